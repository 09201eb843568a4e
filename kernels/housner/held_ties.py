"""Ties of a rocking block: the forces that they give, and the rotations at which they change.

A tie holds a point of a side of the block, at a height d above the base, by a horizontal force; its
other end is so far away that the force stays horizontal. With X from the pivot to that side along
the base, s = sin(theta) and w = 1 - cos(theta), the point moves along the base by

    u = d s - X w,

the tie is longer by e = -side u than with the block at rest, and a horizontal force H turns the
block by H du/dtheta = H (d cos(theta) - X s). What force a tie gives at an
elongation is told in kernels/contact/ties.py.

Between two changes the moment of all ties is a polynomial in s and w, so that the series of the
rotation follows as that of the free block does. A block that turns one way moves all its ties one
way: each change is a rotation that is known before it is reached, and is located as an impact is.
"""

import warp as wp

from warprock.kernels.contact.ties import (
    ELASTIC,
    LOOSE,
    YIELDING,
    YIELDING_BACK,
    Load,
    Tie,
    TieState,
    changed_state,
    force_of,
    state_at,
)


@wp.struct
class Restraints:
    """What acts on the block of a lane; ties are [tie, lane].

    Attributes:
        ties: What they are.
        states: Their states.
        lane: Number of the lane.
        half_width: Of the block [m].
        inertia: Of the block about its pivot [kg m^2].
        load: On top of it.
    """

    ties: wp.array2d(dtype=Tie)
    states: wp.array2d(dtype=TieState)
    lane: int
    half_width: real
    inertia: real
    load: Load


@wp.struct
class Pull:
    """Moments and forces of all restraints between two changes.

    The moment over the inertia is k + c cos + s sin + sc sin cos + sx (sin^2 + w cos) + sw sin w of
    the rotation; the force along the base is f + fs sin + fw w, that downwards n [N].
    """

    k: real
    c: real
    s: real
    sc: real
    sx: real
    sw: real
    f: real
    fs: real
    fw: real
    n: real


@wp.struct
class Bound:
    """Where the motion of a block changes next: the lean [rad], and the tie; -1 is none of them."""

    lean: real
    tie: int


@wp.func
def arm_of(held: Restraints, tie: Tie, side: real) -> real:
    """The distance X from the pivot at a side to the side of a tie [m]."""
    return held.half_width * (tie.side - side)


@wp.func
def tie_shift(tie: Tie, arm: real, theta: real) -> real:
    """How far the point of a tie has moved along the base [m]."""
    s, c = sine(HALF * theta), cosine(HALF * theta)
    return real(2.0) * s * (tie.height * c - arm * s)


@wp.func
def elongation(held: Restraints, tie: Tie, side: real, theta: real) -> real:
    """Elongation of a tie from the state in which the block rests [m]."""
    return -tie.side * tie_shift(tie, arm_of(held, tie, side), theta)


@wp.func
def pull_of(held: Restraints, side: real) -> Pull:
    """The moments about the pivot at a side, and the forces, of the ties and of the load.

    A weight N, X from the pivot and d above it, turns the block by N (X cos + d sin) where it moves
    with it, by N X where it stays; a thrust T by T (d cos - X sin).
    """
    p = Pull()
    load = held.load
    beside = load.place - held.half_width * side
    p.f = load.thrust
    p.n = load.weight
    p.c = load.thrust * load.height / held.inertia
    p.s = -load.thrust * beside / held.inertia
    if load.stays > 0:
        p.k = load.weight * beside / held.inertia
    else:
        p.c = p.c + load.weight * beside / held.inertia
        p.s = p.s + load.weight * load.height / held.inertia
    for i in range(held.ties.shape[0]):
        tie = held.ties[i, held.lane]
        state = held.states[i, held.lane]
        d, x = tie.height, arm_of(held, tie, side)
        constant = tie.side * force_of(tie, state, state.free)
        if state.does == ELASTIC:
            k = tie.stiffness
            constant = -tie.side * k * state.free
            per = k / held.inertia
            p.sc = p.sc - per * d * d
            p.sx = p.sx + per * d * x
            p.sw = p.sw - per * x * x
            p.fs = p.fs - k * d
            p.fw = p.fw + k * x
        p.c = p.c + constant * d / held.inertia
        p.s = p.s - constant * x / held.inertia
        p.f = p.f + constant
    return p


