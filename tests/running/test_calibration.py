"""Factors of the error estimates: where they come from, and that they cover the true errors."""

from __future__ import annotations

import functools
import importlib.resources

import numpy as np
import numpy.typing as npt
import pandas as pd
import pytest

from tests.shared.blocks import make_lanes
from warprock.engines import ENGINES, engine_class
from warprock.model import rocking
from warprock.model.lanes import Lanes
from warprock.model.motion import Control, GroundMotions, Waveform, harmonic_motions
from warprock.model.response import Response, SampleTimes, Status
from warprock.running import calibration
from warprock.running.batch import run_batch
from warprock.running.calibration import (
    BLOCK,
    BODY,
    QUANTITIES,
    STACK,
    TABLE,
    Factors,
    estimate_factors,
)
from warprock.running.tolerance import run_to_tolerance
from warprock.settings.engines import EventSettings

Array = npt.NDArray[np.float64]

TIMES = SampleTimes(4.0, 5e-3)
COUNT = 96


@functools.cache
def pulses() -> tuple[Lanes, GroundMotions]:
    """One cycle of sines under all controls: blocks that rock, and slide where velocities step."""
    rng = np.random.default_rng(12)
    height = rng.uniform(0.4, 3.0, COUNT)
    width = height / rng.uniform(1.8, 6.0, COUNT)
    lanes = make_lanes(width, height, 0.0, rng.uniform(0.3, 1.3, COUNT))
    frequency = rng.uniform(0.8, 5.0, COUNT)
    acceleration = rocking.uplift_acceleration(width, height) * rng.uniform(1.1, 2.5, COUNT)
    orders = np.arange(COUNT) % 3
    controls = [(Control.ACCELERATION, Control.VELOCITY, Control.DISPLACEMENT)[k] for k in orders]
    amplitude = acceleration / (2.0 * np.pi * frequency) ** orders
    start = np.full(COUNT, 0.05)
    motions = harmonic_motions(
        Waveform.SINE, controls, amplitude, frequency, start, 1.0 / frequency
    )
    return lanes, motions


@functools.cache
def truth() -> Response:
    """Off by 1e-6 of the slenderness angle, as steps of `event` of 2e-5 s say."""
    lanes, motions = pulses()
    return run_batch("event", lanes, motions, TIMES, settings=EventSettings(time_step=1e-4))


def coverage(engine: str) -> dict[str, float]:
    """Share of the standing lanes `ok` whose true errors lie within their estimates."""
    lanes, motions = pulses()
    found, right = run_to_tolerance(engine, lanes, motions, TIMES), truth()
    alpha = lanes.slenderness_angle
    rotation = np.abs(found["rotation"] - right["rotation"]).max(axis=1)
    chosen = (found["status"] == Status.OK) & (np.abs(right["rotation"]).max(axis=1) < 1.5)
    assert chosen.sum() > 0.7 * COUNT
    errors: dict[str, tuple[Array, Array]] = {
        "rotation_error": (rotation, alpha),
        "peak_rotation_error": (np.abs(found["peak_rotation"] - right["peak_rotation"]), alpha),
        "peak_slide_error": (np.abs(found["peak_slide"] - right["peak_slide"]), lanes.width),
    }
    return {
        name: float(np.mean(((error <= found[name]) | (error <= 1e-7 * size))[chosen]))
        for name, (error, size) in errors.items()
    }


@pytest.mark.parametrize("engine", ["event", pytest.param("impulse", marks=pytest.mark.thorough)])
def test_nineteen_lanes_of_twenty_err_by_less_than_their_estimates(
    engine: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = coverage(engine)
    # Measured: 0.953 or more of some 86 lanes; two more may err with another compiler.
    assert min(found.values()) >= 0.93, found
    # With the factor that all engines had, no floor, too few are of `impulse`.
    monkeypatch.setattr(calibration, "shipped_factors", dict)
    plain = coverage(engine)
    assert (min(plain.values()) < 0.93) == (engine == "impulse"), plain


def test_every_engine_with_an_order_has_its_factors() -> None:
    table = calibration.shipped_factors()
    # No factor of assemblies was measured: their estimates are as they come.
    ordered = [
        name
        for name in ENGINES
        if engine_class(name).order is not None and not engine_class(name).assemblies
    ]
    for engine in ordered:
        for name in ("free", "pulses", "records"):
            for quantity in QUANTITIES:
                known = (BLOCK, name, engine, quantity) in table
                assert known == ((name, engine) != ("records", "dem"))
    for scene in (BODY, STACK):
        for name in ("free", "pulses", "records"):
            assert (scene, name, "event", "rotation_error") in table
    for (scene, name, engine, quantity), factor in table.items():
        assert factor.factor >= 1.0
        assert 0.0 <= factor.floor <= 1e-2
        # Only records have factors of their own.
        if name == "free":
            assert table[scene, "pulses", engine, quantity] == factor
    found = estimate_factors("event", STACK, records=True)
    assert found.rotation == table[STACK, "records", "event", "rotation_error"]
    plain = [estimate_factors("dem", BLOCK, records=records) for records in (True, False)]
    assert plain[0] == plain[1]
    blocks = estimate_factors("xpbd", BLOCK, records=True)
    assert estimate_factors("xpbd", STACK, records=True) == blocks
    assert estimate_factors("no engine", BLOCK, records=False) == Factors()


def test_the_shipped_table_covers_what_is_said_of_it() -> None:
    file = importlib.resources.files("warprock.cases") / "estimate" / TABLE
    with file.open(encoding="utf-8") as stream:
        table = pd.read_csv(stream, comment="#")
    # Of dem a few dozen lanes have a known true answer; stacks miss events within steps.
    few, stacks = table["engine"] == "dem", table["scene"] == STACK
    exact = stacks & (table["engine"] == "event")
    assert np.all(table["covered"][~few & ~stacks] >= 0.95)
    assert np.all(table["covered"][few] >= 0.93)
    assert np.all(table["covered"][exact] >= 0.9)
    assert np.all(table["covered"][stacks] >= 0.83)
