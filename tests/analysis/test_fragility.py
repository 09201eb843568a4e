"""Fragility functions: greatest likelihood, data without one, bands over records, the command."""

from __future__ import annotations

import io
import json
import pathlib

import numpy as np
import numpy.typing as npt
import pandas as pd
import pytest
from click.testing import Result
from scipy.optimize import minimize
from scipy.special import ndtr
from scipy.stats import norm

from tests.shared.commands import invoke
from tests.shared.fragility_studies import stripes
from warprock.analysis.exports import component_rows
from warprock.analysis.fragility import (
    curve_rows,
    fragility_curves,
)
from warprock.analysis.limits import read_limits
from warprock.analysis.lognormal import Verdict, fit_lognormal, observe
from warprock.errors import InputError
from warprock.figures.fragility import draw_curves, gathered
from warprock.findings.fits import fit_cells
from warprock.findings.fragility import find_fragility
from warprock.tables.finding import print_finding
from warprock.tables.terminal import plain_console

Array = npt.NDArray[np.float64]


def test_the_fit_is_the_greatest_likelihood():
    intensity, reached, record = stripes(30, seed=3)
    fit = fit_lognormal(observe(intensity, reached, record).brackets)

    def loss(parameters: Array) -> float:
        share = norm.cdf(np.log(intensity / np.exp(parameters[0])) / np.exp(parameters[1]))
        return -float(np.sum(np.where(reached, np.log(share), np.log1p(-share))))

    best = minimize(
        loss, [0.0, -1.0], method="Nelder-Mead", options={"xatol": 1e-9, "fatol": 1e-12}
    )
    # The simplex sees the minimum through round-off of the loss: half of the digits.
    assert fit.verdict is Verdict.FITTED
    assert np.log(fit.median) == pytest.approx(best.x[0], abs=1e-6)
    assert np.log(fit.dispersion) == pytest.approx(best.x[1], abs=1e-6)


@pytest.mark.extra
def test_the_fit_equals_that_of_pyfragility():
    other = pytest.importorskip("pyFragility", reason="the extra [fragility] is not installed")
    intensity, reached, record = stripes(40, seed=5)
    levels = np.unique(intensity)
    counts = np.array([reached[intensity == level].sum() for level in levels])
    theirs = other.fit_msa(levels, counts, np.full(len(levels), 40))
    ours = fit_lognormal(observe(intensity, reached, record).brackets)
    np.testing.assert_allclose([ours.median, ours.dispersion], theirs.params, rtol=1e-6)


@pytest.mark.parametrize(
    ("hits", "verdict", "low", "high"),
    [
        ((0, 0, 0, 0), Verdict.NONE_REACHED, 4.0, np.nan),
        ((1, 1, 1, 1), Verdict.ALL_REACHED, np.nan, 1.0),
        ((0, 0, 1, 1), Verdict.SEPARATED, 2.0, 3.0),
        ((1, 1, 0, 0), Verdict.FALLING, np.nan, np.nan),
        ((1, 0, 1, 0), Verdict.FALLING, np.nan, np.nan),
        ((0, 1, 0, 1), Verdict.FITTED, np.nan, np.nan),
    ],
)
def test_data_without_a_function_say_so(
    hits: tuple[int, ...], verdict: Verdict, low: float, high: float
):
    intensity = np.array([1.0, 2.0, 3.0, 4.0])
    fit = fit_lognormal(observe(intensity, np.array(hits, dtype=bool), np.arange(4)).brackets)
    assert fit.verdict is verdict
    np.testing.assert_equal([fit.low, fit.high], [low, high])
    assert np.isfinite(fit.median) == (verdict in (Verdict.FITTED, Verdict.SEPARATED))


def test_lanes_that_overlap_at_one_intensity_alone_are_parted():
    # Mixed at 2, nothing below, everything above: the likelihood grows as the dispersion falls.
    intensity = np.array([1.0, 2.0, 2.0, 3.0])
    fit = fit_lognormal(
        observe(intensity, np.array([0, 0, 1, 1], dtype=bool), np.arange(4)).brackets
    )
    assert fit.verdict is Verdict.SEPARATED
    assert (fit.low, fit.high) == (2.0, 2.0)


def test_a_scale_of_the_intensity_scales_the_median_alone():
    intensity, reached, record = stripes(25, seed=7)
    small, large = (
        fit_lognormal(observe(s * intensity, reached, record).brackets) for s in (1e-6, 1e6)
    )
    assert large.median / small.median == pytest.approx(1e12, rel=1e-9)
    assert large.dispersion == pytest.approx(small.dispersion, rel=1e-9)


