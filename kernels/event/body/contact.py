"""Contact of a body on contact points with its base: exact small solves.

As in event/block/contact.py the mass is 1, the rotation clockwise, and w the inverse inertia
[1/m^2]; the corners are those of shape/body.py, and nothing is reflected. A corner may be rounded:
(x, z) is then the centre of its arc, which touches the base a radius r below it. The velocity of
the point of contact is

    along the base    vx + omega (Z - r),
    upwards           vz - omega X,

(X, Z) the turned (x, z). The second does not contain r, since the arc rolls: the place of the
centre of an arc that does not slide grows by r theta along the base.
"""

import warp as wp

from warprock.kernels.event.block.contact import SOON, Contact, Lever, Velocity, corner_impulse
from warprock.kernels.event.body.weight import Weight
from warprock.kernels.lane.modes import FLAT, FLYING, PIVOTING


@wp.struct
class Body:
    """One lane's body, of mass 1, its start, and its longest step.

    Attributes:
        inertia, inverse_inertia: About the centre of mass [m^2], [1/m^2].
        friction: Coefficient of friction.
        radius: Of its rounded corners [m].
        restitution: Angular velocity after over that before an impact in which the body rocks over
            the edge that it stands on at first; negative if the law of contact finds it.
        rebound, expansion, slow: Of corners that strike the base: normal restitution by Newton's
            law and by Poisson's, one of them zero, and the speed up to which they do not bounce
            [m/s]. See event/body/bounce.py, which alone reads them.
        start, spin: Rotation [rad] and angular velocity [rad/s] at the start.
        rest_rotation: Swing below which the body rests [rad].
        longest_step: Longest step [s].
        step_limit: Largest number of steps.
    """

    inertia: real
    inverse_inertia: real
    friction: real
    radius: real
    restitution: real
    rebound: real
    expansion: real
    slow: real
    start: real
    spin: real
    rest_rotation: real
    longest_step: real
    step_limit: int


@wp.struct
class Edge:
    """An edge that lies flat: its ends and the base from the centre of mass [m]."""

    left: real
    right: real
    height: real


@wp.func
def flat_friction(mu: real, slip: real, ux: real, uz: real) -> real:
    """Impulse of friction on a body on an edge [m/s], from its velocities without contact [m/s]."""
    bound = -mu * uz
    held = larger(smaller(-ux, bound), -bound)
    return wp.where(slip != real(0.0), -slip * bound, held)


@wp.func
def tips_right(mu: real, slip: real, edge: Edge, ux: real, uz: real) -> bool:
    """Whether the centre of pressure of an edge is nearer to its end at +x than to the other."""
    moment = -edge.height * flat_friction(mu, slip, ux, uz)
    presses = TWO * moment >= -uz * (edge.left + edge.right)
    # The end ahead can jam even if nothing presses the edge on the base.
    return wp.where(uz < real(0.0), presses, ux >= real(0.0))


@wp.func
def hold_reserve(body: Body, gravity: real, slip: real, at: Lever, omega: real, a: real):
    """Margin of the force at a pivoting corner until it slides; of a sliding one until it leaves.

    See event/block/contact.py.

    Args:
        body: The body.
        gravity: [m/s^2].
        slip: Direction of sliding, 0 where the corner sticks.
        at: The point of contact.
        omega: Angular velocity [rad/s].
        a: Acceleration of the base [m/s^2].

    Returns:
        The reserve [m/s^2]; whether it is surely positive.
    """
    # Of a rounded corner the centre of its arc is what turns; the point of contact moves over it.
    u = -gravity - omega * omega * (at.z + body.radius)
    s = -a - omega * omega * at.x
    # The impulses that take both to zero, times 1 + w (x^2 + z^2).
    q = body.inverse_inertia * (at.x * s + at.z * u)
    n = -u - at.z * q
    f = -s - at.x * q
    slides = slip != real(0.0)
    grip = body.friction * n
    reserve = wp.where(slides, -u, grip - size(f))
    return reserve, reserve > SOON * wp.where(slides, gravity, grip)


