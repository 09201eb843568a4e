"""The compliant contact engine: springs and dashpots by backward Euler, solved exactly, batched."""

from __future__ import annotations

import dataclasses
from typing import Any, ClassVar, final

import numpy as np
import numpy.typing as npt

from warprock.engines.base import KernelEngine
from warprock.engines.blocks import body_columns, find_load, stack_columns, start_on_corners
from warprock.engines.decoding import lane_fields, planar_fields, rest_start_times
from warprock.engines.launching import Found, Kernel
from warprock.engines.soundness import account_of, contacts_hold, unstable
from warprock.kernels import direct
from warprock.model.lanes import Lanes, as_stacks
from warprock.model.motion import GroundMotions
from warprock.model.response import SampleTimes, Status
from warprock.model.scene import SceneKind
from warprock.settings.engines import DirectSettings
from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]


@final
@dataclasses.dataclass(frozen=True)
class Direct(KernelEngine):
    """Springs and dashpots at the corners, backward Euler, contact impulses solved exactly.

    A single block by trying each way to touch, a stack by pivoting.

    The time step is that of Eq. 9 of the paper, stiffness and damping act as CFM and ERP (Eq. 13).
    First order in the step; at the default stiffness the contacts are rigid, as Housner's. A block
    rocks while a corner has parted from the base, by more than a step of falling makes; it is at
    rest while none has and it does not slide. The run of a lane whose contacts are not solved to
    round-off ends there, with the status ITERATION_LIMIT. What is lost is what the contacts take;
    what a spring holds counts as lost until it gives it back. A lane that gains more energy than it
    held and its base supplied has the status UNSTABLE.
    """

    name: ClassVar[str] = "direct"
    settings_type = DirectSettings
    order: ClassVar[int | None] = 1

    def kernel_of(self, scene: SceneKind | Lanes) -> Kernel:
        """The kernel that runs a scene: stacks run one lane a thread on any device."""
        if scene.stacked:
            return Kernel(direct, "stack_run")
        return Kernel(direct, "block_run", lanes=self.target.lanes)

    def inputs(
        self, module: Any, lanes: Lanes, motions: GroundMotions, times: SampleTimes
    ) -> dict[str, Any]:
        """What the kernel takes; see `KernelEngine.inputs`."""
        step, stiffness = self.settings.time_step, self.settings.contact_stiffness
        knobs = module.Knobs()
        knobs.time_step = step
        knobs.rate = 1.0 / step
        knobs.gravity = GRAVITY
        knobs.margin = 2.0 * GRAVITY * step**2
        knobs.box = self.settings.friction_box
        if not lanes.stacked:
            blocks = _single_blocks(lanes, self.settings)
            return {"blocks": blocks, "starts": lanes.rotation_start, "knobs": knobs}
        drag = step * stiffness + self.settings.contact_damping
        knobs.cfm = 1.0 / (step * drag)
        knobs.erp = step * stiffness / drag
        blocks = _stacked_blocks(lanes, self.settings)
        return {"blocks": blocks, "lanes": stack_columns(lanes), "knobs": knobs}

    def fields(
        self, lanes: Lanes, motions: GroundMotions, times: SampleTimes, found: Found
    ) -> dict[str, npt.NDArray[Any]]:
        """Lane fields of a response; see `KernelEngine.fields`."""
        rows, step = found.lanes, self.settings.time_step
        # Of single blocks the kernel knows the energy of unit mass.
        mass = 1.0 if lanes.stacked else lanes.mass
        stacks = as_stacks(lanes)
        hold = contacts_hold(stacks, self.settings.contact_stiffness)
        gained = unstable(stacks, account_of(rows, step, mass), found.blocks["peak"], rigid=hold)
        # In the last step of the run no end had parted, and nothing slid.
        rest_time = rest_start_times(rows, times.times[-1] - 0.5 * step)
        fields = lane_fields(rows, rest_time, [(gained, Status.UNSTABLE)])
        return fields | planar_fields(found.blocks) | {"energy_lost": mass * rows["loss"]}


def _single_blocks(lanes: Lanes, settings: DirectSettings) -> dict[str, Array]:
    """Fields of the struct `Block` of single blocks, shape [lane, 1] each; they have the mass 1."""
    step, stiffness = settings.time_step, settings.contact_stiffness
    drag = step * stiffness + settings.contact_damping
    stacks = as_stacks(lanes)
    return {
        "half_width": 0.5 * stacks.face_width,
        "half_height": 0.5 * stacks.height,
        "inverse_inertia": 12.0 / (stacks.width**2 + stacks.height**2),
        "friction": stacks.friction,
        "stiffness": stiffness / stacks.mass,
        "cfm": stacks.mass / (step * drag),
        "erp": np.full(stacks.width.shape, step * stiffness / drag),
    }


def _stacked_blocks(lanes: Lanes, settings: DirectSettings) -> dict[str, Array]:
    """Fields of the struct `Block` of stacks, shape [lane, block] each.

    A stack that stands flat starts sunk into its springs by its weight; that springs under an
    eccentric weight tilt it is left to the first moments of the run, as is the sinking of a turned
    block.
    """
    x, z, left, right = start_on_corners(lanes)
    above, centre = find_load(lanes, x)
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
