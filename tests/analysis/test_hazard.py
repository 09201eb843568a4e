"""Hazard curves: what is read from tables and OpenQuake's files, and what is refused."""

from __future__ import annotations

import hashlib
import pathlib
import re

import numpy as np
import pandas as pd
import pytest

from warprock.analysis.hazard import Hazard
from warprock.analysis.hazard_files import (
    hazard_names,
    parse_age,
    read_hazard,
    read_power_law,
)
from warprock.errors import InputError
from warprock.units import GRAVITY

ROOT = pathlib.Path(__file__).resolve().parents[2]
PGA, PGV = "peak_acceleration_m_s2", "peak_velocity_m_s"
CHANCES = (0.4553861, 0.05754043, 0.006354517)
"""Of exceeding 0.1, 0.4 and 0.6 g within a year, as OpenQuake writes them."""
OPENQUAKE = (
    "#,,,,,\"generated_by='OpenQuake engine 3.20.0', start_date='2024-06-03T09:36:04', "
    "checksum=2107362341, kind='mean', investigation_time={years}, imt='{imt}'\"\n"
    "lon,lat,depth,poe-0.1000000,poe-0.4000000,poe-0.6000000\n"
    "0.00000,0.00000,-0.10000,4.553861E-01,5.754043E-02,6.354517E-03\n"
)
SECOND_SITE = "0.10000,0.00000,-0.10000,1.522632E-01,1.000000E-03,0.000000E+00\n"
NRML = """<?xml version="1.0" encoding="utf-8"?>
<nrml xmlns:gml="http://www.opengis.net/gml" xmlns="http://openquake.org/xmlns/nrml/0.5">
  <hazardCurves sourceModelTreePath="b1" gsimTreePath="b1" investigationTime="50.0" IMT="PGV">
    <IMLs>10.0 40.0 60.0</IMLs>
    <hazardCurve>
      <gml:Point><gml:pos>-122.5 37.5</gml:pos></gml:Point>
      <poEs>0.4553861 0.05754043 0.006354517</poEs>
    </hazardCurve>
  </hazardCurves>
  <hazardCurves IMT="SA" saPeriod="0.5" saDamping="5.0" investigationTime="50.0">
    <IMLs>0.1 0.4 0.6</IMLs>
    <hazardCurve>
      <gml:Point><gml:pos>-122.5 37.5</gml:pos></gml:Point>
      <poEs>0.4553861 0.05754043 0.006354517</poEs>
    </hazardCurve>
  </hazardCurves>
</nrml>
"""


def kept(folder: pathlib.Path, text: str, name: str = "hazard.csv") -> str:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return str(path)


def assert_curve(found: Hazard, measure: str, values: list[float], rates: list[float]) -> None:
    assert found.measure == measure
    np.testing.assert_allclose(found.edges, values, rtol=1e-12)
    np.testing.assert_allclose(found.rate(np.array(values)), rates, rtol=1e-12)
    assert (found.start, found.end) == (found.edges[0], found.edges[-1])


@pytest.mark.parametrize(
    ("head", "values", "exceeded", "measure", "size"),
    [
        ("PGA [g],annual_rate", (0.1, 0.5), (1e-2, 1e-4), PGA, 9.81),
        ("pga_g,return_period_years", (0.1, 0.5), (100.0, 1e4), PGA, 9.81),
        ("peak_velocity_cm_s,annual rate [1/year]", (10, 50), (1e-2, 1e-4), PGV, 0.01),
        ("normalised_velocity,rate_per_year", (0.1, 0.5), (1e-2, 1e-4), "normalised_velocity", 1),
        (
            "PGV [m/s],poe_in_50_years",
            (0.1, 0.5),
            tuple(-np.expm1(-50.0 * np.array([1e-2, 1e-4]))),
            PGV,
            1.0,
        ),
    ],
)
def test_a_table_tells_its_measure_its_unit_and_how_it_counts(
    head: str,
    values: tuple[float, float],
    exceeded: tuple[float, float],
    measure: str,
    size: float,
    tmp_path: pathlib.Path,
):
    rows = "".join(f"{x!r},{y!r}\n" for x, y in zip(values, map(float, exceeded), strict=True))
    found = read_hazard(kept(tmp_path, f"# a remark\n{head}\n{rows}"))
    assert_curve(found, measure, [x * size for x in values], [1e-2, 1e-4])
    table = pd.DataFrame(dict(zip(head.split(","), (values, exceeded), strict=True)))
    assert_curve(read_hazard(table), measure, [x * size for x in values], [1e-2, 1e-4])