@wp.func
def bounds(body: Body, edge: Edge):
    """Accelerations of the base, over the weight, to -x and to +x that let a body on an edge go."""
    per = real(1.0) / edge.height
    return smaller(body.friction, edge.right * per), smaller(body.friction, -edge.left * per)


@wp.func
def least_lack(body: Body, weight: Weight, edge: Edge, a0: real, a1: real) -> real:
    """Smallest lack at the ends of a step (event/lift.py) of the acceleration of the base [m/s^2].

    Args:
        body: The body.
        weight: Its weight in the step.
        edge: The edge it lies on.
        a0, a1: Acceleration of the base at the start [m/s^2] and at the end.
    """
    back, ahead = bounds(body, edge)
    lack = smaller(weight.start * back + a0, weight.start * ahead - a0)
    lack1 = smaller(weight.end * back + a1, weight.end * ahead - a1)
    return smaller(lack, lack1)


@wp.func
def mean_velocity(
    body: Body, contact: Contact, hold: bool, edge: Edge, at: Lever, free: Velocity
):  # fmt: skip
    """Mean velocity of a step and the contact that makes it.

    Args:
        body: The body.
        contact: How it touches its base at the start.
        hold: Whether a pivoting corner sticks, however large the force that holds it.
        edge: The edge it lies on, if it is flat.
        at: The point of contact in the middle of the step.
        free: Mean velocity without contact.

    Returns:
        Mean velocity; contact in the step; energy lost to friction per unit mass [J/kg].
    """
    zero = real(0.0)
    w = body.inverse_inertia
    mode, slip = contact.mode, contact.slip
    slides = slip != zero
    n, f, sticks, drag = corner_impulse(
        body.friction, w, at, free.z - free.omega * at.x, free.x + free.omega * at.z, hold, slides,
        -slip,
    )  # fmt: skip
    presses, held = n > zero, sticks and n >= zero
    on = mode != FLYING and (presses or hold or held)
    n = wp.where(on, n, zero)
    f = wp.where(on, f, zero)
    flat_f = flat_friction(body.friction, slip, free.x, free.z)
    moment = -edge.height * flat_f
    below, above = moment <= -free.z * edge.right, moment >= -free.z * edge.left
    stays = mode == FLAT and below and above
    starts = size(free.x) > -body.friction * free.z
    mx = free.x + wp.where(stays, flat_f, f)
    mo = wp.where(stays, zero, free.omega + w * (f * at.z - n * at.x))
    flat_slip = wp.where(slides, slip, wp.where(starts, sign_of(free.x), zero))
    pivot_slip = wp.where(sticks or not on, zero, -drag)
    lost = -wp.where(stays, flat_f * mx, f * (mx + mo * at.z))
    return (
        Velocity(mx, wp.where(stays, zero, free.z + n), mo),
        Contact(
            wp.where(stays, FLAT, wp.where(on, PIVOTING, FLYING)),
            wp.where(stays, flat_slip, pivot_slip),
        ),
        TWO * lost,
    )


@wp.func
def held_velocity(body: Body, contact: Contact, at: Lever, free: Velocity) -> Velocity:
    """Velocity at the end of a step, projected on its contact along the contact's force.

    Args:
        body: The body.
        contact: How it touches its base.
        at: The point of contact.
        free: Velocity before.
    """
    zero = real(0.0)
    w = body.inverse_inertia
    sticks, lies = contact.slip == zero, contact.mode == FLAT
    n, f, _sticks, _drag = corner_impulse(
        body.friction, w, at, free.z - free.omega * at.x, free.x + free.omega * at.z, sticks,
        not sticks, -contact.slip,
    )  # fmt: skip
    pivots = contact.mode == PIVOTING
    return Velocity(
        wp.where(lies and sticks, zero, free.x + wp.where(pivots, f, zero)),
        free.z + wp.where(pivots, n, zero),
        free.omega + wp.where(pivots, w * (f * at.z - n * at.x), zero),
    )


