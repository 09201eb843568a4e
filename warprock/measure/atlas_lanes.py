"""The lanes of the atlas of extremes: blocks and shaking far beyond any structure.

The ranges are there to find out where an engine stops being right, and whether it says so.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Hashable, Iterable

import numpy as np
import numpy.typing as npt
import pandas as pd

from warprock.model import rocking
from warprock.model.lanes import Lanes
from warprock.model.motion import Control, GroundMotions, StillBase, Waveform, harmonic_motions
from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]

SLENDERNESS = (0.3, 20.0)
HEIGHTS = (0.05, 50.0)
"""Height / width, and height [m]."""
STARTS = (1e-6, 1e-3, 0.03, 0.2, 0.5, 0.9, 0.99, 0.9999)
"""Rotations at the start over the slenderness angle."""
MASS_RATIOS = (1e-4, 1e4)
AMPLITUDES = (0.05, 5.0)
FREQUENCIES = (0.1, 50.0)
FRICTIONS = (1e-3, 10.0)
"""Upper over lower mass, base acceleration / g, frequency [Hz], friction besides none at all."""

DEPTH, DENSITY, HOLDING_FRICTION = 0.5, 2000.0, 10.0
"""Depth [m] and density [kg/m^3] of every block, and a friction that holds all of them."""
STIFFNESS_WIDTH = 0.5
"""Width [m] of the blocks of the maps of stiffness: a corner stands for half of the face."""
STACK_SLENDERNESS = 3.0
"""Height / width of the blocks of a stack."""
STACK_TURNS = {"both": (1.0, 1.0), "upper": (0.0, 1.0), "lower": (1.0, 0.0), "against": (1.0, -1.0)}
"""Rotations at the start of the lower and the upper block, over the lane's start."""
CYCLES = 3.0
"""Cycles of a sine burst."""


