"""The soft-spring (distinct element) engine: sub-contact springs under every block, batched."""

from __future__ import annotations

import math
from types import ModuleType
from typing import Any, ClassVar, final

import numpy as np
import numpy.typing as npt
import warp as wp

from warprock.engines.base import AbstractEngine
from warprock.engines.decoding import lane_fields, planar_fields
from warprock.engines.dem_springs import (
    interface_depth,
    stable_step,
    standing_ratio,
    start_at_rest,
    stiffest_frequency,
)
from warprock.engines.launching import NEVER, Kernel, Target, respond
from warprock.engines.soundness import account_of, unstable
from warprock.engines.spatial_dem import (
    dem_module,
    longest_steps,
    run_dem,
    standing_ratio_in_space,
)
from warprock.engines.stack_launching import (
    Array,
    as_stacks,
    body_columns,
    launch_stacks,
    stack_module,
)
from warprock.model import rocking
from warprock.model.lanes import Lanes
from warprock.model.motion import GroundMotions, StillBase
from warprock.model.response import FIELDS, Response, SampleTimes, Status
from warprock.model.scene import SceneKind
from warprock.settings.engines import DemSettings
from warprock.units import GRAVITY

TURN_SAMPLES = 2000
"""Samples in which a turn is looked for: it is flat, a sample misses 1e-6 of it."""


@final
class Dem(AbstractEngine):
    """Springs and dashpots over every interface, Mohr-Coulomb slip, central differences.

    First order in the step, whose dashpots are half a step late. Every lane has its own step: the
    `time_step` of the settings, or `step_safety` of what its stiffest mode allows.

    A lane has lifted once the springs of an eighth of an interface, at one end, carry all: of five
    sub-contacts only the last, which is when a rigid block lifts; its time is when that interface
    began to gape in the middle. It is at rest while no interface has parted so and none slides; an
    impact is an interface that closes in the middle again, bounces counted. What a lane lost went
    into dashpots, slip and springs that opened under load. The account of its energy knows what
    springs hold; a lane that gains what neither its start nor its base gave, by a tenth of what
    they did and of what overturns it, has the status UNSTABLE, as at a `step_safety` beyond 1.

    Blocks lift and overturn below g tan(slenderness angle) on springs, and that is the model. Under
    an acceleration that starts at once a rigid block stands up to g b / h (half width over half
    height); a block on springs rocks on them before it lifts, and falls from

        a = g (b / h - sqrt((A / A_end - 1) d / h)),   d = m g / (k A),

    on, A / A_end = 2 (points - 1), if dashpots take nothing: by 8 % for a block of 0.2 m x 1 m on
    the default springs, by 0.3 % on two points of 1e11 N/m^3. Under several cycles still less will
    do, as a block that has begun to rock takes energy from every one of them.

    Blocks that are too tall for their springs (k I <= W h, see `standing_ratio`) are refused.

    In space the springs are a grid, `subcontacts` along the width times `subcontacts_across` along
    the depth, under the face of the upper block; they press along the normal of the lower face. A
    lane has lifted there once an interface gapes from the middle to three quarters of the way to
    the corner that is pressed most: about an edge that is when it does in the plane. A
    block that rocks over corners chatters on weakly damped springs: there no order shows.
    """

    name: ClassVar[str] = "dem"
    order: ClassVar[int | None] = 1
    settings_type = DemSettings

    def __init__(self, settings: DemSettings | None = None, target: Target | None = None) -> None:
        """Builds the engine.

        Args:
            settings: Defaults where None.
            target: Precision, device and form of the kernel.
        """
        self.settings = settings or DemSettings()
        self.target = target or Target()

    @classmethod
    def supports(cls, scene: SceneKind) -> str | None:
        """Why the scene cannot be run; None if it can: impacts follow the contact law alone."""
        if scene.restitution_given:
            return (
                "dem finds the angular restitution from its contact law and cannot follow "
                "the prescribed contact.angular_restitution"
            )
        return None

    def kernel(self, scene: SceneKind | Lanes) -> Kernel:
        """The kernel that runs a scene: the same text for a single block and for a stack."""
        file = "dem/space_stack_run" if scene.spatial else "dem/stack_run"
        return Kernel(file, self.target.kernel_form)

    def warm_up(self, lanes: Lanes, motions: GroundMotions) -> None:
        """Compiles or loads the kernels; see `AbstractEngine.warm_up`."""
        wp.load_module(self._module(lanes, motions).__name__, device=self.target.device)

    def longest_step(self, lanes: Lanes, motions: GroundMotions) -> npt.NDArray[np.float64]:
        """Longest step of every lane [s]; see `AbstractEngine.longest_step`."""
        if lanes.spatial:
            return longest_steps(self.settings, lanes)
        limit = stable_step(stiffest_frequency(as_stacks(lanes), self.settings), self.settings)
        return np.asarray(np.minimum(self.settings.time_step, self.settings.step_safety * limit))

    def reserve(self, lanes: Lanes) -> tuple[Array, str]:
        """Whether blocks can stand on their springs; see `AbstractEngine.reserve`."""
        if lanes.spatial:
            ratio = standing_ratio_in_space(lanes, self.settings)
        else:
            ratio = standing_ratio(as_stacks(lanes), self.settings)
        return ratio.min(axis=1), (
            "in dem the stiffness against rocking of the springs below a block over what the "
            "weight on them needs to stand, k_n I / (W h); raise engines.dem.normal_stiffness"
        )

    def _module(self, lanes: Lanes, motions: GroundMotions) -> ModuleType:
        if lanes.spatial:
            return dem_module(self.kernel(lanes), self.settings, self.target, lanes, motions)
        return stack_module(
            self.kernel(lanes), self.target, motions, lanes, self.settings.subcontacts
        )

    def _knobs(self, module: Any) -> Any:
        knobs = module.Knobs()
        knobs.gravity = GRAVITY
        knobs.normal_stiffness = self.settings.normal_stiffness
        knobs.shear_stiffness = self.settings.shear_stiffness
        knobs.shear_flexibility = 1.0 / self.settings.shear_stiffness
        knobs.stiffness_damping = self.settings.stiffness_damping
        knobs.mass_damping = self.settings.mass_damping
        knobs.cohesion = self.settings.cohesion
        knobs.tensile_strength = self.settings.tensile_strength
        knobs.dilatancy = math.tan(self.settings.dilatancy)
        return knobs

    def run(self, lanes: Lanes, motions: GroundMotions, times: SampleTimes) -> Response:
        """Runs a batch of lanes on the calling thread; see `AbstractEngine.run`."""
        module = self._module(lanes, motions)
        if lanes.spatial:
            knobs = self._knobs(module)
            return run_dem(module, self.settings, knobs, self.target, lanes, motions, times)
        stacks = as_stacks(lanes)
        step = self.longest_step(lanes, motions)
        turned = np.diff(stacks.rotation_start, axis=1, prepend=0.0).any(axis=1)
        rows, per_block, rotations = launch_stacks(
            module,
            self.target,
            motions,
            times,
            _blocks(stacks, self.settings),
            {
                # A lane whose sizes are not finite takes one step to find that out.
                "time_step": np.where(np.isfinite(step), step, times.duration),
                "uplift_time": np.where(turned, 0.0, NEVER),
            },
            self._knobs(module),
        )
        # Springs tilt under what rigid faces carry: its own account alone tells what is gained.
        gained = unstable(
            stacks, account_of(rows, step), per_block["peak"], rigid=False, complete=True
        )
        # In the last step of the run every interface was closed and held.
        marks = [(gained, Status.UNSTABLE)]
        columns = lane_fields(rows, times.times[-1] - 1.5 * step, marks) | planar_fields(per_block)
        if not lanes.stacked:
            columns = {k: v[:, 0] if FIELDS[k].per_block else v for k, v in columns.items()}
            rotations = None if rotations is None else rotations[:, 0]
        return respond(self.name, columns, rotations, times)


