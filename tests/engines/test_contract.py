"""What every engine promises, whatever its scheme."""

from __future__ import annotations

import dataclasses
import functools

import numpy as np
import pytest

from tests.shared.blocks import at_rest, free_lanes, make_lanes, sines, single_block_engines
from tests.shared.marks import all_but
from warprock.engines.energy import energy_held
from warprock.engines.launching import Form, Target
from warprock.model import rocking
from warprock.model.lanes import Lanes
from warprock.model.motion import Control, GroundMotions, HarmonicMotions, StillBase
from warprock.model.response import LANE_FIELDS, Outcome, Response, SampleTimes, Status
from warprock.running.batch import run_batch
from warprock.settings.engines import DemSettings
from warprock.units import GRAVITY

LANES = 75
"""Two whole packs of 32 and a part of one."""
TIMES = SampleTimes(duration=1.5, interval=0.05, places=True)

RIGID = {
    "dem": DemSettings(
        normal_stiffness=1e12, shear_stiffness=1e12, subcontacts=2, stiffness_damping=2e-4
    )
}
"""Settings of a compliant engine at which its block comes close to a rigid one on two corners."""

NOT_STILL = ("direct", "xpbd")
"""Engines whose kernels of a base that stands still no other ordinary test asks for."""

every_engine = pytest.mark.parametrize("engine", single_block_engines())


def mixed_batch() -> tuple[Lanes, HarmonicMotions]:
    """Blocks that rest, rock, and fall, under pulses of many sizes and frequencies."""
    k = np.arange(LANES)
    lanes = make_lanes(0.17 + 0.003 * k, 1.0 + 0.01 * (k % 7), np.where(k % 5 == 0, 0.3, 0.0))
    amplitude = np.where(k % 11 == 3, 0.3, 0.002 + 0.0002 * k)
    return lanes, sines(Control.DISPLACEMENT, amplitude, 2.0 + 0.04 * k, cycles=1.5)


@functools.cache
def mixed_response(engine: str) -> Response:
    """What the packed form of an engine answers to that batch, in one chunk."""
    lanes, motions = mixed_batch()
    return run_batch(engine, lanes, motions, TIMES, form=Form.PACKED, workers=1, chunk_size=LANES)


def assert_same(one: Response, other: Response) -> None:
    """Bitwise equality of every field, histories and NaN among them."""
    assert set(one.fields) == set(other.fields)
    for name, values in one.fields.items():
        np.testing.assert_array_equal(values, other.fields[name], err_msg=name)


@every_engine
def test_lane_does_not_depend_on_batch_chunk_workers_or_place(engine: str) -> None:
    lanes, motions = mixed_batch()
    whole = mixed_response(engine)
    assert set(LANE_FIELDS) <= set(whole.fields)
    assert whole["rotation"].shape == (LANES, len(TIMES.times))
    assert np.all(np.isfinite(whole["peak_penetration"]) & (whole["peak_penetration"] >= 0.0))
    for workers, chunk_size in ((2, 32), (2, 7)):
        assert_same(
            whole,
            run_batch(engine, lanes, motions, TIMES, workers=workers, chunk_size=chunk_size),
        )
    # One lane a chunk; it runs as a whole pack, so that a few must do.
    few = np.arange(3, LANES, 9)
    alone = run_batch(engine, lanes.take(few), motions.take(few), TIMES, workers=3, chunk_size=1)
    for name, values in whole.fields.items():
        np.testing.assert_array_equal(values[few], alone[name], err_msg=name)
    order = np.random.default_rng(0).permutation(LANES)
    shuffled = run_batch(engine, take(lanes, order), take(motions, order), TIMES)
    for name, values in whole.fields.items():
        np.testing.assert_array_equal(values[order], shuffled[name], err_msg=name)


