"""Contact step of a rocking block, impacts located: order 5 where it rocks, 2 where it slides.

The block lives in the frame of the base: mass 1, clockwise rotation theta, half sizes b and h,
inertia I; corner (X, Z) from the centre of mass moves at (vx + omega Z, vz - omega X). A step
reflects a block that leans to -x, so that it always leans to +x. Its lower corner is then

    X = b cos(theta) - h sin(theta),   Z = -b sin(theta) - h cos(theta).

Where the lower corner surely sticks in a step of length d, or a block at rest lifts about it, the
rotation is a Taylor polynomial (event/block/rocking.py). The step ends at the impact of the other
corner, a root of that polynomial. The velocity of a block that slides flat is such a polynomial,
too (event/block/sliding.py), and its step ends at the stop. All other steps are at most half as
long as `time_step` and follow the midpoint rule (Moreau 1988, Jean 1999; second order in d):

    1. The mean velocity is v_m = v - (dV/2, g d/2, 0) + M^-1 J^T l, with J at theta + omega d/2 and
       dV the change of the base velocity in the step. The contact impulses l = (n, f) are exact: a
       sticking corner has no mean velocity, a sliding one no normal mean velocity and
       |f| = friction n. A corner for which n would be negative leaves the base. The block lies flat
       where both corners keep n >= 0.
    2. q = q + d v_m and v = 2 v_m - v. The lower corner of a block in contact is put back on the
       base, and where it sticks also along it, which removes the drift.

At the end of a step of either kind:

    3. An event inside the step (the other corner or a flying one lands, a sliding corner stops, a
       sticking corner slips, a sliding one leaves, the block overturns) discards the step. The next
       step ends at the event, which the parabola through both ends and the first velocity predicts.
       Whether a corner slips or leaves follows from the force that holds it, which the
       accelerations at both ends give (`hold_reserve` in event/block/contact.py). While the force
       at the start is surely inside its bound, the contact of the corner stays what it was.
    4. v is projected on the contacts at the end of the step, along their force. Where a corner
       lands, or the velocity of the base steps, this is the inelastic impact with Coulomb friction
       of one contact or of both, whichever obeys the contact law (event/block/impact.py). Steps of
       the base velocity fall on ends of steps. Where sticking and leaving both obey the law, the
       corner sticks. Sliding that has reversed by then ends.

A block at rest looks ahead for the time at which the base lets it go (event/lift.py), and its step
ends there. Most steps have no event at all; event/block/roll.py takes those.

The scheme does not see a corner that leaves and lands inside one step, nor a swing that dips
through zero and turns back inside one. Their effect is of the order of d^2.

`State` is the state of a lane and `Seen` its observed response (event/block/state.py).

Rest rule: after an impact on its other corner the block rests if its next swing would stay below
`rest_rotation` on either side, under the acceleration of that moment, or under its friction where
it slides. The omitted impacts would take a time, as in housner/block.py, which is added to the rest
time.
"""

import warp as wp

from warprock.kernels.event.block.begin import begin_step, first_root
from warprock.kernels.event.block.contact import (
    SOON,
    Block,
    Contact,
    Velocity,
    held_velocity,
    hold_reserve,
    lower_corner,
    step_velocity,
)
from warprock.kernels.event.block.impact import end_step
from warprock.kernels.event.block.rocking import (
    Curve,
    mirror_curve,
    rate_after,
    turning_point,
    value_after,
)
from warprock.kernels.event.block.state import End, Event, Shown, Span, State
from warprock.kernels.event.lift import TICK, held_time, round_off
from warprock.kernels.lane.modes import BROKEN, FLAT, FLYING, OVERTURNED, PIVOTING
from warprock.kernels.motion.kinds import (
    Acceleration,
    Ground,
    Motion,
    acceleration_at,
    expand,
    knot_time,
)

NEARLY = by_precision(1.0e-6, 1.0e-4)
"""Tolerance of the time of an event, as a part of the longest step."""
GRAIN = by_precision(1.0e-14, 1.0e-6)
"""Round-off of a gap, as a part of the half height."""
LEAST = real(0.125)
"""Shortest part to which a step is cut at once when a force reaches its bound: the force at the end
of a step that is far too long says little about the time at which it does."""


