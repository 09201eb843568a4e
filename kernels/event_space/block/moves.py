"""How one block in space moves in a step of the event engine, and its events.

An attitude is a quaternion (x, y, z, w). Corners, stances and velocities are those of
event_space/block/contact.py. The gap of a corner is its height above the base.
"""

import warp as wp

from warprock.kernels.algebra.vectors import Quaternion, Vector
from warprock.kernels.event.block.step import first_root
from warprock.kernels.event_space.block.contact import BOX, EDGE, FLAT, Body, Two, direction_of
from warprock.kernels.shape_space.block import Block, turn_freely
from warprock.kernels.shape_space.frame import frame
from warprock.kernels.shape_space.lanes import Triple, matrix_of

SIDES = 6 if BOX else 5
"""Ways in which a block at rest may start to move, see `lack_of`."""

GRAIN = by_precision(1.0e-14, 1.0e-6)
"""Round-off of a gap, as a part of the half height."""
LEVEL = by_precision(1.0e-17, 1.0e-9)
"""Slope of an edge that counts as level."""


@wp.func
def rotate_unnormalised(q: Quaternion, turn: Vector) -> Quaternion:
    """As `rotate_attitude`, but the quaternion is not normalised."""
    half = HALF * wp.length(turn)
    ratio = HALF * wp.where(half > TINY, sine(half) / larger(half, TINY), real(1.0))
    a = turn * ratio
    c = cosine(half)
    return Quaternion(
        c * q[0] + a[0] * q[3] + a[1] * q[2] - a[2] * q[1],
        c * q[1] + a[1] * q[3] + a[2] * q[0] - a[0] * q[2],
        c * q[2] + a[2] * q[3] + a[0] * q[1] - a[1] * q[0],
        c * q[3] - a[0] * q[0] - a[1] * q[1] - a[2] * q[2],
    )


@wp.func
def rotate_attitude(q: Quaternion, turn: Vector) -> Quaternion:
    """An attitude after a turn, a rotation vector in the axes of the base [rad]."""
    return wp.normalize(rotate_unnormalised(q, turn))


@wp.func
def body_at(block: Block, q: Quaternion) -> Body:
    """The block in an attitude."""
    one = real(1.0)
    body = Body()
    turn = frame(q)
    back = wp.transpose(turn)
    inverse = Vector(block.inverse_x, block.inverse_y, block.inverse_z)
    body.inverse = turn * wp.diag(inverse) * back
    body.inertia = (
        turn * wp.diag(Vector(one / inverse[0], one / inverse[1], one / inverse[2])) * back
    )
    for k in range(4):
        x = wp.where(k == 1 or k == 2, block.half_width, -block.half_width) - block.centre_x
        y = wp.where(k >= 2, block.half_depth, -block.half_depth) - block.centre_y
        body.corners[k] = turn * Vector(x, y, -block.half_height)
    body.friction = block.friction
    return body


@wp.func
def rotate_freely(block: Block, q: Quaternion, momentum: Vector, d: real) -> Quaternion:
    """Attitude after free rotation."""
    spin = Triple(momentum[0], momentum[1], momentum[2])
    inverse = Triple(block.inverse_x, block.inverse_y, block.inverse_z)
    qx, qy, qz, qw = turn_freely(q[0], q[1], q[2], q[3], spin, inverse, d)
    return Quaternion(qx, qy, qz, qw)


@wp.func
def block_axis(q: Quaternion) -> Vector:
    """The block's axis."""
    r = matrix_of(q[0], q[1], q[2], q[3])
    return Vector(r.r13, r.r23, r.r33)


@wp.func
def level_attitude(q: Quaternion, stance: int) -> Quaternion:
    """The attitude with the edge or face of a stance level: removes round-off and drift."""
    zero, one = real(0.0), real(1.0)
    new = q
    if stance == FLAT:
        for _again in range(2):
            up = block_axis(new)
            new = rotate_attitude(new, Vector(up[1], -up[0], zero))
    elif stance >= EDGE and stance < FLAT:
        for _again in range(2):
            r = matrix_of(new[0], new[1], new[2], new[3])
            # Edges 0 and 2 lie along the width, 1 and 3 along the depth.
            wide = (stance - EDGE) % 2 == 0
            way = Vector(wp.where(wide, r.r11, r.r12), wp.where(wide, r.r21, r.r22), zero)
            rise = wp.where(wide, r.r31, r.r32)
            if size(rise) > LEVEL:
                new = rotate_attitude(
                    new, Vector(-way[1], way[0], zero) * (rise / (one - rise * rise))
                )
    return new


@wp.func
def foot(body: Body, mask: int) -> Vector:
    """Mean of the corners of a mask, from the centre of mass [m]; zero if the mask is empty."""
    total = Vector()
    count = real(0.0)
    for k in range(4):
        if (mask & (1 << k)) != 0:
            total = total + body.corners[k]
            count += real(1.0)
    return total / larger(count, real(1.0))


