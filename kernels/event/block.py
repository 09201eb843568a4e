"""Contact step of a rocking block, impacts located: order 5 where it rocks, 2 where it slides.

The block lives in the frame of the base: mass 1, clockwise rotation theta, half sizes b and h,
inertia I; corner (X, Z) from the centre of mass moves at (vx + omega Z, vz - omega X). Every
step is seen so that the block leans to +x (reflected where it leans to -x): its lower corner is

    X = b cos(theta) - h sin(theta),   Z = -b sin(theta) - h cos(theta).

Where the lower corner surely sticks in a step of length d, or a block at rest lifts about it, the
rotation is a Taylor polynomial (event/block_rocking.py), and the step ends where that comes to the
other corner's impact. One that slides flat does alike (event/block_sliding.py). Else, in steps of
half of `time_step` (Moreau 1988, Jean 1999; at the midpoint second order in d):

    1. mean velocity v_m = v - (dV/2, g d/2, 0) + M^-1 J^T l, J at theta + omega d/2, dV the change
       of the base velocity in the step. Contact impulses l = (n, f) exactly: a sticking corner
       has no mean velocity, a sliding one no normal mean velocity and |f| = friction n; without
       n >= 0 the corner leaves. On the base lies the block where both corners keep n >= 0;
    2. q = q + d v_m and v = 2 v_m - v; the lower corner of a block in contact is put back on the
       base, and where it sticks also along it (this removes the drift).

At the end of either:

    3. if an event lies inside the step (the other corner or a flying one lands, a sliding corner
       stops, a sticking corner slips, a sliding one leaves, the block has overturned), nothing is
       taken: the next step ends there, by the parabola through both ends and the first velocity.
       The holding force decides whether a corner slips or leaves, from the accelerations at both
       ends (`hold_reserve` in event/block_contact.py); as long as the one at the start is surely
       inside its bound, the corner does in the step what it did before;
    4. v is projected on the contacts at the end of the step, along their force. Where a corner
       lands or the base steps its velocity this is the inelastic impact with Coulomb friction,
       one contact or both at once, whichever obeys the contact law (event/block_impact.py). The
       base's velocity steps fall on ends of steps. Where sticking and leaving both obey it, the
       corner sticks. Sliding that has turned round by now ends.

A block at rest looks ahead where the base may let it go (event/lift.py): its step ends there.
Most steps have no event at all, and event/block_roll.py takes those.

A corner that leaves and lands, or a swing that dips through zero and turns back, inside one step
is not seen; what they would do is of the order of d^2.

A lane's state: theta [rad]; slide of the lower corner along the base and its gap above it [m];
vx, vz [m/s] and omega [rad/s] relative to the base; slip, the direction in which the corner
slides (-1, 1, or 0 where it sticks); mode (FLYING, PIVOTING, FLAT, OVERTURNED, BROKEN); time [s],
segment (knots of the motion passed), base velocity [m/s], cap, the longest step allowed next
time [s]. `Record` below names what is observed.

Rest rule: after an impact on its other corner the block rests if, under the acceleration of that
moment (when sliding: under its friction), its next swing would stay below `rest_rotation` on
either side. The impacts that it leaves out take a time, as in housner/block.py, that is added to
the rest time.
"""

import warp as wp

from warprock.kernels.event.block_begin import begin, first_root
from warprock.kernels.event.block_contact import (
    SOON,
    Block,
    held_velocity,
    hold_reserve,
    lower_corner,
)
from warprock.kernels.event.block_impact import end_of_step
from warprock.kernels.event.block_rocking import advance, rate_after, rotation_after, turning_point
from warprock.kernels.event.lift import Lack, held_time
from warprock.kernels.modes import BROKEN, FLAT, FLYING, OVERTURNED, PIVOTING
from warprock.kernels.motion import Motion, acceleration_after, knot_time, series

NEARLY = by_precision(1.0e-6, 1.0e-4)
"""Part of the longest step by which the time of an event may be missed."""
GRAIN = by_precision(1.0e-14, 1.0e-6)
"""Round-off of a gap, as a part of the half height."""
TICK = by_precision(1.0e-15, 5.0e-7)
"""Four roundings of a time, relative: an event that is nearer has come, or no step would end."""
LEAST = real(0.125)
"""A step in which a force reaches its bound is cut to no less than this part of it at once: the
force at the end of a step that is far too long says little about when."""


@wp.struct
class Knobs:
    """What a step needs to know of the settings."""

    gravity: real


