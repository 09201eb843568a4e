"""Impacts of a planar block on its base, and when it rests after one.

See event/block.py; the block leans to +x or not at all, as in event/block_contact.py.
"""

import warp as wp

from warprock.kernels.event.block_contact import Block, corner_impulse, lower_corner
from warprock.kernels.modes import FLAT, FLYING, PIVOTING


@wp.func
def struck_velocity(block: Block, flat: bool, s: real, c: real, ux: real, uz: real, uo: real):
    """Velocity after an inelastic impact: a corner has landed or the base stepped its velocity.

    With both corners at the base one is struck, or both are where the other would sink then: as
    `law_velocity` in event/body_contact.py.

    Args:
        block: The block.
        flat: Whether both corners are at the base.
        s, c: Sine of the rotation and its cosine.
        ux: Velocity along the base before [m/s].
        uz: Velocity across the base before [m/s].
        uo: Angular velocity before [rad/s].

    Returns:
        Velocity (three values), mode, direction of sliding, energy lost per unit mass [J/kg].
    """
    zero = real(0.0)
    w = block.inverse_inertia
    x, z = lower_corner(block, s, c)
    bound = larger(-block.friction * uz, zero)
    flat_f = larger(smaller(-ux, bound), -bound)
    # The share of the lower corner with both pressed, times the width: one that is pulled opens.
    share = fused(flat_f, z, fused(block.inertia, uo, larger(-uz, zero) * block.half_width))
    x = wp.where(flat and share < zero, -x, x)
    n, f, sticks, _drag = corner_impulse(
        block.friction, w, x, z, fused_less(uo, x, uz), fused(uo, z, ux), False, False, zero
    )
    vx = ux + f
    vz = uz + n
    vo = fused(w, fused_less(n, x, f * z), uo)
    # Both corners at the base: the other one must not sink.
    both = flat and fused(x, vo, vz) <= zero
    vx = wp.where(both, ux + flat_f, vx)
    vz = wp.where(both, zero, vz)
    vo = wp.where(both, zero, vo)
    along = fused(vo, z, vx)
    still = wp.where(both, along == zero, sticks)
    lost = fused(ux - vx, ux + vx, (uz - vz) * (uz + vz))
    lost = fused((uo - vo) * block.inertia, uo + vo, lost)
    return (
        vx, vz, vo,
        wp.where(both, FLAT, PIVOTING),
        wp.where(still, zero, sign_of(along)),
        HALF * lost,
    )  # fmt: skip


@wp.func
def may_rest(block: Block, gravity: real, omega: real, before: real, pull: real):
    """Whether the block rests after an impact, and the time of the impacts that are left out.

    Args:
        block: The block.
        gravity: [m/s^2].
        omega: Angular velocity after the impact [rad/s].
        before: The one before it.
        pull: Size of the horizontal force per unit mass [m/s^2].
    """
    quarter = real(0.25) * block.inverse_inertia
    carried = quarter * gravity * block.half_width
    pulled = quarter * pull * block.half_height
    weaker = carried - pulled
    rests = weaker > real(0.0) and omega * omega <= real(2.0) * weaker * block.rest_rotation
    # 2 |omega| (1 / weaker + 1 / stronger) / (2 (1 - |omega / before|)).
    fast = size(before)
    lost = larger(fast - size(omega), real(1.0e-6) * fast)
    tail = real(2.0) * size(omega) * carried * fast / (weaker * (carried + pulled) * lost)
    return rests, wp.where(rests, tail, real(0.0))


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
    lost = fused_less(HALF * turn * kick, fused_less(turn, kicked, vx1), lost)
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
    rest_lost = fused(vx1, vx1, fused_less(glides, glides, vz1 * vz1))
    rest_lost = HALF * fused(omega1 * omega1, block.inertia, rest_lost)
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
