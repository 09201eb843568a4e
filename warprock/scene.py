"""What a batch of lanes requires of an engine, decided once, before launch."""

from __future__ import annotations

import dataclasses

import numpy as np

from warprock.lanes import Lanes
from warprock.motion import GroundMotions, MotionKind
from warprock.stacking import uplift_ratio


@dataclasses.dataclass(frozen=True)
class SceneKind:
    """What chooses the kernel, and what an engine may have to decline.

    Attributes:
        motion: Family of ground motions.
        stacked: Whether a lane is a stack, be it of one block.
        block_count: Blocks in a lane.
        contact_point_count: Corners that can touch at once: two of every block.
        centred: Whether every block starts above the centre of what it stands on.
        restitution_given: Whether the case prescribes the angular restitution.
        friction_ratio: Smallest friction coefficient / base acceleration in g that makes the block
            rock, tan(slenderness angle) of a single one; below 1 a block slides before it rocks.
    """

    motion: MotionKind
    stacked: bool
    block_count: int
    contact_point_count: int
    centred: bool
    restitution_given: bool
    friction_ratio: float


def scene_kind(lanes: Lanes, motions: GroundMotions, *, restitution_given: bool) -> SceneKind:
    """The kind of scene that lanes and motions make up: planar blocks on a moving base."""
    uplift = uplift_ratio(lanes) if lanes.stacked else lanes.face_width / lanes.height
    return SceneKind(
        motion=motions.kind,
        stacked=lanes.stacked,
        block_count=lanes.block_count,
        contact_point_count=2 * lanes.block_count,
        centred=not lanes.offset.any(),
        restitution_given=restitution_given,
        friction_ratio=float(np.min(lanes.friction / uplift)),
    )
