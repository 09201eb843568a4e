"""Boundaries of an overturning map: where in a column of its grid the mode of overturning changes.

In each column of the grid every change of the mode from one lane to the next is halved, all columns
in one batch, down to an accuracy. A third mode in the middle makes two boundaries of one. What is
narrower than the grid and lies between two lanes of the same mode is not seen.
"""

from __future__ import annotations

import dataclasses
import itertools
import time
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from warprock.analysis.overturning import (
    Array,
    Codes,
    Mode,
    OverturningMap,
    modes,
    run_grid,
    strengths,
)
from warprock.case.case import Case
from warprock.errors import InputError
from warprock.model.response import SampleTimes
from warprock.running.batch import run_batch

LEAST_ACCURACY, MOST_ACCURACY = 1e-9, 0.1
SAME_FREQUENCY = 1e-3
"""Two frequency ratios that differ by less, relatively, are one column."""


@dataclasses.dataclass(frozen=True)
class _Brackets:
    """Stretches of strength at whose ends the modes differ, shape [bracket]."""

    group: npt.NDArray[np.intp]
    column: npt.NDArray[np.intp]
    lane: npt.NDArray[np.intp]
    low: Array
    high: Array
    below: Codes
    above: Codes

    def take(self, which: npt.NDArray[Any]) -> _Brackets:
        """Some of them."""
        return _Brackets(*(getattr(self, f.name)[which] for f in dataclasses.fields(self)))


def refine(
    found: OverturningMap,
    accuracy: float,
    *,
    chosen: npt.NDArray[np.bool_] | None = None,
    progress: Callable[[int], None] | None = None,
) -> OverturningMap:
    """Halves every change of the mode between two lanes of a column, until it is narrow enough.

    Args:
        found: The grid.
        accuracy: Width of a bracket over its strength, from 1e-9 to 0.1.
        chosen: Which columns to look at, shape [group, frequency]; None is all.
        progress: Called with the lanes run so far, those of the grid included.

    Returns:
        The map with its boundaries, by group, frequency and strength: `group`, `frequency_hz`,
        `frequency_ratio`, `acceleration_ratio` (middle of the bracket), its ends
        `acceleration_ratio_low` and `acceleration_ratio_high`, `peak_acceleration_m_s2`, and the
        modes `below` and `above`.

    Raises:
        InputError: The accuracy is out of bounds.
    """
    require_accuracy(accuracy)
    started = time.perf_counter()
    brackets = _first_brackets(found, chosen)
    ready = [brackets.take(np.zeros(len(brackets.lane), dtype=np.bool_))]
    stages, lanes_run = 0, found.lanes_run
    while len(brackets.lane):
        wide = brackets.high - brackets.low > accuracy * brackets.high
        ready.append(brackets.take(~wide))
        brackets = brackets.take(wide)
        if not len(brackets.lane):
            break
        middle = 0.5 * (brackets.low + brackets.high)
        given_up, brackets = _halve(brackets, middle, _middle_modes(found, brackets, middle))
        stages, lanes_run = stages + 1, lanes_run + len(middle)
        ready.append(given_up)
        if progress is not None:
            progress(lanes_run)
    return dataclasses.replace(
        found,
        boundaries=_boundary_table(found, ready),
        accuracy=accuracy,
        lanes_run=lanes_run,
        stages=stages,
        wall_time=found.wall_time + time.perf_counter() - started,
    )


def _middle_modes(found: OverturningMap, brackets: _Brackets, middle: Array) -> Codes:
    """Modes of the lanes in the middle of some brackets, which are run."""
    run, lanes = found.run, brackets.lane
    factors = middle / strengths(run.lane_set)[lanes]
    blocks = run.lane_set.lanes.take(lanes)
    motions = run.lane_set.motions.take(lanes).scaled(factors)
    duration = run.lane_set.times.duration
    response = run_batch(
        run.response.engine,
        blocks,
        motions,
        SampleTimes(duration),
        settings=run.settings,
        **run.options.of_batch,
    )
    return modes(response, blocks, motions, duration)


