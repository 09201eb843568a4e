"""The event-driven contact engine: second order in the time step through impacts, batched."""

from __future__ import annotations

from types import ModuleType
from typing import Any, ClassVar, final

import numpy as np
import numpy.typing as npt
import warp as wp

from warprock.engines.base import AbstractEngine
from warprock.engines.event_stack import EVENT_STACK, event_stack_module, run_event_stacks
from warprock.engines.launching import (
    Kernel,
    Target,
    launch,
    respond,
    step_limit,
    time_or_nan,
)
from warprock.engines.spatial_event import (
    longest_steps,
    run_spatial_event,
    spatial_event_kernel,
    spatial_event_module,
)
from warprock.kernels.instance import kernel_module
from warprock.model import rocking
from warprock.model.lanes import Lanes
from warprock.model.motion import GroundMotions
from warprock.model.response import Outcome, Response, SampleTimes, Status
from warprock.model.scene import SceneKind
from warprock.settings.engines import EventSettings
from warprock.units import GRAVITY

PHASE_STEP = 0.25
"""Longest step as a part of 1 / p: a longer one does not follow the block's own rocking."""

OVERTURNED, BROKEN, STALLED = range(3, 6)
"""Modes of a lane in the kernel."""


@final
class Event(AbstractEngine):
    """Rigid corners, Coulomb friction, midpoint Moreau-Jean steps that end at impacts.

    Second order in `time_step` through impacts. Rest rule: after an impact on its other corner a
    block rests if its next swing would stay below `rest_rotation_ratio` times the slenderness
    angle on either side; at rest it lifts or slides as the contact law says. Its penetration is
    what the end of a step puts back on the base: drift, of third order in the step, and landings
    that it misses by a part of the step. Single blocks in space have four corners, and kernels of
    their own (kernels/event_space/space.py). So have stacks in space
    (kernels/event_space/space_stack.py), which are second order while contacts stick, through
    impacts, too, and first order where they
    slide or an edge lets go of an end: that is not located there.

    With friction as a box single blocks are second order through the ends of their slips, along x
    and along y; of blocks that rock and slide errors scatter (1.4 to 2). How rigid faces share
    their load is not determined, and where they slide along x and stick along y the yaw of a stack
    hangs on it: `event` and `impulse` may come to different ones.
    """

    name: ClassVar[str] = "event"
    order: ClassVar[int | None] = 2
    rests_exactly: ClassVar[bool] = True
    settings_type = EventSettings

    def __init__(self, settings: EventSettings | None = None, target: Target | None = None) -> None:
        """Builds the engine.

        Args:
            settings: Defaults where None.
            target: Precision, device and form of the kernel.
        """
        self.settings = settings or EventSettings()
        self.target = target or Target()

    @classmethod
    def supports(cls, scene: SceneKind) -> str | None:
        """Why the scene cannot be run; None if it can: impacts follow the contact law alone."""
        if scene.restitution_given:
            return (
                "event finds the angular restitution from its contact law and cannot follow "
                "the prescribed contact.angular_restitution"
            )
        return None

    def kernel(self, scene: SceneKind | Lanes) -> Kernel:
        """The kernel that runs a scene; see `AbstractEngine.kernel`."""
        if scene.spatial:
            return spatial_event_kernel(self.settings, self.target, scene)
        return EVENT_STACK if scene.stacked else Kernel("event/block_run", self.target.kernel_form)

    def warm_up(self, lanes: Lanes, motions: GroundMotions) -> None:
        """Compiles or loads the kernels; see `AbstractEngine.warm_up`."""
        wp.load_module(self._module(lanes, motions).__name__, device=self.target.device)

    def _module(self, lanes: Lanes, motions: GroundMotions) -> ModuleType:
        if lanes.spatial:
            return spatial_event_module(self.settings, self.target, lanes, motions)
        if lanes.stacked:
            return event_stack_module(self.target, lanes, motions)
        module: ModuleType = kernel_module(
            self.kernel(lanes).file, precision=self.target.precision, motion=motions.kind.value
        )
        return module

    def _knobs(self, module: Any) -> Any:
        knobs = module.Knobs()
        knobs.gravity = GRAVITY
        return knobs

    def longest_step(self, lanes: Lanes, motions: GroundMotions) -> npt.NDArray[np.float64]:
        """Longest step that every lane may take [s]: also cut at the knots of a record."""
        if lanes.spatial:
            return np.minimum(longest_steps(self.settings, lanes), motions.knot_interval)
        rate = rocking.frequency_parameter(lanes.width, lanes.height)
        fastest = rate.reshape(lanes.lane_count, -1).max(axis=1)
        longest = np.minimum(self.settings.time_step, PHASE_STEP / fastest)
        return np.asarray(np.minimum(longest, motions.knot_interval))

    def run(self, lanes: Lanes, motions: GroundMotions, times: SampleTimes) -> Response:
        """Runs a batch of lanes on the calling thread; see `AbstractEngine.run`."""
        if lanes.spatial:
            return run_spatial_event(self.settings, self.target, lanes, motions, times)
        if lanes.stacked:
            return run_event_stacks(self.settings, self.target, lanes, motions, times)
        inertia = (lanes.width**2 + lanes.height**2) / 12.0
        rate = rocking.frequency_parameter(lanes.width, lanes.height)
        longest_step = np.minimum(self.settings.time_step, PHASE_STEP / rate)
        hold = np.minimum(lanes.friction, lanes.width / lanes.height)
        blocks = {
            "half_width": 0.5 * lanes.width,
            "half_height": 0.5 * lanes.height,
            "inertia": inertia,
            "inverse_inertia": 1.0 / inertia,
            "friction": lanes.friction,
            "hold_acceleration": GRAVITY * hold,
            "rest_rotation": self.settings.rest_rotation_ratio * lanes.slenderness_angle,
            "longest_step": longest_step,
            "step_limit": step_limit(motions, times, longest_step),
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
        mode = rows["mode"]
        rest_time = time_or_nan(rows["rest_time"])
        columns = {
            "peak_rotation": rows["peak"],
            "peak_time": rows["peak_time"],
            "outcome": np.select(
                [mode == OVERTURNED, np.isfinite(rest_time)],
                [Outcome.OVERTURNED, Outcome.AT_REST],
                Outcome.ROCKING,
            ),
            "status": np.select(
                [mode == BROKEN, mode == STALLED], [Status.NONFINITE, Status.EVENT_LIMIT], Status.OK
            ),
            "impact_count": rows["impacts"],
            "uplift_time": time_or_nan(rows["uplift_time"]),
            "rest_time": rest_time,
            "residual_slide": rows["slide"],
            "peak_slide": rows["peak_slide"],
            "peak_penetration": rows["deepest"],
            "energy_lost": lanes.mass * rows["loss"],
            "step_count": rows["steps"],
        }
        return respond(self.name, columns, rotations, times)
