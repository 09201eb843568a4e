"""Sliding of a block that lies flat, as a polynomial in time.

Reflected so that it slides to +x, the block has a velocity u relative to its base, which obeys

    u' = -a - friction g

until u is zero, a the acceleration of the base. The centre of pressure is ahead of the centre of
mass by the friction times the half height. If that is at most the half width, the block stays flat
however the base moves.
"""

import warp as wp

from warprock.kernels.event.block.contact import Block
from warprock.kernels.event.block.rocking import Curve
from warprock.kernels.lane.modes import FLAT
from warprock.kernels.motion.kinds import Acceleration


@wp.func
def slides_flat(block: Block, mode: int, slip: real, vx: real) -> bool:
    """Whether a block lies flat, slides in its direction and stays flat while it does."""
    stays = block.friction * block.half_height <= block.half_width
    return mode == FLAT and slip * vx > real(0.0) and stays


@wp.func
def sliding_series(block: Block, gravity: real, u: real, a: Acceleration) -> Curve:
    """The velocity, from its value at the start [m/s] and the acceleration of the base."""
    pull = block.friction * gravity
    return Curve(
        u, -a.a0 - pull, -OVER_2 * a.a1, -OVER_3 * a.a2, -OVER_4 * a.a3, -OVER_5 * a.a4,
        -OVER_6 * a.a5,
    )  # fmt: skip


@wp.func
def slide_after(u: Curve, tau: real) -> real:
    """Distance along the base a time after the start of a step [m], from the velocity."""
    high = fused(tau, fused(tau, OVER_7 * u.c6, OVER_6 * u.c5), OVER_5 * u.c4)
    high = fused(tau, fused(tau, high, OVER_4 * u.c3), OVER_3 * u.c2)
    return tau * fused(tau, fused(tau, high, OVER_2 * u.c1), u.c0)
