"""A re-simulation gives the same bits, and says so only when it is true."""

import json
from functools import partial

import numpy as np
import pytest

from soft_sim_ros import read_run
from soft_sim_ros.errors import RecordingError
from soft_sim_ros.experiments import resimulation as module
from soft_sim_ros.experiments.resimulation import Rerun
from soft_sim_ros.recording.cdr import encode_floats, encode_string
from soft_sim_ros.recording.decode import decode
from soft_sim_ros.recording.reader import LoggedMessage
from soft_sim_ros.recording.telemetry import Telemetry
from soft_sim_ros.recording.topics import FLOATS, STRING, Qos, recorded_topics
from soft_sim_ros.recording.writer import BagWriter


def rewrite(recording, directory, change=lambda message: message.data, scene=None, **facts):
    """Copy a recording; ``change`` gives the bytes of a message, None to leave it out."""
    run = read_run(recording)
    attachments = {k: v for k, v in run.attachments.items() if k != "machine.json"}
    if scene is not None:
        attachments["scene.yaml"] = scene
    keys = {topic.name: topic.key for topic in recorded_topics("/soft_arm")}
    with BagWriter(
        directory,
        recorded_topics("/soft_arm"),
        metadata=run.metadata | facts,
        attachments=attachments,
    ) as writer:
        for message in run.messages():
            data = change(message)
            if data is not None:
                writer.write(keys[message.topic], message.time_ns, data)
    return directory


def test_the_recording_is_reproduced_to_the_bit(recording, call, capsys):
    assert call("rerun", recording) == 0
    assert "identical: 205 messages, 0 bits different" in capsys.readouterr().out


@pytest.mark.parametrize("topic", ["backbone", "strain_state", "energy", "tip_pose"])
def test_one_bit_is_noticed(recording, call, capsys, tmp_path, topic):
    def flip(message):
        if message.topic.endswith(topic) and message.time_ns == 250_000_000:
            return message.data[:-8] + bytes([message.data[-8] ^ 1]) + message.data[-7:]
        return message.data

    changed = rewrite(recording, tmp_path / "changed", flip)
    assert call("rerun", changed) == 1
    assert f"the first at t = 0.25 s on /soft_arm/{topic}" in capsys.readouterr().out


def test_a_command_too_few_is_noticed(recording, call, tmp_path):
    def drop(message):
        lost = message.topic.endswith("/command") and message.time_ns == 146_000_000
        return None if lost else message.data

    changed = rewrite(recording, tmp_path / "changed", drop)
    comparison = Rerun(read_run(changed)).compare()
    assert comparison.first == (0.15, "/soft_arm/backbone")
    assert comparison.difference > 1e-3


def test_another_scene_is_noticed(recording, call, scene, tmp_path):
    softer = scene.read_text().replace("1.0e+6", "0.9e+6").encode()
    assert call("rerun", rewrite(recording, tmp_path / "changed", scene=softer)) == 1


def test_a_command_timeout_acts_again(recording, call, tmp_path):
    changed = rewrite(recording, tmp_path / "out", command_timeout="0.06", command_ramp="0.02")
    comparison = Rerun(read_run(changed)).compare()
    # the command of 0.2 s is held up to 0.26 s, after which the recording and the timeout part
    assert comparison.first == (0.27, "/soft_arm/backbone")


def test_a_reset_acts_again(recording, tmp_path):
    times = read_run(recording).strain_state.time_ns

    def with_reset(directory):
        run = read_run(recording)
        rerun = Rerun(run)
        topics = recorded_topics("/soft_arm")
        keys = {topic.name: topic.key for topic in topics}
        source = {"scene.yaml": run.attachments["scene.yaml"]}
        with BagWriter(directory, topics, metadata=run.metadata, attachments=source) as writer:
            for time_ns in times.tolist():
                rerun._inputs.advance(
                    (time_ns - rerun.simulation.time_ns) // rerun.simulation.step_ns
                )
                if time_ns == 100_000_000:
                    writer.write("command", time_ns, encode_floats([0.1, 0.0]))
                    rerun._inputs.command([0.1, 0.0])
                if time_ns == 200_000_000:
                    writer.write("events", time_ns, encode_string("reset"))
                    rerun._inputs.reset()
                for name, build in rerun._builders.items():
                    writer.write(keys[name], time_ns, build())
        return directory

    run = read_run(with_reset(tmp_path / "reset"))
    assert Rerun(run).compare().identical
    at = times.tolist().index(200_000_000)
    np.testing.assert_array_equal(run.strain_state.position[at], run.strain_state.position[0])


