"""Corners of bodies as kernels take them."""

from __future__ import annotations

import dataclasses
import time

import numpy as np
import pytest

from tests.shared.blocks import make_lanes, sines
from tests.shared.planar_bodies import STEPPED, body_lanes, planar_bodies
from tests.shared.speed import require_gain
from warprock.engines import engine_class
from warprock.engines.bodies import Corners, box_bodies
from warprock.engines.launching import NEVER
from warprock.model import rocking
from warprock.model.lanes import Lanes
from warprock.model.motion import Control
from warprock.model.response import SampleTimes


def corners_of(points: list[list[float]], radius: float = 0.0) -> Corners:
    body = body_lanes([(x, z) for x, z in points], [0.0], radius=radius).body
    assert body is not None
    return Corners.of(body)


def test_points_on_an_edge_are_no_corners() -> None:
    corners = corners_of([[-0.2, -0.5], [-0.1, -0.5], [0.1, -0.5 + 1e-9], [0.3, -0.5]])
    assert corners.x.tolist() == [[-0.2, 0.3]]
    assert corners.angle.tolist() == [[0.0, NEVER]]
    assert corners.along.tolist() == [[-0.2, 0.3]]


def test_round_off_makes_no_corners() -> None:
    # A level base with noise of a ten millionth, and points beside it that are no further out.
    rng = np.random.default_rng(1)
    noise = [[x, -0.5 + 1e-7 * rng.random()] for x in np.linspace(-0.2, 0.3, 20)]
    corners = corners_of([[-0.4, -0.3], [-0.3, -0.4 + 1e-8], *noise, [0.4, -0.45], [0.5, -0.4]])
    np.testing.assert_allclose(corners.x[0], [-0.4, -0.2, 0.3, 0.5])
    assert corners.angle[0, 1] == 0.0
    assert np.all(np.diff(corners.angle[0]) > 0.0)


def test_edges_lie_flat_at_their_angles_and_roll_out_by_their_lengths() -> None:
    corners = corners_of([list(each) for each in STEPPED])
    angles = np.arctan2([-0.04, -0.02, 0.0, 0.03], [0.08, 0.12, 0.25, 0.1])
    np.testing.assert_allclose(corners.angle[0], [*angles, NEVER], rtol=1e-13)
    lengths = np.hypot([0.08, 0.12, 0.25, 0.1], [0.04, 0.02, 0.0, 0.03])
    np.testing.assert_allclose(np.diff(corners.along[0]), lengths, rtol=1e-13)
    # It stands on the third and the fourth at first: there they come to stand where they are.
    np.testing.assert_allclose(corners.along[0, 2:4], [-0.1, 0.15], rtol=1e-13)


def test_what_touches_and_the_height_follow_the_rotation() -> None:
    corners = corners_of([list(each) for each in STEPPED], radius=0.02)
    turns = np.array([[-0.6, -0.2, -0.1, 0.0, 0.2, 0.4]])
    assert corners.lowest(turns)[0].tolist() == [0, 1, 2, 2, 3, 4]
    x, z = corners.lever(turns)
    # The height of a body on the ground is least at its support: dz / dtheta = -x.
    # On an edge, at zero, it is not smooth.
    _x, later = corners.lever(turns + 1e-6)
    beside = turns[0] != 0.0
    np.testing.assert_allclose((later - z)[0, beside] / 1e-6, -x[0, beside], atol=1e-5)
    # A body that rolls on does not slide, whatever corner it stands on.
    rolled = np.take_along_axis(corners.along, corners.lowest(turns), axis=1) + 0.02 * turns
    np.testing.assert_allclose(corners.slide(turns, rolled - x), 0.0, atol=1e-15)


def test_bodies_of_different_counts_share_a_batch() -> None:
    body = body_lanes(STEPPED, [0.0, 0.0]).body
    assert body is not None
    points = body.points.copy()
    points[1, 3:] = points[1, 3]
    mixed = type(body)(
        body.mass, body.gyration, points, np.array([5, 4], np.int32), body.corner_radius, body.axes
    )
    corners = Corners.of(mixed)
    assert corners.last.tolist() == [4, 3]
    assert corners.angle[1, 3:].tolist() == [NEVER, NEVER]
    assert corners.x[1, 4] == corners.x[1, 3]


def test_a_box_falls_as_fast_as_its_frequency_parameter_says() -> None:
    lanes = make_lanes([0.2, 0.5], [1.0, 1.5])
    body = box_bodies(lanes)
    np.testing.assert_allclose(
        Corners.of(body).fastest_rate(body.gyration),
        rocking.frequency_parameter(lanes.width, lanes.height),
        rtol=1e-13,
    )


@pytest.mark.speed
@pytest.mark.parametrize(("engine", "duration"), [("event", 2.0), ("impulse", 0.2), ("dem", 0.2)])
def test_twelve_corners_cost_at_most_five_boxes(engine: str, duration: float) -> None:
    count, ratio = 2048, np.random.default_rng(0).uniform(0.2, 0.9, 2048)
    box = make_lanes(np.full(count, 0.3), 1.0, ratio, 0.8)
    step = np.arange(6)
    side = np.stack([0.15 + 0.002 * step, -0.5 + 0.003 * step + 0.0015 * step**2], axis=1)
    base = np.concatenate([side[::-1] * np.array([-1.0, 1.0]), side])
    mass = np.full(count, 150.0)
    body = planar_bodies(mass=mass, inertia=mass * 1.09 / 12.0, points=base)
    assert Corners.of(body).x.shape == (count, 12)
    motions = sines(Control.ACCELERATION, np.full(count, 2.0), 1.0, 2.0)
    runs = engine_class(engine)()

    def cost(lanes: Lanes) -> float:
        started = time.process_time()
        runs.run(lanes, motions, SampleTimes(duration))
        return time.process_time() - started

    cornered = dataclasses.replace(box, body=body)
    for lanes in (box, cornered):
        cost(lanes)
    # Measured for `impulse`: 4.0 boxes with vectors of 256 bits, 4.3 with those of 512.
    require_gain(lambda: cost(box), lambda: cost(cornered), 0.2)
