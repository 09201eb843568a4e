"""Two stacked rocking blocks by Taylor series, event by event.

A step is one expansion of degree 10 in the present pattern (head of two_block/stack_mechanics.py).
It ends at the first of these:

- the length over which the series is accurate;
- a knot of the motion;
- a contact closes: an impact;
- the resultant of a closed contact leaves its width: the contact opens next;
- |rotation| = pi/2: a block has overturned.

Every event is a root of a series, found to round-off.

At an impact and at a velocity step of the base, two_block/stack_contact.py chooses the new pattern.
Then the rest rule follows: a contact that opens is closed at once if its next swing would stay
below `rest_rotation`, under the acceleration of that moment. The infinitely many impacts that this
leaves out are not counted and take no time.
"""

import warp as wp

from warprock.kernels.lane.modes import BROKEN, OVERTURNED
from warprock.kernels.motion.series import Series, slope_of, value_of
from warprock.kernels.two_block.stack_contact import (
    ADMISSIBLE,
    after_force,
    after_impulse,
    close_slow_contacts,
)
from warprock.kernels.two_block.stack_mechanics import (
    ROUND_OFF,
    Pair,
    Stack,
    accelerations,
    ground_pulls,
    interface_pulls,
    kinetic_energy,
    reactions,
)
from warprock.kernels.two_block.stack_series import (
    bearing_series,
    closing_time,
    first_crossing,
    root,
    sure_step,
)

NOTHING, GROUND, INTERFACE, OPENING, FALL = 0, 1, 2, 3, 4
"""Events that end a step."""

TOLERANCE = by_precision(1.0e-14, 1.0e-7)
"""Largest last term of the series of a rotation in a step [rad]."""
TOUCHING = by_precision(1.0e-14, 1.0e-7)
"""Gap [rad] below which a second closing contact takes part in an impact."""
OVERSTEP = by_precision(1.0e-9, 1.0e-5)
"""Time by which a step ends after the opening of a contact, so that its margin is negative [s]."""
SLACK = real(2.0) * ROUND_OFF


@wp.struct
class State:
    """State of one lane, and its observed response.

    Attributes:
        rotation, rate: [rad], [rad/s].
        ground, interface: The pattern.
        time: [s].
        segment: Knots of the motion passed.
        mode: How the lane stands, see modes.py.
        peak, peak_time: Largest |rotation| of the blocks and their times [s].
        uplift_time: Time of the first uplift [s], NEVER before.
        rest_time: Time since which the stack rests [s], NEVER while it moves.
        loss: Energy lost in impacts [J].
        impacts: Their number.
        regrip: Whether the forces have yet to choose which closed contacts open.
        outside: How often no pattern was admissible or a contact had to pull.
    """

    rotation: Pair
    rate: Pair
    ground: real
    interface: real
    time: real
    segment: int
    mode: int
    peak: Pair
    peak_time: Pair
    uplift_time: real
    rest_time: real
    loss: real
    impacts: int
    regrip: int
    outside: int


@wp.func
def sign_or_zero(x: real) -> real:
    """-1, 0 or 1."""
    return wp.where(x == real(0.0), real(0.0), sign_of(x))


@wp.func
def start_lane(stack: Stack) -> State:
    """The state of a stack at its start."""
    s = State()
    s.rotation = Pair(stack.lower.rotation_start, stack.upper.rotation_start)
    s.ground = sign_or_zero(s.rotation[0])
    s.interface = sign_or_zero(s.rotation[1] - s.rotation[0])
    flat = s.ground == real(0.0) and s.interface == real(0.0)
    s.peak = Pair(size(s.rotation[0]), size(s.rotation[1]))
    s.uplift_time = wp.where(flat, NEVER, real(0.0))
    s.rest_time = wp.where(flat, real(0.0), NEVER)
    s.regrip = 1
    return s


@wp.func
def set_pattern(state: State, s1: real, s2: real) -> State:
    """The state with a new pattern, and the times of uplift and rest that follow from it."""
    rested = state.ground == real(0.0) and state.interface == real(0.0)
    rests = s1 == real(0.0) and s2 == real(0.0)
    s = state
    s.ground = s1
    s.interface = s2
    if rested and not rests:
        s.uplift_time = smaller(s.uplift_time, s.time)
        s.rest_time = NEVER
    if rests and not rested:
        s.rest_time = s.time
    return s


