"""The event-driven contact engine on stacks of blocks: what its kernel takes and leaves."""

from __future__ import annotations

from types import ModuleType
from typing import Any

import numpy as np
import numpy.typing as npt

from warprock.engines.launching import (
    Form,
    Kernel,
    Target,
    respond,
    step_limit,
    time_or_nan,
)
from warprock.engines.stack_launching import Array, launch_stacks, stack_module
from warprock.kernels.modes import BROKEN, OVERTURNED, SLID_OFF, STALLED, UNSOLVED
from warprock.model import rocking
from warprock.model.lanes import Lanes
from warprock.model.motion import GroundMotions
from warprock.model.response import Outcome, Response, SampleTimes, Status
from warprock.settings.engines import EventSettings
from warprock.units import GRAVITY

PHASE_STEP = 0.25
"""Longest step as a part of 1 / p of the quickest block: a longer one does not follow its own
rocking."""

EVENT_STACK = Kernel("event/stack_run", Form.PLAIN)
"""The kernel of stacks: one lane a thread on any device."""


def event_stack_module(target: Target, lanes: Lanes, motions: GroundMotions) -> ModuleType:
    """The instance of the kernel file for a batch of stacks."""
    return stack_module(EVENT_STACK, target, motions, lanes)


def run_event_stacks(
    settings: EventSettings,
    target: Target,
    lanes: Lanes,
    motions: GroundMotions,
    times: SampleTimes,
) -> Response:
    """Runs a batch of stacks on the calling thread; see `AbstractEngine.run`."""
    module = event_stack_module(target, lanes, motions)
    knobs = module.Knobs()
    knobs.gravity = GRAVITY
    rate = rocking.frequency_parameter(lanes.width, lanes.height).max(axis=1)
    longest_step = np.minimum(settings.time_step, PHASE_STEP / rate)
    stacks = {
        "mass": lanes.mass.sum(axis=1),
        "longest_step": longest_step,
        "step_limit": step_limit(motions, times, longest_step),
    }
    rows, per_block, rotations = launch_stacks(
        module, target, motions, times, _blocks(settings, lanes), stacks, knobs
    )
    mode = rows["mode"]
    rest_time = time_or_nan(rows["rest_time"])
    columns: dict[str, npt.NDArray[Any]] = {
        "peak_rotation": per_block["peak"],
        "peak_time": per_block["peak_time"],
        "outcome": np.select(
            [mode == OVERTURNED, mode == SLID_OFF, np.isfinite(rest_time)],
            [Outcome.OVERTURNED, Outcome.SLID_OFF, Outcome.AT_REST],
            Outcome.ROCKING,
        ),
        "status": np.select(
            [mode == BROKEN, mode == STALLED, mode == UNSOLVED],
            [Status.NONFINITE, Status.EVENT_LIMIT, Status.ITERATION_LIMIT],
            Status.OK,
        ),
        "impact_count": rows["impacts"],
        "uplift_time": time_or_nan(rows["uplift_time"]),
        "rest_time": rest_time,
        "residual_slide": per_block["slide"],
        "peak_slide": per_block["peak_slide"],
        "peak_penetration": rows["deepest"],
        "energy_lost": rows["loss"],
        "step_count": rows["steps"],
    }
    return respond("event", columns, rotations, times)


def _blocks(settings: EventSettings, lanes: Lanes) -> dict[str, Array]:
    """Fields of the struct `Block`, shape [lane, block] each."""
    inertia = lanes.mass * (lanes.width**2 + lanes.height**2) / 12.0
    return {
        "half_height": 0.5 * lanes.height,
        "half_face": 0.5 * lanes.face_width,
        "inverse_mass": 1.0 / lanes.mass,
        "inverse_inertia": 1.0 / inertia,
        "friction": lanes.friction,
        "rest_rotation": settings.rest_rotation_ratio * lanes.slenderness_angle,
        "offset": lanes.offset,
        "rotation_start": lanes.rotation_start,
    }
