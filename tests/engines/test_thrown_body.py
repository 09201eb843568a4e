"""Bodies on points that start in motion, or in any attitude: flight, impacts, and their ends."""

from __future__ import annotations

import dataclasses

import numpy as np
import numpy.typing as npt
import pytest

from tests.shared.blocks import at_rest
from tests.shared.flight import apart, attitudes, euler
from tests.shared.marks import first
from tests.shared.planar_bodies import GYRATION
from tests.shared.planar_bodies import body_lanes as planar_lanes
from tests.shared.space_bodies import (
    BOULDER,
    ROCK_POINTS,
    ROCK_TENSOR,
    body_lanes,
    box_as_body,
    some_boxes,
)
from tests.shared.spatial_blocks import sound_run, still, unmoved
from warprock.case.lanes import LaneSet, expand_lanes
from warprock.case.load import load_case
from warprock.engines.energy import kinetic_energy_at_start
from warprock.model.bodies import boxes_on_corners
from warprock.model.lanes import SpatialLanes
from warprock.model.pose import quaternion, start_corners
from warprock.model.release import Release, rolling
from warprock.model.response import Outcome, SampleTimes
from warprock.settings.engines import ImpulseSettings
from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]

ENGINES = (
    "impulse",
    *(pytest.param(name, marks=pytest.mark.thorough) for name in ("dem", "event")),
)
STEP = {"impulse": 2e-4, "dem": 2e-4, "event": 5e-3}
"""Time step, at most [s]."""


def boulders(
    attitude: npt.ArrayLike, velocity: npt.ArrayLike, spin: npt.ArrayLike, height: float,
    friction: npt.ArrayLike = 0.5,
) -> SpatialLanes:  # fmt: skip
    """Boulders that are thrown, one a row of the attitudes."""
    q = np.atleast_2d(np.asarray(attitude, dtype=float))
    count = len(q)
    lanes = body_lanes(BOULDER, ROCK_TENSOR, count, friction=friction)
    parts = [np.broadcast_to(np.asarray(part, float), (count, 3)) for part in (velocity, spin)]
    return dataclasses.replace(lanes, release=Release(*parts, q, np.full(count, height)))


TILTED = quaternion(np.array([0.9, -0.4, 2.0]))


@pytest.mark.parametrize("engine", ENGINES)
def test_a_body_without_symmetry_flies_as_euler_says(engine):
    """A parabola, and a turn about no axis of its own: exact but for the order of the step."""
    velocity, spin = np.array([1.5, -0.7, 2.0]), np.array([3.0, -9.0, 2.0])
    lanes, times = boulders(TILTED, velocity, spin, 1.0), SampleTimes(0.4, 0.01, True)
    response = sound_run(engine, lanes, unmoved(1), times)
    t = response.times
    way = velocity * t[:, None] - 0.5 * GRAVITY * t[:, None] ** 2 * np.array([0.0, 0.0, 1.0])
    place = np.stack([response[axis][0] for axis in "xyz"], axis=-1)
    # Inside a step a sample lies on its chord: off by g dt^2 / 8.
    np.testing.assert_allclose(place, way + np.array([0.0, 0.0, 1.0]), atol=5e-8)
    wanted = euler(TILTED, spin, t, ROCK_TENSOR)
    assert np.all(apart(wanted, attitudes(response)[0]) < 2.0 * (10.0 * STEP[engine]) ** 2)
    # Nothing touched; `event` counts what a turn of second order makes of the energy.
    near = 1e-4 if engine == "event" else 1e-9
    assert np.all(np.abs(response["energy_lost"]) < near * kinetic_energy_at_start(lanes))


@pytest.fixture(scope="module")
def tosses() -> LaneSet:
    """A few of the tosses of the shipped cube, as boxes."""
    return expand_lanes(load_case("cube-tosses"), range(0, 40, 4))


