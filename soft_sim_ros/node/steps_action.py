"""The action ``~/simulate_steps`` of simulation_interfaces, where the package has it."""

from __future__ import annotations

from collections.abc import Generator
from importlib import import_module
from types import ModuleType
from typing import Any

from soft_sim_ros.node.physics import Physics


def offer_steps(node, physics: Physics, package: str, messages: ModuleType) -> StepsAction | None:
    """Offer the action if the package has it; older versions have none."""
    try:
        kind = import_module(f"{package}.action").SimulateSteps
    except (ImportError, AttributeError):
        return None
    from rclpy.action import ActionServer, CancelResponse

    action = StepsAction(physics, kind, messages.Result)
    action.server = ActionServer(
        node,
        kind,
        "~/simulate_steps",
        action.execute,
        cancel_callback=lambda goal: CancelResponse.ACCEPT,
    )
    return action


class StepsAction:
    """Makes many steps of a paused simulation, and tells how far it is.

    Between two states that are published it gives way to other callbacks, so it can be cancelled.

    Parameters
    ----------
    physics : Physics
        Makes the steps.
    kind : type
        ``simulation_interfaces.action.SimulateSteps``.
    codes : type
        ``simulation_interfaces.msg.Result``.
    """

    def __init__(self, physics: Physics, kind, codes):
        self._physics, self._kind, self._codes = physics, kind, codes
        self.server: Any = None

    async def execute(self, goal):
        """Carry out a goal; give its result."""
        physics, wanted = self._physics, int(goal.request.steps)
        first = physics.simulation.step_index
        made, text = 0, "" if wanted else "steps = 0: expected at least 1"
        while made < wanted and not text:
            if goal.is_cancel_requested:
                goal.canceled()
                return self._result(f"cancelled after {made} of {wanted} steps")
            before = made
            done, said = physics.step(min(wanted - made, physics.grid.publish))
            made = physics.simulation.step_index - first
            # a running arm moves by itself, and an arm that is stepped may take several calls
            if not done and (made == before or physics.diverged or not physics.paused):
                text = f"{made} of {wanted} steps: {said}"
            feedback = self._kind.Feedback()
            feedback.completed_steps, feedback.remaining_steps = made, max(0, wanted - made)
            goal.publish_feedback(feedback)
            await _Breath()
        if text:
            goal.abort()
        else:
            goal.succeed()
        return self._result(text)

    def _result(self, text: str):
        codes, result = self._codes, self._kind.Result()
        result.result.result = codes.RESULT_OPERATION_FAILED if text else codes.RESULT_OK
        result.result.error_message = text
        return result


class _Breath:
    """Lets an executor call what else is due."""

    def __await__(self) -> Generator[None, None, None]:
        yield
