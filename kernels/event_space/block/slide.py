"""Sliding contact of one block in space; see event_space/block/contact.py.

A sliding corner has the impulse p = n (-friction d, 1), d the direction of its velocity afterwards.
For given d the normal impulses n of a stance solve linear equations. Newton's method finds the d
that equal the directions of the velocities.
"""

import warp as wp

from warprock.kernels.algebra.vectors import Matrix, Vector
from warprock.kernels.event_space.block.contact import (
    EDGE,
    FLAT,
    Body,
    Corners,
    Held,
    Shares,
    Two,
    corner_matrix,
    corner_velocity,
    direction_of,
    face_shares,
    lies_inside,
    mask_of,
    sinks,
)

ALIKE = by_precision(1.0e-14, 1.0e-6)
"""Change of a direction [rad] that is round-off."""
GOOD = by_precision(1.0e-9, 1.0e-4)
"""Change of a direction [rad] up to which a search that has not converged is accepted."""
LITTLE = by_precision(1.0e-7, 1.0e-3)
"""Turn of a direction for the slope by differences [rad]."""
STEEPEST = real(0.5)
"""Largest turn of a direction in one of Newton's steps [rad]."""
TURNS = 60
"""Steps of Newton's method, or of the iteration for the directions of sliding."""


@wp.func
def solve_sliding_corner(m: Matrix, u: Vector, mu: real, start: Two):
    """Impulse of a corner that slides, and the direction of its velocity afterwards.

    Args:
        m: `corner_matrix` of the corner.
        u: Its velocity without contact [m/s].
        mu: Friction coefficient.
        start: Direction to start from.

    Returns:
        Normal impulse [m/s], direction, whether that is the direction of the velocity.
    """
    d = start
    n = real(0.0)
    turn = real(1.0)
    ahead = real(0.0)
    weight = real(1.0)
    tries = int(0)
    while size(turn) > ALIKE and tries < TURNS:
        e = Two(-d[1], d[0])
        f = m * Vector(-mu * d[0], -mu * d[1], real(1.0))
        rate = m * Vector(-mu * e[0], -mu * e[1], real(0.0))
        weight = f[2]
        n = -u[2] / weight
        change = -n * rate[2] / weight
        tx = u[0] + n * f[0]
        ty = u[1] + n * f[1]
        ahead = tx * d[0] + ty * d[1]
        aside = tx * e[0] + ty * e[1]
        bend = -ahead + e[0] * (change * f[0] + n * rate[0]) + e[1] * (change * f[1] + n * rate[1])
        # The step never leads away from the direction of the velocity.
        bend = wp.where(bend < -TINY, bend, -TINY)
        turn = wp.where(aside == real(0.0), real(0.0), -aside / bend)
        turn = larger(smaller(turn, STEEPEST), -STEEPEST)
        d = wp.normalize(d + turn * e)
        tries += 1
    sound = n >= real(0.0) and weight > real(0.0) and ahead >= real(0.0)
    return n, d, sound and size(turn) <= GOOD


@wp.func
def solve_sliding_face(body: Body, mu: real, dirs: Corners, pressed: Shares, v: Vector, w: Vector):
    """`solve_sliding` for a flat block."""
    zero = real(0.0)
    p = Vector(zero, zero, -v[2])
    torsion = real(0.0)
    for k in range(4):
        fx = -mu * pressed[k] * dirs[k, 0]
        fy = -mu * pressed[k] * dirs[k, 1]
        p = p + Vector(fx, fy, zero)
        torsion += body.corners[k, 0] * fy - body.corners[k, 1] * fx
    spin = body.inertia * w
    low = -body.corners[0, 2]
    x = (spin[1] - low * p[0]) / larger(p[2], TINY)
    y = (-spin[0] - low * p[1]) / larger(p[2], TINY)
    n = p[2] * face_shares(body, x, y)
    sound = p[2] >= zero and lies_inside(body, x, y)
    v_after = Vector(v[0] + p[0], v[1] + p[1], zero)
    w_after = Vector(zero, zero, w[2] + torsion / body.inertia[2, 2])
    return v_after, w_after, n, sound


