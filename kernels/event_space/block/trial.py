"""Start of a step of the event engine in space.

State of a lane, motion of its base in the step, and the time at which an edge lets go of one of its
ends. The scheme is in event_space/block/step.py.
"""

import warp as wp

from warprock.kernels.algebra.vectors import Quaternion, Vector
from warprock.kernels.event.block.begin import MORE, base_change
from warprock.kernels.event_space.block.contact import FLAT, Body, Corners, Held
from warprock.kernels.event_space.block.moves import body_at, rotate_attitude
from warprock.kernels.event_space.lane import BaseMotion, Knots, Limits
from warprock.kernels.motion.kinds import expand, knot_step, knot_time
from warprock.kernels.shape_space.block import Block

if FRICTION == "box":
    from warprock.kernels.event_space.block.box_friction import (
        directions,
        project,
        solve_as_before,
    )
else:
    from warprock.kernels.event_space.block.law import directions, project, solve_as_before

SHARP = by_precision(1.0e-5, 1.0e-3)
"""Tolerance of the time at which an edge lets go of an end, as a part of the longest step; the
error is of its first order."""
PROBE = by_precision(1.0e-4, 1.0e-2)
"""Length of the very short step of `probe`, as a part of the longest step."""
REACH = real(0.125)
"""Largest rotation in one step [rad]: keeps the polynomials in their range."""


@wp.struct
class State:
    """State of one lane.

    Attributes:
        x, q, v, w: Position [m], attitude, velocity [m/s], angular velocity [rad/s].
        turn: Rotation vector of the last step [rad].
        swing: Angular velocity at its end, before the impact [rad/s].
        stance, slip: See event_space/block/contact.py.
        time: [s].
        knots: Knots of the motion passed, along x, y and z.
        base: Velocity of the base [m/s].
        cap: Longest next step [s].
        mode: How the lane stands, see modes.py.
        lost: Energy lost for unit mass [J/kg].
        deepest: Deepest penetration of a corner before it was put back on the base [m].
        impacts: Their number.
        taken: Whether the last trial step was taken.
    """

    x: Vector
    q: Quaternion
    v: Vector
    w: Vector
    turn: Vector
    swing: Vector
    stance: int
    slip: int
    time: real
    knots: Knots
    base: Vector
    cap: real
    mode: int
    lost: real
    deepest: real
    impacts: int
    taken: bool


@wp.struct
class Base:
    """A step, and the motion of the base in it.

    Change of the velocity of the base, and velocity step at the end [m/s]; acceleration at both
    ends [m/s^2]; knots passed after it; length d and end of the step [s].
    """

    change: Vector
    kick: Vector
    first: Vector
    last: Vector
    knots: Knots
    d: real
    time: real


@wp.struct
class Moment:
    """A block at one end of a step: its state, and the block in its attitude.

    Funcs take it by reference: copies of it cost the plain form up to 8 % of its speed.
    """

    state: State
    body: Body


@wp.func
def state_at(moment: wp.ref[Moment]) -> State:
    """A copy of the state that may be changed."""
    return moment.state


@wp.func
def kinetic_energy(body: Body, v: Vector, w: Vector) -> real:
    """Kinetic energy for unit mass in the frame of the base [J/kg]."""
    return HALF * (wp.dot(v, v) + wp.dot(w, body.inertia * w))


