"""Second-order contact step of a body on contact points, impacts located.

As event/block.py, which see for the scheme; here is what differs. A body turns about corner k, or
flies with corner k lowest, while its rotation is between those at which the edges on both sides of
k lie flat (see shape/body.py). Steps end where one of them does: the corner at its other end lands,
which is the impact, or takes the place of corner k in flight. Where a body lies on an edge it may
be any edge; the corner about which it would tip is the end nearer to where the base presses it. It
has overturned at a right angle from where it stands at first.

A lane's state is that of event/block.py with theta [rad] from where the body stands at first, and
`corner`, the number of corner k; of a body that lies flat, of its edge's end at -x. The slide is
that of what touches, along the base, over what the body has rolled.

After an impact on another corner the body rests on the edge between if its next swing would stay
below `rest_rotation` on either side.
"""

import warp as wp

from warprock.kernels.event.block import (
    GRAIN,
    LEAST,
    NEARLY,
    REACH,
    SLOWEST,
    Knobs,
    base_change,
    first_root,
)
from warprock.kernels.event.block_contact import SOON
from warprock.kernels.event.body_contact import (
    Body,
    Edge,
    held_lack,
    held_velocity,
    hold_reserve,
    may_rest,
    mean_velocity,
    struck_velocity,
    tips_right,
)
from warprock.kernels.modes import BROKEN, FLAT, FLYING, OVERTURNED, PIVOTING
from warprock.kernels.motion import Motion, knot_step, knot_time, series
from warprock.kernels.shape.body import turned_x, turned_z


@wp.struct
class View:
    """Corner k and what is on both sides of it, from the centre of mass at the rotation zero.

    Attributes:
        corner: k.
        x, z: Where it is [m].
        low, high: Rotations at which the edges on both sides lie flat [rad].
        left_x, left_z: The corner to -x [m], k itself if it is the first; right_x, right_z to +x.
        flat_right: Whether a body that lies flat lies on the edge to +x of it.
    """

    corner: int
    x: real
    z: real
    low: real
    high: real
    left_x: real
    left_z: real
    right_x: real
    right_z: real
    flat_right: bool


@wp.func
def begin(
    body: Body, knobs: Knobs, m: Motion, sample: real, sample_slope: real, end: real, live: bool,
    resting: bool, time: real, segment: int, omega: real, base: real, cap: real,
):  # fmt: skip
    """What a trial step of a lane begins with.

    Returns:
        Its length [s], its end, whether that is a knot, the velocity step of the base there, the
        acceleration of the base there [m/s^2] and the change of its velocity until then [m/s].
    """
    zero = real(0.0)
    knot = knot_time(m, segment)
    target = smaller(knot, end)
    room = larger(target - time, zero)
    d = smaller(smaller(body.longest_step, REACH / (size(omega) + SLOWEST)), cap)
    quiet = segment == 0 or knot >= NEVER
    d = smaller(wp.where(resting and quiet, room, d), room)
    d = wp.where(live, d, zero)
    time1 = wp.where(d >= target - time, target, time + d)
    passed = time1 >= knot
    kick = wp.where(passed, knot_step(m, segment), zero)
    a, jerk, _a2, _a3, _a4, _a5, _a6, _a7, _a8 = series(m, segment, time1, sample, sample_slope)
    return d, time1, passed, kick, a, base_change(m, time1, d, a, jerk, base, kick)


@wp.func
def edge_of(body: Body, x1: real, z1: real, x2: real, z2: real, s: real, c: real) -> Edge:
    """The edge between two corners, the first at -x, of a body turned by (s, c)."""
    return Edge(
        turned_x(x1, z1, s, c), turned_x(x2, z2, s, c), body.radius - turned_z(x1, z1, s, c)
    )


@wp.func
def tips_about_second(
    body: Body, gravity: real, x1: real, z1: real, x2: real, z2: real, theta: real, slip: real,
    vx: real, dv: real, d: real,
) -> bool:  # fmt: skip
    """Whether a body on an edge would tip about its end at +x, see `tips_right`."""
    edge = edge_of(body, x1, z1, x2, z2, sine(theta), cosine(theta))
    return tips_right(body.friction, slip, edge, vx - HALF * dv, -HALF * d * gravity)


