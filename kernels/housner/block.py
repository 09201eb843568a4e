"""Housner's rocking block by Taylor series, event by event.

With alpha the slenderness angle, s = sign(theta), phi = theta - s alpha, p^2 = 3 g / (4 R) and
q = p^2 / g = 3 / (4 R), the block obeys between two events (Housner 1963, Eq. 1)

    theta'' = p^2 sin(phi) - q a(t) cos(phi),

and since sin and cos of phi obey S' = theta' C, C' = -theta' S, every Taylor coefficient of
theta follows from lower ones (Leibniz's rule). A step is one expansion of degree 10. It ends at
the first of: its full length, a knot of the motion, a turning point (theta' = 0), an impact
(theta = 0); at rest a turning point of a(t) or the uplift |a| = g tan(alpha). So theta (at rest
a) is monotone inside each step, no event can hide in it, and every event is a root of a
polynomial, found to round-off.

Under a record, at whose samples steps end, a step may contain a turning point if |theta| is concave
on the whole step and stays below the peak so far: such a curve has at most one zero behind its
start, and its top changes no peak. A third of the steps with events were those up to the tops of
hops shorter than a sample.

At an impact theta' becomes eta theta' and s changes sign. At a velocity step dv of the base
theta' changes by -q cos(alpha - |theta|) dv, and a block at rest lifts with -q cos(alpha) dv.

Rest rule: after an impact the block rests if, under the acceleration of that moment, its next
swing would stay below `rest_rotation` on either side. The infinitely many impacts that it leaves
out would take 2 theta' (1/r + eta/r') / (1 - eta^2), with the decelerations r on the side that it
leaves for and r' on the other; that time is added to the rest time.

Measured: packed, in float64, under the modulated waveform it runs at 0.96 of the speed that it had
with one argument a number. An `and` branches around its second operand; one with arithmetic or a
field in it is read before, since packed lanes keep masks for every branch.
"""

import warp as wp

from warprock.kernels.housner.block_contact import needed_at_step, needed_in_step, rocking_series
from warprock.kernels.housner.block_found import Seen
from warprock.kernels.lane.modes import BROKEN, OVERTURNED, RESTING, ROCKING, STALLED
from warprock.kernels.motion.kinds import (
    Acceleration,
    Ground,
    Motion,
    acceleration_at,
    expand,
    knot_step,
    knot_time,
)
from warprock.kernels.shape.taylor import Polynomial, root, scale, slope_at, value_at

NEARLY = by_precision(1.0e-9, 1.0e-5)
"""What counts as round-off of an event that the last step has located."""
ROUND_OFF = by_precision(1.0e-12, 1.0e-6)
"""A block may rest up to this relative excess of |a| over g tan(alpha), and lifts at twice it."""
TICK = by_precision(4.4e-16, 2.4e-7)
"""Two roundings of a time, relative: an event nearer to a knot is at the knot."""
COARSE = PRECISION == "float32"
"""Whether the round-off of a time matters beside ROUND_OFF."""
GRAIN = by_precision(0.0, 4.8e-7)
"""Relative error of a time, up to four roundings, where it matters."""
TURNS = MOTION == "record"
"""Whether a block may turn inside a step."""
REACH = real(0.25)
"""Largest rotation of the block in one step [rad]; keeps fast overturning inside the series."""


@wp.struct
class Block:
    """What a step needs to know of one lane's block."""

    slenderness_angle: real
    frequency_squared: real
    coupling: real
    uplift_acceleration: real
    angular_restitution: real
    impact_friction: real
    fall_angle: real
    rest_rotation: real
    step_length: real
    step_limit: int


@wp.struct
class State:
    """State of a lane.

    Attributes:
        theta: Rotation [rad].
        omega: Its rate [rad/s].
        side: The side that the block leans to or last left for, -1 or 1.
        time: Time [s].
        segment: Knots of the motion that are passed.
        mode: RESTING, ROCKING, or how the lane ended.
        cap: Longest step allowed next time [s].
        needed: Friction that the block has needed so far (head of housner/block_contact.py), which
            changes nothing of its motion.
    """

    theta: real
    omega: real
    side: real
    time: real
    segment: int
    mode: int
    cap: real
    needed: real


