"""Impacts of a planar block on its base, and rest after them: see event/block/step.py.

The block leans to +x or not at all, as in event/block/contact.py.
"""

import warp as wp

from warprock.kernels.event.block.contact import (
    Block,
    Contact,
    Lever,
    Velocity,
    corner_impulse,
    lower_corner,
)
from warprock.kernels.event.block.state import End, Span
from warprock.kernels.lane.modes import FLAT, FLYING, PIVOTING


@wp.struct
class Impact:
    """The block after the end of a step, reflected so that it leans to +x.

    Attributes:
        turn: -1 where the end of the step changes the side to which the block leans, else 1.
        vx, vz, omega: Velocity [m/s], [rad/s].
        mode, slip: How the block touches its base.
        lost: Energy lost per unit mass [J/kg].
        hit: Whether the other corner or a flying one hit the base.
        tail: Time of the impacts that the rest rule omits [s].
    """

    turn: real
    vx: real
    vz: real
    omega: real
    mode: int
    slip: real
    lost: real
    hit: bool
    tail: real


@wp.func
def struck_velocity(block: Block, flat: bool, lower: Lever, before: Velocity):
    """Velocity after an inelastic impact: a corner has landed or the base stepped its velocity.

    With both corners at the base the impact is on one of them, or on both if the other would sink
    into the base then: as in `law_velocity` in event/body/contact.py.

    Args:
        block: The block.
        flat: Whether both corners are at the base.
        lower: The lower corner.
        before: Velocity before.

    Returns:
        Velocity, contact, energy lost per unit mass [J/kg].
    """
    zero = real(0.0)
    w = block.inverse_inertia
    ux, uz, uo, z = before.x, before.z, before.omega, lower.z
    bound = larger(-block.friction * uz, zero)
    flat_f = larger(smaller(-ux, bound), -bound)
    # The impulse at the lower corner if both are struck, times the width: if negative, it opens.
    share = fused(flat_f, z, fused(block.inertia, uo, larger(-uz, zero) * block.half_width))
    x = wp.where(flat and share < zero, -lower.x, lower.x)
    n, f, sticks, _drag = corner_impulse(
        block.friction, w, Lever(x, z), fused_less(uo, x, uz), fused(uo, z, ux), False, False, zero
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
    contact = Contact(wp.where(both, FLAT, PIVOTING), wp.where(still, zero, sign_of(along)))
    return Velocity(vx, vz, vo), contact, HALF * lost


@wp.func
def may_rest(block: Block, gravity: real, omega: real, before: real, pull: real):
    """Whether the block rests after an impact, and the time of the impacts that are omitted.

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
def end_step(block: Block, gravity: real, falls: bool, lands: bool, span: Span, end: End) -> Impact:
    """Applies the impact, the velocity step of the base and the rest rule at the end of a step.

    Args:
        block: The block, which leans to +x.
        gravity: [m/s^2].
        falls, lands: Whether it falls on its other corner, whether its lower corner lands.
        span: The step.
        end: The block at its end.
    """
    zero = real(0.0)
    one = real(1.0)
    kick = span.kick
    hit = lands or (falls and end.mode == PIVOTING)
    struck = hit or (kick != zero and end.mode != FLYING)
    level = falls or end.mode == FLAT
    kicked = end.vx - kick
    turn = wp.where(falls, -one, wp.where(end.mode == FLAT and struck, sign_of(kicked), one))
    at = lower_corner(block, end.theta)
    lower = Lever(
        wp.where(level, block.half_width, at.x), wp.where(level, -block.half_height, at.z)
    )
    before = Velocity(turn * kicked, end.vz, turn * end.omega)
    after, contact, lost = struck_velocity(block, level or end.theta == zero, lower, before)
    # The base's work on the block is at the mean of both velocities: see account.py.
    lost = fused_less(HALF * turn * kick, fused_less(turn, kicked, after.x), lost)
    vx1 = wp.where(struck, after.x, turn * kicked)
    vz1 = wp.where(struck, after.z, end.vz)
    omega1 = wp.where(struck, after.omega, turn * end.omega)
    mode1 = wp.where(struck, contact.mode, end.mode)
    slip1 = wp.where(struck, contact.slip, turn * end.slip)
    lost = wp.where(struck, lost, zero)
    pull = wp.where(slip1 != zero, block.friction * gravity, size(span.a1))
    stays, tail = may_rest(block, gravity, omega1, end.omega, pull)
    rests = stays and hit and level and mode1 == PIVOTING
    glides = wp.where(slip1 != zero, vx1, zero)
    slip1 = wp.where(rests and slip1 != zero, sign_of(vx1), slip1)
    rest_lost = fused(vx1, vx1, fused_less(glides, glides, vz1 * vz1))
    rest_lost = HALF * fused(omega1 * omega1, block.inertia, rest_lost)
    return Impact(
        turn, wp.where(rests, glides, vx1), wp.where(rests, zero, vz1),
        wp.where(rests, zero, omega1), wp.where(rests, FLAT, mode1), slip1,
        lost + wp.where(rests, rest_lost, zero), hit, wp.where(rests, tail, zero),
    )  # fmt: skip