def test_rates_are_straight_over_logarithms_and_go_on_beyond_the_ends(tmp_path: pathlib.Path):
    text = "PGA [m/s^2],annual_rate\n1,1e-1\n2,1e-2\n8,1e-3\n"
    found = read_hazard(kept(tmp_path, text))
    middle = np.sqrt([0.5 * 1.0, 1.0 * 2.0, 2.0 * 8.0, 8.0 * 32.0])
    # A factor of two takes 10 before the second row, a factor of four from it on.
    wanted = [1e-1 * 10**0.5, 1e-2 * 10**0.5, 1e-3 * 10**0.5, 1e-3 * 10**-0.5]
    np.testing.assert_allclose(found.rate(middle), wanted, rtol=1e-12)
    np.testing.assert_allclose(found.cut(np.array([1.5, 4.0])).rate(middle), wanted, rtol=1e-12)


def test_openquakes_csv_is_read_with_its_investigation_time(tmp_path: pathlib.Path):
    text = OPENQUAKE.format(years="50.0", imt="PGA")
    rates = (-np.log1p(-np.array(CHANCES)) / 50.0).tolist()
    found = read_hazard(kept(tmp_path, text))
    assert_curve(found, PGA, [0.981, 3.924, 5.886], rates)
    path = kept(tmp_path, text + SECOND_SITE)
    assert_curve(read_hazard(f"{path}#1"), PGA, [0.981, 3.924, 5.886], rates)
    # Where nothing exceeds an intensity the curve ends before it.
    assert read_hazard(f"{path}#2").end == pytest.approx(3.924)
    with pytest.raises(InputError, match=r"must name one of its curves, FILE#NUMBER: 1 \(PGA at 0"):
        read_hazard(path)


def test_nrml_is_read_curve_by_curve(tmp_path: pathlib.Path):
    path = kept(tmp_path, NRML, "curves.xml")
    rates = (-np.log1p(-np.array(CHANCES)) / 50.0).tolist()
    assert_curve(read_hazard(f"{path}#PGV"), PGV, [0.1, 0.4, 0.6], rates)
    spectral = read_hazard(f"{path}#2")
    assert_curve(spectral, "spectral_acceleration_m_s2", [0.981, 3.924, 5.886], rates)
    assert spectral.period == 0.5


def test_a_power_law_is_read_with_its_unit():
    found = read_power_law(1e-4, 2.0, "50 cm/s", "PGV")
    assert found.measure == PGV
    np.testing.assert_allclose(found.rate(np.array([0.5, 1.0])), [1e-4, 2.5e-5], rtol=1e-12)
    with pytest.raises(
        InputError, match=r"--at: peak_acceleration_m_s2: got '50 cm/s', must be in"
    ):
        read_power_law(1e-4, 2.0, "50 cm/s", "PGA")
    with pytest.raises(InputError, match=r"--k: got 0\.0, must be finite and > 0"):
        read_power_law(1e-4, 0.0, "1 g", "PGA")