@wp.func
def law_velocity(body: Body, beside: bool, at: Lever, other: real, before: Velocity):
    """Velocity after an inelastic impact that the law of contact finds.

    With two corners at the base the impact is on one of them, or on both if the other would sink
    into the base then. The one is the first corner, or the second if laying both flat would need a
    pull at the first. More than one of these impacts obeys the law only where friction can jam a
    corner.

    Args:
        body: The body.
        beside: Whether a second corner is at the base.
        at: The point of contact of the first corner.
        other: x of the second one, as high as the first, from the centre of mass [m].
        before: Velocity before.

    Returns:
        Velocity, mode, whether the point of contact sticks, whether the second corner is struck.
    """
    zero = real(0.0)
    w = body.inverse_inertia
    ux, uz, uo, z = before.x, before.z, before.omega, at.z
    press = larger(-uz, zero)
    flat_f = flat_friction(body.friction, zero, ux, -press)
    # The impulse at the first corner if both are struck, times the length of the edge: a pull if
    # negative.
    share = (flat_f * z + body.inertia * uo - press * other) * (at.x - other)
    second = beside and share < zero
    x, apart = wp.where(second, other, at.x), wp.where(second, at.x, other)
    n, f, sticks, _drag = corner_impulse(
        body.friction, w, Lever(x, z), uz - uo * x, ux + uo * z, False, False, zero
    )
    if VERTICAL:
        # A base that is kicked downwards leaves what stands on it.
        leaves = uz - uo * x > zero and not (sticks and n > zero)
        n, f = wp.where(leaves, zero, n), wp.where(leaves, zero, f)
    vo = uo + w * (f * z - n * x)
    vx = ux + f
    vz = uz + n
    # Both corners at the base: the other one must not sink.
    sinks = vz - vo * apart <= zero
    both = beside and sinks
    vx = wp.where(both, ux + flat_f, vx)
    vz = wp.where(both, zero, vz)
    vo = wp.where(both, zero, vo)
    mode = wp.where(both, FLAT, PIVOTING)
    if VERTICAL:
        mode = wp.where(leaves and not both, FLYING, mode)
    return Velocity(vx, vz, vo), mode, wp.where(both, vx == zero, sticks), second and not both


@wp.struct
class Blow:
    """More about an impact.

    Attributes:
        second: Whether the second corner is struck.
        lost: Energy lost per unit mass [J/kg].
        needed: Friction that a prescribed impact needs; NEVER where the base would have to pull,
            and zero where none is prescribed.
    """

    second: bool
    lost: real
    needed: real


@wp.struct
class Turn:
    """Angular velocity that a prescribed restitution leaves after an impact.

    Attributes:
        follows: Whether the impact is the prescribed one, not that of the law of contact.
        omega: The angular velocity [rad/s].
        needed: Friction that it needs, see `Blow`.
    """

    follows: bool
    omega: real
    needed: real


@wp.func
def prescribed_turn(
    body: Body, given: bool, held: bool, at: Lever, law: Velocity, before: Velocity
) -> Turn:
    """The impact that a prescribed restitution asks for, see `struck_velocity`.

    Args:
        body: The body.
        given: Whether the restitution is that of this impact.
        held: Whether the law of contact finds that the first corner sticks.
        at: The point of contact of the first corner.
        law: Velocity after the impact by that law.
        before: Velocity before.
    """
    zero, one = real(0.0), real(1.0)
    ux, uz, uo, x, z = before.x, before.z, before.omega, at.x, at.z
    # A body that slides as it comes down can turn faster than its energy allows after the impact.
    energy = ux * ux + uz * uz + body.inertia * uo * uo
    most = wp.sqrt(energy / (body.inertia + x * x + z * z))
    asked = larger(smaller(body.restitution * uo, most), -most)
    press = asked * x - uz
    grip = -asked * z - ux
    needed = wp.where(press > zero, size(grip) / press, NEVER)
    needed = wp.where(given, needed, zero)
    # The part of the way from the law's impulses to the prescribed ones that stays in the cone of
    # friction.
    spare = body.friction * press - size(grip)
    room = larger(body.friction * (law.z - uz) - sign_of(grip) * (law.x - ux), zero)
    part = wp.where(spare >= zero, one, wp.where(held, room / (room - spare), zero))
    part = wp.where(given and press > zero, part, zero)
    # The corner sticks: it is the angular velocity that lies between.
    turn = wp.where(spare >= zero, asked, law.omega + part * (asked - law.omega))
    return Turn(part > zero, turn, needed)


