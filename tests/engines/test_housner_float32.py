"""`housner` in float32, whose times are coarse: no lane stalls, errors are those of round-off."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from tests.shared.held import held_batch
from tests.shared.strips import strip_batch
from tests.shared.vertical_motion import sampled
from warprock.model.lanes import Lanes
from warprock.model.motion import GroundMotions, PlanarMotions, RecordMotions
from warprock.model.response import Response, SampleTimes, Status
from warprock.running.batch import run_batch
from warprock.units import GRAVITY

pytestmark = pytest.mark.thorough

OFF = 1e-6
"""Relative change of widths, some ten round-offs of float32."""
PARTS = (0.5, 0.75, 0.9, 0.95)
"""Of the lanes; the rest come close to their balance, and beyond any bound differ by anything."""

KINDS = {
    "wall": {"wall": True, "ties": 0},
    "ties": {"wall": False, "ties": 3, "load": True},
    "free": {"wall": False, "ties": 0},
}


def lanes_of(kind: str, count: int, seed: int) -> tuple[Lanes, PlanarMotions]:
    """Lanes of a kind, and pulses."""
    if kind == "strip":
        return strip_batch(count, seed)
    lanes, motions = held_batch(count, seed, **KINDS[kind])
    return (dataclasses.replace(lanes, hold=None) if kind == "free" else lanes), motions


def quakes(lanes: Lanes, seed: int) -> RecordMotions:
    """Noise of some 2 Hz, 10 s long, of up to thrice what lifts each block."""
    rng, count, interval = np.random.default_rng(seed), 1000, 0.01
    shape = (lanes.lane_count, count)
    spectrum = np.fft.rfft(rng.normal(size=shape), axis=1)
    spectrum *= np.exp(-0.5 * ((np.fft.rfftfreq(count, interval) - 2.0) / 2.0) ** 2)
    samples = np.fft.irfft(spectrum, count, axis=1) * np.sin(np.linspace(0.0, np.pi, count))
    strip = None if lanes.hold is None else lanes.hold.strip
    lifting = lanes.width / lanes.height if strip is None else strip.uplift_ratios.min(axis=1)
    peak = rng.uniform(0.8, 3.0, lanes.lane_count) * GRAVITY * lifting
    return sampled(samples * (peak / np.abs(samples).max(axis=1))[:, None], interval)


def off(lanes: Lanes, found: Response, exact: Response) -> list[float]:
    """By how much rotations differ at most in parts of the lanes, in slenderness angles."""
    gap = np.abs(found["rotation"] - exact["rotation"]).max(axis=1) / lanes.slenderness_angle
    return np.quantile(gap, PARTS).tolist()


def both(lanes: Lanes, motions: GroundMotions, duration: float) -> tuple[Response, Response]:
    """What float32 and float64 find."""
    times = SampleTimes(duration, 0.02)
    single, double = (
        run_batch("housner", lanes, motions, times, precision=f"float{bits}") for bits in (32, 64)
    )
    # A lane that makes no headway has the status EVENT_LIMIT.
    assert np.isin(single["status"], [Status.OK, Status.OUTSIDE_MODEL]).all()
    return single, double


@pytest.mark.parametrize(
    ("kind", "moves"),
    [
        ("free", "pulse"),
        ("wall", "record"),
        ("wall", "pulse"),
        ("ties", "pulse"),
        ("ties", "record"),
        ("free", "record"),
    ],
)
def test_float32_errs_less_than_a_width_off_by_some_round_offs(kind, moves):
    lanes, pulses = lanes_of(kind, 200, 1)
    motions = pulses if moves == "pulse" else quakes(lanes, 51)
    duration = 4.0 if moves == "pulse" else 10.0
    single, double = both(lanes, motions, duration)
    sign = np.random.default_rng(0).choice([-1.0, 1.0], lanes.lane_count)
    changed = dataclasses.replace(lanes, width=lanes.width * (1.0 + OFF * sign))
    other = run_batch("housner", changed, motions, SampleTimes(duration, 0.02))
    assert np.all(np.less(off(lanes, single, double), off(lanes, other, double)))


def test_no_strip_stalls_in_float32():
    lanes, pulses = lanes_of("strip", 100, 3)
    both(lanes, pulses, 4.0)


def test_no_block_at_rest_stalls_at_a_crest_of_its_base():
    # Some blocks in a thousand see a crest at a time that float32 tells from the next sample alone.
    lanes, pulses = lanes_of("free", 1500, 3)
    both(lanes, pulses, 4.0)
