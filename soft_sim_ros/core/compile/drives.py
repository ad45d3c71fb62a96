"""Motions of driven joints as the programs of model.py."""

from __future__ import annotations

import ast
from collections.abc import Sequence

import numpy as np

from soft_sim_ros.core.model.model import Drives, new_live
from soft_sim_ros.core.model.packing import floats, ints
from soft_sim_ros.core.terms.driven import COMMANDED, OPERATIONS, TABLE, known_motion
from soft_sim_ros.errors import SceneError
from soft_sim_ros.scene import Joint, Scene
from soft_sim_ros.scene.driven import Commanded, Course, TimeTable

from .chain import Chain

Step = tuple[int, float]
_WORDS = {
    ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.Pow: "**",
    ast.USub: "negative",
}  # fmt: skip


def courses(scene: Scene) -> list[Course]:
    """Return what all driven coordinates of a scene are told, in their order."""
    return [c for body in scene.bodies if isinstance(body, Joint) for c in body.driven]


def refuse_undriven(scene: Scene) -> None:
    """Refuse methods that cannot follow driven joints.

    Raises
    ------
    SceneError
        for ``energy_midpoint``, which changes velocities to close the ledger; for commands that
        are to be reached within less than a step
    """
    for name, course in scene.commanded.items():
        if course.within < scene.numerics.step * (1.0 - 1e-9):
            expected = f"at least the step of {scene.numerics.step:g} s, which has to show the way"
            joint = name.partition("/")[0]
            raise SceneError(scene.file, f"bodies.{joint}.driven.within", course.within, expected)
    if scene.numerics.integrator == "energy_midpoint" and courses(scene):
        expected = "another integrator: this one changes velocities, those of driven joints as well"
        raise SceneError(scene.file, "numerics.integrator", scene.numerics.integrator, expected)


def flat_drives(scene: Scene, chain: Chain) -> Drives:
    """Return the programs of all driven coordinates.

    Raises
    ------
    SceneError
        if a formula has no rate or no acceleration at the start
    """
    drives = flat_courses(courses(scene), [column for column, _ in chain.driven])
    _refuse_kinks(scene, drives)
    return drives


def flat_courses(told: Sequence[Course], columns: Sequence[int]) -> Drives:
    """Return the programs of courses, each with its column."""
    programs: list[list[Step]] = []
    tables: list[np.ndarray] = []
    for course in told:
        if isinstance(course, TimeTable):
            programs.append([(TABLE, float(len(tables)))])
            tables.append(_rows(course))
        elif isinstance(course, Commanded):
            plus = OPERATIONS["+"], 0.0
            programs.append([(COMMANDED, 0.0), (OPERATIONS["number"], course.start), plus])
        else:
            programs.append(_program(course.expression.tree))
    steps = [step for program in programs for step in program]
    return Drives(
        column=ints(columns),
        ptr=ints([0, *np.cumsum([len(program) for program in programs])]),
        operation=ints([operation for operation, _ in steps]),
        operand=floats([operand for _, operand in steps]),
        table_ptr=ints([0, *np.cumsum([len(table) for table in tables])]),
        table=floats(np.concatenate(tables) if tables else np.zeros((0, 5))),
    )


def _rows(course: TimeTable) -> np.ndarray:
    """Return (N + 1, 5) pieces of a table; the first and the last are constant."""
    first, last = course.values[0], course.values[-1]
    rows = np.column_stack([course.times[:-1], course.spline])
    before, after = [course.times[0] - 1.0, first, 0, 0, 0], [course.times[-1], last, 0, 0, 0]
    return np.vstack([before, rows, after])


def _program(node: ast.expr) -> list[Step]:
    """Return the steps that leave the value of a formula on the stack."""
    if isinstance(node, ast.Constant):
        return [(OPERATIONS["number"], float(node.value))]  # type: ignore[arg-type]
    if isinstance(node, ast.Name):
        return [(OPERATIONS["t"], 0.0) if node.id == "t" else (OPERATIONS["number"], np.pi)]
    if isinstance(node, ast.BinOp):
        word = _WORDS[type(node.op)]
        return [*_program(node.left), *_program(node.right), (OPERATIONS[word], 0.0)]
    if isinstance(node, ast.UnaryOp):
        inner = _program(node.operand)
        return inner if isinstance(node.op, ast.UAdd) else [*inner, (OPERATIONS["negative"], 0.0)]
    assert isinstance(node, ast.Call) and isinstance(node.func, ast.Name)
    return [*_program(node.args[0]), (OPERATIONS[node.func.id], 0.0)]


def _refuse_kinks(scene: Scene, drives: Drives) -> None:
    index, course_of = 0, new_live(0, len(drives.column)).course
    for body in scene.bodies:
        for course in body.driven if isinstance(body, Joint) else ():
            found = np.zeros(3)
            known_motion(drives, course_of, index, 0.0, found)
            if not np.isfinite(found).all():
                what = getattr(course, "expression", None)
                expected = "a formula with a rate and an acceleration at t = 0"
                text = what.text if what is not None else "(table)"
                raise SceneError(scene.file, f"bodies.{body.name}.driven", text, expected)
            index += 1
