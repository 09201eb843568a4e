"""Axes of a case: what varies along each, and where a lane lies on them.

Keys inside an axis are zipped; axes are crossed, the first one slowest. [[sweep]], [spectrum] and
[sample] make them.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from collections.abc import Set as AbstractSet
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from warprock.case.sampling import Distribution, Sample
from warprock.errors import InputError, Said
from warprock.units import Dimension

LABEL = "label."
"""Prefix of an axis key that names lanes and changes nothing in them."""


@dataclasses.dataclass(frozen=True)
class Numbers:
    """Numeric values along an axis.

    Attributes:
        values: SI units or rad, shape [axis].
        dimension: What they all measure.
        first: The first value as it was written.
    """

    values: npt.NDArray[np.float64]
    dimension: Dimension
    first: object

    @property
    def length(self) -> int:
        """How many values."""
        return len(self.values)


@dataclasses.dataclass(frozen=True)
class Texts:
    """Text values along an axis.

    Attributes:
        values: Distinct texts in order of their first appearance.
        codes: Index into `values`, shape [axis].
    """

    values: tuple[str, ...]
    codes: npt.NDArray[np.int32]

    @property
    def first(self) -> object:
        """The first value as it was written."""
        return self.values[int(self.codes[0])]

    @property
    def length(self) -> int:
        """How many values."""
        return len(self.codes)


class TableSource(NamedTuple):
    """The file that an axis is from.

    Attributes:
        written: Its path as the case has it.
        file: Its path, as errors name it.
        sha256: Hash of its bytes.
    """

    written: str
    file: str
    sha256: str


Column = Numbers | Texts | Distribution
"""What a key of an axis has: values, or a distribution that they are drawn from."""


@dataclasses.dataclass(frozen=True)
class Axis:
    """One axis: values by dotted key, all of the same length.

    Attributes:
        columns: Values by dotted key, in the order of the case file.
        length: Values along the axis, >= 1.
        sample: What draws the values of every column, one of a list with equal chances; None
            where the columns list them.
        source: The file whose rows they are; None where the case lists them.
    """

    columns: Mapping[str, Column]
    length: int
    sample: Sample | None = None
    source: TableSource | None = None

    @property
    def labels_differ(self) -> bool:
        """Whether its labels name every value along it."""
        codes = [
            column.codes
            for key, column in self.columns.items()
            if key.startswith(LABEL) and isinstance(column, Texts)
        ]
        return bool(codes) and len(np.unique(np.stack(codes), axis=1).T) == self.length

    def places(self, positions: npt.NDArray[np.intp]) -> dict[str, npt.NDArray[Any]]:
        """Which value of each column a lane takes, for some positions along the axis.

        Returns:
            By key, shape [position]: an index into a list, or the probability that the value of a
            distribution is not exceeded.
        """
        if self.sample is None:
            return dict.fromkeys(self.columns, positions)
        points = self.sample.points(positions).T
        return {
            key: drawn if isinstance(column, Distribution) else _deal(drawn, column.length)
            for drawn, (key, column) in zip(points, self.columns.items(), strict=True)
        }


def _deal(drawn: npt.NDArray[np.float64], length: int) -> npt.NDArray[np.intp]:
    """Positions in a list, all equally likely."""
    return np.floor(drawn * length).astype(np.intp)


def crossed_labels(axes: Sequence[Axis], skipped: AbstractSet[int], source: str) -> tuple[str, ...]:
    """Labels of every combination along some axes, first axis slowest; one text without any.

    Args:
        axes: All axes of a case.
        skipped: Numbers of those that are left out.
        source: The case file, for the error text.

    Raises:
        InputError: One of the axes has no label to name its values by.
    """
    texts = [""]
    for number, axis in enumerate(axes):
        if number in skipped:
            continue
        labels = [
            column
            for key, column in axis.columns.items()
            if key.startswith(LABEL) and isinstance(column, Texts)
        ]
        if not labels:
            allowed = "must have a label.NAME: each of its values is a panel of the figure"
            raise InputError(source, f"sweep[{number}]", Said("no label"), allowed)
        names = [
            ", ".join(label.values[label.codes[at]] for label in labels)
            for at in range(axis.length)
        ]
        texts = [", ".join(filter(None, (text, name))) for text in texts for name in names]
    return tuple(texts)


def axis_shape(axes: Sequence[Axis]) -> tuple[int, ...]:
    """Lengths of the axes, first one slowest; one lane has no axes."""
    return tuple(axis.length for axis in axes)


def lane_indices(shape: Sequence[int], lanes: range) -> list[npt.NDArray[np.intp]]:
    """Position along every axis of some lanes: the digits of a lane's number in mixed radix.

    Args:
        shape: Lengths of the axes, first one slowest.
        lanes: Lane numbers, each from 0 to the product of the lengths less one.

    Returns:
        One array an axis, shape [lane].

    Raises:
        ValueError: A lane number outside the grid.
    """
    total = math.prod(shape)
    if lanes and (min(lanes) < 0 or max(lanes) >= total):
        raise ValueError(f"lanes: got {lanes}, must lie in 0 to {total - 1}")
    left = np.arange(lanes.start, lanes.stop, lanes.step, dtype=np.intp)
    digits: list[npt.NDArray[np.intp]] = []
    for length in reversed(shape):
        left, digit = np.divmod(left, length)
        digits.append(digit)
    return digits[::-1]
