"""Sliding of a block that lies flat, as a polynomial in time.

Seen so that it slides to +x with a velocity u relative to the base, of acceleration a,

    u' = -a - friction g,

until u is zero. Half height times friction tells how far the pressure's centre is ahead of the
centre of mass: up to the half width the block stays flat, whatever the base does.
"""

import warp as wp

from warprock.kernels.event.block_contact import Block
from warprock.kernels.modes import FLAT


@wp.func
def slides_flat(block: Block, mode: int, slip: real, vx: real) -> bool:
    """Whether a block lies flat, slides in its direction and stays flat while it does."""
    stays = block.friction * block.half_height <= block.half_width
    return mode == FLAT and slip * vx > real(0.0) and stays


@wp.func
def sliding_series(
    block: Block, gravity: real, a0: real, a1: real, a2: real, a3: real, a4: real, a5: real
):
    """Taylor coefficients 1 to 6 of the velocity, from 0 to 5 of the base's acceleration."""
    pull = block.friction * gravity
    return -a0 - pull, -OVER_2 * a1, -OVER_3 * a2, -OVER_4 * a3, -OVER_5 * a4, -OVER_6 * a5


@wp.func
def slide_after(
    u: real, u1: real, u2: real, u3: real, u4: real, u5: real, u6: real, tau: real
) -> real:  # fmt: skip
    """Way along the base a time after the start of a step [m], from the velocity's coefficients."""
    high = fused(tau, fused(tau, OVER_7 * u6, OVER_6 * u5), OVER_5 * u4)
    high = fused(tau, fused(tau, high, OVER_4 * u3), OVER_3 * u2)
    return tau * fused(tau, fused(tau, high, OVER_2 * u1), u)
