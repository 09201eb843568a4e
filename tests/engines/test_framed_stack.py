"""Stacks in engines that step in frames, `impulse`, `direct` and `xpbd`: what each keeps."""

from __future__ import annotations

import dataclasses
import time
from typing import Any

import numpy as np
import pytest

from tests.shared.blocks import (
    at_rest,
    every_height_of_stack,
    free_lanes,
    make_lanes,
    make_stacks,
    sines,
    velocity_steps,
)
from tests.shared.marks import first
from tests.shared.pairs import follow_by_oracle, potential_energy, random_pairs, shaken_threes
from tests.shared.speed import require_gain
from warprock.engines.launching import Form
from warprock.model.lanes import Lanes, as_stacks
from warprock.model.motion import Control, GroundMotions, HarmonicMotions
from warprock.model.response import LANE_FIELDS, Outcome, Response, SampleTimes, Status
from warprock.running.batch import run_batch
from warprock.running.machine import cpu_vector_flags
from warprock.settings.engines import SETTINGS
from warprock.units import GRAVITY

"""Its kernels of stacks take the longest to compile."""
every_engine = pytest.mark.parametrize("engine", first(1, ["impulse", "xpbd", "direct"]))
TIMES = SampleTimes(1.2, 0.1)


def run(
    engine: str, lanes: Lanes, motions: GroundMotions, times: SampleTimes, **settings: Any
) -> Response:
    """A run in which no lane fails."""
    response = run_batch(engine, lanes, motions, times, settings=SETTINGS[engine](**settings))
    assert np.all(response["status"] == Status.OK)
    return response


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("engine", "settings", "apart", "energy"),
    [
        # The starts differ by what the sweeps leave, 0.36^10 of a step's fall.
        ("impulse", {}, 1e-8, 1e-4),
        # One law, two solvers and two ways to write the geometry: round-off, magnified by impacts.
        ("direct", {}, 1e-9, 1e-5),
        ("direct", {"friction_box": 1}, 1e-9, 1e-5),
        ("xpbd", {}, 0.0, 0.0),
    ],
)
def test_a_stack_of_one_is_the_single_block(
    engine: str, settings: dict[str, Any], apart: float, energy: float
) -> None:
    single, times = free_lanes(), SampleTimes(2.0, 0.01)
    one, other = (
        run(engine, lanes, at_rest(9), times, **settings) for lanes in (single, as_stacks(single))
    )
    np.testing.assert_allclose(other["rotation"][:, 0], one["rotation"], rtol=0.0, atol=apart)
    np.testing.assert_array_equal(other["outcome"], one["outcome"])
    np.testing.assert_array_equal(other["impact_count"], one["impact_count"])
    np.testing.assert_allclose(other["peak_slide"][:, 0], one["peak_slide"], rtol=0.0, atol=apart)
    np.testing.assert_allclose(other["energy_lost"], one["energy_lost"], rtol=energy)


@pytest.mark.parametrize(
    ("engine", "count", "coarse", "fine"),
    [
        ("impulse", 8, 5e-4, 6e-5),
        pytest.param("direct", 12, 3e-4, 3e-5, marks=pytest.mark.thorough),
        pytest.param("xpbd", 12, 3e-4, 4e-5, marks=pytest.mark.thorough),
    ],
)
def test_free_pairs_converge_to_the_oracle_at_first_order(
    engine: str, count: int, coarse: float, fine: float
) -> None:
    lanes, motions, times = random_pairs(count), at_rest(count), SampleTimes(0.5, 0.01)
    expected = follow_by_oracle(lanes, motions, times)
    substeps = np.array([6, 20, 63, 200])
    errors = []
    for each in substeps:
        response = run(engine, lanes, motions, times, substeps=int(each))
        errors.append(np.abs(response["rotation"] - expected).max(axis=(1, 2)))
    # Each impact falls somewhere inside its step, and some stacks magnify that; the geometric mean
    # over all of them shows the order.
    typical = np.exp(np.log(errors).mean(axis=1))
    slope = np.polyfit(np.log(1.0 / (substeps + 1.0)), np.log(typical), 1)[0]
    assert 0.8 <= slope <= (1.3 if engine == "direct" else 1.2)
    assert typical[1] <= coarse
    assert typical[3] <= fine


