"""Impulses that stop contact points of a body in space together, as one motion of the body.

As impulse_space/block_hold.py for the four corners of a block, for any number of points. Held
points allow a body one motion: about the point, about the line through them, or none if they span a
plane, apart from the motion that closes open gaps. Let m be their middle, w a vector along their
line, A the moment of inertia about m, and s the angular momentum about m, both without the motion
that closes the gaps. Then omega is

    one point:  A^-1 s        a line:  w (w.s) / (w.A w)        a plane:  0,

and the centre of mass moves at m x omega. This takes the impulse e, whose moment about m is g. The
normal impulses are those of a bed of equal springs, n = a + b.(r - m), with the sum e_z and the
moments g_x and g_y. The friction of a point is n times a field of two terms: (e_x, e_y) / e_z, and
a turn about the centre of pressure that gives g_z.

Rounds find the held points, starting with all contacts: a point that would pull is released, one
that would sink is held. Where a body stands they start with those that touch: if it lies with a
tilt of round-off, others are open, and no motion meets the aims of all. If the rounds do not end,
or friction is not enough, the sweeps of impulse_space/block.py follow.
"""

import warp as wp

from warprock.kernels.impulse_space.block import Contact, Impulse, Knobs, Velocity
from warprock.kernels.impulse_space.block_hold import WITHIN, solve_symmetric
from warprock.kernels.shape_space.body import APART, divide_by_moments, spans
from warprock.kernels.shape_space.contact import holds
from warprock.kernels.shape_space.lanes import (
    State,
    Symmetric,
    Triple,
    cross_product,
    minus,
    plus,
    scalar_product,
    times,
)

LEFT = by_precision(1.0e-9, 1.0e-2)
"""Deviation of a point from its aim, over g dt, that is round-off."""
ROUNDS = 6
"""Largest number of rounds that find the held points."""


@wp.struct
class Sums:
    """Sums over the held points: of their number, levers and aims, and of products.

    Attributes:
        count: Their number.
        x, y, z: Of the levers [m].
        xx, xy, yy, zx, zy: Of products of these [m^2].
        t, tx, ty: Of the aims [m/s], and of their products with x and y.
    """

    count: real
    x: real
    y: real
    z: real
    xx: real
    xy: real
    yy: real
    zx: real
    zy: real
    t: real
    tx: real
    ty: real


@wp.struct
class Bed:
    """Total impulse of the held points, and its distribution.

    Attributes:
        x, y: Their middle, from the centre of mass [m].
        ex, ey, ez: Their impulse [m/s].
        gz: Its moment about the vertical through their middle [m^2/s].
        push, bx, by: The plane of the normal impulses, in the middle and its slopes.
    """

    x: real
    y: real
    ex: real
    ey: real
    ez: real
    gz: real
    push: real
    bx: real
    by: real


@wp.struct
class Pressure:
    """Moments of the normal impulses about the middle: first ones and the polar one."""

    x: real
    y: real
    polar: real


@wp.struct
class Turning:
    """The turn of the friction about the centre of pressure (x, y) [m]."""

    x: real
    y: real
    turn: real


@wp.func
def first_held(knobs: Knobs, stands: bool, at: Contact, lowest: real) -> real:
    """1 for a contact to begin with, else 0: if the body stands one that touches, if any does.

    `lowest` is the lowest gap of all points [m].
    """
    dust = LEFT * knobs.gravity * knobs.time_step
    begins = at.aim >= -dust or not stands or lowest * knobs.rate > dust
    return wp.where(begins, at.on, real(0.0))


@wp.func
def add_held(held: real, at: Contact, sums: wp.ref[Sums]):
    """Adds a point to the sums over the held ones."""
    on, zero = held > real(0.0), real(0.0)
    a, b, c, d = wp.where(on, at.x, zero), wp.where(on, at.y, zero), held * at.h, held * at.aim
    sums.count = sums.count + held
    sums.x = sums.x + a
    sums.y = sums.y + b
    sums.z = sums.z + c
    sums.xx = sums.xx + a * a
    sums.xy = sums.xy + a * b
    sums.yy = sums.yy + b * b
    sums.zx = sums.zx + c * a
    sums.zy = sums.zy + c * b
    sums.t = sums.t + d
    sums.tx = sums.tx + d * a
    sums.ty = sums.ty + d * b


@wp.func
def turn_about(point: bool, m: Triple, w: Triple, s: Triple, j: Symmetric) -> Triple:
    """Angular velocity about a `point` m, or about a line w through it, from s about m.

    j are moments of inertia about the centre of mass.
    """
    mm = scalar_product(m, m)
    about = Symmetric(
        j.xx + mm - m.x * m.x, j.xy - m.x * m.y, j.xz - m.x * m.z,
        j.yy + mm - m.y * m.y, j.yz - m.y * m.z, j.zz + mm - m.z * m.z,
    )  # fmt: skip
    spin = scalar_product(w, s) / larger(scalar_product(w, times(about, w)), TINY)
    o = solve_symmetric(about, s)
    return Triple(
        wp.where(point, o.x, spin * w.x), wp.where(point, o.y, spin * w.y),
        wp.where(point, o.z, spin * w.z),
    )  # fmt: skip


