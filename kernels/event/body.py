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

from warprock.kernels.event.block import GRAIN, LEAST, NEARLY, TICK, Knobs
from warprock.kernels.event.block_begin import REACH, SLOWEST, base_change, first_root
from warprock.kernels.event.block_contact import SOON
from warprock.kernels.event.body_contact import (
    Body,
    Edge,
    bounds,
    held_velocity,
    hold_reserve,
    least_lack,
    mean_velocity,
)
from warprock.kernels.event.body_impact import end_of_step
from warprock.kernels.event.body_view import View, contacts_at, edge_below
from warprock.kernels.event.body_weight import Weight, fall_in
from warprock.kernels.event.lift import Lack, held_time
from warprock.kernels.modes import BROKEN, FLAT, FLYING, OVERTURNED, PIVOTING
from warprock.kernels.motion import (
    LINEAR,
    Motion,
    acceleration_after,
    knot_step,
    knot_time,
    series,
)
from warprock.kernels.shape.above import Above
from warprock.kernels.shape.body import turned_x, turned_z


@wp.func
def begin(
    body: Body, knobs: Knobs, m: Motion, sample: real, sample_slope: real, end: real, live: bool,
    mode: int, slip: real, time: real, segment: int, omega: real, base: real, cap: real,
    above: Above,
):  # fmt: skip
    """What a trial step of a lane begins with.

    Returns:
        Its length [s], its end, whether that is a knot, the velocity step of the base there, the
        acceleration of the base there [m/s^2] and the change of its velocity until then [m/s]; by
        how much the acceleration may be larger inside the step than at its ends [m/s^2].
    """
    zero = real(0.0)
    knot = knot_time(m, segment)
    target = smaller(knot, end)
    still = segment == 0 or knot >= NEVER
    if VERTICAL:
        lifts = knot_time(above.motion, above.segment)
        target = smaller(lifts, target)
        still = still and (above.segment == 0 or lifts >= NEVER)
    room = larger(target - time, zero)
    d = smaller(smaller(body.longest_step, REACH / (size(omega) + SLOWEST)), cap)
    quiet = mode == FLAT and slip == zero and still
    d = smaller(wp.where(quiet, room, d), room)
    d = wp.where(live, d, zero)
    time1 = wp.where(d >= target - time, target, time + d)
    passed = time1 >= knot
    kick = wp.where(passed, knot_step(m, segment), zero)
    a, jerk, bend, _a3, _a4, _a5, _a6, _a7, _a8 = series(m, segment, time1, sample, sample_slope)
    more = zero
    if not LINEAR:
        more = d * (size(jerk) + d * size(bend))
        if VERTICAL:
            # How much less the body weighs is not asked: one at rest looks ahead in every step.
            more = NEVER
    return d, time1, passed, kick, a, base_change(m, time1, d, a, jerk, base, kick), more


@wp.func
def look_ahead(
    body: Body, gravity: real, edge: Edge, m: Motion, sample: real, sample_slope: real, end: real,
    time: real, segment: int, above: Above,
) -> real:  # fmt: skip
    """Longest step of a body at rest [s]: see event/lift.py."""
    knot = smaller(knot_time(m, segment), end)
    if VERTICAL:
        knot = smaller(knot, knot_time(above.motion, above.segment))
    d = smaller(body.longest_step, knot - time)
    a0, a1, a2, a3, a4, a5, a6, a7, a8 = series(m, segment, time, sample, sample_slope)
    a = acceleration_after(a0, a1, a2, a3, a4, a5, a6, a7, a8, d)
    back, ahead = bounds(body, edge)
    weight, weight1 = gravity, gravity
    if VERTICAL:
        u0, u1, u2, u3, u4, u5, u6, u7, u8 = series(
            above.motion, above.segment, time, above.value, above.slope
        )
        weight = gravity + u0
        weight1 = gravity + acceleration_after(u0, u1, u2, u3, u4, u5, u6, u7, u8, d)
    up = smaller(weight * ahead - a0, weight1 * ahead - a) < smaller(
        weight * back + a0, weight1 * back + a
    )
    s, part = wp.where(up, real(-1.0), real(1.0)), wp.where(up, ahead, back)
    lack = Lack(
        fused(s, a0, part * weight), s * a1, s * a2, s * a3, s * a4, s * a5, s * a6, s * a7, s * a8
    )
    if VERTICAL:
        lack = Lack(
            lack.c0, fused(part, u1, lack.c1), fused(part, u2, lack.c2), fused(part, u3, lack.c3),
            fused(part, u4, lack.c4), fused(part, u5, lack.c5), fused(part, u6, lack.c6),
            fused(part, u7, lack.c7), fused(part, u8, lack.c8),
        )  # fmt: skip
    bound = part * gravity
    return held_time(lack, bound, TICK * fused(size(lack.c1), time, bound), d)


