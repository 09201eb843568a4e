"""Contact of one block in space with its base, for one precision: exact for the usual states.

Mass 1, inertia I about the centre of mass, velocity v, angular velocity w; corner k lies at r_k
from the centre of mass and moves at v + w x r_k. The base is the plane z = 0. An impulse p at a
corner, p_z = n >= 0 and |p_x, p_y| <= friction n (the cone), changes v by p and w by I^-1 (r x p).

Where the block touches is its *stance*: on corner k (0 to 3), on the edge from corner k to the
next (4 + k), flat (8), or nowhere (9). What may hold is tried, larger stances first:

    1. all that touch stick: on a corner L + a x v about it is kept (L = I w, a = -r), on an edge
       its component along the edge, flat nothing moves. The impulses follow. Those of an edge
       share what pushes along it as the cones allow; those of a face are spread bilinearly over
       the rectangle, which leaves all n >= 0 as long as the centre of pressure lies in it;
    2. all that touch slide, p = n (-friction d, 1), d the directions in which the corners end up:
       on a corner Newton's method for the angle of d, on an edge and flat an iteration;
    3. else corner by corner, each solved exactly, until nothing changes (block Gauss-Seidel).

A corner that touches and is not held must not sink. Where several states obey the law, the first
is taken: sticking before sliding before leaving.
"""

from typing import Any

import warp as wp

from warprock.kernels.instance import kernel_module

real: Any
PRECISION: str

stack = kernel_module("stack", precision=PRECISION, blocks=1)
wp.set_module_options(stack.STACK_OPTIONS)
scalar = kernel_module("scalar", precision=PRECISION)
larger, smaller, size = scalar.larger, scalar.smaller, scalar.size

EDGE = 4
FLAT = 8
FLYING = 9
ALL = 15

HALF = real(0.5)
TINY = real(1.0e-30)
"""Keeps a quotient by zero finite."""
ALIKE = real({"float64": 1.0e-14, "float32": 1.0e-6}[PRECISION])
"""Change of a direction [rad] that is round-off."""
STEEPEST = real(0.5)
"""Largest turn of a direction in one of Newton's steps [rad]."""
TURNS = 60
"""Steps of Newton's method, or of the iteration for the directions of sliding."""
SWEEPS = 20000
"""Sweeps of the Gauss-Seidel iteration before it gives up."""
SETTLED = real({"float64": 1.0e-13, "float32": 1.0e-6}[PRECISION])
"""Change of the velocities in a sweep, as a part of the largest, at which it ends."""

Two = wp.types.vector(length=2, dtype=real)
Three = stack.Three
Matrix = stack.Matrix
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
    """What contacts make of a motion.

    Velocity [m/s] and angular velocity [rad/s]; stance; slip, the corners that slide, as a sum of
    2^k; work, what friction took in this motion [m^2/s^2], times the step's length if the motion is
    a mean; fits, whether the contact law is obeyed.
    """

    v: Three
    w: Three
    stance: int
    slip: int
    work: real
    fits: bool


@wp.func
def mask_of(stance: int) -> int:
    """Corners of a stance, as a sum of 2^k."""
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
    """Stance in which some corners touch; two opposite ones, or three, make the block lie flat."""
    stance = int(8)
    for number in range(8):
        if mask_of(number) == mask:
            stance = number
    return wp.where(mask == 0, FLYING, stance)


@wp.func
def corner_velocity(body: Body, v: Three, w: Three, k: int) -> Three:
    """Velocity of a corner [m/s]."""
    return v + wp.cross(w, body.corners[k])


@wp.func
def along(u: Three) -> Two:
    """Direction of a velocity along the base, zero where it has none."""
    length = wp.sqrt(u[0] * u[0] + u[1] * u[1])
    over = wp.where(length > TINY, real(1.0) / larger(length, TINY), real(0.0))
    return Two(u[0] * over, u[1] * over)


