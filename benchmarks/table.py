"""The tables of docs/benchmarks.md and README.md, written from the result files into the pages."""

from __future__ import annotations

import json
import textwrap
from pathlib import Path
from statistics import median
from typing import Any

from . import fronts
from .cases import CASES
from .programs.peers import PEERS
from .reference import RESULTS

ROOT = Path(__file__).resolve().parent.parent
ERRORS = (1e-3, 1e-5)
OURS = "soft_sim_ros"
# the settling arm: error over its length and wall s for its 10 s
BAR = ("heavy_arm", 1e-4, 0.1)


def wrapped(lines: list[str], width: int = 100) -> str:
    """Return lines as text whose paragraphs, but not tables, are at most this wide."""
    out = []
    for line in lines:
        short = line.startswith("|") or len(line) <= width
        out += [line] if short else textwrap.wrap(line, width, break_on_hyphens=False)
    return "\n".join(out)


def seconds(value: float | None) -> str:
    """Return a time with two digits."""
    if value is None:
        return "not reached"
    if value >= 99.5:
        return f"{float(f'{value:.2g}'):,.0f} s"
    return f"{value * 1e3:.2g} ms" if value < 0.0995 else f"{value:.2g} s"


def times(ratio: float) -> str:
    """Return a ratio with two digits and no exponent."""
    return f"{float(f'{ratio:.2g}'):,.0f}×" if ratio >= 9.95 else f"{ratio:.2g}×"


def best_of(entries: fronts.Entries) -> dict[str, Any] | None:
    """Return the run of the least error."""
    done = [e for e in entries if e["outcome"] == "completed" and e["error_rel"]]
    return min(done, key=lambda e: float(e["error_rel"]), default=None)


def peer_cell(entries: fronts.Entries, mine: float | None, error: float) -> str:
    """Return a peer's cost at an error and the ratio to ours, or how far it got, or why not."""
    outcomes = {entry["outcome"] for entry in entries}
    if not entries:
        return "–"
    if outcomes == {"unsupported"}:
        return "unsupported"
    best = best_of(entries)
    if best is None:
        return "/".join(sorted(outcomes))
    cost = fronts.cost_at(entries, error)
    if cost is None:
        beyond = fronts.beyond(entries, error)
        more = f" ({seconds(beyond)} by its order)" if beyond else ""
        return f"no: {best['error_rel']:.0e} in {seconds(fronts.cost(best))}{more}"
    return seconds(cost) + (f" ({times(cost / mine)})" if mine else "")


def best_peer(entries: fronts.Entries, case: str, error: float) -> tuple[float, str] | None:
    """Return (s, name) of the fastest peer that reaches an error; None where none does."""
    costs = [
        (fronts.cost_at(fronts.of(entries, case, p), error), name) for p, name in PEERS.items()
    ]
    return min(((cost, name) for cost, name in costs if cost is not None), default=None)


def cases_in(entries: fronts.Entries) -> list[str]:
    """Return the names of the cases that were run, in order."""
    return [case for case in CASES if any(e["case"] == case for e in entries)]


def unresolved(entries: fronts.Entries, case: str, error: float) -> str:
    """Return a remark where the reference of a case does not resolve an error."""
    known = next(float(e["reference_agreement"]) for e in entries if e["case"] == case)
    return f"reference agrees to {known:.0e} only" if known > 0.2 * error else ""


def table_at(entries: fronts.Entries, error: float) -> list[str]:
    """Return the lines about one error."""
    lines = [
        f"Time on one core to a largest tip error of {error:.0e} of the length; in brackets, how",
        'many times ours; "no": the least error within the time allowed, and its time, and the',
        "time that its observed order makes of it at the error asked for:",
        "",
        f"| case | {OURS} | " + " | ".join(PEERS.values()) + " | best peer ÷ ours |",
        "|---|---|" + "---|" * len(PEERS) + "---|",
    ]
    ratios: list[float] = []
    for case in cases_in(entries):
        remark = unresolved(entries, case, error)
        mine = fronts.cost_at(fronts.of(entries, case, OURS), error)
        cells = [peer_cell(fronts.of(entries, case, peer), mine, error) for peer in PEERS]
        found, ratio = best_peer(entries, case, error), "–"
        if found and mine and not remark:
            ratios.append(found[0] / mine)
            ratio = f"{times(ratios[-1])} ({found[1]})"
        lines.append(f"| {case} | {remark or seconds(mine)} | {' | '.join(cells)} | {ratio} |")
    if ratios:
        lines += [
            "",
            f"Against the best peer: median {times(median(ratios))}, least "
            f"{times(min(ratios))}, most {times(max(ratios))}, over the {len(ratios)} cases where "
            "a peer gets there.",
        ]
    else:
        lines += ["", "No peer gets there within the time allowed."]
    return [*lines, ""]


