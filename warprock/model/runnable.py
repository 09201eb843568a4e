"""Refuses lanes and ground motions that no engine could run, before one is asked to.

A case is judged where it is read, key by key. What a program hands over as arrays is judged here,
once for all engines: shapes first, then every value.
"""

from __future__ import annotations

import dataclasses

import numpy as np
import numpy.typing as npt

from warprock.errors import InputError
from warprock.model.bodies import Bodies
from warprock.model.lanes import Lanes, SpatialLanes
from warprock.model.motion import (
    ComposedMotions,
    GroundMotions,
    PlanarMotions,
    RecordMotions,
    SpatialMotions,
    StillBase,
)
from warprock.model.pulse import PulseMotions

HIGHEST_STACK = 20
"""Blocks in the highest stack that an engine runs."""

RIGHT_ANGLE = 0.5 * np.pi
_ABOVE_ZERO = ("width", "height", "depth", "density")
_NOT_NEGATIVE = ("friction", "chamfer", "gap_start")
_POSITIVE_OF_MOTIONS = ("frequency", "rate", "interval")
_MAY_BE_INFINITE = ("stop",)
_PER_LANE = ("angular_restitution",)
"""Fields that have one value for a lane, be it a stack."""


SOURCE = "run_batch"
"""What errors name as their source."""


def require_runnable(lanes: Lanes, motions: GroundMotions) -> None:
    """Refuses lanes and motions that cannot be run.

    Args:
        lanes: The lanes.
        motions: Their ground motions.

    Raises:
        InputError: No lanes, an array of another shape or length than the widths, a value that is
            not finite or out of bounds, or motions of another number of lanes.
    """
    shape = np.shape(lanes.width)
    if len(shape) not in (1, 2) or shape[0] < 1 or not 1 <= (*shape, 1)[1] <= HIGHEST_STACK:
        allowed = (
            f"must be [lane] or [lane, block], with 1 lane or more, 1 to {HIGHEST_STACK} blocks"
        )
        raise InputError(SOURCE, "lanes.width", list(shape), f"the shape of its array {allowed}")
    for field, got in lanes.arrays.items():
        name = f"lanes.{field}"
        wanted = shape[:1] if field in _PER_LANE else shape
        values = _numbers(got, wanted, name)
        # Engines that follow their own contact law have no use for it, and it may be any number.
        if field not in _PER_LANE:
            _require(values, np.isfinite(values), name, "must be finite")
        if field in _ABOVE_ZERO:
            _require(values, values > 0.0, name, "must be more than 0")
        elif field in _NOT_NEGATIVE:
            _require(values, values >= 0.0, name, "must be at least 0")
    _require_faces(lanes)
    if lanes.body is not None:
        _require_bodies(lanes, lanes.body)
    _require_motions(lanes, motions)


def _numbers(got: object, shape: tuple[int, ...], name: str) -> npt.NDArray[np.float64]:
    """An array of numbers of a shape.

    Raises:
        InputError: It has another shape, or holds no numbers.
    """
    values = got if isinstance(got, np.ndarray) else np.empty(0, dtype=object)
    if values.dtype.kind not in "fiu":
        kind = values.dtype if isinstance(got, np.ndarray) else type(got).__name__
        raise InputError(SOURCE, name, str(kind), "must be a NumPy array of numbers")
    if values.shape != shape:
        allowed = f"the shape of its array must be that of the widths, {list(shape)}"
        raise InputError(SOURCE, name, list(values.shape), allowed)
    return values


def _require(
    values: npt.NDArray[np.float64],
    good: npt.NDArray[np.bool_],
    name: str,
    allowed: str,
) -> None:
    """Refuses the first value that is not good."""
    if good.all():
        return
    lane, *block = (int(place[0]) for place in np.nonzero(~good))
    where = f"lane {lane}" + "".join(f", block {number + 1}" for number in block[:1])
    raise InputError(SOURCE, name, float(values[lane, *block]), f"{allowed} ({where})")


