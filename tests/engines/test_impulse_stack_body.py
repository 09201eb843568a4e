"""`impulse` of stacks with bodies: boxes, single bodies, mirror images, energy, how they stand."""

from __future__ import annotations

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
from warprock.engines.energy import stack_energy_held
from warprock.engines.impulse import Impulse
from warprock.engines.launching import Form, Target
from warprock.model.lanes import Lanes
from warprock.model.motion import GroundMotions
from warprock.model.response import Outcome, Response, SampleTimes, Status
from warprock.model.stacking import uplift_ratio
from warprock.settings.engines import ImpulseSettings
from warprock.units import GRAVITY

pytestmark = pytest.mark.thorough

PLAIN = Target(form=Form.PLAIN)
"""Compiled in a third of the time of the packed form."""
TIMES = SampleTimes(1.0, 0.01, places=True)


def run(lanes: Lanes, motions: GroundMotions, times: SampleTimes = TIMES) -> Response:
    response = Impulse(ImpulseSettings(substeps=20), target=PLAIN).run(lanes, motions, times)
    assert np.all(response["status"] == Status.OK)
    return response


@pytest.mark.parametrize("friction", [0.3, 0.8])
def test_boxes_as_bodies_are_the_stack_of_boxes(friction: float) -> None:
    lanes, motions = random_pairs(8, friction), shaken(EIGHT)
    boxes, bodies = run(lanes, motions), run(as_bodies(lanes), motions)
    np.testing.assert_array_equal(bodies["outcome"], boxes["outcome"])
    # Round-off, which impacts magnify.
    for name in ("rotation", "slide", "x", "z"):
        np.testing.assert_allclose(bodies[name], boxes[name], atol=2e-5, err_msg=name)
        typical = np.median(np.abs(bodies[name] - boxes[name]).max(axis=(1, 2)))
        assert typical <= 1e-8, name


def test_a_stack_of_one_is_the_single_body() -> None:
    lanes = body_lanes(((-0.3, -0.46), (-0.2, -0.5), (0.15, -0.5), (0.25, -0.48)),
                       (0.08, 0.03, -0.1, -0.15, 0.05, 0.0, 0.0, 0.0), friction=0.4)  # fmt: skip
    motions = shaken(EIGHT)
    one, other = run(lanes, motions), run(stack_of_one(lanes), motions)
    np.testing.assert_array_equal(other["outcome"], one["outcome"])
    np.testing.assert_array_equal(other["impact_count"], one["impact_count"])
    # The starts differ by what the sweeps leave.
    for name in ("rotation", "slide", "x", "z"):
        np.testing.assert_allclose(other[name][:, 0], one[name], atol=1e-6, err_msg=name)


@pytest.mark.parametrize("block", [0, 1])
def test_a_mirrored_stack_moves_as_in_a_mirror(block: int) -> None:
    lanes, motions = with_body(random_pairs(8, 0.4), block), shaken(EIGHT)
    one, other = run(lanes, motions), run(mirrored_stacks(lanes), motions.scaled(-np.ones(8)))
    assert np.abs(one["rotation"]).max() > 0.1
    for name in ("rotation", "slide", "x"):
        np.testing.assert_allclose(other[name], -one[name], atol=1e-12, err_msg=name)


@pytest.mark.parametrize("block", [0, 1])
def test_a_stack_that_comes_to_rest_has_lost_what_it_held(block: int) -> None:
    rotation = np.array([[0.02, 0.02], [-0.03, -0.01], [0.01, -0.02]])
    lanes = with_body(make_stacks([0.5, 0.4], [0.6, 0.5], rotation=rotation, friction=0.8), block)
    response = run(lanes, shaken(np.zeros(3)), SampleTimes(8.0, 0.5))
    np.testing.assert_array_equal(response["outcome"], Outcome.AT_REST)
    # First order: rests are flat but for what the step leaves in the gaps.
    np.testing.assert_allclose(response["energy_lost"], stack_energy_held(lanes), rtol=2e-3)


def test_a_body_on_a_block_lifts_over_its_weaker_side() -> None:
    # Ends 0.1 m and 0.3 m beside a centre 0.5 m high: from 0.2 g and 0.6 g on. What is below is
    # stout, and stands.
    points = ((-0.1, -0.5), (0.3, -0.5))
    lanes = with_body(make_stacks(np.full((4, 2), (2.0, 0.4)), [0.4, 1.0]), 1, points)
    amplitude = np.array([0.19, 0.21, -0.59, -0.61]) * GRAVITY
    response = run(lanes, shaken(amplitude, 0.5))
    lifted = np.isfinite(response["uplift_time"])
    np.testing.assert_array_equal(lifted, [False, True, False, True])
    np.testing.assert_array_equal(response["outcome"][~lifted], Outcome.AT_REST)
    assert response["rotation"][1, 1].min() < -1e-6
    assert response["rotation"][3, 1].max() > 1e-6


def test_an_end_of_the_top_below_carries_a_wider_base() -> None:
    # A base of 0.6 m on a top of 0.4 m: it lifts where that ends.
    lanes = as_bodies(make_stacks(np.full((2, 2), (2.0, 0.6)), [0.4, 1.0]))
    assert lanes.profiles is not None
    lanes.profiles.top[:, 0, :2] = (-0.2, 0.2)
    np.testing.assert_allclose(uplift_ratio(lanes)[:, 1], 0.4)
    response = run(lanes, shaken(np.array([0.39, 0.41]) * GRAVITY, 0.5))
    np.testing.assert_array_equal(np.isfinite(response["uplift_time"]), [False, True])


def test_many_lanes_side_by_side_move_as_each_alone() -> None:
    lanes, motions = with_body(random_pairs(8, 0.5), 1), shaken(EIGHT)
    settings = ImpulseSettings(substeps=20)
    packed = Impulse(settings, target=Target(form=Form.PACKED)).run(lanes, motions, TIMES)
    plain = run(lanes, motions)
    for name in ("rotation", "slide"):
        np.testing.assert_allclose(packed[name], plain[name], atol=1e-9, err_msg=name)
