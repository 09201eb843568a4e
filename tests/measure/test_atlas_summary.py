"""What the atlas of extremes says: limits, sentences, cells of its figures, and the command."""

from __future__ import annotations

import json
import math
import pathlib
import struct

import numpy as np
import pandas as pd
import pytest

from tests.shared.commands import invoke, succeed
from warprock.figures import atlas as plots_stability
from warprock.findings.stability import tell_stability
from warprock.measure.atlas import supported_lanes
from warprock.measure.atlas_lanes import AtlasSize
from warprock.measure.atlas_maps import MAPS
from warprock.measure.atlas_summary import reach, summarise, within

BY_NAME = {each.name: each for each in MAPS}
TINY = AtlasSize(points=3, steps=150, duration=0.5, iterations=(10,))


def counted(errors: list[float], steps: list[float], **columns) -> pd.DataFrame:
    """A table of lanes of one engine on the map of steps."""
    count = len(errors)
    base = {
        "penetration": 1e-6,
        "map": "step",
        "engine": "event",
        "precision": "float64",
        "status": "ok",
        "usable": True,
        "finite": True,
        "grew": False,
        "absurd": False,
        "compared": True,
        "growth": 0.0,
        "start_ratio": 0.5,
        "slenderness": 2.0,
        "duration_s": 1.0,
        "same_outcome": 1.0,
    }
    filled = {name: np.full(count, value) for name, value in base.items()}
    return pd.DataFrame({**filled, "error": errors, "step_s": steps, **columns})


def test_limits_are_where_the_numbers_say():
    steps = [1e-4] * 10 + [1e-3] * 10 + [1e-2] * 10 + [1e-1] * 10
    errors = [1e-5] * 9 + [0.5] + [5e-3] * 10 + [0.5] * 2 + [1e-5] * 8 + [1e-5] * 10
    rows = counted(errors, steps)
    assert within(rows.iloc[:10], 1e-3) == pytest.approx(0.9)
    limits = summarise(rows)["engines"][0]["limits"]
    assert limits["step_s_error_0.001"] == 1e-4
    # It holds at 0.1 s again, which nobody would rely on.
    assert limits["step_s_error_0.01"] == 1e-3
    assert limits["step_s_usable"] == 0.1
    grew = np.arange(40) >= 20
    rows = counted(errors, steps, grew=grew, growth=np.where(grew, 0.02, 0.0))
    assert summarise(rows)["engines"][0]["limits"]["step_s_energy"] == 1e-3
    assert math.isnan(reach(rows, "step_s", lambda _: False))
    lost = counted([math.nan] * 10, [1e-4] * 10)
    assert within(lost, 1e-2) == 0.0
    assert math.isnan(within(lost.assign(compared=False), 1e-2))


def test_sentences_follow_the_numbers():
    steps = [1e-3] * 10 + [1e-2] * 10
    sound = " ".join(summarise(counted([1e-5] * 20, steps))["engines"][0]["sentences"])
    assert "20 lanes (20 ok); every number is finite" in sound
    assert "no status passes an absurd number" in sound
    assert "stays below 0.001 up to 0.01 s, below 0.01 up to 0.01 s" in sound
    assert "No lane of 20" in sound
    absurd = np.arange(20) == 19
    rows = counted([0.5] * 20, steps, absurd=absurd, grew=absurd, growth=np.where(absurd, 3.0, 0.0))
    found = summarise(rows)
    wrong = " ".join(found["engines"][0]["sentences"])
    assert "1 (5 %) have absurd numbers that their status passes" in wrong
    assert "not even at the smallest step" in wrong
    assert "every number may be used up to 0.001 s" in wrong
    assert [row["growth"] for row in found["defects"]] == [3.0]
    lines = tell_stability({"explained": "words", **found}, {}).texts["summary.md"]
    assert "Defect: map step (one of 1 lanes)" in lines


def test_a_cell_is_coloured_by_nine_lanes_in_ten_and_marked_by_one():
    errors = [1e-5] * 9 + [0.5] + [1e-5] * 8 + [0.5] * 2
    refused = np.arange(20) == 3
    rows = counted(errors, [1e-3] * 10 + [1e-2] * 10, usable=~refused)
    places = [np.array([1e-3, 1e-2]), np.array([2.0])]
    found = plots_stability.cells(rows, ("step_s", "slenderness"), places)
    np.testing.assert_array_equal(found["error"], [[0.5, 0.5]])
    rows = counted([1e-5] * 10 + errors[10:], [1e-3] * 10 + [1e-2] * 10, usable=~refused)
    found = plots_stability.cells(rows, ("step_s", "slenderness"), places)
    np.testing.assert_array_equal(found["error"], [[1e-5, 0.5]])
    np.testing.assert_array_equal(found["refused"], [[True, False]])
    assert not found["grew"].any()
    everywhere = plots_stability.cells(
        rows.assign(step_s=math.nan), ("step_s", "slenderness"), places
    )
    np.testing.assert_array_equal(everywhere["count"], [[20, 20]])


@pytest.mark.thorough
@pytest.mark.usefixtures("pages_bare")
def test_the_command_writes_maps_figures_and_a_summary(
    tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch
):
    options = ["-e", "housner", "--map", "step", "--points", "3", "--steps", "50"]
    result = succeed("stability", *options, "-o", tmp_path, "--json")
    found = json.loads(result.stdout)
    assert [entry["engine"] for entry in found["engines"]] == ["housner", "housner"]
    # Blocks too wide to rock over are none of Housner's.
    assert found["lanes"] == 2 * len(supported_lanes("housner", BY_NAME["step"].lanes(TINY)))
    for file in map(pathlib.Path, found["files"]):
        assert file.is_file()
        if file.suffix == ".png":
            assert struct.unpack(">I", file.read_bytes()[16:20])[0] > 1000
    assert "Free rocking, no time step" in (tmp_path / "summary.md").read_text()
    # The figures are not drawn a second time.
    monkeypatch.setattr(plots_stability, "draw_maps", lambda *_: [])
    printed = invoke("stability", *options, "-o", tmp_path)
    assert "Atlas of extremes" in printed.stdout


@pytest.mark.parametrize(
    "options",
    [
        ["-e", "nobody"],
        ["--map", "nowhere"],
        ["--points", "1"],
        ["--points", "1000"],
        ["--steps", "0"],
    ],
)
def test_bad_options_are_refused(options: list[str], tmp_path: pathlib.Path):
    result = invoke("stability", *options, "-o", tmp_path / "x")
    assert result.exit_code == 2
    assert options[0] in result.stderr
    assert not (tmp_path / "x").exists()
