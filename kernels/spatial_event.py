"""Second-order contact step of one rigid block in space, for one precision and kind of motion.

The scheme is that of event.py, in the frame of the base, for mass 1: position x and velocity v of
the centre of mass, attitude, angular velocity w with L = I w in the axes of the base. One step of
length d:

    1. mean motion v_m = v - dV/2 - g d/2 + sum p / 2, I_m w_m = L + sum r x p / 2, with I_m and
       the corners in the attitude turned on by w d / 2, dV the change of the base velocity in the
       step, impulses p such that v_m and w_m obey the contact law (spatial_event_contact.py);
    2. attitude turned by d w_m, x moved by d v_m, v = 2 v_m - v, L = 2 I_m w_m - L; what touches is
       put back on the base and, where it sticks, along it (this removes the drift). In flight the
       turn is that of spatial.turn_freely: it keeps L to the last bit, the energy within a bound;
    3. if inside the step an open corner lands, a sliding corner stops, a resting block lifts or the
       block has overturned, nothing is taken: the next step ends there;
    4. v and w are projected on the contacts at the end of the step, along their force. Where
       corners land or the base steps its velocity this is the inelastic impact with friction.

In a plane this is event.py, step by step. What holds beyond it:

- Corners within `TOGETHER` of the base at an impact take part in it. Without that, of two corners
  of an edge that differ by round-off one would land first, the other a moment later, and what
  follows a blow on one corner is not what follows a blow on an edge. Apart by more they land one
  after the other, as rigid corners do.
- A corner that after an impact would rise by less than its part of `rest_gap` before it comes back
  is closed at once, so that blows that follow one another ever faster end.
- Where an edge lets go of one end, which slides or opens, the friction across the edge that held it
  ends with a jump: that is located. Where corners open or start to slide otherwise forces go on
  without a jump, and need not be.
- Second order holds while corners stick, slide straight, or turn their way slowly; a corner's last
  step before it stops on a curved way may be of first order.
"""

from typing import Any

import warp as wp

from warprock.kernels.instance import kernel_module

real: Any
PRECISION: str
MOTION: str

scalar = kernel_module("scalar", precision=PRECISION)
motion = kernel_module("motion", precision=PRECISION, motion=MOTION)
event = kernel_module("event", precision=PRECISION, motion=MOTION)
spatial = kernel_module("spatial", precision=PRECISION)
contact = kernel_module("spatial_event_contact", precision=PRECISION)
wp.set_module_options(contact.OPTIONS)
slide = kernel_module("spatial_event_slide", precision=PRECISION)
law = kernel_module("spatial_event_law", precision=PRECISION)
moves = kernel_module("spatial_event_moves", precision=PRECISION)
larger, smaller, size = scalar.larger, scalar.smaller, scalar.size
Motion, series = motion.Motion, motion.series
knot_time, knot_step = motion.knot_time, motion.knot_step
base_change, first_root = event.base_change, event.first_root
Block, Body, Held = spatial.Block, contact.Body, contact.Held
Three, Four, Corners, Shares = contact.Three, moves.Four, contact.Corners, contact.Shares
mask_of, stance_of, corner_velocity = contact.mask_of, contact.stance_of, contact.corner_velocity
settled, guessed = law.settled, law.guessed
stuck, along = contact.stuck, contact.along
slid, swung = slide.slid, slide.swung
turned, body_at, flown, levelled = moves.turned, moves.body_at, moves.flown, moves.levelled
foot, placed, least_spare = moves.foot, moves.placed, moves.least_spare
corner_event, stop_event = moves.corner_event, moves.stop_event
EDGE, FLAT, FLYING = contact.EDGE, contact.FLAT, contact.FLYING

RUNNING = 0
OVERTURNED = 1
BROKEN = 2
STALLED = 3
UNSETTLED = 4