@wp.func
def observe_peak(state: State, block: int, rotation: real, time: real) -> State:
    """The state with the peak of a block updated by a rotation."""
    s = state
    if size(rotation) > s.peak[block]:
        s.peak[block] = size(rotation)
        s.peak_time[block] = time
    return s


@wp.func
def reopen_contacts(stack: Stack, state: State, a: real) -> State:
    """Opens closed contacts by the forces at this time."""
    found = after_force(stack, state.ground, state.interface, state.rotation, state.rate, a)
    s = set_pattern(state, found.ground, found.interface)
    s.regrip = 0
    if found.rank < ADMISSIBLE or found.pulls:
        s.outside = s.outside + 1
    return s


@wp.func
def strike(stack: Stack, state: State, shut1: bool, shut2: bool, dv: real, a: real) -> State:
    """The state after an impact, or a step dv of the base velocity, at the touching contacts."""
    s1 = state.ground
    s2 = state.interface
    before = kinetic_energy(stack, s1, s2, state.rotation, state.rate)
    found = after_impulse(stack, s1, s2, shut1, shut2, state.rotation, state.rate, dv)
    s = state
    if found.rank < ADMISSIBLE or found.pulls:
        s.outside = s.outside + 1
    # Once one contact is closed, the other one may open too slowly to count.
    for _ in range(2):
        found = close_slow_contacts(stack, found, shut1, shut2, s.rotation, a)
    s.rate = found.motion
    s = set_pattern(s, found.ground, found.interface)
    s.regrip = 1
    if dv == real(0.0):
        after = kinetic_energy(stack, s.ground, s.interface, s.rotation, s.rate)
        s.loss = s.loss + before - after
        s.impacts = s.impacts + 1
    return s


@wp.func
def land(stack: Stack, state: State, event: int, a: real) -> State:
    """The state after an impact; the gap of the closing contact is exactly zero from then on."""
    zero = real(0.0)
    s = state
    s1 = s.ground
    s2 = s.interface
    gap1 = s1 * s.rotation[0]
    gap2 = s2 * (s.rotation[1] - s.rotation[0])
    nears1 = gap1 <= TOUCHING and s1 * s.rate[0] < zero
    nears2 = gap2 <= TOUCHING and s2 * (s.rate[1] - s.rate[0]) < zero
    shut1 = s1 == zero or event == GROUND or nears1
    shut2 = s2 == zero or event == INTERFACE or nears2
    if shut1:
        s.rotation[0] = zero
    if shut2:
        s.rotation[1] = s.rotation[0]
    return strike(stack, s, shut1, shut2, zero, a)


@wp.func
def presses(gap: Series, lever: real) -> bool:
    """Whether a pivoting contact without a gap is about to close."""
    zero = real(0.0)
    falls = gap[1] < zero or (gap[1] == zero and gap[2] <= zero)
    return lever != zero and gap[0] <= zero and falls


@wp.func
def first_opening(stack: Stack, state: State, x1: Series, x2: Series, a: Series, h: real) -> real:
    """First time in a step [s] at which the resultant of a closed contact leaves its width."""
    zero = real(0.0)
    found = NEVER
    s1 = state.ground
    s2 = state.interface
    if s1 == zero or s2 == zero:
        ground_load, tilt, normal, moment = bearing_series(stack, s1, s2, x1, x2, a)
        slack = SLACK * stack.lane.reach * stack.lane.gravity
        contact = int(0)
        while contact < 4:
            side = wp.where(contact % 2 == 0, real(1.0), real(-1.0))
            margin = Series()
            if contact < 2 and s1 == zero:
                margin = stack.lane.ground * ground_load + side * tilt
                margin[0] = margin[0] + slack * (stack.lower.mass + stack.upper.mass)
            if contact >= 2 and s2 == zero:
                margin = stack.lane.interface * normal + side * moment
                margin[0] = margin[0] + slack * stack.upper.mass
            found = smaller(first_crossing(margin, h), found)
            contact += 1
    return found


@wp.func
def first_fall(x: Series, h: real) -> real:
    """First time in a step at which |rotation| reaches pi/2."""
    found = NEVER
    end = value_of(x, h)
    if size(end) >= HALF_PI:
        left = -sign_of(end) * x
        left[0] = left[0] + HALF_PI
        found = first_crossing(left, h)
    return found


