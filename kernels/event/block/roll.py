"""Steps without an event of a block that rocks about a sticking corner, rests, or slides flat.

They cost two fifths of a step of event/block/step.py, which takes all others: steps with an impact,
an uplift, a stop or a velocity step of the base; steps of a block that slides on a corner or flies;
and steps at whose start or end the force on the corner is near its bound. A step that is declined
here changes nothing.
"""

import warp as wp

from warprock.kernels.event.block.begin import REACH, base_change, step_length
from warprock.kernels.event.block.contact import Block, Velocity, lower_corner
from warprock.kernels.event.block.rocking import (
    Curve,
    mirror_acceleration,
    mirror_curve,
    rate_after,
    rocking_series,
    sticks_surely,
    turning_point,
    value_after,
)
from warprock.kernels.event.block.sliding import slide_after, slides_flat, sliding_series
from warprock.kernels.event.block.state import Shown, State
from warprock.kernels.event.block.step import NEARLY, Knobs
from warprock.kernels.lane.modes import FLAT, PIVOTING
from warprock.kernels.motion.kinds import (
    LINEAR,
    Acceleration,
    Ground,
    Motion,
    acceleration_at,
    expand,
    knot_step,
    knot_time,
    weak_samples_ahead,
)
from warprock.kernels.motion.pool import AHEAD


@wp.func
def rock(
    block: Block, gravity: real, near: real, d: real, side: real, s: State, a: Acceleration,
    last: real,
):  # fmt: skip
    """A step about a corner that sticks.

    Args:
        block: The block.
        gravity: [m/s^2].
        near: Time by which an event may be missed [s].
        d: Length of the step [s].
        side: The side that the block leans to.
        s: State at the start.
        a, last: Acceleration of the base, and that at the end [m/s^2].

    Returns:
        Whether no event lies in it; velocity at its end and rotation in it, reflected so that the
        block leans to +x.
    """
    th, om = side * s.theta, side * s.omega
    at = lower_corner(block, th)
    curve, x2, z2 = rocking_series(block, gravity, at, th, om, mirror_acceleration(side, a))
    th1 = value_after(curve, d)
    om1 = rate_after(curve, d)
    end = lower_corner(block, th1)
    turn = block.inverse_pivot_inertia * fused_less(gravity, end.x, side * last * end.z)
    held = sticks_surely(block, fused_less(TWO, z2, gravity), fused_less(TWO, x2, side * a.a0))
    held1 = sticks_surely(
        block, fused(om1 * om1, end.z, fused(turn, end.x, gravity)),
        fused(om1 * om1, end.x, fused_less(turn, end.z, side * last)),
    )  # fmt: skip
    stands = th1 > near * size(om1) and th1 < fused_less(near, size(om1), HALF_PI)
    stands = stands and d * size(om) < REACH
    return held and held1 and stands, Velocity(-side * om1 * end.z, om1 * end.x, om1), curve


@wp.func
def roll(block: Block, knobs: Knobs, m: Motion, ground: Ground, end: real, going: bool, s: State):
    """One step of one lane, at most to its next knot or to `end`, where no event lies in it.

    A block at rest passes many samples of a record at once that are too weak to move it. The step
    does not follow the velocity of the base then, which only other motions need.

    Returns:
        The state after it, unchanged where it is declined; what the step adds to the response; the
        rotation that it followed.
    """
    zero = real(0.0)
    rests = s.mode == FLAT and s.slip == zero
    knot = knot_time(m, s.segment)
    target = smaller(knot, end)
    room = target - s.time
    # How fast the block turns does not shorten this step; a fast one is declined.
    d = step_length(block, rests, s.segment == 0 or knot >= NEVER, zero, room, NEVER)
    time = wp.where(d >= room, target, s.time + d)
    passed = time >= knot
    jolts = passed and knot_step(m, s.segment) != zero
    a = expand(m, s.segment, s.time, ground.value, ground.slope)
    last = acceleration_at(a, d)
    side, near = sign_of(wp.where(s.theta != zero, s.theta, s.omega)), NEARLY * block.longest_step
    rocks, rolled, curve = rock(block, knobs.gravity, near, d, side, s, a, last)
    hold = block.hold_acceleration
    weak, far = weak_samples_ahead(m, s.segment, ground.strongest, hold)
    calm = rests and weak and far <= end
    # The acceleration is below its bound at both ends, and so are its first terms together between.
    below = size(a.a0) < hold and size(last) < hold
    if not LINEAR:
        below = below and fused(d, fused(d, size(a.a2), size(a.a1)), size(a.a0)) < hold
    still = calm or (rests and below)
    dv = base_change(m, time, d, last, a.a1, s.base, zero)
    u = s.slip * s.vx
    speed = sliding_series(block, knobs.gravity, u, mirror_acceleration(s.slip, a))
    pull = d * block.friction * knobs.gravity
    after = fused_less(s.slip, dv, u) - pull
    slides = slides_flat(block, s.mode, s.slip, s.vx) and d * after > near * size(after - u)
    slid = slide_after(speed, d)
    apex, rise = turning_point(curve, d, rolled.omega)
    turns = curve.c1 > zero and rolled.omega < zero
    rocks = rocks and s.mode == PIVOTING and s.slip == zero
    taken = going and (calm or not jolts) and (still or slides or rocks)
    rolls = taken and rocks
    glides = taken and slides
    new = State(
        wp.where(rolls, side * value_after(curve, d), s.theta),
        s.slide + wp.where(glides, s.slip * slid, zero), s.gap,
        wp.where(rolls, rolled.x, wp.where(glides, s.slip * after, s.vx)),
        wp.where(rolls, rolled.z, s.vz), wp.where(rolls, side * rolled.omega, s.omega), s.slip,
        s.mode, wp.where(taken, wp.where(calm, far, time), s.time),
        s.segment + wp.where(taken, wp.where(calm, AHEAD, wp.where(passed, 1, 0)), 0),
        s.base + wp.where(taken, dv, zero), s.cap,
    )  # fmt: skip
    shown = Shown(
        taken, False, wp.where(rolls and turns, apex, zero),
        s.time + wp.where(rolls, wp.where(turns, rise, zero), zero),
        wp.where(glides, block.friction * knobs.gravity * slid, zero), zero, zero,
    )  # fmt: skip
    swung = mirror_curve(side, curve)
    path = Curve(
        s.theta, s.omega, wp.where(rocks, swung.c2, zero), wp.where(rocks, swung.c3, zero),
        wp.where(rocks, swung.c4, zero), wp.where(rocks, swung.c5, zero),
        wp.where(rocks, swung.c6, zero),
    )  # fmt: skip
    return new, shown, path