@every_engine
def test_driven_pairs_follow_the_oracle(engine: str) -> None:
    size = np.array([0.35, 0.4, 0.45, 0.5]) * GRAVITY
    lanes = make_stacks(np.tile([0.2, 0.15], (4, 1)), 0.6, density=[1068.0, 1468.5])
    motions = sines(Control.ACCELERATION, size, np.array([4.0, 4.0, 5.0, 5.0]), 1.0)
    times = SampleTimes(0.6, 0.01)
    expected = follow_by_oracle(lanes, motions, times)
    assert np.all(np.abs(expected).max(axis=2) > 2e-3)
    coarse, fine = (
        np.abs(run(engine, lanes, motions, times, substeps=n)["rotation"] - expected).max(
            axis=(1, 2)
        )
        for n in (20, 200)
    )
    assert np.mean(coarse) <= 2e-3
    # A tenth of the step, a tenth of the error.
    assert np.mean(fine) <= np.mean(coarse) / 5.0


@every_height_of_stack
@pytest.mark.parametrize(
    ("engine", "settings", "still"),
    [
        ("impulse", {}, 1e-9),
        # Sunk into its springs by its weight from the start, it does not move.
        *(
            pytest.param(
                "direct",
                {"contact_stiffness": stiffness, "contact_damping": 5e-3 * stiffness},
                1e-12,
                marks=pytest.mark.thorough,
            )
            for stiffness in (1e15, 1e8)
        ),
        pytest.param("xpbd", {}, 1e-11, marks=pytest.mark.thorough),
    ],
)
def test_a_stack_that_nothing_lifts_rests(
    engine: str, settings: dict[str, float], still: float, count: int
) -> None:
    lanes = make_stacks(np.full((3, count), 0.5), np.array([[0.25], [0.5], [1.0]]))
    response = run(engine, lanes, at_rest(3), SampleTimes(60.0), substeps=1, **settings)
    assert np.all(response["peak_rotation"] < still)
    assert np.all(response["peak_slide"] < still)
    assert np.all(response["outcome"] == Outcome.AT_REST)
    assert np.all(np.isnan(response["uplift_time"]))
    assert np.all(response["impact_count"] == 0)
    if engine == "direct":
        # Round-off, 1e-16, of the work of the weight in each of 30,000 steps, 1e2 J.
        assert np.all(np.abs(response["energy_lost"]) < 3e-8 * count)


def energy_bounds(engine: str, step: float) -> tuple[float, float]:
    """What an engine may win, and lack at rest, of the energy at the start, at a time step [s].

    `impulse`: three hundred times the step is what penetrations give back until the rest; a
    thousandth of it what a swing without impacts wins. `direct`: a swing without impacts wins a
    part of what it has; what rests has lost all but what one step of falling makes. `xpbd`: what an
    interval without impacts wins is that of a second-order step, (p dt)^2; rests have a velocity of
    half a step.
    """
    return {
        "impulse": (6.0 * step, 300.0 * step),
        "direct": (6.0 * step, 0.1 * step),
        "xpbd": ((5.0 * step) ** 2, 2e-2 * step),
    }[engine]


@pytest.mark.thorough
@every_engine
def test_energy_is_lost_and_never_won(engine: str) -> None:
    lanes = random_pairs(12)
    held = potential_energy(lanes)
    for substeps in (20, 40):
        lost = [np.zeros(12)]
        for duration in (0.05, 0.1, 0.2, 0.4, 4.0):
            response = run(engine, lanes, at_rest(12), SampleTimes(duration), substeps=substeps)
            lost.append(response["energy_lost"] / held)
        won, lacks = energy_bounds(engine, SETTINGS[engine](substeps=substeps).time_step)
        assert np.min(np.diff(lost, axis=0)) >= -won
        still = response["outcome"] == Outcome.AT_REST
        assert np.count_nonzero(still) >= 4
        assert np.all(np.abs(lost[-1][still] - 1.0) <= lacks)


