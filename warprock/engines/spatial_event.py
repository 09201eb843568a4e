"""The event-driven contact engine in space, blocks and stacks: what its kernels take and leave."""

from __future__ import annotations

from types import ModuleType
from typing import Any

import numpy as np
import numpy.typing as npt
import warp as wp

from warprock.engines.launching import (
    Form,
    Kernel,
    Target,
    respond,
    step_limit,
    struct_rows,
    time_or_nan,
)
from warprock.engines.spatial_launching import (
    Array,
    block_columns,
    block_fields,
    histories,
    launch_spatial,
)
from warprock.engines.spatial_soundness import unstable_in_space
from warprock.kernels.instance import kernel_module
from warprock.model import rocking
from warprock.model.lanes import Lanes
from warprock.model.motion import GroundMotions
from warprock.model.response import Outcome, Response, SampleTimes, Status
from warprock.model.scene import SceneKind
from warprock.settings.engines import EventSettings
from warprock.units import GRAVITY

PHASE_STEP = 0.25
"""Longest step as a part of 1 / p of the quickest block: a longer one does not follow its own
rocking."""

PACK = 8
"""Lanes side by side: one vector of float64 with AVX-512. Steps with an event are taken one by one
in between, so that more in flight gain nothing, and a batch smaller than a pack costs less."""

OVERTURNED, SLID_OFF, BROKEN, STALLED, UNSETTLED = range(1, 6)
"""Modes of a lane in the kernels."""


def spatial_event_kernel(
    settings: EventSettings, target: Target, scene: SceneKind | Lanes
) -> Kernel:
    """The kernel of blocks in space: packed are single ones on a cone alone."""
    if scene.stacked:
        return Kernel("event_space/space_stack_run", Form.PLAIN)
    if target.kernel_form is Form.PACKED and not settings.friction_box:
        return Kernel("event_space/pack_run", Form.PACKED)
    return Kernel("event_space/space_run", Form.PLAIN)


def spatial_event_module(
    settings: EventSettings, target: Target, lanes: Lanes, motions: GroundMotions
) -> ModuleType:
    """The instance of the kernel file for a batch of blocks."""
    kernel = spatial_event_kernel(settings, target, lanes)
    module: ModuleType = kernel_module(
        kernel.file,
        precision=target.precision,
        motion=motions.kind.value,
        blocks=lanes.block_count,
        lanes=PACK if kernel.packed else 1,
        friction="box" if settings.friction_box else "cone",
    )
    return module


def longest_steps(settings: EventSettings, lanes: Lanes) -> Array:
    """Longest step that lanes may take [s]: a part of 1 / p, the largest of blocks and planes."""
    rates = [
        rocking.frequency_parameter(side, lanes.height).reshape(lanes.lane_count, -1).max(axis=1)
        for side in (lanes.width, lanes.depth)
    ]
    return np.asarray(np.minimum(settings.time_step, PHASE_STEP / np.maximum(*rates)))


def run_spatial_event(
    settings: EventSettings,
    target: Target,
    lanes: Lanes,
    motions: GroundMotions,
    times: SampleTimes,
) -> Response:
    """Runs a batch of blocks or stacks on the calling thread; see `AbstractEngine.run`."""
    module: Any = spatial_event_module(settings, target, lanes, motions)
    knobs = module.Knobs()
    knobs.gravity = GRAVITY
    longest_step = longest_steps(settings, lanes)
    face = np.minimum(lanes.face_width, lanes.face_depth)
    rest_gap = settings.rest_rotation_ratio * np.arctan2(face, lanes.height) * face
    columns: dict[str, npt.NDArray[Any]] = {
        "longest_step": longest_step,
        "rest_gap": rest_gap.reshape(lanes.lane_count, -1).min(axis=1),
        "step_limit": step_limit(motions, times, longest_step),
    }
    rows = struct_rows(module.Lane, columns, lanes.lane_count)
    with wp.ScopedDevice(target.device):
        limits = wp.array(rows, dtype=module.Lane)
    results, per_block, attitudes = launch_spatial(
        module, target, motions, times, block_columns(lanes), limits, knobs
    )
    mode = results["mode"]
    rest_time = time_or_nan(results["moved"])
    peaks = block_fields(lanes, per_block)
    unstable = unstable_in_space(
        lanes,
        motions,
        times.duration,
        energy_lost=results["loss"],
        peak_tilt=peaks["peak_tilt"],
        deepest=results["deepest"],
    )
    fields: dict[str, npt.NDArray[Any]] = {
        **peaks,
        "outcome": np.select(
            [mode == OVERTURNED, mode == SLID_OFF, np.isfinite(rest_time)],
            [Outcome.OVERTURNED, Outcome.SLID_OFF, Outcome.AT_REST],
            Outcome.ROCKING,
        ),
        "status": np.select(
            [mode == BROKEN, mode == STALLED, mode == UNSETTLED, unstable],
            [Status.NONFINITE, Status.EVENT_LIMIT, Status.ITERATION_LIMIT, Status.UNSTABLE],
            Status.OK,
        ),
        "impact_count": results["impacts"],
        "uplift_time": time_or_nan(results["uplift_time"]),
        "rest_time": rest_time,
        "peak_penetration": results["deepest"],
        "energy_lost": results["loss"],
        "step_count": results["steps"],
    }
    rotations, others = histories(lanes, attitudes)
    return respond("event", fields, rotations, times, others)
