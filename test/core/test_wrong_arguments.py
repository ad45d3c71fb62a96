"""Whatever goes into kernels is checked for type, size and range; nothing loses its meaning."""

import inspect
from fractions import Fraction

import numpy as np
import pytest
from scenes import rod_document, scene_of

from soft_sim_ros.core.algebra import se3
from soft_sim_ros.core.analysis.discrete_gradient import DiscreteGradient
from soft_sim_ros.core.analysis.port_hamiltonian import PortHamiltonian
from soft_sim_ros.core.compile.overflow import LATEST
from soft_sim_ros.core.mechanics.sampler import Sampler
from soft_sim_ros.core.settled import Dynamics, Simulation
from soft_sim_ros.core.simulation.inputs import Inputs
from soft_sim_ros.errors import BadArgument, CommandError, SceneError

ACTUATORS = 2


def document():
    out = rod_document(
        strains=["bend_y", "bend_z"], order=1, gravity=(0, 0, -1.0), material={"viscosity": 300.0}
    )
    out["actuators"] = [
        {"tendon": "a", "rod": "rod", "offset": [0.02, 0.0]},
        {"tendon": "b", "rod": "rod", "offset": [0.0, 0.02]},
    ]
    return out


@pytest.fixture(scope="module")
def arm():
    return Simulation(scene_of(document()))


def hidden(values):
    return np.ma.masked_array(values, mask=[True] + [False] * (len(values) - 1))


# what is made of a right vector → why it is wrong
WRONG = {
    "an imaginary part": lambda x: np.array(x) + 1j,
    "a complex type": lambda x: np.array(x, dtype=complex),
    "a complex number in a list": lambda x: [*x[:-1], 1j],
    "one too many": lambda x: np.append(x, 0.0),
    "one too few": lambda x: x[:-1],
    "a row": lambda x: np.array(x)[None],
    "texts": lambda x: [str(v) for v in x],
    "truth values": lambda x: np.array(x) > 0.0,
    "times": lambda x: np.array(x).astype("m8[s]"),
    "objects": lambda x: [object() for _ in x],
    "None in it": lambda x: [None, *x[1:]],
    "rows of different lengths": lambda x: [[0.0], *x[1:]],
    "a hidden entry": hidden,
    "a whole number beyond doubles": lambda x: [10**400, *x[1:]],
    "a text": lambda x: "abc",
    "a mapping": lambda x: {},
}
NOT_FINITE = {"nan": np.nan, "inf": np.inf, "-inf": -np.inf}
# … and the same numbers, otherwise written
SAME = {
    "a list": list,
    "a tuple": tuple,
    "strided": lambda x: np.repeat(x, 2)[::2],
    "read-only": lambda x: np.broadcast_to(x, np.shape(x)),
    "big-endian": lambda x: np.array(x, dtype=">f8"),
    "a column of a table": lambda x: np.array([x, x], order="F").T[:, 0],
    "fractions": lambda x: [Fraction(v) for v in x],
    "objects": lambda x: np.array(x, dtype=object),
    "masked, nothing hidden": np.ma.masked_array,
    "long doubles": lambda x: np.array(x, dtype=np.longdouble),
}


def right(name, method, n):
    """Return a right value of a parameter by its name: vectors as arrays."""
    rng = np.random.default_rng(sum(map(ord, name)))
    sizes = {"efforts": ACTUATORS, "tip": 6, "wrench": 6, "alpha": 3}
    sizes |= dict.fromkeys(("q", "v", "a", "p", "tau", "values", "besides"), n)
    if name in sizes:
        return rng.uniform(0.1, 0.3, sizes[name])
    others = {"time": 0.1, "share": 0.7, "tip_follows": True, "actuator": 1, "name": "q"}
    others |= {"live": None}
    return others[name]  # a new parameter has to be made known here


def calls_of(kind):
    """Give (name, parameters) of all public methods of a class that take something."""
    for name, method in inspect.getmembers(kind, inspect.isfunction):
        parameters = list(inspect.signature(method).parameters)[1:]
        if not name.startswith("_") and parameters:
            yield name, parameters


PURE = [
    (kind, name, tuple(parameters))
    for kind in (Dynamics, PortHamiltonian)
    for name, parameters in calls_of(kind)
    if name != "carry"  # it takes no numbers
]


def call(owner, name, given):
    """Call a method by the names of its parameters; ``data`` is made for it."""
    method = getattr(owner, name)
    given = dict(given)
    if "data" in inspect.signature(method).parameters:
        given["data"] = owner.forcing()
    return method(**given)


