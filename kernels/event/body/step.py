"""Second-order contact step of a body on contact points, impacts located.

The scheme is that of event/block/step.py; here is what differs. A body turns about corner k, or
flies with corner k lowest, while its rotation is between those at which the edges on both sides of
k lie flat (shape/body.py). A step ends where one of these edges comes to lie flat. The corner at
the other end of the edge then lands, which is the impact, or becomes the lowest one in flight. A
body can lie on any edge. It tips about the end of the edge that is nearer to the centre of
pressure. It has overturned at a right angle from its first pose.

The state is that of event/block/state.py, with theta [rad] from the first pose, and the number of
corner k. Of a body that lies flat, k is the end of its edge at -x. The slide is that of the point
of contact along the base, in excess of what the body has rolled.

After an impact on another corner the body rests on the edge between the two if its next swing would
stay below `rest_rotation` on either side.

Conditions have names before they are joined: `and` and `or` branch around their second operand, and
packed lanes keep a mask for every branch with arithmetic or a field in it.
"""

import warp as wp

from warprock.kernels.event.block.begin import REACH, SLOWEST, base_change, first_root
from warprock.kernels.event.block.contact import SOON, Contact, Lever, Velocity
from warprock.kernels.event.block.state import End, Shown, Span, State, is_at_rest
from warprock.kernels.event.block.step import GRAIN, LEAST, NEARLY, Knobs, Margin
from warprock.kernels.event.body.contact import (
    Body,
    Edge,
    bounds,
    held_velocity,
    hold_reserve,
    least_lack,
    mean_velocity,
)
from warprock.kernels.event.body.impact import end_step
from warprock.kernels.event.body.view import View, edge_below, find_contacts
from warprock.kernels.event.body.weight import Weight, fall_in, nearest_lack
from warprock.kernels.event.lift import held_time, round_off
from warprock.kernels.lane.modes import BROKEN, FLAT, FLYING, OVERTURNED, PIVOTING
from warprock.kernels.motion.kinds import (
    LINEAR,
    Acceleration,
    Ground,
    Motion,
    expand,
    knot_step,
    knot_time,
)
from warprock.kernels.shape.above import Above
from warprock.kernels.shape.body import rotated_x, rotated_z


@wp.struct
class Footing:
    """Corners of a body after a step.

    Attributes:
        corner: Corner k, see the head of this file.
        needed: Friction that a prescribed impact needs, see `Blow`.
        asks: Whether a body at rest has to look ahead before it takes the step.
    """

    corner: int
    needed: real
    asks: bool


@wp.func
def begin_step(
    body: Body, m: Motion, ground: Ground, end: real, live: bool, s: State, above: Above
):  # fmt: skip
    """The length of a trial step of a lane, and the motion of the base in it.

    Returns:
        The step; by how much the acceleration of the base may be larger inside it than at its ends
        [m/s^2].
    """
    zero = real(0.0)
    knot = knot_time(m, s.segment)
    target = smaller(knot, end)
    still = s.segment == 0 or knot >= NEVER
    if VERTICAL:
        lifts = knot_time(above.motion, above.segment)
        target = smaller(lifts, target)
        still = still and (above.segment == 0 or lifts >= NEVER)
    room = larger(target - s.time, zero)
    d = smaller(smaller(body.longest_step, REACH / (size(s.omega) + SLOWEST)), s.cap)
    quiet = s.mode == FLAT and s.slip == zero and still
    d = smaller(wp.where(quiet, room, d), room)
    d = wp.where(live, d, zero)
    time = wp.where(d >= target - s.time, target, s.time + d)
    passed = time >= knot
    kick = wp.where(passed, knot_step(m, s.segment), zero)
    a = expand(m, s.segment, time, ground.value, ground.slope)
    more = real(0.0)
    if not LINEAR:
        more = d * (size(a.a1) + d * size(a.a2))
        if VERTICAL:
            # Without a bound on how much lighter the body becomes, it looks ahead in every step.
            more = NEVER
    dv = base_change(m, time, d, a.a0, a.a1, s.base, kick)
    per = real(1.0) / d
    return Span(d, time, passed, TWO * dv * per - a.a0, a.a0, dv, kick), more


@wp.func
def look_ahead(
    body: Body, gravity: real, edge: Edge, m: Motion, ground: Ground, end: real, s: State,
    above: Above,
) -> real:  # fmt: skip
    """Longest step of a body at rest [s], up to where the base lets it go (event/lift.py)."""
    knot = smaller(knot_time(m, s.segment), end)
    if VERTICAL:
        knot = smaller(knot, knot_time(above.motion, above.segment))
    d = smaller(body.longest_step, knot - s.time)
    a = expand(m, s.segment, s.time, ground.value, ground.slope)
    u = Acceleration()
    if VERTICAL:
        u = expand(above.motion, above.segment, s.time, above.value, above.slope)
    back, ahead = bounds(body, edge)
    lack, bound = nearest_lack(a, u, gravity, back, ahead, d)
    return held_time(lack, bound, round_off(lack, bound, s.time), d)


