"""Rocking about a corner that sticks, as a polynomial in time.

With (X, Z) the lower corner from the centre of mass of a block of mass 1 that leans to +x, I its
inertia and a the acceleration of the base, the block obeys while that corner stays where it is

    omega' = (a Z - g X) / (I + X^2 + Z^2),   X' = omega Z,   Z' = -omega X.

Every Taylor coefficient of the three follows from lower ones (Leibniz's rule). A step takes the
rotation to degree 6: what it leaves out is (p d)^6 / 6! of the angular velocity, p the frequency
parameter. The corner presses on the base with n = g - Z'' and pushes along it with f = a - X'': it
sticks while |f| <= friction n.
"""

import warp as wp

from warprock.kernels.event.block_contact import SOON, Block, step_velocity
from warprock.kernels.modes import PIVOTING
from warprock.kernels.motion import LINEAR

NEWTON_STEPS = 7
"""From the root of a parabola through the step's ends: round-off after two, or after some halvings
where that is far off, as it is of a block that has just lifted."""


@wp.func
def rocking_series(
    block: Block, gravity: real, x0: real, z0: real, w0: real,
    a0: real, a1: real, a2: real, a3: real, a4: real,
):  # fmt: skip
    """Taylor coefficients of a block that turns about its lower corner.

    Args:
        block: The block.
        gravity: [m/s^2].
        x0, z0: Corner from the centre of mass [m].
        w0: Angular velocity [rad/s].
        a0 to a4: Coefficients of the acceleration of the base.

    Returns:
        2 to 6 of the rotation; 2 of the corner, along the base and upwards.
    """
    # What is known last stands outermost in a sum, so that the rest of it need not wait.
    k = block.inverse_pivot_inertia
    w1 = k * fused_less(gravity, x0, a0 * z0)
    x1 = w0 * z0
    z1 = -w0 * x0
    w2 = OVER_2 * k * fused_less(gravity, x1, fused(a0, z1, a1 * z0))
    x2 = OVER_2 * fused(w1, z0, w0 * z1)
    z2 = -OVER_2 * fused(w1, x0, w0 * x1)
    pull3 = a1 * z1
    if not LINEAR:
        pull3 = fused(a2, z0, pull3)
    w3 = OVER_3 * k * fused_less(gravity, x2, fused(a0, z2, pull3))
    x3 = OVER_3 * fused(w2, z0, fused(w1, z1, w0 * z2))
    z3 = -OVER_3 * fused(w2, x0, fused(w1, x1, w0 * x2))
    pull4 = a1 * z2
    if not LINEAR:
        pull4 = fused(a2, z1, fused(a3, z0, pull4))
    w4 = OVER_4 * k * fused_less(gravity, x3, fused(a0, z3, pull4))
    x4 = OVER_4 * fused(w3, z0, fused(w2, z1, fused(w1, z2, w0 * z3)))
    z4 = -OVER_4 * fused(w3, x0, fused(w2, x1, fused(w1, x2, w0 * x3)))
    pull5 = a1 * z3
    if not LINEAR:
        pull5 = fused(a2, z2, fused(a3, z1, fused(a4, z0, pull5)))
    w5 = OVER_5 * k * fused_less(gravity, x4, fused(a0, z4, pull5))
    return (
        w1 * OVER_2, w2 * OVER_3, w3 * OVER_4, w4 * OVER_5, w5 * OVER_6, x2, z2,
    )  # fmt: skip


@wp.func
def rotation_after(
    theta: real, omega: real, t2: real, t3: real, t4: real, t5: real, t6: real, tau: real
) -> real:
    """Rotation a time after the start of a step, from its Taylor coefficients."""
    high = fused(tau, fused(tau, fused(tau, t6, t5), t4), t3)
    return fused(tau, fused(tau, fused(tau, high, t2), omega), theta)


@wp.func
def rate_after(
    omega: real, t2: real, t3: real, t4: real, t5: real, t6: real, tau: real
) -> real:  # fmt: skip
    """Angular velocity a time after the start of a step."""
    high = fused(tau, fused(tau, real(6.0) * t6, real(5.0) * t5), real(4.0) * t4)
    return fused(tau, fused(tau, fused(tau, high, real(3.0) * t3), real(2.0) * t2), omega)


@wp.func
def landing(
    theta: real, omega: real, t2: real, t3: real, t4: real, t5: real, t6: real, guess: real, d: real
) -> real:
    """Time in (0, d] at which a block that leans at its start stands upright, as it does not at d.

    Newton's method inside a shrinking bracket.
    """
    tau, low, high = real(guess), real(0.0), real(d)
    for _ in range(NEWTON_STEPS):
        at = rotation_after(theta, omega, t2, t3, t4, t5, t6, tau)
        low = wp.where(at > real(0.0), tau, low)
        high = wp.where(at > real(0.0), high, tau)
        tau = tau - at / rate_after(omega, t2, t3, t4, t5, t6, tau)
        tau = wp.where(tau >= low and tau <= high, tau, HALF * (low + high))
    return tau


@wp.func
def turning_point(
    theta: real, omega: real, t2: real, t3: real, t4: real, t5: real, t6: real, d: real,
    omega1: real,
):  # fmt: skip
    """Rotation and time at which a block that turns back in a step of length d does so."""
    per = d / (omega - omega1)
    secant = omega * per
    rate = rate_after(omega, t2, t3, t4, t5, t6, secant)
    at = rotation_after(theta, omega, t2, t3, t4, t5, t6, secant)
    late = rate * per
    return fused(HALF * rate, late, at), secant + late


@wp.func
def sticks_surely(block: Block, normal: real, along: real) -> bool:
    """Whether a corner pressed with a force per unit mass surely holds one along the base."""
    grip = block.friction * normal
    return grip - size(along) > SOON * grip and normal > real(0.0)


@wp.func
def advance(
    block: Block, gravity: real, mode: int, slip: real, surely: bool, dv: real, d: real,
    theta: real, vx: real, vz: real, omega: real,
    t2: real, t3: real, t4: real, t5: real, t6: real,
):  # fmt: skip
    """The step without events; the block leans to +x, see `integrate`.

    Returns:
        Mean velocity (three values); mode and direction of sliding in the step, energy lost per
        unit mass; whether the block rocks about a corner that sticks; coefficients 2 to 6 of the
        polynomial that the rotation follows in the step.
    """
    zero = real(0.0)
    mx, mz, mo, mode1, slip1, lost = step_velocity(
        block, mode, slip, surely, theta, vx, vz, omega, dv, d, d * gravity
    )
    sticks = surely and slip == zero and slip1 == zero and d > zero and mode1 == PIVOTING
    # A block at rest that lifts leans by the end, and on.
    leans = rotation_after(theta, omega, t2, t3, t4, t5, t6, d) > zero
    leans = leans and rate_after(omega, t2, t3, t4, t5, t6, d) > zero
    rocks = sticks and (mode == PIVOTING or leans)
    bend = wp.where(d > zero, (mo - omega) / d, zero)
    return (
        mx, mz, mo, mode1, slip1, lost, rocks,
        wp.where(rocks, t2, bend), wp.where(rocks, t3, zero), wp.where(rocks, t4, zero),
        wp.where(rocks, t5, zero), wp.where(rocks, t6, zero),
    )  # fmt: skip
