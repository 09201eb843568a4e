"""A rocking block that something holds: Housner's equation with ties, beside a wall, loaded.

As housner/block.py, with the moment of ties and of a load on top (housner/held_ties.py):

    theta'' = p^2 sin(phi) - q a(t) cos(phi) + M(theta) / I,      phi = theta - side alpha.

A step is one expansion of degree 10. It is cut at its turning point; on what is left the lean
grows or falls all along, so that it ends at the first change of a tie, an impact or the fall in its
way. At rest the block lifts over the side on which

    side (M(0) / I - q a cos(alpha)) > p^2 sin(alpha).

A wall stands at one side of the block, along its whole height: the block turns to the other side
alone. It comes back on base and wall at once, and its angular velocity becomes -rebound times what
it was. What rests against a wall lifts away from it alone; a velocity step that presses it on the
wall moves nothing.

Rest rule: as of the free block, of the sides to which the block may turn. Beside a wall the impacts
that are left out would take 2 theta' / r / (1 - rebound).

The friction that a block needs is looked up at nine times in every step, and at their crest; of a
step in which it comes to where it falls for certain (housner/block_contact.py), up to there. Of a
block against its wall only what the wall cannot give is asked of the base; impacts on a wall are
not judged.
"""

import warp as wp

from warprock.kernels.contact.ties import force_of
from warprock.kernels.housner.block import COARSE, GRAIN, ROUND_OFF
from warprock.kernels.housner.block_contact import needed_at_step, ratio
from warprock.kernels.housner.block_found import FrictionSeen
from warprock.kernels.housner.held_ties import (
    Pull,
    Restraints,
    change_tie,
    elongation,
    next_bound,
    pull_of,
)
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
    value_of,
)


@wp.struct
class Block:
    """What a step needs to know of one lane's block.

    `wall` is the side at which a wall stands, -1 or 1; 0 without one.
    """

    slenderness_angle: real
    frequency_squared: real
    coupling: real
    angular_restitution: real
    impact_friction: real
    rebound: real
    wall: real
    fall_angle: real
    rest_rotation: real
    step_length: real
    step_limit: int
    half_width: real
    inertia: real
    mass: real
    load_weight: real
    load_thrust: real
    load_place: real
    load_height: real
    load_stays: int


@wp.struct
class TiesSeen:
    """Largest force [N] and largest elongation [m] of a tie so far."""

    force: real
    stretch: real


@wp.func
def rotation_series(block: Block, p: Pull, s: State, a: Series) -> Series:
    """The rotation about the present time.

    With s = sin(theta), c = cos(theta), w = 1 - c: s' = theta' c, w' = theta' s.
    """
    x = Series()
    sines = Series()
    lows = Series()
    x[0] = s.theta
    x[1] = s.omega
    half_sine = sine(HALF * s.theta)
    sines[0] = real(2.0) * half_sine * cosine(HALF * s.theta)
    lows[0] = real(2.0) * half_sine * half_sine
    up, across = cosine(block.slenderness_angle), s.side * sine(block.slenderness_angle)
    p2, q = block.frequency_squared, block.coupling
    cosines = Series()
    cosines[0] = real(1.0) - lows[0]
    for n in range(DEGREE - 1):
        sc, sx, sw, pushed = real(0.0), real(0.0), real(0.0), real(0.0)
        for j in range(n + 1):
            sc = sc + sines[j] * cosines[n - j]
            sx = sx + sines[j] * sines[n - j] + lows[j] * cosines[n - j]
            sw = sw + sines[j] * lows[n - j]
            pushed = pushed + a[j] * (up * cosines[n - j] + across * sines[n - j])
        bend = p2 * (up * sines[n] - across * cosines[n]) - q * pushed
        if n == 0:
            bend = bend + p.k
        bend = bend + p.c * cosines[n] + p.s * sines[n] + p.sc * sc + p.sx * sx + p.sw * sw
        x[n + 2] = bend / real((n + 1) * (n + 2))
        turned, lowered = real(0.0), real(0.0)
        for j in range(n + 1):
            rate = real(j + 1) * x[j + 1]
            turned = turned + rate * cosines[n - j]
            lowered = lowered + rate * sines[n - j]
        sines[n + 1] = turned / real(n + 1)
        lows[n + 1] = lowered / real(n + 1)
        cosines[n + 1] = -lows[n + 1]
    return x


