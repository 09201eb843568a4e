"""A strip of wall between two floors: two bodies that rock about a hinge between them.

The mechanism is that of `warprock.model.strip`, where its letters are explained. Mirrored so that
the strip is bowed towards +x, with x the lean and a the acceleration of the base,

    M x'' + M' x' / 2 = -V' - a S',      psi' = r x',

primes of M in time. A step is one expansion of degree 10 of lean and turn, with their sines and
cosines; it is cut at its turning point, and on what is left the lean grows or falls all along, so
that it ends at the return upright or at the fall in its way. At rest the strip bows to the side to
which |a| > V' / S'.

Upright, the cracks close and others open: the strip goes on bowed to the other side, its rate times
the angular restitution. Rest rule: as of the free block (housner/block.py), with the leans of the
unstable balance for slenderness angles.

The friction that base and hinge need is looked up at nine times in every step, and at their crest;
of a step in which the strip comes to where it falls for certain, up to there: where a base
acceleration of friction x g, at most g, would not hold it any more. At rest it is not known how the
faces share what the base gives: nothing is judged.
"""

import warp as wp

from warprock.kernels.housner.block import COARSE, GRAIN, ROUND_OFF
from warprock.kernels.housner.block_contact import ratio
from warprock.kernels.housner.block_found import FrictionSeen
from warprock.kernels.housner.lean import (
    LOOK,
    LOOKS,
    REACH,
    Looks,
    State,
    crest_of,
    end_step,
    go_on,
    goes_out,
    judged_time,
    lift,
    quiet_step,
    turning_time,
)
from warprock.kernels.lane.modes import OVERTURNED, RESTING, ROCKING
from warprock.kernels.motion.kinds import Ground, Motion, knot_step, knot_time
from warprock.kernels.motion.series import (
    DEGREE,
    TICK,
    Series,
    pull_series,
    root_of,
    slope_of,
    term,
    value_of,
)

ORDERS = DEGREE - 1
"""Orders to which the turn of the upper body, sines and cosines are expanded."""

LAST_TERM = by_precision(1.0e-13, 1.0e-7)
"""Largest last term of the lean, and of the turn of the upper body, in a step [rad]."""


@wp.struct
class Strip:
    """What a step needs to know of one lane's strip.

    Of what depends on the side, `left` is that of a strip bowed to -x.
    """

    width: real
    lower: real
    upper: real
    lower_mass: real
    upper_mass: real
    lower_inertia: real
    upper_inertia: real
    weight: real
    gravity: real
    angular_restitution: real
    impact_friction: real
    rest_rotation: real
    step_length: real
    step_limit: int
    arm_left: real
    arm_right: real
    laid_left: real
    laid_right: real
    fall_left: real
    fall_right: real


@wp.struct
class Mechanism:
    """A strip bowed to one side, per unit of the rate of its lean.

    Attributes:
        arm: a [m].
        turn: Turn of the upper body [rad].
        rate: r.
        x1, y1, x2, y2: Velocities of the centres [m].
        inertia: M [kg m^2].
        restoring: V' [N m].
        pulled: S' [kg m].
    """

    arm: real
    turn: real
    rate: real
    x1: real
    y1: real
    x2: real
    y2: real
    inertia: real
    restoring: real
    pulled: real


@wp.struct
class Way:
    """A strip in a step: its lean and the turn of the upper body, their sines and cosines."""

    lean: Series
    turn: Series
    sine1: Series
    cosine1: Series
    sine2: Series
    cosine2: Series


@wp.struct
class Gain:
    """What the bodies gain, by Newton's law: velocities or, with gravity, accelerations."""

    x1: real
    y1: real
    x2: real
    y2: real
    turn: real


@wp.func
def arm_of(strip: Strip, side: real) -> real:
    """Distance from the edge of the upper body at the hinge to the point below the floor [m]."""
    return wp.where(side > real(0.0), strip.arm_right, strip.arm_left)


