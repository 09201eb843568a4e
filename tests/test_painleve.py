"""Friction above which rigid contact has no unique answer: the limit, and the lanes marked."""

from __future__ import annotations

import numpy as np
import pytest

from tests.blocks import make_lanes, sines
from tests.case_texts import PULSE
from tests.spatial_blocks import along, in_space
from warprock import rocking
from warprock.batch import run_batch
from warprock.case import load_case
from warprock.engines.settings import EventSettings, ImpulseSettings
from warprock.engines.stack_launching import as_stacks
from warprock.estimate import run_with_estimate
from warprock.expansion import expand_lanes
from warprock.motion import Control, HarmonicMotions, StillBase
from warprock.painleve import ambiguous, friction_limit, mark_ambiguous
from warprock.response import SOUND, USABLE, SampleTimes, Status

TIMES = SampleTimes(1.5, 0.01)
FINE = {"event": EventSettings(time_step=1e-3), "impulse": ImpulseSettings(substeps=200)}
LANES = 40


def test_the_limit_is_where_a_corner_can_be_pressed_down_by_its_friction():
    # A corner at (b, -h) of a rectangle of mass 1 and inertia (b^2 + h^2) / 3, by hand.
    width, height = np.array([0.2, 0.5, 1.0, 2.0, 5.0]), 1.0
    b, h = 0.5 * width, 0.5 * height
    w = 3.0 / (b * b + h * h)
    np.testing.assert_allclose(
        friction_limit(width, height), (1.0 + w * b * b) / (w * b * h), 1e-14
    )
    # Turned, the lever leans by less; the least of all leans is 4/3, at a slenderness of 2.
    lean = np.arctan2(width, height)
    turned = 0.4 * lean
    leans = lean - np.linspace(0.0, 1.0, 2001)[:, None] * turned
    brute = (1.0 + 3.0 * np.sin(leans) ** 2) / (3.0 * np.sin(leans) * np.cos(leans))
    found = friction_limit(width, height, turned)
    np.testing.assert_allclose(found, brute.min(axis=0), 1e-5)
    assert friction_limit(0.5, 1.0) == pytest.approx(4.0 / 3.0, rel=1e-14)
    assert friction_limit(5.0, 1.0, 1.5) == pytest.approx(4.0 / 3.0, rel=1e-14)


def pulses(seed: int = 1):
    """Random blocks with friction 1.34 to 5 under displacement pulses, half of them strong."""
    rng = np.random.default_rng(seed)
    height = 10.0 ** rng.uniform(-0.3, 0.5, LANES)
    width = height / rng.uniform(1.0, 6.0, LANES)
    lanes = make_lanes(width, height, friction=rng.uniform(1.34, 5.0, LANES))
    rate = rocking.frequency_parameter(width, height)
    frequency = 1.5 * rate * 10.0 ** rng.uniform(0.2, 1.0, LANES) / (2.0 * np.pi)
    speed = rocking.overturning_velocity_step(width, height) * rng.uniform(0.2, 1.2, LANES)
    amplitude = speed / (2.0 * np.pi * frequency) * rng.choice([-1.0, 1.0], LANES)
    return lanes, sines(Control.DISPLACEMENT, amplitude, frequency, cycles=1.0)


def test_lanes_in_which_engines_part_are_marked_and_most_others_are_not():
    lanes, motions = pulses()
    runs = [
        run_batch("event", lanes, motions, TIMES, settings=FINE["event"]),
        run_batch("event", as_stacks(lanes), motions, TIMES, settings=FINE["event"]),
        run_batch("impulse", lanes, motions, TIMES, settings=FINE["impulse"]),
    ]
    history = np.array([run["rotation"].reshape(LANES, -1) for run in runs])
    apart = np.ptp(history, axis=0).max(axis=1) / lanes.slenderness_angle
    marked = np.array([run["status"] == Status.AMBIGUOUS for run in runs])
    parted, agreed = apart > 0.05, apart < 0.01
    assert parted.sum() >= 5
    assert agreed.sum() >= 10
    assert np.all(marked[:, parted])
    assert marked[:, agreed].mean() <= 0.4
    # The rule sees the lane, not the engine: only a slide of about its least size differs.
    assert np.sum(marked.any(axis=0) != marked.all(axis=0)) <= 1
    assert np.all(np.isin([run["status"] for run in runs], SOUND))


def test_friction_that_holds_is_not_marked():
    ratio = np.array([0.2, -0.5, 0.9, 0.99])
    free = make_lanes([0.2, 0.5, 0.9, 0.3], 1.0, ratio, friction=10.0)
    for engine in ("event", "impulse"):
        for lanes in (free, as_stacks(free)):
            response = run_batch(engine, lanes, StillBase(4), TIMES)
            assert np.all(response["status"] == Status.OK)
    # Below the limit a block may slide as it likes.
    lanes, motions = pulses()
    low = make_lanes(lanes.width, lanes.height, friction=1.3)
    response = run_batch("event", low, motions, TIMES)
    assert np.sum(response["peak_slide"] > 1e-3 * low.width) >= 10
    assert not np.any(response["status"] == Status.AMBIGUOUS)


def test_space_marks_as_the_plane_does():
    lanes, motions = pulses()
    some = np.arange(12)
    lanes, motions = lanes.take(some), motions.take(some)
    fine = {"settings": FINE["event"]}
    plane = run_batch("event", lanes, motions, TIMES, **fine)
    space = run_batch("event", in_space(lanes), along(motions), TIMES, **fine)
    np.testing.assert_array_equal(plane["status"], space["status"])
    assert 0 < np.sum(plane["status"] == Status.AMBIGUOUS) < 12


def test_what_other_statuses_say_comes_first():
    lanes, motions = pulses()
    response = run_batch("event", lanes, motions, TIMES)
    slid = ambiguous(lanes, response)
    assert slid.any()
    for status in Status:
        fields = {**response.fields, "status": np.full(LANES, int(status))}
        marked = mark_ambiguous(lanes, type(response)("event", fields, response.times))["status"]
        expected = Status.AMBIGUOUS if status is Status.OK else status
        np.testing.assert_array_equal(marked, np.where(slid, expected, status))
    assert {Status.AMBIGUOUS, Status.OK} <= set(SOUND) <= set(USABLE)


def test_ambiguous_lanes_have_an_estimate():
    lanes, motions = pulses()
    found = run_with_estimate("event", lanes, motions, SampleTimes(0.5))
    marked = found["status"] == Status.AMBIGUOUS
    assert marked.any()
    assert np.all(np.isfinite(found["rotation_error"][marked]))


def test_housner_never_slides_and_is_not_marked():
    lanes, motions = pulses()
    assert isinstance(motions, HarmonicMotions)
    assert not np.any(run_batch("housner", lanes, motions, TIMES)["status"] == Status.AMBIGUOUS)


def test_it_is_said_where_friction_is_asked_for(write):
    note = expand_lanes(load_case(write(PULSE), ["contact.friction=1.5"])).scene.friction_note
    assert note.startswith("1 lane has friction above the limit of the block, 1.33 at least")
    assert expand_lanes(load_case(write(PULSE))).scene.friction_note == ""
