"""The paper's run times beside ours: one lane on one core, and one of a batch of lanes.

The paper's are wall times of whole programs on two workstations; ours are the CPU time of an
engine at its default settings, on whatever machine this runs, kernels built before.
"""

from __future__ import annotations

import pathlib
from typing import Any

import numpy as np
import pandas as pd

from warprock.case.lanes import LaneSet
from warprock.engines import ENGINES, engine_class
from warprock.engines.base import KernelEngine
from warprock.model.batch import Batch
from warprock.paper.conflict_texts import Conflict
from warprock.paper.printed import PAPER_COLUMNS, paper_columns
from warprock.paper.runs import (
    PULSE,
    SINE,
    STACK_PULSE,
    STACK_SINE,
    KernelUse,
    PaperRuns,
    Reproduction,
    Row,
    write_rows,
    written_number,
)
from warprock.running.batch import LANE_QUANTUM

SCENES: dict[tuple[str, str], tuple[str, dict[str, str]]] = {
    ("single", "pulse"): (PULSE, {"reading": "displacement"}),
    ("single", "sine"): (SINE, {"reading": "displacement"}),
    ("stack", "pulse"): (
        STACK_PULSE,
        {"reading": "displacement", "geometry": "printed", "edges": "chamfered"},
    ),
    ("stack", "sine"): (
        STACK_SINE,
        {"reading": "displacement", "geometry": "printed", "edges": "chamfered"},
    ),
}
"""System and excitation of the paper's run times -> the shipped case, and labels of its lane."""

BATCH = LANE_QUANTUM
"""Lanes of a batch: one pack. To a kernel that takes lanes one by one a lane is a batch."""
SPREAD = 0.01
"""Part by which the amplitudes of a batch differ, so that its lanes do not do the same."""
REPEATS, ENOUGH = 3, 0.15
"""Runs of a lane, of which the quickest counts, and CPU time [s] after which no more are made."""


def scene_lane(lane_set: LaneSet, labels: dict[str, str], inputs: Any) -> int:
    """The lane of a case with certain labels, frequency [Hz] and amplitude [mm]."""
    table = lane_set.inputs.iloc[lane_set.select(labels)]
    same = np.isclose(table["frequency_hz"], inputs["frequency_hz"]) & np.isclose(
        table["amplitude_mm"], inputs["amplitude_mm"]
    )
    (lane,) = table.index[same]
    return int(lane)


def spread_batch(lane_set: LaneSet, lane: int, count: int) -> Batch:
    """A lane many times over, with amplitudes that differ by `SPREAD` from least to largest."""
    places = np.full(count, lane)
    factor = 1.0 + SPREAD * np.linspace(-0.5, 0.5, count)
    motions = lane_set.motions.take(places).scaled(factor)
    return Batch(lane_set.lanes.take(places), motions, lane_set.times)


def times_batches(runs: PaperRuns) -> list[KernelUse]:
    """What is timed, for its kernels."""
    sets = [runs.case(case).lane_set for case, _ in SCENES.values()]
    return [
        (engine_class(name)(), lane_set.lanes, lane_set.motions)
        for lane_set in sets
        for name in _engines(lane_set)
    ]


def _engines(lane_set: LaneSet) -> list[str]:
    """Engines that can do a scene."""
    return [name for name in ENGINES if engine_class(name).supports(lane_set.scene) is None]


def run_times(target: str, runs: PaperRuns, folder: pathlib.Path) -> Reproduction:
    """Times every engine that can do a scene, on the scenes whose run times the paper prints."""
    rows: list[Row] = []
    printed = {
        (row["system"], row["excitation"]): row for row in paper_columns("run-times").records
    }
    for scene, (case, labels) in SCENES.items():
        lane_set = runs.case(case).lane_set
        inputs = printed[scene]
        shared: Row = {
            "target": target,
            "frequency_hz": written_number(inputs["frequency_hz"]),
            "amplitude_mm": written_number(inputs["amplitude_mm"]),
            "reading": "displacement",
            "system": scene[0],
            "excitation": scene[1],
            "duration_s": lane_set.times.duration,
            "peak_rotation_ratio": None,
        }
        rows += [
            shared
            | {
                "source": f"paper-{name}",
                "reading": "as printed",
                "duration_s": None,
                "wall_s": float(inputs[f"{name}_s"]),
            }
            for name in PAPER_COLUMNS[1:]
        ]
        lane = scene_lane(lane_set, labels, inputs)
        rows += [
            shared | {"source": engine} | _time_engine(runs, engine, lane_set, lane)
            for engine in _engines(lane_set)
        ]
    return Reproduction(
        rows, [write_rows(rows, folder / f"{target}.csv")], (_find_swap(pd.DataFrame(rows)),)
    )


def _time_engine(runs: PaperRuns, engine: str, lane_set: LaneSet, lane: int) -> Row:
    alone = np.array([lane])
    one = Batch(lane_set.lanes.take(alone), lane_set.motions.take(alone), lane_set.times)
    response, seconds = runs.timed(engine, one, repeats=REPEATS, enough=ENOUGH)
    each, built = seconds, engine_class(engine)()
    if not isinstance(built, KernelEngine) or built.kernel_of(one.lanes).lanes > 1:
        _, of_all = runs.timed(engine, spread_batch(lane_set, lane, BATCH))
        each = of_all / BATCH
    return {
        "cpu_s": seconds,
        "cpu_s_per_lane": each,
        "step_count": int(response["step_count"][0]),
    }


def _find_swap(rows: pd.DataFrame) -> Conflict:
    """The paper's times of pulse and sine against the steps that ours take."""
    single = rows[(rows["system"] == "single")].set_index(["excitation", "source"])
    pulse, sine = (single["duration_s"][kind, "impulse"] for kind in ("pulse", "sine"))
    dearer = single["cpu_s"]["sine", "impulse"] / single["cpu_s"]["pulse", "impulse"]
    wall = single["wall_s"]
    return Conflict(
        11,
        "run times of pulse and sine",
        f"The lengths of the runs are not printed with the times; ours are {pulse:g} s for the "
        f"pulse and {sine:g} s for the sine on the single block, which the figures show. The paper "
        f"prints {wall['pulse', 'paper-bullet']:g} s for the pulse and "
        f"{wall['sine', 'paper-bullet']:g} s for the sine with Bullet and Vortex, less for the "
        f"longer run, but more with 3DEC; `impulse` takes {dearer:.1f} times as long for the sine "
        "as for the pulse. The two look swapped. Likely.",
    )
