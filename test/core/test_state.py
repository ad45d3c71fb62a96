"""The state of a simulation is a value that decides how it goes on, and nothing else does."""

import contextlib
import copy
import pickle
from dataclasses import FrozenInstanceError, fields, replace

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from scenes import rod_document, scene_of

from soft_sim_ros import Simulation, SimulationState, compile_scene, initial_state, settle
from soft_sim_ros.core.integrators.problem import Held, State, Work
from soft_sim_ros.core.simulation.memory import ARRAYS, NO_FACTOR, SCRATCH
from soft_sim_ros.core.simulation.value import Value
from soft_sim_ros.errors import BadArgument, Diverged, OtherModel, StateError, UnfitFile
from soft_sim_ros.scene import load_scene

INTEGRATORS = {
    "sdirk2": {},
    "sdirk4": {},
    "generalized_alpha": {"rho": 0.7},
    "energy_midpoint": {},
    "adaptive": {"error": 1e-5},
}


def document(integrator="sdirk2", **changes):
    """Return an arm with everything that has a memory: branches, friction, a winch, schedules."""
    arm = rod_document(
        strains=["bend_y", "bend_z"],
        order=2,
        gravity=(1.0, 2.0, -9.0),
        material={"viscosity": 300.0, "maxwell": {"ratio": 0.5, "time": 0.05}},
        numerics={
            "basis": {"order": 2},
            "integrator": integrator,
            "options": INTEGRATORS[integrator],
        },
    )
    tendon = {"rod": "rod", "limits": [0.0, 3.0]}
    arm["actuators"] = [
        tendon | {"tendon": "rough", "offset": [0.0, 0.02], "friction": 0.3},
        tendon | {"tendon": "winch", "offset": [0.02, 0.0], "limits": [-0.01, 0.01],
                  "control": "length", "axial_stiffness": 2e3},
    ]  # fmt: skip
    arm["loads"] = [
        {"point": "knock", "body": "rod", "s": 0.3, "force": [0.0, 0.3, 0.2],
         "schedule": {"start": 0.0213, "end": 0.0377}},
    ]  # fmt: skip
    return arm | changes


@pytest.fixture(scope="module")
def arms():
    """Pairs of simulations by their integrator, made when they are first asked for."""
    made = {}

    def pair(integrator):
        if integrator not in made:
            model = compile_scene(scene_of(document(integrator)))
            made[integrator] = Simulation(model), Simulation(model)
        return made[integrator]

    return pair


@pytest.fixture(scope="module")
def arm(arms):
    one, _ = arms("sdirk2")
    one.reset()
    act(one, [("efforts", 1), ("advance", 7), ("wrench", 2), ("advance", 4)])
    return one


def act(simulation, actions):
    """Do to a simulation what its users may do, refused steps among it."""
    for name, seed in actions:
        rng = np.random.default_rng(seed)
        if name == "advance":
            with contextlib.suppress(Diverged):  # pushed too far before: a refused step, again
                simulation.advance(seed % 9)
        elif name == "efforts":
            low, high = np.array([a.limits for a in simulation.scene.actuators]).T
            simulation.set_efforts(rng.uniform(low, high))
        elif name == "wrench":
            simulation.set_tip_wrench(0.02 * rng.normal(size=6), rng.choice(["world", "tip"]))
        elif name == "push":  # far beyond what the arm can follow
            _, wrench, follows = simulation.held()
            simulation.set_tip_wrench([0.0, 0.0, 0.0, 1e9, 1e9, 1e9])
            with contextlib.suppress(Diverged):
                simulation.advance(2)
            simulation.set_tip_wrench(wrench, "tip" if follows else "world")
        elif name == "look":
            simulation.ledger(), simulation.ports(), simulation.sampler(3).poses()
        elif name == "place":
            simulation.set_state(
                0.1 * rng.normal(size=simulation.n_coordinates) / simulation.model.weight,
                np.zeros(simulation.n_coordinates),
            )
        elif name == "reset":
            simulation.reset()


