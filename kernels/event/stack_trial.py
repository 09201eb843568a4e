"""One trial step of a stack of blocks, before it is taken; see event/stack.py for the scheme."""

import warp as wp

from warprock.kernels.event.block_begin import base_change, first_root
from warprock.kernels.event.body_weight import Weight, kicks, weight_in
from warprock.kernels.event.stack_chain import relative_velocity
from warprock.kernels.event.stack_contact import solve
from warprock.kernels.event.stack_moves import flight_event, moved, opening, pivot_event
from warprock.kernels.event.stack_rocking import Terms, rocking
from warprock.kernels.event.stack_rolling import (
    LACKS,
    SPENT,
    rolled,
    rolled_velocity,
    value_of,
)
from warprock.kernels.event.stack_weight import keeps_height, left_behind, until_knot
from warprock.kernels.motion import Motion, knot_step, knot_time, series
from warprock.kernels.shape.stack import (
    CLOSED,
    MINUS,
    OPEN,
    PLUS,
    Blocks,
    Counts,
    Triples,
    Values,
    all_rows,
    lower_face,
    side_of,
)

if CHAINS:
    from warprock.kernels.event.stack_body import next_edge

from warprock.kernels.event.stack_state import (
    DUST,
    FOUND,
    GRAIN,
    NEARLY,
    REACH,
    SLOWEST,
    SOON,
    STEADY,
    STILL,
    Limits,
    State,
    Trial,
    fastest,
    still_curve,
)

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
def closing(s: State, trial: Trial, rests: Counts) -> Trial:
    """The trial without a step, at whose start some interfaces close instead."""
    t = trial
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


@wp.func(inline=False)
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
        t = closing(s, t, rests)
    return t


@wp.func(inline=False)
def clocked(
    limits: Limits, m: Motion, sample: real, sample_slope: real, target: real, s: State, d: real
) -> Trial:
    """A trial of a length of its step, at most to `target`, with what the base does in it."""
    t = Trial()
    t.cut = NEVER
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


@wp.func
def stays_put(touch: Counts, rate: Triples, grain: real) -> bool:
    """Whether no end that touches moves against what it touches.

    One that an impact has let go so slowly that it counts as touching may do so.
    """
    found = bool(True)
    for k in range(BLOCKS):
        along = size(rate[3 * k])
        plus = wp.where((touch[k] & PLUS) != 0, size(rate[3 * k + 1]), real(0.0))
        minus = wp.where((touch[k] & MINUS) != 0, size(rate[3 * k + 2]), real(0.0))
        found = found and larger(along, larger(plus, minus)) <= grain
    return found


@wp.func(inline=False)
def rolling(
    blocks: Blocks, limits: Limits, m: Motion, sample: real, sample_slope: real, target: real,
    s: State, touch: Counts, d: real,
) -> Trial:  # fmt: skip
    """The trial in which all ends that touch stick, if they do (`rolls`), of at most a length."""
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
    if found == LACKS:
        return Trial()
    t = clocked(limits, m, sample, sample_slope, target, s, d1)
    t.rolls = True
    t.spends = found == SPENT
    t.curve = r.theta
    mean = Triples()
    per = real(1.0) / larger(d1, SLOWEST)
    for k in range(BLOCKS):
        mean[3 * k + 2] = (value_of(r.theta[k], d1) - s.pose.theta[k]) * per
    t.pose = moved(blocks, s.pose, touch, mean, Values(), d1)
    t.velocity = rolled_velocity(r.chain, t.pose, r.theta, d1)
    t.plain = not lands and not t.struck
    if CHAINS:
        # A body may come to its next edge.
        t.plain = False
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
    grain = STILL * (speed + limits.gravity * limits.longest_step)
    stuck = sticks(s.pose.touch, s.slip) and stays_put(s.pose.touch, s.rate, grain)
    # A struct that is set under a condition is copied each time; one that is returned is not.
    if stuck and s.seek == STEADY:
        first = rolling(blocks, limits, m, sample, sample_slope, target, s, s.pose.touch, d)
        if first.plain:
            return first
        if first.rolls:
            return watched(blocks, limits, s, first)
    t = clocked(limits, m, sample, sample_slope, target, s, d)
    t = mean_step(blocks, limits, t, s, speed)
    # What is lacking from the start need not be sought.
    t.turns = t.turns and not (stuck and s.seek == STEADY)
    if stuck and (s.seek == STEADY or s.seek == FOUND) and sticks(t.pose.touch, t.slip):
        other = rolling(blocks, limits, m, sample, sample_slope, target, s, t.pose.touch, d)
        if other.plain:
            return other
        if other.rolls:
            return watched(blocks, limits, s, other)
    return watched(blocks, limits, s, t)


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
    t.slip = slip
    t.pose = moved(blocks, s.pose, hold, mean, slide, d)
    for k in range(BLOCKS):
        bend = t.pose.theta[k] - s.pose.theta[k] - d * s.velocity[3 * k + 2]
        t.curve[k, 2] = wp.where(d > real(0.0), bend / (d * d), real(0.0))
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
