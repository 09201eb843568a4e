"""What the host side of the engines shares where a lane is a stack of blocks.

A kernel of stacks runs `LANES` lanes a thread, `LANE_WIDTH` of them on a CPU, one on any other
device. Arrays of its blocks are [block, lane], lowest block first, so that lanes lie side by side.
"""

from __future__ import annotations

import dataclasses
from types import ModuleType
from typing import Any

import numpy as np
import numpy.typing as npt
import warp as wp

from warprock.engines.launching import (
    NEVER,
    Kernel,
    Target,
    motion_columns,
    padded,
    struct_rows,
)
from warprock.kernels.instance import LANE_WIDTH, REALS, kernel_module
from warprock.model.lanes import Lanes
from warprock.model.motion import GroundMotions
from warprock.model.response import SampleTimes

Array = npt.NDArray[np.float64]


def stack_module(
    kernel: Kernel, target: Target, motions: GroundMotions, lanes: Lanes, iterations: int = 0
) -> ModuleType:
    """The instance of a stack's kernel file for a target, a kind of motion and a block count."""
    module: ModuleType = kernel_module(
        kernel.file,
        precision=target.precision,
        motion=motions.kind.value,
        iterations=iterations,
        blocks=lanes.block_count,
        lanes=LANE_WIDTH if kernel.packed else 1,
    )
    return module


def as_stacks(lanes: Lanes) -> Lanes:
    """The lanes with a block axis: a single block is a stack of one."""
    if lanes.stacked:
        return lanes
    parts = {
        field.name: getattr(lanes, field.name)[:, None]
        for field in dataclasses.fields(lanes)
        if field.name != "angular_restitution"
    }
    return dataclasses.replace(lanes, **parts)


