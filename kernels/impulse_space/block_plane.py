"""Contacts of a block that moves in a plane of its own symmetry, solved exactly.

Several motions may obey Coulomb's law after an impact with friction. A block that lands flat and
slides may tip over the edge ahead. It may also take the whole impulse on one corner of that edge
and turn about the vertical. Sweeps find the second motion, since the first corner leaves no impulse
for the next. A block whose state is its own mirror image also has a motion that is its own mirror
image. That motion is taken here.

Both corners of an edge across the plane then have the same impulses, and the contact problem is
that of the planar block: two edges A and B, B towards the lean, at the levers (x, h) along the
plane and upwards. Let s, w and o be the velocities along the plane and upwards and the angular
velocity, J the inverse moment of inertia, mass 1; f and n the friction and the normal impulse of an
edge. Then

    s' = s + f_A + f_B,    w' = w + n_A + n_B,    o' = o + J (h_A f_A - x_A n_A + h_B f_B - x_B n_B)

and an edge slips at s' + h o' and parts at w' - x o'. Each edge presses or not; if it presses, its
normal velocity equals its aim, and it sticks or slides to one of two sides. Each of these cases is
a linear system with a closed form. If both edges press, their aims give o' and w', so that the sums
of normal impulses and of moments are known. The first case whose result obeys the contact law is
the solution. Cases without sliding come first, then those that slide, then those that part.
`stop_contacts` (block_hold.py) has tried the case in which both stick before.

References:
    Stewart and Trinkle (1996), An implicit time-stepping scheme for rigid body dynamics with
    inelastic collisions and Coulomb friction.
"""

import warp as wp

from warprock.kernels.impulse_space.block import (
    Box,
    Contact,
    Corners,
    Impulse,
    Knobs,
    Lean,
    Velocity,
)
from warprock.kernels.impulse_space.block_hold import Four
from warprock.kernels.shape_space.contact import CONE
from warprock.kernels.shape_space.lanes import State, turn_of

PLANE = by_precision(1.0e-9, 1.0e-4)
"""Largest motion out of the plane, over the whole motion, that counts as round-off that grew."""
EXACT = by_precision(1.0e-11, 1.0e-4)
"""Residual of the contact law of a solution, over the velocities, that is round-off."""


@wp.struct
class Edge:
    """Two corners that are mirror images of each other.

    Attributes:
        x, h: Lever from the centre of mass, along the plane and upwards [m].
        aim: Least normal velocity after the step [m/s].
        on: 1 if it is a contact, else 0.
    """

    x: real
    h: real
    aim: real
    on: real


@wp.struct
class Speeds:
    """Motion in the plane: along it and upwards [m/s], and the angular velocity [rad/s]."""

    along: real
    up: real
    turn: real


@wp.struct
class Edges:
    """The contact problem of two edges.

    Attributes:
        a, b: The edges.
        free: Motion without contact.
        inertia: Inverse moment of inertia across the plane, for unit mass [1/m^2].
        mu: Friction coefficient.
        round_off: Allowed residual of the contact law [m/s].
    """

    a: Edge
    b: Edge
    free: Speeds
    inertia: real
    mu: real
    round_off: real


@wp.struct
class Shares:
    """Friction and normal impulses of the edges A and B, for mass 1 [m/s].

    `found` is 1 if they obey the contact law, else 0.
    """

    fa: real
    na: real
    fb: real
    nb: real
    found: real


