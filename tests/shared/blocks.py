"""Small batches that several engine tests share."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from warprock.engines import ENGINES, engine_class
from warprock.model import rocking
from warprock.model.lanes import Lanes, as_stacks
from warprock.model.motion import (
    Control,
    GroundMotions,
    HarmonicMotions,
    StillBase,
    Waveform,
    harmonic_motions,
)
from warprock.model.response import SampleTimes, Status
from warprock.model.scene import scene_kind
from warprock.running.batch import run_batch
from warprock.settings.engines import SETTINGS
from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]


def make_lanes(
    width: npt.ArrayLike,
    height: npt.ArrayLike,
    rotation_ratio: npt.ArrayLike = 0.0,
    friction: npt.ArrayLike = 1.0,
    angular_restitution: npt.ArrayLike | None = None,
) -> Lanes:
    """Lanes from full widths and heights [m], which broadcast against each other."""
    angle = np.arctan2(width, height)
    if angular_restitution is None:
        angular_restitution = rocking.angular_restitution(angle)
    parts = np.broadcast_arrays(
        width, height, 0.5, 2000.0, friction, 0.0, 0.0, rotation_ratio * angle, angular_restitution
    )
    return Lanes(*(np.array(np.atleast_1d(part), dtype=np.float64) for part in parts))


def make_stacks(
    width: npt.ArrayLike,
    height: npt.ArrayLike,
    *,
    rotation: npt.ArrayLike = 0.0,
    friction: npt.ArrayLike = 10.0,
    density: npt.ArrayLike = 2000.0,
    chamfer: npt.ArrayLike = 0.0,
    offset: npt.ArrayLike = 0.0,
) -> Lanes:
    """Stacks from values that broadcast to [lane, block]; with this friction nothing slides."""
    parts = np.broadcast_arrays(
        *(np.atleast_2d(v) for v in (width, height, 0.5, density, friction, chamfer, offset)),
        np.atleast_2d(rotation),
    )
    arrays = [np.array(part, dtype=np.float64) for part in parts]
    return Lanes(*arrays, angular_restitution=np.ones(len(arrays[0])))


def two_equal(lanes: Lanes) -> Lanes:
    """Two blocks of each lane, one on the other, let go as one."""
    stacks = as_stacks(lanes)
    parts = {
        name: np.repeat(each, 2, axis=1)
        for name, each in stacks.arrays.items()
        if name != "angular_restitution"
    }
    halved = 0.3 * parts.pop("rotation_start")
    return dataclasses.replace(stacks, rotation_start=halved, **parts)


def single_block_engines() -> list[str]:
    """Names of the engines that run single blocks."""
    scene = scene_kind(make_lanes(0.2, 1.0), StillBase(1), restitution_given=False)
    return [name for name in ENGINES if engine_class(name).supports(scene) is None]


every_height_of_stack = pytest.mark.parametrize(
    "count",
    [pytest.param(n, marks=() if n == 2 else pytest.mark.thorough) for n in (1, 2, 3)],
)
"""Stacks of one block to three, each number a kernel to compile: but for two blocks with
`thorough`, the least, and the first with a block that touches two others."""


def free_lanes() -> Lanes:
    """B1, B2 and B3 of the paper's Table 3, each from 0.2, 0.5 and 0.99 of the critical angle."""
    height = np.repeat([0.75, 1.0, 1.25], 3)
    return make_lanes(np.full(9, 0.5), height, np.tile([0.2, 0.5, 0.99], 3))


def sines(
    control: Control,
    amplitude: npt.ArrayLike,
    frequency: npt.ArrayLike,
    cycles: float,
    waveform: Waveform = Waveform.SINE,
    start: float = 0.0,
) -> HarmonicMotions:
    """Harmonic motions, one a lane; the amplitude is that of the controlled quantity, SI."""
    a, f = np.broadcast_arrays(np.atleast_1d(amplitude), np.atleast_1d(frequency))
    f = f.astype(np.float64)
    count = len(f)
    return harmonic_motions(
        waveform, [control] * count, a.astype(np.float64), f, np.full(count, start), cycles / f
    )


def ramp(speed: Array, duration: float) -> HarmonicMotions:
    """Bases that come to a velocity by half a sine of acceleration, in a time [s], and keep it."""
    zero = np.zeros_like(speed)
    return HarmonicMotions(
        start=zero, stop=zero + duration, velocity_step_start=zero, velocity_step_stop=zero,
        velocity_final=speed, frequency=zero + 0.5 / duration,
        acceleration_amplitude=0.5 * np.pi * speed / duration, phase=zero,
        velocity_offset=0.5 * speed,
    )  # fmt: skip


def velocity_steps(first: Array, second: Array, interval: Array) -> HarmonicMotions:
    """Two velocity steps [m/s] of a base that moves evenly between and stays still after."""
    zero = np.zeros_like(first)
    return HarmonicMotions(
        start=zero,
        stop=interval,
        velocity_step_start=first,
        velocity_step_stop=second,
        velocity_final=first + second,
        frequency=np.ones_like(first),
        acceleration_amplitude=zero,
        phase=zero,
        velocity_offset=first,
    )


def errors_to_housner(
    engine: str, lanes: Lanes, motions: GroundMotions, times: SampleTimes, **settings: Any
) -> Array:
    """Largest |rotation - housner| / slenderness angle of each lane; no lane fails."""
    reference = run_batch("housner", lanes, motions, times)
    given = SETTINGS[engine](**settings)
    response = run_batch(engine, lanes, motions, times, settings=given)
    assert np.all(response["status"] == Status.OK)
    gap = np.abs(response["rotation"] - reference["rotation"]).max(axis=1)
    return np.asarray(gap / lanes.slenderness_angle)


def at_rest(count: int) -> HarmonicMotions:
    """A base that does not move, as a pulse of no size.

    Kernels of analytic motions run it, which tests compile anyhow. Those of a still base are held
    to the same, of three engines, by `engines/test_contract_scenes.py`, `thorough`.
    """
    zero = np.zeros(count)
    return velocity_steps(zero, zero, zero)


def shakes(
    count: int, friction: tuple[float, float], seed: int = 5
) -> tuple[Lanes, HarmonicMotions]:
    """Random blocks under two cycles of a sine of 1.5 to 8 g, the velocity of which is given."""
    rng = np.random.default_rng(seed)
    height = 10.0 ** rng.uniform(-0.3, 0.5, count)
    width = height / rng.uniform(1.0, 6.0, count)
    lanes = make_lanes(width, height, friction=rng.uniform(*friction, count))
    rate = rocking.frequency_parameter(width, height)
    w = rate * 10.0 ** rng.uniform(0.0, 1.0, count)
    size = GRAVITY * rng.uniform(1.5, 8.0, count) * rng.choice([-1.0, 1.0], count)
    return lanes, sines(Control.VELOCITY, size / w, w / (2.0 * np.pi), cycles=2.0)
