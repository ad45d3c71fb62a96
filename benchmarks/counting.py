"""What a compiled kernel executes, counted and not guessed: without hardware counters.

The optimised LLVM code of a compiled kernel is the last text before instructions are chosen for the
processor, one for one as far as arithmetic goes: the compiler may fuse nothing by itself. A copy of
it gets a counter in every basic block and is compiled beside the original; executions times what
stands in the blocks is what was executed. Vectors count with all their lanes.
"""

from __future__ import annotations

import ctypes
import re
from collections import Counter
from typing import Any

import llvmlite.binding as llvm
import numpy as np
from numba.core.codegen import get_host_cpu_features

FLOPS = {"fadd": 1, "fsub": 1, "fmul": 1, "fdiv": 1, "frem": 1, "sqrt": 1, "fma": 2}
_DEFINE = re.compile(r"^define .*@(\"[^\"]+\"|[\w.$-]+)\(")
_LABEL = re.compile(r"^(\"[^\"]+\"|[\w.$-]+):")
_RESULT = re.compile(r"^(?:%(?:\"[^\"]+\"|[\w.$-]+) = )?(?:(?:tail|musttail|notail) )?(\w+)")
_WIDTH = re.compile(r"<(\d+) x (double|i64|ptr)>")
_INTRINSIC = re.compile(r"@llvm\.(sqrt|fma|fmuladd)\.")
_CALLEE = re.compile(r"@([\w.$]+)\(")
_LIBM = ("sin", "cos", "tan", "exp", "log", "pow", "atan2", "sincos")


def classify(line: str) -> Counter[str]:
    """Return what an instruction does: flops by kind, bytes loaded and stored, branches, others."""
    match = _RESULT.match(line)
    if not match:
        return Counter()
    opcode = match.group(1)
    vector = _WIDTH.search(line)
    lanes = int(vector.group(1)) if vector else 1
    if opcode in ("fadd", "fsub", "fmul", "fdiv", "frem"):
        return Counter({opcode: lanes, "vector": lanes if lanes > 1 else 0, "instructions": 1})
    if opcode in ("load", "store"):
        kind = line.split(" = load ")[-1] if opcode == "load" else line.split("store ", 1)[-1]
        return Counter(
            {f"{opcode}s": 1, f"{opcode}_bytes": lanes * _bytes(kind), "instructions": 1}
        )
    if opcode == "call":
        intrinsic = _INTRINSIC.search(line)
        if intrinsic:
            name = "sqrt" if intrinsic.group(1) == "sqrt" else "fma"
            flops = lanes * FLOPS[name] if lanes > 1 else 0
            return Counter({name: lanes, "vector": flops, "instructions": 1})
        callee = _CALLEE.search(line)
        name = callee.group(1) if callee else ""
        if name in _LIBM:
            return Counter({"libm": 1, "instructions": 1})
        return Counter() if name.startswith("llvm.") else Counter({"calls": 1, "instructions": 1})
    if opcode in ("br", "switch"):
        return Counter({"branches": 1, "instructions": 1})
    if opcode in ("phi", "ret", "unreachable", "bitcast", "inttoptr", "ptrtoint", "freeze"):
        return Counter()
    if opcode in ("getelementptr", "insertvalue", "extractvalue"):
        return Counter({"addresses": 1})  # mostly folded into the access
    if opcode in ("insertelement", "extractelement", "shufflevector"):
        return Counter({"shuffles": 1, "instructions": 1})
    return Counter({"others": 1, "instructions": 1})


def _bytes(text: str) -> int:
    kind = re.match(r"(?:volatile )?(?:<\d+ x )?(double|float|i\d+|ptr)", text)
    if not kind:
        return 8
    name = kind.group(1)
    return {"double": 8, "float": 4, "ptr": 8}.get(name) or max(1, int(name[1:]) // 8)


def target_machine() -> Any:
    """Return what numba compiles for: this processor, with all it has."""
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    return llvm.Target.from_default_triple().create_target_machine(
        cpu=llvm.get_host_cpu_name(),
        features=get_host_cpu_features(),
        opt=3,
        reloc="static",
        codemodel="jitdefault",
        jit=True,
    )


class Counted:
    """A copy of a compiled overload of a numba function that counts what it executes.

    Attributes
    ----------
    address : of the copy, to be called in place of the original
    """

    def __init__(self, overload: Any) -> None:
        text = str(overload.library._get_module_for_linking())
        counted, self._blocks = _instrumented(text)
        module = llvm.parse_assembly(counted)
        module.verify()
        self._engine = llvm.create_mcjit_compiler(module, target_machine())
        self._engine.finalize_object()
        self.address = self._engine.get_function_address(overload.fndesc.llvm_func_name)
        where = self._engine.get_global_value_address("counts_of_blocks")
        kind = ctypes.c_int64 * len(self._blocks)
        self._executed = np.ctypeslib.as_array(kind.from_address(where))

    def reset(self) -> None:
        """Begin at zero."""
        self._executed[:] = 0

    def counts(self) -> Counter[str]:
        """Return what was executed since, by kind; flops: their sum."""
        total: Counter[str] = Counter()
        for times, inside in zip(self._executed.tolist(), self._blocks, strict=True):
            if times:
                for kind, number in inside.items():
                    total[kind] += times * number
        total["flops"] = sum(weight * total[kind] for kind, weight in FLOPS.items())
        return total


def _instrumented(text: str) -> tuple[str, list[Counter[str]]]:
    """Return LLVM code with a counter in every basic block, and what stands in the blocks."""
    out: list[str] = []
    blocks: list[Counter[str]] = []
    inside, waiting = False, False  # in a function; at the head of a block, among its phis
    for line in text.splitlines():
        stripped = line.strip()
        if not inside:
            inside = waiting = bool(_DEFINE.match(line))
            if inside:
                blocks.append(Counter())
            out.append(line)
            continue
        if line.startswith("}"):
            inside = False
        elif _LABEL.match(line):
            if not waiting or sum(blocks[-1].values()):
                blocks.append(Counter())
            waiting = True
        elif stripped and not stripped.startswith(";"):
            if waiting and " = phi " not in line:
                out.extend(_increment(len(blocks) - 1))
                waiting = False
            blocks[-1].update(classify(stripped))
        out.append(line)
    size = len(blocks)
    out.append(f"@counts_of_blocks = global [{size} x i64] zeroinitializer")
    return "\n".join(out).replace("SIZE_OF_COUNTS", str(size)), blocks


def _increment(block: int) -> list[str]:
    array = "[SIZE_OF_COUNTS x i64], ptr @counts_of_blocks"
    place = f"getelementptr inbounds ({array}, i64 0, i64 {block})"
    return [
        f"  %counts.{block}.before = load i64, ptr {place}",
        f"  %counts.{block}.after = add i64 %counts.{block}.before, 1",
        f"  store i64 %counts.{block}.after, ptr {place}",
    ]
