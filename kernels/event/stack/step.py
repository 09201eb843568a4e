"""Contact step of a stack of rocking blocks: order 5 while all contacts stick, else 2.

While every interface touches and sticks, rotations follow Taylor polynomials, and the step ends at
their first impact, opening or slip (rocking.py, rocking_end.py); if no event lies in it, nothing
else is done. Else the scheme is that of event/block/step.py for all blocks at once: one clock a
lane, a midpoint Moreau-Jean step, an event inside a step ends the next one there, and at a step's
end the velocity is projected on its contacts. In the frame of the base, with v = (vx, vz, omega) of
every block:

    1. mean velocity v_m = v - (dV/2, g d/2, 0) + W G^T p, G at the pose d/2 ahead, p such that
       v_m obeys the contact law of event/stack/contact.py at all interfaces;
    2. theta = theta + d omega_m; every contact keeps its anchor but for its slide (see
       shape/stack.py), so that there is no drift; what flies moves by v_m; v = 2 v_m - v;
    3. if inside the step an open end lands, a pivoting block falls flat on what it stands on, a
       sliding contact stops or a block overturns, the step is not taken: the next one ends there;
    4. v is projected on the contacts at the end of the step. If something landed or the base
       stepped its velocity, this is the inelastic impact with Coulomb friction, in which all ends
       of the stack take part that touch then.

A stack that sticks before an impact and after it is a chain, whose angular velocities say all of it
(event/stack/strike.py). So is one in which an interface closes at the start of a step.

A closed interface shares one rotation, and while it sticks one motion, exactly. So a stack that
nothing moves stays where it is to the last digit, and on a base at rest it waits in one step.

On a base that moves upwards, too, gravity is g + a_z; blocks fly when it is not positive.

A stack at rest waits for the moment at which the base lets it go (event/stack/rest.py).

Rest rule: an interface closes when its block would fall back inside the next step from an opening
below `rest_rotation`. The impacts that this leaves out take no time.

The kernel is scalar on purpose, one lane a thread on a CPU too: which contacts act differs from
lane to lane, and packs of lanes would run all branches of all. Functions take large structs as
`wp.ref`, a pointer, and fill what they find likewise: copies took up to a quarter of the time.
"""

import warp as wp

from warprock.kernels.event.body.weight import kicks
from warprock.kernels.event.stack.chain import Contacts, constrain, relative_velocity
from warprock.kernels.event.stack.contact import RoundOff, Solution, solve
from warprock.kernels.event.stack.links import hold_together, link
from warprock.kernels.event.stack.moves import find_departure, find_stop, glue, lay_down, opening
from warprock.kernels.event.stack.state import (
    DUST,
    FOUND,
    NEARLY,
    SEEKING,
    SOON,
    STEADY,
    Limits,
    Search,
    State,
    Trial,
    as_base_rises,
    at_rest,
    largest_speeds,
    lost_in_impact,
)
from warprock.kernels.event.stack.strike import strike
from warprock.kernels.lane.modes import BROKEN, OVERTURNED, RUNNING, SLID_OFF, UNSOLVED
from warprock.kernels.shape.stack import (
    CLOSED,
    MINUS,
    OPEN,
    PLUS,
    Blocks,
    Counts,
    Jacobian,
    Pose,
    Triples,
    Values,
    fill_jacobian,
    lower_face,
    slide_place,
    three_of,
    turn_of,
)

if BOUNCES:
    from warprock.kernels.event.stack.bounce import bounce
if CHAINS:
    from warprock.kernels.event.stack.edges import has_left

TOUCHING = by_precision(1.0e-8, 1.0e-5)
"""Opening [rad] below which an end takes part in an impact elsewhere."""


@wp.func
def search_switch(
    limits: wp.ref[Limits], s: wp.ref[State], t: wp.ref[Trial], n: wp.ref[State]
):  # fmt: skip
    """Sets the search of a state n for the moment at which a contact lets go, see `Search`.

    The first trial in which a contact lets go tells the lack of force in its middle. A probe of
    next to no length tells the margin at its start. The next step ends where a line between the two
    is zero. A moment within `SOON` is not searched for.
    """
    soon = SOON * limits.longest_step
    if s.search.stage == SEEKING:
        n.search.stage = FOUND
        n.cap = NEVER
        if not t.switches:
            there = HALF * s.search.span * t.spare / (t.spare - s.search.lack)
            n.cap = wp.where(there > soon, there, NEVER)
    elif s.search.stage == STEADY and t.switches and t.d > soon and t.spare < real(0.0):
        n.search = Search(SEEKING, t.spare, t.d)
        n.cap = soon


