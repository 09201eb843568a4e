"""The table [run]: the length of a run and the sampling of its histories."""

from __future__ import annotations

from typing import Annotated, ClassVar, Self

import pydantic

from warprock.case.validation import KeyedError, Table
from warprock.quantity import Column, NumberKey

MOST_SAMPLES = 1_000_000
"""Samples of a history that a case may ask for: more than a figure shows or a table is read for."""


DURATION = "run.duration"
"""Key of the length of the run."""


class Run(Table):
    """Length of the run, which lanes may have of their own, and time between samples [s]."""

    place: ClassVar[str] = "run"

    duration: Annotated[
        float,
        NumberKey(
            "the length of the run",
            "0 s to 1e5 s",
            low_open=True,
            swept=True,
            column=Column("duration"),
        ),
    ]
    sample_interval: Annotated[
        float | None, NumberKey("the time between samples", "0 s to 1e5 s", low_open=True)
    ] = None

    @pydantic.model_validator(mode="after")
    def _interval_inside(self) -> Self:
        if self.sample_interval is None:
            return self
        got = f"{self.sample_interval:g} s"
        if self.sample_interval > self.duration:
            allowed = f"must be at most run.duration, {self.duration:g} s"
            raise KeyedError("sample_interval", got, allowed)
        if self.duration >= MOST_SAMPLES * self.sample_interval:
            count = self.duration / self.sample_interval
            allowed = (
                f"must make less than {MOST_SAMPLES:,} samples of {self.duration:g} s, not "
                f"{count:.3g}: a history of {8e-9 * count:.3g} GB"
            )
            raise KeyedError("sample_interval", got, allowed)
        return self
