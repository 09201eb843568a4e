"""Single blocks in engines that step in frames, `impulse`, `direct` and `xpbd`: what each keeps."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tests.shared import closed_forms
from tests.shared.blocks import (
    at_rest,
    errors_to_housner,
    free_lanes,
    make_lanes,
    sines,
    velocity_steps,
)
from tests.shared.marks import first
from tests.shared.speed import require_gain
from warprock.engines.launching import Form
from warprock.measure import bench
from warprock.model import rocking
from warprock.model.motion import Control
from warprock.model.response import Outcome, SampleTimes
from warprock.recordings import load_record, record_motions
from warprock.running.batch import run_batch
from warprock.running.machine import cpu_vector_flags
from warprock.settings.engines import SETTINGS
from warprock.units import GRAVITY

every_engine = pytest.mark.parametrize("engine", ["impulse", "direct", "xpbd"])


@pytest.mark.parametrize(
    ("engine", "coarse", "fine", "slowest"),
    first(
        2, [("impulse", 4e-3, 1e-3, 0.8), ("direct", 3e-3, 5e-4, 0.8), ("xpbd", 3e-3, 3e-4, 0.9)]
    ),
)
def test_free_rocking_converges_to_housner_at_first_order(
    engine: str, coarse: float, fine: float, slowest: float
) -> None:
    lanes, times = free_lanes(), SampleTimes(5.0, 0.01)
    substeps = np.array([6, 20, 63, 200])
    found = [errors_to_housner(engine, lanes, at_rest(9), times, substeps=int(n)) for n in substeps]
    assert np.max(found[1]) <= coarse
    assert np.max(found[3]) <= fine
    # Each impact falls somewhere inside its step, so one lane's error scatters about its trend;
    # the mean of nine lanes over a factor of 30 in the step shows the order.
    slope = np.polyfit(np.log(1.0 / (substeps + 1.0)), np.log(np.mean(found, axis=1)), 1)[0]
    assert slowest <= slope <= 1.3


@pytest.mark.parametrize(
    ("engine", "settings", "still"),
    [
        # The rotation stays below what the collision margin hides.
        ("impulse", {}, 2e-6),
        # The block leans on its springs.
        ("direct", {}, 1e-9),
        ("direct", {"friction_box": 1}, 1e-9),
        ("xpbd", {}, 1e-9),
    ],
)
def test_block_slides_by_the_closed_form(
    engine: str, settings: dict[str, Any], still: float
) -> None:
    # Friction below tan(alpha): the block slides and does not rock. Under a velocity step v it
    # slides v^2 / (2 mu g), against the step of the base.
    friction = np.array([0.05, 0.1, 0.2])
    speed = np.array([0.3, -0.2, 0.4])
    lanes = make_lanes(np.full(3, 1.0), 1.0, friction=friction)
    motions = velocity_steps(speed, np.zeros(3), np.full(3, 10.0))
    given = SETTINGS[engine](**settings)
    response = run_batch(engine, lanes, motions, SampleTimes(2.0), settings=given)
    expected = -np.sign(speed) * speed**2 / (2.0 * friction * GRAVITY)
    # First order: the last step may be off by v dt.
    assert np.all(np.abs(response["residual_slide"] - expected) <= np.abs(speed) * given.time_step)
    assert np.all(response["outcome"] == Outcome.AT_REST)
    assert np.all(response["peak_rotation"] < still)
    np.testing.assert_allclose(response["energy_lost"], 0.5 * lanes.mass * speed**2, rtol=2e-3)


@pytest.mark.parametrize("engine", ["impulse", "direct"])
def test_sticking_block_does_not_slide(engine: str) -> None:
    lanes = make_lanes(np.full(1, 0.2), 1.0, friction=1.0)
    motions = sines(Control.ACCELERATION, 0.25 * GRAVITY, 3.0, 1.0)
    response = run_batch(engine, lanes, motions, SampleTimes(3.0))
    assert response["outcome"][0] != Outcome.OVERTURNED
    assert response["peak_rotation"][0] > 0.05 * lanes.slenderness_angle[0]
    # The pivot moves on an arc that the step follows along its tangent: (omega dt)^2 R a step.
    assert response["peak_slide"][0] < 1e-4


@pytest.mark.thorough
@pytest.mark.parametrize("engine", ["impulse", "direct"])
def test_record_is_followed_in_time_and_size(engine: str) -> None:
    record = load_record("ridgecrest-2019-ccc-090")
    lanes = make_lanes(np.full(2, 0.4), 2.0, friction=2.0)
    motions = record_motions(
        [record], index=np.zeros(2, np.int64), scale=np.array([0.6, 0.6]), start=np.zeros(2)
    )
    times = SampleTimes(22.0, 0.01)
    found = errors_to_housner(engine, lanes, motions, times, substeps=200)
    peak = run_batch("housner", lanes, motions, times)["peak_rotation"] / lanes.slenderness_angle
    assert np.all(peak > 0.02)
    # First order through some twenty impacts: a few per cent of the largest swing.
    assert np.max(found) <= 0.05 * np.max(peak)


@every_engine
def test_quarter_period_within_a_step(engine: str) -> None:
    lanes = make_lanes(np.full(3, 0.5), np.array([0.75, 1.0, 1.25]), 0.5)
    quarter = rocking.quarter_period(lanes.width, lanes.height, lanes.rotation_start)
    step = SETTINGS[engine]().time_step
    response = run_batch(engine, lanes, at_rest(3), SampleTimes(1.0, step))
    below = np.argmax(response["rotation"] <= 1e-6, axis=1) * step
    # The landing shows in the step that reaches the base, or in the one after.
    assert np.all(np.abs(below - quarter) <= 2.0 * step)


@pytest.mark.parametrize("engine", first(2, ["impulse", "direct", "xpbd"]))
def test_overturning_velocity_step_at_its_limit(engine: str) -> None:
    limit = float(closed_forms.overturning_velocity_step(0.3, 1.0))
    settings = SETTINGS[engine](substeps=200)
    # The step is felt over half a time step: the limit moves by about p dt = 1e-4 of itself.
    speed = limit * np.array([1.0 - 5e-4, 1.0 + 5e-4])
    lanes = make_lanes(np.full(2, 0.3), 1.0, friction=10.0)
    motions = velocity_steps(speed, np.zeros(2), np.full(2, 30.0))
    response = run_batch(engine, lanes, motions, SampleTimes(5.0), settings=settings)
    np.testing.assert_array_equal(response["outcome"] == Outcome.OVERTURNED, [False, True])


GAINS = {
    # With vectors of 512 bits 4.3 to 9.7 were measured.
    ("impulse", "float64"): (3.0, 2.0),
    # 7 to 12.
    ("impulse", "float32"): (5.0, 3.0),
    # 3.4 to 4.1.
    ("direct", "float64"): (2.0, 1.5),
    # 6.1 to 9.2.
    ("direct", "float32"): (4.0, 2.5),
}
"""How many times as fast the packed form is at least, with 512-bit vectors and with shorter ones.

Without vector code it is 1. Each bound is some half of what was measured: the two forms do not slow
down alike where other programs use the machine.
"""


@pytest.mark.speed
@pytest.mark.parametrize(("engine", "precision"), GAINS)
def test_packed_kernel_is_vectorised(engine: str, precision: str) -> None:
    # A ratio within one run: without vector code the packed form is no faster than the plain one.
    wide, narrow = GAINS[engine, precision]

    def cost(form: Form) -> float:
        measured = bench.measure(engine, 0.5, precision=precision, form=form)
        return measured.cpu_s_per_simulated_s

    least = wide if "avx512f" in cpu_vector_flags() else narrow
    require_gain(lambda: cost(Form.PLAIN), lambda: cost(Form.PACKED), least)
