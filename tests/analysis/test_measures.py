"""Measures: factors on the yearly rate are those of rates that are found one by one."""

from __future__ import annotations

import json
import pathlib

import numpy as np
import pytest

import warprock as wr
from tests.shared.commands import invoke, succeed
from warprock.analysis import measures
from warprock.analysis.bands import ratio_interval
from warprock.analysis.risk import rates_of
from warprock.case.lanes import expand_lanes
from warprock.case.load import changed, load_case

pytestmark = pytest.mark.usefixtures("pages_bare")

ONE = {"motion.scale": 1.0, "block.width": "0.5 m", "run.duration": "25 s"}
LAW = {"k0": 1e-3, "k": 2.0, "im": "PGA"}
LADDER = {"from_": 0.2, "to": 10.0, "count": 9, "accuracy": 0.2}
QUIET = {**LADDER, "progress": False}
CASE = "fragility-five-blocks"


def rate(changes: dict[str, object]) -> wr.Found:
    """The rate of the block with some changes, by `ida` and `risk`."""
    ida = wr.ida(CASE, "housner", overrides={**ONE, **changes}, **QUIET)
    return wr.risk(ida, **LAW)


def test_the_factor_is_the_rate_with_a_measure_over_that_without():
    found = wr.measures(
        CASE, "housner", overrides=ONE, measure=["block.width=0.6 m", "block.height=1.6 m"],
        **LAW, **QUIET,
    )  # fmt: skip
    base, wide = rate({}), rate({"block.width": "0.6 m"})
    row = found.table.set_index("measure").loc["block.width=0.6 m"]
    assert row["rate_per_year"] == wide.table["rate_per_year"].iloc[0]
    wanted = wide.table["rate_per_year"].iloc[0] / base.table["rate_per_year"].iloc[0]
    assert row["factor"] == pytest.approx(wanted, rel=1e-12)
    assert row["factor_p05"] < row["factor"] < row["factor_p95"]
    assert found.table["factor"].is_monotonic_increasing
    assert len(found.figures()) == 1
    # With the band of each rate alone the factor would be known far worse.
    ends = [np.log(each.found[0].band[1] / each.found[0].band[0]) for each in (base, wide)]
    assert np.log(row["factor_p95"] / row["factor_p05"]) < np.hypot(*ends)


def test_the_factor_of_nothing_is_one_and_its_band_a_point():
    (risk,) = rate({}).found
    band = risk.function.band

    def number(median: np.ndarray, spread: np.ndarray) -> np.ndarray:
        return rates_of(risk.hazard, median, spread)

    assert ratio_interval(band, band, number) == (1.0, 1.0)


