"""A ~/step that ended by itself is in the recording as it was made, not as it was asked for."""

import re
from pathlib import Path

from peer import simulator
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter

from soft_sim_ros.experiments.resimulation import Rerun
from soft_sim_ros.recording.reader import read_run

SCENE = Path(__file__).with_name("arm.yaml")


def ask_for(peer, count):
    parameter = Parameter("step_count", value=count).to_parameter_msg()
    request = SetParameters.Request(parameters=[parameter])
    (result,) = peer.ask(SetParameters, "soft_arm/set_parameters", request).results
    assert result.successful, result.reason


def test_a_run_with_a_step_that_was_cut_short_is_rerun_to_the_bit(tmp_path, peer):
    program = simulator(tmp_path, scene=SCENE, command_timeout=0, record=tmp_path / "run")
    try:
        assert peer.pause(True).success
        ask_for(peer, 1_000_000)
        cut = peer.trigger("soft_arm/step")
        assert not cut.success
        ask_for(peer, 7)  # no whole number of published instants: what comes after is off its grid
        assert peer.trigger("soft_arm/step").success
        assert peer.pause(False).success
        ask_for(peer, 0)
    finally:
        assert program.end() == 0, program.text
    made = int(re.match(r"(\d+) of 1000000 steps, now at t = ", cut.message)[1])
    run = read_run(tmp_path / "run")
    compared = Rerun(run).compare()
    assert compared.identical, compared
    assert run.strain_state.time_ns[-1] > made * Rerun(run).simulation.step_ns
