"""Contact of a body on contact points with its base: exact small solves.

As event/block_contact.py, with corners (see shape/body.py) in the place of a rectangle's. Mass 1,
clockwise rotation, inverse inertia w [1/m^2]; nothing is reflected. A corner may be rounded: (x, z)
is then the centre of its arc, and it touches a radius r below that. The point that touches moves at

    along the base    vx + omega (Z - r),
    upwards           vz - omega X,

(X, Z) the turned (x, z). The second does not see r, so that the arc rolls: of a corner that does
not slide X + x of the centre of mass grows by r theta.
"""

import warp as wp

from warprock.kernels.event.block_contact import SOON, corner_impulse
from warprock.kernels.event.body_weight import Weight
from warprock.kernels.modes import FLAT, FLYING, PIVOTING


@wp.struct
class Body:
    """What a step needs to know of one lane's body, and how it is let go.

    It starts at a rotation `start` [rad] with the angular velocity `spin` [rad/s].

    `restitution` is the part of the angular velocity that is left where the body rocks over the
    edge that it stands on at first; negative where the law of contact finds it.
    """

    inertia: real
    inverse_inertia: real
    friction: real
    radius: real
    restitution: real
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
    """Friction of a body on an edge [m/s], from its velocities without contact."""
    bound = -mu * uz
    held = larger(smaller(-ux, bound), -bound)
    return wp.where(slip != real(0.0), -slip * bound, held)


@wp.func
def tips_right(mu: real, slip: real, edge: Edge, ux: real, uz: real) -> bool:
    """Whether the base presses an edge nearer to its end at +x than to the other one."""
    moment = -edge.height * flat_friction(mu, slip, ux, uz)
    return TWO * moment >= -uz * (edge.left + edge.right)


@wp.func
def hold_reserve(body: Body, gravity: real, slip: real, x: real, z: real, omega: real, a: real):
    """Margin of the force at a pivoting corner until it slides; of a sliding one until it leaves.

    See event/block_contact.py.

    Args:
        body: The body.
        gravity: [m/s^2].
        slip: Direction of sliding, 0 where the corner sticks.
        x, z: What touches from the centre of mass [m].
        omega: Angular velocity [rad/s].
        a: Acceleration of the base [m/s^2].

    Returns:
        The reserve; whether it is surely positive.
    """
    # Of an arc its centre is flung out: what touches moves on over the arc.
    u = -gravity - omega * omega * (z + body.radius)
    s = -a - omega * omega * x
    # The impulses that take both to zero, times 1 + w (x^2 + z^2).
    q = body.inverse_inertia * (x * s + z * u)
    n = -u - z * q
    f = -s - x * q
    slides = slip != real(0.0)
    grip = body.friction * n
    reserve = wp.where(slides, -u, grip - size(f))
    return reserve, reserve > SOON * wp.where(slides, gravity, grip)


@wp.func
def held_lack(
    body: Body, weight: Weight, edge: Edge, mode: int, mode1: int, slip: real, surely: bool,
    reserve: real, reserve1: real, a0: real, a1: real,
):  # fmt: skip
    """How far the force is from changing the contact of a body, at both ends of a step.

    Args:
        body: The body.
        weight: What weighs on it in the step.
        edge: The edge it lies on, if it is flat.
        mode, mode1: FLYING, PIVOTING or FLAT at the start and in the step.
        slip: Direction of sliding at the start, 0 where the body sticks.
        surely: Whether the reserve at the start is surely positive.
        reserve, reserve1: `hold_reserve` at the start and at the end.
        a0, a1: Acceleration of the base at the start [m/s^2] and at the end.

    Returns:
        Whether the start of the step holds it; the lack at the start and at the end.
    """
    per = real(1.0) / edge.height
    most = weight.start * smaller(body.friction, -edge.left * per)
    least = -weight.start * smaller(body.friction, edge.right * per)
    up = most - larger(a0, a1) < smaller(a0, a1) - least
    lack, lack1 = wp.where(up, most - a0, a0 - least), wp.where(up, most - a1, a1 - least)
    if VERTICAL:
        most1 = weight.end * smaller(body.friction, -edge.left * per)
        least1 = -weight.end * smaller(body.friction, edge.right * per)
        up = smaller(most - a0, most1 - a1) < smaller(a0 - least, a1 - least1)
        lack, lack1 = wp.where(up, most - a0, a0 - least), wp.where(up, most1 - a1, a1 - least1)
    rests = mode == FLAT and slip == real(0.0) and lack > -SOON * lack1
    corner = surely and not rests and (mode == PIVOTING or mode1 == PIVOTING)
    return rests or corner, wp.where(corner, reserve, lack), wp.where(corner, reserve1, lack1)


