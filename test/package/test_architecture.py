"""Imports go one way: the tables of docs/architecture.md are the rule, for packages and in core."""

import ast
import re
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

import soft_sim_ros

PACKAGE = Path(soft_sim_ros.__file__).parent
PAGE = PACKAGE.parent / "docs" / "architecture.md"
NAME = PACKAGE.name


def modules():
    """Return module → file of the whole package."""
    found = {}
    for file in sorted(PACKAGE.rglob("*.py")):
        parts = [NAME, *file.relative_to(PACKAGE).with_suffix("").parts]
        found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = file
    return found


MODULES = modules()


def imported(module):
    """Return the modules of the package that one imports, anywhere in it and for types too."""
    file, out = MODULES[module], set()
    package = module if file.name == "__init__.py" else module.rpartition(".")[0]
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            out |= {name.name for name in node.names}
        elif isinstance(node, ast.ImportFrom):
            parts = package.split(".")[: -node.level + 1 or None] if node.level else []
            base = ".".join([*parts, *([node.module] if node.module else [])])
            whole = {f"{base}.{name.name}" for name in node.names}
            out |= {name if name in MODULES else base for name in whole}
    return {name for name in out if name in MODULES and name != module}


IMPORTS = {module: imported(module) for module in MODULES}


def table(head):
    """Return the rows of the table of the page that begins with a head: names → what they may."""
    lines = PAGE.read_text(encoding="utf-8").split(head, 1)[1].splitlines()[2:]
    rows = {}
    for line in lines:
        if not line.startswith("|"):
            break
        names, may = (cell.strip() for cell in line.split("|")[1:3])
        for name in re.findall(r"`\.?([\w.]+)`", names):
            rows[name.removeprefix(f"{NAME}.")] = set(re.findall(r"[\w.]+", may))
    return rows


def place(module, depth):
    """Return where a module stands: the part of its name at a depth, or None above that."""
    parts = module.split(".")
    return parts[depth] if len(parts) > depth else None


@pytest.mark.parametrize(
    ("head", "within", "depth"),
    [("| package | may import | holds |", NAME, 1), ("| room | may import | holds |", "core", 2)],
    ids=["packages", "core"],
)
def test_whatever_is_imported_is_in_the_table(head, within, depth):
    rows = table(head)
    wrong, there = [], set()
    for module, names in IMPORTS.items():
        own = place(module, depth)
        if own is None or module.split(".")[depth - 1] != within or own == "__main__":
            continue
        there.add(own)
        for name in names:
            other = place(name, depth)
            if name.split(".")[depth - 1] != within or other in (None, own):
                continue
            if other not in rows.get(own, set()):
                wrong.append(f"{module} imports {name}")
    assert wrong == []
    assert there == set(rows)


def test_no_module_imports_itself_by_way_of_others():
    try:
        TopologicalSorter(IMPORTS).prepare()
    except CycleError as error:
        pytest.fail(" imports ".join(error.args[1]))


def test_only_the_node_and_its_verbs_import_ros():
    for module, file in MODULES.items():
        names = {
            name
            for node in ast.walk(ast.parse(file.read_text(encoding="utf-8")))
            if isinstance(node, ast.Import | ast.ImportFrom)
            for name in ([node.module or ""] if isinstance(node, ast.ImportFrom) else
                         [alias.name for alias in node.names])
        }  # fmt: skip
        if any(name.split(".")[0] == "rclpy" for name in names):
            assert module.split(".")[1] in ("node", "commands"), module
