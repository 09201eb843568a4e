"""Contact step of a stack of blocks in space, impacts located.

The scheme is that of event_space/block/step.py for all blocks at once, in the frame of the base,
with one clock a lane. One step of length d:

    1. the pose d/2 ahead. Its contacts are those that touched at the start, within `rest_gap`
       (event_space/stack/contact.py). The mean motion is v_m = v - dV/2 - g d/2 + sum p / (2 m),
       I_m w_m = L + sum r x p / 2, such that v_m and w_m obey the contact law at all interfaces;
    2. attitudes turned by d w_m, x moved by d v_m, v = 2 v_m - v, L = 2 I_m w_m - L. A block
       without contacts flies, see `turn_freely` in shape_space/block.py;
    3. if inside the step a corner lands, hops by more than `rest_gap`, or slides to a stop, the
       step is not taken: the next one ends there. A corner has landed within `rest_gap` of the
       face. A contact that leaves or slides back slowly does neither, see `LEFT_OUT` in
       event_space/stack/look.py;
    4. the gaps of contacts that pushed are closed, which removes the drift. v and w are projected
       on these contacts: one that stuck does not move, one that slid neither leaves nor approaches.
       If corners landed or the base steps its velocity, an impact with friction of all contacts
       follows: inelastic, or with a restitution (event_space/stack/bounce.py). What a step of the
       base does is the limit of a steep ramp, see `solve_impact` in event_space/stack/solve.py.

A stack whose mean motion from rest is round-off stands still: its pose keeps every bit. On a base
at rest it waits in one step.

Before all that, a stack whose blocks move as one, or stand still, takes the step of one body where
nothing happens in it (event_space/stack/whole.py).

The beginning of slips and the opening of contacts are not located. A contact that sticks in the
mean of a step stops at its end.
"""

import warp as wp

from warprock.kernels.algebra.vectors import Vector
from warprock.kernels.event_space.block.contact import FLAT, FLYING
from warprock.kernels.event_space.block.moves import rotate_attitude
from warprock.kernels.event_space.block.trial import Base, next_step
from warprock.kernels.event_space.block.trial import State as BlockState
from warprock.kernels.event_space.lane import BaseMotion, Limits
from warprock.kernels.event_space.stack.contact import (
    CONE,
    Ints,
    Own,
    Pose,
    Touches,
    block_of,
    pose_of,
    sticking_bits,
)
from warprock.kernels.event_space.stack.look import (
    LEFT_OUT,
    NEARLY,
    Kept,
    Look,
    State,
    attitudes_after,
    contacts_at_end,
    continue_contacts,
    energy,
    find_stop,
    laws_of_velocity,
    look_at_step,
    momenta,
)
from warprock.kernels.event_space.stack.solve import ROUNDS, solve, solve_impact
from warprock.kernels.event_space.stack.whole import Whole, roll, state_after
from warprock.kernels.lane.modes import BROKEN, OVERTURNED, RUNNING, SLID_OFF, UNSOLVED
from warprock.kernels.shape_space.frame import frame, rotate_diagonal
from warprock.kernels.shape_space.stack import Bodies, Points, rows_of

if BOUNCES:
    from warprock.kernels.event_space.stack.bounce import bounce

STILL = by_precision(1.0e-10, 1.0e-4)
"""Velocity that counts as zero, as a part of the velocity that gravity gives in a step."""
BINDING = 12
"""Largest number of Newton rounds that close gaps and project velocities in a step; the next step
does the rest."""


TRIES = 4
"""Number of trials in a row that end at an event; then a step is halved. Where a corner of an
overlap comes and goes its gap jumps, and no root of its gaps at both ends is the event."""
LEAST = real(1.0 / 256.0)
"""A step whose contacts were not solved is halved down to this part of the longest step."""


