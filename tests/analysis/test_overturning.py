"""Overturning maps: closed forms, the safe gap, boundaries held against SciPy, refusals, files."""

from __future__ import annotations

import dataclasses
import json
import pathlib

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner

from tests.shared.commands import invoke, succeed
from tests.shared.marks import first
from warprock.analysis import boundaries as overturning_boundaries
from warprock.analysis.boundaries import refine
from warprock.analysis.overturning import Mode, OverturningMap, modes, run_grid
from warprock.case.case import Case
from warprock.case.lanes import expand_lanes
from warprock.case.load import load_case
from warprock.cli.main import main
from warprock.errors import InputError
from warprock.model import rocking
from warprock.model.motion import GroundMotions, RecordMotions, SpatialMotions
from warprock.model.response import Response, SampleTimes, Status
from warprock.oracle.block import oracle_response
from warprock.verification.checks import run_checks

Array = np.ndarray

MAP = """
title = "a map"
source = "a test"
[block]
width = "{width} m"
height = "1.5 m"
depth = "0.5 m"
density = "2400 kg/m^3"
[contact]
friction = 1.0
angular_restitution = 0.9
[motion]
waveform = "sine"
control = "acceleration"
amplitude = "{unit} g"
frequency = "1 Hz"
cycles = 1
[run]
duration = "12 s"
[[sweep]]
motion.amplitude = {{ from = "{low} g", to = "{high} g", count = {count} }}
[[sweep]]
label.pulse = ["half sine", "one-cycle sine"]
motion.cycles = [0.5, 1]
[[sweep]]
motion.frequency = ["1 Hz", "2 Hz", "2.5 Hz"]
"""


def written(tmp_path: pathlib.Path, tangent: float = 0.01, count: int = 29, **change: str) -> Case:
    """The map of a block 1.5 m high, tan(alpha) = tangent, from 1 to 15 times what lifts it."""
    text = MAP.format(
        width=1.5 * tangent, unit=tangent, low=tangent, high=15.0 * tangent, count=count
    )
    for old, new in change.items():
        text = text.replace(old.replace("_", " "), new)
    file = tmp_path / "case.toml"
    file.write_text(text, encoding="utf-8")
    return load_case(file)


def to_mode_2(found: OverturningMap, group: int) -> Array:
    """The boundary of overturning without an impact, shape [frequency]."""
    rows = found.boundaries
    mine = rows[(rows["group"] == found.groups[group]) & (rows["above"] == "without impact")]
    assert len(mine) == len(found.frequency_ratio[group])
    return mine["acceleration_ratio"].to_numpy()


def test_boundaries_without_impact_are_the_closed_forms(tmp_path: pathlib.Path):
    """They are of the linear block: sin and cos of up to 2 alpha leave out parts of alpha^2."""
    away = {}
    for tangent in (0.01, 0.04):
        found = refine(run_grid(written(tmp_path, tangent), "housner"), 1e-8)
        assert found.groups == ("half sine", "one-cycle sine")
        forms = (
            rocking.half_sine_overturning_amplitude(found.frequency_ratio[0]),
            rocking.one_cycle_sine_overturning_amplitude(found.frequency_ratio[1]),
        )
        off = [to_mode_2(found, n) / form - 1.0 for n, form in enumerate(forms)]
        assert np.max(np.abs(off)) <= 2.0 * tangent**2
        away[tangent] = np.array(off)
        for group, form in enumerate(forms):
            named = found.closed_form(group)
            assert named is not None
            np.testing.assert_array_equal(named[1], form)
    # A difference of order alpha^2 and nothing else: 16 times as much at 4 times the angle.
    np.testing.assert_allclose(away[0.04] / away[0.01], 16.0, rtol=0.05)


@pytest.mark.thorough
def test_the_case_has_the_published_limits_and_a_wrong_impact_loses_them():
    assert all(row.ok for row in run_checks(load_case("overturning-map")))
    harder = load_case("overturning-map", ["contact.angular_restitution=0.85"])
    one_cycle, half = run_checks(harder)
    assert not one_cycle.ok
    assert half.ok  # a block that falls without an impact does not know its restitution