@wp.struct
class Event:
    """What ends a step.

    Attributes:
        tau: Length of the step [s].
        turned: Whether it ends at a turning point of the watched quantity.
        crossed: Whether it ends where that crosses zero.
        cap: Longest step allowed next time [s].
    """

    tau: real
    turned: bool
    crossed: bool
    cap: real


@wp.func
def start_lane(theta: real, omega: real):
    """Releases a block at a rotation [rad] with a rate [rad/s]: its state, what is seen of it."""
    zero = real(0.0)
    rests = theta == zero and omega == zero
    side = sign_of(wp.where(theta == zero, omega, theta))
    mode = wp.where(rests, RESTING, ROCKING)
    lifted, rested = wp.where(rests, NEVER, zero), wp.where(rests, zero, NEVER)
    state = State(theta, omega, side, zero, 0, mode, NEVER, zero)
    return state, Seen(size(theta), zero, lifted, rested, zero, 0, 0)


@wp.func
def may_rest(block: Block, omega: real, acceleration: real):
    """Whether the block rests after an impact, and the time of the impacts that are left out.

    One that an impact leaves no rate rests, if only until the base lifts it.
    """
    eta = block.angular_restitution
    gravity_part = block.frequency_squared * sine(block.slenderness_angle)
    motion_part = block.coupling * acceleration * cosine(block.slenderness_angle)
    weaker = fused(gravity_part, real(1.0) + ROUND_OFF, -size(motion_part))
    slow = omega * omega <= real(2.0) * weaker * block.rest_rotation
    rests = (weaker > real(0.0) and slow) or omega == real(0.0)
    here = fused(sign_of(omega), motion_part, gravity_part)
    there = fused_less(sign_of(omega), motion_part, gravity_part)
    lost = larger(fused_less(eta, eta, real(1.0)), real(1.0e-6))
    tail = real(2.0) * size(omega) * (real(1.0) / here + eta / there) / lost
    return rests, tail


@wp.func
def pick(turns: bool, zeros: int, slope: real, e: real, once: real, twice: real, thrice: real):
    """Coefficient of the derivative, or of a quantity over time to the power of its zeros."""
    low = wp.where(zeros == 0, e, once)
    high = wp.where(zeros == 2, twice, thrice)
    return wp.where(turns, slope, wp.where(zeros < 2, low, high))


@wp.func
def tops_below(bound: real, p: Polynomial, h: real) -> bool:
    """Whether a polynomial is surely concave on a whole step and stays below a bound.

    With p'' <= bend < 0 it is nowhere above the parabola c0 + c1 t + bend t^2 / 2.
    """
    high = fused(h, real(90.0) * size(p.c10), real(72.0) * size(p.c9))
    high = fused(h, fused(h, high, real(56.0) * size(p.c8)), real(42.0) * size(p.c7))
    high = fused(h, fused(h, high, real(30.0) * size(p.c6)), real(20.0) * size(p.c5))
    high = fused(h, high, real(12.0) * size(p.c4))
    bend = fused(h * h, high, real(2.0) * larger(p.c2, fused(real(3.0) * h, p.c3, p.c2)))
    return p.c1 * p.c1 < real(-2.0) * bend * (bound - p.c0)


