"""Intensity measures as a reader knows them: a name, and the unit that engineers say them in."""

from __future__ import annotations

import dataclasses

import numpy as np

from warprock.case.input_columns import input_meaning
from warprock.findings.digits import MEASURED
from warprock.units import GRAVITY, split_unit

_READABLE = {"m/s^2": ("g", 1.0 / GRAVITY), "rad": ("deg", 180.0 / np.pi), "m/s": ("cm/s", 100.0)}
"""Unit of a column -> unit of a figure, and how many of them it is."""
_NAMES = {
    "factor": "factor on the motion",
    "peak_acceleration_m_s2": "peak base acceleration",
    "peak_velocity_m_s": "peak base velocity",
    "normalised_acceleration": "peak base acceleration / (g tan(slenderness angle))",
    "normalised_velocity": "p x peak base velocity / (g tan(slenderness angle))",
    "scale": "factor on the record",
    "velocity_acceleration_ratio_s": "peak velocity / peak acceleration",
}
"""Columns whose meaning is too long, or no name."""


@dataclasses.dataclass(frozen=True)
class Measure:
    """A column as a figure shows it.

    Attributes:
        name: What it is.
        unit: Its unit in the figure; "-" without.
        size: Values of the figure over values of the column.
    """

    name: str
    unit: str
    size: float

    @property
    def label(self) -> str:
        """Label of its axis."""
        return f"{self.name} [{self.unit}]"

    def text(self, value: float) -> str:
        """A value of the column with three digits and its unit."""
        text = format(value * self.size, MEASURED.form)
        return text if self.unit == "-" else f"{text} {self.unit}"


def measure(column: str) -> Measure:
    """How a figure shows an input column of the lane table: accelerations in g, angles in deg."""
    unit, text = input_meaning(column)
    unknown = text == input_meaning("")[1]
    name = _NAMES.get(column, column if unknown else text[:1].lower() + text[1:].split(",")[0])
    unit = unit or split_unit(column)[1]
    unit, size = _READABLE.get(unit, (unit, 1.0))
    return Measure(name, unit or "-", size)
