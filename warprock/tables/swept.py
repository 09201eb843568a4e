"""The swept inputs of a case as a figure needs them: names, coordinates, and a fair selection."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from warprock.case.axes import LABEL, Axis, Numbers, Texts
from warprock.case.case import Case
from warprock.case.sampling import Distribution, Shape
from warprock.units import UNITS, format_quantity, unit_written

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.intp]

NAMES: dict[str, tuple[str, str]] = {
    "start.rotation": ("starting rotation", "rotation at the start"),
    "start.rotation_ratio": (
        "starting rotation ratio",
        "rotation at the start / slenderness angle",
    ),
    "motion.scale": ("scale", "scale of the record"),
    "motion.start": ("start of motion", "start of the motion"),
    "motion.duration": ("duration", "duration of the motion"),
    "contact.angular_restitution": ("restitution", "angular restitution"),
}
"""Short and long name of a key where its own last part would not do."""

TICKS = 12
"""Names that fit side by side below an axis."""

_SPACING_TOLERANCE = 1e-6


@dataclasses.dataclass(frozen=True)
class SweptAxis:
    """One axis of a sweep with more than one value.

    Attributes:
        number: Its place among the axes of the case.
        axis: The axis.
    """

    number: int
    axis: Axis

    @property
    def length(self) -> int:
        """Values along the axis."""
        return self.axis.length

    @property
    def texts(self) -> dict[str, Texts]:
        """Columns that hold text: its labels, or where it has none, all that vary."""
        if self.axis.sample is not None:
            return {}
        found = {k: c for k, c in self.axis.columns.items() if isinstance(c, Texts)}
        labels = {k: c for k, c in found.items() if k.startswith(LABEL)}
        varying = {k: c for k, c in found.items() if len(c.values) > 1}
        return labels or varying

    @property
    def numbers(self) -> dict[str, Numbers]:
        """Columns of numbers that vary; none where they are drawn, for those make no scale."""
        if self.axis.sample is not None:
            return {}
        found = {k: c for k, c in self.axis.columns.items() if isinstance(c, Numbers)}
        return {k: c for k, c in found.items() if np.ptp(c.values) > 0.0}

    @property
    def nominal(self) -> bool:
        """Whether its values are told apart by names, not along a scale."""
        return self.scale_key is None

    @property
    def scale_key(self) -> str | None:
        """The key whose values make a scale: the only one, or more than names could show."""
        rising = [k for k, c in self.numbers.items() if _is_monotone(c.values)]
        alone = len(self.numbers) == 1 and not self.texts
        return rising[0] if rising and (alone or self.length > TICKS) else None

    @property
    def of_seeds(self) -> bool:
        """Whether its values are seeds: between two of them nothing lies."""
        return (self.scale_key or "").endswith("seed")

    @property
    def coordinates(self) -> Array:
        """Where each value lies along a scale, in the unit it was written in, shape [axis]."""
        key = self.scale_key
        if key is None:
            return np.arange(self.length, dtype=np.float64)
        column = self.numbers[key]
        return column.values / float(UNITS[column.dimension][_unit(column)])

    @property
    def logarithmic(self) -> bool:
        """Whether the values are spaced as a geometric series."""
        values = self.coordinates
        if self.nominal or len(values) < 3 or np.any(values <= 0.0):
            return False
        steps = np.diff(np.log(values))
        return bool(np.ptp(steps) < _SPACING_TOLERANCE * np.abs(steps).max())

    @property
    def title(self) -> str:
        """Label of the axis, with the unit of its scale."""
        key = self.scale_key
        if key is not None:
            others = [_short(k) for k in (*self.texts, *self.numbers) if k != key]
            beside = f" (with {', '.join(others)})" if others else ""
            return f"{_long(key)} [{_unit(self.numbers[key]) or '-'}]{beside}"
        keys = list(self.texts) or list(self.numbers)
        return ", ".join(_short(key) for key in keys)

    def name(self, position: int, *, bare: bool = False) -> str:
        """What sets one value apart: its labels, or its numbers with their names.

        Args:
            position: Place along the axis.
            bare: Whether to leave the names of the numbers out.
        """
        if self.axis.sample is not None:
            return f"draw {position}"
        parts = [c.values[int(c.codes[position])] for c in self.texts.values()]
        pairs = {(*(int(c.codes[p]) for c in self.texts.values()),) for p in range(self.length)}
        if len(pairs) < self.length:
            for key, column in self.numbers.items():
                value = float(f"{column.values[position]:.12g}")
                text = _number_text(value, column)
                parts.append(text if bare else f"{_short(key)} {text}")
        return ", ".join(parts)

    def columns(self) -> dict[str, list[str]]:
        """What tells its values apart in a table: the text of each by its heading, with its unit.

        Labels that differ stand for the numbers beside them.
        """
        found = {
            _short(key).replace(" ", "\n"): [column.values[int(code)] for code in column.codes]
            for key, column in self.texts.items()
        }
        if found and len(set(zip(*found.values(), strict=True))) == self.length:
            return found
        for key, column in self.numbers.items():
            unit = _unit(column)
            values = column.values / float(UNITS[column.dimension][unit])
            heading = _short(key).replace(" ", "\n") + (f"\n[{unit}]" if unit else "")
            found[heading] = [f"{value:.6g}" for value in values]
        return found


@dataclasses.dataclass(frozen=True)
class DrawnInput:
    """An input that a case draws, as the abscissa of a panel.

    Attributes:
        key: Its dotted key.
        title: Label of the abscissa, with its unit.
        unit_size: Size of that unit in SI units or rad.
        logarithmic: Whether its distribution is one of the logarithm.
        names: What texts are drawn from; None of numbers.
    """

    key: str
    title: str
    unit_size: float = 1.0
    logarithmic: bool = False
    names: tuple[str, ...] | None = None


def drawn_inputs(case: Case) -> list[DrawnInput]:
    """The inputs that a case draws, in their order."""
    found = []
    for axis in case.axes:
        for key, column in axis.columns.items() if axis.sample is not None else ():
            if isinstance(column, Texts):
                found.append(DrawnInput(key, _long(key), names=column.values))
                continue
            unit = _unit(column)
            size = float(UNITS[column.dimension][unit])
            log = isinstance(column, Distribution) and column.shape is not Shape.UNIFORM
            found.append(DrawnInput(key, f"{_long(key)} [{unit or '-'}]", size, log))
    return found


def swept_axes(case: Case) -> list[SweptAxis]:
    """Axes of a case along which something changes, in their order."""
    found = (SweptAxis(number, axis) for number, axis in enumerate(case.axes))
    return [axis for axis in found if axis.length > 1]


def spread(lengths: Sequence[int], most: int) -> list[Indices]:
    """Evenly spaced positions along some axes, so that their product is at most `most`.

    The longest axis gives way first, so that every axis keeps its ends as long as it can.
    """
    counts = list(lengths)
    while int(np.prod(counts)) > most:
        counts[counts.index(max(counts))] -= 1
    return [
        np.round(np.linspace(0, length - 1, count)).astype(np.intp)
        for length, count in zip(lengths, counts, strict=True)
    ]


def lanes_at(case: Case, positions: dict[int, int]) -> Indices:
    """Lanes at some positions, all values of the axes not named, in lane order.

    Args:
        case: The case.
        positions: Place along an axis by its number.
    """
    grid = np.arange(case.lane_count, dtype=np.intp).reshape(case.shape)
    index = tuple(positions.get(number, slice(None)) for number in range(len(case.shape)))
    return np.ravel(grid[index])


def _is_monotone(values: Array) -> bool:
    steps = np.diff(values)
    return bool(np.all(steps > 0.0) or np.all(steps < 0.0))


def _short(key: str) -> str:
    key, direction = _without_direction(key)
    tail = key.rpartition(".")[2].replace("_", " ")
    return NAMES.get(key, (tail, tail))[0] + direction


def _long(key: str) -> str:
    plain, direction = _without_direction(key)
    return NAMES[plain][1] + direction if plain in NAMES else _short(key)


def _without_direction(key: str) -> tuple[str, str]:
    """The key of a motion along x, and the direction in words if it is another."""
    for direction in ("y", "z"):
        if key.startswith(f"motion.{direction}."):
            return key.replace(f".{direction}.", "."), f" along {direction}"
    return key, ""


def _unit(column: Numbers | Distribution) -> str:
    """The unit that the first value was written in; the SI unit where that is not told."""
    sizes = UNITS[column.dimension]
    unit = unit_written(column.first) if isinstance(column.first, str) else ""
    return unit if unit in sizes else next(iter(sizes))


def _number_text(value: float, column: Numbers) -> str:
    unit = _unit(column)
    size = float(UNITS[column.dimension][unit])
    return format_quantity(float(f"{value / size:.4g}") * size, column.dimension, unit)
