"""Vectors and matrices of packed kernels: structs of numbers.

A loop over lanes does not become vector code if a func takes or returns a short vector of float32
(`wp.types.vector`): the compiler keeps its numbers in pairs. It splits structs into their fields.
"""

import warp as wp


@wp.struct
class Triple:
    """A vector."""

    x: real
    y: real
    z: real


@wp.struct
class State:
    """State of a block, in the frame of the base.

    Attributes:
        x, y, z: Centre of mass [m].
        qx, qy, qz, qw: Attitude.
        vx, vy, vz: Velocity half a step earlier [m/s].
        lx, ly, lz: Angular momentum for unit mass, in the axes of the base [m^2/s].
    """

    x: real
    y: real
    z: real
    qx: real
    qy: real
    qz: real
    qw: real
    vx: real
    vy: real
    vz: real
    lx: real
    ly: real
    lz: real


@wp.struct
class Turn:
    """A rotation matrix, row by row."""

    r11: real
    r12: real
    r13: real
    r21: real
    r22: real
    r23: real
    r31: real
    r32: real
    r33: real


@wp.struct
class Symmetric:
    """A symmetric matrix, such as a moment of inertia."""

    xx: real
    xy: real
    xz: real
    yy: real
    yz: real
    zz: real


@wp.func
def product(ax: real, ay: real, az: real, bx: real, by: real, bz: real) -> real:
    """The scalar product of two vectors in space."""
    return fused(az, bz, fused(ay, by, ax * bx))


@wp.func
def vector_product(ax: real, ay: real, az: real, bx: real, by: real, bz: real):
    """The vector product of two vectors."""
    return fused_less(az, by, ay * bz), fused_less(ax, bz, az * bx), fused_less(ay, bx, ax * by)


@wp.func
def plus(a: Triple, b: Triple) -> Triple:
    """The sum of two vectors."""
    return Triple(a.x + b.x, a.y + b.y, a.z + b.z)


@wp.func
def minus(a: Triple, b: Triple) -> Triple:
    """The difference of two vectors."""
    return Triple(a.x - b.x, a.y - b.y, a.z - b.z)


@wp.func
def multiple(part: real, a: Triple) -> Triple:
    """A multiple of a vector."""
    return Triple(part * a.x, part * a.y, part * a.z)


@wp.func
def elementwise_product(a: Triple, b: Triple) -> Triple:
    """The products of the components of two vectors."""
    return Triple(a.x * b.x, a.y * b.y, a.z * b.z)


@wp.func
def choose(first: bool, a: Triple, b: Triple) -> Triple:
    """One of two vectors."""
    return Triple(wp.where(first, a.x, b.x), wp.where(first, a.y, b.y), wp.where(first, a.z, b.z))


@wp.func
def scalar_product(a: Triple, b: Triple) -> real:
    """The scalar product of two vectors."""
    return product(a.x, a.y, a.z, b.x, b.y, b.z)


@wp.func
def cross_product(a: Triple, b: Triple) -> Triple:
    """The vector product of two vectors."""
    x, y, z = vector_product(a.x, a.y, a.z, b.x, b.y, b.z)
    return Triple(x, y, z)


@wp.func
def matrix_of(qx: real, qy: real, qz: real, qw: real) -> Turn:
    """Rotation matrix of an attitude."""
    x, y, z = qx + qx, qy + qy, qz + qz
    xy, xz, yz = x * qy, x * qz, y * qz
    flat, tall = fused_less(z, qz, real(1.0)), fused_less(y, qy, real(1.0))
    return Turn(
        fused_less(y, qy, flat), fused_less(z, qw, xy), fused(y, qw, xz),
        fused(z, qw, xy), fused_less(x, qx, flat), fused_less(x, qw, yz),
        fused_less(y, qw, xz), fused(x, qw, yz), fused_less(x, qx, tall),
    )  # fmt: skip


@wp.func
def turn_of(s: State) -> Turn:
    """Rotation matrix of a block."""
    return matrix_of(s.qx, s.qy, s.qz, s.qw)


@wp.func
def into_base(r: Turn, v: Triple) -> Triple:
    """A vector in the axes of the base, from that in the axes of the body."""
    return Triple(
        product(r.r11, r.r12, r.r13, v.x, v.y, v.z),
        product(r.r21, r.r22, r.r23, v.x, v.y, v.z),
        product(r.r31, r.r32, r.r33, v.x, v.y, v.z),
    )


@wp.func
def into_body(r: Turn, v: Triple) -> Triple:
    """A vector in the axes of the body, from that in the axes of the base."""
    return Triple(
        product(r.r11, r.r21, r.r31, v.x, v.y, v.z),
        product(r.r12, r.r22, r.r32, v.x, v.y, v.z),
        product(r.r13, r.r23, r.r33, v.x, v.y, v.z),
    )


@wp.func
def inertia_of(r: Turn, d: Triple) -> Symmetric:
    """R diag(d) R^T: a moment of inertia, or its inverse, in the axes of the base."""
    a1, a2, a3 = r.r11 * d.x, r.r12 * d.y, r.r13 * d.z
    b1, b2, b3 = r.r21 * d.x, r.r22 * d.y, r.r23 * d.z
    c1, c2, c3 = r.r31 * d.x, r.r32 * d.y, r.r33 * d.z
    return Symmetric(
        product(r.r11, r.r12, r.r13, a1, a2, a3),
        product(r.r21, r.r22, r.r23, a1, a2, a3),
        product(r.r31, r.r32, r.r33, a1, a2, a3),
        product(r.r21, r.r22, r.r23, b1, b2, b3),
        product(r.r31, r.r32, r.r33, b1, b2, b3),
        product(r.r31, r.r32, r.r33, c1, c2, c3),
    )


@wp.func
def times(m: Symmetric, v: Triple) -> Triple:
    """A symmetric matrix times a vector."""
    return Triple(
        product(m.xx, m.xy, m.xz, v.x, v.y, v.z),
        product(m.xy, m.yy, m.yz, v.x, v.y, v.z),
        product(m.xz, m.yz, m.zz, v.x, v.y, v.z),
    )


@wp.func
def cofactors(m: Symmetric) -> Symmetric:
    """Cofactors of a symmetric matrix."""
    xx, xy, xz = vector_product(m.xy, m.yy, m.yz, m.xz, m.yz, m.zz)
    return Symmetric(
        xx, xy, xz, fused_less(m.xz, m.xz, m.xx * m.zz), fused_less(m.xx, m.yz, m.xy * m.xz),
        fused_less(m.xy, m.xy, m.xx * m.yy),
    )  # fmt: skip
