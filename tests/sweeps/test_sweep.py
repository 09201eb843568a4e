"""Sweeps: the lanes of a case in chunks, the same bytes however they are cut, shared, resumed."""

from __future__ import annotations

import json
import os
import pathlib

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest

from tests.shared.commands import invoke
from tests.shared.marks import first
from tests.shared.sweeps import CASE, LANES, merged_bytes, planned, run_all, write_case
from warprock.case.load import load_case
from warprock.errors import InputError
from warprock.model.response import Status
from warprock.running import case_run as runner
from warprock.running.lane_table import lane_table
from warprock.sweeps import plan as sweep_plan
from warprock.sweeps import run as sweep_run
from warprock.sweeps.chunks import chunk_path, merge, sweep_state
from warprock.sweeps.plan import make_plan, read_plan, require_same_software
from warprock.sweeps.run import Shard, chunks_to_run, read_shard, run_chunk

ENSEMBLE = """
[ensemble]
members = 10
time_step = "10 %"
spread.block.height = "5 %"
"""


def same_tables(one: pd.DataFrame, other: pd.DataFrame) -> bool:
    """Whether two tables have the same values, whatever holds their words."""
    assert list(one.columns) == list(other.columns)
    words = [name for name in one if not pd.api.types.is_numeric_dtype(one[name])]
    plain = [table.astype(dict.fromkeys(words, object)) for table in (one, other)]
    return plain[0].equals(plain[1])


def test_a_sweep_has_the_lanes_of_a_run(case_file: pathlib.Path, undisturbed: bytes, tmp_path):
    case = load_case(case_file)
    run = runner.run_case(case, "housner", histories=False)
    expected = lane_table(run.lane_set, run.response)
    (tmp_path / "lanes.parquet").write_bytes(undisturbed)
    found = pq.read_table(tmp_path / "lanes.parquet")
    assert same_tables(found.to_pandas(), expected)
    height = found.schema.field("height_m").metadata
    assert (height[b"unit"], height[b"text"]) == (b"m", b"Full height of the block")
    assert set(expected["outcome"]) >= {"rocking", "overturned"}


@pytest.mark.parametrize(
    ("chunk_lanes", "shards", "workers"),
    first(3, [(64, 1, 2), (64, 7, 1), (1, 1, 1), (64, 1, 1), (64, 2, 1), (37, 1, 1)]),
)
def test_bytes_do_not_depend_on_chunks_shards_and_threads(
    case_file, undisturbed, tmp_path, monkeypatch, chunk_lanes, shards, workers
):
    if chunk_lanes == 1:
        case_file = write_case(tmp_path / "small", CASE.replace("lanes = 150", "lanes = 5"))
        undisturbed = merged_bytes(case_file, tmp_path / "one", 10)
    found = merged_bytes(case_file, tmp_path / "sweep", chunk_lanes, shards=shards, workers=workers)
    assert found == undisturbed


def test_row_groups_do_not_follow_chunks(case_file: pathlib.Path, tmp_path, monkeypatch):
    monkeypatch.setattr("warprock.sweeps.chunks.ROW_GROUP", 70)
    for chunk_lanes in (64, 300):
        merged_bytes(case_file, tmp_path / str(chunk_lanes), chunk_lanes)
    one, other = (tmp_path / str(lanes) / "lanes.parquet" for lanes in (64, 300))
    assert one.read_bytes() == other.read_bytes()
    groups = pq.read_metadata(one)
    rows = [groups.row_group(at).num_rows for at in range(groups.num_row_groups)]
    assert rows == [70, 70, 70, 70, 20]
    assert pq.read_table(one)["lane"].to_pylist() == list(range(LANES))