@wp.func
def next_event(p: Polynomial, h: real, passes: bool) -> Event:
    """First turning point or zero of a watched quantity within a step of length h.

    Where the quantity crosses zero and turns back in one step, nothing happens yet: the caller
    repeats the step up to that point, before which lies the crossing alone; none where it `passes`.
    """
    zero = real(0.0)
    p_end = value_at(p, h)
    d_end = slope_at(p, h)
    # One in the first or last NEARLY of the step is one that a step ends at.
    turns = p.c1 * d_end < -NEARLY * fused(d_end, d_end, p.c1 * p.c1) and not passes
    crosses = p_end < zero and not turns
    # A block on the ground has a zero there already; at rest a double one; one that has just
    # lifted where |a| passed its limit a triple one. They are divided out.
    zeros = wp.where(p.c0 == zero, wp.where(p.c1 == zero, 2, 1), 0)
    flat = size(p.c2) < NEARLY * size(p.c3) * h
    zeros = wp.where(zeros == 2 and flat, 3, zeros)
    over_h = real(1.0) / h
    at_end = pick(
        turns, zeros, d_end, p_end, p_end * over_h, p_end * over_h * over_h,
        p_end * over_h * over_h * over_h,
    )  # fmt: skip
    g = Polynomial(
        pick(turns, zeros, p.c1, p.c0, p.c1, p.c2, p.c3),
        pick(turns, zeros, real(2.0) * p.c2, p.c1, p.c2, p.c3, p.c4),
        pick(turns, zeros, real(3.0) * p.c3, p.c2, p.c3, p.c4, p.c5),
        pick(turns, zeros, real(4.0) * p.c4, p.c3, p.c4, p.c5, p.c6),
        pick(turns, zeros, real(5.0) * p.c5, p.c4, p.c5, p.c6, p.c7),
        pick(turns, zeros, real(6.0) * p.c6, p.c5, p.c6, p.c7, p.c8),
        pick(turns, zeros, real(7.0) * p.c7, p.c6, p.c7, p.c8, p.c9),
        pick(turns, zeros, real(8.0) * p.c8, p.c7, p.c8, p.c9, p.c10),
        pick(turns, zeros, real(9.0) * p.c9, p.c8, p.c9, p.c10, zero),
        pick(turns, zeros, real(10.0) * p.c10, p.c9, p.c10, zero, zero),
        pick(turns, zeros, zero, p.c10, zero, zero, zero),
    )
    at_root, exact, low, high = root(g, h, at_end)
    # Pressed down on its side, a block without velocity crosses at once.
    pressed = crosses and g.c0 <= zero
    at_root = wp.where(pressed, zero, at_root)
    exact = exact or pressed
    # Towards a root that is not yet exact the step goes as far as is safe; the next one finds it
    # in a narrower bracket.
    event = turns or crosses
    tau = wp.where(event, wp.where(exact, at_root, low), h)
    sinks = value_at(p, tau) < zero
    dips = turns and exact and sinks
    return Event(
        wp.where(dips, zero, tau),
        turns and exact and not dips,
        crosses and exact,
        wp.where(dips, tau, wp.where(event and not exact, high - low, NEVER)),
    )


@wp.func
def stronger_pull(a: Acceleration, h: real) -> real:
    """Sign of the stronger acceleration of the base at the two ends of a step of length h."""
    a_end = acceleration_at(a, h)
    return sign_of(wp.where(size(a_end) > size(a.a0), a_end, a.a0))


@wp.func
def first_event(
    block: Block, s: State, rotation: Polynomial, a: Acceleration, pull: real, h: real, peak: real,
) -> Event:  # fmt: skip
    """First event of a block within a step of length h.

    Watched is the lean while rocking, and what |a| lacks to uplift while at rest. `pull` is the
    sign of the acceleration that may lift the block, `peak` that of |theta| so far, below which
    it may turn.
    """
    zero = real(0.0)
    resting, rocking = s.mode == RESTING, s.mode == ROCKING
    limit = block.uplift_acceleration * (real(1.0) + real(2.0) * ROUND_OFF)
    side = s.side
    # One coefficient after the other: two whole polynomials would take registers that packed lanes
    # lack.
    watched = Polynomial(
        wp.where(resting, fused_less(pull, a.a0, limit), side * rotation.c0),
        wp.where(resting, -pull * a.a1, side * rotation.c1),
        wp.where(resting, -pull * a.a2, side * rotation.c2),
        wp.where(resting, -pull * a.a3, side * rotation.c3),
        wp.where(resting, -pull * a.a4, side * rotation.c4),
        wp.where(resting, -pull * a.a5, side * rotation.c5),
        wp.where(resting, -pull * a.a6, side * rotation.c6),
        wp.where(resting, -pull * a.a7, side * rotation.c7),
        wp.where(resting, -pull * a.a8, side * rotation.c8),
        wp.where(resting, zero, side * rotation.c9),
        wp.where(resting, zero, side * rotation.c10),
    )
    passes = bool(False)
    if TURNS:
        lean = scale(side, rotation)
        passes = rocking and lean.c0 >= zero and tops_below(peak, lean, h)
    elif COARSE:
        # A crest of the base nearer than times resolve is at hand: a step to it would not end.
        near = size(watched.c1) <= size(watched.c2) * (TWO * GRAIN * s.time)
        passes = resting and near
    event = next_event(watched, h, passes)
    # A jump of the acceleration lifts a resting block, round-off sinks a rocking one: at once.
    lack_at_end = fused_less(pull, acceleration_at(a, h), limit)
    jumps, grows = watched.c0 < -NEARLY * limit, lack_at_end < zero
    lifts = jumps or (watched.c0 <= zero and grows)
    sunk = watched.c0 < zero
    at_once = (rocking and sunk) or (resting and lifts)
    return Event(
        wp.where(at_once, zero, event.tau),
        event.turned and not at_once,
        event.crossed or at_once,
        wp.where(at_once, NEVER, event.cap),
    )


