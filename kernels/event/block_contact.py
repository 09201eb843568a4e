"""Contact of a planar block with its base: exact small solves.

Mass 1, clockwise rotation, half sizes b and h, inverse inertia w [1/m^2]; corner (X, Z) from the
centre of mass moves at (vx + omega Z, vz - omega X). The block leans to +x or not at all, so its
lower corner is X = b cos(theta) - h sin(theta), Z = -b sin(theta) - h cos(theta). Impulses n
(normal, not negative) and f along the base (|f| <= friction n, against the sliding) change its
velocities by K (n, f) with

    Knn = 1 + w X^2,   Ktt = 1 + w Z^2,   Knt = -w X Z.

A corner that sticks takes both velocities to zero; one that slides takes the normal one to zero
with |f| = friction n. With both corners at the base a flat block has three unknowns, f, n of one
corner and n of the other, and the law is tried case by case: one corner, else both.
"""

import warp as wp

from warprock.kernels.modes import FLAT, FLYING, PIVOTING

SOON = real(1.0e-3)
"""Part by which a force may miss its bound: the error in velocity is of its square."""


@wp.struct
class Block:
    """What a step needs to know of one lane's block."""

    half_width: real
    half_height: real
    inertia: real
    inverse_inertia: real
    inverse_pivot_inertia: real
    friction: real
    hold_acceleration: real
    rest_rotation: real
    longest_step: real
    short_step: real
    step_limit: int


@wp.func
def lower_corner(block: Block, s: real, c: real):
    """Lower corner from the centre of mass [m], from the sine and cosine of the rotation."""
    return (
        fused_less(block.half_height, s, block.half_width * c),
        fused_less(block.half_width, s, -block.half_height * c),
    )


@wp.func
def corner_impulse(
    mu: real, w: real, x: real, z: real, u: real, s: real, hold: bool, slides: bool, drag: real
):
    """Impulses of one corner on a block of mass 1.

    Args:
        mu: Friction coefficient.
        w: Inverse inertia [1/m^2].
        x, z: Corner from the centre of mass [m].
        u: Normal velocity of the corner without contact [m/s].
        s: Tangential velocity of the corner without contact [m/s].
        hold: Whether the corner sticks whatever force it takes.
        slides, drag: Whether it slides, with friction in the direction `drag` (-1 or 1).

    Returns:
        Normal and tangential impulse [m/s]; whether the corner sticks; direction of friction.
    """
    one = real(1.0)
    kn = fused(w * x, x, one)
    kt = fused(w * z, z, one)
    k = -w * x * z
    n = fused_less(kt, u, k * s)
    f = fused_less(kn, s, k * u)
    fits = n >= real(0.0) and size(f) <= mu * n
    sign = wp.where(slides, drag, sign_of(f))
    # Painleve's paradox: no normal force is consistent with this sliding; the corner jams.
    jams = fused(sign * mu, k, kn) <= real(0.0)
    sign = wp.where(jams, -sign, sign)
    sticks = hold or wp.where(slides, jams, fits)
    scale = one / wp.where(sticks, fused(w, fused(x, x, z * z), one), fused(sign * mu, k, kn))
    n = wp.where(sticks, n, -u) * scale
    return n, wp.where(sticks, f * scale, sign * mu * n), sticks, sign


@wp.func
def hold_reserve(block: Block, gravity: real, slip: real, x: real, z: real, omega: real, a: real):
    """Margin of the force at a pivoting corner until it slides; of a sliding one until it leaves.

    From the accelerations of the corner without contact: it falls at g and is flung out by the
    rotation. The force that holds it there stays inside its cone of friction while the reserve is
    positive; one that slides leaves where nothing presses it on the base any more.

    Args:
        block: The block.
        gravity: [m/s^2].
        slip: Direction of sliding, 0 where the corner sticks.
        x, z: Corner from the centre of mass [m].
        omega: Angular velocity [rad/s].
        a: Acceleration of the base [m/s^2].

    Returns:
        The reserve; whether it is surely positive.
    """
    # Downwards and back; behind it the impulses that take both to zero, times 1 + w (x^2 + z^2).
    down = fused(omega * omega, z, gravity)
    back = fused(omega * omega, x, a)
    q = block.inverse_inertia * fused(x, back, z * down)
    n = fused(z, q, down)
    f = fused(x, q, back)
    slides = slip != real(0.0)
    grip = block.friction * n
    reserve = wp.where(slides, down, grip - size(f))
    return reserve, reserve > SOON * wp.where(slides, gravity, grip)


