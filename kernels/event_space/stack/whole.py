"""Steps of a stack in space that moves as one body, or stands still.

Most steps of a stack that rocks have all of its faces closed and sticking but one. Below that the
blocks stand still; those above it are one rigid body that turns about a corner or an edge, as in
event_space/block/pack.py. In a stack that stands still all faces are closed and stick.

The *part* k of a stack is block k with all blocks above it; where block k stands still, up to the
first one that moves. Newton's and Euler's equations of a part give the impulse that its lowest face
takes in a step, and the moment of that. They hold if the corners of the overlap can share them out:
normal impulses linear in place, as of a bed of springs, none below zero; friction in proportion to
these, as one pull and a turn about the centre of pressure (as in event_space/body/face.py), within
the cone. Where this way to share does not do there may be others: the step of
event_space/stack/step.py decides. It also takes all steps with an event.

What moves is described in the axes of its lowest block, what stands below it in those of the base,
both from the middle of the corners at the hinge.
"""

import warp as wp

from warprock.kernels.algebra.vectors import Matrix, Quaternion, Vector
from warprock.kernels.event.block.begin import first_root
from warprock.kernels.event_space.block.moves import rotate_unnormalised
from warprock.kernels.event_space.block.pack import LEVEL, holds_hinge, level_edge, mobility_of
from warprock.kernels.event_space.block.trial import Base
from warprock.kernels.event_space.lane import Limits
from warprock.kernels.event_space.stack.contact import (
    INSIDE,
    PARALLEL,
    Ints,
    Own,
    block_of,
    find_corners,
    pose_of,
)
from warprock.kernels.event_space.stack.look import GRAIN, NEARLY, State
from warprock.kernels.shape.faces import SLOTS
from warprock.kernels.shape_space.body import spans
from warprock.kernels.shape_space.frame import frame
from warprock.kernels.shape_space.stack import (
    CONTACTS,
    UPPER,
    WHOLE,
    Axes,
    Bodies,
    Numbers,
    Points,
    rows_of,
)

LOWEST = 1
"""The lowest block."""
STUCK = by_precision(1.0e-6, 1.0e-4)
"""Velocity up to which blocks move as one, over theirs and what gravity gives in a step: far below
the slips and lifts that count (`LEFT_OUT`), above what closing gaps leaves of sticking contacts."""
CLOSED = by_precision(1.0e-9, 1.0e-4)
"""Gap up to which a corner is closed, as a part of the half height of the lowest block."""


@wp.struct
class Whole:
    """A stack as one body.

    Attributes:
        holds: Whether it is one.
        turns: Whether it turns about a hinge; else it stands still.
        lowest: The lowest block that moves; of a stack that stands still, its lowest one.
        level: Height of the face that the hinge is on [m].
        mobility: Inverse inertia about the hinge [1/(kg m^2)].
        way: Half the edge [m]; zero for a corner.
        over: Reciprocal of the length of the edge [1/m]; likewise.
        mass: Of each part [kg].
        centre: Of mass of each part [m].
        inertia: Of each part about its centre [kg m^2].
        blocks: Centre of mass of each block [m].
        axes: Directions of each face.
        count: Number of corners of each overlap.
        corners: Of each overlap from the centre of the part along the directions of the face [m];
            at the hinge the four of the block above it, from the hinge.
        middle: Mean of these corners [m].
        spread: Inverse of the mean products of their distances from it: xx, xy, yy [1/m^2].
    """

    holds: bool
    turns: bool
    lowest: int
    level: real
    mobility: Matrix
    way: Vector
    over: real
    mass: Numbers
    centre: Bodies
    inertia: Axes
    blocks: Bodies
    axes: Axes
    count: Ints
    corners: Points
    middle: Bodies
    spread: Bodies


@wp.struct
class Rolled:
    """The end of a step of a stack as one.

    Attributes:
        q: Attitude of the lowest block that moves.
        turn: Of all that move in the step [rad].
        rise: Direction of the edge before it was levelled.
        w: Angular velocity [rad/s].
        foot: Middle of the touching corners [m].
        deep: Penetration of that before it was put back on the base [m].
        lost: Energy lost in the frame of the base [J].
        clear: Whether the step has no event.
        cut: Length of the step to the landing of a corner inside, or NEVER [s].
    """

    q: Quaternion
    turn: Vector
    rise: Vector
    w: Vector
    foot: Vector
    deep: real
    lost: real
    clear: bool
    cut: real


