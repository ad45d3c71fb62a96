"""A reference shape given as points of the centre line, with or without frames, as strains.

Points are joined by a quintic spline over their chords (a cubic one if there are fewer than six);
its arc length is found by quadrature, its curvature vector t × t′ is seen from a frame that goes
along. That frame is the one that does not turn about the tangent (rotation-minimising), or is read
from quaternions at the points, joined by scipy's rotation spline. Only strains come out, so where
the curve lies in space does not matter.
"""

from __future__ import annotations

import itertools
from typing import NamedTuple

import numpy as np
import scipy

from soft_sim_ros.scene.columns import read_columns
from soft_sim_ros.scene.profile import Profile, Smooth
from soft_sim_ros.scene.reader import Reader
from soft_sim_ros.scene.taper import Floats, Taper

LEAST = 4  # points
AGREEMENT = 1e-3  # of the length: what points and `length` may differ by
FINE = 2000  # places along the curve at which strains are taken


class Curve(NamedTuple):
    """The curve at fine places (M,): arc length, tangent and curvature vector t × dt/ds (M, 3)."""

    s: Floats
    tangent: Floats
    curvature: Floats


def read_centre_line(
    reader: Reader, length: float
) -> tuple[tuple[Profile, ...], Profile, tuple[Profile, ...]]:
    """Return curvature (3), stretch and shear (2) of a section of a length in m."""
    reader.only("points", "frames", "file", "normal")
    key = reader.one_of(("points", "file"))
    points, quaternions = _read_points(reader, key)
    steps = np.linalg.norm(np.diff(points.reshape(-1, 3), axis=0), axis=1)
    if len(points) < LEAST or not np.all(steps > 1e-9 * length):
        reader.refuse(f"at least {LEAST} points, each apart from the one before", key)
    straight = float(steps.sum())  # no curve through the points is shorter
    if straight > length * (1.0 + AGREEMENT):
        expected = (
            f"points on a curve as long as the section, {length:g} m (at least {straight:g} m)"
        )
        reader.refuse(expected, key)
    chord = np.concatenate([[0.0], np.cumsum(steps)])
    spline = scipy.interpolate.make_interp_spline(chord, points, k=5 if len(points) > 5 else 3)
    curve = _curve(spline, chord)
    whole = float(curve.s[-1])
    if abs(whole - length) > AGREEMENT * length:
        reader.refuse(
            f"points on a curve as long as the section, {length:g} m ({whole:.6g} m)", key
        )
    if quaternions is None:
        strains = _without_twist(reader, curve)
    else:
        strains = _with_frames(reader, curve, quaternions, _at_points(curve, chord))
    # the same shape, made exactly as long as the section
    strains[:, :3] *= whole / length
    fit = [
        scipy.interpolate.make_interp_spline(curve.s * (length / whole), column, k=3)
        for column in strains.T
    ]
    profiles: list[Profile] = [
        Taper(column[0], column[0]) if np.all(column == column[0]) else Smooth(f, length)
        for f, column in zip(fit, strains.T, strict=True)
    ]
    return tuple(profiles[:3]), profiles[3], tuple(profiles[4:])


def _read_points(reader: Reader, key: str) -> tuple[Floats, Floats | None]:
    """Return points (N, 3) and quaternions (N, 4) or None."""
    if key == "points":
        points = reader.matrix("points", None, 3)
        if not reader.has("frames"):
            return points, None
        reader.no_effect("normal", "the frames say where the section's axes point")
        quaternions = reader.matrix("frames", None, 4)
        if len(quaternions) != len(points):
            reader.refuse(f"{len(points)} quaternions [x, y, z, w], one for each point", "frames")
        if np.any(np.abs(np.linalg.norm(quaternions, axis=1) - 1.0) > 1e-3):
            reader.refuse("quaternions [x, y, z, w] of norm 1", "frames")
        return points, quaternions
    reader.no_effect("frames", "they are columns qx, qy, qz, qw of the file")
    columns = read_columns(reader, "file", ("x", "y", "z"), ("qx", "qy", "qz", "qw"))
    points = np.stack(columns[:3], axis=1)
    content = f"points: {points.tolist()}"
    quaternions = np.stack(columns[3:], axis=1) if len(columns) > 3 else None
    if quaternions is not None:
        reader.no_effect("normal", "the frames say where the section's axes point")
        content += f", frames: {quaternions.tolist()}"
    if reader.has("normal"):
        content += f", normal: {reader.vector('normal', 3).tolist()}"
    reader.inline(f"{{{content}}}")
    return points, quaternions