@wp.func
def keep_touching(
    blocks: wp.ref[Blocks], limits: wp.ref[Limits], t: wp.ref[Trial], g: wp.ref[Jacobian],
    touch: Counts, hold: Counts, v: Triples,
) -> Counts:  # fmt: skip
    """Ends that still touch after an impact.

    Those held; and of an interface that leaves, those that would rise by no more than the half face
    times `rest_rotation`.

    Args:
        blocks: The blocks.
        limits: The lane's limits.
        t: The step.
        g: The Jacobian at its end.
        touch: Ends that touched in the impact.
        hold: Ends held after it.
        v: Velocities after it.
    """
    ends = hold
    gravity = limits.gravity
    if VERTICAL:
        gravity = t.weight.end
    for k in range(BLOCKS):
        if hold[k] == OPEN and touch[k] != OPEN:
            u = relative_velocity(g, v, k)
            rise = TWO * gravity * limits.rest_rotation[k] * blocks.half_width[k]
            for end in range(2):
                code = wp.where(end == 0, PLUS, MINUS)
                if (touch[k] & code) != 0 and u[1 + end] * u[1 + end] <= rise:
                    ends[k] = ends[k] + code
    return ends


@wp.func
def mode_of(blocks: wp.ref[Blocks], s: wp.ref[State], near: real) -> int:
    """Mode of a lane at the end of a step; its end may be early by the time `near` [s]."""
    mode = int(RUNNING)
    for k in range(BLOCKS):
        if CHAINS:
            mode = wp.where(has_left(blocks, s.pose, k), SLID_OFF, mode)
        elif not s.stuck:
            low, _height = lower_face(blocks, k)
            room = low + blocks.half_width[k] - near * size(s.rate[3 * k])
            if size(slide_place(blocks, s.pose, k)) >= room:
                mode = SLID_OFF
    for k in range(BLOCKS):
        if size(s.pose.theta[k]) >= HALF_PI - near * size(s.swing[k]):
            mode = OVERTURNED
        if CHAINS:
            upright = size(turn_of(s.pose, k) + s.pose.foot[k]) < HALF_PI
            mode = wp.where(upright, mode, OVERTURNED)
    return sound_mode(s, mode)


@wp.func
def sound_mode(s: wp.ref[State], running: int) -> int:
    """A mode, or BROKEN if the state is not finite."""
    mode = int(running)
    for k in range(BLOCKS):
        v = three_of(s.velocity, k)
        sound = s.pose.theta[k] + s.pose.along[k] + s.pose.above[k] + v[0] + v[1] + v[2] + s.time
        mode = wp.where(sound - sound == real(0.0), mode, BROKEN)
    return mode


@wp.func
def guess_held(before: Counts, touch: Counts) -> Counts:
    """Ends likely to be held in an impact: of a block that falls flat, those that land."""
    ends = touch
    for k in range(BLOCKS):
        if touch[k] == CLOSED and before[k] != OPEN and before[k] != CLOSED:
            ends[k] = CLOSED - before[k]
    return ends


@wp.func
def kick_base(t: wp.ref[Trial], velocity: Triples) -> Triples:
    """Velocities as seen from the base after its velocity steps at the end of a trial step."""
    v = velocity
    for k in range(BLOCKS):
        v[3 * k] = v[3 * k] - t.kick
    if VERTICAL:
        v = as_base_rises(v, t.weight.kick)
    return v


@wp.func
def take_step(s: wp.ref[State], t: wp.ref[Trial], n: wp.ref[State]):
    """Sets the clock, the base and the search of a state that the step t from s has reached."""
    n.time = t.time
    n.segment = t.segment
    n.base = s.base + t.dv + t.kick
    n.cap = NEVER
    n.taken = True
    n.chain.known = False
    n.stuck = t.rocks
    n.search.stage = wp.where(t.spends, FOUND, STEADY)
    n.calm = (
        at_rest(s.pose.touch, s.slip) and at_rest(n.pose.touch, n.slip)
        and t.dv == real(0.0) and t.kick == real(0.0)
    )  # fmt: skip
    if VERTICAL:
        n.rising = s.rising + t.weight.gained + t.weight.kick
        n.risen = s.risen + wp.where(t.weight.passed, 1, 0)
        n.calm = n.calm and t.weight.gained == real(0.0) and t.weight.kick == real(0.0)


