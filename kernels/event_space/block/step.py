"""Second-order contact step of one rigid block in space.

The scheme is that of event/block/step.py, in the frame of the base, for mass 1: position x and
velocity v of the centre of mass, attitude, angular velocity w with L = I w in the axes of the base.
One step of length d:

    1. mean motion v_m = v - dV/2 - g d/2 + sum p / 2, I_m w_m = L + sum r x p / 2. dV is the change
       of the base velocity in the step; I_m and the corners are those of the attitude turned on by
       w d / 2. The impulses p are such that v_m and w_m obey the contact law
       (event_space/block/contact.py);
    2. attitude turned by d w_m, x moved by d v_m, v = 2 v_m - v, L = 2 I_m w_m - L; what touches is
       put back on the base and, where it sticks, along it (this removes the drift). In flight the
       turn is that of `turn_freely` in shape_space/block.py: it keeps L to the last bit, the energy
       within a bound;
    3. if inside the step an open corner lands, a sliding corner stops, a resting block lifts or the
       block overturns, the step is not taken: the next one ends there;
    4. v and w are projected on the contacts at the end of the step, along their force. Where
       corners land or the base steps its velocity this is the inelastic impact with friction.

In a plane this is event/block/step.py, step by step. What holds beyond it:

- All corners with a gap below `TOGETHER` take part in an impact. The contact law decides whether
  the impact acts on a corner, an edge or the face. Corners of an edge with larger gaps land one
  after the other, often alternately. The smaller their gaps, the closer the outcome is to that of
  an impact on the edge, so `TOGETHER` saves events and does not choose between two answers.
- A corner that would rise by less than its part of `rest_gap` after an impact is closed at once.
  This ends sequences of ever faster impacts.
- Where one end of an edge starts to slide or opens, the friction across the edge jumps to zero.
  This event is located. Where corners open or start to slide otherwise, forces do not jump, and
  these events are not located.
- The order is 2 while corners stick and while they slide, on curved paths too. It is lower where a
  sliding corner nearly stops, since its path turns ever faster there. Steps are then cut down to a
  hundredth of the longest one. The remaining error falls with the step, but not always with its
  square.
- Friction as a box has a law and an order of its own (event_space/block/box_friction.py).
"""

import warp as wp

from warprock.kernels.algebra.vectors import Vector
from warprock.kernels.event.block.step import first_root
from warprock.kernels.event_space.block.contact import (
    EDGE,
    FLAT,
    FLYING,
    Body,
    Corners,
    Held,
    corner_velocity,
    mask_of,
    sinks,
    stance_of,
)
from warprock.kernels.event_space.block.moves import (
    GRAIN,
    Course,
    block_axis,
    body_at,
    corner_event,
    cut_to,
    foot,
    least_lack,
    level_attitude,
    place_on_base,
    rotate_attitude,
    rotate_freely,
)
from warprock.kernels.event_space.block.trial import (
    Base,
    Moment,
    State,
    find_release,
    kinetic_energy,
    next_step,
    state_at,
)
from warprock.kernels.event_space.lane import LIGHTER, LIGHTEST, BaseMotion, Limits
from warprock.kernels.lane.modes import BROKEN, OVERTURNED, UNSOLVED
from warprock.kernels.shape_space.block import Block

if FRICTION == "box":
    from warprock.kernels.event_space.block.box_friction import (
        directions,
        holds_both_ends,
        moving_bits,
        project,
        sliding_bits,
        slip_after,
        solve,
    )  # fmt: skip
else:
    from warprock.kernels.event_space.block.law import (
        directions,
        holds_both_ends,
        moving_bits,
        project,
        sliding_bits,
        slip_after,
        solve,
    )  # fmt: skip

NEARLY = by_precision(1.0e-7, 1.0e-4)
"""Tolerance of the time of an event, as a part of the longest step."""
TOGETHER = by_precision(1.0e-7, 1.0e-4)
"""Gap, as a part of the half height, up to which corners take part in an impact elsewhere."""
DUST = by_precision(1.0e-12, 1.0e-5)
"""Round-off of a velocity, as a part of the largest."""
LAST = real(100.0)
"""Speed at which a flat block stops sliding, over the speed that gravity gives in the tolerance of
the time of an event."""
SOON = real(1.0e-3)
"""Tolerance of the time of an uplift, as a part of a step; the error is of its square."""


