"""Housner's block as a body on a convex base: it turns about one point of it, event by event.

The base is a chain of feet from -x to +x (head of housner/body_series.py), 0 to n - 1. Between two
feet is an edge, which lies flat on the ground at one rotation of the body. Foot j touches the
ground alone while the rotation is between `low`, that of the edge to its -x, and `high`, that of
the edge to its +x; an outer foot does so up to a right angle. Where the rotation of a body comes to
such an end, the next foot strikes the ground. With the places x_o and x_n of the old and the new
foot beside the centre of mass, its height H above the ground and the radius of gyration k, the
angular momentum about the new foot keeps

    eta = (k^2 + x_o x_n + H^2) / (k^2 + x_n^2 + H^2)

of the angular velocity (found on the host, `warprock/engines/housner_body.py`), or what the case
prescribes for the edge that the body stands on at first.
At eta <= 0 it stays on both feet. On an edge it rests as long as the base acceleration lies between
-g x_right / H and -g x_left / H, and is lifted over that end otherwise; where the centre of mass is
beyond an end that is at once.

A step is as in housner/block.py. What is watched while the body rocks is the distance to the edge
that it moves towards, or has just left; a step that would pass the other end of the foot's range
is repeated up to there. The loss is the sum of I_o w_o^2 - I_n w_n^2 over the impacts, I over the
mass [m^2/s^2].
"""

import warp as wp

from warprock.kernels.housner.block import NEARLY, REACH, ROUND_OFF, TICK, Event, next_event
from warprock.kernels.housner.block_contact import Force, needed_in_step, ratio
from warprock.kernels.housner.block_found import Seen
from warprock.kernels.housner.body_series import (
    Foot,
    force_series,
    friction_at_rest,
    rolling_series,
    sine_cosine,
)
from warprock.kernels.housner.body_weight import expand_above, lift_at
from warprock.kernels.lane.modes import OVERTURNED, RESTING, ROCKING
from warprock.kernels.motion.kinds import Acceleration, Ground, Motion, expand, knot_time
from warprock.kernels.shape.above import Above
from warprock.kernels.shape.taylor import Polynomial, choose, scale, slope_at, value_at


@wp.struct
class Body:
    """What a step needs to know of one lane's body."""

    gravity: real
    radius: real
    fall_left: real
    fall_right: real
    rest_rotation: real
    step_length: real
    step_limit: int


@wp.struct
class Edge:
    """What there is between a foot, on the left, and the next one, on the right.

    `hold`: base acceleration that lifts the body over that end; `weight` and `pull`: angular
    acceleration about that end that weight and a unit of base acceleration make; `inertia`: about
    that end, over the mass; `kept`: eta of the impact on that end, and `slip`, the friction that it
    needs.
    """

    hold_left: real
    hold_right: real
    weight_left: real
    weight_right: real
    pull_left: real
    pull_right: real
    inertia_left: real
    inertia_right: real
    kept_left: real
    kept_right: real
    slip_left: real
    slip_right: real


@wp.struct
class State:
    """State of a lane.

    Attributes:
        theta: Rotation [rad].
        omega: Its rate [rad/s].
        place: Number of the foot that the body turns about; at rest of the one at -x of its edge.
        last: Number of the last foot.
        time: Time [s].
        segment, risen: Knots that are passed of the motion along x and of that upwards.
        mode: RESTING, ROCKING, or how the lane ended.
        cap: Longest step allowed next time [s].
        needed: Friction that the body has needed so far, which changes nothing of its motion.
    """

    theta: real
    omega: real
    place: int
    last: int
    time: real
    segment: int
    risen: int
    mode: int
    cap: real
    needed: real


@wp.struct
class Hold:
    """What holds a body at rest on an edge against the base.

    Attributes:
        pull: Direction of the acceleration that is nearer to lifting it, 1 to +x or -1.
        limit: Acceleration that lifts it [m/s^2].
        per: What the limit grows by per vertical acceleration of the base.
    """

    pull: real
    limit: real
    per: real


@wp.struct
class Ending:
    """What a step ends with.

    Attributes:
        impact: Whether the next foot strikes the ground.
        uplift: Whether the body is lifted off an edge.
        upper: Whether the event is at the upper end of the foot's range.
        pull: Direction of the acceleration that lifts a body at rest, 1 to +x or -1.
        along, upwards: Acceleration of the base [m/s^2].
    """

    impact: bool
    uplift: bool
    upper: bool
    pull: real
    along: real
    upwards: real


