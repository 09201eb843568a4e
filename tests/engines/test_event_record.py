"""`event` under records: rest passes many samples at once, lanes are put in order."""

from __future__ import annotations

import numpy as np
import pytest

from tests.shared.blocks import make_lanes
from tests.shared.made_records import made_record
from warprock.case.lanes import LaneSet, expand_lanes
from warprock.case.load import load_case
from warprock.engines.event import Event
from warprock.engines.launching import Form
from warprock.kernels.motion.pool import AHEAD
from warprock.model.motion import RecordMotions
from warprock.model.response import SampleTimes, Status
from warprock.recordings import record_motions
from warprock.running.batch import run_batch
from warprock.settings.engines import EventSettings
from warprock.units import GRAVITY

INTERVAL = 0.01


@pytest.fixture(scope="module")
def many() -> LaneSet:
    """Lanes that rest, rock and overturn under 20 s of an earthquake."""
    return expand_lanes(load_case("record-sample", ["sample.lanes=400"]))


def shaken_once(acceleration: float, quiet: float = 0.0, count: int = 2000) -> RecordMotions:
    """One lane under a record that is quiet but for one sample, at 15 s."""
    values = quiet * np.where(np.arange(count) % 2 == 0, 1.0, -1.0)
    values[1500] = acceleration
    record = made_record(values, INTERVAL)
    return record_motions([record], index=np.zeros(1, int), scale=np.ones(1), start=np.zeros(1))


@pytest.mark.thorough
def test_lanes_that_are_put_in_order_do_what_they_do_in_theirs(many: LaneSet) -> None:
    order = Event(EventSettings()).alike_order(many.lanes, many.motions)
    assert order is not None
    assert np.any(np.diff(order) < 0)
    packed, plain = (
        run_batch("event", many.lanes, many.motions, many.times, form=form) for form in Form
    )
    assert len(np.unique(packed["outcome"])) == 3
    for name, values in packed.fields.items():
        np.testing.assert_array_equal(values, plain[name], err_msg=name)


def test_the_first_sample_above_a_bound(many: LaneSet) -> None:
    motions = many.motions
    assert isinstance(motions, RecordMotions)
    bound = np.linspace(0.1, 8.0, motions.lane_count)
    found = motions.first_above(bound)
    assert 0 < np.sum(np.isinf(found)) < len(found)
    for lane in range(0, motions.lane_count, 29):
        times = motions.start[lane] + motions.interval[lane] * np.arange(motions.count[lane] - 1)
        strong = np.abs(motions.acceleration(times + 1e-9, lane)) >= bound[lane] * (1 - 1e-6)
        assert found[lane] == (times[np.argmax(strong)] if strong.any() else np.inf)


def test_a_block_at_rest_passes_weak_samples_at_once_and_moves_in_time() -> None:
    lanes = make_lanes(np.full(1, 0.2), 1.0, friction=2.0)
    limit = 0.2 * GRAVITY
    times = SampleTimes(20.0)
    still = run_batch("event", lanes, shaken_once(0.99 * limit, 0.1), times)
    assert still["peak_rotation"][0] == 0.0
    # The bound lies between, so that samples near the shock are stepped to one by one.
    assert still["step_count"][0] <= 2000 / AHEAD + 2 * AHEAD
    moved = run_batch("event", lanes, shaken_once(1.5 * limit, 0.1), times)
    # Linear from the sample before, which is -0.1 m/s^2.
    part = (limit + 0.1) / (1.5 * limit + 0.1)
    lifts = (1499.0 + part) * INTERVAL
    # Located to a part of the longest step.
    assert moved["uplift_time"][0] == pytest.approx(lifts, abs=1e-5)


def test_blocks_that_hardly_lift_come_down_in_few_steps() -> None:
    # Two of 40,000 whose rotation starts on a curve that a parabola through the step's ends misses.
    case = load_case("record-sample", ["sample.lanes=40000"])
    lifts = expand_lanes(case, range(10568, 22046, 22045 - 10568))
    found = run_batch("event", lifts.lanes, lifts.motions, lifts.times)
    np.testing.assert_array_equal(found["status"], Status.OK)
    # Some 64 hops over the resting ones, and a few steps about each impact.
    assert np.all(found["step_count"] < 2000)