def test_members_of_an_ensemble_may_fall_into_several_chunks(tmp_path: pathlib.Path):
    text = CASE[: CASE.index("[sample]")].replace('"3 s"', '"0.5 s"') + "[[sweep]]\n"
    text += 'motion.start = ["0 s", "0.1 s"]\n' + ENSEMBLE
    case = load_case(write_case(tmp_path, text))
    plan = planned(case, tmp_path / "sweep", 7, "event")
    run_all(plan, tmp_path / "sweep")
    found = pd.read_parquet(merge(plan, tmp_path / "sweep"))
    run = runner.run_case(case, "event", histories=False)
    assert same_tables(found, lane_table(run.lane_set, run.response))
    assert found["time_step_factor"].nunique() > 2


def test_errors_are_estimated_where_the_plan_says_so(tmp_path: pathlib.Path):
    case = load_case(write_case(tmp_path), ["sample.lanes=4", "run.duration=0.5 s"])
    plan = make_plan(case, "event", chunk_lanes=3)
    sweep_plan.write_plan(plan, tmp_path / "sweep")
    run_all(plan, tmp_path / "sweep")
    found = pd.read_parquet(merge(plan, tmp_path / "sweep"))
    run = runner.run_case(case, "event", histories=False)
    assert same_tables(found, lane_table(run.lane_set, run.response))
    assert "rotation_error_rad" in found


def test_only_what_is_missing_is_run_again(case_file, undisturbed, tmp_path):
    plan = planned(load_case(case_file), tmp_path, 64)
    run_all(plan, tmp_path)
    chunk_path(tmp_path, 1).unlink()
    cut = chunk_path(tmp_path, 3)
    cut.write_bytes(cut.read_bytes()[:-100])
    kept = {number: chunk_path(tmp_path, number).stat().st_mtime_ns for number in (0, 2, 4)}
    assert chunks_to_run(plan, tmp_path, Shard()) == [1, 3]
    state = sweep_state(plan, tmp_path)
    assert (state["missing"], state["broken"], state["foreign"]) == ([1], [3], [])
    assert (state["chunks_done"], state["lanes_done"]) == (3, 64 + 64 + 44)
    run_all(plan, tmp_path)
    for number, time in kept.items():
        assert chunk_path(tmp_path, number).stat().st_mtime_ns == time
    assert merge(plan, tmp_path).read_bytes() == undisturbed
    state = sweep_state(plan, tmp_path)
    assert sum(state["status"].values()) == sum(state["outcome"].values()) == LANES


def test_the_state_of_a_sweep_counts_lanes_by_word(case_file, tmp_path):
    plan = planned(load_case(case_file), tmp_path, 64)
    for number in (0, 4):
        run_chunk(plan, tmp_path, number)
    run = runner.run_case(load_case(case_file), "housner", histories=False)
    table = lane_table(run.lane_set, run.response)
    some = pd.concat([table[:64], table[256:]])
    done = some["outcome"]
    result = invoke("sweep", "status", tmp_path, "--json")
    found = json.loads(result.stdout)
    counted = done.value_counts()
    assert found["outcome"] == {word: counted.get(word, 0) for word in found["outcome"]}
    # Of some lanes `housner` says that their block would slide or be pulled.
    usable = found["status"]["ok"] + found["status"]["outside_model"]
    assert usable == len(done) == found["lanes_done"]
    # The record is over after 1 s, but 2 s later blocks still rock.
    assert found["undecided"]["lanes"] == int(some["undecided"].sum()) > 0
    printed = invoke("sweep", "status", tmp_path).stdout
    assert f"undecided: {found['undecided']['lanes']} lanes" in printed
    assert "2 of 5 done" in printed
    assert "missing: 3: 1, 2, 3" in printed


