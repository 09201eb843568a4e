"""`event`: second order to Housner through impacts, sliding, rest, closed forms, vector code."""

from __future__ import annotations

import time
from collections.abc import Sequence

import numpy as np
import pytest

from tests.shared import closed_forms
from tests.shared.blocks import Array, free_lanes, make_lanes, sines, velocity_steps
from tests.shared.speed import require_gain
from warprock.case.lanes import expand_lanes
from warprock.case.load import load_case
from warprock.engines import event
from warprock.engines.energy import energy_held
from warprock.engines.launching import Form
from warprock.model import rocking
from warprock.model.lanes import Lanes
from warprock.model.motion import Control, GroundMotions, StillBase
from warprock.model.response import SOUND, Outcome, Response, SampleTimes, Status
from warprock.recordings import load_record, record_motions
from warprock.running.batch import run_batch
from warprock.settings.engines import EventSettings
from warprock.units import GRAVITY

STEPS = np.array([1e-2, 5e-3, 2e-3, 1e-3])


def respond(
    lanes: Lanes, motions: GroundMotions, times: SampleTimes, step: float, **settings: float
) -> Response:
    """Response of `event` at a time step [s], every lane sound."""
    response = run_batch(
        "event", lanes, motions, times, settings=EventSettings(time_step=step, **settings)
    )
    assert np.all(np.isin(response["status"], SOUND))
    return response


def errors(
    lanes: Lanes, motions: GroundMotions, times: SampleTimes, steps: Sequence[float] = STEPS
) -> Array:
    """Largest |rotation - housner| / slenderness angle, shape [step, lane]."""
    reference = run_batch("housner", lanes, motions, times)["rotation"]
    found = [respond(lanes, motions, times, float(step))["rotation"] for step in steps]
    gap = np.abs(np.stack(found) - reference).max(axis=2)
    return np.asarray(gap / lanes.slenderness_angle)


def orders(found: Array) -> Array:
    """Slope of log(error) over log(step) of every lane."""
    return np.asarray(np.polyfit(np.log(STEPS), np.log(found), 1)[0])


def test_free_rocking_is_followed_to_the_swings_that_resting_leaves_out() -> None:
    found = errors(free_lanes(), StillBase(9), SampleTimes(5.0, 0.01))
    # Rest begins below 1e-6 of the slenderness angle. Until then blocks follow polynomials.
    assert np.max(found) <= 1e-6


def test_free_rocking_is_of_fifth_order_through_all_impacts() -> None:
    lanes, times = make_lanes(np.full(2, 1.0), np.array([5.0, 5.5]), 0.5), SampleTimes(5.0, 0.01)
    found = errors(lanes, StillBase(2), times, steps=(2.5e-2, 1.25e-2, 6.25e-3))
    assert np.max(found[0]) <= 3e-7
    # Polynomials take four times as long steps: 0.1 s is a sixth of 1 / p, which is not yet as
    # small as an order asks for.
    assert np.min(np.log2(found[0] / found[1])) >= 4.0
    assert np.min(np.log2(found[1] / found[2])) >= 4.5


def test_displacement_reading_of_table_6_within_a_thousandth_at_500_steps_a_second() -> None:
    pulse = expand_lanes(load_case("single-sine-pulse", ["contact.friction=10"]))
    part = slice(0, 6)
    lanes, motions = pulse.lanes.take(part), pulse.motions.take(part)
    times = SampleTimes(1.0, 0.01)
    reference = run_batch("housner", lanes, motions, times)
    response = respond(lanes, motions, times, 2e-3)
    # The peaks come before the stop of the pulse, where the pivot would have to pull the block
    # down: there the block leaves the base and Housner does not hold.
    assert np.all(reference["peak_time"] < motions.stop)
    np.testing.assert_allclose(response["peak_rotation"], reference["peak_rotation"], rtol=1e-3)
    # A turning point lies at (p dt)^2 of a swing's length.
    np.testing.assert_allclose(response["peak_time"], reference["peak_time"], atol=2e-5)


@pytest.mark.parametrize("control", list(Control))
def test_pulses_are_second_order(control: Control) -> None:
    frequency = np.linspace(2.6, 4.4, 6)
    swing = 0.37 / (2.0 * np.pi * frequency) * GRAVITY
    size = {
        Control.DISPLACEMENT: swing / (2.0 * np.pi * frequency),
        Control.VELOCITY: swing,
        Control.ACCELERATION: swing * 2.0 * np.pi * frequency,
    }[control]
    lanes = make_lanes(np.full(6, 0.17), 1.0, friction=10.0)
    motions = sines(control, size, frequency, 1.0, start=0.1)
    found = errors(lanes, motions, SampleTimes(1.0, 0.01))
    # At 1e-2 s a cycle has 23 to 38 steps: (2 pi / 23)^2 / 12 = 6e-3 of the swing.
    assert np.max(found[0]) <= 1e-2
    assert np.max(found[3]) <= 1e-4
    # A single lane's impacts fall differently in their steps; the mean of six shows the order.
    assert orders(np.mean(found, axis=1)[:, None])[0] >= 1.8