ACTIONS = st.lists(
    st.tuples(
        st.sampled_from(["advance", "advance", "advance", "efforts", "wrench", "push", "look",
                         "place", "reset"]),
        st.integers(0, 99),
    ),
    max_size=7,
)  # fmt: skip


def bits(simulation):
    """Return everything that can be read off."""
    parts = (simulation.q, simulation.v, simulation.ledger(), *simulation.ports())
    rest = (simulation.time_ns, simulation.time_error, *simulation.statistics())
    return (*(part.tobytes() for part in parts), rest)


@pytest.mark.parametrize("integrator", INTEGRATORS)
@settings(
    phases=[Phase.explicit, Phase.generate],
    max_examples=6,
    deadline=None,
    suppress_health_check=list(HealthCheck),
)
@given(before=ACTIONS, after=ACTIONS, elsewhere=ACTIONS)
def test_a_restored_state_goes_on_with_the_same_bits(arms, integrator, before, after, elsewhere):
    one, other = arms(integrator)
    after = [("advance", 5), *after, ("advance", 8)]
    act(one, before)
    state = one.state()
    now = bits(one)
    act(one, after)
    act(other, elsewhere)
    other.restore(pickle.loads(pickle.dumps(state)))
    assert other.state() == state and bits(other) == now
    act(other, after)
    assert bits(other) == bits(one)
    assert other.state() == one.state()


@pytest.mark.parametrize("name", ["flying_body", "rubber_arm", "floating_frame", "mixed_chain"])
def test_a_restored_state_of_a_packaged_scene_goes_on_with_the_same_bits(name):
    model = compile_scene(settle(load_scene(name)))
    one, other = Simulation(model), Simulation(model)
    act(one, [("wrench", 3), ("advance", 8), ("efforts", 4), ("advance", 5)] if one.n_actuators
        else [("wrench", 3), ("advance", 8)])  # fmt: skip
    act(other, [("wrench", 8), ("advance", 6)])
    state = one.state()
    one.advance(20)
    other.restore(state)
    other.advance(20)
    assert bits(one) == bits(other) and one.state() == other.state()


def test_a_state_is_the_same_however_steps_were_grouped_and_who_looked(arms):
    one, other = arms("sdirk2")
    one.reset()
    other.restore(one.state())
    one.advance(12)
    for _ in range(4):
        other.advance(3)
        act(other, [("look", 0)])
    assert one.state() == other.state()


def leaves(value, of=()):
    for field in fields(value):
        part = getattr(value, field.name)
        path = (*of, field.name)
        yield from leaves(part, path) if isinstance(part, Value) else [(path, part)]


def put(value, path, part):
    """Return a value with another part."""
    name, *rest = path
    return replace(value, **{name: put(getattr(value, name), rest, part) if rest else part})


def other_than(part):
    """Return a part that differs as little as can be."""
    if isinstance(part, np.ndarray):
        if not part.size:
            return np.zeros((*part.shape, 1), part.dtype)
        part = part.copy()
        part.flat[-1] = np.nextafter(part.flat[-1], 9.0) if part.dtype.kind == "f" else 7
        return part
    if isinstance(part, float):
        return np.nextafter(part, 9.0)
    return (*part, "x") if isinstance(part, tuple) else part + type(part)(1) if not isinstance(
        part, str | bool) else (part + "x" if isinstance(part, str) else not part)  # fmt: skip


def test_states_are_equal_where_every_bit_of_every_part_is(arm):
    state = arm.state()
    again = arm.state()
    assert again is not state and again == state and hash(again) == hash(state)
    assert len({state, again}) == 1
    for path, part in leaves(state):
        other = put(state, path, other_than(part))
        assert other != state, path
    assert state != "a state"


def test_a_state_is_its_own_copy_and_a_pickle_is_equal(arm):
    state = arm.state()
    assert copy.copy(state) is state and copy.deepcopy(state) is state
    again = pickle.loads(pickle.dumps(state))
    assert again == state and not again.q.flags.writeable


