"""Fragility functions as pelicun and OpenQuake read them: small readers after their schemas."""

from __future__ import annotations

import csv
import json
import os
import pathlib
import re
import subprocess
import xml.etree.ElementTree as ElementTree

import numpy as np
import pandas as pd
import pytest
from scipy.stats import lognorm

import warprock as wr
from tests.analysis.test_predictors import lanes as two_measures
from tests.shared.commands import succeed
from tests.shared.fragility_studies import stripes
from warprock.analysis.exports import _function_ids, component_rows, nrml_text
from warprock.analysis.fragility import fragility_curves
from warprock.analysis.limits import read_limits
from warprock.analysis.predictors import compare_measures, slices
from warprock.errors import InputError
from warprock.units import GRAVITY

pytestmark = pytest.mark.usefixtures("pages_bare")

PGA, PGV, SA = "peak_acceleration_m_s2", "peak_velocity_m_s", "spectral_acceleration_m_s2"


def lanes() -> pd.DataFrame:
    """Two groups of lanes, the second of which falls at double the intensity."""
    intensity, reached, record = stripes(12, seed=3)
    table = pd.DataFrame(
        {
            PGA: intensity,
            PGV: 0.1 * intensity,
            SA: 2.0 * intensity,
            "sa_period_s": 0.5,
            "record": record,
            "block": "tall-vase",
            "outcome": np.where(reached, "overturned", "at_rest"),
            "status": "ok",
            "peak_rotation_ratio": np.where(reached, 2.0, np.minimum(0.9, 0.4 * intensity)),
            "uplift_time_s": np.where(intensity > 0.4, 1.0, np.nan),
        }
    )
    strong = table.assign(block="low-vase", **{name: 2.0 * table[name] for name in (PGA, PGV, SA)})
    return pd.concat([table, strong], ignore_index=True)


def read_nrml(text: str) -> dict[str, dict[str, tuple[str, float, float]]]:
    """Functions by name and limit state: measure, mean and standard deviation.

    What the engine's reader asks for: `fragilityModel` with its attributes, `description` and
    `limitStates` before the functions, each with `imls` and one `params` a limit state in order.
    """
    space = "{http://openquake.org/xmlns/nrml/0.5}"
    (model,) = ElementTree.fromstring(text)
    assert model.tag == f"{space}fragilityModel"
    assert {"id", "assetCategory", "lossCategory"} <= set(model.keys())
    description, states, *functions = model
    assert (description.tag, states.tag) == (f"{space}description", f"{space}limitStates")
    limits = str(states.text).split()
    assert all(name.isidentifier() for name in limits)
    found: dict[str, dict[str, tuple[str, float, float]]] = {}
    for function in functions:
        assert function.tag == f"{space}fragilityFunction"
        assert (function.get("format"), function.get("shape")) == ("continuous", "logncdf")
        imls, *params = function
        assert float(imls.get("minIML", "")) < float(imls.get("maxIML", ""))
        assert [each.get("ls") for each in params] == limits
        found[function.get("id", "")] = {
            limit: (
                imls.get("imt", ""),
                float(each.get("mean", "")),
                float(each.get("stddev", "")),
            )
            for limit, each in zip(limits, params, strict=True)
        }
    return found


def chance(mean: float, deviation: float, intensity: float) -> float:
    """The probability as the engine computes it of mean and standard deviation."""
    variance = deviation**2
    sigma = np.sqrt(np.log(variance / mean**2 + 1.0))
    return float(lognorm.cdf(intensity, sigma, scale=mean**2 / np.sqrt(variance + mean**2)))


def read_components(path: pathlib.Path) -> dict[str, dict[tuple[str, str], str]]:
    """Rows by ID; columns as pairs, which pelicun makes of names by splitting them at a hyphen."""
    with path.open(encoding="utf-8", newline="") as file:
        heads, *rows = list(csv.reader(file))
    pairs = [tuple((*head.split("-"), "")[:2]) for head in heads]
    assert all(head.count("-") <= 1 for head in heads)
    found = {}
    for row in rows:
        values = {(pair[0], pair[1]): cell for pair, cell in zip(pairs, row, strict=True)}
        name = values.pop(("ID", ""))
        assert "-" not in name
        found[name] = values
    return found


