"""Contacts of a block that moves in a plane of its own symmetry, solved exactly.

Several motions may obey Coulomb's law after an impact with friction. A block that comes down flat
and slides may tip over the edge ahead. It may as well take the whole blow on one corner of that
edge and turn about the vertical. Corners that are visited in turn find the second motion: the first
corner leaves the next one nothing to carry. A block whose state is its own mirror image has a
motion that is its own mirror image, too, and that one is taken here.

Both corners of an edge across the plane then carry the same, and the contact problem is that of the
planar block: two edges A and B, B towards the lean, at the levers (x, h) along the plane and
upwards. Let s, w and o be speeds along the plane and upwards and the angular velocity, J the
inverse moment of inertia, mass 1; f and n the friction and the normal impulse of an edge. Then

    s' = s + f_A + f_B,    w' = w + n_A + n_B,    o' = o + J (h_A f_A - x_A n_A + h_B f_B - x_B n_B)

and an edge slips at s' + h o' and parts at w' - x o'. Each edge presses or not; if it presses, its
normal velocity is what it aims at, and it sticks or slides to one of two sides. Each of these cases
is a linear system with a closed form. Where both edges press, their aims give o' and w', so that
both edges share known sums of normal impulses and of moments. The first case whose result obeys
the law of contact is the solution. Cases stand in this order: what leaves no edge to slide, what
slides, what parts. In `hold` (block_hold.py) stands the case before them, in which both stick.

References:
    Stewart and Trinkle (1996), An implicit time-stepping scheme for rigid body dynamics with
    inelastic collisions and Coulomb friction.
"""

import warp as wp

from warprock.kernels.impulse_space.block import Knobs
from warprock.kernels.impulse_space.block_hold import keep
from warprock.kernels.shape_space.block import matrix_of
from warprock.kernels.shape_space.contact import CONE

PLANE = by_precision(1.0e-9, 1.0e-4)
"""Part of its motion by which a block may leave a plane that it moves in: round-off that grew."""
EXACT = by_precision(1.0e-11, 1.0e-4)
"""Part of the speeds by which a solution may miss the law of contact: round-off."""