@wp.struct
class Mean:
    """Mean motion of a step, and its contacts.

    Velocities [m/s] and angular velocities [rad/s]; spin, angular momenta at the start for unit
    mass [m^2/s]; held, slots that push, and slots that stick, by interface.
    """

    v: Bodies
    w: Bodies
    spin: Bodies
    held: Ints
    stuck: Ints


@wp.func
def forces_after(t: Touches, pose: Pose, p: Points, gravity: real) -> Kept:
    """A guess of the forces after an impact [N]: its impulses, in sum as large as at rest."""
    found, push, load = Kept(), real(0.0), real(0.0)
    bodies = int(BLOCKS + 1)
    for k in range(1, bodies):
        # All interfaces below a block carry it.
        load += real(k) * gravity / pose.light[k]
    for i in range(t.total):
        push += p[i][2]
    for i in range(t.total):
        found[16 * (t.body[i] - 1) + t.slot[i]] = p[i] * (load / larger(push, TINY))
    return found


@wp.func
def end_step(
    own: Own, limits: Limits, reached: State, pose: Pose, seen: Look, b: Base, held: Ints,
    stuck: Ints,
) -> State:  # fmt: skip
    """The state at the end of a step: gaps closed, velocities projected, after its impact."""
    n = reached
    look = seen
    zero = Bodies()
    bodies = int(BLOCKS + 1)
    gravity = limits.gravity
    t = contacts_at_end(own, pose, look, held)
    _p, shift, turn, _good = solve(BINDING, t, pose, Points(), zero, zero, zero, zero)
    for k in range(1, bodies):
        n.x[k] = n.x[k] + shift[k]
        n.q[k] = rotate_attitude(n.q[k], turn[k])
    t = laws_of_velocity(t, look, stuck)
    _q, v, w, _bound = solve(BINDING, t, pose, Points(), n.v, n.w, n.v, n.w)
    n.lost = n.lost - energy(own, gravity, n.x, n.q, v, w)
    struck = look.landed
    for axis in range(3):
        struck = struck or b.kick[axis] != real(0.0)
    fits = bool(True)
    if struck:
        for k in range(1, bodies):
            v[k] = v[k] - b.kick
        before = energy(own, gravity, n.x, n.q, v, w)
        for i in range(t.total):
            t.law[i] = CONE
        if BOUNCES:
            v1, w1, left, fits = bounce(own.rebound, t, pose, v, w, wp.length(b.kick))
            for k in range(1, bodies):
                look.touch[k] = look.touch[k] & ~left[k]
                look.closed = look.closed and left[k] == 0
        else:
            p, v1, w1, fits = solve_impact(t, pose, v, w, wp.length(b.kick))
            if look.landed:
                n.force = forces_after(t, pose, p, gravity)
        n.lost = n.lost + before - energy(own, gravity, n.x, n.q, v1, w1)
        # The base's work on the blocks is at the mean of both velocities: see account.py.
        for k in range(1, bodies):
            n.lost = n.lost - HALF * block_of(own, k).mass * wp.dot(b.kick, v1[k] - v[k])
        v = v1
        w = w1
    n.v = v
    n.w = w
    n.mode = wp.where(fits, n.mode, UNSOLVED)
    n.impacts = n.impacts + wp.where(look.landed, 1, 0)
    for k in range(1, bodies):
        above = wp.where(k < BLOCKS, look.touch[wp.min(k + 1, BLOCKS)], 0)
        n.flies[k] = wp.where(look.touch[k] == 0 and above == 0, 1, 0)
    n.there = look.there
    n.touch = look.touch
    n.closed = look.closed
    return n


@wp.func
def stands_still(own: Own, v: Bodies, w: Bodies, bound: real) -> bool:
    """Whether all blocks are slower than a bound [m/s]."""
    fastest = real(0.0)
    bodies = int(BLOCKS + 1)
    for k in range(1, bodies):
        turns = wp.length(w[k]) * block_of(own, k).half_height
        fastest = larger(fastest, wp.length(v[k]) + turns)
    return fastest <= bound


