"""Planar scenes of the shipped cases, run in space: the same laws give the same rotations."""

from __future__ import annotations

import dataclasses
from typing import NamedTuple

import numpy as np
import pytest

from tests.shared.blocks import Array, make_lanes, sines
from tests.shared.marks import first
from tests.shared.spatial_blocks import along, in_space, unmoved
from tests.shared.vertical_motion import flights
from warprock.case.lanes import expand_lanes
from warprock.case.load import load_case
from warprock.engines import engine_class
from warprock.engines.launching import Form, Target
from warprock.model.bodies import Bodies
from warprock.model.lanes import Lanes, SpatialLanes
from warprock.model.motion import (
    Control,
    PlanarMotions,
    SpatialMotions,
    StillBase,
    UprightMotions,
    no_motion,
)
from warprock.model.response import Response, SampleTimes, Status
from warprock.running.batch import run_batch
from warprock.settings.engines import DemSettings, EventSettings, ImpulseSettings

TIMES = SampleTimes(2.0, 0.01)
DISPLACEMENT, OTHERS = slice(0, 6), slice(6, 18)
"""Lanes of the sine pulses under displacement control, with velocity steps, and from rest."""


def scene(case: str) -> tuple[Lanes, PlanarMotions]:
    """Lanes and motions of a shipped case."""
    found = expand_lanes(load_case(case))
    return found.lanes, found.motions


def apart(engine: str, case: str, planar: object, spatial: object) -> Array:
    """Largest difference of the rotations in the plane and in space, over the slenderness angle.

    Args:
        engine: Name of the engine.
        case: Name of the case.
        planar: Settings in the plane, spatial those in space.
        spatial: See planar.
    """
    lanes, motions = scene(case)
    base = unmoved(lanes.lane_count) if isinstance(motions, StillBase) else along(motions)
    there = run_batch(engine, lanes, motions, TIMES, settings=planar)
    here = run_batch(engine, in_space(lanes), base, TIMES, settings=spatial)
    for response in (there, here):
        assert np.all(response["status"] == Status.OK)
    gap = np.abs(here["rotation"] - there["rotation"]).max(axis=1)
    return np.asarray(gap / lanes.slenderness_angle)


@pytest.mark.parametrize("case", ["free-b0", "free-b1-b3", "single-sine-pulse"])
def test_dem_at_one_step(case: str) -> None:
    # A thin block has stiffer modes across the plane, and with them a shorter stable step in space.
    settings = DemSettings(time_step=2e-4)
    # Other sums: round-off, which every opening of a spring magnifies.
    assert np.all(apart("dem", case, settings, settings) <= 1e-8)


@pytest.mark.parametrize(
    "case",
    ["free-b0", "free-b1-b3", pytest.param("single-sine-pulse", marks=pytest.mark.thorough)],
)
def test_impulse_with_sweeps_that_have_settled(case: str) -> None:
    space = ImpulseSettings()
    # Free blocks do not slide: a hundred sweeps are as good as a thousand.
    plane = dataclasses.replace(space, iterations=1000 if case == "single-sine-pulse" else 100)
    found = apart("impulse", case, plane, space)
    if case == "single-sine-pulse":
        # Where corners slide, after a velocity step, space sweeps ten times, too.
        assert np.all(found[DISPLACEMENT] <= 1e-5)
        found = found[OTHERS]
    # Space stops contacts that hold at once. Round-off, which impacts magnify.
    assert np.all(found <= 1e-6)
    # With ten sweeps in the plane blocks that lift slowly differ by what these leave.
    few = apart("impulse", case, space, space)
    assert np.all(few <= 1e-2)


def boxes_on_points(lanes: SpatialLanes) -> SpatialLanes:
    """Boxes as bodies that stand on the corners of their bottom faces."""
    x, y, z = lanes.width, lanes.depth, lanes.height
    sides = ((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5))
    squares = np.stack([y * y + z * z, x * x + z * z, x * x + y * y], axis=-1)
    body = Bodies(
        mass=lanes.mass,
        gyration=squares / 12.0,
        points=np.stack([np.stack([a * x, b * y, -0.5 * z], axis=-1) for a, b in sides], axis=1),
        count=np.full(len(x), 4, np.int32),
        corner_radius=np.zeros(len(x)),
        axes=np.tile((0.0, 0.0, 0.0, 1.0), (len(x), 1)),
    )
    return dataclasses.replace(lanes, body=body)


