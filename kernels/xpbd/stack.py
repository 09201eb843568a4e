"""Position-level contact step of a stack of rocking blocks (XPBD).

Bodies are numbered from the ground: body 0 is the ground, an endless flat face that nothing moves,
body k the k-th block. Interface k, below block k, touches at the two ends of the overlap of the
upper block's bottom face and the lower one's top face, see shape/interface.py. Here an `Impulse`
holds a multiplier [kg m], an impulse times the length of a sub-step. A `Velocity` holds a
correction of a pose [m], [rad], a velocity times that length.

One sub-step of length h:

    1. predict: velocity v* = v + h (0, -g) - (dv_base, 0) and pose q* = q + h v*;
    2. the ends whose gap at q is at most g h^2, the fall in one step, are contacts. Their gaps and
       their places along the faces are taken exactly at q and at q*, their gradients J at q;
    3. both passes are `iterations` Gauss-Seidel sweeps over the contacts. Each contact corrects the
       two bodies of its interface by M^-1 J^T times its multipliers n, t [kg m] (impulses are
       n / h, t / h). Both passes share the rows and differ in the conditions:
           velocity pass:  growth of the gap from q = 0,  slip from q = 0
           pose pass:      gap + (alpha / h^2) n = 0,     distance from the anchor = 0
       each >= 0 with n = 0 if the contact opens, and |t| <= mu n. alpha is the compliance of one
       contact [m/N]. The velocity pass starts from its last multipliers, the pose pass from the new
       ones of the velocity pass;
    4. v(n + 1) = v* + correction of the velocity pass / h, q(n + 1) = q* + that of the pose pass.

The velocity pass makes the restitution zero: without it v would be (q(n + 1) - q(n)) / h. It comes
first so that its multipliers are a start for the pose pass; neither pass depends on the result of
the other. The anchor is the place where an end came to stick. An end loses it when it slips in the
pose pass or opens.

Why this converges to rigid contact, at first order:

- Growth and slip are differences of exact poses, so that v is the chord of the motion, and J is
  taken where the force acts. So between impacts both passes agree, and the scheme is SHAKE, of
  second order. (With J at q* it would be of first order everywhere. With J v for the growth of a
  gap, a rotation about a corner would be braked in every step.)
- At an impact a corner penetrates the face, since it is no contact until the next sub-step. The
  pose pass of that sub-step pushes it out by M^-1 J^T, to the pose of a block that had met the face
  in time. Divided by h this push would be a velocity that does not vanish with h, a bounce. The
  velocity pass applies only the plastic impulse, which is Housner's.
- The remaining error is of the order of h: the old corner carries until the end of the sub-step of
  the impact, wherever in it the impact is. That is half a sub-step too long or too short, and
  nothing in the mean. (If a corner stopped at the face, it would take over a sub-step too early in
  the mean.)
- Compliance changes poses and not velocities, so impacts are plastic at any compliance. At rest the
  penetration of an end is alpha times its force. It gets there like an overdamped spring, in a time
  of about alpha m / h. So a contact is the more rigid the smaller h is, and both limits, h -> 0 and
  alpha -> 0, may be taken in any order.
- Sweeps that end early leave gaps and slips. The next step corrects them, because gaps are absolute
  and an end that sticks keeps its anchor. (With slip counted from the start of each sub-step alone,
  tall stacks creep and their errors grow.)

Macklin, Mueller and Chentanez (2016) for compliance, Macklin et al. (2019) for sub-steps, Mueller
et al. (2020) for rigid bodies and the velocity pass; Ryckaert, Ciccotti and Berendsen (1977) for
SHAKE.
"""

import warp as wp

from warprock.kernels.contact.cone import solve_single_contact
from warprock.kernels.lane.account import Account
from warprock.kernels.shape.interface import Impulse, Mass, Point, Pose, Velocity
from warprock.kernels.xpbd.stack_pair import Contact, Coupling, End, Grip

if BLOCKS == 1:
    from warprock.kernels.xpbd.stack_ground import TURNS, gap_and_slip
else:
    from warprock.kernels.xpbd.stack_pair import TURNS, gap_and_slip

LOOSE = real(1.0e30)
"""Anchor of an end without one: it has slipped or opened."""


@wp.struct
class Knobs:
    """Settings of a step; `rate` is the inverse of the time step [1/s].

    `softness` is the compliance over the square of the time step [1/kg].
    """

    time_step: real
    rate: real
    gravity: real
    softness: real


@wp.struct
class Ahead:
    """Sine and cosine of the predicted rotation of a body."""

    s: real
    c: real


@wp.struct
class Spot:
    """Gap of an end, and place of the upper block along what it touches there [m]."""

    gap: real
    place: real


