"""Contact step of a stack of rocking blocks: order 5 while all contacts stick, else 2.

Where every interface touches and sticks, rotations follow Taylor polynomials, and the step ends at
the impact, opening or slip that these come to (event/stack_rocking.py, stack_rolling.py); where no
event lies in it, nothing else is done. Else the scheme is that of event/block.py for all blocks at
once: one clock a lane, a midpoint Moreau-Jean step, an event inside a step ends the next one there,
and at a step's end the velocity is projected on its contacts. In the frame of the base, with
v = (vx, vz, omega) of every block:

    1. mean velocity v_m = v - (dV/2, g d/2, 0) + W G^T p, G at the pose d/2 ahead, p such that
       v_m obeys the contact law of event/stack_contact.py at all interfaces;
    2. theta = theta + d omega_m; the place of every contact is carried along by its anchor (see
       shape/stack.py), so that there is no drift; what flies moves by v_m; v = 2 v_m - v;
    3. if inside the step an open end lands, a pivoting block falls flat on what it stands on, a
       sliding contact stops or a block overturns, nothing is taken: the next step ends there;
    4. v is projected on the contacts at the end of the step. If something landed or the base
       stepped its velocity, this is the inelastic impact with Coulomb friction: all ends of the
       stack that touch then take part.

A closed interface shares one rotation, and while it sticks one motion, exactly; so a stack that
nothing moves stays where it is to the last digit, and on a base at rest it waits in one step.

On a base that moves upwards, too, gravity is g + a_z, and where nothing of it is left blocks fly.

Rest rule: an interface closes when its block, after an impact, would fall back inside the next
step from an opening below `rest_rotation`. The impacts that this leaves out take no time.

The kernel is scalar on purpose, one lane a thread on a CPU too: which contacts act differs from
lane to lane, and packs of lanes would run all branches of all.
"""

import warp as wp

from warprock.kernels.event.stack_chain import bound_velocity, relative_velocity
from warprock.kernels.event.stack_contact import solve
from warprock.kernels.event.stack_moves import flattened, glued, opening
from warprock.kernels.event.stack_state import (
    DUST,
    FOUND,
    NEARLY,
    SEEKING,
    SOON,
    STEADY,
    Limits,
    State,
    Trial,
    at_rest,
    fastest,
    lost_between,
)
from warprock.kernels.event.stack_trial import stopping, tried
from warprock.kernels.event.stack_weight import left_behind, pushed_up
from warprock.kernels.modes import BROKEN, OVERTURNED, RUNNING, SLID_OFF, UNSOLVED
from warprock.kernels.motion import Motion
from warprock.kernels.shape.stack import (
    CLOSED,
    MINUS,
    OPEN,
    PLUS,
    Blocks,
    Counts,
    Rows,
    Triples,
    Values,
    all_rows,
    anchored,
    ends_below,
    lower_face,
    three_of,
    turn_of,
    upright_place,
)

if CHAINS:
    from warprock.kernels.event.stack_body import has_left

TOUCHING = by_precision(1.0e-8, 1.0e-5)
"""Opening [rad] below which an end takes part in an impact elsewhere."""


