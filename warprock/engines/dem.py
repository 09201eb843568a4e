"""The soft-spring (distinct element) engine: sub-contact springs under every block, batched."""

from __future__ import annotations

import dataclasses
import math
from types import ModuleType
from typing import TYPE_CHECKING, Any, ClassVar, cast, final

import numpy as np
import numpy.typing as npt

from warprock.engines import dem_stack_bodies
from warprock.engines.assembly_packs import LARGE
from warprock.engines.base import KernelEngine
from warprock.engines.blocks import body_columns, speed_columns
from warprock.engines.decoding import lane_fields, planar_fields, rest_start_times, spatial_fields
from warprock.engines.dem_bodies import CornerSprings, corner_rows, cornered_columns
from warprock.engines.dem_bodies_space import PointSprings, on_corners, sprung_inputs
from warprock.engines.dem_springs import (
    interface_depth,
    stable_step,
    standing_on,
    standing_ratio,
    start_at_rest,
    stiffest_frequency,
)
from warprock.engines.dem_springs_space import (
    ENDLESS,
    SpatialSprings,
    point_pairs,
    spatial_frequencies,
    start_in_space,
)
from warprock.engines.launching import NEVER, Found, Kernel
from warprock.engines.soundness import account_in_space, account_of, unstable
from warprock.engines.stack_bodies import foot_columns
from warprock.kernels import dem, dem_space
from warprock.model import rocking
from warprock.model.lanes import Lanes, SpatialLanes, as_stacks
from warprock.model.motion import GroundMotions, StillBase
from warprock.model.response import Response, SampleTimes, Status
from warprock.model.scene import SceneKind
from warprock.model.stacking import sum_above
from warprock.settings.engines import DemSettings
from warprock.units import GRAVITY

if TYPE_CHECKING:
    from warprock.engines.dem_assembly import SprungAssembly

Array = npt.NDArray[np.float64]

TURN_SAMPLES = 2000
"""Samples in which a turn is looked for: it is flat, a sample misses 1e-6 of it."""

LEAST_CREEP = 1e-9
"""Speed that is round-off of a block that nothing holds [m/s]."""


