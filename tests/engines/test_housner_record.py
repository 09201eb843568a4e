"""`housner` under records, where most steps are those without events of housner/block_roll.py."""

from __future__ import annotations

import time

import numpy as np
import pytest

from tests.shared.blocks import make_lanes
from tests.shared.made_records import made_record
from tests.shared.speed import require_gain
from tests.shared.vertical_motion import sampled
from warprock.case.lanes import LaneSet, expand_lanes
from warprock.case.load import load_case
from warprock.engines.launching import Form, strongest_ahead
from warprock.kernels.motion.pool import AHEAD
from warprock.model import rocking
from warprock.model.motion import StillBase, UprightMotions
from warprock.model.response import SampleTimes
from warprock.recordings import record_motions
from warprock.running.batch import run_batch
from warprock.units import GRAVITY

LANES = 400
"""More than a thread has places for, so that lanes take the places of others."""


@pytest.fixture(scope="module")
def many() -> LaneSet:
    """Lanes that rest, rock and overturn under 20 s of an earthquake."""
    restitution = "sample.over.contact.angular_restitution"
    keeps = "={distribution='uniform', from=0.85, to=0.97}"
    case = load_case("record-sample", [f"sample.lanes={LANES}", restitution + keeps])
    return expand_lanes(case)


@pytest.mark.thorough
def test_lanes_side_by_side_do_what_each_does_alone(many: LaneSet) -> None:
    # The plain form has the step of housner/block.py alone, and one lane a thread.
    packed, plain = (
        run_batch("housner", many.lanes, many.motions, many.times, form=form) for form in Form
    )
    assert len(np.unique(packed["outcome"])) == 3
    for name, values in packed.fields.items():
        np.testing.assert_array_equal(values, plain[name], err_msg=name)


@pytest.mark.speed
def test_many_lanes_under_a_record_are_vector_code(many: LaneSet) -> None:
    def cost(form: Form) -> float:
        started = time.process_time()
        run_batch(
            "housner", many.lanes, many.motions, many.times, form=form, workers=1, chunk_size=LANES
        )
        return time.process_time() - started

    # 2.4 to 2.5 of 256-bit vectors; 1.2 without vector code for steps without events.
    require_gain(lambda: cost(Form.PLAIN), lambda: cost(Form.PACKED), 1.5)


def test_a_block_at_rest_passes_quiet_samples_and_lifts_in_time() -> None:
    interval, quiet, limit = 0.01, 0.1, float(rocking.uplift_acceleration(0.2, 1.0))
    # A peak at every sample in turn, which a step of many samples may end before, at or behind.
    peaks = np.arange(300, 360)
    records = []
    for peak in peaks:
        samples = np.full(500, quiet * limit)
        samples[peak] = 2.0 * limit
        records.append(made_record(samples, interval))
    count = len(peaks)
    motions = record_motions(
        records, index=np.arange(count), scale=np.ones(count), start=np.zeros(count)
    )
    lanes = make_lanes(np.full(count, 0.2), 1.0)
    found = run_batch("housner", lanes, motions, SampleTimes(4.0))
    rise = (1.0 - quiet) / (2.0 - quiet)
    lifted = interval * (peaks - 1 + rise)
    # To the part 2 x 1e-12 of the limit by which a block at rest may exceed it.
    np.testing.assert_allclose(found["uplift_time"], lifted, rtol=1e-11)
    still = run_batch("housner", lanes, motions, SampleTimes(2.9))
    assert np.isnan(still["uplift_time"]).all()
    # 290 samples, all but the first of which are passed without a step.
    assert np.max(still["step_count"]) < 5


def test_a_block_at_rest_needs_what_the_strongest_sample_asks_for() -> None:
    draw, count, interval = np.random.default_rng(6), 24, 0.01
    samples = draw.uniform(-2.0, 2.0, (count, 300)) * draw.uniform(0.1, 1.0, (count, 300)) ** 4
    motions = sampled(samples, interval)
    lanes = make_lanes(np.full(count, 3.0), 1.0, friction=9.0)
    # Ends in the midst of samples, and of a leap over many.
    for end in (0.123, 0.5, 1.704, 2.98):
        found = run_batch("housner", lanes, motions, SampleTimes(end))
        assert np.isnan(found["uplift_time"]).all()
        time = np.append(interval * np.arange(int(end / interval) + 1), end)
        record = [np.interp(time, interval * np.arange(300), each) for each in samples]
        needed = np.abs(record).max(axis=1) / GRAVITY
        np.testing.assert_allclose(found["friction_needed"], needed, rtol=1e-12)


def test_a_block_that_rocks_and_rests_again_needs_as_much_as_on_a_base_that_may_rise() -> None:
    # Kernels of their own, in which a block at rest passes no sample without a step.
    draw, count = np.random.default_rng(7), 60
    samples = draw.uniform(-6.0, 6.0, (count, 300)) * draw.uniform(0.1, 1.0, (count, 300)) ** 2
    lanes = make_lanes(draw.uniform(0.25, 0.6, count), 1.0, friction=9.0)
    along = sampled(samples, 0.01)
    both = UprightMotions(along, sampled(0.0 * samples, 0.01))
    found, other = (
        run_batch("housner", lanes, motions, SampleTimes(2.9)) for motions in (along, both)
    )
    assert np.sum(found["impact_count"] > 0) > 20
    np.testing.assert_allclose(found["friction_needed"], other["friction_needed"], rtol=1e-7)


def test_a_record_of_zeros_leaves_a_block_rocking_as_on_still_ground() -> None:
    # Most hops are shorter than a sample: the block turns and comes down inside one step. On still
    # ground every step ends at a turning point.
    lanes = make_lanes(np.array([0.2, 0.3, 0.4]), 1.0, np.array([0.5, -0.7, 0.9]))
    zeros = record_motions(
        [made_record(np.zeros(2000), 0.01)], index=np.zeros(3), scale=1.0, start=0.0
    )
    found, still = (
        run_batch("housner", lanes, motions, SampleTimes(19.0)) for motions in (zeros, StillBase(3))
    )
    assert np.isfinite(still["rest_time"]).all()
    np.testing.assert_array_equal(found["impact_count"], still["impact_count"])
    # One step a sample and one an impact; none for the tops of hops.
    samples = np.ceil(found["rest_time"] / 0.01)
    assert (found["step_count"] <= found["impact_count"] + samples + 2).all()
    # Steps on still ground are as long as their series allows: 2e-8 of the time until rest.
    for name in ("rest_time", "energy_lost", "friction_needed"):
        np.testing.assert_allclose(found[name], still[name], rtol=1e-7, err_msg=name)


def test_a_peak_does_not_depend_on_where_steps_end() -> None:
    case = load_case("record-ridgecrest")
    lanes = expand_lanes(case)
    end = float(lanes.longest.duration)
    found = run_batch("housner", lanes.lanes, lanes.motions, SampleTimes(end))
    often = run_batch("housner", lanes.lanes, lanes.motions, SampleTimes(end, 0.0037))
    assert np.max(often["rotation"]) > 0.0
    # Steps that end elsewhere have other errors: 2e-12 of the peak, tried.
    np.testing.assert_allclose(found["peak_rotation"], often["peak_rotation"], rtol=1e-9)


def test_strongest_ahead_looks_at_each_sample_and_those_after_it() -> None:
    values = np.random.default_rng(1).normal(size=200)
    for count in (1, 2, 7, AHEAD, 300):
        wanted = [np.abs(values[i : i + count + 1]).max() for i in range(len(values))]
        np.testing.assert_array_equal(strongest_ahead(values, count), wanted)
