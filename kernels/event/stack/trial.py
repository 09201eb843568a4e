"""One trial step of a stack of blocks, before it is taken; see step.py for the scheme."""

import warp as wp

from warprock.kernels.event.block.begin import base_change, first_root
from warprock.kernels.event.body.weight import Weight, kicks, weight_in
from warprock.kernels.event.stack.chain import Contacts, relative_velocity
from warprock.kernels.event.stack.contact import RoundOff, Solution, solve
from warprock.kernels.event.stack.curves import rate_of
from warprock.kernels.event.stack.links import link, velocities_after
from warprock.kernels.event.stack.moves import find_closing, find_landing, move, opening, settles
from warprock.kernels.event.stack.rest import look_ahead
from warprock.kernels.event.stack.rocking import Rocking, Terms, predict_rocking
from warprock.kernels.event.stack.rocking_end import LACKS, SPENT, find_end
from warprock.kernels.motion.kinds import expand, knot_step, knot_time
from warprock.kernels.shape.above import Above
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
)

if CHAINS:
    from warprock.kernels.event.stack.edges import find_next_edge

from warprock.kernels.event.stack.state import (
    DUST,
    NEARLY,
    REACH,
    SEEKING,
    SLOWEST,
    STEADY,
    STILL,
    Limits,
    Shaking,
    State,
    Trial,
    as_base_rises,
    at_rest,
    largest_speeds,
    still_curve,
)

if CHAINS:

    @wp.func
    def find_next_edges(
        blocks: wp.ref[Blocks], limits: wp.ref[Limits], s: wp.ref[State], t: wp.ref[Trial]
    ):  # fmt: skip
        """Adds to a trial step the edges that its blocks come to, see event/stack/edges.py."""
        for k in range(BLOCKS):
            cut, way, lands, leaves = find_next_edge(blocks, limits, s, t, k)
            t.cut = smaller(t.cut, cut)
            if leaves:
                t.falls[k] = OPEN
            if t.falls[k] == OPEN:
                t.way[k] = way
                if lands:
                    t.falls[k] = CLOSED
                    t.struck = True


@wp.func
def close_at_start(s: wp.ref[State], rests: Counts, t: wp.ref[Trial]):
    """Makes a trial one of no length, in which interfaces close at the start of the step."""
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
    t.switches = False
    t.spends = False
    t.curve = still_curve(s)
    t.deep = real(0.0)
    if VERTICAL:
        t.weight = Weight()


@wp.func(inline=False)
def find_events(blocks: wp.ref[Blocks], limits: wp.ref[Limits], s: wp.ref[State], t: wp.ref[Trial]):
    """Adds to a trial step the events at its interfaces and the overturning of its blocks."""
    near = NEARLY * limits.longest_step
    rests = Counts()
    for k in range(BLOCKS):
        touch = t.pose.touch[k]
        if touch == OPEN:
            cut, lands, lowest = find_landing(blocks, limits, s, t, k)
            t.cut = smaller(t.cut, cut)
            t.falls[k] = lands
            t.deep = larger(-lowest, t.deep)
            t.struck = t.struck or lands != OPEN
        elif touch != CLOSED:
            start = opening(s.pose, s.velocity, k, touch)
            end = opening(t.pose, t.velocity, k, touch)
            cut, falls = find_closing(start, end, t.d, near)
            t.cut = smaller(t.cut, cut)
            pivots_since_impact = s.pose.touch[k] != CLOSED
            if cut < NEVER and pivots_since_impact and not t.rocks:
                bend = (end.angle - start.angle - start.rate * t.d) / (t.d * t.d)
                if settles(start, bend, limits.rest_rotation[k]):
                    t.resting = True
                    rests[k] = CLOSED
            t.falls[k] = wp.where(falls, CLOSED, OPEN)
            t.struck = t.struck or falls
            # A block that has turned past the lower face is deepest at the end that was open.
            low, _height = lower_face(blocks, k)
            t.deep = larger(-TWO * smaller(low, blocks.half_width[k]) * sine(end.angle), t.deep)
        side = wp.where(t.pose.theta[k] < real(0.0), real(-1.0), real(1.0))
        left = HALF_PI - side * t.pose.theta[k]
        if left < -near * size(t.velocity[3 * k + 2]) and t.d > near:
            left0 = HALF_PI - side * s.pose.theta[k]
            t.cut = smaller(t.cut, first_root(left0, -side * s.velocity[3 * k + 2], left, t.d))
    if CHAINS:
        find_next_edges(blocks, limits, s, t)
    if t.resting:
        close_at_start(s, rests, t)


