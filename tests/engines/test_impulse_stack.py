"""`impulse` on stacks: momentum, round-off, statics, what lifts and overturns."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from tests.shared.blocks import at_rest, make_stacks, sines
from tests.shared.kinds import lanes_of, planar_motions
from tests.shared.pairs import place_centres, random_pairs
from warprock.model.lanes import Lanes
from warprock.model.motion import Control, GroundMotions, MotionKind
from warprock.model.response import Outcome, Response, SampleTimes, Status
from warprock.running.batch import run_batch
from warprock.settings.engines import ImpulseSettings
from warprock.units import GRAVITY

STICKING = 10.0
"""A friction at which nothing slides."""
COARSE = ImpulseSettings(substeps=1)
"""480 steps a second, for what does not hang on the step."""


def run(lanes: Lanes, motions: GroundMotions, times: SampleTimes, substeps: int = 20) -> Response:
    """A run in which no lane fails."""
    response = run_batch(
        "impulse", lanes, motions, times, settings=ImpulseSettings(substeps=substeps)
    )
    assert np.all(response["status"] == Status.OK)
    return response


def test_momentum_is_kept_on_a_base_without_friction() -> None:
    lanes = random_pairs(12)
    lanes = dataclasses.replace(lanes, friction=np.tile([0.0, STICKING], (12, 1)))
    times = SampleTimes(0.5, 0.1)
    before, _ = place_centres(lanes, lanes.rotation_start, np.zeros((12, 2)))
    for substeps in (20, 200):
        response = run(lanes, at_rest(12), times, substeps)
        after, _ = place_centres(lanes, response["rotation"][:, :, -1], response["residual_slide"])
        drift = ((after - before) * lanes.mass).sum(axis=1) / lanes.mass.sum(axis=1)
        assert np.all(response["impact_count"] >= 5)
        assert np.all(np.abs(response["residual_slide"][:, 0]) > 1e-3)
        # What an inclined interface gives back of a penetration shifts the block on it sideways.
        assert np.max(np.abs(drift)) <= 5e-3 * ImpulseSettings(substeps=substeps).time_step


def test_round_off_chooses_no_side() -> None:
    # A stack that stands straight, on a base that begins with a jump of its velocity.
    again = np.full(8, 2)
    straight = lanes_of("stack").take(again)
    sizes = 1.0 + np.spacing(1.0) * np.random.default_rng(0).integers(-8, 9, straight.width.shape)
    lanes = dataclasses.replace(straight, height=straight.height * sizes)
    motions = planar_motions(MotionKind.HARMONIC, 4).take(again)
    found = run_batch("impulse", lanes, motions, SampleTimes(1.0, 0.05))["rotation"]
    # Round-off, magnified by fourteen landings; the two sides differ by 1e-3 rad.
    np.testing.assert_allclose(found, found[:1].repeat(8, axis=0), rtol=0.0, atol=1e-9)


def test_blocks_overturn() -> None:
    # On a face so wide that the block stays on it wherever its corner slips.
    lanes = make_stacks(np.tile([4.0, 0.15], (2, 1)), [0.3, 0.9], friction=1.0)
    motions = sines(Control.ACCELERATION, np.array([0.9, -0.9]) * GRAVITY, 1.0, 0.5)
    response = run(lanes, motions, SampleTimes(3.0, 0.1))
    assert np.all(response["outcome"] == Outcome.OVERTURNED)
    np.testing.assert_allclose(response["peak_rotation"][:, 1], 0.5 * np.pi, rtol=1e-12)
    assert response["rotation"][0, 1, -1] < 0.0 < response["rotation"][1, 1, -1]


@pytest.mark.thorough
def test_a_tower_stands_while_its_centres_of_mass_are_supported() -> None:
    # Equal blocks of width w stand while what is above a face has its centre within w / 2: two
    # blocks up to an offset of w / 2, and with that, below them, up to w / 4.
    width = 0.4
    ratio = np.array([[0.0, 0.0, 0.49], [0.0, 0.0, 0.51], [0.0, 0.24, 0.49], [0.0, 0.26, 0.49]])
    offset = width * np.concatenate([ratio, -ratio])
    lanes = make_stacks(width, 0.1, offset=offset, friction=1.0)
    response = run_batch("impulse", lanes, at_rest(8), SampleTimes(2.0, 0.5), settings=COARSE)
    falls = np.array([False, True] * 4)
    np.testing.assert_array_equal(response["outcome"] == Outcome.AT_REST, ~falls)
    assert np.all(response["peak_rotation"][~falls] < 1e-9)
    assert np.all(response["peak_rotation"][falls, 2] > 1.0)


def test_a_chamfer_makes_a_block_lift_earlier() -> None:
    # A block on a wide one lifts at |a| / g = (width / 2 - chamfer) / (height / 2).
    chamfer = np.repeat([0.0, 0.01], 2)
    limit = GRAVITY * (0.1 - 2.0 * chamfer) / 0.5
    lanes = make_stacks(
        np.tile([1.0, 0.1], (4, 1)), [0.2, 0.5], chamfer=np.stack([0.0 * chamfer, chamfer], 1)
    )
    motions = sines(Control.ACCELERATION, limit * np.tile([0.98, 1.02], 2), 2.0, 1.0)
    response = run(lanes, motions, SampleTimes(0.5))
    np.testing.assert_array_equal(np.isfinite(response["uplift_time"]), [False, True] * 2)
