"""What a batch of lanes requires of an engine, decided once, before launch."""

from __future__ import annotations

import dataclasses

import numpy as np

from warprock.model.coplanar import find_coplanar
from warprock.model.drums import no_column
from warprock.model.lanes import Lanes
from warprock.model.motion import GroundMotions, MotionKind, UprightMotions
from warprock.model.painleve import above_limit
from warprock.model.stacking import uplift_ratio


@dataclasses.dataclass(frozen=True)
class SceneKind:
    """What chooses the kernel, and what an engine may have to decline.

    Attributes:
        motion: Family of ground motions.
        stacked: Whether a lane is a stack, be it of one block.
        block_count: Blocks in a lane.
        contact_point_count: Points that can touch at once: two of every block in the plane; in
            space four of the lowest, and eight between two faces that are turned.
        centred: Whether every block starts above the centre of what it stands on.
        restitution_given: Whether the case prescribes the angular restitution.
        bodies: Whether there are bodies, of which the box says nothing.
        rounded: Whether the corners of a body are rounded.
        vertical: Whether the base moves upwards, too, under blocks in the plane.
        held: What holds its block besides its base, by the tables of a case; mostly nothing.
        assembly: Whether a lane is an assembly of many blocks with joints.
        bonded: Whether joints of assemblies have cohesion and tensile strength.
        no_column: Why assemblies are not all columns of as many equal drums; empty where they are.
        coplanar: Share of the lanes that are stacks in space and move in one vertical plane.
        moving: What starts in motion; empty where blocks are let go from rest.
        spatial_because: What makes a planar model fall short; empty where the scene is planar.
        friction_ratio: Smallest friction coefficient / base acceleration in g that makes the block
            rock, tan(slenderness angle) of a single one; below 1 a block slides before it rocks.
        angular_restitution: Smallest ratio of the angular velocities after and before an impact of
            a single block, prescribed or Housner's; at 0 or below the block does not rock over.
        above_friction_limit: Lanes with friction above the `friction_limit`: a contact law may have
            several solutions there.
        friction_limit: The least limit of their blocks; infinite without such lanes.
    """

    motion: MotionKind
    stacked: bool
    block_count: int
    contact_point_count: int
    centred: bool
    restitution_given: bool
    moving: str
    spatial_because: str
    friction_ratio: float
    angular_restitution: float
    above_friction_limit: int
    friction_limit: float
    bodies: bool = False
    rounded: bool = False
    vertical: bool = False
    held: tuple[str, ...] = ()
    assembly: bool = False
    bonded: bool = False
    no_column: str = ""
    coplanar: float = 0.0

    @property
    def piled(self) -> bool:
        """Whether blocks stand on one another alone: in a stack, or a column of an assembly."""
        return self.stacked or (self.assembly and not self.no_column)

    @property
    def spatial(self) -> bool:
        """Whether the blocks move in space."""
        return bool(self.spatial_because)

    @property
    def on_points(self) -> bool:
        """Whether kernels of bodies run it: single boxes, too, on a base that moves upwards."""
        return self.bodies or (self.vertical and not self.stacked)

    @property
    def thrown(self) -> bool:
        """Whether its blocks are thrown, so that they may fall on any of their faces."""
        return self.moving.startswith("throws")

    @property
    def left_out(self) -> tuple[str, ...]:
        """What the model does without because nothing in the scene needs it, and why."""
        if self.assembly and self.spatial:
            return ()
        if self.assembly:
            return ("motion out of the plane: its base moves along x",)
        parts = []
        ways = "and upwards" if self.vertical else "at most"
        if not self.spatial and self.bodies:
            parts += [
                "motion out of the plane of rocking, of which the base is a profile: three degrees "
                "of freedom are enough where it stays in that plane",
            ]
        elif not self.spatial:
            parts += [
                f"motion out of the plane of rocking: the base moves along x {ways} and each "
                "block is symmetric about the plane, so three degrees of freedom a block are "
                "enough",
            ]
        if self.motion is MotionKind.STILL:
            parts += ["ground motion: the base stands still"]
        if self.held:
            return tuple(parts)
        if self.block_count == 1:
            parts += ["contact between blocks: there is one, and it touches its base alone"]
        parts += [
            "the search for pairs that might touch: each face can meet but the one it stands on",
        ]
        if not self.thrown:
            parts += ["the sides of blocks: a lane ends once a block has overturned or slid off"]
        return tuple(parts)

    @property
    def friction_note(self) -> str:
        """What is to be said of friction at which contact has no unique answer; else empty."""
        if not self.above_friction_limit:
            return ""
        some = "lane has" if self.above_friction_limit == 1 else "lanes have"
        return (
            f"{self.above_friction_limit} {some} friction above the limit of the block, "
            f"{self.friction_limit:.3g} at least, up to which rigid contact has one solution "
            "(Painleve); where such a block slides its status is ambiguous"
        )

    @property
    def beyond_the_plane(self) -> str | None:
        """Why an engine of the plane of rocking cannot run the scene; None if it can."""
        if self.spatial:
            return f"it follows the plane of rocking only, and the case {self.spatial_because}"
        return None


def scene_kind(
    lanes: Lanes,
    motions: GroundMotions,
    *,
    restitution_given: bool,
    spatial_because: str = "has blocks in space",
) -> SceneKind:
    """The kind of scene that lanes and motions make up: blocks on a moving base.

    Args:
        lanes: The lanes.
        motions: Their ground motions.
        restitution_given: Whether the case prescribes the angular restitution.
        spatial_because: What asks for space, of lanes that are spatial.
    """
    above, limit = above_limit(lanes)
    body, assembly = lanes.body, lanes.assembly
    if body is not None:
        uplift = body.uplift_ratios.min(axis=1)
    else:
        uplift = uplift_ratio(lanes) if lanes.stacked else lanes.face_width / lanes.height
    return SceneKind(
        motion=motions.kind,
        stacked=lanes.stacked,
        block_count=lanes.block_count if assembly is None else assembly.most_blocks,
        contact_point_count=(lanes.contact_point_count if assembly is None else assembly.most_ends),
        centred=not lanes.offset.any(),
        restitution_given=restitution_given,
        moving=lanes.moving,
        spatial_because=spatial_because if lanes.spatial else "",
        friction_ratio=float(np.min(lanes.friction / uplift)),
        angular_restitution=float(np.min(lanes.angular_restitution)),
        above_friction_limit=int(np.sum(above)),
        friction_limit=float(limit[above].min()) if above.any() else np.inf,
        bodies=lanes.bodies,
        rounded=body is not None and bool(body.corner_radius.any()),
        vertical=isinstance(motions, UprightMotions),
        held=lanes.held,
        assembly=assembly is not None,
        bonded=assembly is not None and assembly.bonded,
        no_column="" if assembly is None else no_column(assembly),
        coplanar=float(find_coplanar(lanes, motions).within.mean()),
    )