@pytest.mark.thorough
@pytest.mark.parametrize("kind", ["packed", "box", "plain", "points"])
def test_event_in_flights_and_landings(kind: str) -> None:
    # Edges that let go, slide, fly and land as a whole, at random.
    lanes, x, z = flights(160, seed=0)
    times, settings = SampleTimes(2.0, 0.01), EventSettings(time_step=1e-3)
    there = engine_class("event")(settings).run(lanes, UprightMotions(x, z), times)
    spatial, target = in_space(lanes), Target(form=Form.PLAIN if kind == "plain" else None)
    spatial = boxes_on_points(spatial) if kind == "points" else spatial
    settings = dataclasses.replace(settings, friction_box=int(kind == "box"))
    here = engine_class("event")(settings, target).run(spatial, along(x, z=z), times)
    for response in (there, here):
        assert np.all(response["status"] == Status.OK)
    assert np.median(there["impact_count"]) >= 3
    # Friction as a box is found from unlike sums for either end: round-off, which impacts magnify.
    aside = 1e-12 if kind == "box" else 0.0
    assert np.all(np.abs(here["rotation_across"]) <= aside)
    # Both are of second order, and impacts magnify what they err by to 1e-3 rad at most.
    gap = np.abs(here["rotation"] - there["rotation"]).max(axis=1)
    assert gap.max() < 5e-3
    assert np.median(gap) < 1e-5


COUNT = 64


class Planar(NamedTuple):
    """Blocks that leave the ground, land flat and slide, in one plane.

    Sizes are across the plane (`depth`) and in it; `lean` [rad] and `offset` of the centre [m] are
    towards +. The base moves by a sine of acceleration along the plane and one upwards.
    """

    width: Array
    depth: Array
    height: Array
    friction: Array
    lean: Array
    offset: Array
    along: PlanarMotions
    up: PlanarMotions

    def mirrored(self) -> Planar:
        """The mirror image."""
        back = self.along.scaled(np.full(len(self.width), -1.0))
        return self._replace(lean=-self.lean, offset=-self.offset, along=back)

    def blocks(self, *, across: bool = False, yaw: float = 0.0) -> SpatialLanes:
        """The blocks, their plane along x, along y, or turned from x by a yaw [rad]."""
        if across:
            lanes = make_lanes(self.depth, self.height, friction=self.friction)
            return in_space(
                lanes, depth=self.width, rotation_across_start=self.lean,
                centre_offset_y=self.offset,
            )  # fmt: skip
        lanes = make_lanes(self.width, self.height, friction=self.friction)
        return in_space(
            lanes, depth=self.depth, rotation_start=self.lean, centre_offset_x=self.offset,
            yaw_start=yaw,
        )  # fmt: skip

    def base(self, *, across: bool = False, yaw: float = 0.0) -> SpatialMotions:
        """The motion of the base of these blocks."""
        if across:
            return along(no_motion(self.along), self.along, self.up)
        one = np.ones(len(self.width))
        x, y = (self.along.scaled(part(yaw) * one) for part in (np.cos, np.sin))
        return along(x, y, self.up)


def random_planar(vertical: float, count: int = COUNT) -> Planar:
    """Random blocks; `vertical` is a factor of the motion upwards, up to 15 m/s^2."""
    rng = np.random.default_rng(3)
    low, high = [[0.1], [0.1], [0.4]], [[1.0], [1.0], [6.0]]
    width, depth, height = rng.uniform(low, high, (3, count))
    leans, eccentric = rng.random((2, count)) < 0.4
    lean = np.where(leans, rng.uniform(-0.8, 0.8, count), 0.0) * np.arctan2(width, height)
    offset = np.where(eccentric, 0.1 * width * rng.uniform(-1.0, 1.0, count), 0.0)
    strength = rng.uniform(1.0, 12.0, count) * rng.choice([-1.0, 1.0], count)
    often = rng.uniform(1.0, 5.0, (2, count))
    way = sines(Control.ACCELERATION, strength, often[0], 2.0, start=0.1)
    lift = vertical * rng.uniform(-15.0, 15.0, count)
    up = sines(Control.ACCELERATION, lift, often[1], 3.0)
    friction = rng.uniform(0.1, 1.2, count)
    return Planar(width, depth, height, friction, lean, offset, way, up)


