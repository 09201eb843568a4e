"""Second-order contact step of a stack of rocking blocks, for one precision, motion and count.

The scheme is that of event.py for all blocks at once: one clock a lane, a midpoint Moreau-Jean
step, an event inside a step ends the next one there, and at a step's end the velocity is projected
on its contacts. In the frame of the base, with v = (vx, vz, omega) of every block:

    1. mean velocity v_m = v - (dV/2, g d/2, 0) + W G^T p, G at the pose d/2 ahead, p such that
       v_m obeys the contact law of event_stack_contact.py at all interfaces;
    2. theta = theta + d omega_m; the place of every contact is carried along by its anchor (see
       stack.py), so that there is no drift; what flies moves by v_m; v = 2 v_m - v;
    3. if inside the step an open end lands, a pivoting block falls flat on what it stands on, a
       sliding contact stops or a block overturns, nothing is taken: the next step ends there;
    4. v is projected on the contacts at the end of the step. If something landed or the base
       stepped its velocity, this is the inelastic impact with Coulomb friction: all ends of the
       stack that touch then take part.

A closed interface shares one rotation, and while it sticks one motion, exactly; so a stack that
nothing moves stays where it is to the last digit, and on a base at rest it waits in one step.

Rest rule: an interface closes when its block, after an impact, would fall back inside the next
step from an opening below `rest_rotation`. The impacts that this leaves out take no time.

The kernel is scalar on purpose, one lane a thread on a CPU too: which contacts act differs from
lane to lane, and packs of lanes would run all branches of all.
"""

from typing import Any

import warp as wp

from warprock.kernels.instance import kernel_module

real: Any
PRECISION: str
MOTION: str
BLOCKS: int

stack = kernel_module("stack", precision=PRECISION, blocks=BLOCKS)
wp.set_module_options(stack.STACK_OPTIONS)
scalar = kernel_module("scalar", precision=PRECISION)
motion = kernel_module("motion", precision=PRECISION, motion=MOTION)
event = kernel_module("event", precision=PRECISION, motion=MOTION)
moves = kernel_module("event_stack_moves", precision=PRECISION, motion=MOTION, blocks=BLOCKS)
contact = kernel_module("event_stack_contact", precision=PRECISION, blocks=BLOCKS)
larger, smaller, size = scalar.larger, scalar.smaller, scalar.size
Motion, series = motion.Motion, motion.series
knot_time, knot_step = motion.knot_time, motion.knot_step
base_change, first_root = event.base_change, event.first_root
Values, Counts, Triples = stack.Values, stack.Counts, stack.Triples
Blocks, Pose, three_of = stack.Blocks, stack.Pose, stack.three_of
anchored, upright_place = stack.anchored, stack.upright_place
lower_face, all_rows = stack.lower_face, stack.all_rows
moved, flattened, glued, opening = moves.moved, moves.flattened, moves.glued, moves.opening
pivot_event, flight_event = moves.pivot_event, moves.flight_event
settle, bound_velocity = contact.settle, contact.bound_velocity
relative_velocity = contact.relative_velocity
Rows = stack.Rows
OPEN, PLUS, MINUS, CLOSED = stack.OPEN, stack.PLUS, stack.MINUS, stack.CLOSED

RUNNING = 0
OVERTURNED = 1
SLID_OFF = 2
BROKEN = 3
STALLED = 4
UNSETTLED = 5

STEADY = 0
SEEKING = 1
FOUND = 2