@wp.func
def missed_event(
    view: View, flying: bool, theta: real, omega: real, theta1: real, omega1: real,
    gap: real, rise: real, gap1: real, rise1: real,
    slip: real, along: real, along1: real, slows: real, reach: real, holds: bool, lack: real,
    lack1: real, d: real, per: real, near: real, grain: real,
):  # fmt: skip
    """Whether an event lies inside a step, and the length of the step that ends there.

    Args:
        view: The corner and its neighbours.
        slows: Rate at which the speed along the base grows at the start [m/s^2].
        Others: See `missed_event` of event/block.py.
    """
    zero = real(0.0)
    past = theta1 > view.high + near * size(omega1)
    below = theta1 < view.low - near * size(omega1)
    sinks = flying and gap1 < -near * size(rise1) - grain
    stops = slip * along > zero and slip * along1 < -reach
    lifts = holds and lack1 < -SOON * lack and d > near
    e0 = wp.where(stops, slip * along, lack)
    e1 = wp.where(stops, slip * along1, lack1)
    slope = wp.where(stops, slows, (e1 - e0) * per)
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
def step_velocity(
    body: Body, view: View, edge: Edge, mode: int, slip: real, hold: bool, theta: real,
    vx: real, vz: real, omega: real, dv: real, d: real, fall: real,
):  # fmt: skip
    """`mean_velocity` of a step of a given length; a step of length zero changes nothing.

    Args:
        body: The body.
        view: The corner and its neighbours.
        edge: The edge it lies on, if it is flat.
        mode, slip: See `mean_velocity`.
        hold: Whether a pivoting corner that sticks does so in the whole step.
        theta: Rotation at the start [rad]; vx, vz and omega velocities.
        dv: Change of the base velocity in the step [m/s].
        d: Length of the step [s].
        fall: What gravity makes of a velocity in it [m/s].
    """
    middle = theta + HALF * d * omega
    s, c = sine(middle), cosine(middle)
    mx, mz, mo, mode1, slip1, lost = mean_velocity(
        body, mode, slip, hold and slip == real(0.0), edge, turned_x(view.x, view.z, s, c),
        turned_z(view.x, view.z, s, c) - body.radius, vx - HALF * dv, vz - HALF * fall, omega,
    )  # fmt: skip
    idle = d <= real(0.0)
    return (
        wp.where(idle, vx, mx),
        wp.where(idle, vz, mz),
        wp.where(idle, omega, mo),
        wp.where(idle, mode, mode1),
        wp.where(idle, slip, slip1),
        wp.where(idle, real(0.0), lost),
    )


@wp.func
def integrate(
    body: Body, gravity: real, weight: Weight, view: View, mode: int, slip: real, a: real, dv: real,
    d: real, more: real, theta: real, gap: real, vx: real, vz: real, omega: real,
):  # fmt: skip
    """The step up to its end, before the projection.

    Returns:
        Rotation, slide in the step, gap, gap before what is put back, velocity (three values), mode
        and direction of sliding in the step, energy lost per unit mass; whether an event was
        missed, the length of the step to it; whether the base may let go of the body at rest.
    """
    zero = real(0.0)
    per = real(1.0) / d
    idle = d <= zero
    r = body.radius
    s0, c0 = sine(theta), cosine(theta)
    x0, z0 = turned_x(view.x, view.z, s0, c0), turned_z(view.x, view.z, s0, c0) - r
    edge = edge_below(body, view, s0, c0)
    a0 = TWO * dv * per - a
    reserve, surely = hold_reserve(body, weight.start, slip, x0, z0, omega, a0)
    mx, mz, mo, mode1, slip1, lost = step_velocity(
        body, view, edge, mode, slip, surely, theta, vx, vz, omega, dv, d,
        fall_in(weight, gravity, d),
    )  # fmt: skip
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
    reserve1, _surely = hold_reserve(body, weight.end, slip, x1, z1, omega1, a)
    holds = surely and (mode == PIVOTING or mode1 == PIVOTING)
    rests = mode == FLAT and slip == zero
    looks = rests and least_lack(body, weight, edge, a0, a) < more + SOON * gravity
    # The secant of a speed that begins to fall, of a short slide, is far from its slope.
    slows = wp.where(mode1 == FLAT, -slip * a0 - body.friction * weight.start,
                     slip * (along1 - along) * per)  # fmt: skip
    missed, cut = missed_event(
        view, flying, theta, omega, theta1, omega1, gap, vz - omega * x0, gap1, vz1 - omega1 * x1,
        slip, along, along1, slows, reach, holds, reserve, reserve1, d, per, near,
        GRAIN * edge.height,
    )  # fmt: skip
    return (
        theta1, glide, gap1, raw_gap, vx1, vz1, omega1, mode1, slip1, lost, missed and not idle,
        cut, looks,
    )  # fmt: skip


