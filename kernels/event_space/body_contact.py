"""Where a body in space touches its base on points, and the contact law there.

Mass 1, as in event_space/contact.py; points, feet and frames are those of shape_space/body.py. Sets
of points are bits of a number. The law is tried in this order:

    1. what can be held is held, as one motion of the body: impulse_space/body_hold.py, whose rounds
       find the points that carry, and whose friction is in proportion to their load;
    2. else point by point, until nothing changes but round-off (Gauss-Seidel on all three impulses
       of a point, as in impulse_space/block.py).

Points that a face has in excess leave their impulses undetermined; what these do is not, as long as
friction holds. Where a face slides and turns, the load is shared as the last step left it.
"""

import warp as wp

from warprock.kernels.impulse_space.block import Knobs
from warprock.kernels.impulse_space.body_hold import (
    ROUNDS,
    add_held,
    add_pressure,
    find_motion,
    find_turn,
    judge,
    share,
    solved,
)
from warprock.kernels.impulse_space.stack import (
    Attitude,
    Gains,
    Matrix,
    frame,
    gains_of,
    solve_contact,
    weighted,
)
from warprock.kernels.shape.faces import Vector
from warprock.kernels.shape_space.block import Block
from warprock.kernels.shape_space.body import APART, Frame, Point, spans

SWEEPS = 4000
"""Most sweeps of a solve..."""
WHOLE = 60
"""...in which each point goes all of its way; then half of it, so that none goes to and fro."""
SETTLED = by_precision(1.0e-14, 1.0e-6)
"""Change of the velocities in a sweep, over those without contact, that is round-off."""
LOOSE = by_precision(1.0e-6, 1.0e-3)
"""The same, above which a solve that ran out of sweeps counts as none: faces of many points that
slide settle slowly."""
INSIDE = by_precision(1.0 - 1.0e-9, 1.0 - 1.0e-4)
"""Part of its bound within which the friction of a point that sticks lies."""

CONE = 0
HOLD = 1
KEEP = 2
"""Laws of a point: it pushes with friction within its bound, it does not move, it does not leave
or approach."""

# Rows for at least as many points as a body has: POINTS of them.
Points = wp.types.matrix(shape=(POINTS, 3), dtype=real)
PointGains = wp.types.matrix(shape=(POINTS, 12), dtype=real)
PointInts = wp.types.vector(length=POINTS, dtype=int)
PointNumbers = wp.types.vector(length=POINTS, dtype=real)


@wp.struct
class Shape:
    """What a body is: friction coefficient, inverse moments of inertia, reach [m], and its points.

    These are a row of all lanes' points; `feet` are those that it stands on at rest. `axis` is the
    block's axis, seen in the body's axes.
    """

    friction: real
    inverse: Vector
    axis: Vector
    reach: real
    count: int
    feet: wp.uint64
    points: wp.array2d(dtype=Point)
    lane: int


@wp.struct
class Pose:
    """Where a body is: centre of mass [m], attitude, its matrix, inertia and its inverse."""

    x: Vector
    q: Attitude
    turn: Matrix
    inertia: Matrix
    inverse: Matrix


@wp.struct
class Touches:
    """Points that touch: their number, which they are, their levers from the centre of mass [m]."""

    total: int
    which: PointInts
    lever: Points


@wp.func
def bit_of(k: int) -> wp.uint64:
    """The bit of a point."""
    return wp.uint64(1) << wp.uint64(k)


@wp.func
def among(k: int, bits: wp.uint64) -> bool:
    """Whether a point is one of some."""
    return (bits & bit_of(k)) != wp.uint64(0)


@wp.func
def shape_of(block: Block, own: Frame) -> Shape:
    """The body of a lane, still without points."""
    s = Shape()
    s.friction = block.friction
    s.inverse = Vector(block.inverse_x, block.inverse_y, block.inverse_z)
    s.reach = own.reach
    s.axis = frame(Attitude(own.ax, own.ay, own.az, own.aw))[2]
    return s


@wp.func
def posed(s: Shape, x: Vector, q: Attitude) -> Pose:
    """The pose of a centre of mass and an attitude."""
    one = real(1.0)
    pose = Pose()
    pose.x = x
    pose.q = q
    pose.turn = frame(q)
    pose.inverse = weighted(pose.turn, s.inverse[0], s.inverse[1], s.inverse[2])
    pose.inertia = weighted(pose.turn, one / s.inverse[0], one / s.inverse[1], one / s.inverse[2])
    return pose


@wp.func
def place_of(point: Point) -> Vector:
    """Place of a point from the centre of mass in the body's axes [m]."""
    return Vector(point.x, point.y, point.z)


