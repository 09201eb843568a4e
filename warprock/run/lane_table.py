"""The lane table: one row a lane, its inputs and what became of it, with units and meanings."""

from __future__ import annotations

import json
import re
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa

from warprock.case.lanes import LaneSet
from warprock.model.response import (
    ESTIMATE_FIELDS,
    FIELDS,
    LANE_FIELDS,
    MODEL_FIELDS,
    SPATIAL_FIELDS,
    Field,
    Response,
)
from warprock.model.undecided import UNDECIDED, UNDECIDED_TEXT, undecided
from warprock.run.parts import FOOTER

LANE_TABLE = "lanes.parquet"
"""Name of the file that a run, and a sweep that was merged, keep it in."""

INPUTS: dict[str, tuple[str, str]] = {
    "lane": ("-", "Number of the lane"),
    "width_m": ("m", "Full width in the plane of rocking"),
    "height_m": ("m", "Full height"),
    "depth_m": ("m", "Full depth across the plane of rocking"),
    "density_kg_m3": ("kg/m^3", "Density"),
    "friction": ("-", "Coulomb friction coefficient"),
    "angular_restitution": ("-", "Angular velocity after / before an impact"),
    "slenderness_angle_rad": (
        "rad",
        "Slenderness (critical) angle; of an eccentric block that of its weaker side",
    ),
    "slenderness_angle_across_rad": ("rad", "The same about the edges at the ends of its depth"),
    "half_diagonal_m": ("m", "Half diagonal"),
    "frequency_parameter_rad_s": ("rad/s", "Frequency parameter"),
    "rotation_start_rad": ("rad", "Rotation at the start"),
    "rotation_ratio_start": ("-", "Rotation at the start / slenderness angle"),
    "waveform": ("-", "Shape of the controlled quantity in time"),
    "control": ("-", "Quantity of the base that follows the waveform"),
    "frequency_hz": ("Hz", "Frequency of the motion"),
    "amplitude_mm": ("mm", "Amplitude, as a displacement"),
    "amplitude_m_s": ("m/s", "Amplitude, as a velocity"),
    "amplitude_m_s2": ("m/s^2", "Amplitude, as an acceleration"),
    "record": ("-", "Name of the record"),
    "record_source": ("-", "Where the record is from"),
    "record_licence": ("-", "Licence of the record"),
    "record_sha256": ("-", "SHA-256 of the record's file"),
    "record_processing": ("-", "What was done to the record before the run"),
    "scale": ("-", "Factor on the record"),
    "start_s": ("s", "Time at which the motion starts"),
    "cycles": ("-", "Periods of its frequency in a pulse"),
    "phase_rad": ("rad", "Phase of a pulse in its middle"),
    "stop_s": ("s", "Time at which the motion stops"),
    "peak_acceleration_m_s2": ("m/s^2", "Largest acceleration of the base, velocity steps apart"),
    "yaw_start_rad": ("rad", "Turn about the vertical at the start"),
    "rotation_across_start_rad": ("rad", "Rotation across the plane of rocking at the start"),
    "gap_start_mm": ("mm", "Height of the lowest corner above the base at the start"),
    "centre_offset_x_mm": ("mm", "Centre of mass from the middle, along the width"),
    "centre_offset_y_mm": ("mm", "Centre of mass from the middle, along the depth"),
    "member": ("-", "Number of the member in its cell"),
    "time_step_factor": ("-", "Factor on the engine's time step"),
    "peak_velocity_m_s": ("m/s", "Largest velocity of the base, PGV"),
    "normalised_velocity": ("-", "Frequency parameter x PGV / (g tan(slenderness angle))"),
    "normalised_acceleration": (
        "-",
        "Largest acceleration / that which lifts the block to its weaker side, g tan(slenderness "
        "angle); in space with its yaw",
    ),
}
"""Unit and meaning of the columns that a lane's inputs may have; any other is a label."""

