"""Blocks as inputs of kernels: their properties and starts, shape [lane, block].

Lowest block first; a single block is a stack of one.
"""

from __future__ import annotations

from typing import Any, cast

import numpy as np
import numpy.typing as npt

from warprock.engines.bodies import rotate_lever
from warprock.engines.launching import NEVER
from warprock.engines.stack_bodies import profile_columns, start_on_feet
from warprock.model.lanes import Lanes, SpatialLanes, as_stacks
from warprock.model.pose import bottom_corners, rotate_yaw, start_poses
from warprock.model.release import Release
from warprock.model.stacking import sum_above
from warprock.model.turning import rotate

Array = npt.NDArray[np.float64]

TOUCHING = 1e-9
"""Height above the lowest corner up to which a corner touches, too, at the start [m]."""


def start_on_corners(lanes: Lanes) -> tuple[Array, Array, Array, Array]:
    """Poses of the blocks at the start, each on its lower corner on the face below.

    A block without rotation relative to the body below has its centre at the offset along it. A
    rotated block is rotated about the end of the overlap to which it leans.

    Returns:
        x and z of their centres, and x of both ends of the overlaps below them, at -x and at +x
        [m], shape [lane, block] each.
    """
    if lanes.profiles is not None:
        return start_on_feet(lanes)
    half_face, half_height = 0.5 * lanes.face_width, 0.5 * lanes.height
    x, z, left, right = np.zeros((4, *lanes.width.shape))
    below_x, below_z, below_turn, below_height = np.zeros((4, lanes.lane_count))
    below_face = np.full(lanes.lane_count, np.inf)
    for block in range(lanes.block_count):
        turn, offset = lanes.rotation_start[:, block], lanes.offset[:, block]
        ends = [s * np.minimum(below_face, half_face[:, block] + s * offset) for s in (-1.0, 1.0)]
        feet = [rotate_lever(end, below_height, below_turn) for end in ends]
        left[:, block], right[:, block] = (below_x + foot[0] for foot in feet)
        # From either end to the centre; both give the same if the block is not rotated.
        ways = [rotate_lever(end - offset, -half_height[:, block], turn) for end in ends]
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
    """Fields of the struct `Stack` of kernels/shape/stack_run.py, shape [lane] each."""
    turned = np.diff(lanes.rotation_start, axis=1, prepend=0.0)
    # The first number of a stack that differs from that of its mirror image.
    parts = [lanes.rotation_start, lanes.offset]
    odd = np.concatenate(parts if lanes.profiles is None else [*parts, lanes.profiles.odd], axis=1)
    first = np.take_along_axis(odd, np.argmax(odd != 0.0, axis=1)[:, None], axis=1)[:, 0]
    return {
        "uplift_time": np.where(turned.any(axis=1), 0.0, NEVER),
        "lean": np.sign(first),
    }


def find_load(lanes: Lanes, x: Array) -> tuple[Array, Array]:
    """Mass [kg] and centre [m] of all blocks above each interface, shape [lane, block] each.

    Args:
        lanes: The stacks.
        x: Centres of mass of the blocks [m], shape [lane, block].
    """
    above = sum_above(lanes.mass)
    return above, sum_above(lanes.mass * x) / above


def body_columns(lanes: Lanes) -> dict[str, Array]:
    """Fields of the struct `Block` that are read off the lanes, shape [lane, block] each."""
    return {
        "half_width": 0.5 * lanes.face_width,
        "half_height": 0.5 * lanes.height,
        "inverse_mass": 1.0 / lanes.mass,
        "inverse_inertia": 12.0 / (lanes.mass * (lanes.width**2 + lanes.height**2)),
        "friction": lanes.friction,
        "offset": lanes.offset,
        "theta": lanes.rotation_start,
    }


