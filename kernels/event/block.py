"""Second-order contact step of a rocking block, impacts located.

The block lives in the frame of the base: mass 1, clockwise rotation theta, half sizes b and h,
inertia I; corner (X, Z) from the centre of mass moves at (vx + omega Z, vz - omega X). Every
step is seen so that the block leans to +x (reflected where it leans to -x): its lower corner is

    X = b cos(theta) - h sin(theta),   Z = -b sin(theta) - h cos(theta).

One step of length d (Moreau 1988, Jean 1999; at the midpoint second order in d):

    1. mean velocity v_m = v - (dV/2, g d/2, 0) + M^-1 J^T l, J at theta + omega d/2, dV the change
       of the base velocity in the step. Contact impulses l = (n, f) exactly: a sticking corner
       has no mean velocity, a sliding one no normal mean velocity and |f| = friction n; without
       n >= 0 the corner leaves. On the base lies the block where both corners keep n >= 0;
    2. q = q + d v_m and v = 2 v_m - v; the lower corner of a block in contact is put back on the
       base, and where it sticks also along it (this removes the drift);
    3. if an event lies inside the step (the other corner or a flying one lands, a sliding corner
       stops, a resting block lifts, a sticking corner slips, a sliding one leaves, the block has
       overturned), nothing is taken: the next step ends there, by the parabola through both ends
       and the first velocity. Whether a corner slips or leaves says the force that holds it, from
       the accelerations at both ends (`hold_reserve` in event/block_contact.py); as long as the one
       at the start is surely inside its bound, the corner does in the step what it did before;
    4. v is projected on the contacts at the end of the step, along their force. Where a corner
       lands or the base steps its velocity this is the inelastic impact with Coulomb friction,
       one contact or both at once, whichever obeys the contact law. The base's velocity steps
       fall on ends of steps. Where sticking and leaving both obey it, the corner sticks. Sliding
       that has turned round by now ends.

A corner that leaves and lands, or a swing that dips through zero and turns back, inside one step
is not seen; what they would do is of the order of d^2.

A lane's state: theta [rad]; slide of the lower corner along the base and its gap above it [m];
vx, vz [m/s] and omega [rad/s] relative to the base; slip, the direction in which the corner
slides (-1, 1, or 0 where it sticks); mode (FLYING, PIVOTING, FLAT, OVERTURNED, BROKEN); time [s],
segment (knots of the motion passed), base velocity [m/s], cap, the longest step allowed next
time [s]. `Record` below names what is observed.

Rest rule: after an impact on its other corner the block rests if, under the acceleration of that
moment (when sliding: under its friction), its next swing would stay below `rest_rotation` on
either side. The impacts that it leaves out take a time, as in housner/block.py, that is added to
the rest time.
"""

import warp as wp

from warprock.kernels.event.block_contact import (
    SOON,
    Block,
    held_lack,
    held_velocity,
    hold_reserve,
    lower_corner,
    may_rest,
    step_velocity,
    struck_velocity,
)
from warprock.kernels.modes import BROKEN, FLAT, FLYING, OVERTURNED, PIVOTING
from warprock.kernels.motion import Motion, base_velocity, knot_step, knot_time, series

NEARLY = by_precision(1.0e-6, 1.0e-4)
"""Part of the longest step by which the time of an event may be missed."""
GRAIN = by_precision(1.0e-14, 1.0e-6)
"""Round-off of a gap, as a part of the half height."""
LEAST = real(0.125)
"""A step in which a force reaches its bound is cut to no less than this part of it at once: the
force at the end of a step that is far too long says little about when."""
REACH = real(0.125)
"""Largest rotation in one step [rad]: keeps fast overturning inside the polynomials' range."""

SLOWEST = real(1.0e-30)
"""Keeps a quotient by an angular velocity of -0.0 positive [rad/s]."""


@wp.struct
class Knobs:
    """What a step needs to know of the settings."""

    gravity: real


@wp.func
def first_root(e0: real, slope: real, e1: real, d: real) -> real:
    """First root of the parabola that starts at e0 >= 0 with a slope and is below zero at d."""
    bend = (e1 - e0 - slope * d) / (d * d)
    square = slope * slope - real(4.0) * e0 * bend
    root = wp.sqrt(larger(square, real(0.0)))
    rises = slope > real(0.0)
    over = wp.where(rises, slope + root, TWO * e0)
    return smaller(over / wp.where(rises, -TWO * bend, root - slope), d)


