"""Yearly rates: closed forms, bands, ends of the hazard, what an age allows, the command."""

from __future__ import annotations

import json
import pathlib

import numpy as np
import pandas as pd
import pytest
from scipy.integrate import quad
from scipy.special import ndtr

import warprock as wr
from tests.shared.commands import invoke, succeed
from tests.shared.fragility_studies import stripes
from warprock.analysis.hazard import Hazard, hazard_table, power_law
from warprock.analysis.lognormal import Fit, Verdict
from warprock.analysis.risk import (
    Function,
    allowed_hazard,
    allowed_rate,
    assess,
    chance_within,
    contributions,
    rates_of,
)
from warprock.errors import InputError

pytestmark = pytest.mark.usefixtures("pages_bare")

PGA = "peak_acceleration_m_s2"
FIT = Fit(Verdict.FITTED, 0.5, 0.4)
OVERTURNING = Function({}, "overturning", FIT)
LAW = power_law("a law", PGA, 1e-4, 2.0, 1.0)


def table(last: int = 8) -> Hazard:
    """A hazard curve that is no power law."""
    at = np.array([0.01, 0.05, 0.1, 0.3, 0.7, 1.0, 2.0, 4.0])[:last]
    rate = np.array([0.5, 0.2, 0.05, 0.01, 1e-3, 3e-4, 1e-5, 2e-7])[:last]
    return hazard_table("a table", PGA, at, rate)


def lanes(records: int = 12, seed: int = 3) -> pd.DataFrame:
    """A lane table of a known fragility."""
    intensity, reached, record = stripes(records, seed)
    return pd.DataFrame(
        {
            PGA: intensity,
            "record": record,
            "outcome": np.where(reached, "overturned", "at_rest"),
            "status": "ok",
            "peak_rotation_ratio": np.where(reached, 2.0, 0.1),
            "uplift_time_s": 1.0,
        }
    )


def test_a_power_law_gives_the_closed_form():
    found = assess(OVERTURNING, LAW)
    # k0 th^-k exp(k^2 b^2 / 2) = 4e-4 exp(0.32)
    assert found.rate == pytest.approx(5.508511e-4, rel=5e-8)
    assert found.rate == pytest.approx(4e-4 * np.exp(0.32), rel=1e-14)
    assert chance_within(found.rate, 50.0) == pytest.approx(0.0271667, abs=5e-8)
    assert np.exp(-found.rate * 1e4) == pytest.approx(0.00405214, abs=5e-9)
    assert (found.below, found.beyond) == (0.0, 0.0)


def test_pieces_are_the_integral_over_the_hazard():
    hazard = table()
    parts = contributions(hazard, FIT)
    for piece in range(1, len(parts) - 1):
        slope, log_size = hazard.slope[piece], hazard.log_size[piece]

        def added(u: float, slope: float = slope, log_size: float = log_size) -> float:
            score = (u - np.log(FIT.median)) / FIT.dispersion
            return float(ndtr(score) * slope * np.exp(log_size - slope * u))

        ends = np.log(hazard.edges[piece - 1 : piece + 1])
        wanted = quad(added, *ends, epsabs=0.0, epsrel=1e-11)[0]
        # The quadrature is asked for 1e-11; where P is small the closed form takes differences.
        assert parts[piece] == pytest.approx(wanted, rel=1e-10)


def test_a_power_law_in_pieces_is_the_same():
    at = np.geomspace(0.01, 50.0, 40)
    whole = assess(OVERTURNING, LAW)
    cut = hazard_table("cut", PGA, at, LAW.rate(at))
    assert assess(OVERTURNING, cut).rate == pytest.approx(whole.rate, rel=1e-12)
    assert LAW.cut(at).rate(at) == pytest.approx(LAW.rate(at), rel=1e-12)
    assert contributions(LAW.cut(at), FIT).sum() == pytest.approx(whole.rate, rel=1e-12)


@pytest.mark.parametrize("dispersion", [1e-6, 0.01, 3.0])
def test_a_steep_and_a_flat_function_lose_no_digits(dispersion: float):
    fit = Fit(Verdict.FITTED, 0.5, dispersion)
    law = power_law("steep", PGA, 1e-4, 6.0, 1.0)
    wanted = 1e-4 * 0.5**-6 * np.exp(0.5 * (6.0 * dispersion) ** 2)
    assert assess(Function({}, "overturning", fit), law).rate == pytest.approx(wanted, rel=1e-12)
    # Nearly a step: the rate at which its median is exceeded.
    if dispersion < 1e-3:
        assert wanted == pytest.approx(law.rate(np.array([0.5]))[0], rel=1e-10)


def test_intensities_that_contribute_are_quantiles_of_the_rate():
    found = assess(OVERTURNING, table())
    for share in (0.05, 0.5, 0.95):
        at = np.array([found.intensity_at(share)])
        hazard = found.hazard.cut(at)
        upto = np.append(hazard.edges, np.inf) <= at
        assert contributions(hazard, FIT)[upto].sum() / found.rate == pytest.approx(share, rel=1e-6)


