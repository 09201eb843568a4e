"""Stacks in the plane with bodies among their blocks: what goes from edge to edge.

The scheme is that of event/stack.py. A block stands on a chain of corners, convex towards what is
below (see shape/body.py), and an interface is that of one edge of it and the top below: the edge on
which the block lies, or on which it would fall if it turned back. Here is where it takes the next
edge, to +x (`way` 1) or to -x (-1), at the end of a step:

- A block that turns on a corner comes to lie on the edge behind it: that is an impact at the ends
  of that edge, as the fall on its own edge is. A step that would pass it ends there.
- A block that flies turns so far that the corner behind the edge becomes the lowest one. A step
  ends there, too.
- A sliding block leaves the top with the whole edge, or comes back on it with its end while it is
  turned beyond the next edge.

Under an end of its edge that lies beyond the top below, a block touches the end of the top. The
next edge is further outside, and cannot land.
"""

import warp as wp

from warprock.kernels.event.block_begin import first_root
from warprock.kernels.event.stack_moves import GRAIN, opening, pivot_event
from warprock.kernels.shape.stack import (
    CLOSED,
    MINUS,
    OPEN,
    PLUS,
    Blocks,
    Counts,
    Pose,
    Triples,
    between,
    lower_face,
    side_of,
    turn_of,
    with_foot,
)
from warprock.kernels.shape.stack_body import Foot

WITHIN = real(1.0 - 1.0e-9)
"""Part of a face within which a corner must lie for the edge behind it to land on the face."""


@wp.func
def on_edge(blocks: Blocks, k: int, before: Foot, here: Foot, after: Foot, behind: Foot) -> Blocks:
    """The blocks with block k on the edge from corner `here` to the next one, `after`.

    Args:
        blocks: The blocks.
        k: Which one.
        before: Row before `here`, see shape/stack_body.py.
        here: Row at which the edge begins.
        after: Row at which it ends.
        behind: Row after that.
    """
    b = blocks
    half = HALF * (after.along - here.along)
    b.half_width[k] = half
    b.half_height[k] = here.depth
    b.foot[k] = here.angle
    b.foot_sine[k] = here.sine
    b.foot_cosine[k] = here.cosine
    b.foot_middle[k] = here.x * here.cosine + here.z * here.sine + half
    b.rolled[k] = here.along + half
    b.ahead[k] = wp.where(behind.along > after.along, after.angle - here.angle, NEVER)
    b.behind[k] = wp.where(before.along < here.along, here.angle - before.angle, NEVER)
    return b


@wp.func
def room_of(blocks: Blocks, k: int, side: real) -> real:
    """How far block k turns from its edge to the next one on a side [rad], or NEVER."""
    return wp.where(side > real(0.0), blocks.ahead[k], blocks.behind[k])


@wp.func
def has_next(blocks: Blocks, pose: Pose, k: int, side: real) -> bool:
    """Whether there is a next edge on a side that could lie on the top below.

    One that has turned beyond the upright is a side of the block.
    """
    return room_of(blocks, k, side) - side * turn_of(pose, k) < HALF_PI


@wp.func
def end_of_edge(blocks: Blocks, pose: Pose, k: int, side: real) -> real:
    """Where an end of the edge of interface k is along the top below, to that side [m]."""
    _s, _c, _sd, cd = between(pose, k)
    return side * pose.along[k] + blocks.half_width[k] * cd


@wp.func
def passes(a0: real, r0: real, a1: real, r1: real, d: real, near: real):
    """What becomes of a flying block's way to its next edge, from that and its rate at both ends.

    Returns:
        Length of the step to where it lies level if that is inside, else NEVER; whether it has
        come there.
    """
    zero = real(0.0)
    reach = near * size(r1) + GRAIN
    cut = NEVER
    there = a1 <= reach and (r1 < zero or a1 <= zero)
    if a0 > zero and a1 < -reach and d > near:
        cut = first_root(a0, r0, a1, d)
        there = False
    return cut, there


@wp.func
def leaves_top(blocks: Blocks, old: Pose, new: Pose, k: int, side: real, d: real, near: real):
    """Whether the whole edge of interface k has left the top beyond the end away from a side.

    Returns:
        Length of the step to there if that is inside, else NEVER; whether it has left at its end.
    """
    zero = real(0.0)
    low, _height = lower_face(blocks, k)
    before = end_of_edge(blocks, old, k, side) + low
    after = end_of_edge(blocks, new, k, side) + low
    part = wp.where(d > near, near / d, zero)
    reach = part * size(after - before) + GRAIN * blocks.half_width[k]
    cut = NEVER
    if before > reach and after < -reach and d > near:
        cut = d * before / (before - after)
    return cut, after <= wp.where(after < before, reach, zero)


