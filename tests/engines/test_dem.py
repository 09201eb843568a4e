"""`dem`: the paper's DEM column, the rigid limit, energy, strengths, order, and stacks."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from tests.shared.blocks import (
    Array,
    at_rest,
    free_lanes,
    make_lanes,
    make_stacks,
    sines,
    velocity_steps,
)
from tests.shared.speed import require_gain
from warprock.case.lanes import expand_lanes
from warprock.case.load import load_case
from warprock.engines import dem
from warprock.engines.energy import energy_held
from warprock.engines.launching import Form
from warprock.measure import bench
from warprock.model import rocking
from warprock.model.lanes import Lanes
from warprock.model.motion import Control, GroundMotions, StillBase
from warprock.model.response import LANE_FIELDS, Outcome, Response, SampleTimes, Status
from warprock.paper.printed import paper_table
from warprock.running.batch import run_batch
from warprock.running.machine import cpu_vector_flags
from warprock.settings.engines import DemSettings
from warprock.units import GRAVITY

ROUGH = 10.0
"""A friction at which nothing slides."""


def run(
    lanes: Lanes,
    motions: GroundMotions,
    times: SampleTimes,
    settings: DemSettings | None = None,
    engine: str = "dem",
) -> Response:
    """A run in which no lane fails."""
    response = run_batch(engine, lanes, motions, times, settings=settings)
    assert np.all(response["status"] == Status.OK)
    return response


def stiff(lanes: Lanes, stiffness: float, damping_ratio: float) -> DemSettings:
    """Springs at the two ends alone, with the damping ratio of one end under a whole block."""
    area = float(np.min(lanes.width * lanes.depth))
    frequency = np.sqrt(0.5 * stiffness * area / float(np.min(lanes.mass)))
    return DemSettings(
        normal_stiffness=stiffness,
        shear_stiffness=stiffness,
        subcontacts=2,
        stiffness_damping=2.0 * damping_ratio / frequency,
        step_safety=0.5,
    )


def test_table_6_is_within_three_per_cent_of_the_papers_dem() -> None:
    # Nothing is fitted: the springs are those of Table 5, the base follows the displacement.
    pulse = expand_lanes(load_case("single-sine-pulse"))
    lanes, motions = pulse.lanes.take(slice(0, 6)), pulse.motions.take(slice(0, 6))
    printed = paper_table("table6")["dem"].to_numpy(dtype=float)
    peaks = []
    for safety in (DemSettings().step_safety, 0.02):
        response = run(lanes, motions, SampleTimes(2.0), DemSettings(step_safety=safety))
        peaks.append(response["peak_rotation"] / lanes.slenderness_angle)
        np.testing.assert_allclose(peaks[-1], printed, rtol=0.03)
    # The default step is worth 0.3 % of the peaks.
    np.testing.assert_allclose(peaks[0], peaks[1], rtol=3e-3)


@pytest.mark.thorough
def test_stiff_springs_at_the_ends_converge_to_housner() -> None:
    lanes, times = free_lanes(), SampleTimes(1.0, 0.01)
    reference = run(lanes, StillBase(9), times, engine="housner")
    found = []
    for stiffness in (1e9, 1e10, 1e11):
        response = run(lanes, at_rest(9), times, stiff(lanes, stiffness, 10.0))
        gap = np.abs(response["rotation"] - reference["rotation"]).max(axis=1)
        found.append(np.max(gap / lanes.slenderness_angle))
    # The springs give by mg / k, so ten times the stiffness is a tenth of the difference.
    assert found[0] <= 1e-2
    assert found[1] <= found[0] / 5.0
    assert found[2] <= found[1] / 3.0


@pytest.mark.thorough
def test_springs_inside_the_face_keep_more_than_housner() -> None:
    # A rigid face that meets a rigid base has no unique impact. Points at the two ends alone give
    # Housner's; points in between take part of the blow, and the block turns on faster.
    lanes = make_lanes(0.5, 1.0, 0.5, friction=ROUGH)
    ends = stiff(lanes, 1e11, 10.0)
    found = [
        float(dem.equivalent_restitution(lanes, dataclasses.replace(ends, subcontacts=n))[0])
        for n in (2, 3, 5)
    ]
    assert found[0] == pytest.approx(float(rocking.angular_restitution(np.arctan(0.5))), abs=1e-3)
    assert found[0] + 0.03 < found[1] < found[2] - 0.01
    assert found[2] < 0.85


def test_energy_is_lost_and_never_won() -> None:
    lanes = free_lanes()
    held = energy_held(lanes, lanes.rotation_start)
    for settings in (DemSettings(stiffness_damping=0.0), DemSettings(step_safety=0.8)):
        early = run(lanes, StillBase(9), SampleTimes(1.0), settings)["energy_lost"]
        late = run(lanes, StillBase(9), SampleTimes(4.0), settings)["energy_lost"]
        # Without dashpots a block slips and opens loaded shear springs; no step wins anything,
        # but for (w dt)^2 / 24 of the energy that swings in the springs.
        assert np.all(early >= -1e-3 * held)
        assert np.all(late >= early - 1e-3 * held)
        assert np.all(late <= held * (1.0 + 1e-3))


def test_energy_of_a_block_that_comes_to_rest_is_all_lost() -> None:
    lanes = make_lanes(np.full(2, 0.5), np.array([0.75, 1.0]), 0.3)
    settings = DemSettings(stiffness_damping=2e-3, normal_stiffness=1e10, shear_stiffness=1e10)
    response = run(lanes, StillBase(2), SampleTimes(6.0), settings)
    held = energy_held(lanes, lanes.rotation_start)
    assert np.all(response["outcome"] == Outcome.AT_REST)
    # Released and resting blocks settle by some mg / k, 1e-6 m to 1e-5 m of the lift of 4 cm.
    np.testing.assert_allclose(response["energy_lost"], held, rtol=1e-3)


@pytest.mark.parametrize(
    ("subcontacts", "count"),
    [
        (5, 2),
        pytest.param(2, 3, marks=pytest.mark.thorough),
    ],
)
def test_resting_stack_stays(subcontacts: int, count: int) -> None:
    lanes = make_stacks(
        np.array([[0.5, 0.4, 0.3], [0.3, 0.5, 0.3], [0.4, 0.4, 0.4]])[:, :count],
        0.6,
        offset=np.array([[0.0, 0.02, -0.01], [0.0, 0.05, 0.1], [0.0, 0.0, 0.0]])[:, :count],
        friction=1.0,
    )
    settings = DemSettings(subcontacts=subcontacts)
    response = run(lanes, at_rest(3), SampleTimes(10.0, 0.5), settings)
    moved = np.abs(response["rotation"] - response["rotation"][:, :, :1]).max(axis=2)
    assert np.all(moved * lanes.width <= 1e-9)
    assert np.all(response["peak_slide"] <= 1e-9)
    assert np.all(response["outcome"] == Outcome.AT_REST)
    assert np.all(response["impact_count"] == 0)
    # Eccentric blocks lean on their springs, the centred ones of the last stack do not.
    assert np.all(np.abs(response["rotation"][:2, :, 0]) > 1e-7)
    assert np.all(response["rotation"][2] == 0.0)


def test_block_parts_and_rocks_from_below_the_rigid_threshold() -> None:
    ratio = np.linspace(0.7, 1.1, 41)
    lanes = make_lanes(np.full(41, 0.2), 1.0)
    limit = rocking.uplift_acceleration(0.2, 1.0)
    motions = sines(Control.ACCELERATION, ratio * limit, 0.5, 0.5)
    times = SampleTimes(1.5)
    parts, rocks = [], []
    for subcontacts, stiffness in ((2, 1e10), (5, 1e10), (5, 1e9), (5, 1e11)):
        # Damped so that a resting block follows the base without ringing.
        settings = DemSettings(
            normal_stiffness=stiffness,
            shear_stiffness=stiffness,
            subcontacts=subcontacts,
            stiffness_damping=1.0 / np.sqrt(stiffness / 2000.0),
            step_safety=0.5,
        )
        response = run(lanes, motions, times, settings)
        parts.append(np.min(ratio[np.isfinite(response["uplift_time"])]))
        rocks.append(np.min(ratio[response["peak_rotation"] > 1.5e-3]))
    # The block has parted once the last spring at one end, of two or of five, carries all: where a
    # rigid one lifts. Ratios are 0.01 apart.
    assert parts[0] == pytest.approx(1.0, abs=0.0201)
    assert parts[1] == parts[3] == pytest.approx(1.0, abs=0.0201)
    # Soft springs let it lean before it lifts.
    assert 0.9 < parts[2] < parts[1]
    # It rocks from the rigid threshold on, softer springs from below it.
    assert rocks[2] < rocks[1] <= rocks[3] <= 1.04
    assert rocks[2] < 0.99
    assert rocks[3] > 0.98


def test_block_slides_by_the_closed_form() -> None:
    # Under a velocity step v a block slides v^2 / (2 mu g). Dilation lifts it on its way and takes
    # that out of what friction loses.
    friction = np.array([0.05, 0.1, 0.2])
    speed = np.array([0.3, -0.2, 0.4])
    lanes = make_lanes(np.full(3, 1.0), 1.0, friction=friction)
    motions = velocity_steps(speed, np.zeros(3), np.full(3, 10.0))
    for angle in (0.0, 0.03):
        settings = DemSettings(dilatancy=angle, stiffness_damping=2e-3)
        response = run(lanes, motions, SampleTimes(2.0), settings)
        # The springs carry the block back by mu m g / k and it rings on them for a while: 1 %.
        slide = -np.sign(speed) * speed**2 / (2.0 * GRAVITY * friction)
        np.testing.assert_allclose(response["residual_slide"], slide, rtol=0.01)
        lost = 0.5 * lanes.mass * speed**2 * (1.0 - np.tan(angle) / friction)
        np.testing.assert_allclose(response["energy_lost"], lost, rtol=0.02)


def test_mass_damping_slows_a_block_without_friction() -> None:
    lanes = make_lanes(1.0, 1.0, friction=0.0)
    motions = velocity_steps(np.array([0.2]), np.zeros(1), np.full(1, 10.0))
    response = run(lanes, motions, SampleTimes(1.0), DemSettings(mass_damping=3.0))
    # v / alpha (1 - exp(-alpha t)), within half a step of the explicit drag.
    assert response["residual_slide"][0] == pytest.approx(-0.2 / 3.0 * (1 - np.exp(-3)), rel=2e-3)


def test_tension_and_cohesion_hold_up_to_their_strength() -> None:
    # Slow pulses. Bonded springs stay linear: the end of five bears W / A - M b / (3/8 A b^2). They
    # hold more than twice of what lifts the block without them, which therefore parts as they fail.
    factor = np.array([0.95, 1.05])
    lanes = make_lanes(np.full(2, 0.2), 1.0)
    area, weight = 0.2 * 0.5, float(lanes.mass[0]) * GRAVITY
    strength = 1e5
    limit = (strength * area + weight) * 0.375 * 0.1 / (lanes.mass[0] * 0.5)
    assert limit > 2.0 * rocking.uplift_acceleration(0.2, 1.0)
    motions = sines(Control.ACCELERATION, factor * limit, 1.0, 0.5)
    settings = DemSettings(tensile_strength=strength, cohesion=1e6, stiffness_damping=1e-3)
    response = run(lanes, motions, SampleTimes(1.0), settings)
    np.testing.assert_array_equal(np.isfinite(response["uplift_time"]), [False, True])

    # The shear stress is m a / A everywhere until it reaches c.
    lanes = make_lanes(np.full(2, 1.0), 1.0, friction=0.0)
    limit = 2e3 * 0.5 / lanes.mass[0]
    motions = sines(Control.ACCELERATION, factor * limit, 1.0, 0.5)
    settings = DemSettings(cohesion=2e3, stiffness_damping=1e-3)
    response = run(lanes, motions, SampleTimes(1.0), settings)
    # c / k_s = 2e-6 m; once cohesion has gone, nothing keeps the block from sliding by centimetres.
    assert response["peak_slide"][0] < 1e-5
    assert response["peak_slide"][1] > 1e-2


def test_error_is_of_first_order_in_the_step() -> None:
    lanes, times = free_lanes(), SampleTimes(0.8, 0.01)

    def rotation(safety: float) -> Array:
        settings = DemSettings(step_safety=safety, time_step=0.1)
        return np.asarray(run(lanes, StillBase(9), times, settings)["rotation"])

    safety = np.array([0.8, 0.4, 0.2, 0.1, 0.05, 0.025])
    exact = rotation(0.003)
    # Lanes differ a thousandfold in how often their springs have opened: a mean of logarithms.
    error = [
        np.mean(np.log(np.abs(rotation(value) - exact).max(axis=1) + 1e-12)) for value in safety
    ]
    slope = np.polyfit(np.log(safety), error, 1)[0]
    assert 0.75 <= slope <= 1.3


def test_unlike_lanes_keep_their_own_steps(unjudged: None) -> None:
    # A pack with steps that differ tenfold, stacks of two that rock, slide and fall, and a lane
    # that is no number: each lane gives what it gives alone.
    k = np.arange(40)
    width = np.stack([0.1 + 0.02 * k, 0.08 + 0.02 * k], axis=1)
    lanes = make_stacks(width, 0.6, rotation=np.where(k % 3 == 0, 0.05, 0.0)[:, None] * [1.0, 1.0])
    lanes.friction[:, 1] = np.where(k % 4 == 1, 0.2, 1.0)
    motions = sines(Control.DISPLACEMENT, 0.004 + 0.0004 * k, 2.0 + 0.04 * k, cycles=1.5)
    times = SampleTimes(0.8, 0.1)
    whole = run_batch("dem", lanes, motions, times, workers=1, chunk_size=40)
    assert len(np.unique(whole["step_count"])) > 10
    assert len(np.unique(whole["outcome"])) >= 2
    apart = run_batch("dem", lanes, motions, times, workers=2, chunk_size=7)
    lanes.height[5, 1] = np.nan
    broken = run_batch("dem", lanes, motions, times, workers=1, chunk_size=40)
    assert broken["status"][5] == Status.NONFINITE
    others = k != 5
    for name in (*LANE_FIELDS, "rotation"):
        np.testing.assert_array_equal(whole[name], apart[name], err_msg=name)
        np.testing.assert_array_equal(whole[name][others], broken[name][others], err_msg=name)


def test_mirrored_stack_gives_mirrored_response() -> None:
    lanes = make_stacks(
        np.array([[0.4, 0.3], [0.3, 0.4], [0.3, 0.3]]),
        0.6,
        rotation=np.array([[0.1, 0.15], [0.0, 0.1], [0.0, 0.0]]),
        offset=np.array([[0.0, 0.02], [0.0, -0.03], [0.0, 0.05]]),
        friction=0.5,
    )
    motions = sines(Control.ACCELERATION, np.full(3, 3.0), 2.0, cycles=2.0)
    times = SampleTimes(1.0, 0.05)
    there = run(lanes, motions, times)
    mirrored = dataclasses.replace(
        lanes, rotation_start=-lanes.rotation_start, offset=-lanes.offset
    )
    back = run(mirrored, sines(Control.ACCELERATION, np.full(3, -3.0), 2.0, cycles=2.0), times)
    np.testing.assert_array_equal(there["rotation"], -back["rotation"])
    np.testing.assert_array_equal(there["residual_slide"], -back["residual_slide"])


@pytest.mark.thorough
def test_stiff_stack_of_two_follows_two_block() -> None:
    # A lower block alone in motion below a glued one, and an upper one alone, wider and narrower.
    lanes = make_stacks(
        np.array([[0.3, 0.3], [0.3, 0.4], [0.4, 0.2]]),
        0.6,
        rotation=np.array([[0.1, 0.1], [0.0, 0.15], [0.0, 0.1]]),
    )
    times = SampleTimes(0.8, 0.01)
    reference = run(lanes, at_rest(3), times, engine="two-block")
    found = []
    for stiffness in (1e9, 1e10, 1e11):
        response = run(lanes, at_rest(3), times, stiff(lanes, stiffness, 10.0))
        found.append(np.abs(response["rotation"] - reference["rotation"]).max())
    assert np.abs(reference["rotation"]).max() >= 0.1
    assert found[0] <= 1e-2
    assert found[1] <= found[0] / 3.0
    assert found[2] <= 5e-4


def test_blocks_slide_off_and_topple() -> None:
    # The base leaves at 1 m/s below a slippery upper block; another one stands beside its edge.
    lanes = make_stacks(
        np.full((2, 2), 0.4),
        0.6,
        offset=np.array([[0.0, 0.0], [0.0, 0.25]]),
        friction=np.array([[ROUGH, 0.02], [ROUGH, ROUGH]]),
    )
    motions = velocity_steps(np.array([-1.0, 0.0]), np.zeros(2), np.full(2, 10.0))
    response = run(lanes, motions, SampleTimes(2.0))
    np.testing.assert_array_equal(response["outcome"], [Outcome.SLID_OFF, Outcome.OVERTURNED])
    assert 0.3 < response["peak_slide"][0, 1] < 0.45
    assert response["peak_rotation"][1, 1] == pytest.approx(0.5 * np.pi)


def test_centre_of_a_block_without_friction_falls_straight_down() -> None:
    lanes = make_lanes(np.full(2, 0.3), 1.0, np.array([0.5, -0.9]), friction=0.0)
    response = run(lanes, StillBase(2), SampleTimes(0.5, 0.5))
    turn, start = response["rotation"][:, -1], lanes.rotation_start
    side, first = np.sign(turn), np.sign(start)
    moved = response["residual_slide"] - side * 0.15 * (np.cos(turn) - 1.0) + 0.5 * np.sin(turn)
    begun = -first * 0.15 * (np.cos(start) - 1.0) + 0.5 * np.sin(start)
    assert np.all(np.abs(turn - start) > 0.09)
    # The slide is a step older than the last sample.
    np.testing.assert_allclose(moved, begun, atol=0.5 * 3.0 * 5e-4)


@pytest.mark.speed
def test_packed_kernel_is_vectorised() -> None:
    # A ratio within one run: without vector code the packed form is no faster than the plain one.
    expected = 2.5 if any(flag.startswith("avx512f") for flag in cpu_vector_flags()) else 1.8

    def cost(form: Form) -> float:
        measured = bench.measure("dem", 0.5, form=form)
        return measured.cpu_s_per_simulated_s

    require_gain(lambda: cost(Form.PLAIN), lambda: cost(Form.PACKED), expected)
