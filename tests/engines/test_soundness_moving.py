"""Energy from nowhere on moving bases: what accounts tell, and runs on many bases."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import pandas as pd
import pytest

from tests.shared.blocks import Array, make_lanes, sines, single_block_engines, two_equal
from tests.shared.marks import all_but
from warprock.engines import engine_class
from warprock.engines.soundness import Account, contacts_hold, find_moved_by_nothing, unstable
from warprock.measure.atlas_maps import at_step, at_stiffness
from warprock.model import rocking
from warprock.model.lanes import Lanes, as_stacks
from warprock.model.motion import Control, HarmonicMotions
from warprock.model.response import SOUND, USABLE, Response, SampleTimes, Status
from warprock.running.batch import run_batch
from warprock.settings.engines import build_settings
from warprock.units import GRAVITY


def account(
    count: int, *, returned: Any = 0.0, supplied: Any = 0.0, pull: Any = 1e9, deepest: float = 0.0
) -> Account:
    """An account of lanes of which nothing else is told."""
    parts = (pull, supplied, 0.0, returned, deepest)
    return Account(*(np.broadcast_to(np.asarray(part, float), count) for part in parts))


def test_soft_contacts_are_judged_by_less():
    lanes = make_lanes(np.full(2, 0.2), 1.0, 0.1)
    peak = np.full(2, 1.5)
    assert unstable(lanes, account(2), peak).all()
    found = unstable(lanes, account(2), peak, rigid=np.array([True, False]))
    np.testing.assert_array_equal(found, [True, False])
    # 200 kg on a rise of 10 mm: 20 kN/m sink by 0.1 m, 2e9 N/m by a micrometre.
    assert contacts_hold(lanes, 2e9).all()
    assert not contacts_hold(lanes, 2e4).any()


def test_contacts_give_back_no_more_than_was_held_and_supplied():
    lanes = make_lanes(np.full(4, 0.2), 1.0, np.array([0.0, 0.0, 0.5, 0.5]))
    barrier = GRAVITY * lanes.mass[0] * 0.5 * (math.hypot(0.2, 1.0) - 1.0)
    held = 0.75 * barrier
    given = account(4, returned=[0.2 * barrier, 0.2 * barrier, 1.1 * held, 1.1 * held],
                    supplied=[0.1 * barrier, 0.3 * barrier, 0.0, 0.2 * held])  # fmt: skip
    found = unstable(lanes, given, np.abs(lanes.rotation_start))
    np.testing.assert_array_equal(found, [True, False, True, False])
    # What soft contacts hold of a block that has sunk is its own.
    sunk = account(1, returned=0.2 * barrier, deepest=0.3 * barrier / (GRAVITY * lanes.mass[0]))
    soft = unstable(lanes.take(slice(0, 1)), sunk, np.zeros(1), rigid=False)
    assert not soft[0]
    # A rotation that takes more than there was; a base that supplies it.
    peak = np.full(4, 1.0)
    rocked = account(4, supplied=[0.0, 2.0 * barrier, 0.0, 2.0 * barrier])
    np.testing.assert_array_equal(unstable(lanes, rocked, peak)[:2], [True, False])


@pytest.mark.parametrize("stacked_blocks", [1, 2])
def test_a_base_too_weak_to_lift_a_block_turns_none(stacked_blocks: int):
    lanes = make_lanes(np.full(5, 0.2), 1.0, np.array([0.0, 0.0, 0.0, 0.0, 0.1]))
    lanes = as_stacks(lanes) if stacked_blocks == 1 else two_equal(lanes)
    # Two blocks on one another turn as one from half of what lifts a single one.
    limit = 0.2 * GRAVITY / stacked_blocks
    pull = np.array([0.85, 0.85, 0.95, 1.2, 0.85]) * limit
    angle = math.atan(0.2)
    turned = np.array([0.06, 0.04, 0.06, 1.0, 0.06])[:, None] * angle
    peak = np.repeat(turned, stacked_blocks, axis=1)
    found = find_moved_by_nothing(lanes, pull, peak)
    np.testing.assert_array_equal(found, [True, False, False, False, False])


SHAKEN = pd.MultiIndex.from_product(
    [[0.002, 0.04, 0.3, 5.0], [0.2, 1.0, 5.0], [0.05, 1.0], [0.5, 2.0, 8.0, 20.0], [0.05, 10.0]],
    names=["amplitude_g", "frequency", "height", "slenderness", "friction"],
).to_frame(index=False)
"""Small and large blocks that stand flat, slender and stocky, slippery or not, on many bases."""


def shaken() -> tuple[Lanes, HarmonicMotions]:
    lanes = make_lanes(
        SHAKEN["height"] / SHAKEN["slenderness"], SHAKEN["height"], 0.0, SHAKEN["friction"]
    )
    amplitude = GRAVITY * SHAKEN["amplitude_g"].to_numpy()
    return lanes, sines(Control.ACCELERATION, amplitude, SHAKEN["frequency"].to_numpy(), 3.0)


def beyond_the_base(lanes: Lanes, response: Response, duration: float) -> Array:
    """Where a lane did what its base cannot do to a rigid block, whatever its contacts.

    In the frame of the base |d sqrt(E)/dt| <= sqrt(m / 2) |a|, so that sqrt(2 E / m) is at most the
    total variation S of the base velocity: of a sine 2 A / (pi f) a half cycle. Twice that for the
    rotation and its way, and a tenth of the width, is beyond all doubt; so is a twentieth of the
    slenderness angle under an acceleration that lifts no corner.
    """
    amplitude = GRAVITY * SHAKEN["amplitude_g"].to_numpy()
    frequency = SHAKEN["frequency"].to_numpy()
    half_cycles = np.ceil(2.0 * frequency * np.minimum(3.0 / frequency, duration))
    variation = half_cycles * amplitude / (np.pi * frequency)
    most = 0.5 * lanes.mass * variation**2
    held = rocking.energy(
        lanes.width, lanes.height, lanes.depth, lanes.density,
        np.minimum(np.abs(response["peak_rotation"]), lanes.slenderness_angle), 0.0,
    )  # fmt: skip
    barrier = 0.5 * GRAVITY * lanes.mass * (np.hypot(lanes.width, lanes.height) - lanes.height)
    thrown = held > 2.0 * most + 0.1 * barrier
    slid = response["peak_slide"] > 2.0 * variation * duration + 0.1 * lanes.width
    weak = amplitude < 0.89 * GRAVITY * lanes.width / lanes.height
    return np.asarray(thrown | slid | (weak & (held > 0.1 * barrier)))


@pytest.mark.parametrize(
    ("engine", "step", "changes", "least", "precision"),
    [
        ("impulse", 0.1, {}, 60, "float64"),
        ("impulse", 0.02, {}, 20, "float64"),
        ("xpbd", 0.1, {}, 15, "float64"),
        ("xpbd", 0.1, {"compliance": 1e-9}, 15, "float64"),
        ("direct", 0.1, {}, 0, "float64"),
        pytest.param("xpbd", 0.1, {}, 15, "float32", marks=pytest.mark.thorough),
    ],
)
def test_what_no_base_can_do_is_seen_on_a_moving_one(
    engine: str, step: float, changes: dict[str, float], least: int, precision: str
):
    lanes, motions = shaken()
    settings = at_step(build_settings(engine, {}, "test"), step)
    settings = dataclasses.replace(settings, **changes)
    times = SampleTimes(5.0)
    response = run_batch(engine, lanes, motions, times, settings=settings, precision=precision)
    absurd = beyond_the_base(lanes, response, times.duration)
    assert absurd.sum() >= least
    assert not np.any(absurd & np.isin(response["status"], USABLE))


SLIDING = [name for name in single_block_engines() if engine_class(name).slides]


@pytest.mark.parametrize("engine", all_but(("dem",), SLIDING))
def test_no_sound_lane_on_a_moving_base_is_called_unstable(engine: str):
    lanes, motions = shaken()
    response = run_batch(engine, lanes, motions, SampleTimes(2.0))
    assert not np.any(response["status"] == Status.UNSTABLE)
    # The springs of `dem` lean where rigid faces stand; `event` may run out of steps as it slides.
    if engine != "dem":
        usable = np.isin(response["status"], USABLE)
        assert not np.any(usable & beyond_the_base(lanes, response, 2.0))
        assert usable.sum() >= 0.98 * len(usable)


def test_dem_beyond_its_stable_step_says_so_on_a_moving_base():
    lanes, motions = shaken()
    base = at_stiffness(at_step(build_settings("dem", {}, "test"), 0.1), 1e8)
    wild, calm = (
        run_batch("dem", lanes, motions, SampleTimes(1.0),
                  settings=dataclasses.replace(base, step_safety=safety))
        for safety in (2.0, 0.2)
    )  # fmt: skip
    assert (wild["status"] == Status.UNSTABLE).sum() > 100
    # Half of the lanes have friction 10, above Painleve's limit, and slide on their springs.
    assert np.all(np.isin(calm["status"], SOUND))