@wp.func
def side_of(turn: real, rate: real, hint: real, before: real) -> real:
    """Side to which an interface leans, -1 or 1.

    The first of these numbers that is not zero decides.

    Args:
        turn: Rotation of the block relative to the one below [rad].
        rate: Rate of that [rad/s].
        hint: Present or next gain of the base velocity [m/s].
        before: Side to which the interface leaned before.
    """
    zero = real(0.0)
    still = wp.where(hint != zero, -hint, before)
    return sign_of(wp.where(turn != zero, turn, wp.where(rate != zero, rate, still)))


@wp.func
def swap_anchors_unless(same: bool, one: wp.ref[real], two: wp.ref[real]):
    """Swaps two anchors, unless the order of the ends is the same."""
    place = real(one)
    one = wp.where(same, place, two)
    two = wp.where(same, two, place)


@wp.func
def predict(v: Velocity, dv: real, knobs: Knobs) -> Velocity:
    """Velocity of a block after a step without contact in which the base gains dv [m/s]."""
    return Velocity(v.x - dv, fused_less(knobs.time_step, knobs.gravity, v.z), v.omega)


@wp.func
def turn_ahead(dt: real, at: Pose, omega: real) -> Ahead:
    """The predicted rotation of a block a time step later."""
    turned = fused(dt, omega, at.theta)
    return Ahead(sine(in_range(turned)), cosine(in_range(turned)))


@wp.func
def pose_ahead(dt: real, at: Pose, below: Pose, u: Velocity, v: Velocity, ahead: Ahead) -> Pose:
    """The predicted pose of a block, from the centre of the body below.

    Only the sine and the cosine of its rotation are set.

    Args:
        dt: Time step [s].
        at, below: Poses of both at the start of the step.
        u, v: Their predicted velocities.
        ahead: Predicted rotation of the block.
    """
    dx = fused(dt, u.x - v.x, at.x - below.x)
    return Pose(dx, fused(dt, u.z - v.z, at.z - below.z), real(0.0), ahead.s, ahead.c)


@wp.func
def below_ahead(ahead: Ahead) -> Pose:
    """The predicted pose of the body below, in the same frame."""
    zero = real(0.0)
    return Pose(zero, zero, zero, ahead.s, ahead.c)


@wp.func
def without_tiny(value: real) -> real:
    """A number, or zero if it is below `TINY`: subnormal numbers are slow."""
    return wp.where(size(value) < TINY, real(0.0), value)


@wp.func
def closes(knobs: Knobs, gap: real) -> bool:
    """Whether an end is a contact: the fall in one step closes its gap."""
    return gap <= knobs.gravity * knobs.time_step * knobs.time_step


@wp.func
def warm_start(closed: bool, last: Impulse) -> Impulse:
    """First guess of the multipliers of an end: the last ones if it is a contact, else zero."""
    on = wp.where(closed, real(1.0), real(0.0))
    return Impulse(on * last.n, on * without_tiny(last.t))


@wp.func
def find_contact(
    knobs: Knobs, up: Mass, low: Mass, point: Point, now: Spot, then: Spot, anchor: real
):
    """The conditions of an end in the velocity pass and in the pose pass, and its anchor.

    Args:
        knobs: Settings.
        up, low: Masses of the upper and of the lower body.
        point: The end at the start of the step.
        now, then: Its gap and place at the start, and predicted ones.
        anchor: Its anchor; an end without one gets the present place.
    """
    closed = closes(knobs, now.gap)
    on = wp.where(closed, real(1.0), real(0.0))
    place = wp.where(closed and size(anchor) < LOOSE, anchor, now.place)
    normal = fused(low.j * point.al, point.al, fused(up.j * point.au, point.au, up.m + low.m))
    dt = on / fused(low.j * point.bl, point.bl, fused(up.j * point.bu, point.bu, up.m + low.m))
    return (
        Contact(then.gap - now.gap, then.place - now.place, on / normal),
        Contact(then.gap, then.place - place, on / (normal + knobs.softness)),
        Grip(dt, place),
    )


