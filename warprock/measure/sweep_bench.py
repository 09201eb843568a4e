"""What a sweep costs on this machine from its plan to the merged table: time, memory, lanes.

Each of the three commands runs in a process of its own, as a user's would, so that start-up and the
largest memory are those of a sweep and of nothing else.
"""

from __future__ import annotations

import os
import pathlib
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from typing import Any

from warprock.case.sampling import MOST_POINTS
from warprock.engines import preferred_engines, reference_engine
from warprock.errors import InputError, Said

CASE = "record-sample"
"""Shipped case whose sample is enlarged."""

LANES = (10_000, 1_000_000)
"""Lanes of the sweeps measured: a cost in proportion has the same lanes a second in both."""

ENGINES = (reference_engine(), preferred_engines()[0])

RESTITUTION = "sample.over.contact.angular_restitution={distribution='uniform', from=0.85, to=0.97}"
"""What else is drawn for the engine whose law it is."""

_BYTES_OF_MAXRSS = 1 if sys.platform == "darwin" else 1024


def run_sweep_bench(
    lanes: Sequence[int] = LANES,
    engines: Sequence[str] = ENGINES,
    *,
    workers: int | None = None,
    report: Callable[[str], None] | None = None,
) -> list[dict[str, Any]]:
    """Measures sweeps.

    Args:
        lanes: Lanes of each sweep.
        engines: Engines, each at its default settings.
        workers: Worker threads; the cores at hand where None.
        report: Called with what is about to be measured.

    Returns:
        One row a sweep: engine, lanes, seconds (from the start of the plan to the merged table),
        lanes_per_s, cpu_s (of all processes), cpu_us_per_lane, peak_memory_mb (of the largest
        process), table_mb, ok (lanes with that status).

    Raises:
        InputError: A number of lanes out of bounds.
        OSError: A command failed.
    """
    for count in lanes:
        if not 1 <= count <= MOST_POINTS:
            allowed = f"must be a number of lanes from 1 to {MOST_POINTS}"
            raise InputError("--lanes", "", count, allowed)
    if not hasattr(os, "wait4"):
        allowed = "must run where a process tells what it used (Linux, macOS)"
        raise InputError("bench sweep", "", Said(sys.platform), allowed)
    rows = []
    for engine in engines:
        for count in lanes:
            if report is not None:
                report(f"bench sweep: {count} lanes with {engine}")
            rows.append(_measure(engine, count, workers))
    return rows


def _measure(engine: str, lanes: int, workers: int | None) -> dict[str, Any]:
    threads = [] if workers is None else ["--workers", str(workers)]
    drawn = ["-s", f"sample.lanes={lanes}"] + (
        ["-s", RESTITUTION] if engine == reference_engine() else []
    )
    with tempfile.TemporaryDirectory() as place:
        folder = str(pathlib.Path(place) / "sweep")
        begin = time.perf_counter()
        used = [
            _command("plan", CASE, "-e", engine, *drawn, "--no-estimate", "-o", folder),
            _command("run", folder, *threads),
            _command("merge", folder),
        ]
        seconds = time.perf_counter() - begin
        table = pathlib.Path(folder) / "lanes.parquet"
        cpu = sum(each[0] for each in used)
        return {
            "engine": engine,
            "lanes": lanes,
            "seconds": seconds,
            "lanes_per_s": lanes / seconds,
            "cpu_s": cpu,
            "cpu_us_per_lane": 1e6 * cpu / lanes,
            "peak_memory_mb": max(each[1] for each in used) / 1e6,
            "table_mb": table.stat().st_size / 1e6,
            "ok": _ok_lanes(table),
        }


def _command(*arguments: str) -> tuple[float, float]:
    """CPU time [s] and largest memory [byte] of a sweep command in a process of its own."""
    command = [sys.executable, "-m", "warprock", "sweep", *arguments]
    with tempfile.TemporaryFile() as errors:
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=errors)
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode:
            errors.seek(0)
            said = errors.read().decode(errors="replace").strip()
            raise OSError(f"warprock sweep {' '.join(arguments)} failed: {said}")
    return usage.ru_utime + usage.ru_stime, float(usage.ru_maxrss * _BYTES_OF_MAXRSS)


def _ok_lanes(table: pathlib.Path) -> int:
    import pyarrow.parquet as pq

    words = pq.read_table(table, columns=["status"])["status"]
    counts = words.value_counts().to_pylist()
    return sum(each["counts"] for each in counts if each["values"] == "ok")