@wp.func
def flying_way(
    blocks: Blocks, old: Pose, new: Pose, v0: Triples, v1: Triples, k: int, d: real, near: real
):
    """The next edge of an open interface; see `next_edge`, but for what lands."""
    cut = NEVER
    way = int(0)
    leaves = bool(False)
    low, _height = lower_face(blocks, k)
    for number in range(2):
        side = wp.where(number == 0, real(1.0), real(-1.0))
        code = wp.where(number == 0, PLUS, MINUS)
        room = room_of(blocks, k, side)
        there_at, there = leaves_top(blocks, old, new, k, side, d, near)
        cut = smaller(cut, there_at)
        if has_next(blocks, new, k, side):
            if there:
                way = wp.where(number == 0, 1, -1)
                leaves = True
            elif size(end_of_edge(blocks, new, k, side)) < WITHIN * low:
                e0, r0 = opening(old, v0, k, code)
                e1, r1 = opening(new, v1, k, code)
                there_at, there = passes(room - e0, -r0, room - e1, -r1, d, near)
                cut = smaller(cut, there_at)
                if there and not leaves:
                    way = wp.where(number == 0, 1, -1)
    return cut, way, leaves


@wp.func
def sliding_way(blocks: Blocks, old: Pose, new: Pose, k: int, d: real, near: real):
    """The next edge of an interface that touches, where sliding alone leads there; see `next_edge`.

    Its whole edge leaves the top, or its corner comes back on it, turned beyond the next edge.
    """
    cut = NEVER
    way = int(0)
    low, _height = lower_face(blocks, k)
    touch = new.touch[k]
    for number in range(2):
        side = wp.where(number == 0, real(1.0), real(-1.0))
        there_at, there = leaves_top(blocks, old, new, k, side, d, near)
        cut = smaller(cut, there_at)
        if touch != CLOSED and side == side_of(touch):
            beyond = side * turn_of(new, k) > room_of(blocks, k, side) + GRAIN
            there = there or (beyond and end_of_edge(blocks, new, k, side) < WITHIN * low)
        if there and has_next(blocks, new, k, side):
            way = wp.where(number == 0, 1, -1)
    return cut, way


@wp.func
def next_edge(
    blocks: Blocks, old: Pose, new: Pose, v0: Triples, v1: Triples, k: int, d: real, near: real
):
    """Whether interface k takes another edge in a step, from its start and its end.

    Args:
        blocks: The blocks.
        old, new: Poses.
        v0, v1: Velocities.
        k: The interface.
        d: Length of the step [s].
        near: Time by which an event may be missed [s].

    Returns:
        Length of the step to there if that lies inside, else NEVER; by how many edges the interface
        moves on at its end; whether it lands on the next edge; whether its own has left the top.
    """
    cut = NEVER
    way = int(0)
    lands = bool(False)
    leaves = bool(False)
    touch = new.touch[k]
    if touch == OPEN:
        cut, way, leaves = flying_way(blocks, old, new, v0, v1, k, d, near)
    else:
        side = side_of(touch)
        low, _height = lower_face(blocks, k)
        room = room_of(blocks, k, side)
        corner = end_of_edge(blocks, old, k, side)
        if touch != CLOSED and room < NEVER and size(corner) < WITHIN * low:
            e0, r0 = opening(old, v0, k, touch)
            e1, r1 = opening(new, v1, k, touch)
            cut, lands, _rests = pivot_event(
                room - e0, -r0, room - e1, -r1, real(0.0), d, near, False, real(0.0)
            )
        if lands:
            way = wp.where(touch == PLUS, 1, -1)
        elif cut >= NEVER:
            cut, way = sliding_way(blocks, old, new, k, d, near)
            leaves = way != 0
    return cut, way, lands, leaves


@wp.func
def rolled_on(old: Blocks, blocks: Blocks, pose: Pose, way: Counts, falls: Counts) -> Pose:
    """A pose, told by the edges that its blocks have come to.

    Args:
        old: The blocks on the edges of the pose.
        blocks: The same on the edges that they have come to.
        pose: The pose.
        way: By how many edges each has moved on.
        falls: Ends that land.
    """
    new = pose
    for k in range(BLOCKS):
        if way[k] != 0:
            side = real(way[k])
            _s, _c, sd, cd = between(pose, k)
            new = with_foot(blocks, new, k)
            _s1, _c1, sd1, cd1 = between(new, k)
            # Both edges have the corner between them.
            new.along[k] = pose.along[k] + side * (
                old.half_width[k] * cd + blocks.half_width[k] * cd1
            )
            new.above[k] = pose.above[k] - side * (
                old.half_width[k] * sd + blocks.half_width[k] * sd1
            )
            # Where a corner passes over an end of the top, the next edge turns away from it.
            lands = wp.where(way[k] > 0, MINUS, PLUS)
            new.touch[k] = wp.where(falls[k] == OPEN, OPEN, lands)
    return new


@wp.func
def overshoot(blocks: Blocks, pose: Pose, k: int) -> real:
    """How deep the edge on which block k has fallen is in the top below [m]."""
    low, _height = lower_face(blocks, k)
    over = -side_of(pose.touch[k]) * turn_of(pose, k)
    return TWO * smaller(low, blocks.half_width[k]) * sine(over)


@wp.func
def has_left(blocks: Blocks, pose: Pose, k: int) -> bool:
    """Whether block k has left the top below: all that could touch that lies beyond an end."""
    low, _height = lower_face(blocks, k)
    left = size(turn_of(pose, k)) >= HALF_PI
    for number in range(2):
        side = wp.where(number == 0, real(1.0), real(-1.0))
        beyond = end_of_edge(blocks, pose, k, side) <= -low
        left = left or (beyond and not has_next(blocks, pose, k, side))
    return left
