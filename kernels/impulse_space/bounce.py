"""Normal restitution of the impulse step in space, point by point.

A point that touches and comes down faster than `SLOW` g dt asks for e times that speed upwards
(Newton's restitution), not for zero.
"""

import warp as wp

from warprock.kernels.impulse_space.block import Knobs
from warprock.kernels.shape_space.block import matrix_of

SLOW = real(4.0)
"""Speed over that which gravity gives in a step up to which a corner does not bounce: a block that
rests comes down at one of it, one that has just landed at two."""


@wp.func
def bounce(
    knobs: Knobs, rx: real, ry: real, uz: real, ox: real, oy: real, on: real, aim: real
) -> real:  # fmt: skip
    """Normal velocity that a corner asks for [m/s], from that at which it comes down."""
    speed = -(uz + ox * ry - oy * rx)
    falls = on > real(0.0) and speed > SLOW * knobs.gravity * knobs.time_step
    return wp.where(falls, larger(knobs.restitution * speed, aim), aim)


@wp.func
def calm(
    knobs: Knobs, dvx: real, dvy: real, dvz: real, qx: real, qy: real, qz: real, qw: real,
    ix: real, iy: real, iz: real, vx: real, vy: real, vz: real, lx: real, ly: real, lz: real,
    ux: wp.ref[real], uy: wp.ref[real], uz: wp.ref[real],
    ox: wp.ref[real], oy: wp.ref[real], oz: wp.ref[real],
):  # fmt: skip
    """Takes back what an impact gave that was not there.

    With friction Newton's restitution may make energy. The impulses of the contacts, for unit mass
    p and h, change free velocities f and a by p and b = I^-1 h; of a part s of them the work is

        W = s (p . f + h . a) + s^2 / 2 (p . p + h . b).

    Where it is above zero for the whole, that part is taken for which it is zero.

    References:
        Kane and Levinson (1985), Dynamics: Theory and Applications.
    """
    r11, r12, r13, r21, r22, r23, r31, r32, r33 = matrix_of(qx, qy, qz, qw)
    ax = ix * (r11 * lx + r21 * ly + r31 * lz)
    ay = iy * (r12 * lx + r22 * ly + r32 * lz)
    az = iz * (r13 * lx + r23 * ly + r33 * lz)
    bx = r11 * ox + r21 * oy + r31 * oz - ax
    by = r12 * ox + r22 * oy + r32 * oz - ay
    bz = r13 * ox + r23 * oy + r33 * oz - az
    fx, fy, fz = vx - dvx, vy - dvy, vz - dvz - knobs.time_step * knobs.gravity
    px, py, pz = ux - fx, uy - fy, uz - fz
    once = px * fx + py * fy + pz * fz + bx * ax / ix + by * ay / iy + bz * az / iz
    twice = px * px + py * py + pz * pz + bx * bx / ix + by * by / iy + bz * bz / iz
    makes = knobs.restitution > real(0.0) and once + HALF * twice > real(0.0)
    less = wp.where(makes, real(1.0) + TWO * once / larger(twice, TINY), real(0.0))
    less = smaller(less, real(1.0))
    ux = ux - less * px
    uy = uy - less * py
    uz = uz - less * pz
    ox = ox - less * (r11 * bx + r12 * by + r13 * bz)
    oy = oy - less * (r21 * bx + r22 * by + r23 * bz)
    oz = oz - less * (r31 * bx + r32 * by + r33 * bz)