@wp.func
def rebound(block: Block, omega: real) -> real:
    """Angular velocity after an impact [rad/s]: the law of impact, Housner's or prescribed."""
    return block.angular_restitution * omega


@wp.func
def apply_event(
    block: Block, impact: bool, uplift: bool, pull: real, acceleration: real, s: wp.ref[State],
    seen: wp.ref[Seen],
):  # fmt: skip
    """Changes what an impact or an uplift changes; `pull` is the sign of the acceleration."""
    zero = real(0.0)
    before = s.omega
    after = rebound(block, before)
    stays, tail = may_rest(block, after, acceleration)
    rests = stays and impact
    after = wp.where(rests, zero, after)
    s.omega = wp.where(impact, after, before)
    s.side = wp.where(impact, -s.side, wp.where(uplift, -pull, s.side))
    s.mode = wp.where(rests, RESTING, wp.where(uplift, ROCKING, s.mode))
    s.needed = wp.where(impact, larger(block.impact_friction, s.needed), s.needed)
    first = smaller(seen.uplift_time, s.time)
    seen.uplift_time = wp.where(uplift, first, seen.uplift_time)
    rested = wp.where(uplift, NEVER, seen.rest_time)
    seen.rest_time = wp.where(rests, s.time + tail, rested)
    seen.loss = seen.loss + wp.where(impact, fused_less(after, after, before * before), zero)
    seen.impacts = seen.impacts + wp.where(impact, 1, 0)


@wp.func
def pass_knot(block: Block, passed: bool, dv: real, s: wp.ref[State], seen: wp.ref[Seen]):
    """Passes a knot of the motion if it is reached, with a velocity step dv of the base."""
    zero = real(0.0)
    resting, rocking, upright = s.mode == RESTING, s.mode == ROCKING, s.theta == zero
    outwards = s.side * s.omega >= zero
    steps = passed and dv != zero
    kick = -block.coupling * cosine(block.slenderness_angle - size(s.theta)) * dv
    rests, _tail = may_rest(block, kick, zero)
    lifts = steps and resting and not rests
    rocks = steps and (rocking or lifts)
    falls = s.side * s.theta >= block.fall_angle and outwards
    omega = wp.where(rocks, s.omega + kick, s.omega)
    side = wp.where(steps and upright, sign_of(omega), s.side)
    asked = needed_at_step(size(s.theta), side, dv, block.slenderness_angle)
    more = asked > s.needed
    # A step that would leave a block at rest where it is needs no friction to speak of.
    counts = rocks and not rests and not falls and more
    s.omega = omega
    s.side = side
    s.segment = s.segment + wp.where(passed, 1, 0)
    s.mode = wp.where(lifts, ROCKING, s.mode)
    s.needed = wp.where(counts, asked, s.needed)
    first = smaller(seen.uplift_time, s.time)
    seen.uplift_time = wp.where(lifts, first, seen.uplift_time)
    seen.rest_time = wp.where(lifts, NEVER, seen.rest_time)


@wp.func
def reject_overshoot(live: bool, rocking: bool, theta: real, omega: real, tau: real, cap: real):
    """Whether a block falls past pi/2 in a step: it repeats it up to there (Newton's method).

    Returns:
        That, the length of the step (0 if it is repeated), the longest step allowed next time.
    """
    excess = size(theta) - HALF_PI
    past = rocking and excess > NEARLY
    return (
        past,
        wp.where(past or not live, real(0.0), tau),
        wp.where(past, larger(tau - excess / size(omega), real(0.5) * tau), cap),
    )