@wp.func
def find_event(
    body: Body, view: View, edge: Edge, contact: Contact, start: Margin, end: Margin, slows: real,
    d: real,
):  # fmt: skip
    """Whether an event lies inside a step, and the length of the step that ends there.

    Args:
        body: The body.
        view: The corner and its neighbours.
        edge: The edge it lies on, if it is flat.
        contact: Its mode in the step, and the direction in which it slides at the start.
        start, end: Distances from events at both ends of the step; the reserve at the end is NEVER
            where no force surely holds a corner at the start.
        slows: Rate of the sliding speed at the start [m/s^2].
        d: Length of the step [s].
    """
    zero = real(0.0)
    near, per, slip = NEARLY * body.longest_step, real(1.0) / d, contact.slip
    grain = GRAIN * edge.height
    past = end.theta > view.high + near * size(end.omega)
    below = end.theta < view.low - near * size(end.omega)
    flying, deep = contact.mode == FLYING, end.gap < -near * size(end.rise) - grain
    sinks = flying and deep
    reach = near * size(end.along - start.along) * per
    ahead, back = slip * start.along > zero, slip * end.along < -reach
    stops = ahead and back
    lifts = end.reserve < -SOON * start.reserve and d > near
    e0 = wp.where(stops, slip * start.along, start.reserve)
    e1 = wp.where(stops, slip * end.along, end.reserve)
    slope = wp.where(stops, slows, (e1 - e0) * per)
    e0 = wp.where(sinks, start.gap, e0)
    e1 = wp.where(sinks, end.gap, e1)
    slope = wp.where(sinks, start.rise, slope)
    e0 = wp.where(below, start.theta - view.low, e0)
    e1 = wp.where(below, end.theta - view.low, e1)
    slope = wp.where(below, start.omega, slope)
    e0 = wp.where(past, view.high - start.theta, e0)
    e1 = wp.where(past, view.high - end.theta, e1)
    slope = wp.where(past, -start.omega, slope)
    # Not shorter than `near`: an event nearer than that counts as reached.
    least = wp.where(past or below or sinks or stops, HALF * near, larger(LEAST * d, HALF * near))
    cut = larger(first_root(e0, slope, e1, d), least)
    return past or below or sinks or stops or lifts, cut


@wp.func
def step_velocity(
    body: Body, view: View, edge: Edge, s: State, hold: bool, span: Span, fall: real
):  # fmt: skip
    """`mean_velocity` of a step of a given length; a step of length zero changes nothing.

    Args:
        body: The body.
        view: The corner and its neighbours.
        edge: The edge it lies on, if it is flat.
        s: State at the start.
        hold: Whether a pivoting corner that sticks does so in the whole step.
        span: The step.
        fall: What gravity makes of a velocity in it [m/s].
    """
    sticks = s.slip == real(0.0)
    middle = s.theta + HALF * span.d * s.omega
    sn, cs = sine(middle), cosine(middle)
    mean, held, lost = mean_velocity(
        body, Contact(s.mode, s.slip), hold and sticks, edge,
        Lever(rotated_x(view.x, view.z, sn, cs), rotated_z(view.x, view.z, sn, cs) - body.radius),
        Velocity(s.vx - HALF * span.dv, s.vz - HALF * fall, s.omega),
    )  # fmt: skip
    idle = span.d <= real(0.0)
    return (
        Velocity(
            wp.where(idle, s.vx, mean.x),
            wp.where(idle, s.vz, mean.z),
            wp.where(idle, s.omega, mean.omega),
        ),
        Contact(wp.where(idle, s.mode, held.mode), wp.where(idle, s.slip, held.slip)),
        wp.where(idle, real(0.0), lost),
    )


