"""Where blocks are at the samples, against closed forms and between engines."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from tests.shared.blocks import (
    Array,
    at_rest,
    make_lanes,
    make_stacks,
    sines,
    single_block_engines,
    velocity_steps,
)
from tests.shared.spatial_blocks import along, in_space, unmoved
from warprock.engines import engine_class
from warprock.model.lanes import Lanes
from warprock.model.motion import Control, GroundMotions
from warprock.model.response import Response, SampleTimes, Status
from warprock.running.batch import run_batch
from warprock.units import GRAVITY

TIMES = SampleTimes(0.6, 0.007, places=True)
"""No multiple of any step, so that samples lie inside of steps."""

EXACT = ("housner", "event")
"""Engines whose blocks keep their corners on the base to round-off."""

every_engine = pytest.mark.parametrize("engine", single_block_engines())


def on_corner(lanes: Lanes, rotation: Array) -> tuple[Array, Array]:
    """Centres of blocks that turn about corners which stay where they are [m]."""
    side, size = np.where(rotation < 0.0, -1.0, 1.0), np.abs(rotation)
    b, h = 0.5 * lanes.width[:, None], 0.5 * lanes.height[:, None]
    return (
        side * (b - b * np.cos(size) + h * np.sin(size)),
        b * np.sin(size) + h * np.cos(size),
    )


@every_engine
def test_a_block_that_does_not_slide_is_where_its_rotation_says(engine: str) -> None:
    lanes = make_lanes(np.full(3, 0.5), np.array([0.75, 1.0, 1.25]), np.array([0.3, -0.5, 0.9]))
    response = run_batch(engine, lanes, at_rest(3), TIMES)
    x, z = on_corner(lanes, response["rotation"])
    # What the lane itself says of its slide and its penetration, which are none of `housner`; hops
    # and the springs of `dem` raise it by no more.
    off, exact = response["peak_slide"] + response["peak_penetration"], engine in EXACT
    most = 2.0 * off[:, None] + (1e-12 if exact else 1e-5)
    # Peaks are those of the ends of steps; within them corners slip back and forth.
    dust = 1e-12 if exact else 1e-6 if engine == "dem" else 1e-8
    assert np.all(np.abs(response["slide"]) <= response["peak_slide"][:, None] + dust)
    assert np.all(np.abs(response["x"] - x) <= most)
    assert np.all(np.abs(response["z"] - z) <= most)


def sliding(engine: str, *, spatial: bool) -> Response:
    """A wide block on a base that sets out at 1 m/s."""
    lanes: Lanes = make_lanes(1.0, 0.5, friction=0.4)
    motions: GroundMotions = velocity_steps(np.array([1.0]), np.array([0.0]), np.array([5.0]))
    if spatial:
        lanes, motions = in_space(lanes), along(motions)
    return run_batch(engine, lanes, motions, TIMES)


SLIDING = [
    (name, spatial)
    for name in single_block_engines()
    for spatial in (False, True)
    if engine_class(name).slides and (engine_class(name).spatial or not spatial)
]


@pytest.mark.parametrize(("engine", "spatial"), SLIDING)
def test_a_flat_block_slides_as_friction_stops_it(engine: str, spatial: bool) -> None:
    response = sliding(engine, spatial=spatial)
    # It stays behind by t, less what friction brings it back by; it stops at 1 / (0.4 g).
    t = np.minimum(TIMES.times, 1.0 / (0.4 * GRAVITY))
    expected = -t + 0.5 * 0.4 * GRAVITY * t**2
    # A step of 5 ms ends where the block stops; the first-order ones err by some dt x 1 m/s.
    most = {"event": 1e-12, "dem": 2e-3}.get(engine, 4e-4)
    np.testing.assert_allclose(response["x"][0], expected, rtol=0.0, atol=most)
    np.testing.assert_allclose(response["slide"][0], response["x"][0], rtol=0.0, atol=1e-4)
    sinks = 1e-3 if engine == "dem" else 1e-6
    np.testing.assert_allclose(response["z"][0], 0.25, rtol=0.0, atol=sinks)


@every_engine
def test_a_block_at_rest_stays_where_it_is(engine: str) -> None:
    lanes = make_lanes(0.3, 1.0)
    response = run_batch(engine, lanes, at_rest(1), TIMES)
    # Sweeps that end early leave a remainder.
    assert np.max(np.abs([response["x"], response["slide"]])) <= 1e-9
    # On springs it stands lower, by its weight over their stiffness.
    assert np.all(np.abs(response["z"] - 0.5) <= (1e-3 if engine == "dem" else 1e-7))
    assert np.ptp(response["z"]) <= 1e-7


def test_without_places_histories_are_rotations_alone() -> None:
    lanes, bare = make_lanes(0.3, 1.0, 0.5), dataclasses.replace(TIMES, places=False)
    whole = run_batch("event", lanes, at_rest(1), TIMES)
    alone = run_batch("event", lanes, at_rest(1), bare)
    assert set(whole.fields) - set(alone.fields) == {"slide", "x", "z"}
    for name, values in alone.fields.items():
        np.testing.assert_array_equal(values, whole[name], err_msg=name)


def test_stacked_blocks_are_where_the_analytical_model_puts_them() -> None:
    # Before any impact both engines follow the same equations: second order in the step of `event`.
    lanes = make_stacks([[0.3, 0.2]], [[0.6, 0.5]], rotation=[[0.05, 0.12]])
    times = SampleTimes(0.1, 0.007, places=True)
    there, here = (run_batch(name, lanes, at_rest(1), times) for name in ("two-block", "event"))
    assert there["status"][0] == Status.OK
    for name in ("rotation", "x", "z"):
        np.testing.assert_allclose(here[name], there[name], rtol=0.0, atol=2e-5, err_msg=name)
    assert np.max(np.abs([there["slide"], here["slide"]])) <= 1e-6


def test_stacks_slide_as_a_single_block_does() -> None:
    # The lower block is the single one that slides, with a small one upon it that sticks.
    lanes = make_stacks([[1.0, 0.4]], [[0.5, 0.2]], friction=[[0.3, 1.0]], offset=[[0.0, 0.1]])
    motions = sines(Control.ACCELERATION, 0.6 * GRAVITY, 2.0, cycles=1.0)
    single = make_lanes(1.0, 0.5, friction=0.3)
    stack, alone = (run_batch("event", each, motions, TIMES) for each in (lanes, single))
    assert np.max(np.abs(alone["slide"])) > 0.02
    np.testing.assert_allclose(stack["slide"][:, 0], alone["slide"], rtol=0.0, atol=2e-3)
    np.testing.assert_allclose(stack["x"][:, 1], stack["x"][:, 0] + 0.1, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(stack["z"][:, 1], 0.6, rtol=0.0, atol=1e-9)


def test_the_middle_of_the_box_is_told_and_not_the_centre_of_mass() -> None:
    lanes = in_space(
        make_lanes(0.4, 1.0), centre_offset_x=0.05, centre_offset_y=-0.02, yaw_start=np.pi / 2
    )
    response = run_batch("event", lanes, unmoved(1), TIMES)
    for name, place in (("x", 0.0), ("y", 0.0), ("z", 0.5)):
        np.testing.assert_allclose(response[name][0], place, rtol=0.0, atol=1e-12, err_msg=name)
    quarter = np.sqrt(0.5)
    for part, value in zip("xyzw", (0.0, 0.0, quarter, quarter), strict=True):
        np.testing.assert_allclose(response[f"attitude_{part}"][0], value, rtol=0.0, atol=1e-12)
