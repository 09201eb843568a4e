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
is repeated up to there. A lane's state is that of housner/block.py, with `place` for the side: the
number of the foot that the body turns about, at rest of the one at -x of its edge. `loss` is the
sum of I_o w_o^2 - I_n w_n^2 over the impacts, I over the mass [m^2/s^2].
"""

import warp as wp

from warprock.kernels.housner.block import (
    NEARLY,
    REACH,
    ROUND_OFF,
    TICK,
    next_event,
)  # fmt: skip
from warprock.kernels.housner.block_contact import needed_in_step, ratio
from warprock.kernels.housner.body_series import (
    force_series,
    friction_at_rest,
    rolling_series,
    sine_cosine,
)
from warprock.kernels.housner.body_weight import Heave, heave_after, heave_at
from warprock.kernels.modes import OVERTURNED, RESTING, ROCKING
from warprock.kernels.motion import Motion, knot_time, series
from warprock.kernels.shape.above import Above
from warprock.kernels.shape.taylor import slope_at, value_at


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
class Foot:
    """A point of the base; the symbols are those of housner/body_series.py."""

    alpha: real
    reach: real
    p2: real
    q: real
    rho: real
    eps: real
    low: real
    high: real


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
def watched(
    resting: bool, upper: bool, limit: real, per: real, pull: real, theta: real, foot: Foot,
    omega: real, t2: real, t3: real, t4: real, t5: real, t6: real, t7: real, t8: real, t9: real,
    t10: real,
    a0: real, a1: real, a2: real, a3: real, a4: real, a5: real, a6: real, a7: real, a8: real,
    z: Heave, h: real,
):  # fmt: skip
    """First event within a step of length h; as `next_event`.

    Watched is how far the rotation is from the upper or the lower end of the foot's range; at rest
    what a pull of the base lacks to the limit, which is `per` vertical acceleration larger where
    the base moves upwards.
    """
    zero = real(0.0)
    s = wp.where(upper, real(-1.0), real(1.0))
    e0 = wp.where(upper, foot.high - theta, theta - foot.low)
    l0, l1, l2, l3, l4 = limit - pull * a0, -pull * a1, -pull * a2, -pull * a3, -pull * a4
    l5, l6, l7, l8 = -pull * a5, -pull * a6, -pull * a7, -pull * a8
    if VERTICAL:
        l0, l1, l2, l3 = l0 + per * z.z0, l1 + per * z.z1, l2 + per * z.z2, l3 + per * z.z3
        l4, l5, l6, l7 = l4 + per * z.z4, l5 + per * z.z5, l6 + per * z.z6, l7 + per * z.z7
        l8 = l8 + per * z.z8
    e0 = wp.where(resting, l0, e0)
    tau, turned, crossed, cap = next_event(
        e0,
        wp.where(resting, l1, s * omega),
        wp.where(resting, l2, s * t2),
        wp.where(resting, l3, s * t3),
        wp.where(resting, l4, s * t4),
        wp.where(resting, l5, s * t5),
        wp.where(resting, l6, s * t6),
        wp.where(resting, l7, s * t7),
        wp.where(resting, l8, s * t8),
        wp.where(resting, zero, s * t9),
        wp.where(resting, zero, s * t10),
        h,
        False,
    )
    # A jump of the acceleration lifts a resting body, round-off sinks a rocking one: at once.
    a_end = value_at(a0, a1, a2, a3, a4, a5, a6, a7, a8, zero, zero, h)
    lack = limit - pull * a_end
    if VERTICAL:
        lack = lack + per * heave_after(z, h)
    lifts = e0 < -NEARLY * size(limit) or (e0 <= zero and lack < zero)
    at_once = wp.where(resting, lifts, e0 < zero)
    return (
        wp.where(at_once, zero, tau),
        turned and not at_once,
        crossed or at_once,
        wp.where(at_once, NEVER, cap),
    )


@wp.func
def weaker_hold(edge: Edge, gravity: real, a0: real, a_end: real, z0: real, z_end: real):
    """The pull, 1 to +x or -1, that is nearer to lifting a body off an edge, and its limit.

    The third value is what the limit grows by per vertical acceleration of the base.
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
    return wp.where(to_left, real(1.0), real(-1.0)), hold + slack + zero, hold / gravity


@wp.func
def towards(foot: Foot, theta: real, omega: real, t2: real, t3: real, h: real) -> bool:
    """Whether the upper end of a foot's range is watched, not the lower one.

    It is the end that a step starts at, else the one that the body moves towards.
    """
    still = wp.where(size(t2) > NEARLY * size(t3) * h, t2, t3)
    moves = wp.where(omega == real(0.0), still, omega)
    return theta == foot.high or (theta != foot.low and moves > real(0.0))


