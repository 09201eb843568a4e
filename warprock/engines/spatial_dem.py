"""The soft-spring engine in space: a grid of sub-contact springs under every block, batched."""

from __future__ import annotations

from types import ModuleType
from typing import Any, cast

import numpy as np
import numpy.typing as npt
import warp as wp

from warprock.engines.decoding import lane_fields
from warprock.engines.dem_springs import stable_step, standing_on
from warprock.engines.launching import (
    NEVER,
    Kernel,
    Target,
    respond,
    struct_rows,
)
from warprock.engines.spatial_dem_springs import (
    ENDLESS,
    SpatialSprings,
    point_pairs,
    spatial_frequencies,
    start_in_space,
)
from warprock.engines.spatial_launching import (
    block_fields,
    components,
    histories,
    launch_spatial,
)
from warprock.engines.spatial_soundness import unstable_in_space
from warprock.engines.stack_launching import as_stacks
from warprock.kernels.instance import LANE_WIDTH, REALS, kernel_module
from warprock.model.lanes import Lanes, SpatialLanes
from warprock.model.motion import GroundMotions
from warprock.model.response import Response, SampleTimes, Status
from warprock.settings.engines import DemSettings
from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]

LEAST_CREEP = 1e-9
"""Speed that is round-off of a block that nothing holds [m/s]."""


def dem_module(
    kernel: Kernel, settings: DemSettings, target: Target, lanes: Lanes, motions: GroundMotions
) -> ModuleType:
    """The instance of the kernel for a grid of points, a target, a motion and a block count."""
    module: ModuleType = kernel_module(
        kernel.file,
        precision=target.precision,
        motion=motions.kind.value,
        iterations=point_pairs(settings.subcontacts, settings.subcontacts_across).shape[1],
        blocks=lanes.block_count,
        lanes=LANE_WIDTH if kernel.packed else 1,
        friction="box" if settings.friction_box else "cone",
    )
    return module


def longest_steps(settings: DemSettings, lanes: Lanes) -> Array:
    """Longest step of every lane [s], from its stiffest mode and the damping, shape [lane]."""
    limit = stable_step(spatial_frequencies(lanes, settings)[:, -1], settings)
    return np.asarray(np.minimum(settings.time_step, settings.step_safety * limit))


def standing_ratio_in_space(lanes: Lanes, settings: DemSettings) -> Array:
    """`dem_springs.standing_ratio` about the weaker of both axes of a face, [lane, block]."""
    springs = SpatialSprings.of(lanes, settings)
    stacks, stiffness = as_stacks(lanes), settings.normal_stiffness
    ratios = [
        standing_on(stacks, stiffness, springs.place[..., axis], springs.area) for axis in (0, 1)
    ]
    return np.minimum(*ratios)


def run_dem(
    module: ModuleType,
    settings: DemSettings,
    knobs: Any,
    target: Target,
    lanes: Lanes,
    motions: GroundMotions,
    times: SampleTimes,
) -> Response:
    """Runs blocks in space; see `AbstractEngine.run`.

    Args:
        module: The instance of the kernel.
        settings: Of the springs.
        knobs: The same as the struct `Knobs` of the module.
        target: Precision and device.
        lanes: Blocks and starts.
        motions: Their ground motions.
        times: Duration and sampling.
    """
    step = longest_steps(settings, lanes)
    count = -(-lanes.lane_count // module.LANES) * module.LANES
    columns = lane_columns(lanes, motions, times, step) | {"creep": creep_speed(lanes, settings)}
    per_lane = struct_rows(module.Lane, columns, count)
    points = point_pairs(settings.subcontacts, settings.subcontacts_across)
    with wp.ScopedDevice(target.device):
        rows, per_block, attitudes = launch_spatial(
            module,
            target,
            motions,
            times,
            with_ground(start_in_space(lanes, settings)),
            wp.array(per_lane, dtype=module.Lane),
            wp.array(points, dtype=REALS[target.precision]),
            knobs,
        )
    # Body 0 is the ground.
    per_block = per_block[:, 1:]
    attitudes = None if attitudes is None else attitudes[:, 1:]
    fields = block_fields(lanes, per_block)
    # Springs lean and sink under what rigid faces carry.
    gained = unstable_in_space(
        lanes,
        motions,
        times.duration,
        energy_lost=rows["loss"],
        peak_tilt=fields["peak_tilt"],
        deepest=rows["deepest"],
        rigid=False,
    )
    rotations, others = histories(lanes, attitudes)
    # In the last step of the run every interface was closed.
    marks = [(gained, Status.UNSTABLE)]
    found = fields | lane_fields(rows, times.times[-1] - 1.5 * step, marks)
    return respond("dem", found, rotations, times, others)


def lane_columns(
    lanes: Lanes, motions: GroundMotions, times: SampleTimes, step: Array
) -> dict[str, npt.NDArray[Any]]:
    """Fields of the struct `Lane`, shape [lane] each; `step` is the longest step [s]."""
    stacks = cast(SpatialLanes, as_stacks(lanes))
    away = (stacks.rotation_start != 0.0) | (stacks.rotation_across_start != 0.0)
    away = (away | (stacks.gap_start > 0.0)).any(axis=1)
    x, y, z = (part.moves.astype(np.int32) for part in components(motions))
    return {
        # A lane whose sizes are not finite takes one step to find that out.
        "time_step": np.where(np.isfinite(step), step, times.duration),
        "uplift_time": np.where(away, 0.0, NEVER),
        "moves": x + 2 * y + 4 * z,
    }


def creep_speed(lanes: Lanes, settings: DemSettings) -> Array:
    """Speed up to which faces that stick may slip back and forth on their springs [m/s], [lane].

    A mass M on a shear spring K that holds at most a force F swings by at most F / K, at the speed
    F / sqrt(K M). What slides faster has left that; what slides slower sticks within a quarter of a
    swing. The loosest interface counts.
    """
    stacks = cast(SpatialLanes, as_stacks(lanes))
    mass = np.cumsum(stacks.mass[:, ::-1], axis=1)[:, ::-1]
    area = stacks.face_width * stacks.face_depth
    bound = stacks.friction * GRAVITY * mass + settings.cohesion * area
    swing = bound / np.sqrt(settings.shear_stiffness * area * mass)
    return np.asarray(np.maximum(swing.max(axis=1), LEAST_CREEP))


def with_ground(columns: dict[str, Array]) -> dict[str, Array]:
    """Blocks on the ground, body 0: an endless flat face, of no height."""
    endless = dict.fromkeys(("width", "depth"), ENDLESS)
    return {
        name: np.concatenate([np.full((len(each), 1), endless.get(name, 0.0)), each], axis=1)
        for name, each in columns.items()
    }
