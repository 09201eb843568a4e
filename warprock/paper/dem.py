"""How the paper's distinct-element column of Table 6 depends on what its springs are.

`dem` with the parameters of Table 5 beside the paper's DEM and beside Housner, nothing fitted; then
one knob at a time, and the corrected damping: the printed one, 2 / (1418 Hz x 2 pi) with a damping
of 1, is critical at 1418 Hz and 5 to 7 % of critical at this block's own contact frequency, where
4.4e-3 s would be critical. Springs stiff enough, two an interface and damped likewise, with
friction that holds the velocity step, show the rigid limit.
"""

from __future__ import annotations

import dataclasses
import pathlib
from typing import Any

import numpy as np

from warprock.engines import engine_class
from warprock.engines.dem import equivalent_restitution
from warprock.model import rocking
from warprock.model.batch import Batch
from warprock.model.response import SampleTimes
from warprock.paper.printed import paper_columns
from warprock.paper.runs import (
    PULSE,
    KernelUse,
    PaperRuns,
    Reproduction,
    Row,
    write_rows,
    written_number,
)
from warprock.settings.engines import DemSettings

CORRECTED = {"stiffness_damping": 4.4e-3}
RIGID = {
    "normal_stiffness": 1e11,
    "shear_stiffness": 1e11,
    "stiffness_damping": 4.4e-4,
    "subcontacts": 2,
}
HOLDING_FRICTION = 5.0
"""Friction at which the velocity step at the start does not slide the block."""

RELEASED_FROM = 0.5
"""Part of the slenderness angle from which the block is let go to find its restitution."""

VARIANTS: tuple[tuple[str, float | None, dict[str, Any], float | None], ...] = (
    ("Table 5", None, {}, None),
    *(("sub-contacts", float(n), {"subcontacts": n}, None) for n in (2, 5, 10, 20)),
    *(
        ("damping beta [s]", beta, {"stiffness_damping": beta}, None)
        for beta in (0.0, 1.1e-4, 2.25e-4, 4.5e-4)
    ),
    *(
        ("step / stable step", safety, {"step_safety": safety}, None)
        for safety in (0.8, 0.4, 0.2, 0.1, 0.01)
    ),
    ("corrected damping", 4.4e-3, CORRECTED, None),
    ("corrected, two springs", 4.4e-3, CORRECTED | {"subcontacts": 2}, HOLDING_FRICTION),
    ("rigid limit: 1e11 N/m^3", 4.4e-4, RIGID, HOLDING_FRICTION),
)
"""Knob, its value, the settings that differ from Table 5, and the friction where it differs."""


def dem_batches(runs: PaperRuns) -> list[KernelUse]:
    """What the study runs, for its kernels."""
    lane_set = runs.case(PULSE).lane_set
    return [
        (engine_class("dem")(DemSettings(**changed)), lane_set.lanes, lane_set.motions)
        for _, _, changed, _ in VARIANTS
    ]


def run_dem_study(target: str, runs: PaperRuns, folder: pathlib.Path) -> Reproduction:
    """Table 6's six inputs under displacement control with every variant of the springs.

    Rows have the `knob`, its `value`, `source`, `peak_rotation_ratio`, `paper_off` and
    `housner_off` (relative differences from the paper's DEM and from Housner's block),
    `restitution` and `housner_restitution` (angular, of the block let go from half of its
    slenderness angle: what the springs amount to, and Housner's), and
    `steps_per_s`.
    """
    lane_set = runs.case(PULSE).lane_set
    chosen = lane_set.select({"reading": "displacement"})
    lanes, motions = lane_set.lanes.take(chosen), lane_set.motions.take(chosen)
    inputs = lane_set.inputs.iloc[chosen]
    times = SampleTimes(lane_set.times.duration)
    slenderness = lanes.slenderness_angle
    held, _ = runs.timed("housner", Batch(lanes, motions, times))
    rigid = held["peak_rotation"] / slenderness
    # A motion of no amplitude needs no kernel of its own.
    at_rest = motions.take(slice(0, 1)).scaled(np.zeros(1))
    paper = paper_columns("table6")["dem"]
    rows: list[Row] = []
    for knob, value, changed, friction in VARIANTS:
        run_lanes = lanes
        if friction is not None:
            run_lanes = dataclasses.replace(lanes, friction=np.full_like(lanes.friction, friction))
        batch = Batch(run_lanes, motions, times)
        response, _ = runs.timed("dem", batch, settings=DemSettings(**changed))
        ratio = response["peak_rotation"] / slenderness
        alike = dataclasses.replace(
            run_lanes.take(slice(0, 1)), rotation_start=RELEASED_FROM * slenderness[:1]
        )
        restitution = float(equivalent_restitution(alike, DemSettings(**changed), at_rest)[0])
        rows += [
            {
                "target": target,
                "frequency_hz": written_number(inputs["frequency_hz"].iloc[lane]),
                "amplitude_mm": written_number(inputs["amplitude_mm"].iloc[lane]),
                "reading": "displacement",
                "source": "dem",
                "peak_rotation_ratio": float(ratio[lane]),
                "knob": knob,
                "value": value,
                "friction": float(run_lanes.friction[lane]),
                "paper_off": float(ratio[lane] / paper[lane] - 1.0),
                "housner_off": float(ratio[lane] / rigid[lane] - 1.0),
                "restitution": restitution,
                "housner_restitution": float(rocking.angular_restitution(slenderness[lane])),
                "steps_per_s": int(response["step_count"][lane]) / times.duration,
            }
            for lane in range(len(chosen))
        ]
    return Reproduction(rows, [write_rows(rows, folder / f"{target}.csv")])
