"""Velocity-level contact step of a body on contact points.

As impulse/block.py, for the lowest corner of a body (see shape/body.py) and its two neighbours: on
flat ground no other corner of a convex chain can carry. The sweeps update the velocities, which
include all impulses so far,

    n = larger(n - (u_n - least) / K_nn, 0),   f = within mu n of f - u_t / K_tt.

A step reflects a body so that it leans to +x. Corner 1 is then the neighbour to -x, corner 2 the
lowest one and corner 3 the neighbour to +x.
"""

import warp as wp

from warprock.kernels.contact.cone import solve_single_contact
from warprock.kernels.impulse.block import ENDS_EARLY, Knobs, least_normal_velocity
from warprock.kernels.shape.block import State
from warprock.kernels.shape.body_seen import Corners
from warprock.kernels.shape.interface import Velocity
from warprock.kernels.shape.rising import fall_depth, fall_in


@wp.struct
class Body:
    """The body of one lane, and its start.

    `reach` is the largest distance of its corners from the centre of mass [m]; `start` is its
    rotation at the start [rad], vx, vz and omega its velocities then [m/s, rad/s].
    """

    inverse_inertia: real
    friction: real
    reach: real
    start: real
    vx: real
    vz: real
    omega: real


@wp.struct
class Feet:
    """The lowest corner of a body and its neighbours to -x and to +x, from the centre of mass [m].

    `has_left` and `has_right` are 1 if that neighbour exists, else 0.
    """

    x: real
    z: real
    left_x: real
    left_z: real
    right_x: real
    right_z: real
    has_left: int
    has_right: int


@wp.struct
class Impulses:
    """Normal and tangential impulses of three corners, from -x to +x [m/s]; 2 is the lowest."""

    n1: real
    f1: real
    n2: real
    f2: real
    n3: real
    f3: real


@wp.struct
class Contact:
    """A corner that may be a contact.

    Attributes:
        on: 1 if it is a contact, else 0.
        x, z: From the centre of mass [m].
        gap: Of the corner at the start of the step [m].
        least: Least normal velocity after it [m/s].
        dn, dt: 1 / K_nn and 1 / K_tt; zero if it is no contact.
    """

    on: real
    x: real
    z: real
    gap: real
    least: real
    dn: real
    dt: real


@wp.func
def find_contact(knobs: Knobs, w: real, has: int, height: real, x: real, z: real) -> Contact:
    """A corner, if it exists (`has` is 1), of a body whose centre of mass is at a height [m]."""
    one, gap = real(1.0), height + z
    on = wp.where(has > 0 and gap <= knobs.collision_margin, one, real(0.0))
    dn, dt = on / fused(w * x, x, one), on / fused(w * z, z, one)
    return Contact(on, x, z, gap, least_normal_velocity(gap, knobs), dn, dt)


@wp.func
def solve_contact(
    mu: real, w: real, c: Contact, n: wp.ref[real], f: wp.ref[real], v: wp.ref[Velocity]
):  # fmt: skip
    """Gauss-Seidel on the two impulses of a corner; updates them and the velocity of the body.

    Args:
        mu: Friction coefficient.
        w: Inverse inertia for unit mass [1/m^2].
        c: The corner.
        n, f: Its impulses [m/s].
        v: Velocity of the body.
    """
    n1 = larger(fused_less(c.dn, fused_less(v.omega, c.x, v.z - c.least), n), real(0.0))
    v.z = v.z + (n1 - n)
    v.omega = fused_less(w * c.x, n1 - n, v.omega)
    bound = mu * n1
    f1 = larger(smaller(fused_less(c.dt, fused(v.omega, c.z, v.x), f), bound), -bound)
    v.x = v.x + (f1 - f)
    v.omega = fused(w * c.z, f1 - f, v.omega)
    n = n1
    f = f1


@wp.func
def sweep(
    mu: real, w: real, one: Contact, two: Contact, three: Contact, p: wp.ref[Impulses],
    v: wp.ref[Velocity],
):  # fmt: skip
    """One sweep over the three corners."""
    solve_contact(mu, w, one, p.n1, p.f1, v)
    solve_contact(mu, w, two, p.n2, p.f2, v)
    solve_contact(mu, w, three, p.n3, p.f3, v)