HALF = real(0.5)
TWO = real(2.0)
HALF_PI = real(1.5707963267948966)
NEVER = real(1.0e30)
NEARLY = real({"float64": 1.0e-6, "float32": 1.0e-4}[PRECISION])
"""Part of the longest step by which the time of an event may be missed."""
SOON = real(1.0e-3)
"""Part of the longest step by which the opening of a contact may be missed."""
DUST = real({"float64": 1.0e-12, "float32": 1.0e-5}[PRECISION])
"""Round-off of a velocity, as a part of the largest."""
TOUCHING = real({"float64": 1.0e-8, "float32": 1.0e-5}[PRECISION])
"""Opening [rad] below which an end takes part in an impact elsewhere."""
REACH = real(0.125)
"""Largest rotation in one step [rad]: keeps the polynomials in their range."""
SLOWEST = real(1.0e-30)
"""Keeps a quotient by an angular velocity of zero finite [rad/s]."""


@wp.struct
class Limits:
    """What a step needs to know of one lane besides its blocks."""

    gravity: real
    mass: real
    longest_step: real
    rest_rotation: Values


@wp.struct
class State:
    """State of one lane.

    velocity [m/s, rad/s] relative to the base; slip, the directions in which the interfaces slide;
    rate, relative velocities at the interfaces [m/s]; swing, angular velocities at the end of the
    last step before its impact [rad/s]; base velocity [m/s]; cap, the longest next step [s]; lost
    energy [J]; segment, knots passed; calm, whether the last step changed nothing; taken, whether
    the last trial was a step; seek, lack and span, see `sought`.
    """

    pose: Pose
    velocity: Triples
    rate: Triples
    slip: Counts
    swing: Values
    time: real
    base: real
    cap: real
    lost: real
    segment: int
    mode: int
    impacts: int
    calm: bool
    taken: bool
    seek: int
    lack: real
    span: real


@wp.struct
class Trial:
    """A step that has not been taken yet.

    Pose and velocity at its end before impacts; slip, the directions of sliding in it; length d
    [s]; time at its end [s]; change of the base's velocity in it and its velocity step [m/s]; lost
    energy [J]; cut, the length of the step to the first event inside it, else NEVER; falls, the
    ends that land; rests, the interfaces that close at its start instead; segment after it; turns, whether a contact
    opens or starts to slide in it, and what contacts would have to spare [N] if none did.
    """

    pose: Pose
    velocity: Triples
    slip: Counts
    d: real
    time: real
    dv: real
    kick: real
    lost: real
    cut: real
    falls: Counts
    resting: bool
    struck: bool
    settled: bool
    turns: bool
    spare: real
    segment: int


@wp.func
def fastest(velocity: Triples):
    """Largest velocity of a block's centre [m/s] and largest angular velocity [rad/s]."""
    speed = real(0.0)
    spin = real(0.0)
    for k in range(BLOCKS):
        speed = larger(speed, size(velocity[3 * k]))
        speed = larger(speed, size(velocity[3 * k + 1]))
        spin = larger(spin, size(velocity[3 * k + 2]))
    return speed, spin


@wp.func
def at_rest(touch: Counts, slip: Counts) -> bool:
    """Whether all interfaces are closed and stick."""
    rests = bool(True)
    for k in range(BLOCKS):
        rests = rests and touch[k] == CLOSED and slip[k] == 0
    return rests


@wp.func
def kinetic_energy(blocks: Blocks, velocity: Triples) -> real:
    """Kinetic energy in the frame of the base [J]."""
    energy = real(0.0)
    for k in range(BLOCKS):
        v = three_of(velocity, k)
        energy += HALF * (v[0] * v[0] + v[1] * v[1]) / blocks.inverse_mass[k]
        energy += HALF * v[2] * v[2] / blocks.inverse_inertia[k]
    return energy


