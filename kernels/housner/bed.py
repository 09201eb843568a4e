"""A rocking block on compliant ground: springs and dampers under its base that do not pull.

The ground gives each part dA of the base that is at a depth d below its surface the force
(k d + c d') dA upwards (a Winkler bed, with k a unit of area and c likewise); a part that is above
the surface is free of it. A damper acts as long as its spring is pressed, so that it may pull as
that lets go (Psycharis and Jennings 1983). The lower corner of the base does not move sideways.

With the lean phi to a side, the depth w of the corner there, the half width b, the half height h,
the mass m and the inertia I of the block about its centre, whose place from the corner is

    -A = b cos(phi) - h sin(phi) inwards,    B = b sin(phi) + h cos(phi) upwards,

a point of the base r away from the corner is at the depth w - r sin(phi). Depth is left on the
length L: the whole base, 2 b, or w / sin(phi) of it. With the area D dr, the force N upwards and
its moment M = S cos(phi) about the corner,

    N = D int_0^L (k d + c d') dr,    S = D int_0^L (k d + c d') r dr,

    (I + m B^2) phi'' = -m B a + S cos(phi) + A N + m A B phi'^2
    w'' = g - N / m - B phi'^2 - A phi''

under the acceleration a of the base towards that side. As k grows, L and w go to zero, and the
first equation to Housner's. An impact is no event here: what it leaves is what the dampers leave.

A step is one expansion of degree 10. It is cut where the block turns back, where it comes upright,
where its face begins to lift or is pressed as a whole again, where its corner leaves the ground or
lands, and where it falls. It starts in balance upon the ground. While its whole face is pressed it
counts as at rest.

At a velocity step dv of the base (I + m B^2) phi' changes by -m B dv and w' by -A times what phi'
does; springs and dampers have no time to act. The friction that it takes is not judged.

Cited for this model of lifting; the text has not been at hand:
    I. N. Psycharis and P. C. Jennings (1983), Rocking of slender rigid bodies allowed to uplift,
    Earthquake Engineering and Structural Dynamics 11(1), 57-76.
"""

import warp as wp

from warprock.kernels.housner.block import NEARLY
from warprock.kernels.housner.block_contact import ratio
from warprock.kernels.housner.block_found import FrictionSeen
from warprock.kernels.housner.lean import (
    LOOK,
    LOOKS,
    REACH,
    Looks,
    crest_of,
    judged_time,
)
from warprock.kernels.lane.modes import BROKEN, OVERTURNED, ROCKING
from warprock.kernels.motion.kinds import Ground, Motion, knot_step, knot_time
from warprock.kernels.motion.series import (
    DEGREE,
    TICK,
    Series,
    first_root,
    pull_series,
    slope_of,
    term,
    value_of,
)

ORDERS = DEGREE - 1
KNOWN = DEGREE - 2
"""Orders to which rates, and accelerations and forces, are known."""
NODE_1 = real(0.23861918608319690863)
NODE_2 = real(0.66120938646626451366)
NODE_3 = real(0.93246951420315202781)
WEIGHT_1 = real(0.46791393457269104739)
WEIGHT_2 = real(0.36076157304813860757)
WEIGHT_3 = real(0.17132449237917034504)
"""Gauss's rule of six nodes: their distances from the middle of a step, over half of it."""
WHOLE, PART, FREE = 0, 1, 2
"""How much of the base is pressed: all of it, a part at the corner, nothing."""
LAST_TERM = by_precision(2.0e-12, 2.0e-9)
"""Largest last term of a step, over the depth at rest: of a swing at the longest step."""
AT = by_precision(1.0e-13, 1.0e-6)
"""What counts as round-off of a depth, over the largest depth that matters."""


@wp.struct
class Block:
    """What a step needs to know of one lane's block.

    Attributes:
        half_width, half_height: [m].
        mass: [kg].
        inertia: About its centre [kg m^2].
        stiffness: Of the ground a unit of length of the base, k D [N/m^2].
        damping: Likewise, c D [N s/m^2].
        gravity: [m/s^2].
        sunk: Depth at rest [m].
        fall_angle: Lean from which on it falls for certain [rad].
    """

    half_width: real
    half_height: real
    mass: real
    inertia: real
    stiffness: real
    damping: real
    gravity: real
    sunk: real
    fall_angle: real
    step_length: real
    step_limit: int


@wp.struct
class State:
    """State of a lane.

    Attributes:
        side: The side that the block leans to, -1 or 1.
        lean: [rad], outwards.
        rate: Its rate [rad/s].
        depth: Of the lower corner [m]; negative above the ground.
        sink: Its rate [m/s].
        time: [s].
        segment: Knots of the motion that are passed.
        pressed: WHOLE, PART or FREE.
        mode: RESTING, ROCKING, or how the lane ended.
    """

    side: real
    lean: real
    rate: real
    depth: real
    sink: real
    time: real
    segment: int
    pressed: int
    mode: int


