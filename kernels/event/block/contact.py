"""Contact of a planar block with its base: exact small solves.

Mass 1, clockwise rotation, half sizes b and h, inverse inertia w [1/m^2]; corner (X, Z) from the
centre of mass moves at (vx + omega Z, vz - omega X). The block leans to +x or not at all, so its
lower corner is X = b cos(theta) - h sin(theta), Z = -b sin(theta) - h cos(theta). Impulses n
(normal, not negative) and f (along the base, against the sliding, |f| <= friction n) change its
velocities by K (n, f) with

    Knn = 1 + w X^2,   Ktt = 1 + w Z^2,   Knt = -w X Z.

A corner that sticks takes both velocities to zero; one that slides takes the normal one to zero
with |f| = friction n. With both corners at the base a flat block has three unknowns, f, n of one
corner and n of the other, and the law is tried case by case: one corner, else both.
"""

import warp as wp

from warprock.kernels.lane.modes import FLAT, FLYING, PIVOTING

SOON = real(1.0e-3)
"""Relative tolerance of a force at its bound; the error in velocity is of its square."""


@wp.struct
class Block:
    """One lane's block, of mass 1, and its longest steps.

    Attributes:
        half_width, half_height: Half sizes [m].
        inertia, inverse_inertia: About the centre of mass [m^2], [1/m^2].
        inverse_pivot_inertia: Reciprocal of the inertia about a corner [1/m^2].
        friction: Coefficient of friction.
        hold_acceleration: Acceleration of the base that lets the block go at rest [m/s^2].
        rest_rotation: Swing below which the block rests [rad].
        longest_step: Longest step [s].
        short_step: Longest step of second order [s].
        step_limit: Largest number of steps.
    """

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


@wp.struct
class Lever:
    """Vector from the centre of mass to a corner [m]."""

    x: real
    z: real


@wp.struct
class Velocity:
    """Velocity of the centre of mass relative to the base [m/s], and angular velocity [rad/s]."""

    x: real
    z: real
    omega: real


@wp.struct
class Contact:
    """How a block touches its base.

    Attributes:
        mode: FLYING, PIVOTING or FLAT.
        slip: Direction in which it slides, -1 or 1, or 0 where it sticks.
    """

    mode: int
    slip: real


@wp.func
def lower_corner(block: Block, theta: real) -> Lever:
    """The lower corner of a block that leans to +x by a rotation [rad]."""
    s, c = sine(theta), cosine(theta)
    return Lever(
        fused_less(block.half_height, s, block.half_width * c),
        fused_less(block.half_width, s, -block.half_height * c),
    )


@wp.func
def corner_impulse(
    mu: real, w: real, at: Lever, u: real, s: real, hold: bool, slides: bool, drag: real
):
    """Impulses of one corner on a block of mass 1.

    Args:
        mu: Friction coefficient.
        w: Inverse inertia [1/m^2].
        at: The corner.
        u: Normal velocity of the corner without contact [m/s].
        s: Tangential velocity of the corner without contact [m/s].
        hold: Whether the corner sticks, however large the force that holds it.
        slides, drag: Whether it slides, with friction in the direction `drag` (-1 or 1).

    Returns:
        Normal and tangential impulse [m/s]; whether the corner sticks; direction of friction.
    """
    one, x, z = real(1.0), at.x, at.z
    kn = fused(w * x, x, one)
    kt = fused(w * z, z, one)
    k = -w * x * z
    n = fused_less(kt, u, k * s)
    f = fused_less(kn, s, k * u)
    # A condition of its own: packed lanes keep a mask for what an `and` branches around.
    within = size(f) <= mu * n
    fits = n >= real(0.0) and within
    sign = wp.where(slides, drag, sign_of(f))
    # Painleve's paradox: no normal force is consistent with this sliding; the corner jams.
    jams = fused(sign * mu, k, kn) <= real(0.0)
    sign = wp.where(jams, -sign, sign)
    keeps = wp.where(slides, jams, fits)
    sticks = hold or keeps
    scale = one / wp.where(sticks, fused(w, fused(x, x, z * z), one), fused(sign * mu, k, kn))
    n = wp.where(sticks, n, -u) * scale
    return n, wp.where(sticks, f * scale, sign * mu * n), sticks, sign


@wp.func
def hold_reserve(block: Block, gravity: real, slip: real, at: Lever, omega: real, a: real):
    """Margin of the force at a pivoting corner until it slides; of a sliding one until it leaves.

    Relative to the base a free corner has the acceleration of gravity, the centripetal one of the
    rotation, and that of the base reversed. The force that cancels them stays inside the cone of
    friction while the reserve is positive. A sliding corner leaves where nothing presses it on the
    base any more.

    Args:
        block: The block.
        gravity: [m/s^2].
        slip: Direction of sliding, 0 where the corner sticks.
        at: The corner.
        omega: Angular velocity [rad/s].
        a: Acceleration of the base [m/s^2].

    Returns:
        The reserve; whether it is surely positive.
    """
    # Accelerations of the free corner; then the impulses that cancel them, times
    # 1 + w (x^2 + z^2).
    down = fused(omega * omega, at.z, gravity)
    back = fused(omega * omega, at.x, a)
    q = block.inverse_inertia * fused(at.x, back, at.z * down)
    n = fused(at.z, q, down)
    f = fused(at.x, q, back)
    slides = slip != real(0.0)
    grip = block.friction * n
    reserve = wp.where(slides, down, grip - size(f))
    return reserve, reserve > SOON * wp.where(slides, gravity, grip)


