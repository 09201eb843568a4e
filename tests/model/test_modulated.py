"""Pulses of Mavroeidis and Papageorgiou: the formula, its peak, and the engines that follow it."""

import itertools
import pathlib

import numpy as np
import pytest

from tests.shared.blocks import make_lanes
from warprock.case.lanes import expand_lanes
from warprock.case.load import load_case
from warprock.errors import InputError
from warprock.model.motion import (
    Control,
    ModulatedMotions,
    mavroeidis_papageorgiou_motions,
    modulated_peak_acceleration,
)
from warprock.model.response import SampleTimes, Status
from warprock.oracle.block import oracle_response
from warprock.running.batch import run_batch
from warprock.settings.engines import ImpulseSettings

Array = np.ndarray
GRAVITY = 9.81
CYCLES = np.array([1.0001, 1.3, 2.0, 3.7])
PHASE = np.array([0.0, 0.7, np.pi / 2, -2.5])
START = np.array([0.0, 0.3, 1.0, 0.1])
FREQUENCY = np.array([0.5, 1.0, 2.0, 3.0])


def pulses(control: Control, amplitude: float = 0.4, lanes: int = 4) -> ModulatedMotions:
    return mavroeidis_papageorgiou_motions(
        [control] * lanes,
        np.full(lanes, amplitude),
        FREQUENCY[:lanes],
        START[:lanes],
        cycles=CYCLES[:lanes],
        phase=PHASE[:lanes],
    )


def formula(lane: int, time: Array) -> Array:
    """The controlled quantity as it is printed, of amplitude 0.4."""
    f, gamma, nu = FREQUENCY[lane], CYCLES[lane], PHASE[lane]
    tau = time - START[lane] - gamma / (2.0 * f)
    envelope = 1.0 + np.cos(2.0 * np.pi * f / gamma * tau)
    return 0.2 * envelope * np.cos(2.0 * np.pi * f * tau + nu)


@pytest.mark.parametrize("lane", range(4))
@pytest.mark.parametrize("control", Control)
def test_the_controlled_quantity_is_the_printed_formula(control: Control, lane: int) -> None:
    motions = pulses(control)
    length = CYCLES[lane] / FREQUENCY[lane]
    assert motions.stop[lane] - START[lane] == pytest.approx(length, rel=1e-14)
    time = START[lane] + length * np.linspace(0.01, 0.99, 50)
    found = motions.acceleration(time, lane)
    w = 4.0 * np.pi * FREQUENCY[lane]
    if control is Control.ACCELERATION:
        assert found == pytest.approx(formula(lane, time), abs=1e-14)
    elif control is Control.VELOCITY:
        h = 1e-5  # step^2 / 6 x w^3, and round-off / step
        slope = (formula(lane, time + h) - formula(lane, time - h)) / (2.0 * h)
        assert found == pytest.approx(slope, abs=0.4 * (h**2 * w**3 / 6.0 + 1e-15 / h))
    else:
        h = 1e-4  # step^2 / 12 x w^4, and round-off / step^2
        sides = formula(lane, time + h) + formula(lane, time - h)
        bend = (sides - 2.0 * formula(lane, time)) / h**2
        assert found == pytest.approx(bend, abs=0.4 * (h**2 * w**4 / 12.0 + 4e-16 / h**2))
    outside = motions.acceleration(np.array([START[lane] - 1e-6, motions.stop[lane]]), lane)
    assert outside == pytest.approx([0.0, 0.0])


@pytest.mark.parametrize("control", Control)
def test_no_pulse_starts_or_stops_with_a_velocity_step(control: Control) -> None:
    motions = pulses(control)
    assert not np.any(motions.velocity_step_start)
    assert not np.any(motions.velocity_step_stop)
    for lane in range(4):
        # Gauss-Legendre over a pulse of at most 5 fast cycles: exact to round-off.
        x, weight = np.polynomial.legendre.leggauss(60)
        half = 0.5 * (motions.stop[lane] - START[lane])
        gained = half * weight @ motions.acceleration(START[lane] + half * (1.0 + x), lane)
        assert motions.velocity_final[lane] == pytest.approx(gained, abs=1e-12)
        if control is not Control.ACCELERATION:
            assert motions.velocity_final[lane] == 0.0


@pytest.mark.parametrize("control", Control)
def test_the_peak_is_that_of_a_thousand_looks_a_period(control: Control) -> None:
    cycles, phase = (
        np.array(part)
        for part in zip(
            *itertools.product([1.001, 1.2, 1.5, 2.0, 4.0], np.linspace(-np.pi, np.pi, 9)),
            strict=True,
        )
    )
    count = len(cycles)
    motions = mavroeidis_papageorgiou_motions(
        *([control] * count, np.full(count, -0.7), np.full(count, 2.0), np.zeros(count)),
        cycles=cycles,
        phase=phase,
    )
    found = modulated_peak_acceleration(motions)
    for lane in range(count):
        time = np.linspace(0.0, motions.stop[lane], round(1000 * cycles[lane]))
        seen = np.max(np.abs(motions.acceleration(time, lane)))
        # A look is at most half a thousandth of a period away: (2 pi 1.5 / 2000)^2 / 2.
        assert seen <= found[lane] * (1.0 + 1e-12)
        assert seen == pytest.approx(found[lane], rel=2e-5)


