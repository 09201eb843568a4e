"""Which lanes fragility functions count: left out, in doubt, too many; the slide as a limit."""

from __future__ import annotations

import json
import pathlib

import numpy as np
import pandas as pd
import pytest
from click.testing import Result

from tests.shared.commands import invoke
from warprock.analysis.fragility import curve_rows, fragility_curves
from warprock.analysis.limits import find_reached, in_doubt, read_limits
from warprock.errors import InputError

ALPHA = 0.2


def lane_table(lanes: int = 400) -> pd.DataFrame:
    """Lanes of twenty records with an estimate of their errors, all of them ok."""
    rng = np.random.default_rng(0)
    scale = rng.uniform(0.2, 3.0, lanes)
    ratio = scale * np.exp(0.5 * rng.standard_normal(lanes)) * 0.5
    fell = ratio > 1.0
    ratio = np.where(fell, 0.5 * np.pi / ALPHA, ratio)
    return pd.DataFrame(
        {
            "record": [f"r{k % 20}" for k in range(lanes)],
            "peak_acceleration_m_s2": scale,
            "slenderness_angle_rad": ALPHA,
            "uplift_time_s": np.where(ratio > 0.2, 1.0, np.nan),
            "outcome": np.where(fell, "overturned", "rocking"),
            "status": "ok",
            "peak_rotation_ratio": ratio,
            "peak_rotation_error_rad": 1e-4 * ALPHA,
            "peak_slide_m": 0.01 * scale * np.exp(0.5 * rng.standard_normal(lanes)),
        }
    )


def lanes_like(**columns: object) -> pd.DataFrame:
    return lane_table(1).assign(**{"outcome": "rocking", "uplift_time_s": 1.0, **columns})


@pytest.mark.parametrize(
    ("limit", "columns", "doubt"),
    [
        # The estimated error reaches over the limit or does not.
        ("0.35", {"peak_rotation_ratio": 0.34, "peak_rotation_error_rad": 0.02 * ALPHA}, True),
        ("0.35", {"peak_rotation_ratio": 0.34, "peak_rotation_error_rad": 0.005 * ALPHA}, False),
        ("0.35", {"peak_rotation_ratio": 0.36, "peak_rotation_error_rad": 0.02 * ALPHA}, True),
        ("0.35", {"peak_rotation_ratio": 0.1, "peak_rotation_error_rad": np.inf}, True),
        # A sensitive lane far from a limit is not in doubt of it, without an estimate it is.
        ("0.35", {"status": "sensitive", "peak_rotation_ratio": 0.1}, False),
        ("0.35", {"status": "sensitive", "peak_rotation_error_rad": np.nan}, True),
        ("overturning", {"status": "sensitive", "peak_rotation_ratio": 0.4,
                         "peak_rotation_error_rad": 0.3 * ALPHA}, False),
        ("overturning", {"status": "sensitive", "peak_rotation_ratio": 0.8,
                         "peak_rotation_error_rad": 0.3 * ALPHA}, True),
        ("overturning", {"status": "sensitive", "outcome": "overturned",
                         "peak_rotation_ratio": 7.9, "peak_rotation_error_rad": 7.5 * ALPHA}, True),
        ("overturning", {"status": "sensitive", "outcome": "overturned", "peak_rotation_ratio": 7.9,
                         "peak_rotation_error_rad": 4.0 * ALPHA}, False),
        ("overturning", {"status": "sensitive", "outcome": "overturned",
                         "peak_rotation_error_rad": np.nan}, True),
        ("overturning", {"status": "ok", "outcome": "overturned"}, False),
        ("uplift", {"status": "sensitive", "peak_rotation_ratio": 0.4,
                    "peak_rotation_error_rad": 0.3 * ALPHA}, False),
        ("uplift", {"status": "sensitive", "peak_rotation_ratio": 0.1,
                    "peak_rotation_error_rad": 0.3 * ALPHA}, True),
        # What an engine left out may have changed what became of a block, not that it lifted.
        ("overturning", {"status": "outside_model"}, True),
        ("0.35", {"status": "outside_model"}, True),
        ("uplift", {"status": "outside_model"}, False),
        ("slide 10 mm", {"peak_slide_m": 0.0101, "peak_slide_error_m": 2e-4}, True),
        ("slide 10 mm", {"peak_slide_m": 0.0101, "peak_slide_error_m": 5e-5}, False),
        ("slide 10 mm", {"status": "sensitive", "peak_slide_m": 0.1}, True),
        ("slide 10 mm", {"status": "ok", "peak_slide_m": 0.1}, False),
    ],
)  # fmt: skip
def test_a_lane_is_in_doubt_where_its_numbers_do_not_tell(
    limit: str, columns: dict[str, object], doubt: bool
):
    slides = [limit.removeprefix("slide ")] if limit.startswith("slide") else []
    (asked,) = read_limits([] if slides else [limit], slides)
    assert in_doubt(lanes_like(**columns), asked).tolist() == [doubt]


