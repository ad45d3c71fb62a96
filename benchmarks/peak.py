"""What this processor can do at most: arithmetic in registers, and reading memory of each level.

Written in LLVM's language, so that it is known what runs: chains of x ← x·m + a that do not depend
on each other, as many as registers hold, and sums of arrays.
"""

from __future__ import annotations

import ctypes
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import llvmlite.binding as llvm
import numpy as np

from .counting import target_machine

CHAINS = 14  # and two registers for the constants
SECONDS = 0.01  # of one measurement; the best of ROUNDS counts
ROUNDS = 15
_CACHES = Path("/sys/devices/system/cpu/cpu0/cache")
_engines: list[Any] = []  # keep the code alive


def arithmetic(width: int, fused: bool = False) -> float:
    """Return the measured peak in Gflop/s of operations on ``width`` numbers at once."""
    kind = f"<{width} x double>" if width > 1 else "double"
    suffix = f"v{width}f64" if width > 1 else "f64"

    def number(value: float) -> str:
        inside = ", ".join([f"double {value}"] * width)
        return f"<{inside}>" if width > 1 else f"{value}"

    heads, bodies, ends = [], [], []
    for i in range(CHAINS):
        heads.append(f"  %x{i} = phi {kind} [ {number(1.0 + i)}, %entry ], [ %z{i}, %loop ]")
        if fused:
            given = f"{kind} %x{i}, {kind} %m, {kind} %a"
            bodies.append(f"  %z{i} = call {kind} @llvm.fma.{suffix}({given})")
        else:
            bodies.append(f"  %y{i} = fmul {kind} %x{i}, %m\n  %z{i} = fadd {kind} %y{i}, %a")
        ends.append(f"  %o{i} = getelementptr {kind}, ptr %out, i64 {i}")
        ends.append(f"  store {kind} %z{i}, ptr %o{i}, align 8")
    code = f"""
declare {kind} @llvm.fma.{suffix}({kind}, {kind}, {kind})
define void @run(i64 %n, ptr %out) {{
entry:
  %pm = getelementptr {kind}, ptr %out, i64 {CHAINS}
  %pa = getelementptr {kind}, ptr %out, i64 {CHAINS + 1}
  %m = load {kind}, ptr %pm, align 8
  %a = load {kind}, ptr %pa, align 8
  br label %loop
loop:
  %i = phi i64 [ 0, %entry ], [ %next, %loop ]
{chr(10).join(heads)}
{chr(10).join(bodies)}
  %next = add i64 %i, 1
  %more = icmp slt i64 %next, %n
  br i1 %more, label %loop, label %done
done:
{chr(10).join(ends)}
  ret void
}}"""
    out = np.full((CHAINS + 2, width), 0.5)
    return _rate(_compiled(code), out, 2 * CHAINS * width)


def reading(size: int) -> float:
    """Return the measured rate in GB/s of reading an array of ``size`` bytes again and again."""
    lanes, sums = 4, 8
    kind, step = f"<{lanes} x double>", lanes * sums
    zero = "zeroinitializer"
    heads = [f"  %x{i} = phi {kind} [ {zero}, %entry ], [ %z{i}, %loop ]" for i in range(sums)]
    bodies, ends = [], []
    for i in range(sums):
        bodies.append(f"  %j{i} = add i64 %at, {lanes * i}")
        bodies.append(f"  %p{i} = getelementptr double, ptr %out, i64 %j{i}")
        bodies.append(f"  %v{i} = load {kind}, ptr %p{i}, align 8")
        bodies.append(f"  %z{i} = fadd {kind} %x{i}, %v{i}")
        ends.append(f"  %o{i} = getelementptr {kind}, ptr %out, i64 {i}")
        ends.append(f"  store {kind} %z{i}, ptr %o{i}, align 8")
    count = max(1, size // 8 // step)
    code = f"""
define void @run(i64 %n, ptr %out) {{
entry:
  br label %loop
loop:
  %i = phi i64 [ 0, %entry ], [ %next, %loop ]
{chr(10).join(heads)}
  %block = urem i64 %i, {count}
  %at = mul i64 %block, {step}
{chr(10).join(bodies)}
  %next = add i64 %i, 1
  %more = icmp slt i64 %next, %n
  br i1 %more, label %loop, label %done
done:
{chr(10).join(ends)}
  ret void
}}"""
    return _rate(_compiled(code), np.zeros(count * step), 8 * step)


def caches() -> dict[str, int]:
    """Return the sizes in bytes of the caches for data of one core, empty where unknown."""
    out = {}
    for folder in sorted(_CACHES.glob("index*")):
        if (folder / "type").read_text().strip() != "Instruction":
            size = (folder / "size").read_text().strip()
            out["L" + (folder / "level").read_text().strip()] = int(size.rstrip("K")) * 1024
    return out


def _compiled(code: str) -> Callable[[int, int], None]:
    module = llvm.parse_assembly(code)
    module.verify()
    engine = llvm.create_mcjit_compiler(module, target_machine())
    engine.finalize_object()
    _engines.append(engine)
    kind = ctypes.CFUNCTYPE(None, ctypes.c_int64, ctypes.c_void_p)
    return kind(engine.get_function_address("run"))


def _rate(run: Callable[[int, int], None], out: np.ndarray, each: int) -> float:
    """Return how many of ``each`` per iteration are done in a nanosecond."""
    count, spent = 1000, 0.0
    while spent < SECONDS:
        count *= 2
        begin = time.process_time()
        run(count, out.ctypes.data)
        spent = time.process_time() - begin
    best = np.inf
    for _ in range(ROUNDS):
        begin = time.process_time()
        run(count, out.ctypes.data)
        best = min(best, time.process_time() - begin)
    return float(each * count / best * 1e-9)
