"""Closed forms of stacks of blocks at rest, in NumPy, for all lanes at once.

Arrays are [lane, block], lowest block first; face k is the one that block k stands on.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from warprock.model.lanes import Lanes, SpatialLanes

Array = npt.NDArray[np.float64]


def contact_ends(lanes: Lanes) -> tuple[Array, Array]:
    """Ends of the stretch over which a block touches what it stands on.

    Args:
        lanes: Stacks.

    Returns:
        Distances of the -x end and of the +x end to +x of the block's centre [m], shape
        [lane, block]; the base is wider than any block.
    """
    half = 0.5 * lanes.face_width
    below = np.concatenate([np.full((lanes.lane_count, 1), np.inf), half[:, :-1]], axis=1)
    return np.maximum(-half, -lanes.offset - below), np.minimum(half, below - lanes.offset)


def uplift_ratio(lanes: Lanes) -> Array:
    """Base acceleration / g at which a block and all above it begin to rock as one [-].

    They turn about an end of the face below once the resultant of weight and inertia leaves it:
    at the distance of their common centre of mass from that end over its height above the face.
    Of the two ends the nearer one counts; <= 0 where the centre of mass does not lie above it.
    In space that is about edges across x, as if no block were turned about the vertical.

    Args:
        lanes: Stacks, all blocks upright.

    Returns:
        Shape [lane, block].
    """
    mass, height = lanes.mass, lanes.height
    low, high = contact_ends(lanes)
    ratio = np.empty_like(mass)
    for block in range(lanes.block_count):
        above = mass[:, block:]
        total = above.sum(axis=1)
        base = np.cumsum(height[:, block:], axis=1) - height[:, block:]
        centre = base + 0.5 * height[:, block:]
        aside = np.cumsum(lanes.offset[:, block:], axis=1) - lanes.offset[:, block : block + 1]
        if isinstance(lanes, SpatialLanes):
            aside = aside + lanes.centre_offset_x[:, block:]
        x = (above * aside).sum(axis=1) / total
        z = (above * centre).sum(axis=1) / total
        ratio[:, block] = np.minimum(high[:, block] - x, x - low[:, block]) / z
    return ratio