@wp.func
def step(
    body: Body, knobs: Knobs, weight: Weight, view: View, live: bool, looked: bool, d: real,
    time1: real, passed: bool, kick: real, a: real, dv: real, more: real, corner: int,
    theta: real, slide: real, gap: real, vx: real, vz: real, omega: real, slip: real, mode: int,
    time: real, segment: int, base: real, cap: real,
):  # fmt: skip
    """One trial step of one lane, from what `begin` found.

    From `corner` on the lane's state, see the head of this file; the step returns it in the same
    order, unchanged but for `cap` where an event lay inside. Behind it: the turning point in the
    step [rad] and its time [s], energy lost per unit mass [J/kg], time of the impacts that resting
    leaves out [s], whether an impact ended the step, whether the step was taken, how deep a corner
    was in the base at its end, before it was put back [m], and the friction that a prescribed
    impact asks for; whether a body at rest has to look ahead before it takes the step.
    """
    zero = real(0.0)
    (
        th1, glide, gap1, raw_gap, vx1, vz1, om1, mode1, slip1, lost, missed, cut, looks,
    ) = integrate(
        body, knobs.gravity, weight, view, mode, slip, a, dv, d, more, theta, gap, vx, vz, omega
    )  # fmt: skip
    up, down, lands, deep = contacts_at(body, view, mode1, th1, gap1, raw_gap, vz1, om1)
    over = (up and view.high >= HALF_PI) or (down and view.low <= -HALF_PI)
    th2 = wp.where(up, view.high, wp.where(down, view.low, th1))
    vx2, vz2, om2, mode2, slip2, corner2, lost2, hit, tail, needed = end_of_step(
        body, weight, view, up and not over, down and not over, lands, kick, a, mode1,
        slip1, th2, vx1, vz1, om1,
    )  # fmt: skip
    sound = th2 - th2 == zero and om2 - om2 == zero and vx2 - vx2 == zero and vz2 - vz2 == zero
    spot = view.x * view.z
    sound = sound and time1 - time1 == zero and spot - spot == zero
    mode2 = wp.where(sound, wp.where(over, OVERTURNED, mode2), BROKEN)
    waits = live and looks and sound and not looked
    taken = live and not (missed and sound) and not waits
    turns = taken and omega * om1 < zero
    rise = omega * d / (omega - om1)
    return (
        wp.where(taken, corner2, corner),
        wp.where(taken, th2, theta), wp.where(taken, slide + glide, slide),
        wp.where(taken, wp.where(lands, zero, gap1), gap), wp.where(taken, vx2, vx),
        wp.where(taken, vz2, vz), wp.where(taken, om2, omega),
        wp.where(taken, slip2, slip), wp.where(taken, mode2, mode),
        wp.where(taken, time1, time), segment + wp.where(taken and passed, 1, 0),
        wp.where(taken, base + dv + kick, base),
        wp.where(taken, NEVER, wp.where(live and not waits, cut, cap)),
        wp.where(turns, theta + HALF * omega * rise, zero), time + wp.where(turns, rise, zero),
        wp.where(taken, lost + lost2, zero), wp.where(taken, tail, zero), taken and hit, taken,
        wp.where(taken, deep, zero), wp.where(taken, needed, zero), waits,
    )  # fmt: skip
