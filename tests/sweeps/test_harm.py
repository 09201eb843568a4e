"""What may happen to a sweep: killed, stopped, cut off, mixed up, without room, on a cluster."""

from __future__ import annotations

import contextlib
import importlib.util
import json
import os
import pathlib
import pickle
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator

import pyarrow.parquet as pq
import pytest

from tests.shared.commands import invoke
from tests.shared.sweeps import planned, run_all
from warprock.case.load import load_case
from warprock.cli.exits import EXIT_RESUMABLE
from warprock.errors import InputError, Said
from warprock.sweeps import dask as sweep_dask
from warprock.sweeps import run as sweep_run
from warprock.sweeps.chunks import CHUNKS, chunk_path, find_chunks, merge
from warprock.sweeps.plan import Plan, read_plan
from warprock.sweeps.run import Shard, chunks_to_run, run_chunk

ROOT = pathlib.Path(__file__).resolve().parents[2]
KILLS = 20

on_posix = pytest.mark.skipif(os.name != "posix", reason="signals and limits of POSIX systems")


@pytest.fixture
def plan(case_file: pathlib.Path, tmp_path: pathlib.Path) -> Plan:
    """A plan of five chunks in the folder of the test, none of them run."""
    return planned(load_case(case_file), tmp_path, 64)


@pytest.fixture
def done(plan: Plan, tmp_path: pathlib.Path) -> Plan:
    """The same plan, all of its chunks done."""
    run_all(plan, tmp_path)
    return plan


def start(*arguments: object) -> subprocess.Popen[str]:
    command = [sys.executable, "-m", *(str(argument) for argument in arguments)]
    return subprocess.Popen(
        command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )


@pytest.mark.thorough
@on_posix
def test_a_sweep_that_is_killed_twenty_times_loses_nothing(case_file, undisturbed, tmp_path):
    plan = planned(load_case(case_file), tmp_path, 5)
    process = start("tests.shared.sweep_killer", tmp_path, KILLS, 1)
    said, errors = process.communicate(timeout=120)
    assert process.returncode == 0, errors
    rows = json.loads(said)
    done = [row["done"] for row in rows]
    assert sum(row["hit"] for row in rows) == len(rows) == KILLS
    assert done == sorted(done)
    assert 0 < done[-1] < plan.chunk_count
    # Those killed amid a write left half a chunk, which nobody takes for one; the next run saw
    # that its writer is no more, and took it away.
    assert all(row["half"] == 1 for row in rows[2::3])
    kept = {path: path.stat().st_mtime_ns for path in (tmp_path / CHUNKS).glob("chunk-*")}
    assert len(kept) == done[-1]
    run_all(plan, tmp_path)
    assert all(path.stat().st_mtime_ns == time for path, time in kept.items())
    assert merge(plan, tmp_path).read_bytes() == undisturbed
    assert not list((tmp_path / CHUNKS).glob(".*"))


@on_posix
@pytest.mark.parametrize(
    ("number", "code"),
    [(signal.SIGTERM, 75), (signal.SIGUSR1, 75), (signal.SIGINT, 130)],
)
def test_signals_drop_the_chunk_in_hand(
    plan: Plan, tmp_path, monkeypatch, interruptible, number, code
):
    honest = sweep_run.run_lane_set

    def run_and_signal(engine, lane_set, *arguments, **options):
        if lane_set.first == 128:
            os.kill(os.getpid(), number)
        return honest(engine, lane_set, *arguments, **options)

    monkeypatch.setattr(sweep_run, "run_lane_set", run_and_signal)
    handler = signal.getsignal(number)
    result = invoke("sweep", "run", tmp_path)
    assert result.exit_code == code
    assert f"to go on: warprock sweep run {tmp_path}" in result.stderr
    assert chunks_to_run(plan, tmp_path, Shard()) == [2, 3, 4]
    assert signal.getsignal(number) is handler