@wp.func
def end_step(mode: int, theta: real, omega: real, time: real):
    """Mode and rotation at the end of a step: the block may have overturned, or be BROKEN."""
    zero = real(0.0)
    sound = theta - theta == zero and omega - omega == zero and time - time == zero
    over = mode == ROCKING and size(theta) >= HALF_PI
    ended = wp.where(sound, wp.where(over, OVERTURNED, mode), BROKEN)
    return ended, wp.where(over, HALF_PI * sign_of(theta), theta)


@wp.func
def observe(theta: real, time: real, seen: wp.ref[Seen]):
    """Sees a step end at a rotation and a time."""
    higher = size(theta) > seen.peak
    seen.peak = wp.where(higher, size(theta), seen.peak)
    seen.peak_time = wp.where(higher, time, seen.peak_time)
    seen.steps = seen.steps + 1


@wp.func
def stall(mode: int, steps: int, step_limit: int) -> int:
    """Mode of a lane: STALLED if it still runs after all the steps that it may take."""
    return wp.where(steps >= step_limit and mode < OVERTURNED, STALLED, mode)


@wp.func
def needed_at_rest(block: Block, rests: bool, a0: real, a1: real, needed: real) -> real:
    """The larger of a friction and |a| / g of a step at rest, in which a goes from a0 to a1.

    It is monotone there. A step without length, of a jump that lifts, is none at rest.
    """
    # g is p^2 / q.
    asked = larger(size(a0), size(a1)) * block.coupling / block.frequency_squared
    return wp.where(rests, larger(asked, needed), needed)


@wp.func
def step(block: Block, m: Motion, ground: Ground, until: real, s: State, seen: Seen):
    """One step of one lane, to its next event or at most to `until`: its state, what is seen."""
    knot, zero = knot_time(m, s.segment), real(0.0)
    live, resting, rocking = s.mode < OVERTURNED, s.mode == RESTING, s.mode == ROCKING
    target = smaller(knot, until)
    room = target - s.time
    h = smaller(smaller(smaller(block.step_length, REACH / size(s.omega)), room), s.cap)
    h = wp.where(live, larger(h, zero), zero)

    # Expansion about the present time.
    a = expand(m, s.segment, s.time, ground.value, ground.slope)
    rotation, force = rocking_series(
        block.frequency_squared, block.coupling, s.side * block.slenderness_angle, s.theta,
        s.omega, a,
    )  # fmt: skip
    pull = stronger_pull(a, h)
    event = first_event(block, s, rotation, a, pull, h, seen.peak)
    turned, crossed = event.turned, event.crossed
    theta = value_at(rotation, event.tau)
    omega = slope_at(rotation, event.tau)
    past, tau, cap = reject_overshoot(live, rocking, theta, omega, event.tau, event.cap)
    uplift, impact = resting and crossed, rocking and crossed and not past
    needed = needed_in_step(
        s.needed, rocking, block.fall_angle, s.side * s.theta, s.side * s.omega, s.side * omega,
        tau, force,
    )  # fmt: skip

    # The state there; a turning point, an impact, an uplift.
    theta = wp.where(impact or uplift, zero, wp.where(rocking and not past, theta, s.theta))
    omega = wp.where(past, s.omega, wp.where(rocking and not turned, omega, zero))
    arrives = tau >= fused_less(TICK, target, room)
    time = wp.where(live and arrives, target, s.time + tau)
    a_now = acceleration_at(a, tau)
    needed = needed_at_rest(block, resting and tau > zero, a.a0, a_now, needed)
    n = State(theta, omega, s.side, time, s.segment, s.mode, cap, needed)
    o = seen
    apply_event(block, impact, uplift, pull, a_now, n, o)
    pass_knot(block, time >= knot and live, knot_step(m, s.segment), n, o)
    mode, rests_at = end_step(n.mode, n.theta, n.omega, n.time)
    n.theta = rests_at
    observe(n.theta, n.time, o)
    n.mode = stall(mode, o.steps, block.step_limit)
    return n, o