def numbers_of(result):
    """Return all numbers of a result in one array."""
    if isinstance(result, dict):
        result = list(result.values())
    if isinstance(result, (tuple, list)):
        parts = [numbers_of(part) for part in result if not isinstance(part, str)]
        return np.concatenate(parts) if parts else np.zeros(0)
    return np.asarray(result, dtype=float).ravel()


@pytest.mark.parametrize(("kind", "name", "parameters"), PURE, ids=lambda x: str(x))
def test_functions_of_the_state_refuse_what_is_no_vector_and_take_all_that_is(
    arm, kind, name, parameters
):
    owner = arm.dynamics if kind is Dynamics else PortHamiltonian(arm.dynamics)
    given = {p: right(p, name, owner.n) for p in parameters if p != "data"}
    expected = numbers_of(call(owner, name, given)).copy()
    for parameter in (p for p, value in given.items() if isinstance(value, np.ndarray)):
        for why, spoil in WRONG.items():
            with pytest.raises(BadArgument):
                call(owner, name, given | {parameter: spoil(given[parameter])})
                pytest.fail(f"{name}: {parameter} with {why}")
        for why, written in SAME.items():
            result = numbers_of(call(owner, name, given | {parameter: written(given[parameter])}))
            np.testing.assert_array_equal(result, expected, err_msg=f"{parameter}: {why}")
    for parameter in {"time", "share"} & set(parameters):
        for wrong in ("a", None, 1j, [0.0], np.nan, np.inf, True):
            with pytest.raises(BadArgument, match=parameter):
                call(owner, name, given | {parameter: wrong})


def test_numbers_are_made_doubles_before_anything_is_computed_with_them(arm):
    """Fractions multiply exactly, long doubles nearly so: sums would round elsewhere."""
    owner, rng = PortHamiltonian(arm.dynamics), np.random.default_rng(4)
    q = rng.uniform(0.1, 0.3, owner.n)
    for p in rng.uniform(-1.0, 1.0, (40, owner.n)):
        expected = owner.hamiltonian(q, p)
        for why in ("fractions", "long doubles", "objects"):
            assert owner.hamiltonian(q, SAME[why](p)) == expected, why


def test_scratch_of_another_arm_is_refused(arm):
    other = Dynamics(arm.compiled)
    zero = np.zeros(other.n)
    with pytest.raises(BadArgument, match="data must be what"):
        arm.dynamics.residual(zero, zero, zero, other.forcing())


@pytest.mark.parametrize("actuator", [-1, ACTUATORS, 0.0, "a", None, True])
def test_an_actuator_is_counted_from_zero(arm, actuator):
    zero = np.zeros(arm.n_coordinates)
    with pytest.raises(BadArgument, match=r"actuator must be a whole number in \[0, 1\]"):
        arm.dynamics.tensions(zero, zero, np.zeros(ACTUATORS), actuator)


COMMANDS = {
    "set_state": (("q", 4), ("v", 4)),
    "set_efforts": (("efforts", ACTUATORS),),
    "set_tip_wrench": (("wrench", 6),),
}


@pytest.mark.parametrize("name", COMMANDS)
def test_commands_refuse_what_is_no_finite_vector_and_change_nothing_then(arm, name):
    given = {p: 0.01 * np.arange(1.0, size + 1.0) for p, size in COMMANDS[name]}
    assert arm.n_coordinates == 4
    before = arm.q.tobytes(), arm.ledger().tobytes(), arm.ports()[2].tobytes()
    for parameter, size in COMMANDS[name]:
        wrong = {why: spoil(given[parameter]) for why, spoil in WRONG.items()}
        wrong |= {why: np.append(np.zeros(size - 1), x) for why, x in NOT_FINITE.items()}
        for why, value in wrong.items():
            with pytest.raises(BadArgument, match=parameter):
                getattr(arm, name)(**(given | {parameter: value}))
                pytest.fail(f"{parameter} with {why}")
    assert before == (arm.q.tobytes(), arm.ledger().tobytes(), arm.ports()[2].tobytes())
    states = []
    for written in SAME.values():
        arm.reset()
        getattr(arm, name)(**{p: written(value) for p, value in given.items()})
        arm.advance(1)
        states.append(arm.q.tobytes())
    assert len(set(states)) == 1


WHOLE = [5.0, 1.5, np.nan, np.inf, "a", None, -1, 2**63, 10**30, 1j, [1], True, np.float64(3.0),
         np.bool_(True), np.array([1, 2])]  # fmt: skip