@wp.func
def stuck(body: Body, stance: int, v: Three, w: Three):
    """Velocities of a block whose stance sticks: the motion projected on those that it allows."""
    v1 = Three()
    w1 = Three()
    if stance < FLAT:
        k = stance % 4
        a = -body.corners[k]
        spin = body.inertia * w + wp.cross(a, v)
        if stance < EDGE:
            about = body.inertia + wp.dot(a, a) * wp.identity(n=3, dtype=real) - wp.outer(a, a)
            w1 = wp.inverse(about) * spin
        else:
            e = wp.normalize(body.corners[(k + 1) % 4] - body.corners[k])
            arm = wp.cross(e, a)
            w1 = e * (wp.dot(e, spin) / (wp.dot(e, body.inertia * e) + wp.dot(arm, arm)))
        v1 = wp.cross(w1, a)
    return v1, w1


@wp.func
def edge_carries(body: Body, k: int, p: Three, twist: Three) -> bool:
    """Whether an edge can take an impulse p and an angular impulse about the centre of mass."""
    zero = real(0.0)
    first = body.corners[k]
    way = body.corners[(k + 1) % 4] - first
    e = wp.normalize(way)
    middle = first + HALF * way
    # The halves differ by 2 q, across the edge; what they share along it the cones tell.
    q = wp.cross((twist - wp.cross(middle, p)) / wp.length(way), e)
    one = HALF * p - q
    other = HALF * p + q
    side = Two(-e[1], e[0])
    across1 = one[0] * side[0] + one[1] * side[1]
    across2 = other[0] * side[0] + other[1] * side[1]
    most1 = body.friction * one[2]
    most2 = body.friction * other[2]
    left1 = most1 * most1 - across1 * across1
    left2 = most2 * most2 - across2 * across2
    spare = wp.sqrt(larger(left1, zero)) + wp.sqrt(larger(left2, zero))
    pressed = one[2] >= zero and other[2] >= zero
    return pressed and left1 >= zero and left2 >= zero and size(wp.dot(p, e)) <= spare


@wp.func
def face_shares(body: Body, x: real, y: real) -> Shares:
    """Bilinear shares of the corners in a pressure whose centre is at (x, y) [m]."""
    one = real(1.0)
    c0 = body.corners[0]
    ex = body.corners[1] - c0
    ey = body.corners[3] - c0
    s = ((x - c0[0]) * ex[0] + (y - c0[1]) * ex[1]) / wp.dot(ex, ex)
    t = ((x - c0[0]) * ey[0] + (y - c0[1]) * ey[1]) / wp.dot(ey, ey)
    return Shares((one - s) * (one - t), s * (one - t), s * t, (one - s) * t)


@wp.func
def inside(body: Body, x: real, y: real) -> bool:
    """Whether a point of the base lies under the bottom face."""
    zero, one = real(0.0), real(1.0)
    c0 = body.corners[0]
    ex = body.corners[1] - c0
    ey = body.corners[3] - c0
    s = ((x - c0[0]) * ex[0] + (y - c0[1]) * ex[1]) / wp.dot(ex, ex)
    t = ((x - c0[0]) * ey[0] + (y - c0[1]) * ey[1]) / wp.dot(ey, ey)
    return s >= zero and s <= one and t >= zero and t <= one


@wp.func
def face_carries(body: Body, p: Three, twist: Three, dust: real) -> bool:
    """Whether a flat block can take an impulse and an angular impulse about its centre of mass."""
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
            worst = larger(worst, wp.where(shares[k] > real(0.0), fx * fx + fy * fy, real(0.0)))
        fits = inside(body, x, y) and wp.sqrt(worst) <= body.friction * p[2] + dust
    return fits


@wp.func
def sinks(body: Body, v: Three, w: Three, mask: int, dust: real) -> bool:
    """Whether one of some corners moves into the base."""
    found = bool(False)
    for k in range(4):
        u = corner_velocity(body, v, w, k)
        found = found or ((mask & (1 << k)) != 0 and u[2] < -dust)
    return found


