"""The event-driven contact engine: second order in the time step through impacts, batched."""

from __future__ import annotations

import dataclasses
from typing import Any, ClassVar, cast, final

import numpy as np
import numpy.typing as npt

from warprock.engines.base import HELD_IN_PLACE, KernelEngine
from warprock.engines.blocks import speed_columns, start_columns
from warprock.engines.bodies import Corners, box_bodies
from warprock.engines.coplanar import response_in_space
from warprock.engines.decoding import (
    asked_friction,
    lane_fields,
    planar_fields,
    spatial_fields,
    time_or_nan,
)
from warprock.engines.energy import nearest_edge
from warprock.engines.held import (
    free_tie_rate,
    held_fields,
    load_columns,
    tie_columns,
    wall_columns,
)
from warprock.engines.launching import NEVER, Form, Found, Kernel
from warprock.engines.soundness import account_in_space, unstable
from warprock.engines.spatial_bodies import point_rows, quickest, spatial_inputs
from warprock.engines.stack_bodies import edge_columns, foot_columns
from warprock.engines.workload import step_limit
from warprock.kernels import event, event_space
from warprock.model import rocking
from warprock.model.bodies import CORNERS, Bodies, boxes_on_corners
from warprock.model.coplanar import Coplanar, find_coplanar, in_their_plane, no_plane
from warprock.model.lanes import Lanes, SpatialLanes, as_stacks
from warprock.model.motion import GroundMotions, RecordMotions, SpatialMotions, UprightMotions
from warprock.model.pose import bottom_corners
from warprock.model.response import Response, SampleTimes, Status, join_responses, take_lanes
from warprock.model.runnable import HIGHEST_STACK
from warprock.model.scene import SceneKind
from warprock.settings.engines import NEWTON, EventSettings
from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]

PHASE_STEP = 0.25
"""Longest step, times the frequency parameter p of the quickest block: a longer one does not
resolve its rocking."""

POLYNOMIAL_STEPS = 4.0
"""Longest step over `time_step` of single boxes in the plane that follow polynomials. These are of
fifth order, and err by less in such a step than a scheme of second order in `time_step`."""

SHORT_STEP = 0.5
"""Longest step over `time_step` of single boxes in the plane that slide on a corner or fly. The
difference of two runs does not show a slide that is shorter than their steps (of 600 pulses the
estimates held in 96 % of the lanes with 1, in 99.4 % with 0.5)."""

MOTION_STEP = 1.0
"""Longest step of single boxes in the plane, times the largest angular frequency of their motion:
its Taylor polynomials end at degree 8."""

SHORTEST_BOUNCE = 0.0625
"""Shortest flight of a corner that bounces, over the longest step; shorter ones are left out. The
difference of two runs does not show them where both leave out the same. Of 256 pulses the estimates
held in all lanes at restitutions of 0.2 to 0.6, in 96 to 100 % with 0.25 and in 80 to 88 % with 1,
which saves 7 % of the steps; at 0.8 in 95 to 98 %."""

HELD_STEP = 0.4
"""Longest step of held blocks times the largest angular frequency of block, ties and motion: what
their series of degree 10 leave out of a step is about this to the power 11 over 11!, 1e-12."""

STACK_REST = 1e-2
"""Swing at which a block of a stack in the plane rests, over that of a single block; in space, too,
where it bounces. Its last swings decide which ends take part in an impact elsewhere. Of 560 random
stacks in the plane of 2 to 6 blocks 7 erred by more than 1e-2 of the slenderness angle with 1, and
one with 1e-2, in 1.2 times as many steps."""

STEPS_SPARE = 50
"""Steps allowed for every step that a run without events would take; an impact takes some four, so
this is far above any motion and ends only a lane that makes no headway."""

PACK = 8
"""Lanes of blocks in space that run side by side: one vector of float64 with AVX-512. Steps with an
event run one lane at a time, so a larger pack gains nothing, and a small batch costs less."""

