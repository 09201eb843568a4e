"""The velocity-level contact engine on blocks in space: what its kernels take and leave."""

from __future__ import annotations

from types import ModuleType

from warprock.engines.decoding import lane_fields
from warprock.engines.launching import Form, Kernel, Target, respond
from warprock.engines.spatial_launching import (
    block_columns,
    block_fields,
    histories,
    launch_spatial,
)
from warprock.engines.spatial_soundness import unstable_in_space
from warprock.kernels.instance import LANE_WIDTH, kernel_module
from warprock.model.lanes import Lanes
from warprock.model.motion import GroundMotions
from warprock.model.response import Response, SampleTimes, Status
from warprock.model.scene import SceneKind
from warprock.settings.engines import ImpulseSettings
from warprock.units import GRAVITY


def spatial_impulse_kernel(target: Target, scene: SceneKind | Lanes) -> Kernel:
    """The kernel of blocks in space: stacks run one lane a thread on any device."""
    if scene.stacked:
        return Kernel("impulse/space_stack_run", Form.PLAIN)
    return Kernel("impulse/space_run", target.kernel_form)


def spatial_impulse_module(
    settings: ImpulseSettings, target: Target, lanes: Lanes, motions: GroundMotions
) -> ModuleType:
    """The instance of the kernel file for a batch of blocks in space."""
    kernel = spatial_impulse_kernel(target, lanes)
    module: ModuleType = kernel_module(
        kernel.file,
        precision=target.precision,
        motion=motions.kind.value,
        blocks=lanes.block_count,
        lanes=LANE_WIDTH if kernel.packed else 1,
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
    # Of single blocks the kernel knows the energy of unit mass.
    lost = rows["loss"] if lanes.stacked else lanes.mass * rows["loss"]
    # In the last step of the run all corners touched.
    since = times.times[-1] - 0.5 * settings.time_step
    fields = block_fields(lanes, per_block)
    gained = unstable_in_space(
        lanes,
        motions,
        times.duration,
        energy_lost=lost,
        peak_tilt=fields["peak_tilt"],
        deepest=rows["deepest"],
    )
    columns = fields | lane_fields(rows, since, [(gained, Status.UNSTABLE)])
    columns["energy_lost"] = lost
    rotations, others = histories(lanes, attitudes)
    return respond("impulse", columns, rotations, times, others)