@wp.func(inline=False)
def close_corners(block: Block, s: State, body: Body, closes: int, slow: real) -> State:
    """Closes the corners `closes`, which hardly rise.

    Those that move along the base faster than `slow` [m/s] slide on.
    """
    n = s
    mask = mask_of(s.stance) | closes
    n.stance = stance_of(mask)
    n.q = level_attitude(s.q, n.stance)
    now = body_at(block, n.q)
    pinned = mask_of(s.stance)
    n.x = place_on_base(now, mask_of(n.stance), s.x + foot(body, pinned) - foot(now, pinned))
    for k in range(4):
        if (closes & (1 << k)) != 0:
            n.slip = n.slip | moving_bits(k, corner_velocity(body, s.v, s.w, k), slow)
    if n.slip != 0 and (s.slip != 0 or n.stance == FLAT):
        n.slip = sliding_bits(mask_of(n.stance))
    smooth = now
    # Without an impact a corner closes without friction, so that it adds no energy.
    smooth.friction = real(0.0)
    v_after, w_after = project(smooth, n.stance, n.slip, s.v, s.w)
    n.v = v_after
    n.w = w_after
    n.lost = s.lost + kinetic_energy(body, s.v, s.w) - kinetic_energy(now, n.v, n.w)
    n.turn = Vector()
    n.swing = n.w
    n.cap = NEVER
    n.taken = True
    return n


@wp.func(inline=False)
def solve_impact(body: Body, touch: int, v: Vector, w: Vector, kick: real, dust: real) -> Held:
    """The motion after an impact; one by a velocity step of the base is the limit of a steep ramp.

    In a ramp the weight acts, too. It is all there is at first, and counts ever less beside the
    acceleration of the base. So the impact is solved with weights that fall from the velocity step
    `kick` [m/s] to next to nothing, then without, each time from the state of the one before.
    """
    h = Held()
    h.stance = touch
    start, weight, good = Corners(), real(kick), bool(True)
    while weight > LIGHTEST * kick and good:
        last = solve(
            body, h.stance, h.slip, start, v - Vector(real(0.0), real(0.0), weight), w, dust
        )
        good = last.fits and not sinks(body, last.v, last.w, mask_of(touch), dust)
        if good:
            h = last
            start = directions(body, last.v, last.w)
        weight = LIGHTER * weight
    h = solve(body, h.stance, h.slip, start, v, w, dust)
    if not h.fits or sinks(body, h.v, h.w, mask_of(touch), dust):
        h = solve(body, touch, 0, Corners(), v, w, dust)
    return h


@wp.func
def end_step(
    block: Block, s: State, reached: State, body: Body, base: Base, lands: int, grain: real
) -> State:
    """The state at the end of a step: velocities after its impact, or projected on the contacts."""
    n = reached
    mask = mask_of(n.stance)
    struck = lands != 0
    for axis in range(3):
        struck = struck or (base.kick[axis] != real(0.0) and mask != 0)
    v_after, w_after = project(body, n.stance, n.slip, n.v, n.w)
    v = v_after - base.kick
    n.v = v
    n.w = w_after
    if struck:
        mask = mask | lands
        for k in range(4):
            if n.x[2] + body.corners[k, 2] <= TOGETHER * block.half_height:
                mask = mask | (1 << k)
        touch = stance_of(mask)
        pinned = mask_of(n.stance)
        n.q = level_attitude(n.q, touch)
        now = body_at(block, n.q)
        n.x = place_on_base(now, mask_of(touch), n.x + foot(body, pinned) - foot(now, pinned))
        h = solve_impact(now, touch, v, n.w, wp.length(base.kick), grain)
        n.lost = n.lost + kinetic_energy(now, v, n.w) - kinetic_energy(now, h.v, h.w)
        # The base's work on the block is at the mean of both velocities: see account.py.
        n.lost = n.lost - HALF * wp.dot(base.kick, h.v - v)
        n.v = h.v
        n.w = h.w
        n.stance = h.stance
        n.slip = h.slip
        n.mode = wp.where(h.fits, n.mode, UNSOLVED)
        n.impacts = s.impacts + wp.where(lands != 0, 1, 0)
    return n


