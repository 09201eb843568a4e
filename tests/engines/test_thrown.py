"""Blocks that start in motion, in any attitude: flight, impacts, and whichever face is down."""

from __future__ import annotations

import dataclasses

import numpy as np
import numpy.typing as npt
import pytest

from tests.shared.blocks import at_rest, make_lanes
from tests.shared.flight import apart, attitudes, euler
from tests.shared.spatial_blocks import in_space, sound_run, still
from warprock.model.lanes import SpatialLanes
from warprock.model.pose import product, quaternion
from warprock.model.release import Release
from warprock.model.response import Outcome, Response, SampleTimes
from warprock.model.turning import inverse
from warprock.settings.engines import DemSettings, EventSettings, ImpulseSettings
from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]

SIZES = (0.1, 0.16, 0.24)
"""Width, depth and height of a brick that turns about no axis alike [m]."""
ENGINES = ("event", "impulse")
EVENT, IMPULSE, DEM = (
    pytest.param(name, marks=pytest.mark.thorough) for name in ("event", "impulse", "dem")
)
"""Kernels of thrown blocks take 5 s to compile, that of `event` 12. The ordinary run throws bodies,
in `test_thrown_body.py`."""
SETTINGS = {"event": EventSettings(), "impulse": ImpulseSettings(), "dem": DemSettings()}


def thrown(
    attitude: npt.ArrayLike,
    velocity: npt.ArrayLike = (0.0, 0.0, 0.0),
    spin: npt.ArrayLike = (0.0, 0.0, 0.0),
    *,
    height: npt.ArrayLike = 1.0,
    sizes: tuple[float, float, float] = SIZES,
    friction: float = 0.3,
) -> SpatialLanes:
    """Bricks that are thrown, one a row of the attitudes."""
    q = np.atleast_2d(np.asarray(attitude, dtype=float))
    count = len(q)
    flat = make_lanes(np.full(count, sizes[0]), np.full(count, sizes[2]), friction=friction)
    parts = [np.tile(np.asarray(each, dtype=float), (count, 1)) for each in (velocity, spin)]
    release = Release(*parts, q, np.broadcast_to(np.asarray(height, float), count))
    lanes = in_space(flat, depth=sizes[1])
    return dataclasses.replace(lanes, release=release)


def fly(engine: str, lanes: SpatialLanes, duration: float, settings: object = None) -> Response:
    times = SampleTimes(duration, duration / 50, places=True)
    return sound_run(engine, lanes, still(lanes.lane_count), times, settings or SETTINGS[engine])


TILTED = quaternion(np.array([0.9, -0.4, 2.0]))
SPIN = np.array([3.0, -9.0, 2.0])


@pytest.mark.parametrize("engine", [EVENT, IMPULSE, DEM])
def test_flight_is_a_parabola_and_the_turn_is_eulers(engine):
    """They fly exactly but for the turn, of second order: 5 ms, or 0.2 ms and less, at 10 rad/s."""
    velocity = np.array([1.5, -0.7, 2.0])
    response = fly(engine, thrown(TILTED, velocity, SPIN, height=1.0), 0.4)
    t = response.times
    way = velocity * t[:, None] - 0.5 * GRAVITY * t[:, None] ** 2 * np.array([0.0, 0.0, 1.0])
    place = np.stack([response[axis][0] for axis in "xyz"], axis=-1)
    # Inside a step of impulse a sample lies on its chord: off by g dt^2 / 8.
    np.testing.assert_allclose(place, way + np.array([0.0, 0.0, 1.0]), atol=5e-8)
    squares = np.square(SIZES)
    wanted = euler(TILTED, SPIN, t, np.diag(squares.sum() - squares))
    step = {"event": 5e-3, "impulse": 2e-4, "dem": 2e-4}[engine]
    assert np.all(apart(wanted, attitudes(response)[0]) < 2.0 * (10.0 * step) ** 2)
    assert np.all(np.abs(response["energy_lost"]) < 1e-9)


@pytest.mark.parametrize("engine", [EVENT, IMPULSE])
def test_a_block_may_fall_on_any_of_its_faces(engine):
    """Names of body axes do not matter: the same brick with its sides in another order.

    It is thrown on its edges and tumbles over several faces. The step turns about the axes of the
    body one after the other, so that other names have another error of second order, which impacts
    of corners make larger; it ends on the same face.
    """
    turn = quaternion(0.5 * np.pi * np.eye(3))
    # About x depth and height change places, about y width and height, about z width and depth.
    orders = ((0, 1, 2), (0, 2, 1), (2, 1, 0), (1, 0, 2))
    names = np.concatenate([[[0.0, 0.0, 0.0, 1.0]], turn])
    found = []
    for order, name in zip(orders, names, strict=True):
        sizes = tuple(SIZES[k] for k in order)
        lanes = thrown(product(TILTED, name), (0.4, 0.1, 0.0), (2.0, 6.0, 1.0), height=0.3,
                       sizes=sizes)  # fmt: skip
        response = fly(engine, lanes, 1.5)
        place = np.stack([response[axis][0] for axis in "xyz"], axis=-1)
        back = inverse(name)
        found.append((place, product(attitudes(response)[0], np.broadcast_to(back, (51, 4)))))
        assert response["impact_count"][0] > 2
        assert response["outcome"][0] == Outcome.AT_REST
    for place, turns in found[1:]:
        np.testing.assert_allclose(place, found[0][0], atol=3e-3)
        assert np.all(np.abs(np.sum(turns * found[0][1], axis=-1)) > np.cos(0.5 * 0.03))


