"""Lanes that pages of sweeps and analyses play: those of the tables that tell most."""

from __future__ import annotations

import io
import json
import pathlib
import re
from typing import Any

import numpy as np
import pandas as pd
import pytest

from tests.shared.case_texts import pulse_text
from tests.shared.commands import invoke, succeed
from warprock.case.lanes import expand_lanes
from warprock.case.load import load_case
from warprock.tables.stack import print_stack_comparison
from warprock.tables.terminal import plain_console

pytestmark = pytest.mark.usefixtures("nothing_rendered")

CASE = (
    pulse_text()
    + """
[[sweep]]
motion.amplitude = {from = "0.2 g", to = "1.5 g", count = 30}
"""
)


STATUE = """
title = "A statue on a pedestal"
source = "Made for this test."

[block.1]
width = "0.6 m"
height = "0.8 m"
depth = "0.6 m"
density = "2400 kg/m^3"

[block.2]
mass = "350 kg"
base = [[-0.22, 0.0], [-0.10, 0.0], [0.16, 0.0], [0.24, 0.01]]
centre = [0.02, 0.6]
inertia = "60 kg m^2"

[contact]
friction = 0.6

[run]
duration = "0.2 s"
"""


def command(*arguments: object) -> str:
    result = succeed(*arguments)
    return result.output


def scenes(folder: pathlib.Path) -> dict[str, Any]:
    """What the player of a page holds, which has one."""
    page = (folder / "report.html").read_text(encoding="utf-8")
    (found,) = re.findall(r'class="scenes" data-digest="[0-9a-f]+">(.*?)</script>', page, re.S)
    return json.loads(found)


def peak(lane: dict[str, Any]) -> float:
    (block,) = lane["blocks"]
    return max(map(abs, block["r"])) * lane["angle"] / np.max(block["alpha"])


@pytest.fixture(scope="module")
def sweep(tmp_path_factory: pytest.TempPathFactory) -> pathlib.Path:
    folder = tmp_path_factory.mktemp("sweep")
    (folder / "case.toml").write_text(CASE)
    command(
        "sweep", "plan", folder / "case.toml", "-e", "housner", "--chunk", 16, "-o", folder / "out"
    )
    command("sweep", "run", folder / "out")
    command("sweep", "merge", folder / "out")
    return folder / "out"


def test_a_merged_sweep_plays_the_lanes_of_its_table(sweep: pathlib.Path):
    table, found = pd.read_parquet(sweep / "lanes.parquet"), scenes(sweep)
    assert len(found["lanes"]) < len(table)
    assert f"of {len(table)} lanes" in found["note"]
    stood = table[table["outcome"] != "overturned"]
    far = stood.loc[stood["peak_rotation_ratio"].idxmax()]
    told = next(each for each in found["lanes"] if "largest rotation" in each["about"])
    assert told["lane"] == far["lane"]
    # The page holds a sample in 10 ms: near its peak the block moves by less than a percent in it.
    assert peak(told) == pytest.approx(far["peak_rotation_ratio"], rel=0.01)
    command("report", sweep)
    assert scenes(sweep) == found


@pytest.mark.thorough
def test_a_statue_of_a_stack_is_played_by_its_outline(tmp_path: pathlib.Path):
    (tmp_path / "case.toml").write_text(STATUE)
    out = tmp_path / "out"
    command("sweep", "plan", tmp_path / "case.toml", "-e", "dem", "-o", out)
    command("sweep", "run", out)
    assert "1 lane is in one table" in command("sweep", "merge", out)
    (lane,) = scenes(out)["lanes"]
    profiles = expand_lanes(load_case(str(tmp_path / "case.toml"))).lanes.profiles
    assert profiles is not None
    # In the plane: no corner has a y. A page says micrometres.
    for block, outline in zip(lane["blocks"], profiles.outlines()[0], strict=True):
        corners = np.array(block["p"])
        np.testing.assert_allclose(corners[:, [0, -1]], outline, atol=1e-6)


def test_the_csv_of_a_merged_sweep_has_the_rows_of_the_parquet_file(
    sweep: pathlib.Path, tmp_path: pathlib.Path
):
    whole = pd.read_parquet(sweep / "lanes.parquet")
    words = whole.select_dtypes("category").columns
    whole = whole.astype(dict.fromkeys(words, str))
    command("sweep", "merge", sweep, "-o", tmp_path / "all.csv")
    for file in (sweep / "lanes.csv", tmp_path / "all.csv"):
        found = pd.read_csv(file, keep_default_na=False)
        assert list(found) == list(whole)
        assert found["outcome"].tolist() == whole["outcome"].tolist()
        # As text a number has all of its digits; pandas may read the last one off by one.
        peaks = (each["peak_rotation_rad"].to_numpy() for each in (found, whole))
        np.testing.assert_allclose(*peaks, rtol=1e-15)