def take(lanes, order):
    """Lanes or motions in another order."""
    arrays = getattr(lanes, "arrays", None) or {
        f.name: getattr(lanes, f.name) for f in dataclasses.fields(lanes)
    }
    parts = {name: each[order] for name, each in arrays.items()}
    return dataclasses.replace(lanes, **parts)


@every_engine
def test_mirrored_scene_gives_mirrored_response(engine: str) -> None:
    lanes, motions = mixed_batch()
    there = mixed_response(engine)
    mirrored = dataclasses.replace(lanes, rotation_start=-lanes.rotation_start)
    names = (
        "acceleration_amplitude",
        "velocity_offset",
        "velocity_step_start",
        "velocity_step_stop",
        "velocity_final",
    )
    back = dataclasses.replace(motions, **{name: -getattr(motions, name) for name in names})
    response = run_batch(engine, mirrored, back, TIMES)
    # To the last bit: a series of an odd function has mirrored coefficients, and the contact
    # solver visits the corners of a mirrored block in mirrored order.
    np.testing.assert_array_equal(there["rotation"], -response["rotation"])
    np.testing.assert_array_equal(there["outcome"], response["outcome"])


@every_engine
def test_no_energy_from_nothing(engine: str) -> None:
    lanes = free_lanes()
    times = SampleTimes(duration=3.0, interval=0.01)
    response = run_batch(engine, lanes, at_rest(9), times)
    lost = response["energy_lost"]
    held = energy_held(lanes, lanes.rotation_start)
    assert np.all(lost > 0.0)
    # Round-off for the event-driven solution; (p dt)^2 / 4 for the second-order step; the impulse
    # step gives back penetrations of the order of dt times the impact velocity, 1 % of the energy
    # at its default step.
    bound = {"housner": 1e-9, "event": 2e-4}.get(engine, 1e-2)
    assert np.all(lost <= held * (1.0 + bound))
    # A swing never climbs above the one before it, to either side (round-off, or the same).
    rotation = np.abs(response["rotation"])
    for lane in range(9):
        peaks = [
            max(part) for part in np.split(rotation[lane], np.flatnonzero(turns(response, lane)))
        ]
        slack = {"housner": 1e-9, "event": 1e-9}.get(engine, 2e-3)
        assert np.all(np.diff(peaks) <= slack * lanes.slenderness_angle[lane])


def turns(response: Response, lane: int) -> np.ndarray:
    """Where the rotation changes its sign between two samples."""
    sign = np.signbit(response["rotation"][lane])
    return np.diff(sign, prepend=sign[0])


@every_engine
def test_block_rests_below_the_uplift_acceleration_and_lifts_above(engine: str) -> None:
    limit = rocking.uplift_acceleration(0.2, 1.0)
    ratio = np.array([0.5, 0.9, 0.99, 1.01, 1.2])
    lanes = make_lanes(np.full(5, 0.2), 1.0)
    motions = sines(Control.ACCELERATION, ratio * limit, 2.0, cycles=1.0)
    response = run_batch(engine, lanes, motions, SampleTimes(0.6), settings=RIGID.get(engine))
    lifted = np.isfinite(response["uplift_time"])
    np.testing.assert_array_equal(lifted, ratio > 1.0)
    assert np.all(response["outcome"][~lifted] == Outcome.AT_REST)
    # A block on springs leans on them: by m g / (k A / 2) = 4e-8 m in half of its width.
    still = {"dem": 1e-5}.get(engine, 1e-6)
    assert np.all(response["peak_rotation"][~lifted] < still * lanes.slenderness_angle[0])
    expected = np.arcsin(1.0 / ratio[lifted]) / (4.0 * np.pi)
    # Round-off for an event; a step of 2e-4 s (twice, for the half step) for a time step. Near its
    # crest the pulse is flat: the impulse engine sees the uplift within the square root of that,
    # the secant of the event engine misses it by a part of its step of 5e-3 s.
    # A block on springs has to turn by twice what it leans, first with the cube of the time.
    tolerance = {"housner": 1e-9, "event": 1e-3, "dem": 1e-2}.get(engine, 4e-3)
    np.testing.assert_allclose(response["uplift_time"][lifted], expected, atol=tolerance)