def test_a_table_that_ends_too_early_is_refused_and_its_share_is_told():
    whole = assess(OVERTURNING, table())
    assert 0.0 < whole.beyond < 1e-3
    short = table(5)
    with pytest.raises(
        InputError, match=r"a table: .* got '23.* % of the rate of overturning from"
    ):
        assess(OVERTURNING, short)
    taken = assess(OVERTURNING, short, most_outside=1.0)
    # Motions beyond the end fall with a probability between that at the end and 1.
    beyond = taken.beyond * taken.rate
    assert ndtr(np.log(0.7 / 0.5) / 0.4) * 1e-3 < beyond < 1e-3
    late = hazard_table("late", PGA, np.array([0.5, 1.0, 4.0]), np.array([1e-2, 1e-3, 1e-6]))
    with pytest.raises(InputError, match="must tell of motions so weak"):
        assess(OVERTURNING, late)


def test_data_that_one_intensity_parts_have_the_rates_of_its_ends():
    fit = Fit(Verdict.SEPARATED, np.sqrt(0.5), 0.0, 0.5, 1.0)
    found = assess(Function({}, "overturning", fit), LAW)
    assert found.rate == pytest.approx(2e-4)
    assert found.band == pytest.approx((1e-4, 4e-4))
    none = assess(Function({}, "overturning", Fit(Verdict.NONE_REACHED, low=2.0)), LAW)
    assert np.isnan(none.rate)


def test_an_age_allows_a_hazard_that_does_not_contradict_it():
    age, unlikely = 1e4, 0.05
    at = np.geomspace(0.05, 5.0, 30)
    found = assess(OVERTURNING, LAW)
    allowed = allowed_hazard(FIT, at, age, unlikely)
    # Whatever the hazard, its rate is at least lambda(x) P(x): at the bound it stands as unlikely.
    np.testing.assert_allclose(np.exp(-allowed * FIT.probability(at) * age), unlikely, rtol=1e-12)
    assert (LAW.rate(at) * FIT.probability(at) <= found.rate).all()
    scaled = power_law("scaled", PGA, 1e-4 * allowed_rate(age) / found.rate, 2.0, 1.0)
    assert np.exp(-assess(OVERTURNING, scaled).rate * age) == pytest.approx(0.05, rel=1e-12)


def test_the_band_over_records_goes_through_to_the_rate():
    found = wr.risk(lanes(), k0=1e-3, k=2.0, at="1 m/s^2")
    (risk,) = found.found
    band = risk.function.band
    assert risk.band[0] < risk.rate < risk.band[1]
    whole = rates_of(risk.hazard, np.array([band.median]), np.array([band.dispersion]))
    assert risk.rate == pytest.approx(whole[0], rel=1e-12)
    few = wr.risk(lanes(6), k0=1e-3, k=2.0, at="1 m/s^2").found[0]
    assert np.log(few.band[1] / few.band[0]) > np.log(risk.band[1] / risk.band[0])
    none = wr.risk(lanes(4), k0=1e-3, k=2.0, at="1 m/s^2").found[0]
    assert np.isnan(none.band).all()


def test_several_objects_and_limit_states_stand_side_by_side(tmp_path: pathlib.Path):
    tables = {"statue": lanes(), "vase": lanes(seed=5)}
    found = wr.risk(tables, k0=1e-3, k=2.0, at="1 m/s^2", limit=["0.05", "overturning"])
    rows = found.table
    assert rows[["object", "limit_state"]].to_numpy().tolist() == [
        ["statue", "0.05"],
        ["statue", "overturning"],
        ["vase", "0.05"],
        ["vase", "overturning"],
    ]
    assert rows["verdict"].tolist() == ["all reached", "fitted", "all reached", "fitted"]
    assert rows["rate_per_year"].notna().tolist() == [False, True, False, True]
    alone = wr.risk(tables["vase"], k0=1e-3, k=2.0, at="1 m/s^2")
    assert rows["rate_per_year"].iloc[3] == alone.table["rate_per_year"].iloc[0]
    assert "(statue)" in found.finding.headline
    assert "(vase)" in found.finding.headline
    parts = found.tables["risk-contributions.csv"]
    shares = parts.groupby("object")["share"].sum()
    # The ranges leave out half a percent at each end.
    assert ((shares > 0.98) & (shares <= 1.0 + 1e-12)).all()
    assert found.save(tmp_path)[-1].name == "report.html"