def require_accuracy(accuracy: float) -> None:
    """Refuses an accuracy that is out of bounds.

    Raises:
        InputError: It is not from 1e-9 to 0.1.
    """
    if not LEAST_ACCURACY <= accuracy <= MOST_ACCURACY:
        allowed = f"must be from {LEAST_ACCURACY:g} to {MOST_ACCURACY:g}"
        raise InputError("--accuracy", "", accuracy, allowed)


def _first_brackets(found: OverturningMap, chosen: npt.NDArray[np.bool_] | None) -> _Brackets:
    """Neighbours in a column whose modes differ; lanes without a number are passed over."""
    mode, strength = found.mode, found.strength
    rows = []
    for group, column in np.ndindex(mode.shape[:2]):
        if chosen is not None and not chosen[group, column]:
            continue
        known = np.flatnonzero(mode[group, column] != Mode.NO_NUMBER)
        for one, other in itertools.pairwise(known):
            place = (group, column, found.lanes[group, column, one])
            ends = strength[group, column, [one, other]]
            kinds = mode[group, column, [one, other]]
            if kinds[0] != kinds[1]:
                rows.append((*place, *ends, *kinds))
    columns = list(zip(*rows, strict=True)) or [()] * 7
    types = (np.intp, np.intp, np.intp, np.float64, np.float64, np.int8, np.int8)
    return _Brackets(*(np.array(c, t) for c, t in zip(columns, types, strict=True)))


def _halve(brackets: _Brackets, middle: Array, mode: Codes) -> tuple[_Brackets, _Brackets]:
    """Brackets whose middle has no number, as they are, and the halves that the others leave."""
    known = mode != Mode.NO_NUMBER
    lower = dataclasses.replace(brackets, high=middle, above=mode)
    upper = dataclasses.replace(brackets, low=middle, below=mode)
    left = [half.take(known & (half.below != half.above)) for half in (lower, upper)]
    return brackets.take(~known), _join(left)


def _join(parts: list[_Brackets]) -> _Brackets:
    names = [field.name for field in dataclasses.fields(_Brackets)]
    return _Brackets(*(np.concatenate([getattr(part, name) for part in parts]) for name in names))


def _boundary_table(found: OverturningMap, ready: list[_Brackets]) -> pd.DataFrame:
    brackets = _join(ready)
    brackets = brackets.take(np.lexsort((brackets.low, brackets.column, brackets.group)))
    inputs = found.run.lane_set.inputs.iloc[brackets.lane]
    middle = 0.5 * (brackets.low + brackets.high)
    peak = inputs["peak_acceleration_m_s2"].to_numpy() * middle
    words = pd.Index([mode.text for mode in Mode])
    return pd.DataFrame(
        {
            "group": np.array(found.groups, dtype=object)[brackets.group],
            "frequency_hz": inputs["frequency_hz"].to_numpy(),
            "frequency_ratio": found.frequency_ratio[brackets.group, brackets.column],
            "acceleration_ratio": middle,
            "acceleration_ratio_low": brackets.low,
            "acceleration_ratio_high": brackets.high,
            "peak_acceleration_m_s2": peak / inputs["normalised_acceleration"].to_numpy(),
            "below": np.asarray(words[brackets.below], dtype=object),
            "above": np.asarray(words[brackets.above], dtype=object),
        }
    )


def boundaries_at(
    case: Case,
    engine: str,
    where: Mapping[str, str],
    frequency_ratio: float,
    *,
    accuracy: float,
) -> Array:
    """Strengths at which the mode changes in one column of a map, weakest first.

    Args:
        case: The case.
        engine: Name of the engine.
        where: Label -> value that selects the group.
        frequency_ratio: omega_p / p of the column.
        accuracy: Width of a bracket over its strength.

    Raises:
        InputError: The case is no map, or there is not exactly one such column.
    """
    grid = run_grid(case, engine)
    selected = np.isin(grid.lanes[:, :, 0], grid.run.lane_set.select(where))
    near = np.isclose(grid.frequency_ratio, frequency_ratio, rtol=SAME_FREQUENCY, atol=0.0)
    chosen = selected & near
    if chosen.sum() != 1:
        allowed = f"must be that of one column of the map; {chosen.sum()} have it"
        raise InputError(case.file, "check.frequency_ratio", frequency_ratio, allowed)
    found = refine(grid, accuracy, chosen=chosen)
    return found.boundaries["acceleration_ratio"].to_numpy()
