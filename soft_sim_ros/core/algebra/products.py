"""Products of matrices with a row for every component of a twist.

Columns are padded to a multiple of four with zeros, and taken four at once.
"""

from soft_sim_ros.core.backend.jit import kernel

from .maps import stack_of, weighed
from .simd import WIDTH, fused, keep_one, lane, one, sum_of
from .spaces import size_of


@kernel
def clear(a, count):
    """Zero the first rows of a (…, padded m)."""
    for i in range(count):
        for j in range(0, a.shape[1], WIDTH):
            keep_one(a, i, j, 0.0)


@kernel
def accumulate(a, b, count):
    """Add the first rows of b (…, padded m) to a."""
    for i in range(count):
        for j in range(0, a.shape[1], WIDTH):
            keep_one(a, i, j, one(a, i, j) + one(b, i, j))


@kernel
def add_product(space, matrix, at, factor, x, out):
    """Out += factor times a matrix (rows ``at`` … of it) times x (≥ size, padded m)."""
    for j in range(0, out.shape[1], WIDTH):
        stack = stack_of(space, x, 0, j)
        for i in range(size_of(space)):
            keep_one(out, i, j, weighed(space, matrix, at + i, 0, 0, factor, stack, one(out, i, j)))


@kernel
def add_product_t(space, matrix, at, factor, x, out, begin, count):
    """Rows ``begin`` … of out += factor times ``count`` rows of a transposed matrix times x."""
    for j in range(0, out.shape[1], WIDTH):
        stack = stack_of(space, x, 0, j)
        for i in range(count):
            total = one(out, begin + i, j)
            total = weighed(space, matrix, at, i, 1, factor, stack, total)
            keep_one(out, begin + i, j, total)


@kernel
def add_wide_product(matrix, x, out):
    """Out (a, padded m) += matrix (a, ≥ b) times x (b, padded m)."""
    for j in range(0, x.shape[1], WIDTH):
        for i in range(out.shape[0]):
            total = one(out, i, j)
            for c in range(x.shape[0]):
                total = fused(matrix[i, c], one(x, c, j), total)
            keep_one(out, i, j, total)


@kernel
def row_product(x, i, y, j):
    """Return the product of row i of x and row j of y (…, padded m)."""
    total = one(x, i, 0) * one(y, j, 0)
    for c in range(WIDTH, x.shape[1], WIDTH):
        total = total + one(x, i, c) * one(y, j, c)
    return sum_of(total)


@kernel
def add_entries(model, k, begin, factor, hessian, turned, block):
    """Add factor times φᵀ H φ of segment k to its block (m, padded m).

    hessian (12, 12) between strains at the Gauss points, transposed: row 6g + c is the change of
    all forces per unit of strain c at Gauss point g. turned (12, padded m): scratch.
    """
    clear(turned, 12)
    for e in range(model.entry_ptr[k], model.entry_ptr[k + 1]):
        j, comp = model.entry_col[e] - begin, model.entry_comp[e]
        t1, t2 = factor * model.entry_phi[e, 0], factor * model.entry_phi[e, 1]
        for c in range(0, 12, WIDTH):
            change = fused(t1, one(hessian, comp, c), t2 * one(hessian, 6 + comp, c))
            for i in range(WIDTH):
                turned[c + i, j] += lane(change, i)
    for e in range(model.entry_ptr[k], model.entry_ptr[k + 1]):
        i, comp = model.entry_col[e] - begin, model.entry_comp[e]
        p1, p2 = model.entry_phi[e, 0], model.entry_phi[e, 1]
        for j in range(0, block.shape[1], WIDTH):
            total = fused(p1, one(turned, comp, j), one(block, i, j))
            keep_one(block, i, j, fused(p2, one(turned, 6 + comp, j), total))
