"""Weights of records: what they do to a fit, its band and a rate, and what is refused."""

from __future__ import annotations

import json
import pathlib

import numpy as np
import pandas as pd
import pytest

import warprock as wr
from tests.analysis.test_risk import PGA, lanes
from tests.shared.commands import invoke, succeed

LAW = {"k0": 1e-3, "k": 2.0, "at": "1 m/s^2"}
OVERTURNING = {"limit": "overturning"}


def named(records: int = 12) -> pd.DataFrame:
    """Lanes of a known fragility, whose records have names."""
    table = lanes(records)
    return table.assign(record=[f"r{number}" for number in table["record"]])


def weights(table: pd.DataFrame, seed: int = 2) -> dict[str, float]:
    names = table["record"].unique()
    drawn = np.random.default_rng(seed).integers(1, 5, len(names))
    return dict(zip(names, drawn.astype(float).tolist(), strict=True))


def test_a_record_of_weight_three_counts_as_three_of_it():
    table = named()
    heavy = weights(table)
    parts = [
        part.assign(record=f"{name}-{copy}")
        for name, part in table.groupby("record")
        for copy in range(int(heavy[name]))
    ]
    ours = wr.fragility(table, weights=heavy, **OVERTURNING).table.iloc[0]
    copied = wr.fragility(pd.concat(parts), **OVERTURNING).table.iloc[0]
    assert ours["median"] == pytest.approx(copied["median"], rel=1e-9)
    assert ours["dispersion"] == pytest.approx(copied["dispersion"], rel=1e-9)
    # Copies tell nothing new, of which a weight knows and a copy does not.
    values = np.array(list(heavy.values()))
    assert ours["effective_records"] == pytest.approx(values.sum() ** 2 / (values**2).sum())
    assert copied["effective_records"] == values.sum()
    spans = [np.log(row["median_p95"] / row["median_p05"]) for row in (ours, copied)]
    assert spans[0] > spans[1]


def test_equal_weights_are_none():
    table = named()
    plain = wr.risk(table, **LAW).table.iloc[0]
    same = wr.risk(table, weights=dict.fromkeys(table["record"].unique(), 7.5), **LAW).table.iloc[0]
    for name in (
        "rate_per_year",
        "rate_p05_per_year",
        "rate_p95_per_year",
        "rate_fit_p95_per_year",
    ):
        assert same[name] == pytest.approx(plain[name], rel=1e-9)


def test_a_column_and_a_file_say_the_same_as_weights_by_name(tmp_path: pathlib.Path):
    table = named()
    heavy = weights(table)
    table["own"] = [heavy[name] for name in table["record"]]
    table.to_parquet(tmp_path / "lanes.parquet")
    file = tmp_path / "weights.csv"
    rows = "".join(f"raw/{name}.txt,{weight}\n" for name, weight in heavy.items())
    file.write_text(f"record,weight\n{rows}", encoding="utf-8")
    wanted = wr.risk(table, weights=heavy, **LAW).table["rate_per_year"].iloc[0]
    for asked in ("own", file):
        assert wr.risk(table, weights=asked, **LAW).table["rate_per_year"].iloc[0] == wanted
        law = ("--k0", 1e-3, "--k", 2, "--at", "1 m/s^2")
        said = succeed("risk", tmp_path, *law, "--weights", asked, "--json").stdout
        assert json.loads(said)["risks"][0]["rate_per_year"] == pytest.approx(wanted, rel=1e-12)
    assert wanted != wr.risk(table, **LAW).table["rate_per_year"].iloc[0]


