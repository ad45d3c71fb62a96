"""What a sensor says, as a value."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from soft_sim_ros.core.floats import Floats
from soft_sim_ros.errors import NoSuchPlace


@dataclass(frozen=True, eq=False)
class Reading:
    """One reading of a sensor.

    ``reading["acceleration"]`` is what belongs to a quantity: a number, or an array where the
    quantity has components.

    Attributes
    ----------
    name, kind : of the sensor
    time_ns : simulation time in ns at which it was measured; None: nothing was measured yet
    delivered_ns : when it got out of the sensor, ``latency`` later; None likewise
    labels : names of the numbers, ``quantity`` or ``quantity/component``
    values : (W,) the numbers, NaN if nothing was measured yet
    """

    name: str
    kind: str
    time_ns: int | None
    delivered_ns: int | None
    labels: tuple[str, ...]
    values: Floats

    @property
    def time(self) -> float:
        """Simulation time in s at which it was measured; NaN: nothing was measured yet."""
        return np.nan if self.time_ns is None else self.time_ns * 1e-9

    def __getitem__(self, quantity: str) -> float | Floats:
        """Return a quantity, a component of it, or all components (k,)."""
        if quantity in self.labels:
            return float(self.values[self.labels.index(quantity)])
        columns = [i for i, x in enumerate(self.labels) if x.startswith(f"{quantity}/")]
        if not columns:
            known = dict.fromkeys(x.split("/")[0] for x in self.labels)
            raise NoSuchPlace(quantity, f"a quantity of {self.name}: {', '.join(known)}")
        return self.values[columns]

    def __repr__(self) -> str:
        numbers = ", ".join(f"{x:.6g}" for x in self.values.tolist())
        return f"<{self.kind} {self.name!r} at t = {self.time:.9g} s: {numbers}>"
