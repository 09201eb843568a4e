"""What the host side of the engines shares where blocks move in space.

Single blocks and stacks alike have the block axis in the kernel: arrays of blocks are
[block, lane], lowest block first. A kernel runs `LANES` lanes a thread.
"""

from __future__ import annotations

import dataclasses
from types import ModuleType
from typing import Any, cast

import numpy as np
import numpy.typing as npt
import warp as wp

from warprock.engines.launching import (
    Target,
    motion_columns,
    struct_rows,
)
from warprock.engines.stack_launching import as_stacks, block_rows
from warprock.kernels.instance import REALS
from warprock.model.lanes import Lanes, SpatialLanes
from warprock.model.motion import GroundMotions, PlanarMotions, RecordMotions, SpatialMotions
from warprock.model.pose import bottom_corners, rotations, start_poses, turned
from warprock.model.response import SampleTimes

Array = npt.NDArray[np.float64]
Rows = npt.NDArray[Any]

TOUCHING = 1e-9
"""Height above the lowest corner up to which a corner touches, too, at the start [m]."""


def block_columns(lanes: Lanes) -> dict[str, Array]:
    """Fields of the struct `Block` of kernels/shape/space.py, shape [lane, block] each."""
    stacks = cast(SpatialLanes, as_stacks(lanes))
    width, depth, height = stacks.width, stacks.depth, stacks.height
    position, attitude = start_poses(stacks)
    flat = _flat_places(stacks)
    turn = np.diff(stacks.yaw_start, axis=1, prepend=0.0)
    low = turned(attitude[..., None, :], bottom_corners(stacks))[..., 2]
    above = low - low.min(axis=-1, keepdims=True)
    columns = {
        "width": 0.5 * stacks.face_width,
        "depth": 0.5 * stacks.face_depth,
        "height": 0.5 * height,
        "centre_x": stacks.centre_offset_x,
        "centre_y": stacks.centre_offset_y,
        "mass": stacks.mass,
        "inverse_x": 12.0 / (depth**2 + height**2),
        "inverse_y": 12.0 / (width**2 + height**2),
        "inverse_z": 12.0 / (width**2 + depth**2),
        "friction": stacks.friction,
        "flat_x": flat[..., 0],
        "flat_y": flat[..., 1],
        "flat_c": np.cos(turn),
        "flat_s": np.sin(turn),
        "standing": np.sum(above <= TOUCHING, axis=-1).astype(np.float64),
    }
    columns |= {name: position[..., axis] for axis, name in enumerate(("x", "y", "z"))}
    return columns | {
        name: attitude[..., part] for part, name in enumerate(("qx", "qy", "qz", "qw"))
    }


def _flat_places(stacks: SpatialLanes) -> Array:
    """Middles of the bottom faces of flat blocks from the centre of mass below, in its axes [m].

    Shape [lane, block, 2]; of the lowest block from the origin of the ground.
    """
    offset = np.stack([stacks.offset, stacks.offset_across], axis=-1)
    below = np.concatenate([np.zeros_like(stacks.yaw_start[:, :1]), stacks.yaw_start[:, :-1]], 1)
    centre = np.stack([stacks.centre_offset_x, stacks.centre_offset_y], axis=-1)
    beside = np.concatenate([np.zeros_like(centre[:, :1]), centre[:, :-1]], axis=1)
    # What stands on the ground stands where its first block's offset says, in the axes of the base.
    return np.asarray(_turned(offset, -below) - beside)


def _turned(vector: Array, angle: Array) -> Array:
    """Vectors [..., 2] turned by angles [rad], from +x to +y."""
    c, s = np.cos(angle), np.sin(angle)
    x, y = vector[..., 0], vector[..., 1]
    return np.stack([c * x - s * y, s * x + c * y], axis=-1)


def components(motions: GroundMotions) -> tuple[PlanarMotions, PlanarMotions, PlanarMotions]:
    """The motions along x, y and z."""
    return cast(SpatialMotions, motions).components


def _pool_and_rows(struct: Any, motions: GroundMotions, count: int) -> tuple[Array, Rows]:
    """Samples of the records of all directions in one pool, and rows of `Motion`, [3, lane]."""
    parts = components(motions)
    pools = [part.pool for part in parts]
    rows, first = [], 0
    for part, pool in zip(parts, pools, strict=True):
        placed = part
        if isinstance(part, RecordMotions):
            placed = dataclasses.replace(part, offset=(part.offset + first).astype(np.int32))
        rows.append(struct_rows(struct, motion_columns(struct, placed), count))
        first += pool.shape[1]
    return np.concatenate(pools, axis=1), np.stack(rows)


