"""Ties of a block, and what lies on its top: what they are, and the force of a tie.

A tie pulls towards its side with F = k (e - e0), e its elongation from the state in which the block
rests, and with no more than its yield force; e0, where it has no force, is its slack less what its
prestress has taken, and grows by what it yields. A tie that only pulls is loose below e0. Beyond
its ultimate elongation it is broken.
"""

import warp as wp

LOOSE, ELASTIC, YIELDING, YIELDING_BACK, BROKEN_TIE = 0, 1, 2, 3, 4
"""What a tie does: nothing; give a force by its stiffness; yield in tension, in compression; it is
broken."""


@wp.struct
class Tie:
    """What a step needs to know of a tie.

    Attributes:
        side: Side of the block that it is at, -1 or 1.
        height: Height of its point [m].
        stiffness: [N/m].
        yield_force: [N]; NEVER of one that does not yield.
        longest: Elongation at which it breaks [m]; NEVER of one that does not.
        free_length: Elongation without force at the start, e0 [m].
        pushes: 1 if it also gives compression, else 0.
    """

    side: real
    height: real
    stiffness: real
    yield_force: real
    longest: real
    free_length: real
    pushes: int


@wp.struct
class TieState:
    """State of a tie.

    Attributes:
        free: Elongation without force, e0 [m].
        lost: Energy that it has taken by yielding and with its break [J].
        broken: When it broke [s]; NEVER before.
        does: LOOSE, ELASTIC and so on.
    """

    free: real
    lost: real
    broken: real
    does: int


@wp.struct
class Load:
    """Forces on top of a block.

    Attributes:
        weight: Downwards [N].
        thrust: Towards +x [N].
        place: Where it presses, from the middle of the block to +x [m].
        height: How high above its base [m].
        stays: 1 if the weight keeps its place while the block turns, else 0.
    """

    weight: real
    thrust: real
    place: real
    height: real
    stays: int


@wp.func
def force_of(tie: Tie, state: TieState, stretch: real) -> real:
    """Force of a tie at an elongation [N], tension positive."""
    force = real(0.0)
    if state.does == ELASTIC:
        force = tie.stiffness * (stretch - state.free)
    if state.does == YIELDING:
        force = tie.yield_force
    if state.does == YIELDING_BACK:
        force = -tie.yield_force
    return force


@wp.func
def breaks_before_yield(tie: Tie, state: TieState) -> bool:
    """Whether an elastic tie that is stretched breaks before it yields."""
    return tie.longest <= state.free + tie.yield_force / tie.stiffness


@wp.func
def changed_state(tie: Tie, state: TieState, further: bool, stretch: real, time: real) -> TieState:
    """State behind an event at an elongation [m] that grows further, or else shrinks.

    The energy that yielding takes is counted where it ends; a break takes what the tie holds, too.
    """
    reach = tie.yield_force / tie.stiffness
    if further:
        if state.does == LOOSE:
            state.does = ELASTIC
        elif state.does == ELASTIC:
            state.does = YIELDING
            if breaks_before_yield(tie, state):
                state.does = BROKEN_TIE
                force = tie.stiffness * (stretch - state.free)
                state.lost = state.lost + HALF * force * force / tie.stiffness
                state.broken = time
        elif state.does == YIELDING:
            state.does = BROKEN_TIE
            worn = tie.yield_force * (stretch - reach - state.free)
            state.lost = state.lost + worn + HALF * tie.yield_force * reach
            state.broken = time
        else:
            state.does = ELASTIC
            worn = tie.yield_force * (state.free - (stretch + reach))
            state.lost = state.lost + worn
            state.free = stretch + reach
    elif state.does == YIELDING:
        state.does = ELASTIC
        worn = tie.yield_force * (stretch - reach - state.free)
        state.lost = state.lost + worn
        state.free = stretch - reach
    elif tie.pushes > 0:
        state.does = YIELDING_BACK
    else:
        state.does = LOOSE
    return state


@wp.func
def state_at(tie: Tie, stretch: real) -> TieState:
    """State of a tie of a block that was led to an elongation [m]."""
    state = TieState(tie.free_length, real(0.0), NEVER, ELASTIC)
    reach = tie.yield_force / tie.stiffness
    if stretch < state.free and tie.pushes == 0:
        state.does = LOOSE
    if stretch > state.free + reach:
        state.free = stretch - reach
    if stretch < state.free - reach and tie.pushes > 0:
        state.free = stretch + reach
    if stretch > tie.longest:
        state.does = BROKEN_TIE
        state.broken = real(0.0)
    return state