@wp.struct
class Push:
    """Impulse at a corner that slides, for a normal impulse of 1: itself, and the spin it gives."""

    force: Vector
    spin: Vector


@wp.func
def push_of(body: Body, k: int, mu: real, d: Vector) -> Push:
    """The impulse at corner k if it slides in direction d."""
    force = Vector(-mu * d[0], -mu * d[1], real(1.0))
    return Push(force, body.inverse * wp.cross(body.corners[k], force))


@wp.func
def velocity_by_push(body: Body, push: Push, at: int) -> real:
    """Change of the upward velocity of corner `at`."""
    return (push.force + wp.cross(push.spin, body.corners[at]))[2]


@wp.struct
class EdgeSlide:
    """Motion of a block both ends of whose edge slide in given directions.

    Velocity and angular velocity; normal impulses of both ends [m/s]; sound, whether friction does
    not jam them.
    """

    v: Vector
    w: Vector
    n: Two
    sound: bool


@wp.func
def slide_edge(
    body: Body, stance: int, one: Push, other: Push, sinking: Two, v: Vector, w: Vector
) -> EdgeSlide:  # fmt: skip
    """The motion of a block on an edge whose ends slide with given impulses.

    `sinking` has the upward velocities of both ends without contact [m/s].
    """
    i = stance % 4
    j = (i + 1) % 4
    a11, a12 = velocity_by_push(body, one, i), velocity_by_push(body, other, i)
    a21, a22 = velocity_by_push(body, one, j), velocity_by_push(body, other, j)
    det = a11 * a22 - a12 * a21
    n = Two(
        (a12 * sinking[1] - a22 * sinking[0]) / det, (a21 * sinking[0] - a11 * sinking[1]) / det
    )
    # If a tall block slides upright on an edge, friction may jam the roll over one of its
    # ends (det < 0). Equal impulses at both ends are still a solution if they stop the
    # sinking.
    stops = n[0] * sinking[0] + n[1] * sinking[1] < real(0.0)
    sound = (det > real(0.0) and a11 > real(0.0)) or stops
    v_after = v + n[1] * other.force
    w_after = w + n[1] * other.spin
    return EdgeSlide(v_after + n[0] * one.force, w_after + n[0] * one.spin, n, sound)


@wp.func(inline=False)
def solve_sliding(
    body: Body, stance: int, mu: real, dirs: Corners, pressed: Shares, v: Vector, w: Vector
):
    """Velocities of a block that slides in given directions, and the normal impulses.

    Args:
        body: The block.
        stance: Its stance.
        mu: Friction coefficient.
        dirs: Directions in which its corners slide.
        pressed: Normal impulses from which the friction of a flat block follows.
        v: Velocity without contact [m/s].
        w: Angular velocity without contact [rad/s].

    Returns:
        Velocity, angular velocity, normal impulses, whether no corner pulls or jams.
    """
    zero = real(0.0)
    n = Shares()
    v_after = v
    w_after = w
    sound = bool(True)
    if stance == FLAT:
        v_face, w_face, n_face, sound_face = solve_sliding_face(body, mu, dirs, pressed, v, w)
        v_after = v_face
        w_after = w_face
        n = n_face
        sound = sound_face
    else:
        i = stance % 4
        u = corner_velocity(body, v, w, i)
        one = push_of(body, i, mu, dirs[i])
        if stance < EDGE:
            own = velocity_by_push(body, one, i)
            sound = own > zero
            n[i] = -u[2] / own
            v_after = v_after + n[i] * one.force
            w_after = w_after + n[i] * one.spin
        else:
            j = (i + 1) % 4
            u_other = corner_velocity(body, v, w, j)
            other = push_of(body, j, mu, dirs[j])
            edge = slide_edge(body, stance, one, other, Two(u[2], u_other[2]), v, w)
            n[i] = edge.n[0]
            n[j] = edge.n[1]
            sound = edge.sound
            v_after = edge.v
            w_after = edge.w
        for k in range(4):
            sound = sound and n[k] >= zero
    return v_after, w_after, n, sound