@pytest.mark.parametrize("engine", first(1, ["impulse", "xpbd"]))
def test_slides_add_up_to_the_closed_form(engine: str) -> None:
    # Under a velocity step v a face of friction mu slides v^2 / (2 mu g) in all: of the ground
    # where it is the smoothest, else of the ground and of the interface together.
    friction = np.array([[0.5, 0.05], [0.5, 0.1], [0.1, 0.5], [0.5, 0.2]])
    speed = np.array([0.3, -0.2, 0.3, 0.4])
    lanes = make_stacks(1.0, 0.5, friction=friction)
    motions = velocity_steps(speed, np.zeros(4), np.full(4, 10.0))
    slides = []
    for substeps in (20, 200):
        response = run(engine, lanes, motions, SampleTimes(1.2), substeps=substeps)
        slide = response["residual_slide"]
        expected = -np.sign(speed) * speed**2 / (2.0 * friction.min(axis=1) * GRAVITY)
        # First order: each of the two faces may stick a step late, at |v| dt.
        step = SETTINGS[engine](substeps=substeps).time_step
        assert np.all(np.abs(slide.sum(axis=1) - expected) <= 2.0 * np.abs(speed) * step)
        assert np.all(response["outcome"] == Outcome.AT_REST)
        slides.append(slide)
    # On the rougher ground the lower block is braked by mu_1 (m_1 + m_2) and driven by mu_2 m_2.
    braking = (2.0 * friction[:, 0] - friction[:, 1]) * GRAVITY
    lower = -np.sign(speed) * speed**2 / (2.0 * braking)
    rough = friction[:, 0] > friction[:, 1]
    np.testing.assert_allclose(slides[1][rough, 0], lower[rough], rtol=2e-3)
    np.testing.assert_allclose(slides[1][~rough, 1], 0.0, atol=1e-9)


@pytest.mark.parametrize("engine", first(1, ["impulse", "xpbd"]))
def test_a_fast_base_takes_the_lower_block_away(engine: str) -> None:
    # The upper block, left behind by nearly the whole of the step in velocity, has no overlap left
    # once it has slid over one width; it falls off when its centre has lost its support.
    speed = np.array([3.0, -3.0])
    lanes = make_stacks(np.full((2, 2), 0.5), 0.25, friction=[0.6, 0.02])
    motions = velocity_steps(speed, np.zeros(2), np.full(2, 10.0))
    response = run(engine, lanes, motions, SampleTimes(2.0, 0.05))
    assert np.all(response["outcome"] == Outcome.SLID_OFF)
    slide = response["peak_slide"][:, 1]
    assert np.all((slide > 0.5) & (slide < 0.502))
    # The run ends there, and the rotations stay.
    assert np.all(response["step_count"] < 2.0 / SETTINGS[engine]().time_step)
    assert np.all(response["rotation"][:, :, -1] == response["rotation"][:, :, -2])


def batch_of(engine: str) -> tuple[Lanes, HarmonicMotions]:
    """Many stacks that differ: of `direct` pairs, whose kernel takes the shortest to compile."""
    return (random_pairs(75), at_rest(75)) if engine == "direct" else shaken_threes()


@pytest.mark.thorough
@pytest.mark.parametrize("engine", ["impulse", "direct", "xpbd"])
def test_a_stack_depends_on_no_other(engine: str, unjudged: None) -> None:
    lanes, motions = batch_of(engine)
    whole = run_batch(engine, lanes, motions, TIMES, workers=1, chunk_size=75)
    assert whole["rotation"].shape == (75, lanes.block_count, len(TIMES.times))
    order = np.random.default_rng(0).permutation(75)
    height = lanes.height.copy()
    height[5, 1] = np.nan
    broken = dataclasses.replace(lanes, height=height)
    others = order != 5
    for chunk_size in (32, 7):
        shuffled = broken.take(order), motions.take(order)
        response = run_batch(engine, *shuffled, TIMES, workers=2, chunk_size=chunk_size)
        assert response["status"][order == 5] == Status.NONFINITE
        for name in (*LANE_FIELDS, "rotation"):
            np.testing.assert_array_equal(
                response[name][others], whole[name][order][others], err_msg=name
            )