@wp.func
def find_plane(knobs: Knobs, box: Box, s: State, u: Velocity) -> real:
    """The plane of symmetry in which a block moves: 1 along its width, 2 along its depth, 0 none.

    Friction as a box must have its axes there. u is the velocity without contact.
    """
    zero, h = real(0.0), box.half_height
    r = turn_of(s)
    # Velocities along the width and along the depth, with the rotation about the other axis.
    about_width = size(dot(r.r11, r.r21, u.turn_x, u.turn_y))
    about_depth = size(dot(r.r12, r.r22, u.turn_x, u.turn_y))
    wide = size(dot(r.r11, r.r21, u.x, u.y)) + h * about_depth
    deep = size(dot(r.r12, r.r22, u.x, u.y)) + h * about_width
    fall, yaw = knobs.gravity * knobs.time_step, h * size(u.turn_z)
    wide_only = deep + yaw <= PLANE * (wide + fall) and size(r.r32) <= PLANE
    deep_only = wide + yaw <= PLANE * (deep + fall) and size(r.r31) <= PLANE
    wide_only = wide_only and box.centre_y == zero
    deep_only = deep_only and box.centre_x == zero
    if not CONE:
        square = smaller(size(r.r21), size(r.r11)) <= PLANE
        wide_only = wide_only and square
        deep_only = deep_only and square
    return wp.where(wide_only, real(1.0), wp.where(deep_only, real(2.0), zero))


@wp.func
def mirror_corner(plane: real, x: Four) -> Four:
    """The number of the mirror image of each corner; without a plane, its own."""
    wide, deep = plane == real(1.0), plane == real(2.0)
    return Four(
        wp.where(wide, x.c, wp.where(deep, x.b, x.a)),
        wp.where(wide, x.d, wp.where(deep, x.a, x.b)),
        wp.where(wide, x.a, wp.where(deep, x.d, x.c)),
        wp.where(wide, x.b, wp.where(deep, x.c, x.d)),
    )


@wp.func
def with_mirror_aim(c: Contact, aim: real, on: real) -> Contact:
    """A corner with the mean aim of itself and its mirror image; a contact if either is."""
    return Contact(c.x, c.y, c.h, HALF * (c.aim + aim), larger(c.on, on))


@wp.func
def mirror_aims(plane: real, at: Corners) -> Corners:
    """Corners with the mean aims of themselves and their mirror images, contacts if either is.

    Without a plane they stay as they are. This removes round-off: a gap is a small difference of
    lengths, and an aim is a gap over the time step.
    """
    aim = mirror_corner(plane, Four(at.a.aim, at.b.aim, at.c.aim, at.d.aim))
    on = mirror_corner(plane, Four(at.a.on, at.b.on, at.c.on, at.d.on))
    return Corners(
        with_mirror_aim(at.a, aim.a, on.a), with_mirror_aim(at.b, aim.b, on.b),
        with_mirror_aim(at.c, aim.c, on.c), with_mirror_aim(at.d, aim.d, on.d),
    )  # fmt: skip


@wp.func
def edge_of(x: real, y: real, one: Contact, other: Contact) -> Edge:
    """The edge between two corners across a plane along the horizontal direction (x, y)."""
    lever = HALF * (dot(x, y, one.x, one.y) + dot(x, y, other.x, other.y))
    h, aim = HALF * (one.h + other.h), HALF * (one.aim + other.aim)
    return Edge(lever, h, aim, larger(one.on, other.on))


@wp.func
def apply_impulses(two: Edges, p: Shares) -> Speeds:
    """Motion after the impulses of both edges."""
    free, a, b, inertia = two.free, two.a, two.b, two.inertia
    moment = dot(a.h, b.h, p.fa, p.fb) - dot(a.x, b.x, p.na, p.nb)
    speed, up = free.along + p.fa + p.fb, free.up + p.na + p.nb
    return Speeds(speed, up, fused(inertia, moment, free.turn))


@wp.func
def violation(v: Speeds, edge: Edge, f: real, n: real, mu: real) -> real:
    """Residual of the contact law at an edge with the impulses f and n [m/s]."""
    bound = mu * larger(n, real(0.0))
    slip = fused(v.turn, edge.h, v.along)
    rise = fused_less(v.turn, edge.x, v.up) - edge.aim
    dragged = larger(smaller(f - slip, bound), -bound)
    pressed = larger(n - rise, real(0.0))
    return wp.where(edge.on > real(0.0), size(f - dragged) + size(n - pressed), real(0.0))