@wp.struct
class Way:
    """The motion about the present time.

    Attributes:
        lean, depth: [rad], [m].
        reach: What is left of the whole base at its depth, w - 2 b sin(phi) [m]: the other corner.
        force: Of the ground upwards [N].
        grip: Along the base towards the side that the block leans to [N].
    """

    lean: Series
    depth: Series
    reach: Series
    force: Series
    grip: Series


@wp.func
def way_of(block: Block, s: State, a: Series) -> Way:
    """A block about the present time; `a` is the acceleration towards its side."""
    b, h, mass = block.half_width, block.half_height, block.mass
    k, c = block.stiffness, block.damping
    x, w, u, v = Series(), Series(), Series(), Series()
    sines, cosines, across, up = Series(), Series(), Series(), Series()
    length, square, cube, turn = Series(), Series(), Series(), Series()
    force, moment, spin, held, bend = Series(), Series(), Series(), Series(), Series()
    lever = Series()
    x[0] = s.lean
    w[0] = s.depth
    x[1] = s.rate
    w[1] = s.sink
    u[0] = s.rate
    v[0] = s.sink
    sines[0] = sine(s.lean)
    cosines[0] = cosine(s.lean)
    if s.pressed == WHOLE:
        length[0] = real(2.0) * b
    for n in range(ORDERS):
        across[n] = h * sines[n] - b * cosines[n]
        up[n] = b * sines[n] + h * cosines[n]
        if s.pressed == PART:
            over = w[n]
            for j in range(n):
                over = over - length[j] * sines[n - j]
            length[n] = over / sines[0]
        square[n] = term(length, length, n)
        cube[n] = term(length, square, n)
        turn[n] = term(cosines, u, n)
        spring = term(w, length, n) - HALF * term(sines, square, n)
        damper = term(v, length, n) - HALF * term(turn, square, n)
        force[n] = k * spring + c * damper
        spring = HALF * term(w, square, n) - OVER_3 * term(sines, cube, n)
        damper = HALF * term(v, square, n) - OVER_3 * term(turn, cube, n)
        moment[n] = k * spring + c * damper
        spin[n] = term(u, u, n)
        held[n] = block.inertia * wp.where(n == 0, real(1.0), real(0.0)) + mass * term(up, up, n)
        # The moment of all but inertia about the centre, and the angular acceleration.
        lever[n] = term(across, up, n)
        pushed = term(moment, cosines, n) + term(across, force, n)
        pushed = pushed + mass * (term(lever, spin, n) - term(up, a, n))
        for j in range(n):
            pushed = pushed - bend[j] * held[n - j]
        bend[n] = pushed / held[0]
        sinks = -force[n] / mass - term(up, spin, n) - term(across, bend, n)
        if n == 0:
            sinks = sinks + block.gravity
        u[n + 1] = bend[n] / real(n + 1)
        v[n + 1] = sinks / real(n + 1)
        x[n + 2] = u[n + 1] / real(n + 2)
        w[n + 2] = v[n + 1] / real(n + 2)
        turned, lowered = real(0.0), real(0.0)
        for j in range(n + 1):
            turned = turned + u[j] * cosines[n - j]
            lowered = lowered + u[j] * sines[n - j]
        sines[n + 1] = turned / real(n + 1)
        cosines[n + 1] = -lowered / real(n + 1)
    # m (a + (B phi')') along the base.
    grip = Series()
    moved = Series()
    for n in range(ORDERS):
        moved[n] = term(up, u, n)
    for n in range(KNOWN):
        grip[n] = mass * (a[n] + real(n + 1) * moved[n + 1])
    reach = w - (real(2.0) * b) * sines
    reach[DEGREE] = w[DEGREE] - real(2.0) * b * sine_term(u, cosines)
    return Way(x, w, reach, force, grip)


@wp.func
def sine_term(u: Series, cosines: Series) -> real:
    """The last coefficient of sin(phi), of which the others are known."""
    found = real(0.0)
    for j in range(DEGREE):
        found = found + u[j] * cosines[ORDERS - j]
    return OVER_10 * found


@wp.func
def power(block: Block, pressed: int, way: Way, t: real) -> real:
    """Power of the dampers a time t after the start of a step [W]: c int (w' - r cos phi')^2 dr."""
    lean = value_of(way.lean, t)
    sink = value_of(slope_of(way.depth), t)
    turn = cosine(lean) * value_of(slope_of(way.lean), t)
    length = real(2.0) * block.half_width
    if pressed == PART:
        length = value_of(way.depth, t) / sine(lean)
    moved = turn * length
    return block.damping * length * (sink * sink - sink * moved + OVER_3 * moved * moved)


