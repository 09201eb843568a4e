"""Normal restitution of the impulse step in space, point by point.

The least normal velocity of a touching point that comes down faster than `SLOW` g dt is e times
that speed upwards (Newton's restitution), not zero. The velocity of a step is that of its middle:
at its start, where the point touches, it falls g dt / 2 more slowly and leaves g dt / 2 faster.
"""

import warp as wp

from warprock.kernels.impulse_space.block import (
    Contact,
    Knobs,
    Velocity,
    rate_of,
    spin_of,
)
from warprock.kernels.shape_space.lanes import (
    State,
    Triple,
    Turn,
    elementwise_product,
    minus,
    turn_of,
)

SLOW = real(4.0)
"""Largest speed, over g dt, at which a corner does not bounce: the corners of a block at rest come
down at 1 g dt, those of a block that has just landed at 2 g dt."""


@wp.func
def bounce_velocity(knobs: Knobs, at: Contact, u: Velocity) -> real:
    """Least normal velocity of a corner after the step [m/s], by restitution."""
    speed = -(u.z + u.turn_x * at.y - u.turn_y * at.x)
    fall = knobs.gravity * knobs.time_step
    falls = at.on > real(0.0) and speed > SLOW * fall
    leaves = knobs.restitution * (speed - HALF * fall) - HALF * fall
    return wp.where(falls, larger(leaves, at.aim), at.aim)


@wp.func
def rounded_into_body(r: Turn, v: Triple) -> Triple:
    """`into_body` without fused products."""
    return Triple(
        r.r11 * v.x + r.r21 * v.y + r.r31 * v.z,
        r.r12 * v.x + r.r22 * v.y + r.r32 * v.z,
        r.r13 * v.x + r.r23 * v.y + r.r33 * v.z,
    )


@wp.func
def rounded_into_base(r: Turn, v: Triple) -> Triple:
    """`into_base` without fused products."""
    return Triple(
        r.r11 * v.x + r.r12 * v.y + r.r13 * v.z,
        r.r21 * v.x + r.r22 * v.y + r.r23 * v.z,
        r.r31 * v.x + r.r32 * v.y + r.r33 * v.z,
    )


@wp.func
def remove_gained_energy(knobs: Knobs, dv: Triple, inverse: Triple, s: State, u: wp.ref[Velocity]):
    """Removes the energy that an impact with restitution has created.

    With friction Newton's restitution may create energy. The impulses of the contacts, for unit
    mass p and h, change the free velocities f and a by p and b = I^-1 h. A part s of them does the
    work

        W = s (p . f + h . a) + s^2 / 2 (p . p + h . b).

    If W is positive for s = 1, the part s with W = 0 is taken.

    References:
        Kane and Levinson (1985), Dynamics: Theory and Applications.
    """
    r = turn_of(s)
    a = elementwise_product(inverse, rounded_into_body(r, spin_of(s)))
    b = minus(rounded_into_body(r, rate_of(u)), a)
    fx, fy, fz = s.vx - dv.x, s.vy - dv.y, s.vz - dv.z - knobs.time_step * knobs.gravity
    px, py, pz = u.x - fx, u.y - fy, u.z - fz
    ix, iy, iz = inverse.x, inverse.y, inverse.z
    once = px * fx + py * fy + pz * fz + b.x * a.x / ix + b.y * a.y / iy + b.z * a.z / iz
    twice = px * px + py * py + pz * pz + b.x * b.x / ix + b.y * b.y / iy + b.z * b.z / iz
    makes = once + HALF * twice > real(0.0)
    less = wp.where(makes, real(1.0) + TWO * once / larger(twice, TINY), real(0.0))
    less = smaller(less, real(1.0))
    turn = rounded_into_base(r, b)
    u.x = u.x - less * px
    u.y = u.y - less * py
    u.z = u.z - less * pz
    u.turn_x = u.turn_x - less * turn.x
    u.turn_y = u.turn_y - less * turn.y
    u.turn_z = u.turn_z - less * turn.z