def test_lanes_in_doubt_count_as_they_are_and_bands_reach_around_both_extremes():
    table = lane_table()
    plain = curve_rows(fragility_curves(table, source="t", limits=read_limits(["overturning"])))
    near = (table["outcome"] == "overturned") & (np.arange(400) % 5 == 0)
    table.loc[near, "status"] = "sensitive"
    table.loc[near, "peak_rotation_error_rad"] = np.inf
    (curve,) = fragility_curves(table, source="t", limits=read_limits(["overturning"]))
    row = curve_rows([curve]).iloc[0]
    assert row["in_doubt"] == near.sum() > 10
    assert row["reached"] == plain["reached"][0]
    # All of them had overturned: as if none was in doubt, and as if none had.
    assert row["median_if_reached"] == pytest.approx(plain["median"][0], rel=1e-9)
    table.loc[near, "outcome"] = "rocking"
    table.loc[near, ["status", "peak_rotation_error_rad"]] = ["ok", 1e-4 * ALPHA]
    other = curve_rows(fragility_curves(table, source="t", limits=read_limits(["overturning"])))
    assert row["median_if_not"] == pytest.approx(other["median"][0], rel=1e-9)
    assert plain["median"][0] == row["median"] < other["median"][0]
    assert row["median_p05"] <= plain["median_p05"][0]
    assert row["median_p95"] >= other["median_p95"][0]


def test_lanes_that_cannot_be_used_are_left_out_and_counted_by_status(
    tmp_path: pathlib.Path, unrendered: None
):
    table = lane_table()
    table.loc[:29, "status"] = "nonfinite"
    table.loc[30:39, "status"] = "unstable"
    table.to_parquet(tmp_path / "lanes.parquet")
    (curve,) = fragility_curves(table, source="t", limits=read_limits(["0.5"]))
    assert curve.left_out == {"nonfinite": 30, "unstable": 10}
    assert curve.seen.count.sum() == 360
    result = run(str(tmp_path), "-o", str(tmp_path / "out"))
    assert "Left out: 40 lanes" in result.stdout
    assert "nonfinite 30, unstable 10" in result.stdout
    written = pd.read_csv(tmp_path / "out" / "fragility.csv")
    assert written["left_out_as"][0] == "nonfinite 30, unstable 10"


def test_too_many_lanes_in_doubt_are_refused_unless_asked_for(tmp_path: pathlib.Path):
    table = lane_table()
    table.loc[::4, "status"] = "sensitive"
    table["peak_rotation_error_rad"] = np.where(table["status"] == "sensitive", 2.0, 1e-5)
    table.to_parquet(tmp_path / "lanes.parquet")
    result = run(str(tmp_path), "--limit", "overturning")
    assert result.exit_code == 2
    assert result.stderr.count("\n") == 1
    assert "100 of 400 lanes (in doubt: sensitive 100)" in result.stderr
    assert "at most 20 %" in result.stderr
    asked = run(str(tmp_path), "--limit", "overturning", "--max-doubt", "0.3", "--json")
    assert asked.exit_code == 0
    found = json.loads(asked.stdout)
    assert found["curves"][0]["in_doubt"] == 100
    assert "finest run" in found["rule"]
    assert "in doubt" in run(str(tmp_path), "--limit", "overturning", "--max-doubt", "1").stdout