@wp.func
def round_off(limits: wp.ref[Limits], velocity: Triples) -> RoundOff:
    """What counts as round-off in an impact at given velocities."""
    speed, _spin = largest_speeds(velocity)
    grain = DUST * (speed + limits.gravity * limits.longest_step)
    return RoundOff(grain, grain * limits.mass)


@wp.func
def collide(
    blocks: wp.ref[Blocks], limits: wp.ref[Limits], t: wp.ref[Trial], g: wp.ref[Jacobian],
    free: wp.ref[Triples], found: wp.ref[Solution],
):  # fmt: skip
    """Finds the impact at the end of a step.

    Args:
        blocks: The blocks.
        limits: The lane's limits.
        t: The step.
        g: The Jacobian at its end.
        free: Velocities without contact.
        found: The impact; with ends that touch then, and directions of sliding before it.
    """
    if t.struck:
        dust = round_off(limits, free)
        touch = found.contacts.hold
        found.contacts.hold = guess_held(t.pose.touch, touch)
        if BOUNCES:
            bounce(blocks, g, limits.rebound, touch, free, dust, found)
        else:
            solve(blocks, g, touch, Counts(), free, dust, Triples(), found)
    else:
        # An end that closes without an impact has no friction, so that it adds no energy.
        smooth = blocks
        smooth.friction = Values()
        found.solved = True
        found.velocity = free
        constrain(smooth, g, found.contacts, found.velocity)


@wp.func
def conclude(blocks: wp.ref[Blocks], limits: wp.ref[Limits], n: wp.ref[State]):
    """Sets the mode of a state that a step has reached, and keeps its rotations in range."""
    n.mode = mode_of(blocks, n, NEARLY * limits.longest_step)
    for k in range(BLOCKS):
        n.pose.theta[k] = larger(smaller(n.pose.theta[k], HALF_PI), -HALF_PI)


@wp.func
def stick_on(
    blocks: wp.ref[Blocks], limits: wp.ref[Limits], s: wp.ref[State], t: wp.ref[Trial],
    n: wp.ref[State],
):  # fmt: skip
    """Ends a step with the velocities of a stack that goes on to stick at all its contacts."""
    n.slip = Counts()
    n.rate = Triples()
    n.lost = s.lost + lost_in_impact(blocks, t, t.velocity, n.velocity)
    take_step(s, t, n)
    n.chain.known = True
    conclude(blocks, limits, n)


@wp.func
def strikes_chain(
    blocks: wp.ref[Blocks], limits: wp.ref[Limits], t: wp.ref[Trial], n: wp.ref[State]
) -> bool:  # fmt: skip
    """Whether a step ends with an impact of a stack that sticks before and after; see `strike`."""
    ramps = t.kick != real(0.0)
    if VERTICAL:
        ramps = kicks(t.weight, t.kick)
    found = t.rocks and t.struck and not ramps
    if BOUNCES:
        found = False
    if found:
        guess = guess_held(t.pose.touch, n.pose.touch)
        found = strike(blocks, t, guess, round_off(limits, t.velocity), n)
    return found


@wp.func
def project(
    blocks: wp.ref[Blocks], limits: wp.ref[Limits], s: wp.ref[State], t: wp.ref[Trial],
    g: wp.ref[Jacobian], n: wp.ref[State],
):  # fmt: skip
    """Projects velocities at the end of a step that is taken, impacts included.

    Args:
        blocks: The blocks.
        limits: The lane's limits.
        s: State before the step.
        t: The step.
        g: Jacobian at its end.
        n: State with the pose and the directions of sliding at its end; what the step has reached
            after it.
    """
    v = t.velocity
    if not t.rocks:
        before = Contacts(t.pose.touch, n.slip)
        constrain(blocks, g, before, v)
    impact = Solution()
    impact.contacts = Contacts(n.pose.touch, n.slip)
    impact.solved = True
    impact.ramps = t.kick != real(0.0)
    if VERTICAL:
        impact.ramps = kicks(t.weight, t.kick)
    if t.struck or t.resting:
        free = kick_base(t, v)
        collide(blocks, limits, t, g, free, impact)
        v = impact.velocity
        n.lost = s.lost + lost_in_impact(blocks, t, free, v)
    n.pose.touch = keep_touching(blocks, limits, t, g, n.pose.touch, impact.contacts.hold, v)
    for k in range(BLOCKS):
        n.slip[k] = wp.where(n.pose.touch[k] == OPEN, 0, impact.contacts.slip[k])
    n.velocity = glue(blocks, n.pose, n.slip, v)
    for k in range(BLOCKS):
        u = relative_velocity(g, n.velocity, k)
        for i in range(3):
            n.rate[3 * k + i] = u[i]
    n.lost = n.lost + t.lost
    take_step(s, t, n)
    conclude(blocks, limits, n)
    if n.mode != BROKEN and not (impact.solved and t.settled):
        n.mode = UNSOLVED


