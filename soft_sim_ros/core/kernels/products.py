"""Products of 6-row matrices, written so that the inner loop runs along contiguous columns."""

from .jit import kernel


@kernel
def product(matrix, x, out):
    """Out = matrix (6, 6) times x (6, m)."""
    for i in range(6):
        for j in range(x.shape[1]):
            out[i, j] = 0.0
        for c in range(6):
            s = matrix[i, c]
            for j in range(x.shape[1]):
                out[i, j] += s * x[c, j]


@kernel
def product_add(matrix, x, out, factor):
    """Out += factor times matrix (6, 6) times x (6, m)."""
    for i in range(6):
        for c in range(6):
            s = factor * matrix[i, c]
            for j in range(x.shape[1]):
                out[i, j] += s * x[c, j]


@kernel
def product_t_add(matrix, x, out, factor):
    """Out += factor times transposed matrix (6, 6) times x (6, m)."""
    for i in range(6):
        for c in range(6):
            s = factor * matrix[c, i]
            for j in range(x.shape[1]):
                out[i, j] += s * x[c, j]


@kernel
def gram_add(left, right, matrix):
    """Add leftᵀ right to matrix (m, m), left and right (6, m)."""
    for i in range(left.shape[1]):
        for c in range(6):
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
