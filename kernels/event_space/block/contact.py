"""Contact of one block in space with its base.

Mass 1, inertia I about the centre of mass, velocity v, angular velocity w; corner k lies at r_k
from the centre of mass and moves at v + w x r_k. The base is the plane z = 0. An impulse p at a
corner, p_z = n >= 0 and |p_x, p_y| <= friction n (the cone), changes v by p and w by I^-1 (r x p).
The box bounds |p_x| and |p_y| separately; event_space/block/box_friction.py finds what slides then.

The *stance* says where the block touches: on corner k (0 to 3), on the edge from corner k to the
next (4 + k), flat (8), or nowhere (9). States are tried in this order; 1 to 5 are exact:

    1. the face, else an edge, sticks. On an edge the component of L + a x v along the edge is
       conserved (L = I w, a = -r); flat, nothing moves. The impulses follow. The ends of an edge
       share the impulse along it as the cones allow. A face spreads the impulse bilinearly over
       the rectangle, so that all n >= 0 while the centre of pressure lies in it;
    2. it slides: p = n (-friction d, 1), d the directions of the velocities after the impulse,
       found by Newton's method;
    3. one end of an edge sticks and the other slides, which is possible only across the edge. The
       angular momentum about the sticking end changes only by the moment of the other's impulse;
    4. one corner sticks, which conserves L + a x v about it; else it slides;
    5. no contact carries;
    6. block Gauss-Seidel: corner by corner, each solved exactly, until nothing changes.

A corner that touches and does not carry must not sink. With friction several states may obey the
law (Painleve): a tall block can slide on an edge as a whole, or turn over one of its ends. The
first one is taken; it keeps the plane motion of a block plane.

In a plane motion both ends of an edge have the same state. In other motions the order differs, to
save searches for sliding directions. If exactly one end would sink without contact, as when a block
rolls from corner to corner, that corner sticks if it can. If the friction of one end is used up
before that of the other, 2 comes last.
"""

import warp as wp

from warprock.kernels.algebra.vectors import Matrix, Vector

BOX = FRICTION == "box"
"""Whether friction is bound as a box along x and y, else as a cone."""
EDGE = 4
FLAT = 8
FLYING = 9
ALL = 15

ALIKE = by_precision(1.0e-8, 1.0e-4)
"""Difference of the margins of both ends of an edge, as a part of its friction, up to which both
ends let go together."""


Two = wp.types.vector(length=2, dtype=real)
Shares = wp.types.vector(length=4, dtype=real)
"""One number a corner."""
Corners = wp.types.matrix(shape=(4, 3), dtype=real)
"""One vector a corner."""


@wp.struct
class Body:
    """A block in one attitude: its inertia for unit mass [m^2], its inverse, its corners [m]."""

    inertia: Matrix
    inverse: Matrix
    corners: Corners
    friction: real


@wp.struct
class Held:
    """The motion with contacts.

    Attributes:
        v, w: Velocity [m/s] and angular velocity [rad/s].
        stance: Where the block touches.
        slip: The corners that slide, a sum of 2^k.
        work: Energy per unit mass that friction takes [m^2/s^2]; if the motion is a mean of a step,
            to be multiplied by the length of the step.
        fits: Whether the motion obeys the contact law.
        spare: Friction margin of the weaker end of an edge; if that end slides beside one that
            sticks, its normal impulse.
        turns: Whether `spare` is used up, so that the edge lets go of that end alone.
    """

    v: Vector
    w: Vector
    stance: int
    slip: int
    work: real
    fits: bool
    spare: real
    turns: bool


@wp.func
def mask_of(stance: int) -> int:
    """Corners of a stance, a sum of 2^k."""
    mask = int(0)
    if stance < EDGE:
        mask = 1 << stance
    elif stance < FLAT:
        mask = (1 << (stance - EDGE)) | (1 << ((stance - EDGE + 1) % 4))
    elif stance == FLAT:
        mask = ALL
    return mask


