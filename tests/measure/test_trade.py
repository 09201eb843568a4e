"""The trade: its rows, its table kept and resumed, its levels, and what `--cheapest` picks."""

from __future__ import annotations

import dataclasses
import functools
import json
import math
import pathlib
from collections.abc import Iterator

import numpy as np
import pandas as pd
import pytest

from tests.shared.blocks import free_lanes, make_lanes
from tests.shared.commands import invoke, succeed
from warprock.case.lanes import expand_lanes
from warprock.case.load import load_case
from warprock.engines import ENGINES, engine_class
from warprock.errors import InputError
from warprock.figures import trade as plots_trade
from warprock.measure import trade
from warprock.measure.trade import Entry, all_entries, run_trade
from warprock.measure.trade_choice import Choice, choose, shipped_trade
from warprock.measure.trade_knobs import TRADE_KNOBS
from warprock.measure.trade_scenes import (
    FINE_STEP,
    SINES,
    TRADE_SCENES,
    fine_response,
    lane_errors,
    scene_class,
)
from warprock.model.lanes import Lanes
from warprock.model.motion import GroundMotions, StillBase
from warprock.model.response import Outcome, Response, SampleTimes, Status
from warprock.running import machine
from warprock.running.batch import run_batch
from warprock.settings.engines import build_settings

SMALL = [
    Entry("free", "housner", {}, "float64"),
    Entry("free", "event", {"time_step": 1e-2}, "float64"),
    Entry("free", "event", {"time_step": 5e-3}, "float64"),
]


@pytest.fixture(scope="module", autouse=True)
def short() -> Iterator[None]:
    """Costs are measured for a shorter while, whose digits no test sees; a reference is kept."""
    scene = TRADE_SCENES["free"]
    solved = functools.cache(lambda: scene.solve(*scene.build(), scene.times))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(trade, "COST_SECONDS", 0.03)
        known = dataclasses.replace(scene, solve=lambda *_: solved())
        patch.setitem(TRADE_SCENES, "free", known)
        yield


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> tuple[pathlib.Path, pd.DataFrame]:
    """A folder with a small trade, and its table."""
    folder = tmp_path_factory.mktemp("trade")
    return folder, run_trade(SMALL, folder)


def rows_of(*rows: tuple[str, dict[str, float], float, float], scene: str = "free") -> pd.DataFrame:
    """A table of engine, settings, largest error and cost."""
    return pd.DataFrame(
        [
            {
                "scene": scene,
                "engine": engine,
                "settings": json.dumps(settings),
                "precision": "float64",
                "error_max": error,
                "ok_share": 1.0,
                "cpu_s_per_simulated_s": cost,
                "measured": "2000-01-01",
            }
            for engine, settings, error, cost in rows
        ]
    )


def test_every_knob_is_a_setting_and_no_row_comes_twice() -> None:
    assert set(TRADE_KNOBS) <= set(ENGINES)
    for engine, knobs in TRADE_KNOBS.items():
        built = [build_settings(engine, dict(settings), "knobs") for settings in knobs]
        assert len(set(built)) == len(knobs), engine
    keys = [entry.key for entry in all_entries()]
    assert len(set(keys)) == len(keys)


def test_every_engine_is_measured_in_every_scene_that_it_can_do() -> None:
    entries = all_entries(knobs={"event": ({"time_step": 1e-3},)}, precisions=("float64",))
    pairs = {(entry.scene, entry.engine) for entry in entries}
    assert len(entries) == len(pairs)
    # Its scenes are blocks and stacks.
    assert {engine for _, engine in pairs} == set(ENGINES) - {"assembly"}
    assert ("stack", "housner") not in pairs
    assert ("free", "two-block") not in pairs
    # An engine without a row of knobs runs with its defaults.
    assert {e.settings["time_step"] for e in entries if e.engine == "event"} == {1e-3}
    assert all(not e.settings for e in entries if e.engine != "event")