@wp.func
def event_step(
    body: Body, edge: Edge, impact: bool, uplift: bool, upper: bool, pull: real,
    acceleration: real, lifting: real, time: real,
    omega: real, place: int, mode: int, uplift_time: real, rest_time: real, loss: real,
    needed: real,
):  # fmt: skip
    """What an impact on an edge, or an uplift from one, does to a body."""
    zero = real(0.0)
    kept = larger(wp.where(upper, edge.kept_right, edge.kept_left), zero)
    before = wp.where(upper, edge.inertia_left, edge.inertia_right)
    behind = wp.where(upper, edge.inertia_right, edge.inertia_left)
    slip = wp.where(upper, edge.slip_right, edge.slip_left)
    after = kept * omega
    stays, tail = may_rest(
        edge, body.rest_rotation, after, acceleration, lifting, body.gravity
    )  # fmt: skip
    # A body that keeps nothing stays on both feet; what moves it from there is an uplift.
    rests = impact and (stays or kept == zero)
    after = wp.where(rests, zero, after)
    # At rest the place is that of the foot at -x of the edge.
    struck = wp.where(upper, wp.where(rests, place, place + 1), place - 1)
    lifted = wp.where(pull > zero, place, place + 1)
    return (
        wp.where(impact, after, omega),
        wp.where(uplift, lifted, wp.where(impact, struck, place)),
        wp.where(rests, RESTING, wp.where(uplift, ROCKING, mode)),
        wp.where(uplift, smaller(uplift_time, time), uplift_time),
        wp.where(rests, time + wp.where(stays, tail, zero), wp.where(uplift, NEVER, rest_time)),
        loss + wp.where(impact, before * omega * omega - behind * after * after, zero),
        wp.where(impact, larger(slip, needed), needed),
    )


@wp.func
def motion_step(
    body: Body, foot: Foot, edge: Edge, passed: bool, dv: real, dz: real, time: real,
    theta: real, omega: real, place: int, mode: int, uplift_time: real, rest_time: real,
    needed: real,
):  # fmt: skip
    """What a velocity step of the base at a knot, dv along and dz upwards, does to a body."""
    zero = real(0.0)
    steps = passed and (dv != zero or dz != zero)
    s, c = sine_cosine(theta - foot.alpha)
    kick = -(foot.rho + foot.q * c) / (real(1.0) + foot.eps * c) * dv
    off = -wp.where(dv > zero, edge.pull_left, edge.pull_right) * dv
    to_right = dv < zero
    off_along, off_upwards = real(dv), real(dz)
    if VERTICAL:
        kick = kick + foot.q * s / (real(1.0) + foot.eps * c) * dz
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
    rocks = steps and mode == ROCKING
    lifts = steps and mode == RESTING and not rests
    if VERTICAL:
        lifts = lifts and off != zero
    omega1 = wp.where(rocks, omega + kick, wp.where(lifts, off, omega))
    # Thrown back where a foot has just come down, the body turns about the one that it left.
    place1 = wp.where(rocks and theta == foot.high and omega1 > zero, place + 1, place)
    place1 = wp.where(rocks and theta == foot.low and omega1 < zero, place - 1, place1)
    place1 = wp.where(lifts and to_right, place + 1, place1)
    along = dv + (body.radius + foot.reach * c) * kick
    falls = (theta >= body.fall_right and omega >= zero) or (
        theta <= -body.fall_left and omega <= zero
    )
    asked = ratio(along, -foot.reach * s * kick)
    counts = rocks and not falls
    if VERTICAL:
        asked = ratio(along, dz - foot.reach * s * kick)
        asked = wp.where(lifts, ratio(off_along, off_upwards), asked)
        counts = counts or lifts
    return (
        omega1,
        place1,
        wp.where(lifts, ROCKING, mode),
        wp.where(lifts, smaller(uplift_time, time), uplift_time),
        wp.where(lifts, NEVER, rest_time),
        wp.where(counts and asked > needed, asked, needed),
    )