@wp.struct
class Swing:
    """Motion of a block on an edge whose one end sticks while the other slides across it.

    Velocity and angular velocity; normal impulse [m/s] and direction of the sliding end; sound,
    whether friction does not jam that end.
    """

    v: Vector
    w: Vector
    n: real
    d: Two
    sound: bool


@wp.func
def solve_swing(body: Body, k: int, other: int, side: real, v: Vector, w: Vector) -> Swing:
    """The motion of a block whose corner k sticks while a neighbour slides.

    Args:
        body: The block.
        k: The corner that sticks.
        other: The corner that slides, at the other end of an edge of the bottom face.
        side: 1 if it moves as the block turns from +x to +y about corner k, else -1.
        v: Velocity without contact [m/s].
        w: Angular velocity without contact [rad/s].
    """
    a = -body.corners[k]
    way = body.corners[other] - body.corners[k]
    d = direction_of(Vector(-way[1], way[0], real(0.0))) * side
    force = Vector(-body.friction * d[0], -body.friction * d[1], real(1.0))
    about = body.inertia + wp.dot(a, a) * wp.identity(n=3, dtype=real) - wp.outer(a, a)
    inverse = wp.inverse(about)
    free = inverse * (body.inertia * w + wp.cross(a, v))
    gain = inverse * wp.cross(way, force)
    weight = wp.cross(gain, way)[2]
    n = -wp.cross(free, way)[2] / weight
    w_after = free + n * gain
    return Swing(wp.cross(w_after, a), w_after, n, d, weight > real(0.0))


@wp.func
def try_swing(
    body: Body, way: int, mask: int, slip: int, start: Corners, v: Vector, w: Vector, dust: real
) -> Held:
    """The motion if one end of an edge sticks and the other slides; `fits` if it obeys the law.

    `way`, 0 to 15, is the edge plus four times a number for the end and the side. An end that
    slides already (`slip`) keeps its direction in `start`, see `try_slipping`.
    """
    zero = real(0.0)
    h = Held()
    edge, turn = way % 4, way // 4
    k = (edge + turn % 2) % 4
    other = (edge + 1 - turn % 2) % 4
    side = wp.where(turn < 2, real(1.0), real(-1.0))
    swing = solve_swing(body, k, other, side, v, w)
    v_after, w_after, n, d = swing.v, swing.w, swing.n, swing.d
    h.v = v_after
    h.w = w_after
    h.stance = EDGE + edge
    h.slip = 1 << other
    u = corner_velocity(body, v_after, w_after, other)
    ahead = u[0] * d[0] + u[1] * d[1]
    forced = slip == h.slip and d[0] * start[other, 0] + d[1] * start[other, 1] > zero
    h.work = body.friction * n * ahead
    h.spare = body.friction * n
    h.turns = n < zero
    p = v_after - v - n * Vector(-body.friction * d[0], -body.friction * d[1], real(1.0))
    sticks = wp.sqrt(p[0] * p[0] + p[1] * p[1]) <= body.friction * p[2]
    h.fits = swing.sound and sticks and n >= zero and p[2] >= zero
    h.fits = h.fits and (forced or (slip == 0 and ahead >= zero))
    h.fits = h.fits and not sinks(body, v_after, w_after, mask & ~mask_of(h.stance), dust)
    return h


@wp.func
def rotate_direction(d: Vector, angle: real) -> Vector:
    """A direction along the base, turned by a small angle [rad]."""
    return wp.normalize(Vector(d[0] - angle * d[1], d[1] + angle * d[0], real(0.0)))


