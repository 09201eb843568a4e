"""The contact law of a body in space that stands on points: which points carry, stick or slide.

The motion of a body on points depends only on the corners of their convex hull: if no corner sinks,
no point does. So few states are possible. They are tried in this order, and the first that obeys
the law is taken, as for the box:

    1. one or two points, or all on a line, whose ends count: the law of a corner and of an edge,
       event_space/block/law.py;
    2. the points span a plane: the face sticks, event_space/body/face.py;
    3. the body turns over a sticking edge of the hull: edge by edge, until no point sinks;
    4. the face slides;
    5. the body turns over an edge of which both ends push, by the law of an edge;
    6. the body turns over a corner;
    7. the body leaves the base, and no point sinks.

Gauss-Seidel sweeps from point to point converge more slowly the more points there are. They are
used only if all of these fail: friction then leaves several solutions of the law, or none
(Painleve).
"""

import warp as wp

from warprock.kernels.algebra.vectors import Matrix, Vector
from warprock.kernels.event_space.block.contact import (
    BOX,
    EDGE,
    Body,
    Corners,
    direction_of,
    try_sticking,
)
from warprock.kernels.event_space.block.slide import solve_swing, try_slipping
from warprock.kernels.event_space.body.contact import (
    ALL,
    Carried,
    PointGains,
    PointNumbers,
    Points,
    Pose,
    Shape,
    Touches,
    bit_of,
    is_among,
    spans_plane,
    touches_of,
)
from warprock.kernels.event_space.body.face import (
    INSIDE,
    first_on_hull,
    next_on_hull,
    slide_flat,
    stick_flat,
    sticks,
)
from warprock.kernels.shape_space.body import APART
from warprock.kernels.shape_space.contact import (
    gains_of,
    solve_contact,
)
from warprock.kernels.shape_space.frame import relative_velocity

if FRICTION == "box":
    from warprock.kernels.event_space.block.box_friction import project, sliding_bits
    from warprock.kernels.event_space.block.box_friction import solve as solve_two
else:
    from warprock.kernels.event_space.block.law import project, sliding_bits
    from warprock.kernels.event_space.block.law import solve as solve_two

BEGINNINGS = 12
"""Directions from which those of an edge that slides are sought: beside either end to either side,
and eight in which both ends slide alike."""
SWEEPS = 4000
"""Largest number of sweeps of a solve."""
WHOLE = 60
"""Sweeps of a solve that take the whole change of a point. Later ones take half of it, so that no
point alternates."""
SETTLED = by_precision(1.0e-14, 1.0e-6)
"""Change of the velocities in a sweep, over those without contact, that is round-off."""
LOOSE = by_precision(1.0e-6, 1.0e-3)
"""Change above which a solve that used all sweeps has failed."""
DUST = by_precision(1.0e-12, 1.0e-5)
"""Round-off of a velocity, as a part of the largest."""


@wp.func
def block_on_two(s: Shape, pose: Pose, one: Vector, other: Vector) -> Body:
    """The body as a block whose edge 0 has its ends at two levers [m]."""
    b = Body()
    b.inertia = pose.inertia
    b.inverse = pose.inverse
    b.friction = s.friction
    for k in range(4):
        b.corners[k] = one
    b.corners[1] = other
    return b


@wp.func
def start_directions(two: Body, number: int, v: Vector, w: Vector) -> Corners:
    """First guess of the directions in which both ends of an edge slide: one of BEGINNINGS."""
    dirs = Corners()
    if number < 4:
        # Beside an end that sticks, if it could; it cannot, and goes where it is pushed.
        side = wp.where(number < 2, real(1.0), real(-1.0))
        k = number % 2
        swing = solve_swing(two, k, 1 - k, side, v, w)
        d = swing.d
        push = swing.v - v + (two.friction * swing.n) * Vector(d[0], d[1], real(0.0))
        a = direction_of(push)
        dirs[k] = Vector(-a[0], -a[1], real(0.0))
        dirs[1 - k] = Vector(d[0], d[1], real(0.0))
    else:
        x, y = cycle(real(number) / real(BEGINNINGS - 4))
        dirs[0] = Vector(x, y, real(0.0))
        dirs[1] = Vector(x, y, real(0.0))
    return dirs


