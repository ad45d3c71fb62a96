import importlib
from pathlib import Path

import pytest

DATA = Path(__file__).parent / "data"


@pytest.fixture(scope="session")
def module():
    """Modules of the package of comparisons, by name."""
    return lambda name: importlib.import_module(f"benchmarks.validation.{name}")


@pytest.fixture(scope="session")
def data():
    return DATA
