"""Values of a case lane by lane, and the refusal of a lane whose values do not fit together."""

from __future__ import annotations

import functools
from typing import Any

import numpy as np
import numpy.typing as npt

from warprock.case.axes import LABEL, Column, Numbers, Texts, lane_indices
from warprock.case.block import ROUND_DEPTH
from warprock.case.case import Case
from warprock.case.keys import KEYS, general_key
from warprock.case.sampling import Distribution
from warprock.errors import InputError, Said
from warprock.quantity import NumberKey
from warprock.units import Dimension, Quantity, format_quantity, unit_written

Array = npt.NDArray[np.float64]


class LaneValues:
    """Values of case keys lane by lane: along an axis where a key is swept, else one for all."""

    def __init__(self, case: Case, lanes: range, *, spread: bool = True) -> None:
        """Finds where each lane lies on each axis, and which member of its cell it is.

        Args:
            case: The case.
            lanes: Numbers of the lanes wanted.
            spread: Whether the members of an ensemble differ; the values are the cell's own
                otherwise.
        """
        self.case, self.lanes = case, lanes
        *positions, self.members = lane_indices((*case.shape, case.members), lanes)
        self._spread = case.ensemble if spread else None
        self._swept: dict[str, tuple[Column, npt.NDArray[Any]]] = {
            key: (axis.columns[key], place)
            for axis, position in zip(case.axes, positions, strict=True)
            for key, place in axis.places(position).items()
        }
        self._rows = {
            key: (axis.source.file, position)
            for axis, position in zip(case.axes, positions, strict=True)
            if axis.source is not None
            for key in axis.columns
        }

    def given(self, key: str) -> bool:
        """Whether the case gives a key, swept or not."""
        return key in self._swept or self.case.tables.constant(key) is not None

    def swept(self, key: str) -> bool:
        """Whether a key lies on an axis of the case."""
        return key in self._swept

    def numbers(self, key: str) -> Array:
        """Values of a numeric key, SI units or rad, shape [lane].

        Of a block with a round base they are those of the box that is run in its place.
        """
        table, _, name = key.rpartition(".")
        if name in ("width", "depth") and self.given(f"{table}.diameter"):
            return (ROUND_DEPTH if name == "depth" else 1.0) * self.numbers(f"{table}.diameter")
        values = self._own_numbers(key)
        if self._spread is not None and key in self._spread.spread:
            return self._spread.moved(key, values, self._points)
        return values

    @functools.cached_property
    def _points(self) -> Array:
        """Where the lanes' members of an ensemble lie."""
        assert self._spread is not None
        return self._spread.points(self.members)

    def _own_numbers(self, key: str) -> Array:
        """Values that the lanes' cells have."""
        if key in self._swept:
            column, position = self._swept[key]
            if isinstance(column, Distribution):
                return column.quantile(position)
            assert isinstance(column, Numbers)
            return np.asarray(column.values[position])
        constant = self.case.tables.constant(key)
        if isinstance(constant, Quantity):
            constant = constant.value
        assert isinstance(constant, float), key
        return np.full(len(self.lanes), constant)

    def dimension(self, key: str) -> Dimension:
        """What the values of a numeric key measure, the same in all lanes."""
        if key in self._swept:
            column = self._swept[key][0]
            assert not isinstance(column, Texts)
            return column.dimension
        constant = self.case.tables.constant(key)
        assert isinstance(constant, Quantity), key
        return constant.dimension

    def texts(self, key: str) -> tuple[tuple[str, ...], npt.NDArray[np.int32]]:
        """Distinct texts of a key, and the index of each lane's among them, shape [lane]."""
        if key in self._swept:
            column, position = self._swept[key]
            assert isinstance(column, Texts)
            return column.values, column.codes[position]
        return (str(self.case.tables.constant(key)),), np.zeros(len(self.lanes), np.int32)

    def column(self, key: str) -> Texts:
        """Texts of a key as a column, shape [lane]."""
        return Texts(*self.texts(key))

    def labels(self) -> dict[str, object]:
        """Label columns by their names, shape [lane]."""
        return {label: self._label(LABEL + label) for label in self.case.labels}

    def _label(self, key: str) -> object:
        """A label's texts, or the numbers that were observed."""
        column, position = self._swept[key]
        return column.values[position] if isinstance(column, Numbers) else self.column(key)

    def refuse(self, bad: npt.NDArray[np.bool_], key: str, allowed: str) -> None:
        """Refuses the first lane in which something is wrong.

        Args:
            bad: Whether a lane is wrong, shape [lane].
            key: The key to blame.
            allowed: What the key must be.

        Raises:
            InputError: A lane is wrong.
        """
        if bad.any():
            at = int(np.argmax(bad))
            said, source = self._write_value(key, at), self.case.source_of(key)
            if key in self._rows:
                source, rows = self._rows[key]
                key = f"{key}, row {rows[at] + 1}"
            raise InputError(source, key, said, f"{allowed} (lane {self.lanes[at]})")

    def _write_value(self, key: str, at: int) -> Said:
        """One lane's value of a key, as a user would write it."""
        reader = KEYS[general_key(key)]
        if not isinstance(reader, NumberKey):
            values, codes = self.texts(key)
            return Said(values[int(codes[at])])
        dimensions = list(reader.bounds)
        dimension = self.dimension(key) if len(dimensions) > 1 else dimensions[0]
        unit = "deg" if dimension is Dimension.ANGLE else None
        if dimension is Dimension.FREQUENCY:
            # Angular velocities have this dimension, too.
            unit = unit_written(reader.bounds[dimension][0])
        return Said(format_quantity(float(self.numbers(key)[at]), dimension, unit))
