"""How the blocks of a stack move in a step, and what happens to them there: event/stack.py.

For one precision, motion and number of blocks. Poses are those of shape/stack.py.
"""

import warp as wp

from warprock.kernels.event.block_begin import first_root
from warprock.kernels.shape.stack import (
    ALIKE,
    CLOSED,
    MINUS,
    OPEN,
    PLUS,
    Blocks,
    Counts,
    Pose,
    Triples,
    Values,
    anchored,
    between,
    carried,
    ends_below,
    face_middles,
    flat_rotation,
    interface_rows,
    leaning,
    lower_face,
    side_of,
    three_of,
    turn_of,
    upright_place,
    with_foot,
)

DEEP = real(1.0e-6)
"""Part of the half height by which an open end may lie too low and still land."""
GRAIN = by_precision(1.0e-15, 1.0e-6)
"""Round-off of a rotation [rad], and of a gap as a part of the half height."""


@wp.func
def started(blocks: Blocks, pose: Pose) -> Pose:
    """A pose from its rotations, `along` being that of blocks turned flat about their corners."""
    p = pose
    for k in range(BLOCKS):
        p.sine[k] = sine(p.theta[k])
        p.cosine[k] = cosine(p.theta[k])
        if CHAINS:
            p = with_foot(blocks, p, k)
        _s, _c, sd, cd = between(p, k)
        touch = leaning(turn_of(p, k))
        p.touch[k] = touch
        side = side_of(touch)
        low, _height = lower_face(blocks, k)
        anchor = p.along[k] + side * blocks.half_width[k]
        rate = real(1.0)
        if side * anchor > ALIKE * low:
            anchor = side * low - p.along[k]
            rate = real(-1.0)
        if touch == CLOSED:
            anchor = p.along[k]
            rate = real(1.0)
        along, above = carried(blocks, k, touch, anchor, rate, sd, cd)
        p.along[k] = along
        p.above[k] = above
    return p


@wp.func
def flown(blocks: Blocks, old: Pose, new: Pose, velocity: Triples, k: int, d: real):
    """Along and above of an open interface after a time d at constant velocities."""
    s0, c0, _sd0, _cd0 = between(old, k)
    s1, c1, _sd1, _cd1 = between(new, k)
    _low, low_height = lower_face(blocks, k)
    height = blocks.half_height[k]
    v = three_of(velocity, k)
    x = old.along[k] * c0 + old.above[k] * s0 + d * v[0]
    z = old.above[k] * c0 - old.along[k] * s0 + d * v[1]
    if k > 0:
        below = three_of(velocity, k - 1)
        x = x - d * below[0]
        z = z - d * below[1]
    if CHAINS:
        upper, lower = face_middles(blocks, k)
        su = new.foot_sine[k] - old.foot_sine[k]
        cu = new.foot_cosine[k] - old.foot_cosine[k]
        x = x - height * su + upper * cu - low_height * (s1 - s0) - lower * (c1 - c0)
        z = z - height * cu - upper * su - low_height * (c1 - c0) + lower * (s1 - s0)
    else:
        x = x - height * (new.sine[k] - old.sine[k]) - low_height * (s1 - s0)
        z = z - height * (new.cosine[k] - old.cosine[k]) - low_height * (c1 - c0)
    return x * c1 - z * s1, z * c1 + x * s1


@wp.func(inline=False)
def moved(
    blocks: Blocks, old: Pose, touch: Counts, velocity: Triples, slide: Values, d: real
) -> Pose:
    """Pose after a time d at constant velocities, contacts carried along; slide [m/s] of each."""
    new = Pose()
    new.touch = touch
    for k in range(BLOCKS):
        theta = old.theta[k] + d * velocity[3 * k + 2]
        if touch[k] == CLOSED:
            theta = flat_rotation(blocks, new, k)
        new.theta[k] = theta
        new.sine[k] = sine(theta)
        new.cosine[k] = cosine(theta)
        if CHAINS:
            new = with_foot(blocks, new, k)
        if touch[k] == OPEN:
            along, above = flown(blocks, old, new, velocity, k, d)
            new.along[k] = along
            new.above[k] = above
        else:
            anchor, rate = anchored(blocks, old, k, touch[k])
            anchor = anchor + rate * d * slide[k]
            _s, _c, sd, cd = between(new, k)
            along, above = carried(blocks, k, touch[k], anchor, rate, sd, cd)
            new.along[k] = along
            new.above[k] = above
    return new


@wp.func
def opening(pose: Pose, velocity: Triples, k: int, touch: int):
    """How far [rad] and how fast [rad/s] a pivoting interface is open."""
    turn = turn_of(pose, k)
    rate = velocity[3 * k + 2]
    if k > 0:
        rate = rate - velocity[3 * k - 1]
    side = side_of(touch)
    return side * turn, side * rate