HEAD = "PGA [g],annual_rate\n"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("PGA [cm/s],annual_rate\n1,1\n2,.1\n", "peak_acceleration_m_s2: got 'cm/s', must be in"),
        ("PGA,annual_rate\n1,1\n2,.1\n", "peak_acceleration_m_s2: got '', must be in a unit"),
        ("PGA [furlong],annual_rate\n1,1\n2,.1\n", "PGA: got 'furlong', must be a unit"),
        (HEAD + "0.1,1e-2\n0.1,1e-3\n", "intensity: got 0.981, must be above that of the row"),
        (HEAD + "0.1,1e-3\n0.2,1e-2\n", "rate: got 0.01, must be at most that of the row"),
        (HEAD + "-0.1,1e-3\n0.2,1e-4\n", r"must be finite and > 0 \(row 1\)"),
        (HEAD + "0.1,1e-3\n0.2,-1e-4\n", r"rate: got -0.0001, must be finite and >= 0 \(row 2\)"),
        (HEAD + "0.1,often\n", "row 1: got '0.1,often', must be two numbers"),
        (HEAD + "0.1,1e-3\n", "rate: got 1 such row, must have at least 2 rows"),
        (HEAD, "got 0 rows, must have at least 2"),
        ("", "header: got '', must be two columns"),
        ("PGA [g],PGV [cm/s]\n1,2\n", r"header: got 'PGA \[g\],PGV \[cm/s\]', must be two columns"),
        ("PGA [g],chance_in_50_years\n0.1,1.2\n", r"got 1.2, must be a chance from 0 to 1 \(row 1"),
        (OPENQUAKE.format(years="-1", imt="PGA"), "investigation time: got '-1', must be a number"),
        (OPENQUAKE.format(years="1", imt="MMI"), "IMT: got 'MMI', must be a measure whose unit is"),
        ("<nrml>", r"got the file, must be XML \("),
        ("<nrml/>", "hazardCurves: got nothing, must hold hazard curves"),
    ],
)
def test_what_is_no_hazard_is_refused_in_a_line(text: str, said: str, tmp_path: pathlib.Path):
    path = kept(tmp_path, text)
    with pytest.raises(InputError, match=said) as error:
        read_hazard(path)
    assert str(error.value).startswith(path)
    assert "\n" not in str(error.value)


def test_a_file_that_is_not_there_is_named(tmp_path: pathlib.Path):
    with pytest.raises(InputError, match=r"--hazard: got '.*none.csv', must be a file \(no such"):
        read_hazard(tmp_path / "none.csv")
    with pytest.raises(InputError, match=r"or a shipped curve: usgs-2008-los-angeles, "):
        read_hazard("usgs-2008-los-angles")


def test_every_shipped_curve_is_in_the_notice_with_its_hash():
    folder = ROOT / "cases" / "hazards"
    lines = (folder / "NOTICE").read_text(encoding="utf-8").splitlines()
    listed = dict(reversed(line.split()) for line in lines if re.match(r"[0-9a-f]{64}  ", line))
    files = [path for path in folder.iterdir() if path.name != "NOTICE"]
    assert listed == {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in files}
    assert [f"{name}.csv" for name in hazard_names()] == sorted(listed)


@pytest.mark.parametrize("name", hazard_names())
def test_a_shipped_curve_is_a_hazard(name: str):
    found = read_hazard(name)
    assert (found.source, found.measure) == (name, PGA)
    assert found.start == pytest.approx(0.0025 * GRAVITY)
    assert found.end > 3.0 * GRAVITY


@pytest.mark.parametrize(
    ("place", "intensity"),
    [("los-angeles", 0.8932122811580905), ("seattle", 0.568659949982634)],
)
def test_the_rate_between_rows_is_that_of_the_program_of_the_curve(place: str, intensity: float):
    # What its deaggregation for a return period of 2475 years says of the same curve.
    found = read_hazard(f"usgs-2008-{place}").rate(np.array([intensity * GRAVITY]))
    # Rows have 9 digits, of which the logarithm between two of them keeps some 8.
    assert found[0] == pytest.approx(1.0 / 2475.0, rel=1e-7)


def test_ages_have_units():
    assert [parse_age("--survived", text) for text in ("500 years", "10 ka", "2 Ma")] == [
        500.0,
        1e4,
        2e6,
    ]
    for text in ("10", "10 s", "-1 ka"):
        with pytest.raises(InputError, match=f"--survived: got '{text}', must be"):
            parse_age("--survived", text)