def test_nothing_in_a_state_can_be_changed(arm):
    state = arm.state()
    kept = {path: part.tobytes() for path, part in leaves(state) if isinstance(part, np.ndarray)}
    for _, part in leaves(state):
        if isinstance(part, np.ndarray):
            with pytest.raises(ValueError, match="read-only"):
                part[...] = 0
            with pytest.raises(ValueError, match="WRITEABLE"):
                part.setflags(write=True)
    with pytest.raises(FrozenInstanceError):
        state.step_index = 3
    arm.advance(3)
    assert kept == {p: x.tobytes() for p, x in leaves(state) if isinstance(x, np.ndarray)}
    given_q = state.q.copy()
    mine = replace(state, q=given_q)
    given_q[:] = 5.0
    assert mine == state
    arm.restore(state)


def test_a_state_tells_what_it_is_of(arm):
    state = arm.state()
    assert (state.scene, state.time_ns, state.step_ns) == ("rod", arm.time_ns, arm.step_ns)
    assert state.time == arm.time
    assert f"state of 'rod' at t = {arm.time:.9g} s" in repr(state)
    np.testing.assert_array_equal(state.q, arm.q)
    np.testing.assert_array_equal(state.efforts, arm.held()[0])


@pytest.mark.parametrize("scene", [*INTEGRATORS, "flying_body", "mixed_chain"])
def test_what_is_called_scratch_decides_nothing(scene):
    made = scene_of(document(scene)) if scene in INTEGRATORS else load_scene(scene)
    model = compile_scene(settle(made))
    one, other = Simulation(model), Simulation(model)
    actions = [("wrench", 2), ("advance", 8), ("advance", 5)]
    for _ in range(3):
        for name in SCRATCH:
            getattr(other._work, name)[...] = np.nan
        for name in NO_FACTOR:
            getattr(other._work.system, name)[...] = np.nan
        act(one, actions)
        act(other, actions)
        assert bits(one) == bits(other) and one.state() == other.state()


def test_every_array_of_a_solver_is_remembered_or_scratch_or_constant():
    others = {"system", "measure", "zero"}
    assert {*ARRAYS.values(), *SCRATCH} | others == {*Work._fields}
    assert len(Work._fields) == len(ARRAYS) + len(SCRATCH) + len(others)
    apart = {"model", "step_index", "q", "v", "dashpots", "solver"}
    held = {"efforts", "wrench", "wrench_follows", "pushes", "pushes_follow", "courses", "attached"}
    booked = {"dissipated", "load_work", "actuator_work", "reference", "ports"}
    booked |= {"bristles", "sensed"}
    closed = {"held", "acts", "multipliers"}
    assert {field.name for field in fields(SimulationState)} == apart | held | booked | closed
    # q and v with dashpots; the account is booked but for what is read off the state
    read_off = {"position", "rate", "acting"}
    assert {*State._fields} - read_off == {"q", "v", "ledger", "account", "settled", "steps"}
    assert {*Held._fields} == {"gravity", "effort", "tip", "follows", "live"}


# Files.


def test_a_state_survives_a_file_to_the_bit(arm, tmp_path):
    state = arm.state()
    one, two = tmp_path / "one.npz", tmp_path / "two.npz"
    state.save(one)
    again = SimulationState.load(one)
    assert again == state
    again.save(two)
    assert one.read_bytes() == two.read_bytes()
    arm.restore(again)
    assert arm.state() == state
    with np.load(one, allow_pickle=False) as arrays:
        np.testing.assert_array_equal(arrays["q"], state.q)


@pytest.fixture(scope="module")
def stored(arm, tmp_path_factory):
    file = tmp_path_factory.mktemp("states") / "state.npz"
    arm.state().save(file)
    with np.load(file) as arrays:
        return dict(arrays)


