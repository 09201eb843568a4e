"""Friction above which rigid contact has no unique answer: the limit, and the lanes marked."""

from __future__ import annotations

import numpy as np
import pytest

from tests.shared import closed_forms
from tests.shared.blocks import at_rest, make_lanes, shakes, sines
from tests.shared.case_texts import PULSE
from tests.shared.space_bodies import bodies_of
from tests.shared.spatial_blocks import along, in_space
from warprock.case.lanes import expand_lanes
from warprock.case.load import load_case
from warprock.model import rocking
from warprock.model.lanes import Lanes, as_stacks
from warprock.model.motion import Control, HarmonicMotions
from warprock.model.painleve import (
    ambiguous,
    friction_limit,
    least_limit,
    mark_ambiguous,
    spatial_limit,
)
from warprock.model.response import SOUND, USABLE, SampleTimes, Status
from warprock.running.batch import run_batch
from warprock.running.tolerance import run_to_tolerance
from warprock.settings.engines import EventSettings, ImpulseSettings

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
    speed = closed_forms.overturning_velocity_step(width, height) * rng.uniform(0.2, 1.2, LANES)
    amplitude = speed / (2.0 * np.pi * frequency) * rng.choice([-1.0, 1.0], LANES)
    return lanes, sines(Control.DISPLACEMENT, amplitude, frequency, cycles=1.0)


def solutions(lean: float, friction: float, along: float) -> set[str]:
    """Ways in which a corner may take a velocity step of the base.

    One that slides on has a normal velocity of zero without an impulse, and keeps it with none.

    Args:
        lean: Angle of the line from the corner to the centre of mass against the vertical [rad]:
            half diagonal 1, mass 1, moment of inertia 1/3.
        friction: Friction coefficient.
        along: Velocity along the base that the corner has after the step without contact [m/s].
    """
    rx, rz = np.sin(lean), -np.cos(lean)
    # Changes of the corner's normal and tangential velocity by either impulse of 1.
    effect = np.eye(2) + 3.0 * np.array([[rx * rx, -rx * rz], [-rx * rz, rz * rz]])
    found = {"slides without impulse"}
    normal, tangential = np.linalg.solve(effect, [0.0, -along])
    if normal >= 0.0 and abs(tangential) <= friction * normal:
        found.add("sticks")
    return found


def test_above_the_limit_a_velocity_step_has_two_answers_and_below_it_one():
    rng = np.random.default_rng(3)
    for lean in rng.uniform(0.05, 1.2, 200):
        limit = float(friction_limit(np.tan(lean), 1.0))
        for way in (-1.0, 1.0):
            below = solutions(lean, 0.999 * limit, way)
            above = solutions(lean, 1.001 * limit, way)
            assert below == {"slides without impulse"}
            # Friction presses a corner on its base that would slide towards the block.
            assert above == below | ({"sticks"} if way > 0.0 else set()), (lean, way)


def both_kernels(lanes: Lanes, motions: HarmonicMotions):
    """Blocks in two kernels of `event`, alone and as stacks of one.

    Returns:
        Gap between the rotations of the two, over the slenderness angle; lanes in which each has
        come to its answer: half the step changes it by less than 1e-2; lanes marked by each.
    """
    steps = [EventSettings(time_step=1e-3), EventSettings(time_step=5e-4)]
    kinds = (lanes, as_stacks(lanes))
    runs = [
        run_batch("event", kind, motions, TIMES, settings=step) for kind in kinds for step in steps
    ]
    turns = [
        np.clip(run["rotation"].reshape(lanes.lane_count, -1), -0.5 * np.pi, 0.5 * np.pi)
        for run in runs
    ]
    own, other, gap = (
        np.abs(turns[i] - turns[j]).max(axis=1) / lanes.slenderness_angle
        for i, j in ((0, 1), (2, 3), (1, 3))
    )
    marked = [run["status"] == Status.AMBIGUOUS for run in (runs[1], runs[3])]
    return gap, np.maximum(own, other) < 0.01, marked