@wp.func
def solve(mu: real, k: Coupling, first: End, second: End, u: Velocity, v: Velocity):
    """TURNS sweeps over the multipliers of an interface; a single contact is solved exactly.

    Args:
        mu: Friction coefficient.
        k: Coupling of the multipliers of both ends of the interface.
        first, second: These ends.
        u, v: Corrections of the upper and of the lower body.

    Returns:
        The multipliers of the first end, and those of the second.
    """
    dn1, dt1, dn2, dt2 = first.contact.dn, first.dt, second.contact.dn, second.dt
    a = real(first.last.n)
    b = real(first.last.t)
    e = real(second.last.n)
    f = real(second.last.t)
    # Gaps and slips without these four multipliers, each over its diagonal element.
    gap1, slip1 = gap_and_slip(first, u, v)
    gap2, slip2 = gap_and_slip(second, u, v)
    u1 = -dn1 * less_three(fused_less(k.n1n1, a, gap1), k.n1t1, b, k.n1n2, e, k.n1t2, f)
    s1 = -dt1 * less_three(fused_less(k.n1t1, a, slip1), k.t1t1, b, k.t1n2, e, k.t1t2, f)
    u2 = -dn2 * less_three(fused_less(k.n1n2, a, gap2), k.t1n2, b, k.n2n2, e, k.n2t2, f)
    s2 = -dt2 * less_three(fused_less(k.n1t2, a, slip2), k.t1t2, b, k.n2t2, e, k.t2t2, f)
    a1, a2, a3 = dn1 * k.n1t1, dn1 * k.n1n2, dn1 * k.n1t2
    b1, b2, b3 = dt1 * k.n1t1, dt1 * k.t1n2, dt1 * k.t1t2
    c1, c2, c3 = dn2 * k.n1n2, dn2 * k.t1n2, dn2 * k.n2t2
    d1, d2, d3 = dt2 * k.n1t2, dt2 * k.t1t2, dt2 * k.n2t2
    only_one, only_two = dn2 <= real(0.0), dn1 <= real(0.0)
    n, t = solve_single_contact(
        mu, wp.where(only_one, a1, c3), wp.where(only_one, b1, d3), wp.where(only_one, u1, u2),
        wp.where(only_one, s1, s2),
    )  # fmt: skip
    # The value that is known last comes last in each row, so that other terms need not wait for it.
    for _ in range(TURNS):
        a = larger(less_three(u1, a1, b, a2, e, a3, f), real(0.0))
        b = larger(smaller(less_three(s1, b2, e, b3, f, b1, a), mu * a), -mu * a)
        e = larger(less_three(u2, c3, f, c1, a, c2, b), real(0.0))
        f = larger(smaller(less_three(s2, d1, a, d2, b, d3, e), mu * e), -mu * e)
    one = Impulse(wp.where(only_one, n, a), wp.where(only_one, t, b))
    return one, Impulse(wp.where(only_two, n, e), wp.where(only_two, t, f))


@wp.func
def integrate(live: bool, dt: real, at: Pose, u: Velocity, lift: Velocity) -> Pose:
    """The pose of a block after a step, if its lane still runs.

    Args:
        live: Whether it does.
        dt: Time step [s].
        at: Pose of the block before.
        u: Its predicted velocity.
        lift: Correction of its predicted pose.
    """
    theta = wp.where(live, at.theta + fused(dt, u.omega, lift.omega), at.theta)
    turned = in_range(theta)
    return Pose(
        wp.where(live, at.x + fused(dt, u.x, lift.x), at.x),
        wp.where(live, at.z + fused(dt, u.z, lift.z), at.z),
        theta, sine(turned), cosine(turned),
    )  # fmt: skip


@wp.func
def add_energy(
    live: bool, knobs: Knobs, dv: real, mass: Mass, u: Velocity, push: Velocity, lift: Velocity,
    account: wp.ref[Account],
):  # fmt: skip
    """Adds a step of a block to the energy account of its lane.

    The loss [J] grows by the energy that contacts take: minus their work on the mean velocity of
    the step, less the potential energy by which the pose pass lifts the block. The work of the base
    [J] is added, too.

    Args:
        live: Whether its lane still runs.
        knobs: Settings.
        dv: Gain of the base velocity in the step [m/s].
        mass: Mass of the block.
        u: Its predicted velocity.
        push: Correction of that, times the time step.
        lift: Correction of its predicted pose.
        account: Account of the lane.
    """
    # Change of the velocity by contacts, times the sum of the velocities before and after.
    px = knobs.rate * push.x
    pz = knobs.rate * push.z
    po = knobs.rate * push.omega
    along = u.x + dv + u.x + px
    upwards = fused(knobs.time_step, knobs.gravity, u.z + u.z + pz)
    linear = HALF * dot(px, pz, along, upwards)
    angular = HALF * po * (u.omega + u.omega + po)
    done = fused(knobs.gravity, lift.z - push.z, linear) / mass.m + angular / mass.j
    account.loss = account.loss - wp.where(live, done, real(0.0))
    account.work = account.work - wp.where(live, HALF * dv * along / mass.m, real(0.0))


@wp.func
def correct(rate: real, u: Velocity, push: Velocity) -> Velocity:
    """Velocity of a block after a step, from the predicted one and its correction."""
    return Velocity(
        without_tiny(u.x + rate * push.x),
        without_tiny(u.z + rate * push.z),
        without_tiny(u.omega + rate * push.omega),
    )


@wp.func
def anchor_after(mu: real, pose: Impulse, anchor: real) -> real:
    """Anchor of an end after a step, from the multipliers of the pose pass: none if it slips."""
    return wp.where(size(pose.t) < mu * pose.n, anchor, LOOSE)