@wp.func
def mode_of(s: State) -> int:
    """Mode of a lane at the end of a step."""
    mode = s.mode
    sums = s.time + s.lost
    bodies = int(BLOCKS + 1)
    for k in range(1, bodies):
        up, below = frame(s.q[k]), frame(s.q[k - 1])
        lean = up[0, 2] * below[0, 2] + up[1, 2] * below[1, 2] + up[2, 2] * below[2, 2]
        over = smaller(up[2, 2], lean) <= real(0.0)
        found = wp.where(s.there[k] == 0, SLID_OFF, RUNNING)
        found = wp.where(over, OVERTURNED, found)
        mode = wp.where(mode == RUNNING, found, mode)
        sums = sums + wp.length(s.x[k]) + wp.length(s.v[k]) + wp.length(s.w[k]) + lean
    return wp.where(sums - sums == real(0.0), mode, BROKEN)


@wp.func
def next_step_of_stack(limits: Limits, motion: BaseMotion, end: real, s: State) -> Base:
    """The next step, and the motion of the base in it: as `next_step` of a single block."""
    p = BlockState()
    p.time = s.time
    p.knots = s.knots
    p.base = s.base
    p.cap = s.cap
    p.stance = wp.where(s.still, FLAT, FLYING)
    bodies = int(BLOCKS + 1)
    for k in range(1, bodies):
        if wp.length(s.w[k]) > wp.length(p.w):
            p.w = s.w[k]
    return next_step(limits, motion, end, p)


@wp.func
def retry_step(s: State, cut: real, d: real, near: real) -> State:
    """The state before the step; its next step ends at an event, and is not shorter than `near`."""
    n = s
    n.tries = s.tries + 1
    late = cut > d - near or n.tries > TRIES
    n.cap = larger(wp.where(late, HALF * d, cut), HALF * near)
    n.still = False
    n.taken = False
    return n


@wp.func
def integrate(
    own: Own, limits: Limits, s: State, begun: State, b: Base, pose0: Pose, pose: Pose, mean: Mean
) -> State:
    """The end of a step by its mean motion, or the old state if an event lies inside.

    `pose0` is the pose at the start of the step, `pose` that in its middle.
    """
    n = begun
    d, vm, wm, spin, held, stuck = b.d, mean.v, mean.w, mean.spin, mean.held, mean.stuck
    bodies = int(BLOCKS + 1)
    work, energy_before = real(0.0), energy(own, limits.gravity, s.x, s.q, s.v, s.w)
    n.q = attitudes_after(own, s, spin, wm, d)
    last = pose_of(own, s.x + d * vm, n.q)
    n.x = last.x
    for k in range(1, bodies):
        block = block_of(own, k)
        work = work - block.mass * wp.dot(vm[k], b.change)
        n.v[k] = TWO * vm[k] - s.v[k]
        mid = rotate_diagonal(
            wp.transpose(rows_of(pose.axes, k)), real(1.0) / block.inverse_x,
            real(1.0) / block.inverse_y, real(1.0) / block.inverse_z,
        )  # fmt: skip
        reached = wp.where(s.flies[k] != 0, spin[k], TWO * (mid * wm[k]) - spin[k])
        n.w[k] = block.mass * (rows_of(last.ease, k) * reached)
        n.turn[k] = d * wm[k]
    look = look_at_step(own, limits, s, n, pose0, last, held, d)
    if look.cut < NEVER:
        again = retry_step(s, look.cut, d, NEARLY * limits.longest_step)
        again.force = n.force
        return again
    n.lost = s.lost + energy_before + work
    n.deepest = larger(s.deepest, look.deepest)
    n = end_step(own, limits, n, last, look, b, held, stuck)
    n.mode = mode_of(n)
    return n