@pytest.mark.parametrize("engine", [EVENT, IMPULSE])
def test_a_block_that_falls_flat_loses_what_it_fell(engine):
    """On each of its faces: plastic impacts leave nothing."""
    down = [(0.0, 0.0, 0.0), (np.pi, 0.0, 0.0), (0.5 * np.pi, 0.0, 0.0), (0.0, -0.5 * np.pi, 0.0)]
    lanes = thrown(quaternion(np.array(down)), height=0.3)
    response = fly(engine, lanes, 0.5)
    half = 0.5 * np.array([SIZES[2], SIZES[2], SIZES[1], SIZES[0]])
    np.testing.assert_allclose(response["z"][:, -1], half, atol=1e-6)
    fell = lanes.mass * GRAVITY * (0.3 - half)
    # impulse gives back what it sinks in a step before it is held.
    np.testing.assert_allclose(response["energy_lost"], fell, rtol=2e-3)
    np.testing.assert_allclose(
        response["rest_time"], np.sqrt(2 * (0.3 - half) / GRAVITY), atol=3e-3
    )


@pytest.mark.thorough
@pytest.mark.parametrize("restitution", [0.0, 0.5])
def test_a_block_bounces_with_its_restitution(restitution):
    """It leaves a face's blow at e times its speed: it rises e^2 times as high, to a step."""
    lanes = thrown((0.0, 0.0, 0.0, 1.0), height=0.62)
    response = fly("impulse", lanes, 0.8, ImpulseSettings(restitution=restitution))
    landed = np.sqrt(2.0 * 0.5 / GRAVITY)
    again = response["z"][0][response.times > landed + 0.01]
    assert again.max() - 0.12 == pytest.approx(restitution**2 * 0.5, abs=1e-3)


@pytest.mark.thorough
def test_bounces_neither_gain_height_nor_go_on_for_ever():
    """An elastic block keeps its height but for what a step lifts; others rest in finite time."""
    lanes, drop = thrown((0.0, 0.0, 0.0, 1.0), height=0.22), 0.1
    elastic = fly("impulse", lanes, 15.0, ImpulseSettings(restitution=1.0))
    assert elastic["impact_count"] > 50
    held = lanes.mass * GRAVITY * drop
    assert np.abs(elastic["energy_lost"]) < 2e-3 * held
    bouncy = fly("impulse", lanes, 2.0, ImpulseSettings(restitution=0.8))
    first = np.sqrt(2.0 * drop / GRAVITY)
    assert bouncy["rest_time"] == pytest.approx(first * (1.0 + 2.0 * 0.8 / 0.2), abs=1e-2)


@pytest.mark.thorough
@pytest.mark.parametrize("restitution", [0.5, 1.0])
def test_bounces_with_friction_make_no_energy(restitution):
    """Bricks that come down on corners, whatever the friction: where Newton's law would make some.

    What a step lifts of what a corner sinks, it gives back: 0.5 % of the drop at most.
    """
    rng, count = np.random.default_rng(5), 192
    q = rng.normal(size=(count, 4))
    q /= np.linalg.norm(q, axis=1)[:, None]
    release = Release(
        2.0 * rng.normal(size=(count, 3)), 8.0 * rng.normal(size=(count, 3)), q, np.full(count, 0.6)
    )
    lanes = dataclasses.replace(
        thrown(q), release=release, friction=rng.choice([0.0, 0.1, 0.3, 0.6, 1.0], count)
    )
    response = fly("impulse", lanes, 1.0, ImpulseSettings(restitution=restitution))
    assert response["impact_count"].mean() > 2
    assert np.all(response["energy_lost"] > -5e-3 * lanes.mass * GRAVITY * 0.6)


