"""Small batches of blocks in space that several test files share."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import numpy.typing as npt

from tests.shared.blocks import at_rest, make_lanes
from warprock.model.lanes import Lanes, SpatialLanes
from warprock.model.motion import GroundMotions, PlanarMotions, SpatialMotions, StillBase, no_motion
from warprock.model.response import SOUND, Response, SampleTimes
from warprock.running.batch import run_batch

Array = npt.NDArray[np.float64]

ONLY_IN_SPACE = (
    "rotation_across_start",
    "yaw_start",
    "gap_start",
    "centre_offset_x",
    "centre_offset_y",
    "offset_across",
)


def in_space(lanes: Lanes, **more: npt.ArrayLike) -> SpatialLanes:
    """The same blocks in space, with other values of some fields."""
    zero = np.zeros_like(lanes.width)
    parts = {field.name: getattr(lanes, field.name) for field in dataclasses.fields(lanes)}
    parts |= dict.fromkeys(ONLY_IN_SPACE, zero)
    parts |= {name: zero + np.asarray(value) for name, value in more.items()}
    return SpatialLanes(**parts)


def spatial_lanes(
    width: npt.ArrayLike, height: npt.ArrayLike, friction: npt.ArrayLike = 1.0,
    **more: npt.ArrayLike,
) -> SpatialLanes:  # fmt: skip
    """Single blocks in space from full widths and heights [m]; more fields by name."""
    return in_space(make_lanes(width, height, friction=friction), **more)


def spatial_stack(
    width: npt.ArrayLike, height: npt.ArrayLike, **more: npt.ArrayLike
) -> SpatialLanes:
    """One stack in space from the full widths and heights of its blocks [m]; more by name."""
    flat = make_lanes(width, height)
    parts = {
        name: each[None, :] for name, each in flat.arrays.items() if name != "angular_restitution"
    }
    return in_space(Lanes(**parts, angular_restitution=np.ones(1)), **more)


def still(count: int) -> SpatialMotions:
    """A base that does not move."""
    return SpatialMotions(StillBase(count), StillBase(count), StillBase(count))


def unmoved(count: int) -> SpatialMotions:
    """The same as pulses of no size: see `at_rest`."""
    return along(at_rest(count))


def along(
    x: PlanarMotions, y: PlanarMotions | None = None, z: PlanarMotions | None = None
) -> SpatialMotions:
    """A base that moves along x, and along y and z where given."""
    return SpatialMotions(x, y or no_motion(x), z or no_motion(x))


def mirrored(lanes: SpatialLanes, *, x: bool, y: bool) -> SpatialLanes:
    """The mirror image of blocks, left for right along x, or along y, or both."""
    sx, sy = (-1.0 if x else 1.0), (-1.0 if y else 1.0)
    return dataclasses.replace(
        lanes,
        rotation_start=sx * lanes.rotation_start,
        offset=sx * lanes.offset,
        centre_offset_x=sx * lanes.centre_offset_x,
        rotation_across_start=sy * lanes.rotation_across_start,
        offset_across=sy * lanes.offset_across,
        centre_offset_y=sy * lanes.centre_offset_y,
        yaw_start=sx * sy * lanes.yaw_start,
    )


def sound_run(
    engine: str, lanes: Lanes, motions: GroundMotions, times: SampleTimes,
    settings: Any = None, **more: Any,
) -> Response:  # fmt: skip
    """Response of an engine, every lane of which is `SOUND`; further arguments of `run_batch`."""
    response = run_batch(engine, lanes, motions, times, settings=settings, **more)
    assert np.all(np.isin(response["status"], SOUND))
    return response
