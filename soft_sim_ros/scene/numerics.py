"""Numerical settings of a scene. They do not change the physics, and all have defaults."""

from __future__ import annotations

from dataclasses import dataclass, field

from soft_sim_ros.scene.body import Body, Rod
from soft_sim_ros.scene.interval import POSITIVE, Interval
from soft_sim_ros.scene.reader import Reader
from soft_sim_ros.scene.strains import STRAINS

INTEGRATORS = (
    "sdirk2", "sdirk3", "sdirk4", "implicit_midpoint", "generalized_alpha", "energy_midpoint",
    "adaptive",
)  # fmt: skip
# a list: soft_sim_ros.core.bases.register makes more of them known
BASES = ["legendre", "chebyshev", "monomial", "constant", "linear"]
FIXED_ORDER = {"constant": 0, "linear": 1}
DEFAULT_ORDER = dict.fromkeys(STRAINS, 3)
LONGEST_STEP = 1e6  # s: times are counted in 64 bits of nanoseconds
MAX_ORDER = 50
MAX_ELEMENTS = 10000
NODES = Interval(2, 100, True, True)
POSITION, ORIENTATION = Interval.parse("[1e-8, 0.1]"), Interval.parse("[1e-8, 1]")


@dataclass(frozen=True)
class Basis:
    """Trial functions of the strains.

    kind : one of BASES
    order : highest polynomial degree by strain
    elements : equal elements per section
    nodes : Gauss–Lobatto nodes per element; None: chosen from the order
    """

    kind: str = "legendre"
    order: dict[str, int] = field(default_factory=lambda: dict(DEFAULT_ORDER))
    elements: int = 1
    nodes: int | None = None


@dataclass(frozen=True)
class Free:
    """Settings left to the solver, by a tolerance or because the scene names no numerics.

    time : whether the error of the integrator's steps
    order, elements, nodes : names of the rods whose orders, elements and nodes
    """

    time: bool = False
    order: frozenset[str] = frozenset()
    elements: frozenset[str] = frozenset()
    nodes: frozenset[str] = frozenset()

    def __bool__(self) -> bool:
        return bool(self.time or self.order or self.elements or self.nodes)


@dataclass(frozen=True)
class Numerics:
    """Step in s, integrator and its options, Newton's tolerance and iterations, bases.

    Without a ``newton_tolerance`` Newton's method follows the error of the integrator. With a
    ``tolerance``, of the tip's position over the arm's length, and one of its ``orientation`` in
    rad, what is ``free`` has yet to be chosen (contract.py) and stands here with its default;
    ``trust`` is what the distance to a companion is then multiplied by (convergence.py).
    Without any numerics, all is free (unwritten.py). ``written`` has the keys that the scene's
    author wrote.
    ``rods`` has one Basis for every rod, with orders for its active strains only: ``basis`` with
    the overrides of that rod put in.
    """

    step: float = 0.002
    integrator: str = "sdirk2"
    options: dict[str, float] = field(default_factory=dict)
    newton_tolerance: float | None = None
    max_iterations: int = 20
    basis: Basis = field(default_factory=Basis)
    rods: dict[str, Basis] = field(default_factory=dict)
    tolerance: float | None = None
    orientation: float | None = None
    free: Free = Free()
    trust: float | None = field(default=None, compare=False)
    written: tuple[str, ...] = field(default=(), compare=False)

    @property
    def space_written(self) -> bool:
        """Whether the scene's author chose bases, for all rods or for some."""
        return bool({"basis", "rods"} & set(self.written))


def read_numerics(reader: Reader, bodies: tuple[Body, ...]) -> Numerics:
    """Read ``numerics``."""
    rods = [body for body in bodies if isinstance(body, Rod)]
    active = tuple(s for s in STRAINS if any(s in rod.strains for rod in rods))
    reader.only(
        "step", "integrator", "options", "newton_tolerance", "max_iterations", "basis", "rods",
        "tolerance",
    )  # fmt: skip
    basis = _read_basis(reader.mapping("basis"), Basis(), active)
    bases: dict[str, Basis] = {}
    overrides = reader.mapping("rods").only(*(rod.name for rod in rods))
    for rod in rods:
        bases[rod.name] = _read_basis(overrides.mapping(rod.name), basis, rod.strains)
    tolerance, orientation = _read_tolerance(reader)
    written = tuple(sorted(reader.keys()))
    fixed = tolerance is None and written
    return Numerics(
        step=_read_step(reader),
        integrator=reader.choice("integrator", INTEGRATORS, default="sdirk2"),
        options=_read_options(reader.mapping("options")),
        newton_tolerance=_read_newton_tolerance(reader),
        max_iterations=reader.whole("max_iterations", Interval.parse("[1, 1000]"), default=20),
        basis=basis,
        rods=bases,
        tolerance=tolerance,
        orientation=orientation,
        free=Free() if fixed else _read_free(reader, bases),
        written=written,
    )