def as_body(boxes: SpatialLanes) -> SpatialLanes:
    """Thrown boxes as bodies of their eight corners."""
    release = boxes.release
    assert release is not None
    sizes = np.stack([boxes.width, boxes.depth, boxes.height], axis=-1)
    body = boxes_on_corners(sizes=sizes, mass=boxes.mass, gyration=release.gyration)
    return dataclasses.replace(
        boxes, body=body, release=dataclasses.replace(release, gyration=None)
    )


@pytest.mark.thorough
def test_a_thrown_cube_is_one_as_a_body_of_its_corners(tosses):
    """The text of boxes renames axes and sweeps in another order; both fall on the same face.

    With 50 sweeps the order tells no more. Impacts multiply what is left, round-off by corners that
    touch in one step or in the next: most are alike to 0.1 mm, all to 2 mm and 4 degrees after four
    impacts (of all forty tosses to 4 mm and 5 degrees).
    """
    settings = ImpulseSettings(restitution=0.125, iterations=50)
    times, count = SampleTimes(0.9, 0.005, True), tosses.lanes.lane_count
    box, body = (
        sound_run("impulse", lanes, base(count), times, settings)
        for lanes, base in ((tosses.lanes, still), (as_body(tosses.lanes), unmoved))
    )
    far = np.max([np.abs(box[axis] - body[axis]) for axis in "xyz"], axis=(0, 2))
    assert far.max() < 2e-3
    assert np.sum(far < 1e-4) >= 8
    np.testing.assert_allclose(body["energy_lost"], box["energy_lost"], rtol=1e-4)
    assert np.all(apart(attitudes(box)[:, -1], attitudes(body)[:, -1]) < np.deg2rad(4.0))
    np.testing.assert_array_equal(body["outcome"], box["outcome"])


@pytest.mark.thorough
def test_a_box_that_is_pushed_is_one_as_a_body_of_its_corners():
    boxes = some_boxes()
    velocity = np.array([[0.3, 0.0, 0.0], [0.0, 0.1, 0.2], [0.2, -0.1, 0.0], [1.0, 0.5, 0.0]])
    spin = np.array([[0.0, 0.3, 0.0], [0.2, 0.0, 1.0], [0.0, 0.0, 0.0], [0.0, 0.0, 2.0]])
    boxes = dataclasses.replace(boxes, release=Release(velocity, spin))
    times = SampleTimes(0.6, 0.02, True)
    box, body = (
        sound_run("impulse", lanes, base(4), times, ImpulseSettings(iterations=100))
        for lanes, base in ((boxes, still), (box_as_body(boxes), unmoved))
    )
    for name in ("x", "y", "z", "rotation", "rotation_across", "yaw", "slide"):
        # A box that moves in its plane is solved exactly. Other sweeps visit corners in another
        # order and end early, where corners slip: for a step, or, the last one, all along.
        np.testing.assert_allclose(body[name][:3], box[name][:3], atol=1e-6, err_msg=name)
        np.testing.assert_allclose(body[name][3], box[name][3], atol=1e-4, err_msg=name)


@pytest.mark.parametrize("restitution", first(1, [0.5, 0.0, 1.0]))
def test_impacts_make_no_energy(restitution):
    """At no time, with friction or without, on whatever points a boulder lands.

    But for the step: what a corner sinks before it is stopped, g dt v, is lifted again.
    """
    rng = np.random.default_rng(1)
    attitude = rng.normal(size=(12, 4))
    attitude /= np.linalg.norm(attitude, axis=1, keepdims=True)
    velocity, spin = rng.normal(size=(12, 3)), 4.0 * rng.normal(size=(12, 3))
    lanes = boulders(attitude, velocity, spin, 0.6, friction=np.repeat([0.0, 0.3, 1.0], 4))
    settings = ImpulseSettings(restitution=restitution)
    lost = np.array([
        sound_run("impulse", lanes, unmoved(12), SampleTimes(end), settings)["energy_lost"]
        for end in np.linspace(0.2, 1.4, 4)
    ])  # fmt: skip
    held = 100.0 * GRAVITY * 0.6
    assert np.diff(lost, axis=0, prepend=0.0).min() > -2e-3 * held
    if restitution == 0.0:
        assert np.diff(lost, axis=0).min() > -1e-5 * held
    if restitution == 1.0:
        # Without friction nothing else takes energy, either.
        assert np.abs(lost[:, :4]).max() < 1e-2 * held


