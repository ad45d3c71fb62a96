import importlib
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
DATA = Path(__file__).parent / "data"


@pytest.fixture(scope="session", autouse=True)
def tree_on_path():
    """The benchmarks are not installed: they are imported from the source tree."""
    sys.path.insert(0, str(ROOT))
    yield
    sys.path.remove(str(ROOT))


@pytest.fixture(scope="session")
def module(tree_on_path):
    """Modules of the package of comparisons, by name."""
    return lambda name: importlib.import_module(f"benchmarks.validation.{name}")


@pytest.fixture(scope="session")
def data():
    return DATA