@wp.func
def missed_event(
    view: View, flying: bool, theta: real, omega: real, theta1: real, omega1: real,
    gap: real, rise: real, gap1: real, rise1: real,
    slip: real, along: real, along1: real, reach: real, holds: bool, lack: real, lack1: real,
    d: real, per: real, near: real, grain: real,
):  # fmt: skip
    """Whether an event lies inside a step, and the length of the step that ends there.

    Args:
        view: The corner and its neighbours; for all others see `missed_event` of event/block.py.
    """
    zero = real(0.0)
    past = theta1 > view.high + near * size(omega1)
    below = theta1 < view.low - near * size(omega1)
    sinks = flying and gap1 < -near * size(rise1) - grain
    stops = slip * along > zero and slip * along1 < -reach
    lifts = holds and lack1 < -SOON * lack and d > near
    e0 = wp.where(stops, slip * along, lack)
    e1 = wp.where(stops, slip * along1, lack1)
    slope = (e1 - e0) * per
    e0 = wp.where(sinks, gap, e0)
    e1 = wp.where(sinks, gap1, e1)
    slope = wp.where(sinks, rise, slope)
    e0 = wp.where(below, theta - view.low, e0)
    e1 = wp.where(below, theta1 - view.low, e1)
    slope = wp.where(below, omega, slope)
    e0 = wp.where(past, view.high - theta, e0)
    e1 = wp.where(past, view.high - theta1, e1)
    slope = wp.where(past, -omega, slope)
    # Not shorter than `near`: with less than that left to go, the event counts as reached.
    least = wp.where(past or below or sinks or stops, HALF * near, larger(LEAST * d, HALF * near))
    cut = larger(first_root(e0, slope, e1, d), least)
    return past or below or sinks or stops or lifts, cut


@wp.func
def integrate(
    body: Body, knobs: Knobs, view: View, mode: int, slip: real, a: real, dv: real, d: real,
    theta: real, gap: real, vx: real, vz: real, omega: real,
):  # fmt: skip
    """The step up to its end, before the projection.

    Returns:
        Rotation, slide in the step, gap, velocity (three values), mode and direction of sliding in
        the step, energy lost per unit mass; whether an event was missed, the length of the step to
        it; whether the corner to +x lands on the base or takes its place, whether that to -x does;
        whether the lower corner lands; how deep a corner is [m].
    """
    zero = real(0.0)
    per = real(1.0) / d
    r = body.radius
    s0, c0 = sine(theta), cosine(theta)
    x0, z0 = turned_x(view.x, view.z, s0, c0), turned_z(view.x, view.z, s0, c0) - r
    lx = wp.where(view.flat_right, view.x, view.left_x)
    lz = wp.where(view.flat_right, view.z, view.left_z)
    rx = wp.where(view.flat_right, view.right_x, view.x)
    rz = wp.where(view.flat_right, view.right_z, view.z)
    edge = edge_of(body, lx, lz, rx, rz, s0, c0)
    a0 = TWO * dv * per - a
    reserve, surely = hold_reserve(body, knobs.gravity, slip, x0, z0, omega, a0)
    middle = theta + HALF * d * omega
    sm, cm = sine(middle), cosine(middle)
    mx, mz, mo, mode1, slip1, lost = mean_velocity(
        body, mode, slip, surely and slip == zero, edge, turned_x(view.x, view.z, sm, cm),
        turned_z(view.x, view.z, sm, cm) - r, vx - HALF * dv, vz - HALF * d * knobs.gravity, omega,
    )  # fmt: skip
    idle = d <= zero
    mx = wp.where(idle, vx, mx)
    mz = wp.where(idle, vz, mz)
    mo = wp.where(idle, omega, mo)
    mode1 = wp.where(idle, mode, mode1)
    slip1 = wp.where(idle, slip, slip1)
    lost = wp.where(idle, zero, lost)
    theta1 = theta + d * mo
    s1, c1 = sine(theta1), cosine(theta1)
    x1, z1 = turned_x(view.x, view.z, s1, c1), turned_z(view.x, view.z, s1, c1) - r
    flying = mode1 == FLYING
    glide = d * mx + (x1 - x0) - r * (theta1 - theta)
    glide = wp.where(flying or slip1 != zero, glide, zero)
    raw_vx = TWO * mx - vx
    raw_omega = TWO * mo - omega
    along = vx + omega * z0
    # Not projected: where friction nearly jams the body, that would hide how far it overshot.
    along1 = raw_vx + raw_omega * z1
    near = NEARLY * body.longest_step
    reach = near * size(along1 - along) * per
    # Sliding ends where it would turn round.
    turned = slip1 * along1 <= wp.where(slip * along > zero, reach, zero)
    slip1 = wp.where(turned and not idle, zero, slip1)
    vx1, vz1, omega1 = held_velocity(body, mode1, slip1, x1, z1, raw_vx, TWO * mz - vz, raw_omega)
    # Nor does it go on where its own friction turned it round in the projection.
    slip1 = wp.where(slip1 * (vx1 + omega1 * z1) <= zero and not idle, zero, slip1)
    glide = wp.where(slip == zero and slip1 == zero and not flying, zero, glide)
    raw_gap = gap + d * mz + (z1 - z0)
    gap1 = wp.where(flying, raw_gap, zero)
    gap1 = wp.where(mode != FLYING, larger(gap1, zero), gap1)
    rise1 = vz1 - omega1 * x1
    reserve1, _surely = hold_reserve(body, knobs.gravity, slip, x1, z1, omega1, a)
    holds, lack, lack1 = held_lack(
        body, knobs.gravity, edge, mode, mode1, slip, surely, reserve, reserve1, a0, a
    )
    grain = GRAIN * edge.height
    missed, cut = missed_event(
        view, flying, theta, omega, theta1, omega1, gap, vz - omega * x0, gap1, rise1,
        slip, along, along1, reach, holds, lack, lack1, d, per, near, grain,
    )  # fmt: skip
    flat = mode1 == FLAT
    up = not flat and omega1 > zero and theta1 >= view.high - near * omega1
    down = not flat and omega1 < zero and theta1 <= view.low - near * omega1
    lands = flying and rise1 < zero and gap1 <= grain - near * rise1
    below = smaller(
        turned_z(view.left_x, view.left_z, s1, c1), turned_z(view.right_x, view.right_z, s1, c1)
    )
    deep = larger(-raw_gap, z1 + r - below - raw_gap)
    return (
        theta1, glide, gap1, vx1, vz1, omega1, mode1, slip1, lost,
        missed and not idle, cut, up, down, lands, deep,
    )  # fmt: skip


