"""What an arm felt in a run: reactions of constraints, and contacts."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from soft_sim_ros.recording.reader import Run
from soft_sim_ros.report.numbers import Rows, short
from soft_sim_ros.report.plots import MOST_LINES, WIDTH, legend, mark_events
from soft_sim_ros.report.style import look, shown, thin

MOST_ROWS = 24


def felt(run: Run) -> Figure:
    """Draw forces and moments of constraints, and forces of all pairs that touched."""
    reactions, contacts = run.reactions, run.contacts
    titles = ["Forces of constraints", "Moments of constraints"] if reactions else []
    titles += ["Forces of contacts: normal, and friction dotted"] if len(contacts) else []
    figure = Figure(figsize=(WIDTH, 2.3 * len(titles) + 0.6), layout="constrained")
    panels = figure.subplots(len(titles), 1, sharex=True, squeeze=False)[:, 0]
    for axes, title in zip(panels, titles, strict=True):
        axes.set(title=title, ylabel="N·m" if title.startswith("Moments") else "N")
    for index, (name, series) in enumerate(list(reactions.items())[:MOST_LINES]):
        for axes, vectors in zip(panels, (series.force, series.moment), strict=False):
            size = np.linalg.norm(shown(vectors), axis=1)
            axes.plot(*thin(series.time, size), label=short(name), **look(index))
    if len(contacts):
        for index, (body, other) in enumerate(contacts.pairs[:MOST_LINES]):
            label = f"{short(body)} on {short(other)}"
            normal, friction = pair_forces(run, body, other)
            panels[-1].plot(*thin(contacts.time, shown(normal)), label=label, **look(index))
            style = look(index) | {"linestyle": ":"}
            panels[-1].plot(*thin(contacts.time, shown(friction)), **style)
    for axes in panels:
        legend(axes)
    panels[-1].set(xlabel="time (s)")
    mark_events(run, *panels)
    return figure


def pair_forces(run: Run, body: str, other: str) -> tuple[np.ndarray, np.ndarray]:
    """Return the sum of normal forces (T,) of a pair in N, and the size of its friction (T,)."""
    contacts = run.contacts
    own = (contacts.body == body) & (contacts.other == other)
    normal, friction = np.zeros(len(contacts)), np.zeros((len(contacts), 3))
    np.add.at(normal, contacts.at[own], contacts.normal_force[own])
    np.add.at(friction, contacts.at[own], contacts.friction[own])
    return normal, np.linalg.norm(friction, axis=1)


def felt_rows(run: Run) -> Rows:
    """Say how much constraints carried, and what touched."""
    rows: Rows = []
    for name, series in list(run.reactions.items())[:MOST_ROWS]:
        if len(series):
            force = np.linalg.norm(shown(series.force), axis=1).max()
            moment = np.linalg.norm(shown(series.moment), axis=1).max()
            rows.append((f"Largest at {short(name)}", f"{force:.4g} N, {moment:.4g} N·m"))
    contacts = run.contacts
    for body, other in contacts.pairs[:MOST_ROWS]:
        normal, friction = pair_forces(run, body, other)
        part = np.count_nonzero(normal) / len(contacts)
        said = f"at most {normal.max():.4g} N, friction {friction.max():.4g} N"
        rows.append((f"{short(body)} on {short(other)}", f"{said}; {part:.0%} of the time"))
    if len(contacts) and not contacts.pairs:
        rows.append(("Contacts", "none"))
    return rows