@wp.func(inline=False)
def solve_edge(
    s: Shape, pose: Pose, t: Touches, i: int, j: int, grain: real, v: Vector, w: Vector
) -> Carried:
    """The motion if only points i and j push; if i = j, only that one."""
    two, stance = block_on_two(s, pose, t.lever[i], t.lever[j]), wp.where(i == j, 0, EDGE)
    h = solve_two(two, stance, 0, Corners(), v, w, grain)
    if not BOX:
        # If Newton's method for the directions has failed, it starts from other ones.
        for number in range(BEGINNINGS):
            if not h.fits and i != j:
                h = try_slipping(
                    two, EDGE, 3, False, start_directions(two, number, v, w), v, w, grain
                )
    c = Carried()
    c.v = h.v
    c.w = h.w
    c.fits = h.fits
    slides = (h.slip | (h.slip >> 4)) & 3
    if h.stance == 0 or h.stance == EDGE:
        c.held = bit_of(t.which[i])
        c.stuck = wp.where((slides & 1) == 0, c.held, wp.uint64(0))
    if h.stance == 1 or h.stance == EDGE:
        bit = bit_of(t.which[j])
        c.held = c.held | bit
        c.stuck = c.stuck | wp.where((slides & 2) == 0, bit, wp.uint64(0))
    return c


@wp.func
def sinks(t: Touches, grain: real, v: Vector, w: Vector) -> bool:
    """Whether a touching point moves into the base."""
    found, total = bool(False), t.total
    for k in range(total):
        found = found or v[2] + w[0] * t.lever[k][1] - w[1] * t.lever[k][0] < -grain
    return found


@wp.func(inline=False)
def stick_edge(
    s: Shape, pose: Pose, t: Touches, i: int, j: int, grain: real, v: Vector, w: Vector
) -> Carried:
    """The motion over the edge from point i to point j if it sticks."""
    c = Carried()
    h = try_sticking(block_on_two(s, pose, t.lever[i], t.lever[j]), EDGE, 3, v, w, grain)
    c.held = bit_of(t.which[i]) | bit_of(t.which[j])
    c.v = h.v
    c.w = h.w
    c.fits = h.fits
    c.stuck = c.held
    return c


@wp.func(inline=False)
def solve_hull(
    s: Shape, pose: Pose, t: Touches, stick: bool, grain: real, v: Vector, w: Vector
) -> Carried:  # fmt: skip
    """The motion over an edge or a corner of the hull of the points that touch.

    An edge that sticks where `stick` holds. Else one of which both ends push, whatever they do
    besides; where there is none, a corner, which is an edge of which one end pushes.
    """
    best, corner, total = Carried(), Carried(), t.total
    first = first_on_hull(t)
    i, turns = int(first), int(0)
    while not best.fits and turns < total:
        j = next_on_hull(t, APART * s.reach * s.reach, i)
        if stick:
            c = stick_edge(s, pose, t, i, j, grain, v, w)
        else:
            c = solve_edge(s, pose, t, i, j, grain, v, w)
        if c.fits and c.held != wp.uint64(0) and not sinks(t, grain, c.v, c.w):
            if c.held == (bit_of(t.which[i]) | bit_of(t.which[j])):
                best = c
            elif not corner.fits:
                corner = c
        i = int(j)
        turns = wp.where(i == first, total, turns + 1)
    if corner.fits and not best.fits:
        best = corner
    return best


@wp.func
def ends_of(t: Touches):
    """The two ends of points on a line."""
    i, j, total = int(0), int(0), t.total
    for k in range(total):
        i = wp.where(squared_distance(t, k, 0) > squared_distance(t, i, 0), k, i)
    for k in range(total):
        j = wp.where(squared_distance(t, k, i) > squared_distance(t, j, i), k, j)
    return i, j


@wp.func
def squared_distance(t: Touches, k: int, i: int) -> real:
    """Square of the distance of two points in plan [m^2]."""
    x, y = t.lever[k][0] - t.lever[i][0], t.lever[k][1] - t.lever[i][1]
    return x * x + y * y