@wp.func
def end_of_step(
    body: Body, gravity: real, view: View, up: bool, down: bool, lands: bool, kick: real, a: real,
    mode: int, slip: real, theta: real, vx: real, vz: real, omega: real,
):  # fmt: skip
    """What the end of a step does to the velocities.

    Args:
        body: The body.
        gravity: [m/s^2].
        view: The corner and its neighbours.
        up, down: Whether the body now lies on the edge to +x of the corner, to -x of it.
        lands: Whether the corner has landed.
        kick: Velocity step of the base [m/s].
        a: Acceleration of the base [m/s^2].
        mode, slip: In the step.
        theta: Rotation; vx, vz and omega velocities.

    Returns:
        Velocity (three values), mode, direction of sliding and number of the corner; energy lost
        per unit mass; whether another corner or a flying one hit the base; time of the impacts
        that resting leaves out.
    """
    zero = real(0.0)
    flat = mode == FLAT
    falls = up or down
    hit = lands or (falls and mode == PIVOTING)
    struck = hit or (kick != zero and mode != FLYING)
    kicked = vx - kick
    s, c = sine(theta), cosine(theta)
    right = wp.where(flat, view.flat_right, up or (not down and theta == view.high))
    left = wp.where(flat, not view.flat_right, down or (not up and theta == view.low))
    # The edge: the corner and its neighbour on that side.
    sx, sz = turned_x(view.x, view.z, s, c), turned_z(view.x, view.z, s, c)
    ox = wp.where(right, turned_x(view.right_x, view.right_z, s, c),
                  turned_x(view.left_x, view.left_z, s, c))  # fmt: skip
    oz = wp.where(right, turned_z(view.right_x, view.right_z, s, c),
                  turned_z(view.left_x, view.left_z, s, c))  # fmt: skip
    # The corner that is struck is the neighbour where that lands; of a flat body, the one ahead.
    swaps = falls or (flat and (kicked >= zero) == right)
    x, z = wp.where(swaps, ox, sx), wp.where(swaps, oz, sz) - body.radius
    other = wp.where(swaps, sx, ox)
    vx1, vz1, omega1, mode1, slip1, lost = struck_velocity(
        body, left or right, falls and mode == PIVOTING, x, z, other, kicked, vz, omega
    )
    # The base's work on the body is at the mean of both velocities: see account.py.
    lost = lost - HALF * kick * (vx1 - kicked)
    vx1 = wp.where(struck, vx1, kicked)
    vz1 = wp.where(struck, vz1, vz)
    omega1 = wp.where(struck, omega1, omega)
    mode1 = wp.where(struck, mode1, mode)
    slip1 = wp.where(struck, slip1, slip)
    lost = wp.where(struck, lost, zero)
    edge = Edge(smaller(x, other), larger(x, other), -z)
    pull = wp.where(slip1 != zero, -slip1 * body.friction * gravity, a)
    stays, tail = may_rest(body, gravity, edge, omega1, omega, pull)
    rests = stays and hit and falls and mode1 == PIVOTING
    tail = wp.where(rests, tail, zero)
    glides = wp.where(slip1 != zero, vx1, zero)
    slip1 = wp.where(rests and slip1 != zero, sign_of(vx1), slip1)
    rest_lost = HALF * (vx1 * vx1 - glides * glides + vz1 * vz1 + omega1 * omega1 * body.inertia)
    mode1 = wp.where(rests, FLAT, mode1)
    # Corners are numbered from -x: an edge is known by its end there.
    on_edge = view.corner + wp.where(right, 0, -1)
    next_door = view.corner + wp.where(right, 1, -1)
    moves = falls or (flat and swaps and mode1 != FLAT)
    return (
        wp.where(rests, glides, vx1),
        wp.where(rests, zero, vz1),
        wp.where(rests, zero, omega1),
        mode1,
        slip1,
        wp.where(mode1 == FLAT, on_edge, wp.where(moves, next_door, view.corner)),
        lost + wp.where(rests, rest_lost, zero),
        hit,
        tail,
    )


