"""Pages of reports, taken apart and played in a browser."""

from __future__ import annotations

import base64
import gzip
import re
import shutil
import subprocess
from pathlib import Path

BROWSER = shutil.which("chromium") or shutil.which("chromium-browser")
FLAGS = (
    "--headless --no-sandbox --disable-quic --no-first-run --disable-background-networking "
    "--disable-component-update --disable-sync --use-gl=angle --use-angle=swiftshader "
    "--enable-unsafe-swiftshader --enable-logging=stderr --window-size=900,900 "
    "--virtual-time-budget=3000 --dump-dom"
).split()


def part(page: str, name: str) -> str:
    """Return the text of a script element of the page."""
    found = re.search(rf'<script type="[^"]*" id="{name}">([^<]*)</script>', page)
    assert found is not None
    return found[1]


def unpacked(page: str, name: str) -> bytes:
    """Return the bytes that such an element holds."""
    return gzip.decompress(base64.b64decode(part(page, name)))


def played(page: Path, profile: Path) -> str:
    """Return the document after a browser has played it from a file without any complaint."""
    assert BROWSER is not None
    done = subprocess.run(
        [BROWSER, *FLAGS, f"--user-data-dir={profile}", page.as_uri()],
        capture_output=True,
        text=True,
        timeout=100,
    )
    assert done.returncode == 0, done.stderr
    said = [line for line in done.stderr.splitlines() if "CONSOLE" in line]
    # the software renderer of a machine without graphics complains of reading back
    assert [line for line in said if "GPU stall" not in line] == []
    return done.stdout
