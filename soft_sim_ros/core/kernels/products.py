"""Products of matrices with a row for every component of a twist.

Written so that the inner loop runs along contiguous columns.
"""

from .jit import kernel


@kernel
def add_product(matrix, x, out, factor, size):
    """Out += factor times matrix (size, size) times x (size, m)."""
    for i in range(size):
        for c in range(size):
            s = factor * matrix[i, c]
            for j in range(x.shape[1]):
                out[i, j] += s * x[c, j]


@kernel
def add_product_t(matrix, x, out, factor, size):
    """Out += factor times transposed matrix (size, size) times x (size, m)."""
    for i in range(size):
        for c in range(size):
            s = factor * matrix[c, i]
            for j in range(x.shape[1]):
                out[i, j] += s * x[c, j]


@kernel
def add_gram(left, right, matrix, size):
    """Add leftᵀ right to matrix (m, m), left and right (size, m)."""
    for i in range(left.shape[1]):
        for c in range(size):
            s = left[c, i]
            for j in range(right.shape[1]):
                matrix[i, j] += s * right[c, j]


@kernel
def clear(a):
    """Zero a three-dimensional array."""
    for i in range(a.shape[0]):
        for j in range(a.shape[1]):
            for k in range(a.shape[2]):
                a[i, j, k] = 0.0


@kernel
def accumulate(a, b):
    """Add matrix b to a."""
    for i in range(a.shape[0]):
        for j in range(a.shape[1]):
            a[i, j] += b[i, j]


@kernel
def accumulate3(a, b):
    """Add b to a, three-dimensional arrays."""
    for i in range(a.shape[0]):
        accumulate(a[i], b[i])


@kernel
def add_entries(model, k, begin, factor, hessian, block):
    """Add factor times φᵀ H φ of segment k to its block, H (2, 2, 6, 6) between Gauss points."""
    for e in range(model.entry_ptr[k], model.entry_ptr[k + 1]):
        i, ci = model.entry_col[e] - begin, model.entry_comp[e]
        p1, p2 = factor * model.entry_phi[e, 0], factor * model.entry_phi[e, 1]
        for e2 in range(model.entry_ptr[k], model.entry_ptr[k + 1]):
            cj = model.entry_comp[e2]
            t1, t2 = model.entry_phi[e2, 0], model.entry_phi[e2, 1]
            block[i, model.entry_col[e2] - begin] += p1 * (
                t1 * hessian[0, 0, ci, cj] + t2 * hessian[0, 1, ci, cj]
            ) + p2 * (t1 * hessian[1, 0, ci, cj] + t2 * hessian[1, 1, ci, cj])
