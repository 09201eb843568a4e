"""The compliant contact engine on stacks of blocks: what its kernel takes and leaves."""

from __future__ import annotations

from types import ModuleType
from typing import Any

import numpy as np

from warprock.engines.decoding import lane_fields, planar_fields
from warprock.engines.launching import Form, Kernel, Target, respond
from warprock.engines.soundness import account_of, contacts_hold, unstable
from warprock.engines.stack_launching import (
    Array,
    body_columns,
    carried,
    launch_stacks,
    stack_columns,
    stack_module,
    start_on_corners,
)
from warprock.kernels.modes import UNSOLVED
from warprock.model.lanes import Lanes
from warprock.model.motion import GroundMotions
from warprock.model.response import Response, SampleTimes, Status
from warprock.settings.engines import DirectSettings
from warprock.units import GRAVITY

DIRECT_STACK = Kernel("direct/stack_run", Form.PLAIN)
"""The kernel of stacks: one lane a thread on any device."""


def direct_stack_module(target: Target, lanes: Lanes, motions: GroundMotions) -> ModuleType:
    """The instance of the kernel file for a batch of stacks."""
    return stack_module(DIRECT_STACK, target, motions, lanes)


def run_direct_stacks(
    settings: DirectSettings,
    target: Target,
    lanes: Lanes,
    motions: GroundMotions,
    times: SampleTimes,
) -> Response:
    """Runs a batch of stacks on the calling thread; see `AbstractEngine.run`."""
    module = direct_stack_module(target, lanes, motions)
    rows, per_block, rotations = launch_stacks(
        module,
        target,
        motions,
        times,
        _blocks(lanes, settings),
        stack_columns(lanes),
        _knobs(module, settings),
    )
    step, mode = settings.time_step, rows["mode"]
    hold = contacts_hold(lanes, settings.contact_stiffness)
    gained = unstable(lanes, account_of(rows, step), per_block["peak"], rigid=hold)
    # In the last step of the run no end had parted, and nothing slid.
    marks = [(mode == UNSOLVED, Status.ITERATION_LIMIT), (gained, Status.UNSTABLE)]
    columns = lane_fields(rows, times.times[-1] - 0.5 * step, marks) | planar_fields(per_block)
    return respond("direct", columns, rotations, times)


def _knobs(module: Any, settings: DirectSettings) -> Any:
    step, stiffness = settings.time_step, settings.contact_stiffness
    drag = step * stiffness + settings.contact_damping
    knobs = module.Knobs()
    knobs.time_step = step
    knobs.rate = 1.0 / step
    knobs.gravity = GRAVITY
    knobs.margin = 2.0 * GRAVITY * step**2
    knobs.box = settings.friction_box
    knobs.cfm = 1.0 / (step * drag)
    knobs.erp = step * stiffness / drag
    return knobs


def _blocks(lanes: Lanes, settings: DirectSettings) -> dict[str, Array]:
    """Fields of the struct `Block`, shape [lane, block] each.

    A stack that stands flat starts sunk into its springs by its weight; that springs under an
    eccentric weight tilt it is left to the first moments of the run, as is the sinking of a turned
    block.
    """
    x, z, left, right = start_on_corners(lanes)
    above, centre = carried(lanes, x)
    share = np.clip((centre - left) / np.maximum(right - left, 1e-12), 0.0, 1.0)
    turn = np.diff(lanes.rotation_start, axis=1, prepend=0.0)
    on_right = np.select([turn > 0.0, turn < 0.0], [1.0, 0.0], share)
    flat = ~lanes.rotation_start.any(axis=1, keepdims=True)
    sunk = np.where(flat, 0.5 * GRAVITY * above / settings.contact_stiffness, 0.0)
    weight = GRAVITY * settings.time_step * above
    return {
        **body_columns(lanes),
        "x": x,
        "z": z - np.cumsum(sunk, axis=1),
        "left": weight * (1.0 - on_right),
        "right": weight * on_right,
    }
