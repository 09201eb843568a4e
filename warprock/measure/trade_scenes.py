"""The fixed scenes on which engines are traded against one another, and how wrong a response is.

Friction is 1, that of the paper, throughout. Where it is enough for Housner's blocks not to slide
(free rocking, the record, the stack), errors are taken against the oracles, which share no code
with any engine. Under the sines it is not: the velocity steps of a displacement control need a
friction of 2.2 or more, and one of them would have to pull a block. There Housner's solution does
not hold, and errors are taken against `event` at a step of `FINE_STEP`. Inputs and lengths are such
that the lanes do not yet magnify small differences: what is measured is the error of a scheme, not
the chaos of rocking.
"""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from warprock.measure.bench import ERROR_DURATION, free_lanes
from warprock.model import rocking
from warprock.model.lanes import Lanes
from warprock.model.motion import (
    Control,
    GroundMotions,
    HarmonicMotions,
    MotionKind,
    StillBase,
    Waveform,
    harmonic_motions,
)
from warprock.model.response import Response, SampleTimes
from warprock.recordings import load_record, record_motions
from warprock.running.batch import run_batch
from warprock.settings.engines import EventSettings
from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]

FRICTION = 1.0
"""Friction of all scenes, that of the paper's Table 5."""

FINE_STEP = 1e-5
"""Step of `event` where it is the reference [s]. Runs at 2e-5 s and 5e-6 s differ by 2e-8 of the
slenderness angle; where nothing slides it is within 1e-6 of Housner's solution."""

SAMPLE_INTERVAL = 5e-3
"""Time between the samples at which errors are taken [s]."""

SINES = ((3.0, 8e-3), (3.3, 6e-3), (3.3, 8e-3), (5.0, 4e-3), (5.0, 5e-3), (5.0, 6e-3))
"""Frequency [Hz] and displacement amplitude [m] of the six inputs of the paper's Table 4."""

SINE_DURATION = 10.0
"""Length of the continuous sines [s]."""

RECORD = "ridgecrest-2019-ccc-090"
RECORD_SCALES = (0.46, 0.48, 0.5, 0.54, 0.59, 0.6)
"""Scales of the shipped record between uplift and fall. At those between them an error of 1e-6 in
the first impacts becomes one of 1e-2 (0.45, 0.55) or more; they would measure chaos."""

RECORD_DURATION = 30.0
"""Length that is run [s]: the strong motion, and a dozen seconds of rocking."""

STACK_SIZES = (0.35, 0.4, 0.45, 0.5)
STACK_FREQUENCIES = (3.3, 4.0, 5.0, 6.5)
"""Amplitudes [g] and frequencies [Hz] of the pulses under the stack; all of them are crossed."""

STACK_DURATION = 0.7
"""Length of its runs [s]: some ten impacts. In 1 s, errors grow tenfold in some lanes."""

PULSE_CYCLES = 2.0
"""Cycles of a sine up to which it is a pulse."""


def _solve_block(lanes: Lanes, motions: GroundMotions, times: SampleTimes) -> Response:
    """The oracle's response of single blocks; SciPy is imported when it is asked."""
    from warprock.oracle.block import oracle_response

    return oracle_response(lanes, motions, times)


def _solve_pair(lanes: Lanes, motions: GroundMotions, times: SampleTimes) -> Response:
    """The oracle's response of pairs of blocks; SciPy is imported when it is asked."""
    from warprock.oracle.pair_lanes import two_block_response

    return two_block_response(lanes, motions, times)


@dataclasses.dataclass(frozen=True)
class TradeScene:
    """One scene of the trade; its name is also that of the class that it stands for.

    Attributes:
        text: What it is.
        times: Duration and sampling.
        build: Gives its lanes and motions.
        solve: Gives the right response for them: the oracle's, or a fine one where blocks slide.
    """

    text: str
    times: SampleTimes
    build: Callable[[], tuple[Lanes, GroundMotions]]
    solve: Callable[[Lanes, GroundMotions, SampleTimes], Response] = _solve_block


def _fill(shape: tuple[int, ...], width: npt.ArrayLike, height: npt.ArrayLike) -> Lanes:
    """Blocks of the paper's stone at rest, some for each lane or one."""
    parts = {"width": width, "height": height, "depth": 0.5, "density": 2670.0}
    parts |= {"friction": FRICTION, "chamfer": 0.0, "offset": 0.0, "rotation_start": 0.0}
    columns: dict[str, Any] = {
        name: np.array(np.broadcast_to(part, shape), float) for name, part in parts.items()
    }
    angle = rocking.slenderness_angle(columns["width"], columns["height"])
    restitution = rocking.angular_restitution(angle) if len(shape) == 1 else np.ones(shape[0])
    return Lanes(**columns, angular_restitution=restitution)