@wp.func
def may_rest(
    edge: Edge, rest_rotation: real, omega: real, acceleration: real, lifting: real, gravity: real
):
    """Whether a body stays on an edge, and the time of the impacts that are left out."""
    one = real(1.0)
    left = edge.weight_left - edge.pull_left * acceleration
    right = edge.weight_right + edge.pull_right * acceleration
    if VERTICAL:
        left = left + edge.weight_left / gravity * lifting
        right = right + edge.weight_right / gravity * lifting
    weaker = smaller(left + ROUND_OFF * edge.weight_left, right + ROUND_OFF * edge.weight_right)
    rests = weaker > real(0.0) and omega * omega <= TWO * weaker * rest_rotation
    to_right = omega > real(0.0)
    here, there = wp.where(to_right, right, left), wp.where(to_right, left, right)
    eta = wp.where(to_right, edge.kept_left, edge.kept_right)
    lost = larger(one - edge.kept_left * edge.kept_right, real(1.0e-6))
    return rests, TWO * size(omega) * (one / here + eta / there) / lost


@wp.func
def first_event(
    resting: bool, upper: bool, hold: Hold, foot: Foot, rotation: Polynomial, a: Acceleration,
    z: Acceleration, h: real,
) -> Event:  # fmt: skip
    """First event within a step of length h; as `next_event`.

    Watched is how far the rotation is from the upper or the lower end of the foot's range; at rest
    what a pull of the base lacks to the limit, which is `per` vertical acceleration larger where
    the base moves upwards.
    """
    zero = real(0.0)
    pull, per = hold.pull, hold.per
    way = scale(wp.where(upper, real(-1.0), real(1.0)), rotation)
    way.c0 = wp.where(upper, foot.high - rotation.c0, rotation.c0 - foot.low)
    lack = Polynomial(
        hold.limit - pull * a.a0, -pull * a.a1, -pull * a.a2, -pull * a.a3, -pull * a.a4,
        -pull * a.a5, -pull * a.a6, -pull * a.a7, -pull * a.a8, zero, zero,
    )  # fmt: skip
    if VERTICAL:
        lack.c0 = lack.c0 + per * z.a0
        lack.c1 = lack.c1 + per * z.a1
        lack.c2 = lack.c2 + per * z.a2
        lack.c3 = lack.c3 + per * z.a3
        lack.c4 = lack.c4 + per * z.a4
        lack.c5 = lack.c5 + per * z.a5
        lack.c6 = lack.c6 + per * z.a6
        lack.c7 = lack.c7 + per * z.a7
        lack.c8 = lack.c8 + per * z.a8
    watched = choose(resting, lack, way)
    event = next_event(watched, h, False)
    # A jump of the acceleration lifts a resting body, round-off sinks a rocking one: at once.
    lack_at_end = hold.limit - pull * value_at(base_polynomial(a), h)
    if VERTICAL:
        lack_at_end = lack_at_end + per * lift_at(z, h)
    lifts = watched.c0 < -NEARLY * size(hold.limit) or (watched.c0 <= zero and lack_at_end < zero)
    at_once = wp.where(resting, lifts, watched.c0 < zero)
    return Event(
        wp.where(at_once, zero, event.tau),
        event.turned and not at_once,
        event.crossed or at_once,
        wp.where(at_once, NEVER, event.cap),
    )


@wp.func
def base_polynomial(a: Acceleration) -> Polynomial:
    """The acceleration of the base as a polynomial."""
    zero = real(0.0)
    return Polynomial(a.a0, a.a1, a.a2, a.a3, a.a4, a.a5, a.a6, a.a7, a.a8, zero, zero)


@wp.func
def weaker_hold(edge: Edge, gravity: real, a0: real, a_end: real, z0: real, z_end: real) -> Hold:
    """What holds a body on an edge against the stronger pull of the base in a step.

    The base accelerates by a0 and z0 at its start, by a_end and z_end at its end.
    """
    zero = real(0.0)
    left = edge.hold_left - larger(a0, a_end)
    right = edge.hold_right + smaller(a0, a_end)
    if VERTICAL:
        more_left, more_right = edge.hold_left / gravity, edge.hold_right / gravity
        left = edge.hold_left + smaller(more_left * z0 - a0, more_left * z_end - a_end)
        right = edge.hold_right + smaller(more_right * z0 + a0, more_right * z_end + a_end)
    to_left = left < right
    hold = wp.where(to_left, edge.hold_left, edge.hold_right)
    slack = TWO * ROUND_OFF * size(hold)
    pull = wp.where(to_left, real(1.0), real(-1.0))
    return Hold(pull, hold + slack + zero, hold / gravity)


