"""Closed forms of stacks of blocks at rest, in NumPy, for all lanes at once.

Arrays are [lane, block], lowest block first; face k is the one that block k stands on.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from warprock.model.lanes import Lanes, SpatialLanes
from warprock.model.profiles import Profiles

Array = npt.NDArray[np.float64]


def sum_above(values: Array) -> Array:
    """Sums over each block and all above it, as `values`, whose second axis is the block."""
    return np.asarray(np.cumsum(values[:, ::-1], axis=1)[:, ::-1])


def base_ends(lanes: Lanes) -> Array:
    """Ends at -x and +x of what blocks of stacks stand on, from below the centre [m].

    Shape [lane, block, 2].
    """
    if lanes.profiles is not None:
        return lanes.profiles.base_ends
    half = 0.5 * lanes.face_width
    return np.stack([-half, half], axis=-1)


def centre_height(lanes: Lanes) -> Array:
    """Height of the centres of mass of stacked blocks above their bases [m], [lane, block]."""
    if lanes.profiles is not None:
        return lanes.profiles.centre_height
    return np.asarray(0.5 * lanes.height)


def top_ends(lanes: Lanes) -> Array:
    """Ends of the tops of stacked blocks at -x and +x, from above the centre [m].

    Shape [lane, block, 2].
    """
    return base_ends(lanes) if lanes.profiles is None else lanes.profiles.top[..., :2]


def box_profiles(lanes: Lanes) -> Profiles:
    """Stacks of boxes as profiles; none of their blocks counts as a body."""
    half, high = 0.5 * lanes.face_width, 0.5 * lanes.height
    ends = [np.stack([side * half, -high], axis=-1) for side in (-1.0, 1.0)]
    return Profiles(
        mass=lanes.density * lanes.width * lanes.height * lanes.depth,
        gyration=(lanes.width**2 + lanes.height**2) / 12.0,
        points=np.stack(ends, axis=2),
        count=np.full(half.shape, 2, np.int32),
        top=np.stack([-half, half, high], axis=-1),
        is_body=(False,) * lanes.block_count,
    )


def contact_ends(lanes: Lanes) -> tuple[Array, Array]:
    """Ends of the stretch over which a block touches what it stands on.

    Args:
        lanes: Stacks.

    Returns:
        Distances of the -x end and of the +x end to +x of the block's centre [m], shape
        [lane, block]; the base is wider than any block.
    """
    low, high = np.moveaxis(base_ends(lanes), -1, 0)
    middle = 0.5 * (low + high)
    half = 0.5 * np.diff(top_ends(lanes), axis=-1)[..., 0]
    below = np.concatenate([np.full((lanes.lane_count, 1), np.inf), half[:, :-1]], axis=1)
    from_there = middle - lanes.offset
    return np.maximum(low, from_there - below), np.minimum(high, from_there + below)


def steps_along(lanes: Lanes) -> Array:
    """How far the centres of upright blocks are to +x of the one below [m], [lane, block].

    Of the lowest block from where the middle of its base stands.
    """
    steps = lanes.offset - base_ends(lanes).mean(axis=-1)
    steps[:, 1:] += top_ends(lanes)[:, :-1].mean(axis=-1)
    return np.asarray(steps)


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
    mass, height, rise = lanes.mass, lanes.height, centre_height(lanes)
    steps = steps_along(lanes)
    low, high = contact_ends(lanes)
    ratio = np.empty_like(mass)
    for block in range(lanes.block_count):
        above = mass[:, block:]
        total = above.sum(axis=1)
        base = np.cumsum(height[:, block:], axis=1) - height[:, block:]
        centre = base + rise[:, block:]
        aside = np.cumsum(steps[:, block:], axis=1) - steps[:, block : block + 1]
        if isinstance(lanes, SpatialLanes):
            aside = aside + lanes.centre_offset_x[:, block:]
        x = (above * aside).sum(axis=1) / total
        z = (above * centre).sum(axis=1) / total
        ratio[:, block] = np.minimum(high[:, block] - x, x - low[:, block]) / z
    return ratio