@wp.func
def look_ahead(
    block: Block, m: Motion, sample: real, sample_slope: real, end: real, time: real, segment: int
) -> real:
    """Longest step of a block at rest [s]: see event/lift.py."""
    d = smaller(block.longest_step, smaller(knot_time(m, segment), end) - time)
    a0, a1, a2, a3, a4, a5, a6, a7, a8 = series(m, segment, time, sample, sample_slope)
    a = acceleration_after(a0, a1, a2, a3, a4, a5, a6, a7, a8, d)
    s = -sign_of(wp.where(size(a) > size(a0), a, a0))
    hold = block.hold_acceleration
    lack = Lack(fused(s, a0, hold), s * a1, s * a2, s * a3, s * a4, s * a5, s * a6, s * a7, s * a8)
    return held_time(lack, hold, TICK * fused(size(a1), time, hold), d)


@wp.func
def missed_event(
    flying: bool, theta: real, omega: real, theta1: real, omega1: real,
    gap: real, rise: real, gap1: real, rise1: real,
    slip: real, along: real, along1: real, reach: real, holds: bool, lack: real, lack1: real,
    d: real, per: real, near: real, grain: real,
):  # fmt: skip
    """Whether an event lies inside a step, and the length of the step that ends there.

    Args:
        flying: Whether no corner touches the base in the step.
        theta, omega: Rotation [rad] and its rate [rad/s] at the start; with a 1 at the end.
        gap, rise, along: Gap of the lower corner [m], its rate, and the corner's velocity along the
            base [m/s], at the start; with a 1 at the end.
        lack: `hold_reserve` at the start; with a 1 at the end.
        slip: Direction of sliding in the step.
        reach: How far a stop may be missed [m/s].
        holds: Whether at the start the force surely holds a corner that the block turns about.
        d, per: Length of the step [s] and its reciprocal.
        near: Time by which an event may be missed [s].
        grain: Gap that is round-off [m].
    """
    zero = real(0.0)
    past = theta1 > fused(near, size(omega1), HALF_PI)
    below = theta1 < -near * size(omega1)
    sinks = flying and gap1 < fused_less(near, size(rise1), -grain)
    stops = slip * along > zero and slip * along1 < -reach
    lifts = holds and lack1 < -SOON * lack and d > near
    e0 = wp.where(stops, slip * along, lack)
    e1 = wp.where(stops, slip * along1, lack1)
    slope = (e1 - e0) * per
    e0 = wp.where(sinks, gap, e0)
    e1 = wp.where(sinks, gap1, e1)
    slope = wp.where(sinks, rise, slope)
    e0 = wp.where(below, theta, e0)
    e1 = wp.where(below, theta1, e1)
    slope = wp.where(below, omega, slope)
    e0 = wp.where(past, HALF_PI - theta, e0)
    e1 = wp.where(past, HALF_PI - theta1, e1)
    slope = wp.where(past, -omega, slope)
    # Not shorter than `near`: with less than that left to go, the event counts as reached.
    least = wp.where(past or below or sinks or stops, HALF * near, larger(LEAST * d, HALF * near))
    cut = larger(first_root(e0, slope, e1, d), least)
    return past or below or sinks or stops or lifts, cut


@wp.func
def held_at_end(
    block: Block, mode: int, slip: real, slip1: real, idle: bool, along: real, along1: real,
    near: real, per: real, s: real, c: real, ux: real, uz: real, uo: real,
):  # fmt: skip
    """Velocity at the end of a step, projected on its contact; sliding that turned round ends.

    Args:
        block, mode: The block and its mode in the step.
        slip, slip1: Direction of sliding at the start and in the step.
        idle: Whether the step has no length.
        along, along1: Velocity of the corner along the base at the start and at the end [m/s], not
            projected: where friction nearly jams the block, that would hide how far it overshot.
        near, per: Time by which an event may be missed [s]; one over the length of the step.
        s, c: Sine and cosine of the rotation at the end.
        ux, uz, uo: Velocity there, before.

    Returns:
        Velocity (three values), direction of sliding, how far a stop may be missed [m/s].
    """
    zero = real(0.0)
    reach = near * size(along1 - along) * per
    turned = slip1 * along1 <= wp.where(slip * along > zero, reach, zero)
    slides = wp.where(turned and not idle, zero, slip1)
    vx, vz, omega = held_velocity(block, mode, slides, s, c, ux, uz, uo)
    x, z = lower_corner(block, s, c)
    # Nor does it go on where its own friction turned it round in the projection.
    slides = wp.where(slides * fused(omega, z, vx) <= zero and not idle, zero, slides)
    # The force of a corner that sticks has no moment about it.
    turn = block.inverse_pivot_inertia * fused(x, uz, fused_less(z, ux, block.inertia * uo))
    sticks = mode == PIVOTING and slides == zero
    return (
        wp.where(sticks, -turn * z, vx), wp.where(sticks, turn * x, vz),
        wp.where(sticks, turn, omega), slides, reach,
    )  # fmt: skip


