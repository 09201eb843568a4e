"""Steps of a block that rocks about a corner that sticks, rests, or slides flat, without an event.

They cost two fifths of a step of event/block.py, which takes all others: those with an impact, an
uplift, a stop or a velocity step of the base, those in which a block slides on a corner or flies,
and those at whose start or end the force on the corner is near its bound. What is declined here
has changed nothing.
"""

import warp as wp

from warprock.kernels.event.block import NEARLY, Knobs
from warprock.kernels.event.block_begin import REACH, base_change, step_length
from warprock.kernels.event.block_contact import Block, lower_corner
from warprock.kernels.event.block_rocking import (
    rate_after,
    rocking_series,
    rotation_after,
    sticks_surely,
    turning_point,
)
from warprock.kernels.event.block_sliding import slide_after, slides_flat, sliding_series
from warprock.kernels.modes import FLAT, PIVOTING
from warprock.kernels.motion import (
    LINEAR,
    Motion,
    acceleration_after,
    knot_step,
    knot_time,
    series,
    undisturbed,
)
from warprock.kernels.pool import AHEAD


@wp.func
def rocked(
    block: Block, gravity: real, near: real, d: real, side: real, theta: real, omega: real,
    a0: real, a1: real, a2: real, a3: real, a4: real, a_end: real,
):  # fmt: skip
    """A step about a corner that sticks.

    Returns:
        Whether no event lies in it; rotation, angular velocity and velocity of the centre along and
        across the base at its end; turning point of |rotation| in it, 0 where there is none, and
        its time; Taylor coefficients 2 to 6 of the rotation.
    """
    zero = real(0.0)
    th, om = side * theta, side * omega
    x, z = lower_corner(block, sine(th), cosine(th))
    t2, t3, t4, t5, t6, x2, z2 = rocking_series(
        block, gravity, x, z, om, side * a0, side * a1, side * a2, side * a3, side * a4
    )
    th1 = rotation_after(th, om, t2, t3, t4, t5, t6, d)
    om1 = rate_after(om, t2, t3, t4, t5, t6, d)
    xd, zd = lower_corner(block, sine(th1), cosine(th1))
    turn = block.inverse_pivot_inertia * fused_less(gravity, xd, side * a_end * zd)
    held = sticks_surely(block, fused_less(TWO, z2, gravity), fused_less(TWO, x2, side * a0))
    held1 = sticks_surely(
        block, fused(om1 * om1, zd, fused(turn, xd, gravity)),
        fused(om1 * om1, xd, fused_less(turn, zd, side * a_end)),
    )  # fmt: skip
    stands = th1 > near * size(om1) and th1 < fused_less(near, size(om1), HALF_PI)
    stands = stands and d * size(om) < REACH
    apex, rise = turning_point(th, om, t2, t3, t4, t5, t6, d, om1)
    turns = om > zero and om1 < zero
    return (
        held and held1 and stands,
        side * th1, side * om1, -side * om1 * zd, om1 * xd,
        wp.where(turns, apex, zero), wp.where(turns, rise, zero),
        side * t2, side * t3, side * t4, side * t5, side * t6,
    )  # fmt: skip


@wp.func
def roll(
    block: Block, knobs: Knobs, m: Motion, sample: real, sample_slope: real, strongest: real,
    end: real, going: bool, theta: real, vx: real, vz: real, omega: real, slip: real, mode: int,
    time: real, segment: int, base: real,
):  # fmt: skip
    """One step of one lane, at most to its next knot or to `end`, where no event lies in it.

    A block at rest passes many samples of a record at once which are too weak to move it; the
    velocity of the base, which only other motions ask for, is not followed there.

    Returns:
        theta, omega, vx, vz, time, segment and base, unchanged where it is declined; way along the
        base [m] and energy lost in it per unit mass [J/kg]; turning point of |theta| in the step
        [rad], zero where there is none, and its time [s]; whether the step was taken; coefficients
        2 to 6 of the polynomial that the rotation followed.
    """
    zero = real(0.0)
    rests = mode == FLAT and slip == zero
    knot = knot_time(m, segment)
    target = smaller(knot, end)
    room = target - time
    # How fast the block turns does not shorten this step; a fast one is declined.
    d = step_length(block, rests, segment == 0 or knot >= NEVER, zero, room, NEVER)
    time1 = wp.where(d >= room, target, time + d)
    passed = time1 >= knot
    jolts = passed and knot_step(m, segment) != zero
    a0, a1, a2, a3, a4, a5, a6, a7, a8 = series(m, segment, time, sample, sample_slope)
    a = acceleration_after(a0, a1, a2, a3, a4, a5, a6, a7, a8, d)
    side, near = sign_of(wp.where(theta != zero, theta, omega)), NEARLY * block.longest_step
    rocks, th, om, ux, uz, apex, rise, t2, t3, t4, t5, t6 = rocked(
        block, knobs.gravity, near, d, side, theta, omega, a0, a1, a2, a3, a4, a
    )
    hold = block.hold_acceleration
    weak, far = undisturbed(m, segment, strongest, hold)
    calm = rests and weak and far <= end
    # Ends below the bound, and between them no more than the first terms of the series together.
    below = size(a0) < hold and size(a) < hold
    if not LINEAR:
        below = below and fused(d, fused(d, size(a2), size(a1)), size(a0)) < hold
    still = calm or (rests and below)
    dv = base_change(m, time1, d, a, a1, base, zero)
    u = slip * vx
    u1, u2, u3, u4, u5, u6 = sliding_series(
        block, knobs.gravity, slip * a0, slip * a1, slip * a2, slip * a3, slip * a4, slip * a5
    )
    pull = d * block.friction * knobs.gravity
    after = fused_less(slip, dv, u) - pull
    slides = slides_flat(block, mode, slip, vx) and d * after > near * size(after - u)
    slid = slide_after(u, u1, u2, u3, u4, u5, u6, d)
    rocks = rocks and mode == PIVOTING and slip == zero
    taken = going and (calm or not jolts) and (still or slides or rocks)
    rolls = taken and rocks
    glides = taken and slides
    return (
        wp.where(rolls, th, theta), wp.where(rolls, om, omega),
        wp.where(rolls, ux, wp.where(glides, slip * after, vx)), wp.where(rolls, uz, vz),
        wp.where(taken, wp.where(calm, far, time1), time),
        segment + wp.where(taken, wp.where(calm, AHEAD, wp.where(passed, 1, 0)), 0),
        base + wp.where(taken, dv, zero), wp.where(glides, slip * slid, zero),
        wp.where(glides, block.friction * knobs.gravity * slid, zero),
        wp.where(rolls, apex, zero), time + wp.where(rolls, rise, zero), taken,
        wp.where(rocks, t2, zero), wp.where(rocks, t3, zero), wp.where(rocks, t4, zero),
        wp.where(rocks, t5, zero), wp.where(rocks, t6, zero),
    )  # fmt: skip
