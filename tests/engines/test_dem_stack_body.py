"""`dem` of stacks with bodies: boxes on two springs, single bodies, mirror images, energy, rest."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from tests.shared.blocks import make_stacks
from tests.shared.planar_bodies import body_lanes
from tests.shared.stack_bodies import (
    EIGHT,
    as_bodies,
    mirrored_stacks,
    random_pairs,
    shaken,
    stack_of_one,
    with_body,
)
from warprock.engines.dem import Dem
from warprock.engines.launching import Form, Target
from warprock.model.lanes import Lanes
from warprock.model.motion import GroundMotions
from warprock.model.response import Outcome, Response, SampleTimes, Status
from warprock.settings.engines import DemSettings

pytestmark = pytest.mark.thorough

STIFF = DemSettings(subcontacts=2, normal_stiffness=1e10, shear_stiffness=4e9)
"""Springs at the ends of faces alone, as under bodies."""
TIMES = SampleTimes(1.0, 0.01, places=True)


def run(lanes: Lanes, motions: GroundMotions, settings: DemSettings = STIFF) -> Response:
    response = Dem(settings, target=Target(form=Form.PLAIN)).run(lanes, motions, TIMES)
    assert np.all(response["status"] == Status.OK)
    return response


def test_boxes_as_bodies_are_the_stack_of_boxes() -> None:
    lanes, motions = random_pairs(8, 0.8), shaken(EIGHT)
    boxes, bodies = run(lanes, motions), run(as_bodies(lanes), motions)
    # A spring stands for the area at rest; under boxes it goes with what the faces share, which
    # changes where they slide.
    sticks = boxes["peak_slide"].max(axis=1) < 1e-4
    assert sticks.sum() >= 4
    np.testing.assert_array_equal(bodies["outcome"][sticks], boxes["outcome"][sticks])
    for name in ("rotation", "slide", "x", "z"):
        one, other = bodies[name][sticks], boxes[name][sticks]
        np.testing.assert_allclose(one, other, atol=1e-7, err_msg=name)
        np.testing.assert_allclose(one[..., 0], other[..., 0], atol=1e-10, err_msg=name)


@pytest.mark.parametrize("block", [0, 1])
def test_a_mirrored_stack_moves_as_in_a_mirror(block: int) -> None:
    lanes, motions = with_body(random_pairs(8, 0.4), block), shaken(EIGHT)
    one, other = run(lanes, motions), run(mirrored_stacks(lanes), motions.scaled(-np.ones(8)))
    assert np.abs(one["rotation"]).max() > 0.1
    for name in ("rotation", "slide", "x"):
        np.testing.assert_allclose(other[name], -one[name], atol=1e-9, err_msg=name)


@pytest.mark.parametrize("block", [0, 1])
def test_a_stack_that_stands_stays_where_it_is(block: int) -> None:
    lanes = with_body(make_stacks([[0.5, 0.4]], [0.6, 0.5], offset=[0.0, 0.05]), block)
    response = run(lanes, shaken(np.zeros(1)))
    assert response["outcome"][0] == Outcome.AT_REST
    moved = response["rotation"][0] - response["rotation"][0][:, :1]
    # Its springs are in equilibrium from the start.
    assert np.abs(moved).max() < 1e-4 * np.abs(response["rotation"][0]).max()


def test_a_stack_of_one_is_the_single_body() -> None:
    lanes = body_lanes(((-0.3, -0.46), (-0.2, -0.5), (0.15, -0.5), (0.25, -0.48)),
                       (0.08, 0.03, -0.1, -0.15, 0.05, 0.0, 0.0, 0.0))  # fmt: skip
    motions, stacks = shaken(EIGHT), stack_of_one(lanes)
    engine = Dem(STIFF, target=Target(form=Form.PLAIN))
    # Each finds its own step; they are compared at the shorter one.
    step = min(float(engine.longest_step(each, motions).min()) for each in (lanes, stacks))
    settings = dataclasses.replace(STIFF, time_step=step)
    one, other = run(lanes, motions, settings), run(stacks, motions, settings)
    np.testing.assert_array_equal(other["outcome"], one["outcome"])
    for name in ("rotation", "slide", "x", "z"):
        np.testing.assert_allclose(other[name][:, 0], one[name], atol=1e-6, err_msg=name)