def blocks_and_pulses() -> tuple[ModulatedMotions, SampleTimes]:
    lanes = 4
    motions = mavroeidis_papageorgiou_motions(
        [Control.VELOCITY, Control.ACCELERATION, Control.DISPLACEMENT, Control.VELOCITY],
        np.array([0.45, 0.34 * GRAVITY, 0.03, 0.3]),
        np.array([1.0, 1.5, 2.0, 1.6]),
        np.array([0.0, 0.2, 0.1, 0.3]),
        cycles=np.array([1.2, 2.0, 2.5, 3.5]),
        phase=np.array([0.0, 1.0, np.pi / 2, -2.0]),
    )
    assert motions.lane_count == lanes
    return motions, SampleTimes(4.0, 0.02)


@pytest.mark.thorough
def test_housner_follows_the_oracle() -> None:
    motions, times = blocks_and_pulses()
    lanes = make_lanes(np.full(4, 0.3), 1.5, friction=10.0)
    found = run_batch("housner", lanes, motions, times)
    assert np.all(found["status"] == Status.OK)
    assert np.all(found["peak_rotation"] > 0.02 * lanes.slenderness_angle)
    reference = oracle_response(lanes, motions, times)
    gap = np.abs(found["rotation"] - reference["rotation"]) / lanes.slenderness_angle[:, None]
    # The oracle's tolerance of 1e-12 grows over up to ten impacts.
    assert np.max(gap) < 1e-9


@pytest.mark.thorough
def test_a_stepped_engine_follows_the_velocity_of_the_base() -> None:
    motions, times = blocks_and_pulses()
    lanes = make_lanes(np.full(4, 0.3), 1.5, friction=10.0)
    right = run_batch("housner", lanes, motions, times)["rotation"]
    errors = []
    for substeps in (20, 200):
        settings = ImpulseSettings(substeps=substeps)
        found = run_batch("impulse", lanes, motions, times, settings=settings)["rotation"]
        gap = np.abs(found - right) / lanes.slenderness_angle[:, None]
        errors.append(float(np.mean(np.max(gap, axis=1))))
    # First order: a tenth of the step, a tenth of the error, to within a factor of two.
    coarse, fine = errors
    assert fine < coarse / 5.0 < 1e-2


CASE = """
title = "pulse"
source = "test"
[block]
width = "0.3 m"
height = "1.5 m"
depth = "0.5 m"
density = "2000 kg/m^3"
[contact]
friction = 1.0
[run]
duration = "5 s"
[motion]
waveform = "mavroeidis-papageorgiou"
control = "velocity"
frequency = "1 Hz"
"""


def expanded(folder: pathlib.Path, more: str):
    file = folder / "case.toml"
    file.write_text(CASE + more, encoding="utf-8")
    return expand_lanes(load_case(str(file)))


def test_a_case_sweeps_cycles_and_phase(tmp_path: pathlib.Path) -> None:
    more = 'amplitude = "40 cm/s"\ncycles = 2.0\n[[sweep]]\nmotion.cycles = [1.5, 3.0]\n'
    lane_set = expanded(tmp_path, more + '[[sweep]]\nmotion.phase = ["0 deg", "90 deg"]\n')
    inputs = lane_set.inputs
    assert list(inputs["cycles"]) == [1.5, 1.5, 3.0, 3.0]
    assert list(inputs["phase_rad"]) == pytest.approx([0.0, np.pi / 2] * 2)
    assert list(inputs["stop_s"]) == pytest.approx([1.5, 1.5, 3.0, 3.0])
    assert isinstance(lane_set.motions, ModulatedMotions)
    assert np.all(inputs["peak_acceleration_m_s2"] > 0.4 * 2.0 * np.pi * 0.5)


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ('amplitude = "40 cm/s"\n', "motion.cycles: got nothing"),
        ('amplitude = "40 cm/s"\ncycles = 1.0\n', "motion.cycles: got 1, must be above 1"),
        ('amplitude = "40 cm"\ncycles = 2.0\n', "motion.amplitude: got 0.4 m, must be of the kind"),
        ('amplitude = "1 m/s"\ncycles = 2.0\nphase = 1.0\n', "motion.phase: got 1.0"),
        ('amplitude = "1 m/s"\ncycles = 2.0\nphase = "400 deg"\n', "motion.phase: got '400 deg'"),
        ('amplitude = "1 m/s"\ncycles = 2.0\nduration = "1 s"\n', "motion.duration"),
    ],
)
def test_a_case_that_is_none_is_refused(tmp_path: pathlib.Path, more: str, said: str) -> None:
    with pytest.raises(InputError) as caught:
        expanded(tmp_path, more)
    assert said in str(caught.value)
