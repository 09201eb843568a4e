"""Contact step of a body in space that stands on points, impacts located.

The scheme is that of event_space/stack/step.py for one body on the ground, for mass 1 and in the
frame of the base. One step of length d:

    1. the pose d/2 ahead. Its contacts are the points that touched at the start, within `rest_gap`.
       The mean motion is v_m = v - dV/2 - g d/2 + sum p / 2, I_m w_m = L + sum r x p / 2, such that
       v_m and w_m obey the contact law (event_space/body/law.py);
    2. attitude turned by d w_m, x moved by d v_m, v = 2 v_m - v, L = 2 I_m w_m - L. In flight the
       attitude turns freely, see `turn_freely` in shape_space/block.py;
    3. if inside the step a point lands, or hops by more than `rest_gap`, the step is not taken: the
       next one ends there;
    4. points that pushed are put back on the base; if all of them stick, along the base, too. v and
       w are projected on these points: one that stuck does not move, one that slid neither leaves
       nor approaches. If points landed or the base steps its velocity, an inelastic impact with
       friction of all touching points follows.

A body whose mean motion from rest is round-off stands still: its pose keeps every bit. On a base at
rest it waits in one step. It stands while the points that push span a plane; its uplift time is
when they no longer do.

The ends of slips and the opening of points are not located. A point that sticks in the mean of a
step stops at its end. So the order is 2 while points stick, also through impacts, and 1 while they
slide.
"""

import warp as wp

from warprock.kernels.algebra.vectors import Quaternion, Vector
from warprock.kernels.event.block.begin import first_root
from warprock.kernels.event_space.block.contact import BOX, FLAT, FLYING
from warprock.kernels.event_space.block.moves import cut_to, rotate_attitude, rotate_freely
from warprock.kernels.event_space.block.trial import Base, next_step
from warprock.kernels.event_space.block.trial import State as BlockState
from warprock.kernels.event_space.body.contact import (
    Carried,
    Pose,
    Shape,
    bit_of,
    is_among,
    level_points,
    place_of,
    pose_of,
    spans_plane,
    touches_of,
)
from warprock.kernels.event_space.body.law import project_on_points, solve
from warprock.kernels.event_space.body.quiet import HOP, Course, Quiet, Support, roll, stays_still
from warprock.kernels.event_space.lane import BaseMotion, Knots, Limits
from warprock.kernels.lane.modes import BROKEN, OVERTURNED, RUNNING, UNSOLVED
from warprock.kernels.shape_space.block import Block
from warprock.kernels.shape_space.frame import frame

if BOUNCES:
    from warprock.kernels.event_space.body.bounce import bounce

NEARLY = by_precision(1.0e-7, 1.0e-4)
"""Tolerance of the time of an event, as a part of the longest step."""
GRAIN = by_precision(1.0e-14, 1.0e-6)
"""Round-off of a gap, as a part of the body's reach."""
STILL = by_precision(1.0e-10, 1.0e-4)
"""Velocity that counts as zero, as a part of the velocity that gravity gives in a step."""


@wp.struct
class State:
    """State of one lane.

    Centre of mass, attitude, velocity, angular velocity; turn in the last step [rad], and angular
    velocity at its end before its impact, swing; points that touch; whether the body flies,
    stands still, and stands; time [s]; knots of the motion passed; base velocity [m/s]; cap, the
    longest next step [s]; mode; lost energy for unit mass [J/kg]; deepest penetration [m]; impacts;
    whether the last trial was a step; and one about a hinge in which nothing happened.
    """

    x: Vector
    q: Quaternion
    v: Vector
    w: Vector
    turn: Vector
    swing: Vector
    touch: wp.uint64
    flies: bool
    still: bool
    stands: bool
    time: real
    knots: Knots
    base: Vector
    cap: real
    mode: int
    lost: real
    deepest: real
    impacts: int
    taken: bool
    quiet: bool


@wp.struct
class Look:
    """Points that touch and that land at the end of a trial; length to an event [s]."""

    touch: wp.uint64
    lands: wp.uint64
    deepest: real
    cut: real


@wp.func
def attitude_after(block: Block, s: State, spin: Vector, w: Vector, d: real) -> Quaternion:
    """Attitude after a time d at the angular velocity w, or of free rotation in flight."""
    if s.flies:
        return rotate_freely(block, s.q, spin, d)
    return rotate_attitude(s.q, d * w)


@wp.func
def energy(limits: Limits, pose: Pose, v: Vector, w: Vector) -> real:
    """Energy in the frame of the base for unit mass [J/kg]."""
    kinetic = HALF * (wp.dot(v, v) + wp.dot(w, pose.inertia * w))
    return kinetic + limits.gravity * pose.x[2]


