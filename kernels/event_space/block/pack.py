"""The event step in space in which nothing happens, as vector code.

Most steps have no event: the block lies flat on a base that does not move it, or turns about a
sticking corner or edge. The touching corners are then a hinge, and the step of
event_space/block/step.py has a single case. `roll` takes that step. Its `clear` is False if the
block slides, lifts, opens at one end or overturns, or is close to it. If a corner lands inside the
step, it gives the time. All of this depends on the lane alone.

The formulas are those of event_space/block/step.py, in the block's own axes where that is less
work. Both agree to round-off. Friction is the cone.

This second text of the step exists because the first one is slower: 512 blocks that rock under
sines along x and y take 3.9 million steps a second on a core with it, 0.76 million without
(float32: 2.1 and 1.1 million; AMD EPYC with 512-bit vectors, November 2026).
"""

import warp as wp

from warprock.kernels.algebra.vectors import Matrix, Quaternion, Vector
from warprock.kernels.event_space.block.contact import EDGE, FLAT
from warprock.kernels.event_space.block.moves import (
    GRAIN,
    corner_event,
    cut_to,
    rotate_unnormalised,
)
from warprock.kernels.event_space.block.step import NEARLY
from warprock.kernels.event_space.block.trial import Base, State
from warprock.kernels.event_space.lane import Limits
from warprock.kernels.shape_space.block import Block
from warprock.kernels.shape_space.lanes import matrix_of, product

SPARE = by_precision(1.0e-3, 1.0e-1)
"""Margin of friction, as a part of it, that each end of an edge must have at the end of a step to
hold on for a moment more: ten times the part of a step by which `find_release` looks ahead."""
LEVEL = real(1.0e-6)
"""Largest slope of an edge that one small turn levels to round-off."""


@wp.struct
class Hinge:
    """The sticking contacts that a block turns about, in its own axes.

    Attributes:
        lever: From the middle of the touching corners to the centre of mass [m].
        mobility: Inverse inertia about the hinge for unit mass [1/m^2], entries 11, 22 and 33.
        mixed: Its entries 12, 13 and 23.
        way: Half the edge [m]; zero for a corner and a face.
        over: Reciprocal of the length of the edge [1/m]; likewise.
        open: From the touching corners to the others, along the width and the depth [m].
        inertia: About the block's own axes for unit mass [m^2].
    """

    lever: Vector
    mobility: Vector
    mixed: Vector
    way: Vector
    over: real
    open: Vector
    inertia: Vector


@wp.struct
class Rolled:
    """The end of a step about a hinge; fields as in `State`, and these.

    Attributes:
        deep: Penetration of a corner [m].
        clear: Whether the step has no event.
        met: Whether the first event is the landing of a corner inside the step.
        cut: Length of the step to that [s].
    """

    q: Quaternion
    x: Vector
    v: Vector
    w: Vector
    turn: Vector
    swing: Vector
    deep: real
    clear: bool
    met: bool
    cut: real


@wp.func(inline=True)
def mobility_of(about: Matrix, e: Vector) -> Matrix:
    """Inverse of an inertia about a point, or about an axis e through it if that is not zero."""
    m = wp.outer(e, e) * (real(1.0) / larger(wp.dot(e, about * e), TINY))
    if wp.dot(e, e) == real(0.0):
        m = wp.inverse(about)
    return m


