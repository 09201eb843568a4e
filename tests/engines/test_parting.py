"""What planar engines that step through time say of uplift, impacts and rest."""

from __future__ import annotations

import numpy as np
import pytest

from tests.shared.blocks import make_lanes, make_stacks, sines, velocity_steps
from warprock.engines.launching import Form
from warprock.model import rocking
from warprock.model.lanes import Lanes, as_stacks
from warprock.model.motion import Control, HarmonicMotions, Waveform
from warprock.model.response import Outcome, Response, SampleTimes
from warprock.running.batch import run_batch
from warprock.settings.engines import DemSettings, EventSettings, ImpulseSettings
from warprock.units import GRAVITY

RIGID = ("impulse", "direct", "xpbd")
"""Engines whose contacts are rigid at their defaults."""
STEPPED = (*RIGID, "dem")
STEP = ImpulseSettings().time_step
"""Default time step of those three [s]."""
STIFF = DemSettings(normal_stiffness=1e12, shear_stiffness=1e12, subcontacts=2)
FIRM = DemSettings(normal_stiffness=1e10, shear_stiffness=1e10, subcontacts=2)
"""Stiff enough for a slide: it ends within a step of the rigid engines."""

FORMS = [
    pytest.param(
        engine,
        form,
        marks=pytest.mark.thorough if form == "stack" and engine != "xpbd" else (),
    )
    for engine in RIGID
    for form in ("packed", "stack")
]
"""Engines, and whether a block runs alone or as a stack of one, which has a kernel of its own in
`impulse` and `direct`. Packed and plain forms are held to one another in `test_forms.py`."""


def answer(
    engine: str, form: str, lanes: Lanes, motions: HarmonicMotions, duration: float
) -> Response:
    """Of single blocks in a form of the kernel, or of stacks of one."""
    stacked = form == "stack"
    return run_batch(
        engine,
        as_stacks(lanes) if stacked else lanes,
        motions,
        SampleTimes(duration),
        form=None if stacked else Form(form),
        workers=1,
    )


def started_at_once(count: int, friction: float) -> tuple[Lanes, HarmonicMotions]:
    """Blocks of many sizes on bases whose acceleration begins with a step that lifts none."""
    random = np.random.default_rng(5)
    height = np.exp(random.uniform(np.log(0.1), np.log(10.0), count))
    angle = random.uniform(0.05, 0.7, count)
    lanes = make_lanes(height * np.tan(angle), height, friction=friction)
    size = random.uniform(0.5, 0.99, count) * GRAVITY * np.tan(angle)
    frequency = np.exp(random.uniform(np.log(0.3), np.log(10.0), count))
    return lanes, sines(Control.ACCELERATION, size, frequency, 3.0, Waveform.COSINE)


@pytest.mark.parametrize(("engine", "form"), FORMS)
def test_what_does_not_lift_never_moved(engine: str, form: str) -> None:
    # Sweeps that end early let corners hop by up to 0.42 g dt^2 when such a motion sets in.
    for friction in (1.0, 3.0):
        lanes, motions = started_at_once(32, friction)
        response = answer(engine, form, lanes, motions, 0.25)
        assert np.all(np.isnan(response["uplift_time"]))
        assert np.all(response["impact_count"] == 0)
        assert np.all(response["rest_time"] == 0.0)


def fallen_under_pulses(count: int, friction: float) -> tuple[Lanes, HarmonicMotions]:
    """Blocks under whole sines strong enough for most to overturn, with an impact or without."""
    random = np.random.default_rng(2)
    height = np.exp(random.uniform(np.log(0.5), np.log(3.0), count))
    angle = random.uniform(0.12, 0.35, count)
    lanes = make_lanes(height * np.tan(angle), height, friction=friction)
    rate = rocking.frequency_parameter(lanes.width, lanes.height)
    frequency = rate / (2.0 * np.pi) * random.uniform(1.0, 5.0, count)
    size = random.uniform(1.5, 6.0, count) * GRAVITY * np.tan(angle)
    return lanes, sines(Control.ACCELERATION, size, frequency, 1.0)


