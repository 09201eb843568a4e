"""Two stacked rocking blocks by Taylor series, event by event.

A step is one expansion of degree 10 in the present pattern (head of two_block/stack_mechanics.py).
It
ends at the first of: the length over which the series is sure, a knot of the motion, a contact
that closes (an impact), the resultant of a closed contact leaving its width (the contact opens
next), |rotation| = pi/2 (overturned). Every event is a root of a series, found to round-off.

At an impact and at a velocity step of the base the rule of two_block/stack_contact.py decides, and
then
the rest rule: a contact that opens closes at once if, under the acceleration of that moment, its
next swing would stay below `rest_rotation`. The infinitely many impacts that it leaves out are
neither counted nor given their time.
"""

import warp as wp

from warprock.kernels.modes import BROKEN, OVERTURNED
from warprock.kernels.two_block.stack_contact import ADMISSIBLE, after_force, after_impulse, settle
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
    Series,
    bearing_series,
    closing,
    derive,
    first_crossing,
    root,
    sure_step,
    value,
)

NOTHING, GROUND, INTERFACE, OPENING, FALL = 0, 1, 2, 3, 4
"""Events that end a step."""

TOLERANCE = by_precision(1.0e-14, 1.0e-7)
"""Largest last term of a rotation's series in a step [rad]."""
TOUCHING = by_precision(1.0e-14, 1.0e-7)
"""Gap [rad] below which a second contact that closes takes part in an impact."""
OVERSTEP = by_precision(1.0e-9, 1.0e-5)
"""Time by which the opening of a contact is overstepped, so that its cause is clear [s]."""
SLACK = real(2.0) * ROUND_OFF


@wp.struct
class State:
    """One lane: the state of its blocks, and what has happened so far.

    rotation [rad] and rate [rad/s]; the pattern (ground, interface); time [s]; segment, the knots
    passed; mode; peaks of |rotation| and their times; time of the first uplift and time since
    when the stack rests, NEVER before; loss, the energy lost in impacts [J]; impacts; regrip,
    whether forces have still to decide about the contacts; outside, how often the model had no
    admissible answer or a contact had to pull.
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
def release(stack: Stack) -> State:
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
def in_pattern(state: State, s1: real, s2: real) -> State:
    """The state with a pattern, and the times of uplift and rest that follow."""
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
def note_peak(state: State, block: int, rotation: real, time: real) -> State:
    """The state with a rotation of one block as a candidate for its peak."""
    s = state
    if size(rotation) > s.peak[block]:
        s.peak[block] = size(rotation)
        s.peak_time[block] = time
    return s


@wp.func
def regrip(stack: Stack, state: State, a: real) -> State:
    """Lets the forces of this moment open closed contacts."""
    found = after_force(stack, state.ground, state.interface, state.rotation, state.rate, a)
    s = in_pattern(state, found.ground, found.interface)
    s.regrip = 0
    if found.rank < ADMISSIBLE or found.pulls:
        s.outside = s.outside + 1
    return s


@wp.func
def strike(stack: Stack, state: State, shut1: bool, shut2: bool, dv: real, a: real) -> State:
    """An impact, or a step dv of the base's velocity, at the contacts that touch."""
    s1 = state.ground
    s2 = state.interface
    before = kinetic_energy(stack, s1, s2, state.rotation, state.rate)
    found = after_impulse(stack, s1, s2, shut1, shut2, state.rotation, state.rate, dv)
    s = state
    if found.rank < ADMISSIBLE or found.pulls:
        s.outside = s.outside + 1
    # Once a contact is closed, the other one may open too slowly to count.
    for _ in range(2):
        found = settle(stack, found, shut1, shut2, s.rotation, a)
    s.rate = found.motion
    s = in_pattern(s, found.ground, found.interface)
    s.regrip = 1
    if dv == real(0.0):
        after = kinetic_energy(stack, s.ground, s.interface, s.rotation, s.rate)
        s.loss = s.loss + before - after
        s.impacts = s.impacts + 1
    return s