def equivalent_restitution(lanes: Lanes, settings: DemSettings | None = None) -> Array:
    """Angular restitution of a rigid block that swings back as far as the one on springs [-].

    The root of the ratio of the energies at the first turn on the other side and at the release,
    to be held against Housner's `rocking.angular_restitution`. The springs have a mean value of
    their own only where they absorb a blow before the next: bounces are part of it.

    Args:
        lanes: Single blocks, released from `rotation_start`, not zero.
        settings: Defaults where None.

    Returns:
        Shape [lane].

    References:
        Housner (1963), energy of free rocking.
    """
    quarter = rocking.quarter_period(lanes.width, lanes.height, lanes.rotation_start)
    duration = 2.5 * float(np.max(quarter))
    times = SampleTimes(duration, duration / TURN_SAMPLES)
    response = Dem(settings).run(lanes, StillBase(lanes.lane_count), times)
    away = -np.sign(lanes.rotation_start)[:, None] * response["rotation"]
    turn = np.maximum(away.max(axis=1), 0.0)
    angle = lanes.slenderness_angle
    after = np.cos(angle - turn) - np.cos(angle)
    before = np.cos(angle - np.abs(lanes.rotation_start)) - np.cos(angle)
    return np.asarray(np.sqrt(after / before))


def _blocks(stacks: Lanes, settings: DemSettings) -> dict[str, Array]:
    """Fields of the struct `Block`, shape [lane, block] each."""
    start = start_at_rest(stacks, settings)
    return {
        **body_columns(stacks),
        "depth": interface_depth(stacks),
        "x": start.x,
        "z": start.settlement,
        "theta": start.rotation,
        "stretch": start.stretch,
    }
