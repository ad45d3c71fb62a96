"""Branches cost no more than rods in a row. The limits leave room for a busy machine."""

import pytest

from benchmarks.forest import branches_cost, comb, hand, two_arms_cost


@pytest.mark.parametrize("shape", [comb, hand])
def test_rods_on_branches_cost_what_as_many_in_a_row_cost(shape):
    assert branches_cost(64, shape, rounds=15) < 1.25


def test_two_arms_in_one_scene_cost_two_arms():
    assert two_arms_cost(32, rounds=15) < 1.2
