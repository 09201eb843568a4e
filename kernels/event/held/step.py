"""A block that ties, a load and a wall hold, with sliding: steps of Taylor series between events.

A step follows the polynomials of event/held/path.py and ends at the first event
(event/held/events.py), at a knot of the motion, or where it would be too long. Then

    1. where a point comes down on base or wall, or the velocity of the base steps, the velocities
       after the impact follow from the contact law (event/held/contact.py): the base is plastic, a
       wall throws a point back with the part `rebound` of its speed;
    2. which points press and whether the corner at the base sticks follows from the accelerations,
       by the same law.

Whatever follows an event is seen from the side to which the block leans, or turns, or is pushed: so
the mirror image of a lane has the same bits.

Rest rule: after an impact on its other corner the block rests if its next swing would stay below
`rest_rotation` on either side, as it then slides or sticks (event/block/step.py). A point that the
wall throws back stays if it would come back from no farther than such a swing takes the top. What
the impacts that are left out would take is added to the rest time.

Where a corner slides so that no forces obey the law (Painleve 1895), it jams: an impact without a
fall brings it to rest.
"""

import warp as wp

from warprock.kernels.contact.ties import BROKEN_TIE, force_of
from warprock.kernels.event.held.contact import (
    EPS,
    Ask,
    Choice,
    Four,
    Vector,
    choose,
)
from warprock.kernels.event.held.events import (
    AT_ZERO,
    CHANGES,
    FALLS,
    LETS_GO,
    OPENS,
    STARTS,
    STOPS,
    TOUCHES,
    change_tie,
    find_event,
    let_go,
    start_tie,
)
from warprock.kernels.event.held.path import (
    Held,
    Path,
    Pull,
    expand_path,
    force_series,
    free_rates,
    pull_of,
    slip_series,
    stretch_of,
    stretch_series,
    tie_of,
)
from warprock.kernels.event.held.state import (
    ALL,
    BASE,
    FACE,
    LEFT,
    LOW,
    RIGHT,
    Block,
    Point,
    Seen,
    State,
    has_point,
    mirror_block,
    mirror_state,
    normal_gap,
    normal_rate,
    point_of,
    slide_of,
    turn_point,
)
from warprock.kernels.lane.modes import BROKEN, FLAT, FLYING, OVERTURNED, PIVOTING, UNSOLVED
from warprock.kernels.motion.kinds import Ground, Motion, knot_step, knot_time
from warprock.kernels.motion.series import (
    DEGREE,
    TICK,
    Series,
    pull_series,
    root_of,
    slope_of,
    value_of,
)

REACH = real(0.25)
"""Largest rotation of the block in one step [rad]."""
AT_ONCE = by_precision(1.0e-9, 1.0e-5)
"""Part of a step that is none: an event so soon is at its start."""
TOUCHING = by_precision(1.0e-12, 1.0e-5)
"""Gap over the size of the block up to which a point touches where an event has ended a step."""


@wp.struct
class Base:
    """What the base does at the end of a step: acceleration [m/s^2], step of its velocity [m/s]."""

    a: real
    kick: real


@wp.func
def touching_points(block: Block, s: State) -> int:
    """Points that touch base or wall, as a sum of their bits."""
    points = int(s.closed)
    near = TOUCHING * (block.half_height + block.half_width)
    for k in range(4):
        there = k < 2 or block.wall != real(0.0)
        if there and not has_point(points, k) and normal_gap(block, k, s) <= near:
            points = points + (1 << k)
    return points


@wp.func
def put_back(block: Block, s: wp.ref[State], points: int):
    """Removes the round-off from a block that lies flat, and from one whose face is on its wall."""
    if (points & BASE) == BASE:
        s.theta = real(0.0)
        s.z = block.half_height
        if (points & FACE) == FACE:
            s.x = real(0.0)


@wp.func
def ask_rates(block: Block, pull: Pull, s: State, near: int, a: real) -> Ask:
    """What the contacts of a block have to bring about at an acceleration a of the base."""
    rates = free_rates(block, pull, s, a)
    sin, cos = sine(s.theta), cosine(s.theta)
    return Ask(rates, s.omega * s.omega, Four(), near, s.slip, 0, sin, cos)


@wp.func
def ask_velocities(s: State, near: int, back: Four) -> Ask:
    """What the contacts of a block have to bring about in an impact.

    `back` are the speeds at which the wall throws points back [m/s].
    """
    sin, cos = sine(s.theta), cosine(s.theta)
    rates = Vector(s.vx, s.vz, s.omega)
    return Ask(rates, real(0.0), back, near, real(0.0), 1, sin, cos)