@wp.func
def turn_at(strip: Strip, arm: real, lean: real) -> real:
    """Turn of the upper body at a lean [rad]."""
    half_sine = sine(HALF * lean)
    reach = real(2.0) * half_sine * (strip.lower * cosine(HALF * lean) + strip.width * half_sine)
    square = strip.upper * strip.upper + reach * (real(2.0) * arm - reach)
    root = wp.sqrt(larger(square, real(0.0)))
    return real(2.0) * wp.atan(reach / (strip.upper + root))


@wp.func
def mechanism_at(strip: Strip, side: real, lean: real) -> Mechanism:
    """A strip at a lean to a side."""
    n = Mechanism()
    t, h1, h2 = strip.width, strip.lower, strip.upper
    n.arm = arm_of(strip, side)
    n.turn = turn_at(strip, n.arm, lean)
    s1, c1, s2, c2 = sine(lean), cosine(lean), sine(n.turn), cosine(n.turn)
    across, rise = h1 * c1 + t * s1, t * c1 - h1 * s1
    n.rate = across / (h2 * c2 + n.arm * s2)
    n.x1 = HALF * across
    n.y1 = HALF * rise
    n.x2 = across - HALF * (t * s2 + h2 * c2) * n.rate
    n.y2 = rise + HALF * (t * c2 - h2 * s2) * n.rate
    top = rise + (n.arm * c2 - h2 * s2) * n.rate
    moved = strip.upper_mass * (n.x2 * n.x2 + n.y2 * n.y2)
    n.inertia = strip.lower_inertia + moved + strip.upper_inertia * n.rate * n.rate
    lifted = strip.lower_mass * n.y1 + strip.upper_mass * n.y2
    n.restoring = strip.gravity * lifted + strip.weight * top
    n.pulled = strip.lower_mass * n.x1 + strip.upper_mass * n.x2
    return n


@wp.func
def way_of(strip: Strip, side: real, lean: real, omega: real, pull: Series) -> Way:
    """A strip about the present time; `omega` is the rate of its lean, `pull` mirrored with it."""
    n0 = mechanism_at(strip, side, lean)
    t, h1, h2, arm = strip.width, strip.lower, strip.upper, n0.arm
    x, turn = Series(), Series()
    s1, c1, s2, c2 = Series(), Series(), Series(), Series()
    # Rate of the lean, r, the distance that r is divided by, velocities for x' = 1, M.
    rate, r, below, x2, y2, inertia = Series(), Series(), Series(), Series(), Series(), Series()
    across2, along2 = Series(), Series()
    x[0] = lean
    x[1] = omega
    rate[0] = omega
    turn[0] = n0.turn
    s1[0] = sine(lean)
    c1[0] = cosine(lean)
    s2[0] = sine(n0.turn)
    c2[0] = cosine(n0.turn)
    r[0] = n0.rate
    below[0] = h2 * c2[0] + arm * s2[0]
    across2[0] = HALF * (t * s2[0] + h2 * c2[0])
    along2[0] = HALF * (t * c2[0] - h2 * s2[0])
    x2[0] = n0.x2
    y2[0] = n0.y2
    inertia[0] = n0.inertia
    pulled = Series()
    pulled[0] = n0.pulled
    for n in range(ORDERS):
        k = n + 1
        part = real(1.0) / real(k)
        turn[k] = part * term(r, rate, n)
        up, down, up2, down2 = real(0.0), real(0.0), real(0.0), real(0.0)
        for j in range(k):
            up = up + rate[j] * c1[n - j]
            down = down + rate[j] * s1[n - j]
            swing = real(j + 1) * turn[j + 1]
            up2 = up2 + swing * c2[n - j]
            down2 = down2 + swing * s2[n - j]
        s1[k] = part * up
        c1[k] = -part * down
        s2[k] = part * up2
        c2[k] = -part * down2
        below[k] = h2 * c2[k] + arm * s2[k]
        across2[k] = HALF * (t * s2[k] + h2 * c2[k])
        along2[k] = HALF * (t * c2[k] - h2 * s2[k])
        across = h1 * c1[k] + t * s1[k]
        left = real(across)
        for j in range(k):
            left = left - r[j] * below[k - j]
        r[k] = left / below[0]
        x2[k] = across - term(across2, r, k)
        y2[k] = t * c1[k] - h1 * s1[k] + term(along2, r, k)
        moved = strip.upper_mass * (term(x2, x2, k) + term(y2, y2, k))
        inertia[k] = moved + strip.upper_inertia * term(r, r, k)
        # What turns it back, of order n; then M x'' = that - M' x' / 2, order by order.
        rise = t * c1[n] - h1 * s1[n]
        force = -strip.gravity * (HALF * strip.lower_mass * rise + strip.upper_mass * y2[n])
        top = real(rise)
        for j in range(k):
            top = top + (arm * c2[j] - h2 * s2[j]) * r[n - j]
        force = force - strip.weight * top
        for j in range(k):
            force = force - pull[j] * pulled[n - j]
            force = force - HALF * real(j + 1) * inertia[j + 1] * rate[n - j]
        for j in range(n):
            force = force - inertia[n - j] * real(j + 1) * rate[j + 1]
        rate[k] = part * force / inertia[0]
        x[k + 1] = rate[k] / real(k + 1)
        pulled[k] = HALF * strip.lower_mass * across + strip.upper_mass * x2[k]
    return Way(x, turn, s1, c1, s2, c2)