@wp.func
def watched(blocks: Blocks, limits: Limits, s: State, trial: Trial) -> Trial:
    """The trial step with the events at its interfaces and the overturning of its blocks."""
    t = trial
    near = NEARLY * limits.longest_step
    rests = Counts()
    for k in range(BLOCKS):
        touch = t.pose.touch[k]
        if touch == OPEN:
            cut, lands = flight_event(blocks, s.pose, t.pose, s.velocity, t.velocity, k, t.d, near)
            t.cut = smaller(t.cut, cut)
            t.falls[k] = lands
            t.struck = t.struck or lands != OPEN
        elif touch != CLOSED:
            e0, r0 = opening(s.pose, s.velocity, k, touch)
            e1, r1 = opening(t.pose, t.velocity, k, touch)
            fresh = s.pose.touch[k] != CLOSED
            cut, falls, quiet = pivot_event(
                e0, r0, e1, r1, t.d, near, fresh, limits.rest_rotation[k]
            )
            t.cut = smaller(t.cut, cut)
            t.resting = t.resting or quiet
            rests[k] = wp.where(quiet, CLOSED, OPEN)
            t.falls[k] = wp.where(falls, CLOSED, OPEN)
            t.struck = t.struck or falls
        side = wp.where(t.pose.theta[k] < real(0.0), real(-1.0), real(1.0))
        left = HALF_PI - side * t.pose.theta[k]
        if left < -near * size(t.velocity[3 * k + 2]) and t.d > near:
            left0 = HALF_PI - side * s.pose.theta[k]
            t.cut = smaller(t.cut, first_root(left0, -side * s.velocity[3 * k + 2], left, t.d))
    if t.resting:
        t.falls = rests
        t.pose = s.pose
        t.velocity = s.velocity
        t.slip = s.slip
        t.lost = real(0.0)
        t.d = real(0.0)
        t.dv = real(0.0)
        t.kick = real(0.0)
        t.time = s.time
        t.cut = NEVER
        t.segment = s.segment
        t.struck = False
        t.turns = False
    return t


@wp.func
def tried(
    blocks: Blocks, limits: Limits, m: Motion, sample: real, sample_slope: real, end: real, s: State
) -> Trial:
    """One trial step, at most to the next knot of the motion or to `end`."""
    t = Trial()
    knot = knot_time(m, s.segment)
    target = smaller(knot, end)
    room = larger(target - s.time, real(0.0))
    speed, spin = fastest(s.velocity)
    d = smaller(smaller(limits.longest_step, REACH / (spin + SLOWEST)), s.cap)
    if s.calm and (s.segment == 0 or knot >= NEVER):
        d = room
    d = smaller(d, room)
    t.d = d
    t.time = wp.where(d >= room, target, s.time + d)
    passed = t.time >= knot
    t.segment = s.segment + wp.where(passed, 1, 0)
    t.kick = wp.where(passed, knot_step(m, s.segment), real(0.0))
    a, jerk, _a2, _a3, _a4, _a5, _a6, _a7, _a8 = series(m, s.segment, t.time, sample, sample_slope)
    t.dv = base_change(m, t.time, d, a, jerk, s.base, t.kick)
    slide = Values()
    free = s.velocity
    for k in range(BLOCKS):
        slide[k] = wp.where(s.slip[k] != 0, s.rate[3 * k], real(0.0))
        free[3 * k] = free[3 * k] - HALF * t.dv
        free[3 * k + 1] = free[3 * k + 1] - HALF * d * limits.gravity
    middle = moved(blocks, s.pose, s.pose.touch, s.velocity, slide, HALF * d)
    upper, lower, _plus, _minus = all_rows(blocks, middle)
    grain = DUST * (speed + limits.gravity * limits.longest_step)
    mean, impulse, hold, slip, settled, same, left = settle(
        blocks, upper, lower, s.pose.touch, s.slip, s.pose.touch, s.slip, free, False,
        grain, limits.mass,
    )  # fmt: skip
    t.settled = settled
    t.turns = not same
    t.spare = left / larger(d, SLOWEST)
    for k in range(BLOCKS):
        slide[k] = real(0.0)
        if slip[k] != 0 and hold[k] != OPEN:
            u = relative_velocity(upper, lower, mean, k)
            slide[k] = u[0]
            t.lost = t.lost - TWO * u[0] * impulse[3 * k]
        slip[k] = wp.where(hold[k] == OPEN, 0, slip[k])
    t.slip = slip
    t.pose = moved(blocks, s.pose, hold, mean, slide, d)
    t.velocity = TWO * mean - s.velocity
    t.cut = NEVER
    t.struck = t.kick != real(0.0)
    return watched(blocks, limits, s, t)