@wp.func
def next_change(tie: Tie, state: TieState, stretches: bool) -> real:
    """The elongation at which a tie that is stretched or let go changes [m]; NEVER if none.

    One that yields and turns back is elastic from where it is: -NEVER or NEVER, which it has
    passed.
    """
    bound = NEVER
    if stretches:
        if state.does == LOOSE:
            bound = state.free
        if state.does == ELASTIC:
            bound = smaller(tie.longest, state.free + tie.yield_force / tie.stiffness)
        if state.does == YIELDING:
            bound = tie.longest
        if state.does == YIELDING_BACK:
            bound = -NEVER
    else:
        bound = -NEVER
        if state.does == ELASTIC:
            bound = state.free
            if tie.pushes > 0:
                bound = state.free - tie.yield_force / tie.stiffness
        if state.does == YIELDING:
            bound = NEVER
    return bound


@wp.func
def lean_at(tie: Tie, arm: real, side: real, stretch: real) -> real:
    """The lean to a side at which a tie has an elongation [rad]; -1 where there is none.

    With t = tan(theta / 2), (2 X + u) t^2 - 2 d t + u = 0.
    """
    lean = real(-1.0)
    u = -tie.side * stretch
    d = tie.height
    square = d * d - u * (real(2.0) * arm + u)
    if square >= real(0.0):
        lean = side * real(2.0) * wp.atan(u / (d + wp.sqrt(square)))
    return lean


@wp.func
def next_bound(held: Restraints, side: real, lean: real, outwards: bool) -> Bound:
    """Where a block that turns outwards or back comes to next: a change of a tie, its end."""
    bound = Bound(wp.where(outwards, HALF_PI, real(0.0)), -1)
    for i in range(held.ties.shape[0]):
        tie = held.ties[i, held.lane]
        state = held.states[i, held.lane]
        stretches = (tie.side * side < real(0.0)) == outwards
        at = next_change(tie, state, stretches)
        turned_back = (stretches and at <= -NEVER) or (not stretches and at >= NEVER)
        there = lean
        if not turned_back:
            there = lean_at(tie, arm_of(held, tie, side), side, at)
        if outwards and there >= real(0.0) and there < bound.lean:
            bound = Bound(there, i)
        if not outwards and there > bound.lean:
            bound = Bound(there, i)
    return bound


@wp.func
def change_tie(held: Restraints, i: int, side: real, theta: real, outwards: bool, time: real):
    """Changes what a tie does at the rotation at which it changes."""
    tie = held.ties[i, held.lane]
    stretch = elongation(held, tie, side, theta)
    further = (tie.side * side < real(0.0)) == outwards
    state = changed_state(tie, held.states[i, held.lane], further, stretch, time)
    held.states[i, held.lane] = state


@wp.func
def start_ties(held: Restraints, side: real, theta: real):
    """Puts the ties in the state that a block has which was led to a rotation."""
    for i in range(held.ties.shape[0]):
        tie = held.ties[i, held.lane]
        held.states[i, held.lane] = state_at(tie, elongation(held, tie, side, theta))


@wp.func
def unfinished_loss(held: Restraints, i: int, side: real, theta: real) -> real:
    """Energy that a tie has taken until now, with that of a yielding that has not ended [J]."""
    tie = held.ties[i, held.lane]
    state = held.states[i, held.lane]
    stretch = elongation(held, tie, side, theta)
    reach = tie.yield_force / tie.stiffness
    lost = state.lost
    if state.does == YIELDING:
        lost = lost + tie.yield_force * (stretch - reach - state.free)
    if state.does == YIELDING_BACK:
        lost = lost + tie.yield_force * (state.free - (stretch + reach))
    return lost