@wp.func
def touches_of(s: Shape, turn: Matrix, bits: wp.uint64) -> Touches:
    """Some of the points, in an attitude."""
    t = Touches()
    count = s.count
    for k in range(count):
        if among(k, bits):
            t.which[t.total] = k
            t.lever[t.total] = turn * place_of(s.points[k, s.lane])
            t.total += 1
    return t


@wp.func
def held_motion(s: Shape, pose: Pose, t: Touches, v: Vector, w: Vector):
    """Velocities of a body whose points are all stopped, whatever that takes."""
    zero = real(0.0)
    count, mx, my, mz, xx, xy = real(0.0), real(0.0), real(0.0), real(0.0), real(0.0), real(0.0)
    yy, zx, zy, a, ax, ay = real(0.0), real(0.0), real(0.0), real(0.0), real(0.0), real(0.0)
    vx, vy, vz, ox, oy, oz = real(0.0), real(0.0), real(0.0), real(0.0), real(0.0), real(0.0)
    ex, ey, ez, gz, push, bx = real(0.0), real(0.0), real(0.0), real(0.0), real(0.0), real(0.0)
    by, spin, m, i = real(0.0), pose.inertia * w, pose.turn, s.inverse
    total = t.total
    for k in range(total):
        r = t.lever[k]
        add_held(
            real(1.0), r[0], r[1], r[2], zero, count, mx, my, mz, xx, xy, yy, zx, zy, a, ax, ay
        )
    find_motion(
        s.reach, v[0], v[1], v[2], w[0], w[1], w[2], spin[0], spin[1], spin[2], m[0, 0], m[0, 1],
        m[0, 2], m[1, 0], m[1, 1], m[1, 2], m[2, 0], m[2, 1], m[2, 2], i[0], i[1], i[2], count, mx,
        my, mz, xx, xy, yy, zx, zy, a, ax, ay, vx, vy, vz, ox, oy, oz, ex, ey, ez, gz, push, bx, by,
    )  # fmt: skip
    return Vector(vx, vy, vz), Vector(ox, oy, oz)


@wp.func
def hold(s: Shape, pose: Pose, t: Touches, dust: real, v: Vector, w: Vector):
    """The motion of a body held by some of its points, see impulse_space/body_hold.py.

    Args:
        s: The body.
        pose: Where it is.
        t: The points that touch.
        dust: Velocity that is round-off [m/s].
        v, w: Velocity [m/s] and angular velocity [rad/s] without contact.

    Returns:
        Velocities, impulses of the points, and whether they obey the law of contact.
    """
    zero, one = real(0.0), real(1.0)
    knobs = Knobs()
    knobs.gravity = dust
    knobs.time_step = one
    count, mx, my, mz, xx, xy = real(0.0), real(0.0), real(0.0), real(0.0), real(0.0), real(0.0)
    yy, zx, zy, a, ax, ay = real(0.0), real(0.0), real(0.0), real(0.0), real(0.0), real(0.0)
    vx, vy, vz, ox, oy, oz = real(0.0), real(0.0), real(0.0), real(0.0), real(0.0), real(0.0)
    ex, ey, ez, gz, push, bx = real(0.0), real(0.0), real(0.0), real(0.0), real(0.0), real(0.0)
    by, good, cx, cy, turn = real(0.0), real(0.0), real(0.0), real(0.0), real(0.0)
    fx, fy, n = real(0.0), real(0.0), real(0.0)
    spin, m, i, total = pose.inertia * w, pose.turn, s.inverse, t.total
    held, p = PointNumbers(), Points()
    for k in range(total):
        held[k] = one
    turns = int(0)
    while good <= zero and turns < ROUNDS:
        mx = zero
        my = zero
        mz = zero
        for k in range(total):
            r = t.lever[k]
            add_held(
                held[k], r[0], r[1], r[2], zero, count, mx, my, mz, xx, xy, yy, zx, zy, a, ax, ay
            )
        find_motion(
            s.reach, v[0], v[1], v[2], w[0], w[1], w[2], spin[0], spin[1], spin[2], m[0, 0],
            m[0, 1], m[0, 2], m[1, 0], m[1, 1], m[1, 2], m[2, 0], m[2, 1], m[2, 2], i[0], i[1],
            i[2], count, mx, my, mz, xx, xy, yy, zx, zy, a, ax, ay, vx, vy, vz, ox, oy, oz, ex, ey,
            ez, gz, push, bx, by,
        )  # fmt: skip
        good = one
        for k in range(total):
            r = t.lever[k]
            judge(knobs, one, zero, r[0], r[1], mx, my, vz, ox, oy, push, bx, by, held[k], good)
        turns += 1
    for k in range(total):
        r = t.lever[k]
        add_pressure(held[k], r[0], r[1], mx, my, push, bx, by, cx, cy, turn)
    find_turn(ex, ey, ez, gz, mx, my, cx, cy, turn)
    for k in range(total):
        r = t.lever[k]
        share(
            knobs, s.friction, one, held[k], zero, r[0], r[1], mx, my, push, bx, by, ex, ey, ez,
            cx, cy, turn, vz, ox, oy, fx, fy, n, good,
        )  # fmt: skip
        p[k] = Vector(fx, fy, n)
    return Vector(vx, vy, vz), Vector(ox, oy, oz), p, good > zero


