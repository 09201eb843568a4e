"""`impulse` of bodies on contact points in the plane: boxes, and first order to Housner's body."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from tests.shared.blocks import make_lanes, sines
from tests.shared.planar_bodies import STEPPED, body_lanes, mirrored
from warprock.engines.bodies import box_bodies
from warprock.engines.impulse import Impulse
from warprock.model.lanes import Lanes
from warprock.model.motion import Control, GroundMotions
from warprock.model.response import Outcome, Response, SampleTimes, Status
from warprock.running.batch import run_batch
from warprock.settings.engines import ImpulseSettings
from warprock.units import GRAVITY

TIMES = SampleTimes(2.0, 0.01, places=True)
STARTS = (0.08, 0.03, -0.1, -0.15, 0.05)


def shaken(count: int, amplitude: float = 1.5) -> GroundMotions:
    return sines(Control.ACCELERATION, np.full(count, amplitude), np.full(count, 1.0), 1.0)


def run(lanes: Lanes, motions: GroundMotions, substeps: int = 20) -> Response:
    response = Impulse(ImpulseSettings(substeps=substeps)).run(lanes, motions, TIMES)
    assert np.all(response["status"] == Status.OK)
    return response


@pytest.mark.thorough
@pytest.mark.parametrize("friction", [0.15, 0.5])
def test_a_box_as_a_body_is_the_box(friction: float) -> None:
    lanes = make_lanes(np.linspace(0.2, 0.5, 8), 1.0, np.linspace(-0.9, 0.9, 8), friction)
    motions = shaken(8, 3.0)
    box, body = (
        run(lanes, motions),
        run(dataclasses.replace(lanes, body=box_bodies(lanes)), motions),
    )
    np.testing.assert_array_equal(body["outcome"], box["outcome"])
    # Sweeps that stop before they have converged stop elsewhere: by less than the step's own error,
    # some 1e-3 of a rotation and g dt in a speed.
    for name in ("rotation", "slide", "x", "z"):
        np.testing.assert_allclose(body[name], box[name], atol=1e-4, err_msg=name)


def test_first_order_to_housner() -> None:
    lanes, motions = body_lanes(STEPPED, STARTS), shaken(5)
    exact = run_batch("housner", lanes, motions, TIMES)["rotation"]
    coarse, fine = (
        np.abs(run(lanes, motions, each)["rotation"] - exact).max(axis=1) for each in (9, 99)
    )
    assert np.all(fine <= 2e-3)
    # A tenth of the step; impacts within their steps scatter the errors of one lane.
    assert np.mean(fine) <= np.mean(coarse) / 4.0


def test_a_mirrored_body_moves_as_in_a_mirror() -> None:
    lanes, motions = body_lanes(STEPPED, STARTS, friction=0.4), shaken(5, 4.0)
    one, other = run(lanes, motions), run(mirrored(lanes), motions.scaled(-np.ones(5)))
    assert one["impact_count"].min() > 1
    np.testing.assert_array_equal(other["rotation"], -one["rotation"])


def test_an_eccentric_body_rests_and_lifts_over_its_weaker_side() -> None:
    # Ends 0.1 m and 0.3 m beside a centre 0.5 m high: from 0.2 g and 0.6 g on.
    points = ((-0.1, -0.5), (0.3, -0.5))
    amplitude = np.array([0.19, 0.21, -0.5, -0.59, -0.61]) * GRAVITY
    motions = sines(Control.ACCELERATION, amplitude, np.full(5, 2.0), 0.5)
    response = Impulse().run(body_lanes(points, np.zeros(5)), motions, TIMES)
    lifted = np.isfinite(response["uplift_time"])
    np.testing.assert_array_equal(lifted, [False, True, False, False, True])
    np.testing.assert_array_equal(response["outcome"][~lifted], Outcome.AT_REST)
    # Half a cycle of +0.2 g pushes the centre of mass towards -x.
    assert response["rotation"][1].min() < -1e-6
    assert response["rotation"][4].max() > 1e-6
