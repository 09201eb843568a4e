"""How the blocks of a stack move in a step, and which events end it: event/stack/step.py.

Poses are those of shape/stack.py.
"""

import warp as wp

from warprock.kernels.event.block.begin import first_root
from warprock.kernels.event.stack.state import GRAIN, NEARLY, Limits, State, Trial
from warprock.kernels.shape.stack import (
    ALIKE,
    CLOSED,
    MINUS,
    OPEN,
    PLUS,
    Anchor,
    Blocks,
    Counts,
    Pose,
    Triples,
    Values,
    ends_below,
    face_above,
    face_below,
    face_middles,
    find_anchor,
    flat_rotation,
    interface_rows,
    lower_face,
    nearest_ends,
    place_block,
    side_of,
    slide_place,
    three_of,
    turn_block,
    turn_foot,
    turn_of,
    upright_place,
)

DEEP = real(1.0e-6)
"""Depth to which an open end may lie too low and still land, over the half height."""
LEAST = real(1.0 / 32.0)
"""Least part of itself to which a step is cut at once if a contact stops in it. If the step is far
too long, its acceleration says little about the time of the stop."""


@wp.struct
class Opening:
    """Opening of a pivoting interface, positive if open: angle [rad] and rate [rad/s]."""

    angle: real
    rate: real


@wp.func
def start_pose(blocks: wp.ref[Blocks], pose: wp.ref[Pose]) -> Pose:
    """A pose from its rotations and from `along` of blocks turned flat about their corners."""
    p = pose
    for k in range(BLOCKS):
        turn_block(blocks, p, k, p.theta[k])
        touch = nearest_ends(turn_of(p, k))
        p.touch[k] = touch
        side = side_of(touch)
        low, _height = lower_face(blocks, k)
        anchor = Anchor(p.along[k] + side * blocks.half_width[k], real(1.0))
        if side * anchor.place > ALIKE * low:
            anchor = Anchor(side * low - p.along[k], real(-1.0))
        if touch == CLOSED:
            anchor = Anchor(p.along[k], real(1.0))
        place_block(blocks, p, k, touch, anchor)
    return p


@wp.func
def fly(
    blocks: wp.ref[Blocks], old: wp.ref[Pose], new: wp.ref[Pose], velocity: Triples, k: int, d: real
):  # fmt: skip
    """Along and above of an open interface after a time d at constant velocities."""
    s0, c0 = face_below(old, k)
    s1, c1 = face_below(new, k)
    su0, cu0 = face_above(old, k)
    su1, cu1 = face_above(new, k)
    su = su1 - su0
    cu = cu1 - cu0
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
        x = x - height * su + upper * cu - low_height * (s1 - s0) - lower * (c1 - c0)
        z = z - height * cu - upper * su - low_height * (c1 - c0) + lower * (s1 - s0)
    else:
        x = x - height * su - low_height * (s1 - s0)
        z = z - height * cu - low_height * (c1 - c0)
    return x * c1 - z * s1, z * c1 + x * s1


@wp.func(inline=False)
def move(
    blocks: wp.ref[Blocks], old: wp.ref[Pose], touch: Counts, velocity: wp.ref[Triples],
    slide: wp.ref[Values], d: real, new: wp.ref[Pose],
):  # fmt: skip
    """Sets the pose after a time at constant velocities; anchors of contacts move as they slide.

    Args:
        blocks: The blocks.
        old: The pose before.
        touch: Ends that touch meanwhile.
        velocity: Velocities.
        slide: Sliding velocities of the contacts [m/s].
        d: The time [s].
        new: The pose after it.
    """
    new.touch = touch
    for k in range(BLOCKS):
        theta = old.theta[k] + d * velocity[3 * k + 2]
        if touch[k] == CLOSED:
            theta = flat_rotation(blocks, new, k)
        turn_block(blocks, new, k, theta)
        if touch[k] == OPEN:
            along, above = fly(blocks, old, new, velocity, k, d)
            new.along[k] = along
            new.above[k] = above
        else:
            anchor = find_anchor(blocks, old, k, touch[k])
            anchor.place = anchor.place + anchor.rate * d * slide[k]
            place_block(blocks, new, k, touch[k], anchor)


@wp.func
def opening(pose: wp.ref[Pose], velocity: Triples, k: int, touch: int) -> Opening:
    """The opening of an interface that pivots on an end."""
    turn = turn_of(pose, k)
    rate = velocity[3 * k + 2]
    if k > 0:
        rate = rate - velocity[3 * k - 1]
    side = side_of(touch)
    return Opening(side * turn, side * rate)


@wp.func
def find_closing(start: Opening, end: Opening, d: real, near: real):
    """Where an opening comes to zero in a step.

    Args:
        start, end: The opening at both ends of the step.
        d: Length of the step [s].
        near: Time by which an event may be missed [s].

    Returns:
        Length of the step to there if that lies inside, else NEVER; whether it is at its end.
    """
    zero = real(0.0)
    reach = near * size(end.rate) + GRAIN
    cut = NEVER
    closes = end.angle <= reach and (end.rate < zero or end.angle <= zero)
    if end.angle < -reach and d > near:
        cut = first_root(larger(start.angle, zero), start.rate, end.angle, d)
        closes = False
    return cut, closes


