"""The error estimate on stacks, held against the analytical model of two blocks."""

import numpy as np
import pytest

from tests.shared.blocks import sines
from warprock.model.lanes import Lanes
from warprock.model.motion import Control
from warprock.model.response import Outcome, SampleTimes, Status
from warprock.model.stacking import uplift_ratio
from warprock.running.batch import run_batch
from warprock.running.tolerance import run_to_tolerance
from warprock.settings.engines import EventSettings
from warprock.units import GRAVITY

COUNT = 200
TIMES = SampleTimes(2.0, 0.005)


def pairs(random: np.random.Generator) -> Lanes:
    """Pairs of blocks that do not slide, the upper one as wide as the lower one or narrower."""
    width = random.uniform(0.2, 0.5, COUNT)
    upper = width * random.uniform(0.4, 1.0, COUNT)
    heights = width * random.uniform(2.0, 4.0, COUNT), width * random.uniform(2.0, 5.0, COUNT)
    both = np.ones((COUNT, 2))
    return Lanes(
        width=np.stack([width, upper], axis=1),
        height=np.stack(heights, axis=1),
        depth=0.5 * both,
        density=2000.0 * both,
        friction=10.0 * both,
        chamfer=0.002 * both,
        offset=0.0 * both,
        rotation_start=0.0 * both,
        angular_restitution=both[:, 0],
    )


@pytest.mark.thorough
@pytest.mark.parametrize("time_step", [2e-2, 5e-3])
def test_the_error_of_most_blocks_is_below_its_estimate(time_step: float) -> None:
    """200 such pairs: 0.98 and 0.96 of the blocks; most errors are below what resting leaves out.

    Blocks that fall are compared up to their slenderness angle, as the estimate does it; lanes in
    which the analytical model has a contact pull are no reference.
    """
    random = np.random.default_rng(5)
    lanes = pairs(random)
    amplitude = GRAVITY * uplift_ratio(lanes).min(axis=1) * random.uniform(1.2, 2.5, COUNT)
    motions = sines(Control.ACCELERATION, amplitude, random.uniform(1.0, 4.0, COUNT), 1.0)
    reference = run_batch("two-block", lanes, motions, TIMES)
    found = run_to_tolerance(
        "event", lanes, motions, TIMES, settings=EventSettings(time_step=time_step)
    )
    fallen, fell = (
        np.isin(each["outcome"], (Outcome.OVERTURNED, Outcome.SLID_OFF))
        for each in (found, reference)
    )
    sound = (found["status"] == Status.OK) & (reference["status"] == Status.OK)
    assert sound.mean() > 0.6
    assert not np.any(sound & (fallen != fell))
    bound = np.where((fallen & fell)[:, None], lanes.slenderness_angle, np.inf)[..., None]
    ours, theirs = (np.clip(each["rotation"], -bound, bound) for each in (found, reference))
    error = np.abs(ours - theirs).max(axis=2)[sound]
    estimate = found["rotation_error"][sound]
    assert np.mean(error <= estimate) > 0.92
    # Of some 1e-3 of the angle at second order.
    assert np.median(error) <= 1e-6
    moves = error > 1e-5
    assert 0.5 < np.median(estimate[moves] / error[moves]) < 5.0