@wp.func
def overshot(live: bool, excess: real, omega: real, tau: real, cap: real):
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
def step_friction(
    body: Body, foot: Foot, resting: bool, rocking: bool, needed: real, theta: real, omega: real,
    end_omega: real, tau: real,
    t2: real, t3: real, t4: real, t5: real, t6: real, t7: real, t8: real,
    c2: real, c3: real, c4: real, c5: real, c6: real, c7: real, c8: real,
    s2: real, s3: real, s4: real, s5: real, s6: real, s7: real, s8: real,
    a0: real, a1: real, a2: real, a3: real, a4: real, a5: real, a6: real, z: Heave,
) -> real:  # fmt: skip
    """The larger of a friction and what a step of length tau needs."""
    n0, n1, n2, n3, n4, n5, n6, f0, f1, f2, f3, f4, f5, f6 = force_series(
        body.gravity, body.radius, foot.reach, t2, t3, t4, t5, t6, t7, t8,
        c2, c3, c4, c5, c6, c7, c8, s2, s3, s4, s5, s6, s7, s8, a0, a1, a2, a3, a4, a5, a6, z,
    )  # fmt: skip
    side = sign_of(theta)
    fall = wp.where(theta < real(0.0), body.fall_left, body.fall_right)
    held = friction_at_rest(body.gravity, needed, tau, a0, a1, a2, a3, a4, a5, a6, z)
    return needed_in_step(
        wp.where(resting and tau > real(0.0), held, needed), rocking, fall, side * theta,
        side * omega, side * end_omega, tau,
        n0, n1, n2, n3, n4, n5, n6, f0, f1, f2, f3, f4, f5, f6,
    )  # fmt: skip


@wp.func
def advance(
    body: Body, foot: Foot, behind: Edge, last: int,
    m: Motion, sample: real, sample_slope: real, above: Above, until: real,
    theta: real, omega: real, place: int, time: real, segment: int, mode: int, cap: real,
    needed: real,
):  # fmt: skip
    """The way of one lane to its next event, or at most to `until`.

    `behind` is the edge behind the foot, on which a body at rest lies; `last` the last foot.

    Returns:
        Rotation, its rate and the time at the end; the base acceleration there, along and upwards;
        whether the event
        is at the upper end of the foot's range; the pull that lifts a body at rest; whether it
        strikes the next foot, and whether it is lifted; the longest step allowed next time; the
        friction needed.
    """
    zero = real(0.0)
    live, resting, rocking = mode < OVERTURNED, mode == RESTING, mode == ROCKING
    target = smaller(knot_time(m, segment), until)
    if VERTICAL:
        target = smaller(knot_time(above.motion, above.segment), target)
    room = target - time
    h = smaller(smaller(smaller(body.step_length, REACH / size(omega)), room), cap)
    h = wp.where(live, larger(h, zero), zero)
    a0, a1, a2, a3, a4, a5, a6, a7, a8 = series(m, segment, time, sample, sample_slope)
    z = heave_at(above.motion, above.segment, time, above.value, above.slope)
    (
        t2, t3, t4, t5, t6, t7, t8, t9, t10,
        c2, c3, c4, c5, c6, c7, c8, s2, s3, s4, s5, s6, s7, s8,
    ) = rolling_series(
        foot.p2, foot.q, foot.rho, foot.eps, theta - foot.alpha, omega, z,
        a0, a1, a2, a3, a4, a5, a6, a7, a8,
    )  # fmt: skip
    upper = resting or towards(foot, theta, omega, t2, t3, h)
    a_end = value_at(a0, a1, a2, a3, a4, a5, a6, a7, a8, zero, zero, h)
    pull, limit, per = weaker_hold(behind, body.gravity, a0, a_end, z.z0, heave_after(z, h))
    tau, turned, crossed, cap1 = watched(
        resting, upper, limit, per, pull, theta, foot,
        omega, t2, t3, t4, t5, t6, t7, t8, t9, t10, a0, a1, a2, a3, a4, a5, a6, a7, a8, z, h,
    )  # fmt: skip
    theta1 = value_at(theta, omega, t2, t3, t4, t5, t6, t7, t8, t9, t10, tau)
    omega1 = slope_at(omega, t2, t3, t4, t5, t6, t7, t8, t9, t10, tau)
    excess = wp.where(upper, foot.low - theta1, theta1 - foot.high)
    past, tau, cap1 = overshot(live, wp.where(rocking, excess, zero), omega1, tau, cap1)
    needed1 = step_friction(
        body, foot, resting, rocking, needed, theta, omega, omega1, tau, t2, t3, t4, t5, t6, t7, t8,
        c2, c3, c4, c5, c6, c7, c8, s2, s3, s4, s5, s6, s7, s8, a0, a1, a2, a3, a4, a5, a6, z,
    )  # fmt: skip
    reaches = rocking and crossed and not past
    end = wp.where(upper, foot.high, foot.low)
    strikes = wp.where(upper, place < last, place > 0)
    return (
        wp.where(rocking and not past, wp.where(reaches, end, theta1), theta),
        wp.where(past, omega, wp.where(rocking and not turned, omega1, zero)),
        wp.where(live and tau >= room - TICK * target, target, time + tau),
        value_at(a0, a1, a2, a3, a4, a5, a6, a7, a8, zero, zero, tau), heave_after(z, tau),
        upper, pull, reaches and strikes, resting and crossed, cap1, needed1,
    )  # fmt: skip