@pytest.mark.parametrize("name", TRADE_SCENES)
def test_scenes_stay_within_what_their_references_know(name: str) -> None:
    scene = TRADE_SCENES[name]
    lanes, motions = scene.build()
    assert scene_class(lanes, motions) == name
    assert np.all(lanes.friction == 1.0)
    # two-block says itself where its model does not hold, and so does housner.
    engine = "two-block" if lanes.stacked else "housner"
    if scene.solve is fine_response:
        response = run_batch(engine, lanes, motions, scene.times)
        assert np.all(response["status"] == Status.OUTSIDE_MODEL)
        engine = "event"
    response = run_batch(engine, lanes, motions, scene.times)
    assert np.all(response["status"] == Status.OK)
    assert np.all(np.isin(response["outcome"], (Outcome.AT_REST, Outcome.ROCKING)))
    rotation = np.abs(response["rotation"]).reshape(lanes.lane_count, -1).max(axis=1)
    assert np.all((rotation > 1e-3) & (rotation < 0.5 * np.pi))


@pytest.mark.thorough
def test_where_blocks_slide_the_reference_has_converged_and_other_engines_come_to_it() -> None:
    scene = TRADE_SCENES["pulse"]
    lanes, motions = scene.build()
    assert lanes.lane_count == len(set(SINES)) == 6
    reference = scene.solve(lanes, motions, scene.times)
    assert np.all(reference["peak_slide"] > 1e-4)
    # Second order: at four times the step sixteen times the error, all of it less than a hundredth
    # of the least error that the trade tells the price of.
    coarser = build_settings("event", {"time_step": 4.0 * FINE_STEP}, "reference")
    found = run_batch("event", lanes, motions, scene.times, settings=coarser)
    assert lane_errors(found, reference, lanes).max() < 1e-2 * trade.LEVELS[-1]
    # impulse shares neither the scheme nor the contact solver; measured: 5.8e-3 and 5.1e-4.
    errors = []
    for substeps in (63, 630):
        settings = build_settings("impulse", {"substeps": substeps}, "reference")
        found = run_batch("impulse", lanes, motions, scene.times, settings=settings)
        errors.append(lane_errors(found, reference, lanes).max())
    assert errors[1] < 0.3 * errors[0]
    assert errors[1] < 1e-3


@pytest.mark.parametrize(
    ("case", "name"),
    [
        ("free-b1-b3", "free"),
        ("single-sine-pulse", "pulse"),
        ("single-continuous-sine", "sine"),
        ("record-ridgecrest", "record"),
        ("stack-sine-pulse", "stack"),
    ],
)
def test_cases_belong_to_classes(case: str, name: str) -> None:
    lane_set = expand_lanes(load_case(case))
    assert scene_class(lane_set.lanes, lane_set.motions) == name


def test_no_sample_comes_after_the_end_of_a_run() -> None:
    """The kernels of stacks had no answer for it; 140 x 5 ms is 0.7000000000000001 s."""
    for tenths in range(1, 200):
        times = SampleTimes(tenths / 10.0, 5e-3).times
        assert len(times) == 20 * tenths + 1
        assert times[-1] <= tenths / 10.0


def test_error_of_a_lane_is_that_of_its_worst_block_and_infinite_without_an_answer() -> None:
    lanes = make_lanes(np.full(3, 0.5), 1.0)
    stacked = dataclasses.replace(
        lanes,
        **{
            name: np.stack([each] * 2, axis=1)
            for name, each in lanes.arrays.items()
            if name != "angular_restitution"
        },
    )
    right = np.zeros((3, 2, 4))
    wrong = right.copy()
    wrong[0, 1, 2], wrong[1, 0, 3], wrong[2, 0, 1] = -0.2, 0.1, np.inf
    times = np.arange(4.0)
    found = lane_errors(
        Response("a", {"rotation": wrong}, times),
        Response("b", {"rotation": right}, times),
        stacked,
    )
    np.testing.assert_allclose(found, [0.2 / math.atan(0.5), 0.1 / math.atan(0.5), np.inf])


def test_rows_hold_the_error_against_the_oracle_and_a_cost(
    small: tuple[pathlib.Path, pd.DataFrame],
) -> None:
    _, table = small
    assert list(table) == list(trade.COLUMNS)
    errors = table["error_max"].to_numpy()
    # The oracle's tolerance; then the swings below which blocks rest in `event`, at any step.
    assert errors[0] < 1e-9
    assert np.all((errors[1:] > 1e-7) & (errors[1:] < 1e-6))
    assert np.all(table["error_median"] <= table["error_max"])
    assert np.all(table["ok_share"] == 1.0)
    assert np.all(table["cpu_s_per_simulated_s"] > 0.0)
    # Steps of 1e-2 s and 5e-3 s, with one more where an impact is located, in lanes that rock.
    steps = table["steps_per_simulated_s"].to_numpy()
    assert steps[2] > 1.5 * steps[1]
    rate = table["block_steps_per_cpu_s"] * table["cpu_s_per_simulated_s"]
    np.testing.assert_allclose(rate, table["steps_per_simulated_s"])