@wp.func
def outward_moment(block: Block, held: Restraints, side: real, a: real) -> real:
    """Angular acceleration at which a flat block would lift over a side [rad/s^2]."""
    pull = pull_of(held, side)
    moved = pull.k + pull.c - block.coupling * a * cosine(block.slenderness_angle)
    return side * moved - block.frequency_squared * sine(block.slenderness_angle)


@wp.func
def blur_of(block: Block, a: Series, time: real) -> real:
    """By how much an error of the time blurs the angular acceleration of a flat block [rad/s^2].

    A block rests up to this beyond its balance, too: its hops would be shorter than times resolve.
    """
    found = real(0.0)
    if COARSE:
        found = GRAIN * time * block.coupling * cosine(block.slenderness_angle) * size(a[1])
    return found


@wp.func
def may_turn(block: Block, side: real) -> bool:
    """Whether a block may turn to a side: there is no wall."""
    return block.wall * side <= real(0.0)


@wp.func
def flat_acceleration(block: Block, held: Restraints, side: real, a: real) -> real:
    """Angular acceleration that keeps a flat block from turning to a side; NEVER at a wall."""
    found = NEVER
    if may_turn(block, side):
        found = -outward_moment(block, held, side, a)
    return found


@wp.func
def settles(block: Block, held: Restraints, omega: real, a: real, blur: real) -> bool:
    """Whether a flat block with a rate rests: its next swing is too small to count."""
    one, other = real(1.0), real(-1.0)
    weaker = smaller(
        flat_acceleration(block, held, one, a), flat_acceleration(block, held, other, a)
    )
    weaker = weaker + ROUND_OFF * block.frequency_squared * sine(block.slenderness_angle) + blur
    return weaker > real(0.0) and omega * omega <= real(2.0) * weaker * block.rest_rotation


@wp.func
def strike(
    block: Block,
    held: Restraints,
    a: real,
    blur: real,
    s: wp.ref[State],
    seen: wp.ref[FrictionSeen],
):
    """An impact: on the base, or on base and wall."""
    kept = block.angular_restitution
    after = kept * s.omega
    if block.wall != real(0.0):
        kept = block.rebound
        after = -kept * s.omega
    else:
        s.side = -s.side
        seen.needed = larger(block.impact_friction, seen.needed)
    # It rests, if only until the base or what holds it lifts it.
    rests = after == real(0.0) and block.wall == real(0.0)
    tail = real(0.0)
    if not rests and settles(block, held, after, a, blur):
        here = flat_acceleration(block, held, s.side, a)
        there = flat_acceleration(block, held, -s.side, a)
        tail = real(2.0) * size(after) / here / larger(real(1.0) - kept, real(1.0e-6))
        if block.wall == real(0.0):
            lost = larger(real(1.0) - kept * kept, real(1.0e-6))
            tail = real(2.0) * size(after) * (real(1.0) / here + kept / there) / lost
        rests = True
    go_on(after, rests, tail, s, seen)


