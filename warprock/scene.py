"""What a batch of lanes requires of an engine, decided once, before launch."""

from __future__ import annotations

import dataclasses

import numpy as np

from warprock.lanes import Lanes
from warprock.motion import GroundMotions, MotionKind


@dataclasses.dataclass(frozen=True)
class SceneKind:
    """What chooses the kernel, and what an engine may have to decline.

    Attributes:
        motion: Family of ground motions.
        block_count: Blocks in a lane.
        contact_point_count: Corners that can touch the base.
        restitution_given: Whether the case prescribes the angular restitution.
        friction_ratio: Smallest friction coefficient / tan(slenderness angle) of all lanes;
            below 1 a block slides before it rocks.
    """

    motion: MotionKind
    block_count: int
    contact_point_count: int
    restitution_given: bool
    friction_ratio: float


def scene_kind(lanes: Lanes, motions: GroundMotions, *, restitution_given: bool) -> SceneKind:
    """The kind of scene that lanes and motions make up: one planar block on a moving base."""
    return SceneKind(
        motion=motions.kind,
        block_count=1,
        contact_point_count=2,
        restitution_given=restitution_given,
        friction_ratio=float(np.min(lanes.friction * lanes.height / lanes.width)),
    )
