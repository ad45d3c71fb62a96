"""The tables of docs/validation.md and the short one of README.md, written from what was found."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..table import ROOT, put, wrapped
from .bank import LICENCE, SOURCE

Found = dict[str, Any]
COMMAND = "python -m benchmarks.validation --only "


def size(value: float | None) -> str:
    """Return an error with two digits."""
    return "–" if value is None else f"{value:.1e}"


def overview(found: Found) -> list[tuple[str, str, str, str, str, str]]:
    """Return rows: judged by, what, our error, its own accuracy, source and licence, command."""
    rows = []
    if "sorosim_statics" in found:
        one = found["sorosim_statics"]
        rows.append((
            "SoRoSim", f"{one['shapes']} static shapes of a rod of TPU",
            f"median {size(one['median'])}, worst {size(one['worst'])}; ours alone "
            f"{size(max(row['ours'] for row in one['checked']))}",
            f"{size(max(row['theirs'] for row in one['checked']))}: four decimals",
            f"{SOURCE}, {LICENCE}", COMMAND + "sorosim_statics --bank DIR",
        ))  # fmt: skip
    if "sorosim_releases" in found:
        one = found["sorosim_releases"]
        rows.append((
            "SoRoSim", f"{one['releases']} releases of 10 s",
            f"median {size(one['median'])}, worst {size(one['worst'])}; ours alone "
            f"{size(one['ours'])}", "5e-4 at the start: four decimals",
            f"{SOURCE}, {LICENCE}", COMMAND + "sorosim_releases --bank DIR",
        ))  # fmt: skip
    if "princeton" in found:
        worst = found["princeton"]["worst"]
        rows.append((
            "ANSYS (beam)", "Princeton beam, 14 tips", size(worst["ansys_beam"]), "not known",
            "Obrezkov, Mikkola, Matikainen, Nonlinear Dyn. 109 (2022), in Exudyn's tests",
            COMMAND + "princeton",
        ))  # fmt: skip
        rows.append((
            "ANSYS (solid)", "the same", size(worst["ansys_solid"]), "a solid is not a beam",
            "the same", COMMAND + "princeton",
        ))  # fmt: skip
        rows.append((
            "Exudyn, 16 elements", "the same, their torsion constant", size(worst["exudyn16"]),
            "6e-4: 16 elements", "Exudyn's tests, BSD-3-Clause", COMMAND + "princeton",
        ))  # fmt: skip
    rows += [
        (row["name"], f"Bathe's 45° bend, {row['axis']}", size(row["error"]),
         size(row["own_accuracy"]) + ": digits", row["source"], COMMAND + "bathe")
        for row in found.get("bathe", {"rows": []})["rows"]
    ]  # fmt: skip
    for name, title in (("flight", "beam in free flight"), ("elbow", "elbow, 30 s in space")):
        if name in found:
            one = found[name]
            rows.append((
                "Exudyn 1.13.6", f"Simo and Vu-Quoc's {title}", size(one["error"]),
                f"{size(one['own_accuracy'])}: extrapolation", one["theirs"], COMMAND + name,
            ))  # fmt: skip
    if "flight" in found:
        one = found["flight"]
        rows.append((
            "impulse of the load", "momentum of the beam in flight", size(one["momentum_error"]),
            "exact", "closed form", COMMAND + "flight",
        ))  # fmt: skip
    if "elbow" in found:
        curves = found["elbow"]["figure"]
        rows.append((
            "Simo, Vu-Quoc 1988", "elbow, printed curves",
            f"rms {size(max(curve['rms'] for curve in curves.values()))}",
            "a figure; Exudyn is as far from it", "digitised by AeroBeams, MIT", COMMAND + "elbow",
        ))  # fmt: skip
    for row in found.get("cosseratbench", []):
        said = size(row["score"]) if row["outcome"] == "completed" else row["outcome"]
        rows.append((
            "cosseratbench 0.3", row["experiment"], said, row["floor"], "PyPI, Apache-2.0",
            COMMAND + "cosseratbench",
        ))  # fmt: skip
    rows.append(("a real tendon-driven arm", "tip against tendon pulls", "not identified yet",
                 "–", "motion capture", "–"))  # fmt: skip
    return rows


def table(head: tuple[str, ...], rows: list[tuple[str, ...]]) -> list[str]:
    """Return the lines of a table and an empty one."""
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return [*lines, *("| " + " | ".join(row) + " |" for row in rows), ""]


def sorosim_text(found: Found) -> list[str]:
    """Return what is ours and what is theirs in SoRoSim's bank."""
    lines: list[str] = []
    if "sorosim_statics" in found:
        one = found["sorosim_statics"]
        rows = [
            (row["shape"], size(row["difference"]), size(row["ours"]), size(row["theirs"]),
             size(row["within_digits"]))
            for row in one["checked"]
        ]  # fmt: skip
        parts = np.array([[row["theirs"], row["within_digits"]] for row in one["checked"]])
        lines += [
            f"**SoRoSim, statics.** {one['shapes']} shapes, {one['cpu_s']:.0f} s of CPU time: "
            f"median {size(one['median'])}, worst {size(one['worst'])} of the length "
            f"({one['worst_shape']}). {len(rows)} of them against the boundary-value problem:",
            "",
            *table(("shape", "difference", "ours to the problem", "theirs to the problem",
                    "difference with loads within their digits"), rows),
            f"Theirs is {size(float(np.median(parts[:, 0])))} from the boundary-value problem of "
            "the loads in the file, and these have four decimals. With other loads that round to "
            f"the same numbers it falls to {size(float(np.median(parts[:, 1])))} (medians); "
            "positions of four decimals leave up to 2.2e-04.",
            "",
        ]  # fmt: skip
    if "sorosim_releases" in found:
        one = found["sorosim_releases"]
        rows = [
            (row["release"], f"{row['damping_s']:g}", f"{row['swing']:.2f}",
             size(row["tip_worst"]), size(row["tip_rms"]), size(row["tip_first"]),
             size(row["tip_last"]), size(row["tip_worst_with_shear"]))
            for row in one["rows"]
        ]  # fmt: skip
        lines += [
            "**SoRoSim, releases.** Let go at rest, 10 s, compared 200 times per second; all but "
            "the second column over the length. Finer strains move ours by "
            f"{size(one['ours'])}. Theirs has no shear, nor has ours here: with shear the worst is "
            f"{size(one['worst_with_shear'])}.",
            "",
            *table(("release", "damping, s", "swing", "tip, worst", "tip, rms", "at the start",
                    "at the end", "worst with shear"), rows),
        ]  # fmt: skip
    return lines