@wp.func
def try_shares(best: Shares, fits: bool, new: Shares, two: Edges) -> Shares:
    """The new impulses if they fit and obey the contact law and no earlier ones did; else best."""
    v = apply_impulses(two, new)
    off = violation(v, two.a, new.fa, new.na, two.mu) + violation(v, two.b, new.fb, new.nb, two.mu)
    takes = fits and best.found == real(0.0) and off <= two.round_off
    return Shares(
        wp.where(takes, new.fa, best.fa), wp.where(takes, new.na, best.na),
        wp.where(takes, new.fb, best.fb), wp.where(takes, new.nb, best.nb),
        wp.where(takes, real(1.0), best.found),
    )  # fmt: skip


@wp.func
def solve_alone(two: Edges, edge: Edge, side: real):
    """Friction and normal impulse of an edge that presses alone.

    It sticks if `side` is 0; else it slides to that side, -1 or 1.
    """
    free, inertia, mu = two.free, two.inertia, two.mu
    slip = fused(free.turn, edge.h, free.along)
    rise = fused_less(free.turn, edge.x, free.up) - edge.aim
    one, jh, jx = real(1.0), inertia * edge.h, inertia * edge.x
    kff, knn, kfn = fused(jh, edge.h, one), fused(jx, edge.x, one), -jx * edge.h
    over = one / fused(jh, edge.h, knn)
    f, n = over * (kfn * rise - knn * slip), over * (kfn * slip - kff * rise)
    push = -rise / (knn - side * mu * kfn)
    sticks = side == real(0.0)
    return wp.where(sticks, f, -side * mu * push), wp.where(sticks, n, push)


@wp.func
def place_impulse(free: bool, f: real, n: real) -> Shares:
    """Impulses of one edge alone: of A, or of B if A is free."""
    zero = real(0.0)
    return Shares(
        wp.where(free, zero, f), wp.where(free, zero, n), wp.where(free, f, zero),
        wp.where(free, n, zero), real(1.0),
    )  # fmt: skip


@wp.func
def solve_edges(two: Edges) -> Shares:
    """Impulses of two edges that obey the contact law; `found` is 0 without a solution."""
    zero, one = real(0.0), real(1.0)
    p, a, b, mu = Shares(), two.a, two.b, two.mu
    on_a, on_b = a.on > zero, b.on > zero
    both = on_a and on_b
    # One edge sticks, the other one parts.
    f, n = solve_alone(two, a, zero)
    p = try_shares(p, on_a, place_impulse(False, f, n), two)
    f, n = solve_alone(two, b, zero)
    p = try_shares(p, on_b, place_impulse(True, f, n), two)
    # Both press: the motion upwards and the turn, then sums of normal impulses and of moments.
    width = wp.where(both, b.x - a.x, one)
    turn = (a.aim - b.aim) / width
    push = fused(turn, a.x, a.aim) - two.free.up
    moment = (turn - two.free.turn) / two.inertia
    for to_b in range(2):
        side_b = real(2 * to_b - 1)
        for way in range(2):
            side_a = wp.where(way == 0, side_b, -side_b)
            ga, gb = -fused(side_a * mu, a.h, a.x), -fused(side_b * mu, b.h, b.x)
            n = fused_less(gb, push, moment) / (ga - gb)
            m = push - n
            p = try_shares(p, both, Shares(-side_a * mu * n, n, -side_b * mu * m, m, one), two)
    for to in range(2):
        side = real(2 * to - 1)
        # A sticks and B slides; B sticks and A slides.
        drag = -fused(turn, a.h, two.free.along)
        n = fused_less(a.x, push, a.h * drag) - moment
        n = n / fused(side * mu, b.h - a.h, width)
        f = -side * mu * n
        p = try_shares(p, both, Shares(drag - f, push - n, f, n, one), two)
        drag = -fused(turn, b.h, two.free.along)
        n = moment - fused_less(b.x, push, b.h * drag)
        n = n / fused(side * mu, b.h - a.h, width)
        f = -side * mu * n
        p = try_shares(p, both, Shares(f, n, drag - f, push - n, one), two)
    for to in range(2):
        side = real(2 * to - 1)
        f, n = solve_alone(two, a, side)
        p = try_shares(p, on_a, place_impulse(False, f, n), two)
        f, n = solve_alone(two, b, side)
        p = try_shares(p, on_b, place_impulse(True, f, n), two)
    return try_shares(p, True, Shares(zero, zero, zero, zero, one), two)