@wp.func
def missed_event(
    flying: bool, theta: real, omega: real, theta1: real, omega1: real,
    gap: real, rise: real, gap1: real, rise1: real,
    slip: real, along: real, along1: real, reach: real, holds: bool, lack: real, lack1: real,
    d: real, per: real, near: real, grain: real,
):  # fmt: skip
    """Whether an event lies inside a step, and the length of the step that ends there.

    Args:
        flying: Whether no corner touches the base in the step.
        theta, omega: Rotation [rad] and its rate [rad/s] at the start; with a 1 at the end.
        gap, rise, along: Gap of the lower corner [m], its rate, and the corner's velocity along the
            base [m/s], at the start; with a 1 at the end.
        lack: `held_lack` at the start; with a 1 at the end.
        slip: Direction of sliding in the step.
        reach: How far a stop may be missed [m/s].
        holds: Whether at the start a force holds the block where it lies or a corner where it is.
        d, per: Length of the step [s] and its reciprocal.
        near: Time by which an event may be missed [s].
        grain: Gap that is round-off [m].
    """
    zero = real(0.0)
    past = theta1 > HALF_PI + near * size(omega1)
    below = theta1 < -near * size(omega1)
    sinks = flying and gap1 < -near * size(rise1) - grain
    stops = slip * along > zero and slip * along1 < -reach
    lifts = holds and lack1 < -SOON * lack and d > near
    e0 = wp.where(stops, slip * along, lack)
    e1 = wp.where(stops, slip * along1, lack1)
    slope = (e1 - e0) * per
    e0 = wp.where(sinks, gap, e0)
    e1 = wp.where(sinks, gap1, e1)
    slope = wp.where(sinks, rise, slope)
    e0 = wp.where(below, theta, e0)
    e1 = wp.where(below, theta1, e1)
    slope = wp.where(below, omega, slope)
    e0 = wp.where(past, HALF_PI - theta, e0)
    e1 = wp.where(past, HALF_PI - theta1, e1)
    slope = wp.where(past, -omega, slope)
    # Not shorter than `near`: with less than that left to go, the event counts as reached.
    least = wp.where(past or below or sinks or stops, HALF * near, larger(LEAST * d, HALF * near))
    cut = larger(first_root(e0, slope, e1, d), least)
    return past or below or sinks or stops or lifts, cut


if MOTION == "record":

    @wp.func
    def base_change(
        m: Motion, time: real, d: real, a: real, slope: real, base: real, kick: real
    ) -> real:
        """Change of the base velocity in a step [m/s]: the acceleration is linear in it."""
        return d * (a - HALF * d * slope)

else:

    @wp.func
    def base_change(
        m: Motion, time: real, d: real, a: real, slope: real, base: real, kick: real
    ) -> real:
        """Change of the base velocity in a step that ends at a time [m/s], without the kick."""
        zero = real(0.0)
        return base_velocity(m, time, zero, zero, zero) - base - kick


@wp.func
def step_length(
    block: Block, resting: bool, quiet: bool, omega: real, room: real, cap: real
) -> real:
    """Length of the next step [s]; a block that will stay at rest takes all that is left."""
    zero = real(0.0)
    d = smaller(smaller(block.longest_step, REACH / (size(omega) + SLOWEST)), cap)
    return larger(smaller(wp.where(resting and quiet, room, d), room), zero)