HALF = real(0.5)
TWO = real(2.0)
TEN = real(10.0)
TINY = contact.TINY
NEVER = real(1.0e30)
NEARLY = real({"float64": 1.0e-7, "float32": 1.0e-4}[PRECISION])
"""Part of the longest step by which the time of an event may be missed."""
TOGETHER = real({"float64": 1.0e-7, "float32": 1.0e-4}[PRECISION])
"""Gap, as a part of the half height, up to which corners take part in an impact elsewhere."""
DUST = real({"float64": 1.0e-12, "float32": 1.0e-5}[PRECISION])
"""Round-off of a velocity, as a part of the largest."""
SOON = real(1.0e-3)
"""Part of a step by which an uplift may be missed: the error is of its square."""
SHARP = real({"float64": 1.0e-5, "float32": 1.0e-3}[PRECISION])
"""Part of the longest step by which an edge may let go of an end late: the error is of that."""
PROBE = real({"float64": 1.0e-4, "float32": 1.0e-2}[PRECISION])
"""Length of a moment, as a part of the longest step."""
REACH = real(0.125)
"""Largest rotation in one step [rad]: keeps the polynomials in their range."""

Knots = wp.types.vector(length=3, dtype=int)
"""Knots of the motion passed, along x, y and z."""


@wp.struct
class Limits:
    """What a step needs to know of one lane besides its block: see the head of this file."""

    gravity: real
    longest_step: real
    rest_gap: real


@wp.struct
class State:
    """State of one lane.

    Position, attitude, velocity and angular velocity; turn in the last step [rad], and angular
    velocity at its end before its impact, swing; stance and slip, see
    spatial_event_contact.py; time [s]; knots of the motion passed; base velocity [m/s]; cap, the
    longest next step [s]; mode; lost energy for unit mass [J/kg]; deepest, how deep a corner was
    in the base before it was put back [m]; impacts; taken, whether the last trial was a step.
    """

    x: Three
    q: Four
    v: Three
    w: Three
    turn: Three
    swing: Three
    stance: int
    slip: int
    time: real
    knots: Knots
    base: Three
    cap: real
    mode: int
    lost: real
    deepest: real
    impacts: int
    taken: bool


@wp.struct
class Base:
    """What the base does in a step.

    Change of its velocity and velocity step at the end [m/s]; acceleration at both ends [m/s^2];
    knots passed after it; length d and end of the step [s].
    """

    change: Three
    kick: Three
    first: Three
    last: Three
    knots: Knots
    d: real
    time: real


@wp.func
def kinetic_energy(body: Body, v: Three, w: Three) -> real:
    """Kinetic energy for unit mass in the frame of the base [J/kg]."""
    return HALF * (wp.dot(v, v) + wp.dot(w, body.inertia * w))


@wp.func
def next_step(
    limits: Limits, mx: Motion, my: Motion, mz: Motion, value: Three, slope: Three, end: real,
    s: State,
) -> Base:  # fmt: skip
    """Length of the next step, to a knot or the end at most, and what the base does in it."""
    zero = real(0.0)
    b = Base()
    tx = knot_time(mx, s.knots[0])
    ty = knot_time(my, s.knots[1])
    tz = knot_time(mz, s.knots[2])
    target = smaller(smaller(tx, ty), smaller(tz, end))
    room = larger(target - s.time, zero)
    d = smaller(smaller(limits.longest_step, REACH / (wp.length(s.w) + TINY)), s.cap)
    quiet = (
        (s.knots[0] == 0 or tx >= NEVER)
        and (s.knots[1] == 0 or ty >= NEVER)
        and (s.knots[2] == 0 or tz >= NEVER)
    )
    # At rest on a base that will not move the block waits at once.
    d = smaller(wp.where(s.stance == FLAT and s.slip == 0 and quiet, room, d), room)
    b.d = d
    b.time = wp.where(d >= room, target, s.time + d)
    b.knots = s.knots
    b.kick = Three()
    if b.time >= tx:
        b.knots[0] = s.knots[0] + 1
        b.kick[0] = knot_step(mx, s.knots[0])
    if b.time >= ty:
        b.knots[1] = s.knots[1] + 1
        b.kick[1] = knot_step(my, s.knots[1])
    if b.time >= tz:
        b.knots[2] = s.knots[2] + 1
        b.kick[2] = knot_step(mz, s.knots[2])
    ax, jx, _a2, _a3, _a4, _a5, _a6, _a7, _a8 = series(mx, s.knots[0], b.time, value[0], slope[0])
    ay, jy, _b2, _b3, _b4, _b5, _b6, _b7, _b8 = series(my, s.knots[1], b.time, value[1], slope[1])
    az, jz, _c2, _c3, _c4, _c5, _c6, _c7, _c8 = series(mz, s.knots[2], b.time, value[2], slope[2])
    b.last = Three(ax, ay, az)
    b.change = Three(
        base_change(mx, b.time, d, ax, jx, s.base[0], b.kick[0]),
        base_change(my, b.time, d, ay, jy, s.base[1], b.kick[1]),
        base_change(mz, b.time, d, az, jz, s.base[2], b.kick[2]),
    )
    b.first = b.change * (TWO / larger(d, TINY)) - b.last
    return b