def launch_spatial(
    module: ModuleType,
    target: Target,
    motions: GroundMotions,
    times: SampleTimes,
    blocks: dict[str, Array],
    *settings: Any,
) -> tuple[Rows, Rows, Array | None]:
    """Runs the kernel `spatial` of a launch module over a batch of lanes.

    Args:
        module: Instance of a `spatial_*_launch` kernel file with the structs `Block`, `Motion`,
            `BlockResult`, `Result` and `Found`, see kernels/shape/space_found.py, and the constant
            `LANES`, the lanes of a thread. The kernel's arguments are blocks [block, lane],
            motions [direction, lane], the pool of records [row, sample], the times of the samples,
            the settings, and the struct `Found`.
        target: Where and how it runs.
        motions: Ground motions of the lanes.
        times: Duration and sampling.
        blocks: Fields of the struct `Block`, shape [lane, block] each.
        settings: What the kernel takes besides, after the sample times.

    Returns:
        Rows of `Result`, shape [lane]; rows of `BlockResult`, shape [lane, block]; attitudes
        (quaternions), shape [lane, block, sample, 4], if asked for.
    """
    real = REALS[target.precision]
    lane_count, block_count = next(iter(blocks.values())).shape
    side_by_side = module.LANES
    count = -(-lane_count // side_by_side) * side_by_side
    samples = times.times
    pool, motion_rows = _pool_and_rows(module.Motion, motions, count)
    with wp.ScopedDevice(target.device):
        found = module.Found()
        found.results = wp.empty(count, dtype=module.Result)
        found.blocks = wp.empty((block_count, count), dtype=module.BlockResult)
        asked = times.interval is not None
        shape = (len(samples), block_count, 4, count) if asked else (0, 0, 0, 0)
        found.attitudes = wp.full(shape, value=np.inf, dtype=real)
        wp.launch(
            module.spatial,
            dim=count // side_by_side,
            inputs=[
                wp.array(block_rows(module.Block, blocks, count), dtype=module.Block),
                wp.array(motion_rows, dtype=module.Motion),
                wp.array(pool, dtype=real),
                wp.array(samples, dtype=real),
                *settings,
                found,
            ],
        )
        results = found.results.numpy()[:lane_count]
        per_block = found.blocks.numpy()[:, :lane_count].T
        if not asked:
            return results, per_block, None
        attitudes = found.attitudes.numpy()[..., :lane_count].transpose(3, 1, 0, 2)
        return results, per_block, np.ascontiguousarray(attitudes, dtype=np.float64)


def block_fields(lanes: Lanes, per_block: Rows) -> dict[str, Array]:
    """Fields of a response that belong to blocks, from rows of `BlockResult`.

    Shape [lane] each for single blocks, [lane, block] for stacks.
    """
    stacks = cast(SpatialLanes, as_stacks(lanes))
    rows = {name: per_block[name].astype(np.float64) for name in per_block.dtype.names or ()}
    below = np.concatenate([np.zeros_like(stacks.yaw_start[:, :1]), stacks.yaw_start[:, :-1]], 1)
    slide = _turned(np.stack([rows["slide_x"], rows["slide_y"]], axis=-1), below)
    yaw = 2.0 * np.arctan2(rows["qz"], rows["qw"]) - stacks.yaw_start
    fields = {
        "peak_rotation": np.arctan(rows["peak"]),
        "peak_time": rows["peak_time"],
        "residual_slide": slide[..., 0],
        "residual_slide_across": slide[..., 1],
        "peak_slide": np.sqrt(rows["peak_slide"]),
        "peak_tilt": np.arctan(np.sqrt(rows["peak_tilt"])),
        "peak_rotation_across": np.arctan(rows["peak_across"]),
        "peak_yaw": 2.0 * np.arctan(np.abs(rows["peak_yaw"])),
        "residual_yaw": yaw - 2.0 * np.pi * np.round(yaw / (2.0 * np.pi)),
    }
    return fields if lanes.stacked else {name: values[:, 0] for name, values in fields.items()}


def histories(lanes: Lanes, attitudes: Array | None) -> tuple[Array | None, dict[str, Array]]:
    """Rotations, and the other histories by field, from attitudes [lane, block, sample, 4]."""
    if attitudes is None:
        return None, {}
    angles = rotations(attitudes if lanes.stacked else attitudes[:, 0])
    return angles[0], {"rotation_across": angles[1], "yaw": angles[2]}