@pytest.mark.parametrize(
    ("intensity", "imt", "size"), [(PGA, "PGA", 9.81), (PGV, "PGV", 0.01), (SA, "SA(0.5)", 9.81)]
)
def test_openquake_computes_our_probabilities(intensity: str, imt: str, size: float):
    limits = read_limits(["0.5", "overturning"])
    curves = fragility_curves(lanes(), source="t", intensity=intensity, limits=limits, by=["block"])
    found = read_nrml(nrml_text(curves, intensity, 0.5))
    assert list(found) == ["block_tall-vase", "block_low-vase"]
    for curve in curves:
        limit = "rotation_0_5" if curve.limit.ratio else "overturning"
        name, mean, deviation = found[curve.group_text.replace(" ", "_")][limit]
        assert name == imt
        for score in (-2.0, 0.0, 1.5):
            at = curve.fit.median * np.exp(score * curve.fit.dispersion)
            ours = curve.fit.probability(np.array([at]))[0]
            assert chance(mean, deviation, at / size) == pytest.approx(ours, rel=1e-9)


def test_a_measure_that_openquake_does_not_know_makes_no_model():
    table = lanes().assign(factor=lambda each: each[PGA])
    curves = fragility_curves(
        table, source="t", intensity="factor", limits=read_limits(["overturning"])
    )
    assert nrml_text(curves, "factor") == ""
    rows = component_rows(curves, "factor")
    assert rows[["Demand-Type", "Demand-Unit"]].to_numpy().tolist() == [["factor", "unitless"]]


def test_a_group_without_a_function_is_left_out_of_the_model():
    table = lanes()
    table.loc[table["block"] == "low-vase", "outcome"] = "at_rest"
    table.loc[table["block"] == "low-vase", "peak_rotation_ratio"] = 0.1
    curves = fragility_curves(table, source="t", limits=read_limits(["overturning"]), by=["block"])
    text = nrml_text(curves, PGA)
    assert list(read_nrml(text)) == ["block_tall-vase"]
    assert "left out for want of a function: 1 groups" in text
    assert component_rows(curves, PGA)["Incomplete"].tolist() == [0, 1]


def test_what_one_intensity_parts_is_deterministic_in_the_table_and_no_limit_of_the_model():
    limits = read_limits(["uplift", "overturning"])
    table = lanes().query("block == 'tall-vase'")
    curves = fragility_curves(table, source="t", limits=limits)
    row = component_rows(curves, PGA).iloc[0]
    assert (row["Incomplete"], row["LS1-Family"]) == (0, "deterministic")
    # Lanes lift above 0.4 m/s^2; of those that ran the nearest are at 0.389 and 0.542.
    assert 0.4 * 0.9 < row["LS1-Theta_0"] < 0.542
    assert list(read_nrml(nrml_text(curves, PGA))["block"]) == ["overturning"]


READERS = os.environ.get("WARPROCK_READERS", "")
"""The Python that has pelicun and OpenQuake, as `.ci/outside` makes it."""
extra = pytest.mark.skipif(not READERS, reason="WARPROCK_READERS names no Python: .ci/outside does")


def theirs(*asked: object) -> dict[str, dict]:
    """What a program of others reads in a file of ours."""
    script = pathlib.Path(__file__).parents[1] / "shared" / "readers.py"
    done = subprocess.run(
        [READERS, "-I", script, *map(str, asked)], capture_output=True, text=True, check=True
    )
    return json.loads(done.stdout.splitlines()[-1])


@pytest.mark.extra
@extra
def test_pelicun_reads_our_table(tmp_path: pathlib.Path):
    limits = read_limits(["uplift", "0.5", "overturning"])
    rows = component_rows(fragility_curves(lanes(), source="t", limits=limits, by=["block"]), PGA)
    path = tmp_path / "fragility-p58.csv"
    rows.to_csv(path, index=False)
    found = theirs("pelicun", path)
    assert set(found) == set(rows["ID"])
    for _, row in rows.iterrows():
        for key in ("LS2-Theta_0", "LS3-Theta_0", "LS3-Theta_1"):
            # Their base unit is that of the table, m/s^2.
            assert found[row["ID"]][key] == pytest.approx(row[key], rel=1e-12)


@pytest.mark.extra
@extra
@pytest.mark.parametrize(("intensity", "imt", "size"), [(PGA, "PGA", GRAVITY), (PGV, "PGV", 0.01)])
def test_openquake_finds_our_probabilities(
    intensity: str, imt: str, size: float, tmp_path: pathlib.Path
):
    limits = read_limits(["0.5", "overturning"])
    curves = fragility_curves(lanes(), source="t", intensity=intensity, limits=limits, by=["block"])
    path = tmp_path / "fragility.xml"
    path.write_text(nrml_text(curves, intensity), encoding="utf-8")
    middle = curves[0].fit.median / size
    levels = [0.5 * middle, middle, 2.0 * middle]
    found = theirs("openquake", path, *levels)
    assert set(found) == {"block_tall-vase", "block_low-vase"}
    for curve in curves:
        function = found[curve.group_text.replace(" ", "_")]
        assert function["imt"] == imt
        assert function["limits"] == ["rotation_0_5", "overturning"]
        ours = curve.fit.probability(np.array(levels) * size)
        number = function["limits"].index("rotation_0_5" if curve.limit.ratio else "overturning")
        np.testing.assert_allclose(function["chances"][number], ours, rtol=1e-9)