@wp.func
def mean_velocity(
    body: Body, mode: int, slip: real, hold: bool, edge: Edge, x: real, z: real,
    ux: real, uz: real, uo: real,
):  # fmt: skip
    """Mean velocity of a step and the contact that makes it.

    Args:
        body: The body.
        mode: FLYING, PIVOTING or FLAT.
        slip: Direction of sliding at the start, 0 where the body sticks.
        hold: Whether a pivoting corner sticks whatever force it takes.
        edge: The edge it lies on, if it is flat.
        x, z: What touches from the centre of mass, in the middle of the step [m].
        ux, uz: Mean velocity along the base and across it without contact [m/s].
        uo: Mean angular velocity without contact [rad/s].

    Returns:
        Mean velocity (three values); mode in the step; direction of sliding in the step; energy
        lost to friction per unit mass [J/kg].
    """
    zero = real(0.0)
    w = body.inverse_inertia
    slides = slip != zero
    n, f, sticks, drag = corner_impulse(
        body.friction, w, x, z, uz - uo * x, ux + uo * z, hold, slides, -slip
    )
    on = mode != FLYING and (n > zero or hold or (sticks and n >= zero))
    n = wp.where(on, n, zero)
    f = wp.where(on, f, zero)
    flat_f = flat_friction(body.friction, slip, ux, uz)
    moment = -edge.height * flat_f
    stays = mode == FLAT and moment <= -uz * edge.right and moment >= -uz * edge.left
    starts = size(ux) > -body.friction * uz
    mx = ux + wp.where(stays, flat_f, f)
    mo = wp.where(stays, zero, uo + w * (f * z - n * x))
    flat_slip = wp.where(slides, slip, wp.where(starts, sign_of(ux), zero))
    pivot_slip = wp.where(sticks or not on, zero, -drag)
    lost = -wp.where(stays, flat_f * mx, f * (mx + mo * z))
    return (
        mx,
        wp.where(stays, zero, uz + n),
        mo,
        wp.where(stays, FLAT, wp.where(on, PIVOTING, FLYING)),
        wp.where(stays, flat_slip, pivot_slip),
        TWO * lost,
    )


@wp.func
def held_velocity(
    body: Body, mode: int, slip: real, x: real, z: real, ux: real, uz: real, uo: real
):
    """Velocity at the end of a step, projected on its contact along the contact's force.

    Args:
        body: The body.
        mode: FLYING, PIVOTING or FLAT.
        slip: Direction of sliding, 0 where the body sticks.
        x, z: What touches from the centre of mass [m].
        ux, uz: Velocity along the base and across it before [m/s].
        uo: Angular velocity before [rad/s].
    """
    zero = real(0.0)
    w = body.inverse_inertia
    sticks = slip == zero
    n, f, _sticks, _drag = corner_impulse(
        body.friction, w, x, z, uz - uo * x, ux + uo * z, sticks, not sticks, -slip
    )
    pivots = mode == PIVOTING
    return (
        wp.where(mode == FLAT and sticks, zero, ux + wp.where(pivots, f, zero)),
        uz + wp.where(pivots, n, zero),
        uo + wp.where(pivots, w * (f * z - n * x), zero),
    )