@wp.func
def are_equal(p: Impulses, q: Impulses) -> bool:
    """Whether impulses are equal."""
    middle = p.n2 == q.n2 and p.f2 == q.f2
    return p.n1 == q.n1 and p.f1 == q.f1 and middle and p.n3 == q.n3 and p.f3 == q.f3


@wp.func
def add_impulses(
    w: real, one: Contact, two: Contact, three: Contact, p: Impulses, u: Velocity
) -> Velocity:
    """The velocity of a body after the impulses of its corners."""
    turn = wedge(one.z, one.x, p.n1, p.f1) + wedge(two.z, two.x, p.n2, p.f2)
    turn = turn + wedge(three.z, three.x, p.n3, p.f3)
    return Velocity(u.x + p.f1 + p.f2 + p.f3, u.z + p.n1 + p.n2 + p.n3, fused(w, turn, u.omega))


@wp.func
def solve(
    mu: real, w: real, one: Contact, two: Contact, three: Contact, u: Velocity, guess: Impulses
) -> Impulses:
    """Impulses of three corners by projected Gauss-Seidel; a single contact is solved exactly.

    Args:
        mu: Friction coefficient.
        w: Inverse inertia for unit mass [1/m^2].
        one, two, three: The corners.
        u: Velocity of the body without contact.
        guess: First guess of the impulses.
    """
    p = Impulses(
        one.on * guess.n1, one.on * guess.f1, two.on * guess.n2, two.on * guess.f2,
        three.on * guess.n3, three.on * guess.f3,
    )  # fmt: skip
    first, last = one.on > two.on + three.on, three.on > one.on + two.on
    x = wp.where(first, one.x, wp.where(last, three.x, two.x))
    z = wp.where(first, one.z, wp.where(last, three.z, two.z))
    least = wp.where(first, one.least, wp.where(last, three.least, two.least))
    dn, dt = one.dn + two.dn + three.dn, one.dt + two.dt + three.dt
    cross = -w * x * z
    n, f = solve_single_contact(
        mu, dn * cross, dt * cross, -dn * (u.z - u.omega * x - least), -dt * (u.x + u.omega * z)
    )
    v = add_impulses(w, one, two, three, p, u)
    if ENDS_EARLY:
        for _ in range(ITERATIONS):
            old = Impulses(p.n1, p.f1, p.n2, p.f2, p.n3, p.f3)
            sweep(mu, w, one, two, three, p, v)
            if are_equal(p, old):
                break
    else:
        for _ in range(ITERATIONS):
            sweep(mu, w, one, two, three, p, v)
    is_alone = one.on + two.on + three.on == real(1.0)
    return Impulses(
        wp.where(is_alone, one.on * n, p.n1), wp.where(is_alone, one.on * f, p.f1),
        wp.where(is_alone, two.on * n, p.n2), wp.where(is_alone, two.on * f, p.f2),
        wp.where(is_alone, three.on * n, p.n3), wp.where(is_alone, three.on * f, p.f3),
    )  # fmt: skip


@wp.func
def lean_of(state: State, slip: real, feet: Feet) -> real:
    """A number whose sign is the side to which a body leans; 0 if it is its own mirror image.

    A body that stands still and upright leans to the side to which its base reaches further.
    """
    zero = real(0.0)
    reaches = feet.right_x + wp.where(feet.x == zero, feet.left_x, feet.x)
    still = wp.where(slip != zero, slip, reaches)
    moving = wp.where(state.omega != zero, state.omega, still)
    return wp.where(state.theta != zero, state.theta, moving)


@wp.func
def balance(even: bool, amid: bool, p: Impulses) -> Impulses:
    """Impulses of three points; if the body is its own mirror image (`even`), mean of both orders.

    Each point has a mirror image. If the second point lies in the middle (`amid`), the image of the
    first is the last; else the image of the second is the last.
    """
    zero, outer, inner = real(0.0), even and amid, even and not amid
    n = HALF * (wp.where(amid, p.n1, p.n2) + p.n3)
    f = HALF * (wp.where(amid, p.f1, p.f2) - p.f3)
    return Impulses(
        wp.where(outer, n, p.n1), wp.where(outer, f, p.f1),
        wp.where(inner, n, p.n2), wp.where(inner, f, wp.where(outer, zero, p.f2)),
        wp.where(even, n, p.n3), wp.where(even, -f, p.f3),
    )  # fmt: skip


