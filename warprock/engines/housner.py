"""Housner's rocking block, batched and event-driven: the reference of the other engines."""

from __future__ import annotations

from types import ModuleType
from typing import Any, ClassVar, final

import numpy as np
import numpy.typing as npt
import warp as wp

from warprock.engines.base import AbstractEngine
from warprock.engines.launching import (
    NEVER,
    Kernel,
    Target,
    launch,
    respond,
    time_or_nan,
)
from warprock.kernels.instance import kernel_module
from warprock.model import rocking
from warprock.model.lanes import Lanes
from warprock.model.motion import GroundMotions
from warprock.model.response import Outcome, Response, SampleTimes, Status
from warprock.model.scene import SceneKind
from warprock.settings.engines import HousnerSettings
from warprock.units import GRAVITY

WIDEST = np.sqrt(2.0)
"""Width over height at which Housner's angular restitution is 0: sin^2(slenderness angle) = 2/3."""

PHASE_STEP = {"float64": 0.4, "float32": 0.8}
"""Longest step as a part of 1 / (fastest rate of the lane): the first term that the series
leaves out is about this to the power 11 over 11!, 1e-12 (float64) or 2e-9 (float32)."""

REST_RATIO_LEAST = {"float64": 0.0, "float32": 1e-6}
"""Least rest_rotation_ratio: the swings below it would be shorter than float32 times resolve."""

STEPS_SPARE = 50
"""Steps allowed for every step that a run without events would take; an impact takes some five
steps, so this is far above any rocking motion and ends only a lane that makes no headway."""

FRICTION_SLACK = {"float64": 1e-6, "float32": 1e-4}
"""Part by which a lane's friction may fall short before the lane counts as outside the model: the
series of the contact force leave out some 1e-7 of the weight, float32 rounds to about 1e-5."""

RESTING, ROCKING, OVERTURNED, BROKEN, STALLED = range(5)
"""Modes of a lane in the kernel."""


