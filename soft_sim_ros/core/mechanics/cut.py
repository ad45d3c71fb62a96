"""The wrench through a cut in front of a joint or a rod.

The recursion sums up, at every node, what the node itself and everything beyond it ask for. Where
the end of one body and the beginning of the next are one node, masses and loads of both are lumped
there, and other bodies may leave from it. What does not lie beyond the cut is taken off again.
"""

from __future__ import annotations

import numpy as np

from soft_sim_ros.core.compile.loads import node_shares
from soft_sim_ros.core.compile.scene import Compiled
from soft_sim_ros.core.floats import Floats
from soft_sim_ros.errors import SceneError
from soft_sim_ros.scene import FlexibleLink, InputLoad, Joint, RigidBody, Rod
from soft_sim_ros.scene.sensor import Sensor

from .instant import Instant, cross


class Cut:
    """The cut in front of a body: between it with all that is attached to it, and the rest.

    Parameters
    ----------
    compiled : the arm
    sensor : whose body it is
    key : of the sensor in its scene, for errors

    Raises
    ------
    SceneError
        if forces at its node cannot be told apart
    """

    def __init__(self, compiled: Compiled, sensor: Sensor, key: str) -> None:
        scene, chain = compiled.scene, compiled.chain
        body = next(body for body in scene.bodies if body.name == sensor.of)
        self.node = (
            chain.frames[body.name] if isinstance(body, Joint) else chain.rods[body.name].first_node
        )
        beyond = {body.name}
        for other in scene.bodies:  # depth first: what a body is attached to comes before it
            if scene.forest.parent(other.name) in beyond:
                beyond.add(other.name)
        self._masses: list[tuple[Floats, Floats, int]] = []
        before = [other for other in scene.bodies if other.name not in beyond]
        shared = [other for other in before if self._ends_here(compiled, other)]
        self._loads = [
            (i, node, share)
            for i, load in enumerate(scene.scheduled_loads)
            if load.body not in beyond
            for node, share in node_shares(chain, load)
            if node == self.node
        ]
        pushed = compiled.loads.push.tolist()
        self._pushes = [
            i
            for i, load in enumerate(scene.input_loads)
            if isinstance(load, InputLoad) and load.body not in beyond and pushed[i] == self.node
        ]
        ends = list(chain.ends.items())
        self._branches = [
            k
            for k, segment in enumerate(chain.segments)
            if segment.origin == self.node
            and next(name for name, end in ends if end > k) not in beyond
        ]
        self._compiled = compiled
        if shared:
            self._refuse_mixed(compiled, shared[-1].name, sensor, key)

    def wrench(self, now: Instant) -> Floats:
        """Return the wrench (6,) that what is beyond does to what is before.

        Moment about the origin of the body's frame and force, along the axes of that frame.
        """
        data, live = now.data, None if now.data is None else now.data.live
        assert data is not None and live is not None
        total = data.wrench[self.node].copy()
        for k in self._branches:
            turn, shift = data.relative[k, :9].reshape(3, 3), data.relative[k, 9:]
            moment, force = turn @ data.wrench[k + 1, :3], turn @ data.wrench[k + 1, 3:]
            total -= np.concatenate([moment + cross(shift, force), force])
        eta, rate = data.eta[self.node], data.acc[self.node]
        for inertia, damping, payload in self._masses:
            if payload < 0 or now.attached[payload]:
                total -= inertial_wrench(inertia, eta, rate) + damping[[1, 2, 3, 0, 0, 0]] * eta
        loads, turn = self._compiled.loads, data.rotation[self.node].reshape(3, 3)
        for i, _, share in self._loads:
            load = self._compiled.scene.scheduled_loads[i]
            own = np.concatenate([load.moment, load.force])
            if not loads.follows[i]:
                own = _turned(self._compiled.to_base(own), turn)
            total += load.schedule.factor(now.time) * share * own
        for i in self._pushes:
            push = live.push[i]
            total += push if live.follows[i] else _turned(push, turn)
        return -total

    def _ends_here(self, compiled: Compiled, body: Joint | Rod | RigidBody | FlexibleLink) -> bool:
        """Note the masses that a body before the cut has on its node; tell whether it ends here."""
        chain, node = compiled.chain, self.node
        if isinstance(body, Rod):
            elements = chain.rods[body.name].elements
            if chain.rods[body.name].last_node != node:
                return False
            _, at, weights = elements[-1].lumps
            inertia = (elements[-1].section.inertia(at) * weights)[-1]
            damping = elements[-1].section.material.mass_damping * inertia
            self._masses.append((inertia, damping, -1))
        elif isinstance(body, RigidBody) and chain.frames[body.name] == node:
            row = np.array([body.mass, *body.inertia])
            payload = -1
            if body.name in chain.payloads:
                payload = list(chain.payloads).index(body.name)
                if chain.payloads[body.name][0] != node:
                    return False
            elif body.com.position.any() or body.com.quaternion[:3].any():
                return False
            self._masses.append((row, np.zeros(4), payload))
        return chain.ends[body.name] == node

    def _refuse_mixed(self, compiled: Compiled, before: str, sensor: Sensor, key: str) -> None:
        """Refuse forces on the node that are not known by body."""
        model = compiled.model
        found = {
            "the fluid": model.fluid.node,
            "contact": model.contact.node,
            "a load by a law": model.custom.node,
            "a constraint": model.closures.node,
        }
        mixed = [what for what, nodes in found.items() if (nodes == self.node).any()]
        if before in compiled.chain.links:
            mixed.append("the masses of a flexible link")
        if mixed:
            expected = (
                f"a joint with an offset between it and {before}: {mixed[0]} acts at the end of "
                f"{before}, which is the same place"
            )
            raise SceneError(compiled.scene.file, f"{key}.body", sensor.of, expected)


def inertial_wrench(inertia: Floats, eta: Floats, rate: Floats) -> Floats:
    """Return the wrench (6,) that a mass asks for: Boyer & Primault 2005 (3.15).

    inertia : (4,) kg and principal moments in kg·m²; eta, rate : twist and its rate (6,)
    """
    spin = inertia[1:] * eta[:3]
    moment = inertia[1:] * rate[:3] + cross(eta[:3], spin)
    return np.concatenate([moment, inertia[0] * (rate[3:] + cross(eta[:3], eta[3:]))])


def _turned(wrench: Floats, turn: Floats) -> Floats:
    """Return a wrench (6,) along base axes in those of a frame."""
    return np.concatenate([wrench[:3] @ turn, wrench[3:] @ turn])
