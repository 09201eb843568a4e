"""`event` of bodies on contact points in the plane: boxes, Housner's body, rest on any edge."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from tests.shared.blocks import make_lanes, sines
from tests.shared.held import held_batch
from tests.shared.planar_bodies import STEPPED, body_lanes, mirrored
from warprock.engines.bodies import Corners, box_bodies
from warprock.engines.event import Event
from warprock.model.lanes import Lanes
from warprock.model.motion import Control, GroundMotions
from warprock.model.response import Outcome, Response, SampleTimes, Status
from warprock.running.batch import run_batch
from warprock.settings.engines import EventSettings
from warprock.units import GRAVITY

TIMES = SampleTimes(3.0, 0.01, places=True)
STARTS = (0.08, 0.03, -0.1, -0.15, 0.05)


def shaken(count: int, amplitude: float = 1.5) -> GroundMotions:
    return sines(Control.ACCELERATION, np.full(count, amplitude), np.full(count, 1.0), 1.0)


def run(lanes: Lanes, motions: GroundMotions, step: float = 5e-3) -> Response:
    response = Event(EventSettings(time_step=step)).run(lanes, motions, TIMES)
    assert np.all(response["status"] == Status.OK)
    return response


@pytest.mark.parametrize("friction", [0.15, 0.5, 3.0])
def test_a_box_as_a_body_is_the_box(friction: float) -> None:
    lanes = make_lanes(np.linspace(0.2, 0.5, 8), 1.0, np.linspace(-0.9, 0.9, 8), friction)
    motions = shaken(8, 3.0)
    box = run(lanes, motions)
    body = run(dataclasses.replace(lanes, body=box_bodies(lanes)), motions, 1e-4)
    for name in ("outcome", "status"):
        np.testing.assert_array_equal(body[name], box[name], err_msg=name)
    # Steps of a body are of second order, and so are those of a box where it slides: what is left
    # is that of the box at 5e-3 s (8e-5 of the energy), and that of the body at 1e-4 s.
    for name in ("rotation", "slide", "x", "z", "peak_slide", "energy_lost", "uplift_time"):
        most = 2e-4 * max(float(np.nanmax(np.abs(box[name]))), 1e-3)
        np.testing.assert_allclose(body[name], box[name], rtol=0.0, atol=most, err_msg=name)


@pytest.mark.parametrize("radius", [0.0, 0.03])
@pytest.mark.parametrize("restitution", [None, 0.8])
def test_second_order_to_housner(radius: float, restitution: float | None) -> None:
    lanes = body_lanes(STEPPED, STARTS, radius=radius, restitution=restitution)
    motions = shaken(5)
    exact = run_batch("housner", lanes, motions, TIMES)["rotation"]
    coarse, fine = (
        np.abs(run(lanes, motions, step)["rotation"] - exact).max(axis=1) for step in (8e-3, 2e-3)
    )
    assert np.all(fine <= 5e-4)
    # A quarter of the step, a sixteenth of the error; of one lane impacts scatter it.
    assert np.mean(fine) <= np.mean(coarse) / 10.0


def test_a_mirrored_body_moves_as_in_a_mirror() -> None:
    lanes, motions = body_lanes(STEPPED, STARTS, friction=0.4), shaken(5, 4.0)
    one, other = run(lanes, motions), run(mirrored(lanes), motions.scaled(-np.ones(5)))
    assert one["impact_count"].min() > 1
    np.testing.assert_array_equal(other["rotation"], -one["rotation"])
    np.testing.assert_array_equal(other["energy_lost"], one["energy_lost"])


def test_a_body_comes_to_rest_on_either_of_its_stable_edges() -> None:
    # Let go from beside the balance over the corner between them; what is lost is what it held.
    points = ((-0.2, -0.5), (0.2, -0.5), (0.5, -0.3))
    edge = np.arctan2(0.2, 0.3)
    starts = np.array([0.35, 0.5, 0.6, edge])
    lanes, still = body_lanes(points, starts), shaken(4).scaled(np.zeros(4))
    response = Event().run(lanes, still, SampleTimes(6.0, 0.1))
    assert np.all(response["outcome"] == Outcome.AT_REST)
    np.testing.assert_allclose(response["rotation"][:, -1], [0.0, edge, edge, edge], atol=1e-15)
    corners = Corners.of(lanes.body)
    ends = np.stack([starts, response["rotation"][:, -1]], axis=1)
    held = lanes.mass * GRAVITY * -np.diff(-corners.lever(ends)[1], axis=1)[:, 0]
    # Second order: the drift that the ends of steps take back.
    np.testing.assert_allclose(response["energy_lost"], held, rtol=2e-3, atol=1e-9)
    assert response["impact_count"][3] == 0


def test_a_restitution_is_followed_by_boxes_too() -> None:
    # Given far from what the contact law finds: 0.97 for a block of 0.2 m x 1.4 m.
    lanes = make_lanes(0.2, np.array([1.0, 1.2, 1.4]), 0.7, 3.0, [0.5, 0.7, 0.85])
    lanes = dataclasses.replace(lanes, restitution_given=True)
    still = shaken(3).scaled(np.zeros(3))
    exact = run_batch("housner", lanes, still, TIMES)["rotation"]
    gap = np.abs(run(lanes, still)["rotation"] - exact).max(axis=1)
    # Its own error of second order at 5 ms, a part of the slenderness angle.
    assert np.all(gap <= 1e-3 * lanes.slenderness_angle)


def restituting(count: int, seed: int, least: float = 0.4) -> Lanes:
    """Boxes with prescribed restitutions, most of which ask for more friction."""
    draw = np.random.default_rng(seed)
    lanes = make_lanes(
        draw.uniform(0.1, 1.0, count),
        draw.uniform(1.0, 4.0, count),
        draw.uniform(-0.8, 0.8, count),
        draw.uniform(least, 1.2, count),
        draw.uniform(0.05, 1.0, count),
    )
    return dataclasses.replace(lanes, restitution_given=True)


def test_friction_leaves_of_a_restitution_what_it_can() -> None:
    lanes = restituting(80, 1)
    lanes = lanes.take(np.flatnonzero(lanes.friction > 1.1 * lanes.width / lanes.height))
    still = shaken(lanes.lane_count).scaled(np.zeros(lanes.lane_count))
    found = Event().run(lanes, still, TIMES)
    housner = run_batch("housner", lanes, still, TIMES)
    needed = housner["friction_needed"]
    # What Housner needs besides impacts is less than what holds these blocks anyhow.
    landed = (found["impact_count"] > 0) & (needed > lanes.friction)
    assert landed.sum() > 20
    np.testing.assert_allclose(found["friction_needed"][landed], needed[landed], rtol=1e-6)
    np.testing.assert_array_equal(found["status"], housner["status"])
    # The corner takes m h w (1 - e) / 2 along and m b w (1 + e) / 2 upwards, at most mu of it.
    pull = lanes.friction * lanes.width
    least = (lanes.height - pull) / (lanes.height + pull)
    kept = np.maximum(lanes.angular_restitution, least)
    held = dataclasses.replace(lanes, angular_restitution=kept)
    exact = run_batch("housner", held, still, TIMES)
    gap = np.abs(found["rotation"] - exact["rotation"]).max(axis=1)
    # Its own error of second order at 5 ms, a part of the slenderness angle.
    assert np.all(gap <= 1e-3 * lanes.slenderness_angle)
    np.testing.assert_array_equal(found["outcome"], exact["outcome"])
    assert (found["outcome"] == Outcome.AT_REST).sum() > 20


def test_what_an_impact_leaves_no_rate_rests_until_it_is_lifted() -> None:
    count = 40
    lanes, motions = held_batch(count, 1, wall=False, ties=0)
    stops = {"angular_restitution": np.zeros(count), "friction": np.full(count, 50.0)}
    lanes = dataclasses.replace(lanes, hold=None, restitution_given=True, **stops)
    times = SampleTimes(4.0, None)
    found = Event(EventSettings(time_step=1e-3)).run(lanes, motions, times)
    exact = run_batch("housner", lanes, motions, times)
    assert np.all(found["status"] == Status.OK)
    lands = exact["impact_count"] > 0
    assert lands.sum() > 10
    for name in ("outcome", "impact_count"):
        np.testing.assert_array_equal(found[name], exact[name], err_msg=name)
    # Its own error of second order at 1 ms.
    gap = np.abs(found["peak_rotation"] - exact["peak_rotation"])
    assert np.all(gap <= 1e-3 * lanes.slenderness_angle)


def test_prescribed_impacts_neither_last_nor_gain_energy() -> None:
    count = 80
    lanes = restituting(count, 2, least=0.1)
    lanes.angular_restitution[::4] = 1.0
    amplitude = np.random.default_rng(4).uniform(-9.0, 9.0, count)
    pulse = sines(Control.ACCELERATION, amplitude, 1.5, 2.0)
    found = Event().run(lanes, pulse, SampleTimes(4.0, 0.05))
    assert set(found["status"]) == {Status.OK, Status.OUTSIDE_MODEL}
    lacks = found["friction_needed"] > lanes.friction * (1.0 + 1e-6)
    np.testing.assert_array_equal(found["status"] == Status.OUTSIDE_MODEL, lacks)
    # Of round-off of the energy that comes in; what steps of 5 ms drift while they rock is less.
    assert found["energy_lost"].min() >= -1e-6 * GRAVITY * lanes.mass.max()
    still = pulse.scaled(np.zeros(count))
    alone = Event().run(lanes, still, SampleTimes(4.0, None))
    # Some tens of impacts a second where a block nearly rests; without an end they are thousands.
    assert alone["impact_count"].max() < 300
    back = dataclasses.replace(lanes, rotation_start=-lanes.rotation_start)
    other = Event().run(back, pulse.scaled(-np.ones(count)), SampleTimes(4.0, 0.05))
    np.testing.assert_array_equal(other["rotation"], -found["rotation"])
