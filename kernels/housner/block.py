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

Under a record, at whose samples steps end, a step may go on behind a turning point where |theta|
surely bends downwards all along it and stays below its peak so far: such a curve has one zero at
most behind its start, and its top tells nothing new. A third of the steps with events were those
up to the tops of hops shorter than a sample.

At an impact theta' becomes eta theta' and s changes sign. At a velocity step dv of the base
theta' changes by -q cos(alpha - |theta|) dv, and a block at rest lifts with -q cos(alpha) dv.

A lane's state: theta [rad], omega = theta' [rad/s], side that it leans to or last left for (-1 or
1), time [s], segment (knots of the motion passed), mode (RESTING, ...), peak of |theta| [rad] and
its time [s], time of the first uplift [s], time since when it rests [s] (both NEVER before),
loss = sum of omega^2 (1 - eta^2) over the impacts [rad^2/s^2], impacts, cap, the longest step
allowed next time [s], and needed, the friction that the block has needed so far (head of
housner/block_contact.py), which changes nothing of its motion.

Rest rule: after an impact the block rests if, under the acceleration of that moment, its next
swing would stay below `rest_rotation` on either side. The infinitely many impacts that it leaves
out would take 2 theta' (1/r + eta/r') / (1 - eta^2), with the decelerations r on the side that it
leaves for and r' on the other; that time is added to the rest time.
"""

import warp as wp

from warprock.kernels.housner.block_contact import needed_at_step, needed_in_step, rocking_series
from warprock.kernels.modes import BROKEN, OVERTURNED, RESTING, ROCKING
from warprock.kernels.motion import Motion, acceleration_after, knot_step, knot_time, series
from warprock.kernels.shape.taylor import root, slope_at, value_at

NEARLY = by_precision(1.0e-9, 1.0e-5)
"""What counts as round-off of an event that the last step has located."""
ROUND_OFF = by_precision(1.0e-12, 1.0e-6)
"""A block may rest up to this relative excess of |a| over g tan(alpha), and lifts at twice it."""
TICK = by_precision(4.4e-16, 2.4e-7)
"""Two roundings of a time, relative: an event nearer to a knot is at the knot."""
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


@wp.func
def may_rest(block: Block, omega: real, acceleration: real):
    """Whether the block rests after an impact, and the time of the impacts that are left out."""
    eta = block.angular_restitution
    gravity_part = block.frequency_squared * sine(block.slenderness_angle)
    motion_part = block.coupling * acceleration * cosine(block.slenderness_angle)
    weaker = fused(gravity_part, real(1.0) + ROUND_OFF, -size(motion_part))
    rests = weaker > real(0.0) and omega * omega <= real(2.0) * weaker * block.rest_rotation
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
def tops_below(
    bound: real, e0: real, e1: real, e2: real, e3: real, e4: real, e5: real,
    e6: real, e7: real, e8: real, e9: real, e10: real, h: real,
) -> bool:  # fmt: skip
    """Whether a polynomial surely bends downwards all along a step and stays below a bound.

    With e'' <= bend < 0 it is nowhere above the parabola e0 + e1 t + bend t^2 / 2.
    """
    high = fused(h, real(90.0) * size(e10), real(72.0) * size(e9))
    high = fused(h, fused(h, high, real(56.0) * size(e8)), real(42.0) * size(e7))
    high = fused(h, fused(h, high, real(30.0) * size(e6)), real(20.0) * size(e5))
    high = fused(h, high, real(12.0) * size(e4))
    bend = fused(h * h, high, real(2.0) * larger(e2, fused(real(3.0) * h, e3, e2)))
    return e1 * e1 < real(-2.0) * bend * (bound - e0)


@wp.func
def next_event(
    e0: real, e1: real, e2: real, e3: real, e4: real, e5: real,
    e6: real, e7: real, e8: real, e9: real, e10: real, h: real, passes: bool,
):  # fmt: skip
    """First turning point or zero of a watched quantity within a step of length h.

    Where the quantity crosses zero and turns back in one step, nothing happens yet: the caller
    repeats the step up to that point, before which lies the crossing alone; none where it `passes`.

    Returns:
        Length of the step; whether it ends at a turning point; whether it ends at a crossing;
        the longest step allowed next time.
    """
    zero = real(0.0)
    e_end = value_at(e0, e1, e2, e3, e4, e5, e6, e7, e8, e9, e10, h)
    d_end = slope_at(e1, e2, e3, e4, e5, e6, e7, e8, e9, e10, h)
    # One in the first or last NEARLY of the step is one that a step ends at.
    turns = e1 * d_end < -NEARLY * fused(d_end, d_end, e1 * e1) and not passes
    crosses = e_end < zero and not turns
    # A block on the ground has a zero there already; at rest a double one; one that has just
    # lifted where |a| passed its limit a triple one. They are divided out.
    zeros = wp.where(e0 == zero, wp.where(e1 == zero, 2, 1), 0)
    zeros = wp.where(zeros == 2 and size(e2) < NEARLY * size(e3) * h, 3, zeros)
    over_h = real(1.0) / h
    g0 = pick(turns, zeros, e1, e0, e1, e2, e3)
    at_end = pick(
        turns, zeros, d_end, e_end, e_end * over_h, e_end * over_h * over_h,
        e_end * over_h * over_h * over_h,
    )  # fmt: skip
    at_root, exact, low, high = root(
        g0,
        pick(turns, zeros, real(2.0) * e2, e1, e2, e3, e4),
        pick(turns, zeros, real(3.0) * e3, e2, e3, e4, e5),
        pick(turns, zeros, real(4.0) * e4, e3, e4, e5, e6),
        pick(turns, zeros, real(5.0) * e5, e4, e5, e6, e7),
        pick(turns, zeros, real(6.0) * e6, e5, e6, e7, e8),
        pick(turns, zeros, real(7.0) * e7, e6, e7, e8, e9),
        pick(turns, zeros, real(8.0) * e8, e7, e8, e9, e10),
        pick(turns, zeros, real(9.0) * e9, e8, e9, e10, zero),
        pick(turns, zeros, real(10.0) * e10, e9, e10, zero, zero),
        pick(turns, zeros, zero, e10, zero, zero, zero),
        h,
        at_end,
    )
    # Pressed down on its side, a block without velocity crosses at once.
    pressed = crosses and g0 <= zero
    at_root = wp.where(pressed, zero, at_root)
    exact = exact or pressed
    # Towards a root that is not yet exact the step goes as far as is safe; the next one finds it
    # in a narrower bracket.
    event = turns or crosses
    tau = wp.where(event, wp.where(exact, at_root, low), h)
    at_turn = value_at(e0, e1, e2, e3, e4, e5, e6, e7, e8, e9, e10, tau)
    dips = turns and exact and at_turn < zero
    return (
        wp.where(dips, zero, tau),
        turns and exact and not dips,
        crosses and exact,
        wp.where(dips, tau, wp.where(event and not exact, high - low, NEVER)),
    )


@wp.func
def first_event(
    uplift: real, resting: bool, rocking: bool, side: real, theta: real, omega: real,
    t2: real, t3: real, t4: real, t5: real, t6: real, t7: real, t8: real, t9: real, t10: real,
    a0: real, a1: real, a2: real, a3: real, a4: real, a5: real, a6: real, a7: real, a8: real,
    h: real, peak: real,
):  # fmt: skip
    """First event of a block within a step of length h; `uplift` is its uplift acceleration.

    Watched is the lean while rocking, and what |a| lacks to uplift while at rest. `peak`: that of
    |theta| so far, below which a block may turn.

    Returns:
        As `next_event`, and the sign of the acceleration that may lift the block.
    """
    zero = real(0.0)
    limit = uplift * (real(1.0) + real(2.0) * ROUND_OFF)
    a_end = acceleration_after(a0, a1, a2, a3, a4, a5, a6, a7, a8, h)
    pull = sign_of(wp.where(size(a_end) > size(a0), a_end, a0))
    e0 = wp.where(resting, fused_less(pull, a0, limit), side * theta)
    passes = bool(False)
    if TURNS:
        lean = side * theta
        low = tops_below(
            peak, lean, side * omega, side * t2, side * t3, t4, t5, t6, t7, t8, t9, t10, h
        )
        passes = rocking and lean >= zero and low
    tau, turned, crossed, cap = next_event(
        e0,
        wp.where(resting, -pull * a1, side * omega),
        wp.where(resting, -pull * a2, side * t2),
        wp.where(resting, -pull * a3, side * t3),
        wp.where(resting, -pull * a4, side * t4),
        wp.where(resting, -pull * a5, side * t5),
        wp.where(resting, -pull * a6, side * t6),
        wp.where(resting, -pull * a7, side * t7),
        wp.where(resting, -pull * a8, side * t8),
        wp.where(resting, zero, side * t9),
        wp.where(resting, zero, side * t10),
        h,
        passes,
    )
    # A jump of the acceleration lifts a resting block, round-off sinks a rocking one: at once.
    lifts = e0 < -NEARLY * limit or (e0 <= zero and fused_less(pull, a_end, limit) < zero)
    at_once = (rocking and e0 < zero) or (resting and lifts)
    return (
        wp.where(at_once, zero, tau),
        turned and not at_once,
        crossed or at_once,
        wp.where(at_once, NEVER, cap),
        pull,
    )


@wp.func
def event_step(
    block: Block, impact: bool, uplift: bool, pull: real, acceleration: real, time: real,
    omega: real, side: real, mode: int, uplift_time: real, rest_time: real, loss: real,
    needed: real,
):  # fmt: skip
    """What an impact or an uplift does to a block; `pull` is the sign of the acceleration."""
    zero = real(0.0)
    after = block.angular_restitution * omega
    stays, tail = may_rest(block, after, acceleration)
    rests = stays and impact
    after = wp.where(rests, zero, after)
    return (
        wp.where(impact, after, omega),
        wp.where(impact, -side, wp.where(uplift, -pull, side)),
        wp.where(rests, RESTING, wp.where(uplift, ROCKING, mode)),
        wp.where(uplift, smaller(uplift_time, time), uplift_time),
        wp.where(rests, time + tail, wp.where(uplift, NEVER, rest_time)),
        loss + wp.where(impact, fused_less(after, after, omega * omega), zero),
        wp.where(impact, larger(block.impact_friction, needed), needed),
    )


@wp.func
def motion_step(
    block: Block, passed: bool, dv: real, time: real,
    theta: real, omega: real, side: real, mode: int, uplift_time: real, rest_time: real,
    needed: real,
):  # fmt: skip
    """What a velocity step dv of the base at a knot does to a block, if it is passed."""
    zero = real(0.0)
    steps = passed and dv != zero
    kick = -block.coupling * cosine(block.slenderness_angle - size(theta)) * dv
    rests, _tail = may_rest(block, kick, zero)
    lifts = steps and mode == RESTING and not rests
    omega1 = wp.where(steps and (mode == ROCKING or lifts), omega + kick, omega)
    side1 = wp.where(steps and theta == zero, sign_of(omega1), side)
    # A step that would leave a block at rest where it is needs no friction to speak of.
    counts = steps and (mode == ROCKING or lifts) and not rests
    falls = side * theta >= block.fall_angle and side * omega >= zero
    asked = needed_at_step(size(theta), side1, dv, block.slenderness_angle)
    return (
        omega1,
        side1,
        wp.where(lifts, ROCKING, mode),
        wp.where(lifts, smaller(uplift_time, time), uplift_time),
        wp.where(lifts, NEVER, rest_time),
        wp.where(counts and not falls and asked > needed, asked, needed),
    )


@wp.func
def overshot(live: bool, rocking: bool, theta: real, omega: real, tau: real, cap: real):
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
def end_of_step(
    mode: int, theta: real, omega: real, time: real, peak: real, peak_time: real,
):  # fmt: skip
    """Peak, overturning and trouble at the end of a step: mode, theta, peak, peak_time."""
    zero = real(0.0)
    sound = theta - theta == zero and omega - omega == zero and time - time == zero
    over = mode == ROCKING and size(theta) >= HALF_PI
    theta1 = wp.where(over, HALF_PI * sign_of(theta), theta)
    higher = size(theta1) > peak
    return (
        wp.where(sound, wp.where(over, OVERTURNED, mode), BROKEN),
        theta1,
        wp.where(higher, size(theta1), peak),
        wp.where(higher, time, peak_time),
    )


@wp.func
def needed_at_rest(block: Block, rests: bool, a0: real, a1: real, needed: real) -> real:
    """The larger of a friction and |a| / g of a step at rest, in which a goes from a0 to a1.

    It is monotone there. A step without length, of a jump that lifts, is none at rest.
    """
    # g is p^2 / q.
    asked = larger(size(a0), size(a1)) * block.coupling / block.frequency_squared
    return wp.where(rests, larger(asked, needed), needed)


@wp.func
def step(
    block: Block, m: Motion, sample: real, sample_slope: real, until: real,
    theta: real, omega: real, side: real, time: real, segment: int, mode: int,
    peak: real, peak_time: real, uplift_time: real, rest_time: real, loss: real, impacts: int,
    cap: real, needed: real,
):  # fmt: skip
    """One step of one lane, to its next event or at most to `until`.

    The arguments from `theta` on are the lane's state, see the head of this file; the step
    returns it in the same order. `sample` and `sample_slope` belong to a record's segment.
    """
    knot, zero = knot_time(m, segment), real(0.0)
    live, resting, rocking = mode < OVERTURNED, mode == RESTING, mode == ROCKING
    target = smaller(knot, until)
    room = target - time
    h = smaller(smaller(smaller(block.step_length, REACH / size(omega)), room), cap)
    h = wp.where(live, larger(h, zero), zero)

    # Expansion about the present time.
    a0, a1, a2, a3, a4, a5, a6, a7, a8 = series(m, segment, time, sample, sample_slope)
    (
        t2, t3, t4, t5, t6, t7, t8, t9, t10,
        n0, n1, n2, n3, n4, n5, n6, f0, f1, f2, f3, f4, f5, f6,
    ) = rocking_series(
        block.frequency_squared, block.coupling, theta - side * block.slenderness_angle, omega,
        a0, a1, a2, a3, a4, a5, a6, a7, a8,
    )  # fmt: skip
    tau, turned, crossed, cap1, pull = first_event(
        block.uplift_acceleration, resting, rocking, side, theta, omega,
        t2, t3, t4, t5, t6, t7, t8, t9, t10, a0, a1, a2, a3, a4, a5, a6, a7, a8, h, peak,
    )  # fmt: skip
    theta1 = value_at(theta, omega, t2, t3, t4, t5, t6, t7, t8, t9, t10, tau)
    omega1 = slope_at(omega, t2, t3, t4, t5, t6, t7, t8, t9, t10, tau)
    past, tau, cap1 = overshot(live, rocking, theta1, omega1, tau, cap1)
    uplift, impact = resting and crossed, rocking and crossed and not past
    needed1 = needed_in_step(
        needed, rocking, block.fall_angle, side * theta, side * omega, side * omega1, tau,
        n0, n1, n2, n3, n4, n5, n6, f0, f1, f2, f3, f4, f5, f6,
    )  # fmt: skip

    # The state there; a turning point, an impact, an uplift.
    theta1 = wp.where(impact or uplift, zero, wp.where(rocking and not past, theta1, theta))
    omega1 = wp.where(past, omega, wp.where(rocking and not turned, omega1, zero))
    time1 = wp.where(live and tau >= fused_less(TICK, target, room), target, time + tau)
    a_now = acceleration_after(a0, a1, a2, a3, a4, a5, a6, a7, a8, tau)
    needed1 = needed_at_rest(block, resting and tau > zero, a0, a_now, needed1)
    omega1, side1, mode1, uplift_time1, rest_time1, loss1, needed1 = event_step(
        block, impact, uplift, pull, a_now, time1,
        omega1, side, mode, uplift_time, rest_time, loss, needed1,
    )  # fmt: skip
    passed = time1 >= knot and live
    omega1, side1, mode1, uplift_time1, rest_time1, needed1 = motion_step(
        block, passed, knot_step(m, segment), time1,
        theta1, omega1, side1, mode1, uplift_time1, rest_time1, needed1,
    )  # fmt: skip
    mode1, theta1, peak1, peak_time1 = end_of_step(mode1, theta1, omega1, time1, peak, peak_time)
    return (
        theta1, omega1, side1, time1, segment + wp.where(passed, 1, 0), mode1, peak1, peak_time1,
        uplift_time1, rest_time1, loss1, impacts + wp.where(impact, 1, 0), cap1, needed1,
    )  # fmt: skip
