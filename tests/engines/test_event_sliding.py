"""`event` where blocks slip, slide, stick and land inside its steps: order 2, right slides."""

from __future__ import annotations

import numpy as np
import pytest

from tests.shared.blocks import Array, make_lanes, sines
from tests.shared.sliding_motion import Case, motion
from warprock.case.lanes import expand_lanes
from warprock.case.load import load_case
from warprock.engines.launching import Form
from warprock.model.lanes import Lanes
from warprock.model.motion import Control, HarmonicMotions
from warprock.model.response import SOUND, Response, SampleTimes
from warprock.running.batch import run_batch
from warprock.settings.engines import EventSettings
from warprock.units import GRAVITY

DEFAULT = EventSettings().time_step
TIMES = SampleTimes(1.5, 0.01)
SLIDE_DUST = 1e-4
"""Slides are compared to a part of themselves and of this [m]: the time of a stop is of order 2."""


def respond(
    lanes: Lanes, motions: HarmonicMotions, step: float, form: Form | None = None
) -> Response:
    settings = EventSettings(time_step=step)
    response = run_batch("event", lanes, motions, TIMES, settings=settings, form=form)
    assert np.all(np.isin(response["status"], SOUND))
    return response


def random_pulses(
    control: Control, seed: int, count: int, grip: tuple[float, float] | None = None
) -> tuple[Lanes, HarmonicMotions]:
    """Blocks of 0.1 to 1 m under one cycle of a sine of 0.8 to 4 times what moves them.

    Their friction is 0.3 to 1.3, or inside `grip` times width / height.
    """
    rng = np.random.default_rng(seed)
    width, slenderness = rng.uniform(0.1, 1.0, count), rng.uniform(1.5, 6.0, count)
    friction, frequency = rng.uniform(0.3, 1.3, count), rng.uniform(1.0, 8.0, count)
    if grip is not None:
        friction = rng.uniform(*grip, count) / slenderness
    least = GRAVITY * np.minimum(1.0 / slenderness, friction)
    size = least * rng.uniform(0.8, 4.0, count)
    size = size / (2.0 * np.pi * frequency) ** (2 if control is Control.DISPLACEMENT else 0)
    lanes = make_lanes(width, width * slenderness, friction=friction)
    return lanes, sines(control, size, frequency, 1.0, start=0.1)


def case_of(lanes: Lanes, motions: HarmonicMotions, lane: int) -> Case:
    """One lane as the independent integration takes it."""
    start, stop = float(motions.start[lane]), float(motions.stop[lane])
    w = 2.0 * np.pi * float(motions.frequency[lane])
    amplitude, phase = float(motions.acceleration_amplitude[lane]), float(motions.phase[lane])

    def acceleration(time: float) -> float:
        inside = start <= time < stop
        return amplitude * float(np.sin(w * (time - start) + phase)) if inside else 0.0

    first, last = float(motions.velocity_step_start[lane]), float(motions.velocity_step_stop[lane])
    return Case(
        b=0.5 * float(lanes.width[lane]),
        h=0.5 * float(lanes.height[lane]),
        mu=float(lanes.friction[lane]),
        acceleration=acceleration,
        steps=((start, first), (stop, last)),
    )


def rotation_error(found: Array, expected: Array, lanes: Lanes) -> Array:
    """Largest error of every lane / slenderness angle."""
    return np.asarray(np.abs(found - expected).max(axis=1) / lanes.slenderness_angle)


def slide_error(found: Array, expected: Array) -> Array:
    return np.asarray(np.abs(found - expected) / (expected + SLIDE_DUST))


@pytest.mark.parametrize(
    ("control", "grip"),
    [
        (Control.DISPLACEMENT, None),
        pytest.param(Control.ACCELERATION, (1.02, 1.4), marks=pytest.mark.thorough),
    ],
)
def test_rotations_and_slides_are_those_of_an_independent_integration(
    control: Control, grip: tuple[float, float] | None
) -> None:
    # Velocity steps make the one kind slide, a friction that hardly lets it rock the other.
    count = 6 if grip else 4
    lanes, motions = random_pulses(control, 21, count, grip)
    at = np.arange(151) * 0.01
    parts = [motion(case_of(lanes, motions, lane), at) for lane in range(count)]
    rotations, slides = np.array([part[0] for part in parts]), np.array([part[1] for part in parts])
    assert np.sum(slides > 1e-4) >= count // 2
    # Order 2: an error of some 2e-3 at 5e-3 s is 1e-6 at 1e-4 s.
    for step, most in ((DEFAULT, 5e-3), (1e-4, 5e-6)):
        response = respond(lanes, motions, step)
        found = np.clip(response["rotation"], -0.5 * np.pi, 0.5 * np.pi)
        assert np.max(rotation_error(found, rotations, lanes)) <= most
        assert np.max(slide_error(response["peak_slide"], slides)) <= 4.0 * most


