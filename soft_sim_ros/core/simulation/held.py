"""What a simulation holds from outside: efforts, wrenches, and where driven joints are to go."""

from __future__ import annotations

import numpy as np

from soft_sim_ros.core.arguments import number, vector
from soft_sim_ros.core.backend.interrupts import wholly
from soft_sim_ros.core.floats import Floats
from soft_sim_ros.errors import BadArgument
from soft_sim_ros.scene.joint import LABELS

from .course import course_to
from .posed import coordinates_of, posed_joints, rates_of
from .twins import Twins


class Holding(Twins):
    """The inputs of a Simulation, each held until it is given anew."""

    def set_efforts(self, efforts: Floats) -> None:
        """Hold efforts (A,) in scene order, in N·m, N or Pa (lengths in m), from now on."""
        given = vector("efforts", efforts, self.n_actuators)
        if not self._entry.hold(given):
            raise BadArgument("efforts", efforts, f"{self.n_actuators} finite numbers")

    def set_tip_wrench(self, wrench: Floats, frame: str = "world") -> None:
        """Hold a wrench (6,), moment N·m then force N, on the tip.

        Along world axes, or ("tip") following it.
        """
        local, follows = self._along(wrench, frame, "tip")
        held = self._held
        if follows == held.follows[0] and np.array_equal(local, held.tip):
            return

        def push() -> None:
            held.tip[:], held.follows[0] = local, follows
            self._work.restart[0] = 1

        wholly(push)

    def set_wrench(self, name: str, wrench: Floats, frame: str | None = None) -> None:
        """Hold a wrench (6,), moment N·m then force N, where the load ``input: name`` is.

        frame : "world": along world axes, "body": along those of the cross-section; as the scene
            says by default
        """
        loads = self.scene.input_loads
        names = [load.name for load in loads]
        if name not in names:
            raise BadArgument(
                "name", name, f"one of the input loads {', '.join(names) or '(none)'}"
            )
        which = names.index(name)
        local, follows = self._along(wrench, loads[which].frame if frame is None else frame, "body")
        live = self._held.live
        if follows == live.follows[which] and np.array_equal(local, live.push[which]):
            return

        def push() -> None:
            live.push[which], live.follows[which] = local, follows
            self._work.restart[0] = 1

        wholly(push)

    def set_driven(
        self,
        name: str,
        position: float | None = None,
        velocity: float | None = None,
        within: float | None = None,
    ) -> None:
        """Command a driven coordinate that follows commands (``driven: {within: …}``).

        From where it is and however it moves, it goes there smoothly; its rate then stays.

        Parameters
        ----------
        name : of the coordinate: that of a joint with one, ``base/x`` of one with several
        position : rad or m, to be reached; None: wherever the rate leads to
        velocity : rad/s or m/s, when it gets there and from then on; None: 0
        within : s that it takes; as the scene says by default

        Raises
        ------
        BadArgument
            for a name that follows no commands, and numbers that are none
        """
        commanded = self.scene.commanded
        if name not in commanded:
            expected = f"one of the coordinates {', '.join(commanded) or '(none)'}"
            raise BadArgument("name", name, f"{expected}: they are driven within some time")
        if position is None and velocity is None:
            raise BadArgument("position", position, "a position or a velocity")
        own = commanded[name]
        goal = None if position is None else number("position", position) - own.start
        rate = None if velocity is None else number("velocity", velocity)
        lasts = own.within if within is None else number("within", within)
        if not lasts * 1e9 >= self.step_ns - 0.5:
            expected = f"at least the step of {self.step_ns * 1e-9:g} s, which has to show the way"
            raise BadArgument("within", within, expected)
        column = self.compiled.coordinate_names.index(name)
        row = self.compiled.loads.drives.column.tolist().index(column)
        told = self.dynamics.guided(self._now, self._held.live)
        now = np.array([part[column] for part in told])
        now[0] -= own.start
        with np.errstate(over="ignore", invalid="ignore"):
            course = course_to(self._now, now, lasts, goal, rate)
        if not np.isfinite(course).all():
            raise BadArgument("position", position, "a motion whose numbers are finite")

        def go() -> None:
            self._held.live.course[row] = course
            self._work.restart[0] = 1

        wholly(go)

    def set_driven_pose(
        self,
        joint: str,
        pose: Floats,
        twist: Floats | None = None,
        within: float | None = None,
    ) -> None:
        """Command a free joint at the base, all of whose coordinates follow commands.

        Parameters
        ----------
        joint : its name
        pose : (7,) x y z qx qy qz qw, in the world, of the frame that it carries
        twist : (6,) angular and linear velocity along the axes of that frame, rad/s and m/s, when
            it gets there; None: 0
        within : s that it takes; as the scene says by default
        """
        frames = posed_joints(self.scene)
        if joint not in frames:
            expected = f"one of the free joints {', '.join(frames) or '(none)'} that follow poses"
            raise BadArgument("joint", joint, expected)
        pose = vector("pose", pose, 7, finite=True)
        names = [f"{joint}/{label}" for label in LABELS["free"]]
        now = [self.q[self.compiled.coordinate_names.index(name)] for name in names[:3]]
        goal = coordinates_of(frames[joint], pose, np.array(now))
        rates = np.zeros(6)
        if twist is not None:
            rates = rates_of(goal, vector("twist", twist, 6, finite=True))
        for name, position, rate in zip(names, goal.tolist(), rates.tolist(), strict=True):
            self.set_driven(name, position, rate, within)

    def driven(self) -> tuple[Floats, Floats, Floats]:
        """Return position, rate and force (C,) of the driven coordinates that follow commands.

        Forces, in N·m or N, are what their drives must give beyond springs and dampers.
        """
        efforts, wrench, follows = self.held()
        columns = [self.compiled.coordinate_names.index(name) for name in self.scene.commanded]
        forces = self.dynamics.drive_forces(
            self.q, self.v, efforts, self._now, wrench, follows, self._held.live
        )
        all_forces = np.zeros(self.n_coordinates)
        all_forces[~self.dynamics.free] = forces
        return self.q[columns], self.v[columns], all_forces[columns]

    @property
    def _now(self) -> float:
        """Time in s as kernels count it."""
        return self.time_ns * 1e-9

    def _along(self, wrench: Floats, frame: str, own: str) -> tuple[Floats, bool]:
        """Return a wrench (6,) along the axes of the base, or of its frame, and whether of that."""
        wrench = vector("wrench", wrench, 6, finite=True)
        if frame not in ("world", own):
            raise BadArgument("frame", frame, f"'world' or {own!r}")
        follows = frame == own
        local = wrench if follows else self.dynamics.to_base(wrench)
        if not np.isfinite(local).all():  # overflows when rotated
            raise BadArgument("wrench", wrench, "6 finite numbers, also along the axes of the base")
        return local, follows
