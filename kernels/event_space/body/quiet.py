"""Steps of a body in space without an event.

Most steps have no event: the body stands still on a base that does not move it, or turns about one
or two sticking points. These are then a hinge, as in event_space/block/pack.py, with its formulas.
Of the other points only the heights count. If a point lands at the end of a step, slides, or lifts,
the step of event_space/body/step.py is taken instead.

The centre of pressure of a body that stands still lies below its centre of mass, shifted by the
height of that times the pull of the base over the weight. The body stands while the shift is within
`room`, where all points press, and friction can take the pull.
"""

import warp as wp

from warprock.kernels.algebra.vectors import Quaternion, Vector
from warprock.kernels.event.block.begin import first_root
from warprock.kernels.event_space.block.moves import GRAIN, rotate_unnormalised
from warprock.kernels.event_space.block.pack import (
    LEVEL,
    Hinge,
    frame,
    level_edge,
    mean_motion,
    mobility_of,
    scale_in_body,
    turn_about_hinge,
)
from warprock.kernels.event_space.block.step import NEARLY
from warprock.kernels.event_space.block.trial import Base
from warprock.kernels.event_space.body.contact import Shape, is_among, place_of
from warprock.kernels.event_space.body.face import INSIDE
from warprock.kernels.event_space.lane import Limits
from warprock.kernels.shape_space.block import Block
from warprock.kernels.shape_space.body import spans

HOP = real(4.0)
"""A hop that lasts one step rises by its first velocity times the step over this number."""


@wp.struct
class Support:
    """The sticking points on which a body stands or turns.

    Points that touch; their hinge, if they are one or two; for a face, the height of the centre of
    mass, and the largest distance of the centre of pressure from below it at which all points press
    [m].
    """

    touch: wp.uint64
    hinge: Hinge
    hinged: bool
    height: real
    room: real


@wp.struct
class Course:
    """Pose and velocities of a body at the start of a step.

    Centre of mass [m], attitude, velocity [m/s], angular velocity [rad/s].
    """

    x: Vector
    q: Quaternion
    v: Vector
    w: Vector


@wp.struct
class Quiet:
    """The end of a quiet step; fields as in `State` of event_space/body/step.py, and these.

    Deep, the penetration of the hinge [m]; mean, the mean velocity of the step [m/s]; lost, the
    energy lost in the frame of the base for unit mass [J/kg]; clear, whether the step has no event;
    cut, the length of the step to the landing of a point inside, or NEVER.
    """

    x: Vector
    q: Quaternion
    v: Vector
    w: Vector
    turn: Vector
    swing: Vector
    mean: Vector
    deep: real
    lost: real
    clear: bool
    cut: real


@wp.func
def hinge_of(inertia: Vector, one: Vector, other: Vector, single_point: bool) -> Hinge:
    """The hinge of a point, or of two, at their places in the body's axes [m]."""
    h = Hinge()
    a = -HALF * (one + other)
    about = wp.diag(inertia) + wp.dot(a, a) * wp.identity(n=3, dtype=real) - wp.outer(a, a)
    if not single_point:
        h.way = HALF * (other - one)
        h.over = HALF / wp.length(h.way)
    m = mobility_of(about, (TWO * h.over) * h.way)
    h.lever = a
    h.inertia = inertia
    h.mobility = Vector(m[0, 0], m[1, 1], m[2, 2])
    h.mixed = Vector(m[0, 1], m[0, 2], m[1, 2])
    return h


@wp.func
def room_of(body: Shape, q: Quaternion, touch: wp.uint64) -> real:
    """Largest distance of the centre of pressure from below the centre of mass [m].

    Within it all touching points press. Zero if they span no plane, or the centre of mass is not
    above them.
    """
    zero, one, turn, points = real(0.0), real(1.0), frame(q), body.count
    count, mx, my, xx, xy, yy = real(0.0), real(0.0), real(0.0), real(0.0), real(0.0), real(0.0)
    for k in range(points):
        if is_among(k, touch):
            r = turn * place_of(body.points[k, body.lane])
            count += one
            mx += r[0]
            my += r[1]
            xx += r[0] * r[0]
            xy += r[0] * r[1]
            yy += r[1] * r[1]
    part = one / larger(count, one)
    mx = mx * part
    my = my * part
    xx = part * xx - mx * mx
    xy = part * xy - mx * my
    yy = part * yy - my * my
    over = one / larger(xx * yy - xy * xy, TINY)
    room = NEVER + zero
    for k in range(points):
        if is_among(k, touch):
            r = turn * place_of(body.points[k, body.lane])
            # It presses where 1 + g.(c - m) > 0, c the centre of the pressure.
            x, y = r[0] - mx, r[1] - my
            gx, gy = over * (yy * x - xy * y), over * (xx * y - xy * x)
            room = smaller(room, (one - gx * mx - gy * my) / wp.sqrt(gx * gx + gy * gy))
    return wp.where(spans(count, xx, xy, yy), room, zero)


