"""What a base that moves upwards, too (VERTICAL), changes in a step of a stack.

As event/body_weight.py, which see, for all blocks at once.
"""

import warp as wp

from warprock.kernels.motion import knot_time
from warprock.kernels.shape.above import Above
from warprock.kernels.shape.stack import Blocks, Triples


@wp.func
def until_knot(above: Above, target: real) -> real:
    """A time [s], or that of the next knot of the vertical motion where it is sooner."""
    return smaller(knot_time(above.motion, above.segment), target)


@wp.func
def keeps_height(above: Above) -> bool:
    """Whether the base has not begun to move upwards, or has ended."""
    return above.segment == 0 or knot_time(above.motion, above.segment) >= NEVER


@wp.func
def left_behind(velocity: Triples, gained: real) -> Triples:
    """Velocities of blocks, seen from a base that gains some upwards [m/s]."""
    v = velocity
    for k in range(BLOCKS):
        v[3 * k + 1] = v[3 * k + 1] - gained
    return v


@wp.func
def pushed_up(blocks: Blocks, kick: real, free: Triples, velocity: Triples) -> real:
    """Work of contacts in an impact against a velocity step upwards [J], see `lost_between`."""
    work = real(0.0)
    for k in range(BLOCKS):
        work += HALF * kick * (velocity[3 * k + 1] - free[3 * k + 1]) / blocks.inverse_mass[k]
    return work
