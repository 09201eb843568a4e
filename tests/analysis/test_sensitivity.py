"""Sobol' indices: a function with known ones, inputs that play no part, refusals, the command."""

from __future__ import annotations

import json
import pathlib

import numpy as np
import pandas as pd
import pytest

from tests.shared.case_texts import pulse_text
from tests.shared.commands import invoke, succeed
from warprock.analysis import sensitivity
from warprock.analysis.sensitivity import SaltelliSample, indices, run_sensitivity, saltelli_case
from warprock.case.case import Case
from warprock.case.lanes import expand_lanes
from warprock.case.load import load_case
from warprock.case.sampling import Sample
from warprock.errors import InputError
from warprock.model.ratios import peak_ratio
from warprock.model.response import Outcome, Status
from warprock.running.case_run import run_case

CASE = (
    pulse_text(width="0.17 m", amplitude="2.6 m/s^2", frequency="3 Hz", duration="5 s")
    + """
[sample]
lanes = 128
[sample.over]
block.depth = { distribution = "uniform", from = "0.4 m", to = "0.6 m" }
motion.amplitude = { distribution = "uniform", from = "2.5 m/s^2", to = "2.7 m/s^2" }
block.density = { distribution = "loguniform", from = "1000 kg/m^3", to = "3000 kg/m^3" }
contact.angular_restitution = [0.9, 0.95]
"""
)
INPUTS = ("block.depth", "block.density", "motion.amplitude", "contact.angular_restitution")


@pytest.fixture
def case(tmp_path: pathlib.Path) -> Case:
    (tmp_path / "case.toml").write_text(CASE, encoding="utf-8")
    return load_case(tmp_path)


@pytest.mark.parametrize("sampling", ["sobol", "lhs"])
def test_the_indices_of_ishigamis_function(sampling: str):
    """Known: V = 1/2 + a^2/8 + b pi^4/5 + b^2 pi^8/18 with a = 7, b = 0.1 (Ishigami 1990)."""
    a, b, count = 7.0, 0.1, 4096
    design = SaltelliSample(sampling, 3, 5 * count, 3, Sample(sampling, 3, count, 6))
    points = design.points(np.arange(5 * count))
    x = np.pi * (2.0 * points.T - 1.0)
    values = np.sin(x[0]) + a * np.sin(x[1]) ** 2 + b * x[2] ** 4 * np.sin(x[0])
    found = indices(values.reshape(5, count), 100, 1)
    variance = 0.5 + a**2 / 8.0 + b * np.pi**4 / 5.0 + b**2 * np.pi**8 / 18.0
    alone = np.array([0.5 * (1.0 + b * np.pi**4 / 5.0) ** 2, a**2 / 8.0, 0.0]) / variance
    both = b**2 * np.pi**8 * (1.0 / 18.0 - 1.0 / 50.0) / variance
    total = alone + both * np.array([1.0, 0.0, 1.0])
    for name, known in (("first_order", alone), ("total", total)):
        # The bands are a sample's own: its indices lie within one and a half of them.
        for index, expected in zip(found, known, strict=True):
            width = index[f"{name}_p95"] - index[f"{name}_p05"]
            assert index[name] == pytest.approx(expected, abs=1.5 * width)
            assert width < 0.15


def test_a_single_input_explains_all():
    count = 256
    design = SaltelliSample("sobol", 3 * count, 3 * count, 1, Sample("sobol", 3, count, 2))
    values = design.points(np.arange(3 * count)).reshape(3, count) ** 2
    (found,) = indices(values, 20, 1)
    # The estimate of a sample of 256 points is within 1 / sqrt(256) of it.
    assert [found["first_order"], found["total"]] == pytest.approx([1.0, 1.0], abs=1.0 / 16.0)