def test_capacities_of_an_incremental_analysis_have_weights_too():
    low = np.geomspace(0.5, 2.0, 9)
    table = pd.DataFrame(
        {
            "standing_factor": low,
            "overturning_factor": 1.01 * low,
            "verdict": "bracketed",
            "record": [f"r{number}" for number in range(9)],
            PGA: 1.0,
        }
    )
    strong = {f"r{number}": 1.0 + number for number in range(9)}
    found = wr.risk(table, weights=strong, **LAW).table.iloc[0]
    logs, share = np.log(1.005 * low), np.arange(1, 10) / 45.0
    # Brackets of 1 % are as good as their middles.
    assert np.log(found["median"]) == pytest.approx((share * logs).sum(), abs=1e-3)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("record,weight\nr0,1\n", "record: got 'r1', must have a weight; these have one: r0"),
        ("record,weight\nr0,0\n", "weight: got '0', must be finite and > 0 (row 1)"),
        ("record,weight\nr0,much\n", "weight: got 'much', must be finite and > 0 (row 1)"),
        ("record,weight\nr0,1\nr0,1\n", "record: got 'r0', must be there once (row 2)"),
        ("record,weight\n", "record: got 0 rows, must have at least one record"),
        ("name,weight\nr0,1\n", "record: got nothing, must be a CSV file with the columns"),
        ("", "must be a CSV file with the columns record and weight"),
    ],
)
def test_weights_that_cannot_be_used_are_refused(text: str, said: str, tmp_path: pathlib.Path):
    named().to_parquet(tmp_path / "lanes.parquet")
    file = tmp_path / "weights.csv"
    file.write_text(text, encoding="utf-8")
    done = invoke("fragility", tmp_path, "--weights", file)
    assert done.exit_code == 2
    assert said in done.output


def test_a_column_of_weights_is_judged():
    table = named()
    with pytest.raises(wr.InputError, match="weights: got 'nope', must be a CSV file, or a column"):
        wr.fragility(table, weights="nope")
    drifting = table.assign(own=np.arange(1.0, len(table) + 1.0))
    with pytest.raises(wr.InputError, match=r"own: got 2\.0, must be the same in all lanes of a"):
        wr.fragility(drifting, weights="own")
    with pytest.raises(wr.InputError, match=r"own: got -1\.0, must be finite and > 0 in every"):
        wr.fragility(table.assign(own=-1.0), weights="own")
    with pytest.raises(wr.InputError, match="record: got nothing, must be a column: weights are"):
        wr.fragility(table.drop(columns="record"), weights={"r0": 1.0})


def test_records_of_a_folder_are_imported_with_their_weights(tmp_path: pathlib.Path):
    raw = tmp_path / "raw"
    raw.mkdir()
    for seed in (1, 2):
        succeed(
            "records", "generate", "--seed", seed, "--peak", "0.3 g", "-o", raw / f"q{seed}.csv"
        )
    file = tmp_path / "weights.csv"
    file.write_text("record,weight\nq1.csv,2\nq2,0.5\n", encoding="utf-8")
    asked = ("records", "import", raw, "-o", tmp_path / "made", "--weights", file)
    printed = succeed(*asked).stdout
    assert "made.csv is a table for a sweep over them" in " ".join(printed.split())
    table = (tmp_path / "made.csv").read_text(encoding="utf-8")
    assert table == "record,label.weight\nmade/q1.csv,2.0\nmade/q2.csv,0.5\n"
    case = tmp_path / "case.toml"
    case.write_text(
        'title = "t"\nsource = "s"\n[block]\nwidth = "0.5 m"\nheight = "2 m"\ndepth = "0.5 m"\n'
        'density = "2400 kg/m^3"\n[contact]\nfriction = 0.8\n[motion]\nwaveform = "record"\n'
        'record = "made/q1.csv"\n[run]\nduration = "5 s"\n[[sweep]]\ntable = "made.csv"\n',
        encoding="utf-8",
    )
    run = wr.run(str(tmp_path), "housner", progress=False)
    # Labels are texts.
    assert run.table["weight"].tolist() == ["2.0", "0.5"]
    file.write_text("record,weight\nq1,2\n", encoding="utf-8")
    done = invoke(*asked)
    assert done.exit_code == 2
    assert "q2.csv', must have a weight" in done.output
    file.write_text("record,weight\nq1,2\nq2,1\nq3,1\n", encoding="utf-8")
    assert "got 'q3', must be a file that is imported" in invoke(*asked).output
