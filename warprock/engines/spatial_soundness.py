"""Energy from nowhere in space: which lanes have more than their base can have supplied.

In the frame of its base the energy E of a lane above its flat state changes by the work of the
base, -a . sum(m v) with the acceleration a of the base, and by that of the contacts, which can only
take. As long as no block lies below its flat place sum(m v^2) / 2 is at most E, so that
|d sqrt(E) / dt| <= sqrt(M / 2) |a| with the mass M of all blocks, and E never exceeds
(sqrt(E at the start) + sqrt(M / 2) S)^2, S the total variation of the base velocity. That is known
before a run. It is the looser the longer the base moves: what contacts give a block that a long
record shakes passes unseen up to that.
"""

from __future__ import annotations

import math
from typing import cast

import numpy as np
import numpy.typing as npt

from warprock.engines.soundness import BARRIER_SHARE, COMPLETE_BOUND, exploded, gone_through
from warprock.engines.stack_launching import as_stacks
from warprock.model.lanes import Lanes, SpatialLanes
from warprock.model.motion import (
    GroundMotions,
    SpatialMotions,
)
from warprock.model.pose import start_poses
from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]


def energy_at_start(lanes: Lanes) -> Array:
    """Energy at the start above the state in which all blocks are flat [J], shape [lane]."""
    stacks = cast(SpatialLanes, as_stacks(lanes))
    height = np.cumsum(stacks.height, axis=1) - 0.5 * stacks.height
    rise = start_poses(stacks)[0][..., 2] - height
    return np.asarray(GRAVITY * (stacks.mass * rise).sum(axis=1))


def most_energy(lanes: Lanes, motions: GroundMotions, duration: float) -> Array:
    """The most energy above the flat state that a lane can have until a time [J], shape [lane]."""
    held = np.maximum(energy_at_start(lanes), 0.0)
    mass = lanes.mass.reshape(lanes.lane_count, -1).sum(axis=1)
    parts = cast(SpatialMotions, motions).components
    variation = sum(part.velocity_variation(duration) for part in parts)
    return np.asarray((np.sqrt(held) + np.sqrt(0.5 * mass) * variation) ** 2)


def energy_to_tilt(lanes: Lanes, tilt: Array) -> Array:
    """Least energy above the flat state of single blocks whose axes lean by an angle [J], [lane].

    That is a turn about the nearest edge of the face; beyond where it overturns, what that takes.
    """
    arm, half = _nearest_edge(lanes), 0.5 * lanes.height
    turned = np.minimum(np.abs(tilt), np.arctan2(arm, half))
    rise = arm * np.sin(turned) + half * (np.cos(turned) - 1.0)
    return np.asarray(GRAVITY * lanes.mass * rise)


def _nearest_edge(lanes: Lanes) -> Array:
    """Distance of the nearest edge of the bottom face from the centre of mass [m], [lane]."""
    blocks = cast(SpatialLanes, lanes)
    along = 0.5 * blocks.face_width - np.abs(blocks.centre_offset_x)
    across = 0.5 * blocks.face_depth - np.abs(blocks.centre_offset_y)
    return np.asarray(np.minimum(along, across))


def tilted_by_nothing(lanes: Lanes, motions: GroundMotions, tilt: Array) -> Mask:
    """Where single blocks lean that stood flat on a base too weak to lift an edge, shape [lane].

    The resultant of weight and inertia stays inside the face, whatever slides. `BARRIER_SHARE` says
    how far a block has to lean.
    """
    blocks = cast(SpatialLanes, lanes)
    x, y, z = (part.strongest_pull() for part in cast(SpatialMotions, motions).components)
    arm = _nearest_edge(lanes)
    weak = np.hypot(x, y) * 0.5 * lanes.height < (1.0 - BARRIER_SHARE) * (GRAVITY - z) * arm
    flat = (blocks.rotation_start == 0.0) & (blocks.rotation_across_start == 0.0)
    flat &= blocks.gap_start == 0.0
    far = tilt > (1.0 - math.sqrt(1.0 - BARRIER_SHARE)) * np.arctan2(arm, 0.5 * lanes.height)
    return np.asarray(flat & weak & far)


def unstable_in_space(
    lanes: Lanes,
    motions: GroundMotions,
    duration: float,
    *,
    energy_lost: Array,
    peak_tilt: Array,
    deepest: Array,
    rigid: bool = True,
) -> Mask:
    """Where blocks have energy that nothing gave, shape [lane], on a base that moves or not.

    Where contacts gave more than `exploded` puts down to small errors, beside the most energy that
    a lane can have, and where single blocks leaned further than that can bring about. Where
    contacts are rigid also those that leaned on a base too weak to lift them, and corners that went
    through the ground.

    Args:
        lanes: Single blocks or stacks.
        motions: Their ground motions.
        duration: Of the run [s].
        energy_lost: By the engine's own account [J], shape [lane].
        peak_tilt: Largest lean of the axes [rad], shape [lane]; of stacks it does not count.
        deepest: Deepest penetration [m], shape [lane].
        rigid: Whether contacts are rigid, so that a lean tells an energy.
    """
    most = most_energy(lanes, motions, duration)
    found = exploded(lanes, most, -np.asarray(energy_lost, dtype=np.float64))
    if not rigid:
        if not lanes.stacked:
            # Springs let a centre sink below where a rigid corner would hold it.
            weight = GRAVITY * lanes.mass
            least = energy_to_tilt(lanes, peak_tilt) - weight * np.asarray(deepest)
            found |= exploded(lanes, most, least - most, COMPLETE_BOUND)
        return np.asarray(found)
    if not lanes.stacked:
        found |= exploded(lanes, most, energy_to_tilt(lanes, peak_tilt) - most)
        found |= tilted_by_nothing(lanes, motions, peak_tilt)
    return np.asarray(found | gone_through(lanes, np.asarray(deepest, dtype=np.float64)))