@pytest.mark.thorough
@pytest.mark.parametrize("engine", ["impulse", "direct", "xpbd"])
def test_a_mirrored_stack_responds_mirrored(engine: str) -> None:
    lanes, motions = batch_of(engine)
    mirrored = dataclasses.replace(
        lanes, rotation_start=-lanes.rotation_start, offset=-lanes.offset
    )
    there = run_batch(engine, lanes, motions, TIMES)
    response = run_batch(engine, mirrored, motions.scaled(-np.ones(75)), TIMES)
    if engine != "direct":
        assert set(np.unique(there["outcome"])) >= {0, 1, Outcome.OVERTURNED}
    np.testing.assert_array_equal(there["rotation"], -response["rotation"])
    np.testing.assert_array_equal(there["residual_slide"], -response["residual_slide"])
    np.testing.assert_array_equal(there["outcome"], response["outcome"])


def packs_of(blocks: int) -> tuple[Lanes, HarmonicMotions]:
    """Two packs of single blocks, or of stacks of three."""
    lanes, motions = shaken_threes(64)
    return (make_lanes(np.linspace(0.2, 0.4, 64), 1.0) if blocks == 1 else lanes), motions


@pytest.mark.thorough
@pytest.mark.parametrize("engine", ["impulse", "xpbd"])
def test_packed_and_plain_forms_agree(engine: str) -> None:
    lanes, motions = packs_of(3)
    packed = run_batch(engine, lanes, motions, TIMES, form=Form.PACKED, workers=1)
    some = lanes.take(slice(0, 8)), motions.take(slice(0, 8))
    plain = run_batch(engine, *some, TIMES, form=Form.PLAIN, workers=1)
    for name, values in plain.fields.items():
        np.testing.assert_array_equal(packed[name][:8], values, err_msg=name)


@pytest.mark.speed
@pytest.mark.parametrize(
    ("engine", "blocks", "narrow"), [("impulse", 3, 1.7), ("xpbd", 1, 2.0), ("xpbd", 3, 2.0)]
)
def test_packed_kernel_is_vectorised(engine: str, blocks: int, narrow: float) -> None:
    lanes, motions = packs_of(blocks)

    def cost(form: Form) -> float:
        part = slice(0, 64 if form is Form.PACKED else 8)
        few, base = lanes.take(part), motions.take(part)
        start = time.process_time()
        response = run_batch(engine, few, base, TIMES, form=form, workers=1)
        return (time.process_time() - start) / float(response["step_count"].sum())

    for form in Form:
        cost(form)
    # A ratio within one run: without vector code the packed form is no faster.
    least = 2.5 if "avx512f" in cpu_vector_flags() else narrow
    require_gain(lambda: cost(Form.PLAIN), lambda: cost(Form.PACKED), least)


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("engine", "most"),
    [
        # float32 has 1.2e-7 of a metre; six impacts and 1500 steps magnify that a hundredfold.
        ("impulse", 1e-3),
        # float32 has 6e-8 of a metre in a gap; over a step of 2e-4 s that is 3e-4 m/s.
        ("xpbd", 5e-3),
    ],
)
def test_single_precision_is_near_double(engine: str, most: float) -> None:
    lanes, times = random_pairs(12), SampleTimes(0.3, 0.01)
    double, single = (
        run_batch(engine, lanes, at_rest(12), times, precision=each)["rotation"]
        for each in ("float64", "float32")
    )
    apart = np.abs(single - double).max(axis=(1, 2))
    assert np.all(apart < most)
    assert np.all(apart > 0.0)