@wp.func
def pass_knot(
    block: Block, held: Restraints, dv: real, s: wp.ref[State], seen: wp.ref[FrictionSeen]
):
    """Passes a knot of the motion, with a velocity step dv of the base."""
    zero = real(0.0)
    s.segment = s.segment + 1
    kick = -block.coupling * cosine(block.slenderness_angle - size(s.theta)) * dv
    if dv != real(0.0) and s.mode == RESTING:
        goes = may_turn(block, sign_of(kick)) and not settles(block, held, kick, zero, zero)
        if goes:
            lift(sign_of(kick), s, seen)
    if dv != real(0.0) and s.mode == ROCKING:
        s.omega = s.omega + kick
        if s.theta == real(0.0) and block.wall == real(0.0):
            s.side = sign_of(s.omega)
        falls = s.side * s.theta >= block.fall_angle and s.side * s.omega >= real(0.0)
        if not falls:
            asked = needed_at_step(size(s.theta), s.side, dv, block.slenderness_angle)
            seen.needed = larger(asked, seen.needed)


@wp.func
def needed_at(block: Block, p: Pull, side: real, x: Series, a: Series, t: real) -> real:
    """Friction that a rocking block needs a time t after the start of a step."""
    slope = slope_of(x)
    theta, omega = value_of(x, t), value_of(slope, t)
    bend, base = value_of(slope_of(slope), t), value_of(a, t)
    phi = theta - side * block.slenderness_angle
    s, c = sine(phi), cosine(phi)
    # R and g of the free block.
    radius, gravity = real(0.75) / block.coupling, block.frequency_squared / block.coupling
    half_sine = sine(HALF * theta)
    low = real(2.0) * half_sine * half_sine
    pull = p.f + p.fs * real(2.0) * half_sine * cosine(HALF * theta) + p.fw * low
    along = block.mass * (base + radius * (bend * c - omega * omega * s)) - pull
    upwards = block.mass * (gravity - radius * (bend * s + omega * omega * c)) + p.n
    return ratio(along, upwards)


@wp.func
def needed_in(block: Block, p: Pull, side: real, x: Series, a: Series, tau: real) -> real:
    """Friction that a rocking block needs in a step of length tau, from a few looks."""
    part = LOOK * tau
    looks = Looks()
    for k in range(LOOKS):
        looks[k] = needed_at(block, p, side, x, a, real(k + 1) * part)
    found, crest = crest_of(needed_at(block, p, side, x, a, real(0.0)), looks)
    if crest > real(0.0):
        found = larger(needed_at(block, p, side, x, a, crest * part), found)
    return found


@wp.func
def needed_flat(block: Block, held: Restraints, a: real) -> real:
    """Friction that a block at rest needs; a wall gives what pushes the block away from it."""
    pull = pull_of(held, real(1.0))
    gravity = block.frequency_squared / block.coupling
    along = block.mass * a - pull.f
    if block.wall * along < real(0.0):
        along = real(0.0)
    return size(along) / (block.mass * gravity + pull.n)


@wp.func
def observe_ties(held: Restraints, s: State, seen: wp.ref[TiesSeen]):
    """Sees the forces and elongations of the ties."""
    for i in range(held.ties.shape[0]):
        tie = held.ties[i, held.lane]
        stretch = elongation(held, tie, s.side, s.theta)
        seen.stretch = larger(stretch, seen.stretch)
        force = force_of(tie, held.states[i, held.lane], stretch)
        seen.force = larger(size(force), seen.force)