def test_steps_are_those_of_the_run_whose_cost_is_measured(
    small: tuple[pathlib.Path, pd.DataFrame],
) -> None:
    """`housner` steps from sample to sample: with samples it would seem ten times as fast."""
    _, table = small
    scene = TRADE_SCENES["free"]
    lanes, motions = scene.build()
    plain = run_batch("housner", lanes, motions, SampleTimes(scene.times.duration))
    sampled = run_batch("housner", lanes, motions, scene.times)
    steps = plain["step_count"].mean() / scene.times.duration
    assert table["steps_per_simulated_s"][0] == pytest.approx(steps)
    assert sampled["step_count"].mean() > 5.0 * plain["step_count"].mean()


def test_a_stopped_trade_goes_on_where_it_was(
    small: tuple[pathlib.Path, pd.DataFrame],
    tmp_path: pathlib.Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    _, table = small
    measured: list[Entry] = []
    by_key = {tuple(row[k] for k in trade.KEYS): row for row in table.to_dict("records")}

    def measure(entry: Entry, *_: object) -> dict[str, object]:
        measured.append(entry)
        names = [n for n in trade.COLUMNS if n not in (*trade.KEYS, *trade.PLACE, "measured")]
        return {name: by_key[entry.key][name] for name in names}

    def stop(done: int) -> None:
        if done == 2:
            raise KeyboardInterrupt

    monkeypatch.setattr(trade, "measure", measure)
    with pytest.raises(KeyboardInterrupt):
        run_trade(SMALL, tmp_path, stop)
    assert measured == SMALL[:2]
    again = run_trade(SMALL, tmp_path)
    assert measured == SMALL
    pd.testing.assert_frame_equal(again, table.assign(measured=again["measured"]))
    # Fewer rows asked for: nothing is measured, nothing lost; of an engine they come first.
    last = run_trade(SMALL[2:], tmp_path)
    assert measured == SMALL
    assert last["settings"].tolist() == again["settings"][[0, 2, 1]].tolist()
    # With other kernels, what is asked for is measured anew; the rest says what it is of.
    before = machine.kernel_hash()
    monkeypatch.setattr(machine, "kernel_hash", lambda: "other")
    mixed = run_trade(SMALL[:1], tmp_path)
    assert measured[3:] == SMALL[:1]
    assert mixed["kernel_sha256"].tolist() == ["other", before, before]
    head = trade.write_csv(mixed, tmp_path).read_text(encoding="utf-8")
    assert f"# kernel sources: sha256 other\n# kernel sources: sha256 {before}\n" in head


def test_a_table_that_cannot_be_read_is_refused_and_kept(tmp_path: pathlib.Path) -> None:
    (tmp_path / trade.TABLE).write_bytes(b"PAR1 cut off")
    with pytest.raises(InputError, match=f"{trade.TABLE}: got no Parquet.*delete it"):
        run_trade(SMALL, tmp_path)
    assert (tmp_path / trade.TABLE).read_bytes() == b"PAR1 cut off"


def test_levels_take_the_cheapest_that_met_them_in_every_lane() -> None:
    table = rows_of(
        ("event", {"time_step": 1e-2}, 2e-3, 1.0),
        ("event", {"time_step": 5e-3}, 5e-4, 2.0),
        ("event", {"time_step": 1e-3}, 5e-5, 9.0),
        ("impulse", {}, 5e-4, 4.0),
    )
    failing = rows_of(("impulse", {"substeps": 3}, 1e-4, 0.1)).assign(ok_share=0.9)
    rows = trade.level_rows(pd.concat([table, failing], ignore_index=True))
    found = {(row["engine"], row["level"]): row["cpu_s_per_simulated_s"] for row in rows}
    assert found == {
        ("event", 1e-2): 1.0,
        ("event", 1e-3): 2.0,
        ("event", 1e-4): 9.0,
        ("impulse", 1e-2): 4.0,
        ("impulse", 1e-3): 4.0,
    }


def test_front_holds_what_no_row_beats() -> None:
    table = rows_of(
        ("event", {}, 1e-3, 1.0),
        ("impulse", {}, 1e-3, 2.0),
        ("dem", {}, 1e-4, 3.0),
        ("direct", {}, 2e-4, 4.0),
        ("xpbd", {}, 1e-1, 0.5),
    )
    assert plots_trade._front(table)["engine"].tolist() == ["dem", "event", "xpbd"]


def test_choice_is_the_cheapest_that_passes_its_test() -> None:
    case = load_case("free-b1-b3", ["run.duration=5 s"])
    # The first row's error is a lie: 21 steps of 1/210 s cannot be that good.
    table = rows_of(
        ("impulse", {"frames_per_second": 10.0}, 9e-4, 1.0),
        ("impulse", {"substeps": 3}, 8e-4, 2.0),
        ("event", {"time_step": 5e-3}, 1e-4, 3.0),
        ("event", {"time_step": 1e-3}, 4e-6, 4.0),
    )
    choice = choose(case, 1e-3, table=table)
    assert (choice.engine, choice.settings["time_step"]) == ("event", 5e-3)
    assert (choice.lanes, choice.lanes_met) == (9, 9)
    # The second row is the same engine with hardly less of an error: not worth a trial.
    assert choice.test.endswith("did not pass: impulse with frames_per_second=10, float64")
    lanes = free_lanes()
    times = SampleTimes(5.0, 0.01)
    settings = build_settings("event", dict(choice.settings), "choice")
    ours = run_batch("event", lanes, StillBase(9), times, settings=settings)
    gap = np.abs(ours["rotation"] - run_batch("housner", lanes, StillBase(9), times)["rotation"])
    assert np.max(gap.max(axis=1) / lanes.slenderness_angle) <= choice.largest_error <= 1e-3


def test_choice_without_a_time_step_is_held_against_one_that_has() -> None:
    table = rows_of(("housner", {}, 1e-11, 1.0), ("event", {"time_step": 1e-3}, 4e-6, 3.0))
    choice = choose(load_case("free-b1-b3"), 1e-4, table=table)
    assert choice.engine == "housner"
    assert choice.lanes_met == 9
    assert 0.0 < choice.largest_error < 1e-4
    assert "against event with time_step=0.001" in choice.test
    # Enough for B1 to lift (0.67) and for its impacts (0.45).
    low = load_case("free-b1-b3", ["contact.friction=0.7"])
    assert choose(low, 1e-4, table=table).engine == "housner"
    sliding = load_case("single-sine-pulse")  # friction 1.0, its velocity steps need 2.2
    assert choose(sliding, 1e-4, table=table.assign(scene="pulse")).engine == "event"


def test_test_of_a_choice_does_not_compare_the_end_of_a_fall() -> None:
    """At scales 0.75 and 1 of the record the block falls: half a radian in a hundredth second."""
    table = rows_of(
        ("housner", {}, 1e-11, 1.0), ("event", {"time_step": 2e-4}, 3e-4, 3.0), scene="record"
    )
    choice = choose(load_case("record-ridgecrest"), 2e-2, engine="housner", table=table)
    fell = run_batch("housner", *_scene_of("record-ridgecrest"))["outcome"] == Outcome.OVERTURNED
    assert fell.sum() == 2
    assert choice.lanes_met == len(fell) == 7


def _scene_of(name: str) -> tuple[Lanes, GroundMotions, SampleTimes]:
    lane_set = expand_lanes(load_case(name))
    return lane_set.lanes, lane_set.motions, SampleTimes(lane_set.times.duration)


def test_choice_names_the_best_where_nothing_met_the_tolerance() -> None:
    case = load_case("free-b1-b3")
    table = rows_of(("event", {"time_step": 5e-3}, 1e-4, 1.0), ("impulse", {}, 2e-3, 2.0))
    with pytest.raises(InputError, match=r"the best is 0.0001, event with time_step=0.005"):
        choose(case, 1e-5, table=table)
    with pytest.raises(InputError, match=r"impulse: nothing.*the best is 0.002"):
        choose(case, 1e-3, engine="impulse", table=table)
    with pytest.raises(InputError, match=r"any engine in float32: nothing was measured"):
        choose(case, 1e-3, precision="float32", table=table)
    for bad in (0.0, 1.0, math.nan, -1e-3):
        with pytest.raises(InputError, match="must be > 0 and < 1"):
            choose(case, bad, table=table)


def test_shipped_table_is_that_of_the_engines() -> None:
    table = shipped_trade()
    for row in table.to_dict("records"):
        build_settings(row["engine"], json.loads(row["settings"]), "shipped")
    fixed = table["engine"].isin([name for name in ENGINES if not engine_class(name).slides])
    sliding = table[~fixed]
    for name in TRADE_SCENES:
        assert len(trade.cheapest(sliding[sliding["scene"] == name], 1e-3)) > 0, name
    references = table[fixed & (table["precision"] == "float64")]
    assert set(references["scene"]) == set(TRADE_SCENES)
    # Where blocks slide neither of them holds, and says so.
    slides = [TRADE_SCENES[name].solve is fine_response for name in references["scene"]]
    assert np.all(references["ok_share"] == np.where(slides, 0.0, 1.0))
    assert np.all(references["error_max"][~np.array(slides)] < 1e-8)


@pytest.mark.parametrize("engine", ["event", "impulse"])
def test_shipped_errors_are_those_of_today(engine: str) -> None:
    scene = TRADE_SCENES["free"]
    lanes, motions = scene.build()
    reference = run_batch("housner", lanes, motions, scene.times)
    table = shipped_trade()
    chosen = table[(table["engine"] == engine) & (table["scene"] == "free")]
    for row in chosen[chosen["precision"] == "float64"].head(4).to_dict("records"):
        settings = build_settings(engine, json.loads(row["settings"]), "shipped")
        response = run_batch(engine, lanes, motions, scene.times, settings=settings)
        # Round-off differs between processors and may move a few impacts of `impulse` into the
        # next step, each by a part of the error.
        assert lane_errors(response, reference, lanes).max() == pytest.approx(
            row["error_max"], rel=0.02
        )


@pytest.mark.thorough
def test_run_takes_the_cheapest_within_its_tolerance(tmp_path: pathlib.Path) -> None:
    arguments = ["run", "free-b1-b3", "-s", "run.duration=2 s", "--cheapest", "--tolerance", "1e-3"]
    result = succeed(*arguments, "-e", "event", "--precision", "float64", "--json", "-o", tmp_path)
    found = json.loads(result.stdout)
    assert found["engine"]["name"] == found["choice"]["engine"] == "event"
    assert found["engine"]["settings"] == found["choice"]["settings"]
    assert found["choice"]["lanes_met"] == 9
    assert "the cheapest of" in found["choice"]["why"]
    written = json.loads((tmp_path / "run.json").read_text(encoding="utf-8"))
    assert written["engine"] == found["engine"]
    refused = invoke(*arguments, "-s", "engines.event.time_step=0.1")
    assert refused.exit_code == 2
    assert "chooses the settings itself" in refused.stderr
    bare = invoke(*arguments[:4], "--cheapest", "--no-estimate")
    assert bare.exit_code == 2
    assert "--no-estimate" in bare.stderr
    printed = succeed(*arguments)
    assert "CPU s a simulated second" in printed.stdout


@pytest.mark.usefixtures("pages_bare")
def test_trade_writes_what_it_prints(tmp_path: pathlib.Path) -> None:
    arguments = ["trade", "--scene", "free", "-e", "housner", "-o", str(tmp_path)]
    result = succeed(*arguments)
    names = {path.name for path in tmp_path.iterdir()}
    assert names == {"trade.parquet", "trade.csv", "trade.png", "report.html"}
    assert "free: blocks B1 to B3" in result.stdout
    shipped_form = pd.read_csv(tmp_path / "trade.csv", comment="#")
    assert list(shipped_form) == list(shipped_trade())
    assert shipped_form["precision"].tolist() == ["float64", "float32"]
    for bad in (["--scene", "moon"], ["-e", "moon"]):
        assert invoke(*arguments, *bad).exit_code == 2


def test_choice_becomes_overrides_that_a_case_reads() -> None:
    choice = Choice("event", {"time_step": 5e-05}, "float64", "", "", 1, 1, 0.0)
    case = load_case("free-b1-b3", choice.overrides)
    assert case.engine_settings("event").time_step == 5e-5
    assert engine_class("event")(case.engine_settings("event")).settings.time_step == 5e-5
