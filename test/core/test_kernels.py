"""Kernels that Python calls are compilation units: inlined ones cannot be called from Python."""

import ast
from importlib import import_module
from pathlib import Path

import pytest

import soft_sim_ros
from soft_sim_ros.core.algebra import dual
from soft_sim_ros.core.recursion import rnea

PACKAGE = Path(soft_sim_ros.__file__).parent
# of core/: where kernels stand
KERNELS = ("algebra", "contact", "terms", "recursion", "integrators")


def of_kernels(module):
    """Return whether a module, named from the package on, is one of kernels."""
    return any(module.startswith(f"soft_sim_ros.core.{room}.") for room in KERNELS)


def imported_kernels():
    """Yield (file, module, name) of everything the package imports from its kernels."""
    for file in sorted(PACKAGE.rglob("*.py")):
        if file.parent.name in KERNELS:
            continue
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and of_kernels(node.module or ""):
                for name in node.names:
                    yield file, node.module, name.name


def test_python_calls_units_only():
    names = list(imported_kernels())
    assert len(names) > 20
    inlined = []
    for file, module, name in names:
        options = getattr(getattr(import_module(module), name), "targetoptions", {})
        compiled_there = "@unit" in file.read_text(encoding="utf-8")
        if options.get("no_cpython_wrapper") and not compiled_there:
            inlined.append(f"{file.name}: {name}")
    assert inlined == []


@pytest.mark.parametrize("kernel", [dual.add, rnea.strains], ids=["algebra", "kernel"])
def test_a_kernel_called_from_python_says_so(kernel):
    with pytest.raises(TypeError, match=rf"{kernel.__name__} is inlined .* Python can call units"):
        kernel((0.0, 0.0, 0.0), (1.0, 2.0, 3.0))
