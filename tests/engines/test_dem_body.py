"""`dem` of bodies on contact points in the plane: boxes on two springs, rest, Housner's body."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from tests.shared.blocks import make_lanes, sines
from tests.shared.planar_bodies import STEPPED, body_lanes, mirrored
from warprock.engines.bodies import box_bodies
from warprock.engines.dem import Dem
from warprock.engines.dem_bodies import CornerSprings, corner_rows
from warprock.model.lanes import Lanes
from warprock.model.motion import Control, GroundMotions
from warprock.model.response import Outcome, Response, SampleTimes, Status
from warprock.running.batch import run_batch
from warprock.settings.engines import DemSettings
from warprock.units import GRAVITY

TIMES = SampleTimes(1.0, 0.01, places=True)
STARTS = (0.08, 0.03, -0.1, -0.15, 0.05)
STIFF = DemSettings(normal_stiffness=1e11, shear_stiffness=1e11, stiffness_damping=2e-4)


def shaken(count: int, amplitude: float = 1.5) -> GroundMotions:
    return sines(Control.ACCELERATION, np.full(count, amplitude), np.full(count, 1.0), 1.0)


def run(lanes: Lanes, motions: GroundMotions, settings: DemSettings | None = None) -> Response:
    response = Dem(settings).run(lanes, motions, TIMES)
    assert np.all(response["status"] == Status.OK)
    return response


@pytest.mark.parametrize("friction", [0.3, 0.8])
def test_a_box_as_a_body_is_the_box_on_two_springs(friction: float) -> None:
    lanes = make_lanes(np.linspace(0.3, 0.5, 4), 1.0, [-0.5, 0.0, 0.3, 0.6], friction)
    motions, two = shaken(4, 3.0), DemSettings(subcontacts=2)
    bodies = dataclasses.replace(lanes, body=box_bodies(lanes))
    box, body = run(lanes, motions, two), run(bodies, motions, two)
    np.testing.assert_array_equal(body["step_count"], box["step_count"])
    np.testing.assert_array_equal(body["impact_count"], box["impact_count"])
    # The same equations: round-off, and what ten thousand steps made of it.
    for name in ("rotation", "slide", "x", "z", "peak_penetration"):
        np.testing.assert_allclose(body[name], box[name], atol=1e-8, err_msg=name)


@pytest.mark.thorough
def test_on_stiff_springs_a_body_moves_as_housner_says() -> None:
    lanes, motions = body_lanes(STEPPED, STARTS), shaken(5)
    exact = run_batch("housner", lanes, motions, TIMES)["rotation"]
    soft, stiff = (
        np.abs(run(lanes, motions, each)["rotation"] - exact).max(axis=1) for each in (None, STIFF)
    )
    # The settlement over the width, on the default springs some 1e-5, is what both differ by; a
    # model difference that goes with it.
    assert np.mean(stiff) <= 0.5 * np.mean(soft)
    assert np.all(stiff <= 0.02)


def test_an_eccentric_body_stands_still_from_the_start() -> None:
    lanes = body_lanes(((-0.1, -0.5), (0.3, -0.5)), np.zeros(2))
    still = shaken(2).scaled(np.zeros(2))
    response = run(lanes, still)
    assert np.all(response["outcome"] == Outcome.AT_REST)
    springs = CornerSprings.of(lanes, DemSettings())
    # Three quarters of the weight on the nearer corner, a quarter on the other: they lean it.
    lean = -np.arcsin(0.5 * springs.load / 0.4)
    np.testing.assert_allclose(response["rotation"], lean[:, None].repeat(101, 1), rtol=1e-3)
    assert np.ptp(response["rotation"], axis=1).max() <= 1e-9 * np.abs(lean).max()
    np.testing.assert_allclose(springs.load, GRAVITY * lanes.mass / (1e9 * springs.area))


def test_a_mirrored_body_moves_as_in_a_mirror() -> None:
    base = ((-0.1, -0.5), (0.2, -0.5), (0.3, -0.4))
    lanes, motions = body_lanes(base, STARTS, friction=0.4), shaken(5, 4.0)
    one, other = run(lanes, motions), run(mirrored(lanes), motions.scaled(-np.ones(5)))
    # Sums over the springs are not taken in mirrored order.
    np.testing.assert_allclose(other["rotation"], -one["rotation"], atol=1e-9)


def test_few_kernels_serve_all_bodies() -> None:
    assert [corner_rows(count) for count in (2, 4, 5, 12, 13)] == [4, 4, 8, 12, 16]