def test_a_lane_of_a_sweep_is_a_moving_picture(sweep: pathlib.Path):
    command("animate", sweep, "--lane", 7, "--rate", 2, "--speed", 1)
    assert (sweep / "lane-7.gif").stat().st_size > 0
    result = invoke("animate", sweep, "--lane", "30")
    assert result.exit_code == 2
    assert "must be a lane from 0 to 29" in result.output


def test_fragility_plays_both_sides_of_the_fall(sweep: pathlib.Path, tmp_path: pathlib.Path):
    """The table lies in the folder of a sweep; its own page stays with the player of the sweep."""
    asked = ("fragility", sweep, "--im", "normalised_acceleration", "--limit", "overturning")
    command(*asked, "-o", tmp_path)
    table = pd.read_parquet(sweep / "lanes.parquet")
    fell = table[table["outcome"] == "overturned"]
    weakest = fell.loc[fell["normalised_acceleration"].idxmin(), "lane"]
    about = {each["lane"]: each["about"] for each in scenes(tmp_path)["lanes"]}
    assert "the weakest motion that felled one" in about[weakest]
    command("report", tmp_path)
    assert {each["lane"] for each in scenes(tmp_path)["lanes"]} == set(about)
    before = scenes(sweep)
    command(*asked, "-o", sweep)
    assert scenes(sweep) == before


def test_an_incremental_analysis_plays_a_lane_just_below_and_at_its_fall(tmp_path: pathlib.Path):
    (tmp_path / "case.toml").write_text(CASE)
    over = ("-s", "motion.amplitude=0.3 g", "-s", "motion.frequency=1 Hz, 2 Hz")
    asked = ("--im", "factor", "--count", 5, "--accuracy", 0.1, "-o", tmp_path / "out")
    command("ida", tmp_path / "case.toml", "-e", "housner", *over, *asked)
    found = scenes(tmp_path / "out")["lanes"]
    assert {each["lane"] for each in found} == {0, 1}
    for below, above in zip(found[::2], found[1::2], strict=True):
        assert below["lane"] == above["lane"]
        assert "below its fall" in below["about"]
        assert peak(below) < 1.5 < peak(above)
        assert "overturned" in above["about"]


def test_a_comparison_leaves_a_page_that_plays_the_lane_in_which_engines_differ_most(
    tmp_path: pathlib.Path,
):
    (tmp_path / "case.toml").write_text(CASE)
    over = ("-s", "motion.amplitude=0.22 g, 0.3 g", "-s", "run.sample_interval=20 ms")
    asked = ("compare", tmp_path / "case.toml", "-e", "housner", "-e", "event", *over)
    said = command(*asked, "-o", tmp_path / "out")
    assert said.splitlines()[-2].startswith("event is within")
    table = pd.read_csv(tmp_path / "out" / "comparison.csv")
    off = table[table["engine"] == "event"]["error_run_ratio"].to_numpy()
    assert [each["lane"] for each in scenes(tmp_path / "out")["lanes"][:2]] == [off.argmax()] * 2
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert "event is within" in page
    assert set(json.loads(command(*asked, "--json"))) == {
        *("case", "engines", "stacked", "spatial", "costs", "rows"),
    }


def test_a_comparison_of_many_stacks_is_summed_up():
    rows = [
        {
            "lane": f"lane {lane}",
            "lane_number": lane,
            "block": block,
            "engine": engine,
            "reference": "a",
            "outcome": "at_rest",
            "status": "ok",
            "peak_slide_mm": 0.0,
            "peak_rotation_ratio": 0.1,
            "difference_5s_ratio": 0.0,
            "difference_run_ratio": 0.001 * lane if engine == "b" else 0.0,
        }
        for engine in ("a", "b")
        for lane in range(25)
        for block in (1, 2)
    ]
    rows[-1]["outcome"] = "overturned"

    def printed(shown: list[dict[str, Any]]) -> str:
        console = plain_console(width=80, record=True, file=io.StringIO())
        found = {"case": "c", "engines": ["a", "b"], "spatial": False, "rows": shown}
        print_stack_comparison(found, console)
        return console.export_text()

    text = printed(rows)
    assert "lane 7" not in text
    assert [" ".join(line.split()) for line in text.splitlines() if line.startswith(" b")] == [
        "b 1 25 0.012 0.024 0"
    ]
    assert "2 25 0.012 0.024 1" in " ".join(text.split())
    assert "lane 7" in printed([row for row in rows if row["lane_number"] < 24])