@wp.func
def velocities_across(body: Body, stance: int, edge: EdgeSlide, d1: Vector, d2: Vector) -> Two:
    """Velocities of both ends of an edge across their assumed directions of sliding."""
    i = stance - EDGE
    u = corner_velocity(body, edge.v, edge.w, i)
    t = corner_velocity(body, edge.v, edge.w, (i + 1) % 4)
    return Two(u[1] * d1[0] - u[0] * d1[1], t[1] * d2[0] - t[0] * d2[1])


@wp.func(inline=False)
def find_edge_directions(body: Body, stance: int, start: Corners, v: Vector, w: Vector, dust: real):
    """Directions in which the ends of an edge slide, by Newton's method; whether it converged.

    Opposite friction of both ends along the edge does not change the motion. It need not converge.
    """
    i = stance - EDGE
    j = (i + 1) % 4
    mu = body.friction
    dirs = start
    sinking = Two(corner_velocity(body, v, w, i)[2], corner_velocity(body, v, w, j)[2])
    change = real(1.0)
    error = real(1.0)
    tries = int(0)
    while change > real(10.0) * ALIKE and tries < TURNS:
        d1, d2 = dirs[i], dirs[j]
        one, other = push_of(body, i, mu, d1), push_of(body, j, mu, d2)
        edge = slide_edge(body, stance, one, other, sinking, v, w)
        g = velocities_across(body, stance, edge, d1, d2)
        turned = rotate_direction(d1, LITTLE)
        edge1 = slide_edge(body, stance, push_of(body, i, mu, turned), other, sinking, v, w)
        g1 = (velocities_across(body, stance, edge1, turned, d2) - g) / LITTLE
        turned = rotate_direction(d2, LITTLE)
        edge2 = slide_edge(body, stance, one, push_of(body, j, mu, turned), sinking, v, w)
        g2 = (velocities_across(body, stance, edge2, d1, turned) - g) / LITTLE
        det = g1[0] * g2[1] - g2[0] * g1[1]
        det = wp.where(det == real(0.0), TINY, det)
        a = (g2[0] * g[1] - g[0] * g2[1]) / det
        b = (g1[1] * g[0] - g1[0] * g[1]) / det
        dirs[i] = rotate_direction(d1, larger(smaller(a, STEEPEST), -STEEPEST))
        dirs[j] = rotate_direction(d2, larger(smaller(b, STEEPEST), -STEEPEST))
        change = size(a) + size(b)
        error = size(g[0]) + size(g[1])
        tries += 1
    return dirs, change <= GOOD or error <= dust


@wp.func
def face_correction(body: Body, n: Shares, free: Vector, z: Vector) -> Vector:
    """Newton's step for the motion (vx, vy, wz) of a flat block that slides, pressed by n.

    The motion z = free - M^-1 sum friction n_k G_k^T d_k, d_k the direction of the velocity G_k z
    of corner k, minimises a convex function. Its second derivative follows from how the directions
    turn.
    """
    one, zero = real(1.0), real(0.0)
    lighter = one / body.inertia[2, 2]
    rest = z - free
    bend = wp.identity(n=3, dtype=real)
    for k in range(4):
        x = body.corners[k, 0]
        y = body.corners[k, 1]
        ux = z[0] - z[2] * y
        uy = z[1] + z[2] * x
        d = direction_of(Vector(ux, uy, zero))
        push = body.friction * n[k]
        rest = rest + push * Vector(d[0], d[1], lighter * (x * d[1] - y * d[0]))
        t = Vector(-d[1], d[0], x * d[0] + y * d[1])
        stiff = push / larger(wp.sqrt(ux * ux + uy * uy), TINY)
        bend = bend + stiff * wp.outer(Vector(t[0], t[1], lighter * t[2]), t)
    return -(wp.inverse(bend) * rest)


