"""The programs of docs/actuators.md run, and print what their words say."""

import re
from pathlib import Path

PAGE = (Path(__file__).parents[2] / "docs" / "actuators.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)


def test_the_programs_of_the_page_run(capsys):
    names: dict = {}
    for block in BLOCKS:
        exec(block, names)
    assert len(BLOCKS) == 4 and "N near the winch" in capsys.readouterr().out
    along = names["along"]
    assert (along > 0.0).all() and along[-1] < 0.99 * along[0]
    # what was commanded and what the arm took in differ by the stretch of the tendon
    names["arm"].advance(2000)
    y, _, tension = names["arm"].ports()
    rest = names["arm"].model.tendon_rest[0]
    assert abs(0.03 - y[0] - tension[0] * rest / 2e4) < 1e-5
    assert (names["volume"][[0, 3, 4, 5]] > 0.0).all()
