"""The contract's benchmark judges what it says: error against a reference, of a run as chosen."""

import pytest

from benchmarks.cases import CASES
from benchmarks.contract import entry_of, scene_of
from benchmarks.programs.ours import drive_of


@pytest.mark.parametrize("case", ["tendon_step", "planar_pcs"])
def test_an_entry_is_within_its_tolerance_with_an_estimate_near_its_error(case):
    entry = entry_of(CASES[case], 1e-2)
    assert entry["outcome"] == "completed"
    assert entry["error_rel"] <= entry["tolerance"]
    assert 0.1 < entry["estimate_rel"] / entry["error_rel"] < 10.0


@pytest.mark.parametrize("name", CASES)
def test_every_case_leaves_everything_free_and_ends_on_its_outputs(name):
    case = CASES[name]
    scene = scene_of(case, 1e-3)
    assert scene.numerics.free.time and scene.numerics.free.order
    drive = drive_of(case, round(scene.numerics.step * 1e9))
    assert drive.last * scene.numerics.step == pytest.approx(case.duration, rel=1e-9)
    assert drive.last == case.outputs * drive.every