@wp.struct
class Solved:
    """Solution of the contacts of a block in its plane.

    Attributes:
        found: Whether it moves in a plane, touches, and has a solution.
        touches: Whether an edge presses.
        after: Velocity of the block after the impulses, exactly in its plane.
        a, b, c, d: Impulses of its corners.
    """

    found: bool
    touches: bool
    after: Velocity
    a: Impulse
    b: Impulse
    c: Impulse
    d: Impulse


@wp.func
def impulse_along(f: real, n: real, x: real, y: real) -> Impulse:
    """An impulse with the friction f in the horizontal direction (x, y)."""
    return Impulse(f * x, f * y, n)


@wp.func
def choose_contact(first: bool, one: Contact, other: Contact) -> Contact:
    """One of two contacts."""
    return Contact(
        wp.where(first, one.x, other.x), wp.where(first, one.y, other.y),
        wp.where(first, one.h, other.h), wp.where(first, one.aim, other.aim),
        wp.where(first, one.on, other.on),
    )  # fmt: skip


@wp.func
def find_edges(
    knobs: Knobs, box: Box, x: real, y: real, inertia: real, a: Edge, b: Edge, u: Velocity
) -> Edges:  # fmt: skip
    """The contact problem of two edges in the plane along (x, y); u is the velocity without it."""
    free = Speeds(dot(x, y, u.x, u.y), u.z, wedge(x, y, u.turn_x, u.turn_y))
    reach = size(a.x) + size(b.x) + size(a.h) + size(b.h)
    fall = knobs.gravity * knobs.time_step
    speed_scale = fall + size(free.along) + size(free.up) + reach * size(free.turn)
    return Edges(a, b, free, inertia, box.friction, EXACT * speed_scale)


@wp.func
def solve_in_plane(
    plane: real, knobs: Knobs, box: Box, lean: Lean, s: State, u: Velocity, at: Corners
) -> Solved:  # fmt: skip
    """Solves the contacts of a block that moves in a plane, if it does; see `find_plane`."""
    zero, wide = real(0.0), plane == real(1.0)
    r = turn_of(s)
    # Unit vector of the horizontal direction of the plane, towards the lean.
    x = wp.where(wide, lean.x * r.r22, -lean.y * r.r21)
    y = wp.where(wide, -lean.x * r.r12, lean.y * r.r11)
    inertia = wp.where(wide, box.inverse_y, box.inverse_x)
    # The corner a belongs to the edge A, the corner d to B, the others as the plane lies.
    first = edge_of(x, y, at.a, choose_contact(wide, at.c, at.b))
    second = edge_of(x, y, at.d, choose_contact(wide, at.b, at.c))
    two = find_edges(knobs, box, x, y, inertia, first, second, u)
    p = solve_edges(two)
    v = apply_impulses(two, p)
    found = plane > zero and p.found > zero and at.a.on + at.b.on + at.c.on + at.d.on > zero
    fa, na, fb, nb = HALF * p.fa, HALF * larger(p.na, zero), HALF * p.fb, HALF * larger(p.nb, zero)
    return Solved(
        found, found and na + nb > zero,
        Velocity(v.along * x, v.along * y, v.up, -v.turn * y, v.turn * x, zero),
        impulse_along(fa, na, x, y),
        impulse_along(wp.where(wide, fb, fa), wp.where(wide, nb, na), x, y),
        impulse_along(wp.where(wide, fa, fb), wp.where(wide, na, nb), x, y),
        impulse_along(fb, nb, x, y),
    )  # fmt: skip