OF_ITS_OWN = -1.0
"""Angular restitution that asks the law of contact of a body to find it."""


@final
@dataclasses.dataclass(frozen=True)
class Event(KernelEngine):
    """Rigid corners, Coulomb friction, midpoint Moreau-Jean steps that end at impacts.

    `order` is the least that a run has, 2, through impacts; estimates that count on it err on the
    safe side. In space stacks and bodies are of first order where they slide.

    Rest rule: a block rests after an impact on its other corner if its next swing would stay below
    `rest_rotation_ratio` times the slenderness angle, to either side. In a stack in the plane the
    bound is a hundredth of that. At rest it lifts or slides as the contact law says.

    `peak_penetration` is what the end of a step puts back on the base: drift, of third order in the
    step, and landings that the step misses by a part of its length.

    Single boxes in the plane (kernels/event/block/step.py): those that rock about a corner that
    sticks, or slide flat, follow Taylor polynomials of fifth order in steps of up to four times
    `time_step`; the knots of a record do not cut these short. Boxes that slide on a corner or fly
    take steps of second order, at most half of `time_step`.

    Boxes that ties, a load or a wall hold (kernels/event/held/step.py): Taylor series of degree 10
    in all that they do, sliding and flight among it, between events that are located to round-off.
    A wall is smooth; a point that strikes it leaves it with the part `rebound` of its speed, and
    the base is plastic. Their order is above 6: estimates that count on 2 are on the safe side.

    Bodies in the plane (kernels/event/body/step.py), also boxes whose base moves upwards or whose
    angular restitution is prescribed: corners may be rounded. A prescribed restitution acts in
    impacts on the other corner of the edge on which a body stands at first. The corner takes the
    impulses which that asks for. Where these need more friction than there is, the restitution is
    the nearest that friction allows (`struck_velocity` in kernels/event/body/contact.py).
    `friction_needed` is the friction that such impacts need; a lane with less is OUTSIDE_MODEL.

    With a `restitution` single blocks and bodies bounce, boxes as bodies, and stacks
    (kernels/event/body/bounce.py, kernels/event_space/body/bounce.py,
    kernels/event/stack/bounce.py, kernels/event_space/stack/bounce.py): second order through all
    bounces where the scheme without them is of second order. Those that are left out have
    heights of second order in the step.

    Stacks in the plane (kernels/event/stack/): fifth order while all contacts stick, second where
    something slides or flies. A body in a stack stands on an edge of its chain of corners
    (kernels/event/stack/edges.py). A column of equal drums that an [assembly] lays runs as a stack,
    too; a lane ends once a drum has overturned or slid off, where it has collapsed.

    Where the base moves upwards gravity is g + a_z; below zero a block flies until it lands.

    Blocks in space have four corners (kernels/event_space/block/step.py), bodies up to 64 points
    (kernels/event_space/body/step.py). Both are of second order while contacts stick, through
    impacts, too. So are stacks (kernels/event_space/stack/step.py); they do not locate when an edge
    lets go of an end, which is of first order. A stack that is its own mirror image in a vertical
    plane, on a base that moves in that plane, runs as a stack in the plane
    (warprock/model/coplanar.py).

    With friction as a box single blocks are of second order through the ends of their slips along x
    and y; the errors of blocks that rock and slide scatter (order 1.4 to 2). Rigid faces do not
    determine how they share their load. Where a stack slides along x and sticks along y, its yaw
    depends on that, so `event` and `impulse` may find different ones.
    """

    name: ClassVar[str] = "event"
    settings_type = EventSettings
    order: ClassVar[int | None] = 2
    locates_events: ClassVar[bool] = True
    preference: ClassVar[int | None] = 1
    spatial: ClassVar[bool] = True
    starts_moving: ClassVar[tuple[str, ...]] = ("plane", "space")
    bodies: ClassVar[tuple[bool, bool]] = (True, True)
    bodies_move: ClassVar[tuple[str, ...]] = ("plane", "space")
    drums: ClassVar[bool] = True
    highest: ClassVar[tuple[int, int]] = (HIGHEST_STACK, 6)
    stacked_bodies: ClassVar[bool] = True
    rounded: ClassVar[bool] = True
    holds: ClassVar[bool] = True
    vertical: ClassVar[tuple[str, ...]] = ("block", "stack")
    restitution: ClassVar[str | None] = None
    rests_exactly: ClassVar[bool] = True

    @classmethod
    def declines(cls, scene: SceneKind) -> str | None:
        """Why its model is not for a scene: what is prescribed is for one block in the plane."""
        if scene.restitution_given and (scene.spatial or scene.stacked):
            where = "in space" if scene.spatial else "of stacks"
            return (
                f"event finds the angular restitution {where} from its contact law and cannot "
                "follow the prescribed contact.angular_restitution"
            )
        beyond = [table for table in scene.held if table not in HELD_IN_PLACE]
        if beyond:
            return (
                "event runs blocks in one piece that stand by themselves, and the case holds its "
                f"block another way ({' and '.join(beyond)}); housner runs it"
            )
        if scene.held and scene.restitution_given:
            return (
                "event finds what a held block keeps in an impact from its contact law and cannot "
                "follow the prescribed contact.angular_restitution; housner can"
            )
        return None

    def refuses(self, scene: SceneKind) -> str | None:
        """Why its settings are not for a scene: what does not bounce."""
        if not self._bounces:
            return None
        if scene.stacked and not scene.held and self.settings.restitution_law != NEWTON:
            return (
                "engines.event.restitution_law = 1 is for single free-standing blocks and bodies, "
                "and the case has a stack, which bounces by Newton's law, 0"
            )
        why = None
        if scene.assembly or scene.held:
            table = "assembly" if scene.assembly else next(iter(scene.held), "")
            why = f"the case has [{table}]"
        elif scene.restitution_given:
            why = "the case prescribes contact.angular_restitution"
        return why and (
            "engines.event.restitution above 0 is for single free-standing blocks and bodies and "
            f"for stacks, and {why}"
        )

    def kernel_of(self, scene: SceneKind | Lanes) -> Kernel:
        """The kernel that runs a scene: packed are single blocks alone, in space on a cone."""
        if not scene.spatial:
            piled = scene.piled if isinstance(scene, SceneKind) else scene.stacked
            if piled:
                return Kernel(event, "stack_run", bounces=self._bounces)
            if scene.held:
                return Kernel(event, "held_run")
            cornered = scene.on_points or scene.restitution_given or self._bounces
            name = "body_run" if cornered else "block_run"
            return Kernel(event, name, lanes=self.target.lanes, bounces=self._bounces)
        friction = "box" if self.settings.friction_box else "cone"
        if isinstance(scene, SceneKind) and self._runs_in_plane(scene) == 1.0:
            return Kernel(event, "stack_run", bounces=self._bounces)
        if scene.stacked:
            return Kernel(event_space, "stack_run", friction=friction, bounces=self._bounces)
        if scene.bodies or self._bounces:
            rows = point_rows(scene) if scene.bodies else CORNERS
            return Kernel(
                event_space, "body_run", friction=friction, points=rows, bounces=self._bounces
            )
        if scene.moving:
            return Kernel(event_space, "block_run", friction=friction, thrown=True)
        if self.target.kernel_form is Form.PACKED and friction == "cone":
            return Kernel(event_space, "block_pack_run", lanes=PACK)
        return Kernel(event_space, "block_run", friction=friction)

    def kernel_note(self, scene: SceneKind) -> str:
        """Which stacks in space run in the plane; see `KernelEngine.kernel_note`."""
        part = self._runs_in_plane(scene)
        if part == 1.0:
            return "each stack moves in one vertical plane and runs in it"
        if part > 0.0:
            share = f"{part:.0%} of the stacks, which move in one vertical plane"
            return f"{share}, run in it (kernels/event/stack_run.py)"
        return ""

    def _runs_in_plane(self, scene: SceneKind) -> float:
        """Part of the stacks of a scene that run by the equations of the plane."""
        return 0.0 if self.settings.friction_box else scene.coplanar

    def _find_coplanar(self, lanes: Lanes, motions: GroundMotions) -> Coplanar:
        """The stacks that run by the equations of the plane.

        None does where friction is a box: that lies along x and y of the ground, so that a plane
        in another direction is none of symmetry.
        """
        return no_plane(lanes) if self.settings.friction_box else find_coplanar(lanes, motions)

    def longest_step(self, lanes: Lanes, motions: GroundMotions) -> Array:
        """Longest step that every lane may take [s]: also cut at the knots of a record."""
        step = np.array(self._own_step(self.kernel_lanes(lanes, motions), motions))
        found = self._find_coplanar(lanes, motions)
        for rows in found.lots:
            parts = in_their_plane(*_in_space(lanes, motions), found, rows)
            step[rows] = self._own_step(*parts)
        return np.asarray(np.minimum(step, motions.knot_interval))

    def step_of_settings(self, lanes: Lanes, motions: GroundMotions) -> float:
        """Longest step that the settings ask for [s]; polynomials take longer ones."""
        parts = POLYNOMIAL_STEPS if self._rolls(lanes, motions) else 1.0
        return parts * float(self.settings.time_step)

    def kernel_lanes(self, lanes: Lanes, motions: GroundMotions) -> Lanes:
        """Lanes as its kernels take them: boxes are bodies where they bounce, too."""
        joined = lanes.stacked or lanes.assembly is not None
        if not self._bounces or lanes.body is not None or joined:
            return super().kernel_lanes(lanes, motions)
        if not lanes.spatial:
            return dataclasses.replace(lanes, body=box_bodies(lanes))
        own = None if lanes.release is None else lanes.release.gyration
        boxes = cast(SpatialLanes, lanes)
        sizes = np.stack([boxes.width, boxes.depth, boxes.height], axis=-1)
        body = boxes_on_corners(sizes=sizes, mass=lanes.mass, gyration=own)
        if not lanes.thrown:
            # It ends where it has overturned, and does not come down on its side.
            feet = bottom_corners(boxes)
            count = np.full(lanes.lane_count, feet.shape[1], np.int32)
            body = dataclasses.replace(body, points=feet, count=count)
        release = lanes.release and dataclasses.replace(lanes.release, gyration=None)
        return dataclasses.replace(boxes, body=body, release=release)

    @property
    def _bounces(self) -> bool:
        """Whether corners that strike the base leave it again."""
        return bool(self.settings.restitution > 0.0)

    def _rolls(self, lanes: Lanes, motions: GroundMotions) -> bool:
        """Whether lanes are boxes that rock by Taylor polynomials (kernels/event/block/step.py)."""
        piled = lanes.stacked or lanes.assembly is not None
        boxes = not lanes.spatial and not piled and lanes.body is None
        follows = lanes.restitution_given or self._bounces or isinstance(motions, UprightMotions)
        return boxes and not follows

    def _own_step(self, lanes: Lanes, motions: GroundMotions) -> Array:
        """Longest step [s]: a part of 1 / p, the largest of blocks, and in space of both planes."""
        if lanes.body is not None and lanes.spatial:
            fastest = quickest(lanes.body)
            return np.asarray(np.minimum(self.settings.time_step, PHASE_STEP / fastest))
        if lanes.body is not None:
            fastest = Corners.of(lanes.body).fastest_rate(lanes.body.gyration)
            return np.asarray(np.minimum(self.settings.time_step, PHASE_STEP / fastest))
        if lanes.profiles is not None:
            each = lanes.profiles.each
            rates = [Corners.of(body).fastest_rate(body.gyration) for body in each]
            fastest = np.max(rates, axis=0)
            return np.asarray(np.minimum(self.settings.time_step, PHASE_STEP / fastest))
        sides = (lanes.width, lanes.depth) if lanes.spatial else (lanes.width,)
        rates = [
            rocking.frequency_parameter(side, lanes.height).reshape(lanes.lane_count, -1)
            for side in sides
        ]
        fastest = np.concatenate(rates, axis=1).max(axis=1)
        step = np.asarray(np.minimum(self.step_of_settings(lanes, motions), PHASE_STEP / fastest))
        if self._rolls(lanes, motions):
            rate = motions.components[0].fastest_rate
            with np.errstate(divide="ignore"):
                step = np.minimum(step, MOTION_STEP / np.asarray(rate))
                if lanes.hold is not None:
                    rate = np.maximum(rate, np.maximum(fastest, free_tie_rate(lanes)))
                    step = np.minimum(step, HELD_STEP / rate)
        return step

    def alike_order(self, lanes: Lanes, motions: GroundMotions) -> npt.NDArray[np.intp] | None:
        """Single boxes under records by when they first move: until then they cost nothing.

        See `AbstractEngine.alike_order`.
        """
        if self.target.lanes == 1 or not self._rolls(lanes, motions) or lanes.release is not None:
            return None
        if lanes.hold is not None:
            return None
        record = motions.components[0]
        # Where nearly every lane has a record of its own that costs more than it gains.
        if not isinstance(record, RecordMotions):
            return None
        if record.record_count * self.target.lanes > lanes.lane_count:
            return None
        first = record.first_above(_hold_acceleration(lanes))
        return np.argsort(np.where(lanes.rotation_start == 0.0, first, 0.0), kind="stable")

    def warm_up(self, lanes: Lanes, motions: GroundMotions) -> None:
        """Compiles or loads the kernels for lanes and motions, once, on the calling thread."""
        found = self._find_coplanar(lanes, motions)
        for rows in found.lots:
            super().warm_up(*in_their_plane(*_in_space(lanes, motions), found, rows))
        if not found.within.all():
            super().warm_up(lanes, motions)

    def run(self, lanes: Lanes, motions: GroundMotions, times: SampleTimes) -> Response:
        """Runs a batch of lanes: stacks in space that move in one vertical plane run there."""
        found = self._find_coplanar(lanes, motions)
        if not found.lots:
            return super().run(lanes, motions, times)
        spatial, base = _in_space(lanes, motions)
        lots, parts = found.lots, []
        for rows in lots:
            response = super().run(*in_their_plane(spatial, base, found, rows), times)
            parts.append(response_in_space(spatial, found, rows, response))
        rest = np.flatnonzero(~found.within)
        if len(rest):
            lots = [*lots, rest]
            parts.append(super().run(lanes.take(rest), motions.take(rest), times))
        return take_lanes(join_responses(parts), np.argsort(np.concatenate(lots)))

    def inputs(
        self, module: Any, lanes: Lanes, motions: GroundMotions, times: SampleTimes
    ) -> dict[str, Any]:
        """What the kernel takes; see `KernelEngine.inputs`."""
        if lanes.hold is not None:
            return self._held_inputs(lanes, motions, times)
        knobs = module.Knobs()
        knobs.gravity = GRAVITY
        longest_step = self._own_step(lanes, motions)
        short_step = np.minimum(longest_step, SHORT_STEP * self.settings.time_step)
        per_lane: dict[str, npt.NDArray[Any]] = {
            "longest_step": longest_step,
            "step_limit": step_limit(motions, times.duration, short_step, STEPS_SPARE),
        }
        per_lane |= self._rebound(longest_step)
        if lanes.spatial:
            part = STACK_REST if lanes.stacked and self._bounces else 1.0
            per_lane["rest_gap"] = part * _rest_gap(lanes, self.settings)
            columns = spatial_inputs(lanes)
            return columns | {"lanes": per_lane | columns.get("frames", {}), "knobs": knobs}
        if lanes.stacked:
            per_lane["mass"] = lanes.mass.sum(axis=1)
            per_lane["fall"] = np.full(lanes.lane_count, NEVER)
            if lanes.profiles is None:
                blocks = _stacked_blocks(lanes, self.settings)
            else:
                blocks = {
                    **edge_columns(lanes),
                    "rest_rotation": _stack_rest(lanes, self.settings),
                }
            feet = foot_columns(lanes, module.Foot)
            return {"blocks": blocks, "lanes": per_lane, "feet": feet, "knobs": knobs}
        if lanes.body is not None or lanes.restitution_given:
            body = lanes.body or box_bodies(lanes)
            corners = Corners.of(body)
            per_lane |= _bodies(lanes, body, corners, self.settings)
            blocks = {name: each[:, None] for name, each in per_lane.items()}
            return {"blocks": blocks, "corners": corners.columns, "knobs": knobs}
        blocks = _single_blocks(lanes, self.settings)
        per_lane["short_step"] = short_step
        blocks |= {name: each[:, None] for name, each in per_lane.items()}
        return {"blocks": blocks, "knobs": knobs} | start_columns(lanes)

    def _rebound(self, longest_step: Array) -> dict[str, Array]:
        """How corners bounce: restitution by either law, and the speed up to which none is [m/s].

        A bounce that would last less than a part of the longest step, 2 e v / g, is left out.
        """
        kept, none = (
            np.full(longest_step.shape, self.settings.restitution),
            np.zeros_like(longest_step),
        )
        newton = self.settings.restitution_law == NEWTON
        with np.errstate(divide="ignore"):
            slow = 0.5 * GRAVITY * SHORTEST_BOUNCE * longest_step / kept
        rebound, expansion = (kept, none) if newton else (none, kept)
        return {"rebound": rebound, "expansion": expansion, "slow": slow}

    def _held_inputs(
        self, lanes: Lanes, motions: GroundMotions, times: SampleTimes
    ) -> dict[str, Any]:
        """What the kernel of held blocks takes."""
        longest_step = self._own_step(lanes, motions)
        blocks = _held_blocks(lanes, self.settings) | {
            "longest_step": longest_step,
            "step_limit": step_limit(motions, times.duration, longest_step, STEPS_SPARE),
        }
        return {
            "blocks": {name: each[:, None] for name, each in blocks.items()},
            "ties": tie_columns(lanes),
            **start_columns(lanes),
        }

    def fields(
        self, lanes: Lanes, motions: GroundMotions, times: SampleTimes, found: Found
    ) -> dict[str, npt.NDArray[Any]]:
        """Lane fields of a response; see `KernelEngine.fields`."""
        rows, marks = found.lanes, []
        if lanes.spatial:
            blocks = spatial_fields(lanes, found.blocks)
            account = account_in_space(lanes, motions, times.duration, rows)
            marks = [(unstable(lanes, account, blocks["peak_tilt"]), Status.UNSTABLE)]
        else:
            blocks = planar_fields(found.blocks)
        if lanes.restitution_given:
            needed, lacks = asked_friction(rows, lanes.friction, self.target.precision)
            marks = [(lacks, Status.OUTSIDE_MODEL)]
            blocks["friction_needed"] = needed
        rest_time = time_or_nan(rows["moved" if lanes.spatial else "rest_time"])
        fields = lane_fields(rows, rest_time, marks)
        if lanes.hold is not None:
            lost = rows["loss"] + rows["tie_loss"]
            return fields | blocks | held_fields(lanes, rows) | {"energy_lost": lost}
        # Of single blocks in the plane the kernel knows the energy of unit mass.
        mass = 1.0 if lanes.stacked or lanes.spatial else lanes.mass
        return fields | blocks | {"energy_lost": mass * rows["loss"]}