@wp.struct
class Knobs:
    """Settings of a step: gravity [m/s^2]."""

    gravity: real


@wp.struct
class Margin:
    """Distances from events, at one end of a step.

    Attributes:
        theta, omega: Rotation [rad] and its rate [rad/s].
        gap, rise: Gap of the lower corner [m] and its rate [m/s].
        along: Velocity of that corner along the base [m/s].
        reserve: `hold_reserve` [m/s^2].
    """

    theta: real
    omega: real
    gap: real
    rise: real
    along: real
    reserve: real


@wp.func
def look_ahead(block: Block, m: Motion, ground: Ground, end: real, s: State) -> real:
    """Longest step of a block at rest [s], up to where the base lets it go (event/lift.py)."""
    d = smaller(block.longest_step, smaller(knot_time(m, s.segment), end) - s.time)
    a = expand(m, s.segment, s.time, ground.value, ground.slope)
    last = acceleration_at(a, d)
    way = -sign_of(wp.where(size(last) > size(a.a0), last, a.a0))
    hold = block.hold_acceleration
    lack = Acceleration(
        fused(way, a.a0, hold), way * a.a1, way * a.a2, way * a.a3, way * a.a4, way * a.a5,
        way * a.a6, way * a.a7, way * a.a8,
    )  # fmt: skip
    return held_time(lack, hold, round_off(lack, hold, s.time), d)


@wp.func
def find_event(
    block: Block, contact: Contact, start: Margin, end: Margin, holds: bool, reach: real, d: real,
    near: real,
):  # fmt: skip
    """Whether an event lies inside a step, and the length of the step that ends there.

    Args:
        block: The block.
        contact: Its mode in the step, and the direction in which it slides at the start.
        start, end: Distances from events at both ends of the step.
        holds: Whether the force at the start surely holds a corner that the block turns about.
        reach: Tolerance of the speed at a stop [m/s].
        d: Length of the step [s].
        near: Tolerance of the time of an event [s].
    """
    zero = real(0.0)
    per, slip, grain = real(1.0) / d, contact.slip, GRAIN * block.half_height
    past = end.theta > fused(near, size(end.omega), HALF_PI)
    below = end.theta < -near * size(end.omega)
    sinks = contact.mode == FLYING and end.gap < fused_less(near, size(end.rise), -grain)
    stops = slip * start.along > zero and slip * end.along < -reach
    lifts = holds and end.reserve < -SOON * start.reserve and d > near
    e0 = wp.where(stops, slip * start.along, start.reserve)
    e1 = wp.where(stops, slip * end.along, end.reserve)
    slope = (e1 - e0) * per
    e0 = wp.where(sinks, start.gap, e0)
    e1 = wp.where(sinks, end.gap, e1)
    slope = wp.where(sinks, start.rise, slope)
    e0 = wp.where(below, start.theta, e0)
    e1 = wp.where(below, end.theta, e1)
    slope = wp.where(below, start.omega, slope)
    e0 = wp.where(past, HALF_PI - start.theta, e0)
    e1 = wp.where(past, HALF_PI - end.theta, e1)
    slope = wp.where(past, -start.omega, slope)
    # Not shorter than `near`: an event nearer than that counts as reached.
    least = wp.where(past or below or sinks or stops, HALF * near, larger(LEAST * d, HALF * near))
    cut = larger(first_root(e0, slope, e1, d), least)
    return past or below or sinks or stops or lifts, cut


