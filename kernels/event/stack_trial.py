"""One trial step of a stack of blocks, before it is taken; see event/stack.py for the scheme."""

import warp as wp

from warprock.kernels.event.block import base_change, first_root
from warprock.kernels.event.body_weight import Weight, kicks, weight_in
from warprock.kernels.event.stack_contact import relative_velocity, solve
from warprock.kernels.event.stack_moves import flight_event, moved, opening, pivot_event
from warprock.kernels.event.stack_rocking import DEGREE, Curves, Terms, rocking
from warprock.kernels.event.stack_rolling import (
    LACKS,
    SPENT,
    rolled,
    rolled_velocity,
    value_in,
)
from warprock.kernels.event.stack_weight import keeps_height, left_behind, until_knot
from warprock.kernels.motion import Motion, knot_step, knot_time, series
from warprock.kernels.shape.above import Above
from warprock.kernels.shape.stack import (
    CLOSED,
    OPEN,
    Blocks,
    Counts,
    Pose,
    Triples,
    Values,
    all_rows,
    lower_face,
    side_of,
    three_of,
)

if CHAINS:
    from warprock.kernels.event.stack_body import next_edge

NEARLY = by_precision(1.0e-6, 1.0e-4)
"""Part of the longest step by which the time of an event may be missed."""
DUST = by_precision(1.0e-12, 1.0e-5)
"""Round-off of a velocity, as a part of the largest."""
REACH = real(0.125)
"""Largest rotation in one step [rad]: keeps the polynomials in their range."""
SLOWEST = real(1.0e-30)
"""Keeps a quotient by zero finite."""
GRAIN = by_precision(1.0e-15, 1.0e-6)
"""Round-off of a rotation [rad]."""
PART = real(0.25)
"""Longest step where something slides or flies, over that of a stack that sticks: it is of second
order, the other of fifth."""
STEADY = 0
SEEKING = 1
FOUND = 2
"""Whether the moment is sought at which a contact opens or starts to slide, see `sought`."""
SOON = real(1.0e-3)
"""Part of the longest step by which that moment may be missed."""


@wp.struct
class Limits:
    """What a step needs to know of one lane besides its blocks; above, where its base stands."""

    gravity: real
    mass: real
    longest_step: real
    rest_rotation: Values
    if VERTICAL:
        above: Above


@wp.struct
class State:
    """State of one lane.

    velocity [m/s, rad/s] relative to the base; slip, the directions in which the interfaces slide;
    rate, relative velocities at the interfaces [m/s]; swing, angular velocities at the end of the
    last step before its impact [rad/s]; base velocity [m/s]; cap, the longest next step [s]; lost
    energy [J]; segment, knots passed; calm, whether the last step changed nothing; taken, whether
    the last trial was a step; deepest, how deep an end was in a face at the end of a step, before
    it was put back [m]; seek, lack and span, see `sought`; plain, whether the last step rolled and
    had no event; curve, the rotations in the last step as
    polynomials of the time since its start; rising, velocity of the base upwards
    [m/s]; risen, knots of its vertical motion passed.
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
    deepest: real
    seek: int
    lack: real
    span: real
    plain: bool
    curve: Curves
    if VERTICAL:
        rising: real
        risen: int


@wp.struct
class Trial:
    """A step that has not been taken yet.

    Pose and velocity at its end before impacts; slip, the directions of sliding in it; length d
    [s]; time at its end [s]; change of the base's velocity in it and its velocity step [m/s]; lost
    energy [J]; cut, the length of the step to the first event inside it, else NEVER; falls, the
    ends that land; rests, the interfaces that close at its start instead; segment after it;
    turns, whether a contact opens or starts to slide in it; spare, what the contacts would have
    left if none did [N]; deep, how deep an end is in a face at its end [m]; rolls, whether all its
    contacts stick and it follows their polynomials (event/stack_rocking.py), and spends, whether it
    ends where a contact has nothing left to spare; plain, whether it rolls and has no event; curve, see `State`; weight, what weighs; way, by
    how many edges bodies roll on at its end, see event/stack_body.py.
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
    deep: real
    rolls: bool
    spends: bool
    plain: bool
    curve: Curves
    if CHAINS:
        way: Counts
    if VERTICAL:
        weight: Weight


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
def lost_between(blocks: Blocks, kick: real, free: Triples, velocity: Triples) -> real:
    """Energy that contacts take in an impact [J].

    The base's work on the blocks is at the mean of the velocities before and after, see account.py.

    Args:
        blocks: The blocks.
        kick: Velocity step of the base [m/s].
        free, velocity: Velocities after it without contact and with it.
    """
    lost = kinetic_energy(blocks, free) - kinetic_energy(blocks, velocity)
    for k in range(BLOCKS):
        lost -= HALF * kick * (velocity[3 * k] - free[3 * k]) / blocks.inverse_mass[k]
    return lost