def princeton_text(found: Found) -> list[str]:
    """Return the tips of the Princeton beam."""
    if "princeton" not in found:
        return []

    def pair(values: list[float]) -> str:
        return " ".join(f"{1e3 * value:.2f}" for value in values)

    rows = [
        (f"{row['force_N']:g}", f"{row['beta_deg']:g}", pair(row["own"]), pair(row["ansys_beam"]),
         pair(row["ansys_solid"]), pair(row["paper"]), pair(row["exudyn16"]))
        for row in found["princeton"]["rows"]
    ]  # fmt: skip
    return [
        "**Princeton beam**, tip along width and thickness in mm; once with the rectangle's own "
        "torsion constant, once with the 0.198 (I_y + I_z) of the paper:",
        "",
        *table(("force, N", "angle, °", "ours", "ANSYS, beam", "ANSYS, solid",
                "ours, 0.198", "Exudyn, 0.198"), rows),
    ]  # fmt: skip


def elbow_text(found: Found) -> list[str]:
    """Return first peaks of the elbow."""
    if "elbow" not in found:
        return []
    rows = [
        (name, *("{1:.2f} at {0:.2f} s".format(*curve[f"{who}_first_peak"])
                 for who in ("our", "exudyn", "figure")), size(curve["rms"]))
        for name, curve in found["elbow"]["figure"].items()
    ]  # fmt: skip
    return [
        "**Elbow**, first peak out of the plane (legs of 10), and how far the printed curve is:",
        "",
        *table(("point", "ours", "Exudyn", "printed", "printed to ours, rms over a leg"), rows),
    ]


def scores_text(found: Found) -> list[str]:
    """Return the scores of cosseratbench."""
    rows = [
        (row["experiment"], row["metric"] or "–",
         size(row["score"]) if row["outcome"] == "completed"
         else f"{row['outcome']}: {', '.join(row['missing']) or row['reason']}",
         size(row["known"]),
         row["floor"] or "–")
        for row in found.get("cosseratbench", [])
    ]  # fmt: skip
    if not rows:
        return []
    head = (
        "experiment",
        "metric",
        "our score",
        "its PyElastica and MuJoCo, the better",
        "what its reference can tell",
    )
    return ["**cosseratbench**, at its default settings:", "", *table(head, rows)]


def measured_with(kept: Found) -> str:
    """Return machines and commits."""
    machines = {
        f"{m['cpu']}, Python {m['python']}, numpy {m['numpy']}, commit {m['commit']}"
        for m in (part["machine"] for part in kept.values())
    }
    return "Measured with " + "; ".join(sorted(machines)) + "."


def text(kept: Found) -> str:
    """Return the tables of docs/validation.md."""
    found = {name: part["found"] for name, part in kept.items()}
    head = ("judged by", "what", "our error", "its own accuracy", "source, licence", "command")
    lines = table(head, [(*row[:5], f"`{row[5]}`") for row in overview(found)])
    lines += sorosim_text(found) + princeton_text(found) + elbow_text(found) + scores_text(found)
    return wrapped([*lines, measured_with(kept)])


def short_text(kept: Found) -> str:
    """Return the table of the README: one line per judge."""
    found = {name: part["found"] for name, part in kept.items()}
    wanted = [row for row in overview(found) if row[5] != "–" and row[2] != "unsupported"]
    return "\n".join(table(("judged by", "what", "our error", "its own accuracy"),
                           [row[:4] for row in wanted])).rstrip()  # fmt: skip


def main(kept: Found) -> None:
    """Put the tables into the pages."""
    put(ROOT / "docs" / "validation.md", text(kept), "validation")
    put(ROOT / "README.md", short_text(kept), "validation")
