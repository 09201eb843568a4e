"""Factors of the estimates of `run_to_tolerance`, from the table of `tools/calibrate_estimates.py`.

An estimate is a factor times the error by the differences of runs, plus a floor for the error that
all runs share: a swing of a block that barely lifts, or a slip that ends within a step. Both were
fitted by engine, quantity, scene and kind of motion to lanes with a known true answer.
"""

from __future__ import annotations

import csv
import dataclasses
import functools
import importlib.resources
from collections.abc import Iterator

TABLE = "calibration.csv"

QUANTITIES = ("rotation_error", "peak_rotation_error", "peak_slide_error")

PLAIN = 1.56
"""Factor of an engine, or of a quantity, that the table does not have."""


BLOCK, BODY, STACK = "block", "body", "stack"
"""Scenes that have factors of their own: a single box in the plane, all else that stands alone, and
stacks."""


@dataclasses.dataclass(frozen=True)
class Factor:
    """How the differences of runs become an estimate of the error.

    Attributes:
        factor: Factor on the error by the differences of runs.
        floor: Error that is added, over the slenderness angle for rotations, over the peak slide
            for slides.
    """

    factor: float = PLAIN
    floor: float = 0.0


@dataclasses.dataclass(frozen=True)
class Factors:
    """The factors of an engine's estimates."""

    rotation: Factor = Factor()
    peak: Factor = Factor()
    slide: Factor = Factor()


Key = tuple[str, str, str, str]
"""Scene, set of lanes, engine, quantity."""


def estimate_factors(engine: str, scene: str, *, records: bool) -> Factors:
    """The factors that an engine's estimates need.

    Args:
        engine: Name in `ENGINES`; one that the table does not have gets `PLAIN`.
        scene: `BLOCK`, `BODY` or `STACK`; the factors of blocks where the engine has none for it.
        records: Whether nothing but records moves the base; the factors of pulses where the engine
            has none for records of either scene.
    """
    found = shipped_factors()
    sets = ("records", "pulses") if records else ("pulses",)
    places = [(each, name) for name in sets for each in (scene, BLOCK)]
    parts = []
    for quantity in QUANTITIES:
        keys = [(*place, engine, quantity) for place in places]
        parts.append(next((found[key] for key in keys if key in found), Factor()))
    return Factors(*parts)


@functools.cache
def shipped_factors() -> dict[Key, Factor]:
    """The shipped table."""
    return {
        (row["scene"], row["set"], row["engine"], row["quantity"]): Factor(
            float(row["factor"]), float(row["floor"])
        )
        for row in _rows()
    }


def _rows() -> Iterator[dict[str, str]]:
    file = importlib.resources.files("warprock.cases") / "estimate" / TABLE
    with file.open(encoding="utf-8") as stream:
        yield from csv.DictReader(line for line in stream if not line.startswith("#"))