@pytest.mark.parametrize("engine", ENGINES)
def test_a_body_on_its_base_alone_ends_as_overturned(engine):
    """Pushed hard it turns over its base, of which the other sides are not known; a boulder lives.

    The boulder lies on its side in the end.
    """
    spin, corner = np.array([[0.0, 6.0, 0.0]]), np.array([[0.2, 0.0, -0.3]])
    push = Release(-np.cross(spin, corner), spin)
    rock = body_lanes(ROCK_POINTS, ROCK_TENSOR, 1, friction=0.5)
    over = sound_run(
        engine, dataclasses.replace(rock, release=push), unmoved(1), SampleTimes(2.0, 0.1, True)
    )
    assert over["outcome"][0] == Outcome.OVERTURNED
    upright = np.array([0.0, 0.0, 0.0, 1.0])
    tumbles = boulders(upright, push.velocity[0], spin[0], 0.3)
    lies = sound_run(engine, tumbles, unmoved(1), SampleTimes(3.0, 0.1, True))
    assert lies["outcome"][0] == Outcome.AT_REST
    assert lies["peak_rotation"][0] > 1.0


@pytest.mark.thorough
def test_event_and_impulse_throw_a_boulder_alike():
    """Schemes that share no contact solver, over some twenty landings until it lies."""
    rng = np.random.default_rng(1)
    attitude = rng.normal(size=(8, 4))
    attitude /= np.linalg.norm(attitude, axis=1, keepdims=True)
    velocity, spin = rng.normal(size=(8, 3)), 4.0 * rng.normal(size=(8, 3))
    lanes = boulders(attitude, velocity, spin, 0.6)
    times = SampleTimes(2.0, 0.04, True)
    one, two = (sound_run(engine, lanes, unmoved(8), times) for engine in ("event", "impulse"))
    far = np.max([np.abs(one[axis] - two[axis]) for axis in "xyz"], axis=(0, 2))
    # The one is of first order in 0.2 ms, and impacts multiply what is left.
    assert np.median(far) < 2e-3
    np.testing.assert_array_equal(one["outcome"], two["outcome"])
    np.testing.assert_allclose(one["energy_lost"], two["energy_lost"], rtol=2e-3)


@pytest.mark.parametrize("engine", ["housner", "event", "impulse", "dem"])
def test_a_body_in_the_plane_rises_over_the_corner_it_is_pushed_over(engine):
    """(k^2 + R^2) w^2 / 2 = g (height of its turn - height at rest), R from the corner."""
    spin = np.array([-0.6, 0.4])
    base = ((-0.15, -0.5), (0.1, -0.5))
    lanes = planar_lanes(base, [0.0, 0.0], friction=1.0)
    w = np.stack([0.0 * spin, spin, 0.0 * spin], axis=-1)
    release = Release(rolling(start_corners(lanes), w), w)
    response = sound_run(
        engine, dataclasses.replace(lanes, release=release), at_rest(2), SampleTimes(0.5)
    )
    corner = np.array([0.15, 0.1])
    radius, angle = np.hypot(corner, 0.5), np.arctan2(corner, 0.5)
    rise = 0.5 * (GYRATION + radius**2) * spin**2 / GRAVITY
    wanted = angle - np.arccos((0.5 + rise) / radius)
    # On springs it has lifted before it lets go of them.
    near = 1e-2 if engine == "dem" else 1e-3
    found = [response["peak_rotation_left"][0], response["peak_rotation_right"][1]]
    np.testing.assert_allclose(found, wanted, rtol=near)