@wp.func
def land(stack: Stack, state: State, event: int, a: real) -> State:
    """An impact: the gap of the contact that closes is exactly zero from here on."""
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
    """First time in a step at which the resultant of a closed contact leaves its width."""
    zero = real(0.0)
    found = NEVER
    s1 = state.ground
    s2 = state.interface
    if s1 == zero or s2 == zero:
        whole, tilt, normal, moment = bearing_series(stack, s1, s2, x1, x2, a)
        slack = SLACK * stack.reach * stack.gravity
        contact = int(0)
        while contact < 4:
            side = wp.where(contact % 2 == 0, real(1.0), real(-1.0))
            margin = Series()
            if contact < 2 and s1 == zero:
                margin = stack.ground * whole + side * tilt
                margin[0] = margin[0] + slack * (stack.lower.mass + stack.upper.mass)
            if contact >= 2 and s2 == zero:
                margin = stack.interface * normal + side * moment
                margin[0] = margin[0] + slack * stack.upper.mass
            found = smaller(first_crossing(margin, h), found)
            contact += 1
    return found


@wp.func
def first_fall(x: Series, h: real) -> real:
    """First time in a step at which |rotation| reaches pi/2."""
    found = NEVER
    end = value(x, h)
    if size(end) >= HALF_PI:
        left = -sign_of(end) * x
        left[0] = left[0] + HALF_PI
        found = first_crossing(left, h)
    return found


@wp.func
def arrive(state: State, x1: Series, x2: Series, tau: real, time: real) -> State:
    """The state after a time tau of a step, turning points noted, snapped to its pattern."""
    s = state
    v1 = derive(x1)
    v2 = derive(x2)
    w1 = value(v1, tau)
    w2 = value(v2, tau)
    if w1 * v1[0] < real(0.0):
        turn1 = root(v1, real(0.0), tau)
        s = note_peak(s, 0, value(x1, turn1), state.time + turn1)
    if w2 * v2[0] < real(0.0):
        turn2 = root(v2, real(0.0), tau)
        s = note_peak(s, 1, value(x2, turn2), state.time + turn2)
    first = value(x1, tau)
    second = value(x2, tau)
    glued = s.interface == real(0.0)
    s.rotation = Pair(first, wp.where(glued, first, second))
    s.rate = Pair(w1, wp.where(glued, w1, w2))
    s.time = time
    s = note_peak(s, 0, s.rotation[0], time)
    return note_peak(s, 1, s.rotation[1], time)


@wp.func
def step(stack: Stack, state: State, a: Series, until: real, x1: Series, x2: Series) -> State:
    """One step of the series x1, x2 to its first event, or at most to `until`."""
    zero = real(0.0)
    s1 = state.ground
    s2 = state.interface
    room = until - state.time
    h = smaller(sure_step(x1, x2, TOLERANCE), stack.step_length)
    whole = h >= room
    h = wp.where(whole, room, h)
    gap1 = s1 * x1
    gap2 = s2 * (x2 - x1)
    event = int(NOTHING)
    tau = real(h)
    if presses(gap1, s1) or presses(gap2, s2):
        tau = zero
        event = wp.where(presses(gap1, s1), GROUND, INTERFACE)
    else:
        lands1 = wp.where(s1 == zero, NEVER, closing(gap1, h))
        lands2 = wp.where(s2 == zero, NEVER, closing(gap2, h))
        opening = first_opening(stack, state, x1, x2, a, h)
        fall = smaller(first_fall(x1, h), first_fall(x2, h))
        first = smaller(smaller(lands1, lands2), smaller(opening, fall))
        if first <= h:
            tau = first
            event = wp.where(first == opening, OPENING, FALL)
            event = wp.where(first == lands2, INTERFACE, event)
            event = wp.where(first == lands1, GROUND, event)
            tau = wp.where(event == OPENING, smaller(tau + OVERSTEP, h), tau)
    time = wp.where(whole and tau >= h, until, state.time + tau)
    s = arrive(state, x1, x2, tau, time)
    lands = event < OPENING and event > NOTHING
    if lands:
        s = land(stack, s, event, value(a, tau))
    elif event == FALL:
        s = topple(s)
    elif event == OPENING:
        s.regrip = 1
    return check(stack, s, value(a, tau))


@wp.func
def topple(state: State) -> State:
    """The state of a lane one block of which has overturned: its rotation is pi/2."""
    s = state
    s.mode = OVERTURNED
    upper_falls = size(s.rotation[1]) > size(s.rotation[0])
    if upper_falls or s.interface == real(0.0):
        s.rotation[1] = HALF_PI * sign_of(s.rotation[1])
    if not upper_falls or s.interface == real(0.0):
        s.rotation[0] = HALF_PI * sign_of(s.rotation[0])
    s = note_peak(s, 0, s.rotation[0], s.time)
    return note_peak(s, 1, s.rotation[1], s.time)


@wp.func
def check(stack: Stack, state: State, a: real) -> State:
    """The state, broken if it is not finite; contacts that have to pull are noted."""
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