def _curve(spline: scipy.interpolate.BSpline, chord: Floats) -> Curve:
    """Return the curve at equal parts of every chord, about FINE in all."""
    parts = max(4, FINE // (len(chord) - 1))
    u = np.concatenate([
        np.linspace(a, b, parts, endpoint=False)
        for a, b in itertools.pairwise(chord)
    ] + [chord[-1:]])  # fmt: skip
    first, second = spline.derivative(1), spline.derivative(2)
    x, w = np.polynomial.legendre.leggauss(6)
    inner = u[:-1, None] + np.diff(u)[:, None] * 0.5 * (1.0 + x)
    speeds = np.linalg.norm(first(inner), axis=-1)
    s = np.concatenate([[0.0], np.cumsum(0.5 * np.diff(u) * (speeds @ w))])
    slope = first(u)
    speed = np.linalg.norm(slope, axis=1, keepdims=True)
    return Curve(s, slope / speed, np.cross(slope, second(u)) / speed**3)


def _at_points(curve: Curve, chord: Floats) -> Floats:
    """Return the arc lengths (N,) of the points."""
    return curve.s[:: (len(curve.s) - 1) // (len(chord) - 1)]


def _without_twist(reader: Reader, curve: Curve) -> Floats:
    """Return strains (M, 6) in the rotation-minimising frame.

    Its y axis starts along ``normal``, or along the y axis of the points (z, if the curve begins
    along y), made upright to the tangent. It is carried by double reflection (W. Wang and others,
    ACM Trans. Graph. 27, 2008), whose angle is right to the fourth power of the fine step.
    """
    start = curve.tangent[0]
    axis = np.array([0.0, 0.0, 1.0] if abs(start[1]) > 0.9 else [0.0, 1.0, 0.0])
    normal = reader.vector("normal", 3, default=axis)
    upright = normal - start * (start @ normal)
    if not np.linalg.norm(upright) > 1e-6 * np.linalg.norm(normal):
        reader.refuse("a direction that is not along the curve", "normal")
    y = np.empty_like(curve.tangent)
    y[0] = upright / np.linalg.norm(upright)
    # chords of the fine curve, to the accuracy of its tangents (Simpson's rule would need middles)
    step = np.diff(curve.s)[:, None]
    bend = np.cross(curve.curvature, curve.tangent)  # dt/ds
    chord = 0.5 * step * (curve.tangent[:-1] + curve.tangent[1:])
    chord += step**2 / 12.0 * (bend[:-1] - bend[1:])
    for i in range(len(step)):
        along = chord[i] / np.linalg.norm(chord[i])
        carried = y[i] - 2.0 * (along @ y[i]) * along
        ahead = curve.tangent[i] - 2.0 * (along @ curve.tangent[i]) * along
        mirror = curve.tangent[i + 1] - ahead
        y[i + 1] = carried - 2.0 * (mirror @ carried) / (mirror @ mirror) * mirror
    z = np.cross(curve.tangent, y)
    out = np.zeros((len(curve.s), 6))
    out[:, 1] = np.sum(curve.curvature * y, axis=1)
    out[:, 2] = np.sum(curve.curvature * z, axis=1)
    out[:, 3] = 1.0
    return out


def _with_frames(reader: Reader, curve: Curve, quaternions: Floats, s: Floats) -> Floats:
    """Return strains (M, 6) seen from frames given at arc lengths s (N,)."""
    frames = scipy.spatial.transform.RotationSpline(
        s, scipy.spatial.transform.Rotation.from_quat(quaternions)
    )
    tangent = frames(curve.s).inv().apply(curve.tangent)
    if not np.all(tangent[:, 0] > 0.5):
        reader.refuse("frames whose x axes point along the curve", "frames")
    return np.concatenate([frames(curve.s, 1), tangent], axis=1)