def test_a_file_with_a_part_missing_or_of_another_kind_is_refused_by_its_name(stored, tmp_path):
    file = tmp_path / "bad.npz"
    for key in stored:
        for changed in (
            {name: part for name, part in stored.items() if name != key},
            stored | {key: np.array([1j])},
            stored | {key: np.zeros((1, 1, 1, 1), dtype="U1" if key == "q" else bool)},
        ):
            np.savez(file, **changed)
            with pytest.raises(StateError) as caught:
                SimulationState.load(file)
            assert (caught.value.where, caught.value.key) == (str(file), key)
            assert str(caught.value).startswith(f"{file}: {key} is ")
    np.savez(file, **stored, more=np.zeros(2))
    with pytest.raises(StateError, match="more is there: expected no such key"):
        SimulationState.load(file)
    np.savez(file, **stored | {"format": np.array("soft_sim_ros state 99")})
    with pytest.raises(StateError, match=r"format is 'soft_sim_ros state 99': expected 'soft_sim_"):
        SimulationState.load(file)


def test_a_file_that_is_none_is_refused(stored, tmp_path):
    file = tmp_path / "bad.npz"
    file.write_bytes(b"no state")
    with pytest.raises(UnfitFile, match=r"bad\.npz"):
        SimulationState.load(file)
    np.savez(file, **stored | {"q": np.array([{}])})
    with pytest.raises(UnfitFile, match=r"bad\.npz"):
        SimulationState.load(file)
    with pytest.raises(FileNotFoundError):
        SimulationState.load(tmp_path / "none.npz")


