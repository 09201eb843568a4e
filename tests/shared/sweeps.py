"""A small sweep that several test files run: blocks of many sizes under 3 s of a short record."""

from __future__ import annotations

import pathlib

from warprock.case.case import Case
from warprock.case.load import load_case
from warprock.sweeps.chunks import merge
from warprock.sweeps.plan import Plan, make_plan, write_plan
from warprock.sweeps.run import Shard, chunks_to_run, run_here

LANES = 300
CASE = f"""
title = "Blocks of many sizes"
source = "made up"
[block]
width = "0.2 m"
height = "1 m"
depth = "0.5 m"
density = "2400 kg/m^3"
[contact]
friction = 1.0
[motion]
waveform = "record"
record = "shake.csv"
[run]
duration = "3 s"
[sample]
lanes = {LANES // 2}
[[sweep]]
label.site = ["near", "far"]
motion.start = ["0 s", "0.1 s"]
[sample.over]
block.height = {{ distribution = "uniform", from = "0.5 m", to = "2 m" }}
motion.scale = {{ distribution = "lognormal", median = 1.0, dispersion = 0.5 }}
"""
RECORD = "# unit: g\n# interval: 0.1 s\n" + "\n".join(
    str(value) for value in (0.0, 0.5, -0.6, 0.7, -0.2, 0.4, -0.8, 0.9, 0.0)
)


def write_case(folder: pathlib.Path, text: str = CASE) -> pathlib.Path:
    """Writes the case and its record to a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "shake.csv").write_text(RECORD, encoding="utf-8")
    file = folder / "case.toml"
    file.write_text(text, encoding="utf-8")
    return file


def planned(case: Case, folder: pathlib.Path, chunk_lanes: int, engine: str = "housner") -> Plan:
    """A plan that lies in a folder."""
    plan = make_plan(case, engine, chunk_lanes=chunk_lanes)
    write_plan(plan, folder)
    return plan


def run_all(plan: Plan, folder: pathlib.Path, *, shards: int = 1, workers: int = 1) -> None:
    """Runs what is missing of a sweep, the last shard first."""
    for number in range(shards, 0, -1):
        chunks = chunks_to_run(plan, folder, Shard(number, shards))
        run_here(plan, folder, workers)(chunks, lambda done: None)


def merged_bytes(
    file: pathlib.Path, folder: pathlib.Path, chunk_lanes: int, *, shards: int = 1, workers: int = 1
) -> bytes:
    """The merged table of a sweep that nothing disturbed."""
    plan = planned(load_case(file), folder, chunk_lanes)
    run_all(plan, folder, shards=shards, workers=workers)
    return merge(plan, folder).read_bytes()
