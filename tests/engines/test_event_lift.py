"""`event`: when blocks, bodies and stacks at rest in the plane lift, however shortly."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from tests.shared.blocks import Array, make_lanes, make_stacks, sines
from tests.shared.marks import first
from tests.shared.planar_bodies import STEPPED, body_lanes
from tests.shared.stack_bodies import as_bodies
from tests.shared.vertical_motion import sampled
from warprock.engines.bodies import box_bodies
from warprock.model import rocking
from warprock.model.lanes import Lanes
from warprock.model.motion import Control, GroundMotions, HarmonicMotions, UprightMotions
from warprock.model.response import SOUND, Outcome, Response, SampleTimes, Status
from warprock.model.stacking import uplift_ratio
from warprock.running.batch import run_batch
from warprock.settings.engines import EventSettings
from warprock.units import GRAVITY

COUNT = 24
SHAPES = ("block", "body", "upright", "stack", "upright stack", "stack of bodies")
STEPS = (1e-3, 5e-3, 1.3e-2)
ON_EACH = [("block", step) for step in STEPS] + [
    pytest.param(shape, STEPS[1], marks=pytest.mark.thorough) for shape in SHAPES[1:]
]
"""Single blocks at steps below, near and above what a base changes in; others near it."""


def standing(shape: str, draw: np.random.Generator) -> tuple[Lanes, Array]:
    """Lanes at rest, and the acceleration to +x at which each is let go [m/s^2]."""
    if shape == "body":
        lanes = body_lanes(STEPPED, np.zeros(COUNT))
        # The corners at (-0.1, -0.5) and (0.15, -0.5): it tips over the one at -x.
        return lanes, np.full(COUNT, GRAVITY * 0.1 / 0.5)
    friction = np.where(draw.random(COUNT) < 0.3, 0.15, 2.0)
    if "stack" in shape:
        # Upper blocks stand towards -x, so that all tip over that end first.
        lanes = make_stacks(
            draw.uniform(0.2, 0.5, (COUNT, 2)),
            draw.uniform(0.3, 0.9, (COUNT, 2)),
            offset=np.stack([np.zeros(COUNT), draw.uniform(-0.06, 0.0, COUNT)], axis=1),
            friction=friction[:, None],
        )
        limit = np.minimum(uplift_ratio(lanes).min(axis=1), friction) * GRAVITY
        return as_bodies(lanes) if shape == "stack of bodies" else lanes, limit
    lanes = make_lanes(draw.uniform(0.2, 0.5, COUNT), 1.0, friction=friction)
    limit = rocking.uplift_acceleration(lanes.width, lanes.height)
    return lanes, np.minimum(limit, GRAVITY * friction)


def moved(shape: str, motions: HarmonicMotions) -> GroundMotions:
    """The motions, with a vertical one of no size where the shape asks for that."""
    if "upright" not in shape:
        return motions
    still = sines(Control.ACCELERATION, np.zeros(COUNT), motions.frequency, 8.0)
    return UprightMotions(motions, still)


def slid(found: Response) -> Array:
    """Which lanes slid."""
    return np.asarray((found["peak_slide"] > 0.0).reshape(COUNT, -1).any(axis=1))


@pytest.mark.parametrize(("shape", "step"), ON_EACH)
def test_a_crest_just_above_the_bound_is_never_missed(shape: str, step: float) -> None:
    draw = np.random.default_rng(7)
    lanes, limit = standing(shape, draw)
    excess = 10.0 ** draw.uniform(-6.0, -3.0, COUNT)
    frequency, start = draw.uniform(0.5, 8.0, COUNT), draw.uniform(0.0, 0.1, COUNT)
    phase = draw.uniform(0.0, 0.45 * np.pi, COUNT)
    w = 2.0 * np.pi * frequency
    motions = HarmonicMotions(
        start=start,
        stop=start + 0.8 / frequency,
        velocity_step_start=0.0 * w,
        velocity_step_stop=0.0 * w,
        velocity_final=0.0 * w,
        frequency=frequency,
        acceleration_amplitude=limit * (1.0 + excess),
        phase=phase,
        velocity_offset=limit * (1.0 + excess) / w * np.cos(phase),
    )
    found = run_batch(
        "event",
        lanes,
        moved(shape, motions),
        SampleTimes(float(np.max(start + (0.45 * np.pi) / w + 0.25 / frequency)), None),
        settings=EventSettings(time_step=step),
    )
    assert np.all(np.isin(found["status"], SOUND))
    lifts = start + (np.arcsin(1.0 / (1.0 + excess)) - phase) / w
    slides = slid(found)
    assert np.all(np.isfinite(found["uplift_time"]) | slides)
    # Excess and phase are known to 2e-16: the time before the crest to a hundredth of 1e-9 of it.
    np.testing.assert_allclose(found["uplift_time"][~slides], lifts[~slides], rtol=0.0, atol=1e-10)
    tips = lanes.friction.reshape(COUNT, -1)[:, 0] * GRAVITY > 1.001 * limit
    assert np.all(found["peak_rotation"][tips].reshape(np.sum(tips), -1).max(axis=1) > 0.0)


@pytest.mark.parametrize(("shape", "step"), ON_EACH)
def test_a_crest_just_below_the_bound_moves_nothing(shape: str, step: float) -> None:
    draw = np.random.default_rng(8)
    lanes, limit = standing(shape, draw)
    less = 1.0 - 10.0 ** draw.uniform(-12.0, -3.0, COUNT)
    motions = sines(Control.ACCELERATION, limit * less, draw.uniform(0.5, 8.0, COUNT), 0.45)
    found = run_batch(
        "event", lanes, moved(shape, motions), SampleTimes(0.4, None),
        settings=EventSettings(time_step=step),
    )  # fmt: skip
    assert np.all(np.isin(found["status"], SOUND))
    # A base that is stopped at some speed kicks the block, which then lifts or slides.
    lifted = np.isfinite(found["uplift_time"]) & (found["uplift_time"] < 0.449 / motions.frequency)
    assert not np.any(lifted)


@pytest.mark.parametrize(("shape", "step"), ON_EACH)
def test_a_sample_just_above_the_bound_is_never_missed(shape: str, step: float) -> None:
    draw = np.random.default_rng(9)
    lanes, limit = standing(shape, draw)
    excess = 10.0 ** draw.uniform(-6.0, -3.0, COUNT)
    interval, crest = 0.02, 6
    rise = np.interp(np.arange(12.0), [0.0, 2.0, crest, 8.0, 11.0], [0.0, -0.3, 1.0, 0.0, 0.0])
    along = sampled(np.multiply.outer(limit * (1.0 + excess), rise), interval)
    motions: GroundMotions = along
    if "upright" in shape:
        motions = UprightMotions(along, sampled(np.zeros((COUNT, 12)), interval))
    found = run_batch(
        "event", lanes, motions, SampleTimes(0.2, None), settings=EventSettings(time_step=step)
    )
    assert np.all(np.isin(found["status"], SOUND))
    slope = 1.3 / ((crest - 2) * interval)
    lifts = crest * interval - excess / (1.0 + excess) / slope
    slides = slid(found)
    assert np.all(np.isfinite(found["uplift_time"]) | slides)
    np.testing.assert_allclose(found["uplift_time"][~slides], lifts[~slides], rtol=0.0, atol=1e-14)


@pytest.mark.parametrize(("shape", "step"), ON_EACH)
def test_a_lift_is_found_to_round_off(shape: str, step: float) -> None:
    draw = np.random.default_rng(10)
    lanes, limit = standing(shape, draw)
    size = limit * draw.uniform(1.01, 4.0, COUNT)
    motions = sines(Control.ACCELERATION, size, draw.uniform(0.5, 8.0, COUNT), 2.0)
    found = run_batch(
        "event", lanes, moved(shape, motions), SampleTimes(0.6, None),
        settings=EventSettings(time_step=step),
    )  # fmt: skip
    lifts = np.arcsin(limit / size) / (2.0 * np.pi * motions.frequency)
    tips = lanes.friction.reshape(COUNT, -1)[:, 0] * GRAVITY > 1.001 * limit
    np.testing.assert_allclose(found["uplift_time"][tips], lifts[tips], rtol=1e-13)


@pytest.mark.thorough
@pytest.mark.parametrize("shape", SHAPES[2:5:2])
def test_a_base_that_falls_away_lets_go_to_round_off(shape: str) -> None:
    draw = np.random.default_rng(11)
    lanes, _limit = standing(shape, draw)
    excess = 10.0 ** draw.uniform(-6.0, -0.5, COUNT)
    frequency = draw.uniform(0.5, 8.0, COUNT)
    falls = sines(Control.ACCELERATION, -GRAVITY * (1.0 + excess), frequency, 2.0)
    still = sines(Control.ACCELERATION, 0.0 * excess, frequency, 2.0)
    found = run_batch(
        "event", lanes, UprightMotions(still, falls), SampleTimes(0.6, None),
        settings=EventSettings(time_step=STEPS[1]),
    )  # fmt: skip
    assert np.all(np.isin(found["status"], SOUND))
    lets_go = np.arcsin(1.0 / (1.0 + excess)) / (2.0 * np.pi * frequency)
    np.testing.assert_allclose(found["uplift_time"], lets_go, rtol=0.0, atol=1e-10)


@pytest.mark.parametrize("shape", first(1, ["block", "body", "stack"]))
def test_a_crest_that_reaches_its_bound_to_round_off_ends_no_step_twice(shape: str) -> None:
    count = 200
    lanes = make_lanes(np.full(count, 0.02), 2.0, friction=5.0)
    bound = GRAVITY * np.tan(lanes.slenderness_angle)
    if shape == "body":
        lanes = dataclasses.replace(lanes, body=box_bodies(lanes))
    elif shape == "stack":
        lanes = make_stacks(0.02, np.ones((count, 2)), friction=5.0)
        bound = GRAVITY * uplift_ratio(lanes).min(axis=1)
    amplitude = bound * (1.0 + np.linspace(-4e-16, 4e-16, count))
    frequency = np.linspace(0.25, 4.0, count)
    motions = sines(Control.ACCELERATION, amplitude, frequency, 1.0)
    found = run_batch("event", lanes, motions, SampleTimes(5.0))
    assert np.all(found["status"] == Status.OK)
    assert np.all(found["outcome"] == Outcome.AT_REST)
    assert found["step_count"].max() < 10_000