def _in_space(lanes: Lanes, motions: GroundMotions) -> tuple[SpatialLanes, SpatialMotions]:
    """The same lanes and motions, which are of space."""
    return cast(SpatialLanes, lanes), cast(SpatialMotions, motions)


def _hold_acceleration(lanes: Lanes) -> Array:
    """Acceleration of the base up to which boxes at rest neither lift nor slide [m/s^2]."""
    return np.asarray(GRAVITY * np.minimum(lanes.friction, lanes.width / lanes.height))


def _single_blocks(lanes: Lanes, settings: EventSettings) -> dict[str, npt.NDArray[Any]]:
    """Fields of the struct `Block` of single blocks, shape [lane, 1] each; they have the mass 1."""
    blocks = as_stacks(lanes)
    inertia = (blocks.width**2 + blocks.height**2) / 12.0
    return {
        "half_width": 0.5 * blocks.width,
        "half_height": 0.5 * blocks.height,
        "inertia": inertia,
        "inverse_inertia": 1.0 / inertia,
        "inverse_pivot_inertia": 0.25 / inertia,
        "friction": blocks.friction,
        "hold_acceleration": _hold_acceleration(blocks),
        "rest_rotation": settings.rest_rotation_ratio * blocks.slenderness_angle,
    }


def _held_blocks(lanes: Lanes, settings: EventSettings) -> dict[str, npt.NDArray[Any]]:
    """Fields of the struct `Block` of held blocks, shape [lane] each."""
    return {
        **wall_columns(lanes),
        **load_columns(lanes),
        "half_width": 0.5 * lanes.width,
        "half_height": 0.5 * lanes.height,
        "mass": lanes.mass,
        "inertia": lanes.mass * (lanes.width**2 + lanes.height**2) / 12.0,
        "gravity": np.full(lanes.lane_count, GRAVITY),
        "friction": lanes.friction,
        "rest_rotation": settings.rest_rotation_ratio * lanes.slenderness_angle,
    }


