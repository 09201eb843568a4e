"""The analytical model of two stacked blocks, batched and event-driven."""

from __future__ import annotations

from types import ModuleType
from typing import Any, ClassVar, final

import numpy as np
import numpy.typing as npt
import warp as wp

from warprock.engines.base import AbstractEngine
from warprock.engines.launching import (
    Form,
    Kernel,
    Target,
    respond,
    time_or_nan,
)
from warprock.engines.stack_launching import launch_stacks, stack_module
from warprock.model import rocking
from warprock.model.lanes import Lanes
from warprock.model.motion import GroundMotions
from warprock.model.response import Outcome, Response, SampleTimes, Status
from warprock.model.scene import SceneKind
from warprock.settings.engines import TwoBlockSettings
from warprock.units import GRAVITY

PHASE_STEP = {"float64": 0.4, "float32": 0.8}
"""Longest step as a part of 1 / (fastest rate of the lane); the series may ask for shorter ones."""

REST_RATIO_LEAST = {"float64": 0.0, "float32": 1e-5}
"""Least rest_rotation_ratio: the swings below it would be shorter than float32 times resolve."""

STEPS_SPARE = 100
"""Steps allowed for every step that a run without events would take: ends only a lane that makes
no headway."""

LIVE, OVERTURNED, BROKEN, STALLED = range(4)
"""Modes of a lane in the kernel."""


@final
class TwoBlock(AbstractEngine):
    """Two stacked blocks that rock without sliding, event by event, by Taylor series.

    The planar model of Psycharis (1990), Spanos, Roussis and Politis (2001) and Kounadis (2015):
    every contact is a corner on which a block pivots or is closed, which makes four patterns; an
    impact keeps the angular momentum of the whole about the new ground pivot and that of the upper
    block about the new interface pivot. Events are located to round-off. Friction does not enter:
    nothing slides or penetrates. Rest rule: after an impact a contact that opens closes again if
    its next swing would stay below `rest_rotation_ratio` times the slenderness angle.

    A lane has the status OUTSIDE_MODEL where a contact would have had to pull, so that a block
    would in truth have left its pivot, or where no pattern was admissible; its numbers are those
    of the model all the same. Pulling is looked for where steps end and at impulses.
    """

    name: ClassVar[str] = "two-block"
    order: ClassVar[int | None] = None
    slides: ClassVar[bool] = False
    settings_type = TwoBlockSettings

    def __init__(
        self, settings: TwoBlockSettings | None = None, target: Target | None = None
    ) -> None:
        """Builds the engine.

        Args:
            settings: Defaults where None.
            target: Precision and device; every form of the kernel runs one lane a thread.
        """
        self.settings = settings or TwoBlockSettings()
        self.target = target or Target()

    @classmethod
    def supports(cls, scene: SceneKind) -> str | None:
        """Why the scene cannot be run; None if it can: two centred blocks that do not slide."""
        if scene.beyond_the_plane:
            return scene.beyond_the_plane
        if not scene.stacked or scene.block_count != 2:
            blocks = f"a stack of {scene.block_count}" if scene.stacked else "single blocks"
            return f"two-block runs stacks of two blocks, and the case has {blocks}"
        if not scene.centred:
            return "two-block runs blocks that start above each other's centre: offset must be 0 m"
        if scene.friction_ratio < 1.0:
            return (
                "two-block needs friction >= tan(slenderness angle) of every block, the smallest "
                f"ratio is {scene.friction_ratio:.3g}: that block slides before it rocks"
            )
        if scene.restitution_given:
            return (
                "two-block finds its impacts from angular momentum and cannot follow the "
                "prescribed contact.angular_restitution"
            )
        return None

    def kernel(self, scene: SceneKind | Lanes) -> Kernel:
        """The kernel that runs a scene: one lane a thread on any device."""
        return Kernel("two_block/stack_run", Form.PLAIN)

    def warm_up(self, lanes: Lanes, motions: GroundMotions) -> None:
        """Compiles or loads the kernels; see `AbstractEngine.warm_up`."""
        wp.load_module(self._module(lanes, motions).__name__, device=self.target.device)

    def _module(self, lanes: Lanes, motions: GroundMotions) -> ModuleType:
        return stack_module(self.kernel(lanes), self.target, motions, lanes)

    def run(self, lanes: Lanes, motions: GroundMotions, times: SampleTimes) -> Response:
        """Runs a batch of stacks on the calling thread; see `AbstractEngine.run`."""
        module = self._module(lanes, motions)
        knobs = module.Knobs()
        knobs.duration = times.duration
        rows, per_block, rotations = launch_stacks(
            module,
            self.target,
            motions,
            times,
            self._blocks(lanes),
            self._stacks(lanes, motions, times),
            knobs,
        )
        mode, resting = rows["mode"], rows["resting"] == 1
        still = np.zeros(per_block["peak"].shape)
        columns: dict[str, npt.NDArray[Any]] = {
            "peak_rotation": per_block["peak"],
            "peak_time": per_block["peak_time"],
            "outcome": np.select(
                [mode == OVERTURNED, resting],
                [Outcome.OVERTURNED, Outcome.AT_REST],
                Outcome.ROCKING,
            ),
            "status": np.select(
                [mode == BROKEN, mode == STALLED, rows["outside"] > 0],
                [Status.NONFINITE, Status.EVENT_LIMIT, Status.OUTSIDE_MODEL],
                Status.OK,
            ),
            "impact_count": rows["impacts"],
            "uplift_time": time_or_nan(rows["uplift_time"]),
            "rest_time": np.where(resting, time_or_nan(rows["rest_time"]), np.nan),
            "residual_slide": still,
            "peak_slide": still,
            "peak_penetration": np.zeros(lanes.lane_count),
            "energy_lost": rows["loss"],
            "step_count": rows["steps"],
        }
        return respond(self.name, columns, rotations, times)

    def _blocks(self, lanes: Lanes) -> dict[str, npt.NDArray[np.float64]]:
        """Fields of the struct `Block`, shape [lane, block] each."""
        ratio = max(self.settings.rest_rotation_ratio, REST_RATIO_LEAST[self.target.precision])
        return {
            "mass": lanes.mass,
            "inertia": lanes.mass * (lanes.width**2 + lanes.height**2) / 12.0,
            "half_height": 0.5 * lanes.height,
            "rotation_start": lanes.rotation_start,
            "rest_rotation": ratio * lanes.slenderness_angle,
        }

    def _stacks(
        self, lanes: Lanes, motions: GroundMotions, times: SampleTimes
    ) -> dict[str, npt.NDArray[Any]]:
        """Fields of the struct `Stack`, shape [lane] each."""
        p = rocking.frequency_parameter(lanes.width, lanes.height).max(axis=1)
        rate = np.maximum(p, motions.components[0].fastest_rate)
        step_length = PHASE_STEP[self.target.precision] / rate
        steps = times.duration / step_length + motions.knot_count
        limit = np.where(np.isfinite(steps), STEPS_SPARE * (steps + 100.0), 0.0)
        face = lanes.face_width
        return {
            "gravity": np.full(lanes.lane_count, GRAVITY),
            "ground": 0.5 * face[:, 0],
            "interface": 0.5 * face.min(axis=1),
            "reach": np.hypot(lanes.width.max(axis=1), lanes.height.sum(axis=1)),
            "upper_narrower": np.asarray(face[:, 1] <= face[:, 0], np.int64),
            "step_length": step_length,
            "step_limit": limit.astype(np.int64),
        }