@wp.func
def speed_slack(block: Block, s: State) -> real:
    """Round-off of the velocities of a block [m/s]."""
    reach = block.half_height + block.half_width
    least = AT_ZERO * wp.sqrt(block.gravity * reach)
    return EPS * (size(s.vx) + size(s.vz) + reach * size(s.omega)) + least


@wp.func
def energy_of(block: Block, s: State) -> real:
    """Kinetic energy of a block [J]."""
    moves = block.mass * (s.vx * s.vx + s.vz * s.vz)
    return HALF * (moves + block.inertia * s.omega * s.omega)


@wp.func
def lower_of(points: int) -> int:
    """Number of the base corner whose sliding counts: 1, that of the lean, if it presses."""
    corner = int(0)
    if (points & RIGHT) > 0:
        corner = int(1)
    return corner


@wp.func
def apply_velocities(block: Block, choice: Choice, points: int, slack: real, s: wp.ref[State]):
    """Takes the velocities of an impact, and finds out what touches and what slides after it."""
    s.vx = choice.rate[0]
    s.vz = choice.rate[1]
    s.omega = choice.rate[2]
    near = int(0)
    for k in range(4):
        if has_point(points, k) and normal_rate(block, k, s) <= slack:
            near = near + (1 << k)
    s.slip = real(0.0)
    if choice.holds == 0 and (near & BASE) > 0:
        at = turn_point(point_of(block, lower_of(near)), sine(s.theta), cosine(s.theta))
        along = s.vx + s.omega * at.z
        if size(along) > slack:
            s.slip = sign_of(along)
    s.near = near
    s.closed = near
    s.fresh = 1


@wp.func
def comes_back(block: Block, pull: Pull, s: State, points: int, a: real) -> Point:
    """Of a point that the wall has thrown back: its speed, and how it is pulled to the wall again.

    The largest speed over all such points; zero if none comes back at once.
    """
    zero = real(0.0)
    found = Point(zero, zero)
    near = s.near & BASE
    choice = choose(block, ask_rates(block, pull, s, near, a))
    for k in range(2, 4):
        speed = normal_rate(block, k, s)
        at = turn_point(point_of(block, k), sine(s.theta), cosine(s.theta))
        pulled = choice.rate[0] + choice.rate[2] * at.z - s.omega * s.omega * at.x
        pulled = block.wall * pulled
        if has_point(points, k) and speed > found.x:
            found = Point(speed, pulled)
    return found


@wp.func
def flat_acceleration(block: Block, pull: Pull, s: State, side: int, a: real) -> real:
    """Angular acceleration that keeps a flat block from turning about the corner of a side."""
    ask = ask_rates(block, pull, s, side, a)
    ask.curve = real(0.0)
    choice = choose(block, ask)
    down = -choice.rate[2]
    if side == LEFT:
        down = choice.rate[2]
    return down


@wp.func
def settle(block: Block, pull: Pull, a: real, before: real, s: wp.ref[State]):
    """Lays down a flat block whose next swing is too small to count.

    Args:
        block: The block.
        pull: Ties and load.
        a: Acceleration of the base [m/s^2].
        before: Size of its angular velocity before the impact [rad/s].
        s: The block, which has just struck its base.
    """
    zero = real(0.0)
    after = size(s.omega)
    there = flat_acceleration(block, pull, s, LEFT, a)
    here = flat_acceleration(block, pull, s, RIGHT, a)
    weaker = smaller(here, there)
    if weaker > zero and after * after <= TWO * weaker * block.rest_rotation:
        kept = after / larger(before, after)
        if s.omega < zero:
            other = here
            here = there
            there = other
        lost = larger(real(1.0) - kept * kept, real(1.0e-6))
        s.tail = TWO * after * (real(1.0) / here + kept / there) / lost
        s.omega = zero
        s.vz = zero
        if s.slip == zero:
            s.vx = zero
        else:
            s.slip = sign_of(s.vx)
        s.near = BASE
        s.closed = BASE