def lane_table(lanes: int = 400) -> pd.DataFrame:
    rng = np.random.default_rng(0)
    scale = rng.uniform(0.2, 3.0, lanes)
    ratio = scale * np.exp(0.5 * rng.standard_normal(lanes)) * 0.5
    fell = ratio > 1.0
    return pd.DataFrame(
        {
            "size": np.where(np.arange(lanes) % 2, "small", "large"),
            "record": pd.Categorical([f"r{k % 20}" for k in range(lanes)]),
            "peak_acceleration_m_s2": scale,
            "uplift_time_s": np.where(ratio > 0.2, 1.0, np.nan),
            "outcome": np.where(fell, "overturned", "rocking"),
            "status": "ok",
            "peak_rotation_ratio": np.where(fell, 9.0, ratio),
        }
    )


def test_limit_states_are_counted_as_they_are_defined():
    table = lane_table()
    limits = read_limits(["uplift", "0.5", "overturning"])
    curves = fragility_curves(table, source="t", limits=limits, by=["size"])
    rows = curve_rows(curves).set_index(["size", "limit_state"])
    for size, lanes in table.groupby("size"):
        counts = rows.loc[size]["reached"]
        assert counts["uplift"] == lanes["uplift_time_s"].notna().sum()
        assert counts["0.5"] == (lanes["peak_rotation_ratio"] >= 0.5).sum()
        assert counts["overturning"] == (lanes["outcome"] == "overturned").sum()
    assert set(rows["records"]) == {10}


def test_lanes_without_a_value_are_a_group_of_their_own():
    table = lane_table()
    table["scale"] = np.where(np.arange(len(table)) % 2, 0.5, np.nan)
    curves = fragility_curves(table, source="t", limits=read_limits(["0.5"]), by=["scale"])
    assert [curve.seen.count.sum() for curve in curves] == [200, 200]
    assert [curve.group_text for curve in curves] == ["scale nan", "scale 0.5"]


def test_a_group_for_every_lane_is_refused(tmp_path: pathlib.Path):
    lane_table(1001).to_parquet(tmp_path / "lanes.parquet")
    result = run(str(tmp_path), "--by", "peak_acceleration_m_s2")
    assert result.exit_code == 2
    assert "'peak_acceleration_m_s2', must make at most 1,000 groups, not 1,001" in result.stderr


def test_a_block_that_slid_off_has_reached_all_but_overturning():
    table = lane_table(4).assign(
        outcome=["slid_off", "rocking", "rocking", "overturned"],
        peak_rotation_ratio=[0.1, 0.5, np.nextafter(0.5, 0.0), 9.0],
        uplift_time_s=[np.nan, 1.0, 1.0, np.nan],
    )
    limits = read_limits(["uplift", "0.5", "overturning"])
    rows = curve_rows(fragility_curves(table, source="t", limits=limits))
    assert rows["reached"].tolist() == [4, 3, 1]


@pytest.mark.parametrize(("records", "banded"), [(4, False), (5, True)])
def test_fewer_than_five_records_have_no_band(records: int, banded: bool):
    table = lane_table()
    table["record"] = np.arange(len(table)) % records
    (curve,) = fragility_curves(table, source="t", limits=read_limits(["0.5"]))
    assert (curve.band is not None) == banded
    assert np.isfinite(curve_rows([curve])["median_p05"]).item() == banded


def test_dots_are_as_many_lanes_each():
    lanes = lane_table(1200)
    (curve,) = fragility_curves(lanes, source="t", limits=read_limits(["0.5"]))
    at, share = gathered(curve.seen)
    assert len(at) == 12
    assert np.all(np.diff(at) > 0.0)
    # Of a hundred lanes each.
    assert 100.0 * share.sum() == pytest.approx(curve.seen.reached.sum(), abs=1e-9)


def test_a_table_says_beyond_what_a_limit_lies():
    table = lane_table().assign(outcome="rocking")
    limits = read_limits(["0.0001", "99"])
    rows = curve_rows(fragility_curves(table, source="t", limits=limits))
    least, most = table["peak_acceleration_m_s2"].min(), table["peak_acceleration_m_s2"].max()
    assert fit_cells(rows.iloc[0]) == [f"below {least:.4g}", "none: everything reached it"]
    assert fit_cells(rows.iloc[1]) == [f"above {most:.4g}", "none: nothing reached it"]


def test_a_stack_reaches_a_limit_with_its_worst_block():
    table = lane_table().rename(columns={"peak_rotation_ratio": "peak_rotation_ratio_1"})
    table["peak_rotation_ratio_2"] = 2.0
    (curve,) = fragility_curves(table, source="t", limits=read_limits(["1.5"]))
    assert curve.fit.verdict is Verdict.ALL_REACHED


def test_the_component_table_marks_what_has_no_function():
    limits = read_limits(["50", "0.5"])
    curves = fragility_curves(lane_table(), source="t", limits=limits)
    row = component_rows(curves, "peak_acceleration_m_s2").iloc[0]
    # Only blocks that overturned reach 50, and here none of them stands above it.
    assert row["LS2-Family"] == "lognormal"
    assert row["LS2-Theta_0"] == pytest.approx(curves[1].fit.median)
    assert row["Incomplete"] == 0
    none = fragility_curves(lane_table().assign(outcome="rocking"), source="t", limits=limits)
    assert component_rows(none, "x").iloc[0]["Incomplete"] == 1


