"""Where blocks were seen, and how far from it an engine has them: by lane, over time, at the end.

An observed file is a CSV table with one row a sample: a column for each label that tells the lane,
`time_s`, the centre `x_m`, `y_m`, `z_m` from below where it was at the start, and the quaternion
`attitude_x`, `attitude_y`, `attitude_z`, `attitude_w`. Times of a lane rise; its last row is the
end, at which the block may have come to rest or not.
"""

from __future__ import annotations

import dataclasses
import io
import pathlib

import numpy as np
import numpy.typing as npt
import pandas as pd

from warprock.case.case import Case
from warprock.case.lanes import LaneSet
from warprock.case.text import data_folder
from warprock.errors import NOTHING, InputError, Said
from warprock.model.response import Response
from warprock.reading import read_bytes, reason

Array = npt.NDArray[np.float64]

PLACE = ("x", "y", "z")
ATTITUDE = tuple(f"attitude_{part}" for part in "xyzw")
NUMBERS = ("time_s", *(f"{axis}_m" for axis in PLACE), *ATTITUDE)
"""Columns of an observed file besides its labels."""
UNIT = 1e-2
"""By how much the length of a quaternion may differ from 1: two digits of each part."""


@dataclasses.dataclass(frozen=True)
class ObservedPoses:
    """Where the block of one lane was seen.

    Attributes:
        lane: Number of the lane.
        times: [s], shape [sample].
        position: Its centre [m], shape [sample, 3].
        attitude: Quaternions (x, y, z, w), shape [sample, 4].
    """

    lane: int
    times: Array
    position: Array
    attitude: Array


def read_poses(case: Case, lane_set: LaneSet, file: str) -> list[ObservedPoses]:
    """The observed poses of the lanes of a case.

    Args:
        case: The case.
        lane_set: Its lanes, of single blocks in space.
        file: Path of the file; a relative one starts from the folder of the case.

    Returns:
        Of every lane that the file has, in the order of the lanes.

    Raises:
        InputError: The file cannot be read, lacks a column, names no lane, or has a sample that is
            no pose or is not in time.
    """
    path = (data_folder(case.name, case.folder) or pathlib.Path()) / file
    try:
        table = pd.read_csv(io.BytesIO(read_bytes(path)))
    except OSError as error:
        allowed = f"must be a file to read ({reason(error)})"
        raise InputError(str(path), "file", file, allowed) from None
    except (ValueError, UnicodeDecodeError) as error:
        allowed = f"must be a CSV table: {str(error).splitlines()[0]}"
        raise InputError(str(path), "", Said("the text"), allowed) from None
    labels = [name for name in lane_set.labels if name in table.columns]
    _require_table(table, labels, lane_set, str(path))
    found = []
    seen = table.groupby([table[name].astype(str) for name in labels], sort=False)
    names: dict[tuple[str, ...], pd.DataFrame] = {
        tuple(map(str, key)) if isinstance(key, tuple) else (str(key),): rows for key, rows in seen
    }
    for lane, row in enumerate(lane_set.inputs[labels].astype(str).itertuples(index=False)):
        rows = names.pop(tuple(row), None)
        if rows is not None:
            found.append(_poses(lane, rows, lane_set, str(path)))
    if names:
        allowed = f"must be labels of a lane of {case.name}"
        raise InputError(str(path), labels[0], ", ".join(next(iter(names))), allowed)
    return found


def _require_table(table: pd.DataFrame, labels: list[str], lane_set: LaneSet, source: str) -> None:
    if not labels:
        known = ", ".join(lane_set.labels) or "the case has none"
        allowed = f"must have a column for a label of the case ({known})"
        raise InputError(source, "", Said("the table"), allowed)
    for name in NUMBERS:
        if name not in table.columns:
            raise InputError(source, name, NOTHING, "must be a column of the table")
        values = pd.to_numeric(table[name], errors="coerce").to_numpy(dtype=float)
        bad = np.flatnonzero(~np.isfinite(values))
        if len(bad):
            got = str(table[name].iloc[bad[0]])
            raise InputError(source, f"{name}, row {bad[0] + 1}", got, "must be a number")


def _poses(lane: int, rows: pd.DataFrame, lane_set: LaneSet, source: str) -> ObservedPoses:
    """The samples of one lane."""
    times = rows["time_s"].to_numpy(dtype=float)
    end = lane_set.times.duration
    first = int(rows.index[0]) + 1
    if np.any(np.diff(times) <= 0.0) or times[0] < 0.0 or times[-1] > end:
        allowed = f"must rise from 0 s to at most the end of the run, {end:g} s, in every lane"
        raise InputError(source, f"time_s, rows from {first}", f"{times[-1]:g}", allowed)
    attitude = rows[list(ATTITUDE)].to_numpy(dtype=float)
    length = np.linalg.norm(attitude, axis=1)
    off = np.flatnonzero(np.abs(length - 1.0) > UNIT)
    if len(off):
        at = f"attitude, row {int(rows.index[off[0]]) + 1}"
        raise InputError(source, at, f"{length[off[0]]:.4g}", "must be a quaternion of length 1")
    position = rows[[f"{axis}_m" for axis in PLACE]].to_numpy(dtype=float)
    return ObservedPoses(lane, times, position, attitude / length[:, None])