def test_the_commands_make_a_table(case_file, undisturbed, tmp_path):
    folder = tmp_path / "sweep"
    plan = invoke(
        "sweep", "plan", case_file, "-e", "housner", "--chunk", 100, "-o", folder, "--json"
    )
    facts = json.loads(plan.stdout)
    assert (facts["lanes"], facts["chunks"], facts["written"]) == (LANES, 3, True)
    again = invoke("sweep", "plan", case_file, "-e", "housner", "--chunk", 100, "-o", folder)
    assert "there already" in again.stdout
    for shard, done in (("2/2", 100), ("1/2", 300)):
        result = invoke("sweep", "run", folder, "--shard", shard, "--workers", 1)
        assert result.exit_code == 0, result.stderr
        assert f"{done} lanes to run" in result.stderr or done == 300
        assert "lanes/s" in result.stderr
        assert read_plan(folder).id == facts["plan"]
    result = invoke("sweep", "merge", folder, "-o", tmp_path / "all.parquet")
    assert result.stdout.splitlines()[0] == str(tmp_path / "all.parquet")
    assert (tmp_path / "all.parquet").read_bytes() == undisturbed
    done = invoke("sweep", "run", folder)
    assert "3 chunks done before, 0 chunks, 0 lanes to run" in done.stderr


def test_a_shard_leads_to_the_merge_once_all_of_them_are_done(case_file, tmp_path):
    plan = planned(load_case(case_file), tmp_path, 64)
    left = plan.chunk_count
    for shard in (3, 1, 4, 2):
        result = invoke("sweep", "run", tmp_path, "--shard", f"{shard}/4", "--workers", 1)
        assert result.exit_code == 0, result.stderr
        left -= len(Shard(shard, 4).chunks(plan))
        assert f"of shard {shard}/4, of {LANES} in all, done" in result.stdout
        (following,) = (line for line in result.stdout.splitlines() if line.startswith("next: "))
        assert following == f"next: warprock sweep {'status' if left else 'merge'} {tmp_path}"
        counts = json.loads(
            invoke("sweep", "run", tmp_path, "--shard", f"{shard}/4", "--json").stdout
        )
        assert counts["chunks_left"] == left
        merged = invoke(*following.removeprefix("next: warprock ").split())
        assert merged.exit_code == 0, merged.stderr


def test_too_many_bad_lanes_are_told_by_the_exit_code(case_file, tmp_path, monkeypatch):
    planned(load_case(case_file), tmp_path, 100)
    honest = sweep_run.run_lane_set

    def broken(*arguments, **options):
        response = honest(*arguments, **options)
        response.fields["status"][:10] = Status.NONFINITE
        return response

    monkeypatch.setattr(sweep_run, "run_lane_set", broken)
    for share, code in ((0.09, 4), (0.1, 0), (None, 0)):
        limit = () if share is None else ("--max-bad", share)
        result = invoke("sweep", "run", tmp_path, *limit, "--json")
        assert result.exit_code == code
        assert json.loads(result.stdout)["bad"] == 30


def test_the_id_is_that_of_what_is_computed(case_file: pathlib.Path):
    def id_of(*overrides: str, engine: str = "housner", chunk_lanes: int = 100) -> str:
        return make_plan(load_case(case_file, overrides), engine, chunk_lanes=chunk_lanes).id

    same = id_of()
    assert id_of(chunk_lanes=64) == same
    others = [
        id_of("sample.seed=2"),
        id_of("engines.housner.rest_rotation_ratio=1e-6"),
        id_of("run.duration=2.5 s"),
        id_of(engine="event"),
    ]
    # The first key of a sample has the first dimension of its points.
    swapped = CASE.splitlines()
    swapped[-1], swapped[-2] = swapped[-2], swapped[-1]
    write_case(case_file.parent / "swapped", "\n".join(swapped))
    case = load_case(case_file.parent / "swapped")
    others.append(make_plan(case, "housner").id)
    assert len({same, *others}) == 6


