"""Impulses that stop all contacts of a block in space together, as one motion of the block.

Names are those of impulse_space/block.py; lengths and impulses are for mass 1. Held contacts allow
a block one motion: about the corner, about the line through two corners, or none if it lies flat,
apart from the motion that closes open gaps. Let m be the middle of the held corners, w half the way
from the first to the last of two corners, A the moment of inertia about m, and s the angular
momentum about m, both without the motion that closes the gaps. Then omega is

    one corner:  A^-1 s        two:  w (w.s) / (w.A w)        four:  0,

and the centre of mass moves at m x omega. This takes the impulse e, whose moment about m is g. Four
corners share it by the centre of pressure, which lies at the parts a and b of the half width and
half depth: e (1 +- a) (1 +- b) / 4, and a couple about the vertical. Two corners take half of it
each, -+ g x w / (2 w.w); they share the part along their line in proportion to their normal
impulses.

If the centre of pressure lies beyond the face, the corners on the far side are released, and the
others are tried. The released corners must then not sink. The sweeps solve blocks on three corners,
and blocks that slide.
"""

import warp as wp

from warprock.kernels.impulse_space.block import (
    Box,
    Corners,
    Impulse,
    Knobs,
    Lean,
    Velocity,
    impulse_where,
    rate_of,
    spin_of,
)
from warprock.kernels.shape_space.contact import holds
from warprock.kernels.shape_space.lanes import (
    State,
    Symmetric,
    Triple,
    choose,
    cofactors,
    cross_product,
    inertia_of,
    into_base,
    minus,
    multiple,
    plus,
    product,
    scalar_product,
    times,
    turn_of,
)

QUARTER = real(0.25)
WITHIN = by_precision(1.0 - 1.0e-12, 1.0 - 1.0e-5)
"""Largest friction of a corner that sticks here, over its bound; sweeps allow as much."""
EVEN = real(1.0e-9)
"""Deviation of the aims of four corners from a plane motion that is allowed, over g dt."""


@wp.struct
class Four:
    """One number a corner of a face, in the order of the lean: see impulse_space/block.py."""

    a: real
    b: real
    c: real
    d: real


@wp.struct
class Face:
    """The face that looks down, and the inertia of its block.

    Attributes:
        a, b: Half width and half depth towards the lean [m].
        middle: From the centre of mass [m].
        inertia: Moments of inertia for unit mass, in the axes of the base [m^2].
    """

    a: Triple
    b: Triple
    middle: Triple
    inertia: Symmetric


@wp.struct
class Line:
    """Held corners of a face: the line from the first to the last of two, or their middle.

    Attributes:
        w: Half of the line [m]; zero if one corner or all four are held.
        m: Middle of the held corners, from the centre of mass [m].
        x, y: w over half width and half depth.
    """

    w: Triple
    m: Triple
    x: real
    y: real


@wp.struct
class Motion:
    """Velocity [m/s] and angular velocity [rad/s] of a block."""

    v: Triple
    o: Triple


@wp.struct
class Push:
    """An impulse for mass 1 [m/s] and its moment about a point [m^2/s]."""

    e: Triple
    g: Triple


@wp.struct
class Pressure:
    """How four corners share an impulse.

    Attributes:
        a, b: Centre of pressure along the half width and the half depth.
        couple: The couple of their friction besides the part in proportion to the pressure, over
            the levers.
    """

    a: real
    b: real
    couple: real


@wp.func
def solve_symmetric(m: Symmetric, v: Triple) -> Triple:
    """The inverse of a symmetric matrix times a vector."""
    c = cofactors(m)
    part = real(1.0) / product(m.xx, m.xy, m.xz, c.xx, c.xy, c.xz)
    return multiple(part, times(c, v))


@wp.func
def push_between(free: Motion, after: Motion, spin: Triple, m: Triple, inertia: Symmetric) -> Push:
    """Impulse that changes one motion to another, and its moment about m.

    `spin` is the angular momentum before.
    """
    lost = minus(after.v, free.v)
    return Push(lost, plus(minus(times(inertia, after.o), spin), cross_product(lost, m)))


