"""A few rows of SoRoSim's bank: what is ours of the difference, and what is theirs."""

import dataclasses

import numpy as np
import pytest


@pytest.fixture(scope="module")
def shapes(module, data):
    return module("bank").shapes(data)


def test_shapes_are_those_of_the_boundary_value_problem_and_near_sorosims(module, shapes):
    sorosim = module("sorosim")
    assert [shape.name for shape in shapes] == ["s001", "s002", "s251"]
    assert sorosim.apart(sorosim.ours(shapes[0]), sorosim.exact(shapes[0])) < 2e-6
    for shape in shapes:
        assert sorosim.apart(sorosim.ours(shape), shape.positions) < 1e-3


def test_the_difference_to_sorosim_is_within_the_digits_of_its_loads(module, shapes):
    sorosim, bank = module("sorosim"), module("bank")
    shape = shapes[0]
    before = sorosim.apart(sorosim.ours(shape), shape.positions)
    after, nearest = sorosim.within_digits(shape)
    assert after < 2.2e-4 < before  # what four decimals of a position leave, along three axes
    for name in ("gravity", "wrenches"):
        moved = np.abs(getattr(nearest, name) - getattr(shape, name))
        assert moved.max() <= bank.DIGIT * (1 + 1e-9)


def test_loads_of_the_wrong_sign_are_far_from_sorosims_shape(module, shapes):
    sorosim, shape = module("sorosim"), shapes[0]
    for changed in (
        dataclasses.replace(shape, gravity=-shape.gravity),
        dataclasses.replace(shape, wrenches=shape.wrenches * [1, 1, 1, -1, -1, -1]),
        dataclasses.replace(shape, wrenches=shape.wrenches[::-1]),
    ):
        assert sorosim.apart(sorosim.ours(changed), shape.positions) > 0.01


def test_a_release_moves_as_sorosims_does(module, data):
    sorosim = module("sorosim")
    (release,) = module("bank").releases(data)
    assert release.times[-1] == 0.25
    mid, tip = sorosim.motion(release)
    assert np.linalg.norm(tip[-1] - tip[0]) > 0.1
    assert sorosim.apart(tip, release.tip) < 1.5e-3
    assert sorosim.apart(mid, release.mid) < 1e-3
    sheared = sorosim.motion(release, strains=sorosim.STRAINS + sorosim.SHEARS)[1]
    assert sorosim.apart(sheared, release.tip) > sorosim.apart(tip, release.tip)
    stiff = dataclasses.replace(release, damping=2 * release.damping)
    assert sorosim.apart(sorosim.motion(stiff)[1], release.tip) > 2e-2


def test_what_is_no_bank_is_refused_with_what_was_expected(module, tmp_path):
    bank = module("bank")
    for read in (bank.shapes, bank.releases):
        with pytest.raises(bank.BankError, match="opencr-mujoco"):
            read(tmp_path)