def test_uplift_is_located() -> None:
    lanes = make_lanes(np.full(4, 0.2), 1.0, friction=2.0)
    motions = sines(Control.ACCELERATION, 0.3 * GRAVITY, np.array([1.0, 2.0, 3.0, 4.0]), 1.0)
    times = SampleTimes(0.5)
    expected = run_batch("housner", lanes, motions, times)["uplift_time"]
    coarse, fine = (respond(lanes, motions, times, step)["uplift_time"] for step in (5e-3, 1e-3))
    # A secant through the ends of the step: w^2 dt^2 / 8 of it, and a thousandth of the step.
    assert np.max(np.abs(coarse - expected)) <= 1e-4
    assert np.max(np.abs(fine - expected)) <= 4e-6


@pytest.mark.thorough
def test_record_is_followed() -> None:
    record = load_record("ridgecrest-2019-ccc-090")
    lanes = make_lanes(np.full(2, 0.4), 2.0, friction=2.0)
    motions: GroundMotions = record_motions(
        [record], index=np.zeros(2, np.int64), scale=np.array([0.5, 0.6]), start=np.zeros(2)
    )
    found = errors(lanes, motions, SampleTimes(22.0, 0.01))
    # Ten impacts magnify an error; it still falls with the square of the step (25 from 5e-3 s on,
    # here less, because knots every 10 ms cut the steps).
    assert np.max(found[3]) <= 2e-3
    assert np.all(found[1] >= 8.0 * found[3])


def test_block_slides_by_the_closed_form() -> None:
    # Friction below tan(alpha): the block slides and does not rock. Under a velocity step v it
    # slides v^2 / (2 mu g), against the step of the base, for v / (mu g).
    friction = np.array([0.05, 0.1, 0.2])
    speed = np.array([0.3, -0.2, 0.4])
    lanes = make_lanes(np.full(3, 1.0), 1.0, friction=friction)
    motions = velocity_steps(speed, np.zeros(3), np.full(3, 10.0))
    response = respond(lanes, motions, SampleTimes(2.0), 5e-3)
    # Even deceleration: the step is exact, so is the time at which sliding stops; round-off.
    expected = -np.sign(speed) * speed**2 / (2.0 * friction * GRAVITY)
    np.testing.assert_allclose(response["residual_slide"], expected, rtol=1e-12)
    np.testing.assert_allclose(
        response["rest_time"], np.abs(speed) / (friction * GRAVITY), rtol=1e-12
    )
    assert np.all(response["peak_rotation"] == 0.0)
    assert np.all(response["outcome"] == Outcome.AT_REST)
    kinetic = 0.5 * lanes.density * lanes.width * lanes.height * lanes.depth * speed**2
    np.testing.assert_allclose(response["energy_lost"], kinetic, rtol=1e-12)


def test_shaken_block_slides_as_its_equation_says() -> None:
    # A base accelerating at 2 mu g for 0.5 s and then still in its velocity v: against the base
    # the block falls behind at mu g to -mu g 0.5, then stops after as long again.
    friction, time = 0.1, 0.5
    lanes = make_lanes(np.full(1, 1.0), 1.0, friction=friction)
    # A velocity-controlled cosine of half a turn has no simple sliding; a slow sine of large
    # amplitude under acceleration control is 2 mu g sin(w t) and is integrated here by itself.
    w = np.pi / time
    motions = sines(Control.ACCELERATION, 2.0 * friction * GRAVITY, w / (2.0 * np.pi), 0.5)
    first = np.arcsin(0.5) / w
    grip = friction * GRAVITY

    def speed(t: float) -> float:
        moved = 2.0 * grip / w * (np.cos(w * first) - np.cos(w * min(t, time)))
        return float(grip * (t - first) - moved)

    low, high = 0.5 * time, 3.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if speed(middle) < 0.0 else (low, middle)
    at = np.linspace(first, high, 20001)
    velocity = np.array([speed(float(t)) for t in at])
    expected = float(np.sum(0.5 * (velocity[1:] + velocity[:-1]) * np.diff(at)))
    error = [
        abs(respond(lanes, motions, SampleTimes(3.0), step)["residual_slide"][0] - expected)
        for step in (1e-2, 1e-3)
    ]
    # Second order: (w dt)^2 / 12 of the slide at 1e-2 s is 3e-4; a hundredth of it at 1e-3 s.
    assert error[0] <= 1e-3 * abs(expected)
    assert error[1] <= 1e-5 * abs(expected)