@wp.func(inline=True)
def hinge_of(block: Block, stance: int) -> Hinge:
    """The hinge of a stance; a flat block does not turn."""
    zero, one = real(0.0), real(1.0)
    h = Hinge()
    k = stance % 4
    edge = stance >= EDGE and stance < FLAT
    wide = edge and k % 2 == 0
    deep = edge and k % 2 == 1
    x = wp.where(k == 1 or k == 2, block.half_width, -block.half_width)
    y = wp.where(k >= 2, block.half_depth, -block.half_depth)
    x = wp.where(wide or stance >= FLAT, zero, x)
    y = wp.where(deep or stance >= FLAT, zero, y)
    a = Vector(block.centre_x - x, block.centre_y - y, block.half_height)
    inertia = Vector(one / block.inverse_x, one / block.inverse_y, one / block.inverse_z)
    h.lever = a
    h.inertia = inertia
    h.open = Vector(-x - x, -y - y, zero)
    if stance < EDGE:
        about = wp.diag(inertia) + wp.dot(a, a) * wp.identity(n=3, dtype=real) - wp.outer(a, a)
        m = wp.inverse(about)
        h.mobility = Vector(m[0, 0], m[1, 1], m[2, 2])
        h.mixed = Vector(m[0, 1], m[0, 2], m[1, 2])
    if wide:
        h.way = Vector(block.half_width, zero, zero)
        h.over = HALF / block.half_width
        h.mobility = Vector(one / (inertia[0] + a[1] * a[1] + a[2] * a[2]), zero, zero)
    if deep:
        h.way = Vector(zero, block.half_depth, zero)
        h.over = HALF / block.half_depth
        h.mobility = Vector(zero, one / (inertia[1] + a[0] * a[0] + a[2] * a[2]), zero)
    return h


@wp.func(inline=True)
def frame(q: Quaternion) -> Matrix:
    """Rotation matrix of an attitude."""
    r = matrix_of(q[0], q[1], q[2], q[3])
    return Matrix(r.r11, r.r12, r.r13, r.r21, r.r22, r.r23, r.r31, r.r32, r.r33)


@wp.func(inline=True)
def in_base(r: Matrix, v: Vector) -> Vector:
    """A vector of the body's own axes in those of the base."""
    return Vector(
        product(r[0, 0], r[0, 1], r[0, 2], v[0], v[1], v[2]),
        product(r[1, 0], r[1, 1], r[1, 2], v[0], v[1], v[2]),
        product(r[2, 0], r[2, 1], r[2, 2], v[0], v[1], v[2]),
    )


@wp.func(inline=True)
def in_body(r: Matrix, v: Vector) -> Vector:
    """A vector of the base's axes in those of the body."""
    return in_base(wp.transpose(r), v)


@wp.func(inline=True)
def scale_in_body(r: Matrix, d: Vector, v: Vector) -> Vector:
    """A vector times a diagonal matrix of the body's own axes."""
    b = in_body(r, v)
    return in_base(r, Vector(d[0] * b[0], d[1] * b[1], d[2] * b[2]))


@wp.func(inline=True)
def turn_about_hinge(h: Hinge, r: Matrix, spin: Vector) -> Vector:
    """Angular velocity about a hinge, from the angular momentum about it."""
    b = in_body(r, spin)
    m = h.mobility
    n = h.mixed
    wx = product(m[0], n[0], n[1], b[0], b[1], b[2])
    wy = product(n[0], m[1], n[2], b[0], b[1], b[2])
    wz = product(n[1], n[2], m[2], b[0], b[1], b[2])
    return in_base(r, Vector(wx, wy, wz))


@wp.func(inline=True)
def level_edge(q: Quaternion, rise: Vector) -> Quaternion:
    """The attitude with the edge along `rise`, a unit vector, level to round-off."""
    a = Vector(-rise[1], rise[0], real(0.0)) * (HALF * rise[2])
    n = Quaternion(
        q[0] + a[0] * q[3] + a[1] * q[2],
        q[1] + a[1] * q[3] - a[0] * q[2],
        q[2] + a[0] * q[1] - a[1] * q[0],
        q[3] - a[0] * q[0] - a[1] * q[1],
    )
    return n * (real(1.5) - HALF * wp.dot(n, n))


@wp.func(inline=True)
def end_margins(mu: real, p: Vector, twist: Vector, arm: Vector, e: Vector, over: real):
    """Friction margins of both ends of an edge, see `edge_carries`.

    `over` is the reciprocal of the length of the edge [1/m]. A corner counts as two ends that share
    its impulse by halves; its `e` is zero.

    Returns:
        The smaller margin, the smaller normal impulse, and a lower bound of the square of the
        margin along the edge.
    """
    q = wp.cross((twist + wp.cross(arm, p)) * over, e)
    one = HALF * p - q
    other = HALF * p + q
    most1 = mu * one[2]
    most2 = mu * other[2]
    room1 = most1 - size(one[1] * e[0] - one[0] * e[1])
    room2 = most2 - size(other[1] * e[0] - other[0] * e[1])
    more = room1 * (most1 + most1 - room1) + room2 * (most2 + most2 - room2)
    return smaller(room1, room2), smaller(one[2], other[2]), more


