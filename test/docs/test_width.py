"""Pages are no wider than 100 columns, but for tables and lines that are one link."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGES = sorted([*ROOT.glob("*.md"), *ROOT.glob("*.rst"), *ROOT.glob("docs/**/*.md")])
ONE_LINK = re.compile(r"\s*(?:[*-] )?\S*(?:\[[^\]]*\]\(\S+\)|https?://\S+)\S*$")


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_lines_have_100_columns(page):
    lines = page.read_text(encoding="utf-8").splitlines()
    wide = [
        f"line {number}: {line}"
        for number, line in enumerate(lines, 1)
        if len(line) > 100 and not line.lstrip().startswith("|") and not ONE_LINK.match(line)
    ]
    assert not wide, "\n".join(wide)


def test_all_pages_are_looked_at():
    assert {"README.md", "CHANGELOG.rst", "theory.md"} <= {page.name for page in PAGES}