@wp.func(inline=False)
def solve_by_sweeps(
    s: Shape, pose: Pose, t: Touches, least: PointNumbers, v: Vector, w: Vector
) -> Carried:
    """The motion found point by point, until nothing changes but round-off (Gauss-Seidel).

    Each point pushes by no less than its normal impulse in `least` [m/s], which v and w contain.
    """
    zero = real(0.0)
    c = Carried()
    c.v = v
    c.w = w
    p, gains = Points(), PointGains()
    e, none, total = wp.identity(n=3, dtype=real), Vector(), t.total
    for k in range(total):
        gains[k] = gains_of(real(1.0), e, pose.inverse, Matrix(), t.lever[k], none)
        p[k] = Vector(zero, zero, least[k])
    norm_sq = wp.length_sq(v) + s.reach * s.reach * wp.length_sq(w)
    change, step = real(norm_sq), int(0)
    while change > SETTLED * SETTLED * norm_sq and step < SWEEPS:
        u0, o0 = c.v + Vector(), c.w + Vector()
        part = wp.where(step > WHOLE, HALF, real(1.0))
        for turn in range(total):
            k = wp.where(step % 2 == 0, turn, total - 1 - turn)
            r = t.lever[k]
            u = relative_velocity(c.v, c.w, r, none, none, none)
            new = solve_contact(s.friction, least[k], gains[k], e, p[k], u)
            more = part * (new - p[k])
            p[k] = p[k] + more
            c.v = c.v + more
            c.w = c.w + pose.inverse * wp.cross(r, more)
        change = wp.length_sq(c.v - u0) + s.reach * s.reach * wp.length_sq(c.w - o0)
        step += 1
    c.fits = change <= LOOSE * LOOSE * norm_sq
    for k in range(total):
        if p[k][2] > zero:
            bit = bit_of(t.which[k])
            c.held = c.held | bit
            if sticks(p[k], INSIDE * s.friction * p[k][2]):
                c.stuck = c.stuck | bit
    return c


@wp.func(inline=False)
def solve(s: Shape, pose: Pose, t: Touches, dust: real, v: Vector, w: Vector) -> Carried:
    """The motion that obeys the law of contact; see the head of this file.

    Args:
        s: The body.
        pose: Where it is.
        t: The points that touch.
        dust: Velocity that gravity gives in the longest step [m/s], of which round-off is a part.
        v, w: Velocity [m/s] and angular velocity [rad/s] without contact.
    """
    c = Carried()
    c.v = v
    c.w = w
    c.fits = t.total == 0
    grain = DUST * (wp.length(v) + wp.length(w) * s.reach + dust)
    if t.total > 0 and not spans_plane(t, ALL):
        i, j = ends_of(t)
        c = solve_edge(s, pose, t, i, j, grain, v, w)
    elif t.total > 0:
        c = stick_flat(s, pose, t, v, w)
        if not c.fits and c.held == wp.uint64(0):
            c = solve_hull(s, pose, t, True, grain, v, w)
        if not c.fits:
            c = slide_flat(s, pose, t, v, w)
        if not c.fits:
            c = solve_hull(s, pose, t, False, grain, v, w)
        if not c.fits and not sinks(t, grain, v, w):
            c = Carried()
            c.v = v
            c.w = w
            c.fits = True
        if not c.fits:
            c = solve_by_sweeps(s, pose, t, PointNumbers(), v, w)
    return c


@wp.func
def project_on_points(
    s: Shape, pose: Pose, held: wp.uint64, stuck: wp.uint64, v: Vector, w: Vector
):
    """Velocities projected on the points that pushed, along their force."""
    v1, w1, t = v + Vector(), w + Vector(), touches_of(s, pose.turn, held)
    flat = spans_plane(t, ALL)
    if flat and held == stuck:
        v1 = Vector()
        w1 = Vector()
    elif flat:
        v1 = Vector(v[0], v[1], real(0.0))
        w1 = Vector(real(0.0), real(0.0), w[2])
    elif t.total > 0:
        i, j = ends_of(t)
        slip = wp.where(is_among(t.which[i], stuck), 0, 1)
        slip = slip | wp.where(i == j or is_among(t.which[j], stuck), 0, 2)
        v2, w2 = project(
            block_on_two(s, pose, t.lever[i], t.lever[j]), wp.where(i == j, 0, EDGE),
            wp.where(slip == 0, 0, sliding_bits(slip)), v, w,
        )  # fmt: skip
        v1 = v2
        w1 = w2
    return v1, w1