def bar_text(entries: fronts.Entries) -> list[str]:
    """Return the line on the settling arm."""
    case, error, allowed = BAR
    done = [
        e for e in fronts.of(entries, case, OURS)
        if e["outcome"] == "completed" and e["error_rel"] <= error
    ]  # fmt: skip
    if not done:
        return []

    def best(some: fronts.Entries) -> str:
        run = min(some, key=lambda e: float(e["wall_s"]))
        return f"{seconds(run['wall_s'])} of wall time, error {run['error_rel']:.1e}"

    said = f"The bar of {case}, {error:.0e} in {allowed:g} s for its 10 s: {best(done)}"
    spatial = [e for e in done if "strains" not in e["settings"]]
    if spatial:
        said += f"; with all six strains free {best(spatial)}"
    peers = [
        f"{label} {peer_cell(fronts.of(entries, case, peer), None, error)}"
        for peer, label in PEERS.items()
    ]
    return [f"{said}. {'; '.join(peers)}.", ""]


def measured_with(entries: fronts.Entries) -> str:
    """Return versions and machines."""
    machines = {
        f"{m['cpu']}, {m['cores']} cores, Python {m['python']}, numpy {m['numpy']}, numba "
        f"{m['numba']}, commit {m['commit']}"
        for m in (e["machine"] for e in entries)
    }
    versions = sorted({f"{e['program']} {e['version']}" for e in entries})
    return "Measured with " + ", ".join(versions) + "; " + "; ".join(sorted(machines)) + "."


def text(entries: fronts.Entries) -> str:
    """Return the tables of the page on benchmarks."""
    lines = [line for error in ERRORS for line in table_at(entries, error)]
    lines += bar_text(entries) + convergence_text() + scaling_text()
    return wrapped([*lines, measured_with(entries)])


def short_text(entries: fronts.Entries) -> str:
    """Return the table of the README: ours against the best peer."""
    heads = [f"{error:.0e} of the length, ours | best peer" for error in ERRORS]
    lines = ["| case | " + " | ".join(heads) + " |", "|---|" + "---|---|" * len(ERRORS)]
    for case in cases_in(entries):
        cells = []
        for error in ERRORS:
            mine = fronts.cost_at(fronts.of(entries, case, OURS), error)
            found = best_peer(entries, case, error)
            if unresolved(entries, case, error):
                cells += ["–", "–"]
                continue
            if found:
                cost, name = found
                theirs = f"{name} {seconds(cost)}" + (f" ({times(cost / mine)})" if mine else "")
            else:
                theirs = nearest(entries, case)
            cells += [seconds(mine), theirs]
        lines.append(f"| {case} | " + " | ".join(cells) + " |")
    return wrapped([*lines, "", measured_with(entries)])


def nearest(entries: fronts.Entries, case: str) -> str:
    """Return how near the peer of the least error comes."""
    best = [(best_of(fronts.of(entries, case, peer)), name) for peer, name in PEERS.items()]
    least = min(((float(e["error_rel"]), name) for e, name in best if e), default=None)
    return "none" if least is None else f"none (least error {least[0]:.0e}, {least[1]})"


def convergence_text() -> list[str]:
    """Return the table of rates at which bases converge."""
    file = RESULTS / "convergence.json"
    if not file.is_file():
        return []
    rates = json.loads(file.read_text())["rates"]
    lines = ["Convergence in space, error against coordinates:", ""]
    lines += ["| basis | " + " | ".join(rates) + " |", "|---|" + "---|" * len(rates)]
    for basis in next(iter(rates.values())):
        cells = []
        for case in rates:
            ((what, value),) = rates[case][basis].items()
            cells.append(f"÷ {value:.2g} per order" if "order" in what else f"n^−{value:.2g}")
        lines.append(f"| {basis} | " + " | ".join(cells) + " |")
    return [*lines, ""]


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


def put(page: Path, what: str, mark: str = "table") -> None:
    """Put a text between the marks of a page; a page without marks stays as it is."""
    begin, end = f"<!-- {mark}: begin -->", f"<!-- {mark}: end -->"
    if page.is_file() and begin in (old := page.read_text()):
        head, _, rest = old.partition(begin)
        _, _, tail = rest.partition(end)
        page.write_text(f"{head}{begin}\n{what}\n{end}{tail}")


def main() -> None:
    """Print the tables, and put them into the pages."""
    file = RESULTS / "work_precision.json"
    if not file.is_file():
        return
    entries = json.loads(file.read_text())
    print(text(entries))
    put(ROOT / "docs" / "benchmarks.md", text(entries))
    put(ROOT / "README.md", short_text(entries))


if __name__ == "__main__":
    main()