def test_the_design_is_two_samples_and_one_column_changed_at_a_time():
    base = Sample("sobol", 5, 16, 6)
    design = SaltelliSample("sobol", 5, 80, 3, base)
    points = design.points(np.arange(80)).reshape(5, 16, 3)
    both = base.points(np.arange(16))
    np.testing.assert_array_equal(points[0], both[:, :3])
    np.testing.assert_array_equal(points[1], both[:, 3:])
    for k in range(3):
        same = [n for n in range(3) if n != k]
        np.testing.assert_array_equal(points[2 + k][:, same], points[0][:, same])
        np.testing.assert_array_equal(points[2 + k][:, k], points[1][:, k])
    # A point does not know which others are asked for.
    some = np.array([3, 4, 5, 40, 41, 79])
    np.testing.assert_array_equal(design.points(some), design.points(np.arange(80))[some])


def test_lanes_of_the_design_are_those_of_the_case(case: Case):
    design = saltelli_case(case)
    assert design.lane_count == 128 * 6
    lanes = expand_lanes(design).inputs
    assert set(lanes["angular_restitution"]) == {0.9, 0.95}
    first, third = lanes.iloc[:128], lanes.iloc[2 * 128 : 3 * 128]
    moved = [name for name in lanes if not np.array_equal(first[name], third[name])]
    assert moved == ["depth_m"]


def test_inputs_that_play_no_part_have_no_share(case: Case):
    found = run_sensitivity(case, "housner", resamples=20)
    rows = found.rows.set_index("input")
    assert tuple(rows.index) == INPUTS
    # Rocking knows neither depth nor density: bitwise the same lanes.
    for name in ("block.depth", "block.density"):
        assert rows.loc[name, ["total", "total_p05", "total_p95"]].tolist() == [0.0, 0.0, 0.0]
        assert rows.loc[name, "first_order"] == 0.0
    shares = rows["first_order"]["motion.amplitude"], rows["total"]["contact.angular_restitution"]
    assert shares[0] > 0.5
    assert 0.0 < shares[1] < shares[0]
    energy = run_sensitivity(case, "housner", of="energy_lost_J", resamples=20).rows
    assert energy.set_index("input")["total"]["block.density"] > 0.5


def test_a_design_with_a_lane_that_has_no_number_is_refused(
    case: Case, monkeypatch: pytest.MonkeyPatch
):
    def one_bad(*arguments, **options):
        run = run_case(*arguments, **options)
        run.response.fields["status"][7] = Status.NONFINITE
        return run

    monkeypatch.setattr(sensitivity, "run_case", one_bad)
    with pytest.raises(InputError, match="status: got 1 lane without a usable number"):
        run_sensitivity(case, "housner", resamples=10)


def test_groups_are_those_of_the_sweep(case: Case, tmp_path: pathlib.Path):
    sweep = '[[sweep]]\nlabel.pulse = ["one", "two"]\nmotion.cycles = [1, 2]\n'
    (tmp_path / "case.toml").write_text(CASE + sweep, encoding="utf-8")
    both = run_sensitivity(load_case(tmp_path), "housner", resamples=10)
    alone = run_sensitivity(case, "housner", resamples=10)
    assert both.groups["group"].tolist() == ["one", "two"]
    first = both.rows[both.rows["group"] == "one"]
    assert first["total"].tolist() == alone.rows["total"].tolist()


def test_a_result_that_does_not_vary_has_no_indices(case: Case):
    found = run_sensitivity(case, "housner", of="overturned", resamples=10)
    assert found.groups["overturned"].tolist() == [0]
    assert found.rows["total"].isna().all()


FALLING = (
    pulse_text(width="0.3 m", friction=10.0, amplitude="3 m/s^2", frequency="3 Hz", duration="12 s")
    + """
[sample]
lanes = 64
[sample.over]
block.width = { distribution = "uniform", from = "0.1 m", to = "0.3 m" }
block.depth = { distribution = "uniform", from = "0.4 m", to = "0.6 m" }
"""
)
"""Every slender block falls, few of the others: the ratio of 90 degrees is that of the width."""


