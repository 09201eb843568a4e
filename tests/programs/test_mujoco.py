"""MuJoCo beside the engines: bodies in space as the hull of their contact points."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from tests.shared.blocks import make_stacks
from tests.shared.flight import apart, attitudes
from tests.shared.space_bodies import (
    BOULDER,
    ROCK_POINTS,
    ROCK_TENSOR,
    body_lanes,
    box_as_body,
)
from tests.shared.spatial_blocks import sound_run, spatial_lanes, still
from tests.shared.stack_bodies import shaken, with_body
from warprock.engines.impulse import Impulse
from warprock.engines.launching import Form, Target
from warprock.errors import DeclinedError
from warprock.model.motion import StillBase
from warprock.model.pose import quaternion
from warprock.model.release import Release
from warprock.model.response import SampleTimes
from warprock.programs.scene import peer_scenes
from warprock.programs.table import require_scenes, run_program
from warprock.settings.programs import BulletSettings, MujocoSettings

pytest.importorskip("mujoco")
pytestmark = pytest.mark.extra

TIMES = SampleTimes(0.6, 0.05, True)
TURNS = ("rotation", "rotation_across", "yaw")


def test_the_hull_of_a_rock_rocks_as_impulse_says():
    lanes = body_lanes(
        ROCK_POINTS, ROCK_TENSOR, 2, friction=0.6, rotation_start=[-0.2, 0.1],
        rotation_across_start=[0.05, -0.25],
    )  # fmt: skip
    settings = MujocoSettings(steps_per_second=8000)
    answer = run_program("mujoco", lanes, still(2), TIMES, settings).response
    ours = sound_run("impulse", lanes, still(2), TIMES)
    assert np.all(ours["impact_count"] >= 4)
    # Its contacts are soft: 4e-4 rad apart at 2000 steps a second, half of that at 8000.
    for name in TURNS:
        np.testing.assert_allclose(answer[name], ours[name], atol=1e-3)
    for name in ("x", "y", "z"):
        np.testing.assert_allclose(answer[name], ours[name], atol=1e-3)


def test_a_boulder_that_is_thrown_lands_as_impulse_says():
    """Over seven landings on top, side and base; MuJoCo's contacts are soft, and late by a step."""
    spin, attitude = np.array([2.0, 5.0, -1.0]), quaternion(np.array([0.5, 0.2, 1.0]))
    lanes = body_lanes(BOULDER, ROCK_TENSOR, 1, friction=0.6)
    release = Release(np.array([[0.5, 0.2, 0.0]]), spin[None], attitude[None], np.array([0.6]))
    lanes, times = dataclasses.replace(lanes, release=release), SampleTimes(0.6, 0.05, True)
    settings = MujocoSettings(steps_per_second=8000)
    answer = run_program("mujoco", lanes, still(1), times, settings).response
    ours = sound_run("impulse", lanes, still(1), times)
    assert ours["impact_count"][0] >= 5
    assert apart(attitudes(answer), attitudes(ours)).max() < 5e-3
    for name in ("x", "y", "z"):
        np.testing.assert_allclose(answer[name], ours[name], atol=2e-3)


def test_a_box_as_a_hull_moves_as_the_box_does():
    lanes = spatial_lanes(
        [0.2], [0.6], friction=0.6, rotation_start=0.15, rotation_across_start=0.1
    )
    lanes = dataclasses.replace(lanes, depth=np.array([0.3]))
    settings = MujocoSettings()
    box = run_program("mujoco", lanes, still(1), TIMES, settings).response
    hull = run_program("mujoco", box_as_body(lanes), still(1), TIMES, settings).response
    # Contacts of a mesh are found by another routine: the last digits differ, and impacts multiply.
    for name in TURNS:
        np.testing.assert_allclose(hull[name], box[name], atol=1e-4)


def test_a_scene_tells_the_tensor_in_the_axes_of_the_block():
    body = peer_scenes(body_lanes(ROCK_POINTS, ROCK_TENSOR, 1), still(1), TIMES)[0].blocks[0].body
    assert body is not None
    xx, yy, zz, xy, xz, yz = np.array(body.tensor) / 100.0
    found = np.array([(xx, xy, xz), (xy, yy, yz), (xz, yz, zz)])
    np.testing.assert_allclose(found, ROCK_TENSOR, atol=1e-15)
    np.testing.assert_allclose(body.points, ROCK_POINTS, atol=1e-15)


def test_programs_that_are_given_boxes_decline_bodies():
    lanes = body_lanes(ROCK_POINTS, ROCK_TENSOR, 1)
    require_scenes("mujoco", lanes, still(1), TIMES, MujocoSettings())
    with pytest.raises(DeclinedError, match="boxes only"):
        require_scenes("bullet", lanes, still(1), TIMES, BulletSettings())


@pytest.mark.parametrize("block", [0, 1])
def test_a_stack_with_a_body_rocks_as_impulse_says(block: int):
    boxes = make_stacks([[0.7, 0.6]], [0.6, 0.9], friction=0.8, offset=[0.0, 0.03])
    lanes, motions = with_body(boxes, block), shaken(np.array([4.0]))
    times, target = SampleTimes(1.0, 0.05), Target(form=Form.PLAIN)
    settings = MujocoSettings(steps_per_second=8000)
    answer = run_program("mujoco", lanes, motions, times, settings).response
    ours = Impulse(target=target).run(lanes, motions, times)
    peak = np.abs(ours["rotation"]).max()
    assert peak > 0.05
    # Soft contacts on one side, a step of 0.2 ms on the other: thousandths of a rotation.
    np.testing.assert_allclose(answer["rotation"], ours["rotation"], atol=0.02 * peak)
    np.testing.assert_allclose(answer["peak_slide"], ours["peak_slide"], atol=2e-3)
    with pytest.raises(DeclinedError, match="boxes only"):
        require_scenes("bullet", lanes, motions, times, BulletSettings())


def test_stacks_with_a_body_start_upright_there():
    lanes = with_body(make_stacks([[0.5, 0.4]], [0.6, 0.9], rotation=[0.0, 0.02]), 1)
    with pytest.raises(DeclinedError, match="upright"):
        require_scenes("mujoco", lanes, StillBase(1), TIMES, MujocoSettings())