@wp.func
def look_at_step(
    body: Shape, limits: Limits, s: State, reached: State, pose0: Pose, pose: Pose,
    held: wp.uint64, d: real,
) -> Look:  # fmt: skip
    """Events of the points in a step, from their gaps at both of its ends."""
    v, w = reached.v, reached.w
    zero, near, n = real(0.0), NEARLY * limits.longest_step, Look()
    n.cut = TWO * NEVER
    count = body.count
    for k in range(count):
        place = place_of(body.points[k, body.lane])
        r0, r1 = pose0.turn * place, pose.turn * place
        rate0 = s.v[2] + s.w[0] * r0[1] - s.w[1] * r0[0]
        rate = v[2] + w[0] * r1[1] - w[1] * r1[0]
        gap = pose.x[2] + r1[2]
        was, holds = is_among(k, s.touch), is_among(k, held)
        reach = near * size(rate) + GRAIN * body.reach
        if d > near and not was and gap < -reach:
            cut = first_root(larger(pose0.x[2] + r0[2], zero), rate0, gap, d)
            n.cut = smaller(n.cut, cut)
        # A hop inside the step.
        if d > near and holds and rate0 * d > HOP * limits.rest_gap:
            n.cut = smaller(n.cut, HALF * HALF * d)
        if holds or gap <= limits.rest_gap:
            n.touch = n.touch | bit_of(k)
            if not was and rate < zero:
                n.lands = n.lands | bit_of(k)
        n.deepest = larger(n.deepest, -gap)
    return n


@wp.func
def put_on_base(
    body: Shape, reached: State, pose0: Pose, held: wp.uint64, stuck: bool
) -> State:  # fmt: skip
    """The state with points that pushed put on the base; points that stuck, at their places."""
    n = reached
    t = touches_of(body, frame(n.q), held)
    if t.total > 0:
        up, turn = level_points(body, n.x[2], t)
        n.x[2] = n.x[2] + up
        n.q = rotate_attitude(n.q, turn)
        if stuck:
            now, way, total = frame(n.q), Vector(), t.total
            for k in range(total):
                place = place_of(body.points[t.which[k], body.lane])
                way += pose0.turn * place - now * place
            n.x[0] = pose0.x[0] + way[0] / real(total)
            n.x[1] = pose0.x[1] + way[1] / real(total)
    return n


@wp.func
def end_step(
    body: Shape, limits: Limits, reached: State, pose0: Pose, look: Look, b: Base,
    held: wp.uint64, stuck: wp.uint64,
) -> State:  # fmt: skip
    """The state at the end of a step: gaps closed, velocities projected, after its impact."""
    n = put_on_base(body, reached, pose0, held, held == stuck)
    pose = pose_of(body, n.x, n.q)
    v, w = project_on_points(body, pose, held, stuck, n.v, n.w)
    n.lost = n.lost - energy(limits, pose, v, w)
    landed = look.lands != wp.uint64(0)
    pushes = held
    n.touch = look.touch
    t = touches_of(body, pose.turn, look.touch)
    if landed or wp.length_sq(b.kick) > real(0.0):
        v0 = v - b.kick
        dust = limits.gravity * limits.longest_step
        if BOUNCES:
            leaps = bounce(body, pose, look.touch, dust, v0, w)
            c = leaps.carried
            n.touch = leaps.touch
        else:
            c = solve(body, pose, t, dust, v0, w)
        n.lost = n.lost + energy(limits, pose, v0, w) - energy(limits, pose, c.v, c.w)
        # The base's work on the body is at the mean of both velocities: see account.py.
        n.lost = n.lost - HALF * wp.dot(b.kick, c.v - v0)
        v = c.v
        w = c.w
        n.mode = wp.where(c.fits, n.mode, UNSOLVED)
        pushes = c.held
    n.v = v
    n.w = w
    n.impacts = n.impacts + wp.where(landed, 1, 0)
    n.flies = n.touch == wp.uint64(0)
    n.stands = spans_plane(t, pushes)
    return n


@wp.func
def retry_step(s: State, cut: real, d: real, near: real) -> State:
    """The state before the step; its next step ends at the event inside this one."""
    n = s
    n.cap = cut_to(cut, d, near)
    n.still = False
    n.taken = False
    return n


@wp.func
def next_step_of_body(limits: Limits, motion: BaseMotion, end: real, s: State) -> Base:
    """The next step, and the motion of the base in it: as `next_step` of a block."""
    p = BlockState()
    p.time = s.time
    p.knots = s.knots
    p.base = s.base
    p.cap = s.cap
    p.w = s.w
    p.stance = wp.where(s.still, FLAT, FLYING)
    return next_step(limits, motion, end, p)


