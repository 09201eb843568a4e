"""Steps of Housner's block under a record in which nothing happens.

A record is linear between its samples, and most steps end at one of them without an event. Such a
step is that of housner/block.py, to the last bit, but for the search of an event and of the
friction that it needs. A step that may hold an event, or need more friction than any before it, is
declined, and has changed nothing; housner/block.py takes it. That costs four times as much.

A block at rest passes all samples of which none could lift it, which is no step.
"""

import warp as wp

from warprock.kernels.housner.block import REACH, Block, State, tops_below
from warprock.kernels.housner.block_contact import Force, rocking_series
from warprock.kernels.lane.modes import RESTING, ROCKING
from warprock.kernels.motion.kinds import (
    Acceleration,
    Ground,
    Motion,
    acceleration_at,
    between_samples,
    expand,
    knot_time,
    weak_samples_ahead,
)
from warprock.kernels.motion.pool import AHEAD
from warprock.kernels.shape.taylor import scale, slope_at, value_at

NEARLY_ALL = by_precision(1.0 - 1.0e-9, 1.0 - 1.0e-5)
"""Part of a bound up to which a step is taken here: what round-off could decide is declined."""


@wp.func
def friction_suffices(friction: real, h: real, force: Force) -> bool:
    """Whether a friction surely holds in a step of length h: n and f are chords and what bends."""
    n0, n1, n2, n3 = force.n0, force.n1, force.n2, force.n3
    f0, f1, f2, f3 = force.f0, force.f1, force.f2, force.f3
    n = fused_less(h * h, fused(size(n3), h, size(n2)), smaller(n0, fused(n1, h, n0)))
    f = fused(h * h, fused(size(f3), h, size(f2)), larger(size(f0), size(fused(f1, h, f0))))
    return f < NEARLY_ALL * friction * n


@wp.func
def rock_on(block: Block, h: real, s: State, peak: real, a: Acceleration):
    """A step of a rocking block: theta and omega after it, whether nothing happens in it."""
    zero = real(0.0)
    rotation, force = rocking_series(
        block.frequency_squared, block.coupling, s.side * block.slenderness_angle, s.theta,
        s.omega, a,
    )  # fmt: skip
    theta = value_at(rotation, h)
    omega = slope_at(rotation, h)
    lean = scale(s.side, rotation)
    lean_at_end = s.side * theta
    stands = lean.c0 >= zero and lean_at_end > zero and lean_at_end < NEARLY_ALL * HALF_PI
    one_way = s.omega * omega >= zero or tops_below(NEARLY_ALL * peak, lean, h)
    one_way = one_way and size(s.omega) * h < NEARLY_ALL * REACH
    fallen = lean.c0 >= block.fall_angle and lean.c1 >= zero
    held = fallen or friction_suffices(s.needed, h, force)
    return theta, omega, stands and one_way and held


@wp.func
def rest_on(block: Block, m: Motion, ground: Ground, until: real, s: State):
    """Takes a block at rest past samples that surely do not lift it, at most to `until`.

    Returns:
        Whether it gets on; the time and the segment that it comes to; the friction that it has
        needed by then.
    """
    bound = NEARLY_ALL * block.uplift_acceleration
    calm, far = weak_samples_ahead(m, s.segment, ground.strongest, bound)
    # The sample that the segment starts at is one of the strongest.
    starts = s.time <= knot_time(m, s.segment - 1)
    leaps = calm and far <= until and starts
    knot = knot_time(m, s.segment)
    target = smaller(knot, until)
    value_at_end = ground.value + ground.slope * m.interval
    largest = size(m.scale) * larger(size(ground.value), size(value_at_end))
    weak = largest < bound and between_samples(m, s.segment)
    gets_on = s.mode == RESTING and (leaps or (weak and target - s.time <= s.cap))
    passed = wp.where(leaps, AHEAD, wp.where(target >= knot, 1, 0))
    a = expand(m, s.segment, s.time, ground.value, ground.slope)
    last = acceleration_at(a, target - s.time)
    strongest = wp.where(leaps, size(m.scale) * ground.strongest, larger(size(a.a0), size(last)))
    # g is p^2 / q.
    asked = strongest * block.coupling / block.frequency_squared
    return (
        gets_on,
        wp.where(gets_on, wp.where(leaps, far, target), s.time),
        wp.where(gets_on, s.segment + passed, s.segment),
        wp.where(gets_on, larger(asked, s.needed), s.needed),
    )


@wp.func
def roll(block: Block, m: Motion, ground: Ground, until: real, s: State, peak: real):
    """One step of one lane, at most to its next sample or to `until`, if nothing happens in it.

    `peak` is that of |theta| so far.

    Returns:
        Whether it is taken; the state after it.
    """
    knot = knot_time(m, s.segment)
    target = smaller(knot, until)
    room = target - s.time
    cuts = room > block.step_length
    h = wp.where(cuts, block.step_length, room)
    a = expand(m, s.segment, s.time, ground.value, ground.slope)
    theta, omega, rolls = rock_on(block, h, s, peak, a)
    taken = rolls and s.mode == ROCKING and between_samples(m, s.segment) and h <= s.cap
    time = wp.where(cuts, s.time + h, target)
    segment = s.segment + wp.where(time >= knot, 1, 0)
    return taken, State(theta, omega, s.side, time, segment, s.mode, s.cap, s.needed)
