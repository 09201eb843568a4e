"""Physics engines of others beside ours: the same block, the same error, one run.

A peer is there where its extra is installed. It runs block B0 over 5 s as `bench` does, one scene
at a time, as on a CPU it has no batches; so its cost is held against that of `event` twice: for one
block of many, and for a block alone, each at an error no larger than the peer's.
"""

from __future__ import annotations

import importlib
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from warprock import bench
from warprock.motion import StillBase
from warprock.reference.peer_programs import PROGRAMS, run_program
from warprock.reference.peer_settings import PEER_SETTINGS

PEERS = ("mujoco", "bullet")
"""Peers that are run, the fast ones: names of programs, and of their extras."""

SUBSTEPS = (20, 200)
"""Steps in each 1 / `bench.B0_SAMPLING`, from coarse to fine."""

CPU_LIMIT = 5.0
"""CPU time that a run may take [s], as told from the coarser one."""

AGAINST = "event"
"""Engine whose cost the peers' are held against."""


def compare(accuracy: Sequence[Mapping[str, Any]], seconds: float) -> dict[str, Any]:
    """Runs every peer that is installed.

    Args:
        accuracy: Rows of `bench.accuracy_row`, that of `event` among them.
        seconds: Time of a measurement of `event`, about [s].

    Returns:
        rows (one a peer and step: its cost and error, and the ratios to the cost of `event`),
        missing (one sentence for each peer that is not installed).
    """
    ours = [row for row in accuracy if row["engine"] == AGAINST]
    rows: list[dict[str, Any]] = []
    missing = []
    for name in PEERS:
        try:
            rows += measure(name, ours, seconds)
        except ImportError as error:
            missing.append(str(error))
    return {"rows": rows, "missing": missing}


def measure(name: str, ours: list[Mapping[str, Any]], seconds: float) -> list[dict[str, Any]]:
    """Runs one peer on B0, at finer steps for as long as they fit into `CPU_LIMIT`.

    Args:
        name: Name in `PEERS`.
        ours: Rows of `event` to hold its cost against, coarse to fine; where all of them are less
            accurate than the peer, a finer one is measured and joins them.
        seconds: Time of such a measurement, about [s].

    Returns:
        One row a step, the finest last.

    Raises:
        ImportError: The peer is not installed; one line that names the extra.
    """
    lanes, times = bench.b0_lanes(np.array([bench.B0_RATIO])), bench.b0_times()
    rows: list[dict[str, Any]] = []
    for substeps in SUBSTEPS:
        if rows and rows[-1]["cpu_s"] * substeps / SUBSTEPS[len(rows) - 1] > CPU_LIMIT:
            break
        rate = bench.B0_SAMPLING * substeps
        settings = PEER_SETTINGS[name](steps_per_second=rate)
        answer = run_program(name, lanes, StillBase(1), times, settings)
        response = answer.response
        error = bench.b0_error(response.times, response["rotation"][0])
        if all(row["error"] > error for row in ours):
            ours.append(bench.accuracy_row(AGAINST, seconds, error))
        fair = next((row for row in ours if row["error"] <= error), ours[-1])
        rows.append(
            {
                "peer": name,
                "settings": importlib.import_module(PROGRAMS[name].module).SETTINGS,
                "steps_per_s": rate,
                "error": error,
                "cpu_s": answer.cpu_s,
                "cpu_s_per_simulated_s": answer.cost,
                f"{AGAINST}_error": fair["error"],
                f"cost / {AGAINST}": answer.cost / fair["cpu_s_per_simulated_s"],
                f"cost / {AGAINST}_alone": answer.cost / fair["cpu_s_per_simulated_s_alone"],
            }
        )
    return rows
