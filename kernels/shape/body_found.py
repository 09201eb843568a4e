"""Results of a run of a body in the plane, of all stepped engines."""

import warp as wp

from warprock.kernels.shape.stack_found import BlockResult, Result

TO_LEFT, TO_RIGHT = 0, 1
"""Rows of the largest rotations to -x and to +x."""


@wp.struct
class Sides:
    """Largest rotations so far to -x and to +x [rad], neither negative."""

    left: real
    right: real


@wp.func
def observe_sides(live: bool, theta: real, sides: Sides) -> Sides:
    """The largest rotations after a step that ends at a rotation [rad], if the lane still runs."""
    return Sides(
        wp.where(live, larger(-theta, sides.left), sides.left),
        wp.where(live, larger(theta, sides.right), sides.right),
    )


@wp.struct
class Found:
    """As `Found` of stacks, and `sides`: largest rotations to -x and +x [rad], shape [2, lane]."""

    results: wp.array(dtype=Result)
    blocks: wp.array2d(dtype=BlockResult)
    rotations: wp.array3d(dtype=real)
    places: wp.array4d(dtype=real)
    sides: wp.array2d(dtype=real)