@wp.func
def end_step(state: State, x1: Series, x2: Series, tau: real, time: real) -> State:
    """The state after a time tau of a step, with its peaks; closed contacts are exactly closed."""
    s = state
    rate1 = slope_of(x1)
    rate2 = slope_of(x2)
    end_rate1 = value_of(rate1, tau)
    end_rate2 = value_of(rate2, tau)
    if end_rate1 * rate1[0] < real(0.0):
        turn1 = root(rate1, real(0.0), tau)
        s = observe_peak(s, 0, value_of(x1, turn1), state.time + turn1)
    if end_rate2 * rate2[0] < real(0.0):
        turn2 = root(rate2, real(0.0), tau)
        s = observe_peak(s, 1, value_of(x2, turn2), state.time + turn2)
    first = value_of(x1, tau)
    second = value_of(x2, tau)
    glued = s.interface == real(0.0)
    s.rotation = Pair(first, wp.where(glued, first, second))
    s.rate = Pair(end_rate1, wp.where(glued, end_rate1, end_rate2))
    s.time = time
    s = observe_peak(s, 0, s.rotation[0], time)
    return observe_peak(s, 1, s.rotation[1], time)


@wp.func
def step(stack: Stack, state: State, a: Series, until: real, x1: Series, x2: Series) -> State:
    """One step of the series x1, x2 to its first event, or at most to `until`."""
    zero = real(0.0)
    s1 = state.ground
    s2 = state.interface
    room = until - state.time
    h = smaller(sure_step(x1, x2, TOLERANCE), stack.lane.step_length)
    reaches_end = h >= room
    h = wp.where(reaches_end, room, h)
    gap1 = s1 * x1
    gap2 = s2 * (x2 - x1)
    event = int(NOTHING)
    tau = real(h)
    if presses(gap1, s1) or presses(gap2, s2):
        tau = zero
        event = wp.where(presses(gap1, s1), GROUND, INTERFACE)
    else:
        lands1 = wp.where(s1 == zero, NEVER, closing_time(gap1, h))
        lands2 = wp.where(s2 == zero, NEVER, closing_time(gap2, h))
        opening = first_opening(stack, state, x1, x2, a, h)
        fall = smaller(first_fall(x1, h), first_fall(x2, h))
        first = smaller(smaller(lands1, lands2), smaller(opening, fall))
        if first <= h:
            tau = first
            event = wp.where(first == opening, OPENING, FALL)
            event = wp.where(first == lands2, INTERFACE, event)
            event = wp.where(first == lands1, GROUND, event)
            tau = wp.where(event == OPENING, smaller(tau + OVERSTEP, h), tau)
    time = wp.where(reaches_end and tau >= h, until, state.time + tau)
    s = end_step(state, x1, x2, tau, time)
    lands = event < OPENING and event > NOTHING
    if lands:
        s = land(stack, s, event, value_of(a, tau))
    elif event == FALL:
        s = overturn(s)
    elif event == OPENING:
        s.regrip = 1
    return check_state(stack, s, value_of(a, tau))


@wp.func
def overturn(state: State) -> State:
    """The state of an overturned lane: the rotation of one block is exactly pi/2."""
    s = state
    s.mode = OVERTURNED
    upper_falls = size(s.rotation[1]) > size(s.rotation[0])
    if upper_falls or s.interface == real(0.0):
        s.rotation[1] = HALF_PI * sign_of(s.rotation[1])
    if not upper_falls or s.interface == real(0.0):
        s.rotation[0] = HALF_PI * sign_of(s.rotation[0])
    s = observe_peak(s, 0, s.rotation[0], s.time)
    return observe_peak(s, 1, s.rotation[1], s.time)


@wp.func
def check_state(stack: Stack, state: State, a: real) -> State:
    """The state, BROKEN if it is not finite; counts contacts that have to pull in `outside`."""
    s = state
    total = s.rotation[0] + s.rotation[1] + s.rate[0] + s.rate[1] + s.time + a
    sound = total - total == real(0.0)
    if not sound:
        s.mode = BROKEN
    bend = accelerations(stack, s.ground, s.interface, s.rotation, s.rate, a)
    force = reactions(stack, s.ground, s.interface, s.rotation, s.rate, bend, a)
    if ground_pulls(force) or interface_pulls(stack, s.rotation, force):
        s.outside = s.outside + 1
    return s