@wp.struct
class Edge:
    """Two corners that are mirror images of each other.

    Attributes:
        x, h: Lever from the centre of mass, along the plane and upwards [m].
        aim: Normal velocity that it asks for [m/s].
        on: 1 where it is a contact, else 0.
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
class Shares:
    """Friction and normal impulses of the edges A and B, for mass 1 [m/s].

    `found` is 1 where they obey the law of contact, else 0.
    """

    fa: real
    na: real
    fb: real
    nb: real
    found: real


@wp.func
def find_plane(
    knobs: Knobs, half_height: real, cx: real, cy: real, qx: real, qy: real, qz: real, qw: real,
    ux: real, uy: real, ox: real, oy: real, oz: real,
) -> real:  # fmt: skip
    """The plane of its symmetry that a block moves in: 1 along its width, 2 along its depth.

    0 where it moves in neither. Friction within a box must have its axes there.

    Args:
        knobs: Settings.
        half_height: Of the block [m].
        cx, cy: Its centre of mass from the middle [m].
        qx, qy, qz, qw: Its attitude.
        ux, uy: Horizontal velocity without contact [m/s].
        ox, oy, oz: Angular velocity [rad/s].
    """
    zero = real(0.0)
    r11, r12, _13, r21, r22, _23, r31, r32, _33 = matrix_of(qx, qy, qz, qw)
    # Speeds along the width and along the depth, in both the turn about the other axis.
    wide = size(dot(r11, r21, ux, uy)) + half_height * size(dot(r12, r22, ox, oy))
    deep = size(dot(r12, r22, ux, uy)) + half_height * size(dot(r11, r21, ox, oy))
    fall, yaw = knobs.gravity * knobs.time_step, half_height * size(oz)
    wide_only = deep + yaw <= PLANE * (wide + fall) and size(r32) <= PLANE and cy == zero
    deep_only = wide + yaw <= PLANE * (deep + fall) and size(r31) <= PLANE and cx == zero
    if not CONE:
        square = smaller(size(r21), size(r11)) <= PLANE
        wide_only = wide_only and square
        deep_only = deep_only and square
    return wp.where(wide_only, real(1.0), wp.where(deep_only, real(2.0), zero))


@wp.func
def edge_of(
    along_x: real, along_y: real, x0: real, y0: real, h0: real, aim0: real, on0: real,
    x1: real, y1: real, h1: real, aim1: real, on1: real,
) -> Edge:  # fmt: skip
    """The edge between two corners at the levers (x0, y0, h0) and (x1, y1, h1)."""
    x = HALF * (dot(along_x, along_y, x0, y0) + dot(along_x, along_y, x1, y1))
    return Edge(x, HALF * (h0 + h1), HALF * (aim0 + aim1), larger(on0, on1))


@wp.func
def level(
    plane: real, aim0: wp.ref[real], aim1: wp.ref[real], aim2: wp.ref[real], aim3: wp.ref[real],
    on0: wp.ref[real], on1: wp.ref[real], on2: wp.ref[real], on3: wp.ref[real],
):  # fmt: skip
    """Both corners of an edge are contacts if one is, and aim at the same, where there is a plane.

    A gap is a small difference of lengths, and an aim is a gap over the time step.
    """
    wide, deep = plane == real(1.0), plane == real(2.0)
    a0, a1, a2, a3 = real(aim0), real(aim1), real(aim2), real(aim3)
    aim0 = HALF * (a0 + wp.where(wide, a2, wp.where(deep, a1, a0)))
    aim1 = HALF * (a1 + wp.where(wide, a3, wp.where(deep, a0, a1)))
    aim2 = HALF * (a2 + wp.where(wide, a0, wp.where(deep, a3, a2)))
    aim3 = HALF * (a3 + wp.where(wide, a1, wp.where(deep, a2, a3)))
    a0 = real(on0)
    a1 = real(on1)
    a2 = real(on2)
    a3 = real(on3)
    on0 = larger(a0, wp.where(wide, a2, wp.where(deep, a1, a0)))
    on1 = larger(a1, wp.where(wide, a3, wp.where(deep, a0, a1)))
    on2 = larger(a2, wp.where(wide, a0, wp.where(deep, a3, a2)))
    on3 = larger(a3, wp.where(wide, a1, wp.where(deep, a2, a3)))


@wp.func
def moved(free: Speeds, inertia: real, a: Edge, b: Edge, p: Shares) -> Speeds:
    """Motion after the impulses of both edges."""
    moment = dot(a.h, b.h, p.fa, p.fb) - dot(a.x, b.x, p.na, p.nb)
    along, up = free.along + p.fa + p.fb, free.up + p.na + p.nb
    return Speeds(along, up, fused(inertia, moment, free.turn))


@wp.func
def misses(v: Speeds, edge: Edge, f: real, n: real, mu: real) -> real:
    """By how much an edge with the impulses f and n misses the law of contact [m/s]."""
    bound = mu * larger(n, real(0.0))
    slip = fused(v.turn, edge.h, v.along)
    rise = fused_less(v.turn, edge.x, v.up) - edge.aim
    dragged = larger(smaller(f - slip, bound), -bound)
    pressed = larger(n - rise, real(0.0))
    return wp.where(edge.on > real(0.0), size(f - dragged) + size(n - pressed), real(0.0))


@wp.func
def try_shares(
    best: Shares, fits: bool, fa: real, na: real, fb: real, nb: real,
    free: Speeds, inertia: real, a: Edge, b: Edge, mu: real, round_off: real,
) -> Shares:  # fmt: skip
    """These impulses, where they fit and obey the law of contact and none before them did."""
    new = Shares(fa, na, fb, nb, real(1.0))
    v = moved(free, inertia, a, b, new)
    off = misses(v, a, fa, na, mu) + misses(v, b, fb, nb, mu)
    takes = fits and best.found == real(0.0) and off <= round_off
    return Shares(
        wp.where(takes, fa, best.fa), wp.where(takes, na, best.na),
        wp.where(takes, fb, best.fb), wp.where(takes, nb, best.nb),
        wp.where(takes, real(1.0), best.found),
    )  # fmt: skip


@wp.func
def alone(free: Speeds, inertia: real, e: Edge, mu: real, side: real):
    """Friction and normal impulse of an edge that presses alone.

    It sticks where `side` is 0; else it slides to that side, -1 or 1.
    """
    slip, rise = fused(free.turn, e.h, free.along), fused_less(free.turn, e.x, free.up) - e.aim
    one, jh, jx = real(1.0), inertia * e.h, inertia * e.x
    kff, knn, kfn = fused(jh, e.h, one), fused(jx, e.x, one), -jx * e.h
    over = one / fused(jh, e.h, knn)
    f, n = over * (kfn * rise - knn * slip), over * (kfn * slip - kff * rise)
    push = -rise / (knn - side * mu * kfn)
    sticks = side == real(0.0)
    return wp.where(sticks, f, -side * mu * push), wp.where(sticks, n, push)


@wp.func
def solve_edges(free: Speeds, inertia: real, a: Edge, b: Edge, mu: real, fall: real) -> Shares:
    """Impulses of two edges that obey the law of contact; `found` is 0 where none is found."""
    zero, one = real(0.0), real(1.0)
    p = Shares(zero, zero, zero, zero, zero)
    on_a, on_b = a.on > zero, b.on > zero
    both = on_a and on_b
    reach = size(a.x) + size(b.x) + size(a.h) + size(b.h)
    round_off = EXACT * (fall + size(free.along) + size(free.up) + reach * size(free.turn))
    # One edge sticks, the other one parts.
    f, n = alone(free, inertia, a, mu, zero)
    p = try_shares(p, on_a, f, n, zero, zero, free, inertia, a, b, mu, round_off)
    f, n = alone(free, inertia, b, mu, zero)
    p = try_shares(p, on_b, zero, zero, f, n, free, inertia, a, b, mu, round_off)
    # Both press: the motion upwards and the turn, then sums of normal impulses and of moments.
    width = wp.where(both, b.x - a.x, one)
    turn = (a.aim - b.aim) / width
    push = fused(turn, a.x, a.aim) - free.up
    moment = (turn - free.turn) / inertia
    for to_b in range(2):
        side_b = real(2 * to_b - 1)
        for way in range(2):
            side_a = wp.where(way == 0, side_b, -side_b)
            ga, gb = -fused(side_a * mu, a.h, a.x), -fused(side_b * mu, b.h, b.x)
            n = fused_less(gb, push, moment) / (ga - gb)
            m = push - n
            p = try_shares(
                p, both, -side_a * mu * n, n, -side_b * mu * m, m, free, inertia, a, b, mu,
                round_off,
            )  # fmt: skip
    for to in range(2):
        side = real(2 * to - 1)
        # A sticks and B slides; B sticks and A slides.
        drag = -fused(turn, a.h, free.along)
        n = fused_less(a.x, push, a.h * drag) - moment
        n = n / fused(side * mu, b.h - a.h, width)
        f = -side * mu * n
        p = try_shares(
            p, both, drag - f, push - n, f, n, free, inertia, a, b, mu, round_off
        )  # fmt: skip
        drag = -fused(turn, b.h, free.along)
        n = moment - fused_less(b.x, push, b.h * drag)
        n = n / fused(side * mu, b.h - a.h, width)
        f = -side * mu * n
        p = try_shares(
            p, both, f, n, drag - f, push - n, free, inertia, a, b, mu, round_off
        )  # fmt: skip
    for to in range(2):
        side = real(2 * to - 1)
        f, n = alone(free, inertia, a, mu, side)
        p = try_shares(p, on_a, f, n, zero, zero, free, inertia, a, b, mu, round_off)
        f, n = alone(free, inertia, b, mu, side)
        p = try_shares(p, on_b, zero, zero, f, n, free, inertia, a, b, mu, round_off)
    return try_shares(p, True, zero, zero, zero, zero, free, inertia, a, b, mu, round_off)


@wp.func
def solve_in_plane(
    plane: real, knobs: Knobs, lean_x: real, lean_y: real, mu: real,
    qx: real, qy: real, qz: real, qw: real, ix: real, iy: real,
    x0: real, x1: real, x2: real, x3: real, y0: real, y1: real, y2: real, y3: real,
    h0: real, h1: real, h2: real, h3: real, aim0: real, aim1: real, aim2: real, aim3: real,
    on0: wp.ref[real], on1: wp.ref[real], on2: wp.ref[real], on3: wp.ref[real],
    fx0: wp.ref[real], fx1: wp.ref[real], fx2: wp.ref[real], fx3: wp.ref[real],
    fy0: wp.ref[real], fy1: wp.ref[real], fy2: wp.ref[real], fy3: wp.ref[real],
    n0: wp.ref[real], n1: wp.ref[real], n2: wp.ref[real], n3: wp.ref[real],
    ux: wp.ref[real], uy: wp.ref[real], uz: wp.ref[real],
    ox: wp.ref[real], oy: wp.ref[real], oz: wp.ref[real],
):  # fmt: skip
    """Solves the contacts of a block that moves in a plane, if it does; see `find_plane`.

    Then its velocities and impulses are those, and no corner is left to the sweeps: `on` becomes 0.
    """
    zero = real(0.0)
    r11, r12, _13, r21, r22, _23, _31, _32, _33 = matrix_of(qx, qy, qz, qw)
    wide = plane == real(1.0)
    # The plane's horizontal direction, towards the lean, and its normal; both are unit vectors.
    ax = wp.where(wide, lean_x * r22, -lean_y * r21)
    ay = wp.where(wide, -lean_x * r12, lean_y * r11)
    inertia = wp.where(wide, iy, ix)
    # The corner 0 belongs to the edge A, the corner 3 to B, the others as the plane lies.
    x, y, h = wp.where(wide, x2, x1), wp.where(wide, y2, y1), wp.where(wide, h2, h1)
    a = edge_of(
        ax, ay, x0, y0, h0, aim0, on0, x, y, h, wp.where(wide, aim2, aim1),
        wp.where(wide, on2, on1),
    )  # fmt: skip
    x, y, h = wp.where(wide, x1, x2), wp.where(wide, y1, y2), wp.where(wide, h1, h2)
    b = edge_of(
        ax, ay, x3, y3, h3, aim3, on3, x, y, h, wp.where(wide, aim1, aim2),
        wp.where(wide, on1, on2),
    )  # fmt: skip
    free = Speeds(dot(ax, ay, ux, uy), uz, wedge(ax, ay, ox, oy))
    p = solve_edges(free, inertia, a, b, mu, knobs.gravity * knobs.time_step)
    v = moved(free, inertia, a, b, p)
    solved = plane > zero and p.found > zero and on0 + on1 + on2 + on3 > zero
    fa, na, fb, nb = HALF * p.fa, HALF * larger(p.na, zero), HALF * p.fb, HALF * larger(p.nb, zero)
    f, n = wp.where(wide, fb, fa), wp.where(wide, nb, na)
    keep(solved, fa * ax, fa * ay, na, fx0, fy0, n0)
    keep(solved, f * ax, f * ay, n, fx1, fy1, n1)
    f, n = wp.where(wide, fa, fb), wp.where(wide, na, nb)
    keep(solved, f * ax, f * ay, n, fx2, fy2, n2)
    keep(solved, fb * ax, fb * ay, nb, fx3, fy3, n3)
    # What touches moves in its plane, without the round-off.
    touches = solved and na + nb > zero
    keep(touches, v.along * ax, v.along * ay, v.up, ux, uy, uz)
    keep(touches, -v.turn * ay, v.turn * ax, zero, ox, oy, oz)
    on0 = wp.where(solved, zero, on0)
    on1 = wp.where(solved, zero, on1)
    on2 = wp.where(solved, zero, on2)
    on3 = wp.where(solved, zero, on3)
