"""The springs of `dem`: rebounds and stable steps against closed forms, areas that add up."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from tests.shared.blocks import at_rest, make_lanes, make_stacks
from tests.shared.closed_forms import contact_restitution
from tests.shared.marks import first
from warprock.engines import dem
from warprock.engines.dem_springs import (
    Springs,
    Start,
    stable_step,
    start_at_rest,
    stiffest_frequency,
)
from warprock.model.lanes import Lanes
from warprock.model.motion import StillBase
from warprock.model.response import SampleTimes, Status
from warprock.running.batch import run_batch
from warprock.settings.engines import DemSettings
from warprock.units import GRAVITY


def vertical_frequency(lanes: Lanes, settings: DemSettings) -> float:
    """Frequency of a block that moves up and down on its springs [rad/s]."""
    stiffness = settings.normal_stiffness * lanes.width * lanes.depth
    return float(np.sqrt(stiffness / lanes.mass)[0])


def starting_at(monkeypatch: pytest.MonkeyPatch, height: float) -> None:
    """Lets every block start this much above where it would rest [m]."""

    def raised(lanes: Lanes, settings: DemSettings) -> Start:
        start = start_at_rest(lanes, settings)
        return dataclasses.replace(start, settlement=start.settlement + height)

    monkeypatch.setattr(dem, "start_at_rest", raised)


@pytest.mark.parametrize("ratio", first(4, [0.0, 0.3, 1.0, 1.5, 0.1, 0.5, 0.7, 0.9]))
def test_drop_rebounds_by_the_closed_form(ratio: float, monkeypatch: pytest.MonkeyPatch) -> None:
    drop = 0.5
    starting_at(monkeypatch, drop)
    lanes = make_lanes(0.2, 1.0)
    base = DemSettings(normal_stiffness=1e11, shear_stiffness=1e6)
    frequency = vertical_frequency(lanes, base)
    settings = dataclasses.replace(
        base, stiffness_damping=2.0 * ratio / frequency, step_safety=0.0125
    )
    # Long after the contact, and before the next one even at the smallest rebound.
    until = np.sqrt(2.0 * drop / GRAVITY) * (1.0 + 0.1 * float(contact_restitution(ratio)))
    response = run_batch("dem", lanes, StillBase(1), SampleTimes(until), settings=settings)
    # The drop was put in behind the engine's back: without damping its account finds a part in a
    # thousand of the drop, next to nothing that the block held where the engine thinks it starts.
    assert np.all(np.isin(response["status"], [Status.OK, Status.UNSTABLE]))
    kept = 1.0 - response["energy_lost"] / (lanes.mass * GRAVITY * drop)
    # Gravity during the contact, left out of the closed form, is g / (w v) = 4e-4 of the force;
    # the rest is a part of the step, w dt = 0.025 and less.
    np.testing.assert_allclose(np.sqrt(kept), contact_restitution(ratio), atol=5e-3)


def test_restitution_is_continuous_at_critical_damping() -> None:
    near = contact_restitution([0.0, 1.0 - 1e-8, 1.0, 1.0 + 1e-8])
    # A tenth of the digits is lost where two small numbers are divided.
    np.testing.assert_allclose(near, [1.0, np.exp(-2.0), np.exp(-2.0), np.exp(-2.0)], rtol=1e-3)


@pytest.mark.parametrize("ratio", [0.0, 0.3, 1.0])
def test_steps_are_stable_up_to_the_limit_and_not_beyond(
    ratio: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    # A tensile strength that never fails keeps the springs linear; the vertical mode is the
    # stiffest one of a block on two springs that is higher than wide.
    starting_at(monkeypatch, 1e-6)
    lanes = make_lanes(0.2, 1.0)
    base = DemSettings(
        shear_stiffness=1e6, subcontacts=2, tensile_strength=1e12, cohesion=1e12, time_step=0.1
    )
    frequency = vertical_frequency(lanes, base)
    assert stiffest_frequency(make_stacks(0.2, 1.0), base)[0] == pytest.approx(frequency, rel=1e-9)
    damped = dataclasses.replace(base, stiffness_damping=2.0 * ratio / frequency)
    assert stable_step(np.array([frequency]), damped)[0] == pytest.approx(
        2.0 / frequency * (np.sqrt(1.0 + ratio**2) - ratio)
    )
    energy = 0.5 * frequency**2 * lanes.mass * 1e-12
    for safety, stable in ((0.99, True), (1.02, False)):
        settings = dataclasses.replace(damped, step_safety=safety)
        response = run_batch("dem", lanes, at_rest(1), SampleTimes(1.0), settings=settings)
        lost = response["energy_lost"]
        # Near its limit an undamped mode keeps an energy that is not the continuous one, but
        # bounded: 1 / (1 - 0.99^2) = 50 of it.
        assert (lost[0] > -100.0 * energy[0]) == stable
        assert response["status"][0] == (Status.OK if stable else Status.UNSTABLE)


def test_points_stand_for_the_whole_face() -> None:
    width, offset = np.array([[0.4, 0.5], [0.4, 0.2]]), np.array([[0.0, 0.1], [0.0, 0.15]])
    lanes = make_stacks(width, 0.6, offset=offset)
    springs = Springs.of(lanes, 4)
    np.testing.assert_allclose(springs.place[:, 1, 0], [-0.25, -0.1], atol=1e-15)
    np.testing.assert_allclose(springs.place[:, 1, -1], [0.1, 0.05], atol=1e-15)
    np.testing.assert_allclose(springs.area.sum(axis=2), [[0.2, 0.175], [0.2, 0.075]])
