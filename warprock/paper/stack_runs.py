"""Runs behind Section 6 of the paper: what they found of two stacked blocks, as tables.

Rotations of a stack are divided by 9.85 deg, as the paper's are.
"""

from __future__ import annotations

import dataclasses
import functools

import numpy as np
import numpy.typing as npt
import pandas as pd

from warprock.model.response import FALLEN, SOUND, Outcome, Status, names_of
from warprock.paper.conflicts_stack import (
    CEILING,
    OVERTURNED,
    analytical_peaks,
    read_printed,
    rows_at,
)
from warprock.paper.printed import BLOCKS, REFERENCE_DEGREES, paper_columns
from warprock.paper.runs import (
    ENSEMBLE_ENGINE,
    SINE_ENSEMBLE,
    STACK_ENGINES,
    STACK_SINE,
    PaperRuns,
)
from warprock.running.cells import percentile_of, wilson_interval

Array = npt.NDArray[np.float64]

REFERENCE_ANGLE = float(np.deg2rad(REFERENCE_DEGREES))
INPUTS = ["frequency_hz", "amplitude_mm"]
READING = ["reading", "geometry", "edges"]
LARGEST_ERROR = 0.9
"""Underestimate from which a test is still inferred; beyond it ours counts over tenfold."""
LEAST_BASE = 0.01
"""Rotation / 9.85 deg from which a reading of ours rocks at all."""
SHARES = {
    "low_5": 0.05,
    "quartile_low": 0.25,
    "median": 0.5,
    "quartile_high": 0.75,
    "high_95": 0.95,
}
"""Quantiles of an ensemble: column -> share of members at or below it."""


@functools.lru_cache(maxsize=4)
def peak_table(runs: PaperRuns, name: str, *overrides: str) -> pd.DataFrame:
    """Peaks of every engine, lane and block of a case of stacks, made once and not to be changed.

    Returns:
        A row each with `frequency_hz`, `amplitude_mm`, `reading`, `geometry`, `edges`, `block`
        ("bottom" or "top"), `source`, `peak_rotation_ratio` (/ 9.85 deg), `peak_slide_mm` and
        `outcome`.
    """
    responses = runs.case(name, *overrides)
    inputs = responses.lane_set.inputs[[*INPUTS, *READING]].reset_index(drop=True)
    inputs = inputs.astype(dict.fromkeys(READING, str))
    parts = []
    for engine in STACK_ENGINES:
        response = responses[engine]
        outcome = names_of(Outcome, response["outcome"])
        parts += [
            inputs.assign(
                block=block,
                source=engine,
                peak_rotation_ratio=response["peak_rotation"][:, index] / REFERENCE_ANGLE,
                peak_slide_mm=1e3 * response["peak_slide"][:, index],
                outcome=outcome,
            )
            for index, block in enumerate(BLOCKS)
        ]
    return pd.concat(parts, ignore_index=True)


def input_keys() -> list[tuple[float, float]]:
    """Frequency [Hz] and amplitude [mm] of the inputs of Table 8, in its order."""
    table = paper_columns("table8")
    return list(zip(table["frequency_hz"], table["amplitude_mm"].astype(float), strict=True))


def pick(table: pd.DataFrame, **chosen: object) -> pd.DataFrame:
    """Rows of a table in which columns have certain values."""
    mask = np.ones(len(table), dtype=bool)
    for column, value in chosen.items():
        mask &= (table[column] == value).to_numpy()
    return table[mask]


@dataclasses.dataclass(frozen=True)
class Cells:
    """What became of the members of every cell of an ensemble.

    Attributes:
        inputs: A row a cell: its labels and inputs without spread.
        ratio: Peak rotation / 9.85 deg, NaN of a lane without a usable number, shape
            [cell, member, block].
        outcome: Codes of `Outcome`, shape [cell, member].
    """

    inputs: pd.DataFrame
    ratio: Array
    outcome: npt.NDArray[np.int64]

    @property
    def fell(self) -> npt.NDArray[np.bool_]:
        """Whether a block overturned or slid off, shape [cell, member]."""
        return np.isin(self.outcome, FALLEN)

    @property
    def usable(self) -> npt.NDArray[np.bool_]:
        """Whether a member's numbers may be used, shape [cell, member]."""
        return np.asarray(np.isfinite(self.ratio).all(axis=2))

    def standing_ratio(self, cell: int, block: str) -> Array:
        """Peak rotations / 9.85 deg of the members that stayed up, shape [member]."""
        kept = self.usable[cell] & ~self.fell[cell]
        return np.asarray(self.ratio[cell, kept, BLOCKS.index(block)])

    def percentile(self, cell: int, block: str, value: float) -> float:
        """Where a printed peak / 9.85 deg falls among the members of a cell, 0 to 100."""
        values = self.ratio[cell, :, BLOCKS.index(block)]
        return 100.0 * percentile_of(values, self.outcome[cell], value)

    def place(self, geometry: str, key: tuple[float, float]) -> int:
        """Number of the cell of a geometry and an input (frequency [Hz], amplitude [mm])."""
        found = pick(self.inputs, geometry=geometry, frequency_hz=key[0], amplitude_mm=key[1])
        return int(found.index[0])