@pytest.mark.parametrize("engine", [EVENT, IMPULSE])
def test_a_block_that_slides_stops_where_friction_ends(engine):
    """v^2 / (2 mu g), from a start flat on the base; too low to tip over its edge."""
    lanes = in_space(make_lanes(0.4, 0.1, friction=0.3))
    release = Release(np.array([[1.0, 0.0, 0.0]]), np.zeros((1, 3)))
    response = fly(engine, dataclasses.replace(lanes, release=release), 0.6)
    assert response["residual_slide"][0] == pytest.approx(1.0 / (2 * 0.3 * GRAVITY), rel=2e-3)
    assert response["peak_tilt"][0] < 1e-6


@pytest.mark.thorough
def test_a_spin_goes_on_where_a_sliding_corner_comes_to_a_stand():
    """A block tips onto an edge and slides on both of its ends; one stops, the other goes past it.

    Whether the other end opens for a moment there hangs on the step; where it closes again it goes
    on to slide, at 0.44 m/s. Steps of 5 ms are off by 4e-4 rad and 6e-6 m, shorter ones by at most
    2e-5 rad, as `impulse` is at 0.1 ms.
    """
    lanes = in_space(make_lanes(0.3, 0.8, friction=0.5), depth=0.2, yaw_start=0.4)
    release = Release(np.array([[1.0, 0.5, 0.0]]), np.array([[0.0, 0.0, 2.0]]))
    pushed = dataclasses.replace(lanes, release=release)
    fine = ImpulseSettings(frames_per_second=1000.0, substeps=9)
    wanted = fly("impulse", pushed, 0.3, fine)
    place = np.stack([wanted[axis][0] for axis in "xyz"], axis=-1)
    for step in (5e-3, 2.5e-3, 1.25e-3, 6e-4, 3e-4, 1.5e-4):
        found = fly("event", pushed, 0.3, EventSettings(time_step=step))
        np.testing.assert_allclose(found["yaw"][0], wanted["yaw"][0], atol=1e-3)
        at = np.stack([found[axis][0] for axis in "xyz"], axis=-1)
        np.testing.assert_allclose(at, place, atol=3e-5)


@pytest.mark.parametrize(
    "engine", [EVENT, IMPULSE, "housner", "planar event", "planar impulse", "planar dem"]
)
def test_a_block_that_is_pushed_rises_as_far_as_its_energy(engine):
    """(2/3) R^2 w^2 = g R (cos(alpha - theta) - cos(alpha)), about the edge that it turns on."""
    spin = np.array([0.3, -0.5])
    lanes = make_lanes([0.5, 0.5], [2.0, 2.0], friction=0.8)
    radius, angle = np.hypot(0.25, 1.0), np.arctan2(0.25, 1.0)
    wanted = angle - np.arccos(np.cos(angle) + 2.0 / 3.0 * radius * spin**2 / GRAVITY)
    w = np.stack([0.0 * spin, spin, 0.0 * spin], axis=-1)
    edge = np.stack([np.sign(spin) * 0.25, 0.0 * spin, 0.0 * spin - 1.0], axis=-1)
    release = Release(-np.cross(w, edge), w)
    times = SampleTimes(1.0)
    if engine in ENGINES:
        blocks = dataclasses.replace(in_space(lanes), release=release)
        response = sound_run(engine, blocks, still(2), times, SETTINGS[engine])
    else:
        blocks = dataclasses.replace(lanes, release=release)
        response = sound_run(engine.split()[-1], blocks, at_rest(2), times)
    # It sinks into springs, and has lifted before it lets go of them.
    near = 5e-3 if engine == "planar dem" else 1e-3
    np.testing.assert_allclose(response["peak_rotation"], wanted, rtol=near)
    assert np.all(response["uplift_time"] <= 1e-3)


@pytest.mark.thorough
def test_springs_at_eight_corners_bear_a_block_on_each_of_its_faces():
    """dem: it sinks by its weight over four springs, and has turned as the other engines have."""
    down = [(0.0, 0.0, 0.0), (0.0, 1.45, 0.1), (0.0, -1.3, 0.2)]
    lanes = thrown(quaternion(np.array(down)), height=0.3)
    soft, rigid = (fly(engine, lanes, 1.5) for engine in ("dem", "impulse"))
    np.testing.assert_allclose(soft["z"][:, -1], rigid["z"][:, -1], atol=1e-4)
    # Springs give a part of a blow back: it comes down a little beside.
    assert np.all(apart(attitudes(soft)[:, -1], attitudes(rigid)[:, -1]) < 0.2)
    assert np.all(soft["outcome"] == Outcome.AT_REST)


def test_dem_declines_a_block_that_is_pushed():
    from warprock.engines import engine_class
    from warprock.model.scene import scene_kind

    release = Release(np.zeros((1, 3)), np.array([[0.0, 0.3, 0.0]]))
    lanes = dataclasses.replace(in_space(make_lanes(0.5, 2.0)), release=release)
    scene = scene_kind(lanes, still(1), restitution_given=False)
    assert "dem lets blocks go from rest, or thrown" in engine_class("dem").supports(scene)
