"""Bodies in space on many contact points, in the event-driven engine: round bases, edges, faces.

Its kernel of bodies takes 11 s to compile: `thorough`. The ordinary run has bodies in `impulse`.
"""

from __future__ import annotations

import dataclasses
import time

import numpy as np
import numpy.typing as npt
import pytest

from tests.shared.blocks import sines, velocity_steps
from tests.shared.space_bodies import bodies_of, body_lanes
from tests.shared.spatial_blocks import along, sound_run, spatial_lanes, unmoved
from tests.shared.speed import require_gain
from warprock.engines import engine_class
from warprock.model.lanes import SpatialLanes
from warprock.model.motion import Control
from warprock.model.response import SampleTimes
from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]

RADIUS, HALF_HEIGHT = 0.15, 0.4
TENSOR = np.diag([0.06, 0.06, 0.011])
"""Moments of inertia of a drum over its mass [m^2]."""


def rim(count: int, phase: float = 0.0) -> Array:
    """Points evenly on the rim of a drum, from its centre of mass [m]."""
    angle = 2.0 * np.pi * np.arange(count) / count + phase
    places = RADIUS * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return np.column_stack([places, np.full(count, -HALF_HEIGHT)])


def with_points(lanes: SpatialLanes, bases: list[Array]) -> SpatialLanes:
    """The same lanes, each on a base of its own."""
    body, most = lanes.body, max(len(base) for base in bases)
    assert body is not None
    own = [bodies_of(base, TENSOR, 1).points[0] for base in bases]
    rows = np.stack([np.concatenate([each, each[-1:].repeat(most - len(each), 0)]) for each in own])
    count = np.array([len(base) for base in bases], np.int32)
    return dataclasses.replace(lanes, body=dataclasses.replace(body, points=rows, count=count))


@pytest.mark.thorough
def test_a_round_base_lifts_where_the_pull_leaves_it():
    # Over a corner of the rim, and over an edge between two.
    count, friction, peak, frequency = 16, 2.0, 0.6 * GRAVITY, 0.8
    bases = [rim(count), rim(count, np.pi / count), rim(12), rim(12, np.pi / 12)]
    lanes = with_points(body_lanes(rim(count), TENSOR, 4, friction=friction), bases)
    motion = sines(Control.ACCELERATION, np.full(4, peak), frequency, 1.0)
    found = sound_run("event", lanes, along(motion), SampleTimes(1.5))
    arm = RADIUS * np.cos(np.array([0.0, np.pi / 16, 0.0, np.pi / 12]))
    lifts = np.arcsin(arm / HALF_HEIGHT * GRAVITY / peak) / (2.0 * np.pi * frequency)
    # It lifts in the step in which the pressure leaves the base.
    assert np.all(np.abs(found["uplift_time"] - lifts) <= 5e-3)
    assert np.all(found["energy_lost"] > 0.0)


@pytest.mark.thorough
def test_a_face_of_many_points_slides_as_far_as_friction_lets_it():
    speed, friction = np.array([0.3, 0.5, 0.4]), 0.2
    lanes = body_lanes(rim(16), TENSOR, 3, friction=friction)
    steps = along(*(velocity_steps(c * speed, 0.0 * speed, 50.0 + 0.0 * speed) for c in (0.8, 0.6)))
    found = sound_run("event", lanes, steps, SampleTimes(1.0))
    way = np.hypot(found["residual_slide"], found["residual_slide_across"])
    # Its end is found to a step of 5 ms: friction's speed there, times half of it.
    np.testing.assert_allclose(way, speed**2 / (2.0 * friction * GRAVITY), atol=5e-5)
    assert np.all(found["peak_yaw"] < 1e-6)


@pytest.mark.thorough
def test_points_that_no_hull_has_as_a_corner_change_nothing():
    # A square, and the same with points on its edges and in between.
    a = 0.1
    square = np.array([(-a, -a), (a, -a), (a, a), (-a, a)])
    more = a * np.array([(0.0, -1.0), (1.0, 0.3), (-0.2, 1.0), (-1.0, 0.0), (0.0, 0.0), (0.5, 0.2)])
    bases = [np.column_stack([xy, np.full(len(xy), -HALF_HEIGHT)]) for xy in
             (square, np.concatenate([square, more]))]  # fmt: skip
    lanes = body_lanes(
        bases[0], TENSOR, 4, friction=3.0, rotation_start=[0.1, 0.1, 0.06, 0.06],
        rotation_across_start=[0.0, 0.0, 0.05, 0.05],
    )  # fmt: skip
    rest = along(sines(Control.ACCELERATION, np.zeros(4), 1.0, 1.0))
    found = sound_run("event", with_points(lanes, bases * 2), rest, SampleTimes(1.0, 0.05, True))
    for name in ("rotation", "rotation_across", "yaw", "z"):
        # Impacts are found to 1e-7 of a step.
        np.testing.assert_allclose(found[name][1::2], found[name][::2], atol=1e-6)
    assert np.all(found["impact_count"] >= 2)