@wp.func
def settles(start: Opening, bend: real, rest: real) -> bool:
    """Whether an interface would open by no more than `rest` [rad] before it falls flat again.

    `bend` is half of the acceleration with which it opens [rad/s^2].
    """
    swings = start.rate * start.rate <= real(-4.0) * bend * (rest - start.angle)
    return swings or (start.angle <= GRAIN and start.rate <= real(0.0))


@wp.func(inline=False)
def find_landing(
    blocks: wp.ref[Blocks], limits: wp.ref[Limits], s: wp.ref[State], t: wp.ref[Trial], k: int
):  # fmt: skip
    """Where the ends of an open interface land in a trial step.

    Returns:
        Length of the step to its landing if that lies inside, else NEVER; the ends that land at the
        end of the step, else OPEN; the smaller gap there [m].
    """
    zero = real(0.0)
    near = NEARLY * limits.longest_step
    up0, low0, plus0, minus0 = interface_rows(blocks, s.pose, k)
    up1, low1, plus1, minus1 = interface_rows(blocks, t.pose, k)
    u0 = up0 * three_of(s.velocity, k)
    u1 = up1 * three_of(t.velocity, k)
    if k > 0:
        u0 = u0 + low0 * three_of(s.velocity, k - 1)
        u1 = u1 + low1 * three_of(t.velocity, k - 1)
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
            if g1 < smaller(g0, zero) - reach and t.d > near:
                cut = smaller(cut, first_root(larger(g0, zero), r0, g1, t.d))
            elif g1 <= reach and r1 < zero:
                lands = lands + wp.where(end == 0, PLUS, MINUS)
    return cut, lands, smaller(plus1, minus1)


@wp.func
def find_stop(s: wp.ref[State], t: wp.ref[Trial], k: int, along: real, near: real):
    """Where a sliding contact stops in a step.

    Args:
        s: State before the step.
        t: The step.
        k: The interface.
        along: Sliding velocity at the end of the step [m/s].
        near: Time by which an event may be missed [s].

    Returns:
        Length of the step to there if that lies inside, else NEVER; direction of sliding after it.
    """
    zero = real(0.0)
    slip = t.slip[k]
    d = t.d
    e0 = wp.where(slip == s.slip[k], real(slip) * s.rate[3 * k], zero)
    e1 = real(slip) * along
    cut = NEVER
    after = slip
    if slip != 0 and d > zero:
        reach = near * size(e1 - e0) / d
        if e0 > zero and e1 < -reach and d > near:
            cut = larger(first_root(e0, (e1 - e0) / d, e1, d), LEAST * d)
        elif e1 <= wp.where(e0 > zero, reach, zero):
            after = 0
    return cut, after


@wp.func
def find_departure(
    blocks: wp.ref[Blocks], s: wp.ref[State], t: wp.ref[Trial], k: int, near: real
) -> real:  # fmt: skip
    """Length of a step to where a block has slid off the one below, NEVER if not inside it.

    `near` is the time by which that may be missed [s].
    """
    low, _height = lower_face(blocks, k)
    room = low + blocks.half_width[k]
    last = size(slide_place(blocks, t.pose, k))
    cut = NEVER
    if last > room and t.d > near:
        first = size(slide_place(blocks, s.pose, k))
        if first < room and (last - room) * t.d > near * (last - first):
            cut = t.d * (room - first) / (last - first)
    return cut


@wp.func(inline=False)
def lay_down(blocks: wp.ref[Blocks], old: wp.ref[Pose], falls: Counts, new: wp.ref[Pose]):
    """Sets the pose with fallen blocks flat on what is below, and landed ends on their faces."""
    turned = bool(False)
    for k in range(BLOCKS):
        was = old.touch[k]
        touch = wp.where(falls[k] == OPEN, was, falls[k])
        if was == OPEN:
            was = wp.where(touch == CLOSED, ends_below(old, k), touch)
        theta = old.theta[k]
        if touch == CLOSED:
            theta = flat_rotation(blocks, new, k)
        moved = turned
        turned = theta != old.theta[k]
        if turned:
            turn_block(blocks, new, k, theta)
        else:
            new.theta[k] = theta
            new.sine[k] = old.sine[k]
            new.cosine[k] = old.cosine[k]
            turn_foot(blocks, new, k)
        new.touch[k] = touch
        new.along[k] = old.along[k]
        new.above[k] = old.above[k]
        if touch != OPEN and (turned or moved or falls[k] != OPEN):
            anchor = find_anchor(blocks, old, k, was)
            if touch == CLOSED:
                anchor.place = upright_place(blocks, k, was, anchor)
            place_block(blocks, new, k, touch, anchor)


@wp.func(inline=False)
def glue(blocks: wp.ref[Blocks], pose: wp.ref[Pose], slip: Counts, velocity: Triples) -> Triples:
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
