"""Counted operations: right where they can be counted by hand."""

from benchmarks.counting import classify
from benchmarks.kernel_runs import known_count


def test_a_product_of_matrices_has_as_many_operations_as_its_definition():
    assert known_count() == {"fmul": 6 * 6 * 6, "fadd": 6 * 6 * 6}


def test_vectors_count_with_all_their_lanes():
    text = "%3 = fmul <4 x double> %1, %2"
    assert classify(text)["fmul"] == 4
    assert classify(text)["vector"] == 4
    assert classify("%3 = load <2 x double>, ptr %1, align 8")["load_bytes"] == 16
    assert classify("store double %3, ptr %1, align 8")["store_bytes"] == 8
    assert classify("%3 = call double @llvm.sqrt.f64(double %1)")["sqrt"] == 1