@wp.func
def integrate(
    body: Body, gravity: real, weight: Weight, view: View, s: State, span: Span, more: real
):  # fmt: skip
    """The step up to its end, before an impact there.

    Args:
        body: The body.
        gravity: [m/s^2].
        weight: Its weight in the step.
        view: The corner and its neighbours.
        s: State at the start.
        span: The step.
        more: By how much the acceleration of the base may be larger inside the step than at its
            ends [m/s^2]; negative for a body that has looked ahead.

    Returns:
        The end of the step; whether an event lies inside, and the length of the step to it; whether
        the base may let go of the body at rest.
    """
    zero = real(0.0)
    d, per, idle, r = span.d, real(1.0) / span.d, span.d <= zero, body.radius
    s0, c0 = sine(s.theta), cosine(s.theta)
    at0 = Lever(rotated_x(view.x, view.z, s0, c0), rotated_z(view.x, view.z, s0, c0) - r)
    edge = edge_below(body, view, s0, c0)
    reserve, surely = hold_reserve(body, weight.start, s.slip, at0, s.omega, span.a0)
    mean, held, lost = step_velocity(body, view, edge, s, surely, span, fall_in(weight, gravity, d))
    theta = s.theta + d * mean.omega
    s1, c1 = sine(theta), cosine(theta)
    at1 = Lever(rotated_x(view.x, view.z, s1, c1), rotated_z(view.x, view.z, s1, c1) - r)
    flying, slides = held.mode == FLYING, held.slip != zero
    glide = d * mean.x + (at1.x - at0.x) - r * (theta - s.theta)
    glide = wp.where(flying or slides, glide, zero)
    free = Velocity(TWO * mean.x - s.vx, TWO * mean.z - s.vz, TWO * mean.omega - s.omega)
    along = s.vx + s.omega * at0.z
    # Before the projection, which would hide how far a body overshot that friction nearly jams.
    along1 = free.x + free.omega * at1.z
    near = NEARLY * body.longest_step
    reach = near * size(along1 - along) * per
    # Sliding ends where it would reverse.
    turned = held.slip * along1 <= wp.where(s.slip * along > zero, reach, zero)
    slip = wp.where(turned and not idle, zero, held.slip)
    v = held_velocity(body, Contact(held.mode, slip), at1, free)
    # Sliding also ends where its own friction reversed it in the projection.
    slip = wp.where(slip * (v.x + v.omega * at1.z) <= zero and not idle, zero, slip)
    stuck, sticks = s.slip == zero, slip == zero
    glide = wp.where(stuck and sticks and not flying, zero, glide)
    raw_gap = s.gap + d * mean.z + (at1.z - at0.z)
    gap = wp.where(flying, raw_gap, zero)
    gap = wp.where(s.mode != FLYING, larger(gap, zero), gap)
    reserve1, _surely = hold_reserve(body, weight.end, s.slip, at1, v.omega, span.a1)
    pivoted, pivots = s.mode == PIVOTING, held.mode == PIVOTING
    holds = surely and (pivoted or pivots)
    near_lift = least_lack(body, weight, edge, span.a0, span.a1) < more + SOON * gravity
    looks = is_at_rest(s) and more >= zero and near_lift
    # In a short slide the speed begins to fall inside the step: its secant is far from its slope.
    slows = wp.where(held.mode == FLAT, -s.slip * span.a0 - body.friction * weight.start,
                     s.slip * (along1 - along) * per)  # fmt: skip
    start = Margin(s.theta, s.omega, s.gap, s.vz - s.omega * at0.x, along, reserve)
    last = Margin(
        theta, v.omega, gap, v.z - v.omega * at1.x, along1, wp.where(holds, reserve1, NEVER)
    )
    missed, cut = find_event(body, view, edge, Contact(held.mode, s.slip), start, last, slows, d)
    end = End(theta, glide, gap, v.x, v.z, v.omega, held.mode, slip, lost, -raw_gap)
    return end, missed and not idle, cut, looks


@wp.func
def step(
    body: Body, knobs: Knobs, weight: Weight, view: View, live: bool, span: Span, more: real,
    s: State,
):  # fmt: skip
    """One trial step of one lane, which `begin_step` began; `more` as of `integrate`.

    Returns:
        The state after it, unchanged but for `cap` where an event lay inside; what the step adds to
        the response; the corners.
    """
    zero = real(0.0)
    last, missed, cut, looks = integrate(body, knobs.gravity, weight, view, s, span, more)
    up, down, lands, deep = find_contacts(body, view, last)
    last_up, last_down = view.high >= HALF_PI, view.low <= -HALF_PI
    over = (up and last_up) or (down and last_down)
    omega = last.omega
    last.theta = wp.where(up, view.high, wp.where(down, view.low, last.theta))
    after = end_step(body, weight, view, up and not over, down and not over, lands, span, last)
    spot = view.x * view.z
    # One comparison for all: the difference of a number that is not finite from itself is NaN.
    broken = (last.theta - last.theta) + (after.omega - after.omega) + (after.vx - after.vx)
    broken = broken + (after.vz - after.vz) + (span.time - span.time) + (spot - spot)
    sound = broken == zero
    mode = wp.where(sound, wp.where(over, OVERTURNED, after.mode), BROKEN)
    asks = live and looks and sound
    taken = live and not (missed and sound) and not asks
    turned, passed, hit = s.omega * omega < zero, span.passed, after.hit
    turns = taken and turned
    rise = s.omega * span.d / (s.omega - omega)
    new = State(
        wp.where(taken, last.theta, s.theta), wp.where(taken, s.slide + last.glide, s.slide),
        wp.where(taken, wp.where(lands, zero, last.gap), s.gap), wp.where(taken, after.vx, s.vx),
        wp.where(taken, after.vz, s.vz), wp.where(taken, after.omega, s.omega),
        wp.where(taken, after.slip, s.slip), wp.where(taken, mode, s.mode),
        wp.where(taken, span.time, s.time), s.segment + wp.where(taken and passed, 1, 0),
        wp.where(taken, s.base + span.dv + span.kick, s.base),
        wp.where(taken, NEVER, wp.where(live and not asks, cut, s.cap)),
    )  # fmt: skip
    shown = Shown(
        taken, taken and hit, wp.where(turns, s.theta + HALF * s.omega * rise, zero),
        s.time + wp.where(turns, rise, zero), wp.where(taken, last.lost + after.lost, zero),
        wp.where(taken, after.tail, zero), wp.where(taken, deep, zero),
    )  # fmt: skip
    return new, shown, Footing(after.corner, wp.where(taken, after.needed, zero), asks)