@pytest.mark.parametrize("steps", WHOLE, ids=repr)
def test_steps_are_a_whole_number_that_time_can_hold(arm, steps):
    before, index = arm.q.tobytes(), arm.step_index
    for advance in (arm.advance, Inputs(arm, 0.0, 0.0).advance):
        with pytest.raises(BadArgument, match="steps must be a whole number"):
            advance(steps)
    with pytest.raises(BadArgument, match="step_index must be a whole number"):
        arm.step_index = steps
    assert (arm.q.tobytes(), arm.step_index) == (before, index)


def test_whole_numbers_of_any_type_are_steps(arm):
    begin = arm.step_index
    for steps in (2, np.int32(2), np.uint8(2), np.array(2)):
        arm.advance(steps)
        Inputs(arm, 0.0, 0.0).advance(steps)
    arm.advance(0)
    assert arm.step_index == begin + 16


def test_time_ends_where_64_bits_of_nanoseconds_end():
    simulation = Simulation(scene_of(document()))
    last = LATEST // simulation.step_ns
    simulation.step_index = last - 2
    simulation.advance(2)
    assert 0 < simulation.time_ns <= LATEST and np.isfinite(simulation.q).all()
    with pytest.raises(BadArgument, match=r"steps must be a whole number in \[0, 0\]"):
        simulation.advance(1)
    assert simulation.step_index == last


@pytest.mark.parametrize("poses", [0, *WHOLE], ids=repr)
def test_poses_are_a_whole_number(arm, poses):
    with pytest.raises(BadArgument, match="poses must be a whole number"):
        arm.sampler(poses)


@pytest.mark.parametrize(
    "s", [[-0.1], [0.7], [np.nan], [0.1 + 1j], 0.3, [[0.1]], "a", ["0.1"], [None], [True]], ids=repr
)
def test_frames_are_at_arc_lengths_of_the_arm(arm, s):
    with pytest.raises(BadArgument, match="s must be"):
        Sampler(arm.compiled, arm.q, s)


def test_a_sampler_looks_at_contiguous_doubles(arm):
    for q in (np.zeros(4, dtype=int), np.zeros(4, dtype=">f8"), np.zeros(8)[::2], [0.0] * 4,
              np.zeros(4, dtype=complex), np.zeros(5), np.zeros((2, 2))):  # fmt: skip
        with pytest.raises(BadArgument, match="q must be"):
            Sampler(arm.compiled, q, np.array([0.1]))


@pytest.mark.parametrize("function", [se3.exp, se3.right_tangent, se3.left_tangent])
@pytest.mark.parametrize("why", WRONG)
def test_a_twist_is_six_real_numbers(function, why):
    with pytest.raises(BadArgument, match="x must be 6 numbers"):
        function(WRONG[why](np.full(6, 0.1)))


@pytest.mark.parametrize("why", WRONG)
def test_orders_are_checked_before_they_reach_the_arm(arm, why):
    inputs = Inputs(arm, 0.0, 0.0)
    efforts, wrench = WRONG[why](np.array([1.0, 2.0])), WRONG[why](np.full(6, 0.1))
    for order in (
        lambda: inputs.command(efforts),
        lambda: inputs.joint_command(["a", "b"], efforts),
        lambda: inputs.wrench(wrench),
    ):
        with pytest.raises(CommandError):
            order()


@pytest.mark.parametrize("value", [-1.0, np.nan, np.inf, "a", None, 1j, [1.0], True], ids=repr)
def test_timeout_and_ramp_are_times(arm, value):
    for times in ((value, 0.0), (0.0, value)):
        with pytest.raises(BadArgument, match="must be a time in s: expected a finite number"):
            Inputs(arm, *times)


def test_a_timeout_beyond_all_time_is_none(arm):
    arm.reset()
    inputs = Inputs(arm, 1e300, 1e300)
    inputs.command([1.0, 2.0])
    inputs.advance(5)
    np.testing.assert_array_equal(arm.ports()[2], [1.0, 2.0])


@pytest.mark.parametrize("h", [0.0, np.nan, np.inf, "a", None, 1j, [0.1], True], ids=repr)
def test_a_step_of_a_discrete_gradient_is_a_time(arm, h):
    with pytest.raises(BadArgument, match="h must be"):
        DiscreteGradient(PortHamiltonian(arm.dynamics)).step(h)


@pytest.mark.parametrize("step", [0.0, -1.0, 1e-10, np.nan, np.inf, 1e10, 1e300])
def test_a_step_made_by_hand_is_checked_as_one_that_is_read(step):
    from dataclasses import replace

    scene = scene_of(document())
    with pytest.raises(SceneError, match=r"numerics.step"):
        Simulation(replace(scene, numerics=replace(scene.numerics, step=step)))
