"""Make an environment of the oldest versions that setup.py allows, or see that it is there already.

    python tools/oldest.py .venv-oldest [python3.10]

Run by ``make test-oldest``. Every requirement is taken at its lower bound exactly; setup.py is the
one place where these are written down. ROS is left out: what the node's tests need besides is the
same in both environments. The package itself is not installed, tests run it from the tree.
"""

from __future__ import annotations

import ast
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path

from environment import LOG, ROOT, STAMP

# the oldest numba knows no later one
PYTHONS = ("3.10", "3.11")
# tools that no test imports
NOT_NEEDED = ("colcon-common-extensions", "setuptools", "ruff", "mypy", "types-PyYAML")
EXTRAS = ("batch", "derive", "test")
SMALLEST = re.compile(r"([\w-]+)(?:\[\w+\])?>=([\d.]+),<[\d.]+")


def lower_bounds() -> dict[str, str]:
    """Return name → oldest version allowed of everything that tests without ROS need."""
    found = {}
    for node in ast.parse((ROOT / "setup.py").read_text()).body:
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
            found[node.targets[0].id] = node.value
    requirements = list(ast.literal_eval(found["REQUIRES"]))
    for extra, more in ast.literal_eval(found["EXTRAS"]).items():
        requirements += more if extra in EXTRAS else []
    bounds = {}
    for requirement in requirements:
        name, version = SMALLEST.fullmatch(requirement).groups()
        if name not in NOT_NEEDED:
            bounds[name] = version
    return bounds


def version_of(python: str) -> str:
    """Return ``major.minor`` of an interpreter, nothing if it does not start."""
    code = "import sys; print('%d.%d' % sys.version_info[:2])"
    try:
        return subprocess.run([python, "-c", code], capture_output=True, text=True).stdout.strip()
    except OSError:
        return ""


def make(venv: Path, pythons: list[str]) -> None:
    """Bring ``venv`` to the lower bounds."""
    wanted = "\n".join(f"{name}=={version}" for name, version in lower_bounds().items()) + "\n"
    stamp = venv / STAMP
    if stamp.is_file() and stamp.read_text() == wanted:
        return
    python = next((python for python in pythons if version_of(python) in PYTHONS), None)
    if python is None:
        sys.exit(f"the oldest versions need Python {' or '.join(PYTHONS)}: make test-oldest OLD=…")
    if venv.exists():
        if not (venv / "pyvenv.cfg").is_file():
            sys.exit(f"{venv} exists and is not a virtual environment: move it away.")
        shutil.rmtree(venv)
    begin = time.monotonic()
    print(f"making {venv} with {python} (details: {venv / LOG})", flush=True)
    subprocess.run([python, "-m", "venv", str(venv)], check=True)
    (venv / "constraints.txt").write_text(wanted)
    pip = [str(venv / "bin" / "python"), "-m", "pip", "install", "--no-input"]
    with (venv / LOG).open("w") as log:
        done = subprocess.run(
            [*pip, "--disable-pip-version-check", "-r", str(venv / "constraints.txt")],
            stdout=log,
            stderr=subprocess.STDOUT,
        )
    if done.returncode:
        last = "\n  ".join((venv / LOG).read_text().splitlines()[-12:])
        sys.exit(f"pip ended with exit code {done.returncode}; it said last:\n  {last}")
    stamp.write_text(wanted)
    print(f"environment ready after {time.monotonic() - begin:.0f} s", flush=True)


if __name__ == "__main__":
    named = sys.argv[2:] or ["python3.10", "python3.11", sys.executable]
    make(Path(sys.argv[1]), named)