@wp.func
def retry_step(s: State, cut: real, d: real, near: real) -> State:
    """The state before the step; its next step ends at the event inside this one."""
    n = s
    n.cap = cut_to(cut, d, near)
    n.taken = False
    return n


@wp.func(inline=False)
def later_event(
    block: Block, limits: Limits, begins: wp.ref[Moment], ends: wp.ref[Moment], base: Base, h: Held,
    known: real, lands: int,
) -> real:  # fmt: skip
    """Length of the step to the first event, of those that are not landings or stops.

    These are: a resting block lifts, an edge lets go of an end, the block overturns. `known` is the
    length to the events found so far.
    """
    near = NEARLY * limits.longest_step
    cut = known
    s, reached = begins.state, ends.state
    if s.stance == FLAT and s.slip == 0:
        e0, e1 = least_lack(begins.body, limits.gravity, base.first, base.last)
        if e1 < -SOON * e0 and e0 > -SOON * e1:
            cut = smaller(cut, first_root(e0, (e1 - e0) / base.d, e1, base.d))
    on_edge = s.stance >= EDGE and s.stance < FLAT and holds_both_ends(s.stance, s.slip)
    if on_edge and lands == 0 and cut >= NEVER:
        cut = find_release(block, limits, begins, ends, base, h)
    axis = block_axis(reached.q)
    fall = wp.cross(reached.w, axis)[2]
    left = axis[2] - near * size(fall)
    if left < -near * size(fall) and base.d > near:
        axis0 = block_axis(s.q)
        e0 = larger(axis0[2] - near * size(fall), real(0.0))
        cut = smaller(cut, first_root(e0, wp.cross(s.w, axis0)[2], left, base.d))
    return cut


@wp.func
def apply_events(
    block: Block,
    limits: Limits,
    begins: wp.ref[Moment],
    ends: wp.ref[Moment],
    base: Base,
    h: Held,
    grain: real,
) -> State:
    """The state after the events at the end of a step, or the old one if an event lay inside.

    The corners that no longer slide are added to `ends`.
    """
    near = NEARLY * limits.longest_step
    dust = GRAIN * block.half_height
    s, body0 = begins.state, begins.body
    n = state_at(ends)
    body = ends.body
    slow = LAST * near * limits.gravity
    cut = TWO * NEVER
    fastest = real(0.0)
    faster = real(0.0)
    lands = int(0)
    closes = int(0)
    touched = mask_of(s.stance)
    held = mask_of(n.stance)
    for k in range(4):
        bit = 1 << k
        u0 = corner_velocity(body0, s.v, s.w, k)
        u1 = corner_velocity(body, n.v, n.w, k)
        g1 = n.x[2] + body.corners[k, 2]
        if (touched & bit) == 0:
            g0 = s.x[2] + body0.corners[k, 2]
            there, down, quiet = corner_event(
                g0, u0[2], g1, u1[2], base.d, near, dust, limits.rest_gap
            )
            cut = smaller(cut, there)
            lands = lands | wp.where(down, bit, 0)
            closes = closes | wp.where(quiet and s.stance != FLYING, bit, 0)
        elif (held & bit) == 0:
            lands = lands | wp.where(g1 <= dust and u1[2] < real(0.0), bit, 0)
        else:
            course = Course(u0, u1, base.d, near)
            end, left = slip_after(k, block.friction, limits, course, s.slip, n.slip, n.stance)
            cut = smaller(cut, end)
            n.slip = left
        fastest = larger(fastest, wp.sqrt(u1[0] * u1[0] + u1[1] * u1[1]))
        faster = larger(faster, wp.sqrt(u0[0] * u0[0] + u0[1] * u0[1]))
    # A flat block that is almost at a stop stops with all corners at once.
    slows = fastest <= slow and fastest <= faster
    if n.stance == FLAT and s.slip != 0 and slows:
        n.slip = 0
    ends.state.slip = n.slip
    cut = later_event(block, limits, begins, ends, base, h, cut, lands)
    inside = closes == 0 and cut < NEVER and base.d > near
    if closes != 0:
        n = close_corners(block, s, body0, closes, slow)
    if inside:
        n = retry_step(s, cut, base.d, near)
    if closes == 0 and not inside:
        axis = block_axis(n.q)
        over = axis[2] <= TWO * near * size(wp.cross(n.w, axis)[2])
        n = end_step(block, s, n, body, base, lands, grain)
        n.mode = wp.where(over, OVERTURNED, n.mode)
    return n


