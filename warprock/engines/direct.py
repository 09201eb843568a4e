"""The compliant contact engine: springs and dashpots by backward Euler, solved exactly, batched."""

from __future__ import annotations

from types import ModuleType
from typing import Any, ClassVar, final

import numpy as np
import numpy.typing as npt
import warp as wp

from warprock.engines.base import AbstractEngine
from warprock.engines.decoding import lane_fields, planar_fields
from warprock.engines.direct_stack import DIRECT_STACK, direct_stack_module, run_direct_stacks
from warprock.engines.launching import Kernel, Target, launch, respond
from warprock.engines.soundness import account_of, contacts_hold, unstable
from warprock.kernels.instance import kernel_module
from warprock.kernels.modes import UNSOLVED
from warprock.model.lanes import Lanes
from warprock.model.motion import GroundMotions
from warprock.model.response import Response, SampleTimes, Status
from warprock.model.scene import SceneKind
from warprock.settings.engines import DirectSettings
from warprock.units import GRAVITY


@final
class Direct(AbstractEngine):
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
    order: ClassVar[int | None] = 1
    settings_type = DirectSettings

    def __init__(
        self, settings: DirectSettings | None = None, target: Target | None = None
    ) -> None:
        """Builds the engine.

        Args:
            settings: Defaults where None.
            target: Precision, device and form of the kernel.
        """
        self.settings = settings or DirectSettings()
        self.target = target or Target()

    @classmethod
    def supports(cls, scene: SceneKind) -> str | None:
        """Why the scene cannot be run; None if it can: impacts follow the contact law alone."""
        if scene.beyond_the_plane:
            return scene.beyond_the_plane
        if scene.restitution_given:
            return (
                "direct finds the angular restitution from its contact law and cannot follow "
                "the prescribed contact.angular_restitution"
            )
        return None

    def kernel(self, scene: SceneKind | Lanes) -> Kernel:
        """The kernel that runs a scene; see `AbstractEngine.kernel`."""
        return (
            DIRECT_STACK if scene.stacked else Kernel("direct/block_run", self.target.kernel_form)
        )

    def warm_up(self, lanes: Lanes, motions: GroundMotions) -> None:
        """Compiles or loads the kernels; see `AbstractEngine.warm_up`."""
        wp.load_module(self._module(lanes, motions).__name__, device=self.target.device)

    def _module(self, lanes: Lanes, motions: GroundMotions) -> ModuleType:
        if lanes.stacked:
            return direct_stack_module(self.target, lanes, motions)
        module: ModuleType = kernel_module(
            self.kernel(lanes).file, precision=self.target.precision, motion=motions.kind.value
        )
        return module

    def _knobs(self, module: Any) -> Any:
        knobs = module.Knobs()
        knobs.time_step = self.settings.time_step
        knobs.rate = 1.0 / self.settings.time_step
        knobs.gravity = GRAVITY
        knobs.box = self.settings.friction_box
        knobs.margin = 2.0 * GRAVITY * self.settings.time_step**2
        return knobs

    def run(self, lanes: Lanes, motions: GroundMotions, times: SampleTimes) -> Response:
        """Runs a batch of lanes on the calling thread; see `AbstractEngine.run`."""
        if lanes.stacked:
            return run_direct_stacks(self.settings, self.target, lanes, motions, times)
        module = self._module(lanes, motions)
        rows, rotations = launch(
            module,
            self.kernel(lanes),
            self.target,
            lanes,
            motions,
            times,
            _blocks(lanes, self.settings),
            self._knobs(module),
        )
        step, hold = self.settings.time_step, contacts_hold(lanes, self.settings.contact_stiffness)
        gained = unstable(lanes, account_of(rows, step, lanes.mass), rows["peak"], rigid=hold)
        # In the last step of the run no corner had parted, and nothing slid.
        marks = [(rows["mode"] == UNSOLVED, Status.ITERATION_LIMIT), (gained, Status.UNSTABLE)]
        columns = lane_fields(rows, times.times[-1] - 0.5 * step, marks) | planar_fields(rows)
        columns["energy_lost"] = lanes.mass * rows["loss"]
        return respond(self.name, columns, rotations, times)


def _blocks(lanes: Lanes, settings: DirectSettings) -> dict[str, npt.NDArray[np.float64]]:
    """Fields of the struct `Block`, shape [lane] each; the block has the mass 1."""
    step, stiffness = settings.time_step, settings.contact_stiffness
    drag = step * stiffness + settings.contact_damping
    return {
        "half_width": 0.5 * lanes.face_width,
        "half_height": 0.5 * lanes.height,
        "inverse_inertia": 12.0 / (lanes.width**2 + lanes.height**2),
        "friction": lanes.friction,
        "stiffness": stiffness / lanes.mass,
        "cfm": lanes.mass / (step * drag),
        "erp": np.full(lanes.lane_count, step * stiffness / drag),
    }