def cells_of(runs: PaperRuns, name: str) -> Cells:
    """Runs a case with an ensemble."""
    responses = runs.case(name)
    lane_set, response = responses.lane_set, responses[ENSEMBLE_ENGINE]
    assert lane_set.cells is not None
    inputs = lane_set.cells.reset_index(drop=True)
    inputs = inputs.assign(**{name: inputs[name].astype(str) for name in lane_set.labels})
    shape = (len(inputs), lane_set.members)
    usable = np.isin(response["status"], (*SOUND, Status.SENSITIVE))
    ratio = np.where(usable[:, None], response["peak_rotation"] / REFERENCE_ANGLE, np.nan)
    return Cells(inputs, ratio.reshape(*shape, -1), response["outcome"].reshape(shape))


def cell_rows(cells: Cells, block: str) -> pd.DataFrame:
    """The distribution of one block's peak in every cell.

    Returns:
        A row a cell with its inputs and labels, `block`, `members` (usable ones),
        `collapsed_share` with its 95 % interval `collapsed_low` and `collapsed_high`, and the
        quantiles in `SHARES`; a quantile among members that fell is +infinity.
    """
    ratio = np.where(cells.fell, np.inf, cells.ratio[:, :, BLOCKS.index(block)])
    ratio = np.where(cells.usable, ratio, np.nan)
    members = cells.usable.sum(axis=1)
    fell = (cells.fell & cells.usable).sum(axis=1)
    low, high = wilson_interval(fell, members)
    quantiles = {
        name: [
            float(np.quantile(row[~np.isnan(row)], share, method="inverted_cdf"))
            if members[cell]
            else np.nan
            for cell, row in enumerate(ratio)
        ]
        for name, share in SHARES.items()
    }
    return cells.inputs.assign(
        block=block,
        members=members,
        collapsed_share=np.where(members > 0, fell / np.maximum(members, 1), np.nan),
        collapsed_low=low,
        collapsed_high=high,
        **quantiles,
    )


@dataclasses.dataclass(frozen=True)
class InferredTest:
    """Largest rotations of the shake-table tests / 9.85 deg that a column of errors implies.

    Attributes:
        column: The printed column.
        reading: Reading of ours that stands for that column.
        geometry: Geometry of the same.
        base: Our values, shape [input].
        over: Whether the printed error can only be an overestimate, shape [input].
        values: The tests' values; NaN where nothing is printed, shape [input].
        fallen: Inputs whose test is printed as a fall, shape [input].
    """

    column: str
    reading: str
    geometry: str
    base: Array
    over: npt.NDArray[np.bool_]
    values: Array
    fallen: npt.NDArray[np.bool_]

    def why(self, index: int) -> str:
        """How the value of an input came about."""
        if self.fallen[index]:
            return "90 deg, as the paper enters a test in which the block fell"
        if self.base[index] < LEAST_BASE:
            return "none: the reading of ours that stands for the column does not rock"
        if np.isnan(self.values[index]):
            return "none: nothing is printed, or an error so near 100 % that it hardly says more"
        sign = "+" if self.over[index] else "-"
        return (
            f"ours ({self.base[index]:.3f}) / (1 {sign} error of the paper's {self.column} column)"
            ", inferred, not measured"
        )


def inferred_tests(runs: PaperRuns, table: str, block: str) -> tuple[InferredTest, InferredTest]:
    """The tests behind Table 11 or 12, by the analytical column and by Bullet's.

    Errors are read as underestimates, as the text says of the engines; one above 100 % can only be
    an overestimate, and from `LARGEST_ERROR` to 100 % nothing is inferred. Bullet is stood for by
    the median of the ensemble of the geometry low-top.
    """
    ensemble = cell_rows(cells_of(runs, SINE_ENSEMBLE), block)
    median = pick(ensemble, geometry="low-top")["median"].to_numpy(dtype=float)
    bases = {
        "analytical": (analytical_peaks(peak_table(runs, STACK_SINE), block), "acceleration"),
        "bullet": (median, "displacement"),
    }
    fallen = np.zeros(len(paper_columns(table)), dtype=bool)
    fallen[rows_at(OVERTURNED)] = block == "top"
    tests = []
    for column, (base, reading) in bases.items():
        error = 1e-2 * read_printed(table, column)
        over = error > 1.0
        says = over | (error <= LARGEST_ERROR)
        values = np.full(len(base), np.nan)
        values[says] = (base / np.where(over, 1.0 + error, 1.0 - error))[says]
        values = np.where(fallen, CEILING, np.where(base < LEAST_BASE, np.nan, values))
        geometry = "equal-depths" if column == "analytical" else "low-top"
        tests.append(InferredTest(column, reading, geometry, base, over, values, fallen))
    return tests[0], tests[1]