@wp.func
def trusted_step(last: real, order: int) -> real:
    """Step in which the last term of a series is small enough [s]: a fall has ever shorter ones."""
    return wp.pow(LAST_TERM / (size(last) + TINY), real(1.0) / real(order))


@wp.func
def needed_for(strip: Strip, arm: real, s2: real, c2: real, weight: real, gain: Gain) -> real:
    """Friction that base and hinge need for what the bodies gain; NEVER where they would pull.

    What the hinge gives has no moment about itself, so the upper body tells what the floor gives.
    """
    t, h2, mass = strip.width, strip.upper, strip.upper_mass
    # The centre of the upper body over the hinge, and the point below the floor over the centre.
    x, y = HALF * (t * c2 - h2 * s2), HALF * (t * s2 + h2 * c2)
    beside, height = arm * c2 - h2 * s2 - x, h2 * c2 + arm * s2
    both, hinge = mass * gain.x2, mass * gain.y2 + weight
    floor = -(strip.upper_inertia * gain.turn + x * hinge - y * both + beside * weight) / height
    of_hinge = both - floor
    of_base = strip.lower_mass * gain.x1 + of_hinge
    found = ratio(of_base, strip.lower_mass * gain.y1 + hinge)
    return larger(ratio(of_hinge, hinge), found)


@wp.func
def needed_at(strip: Strip, side: real, way: Way, pull: Series, t: real) -> real:
    """Friction that a bowed strip needs a time t after the start of a step."""
    b, h1, h2 = strip.width, strip.lower, strip.upper
    arm = arm_of(strip, side)
    s1, c1 = value_of(way.sine1, t), value_of(way.cosine1, t)
    s2, c2 = value_of(way.sine2, t), value_of(way.cosine2, t)
    rate = slope_of(way.lean)
    swing = slope_of(way.turn)
    lean_rate, turn_rate = value_of(rate, t), value_of(swing, t)
    bends = value_of(slope_of(rate), t)
    turns = value_of(slope_of(swing), t)
    base = value_of(pull, t)
    # Accelerations of the hinge and of the centres.
    x0 = (h1 * c1 + b * s1) * bends + (b * c1 - h1 * s1) * lean_rate * lean_rate
    y0 = (b * c1 - h1 * s1) * bends - (h1 * c1 + b * s1) * lean_rate * lean_rate
    across2, along2 = HALF * (b * s2 + h2 * c2), HALF * (b * c2 - h2 * s2)
    gain = Gain(
        base + HALF * x0,
        strip.gravity + HALF * y0,
        base + x0 - across2 * turns - along2 * turn_rate * turn_rate,
        strip.gravity + y0 + along2 * turns - across2 * turn_rate * turn_rate,
        turns,
    )
    return needed_for(strip, arm, s2, c2, strip.weight, gain)


@wp.func
def needed_in(strip: Strip, side: real, way: Way, pull: Series, tau: real) -> real:
    """Friction that a bowed strip needs in a step of length tau, from a few looks."""
    part = LOOK * tau
    looks = Looks()
    for k in range(LOOKS):
        looks[k] = needed_at(strip, side, way, pull, real(k + 1) * part)
    found, crest = crest_of(needed_at(strip, side, way, pull, real(0.0)), looks)
    if crest > real(0.0):
        found = larger(needed_at(strip, side, way, pull, crest * part), found)
    return found


