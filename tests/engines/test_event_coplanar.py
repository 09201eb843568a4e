"""Stacks in space that move in one vertical plane run as stacks in that plane."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from tests.shared.blocks import make_stacks, sines
from tests.shared.spatial_blocks import along, in_space
from warprock.engines.base import KernelEngine
from warprock.engines.event import Event
from warprock.model.coplanar import find_coplanar
from warprock.model.lanes import Lanes, SpatialLanes
from warprock.model.motion import Control, PlanarMotions, SpatialMotions
from warprock.model.response import Response, SampleTimes, Status
from warprock.running.batch import run_batch
from warprock.settings.engines import EventSettings
from warprock.units import GRAVITY

TIMES = SampleTimes(1.0, 0.02, places=True)
COUNT = 4


def pairs() -> Lanes:
    """Pairs in the plane, the upper block aside."""
    aside = np.stack([np.zeros(COUNT), np.linspace(0.0, 0.02, COUNT)], axis=1)
    return make_stacks([0.2, 0.18], [0.6, 0.5], friction=0.6, offset=aside)


def shaking() -> PlanarMotions:
    """One cycle at 4 Hz of several strengths."""
    strength = np.linspace(0.4, 0.6, COUNT) * GRAVITY
    return sines(Control.ACCELERATION, strength, np.full(COUNT, 4.0), 1.0)


def run(lanes: Lanes, motions: PlanarMotions | SpatialMotions) -> Response:
    found = run_batch("event", lanes, motions, TIMES)
    assert np.all(found["status"] == Status.OK)
    return found


def turned(flat: Lanes, motion: PlanarMotions, yaw: float) -> tuple[SpatialLanes, SpatialMotions]:
    """Pairs and their motion, both turned about the vertical [rad]."""
    lanes = in_space(flat, yaw_start=yaw, offset_across=np.sin(yaw) * flat.offset)
    lanes = dataclasses.replace(lanes, offset=np.cos(yaw) * flat.offset)
    one = np.ones(COUNT)
    return lanes, along(motion.scaled(np.cos(yaw) * one), motion.scaled(np.sin(yaw) * one))


@pytest.mark.thorough
def test_with_a_box_of_friction_they_run_in_space() -> None:
    """The box lies along x and y of the ground: the plane of the stack is none of symmetry."""
    flat = dataclasses.replace(pairs(), friction=np.full((COUNT, 2), 0.3))
    lanes, motions = turned(flat, shaking(), 0.7)
    engine = Event(EventSettings(friction_box=1))
    here, space = engine.run(lanes, motions, TIMES), KernelEngine.run(engine, lanes, motions, TIMES)
    cone = Event(EventSettings()).run(lanes, motions, TIMES)
    # The box bears up to sqrt(2) times what the cone does: .1 mm of slide here, round-off 1e-14.
    assert np.abs(here["slide"] - cone["slide"]).max() > 1e-5
    for name in ("rotation", "rotation_across", "x", "y", "slide", "slide_across"):
        np.testing.assert_array_equal(here[name], space[name], err_msg=name)


def test_they_have_the_response_of_the_plane_along_their_width_or_their_depth() -> None:
    flat, motion = pairs(), shaking()
    plane = run(flat, motion)
    here = run(in_space(flat), along(motion))
    assert plane["impact_count"].min() >= 2
    for name in ("rotation", "x", "z", "slide", "peak_rotation", "residual_slide", "peak_slide"):
        np.testing.assert_allclose(here[name], plane[name], rtol=0.0, atol=1e-14, err_msg=name)
    np.testing.assert_array_equal(here["peak_tilt"], plane["peak_rotation"])
    for name in ("rotation_across", "yaw", "y", "slide_across", "peak_yaw"):
        assert np.all(here[name] == 0.0), name
    across = in_space(flat, offset_across=flat.offset)
    zero = np.zeros_like(flat.width)
    across = dataclasses.replace(across, width=flat.depth, depth=flat.width, offset=zero)
    there = run(across, along(motion.scaled(np.zeros(COUNT)), motion))
    for name, other in (("rotation_across", "rotation"), ("y", "x"), ("slide_across", "slide")):
        np.testing.assert_allclose(there[name], plane[other], rtol=0.0, atol=1e-14, err_msg=name)
    np.testing.assert_array_equal(there["peak_rotation_across"], here["peak_rotation"])


def test_a_turned_scene_has_the_turned_response() -> None:
    yaw = 0.7
    flat, motion = pairs(), shaking()
    plane = run(flat, motion)
    here = run(*turned(flat, motion, yaw))
    # Round-off of the cosine, which impacts magnify.
    exact = {"rtol": 0.0, "atol": 1e-9}
    np.testing.assert_allclose(here["peak_tilt"], plane["peak_rotation"], **exact)
    np.testing.assert_allclose(here["x"], np.cos(yaw) * plane["x"], **exact)
    np.testing.assert_allclose(here["y"], np.sin(yaw) * plane["x"], **exact)
    tilted = np.tan(plane["rotation"]) * np.cos(yaw)
    np.testing.assert_allclose(np.tan(here["rotation"]), tilted, **exact)
    np.testing.assert_allclose(here["slide_across"], np.sin(yaw) * plane["slide"], **exact)
    assert np.allclose(here["yaw"], yaw, rtol=0.0, atol=1e-12)


@pytest.mark.parametrize(
    "change",
    ["offset_across", "yaw_start", "rotation_start", "gap_start", "centre_offset_y", "base"],
)
def test_what_leads_out_of_the_plane_leaves_them_in_space(change: str) -> None:
    flat, motion = pairs(), shaking()
    lanes, base = in_space(flat), along(motion)
    assert find_coplanar(lanes, base).within.all()
    some = np.zeros((COUNT, 2))
    some[1, 1] = 1e-6
    if change == "base":
        base = along(motion, motion.scaled(some[:, 1]))
    else:
        lanes = dataclasses.replace(lanes, **{change: some})
    np.testing.assert_array_equal(find_coplanar(lanes, base).within, some[:, 1] == 0.0)


@pytest.mark.thorough
def test_the_equations_of_space_find_the_same_motion_to_second_order() -> None:
    flat, motion = pairs(), shaking()
    times = SampleTimes(0.4, 0.02)
    fine = run_batch("event", flat, motion, times, settings=EventSettings(time_step=2.5e-4))
    errors = []
    for step in (4e-3, 1e-3):
        space = KernelEngine.run(
            Event(EventSettings(time_step=step)), in_space(flat), along(motion), times
        )
        errors.append(np.abs(space["rotation"] - fine["rotation"]).max())
    # A quarter of the step leaves a sixteenth of the error.
    assert errors[0] <= 1e-3
    assert errors[1] <= errors[0] / 8.0


@pytest.mark.thorough
def test_lanes_in_the_plane_and_out_of_it_share_a_batch() -> None:
    flat, motion = pairs(), shaking()
    yaw = np.zeros((COUNT, 2))
    yaw[1::2, 1] = 0.1
    lanes, base = in_space(flat, yaw_start=yaw), along(motion)
    together = run(lanes, base)
    for lane in range(COUNT):
        one = np.array([lane])
        alone = run(lanes.take(one), base.take(one))
        for name, values in together.fields.items():
            np.testing.assert_array_equal(alone[name], values[one], err_msg=name)
