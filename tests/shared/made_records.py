"""Records made of given samples."""

from __future__ import annotations

from typing import Any

import numpy.typing as npt

from warprock.model.motion import Control
from warprock.recordings import Record


def made_record(samples: npt.NDArray[Any], interval: float) -> Record:
    """A record of accelerations [m/s^2] at an interval [s]."""
    return Record(
        name="made",
        interval=interval,
        samples=samples,
        quantity=Control.ACCELERATION,
        source="made here",
        licence="none",
        sha256="",
        file="made here",
    )