@pytest.mark.thorough
def test_a_prism_that_rolls_loses_in_an_impact_what_its_angular_momentum_leaves():
    # An octagon rolls over a corner, from a velocity step of the base: it then has the angular
    # momentum about its edge that the step gives, and keeps its energy from face to face.
    sides, radius, gyration = 8, 0.2, 0.03
    angle = np.pi / sides * (2.0 * np.arange(sides) + 1.0)
    ring = np.stack([radius * np.sin(angle), 0.0 * angle, -radius * np.cos(angle)], axis=1)
    points = np.concatenate([ring + np.array([0.0, side, 0.0]) for side in (-0.1, 0.1)])
    lanes = body_lanes(points, gyration * np.eye(3), 2, friction=5.0)
    kick = np.array([0.85, 0.95])
    steps = along(velocity_steps(-kick, 0.0 * kick, 50.0 + 0.0 * kick))
    inertia, low = gyration + radius**2, radius * np.cos(np.pi / sides)
    energy = 0.5 * 100.0 * (low * kick) ** 2 / inertia
    assert np.all(energy > 100.0 * GRAVITY * (radius - low))
    times = SampleTimes(0.8, 0.01, True)
    found = sound_run("event", lanes, steps, times)
    turn = np.pi / sides * 2.0
    passed = found["rotation"] > turn
    assert np.all(passed.any(axis=1))
    first = passed.argmax(axis=1)
    eta = (gyration + radius**2 * np.cos(turn)) / inertia
    lost = []
    for sample in (first - 2, first + 2):
        runs = [
            sound_run("event", lanes, steps, SampleTimes(0.01 * at))["energy_lost"][lane]
            for lane, at in enumerate(sample)
        ]
        lost.append(runs)
    # Second order: 5e-5 in a step of 5 ms.
    np.testing.assert_allclose(np.subtract(*lost[::-1]), energy * (1.0 - eta**2), rtol=1e-4)


@pytest.mark.thorough
def test_bases_of_any_number_of_points_find_their_forces():
    rng, count = np.random.default_rng(1), 96
    bases = []
    for lane in range(count):
        points = rim(int(rng.integers(3, 17)), rng.uniform(0.0, 6.0))
        points[3:, 2] += (lane % 3 > 0) * RADIUS * 10.0 ** rng.uniform(-6.0, -1.0, len(points) - 3)
        points[:3] = rim(3)
        points[3:, :2] *= rng.uniform(0.3 if lane % 3 == 2 else 1.0, 1.0, (len(points) - 3, 1))
        bases.append(points)
    lean = 0.2 * (rng.random(count) < 0.5)
    lanes = body_lanes(
        bases[0], TENSOR, count, friction=rng.uniform(0.1, 0.8, count),
        rotation_start=lean * rng.uniform(-1.0, 1.0, count),
        rotation_across_start=lean * rng.uniform(-1.0, 1.0, count),
    )  # fmt: skip
    pulls = rng.uniform(0.0, 8.0, (2, count))
    motion = along(*(sines(Control.ACCELERATION, pull, 1.5, 2.0) for pull in pulls))
    found = sound_run("event", with_points(lanes, bases), motion, SampleTimes(2.0))
    # Some twenty steps an impact at most, and what contacts take is never given back.
    assert np.all(found["step_count"] < 500 + 30 * found["impact_count"])


@pytest.mark.speed
def test_twelve_points_cost_at_most_four_boxes():
    rng, count = np.random.default_rng(0), 256
    lean = {
        "rotation_start": rng.uniform(0.05, 0.2, count),
        "rotation_across_start": rng.uniform(-0.15, 0.15, count),
    }
    size = np.full(count, 1.8 * RADIUS)
    box = spatial_lanes(size, np.full(count, 2.0 * HALF_HEIGHT), friction=0.7, **lean)
    box = dataclasses.replace(box, depth=size)
    drum, runs = body_lanes(rim(12), TENSOR, count, friction=0.7, **lean), engine_class("event")()

    def cost(lanes: SpatialLanes) -> float:
        started = time.process_time()
        runs.run(lanes, unmoved(count), SampleTimes(3.0))
        return time.process_time() - started

    for lanes in (box, drum):
        cost(lanes)
    require_gain(lambda: cost(box), lambda: cost(drum), 0.25)
