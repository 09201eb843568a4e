"""By how much a motion must be scaled, in words, as JSON and on the page."""

from __future__ import annotations

import json
import pathlib

import numpy as np
import pandas as pd
import pytest

from tests.shared.case_texts import pulse_text
from tests.shared.commands import succeed
from tests.shared.marks import first
from warprock.case.load import load_case
from warprock.model.response import Outcome
from warprock.running.case_run import run_case

CASE = pulse_text(friction=2.0, amplitude="3 m/s^2", duration="10 s")


def _asked(folder: pathlib.Path, *arguments: str) -> str:
    (folder / "case.toml").write_text(CASE, encoding="utf-8")
    asked = ["ida", str(folder), "-e", "housner", "-o", str(folder / "out"), *arguments]
    result = succeed(*asked)
    return result.stdout


@pytest.mark.thorough
def test_the_factor_is_said_wherever_results_are(tmp_path: pathlib.Path):
    printed = _asked(tmp_path)
    row = pd.read_csv(tmp_path / "out/capacities.csv").iloc[0]
    fall, stand = row["overturning_factor"], row["standing_factor"]
    case = load_case(tmp_path, (f'motion.amplitude="{float(3.0 * fall)!r} m/s^2"',))
    assert run_case(case, "housner").response["outcome"][0] == Outcome.OVERTURNED
    case = load_case(tmp_path, (f'motion.amplitude="{float(3.0 * stand)!r} m/s^2"',))
    assert run_case(case, "housner").response["outcome"][0] != Outcome.OVERTURNED
    said = f"The block first falls at {fall:.4g} times its motion (peak acceleration "
    said += f"{3.0 * fall:.3g} m/s^2, {3.0 * fall / 9.80665:.3g} g); at {stand:.4g} times it stands"
    assert said in printed
    assert said in (tmp_path / "out/report.html").read_text(encoding="utf-8")
    assert said in json.loads((tmp_path / "out/run.json").read_text())["sentence"]
    assert said in json.loads(_asked(tmp_path, "--json"))["sentence"]


@pytest.mark.usefixtures("pages_bare")
@pytest.mark.parametrize(
    ("arguments", "said"),
    first(
        1,
        [
            (("--to", "0.5"), "stands at up to 0.5 times its motion (peak acceleration 1.5 m/s^2"),
            (("--from", "8"), "falls at once, at 8 times its motion (peak acceleration 24 m/s^2"),
            (
                ("--im", "factor", "--to", "0.5"),
                "stands at up to 0.5 times its motion: a larger --to",
            ),
        ],
    ),
)
def test_a_lane_that_is_not_bracketed_says_what_to_try(
    arguments: tuple[str, ...], said: str, tmp_path: pathlib.Path
):
    assert said in _asked(tmp_path, *arguments)


@pytest.mark.usefixtures("pages_bare")
def test_of_several_lanes_the_span_of_the_factors_is_said(tmp_path: pathlib.Path):
    printed = _asked(tmp_path, "-s", "block.width=0.15 m, 0.2 m, 0.3 m")
    factors = pd.read_csv(tmp_path / "out/capacities.csv")["overturning_factor"]
    assert np.ptp(factors) > 0.1
    said = f"Of 3 lanes 3 first fall at {factors.min():.4g} times their motion (peak acceleration "
    assert said in printed
    assert f" to {factors.max():.4g} times (" in printed
    assert f"half of them at up to {factors.median():.4g} times." in printed