def _single_blocks(count: int) -> Lanes:
    """The block of the paper's Tables 4 to 7."""
    return _fill((count,), 0.17, 1.0)


def _free() -> tuple[Lanes, GroundMotions]:
    return free_lanes(9), StillBase(9)


def _sines(cycles: float | None) -> tuple[Lanes, GroundMotions]:
    """Displacement-controlled sines: some cycles of them, or longer than the run."""
    frequency, amplitude = np.array(SINES).T
    count = len(frequency)
    duration = np.full(count, 2.0 * SINE_DURATION) if cycles is None else cycles / frequency
    control = [Control.DISPLACEMENT] * count
    motions = harmonic_motions(
        Waveform.SINE, control, amplitude, frequency, np.zeros(count), duration
    )
    return _single_blocks(count), motions


def _record() -> tuple[Lanes, GroundMotions]:
    count = len(RECORD_SCALES)
    motions = record_motions(
        [load_record(RECORD)],
        index=np.zeros(count, dtype=np.intp),
        scale=np.array(RECORD_SCALES),
        start=np.zeros(count),
    )
    return _single_blocks(count), motions


def _stack() -> tuple[Lanes, GroundMotions]:
    """The paper's two blocks without chamfers, as deep as each other, under one-cycle sines."""
    size, frequency = (part.ravel() for part in np.meshgrid(STACK_SIZES, STACK_FREQUENCIES))
    count = len(size)
    control = [Control.ACCELERATION] * count
    motions = harmonic_motions(
        Waveform.SINE, control, GRAVITY * size, frequency, np.zeros(count), 1.0 / frequency
    )
    return _fill((count, 2), (0.2, 0.15), 0.6), motions


def fine_response(lanes: Lanes, motions: GroundMotions, times: SampleTimes) -> Response:
    """The response of `event` at a fine step: the reference where blocks slide."""
    return run_batch("event", lanes, motions, times, settings=EventSettings(time_step=FINE_STEP))


TRADE_SCENES: dict[str, TradeScene] = {
    "free": TradeScene(
        "blocks B1 to B3 let go from 0.2, 0.5 and 0.99 of the slenderness angle, 5 s",
        SampleTimes(ERROR_DURATION, SAMPLE_INTERVAL),
        _free,
    ),
    "pulse": TradeScene(
        "one-cycle sines of Table 4, displacement control, 5 s",
        SampleTimes(5.0, SAMPLE_INTERVAL),
        functools.partial(_sines, 1.0),
        fine_response,
    ),
    "sine": TradeScene(
        "continuous sines of Table 4, displacement control, 10 s",
        SampleTimes(SINE_DURATION, SAMPLE_INTERVAL),
        functools.partial(_sines, None),
        fine_response,
    ),
    "record": TradeScene(
        "the shipped Ridgecrest record at six scales, 30 s",
        SampleTimes(RECORD_DURATION, SAMPLE_INTERVAL),
        _record,
    ),
    "stack": TradeScene(
        "two blocks under sixteen one-cycle sines, 0.7 s",
        SampleTimes(STACK_DURATION, SAMPLE_INTERVAL),
        _stack,
        _solve_pair,
    ),
}
"""Class of scene -> the scene that stands for it."""


def scene_class(lanes: Lanes, motions: GroundMotions) -> str:
    """The class of scene that lanes and their motions belong to: a key of `TRADE_SCENES`."""
    if lanes.stacked:
        return "stack"
    if isinstance(motions, HarmonicMotions):
        cycles = (motions.stop - motions.start) * motions.frequency
        return "pulse" if np.all(cycles <= PULSE_CYCLES + 1e-9) else "sine"
    return {MotionKind.STILL: "free", MotionKind.RECORD: "record"}.get(motions.kind, "pulse")


def lane_errors(response: Response, reference: Response, lanes: Lanes) -> Array:
    """Largest |rotation difference| / slenderness angle of every lane over its run and its blocks.

    Args:
        response: An engine's response, with histories.
        reference: The right one, at the same times.
        lanes: The lanes of both.

    Returns:
        Shape [lane]; infinite where the engine has no answer.
    """
    gap = np.abs(response["rotation"] - reference["rotation"]).max(axis=-1)
    ratio = (gap / lanes.slenderness_angle).reshape(lanes.lane_count, -1).max(axis=1)
    return np.where(np.isfinite(ratio), ratio, np.inf)