@wp.func
def directions(body: Body, v: Three, w: Three) -> Corners:
    """Directions in which the corners move along the base."""
    dirs = Corners()
    for k in range(4):
        d = along(corner_velocity(body, v, w, k))
        dirs[k] = Three(d[0], d[1], real(0.0))
    return dirs


@wp.func
def bound(body: Body, stance: int, slip: int, v: Three, w: Three):
    """Velocities projected on the contacts, along their force."""
    v1 = v
    w1 = w
    mask = mask_of(stance)
    if stance != FLYING and slip == 0:
        v1, w1 = stuck(body, stance, v, w)
    elif stance < FLAT and slip == mask:
        v1, w1, _n, _sound = slid(
            body, stance, body.friction, directions(body, v, w), Shares(), v, w
        )
    elif stance < FLAT:
        k = stance % 4
        first = slip == 1 << k
        other = (k + 1) % 4
        pinned = wp.where(first, other, k)
        slides = wp.where(first, k, other)
        u = corner_velocity(body, v, w, slides) - corner_velocity(body, v, w, pinned)
        way = body.corners[slides] - body.corners[pinned]
        side = wp.where(way[0] * u[1] < way[1] * u[0], real(-1.0), real(1.0))
        v1, w1, _m, _d, _good = swung(body, pinned, slides, side, v, w)
    elif stance == FLAT:
        v1 = Three(v[0], v[1], real(0.0))
        w1 = Three(real(0.0), real(0.0), w[2])
    return v1, w1


@wp.func
def closed(block: Block, limits: Limits, s: State, body: Body, mask: int) -> State:
    """The state with corners closed that hardly rise; no time passes."""
    n = s
    n.stance = stance_of(mask)
    n.q = levelled(block, s.q, n.stance)
    now = body_at(block, n.q)
    pinned = mask_of(s.stance)
    n.x = placed(now, mask_of(n.stance), s.x + foot(body, pinned) - foot(now, pinned))
    n.slip = wp.where(s.slip == 0, 0, mask_of(n.stance))
    smooth = now
    # What closes without an impact closes without friction: no energy comes of it.
    smooth.friction = real(0.0)
    v1, w1 = bound(smooth, n.stance, n.slip, s.v, s.w)
    n.v = v1
    n.w = w1
    n.lost = s.lost + kinetic_energy(body, s.v, s.w) - kinetic_energy(now, n.v, n.w)
    n.turn = Three()
    n.swing = n.w
    n.cap = NEVER
    n.taken = True
    return n