@wp.func
def strike(
    block: Block, pull: Pull, base: Base, points: int, s: wp.ref[State], seen: wp.ref[Seen]
):  # fmt: skip
    """An impact of points that touch, or a step of the velocity of the base."""
    zero = real(0.0)
    s.vx = s.vx - base.kick
    before = energy_of(block, s)
    kicked, spin = real(s.vx), size(s.omega)
    slack = speed_slack(block, s)
    back = Four()
    hit = bool(False)
    bounces = bool(False)
    for k in range(4):
        rate = normal_rate(block, k, s)
        if has_point(points, k) and rate < -slack:
            hit = hit or not has_point(s.closed, k)
            if k > 1 and block.rebound > zero:
                back[k] = -block.rebound * rate
                bounces = True
    ask = ask_velocities(s, points, back)
    choice = choose(block, ask)
    if choice.found == 0:
        s.mode = UNSOLVED
    apply_velocities(block, choice, points, slack, s)
    if bounces:
        thrown = comes_back(block, pull, s, points, base.a)
        swing = TWO * block.half_height * block.rest_rotation
        if thrown.z > zero and thrown.x * thrown.x <= TWO * thrown.z * swing:
            s.tail = TWO * thrown.x / thrown.z / larger(real(1.0) - block.rebound, real(1.0e-6))
            ask.back = Four()
            choice = choose(block, ask)
            apply_velocities(block, choice, points, slack, s)
    lands = hit and (points & BASE) == BASE and (points & FACE) == 0
    if lands and s.omega != zero:
        settle(block, pull, base.a, spin, s)
    if hit:
        seen.impacts = seen.impacts + 1
    seen.loss = seen.loss + before - energy_of(block, s)
    seen.loss = seen.loss + HALF * block.mass * base.kick * (kicked - s.vx)


@wp.func
def decide(block: Block, pull: Pull, a: real, s: wp.ref[State], seen: wp.ref[Seen]):
    """Which points press from now on, and whether the corner at the base sticks."""
    zero = real(0.0)
    lay = (s.closed & BASE) == BASE and s.mode == FLAT
    rested = s.still > 0
    choice = choose(block, ask_rates(block, pull, s, s.near, a))
    if choice.found == 0 and s.slip != zero:
        jammed = choose(block, ask_velocities(s, s.near, Four()))
        if jammed.found > 0:
            before = energy_of(block, s)
            slack = speed_slack(block, s)
            points = int(s.near)
            apply_velocities(block, jammed, points, slack, s)
            seen.loss = seen.loss + before - energy_of(block, s)
            choice = choose(block, ask_rates(block, pull, s, s.near, a))
    if choice.found == 0:
        s.mode = UNSOLVED
    s.closed = choice.points
    s.parts = s.near - choice.points + (s.parts & (ALL - s.near))
    s.near = choice.points
    s.slip = choice.slip
    if (choice.points & BASE) == 0:
        s.slip = zero
    s.mode = FLYING
    count = int(choice.holds)
    for k in range(4):
        if has_point(choice.points, k):
            count = count + 1
    if (choice.points & BASE) > 0:
        s.mode = PIVOTING
    if (choice.points & BASE) == BASE:
        s.mode = FLAT
        s.omega = zero
        s.vz = zero
    if choice.found == 0:
        s.mode = UNSOLVED
    s.still = 0
    if count >= 3 and (choice.holds > 0):
        s.still = 1
        s.vx = zero
        s.vz = zero
        s.omega = zero
    s.fresh = 0
    if s.still > 0 and not rested:
        seen.rest_time = s.time + s.tail
    if s.still == 0:
        seen.rest_time = NEVER
    s.tail = zero
    if lay and s.mode != FLAT:
        seen.uplift_time = smaller(seen.uplift_time, s.time)


@wp.func
def side_seen(block: Block, pull: Pull, s: State, a: Series) -> real:
    """The side from which a lane is seen: that of the first number of it that has a side."""
    found = real(s.theta)
    if found == real(0.0):
        found = s.omega
    if found == real(0.0):
        found = s.vx
    if found == real(0.0):
        found = free_rates(block, pull, s, a[0])[0]
    if found == real(0.0):
        found = -a[1]
    if found == real(0.0):
        found = block.wall
    return sign_of(found)


@wp.func
def friction_loss(block: Block, s: State, path: Path, tau: real) -> real:
    """Energy that friction takes in a step of a length tau [J]."""
    lost = real(0.0)
    if s.slip != real(0.0) and (s.closed & BASE) > 0:
        carried = force_series(path, 0)
        if (s.closed & BASE) == BASE:
            carried = carried + force_series(path, 1)
        along = s.slip * slip_series(path, point_of(block, lower_of(s.closed)))
        power = Series()
        for n in range(DEGREE):
            for j in range(n + 1):
                power[n + 1] = power[n + 1] + carried[j] * along[n - j] / real(n + 1)
        lost = block.friction * value_of(power, tau)
    return lost


