"""The velocity-level contact engine on stacks of blocks: what its kernel takes and leaves."""

from __future__ import annotations

from types import ModuleType

from warprock.engines.decoding import lane_fields, planar_fields
from warprock.engines.launching import Kernel, Target, respond
from warprock.engines.soundness import account_of, unstable
from warprock.engines.stack_launching import (
    block_columns,
    launch_stacks,
    stack_columns,
    stack_module,
)
from warprock.model.lanes import Lanes
from warprock.model.motion import GroundMotions
from warprock.model.response import Response, SampleTimes, Status
from warprock.settings.engines import ImpulseSettings
from warprock.units import GRAVITY


def impulse_stack(target: Target) -> Kernel:
    """The kernel of stacks."""
    return Kernel("impulse/stack_run", target.kernel_form)


def impulse_stack_module(
    settings: ImpulseSettings, target: Target, lanes: Lanes, motions: GroundMotions
) -> ModuleType:
    """The instance of the kernel file for a batch of stacks."""
    return stack_module(impulse_stack(target), target, motions, lanes, settings.iterations)


def run_impulse_stacks(
    settings: ImpulseSettings,
    target: Target,
    lanes: Lanes,
    motions: GroundMotions,
    times: SampleTimes,
) -> Response:
    """Runs a batch of stacks on the calling thread; see `AbstractEngine.run`."""
    module = impulse_stack_module(settings, target, lanes, motions)
    knobs = module.Knobs()
    knobs.time_step = settings.time_step
    knobs.rate = 1.0 / settings.time_step
    knobs.gravity = GRAVITY
    knobs.collision_margin = settings.collision_margin
    knobs.erp = settings.erp
    stacks = stack_columns(lanes)
    blocks = block_columns(lanes, GRAVITY * settings.time_step)
    rows, per_block, rotations = launch_stacks(
        module, target, motions, times, blocks, stacks, knobs
    )
    step = settings.time_step
    gained = unstable(lanes, account_of(rows, step), per_block["peak"])
    # In the last step of the run no end had parted, and nothing slid.
    marks = [(gained, Status.UNSTABLE)]
    columns = lane_fields(rows, times.times[-1] - 0.5 * step, marks) | planar_fields(per_block)
    return respond("impulse", columns, rotations, times)
