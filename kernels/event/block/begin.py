"""Start of a trial step of a single block: its length, and the motion of the base in it.

A block that rocks about a surely sticking corner, lies still, or slides flat takes steps of up to
the longest one. They end at the impact or the stop, a root of the polynomial of the rotation
(event/block/rocking.py) or of the velocity (event/block/sliding.py). Other steps are of second
order, and shorter.
"""

import warp as wp

from warprock.kernels.event.block.contact import SOON, Block, hold_reserve, lower_corner
from warprock.kernels.event.block.rocking import (
    Curve,
    mirror_acceleration,
    rocking_series,
    value_after,
    zero_of,
)
from warprock.kernels.event.block.sliding import slide_after, slides_flat, sliding_series
from warprock.kernels.event.block.state import Span, State
from warprock.kernels.lane.modes import FLAT, PIVOTING
from warprock.kernels.motion.kinds import (
    Ground,
    Motion,
    acceleration_at,
    expand,
    knot_step,
    knot_time,
)

if MOTION != "record":
    from warprock.kernels.motion.kinds import velocity_at

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
        return velocity_at(m, time) - base - kick


@wp.func
def step_length(
    block: Block, resting: bool, quiet: bool, omega: real, room: real, cap: real
) -> real:
    """Length of the next step [s]; a block that will stay at rest takes all that is left."""
    zero = real(0.0)
    d = smaller(smaller(block.longest_step, REACH / (size(omega) + SLOWEST)), cap)
    # A remainder of round-off alone is not a step of its own.
    left = (resting and quiet) or room < d * MORE
    return larger(wp.where(left, room, d), zero)


@wp.func
def begin_step(
    block: Block, gravity: real, m: Motion, ground: Ground, end: real, live: bool, s: State
):
    """The length of a trial step of a lane, and the motion of the base in it.

    The step ends at the impact of a block that turns about a surely sticking corner, and at the
    stop of one that slides flat.

    Returns:
        The step; the rotation in it if the corner sticks, reflected so that the block leans to +x;
        the side to which the block leans, or would lean if it lifted; the distance that a block
        slides flat [m], else 0.
    """
    zero = real(0.0)
    knot = knot_time(m, s.segment)
    target = smaller(knot, end)
    room = target - s.time
    resting = s.mode == FLAT and s.slip == zero
    d = step_length(block, resting, s.segment == 0 or knot >= NEVER, s.omega, room, s.cap)
    d = wp.where(live, d, zero)
    a = expand(m, s.segment, s.time, ground.value, ground.slope)
    last = acceleration_at(a, d)
    upright = wp.where(s.mode == FLAT, wp.where(s.slip != zero, s.slip, -a.a0 - last), s.omega)
    side = sign_of(wp.where(s.theta != zero, s.theta, upright))
    th, om = side * s.theta, side * s.omega
    lower = lower_corner(block, th)
    seen = mirror_acceleration(side, a)
    curve, _x2, _z2 = rocking_series(block, gravity, lower, th, om, seen)
    _reserve, surely = hold_reserve(block, gravity, s.slip, lower, om, seen.a0)
    # A block at rest that friction does not hold is about to slide.
    starts = size(a.a0) >= (real(1.0) - SOON) * block.friction * gravity
    rolls = s.slip == zero and ((s.mode == FLAT and not starts) or (s.mode == PIVOTING and surely))
    slides = slides_flat(block, s.mode, s.slip, s.vx)
    speed = sliding_series(block, gravity, s.slip * s.vx, mirror_acceleration(s.slip, a))
    d = wp.where(rolls or slides, d, smaller(d, block.short_step))
    # The polynomial whose root is the event: the rotation, or the velocity.
    p = Curve(
        wp.where(slides, speed.c0, th), wp.where(slides, speed.c1, om),
        wp.where(slides, speed.c2, curve.c2), wp.where(slides, speed.c3, curve.c3),
        wp.where(slides, speed.c4, curve.c4), wp.where(slides, speed.c5, curve.c5),
        wp.where(slides, speed.c6, curve.c6),
    )  # fmt: skip
    ends = value_after(p, d)
    meets = (slides or (rolls and s.mode == PIVOTING)) and ends < zero
    d = wp.where(meets, zero_of(p, first_root(p.c0, p.c1, ends, d), d), d)
    slid = wp.where(slides, slide_after(speed, d), zero)
    time = wp.where(d >= room, target, s.time + d)
    passed = time >= knot
    kick = wp.where(passed, knot_step(m, s.segment), zero)
    last = acceleration_at(a, d)
    dv = base_change(m, time, d, last, a.a1, s.base, kick)
    return Span(d, time, passed, a.a0, last, dv, kick), curve, side, slid