@wp.func
def observe_ties(block: Block, held: Held, s: State, path: Path, tau: real, seen: wp.ref[Seen]):
    """Sees the forces and elongations of the ties in a step of a length tau, and at its end."""
    for i in range(held.ties.shape[0]):
        tie = tie_of(held, i)
        state = held.states[i, held.lane]
        stretch = stretch_series(block, tie, path)
        slope = slope_of(stretch)
        if slope[0] * value_of(slope, tau) < real(0.0):
            # The largest one, or the least.
            turn = value_of(stretch, root_of(sign_of(slope[0]) * slope, tau))
            seen.stretch = larger(turn, seen.stretch)
            seen.force = larger(size(force_of(tie, state, turn)), seen.force)
        reached = stretch_of(block, tie, s)
        seen.stretch = larger(reached, seen.stretch)
        seen.force = larger(size(force_of(tie, state, reached)), seen.force)


@wp.func
def observe_rotation(block: Block, s: State, path: Path, tau: real, seen: wp.ref[Seen]):
    """Sees the largest rotation and slide in a step of a length tau that ends in a state."""
    zero = real(0.0)
    slope = slope_of(path.theta)
    at_end = value_of(slope, tau)
    side = sign_of(path.theta[0])
    if side * slope[0] > zero and side * at_end < zero:
        at = root_of(side * slope, tau)
        top = size(value_of(path.theta, at))
        if top > seen.peak:
            seen.peak = top
            seen.peak_time = s.time - (tau - at)
    if size(s.theta) > seen.peak:
        seen.peak = size(s.theta)
        seen.peak_time = s.time
    seen.peak_slide = larger(size(slide_of(block, s)), seen.peak_slide)


@wp.func
def move_on(block: Block, path: Path, tau: real, s: wp.ref[State]):
    """Takes a block to a time tau of its step; what does not slide or part has no drift."""
    foot = point_of(block, lower_of(s.closed))
    before = turn_point(foot, sine(s.theta), cosine(s.theta))
    stood = s.x + before.x
    sticks = (s.closed & BASE) > 0 and s.slip == real(0.0)
    s.x = value_of(path.x, tau)
    s.z = value_of(path.z, tau)
    s.theta = value_of(path.theta, tau)
    s.vx = value_of(slope_of(path.x), tau)
    s.vz = value_of(slope_of(path.z), tau)
    s.omega = value_of(slope_of(path.theta), tau)
    at = turn_point(foot, sine(s.theta), cosine(s.theta))
    if (s.closed & BASE) > 0:
        s.z = -at.z
        s.vz = s.omega * at.x
    if sticks:
        s.x = stood - at.x
        s.vx = -s.omega * at.z
    elif (s.closed & FACE) > 0:
        k = int(3)
        if (s.closed & LOW) > 0:
            k = int(2)
        at = turn_point(point_of(block, k), sine(s.theta), cosine(s.theta))
        s.x = block.wall * block.half_width - at.x
        s.vx = -s.omega * at.z


@wp.func
def start_lane(block: Block, theta: real, omega: real, held: Held):
    """A block that is let go at a rotation [rad] with a rate [rad/s]: its state, what is seen."""
    zero = real(0.0)
    rests = theta == zero and omega == zero
    side = sign_of(wp.where(theta == zero, omega, theta))
    foot = Point(side * block.half_width, -block.half_height)
    at = turn_point(foot, sine(theta), cosine(theta))
    points = int(LEFT)
    mode = int(PIVOTING)
    if side > zero:
        points = int(RIGHT)
    x, z = foot.x - at.x, -at.z
    if rests:
        points = int(BASE)
        mode = int(FLAT)
        x = zero
        z = block.half_height
        if block.wall != zero:
            points = int(ALL)
    lifted, rested = wp.where(rests, NEVER, zero), wp.where(rests, zero, NEVER)
    state = State(
        x, z, theta, -omega * at.z, omega * at.x, omega, zero, points, points,
        wp.where(rests, 1, 0), 0, 0, 0, 1, mode, zero, 0, zero,
    )  # fmt: skip
    seen = Seen(size(theta), zero, zero, lifted, rested, zero, zero, zero, 0, 0)
    for i in range(held.ties.shape[0]):
        tie = tie_of(held, i)
        stretch = stretch_of(block, tie, state)
        start_tie(held, i, stretch)
        seen.stretch = larger(stretch, seen.stretch)
        seen.force = larger(size(force_of(tie, held.states[i, held.lane], stretch)), seen.force)
    return state, seen