@wp.func
def find_motion(reach: real, u: Velocity, s: State, j: Symmetric, sums: Sums):
    """Motion of a body whose held points are stopped, from u and s without contact.

    j are its moments of inertia in the axes of the base.

    Returns:
        The motion, and the impulse of the points.
    """
    zero, one, n = real(0.0), real(1.0), sums
    over_count = one / larger(n.count, one)
    m, rise = Triple(over_count * n.x, over_count * n.y, over_count * n.z), over_count * n.t
    axx, axy, ayy = n.xx - n.x * m.x, n.xy - n.x * m.y, n.yy - n.y * m.y
    flat, trace = spans(n.count, axx, axy, ayy), axx + ayy
    some, point = n.count > zero, n.count < real(1.5) or trace <= APART * reach * reach
    # Slopes of the plane, or the line, through the points; and of their aims.
    slope_x, slope_y = divide_by_moments(
        flat, point, axx, axy, ayy, n.zx - n.z * m.x, n.zy - n.z * m.y
    )
    climb_x, climb_y = divide_by_moments(
        flat, point, axx, axy, ayy, n.tx - n.t * m.x, n.ty - n.t * m.y
    )
    closes = Triple(climb_y, -climb_x, zero)
    # In the plane of the points; along a line the motion that closes gaps is level.
    level = wp.where(flat, closes.x * slope_x + closes.y * slope_y, zero)
    # Along the line: its direction is the longer column of the second moments.
    wide = axx >= ayy
    wx, wy = wp.where(wide, axx, axy), wp.where(wide, axy, ayy)
    w = Triple(wx, wy, slope_x * wx + slope_y * wy)
    closing = cross_product(m, closes)
    left = Triple(u.x - closing.x, u.y - closing.y, u.z - closing.z - rise)
    spin = minus(Triple(s.lx, s.ly, s.lz), times(j, closes))
    about = plus(spin, cross_product(left, m))
    rolls = turn_about(point, m, w, about, j)
    o = Triple(
        closes.x + wp.where(flat, zero, rolls.x), closes.y + wp.where(flat, zero, rolls.y),
        level + wp.where(flat, zero, rolls.z),
    )  # fmt: skip
    rides = cross_product(m, o)
    v = Velocity(
        wp.where(some, rides.x, u.x), wp.where(some, rides.y, u.y),
        wp.where(some, rides.z + rise, u.z), wp.where(some, o.x, u.turn_x),
        wp.where(some, o.y, u.turn_y), wp.where(some, o.z, u.turn_z),
    )  # fmt: skip
    lost = Triple(v.x - u.x, v.y - u.y, v.z - u.z)
    h = times(j, Triple(v.turn_x, v.turn_y, v.turn_z))
    g = cross_product(lost, m)
    bx, by = divide_by_moments(flat, point, axx, axy, ayy, s.ly - h.y - g.y, h.x - s.lx + g.x)
    return v, Bed(m.x, m.y, lost.x, lost.y, lost.z, h.z - s.lz + g.z, over_count * lost.z, bx, by)


@wp.func
def pressure_at(bed: Bed, at: Contact) -> real:
    """Normal impulse of a held point."""
    return bed.push + bed.bx * (at.x - bed.x) + bed.by * (at.y - bed.y)


@wp.func
def update_held(
    knobs: Knobs, at: Contact, v: Velocity, bed: Bed, held: wp.ref[real], same: wp.ref[real]
):
    """Releases a held point that would pull, holds one that would sink; sets `same` to 0 then."""
    zero, one = real(0.0), real(1.0)
    # What is no contact may lie anywhere.
    n = pressure_at(bed, at)
    rises = v.z + v.turn_x * at.y - v.turn_y * at.x
    sinks = rises < at.aim - LEFT * knobs.gravity * knobs.time_step
    was = held > zero
    now = at.on > zero and ((was and n > zero) or (not was and sinks))
    held = wp.where(now, one, zero)
    same = wp.where(now == was, same, zero)


@wp.func
def add_pressure(held: real, at: Contact, bed: Bed, sums: wp.ref[Pressure]):
    """Adds a point to the moments of the normal impulses."""
    x, y = at.x - bed.x, at.y - bed.y
    n = wp.where(held > real(0.0), bed.push + bed.bx * x + bed.by * y, real(0.0))
    sums.x = sums.x + n * x
    sums.y = sums.y + n * y
    sums.polar = sums.polar + n * (x * x + y * y)


@wp.func
def find_turn(bed: Bed, sums: Pressure) -> Turning:
    """The centre of pressure, and the turn of the friction about it."""
    part = real(1.0) / larger(bed.ez, TINY)
    cx, cy = part * sums.x, part * sums.y
    polar = sums.polar - (sums.x * cx + sums.y * cy)
    moment = bed.gz - (cx * bed.ey - cy * bed.ex)
    turn = wp.where(polar > TINY, moment / larger(polar, TINY), real(0.0))
    return Turning(bed.x + cx, bed.y + cy, turn)


@wp.func
def share_impulse(
    knobs: Knobs, mu: real, held: real, at: Contact, v: Velocity, bed: Bed, turning: Turning,
    good: wp.ref[real],
) -> Impulse:  # fmt: skip
    """Impulse of a point; `good` is set to 0 if it does not obey the contact law.

    A held point must have the velocity of its aim, push, and have friction within the bound. A
    point that is not held has no impulse and must not sink.
    """
    zero, part = real(0.0), real(1.0) / larger(bed.ez, TINY)
    touches = held > zero
    n = pressure_at(bed, at)
    fx = n * (part * bed.ex - turning.turn * (at.y - turning.y))
    fy = n * (part * bed.ey + turning.turn * (at.x - turning.x))
    left = v.z + v.turn_x * at.y - v.turn_y * at.x - at.aim
    dust = LEFT * knobs.gravity * knobs.time_step
    held_well = size(left) <= dust and holds(fx, fy, n, WITHIN * mu)
    obeys = at.on <= zero or (touches and held_well) or (not touches and left >= -dust)
    good = wp.where(obeys, good, zero)
    return Impulse(
        wp.where(touches, fx, zero), wp.where(touches, fy, zero), wp.where(touches, n, zero)
    )