if CHAINS:

    @wp.func
    def with_next_edges(blocks: Blocks, s: State, trial: Trial, near: real) -> Trial:
        """The trial step with the edges that its blocks come to, see event/stack_body.py."""
        t = trial
        for k in range(BLOCKS):
            cut, way, lands, leaves = next_edge(
                blocks, s.pose, t.pose, s.velocity, t.velocity, k, t.d, near
            )
            t.cut = smaller(t.cut, cut)
            if leaves:
                t.falls[k] = OPEN
            if t.falls[k] == OPEN:
                t.way[k] = way
                if lands:
                    t.falls[k] = CLOSED
                    t.struck = True
        return t


@wp.func
def still_curve(s: State) -> Curves:
    """Rotations and angular velocities of a state, as polynomials that end there."""
    curve = Curves()
    for k in range(BLOCKS):
        curve[k, 0] = s.pose.theta[k]
        curve[k, 1] = s.velocity[3 * k + 2]
    return curve


@wp.func
def watched(blocks: Blocks, limits: Limits, s: State, trial: Trial) -> Trial:
    """The trial step with the events at its interfaces and the overturning of its blocks."""
    t = trial
    near = NEARLY * limits.longest_step
    rests = Counts()
    for k in range(BLOCKS):
        touch = t.pose.touch[k]
        if touch == OPEN:
            cut, lands, lowest = flight_event(
                blocks, s.pose, t.pose, s.velocity, t.velocity, k, t.d, near
            )
            t.cut = smaller(t.cut, cut)
            t.falls[k] = lands
            t.deep = larger(-lowest, t.deep)
            t.struck = t.struck or lands != OPEN
        elif touch != CLOSED:
            e0, r0 = opening(s.pose, s.velocity, k, touch)
            e1, r1 = opening(t.pose, t.velocity, k, touch)
            fresh = s.pose.touch[k] != CLOSED
            bend = (e1 - e0 - r0 * t.d) / (t.d * t.d)
            if t.rolls:
                bend = t.curve[k, 2]
                if k > 0:
                    bend = bend - t.curve[k - 1, 2]
                bend = side_of(touch) * bend
            cut, falls, quiet = pivot_event(
                e0, r0, e1, r1, bend, t.d, near, fresh, limits.rest_rotation[k]
            )
            t.cut = smaller(t.cut, cut)
            t.resting = t.resting or quiet
            rests[k] = wp.where(quiet, CLOSED, OPEN)
            t.falls[k] = wp.where(falls, CLOSED, OPEN)
            t.struck = t.struck or falls
            # A block that has turned past the lower face is deepest at the end that was open.
            low, _height = lower_face(blocks, k)
            t.deep = larger(-TWO * smaller(low, blocks.half_width[k]) * sine(e1), t.deep)
        side = wp.where(t.pose.theta[k] < real(0.0), real(-1.0), real(1.0))
        left = HALF_PI - side * t.pose.theta[k]
        if left < -near * size(t.velocity[3 * k + 2]) and t.d > near:
            left0 = HALF_PI - side * s.pose.theta[k]
            t.cut = smaller(t.cut, first_root(left0, -side * s.velocity[3 * k + 2], left, t.d))
    if CHAINS:
        t = with_next_edges(blocks, s, t, near)
    if t.resting:
        t.falls = rests
        if CHAINS:
            t.way = Counts()
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
        t.rolls = False
        t.spends = False
        t.curve = still_curve(s)
        t.deep = real(0.0)
        if VERTICAL:
            t.weight = Weight(t.weight.start, t.weight.start, real(0.0), real(0.0), False)
    return t