@wp.func
def stance_of(mask: int) -> int:
    """Stance on given corners; with two opposite ones, or three, the block lies flat."""
    stance = int(8)
    for number in range(8):
        if mask_of(number) == mask:
            stance = number
    return wp.where(mask == 0, FLYING, stance)


@wp.func
def corner_velocity(body: Body, v: Vector, w: Vector, k: int) -> Vector:
    """Velocity of a corner [m/s]."""
    return v + wp.cross(w, body.corners[k])


@wp.func
def velocity_by_impulse(body: Body, k: int, p: Vector, at: int) -> Vector:
    """Change of the velocity of corner `at` by an impulse at corner k."""
    return p + wp.cross(body.inverse * wp.cross(body.corners[k], p), body.corners[at])


@wp.func
def corner_matrix(body: Body, k: int) -> Matrix:
    """Matrix of the velocity of corner k for the impulse there, columns by unit impulses."""
    zero, one = real(0.0), real(1.0)
    x = velocity_by_impulse(body, k, Vector(one, zero, zero), k)
    y = velocity_by_impulse(body, k, Vector(zero, one, zero), k)
    z = velocity_by_impulse(body, k, Vector(zero, zero, one), k)
    return Matrix(x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2])


@wp.func
def direction_of(u: Vector) -> Two:
    """Unit vector of a velocity along the base; zero for a velocity of zero."""
    length = wp.sqrt(u[0] * u[0] + u[1] * u[1])
    over = wp.where(length > TINY, real(1.0) / larger(length, TINY), real(0.0))
    return Two(u[0] * over, u[1] * over)


@wp.func
def stick(body: Body, stance: int, v: Vector, w: Vector):
    """Velocities if the stance sticks: the projection on the motions that it allows."""
    v_after = Vector()
    w_after = Vector()
    if stance < FLAT:
        k = stance % 4
        a = -body.corners[k]
        spin = body.inertia * w + wp.cross(a, v)
        if stance < EDGE:
            about = body.inertia + wp.dot(a, a) * wp.identity(n=3, dtype=real) - wp.outer(a, a)
            w_after = wp.inverse(about) * spin
        else:
            e = wp.normalize(body.corners[(k + 1) % 4] - body.corners[k])
            arm = wp.cross(e, a)
            w_after = e * (wp.dot(e, spin) / (wp.dot(e, body.inertia * e) + wp.dot(arm, arm)))
        v_after = wp.cross(w_after, a)
    return v_after, w_after


@wp.func
def friction_size(x: real, y: real) -> real:
    """Size of a friction for its bound: its norm, or for the box its larger component."""
    if BOX:
        return larger(size(x), size(y))
    return wp.sqrt(x * x + y * y)


@wp.struct
class EdgeShares:
    """Impulses of both ends of an edge.

    Attributes:
        one, other: Both impulses, with half of the impulse along the edge each [m/s].
        along: Direction of the edge.
        room1, room2: Part of the bounds that the friction across the edge leaves [m/s].
    """

    one: Vector
    other: Vector
    along: Vector
    room1: real
    room2: real


@wp.func
def edge_shares(body: Body, k: int, p: Vector, twist: Vector) -> EdgeShares:
    """Impulses of both ends of an edge, from their sum and angular impulse about the centre.

    Across the edge they differ by 2 q. Along the edge only their sum matters; each end takes what
    its cone, or box, allows.
    """
    first = body.corners[k]
    way = body.corners[(k + 1) % 4] - first
    e = wp.normalize(way)
    middle = first + HALF * way
    q = wp.cross((twist - wp.cross(middle, p)) / wp.length(way), e)
    one = HALF * p - q
    other = HALF * p + q
    mu = body.friction
    if BOX:
        mu = mu * (size(e[0]) + size(e[1]))
    room1 = mu * one[2] - size(one[1] * e[0] - one[0] * e[1])
    room2 = mu * other[2] - size(other[1] * e[0] - other[0] * e[1])
    return EdgeShares(one, other, e, room1, room2)


