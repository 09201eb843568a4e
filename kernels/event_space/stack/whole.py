"""Steps of a stack in space that moves as one body, or stands still.

Most steps of a stack that rocks have its upper faces closed and sticking: all of it turns about a
corner or an edge of the lowest block. It is one rigid body then, with a hinge as in
event_space/block/pack.py. A stack that stands still is one body, too, on all of its faces.

All is in the axes of the lowest block, from the middle of its touching corners. The *part* k of a
stack is block k with all blocks above it. Newton's and Euler's equations of a part give the
impulse that its lowest face takes in a step, and the moment of that. They hold if the corners of
the overlap can share them out: normal impulses linear in place, as of a bed of springs, none below
zero; friction in proportion to these, as one pull and a turn about the centre of pressure (as in
event_space/body/face.py), within the cone. Where this way to share does not do there may be others:
the step of event_space/stack/step.py decides. It also takes all steps with an event.
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
    Axes,
    Bodies,
    Numbers,
    Points,
    rows_of,
)

LOWEST = 1
"""The lowest block, and the part that is the whole stack."""
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
            of a stack that turns the four of the lowest block, from the hinge.
        middle: Mean of these corners [m].
        spread: Inverse of the mean products of their distances from it: xx, xy, yy [1/m^2].
    """

    holds: bool
    turns: bool
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
        q: Attitude of the lowest block.
        turn: Of all blocks in the step [rad].
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
def moves_as_one(own: Own, limits: Limits, s: State, foot: Vector) -> bool:
    """Whether all blocks have the velocities of one body that turns about a point."""
    h, apart = block_of(own, LOWEST).half_height, real(0.0)
    speed = (
        wp.length(s.v[LOWEST]) + wp.length(s.w[LOWEST]) * h + limits.gravity * limits.longest_step
    )
    bodies = int(BLOCKS + 1)
    for k in range(1, bodies):
        slip = s.v[k] - wp.cross(s.w[LOWEST], s.x[k] - foot)
        apart = larger(apart, wp.length(slip) + h * wp.length(s.w[k] - s.w[LOWEST]))
    return apart <= STUCK * speed