@wp.func
def damping_loss(block: Block, pressed: int, way: Way, tau: real) -> real:
    """Energy that the dampers take in a step of length tau [J], by Gauss's rule of six nodes."""
    found = real(0.0)
    if pressed != FREE and block.damping > found:
        half = HALF * tau
        for k in range(3):
            aside = half * wp.where(k == 0, NODE_1, wp.where(k == 1, NODE_2, NODE_3))
            weight = wp.where(k == 0, WEIGHT_1, wp.where(k == 1, WEIGHT_2, WEIGHT_3))
            both = power(block, pressed, way, half - aside)
            both = both + power(block, pressed, way, half + aside)
            found = found + half * weight * both
    return found


@wp.func
def goes_below(p: Series, scale: real, h: real) -> bool:
    """Whether a series that is zero to round-off falls below zero from now on."""
    rate = p[1] * h
    if size(rate) <= AT * scale:
        rate = p[2] * h * h
        if size(rate) <= NEARLY * size(p[3]) * h * h * h:
            rate = p[3] * h * h * h
        if size(rate) <= AT * scale:
            rate = real(0.0)
    return rate < real(0.0)


@wp.func
def first_below(p: Series, scale: real, h: real) -> real:
    """When a series falls below zero within a step; a zero that it starts at is divided out."""
    zero = real(0.0)
    found = NEVER
    if p[0] > AT * scale:
        found = first_root(p, h)
    else:
        over = 1
        if size(p[1]) * h <= AT * scale:
            over = 2
        q = Series()
        for k in range(KNOWN):
            q[k] = p[k + over]
        if q[0] > zero:
            found = first_root(q, h)
    return found


@wp.func
def lean_over(s: wp.ref[State], width: real):
    """Has an upright block lean to its other side: the corner there is as deep."""
    s.side = -s.side
    s.lean = -s.lean
    s.sink = s.sink - width * s.rate
    s.rate = -s.rate


@wp.func
def changes(block: Block, s: State, way: Way, h: real) -> int:
    """What changes at once: 1 if the block leans over, 2 if another part is pressed."""
    width = real(2.0) * block.half_width
    depth = block.sunk + size(s.depth)
    found = int(0)
    if (
        s.pressed != PART
        and s.lean <= AT * depth / width
        and goes_below(width * way.lean, depth, h)
    ):
        found = 1
    if s.pressed == WHOLE and way.reach[0] <= AT * depth and goes_below(way.reach, depth, h):
        found = 2
    if s.pressed == PART:
        if way.reach[0] >= -AT * depth and goes_below(-way.reach, depth, h):
            found = 2
        if s.depth <= AT * depth and goes_below(way.depth, depth, h):
            found = 2
    if s.pressed == FREE and s.depth >= -AT * depth and goes_below(-way.depth, depth, h):
        found = 2
    return found


@wp.func
def press(block: Block, s: wp.ref[State], seen: wp.ref[FrictionSeen]):
    """Has another part of the base be pressed, that which the present state says.

    Where a state lies between two of them the present one is left.
    """
    before = s.pressed
    reach = s.depth - real(2.0) * block.half_width * sine(s.lean)
    if before == WHOLE:
        s.pressed = PART
        if s.depth < AT * block.sunk:
            s.pressed = FREE
        seen.uplift_time = smaller(seen.uplift_time, s.time)
    elif before == FREE:
        s.pressed = PART
        seen.impacts = seen.impacts + 1
        if reach >= -AT * block.sunk:
            s.pressed = WHOLE
    elif size(reach) < size(s.depth):
        s.pressed = WHOLE
        seen.impacts = seen.impacts + 1
    else:
        s.pressed = FREE
    seen.rest_time = wp.where(s.pressed == WHOLE, s.time, NEVER)


@wp.func
def pass_knot(block: Block, dv: real, s: wp.ref[State]):
    """Passes a knot of the motion, with a velocity step dv of the base."""
    s.segment = s.segment + 1
    if dv != real(0.0):
        sn, cs = sine(s.lean), cosine(s.lean)
        up = block.half_width * sn + block.half_height * cs
        across = block.half_height * sn - block.half_width * cs
        kick = -block.mass * up * s.side * dv / (block.inertia + block.mass * up * up)
        s.rate = s.rate + kick
        s.sink = s.sink - across * kick


@wp.func
def needed_at(way: Way, t: real) -> real:
    """Friction that a block needs a time t after the start of a step."""
    return ratio(value_of(way.grip, t), value_of(way.force, t))


@wp.func
def needed_in(way: Way, tau: real) -> real:
    """Friction that a block needs in a step of length tau, from a few looks."""
    part = LOOK * tau
    looks = Looks()
    for k in range(LOOKS):
        looks[k] = needed_at(way, real(k + 1) * part)
    found, crest = crest_of(needed_at(way, real(0.0)), looks)
    if crest > real(0.0):
        found = larger(needed_at(way, crest * part), found)
    return found