def test_a_plan_is_enough_to_run_by(case_file, undisturbed, tmp_path):
    case_folder = tmp_path / "case"
    planned(load_case(write_case(case_folder)), tmp_path / "sweep", 100)
    (case_folder / "case.toml").unlink()
    plan = read_plan(tmp_path / "sweep")
    run_all(plan, tmp_path / "sweep")
    merged = pq.read_metadata(merge(plan, tmp_path / "sweep")).metadata
    content = json.loads(merged[b"warprock"])
    assert content == plan.content
    assert content["engine"]["name"] == "housner"
    assert content["records"][0]["sha256"]
    assert content["case"]["resolved"]["sample"]["lanes"] == LANES // 2


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--chunk", 0), ["--chunk", "got 0", "from 1"]),
        (("-e", "hausner"), ["--engine", "'hausner'"]),
        (("-e", "two-block"), ["--engine", "'two-block'", "cannot do this scene"]),
        (("--precision", "float16"), ["--precision", "'float16'"]),
        (("-e", "housner", "-s", "block.width=3 m"), ["'housner'", "1.414 times the height"]),
        # Only lanes drawn near the end of the height's range slide before they rock.
        (("-e", "housner", "-s", "contact.friction=0.101"), ["--engine", "slides before it rocks"]),
        (("-s", 'motion.start="5 s"'), ["motion.start", "before the end of the run"]),
    ],
)
def test_what_cannot_be_run_is_refused_when_it_is_planned(case_file, tmp_path, arguments, words):
    folder = tmp_path / "sweep"
    result = invoke("sweep", "plan", case_file, "--chunk", 10, "-o", folder, *arguments)
    assert result.exit_code == 2
    assert result.stderr.count("\n") == 1
    assert all(word in result.stderr for word in words), result.stderr
    assert not folder.exists()


def test_a_study_is_not_swept(tmp_path):
    result = invoke("sweep", "plan", "sensitivity-b0", "-o", tmp_path / "sweep")
    assert result.exit_code == 2
    assert "study" in result.stderr
    assert not (tmp_path / "sweep").exists()


def test_a_folder_has_one_plan(case_file, tmp_path):
    planned(load_case(case_file), tmp_path, 100)
    before = (tmp_path / "plan.json").read_bytes()
    for other in (("--chunk", 50), ("--chunk", 100, "-s", "sample.seed=2")):
        result = invoke("sweep", "plan", case_file, "-o", tmp_path, *other)
        assert result.exit_code == 2
        assert "holds another plan" in result.stderr
    assert (tmp_path / "plan.json").read_bytes() == before


def test_a_plan_that_was_changed_is_refused(case_file, tmp_path):
    planned(load_case(case_file), tmp_path, 100)
    path = tmp_path / "plan.json"
    text = path.read_text(encoding="utf-8")
    wrongs = {
        text.replace('"width": "0.2 m"', '"width": "0.3 m"'): "changed after it was written",
        text[:-9]: "must be JSON",
        "{}": "as it was written",
    }
    for wrong, words in wrongs.items():
        path.write_text(wrong, encoding="utf-8")
        for command in ("run", "status", "merge"):
            result = invoke("sweep", command, tmp_path)
            assert result.exit_code == 2
            assert str(path) in result.stderr
            assert words in result.stderr
    path.unlink()
    assert "sweep plan CASE -o DIR" in invoke("sweep", "run", tmp_path).stderr


def test_other_software_does_not_go_on(case_file, tmp_path, monkeypatch):
    plan = planned(load_case(case_file), tmp_path, 100)
    require_same_software(plan)
    monkeypatch.setattr(sweep_plan.machine, "kernel_hash", lambda: "another")
    result = invoke("sweep", "run", tmp_path)
    assert result.exit_code == 2
    assert "kernel_sha256: got 'another'" in result.stderr
    assert not (tmp_path / "chunks").exists()


def test_another_record_does_not_go_on(case_file, tmp_path):
    case = load_case(write_case(tmp_path / "case"))
    plan = planned(case, tmp_path / "sweep", 100)
    record = tmp_path / "case" / "shake.csv"
    record.write_text(record.read_text(encoding="utf-8").replace("0.9", "0.8"), encoding="utf-8")
    with pytest.raises(InputError, match=r"records\.0\.sha256"):
        chunks_to_run(read_plan(tmp_path / "sweep"), tmp_path / "sweep", Shard())
    assert plan.id == read_plan(tmp_path / "sweep").id