@wp.func(inline=True)
def holds_hinge(mu: real, p: Vector, twist: Vector, arm: Vector, e: Vector, over: real) -> bool:
    """Whether friction and weight hold a hinge; arguments as of `end_margins`."""
    zero = real(0.0)
    room, push, more = end_margins(mu, p, twist, arm, e, over)
    along = wp.dot(p, e)
    sticks = over > zero or p[0] * p[0] + p[1] * p[1] <= mu * mu * p[2] * p[2]
    return sticks and room >= zero and push >= zero and along * along <= more


@wp.struct
class Instant:
    """A block that turns about a hinge, at one end of a step.

    Its rotation matrix; arm, the lever of the hinge in the axes of the base [m]; velocity [m/s] and
    angular velocity [rad/s].
    """

    r: Matrix
    arm: Vector
    v: Vector
    w: Vector


@wp.func(inline=True)
def keeps_end(h: Hinge, mu: real, now: Instant, w: Vector, pull: Vector) -> bool:
    """Whether both ends of an edge go on to stick, at the acceleration `pull` of the base."""
    e = in_base(now.r, h.way) * (h.over + h.over)
    bend = turn_about_hinge(h, now.r, wp.cross(pull, now.arm))
    p = wp.cross(bend, now.arm) + wp.cross(w, wp.cross(w, now.arm)) + pull
    room, _push, _more = end_margins(
        mu, p, scale_in_body(now.r, h.inertia, bend), now.arm, e, h.over
    )
    return room > SPARE * mu * size(p[2])


@wp.func(inline=True)
def stays_at_rest(block: Block, gravity: real, r: Matrix, a: Vector) -> bool:
    """Whether a flat block stays at rest at an acceleration of the base, see `lack_of`."""
    weight = gravity + a[2]
    along = r[0, 0] * a[0] + r[1, 0] * a[1]
    across = r[0, 1] * a[0] + r[1, 1] * a[1]
    low = weight / block.half_height
    slack = block.friction * weight
    return (
        weight > real(0.0)
        and a[0] * a[0] + a[1] * a[1] < slack * slack
        and size(along - low * block.centre_x) < low * block.half_width
        and size(across - low * block.centre_y) < low * block.half_depth
    )


@wp.func(inline=True)
def rise_rate(v: Vector, w: Vector, c: Vector) -> real:
    """Vertical velocity of a point of the block [m/s]."""
    return fused_less(w[1], c[0], fused(w[0], c[1], v[2]))


@wp.func(inline=True)
def open_event(limits: Limits, d: real, grain: real, away: Vector, first: Instant, last: Instant):
    """Events of an open corner in a step, see `corner_event`; `away` leads to it from the hinge.

    Returns:
        Length of the step to its landing if that lies inside, else NEVER; whether it lands at the
        end or closes at once; whether it closes. If `away` is zero, the corner touches.
    """
    c0 = in_base(first.r, away)
    c1 = in_base(last.r, away)
    cut, lands, closes = corner_event(
        c0[2], rise_rate(first.v, first.w, c0 - first.arm),
        c1[2], rise_rate(last.v, last.w, c1 - last.arm), d,
        NEARLY * limits.longest_step, grain, limits.rest_gap,
    )  # fmt: skip
    touches = away[0] == real(0.0) and away[1] == real(0.0)
    happens = (lands or closes) and not touches
    return wp.where(touches, NEVER, cut), happens, closes and not touches


