"""Contacts of a state as values."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from soft_sim_ros.core.compile.contact import Station, fixed_shapes, stations
from soft_sim_ros.core.compile.scene import Compiled
from soft_sim_ros.core.contact import rows as columns
from soft_sim_ros.core.contact.rows import COLUMNS, contact_rows
from soft_sim_ros.core.floats import Floats
from soft_sim_ros.core.model.model import new_data


@dataclass(frozen=True, eq=False)
class Contact:
    """One station of a body on one shape.

    Attributes
    ----------
    body, shape : names
    s : m along the body; 0 on rigid bodies
    point : (3,) m, of the body's surface, in the world
    normal : (3,) from the shape to the body, along world axes
    gap : m, below zero by the depth
    normal_force : N, that pushes the body along the normal
    friction : (3,) N on the body, along world axes
    sticks : whether friction holds it; False where there is none
    slip : (3,) m/s, velocity of the point along the surface
    radius : m of the body there
    length : m of the body that the station stands for; forces over it are forces per length
    """

    body: str
    shape: str
    s: float
    point: Floats
    normal: Floats
    gap: float
    normal_force: float
    friction: Floats
    sticks: bool
    slip: Floats
    radius: float
    length: float

    @property
    def force(self) -> Floats:
        """The whole force (3,) in N on the body, along world axes."""
        return self.normal_force * self.normal + self.friction


class ContactReader:
    """Reads contacts off states of a compiled scene."""

    def __init__(self, compiled: Compiled) -> None:
        self._compiled, self._model = compiled, compiled.model
        self._data = new_data(self._model)
        self._stations: list[Station] = stations(compiled.scene, compiled.chain)
        shapes = fixed_shapes(compiled.scene)
        self._shapes = [shape.name for shape in shapes]
        self._rows = np.zeros((len(self._stations), len(shapes), COLUMNS))
        self._zero = np.zeros(len(compiled.coordinate_names))

    def near(
        self, q: Floats, v: Floats, gap: float = 0.0, bristles: Floats | None = None
    ) -> tuple[Contact, ...]:
        """Return pairs that are not further apart than a gap in m, in the order of the bodies.

        q, v : (n,)
        bristles : as Touch has them; None: there is no friction
        """
        self._data.touch.bristle[:] = 0.0 if bristles is None else bristles
        contact_rows(self._model, self._data, q, v, self._zero, self._rows)
        turn, origin = self._compiled.base[:3, :3], self._compiled.base[:3, 3]
        found = []
        for e, m in np.argwhere(self._rows[:, :, columns.GAP] <= gap).tolist():
            row, station = self._rows[e, m], self._stations[e]
            normal, point, pull, slide = (
                turn @ row[at : at + 3]
                for at in (columns.NORMAL, columns.POINT, columns.PULL, columns.SLIDE)
            )
            found.append(
                Contact(
                    body=station.body,
                    shape=self._shapes[m],
                    s=station.s,
                    point=origin + point,
                    normal=normal,
                    gap=float(row[columns.GAP]),
                    normal_force=float(row[columns.PUSH]),
                    friction=pull,
                    sticks=bool(row[columns.STICKS]),
                    slip=slide,
                    radius=station.radius,
                    length=station.share,
                )
            )
        return tuple(found)


def resultants(contacts: Sequence[Contact]) -> dict[tuple[str, str], Floats]:
    """Return for each pair (body, shape) that touches the wrench on the body (6,).

    Moment in N·m about the origin of the world, force in N, along world axes.
    """
    out: dict[tuple[str, str], Floats] = {}
    for contact in contacts:
        pair = contact.body, contact.shape
        wrench = np.concatenate([np.cross(contact.point, contact.force), contact.force])
        out[pair] = out.get(pair, np.zeros(6)) + wrench
    return out