@wp.func
def stopping(slip: int, before: int, rate: real, along: real, d: real, near: real):
    """Where a sliding contact stops in a step, from its sliding velocities at both ends.

    Returns:
        Length of the step to there if that lies inside, else NEVER; direction of sliding after it.
    """
    zero = real(0.0)
    e0 = wp.where(slip == before, real(slip) * rate, zero)
    e1 = real(slip) * along
    cut = real(NEVER)
    after = slip
    if slip != 0 and d > near:
        reach = near * size(e1 - e0) / d
        if e0 > zero and e1 < -reach:
            cut = first_root(e0, (e1 - e0) / d, e1, d)
        elif e1 <= wp.where(e0 > zero, reach, zero):
            after = 0
    return cut, after


@wp.func
def outcome_of(blocks: Blocks, s: State, near: real) -> int:
    """What has become of a lane at the end of a step."""
    mode = int(RUNNING)
    for k in range(BLOCKS):
        low, _height = lower_face(blocks, k)
        anchor, rate = anchored(blocks, s.pose, k, s.pose.touch[k])
        place = upright_place(blocks, k, s.pose.touch[k], anchor, rate)
        if size(place) >= low + blocks.half_face[k]:
            mode = SLID_OFF
    for k in range(BLOCKS):
        if size(s.pose.theta[k]) >= HALF_PI - near * size(s.swing[k]):
            mode = OVERTURNED
    for k in range(BLOCKS):
        v = three_of(s.velocity, k)
        sound = s.pose.theta[k] + s.pose.along[k] + s.pose.above[k] + v[0] + v[1] + v[2] + s.time
        if not (sound - sound == real(0.0)):
            mode = BROKEN
    return mode


@wp.func
def sought(limits: Limits, s: State, t: Trial) -> State:
    """The state that goes on seeking when in a step a contact opens or starts to slide.

    The first trial with such a turn tells how much the contacts lack in its middle; a probe of
    next to no length tells what they have to spare at its start; the next step ends where, on a
    line between the two, nothing is left. A turn within `SOON` is not sought.
    """
    n = s
    soon = SOON * limits.longest_step
    n.taken = False
    if s.seek == SEEKING:
        n.seek = FOUND
        n.cap = NEVER
        if not t.turns:
            there = HALF * s.span * t.spare / (t.spare - s.lack)
            n.cap = wp.where(there > soon, there, NEVER)
    elif s.seek == STEADY and t.turns and t.d > soon and t.spare < real(0.0):
        n.seek = SEEKING
        n.lack = t.spare
        n.span = t.d
        n.cap = soon
    return n


@wp.func
def kept(
    blocks: Blocks,
    limits: Limits,
    upper: Rows,
    lower: Rows,
    touch: Counts,
    hold: Counts,
    v: Triples,
) -> Counts:
    """Ends that still touch after an impact: those held, and of an interface that leaves those
    that would not rise by more than the half face times `rest_rotation`."""
    ends = hold
    for k in range(BLOCKS):
        if hold[k] == OPEN and touch[k] != OPEN:
            u = relative_velocity(upper, lower, v, k)
            rise = TWO * limits.gravity * limits.rest_rotation[k] * blocks.half_face[k]
            for end in range(2):
                code = wp.where(end == 0, PLUS, MINUS)
                if (touch[k] & code) != 0 and u[1 + end] * u[1 + end] <= rise:
                    ends[k] = ends[k] + code
    return ends


