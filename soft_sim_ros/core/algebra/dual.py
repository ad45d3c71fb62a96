"""Three-vectors, 3x3 matrices and their dual-number versions, as tuples of scalars.

A twist (w; v) is the dual vector w + εv with ε² = 0, a wrench (M; N) is N + εM. Over this ring
SE(3) is SO(3): the Lie bracket is the cross product, Ad is a rotation matrix R + ε p×R, and every
formula of SO(3) holds as it stands (principle of transference). All kernels are written in it.

Types: ``vec`` = 3-tuple, ``mat`` = 9-tuple by rows; dual scalar, vector, matrix = (real part, ε
part).
"""

from soft_sim_ros.core.backend.jit import algebra

# ---- real vectors and matrices ----------------------------------------------------------------


@algebra
def add(a, b):
    """Return a + b."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


@algebra
def sub(a, b):
    """Return a - b."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


@algebra
def scale(s, a):
    """Return s a."""
    return (s * a[0], s * a[1], s * a[2])


@algebra
def dot(a, b):
    """Return a · b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@algebra
def cross(a, b):
    """Return a × b."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


@algebra
def apply(m, a):
    """Return the product of matrix m and vector a."""
    return (
        m[0] * a[0] + m[1] * a[1] + m[2] * a[2],
        m[3] * a[0] + m[4] * a[1] + m[5] * a[2],
        m[6] * a[0] + m[7] * a[1] + m[8] * a[2],
    )


@algebra
def apply_t(m, a):
    """Return the product of the transposed matrix m and vector a."""
    return (
        m[0] * a[0] + m[3] * a[1] + m[6] * a[2],
        m[1] * a[0] + m[4] * a[1] + m[7] * a[2],
        m[2] * a[0] + m[5] * a[1] + m[8] * a[2],
    )


@algebra
def transpose(m):
    """Return the transpose of m."""
    return (m[0], m[3], m[6], m[1], m[4], m[7], m[2], m[5], m[8])


@algebra
def mul(a, b):
    """Return the matrix product a b."""
    return (
        a[0] * b[0] + a[1] * b[3] + a[2] * b[6],
        a[0] * b[1] + a[1] * b[4] + a[2] * b[7],
        a[0] * b[2] + a[1] * b[5] + a[2] * b[8],
        a[3] * b[0] + a[4] * b[3] + a[5] * b[6],
        a[3] * b[1] + a[4] * b[4] + a[5] * b[7],
        a[3] * b[2] + a[4] * b[5] + a[5] * b[8],
        a[6] * b[0] + a[7] * b[3] + a[8] * b[6],
        a[6] * b[1] + a[7] * b[4] + a[8] * b[7],
        a[6] * b[2] + a[7] * b[5] + a[8] * b[8],
    )


@algebra
def madd(a, b):
    """Return the matrix sum a + b."""
    return (
        a[0] + b[0],
        a[1] + b[1],
        a[2] + b[2],
        a[3] + b[3],
        a[4] + b[4],
        a[5] + b[5],
        a[6] + b[6],
        a[7] + b[7],
        a[8] + b[8],
    )


@algebra
def mscale(s, a):
    """Return the matrix s a."""
    return (
        s * a[0],
        s * a[1],
        s * a[2],
        s * a[3],
        s * a[4],
        s * a[5],
        s * a[6],
        s * a[7],
        s * a[8],
    )


@algebra
def skew(a):
    """Return the matrix of a ×."""
    return (0.0, -a[2], a[1], a[2], 0.0, -a[0], -a[1], a[0], 0.0)


@algebra
def outer(a, b):
    """Return the matrix a bᵀ."""
    return (
        a[0] * b[0],
        a[0] * b[1],
        a[0] * b[2],
        a[1] * b[0],
        a[1] * b[1],
        a[1] * b[2],
        a[2] * b[0],
        a[2] * b[1],
        a[2] * b[2],
    )


@algebra
def spherical(s):
    """Return s times the identity matrix."""
    return (s, 0.0, 0.0, 0.0, s, 0.0, 0.0, 0.0, s)