def test_scipy_falls_on_the_same_side_of_every_boundary(tmp_path: pathlib.Path):
    """Both sides of each boundary, a part 1e-4 away from it, by another integrator."""
    case = written(tmp_path, tangent=0.2, count=8)
    found = refine(run_grid(case, "housner"), 1e-6)
    every = found.boundaries
    rows = every.iloc[np.random.default_rng(1).permutation(len(every))[: len(every) // 3]]
    assert set(rows["below"]) == {"safe", "with impact"}
    lane_set = found.run.lane_set
    first = dict(zip(found.groups, found.lanes[:, 0, 0], strict=True))
    column = {ratio: n for n, ratio in enumerate(found.frequency_ratio[0])}
    group = {name: n for n, name in enumerate(first)}
    lanes = np.array(
        [
            found.lanes[group[g], column[f], 0]
            for g, f in zip(rows["group"], rows["frequency_ratio"], strict=True)
        ]
    )
    start = lane_set.inputs["normalised_acceleration"].to_numpy()[lanes]
    for side, word in ((1.0 - 1e-4, "below"), (1.0 + 1e-4, "above")):
        factors = rows["acceleration_ratio"].to_numpy() * side / start
        motions = lane_set.motions.take(lanes).scaled(factors)
        times = SampleTimes(lane_set.times.duration)
        some = lane_set.lanes.take(lanes)
        answer = oracle_response(some, motions, times, rtol=1e-9)
        assert [Mode(code).text for code in modes(answer, some, motions, times.duration)] == list(
            rows[word]
        )


def test_brackets_are_narrow_and_their_ends_are_in_the_modes_that_they_say(tmp_path: pathlib.Path):
    grid = run_grid(written(tmp_path, count=8), "housner")
    coarse, fine = (refine(grid, tolerance) for tolerance in (1e-2, 1e-5))
    for found, tolerance in ((coarse, 1e-2), (fine, 1e-5)):
        rows = found.boundaries
        width = rows["acceleration_ratio_high"] - rows["acceleration_ratio_low"]
        assert np.all(width <= tolerance * rows["acceleration_ratio_high"])
        assert np.all(rows["below"] != rows["above"])
        assert found.lanes_run > grid.lanes_run
    # In a column each boundary leads to the mode from which the next one starts.
    for _, column in fine.boundaries.groupby(["group", "frequency_ratio"]):
        assert list(column["above"])[:-1] == list(column["below"])[1:]
        assert column["acceleration_ratio"].is_monotonic_increasing
    # Two lanes a column, safe and mode 2, do not hide the mode between them.
    both = refine(run_grid(written(tmp_path, count=2), "housner"), 1e-3)
    assert set(both.boundaries["below"]) == {"safe", "with impact"}


def test_lanes_without_a_number_make_no_boundary(tmp_path: pathlib.Path):
    grid = run_grid(written(tmp_path, count=8), "housner")
    status = np.array(grid.run.response["status"])
    weak = grid.lanes[:, :, :4].ravel()
    status[weak] = Status.EVENT_LIMIT
    fields = {**grid.run.response.fields, "status": status}
    answer = Response("housner", fields, np.empty(0))
    lame = dataclasses.replace(grid, run=dataclasses.replace(grid.run, response=answer))
    assert np.all(lame.mode[:, :, :4] == Mode.NO_NUMBER)
    assert refine(lame, 1e-3).boundaries.empty
    status[weak[::2]] = Status.OK
    known = refine(lame, 1e-3).boundaries
    assert set(known["below"]) == {"safe", "with impact"}


def shaken(motions: GroundMotions, times: Array) -> Array:
    if isinstance(motions, SpatialMotions):
        return np.concatenate([shaken(part, times) for part in motions.components])
    steps = [s.velocity_step for s in motions.segments(0)[:2]]
    return np.concatenate([motions.acceleration(times, 0), steps])


@pytest.mark.parametrize(
    "keys",
    [
        'waveform = "sine"\ncontrol = "displacement"\nfrequency = "1 Hz"\namplitude = "{} m"\n'
        "cycles = 1.3",
        'waveform = "ricker"\ncontrol = "velocity"\nfrequency = "1 Hz"\namplitude = "{} m/s"',
        'waveform = "mavroeidis-papageorgiou"\ncontrol = "acceleration"\nfrequency = "1 Hz"\n'
        'amplitude = "{} m/s^2"\ncycles = 2\nphase = "20 deg"',
        'waveform = "record"\nrecord = "ridgecrest-2019-ccc-090"\nscale = {}',
    ],
)
@pytest.mark.parametrize("space", first(1, [False, True]))
def test_a_scaled_motion_is_the_motion_of_a_scaled_amplitude(
    keys: str, space: bool, tmp_path: pathlib.Path
):
    found = []
    for amplitude in ("0.5", "1.25"):
        text = MAP.format(width=0.1, unit=1, low=1, high=2, count=2).split("[motion]")[0]
        motion = keys.format(amplitude)
        above = f"[motion.z]\n{motion}\n" if space else ""
        text += f'[motion]\n{motion}\n{above}[run]\nduration = "12 s"\n'
        text = text.replace("angular_restitution = 0.9\n", "") if space else text
        file = tmp_path / "case.toml"
        file.write_text(text, encoding="utf-8")
        found.append(expand_lanes(load_case(file)).motions)
    times = np.linspace(0.0, 3.0, 40)
    one, other = (
        shaken(m.scaled(np.array([f])), times) for m, f in zip(found, (2.5, 1.0), strict=True)
    )
    np.testing.assert_allclose(one, other, rtol=1e-13, atol=1e-15)
    assert np.any(other != 0.0)
    assert isinstance(found[0], SpatialMotions) is space
    if isinstance(found[0], RecordMotions):
        assert found[0].scaled(np.array([2.0])).pool_acceleration is found[0].pool_acceleration


@pytest.mark.thorough
def test_pulses_of_any_family_make_a_map(tmp_path: pathlib.Path):
    file = tmp_path / "case.toml"
    text = MAP.format(width=0.15, unit=0.1, low=0.1, high=2.0, count=20)
    text = text.replace("cycles = 1\n", "").replace('"sine"', '"ricker"')
    axis = text.index("[[sweep]]\nlabel.pulse")
    file.write_text(text[:axis] + text[text.index("[[sweep]]\nmotion.freq") :], encoding="utf-8")
    found = refine(run_grid(load_case(file), "housner"), 1e-3)
    assert found.groups == ("",)
    assert found.closed_form(0) is None
    assert "without impact" in set(found.boundaries["above"])


@pytest.mark.usefixtures("unrendered")
def test_the_command_writes_what_it_prints(tmp_path: pathlib.Path, request: pytest.FixtureRequest):
    written(tmp_path, count=15)
    out = tmp_path / "out"
    arguments = ["map", str(tmp_path), "-o", str(out), "--accuracy", "1e-3"]
    result = succeed(*arguments, "--json")
    found = json.loads(result.stdout)
    boundaries = pd.read_parquet(out / "boundaries.parquet")
    assert len(boundaries) == found["boundaries"] == len(found["rows"]) > 4
    grid = pd.read_parquet(out / "grid.parquet")
    assert len(grid) == found["grid_lanes"] == sum(found["modes"].values())
    assert set(grid["mode"]) == {"safe", "with impact", "without impact"}
    assert json.loads((out / "run.json").read_text())["boundary_accuracy"] == 1e-3
    assert (out / "map.png").read_bytes()[:4] == b"\x89PNG"
    request.getfixturevalue("unrendered")
    printed = invoke(*arguments).stdout
    assert (
        f"{boundaries['acceleration_ratio'].iloc[0]:.4f} {boundaries['above'].iloc[0]}" in printed
    )


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--accuracy", "0.5"], ["--accuracy", "from 1e-09 to 0.1"]),
        (["-e", "hous"], ["--engine", "allowed"]),
        (["-s", "motion.frequency=1 Hz"], ["motion.frequency", "must be swept"]),
        (["-s", "motion.amplitude=1 g"], ["motion.amplitude", "must be swept"]),
    ],
)
def test_what_makes_no_map_is_refused(
    arguments: list[str], words: list[str], tmp_path: pathlib.Path
):
    written(tmp_path)
    out = tmp_path / "out"
    result = invoke("map", tmp_path, "-o", out, *arguments)
    assert result.exit_code == 2
    assert all(word in result.stderr for word in words), result.stderr
    assert result.stderr.count("\n") == 1
    assert not out.exists()


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"label.pulse": "motion.start"}, "label.NAME"),
        ({'from = "0.01 g"': 'from = "0 g"'}, "must move the base"),
    ],
)
def test_a_sweep_that_makes_no_map_is_refused(
    change: dict[str, str], words: str, tmp_path: pathlib.Path
):
    if "label.pulse" in change:
        change = {'label.pulse = ["half sine", "one-cycle sine"]': 'motion.start = ["0 s", "1 s"]'}
    with pytest.raises(InputError, match=words):
        run_grid(written(tmp_path, **change), "housner")