@wp.func
def integrate(
    block: Block, knobs: Knobs, mode: int, slip: real, a: real, dv: real, d: real,
    theta: real, gap: real, vx: real, vz: real, omega: real,
):  # fmt: skip
    """The step up to its end, before the projection; the block leans to +x.

    Returns:
        Rotation, slide along the base in the step, gap, velocity (three values), mode and
        direction of sliding in the step, energy lost per unit mass; whether an event was missed,
        the length of the step to it; whether the block falls on its other corner, whether its
        lower corner lands; sine and cosine of the rotation; how deep a corner is [m].
    """
    zero = real(0.0)
    per = real(1.0) / d
    x0, z0 = lower_corner(block, sine(theta), cosine(theta))
    a0 = TWO * dv * per - a
    reserve, surely = hold_reserve(block, knobs.gravity, slip, x0, z0, omega, a0)
    mx, mz, mo, mode1, slip1, lost = step_velocity(
        block, mode, slip, surely, theta, vx, vz, omega, dv, d, d * knobs.gravity
    )
    idle = d <= zero
    theta1 = theta + d * mo
    s1, c1 = sine(theta1), cosine(theta1)
    x1, z1 = lower_corner(block, s1, c1)
    flying = mode1 == FLYING
    glide = wp.where(flying or slip1 != zero, d * mx + (x1 - x0), zero)
    raw_vx = TWO * mx - vx
    raw_omega = TWO * mo - omega
    along = vx + omega * z0
    # Not projected: where friction nearly jams the block, that would hide how far it overshot.
    along1 = raw_vx + raw_omega * z1
    near = NEARLY * block.longest_step
    reach = near * size(along1 - along) * per
    # Sliding ends where it would turn round.
    turned = slip1 * along1 <= wp.where(slip * along > zero, reach, zero)
    slip1 = wp.where(turned and not idle, zero, slip1)
    vx1, vz1, omega1 = held_velocity(block, mode1, slip1, s1, c1, raw_vx, TWO * mz - vz, raw_omega)
    # Nor does it go on where its own friction turned it round in the projection.
    slip1 = wp.where(slip1 * (vx1 + omega1 * z1) <= zero and not idle, zero, slip1)
    glide = wp.where(slip == zero and slip1 == zero and not flying, zero, glide)
    raw_gap = gap + d * mz + (z1 - z0)
    gap1 = wp.where(flying, raw_gap, zero)
    gap1 = wp.where(mode != FLYING, larger(gap1, zero), gap1)
    rise1 = vz1 - omega1 * x1
    reserve1, _surely = hold_reserve(block, knobs.gravity, slip, x1, z1, omega1, a)
    holds, lack, lack1 = held_lack(block, mode, mode1, slip, surely, reserve, reserve1, a0, a)
    grain = GRAIN * block.half_height
    missed, cut = missed_event(
        flying, theta, omega, theta1, omega1, gap, vz - omega * x0, gap1, rise1,
        slip, along, along1, reach, holds, lack, lack1, d, per, near, grain,
    )  # fmt: skip
    falls = mode1 != FLAT and omega1 < zero and theta1 <= -near * omega1
    lands = flying and rise1 < zero and gap1 <= grain - near * rise1
    return (
        theta1, glide, gap1, vx1, vz1, omega1, mode1, slip1, lost,
        missed and not idle, cut, falls, lands, s1, c1,
        larger(-raw_gap, real(-2.0) * block.half_width * s1 - raw_gap),
    )  # fmt: skip


@wp.func
def end_of_step(
    block: Block, gravity: real, falls: bool, lands: bool, kick: real, a: real, mode: int,
    slip: real, s: real, c: real, theta: real, vx: real, vz: real, omega: real,
):  # fmt: skip
    """What the end of a step does to the velocities; the block leans to +x.

    Returns:
        -1 where the block is now seen from the other side, else 1; seen from there velocity
        (three values), mode and direction of sliding; energy lost per unit mass; whether the
        other corner or a flying one hit the base; time of the impacts that resting leaves out.
    """
    zero = real(0.0)
    one = real(1.0)
    hit = lands or (falls and mode == PIVOTING)
    struck = hit or (kick != zero and mode != FLYING)
    level = falls or mode == FLAT
    kicked = vx - kick
    turn = wp.where(falls, -one, wp.where(mode == FLAT and struck, sign_of(kicked), one))
    vx1, vz1, omega1, mode1, slip1, lost = struck_velocity(
        block, level or theta == zero,
        wp.where(level, zero, s), wp.where(level, one, c), turn * kicked, vz, turn * omega,
    )  # fmt: skip
    # The base's work on the block is at the mean of both velocities: see account.py.
    lost = lost - HALF * turn * kick * (vx1 - turn * kicked)
    vx1 = wp.where(struck, vx1, turn * kicked)
    vz1 = wp.where(struck, vz1, vz)
    omega1 = wp.where(struck, omega1, turn * omega)
    mode1 = wp.where(struck, mode1, mode)
    slip1 = wp.where(struck, slip1, turn * slip)
    lost = wp.where(struck, lost, zero)
    pull = wp.where(slip1 != zero, block.friction * gravity, size(a))
    stays, tail = may_rest(block, gravity, omega1, omega, pull)
    rests = stays and hit and level and mode1 == PIVOTING
    tail = wp.where(rests, tail, zero)
    glides = wp.where(slip1 != zero, vx1, zero)
    slip1 = wp.where(rests and slip1 != zero, sign_of(vx1), slip1)
    rest_lost = HALF * (vx1 * vx1 - glides * glides + vz1 * vz1 + omega1 * omega1 * block.inertia)
    return (
        turn,
        wp.where(rests, glides, vx1),
        wp.where(rests, zero, vz1),
        wp.where(rests, zero, omega1),
        wp.where(rests, FLAT, mode1),
        slip1,
        lost + wp.where(rests, rest_lost, zero),
        hit,
        tail,
    )


