"""The [ensemble] table of a case: its sample, the lanes it makes, and what it refuses."""

from __future__ import annotations

import functools
import pathlib
from collections.abc import Callable

import numpy as np
import pytest
import scipy.stats

from tests.shared.ensembles import SPREAD, STACK, write_pulse
from warprock.case.case import Case
from warprock.case.ensemble import STEP_GROUPS
from warprock.case.lanes import expand_lanes
from warprock.case.load import load_case
from warprock.errors import InputError
from warprock.running.case_run import run_case
from warprock.running.cells import cell_table
from warprock.tables.cells import cell_names


@pytest.fixture
def write(tmp_path: pathlib.Path) -> Callable[..., pathlib.Path]:
    """Writes the case of three cells to a folder of its own."""
    return functools.partial(write_pulse, tmp_path)


def sample_of(case: Case) -> np.ndarray:
    assert case.ensemble is not None
    return case.ensemble.points(np.arange(case.members))


@pytest.mark.parametrize("sampling", ["sobol", "lhs"])
def test_a_seed_makes_the_sample(write, sampling: str):
    first = expand_lanes(load_case(write(sampling=sampling))).inputs
    again = expand_lanes(load_case(write(sampling=sampling))).inputs
    other = expand_lanes(load_case(write(sampling=sampling, seed=2))).inputs
    columns = ["friction", "width_m", "amplitude_m_s2"]
    for column in columns:
        assert first[column].to_numpy().tobytes() == again[column].to_numpy().tobytes()
        assert (first[column] != other[column]).all()


@pytest.mark.parametrize("sampling", ["sobol", "lhs"])
@pytest.mark.parametrize("members", [64, 1000])
def test_marginals_are_uniform_and_stratified(write, sampling: str, members: int):
    sample = sample_of(load_case(write(members=members, sampling=sampling)))
    assert sample.shape == (members, 3)
    for column in sample.T:
        assert scipy.stats.kstest(column, "uniform").pvalue > 0.05
    if sampling == "lhs" or members == 64:
        # One member in each of as many equal parts: by construction of a Latin hypercube, and of
        # a net of a power of two.
        parts = np.sort(np.floor(sample * members), axis=0)
        np.testing.assert_array_equal(parts, np.arange(members)[:, None].repeat(3, axis=1))


def test_every_cell_has_its_own_values_and_the_same_sample(write):
    case = load_case(write(more='time_step = "10 %"'))
    lane_set = expand_lanes(case)
    assert (case.shape, case.members, case.lane_count) == ((3,), 64, 192)
    assert cell_names(case) == ["0.25 g", "0.3 g", "0.35 g"]
    inputs = lane_set.inputs
    np.testing.assert_array_equal(inputs["member"], np.tile(np.arange(64), 3))
    # "2 %" and "5 %" of the value, "1 mm" as it is; friction 45 deg is a coefficient of 1.
    own = 9.81 * np.array([0.25, 0.3, 0.35])[:, None]
    move = 2.0 * sample_of(case) - 1.0
    found = inputs["amplitude_m_s2"].to_numpy().reshape(3, 64)
    np.testing.assert_allclose(found, own * (1.0 + 0.02 * move[:, 1]), rtol=1e-14)
    for column, value in (
        ("friction", 1.0 + 0.05 * move[:, 0]),
        ("width_m", 0.17 + 1e-3 * move[:, 2]),
    ):
        np.testing.assert_allclose(inputs[column], np.tile(value, 3), rtol=1e-14)
    assert lane_set.cells is not None
    np.testing.assert_allclose(lane_set.cells["amplitude_m_s2"], own[:, 0], rtol=1e-14)
    assert (lane_set.cells["width_m"] == 0.17).all()


def test_time_steps_are_dealt_evenly_and_apart_from_the_inputs(write):
    case = load_case(write(members=1000, more='time_step = "10 %"'))
    factors = expand_lanes(case).step_factors
    assert factors is not None
    steps = 0.9 + 0.2 * (np.arange(STEP_GROUPS) + 0.5) / STEP_GROUPS
    np.testing.assert_allclose(np.unique(factors), steps, rtol=1e-15)
    members = factors[:1000]
    counts = np.unique(members, return_counts=True)[1]
    # 1000 of a net of 1024, which has 128 in each eighth: 24 of 1024 are left out.
    assert counts.max() <= 128
    assert counts.min() >= 104
    for column in sample_of(case)[:, :3].T:
        means = [column[members == step].mean() for step in np.unique(members)]
        # The mean of 104 independent uniform numbers scatters by 0.028.
        np.testing.assert_allclose(means, 0.5, atol=3 * 0.028)