@wp.func
def mean_velocity(
    block: Block, mode: int, slip: real, hold: bool, theta: real, ux: real, uz: real, uo: real
):
    """Mean velocity of a step and the contact that makes it.

    Args:
        block: The block.
        mode: FLYING, PIVOTING or FLAT.
        slip: Direction of sliding at the start, 0 where the corner sticks.
        hold: Whether a pivoting corner sticks whatever force it takes.
        theta: Rotation at the middle of the step [rad].
        ux: Mean velocity along the base without contact [m/s].
        uz: Mean velocity across the base without contact [m/s].
        uo: Mean angular velocity without contact [rad/s].

    Returns:
        Mean velocity (three values); mode in the step; direction of sliding in the step; energy
        lost to friction per unit mass [J/kg].
    """
    zero = real(0.0)
    w = block.inverse_inertia
    x, z = lower_corner(block, sine(theta), cosine(theta))
    slides = slip != zero
    n, f, sticks, drag = corner_impulse(
        block.friction, w, x, z, fused_less(uo, x, uz), fused(uo, z, ux), hold, slides, -slip
    )
    on = mode != FLYING and (n > zero or hold or (sticks and n >= zero))
    n = wp.where(on, n, zero)
    f = wp.where(on, f, zero)
    # Flat on the base: the share of the trailing corner is what is left by the friction's moment.
    bound = -block.friction * uz
    flat_f = wp.where(slides, -slip * bound, larger(smaller(-ux, bound), -bound))
    share = fused_less(block.half_width, uz, block.half_height * flat_f)
    stays = mode == FLAT and share >= zero
    starts = size(ux) > bound
    mx = ux + wp.where(stays, flat_f, f)
    mo = wp.where(stays, zero, fused(w, fused_less(n, x, f * z), uo))
    flat_slip = wp.where(slides, slip, wp.where(starts, sign_of(ux), zero))
    pivot_slip = wp.where(sticks or not on, zero, -drag)
    lost = -wp.where(stays, flat_f * mx, f * fused(mo, z, mx))
    return (
        mx,
        wp.where(stays, zero, uz + n),
        mo,
        wp.where(stays, FLAT, wp.where(on, PIVOTING, FLYING)),
        wp.where(stays, flat_slip, pivot_slip),
        real(2.0) * lost,
    )


@wp.func
def step_velocity(
    block: Block, mode: int, slip: real, hold: bool, theta: real, vx: real, vz: real, omega: real,
    dv: real, d: real, fall: real,
):  # fmt: skip
    """`mean_velocity` of a step of a given length; a step of length zero changes nothing.

    Args:
        block: The block.
        mode, slip: See `mean_velocity`.
        hold: Whether a pivoting corner that sticks does so in the whole step.
        theta: Rotation at the start [rad].
        vx, vz: Velocity along the base at the start [m/s] and across it.
        omega: Angular velocity at the start [rad/s].
        dv: Change of the base velocity in the step [m/s].
        d: Length of the step [s].
        fall: What gravity makes of a velocity in it [m/s].
    """
    mx, mz, mo, mode1, slip1, lost = mean_velocity(
        block, mode, slip, hold and slip == real(0.0), fused(HALF * d, omega, theta),
        fused_less(HALF, dv, vx), fused_less(HALF, fall, vz), omega,
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
def held_velocity(
    block: Block, mode: int, slip: real, s: real, c: real, ux: real, uz: real, uo: real
):
    """Velocity at the end of a step, projected on its contact along the contact's force.

    Args:
        block: The block.
        mode: FLYING, PIVOTING or FLAT.
        slip: Direction of sliding, 0 where the corner sticks.
        s, c: Sine of the rotation and its cosine.
        ux: Velocity along the base before [m/s].
        uz: Velocity across the base before [m/s].
        uo: Angular velocity before [rad/s].
    """
    zero = real(0.0)
    w = block.inverse_inertia
    x, z = lower_corner(block, s, c)
    sticks = slip == zero
    n, f, _sticks, _drag = corner_impulse(
        block.friction, w, x, z, fused_less(uo, x, uz), fused(uo, z, ux), sticks, not sticks, -slip
    )
    pivots = mode == PIVOTING
    return (
        wp.where(mode == FLAT and sticks, zero, ux + wp.where(pivots, f, zero)),
        uz + wp.where(pivots, n, zero),
        wp.where(pivots, fused(w, fused_less(n, x, f * z), uo), uo),
    )