ENSEMBLE = '[ensemble]\nmembers = 2\nspread.block.height = "1 %"\n'


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("amplitude = {", 'amplitude = ["0.02 g", "0.02 g"]\n#', "no two of the same strength"),
        ("[run]", f"{ENSEMBLE}[run]", "has its own lanes"),
    ],
)
def test_lanes_that_make_no_map_are_refused(old: str, new: str, words: str, tmp_path: pathlib.Path):
    written(tmp_path)
    file = tmp_path / "case.toml"
    file.write_text(file.read_text(encoding="utf-8").replace(old, new), encoding="utf-8")
    with pytest.raises(InputError, match=words):
        run_grid(load_case(file), "housner")


def test_axes_that_are_zipped_and_stacks_make_no_map(tmp_path: pathlib.Path):
    case = written(tmp_path)
    both = dataclasses.replace(case.axes[0], columns=case.axes[0].columns | case.axes[2].columns)
    with pytest.raises(InputError, match=r"must not be zipped with motion\.frequency"):
        run_grid(dataclasses.replace(case, axes=(both, case.axes[1])), "housner")
    with pytest.raises(InputError, match="block: got the table, must not be a stack"):
        run_grid(load_case("stack-sine-pulse"), "event")


def test_what_finds_the_load_of_a_tilting_table_is_named(tmp_path: pathlib.Path):
    file = tmp_path / "case.toml"
    text = """
        title = "a block on a tilting table"
        source = "made up"
        block = { width = "0.5 m", height = "2 m", depth = "1 m", density = "2 t/m^3" }
        contact = { friction = 0.7 }
        motion = { waveform = "tilt", tilt_rate = "4 deg/s" }
        run = { duration = "5 s" }
    """
    file.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=r"got tilt, must be a pulse: `warprock limit --push`"):
        run_grid(load_case(file), "assembly")