@wp.func
def advance_clock(s: State, b: Base) -> State:
    """The state after the time of a step in which no block moves."""
    n = s
    n.time = b.time
    n.knots = b.knots
    n.base = s.base + b.change + b.kick
    n.cap = NEVER
    n.tries = 0
    n.taken = True
    n.whole = False
    return n


@wp.func
def step(
    own: Own, limits: Limits, motion: BaseMotion, end: real, on: wp.ref[Whole], s: State
) -> State:  # fmt: skip
    """One trial step of one lane, at most to its next knot or to `end`.

    Returns the state after it. If an event lies inside, that is the old state with a new `cap`.
    `on` is the stack as one body, if it is one.
    """
    b = next_step_of_stack(limits, motion, end, s)
    if on.holds and b.d > TINY and wp.length_sq(b.kick) == real(0.0):
        easy = roll(own, limits, on, b, s)
        if easy.cut < NEVER:
            return retry_step(s, easy.cut, b.d, NEARLY * limits.longest_step)
        if easy.clear:
            n = advance_clock(s, b)
            if on.turns:
                n = state_after(on, n, easy)
            n.whole = True
            return n
    n = any_step(own, limits, s, b)
    return n


@wp.func(inline=False)
def any_step(own: Own, limits: Limits, s: State, b: Base) -> State:
    """One trial step with any events."""
    d, near = b.d, NEARLY * limits.longest_step
    bodies = int(BLOCKS + 1)
    spin = momenta(own, s)
    pose0 = pose_of(own, s.x, s.q)
    middle = s.x
    v, w, held, stuck, first = Bodies(), Bodies(), Ints(), Ints(), Points()
    for k in range(1, bodies):
        middle[k] = s.x[k] + (HALF * d) * s.v[k]
        fall = Vector(real(0.0), real(0.0), HALF * d * limits.gravity)
        v[k] = s.v[k] - HALF * b.change - fall
    pose = pose_of(own, middle, attitudes_after(own, s, spin, s.w, HALF * d))
    for k in range(1, bodies):
        w[k] = block_of(own, k).mass * (rows_of(pose.ease, k) * spin[k])
    t = continue_contacts(own, s, pose0, pose, limits.rest_gap)
    for i in range(t.total):
        first[i] = HALF * d * s.force[16 * (t.body[i] - 1) + t.slot[i]]
    p, vm, wm, good = solve(ROUNDS, t, pose, first, v, w, s.v, s.w)
    if not good:
        if d > LEAST * limits.longest_step:
            return retry_step(s, HALF * d, d, near)
        p, vm, wm, good = solve_impact(t, pose, v, w, real(0.0))
    stop = find_stop(t, pose, p, s, vm, wm, LEFT_OUT * limits.gravity * limits.longest_step)
    if stop * d < d - near:
        return retry_step(s, stop * d, d, near)
    n = advance_clock(s, b)
    n.force = Kept()
    for i in range(t.total):
        k, bit = t.body[i], 1 << t.slot[i]
        n.force[16 * (k - 1) + t.slot[i]] = p[i] * (TWO / larger(d, NEARLY * near))
        held[k] = held[k] | wp.where(p[i][2] > real(0.0), bit, 0)
        stuck[k] = stuck[k] | sticking_bits(t.slot[i], pose.friction[k], p[i])
    n.mode = wp.where(good, s.mode, UNSOLVED)
    slow = STILL * limits.gravity
    stands = stands_still(own, s.v, s.w, slow * limits.longest_step)
    stands = stands and s.closed and stands_still(own, vm, wm, slow * d)
    if stands:
        vm = Bodies()
        wm = Bodies()
    elif d > limits.longest_step:
        return retry_step(s, limits.longest_step, d, near)
    n.still = stands and wp.length(b.kick) == real(0.0)
    if n.still:
        n.v = Bodies()
        n.w = Bodies()
        return n
    return integrate(own, limits, s, n, b, pose0, pose, Mean(vm, wm, spin, held, stuck))
