"""What held blocks, strips and blocks on compliant ground share: steps of one lean, cut at events.

A step is one expansion of degree 10 (motion/series.py). It is cut at its turning point; on what is
left the lean grows or falls all along, so that the first event in its way ends it.
"""

import warp as wp

from warprock.kernels.housner.block import GRAIN, NEARLY
from warprock.kernels.housner.block_found import FrictionSeen
from warprock.kernels.lane.modes import BROKEN, RESTING, ROCKING
from warprock.kernels.motion.series import (
    DEGREE,
    Series,
    first_root,
    root_of,
    slope_of,
    value_of,
)

REACH = real(0.25)
"""Largest rotation of the block in one step [rad]."""
LOOKS = 8
"""Parts of a step at whose ends the contact force is looked at."""
LOOK = real(1.0 / LOOKS)

Looks = wp.types.vector(length=LOOKS, dtype=real)
"""The friction needed at the end of each part of a step."""


@wp.struct
class State:
    """State of a lane, as that of housner/block.py; of a strip that of its lower body."""

    theta: real
    omega: real
    side: real
    time: real
    segment: int
    mode: int


@wp.func
def start_lane(theta: real, omega: real, wall: real):
    """Releases a block at a rotation [rad] with a rate [rad/s]: its state, what is seen of it.

    `wall` is the side at which a wall stands, -1 or 1; 0 without one.
    """
    zero = real(0.0)
    rests = theta == zero and omega == zero
    side = sign_of(wp.where(theta == zero, omega, theta))
    if wall != zero:
        side = -wall
    mode = wp.where(rests, RESTING, ROCKING)
    lifted, rested = wp.where(rests, NEVER, zero), wp.where(rests, zero, NEVER)
    state = State(theta, omega, side, zero, 0, mode)
    return state, FrictionSeen(size(theta), zero, lifted, rested, zero, zero, 0, 0)


@wp.func
def lift(side: real, s: wp.ref[State], seen: wp.ref[FrictionSeen]):
    """Has a block at rest lift over a side."""
    s.side = side
    s.mode = ROCKING
    seen.uplift_time = smaller(seen.uplift_time, s.time)
    seen.rest_time = NEVER


@wp.func
def go_on(after: real, rests: bool, tail: real, s: wp.ref[State], seen: wp.ref[FrictionSeen]):
    """Ends an impact: the block goes on at a rate, or rests.

    Args:
        after: The rate after the impact [rad/s].
        rests: Whether it rests.
        tail: Time that the impacts which are left out would take [s].
        s: Its state before the impact; updated.
        seen: What is seen of it; updated.
    """
    before = s.omega
    s.theta = real(0.0)
    s.omega = after
    if rests:
        s.omega = real(0.0)
        s.mode = RESTING
        seen.rest_time = s.time + tail
    seen.loss = seen.loss + before * before - s.omega * s.omega
    seen.impacts = seen.impacts + 1


@wp.func
def goes_out(side: real, x: Series, h: real) -> bool:
    """Whether a block turns outwards from now on."""
    zero = real(0.0)
    rate = side * x[1]
    if rate == zero:
        rate = side * x[2]
        if size(x[2]) < NEARLY * size(x[3]) * h:
            rate = side * x[3]
    return rate >= zero


@wp.func
def turning_time(x: Series, towards: real, h: real) -> real:
    """When a block that turns `towards` a side turns back within a step; NEVER if it does not."""
    slope = towards * slope_of(x)
    if slope[0] == real(0.0):
        # A block that stands still has a zero there; one that has just lifted a double one.
        over = 1
        if size(slope[1]) < real(2.0) * NEARLY * size(slope[2]) * h:
            over = 2
        divided = Series()
        for k in range(DEGREE - 2):
            divided[k] = slope[k + over]
        slope = divided
    found = NEVER
    if slope[0] > real(0.0):
        found = first_root(slope, h)
    return found


@wp.func
def judged_time(x: Series, towards: real, left: real, tau: real) -> real:
    """How much of a step of length tau the contact is judged in, up to where the block falls.

    `left` is the rotation that it has left to there if it turns outwards, `towards` a side.
    """
    found = real(tau)
    if left <= real(0.0):
        found = real(0.0)
    else:
        ahead = -towards * x
        ahead[0] = left
        if value_of(ahead, tau) < real(0.0):
            found = root_of(ahead, tau)
    return found


@wp.func
def crest_of(first: real, looks: Looks):
    """The largest friction needed in a step, of some looks, and where its crest is.

    Args:
        first: The friction needed at the start of the step.
        looks: Likewise at the end of each part of it.

    Returns:
        The largest look; the place of the crest of the parabola through it and its neighbours, in
        parts of the step, or 0 where it has none.
    """
    found = real(first)
    crest = real(0.0)
    largest = int(0)
    for k in range(LOOKS):
        if looks[k] > found:
            found = looks[k]
            largest = k + 1
    if largest > 0 and largest < LOOKS and found < NEVER:
        before = real(first)
        if largest > 1:
            before = looks[largest - 2]
        after = looks[largest]
        bend = real(2.0) * found - before - after
        if bend > real(0.0):
            crest = real(largest) + HALF * (after - before) / bend
    return found, crest


@wp.func
def quiet_step(a: Series, time: real, longest: real) -> real:
    """How long a block at rest waits: to where the acceleration of the base turns, at most [s]."""
    h = real(longest)
    slope = slope_of(a)
    at_end = value_of(slope, h)
    # A turning point in the first NEARLY of the step is one that the last step has ended at.
    if slope[0] * at_end < -NEARLY * (slope[0] * slope[0] + at_end * at_end):
        turn = root_of(sign_of(slope[0]) * slope, h)
        # One that is nearer than times resolve is at hand: a step to it would not end.
        if turn > GRAIN * time:
            h = turn
    return h


@wp.func
def end_step(s: wp.ref[State], seen: wp.ref[FrictionSeen]):
    """Looks at a lane at the end of a step."""
    if not wp.isfinite(s.theta + s.omega + s.time):
        s.mode = BROKEN
    if size(s.theta) > seen.peak:
        seen.peak = size(s.theta)
        seen.peak_time = s.time
    seen.steps = seen.steps + 1