def test_an_incremental_analysis_tells_the_rate_over_any_measure_that_grows_with_its_factor():
    asked = {"count": 9, "accuracy": 0.05, "progress": False}
    over = {"motion.scale": 1.0, "run.duration": "20 s"}
    ida = wr.ida("fragility-five-blocks", "housner", by="block", **asked, overrides=over)
    by_pga = wr.risk(ida, k0=1e-4, k=2.0, by="block", max_outside=1.0).table
    by_pgv = wr.risk(ida, k0=1e-4, k=2.0, im="PGV", at="50 cm/s", by="block").table
    assert by_pga["block"].tolist() == by_pgv["block"].tolist()
    groups = ida.tables["fragility"].set_index("block")
    np.testing.assert_allclose(
        by_pga.set_index("block")["median"], groups["median"].loc[by_pga["block"]], rtol=1e-12
    )
    assert (by_pgv["rate_per_year"] > 0.0).any()
    with pytest.raises(InputError, match=r"limit: got '0\.3', must be overturning"):
        wr.risk(ida, k0=1e-4, k=2.0, limit="0.3")


def test_the_command_prints_what_the_function_finds(tmp_path: pathlib.Path):
    lanes().to_parquet(tmp_path / "lanes.parquet")
    hazard = tmp_path / "hazard.csv"
    at = np.geomspace(0.05, 20.0, 12)
    rate = 1e-3 * at**-2.0
    rows = "".join(f"{x!r},{y!r}\n" for x, y in zip(at.tolist(), rate.tolist(), strict=True))
    hazard.write_text(f"PGA [m/s^2],annual_rate\n{rows}", encoding="utf-8")
    asked = ("--hazard", hazard, "--years", 10, "--years", 100, "--survived", "10 ka")
    said = json.loads(succeed("risk", tmp_path, *asked, "--json").stdout)
    (row,) = said["risks"]
    law = wr.risk(lanes(), k0=1e-3, k=2.0, at="1 m/s^2", years=[10, 100], survived="10 ka")
    assert row["rate_per_year"] == pytest.approx(law.table["rate_per_year"].iloc[0], rel=1e-9)
    assert [each["within_years"] for each in said["chances"]] == [10.0, 100.0]
    assert row["survival"] == pytest.approx(np.exp(-1e4 * row["rate_per_year"]))
    printed = succeed("risk", tmp_path, *asked, "-o", tmp_path / "out").stdout
    assert "rules the hazard out at 5 %" in printed
    kept = {path.name for path in (tmp_path / "out").iterdir()}
    assert {"risk.csv", "risk-allowed.csv", "risk-hazard.csv", "risk.png", "report.html"} <= kept
    page = succeed("report", tmp_path / "out")
    assert page.exit_code == 0


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ((), "--hazard: got nothing, must be a file, or have --k0 and --k instead"),
        (("--k0", 1e-4), "--k: got nothing, must be given, too"),
        (("--k0", -1.0, "--k", 2), "--k0: got -1.0, must be finite and > 0"),
        (("--k0", 1e-4, "--k", 2, "--im", "PGV"), "--at: peak_velocity_m_s: got '1 g', must be in"),
        (("--k0", 1e-4, "--k", 2, "--im", "speed", "--at", "1 m"), "speed: got '1 m', must be in"),
        (
            ("--k0", 1e-4, "--k", 2, "--im", "x_m", "--at", "1 m"),
            "got 'x_m', must be over a column",
        ),
        (("--k0", 1e-4, "--k", 2, "--years", 0), "--years: got 0.0, must be a number of years"),
        (("--k0", 1e-4, "--k", 2, "--survived", "10"), "--survived: got '10', must be an age"),
        (("--k0", 1e-4, "--k", 2, "--unlikely", 1), "--unlikely: got 1.0, must be"),
        (("--k0", 1e-4, "--k", 2, "--max-outside", 2), "--max-outside: got 2.0, must be"),
    ],
)
def test_what_cannot_be_asked_is_refused(
    asked: tuple[object, ...], said: str, tmp_path: pathlib.Path
):
    lanes().to_parquet(tmp_path / "lanes.parquet")
    done = invoke("risk", tmp_path, *asked)
    assert done.exit_code == 2
    assert said in done.output


def test_a_spectral_acceleration_must_have_the_period_of_the_hazard(tmp_path: pathlib.Path):
    rows = lanes().rename(columns={PGA: "spectral_acceleration_m_s2"}).assign(sa_period_s=0.5)
    curve = "SA({}) [m/s^2],annual_rate\n0.01,1\n0.1,1e-1\n1,1e-3\n10,1e-6\n"
    paths = {}
    for period in ("0.5", "1.0"):
        paths[period] = tmp_path / f"{period}.csv"
        paths[period].write_text(curve.format(period), encoding="utf-8")
    assert wr.risk(rows, hazard=paths["0.5"]).table["rate_per_year"].iloc[0] > 0.0
    with pytest.raises(InputError, match=r"sa_period_s: got '0\.5', must be that of .*, 1 s"):
        wr.risk(rows, hazard=paths["1.0"])