# ---- dual numbers -----------------------------------------------------------------------------


@algebra
def smul(s, t):
    """Return the product of dual scalars."""
    return (s[0] * t[0], s[0] * t[1] + s[1] * t[0])


@algebra
def sadd(s, t):
    """Return the sum of dual scalars."""
    return (s[0] + t[0], s[1] + t[1])


@algebra
def dadd(a, b):
    """Return the sum of dual vectors."""
    return (add(a[0], b[0]), add(a[1], b[1]))


@algebra
def dsub(a, b):
    """Return the difference of dual vectors."""
    return (sub(a[0], b[0]), sub(a[1], b[1]))


@algebra
def rscale(s, a):
    """Return the real number s times the dual vector a."""
    return (scale(s, a[0]), scale(s, a[1]))


@algebra
def dscale(s, a):
    """Return the dual scalar s times the dual vector a."""
    return (scale(s[0], a[0]), add(scale(s[0], a[1]), scale(s[1], a[0])))


@algebra
def ddot(a, b):
    """Return the dual scalar product."""
    return (dot(a[0], b[0]), dot(a[0], b[1]) + dot(a[1], b[0]))


@algebra
def dcross(a, b):
    """Return the dual cross product: the Lie bracket of se(3) for twists."""
    return (cross(a[0], b[0]), add(cross(a[0], b[1]), cross(a[1], b[0])))


@algebra
def dmul(a, b):
    """Return the product of dual matrices."""
    return (mul(a[0], b[0]), madd(mul(a[0], b[1]), mul(a[1], b[0])))


@algebra
def dtranspose(a):
    """Return the transpose of a dual matrix."""
    return (transpose(a[0]), transpose(a[1]))


@algebra
def dmadd(a, b):
    """Return the sum of dual matrices."""
    return (madd(a[0], b[0]), madd(a[1], b[1]))


@algebra
def rmscale(s, a):
    """Return the real number s times the dual matrix a."""
    return (mscale(s, a[0]), mscale(s, a[1]))


@algebra
def dmscale(s, a):
    """Return the dual scalar s times the dual matrix a."""
    return (mscale(s[0], a[0]), madd(mscale(s[0], a[1]), mscale(s[1], a[0])))


@algebra
def dskew(a):
    """Return the dual matrix of a ×."""
    return (skew(a[0]), skew(a[1]))


@algebra
def douter(a, b):
    """Return the dual matrix a bᵀ."""
    return (outer(a[0], b[0]), madd(outer(a[0], b[1]), outer(a[1], b[0])))


@algebra
def dspherical(s):
    """Return the dual scalar s times the identity."""
    return (spherical(s[0]), spherical(s[1]))


# ---- arrays -----------------------------------------------------------------------------------


@algebra
def load_twist(row):
    """Return the dual vector of an array (w, v)."""
    return ((row[0], row[1], row[2]), (row[3], row[4], row[5]))


@algebra
def store_twist(row, a):
    """Write a dual vector as (w, v)."""
    row[0], row[1], row[2] = a[0]
    row[3], row[4], row[5] = a[1]


@algebra
def load_wrench(row):
    """Return the dual vector N + εM of an array (M, N)."""
    return ((row[3], row[4], row[5]), (row[0], row[1], row[2]))


@algebra
def store_wrench(row, f):
    """Write a dual vector N + εM as (M, N)."""
    row[3], row[4], row[5] = f[0]
    row[0], row[1], row[2] = f[1]


@algebra
def load_vec(row):
    """Return a 3-tuple of an array."""
    return (row[0], row[1], row[2])


@algebra
def store_vec(row, a):
    """Write a 3-tuple."""
    row[0], row[1], row[2] = a


@algebra
def load_mat(row):
    """Return the 9-tuple of a flat array."""
    return (row[0], row[1], row[2], row[3], row[4], row[5], row[6], row[7], row[8])


@algebra
def store_mat(row, m):
    """Write a 9-tuple to a flat array."""
    for i in range(9):
        row[i] = m[i]