@pytest.mark.thorough
@on_posix
def test_a_process_that_is_told_to_stop_ends_at_once(case_file, undisturbed, tmp_path):
    planned(load_case(case_file), tmp_path, 20)
    process = start("warprock", "sweep", "run", tmp_path, "--workers", 1)
    limit = time.monotonic() + 60.0
    while not chunk_path(tmp_path, 1).exists() and time.monotonic() < limit:
        time.sleep(0.005)
    process.send_signal(signal.SIGTERM)
    errors = process.communicate(timeout=60)[1]
    assert process.returncode == EXIT_RESUMABLE == 75, errors
    assert "SIGTERM: the chunk in hand is dropped" in errors
    assert "Traceback" not in errors
    plan = read_plan(tmp_path)
    assert 0 < len(chunks_to_run(plan, tmp_path, Shard())) < plan.chunk_count
    assert not list((tmp_path / CHUNKS).glob(".*"))
    run_all(plan, tmp_path)
    assert merge(plan, tmp_path).read_bytes() == undisturbed


def test_two_workers_on_one_chunk_write_the_same(plan: Plan, tmp_path):
    ready = threading.Barrier(2)

    def work() -> None:
        ready.wait()
        run_chunk(plan, tmp_path, 0, workers=1)

    threads = [threading.Thread(target=work) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    both = chunk_path(tmp_path, 0)
    once = both.read_bytes()
    both.unlink()
    run_chunk(plan, tmp_path, 0, workers=1)
    assert both.read_bytes() == once
    assert [path.name for path in (tmp_path / CHUNKS).iterdir()] == [both.name]


def test_a_chunk_of_another_plan_is_refused_and_kept(case_file, done: Plan, tmp_path):
    other = planned(load_case(case_file, ["sample.seed=2"]), tmp_path / "other", 64)
    run_all(other, tmp_path / "other")
    place = chunk_path(tmp_path, 2)
    shutil.copy(chunk_path(tmp_path / "other", 2), place)
    foreign = place.read_bytes()
    for command in ("run", "merge"):
        result = invoke("sweep", command, tmp_path)
        assert result.exit_code == 2
        assert f"{place}: got another file: it is of the plan {other.id[:12]}" in result.stderr
    assert place.read_bytes() == foreign
    assert not (tmp_path / "lanes.parquet").exists()
    status = invoke("sweep", "status", tmp_path)
    assert "foreign: 1: 2" in status.stdout
    # So is another chunk of the same plan, one of another length, and another table.
    for source, word in (
        (chunk_path(tmp_path, 0), "it is chunk 0, lanes 0 to 64"),
        (tmp_path / "other.parquet", "it is no chunk of a sweep"),
    ):
        if not source.exists():
            pq.write_table(pq.read_table(chunk_path(tmp_path, 0)).drop_columns(["lane"]), source)
            pq.write_table(pq.read_table(source).replace_schema_metadata(None), source)
        shutil.copy(source, place)
        assert word in invoke("sweep", "run", tmp_path).stderr


def test_chunks_that_are_not_all_there_are_not_merged(done: Plan, tmp_path):
    merged = merge(done, tmp_path).read_bytes()
    chunk_path(tmp_path, 1).unlink()
    chunk_path(tmp_path, 4).unlink()
    result = invoke("sweep", "merge", tmp_path)
    assert result.exit_code == 2
    assert "missing chunk-000001.parquet, chunk-000004.parquet" in result.stderr
    assert f"warprock sweep run {tmp_path}" in result.stderr
    whole = chunk_path(tmp_path, 3).read_bytes()
    chunk_path(tmp_path, 3).write_bytes(whole[: len(whole) // 2])
    result = invoke("sweep", "merge", tmp_path)
    assert "broken chunk-000003.parquet" in result.stderr
    table = pq.read_table(chunk_path(tmp_path, 0))
    pq.write_table(table.slice(1), chunk_path(tmp_path, 0))
    assert next(find_chunks(done, tmp_path, [0])).why == "it has 63 rows for 64"
    assert "broken chunk-000000.parquet" in invoke("sweep", "merge", tmp_path).stderr
    assert (tmp_path / "lanes.parquet").read_bytes() == merged


def test_a_flipped_bit_is_found(done: Plan, tmp_path):
    path = chunk_path(tmp_path, 0)
    column = pq.read_metadata(path).row_group(0).column(3)
    content = bytearray(path.read_bytes())
    content[column.data_page_offset + column.total_compressed_size - 9] ^= 1
    path.write_bytes(content)
    result = invoke("sweep", "merge", tmp_path)
    assert result.exit_code == 2
    assert f"{path}: got damaged data" in result.stderr
    assert not (tmp_path / "lanes.parquet").exists()


@contextlib.contextmanager
def files_of_at_most(size: int) -> Iterator[None]:
    """A disk that is full after some bytes of each file."""
    import resource

    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


@on_posix
def test_a_full_disk_loses_nothing(plan: Plan, undisturbed, tmp_path):
    run_chunk(plan, tmp_path, 0)
    first = chunk_path(tmp_path, 0).read_bytes()
    with files_of_at_most(8000):
        result = invoke("sweep", "run", tmp_path)
    assert result.exit_code == 1
    assert "chunk 1 (" in result.stderr
    assert "could not be written: " in result.stderr
    assert "File too large; nothing else is lost" in result.stderr
    assert "Traceback" not in result.stderr
    assert [path.name for path in (tmp_path / CHUNKS).iterdir()] == ["chunk-000000.parquet"]
    assert chunk_path(tmp_path, 0).read_bytes() == first
    run_all(plan, tmp_path)
    assert merge(plan, tmp_path).read_bytes() == undisturbed
    with files_of_at_most(8000):
        result = invoke("sweep", "merge", tmp_path)
    assert result.exit_code == 1
    assert "could not be written" in result.stderr
    assert (tmp_path / "lanes.parquet").read_bytes() == undisturbed
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "chunks",
        "lanes.parquet",
        "plan.json",
    ]


def test_the_state_of_an_empty_sweep(plan: Plan, tmp_path):
    (tmp_path / CHUNKS).mkdir()
    (tmp_path / CHUNKS / "notes.txt").write_text("mine", encoding="utf-8")
    found = json.loads(invoke("sweep", "status", tmp_path, "--json").stdout)
    assert found["missing"] == [0, 1, 2, 3, 4]
    assert found["lanes_done"] == 0
    assert found["strangers"] == [str(tmp_path / CHUNKS / "notes.txt")]
    assert all(not chunk.counts for chunk in find_chunks(plan, tmp_path, range(5)))


@pytest.mark.extra
def test_a_cluster_writes_the_same(case_file, undisturbed, tmp_path):
    pytest.importorskip("distributed", reason="the extra [dask] is not installed")
    planned(load_case(case_file), tmp_path, 64)
    process = start(*("warprock", "sweep", "run", tmp_path, "--scheduler", "local", "--workers", 2))
    errors = process.communicate(timeout=120)[1]
    assert process.returncode == 0, errors
    assert merge(read_plan(tmp_path), tmp_path).read_bytes() == undisturbed


def test_without_dask_one_line_names_the_extra(plan: Plan, tmp_path, monkeypatch):
    honest = importlib.util.find_spec
    monkeypatch.setattr(
        sweep_dask.importlib.util,
        "find_spec",
        lambda name: None if name == "distributed" else honest(name),
    )
    result = invoke("sweep", "run", tmp_path, "--scheduler", "local")
    assert result.exit_code == 2
    assert result.stderr.count("\n") == 1
    assert "[dask]" in result.stderr


def test_errors_pass_from_process_to_process():
    error = InputError("case.toml", "block.width", Said("nothing"), "must be given")
    again = pickle.loads(pickle.dumps(error))
    assert str(again) == str(error) == "case.toml: block.width: got nothing, must be given"
    assert again.key == "block.width"