def planar_columns(lanes: Lanes, fall: float) -> dict[str, npt.NDArray[Any]]:
    """Fields of the struct `Block` of kernels/shape/stack_run.py, shape [lane, block] each.

    Of stacks with bodies those of kernels/shape/stack_body.py.

    Args:
        lanes: The stacks.
        fall: Velocity that gravity adds in a step [m/s], or that times the step [m], for
            multipliers that are impulses times the step.
    """
    x, z, left, right = start_on_corners(lanes)
    above, centre = find_load(lanes, x)
    # By statics where an interface is closed; else the end that touches carries everything.
    width = right - left
    width = np.where(width > 0.0, width, np.inf)
    turn = np.diff(lanes.rotation_start, axis=1, prepend=0.0)
    on_left, on_right = (
        np.select([side * turn > 0.0, side * turn < 0.0], [1.0, 0.0], np.clip(arm / width, 0, 1))
        for side, arm in ((-1.0, right - centre), (1.0, centre - left))
    )
    profiled = lanes.profiles is not None
    return {
        **(
            profile_columns(lanes, np.where(stack_columns(lanes)["lean"] < 0.0, -1.0, 1.0))
            if profiled
            else body_columns(lanes)
        ),
        "x": x,
        "z": z,
        "left": fall * above * on_left,
        "right": fall * above * on_right,
    }


def spatial_columns(lanes: Lanes) -> dict[str, Array]:
    """Fields of the struct `Block` of kernels/shape_space/block.py, shape [lane, block] each."""
    stacks = cast(SpatialLanes, as_stacks(lanes))
    width, depth, height = stacks.width, stacks.depth, stacks.height
    position, attitude = start_poses(stacks)
    flat = _flat_places(stacks)
    turn = np.diff(stacks.yaw_start, axis=1, prepend=0.0)
    low = rotate(attitude[..., None, :], bottom_corners(stacks))[..., 2]
    above = low - low.min(axis=-1, keepdims=True)
    columns = {
        "half_width": 0.5 * stacks.face_width,
        "half_depth": 0.5 * stacks.face_depth,
        "half_height": 0.5 * height,
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
    if lanes.release is not None and lanes.release.gyration is not None:
        over = 1.0 / lanes.release.gyration
        columns |= {f"inverse_{axis}": over[:, i, None] for i, axis in enumerate("xyz")}
    columns |= {name: position[..., axis] for axis, name in enumerate(("x", "y", "z"))}
    return columns | {
        name: attitude[..., part] for part, name in enumerate(("qx", "qy", "qz", "qw"))
    }


def start_columns(lanes: Lanes) -> dict[str, npt.NDArray[Any]]:
    """Rotations [rad] and angular velocities [rad/s] of single blocks in the plane, [lane] each."""
    release = lanes.release
    rates = np.zeros(lanes.lane_count) if release is None else release.angular_velocity[:, 1]
    return {"starts": lanes.rotation_start, "rates": np.ascontiguousarray(rates)}


def speed_columns(lanes: Lanes) -> dict[str, Array]:
    """Velocities of single blocks in the plane at the start, by what kernels call them, [lane].

    vx and vz of the centre of mass [m/s], and omega towards +x [rad/s].
    """
    release = lanes.release
    if release is None:
        return dict.fromkeys(("vx", "vz", "omega"), np.zeros(lanes.lane_count))
    v, omega = release.velocity, release.angular_velocity[:, 1]
    return {"vx": v[:, 0], "vz": v[:, 2], "omega": omega}


def throw_columns(lanes: Lanes) -> dict[str, npt.NDArray[Any]]:
    """Fields of the struct `Throw` of kernels/shape_space/thrown.py, shape [lane] each."""
    count = lanes.lane_count
    release = lanes.release or Release(np.zeros((count, 3)), np.zeros((count, 3)))
    found: dict[str, npt.NDArray[Any]] = {
        f"{kind}{axis}": each[:, number]
        for kind, each in (("v", release.velocity), ("w", release.angular_velocity))
        for number, axis in enumerate("xyz")
    }
    return found | {"tumbles": np.full(count, int(release.thrown), np.int32)}


def _flat_places(stacks: SpatialLanes) -> Array:
    """Middles of the bottom faces of flat blocks from the centre of mass below, in its axes [m].

    Shape [lane, block, 2]; of the lowest block from the origin of the ground.
    """
    offset = np.stack([stacks.offset, stacks.offset_across], axis=-1)
    below = np.concatenate([np.zeros_like(stacks.yaw_start[:, :1]), stacks.yaw_start[:, :-1]], 1)
    centre = np.stack([stacks.centre_offset_x, stacks.centre_offset_y], axis=-1)
    beside = np.concatenate([np.zeros_like(centre[:, :1]), centre[:, :-1]], axis=1)
    # What stands on the ground stands where its first block's offset says, in the axes of the base.
    return np.asarray(rotate_yaw(offset, -below) - beside)