@wp.func
def cut_short(limits: wp.ref[Limits], t: wp.ref[Trial], cut: real, n: wp.ref[State]):
    """Makes the next step from n end at the first event inside this one, after `cut` [s]."""
    # Not shorter than `near`: with less than that left to go, the event is reached. An event at
    # the very end of the step would be met there for ever.
    near = NEARLY * limits.longest_step
    n.cap = larger(wp.where(cut > t.d - near, HALF * t.d, cut), HALF * near)
    n.mode = wp.where(t.settled, n.mode, UNSOLVED)


@wp.func
def end_step(
    blocks: wp.ref[Blocks], limits: wp.ref[Limits], s: wp.ref[State], t: wp.ref[Trial],
    n: wp.ref[State],
):  # fmt: skip
    """Ends a trial step with its impacts, unless an event lies inside; arguments as below."""
    falls = t.falls
    hits = int(0)
    for k in range(BLOCKS):
        if falls[k] != OPEN and t.struck:
            hits += 1
        elif t.struck and t.pose.touch[k] != OPEN and t.pose.touch[k] != CLOSED:
            other = opening(t.pose, t.velocity, k, t.pose.touch[k])
            falls[k] = wp.where(other.angle <= TOUCHING, CLOSED, OPEN)
    pose, g = Pose(), Jacobian()
    slip = t.slip
    lay_down(blocks, t.pose, falls, pose)
    cut = t.cut
    if not t.rocks:
        fill_jacobian(blocks, pose, g)
        for k in range(BLOCKS):
            u = relative_velocity(g, t.velocity, k)
            stop, after = find_stop(s, t, k, u[0], NEARLY * limits.longest_step)
            cut = smaller(cut, stop)
            if not CHAINS:
                leaves = find_departure(blocks, s, t, k, NEARLY * limits.longest_step)
                cut = smaller(cut, leaves)
            slip[k] = after
    if cut < NEVER:
        cut_short(limits, t, cut, n)
    else:
        n.pose = pose
        n.slip = slip
        n.curve = t.curve
        for k in range(BLOCKS):
            n.swing[k] = t.velocity[3 * k + 2]
        n.impacts = s.impacts + hits
        n.deepest = larger(t.deep, s.deepest)
        if t.resting and t.rocks:
            link(blocks, n.pose, n.pose.touch, n.chain)
            n.velocity = hold_together(blocks, n.chain, t.velocity)
            stick_on(blocks, limits, s, t, n)
        elif strikes_chain(blocks, limits, t, n):
            stick_on(blocks, limits, s, t, n)
        else:
            if t.rocks:
                fill_jacobian(blocks, pose, g)
            project(blocks, limits, s, t, g, n)


@wp.func
def rock_on(s: wp.ref[State], t: wp.ref[Trial], n: wp.ref[State]):
    """Ends a step without events of a stack that sticks at all its contacts."""
    n.pose = t.pose
    n.velocity = t.velocity
    n.rate = Triples()
    n.slip = Counts()
    n.curve = t.curve
    for k in range(BLOCKS):
        n.swing[k] = t.velocity[3 * k + 2]
    take_step(s, t, n)
    n.mode = sound_mode(n, RUNNING)


@wp.func(inline=False)
def meet_events(
    blocks: wp.ref[Blocks], limits: wp.ref[Limits], s: wp.ref[State], t: wp.ref[Trial],
    n: wp.ref[State],
):  # fmt: skip
    """Ends a trial step, or sets the event that is searched for or at which the next one ends."""
    n.taken = False
    if not t.resting:
        search_switch(limits, s, t, n)
    if n.search.stage == s.search.stage:
        end_step(blocks, limits, s, t, n)


@wp.func
def finish_step(
    blocks: wp.ref[Blocks], limits: wp.ref[Limits], s: wp.ref[State], t: wp.ref[Trial],
    n: wp.ref[State],
):  # fmt: skip
    """Ends a trial step; changes of the state only `cap`, `search` and `mode` if it is not taken.

    Args:
        blocks: The blocks.
        limits: The lane's limits.
        s: State before the step.
        t: The step.
        n: The same state; that after the step afterwards.
    """
    if t.plain:
        rock_on(s, t, n)
    else:
        meet_events(blocks, limits, s, t, n)