def test_sticking_block_does_not_slide_at_all() -> None:
    lanes = make_lanes(np.full(1, 0.2), 1.0, friction=1.0)
    motions = sines(Control.ACCELERATION, 0.25 * GRAVITY, 3.0, 1.0)
    response = respond(lanes, motions, SampleTimes(3.0), 5e-3)
    assert response["peak_rotation"][0] > 0.05 * lanes.slenderness_angle[0]
    assert response["peak_slide"][0] == 0.0


def test_low_friction_impacts_slide_and_impulse_agrees() -> None:
    # Too little friction for an impact without sliding.
    lanes = make_lanes(np.full(1, 0.5), 1.0, 0.5, friction=0.3)
    assert rocking.impact_friction(0.5, 1.0) > 0.3
    times = SampleTimes(1.0, 0.01)
    response = respond(lanes, StillBase(1), times, 1e-3)
    other = run_batch("impulse", lanes, StillBase(1), times)
    held = run_batch("housner", lanes, StillBase(1), times)
    gap = np.abs(response["rotation"] - other["rotation"]).max() / lanes.slenderness_angle[0]
    apart = np.abs(response["rotation"] - held["rotation"]).max() / lanes.slenderness_angle[0]
    # `impulse` is first order: some dt x g / (velocity at the impact) at 2e-4 s.
    assert gap <= 1e-2
    assert apart >= 3.0 * gap
    assert response["peak_slide"][0] > 1e-4
    np.testing.assert_allclose(response["peak_slide"], other["peak_slide"], rtol=5e-2)


def test_energy_never_grows_and_all_of_it_is_accounted_for() -> None:
    lanes = free_lanes()
    held = energy_held(lanes, lanes.rotation_start)
    for step in (1e-2, 1e-3):
        response = respond(lanes, StillBase(9), SampleTimes(10.0, 0.01), step)
        assert np.all(response["outcome"] == Outcome.AT_REST)
        # At rest all energy is lost in impacts; what the steps between them miss is second order.
        rate = rocking.frequency_parameter(lanes.width, lanes.height)
        assert np.all(np.abs(response["energy_lost"] / held - 1.0) <= 0.5 * (rate * step) ** 2)
        rotation = np.abs(response["rotation"])
        sign = np.signbit(response["rotation"])
        for lane in range(9):
            turns = np.flatnonzero(np.diff(sign[lane])) + 1
            peaks = [np.max(part) for part in np.split(rotation[lane], turns)]
            # A swing never climbs above the one before: the bound is round-off, impacts take
            # far more than the step's error.
            assert np.all(np.diff(peaks) <= 1e-12)


def test_energy_never_grows_at_the_extremes() -> None:
    rng = np.random.default_rng(3)
    count = 512
    height = 10.0 ** rng.uniform(np.log10(0.05), np.log10(50.0), count)
    slenderness = 10.0 ** rng.uniform(np.log10(0.3), np.log10(20.0), count)
    friction = np.where(rng.random(count) < 0.2, 0.0, 10.0 ** rng.uniform(-2.0, 1.0, count))
    ratio = rng.choice([-1.0, 1.0], count) * 10.0 ** rng.uniform(-6.0, np.log10(0.9999), count)
    lanes = make_lanes(height / slenderness, height, ratio, friction)
    scale = rocking.energy(lanes.width, lanes.height, lanes.depth, lanes.density, 0.0, 1.0)
    held = energy_held(lanes, lanes.rotation_start)
    for step in (1e-2, 1e-3):
        response = respond(lanes, StillBase(count), SampleTimes(3.0), step)
        assert np.all(response["peak_rotation"] <= np.abs(lanes.rotation_start))
        assert np.all(response["outcome"] != Outcome.OVERTURNED)
        # Neither friction nor impacts give energy: round-off of sums of squares of 1 rad/s.
        assert np.all(response["energy_lost"] >= -1e-12 * (held + scale))
    # Nor do they under a base that shakes and steps its velocity.
    frequency = 10.0 ** rng.uniform(-1.0, 1.5, count)
    motions = sines(Control.VELOCITY, 1.0, frequency, 2.25, start=0.1)
    response = respond(lanes, motions, SampleTimes(3.0), 5e-3)
    mass = lanes.density * lanes.width * lanes.height * lanes.depth
    assert np.all(response["energy_lost"] >= -1e-12 * (held + mass))


def test_flat_block_rests_for_a_minute_without_drift() -> None:
    lanes = make_lanes(np.full(2, 0.5), 1.0)
    flat = respond(lanes, StillBase(2), SampleTimes(60.0, 1.0), 5e-3)
    motions = sines(Control.ACCELERATION, np.full(2, 0.3 * GRAVITY), 2.0, 120.0)
    shaken = respond(lanes, motions, SampleTimes(60.0, 1.0), 5e-3)
    for response in (flat, shaken):
        assert np.all(response["rotation"] == 0.0)
        assert np.all(response["peak_slide"] == 0.0)
        assert np.all(response["rest_time"] == 0.0)
        assert np.all(response["energy_lost"] == 0.0)
    assert shaken["step_count"][0] >= 3000