@wp.func
def clocked(
    limits: Limits, m: Motion, sample: real, sample_slope: real, target: real, s: State,
    trial: Trial, d: real,
) -> Trial:  # fmt: skip
    """The trial with a length of its step, at most to `target`, and what the base does in it."""
    t = trial
    room = larger(target - s.time, real(0.0))
    t.d = d
    t.time = wp.where(d >= room, target, s.time + d)
    passed = t.time >= knot_time(m, s.segment)
    t.segment = s.segment + wp.where(passed, 1, 0)
    t.kick = wp.where(passed, knot_step(m, s.segment), real(0.0))
    a, jerk, _a2, _a3, _a4, _a5, _a6, _a7, _a8 = series(m, s.segment, t.time, sample, sample_slope)
    t.dv = base_change(m, t.time, d, a, jerk, s.base, t.kick)
    t.struck = t.kick != real(0.0)
    if VERTICAL:
        t.weight = weight_in(limits.gravity, limits.above, t.time, d, s.rising)
        t.struck = kicks(t.weight, t.kick)
    return t


@wp.func
def sticks(touch: Counts, slip: Counts) -> bool:
    """Whether an end touches at every interface, and none slides."""
    found = bool(True)
    for k in range(BLOCKS):
        found = found and touch[k] != OPEN and slip[k] == 0
    return found


@wp.func(inline=False)
def rolling(
    blocks: Blocks, limits: Limits, m: Motion, sample: real, sample_slope: real, target: real,
    s: State, trial: Trial, touch: Counts, d: real,
) -> Trial:  # fmt: skip
    """The trial in which all ends that touch stick, if they do (`rolls`), of at most a length."""
    t = trial
    a0, a1, a2, a3, a4, _a5, _a6, _a7, _a8 = series(m, s.segment, s.time, sample, sample_slope)
    zero = real(0.0)
    up = Terms()
    if VERTICAL:
        above = limits.above
        z0, z1, z2, z3, z4, _z5, _z6, _z7, _z8 = series(
            above.motion, above.segment, s.time, above.value, above.slope
        )
        up = Terms(z0, z1, z2, z3, z4)
    up[0] = up[0] + limits.gravity
    r = rocking(blocks, s.pose, touch, s.velocity, Terms(a0, a1, a2, a3, a4), up)
    d1, found, lands = rolled(
        blocks, s.pose, touch, r, d, NEARLY * limits.longest_step, GRAIN, limits.rest_rotation,
        limits.mass * limits.gravity, SOON * limits.longest_step,
    )  # fmt: skip
    t.rolls = found != LACKS
    if t.rolls:
        t.spends = found == SPENT
        t = clocked(limits, m, sample, sample_slope, target, s, t, d1)
        t.curve = r.theta
        mean = Triples()
        for k in range(BLOCKS):
            mean[3 * k + 2] = (value_in(r.theta, k, DEGREE, d1) - s.pose.theta[k]) / larger(
                d1, SLOWEST
            )
        t.pose = moved(blocks, s.pose, touch, mean, Values(), d1)
        t.velocity = rolled_velocity(r.chain, t.pose, r.theta, d1)
        t.plain = not lands and not t.struck
        for k in range(BLOCKS):
            left = HALF_PI - size(t.pose.theta[k])
            t.plain = t.plain and left > NEARLY * limits.longest_step * size(t.velocity[3 * k + 2])
        t.slip = Counts()
        t.settled = True
        t.turns = False
        t.lost = zero
    return t


