"""`housner` with strips of wall between two floors, against closed forms and the SciPy oracle."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from tests.shared.blocks import at_rest, make_lanes, sines, velocity_steps
from tests.shared.marks import first
from tests.shared.strips import strip_batch, strips
from warprock.model.lanes import Lanes
from warprock.model.motion import Control, HarmonicMotions
from warprock.model.response import Outcome, SampleTimes, Status
from warprock.model.strip import LAID
from warprock.oracle.block import oracle_response
from warprock.oracle.strip import StripWall
from warprock.running.batch import run_batch
from warprock.units import GRAVITY

AGREEMENT = 1e-7
"""What is left between `housner` and the oracle, in leans of balance: histories of the oracle are a
dense output of order 7, and differences grow where a strip comes close to its balance."""

LOOKED_UP = 1e-4
"""Relative error of the largest friction: the top of a parabola through looks, eight to a step."""

WALL = make_lanes(np.full(4, 0.2), 2.8)
"""Walls of 0.2 x 2.8 m, height over width 14."""
HINGE = np.array([0.5, 0.5, 0.3, 0.9])
WEIGHT = np.array([0.0, 1e4, 2e4, 3e3])


def lift(lanes: Lanes, lean: np.ndarray, side: float) -> np.ndarray:
    """Energy of bodies and weight at a lean to a side [J], by turning points of the plane."""
    strip = lanes.hold.strip
    found = np.empty(lanes.lane_count)
    for lane in range(lanes.lane_count):
        t, h1, h2 = (float(each[lane]) for each in (strip.width, strip.lower, strip.upper))
        arm = float(strip.arm[lane, int(side > 0)])
        turn = complex(np.cos(lean[lane]), -np.sin(lean[lane]))
        hinge = (0.5 * t) + complex(-t, h1) * turn
        # The upper body turns until its top is above where it was.
        ahead = complex(arm, h2)
        reach = (arm - 0.5 * t - hinge.real) / abs(ahead)
        other = complex(np.exp(1j * (np.arccos(reach) - np.angle(ahead))))
        centres = 0.5 * t + complex(-0.5 * t, 0.5 * h1) * turn, hinge + complex(t, h2) * other / 2
        masses = np.array([h1, h2]) / (h1 + h2) * lanes.mass[lane]
        rise = np.imag(centres) - np.array([0.5 * h1, h1 + 0.5 * h2])
        top = (hinge + ahead * other).imag - h1 - h2
        found[lane] = GRAVITY * float(masses @ rise) + float(strip.weight[lane]) * top
    return found


def test_the_static_multiplier_is_that_of_the_mechanism():
    lanes = strips(WALL, HINGE, WEIGHT)
    # 2 t / (x h) without a load (Sorrentino, Masiani and Griffith 2008).
    np.testing.assert_allclose(lanes.uplift_ratios[0], 0.285714, atol=6e-7)
    # Of a load N on the rising edge: virtual work of N t (1 + x / (1 - x)).
    expected = 2.0 / (14.0 * HINGE) * (1.0 + WEIGHT / (GRAVITY * lanes.mass) / (1.0 - HINGE))
    np.testing.assert_allclose(lanes.uplift_ratios.T, [expected] * 2, rtol=1e-14)


def test_a_strip_bows_at_its_static_multiplier():
    lanes = strips(WALL, 0.6, 1e4, 0.03)
    left, right = lanes.uplift_ratios[0] * GRAVITY
    # A weight at +x holds more where it is farther from the hinge, bowed to +x.
    assert right > left
    pull = [0.999 * left, 1.001 * left, -0.999 * right, -1.001 * right]
    motions = sines(Control.ACCELERATION, pull, 1.0, cycles=0.5)
    found = run_batch("housner", lanes, motions, SampleTimes(0.5))
    np.testing.assert_array_equal(np.isfinite(found["uplift_time"]), [False, True, False, True])


def test_the_restitution_is_what_momenta_of_both_bodies_say():
    lanes = strips(make_lanes(np.full(4, 0.3), 2.8), HINGE, WEIGHT)
    for lane in range(4):
        wall = StripWall((0.3, 2.8, 1.0), 1.0, None, lanes.hold.strip, lane)
        found = wall.rate_after_impact(1, -1.0)
        np.testing.assert_allclose(lanes.angular_restitution[lane], found, rtol=1e-13)
        along, upwards = wall.impact_impulse(1, -1.0, found)
        asked = lanes.hold.strip.impact_friction(lanes.angular_restitution)[lane]
        np.testing.assert_allclose(asked, abs(along) / upwards, rtol=1e-12)


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_strip_that_rests_has_lost_what_it_held(side):
    blocks = dataclasses.replace(WALL, rotation_start=side * 0.6 * WALL.slenderness_angle)
    lanes = strips(blocks, HINGE, WEIGHT, [np.nan, 0.05, -0.08, np.nan])
    found = run_batch("housner", lanes, at_rest(4), SampleTimes(60.0))
    np.testing.assert_array_equal(found["outcome"], Outcome.AT_REST)
    held = lift(lanes, np.abs(lanes.rotation_start), side)
    # Round-off of some hundred steps; the swings that the rest rule leaves out hold 1e-9 of it.
    np.testing.assert_allclose(found["energy_lost"], held, rtol=1e-8)


def test_the_step_that_just_fells_a_strip_is_what_energy_says():
    part = np.array([1.0 - 1e-6, 1.0 + 1e-6, 1.0 - 1e-6, 1.0 + 1e-6])
    lanes = strips(WALL, np.repeat(HINGE[1:3], 2), 1e4)
    upright = lanes.hold.strip.upright
    inertia, pulled = upright.inertia[:, 1], upright.pulled[:, 1]
    top = lift(lanes, lanes.hold.strip.critical[:, 1], 1.0)
    # The step throws the masses back: M theta' = S' dv.
    step = np.sqrt(2.0 * top / inertia) * inertia / pulled
    motions = velocity_steps(-step * part, np.zeros(4), np.ones(4))
    motions = dataclasses.replace(motions, stop=np.full(4, 100.0))
    found = run_batch("housner", lanes, motions, SampleTimes(40.0))
    np.testing.assert_array_equal(found["outcome"] == Outcome.OVERTURNED, [False, True] * 2)
    # It has fallen where one of its bodies lies; the others have come back.
    fell = found["outcome"] == Outcome.OVERTURNED
    turns = np.abs(lanes.hold.strip.places(found["peak_rotation"][:, None])[..., 0, 2])
    np.testing.assert_allclose(turns.max(axis=1)[fell], LAID, rtol=1e-12)
    assert (found["peak_rotation"] < lanes.slenderness_angle)[~fell].all()


def test_what_is_mirrored_moves_mirrored():
    lanes, motions = strip_batch(8, 4)
    strip = lanes.hold.strip
    other = dataclasses.replace(strip, arm=strip.arm[:, ::-1].copy())
    mirrored = dataclasses.replace(
        lanes,
        rotation_start=-lanes.rotation_start,
        hold=dataclasses.replace(lanes.hold, strip=other),
    )
    times = SampleTimes(3.0, 0.02)
    found = run_batch("housner", lanes, motions, times)
    back = motions.scaled(np.full(8, -1.0))
    turned = run_batch("housner", mirrored, back, times)
    np.testing.assert_array_equal(found["rotation"], -turned["rotation"])


def assert_follows_oracle(lanes: Lanes, motions: HarmonicMotions) -> None:
    """Lanes in `housner` beside the oracle."""
    times = SampleTimes(4.0, 0.02)
    found = run_batch("housner", lanes, motions, times, workers=1)
    oracle = oracle_response(lanes, motions, times, rtol=1e-13)
    assert np.isin(found["status"], [Status.OK, Status.OUTSIDE_MODEL]).all()
    off = np.abs(found["rotation"] - oracle["rotation"]).max(axis=1) / lanes.slenderness_angle
    assert off.max() < AGREEMENT, (int(off.argmax()), off.max())
    for name in ("outcome", "status", "impact_count"):
        np.testing.assert_array_equal(found[name], oracle[name], err_msg=name)
    for name in ("peak_rotation", "energy_lost", "uplift_time", "rest_time"):
        np.testing.assert_allclose(
            found[name], oracle[name], rtol=AGREEMENT, atol=1e-9, err_msg=name
        )
    np.testing.assert_allclose(found["friction_needed"], oracle["friction_needed"], rtol=LOOKED_UP)


@pytest.mark.parametrize("seed", first(1, [1, 2]))
def test_random_strips_follow_the_oracle(seed):
    assert_follows_oracle(*strip_batch(3, seed))


@pytest.mark.thorough
def test_a_strip_that_comes_back_from_beyond_its_balance_follows_the_oracle():
    # Beyond its balance for half a second, in which what is off grows a hundredfold.
    lanes, motions = strip_batch(60, 2)
    assert_follows_oracle(lanes.take(slice(50, 51)), motions.take(slice(50, 51)))


@pytest.mark.thorough
def test_many_random_strips_follow_the_oracle():
    # The oracle takes seconds a lane; a hundred lanes of each of three seeds were held once.
    assert_follows_oracle(*strip_batch(12, 3))