@wp.func
def moves_as_one(own: Own, limits: Limits, s: State, lowest: int, foot: Vector) -> bool:
    """Whether blocks from `lowest` on turn about a point as one body, and those below stand."""
    h, apart, fall = block_of(own, lowest).half_height, real(0.0), limits.gravity
    v, w = s.v[lowest], s.w[lowest]
    bodies = int(BLOCKS + 1)
    for k in range(1, bodies):
        spin = wp.where(k < lowest, Vector(), w)
        slip = s.v[k] - wp.cross(spin, s.x[k] - foot)
        apart = larger(apart, wp.length(slip) + h * wp.length(s.w[k] - spin))
    return apart <= STUCK * (wp.length(v) + wp.length(w) * h + fall * limits.longest_step)


@wp.func
def lowest_that_moves(s: State) -> int:
    """The block above the only face that is not closed, on a corner or an edge of its own.

    The lowest one if the stack stands still; 0 if there is none or more than one.
    """
    lowest, fits, still = int(0), bool(True), s.still
    bodies = int(BLOCKS + 1)
    for k in range(1, bodies):
        on, there = s.touch[k], s.there[k]
        if there == 0 or on != there:
            # Corners 0 and 3, and 1 and 2, are no edge.
            hinged = on == 1 or on == 2 or on == 4 or on == 8
            hinged = hinged or on == 3 or on == 5 or on == 10 or on == 12
            fits = fits and hinged and there == WHOLE and lowest == 0
            lowest = int(k)
    if still and lowest == 0:
        return LOWEST
    return wp.where(fits and not still, lowest, 0)


@wp.func
def spread_of(on: wp.ref[Whole], k: int, pressing: int):
    """Middle of the corners of face k that press, and `spread` as of `Whole`; their number.

    The number is zero if they span no plane.
    """
    m, xx, xy, yy, number = Vector(), real(0.0), real(0.0), real(0.0), real(0.0)
    first, count = CONTACTS * (k - 1), on.count[k]
    for i in range(count):
        if (pressing & (1 << i)) != 0:
            m = m + on.corners[first + i]
            number += real(1.0)
    m = m / larger(number, real(1.0))
    for i in range(count):
        if (pressing & (1 << i)) != 0:
            r = on.corners[first + i] - m
            xx += r[0] * r[0]
            xy += r[0] * r[1]
            yy += r[1] * r[1]
    flat = spans(number, xx, xy, yy)
    over = number / wp.where(flat, xx * yy - xy * xy, real(1.0))
    return m, Vector(over * yy, -over * xy, over * xx), wp.where(flat, number, real(0.0))


@wp.func(inline=False)
def whole_of(own: Own, limits: Limits, s: State) -> Whole:
    """The stack of a state as one body, if it is one."""
    on, foot, zero = Whole(), Vector(), real(0.0)
    lowest = lowest_that_moves(s)
    if lowest == 0:
        return on
    pose = pose_of(own, s.x, s.q)
    close = CLOSED * block_of(own, LOWEST).half_height
    down = rows_of(pose.axes, lowest)
    on.lowest = lowest
    bodies = int(BLOCKS + 1)
    slots = int(SLOTS)
    on.turns = not s.still
    on.holds = True
    for below in range(BLOCKS):
        # From the top, since a part is a block and the part above it.
        k = BLOCKS - below
        block = block_of(own, k)
        above, off = zero + zero, Vector()
        inertia = rows_of(pose.inertia, k)
        if k < BLOCKS and k + 1 != lowest:
            above = on.mass[k + 1] + zero
            off = s.x[k] - on.centre[k + 1]
            inertia = inertia + rows_of(on.inertia, k + 1)
        mass = block.mass + above
        on.mass[k] = mass
        on.centre[k] = s.x[k] - (above / mass) * off
        square = wp.dot(off, off) * wp.identity(n=3, dtype=real) - wp.outer(off, off)
        inertia = inertia + (above * block.mass / mass) * square
        for i in range(3):
            on.inertia[3 * k + i] = inertia[i]
    # All of that is in the axes of the base so far.
    one, other, touching, height = Vector(), Vector(), int(0), real(0.0)
    for below in range(BLOCKS):
        k = below + 1
        places, gaps, there, _crossed = find_corners(own, pose, k)
        e = rows_of(pose.axes, k - 1)
        found = int(0)
        for i in range(slots):
            bit = 1 << i
            if (there & bit) != 0 and found < CONTACTS:
                at = s.x[k - 1] + wp.transpose(e) * places[i]
                on.corners[CONTACTS * (k - 1) + found] = at
                touches = (s.touch[k] & bit) != 0
                on.holds = on.holds and (not touches or s.still or size(gaps[i]) <= close)
                if k == lowest and touches:
                    other = at
                    if touching == 0:
                        one = at
                    touching += 1
                    foot = foot + at
                    height += at[2] - gaps[i] * e[2, 2]
                found += 1
        on.count[k] = found
    foot = foot / real(touching)
    on.level = height / real(touching)
    on.holds = on.holds and (s.still or moves_as_one(own, limits, s, lowest, foot))
    if not on.holds:
        return on
    for k in range(1, bodies):
        e = rows_of(pose.axes, k - 1)
        to = wp.identity(n=3, dtype=real)
        if k >= lowest:
            to = down
        axes = e * wp.transpose(to)
        mid = on.centre[k]
        found = on.count[k]
        for i in range(found):
            at = on.corners[CONTACTS * (k - 1) + i]
            off = e * (at - mid)
            if k == lowest and on.turns:
                off = down * (at - foot)
            on.corners[CONTACTS * (k - 1) + i] = off
        turned = to * rows_of(on.inertia, k) * wp.transpose(to)
        on.centre[k] = to * (mid - foot)
        on.blocks[k] = to * (s.x[k] - foot)
        for i in range(3):
            on.axes[3 * k + i] = axes[i]
            on.inertia[3 * k + i] = turned[i]
        m, spread, number = spread_of(on, k, (1 << found) - 1)
        on.middle[k] = m
        on.spread[k] = spread
        on.holds = on.holds and number > zero
    if on.turns:
        on.way = HALF * (down * (other - one))
        on.over = wp.where(touching == 1, zero, HALF / larger(wp.length(on.way), TINY))
        a = on.centre[lowest]
        square = wp.dot(a, a) * wp.identity(n=3, dtype=real) - wp.outer(a, a)
        on.mobility = mobility_of(
            rows_of(on.inertia, lowest) + on.mass[lowest] * square, (TWO * on.over) * on.way
        )
    return on