@wp.func
def way_along(
    block: Block, gravity: real, mode: int, slip: real, slips: real, slip1: real, rocks: bool,
    slid: real, moved: real, lost: real,
):  # fmt: skip
    """How far the lower corner comes along the base in a step, and what friction takes there.

    Args:
        block, gravity: What they are elsewhere.
        mode: FLYING, PIVOTING or FLAT in the step.
        slip, slips, slip1: Direction of sliding at the start, in the step and at the end.
        rocks: Whether the corner sticks and the rotation follows its polynomial.
        slid: Way of a block that slides flat [m], from its polynomial; else 0.
        moved: The way by the mean velocity of the step [m].
        lost: Energy per unit mass that friction takes by that [J/kg].
    """
    zero = real(0.0)
    moves = mode == FLYING or (slips != zero and (slip != zero or slip1 != zero))
    glides = slid > zero and mode == FLAT
    return (
        wp.where(glides, slid, wp.where(moves, moved, zero)),
        wp.where(glides, block.friction * gravity * slid, wp.where(rocks, zero, lost)),
    )


@wp.func
def integrate(
    block: Block, gravity: real, near: real, mode: int, slip: real, a0: real, a: real, dv: real,
    d: real, slid: real, theta: real, gap: real, vx: real, vz: real, omega: real,
    t2: real, t3: real, t4: real, t5: real, t6: real,
):  # fmt: skip
    """The step up to its end, before the projection; the block leans to +x.

    Args:
        block, gravity, mode, slip: What they are elsewhere.
        near: Time by which an event may be missed [s].
        a0, a: Acceleration of the base at the start and at the end of the step [m/s^2].
        dv, d: Change of the base velocity in the step [m/s] and its length [s].
        slid: Way along the base where the block slides flat [m], else 0.
        theta, gap, vx, vz, omega: State at the start.
        t2 to t6: Taylor coefficients of the rotation, should the corner stick.

    Returns:
        Rotation, slide along the base in the step, gap, velocity (three values), mode and
        direction of sliding in the step, energy lost per unit mass; whether an event was missed,
        the length of the step to it; whether the block falls on its other corner, whether its
        lower corner lands; sine and cosine of the rotation; how deep a corner is [m]; coefficients
        2 to 6 of the polynomial that the rotation follows.
    """
    zero = real(0.0)
    per, idle = real(1.0) / d, d <= zero
    x0, z0 = lower_corner(block, sine(theta), cosine(theta))
    reserve, surely = hold_reserve(block, gravity, slip, x0, z0, omega, a0)
    mx, mz, _mo, mode1, slips, lost, rocks, k2, k3, k4, k5, k6 = advance(
        block, gravity, mode, slip, surely, dv, d, theta, vx, vz, omega, t2, t3, t4, t5, t6
    )
    theta1 = rotation_after(theta, omega, k2, k3, k4, k5, k6, d)
    s1, c1 = sine(theta1), cosine(theta1)
    x1, z1 = lower_corner(block, s1, c1)
    raw_omega = rate_after(omega, k2, k3, k4, k5, k6, d)
    raw_vx = wp.where(rocks, -raw_omega * z1, fused(TWO, mx, -vx))
    raw_vz = wp.where(rocks, raw_omega * x1, fused(TWO, mz, -vz))
    along, along1 = fused(omega, z0, vx), fused(raw_omega, z1, raw_vx)
    vx1, vz1, omega1, slip1, reach = held_at_end(
        block, mode1, slip, slips, idle, along, along1, near, per, s1, c1, raw_vx, raw_vz, raw_omega
    )
    glide, lost = way_along(
        block, gravity, mode1, slip, slips, slip1, rocks, slid, fused(d, mx, x1 - x0), lost
    )
    flying, raw_gap = mode1 == FLYING, wp.where(rocks, zero, fused(d, mz, gap) + (z1 - z0))
    gap1 = wp.where(flying, wp.where(mode != FLYING, larger(raw_gap, zero), raw_gap), zero)
    rise1 = fused_less(omega1, x1, vz1)
    reserve1, _surely = hold_reserve(block, gravity, slip, x1, z1, omega1, a)
    holds = surely and (mode == PIVOTING or mode1 == PIVOTING)
    grain = GRAIN * block.half_height
    missed, cut = missed_event(
        flying, theta, omega, theta1, omega1, gap, fused_less(omega, x0, vz), gap1, rise1,
        slip, along, along1, reach, holds, reserve, reserve1, d, per, near, grain,
    )  # fmt: skip
    falls = mode1 != FLAT and omega1 < zero and theta1 <= -near * omega1
    lands = flying and rise1 < zero and gap1 <= fused_less(near, rise1, grain)
    return (
        theta1, glide, gap1, vx1, vz1, omega1, mode1, slip1, lost, missed and not idle, cut, falls,
        lands, s1, c1, larger(-raw_gap, fused(real(-2.0) * block.half_width, s1, -raw_gap)),
        k2, k3, k4, k5, k6,
    )  # fmt: skip