def test_a_bracket_whose_middle_has_no_number_stays_as_it_is(
    tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch
):
    grid = run_grid(written(tmp_path), "housner")
    nothing = np.int8(Mode.NO_NUMBER)
    monkeypatch.setattr(
        overturning_boundaries, "modes", lambda response, *_: np.full(response.lane_count, nothing)
    )
    found = refine(grid, 1e-6)
    assert found.stages == 1
    coarse = found.boundaries
    step = np.diff(grid.strength[0, 0])[0]
    width = coarse["acceleration_ratio_high"] - coarse["acceleration_ratio_low"]
    np.testing.assert_allclose(width, step, rtol=1e-9)
    assert "no number" not in {*coarse["below"], *coarse["above"]}


def test_a_check_is_of_one_column(tmp_path: pathlib.Path):
    case = written(tmp_path)
    p = float(expand_lanes(case).inputs["frequency_parameter_rad_s"][0])
    ratio = 2.0 * np.pi / p
    for where, at, count in (({}, ratio, 2), ({"pulse": "half sine"}, 1.1 * ratio, 0)):
        with pytest.raises(InputError, match=f"one column of the map; {count} have it"):
            overturning_boundaries.boundaries_at(case, "housner", where, at, accuracy=0.1)


@pytest.mark.thorough
@pytest.mark.parametrize("body", ["column", "2 m x 9 m x 2 m"])
def test_a_map_to_start_from_is_long_enough_and_a_short_one_says_how_long_is(
    tmp_path: pathlib.Path, body: str
):
    path = str(tmp_path / "own/case.toml")
    runner = CliRunner()
    started = runner.invoke(main, ["init", "map", path, "--body", body])
    assert started.exit_code == 0, started.output
    fewer = ["-s", "motion.frequency=0.3 Hz to 3 Hz, 6", "-s", "motion.amplitude=0.2 g to 2 g, 9"]
    asked = ["map", path, "-e", "housner", *fewer]
    whole = json.loads(runner.invoke(main, [*asked, "--json"]).stdout)
    assert whole["modes"]["undecided"] == 0
    assert whole["decided_after_s"] is None
    short = ["-s", "run.duration=9 s"]
    cut = json.loads(runner.invoke(main, [*asked, *short, "--json"]).stdout)
    assert cut["modes"]["undecided"] > 0
    long = f'run.duration="{cut["decided_after_s"]:g} s"'
    assert f"with -s {long} none is undecided" in runner.invoke(main, [*asked, *short]).stdout
    again = json.loads(runner.invoke(main, [*asked, "-s", long, "--json"]).stdout)
    assert again["modes"]["undecided"] == 0
