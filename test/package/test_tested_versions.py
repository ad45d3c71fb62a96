"""The file of tested versions is complete, and agrees with what the package declares to need."""

import re
import runpy
from importlib.metadata import PackageNotFoundError, version
from itertools import chain
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).resolve().parents[2]
TEXT = (ROOT / "requirements" / "tested.txt").read_text()
LOCKED = dict(re.findall(r"^([a-z0-9-]+)==(\S+)$", TEXT, re.MULTILINE))
DECLARED = runpy.run_path(str(Path(__file__).with_name("test_metadata.py")))["literals"]()
# tools of the site stand in an environment of their own
OTHERS = chain.from_iterable(
    names for extra, names in DECLARED["EXTRAS"].items() if extra != "docs"
)
REQUIREMENTS = sorted({*DECLARED["REQUIRES"], *OTHERS})


def test_every_line_names_one_version():
    lines = [line for line in TEXT.splitlines() if not line.startswith("#")]
    assert len(lines) == len(LOCKED) > 30
    assert list(LOCKED) == sorted(LOCKED)
    assert re.search(r"^# Python 3\.1[0-3]\.\d+, Linux x86_64\.$", TEXT, re.MULTILINE)
    assert "tools/tested.py" in TEXT


@pytest.mark.parametrize("text", REQUIREMENTS)
def test_what_is_declared_was_tested_within_its_bounds(text):
    requirement = Requirement(text)
    assert LOCKED[canonicalize_name(requirement.name)] in requirement.specifier


@pytest.mark.parametrize("text", REQUIREMENTS)
def test_what_is_installed_is_within_the_declared_bounds(text):
    requirement = Requirement(text)
    try:
        found = version(requirement.name)
    except PackageNotFoundError:
        pytest.skip("not installed here")
    assert found in requirement.specifier