@wp.func
def place_on_base(body: Body, mask: int, x: Vector) -> Vector:
    """The centre of mass moved to the height at which the corners of a mask touch; without, x."""
    down = foot(body, mask)
    return Vector(x[0], x[1], wp.where(mask == 0, x[2], -down[2]))


@wp.func
def lack_of(body: Body, side: int, pull: Two, gravity: real, a: Vector) -> real:
    """Margin of the acceleration of the base before a block at rest moves [m/s^2].

    Args:
        body: The block.
        side: 0 to 3: tips over the edge from that corner to the next. 4 (of the box of friction 5,
            too): slides.
        pull: Direction of sliding.
        gravity: [m/s^2].
        a: Acceleration of the base [m/s^2].
    """
    weight = gravity + a[2]
    found = body.friction * weight - pull[0] * a[0] - pull[1] * a[1]
    if side < 4:
        first = body.corners[side]
        way = body.corners[(side + 1) % 4] - first
        out = direction_of(Vector(way[1], -way[0], real(0.0)))
        arm = out[0] * first[0] + out[1] * first[1]
        found = -weight * arm / first[2] + out[0] * a[0] + out[1] * a[1]
    return found


@wp.func
def least_lack(body: Body, gravity: real, a0: Vector, a1: Vector):
    """`lack_of` at both ends of a step, of the way that moves a block at rest first."""
    larger0 = a0[0] * a0[0] + a0[1] * a0[1] > a1[0] * a1[0] + a1[1] * a1[1]
    pull = direction_of(a1)
    if larger0:
        pull = direction_of(a0)
    if BOX:
        way = Two(wp.sign(pull[0]), wp.sign(pull[1]))
    least = real(1.0e30)
    first = real(0.0)
    last = real(0.0)
    for side in range(SIDES):
        if BOX:
            # Along x, then along y.
            pull = Two(
                wp.where(side == 4, way[0], real(0.0)), wp.where(side == 5, way[1], real(0.0))
            )
        s0 = lack_of(body, side, pull, gravity, a0)
        s1 = lack_of(body, side, pull, gravity, a1)
        if smaller(s0, s1) < least:
            least = smaller(s0, s1)
            first = s0
            last = s1
    return first, last


@wp.func
def corner_event(
    g0: real, r0: real, g1: real, r1: real, d: real, near: real, grain: real, rest: real
):
    """Events of an open corner in a step, from its gap and the rate of that at both ends.

    Returns:
        Length of the step to its landing if that lies inside, else NEVER; whether it lands at the
        end of the step; whether it closes at once, because it would not rise by more than `rest`.
    """
    zero = real(0.0)
    reach = near * size(r1) + grain
    cut = NEVER
    lands = bool(False)
    closes = bool(False)
    start = larger(g0, zero)
    bend = (g1 - start - r0 * d) / larger(d * d, TINY)
    if g1 < smaller(g0, zero) - reach and d > near:
        cut = first_root(start, r0, g1, d)
        closes = g0 <= grain and r0 <= zero
    elif g1 <= reach and r1 < zero:
        lands = True
    # It may come back in this step or in a later one: the rule must not depend on the step.
    hops = r0 > zero and r0 * r0 <= real(-4.0) * bend * rest
    return cut, lands, closes or (g0 <= grain and hops and d > near)


@wp.func
def cut_to(event: real, d: real, near: real) -> real:
    """Length of the next step, which ends at an event inside this one [s].

    It is at least half of `near`, within which an event counts as reached. For an event at the very
    end of the step it is half of the step; otherwise the same trial would repeat for ever.
    """
    return larger(wp.where(event > d - near, HALF * d, event), HALF * near)


@wp.struct
class Course:
    """How a corner moves along the base in a step.

    Its velocities at both ends [m/s]; d, the length of the step [s]; near, the tolerance of the
    time of an event [s].
    """

    first: Vector
    last: Vector
    d: real
    near: real


@wp.func
def stop_event(course: Course):
    """Whether a sliding corner stops in a step.

    Returns:
        Length of the step to where its velocity is across the first one, if that lies inside, else
        NEVER; whether it stands still at the end. On a curved path it may not, and slides on.
    """
    u0, u1, d, near = course.first, course.last, course.d, course.near
    d0 = direction_of(u0)
    e0 = d0[0] * u0[0] + d0[1] * u0[1]
    e1 = d0[0] * u1[0] + d0[1] * u1[1]
    wide = u1 - u0
    reach = near * wp.sqrt(wide[0] * wide[0] + wide[1] * wide[1]) / larger(d, TINY)
    cut = NEVER
    if e0 > real(0.0) and e1 < -reach and d > near:
        cut = first_root(e0, (e1 - e0) / d, e1, d)
    speed = wp.sqrt(u1[0] * u1[0] + u1[1] * u1[1])
    return cut, e1 <= reach and speed <= real(10.0) * reach