def _require_faces(lanes: Lanes) -> None:
    """Refuses blocks that no face is left of, that lie on a side, or lie beside their base."""
    limits: list[tuple[str, npt.NDArray[np.float64] | float, str]] = [
        ("chamfer", 0.5 * lanes.width, "half of the width"),
        ("rotation_start", RIGHT_ANGLE, "a right angle [rad]"),
    ]
    if isinstance(lanes, SpatialLanes):
        limits += [
            ("rotation_across_start", RIGHT_ANGLE, "a right angle [rad]"),
            ("centre_offset_x", 0.5 * lanes.face_width, "half of the face [m]"),
            ("centre_offset_y", 0.5 * lanes.face_depth, "half of the face [m]"),
        ]
    for field, limit, text in limits:
        values = getattr(lanes, field)
        good = np.abs(values) < limit
        _require(values, good, f"lanes.{field}", f"must be less than {text}")


def _require_bodies(lanes: Lanes, body: Bodies) -> None:
    """Refuses bodies of other lanes, of another space, and such as do not stand on their base."""
    count, axes = lanes.lane_count, 3 if lanes.spatial else 2
    most = body.points.shape[1] if np.ndim(body.points) == 3 else 0
    shapes = {
        "mass": (count,),
        "gyration": (count, 3) if lanes.spatial else (count,),
        "points": (count, max(most, 2), axes),
        "count": (count,),
        "corner_radius": (count,),
        "axes": (count, 4),
    }
    for field, shape in shapes.items():
        name = f"lanes.body.{field}"
        values = _numbers(getattr(body, field), shape, name)
        _require(values, np.isfinite(values), name, "must be finite")
        if field in ("mass", "gyration"):
            _require(values, values > 0.0, name, "must be more than 0")
    ends = body.base_ends
    stands = (ends[:, 0] < 0.0) & (ends[:, 1] > 0.0) & (body.centre_height > 0.0)
    allowed = "must have its centre of mass above the area between its lowest points"
    _require(ends[:, 0], stands, "lanes.body.points", allowed)


def _require_motions(lanes: Lanes, motions: GroundMotions) -> None:
    """Refuses motions that are not those of the lanes."""
    spatial = isinstance(motions, SpatialMotions)
    if spatial != lanes.spatial:
        allowed = "must be SpatialMotions for blocks in space, and no such for others"
        raise InputError(SOURCE, "motions", type(motions).__name__, allowed)
    parts = getattr(motions, "components", (motions,))
    several = isinstance(motions, ComposedMotions)
    axes = [f".{axis}" for axis in motions.axes] if several else [""]
    for part, axis in zip(parts, axes, strict=True):
        if not hasattr(part, "lane_count"):
            allowed = "must be ground motions"
            raise InputError(SOURCE, f"motions{axis}", type(part).__name__, allowed)
        if part.lane_count != lanes.lane_count:
            allowed = f"must be as many as the lanes, {lanes.lane_count}"
            raise InputError(SOURCE, f"motions{axis}.lane_count", part.lane_count, allowed)
        _require_motion(part, lanes.lane_count, f"motions{axis}")


def _require_motion(motion: PlanarMotions, count: int, place: str) -> None:
    """Refuses values of a motion that no base can follow."""
    if not dataclasses.is_dataclass(motion) or isinstance(motion, StillBase):
        return
    for field in dataclasses.fields(motion):
        name, values = f"{place}.{field.name}", getattr(motion, field.name)
        pool = field.name.startswith("pool_")
        shape = np.shape(getattr(motion, "pool_velocity", ())) if pool else (count,)
        values = _numbers(values, shape, name)
        finite = np.isfinite(values)
        if field.name in _MAY_BE_INFINITE:
            finite |= values == np.inf
        _require(values, finite, name, "must be finite")
        if field.name in _POSITIVE_OF_MOTIONS:
            _require(values, values > 0.0, name, "must be more than 0")
        elif field.name == "start":
            _require(values, values >= 0.0, name, "must be at least 0")
    if isinstance(motion, PulseMotions):
        later = motion.stop >= motion.start
        _require(motion.stop, later, f"{place}.stop", "must not be before the start")
    elif isinstance(motion, RecordMotions):
        size = len(motion.pool_velocity)
        inside = (motion.offset >= 0) & (motion.count >= 1)
        inside &= motion.offset.astype(np.int64) + motion.count <= size
        ends = motion.offset.astype(np.float64)
        allowed = f"must lie, with its count, inside the pool of {size} samples"
        _require(ends, inside, f"{place}.offset", allowed)
