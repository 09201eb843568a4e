"""`housner` with blocks on compliant ground, against closed forms and the SciPy oracle."""

from __future__ import annotations

import dataclasses

import numpy as np
import numpy.typing as npt
import pytest

from tests.shared.beds import bed_batch
from tests.shared.blocks import at_rest, make_lanes
from warprock.model import rocking
from warprock.model.hold import Bed, Hold
from warprock.model.lanes import Lanes
from warprock.model.response import Outcome, SampleTimes, Status
from warprock.oracle.block import oracle_response
from warprock.running.batch import run_batch
from warprock.units import GRAVITY

AGREEMENT = 1e-7
"""What is left between `housner` and the oracle, in slenderness angles: the events of the oracle
lie on a dense output of order 7, and differences grow where a block comes close to its balance."""

LOOKED_UP = 1e-4
"""Relative error of the largest friction: the top of a parabola through looks, eight to a step."""

WIDTH, HEIGHT = 0.5, 2.0


def on_bed(lanes: Lanes, stiffness: npt.ArrayLike, damping: npt.ArrayLike = 0.0) -> Lanes:
    """Lanes on ground of a stiffness [N/m^3] and a damping [N s/m^3]."""
    k, c = (
        np.broadcast_to(np.asarray(each, np.float64), (lanes.lane_count,)).copy()
        for each in (stiffness, damping)
    )
    return dataclasses.replace(lanes, hold=Hold(bed=Bed(k, c)))


@pytest.mark.parametrize("share", [0.0, 0.2])
def test_a_block_on_its_whole_face_swings_as_its_closed_form(share):
    # K = k d b^3 / 12 - W h / 2 over J = I + m h^2 / 4; dampers likewise, full sizes.
    lanes = make_lanes(np.full(2, WIDTH), HEIGHT, [1e-6, -1e-6], 5.0)
    mass, depth, k = float(lanes.mass[0]), float(lanes.depth[0]), 1e7
    inertia = mass * (WIDTH**2 + HEIGHT**2) / 12.0 + mass * HEIGHT**2 / 4.0
    face = depth * WIDTH**3 / 12.0
    omega = np.sqrt((k * face - mass * GRAVITY * HEIGHT / 2.0) / inertia)
    c = 2.0 * share * omega * inertia / face
    times = SampleTimes(3.0, 0.01)
    found = run_batch("housner", on_bed(lanes, k, c), at_rest(2), times)
    pole = omega * complex(-share, np.sqrt(1.0 - share**2))
    t = found.times
    wave = (np.exp(pole * t) * (1.0 + 1j * pole.real / pole.imag)).real
    # Terms of second order: the lean of 2.5e-7 rad, some waves long.
    np.testing.assert_allclose(
        found["rotation"] / lanes.rotation_start[:, None], [wave, wave], atol=3e-6
    )
    np.testing.assert_array_equal(found["rotation"][0], -found["rotation"][1])
    np.testing.assert_array_equal(found["outcome"], Outcome.AT_REST)
    assert np.isnan(found["uplift_time"]).all()


def test_a_block_at_rest_stays_as_it_is():
    lanes = on_bed(make_lanes(np.full(2, WIDTH), HEIGHT, 0.0, 5.0), [1e7, 1e10], 1e5)
    found = run_batch("housner", lanes, at_rest(2), SampleTimes(2.0, 0.1))
    # Round-off of the balance of weight and springs.
    assert np.abs(found["rotation"]).max() < 1e-15
    np.testing.assert_array_equal(found["rest_time"], 0.0)
    np.testing.assert_array_equal(found["impact_count"], 0)