@wp.func(inline=False)
def move_base(
    limits: wp.ref[Limits], shaking: wp.ref[Shaking], target: real, s: wp.ref[State], d: real,
    t: wp.ref[Trial],
):  # fmt: skip
    """Sets a trial's length d [s], at most to a time `target` [s], and the base's motion in it."""
    t.cut = NEVER
    room = larger(target - s.time, real(0.0))
    t.d = d
    t.time = wp.where(d >= room, target, s.time + d)
    m = shaking.motion
    passed = t.time >= knot_time(m, s.segment)
    t.segment = s.segment + wp.where(passed, 1, 0)
    t.kick = wp.where(passed, knot_step(m, s.segment), real(0.0))
    a = expand(m, s.segment, t.time, shaking.value, shaking.slope)
    t.dv = base_change(m, t.time, d, a.a0, a.a1, s.base, t.kick)
    t.struck = t.kick != real(0.0)
    if VERTICAL:
        t.weight = weight_in(limits.gravity, shaking.above, t.time, d, s.rising)
        t.struck = kicks(t.weight, t.kick)


@wp.func
def sticks(touch: Counts, slip: Counts) -> bool:
    """Whether an end touches at every interface, and none slides."""
    found = bool(True)
    for k in range(BLOCKS):
        found = found and touch[k] != OPEN and slip[k] == 0
    return found


@wp.func
def stays_put(touch: Counts, rate: Triples, grain: real) -> bool:
    """Whether no end that touches moves against what it touches, but for `grain` [m/s].

    One that an impact has let go so slowly that it counts as touching may move.
    """
    found = bool(True)
    for k in range(BLOCKS):
        along = size(rate[3 * k])
        plus = wp.where((touch[k] & PLUS) != 0, size(rate[3 * k + 1]), real(0.0))
        minus = wp.where((touch[k] & MINUS) != 0, size(rate[3 * k + 2]), real(0.0))
        found = found and larger(along, larger(plus, minus)) <= grain
    return found


@wp.func(inline=False)
def try_rocking(
    blocks: wp.ref[Blocks], limits: wp.ref[Limits], shaking: wp.ref[Shaking], target: real,
    s: wp.ref[State], touch: Counts, d: real, t: wp.ref[Trial],
):  # fmt: skip
    """Makes a trial one of at most a length d [s] in which all ends that touch stick.

    If they do not, it stays as it is. If an interface rests at once, it closes at the start.
    """
    a = expand(shaking.motion, s.segment, s.time, shaking.value, shaking.slope)
    along = Terms(a.a0, a.a1, a.a2, a.a3, a.a4)
    up = Terms()
    if VERTICAL:
        above = shaking.above
        z = expand(above.motion, above.segment, s.time, above.value, above.slope)
        up = Terms(z.a0, z.a1, z.a2, z.a3, z.a4)
    up[0] = up[0] + limits.gravity
    if not s.chain.known:
        link(blocks, s.pose, touch, s.chain)
    r = Rocking()
    predict_rocking(blocks, limits, s.pose, s.chain, s.velocity, along, up, r)
    if r.waits:
        t.resting = True
        t.rocks = True
        t.settled = True
        close_at_start(s, r.rests, t)
        return
    pose = Pose()
    d1, found, lands = find_end(blocks, limits, s.pose, s.chain, r, smaller(d, r.reach), pose)
    if found == LACKS:
        return
    move_base(limits, shaking, target, s, d1, t)
    t.slip = Counts()
    t.lost = real(0.0)
    t.switches = False
    t.rocks = True
    t.spends = found == SPENT
    t.curve = r.theta
    t.pose = pose
    spins = Values()
    for k in range(BLOCKS):
        spins[k] = rate_of(r.theta[k], d1)
    t.velocity = velocities_after(s.chain, s.pose, t.pose, spins)
    t.plain = not lands and not t.struck
    if CHAINS:
        # A body may come to its next edge.
        t.plain = False
    for k in range(BLOCKS):
        left = HALF_PI - size(t.pose.theta[k])
        t.plain = t.plain and left > NEARLY * limits.longest_step * size(t.velocity[3 * k + 2])
    t.settled = True


@wp.func
def rest(s: wp.ref[State], t: wp.ref[Trial]):
    """Makes a trial one in which a stack at rest stays there."""
    t.pose = s.pose
    t.velocity = s.velocity
    t.curve = still_curve(s)
    t.rocks = True
    t.settled = True
    t.switches = False
    t.plain = not t.struck


