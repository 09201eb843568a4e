"""The position-level contact engine: compliant constraints, sub-steps, velocity pass, batched."""

from __future__ import annotations

from types import ModuleType
from typing import Any, ClassVar, final

import numpy as np
import warp as wp

from warprock.engines.base import AbstractEngine
from warprock.engines.decoding import lane_fields, planar_fields
from warprock.engines.launching import Kernel, Target, respond
from warprock.engines.soundness import account_of, contacts_hold, unstable
from warprock.engines.stack_launching import (
    as_stacks,
    block_columns,
    launch_stacks,
    stack_columns,
    stack_module,
)
from warprock.model.lanes import Lanes
from warprock.model.motion import GroundMotions
from warprock.model.response import FIELDS, Response, SampleTimes, Status
from warprock.model.scene import SceneKind
from warprock.settings.engines import XpbdSettings
from warprock.units import GRAVITY


@final
class Xpbd(AbstractEngine):
    """Contacts at the ends of every interface as position constraints with compliance (XPBD).

    First order in the time step of Eq. 9 of the paper. A stack is at rest while no end of its
    interfaces has parted, by more than a step of falling makes, and none slides. With compliance it
    starts as it would stand rigidly and sinks by the compliance times the force of each end, within
    a time of about compliance x mass / time step; what that stores counts as lost. Sweeps do not
    carry a block that is thousands of times as heavy as the one it stands on: there energy can
    grow. A lane that gains more than it held and its base supplied has the status UNSTABLE.
    """

    name: ClassVar[str] = "xpbd"
    order: ClassVar[int | None] = 1
    settings_type = XpbdSettings

    def __init__(self, settings: XpbdSettings | None = None, target: Target | None = None) -> None:
        """Builds the engine.

        Args:
            settings: Defaults where None.
            target: Precision, device and form of the kernel.
        """
        self.settings = settings or XpbdSettings()
        self.target = target or Target()

    @classmethod
    def supports(cls, scene: SceneKind) -> str | None:
        """Why the scene cannot be run; None if it can: impacts follow the contact law alone."""
        if scene.beyond_the_plane:
            return scene.beyond_the_plane
        if scene.restitution_given:
            return (
                "xpbd finds the angular restitution from its contact law and cannot follow "
                "the prescribed contact.angular_restitution"
            )
        return None

    def kernel(self, scene: SceneKind | Lanes) -> Kernel:
        """The kernel that runs a scene: the same text for a single block and for a stack."""
        return Kernel("xpbd/stack_run", self.target.kernel_form)

    def warm_up(self, lanes: Lanes, motions: GroundMotions) -> None:
        """Compiles or loads the kernels; see `AbstractEngine.warm_up`."""
        wp.load_module(self._module(lanes, motions).__name__, device=self.target.device)

    def _module(self, lanes: Lanes, motions: GroundMotions) -> ModuleType:
        return stack_module(
            self.kernel(lanes), self.target, motions, lanes, self.settings.iterations
        )

    def _knobs(self, module: Any) -> Any:
        step = self.settings.time_step
        knobs = module.Knobs()
        knobs.time_step = step
        knobs.rate = 1.0 / step
        knobs.gravity = GRAVITY
        knobs.softness = self.settings.compliance / step**2
        return knobs

    def run(self, lanes: Lanes, motions: GroundMotions, times: SampleTimes) -> Response:
        """Runs a batch of lanes on the calling thread; see `AbstractEngine.run`."""
        stacks = as_stacks(lanes)
        step = self.settings.time_step
        module = self._module(lanes, motions)
        # Multipliers are impulses times the step.
        blocks = block_columns(stacks, GRAVITY * step**2)
        rows, per_block, rotations = launch_stacks(
            module,
            self.target,
            motions,
            times,
            blocks,
            stack_columns(stacks),
            self._knobs(module),
        )
        softness = self.settings.compliance
        hold = contacts_hold(stacks, 1.0 / softness if softness else np.inf)
        gained = unstable(stacks, account_of(rows, step), per_block["peak"], rigid=hold)
        # In the last step of the run no end had parted, and nothing slid.
        marks = [(gained, Status.UNSTABLE)]
        columns = lane_fields(rows, times.times[-1] - 0.5 * step, marks) | planar_fields(per_block)
        if not lanes.stacked:
            columns = {k: v[:, 0] if FIELDS[k].per_block else v for k, v in columns.items()}
            rotations = None if rotations is None else rotations[:, 0]
        return respond(self.name, columns, rotations, times)