@wp.func
def hold_at_end(
    block: Block, contact: Contact, slip: real, along: real, d: real, near: real, theta: real,
    free: Velocity,
):  # fmt: skip
    """Velocity at the end of a step, projected on the contact; sliding that has reversed ends.

    Args:
        block: The block.
        contact: How it touches its base in the step.
        slip: Direction of sliding at the start.
        along: Velocity of the corner along the base at the start [m/s].
        d: Length of the step [s].
        near: Tolerance of the time of an event [s].
        theta: Rotation at the end [rad].
        free: Velocity at the end before the projection.

    Returns:
        Velocity, direction of sliding, tolerance of the speed at a stop [m/s].
    """
    zero, per, idle = real(0.0), real(1.0) / d, d <= real(0.0)
    at = lower_corner(block, theta)
    # Before the projection, which would hide how far a block overshot that friction nearly jams.
    along1 = fused(free.omega, at.z, free.x)
    reach = near * size(along1 - along) * per
    turned = contact.slip * along1 <= wp.where(slip * along > zero, reach, zero)
    slides = wp.where(turned and not idle, zero, contact.slip)
    v = held_velocity(block, Contact(contact.mode, slides), theta, free)
    # Sliding also ends where its own friction reversed it in the projection.
    slides = wp.where(slides * fused(v.omega, at.z, v.x) <= zero and not idle, zero, slides)
    # The force of a corner that sticks has no moment about it.
    moment = fused(at.x, free.z, fused_less(at.z, free.x, block.inertia * free.omega))
    turn = block.inverse_pivot_inertia * moment
    sticks = contact.mode == PIVOTING and slides == zero
    held = Velocity(
        wp.where(sticks, -turn * at.z, v.x), wp.where(sticks, turn * at.x, v.z),
        wp.where(sticks, turn, v.omega),
    )  # fmt: skip
    return held, slides, reach


@wp.func
def integrate(
    block: Block, gravity: real, near: real, s: State, span: Span, slid: real, curve: Curve
):
    """The step up to its end, before an impact there.

    Args:
        block: The block, which leans to +x.
        gravity: [m/s^2].
        near: Tolerance of the time of an event [s].
        s: State at the start.
        span: The step.
        slid: Distance that a block slides flat [m], else 0.
        curve: The rotation if the corner sticks.

    Returns:
        The end of the step; the event at it or inside; the rotation that the step follows.
    """
    zero = real(0.0)
    d, idle = span.d, span.d <= zero
    before = Velocity(s.vx, s.vz, s.omega)
    at0 = lower_corner(block, s.theta)
    reserve, surely = hold_reserve(block, gravity, s.slip, at0, s.omega, span.a0)
    mean, held, lost = step_velocity(
        block, Contact(s.mode, s.slip), surely, s.theta, before, span.dv, d, d * gravity
    )
    sticks = surely and s.slip == zero and held.slip == zero and d > zero and held.mode == PIVOTING
    # A block at rest that lifts leans at the end of the step, and ever more.
    leans = value_after(curve, d) > zero and rate_after(curve, d) > zero
    rocks = sticks and (s.mode == PIVOTING or leans)
    bend = wp.where(d > zero, (mean.omega - s.omega) / d, zero)
    path = Curve(
        s.theta, s.omega, wp.where(rocks, curve.c2, bend), wp.where(rocks, curve.c3, zero),
        wp.where(rocks, curve.c4, zero), wp.where(rocks, curve.c5, zero),
        wp.where(rocks, curve.c6, zero),
    )  # fmt: skip
    theta = value_after(path, d)
    at1 = lower_corner(block, theta)
    omega = rate_after(path, d)
    free = Velocity(
        wp.where(rocks, -omega * at1.z, fused(TWO, mean.x, -s.vx)),
        wp.where(rocks, omega * at1.x, fused(TWO, mean.z, -s.vz)), omega,
    )  # fmt: skip
    along = fused(s.omega, at0.z, s.vx)
    v, slip, reach = hold_at_end(block, held, s.slip, along, d, near, theta, free)
    moves = held.mode == FLYING or (held.slip != zero and (s.slip != zero or slip != zero))
    glides = slid > zero and held.mode == FLAT
    moved = wp.where(moves, fused(d, mean.x, at1.x - at0.x), zero)
    glide = wp.where(glides, slid, moved)
    lost = wp.where(glides, block.friction * gravity * slid, wp.where(rocks, zero, lost))
    flying = held.mode == FLYING
    raw_gap = wp.where(rocks, zero, fused(d, mean.z, s.gap) + (at1.z - at0.z))
    gap = wp.where(s.mode != FLYING, larger(raw_gap, zero), raw_gap)
    gap = wp.where(flying, gap, zero)
    rise = fused_less(v.omega, at1.x, v.z)
    reserve1, _surely = hold_reserve(block, gravity, s.slip, at1, v.omega, span.a1)
    holds = surely and (s.mode == PIVOTING or held.mode == PIVOTING)
    start = Margin(s.theta, s.omega, s.gap, fused_less(s.omega, at0.x, s.vz), along, reserve)
    last = Margin(theta, v.omega, gap, rise, fused(omega, at1.z, free.x), reserve1)
    missed, cut = find_event(block, Contact(held.mode, s.slip), start, last, holds, reach, d, near)
    falls = held.mode != FLAT and v.omega < zero and theta <= -near * v.omega
    grain = GRAIN * block.half_height
    lands = flying and rise < zero and gap <= fused_less(near, rise, grain)
    deep = larger(-raw_gap, fused(real(-2.0) * block.half_width, sine(theta), -raw_gap))
    end = End(theta, glide, gap, v.x, v.z, v.omega, held.mode, slip, lost, deep)
    return end, Event(missed and not idle, cut, falls, lands), path