@wp.func
def sticking(body: Body, stance: int, mask: int, v: Three, w: Three, dust: real) -> Held:
    """The motion if a stance sticks, some corners touching; whether its cones can carry that."""
    h = Held()
    v1, w1 = stuck(body, stance, v, w)
    h.v = v1
    h.w = w1
    h.stance = stance
    p = h.v - v
    if stance < EDGE:
        h.fits = p[2] >= real(0.0) and (wp.sqrt(p[0] * p[0] + p[1] * p[1]) <= body.friction * p[2])
    else:
        twist = body.inertia * (h.w - w)
        if stance < FLAT:
            h.fits = edge_carries(body, stance - EDGE, p, twist)
        else:
            h.fits = face_carries(body, p, twist, dust)
    h.fits = h.fits and not sinks(body, h.v, h.w, mask & ~mask_of(stance), dust)
    return h


@wp.func
def answer(body: Body, k: int, p: Three, at: int) -> Three:
    """Velocity that an impulse at corner k gives to corner `at`."""
    return p + wp.cross(body.inverse * wp.cross(body.corners[k], p), body.corners[at])


@wp.func
def corner_matrix(body: Body, k: int) -> Matrix:
    """Velocities of corner k by unit impulses there, column by column."""
    zero, one = real(0.0), real(1.0)
    x = answer(body, k, Three(one, zero, zero), k)
    y = answer(body, k, Three(zero, one, zero), k)
    z = answer(body, k, Three(zero, zero, one), k)
    return Matrix(x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2])


