"""Moments, multipliers and work of blocks that are led outwards: closed forms, and dynamics."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad

import warprock as wr
from warprock.model.lanes import Lanes
from warprock.model.statics import capacity, curve, leaning

WIDTH, HEIGHT = 0.6, 4.8
WEIGHT = 56505.6
"""Of a wall 1 m long, 2,000 kg/m^3 [N]."""
ANGLE, RADIUS = float(np.arctan(WIDTH / HEIGHT)), 0.5 * float(np.hypot(WIDTH, HEIGHT))
BARE = WEIGHT * RADIUS * (1.0 - np.cos(ANGLE))
"""Work that overturns it where nothing holds it [J]."""
ROUND_OFF = 1e-12


def tables(**held: Any) -> dict[str, Any]:
    return {
        "block": {"width": "0.6 m", "height": "4.8 m", "depth": "1 m", "density": "2000 kg/m^3"},
        "contact": {"friction": 5.0},
        "run": {"duration": "60 s"},
        **held,
    }


def lanes(**held: Any) -> Lanes:
    return wr.expand_lanes(wr.Case.from_dict(tables(**held))).lanes


def tie(**keys: Any) -> dict[str, Any]:
    return {"tie": [{"side": "left", "height": "4.5 m", "stiffness": "2 kN/mm", **keys}]}


def test_a_bare_block_has_its_slenderness_as_its_multiplier():
    found = capacity(leaning(lanes(), 1.0))
    assert leaning(lanes(), 1.0).weight[0] == pytest.approx(WEIGHT, rel=ROUND_OFF)
    assert found.multiplier[0] == pytest.approx(WIDTH / HEIGHT, rel=ROUND_OFF)
    assert found.multiplier_peak[0] == pytest.approx(WIDTH / HEIGHT, rel=ROUND_OFF)
    assert found.lean_capacity[0] == pytest.approx(ANGLE, rel=ROUND_OFF)
    assert found.work[0] == pytest.approx(BARE, rel=ROUND_OFF)
    # The centre of percussion of a rectangle lies 4/3 R from its edge: 2/3 of the width along x.
    assert found.displacement_capacity[0] == pytest.approx(2.0 / 3.0 * WIDTH, rel=ROUND_OFF)
    # (I / 2) (m R cos(a) v / I)^2 = work, with I = (4/3) m R^2.
    step = np.sqrt(8.0 / 3.0 * 9.81 * RADIUS * (1.0 - np.cos(ANGLE))) / np.cos(ANGLE)
    assert found.velocity_step[0] == pytest.approx(step, rel=ROUND_OFF)


@pytest.mark.parametrize(("stiffness", "sign"), [("5800 N/m", -1.0), ("5972 N/m", 1.0)])
def test_a_spring_at_the_top_makes_the_stiffness_positive_from_its_critical_value(stiffness, sign):
    """k = W h / d^2, h half the height and d that of the spring: 5,886 N/m."""
    critical = WEIGHT * 0.5 * HEIGHT / HEIGHT**2
    assert critical == pytest.approx(5886.0, rel=ROUND_OFF)
    found = curve(leaning(lanes(**tie(height="4.8 m", stiffness=stiffness)), 1.0), 1e-3)
    assert sign * (found.moment[1] - found.moment[0]) > 0.0
    slope = (found.moment[1] - found.moment[0]) / found.lean[1]
    expected = (float(stiffness.split()[0]) - critical) * HEIGHT**2
    # Of the second order in the lean: the spring lifts with w = 1 - cos(lean), too.
    assert slope == pytest.approx(expected, abs=WEIGHT * RADIUS * found.lean[1])


def test_a_tie_adds_the_area_of_its_own_diagram_to_the_work():
    """Slack 2 mm, 12 kN from 6 mm on, broken at 80 mm beyond its slack."""
    held = tie(slack="2 mm", yield_force="12 kN", ultimate_elongation="80 mm")
    found = capacity(leaning(lanes(**held), 1.0))
    of_tie = 0.5 * 12e3 * 6e-3 + 12e3 * 74e-3
    assert found.work[0] == pytest.approx(BARE + of_tie, rel=ROUND_OFF)
    assert found.multiplier[0] == pytest.approx(WIDTH / HEIGHT, rel=ROUND_OFF)
    assert found.lean_capacity[0] == pytest.approx(ANGLE, rel=ROUND_OFF)
    # The tie yields at an elongation of 8 mm: the lean of 4.5 sin + 0.6 (1 - cos) = 8 mm.
    at = found.lean_at_peak[0]
    assert 4.5 * np.sin(at) + 0.6 * (1.0 - np.cos(at)) == pytest.approx(8e-3, rel=1e-9)
    moment = WEIGHT * RADIUS * np.sin(ANGLE - at) + 12e3 * (4.5 * np.cos(at) + 0.6 * np.sin(at))
    arm = WEIGHT * RADIUS * np.cos(ANGLE - at)
    assert found.multiplier_peak[0] == pytest.approx(moment / arm, rel=1e-9)


def test_prestress_holds_a_block_and_may_pull_it_over():
    held = tie(prestress="5 kN", yield_force="6 kN")
    away, towards = (capacity(leaning(lanes(**held), side)) for side in (1.0, -1.0))
    share = 5e3 * 4.5 / (WEIGHT * 0.5 * HEIGHT)
    assert away.multiplier[0] == pytest.approx(WIDTH / HEIGHT + share, rel=ROUND_OFF)
    assert towards.multiplier[0] == pytest.approx(WIDTH / HEIGHT - share, rel=ROUND_OFF)
    assert (towards.multiplier[0], towards.work[0], towards.lean_capacity[0]) < (0.0, 1e-9, 1e-9)


def test_a_spring_that_never_gives_way_has_no_capacity():
    found = capacity(leaning(lanes(**tie()), 1.0))
    assert np.isnan([found.lean_capacity[0], found.work[0], found.velocity_step[0]]).all()


@pytest.mark.parametrize("point", ["moves", "stays"])
def test_a_load_presses_where_it_is(point):
    """Weight N at x from the middle, thrust T: to the right N (b - x) - T 2 h is added at rest."""
    load = {"weight": "20 kN", "eccentricity": "50 mm", "thrust": "1 kN", "point": point}
    found = capacity(leaning(lanes(top_load=load), 1.0))
    moment = WEIGHT * 0.3 + 20e3 * (0.3 - 0.05) - 1e3 * HEIGHT
    assert found.multiplier[0] == pytest.approx(moment / (WEIGHT * 0.5 * HEIGHT), rel=ROUND_OFF)


def test_a_frame_falls_where_its_columns_do():
    found = capacity(leaning(lanes(frame={"columns": 4, "beam_mass": "20000 kg"}), 1.0))
    assert found.multiplier[0] == pytest.approx(WIDTH / HEIGHT, rel=ROUND_OFF)
    # The beam rises twice as far as the centres of the columns.
    moved = 4.0 * WEIGHT + 2.0 * 20000.0 * 9.81
    assert found.work[0] == pytest.approx(BARE * moved / WEIGHT, rel=ROUND_OFF)


HELD = {
    "bare": ({}, 1.0),
    "yields and breaks": (
        tie(slack="2 mm", yield_force="12 kN", ultimate_elongation="80 mm"),
        1.0,
    ),
    "prestress": (tie(stiffness="20 N/mm", prestress="1 kN", yield_force="2 kN"), -1.0),
    "two ties": (
        {
            "tie": [
                *tie(stiffness="0.2 kN/mm", slack="10 mm", yield_force="3 kN")["tie"],
                *tie(
                    side="right",
                    height="3 m",
                    stiffness="0.2 kN/mm",
                    acts="both",
                    yield_force="2 kN",
                    ultimate_elongation="30 mm",
                )["tie"],
            ]
        },
        1.0,
    ),
    "load": ({"top_load": {"weight": "20 kN", "eccentricity": "-0.1 m", "thrust": "1 kN"}}, 1.0),
    "load that stays": (
        {"top_load": {"weight": "20 kN", "eccentricity": "50 mm", "point": "stays"}},
        1.0,
    ),
    "frame": ({"frame": {"columns": 4, "beam_mass": "20000 kg"}}, 1.0),
}


@pytest.mark.parametrize("name", HELD)
def test_the_work_is_what_just_overturns_the_block_of_housner(name: str):
    """A start with the kinetic energy of this work falls, one with 2e-7 less comes back.

    All lean to their weaker side: to the other one what comes back may fall over the weaker.
    """
    held, side = HELD[name]
    boxes = leaning(lanes(**held), side)
    rate = side * float(np.sqrt(2.0 * capacity(boxes).work / boxes.inertia)[0])
    rates = [f"{rate * (1.0 + change):.15g} rad/s" for change in (-1e-7, 1e-7)]
    case = tables(**held, sweep={"start": {"angular_velocity_y": rates}})
    case["start"] = {"angular_velocity_y": "1 rad/s"}
    # A pulse of no size: kernels of pulses are those that other tests compile.
    pulse = {"waveform": "sine", "amplitude": "1e-12 g", "frequency": "1 Hz", "cycles": 1}
    case["motion"] = {"control": "acceleration", **pulse}
    table = wr.run(case, "housner", progress=False).table
    fell = table["outcome"] == "overturned"
    assert fell.tolist() == [False, True]
    # The lean stays below that of balance by the root of the energy that lacks.
    lean = float(capacity(boxes).lean_capacity[0])
    assert table["peak_rotation_rad"].iloc[0] == pytest.approx(lean, rel=2e-3)


@pytest.mark.parametrize("name", HELD)
def test_the_work_is_the_area_below_the_moment(name: str):
    held, side = HELD[name]
    boxes = leaning(lanes(**held), side)
    found = capacity(boxes)
    end = float(found.lean_capacity[0])
    corners = [c for c in boxes.corners()[0] if c < end]

    def moment(lean: float) -> float:
        return float(boxes.moment(np.array([lean]), np.array([lean]))[0])

    parts = zip([0.0, *corners], [*corners, end], strict=True)
    area = sum(quad(moment, low, high, epsabs=1e-9)[0] for low, high in parts)
    assert found.work[0] == pytest.approx(area, rel=1e-9)
    assert found.multiplier_peak[0] >= found.multiplier[0]


def test_a_velocity_step_of_the_base_overturns_as_it_says():
    """A sine displacement sets off with a step of the velocity, and at 2e-3 Hz does little else.

    Its acceleration stays below 1e-4 g while the block comes to its balance.
    """
    held = tie(side="right", yield_force="12 kN", ultimate_elongation="80 mm")
    held |= {"transverse_wall": {"side": "right", "rebound": "plastic"}}
    step = float(capacity(leaning(lanes(**held), -1.0)).velocity_step[0])
    frequency = 2e-3
    motion = {"waveform": "sine", "control": "displacement", "frequency": "2e-3 Hz", "cycles": 1}
    ways = [f"{factor * step / (2.0 * np.pi * frequency):.12g} m" for factor in (0.998, 1.002)]
    case = tables(**held, motion={**motion, "amplitude": "1 m"})
    case |= {"sweep": {"motion": {"amplitude": ways}}, "run": {"duration": "10 s"}}
    table = wr.run(case, "housner", progress=False).table
    assert (table["outcome"] == "overturned").tolist() == [False, True]