@wp.func
def motion_on_face(t: Four, face: Face) -> Motion:
    """Motion of a block on all four corners, which have the vertical velocities t."""
    a, b = face.a, face.b
    part = QUARTER / fused_less(a.y, b.x, a.x * b.y)
    tx, ty = part * (t.b - t.a + (t.d - t.c)), part * (t.c - t.a + (t.d - t.b))
    o = Triple(
        fused_less(tx, b.x, ty * a.x), fused_less(tx, b.y, ty * a.y),
        fused_less(tx, b.z, ty * a.z),
    )  # fmt: skip
    v = cross_product(face.middle, o)
    return Motion(Triple(v.x, v.y, v.z + QUARTER * (t.a + t.d + (t.b + t.c))), o)


@wp.func
def motion_on_line(
    first: real,
    last: real,
    one_corner: bool,
    free: Triple,
    spin: Triple,
    line: Line,
    inertia: Symmetric,
) -> Motion:
    """Motion of a block on `one_corner` or two, with vertical velocities first and last."""
    w, m, j = line.w, line.m, inertia
    closes = HALF * (last - first) / larger(scalar_product(w, w), TINY)
    ox, oy, rise = closes * w.y, -closes * w.x, HALF * (first + last)
    left = Triple(
        fused(m.z, oy, free.x), fused_less(m.z, ox, free.y),
        free.z - rise - fused_less(m.y, ox, m.x * oy),
    )  # fmt: skip
    closed = Triple(dot(j.xx, j.xy, ox, oy), dot(j.xy, j.yy, ox, oy), dot(j.xz, j.yz, ox, oy))
    s = plus(minus(spin, closed), cross_product(left, m))
    mm = scalar_product(m, m)
    about = Symmetric(
        fused_less(m.x, m.x, j.xx + mm), fused_less(m.x, m.y, j.xy), fused_less(m.x, m.z, j.xz),
        fused_less(m.y, m.y, j.yy + mm), fused_less(m.y, m.z, j.yz),
        fused_less(m.z, m.z, j.zz + mm),
    )  # fmt: skip
    rate = scalar_product(w, s) / larger(scalar_product(w, times(about, w)), TINY)
    free_turn = solve_symmetric(about, s)
    o = Triple(
        wp.where(one_corner, ox + free_turn.x, fused(rate, w.x, ox)),
        wp.where(one_corner, oy + free_turn.y, fused(rate, w.y, oy)),
        wp.where(one_corner, free_turn.z, rate * w.z),
    )
    v = cross_product(m, o)
    return Motion(Triple(v.x, v.y, v.z + rise), o)


@wp.func
def first_held(k: Four, x: Four) -> real:
    """The entry of x at the first corner with k not zero; at the last corner if there is none."""
    zero = real(0.0)
    return wp.where(k.a > zero, x.a, wp.where(k.b > zero, x.b, wp.where(k.c > zero, x.c, x.d)))


@wp.func
def reverse(x: Four) -> Four:
    """The numbers of the corners in reverse order."""
    return Four(x.d, x.c, x.b, x.a)


@wp.func
def line_of(k: Four, face: Face) -> Line:
    """The line or the middle of the corners with k not zero."""
    one, part = real(1.0), wp.where(corners_of(k) == real(4.0), real(0.0), HALF)
    sides_x, sides_y = Four(-one, one, -one, one), Four(-one, -one, one, one)
    i, j = first_held(k, sides_x), first_held(k, sides_y)
    last = reverse(k)
    x, y = first_held(last, reverse(sides_x)), first_held(last, reverse(sides_y))
    way_x, way_y = part * (x - i), part * (y - j)
    middle = plus(face.middle, on_face(part * (x + i), part * (y + j), face))
    return Line(on_face(way_x, way_y, face), middle, way_x, way_y)


@wp.func
def on_face(x: real, y: real, face: Face) -> Triple:
    """A vector on the face from parts of the half width and of the half depth [m]."""
    a, b = face.a, face.b
    return Triple(dot(x, y, a.x, b.x), dot(x, y, a.y, b.y), dot(x, y, a.z, b.z))


@wp.func
def corners_of(k: Four) -> real:
    """Number of corners, from 1 or 0 for each."""
    return k.a + k.b + k.c + k.d