@dataclasses.dataclass(frozen=True)
class AtlasSize:
    """How much of an atlas is run.

    Attributes:
        points: Values along an axis; of time steps at most 11, two a decade.
        steps: Most time steps of a launch with many lanes; its duration is cut to them.
        duration: Longest time that a launch covers [s].
        iterations: Sweeps of the contact solver that are tried; a kernel is built for each.
    """

    points: int = 16
    steps: int = 26_000
    duration: float = 5.0
    iterations: tuple[int, ...] = (1, 10, 100, 1000)

    def along(self, ends: tuple[float, float], most: int | None = None) -> Array:
        """Values of an axis, evenly in their logarithm."""
        count = self.points if most is None else min(self.points, most)
        return np.asarray(np.geomspace(*ends, count))

    def some(self, values: tuple[float, ...]) -> Array:
        """At most half as many of some values as an axis has points, their ends among them."""
        count = min(max(2, self.points // 2), len(values))
        shown = np.linspace(0, len(values) - 1, count).round().astype(int)
        return np.array([values[at] for at in shown])


@dataclasses.dataclass(frozen=True)
class LaneGrid:
    """Lanes of a map.

    Attributes:
        lanes: The lanes.
        motions: Their ground motions.
        inputs: What sets them apart, one row a lane, units in the column names.
        free: Whether a lane's base stands still, shape [lane].
        held: Energy at the start above the flat state [J], shape [lane].
    """

    lanes: Lanes
    motions: GroundMotions
    inputs: pd.DataFrame
    free: npt.NDArray[np.bool_]
    held: Array


def _cross(**axes: Iterable[Hashable]) -> pd.DataFrame:
    """One row for each set of values, the last axis the fastest."""
    values = [list(each) for each in axes.values()]
    return pd.MultiIndex.from_product(values, names=list(axes)).to_frame(index=False)


def _single_blocks(inputs: pd.DataFrame, motions: GroundMotions | None = None) -> LaneGrid:
    """Single blocks from the columns slenderness, height_m, start_ratio and friction, if given."""
    height = inputs["height_m"].to_numpy(float)
    width = height / inputs["slenderness"].to_numpy(float)
    angle = rocking.slenderness_angle(width, height)
    start = angle * inputs["start_ratio"].to_numpy(float)
    count = len(inputs)
    friction = inputs.get("friction", pd.Series(np.full(count, HOLDING_FRICTION)))
    lanes = Lanes(
        width=width,
        height=height,
        depth=np.full(count, DEPTH),
        density=np.full(count, DENSITY),
        friction=friction.to_numpy(float),
        chamfer=np.zeros(count),
        offset=np.zeros(count),
        rotation_start=start,
        angular_restitution=rocking.angular_restitution(angle),
    )
    still = motions is None
    return LaneGrid(
        lanes=lanes,
        motions=StillBase(count) if motions is None else motions,
        inputs=inputs,
        free=np.full(count, still) if still else inputs["amplitude_g"].to_numpy(float) == 0.0,
        held=rocking.energy(width, height, lanes.depth, lanes.density, start, 0.0),
    )


def release_blocks(size: AtlasSize) -> LaneGrid:
    """Single blocks of every slenderness and height let go from every rotation."""
    return _single_blocks(
        _cross(
            slenderness=size.along(SLENDERNESS),
            height_m=size.along(HEIGHTS, max(2, size.points // 2)),
            start_ratio=size.some(STARTS),
        )
    )


def release_evenly_wide(size: AtlasSize) -> LaneGrid:
    """Single blocks of one width and every slenderness let go."""
    inputs = _cross(
        slenderness=size.along(SLENDERNESS, 6), start_ratio=size.some((1e-3, 0.03, 0.2, 0.9))
    )
    return _single_blocks(inputs.assign(height_m=STIFFNESS_WIDTH * inputs["slenderness"]))


def _sines(inputs: pd.DataFrame) -> GroundMotions:
    """Bursts of sine from the columns amplitude_g, frequency_hz and control."""
    frequency = inputs["frequency_hz"].to_numpy(float)
    control = inputs["control"].to_numpy(str)
    rate = np.where(control == Control.DISPLACEMENT, 2.0 * np.pi * frequency, 1.0)
    return harmonic_motions(
        Waveform.SINE,
        control,
        GRAVITY * inputs["amplitude_g"].to_numpy(float) / rate**2,
        frequency,
        np.zeros(len(inputs)),
        CYCLES / frequency,
    )


def shaken(size: AtlasSize) -> LaneGrid:
    """Single blocks at rest under sine bursts of every amplitude and frequency."""
    inputs = _cross(
        amplitude_g=size.along(AMPLITUDES),
        frequency_hz=size.along(FREQUENCIES),
        control=[str(Control.ACCELERATION), str(Control.DISPLACEMENT)],
        slenderness=size.some((0.5, 2.0, 5.0, 12.0)),
    ).assign(height_m=1.0, start_ratio=0.0)
    return _single_blocks(inputs, _sines(inputs))


def sliding(size: AtlasSize) -> LaneGrid:
    """Single blocks let go or shaken on every friction."""
    scenes = pd.DataFrame(
        {
            "start_ratio": [0.03, 0.5, 0.9, 0.0, 0.0],
            "amplitude_g": [0.0, 0.0, 0.0, 0.5, 2.0],
            "frequency_hz": [1.0, 1.0, 1.0, 1.0, 3.0],
        }
    ).assign(control=str(Control.ACCELERATION), height_m=1.0)
    inputs = _cross(
        friction=[0.0, *size.along(FRICTIONS)[1:]], slenderness=size.along(SLENDERNESS)
    ).merge(scenes, how="cross")
    return _single_blocks(inputs, _sines(inputs))


def stack_pairs(size: AtlasSize) -> LaneGrid:
    """Two blocks of every mass ratio let go in several ways."""
    inputs = _cross(
        mass_ratio=size.along(MASS_RATIOS, 9),
        turned=list(STACK_TURNS),
        start_ratio=size.some((0.01, 0.1, 0.2, 0.4)),
        height_m=size.some((0.05, 0.5, 5.0, 50.0)),
    )
    count = len(inputs)
    height = np.tile(inputs["height_m"].to_numpy(float)[:, None], 2)
    width = height / STACK_SLENDERNESS
    factor = np.sqrt(inputs["mass_ratio"].to_numpy(float))
    density = DENSITY * np.stack([1.0 / factor, factor], axis=1)
    turn = np.array([STACK_TURNS[name] for name in inputs["turned"]])
    start = turn * inputs["start_ratio"].to_numpy(float)[:, None] / STACK_SLENDERNESS
    lanes = Lanes(
        width=width,
        height=height,
        depth=np.full((count, 2), DEPTH),
        density=density,
        friction=np.full((count, 2), HOLDING_FRICTION),
        chamfer=np.zeros((count, 2)),
        offset=np.zeros((count, 2)),
        rotation_start=start,
        angular_restitution=np.ones(count),
    )
    free = np.full(count, True)
    return LaneGrid(lanes, StillBase(count), inputs, free, stack_energy(lanes))


def stack_energy(lanes: Lanes) -> Array:
    """Energy above the upright state of two blocks of one width let go from rest [J].

    Each block has its lower corner on the face beneath. With half sizes b and h the centre of the
    lower one is at h0 cos(t0) + b |sin(t0)|, and the upper one's
    h0 cos(t0) + h1 cos(t1) + b |sin(t1) - sin(t0)| above it.

    Args:
        lanes: Stacks of two.

    Returns:
        Shape [lane].
    """
    half = 0.5 * lanes.height
    sine, cosine = np.sin(lanes.rotation_start), np.cos(lanes.rotation_start)
    turned = np.abs(np.diff(sine, axis=1, prepend=0.0))
    drop = half * (cosine - 1.0)
    rise = drop + 0.5 * lanes.width * turned
    rise[:, 1] += rise[:, 0] + drop[:, 0]
    return np.asarray(GRAVITY * (lanes.mass * rise).sum(axis=1))
