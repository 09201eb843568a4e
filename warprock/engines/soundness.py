"""Energy from nowhere: which lanes of a time-stepping engine gained more than can be.

On a base that stands still a block can only lose energy. A step that is long for its size gives
some back; where that is more than the block held, its motion is the step's and not its own.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from warprock import rocking
from warprock.lanes import Lanes
from warprock.motion import GroundMotions, StillBase
from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

EXPLOSION_BOUND = 1.0
"""Energy gained over energy held at the start above which a lane's numbers are absurd..."""
BARRIER_SHARE = 0.1
"""...if what was gained is also this part of the energy that overturns the blocks (a twentieth of
the slenderness angle): a block that holds next to nothing may gain much of that, and move by
nothing."""


def energy_held(lanes: Lanes, rotation: Array) -> Array:
    """Least energy above the flat state of single blocks that turned to a rotation [J], [lane].

    Beyond the slenderness angle it is what it takes to get there.
    """
    turned = np.minimum(np.abs(rotation), lanes.slenderness_angle)
    return rocking.energy(lanes.width, lanes.height, lanes.depth, lanes.density, turned, 0.0)


def energy_gained(lanes: Lanes, energy_lost: Array, peak_rotation: Array) -> Array:
    """Energy that single rigid blocks on a still base gained [J], shape [lane].

    By the engine's own account, or because they turned further than they were let go; negative
    where both say that they lost some.
    """
    reached = energy_held(lanes, peak_rotation) - energy_held(lanes, lanes.rotation_start)
    return np.fmax(-np.asarray(energy_lost, dtype=np.float64), reached)


def exploded(lanes: Lanes, held: Array, gained: Array) -> Mask:
    """Where more energy was gained than can be put down to small errors, shape [lane].

    Args:
        lanes: Single blocks or stacks.
        held: Energy at the start above the flat state [J], shape [lane].
        gained: Energy gained since [J], shape [lane].
    """
    rise = 0.5 * (np.hypot(lanes.width, lanes.height) - lanes.height)
    barrier = (GRAVITY * lanes.mass * rise).reshape(lanes.lane_count, -1).sum(axis=1)
    return np.asarray((gained > EXPLOSION_BOUND * held) & (gained > BARRIER_SHARE * barrier))


def unstable(
    lanes: Lanes, motions: GroundMotions, energy_lost: Array, peak_rotation: Array
) -> Mask:
    """Where single rigid blocks on a still base gained energy that nothing gave, shape [lane].

    Where the base moves it gives energy, and nothing is said.
    """
    if not isinstance(motions, StillBase):
        return np.zeros(lanes.lane_count, dtype=np.bool_)
    gained = energy_gained(lanes, energy_lost, peak_rotation)
    return exploded(lanes, energy_held(lanes, lanes.rotation_start), gained)