def test_dampers_take_all_that_a_block_held():
    count = 8
    lanes = make_lanes(np.full(count, WIDTH), HEIGHT, np.linspace(0.1, 0.9, count), 5.0)
    lanes = on_bed(lanes, 10.0 ** np.linspace(7.0, 8.0, count), np.linspace(1e5, 3e5, count))
    found = run_batch("housner", lanes, at_rest(count), SampleTimes(80.0))
    np.testing.assert_array_equal(found["outcome"], Outcome.AT_REST)
    assert (found["impact_count"] > 3).any()
    hold, weight = lanes.hold, lanes.mass * GRAVITY
    sunk = hold.bed.sunk(lanes.width, lanes.depth, lanes.mass)
    # Let go in balance on a triangle of pressure, w deep at the corner, whose work is W w / 3.
    raised = WIDTH * np.sin(lanes.rotation_start)
    deep = np.sqrt(2.0 * raised * sunk)
    assert (deep < raised).all()
    came = rocking.energy(WIDTH, HEIGHT, 0.5, 2000.0, lanes.rotation_start, 0.0)
    came = came + weight * (deep / 3.0 - deep)
    held = weight * (0.5 * sunk - sunk)
    # A step leaves out terms of 1e-12 of a swing, in some thousand steps.
    np.testing.assert_allclose(found["energy_lost"], came - held, rtol=1e-9)


def test_its_stiff_limit_is_housners_block():
    count = 4
    stiffness = 10.0 ** np.arange(6.0, 14.0, 2.0)[:count] * 10.0
    free = make_lanes(np.full(count, WIDTH), HEIGHT, 0.5, 5.0)
    # Up to just before the first impact: what that leaves is the ground's own.
    times = SampleTimes(0.4, 0.05)
    exact = run_batch("housner", free, at_rest(count), times)
    found = run_batch("housner", on_bed(free, stiffness), at_rest(count), times)
    off = np.abs(found["rotation"] - exact["rotation"]).max(axis=1) / free.slenderness_angle
    # The pressed length, and with it the lever of the ground, goes with the root of the stiffness.
    np.testing.assert_allclose(off[1:-1] / off[2:], 10.0, rtol=0.15)
    assert off[-1] < 1e-3


def test_lanes_and_their_mirror_images_have_the_same_bits():
    lanes, motions = bed_batch(20, 3)
    times = SampleTimes(3.0, 0.02)
    found = run_batch("housner", lanes, motions, times)
    back = dataclasses.replace(lanes, rotation_start=-lanes.rotation_start)
    other = run_batch("housner", back, motions.scaled(np.full(20, -1.0)), times)
    np.testing.assert_array_equal(found["rotation"], -other["rotation"])


@pytest.mark.thorough
def test_float32_errs_by_its_round_off():
    lanes, motions = bed_batch(60, 4)
    times = SampleTimes(3.0, 0.02)
    double = run_batch("housner", lanes, motions, times)
    single = run_batch("housner", lanes, motions, times, precision="float32")
    assert np.isin(single["status"], [Status.OK, Status.OUTSIDE_MODEL]).all()
    off = np.abs(single["rotation"] - double["rotation"]).max(axis=1) / lanes.slenderness_angle
    # Places of 1e-7 of a rotation beside depths of 1e-3 of a width.
    assert np.median(off) < 1e-4


def assert_follows_oracle(count: int, seed: int, duration: float) -> None:
    """Random lanes beside the oracle."""
    lanes, motions = bed_batch(count, seed)
    times = SampleTimes(duration, 0.02)
    found = run_batch("housner", lanes, motions, times, workers=1)
    oracle = oracle_response(lanes, motions, times, rtol=1e-12)
    assert np.isin(found["status"], [Status.OK, Status.OUTSIDE_MODEL]).all()
    off = np.abs(found["rotation"] - oracle["rotation"]).max(axis=1) / lanes.slenderness_angle
    assert off.max() < AGREEMENT, (int(off.argmax()), off.max())
    for name in ("outcome", "status", "impact_count"):
        np.testing.assert_array_equal(found[name], oracle[name], err_msg=name)
    for name in ("peak_rotation", "energy_lost", "uplift_time", "rest_time"):
        np.testing.assert_allclose(
            found[name], oracle[name], rtol=AGREEMENT, atol=1e-8, err_msg=name
        )
    np.testing.assert_allclose(found["friction_needed"], oracle["friction_needed"], rtol=LOOKED_UP)


@pytest.mark.thorough
@pytest.mark.parametrize("seed", [1])
def test_random_lanes_follow_the_oracle(seed):
    assert_follows_oracle(4, seed, 1.5)


@pytest.mark.thorough
def test_many_random_lanes_follow_the_oracle():
    # The oracle takes some seconds a lane; three hundred were held against it once.
    assert_follows_oracle(3, 2, 3.0)