@wp.func
def integrate(
    block: Block, body: Shape, limits: Limits, s: State, b: Base, pose0: Pose, pose: Pose,
    c: Carried,
) -> State:  # fmt: skip
    """The end of a step by its mean motion, or the old state if an event lies inside.

    `pose0` is the pose at the start of the step, `pose` that in its middle.
    """
    n = advance_clock(s, b)
    n.mode = wp.where(c.fits, s.mode, UNSOLVED)
    n.still = False
    d, vm, wm, held, stuck = b.d, c.v, c.w, c.held, c.stuck
    spin = pose0.inertia * s.w
    n.q = attitude_after(block, s, spin, wm, d)
    n.x = s.x + d * vm
    last = pose_of(body, n.x, n.q)
    n.v = TWO * vm - s.v
    n.w = last.inverse * (TWO * (pose.inertia * wm) - spin)
    n.turn = d * wm
    if s.flies:
        n.w = last.inverse * spin
    n.swing = n.w
    look = look_at_step(body, limits, s, n, pose0, last, held, d)
    if look.cut < NEVER:
        return retry_step(s, look.cut, d, NEARLY * limits.longest_step)
    n.lost = s.lost + energy(limits, pose0, s.v, s.w) - wp.dot(vm, b.change)
    n.deepest = larger(s.deepest, look.deepest)
    n = end_step(body, limits, n, pose0, look, b, held, stuck)
    up = wp.dot(frame(n.q)[2], body.axis)
    n.mode = wp.where(n.mode == RUNNING and up <= real(0.0), OVERTURNED, n.mode)
    sound = n.time + n.lost + wp.length(n.x) + wp.length(n.v) + wp.length(n.w) + up
    n.mode = wp.where(sound - sound == real(0.0), n.mode, BROKEN)
    return n


@wp.func
def advance_clock(s: State, b: Base) -> State:
    """The state after the time of a step in which the body does not move."""
    n = s
    n.time = b.time
    n.knots = b.knots
    n.base = s.base + b.change + b.kick
    n.cap = NEVER
    n.taken = True
    n.quiet = False
    return n


@wp.func
def hinged_step(s: State, b: Base, easy: Quiet) -> State:
    """The state after a step about a hinge without an event."""
    n = advance_clock(s, b)
    n.x = easy.x
    n.q = easy.q
    n.v = easy.v
    n.w = easy.w
    n.turn = easy.turn
    n.swing = easy.swing
    n.deepest = larger(s.deepest, easy.deep)
    n.stands = False
    n.lost = s.lost + easy.lost - wp.dot(easy.mean, b.change)
    n.quiet = True
    return n


@wp.func
def step(
    block: Block, body: Shape, limits: Limits, motion: BaseMotion, end: real, on: Support, s: State
) -> State:
    """One trial step of one lane, at most to its next knot or to `end`.

    Returns the state after it. If an event lies inside, that is the old state with a new `cap`.
    `on` is the last support of the body, which is reused while it stands on the same points.
    """
    b = next_step_of_body(limits, motion, end, s)
    if s.still and on.touch == s.touch and stays_still(block, limits, on, b):
        return advance_clock(s, b)
    if not BOX:
        kicked = wp.length_sq(b.kick) > real(0.0)
        if on.hinged and on.touch == s.touch and not kicked and b.d > TINY:
            easy = roll(block, body, limits, on, b, Course(s.x, s.q, s.v, s.w))
            if easy.cut < NEVER:
                return retry_step(s, easy.cut, b.d, NEARLY * limits.longest_step)
            if easy.clear:
                return hinged_step(s, b, easy)
    n = any_step(block, body, limits, s, b)
    return n


@wp.func
def any_step(block: Block, body: Shape, limits: Limits, s: State, b: Base) -> State:
    """One trial step with any events."""
    d, near = b.d, NEARLY * limits.longest_step
    pose0 = pose_of(body, s.x, s.q)
    spin = pose0.inertia * s.w
    pose = pose_of(body, s.x + (HALF * d) * s.v, attitude_after(block, s, spin, s.w, HALF * d))
    v = s.v - HALF * b.change - Vector(real(0.0), real(0.0), HALF * d * limits.gravity)
    w = pose.inverse * spin
    t = touches_of(body, pose.turn, s.touch)
    c = solve(body, pose, t, limits.gravity * limits.longest_step, v, w)
    n = advance_clock(s, b)
    n.mode = wp.where(c.fits, s.mode, UNSOLVED)
    slow = STILL * limits.gravity
    fastest = wp.length(s.v) + wp.length(s.w) * body.reach
    stands = s.stands and fastest <= slow * limits.longest_step
    stands = stands and wp.length(c.v) + wp.length(c.w) * body.reach <= slow * d
    if stands:
        c.v = Vector()
        c.w = Vector()
    elif d > limits.longest_step:
        return retry_step(s, limits.longest_step, d, near)
    n.still = stands and wp.length_sq(b.kick) == real(0.0)
    if n.still:
        n.v = Vector()
        n.w = Vector()
        n.swing = Vector()
        return n
    return integrate(block, body, limits, s, b, pose0, pose, c)