@wp.func
def struck_velocity(
    body: Body, beside: bool, prescribed: bool, at: Lever, other: real, before: Velocity
):  # fmt: skip
    """Velocity after an inelastic impact: a corner has landed or the base stepped its velocity.

    A prescribed restitution is the angular velocity after the impact over that before. The first
    corner sticks, and its impulses follow. If they need more friction than there is, the angular
    velocity lies between the one that the law of contact finds and the prescribed one, as near to
    the latter as friction allows. If the base would have to pull, or the body slides by the law of
    contact, the impact follows that law. No impact gains energy.

    Args:
        body: The body.
        beside: Whether a second corner is at the base.
        prescribed: Whether a prescribed restitution is that of this impact.
        at: The point of contact of the first corner.
        other: x of the second one, as high as the first, from the centre of mass [m].
        before: Velocity before.

    Returns:
        Velocity, contact, and more about the impact.
    """
    zero = real(0.0)
    ux, uz, uo, x, z = before.x, before.z, before.omega, at.x, at.z
    law, law_mode, sticks, second = law_velocity(body, beside, at, other, before)
    turn = Turn(False, law.omega, zero)
    if PRESCRIBED:
        is_given = body.restitution >= zero
        given = prescribed and is_given and law_mode != FLYING
        turn = prescribed_turn(body, given, sticks and not second, at, law, before)
    follows = turn.follows
    vx = wp.where(follows, -turn.omega * z, law.x)
    vz = wp.where(follows, turn.omega * x, law.z)
    vo = wp.where(follows, turn.omega, law.omega)
    along = vx + vo * z
    mode = wp.where(follows, PIVOTING, law_mode)
    still = follows or sticks or mode == FLYING
    lost = ux * ux + uz * uz - vx * vx - vz * vz + (uo * uo - vo * vo) * body.inertia
    contact = Contact(mode, wp.where(still, zero, sign_of(along)))
    return Velocity(vx, vz, vo), contact, Blow(second and not follows, HALF * lost, turn.needed)


@wp.func
def may_rest(body: Body, gravity: real, edge: Edge, omega: real, before: real, pull: real):
    """Whether the body rests on an edge after an impact, and the time of the omitted impacts.

    Args:
        body: The body.
        gravity: [m/s^2].
        edge: The edge.
        omega: Angular velocity after the impact [rad/s].
        before: Angular velocity before it [rad/s].
        pull: Horizontal force on the body per unit mass [m/s^2].

    Returns:
        Whether it rests; the time that the omitted impacts would take [s], 0 where it does not.
    """
    zero = real(0.0)
    square = body.inertia + edge.height * edge.height
    # Angular accelerations back to the edge, about either end.
    left = (-gravity * edge.left - pull * edge.height) / (square + edge.left * edge.left)
    right = (gravity * edge.right + pull * edge.height) / (square + edge.right * edge.right)
    weaker = smaller(left, right)
    slow = omega * omega <= TWO * weaker * body.rest_rotation
    rests = weaker > zero and slow
    # 2 |omega| (1 / left + 1 / right) / (2 (1 - |omega / before|)).
    fast = size(before)
    lost = larger(fast - size(omega), real(1.0e-6) * fast)
    tail = size(omega) * (left + right) * fast / (left * right * lost)
    return rests, wp.where(rests, tail, zero)
