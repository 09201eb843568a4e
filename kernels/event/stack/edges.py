"""Stacks in the plane with bodies among their blocks: how a body rolls from edge to edge.

The scheme is that of step.py. A block stands on a chain of corners, convex towards what is below
(see shape/body.py). An interface is that of one edge of the chain and the top below: the edge on
which the block lies, or on which it would fall if it turned back. The block takes the next edge, to
+x (`way` 1) or to -x (-1), at the end of a step:

- A block that turns on a corner comes to lie on the edge behind it. That is an impact at the ends
  of that edge, as is the fall on its own edge. A step that would pass it ends there.
- A block that flies turns so far that the corner behind the edge becomes the lowest one. A step
  ends there, too.
- A sliding block leaves the top with the whole edge, or comes back on it with an end of the edge
  while it is turned beyond the next edge.

If an end of its edge lies beyond the top below, a block touches the end of the top. The next edge
is further outside, and cannot land.
"""

import warp as wp

from warprock.kernels.event.stack.moves import Opening, find_closing, opening
from warprock.kernels.event.stack.state import GRAIN, NEARLY, Limits, State, Trial
from warprock.kernels.shape.stack import (
    CLOSED,
    MINUS,
    OPEN,
    PLUS,
    Blocks,
    Pose,
    Triples,
    lower_face,
    side_of,
    turn_across,
    turn_foot,
    turn_of,
)
from warprock.kernels.shape.stack_body import Foot

WITHIN = real(1.0 - 1.0e-9)
"""Part of a face within which a corner must lie for the edge behind it to land on the face."""


@wp.func
def stand_on(
    blocks: wp.ref[Blocks], k: int, row: int, before: Foot, here: Foot, after: Foot, behind: Foot
):  # fmt: skip
    """Puts block k on the edge from corner `here`, at a row of the corners, to `after`.

    `before` and `behind` are the rows beside them, see shape/stack_body.py.
    """
    half = HALF * (after.along - here.along)
    blocks.edge[k] = row
    blocks.half_width[k] = half
    blocks.half_height[k] = here.depth
    blocks.foot[k] = here.angle
    blocks.foot_sine[k] = here.sine
    blocks.foot_cosine[k] = here.cosine
    blocks.foot_middle[k] = here.x * here.cosine + here.z * here.sine + half
    blocks.rolled[k] = here.along + half
    blocks.ahead[k] = wp.where(behind.along > after.along, after.angle - here.angle, NEVER)
    blocks.behind[k] = wp.where(before.along < here.along, here.angle - before.angle, NEVER)


@wp.func
def room_of(blocks: wp.ref[Blocks], k: int, side: real) -> real:
    """Turn of block k from its edge to the next one on a side [rad]; NEVER if there is none."""
    return wp.where(side > real(0.0), blocks.ahead[k], blocks.behind[k])


@wp.func
def has_next(blocks: wp.ref[Blocks], pose: wp.ref[Pose], k: int, side: real) -> bool:
    """Whether there is a next edge on a side that could lie on the top below.

    One that has turned beyond the upright is a side of the block.
    """
    return room_of(blocks, k, side) - side * turn_of(pose, k) < HALF_PI


@wp.func
def end_of_edge(blocks: wp.ref[Blocks], pose: wp.ref[Pose], k: int, side: real) -> real:
    """Place of an end of the edge of interface k along the top below, positive to that side [m]."""
    _sd, cd = turn_across(pose, k)
    return side * pose.along[k] + blocks.half_width[k] * cd


@wp.func
def turn_left(
    blocks: wp.ref[Blocks], pose: wp.ref[Pose], velocity: Triples, k: int, touch: int
) -> Opening:
    """Turn that block k, on its end `touch`, still has to its next edge."""
    turned = opening(pose, velocity, k, touch)
    return Opening(room_of(blocks, k, side_of(touch)) - turned.angle, -turned.rate)


@wp.func
def leave_top(
    blocks: wp.ref[Blocks], s: wp.ref[State], t: wp.ref[Trial], k: int, side: real, near: real
):  # fmt: skip
    """Whether the whole edge of interface k leaves the top over the end away from a side.

    Returns:
        Length of the step to there if that is inside, else NEVER; whether it has left at its end.
    """
    zero = real(0.0)
    d = t.d
    low, _height = lower_face(blocks, k)
    before = end_of_edge(blocks, s.pose, k, side) + low
    after = end_of_edge(blocks, t.pose, k, side) + low
    part = wp.where(d > near, near / d, zero)
    reach = part * size(after - before) + GRAIN * blocks.half_width[k]
    cut = NEVER
    if before > reach and after < -reach and d > near:
        cut = d * before / (before - after)
    return cut, after <= wp.where(after < before, reach, zero)


@wp.func
def find_way_in_flight(
    blocks: wp.ref[Blocks], s: wp.ref[State], t: wp.ref[Trial], k: int, near: real
):  # fmt: skip
    """The next edge of an open interface; see `find_next_edge`, but for what lands."""
    cut = NEVER
    way = int(0)
    leaves = bool(False)
    low, _height = lower_face(blocks, k)
    for number in range(2):
        side = wp.where(number == 0, real(1.0), real(-1.0))
        code = wp.where(number == 0, PLUS, MINUS)
        there_at, there = leave_top(blocks, s, t, k, side, near)
        cut = smaller(cut, there_at)
        if has_next(blocks, t.pose, k, side):
            if there:
                way = wp.where(number == 0, 1, -1)
                leaves = True
            elif size(end_of_edge(blocks, t.pose, k, side)) < WITHIN * low:
                start = turn_left(blocks, s.pose, s.velocity, k, code)
                end = turn_left(blocks, t.pose, t.velocity, k, code)
                there_at, there = find_closing(start, end, t.d, near)
                if start.angle <= real(0.0):
                    # It was beyond the edge before.
                    there = there or there_at < NEVER
                    there_at = NEVER
                cut = smaller(cut, there_at)
                if there and not leaves:
                    way = wp.where(number == 0, 1, -1)
    return cut, way, leaves


