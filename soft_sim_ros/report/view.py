"""The part of a page that plays the run in three dimensions, with all it needs inside."""

from __future__ import annotations

import base64
import gzip
import html
import json
import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from soft_sim_ros.recording.reader import Run
from soft_sim_ros.report import around
from soft_sim_ros.report.shapes import shapes_of
from soft_sim_ros.report.style import shown, stride
from soft_sim_ros.report.units import scene_of
from soft_sim_ros.scene.taper import Floats
from soft_sim_ros.viewing.recorded import RecordedTube, recorded_tubes

_FOLDER = Path(__file__).parent
_LIBRARY = _FOLDER / "vendor" / "three.module.min.js"
_LICENCE = _FOLDER / "vendor" / "LICENSE.three.txt"
_PROGRAM = _FOLDER / "view.js"
FRAMES, POSES, TRAIL = 400, 61, 800  # most of them that a page holds
FEWEST = 13  # poses of each backbone, where there are many
_WHOLE = 32767  # the largest number of 16 bits
CSS = """
#view { position: relative; }
#view canvas { display: block; width: 100%; touch-action: none; border-radius: 6px;
  cursor: grab; }
#view .bar { display: flex; flex-wrap: wrap; gap: 8px; align-items: center; margin-top: 10px; }
#view .bar input { flex: 1 1 140px; min-width: 100px; accent-color: var(--accent); }
#view .bar output { min-width: 66px; text-align: right; font-variant-numeric: tabular-nums; }
#view button, #view select { font: inherit; font-size: 13.5px; padding: 4px 11px; color: inherit;
  background: #fff; border: 1px solid #c5ced7; border-radius: 6px; cursor: pointer; }
#view button:hover { background: #eef3f7; }
#view .hint { color: var(--soft); font-size: 12.5px; margin: 8px 0 0; }
@media print { #view-card { display: none; } }
"""


def section(run: Run) -> str:
    """Return the HTML of the view; empty where there is no shape that can be drawn."""
    shapes = shapes_of(run)
    found = np.flatnonzero(shapes.drawable)
    if not len(found) or any(part.stop - part.start < 2 for part in shapes.parts):
        return ""
    chosen = found[stride(len(found), FRAMES)]
    most = max(POSES // len(shapes.parts), FEWEST)
    shares = [part.start + stride(part.stop - part.start, most) for part in shapes.parts]
    picked = np.concatenate(shares)
    poses = shapes.poses[chosen][:, picked]
    scene = scene_of(run)
    positions = poses[..., :3]
    counts = {name: len(own) for name, own in zip(shapes.names, shares, strict=True)}
    steps = np.linalg.norm(np.diff(positions, axis=1), axis=2)
    steps[:, np.cumsum(list(counts.values()))[:-1] - 1] = 0.0  # from one backbone to the next
    tubes = recorded_tubes(scene, counts, float(steps.sum(axis=1).max()))
    names = [tube.actuator for tube in tubes if tube.actuator is not None]
    low, high = positions.min(axis=(0, 1)), positions.max(axis=(0, 1))
    extent = float(np.ptp(positions, axis=(0, 1)).max()) or 1.0
    digits = 5 - math.floor(math.log10(extent))
    grain = extent / (2 * _WHOLE)
    numbers = np.empty((len(chosen), 7 * len(picked) + len(names)), "<i2")
    numbers[:, : 7 * len(picked)] = np.concatenate(
        [np.rint((positions - low) / grain) - _WHOLE, np.rint(_upright(poses) * _WHOLE)], axis=2
    ).reshape(len(chosen), -1)
    moments = shapes.time_ns[chosen]
    numbers[:, 7 * len(picked) :] = np.rint(_shares(run, moments, names) * _WHOLE)
    trails = [
        shapes.poses[found[stride(len(found), TRAIL)], part.stop - 1, :3] for part in shapes.parts
    ]
    meta = {
        "frames": len(chosen),
        "poses": len(picked),
        "times": np.round(moments / 1e9, 6).tolist(),
        "low": low.tolist(),
        "step": grain,
        "shares": len(names),
        "tubes": [_plain(tube, names, digits) for tube in tubes],
        "middle": ((low + high) / 2).tolist(),
        "reach": max(0.6 * extent, 1e-6),
        "floor": float(low[2] - 0.06 * extent),
        "trails": [np.round(trail, digits).ravel().tolist() for trail in trails],
        "solids": around.solids(scene, extent, digits),
        "pushes": around.pushes(run, moments, digits),
        "legend": _legend(names, scene is None, len(run.contacts.at) > 0),
    }
    data = json.dumps(meta, separators=(",", ":"), allow_nan=False)
    licence = html.escape(_LICENCE.read_text("utf-8"))
    return (
        '<section class="card" id="view-card"><h2>The run in three dimensions</h2>'
        '<div id="view"><p>Loading …</p></div>'
        "<noscript><p>Scripts are off; the pictures below show the same run.</p></noscript>"
        f'<script type="application/json" id="view-meta">{data}</script>'
        f'<script type="text/plain" id="view-data">{_packed(numbers.tobytes())}</script>'
        f"<!-- Packed below: three.js r170, unchanged.\n{licence}-->"
        f'<script type="text/plain" id="view-library">{_packed(_LIBRARY.read_bytes())}</script>'
        f"<script>{_PROGRAM.read_text('utf-8')}</script></section>"
    )


def _plain(tube: RecordedTube, names: list[str], digits: int) -> dict[str, object]:
    rings = np.round(tube.rings.reshape(len(tube.at), -1), digits).tolist()
    index = -1 if tube.actuator is None else names.index(tube.actuator)
    return {"at": tube.at, "rings": rings, "effort": index, "clear": bool(names) and index < 0}


def _upright(poses: Floats) -> Floats:
    """Return unit quaternions (…, 4), also where a recording has none."""
    quaternions = shown(poses[..., 3:])
    size = np.linalg.norm(quaternions, axis=-1, keepdims=True)
    good = np.isfinite(size) & (size > 1e-6)
    return np.where(good, quaternions / np.where(good, size, 1.0), [0.0, 0.0, 0.0, 1.0])


def _shares(run: Run, time_ns: NDArray[np.int64], names: list[str]) -> Floats:
    """Return what part of its largest effort in this run each actuator gives, at every frame."""
    out = np.zeros((len(time_ns), len(names)))
    joints = run.joint_states
    if not joints.effort.size:
        return out
    at = np.searchsorted(joints.time_ns, time_ns).clip(0, len(joints) - 1)
    for column, name in enumerate(names):
        if name in joints.name:
            effort = np.nan_to_num(shown(joints.effort[:, joints.name.index(name)]))
            out[:, column] = effort[at] / (np.abs(effort).max() or 1.0)
    return out


def _legend(names: list[str], blind: bool, touches: bool) -> str:
    if blind:
        return "The recording has no scene that can be read: the thickness is made up."
    words = []
    if names:
        words.append(
            "Tendons and chambers: blue without effort, orange at their largest in this run."
        )
    if touches:
        words.append("Arrows are forces of contacts: green where they stick, red where not.")
    return " ".join(words)


def _packed(data: bytes) -> str:
    return base64.b64encode(gzip.compress(data, 9, mtime=0)).decode()
