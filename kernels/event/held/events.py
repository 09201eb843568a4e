"""Events of a held block in a step: the first of them ends it.

Each is the first time at which a Taylor polynomial falls below zero: the gap of a point, the force
of one that presses, what is left of friction, the velocity of a corner that slides, the distance of
a tie from where its force changes, the angle to a fall. A polynomial begins at zero where the last
step has ended at this event. It is then divided by the time until it begins with another number.
"""

import warp as wp

from warprock.kernels.contact.ties import (
    ELASTIC,
    LOOSE,
    YIELDING,
    YIELDING_BACK,
    Tie,
    TieState,
    changed_state,
    state_at,
)
from warprock.kernels.event.held.contact import wall_reserve
from warprock.kernels.event.held.path import (
    Held,
    Path,
    Pull,
    force_series,
    free_rates,
    level_series,
    place_series,
    slip_series,
    stretch_series,
    tie_of,
)
from warprock.kernels.event.held.state import (
    ALL,
    BASE,
    HIGH,
    LEFT,
    LOW,
    RIGHT,
    Block,
    State,
    has_point,
    point_of,
)
from warprock.kernels.motion.series import DEGREE, Series, first_root, slope_of

NOTHING, OPENS, STARTS, STOPS, TOUCHES, CHANGES, FALLS, LETS_GO = 0, 1, 2, 3, 4, 5, 6, 7
"""Kinds of events: none; a point no longer presses; a corner begins to slide, or stops; a point
touches; a tie changes; the block has fallen; base and wall let go of a block."""

AT_ZERO = by_precision(1.0e-14, 1.0e-6)
"""Round-off of a gap, an elongation or a force, as a part of the block's size, its weight."""
NEARLY = by_precision(1.0e-13, 1.0e-5)
"""Round-off of the coefficients that follow one that is zero, as a part of the largest term."""


@wp.struct
class Event:
    """The first event: when [s], of which kind, and of what: a point, a tie, a direction.

    `way` is 1 of a tie that is stretched, -1 of one that is let go.
    """

    time: real
    kind: int
    what: int
    way: int


@wp.func
def first_below(p: Series, h: real, noise: real, zeros: int) -> real:
    """First time in [0, h] at which a series falls below zero; NEVER if it does not.

    Args:
        p: The series.
        h: The end [s].
        noise: Largest value that counts as zero at the start.
        zeros: Coefficients that are known to be zero.
    """
    zero = real(0.0)
    found = NEVER
    q = p
    if zeros > 0 or p[0] <= noise:
        most = zero
        power = real(1.0)
        for k in range(DEGREE + 1):
            if k > 0 and k >= zeros:
                most = larger(size(p[k]) * power, most)
            power = power * h
        lead = int(larger(real(zeros), real(1.0)))
        power = real(1.0)
        for k in range(DEGREE):
            if lead == k and size(p[k]) * power <= NEARLY * most:
                lead = k + 1
            power = power * h
        q = Series()
        for k in range(DEGREE + 1):
            if k + lead <= DEGREE:
                q[k] = p[k + lead]
        if q[0] < zero or (zeros == 0 and p[0] < -real(100.0) * noise):
            found = zero
    if q[0] > zero and found > zero:
        found = first_root(q, h)
    return found


@wp.func
def sooner_event(found: Event, time: real, kind: int, what: int) -> Event:
    """The sooner one of an event and of another."""
    first = found
    if time < found.time:
        first = Event(time, kind, what, 0)
    return first


@wp.func
def contact_events(
    block: Block, s: State, path: Path, weight: real, h: real, found: Event
) -> Event:
    """The first event of contact points, if it is sooner than another."""
    zero = real(0.0)
    first = found
    corner = int(0)
    if (s.closed & RIGHT) > 0:
        corner = int(1)
    sticks = (s.closed & BASE) > 0 and s.slip == zero
    carried = Series()
    n = int(0)
    reach = AT_ZERO * (block.half_height + block.half_width)
    for k in range(4):
        p = point_of(block, k)
        if has_point(s.closed, k):
            force = force_series(path, n)
            first = sooner_event(first, first_below(force, h, AT_ZERO * weight, 0), OPENS, k)
            if k < 2:
                carried = carried + force
            n = n + 1
        elif k < 2 or block.wall != zero:
            gap = level_series(path, p)
            if k > 1:
                gap = -block.wall * place_series(path, p)
                gap[0] = gap[0] + block.half_width
            # A block about a corner that sticks does not bring its foot nearer to the wall than
            # it has it when it lies flat.
            clear = bool(False)
            if k == 2 and sticks:
                foot = point_of(block, corner)
                at = place_series(path, foot)
                clear = block.wall * (at[0] - foot.x) <= real(100.0) * reach
            leaves = int(0)
            if has_point(s.parts, k):
                leaves = int(2)
            # Its force has just come to zero: so do gap, rate and acceleration.
            if has_point(s.opens, k):
                leaves = int(3)
            if not clear:
                first = sooner_event(first, first_below(gap, h, reach, leaves), TOUCHES, k)
    if (s.closed & BASE) > 0:
        if sticks:
            force = force_series(path, n)
            grip = block.friction * carried
            noise = AT_ZERO * weight
            first = sooner_event(first, first_below(grip - force, h, noise, 0), STARTS, -1)
            first = sooner_event(first, first_below(grip + force, h, noise, 0), STARTS, 1)
        else:
            along = s.slip * slip_series(path, point_of(block, corner))
            speed = AT_ZERO * (size(s.vx) + block.half_height * size(s.omega))
            first = sooner_event(first, first_below(along, h, speed, s.starts), STOPS, corner)
    return first