def interpolate(
    times: Array, sampled: Array, position: Array, attitude: Array
) -> tuple[Array, Array]:
    """Poses at times between samples, along straight lines and the shortest turns.

    Args:
        times: [s], shape [time].
        sampled: Times of the samples [s], shape [sample].
        position: [m], shape [sample, 3].
        attitude: Quaternions, shape [sample, 4].

    Returns:
        Positions [m], shape [time, 3], and quaternions, shape [time, 4].
    """
    # q and -q are one attitude: each sample takes the sign of the one before it.
    turns = np.sum(attitude[1:] * attitude[:-1], axis=1)
    signs = np.cumprod(np.concatenate([[1.0], np.where(turns < 0.0, -1.0, 1.0)]))
    place, turn = (
        np.stack([np.interp(times, sampled, part) for part in parts.T], axis=-1)
        for parts in (position, attitude * signs[:, None])
    )
    return place, turn / np.linalg.norm(turn, axis=1, keepdims=True)


def poses_at(response: Response, lane: int, times: Array) -> tuple[Array, Array]:
    """Where a response has the block of a lane at some times.

    Args:
        response: With histories of places.
        lane: Number of the lane.
        times: [s], shape [time].

    Returns:
        Centres [m], shape [time, 3], and quaternions, shape [time, 4].
    """
    position = np.stack([response[name][lane] for name in PLACE], axis=-1)
    attitude = np.stack([response[name][lane] for name in ATTITUDE], axis=-1)
    return interpolate(times, response.times, position, attitude)


def rotation_between(first: Array, second: Array) -> Array:
    """Angle of the turn from one attitude to another [rad], 0 to pi, of quaternions [..., 4]."""
    cosine = np.abs(np.sum(first * second, axis=-1))
    # Of half of the angle; the sine is exact where the cosine is next to 1.
    apart, along = (np.linalg.norm(q, axis=-1) for q in (first - second, first + second))
    sine = 0.5 * apart * along
    return np.asarray(2.0 * np.arctan2(sine, cosine))


def compare_poses(
    lane_set: LaneSet, response: Response, observed: list[ObservedPoses]
) -> pd.DataFrame:
    """How far a response is from what was seen: a row an observed lane.

    Args:
        lane_set: The lanes.
        response: With histories of places.
        observed: The observed poses.

    Returns:
        The lanes' labels, then `lane_number`, `engine`, `position_error_mm` and
        `rotation_error_deg`, means over the observed samples; `position_error_at_end_mm` and
        `rotation_error_at_end_deg` at the last of them; `same_face`, whether the face that was
        seen at the top in the end is at the top.
    """
    rows = []
    for seen in observed:
        place, attitude = poses_at(response, seen.lane, seen.times)
        apart = 1e3 * np.linalg.norm(place - seen.position, axis=1)
        turned = np.rad2deg(rotation_between(attitude, seen.attitude))
        rows.append(
            {name: lane_set.inputs[name].iloc[seen.lane] for name in lane_set.labels}
            | {
                "lane_number": seen.lane,
                "engine": response.engine,
                "position_error_mm": float(apart.mean()),
                "rotation_error_deg": float(turned.mean()),
                "position_error_at_end_mm": float(apart[-1]),
                "rotation_error_at_end_deg": float(turned[-1]),
                "same_face": bool(face_up(attitude[-1]) == face_up(seen.attitude[-1])),
            }
        )
    return pd.DataFrame(rows)


def face_up(attitude: Array) -> int:
    """Number of the body axis that points upwards most, 0 to 2, or 3 to 5 if it points down."""
    x, y, z, w = attitude
    upwards = np.array([2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x**2 + y**2)])
    axis = int(np.argmax(np.abs(upwards)))
    return axis if upwards[axis] > 0.0 else axis + 3


TIMES = 50
"""Times at which errors are told over the longest observed lane."""


def histories_of_errors(
    response: Response, observed: list[ObservedPoses]
) -> dict[str, list[float]]:
    """Errors over time, means over the lanes that are still seen.

    Args:
        response: With histories of places.
        observed: The observed poses.

    Returns:
        `time_s`, `lanes` (how many are still seen), `position_error_mm`, `rotation_error_deg`.
    """
    times = np.linspace(0.0, max(seen.times[-1] for seen in observed), TIMES)
    apart, turned = np.full((2, len(observed), len(times)), np.nan)
    for number, seen in enumerate(observed):
        inside = times <= seen.times[-1]
        place, attitude = poses_at(response, seen.lane, times[inside])
        there, turn = interpolate(times[inside], seen.times, seen.position, seen.attitude)
        apart[number, inside] = np.linalg.norm(place - there, axis=1)
        turned[number, inside] = rotation_between(attitude, turn)
    return {
        "time_s": times.tolist(),
        "lanes": np.isfinite(apart).sum(axis=0).tolist(),
        "position_error_mm": (1e3 * np.nanmean(apart, axis=0)).tolist(),
        "rotation_error_deg": np.rad2deg(np.nanmean(turned, axis=0)).tolist(),
    }
