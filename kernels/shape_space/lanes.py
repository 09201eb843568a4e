"""Vectors and matrices of packed kernels: structs of numbers.

A loop over lanes does not become vector code where a func takes or returns a short vector of
float32 (`wp.types.vector`): the compiler keeps its numbers in pairs. Structs it takes apart.
"""

import warp as wp

from warprock.kernels.shape_space.block import (
    Block,
    in_axes,
    inverse_inertia,
    matrix_of,
    product,
    slide_of,
    turn_freely,
    turns_of,
    vector_product,
)


@wp.struct
class Triple:
    """A vector."""

    x: real
    y: real
    z: real


@wp.struct
class State:
    """What a block keeps from step to step, in the frame of the base.

    Attributes:
        x, y, z: Centre of mass [m].
        qx, qy, qz, qw: Attitude.
        vx, vy, vz: Velocity, of half a step before [m/s].
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
def plus(a: Triple, b: Triple) -> Triple:
    """The sum of two vectors."""
    return Triple(a.x + b.x, a.y + b.y, a.z + b.z)


@wp.func
def minus(a: Triple, b: Triple) -> Triple:
    """The difference of two vectors."""
    return Triple(a.x - b.x, a.y - b.y, a.z - b.z)


@wp.func
def scaled(part: real, a: Triple) -> Triple:
    """A multiple of a vector."""
    return Triple(part * a.x, part * a.y, part * a.z)


@wp.func
def scaled_each(a: Triple, b: Triple) -> Triple:
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
def turn_of(s: State) -> Turn:
    """Rotation matrix of a block."""
    r11, r12, r13, r21, r22, r23, r31, r32, r33 = matrix_of(s.qx, s.qy, s.qz, s.qw)
    return Turn(r11, r12, r13, r21, r22, r23, r31, r32, r33)


@wp.func
def into_base(r: Turn, v: Triple) -> Triple:
    """A vector in the axes of the base, from that in the axes of the body."""
    x, y, z = in_axes(r.r11, r.r12, r.r13, r.r21, r.r22, r.r23, r.r31, r.r32, r.r33, v.x, v.y, v.z)
    return Triple(x, y, z)


@wp.func
def into_body(r: Turn, v: Triple) -> Triple:
    """A vector in the axes of the body, from that in the axes of the base."""
    x, y, z = in_axes(r.r11, r.r21, r.r31, r.r12, r.r22, r.r32, r.r13, r.r23, r.r33, v.x, v.y, v.z)
    return Triple(x, y, z)


@wp.func
def weighted(r: Turn, d: Triple) -> Symmetric:
    """R diag(d) R^T: a moment of inertia, or its inverse, in the axes of the base."""
    xx, xy, xz, yy, yz, zz = inverse_inertia(
        r.r11, r.r12, r.r13, r.r21, r.r22, r.r23, r.r31, r.r32, r.r33, d.x, d.y, d.z
    )
    return Symmetric(xx, xy, xz, yy, yz, zz)


@wp.func
def times(m: Symmetric, v: Triple) -> Triple:
    """A symmetric matrix times a vector."""
    x, y, z = in_axes(m.xx, m.xy, m.xz, m.xy, m.yy, m.yz, m.xz, m.yz, m.zz, v.x, v.y, v.z)
    return Triple(x, y, z)


@wp.func
def turned_freely(s: State, spin: Triple, inverse: Triple, dt: real):
    """Attitude of a block after free rotation for a time dt [s]: x, y, z, w; see `turn_freely`.

    Args:
        s: The block, of which the attitude counts.
        spin: Angular momentum in the axes of the base, for unit mass [m^2/s].
        inverse: Inverse moments of inertia about the body's axes, for unit mass [1/m^2].
        dt: Time [s].
    """
    x, y, z, w = turn_freely(
        s.qx, s.qy, s.qz, s.qw, spin.x, spin.y, spin.z, inverse.x, inverse.y, inverse.z, dt
    )
    return x, y, z, w


@wp.func
def find_turns(block: Block, r: Turn, s: State):
    """What tells how far a block has turned; see `turns_of`."""
    along, across, tilt, yaw = turns_of(block, r.r13, r.r23, r.r33, s.qz, s.qw)
    return along, across, tilt, yaw


@wp.func
def find_slide(block: Block, x: real, y: real, r: Turn):
    """Slide of a block on the ground along x and y [m]; see `slide_of`."""
    away_x, away_y = slide_of(block, x, y, r.r11, r.r12, r.r13, r.r21, r.r22, r.r23, r.r31, r.r32)
    return away_x, away_y
