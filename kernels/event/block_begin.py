"""What a trial step of a single block begins with: its length, and the base's motion in it.

A block that rocks about a corner that surely sticks, lies still, or slides flat takes steps of up
to the longest one, which end where its polynomial (event/block_rocking.py, event/block_sliding.py)
comes to an impact or a stop. All others are of second order and take shorter ones.
"""

import warp as wp

from warprock.kernels.event.block_contact import SOON, Block, hold_reserve, lower_corner
from warprock.kernels.event.block_rocking import landing, rocking_series, rotation_after
from warprock.kernels.event.block_sliding import slide_after, slides_flat, sliding_series
from warprock.kernels.modes import FLAT, PIVOTING
from warprock.kernels.motion import (
    Motion,
    acceleration_after,
    base_velocity,
    knot_step,
    knot_time,
    series,
)

REACH = real(0.125)
"""Largest rotation in one step [rad]: keeps fast overturning inside the polynomials' range."""

MORE = by_precision(1.0 + 1.0e-9, 1.0 + 1.0e-5)
"""A step may be longer by this factor to end at a knot."""

SLOWEST = real(1.0e-30)
"""Keeps a quotient by an angular velocity of -0.0 positive [rad/s]."""


@wp.func
def first_root(e0: real, slope: real, e1: real, d: real) -> real:
    """First root of the parabola that starts at e0 >= 0 with a slope and is below zero at d."""
    bend = fused_less(slope, d, e1 - e0) / (d * d)
    square = fused(slope, slope, real(-4.0) * e0 * bend)
    root = wp.sqrt(larger(square, real(0.0)))
    rises = slope > real(0.0)
    over = wp.where(rises, slope + root, TWO * e0)
    return smaller(over / wp.where(rises, -TWO * bend, root - slope), d)


if MOTION == "record":

    @wp.func
    def base_change(
        m: Motion, time: real, d: real, a: real, slope: real, base: real, kick: real
    ) -> real:
        """Change of the base velocity in a step [m/s]: the acceleration is linear in it."""
        return d * fused_less(HALF * d, slope, a)

else:

    @wp.func
    def base_change(
        m: Motion, time: real, d: real, a: real, slope: real, base: real, kick: real
    ) -> real:
        """Change of the base velocity in a step that ends at a time [m/s], without the kick."""
        zero = real(0.0)
        return base_velocity(m, time, zero, zero, zero) - base - kick


@wp.func
def step_length(
    block: Block, resting: bool, quiet: bool, omega: real, room: real, cap: real
) -> real:
    """Length of the next step [s]; a block that will stay at rest takes all that is left."""
    zero = real(0.0)
    d = smaller(smaller(block.longest_step, REACH / (size(omega) + SLOWEST)), cap)
    # What would be left by round-off alone is not a step of its own.
    left = (resting and quiet) or room < d * MORE
    return larger(wp.where(left, room, d), zero)


@wp.func
def begin(
    block: Block, gravity: real, m: Motion, sample: real, sample_slope: real, end: real, live: bool,
    theta: real, vx: real, omega: real, slip: real, mode: int, time: real, segment: int,
    base: real, cap: real,
):  # fmt: skip
    """What a trial step of a lane begins with.

    Where a corner surely sticks the step ends at the impact that its polynomial comes to, and
    where a block slides flat at its stop.

    Returns:
        Its length [s], its end, whether that is a knot, the velocity step of the base there; the
        side that the block leans to or would if it lifted; acceleration of the base at both ends
        [m/s^2], change of its velocity between [m/s]; way that the block slides where it does so
        flat [m], else 0; coefficients 2 to 6 of the rotation should the corner stick, seen so that
        the block leans to +x.
    """
    zero = real(0.0)
    knot = knot_time(m, segment)
    target = smaller(knot, end)
    room = target - time
    resting = mode == FLAT and slip == zero
    d = step_length(block, resting, segment == 0 or knot >= NEVER, omega, room, cap)
    d = wp.where(live, d, zero)
    a0, a1, a2, a3, a4, a5, a6, a7, a8 = series(m, segment, time, sample, sample_slope)
    a = acceleration_after(a0, a1, a2, a3, a4, a5, a6, a7, a8, d)
    upright = wp.where(mode == FLAT, wp.where(slip != zero, slip, -a0 - a), omega)
    side = sign_of(wp.where(theta != zero, theta, upright))
    th, om = side * theta, side * omega
    x, z = lower_corner(block, sine(th), cosine(th))
    t2, t3, t4, t5, t6, _x2, _z2 = rocking_series(
        block, gravity, x, z, om, side * a0, side * a1, side * a2, side * a3, side * a4
    )
    _reserve, surely = hold_reserve(block, gravity, slip, x, z, om, side * a0)
    # One at rest that friction does not hold is about to slide.
    starts = size(a0) >= (real(1.0) - SOON) * block.friction * gravity
    rolls = slip == zero and ((mode == FLAT and not starts) or (mode == PIVOTING and surely))
    slides = slides_flat(block, mode, slip, vx)
    u = slip * vx
    u1, u2, u3, u4, u5, u6 = sliding_series(
        block, gravity, slip * a0, slip * a1, slip * a2, slip * a3, slip * a4, slip * a5
    )
    d = wp.where(rolls or slides, d, smaller(d, block.short_step))
    # The polynomial that comes to zero at the event: the rotation, or the velocity.
    p0, p1, p2 = wp.where(slides, u, th), wp.where(slides, u1, om), wp.where(slides, u2, t2)
    p3, p4 = wp.where(slides, u3, t3), wp.where(slides, u4, t4)
    p5, p6 = wp.where(slides, u5, t5), wp.where(slides, u6, t6)
    ends = rotation_after(p0, p1, p2, p3, p4, p5, p6, d)
    meets = (slides or (rolls and mode == PIVOTING)) and ends < zero
    met = landing(p0, p1, p2, p3, p4, p5, p6, first_root(p0, p1, ends, d), d)
    d = wp.where(meets, met, d)
    slid = wp.where(slides, slide_after(u, u1, u2, u3, u4, u5, u6, d), zero)
    time1 = wp.where(d >= room, target, time + d)
    passed = time1 >= knot
    kick = wp.where(passed, knot_step(m, segment), zero)
    a = acceleration_after(a0, a1, a2, a3, a4, a5, a6, a7, a8, d)
    return (
        d, time1, passed, kick, side, a0, a, base_change(m, time1, d, a, a1, base, kick),
        slid, t2, t3, t4, t5, t6,
    )  # fmt: skip