@pytest.mark.parametrize("depth", [0.3, 0.5, 0.9])
def test_impulse_keeps_a_block_that_lands_flat_and_slides_in_its_plane(depth: float) -> None:
    block = in_space(make_lanes(0.9, 6.0, friction=0.9), depth=depth)
    way = sines(Control.ACCELERATION, 6.4, 4.0, 1.0, start=0.13)
    base = along(way, None, sines(Control.ACCELERATION, -10.7, 2.9, 3.0))
    found, truth = (run_batch(engine, block, base, TIMES) for engine in ("impulse", "event"))
    assert found["peak_yaw"] == found["peak_rotation_across"] == 0.0
    assert found["impact_count"] == truth["impact_count"] == 5
    # A slide of 0.43 mm; the step is of first order: 6e-6 m at a tenth of it.
    np.testing.assert_allclose(found["peak_slide"], truth["peak_slide"], atol=3e-6)
    np.testing.assert_allclose(found["peak_rotation"], truth["peak_rotation"], atol=5e-5)


@pytest.mark.parametrize(
    ("precision", "box"), first(1, [("float64", 0), ("float64", 1), ("float32", 0)])
)
@pytest.mark.parametrize("vertical", [0.0, 1.0])
@pytest.mark.parametrize("across", first(1, [True, False]))
def test_impulse_stays_in_the_plane_wherever_it_lands_and_slides(
    across: bool, vertical: float, precision: str, box: int
) -> None:
    scene = random_planar(vertical)
    found, image = (
        run_batch(
            "impulse", each.blocks(across=across), each.base(across=across), TIMES,
            precision=precision, settings=ImpulseSettings(friction_box=box),
        )
        for each in (scene, scene.mirrored())
    )  # fmt: skip
    own, other = ("rotation", "rotation_across")[:: -1 if across else 1]
    # Corners visited in turn left it in more than half of the lanes that a base throws, by up to
    # 2 rad. Along the axes of the base nothing is rounded that would lead out of the plane.
    assert found["impact_count"].sum() > 100
    assert np.all(found["peak_yaw"] == 0.0)
    assert np.all(found[f"peak_{other}"] == 0.0)
    np.testing.assert_array_equal(found[own], -image[own])


def turned_planar(vertical: float, precision: str) -> tuple[Response, Response]:
    """Blocks that stand straight, and the same turned about the vertical."""
    scene, yaw = random_planar(vertical)._replace(lean=np.zeros(COUNT)), 0.7
    ahead, found = (
        run_batch("impulse", scene.blocks(yaw=by), scene.base(yaw=by), TIMES, precision=precision)
        for by in (0.0, yaw)
    )
    return ahead, found


@pytest.mark.parametrize("vertical", first(1, [1.0, 0.0]))
def test_impulse_stays_in_a_plane_in_any_direction(vertical: float) -> None:
    ahead, found = turned_planar(vertical, "float64")
    # Round-off, which impacts magnify.
    assert np.all(found["peak_yaw"] <= 1e-11)
    np.testing.assert_allclose(found["peak_tilt"], ahead["peak_tilt"], atol=1e-6)


@pytest.mark.thorough
@pytest.mark.parametrize("vertical", [0.0, 1.0])
def test_impulse_in_float32_stays_near_a_plane_in_any_direction(vertical: float) -> None:
    # Components of a base in float32 are rounded each on its own.
    assert np.all(turned_planar(vertical, "float32")[1]["peak_yaw"] <= 0.02)


@pytest.mark.thorough
@pytest.mark.parametrize("vertical", [0.0, 1.0])
def test_impulse_in_space_is_the_planar_step_with_sweeps_that_have_settled(vertical: float) -> None:
    # Hundreds of sweeps a step are what costs.
    scene = random_planar(vertical, 16)
    scene = scene._replace(offset=np.zeros(16))
    angle = np.arctan2(scene.width, scene.height)
    lanes = make_lanes(scene.width, scene.height, scene.lean / angle, scene.friction)
    base = UprightMotions(scene.along, scene.up)
    settled = ImpulseSettings(iterations=300)
    plane = run_batch("impulse", lanes, base, TIMES, settings=settled)
    space = run_batch("impulse", scene.blocks(), scene.base(), TIMES)
    gap = np.abs(space["peak_rotation"] - plane["peak_rotation"]) / angle
    # What is left of sweeps, and impacts magnify.
    assert np.median(gap) <= 1e-9
    assert np.all(gap <= 5e-3)
    event = run_batch("event", lanes, base, TIMES)
    far = np.abs(space["peak_rotation"] - event["peak_rotation"]) / angle
    # First order in the time step; flights and impacts magnify the error of a few lanes.
    assert np.quantile(far, 0.9) <= 1e-2