def launch_stacks(
    module: ModuleType,
    target: Target,
    motions: GroundMotions,
    times: SampleTimes,
    blocks: dict[str, npt.NDArray[Any]],
    lanes: dict[str, npt.NDArray[Any]],
    knobs: Any,
) -> tuple[npt.NDArray[Any], npt.NDArray[Any], Array | None]:
    """Runs the kernel `stacks` of a launch module over a batch of lanes.

    Args:
        module: Instance of a `*_stack_launch` kernel file with the structs `Block` (one block),
            `Stack` (one lane), `Motion`, `Knobs`, `BlockResult`, `Result` and `Found`, which has
            the arrays `results` [lane], `blocks` [block, lane] and `rotations`
            [sample, block, lane], empty where not asked for.
        target: Where and how it runs.
        motions: Ground motions of the lanes.
        times: Duration and sampling.
        blocks: Fields of the struct `Block`, shape [lane, block] each.
        lanes: Fields of the struct `Stack`, shape [lane] each.
        knobs: The struct `Knobs`.

    Returns:
        Rows of `Result`, shape [lane]; rows of `BlockResult`, shape [lane, block]; rotations
        [rad], shape [lane, block, sample], if asked for.
    """
    real = REALS[target.precision]
    lane_count, block_count = next(iter(blocks.values())).shape
    side_by_side = module.LANES
    count = -(-lane_count // side_by_side) * side_by_side
    samples = times.times
    motion_rows = struct_rows(module.Motion, motion_columns(module.Motion, motions), count)
    with wp.ScopedDevice(target.device):
        found = module.Found()
        found.results = wp.empty(count, dtype=module.Result)
        found.blocks = wp.empty((block_count, count), dtype=module.BlockResult)
        shape = (len(samples), block_count, count) if times.interval is not None else (0, 0, 0)
        found.rotations = wp.full(shape, value=np.inf, dtype=real)
        wp.launch(
            module.stacks,
            dim=count // side_by_side,
            inputs=[
                wp.array(block_rows(module.Block, blocks, count), dtype=module.Block),
                wp.array(struct_rows(module.Stack, lanes, count), dtype=module.Stack),
                wp.array(motion_rows, dtype=module.Motion),
                wp.array(motions.components[0].pool, dtype=real),
                wp.array(samples, dtype=real),
                knobs,
                found,
            ],
        )
        results = found.results.numpy()[:lane_count]
        per_block = found.blocks.numpy()[:, :lane_count].T
        if times.interval is None:
            return results, per_block, None
        histories = found.rotations.numpy()[:, :, :lane_count].transpose(2, 1, 0)
        return results, per_block, np.ascontiguousarray(histories, dtype=np.float64)


def start_on_corners(lanes: Lanes) -> tuple[Array, Array, Array, Array]:
    """Where the blocks start, each on its lower corner on the face beneath.

    A block that is not turned against what it stands on has its centre at the offset along it;
    a turned one is turned about the end of the overlap to which it leans.

    Returns:
        x and z of their centres, and x of both ends of the overlaps below them, at -x and at +x
        [m], shape [lane, block] each.
    """
    half_face, half_height = 0.5 * lanes.face_width, 0.5 * lanes.height
    x, z, left, right = np.zeros((4, *lanes.width.shape))
    below_x, below_z, below_turn, below_height = np.zeros((4, lanes.lane_count))
    below_face = np.full(lanes.lane_count, np.inf)
    for block in range(lanes.block_count):
        turn, offset = lanes.rotation_start[:, block], lanes.offset[:, block]
        ends = [s * np.minimum(below_face, half_face[:, block] + s * offset) for s in (-1.0, 1.0)]
        feet = [_turned(end, below_height, below_turn) for end in ends]
        left[:, block], right[:, block] = (below_x + foot[0] for foot in feet)
        # From either end to the centre; both lead to the same if the block is not turned.
        ways = [_turned(end - offset, -half_height[:, block], turn) for end in ends]
        leans = [turn < below_turn, turn > below_turn]
        from_left, from_right = (
            np.array([below_x + foot[0] - way[0], below_z + foot[1] - way[1]])
            for foot, way in zip(feet, ways, strict=True)
        )
        below_x, below_z = np.select(leans, [from_left, from_right], 0.5 * (from_left + from_right))
        x[:, block], z[:, block] = below_x, below_z
        below_face, below_height, below_turn = half_face[:, block], half_height[:, block], turn
    return x, z, left, right


def stack_columns(lanes: Lanes) -> dict[str, Array]:
    """Fields of the struct `Stack`, shape [lane] each."""
    turned = np.diff(lanes.rotation_start, axis=1, prepend=0.0)
    # The first number of a stack that is not the same in its mirror image.
    odd = np.concatenate([lanes.rotation_start, lanes.offset], axis=1)
    first = np.take_along_axis(odd, np.argmax(odd != 0.0, axis=1)[:, None], axis=1)[:, 0]
    return {
        "uplift_time": np.where(turned.any(axis=1), 0.0, NEVER),
        "lean": np.where(first < 0.0, -1.0, 1.0),
    }


def carried(lanes: Lanes, x: Array) -> tuple[Array, Array]:
    """What stands on each interface [kg] and where its centre is [m], shape [lane, block] each.

    Args:
        lanes: The stacks.
        x: Where the centres of mass of the blocks are [m], shape [lane, block].
    """
    above = np.cumsum(lanes.mass[:, ::-1], axis=1)[:, ::-1]
    return above, np.cumsum((lanes.mass * x)[:, ::-1], axis=1)[:, ::-1] / above


def body_columns(lanes: Lanes) -> dict[str, Array]:
    """Fields of the struct `Block` that are read off the lanes, shape [lane, block] each."""
    return {
        "face": 0.5 * lanes.face_width,
        "high": 0.5 * lanes.height,
        "inverse_mass": 1.0 / lanes.mass,
        "inverse_inertia": 12.0 / (lanes.mass * (lanes.width**2 + lanes.height**2)),
        "friction": lanes.friction,
        "offset": lanes.offset,
        "theta": lanes.rotation_start,
    }


def block_columns(lanes: Lanes, fall: float) -> dict[str, Array]:
    """Fields of the struct `Block`, shape [lane, block] each.

    Args:
        lanes: The stacks.
        fall: Velocity that gravity adds in a step [m/s], or that times the step [m], for
            multipliers that are impulses times the step.
    """
    x, z, left, right = start_on_corners(lanes)
    above, centre = carried(lanes, x)
    # By statics where an interface is closed; else the end that touches carries everything.
    width = right - left
    width = np.where(width > 0.0, width, np.inf)
    turn = np.diff(lanes.rotation_start, axis=1, prepend=0.0)
    on_left, on_right = (
        np.select([side * turn > 0.0, side * turn < 0.0], [1.0, 0.0], np.clip(arm / width, 0, 1))
        for side, arm in ((-1.0, right - centre), (1.0, centre - left))
    )
    return {
        **body_columns(lanes),
        "x": x,
        "z": z,
        "left": fall * above * on_left,
        "right": fall * above * on_right,
    }


def _turned(x: Array, z: Array, rotation: Array) -> tuple[Array, Array]:
    """A lever turned clockwise."""
    s, c = np.sin(rotation), np.cos(rotation)
    return x * c + z * s, z * c - x * s


def block_rows(struct: Any, columns: dict[str, npt.NDArray[Any]], count: int) -> npt.NDArray[Any]:
    """Rows of a struct of blocks, shape [block, lane], padded to a count of lanes."""
    block_count = next(iter(columns.values())).shape[1]
    rows = np.zeros((block_count, count), dtype=struct.numpy_dtype())
    for name in rows.dtype.names or ():
        for block in range(block_count):
            rows[name][block] = padded(columns[name][:, block], count)
    return rows