@wp.func(inline=False)
def find_face_directions(body: Body, start: Corners, v: Vector, w: Vector):
    """Directions and normal impulses of the corners of a sliding flat block; if it converged."""
    zero = real(0.0)
    dirs = start
    for k in range(4):
        # A block that does not spin keeps its direction of sliding and only becomes slower.
        d = direction_of(corner_velocity(body, v, w, k))
        if d[0] * d[0] + d[1] * d[1] > zero:
            dirs[k] = Vector(d[0], d[1], zero)
    n = Shares(real(0.25), real(0.25), real(0.25), real(0.25)) * larger(-v[2], zero)
    for _again in range(3):
        v0, w0, n0, _sound = solve_sliding(body, FLAT, body.friction, dirs, n, v, w)
        n = n0
    free = Vector(v[0], v[1], w[2])
    z = Vector(v0[0], v0[1], w0[2])
    change = real(1.0)
    tries = int(0)
    while change > real(10.0) * ALIKE and tries < TURNS:
        more = face_correction(body, n, free, z)
        turned = bool(False)
        for k in range(4):
            x = body.corners[k, 0]
            y = body.corners[k, 1]
            ux = z[0] - z[2] * y
            uy = z[1] + z[2] * x
            ahead = ux * (ux + more[0] - more[2] * y) + uy * (uy + more[1] + more[2] * x)
            turned = turned or ahead < zero
        # One step does not go beyond a stop.
        z = z + more * wp.where(turned, HALF, real(1.0))
        for k in range(4):
            u = Vector(z[0] - z[2] * body.corners[k, 1], z[1] + z[2] * body.corners[k, 0], zero)
            d = direction_of(u)
            dirs[k] = Vector(d[0], d[1], zero)
        _v, _w, n1, _s = solve_sliding(body, FLAT, body.friction, dirs, n, v, w)
        change = wp.length(n1 - n) / larger(size(v[2]), TINY)
        change = change + wp.length(more) / larger(wp.length(z), TINY)
        n = n1
        tries += 1
    return dirs, n, change <= GOOD


@wp.func(inline=False)
def try_slipping(
    body: Body,
    stance: int,
    mask: int,
    forced: bool,
    start: Corners,
    v: Vector,
    w: Vector,
    dust: real,
) -> Held:
    """The motion if all corners of a stance slide; `fits` if it obeys the contact law.

    `forced` says that they slide already, in the directions `start`. Friction then keeps these
    directions even if the corners reverse, and the step is cut where they stop.
    """
    zero = real(0.0)
    h = Held()
    h.stance = stance
    h.slip = mask_of(stance)
    dirs = start
    n = Shares()
    good = bool(True)
    if stance < EDGE:
        u = corner_velocity(body, v, w, stance)
        d0 = Two(start[stance, 0], start[stance, 1])
        _n, d, found = solve_sliding_corner(corner_matrix(body, stance), u, body.friction, d0)
        dirs[stance] = Vector(d[0], d[1], zero)
        good = found
    if stance >= EDGE and stance < FLAT:
        ends, found_ends = find_edge_directions(body, stance, start, v, w, dust)
        dirs = ends
        good = found_ends
    if stance == FLAT:
        face, pressed, found_face = find_face_directions(body, start, v, w)
        dirs = face
        n = pressed
        good = found_face
    v_after, w_after, n1, sound = solve_sliding(body, stance, body.friction, dirs, n, v, w)
    for k in range(4):
        if (h.slip & (1 << k)) != 0:
            u = corner_velocity(body, v_after, w_after, k)
            good = good and wp.dot(u, dirs[k]) >= -dust
            good = good and not (forced and wp.dot(start[k], dirs[k]) <= zero)
    if forced and not good:
        dirs = start
        good = bool(True)
        for _again in range(3):
            v_after, w_after, n1, sound = solve_sliding(body, stance, body.friction, start, n, v, w)
            n = n1
    h.v = v_after
    h.w = w_after
    for k in range(4):
        u = corner_velocity(body, v_after, w_after, k)
        h.work += body.friction * n1[k] * (u[0] * dirs[k, 0] + u[1] * dirs[k, 1])
    h.fits = sound and good and not sinks(body, v_after, w_after, mask & ~h.slip, dust)
    return h