@pytest.mark.thorough
def test_two_kernels_stick_alike_above_the_limit_and_mark_alike():
    # One that slid without impulse where the other sticks would part from it; none does.
    gap, settled, marked = both_kernels(*shakes(320, (1.34, 10.0)))
    assert settled.sum() >= 300
    assert np.all(gap[settled] < 0.05)
    assert 200 <= marked[0].sum() <= 300
    assert np.sum(marked[0] != marked[1]) <= 3
    # Below the limit the law has one solution.
    gap, settled, marked = both_kernels(*shakes(320, (0.3, 1.3)))
    assert settled.sum() >= 250
    assert np.all(gap[settled] < 0.05)
    assert not np.any(marked)


@pytest.mark.parametrize("stacked", [False, pytest.param(True, marks=pytest.mark.thorough)])
def test_engines_that_stick_where_they_may_agree_above_the_limit_and_mark_alike(stacked: bool):
    # At a velocity step of the base "sticks" and "slides without impulse" both obey the law; all
    # these engines stick. The mark says that another answer is one, too, not that they part.
    lanes, motions = pulses()
    runs = [
        run_batch("event", lanes, motions, TIMES, settings=FINE["event"]),
        run_batch("event", as_stacks(lanes), motions, TIMES, settings=FINE["event"])
        if stacked
        else run_batch("impulse", lanes, motions, TIMES, settings=FINE["impulse"]),
    ]
    history = np.array([run["rotation"].reshape(LANES, -1) for run in runs])
    apart = np.ptp(history, axis=0).max(axis=1) / lanes.slenderness_angle
    marked = np.array([run["status"] == Status.AMBIGUOUS for run in runs])
    # Impulse at 1/12000 s is of first order.
    assert np.all(apart < 0.01)
    assert 10 <= marked[0].sum() <= 30
    # The rule sees the lane, not the engine: only a slide of about its least size differs.
    assert np.sum(marked.any(axis=0) != marked.all(axis=0)) <= 1
    assert np.all(np.isin([run["status"] for run in runs], SOUND))


@pytest.mark.parametrize("stacked", [False, pytest.param(True, marks=pytest.mark.thorough)])
def test_friction_that_holds_is_not_marked(stacked: bool):
    ratio = np.array([0.2, -0.5, 0.9, 0.99])
    free = make_lanes([0.2, 0.5, 0.9, 0.3], 1.0, ratio, friction=10.0)
    for engine in ("event", "impulse"):
        response = run_batch(engine, as_stacks(free) if stacked else free, at_rest(4), TIMES)
        assert np.all(response["status"] == Status.OK)


def test_a_block_below_the_limit_may_slide_as_it_likes():
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
    marked = [response["status"] == Status.AMBIGUOUS for response in (plane, space)]
    assert 4 <= np.sum(marked[0]) < 12
    # In one lane, at 1.04 times its limit, the two part after a slide of 6e-5 widths.
    assert np.sum(marked[0] != marked[1]) <= 1


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
    found = run_to_tolerance("event", lanes, motions, SampleTimes(0.5))
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


def test_the_limit_of_a_body_in_space_is_that_of_the_point_that_touches():
    # Two points in the plane of rocking; a body that can turn about y alone is one of the plane.
    points = np.array([(-0.1, 0.0, -0.3), (0.1, 0.0, -0.3)])
    body = bodies_of(points, np.diag([1e6, 0.02, 1e6]), 1)
    square, lean = 0.1, np.arctan2(0.1, 0.3)
    leans = lean - np.linspace(0.0, 0.2, 9)
    s, c = np.sin(leans), np.cos(leans)
    limit = ((0.02 + square * s * s) / (square * np.abs(s) * c)).min()
    # A tilt across the plane leaves the lean in it nearly what it is.
    np.testing.assert_allclose(spatial_limit(body, np.array([0.2])), limit, rtol=1e-3)


def test_no_tilt_of_a_body_in_space_has_a_lower_limit_than_the_closed_form():
    rng = np.random.default_rng(8)
    closest = np.inf
    for _ in range(40):
        points = rng.uniform(-1.0, 1.0, (6, 3)) * rng.uniform(0.1, 1.0, 3)
        # Principal moments of some body: sums of two squares each.
        squares = rng.uniform(0.01, 1.0, 3)
        body = bodies_of(points, np.diag(squares.sum() - squares), 1)
        least = least_limit(body.gyration.min(axis=1), body.points)
        found = spatial_limit(body, np.array([0.5 * np.pi]))
        assert found >= least
        closest = min(closest, float(found[0] / least[0]))
    # Nor is the bound idle.
    assert closest <= 1.1
