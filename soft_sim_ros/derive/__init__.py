"""Scalar equations of motion of a Cosserat rod by computer algebra.

Curvilinear Systems 2006, end of section 4.

Needs SymPy, the extra ``derive``.
"""

from soft_sim_ros.errors import MissingExtra

try:
    import sympy  # noqa: F401
except ImportError as error:
    raise MissingExtra("deriving equations", "sympy", "derive") from error

from soft_sim_ros.derive.equations import Derivation, derive
from soft_sim_ros.derive.printing import as_latex, as_python, as_text

__all__ = ["Derivation", "as_latex", "as_python", "as_text", "derive"]
