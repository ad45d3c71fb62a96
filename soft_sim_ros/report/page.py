"""One self-contained HTML page about one run."""

from __future__ import annotations

import base64
import html
import io
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from soft_sim_ros.errors import RecordingError
from soft_sim_ros.files import write_whole
from soft_sim_ros.foreign import printable
from soft_sim_ros.recording.claims import scene_name
from soft_sim_ros.recording.reader import Run, read_run
from soft_sim_ros.report import numbers, view
from soft_sim_ros.report.shapes import shapes_of
from soft_sim_ros.report.style import RC

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_METADATA = {"svg": {"Date": None}, "png": {"Software": None}}  # equal runs, equal bytes
_CSS = """
:root { --ink: #1d2733; --soft: #66717d; --line: #e3e8ed; --accent: #0072b2; }
* { box-sizing: border-box; }
body { margin: 0; background: #f4f6f8; color: var(--ink);
  font: 15px/1.5 system-ui, -apple-system, "Segoe UI", Roboto, "Helvetica Neue", sans-serif; }
main { max-width: 1080px; margin: 0 auto; padding: 28px 20px 60px; }
h1 { font-size: 26px; line-height: 1.2; margin: 0; }
h2 { font-size: 16px; margin: 0 0 10px; }
.sub { color: var(--soft); margin: 4px 0 22px; overflow-wrap: anywhere; }
.card { background: #fff; border: 1px solid var(--line); border-radius: 8px;
  padding: 18px 20px; margin: 0 0 18px; }
.card img { display: block; width: 100%; height: auto; }
.tables { display: grid; grid-template-columns: repeat(auto-fit, minmax(300px, 1fr)); gap: 18px; }
.tables .card { margin: 0; }
.tables { margin-bottom: 18px; }
table { border-collapse: collapse; width: 100%; font-size: 13.5px; }
th, td { text-align: left; padding: 4px 0; border-top: 1px solid var(--line);
  vertical-align: top; overflow-wrap: anywhere; }
tr:first-child th, tr:first-child td { border-top: 0; }
th { font-weight: 400; color: var(--soft); padding-right: 14px; width: 46%; }
td { font-variant-numeric: tabular-nums; }
.note { border-left: 4px solid #d55e00; background: #fff6ef; padding: 10px 14px;
  border-radius: 4px; margin: 0 0 18px; }
.note p { margin: 0; }
details.more { margin: 0 0 18px; } details.more .tables { margin-top: 12px; }
summary { cursor: pointer; font-weight: 600; }
pre { font: 12.5px/1.45 ui-monospace, SFMono-Regular, Menlo, Consolas, monospace;
  overflow-x: auto; margin: 12px 0 0; }
@media (max-width: 560px) {
  main { padding: 16px 10px 40px; } .card { padding: 12px; } h1 { font-size: 21px; }
  .wide { overflow-x: auto; } .wide img { min-width: 620px; } }
@media print { body { background: #fff; } .card { break-inside: avoid; } }
"""


def write_report(run_directory: str | Path, out: str | Path | None = None) -> Path:
    """Write one HTML page about a run: pictures, numbers, scene; nothing is loaded from outside.

    Parameters
    ----------
    run_directory : rosbag2 directory, or one MCAP file; a ``summary.json`` beside it is used
    out : file to write, ``report.html`` beside the recording if not given

    Returns
    -------
    Path
        the page
    """
    source = Path(run_directory)
    run = read_run(source)
    folder = source.parent if source.is_file() else source
    path = Path(out) if out is not None else folder / "report.html"
    path.parent.mkdir(parents=True, exist_ok=True)
    write_whole(path, _page(run, numbers.read_summary(folder)))
    return path


def picture(run: Run | str | Path, path: str | Path) -> Path:
    """Write one PNG of the motion.

    Parameters
    ----------
    run : the recording, or where it lies
    path : file to write

    Raises
    ------
    RecordingError
        if the recording holds no backbone
    """
    run = run if isinstance(run, Run) else read_run(run)
    if len(run.backbone) == 0:
        raise RecordingError(run.path, "cannot be drawn: it holds no backbone messages")
    from soft_sim_ros.report.motion import motion

    if not shapes_of(run).drawable.any():
        raise RecordingError(run.path, "cannot be drawn: no backbone in it has finite positions")
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    write_whole(path, drawn(lambda: motion(run), "png"))
    return path


def drawn(draw: Callable[[], Figure], kind: str) -> bytes:
    """Draw a figure in our style; neither windows nor settings of the caller are touched."""
    import matplotlib
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    stream = io.BytesIO()
    with matplotlib.rc_context(RC):
        figure = draw()
        FigureCanvasAgg(figure)
        figure.savefig(stream, format=kind, dpi=150, metadata=_METADATA[kind])
    return stream.getvalue()


