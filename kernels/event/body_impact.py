"""What the end of a step does to a body on contact points: impacts, velocity steps, rest."""

import warp as wp

from warprock.kernels.event.body_contact import Body, Edge, may_rest, struck_velocity
from warprock.kernels.event.body_view import View
from warprock.kernels.event.body_weight import Weight, kicks
from warprock.kernels.modes import FLAT, FLYING, PIVOTING
from warprock.kernels.shape.body import turned_x, turned_z


@wp.func
def struck_corner(
    body: Body, view: View, up: bool, down: bool, lands: bool, mode: int, theta: real,
    kicked: real, omega: real,
):  # fmt: skip
    """The corner that is struck first at the end of a step, and a second one on the base.

    That is the neighbour where it lands; of a flat body that lands or that the base kicks, the
    corner ahead.

    Args:
        body: The body.
        view: The corner and its neighbours.
        up, down: Whether the body now lies on the edge to +x of the corner, to -x of it.
        lands: Whether the corner has landed.
        mode: In the step.
        theta: Rotation [rad].
        kicked: Velocity along the base [m/s].
        omega: Angular velocity [rad/s].

    Returns:
        Whether the edge is that to +x of the corner; whether the body lies on one at all; whether
        the neighbour there is struck; what touches of the struck corner, from the centre of mass,
        and x of the other one [m].
    """
    flat = mode == FLAT
    s, c = sine(theta), cosine(theta)
    right = wp.where(flat, view.flat_right, up or (not down and theta == view.high))
    left = wp.where(flat, not view.flat_right, down or (not up and theta == view.low))
    level = flat or (lands and omega == real(0.0) and (left or right))
    swaps = up or down or (level and (kicked >= real(0.0)) == right)
    next_x = wp.where(right, view.right_x, view.left_x)
    next_z = wp.where(right, view.right_z, view.left_z)
    own_x, own_z = turned_x(view.x, view.z, s, c), turned_z(view.x, view.z, s, c)
    beside_x, beside_z = turned_x(next_x, next_z, s, c), turned_z(next_x, next_z, s, c)
    return (
        right,
        left or right,
        swaps,
        wp.where(swaps, beside_x, own_x),
        wp.where(swaps, beside_z, own_z) - body.radius,
        wp.where(swaps, own_x, beside_x),
    )


@wp.func
def end_of_step(
    body: Body, weight: Weight, view: View, up: bool, down: bool, lands: bool, kick: real, a: real,
    mode: int, slip: real, theta: real, vx: real, vz: real, omega: real,
):  # fmt: skip
    """What the end of a step does to the velocities.

    Args:
        body: The body.
        weight: What weighs on it, and the velocity step of the base upwards.
        view: The corner and its neighbours.
        up, down: Whether the body now lies on the edge to +x of the corner, to -x of it.
        lands: Whether the corner has landed.
        kick: Velocity step of the base [m/s].
        a: Acceleration of the base [m/s^2].
        mode, slip: In the step.
        theta: Rotation; vx, vz and omega velocities.

    Returns:
        Velocity (three values), mode, direction of sliding and number of the corner; energy lost
        per unit mass; whether another corner or a flying one hit the base; time of the impacts
        that resting leaves out; friction that a prescribed impact asks for, see `struck_velocity`.
    """
    zero = real(0.0)
    falls = up or down
    hit = lands or (falls and mode == PIVOTING)
    struck = hit or (kicks(weight, kick) and mode != FLYING)
    kicked, dropped = vx - kick, vz - weight.kick
    right, beside, swaps, x, z, other = struck_corner(
        body, view, up, down, lands, mode, theta, kicked, omega
    )
    # What is prescribed is for the edge that the body stands on at first.
    prescribed = falls and mode == PIVOTING and theta == zero
    vx1, vz1, omega1, mode1, slip1, second, lost, needed = struck_velocity(
        body, beside, prescribed, x, z, other, kicked, dropped, omega
    )
    # The base's work on the body is at the mean of both velocities: see account.py.
    lost = lost - HALF * kick * (vx1 - kicked)
    if VERTICAL:
        lost = lost - HALF * weight.kick * (vz1 - dropped)
    vx1, vz1 = wp.where(struck, vx1, kicked), wp.where(struck, vz1, dropped)
    omega1, mode1 = wp.where(struck, omega1, omega), wp.where(struck, mode1, mode)
    slip1 = wp.where(struck, slip1, slip)
    lost = wp.where(struck, lost, zero)
    edge = Edge(smaller(x, other), larger(x, other), -z)
    pull = wp.where(slip1 != zero, -slip1 * body.friction * weight.end, a)
    stays, tail = may_rest(body, weight.end, edge, omega1, omega, pull)
    rests = stays and hit and falls and mode1 == PIVOTING
    glides = wp.where(slip1 != zero, vx1, zero)
    slip1 = wp.where(rests and slip1 != zero, sign_of(vx1), slip1)
    rest_lost = HALF * (vx1 * vx1 - glides * glides + vz1 * vz1 + omega1 * omega1 * body.inertia)
    mode1 = wp.where(rests, FLAT, mode1)
    # Corners are numbered from -x: an edge is known by its end there.
    on_edge = view.corner + wp.where(right, 0, -1)
    moves = wp.where(struck, swaps != second, falls)
    stands = view.corner + wp.where(moves, wp.where(right, 1, -1), 0)
    return (
        wp.where(rests, glides, vx1), wp.where(rests, zero, vz1), wp.where(rests, zero, omega1),
        mode1, slip1, wp.where(mode1 == FLAT, on_edge, stands),
        lost + wp.where(rests, rest_lost, zero), hit, wp.where(rests, tail, zero), needed,
    )  # fmt: skip
