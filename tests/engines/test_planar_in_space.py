"""Planar scenes of the shipped cases, run in space: the same laws give the same rotations."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from tests.shared.blocks import Array, make_lanes, sines
from tests.shared.spatial_blocks import along, in_space, unmoved
from warprock.case.lanes import expand_lanes
from warprock.case.load import load_case
from warprock.model.lanes import Lanes
from warprock.model.motion import Control, PlanarMotions, StillBase, no_motion
from warprock.model.response import Response, SampleTimes, Status
from warprock.run.batch import run_batch
from warprock.settings.engines import DemSettings, ImpulseSettings

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


def random_planar(across: bool, vertical: float, *, mirror: bool = False) -> Response:
    """Blocks of random depth, width and friction that leave the ground and land, in one plane.

    Args:
        across: Whether they move along y, else along x.
        vertical: Factor of the motion upwards, up to 15 m/s^2.
        mirror: Whether to run the mirror image instead.
    """
    rng, count = np.random.default_rng(3), 64
    width, depth, height = rng.uniform([[0.1], [0.1], [0.4]], [[1.0], [1.0], [6.0]], (3, count))
    lean = np.where(rng.random(count) < 0.3, rng.uniform(-0.8, 0.8, count), 0.0)
    lean *= np.arctan2(depth if across else width, height)
    offset = 0.1 * (depth if across else width) * rng.uniform(-1.0, 1.0, count)
    strength = rng.uniform(1.0, 12.0, count) * rng.choice([-1.0, 1.0], count)
    lift, often = vertical * rng.uniform(-15.0, 15.0, count), rng.uniform(1.0, 5.0, (2, count))
    sign = -1.0 if mirror else 1.0
    names = ("rotation_across_start", "centre_offset_y") if across else (
        "rotation_start", "centre_offset_x")  # fmt: skip
    lanes = in_space(
        make_lanes(width, height, friction=rng.uniform(0.1, 1.2, count)), depth=depth,
        **{names[0]: sign * lean, names[1]: sign * offset},
    )  # fmt: skip
    way = sines(Control.ACCELERATION, sign * strength, often[0], 2.0, start=0.1)
    up = sines(Control.ACCELERATION, lift, often[1], 3.0)
    motions = along(no_motion(way), way, up) if across else along(way, no_motion(way), up)
    return run_batch("impulse", lanes, motions, TIMES)


@pytest.mark.parametrize("vertical", [0.0, 1.0])
@pytest.mark.parametrize("across", [False, True])
def test_impulse_stays_in_the_plane_wherever_it_lands_and_slides(
    across: bool, vertical: float
) -> None:
    found, image = (random_planar(across, vertical, mirror=each) for each in (False, True))
    own, other = ("rotation", "rotation_across")[:: -1 if across else 1]
    # Corners visited in turn left it in more than half of the lanes that a base throws, by up to
    # 2 rad. What is left is round-off, which impacts magnify.
    assert found["impact_count"].sum() > 100
    assert np.all(found["peak_yaw"] <= 1e-12)
    assert np.all(found[f"peak_{other}"] <= 1e-12)
    np.testing.assert_array_equal(found[own], -image[own])
