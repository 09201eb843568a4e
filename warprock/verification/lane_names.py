"""Lanes in words: by their labels, and by the inputs that tell them from the others."""

from __future__ import annotations

import re

import numpy as np

from warprock.case.lanes import LaneSet

_BLOCK_COLUMN = re.compile(
    r"((?:width|height|depth|density|chamfer|offset|friction|rotation_start)_[1-9])(?:_(\w+))?"
)
"""Input columns of one block of a stack: their stem, and the unit behind it."""

_NAMING_COLUMNS = {
    "frequency_hz": "Hz",
    "amplitude_mm": "mm",
    "amplitude_m_s": "m/s",
    "amplitude_m_s2": "m/s^2",
    "record": "",
    "scale": "x",
    "rotation_ratio_start": "of slenderness",
    "rotation_across_start_rad": "rad across",
    "yaw_start_rad": "rad of yaw",
    "amplitude_mm_y": "mm across",
    "amplitude_mm_z": "mm upwards",
}
"""Input columns that name a lane when they vary, and their units."""


def lane_name(lane_set: LaneSet, lane: int) -> str:
    """A lane in words: its labels and what distinguishes it from the others."""
    inputs = lane_set.inputs
    parts = []
    for name in inputs.columns:
        value = inputs[name].iloc[lane]
        if name in lane_set.labels:
            parts.append(str(value))
        elif inputs[name].nunique(dropna=False) > 1:
            block = _BLOCK_COLUMN.fullmatch(name)
            if block:
                parts.append(f"{block[1].replace('_', ' ')} {value:g} {block[2] or ''}".strip())
            elif name in _NAMING_COLUMNS:
                unit = _NAMING_COLUMNS[name]
                number = isinstance(value, (int, float, np.number))
                parts.append(f"{value:g} {unit}".strip() if number else str(value))
    return " ".join(parts) or f"lane {lane}"
