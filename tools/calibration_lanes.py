"""Random lanes that error estimates are calibrated on: let go, under pulses, under records.

Blocks, the same blocks as bodies on contact points, and stacks of two and three blocks.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping

import numpy as np
import numpy.typing as npt

from warprock.case.lanes import expand_lanes
from warprock.case.load import load_case
from warprock.engines.bodies import box_bodies
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
from warprock.model.stacking import uplift_ratio
from warprock.running.calibration import STACK
from warprock.units import GRAVITY

SHIPPED_RECORDS = 6

COUNTS = {"free": 150, "pulses": 250, "records": 35 * SHIPPED_RECORDS}
"""Lanes of a set of blocks."""

STACK_COUNTS = {"free": 60, "pulses": 150, "records": 20 * SHIPPED_RECORDS}
"""Lanes of a set of stacks, of each height."""

HEIGHTS = (2, 3)
"""Blocks of the stacks."""


Array = npt.NDArray[np.float64]


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


def blocks(rng: np.random.Generator, count: int) -> Lanes:
    """Blocks .3 to 4 m high, 1.6 to 6 times as high as wide."""
    height = rng.uniform(0.3, 4.0, count)
    width = height / rng.uniform(1.6, 6.0, count)
    angle = np.arctan2(width, height)
    friction = rng.uniform(0.3, 1.3, count)
    columns = np.broadcast_arrays(width, height, 0.5, 2000.0, friction, 0.0, 0.0, 0.0)
    parts = [np.array(column, dtype=np.float64) for column in columns]
    return Lanes(*parts, angular_restitution=rocking.angular_restitution(angle))


def stacks(rng: np.random.Generator, count: int, high: int) -> Lanes:
    """Stacks of blocks 0.2 to 0.6 m wide, the narrower ones above, 1 to 4 times as high as wide."""
    shape = (count, high)
    parts = np.concatenate([np.ones((count, 1)), rng.uniform(0.6, 1.0, (count, high - 1))], axis=1)
    width = rng.uniform(0.2, 0.6, (count, 1)) * np.cumprod(parts, axis=1)
    height = width * rng.uniform(1.0, 4.0, shape)
    friction = rng.uniform(0.4, 1.2, shape)
    columns = [width, height, 0.5, 2000.0, friction, 0.0, 0.0, 0.0]
    full = [np.array(np.broadcast_to(column, shape), dtype=np.float64) for column in columns]
    return Lanes(*full, angular_restitution=np.ones(count))


def lift_ratio(lanes: Lanes) -> Array:
    """Acceleration of the base at which something lifts, over that of gravity, shape [lane]."""
    return uplift_ratio(lanes).min(axis=1) if lanes.stacked else np.tan(lanes.slenderness_angle)


def free(rng: np.random.Generator, lanes: Lanes) -> Problem:
    """Blocks let go from .05 to .98 of their slenderness angles, of stacks the highest one."""
    count = lanes.lane_count
    start = rng.uniform(0.05, 0.98, count)
    angle = np.arctan2(lanes.width, lanes.height)
    if lanes.stacked:
        rotation = np.zeros_like(angle)
        rotation[:, -1] = start * angle[:, -1]
    else:
        rotation = start * angle
    return Problem(
        dataclasses.replace(lanes, rotation_start=rotation), StillBase(count), DURATION["free"]
    )


def pulses(rng: np.random.Generator, lanes: Lanes) -> Problem:
    """One to three cycles at 1.05 to 4 times the acceleration that lifts the block."""
    count = lanes.lane_count
    controls = [list(Control)[i] for i in rng.integers(0, 3, count)]
    cosine = rng.random(count) < 0.3
    waveforms = [
        Waveform.COSINE if wants and control is not Control.DISPLACEMENT else Waveform.SINE
        for wants, control in zip(cosine, controls, strict=True)
    ]
    frequency = rng.uniform(0.7, 6.0, count)
    acceleration = GRAVITY * lift_ratio(lanes) * rng.uniform(1.05, 4.0, count)
    orders = np.array([{"displacement": 2, "velocity": 1}.get(c.value, 0) for c in controls])
    amplitude = acceleration / (2.0 * np.pi * frequency) ** orders
    cycles = rng.integers(1, 4, count)
    motions = harmonic_motions(
        waveforms, controls, amplitude, frequency, np.full(count, 0.05), cycles / frequency
    )
    return Problem(lanes, motions, DURATION["pulses"])


def records(rng: np.random.Generator, lanes: Lanes) -> Problem:
    """The shipped records, their peaks 1.05 to 3 times the acceleration that lifts the block."""
    shipped = expand_lanes(load_case("fragility-five-blocks"))
    pool = shipped.motions
    assert isinstance(pool, RecordMotions)
    _, first = np.unique(shipped.inputs["record"], return_index=True)
    assert len(first) == SHIPPED_RECORDS
    which = np.arange(lanes.lane_count) % len(first)
    motions = pool.take(first[which])
    assert isinstance(motions, RecordMotions)
    peaks = shipped.inputs["peak_acceleration_m_s2"].to_numpy() / pool.scale
    ratio = rng.uniform(1.05, 3.0, lanes.lane_count)
    scale = GRAVITY * lift_ratio(lanes) / peaks[first[which]] * ratio
    return Problem(lanes, dataclasses.replace(motions, scale=scale), DURATION["records"])


DURATION = {"free": 8.0, "pulses": 8.0, "records": 30.0}
"""Length of a run [s]."""

SETS: Mapping[str, Callable[[np.random.Generator, Lanes], Problem]] = {
    "free": free,
    "pulses": pulses,
    "records": records,
}


def problems(scene: str, name: str, seed: int) -> list[Problem]:
    """The lanes of a scene and a set; bodies are the boxes of blocks."""
    found = []
    for high in HEIGHTS if scene == STACK else (1,):
        rng = np.random.default_rng([seed, list(SETS).index(name), high])
        if scene == STACK:
            found.append(SETS[name](rng, stacks(rng, STACK_COUNTS[name], high)))
        else:
            found.append(SETS[name](rng, blocks(rng, COUNTS[name])))
    return found


def as_bodies(problem: Problem) -> Problem:
    """The same boxes as bodies on contact points."""
    lanes = problem.lanes
    return dataclasses.replace(problem, lanes=dataclasses.replace(lanes, body=box_bodies(lanes)))
