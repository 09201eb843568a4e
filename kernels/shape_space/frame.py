"""Attitudes, moments of inertia and velocities of bodies in space, as vectors and matrices.

A body has the velocity v of its centre of mass and the angular velocity o, both in the axes of the
base. Its point at the lever r from the centre of mass moves at v + o x r.
"""

import warp as wp

from warprock.kernels.algebra.vectors import Matrix, Quaternion, Vector
from warprock.kernels.shape_space.lanes import (
    Triple,
    Turn,
    inertia_of,
    matrix_of,
    product,
)


@wp.func
def frame(q: Quaternion) -> Matrix:
    """Rotation matrix of an attitude."""
    r = matrix_of(q[0], q[1], q[2], q[3])
    return Matrix(r.r11, r.r12, r.r13, r.r21, r.r22, r.r23, r.r31, r.r32, r.r33)


@wp.func
def turn_of_matrix(r: Matrix) -> Turn:
    """A rotation matrix as a struct of numbers."""
    return Turn(
        r[0, 0], r[0, 1], r[0, 2], r[1, 0], r[1, 1], r[1, 2], r[2, 0], r[2, 1], r[2, 2]
    )  # fmt: skip


@wp.func
def rotate_diagonal(r: Matrix, x: real, y: real, z: real) -> Matrix:
    """R diag(x, y, z) R^T: a moment of inertia, or its inverse, in the axes of the base."""
    j = inertia_of(turn_of_matrix(r), Triple(x, y, z))
    return Matrix(j.xx, j.xy, j.xz, j.xy, j.yy, j.yz, j.xz, j.yz, j.zz)


@wp.func
def axis_of(r: Matrix, i: int) -> Vector:
    """One of the axes of a body: a column of its rotation matrix."""
    return Vector(r[0, i], r[1, i], r[2, i])


@wp.func
def parts_along(e: Matrix, v: Vector):
    """The parts of a vector along three directions, one a row."""
    return (
        product(e[0, 0], e[0, 1], e[0, 2], v[0], v[1], v[2]),
        product(e[1, 0], e[1, 1], e[1, 2], v[0], v[1], v[2]),
        product(e[2, 0], e[2, 1], e[2, 2], v[0], v[1], v[2]),
    )


@wp.func
def velocity_at(v: Vector, o: Vector, r: Vector) -> Vector:
    """Velocity of a point of a block at the lever r from its centre of mass [m/s]."""
    return Vector(
        fused_less(o[2], r[1], fused(o[1], r[2], v[0])),
        fused_less(o[0], r[2], fused(o[2], r[0], v[1])),
        fused_less(o[1], r[0], fused(o[0], r[1], v[2])),
    )


@wp.func
def relative_velocity(
    vu: Vector, ou: Vector, ru: Vector, vl: Vector, ol: Vector, rl: Vector
) -> Vector:
    """Velocity of a contact on the upper block as seen from the lower one [m/s]."""
    return velocity_at(vu, ou, ru) - velocity_at(vl, ol, rl)
