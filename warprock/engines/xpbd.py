"""The position-level contact engine: compliant constraints, sub-steps, velocity pass, batched."""

from __future__ import annotations

import dataclasses
from typing import Any, ClassVar, final

import numpy as np
import numpy.typing as npt

from warprock.engines.base import KernelEngine
from warprock.engines.blocks import planar_columns, stack_columns
from warprock.engines.decoding import lane_fields, planar_fields, rest_start_times
from warprock.engines.launching import Found, Kernel
from warprock.engines.soundness import account_of, contacts_hold, unstable
from warprock.kernels import xpbd
from warprock.model.lanes import Lanes, as_stacks
from warprock.model.motion import GroundMotions
from warprock.model.response import SampleTimes, Status
from warprock.model.scene import SceneKind
from warprock.settings.engines import XpbdSettings
from warprock.units import GRAVITY


@final
@dataclasses.dataclass(frozen=True)
class Xpbd(KernelEngine):
    """Contacts at the ends of every interface as position constraints with compliance (XPBD).

    First order in the time step of Eq. 9 of the paper. A stack is at rest while no end of its
    interfaces has parted, by more than a step of falling makes, and none slides. With compliance it
    starts as it would stand rigidly and sinks by the compliance times the force of each end, within
    a time of about compliance x mass / time step; what that stores counts as lost. Sweeps do not
    carry a block that is thousands of times as heavy as the one it stands on: there energy can
    grow. A lane that gains more than it held and its base supplied has the status UNSTABLE.
    """

    name: ClassVar[str] = "xpbd"
    settings_type = XpbdSettings
    order: ClassVar[int | None] = 1

    def kernel_of(self, scene: SceneKind | Lanes) -> Kernel:
        """The kernel that runs a scene: the same text for a single block and for a stack."""
        return Kernel(
            xpbd, "stack_run", lanes=self.target.lanes, iterations=self.settings.iterations
        )

    def inputs(
        self, module: Any, lanes: Lanes, motions: GroundMotions, times: SampleTimes
    ) -> dict[str, Any]:
        """What the kernel takes; see `KernelEngine.inputs`."""
        stacks, step = as_stacks(lanes), self.settings.time_step
        knobs = module.Knobs()
        knobs.time_step = step
        knobs.rate = 1.0 / step
        knobs.gravity = GRAVITY
        knobs.softness = self.settings.compliance / step**2
        # Multipliers are impulses times the step.
        blocks = planar_columns(stacks, GRAVITY * step**2)
        return {"blocks": blocks, "lanes": stack_columns(stacks), "knobs": knobs}

    def fields(
        self, lanes: Lanes, motions: GroundMotions, times: SampleTimes, found: Found
    ) -> dict[str, npt.NDArray[Any]]:
        """Lane fields of a response; see `KernelEngine.fields`."""
        stacks, step = as_stacks(lanes), self.settings.time_step
        softness = self.settings.compliance
        hold = contacts_hold(stacks, 1.0 / softness if softness else np.inf)
        account = account_of(found.lanes, step)
        gained = unstable(stacks, account, found.blocks["peak"], rigid=hold)
        # In the last step of the run no end had parted, and nothing slid.
        rest_time = rest_start_times(found.lanes, times.times[-1] - 0.5 * step)
        fields = lane_fields(found.lanes, rest_time, [(gained, Status.UNSTABLE)])
        return fields | planar_fields(found.blocks)