@every_engine
def test_bad_lane_harms_no_neighbour(engine: str, unjudged: None) -> None:
    lanes, motions = mixed_batch()
    good = mixed_response(engine)
    height = lanes.height.copy()
    height[5] = np.nan
    response = run_batch(engine, dataclasses.replace(lanes, height=height), motions, TIMES)
    others = np.arange(LANES) != 5
    assert response["status"][5] == Status.NONFINITE
    assert np.all(np.isin(response["status"][others], [Status.OK, Status.OUTSIDE_MODEL]))
    for name in LANE_FIELDS:
        np.testing.assert_array_equal(response[name][others], good[name][others], err_msg=name)


def test_a_form_by_its_name_is_that_form() -> None:
    assert Target(form="plain").kernel_form is Form.PLAIN
    with pytest.raises(ValueError, match="fast"):
        Target(form="fast")


@pytest.mark.thorough
@every_engine
def test_single_precision_is_near_double(engine: str) -> None:
    lanes = free_lanes()
    times = SampleTimes(1.0, 0.01)
    double = run_batch(engine, lanes, at_rest(9), times)
    single = run_batch(engine, lanes, at_rest(9), times, precision="float32")
    error = np.abs(single["rotation"] - double["rotation"]).max(axis=1) / lanes.slenderness_angle
    # float32 has 1.2e-7; a run from 0.99 alpha magnifies it a hundredfold, 200 steps of the event
    # engine add up as many roundings, and so do 5000 of the impulse engine.
    assert np.all(error < {"housner": 1e-4, "event": 1e-3}.get(engine, 2e-2))
    assert np.all(error > 0.0)


@every_engine
def test_overturning_is_an_outcome(engine: str) -> None:
    lanes = make_lanes(np.full(2, 0.2), 1.0)
    motions = sines(Control.ACCELERATION, np.array([2.0 * GRAVITY, -2.0 * GRAVITY]), 1.0, 0.5)
    response = run_batch(engine, lanes, motions, SampleTimes(3.0, 0.1))
    assert np.all(response["outcome"] == Outcome.OVERTURNED)
    np.testing.assert_allclose(np.abs(response["peak_rotation"]), 0.5 * np.pi, rtol=1e-12)
    assert response["rotation"][0, -1] < 0.0 < response["rotation"][1, -1]


@every_engine
def test_histories_do_not_change_the_response(engine: str) -> None:
    lanes, motions = mixed_batch()
    asked = mixed_response(engine)
    alone = run_batch(engine, lanes, motions, SampleTimes(TIMES.duration))
    assert "rotation" not in alone.fields
    ok = asked["outcome"] != Outcome.OVERTURNED
    # housner cuts its steps at samples, which moves the last bits.
    for name in ("peak_rotation", "impact_count", "uplift_time"):
        np.testing.assert_allclose(asked[name][ok], alone[name][ok], rtol=1e-7, err_msg=name)


@pytest.mark.parametrize("engine", all_but(NOT_STILL, single_block_engines()))
def test_still_base_leaves_a_flat_block_alone(engine: str) -> None:
    motions: GroundMotions = StillBase(1)
    response = run_batch(engine, make_lanes(0.5, 1.0), motions, SampleTimes(1.0))
    assert response["outcome"][0] == Outcome.AT_REST
    assert response["rest_time"][0] == 0.0
    assert np.isnan(response["uplift_time"][0])
    assert response["impact_count"][0] == 0
    # The sweeps leave a part of 0.36^10 = 4e-5 of the two steps that start the run, each of which
    # could turn the block by no more than g dt^2 / width = 8e-7 rad.
    assert response["peak_rotation"][0] < 1e-9 + (3e-9 if engine == "impulse" else 0.0)