@wp.func
def is_closed(s: State) -> bool:
    """Whether all upper faces touch at all corners, and the lowest block at a hinge or at rest."""
    on, closed = s.touch[LOWEST], bool(True)
    bodies = int(BLOCKS + 1)
    for k in range(2, bodies):
        closed = closed and s.there[k] != 0 and s.touch[k] == s.there[k]
    # Corners 0 and 3, and 1 and 2, are no edge.
    hinged = on == 1 or on == 2 or on == 4 or on == 8
    hinged = hinged or on == 3 or on == 5 or on == 10 or on == 12
    return closed and (s.still or hinged)


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
    if not is_closed(s):
        return on
    pose = pose_of(own, s.x, s.q)
    close = CLOSED * block_of(own, LOWEST).half_height
    down = rows_of(pose.axes, LOWEST)
    bodies = int(BLOCKS + 1)
    slots = int(SLOTS)
    on.turns = not s.still
    on.holds = True
    for below in range(BLOCKS):
        # From the top, since a part is the one above it and a block.
        k = BLOCKS - below
        block = block_of(own, k)
        above, off = zero + zero, Vector()
        inertia = rows_of(pose.inertia, k)
        if k < BLOCKS:
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
    one, other, touching = Vector(), Vector(), int(0)
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
                if k == LOWEST and touches:
                    other = at
                    if touching == 0:
                        one = at
                    touching += 1
                    foot = foot + at
                found += 1
        on.count[k] = found
    foot = foot / real(touching)
    on.holds = on.holds and (s.still or moves_as_one(own, limits, s, foot))
    for k in range(1, bodies):
        e = rows_of(pose.axes, k - 1)
        axes = e * wp.transpose(down)
        mid = on.centre[k]
        found = on.count[k]
        for i in range(found):
            at = on.corners[CONTACTS * (k - 1) + i]
            if k == LOWEST and on.turns:
                on.corners[i] = down * (at - foot)
            else:
                on.corners[CONTACTS * (k - 1) + i] = e * (at - mid)
        turned = down * rows_of(on.inertia, k) * wp.transpose(down)
        on.centre[k] = down * (mid - foot)
        on.blocks[k] = down * (s.x[k] - foot)
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
        a = on.centre[LOWEST]
        square = wp.dot(a, a) * wp.identity(n=3, dtype=real) - wp.outer(a, a)
        on.mobility = mobility_of(
            rows_of(on.inertia, LOWEST) + on.mass[LOWEST] * square, (TWO * on.over) * on.way
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
    """Events of the open corners of the lowest block in a step that ends at the rotation `r`.

    Returns:
        Whether they stay clear of the base; the length of the step to the first landing inside, or
        NEVER [s].
    """
    near, clear, zero = NEARLY * limits.longest_step, bool(True), real(0.0)
    first = NEVER + zero
    for i in range(UPPER):
        if (s.touch[LOWEST] & (1 << i)) == 0:
            r1 = r * on.corners[i]
            if r1[2] <= limits.rest_gap:
                clear = False
                r0 = frame(s.q[LOWEST]) * on.corners[i]
                rate0, rate = wp.cross(s.w[LOWEST], r0)[2], wp.cross(n.w, r1)[2]
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
    zero, d, n = real(0.0), b.d, Rolled()
    q, w, lever, inertia = s.q[LOWEST], s.w[LOWEST], on.centre[LOWEST], rows_of(on.inertia, LOWEST)
    n.cut = NEVER
    r0, middle = frame(q), frame(rotate_unnormalised(q, (HALF * d) * w))
    back = wp.transpose(middle)
    turn, pull = back * r0, back * (HALF * b.change + Vector(zero, zero, HALF * d * limits.gravity))
    # Angular velocity at the start, and its mean, in the block's axes.
    first = wp.transpose(r0) * w
    v = turn * wp.cross(first, lever)
    momentum, mass = turn * (inertia * first), on.mass[LOWEST]
    mean = on.mobility * (momentum + mass * wp.cross(lever, v - pull))
    n.clear = True
    bodies = int(BLOCKS + 1)
    for k in range(1, bodies):
        c, own_inertia, mu = on.centre[k], rows_of(on.inertia, k), block_of(own, k).friction
        push = on.mass[k] * (wp.cross(mean, c) - turn * wp.cross(first, c) + pull)
        twist = own_inertia * mean - turn * (own_inertia * first)
        if k == LOWEST and on.turns:
            e = middle * ((on.over + on.over) * on.way)
            fits = holds_hinge(mu, middle * push, middle * twist, middle * c, e, on.over)
        else:
            fits = carries(on, k, mu, push, twist)
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
    foot = s.x[LOWEST] - r0 * on.blocks[LOWEST]
    n.foot = Vector(foot[0], foot[1], zero)
    vm = middle * wp.cross(mean, lever)
    fall = (r0 * lever)[2] + foot[2] - (r * lever)[2]
    n.deep = -fall - d * vm[2]
    v0, v1 = wp.cross(first, lever), wp.cross(last, lever)
    n.lost = mass * (limits.gravity * fall - wp.dot(vm, b.change))
    n.lost += HALF * mass * (wp.dot(v0, v0) - wp.dot(v1, v1))
    n.lost += HALF * (wp.dot(first, inertia * first) - wp.dot(last, inertia * last))
    total = wp.length(n.w) + n.lost + n.foot[0] + n.foot[1]
    n.clear = size(n.rise[2]) < LEVEL and total - total == zero
    n.clear = n.clear and r[2, 2] > PARALLEL
    if n.clear:
        grain = GRAIN * block_of(own, LOWEST).half_height
        clear, cut = find_landing(limits, on, n, r, s, grain, d)
        n.clear = clear
        n.cut = cut
    return n


@wp.func
def state_after(on: wp.ref[Whole], s: State, n: Rolled) -> State:
    """The state with all blocks moved as one; its clock is still that of the start."""
    after = s
    r = frame(n.q)
    bodies = int(BLOCKS + 1)
    for k in range(1, bodies):
        arm = r * on.blocks[k]
        after.x[k] = n.foot + arm
        after.q[k] = level_edge(rotate_unnormalised(s.q[k], n.turn), n.rise)
        after.v[k] = wp.cross(n.w, arm)
        after.w[k] = n.w
        after.turn[k] = n.turn
    after.lost = s.lost + n.lost
    after.deepest = larger(s.deepest, n.deep)
    return after