@pytest.mark.extra
@extra
def test_openquake_finds_slices_of_two_measures(tmp_path: pathlib.Path):
    table = two_measures()
    found = compare_measures(
        table, source="t", measures=[PGV], limit=read_limits(["overturning"])[0], most_doubt=0.2
    )
    first, cut = slices(found)
    path = tmp_path / "predictors.xml"
    path.write_text(nrml_text(cut, first), encoding="utf-8")
    levels = [20.0, 60.0, 200.0]
    read = theirs("openquake", path, *levels)
    assert len(read) == len(cut) == 5
    for each, function in zip(cut, read.values(), strict=True):
        wanted = each.fit.probability(np.array(levels) * 0.01)
        np.testing.assert_allclose(function["chances"][0], wanted, rtol=1e-9)


def test_names_of_functions_are_those_that_openquake_takes():
    """Its reader refuses others: ^[\\w_\\-:]+$, 75 letters at most."""
    names = ["block tall-vase", "block tall.vase", "x" * 90, "x" * 91, "größe 1.5"]
    found = _function_ids(names)
    assert len(set(found)) == len(names)
    assert all(re.fullmatch(r"[A-Za-z0-9_:-]{1,75}", name) for name in found)
    assert found[:2] == ["block_tall-vase", "block_tall_vase"]


def test_the_command_writes_what_both_read_and_risk_reads_it_back(tmp_path: pathlib.Path):
    lanes().to_parquet(tmp_path / "lanes.parquet")
    out = tmp_path / "out"
    asked = ("--by", "block", "--limit", "overturning")
    succeed("fragility", tmp_path, *asked, "-o", out)
    fits = pd.read_csv(out / "fragility.csv")
    components = read_components(out / "fragility-p58.csv")
    assert list(components) == ["block tall_vase", "block low_vase"]
    for row, values in zip(fits.to_dict("records"), components.values(), strict=True):
        assert values["Demand", "Type"] == "Peak Ground Acceleration"
        assert values["Demand", "Unit"] == "mps2"
        assert values["Incomplete", ""] == "0"
        assert (values["Demand", "Offset"], values["Demand", "Directional"]) == ("0", "0")
        assert values["LS1", "Family"] == "lognormal"
        assert float(values["LS1", "Theta_0"]) == row["median"]
        assert float(values["LS1", "Theta_1"]) == row["dispersion"]
    found = read_nrml((out / "fragility.xml").read_text(encoding="utf-8"))
    assert len(found) == 2
    law = {"k0": 1e-3, "k": 2.0, "at": "1 m/s^2"}
    ours = wr.risk(out / "fragility-p58.csv", **law).table
    lanes_ = wr.risk(tmp_path, **law, by="block").table
    np.testing.assert_allclose(ours["rate_per_year"], lanes_["rate_per_year"], rtol=1e-12)
    page = (out / "report.html").read_text(encoding="utf-8")
    assert "peak base acceleration" in page


def test_functions_from_elsewhere_are_read_in_their_unit(tmp_path: pathlib.Path):
    path = tmp_path / "theirs.csv"
    head = "ID,Demand-Type,Demand-Unit,LS1-Family,LS1-Theta_0,LS1-Theta_1\n"
    path.write_text(f"{head}vase,Peak Ground Acceleration,g,lognormal,0.5,0.4\n", encoding="utf-8")
    found = wr.risk(path, k0=1e-4, k=2.0).table
    assert found[["component", "limit_state"]].to_numpy().tolist() == [["vase", "LS1"]]
    assert found["rate_per_year"].iloc[0] == pytest.approx(5.508511e-4, rel=5e-8)
    for text, said in (
        ("vase,Peak Ground Velocity,mps,lognormal,0.5,0.4", "Demand-Type: got 'Peak Ground Vel"),
        ("vase,Peak Ground Acceleration,inch,lognormal,0.5,0.4", "Demand-Unit: got 'inch', must"),
        ("vase,Peak Ground Acceleration,g,lognormal,-0.5,0.4", "LS1-Theta_0: got -0.5, must be a"),
        ("vase,Peak Ground Acceleration,g,normal,0.5,0.4", "limit: got '', must be a limit state"),
    ):
        path.write_text(f"{head}{text}\n", encoding="utf-8")
        with pytest.raises(InputError, match=said):
            wr.risk(path, k0=1e-4, k=2.0)
    path.write_text("a,b\n1,2\n", encoding="utf-8")
    with pytest.raises(InputError, match="ID: got nothing, must be a component table"):
        wr.risk(path, k0=1e-4, k=2.0)