@pytest.mark.parametrize("text", ["0/2", "3/2", "2", "a/b", "1/0", "-1/2"])
def test_a_shard_is_one_of_several(text: str):
    with pytest.raises(InputError, match="must be i/n"):
        read_shard(text)


def test_shards_share_the_chunks(case_file):
    plan = make_plan(load_case(case_file), "housner", chunk_lanes=10)
    parts = [read_shard(f"{number} / 7").chunks(plan) for number in range(1, 8)]
    assert sorted(chunk for part in parts for chunk in part) == list(range(30))
    assert max(map(len, parts)) - min(map(len, parts)) <= 1


def test_lanes_far_into_a_long_sample_cost_no_more_memory(case_file):
    import tracemalloc

    from warprock.case.lanes import expand_lanes

    peaks = []
    for lanes in (1000, 10**9):
        overrides = [f"sample.lanes={lanes}", "sample.sampling=lhs"]
        case = load_case(case_file, overrides)
        tracemalloc.start()
        part = expand_lanes(case, range(lanes - 500, lanes))
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
        assert np.isfinite(part.inputs["height_m"]).all()
    # Numbers of 500 lanes take the same room, whatever the numbers are.
    assert peaks[1] < 1.5 * peaks[0]


@pytest.mark.thorough
def test_many_more_lanes_are_planned_and_merged_in_the_same_memory(
    case_file, tmp_path, monkeypatch
):
    import tracemalloc

    import pyarrow as pa

    monkeypatch.setattr("warprock.sweeps.chunks.ROW_GROUP", 750)
    before, peaks = pa.default_memory_pool(), []
    for samples in (1000, 6000):
        folder = tmp_path / str(samples)
        case = load_case(case_file, [f"sample.lanes={samples}"])
        # What is imported, and the points of a sample, are there once and for all.
        planned(case, folder, 500)
        tracemalloc.start()
        plan = make_plan(case, "housner", chunk_lanes=500)
        planned_in = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        run_all(plan, folder)
        # A pool of its own tells the most that a merge has held at a time.
        arrow = pa.proxy_memory_pool(before)
        pa.set_memory_pool(arrow)
        try:
            tracemalloc.start()
            merge(plan, folder)
            merged_in = tracemalloc.get_traced_memory()[1] + arrow.max_memory()
            assert sweep_state(plan, folder)["lanes_done"] == 2 * samples
            tracemalloc.stop()
        finally:
            pa.set_memory_pool(before)
        peaks.append((planned_in, merged_in, pq.read_table(folder / "lanes.parquet").nbytes))
    few, many = peaks
    assert many[0] < 1.1 * few[0]
    # What grows is the footer of the file, with row groups of a two hundredth of their usual lanes.
    assert many[1] - few[1] < 0.05 * (many[2] - few[2])


@pytest.mark.thorough
@pytest.mark.skipif(os.name != "posix", reason="memory of processes is told by POSIX systems")
def test_the_benchmark_measures_whole_sweeps(python):
    # In a process of its own: the memory of this one is that of all tests before.
    done = python("-m", "warprock", *["bench", "sweep", "--lanes", "40", "-e", "housner", "--json"])
    (row,) = json.loads(done.stdout)["rows"]
    # One of the blocks would slide.
    assert (row["engine"], row["lanes"], row["ok"]) == ("housner", 40, 39)
    assert row["lanes_per_s"] == pytest.approx(40 / row["seconds"])
    assert row["cpu_us_per_lane"] == pytest.approx(1e6 * row["cpu_s"] / 40)
    # More than an interpreter with NumPy, and far below what is promised.
    assert 50.0 < row["peak_memory_mb"] < 1500.0
    for wrong, words in (("--lanes=0", "--lanes"), ("--engine=hausner", "--engine")):
        refused = invoke("bench", "sweep", wrong)
        assert refused.exit_code == 2
        assert words in refused.stderr