@wp.func
def mean_velocity(block: Block, contact: Contact, hold: bool, theta: real, free: Velocity):
    """Mean velocity of a step and the contact that makes it.

    Args:
        block: The block.
        contact: How it touches its base at the start.
        hold: Whether a pivoting corner sticks, however large the force that holds it.
        theta: Rotation at the middle of the step [rad].
        free: Mean velocity without contact.

    Returns:
        Mean velocity; contact in the step; energy lost to friction per unit mass [J/kg].
    """
    zero = real(0.0)
    w = block.inverse_inertia
    at = lower_corner(block, theta)
    mode, slip = contact.mode, contact.slip
    slides = slip != zero
    n, f, sticks, drag = corner_impulse(
        block.friction, w, at, fused_less(free.omega, at.x, free.z),
        fused(free.omega, at.z, free.x), hold, slides, -slip,
    )  # fmt: skip
    on = mode != FLYING and (n > zero or hold or (sticks and n >= zero))
    n = wp.where(on, n, zero)
    f = wp.where(on, f, zero)
    # Flat on the base: the moment of friction shifts the load off the trailing corner.
    bound = -block.friction * free.z
    flat_f = wp.where(slides, -slip * bound, larger(smaller(-free.x, bound), -bound))
    share = fused_less(block.half_width, free.z, block.half_height * flat_f)
    stays = mode == FLAT and share >= zero
    starts = size(free.x) > bound
    mx = free.x + wp.where(stays, flat_f, f)
    mo = wp.where(stays, zero, fused(w, fused_less(n, at.x, f * at.z), free.omega))
    flat_slip = wp.where(slides, slip, wp.where(starts, sign_of(free.x), zero))
    pivot_slip = wp.where(sticks or not on, zero, -drag)
    lost = -wp.where(stays, flat_f * mx, f * fused(mo, at.z, mx))
    return (
        Velocity(mx, wp.where(stays, zero, free.z + n), mo),
        Contact(
            wp.where(stays, FLAT, wp.where(on, PIVOTING, FLYING)),
            wp.where(stays, flat_slip, pivot_slip),
        ),
        real(2.0) * lost,
    )


@wp.func
def step_velocity(
    block: Block, contact: Contact, hold: bool, theta: real, v: Velocity, dv: real, d: real,
    fall: real,
):  # fmt: skip
    """`mean_velocity` of a step of a given length; a step of length zero changes nothing.

    Args:
        block: The block.
        contact: How it touches its base at the start.
        hold: Whether a pivoting corner that sticks does so in the whole step.
        theta: Rotation at the start [rad].
        v: Velocity there.
        dv: Change of the base velocity in the step [m/s].
        d: Length of the step [s].
        fall: Change of velocity by gravity in the step [m/s].
    """
    mean, held, lost = mean_velocity(
        block, contact, hold and contact.slip == real(0.0), fused(HALF * d, v.omega, theta),
        Velocity(fused_less(HALF, dv, v.x), fused_less(HALF, fall, v.z), v.omega),
    )  # fmt: skip
    idle = d <= real(0.0)
    return (
        Velocity(
            wp.where(idle, v.x, mean.x),
            wp.where(idle, v.z, mean.z),
            wp.where(idle, v.omega, mean.omega),
        ),
        Contact(wp.where(idle, contact.mode, held.mode), wp.where(idle, contact.slip, held.slip)),
        wp.where(idle, real(0.0), lost),
    )


@wp.func
def held_velocity(block: Block, contact: Contact, theta: real, free: Velocity) -> Velocity:
    """Velocity at the end of a step, projected on its contact along the contact's force.

    Args:
        block: The block.
        contact: How it touches its base.
        theta: Rotation [rad].
        free: Velocity before.
    """
    zero = real(0.0)
    w = block.inverse_inertia
    at = lower_corner(block, theta)
    sticks = contact.slip == zero
    n, f, _sticks, _drag = corner_impulse(
        block.friction, w, at, fused_less(free.omega, at.x, free.z),
        fused(free.omega, at.z, free.x), sticks, not sticks, -contact.slip,
    )  # fmt: skip
    pivots = contact.mode == PIVOTING
    return Velocity(
        wp.where(contact.mode == FLAT and sticks, zero, free.x + wp.where(pivots, f, zero)),
        free.z + wp.where(pivots, n, zero),
        wp.where(pivots, fused(w, fused_less(n, at.x, f * at.z), free.omega), free.omega),
    )