@wp.func
def mirror(side: real, p: Impulses) -> Impulses:
    """Impulses, reflected if `side` is -1."""
    swap = side < real(0.0)
    return Impulses(
        wp.where(swap, p.n3, p.n1), side * wp.where(swap, p.f3, p.f1), p.n2, side * p.f2,
        wp.where(swap, p.n1, p.n3), side * wp.where(swap, p.f1, p.f3),
    )  # fmt: skip


@wp.func
def contact_work(c: Contact, n: real, f: real, v: Velocity) -> real:
    """Work of the impulses of a corner [J/kg] at a velocity of the body."""
    return dot(n, f, fused_less(v.omega, c.x, v.z), fused(v.omega, c.z, v.x))


@wp.func
def gap_after(dt: real, c: Contact, v: Velocity) -> real:
    """Gap of a corner after a step, along its velocity [m]."""
    return fused(dt, fused_less(v.omega, c.x, v.z), c.gap)


@wp.func
def step(
    body: Body, knobs: Knobs, dv: real, dz: real, feet: Feet, state: State, before: Impulses,
    loss: wp.ref[real],
):  # fmt: skip
    """One step of one lane, in which the base velocity changes by dv along and dz upwards [m/s].

    `before` has the impulses of the corners in the last step. The step adds its own loss [J/kg].
    Returns the state, the impulses, the normal impulses and gaps of the corners, and the gap of the
    lowest corner at the start [m].
    """
    w, dt = body.inverse_inertia, knobs.time_step
    slip = state.vx - dv
    lean = lean_of(state, slip, feet)
    m = sign_of(lean)
    left = m < real(0.0)
    has1 = wp.where(left, feet.has_right, feet.has_left)
    has3 = wp.where(left, feet.has_left, feet.has_right)
    x1 = m * wp.where(left, feet.right_x, feet.left_x)
    x3 = m * wp.where(left, feet.left_x, feet.right_x)
    z1 = wp.where(left, feet.right_z, feet.left_z)
    z3 = wp.where(left, feet.left_z, feet.right_z)
    one = find_contact(knobs, w, has1, state.z, x1, z1)
    two = find_contact(knobs, w, 1, state.z, m * feet.x, feet.z)
    three = find_contact(knobs, w, has3, state.z, x3, z3)
    u = Velocity(m * slip, state.vz - fall_in(dt, knobs.gravity, dz), m * state.omega)
    p = solve(body.friction, w, one, two, three, u, mirror(m, before))
    p = balance(lean == real(0.0), feet.x == real(0.0), p)
    v = add_impulses(w, one, two, three, p, u)
    # Loss: minus the work of the contact impulses on the mean velocities of their corners.
    mean = Velocity(
        HALF * (m * state.vx + v.x), HALF * (state.vz + v.z), HALF * (u.omega + v.omega)
    )
    done = contact_work(one, p.n1, p.f1, mean) + contact_work(two, p.n2, p.f2, mean)
    done = done + contact_work(three, p.n3, p.f3, mean)
    lowest = smaller(two.gap, smaller(one.gap, three.gap))
    lift = -knobs.erp * smaller(lowest + fall_depth(dt, knobs.gravity, dz), real(0.0))
    loss = fused_less(knobs.gravity, lift, loss - done)
    ahead1, ahead3 = gap_after(dt, one, v), gap_after(dt, three, v)
    pushed = mirror(m, p)
    corners = Corners(
        feet.has_left, feet.has_right, pushed.n1, pushed.n2, pushed.n3,
        wp.where(left, ahead3, ahead1), gap_after(dt, two, v), wp.where(left, ahead1, ahead3),
    )  # fmt: skip
    vx, omega = m * v.x, m * v.omega
    after = State(
        fused(dt, vx, state.x), fused(dt, v.z, state.z) + lift, fused(dt, omega, state.theta),
        vx, v.z, omega,
    )  # fmt: skip
    return after, pushed, corners, lowest