@wp.func
def tried(
    blocks: Blocks, limits: Limits, m: Motion, sample: real, sample_slope: real, end: real, s: State
) -> Trial:
    """One trial step, at most to the next knot of the motion or to `end`."""
    t = Trial()
    t.cut = NEVER
    knot = knot_time(m, s.segment)
    target = smaller(knot, end)
    calm = s.calm and (s.segment == 0 or knot >= NEVER)
    if VERTICAL:
        target = until_knot(limits.above, target)
        calm = calm and keeps_height(limits.above)
    room = larger(target - s.time, real(0.0))
    speed, spin = fastest(s.velocity)
    longest = smaller(smaller(limits.longest_step, REACH / (spin + SLOWEST)), s.cap)
    if calm:
        longest = room
    d = smaller(longest, room)
    lacks = bool(False)
    if not CHAINS:
        rests = sticks(s.pose.touch, s.slip)
        if rests and s.seek == STEADY:
            t = rolling(blocks, limits, m, sample, sample_slope, target, s, t, s.pose.touch, d)
            lacks = not t.rolls
    if not t.rolls:
        part = real(d)
        if not CHAINS:
            part = smaller(d, larger(PART * limits.longest_step, smaller(s.cap, d)))
        t = mean_step(
            blocks, limits, clocked(limits, m, sample, sample_slope, target, s, t, part), s, speed
        )
        if not CHAINS:
            # What is lacking from the start need not be sought.
            t.turns = t.turns and not lacks
            if rests and (lacks or s.seek == FOUND) and sticks(t.pose.touch, t.slip):
                t = rolling(blocks, limits, m, sample, sample_slope, target, s, t, t.pose.touch, d)
    if not t.plain:
        t = watched(blocks, limits, s, t)
    return t


@wp.func(inline=False)
def mean_step(blocks: Blocks, limits: Limits, trial: Trial, s: State, speed: real) -> Trial:
    """The trial by the mean velocity that obeys the contact law in its middle."""
    t = trial
    d = t.d
    slide = Values()
    glide = Counts()
    free = s.velocity
    for k in range(BLOCKS):
        slide[k] = wp.where(s.slip[k] != 0, s.rate[3 * k], real(0.0))
        glide[k] = wp.where(real(s.slip[k]) * slide[k] > real(0.0), s.slip[k], 0)
        free[3 * k] = free[3 * k] - HALF * t.dv
        free[3 * k + 1] = free[3 * k + 1] - HALF * d * limits.gravity
    if VERTICAL:
        free = left_behind(free, HALF * t.weight.gained)
    middle = moved(blocks, s.pose, s.pose.touch, s.velocity, slide, HALF * d)
    upper, lower, _plus, _minus = all_rows(blocks, middle)
    grain = DUST * (speed + limits.gravity * limits.longest_step)
    mean, impulse, hold, slip, settled, same, left = solve(
        blocks, upper, lower, s.pose.touch, glide, s.pose.touch, s.slip, free, grain,
        limits.mass,
    )  # fmt: skip
    t.settled = settled
    t.turns = not same
    t.spare = left / larger(d, SLOWEST)
    t.curve = still_curve(s)
    for k in range(BLOCKS):
        slide[k] = real(0.0)
        if slip[k] != 0 and hold[k] != OPEN:
            u = relative_velocity(upper, lower, mean, k)
            slide[k] = u[0]
            t.lost = t.lost - TWO * u[0] * impulse[3 * k]
        slip[k] = wp.where(hold[k] == OPEN, 0, slip[k])
        t.curve[k, 2] = (mean[3 * k + 2] - s.velocity[3 * k + 2]) / larger(d, SLOWEST)
    t.slip = slip
    t.pose = moved(blocks, s.pose, hold, mean, slide, d)
    t.velocity = TWO * mean - s.velocity
    return t


@wp.func
def stopping(slip: int, before: int, rate: real, along: real, d: real, near: real):
    """Where a sliding contact stops in a step, from its sliding velocities at both ends.

    Returns:
        Length of the step to there if that lies inside, else NEVER; direction of sliding after it.
    """
    zero = real(0.0)
    e0 = wp.where(slip == before, real(slip) * rate, zero)
    e1 = real(slip) * along
    cut = NEVER
    after = slip
    if slip != 0 and d > zero:
        reach = near * size(e1 - e0) / d
        if e0 > zero and e1 < -reach and d > near:
            cut = first_root(e0, (e1 - e0) / d, e1, d)
        elif e1 <= wp.where(e0 > zero, reach, zero):
            after = 0
    return cut, after