@wp.func
def support_of(block: Block, body: Shape, height: real, q: Quaternion, touch: wp.uint64) -> Support:
    """The support of a body whose points `touch` are in contact."""
    s = Support()
    s.touch = touch
    one, other, count, points = Vector(), Vector(), int(0), body.count
    for k in range(points):
        if is_among(k, touch):
            other = place_of(body.points[k, body.lane])
            if count == 0:
                one = place_of(body.points[k, body.lane])
            count += 1
    s.hinged = count == 1 or count == 2
    if s.hinged:
        inertia = Vector(
            real(1.0) / block.inverse_x, real(1.0) / block.inverse_y, real(1.0) / block.inverse_z
        )
        s.hinge = hinge_of(inertia, one, other, count == 1)
    if count > 2:
        s.height = height
        s.room = room_of(body, q, touch)
    return s


@wp.func
def stays_still(block: Block, limits: Limits, on: Support, b: Base) -> bool:
    """Whether a body at rest stays at rest in a step."""
    weight = b.d * limits.gravity + b.change[2]
    pull = wp.sqrt(b.change[0] * b.change[0] + b.change[1] * b.change[1])
    holds = pull < INSIDE * block.friction * weight and pull * on.height < on.room * weight
    return holds and wp.length_sq(b.kick) == real(0.0) and weight > real(0.0)


@wp.func
def find_landing(body: Shape, limits: Limits, n: Quiet, begins: Course, touch: wp.uint64, d: real):
    """Events of the open points in a step.

    Returns:
        Whether they stay clear of the base; the length of the step to the first landing inside, or
        NEVER.
    """
    near, clear, first = NEARLY * limits.longest_step, bool(True), NEVER + real(0.0)
    x, q, v, w = begins.x, begins.q, begins.v, begins.w
    high = n.x[2] - n.deep
    up, points = frame(n.q)[2], body.count
    for k in range(points):
        point = body.points[k, body.lane]
        gap = high + up[0] * point.x + up[1] * point.y + up[2] * point.z
        if gap <= limits.rest_gap and not is_among(k, touch):
            r0, r1 = frame(q) * place_of(point), frame(n.q) * place_of(point)
            rate0 = v[2] + w[0] * r0[1] - w[1] * r0[0]
            rate = TWO * n.mean[2] - v[2] + n.swing[0] * r1[1] - n.swing[1] * r1[0]
            clear = bool(False)
            if d > near and gap < -(near * size(rate) + GRAIN * body.reach):
                cut = first_root(larger(x[2] + r0[2], real(0.0)), rate0, gap, d)
                first = smaller(first, cut)
    return clear, first


@wp.func
def roll(block: Block, body: Shape, limits: Limits, on: Support, b: Base, begins: Course) -> Quiet:
    """The step of a body about a hinge; see `roll` in event_space/block/pack.py."""
    zero, d, h = real(0.0), b.d, on.hinge
    x, q, v, w = begins.x, begins.q, begins.v, begins.w
    n = Quiet()
    n.cut = NEVER
    inverse = Vector(block.inverse_x, block.inverse_y, block.inverse_z)
    r0 = frame(q)
    a0 = r0 * h.lever
    momentum = scale_in_body(r0, h.inertia, w)
    middle = frame(rotate_unnormalised(q, w * (HALF * d)))
    free = v - HALF * b.change - Vector(zero, zero, HALF * d * limits.gravity)
    vm, wm, spun, holds = mean_motion(block, h, free, momentum, middle)
    n.mean = vm
    n.turn = d * wm
    n.q = rotate_unnormalised(q, n.turn)
    rise = (frame(n.q) * h.way) * (h.over + h.over)
    n.q = level_edge(n.q, rise)
    r = frame(n.q)
    a1 = r * h.lever
    n.deep = a1[2] - x[2] - d * vm[2]
    n.x = Vector(x[0] + a1[0] - a0[0], x[1] + a1[1] - a0[1], a1[2])
    spin = TWO * spun - momentum
    n.swing = scale_in_body(r, inverse, spin)
    n.w = turn_about_hinge(h, r, spin + wp.cross(a1, TWO * vm - v))
    n.v = wp.cross(n.w, a1)
    n.lost = limits.gravity * (x[2] - n.x[2]) + HALF * (
        wp.dot(v, v) + wp.dot(w, momentum) - wp.dot(n.v, n.v)
        - wp.dot(n.w, scale_in_body(r, h.inertia, n.w))
    )  # fmt: skip
    # A touching point may rise at first, by a hop inside the step.
    hop = size(v[2] - wp.cross(w, a0)[2]) + size(wp.cross(w, r0 * h.way)[2])
    holds = holds and hop * d <= HOP * limits.rest_gap
    total = n.x[0] + n.x[1] + n.x[2] + n.v[0] + n.v[1] + n.v[2]
    n.clear = holds and size(rise[2]) < LEVEL and total - total == zero
    n.clear = n.clear and wp.dot(r[2], body.axis) > zero
    if n.clear:
        clear, cut = find_landing(body, limits, n, begins, on.touch, d)
        n.clear = clear
        n.cut = cut
    return n
