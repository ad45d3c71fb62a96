"""The programs of docs/theory.md run as they stand there."""

import re
from pathlib import Path

import pytest

PAGE = (Path(__file__).parents[2] / "docs" / "theory.md").read_text(encoding="utf-8")
PROGRAMS = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)


@pytest.mark.parametrize("program", PROGRAMS, ids=range(len(PROGRAMS)))
def test_program_runs_and_prints(program, capsys):
    exec(compile(program, "theory.md", "exec"), {})
    if "print(" in program:
        assert capsys.readouterr().out.strip()


def test_the_page_has_programs():
    assert len(PROGRAMS) >= 2