@final
@dataclasses.dataclass(frozen=True)
class Dem(KernelEngine):
    """Springs and dashpots over every interface, Mohr-Coulomb slip, central differences.

    First order in the step, whose dashpots are half a step late. Every lane has its own step: the
    `time_step` of the settings, or `step_safety` of what its stiffest mode allows.

    A lane lifts once an eighth of an interface, at one end, carries all: of five sub-contacts only
    the last, as when a rigid block lifts. Its uplift time is when that interface began to gape in
    the middle. A lane is at rest while no interface has parted so and none slides. An impact is an
    interface that closes in the middle again; bounces count. What a lane lost went into dashpots,
    slip and springs that opened under load.

    The energy account knows what springs hold. A lane that gains what neither its start nor its
    base gave, by more than a tenth of what they did and of what overturns it, has the status
    UNSTABLE; a `step_safety` beyond 1 makes such lanes.

    Blocks lift and overturn below g tan(slenderness angle) on springs, and that is the model. Under
    an acceleration that starts at once a rigid block stands up to g b / h (half width over half
    height); a block on springs rocks on them before it lifts, and falls from

        a = g (b / h - sqrt((A / A_end - 1) d / h)),   d = m g / (k A),

    on, A / A_end = 2 (points - 1), if dashpots take nothing: by 8 % for a block of 0.2 m x 1 m on
    the default springs, by 0.3 % on two points of 1e11 N/m^3. Under several cycles still less will
    do, as a block that has begun to rock takes energy from every one of them.

    Blocks that are too tall for their springs (k I <= W h, see `standing_ratio`) are refused.

    In space the springs are a grid, `subcontacts` along the width times `subcontacts_across`
    along the depth, under the face of the upper block. They press along the normal of the
    contact where this face is lowest: a corner, or edges that cross. A lane lifts there once an
    interface gapes from the middle to three quarters of the way to the corner that is pressed
    most; for a turn about an edge that is the rule of the plane. A block that rocks over
    corners chatters on weakly damped springs, so that no order shows.

    A body in space stands on a spring under each of its points, which have equal parts of the area
    of its base, as a box with two sub-contacts along and across does. In a stack in the plane with
    a body all interfaces have springs under their contact points alone, those of boxes, too.

    Assemblies have springs at the contacts of the engine `assembly`, the two ends of what the edges
    of a joint share, each for half of the area of the joint. Only declared joints touch. They start
    in equilibrium under their weight, and collapse as in `assembly`. A corner is still below a
    tenth of g / w, with the lowest angular frequency w of the assembly on closed joints.
    """

    name: ClassVar[str] = "dem"
    settings_type = DemSettings
    order: ClassVar[int | None] = 1
    preference: ClassVar[int | None] = 3
    spatial: ClassVar[bool] = True
    starts_moving: ClassVar[tuple[str, ...]] = ("plane", "space")
    bodies: ClassVar[tuple[bool, bool]] = (True, True)
    stacked_bodies: ClassVar[bool] = True
    bodies_move: ClassVar[tuple[str, ...]] = ("plane", "space")
    vertical: ClassVar[tuple[str, ...]] = ("block", "stack")
    above_rigid: ClassVar[bool] = True
    assemblies: ClassVar[bool] = True

    @classmethod
    def declines(cls, scene: SceneKind) -> str | None:
        """Why its model is not for a scene: a box on springs at its corners is thrown alone.

        Bonds are settings of its springs.
        """
        if scene.bonded:
            return (
                "dem takes what joints hold from engines.dem.cohesion and "
                "engines.dem.tensile_strength, and the case has assembly.joint_tensile_strength; "
                "assembly runs it"
            )
        if scene.spatial and scene.moving and not (scene.thrown or scene.bodies):
            return f"dem lets blocks go from rest, or thrown, and the case {scene.moving}"
        joints = scene.contact_point_count // 2
        if scene.assembly and joints > LARGE:
            return (
                f"dem runs assemblies of at most {LARGE:,} joints, and the case has {joints:,}; "
                "assembly runs it"
            )
        return None

    def kernel_lanes(self, lanes: Lanes, motions: GroundMotions) -> Lanes:
        """Lanes as they are: the kernel of boxes knows a base that moves upwards."""
        return lanes

    def kernel_of(self, scene: SceneKind | Lanes) -> Kernel:
        """The kernel that runs a scene: the same text for a single block and for a stack."""
        lanes, settings = self.target.lanes, self.settings
        if scene.assembly:
            return self._assembly.kernel_of(scene)
        if scene.bodies and not (scene.spatial or scene.stacked):
            points = corner_rows(scene.contact_point_count)
            return Kernel(dem, "body_run", lanes=lanes, points=points)
        if not scene.spatial:
            return Kernel(dem, "stack_run", lanes=lanes, iterations=settings.subcontacts)
        if scene.bodies or scene.moving:
            friction = "box" if settings.friction_box else "cone"
            return Kernel(dem_space, "body_run", lanes=lanes, friction=friction)
        pairs = point_pairs(settings.subcontacts, settings.subcontacts_across).shape[1]
        friction = "box" if settings.friction_box else "cone"
        return Kernel(dem_space, "stack_run", lanes=lanes, iterations=pairs, friction=friction)

    @property
    def _assembly(self) -> SprungAssembly:
        """What runs assemblies."""
        from warprock.engines.dem_assembly import SprungAssembly

        return SprungAssembly(self.settings, self.target)

    def module_of(self, lanes: Lanes, motions: GroundMotions) -> ModuleType:
        """The instance of that kernel's file for lanes and motions."""
        if lanes.assembly is not None:
            return self._assembly.module_of(lanes, motions)
        return super().module_of(lanes, motions)

    def alike_order(self, lanes: Lanes, motions: GroundMotions) -> npt.NDArray[np.intp] | None:
        """Order in which lanes lie side by side; see `AbstractEngine.alike_order`."""
        return self._assembly.alike_order(lanes, motions) if lanes.assembly is not None else None

    def run(self, lanes: Lanes, motions: GroundMotions, times: SampleTimes) -> Response:
        """Runs a batch of lanes on the calling thread; see `AbstractEngine.run`."""
        if lanes.assembly is not None:
            return self._assembly.run(lanes, motions, times)
        return super().run(lanes, motions, times)

    def longest_step(self, lanes: Lanes, motions: GroundMotions) -> Array:
        """Longest step of every lane [s], from its stiffest mode and the damping."""
        if lanes.assembly is not None:
            return self._assembly.longest_step(lanes, motions)
        lanes = on_corners(lanes)
        if lanes.spatial and lanes.body is not None:
            stiffest = PointSprings.of(lanes, self.settings).stiffest_frequency()
        elif lanes.spatial:
            stiffest = spatial_frequencies(lanes, self.settings)[:, -1]
        elif lanes.body is not None:
            stiffest = CornerSprings.of(lanes, self.settings).stiffest_frequency(self.settings)
        elif lanes.profiles is not None:
            stiffest = dem_stack_bodies.stiffest_frequency(lanes, self.settings)
        else:
            stiffest = stiffest_frequency(as_stacks(lanes), self.settings)
        limit = self.settings.step_safety * stable_step(stiffest, self.settings)
        return np.asarray(np.minimum(self.settings.time_step, limit))

    def reserve(self, lanes: Lanes) -> tuple[Array, str] | None:
        """Whether blocks can stand on their springs; see `AbstractEngine.reserve`."""
        if lanes.assembly is not None:
            return None
        lanes = on_corners(lanes)
        if lanes.spatial and lanes.body is not None:
            ratio = PointSprings.of(lanes, self.settings).standing_ratio()
        elif lanes.spatial:
            ratio = _standing_ratio_in_space(lanes, self.settings)
        elif lanes.body is not None:
            ratio = CornerSprings.of(lanes, self.settings).standing_ratio()
        elif lanes.profiles is not None:
            ratio = dem_stack_bodies.standing_ratio(lanes, self.settings)
        else:
            ratio = standing_ratio(as_stacks(lanes), self.settings)
        return ratio.min(axis=1), (
            "in dem the stiffness against rocking of the springs below a block over what the "
            "weight on them needs to stand, k_n I / (W h); raise engines.dem.normal_stiffness"
        )

    def inputs(
        self, module: Any, lanes: Lanes, motions: GroundMotions, times: SampleTimes
    ) -> dict[str, Any]:
        """What the kernel takes; see `KernelEngine.inputs`."""
        lanes = on_corners(lanes)
        stacks, step = as_stacks(lanes), self.longest_step(lanes, motions)
        # A lane whose sizes are not finite takes one step to find that out.
        per_lane = {"time_step": np.where(np.isfinite(step), step, times.duration)}
        if lanes.spatial:
            per_lane["moves"] = _moved_along(motions)
        if lanes.spatial and lanes.body is not None:
            columns = sprung_inputs(lanes, self.settings, per_lane)
            return columns | {"knobs": self._knobs(module)}
        if lanes.body is not None:
            springs, time_step = CornerSprings.of(lanes, self.settings), per_lane["time_step"]
            blocks = cornered_columns(springs, lanes, time_step)
            return {"blocks": blocks, "corners": springs.columns, "knobs": self._knobs(module)}
        if not lanes.spatial:
            turned = np.diff(stacks.rotation_start, axis=1, prepend=0.0).any(axis=1)
            spins = speed_columns(lanes)["omega"] != 0.0
            per_lane["uplift_time"] = np.where(turned | spins, 0.0, NEVER)
            if lanes.profiles is None:
                blocks = _planar_blocks(stacks, self.settings)
            else:
                blocks = dem_stack_bodies.sprung_stacks(lanes, self.settings)
            columns = {"blocks": blocks, "lanes": per_lane, "knobs": self._knobs(module)}
            return columns | {"feet": foot_columns(lanes, module.Foot)}
        points = point_pairs(self.settings.subcontacts, self.settings.subcontacts_across)
        return {
            "blocks": _with_ground(start_in_space(lanes, self.settings)),
            "lanes": per_lane | _lane_columns_in_space(lanes, self.settings),
            "points": points,
            "knobs": self._knobs(module),
        }

    def _knobs(self, module: Any) -> Any:
        knobs = module.Knobs()
        knobs.gravity = GRAVITY
        knobs.normal_stiffness = self.settings.normal_stiffness
        knobs.shear_stiffness = self.settings.shear_stiffness
        knobs.shear_flexibility = 1.0 / self.settings.shear_stiffness
        knobs.stiffness_damping = self.settings.stiffness_damping
        knobs.mass_damping = self.settings.mass_damping
        knobs.cohesion = self.settings.cohesion
        knobs.tensile_strength = self.settings.tensile_strength
        knobs.dilatancy = math.tan(self.settings.dilatancy)
        return knobs

    def fields(
        self, lanes: Lanes, motions: GroundMotions, times: SampleTimes, found: Found
    ) -> dict[str, npt.NDArray[Any]]:
        """Lane fields of a response; see `KernelEngine.fields`."""
        rows, step = found.lanes, self.longest_step(lanes, motions)
        if lanes.spatial:
            blocks = spatial_fields(lanes, found.blocks)
            account = account_in_space(lanes, motions, times.duration, rows)
            gained = unstable(lanes, account, blocks["peak_tilt"], rigid=False)
        else:
            blocks = planar_fields(found.blocks)
            # Springs tilt under what rigid faces carry: its own account alone tells what is gained.
            account, peak = account_of(rows, step), blocks["peak_rotation"]
            gained = unstable(lanes, account, peak, rigid=False, complete=True)
        # In the last step of the run every interface was closed and held.
        rest_time = rest_start_times(rows, times.times[-1] - 1.5 * step)
        return lane_fields(rows, rest_time, [(gained, Status.UNSTABLE)]) | blocks