def test_a_table_without_an_estimate_and_few_records_say_so(
    tmp_path: pathlib.Path, unrendered: None
):
    table = lane_table()
    table.to_parquet(tmp_path / "lanes.parquet")
    assert json.loads(run(str(tmp_path), "--json").stdout)["warnings"] == []
    table["record"] = np.arange(400) % 8
    table.drop(columns="peak_rotation_error_rad").to_parquet(tmp_path / "lanes.parquet")
    first, second = json.loads(run(str(tmp_path), "--json").stdout)["warnings"]
    assert "no estimate of errors" in first
    assert "8 records" in second
    assert "Note: 8 records" in run(str(tmp_path)).stdout


def test_the_slide_is_a_limit_state(tmp_path: pathlib.Path, unrendered: None):
    table = lane_table()
    table.to_parquet(tmp_path / "lanes.parquet")
    out = tmp_path / "out"
    result = run(str(tmp_path), "--limit-slide", "10 mm", "--limit-slide", "0.03 m", "-o", str(out))
    assert result.exit_code == 0, result.output
    written = pd.read_csv(out / "fragility.csv")
    assert written["limit_state"].tolist() == ["slide 10 mm", "slide 0.03 m"]
    fell = table["outcome"] == "overturned"
    for row, slide in enumerate((0.01, 0.03)):
        assert written["reached"][row] == ((table["peak_slide_m"] >= slide) | fell).sum()
    component = pd.read_csv(out / "fragility-p58.csv")
    assert component["LS1-Name"][0] == "slide 10 mm"
    assert component["LS1-Theta_0"][0] == pytest.approx(written["median"][0])
    assert (out / "fragility.png").exists()


def test_a_stack_slides_with_its_worst_block():
    table = (
        lane_table().assign(outcome="rocking").rename(columns={"peak_slide_m": "peak_slide_1_m"})
    )
    table["peak_slide_2_m"] = 0.5
    (limit,) = read_limits([], ["20 cm"])
    assert find_reached(table, limit).all()
    assert not find_reached(table.assign(peak_slide_2_m=0.0), limit).any()


@pytest.mark.parametrize("text", ["10", "0 mm", "-3 mm", "3 s", "far"])
def test_slides_that_are_none_are_refused(text: str):
    with pytest.raises(InputError, match=r"--limit-slide: got .*must be"):
        read_limits([], [text])
    with pytest.raises(InputError, match="once"):
        read_limits([], ["1 mm", "1 mm"])


@pytest.mark.parametrize(
    ("drop", "arguments"),
    [
        ("peak_rotation_ratio", ("--limit", "0.35")),
        ("peak_slide_m", ("--limit-slide", "1 mm")),
        ("outcome", ()),
        ("status", ()),
        ("uplift_time_s", ()),
    ],
)
def test_a_table_without_a_column_that_is_needed_is_refused_in_a_line(
    drop: str, arguments: tuple[str, ...], tmp_path: pathlib.Path
):
    lane_table().drop(columns=drop).to_parquet(tmp_path / "lanes.parquet")
    result = run(str(tmp_path), *arguments)
    assert result.exit_code == 2
    assert result.stderr.count("\n") == 1
    assert drop in result.stderr
    text = lane_table().assign(**{drop: "text"})
    if drop in ("peak_rotation_ratio", "peak_slide_m", "uplift_time_s"):
        text.to_parquet(tmp_path / "lanes.parquet")
        result = run(str(tmp_path), *arguments)
        assert (result.exit_code, result.stderr.count("\n")) == (2, 1)
        assert "must be a column of numbers" in result.stderr


def run(*arguments: str) -> Result:
    return invoke("fragility", *arguments)


def test_a_lane_whose_run_ended_too_early_is_in_doubt_of_what_it_had_not_reached():
    lanes = lanes_like(undecided=True, peak_rotation_ratio=0.4, peak_rotation_error_rad=1e-9)
    asked = read_limits(["uplift", "0.0001", "0.9", "overturning"])
    assert [bool(in_doubt(lanes, limit)[0]) for limit in asked] == [False, False, True, True]
