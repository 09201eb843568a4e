"""The lane table: one row a lane, its inputs and what became of it, with units and meanings."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from warprock.arguments import at_the_door
from warprock.case.assembly import BETWEEN
from warprock.case.axes import Texts
from warprock.case.columns import Columns, Meanings
from warprock.case.input_columns import input_meaning
from warprock.case.lanes import LaneSet
from warprock.model.base_path import base_places
from warprock.model.lanes import Lanes
from warprock.model.ratios import peak_ratio
from warprock.model.response import (
    ASSEMBLY_FIELDS,
    BODY_FIELDS,
    ESTIMATE_FIELDS,
    FIELDS,
    HISTORIES,
    LANE_FIELDS,
    MODEL_FIELDS,
    SPATIAL_FIELDS,
    TIE_FIELDS,
    Field,
    JointState,
    Response,
)
from warprock.model.tie_states import tie_elongations, tie_history
from warprock.model.undecided import UNDECIDED, UNDECIDED_TEXT, undecided
from warprock.settings.engines import on_springs

if TYPE_CHECKING:
    import pandas as pd
    import pyarrow as pa

LANE_TABLE = "lanes.parquet"
"""Name of the file that a run, and a sweep that was merged, keep it in."""

_ROUND_OFF = 1e-12
"""How far the last sample may lie after the end of a run, as a part of its length."""

PEAK_RATIO = "peak_rotation_ratio"

JOINT_COLUMNS = {
    "opened_between": "Blocks between which joints opened",
    "slid_between": "Blocks between which joints slid",
    "broken_between": "Blocks between which bonded joints broke",
}
"""Columns of words of an assembly, and what they say."""
APART = ", "
"""What stands between joints."""


@at_the_door
def lane_table(lane_set: LaneSet, response: Response) -> pd.DataFrame:
    """The table of a run, one row a lane: inputs, dimensionless groups and response.

    Units are in the column names; `DataFrame.attrs["columns"]` holds the unit and the meaning
    of every column that has them. Outcome and status are words.

    Args:
        lane_set: Lanes, motions and inputs.
        response: The engine's answer for the same lanes.

    Example:
        >>> import warprock as wr
        >>> run = wr.run_case(wr.load_case("free-b0"), "housner")
        >>> table = wr.lane_table(run.lane_set, run.response)
        >>> table.attrs["columns"]["peak_rotation_rad"]["unit"]
        'rad'
    """
    return run_columns(lane_set, response).frame


def run_columns(lane_set: LaneSet, response: Response) -> Columns:
    """The table of a run as columns of NumPy, which need no pandas; see `lane_table`.

    Args:
        lane_set: Lanes, motions and inputs.
        response: The engine's answer for the same lanes.
    """
    columns: dict[str, Any] = {"lane": lane_set.first + np.arange(response.lane_count)}
    columns |= lane_set.table.columns
    meaning = {name: input_meaning(name) for name in columns}
    more = (*MODEL_FIELDS, *BODY_FIELDS, *TIE_FIELDS, *ASSEMBLY_FIELDS)
    optional = (*SPATIAL_FIELDS, *more, *ESTIMATE_FIELDS)
    besides = [name for name in optional if name in response.fields]
    for field in (FIELDS[name] for name in (*LANE_FIELDS, *besides)):
        values = response[field.name]
        of_field: dict[str, Any] = {field.column: values}
        if field.enum is not None:
            of_field = {field.column: Texts(tuple(words_of(field)), values)}
        if values.ndim == 2:
            of_field = {field.block_column(k): v for k, v in enumerate(values.T, 1)}
        columns |= of_field
        meaning |= dict.fromkeys(of_field, (field.unit, field.text))
    if "joint_state" in response.fields:
        words = joint_columns(lane_set.lanes, response["joint_state"])
        columns |= words
        meaning |= {name: ("-", JOINT_COLUMNS[name]) for name in words}
    given = response, lane_set.lanes, lane_set.motions, lane_set.ends
    columns[UNDECIDED] = undecided(*given, springs=on_springs(response.engine))
    meaning[UNDECIDED] = ("-", UNDECIDED_TEXT)
    ratio = peak_ratio(response, lane_set.lanes)
    ratios = dict(zip(peak_ratio_columns(lane_set), np.atleast_2d(ratio.T), strict=True))
    columns |= ratios
    meaning |= dict.fromkeys(ratios, ("-", "Largest rotation / slenderness angle"))
    return _declared(columns, meaning)


def _declared(columns: Mapping[str, Any], meaning: Mapping[str, tuple[str, str]]) -> Columns:
    """Columns with their units and meanings, by name."""
    said = {name: {"unit": unit, "text": text} for name, (unit, text) in meaning.items()}
    return Columns(columns, {"columns": Meanings(said)})


def joint_columns(lanes: Lanes, state: npt.NDArray[np.int64]) -> dict[str, list[str]]:
    """Names of the blocks between which joints opened, slid, and broke, of every lane.

    Dry joints do not break: of them there is no such column.

    Args:
        lanes: Assemblies.
        state: What their joints did, shape [lane, joint].
    """
    assert lanes.assembly is not None
    found: dict[str, list[str]] = {}
    for name, flag in zip(JOINT_COLUMNS, JointState, strict=True):
        if flag is JointState.BROKEN and not lanes.assembly.bonded:
            continue
        found[name] = []
        for lane, row in enumerate((state & flag) > 0):
            kind = lanes.assembly.of(lane)
            pairs = kind.joints.blocks[np.flatnonzero(row[: kind.joints.count])]
            words = [f"{kind.names[a]}{BETWEEN}{kind.names[b]}" for a, b in pairs]
            found[name].append(APART.join(words))
    return found


def peak_ratio_columns(lane_set: LaneSet) -> list[str]:
    """Columns of the peak rotation / slenderness angle, one for each block of a stack."""
    lanes = lane_set.lanes
    if not lanes.stacked:
        return [PEAK_RATIO]
    return [f"{PEAK_RATIO}_{block}" for block in range(1, lanes.block_count + 1)]


def arrow_table(table: pd.DataFrame) -> pa.Table:
    """An Arrow table whose fields carry the unit and the meaning of their columns.

    `DataFrame.attrs["footer"]`, where it is there, becomes the footer of the file that holds it.
    """
    import pyarrow as pa

    from warprock.running.parts import FOOTER

    bare = table.copy(deep=False)
    meaning, footer = (bare.attrs.pop(name, {}) for name in ("columns", "footer"))
    arrow = pa.Table.from_pandas(bare, preserve_index=False)
    fields = [
        field.with_metadata(meaning[field.name]) if field.name in meaning else field
        for field in arrow.schema
    ]
    metadata = dict(arrow.schema.metadata or {})
    if footer:
        metadata[FOOTER] = json.dumps(footer).encode()
    return arrow.cast(pa.schema(fields, metadata=metadata))


def history_table(response: Response, row: int, lane_set: LaneSet, lane: int) -> pd.DataFrame:
    """Sampled histories of one lane, one row a sample: how and where its blocks and its base are.

    Places are in the frame of the ground. x, y and z of a block are those of the middle of its box;
    the origin is where the middle of the lowest bottom face stood. The base starts at zero. Units
    are in the column names; `DataFrame.attrs["columns"]` holds the unit and the meaning of each.

    Args:
        response: A response with histories.
        row: Row of the lane in it.
        lane_set: Lanes of the case, and their motions.
        lane: Number of the lane among them.
    """
    end = np.broadcast_to(lane_set.ends, lane_set.lanes.lane_count)[lane]
    times = response.times[response.times <= end * (1.0 + _ROUND_OFF)]
    columns: dict[str, Any] = {"time_s": times}
    meaning = {"time_s": ("s", "Time")}
    for field in (FIELDS[name] for name in HISTORIES if name in response.fields):
        values = response[field.name][row][..., : len(times)]
        of_field = {field.column: values}
        if values.ndim == 2:
            of_field = {field.block_column(k): v for k, v in enumerate(values, 1)}
        columns |= of_field
        meaning |= dict.fromkeys(of_field, (field.unit, field.text))
    places = base_places(lane_set.motions, lane, times)
    for axis, name in enumerate("xyz"):
        for column in (c for c in columns if c == f"{name}_m" or c.startswith(f"{name}_")):
            columns[column] = columns[column] + places[:, axis]
            meaning[column] = ("m", f"Centre of the block along {name}, seen from the ground")
    motions = lane_set.motions
    for name, motion in zip(motions.axes, motions.components, strict=True):
        # Most scenes have one direction, whose acceleration needs no name.
        pulled = "base_acceleration" + ("" if name == "x" else f"_{name}") + "_m_s2"
        columns |= {
            f"base_{name}_m": places[:, "xyz".index(name)],
            pulled: motion.acceleration(times, lane),
        }
        meaning[f"base_{name}_m"] = ("m", f"Displacement of the base along {name}")
        meaning[pulled] = (
            "m/s^2",
            f"Acceleration of the base along {name}, without the steps of its velocity",
        )
    if lane_set.ground is not None:
        below = base_places(lane_set.ground, lane, times)
        parts = zip(lane_set.ground.axes, lane_set.ground.components, strict=True)
        for name, motion in parts:
            pulled = "ground_acceleration" + ("" if name == "x" else f"_{name}") + "_m_s2"
            columns |= {
                f"ground_{name}_m": below[:, "xyz".index(name)],
                pulled: motion.acceleration(times, lane),
            }
            meaning[f"ground_{name}_m"] = (
                "m",
                f"Displacement of the ground below the support along {name}",
            )
            meaning[pulled] = ("m/s^2", f"Acceleration of the ground along {name}")
    for number, (elongation, force) in enumerate(_ties_over_time(response, row, lane_set, lane), 1):
        columns |= {
            f"tie_elongation_{number}_m": elongation[: len(times)],
            f"tie_force_{number}_N": force[: len(times)],
        }
        meaning[f"tie_elongation_{number}_m"] = (
            "m",
            "Elongation of the tie from the state in which the block rests",
        )
        meaning[f"tie_force_{number}_N"] = ("N", "Force of the tie, tension positive")
    return _declared(columns, meaning).frame


def lane_pose(response: Response, row: int) -> npt.NDArray[np.float64]:
    """Place of the middle of a single block beside its base along x and z [m], and its rotation.

    Args:
        response: A response with histories of places.
        row: Row of the lane in it.

    Returns:
        Shape [3, sample].
    """
    return np.stack([response[name][row].reshape(-1) for name in ("x", "z", "rotation")])


def first_break(response: Response, row: int) -> float:
    """When the first tie of a lane broke [s]; NaN if none did."""
    if "tie_break_time" not in response.fields:
        return math.nan
    return float(response["tie_break_time"][row])


def _ties_over_time(
    response: Response, row: int, lane_set: LaneSet, lane: int
) -> Iterator[tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]]:
    """Elongation [m] and force [N] of each tie of a lane, shape [sample]."""
    lanes = lane_set.lanes
    if lanes.hold is None or lanes.hold.ties is None or "x" not in response.fields:
        return
    ties = lanes.hold.take(np.array([lane])).ties
    assert ties is not None
    size = float(lanes.width[lane]), float(lanes.height[lane])
    elongation = tie_elongations(ties, *size, lane_pose(response, row))
    done = tie_history(ties, elongation, response.times, first_break(response, row))
    yield from zip(elongation, done.force, strict=True)


def words_of(field: Field) -> list[str]:
    """The words of a field that holds codes, which count from 0."""
    assert field.enum is not None
    return [code.name.lower() for code in sorted(field.enum)]
