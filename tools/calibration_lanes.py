"""Random lanes that error estimates are calibrated on: let go, under pulses, under records."""

from __future__ import annotations

import dataclasses

import numpy as np
import numpy.typing as npt

from warprock.case.lanes import expand_lanes
from warprock.case.load import load_case
from warprock.model import rocking
from warprock.model.lanes import Lanes
from warprock.model.motion import (
    Control,
    GroundMotions,
    RecordMotions,
    StillBase,
    Waveform,
    harmonic_motions,
)
from warprock.model.response import SampleTimes
from warprock.units import GRAVITY

RECORD_REPEATS = 35
"""Blocks under each of the six records."""


@dataclasses.dataclass(frozen=True)
class Problem:
    """Lanes, their motions and the length of their run [s]."""

    lanes: Lanes
    motions: GroundMotions
    duration: float

    def first(self, count: int) -> Problem:
        """Its first lanes."""
        some = np.arange(min(count, self.lanes.lane_count))
        return Problem(self.lanes.take(some), self.motions.take(some), self.duration)

    @property
    def times(self) -> SampleTimes:
        """Samples dense enough to see the largest difference of two rotations."""
        return SampleTimes(self.duration, 5e-3)


def blocks(rng: np.random.Generator, count: int, rotation_ratio: npt.ArrayLike = 0.0) -> Lanes:
    """Blocks .3 to 4 m high, 1.6 to 6 times as high as wide."""
    height = rng.uniform(0.3, 4.0, count)
    width = height / rng.uniform(1.6, 6.0, count)
    angle = np.arctan2(width, height)
    friction = rng.uniform(0.3, 1.3, count)
    columns = np.broadcast_arrays(
        width, height, 0.5, 2000.0, friction, 0.0, 0.0, rotation_ratio * angle
    )
    parts = [np.array(column, dtype=np.float64) for column in columns]
    return Lanes(*parts, angular_restitution=rocking.angular_restitution(angle))


def free(rng: np.random.Generator) -> Problem:
    """Blocks let go from .05 to .98 of their slenderness angles."""
    count = 150
    return Problem(blocks(rng, count, rng.uniform(0.05, 0.98, count)), StillBase(count), 8.0)


def pulses(rng: np.random.Generator) -> Problem:
    """One to three cycles at 1.05 to 4 times the acceleration that lifts the block."""
    count = 250
    lanes = blocks(rng, count)
    controls = [list(Control)[i] for i in rng.integers(0, 3, count)]
    cosine = rng.random(count) < 0.3
    waveforms = [
        Waveform.COSINE if wants and control is not Control.DISPLACEMENT else Waveform.SINE
        for wants, control in zip(cosine, controls, strict=True)
    ]
    frequency = rng.uniform(0.7, 6.0, count)
    acceleration = GRAVITY * np.tan(lanes.slenderness_angle) * rng.uniform(1.05, 4.0, count)
    orders = np.array([{"displacement": 2, "velocity": 1}.get(c.value, 0) for c in controls])
    amplitude = acceleration / (2.0 * np.pi * frequency) ** orders
    cycles = rng.integers(1, 4, count)
    motions = harmonic_motions(
        waveforms, controls, amplitude, frequency, np.full(count, 0.05), cycles / frequency
    )
    return Problem(lanes, motions, 8.0)


def records(rng: np.random.Generator) -> Problem:
    """The shipped records, their peaks 1.05 to 3 times the acceleration that lifts the block."""
    shipped = expand_lanes(load_case("fragility-five-blocks"))
    pool = shipped.motions
    assert isinstance(pool, RecordMotions)
    _, first = np.unique(shipped.inputs["record"], return_index=True)
    count = RECORD_REPEATS * len(first)
    lanes = blocks(rng, count)
    motions = pool.take(np.tile(first, RECORD_REPEATS))
    assert isinstance(motions, RecordMotions)
    peaks = shipped.inputs["peak_acceleration_m_s2"].to_numpy() / pool.scale
    ratio = rng.uniform(1.05, 3.0, count)
    scale = (
        GRAVITY * np.tan(lanes.slenderness_angle) / np.tile(peaks[first], RECORD_REPEATS) * ratio
    )
    return Problem(lanes, dataclasses.replace(motions, scale=scale), 30.0)