@wp.func
def struck_velocity(
    body: Body, beside: bool, prescribed: bool, x: real, z: real, other: real,
    ux: real, uz: real, uo: real,
):  # fmt: skip
    """Velocity after an inelastic impact: a corner has landed or the base stepped its velocity.

    A restitution that is prescribed is the angular velocity after the impact over that before; the
    impulses of the corner do the rest. Where the corner would have to pull, nobody can follow it.

    Args:
        body: The body.
        beside: Whether a second corner is at the base.
        prescribed: Whether a prescribed restitution is for this impact.
        x, z: The corner that is struck, what touches of it, from the centre of mass [m].
        other: x of the second corner [m].
        ux, uz: Velocity along the base and across it before [m/s].
        uo: Angular velocity before [rad/s].

    Returns:
        Velocity (three values), mode, direction of sliding, energy lost per unit mass [J/kg].
    """
    zero = real(0.0)
    w = body.inverse_inertia
    n, f, sticks, _drag = corner_impulse(
        body.friction, w, x, z, uz - uo * x, ux + uo * z, False, False, zero
    )
    if VERTICAL:
        # A base that is kicked downwards leaves what stands on it.
        leaves = uz - uo * x > zero and not (sticks and n > zero)
        n, f = wp.where(leaves, zero, n), wp.where(leaves, zero, f)
    vo = uo + w * (f * z - n * x)
    asked = body.restitution * uo
    press = asked * x - uz
    follows = prescribed and body.restitution >= zero and press >= zero
    grip = -asked * z - ux
    holds = size(grip) <= body.friction * press
    sticks = wp.where(follows, holds, sticks)
    n = wp.where(follows, press, n)
    f = wp.where(follows, wp.where(holds, grip, sign_of(grip) * body.friction * press), f)
    vo = wp.where(follows, asked, vo)
    vx = ux + f
    vz = uz + n
    # Both corners at the base: the other one must not sink.
    both = beside and vz - vo * other <= zero
    bound = larger(-body.friction * uz, zero)
    vx = wp.where(both, ux + larger(smaller(-ux, bound), -bound), vx)
    vz = wp.where(both, zero, vz)
    vo = wp.where(both, zero, vo)
    along = vx + vo * z
    still = wp.where(both, along == zero, sticks)
    lost = ux * ux + uz * uz - vx * vx - vz * vz + (uo * uo - vo * vo) * body.inertia
    landed = wp.where(both, FLAT, PIVOTING)
    if VERTICAL:
        landed = wp.where(leaves and not both, FLYING, landed)
        still = still or landed == FLYING
    return (
        vx, vz, vo, landed,
        wp.where(still, zero, sign_of(along)),
        HALF * lost,
    )  # fmt: skip


@wp.func
def may_rest(body: Body, gravity: real, edge: Edge, omega: real, before: real, pull: real):
    """Whether the body rests on an edge after an impact, and the time of the impacts left out.

    Args:
        body: The body.
        gravity: [m/s^2].
        edge: The edge.
        omega: Angular velocity after the impact [rad/s].
        before: The one before it.
        pull: Horizontal force on the body per unit mass [m/s^2].
    """
    zero = real(0.0)
    square = body.inertia + edge.height * edge.height
    # Angular accelerations back to the edge, about either end.
    left = (-gravity * edge.left - pull * edge.height) / (square + edge.left * edge.left)
    right = (gravity * edge.right + pull * edge.height) / (square + edge.right * edge.right)
    weaker = smaller(left, right)
    rests = weaker > zero and omega * omega <= TWO * weaker * body.rest_rotation
    # 2 |omega| (1 / left + 1 / right) / (2 (1 - |omega / before|)).
    fast = size(before)
    lost = larger(fast - size(omega), real(1.0e-6) * fast)
    tail = size(omega) * (left + right) * fast / (left * right * lost)
    return rests, wp.where(rests, tail, zero)