@wp.func
def sliding_corner(m: Matrix, u: Three, mu: real, start: Two):
    """Impulse of a corner that slides, and the direction in which it ends up doing so.

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
        f = m * Three(-mu * d[0], -mu * d[1], real(1.0))
        rate = m * Three(-mu * e[0], -mu * e[1], real(0.0))
        weight = f[2]
        n = -u[2] / weight
        change = -n * rate[2] / weight
        tx = u[0] + n * f[0]
        ty = u[1] + n * f[1]
        ahead = tx * d[0] + ty * d[1]
        beside = tx * e[0] + ty * e[1]
        bend = -ahead + e[0] * (change * f[0] + n * rate[0]) + e[1] * (change * f[1] + n * rate[1])
        # Never away from the direction of the velocity.
        bend = wp.where(bend < -TINY, bend, -TINY)
        turn = wp.where(beside == real(0.0), real(0.0), -beside / bend)
        turn = larger(smaller(turn, STEEPEST), -STEEPEST)
        d = wp.normalize(d + turn * e)
        tries += 1
    sound = n >= real(0.0) and weight > real(0.0) and ahead >= real(0.0)
    return n, d, sound and size(turn) <= real(1.0e3) * ALIKE


@wp.func
def slid(body: Body, stance: int, mu: real, dirs: Corners, pressed: Shares, v: Three, w: Three):
    """Velocities of a block that slides in given directions, and the normal impulses.

    Args:
        body: The block.
        stance: Its stance.
        mu: Friction coefficient.
        dirs: Directions in which its corners slide.
        pressed: Normal impulses that a flat block's friction is taken from.
        v: Velocity without contact [m/s].
        w: Angular velocity without contact [rad/s].

    Returns:
        Velocity, angular velocity, normal impulses, whether they can be carried at all.
    """
    zero, one = real(0.0), real(1.0)
    n = Shares()
    v1 = v
    w1 = w
    sound = bool(True)
    if stance == FLAT:
        p = Three(zero, zero, -v[2])
        torsion = real(0.0)
        for k in range(4):
            fx = -mu * pressed[k] * dirs[k, 0]
            fy = -mu * pressed[k] * dirs[k, 1]
            p = p + Three(fx, fy, zero)
            torsion += body.corners[k, 0] * fy - body.corners[k, 1] * fx
        spin = body.inertia * w
        low = -body.corners[0, 2]
        x = (spin[1] - low * p[0]) / larger(p[2], TINY)
        y = (-spin[0] - low * p[1]) / larger(p[2], TINY)
        n = p[2] * face_shares(body, x, y)
        sound = p[2] >= zero and inside(body, x, y)
        v1 = Three(v[0] + p[0], v[1] + p[1], zero)
        w1 = Three(zero, zero, w[2] + torsion / body.inertia[2, 2])
    else:
        i = stance % 4
        u = corner_velocity(body, v, w, i)
        f1 = Three(-mu * dirs[i, 0], -mu * dirs[i, 1], one)
        a11 = answer(body, i, f1, i)[2]
        if stance < EDGE:
            sound = a11 > zero
            n[i] = -u[2] / a11
        else:
            j = (i + 1) % 4
            u2 = corner_velocity(body, v, w, j)
            f2 = Three(-mu * dirs[j, 0], -mu * dirs[j, 1], one)
            a12 = answer(body, j, f2, i)[2]
            a21 = answer(body, i, f1, j)[2]
            a22 = answer(body, j, f2, j)[2]
            det = a11 * a22 - a12 * a21
            sound = det > zero and a11 > zero
            n[i] = (a12 * u2[2] - a22 * u[2]) / det
            n[j] = (a21 * u[2] - a11 * u2[2]) / det
            v1 = v1 + n[j] * f2
            w1 = w1 + n[j] * (body.inverse * wp.cross(body.corners[j], f2))
        v1 = v1 + n[i] * f1
        w1 = w1 + n[i] * (body.inverse * wp.cross(body.corners[i], f1))
        for k in range(4):
            sound = sound and n[k] >= zero
    return v1, w1, n, sound


@wp.func
def slipping(
    body: Body, stance: int, mask: int, forced: bool, start: Corners, v: Three, w: Three, dust: real
) -> Held:
    """The motion if all corners of a stance slide; whether it obeys the contact law.

    `forced`: they slide already, in the directions `start`. Should they come to a stop, they go on
    as if friction kept its direction: the step is then cut where they stop.
    """
    zero, one = real(0.0), real(1.0)
    h = Held()
    h.stance = stance
    h.slip = mask_of(stance)
    v1 = v
    w1 = w
    dirs = start
    n = Shares(one, one, one, one) * (real(0.25) * larger(-v[2], zero))
    sound = bool(False)
    turned = bool(False)
    change = real(1.0)
    tries = int(0)
    if stance < EDGE:
        u = corner_velocity(body, v, w, stance)
        d0 = Two(start[stance, 0], start[stance, 1])
        _n, d, sound = sliding_corner(corner_matrix(body, stance), u, body.friction, d0)
        turned = not sound or d[0] * d0[0] + d[1] * d0[1] <= zero
        dirs[stance] = Three(d[0], d[1], zero)
        v1, w1, n, sound = slid(body, stance, body.friction, dirs, n, v, w)
        change = wp.where(turned and not forced, one, zero)
    while change > real(1.0e1) * ALIKE and tries < TURNS and stance >= EDGE:
        v1, w1, n, sound = slid(body, stance, body.friction, dirs, n, v, w)
        change = real(0.0)
        turned = bool(False)
        for k in range(4):
            if (h.slip & (1 << k)) != 0:
                d = along(corner_velocity(body, v1, w1, k))
                dx = d[0] - dirs[k, 0]
                dy = d[1] - dirs[k, 1]
                change = larger(change, size(dx) + size(dy))
                turned = turned or d[0] * start[k, 0] + d[1] * start[k, 1] <= zero
                dirs[k] = Three(d[0], d[1], zero)
        tries += 1
    settled = change <= real(1.0e3) * ALIKE
    if forced and (turned or not settled):
        dirs = start
        for _again in range(3):
            v1, w1, n, sound = slid(body, stance, body.friction, start, n, v, w)
        settled = True
    h.v = v1
    h.w = w1
    for k in range(4):
        u = corner_velocity(body, v1, w1, k)
        h.work += body.friction * n[k] * (u[0] * dirs[k, 0] + u[1] * dirs[k, 1])
    h.fits = sound and settled and not sinks(body, v1, w1, mask & ~h.slip, dust)
    return h


@wp.func
def corner_law(m: Matrix, u: Three, mu: real, d0: Two) -> Three:
    """Impulse of one corner that obeys the contact law, given its velocity without it."""
    p = Three()
    if u[2] < real(0.0):
        p = -(wp.inverse(m) * u)
        push = wp.sqrt(p[0] * p[0] + p[1] * p[1])
        if p[2] < real(0.0) or push > mu * p[2]:
            start = wp.where(d0[0] * d0[0] + d0[1] * d0[1] > real(0.0), d0, -along(p))
            n, d, sound = sliding_corner(m, u, mu, start)
            if not sound:
                n, d, sound = sliding_corner(m, u, mu, -along(p))
            # What can neither stick nor slide jams.
            p = wp.where(sound, n * Three(-mu * d[0], -mu * d[1], real(1.0)), p)
    return p


@wp.func
def swept(body: Body, mask: int, v: Three, w: Three, dust: real) -> Held:
    """The motion that obeys the contact law at some corners, found by Gauss-Seidel sweeps."""
    zero = real(0.0)
    h = Held()
    h.v = v
    h.w = w
    impulses = Corners()
    dirs = Corners()
    speed = wp.length(v) + wp.length(w) * wp.length(body.corners[0])
    change = speed
    tries = int(0)
    while change > SETTLED * speed and tries < SWEEPS:
        change = real(0.0)
        for k in range(4):
            if (mask & (1 << k)) != 0:
                m = corner_matrix(body, k)
                u = corner_velocity(body, h.v, h.w, k) - m * impulses[k]
                p = corner_law(m, u, body.friction, Two(dirs[k, 0], dirs[k, 1]))
                more = p - impulses[k]
                impulses[k] = p
                h.v = h.v + more
                h.w = h.w + body.inverse * wp.cross(body.corners[k], more)
                change = larger(change, wp.length(m * more))
                d = along(corner_velocity(body, h.v, h.w, k))
                dirs[k] = Three(d[0], d[1], zero)
        tries += 1
    held = int(0)
    for k in range(4):
        u = corner_velocity(body, h.v, h.w, k)
        push = wp.sqrt(impulses[k, 0] * impulses[k, 0] + impulses[k, 1] * impulses[k, 1])
        if (mask & (1 << k)) != 0 and u[2] <= dust and impulses[k, 2] > zero:
            held = held | (1 << k)
            if push >= body.friction * impulses[k, 2] * (real(1.0) - real(1.0e4) * SETTLED):
                h.slip = h.slip | (1 << k)
        h.work -= u[0] * impulses[k, 0] + u[1] * impulses[k, 1]
    h.stance = stance_of(held)
    h.fits = tries < SWEEPS
    return h


@wp.func
def settled(
    body: Body, stance: int, slip: int, start: Corners, v: Three, w: Three, dust: real
) -> Held:
    """The motion that obeys the contact law.

    Args:
        body: The block.
        stance: Where it touches.
        slip: Corners that slide already, 0 where friction finds its own directions.
        start: Directions in which they slide.
        v: Velocity without contact [m/s].
        w: Angular velocity without contact [rad/s].
        dust: Velocity that is round-off [m/s].
    """
    mask = mask_of(stance)
    best = Held()
    for number in range(18):
        c = 8 - number % 9
        part = mask_of(c)
        if not best.fits and (part & mask) == part:
            if number < 9:
                if slip == 0:
                    best = sticking(body, c, mask, v, w, dust)
            else:
                forced = slip != 0 and (slip & part) == part
                dirs = start
                if not forced:
                    v1, _w1 = stuck(body, c, v, w)
                    d = along(v - v1)
                    for k in range(4):
                        dirs[k] = Three(d[0], d[1], real(0.0))
                best = slipping(body, c, mask, forced, dirs, v, w, dust)
    if not best.fits:
        best = Held()
        best.v = v
        best.w = w
        best.stance = FLYING
        best.fits = not sinks(body, v, w, mask, real(0.0))
    if not best.fits:
        best = swept(body, mask, v, w, dust)
    return best