def test_without_an_ensemble_there_is_no_member(write):
    file = write()
    text = file.read_text(encoding="utf-8")
    file.write_text(text[: text.index("[ensemble]")], encoding="utf-8")
    case = load_case(file)
    lane_set = expand_lanes(case)
    assert lane_set.members == 1
    assert lane_set.cells is lane_set.step_factors is None
    assert "member" not in lane_set.inputs
    response = run_case(case, "housner", histories=False).response
    with pytest.raises(ValueError, match="case with an ensemble"):
        cell_table(lane_set, response)


@pytest.mark.parametrize(
    ("spread", "more", "words"),
    [
        ('contact.fricton = "5 %"', "", ["ensemble.spread.contact.fricton", "contact.friction?"]),
        ('motion.waveform = "5 %"', "", ["ensemble.spread.motion.waveform", "unknown key"]),
        ('run.duration = "5 %"', "", ["ensemble.spread.run.duration", "unknown key"]),
        ('start.rotation = "5 %"', "", ["start.rotation", "'5 %'", "a part of 0 is 0"]),
        ('contact.friction = "2 deg"', "", ["'2 deg'", "a number without a unit"]),
        ('motion.amplitude = "1 mm"', "", ["motion.amplitude", "an acceleration"]),
        ('motion.scale = "5 %"', "", ["motion.scale", "with waveform sine"]),
        ('contact.friction = "-5 %"', "", ["'-5 %'", 'must be "5 %" of the value']),
        ("contact.friction = 0", "", ["got 0", "more than 0"]),
        ("contact.friction = 1.5", "", ["1.5", "-0.5", "at least 0"]),
        ('block.width = "170 mm"', "", ["'170 mm'", "would reach 0 m", "at least 1 mm"]),
        ("contact.angular_restitution = 0.1", "", ["give contact.angular_restitution too"]),
        (SPREAD, 'time_step = "0.1"', ["ensemble.time_step", "'0.1'", "less than 100 %"]),
        (SPREAD, 'time_step = "100 %"', ["ensemble.time_step", "less than 100 %"]),
        (SPREAD, "member = 3", ["ensemble.member", "did you mean members?"]),
        ("", "", ["ensemble.spread", "at least one key"]),
    ],
)
def test_what_cannot_be_used_is_refused(write, spread: str, more: str, words: list[str]):
    file = write(spread, more=more)
    with pytest.raises(InputError) as error:
        load_case(file)
    for word in [str(file), *words]:
        assert word in str(error.value), f"{word!r} is not in {error.value}"


@pytest.mark.parametrize(
    ("override", "words"),
    [
        ("ensemble.members=1", ["ensemble.members", "got 1", "from 2"]),
        ("ensemble.members=2.5", ["ensemble.members", "whole number"]),
        ("ensemble.seed=-1", ["ensemble.seed", "got -1", "from 0"]),
        ("ensemble.sampling=sobel", ["ensemble.sampling", "did you mean sobol?"]),
        ("ensemble=3", ["ensemble", "must be a table"]),
    ],
)
def test_overrides_are_judged_too(write, override: str, words: list[str]):
    with pytest.raises(InputError) as error:
        load_case(write(), [override])
    for word in ["-s", *words]:
        assert word in str(error.value), f"{word!r} is not in {error.value}"


def test_members_of_a_stack_must_stand(tmp_path: pathlib.Path):
    file = tmp_path / "case.toml"
    file.write_text(STACK + 'block.1.chamfer = "6 mm"\n', encoding="utf-8")
    with pytest.raises(InputError, match=r"block\.1\.chamfer.*would reach -0\.001 m.*at least 0 m"):
        load_case(file)
    file.write_text(STACK + 'block.2.offset = "0.3 m"\n', encoding="utf-8")
    with pytest.raises(InputError, match=r"block\.2\.offset.*on the face.*lane \d"):
        expand_lanes(load_case(file))
