"""What an arm feels, as arrows: contacts, and reactions of constraints."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from soft_sim_ros.scene import Scene
from soft_sim_ros.viewing.parts import Part, State, draw_arrow
from soft_sim_ros.viewing.shapes import (
    ARROW,
    MOMENT,
    REACTION,
    REMOVED,
    SLIPS,
    STICKS,
    Canvas,
    Shape,
)

if TYPE_CHECKING:
    from soft_sim_ros.core.mechanics.contacts import Contact

MOST = 40  # arrows of contacts; of more, the largest forces are shown


class Touching:
    """The force of one contact on the body, at its point: the ``number``-th of a state's."""

    def __init__(self, shape: Shape, unit: float, longest: float) -> None:
        self.shape, self._unit, self._longest = shape, unit, longest
        self._sticks: bool | None = None

    def draw(self, state: State, canvas: Canvas) -> None:
        """Write both ends, and the colour where it has changed."""
        if self.shape.number >= len(state.contacts):
            canvas.action[0] = REMOVED
            return
        contact = state.contacts[self.shape.number]
        draw_arrow(canvas, contact.point, contact.force, self._unit, self._longest)
        if contact.sticks is not self._sticks:
            self._sticks = contact.sticks
            canvas.colour[:] = STICKS if contact.sticks else SLIPS


class Reacting:
    """The force or the moment of a constraint on its first frame, where that is."""

    def __init__(
        self, shape: Shape, name: str, is_force: bool, unit: float, longest: float
    ) -> None:
        self.shape, self._name, self._is_force = shape, name, is_force
        self._unit, self._longest = unit, longest

    def draw(self, state: State, canvas: Canvas) -> None:
        """Write both ends."""
        reaction = state.reactions[self._name]
        vector = reaction.force if self._is_force else reaction.moment
        draw_arrow(canvas, reaction.place, vector, self._unit, self._longest)


def felt_parts(
    scene: Scene, size: tuple[float, float, float], weight: float, length: float, longest: float
) -> Iterator[Part]:
    """Yield the arrows of a scene.

    Parameters
    ----------
    size : of arrows in m: shaft, head, its length
    weight, length : N and m of the arm, which scale forces and moments
    longest : m
    """
    for number in range(MOST if scene.touches else 0):
        shape = Shape("contacts", number, ARROW, size, SLIPS, 2)
        yield Touching(shape, 0.2 * weight, longest)
    for number, one in enumerate(scene.constraints):
        for is_force in (True, False):
            colour = REACTION if is_force else MOMENT
            shape = Shape("reactions", 2 * number + (not is_force), ARROW, size, colour, 2)
            unit = weight if is_force else weight * length
            yield Reacting(shape, one.name, is_force, unit, longest)


def strongest(contacts: Sequence[Contact]) -> Sequence[Contact]:
    """Return at most MOST contacts, those with the largest forces, in their order."""
    if len(contacts) <= MOST:
        return contacts
    sizes = np.array([np.linalg.norm(contact.force) for contact in contacts])
    chosen = np.sort(np.argsort(-sizes, kind="stable")[:MOST])
    return [contacts[i] for i in chosen.tolist()]