@pytest.mark.parametrize(("engine", "form"), FORMS)
def test_blocks_that_fall_count_the_impacts_before(engine: str, form: str) -> None:
    # High friction, for a corner that is about to leave slides whatever its friction.
    for friction in (1.0, 3.0, 10.0):
        lanes, motions = fallen_under_pulses(32, friction)
        reference = run_batch(
            "event",
            lanes,
            motions,
            SampleTimes(3.0),
            settings=EventSettings(time_step=1e-3),
            workers=1,
        )
        fell = reference["outcome"] == Outcome.OVERTURNED
        counts = reference["impact_count"][fell]
        assert np.count_nonzero(counts == 0) >= 5
        assert np.count_nonzero(counts == 1) >= 5
        response = answer(engine, form, lanes, motions, 3.0)
        np.testing.assert_array_equal(response["outcome"], reference["outcome"])
        np.testing.assert_array_equal(response["impact_count"][fell], counts)
        # The corner that a fast block turns about slides as far as friction lets it: of first
        # order in the step, at speeds of several m/s.
        gap = np.ravel(response["peak_slide"]) - np.ravel(reference["peak_slide"])
        assert np.max(np.abs(gap[fell])) <= 5e-3


def test_dem_counts_the_impacts_of_blocks_that_fall() -> None:
    lanes, motions = fallen_under_pulses(16, 3.0)
    times = SampleTimes(3.0)
    reference = run_batch("event", lanes, motions, times, workers=1)
    response = run_batch("dem", lanes, motions, times, workers=1)
    same = (reference["outcome"] == 2) & (response["outcome"] == 2)
    assert np.count_nonzero(same) >= 12
    np.testing.assert_array_equal(response["impact_count"][same], reference["impact_count"][same])


def test_stiff_springs_lift_as_a_rigid_block_does() -> None:
    ratio = np.array([0.5, 0.8, 0.95, 0.99, 1.02, 1.3])
    lanes = make_lanes(np.full(6, 0.25), 1.0)
    limit = rocking.uplift_acceleration(0.25, 1.0)
    motions = sines(Control.ACCELERATION, ratio * limit, 2.0, 1.0)
    response = run_batch("dem", lanes, motions, SampleTimes(0.3), settings=STIFF, workers=1)
    np.testing.assert_array_equal(np.isfinite(response["uplift_time"]), ratio > 1.0)
    assert np.all(response["impact_count"][ratio < 1.0] == 0)
    assert np.all(response["rest_time"][ratio < 1.0] == 0.0)


def sliding(engine: str, form: str, count: int) -> tuple[Lanes, HarmonicMotions, np.ndarray]:
    """Low blocks, or pairs of which the upper one sticks, on a base that steps its velocity.

    The last is the time that they slide for.
    """
    random = np.random.default_rng(3)
    height = random.uniform(0.5, 2.0, count)
    width = height * random.uniform(0.8, 1.2, count)
    friction = random.uniform(0.03, 0.2, count)
    speed = random.uniform(0.2, 1.0, count) * random.choice([-1.0, 1.0], count)
    lanes = make_lanes(width, height, friction=friction)
    if form == "stack":
        lanes = make_stacks(
            width[:, None] * [1.0, 0.8],
            height[:, None] * [0.6, 0.4],
            friction=np.stack([friction, np.full(count, 2.0)], axis=1),
        )
    zero = np.zeros(count)
    motions = velocity_steps(speed, zero, np.full(count, 100.0))
    return lanes, motions, np.abs(speed) / (friction * GRAVITY)


@pytest.mark.parametrize(
    ("engine", "form"),
    [
        pytest.param(
            engine,
            form,
            marks=pytest.mark.thorough if form == "stack" and engine != "impulse" else (),
        )
        for engine in STEPPED
        for form in ("single", "stack")
    ],
)
def test_what_slides_is_not_at_rest(engine: str, form: str) -> None:
    lanes, motions, until = sliding(engine, form, 8)
    settings = FIRM if engine == "dem" else None
    first = float(0.8 * until.min())
    response = run_batch(engine, lanes, motions, SampleTimes(first), settings=settings, workers=1)
    assert np.all(response["outcome"] == Outcome.ROCKING)
    assert np.all(np.isnan(response["rest_time"]))
    last = float(1.2 * until.max())
    response = run_batch(engine, lanes, motions, SampleTimes(last), settings=settings, workers=1)
    assert np.all(response["outcome"] == Outcome.AT_REST)
    # What slides by less than a tenth of g dt counts as at rest: three steps at the least
    # friction, and one for the step in which it stops.
    np.testing.assert_allclose(response["rest_time"], until, rtol=0.0, atol=5.0 * STEP)
