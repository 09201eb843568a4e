"""The velocity-level contact engine on blocks in space: what its kernels take and leave."""

from __future__ import annotations

from types import ModuleType
from typing import Any

import numpy as np
import numpy.typing as npt

from warprock.engines.launching import Form, Target, respond, time_or_nan
from warprock.engines.settings import ImpulseSettings
from warprock.engines.spatial_launching import (
    block_columns,
    block_fields,
    histories,
    launch_spatial,
    unstable_in_space,
)
from warprock.kernels.instance import LANE_WIDTH, kernel_module
from warprock.lanes import Lanes
from warprock.motion import GroundMotions
from warprock.response import Outcome, Response, SampleTimes, Status
from warprock.units import GRAVITY

OVERTURNED, BROKEN, SLID_OFF = 2, 3, 4
"""Modes of a lane in the kernels."""


def spatial_impulse_module(
    settings: ImpulseSettings, target: Target, lanes: Lanes, motions: GroundMotions
) -> ModuleType:
    """The instance of the kernel file for a batch of blocks in space."""
    packs = target.kernel_form is Form.PACKED and not lanes.stacked
    module: ModuleType = kernel_module(
        "spatial_impulse_stack_launch" if lanes.stacked else "spatial_impulse_launch",
        precision=target.precision,
        motion=motions.kind.value,
        blocks=lanes.block_count,
        lanes=LANE_WIDTH if packs else 1,
        friction="box" if settings.friction_box else "cone",
    )
    return module


def run_spatial_impulse(
    settings: ImpulseSettings,
    target: Target,
    lanes: Lanes,
    motions: GroundMotions,
    times: SampleTimes,
) -> Response:
    """Runs a batch of blocks in space on the calling thread; see `AbstractEngine.run`."""
    module = spatial_impulse_module(settings, target, lanes, motions)
    knobs = module.Knobs()
    knobs.time_step = settings.time_step
    knobs.rate = 1.0 / settings.time_step
    knobs.gravity = GRAVITY
    knobs.collision_margin = settings.collision_margin
    knobs.erp = settings.erp
    knobs.sweeps = settings.iterations
    blocks = block_columns(lanes)
    rows, per_block, attitudes = launch_spatial(module, target, motions, times, blocks, knobs)
    mode = rows["mode"]
    # Of single blocks the kernel knows the energy of unit mass.
    lost = rows["loss"] if lanes.stacked else lanes.mass * rows["loss"]
    moved = np.asarray(rows["moved"], dtype=np.float64)
    # In the last step of the run all corners touched.
    resting = (mode < OVERTURNED) & (moved < times.times[-1] - 0.5 * settings.time_step)
    columns: dict[str, npt.NDArray[Any]] = {
        **block_fields(lanes, per_block),
        "outcome": np.select(
            [mode == OVERTURNED, mode == SLID_OFF, resting],
            [Outcome.OVERTURNED, Outcome.SLID_OFF, Outcome.AT_REST],
            Outcome.ROCKING,
        ),
        "status": np.select(
            [mode == BROKEN, unstable_in_space(lanes, motions, lost)],
            [Status.NONFINITE, Status.UNSTABLE],
            Status.OK,
        ),
        "impact_count": rows["impacts"],
        "uplift_time": time_or_nan(rows["uplift_time"]),
        "rest_time": np.where(resting, moved, np.nan),
        "peak_penetration": rows["deepest"],
        "energy_lost": lost,
        "step_count": rows["steps"],
    }
    rotations, others = histories(lanes, attitudes)
    return respond("impulse", columns, rotations, times, others)
