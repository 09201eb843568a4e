"""Bodies in space on any contact points, in the engines that run them."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

from tests.shared.space_bodies import (
    ROCK_POINTS,
    ROCK_TENSOR,
    bodies_of,
    body_lanes,
    box_as_body,
    some_boxes,
)
from tests.shared.spatial_blocks import sound_run, unmoved
from warprock.engines.energy import energy_to_tilt, nearest_edge
from warprock.engines.spatial_bodies import point_rows
from warprock.errors import InputError
from warprock.model.lanes import SpatialLanes
from warprock.model.pose import product, quaternion
from warprock.model.response import Outcome, Response, SampleTimes
from warprock.model.turning import rotate
from warprock.settings.engines import DemSettings, EventSettings, ImpulseSettings

TIMES = SampleTimes(1.0, 0.02, True)
PLACES = ("rotation", "rotation_across", "yaw", "x", "y", "z", "slide", "slide_across")
ENGINES = (
    "impulse",
    pytest.param("event", marks=pytest.mark.thorough),
    pytest.param("dem", marks=pytest.mark.thorough),
)
# Springs under the four corners alone, as a body has them.
SETTINGS = {"dem": DemSettings(subcontacts=2, subcontacts_across=2)}
# Impacts multiply round-off; `event` ends steps at impacts to 1e-7 of a step, and a corner that
# slides is found by another method; springs at corners that chatter multiply more.
ALIKE = {"impulse": 1e-9, "event": 2e-6, "dem": 1e-5}


ROWS = 16
"""Rows of points for which tests with more of them compile the kernel of `event`, too."""


def run(engine: str, lanes: SpatialLanes, *given: Any) -> Response:
    """A sound run; in `event` bodies have the last point in as many rows as there are."""
    body = lanes.body
    if engine == "event" and body is not None:
        rows = np.minimum(np.arange(ROWS), body.points.shape[1] - 1)
        lanes = dataclasses.replace(
            lanes, body=dataclasses.replace(body, points=body.points[:, rows])
        )
    return sound_run(engine, lanes, *given)


def farthest_apart(one: Response, other: Response) -> float:
    """Largest difference of two responses' rotations and places [rad, m]."""
    return max(float(np.abs(one[name] - other[name]).max()) for name in PLACES)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_box_on_its_corners_is_a_box(engine: str):
    boxes, settings = some_boxes(), SETTINGS.get(engine)
    box = run(engine, boxes, unmoved(4), TIMES, settings)
    body = run(engine, box_as_body(boxes), unmoved(4), TIMES, settings)
    assert farthest_apart(box, body) < ALIKE[engine]
    assert box["outcome"].tolist() == body["outcome"].tolist()
    for name in ("peak_rotation", "peak_rotation_across", "peak_tilt", "peak_yaw", "residual_yaw"):
        np.testing.assert_allclose(body[name], box[name], atol=ALIKE[engine])
    np.testing.assert_allclose(body["energy_lost"], box["energy_lost"], rtol=1e-3, atol=1e-9)
    np.testing.assert_allclose(body["uplift_time"], box["uplift_time"])


def turned_about_z(lanes: SpatialLanes, angle: float) -> SpatialLanes:
    """The same bodies described in axes that are turned about the vertical."""
    body = lanes.body
    assert body is not None
    turn = quaternion(np.array([0.0, 0.0, angle]))
    return dataclasses.replace(
        lanes,
        body=dataclasses.replace(body, axes=product(np.broadcast_to(turn, (4, 4)), body.axes)),
    )


@pytest.mark.parametrize("engine", ENGINES)
def test_a_body_does_not_depend_on_the_axes_in_which_it_is_described(engine: str):
    # Turned by a quarter, a body that leans to +x leans to what was its +y.
    lanes = body_lanes(
        ROCK_POINTS, ROCK_TENSOR, 4, friction=0.6, rotation_start=[0.1, -0.1, 0.05, 0.0],
        rotation_across_start=[0.05, 0.1, -0.1, 0.0],
    )  # fmt: skip
    quarter = 0.5 * np.pi
    other = dataclasses.replace(
        turned_about_z(lanes, -quarter),
        rotation_start=lanes.rotation_across_start,
        rotation_across_start=-lanes.rotation_start,
        yaw_start=np.full(4, quarter),
    )
    one, two = (run(engine, each, unmoved(4), SampleTimes(0.3, 0.02, True)) for each in
                (lanes, other))  # fmt: skip
    for name in ("x", "y", "z"):
        np.testing.assert_allclose(one[name], two[name], atol=1e-8)


def rock_on_six_and_on_three(friction: float) -> tuple[SpatialLanes, SpatialLanes]:
    """A tilted rock and one on three of its points; the second one alone, twice."""
    three = ROCK_POINTS[[0, 1, 3]]
    both = body_lanes(ROCK_POINTS, ROCK_TENSOR, 2, friction=friction, rotation_start=0.1)
    body = both.body
    assert body is not None
    alone = body_lanes(three, ROCK_TENSOR, 2, friction=friction, rotation_start=0.1)
    assert alone.body is not None
    points = body.points.copy()
    points[1] = np.concatenate([alone.body.points[1], alone.body.points[1][-1:].repeat(3, axis=0)])
    mixed = dataclasses.replace(body, points=points, count=np.array([6, 3], np.int32))
    return dataclasses.replace(both, body=mixed), alone


