"""The zoo of scenes.py with every kind of path, command and friction."""

from __future__ import annotations

from typing import Any

import numpy as np
from scenes import zoo_document

EXTRA = [
    {"tendon": "winch", "rod": "one", "offset": [0.02, 0.01],
     "control": "length", "axial_stiffness": 500.0, "axial_damping": 5.0},
    {"tendon": "rubbing", "rod": "one", "offset": {"from": [0.02, 0.01], "to": [-0.01, 0.015]},
     "friction": 0.4, "slip_speed": 0.1},
    {"tendon": "rubbing_winch", "rod": "two", "helix": {"radius": 0.02, "turns": 0.5},
     "friction": 0.3, "slip_speed": 0.1,
     "control": "length", "axial_stiffness": 500.0, "axial_damping": 3.0},
    {"tendon": "table", "rod": "one", "friction": 0.3, "slip_speed": 0.05,
     "points": [[0.05, 0.01, 0.0], [0.1, 0.02, 0.01], [0.3, 0.0, 0.02]]},
    {"tendon": "slack", "rod": "two", "offset": [0.01, 0.0],
     "control": "length", "axial_stiffness": 500.0},
    {"chamber": "chamber", "rod": "one", "section": "a", "offset": [0.01, 0.01], "area": 1e-4},
]  # fmt: skip
COMMANDS = np.array([0.3, -0.2, 8.0, 5.0, 0.02, 6.0, 0.02, 7.0, -1.0, 5e4])
LENGTHS = np.array([4, 6, 8])  # actuators commanded by length


def rigged_document() -> dict[str, Any]:
    """Return the document of the zoo with all kinds of actuators along paths."""
    document = zoo_document()
    return document | {"actuators": document["actuators"] + EXTRA}