@wp.func
def rock(
    block: Block, m: Motion, ground: Ground, until: real, held: Restraints, s: wp.ref[State],
    seen: wp.ref[FrictionSeen], pulled: wp.ref[TiesSeen],
):  # fmt: skip
    """One step of a block that rocks, to its next event or at most to `until`."""
    zero = real(0.0)
    knot = knot_time(m, s.segment)
    target = smaller(knot, until)
    room = larger(target - s.time, zero)
    # A plastic return to the wall may leave a rate of -0, of which `size` is -0.
    h = smaller(smaller(block.step_length, REACH / wp.abs(s.omega)), room)
    side = s.side
    lean = side * s.theta
    a = pull_series(m, s.segment, s.time, ground)
    pull = pull_of(held, side)
    x = rotation_series(block, pull, s, a)
    outwards = goes_out(side, x, h)
    if not outwards and lean <= zero:
        strike(block, held, a[0], blur_of(block, a, s.time), s, seen)
    elif h > zero:
        towards = wp.where(outwards, side, -side)
        turn = turning_time(x, towards, h)
        turned = turn < h
        tau = smaller(turn, h)
        bound = next_bound(held, side, lean, outwards)
        left = wp.where(outwards, bound.lean - lean, lean - bound.lean)
        ahead = -towards * x
        ahead[0] = left
        reached = left <= zero
        if reached:
            tau = zero
        elif value_of(ahead, tau) <= zero:
            reached = True
            tau = root_of(ahead, tau)
        judged = real(tau)
        if outwards:
            judged = judged_time(x, towards, block.fall_angle - lean, tau)
        if judged > zero:
            seen.needed = larger(needed_in(block, pull, side, x, a, judged), seen.needed)
        arrives = tau >= fused_less(TICK, target, room)
        theta, omega = value_of(x, tau), value_of(slope_of(x), tau)
        base = value_of(a, tau)
        s.time = wp.where(arrives, target, s.time + tau)
        s.theta = theta
        s.omega = omega
        if reached:
            s.theta = side * bound.lean
        elif turned:
            s.omega = zero
        observe_ties(held, s, pulled)
        if reached:
            if bound.tie >= 0:
                change_tie(held, bound.tie, side, s.theta, outwards, s.time)
                observe_ties(held, s, pulled)
            elif outwards:
                s.mode = OVERTURNED
            else:
                strike(block, held, base, blur_of(block, a, s.time), s, seen)
    if s.time >= knot and s.mode < OVERTURNED:
        pass_knot(block, held, knot_step(m, s.segment), s, seen)


@wp.func
def rest(
    block: Block, m: Motion, ground: Ground, until: real, held: Restraints, s: wp.ref[State],
    seen: wp.ref[FrictionSeen],
):  # fmt: skip
    """One step of a block at rest, until it lifts or at most to `until`."""
    zero = real(0.0)
    knot = knot_time(m, s.segment)
    target = smaller(knot, until)
    room = larger(target - s.time, zero)
    a = pull_series(m, s.segment, s.time, ground)
    h = quiet_step(a, s.time, smaller(block.step_length, room))
    spare = real(2.0) * ROUND_OFF * block.frequency_squared * sine(block.slenderness_angle)
    spare = spare + real(2.0) * blur_of(block, a, s.time)
    tau = real(h)
    side = real(0.0)
    for k in range(2):
        over = real(2 * k - 1)
        # In a step without length, to a knot, it has no time to lift.
        if may_turn(block, over) and h > zero:
            lack = over * block.coupling * cosine(block.slenderness_angle) * a
            lack[0] = spare - outward_moment(block, held, over, a[0])
            if lack[0] <= zero:
                tau = zero
                side = over
            elif value_of(lack, tau) < zero:
                tau = root_of(lack, tau)
                side = over
    seen.needed = larger(needed_flat(block, held, a[0]), seen.needed)
    seen.needed = larger(needed_flat(block, held, value_of(a, tau)), seen.needed)
    arrives = tau >= fused_less(TICK, target, room)
    s.time = wp.where(arrives, target, s.time + tau)
    if side != zero:
        lift(side, s, seen)
    if s.time >= knot:
        pass_knot(block, held, knot_step(m, s.segment), s, seen)


@wp.func
def step(
    block: Block, m: Motion, ground: Ground, until: real, held: Restraints, s: wp.ref[State],
    seen: wp.ref[FrictionSeen], pulled: wp.ref[TiesSeen],
):  # fmt: skip
    """One step of one lane, to its next event or at most to `until`."""
    if s.mode == RESTING:
        rest(block, m, ground, until, held, s, seen)
    else:
        rock(block, m, ground, until, held, s, seen, pulled)
    end_step(s, seen)