@wp.func
def left_along(most: real, room: real) -> real:
    """Friction along an edge that a cone still allows, given the friction across it."""
    return wp.sqrt(larger(room * (most + most - room), real(0.0)))


@wp.func
def friction_range(most: real, p: Vector, e: Vector):
    """Least and largest friction along an edge that a box still allows, given that across it."""
    least = real(-1.0e30)
    largest = real(1.0e30)
    across = p[1] * e[0] - p[0] * e[1]
    for axis in range(2):
        aside = wp.where(axis == 0, -across * e[1], across * e[0])
        if size(e[axis]) > TINY:
            a = (-most - aside) / e[axis]
            b = (most - aside) / e[axis]
            least = larger(least, smaller(a, b))
            largest = smaller(largest, larger(a, b))
    return least, largest


@wp.func
def edge_carries(body: Body, k: int, p: Vector, twist: Vector):
    """Whether an edge can carry an impulse p and an angular impulse about the centre of mass.

    Returns:
        Whether it can; margin of the weaker end before it slides or opens; whether the margin of
        the other end is larger.
    """
    zero = real(0.0)
    shares = edge_shares(body, k, p, twist)
    one, other, e, room1, room2 = shares.one, shares.other, shares.along, shares.room1, shares.room2
    along_edge = wp.dot(p, e)
    least = real(0.0)
    largest = real(0.0)
    if BOX:
        least1, largest1 = friction_range(body.friction * one[2], one, e)
        least2, largest2 = friction_range(body.friction * other[2], other, e)
        least = least1 + least2
        largest = largest1 + largest2
    else:
        largest = left_along(body.friction * one[2], room1)
        largest += left_along(body.friction * other[2], room2)
        least = -largest
    pressed = one[2] >= zero and other[2] >= zero
    room = smaller(room1, room2)
    uneven = size(room1 - room2) > ALIKE * body.friction * (size(one[2]) + size(other[2]))
    shared = least <= along_edge and along_edge <= largest
    return pressed and room >= zero and shared, room, uneven


@wp.func
def first_directions(body: Body, stance: int, v: Vector, w: Vector) -> Corners:
    """First guess of the directions of sliding: against the force that would make corners stick.

    The ends of an edge share that force so that both use their whole cones.
    """
    zero = real(0.0)
    dirs = Corners()
    v_after, w_after = stick(body, stance, v, w)
    d = direction_of(v - v_after)
    for k in range(4):
        dirs[k] = Vector(d[0], d[1], zero)
    if stance >= EDGE and stance < FLAT:
        k = stance - EDGE
        p = v_after - v
        shares = edge_shares(body, k, p, body.inertia * (w_after - w))
        one, other, e = shares.one, shares.other, shares.along
        way = e * wp.sign(wp.dot(p, e))
        left1 = left_along(body.friction * one[2], shares.room1)
        left2 = left_along(body.friction * other[2], shares.room2)
        d1 = direction_of(one + way * left1 - e * wp.dot(one, e))
        d2 = direction_of(other + way * left2 - e * wp.dot(other, e))
        dirs[k] = Vector(-d1[0], -d1[1], zero)
        dirs[(k + 1) % 4] = Vector(-d2[0], -d2[1], zero)
    return dirs


@wp.func
def face_shares(body: Body, x: real, y: real) -> Shares:
    """Bilinear shares of the corners in a load whose centre of pressure is at (x, y) [m]."""
    one = real(1.0)
    c0 = body.corners[0]
    ex = body.corners[1] - c0
    ey = body.corners[3] - c0
    s = ((x - c0[0]) * ex[0] + (y - c0[1]) * ex[1]) / wp.dot(ex, ex)
    t = ((x - c0[0]) * ey[0] + (y - c0[1]) * ey[1]) / wp.dot(ey, ey)
    return Shares((one - s) * (one - t), s * (one - t), s * t, (one - s) * t)


