"""The demo asks again when an answer is lost; a start speaks of compiling only while it does."""

from types import SimpleNamespace

import numba

from soft_sim_ros.commands import drive
from soft_sim_ros.core.backend.compilation import compilations
from soft_sim_ros.node import prepare


def driver(monkeypatch, answered):
    """Stand-in of a driver; ``answered`` says which of its calls is answered, if any."""
    now = [100.0]
    monkeypatch.setattr(drive.time, "monotonic", lambda: now[0])
    calls = []

    def call(request):
        assert request.data is False
        calls.append(request)
        done = len(calls) == answered
        return SimpleNamespace(done=lambda: done)

    pause = SimpleNamespace(call_async=call)
    return SimpleNamespace(time=0.0, _calls=[], _due=0.0, _pause=pause), calls, now


def test_the_driver_asks_until_it_is_answered(monkeypatch):
    stub, calls, now = driver(monkeypatch, answered=3)
    for _ in range(100):
        if drive.Driver._going(stub):
            break
        now[0] += 0.1
    assert len(calls) == 3, "not before a second is over, and no more often"


def test_an_arm_that_moves_needs_no_answer(monkeypatch):
    stub, calls, _ = driver(monkeypatch, answered=0)
    assert not drive.Driver._going(stub)
    stub.time = 0.01
    assert drive.Driver._going(stub)
    assert len(calls) == 1


def test_compilations_are_heard_of_while_they_last():
    heard = []

    @numba.njit
    def fresh(x):
        return x + 1

    with compilations(heard.append) as seen:
        assert not seen.going_on()
        fresh(1)
        assert seen.names == heard and "fresh" in heard
        assert seen.going_on(), "since it was asked last"
        assert not seen.going_on()
        fresh(2)
        assert not seen.going_on(), "nothing is compiled twice"
    before = len(heard)
    fresh(1.5)
    assert len(heard) == before


def test_a_start_that_compiles_nothing_does_not_speak_of_compiling(monkeypatch):
    said = []

    class Slow:
        def __init__(self, scene):
            self.dynamics = self.q = None
            inputs = {"input_loads": (), "posed": (), "commanded": {}, "constraints": ()}
            inputs |= {"environment": (), "touches": False}
            self.scene = SimpleNamespace(numerics=None, bodies=(), attachments={}, **inputs)

        def advance(self, steps):
            for _ in range(200):
                if said:
                    return
                prepare.time.sleep(0.01)

    patience = prepare._patience
    monkeypatch.setattr(prepare, "_patience", lambda say, what: patience(say, what, 0.02))
    monkeypatch.setattr(prepare, "Simulation", Slow)
    monkeypatch.setattr(prepare, "Telemetry", lambda *_, **__: SimpleNamespace(builders={}))
    monkeypatch.setattr(prepare, "draft", lambda scene: scene)
    monkeypatch.setattr(prepare, "long_step", lambda *_: None)
    prepare.warm_up(None, SimpleNamespace(poses=2, frame_id="world"), said.append)
    assert said and not any("compiling" in line for line in said)