@wp.func
def sought(limits: Limits, s: State, t: Trial) -> State:
    """The state whose search goes on for the moment at which a contact opens or starts to slide.

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
    blocks: Blocks, limits: Limits, t: Trial, upper: Rows, lower: Rows, touch: Counts,
    hold: Counts, v: Triples,
) -> Counts:  # fmt: skip
    """Ends that still touch after an impact.

    Those held, and of an interface that leaves those that would not rise by more than the half
    face times `rest_rotation`.
    """
    ends = hold
    gravity = limits.gravity
    if VERTICAL:
        gravity = t.weight.end
    for k in range(BLOCKS):
        if hold[k] == OPEN and touch[k] != OPEN:
            u = relative_velocity(upper, lower, v, k)
            rise = TWO * gravity * limits.rest_rotation[k] * blocks.half_width[k]
            for end in range(2):
                code = wp.where(end == 0, PLUS, MINUS)
                if (touch[k] & code) != 0 and u[1 + end] * u[1 + end] <= rise:
                    ends[k] = ends[k] + code
    return ends


@wp.func
def mode_of(blocks: Blocks, s: State, near: real) -> int:
    """What has become of a lane at the end of a step."""
    mode = int(RUNNING)
    for k in range(BLOCKS):
        low, _height = lower_face(blocks, k)
        if CHAINS:
            mode = wp.where(has_left(blocks, s.pose, k), SLID_OFF, mode)
        else:
            ends = ends_below(s.pose, k)
            anchor, rate = anchored(blocks, s.pose, k, ends)
            place = upright_place(blocks, k, ends, anchor, rate)
            if size(place) >= low + blocks.half_width[k]:
                mode = SLID_OFF
    for k in range(BLOCKS):
        if size(s.pose.theta[k]) >= HALF_PI - near * size(s.swing[k]):
            mode = OVERTURNED
        if CHAINS:
            upright = size(turn_of(s.pose, k) + s.pose.foot[k]) < HALF_PI
            mode = wp.where(upright, mode, OVERTURNED)
    return sound_mode(s, mode)


@wp.func
def sound_mode(s: State, running: int) -> int:
    """A mode, or BROKEN where the state is not finite."""
    mode = int(running)
    for k in range(BLOCKS):
        v = three_of(s.velocity, k)
        sound = s.pose.theta[k] + s.pose.along[k] + s.pose.above[k] + v[0] + v[1] + v[2] + s.time
        mode = wp.where(sound - sound == real(0.0), mode, BROKEN)
    return mode


@wp.func
def landed(before: Counts, touch: Counts) -> Counts:
    """Ends that are likely to be held in an impact: where a block falls flat, those that land."""
    ends = touch
    for k in range(BLOCKS):
        if touch[k] == CLOSED and before[k] != OPEN and before[k] != CLOSED:
            ends[k] = CLOSED - before[k]
    return ends


@wp.func
def kicked(t: Trial, velocity: Triples) -> Triples:
    """Velocities seen from the base after its velocity steps at the end of a trial step."""
    v = velocity
    for k in range(BLOCKS):
        v[3 * k] = v[3 * k] - t.kick
    if VERTICAL:
        v = left_behind(v, t.weight.kick)
    return v


@wp.func
def lost_in_impact(blocks: Blocks, t: Trial, free: Triples, velocity: Triples) -> real:
    """Energy that contacts take at the end of a trial step [J], see `lost_between`."""
    lost = lost_between(blocks, t.kick, free, velocity)
    if VERTICAL:
        lost = lost - pushed_up(blocks, t.weight.kick, free, velocity)
    return lost


@wp.func
def base_moved(s: State, reached: State, t: Trial) -> State:
    """The state reached from s by a step, with the clock and the base at its end."""
    n = reached
    n.time = t.time
    n.segment = t.segment
    n.base = s.base + t.dv + t.kick
    if VERTICAL:
        n.rising = s.rising + t.weight.gained + t.weight.kick
        n.risen = s.risen + wp.where(t.weight.passed, 1, 0)
    return n


@wp.func
def ended(s: State, reached: State, t: Trial) -> State:
    """The state reached from s by a step that is taken."""
    n = reached
    n.cap = NEVER
    n.taken = True
    n.plain = t.plain
    n.seek = wp.where(t.spends, FOUND, STEADY)
    n.calm = (
        at_rest(s.pose.touch, s.slip) and at_rest(n.pose.touch, n.slip)
        and t.dv == real(0.0) and t.kick == real(0.0)
    )  # fmt: skip
    if VERTICAL:
        n.calm = n.calm and t.weight.gained == real(0.0) and t.weight.kick == real(0.0)
    return n


@wp.func
def projected(
    blocks: Blocks, limits: Limits, s: State, reached: State, t: Trial, upper: Rows, lower: Rows
) -> State:
    """The state at the end of a step that is taken: velocities projected, impacts included.

    Args:
        blocks: The blocks.
        limits: The lane's limits.
        s: State before the step.
        reached: State with the pose and the directions of sliding at its end.
        t: The step.
        upper: Rows of the upper blocks at its end.
        lower: Rows of the lower blocks at its end.
    """
    n = reached
    v = t.velocity
    if not t.rolls:
        v = bound_velocity(blocks, upper, lower, t.pose.touch, n.slip, t.velocity)
    hold = n.pose.touch
    slip = n.slip
    settled = bool(True)
    if t.struck or t.resting:
        free = kicked(t, v)
        speed, _spin = fastest(free)
        grain = DUST * (speed + limits.gravity * limits.longest_step)
        if t.struck:
            v, _impulse, hold, slip, settled, _same, _left = solve(
                blocks, upper, lower, hold, Counts(), landed(t.pose.touch, hold), slip, free,
                grain, limits.mass,
            )  # fmt: skip
        else:
            # An end that closes without an impact has no friction, so that it adds no energy.
            smooth = blocks
            smooth.friction = Values()
            v = bound_velocity(smooth, upper, lower, hold, slip, free)
        n.lost = s.lost + lost_in_impact(blocks, t, free, v)
    n.pose.touch = kept(blocks, limits, t, upper, lower, n.pose.touch, hold, v)
    for k in range(BLOCKS):
        n.slip[k] = wp.where(n.pose.touch[k] == OPEN, 0, slip[k])
    n.velocity = glued(blocks, n.pose, n.slip, v)
    for k in range(BLOCKS):
        u = relative_velocity(upper, lower, n.velocity, k)
        for i in range(3):
            n.rate[3 * k + i] = u[i]
    n.lost = n.lost + t.lost
    n = ended(s, base_moved(s, n, t), t)
    n.mode = mode_of(blocks, n, NEARLY * limits.longest_step)
    for k in range(BLOCKS):
        n.pose.theta[k] = larger(smaller(n.pose.theta[k], HALF_PI), -HALF_PI)
    if n.mode != BROKEN and not (settled and t.settled):
        n.mode = UNSOLVED
    return n


@wp.func
def cut_short(limits: Limits, s: State, t: Trial) -> State:
    """The old state, whose next step ends at the event inside this one."""
    # Not shorter than `near`: with less than that left to go, the event is reached. An event at
    # the very end of the step would be met there for ever.
    near = NEARLY * limits.longest_step
    n = s
    n.cap = larger(wp.where(t.cut > t.d - near, HALF * t.d, t.cut), HALF * near)
    n.taken = False
    n.mode = wp.where(t.settled, s.mode, UNSOLVED)
    return n


@wp.func
def end_of_step(blocks: Blocks, limits: Limits, s: State, tentative: Trial) -> State:
    """The state after a trial step and its impacts, or the old one if an event lay inside."""
    t = tentative
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
    n.curve = t.curve
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
        return cut_short(limits, s, t)
    n.impacts = s.impacts + hits
    n.deepest = larger(t.deep, s.deepest)
    return projected(blocks, limits, s, n, t, upper, lower)


@wp.func(inline=False)
def with_events(blocks: Blocks, limits: Limits, s: State, t: Trial) -> State:
    """The state after a trial step, or the old one with what is to be sought or cut."""
    n = sought(limits, s, t)
    if n.seek != s.seek and not t.resting:
        return n
    return end_of_step(blocks, limits, s, t)


@wp.func
def rolled_on(s: State, t: Trial) -> State:
    """The state after a step without events of a stack that sticks at all its contacts."""
    n = s
    n.pose = t.pose
    n.velocity = t.velocity
    n.rate = Triples()
    n.slip = Counts()
    n.curve = t.curve
    for k in range(BLOCKS):
        n.swing[k] = t.velocity[3 * k + 2]
    n = ended(s, base_moved(s, n, t), t)
    n.mode = sound_mode(n, RUNNING)
    return n


@wp.func
def step(
    blocks: Blocks, limits: Limits, m: Motion, sample: real, sample_slope: real, end: real, s: State
) -> State:
    """One trial step of one lane, at most to its next knot or to `end`.

    The state after it, unchanged but for `cap` where an event lay inside.
    """
    t = tried(blocks, limits, m, sample, sample_slope, end, s)
    if t.plain:
        return rolled_on(s, t)
    return with_events(blocks, limits, s, t)