@wp.func
def step(
    body: Body, knobs: Knobs, view: View, live: bool, d: real, time1: real, passed: bool,
    kick: real, a: real, dv: real, corner: int,
    theta: real, slide: real, gap: real, vx: real, vz: real, omega: real, slip: real, mode: int,
    time: real, segment: int, base: real, cap: real,
):  # fmt: skip
    """One trial step of one lane, from what `begin` found.

    From `corner` on the lane's state, see the head of this file; the step returns it in the same
    order, unchanged but for `cap` where an event lay inside. Behind it: the turning point in the
    step [rad] and its time [s], energy lost per unit mass [J/kg], time of the impacts that resting
    leaves out [s], whether an impact ended the step, whether the step was taken, and how deep a
    corner was in the base at its end, before it was put back [m].
    """
    zero = real(0.0)
    th1, glide, gap1, vx1, vz1, om1, mode1, slip1, lost, missed, cut, up, down, lands, deep = (
        integrate(body, knobs, view, mode, slip, a, dv, d, theta, gap, vx, vz, omega)
    )
    over = (up and view.high >= HALF_PI) or (down and view.low <= -HALF_PI)
    th2 = wp.where(up, view.high, wp.where(down, view.low, th1))
    vx2, vz2, om2, mode2, slip2, corner2, lost2, hit, tail = end_of_step(
        body, knobs.gravity, view, up and not over, down and not over, lands, kick, a, mode1,
        slip1, th2, vx1, vz1, om1,
    )  # fmt: skip
    sound = th2 - th2 == zero and om2 - om2 == zero and vx2 - vx2 == zero and vz2 - vz2 == zero
    spot = view.x * view.z
    sound = sound and time1 - time1 == zero and spot - spot == zero
    mode2 = wp.where(sound, wp.where(over, OVERTURNED, mode2), BROKEN)
    taken = live and not (missed and sound)
    turns = taken and omega * om1 < zero
    rise = omega * d / (omega - om1)
    return (
        wp.where(taken, corner2, corner),
        wp.where(taken, th2, theta), wp.where(taken, slide + glide, slide),
        wp.where(taken, wp.where(lands, zero, gap1), gap), wp.where(taken, vx2, vx),
        wp.where(taken, vz2, vz), wp.where(taken, om2, omega),
        wp.where(taken, slip2, slip), wp.where(taken, mode2, mode),
        wp.where(taken, time1, time), segment + wp.where(taken and passed, 1, 0),
        wp.where(taken, base + dv + kick, base), wp.where(taken, NEVER, wp.where(live, cut, cap)),
        wp.where(turns, theta + HALF * omega * rise, zero), time + wp.where(turns, rise, zero),
        wp.where(taken, lost + lost2, zero), wp.where(taken, tail, zero), taken and hit, taken,
        wp.where(taken, deep, zero),
    )  # fmt: skip