@wp.func
def watches_upper(foot: Foot, rotation: Polynomial, h: real) -> bool:
    """Whether the upper end of a foot's range is watched, not the lower one.

    It is the end that a step starts at, else the one that the body moves towards.
    """
    theta, omega = rotation.c0, rotation.c1
    still = wp.where(size(rotation.c2) > NEARLY * size(rotation.c3) * h, rotation.c2, rotation.c3)
    moves = wp.where(omega == real(0.0), still, omega)
    return theta == foot.high or (theta != foot.low and moves > real(0.0))


@wp.func
def apply_event(
    body: Body, edge: Edge, ending: Ending, s: wp.ref[State], seen: wp.ref[Seen],
):  # fmt: skip
    """Changes what an impact on an edge, or an uplift from one, changes."""
    zero = real(0.0)
    impact, uplift, upper = ending.impact, ending.uplift, ending.upper
    kept = larger(wp.where(upper, edge.kept_right, edge.kept_left), zero)
    inertia_before = wp.where(upper, edge.inertia_left, edge.inertia_right)
    inertia_after = wp.where(upper, edge.inertia_right, edge.inertia_left)
    slip = wp.where(upper, edge.slip_right, edge.slip_left)
    before = s.omega
    after = kept * before
    stays, tail = may_rest(
        edge, body.rest_rotation, after, ending.along, ending.upwards, body.gravity
    )
    # A body that keeps nothing stays on both feet; what moves it from there is an uplift.
    rests = impact and (stays or kept == zero)
    after = wp.where(rests, zero, after)
    # At rest the place is that of the foot at -x of the edge.
    struck = wp.where(upper, wp.where(rests, s.place, s.place + 1), s.place - 1)
    lifted = wp.where(ending.pull > zero, s.place, s.place + 1)
    lost = inertia_before * before * before - inertia_after * after * after
    s.omega = wp.where(impact, after, before)
    s.place = wp.where(uplift, lifted, wp.where(impact, struck, s.place))
    s.mode = wp.where(rests, RESTING, wp.where(uplift, ROCKING, s.mode))
    s.needed = wp.where(impact, larger(slip, s.needed), s.needed)
    first = smaller(seen.uplift_time, s.time)
    seen.uplift_time = wp.where(uplift, first, seen.uplift_time)
    rested = wp.where(uplift, NEVER, seen.rest_time)
    seen.rest_time = wp.where(rests, s.time + wp.where(stays, tail, zero), rested)
    seen.loss = seen.loss + wp.where(impact, lost, zero)
    seen.impacts = seen.impacts + wp.where(impact, 1, 0)


@wp.func
def kick(
    body: Body, foot: Foot, edge: Edge, dv: real, dz: real, s: wp.ref[State], seen: wp.ref[Seen],
):  # fmt: skip
    """Changes what a velocity step of the base changes, dv along and dz upwards."""
    zero = real(0.0)
    steps = dv != zero or dz != zero
    sn, c = sine_cosine(s.theta - foot.alpha)
    gain = -(foot.rho + foot.q * c) / (real(1.0) + foot.eps * c) * dv
    off = -wp.where(dv > zero, edge.pull_left, edge.pull_right) * dv
    to_right = dv < zero
    off_along, off_upwards = real(dv), real(dz)
    if VERTICAL:
        gain = gain + foot.q * sn / (real(1.0) + foot.eps * c) * dz
        # Over either end, and what the base gives the centre of mass then.
        over_left = edge.pull_left * dv - edge.weight_left / body.gravity * dz
        over_right = -edge.pull_right * dv - edge.weight_right / body.gravity * dz
        to_right = over_right >= over_left
        off = wp.where(to_right, larger(over_right, zero), -larger(over_left, zero))
        inertia = wp.where(to_right, edge.inertia_right, edge.inertia_left)
        pulled = wp.where(to_right, edge.pull_right, edge.pull_left)
        weighs = wp.where(to_right, edge.weight_right, edge.weight_left) / body.gravity
        off_along = dv + inertia * pulled * off
        off_upwards = dz + inertia * weighs * size(off)
    rests, _tail = may_rest(edge, body.rest_rotation, off, zero, zero, body.gravity)
    rocks = steps and s.mode == ROCKING
    lifts = steps and s.mode == RESTING and not rests
    if VERTICAL:
        lifts = lifts and off != zero
    omega = wp.where(rocks, s.omega + gain, wp.where(lifts, off, s.omega))
    # Thrown back where a foot has just come down, the body turns about the one that it left.
    place = wp.where(rocks and s.theta == foot.high and omega > zero, s.place + 1, s.place)
    place = wp.where(rocks and s.theta == foot.low and omega < zero, s.place - 1, place)
    place = wp.where(lifts and to_right, s.place + 1, place)
    along = dv + (body.radius + foot.reach * c) * gain
    falls = (s.theta >= body.fall_right and s.omega >= zero) or (
        s.theta <= -body.fall_left and s.omega <= zero
    )
    asked = ratio(along, -foot.reach * sn * gain)
    counts = rocks and not falls
    if VERTICAL:
        asked = ratio(along, dz - foot.reach * sn * gain)
        asked = wp.where(lifts, ratio(off_along, off_upwards), asked)
        counts = counts or lifts
    s.omega = omega
    s.place = place
    s.mode = wp.where(lifts, ROCKING, s.mode)
    s.needed = wp.where(counts and asked > s.needed, asked, s.needed)
    first = smaller(seen.uplift_time, s.time)
    seen.uplift_time = wp.where(lifts, first, seen.uplift_time)
    seen.rest_time = wp.where(lifts, NEVER, seen.rest_time)


