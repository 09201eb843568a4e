"""Planar scenes of the shipped cases, run in space: the same laws give the same rotations."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from tests.shared.blocks import Array
from tests.shared.spatial_blocks import along, in_space, unmoved
from warprock.case.lanes import expand_lanes
from warprock.case.load import load_case
from warprock.model.lanes import Lanes
from warprock.model.motion import PlanarMotions, StillBase
from warprock.model.response import SampleTimes, Status
from warprock.running.batch import run_batch
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