@wp.func
def carries(on: wp.ref[Whole], k: int, mu: real, push: Vector, twist: Vector) -> bool:
    """Whether a face carries the impulse of its part, and its moment about the part's centre."""
    zero, one, e, count = real(0.0), real(1.0), rows_of(on.axes, k), on.count[k]
    p, h, m, spread = e * push, e * twist, on.middle[k], on.spread[k]
    over, first = one / larger(p[2], TINY), CONTACTS * (k - 1)
    # The centre of pressure, and the moment about it.
    x, y = over * (m[2] * p[0] - h[1]), over * (h[0] + m[2] * p[1])
    along, across = over * p[0], over * p[1]
    torsion = over * h[2] - x * across + y * along
    pressing, left, number, polar = int(0), (1 << count) - 1, real(count), TINY + zero
    gx, gy = zero + zero, zero + zero
    while pressing != left and number > zero:
        # Corners that would pull are left out.
        if pressing != 0:
            m, spread, number = spread_of(on, k, left)
        pressing = int(left)
        gx = spread[0] * (x - m[0]) + spread[1] * (y - m[1])
        gy = spread[1] * (x - m[0]) + spread[2] * (y - m[1])
        polar = TINY + zero
        for i in range(count):
            r = on.corners[first + i]
            n = one + gx * (r[0] - m[0]) + gy * (r[1] - m[1])
            if (pressing & (1 << i)) != 0:
                if n < zero:
                    left = left & ~(1 << i)
                polar += n * ((r[0] - x) * (r[0] - x) + (r[1] - y) * (r[1] - y))
    turn, most = torsion * number / polar, zero + zero
    for i in range(count):
        if (pressing & (1 << i)) != 0:
            r = on.corners[first + i]
            tx, ty = along - turn * (r[1] - y), across + turn * (r[0] - x)
            most = larger(most, tx * tx + ty * ty)
    return p[2] > zero and number > zero and most < INSIDE * INSIDE * mu * mu


@wp.func
def find_landing(
    limits: Limits, on: wp.ref[Whole], n: Rolled, r: Matrix, s: State, grain: real, d: real
):  # fmt: skip
    """Events of the open corners at the hinge in a step that ends at the rotation `r`.

    Returns:
        Whether they stay clear of the face below; the length of the step to the first landing
        inside, or NEVER [s].
    """
    near, clear, zero = NEARLY * limits.longest_step, bool(True), real(0.0)
    first, k = NEVER + zero, on.lowest
    for i in range(UPPER):
        if (s.touch[k] & (1 << i)) == 0:
            corner = on.corners[CONTACTS * (k - 1) + i]
            r1 = r * corner
            if r1[2] <= limits.rest_gap:
                clear = False
                r0 = frame(s.q[k]) * corner
                rate0, rate = wp.cross(s.w[k], r0)[2], wp.cross(n.w, r1)[2]
                if d > near and r1[2] < -larger(near * size(rate) + grain, limits.rest_gap):
                    start = larger(r0[2], zero)
                    cut = first_root(start, rate0, r1[2], d)
                    if s.tries > 0:
                        # As in `look_at_step`.
                        cut = d - first_root(-r1[2], rate, -start, d)
                    first = smaller(first, cut)
    return clear, first


