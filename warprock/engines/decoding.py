"""Fields of a response from the results of a kernel, the same for all engines."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, cast

import numpy as np
import numpy.typing as npt

from warprock.engines.launching import NEVER, Found
from warprock.engines.places import planar_places, spatial_places
from warprock.kernels.lane.modes import BROKEN, OVERTURNED, SLID_OFF, STALLED, UNSOLVED
from warprock.model.lanes import Lanes, SpatialLanes, as_stacks
from warprock.model.motion import GroundMotions
from warprock.model.pose import rotate_yaw, rotations, start_poses
from warprock.model.response import (
    ASSEMBLY_FIELDS,
    BODY_FIELDS,
    FIELDS,
    HISTORIES,
    INTEGER_FIELDS,
    LANE_FIELDS,
    MODEL_FIELDS,
    SPATIAL_FIELDS,
    TIE_FIELDS,
    USABLE,
    Outcome,
    Response,
    SampleTimes,
    Status,
)
from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]
Rows = npt.NDArray[Any]

FINITE_FIELDS = (
    "peak_rotation",
    "residual_slide",
    "peak_slide",
    "peak_penetration",
    "energy_lost",
)
"""Fields that must be finite in every lane, besides its rotations."""


def time_or_nan(times: Rows) -> Array:
    """Times as float64, NaN of events that did not occur."""
    values = np.asarray(times, dtype=np.float64)
    return np.where(values >= NEVER, np.nan, values)


FRICTION_SLACK = {"float64": 1e-6, "float32": 1e-4}
"""Relative lack of friction up to which a lane counts as inside the model. The truncated series of
the contact force err by some 1e-7 of the weight; float32 rounds to about 1e-5."""


def asked_friction(rows: Rows, friction: Array, precision: str) -> tuple[Array, Mask]:
    """Friction that a model needs, infinite where the base would pull, and lanes that have less.

    Args:
        rows: Rows of a `Result` with `needed`, shape [lane].
        friction: Friction of the lanes, shape [lane].
        precision: Of the kernel.
    """
    needed = np.asarray(rows["needed"], dtype=np.float64)
    needed[needed >= NEVER] = np.inf
    return needed, needed > (1.0 + FRICTION_SLACK[precision]) * friction


def rest_start_times(rows: Rows, time: Array | float) -> Array:
    """Start of rest of lanes that have not moved since a time [s]; NaN for all others.

    Args:
        rows: Rows of a `Result` with `moved`, the last time at which the lane moved, shape [lane].
        time: One, or shape [lane].
    """
    moved = np.asarray(rows["moved"], dtype=np.float64)
    return np.where((rows["mode"] < OVERTURNED) & (moved < time), moved, np.nan)


def lane_fields(
    rows: Rows, rest_time: Array, marks: Sequence[tuple[Mask, Status]] = ()
) -> dict[str, Rows]:
    """Lane fields from the results of a kernel, without those that belong to blocks.

    Args:
        rows: Rows of its `Result`, shape [lane].
        rest_time: Start of rest [s], NaN for lanes that do not rest, shape [lane].
        marks: Statuses besides those of modes, and the lanes that have them, shape [lane]; the
            first one counts.
    """
    mode = rows["mode"]
    modes = (
        (BROKEN, Status.NONFINITE),
        (STALLED, Status.EVENT_LIMIT),
        (UNSOLVED, Status.ITERATION_LIMIT),
    )
    found = [*((mode == number, status) for number, status in modes), *marks]
    where, statuses = zip(*found, strict=True)
    deepest = "deepest" in (rows.dtype.names or ())
    return {
        "outcome": np.select(
            [mode == OVERTURNED, mode == SLID_OFF, np.isfinite(rest_time)],
            [Outcome.OVERTURNED, Outcome.SLID_OFF, Outcome.AT_REST],
            Outcome.ROCKING,
        ),
        "status": np.select(where, statuses, Status.OK),
        "impact_count": rows["impacts"],
        "uplift_time": time_or_nan(rows["uplift_time"]),
        "rest_time": rest_time,
        "peak_penetration": rows["deepest"] if deepest else np.zeros(len(rows)),
        "energy_lost": rows["loss"],
        "step_count": rows["steps"],
    }


def collapse_loads(motions: GroundMotions, still: Rows, fell: Mask) -> Array:
    """Acceleration of the base / g when the blocks of assemblies last were still before a collapse.

    In space its level part.

    Args:
        motions: Ground motions of the lanes.
        still: When they last were still [s], shape [lane].
        fell: Which lanes collapsed, shape [lane]; NaN for the others.
    """
    found = np.full(len(fell), np.nan)
    parts = zip(motions.axes, motions.components, strict=True)
    level = [part for axis, part in parts if axis != "z"]
    for lane in np.flatnonzero(fell):
        at = np.array([still[lane]], dtype=np.float64)
        pulls = [float(part.acceleration(at, int(lane))[0]) for part in level]
        found[lane] = math.hypot(*pulls) / GRAVITY
    return found


def planar_fields(per_block: Rows) -> dict[str, Rows]:
    """Fields of blocks in the plane from rows of `BlockResult`, shape [lane, block] each.

    Slides that a kernel does not give are zero: blocks of its scheme do not slide.
    """
    names = {
        "peak_rotation": "peak",
        "peak_time": "peak_time",
        "residual_slide": "slide",
        "peak_slide": "peak_slide",
    }
    told = per_block.dtype.names or ()
    zero = np.zeros(per_block.shape)
    return {field: per_block[name] if name in told else zero for field, name in names.items()}


def side_fields(sides: Array, peak: Array) -> dict[str, Array]:
    """Largest rotations of bodies to either side.

    Args:
        sides: Those to -x and to +x that a kernel saw at the ends of steps [rad], [lane, 2].
        peak: Largest rotation, inside steps, too [rad], shape [lane].
    """
    higher = (sides == sides.max(axis=1, keepdims=True)) & (sides > 0.0)
    return dict(zip(BODY_FIELDS, np.where(higher, peak[:, None], sides).T, strict=True))


def spatial_fields(lanes: Lanes, per_block: Rows) -> dict[str, Array]:
    """Fields of blocks in space from rows of `BlockResult`, shape [lane, block] each."""
    stacks = cast(SpatialLanes, as_stacks(lanes))
    rows = {name: per_block[name].astype(np.float64) for name in per_block.dtype.names or ()}
    below = np.concatenate([np.zeros_like(stacks.yaw_start[:, :1]), stacks.yaw_start[:, :-1]], 1)
    slide = rotate_yaw(np.stack([rows["slide_x"], rows["slide_y"]], axis=-1), below)
    yaw_start = stacks.yaw_start
    if stacks.thrown:
        yaw_start = rotations(start_poses(stacks)[1])[2]
    yaw = 2.0 * np.arctan2(rows["qz"], rows["qw"]) - yaw_start
    return {
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


def histories(
    lanes: Lanes, found: Found, times: SampleTimes, *, above_rigid: bool
) -> dict[str, Array]:
    """The histories asked for, by field, from the results of a kernel.

    Shape [lane, block, sample] each. Rotations are limited to a right angle, as peaks are.

    Args:
        lanes: The lanes.
        found: Results of the kernel.
        times: Duration and sampling.
        above_rigid: Whether its heights are relative to those of a stack of rigid blocks.
    """
    if found.history is None:
        return {}
    if found.places is not None and above_rigid:
        height = as_stacks(lanes).height
        centre = np.cumsum(height, axis=1) - 0.5 * height
        if lanes.body is not None:
            centre = lanes.body.centre_height[:, None]
        if lanes.profiles is not None:
            centre = np.cumsum(height, axis=1) - height + lanes.profiles.centre_height
        found.places[..., -1] += centre[..., None]
    if not lanes.spatial:
        fields = {"rotation": np.clip(found.history, -0.5 * np.pi, 0.5 * np.pi)}
        if times.places:
            fields |= planar_places(lanes, found.history, found.places)
        return fields
    angles = rotations(found.history)
    fields = dict(zip(("rotation", "rotation_across", "yaw"), angles, strict=True))
    if found.places is not None:
        fields |= spatial_places(lanes, found.history, found.places)
    return fields


PLACES = ("x", "y", "z", "turn")
"""Histories that say where a block is."""


def respond(engine: str, lanes: Lanes, columns: Mapping[str, Rows], times: SampleTimes) -> Response:
    """A response from its fields: every lane field must be there, others that an engine has may be.

    A lane of which a number is not finite gets the status NONFINITE if its status would let that
    pass, on any base.

    Args:
        engine: Its name.
        lanes: The lanes; single blocks have no block axis in a response.
        columns: Fields by name, shape [lane], or [lane, block] where they belong to blocks; with
            histories, if asked for.
        times: Duration and sampling.
    """
    more = (*MODEL_FIELDS, *BODY_FIELDS, *TIE_FIELDS, *ASSEMBLY_FIELDS)
    wanted = (*SPATIAL_FIELDS, *more, "joint_state", *HISTORIES)
    names = (*LANE_FIELDS, *(name for name in wanted if name in columns))
    fields: dict[str, Rows] = {}
    for name in names:
        values = np.asarray(columns[name], np.int64 if name in INTEGER_FIELDS else np.float64)
        # Of an assembly places are those of all its blocks, and all else is told of it as a whole.
        placed = name in PLACES or name.startswith("attitude")
        several = lanes.stacked or (lanes.assembly is not None and placed)
        alone = FIELDS[name].per_block and not several
        fields[name] = values[:, 0] if alone else values
    status = fields["status"]
    # A sum is finite if all of its parts are.
    total = sum(
        fields[name].reshape(len(status), -1).sum(axis=1)
        for name in (*FINITE_FIELDS, "rotation")
        if name in fields
    )
    broken = ~np.isfinite(total) & np.isin(status, USABLE)
    fields["status"] = np.where(broken, np.int64(Status.NONFINITE), status)
    if "rotation" not in fields:
        return Response(engine=engine, fields=fields, times=np.empty(0))
    return Response(engine=engine, fields=fields, times=times.times)