@pytest.mark.parametrize("engine", ENGINES)
def test_rows_without_a_point_change_nothing(engine: str):
    mixed, alone = rock_on_six_and_on_three(0.6)
    both = body_lanes(ROCK_POINTS, ROCK_TENSOR, 2, friction=0.6, rotation_start=0.1)
    times = SampleTimes(0.4, 0.02, True)
    found = run(engine, mixed, unmoved(2), times)
    for lane, lanes in enumerate((both, alone)):
        expected = run(engine, lanes, unmoved(2), times)
        for name in PLACES:
            # Rows more or less may change the last bit of sums.
            np.testing.assert_allclose(found[name][lane], expected[name][lane], atol=1e-9)


def test_rows_without_a_point_have_no_place_in_single_precision():
    """Where a neighbour slides on the point of its row, sweeps take the row of every lane."""
    mixed, alone = rock_on_six_and_on_three(0.1)
    times = SampleTimes(0.4, 0.02, True)
    single = sound_run("impulse", mixed, unmoved(2), times, precision="float32")
    for name in PLACES:
        expected = sound_run("impulse", alone, unmoved(2), times, precision="float32")[name][1]
        np.testing.assert_allclose(single[name][1], expected, atol=1e-6)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_body_stands_on_an_even_base_and_not_on_an_edge(engine: str):
    uneven = np.array(
        [(-0.1, -0.1, -0.2), (-0.1, 0.1, -0.2), (0.1, 0.1, -0.199), (0.1, -0.1, -0.199)]
    )
    even = uneven * (1.0, 1.0, 0.0) - (0.0, 0.0, 0.2)
    tensor = np.diag([0.02, 0.02, 0.01])
    lanes, times = body_lanes(even, tensor, 1, friction=0.6), SampleTimes(0.5)
    stands = run(engine, lanes, unmoved(1), times)
    assert stands["outcome"][0] == Outcome.AT_REST
    assert stands["peak_tilt"][0] < 1e-9
    with pytest.raises(InputError, match="above the area between its lowest points"):
        run(engine, body_lanes(uneven, tensor, 1, friction=0.6), unmoved(1), times)


@pytest.mark.parametrize("engine", ["impulse", pytest.param("event", marks=pytest.mark.thorough)])
def test_what_turns_about_a_point_keeps_its_energy(engine: str):
    # A rock of unequal principal axes on one point that holds: nothing is lost until it lands.
    lanes = body_lanes(
        ROCK_POINTS, ROCK_TENSOR, 1, friction=4.0, rotation_start=0.2, rotation_across_start=0.15
    )
    settings = ImpulseSettings(substeps=200) if engine == "impulse" else None
    found = run(engine, lanes, unmoved(1), SampleTimes(0.08, 0.01, True), settings)
    assert found["impact_count"][0] == 0
    # It has turned by a good part, about an axis that is none of its own.
    drop = 9.81 * 100.0 * (found["z"][0, 0] - found["z"][0, -1])
    assert drop > 1.0
    assert np.abs(found["yaw"][0, -1]) > 1e-4
    # First order in a step of 21 microseconds, or second in 5 ms.
    assert abs(found["energy_lost"][0]) < 2e-3 * drop


@pytest.mark.thorough
def test_event_is_of_second_order_through_impacts_and_impulse_comes_to_the_same():
    lanes = body_lanes(
        ROCK_POINTS, ROCK_TENSOR, 1, friction=3.0, rotation_start=0.15, rotation_across_start=0.08
    )
    times = SampleTimes(0.9, 0.1, True)

    def far(engine: str, settings: object) -> float:
        return farthest_apart(best, run(engine, lanes, unmoved(1), times, settings))

    best = run("event", lanes, unmoved(1), times, EventSettings(time_step=6.25e-5))
    assert best["impact_count"][0] >= 5
    coarse, fine = (far("event", EventSettings(time_step=step)) for step in (5e-3, 1.25e-3))
    # A quarter of the step: 16 times in the second order; between 1.8 and 2.2 of it.
    assert 4.0**1.8 < coarse / fine < 4.0**2.2
    assert far("impulse", ImpulseSettings(frames_per_second=24000, substeps=0)) < 5e-3
    assert far("impulse", ImpulseSettings(frames_per_second=192000, substeps=0)) < 2e-4


def test_the_energy_to_tilt_is_no_more_than_that_of_a_box():
    boxes = some_boxes()
    bodies = box_as_body(boxes)
    tilt = np.array([0.05, 0.15, 0.2, 0.3])
    box, body = energy_to_tilt(boxes, tilt), energy_to_tilt(bodies, tilt)
    # Directions are looked up 96 a turn, and what may lie between two is left out.
    assert np.all(body <= box)
    assert np.all(body > 0.6 * box)
    np.testing.assert_allclose(nearest_edge(bodies), nearest_edge(boxes), rtol=1e-12)


def test_kernels_have_room_for_64_points():
    lanes = body_lanes(np.tile(ROCK_POINTS, (11, 1)), ROCK_TENSOR, 1, friction=0.6)
    with pytest.raises(InputError, match="at most 64 contact points"):
        run("impulse", lanes, unmoved(1), SampleTimes(0.1))
    assert point_rows(body_lanes(ROCK_POINTS, ROCK_TENSOR, 1)) == 8


def test_points_are_told_along_the_principal_axes():
    body = bodies_of(ROCK_POINTS, ROCK_TENSOR, 1)
    np.testing.assert_allclose(rotate(body.axes[0], body.points[0]), ROCK_POINTS, atol=1e-15)