@wp.func
def share_pressure(p: Push, face: Face) -> Pressure:
    """How four corners share an impulse whose moment is about their middle."""
    push, g, a, b = p.e, p.g, face.a, face.b
    part = real(1.0) / (larger(push.z, TINY) * fused_less(a.y, b.x, a.x * b.y))
    x, y = -part * dot(g.x, g.y, b.x, b.y), part * dot(g.x, g.y, a.x, a.y)
    moment = fused_less(dot(x, y, a.y, b.y), push.x, dot(x, y, a.x, b.x) * push.y)
    levers = dot(a.x, a.y, a.x, a.y) + dot(b.x, b.y, b.x, b.y)
    return Pressure(x, y, QUARTER * (g.z - moment) / levers)


@wp.func
def choose_held(s: Four, pushes: bool, at: Pressure) -> Four:
    """Which contacts to hold: of four, those on the side of the centre of pressure."""
    zero, one = real(0.0), real(1.0)
    full = s.a * s.b * s.c * s.d > zero and pushes
    return Four(
        wp.where(full and (at.a > one or at.b > one), zero, s.a),
        wp.where(full and (at.a < -one or at.b > one), zero, s.b),
        wp.where(full and (at.a > one or at.b < -one), zero, s.c),
        wp.where(full and (at.a < -one or at.b < -one), zero, s.d),
    )


@wp.func
def tilt_share(p: Push, w: Triple) -> Triple:
    """Impulse of the last of two corners beyond one half of the whole; w as at the head."""
    part = HALF / larger(scalar_product(w, w), TINY)
    q = multiple(part, cross_product(p.g, w))
    along = (part + part) * scalar_product(p.e, w) * q.z / larger(p.e.z, TINY)
    return Triple(fused(along, w.x, q.x), fused(along, w.y, q.y), fused(along, w.z, q.z))


@wp.struct
class Split:
    """How held corners share an impulse.

    Attributes:
        count: How many they are.
        e: Impulse of all of them.
        q: For two corners, impulse of the last beyond one half.
        x, y: For two corners, see `Line`.
        pressure: For four corners.
    """

    count: real
    e: Triple
    q: Triple
    x: real
    y: real
    pressure: Pressure


@wp.func
def share_impulse(i: real, j: real, on: real, split: Split, face: Face) -> Impulse:
    """Impulse of the corner on the sides i and j, -1 or 1; `on` is 1 if it is held."""
    zero, one, p, a, b = real(0.0), real(1.0), split.pressure, face.a, face.b
    end = larger(smaller(dot(i, j, split.x, split.y), one), -one)
    flat, half = split.count == real(4.0), wp.where(split.count == one, one, HALF)
    part = wp.where(flat, QUARTER * fused(i, p.a, one) * fused(j, p.b, one), half)
    turn_x, turn_y = -p.couple * dot(i, j, a.y, b.y), p.couple * dot(i, j, a.x, b.x)
    x = fused(part, split.e.x, wp.where(flat, turn_x, end * split.q.x))
    y = fused(part, split.e.y, wp.where(flat, turn_y, end * split.q.y))
    z = fused(part, split.e.z, wp.where(flat, zero, end * split.q.z))
    # Not on * x: without contacts x may be infinite.
    return impulse_where(on > zero, Impulse(x, y, z))


@wp.func
def obeys(p: Impulse, mu: real, sinks: bool) -> bool:
    """Whether the impulse of a corner obeys the law, and it does not sink if released."""
    return holds(p.fx, p.fy, p.n, WITHIN * mu) and not sinks


@wp.func
def would_sink(dropped: real, aim: real, i: real, j: real, face: Face, after: Motion) -> bool:
    """Whether a released corner would sink."""
    a, b, m = face.a, face.b, face.middle
    x, y = fused(j, b.x, fused(i, a.x, m.x)), fused(j, b.y, fused(i, a.y, m.y))
    rise = fused_less(after.o.y, x, fused(after.o.x, y, after.v.z))
    return dropped > real(0.0) and rise < aim


@wp.struct
class Held:
    """Impulses that stop the contacts of a block together.

    Attributes:
        fits: Whether they obey the contact law.
        touches: Whether a corner is held.
        after: Velocity of the block then.
        a, b, c, d: Impulses of its corners.
    """

    fits: bool
    touches: bool
    after: Velocity
    a: Impulse
    b: Impulse
    c: Impulse
    d: Impulse