@wp.func
def step(
    block: Block, knobs: Knobs, m: Motion, sample: real, sample_slope: real, end: real, going: bool,
    theta: real, slide: real, gap: real, vx: real, vz: real, omega: real, slip: real, mode: int,
    time: real, segment: int, base: real, cap: real,
):  # fmt: skip
    """One trial step of one lane, at most to its next knot or to `end`.

    From `theta` on the lane's state, see the head of this file; the step returns it in the same
    order, unchanged but for `cap` where an event lay inside. Behind it: highest turning point in
    the step [rad] and its time [s], energy lost per unit mass [J/kg], time of the impacts that
    resting leaves out [s], whether an impact ended the step, whether the step was taken, and how
    deep a corner was in the base at its end, before it was put back [m].
    """
    zero = real(0.0)
    live = mode < OVERTURNED and going
    knot = knot_time(m, segment)
    target = smaller(knot, end)
    room = target - time
    resting = mode == FLAT and slip == zero
    d = step_length(block, resting, segment == 0 or knot >= NEVER, omega, room, cap)
    d = wp.where(live, d, zero)
    time1 = wp.where(d >= room, target, time + d)
    passed = time1 >= knot
    kick = wp.where(passed, knot_step(m, segment), zero)
    a, jerk, _a2, _a3, _a4, _a5, _a6, _a7, _a8 = series(m, segment, time1, sample, sample_slope)
    dv = base_change(m, time1, d, a, jerk, base, kick)

    # Seen so that the block leans to +x, or would if it lifted.
    tends = wp.where(slip != zero, slip, -dv)
    upright = wp.where(mode == FLAT, tends, omega)
    side = sign_of(wp.where(theta != zero, theta, upright))
    th, om, va = side * theta, side * omega, side * vx
    th1, glide, gap1, vx1, vz1, om1, mode1, slip1, lost, missed, cut, falls, lands, s, c, deep = (
        integrate(block, knobs, mode, side * slip, side * a, side * dv, d, th, gap, va, vz, om)
    )
    turn, vx2, vz2, om2, mode2, slip2, lost2, hit, tail = end_of_step(
        block, knobs.gravity, falls, lands, side * kick, a, mode1, slip1, s, c, th1,
        vx1, vz1, om1,
    )  # fmt: skip
    over = th1 >= HALF_PI - NEARLY * block.longest_step * om1
    th2 = wp.where(falls or mode1 == FLAT, zero, wp.where(over, HALF_PI, th1))
    sound = th2 - th2 == zero and om2 - om2 == zero and vx2 - vx2 == zero and vz2 - vz2 == zero
    size2 = block.half_width * block.half_height
    sound = sound and time1 - time1 == zero and size2 - size2 == zero
    mode2 = wp.where(sound, wp.where(over, OVERTURNED, mode2), BROKEN)
    taken = live and not (missed and sound)
    turns = taken and om > zero and om1 < zero
    rise = om * d / (om - om1)
    face = side * turn
    return (
        wp.where(taken, face * th2, theta), wp.where(taken, slide + side * glide, slide),
        wp.where(taken, wp.where(lands, zero, gap1), gap), wp.where(taken, face * vx2, vx),
        wp.where(taken, vz2, vz), wp.where(taken, face * om2, omega),
        wp.where(taken, face * slip2, slip), wp.where(taken, mode2, mode),
        wp.where(taken, time1, time), segment + wp.where(taken and passed, 1, 0),
        wp.where(taken, base + dv + kick, base), wp.where(taken, NEVER, wp.where(live, cut, cap)),
        wp.where(turns, th + HALF * om * rise, zero), time + wp.where(turns, rise, zero),
        wp.where(taken, lost + lost2, zero), wp.where(taken, tail, zero), taken and hit, taken,
        wp.where(taken, deep, zero),
    )  # fmt: skip
