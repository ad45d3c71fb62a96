"""``sensor_msgs/Imu`` as CDR bytes."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from soft_sim_ros.recording.cdr import Buffer, Layout, set_stamp

ORIENTATION, RATE, ACCELERATION = 0, 4 + 9, 4 + 9 + 3 + 9  # first numbers of each in the message
NUMBERS = ACCELERATION + 3 + 9


class ImuBuffer(Buffer):
    """``sensor_msgs/Imu`` in a fixed frame, with fixed covariances.

    Parameters
    ----------
    frame_id : frame of the sensor
    deviation : (9,) standard deviations of orientation in rad, angular velocity in rad/s and
        acceleration in m/s², by axes; where those of one are all zero, its covariance is
        "unknown" to the message
    """

    def __init__(self, frame_id: str, deviation: ArrayLike) -> None:
        layout = Layout().header(frame_id).doubles(NUMBERS)
        self._message, self._stamp, (self._numbers,) = layout.build()
        variance = np.asarray(deviation, float).reshape(3, 3) ** 2
        for first, width, own in zip(
            (ORIENTATION, RATE, ACCELERATION), (4, 3, 3), variance, strict=True
        ):
            self._numbers[first + width : first + width + 9] = np.diag(own).ravel()

    def fill(self, time_ns: int, values: ArrayLike) -> bytes:
        """Give the bytes for quaternion x y z w, angular velocity and acceleration (10,)."""
        set_stamp(self._stamp, time_ns)
        values = np.asarray(values, float)
        self._numbers[ORIENTATION : ORIENTATION + 4] = values[:4]
        self._numbers[RATE : RATE + 3] = values[4:7]
        self._numbers[ACCELERATION : ACCELERATION + 3] = values[7:]
        return self._message.tobytes()