def _planar_blocks(stacks: Lanes, settings: DemSettings) -> dict[str, Array]:
    """Fields of the struct `Block`, shape [lane, block] each."""
    start, speeds = start_at_rest(stacks, settings), speed_columns(stacks)
    return {
        **body_columns(stacks),
        "depth": interface_depth(stacks),
        "x": start.x,
        "z": start.settlement,
        "theta": start.rotation,
        "stretch": start.stretch,
        **{name: np.broadcast_to(each[:, None], start.x.shape) for name, each in speeds.items()},
    }


def _standing_ratio_in_space(lanes: Lanes, settings: DemSettings) -> Array:
    """`dem_springs.standing_ratio` about the weaker of both axes of a face, [lane, block]."""
    springs = SpatialSprings.of(lanes, settings)
    stacks, stiffness = as_stacks(lanes), settings.normal_stiffness
    ratios = [
        standing_on(stacks, stiffness, springs.place[..., axis], springs.area) for axis in (0, 1)
    ]
    return np.minimum(*ratios)


def _moved_along(motions: GroundMotions) -> npt.NDArray[np.int32]:
    """Sum of 1 where a base moves along x, 2 along y and 4 along z, shape [lane]."""
    x, y, z = (part.moves.astype(np.int32) for part in motions.components)
    return np.asarray(x + 2 * y + 4 * z)