@final
class Housner(AbstractEngine):
    """Event-driven solution of Housner's equation (1963) by Taylor series, lane by lane.

    Events are located to round-off; there are no gaps, so nothing penetrates. Rest rule: after an
    impact a block rests if its next swing would stay below `rest_rotation_ratio` times the
    slenderness angle on either side; it lifts again when |base acceleration| exceeds
    g tan(slenderness angle) or the base velocity steps.

    A lane has the status OUTSIDE_MODEL where the block would have slid, its friction being less
    than |force along| / (force upwards) of its contact at some moment, or where the base would have
    had to pull it; impulses at impacts and velocity steps count as forces do. Its numbers are those
    of Housner's equation all the same. Not judged is the end of a fall: once a block leans beyond
    its balance by more than the friction angle (at most 45 degrees) and turns outwards, it falls
    whatever its contact does.
    """

    name: ClassVar[str] = "housner"
    order: ClassVar[int | None] = None
    slides: ClassVar[bool] = False
    settings_type = HousnerSettings

    def __init__(
        self, settings: HousnerSettings | None = None, target: Target | None = None
    ) -> None:
        """Builds the engine.

        Args:
            settings: Defaults where None.
            target: Precision, device and form of the kernel.
        """
        self.settings = settings or HousnerSettings()
        self.target = target or Target()

    @classmethod
    def supports(cls, scene: SceneKind) -> str | None:
        """Why the scene cannot be run; None if it can: Housner's block must not slide."""
        if scene.beyond_the_plane:
            return scene.beyond_the_plane
        if scene.stacked:
            return "housner runs single blocks, and the case has a stack"
        if scene.angular_restitution <= 0.0:
            return (
                "housner needs an angular restitution above 0 in every lane, a width below "
                f"{WIDEST:.4g} times the height: the smallest is {scene.angular_restitution:.3g}, "
                "and that block does not rock over to its other corner"
            )
        if scene.friction_ratio < 1.0:
            return (
                "housner needs friction >= tan(slenderness angle) in every lane, the smallest "
                f"ratio is {scene.friction_ratio:.3g}: that block slides before it rocks"
            )
        return None

    def kernel(self, scene: SceneKind | Lanes) -> Kernel:
        """The kernel that runs a scene; see `AbstractEngine.kernel`."""
        return Kernel("housner/block_run", self.target.kernel_form)

    def warm_up(self, lanes: Lanes, motions: GroundMotions) -> None:
        """Compiles or loads the kernels; see `AbstractEngine.warm_up`."""
        wp.load_module(self._module(lanes, motions).__name__, device=self.target.device)

    def _module(self, lanes: Lanes, motions: GroundMotions) -> ModuleType:
        module: ModuleType = kernel_module(
            self.kernel(lanes).file, precision=self.target.precision, motion=motions.kind.value
        )
        return module

    def _blocks(self, lanes: Lanes, motions: GroundMotions, times: SampleTimes) -> dict[str, Any]:
        """Fields of the kernel's struct `Block`, shape [lane] each."""
        alpha = lanes.slenderness_angle
        radius = rocking.half_diagonal(lanes.width, lanes.height)
        frequency_squared = 3.0 * GRAVITY / (4.0 * radius)
        rate = np.maximum(np.sqrt(frequency_squared), motions.components[0].fastest_rate)
        step_length = PHASE_STEP[self.target.precision] / rate
        return {
            "slenderness_angle": alpha,
            "frequency_squared": frequency_squared,
            "coupling": frequency_squared / GRAVITY,
            "uplift_acceleration": GRAVITY * np.tan(alpha),
            "angular_restitution": lanes.angular_restitution,
            "impact_friction": rocking.impact_friction(
                lanes.width, lanes.height, lanes.angular_restitution
            ),
            "fall_angle": alpha + np.arctan(np.minimum(lanes.friction, 1.0)),
            "rest_rotation": alpha
            * max(self.settings.rest_rotation_ratio, REST_RATIO_LEAST[self.target.precision]),
            "step_length": step_length,
            "step_limit": _step_limit(motions, times, step_length),
        }

    def run(self, lanes: Lanes, motions: GroundMotions, times: SampleTimes) -> Response:
        """Runs a batch of lanes on the calling thread; see `AbstractEngine.run`."""
        rows, rotations = launch(
            self._module(lanes, motions),
            self.kernel(lanes),
            self.target,
            lanes,
            motions,
            times,
            self._blocks(lanes, motions, times),
        )
        mode = rows["mode"]
        needed = np.asarray(rows["needed"], dtype=np.float64)
        needed[needed >= NEVER] = np.inf
        slack = 1.0 + FRICTION_SLACK[self.target.precision]
        inertia = 4.0 / 3.0 * lanes.mass * rocking.half_diagonal(lanes.width, lanes.height) ** 2
        still = np.zeros(lanes.lane_count)
        columns = {
            "peak_rotation": rows["peak"],
            "peak_time": rows["peak_time"],
            "outcome": np.select(
                [mode == OVERTURNED, mode == RESTING],
                [Outcome.OVERTURNED, Outcome.AT_REST],
                Outcome.ROCKING,
            ),
            "status": np.select(
                [mode == BROKEN, mode == STALLED, needed > slack * lanes.friction],
                [Status.NONFINITE, Status.EVENT_LIMIT, Status.OUTSIDE_MODEL],
                Status.OK,
            ),
            "impact_count": rows["impacts"],
            "uplift_time": time_or_nan(rows["uplift_time"]),
            "rest_time": np.where(mode == RESTING, time_or_nan(rows["rest_time"]), np.nan),
            "residual_slide": still,
            "peak_slide": still,
            "peak_penetration": still,
            "energy_lost": 0.5 * inertia * rows["loss"],
            "step_count": rows["steps"],
            "friction_needed": needed,
        }
        return respond(self.name, columns, rotations, times)


def _step_limit(
    motions: GroundMotions, times: SampleTimes, step_length: npt.NDArray[np.float64]
) -> npt.NDArray[np.int64]:
    """Steps after which a lane counts as stalled, shape [lane]."""
    steps = times.duration / step_length + len(times.times) + motions.knot_count
    return np.where(np.isfinite(steps), STEPS_SPARE * (steps + 100.0), 0.0).astype(np.int64)