@wp.func
def face_of(block: Box, lean: Lean, s: State) -> Face:
    """The face of a block at an attitude."""
    one, r = real(1.0), turn_of(s)
    w, d = lean.x * block.half_width, lean.y * block.half_depth
    moments = Triple(one / block.inverse_x, one / block.inverse_y, one / block.inverse_z)
    middle = into_base(r, Triple(-block.centre_x, -block.centre_y, -block.half_height))
    return Face(
        Triple(w * r.r11, w * r.r21, w * r.r31), Triple(d * r.r12, d * r.r22, d * r.r32), middle,
        inertia_of(r, moments),
    )  # fmt: skip


@wp.func
def stop_contacts(
    knobs: Knobs, block: Box, lean: Lean, state: State, free: Velocity, at: Corners
) -> Held:
    """Impulses that stop the contacts of a block together; `fits` if they obey the contact law."""
    zero, one = real(0.0), real(1.0)
    on = Four(at.a.on, at.b.on, at.c.on, at.d.on)
    face = face_of(block, lean, state)
    before = Motion(Triple(free.x, free.y, free.z), rate_of(free))
    spin = spin_of(state)
    t = Four(on.a * at.a.aim, on.b * at.b.aim, on.c * at.c.aim, on.d * at.d.aim)
    lies = motion_on_face(t, face)
    p = push_between(before, lies, spin, face.middle, face.inertia)
    k = choose_held(on, p.e.z > zero, share_pressure(p, face))
    count = corners_of(k)
    flat, line = count == real(4.0), line_of(k, face)
    rolls = motion_on_line(
        first_held(k, t), first_held(reverse(k), reverse(t)), count == one, before.v, spin, line,
        face.inertia,
    )  # fmt: skip
    after = Motion(choose(flat, lies.v, rolls.v), choose(flat, lies.o, rolls.o))
    p = push_between(before, after, spin, line.m, face.inertia)
    split = Split(count, p.e, tilt_share(p, line.w), line.x, line.y, share_pressure(p, face))
    pa, pb = share_impulse(-one, -one, k.a, split, face), share_impulse(one, -one, k.b, split, face)
    pc, pd = share_impulse(-one, one, k.c, split, face), share_impulse(one, one, k.d, split, face)
    uneven = size(t.a - t.b - t.c + t.d) > EVEN * knobs.gravity * knobs.time_step
    fits = count != real(3.0) and not (count == real(4.0) and uneven)
    fits = fits and obeys(pa, block.friction, would_sink(on.a - k.a, t.a, -one, -one, face, after))
    fits = fits and obeys(pb, block.friction, would_sink(on.b - k.b, t.b, one, -one, face, after))
    fits = fits and obeys(pc, block.friction, would_sink(on.c - k.c, t.c, -one, one, face, after))
    fits = fits and obeys(pd, block.friction, would_sink(on.d - k.d, t.d, one, one, face, after))
    v, o = after.v, after.o
    found = Velocity(v.x, v.y, v.z, o.x, o.y, o.z)
    return Held(fits, fits and count > zero, found, pa, pb, pc, pd)


@wp.func
def impulse_if(held: bool, p: Impulse, before: Impulse) -> Impulse:
    """The impulse p if `held`, else the one before. Zero is added so that no number is -0."""
    zero = real(0.0)
    return Impulse(
        wp.where(held, p.fx, before.fx) + zero, wp.where(held, p.fy, before.fy) + zero,
        wp.where(held, p.n, before.n) + zero,
    )  # fmt: skip


@wp.func
def velocity_if(held: bool, v: Velocity, before: Velocity) -> Velocity:
    """The velocity v if `held`, else the one before; likewise."""
    zero = real(0.0)
    return Velocity(
        wp.where(held, v.x, before.x) + zero, wp.where(held, v.y, before.y) + zero,
        wp.where(held, v.z, before.z) + zero, wp.where(held, v.turn_x, before.turn_x) + zero,
        wp.where(held, v.turn_y, before.turn_y) + zero,
        wp.where(held, v.turn_z, before.turn_z) + zero,
    )  # fmt: skip