def test_rest_follows_the_stated_rule() -> None:
    lanes = free_lanes()
    reference = run_batch("housner", lanes, StillBase(9), SampleTimes(10.0))
    for ratio in (1e-3, 1e-6):
        response = respond(lanes, StillBase(9), SampleTimes(10.0), 1e-3, rest_rotation_ratio=ratio)
        # The impacts left out are in the rest time: what remains is the error of the step.
        np.testing.assert_allclose(response["rest_time"], reference["rest_time"], atol=2e-4)
        assert np.all(response["impact_count"] < reference["impact_count"])


def test_quarter_period_to_the_square_of_the_step() -> None:
    lanes = make_lanes(np.full(3, 0.5), np.array([0.75, 1.0, 1.25]), 0.5)
    quarter = rocking.quarter_period(lanes.width, lanes.height, lanes.rotation_start)
    for lane in range(3):
        for sign, count in ((-1.0, 0), (1.0, 1)):
            # (p dt)^2 / 12 is 1e-5 of the quarter period at 5e-3 s.
            times = SampleTimes(float(quarter[lane] * (1.0 + sign * 4e-5)))
            assert respond(lanes, StillBase(3), times, 5e-3)["impact_count"][lane] == count


def test_overturning_velocity_step_at_its_limit() -> None:
    limit = float(closed_forms.overturning_velocity_step(0.3, 1.0))
    # The step of the base is exact; the swing that decides has an error of (p dt)^2.
    speed = limit * np.array([1.0 - 1e-4, 1.0 + 1e-4, -1.0 - 1e-4])
    lanes = make_lanes(np.full(3, 0.3), 1.0, friction=10.0)
    motions = velocity_steps(speed, np.zeros(3), np.full(3, 30.0))
    response = respond(lanes, motions, SampleTimes(8.0, 0.1), 5e-3)
    np.testing.assert_array_equal(response["outcome"] == Outcome.OVERTURNED, [False, True, True])
    np.testing.assert_allclose(response["peak_rotation"][1:], 0.5 * np.pi, rtol=1e-12)


def test_histories_finer_than_the_step_change_nothing() -> None:
    lanes = free_lanes()
    fine = respond(lanes, StillBase(9), SampleTimes(2.0, 5e-4), 5e-3)
    alone = respond(lanes, StillBase(9), SampleTimes(2.0), 5e-3)
    for name in ("peak_rotation", "impact_count", "energy_lost", "rest_time", "step_count"):
        np.testing.assert_array_equal(fine[name], alone[name], err_msg=name)
    reference = run_batch("housner", lanes, StillBase(9), SampleTimes(2.0, 5e-4))
    gap = np.abs(fine["rotation"] - reference["rotation"]).max(axis=1) / lanes.slenderness_angle
    assert np.max(gap) <= 3e-4


def test_stalled_lane_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(event, "STEPS_SPARE", 0.01)
    # One step of the hundred and twenty that 0.1 s may take.
    response = run_batch("event", free_lanes(), StillBase(9), SampleTimes(0.1))
    assert np.all(response["status"] == Status.EVENT_LIMIT)
    assert np.all(response["step_count"] == 1)


def steps_per_second(precision: str, form: Form) -> float:
    """Rate on slender blocks that rock all the time: one at rest waits in a single step."""
    count = 512
    lanes = make_lanes(np.full(count, 1.0), np.where(np.arange(count) % 2, 5.0, 5.5), 0.5)
    begin = time.perf_counter()
    response = run_batch(
        "event",
        lanes,
        StillBase(count),
        SampleTimes(5.0),
        settings=EventSettings(time_step=1e-3),
        precision=precision,
        form=form,
        workers=1,
        chunk_size=count,
    )
    return float(np.sum(response["step_count"])) / (time.perf_counter() - begin)


@pytest.mark.speed
@pytest.mark.parametrize("precision", ["float64", "float32"])
def test_packed_kernel_is_vectorised(precision: str) -> None:
    # A ratio within one run: without vector code the packed form is no faster than the plain one.
    expected = {"float64": 1.4, "float32": 2.0}[precision]
    steps_per_second(precision, Form.PLAIN)
    steps_per_second(precision, Form.PACKED)
    require_gain(
        lambda: 1.0 / max(steps_per_second(precision, Form.PLAIN) for _ in range(2)),
        lambda: 1.0 / max(steps_per_second(precision, Form.PACKED) for _ in range(2)),
        expected,
    )