@wp.func
def by_law(
    law: int, mu: real, g: Gains, e: Matrix, r: Vector, p: Vector, v: Vector, w: Vector
) -> Vector:
    """Impulse of a point that obeys its law, all others as they are."""
    zero, none = real(0.0), Vector()
    if law == CONE:
        return solve_contact(mu, zero, zero, g, e, r, none, p, v, w, none, none)
    u = v + wp.cross(w, r)
    if law == KEEP:
        return Vector(zero, zero, p[2] - g[0] * u[2])
    return Vector(
        p[0] - g[4] * u[0] - g[5] * u[1] - g[6] * u[2],
        p[1] - g[5] * u[0] - g[7] * u[1] - g[8] * u[2],
        p[2] - g[6] * u[0] - g[8] * u[1] - g[9] * u[2],
    )


@wp.func
def solve_by_sweeps(
    s: Shape, pose: Pose, t: Touches, laws: PointInts, first: Points, v: Vector, w: Vector
):
    """Velocities and impulses of points that obey their laws; whether the sweeps have settled."""
    u = v
    o = w
    p, gains, good = Points(), PointGains(), bool(False)
    e, total = wp.identity(n=3, dtype=real), t.total
    for step in range(-1, SWEEPS):
        u0, o0 = u + Vector(), o + Vector()
        part = wp.where(step > WHOLE, HALF, real(1.0))
        for turn in range(total):
            k = wp.where(step % 2 == 0, turn, total - 1 - turn)
            r = t.lever[k]
            new = first[k]
            if step < 0:
                gains[k] = gains_of(real(1.0), e, pose.inverse, Matrix(), r, Vector())
            else:
                new = by_law(laws[k], s.friction, gains[k], e, r, p[k], u, o)
                new = p[k] + part * (new - p[k])
            more = new - p[k]
            p[k] = new
            u = u + more
            o = o + pose.inverse * wp.cross(r, more)
        change = wp.length_sq(u - u0) + s.reach * s.reach * wp.length_sq(o - o0)
        whole = wp.length_sq(v) + s.reach * s.reach * wp.length_sq(w)
        good = step >= 0 and change <= LOOSE * LOOSE * whole
        if step >= 0 and change <= SETTLED * SETTLED * whole:
            break
    return u, o, p, good


@wp.func
def solve(s: Shape, pose: Pose, t: Touches, dust: real, first: Points, v: Vector, w: Vector):
    """The motion that obeys the law of contact; see `hold` and the head of this file."""
    if t.total == 0:
        return v, w, Points(), True
    u, o, p, good = hold(s, pose, t, dust, v, w)
    if not good:
        u, o, p, good = solve_by_sweeps(s, pose, t, PointInts(), first, v, w)
    return u, o, p, good


@wp.func
def levelled(s: Shape, z: real, t: Touches):
    """Shift upwards [m] and turn [rad] that put points on the base, or nearest to it.

    z is the height of the centre of mass [m].
    """
    zero, part = real(0.0), real(1.0) / larger(real(t.total), real(1.0))
    mx, my, xx, xy, yy = real(0.0), real(0.0), real(0.0), real(0.0), real(0.0)
    height, hx, hy, total = real(0.0), real(0.0), real(0.0), t.total
    for k in range(total):
        r = t.lever[k]
        mx += part * r[0]
        my += part * r[1]
        height += part * (z + r[2])
    for k in range(total):
        x, y = t.lever[k][0] - mx, t.lever[k][1] - my
        gap = z + t.lever[k][2] - height
        xx += x * x
        xy += x * y
        yy += y * y
        hx += gap * x
        hy += gap * y
    flat = spans(real(total), xx, xy, yy)
    alone = total < 2 or xx + yy <= APART * s.reach * s.reach
    ax, ay = solved(flat, alone, xx, xy, yy, hx, hy)
    turn = Vector(-ay, ax, zero)
    return -height - (turn[0] * my - turn[1] * mx), turn
