"""The analytical model of two stacked blocks, batched and event-driven."""

from __future__ import annotations

import dataclasses
from typing import Any, ClassVar, final

import numpy as np
import numpy.typing as npt

from warprock.engines.base import KernelEngine
from warprock.engines.decoding import lane_fields, planar_fields, time_or_nan
from warprock.engines.launching import Found, Kernel
from warprock.engines.workload import step_limit
from warprock.kernels import two_block
from warprock.model import rocking
from warprock.model.lanes import Lanes
from warprock.model.motion import GroundMotions
from warprock.model.response import SampleTimes, Status
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


@final
@dataclasses.dataclass(frozen=True)
class TwoBlock(KernelEngine):
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
    settings_type = TwoBlockSettings
    order: ClassVar[int | None] = None
    reference_of: ClassVar[str | None] = "stack"
    locates_events: ClassVar[bool] = True
    restitution: ClassVar[str | None] = "finds its impacts from angular momentum"
    slides: ClassVar[bool] = False

    @classmethod
    def declines(cls, scene: SceneKind) -> str | None:
        """Why its model is not for a scene: two centred blocks that do not slide."""
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
        return None

    def kernel_of(self, scene: SceneKind | Lanes) -> Kernel:
        """The kernel that runs a scene: one lane a thread on any device."""
        return Kernel(two_block, "stack_run")

    def inputs(
        self, module: Any, lanes: Lanes, motions: GroundMotions, times: SampleTimes
    ) -> dict[str, Any]:
        """What the kernel takes; see `KernelEngine.inputs`."""
        knobs = module.Knobs()
        knobs.duration = times.duration
        return {
            "blocks": self._blocks(lanes),
            "lanes": self._stacks(lanes, motions, times),
            "knobs": knobs,
        }

    def fields(
        self, lanes: Lanes, motions: GroundMotions, times: SampleTimes, found: Found
    ) -> dict[str, npt.NDArray[Any]]:
        """Lane fields of a response; see `KernelEngine.fields`."""
        rows = found.lanes
        rest_time = np.where(rows["resting"] == 1, time_or_nan(rows["rest_time"]), np.nan)
        marks = [(rows["outside"] > 0, Status.OUTSIDE_MODEL)]
        return lane_fields(rows, rest_time, marks) | planar_fields(found.blocks)

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
        face = lanes.face_width
        return {
            "gravity": np.full(lanes.lane_count, GRAVITY),
            "ground": 0.5 * face[:, 0],
            "interface": 0.5 * face.min(axis=1),
            "reach": np.hypot(lanes.width.max(axis=1), lanes.height.sum(axis=1)),
            "upper_narrower": np.asarray(face[:, 1] <= face[:, 0], np.int64),
            "step_length": step_length,
            "step_limit": step_limit(motions, times.duration, step_length, STEPS_SPARE),
        }