@wp.func
def still_upwards(above: Above) -> bool:
    """Whether the base has not begun to move upwards, or has ended."""
    return above.segment == 0 or knot_time(above.motion, above.segment) >= NEVER


@wp.func
def try_step(
    blocks: wp.ref[Blocks], limits: wp.ref[Limits], shaking: wp.ref[Shaking], end: real,
    s: wp.ref[State], t: wp.ref[Trial],
):  # fmt: skip
    """Makes an empty trial one step, at most to the next knot of the motion or to `end`."""
    knot = knot_time(shaking.motion, s.segment)
    target = smaller(knot, end)
    calm = s.calm and (s.segment == 0 or knot >= NEVER)
    if VERTICAL:
        above = shaking.above
        target = smaller(knot_time(above.motion, above.segment), target)
        calm = calm and still_upwards(above)
    room = larger(target - s.time, real(0.0))
    speed, spin = largest_speeds(s.velocity)
    longest = smaller(smaller(limits.longest_step, REACH / (spin + SLOWEST)), s.cap)
    if calm:
        longest = room
    d = smaller(longest, room)
    grain = STILL * (speed + limits.gravity * limits.longest_step)
    stuck = sticks(s.pose.touch, s.slip) and stays_put(s.pose.touch, s.rate, grain)
    rests = at_rest(s.pose.touch, s.slip)
    held = bool(False)
    if rests:
        held, d = look_ahead(blocks, limits, shaking, s, d)
    if stuck and not rests and s.search.stage == STEADY:
        try_rocking(blocks, limits, shaking, target, s, s.pose.touch, d, t)
    if not t.rocks:
        move_base(limits, shaking, target, s, d, t)
        if not held:
            try_sliding(blocks, limits, s, speed, t)
            held = rests and at_rest(t.pose.touch, t.slip)
        if held:
            rest(s, t)
        else:
            # If the force is lacking from the start there is no moment to search for.
            t.switches = t.switches and not (stuck and s.search.stage == STEADY)
            if stuck and s.search.stage != SEEKING and sticks(t.pose.touch, t.slip):
                # Its chain is not that of the ends that touch in the state.
                s.chain.known = False
                try_rocking(blocks, limits, shaking, target, s, t.pose.touch, d, t)
                s.chain.known = False
    if not (t.plain or t.resting):
        find_events(blocks, limits, s, t)


@wp.func(inline=False)
def try_sliding(
    blocks: wp.ref[Blocks], limits: wp.ref[Limits], s: wp.ref[State], speed: real, t: wp.ref[Trial]
):  # fmt: skip
    """Makes a trial one by the mean velocity that obeys the contact law in its middle.

    Args:
        blocks: The blocks.
        limits: The lane's limits.
        s: State before it.
        speed: Largest velocity of a block [m/s].
        t: The trial with the motion of the base.
    """
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
        free = as_base_rises(free, HALF * t.weight.gained)
    middle, g, mean = Pose(), Jacobian(), Solution()
    move(blocks, s.pose, s.pose.touch, s.velocity, slide, HALF * d, middle)
    fill_jacobian(blocks, middle, g)
    grain = DUST * (speed + limits.gravity * limits.longest_step)
    touch = s.pose.touch
    dust = RoundOff(grain, grain * limits.mass)
    mean.contacts = Contacts(touch, s.slip)
    solve(blocks, g, touch, glide, free, dust, Triples(), mean)
    hold = mean.contacts.hold
    t.slip = mean.contacts.slip
    t.settled = mean.solved
    t.switches = not mean.guessed
    t.spare = mean.spare / larger(d, SLOWEST)
    t.curve = still_curve(s)
    for k in range(BLOCKS):
        slide[k] = real(0.0)
        if t.slip[k] != 0 and hold[k] != OPEN:
            u = relative_velocity(g, mean.velocity, k)
            slide[k] = u[0]
            t.lost = t.lost - TWO * u[0] * mean.impulse[3 * k]
        t.slip[k] = wp.where(hold[k] == OPEN, 0, t.slip[k])
    move(blocks, s.pose, hold, mean.velocity, slide, d, t.pose)
    for k in range(BLOCKS):
        bend = t.pose.theta[k] - s.pose.theta[k] - d * s.velocity[3 * k + 2]
        t.curve[k, 2] = wp.where(d > real(0.0), bend / (d * d), real(0.0))
    t.velocity = TWO * mean.velocity - s.velocity