@wp.func
def find_way_by_sliding(
    blocks: wp.ref[Blocks], s: wp.ref[State], t: wp.ref[Trial], k: int, near: real
):  # fmt: skip
    """The next edge of an interface that touches, if sliding alone leads there.

    The whole edge leaves the top, or its end comes back on it, turned beyond the next edge. Returns
    as of `find_next_edge`, the first two.
    """
    cut = NEVER
    way = int(0)
    low, _height = lower_face(blocks, k)
    touch = t.pose.touch[k]
    for number in range(2):
        side = wp.where(number == 0, real(1.0), real(-1.0))
        there_at, there = leave_top(blocks, s, t, k, side, near)
        cut = smaller(cut, there_at)
        if touch != CLOSED and side == side_of(touch):
            beyond = side * turn_of(t.pose, k) > room_of(blocks, k, side) + GRAIN
            there = there or (beyond and end_of_edge(blocks, t.pose, k, side) < WITHIN * low)
        if there and has_next(blocks, t.pose, k, side):
            way = wp.where(number == 0, 1, -1)
    return cut, way


@wp.func
def find_next_edge(
    blocks: wp.ref[Blocks], limits: wp.ref[Limits], s: wp.ref[State], t: wp.ref[Trial], k: int
):  # fmt: skip
    """The edge that interface k takes in a trial step.

    Args:
        blocks: The blocks.
        limits: The lane's limits.
        s: State before the step.
        t: The step.
        k: The interface.

    Returns:
        Length of the step to there if that lies inside, else NEVER; by how many edges the interface
        moves on at its end; whether it lands on the next edge; whether its own has left the top.
    """
    near = NEARLY * limits.longest_step
    cut = NEVER
    way = int(0)
    lands = bool(False)
    leaves = bool(False)
    touch = t.pose.touch[k]
    if touch == OPEN:
        cut, way, leaves = find_way_in_flight(blocks, s, t, k, near)
    else:
        side = side_of(touch)
        low, _height = lower_face(blocks, k)
        corner = end_of_edge(blocks, s.pose, k, side)
        if touch != CLOSED and room_of(blocks, k, side) < NEVER and size(corner) < WITHIN * low:
            start = turn_left(blocks, s.pose, s.velocity, k, touch)
            end = turn_left(blocks, t.pose, t.velocity, k, touch)
            cut, lands = find_closing(start, end, t.d, near)
        if lands:
            way = wp.where(touch == PLUS, 1, -1)
        elif cut >= NEVER:
            cut, way = find_way_by_sliding(blocks, s, t, k, near)
            leaves = way != 0
    return cut, way, lands, leaves


@wp.func
def pose_on_edges(old: wp.ref[Blocks], blocks: wp.ref[Blocks], t: wp.ref[Trial]) -> Pose:
    """The pose at the end of a step, as told by the edges that its blocks roll on to.

    Args:
        old: The blocks on the edges of the pose.
        blocks: The blocks on the edges that they roll on to.
        t: The step.
    """
    pose = t.pose
    new = pose
    for k in range(BLOCKS):
        if t.way[k] != 0:
            side = real(t.way[k])
            sd, cd = turn_across(pose, k)
            turn_foot(blocks, new, k)
            sd1, cd1 = turn_across(new, k)
            # Both edges have the corner between them.
            new.along[k] = pose.along[k] + side * (
                old.half_width[k] * cd + blocks.half_width[k] * cd1
            )
            new.above[k] = pose.above[k] - side * (
                old.half_width[k] * sd + blocks.half_width[k] * sd1
            )
            # Where a corner passes over an end of the top, the next edge turns away from it.
            lands = wp.where(t.way[k] > 0, MINUS, PLUS)
            new.touch[k] = wp.where(t.falls[k] == OPEN, OPEN, lands)
    return new


@wp.func
def overshoot(blocks: wp.ref[Blocks], pose: wp.ref[Pose], k: int) -> real:
    """How deep the edge on which block k has fallen is in the top below [m]."""
    low, _height = lower_face(blocks, k)
    over = -side_of(pose.touch[k]) * turn_of(pose, k)
    return TWO * smaller(low, blocks.half_width[k]) * sine(over)


@wp.func
def roll_on(old: wp.ref[Blocks], blocks: wp.ref[Blocks], t: wp.ref[Trial]):
    """Tells the end of a trial step by the edges that its blocks roll on to."""
    t.pose = pose_on_edges(old, blocks, t)
    for k in range(BLOCKS):
        if t.way[k] != 0 and t.falls[k] != OPEN:
            t.deep = larger(overshoot(blocks, t.pose, k), t.deep)


@wp.func
def has_left(blocks: wp.ref[Blocks], pose: wp.ref[Pose], k: int) -> bool:
    """Whether block k has left the top below: all that could touch the top lies beyond an end."""
    low, _height = lower_face(blocks, k)
    left = size(turn_of(pose, k)) >= HALF_PI
    for number in range(2):
        side = wp.where(number == 0, real(1.0), real(-1.0))
        beyond = end_of_edge(blocks, pose, k, side) <= -low
        left = left or (beyond and not has_next(blocks, pose, k, side))
    return left