STACK_INPUTS: dict[str, tuple[str, str]] = {
    "chamfer_mm": ("mm", "Width cut off each edge"),
    "offset_mm": ("mm", "Centre to +x of the centre of the block below"),
    "offset_across_mm": ("mm", "Middle to +y of the middle of the block below"),
    "uplift_ratio": ("-", "Base acceleration / g at which a part of the stack begins to rock"),
}
"""The same for what only stacks have; of a block, without its number."""

_DIRECTIONS = {"_y": "across the plane of rocking", "_z": "upwards"}
"""End of an input column of a motion besides that in the plane -> direction."""

_BLOCK_NUMBER = re.compile(r"_([1-9])(?=_|$)")

PEAK_RATIO = "peak_rotation_ratio"


def lane_table(lane_set: LaneSet, response: Response) -> pd.DataFrame:
    """The table of a run, one row a lane: inputs, dimensionless groups and response.

    Units are in the column names; `DataFrame.attrs["columns"]` holds the unit and the meaning
    of every column that has them. Outcome and status are words.

    Args:
        lane_set: Lanes, motions and inputs.
        response: The engine's answer for the same lanes.
    """
    columns: dict[str, Any] = {"lane": lane_set.first + np.arange(response.lane_count)}
    columns |= {str(name): lane_set.inputs[name].array for name in lane_set.inputs.columns}
    meaning = {name: input_meaning(name) for name in columns}
    optional = (*SPATIAL_FIELDS, *MODEL_FIELDS, *ESTIMATE_FIELDS)
    besides = [name for name in optional if name in response.fields]
    for field in (FIELDS[name] for name in (*LANE_FIELDS, *besides)):
        values = response[field.name]
        of_field: dict[str, Any] = {field.column: values}
        if field.enum is not None:
            of_field = {field.column: pd.Categorical.from_codes(values, pd.Index(words_of(field)))}
        if values.ndim == 2:
            of_field = {field.block_column(k): v for k, v in enumerate(values.T, 1)}
        columns |= of_field
        meaning |= dict.fromkeys(of_field, (field.unit, field.text))
    columns[UNDECIDED] = undecided(
        response, lane_set.lanes, lane_set.motions, lane_set.times.duration
    )
    meaning[UNDECIDED] = ("-", UNDECIDED_TEXT)
    ratio = response["peak_rotation"] / lane_set.lanes.slenderness_angle
    ratios = dict(zip(peak_ratio_columns(lane_set), np.atleast_2d(ratio.T), strict=True))
    columns |= ratios
    meaning |= dict.fromkeys(ratios, ("-", "Largest rotation / slenderness angle"))
    table = pd.DataFrame(columns)
    table.attrs["columns"] = {
        name: {"unit": unit, "text": text} for name, (unit, text) in meaning.items()
    }
    return table


def input_meaning(column: str) -> tuple[str, str]:
    """Unit and meaning of an input column; a block's number in its name does not matter."""
    known = INPUTS | STACK_INPUTS
    if column in known:
        return known[column]
    direction = _DIRECTIONS.get(column[-2:])
    if direction is not None and column[:-2] in known:
        unit, text = known[column[:-2]]
        return unit, f"{text}, of the motion {direction}"
    number = _BLOCK_NUMBER.search(column)
    general = _BLOCK_NUMBER.sub("", column, count=1)
    if number is None or general not in known:
        return "-", "Label of the case"
    unit, text = known[general]
    return unit, f"{text}, block {number[1]}"


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
    bare = table.copy()
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


def history_table(response: Response, row: int) -> pd.DataFrame:
    """Sampled histories of one lane of a response, one row a sample."""
    columns: dict[str, Any] = {"time_s": response.times}
    for field in (FIELDS[name] for name in response.fields):
        if field.dims == ("lane", "sample"):
            values = response[field.name][row]
            of_field = {field.column: values}
            if values.ndim == 2:
                of_field = {field.block_column(k): v for k, v in enumerate(values, 1)}
            columns |= of_field
    return pd.DataFrame(columns)


def words_of(field: Field) -> list[str]:
    """The words of a field that holds codes, which count from 0."""
    assert field.enum is not None
    return [code.name.lower() for code in sorted(field.enum)]
