"""Housner's rocking block, batched and event-driven: the reference of the other engines."""

from __future__ import annotations

import dataclasses
from typing import Any, ClassVar, final

import numpy as np
import numpy.typing as npt

from warprock.engines.base import KernelEngine
from warprock.engines.blocks import start_columns
from warprock.engines.decoding import asked_friction, lane_fields, planar_fields, time_or_nan
from warprock.engines.held import held_fields, held_inputs, inertia_of, tie_rate
from warprock.engines.housner_bed import bed_inputs, bed_rate
from warprock.engines.housner_body import body_inputs
from warprock.engines.housner_strip import strip_inputs, strip_of, strip_rate
from warprock.engines.launching import Found, Kernel
from warprock.engines.workload import step_limit
from warprock.kernels import housner
from warprock.kernels.lane.modes import RESTING
from warprock.model import rocking
from warprock.model.lanes import Lanes
from warprock.model.motion import GroundMotions, UprightMotions
from warprock.model.response import SampleTimes, Status
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


BED_STEP = 0.75
"""Longest step on compliant ground, over that of others: there a block swings at the fastest rate
all the time, and the errors of its rate, 11 times those of its rotation, add up."""


FRAME = ("frame",)
"""What holds blocks that rock as free-standing ones do."""
STRIP = ("strip",)
"""What makes a block a strip of wall."""
BED = ("ground",)
"""What lays a block on compliant ground."""