@wp.func
def let_go_events(
    block: Block, pull: Pull, s: State, a: Series, weight: real, h: real, found: Event
) -> Event:
    """When base and wall let go of a block that lies on both, if that is sooner than another."""
    first = found
    # What they have to give is linear in the acceleration of the base.
    rates = free_rates(block, pull, s, real(0.0))
    zero = real(0.0)
    fixed = wall_reserve(
        block, -block.mass * rates[0], -block.mass * rates[1], -block.inertia * rates[2]
    )
    moving = wall_reserve(block, block.mass, zero, zero)
    arm = block.half_height + block.half_width
    for k in range(3):
        left = moving[k] * a
        left[0] = left[0] + fixed[k]
        noise = AT_ZERO * weight
        if k > 0:
            noise = noise * arm
        first = sooner_event(first, first_below(left, h, noise, 0), LETS_GO, k)
    return first


@wp.func
def reaches(p: Series, h: real, noise: real, begins: bool) -> real:
    """When a tie comes to where its force changes, from what is left until then; NEVER if not.

    At the start of a motion from rest that begins without an acceleration three coefficients of an
    elongation are zero.
    """
    zeros = int(0)
    if begins and p[0] <= noise:
        zeros = int(3)
    return first_below(p, h, noise, zeros)


@wp.func
def turns_back(rate: Series, h: real, begins: bool) -> real:
    """When a rate that does not begin below zero falls below it; NEVER if not."""
    zeros = int(0)
    if begins:
        zeros = int(2)
    return first_below(rate, h, real(0.0), zeros)


@wp.func
def tie_event(
    block: Block, tie: Tie, state: TieState, path: Path, h: real, begins: bool
) -> Event:  # fmt: skip
    """The next change of a tie; `begins` as for `reaches`."""
    noise = AT_ZERO * (block.half_height + block.half_width)
    first = Event(NEVER, NOTHING, 0, 0)
    stretch = stretch_series(block, tie, path)
    reach = tie.yield_force / tie.stiffness
    longer = NEVER
    shorter = NEVER
    left = -stretch
    back = stretch
    if state.does == LOOSE:
        left[0] = left[0] + state.free
        longer = reaches(left, h, noise, begins)
    if state.does == ELASTIC:
        left[0] = left[0] + smaller(tie.longest, state.free + reach)
        longer = reaches(left, h, noise, begins)
        least = state.free
        if tie.pushes > 0:
            least = state.free - reach
        back[0] = back[0] - least
        shorter = reaches(back, h, noise, begins)
    if state.does == YIELDING:
        left[0] = left[0] + tie.longest
        longer = reaches(left, h, noise, begins)
        shorter = turns_back(slope_of(stretch), h, begins)
    if state.does == YIELDING_BACK:
        longer = turns_back(-slope_of(stretch), h, begins)
    if longer < first.time:
        first = Event(longer, CHANGES, 0, 1)
    if shorter < first.time:
        first = Event(shorter, CHANGES, 0, -1)
    return first


@wp.func
def change_tie(held: Held, i: int, way: int, stretch: real, time: real):
    """Changes what a tie does at an elongation [m] and a time [s]."""
    tie = held.ties[i, held.lane]
    held.states[i, held.lane] = changed_state(
        tie, held.states[i, held.lane], way > 0, stretch, time
    )


@wp.func
def start_tie(held: Held, i: int, stretch: real):
    """Puts a tie in the state that a block has which was led to an elongation [m]."""
    held.states[i, held.lane] = state_at(held.ties[i, held.lane], stretch)


@wp.func
def find_event(
    block: Block, held: Held, pull: Pull, s: State, a: Series, path: Path, h: real
) -> Event:
    """The first event within h; its time is NEVER if there is none."""
    found = Event(NEVER, NOTHING, 0, 0)
    weight = block.mass * block.gravity + pull.down
    if s.closed == ALL:
        found = let_go_events(block, pull, s, a, weight, h, found)
    else:
        found = contact_events(block, s, path, weight, h, found)
        still = s.vx == real(0.0) and s.vz == real(0.0) and s.omega == real(0.0)
        begins = still and (s.opens > 0 or s.starts > 0)
        for i in range(held.ties.shape[0]):
            state = held.states[i, held.lane]
            change = tie_event(block, tie_of(held, i), state, path, h, begins)
            if change.time < found.time:
                found = Event(change.time, CHANGES, i, change.way)
        ahead = -path.theta
        behind = path.theta
        ahead[0] = ahead[0] + HALF_PI
        behind[0] = behind[0] + HALF_PI
        found = sooner_event(found, first_below(ahead, h, real(0.0), 0), FALLS, 1)
        found = sooner_event(found, first_below(behind, h, real(0.0), 0), FALLS, -1)
    return found


@wp.func
def let_go(block: Block, what: int, s: wp.ref[State]):
    """Base and wall let go of a block that lies on both: the points that still touch, its slip."""
    away = -block.wall
    far, foot = int(LEFT), int(RIGHT)
    if away > real(0.0):
        far = int(RIGHT)
        foot = int(LEFT)
    s.fresh = 1
    s.near = BASE
    s.opens = LOW + HIGH
    s.slip = away
    s.starts = 2
    if what == 1:
        s.near = far + LOW
        s.opens = foot + HIGH
        s.slip = real(0.0)
        s.starts = 0
    if what == 2:
        s.near = foot + HIGH
        s.opens = far + LOW