def _read_tolerance(reader: Reader) -> tuple[float | None, float | None]:
    """Return the tolerances of the tip's position, over the length, and of its orientation."""
    if not reader.is_mapping("tolerance"):
        return reader.number("tolerance", POSITION, default=None), None
    both = reader.mapping("tolerance").only("position", "orientation")
    position = both.number("position", POSITION)
    return position, both.number("orientation", ORIENTATION, default=None)


def _read_free(reader: Reader, bases: dict[str, Basis]) -> Free:
    """Return what is not written down: a choice that is written stays."""
    adaptive = reader.choice("integrator", INTEGRATORS, default="adaptive") == "adaptive"
    common, overrides = reader.mapping("basis"), reader.mapping("rods")
    free: dict[str, set[str]] = {"order": set(), "elements": set(), "nodes": set()}
    for name, basis in bases.items():
        for key, rods in free.items():
            if not common.has(key) and not overrides.mapping(name).has(key):
                rods.add(name)
        if basis.kind in FIXED_ORDER:  # elements are all that can be refined
            free["order"].discard(name)
    return Free(
        time=adaptive and not reader.mapping("options").has("error"),
        **{key: frozenset(rods) for key, rods in free.items()},
    )


def _read_newton_tolerance(reader: Reader) -> float | None:
    if not reader.has("newton_tolerance") or reader.says("newton_tolerance", "auto"):
        return None
    return reader.number("newton_tolerance", Interval.parse("(0, 1)"))


def _read_step(reader: Reader) -> float:
    step = reader.number("step", POSITIVE, default=0.002)
    if step > LONGEST_STEP:
        reader.refuse(f"a number in (0, {LONGEST_STEP:g}]", "step")
    nanoseconds = step * 1e9
    # Time is counted in whole nanoseconds, as ROS counts it; anything else would drift. What is
    # long is a whole number but for round-off.
    apart = abs(nanoseconds - round(nanoseconds))
    if not (nanoseconds >= 1.0 - 1e-9 and apart < 1e-3 + 1e-15 * nanoseconds):
        reader.refuse("a time in s that is a whole number of nanoseconds", "step")
    return float(step)


def _read_options(reader: Reader) -> dict[str, float]:
    return {key: reader.number(key) for key in reader.keys()}


def _read_basis(reader: Reader, default: Basis, strains: tuple[str, ...]) -> Basis:
    """Read a basis; what is absent comes from ``default``."""
    reader.only("kind", "order", "elements", "nodes")
    kind = reader.choice("kind", BASES, default=default.kind)
    inherited = DEFAULT_ORDER if default.kind in FIXED_ORDER else default.order
    order = {strain: inherited[strain] for strain in strains}
    if kind in FIXED_ORDER:
        reader.no_effect("order", f"a {kind} basis has a fixed order")
        order = dict.fromkeys(strains, FIXED_ORDER[kind])
    elif reader.has("order"):
        order.update(_read_order(reader, strains))
    elements = reader.whole("elements", Interval(1, MAX_ELEMENTS, True, True), default.elements)
    nodes = default.nodes
    if reader.has("nodes"):
        automatic = reader.says("nodes", "auto")
        nodes = None if automatic else reader.whole("nodes", NODES)
    return Basis(kind, order, elements, nodes)


def _read_order(reader: Reader, strains: tuple[str, ...]) -> dict[str, int]:
    allowed = Interval(0, MAX_ORDER, True, True)
    if not reader.is_mapping("order"):
        return dict.fromkeys(strains, reader.whole("order", allowed))
    orders = reader.mapping("order").only(*STRAINS)
    for strain in STRAINS:
        if strain not in strains:
            orders.no_effect(strain, "this strain is not active, its order has no effect")
    return {s: orders.whole(s, allowed) for s in strains if orders.has(s)}
