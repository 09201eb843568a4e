"""The velocity-level contact engine on stacks of blocks: what its kernel takes and leaves."""

from __future__ import annotations

from types import ModuleType

import numpy as np

from warprock.engines.launching import NEVER, Target, respond
from warprock.engines.settings import ImpulseSettings
from warprock.engines.soundness import account_of, unstable
from warprock.engines.stack_launching import (
    Array,
    launch_stacks,
    stack_module,
    start_on_corners,
)
from warprock.engines.stepping import lane_fields, planar_fields
from warprock.lanes import Lanes
from warprock.motion import GroundMotions
from warprock.response import Response, SampleTimes, Status
from warprock.units import GRAVITY


def impulse_stack_module(
    settings: ImpulseSettings, target: Target, lanes: Lanes, motions: GroundMotions
) -> ModuleType:
    """The instance of the kernel file for a batch of stacks."""
    return stack_module("impulse_stack_launch", target, motions, lanes, settings.iterations)


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
    # In the last step of the run both ends of every interface carried something.
    marks = [(gained, Status.UNSTABLE)]
    columns = lane_fields(rows, times.times[-1] - 0.5 * step, marks) | planar_fields(per_block)
    return respond("impulse", columns, rotations, times)


def stack_columns(lanes: Lanes) -> dict[str, Array]:
    """Fields of the struct `Stack`, shape [lane] each."""
    turned = np.diff(lanes.rotation_start, axis=1, prepend=0.0)
    # The first number of a stack that is not the same in its mirror image.
    odd = np.concatenate([lanes.rotation_start, lanes.offset], axis=1)
    first = np.take_along_axis(odd, np.argmax(odd != 0.0, axis=1)[:, None], axis=1)[:, 0]
    return {
        "uplift_time": np.where(turned.any(axis=1), 0.0, NEVER),
        "lean": np.where(first < 0.0, -1.0, 1.0),
    }


def block_columns(lanes: Lanes, fall: float) -> dict[str, Array]:
    """Fields of the struct `Block`, shape [lane, block] each.

    Args:
        lanes: The stacks.
        fall: Velocity that gravity adds in a step [m/s], or that times the step [m], for
            multipliers that are impulses times the step.
    """
    mass = lanes.mass
    x, z, left, right = start_on_corners(lanes)
    # What stands on each interface, and where its centre is: sums from the top down.
    above = np.cumsum(mass[:, ::-1], axis=1)[:, ::-1]
    centre = np.cumsum((mass * x)[:, ::-1], axis=1)[:, ::-1] / above
    # By statics where an interface is closed; else the end that touches carries everything.
    width = right - left
    width = np.where(width > 0.0, width, np.inf)
    turn = np.diff(lanes.rotation_start, axis=1, prepend=0.0)
    on_left, on_right = (
        np.select([side * turn > 0.0, side * turn < 0.0], [1.0, 0.0], np.clip(arm / width, 0, 1))
        for side, arm in ((-1.0, right - centre), (1.0, centre - left))
    )
    return {
        "face": 0.5 * lanes.face_width,
        "high": 0.5 * lanes.height,
        "inverse_mass": 1.0 / mass,
        "inverse_inertia": 12.0 / (mass * (lanes.width**2 + lanes.height**2)),
        "friction": lanes.friction,
        "offset": lanes.offset,
        "x": x,
        "z": z,
        "theta": lanes.rotation_start,
        "left": fall * above * on_left,
        "right": fall * above * on_right,
    }