@wp.func
def step(
    block: Block, knobs: Knobs, m: Motion, sample: real, sample_slope: real, end: real, going: bool,
    theta: real, slide: real, gap: real, vx: real, vz: real, omega: real, slip: real, mode: int,
    time: real, segment: int, base: real, cap: real,
):  # fmt: skip
    """One trial step of one lane, at most to its next knot or to `end`.

    From `theta` on the lane's state, see the head of this file; the step returns it in the same
    order, unchanged but for `cap` where an event lay inside. Behind it: highest turning point in
    the step [rad] and its time [s], energy lost per unit mass [J/kg], time of the impacts that
    resting leaves out [s], whether an impact ended the step, whether the step was taken, how
    deep a corner was in the base at its end, before it was put back [m], and coefficients 2 to 6
    of the polynomial that the rotation followed.
    """
    zero = real(0.0)
    live = mode < OVERTURNED and going
    near = larger(NEARLY * block.longest_step, TICK * time)
    d, time1, passed, kick, side, a0, a, dv, slid, t2, t3, t4, t5, t6 = begin(
        block, knobs.gravity, m, sample, sample_slope, end, live,
        theta, vx, omega, slip, mode, time, segment, base, cap,
    )  # fmt: skip
    th, om, va = side * theta, side * omega, side * vx
    (
        th1, glide, gap1, vx1, vz1, om1, mode1, slip1, lost, missed, cut, falls, lands, s, c, deep,
        k2, k3, k4, k5, k6,
    ) = integrate(
        block, knobs.gravity, near, mode, side * slip, side * a0, side * a, side * dv, d,
        slid, th, gap, va, vz, om, t2, t3, t4, t5, t6,
    )  # fmt: skip
    turn, vx2, vz2, om2, mode2, slip2, lost2, hit, tail = end_of_step(
        block, knobs.gravity, falls, lands, side * kick, a, mode1, slip1, s, c, th1,
        vx1, vz1, om1,
    )  # fmt: skip
    over = th1 >= fused_less(near, om1, HALF_PI)
    th2 = wp.where(falls or mode1 == FLAT, zero, wp.where(over, HALF_PI, th1))
    sound = th2 - th2 == zero and om2 - om2 == zero and vx2 - vx2 == zero and vz2 - vz2 == zero
    size2 = block.half_width * block.half_height
    sound = sound and time1 - time1 == zero and size2 - size2 == zero
    mode2 = wp.where(sound, wp.where(over, OVERTURNED, mode2), BROKEN)
    taken = live and not (missed and sound)
    turns = taken and om > zero and om1 < zero
    apex, rise = turning_point(th, om, k2, k3, k4, k5, k6, d, om1)
    face = side * turn
    return (
        wp.where(taken, face * th2, theta), wp.where(taken, fused(side, glide, slide), slide),
        wp.where(taken, wp.where(lands, zero, gap1), gap), wp.where(taken, face * vx2, vx),
        wp.where(taken, vz2, vz), wp.where(taken, face * om2, omega),
        wp.where(taken, face * slip2, slip), wp.where(taken, mode2, mode),
        wp.where(taken, time1, time), segment + wp.where(taken and passed, 1, 0),
        wp.where(taken, base + dv + kick, base), wp.where(taken, NEVER, wp.where(live, cut, cap)),
        wp.where(turns, apex, zero), time + wp.where(turns, rise, zero),
        wp.where(taken, lost + lost2, zero), wp.where(taken, tail, zero), taken and hit, taken,
        wp.where(taken, deep, zero), side * k2, side * k3, side * k4, side * k5, side * k6,
    )  # fmt: skip
