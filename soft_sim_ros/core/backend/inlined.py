"""Compilation of functions that are always inlined, without optimisation or machine code.

Numba would optimise every function as a library of its own, together with all that it calls, and
make machine code of it, again at every level of the tree of calls. Functions that are always
inlined need none of that: they are linked into the unit that calls them, and optimised there.
"""

from __future__ import annotations

from typing import Any

import numba
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.compiler_machinery import register_pass
from numba.core.typed_passes import NativeLowering

_dynfunc: Any = numba._dynfunc  # type: ignore[attr-defined]
_library: Any = JITCodeLibrary
_lowering: Any = NativeLowering
_pass: Any = register_pass


class _Inlined(_library):
    """A library that is linked into others."""

    def _optimize_final_module(self) -> None:
        """Do nothing: the calling unit optimises."""

    def _finalize_final_module(self) -> None:
        """Make no machine code."""
        self._finalize_dynamic_globals()
        self._finalized = True


@_pass(mutates_CFG=True, analysis_only=False)
class _Lowering(_lowering):
    """Lower to LLVM's intermediate representation only."""

    _name = "inlined_lowering"

    def run_pass(self, state: Any) -> bool:
        """Lower a function into a library of the above kind."""
        state.library = _Inlined(state.targetctx.codegen(), state.func_id.func_qualname)
        state.flags.no_compile = True
        super().run_pass(state)
        result = state["cr"]
        # numba tells functions apart by their entry points: this one is never called
        entry = _dynfunc.make_function(
            result.fndesc.lookup_module(), result.fndesc.qualname.split(".")[-1], "", 0,
            result.env, (state.library,),
        )  # fmt: skip
        state.targetctx.insert_user_function(entry, result.fndesc, [state.library])
        state["cr"] = result._replace(cfunc=entry)
        return True


class InlinedCompiler(CompilerBase):
    """The pipeline of functions that are always inlined."""

    def define_pipelines(self) -> list[Any]:
        """Return numba's own pipeline with another last stage."""
        manager = DefaultPassBuilder.define_nopython_pipeline(self.state)
        manager.add_pass_after(_Lowering, NativeLowering)
        manager.passes = [entry for entry in manager.passes if entry[0] is not NativeLowering]
        manager.finalize()
        return [manager]
