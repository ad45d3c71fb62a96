"""The services of simulation_interfaces, the standard for simulators, where it is installed."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any

from soft_sim_ros.foreign import listed, one_line
from soft_sim_ros.node.inbox import Answer
from soft_sim_ros.node.physics import Physics
from soft_sim_ros.node.steps_action import offer_steps
from soft_sim_ros.node.tip_frame import ALL, BASE, TIP, chosen_frames

if TYPE_CHECKING:
    from soft_sim_ros.viewing.motion import MovingFrames

PACKAGE = "simulation_interfaces"
_TIME, _STATE, _SPAWNED, _EVERYTHING = 1, 2, 4, 255  # bits of a scope; 0 is everything, too
_LONGEST_FILTER = 200  # characters
# A stopped simulation is paused and in its initial state at time 0, and nothing moved it since.
_FEATURES = (
    "ENTITY_CATEGORIES", "ENTITY_STATE_GETTING", "ENTITY_INFO_GETTING",
    "SIMULATION_RESET", "SIMULATION_RESET_STATE",
    "SIMULATION_STATE_GETTING", "SIMULATION_STATE_SETTING", "SIMULATION_STATE_PAUSE",
    "STEP_SIMULATION_SINGLE", "STEP_SIMULATION_MULTIPLE",
)  # fmt: skip


def standard_services(node, physics: Physics, frame_id: str) -> StandardServices | None:
    """Offer the services if the package is installed; say so once if it is not."""
    log = node.get_logger()
    try:
        messages = import_module(f"{PACKAGE}.msg")
        services = import_module(f"{PACKAGE}.srv")
    except ImportError:
        log.info(f"{PACKAGE} is not installed: only the services of std_srvs are offered")
        return None
    try:
        return StandardServices(node, physics, frame_id, messages, services)
    except RuntimeError as error:  # a policy of SROS2 may forbid it
        log.warning(f"the services of {PACKAGE} are not offered: {one_line(error)}")
        return None


class StandardServices:
    """``~/get_simulation_state`` and its like, for one physics thread.

    Parameters
    ----------
    node : rclpy.node.Node
        Owner of the services.
    physics : Physics
        Carries them out.
    frame_id : str
        Frame of poses.
    messages, services : module
        ``simulation_interfaces.msg`` and ``.srv``.
    """

    def __init__(
        self, node, physics: Physics, frame_id: str, messages: ModuleType, services: ModuleType
    ):
        self._physics, self._frame_id, self._messages = physics, frame_id, messages
        self._codes, self._states = messages.Result, messages.SimulationState
        self._stopped_at: int | None = None  # step index at which it was stopped
        scene = physics.simulation.scene
        self.entities = (BASE, TIP, *chosen_frames(scene, ALL))
        self._frames: MovingFrames | None = None
        self._services = [
            node.create_service(getattr(services, kind), f"~/{_snake(kind)}", self._with(handler))
            for kind, handler in self.handlers.items()
            if hasattr(services, kind)  # an older version may lack one
        ]
        self._steps = offer_steps(node, physics, PACKAGE, messages)

    @property
    def handlers(self) -> dict[str, Callable[[Any, Any], tuple[int, str]]]:
        """What carries out a call, by the name of its type: fills a response, gives its result."""
        return {
            "GetSimulatorFeatures": self._get_features,
            "GetSimulationState": self._get_state,
            "SetSimulationState": self._set_state,
            "StepSimulation": self._step,
            "ResetSimulation": self._reset,
            "GetEntities": self._get_entities,
            "GetEntitiesStates": self._get_states,
            "GetEntityState": self._get_entity,
            "GetEntityInfo": self._get_info,
            "SetEntityState": self._set_entity,
        }

    def _with(self, handler):
        def answer(request, response):
            code, text = handler(request, response)
            if hasattr(response, "result"):
                response.result.result, response.result.error_message = code, text
            return response

        return answer

    # Results, with the numbers that the package gives them.

    def _ok(self) -> tuple[int, str]:
        return self._codes.RESULT_OK, ""

    def _failed(self, text: str) -> tuple[int, str]:
        return self._codes.RESULT_OPERATION_FAILED, text

    def _unsupported(self, text: str) -> tuple[int, str]:
        return self._codes.RESULT_FEATURE_UNSUPPORTED, text

    def _done(self, answer: Answer) -> tuple[int, str]:
        done, text = answer
        return self._ok() if done else self._failed(text)

    # The simulation.

    def _get_features(self, _, response) -> tuple[int, str]:
        known = self._messages.SimulatorFeatures
        names = _FEATURES if self._physics.follows else (*_FEATURES, "SIMULATION_RESET_TIME")
        names = names if self._steps is None else (*names, "STEP_SIMULATION_ACTION")
        response.features.features = [getattr(known, n) for n in names if hasattr(known, n)]
        response.features.custom_info = (
            "soft_sim_ros: one step is the scene's numerics.step; accelerations are not computed; "
            "one StepSimulation ends after 2 s with what it has made"
        )
        return self._ok()

    def _now(self) -> int:
        """Return the state of the simulation."""
        physics, states = self._physics, self._states
        if not physics.paused:
            self._stopped_at = None
            return states.STATE_PLAYING
        if physics.simulation.step_index == self._stopped_at:
            return states.STATE_STOPPED
        return states.STATE_PAUSED

    def _get_state(self, _, response) -> tuple[int, str]:
        response.state.state = self._now()
        return self._ok()

    def _set_state(self, request, response) -> tuple[int, str]:
        states, physics = self._states, self._physics
        wanted = request.state.state
        if wanted == states.STATE_QUITTING:
            physics.stop()
            return self._ok()
        if wanted not in (states.STATE_STOPPED, states.STATE_PLAYING, states.STATE_PAUSED):
            return self._unsupported(f"state {wanted}: expected stopped, playing, paused, quitting")
        if wanted == self._now():
            return response.ALREADY_IN_TARGET_STATE, "the simulation is in this state"
        if wanted == states.STATE_STOPPED:
            if physics.follows:
                return response.STATE_TRANSITION_ERROR, "stopping resets time, which is another's"
            done, text = physics.pause(True)
            if done:
                done, text = physics.reset(time=True, resume=False)
            if done:
                self._stopped_at = physics.simulation.step_index
        else:
            done, text = physics.pause(wanted == states.STATE_PAUSED)
            self._stopped_at = None
        return self._ok() if done else (response.STATE_TRANSITION_ERROR, text)

    def _step(self, request, _) -> tuple[int, str]:
        if request.steps < 1:
            return self._failed(f"steps = {request.steps}: expected at least 1")
        return self._done(self._physics.step(int(request.steps)))

    def _reset(self, request, _) -> tuple[int, str]:
        scope = request.scope or _EVERYTHING
        unknown = scope & ~(_TIME | _STATE | _SPAWNED)
        if unknown and scope != _EVERYTHING:
            return self._unsupported(f"scope {scope}: expected time 1, state 2, spawned 4, or all")
        time, state = bool(scope & _TIME), bool(scope & _STATE)
        if not (time or state):
            return self._unsupported("nothing is ever spawned here")
        if time and self._physics.follows:
            return self._unsupported("time belongs to the program that publishes /clock: scope 2")
        return self._done(self._physics.reset(state=state, time=time))

    # Entities: base, tip, joints and rigid bodies.

    def _matching(self, filters) -> list[str] | tuple[int, str]:
        """Return the entities that pass filters, or the result that says why not."""
        if filters.tags.tags:
            return self._unsupported("entities have no tags")
        if filters.bounds.type != self._messages.Bounds.TYPE_EMPTY:
            return self._unsupported("entities cannot be filtered by bounds")
        robot = self._messages.EntityCategory.CATEGORY_ROBOT
        if filters.categories and all(one.category != robot for one in filters.categories):
            return []
        if len(filters.filter) > _LONGEST_FILTER:
            return self._failed(f"a filter of {len(filters.filter)} characters: expected at most "
                                f"{_LONGEST_FILTER}")  # fmt: skip
        try:
            pattern = re.compile(filters.filter)
        except (re.error, OverflowError, RecursionError) as error:
            return self._failed(f"filter: {one_line(error)}")
        return [name for name in self.entities if pattern.search(name)]

    def _get_entities(self, request, response) -> tuple[int, str]:
        found = self._matching(request.filters)
        if isinstance(found, tuple):
            return found
        response.entities = found
        return self._ok()

    def _get_states(self, request, response) -> tuple[int, str]:
        found = self._matching(request.filters)
        if isinstance(found, tuple):
            return found
        states = [self._messages.EntityState() for _ in found]
        done, text = self._look(found, states)
        if not done:
            return self._failed(text)
        response.entities, response.states = found, states
        return self._ok()

    def _get_entity(self, request, response) -> tuple[int, str]:
        if request.entity not in self.entities:
            return self._not_found(request.entity)
        return self._done(self._look([request.entity], [response.state]))

    def _get_info(self, request, response) -> tuple[int, str]:
        if request.entity not in self.entities:
            return self._not_found(request.entity)
        response.info.category.category = self._messages.EntityCategory.CATEGORY_ROBOT
        response.info.description = (
            f"frame {request.entity} of {self._physics.simulation.scene.name}"
        )
        return self._ok()

    def _set_entity(self, request, _) -> tuple[int, str]:
        if request.entity not in self.entities:
            return self._not_found(request.entity)
        return self._unsupported("the frames of an arm follow from its coordinates")

    def _not_found(self, name: str) -> tuple[int, str]:
        have = listed(self.entities, 20)
        return self._codes.RESULT_NOT_FOUND, f"no entity {one_line(name)[:100]!r}: there are {have}"

    def _look(self, names: Sequence[str], states: Sequence[Any]) -> Answer:
        """Fill the states of entities, in the thread that owns the simulation."""

        def look() -> Answer:
            if self._frames is None:  # built for the first who asks
                from soft_sim_ros.viewing.motion import MovingFrames

                spots = [(name, 0.0) for name in self.entities]
                self._frames = MovingFrames(self._physics.simulation, spots)
            poses, twists = self._frames.look()
            sec, nanosec = divmod(self._physics.stamp_ns, 1_000_000_000)
            for name, state in zip(names, states, strict=True):
                number = self.entities.index(name)
                state.header.frame_id = self._frame_id
                state.header.stamp.sec, state.header.stamp.nanosec = sec, nanosec
                x, y, z, qx, qy, qz, qw = poses[number].tolist()
                place, turn = state.pose.position, state.pose.orientation
                place.x, place.y, place.z = x, y, z
                turn.x, turn.y, turn.z, turn.w = qx, qy, qz, qw
                vx, vy, vz, wx, wy, wz = twists[number].tolist()
                linear, angular = state.twist.linear, state.twist.angular
                linear.x, linear.y, linear.z = vx, vy, vz
                angular.x, angular.y, angular.z = wx, wy, wz
            return True, ""

        return self._physics.look(look)


def _snake(name: str) -> str:
    return re.sub(r"(?<!^)(?=[A-Z])", "_", name).lower()
