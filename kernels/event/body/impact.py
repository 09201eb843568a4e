"""End of a step of a body on contact points: impacts, velocity steps of the base, rest."""

import warp as wp

from warprock.kernels.event.block.contact import Lever, Velocity
from warprock.kernels.event.block.state import End, Span
from warprock.kernels.event.body.contact import Body, Edge, may_rest, struck_velocity
from warprock.kernels.event.body.view import View
from warprock.kernels.event.body.weight import Weight, kicks
from warprock.kernels.lane.modes import FLAT, FLYING, PIVOTING
from warprock.kernels.shape.body import rotated_x, rotated_z

if BOUNCES:
    from warprock.kernels.event.body.bounce import bounce_velocity


@wp.struct
class Struck:
    """The corner that is struck first at the end of a step, and the other end of its edge.

    Attributes:
        right: Whether that edge is the one to +x of corner k.
        beside: Whether the whole edge lies on the base.
        swaps: Whether the neighbour of corner k is struck first.
        x, z: Point of contact of the struck corner, from the centre of mass [m].
        other: x of the other end [m].
    """

    right: bool
    beside: bool
    swaps: bool
    x: real
    z: real
    other: real


@wp.struct
class Impact:
    """The body after the end of a step.

    Attributes:
        vx, vz, omega: Velocity [m/s], [rad/s].
        mode, slip: How the body touches its base.
        corner: Corner k, see event/body/step.py.
        lost: Energy lost per unit mass [J/kg].
        hit: Whether another corner or a flying one hit the base.
        tail: Time of the impacts that the rest rule omits [s].
        needed: Friction that a prescribed impact needs, see `Blow`.
    """

    vx: real
    vz: real
    omega: real
    mode: int
    slip: real
    corner: int
    lost: real
    hit: bool
    tail: real
    needed: real


@wp.func
def find_struck(
    body: Body, view: View, up: bool, down: bool, lands: bool, kicked: real, end: End
) -> Struck:
    """The corner that is struck first at the end of a step.

    That is the neighbour of corner k if the neighbour lands. If a flat body lands, or the base
    kicks it, it is the corner ahead.

    Args:
        body: The body.
        view: Corner k and its neighbours.
        up, down: Whether the body now lies on the edge to +x of the corner, to -x of it.
        lands: Whether the corner has landed.
        kicked: Velocity along the base after its velocity step [m/s].
        end: The end of the step.
    """
    flat, turns_not, ahead = end.mode == FLAT, end.omega == real(0.0), kicked >= real(0.0)
    at_high, at_low = end.theta == view.high, end.theta == view.low
    s, c = sine(end.theta), cosine(end.theta)
    right = wp.where(flat, view.flat_right, up or (not down and at_high))
    left = wp.where(flat, not view.flat_right, down or (not up and at_low))
    level = flat or (lands and turns_not and (left or right))
    struck_ahead = ahead == right
    swaps = up or down or (level and struck_ahead)
    next_x = wp.where(right, view.right_x, view.left_x)
    next_z = wp.where(right, view.right_z, view.left_z)
    own_x, own_z = rotated_x(view.x, view.z, s, c), rotated_z(view.x, view.z, s, c)
    beside_x, beside_z = rotated_x(next_x, next_z, s, c), rotated_z(next_x, next_z, s, c)
    return Struck(
        right, left or right, swaps, wp.where(swaps, beside_x, own_x),
        wp.where(swaps, beside_z, own_z) - body.radius, wp.where(swaps, own_x, beside_x),
    )  # fmt: skip


@wp.func
def end_step(
    body: Body, weight: Weight, view: View, up: bool, down: bool, lands: bool, span: Span, end: End
) -> Impact:
    """Applies the impact, the velocity step of the base and the rest rule at the end of a step.

    Args:
        body: The body.
        weight: Its weight, and the velocity step of the base upwards.
        view: Corner k and its neighbours.
        up, down: Whether the body now lies on the edge to +x of the corner, to -x of it.
        lands: Whether the corner has landed.
        span: The step.
        end: The body at its end.
    """
    zero = real(0.0)
    kick = span.kick
    falls, pivots, flies = up or down, end.mode == PIVOTING, end.mode == FLYING
    hit = lands or (falls and pivots)
    kicked_on = kicks(weight, kick) and not flies
    struck = hit or kicked_on
    kicked, dropped = end.vx - kick, end.vz - weight.kick
    corner = find_struck(body, view, up, down, lands, kicked, end)
    # A prescribed restitution is that of the edge on which the body stands at first.
    upright = end.theta == zero
    prescribed = falls and pivots and upright
    at, before = Lever(corner.x, corner.z), Velocity(kicked, dropped, end.omega)
    if BOUNCES:
        after, contact, blow = bounce_velocity(body, corner.beside, at, corner.other, before)
    else:
        after, contact, blow = struck_velocity(
            body, corner.beside, prescribed, at, corner.other, before
        )
    # The base's work on the body is at the mean of both velocities: see account.py.
    lost = blow.lost - HALF * kick * (after.x - kicked)
    if VERTICAL:
        lost = lost - HALF * weight.kick * (after.z - dropped)
    vx1, vz1 = wp.where(struck, after.x, kicked), wp.where(struck, after.z, dropped)
    omega1 = wp.where(struck, after.omega, end.omega)
    mode1 = wp.where(struck, contact.mode, end.mode)
    slip1 = wp.where(struck, contact.slip, end.slip)
    lost = wp.where(struck, lost, zero)
    edge = Edge(smaller(corner.x, corner.other), larger(corner.x, corner.other), -corner.z)
    pull = wp.where(slip1 != zero, -slip1 * body.friction * weight.end, span.a1)
    stays, tail = may_rest(body, weight.end, edge, omega1, end.omega, pull)
    turns, slides = mode1 == PIVOTING, slip1 != zero
    # What a prescribed impact leaves no rate rests, if only until the base lifts it.
    stays = stays or omega1 == zero
    rests = stays and hit and falls and turns
    glides = wp.where(slides, vx1, zero)
    slip1 = wp.where(rests and slides, sign_of(vx1), slip1)
    rest_lost = HALF * (vx1 * vx1 - glides * glides + vz1 * vz1 + omega1 * omega1 * body.inertia)
    mode1 = wp.where(rests, FLAT, mode1)
    # Corners are numbered from -x: an edge is known by its end there.
    on_edge = view.corner + wp.where(corner.right, 0, -1)
    moves = wp.where(struck, corner.swaps != blow.second, falls)
    stands = view.corner + wp.where(moves, wp.where(corner.right, 1, -1), 0)
    return Impact(
        wp.where(rests, glides, vx1), wp.where(rests, zero, vz1), wp.where(rests, zero, omega1),
        mode1, slip1, wp.where(mode1 == FLAT, on_edge, stands),
        lost + wp.where(rests, rest_lost, zero), hit, wp.where(rests, tail, zero), blow.needed,
    )  # fmt: skip
