"""The wrench of the surrounding fluid in the fixed frame, by the balance of the fluid's momentum.

The momentum that a body gives to the fluid is I_A (V − U), with V its twist and U = (0; u) that of
the current about the origin of the fixed frame, and I_A the added mass there, which moves with the
body. It is counted about a point that moves with the current, hence u × of its linear part. See
``spatial.py``; ``terms/fluid.py`` has the same in the axes of the body.
"""

from __future__ import annotations

import numpy as np

from soft_sim_ros.core.algebra import se3
from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.model.model import Data, Model


def fluid_wrenches(model: Model, data: Data, pose: Floats, twist: Floats, rate: Floats) -> Floats:
    """Return the wrench (nodes, 6) of the fluid on all nodes, about the origin of the base frame.

    Parameters
    ----------
    model, data : Model and its scratch, with gravity and current set
    pose, twist, rate : (nodes, 4, 4), (nodes, 6), (nodes, 6) of all nodes, as ``SpatialMotion``
    """
    fluid, out = model.fluid, np.zeros((len(pose), 6))
    turned = fluid.base[:9].reshape(3, 3)
    u, du = data.now[1] * (turned.T @ data.current[:, :2]).T
    flow, speeding = np.concatenate([np.zeros(3), u]), np.concatenate([np.zeros(3), du])
    height = (
        np.linalg.norm(data.gravity) * fluid.base[12] + turned @ data.gravity @ fluid.base[9:12]
    )
    for e, k in enumerate(fluid.node):
        own = np.eye(4)
        own[:3, :3], own[:3, 3] = fluid.frame[e, :9].reshape(3, 3), fluid.frame[e, 9:]
        place = pose[k] @ own
        rotation, x, v = place[:3, :3], place[:3, 3], twist[k]
        to_place, ad = se3.Ad(se3.inverse(place)), se3.ad(v)
        inertia = to_place.T @ (fluid.added[e][:, None] * to_place)
        momentum = inertia @ (v - flow)
        moved = inertia @ (rate[k] - speeding) - (ad.T @ inertia + inertia @ ad) @ (v - flow)
        out[k] -= moved
        out[k, :3] += np.cross(u, momentum[3:])
        spin = rotation.T @ v[:3]
        past = rotation.T @ (v[3:] + np.cross(v[:3], x) - u)
        speed = np.full(3, np.linalg.norm(past))
        lift = np.cross(past, fluid.lift[e]) * speed[0]
        drag = fluid.quadratic[e, 3:] * speed
        if fluid.law[e] == 0:
            friction, slower = fluid.quadratic[e, 3], np.hypot(past[1], past[2]) - speed[0]
            drag[1:] += (fluid.quadratic[e, 4:] - friction) * slower
        push = lift - (drag + fluid.viscous[e, 3:]) * past
        push[0] += data.now[1] * fluid.end[e] * (data.gravity @ x + height)
        brake = (fluid.quadratic[e, :3] * np.linalg.norm(spin) + fluid.viscous[e, :3]) * spin
        force = rotation @ push - fluid.displaced[e] * (data.gravity - du)
        out[k] += np.concatenate([np.cross(x, force) - rotation @ brake, force])
    return out
