"""The velocity-level contact engine: sequential impulses on hard contacts, batched."""

from __future__ import annotations

from types import ModuleType
from typing import Any, ClassVar, final

import warp as wp

from warprock.engines.base import AbstractEngine
from warprock.engines.decoding import lane_fields, planar_fields
from warprock.engines.impulse_stack import (
    impulse_stack,
    impulse_stack_module,
    run_impulse_stacks,
)
from warprock.engines.launching import Form, Kernel, Target, launch, respond
from warprock.engines.soundness import account_of, unstable
from warprock.engines.spatial_impulse import (
    run_spatial_impulse,
    spatial_impulse_kernel,
    spatial_impulse_module,
)
from warprock.kernels.instance import MAX_UNROLL, kernel_module
from warprock.model.lanes import Lanes
from warprock.model.motion import GroundMotions
from warprock.model.response import Response, SampleTimes, Status
from warprock.model.scene import SceneKind
from warprock.settings.engines import ImpulseSettings
from warprock.units import GRAVITY


@final
class Impulse(AbstractEngine):
    """Hard contacts at two corners, Coulomb friction, warm-started projected Gauss-Seidel.

    Semi-implicit Euler at the time step of Eq. 9 of the paper, first order in it. A block rocks
    while a corner has parted from the base, by more than a step of falling makes; it is at rest
    while none has and it does not slide. In a stack the same holds at the two ends of what two
    faces share. A contact that has no other beside it is solved exactly. A lane that gains more
    energy than it held and its base supplied has the status UNSTABLE. What erp lifts counts as a
    gain.

    In space a block touches at its four corners, and two faces at up to eight points. A single
    block rocks and lands there by the same rule, and has lifted since no two opposite corners
    carried; a stack rocks while a point is open by more than a step of falling makes. What the base
    supplied is the most that a lane can have there. Where the law of friction lets all contacts of
    a single block be stopped together, they are, at once; the sweeps solve what slides or leaves.
    """

    name: ClassVar[str] = "impulse"
    order: ClassVar[int | None] = 1
    settings_type = ImpulseSettings

    def __init__(
        self, settings: ImpulseSettings | None = None, target: Target | None = None
    ) -> None:
        """Builds the engine.

        Args:
            settings: Defaults where None.
            target: Precision, device and form of the kernel.
        """
        self.settings = settings or ImpulseSettings()
        self.target = target or Target()

    @classmethod
    def supports(cls, scene: SceneKind) -> str | None:
        """Why the scene cannot be run; None if it can: impacts follow the contact law alone."""
        if scene.restitution_given:
            return (
                "impulse finds the angular restitution from its contact law and cannot follow "
                "the prescribed contact.angular_restitution"
            )
        return None

    def kernel(self, scene: SceneKind | Lanes) -> Kernel:
        """The kernel that runs a scene; see `AbstractEngine.kernel`.

        More sweeps than are written out would keep the packed loop over lanes of single blocks in
        scalar code, many times slower than the plain form.
        """
        if scene.spatial:
            return spatial_impulse_kernel(self.target, scene)
        if scene.stacked:
            return impulse_stack(self.target)
        slow = self.target.form is None and self.settings.iterations > MAX_UNROLL
        return Kernel("impulse/block_run", Form.PLAIN if slow else self.target.kernel_form)

    def warm_up(self, lanes: Lanes, motions: GroundMotions) -> None:
        """Compiles or loads the kernels; see `AbstractEngine.warm_up`."""
        wp.load_module(self._module(lanes, motions).__name__, device=self.target.device)

    def _module(self, lanes: Lanes, motions: GroundMotions) -> ModuleType:
        if lanes.spatial:
            return spatial_impulse_module(self.settings, self.target, lanes, motions)
        if lanes.stacked:
            return impulse_stack_module(self.settings, self.target, lanes, motions)
        module: ModuleType = kernel_module(
            self.kernel(lanes).file,
            precision=self.target.precision,
            motion=motions.kind.value,
            iterations=self.settings.iterations,
        )
        return module

    def _knobs(self, module: Any) -> Any:
        knobs = module.Knobs()
        knobs.time_step = self.settings.time_step
        knobs.rate = 1.0 / self.settings.time_step
        knobs.gravity = GRAVITY
        knobs.collision_margin = self.settings.collision_margin
        knobs.erp = self.settings.erp
        return knobs

    def run(self, lanes: Lanes, motions: GroundMotions, times: SampleTimes) -> Response:
        """Runs a batch of lanes on the calling thread; see `AbstractEngine.run`."""
        if lanes.spatial:
            return run_spatial_impulse(self.settings, self.target, lanes, motions, times)
        if lanes.stacked:
            return run_impulse_stacks(self.settings, self.target, lanes, motions, times)
        blocks = {
            "half_width": 0.5 * lanes.width,
            "half_height": 0.5 * lanes.height,
            "inverse_inertia": 12.0 / (lanes.width**2 + lanes.height**2),
            "friction": lanes.friction,
        }
        module = self._module(lanes, motions)
        rows, rotations = launch(
            module,
            self.kernel(lanes),
            self.target,
            lanes,
            motions,
            times,
            blocks,
            self._knobs(module),
        )
        step = self.settings.time_step
        gained = unstable(lanes, account_of(rows, step, lanes.mass), rows["peak"])
        # In the last step of the run no corner had parted, and nothing slid.
        marks = [(gained, Status.UNSTABLE)]
        columns = lane_fields(rows, times.times[-1] - 0.5 * step, marks) | planar_fields(rows)
        columns["energy_lost"] = lanes.mass * rows["loss"]
        return respond(self.name, columns, rotations, times)
