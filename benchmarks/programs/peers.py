"""Peers run as child processes: what they cannot do, what they were run with, what came out."""

from __future__ import annotations

import json
import os
import signal
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..cases import Case
from ..cases.case import STRAINS
from .environments import PINS, clean, interpreter

HERE = Path(__file__).parent
PEERS = {
    "pyelastica": "PyElastica", "soromox": "SoRoMoX", "exudyn": "Exudyn", "mujoco": "MuJoCo",
}  # fmt: skip
ENVIRONMENT = {
    "pyelastica": "elastica", "soromox": "soromox", "exudyn": "exudyn", "mujoco": "mujoco",
}  # fmt: skip
# CPU s for one timed run, and for all runs of one case with everything that surrounds them
LIMITS = {
    "pyelastica": (75, 160), "soromox": (60, 150), "exudyn": (10, 35), "mujoco": (10, 35),
}  # fmt: skip


def version(program: str) -> str:
    """Return the pinned version of a peer."""
    return PINS[ENVIRONMENT[program]][0].partition("==")[2]


def prepare(programs: list[str]) -> None:
    """Make the environments of peers where they are missing, before anything is timed."""
    for program in programs:
        if program in ENVIRONMENT:
            interpreter(ENVIRONMENT[program])


def unsupported(program: str, case: Case) -> str:
    """Return why a peer cannot do a case, or nothing."""
    if program == "pyelastica":
        if case.tendon:
            return "PyElastica has no tendons"
        if case.name == "gvs":
            return "PyElastica cannot lock strains: its rods always shear and twist"
    if program == "exudyn" and case.tendon:
        return "Exudyn has no tendon of given tension along a curve"
    return ""


def differences(program: str, case: Case) -> str:
    """Return where the physics of a peer's run is not quite the case's."""
    if program == "pyelastica":
        text = "rotary inertia depends on dilatation; Kelvin–Voigt and linear law added by us"
        if set(case.strains) != set(STRAINS):
            text += "; all six strains are free"
        return text
    if program == "exudyn" and case.name in ("spatial_pcs", "gvs"):
        return "in the plane of its gravity; the other programs' runs are in space"
    return ""


def runs(
    program: str, case: Case, settings: list[dict[str, Any]], tell: Callable[[dict[str, Any]], None]
) -> float:
    """Run a peer on a case, ``tell`` one result per setting; return CPU s, all included.

    What the time allowed does not reach is said to be skipped.
    """
    each, everything = LIMITS[program]
    python = interpreter(ENVIRONMENT[program])
    command = [str(python), str(HERE / f"child_{program}.py")]
    child = subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=clean()
    )
    assert child.stdin is not None and child.stdout is not None
    job = {"case": case.as_dict(), "settings": settings, "limit": each, "everything": everything}
    json.dump(job, child.stdin)
    child.stdin.close()
    done = 0
    try:
        for line in child.stdout:
            done += 1
            tell(json.loads(line))
    except BaseException:
        child.kill()
        raise
    finally:
        _, status, usage = os.wait4(child.pid, 0)
        child.returncode = code = os.waitstatus_to_exitcode(status)
    late = code in (-signal.SIGXCPU, -signal.SIGKILL)
    why = f"all runs of the case took {everything} s" if late else f"child ended with {code}"
    for left in settings[done:]:
        outcome = "skipped" if late else "refused"
        tell({"settings": left, "outcome": outcome, "reason": why, "wall_s": None, "tip": []})
    return usage.ru_utime + usage.ru_stime
