"""Steps of Housner's block under a record in which nothing happens.

A record is linear between its samples, and most steps end at one of them without an event. Such a
step is that of housner/block.py, to the last bit, but for the search of an event and of the
friction that it needs. A step that may hold an event, or need more friction than any before it, is
declined, and has changed nothing; housner/block.py takes it. That costs four times as much.

A block at rest passes all samples of which none could lift it, which is no step.
"""

import warp as wp

from warprock.kernels.housner.block import REACH, Block, tops_below
from warprock.kernels.housner.block_contact import rocking_series
from warprock.kernels.modes import RESTING, ROCKING
from warprock.kernels.motion import Motion, between_samples, knot_time, series, undisturbed
from warprock.kernels.pool import AHEAD
from warprock.kernels.shape.taylor import slope_at, value_at

NEARLY_ALL = by_precision(1.0 - 1.0e-9, 1.0 - 1.0e-5)
"""Part of a bound up to which a step is taken here: what round-off could decide is declined."""


@wp.func
def suffices(
    friction: real, h: real, n0: real, n1: real, n2: real, n3: real,
    f0: real, f1: real, f2: real, f3: real,
) -> bool:  # fmt: skip
    """Whether a friction surely holds in a step of length h: n and f are chords and what bends."""
    n = fused_less(h * h, fused(size(n3), h, size(n2)), smaller(n0, fused(n1, h, n0)))
    f = fused(h * h, fused(size(f3), h, size(f2)), larger(size(f0), size(fused(f1, h, f0))))
    return f < NEARLY_ALL * friction * n


@wp.func
def rocks_on(
    block: Block, h: real, side: real, theta: real, omega: real, peak: real, needed: real,
    a0: real, a1: real,
):  # fmt: skip
    """A step of a rocking block: theta and omega after it, whether nothing happens in it."""
    zero = real(0.0)
    (
        t2, t3, t4, t5, t6, t7, t8, t9, t10,
        n0, n1, n2, n3, _n4, _n5, _n6, f0, f1, f2, f3, _f4, _f5, _f6,
    ) = rocking_series(
        block.frequency_squared, block.coupling, theta - side * block.slenderness_angle, omega,
        a0, a1, zero, zero, zero, zero, zero, zero, zero,
    )  # fmt: skip
    theta1 = value_at(theta, omega, t2, t3, t4, t5, t6, t7, t8, t9, t10, h)
    omega1 = slope_at(omega, t2, t3, t4, t5, t6, t7, t8, t9, t10, h)
    lean, lean1 = side * theta, side * theta1
    stands = lean >= zero and lean1 > zero and lean1 < NEARLY_ALL * HALF_PI
    passes = tops_below(
        NEARLY_ALL * peak, lean, side * omega, side * t2, side * t3, t4, t5, t6, t7, t8, t9, t10, h
    )
    one_way = (omega * omega1 >= zero or passes) and size(omega) * h < NEARLY_ALL * REACH
    fallen = lean >= block.fall_angle and side * omega >= zero
    held = fallen or suffices(needed, h, n0, n1, n2, n3, f0, f1, f2, f3)
    return theta1, omega1, stands and one_way and held


@wp.func
def rest_on(
    block: Block, m: Motion, sample: real, sample_slope: real, strongest: real, until: real,
    time: real, segment: int, mode: int, cap: real,
):  # fmt: skip
    """Takes a block at rest past samples that surely do not lift it, at most to `until`.

    `strongest` belongs to the record's segment, as `sample` does.

    Returns:
        Whether it gets on; the time and the segment that it comes to.
    """
    bound = NEARLY_ALL * block.uplift_acceleration
    calm, far = undisturbed(m, segment, strongest, bound)
    leaps = calm and far <= until
    knot = knot_time(m, segment)
    target = smaller(knot, until)
    largest = size(m.scale) * larger(size(sample), size(sample + sample_slope * m.interval))
    weak = largest < bound and between_samples(m, segment)
    gets_on = mode == RESTING and (leaps or (weak and target - time <= cap))
    passed = wp.where(leaps, AHEAD, wp.where(target >= knot, 1, 0))
    return (
        gets_on,
        wp.where(gets_on, wp.where(leaps, far, target), time),
        wp.where(gets_on, segment + passed, segment),
    )


@wp.func
def roll(
    block: Block, m: Motion, sample: real, sample_slope: real, until: real,
    theta: real, omega: real, side: real, time: real, segment: int, mode: int, peak: real,
    cap: real, needed: real,
):  # fmt: skip
    """One step of one lane, at most to its next sample or to `until`, if nothing happens in it.

    The arguments are as of `step` in housner/block.py.

    Returns:
        Whether it is taken; theta, omega, time and segment after it.
    """
    knot = knot_time(m, segment)
    target = smaller(knot, until)
    room = target - time
    cuts = room > block.step_length
    h = wp.where(cuts, block.step_length, room)
    a0, a1, _a2, _a3, _a4, _a5, _a6, _a7, _a8 = series(m, segment, time, sample, sample_slope)
    theta1, omega1, rolls = rocks_on(block, h, side, theta, omega, peak, needed, a0, a1)
    taken = rolls and mode == ROCKING and between_samples(m, segment) and h <= cap
    time1 = wp.where(cuts, time + h, target)
    return taken, theta1, omega1, time1, segment + wp.where(time1 >= knot, 1, 0)