@pytest.mark.thorough
def test_random_displacement_pulses_are_second_order() -> None:
    steps = np.array([5e-3, 2e-3, 1e-3, 5e-4])
    lanes, motions = random_pulses(Control.DISPLACEMENT, 1, 64)
    fine = respond(lanes, motions, 5e-5)
    responses = [respond(lanes, motions, float(step)) for step in steps]
    found = np.array([rotation_error(r["rotation"], fine["rotation"], lanes) for r in responses])
    # As many as a stack of one block has.
    assert np.mean(found[0] <= 1e-2) >= 0.97
    assert np.max(found[2]) <= 1e-3
    rocks = fine["peak_rotation"] > 1e-3 * lanes.slenderness_angle
    assert np.sum(rocks) >= 51
    order = np.polyfit(np.log(steps), np.log(found[:, rocks]), 1)[0]
    assert np.median(order) >= 1.95
    assert np.quantile(order, 0.1) >= 1.8
    slides = np.array([slide_error(r["peak_slide"], fine["peak_slide"]) for r in responses])
    assert np.sum(fine["peak_slide"] > SLIDE_DUST) >= 51
    assert np.max(slides[0]) <= 2e-2
    assert np.max(slides[2]) <= 1e-3


def test_velocity_steps_of_the_sine_pulse_case() -> None:
    pulse = expand_lanes(load_case("single-sine-pulse"))
    lanes, motions = pulse.lanes.take(slice(0, 6)), pulse.motions.take(slice(0, 6))
    fine = respond(lanes, motions, 2e-5)
    for step, most in ((DEFAULT, 1e-3), (1e-3, 4e-5)):
        response = respond(lanes, motions, step)
        assert np.max(rotation_error(response["rotation"], fine["rotation"], lanes)) <= most
        slide = slide_error(response["peak_slide"], fine["peak_slide"])
        assert np.max(slide) <= 10.0 * most
        np.testing.assert_array_equal(response["impact_count"], fine["impact_count"])
    # From an integration to round-off: the corner slides right after a velocity step, and sticks.
    np.testing.assert_allclose(
        1e3 * fine["peak_slide"], [0.1994, 0.1467, 0.2412, 0.1383, 0.2160, 0.3108], atol=1e-4
    )


@pytest.mark.thorough
def test_packed_and_plain_slide_alike() -> None:
    lanes, motions = random_pulses(Control.DISPLACEMENT, 2, 100)
    packed = respond(lanes, motions, DEFAULT, Form.PACKED)
    plain = respond(lanes, motions, DEFAULT, Form.PLAIN)
    for name in ("rotation", "peak_slide", "residual_slide", "uplift_time", "energy_lost"):
        # Round-off, magnified by the impacts of a second.
        np.testing.assert_allclose(packed[name], plain[name], rtol=1e-6, atol=1e-9, err_msg=name)
    np.testing.assert_array_equal(packed["impact_count"], plain["impact_count"])


def test_extremes_neither_gain_energy_nor_stall() -> None:
    rng = np.random.default_rng(5)
    count = 256
    height = 10.0 ** rng.uniform(np.log10(0.05), np.log10(50.0), count)
    slenderness = 10.0 ** rng.uniform(np.log10(0.3), np.log10(20.0), count)
    friction = rng.choice([0.0, 0.05, 0.3, 0.6, 1.0, 1.3, 2.0, 10.0], count)
    lanes = make_lanes(height / slenderness, height, friction=friction)
    frequency = 10.0 ** rng.uniform(-1.0, np.log10(50.0), count)
    size = 10.0 ** rng.uniform(-1.0, np.log10(5.0 * GRAVITY), count)
    motions = sines(Control.VELOCITY, size / (2.0 * np.pi * frequency), frequency, 2.25, start=0.1)
    mass = lanes.density * lanes.width * lanes.height * lanes.depth
    for step in (1e-1, 2e-2, 5e-3):
        response = respond(lanes, motions, step)
        assert np.all(response["energy_lost"] >= -1e-12 * mass)
    # Ever shorter swings before rest take most of the trials; none of them goes in circles.
    assert np.max(response["step_count"]) <= 8.0 * TIMES.duration / DEFAULT


def test_nearly_jammed_sliding_is_left_in_few_trials() -> None:
    # Friction above 4/3 can drive the contact force of a sliding corner to any size. A step that
    # is far too long then says nothing of when the corner leaves.
    rng = np.random.default_rng(7)
    count = 512
    height, slenderness = 10.0 ** rng.uniform(-1.3, 1.0, count), rng.uniform(0.5, 5.0, count)
    friction = rng.choice([1.2, 1.35, 1.4, 1.6, 2.0], count)
    lanes = make_lanes(height / slenderness, height, friction=friction)
    frequency = 10.0 ** rng.uniform(-1.0, 1.0, count)
    size = 10.0 ** rng.uniform(0.0, np.log10(50.0), count)
    motions = sines(
        Control.DISPLACEMENT, size / (2.0 * np.pi * frequency) ** 2, frequency, 1.0, start=0.1
    )
    response = respond(lanes, motions, 1e-3)
    # While a block slides its steps are a quarter of that; two trials each.
    assert np.max(response["step_count"]) <= 2.0 * TIMES.duration / (0.25 * 1e-3)