@pytest.mark.parametrize(
    ("limits", "words"),
    [(["-1"], "above"), (["nan"], "above"), (["tilt"], "uplift"), (["0.2", "0.2"], "once")],
)
def test_limits_that_are_none_are_refused(limits: list[str], words: str):
    with pytest.raises(InputError, match=words):
        read_limits(limits)


def run(*arguments: str) -> Result:
    return invoke("fragility", *arguments)


def many_groups(groups: int) -> pd.DataFrame:
    """Every second group falls from an intensity of 0.5 on, where the others do not fall at all."""
    intensity = np.tile(np.linspace(0.1, 1.0, 10), groups)
    group = np.repeat(np.arange(groups), 10)
    fell = (intensity > 0.5 + 0.01 * group) & (group % 2 == 0)
    return pd.DataFrame(
        {
            "size": group,
            "im": intensity,
            "outcome": np.where(fell, "overturned", "at_rest"),
            "status": "ok",
            "peak_rotation_ratio": np.where(fell, 10.0, 0.1),
            "uplift_time_s": 0.1,
        }
    )


def test_many_groups_are_summed_up_and_their_names_stand_once_in_the_figure():
    limits = read_limits(["overturning"])
    table = many_groups(12)
    curves = fragility_curves(table, source="t", intensity="im", limits=limits, by=["size"])
    finding = find_fragility(table, curves, "t", "im")
    none = "In none of 12 groups a function of overturning could be fitted: no lane reached it or "
    assert finding.headline == f"{none}the data are separated"
    console = plain_console(width=80, record=True, file=io.StringIO())
    print_finding(finding, console)
    text = " ".join(console.export_text().split())
    assert "12 groups" in text
    assert "overturning 0 - - - 6 6 0" in text
    (drawing,) = draw_curves(curves, "im", finding.headline)
    assert drawing.title == finding.headline
    few = fragility_curves(many_groups(2), source="t", intensity="im", limits=limits, by=["size"])
    print_finding(find_fragility(many_groups(2), few, "t", "im"), console)
    assert "2 groups" not in (text := console.export_text())
    assert "dispersion" in text


@pytest.mark.usefixtures("pages_bare")
def test_the_command_writes_what_it_prints(tmp_path: pathlib.Path):
    lane_table().to_parquet(tmp_path / "lanes.parquet")
    result = run(str(tmp_path), "--by", "size", "-o", str(tmp_path / "out"), "--json")
    assert result.exit_code == 0, result.output
    found = json.loads(result.stdout)
    written = pd.read_csv(tmp_path / "out" / "fragility.csv", converters={"median": float})
    assert [row["median"] for row in found["curves"]] == written["median"].tolist()
    # What is parted by no intensity has none; JSON has no NaN.
    assert {row["none_up_to"] for row in found["curves"]} == {None}
    names = {path.name for path in (tmp_path / "out").iterdir()}
    assert names == {
        ".warprock.json",
        "fragility.csv",
        "fragility-p58.csv",
        "fragility.png",
        "fragility.xml",
        "report.html",
    }
    printed = run(str(tmp_path), "--by", "size").stdout
    assert f"{written['median'][1]:.3g}" in printed


@pytest.mark.parametrize(
    ("change", "arguments", "words"),
    [
        ({}, ("--im", "strength"), "peak_acceleration_m_s2"),
        ({}, ("--by", "colour"), "size"),
        ({"peak_acceleration_m_s2": 0.0}, (), "above 0"),
        ({"status": "nonfinite"}, (), "can be used"),
        ({}, ("--max-doubt", "1.5"), "from 0"),
    ],
)
def test_a_table_or_an_option_that_cannot_be_used_is_refused(
    change: dict[str, object], arguments: tuple[str, ...], words: str, tmp_path: pathlib.Path
):
    file = tmp_path / "lanes.parquet"
    lane_table().assign(**change).to_parquet(file)
    result = run(str(file), *arguments)
    assert result.exit_code == 2
    assert words in result.stderr
    assert result.stderr.count("\n") == 1


def test_a_file_that_is_no_table_is_refused(tmp_path: pathlib.Path):
    (tmp_path / "lanes.parquet").write_text("no")
    result = run(str(tmp_path))
    assert result.exit_code == 2
    assert "must be a Parquet file" in result.stderr


def test_the_probability_is_that_of_the_lognormal_distribution():
    fit = fit_lognormal(observe(*stripes(30, seed=1)).brackets)
    at = np.array([0.5, 2.0])
    expected = ndtr((np.log(at) - np.log(fit.median)) / fit.dispersion)
    np.testing.assert_allclose(fit.probability(at), expected, rtol=1e-14)