@wp.func
def step(block: Block, knobs: Knobs, m: Motion, ground: Ground, end: real, going: bool, s: State):
    """One trial step of one lane, at most to its next knot or to `end`.

    Returns:
        The state after it, unchanged but for `cap` where an event lay inside; what the step adds to
        the response; the rotation that it followed.
    """
    zero = real(0.0)
    live = s.mode < OVERTURNED and going
    near = larger(NEARLY * block.longest_step, TICK * s.time)
    span, curve, side, slid = begin_step(block, knobs.gravity, m, ground, end, live, s)
    # Reflected where the block leans to -x.
    own = State(
        side * s.theta, s.slide, s.gap, side * s.vx, s.vz, side * s.omega, side * s.slip, s.mode,
        s.time, s.segment, s.base, s.cap,
    )  # fmt: skip
    moved = Span(
        span.d, span.time, span.passed, side * span.a0, side * span.a1, side * span.dv,
        side * span.kick,
    )  # fmt: skip
    last, event, path = integrate(block, knobs.gravity, near, own, moved, slid, curve)
    after = end_step(block, knobs.gravity, event.falls, event.lands, moved, last)
    over = last.theta >= fused_less(near, last.omega, HALF_PI)
    theta = wp.where(event.falls or last.mode == FLAT, zero, wp.where(over, HALF_PI, last.theta))
    sound = theta - theta == zero and after.omega - after.omega == zero
    sound = sound and after.vx - after.vx == zero and after.vz - after.vz == zero
    area = block.half_width * block.half_height
    sound = sound and span.time - span.time == zero and area - area == zero
    mode = wp.where(sound, wp.where(over, OVERTURNED, after.mode), BROKEN)
    taken = live and not (event.missed and sound)
    turns = taken and own.omega > zero and last.omega < zero
    apex, rise = turning_point(path, span.d, last.omega)
    face = side * after.turn
    new = State(
        wp.where(taken, face * theta, s.theta),
        wp.where(taken, fused(side, last.glide, s.slide), s.slide),
        wp.where(taken, wp.where(event.lands, zero, last.gap), s.gap),
        wp.where(taken, face * after.vx, s.vx), wp.where(taken, after.vz, s.vz),
        wp.where(taken, face * after.omega, s.omega), wp.where(taken, face * after.slip, s.slip),
        wp.where(taken, mode, s.mode), wp.where(taken, span.time, s.time),
        s.segment + wp.where(taken and span.passed, 1, 0),
        wp.where(taken, s.base + span.dv + span.kick, s.base),
        wp.where(taken, NEVER, wp.where(live, event.cut, s.cap)),
    )  # fmt: skip
    shown = Shown(
        taken, taken and after.hit, wp.where(turns, apex, zero),
        s.time + wp.where(turns, rise, zero), wp.where(taken, last.lost + after.lost, zero),
        wp.where(taken, after.tail, zero), wp.where(taken, last.deep, zero),
    )  # fmt: skip
    return new, shown, mirror_curve(side, path)