@wp.func
def finished(blocks: Blocks, limits: Limits, s: State, trial: Trial) -> State:
    """The state after a trial step and its impacts, or the old one if an event lay inside."""
    t = trial
    near = NEARLY * limits.longest_step
    falls = t.falls
    hits = int(0)
    for k in range(BLOCKS):
        if falls[k] != OPEN and t.struck:
            hits += 1
        elif t.struck and t.pose.touch[k] != OPEN and t.pose.touch[k] != CLOSED:
            e1, _r1 = opening(t.pose, t.velocity, k, t.pose.touch[k])
            falls[k] = wp.where(e1 <= TOUCHING, CLOSED, OPEN)
    n = s
    n.pose = flattened(blocks, t.pose, falls)
    upper, lower, _plus, _minus = all_rows(blocks, n.pose)
    n.slip = t.slip
    for k in range(BLOCKS):
        u = relative_velocity(upper, lower, t.velocity, k)
        cut, after = stopping(t.slip[k], s.slip[k], s.rate[3 * k], u[0], t.d, near)
        t.cut = smaller(t.cut, cut)
        n.slip[k] = after
        n.swing[k] = t.velocity[3 * k + 2]
    if t.cut < NEVER:
        # Not shorter than what is near: what is left of the way then counts as arrived.
        n = s
        n.cap = larger(t.cut, HALF * near)
        n.taken = False
        n.mode = wp.where(t.settled, s.mode, UNSETTLED)
    else:
        v, _held, _sound = bound_velocity(blocks, upper, lower, t.pose.touch, n.slip, t.velocity)
        hold = n.pose.touch
        slip = n.slip
        settled = bool(True)
        if t.struck or t.resting:
            free = v
            for k in range(BLOCKS):
                free[3 * k] = free[3 * k] - t.kick
            speed, _spin = fastest(free)
            grain = DUST * (speed + limits.gravity * limits.longest_step)
            v, _impulse, hold, slip, settled, _same, _left = settle(
                blocks, upper, lower, n.pose.touch, Counts(), hold, slip, free, t.resting,
                grain, limits.mass,
            )  # fmt: skip
            n.lost = s.lost + kinetic_energy(blocks, free) - kinetic_energy(blocks, v)
        n.pose.touch = kept(blocks, limits, upper, lower, n.pose.touch, hold, v)
        for k in range(BLOCKS):
            n.slip[k] = wp.where(n.pose.touch[k] == OPEN, 0, slip[k])
        n.velocity = glued(blocks, n.pose, n.slip, v)
        for k in range(BLOCKS):
            u = relative_velocity(upper, lower, n.velocity, k)
            for i in range(3):
                n.rate[3 * k + i] = u[i]
        n.lost = n.lost + t.lost
        n.impacts = s.impacts + hits
        n.time = t.time
        n.segment = t.segment
        n.base = s.base + t.dv + t.kick
        n.cap = NEVER
        n.taken = True
        n.seek = STEADY
        n.calm = (
            at_rest(s.pose.touch, s.slip) and at_rest(n.pose.touch, n.slip)
            and t.dv == real(0.0) and t.kick == real(0.0)
        )  # fmt: skip
        n.mode = outcome_of(blocks, n, near)
        for k in range(BLOCKS):
            n.pose.theta[k] = larger(smaller(n.pose.theta[k], HALF_PI), -HALF_PI)
        if n.mode != BROKEN and not (settled and t.settled):
            n.mode = UNSETTLED
    return n


@wp.func
def step(
    blocks: Blocks, limits: Limits, m: Motion, sample: real, sample_slope: real, end: real, s: State
) -> State:
    """One trial step of one lane, at most to its next knot or to `end`.

    The state after it, unchanged but for `cap` where an event lay inside.
    """
    t = tried(blocks, limits, m, sample, sample_slope, end, s)
    n = sought(limits, s, t)
    if n.seek == s.seek or t.resting:
        n = finished(blocks, limits, s, t)
    return n