def _lane_columns_in_space(lanes: Lanes, settings: DemSettings) -> dict[str, npt.NDArray[Any]]:
    """What the struct `Lane` of blocks in space has besides step and motion, shape [lane] each."""
    stacks = cast(SpatialLanes, as_stacks(lanes))
    away = (stacks.rotation_start != 0.0) | (stacks.rotation_across_start != 0.0)
    away = (away | (stacks.gap_start > 0.0)).any(axis=1)
    return {
        "uplift_time": np.where(away, 0.0, NEVER),
        "creep": _creep_speed(stacks, settings),
    }


def _creep_speed(stacks: SpatialLanes, settings: DemSettings) -> Array:
    """Speed up to which faces that stick may slip back and forth on their springs [m/s], [lane].

    A mass M on a shear spring K that holds at most a force F swings by at most F / K, at the speed
    F / sqrt(K M). What slides faster has left that; what slides slower sticks within a quarter of a
    swing. The loosest interface counts.
    """
    mass = sum_above(stacks.mass)
    area = stacks.face_width * stacks.face_depth
    bound = stacks.friction * GRAVITY * mass + settings.cohesion * area
    swing = bound / np.sqrt(settings.shear_stiffness * area * mass)
    return np.asarray(np.maximum(swing.max(axis=1), LEAST_CREEP))


def _with_ground(columns: dict[str, Array]) -> dict[str, Array]:
    """Blocks on the ground, body 0: an endless flat face, of no height."""
    endless = dict.fromkeys(("half_width", "half_depth"), ENDLESS)
    return {
        name: np.concatenate([np.full((len(each), 1), endless.get(name, 0.0)), each], axis=1)
        for name, each in columns.items()
    }


def equivalent_restitution(
    lanes: Lanes, settings: DemSettings | None = None, base: GroundMotions | None = None
) -> Array:
    """Angular restitution of a rigid block that swings back as far as the one on springs [-].

    The root of the ratio of the energies at the first turn on the other side and at the release,
    to be held against Housner's `model.rocking.angular_restitution`. The springs have a mean value
    of
    their own only where they absorb a blow before the next: bounces are part of it.

    Args:
        lanes: Single blocks, released from `rotation_start`, not zero.
        settings: Defaults where None.
        base: Motions of a base that stays where it is, of a kind whose kernel is at hand; none
            where None.

    Returns:
        Shape [lane].

    References:
        Housner (1963), energy of free rocking.
    """
    quarter = rocking.quarter_period(lanes.width, lanes.height, lanes.rotation_start)
    duration = 2.5 * float(np.max(quarter))
    times = SampleTimes(duration, duration / TURN_SAMPLES)
    response = Dem(settings).run(lanes, base or StillBase(lanes.lane_count), times)
    away = -np.sign(lanes.rotation_start)[:, None] * response["rotation"]
    turn = np.maximum(away.max(axis=1), 0.0)
    angle = lanes.slenderness_angle
    after = np.cos(angle - turn) - np.cos(angle)
    before = np.cos(angle - np.abs(lanes.rotation_start)) - np.cos(angle)
    return np.asarray(np.sqrt(after / before))
