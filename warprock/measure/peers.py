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

from warprock.engines import engine_class
from warprock.engines.launching import Form
from warprock.measure import bench
from warprock.model.motion import StillBase
from warprock.programs.table import PROGRAMS, run_program
from warprock.settings.programs import PEER_SETTINGS

PEERS = ("mujoco", "bullet")
"""Peers that are run, the fast ones: names of programs, and of their extras."""

SUBSTEPS = (20, 200)
"""Steps in each 1 / `bench.B0_SAMPLING`, from coarse to fine."""

CPU_LIMIT = 5.0
"""CPU time that a run may take [s], as told from the coarser one."""

IN_SPACE = "impulse"
"""Engine whose steps in space are counted beside theirs."""

AGAINST = "event"
"""Engine whose cost the peers' are held against."""


def compare(accuracy: Sequence[Mapping[str, Any]], seconds: float) -> dict[str, Any]:
    """Runs every peer that is installed.

    Args:
        accuracy: Rows of `bench.accuracy_row`, that of `event` among them.
        seconds: Time of a measurement of `event`, about [s].

    Returns:
        rows (one a peer and step: its cost and error, and the ratios to the cost of `event`),
        space (`space_row`), missing (one sentence for each peer that is not installed).
    """
    ours = [row for row in accuracy if row["engine"] == AGAINST]
    rows: list[dict[str, Any]] = []
    missing = []
    for name in PEERS:
        try:
            rows += measure(name, ours, seconds)
        except ImportError as error:
            missing.append(str(error))
    return {"rows": rows, "space": space_row(rows, seconds), "missing": missing}


def space_row(rows: Sequence[Mapping[str, Any]], seconds: float) -> dict[str, Any]:
    """Steps that a block in space takes in a CPU second, with ours and with each peer.

    Args:
        rows: One a peer and step, as `measure` gives them.
        seconds: Time of the measurement of ours, about [s].
    """
    cost = bench.measure(IN_SPACE, seconds, form=Form.PACKED, spatial=True).cpu_s_per_simulated_s
    time_step: float = engine_class(IN_SPACE)().settings.time_step
    row = {"engine": f"{IN_SPACE} in space", "block_steps_per_cpu_s": 1.0 / (cost * time_step)}
    for peer in dict.fromkeys(row["peer"] for row in rows):
        mine = (r for r in rows if r["peer"] == peer)
        best = max(r["steps_per_s"] / r["cpu_s_per_simulated_s"] for r in mine)
        row |= {peer: best, f"ratio to {peer}": row["block_steps_per_cpu_s"] / best}
    return row


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