@wp.func
def apply_event(
    block: Block, held: Held, kind: int, what: int, way: int, s: wp.ref[State],
    seen: wp.ref[Seen],
):  # fmt: skip
    """Applies an event that is no impact: what touches from now on, how ties act."""
    if kind == OPENS:
        s.near = s.closed - (1 << what)
        s.opens = 1 << what
        s.fresh = 1
    if kind == STARTS:
        s.slip = real(what)
        s.starts = 2
        s.fresh = 1
    if kind == STOPS:
        at = turn_point(point_of(block, what), sine(s.theta), cosine(s.theta))
        s.slip = real(0.0)
        s.vx = -s.omega * at.z
        s.fresh = 1
    if kind == CHANGES:
        tie = tie_of(held, what)
        stretch = stretch_of(block, tie, s)
        change_tie(held, what, way, stretch, s.time)
        state = held.states[what, held.lane]
        seen.force = larger(size(force_of(tie, state, stretch)), seen.force)
        s.fresh = 1
        if state.does == BROKEN_TIE:
            s.parts = 0
            s.opens = 0
            s.starts = 0
    if kind == FALLS:
        s.mode = OVERTURNED
        s.theta = real(what) * HALF_PI
        seen.peak = HALF_PI


@wp.func
def advance(
    block: Block, held: Held, m: Motion, a: Series, end: real, s: wp.ref[State],
    seen: wp.ref[Seen],
) -> Path:  # fmt: skip
    """One step, to its first event, the next knot of the motion, or at most to a time `end`."""
    zero = real(0.0)
    pull = pull_of(block, held)
    if s.fresh > 0:
        decide(block, pull, a[0], s, seen)
    knot = knot_time(m, s.segment)
    target = smaller(knot, end)
    room = larger(target - s.time, zero)
    h = smaller(smaller(block.longest_step, REACH / (size(s.omega) + TINY)), room)
    path = expand_path(block, pull, a, s)
    event = find_event(block, held, pull, s, a, path, h)
    tau = smaller(event.time, h)
    happens = event.time <= h
    seen.loss = seen.loss + friction_loss(block, s, path, tau)
    arrives = tau >= fused_less(TICK, target, room)
    s.time = wp.where(arrives, target, s.time + tau)
    if s.still == 0:
        move_on(block, path, tau, s)
    observe_rotation(block, s, path, tau, seen)
    observe_ties(block, held, s, path, tau, seen)
    kick = zero
    if s.time >= knot:
        kick = held.face * knot_step(m, s.segment)
        s.segment = s.segment + 1
        s.near = s.closed
        s.fresh = 1
    # A tie that changes at once does not change what has just begun, as long as it holds.
    if tau > AT_ONCE * h or event.kind != CHANGES:
        s.parts = 0
        s.opens = 0
        s.starts = 0
    base = Base(value_of(a, tau), kick)
    hits = happens and event.kind == TOUCHES
    if happens and not hits:
        if event.kind == LETS_GO:
            let_go(block, event.what, s)
        else:
            apply_event(block, held, event.kind, event.what, event.way, s, seen)
    if s.time >= knot:
        # Forces may jump there.
        s.opens = 0
        s.starts = 0
    if s.mode < OVERTURNED and (hits or kick != zero):
        points = touching_points(block, s)
        if hits and not has_point(points, event.what):
            points = points + (1 << event.what)
        put_back(block, s, points)
        strike(block, pull_of(block, held), base, points, s, seen)
    return path


@wp.func
def step(
    block: Block, held: Held, m: Motion, ground: Ground, end: real, s: wp.ref[State],
    seen: wp.ref[Seen],
):  # fmt: skip
    """One step of a lane, to its next event or at most to a time `end`.

    Returns:
        The path that it followed, seen from a side, and that side, -1 or 1.
    """
    a = pull_series(m, s.segment, s.time, ground)
    side = side_seen(block, pull_of(block, held), s, a)
    own = mirror_state(s, side)
    seen_from = Held(held.ties, held.states, held.lane, side)
    path = advance(mirror_block(block, side), seen_from, m, side * a, end, own, seen)
    after = mirror_state(own, side)
    s.x = after.x
    s.z = after.z
    s.theta = after.theta
    s.vx = after.vx
    s.vz = after.vz
    s.omega = after.omega
    s.slip = after.slip
    s.near = after.near
    s.closed = after.closed
    s.still = after.still
    s.parts = after.parts
    s.opens = after.opens
    s.starts = after.starts
    s.fresh = after.fresh
    s.mode = after.mode
    s.time = after.time
    s.segment = after.segment
    s.tail = after.tail
    if not wp.isfinite(s.theta + s.omega + s.vx + s.vz + s.x + s.z + s.time):
        s.mode = BROKEN
    seen.steps = seen.steps + 1
    return path, side
