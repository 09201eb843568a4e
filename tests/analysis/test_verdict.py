"""Verdicts: each answer is what a run of its own says."""

from __future__ import annotations

import json
import pathlib

import numpy as np
import pytest

import warprock as wr
from tests.shared.commands import invoke, succeed
from warprock.analysis.verdict import Spread, run_verdict
from warprock.case.load import load_case
from warprock.errors import InputError
from warprock.findings.verdict import find_verdict
from warprock.running.options import RunOptions

pytestmark = pytest.mark.usefixtures("pages_bare")

BASE = {"motion.scale": 0.5}


@pytest.fixture(scope="module")
def found() -> wr.Found:
    return wr.verdict("record-ridgecrest", "housner", overrides=BASE, neighbours=64, progress=False)


def outcome(changes: dict[str, object]) -> tuple[str, float]:
    """What became of the block, run alone, and its rotation ratio."""
    run = wr.run("record-ridgecrest", "housner", overrides={**BASE, **changes}, progress=False)
    return str(run.table["outcome"].iloc[0]), float(run.table["peak_rotation_ratio"].iloc[0])


def test_it_stands_as_its_run_says(found: wr.Found):
    answers = found.facts["verdict"]
    assert (answers["outcome"], answers["peak_rotation_ratio"]) == outcome({})
    assert found.finding.headline == (
        "It stands: its largest rotation is 0.506 of its slenderness angle"
    )


def test_the_factor_parts_standing_from_falling(found: wr.Found):
    answers = found.facts["verdict"]
    low, high = answers["standing_factor"], answers["overturning_factor"]
    assert low < high <= 1.01 * low
    assert outcome({"motion.scale": 0.5 * low})[0] == "at_rest"
    assert outcome({"motion.scale": 0.5 * high})[0] == "overturned"


def test_the_width_parts_falling_from_standing_under_the_stronger_motion(found: wr.Found):
    answers = found.facts["verdict"]
    low, high = answers["width_low_m"], answers["width_high_m"]
    assert 0.17 < low < high <= 1.01 * low
    stronger = {"motion.scale": 0.75}
    assert outcome({**stronger, "block.width": f"{low:.12g} m"})[0] == "overturned"
    assert outcome({**stronger, "block.width": f"{high:.12g} m"})[0] == "at_rest"
    tried = found.tables["verdict-widths"]
    wider = tried[tried["width_m"] >= high * (1.0 - 1e-9)]
    assert set(wider["outcome"]) == {"at_rest"}


def test_neighbours_are_lanes_within_their_spread(found: wr.Found):
    table = found.tables["verdict-neighbours"]
    assert len(table) == 64
    for column, own, share in (("width_m", 0.17, 0.02), ("height_m", 1.0, 0.02)):
        away = np.abs(table[column] / own - 1.0)
        assert 0.9 * share < away.max() <= share * (1.0 + 1e-9)
    assert np.abs(table["motion_factor"] - 1.0).max() <= 0.1
    row = table.iloc[5]
    changes = {
        "block.width": f"{float(row['width_m'])!r} m",
        "block.height": f"{float(row['height_m'])!r} m",
        "motion.scale": 0.5 * float(row["motion_factor"]),
    }
    what, ratio = outcome(changes)
    assert what == row["outcome"]
    # A record that is scaled twice is rounded once more, and impacts carry that on.
    assert ratio == pytest.approx(row["peak_rotation_ratio"], rel=1e-6)


def test_a_block_that_falls_and_one_that_never_does():
    strong = wr.verdict(
        "record-ridgecrest", "housner", overrides={**BASE, "motion.scale": 1.0}, neighbours=16,
        progress=False,
    )  # fmt: skip
    assert strong.finding.headline == "It does not stand: under this motion the block overturns"
    assert strong.facts["verdict"]["overturning_factor"] < 1.0
    weak = wr.verdict(
        "record-ridgecrest", "housner", overrides={**BASE, "motion.scale": 0.01}, neighbours=16,
        progress=False,
    )  # fmt: skip
    assert weak.finding.headline == "It stands: the motion does not lift the block"
    said = " ".join(weak.finding.sentences)
    assert "It does not fall up to 10 times the motion" in said
    assert "It bears 1.5 times the motion as wide as it is" in said


def test_a_body_and_a_record_are_enough(tmp_path: pathlib.Path):
    asked = ("--body", "0.4 m x 1.2 m x 0.4 m", "--record", "ridgecrest-2019-ccc-090")
    short = ("-s", "run.duration=30 s", "-e", "event", "--neighbours", 16)
    done = succeed("verdict", *asked, *short, "--json", "-o", tmp_path)
    answers = json.loads(done.stdout)["verdict"]
    assert answers["width_m"] == 0.4
    assert answers["peak_slide_m"] is not None
    assert (tmp_path / "verdict.png").exists()
    (tmp_path / "report.html").unlink()
    succeed("report", tmp_path)
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "0.4 m x 1.2 m x 0.4 m under ridgecrest-2019-ccc-090" in page


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ((), "--body: got nothing, must be given"),
        (("--body", "statue"), "--record: got nothing, must be given"),
        (("free-b0",), "motion: got nothing, must be given"),
        (("record-ridgecrest",), "sweep: got 7 lanes, must be one block under one motion"),
        (("record-ridgecrest", "--record", "x"), "--record: got 'x', must be left out"),
        (
            ("record-ridgecrest", "-s", "motion.scale=1", "--spread-size", 0.7),
            "--spread-size: got 0.7, must be a share from 0 to 0.5",
        ),
        (
            ("record-ridgecrest", "-s", "motion.scale=1", "--neighbours", 2),
            "--neighbours: got 2, must be from 16 to 65,536",
        ),
        (
            ("record-ridgecrest", "-s", "motion.scale=1", "--margin", 0.01),
            "--margin: got 0.01, must be from 0.1 to 10",
        ),
    ],
)
def test_what_cannot_be_asked_is_refused(asked: tuple[object, ...], said: str):
    done = invoke("verdict", *asked)
    assert done.exit_code == 2
    assert said in done.output


def test_a_body_that_is_no_box_has_neighbours_of_friction_and_motion_alone(tmp_path: pathlib.Path):
    case = load_case("record-ridgecrest", {**BASE, "contact.friction": 0.9})
    raw = {name: each for name, each in case.raw.items() if name != "check"}
    raw["block"] = {"diameter": "0.3 m", "height": "1 m", "density": "2000 kg/m^3"}
    made = wr.Case.from_dict(raw, name="drum").judged
    ran = run_verdict(made, "event", RunOptions(), spread=Spread(), neighbours=16)
    assert ran.widths is None
    assert ran.neighbours["friction"].nunique() == 16
    told = find_verdict(ran)
    assert not any("wide" in sentence for sentence in told.sentences)
    with pytest.raises(InputError, match="must be a single block"):
        wr.verdict("stack-sine-pulse", overrides={"sweep": []}, progress=False)