def _page(run: Run, summary: dict) -> str:
    title = html.escape(_title(run))
    date = numbers.date(run)
    place = printable(str(run.path.resolve()))
    origin = f"recorded {numbers.short(date)}, {place}" if date else place
    parts = [
        f"<h1>{title}</h1>",
        f'<p class="sub">{html.escape(origin)}</p>',
        _notes(run, summary),
        view.section(run),
        _pictures(run, summary),
        '<div class="tables">',
        _table("Motion", numbers.motion_rows(run)),
        _table("Contacts and reactions", _felt_rows(run)),
        _table("Speed", numbers.speed_rows(summary)),
        _table("Accuracy", numbers.accuracy_rows(run, summary)),
        "</div>",
        '<details class="more"><summary>Machine, versions and messages</summary>'
        '<div class="tables">',
        _table("Machine and versions", numbers.machine_rows(run)),
        _table("Messages by topic", [(numbers.short(t), f"{n:,}") for t, n in run.counts.items()]),
        "</div></details>",
    ]
    if run.scene_text is not None:
        parts.append(
            '<details class="card"><summary>Scene</summary>'
            f"<pre>{html.escape(printable(run.scene_text))}</pre></details>"
        )
    body = "\n".join(part for part in parts if part)
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{title}</title>\n<style>{_CSS}{view.CSS}</style>\n</head>\n"
        f"<body>\n<main>\n{body}\n</main>\n</body>\n</html>\n"
    )


def _title(run: Run) -> str:
    """Name of the scene if it has one, else of the directory."""
    return numbers.short(scene_name(run.scene_text or "") or run.path.resolve().name)


def _notes(run: Run, summary: dict) -> str:
    """Say first what a reader must know before trusting the rest."""
    notes = []
    if run.torn:
        notes.append(f"This recording was never closed; it is readable up to {run.end:.6g} s.")
    if run.damaged_chunks:
        notes.append(f"{run.damaged_chunks} parts of the recording are damaged.")
    if odd := numbers.not_finite(run):
        notes.append(f"{odd} of the recorded states hold numbers that are not finite.")
    dropped = (summary.get("recording") or {}).get("dropped")
    if dropped:
        notes.append(f"{dropped} messages were dropped because the disk was too slow or full.")
    diverged = [text for _, text in run.events if text.startswith("diverged")]
    notes += [f"The solver gave up: {numbers.short(text)}" for text in diverged[:1]]
    if not notes:
        return ""
    return '<div class="note">' + "".join(f"<p>{html.escape(n)}</p>" for n in notes) + "</div>"


def _feels(run: Run) -> bool:
    return bool(run.reactions or len(run.contacts))


def _felt_rows(run: Run) -> numbers.Rows:
    if not _feels(run):
        return []
    from soft_sim_ros.report.felt import felt_rows

    return felt_rows(run)


def _pictures(run: Run, summary: dict) -> str:
    from soft_sim_ros.report import felt, plots
    from soft_sim_ros.report.motion import motion
    from soft_sim_ros.report.sensors import pictures as of_sensors

    pictures: list[tuple[str, bool, Callable[[], Figure]]] = [
        ("Backbone and path of the tip", bool(shapes_of(run).drawable.any()), lambda: motion(run)),
        *(
            (f"Tip {name}".rstrip(), True, partial(plots.tip, run, name))
            for name in list(numbers.tip_paths(run))[: numbers.MOST_TIPS]
        ),
        ("Actuators", bool(run.joint_states.name), lambda: plots.actuators(run)),
        ("Contacts and reactions", _feels(run), lambda: felt.felt(run)),
        ("Energy", len(run.energy) > 0, lambda: plots.energy(run)),
        (
            "Timing",
            max(len(run.backbone), len(run.joint_states)) > 1 or bool(summary.get("step_cost")),
            lambda: plots.timing(run, summary),
        ),
        *of_sensors(run),
    ]
    return "\n".join(
        f'<section class="card"><h2>{title}</h2><div class="wide"><img alt="{title}" '
        f'src="data:image/svg+xml;base64,{base64.b64encode(drawn(draw, "svg")).decode()}">'
        "</div></section>"
        for title, there, draw in pictures
        if there
    )


def _table(title: str, rows: numbers.Rows) -> str:
    if not rows:
        return ""
    lines = "".join(
        f"<tr><th>{html.escape(name)}</th><td>{html.escape(value)}</td></tr>"
        for name, value in rows
    )
    return f'<section class="card"><h2>{title}</h2><table>{lines}</table></section>'