@pytest.mark.thorough
def test_a_box_with_no_ballast_falls_as_the_box(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(measures, "BALLAST", 0.0)
    case = changed(load_case(CASE, ONE), {})
    (ballast,) = [
        each for each in measures.usual_measures(case, "housner") if "ballast" in each.name
    ]
    base, same = rate({}), wr.ida(CASE, "housner", overrides=ONE | ballast.changes, **QUIET)
    again = wr.risk(same, **LAW)
    # The same block told another way: brackets may differ by a step where a fall is close.
    wanted = base.table["rate_per_year"].iloc[0]
    assert again.table["rate_per_year"].iloc[0] == pytest.approx(wanted, rel=0.05)


def test_the_usual_measures_are_those_that_the_block_can_have():
    box = load_case(CASE, ONE)
    names = [each.name for each in measures.usual_measures(box, "housner")]
    assert [name.split()[0] for name in names] == [
        *("base", "base", "base", "ballast", "straps", "isolator", "floor"),
    ]
    slid = [each.name for each in measures.usual_measures(box, "event")]
    assert slid[-2:] == ["friction 0.5 times", "friction 1.5 times"]


def test_what_an_engine_cannot_do_is_said_beside_the_others():
    found = wr.measures(
        CASE, "housner", overrides=ONE, measure=["contact.friction=0.1", "block.width=0.55 m"],
        **LAW, **QUIET,
    )  # fmt: skip
    row = found.table.set_index("measure").loc["contact.friction=0.1"]
    assert np.isnan(row["factor"])
    assert "housner needs friction" in row["why"]
    assert "1 measure could not be judged" in " ".join(found.finding.sentences)


@pytest.mark.thorough
def test_the_width_that_meets_a_rate_lies_in_its_bracket(tmp_path: pathlib.Path):
    options = ("-e", "housner", "-s", "motion.scale=1", "-s", "block.width=0.5 m")
    options += ("-s", "run.duration=25 s", "--from", 0.2, "--count", 9, "--accuracy", 0.2)
    asked = ("--k0", 1e-3, "--k", 2, "--measure", "block.width=0.6 m", "--target", 8e-4)
    done = succeed("measures", CASE, *options, *asked, "--json", "-o", tmp_path)
    said = json.loads(done.stdout)
    low, high = said["width_low_m"], said["width_high_m"]
    assert 0.5 <= low < high <= 1.01 * low
    ends = [rate({"block.width": f"{width:.12g} m"}) for width in (low, high)]
    rates = [each.table["rate_per_year"].iloc[0] for each in ends]
    assert rates[0] > 8e-4 >= rates[1]
    (tmp_path / "report.html").unlink()
    succeed("report", tmp_path)
    # The least straps, likewise.
    low, high = said["tie_low_share"], said["tie_high_share"]
    assert 0.01 <= low < high <= 1.01 * low
    assert not said["tie_why"]
    row = expand_lanes(load_case(CASE, ONE), range(1)).inputs.iloc[0]
    mass = float(row["density_kg_m3"] * row["depth_m"]) * 0.5 * float(row["height_m"])
    for share, met in ((low, False), (high, True)):
        # The same to the last digit: stronger straps may do less, and do so step by step.
        tied = rate(measures._straps(mass, float(row["height_m"]), share))
        assert (tied.table["rate_per_year"].iloc[0] <= 8e-4) == met


@pytest.mark.thorough
def test_a_block_that_has_ties_is_given_no_others():
    quick = {**LADDER, "count": 5, "accuracy": 0.3, "progress": False}
    tied = {**ONE, **measures._straps(600.0, 1.5, 0.05)}
    found = wr.measures(
        CASE, "housner", overrides=tied, measure="block.width=0.6 m", target=8e-4, **LAW, **quick
    )
    target = found.found.target
    assert 0.5 < target.width.high <= 1.01 * target.width.low
    assert target.tie.why == "the block has ties already"
    assert "Which straps do so is not known" in " ".join(found.finding.sentences)
    met = wr.measures(
        CASE, "housner", overrides=ONE, measure="block.width=0.6 m", target=1.0, **LAW, **quick
    )
    assert (met.found.target.width.high, met.found.target.tie.high) == (0.5, 0.0)
    assert "As wide as it is, and without straps" in " ".join(met.finding.sentences)


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ((), "--hazard: got nothing, must be a file"),
        (("--k0", 1e-3, "--k", 2, "--target", -1), "--target: got -1.0, must be a rate above 0"),
        (("--k0", 1e-3, "--k", 2, "--measure", "wider"), "--measure: got 'wider', must be KEY="),
        (("--k0", 1e-3, "--k", 2, "--measure", "block.wide=1 m"), "block.wide: got '1 m', unknown"),
        (("--k0", 1e-3, "--k", 2, "--count", 1), "--count: got 1, must be from 2"),
    ],
)
def test_what_cannot_be_asked_is_refused(asked: tuple[object, ...], said: str):
    done = invoke("measures", CASE, "-s", "motion.scale=1", "-e", "housner", *asked)
    assert done.exit_code == 2
    assert said in done.output


def test_a_block_that_never_falls_has_no_rate_to_lower():
    done = invoke(
        "measures", "record-ridgecrest", "-s", "motion.scale=0.01", "-e", "housner", "--k0", 1e-3,
        "--k", 2, "--to", 1,
    )  # fmt: skip
    assert done.exit_code == 2
    assert "must have a rate to lower" in done.output