@wp.func
def pivot_event(
    e0: real, r0: real, e1: real, r1: real, bend: real, d: real, near: real, fresh: bool, rest: real
):
    """What a pivoting interface does in a step, from its opening and rate at both ends.

    `bend` is half of the acceleration with which it opens [rad/s^2].

    Returns:
        Length of the step to its impact if that lies inside, else NEVER; whether it falls flat at
        the end of the step; whether it rests at once (`fresh`: it pivots since an impact).
    """
    zero = real(0.0)
    reach = near * size(r1) + GRAIN
    cut = NEVER
    falls = bool(False)
    rests = bool(False)
    if e1 < -reach and d > near:
        cut = first_root(larger(e0, zero), r0, e1, d)
        rests = fresh and e0 <= GRAIN and (r0 <= zero or r0 * r0 <= real(-4.0) * bend * rest)
    elif e1 <= reach and (r1 < zero or e1 <= zero):
        falls = True
    return cut, falls, rests


@wp.func(inline=False)
def flight_event(
    blocks: Blocks, old: Pose, new: Pose, v0: Triples, v1: Triples, k: int, d: real, near: real
):
    """What an open interface does in a step.

    Returns:
        Length of the step to its landing if that lies inside, else NEVER; the ends that land at the
        end of the step, else OPEN; the smaller gap there [m].
    """
    zero = real(0.0)
    up0, low0, plus0, minus0 = interface_rows(blocks, old, k)
    up1, low1, plus1, minus1 = interface_rows(blocks, new, k)
    u0 = up0 * three_of(v0, k)
    u1 = up1 * three_of(v1, k)
    if k > 0:
        u0 = u0 + low0 * three_of(v0, k - 1)
        u1 = u1 + low1 * three_of(v1, k - 1)
    grain = GRAIN * blocks.half_height[k]
    cut = NEVER
    lands = int(OPEN)
    for end in range(2):
        g0 = wp.where(end == 0, plus0, minus0)
        g1 = wp.where(end == 0, plus1, minus1)
        r0 = u0[1 + end]
        r1 = u1[1 + end]
        reach = near * size(r1) + grain
        # An end that lies far too low touches the side of a block: that contact is not modelled.
        if g0 >= -DEEP * blocks.half_height[k]:
            if g1 < smaller(g0, zero) - reach and d > near:
                cut = smaller(cut, first_root(larger(g0, zero), r0, g1, d))
            elif g1 <= reach and r1 < zero:
                lands = lands + wp.where(end == 0, PLUS, MINUS)
    return cut, lands, smaller(plus1, minus1)


@wp.func(inline=False)
def flattened(blocks: Blocks, old: Pose, falls: Counts) -> Pose:
    """The pose with fallen blocks flat on what is below, and landed ends put on their faces."""
    new = Pose()
    for k in range(BLOCKS):
        was = old.touch[k]
        touch = wp.where(falls[k] == OPEN, was, falls[k])
        if was == OPEN:
            was = wp.where(touch == CLOSED, ends_below(old, k), touch)
        theta = old.theta[k]
        if touch == CLOSED:
            theta = flat_rotation(blocks, new, k)
        new.theta[k] = theta
        new.sine[k] = sine(theta)
        new.cosine[k] = cosine(theta)
        if CHAINS:
            new = with_foot(blocks, new, k)
        new.touch[k] = touch
        new.along[k] = old.along[k]
        new.above[k] = old.above[k]
        if touch != OPEN:
            anchor, rate = anchored(blocks, old, k, was)
            if touch == CLOSED:
                anchor = upright_place(blocks, k, was, anchor, rate)
            _s, _c, sd, cd = between(new, k)
            along, above = carried(blocks, k, touch, anchor, rate, sd, cd)
            new.along[k] = along
            new.above[k] = above
    return new


@wp.func(inline=False)
def glued(blocks: Blocks, pose: Pose, slip: Counts, velocity: Triples) -> Triples:
    """Velocities without round-off at closed interfaces: one rotation, one motion if they stick."""
    v = velocity
    for k in range(BLOCKS):
        if pose.touch[k] == CLOSED:
            omega = real(0.0)
            x = real(0.0)
            z = real(0.0)
            if k > 0:
                s = pose.sine[k - 1]
                c = pose.cosine[k - 1]
                _low, low_height = lower_face(blocks, k)
                rise = low_height + blocks.half_height[k]
                along = pose.along[k]
                if CHAINS:
                    upper, lower = face_middles(blocks, k)
                    along = along + lower - upper
                omega = v[3 * k - 1]
                x = v[3 * k - 3] + omega * (rise * c - along * s)
                z = v[3 * k - 2] - omega * (along * c + rise * s)
            v[3 * k + 2] = omega
            if slip[k] == 0:
                v[3 * k] = x
                v[3 * k + 1] = z
    return v