@wp.func
def next_step(limits: Limits, motion: BaseMotion, end: real, s: State) -> Base:
    """The next step, at most to a knot or to `end`, and the motion of the base in it."""
    zero = real(0.0)
    b = Base()
    mx, my, mz = motion.x, motion.y, motion.z
    value, slope = motion.value, motion.slope
    tx = knot_time(mx, s.knots[0])
    ty = knot_time(my, s.knots[1])
    tz = knot_time(mz, s.knots[2])
    target = smaller(smaller(tx, ty), smaller(tz, end))
    room = larger(target - s.time, zero)
    d = smaller(smaller(limits.longest_step, REACH / (wp.length(s.w) + TINY)), s.cap)
    quiet = (
        (s.knots[0] == 0 or tx >= NEVER)
        and (s.knots[1] == 0 or ty >= NEVER)
        and (s.knots[2] == 0 or tz >= NEVER)
    )
    # At rest on a base that will not move, the block waits until the end in one step. A remainder
    # of round-off alone is not a step: its impulses would be round-off, too.
    left = (s.stance == FLAT and s.slip == 0 and quiet) or room < d * MORE
    d = wp.where(left, room, d)
    b.d = d
    b.time = wp.where(d >= room, target, s.time + d)
    b.knots = s.knots
    b.kick = Vector()
    if b.time >= tx:
        b.knots[0] = s.knots[0] + 1
        b.kick[0] = knot_step(mx, s.knots[0])
    if b.time >= ty:
        b.knots[1] = s.knots[1] + 1
        b.kick[1] = knot_step(my, s.knots[1])
    if b.time >= tz:
        b.knots[2] = s.knots[2] + 1
        b.kick[2] = knot_step(mz, s.knots[2])
    along_x = expand(mx, s.knots[0], b.time, value[0], slope[0])
    along_y = expand(my, s.knots[1], b.time, value[1], slope[1])
    along_z = expand(mz, s.knots[2], b.time, value[2], slope[2])
    b.last = Vector(along_x.a0, along_y.a0, along_z.a0)
    b.change = Vector(
        base_change(mx, b.time, d, along_x.a0, along_x.a1, s.base[0], b.kick[0]),
        base_change(my, b.time, d, along_y.a0, along_y.a1, s.base[1], b.kick[1]),
        base_change(mz, b.time, d, along_z.a0, along_z.a1, s.base[2], b.kick[2]),
    )
    b.first = b.change * (TWO / larger(d, TINY)) - b.last
    return b


@wp.func(inline=False)
def probe(block: Block, limits: Limits, at: wp.ref[Moment], a: Vector) -> Held:
    """The motion over a very short step; its `spare` is per second.

    `a` is the acceleration of the base [m/s^2].
    """
    d = PROBE * limits.longest_step
    v, w = at.state.v, at.state.w
    soon = body_at(block, rotate_attitude(at.state.q, w * (HALF * d)))
    pull = a + Vector(real(0.0), real(0.0), limits.gravity)
    free = soon.inverse * (at.body.inertia * w)
    dirs = Corners()
    if at.state.slip != 0:
        dirs = directions(at.body, v, w)
    h = solve_as_before(
        soon, at.state.stance, at.state.slip, dirs, v - HALF * d * pull, free, real(0.0)
    )
    h.spare = h.spare / d
    return h


@wp.func(inline=False)
def find_release(
    block: Block, limits: Limits, begins: wp.ref[Moment], ends: wp.ref[Moment], base: Base, h: Held
) -> real:
    """Length of the step to where an edge lets go of one of its ends; NEVER if not inside.

    The friction across the edge jumps to zero there. The margin `spare` of that end is known in the
    middle of the step. Very short steps give it at the start and at the end. The event is the zero
    of a straight line through two of these values.
    """
    d = base.d
    sharp = SHARP * limits.longest_step
    middle = h.spare / larger(d, TINY)
    cut = TWO * NEVER
    if h.turns and d > sharp:
        first = probe(block, limits, begins, base.first)
        there = HALF * d * first.spare / (first.spare - middle)
        cut = wp.where(first.spare > real(0.0) and there > sharp, there, cut)
    s, reached = begins.state, ends.state
    if not h.turns and d > sharp and reached.stance == s.stance and reached.slip == s.slip:
        v, w = project(ends.body, reached.stance, reached.slip, reached.v, reached.w)
        bound = ends
        bound.state.v = v
        bound.state.w = w
        last = probe(block, limits, bound, base.last)
        there = HALF * d * (real(1.0) + middle / (middle - last.spare))
        cut = wp.where(last.turns and there < d - sharp, there, cut)
    return cut