@wp.func(inline=False)
def roll(own: Own, limits: Limits, on: wp.ref[Whole], b: Base, s: State) -> Rolled:
    """The step of a stack as one body; see `roll` in event_space/block/pack.py."""
    d, n, lowest = b.d, Rolled(), on.lowest
    q, w, lever, inertia = s.q[lowest], s.w[lowest], on.centre[lowest], rows_of(on.inertia, lowest)
    n.cut = NEVER
    r0, middle = frame(q), frame(rotate_unnormalised(q, (HALF * d) * w))
    back = wp.transpose(middle)
    held = HALF * b.change + Vector(real(0.0), real(0.0), HALF * d * limits.gravity)
    turn, pull = back * r0, back * held
    # Angular velocity at the start, and its mean, in the block's axes.
    first = wp.transpose(r0) * w
    v = turn * wp.cross(first, lever)
    momentum, mass = turn * (inertia * first), on.mass[lowest]
    mean = on.mobility * (momentum + mass * wp.cross(lever, v - pull))
    # What the part that moves takes, its moment and its centre, in the axes of the base.
    load = middle * (mass * (wp.cross(mean, lever) - v + pull))
    moment, at = middle * (inertia * mean - momentum), middle * lever
    n.clear = True
    bodies = int(BLOCKS + 1)
    for k in range(1, bodies):
        c, own_inertia, mu = on.centre[k], rows_of(on.inertia, k), block_of(own, k).friction
        if k == lowest and on.turns:
            e = middle * ((on.over + on.over) * on.way)
            fits = holds_hinge(mu, load, moment, at, e, on.over)
        elif k < lowest:
            twist = moment + wp.cross(at - c, load)
            fits = carries(on, k, mu, load + on.mass[k] * held, twist)
        else:
            push = on.mass[k] * (wp.cross(mean, c) - turn * wp.cross(first, c) + pull)
            fits = carries(on, k, mu, push, own_inertia * mean - turn * (own_inertia * first))
        n.clear = n.clear and fits
    if not (on.turns and n.clear):
        return n
    n.turn = d * (middle * mean)
    n.q = rotate_unnormalised(q, n.turn)
    n.rise = frame(n.q) * ((on.over + on.over) * on.way)
    n.q = level_edge(n.q, n.rise)
    r = frame(n.q)
    reached = wp.transpose(r)
    spin = middle * (TWO * (inertia * mean)) - r0 * (inertia * first)
    raw = middle * (TWO * wp.cross(mean, lever)) - r0 * wp.cross(first, lever)
    last = on.mobility * (reached * spin + mass * wp.cross(lever, reached * raw))
    n.w = r * last
    foot = s.x[lowest] - r0 * on.blocks[lowest]
    n.foot = Vector(foot[0], foot[1], on.level)
    vm = middle * wp.cross(mean, lever)
    fall = (r0 * lever)[2] + foot[2] - on.level - (r * lever)[2]
    n.deep = -fall - d * vm[2]
    v0, v1 = wp.cross(first, lever), wp.cross(last, lever)
    n.lost = mass * (limits.gravity * fall - wp.dot(vm, b.change))
    n.lost += HALF * mass * (wp.dot(v0, v0) - wp.dot(v1, v1))
    n.lost += HALF * (wp.dot(first, inertia * first) - wp.dot(last, inertia * last))
    total = wp.length(n.w) + n.lost + n.foot[0] + n.foot[1]
    n.clear = size(n.rise[2]) < LEVEL and total - total == real(0.0)
    n.clear = n.clear and r[2, 2] > PARALLEL
    if n.clear:
        grain = GRAIN * block_of(own, LOWEST).half_height
        clear, cut = find_landing(limits, on, n, r, s, grain, d)
        n.clear = clear
        n.cut = cut
    return n


@wp.func
def state_after(on: wp.ref[Whole], s: State, n: Rolled) -> State:
    """The state with all that moves moved as one; the clock is that of `s`."""
    after = s
    r = frame(n.q)
    after.v = Bodies()
    after.w = Bodies()
    after.turn = Bodies()
    bodies = int(BLOCKS + 1)
    for k in range(on.lowest, bodies):
        arm = r * on.blocks[k]
        after.x[k] = n.foot + arm
        after.q[k] = level_edge(rotate_unnormalised(s.q[k], n.turn), n.rise)
        after.v[k] = wp.cross(n.w, arm)
        after.w[k] = n.w
        after.turn[k] = n.turn
    after.lost = s.lost + n.lost
    after.deepest = larger(s.deepest, n.deep)
    return after