@wp.func(inline=True)
def mean_motion(block: Block, h: Hinge, free: Vector, momentum: Vector, middle: Matrix):
    """The mean motion of a step about a hinge.

    Returns:
        Velocity, angular velocity and angular momentum; whether friction can hold the hinge.
    """
    arm = in_base(middle, h.lever)
    w = turn_about_hinge(h, middle, momentum + wp.cross(arm, free))
    v = wp.cross(w, arm)
    p = v - free
    spun = scale_in_body(middle, h.inertia, w)
    e = in_base(middle, h.way) * (h.over + h.over)
    holds = holds_hinge(block.friction, p, spun - momentum, arm, e, h.over)
    return v, w, spun, holds


@wp.func(inline=True)
def find_events(
    block: Block, limits: Limits, b: Base, h: Hinge, flat: bool, first: Instant, last: Instant,
    w: Vector,
):  # fmt: skip
    """Events of a step about a hinge, as in `apply_events`; w is the angular velocity at its end.

    Returns:
        Whether there is none; whether the first one is the landing of a corner inside the step; the
        length of the step to that.
    """
    zero = real(0.0)
    near = NEARLY * limits.longest_step
    grain = GRAIN * block.half_height
    # Of three open corners the farthest is higher than one of the others.
    x = Vector(h.open[0], zero, zero)
    y = Vector(zero, h.open[1], zero)
    cut_x, any_x, closes_x = open_event(limits, b.d, grain, x, first, last)
    cut_y, any_y, closes_y = open_event(limits, b.d, grain, y, first, last)
    cut = smaller(cut_x, cut_y)
    inside = cut < NEVER
    pull = b.last + Vector(zero, zero, limits.gravity)
    keeps = h.over == zero or keeps_end(h, block.friction, last, w, pull)
    rolls = keeps and not (inside or any_x or any_y)
    rests = stays_at_rest(block, limits.gravity, first.r, b.first)
    rests = rests and stays_at_rest(block, limits.gravity, first.r, b.last)
    met = inside and not (flat or closes_x or closes_y)
    return wp.where(flat, rests, rolls), met, cut_to(cut, b.d, near)


@wp.func(inline=True)
def roll(block: Block, limits: Limits, b: Base, h: Hinge, s: State) -> Rolled:
    """The step of a block about a hinge."""
    zero = real(0.0)
    x, q, v, w = s.x, s.q, s.v, s.w
    flat = s.stance == FLAT
    n = Rolled()
    d = b.d
    inverse = Vector(block.inverse_x, block.inverse_y, block.inverse_z)
    r0 = frame(q)
    a0 = in_base(r0, h.lever)
    momentum = scale_in_body(r0, h.inertia, w)
    middle = frame(rotate_unnormalised(q, w * (HALF * d)))
    free = v - HALF * b.change - Vector(zero, zero, HALF * d * limits.gravity)
    v_mean, w_mean, spun, holds = mean_motion(block, h, free, momentum, middle)
    n.turn = d * w_mean
    n.q = rotate_unnormalised(q, n.turn)
    rise = in_base(frame(n.q), h.way) * (h.over + h.over)
    n.q = level_edge(n.q, rise)
    r = frame(n.q)
    a1 = in_base(r, h.lever)
    n.deep = a1[2] - x[2] - d * v_mean[2]
    n.x = Vector(x[0] + a1[0] - a0[0], x[1] + a1[1] - a0[1], a1[2])
    if flat:
        n.q = q
        n.x = x
    raw = TWO * v_mean - v
    spin = TWO * spun - momentum
    n.swing = scale_in_body(r, inverse, spin)
    n.w = turn_about_hinge(h, r, spin + wp.cross(a1, raw))
    n.v = wp.cross(n.w, a1)
    fall = NEARLY * limits.longest_step * wp.length(n.swing)
    upright = size(rise[2]) < LEVEL and r[2, 2] > TWO * fall
    first, last = Instant(r0, a0, v, w), Instant(r, a1, raw, n.swing)
    clear, met, cut = find_events(block, limits, b, h, flat, first, last, n.w)
    n.clear = holds and clear and (flat or upright)
    n.met = holds and met and upright
    n.cut = cut
    return n
