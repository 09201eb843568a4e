"""The velocity-level contact engine: sequential impulses on hard contacts, batched."""

from __future__ import annotations

import dataclasses
from typing import Any, ClassVar, final

import numpy.typing as npt

from warprock.engines.base import KernelEngine
from warprock.engines.blocks import planar_columns, speed_columns, stack_columns
from warprock.engines.bodies import Corners, box_bodies
from warprock.engines.decoding import lane_fields, planar_fields, rest_start_times, spatial_fields
from warprock.engines.launching import Found, Kernel
from warprock.engines.soundness import account_in_space, account_of, unstable
from warprock.engines.spatial_bodies import spatial_inputs
from warprock.engines.stack_bodies import foot_columns
from warprock.kernels import impulse, impulse_space
from warprock.kernels.launch.instance import BYTES, MAX_UNROLL
from warprock.model.lanes import Lanes, as_stacks
from warprock.model.motion import GroundMotions
from warprock.model.response import SampleTimes, Status
from warprock.model.scene import SceneKind
from warprock.settings.engines import ImpulseSettings
from warprock.units import GRAVITY

ROW_BYTES = 128
"""Bytes of a row of a pack of bodies or stacks in space. Of more lanes what a sweep reads of all
contacts would not fit into the nearest cache of a core."""


@final
@dataclasses.dataclass(frozen=True)
class Impulse(KernelEngine):
    """Hard contacts at two corners, Coulomb friction, warm-started projected Gauss-Seidel.

    Semi-implicit Euler at the time step of Eq. 9 of the paper, first order in it. A block rocks
    while a corner has parted from the base, by more than a step of falling makes; it is at rest
    while none has and it does not slide. In a stack the same holds at the two ends of what two
    faces share. A contact that has no other beside it is solved exactly. A lane that gains more
    energy than it held and its base supplied has the status UNSTABLE; what `erp` lifts counts as a
    gain. On a base that moves upwards in the plane single boxes run as bodies on two points.

    In space a block touches at its four corners, and two faces at up to eight points. A single
    block rocks and lands there by the same rule; it lifts once no two opposite corners carry. A
    stack rocks while a point is open by more than a step of falling makes. Of the energy that the
    base supplied only an upper bound is known there. Where friction can stop all contacts of a
    single block together, one solve does; the sweeps solve what slides or leaves.

    A body in space stands on up to 64 points. It rocks while a point that it stood on has parted
    and the points that carry do not span a plane. It is at rest on whatever points it came to lie
    on.
    """

    name: ClassVar[str] = "impulse"
    settings_type = ImpulseSettings
    order: ClassVar[int | None] = 1
    preference: ClassVar[int | None] = 2
    spatial: ClassVar[bool] = True
    starts_moving: ClassVar[tuple[str, ...]] = ("plane", "space")
    bodies: ClassVar[tuple[bool, bool]] = (True, True)
    bodies_move: ClassVar[tuple[str, ...]] = ("plane", "space")
    stacked_bodies: ClassVar[bool] = True
    vertical: ClassVar[tuple[str, ...]] = ("block", "stack")

    def kernel_of(self, scene: SceneKind | Lanes) -> Kernel:
        """The kernel that runs a scene.

        Beyond MAX_UNROLL sweeps the compiler leaves the packed loop over lanes scalar, many times
        slower than the plain form: single blocks then run in that.
        """
        lanes, sweeps = self.target.lanes, self.settings.iterations
        if scene.spatial:
            friction = "box" if self.settings.friction_box else "cone"
            if scene.stacked or scene.bodies:
                few = min(lanes, ROW_BYTES // BYTES[self.target.precision])
                name = "stack_run" if scene.stacked else "body_run"
                return Kernel(impulse_space, name, lanes=few, friction=friction)
            if scene.moving or self.settings.restitution > 0.0:
                return Kernel(impulse_space, "block_run", friction=friction, thrown=True)
            return Kernel(impulse_space, "block_run", lanes=lanes, friction=friction)
        if scene.stacked:
            return Kernel(impulse, "stack_run", lanes=lanes, iterations=sweeps)
        slow = self.target.form is None and sweeps > MAX_UNROLL
        # Boxes that start in motion run as bodies: the loop of boxes lets them go from rest.
        name = "body_run" if scene.on_points or scene.moving else "block_run"
        return Kernel(impulse, name, lanes=1 if slow else lanes, iterations=sweeps)

    def inputs(
        self, module: Any, lanes: Lanes, motions: GroundMotions, times: SampleTimes
    ) -> dict[str, Any]:
        """What the kernel takes; see `KernelEngine.inputs`."""
        step = self.settings.time_step
        knobs = module.Knobs()
        knobs.time_step = step
        knobs.rate = 1.0 / step
        knobs.gravity = GRAVITY
        knobs.collision_margin = self.settings.collision_margin
        knobs.erp = self.settings.erp
        if lanes.spatial:
            knobs.sweeps = self.settings.iterations
            knobs.moves = sum(
                int(part.moves.any()) << d for d, part in enumerate(motions.components)
            )
            knobs.restitution = self.settings.restitution
            return spatial_inputs(lanes) | {"knobs": knobs}
        if lanes.stacked:
            blocks = planar_columns(lanes, GRAVITY * step)
            rows, feet = stack_columns(lanes), foot_columns(lanes, module.Foot)
            return {"blocks": blocks, "lanes": rows, "feet": feet, "knobs": knobs}
        if lanes.body is not None or lanes.moving:
            body = lanes.body or box_bodies(lanes)
            corners = Corners.of(body)
            blocks = {
                "inverse_inertia": 1.0 / body.gyration,
                "friction": lanes.friction,
                "reach": corners.reach,
                "start": lanes.rotation_start,
                **speed_columns(lanes),
            }
            blocks = {name: each[:, None] for name, each in blocks.items()}
            return {"blocks": blocks, "corners": corners.columns, "knobs": knobs}
        stacks = as_stacks(lanes)
        blocks = {
            "half_width": 0.5 * stacks.width,
            "half_height": 0.5 * stacks.height,
            "inverse_inertia": 12.0 / (stacks.width**2 + stacks.height**2),
            "friction": stacks.friction,
        }
        return {"blocks": blocks, "starts": lanes.rotation_start, "knobs": knobs}

    def fields(
        self, lanes: Lanes, motions: GroundMotions, times: SampleTimes, found: Found
    ) -> dict[str, npt.NDArray[Any]]:
        """Lane fields of a response; see `KernelEngine.fields`."""
        rows, step = found.lanes, self.settings.time_step
        # Of single blocks the kernels know the energy of unit mass.
        mass = 1.0 if lanes.stacked else lanes.mass
        if lanes.spatial:
            blocks = spatial_fields(lanes, found.blocks)
            account = account_in_space(lanes, motions, times.duration, rows, mass)
            gained = unstable(lanes, account, blocks["peak_tilt"])
        else:
            blocks = planar_fields(found.blocks)
            gained = unstable(lanes, account_of(rows, step, mass), blocks["peak_rotation"])
        # A lane is at rest if in its last step no corner had parted and nothing slid.
        rest_time = rest_start_times(rows, times.times[-1] - 0.5 * step)
        fields = lane_fields(rows, rest_time, [(gained, Status.UNSTABLE)])
        return fields | blocks | {"energy_lost": mass * rows["loss"]}