@wp.func
def upright_acceleration(strip: Strip, side: real, a: real) -> real:
    """Angular acceleration that keeps an upright strip from bowing to a side [rad/s^2]."""
    n = mechanism_at(strip, side, real(0.0))
    return (n.restoring + side * a * n.pulled) / n.inertia


@wp.func
def blur_of(strip: Strip, side: real, slope: real, time: real) -> real:
    """By how much an error of the time blurs what keeps a strip upright, as of a held block."""
    found = real(0.0)
    if COARSE:
        n = mechanism_at(strip, side, found)
        found = GRAIN * time * size(slope * n.pulled) / n.inertia
    return found


@wp.func
def settles(strip: Strip, omega: real, a: real, blur: real) -> bool:
    """Whether an upright strip with a rate rests: its next swing is too small to count."""
    right, left, still = real(1.0), real(-1.0), real(0.0)
    balance = smaller(
        upright_acceleration(strip, right, still), upright_acceleration(strip, left, still)
    )
    one, other = upright_acceleration(strip, right, a), upright_acceleration(strip, left, a)
    weaker = smaller(one, other) + ROUND_OFF * balance + blur
    return weaker > real(0.0) and omega * omega <= real(2.0) * weaker * strip.rest_rotation


@wp.func
def strike(strip: Strip, a: real, blur: real, s: wp.ref[State], seen: wp.ref[FrictionSeen]):
    """The return upright: the strip goes on bowed to the other side, or rests."""
    kept = strip.angular_restitution
    after = kept * s.omega
    s.side = -s.side
    seen.needed = larger(strip.impact_friction, seen.needed)
    # It rests, if only until the base bows it.
    rests = after == real(0.0)
    tail = real(0.0)
    if not rests and settles(strip, after, a, blur):
        here = upright_acceleration(strip, s.side, a)
        there = upright_acceleration(strip, -s.side, a)
        lost = larger(real(1.0) - kept * kept, real(1.0e-6))
        tail = real(2.0) * size(after) * (real(1.0) / here + kept / there) / lost
        rests = True
    go_on(after, rests, tail, s, seen)


@wp.func
def fall_lean(strip: Strip, side: real) -> real:
    """Lean to a side from which on a strip falls for certain [rad]."""
    return wp.where(side > real(0.0), strip.fall_right, strip.fall_left)


@wp.func
def pass_knot(strip: Strip, dv: real, s: wp.ref[State], seen: wp.ref[FrictionSeen]):
    """Passes a knot of the motion, with a velocity step dv of the base."""
    s.segment = s.segment + 1
    if dv != real(0.0):
        side = s.side
        if s.theta == real(0.0):
            side = -sign_of(dv)
        n = mechanism_at(strip, side, size(s.theta))
        kick = -n.pulled / n.inertia * dv
        goes = s.mode == ROCKING
        if s.mode == RESTING:
            goes = not settles(strip, kick, real(0.0), real(0.0))
            if goes:
                lift(side, s, seen)
        if goes:
            s.omega = s.omega + kick
            if s.theta == real(0.0):
                s.side = sign_of(s.omega)
            falls = s.side * s.theta >= fall_lean(strip, s.side)
            falls = falls and s.side * s.omega >= real(0.0)
            if not falls:
                turned = side * kick
                gain = Gain(
                    side * dv + n.x1 * turned, n.y1 * turned, side * dv + n.x2 * turned,
                    n.y2 * turned, n.rate * turned,
                )  # fmt: skip
                s2, c2 = sine(n.turn), cosine(n.turn)
                asked = needed_for(strip, n.arm, s2, c2, real(0.0), gain)
                seen.needed = larger(asked, seen.needed)