@wp.func
def integrate(block: Block, begins: wp.ref[Moment], b: Base, middle: Body, h: Held) -> Moment:
    """The end of a step by its mean motion, contacts put back on the base; before events."""
    s, body0, d = begins.state, begins.body, b.d
    n = s
    n.q = rotate_attitude(s.q, d * h.w)
    momentum = body0.inertia * s.w
    if s.stance == FLYING:
        n.q = rotate_freely(block, s.q, momentum, d)
    n.q = level_attitude(n.q, h.stance)
    body = body_at(block, n.q)
    held = mask_of(h.stance)
    n.stance = h.stance
    n.slip = h.slip
    n.x = s.x + d * h.v
    raw = n.x[2]
    if h.slip == 0 and held != 0:
        pinned = foot(body0, held) - foot(body, held)
        n.x = Vector(s.x[0] + pinned[0], s.x[1] + pinned[1], raw)
    n.x = place_on_base(body, held, n.x)
    n.v = TWO * h.v - s.v
    n.w = body.inverse * (TWO * (middle.inertia * h.w) - momentum)
    if h.stance == FLAT and h.slip == 0:
        n.q = s.q
        n.x = s.x
    n.turn = d * h.w
    n.swing = n.w
    n.lost = s.lost + TWO * h.work
    n.time = b.time
    n.knots = b.knots
    n.base = s.base + b.change + b.kick
    n.cap = NEVER
    n.taken = True
    n.mode = wp.where(h.fits, s.mode, UNSOLVED)
    low = real(0.0)
    for k in range(4):
        low = smaller(low, raw + body.corners[k, 2])
    n.deepest = larger(s.deepest, -low)
    return Moment(n, body)


@wp.func
def step(block: Block, limits: Limits, motion: BaseMotion, end: real, s: State) -> State:
    """One trial step of one lane, at most to its next knot or to `end`.

    Returns the state after it. If an event lies inside, that is the old state with a new `cap`.
    """
    b = next_step(limits, motion, end, s)
    d = b.d
    body0 = body_at(block, s.q)
    momentum = body0.inertia * s.w
    flying = s.stance == FLYING
    q = rotate_attitude(s.q, s.w * (HALF * d))
    if flying:
        q = rotate_freely(block, s.q, momentum, HALF * d)
    middle = body_at(block, q)
    v = s.v - HALF * b.change - Vector(real(0.0), real(0.0), HALF * d * limits.gravity)
    w = middle.inverse * momentum
    speed = (
        wp.length(s.v) + wp.length(s.w) * block.half_height + limits.gravity * limits.longest_step
    )
    grain = DUST * speed
    h = Held()
    h.v = s.v
    h.w = s.w
    h.stance = s.stance
    h.slip = s.slip
    h.fits = True
    # A step without length, to a knot at the present time, changes nothing.
    if d > TINY:
        dirs = Corners()
        if s.slip != 0:
            dirs = directions(body0, s.v, s.w)
        h = solve(middle, s.stance, s.slip, dirs, v, w, grain)
    begins = Moment(s, body0)
    ends = integrate(block, begins, b, middle, h)
    n = apply_events(block, limits, begins, ends, b, h, grain)
    if n.time == s.time:
        n.deepest = s.deepest
    sound = wp.length(n.x) + wp.length(n.q) + wp.length(n.v) + wp.length(n.w) + n.time
    n.mode = wp.where(sound - sound == real(0.0), n.mode, BROKEN)
    return n