@wp.func
def arrived(
    block: Block, limits: Limits, s: State, reached: State, base: Base, lands: int, grain: real
) -> State:
    """The state at the end of a step: velocities after its impact, or projected on the contacts."""
    n = reached
    body = body_at(block, n.q)
    mask = mask_of(n.stance)
    struck = lands != 0
    for axis in range(3):
        struck = struck or (base.kick[axis] != real(0.0) and mask != 0)
    v1, w1 = bound(body, n.stance, n.slip, n.v, n.w)
    v = v1 - base.kick
    n.v = v
    n.w = w1
    if struck:
        mask = mask | lands
        for k in range(4):
            if n.x[2] + body.corners[k, 2] <= TOGETHER * block.height:
                mask = mask | (1 << k)
        touch = stance_of(mask)
        pinned = mask_of(n.stance)
        n.q = levelled(block, n.q, touch)
        now = body_at(block, n.q)
        n.x = placed(now, mask_of(touch), n.x + foot(body, pinned) - foot(now, pinned))
        h = settled(now, touch, 0, Corners(), v, n.w, grain)
        n.lost = n.lost + kinetic_energy(now, v, n.w) - kinetic_energy(now, h.v, h.w)
        n.v = h.v
        n.w = h.w
        n.stance = h.stance
        n.slip = h.slip
        n.mode = wp.where(h.fits, n.mode, UNSETTLED)
        n.impacts = s.impacts + wp.where(lands != 0, 1, 0)
    return n


@wp.func
def probed(
    block: Block, limits: Limits, q: Four, v: Three, w: Three, stance: int, slip: int, a: Three
) -> Held:
    """The motion if it goes on as it is for a moment, its `spare` for unit time."""
    d = PROBE * limits.longest_step
    now = body_at(block, q)
    soon = body_at(block, turned(q, w * (HALF * d)))
    pull = a + Three(real(0.0), real(0.0), limits.gravity)
    free = soon.inverse * (now.inertia * w)
    h = guessed(soon, stance, slip, directions(now, v, w), v - HALF * d * pull, free, real(0.0))
    h.spare = h.spare / d
    return h


@wp.func
def let_go(block: Block, limits: Limits, s: State, reached: State, base: Base, h: Held) -> real:
    """Length of the step to where an edge lets go of one of its ends, if that lies inside.

    What pushed there across the edge ends with a jump. What the end has to spare is known in the
    middle of the step; moments of next to no length tell it at its start or its end. A line between
    two of them says where nothing is left.
    """
    d = base.d
    sharp = SHARP * limits.longest_step
    middle = h.spare / larger(d, TINY)
    cut = TWO * NEVER
    if h.turns and d > sharp:
        first = probed(block, limits, s.q, s.v, s.w, s.stance, s.slip, base.first)
        there = HALF * d * first.spare / (first.spare - middle)
        cut = wp.where(first.spare > real(0.0) and there > sharp, there, cut)
    if not h.turns and d > sharp and reached.stance == s.stance and reached.slip == s.slip:
        body = body_at(block, reached.q)
        v, w = bound(body, reached.stance, reached.slip, reached.v, reached.w)
        last = probed(block, limits, reached.q, v, w, s.stance, s.slip, base.last)
        there = HALF * d * (real(1.0) + middle / (middle - last.spare))
        cut = wp.where(last.turns and there < d - sharp, there, cut)
    return cut


@wp.func
def capped(s: State, cut: real, d: real, near: real) -> State:
    """The old state where an event lies inside a step, its next step ending there.

    Not shorter than what is near: what is left of the way then counts as arrived. An event at the
    very end of the step would be met there for ever.
    """
    n = s
    n.cap = larger(wp.where(cut > d - near, HALF * d, cut), HALF * near)
    n.taken = False
    return n


