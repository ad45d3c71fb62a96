"""The table of docs/benchmarks.md, printed from the result files into the page."""

from __future__ import annotations

import json
from pathlib import Path
from statistics import median

from . import fronts
from .cases import CASES
from .reference import RESULTS

PAGE = Path(__file__).resolve().parent.parent / "docs" / "benchmarks.md"
BEGIN, END = "<!-- table: begin -->", "<!-- table: end -->"
ERRORS = (1e-3, 1e-5)
PEERS = {"pyelastica": "PyElastica", "soromox": "SoRoMoX"}


def seconds(value: float | None) -> str:
    """Return a time with two digits."""
    return "not reached" if value is None else f"{value:.2g} s"


def peer_cell(entries: fronts.Entries, mine: float | None, error: float) -> str:
    """Return a peer's cost at an error and the ratio to ours, or why there is none."""
    outcomes = {entry["outcome"] for entry in entries}
    if not entries:
        return "–"
    if outcomes == {"unsupported"}:
        return "unsupported"
    if "completed" not in outcomes:
        return "/".join(sorted(outcomes))
    cost = fronts.cost_at(entries, error)
    if cost is None:
        errors = [e["error_rel"] for e in entries if e["error_rel"]]
        best = f" (best {min(errors):.0e})" if errors else ""
        return "not reached" + best
    return seconds(cost) + (f" ({cost / mine:.2g}×)" if mine else "")


def text() -> str:
    """Return the tables."""
    entries = json.loads((RESULTS / "work_precision.json").read_text())
    cases = [case for case in CASES if any(e["case"] == case for e in entries)]
    lines: list[str] = []
    for error in ERRORS:
        lines += [
            f"Time on one core to a largest tip error of {error:.0e} of the length; in brackets,",
            "how many times ours:",
            "",
            "| case | soft_sim_ros | " + " | ".join(PEERS.values()) + " |",
            "|---|---|" + "---|" * len(PEERS),
        ]
        ratios: list[float] = []
        for case in cases:
            known = next(e["reference_agreement"] for e in entries if e["case"] == case)
            if known > 0.5 * error:
                unknown = f"reference agrees to {known:.0e} only"
                lines.append(f"| {case} | {unknown} |" + " – |" * len(PEERS))
                continue
            mine = fronts.cost_at(fronts.of(entries, case, "soft_sim_ros"), error)
            cells, costs = [], []
            for peer in PEERS:
                theirs = fronts.of(entries, case, peer)
                cells.append(peer_cell(theirs, mine, error))
                cost = fronts.cost_at(theirs, error)
                costs += [cost] if cost is not None else []
            if costs and mine:
                ratios.append(min(costs) / mine)
            lines.append(f"| {case} | {seconds(mine)} | " + " | ".join(cells) + " |")
        if ratios:
            lines += [
                "",
                f"Against the better peer: median {median(ratios):.3g}×, least {min(ratios):.3g}×, "
                f"most {max(ratios):.3g}×, over the {len(ratios)} cases where a peer gets there.",
            ]
        else:
            lines += ["", "No peer gets there within the time allowed."]
        lines.append("")
    lines += scaling_text()
    machines = {
        f"{m['cpu']}, {m['cores']} cores, Python {m['python']}, numpy {m['numpy']}, numba "
        f"{m['numba']}, commit {m['commit']}"
        for m in (e["machine"] for e in entries)
    }
    versions = sorted({f"{e['program']} {e['version']}" for e in entries})
    lines += ["Measured with " + ", ".join(versions) + "; " + "; ".join(sorted(machines)) + "."]
    return "\n".join(lines)


def scaling_text() -> list[str]:
    """Return the lines on scaling."""
    file = RESULTS / "scaling.json"
    if not file.is_file():
        return []
    fits = json.loads(file.read_text())["exponents"]
    lines = ["Cost of one step against the number of elements n:", ""]
    for name, fit in fits.items():
        more = f", n^{fit['from 50 elements']:.2f} from 50 on" if "from 50 elements" in fit else ""
        lines.append(f"- {name}: n^{fit['all']:.2f} over all{more}")
    return [*lines, ""]


def main() -> None:
    """Print the tables, and put them into the page."""
    if not (RESULTS / "work_precision.json").is_file():
        return
    out = text()
    print(out)
    if PAGE.is_file():
        page = PAGE.read_text()
        head, _, rest = page.partition(BEGIN)
        _, _, tail = rest.partition(END)
        PAGE.write_text(f"{head}{BEGIN}\n{out}\n{END}{tail}")


if __name__ == "__main__":
    main()