@wp.func
def lies_inside(body: Body, x: real, y: real) -> bool:
    """Whether a point of the base lies under the bottom face."""
    zero, one = real(0.0), real(1.0)
    c0 = body.corners[0]
    ex = body.corners[1] - c0
    ey = body.corners[3] - c0
    s = ((x - c0[0]) * ex[0] + (y - c0[1]) * ex[1]) / wp.dot(ex, ex)
    t = ((x - c0[0]) * ey[0] + (y - c0[1]) * ey[1]) / wp.dot(ey, ey)
    return s >= zero and s <= one and t >= zero and t <= one


@wp.func
def face_carries(body: Body, p: Vector, twist: Vector, dust: real) -> bool:
    """Whether a flat block can carry an impulse and an angular impulse about its centre of mass."""
    fits = wp.length(p) <= dust and wp.length(twist) <= dust * size(body.corners[0, 2])
    if p[2] > dust:
        low = -body.corners[0, 2]
        x = -(twist[1] + low * p[0]) / p[2]
        y = (twist[0] - low * p[1]) / p[2]
        shares = face_shares(body, x, y)
        torsion = twist[2] - x * p[1] + y * p[0]
        reach = real(0.0)
        for k in range(4):
            dx = body.corners[k, 0] - x
            dy = body.corners[k, 1] - y
            reach += shares[k] * (dx * dx + dy * dy)
        turn = torsion / larger(reach, TINY)
        worst = real(0.0)
        for k in range(4):
            fx = p[0] - turn * (body.corners[k, 1] - y)
            fy = p[1] + turn * (body.corners[k, 0] - x)
            worst = larger(worst, wp.where(shares[k] > real(0.0), friction_size(fx, fy), real(0.0)))
        fits = lies_inside(body, x, y) and worst <= body.friction * p[2] + dust
    return fits


@wp.func
def sinks(body: Body, v: Vector, w: Vector, mask: int, dust: real) -> bool:
    """Whether a corner of the mask moves into the base."""
    found = bool(False)
    for k in range(4):
        u = corner_velocity(body, v, w, k)
        found = found or ((mask & (1 << k)) != 0 and u[2] < -dust)
    return found


@wp.func(inline=False)
def try_sticking(body: Body, stance: int, mask: int, v: Vector, w: Vector, dust: real) -> Held:
    """The motion if a stance sticks; `fits` if its cones can carry it and no corner sinks.

    `mask` has the corners that touch.
    """
    h = Held()
    v_after, w_after = stick(body, stance, v, w)
    h.v = v_after
    h.w = w_after
    h.stance = stance
    p = h.v - v
    if stance < EDGE:
        h.fits = p[2] >= real(0.0) and friction_size(p[0], p[1]) <= body.friction * p[2]
    else:
        twist = body.inertia * (h.w - w)
        if stance < FLAT:
            fits, room, uneven = edge_carries(body, stance - EDGE, p, twist)
            h.fits = fits
            h.spare = room
            h.turns = uneven and room < real(0.0)
        else:
            h.fits = face_carries(body, p, twist, dust)
    h.fits = h.fits and not sinks(body, h.v, h.w, mask & ~mask_of(stance), dust)
    return h


@wp.func(inline=False)
def try_sticking_end(body: Body, stance: int, v: Vector, w: Vector, dust: real) -> Held:
    """The motion if the end of an edge that alone would sink without contact sticks.

    It does not fit if both ends would sink, or none.
    """
    h = Held()
    one, other = stance - EDGE, (stance - EDGE + 1) % 4
    sinks_one = corner_velocity(body, v, w, one)[2] < -dust
    sinks_other = corner_velocity(body, v, w, other)[2] < -dust
    if sinks_one != sinks_other:
        h = try_sticking(body, wp.where(sinks_one, one, other), mask_of(stance), v, w, dust)
    return h