@wp.func
def watched(
    block: Block, limits: Limits, s: State, reached: State, base: Base, body0: Body, h: Held,
    grain: real,
) -> State:  # fmt: skip
    """The state after the events of a step, or the old one if one of them lay inside."""
    near = NEARLY * limits.longest_step
    dust = moves.GRAIN * block.height
    n = reached
    body = body_at(block, n.q)
    cut = TWO * NEVER
    fastest = real(0.0)
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
        elif (n.slip & s.slip & bit) != 0:
            there, stops = stop_event(u0, u1, base.d, near)
            cut = smaller(cut, there)
            n.slip = n.slip - wp.where(stops, bit, 0)
        fastest = larger(fastest, wp.sqrt(u1[0] * u1[0] + u1[1] * u1[1]))
    # A flat block that hardly moves stops as a whole.
    if n.stance == FLAT and fastest <= TEN * near * limits.gravity:
        n.slip = 0
    resting = s.stance == FLAT and s.slip == 0
    if resting:
        e0, e1 = least_spare(body0, limits.gravity, base.first, base.last)
        if e1 < -SOON * e0 and e0 > -SOON * e1:
            cut = smaller(cut, first_root(e0, (e1 - e0) / base.d, e1, base.d))
    on_edge = s.stance >= EDGE and s.stance < FLAT and s.slip != touched
    if on_edge and lands == 0 and cut >= NEVER:
        cut = let_go(block, limits, s, n, base, h)
    axis = upright(body)
    fall = wp.cross(n.w, axis)[2]
    e1 = axis[2] - near * size(fall)
    if e1 < -near * size(fall) and base.d > near:
        axis0 = upright(body0)
        e0 = larger(axis0[2] - near * size(fall), real(0.0))
        cut = smaller(cut, first_root(e0, wp.cross(s.w, axis0)[2], e1, base.d))
    inside = closes == 0 and cut < NEVER and base.d > near
    if closes != 0:
        n = closed(block, limits, s, body0, touched | closes)
    if inside:
        n = capped(s, cut, base.d, near)
    if closes == 0 and not inside:
        n = arrived(block, limits, s, n, base, lands, grain)
        n.mode = wp.where(axis[2] <= TWO * near * size(fall), OVERTURNED, n.mode)
    return n


@wp.func
def upright(body: Body) -> Three:
    """The block's axis."""
    return wp.normalize(
        wp.cross(body.corners[1] - body.corners[0], body.corners[3] - body.corners[0])
    )


@wp.func
def step(
    block: Block, limits: Limits, mx: Motion, my: Motion, mz: Motion, value: Three, slope: Three,
    end: real, s: State,
) -> State:  # fmt: skip
    """One trial step of one lane, at most to its next knot or to `end`.

    The state after it, unchanged but for `cap` where an event lay inside.
    """
    b = next_step(limits, mx, my, mz, value, slope, end, s)
    d = b.d
    body0 = body_at(block, s.q)
    momentum = body0.inertia * s.w
    flying = s.stance == FLYING
    q = turned(s.q, s.w * (HALF * d))
    if flying:
        q = flown(block, s.q, momentum, HALF * d)
    middle = body_at(block, q)
    v = s.v - HALF * b.change - Three(real(0.0), real(0.0), HALF * d * limits.gravity)
    w = middle.inverse * momentum
    speed = wp.length(s.v) + wp.length(s.w) * block.height + limits.gravity * limits.longest_step
    grain = DUST * speed
    h = Held()
    h.v = s.v
    h.w = s.w
    h.stance = s.stance
    h.slip = s.slip
    h.fits = True
    # A step without length, to a knot at the present time, changes nothing.
    if d > TINY:
        h = settled(middle, s.stance, s.slip, directions(body0, s.v, s.w), v, w, grain)
    n = s
    n.q = turned(s.q, d * h.w)
    if flying:
        n.q = flown(block, s.q, momentum, d)
    n.q = levelled(block, n.q, h.stance)
    body = body_at(block, n.q)
    held = mask_of(h.stance)
    n.stance = h.stance
    n.slip = h.slip
    n.x = s.x + d * h.v
    raw = n.x[2]
    if h.slip == 0 and held != 0:
        pinned = foot(body0, held) - foot(body, held)
        n.x = Three(s.x[0] + pinned[0], s.x[1] + pinned[1], raw)
    n.x = placed(body, held, n.x)
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
    n.mode = wp.where(h.fits, s.mode, UNSETTLED)
    low = real(0.0)
    for k in range(4):
        low = smaller(low, raw + body.corners[k, 2])
    n = watched(block, limits, s, n, b, body0, h, grain)
    if n.time > s.time:
        n.deepest = larger(s.deepest, -low)
    sound = wp.length(n.x) + wp.length(n.q) + wp.length(n.v) + wp.length(n.w) + n.time
    n.mode = wp.where(sound - sound == real(0.0), n.mode, BROKEN)
    return n