@wp.func
def start_lane(block: Block, theta: real, omega: real):
    """Releases a block in balance at a rotation [rad], with a rate [rad/s]: its state, and seen."""
    zero = real(0.0)
    side = sign_of(wp.where(theta == zero, omega, theta))
    lean = side * theta
    raised = block.half_width * sine(lean)
    depth, pressed = block.sunk + raised, int(WHOLE)
    partly = depth < real(2.0) * raised
    if partly:
        depth = real(2.0) * wp.sqrt(raised * block.sunk)
        pressed = int(PART)
    lifted, rested = wp.where(partly, zero, NEVER), wp.where(partly, NEVER, zero)
    state = State(side, lean, side * omega, depth, zero, zero, 0, pressed, ROCKING)
    return state, FrictionSeen(lean, zero, lifted, rested, zero, zero, 0, 0)


@wp.func
def step_limit_of(block: Block, s: State, way: Way) -> real:
    """Longest step that the last terms of the motion allow [s]."""
    width = real(2.0) * block.half_width
    last = larger(width * size(way.lean[DEGREE]), size(way.depth[DEGREE])) + TINY
    trusted = wp.pow(LAST_TERM * block.sunk / last, OVER_10)
    return smaller(trusted, smaller(block.step_length, REACH / wp.abs(s.rate)))


@wp.func
def advance(
    block: Block, way: Way, a: Series, h: real, s: wp.ref[State], seen: wp.ref[FrictionSeen]
) -> real:
    """Moves a block on to its next event, at most by h; the time that it takes [s]."""
    width = real(2.0) * block.half_width
    depth = block.sunk + size(s.depth)
    tau = real(h)
    happens = int(0)
    rate = slope_of(way.lean)
    if s.rate > real(0.0):
        at = first_root(rate, h)
        if at < tau:
            tau = at
            happens = 4
    if s.pressed != PART:
        at = first_below(width * way.lean, depth, h)
        if at < tau:
            tau = at
            happens = 1
    edge = way.reach
    if s.pressed == PART:
        edge = -way.reach
        at = first_below(way.depth, depth, h)
        if at < tau:
            tau = at
            happens = 2
    if s.pressed == FREE:
        edge = -way.depth
    at = first_below(edge, depth, h)
    if at < tau:
        tau = at
        happens = 2
    laid = -way.lean
    laid[0] = HALF_PI - s.lean
    at = first_root(laid, h)
    if at < tau:
        tau = at
        happens = 3
    judged = real(tau)
    if s.rate >= real(0.0):
        judged = judged_time(way.lean, real(1.0), block.fall_angle - s.lean, tau)
    if judged > real(0.0):
        seen.needed = larger(needed_in(way, judged), seen.needed)
    seen.loss = seen.loss + damping_loss(block, s.pressed, way, tau)
    s.lean = value_of(way.lean, tau)
    s.rate = value_of(rate, tau)
    s.depth = value_of(way.depth, tau)
    s.sink = value_of(slope_of(way.depth), tau)
    if happens == 1:
        s.lean = real(0.0)
    if happens == 3:
        s.lean = HALF_PI
        s.mode = OVERTURNED
    if happens == 4:
        s.rate = real(0.0)
    return tau


@wp.func
def step(
    block: Block,
    m: Motion,
    ground: Ground,
    until: real,
    s: wp.ref[State],
    seen: wp.ref[FrictionSeen],
):
    """One step of one lane, to its next event or at most to `until`."""
    knot = knot_time(m, s.segment)
    target = smaller(knot, until)
    room = larger(target - s.time, real(0.0))
    a = s.side * pull_series(m, s.segment, s.time, ground)
    way = way_of(block, s, a)
    h = smaller(step_limit_of(block, s, way), room)
    change = int(0)
    if h > real(0.0):
        change = changes(block, s, way, h)
    if change == 1:
        lean_over(s, real(2.0) * block.half_width)
    elif change == 2:
        press(block, s, seen)
    else:
        tau = real(0.0)
        if h > tau:
            tau = advance(block, way, a, h, s, seen)
        arrives = tau >= fused_less(TICK, target, room)
        s.time = wp.where(arrives, target, s.time + tau)
        if s.time >= knot and s.mode < OVERTURNED:
            pass_knot(block, knot_step(m, s.segment), s)
    if not wp.isfinite(s.lean + s.rate + s.depth + s.sink + s.time):
        s.mode = BROKEN
    if size(s.lean) > seen.peak:
        seen.peak = size(s.lean)
        seen.peak_time = s.time
    seen.steps = seen.steps + 1
