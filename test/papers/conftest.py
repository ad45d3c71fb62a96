"""Let the tests of the papers use the helpers beside them, those of test/core, and benchmarks."""

import sys
from pathlib import Path

HERE = Path(__file__).parent

sys.path.insert(0, str(HERE))
sys.path.insert(0, str(HERE.parent / "core"))
# the benchmarks are not installed; last, so that an installed package stays the one that is tested
sys.path.append(str(HERE.parents[1]))