@wp.func
def reject_overshoot(live: bool, excess: real, omega: real, tau: real, cap: real):
    """Whether a body passes the other end of its foot's range: it repeats the step up to there.

    Returns:
        That, the length of the step (0 if it is repeated), the longest step allowed next time.
    """
    past = live and excess > NEARLY
    return (
        past,
        wp.where(past or not live, real(0.0), tau),
        wp.where(past, larger(tau - excess / size(omega), HALF * tau), cap),
    )


@wp.func
def friction_in_step(
    body: Body, s: State, force: Force, a: Acceleration, z: Acceleration, tau: real,
    end_omega: real,
) -> real:  # fmt: skip
    """The larger of the friction needed so far and what a step of length tau needs."""
    resting, rocking = s.mode == RESTING, s.mode == ROCKING
    side = sign_of(s.theta)
    fall = wp.where(s.theta < real(0.0), body.fall_left, body.fall_right)
    held = friction_at_rest(body.gravity, s.needed, tau, a, z)
    return needed_in_step(
        wp.where(resting and tau > real(0.0), held, s.needed), rocking, fall, side * s.theta,
        side * s.omega, side * end_omega, tau, force,
    )  # fmt: skip


@wp.func
def advance(
    body: Body, foot: Foot, behind: Edge, m: Motion, ground: Ground, above: Above, until: real,
    s: State,
):  # fmt: skip
    """The way of one lane to its next event, or at most to `until`: its state, what it ends with.

    `behind` is the edge behind the foot, on which a body at rest lies.
    """
    zero = real(0.0)
    live, resting, rocking = s.mode < OVERTURNED, s.mode == RESTING, s.mode == ROCKING
    target = smaller(knot_time(m, s.segment), until)
    if VERTICAL:
        target = smaller(knot_time(above.motion, above.segment), target)
    room = target - s.time
    h = smaller(smaller(smaller(body.step_length, REACH / size(s.omega)), room), s.cap)
    h = wp.where(live, larger(h, zero), zero)
    a = expand(m, s.segment, s.time, ground.value, ground.slope)
    z = expand_above(above, s.time)
    rotation, tilt = rolling_series(foot, s.theta, s.omega, a, z)
    upper = resting or watches_upper(foot, rotation, h)
    hold = weaker_hold(
        behind, body.gravity, a.a0, value_at(base_polynomial(a), h), z.a0, lift_at(z, h)
    )
    event = first_event(resting, upper, hold, foot, rotation, a, z, h)
    theta = value_at(rotation, event.tau)
    omega = slope_at(rotation, event.tau)
    excess = wp.where(upper, foot.low - theta, theta - foot.high)
    past, tau, cap = reject_overshoot(
        live, wp.where(rocking, excess, zero), omega, event.tau, event.cap
    )
    force = force_series(body.gravity, body.radius, foot.reach, rotation, tilt, a, z)
    needed = friction_in_step(body, s, force, a, z, tau, omega)
    reaches = rocking and event.crossed and not past
    end = wp.where(upper, foot.high, foot.low)
    strikes = wp.where(upper, s.place < s.last, s.place > 0)
    after = State(
        wp.where(rocking and not past, wp.where(reaches, end, theta), s.theta),
        wp.where(past, s.omega, wp.where(rocking and not event.turned, omega, zero)),
        s.place,
        s.last,
        wp.where(live and tau >= room - TICK * target, target, s.time + tau),
        s.segment,
        s.risen,
        s.mode,
        cap,
        needed,
    )
    ending = Ending(
        reaches and strikes, resting and event.crossed, upper, hold.pull,
        value_at(base_polynomial(a), tau), lift_at(z, tau),
    )  # fmt: skip
    return after, ending