@wp.func
def rock(
    strip: Strip,
    m: Motion,
    ground: Ground,
    until: real,
    s: wp.ref[State],
    seen: wp.ref[FrictionSeen],
):
    """One step of a bowed strip, to its next event or at most to `until`."""
    zero = real(0.0)
    knot = knot_time(m, s.segment)
    target = smaller(knot, until)
    room = larger(target - s.time, zero)
    side = s.side
    lean = side * s.theta
    n = mechanism_at(strip, side, lean)
    fastest = size(s.omega) * larger(n.rate, real(1.0))
    h = smaller(smaller(strip.step_length, REACH / fastest), room)
    pull = side * pull_series(m, s.segment, s.time, ground)
    way = way_of(strip, side, lean, side * s.omega, pull)
    x = way.lean
    h = smaller(h, smaller(trusted_step(x[DEGREE], DEGREE), trusted_step(way.turn[ORDERS], ORDERS)))
    outwards = goes_out(real(1.0), x, h)
    if not outwards and lean <= zero:
        strike(strip, side * pull[0], blur_of(strip, side, pull[1], s.time), s, seen)
    elif h > zero:
        towards = wp.where(outwards, real(1.0), real(-1.0))
        turn = turning_time(x, towards, h)
        turned = turn < h
        tau = smaller(turn, h)
        laid = wp.where(side > zero, strip.laid_right, strip.laid_left)
        ahead = -towards * x
        ahead[0] = wp.where(outwards, laid - lean, lean)
        reached = ahead[0] <= zero
        if reached:
            tau = zero
        elif value_of(ahead, tau) <= zero:
            reached = True
            tau = root_of(ahead, tau)
        judged = real(tau)
        if outwards:
            judged = judged_time(x, towards, fall_lean(strip, side) - lean, tau)
        if judged > zero:
            seen.needed = larger(needed_in(strip, side, way, pull, judged), seen.needed)
        arrives = tau >= fused_less(TICK, target, room)
        s.time = wp.where(arrives, target, s.time + tau)
        s.theta = side * value_of(x, tau)
        s.omega = side * value_of(slope_of(x), tau)
        base = side * value_of(pull, tau)
        if turned and not reached:
            s.omega = zero
        if reached and outwards:
            s.theta = side * laid
            s.mode = OVERTURNED
        elif reached:
            strike(strip, base, blur_of(strip, side, pull[1], s.time), s, seen)
    if s.time >= knot and s.mode < OVERTURNED:
        pass_knot(strip, knot_step(m, s.segment), s, seen)


@wp.func
def rest(
    strip: Strip,
    m: Motion,
    ground: Ground,
    until: real,
    s: wp.ref[State],
    seen: wp.ref[FrictionSeen],
):
    """One step of a strip at rest, until it bows or at most to `until`."""
    zero = real(0.0)
    knot = knot_time(m, s.segment)
    target = smaller(knot, until)
    room = larger(target - s.time, zero)
    a = pull_series(m, s.segment, s.time, ground)
    h = quiet_step(a, s.time, smaller(strip.step_length, room))
    tau = real(h)
    side = real(0.0)
    for k in range(2):
        over = real(2 * k - 1)
        # In a step without length, to a knot, it has no time to bow.
        if h > zero:
            n = mechanism_at(strip, over, zero)
            lack = over * n.pulled * a
            lack[0] = n.restoring * (real(1.0) + real(2.0) * ROUND_OFF) + over * n.pulled * a[0]
            lack[0] = lack[0] + real(2.0) * n.inertia * blur_of(strip, over, a[1], s.time)
            if lack[0] <= zero:
                tau = zero
                side = over
            elif value_of(lack, tau) < zero:
                tau = root_of(lack, tau)
                side = over
    arrives = tau >= fused_less(TICK, target, room)
    s.time = wp.where(arrives, target, s.time + tau)
    if side != zero:
        lift(side, s, seen)
    if s.time >= knot:
        pass_knot(strip, knot_step(m, s.segment), s, seen)


@wp.func
def step(
    strip: Strip,
    m: Motion,
    ground: Ground,
    until: real,
    s: wp.ref[State],
    seen: wp.ref[FrictionSeen],
):
    """One step of one lane, to its next event or at most to `until`."""
    if s.mode == RESTING:
        rest(strip, m, ground, until, s, seen)
    else:
        rock(strip, m, ground, until, s, seen)
    end_step(s, seen)