def _bodies(
    lanes: Lanes, body: Bodies, corners: Corners, settings: EventSettings
) -> dict[str, npt.NDArray[Any]]:
    """Fields of the struct `Body`, shape [lane] each; they have the mass 1."""
    given = lanes.angular_restitution if lanes.restitution_given else np.array(OF_ITS_OWN)
    return {
        "inertia": body.gyration,
        "inverse_inertia": 1.0 / body.gyration,
        "friction": lanes.friction,
        "radius": corners.radius,
        "start": lanes.rotation_start,
        "spin": speed_columns(lanes)["omega"],
        "restitution": np.broadcast_to(given, lanes.friction.shape),
        "rest_rotation": settings.rest_rotation_ratio * lanes.slenderness_angle,
    }


def _stacked_blocks(lanes: Lanes, settings: EventSettings) -> dict[str, Array]:
    """Fields of the struct `Block` of stacks, shape [lane, block] each."""
    inertia = lanes.mass * (lanes.width**2 + lanes.height**2) / 12.0
    return {
        "half_height": 0.5 * lanes.height,
        "half_width": 0.5 * lanes.face_width,
        "inverse_mass": 1.0 / lanes.mass,
        "inverse_inertia": 1.0 / inertia,
        "friction": lanes.friction,
        "rest_rotation": _stack_rest(lanes, settings),
        "aside": lanes.offset,
        "theta": lanes.rotation_start,
    }


def _stack_rest(lanes: Lanes, settings: EventSettings) -> Array:
    """Swings below which blocks of a stack in the plane rest [rad], shape [lane, block]."""
    return np.asarray(STACK_REST * settings.rest_rotation_ratio * lanes.slenderness_angle)


def _rest_gap(lanes: Lanes, settings: EventSettings) -> Array:
    """Rise of a corner from which a block in space rests [m], the least of a lane, shape [lane]."""
    if lanes.body is not None:
        edge, height = np.maximum(nearest_edge(lanes), 0.0), lanes.body.centre_height
        size = lanes.body.reaches.min(axis=1)
        return np.asarray(settings.rest_rotation_ratio * np.arctan2(edge, height) * size)
    face = np.minimum(lanes.face_width, lanes.face_depth)
    gap = settings.rest_rotation_ratio * np.arctan2(face, lanes.height) * face
    return np.asarray(gap.reshape(lanes.lane_count, -1).min(axis=1))