def test_differences_of_machines_are_named_and_tolerated_as_asked(
    recording, call, capsys, monkeypatch, tmp_path
):
    def jitter(message):
        if not message.topic.endswith("tip_pose"):
            return message.data
        return message.data[:-8] + bytes([message.data[-8] ^ 1]) + message.data[-7:]

    changed = rewrite(recording, tmp_path / "changed", jitter)
    here = module.machine_facts()
    monkeypatch.setattr(module, "machine_facts", lambda: here | {"numba": "99.0"})
    assert call("rerun", changed) == 0
    told = capsys.readouterr().out
    assert f"differs: numba: recorded with {here['numba']}, here 99.0" in told
    assert "within the tolerance 1e-06" in told
    assert call("rerun", changed, "--tolerance", "1e-30") == 1


@pytest.mark.parametrize("fact", ["node", "poses", "command_timeout"])
def test_a_recording_without_its_facts_is_refused(recording, call, capsys, tmp_path, fact):
    run = read_run(recording)
    facts = {key: value for key, value in run.metadata.items() if key != fact}
    topics = recorded_topics("/soft_arm")
    with BagWriter(tmp_path / "bare", topics, metadata=facts, attachments={}) as writer:
        writer.write("events", 0, encode_string("reset"))
    assert call("rerun", tmp_path / "bare") == 2
    assert fact in capsys.readouterr().err


def test_machine_facts_are_in_the_recording(recording):
    facts = json.loads(read_run(recording).attachments["machine.json"])
    assert set(module.DECISIVE) <= set(facts)


@pytest.mark.parametrize("poses", ["many", "1000000000", "nan"])
def test_a_fact_that_is_none_is_bad_input(recording, call, capsys, tmp_path, poses):
    assert call("rerun", rewrite(recording, tmp_path / "odd", poses=poses)) == 2
    assert f"says poses = '{poses}': expected a whole number" in capsys.readouterr().err


def test_what_is_no_number_is_within_no_tolerance(recording, call, capsys, monkeypatch, tmp_path):
    def spoil(message):
        nan = np.array([np.nan]).tobytes()
        return message.data[:-8] + nan if message.topic.endswith("tip_pose") else message.data

    changed = rewrite(recording, tmp_path / "changed", spoil)
    here = module.machine_facts()
    monkeypatch.setattr(module, "machine_facts", lambda: here | {"numba": "99.0"})
    assert call("rerun", changed) == 1
    assert "inf  largest difference on /soft_arm/tip_pose" in capsys.readouterr().out


def test_a_recording_with_the_energies_names_in_one_label_is_read_and_compared(
    scene, call, tmp_path, monkeypatch, capsys
):
    """As recordings of old have them."""
    monkeypatch.setattr("soft_sim_ros.batch.rollout.Telemetry", partial(Telemetry, one_label=True))
    old = tmp_path / "old"
    assert call("rollout", scene, "--duration", 0.1, "--out", old) == 0
    monkeypatch.undo()
    new = tmp_path / "new"
    assert call("rollout", scene, "--duration", 0.1, "--out", new) == 0
    one, other = read_run(old), read_run(new)
    data = [next(m.data for m in run.messages() if "energy" in m.topic) for run in (one, other)]
    assert len(decode(FLOATS, data[0]).labels) == 1 < len(decode(FLOATS, data[1]).labels)
    assert one.energy.names == other.energy.names
    assert np.array_equal(one.energy["kinetic"], other.energy["kinetic"])
    assert call("rerun", old) == 0 and call("rerun", new) == 0


def test_a_time_offset_that_is_none_is_refused_with_its_place(recording):
    run = read_run(recording)
    broken = LoggedMessage(
        0, "/soft_arm/events", STRING, Qos(), encode_string("time_offset: soon ns")
    )
    run.messages = lambda: iter([broken])
    with pytest.raises(RecordingError, match=r"time_offset: soon ns.*expected a whole number"):
        list(Rerun(run).states())