@final
@dataclasses.dataclass(frozen=True)
class Housner(KernelEngine):
    """Event-driven solution of Housner's equation (1963) by Taylor series, lane by lane.

    Events are located to round-off; there are no gaps, so nothing penetrates. Rest rule: after an
    impact a block rests if its next swing would stay below `rest_rotation_ratio` times the
    slenderness angle on either side; it lifts again when |base acceleration| exceeds
    g tan(slenderness angle) or the base velocity steps.

    A lane has the status OUTSIDE_MODEL where the block would have slid: at some moment the friction
    is less than |force along| / (force upwards) of its contact. So has a lane whose base would have
    to pull the block down. Impulses at impacts and velocity steps count as forces do. Its numbers
    are those of Housner's equation all the same. The end of a fall is not judged: once a block
    leans beyond its balance by more than the friction angle (at most 45 degrees) and turns
    outwards, it falls whatever its contact does.

    A block on compliant ground (kernels/housner/bed.py) counts as at rest while its whole face is
    pressed; each return to that counts as an impact.

    Where the base moves upwards, too, a block is pulled down by g + a_z. A base that falls faster
    than its block would leave it: such a lane is OUTSIDE_MODEL like one that is pulled.
    """

    name: ClassVar[str] = "housner"
    settings_type = HousnerSettings
    order: ClassVar[int | None] = None
    reference_of: ClassVar[str | None] = "block"
    locates_events: ClassVar[bool] = True
    preference: ClassVar[int | None] = 4
    restitution: ClassVar[str | None] = None
    slides: ClassVar[bool] = False
    starts_moving: ClassVar[tuple[str, ...]] = ("plane",)
    bodies: ClassVar[tuple[bool, bool]] = (True, False)
    bodies_move: ClassVar[tuple[str, ...]] = ("plane",)
    rounded: ClassVar[bool] = True
    holds: ClassVar[bool] = True
    vertical: ClassVar[tuple[str, ...]] = ("block",)

    @classmethod
    def declines(cls, scene: SceneKind) -> str | None:
        """Why its model is not for a scene: Housner's block must not slide."""
        if scene.stacked:
            return "housner runs single blocks, and the case has a stack"
        least, given = scene.angular_restitution, scene.restitution_given
        if least <= 0.0 and not given and not scene.bodies and scene.held != BED:
            return (
                "housner needs an angular restitution above 0 in every lane, a width below "
                f"{WIDEST:.4g} times the height: the smallest is {least:.3g}, and that block does "
                "not rock over to its other corner"
            )
        if scene.friction_ratio < 1.0 and scene.held != STRIP:
            return (
                "housner needs friction >= tan(slenderness angle) in every lane, the smallest "
                f"ratio is {scene.friction_ratio:.3g}: that block slides before it rocks"
            )
        return None

    def kernel_of(self, scene: SceneKind | Lanes) -> Kernel:
        """The kernel that runs a scene; see `KernelEngine.kernel_of`."""
        if scene.held == STRIP:
            return Kernel(housner, "strip_run")
        if scene.held == BED:
            return Kernel(housner, "bed_run")
        if scene.held and scene.held != FRAME:
            return Kernel(housner, "held_run")
        name = "body_run" if scene.on_points else "block_run"
        return Kernel(housner, name, lanes=self.target.lanes)

    def inputs(
        self, module: Any, lanes: Lanes, motions: GroundMotions, times: SampleTimes
    ) -> dict[str, Any]:
        """What the kernel takes; see `KernelEngine.inputs`."""
        if lanes.body is not None:
            return self._body_inputs(lanes, motions, times)
        if lanes.held == STRIP:
            return self._strip_inputs(lanes, motions, times)
        if lanes.held == BED:
            return self._bed_inputs(lanes, motions, times)
        alpha = lanes.slenderness_angle
        radius = rocking.half_diagonal(lanes.width, lanes.height)
        frequency_squared = 3.0 * GRAVITY / (4.0 * radius)
        rate = np.maximum(np.sqrt(frequency_squared), motions.components[0].fastest_rate)
        if lanes.held == FRAME:
            frequency_squared = lanes.frequency_parameter**2
        elif lanes.hold is not None:
            rate = np.maximum(rate, tie_rate(lanes))
        step_length = PHASE_STEP[self.target.precision] / rate
        blocks = {
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
            "step_limit": step_limit(
                motions, times.duration, step_length, STEPS_SPARE, len(times.times)
            ),
        }
        more = {}
        if lanes.hold is not None and lanes.held != FRAME:
            more = held_inputs(lanes)
            blocks |= more.pop("blocks")
        return {
            "blocks": {name: each[:, None] for name, each in blocks.items()},
            **start_columns(lanes),
            **more,
        }

    def _strip_inputs(
        self, lanes: Lanes, motions: GroundMotions, times: SampleTimes
    ) -> dict[str, Any]:
        """What the kernel of strips takes."""
        precision = self.target.precision
        rate = np.maximum(strip_rate(lanes), motions.components[0].fastest_rate)
        step_length = PHASE_STEP[precision] / rate
        ratio = max(self.settings.rest_rotation_ratio, REST_RATIO_LEAST[precision])
        blocks = strip_inputs(lanes) | {
            "angular_restitution": lanes.angular_restitution,
            "rest_rotation": lanes.slenderness_angle * ratio,
            "step_length": step_length,
            "step_limit": step_limit(
                motions, times.duration, step_length, STEPS_SPARE, len(times.times)
            ),
        }
        return {
            "blocks": {name: each[:, None] for name, each in blocks.items()},
            **start_columns(lanes),
        }

    def _bed_inputs(
        self, lanes: Lanes, motions: GroundMotions, times: SampleTimes
    ) -> dict[str, Any]:
        """What the kernel of blocks on compliant ground takes."""
        rate = np.maximum(bed_rate(lanes), lanes.frequency_parameter)
        rate = np.maximum(rate, motions.components[0].fastest_rate)
        step_length = BED_STEP * PHASE_STEP[self.target.precision] / rate
        limit = step_limit(motions, times.duration, step_length, STEPS_SPARE, len(times.times))
        blocks = bed_inputs(lanes) | {"step_length": step_length, "step_limit": limit}
        return {
            "blocks": {name: each[:, None] for name, each in blocks.items()},
            **start_columns(lanes),
        }

    def _body_inputs(
        self, lanes: Lanes, motions: GroundMotions, times: SampleTimes
    ) -> dict[str, Any]:
        """What the kernel of bodies takes."""
        precision = self.target.precision
        ratio = max(self.settings.rest_rotation_ratio, REST_RATIO_LEAST[precision])
        found = body_inputs(lanes, ratio)
        rate = found.pop("rate")
        if isinstance(motions, UprightMotions):
            # Under g + a_z all rates grow by the root of (g + a_z) / g.
            rate = rate * np.sqrt(1.0 + motions.z.acceleration_bound() / GRAVITY)
        for part in motions.components:
            rate = np.maximum(rate, part.fastest_rate)
        step_length = PHASE_STEP[precision] / rate
        spare = STEPS_SPARE * found["feet"]["alpha"].shape[1]
        limit = step_limit(motions, times.duration, step_length, spare, len(times.times))
        blocks = found["blocks"] | {"step_length": step_length, "step_limit": limit}
        return found | {"blocks": {name: each[:, None] for name, each in blocks.items()}}

    def fields(
        self, lanes: Lanes, motions: GroundMotions, times: SampleTimes, found: Found
    ) -> dict[str, npt.NDArray[Any]]:
        """Lane fields of a response; see `KernelEngine.fields`."""
        rows = found.lanes
        needed, slides = asked_friction(rows, lanes.friction, self.target.precision)
        # Of bodies the kernel gives I w^2 over the mass: only the mass is left to multiply by.
        factor = inertia_of(lanes) if lanes.body is None else lanes.mass
        if lanes.held == STRIP:
            factor = strip_of(lanes).upright.inertia[:, 0]
        rest_time = np.where(rows["mode"] == RESTING, time_or_nan(rows["rest_time"]), np.nan)
        marks = [(slides, Status.OUTSIDE_MODEL)]
        lost = 0.5 * factor * rows["loss"]
        more = {}
        if lanes.held == FRAME:
            # Under a frame, columns share the friction at their bases: none is judged alone.
            return {
                **lane_fields(rows, rest_time),
                **planar_fields(found.blocks),
                "energy_lost": lost,
            }
        if lanes.held == BED:
            lost = rows["loss"]
        elif lanes.hold is not None and lanes.held != STRIP:
            lost = lost + rows["tie_loss"]
            more = held_fields(lanes, rows)
        return {
            **lane_fields(rows, rest_time, marks),
            **planar_fields(found.blocks),
            "energy_lost": lost,
            "friction_needed": needed,
            **more,
        }