@pytest.mark.parametrize("integrator", ["sdirk2", "adaptive"])
def test_numbers_that_no_state_holds_are_refused_before_anything_changes(arms, integrator):
    simulation, _ = arms(integrator)
    simulation.reset()
    simulation.advance(12)
    state, now = simulation.state(), bits(simulation)
    for path, part in leaves(state):
        if path[0] == "model":
            continue
        if isinstance(part, np.ndarray):
            wrong = [np.zeros((*part.shape, 1), part.dtype)]
            if part.size and part.dtype.kind == "f":
                bad = part.copy()
                bad.flat[part.size // 2] = np.nan
                wrong.append(bad)
            elif part.size:
                wrong.append(part - 5 - 2**40)
        elif isinstance(part, float):
            wrong = [np.nan, np.inf]
        else:
            wrong = [] if isinstance(part, bool) else [-1, 2**63 - 1]
        for bad in wrong:
            with pytest.raises(StateError, match=rf"^state of 'rod': {'.'.join(path)} is "):
                simulation.restore(put(state, path, bad))
    assert simulation.state() == state and bits(simulation) == now


def test_a_clock_that_would_have_to_catch_up_for_ever_is_refused(arms):
    simulation, _ = arms("adaptive")
    simulation.reset()
    simulation.advance(12)
    state = simulation.state()
    clock = state.solver.clock.copy()
    clock[4] = 1e15  # steps since the last jump of an input, none of which was made
    with pytest.raises(StateError, match=r"solver\.clock"):
        simulation.restore(put(state, ("solver", "clock"), clock))


# Models.


@pytest.mark.parametrize(
    ("change", "difference"),
    [
        ({"gravity": (1.0, 2.0, -9.1)}, "its numbers are others (gravity)"),
        ({"actuators": []}, "it has 2 actuators, not 0"),
        ({"loads": []}, "it has 12 coordinates, not 6"),
    ],
)
def test_a_state_of_another_model_is_refused_by_name(arm, change, difference):
    other = Simulation(scene_of(document(**change) | {"name": "other"}))
    before = bits(other)
    with pytest.raises(OtherModel) as caught:
        other.restore(arm.state())
    expected = "a state of 'rod' does not fit the model of 'other': "
    assert str(caught.value).startswith(expected + difference)
    assert bits(other) == before


def test_a_state_of_other_steps_or_strains_is_refused_by_name(arm, arms):
    slower = document()
    slower["numerics"] |= {"step": 0.003}
    with pytest.raises(OtherModel, match="its step_ns is 3000000, not "):
        arm.restore(Simulation(scene_of(slower)).state())
    with pytest.raises(OtherModel, match="its integrator is 'adaptive', not 'sdirk2'"):
        arm.restore(arms("adaptive")[0].state())
    tighter = document()
    tighter["numerics"] |= {"newton_tolerance": 1e-11}
    with pytest.raises(OtherModel, match=r"its numbers are others \(numerics\[2\]\)"):
        arm.restore(Simulation(scene_of(tighter)).state())
    with pytest.raises(OtherModel, match="it has 24 coordinates, not 12"):
        finer = document()
        finer["numerics"] |= {"basis": {"order": 5}}
        arm.restore(Simulation(scene_of(finer)).state())
    with pytest.raises(BadArgument, match="must be a SimulationState"):
        arm.restore(arm.q)


def test_a_load_that_ends_makes_another_model_than_one_that_does_not(arm):
    endless = document()
    endless["loads"][0]["schedule"] = {"start": 0.0213}
    with pytest.raises(OtherModel, match=r"its numbers are others \(schedule, switches\)"):
        Simulation(scene_of(endless)).restore(arm.state())


def test_a_state_of_the_same_model_is_taken_whatever_its_scene_is_called(arm):
    twin = Simulation(scene_of(document(name="twin")))
    twin.restore(arm.state())
    assert bits(twin) == bits(arm)


def test_a_model_whose_last_bits_differ_is_the_same_model(arm):
    # as on another machine, whose linear algebra rounds otherwise
    compiled = arm.compiled
    rounded = replace(
        compiled, model=compiled.model._replace(stiffness=compiled.model.stiffness * (1 + 1e-15))
    )
    Simulation(rounded, arm.state())
    softer = replace(
        compiled, model=compiled.model._replace(stiffness=compiled.model.stiffness * (1 + 1e-8))
    )
    with pytest.raises(OtherModel, match=r"\(stiffness\)"):
        Simulation(softer, arm.state())


# A simulation of a model and a state.


def test_the_long_form_is_the_short_one_to_the_bit():
    scene = scene_of(document())
    model = compile_scene(settle(scene))
    short, long = Simulation(scene), Simulation(model, initial_state(model))
    assert short.state() == long.state()
    short.advance(10)
    long.advance(10)
    assert bits(short) == bits(long)


def test_a_state_of_given_coordinates_is_that_of_set_state(arm):
    rng = np.random.default_rng(6)
    q, v = 0.05 * rng.normal(size=(2, arm.n_coordinates)) / arm.model.weight
    fresh = Simulation(arm.compiled)
    fresh.set_state(q, v)
    assert initial_state(arm.compiled, q, v) == fresh.state()
    fresh.set_state(q, np.zeros_like(q))
    assert initial_state(arm.compiled, q) == fresh.state()
    with pytest.raises(BadArgument, match=r"^q must be 12 finite numbers"):
        initial_state(arm.compiled, q[1:])
    with pytest.raises(BadArgument, match=r"^v must be left out, or given with q"):
        initial_state(arm.compiled, v=v)


def test_a_simulation_begins_in_its_state_and_goes_back_to_it(arm):
    state = arm.state()
    branch = Simulation(arm.compiled, state)
    assert branch.state() == state
    act(branch, [("efforts", 5), ("advance", 8), ("wrench", 3), ("advance", 3)])
    index, made = branch.step_index, branch.statistics()
    branch.reset()
    assert (branch.step_index, branch.statistics()) == (index, made)  # time goes on
    solver = replace(state.solver, counters=branch.state().solver.counters)
    assert branch.state() == replace(state, step_index=index, solver=solver)


def test_simulations_of_one_model_do_not_move_one_another(arm):
    state = arm.state()
    others = [Simulation(arm.compiled, state) for _ in range(3)]
    for count, other in enumerate(others):
        other.advance(count)
    assert [other.step_index - state.step_index for other in others] == [0, 1, 2]
    assert arm.state() == state == others[0].state()
    assert others[0].model is arm.model
