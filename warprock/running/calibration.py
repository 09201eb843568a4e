"""Factors of the estimates of `run_to_tolerance`, from the table of `tools/calibrate_estimates.py`.

An estimate is a factor times what two runs tell of the error, and a floor for what all runs get
wrong alike: a swing of a block that barely lifts, or a slip that ends within a step. Both were
fitted by engine, quantity and kind of motion to lanes whose true answer is known.
"""

from __future__ import annotations

import csv
import dataclasses
import functools
import importlib.resources
from collections.abc import Iterator

TABLE = "calibration.csv"

QUANTITIES = ("rotation_error", "peak_rotation_error", "peak_slide_error")

PLAIN = 1.5
"""Factor of an engine, or of a quantity, that the table does not have."""


@dataclasses.dataclass(frozen=True)
class Factor:
    """How the difference of two runs becomes an estimate of the error.

    Attributes:
        factor: Factor on the extrapolated difference of two runs.
        floor: What is added, over the slenderness angle for rotations, over the peak slide for
            slides.
    """

    factor: float = PLAIN
    floor: float = 0.0


@dataclasses.dataclass(frozen=True)
class Factors:
    """The factors of an engine's estimates."""

    rotation: Factor = Factor()
    peak: Factor = Factor()
    slide: Factor = Factor()


def estimate_factors(engine: str, *, records: bool) -> Factors:
    """The factors that an engine's estimates need.

    Args:
        engine: Name in `ENGINES`; one that the table does not have gets `PLAIN`, and under
            records the factors of pulses where it has none for records.
        records: Whether nothing but records moves the base.
    """
    found = shipped_factors()
    parts = []
    for quantity in QUANTITIES:
        part = found.get(("pulses", engine, quantity), Factor())
        parts.append(found.get(("records", engine, quantity), part) if records else part)
    return Factors(*parts)


@functools.cache
def shipped_factors() -> dict[tuple[str, str, str], Factor]:
    """The shipped table: (set of lanes, engine, quantity) -> its factor."""
    return {
        (row["set"], row["engine"], row["quantity"]): Factor(
            float(row["factor"]), float(row["floor"])
        )
        for row in _rows()
    }


def _rows() -> Iterator[dict[str, str]]:
    file = importlib.resources.files("warprock.cases") / "estimate" / TABLE
    with file.open(encoding="utf-8") as stream:
        yield from csv.DictReader(line for line in stream if not line.startswith("#"))
