"""The services of the node: standard types, answered when the physics has done it."""

from __future__ import annotations

from functools import partial

from std_srvs.srv import SetBool, Trigger

from soft_sim_ros.node.inbox import Answer
from soft_sim_ros.node.physics import Physics


class Services:
    """``~/reset``, ``~/pause``, ``~/step`` and others of one physics thread.

    ``~/payload/NAME`` attaches and drops, ``~/constraint/NAME`` holds and releases.

    Parameters
    ----------
    node : rclpy.node.Node
        Owner of the services.
    physics : Physics
        Carries them out.
    step_count : int
        Steps of one ``~/step``; 0 = as many as lie between two state messages.
    reset_time : bool
        Whether ``~/reset`` also sets the time of stamps back to 0.
    """

    def __init__(self, node, physics: Physics, step_count: int, reset_time: bool = False):
        self._physics = physics
        self.step_count, self.reset_time = step_count, reset_time
        self._services = (
            node.create_service(Trigger, "~/reset", self._reset),
            node.create_service(SetBool, "~/pause", self._pause),
            node.create_service(Trigger, "~/step", self._step),
            *(
                node.create_service(SetBool, f"~/payload/{name}", partial(self._carry, name))
                for name in physics.simulation.payloads
            ),
            *(
                node.create_service(SetBool, f"~/constraint/{name}", partial(self._latch, name))
                for name in physics.simulation.dynamics.constraints.names
            ),
        )

    def _reset(self, _, response):
        return _fill(response, self._physics.reset(time=self.reset_time))

    def _pause(self, request, response):
        return _fill(response, self._physics.pause(request.data))

    def _carry(self, name, request, response):
        return _fill(response, self._physics.carry(name, request.data))

    def _latch(self, name, request, response):
        return _fill(response, self._physics.latch(name, request.data))

    def _step(self, _, response):
        return _fill(response, self._physics.step(self.step_count or self._physics.grid.publish))


def _fill(response, answer: Answer):
    response.success, response.message = answer
    return response