@pytest.fixture
def falling(tmp_path: pathlib.Path) -> Case:
    (tmp_path / "case.toml").write_text(FALLING, encoding="utf-8")
    return load_case(tmp_path)


def test_a_fallen_lane_counts_as_the_point_of_balance(falling: Case):
    found = run_sensitivity(falling, "housner", resamples=10)
    run, group = found.run, found.groups.iloc[0]
    fell = run.response["outcome"] == Outcome.OVERTURNED
    assert 10 < fell.sum() < 246
    raw = peak_ratio(run.response, run.lane_set.lanes)
    own = np.where(fell, 1.0, np.minimum(raw, 1.0)).reshape(4, -1)
    assert group["mean"] == pytest.approx(own[:2].mean(), rel=1e-12)
    assert group["censored"] == (fell | (raw >= 1.0)).sum()
    # So that the indices know nothing of how far a fallen block turned on its side.
    known = [each["total"] for each in indices(own, 10, 1)]
    assert found.rows["total"].tolist() == pytest.approx(known, rel=1e-12)


def test_lanes_that_all_fell_have_nothing_to_explain(falling: Case, tmp_path: pathlib.Path):
    case = load_case(tmp_path, ('motion.amplitude="40 m/s^2"', 'motion.frequency="0.5 Hz"'))
    found = run_sensitivity(case, "housner", resamples=10)
    assert (found.run.response["outcome"] == Outcome.OVERTURNED).all()
    assert found.rows["total"].isna().all()


@pytest.mark.parametrize("of", ["peak_rotation_rad", "energy_lost_J", "impact_count"])
def test_what_ends_with_a_fall_is_refused_where_lanes_fell(of: str, falling: Case):
    allowed = "must be none: their numbers end with the fall; ask for peak_rotation_ratio"
    with pytest.raises(InputError, match=allowed):
        run_sensitivity(falling, "housner", of=of, resamples=10)


@pytest.mark.usefixtures("unrendered")
def test_the_command_writes_what_it_prints(
    case: Case, tmp_path: pathlib.Path, request: pytest.FixtureRequest
):
    out = tmp_path / "out"
    arguments = ["sensitivity", str(tmp_path), "--resamples", "20", "-o", str(out)]
    result = succeed(*arguments, "--json")
    found = json.loads(result.stdout)
    table = pd.read_csv(out / "sensitivity.csv")
    assert [row["total"] for row in found["rows"]] == table["total"].tolist()
    assert found["groups"][0]["lanes"] == case.lane_count * 6
    assert (out / "sensitivity.png").read_bytes()[:4] == b"\x89PNG"
    request.getfixturevalue("unrendered")
    printed = invoke(*arguments).stdout
    assert f"{table['total'].max():.3f}" in printed
    order = table.sort_values("total", ascending=False, kind="stable")["input"]
    places = [printed.index(f"{name} ") for name in order]
    assert places == sorted(places)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["-s", "sample.lanes=100"], "sample.lanes: got 100, must be a power of 2"),
        (["-s", "sample.lanes=8"], "at least 16"),
        (["-s", "sample.lanes=16777216"], "at most 20,000,000 lanes"),
        (["--of", "colour"], "must be overturned or one of "),
        (["--resamples", "1"], "from 10 to 10000"),
    ],
)
def test_what_has_no_indices_is_refused(
    arguments: list[str], words: str, case: Case, tmp_path: pathlib.Path
):
    out = tmp_path / "out"
    result = invoke("sensitivity", tmp_path, "-o", out, *arguments)
    assert result.exit_code == 2
    assert words in result.stderr
    assert result.stderr.count("\n") == 1
    assert not out.exists()


def test_a_case_without_a_sample_is_refused():
    with pytest.raises(InputError, match="sample: got nothing, must be given"):
        run_sensitivity(load_case("free-b0"), "housner")
