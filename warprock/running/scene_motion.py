"""A lane as a scene in motion: where its blocks and its base are over time, seen from the ground.

The lane runs again, alone, at the step that its results are from, so that its picture shows these
results.
"""

from __future__ import annotations

import dataclasses
import pathlib
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from warprock.case.case import Case
from warprock.case.lanes import LaneSet, expand_lanes
from warprock.case.load import build_case
from warprock.errors import InputError, Said
from warprock.model.assembly import SPACE
from warprock.model.base_path import base_places
from warprock.model.hull import hull_surface
from warprock.model.lanes import Lanes, as_stacks
from warprock.model.pose import quaternion
from warprock.model.ratios import rotation_ratio
from warprock.model.response import HISTORIES, Outcome, Response
from warprock.model.solids import Face, SpatialAssembly
from warprock.model.turning import rotate
from warprock.reading import require_plain
from warprock.running.case_run import CaseRun, require_options, require_support, run_lane
from warprock.running.lane_table import LANE_TABLE, first_break, lane_pose
from warprock.running.options import RunOptions
from warprock.running.results import PROVENANCE
from warprock.running.run_file import NO_SHAPES, RUN, Shape, read_facts, require_shape
from warprock.running.scene_parts import Part, scene_parts, standing
from warprock.settings.engines import SETTINGS, judged_settings

Array = npt.NDArray[np.float64]

_PLANE = np.array([(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)])
_SPACE = np.array([(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])

FALLING = 30.0
"""Rotation [deg] beyond which a picture of a block shows its fall rather than what led to it."""


@dataclasses.dataclass(frozen=True)
class SceneMotion:
    """The motion of one lane, SI units, seen from the ground; x in the plane of rocking, z upwards.

    Attributes:
        name: Case and lane, in words.
        outcome: What became of the lane.
        spatial: Whether its blocks move in space.
        times: Times of the samples [s], shape [sample].
        sizes: Full width, depth and height of the blocks [m], lowest first, shape [block, 3].
        position: Middles of the blocks [m], shape [block, sample, 3].
        attitude: Quaternions (x, y, z, w) of the blocks, shape [block, sample, 4].
        ratio: Rotations over the slenderness angles [-], shape [block, sample].
        base: Displacement of the base since the start [m], shape [sample, 3].
        acceleration: Acceleration of the base [m/s^2], shape [sample, 3].
        outline: Corners of a body that is no box, as `Bodies.outline` gives them, in its plane with
            y = 0 [m], shape [corner, 3]; None of boxes. Its position is that of its centre of mass.
            Of a stack with bodies those of all blocks, shape [block, corner, 3].
        parts: What holds its block, as a picture shows it.
        ground: Displacement of the ground below the support of its base [m], shape [sample, 3];
            None without a support, where the base is the ground.
        fixed: How many blocks of an assembly, the last ones, move with the base; 0 of all other
            lanes. The ratios of an assembly are rotations in degrees.
        floor: Level of the ground on which an assembly falls, which moves with its base [m].
        goes_on: Whether an assembly that collapsed was followed to the end of its run.
        faces: Of the blocks of an assembly in space the corners of each face, counterclockwise from
            outside; empty of all others.
    """

    name: str
    outcome: str
    spatial: bool
    times: Array
    sizes: Array
    position: Array
    attitude: Array
    ratio: Array
    base: Array
    acceleration: Array
    outline: Array | None = None
    parts: tuple[Part, ...] = ()
    ground: Array | None = None
    fixed: int = 0
    floor: float = 0.0
    goes_on: bool = False
    faces: tuple[tuple[Face, ...], ...] = ()

    @property
    def tall(self) -> float:
        """Height of its blocks at the start [m], one on the other."""
        if not self.fixed:
            return float(self.sizes[:, 2].sum())
        middle, half = self.position[:, 0, 2], 0.5 * self.sizes[:, 2]
        return float((middle + half).max() - (middle - half).min())

    @property
    def end(self) -> float | None:
        """When the lane's model ended, since one of its stacked blocks fell [s]; None of others.

        Blocks then stay where they were, in the air, too: what follows is not modelled.
        """
        if self.goes_on or len(self.sizes) == 1 or self.outcome not in ("overturned", "slid off"):
            return None
        return float(self.times[last_move(self.ratio)])

    @property
    def largest(self) -> int:
        """The sample of the largest rotation below `FALLING`; without one, of the largest."""
        size = np.abs(self.ratio).max(axis=0)
        leans = np.rad2deg(np.abs(2.0 * np.arctan2(self.attitude[..., 1], self.attitude[..., 3])))
        leans = self.ratio if self.faces else leans
        up = leans.max(axis=0) < FALLING
        return int(np.argmax(np.where(up, size, -1.0))) if up.any() else int(np.argmax(size))

    @property
    def axes(self) -> str:
        """The axes that the base may move along: all in space, in the plane x, and z if it does."""
        if self.spatial:
            return "xyz"
        upwards = np.any(self.base[:, 2]) or np.any(self.acceleration[:, 2])
        return "xz" if upwards else "x"

    def corners(self) -> Array:
        """Corners of the blocks in their plane, going round [m], [block, sample, corner, 2]."""
        if self.outline is not None:
            return np.asarray(self._place(self._outlines)[..., [0, 2]])
        flat = _PLANE * self.sizes[:, None, None, [0, 2]]
        arms = np.insert(flat, 1, 0.0, axis=-1)
        return np.asarray(self._place(arms)[..., [0, 2]])

    def corners_in_space(self) -> Array:
        """All corners of the blocks [m], shape [block, sample, 8, 3]: -y, +y for -x, then +x.

        That is, corner 4 i + 2 j + k lies on the side i along the width, j along the depth and k
        along the height, 0 being the negative one. Of a body all corners of its outline.
        """
        if self.outline is not None:
            return self._place(self._outlines)
        return self._place(_SPACE * self.sizes[:, None, None, :])

    @property
    def _outlines(self) -> Array:
        """Outlines of all blocks, which are one or have their own, [block, 1, corner, 3]."""
        assert self.outline is not None
        return np.asarray(self.outline.reshape(-1, 1, *self.outline.shape[-2:]))

    @property
    def reach(self) -> float:
        """Half side of the base as pictures show it [m]: the middles of blocks stay above it."""
        tall, wide = self.tall, float(self.sizes[:, :2].max())
        usual = 0.75 * wide + 0.3 * tall
        away = float(np.nanmax(np.abs(self.position - self.base)[..., :2]))
        return usual if away <= usual else away + 0.5 * max(tall, wide)

    @property
    def span(self) -> tuple[float, float]:
        """Where the base as pictures show it begins and ends along x, from its middle [m]."""
        if self.fixed:
            away = (self.position - self.base)[..., 0]
            half = 0.5 * self.sizes[:, None, 0]
            return float((away - half).min()), float((away + half).max())
        low, high = standing(self.parts)
        return min(-self.reach, low), max(self.reach, high)

    def places_of(self, part: Part) -> Array:
        """Points of a part over time, along x and z [m], shape [sample, point, 2]."""
        turn = 2.0 * np.arctan2(self.attitude[0, :, 1], self.attitude[0, :, 3])
        block = np.column_stack([self.position[0][:, [0, 2]], turn])
        return part.places(self.base[:, [0, 2]], block)

    def surface(self, block: int) -> tuple[Array, Array] | None:
        """Triangles of a body from its centre of mass, and their normals, see `hull_surface`.

        A body in the plane is as deep as the box around it.

        Args:
            block: Its number, from 0.

        Returns:
            Shapes [triangle, 3, 3] and [triangle, 3]; None of boxes.
        """
        if self.outline is None:
            return None
        outline = self.outline.reshape(-1, *self.outline.shape[-2:])[block]
        if not self.spatial:
            half = np.array([0.0, 0.5 * self.sizes[block, 1], 0.0])
            outline = np.concatenate([outline - half, outline + half])
        return hull_surface(outline)

    def _place(self, arms: Array) -> Array:
        shape = (*self.position.shape[:2], arms.shape[-2], 3)
        seen = rotate(self.attitude[:, :, None], np.broadcast_to(arms, shape))
        return np.asarray(seen + self.position[:, :, None])


def last_move(rotation: Array) -> int:
    """The first sample from which on no block turns any more.

    Args:
        rotation: Shape [block, sample], in any unit.
    """
    moving = np.flatnonzero(np.any(rotation != rotation[:, -1:], axis=0))
    return int(moving[-1]) + 1 if len(moving) else 0


def scene_motion(run: CaseRun, lane: int, interval: float) -> SceneMotion:
    """The motion of one lane of a run, run again.

    Args:
        run: The run.
        lane: Number of the lane, from 0.
        interval: Time between samples [s].

    Raises:
        InputError: There is no such lane, or its samples would be too many.
    """
    case = sampled_by(run.case, interval)
    response = run_lane(dataclasses.replace(run, case=case), lane)
    if run.lane_set.lanes.assembly is not None:
        return _assembly_motion(run, case, lane, response)
    lanes = as_stacks(run.lane_set.lanes.take(np.array([lane])))
    spatial = run.lane_set.lanes.spatial
    shape = (lanes.block_count, len(response.times))
    fields = {name: np.reshape(response[name], shape) for name in _histories(response)}
    base = base_places(run.lane_set.motions, lane, response.times)
    nothing = np.zeros(shape)
    place = np.stack([fields["x"], fields.get("y", nothing), fields["z"]], axis=-1) + base
    if spatial:
        attitude = np.stack([fields[f"attitude_{part}"] for part in "xyzw"], axis=-1)
    else:
        # Clockwise in the plane, towards +x: about +y.
        attitude = quaternion(np.stack([nothing, fields["rotation"], nothing], axis=-1))
    sizes = np.stack([lanes.width[0], lanes.depth[0], lanes.height[0]], axis=-1)
    ratio = _ratio(fields["rotation"], lanes)
    if lanes.hold is not None and lanes.hold.strip is not None:
        sizes, place, attitude, ratio = _two_bodies(lanes, fields["rotation"], base)
    outline = None
    if lanes.body is not None:
        outline = lanes.body.outline(lanes.height[:, 0])[0]
    elif lanes.profiles is not None:
        outline = lanes.profiles.outlines()[0]
    if outline is not None and not spatial:
        outline = np.insert(outline, 1, 0.0, axis=-1)
    parts: tuple[Part, ...] = ()
    if run.lane_set.lanes.hold is not None:
        pose = lane_pose(response, 0)
        alone = run.lane_set.lanes.take(np.array([lane]))
        parts = scene_parts(alone, response.times, pose, first_break(response, 0))
    ground = run.lane_set.ground
    return SceneMotion(
        name=_name(run, case, lane, response),
        outcome=_outcome(response),
        spatial=spatial,
        times=response.times,
        sizes=sizes,
        position=place,
        attitude=attitude,
        ratio=ratio,
        base=base,
        acceleration=_base_acceleration(run, lane, response.times),
        outline=outline,
        parts=parts,
        ground=None if ground is None else base_places(ground, lane, response.times),
    )


def _name(run: CaseRun, case: Case, lane: int, response: Response) -> str:
    return f"{case.name}, lane {run.lane_set.first + lane}, {response.engine}"


def _outcome(response: Response) -> str:
    return Outcome(int(response["outcome"][0])).name.lower().replace("_", " ")


def _base_acceleration(run: CaseRun, lane: int, times: Array) -> Array:
    """Acceleration of the base [m/s^2], shape [sample, 3]."""
    found, motions = np.zeros((len(times), 3)), run.lane_set.motions
    for axis, motion in zip(motions.axes, motions.components, strict=True):
        found[:, "xyz".index(axis)] = motion.acceleration(times, lane)
    return found


def _assembly_motion(run: CaseRun, case: Case, lane: int, response: Response) -> SceneMotion:
    """The motion of an assembly: blocks that can move first, as histories have them."""
    assert run.lane_set.lanes.assembly is not None
    kind = run.lane_set.lanes.assembly.of(lane)
    order, moving = np.argsort(kind.fixed, kind="stable"), int((~kind.fixed).sum())
    base = base_places(run.lane_set.motions, lane, response.times)
    shape = (kind.count, len(response.times))
    centre, outline = kind.centre[order], (kind.corners - kind.centre[:, None])[order]
    if isinstance(kind, SpatialAssembly):
        attitude = np.broadcast_to([0.0, 0.0, 0.0, 1.0], (*shape, 4)).copy()
        for part, field in enumerate("xyzw"):
            attitude[:moving, :, part] = response[f"attitude_{field}"][0][:moving]
        angle, faces = turned_by(attitude), tuple(kind.faces[block] for block in order)
    else:
        centre, outline = (np.insert(each, 1, 0.0, axis=-1) for each in (centre, outline))
        angle, faces = np.zeros(shape), ()
        angle[:moving] = response["turn"][0][:moving]
        nothing = np.zeros(shape)
        attitude = quaternion(np.stack([nothing, angle, nothing], axis=-1))
    place = np.broadcast_to(centre[:, None], (*shape, SPACE)).copy()
    for axis, field in enumerate("xyz"):
        if field in response.fields:
            place[:moving, :, axis] = response[field][0][:moving]
    sizes = np.ptp(outline, axis=1)
    if not kind.spatial:
        sizes[:, 1] = kind.depth
    ground = run.lane_set.ground
    return SceneMotion(
        name=_name(run, case, lane, response),
        outcome=_outcome(response),
        spatial=kind.spatial,
        times=response.times,
        sizes=sizes,
        position=place + base,
        attitude=attitude,
        ratio=np.degrees(angle),
        base=base,
        acceleration=_base_acceleration(run, lane, response.times),
        outline=outline,
        ground=None if ground is None else base_places(ground, lane, response.times),
        fixed=kind.count - moving,
        floor=kind.ground,
        goes_on=_goes_on(run, response),
        faces=faces,
    )


def turned_by(attitude: Array) -> Array:
    """Angles by which blocks have turned from rest [rad], by their quaternions, shape [..., 4]."""
    sine = np.linalg.norm(attitude[..., :3], axis=-1)
    return np.asarray(2.0 * np.arctan2(sine, np.abs(attitude[..., 3])))


def _goes_on(run: CaseRun, response: Response) -> bool:
    """Whether the lane of a run was followed to its end after its collapse."""
    after = getattr(run.settings, "after_collapse", 0.0)
    return bool(response["collapse_time"][0] + after >= response.times[-1])


def _two_bodies(lanes: Lanes, rotation: Array, base: Array) -> tuple[Array, Array, Array, Array]:
    """Sizes, positions, attitudes and ratios of both bodies of a strip of wall."""
    assert lanes.hold is not None
    assert lanes.hold.strip is not None
    strip = lanes.hold.strip
    places = strip.places(rotation)[0]
    turn = places[..., 2]
    nothing = np.zeros_like(turn)
    heights = np.concatenate([strip.lower, strip.upper])
    sizes = np.stack(np.broadcast_arrays(lanes.width[0], lanes.depth[0], heights), axis=-1)
    return (
        sizes,
        np.stack([places[..., 0], nothing, places[..., 1]], axis=-1) + base,
        quaternion(np.stack([nothing, turn, nothing], axis=-1)),
        np.abs(turn) / lanes.slenderness_angle[0],
    )


def _ratio(rotation: Array, lanes: Lanes) -> Array:
    """Rotations of one lane over slenderness angles, shape [block, sample]."""
    if lanes.body is not None:
        return rotation_ratio(rotation, lanes)
    return np.asarray(rotation / lanes.slenderness_angle[0][:, None])


def _histories(response: Response) -> list[str]:
    """Fields of a one-lane response that have a sample axis."""
    return [name for name in HISTORIES if name in response.fields]


def sampled_by(case: Case, interval: float) -> Case:
    """A case with samples no further apart than an interval [s]."""
    run = case.tables.run
    of_run = run.model_copy(update={"sample_interval": min(interval, min(case.durations))})
    return dataclasses.replace(case, tables=case.tables.model_copy(update={"run": of_run}))


def run_of_folder(folder: pathlib.Path, shapes: Mapping[str, Shape] = NO_SHAPES) -> CaseRun:
    """A run as its folder tells it, for its lanes to be run again; without their results.

    Args:
        folder: What `warprock run -o` wrote: `run.json` and the lane table.
        shapes: What results of each kind say besides, see `run_file.read_facts`.

    Raises:
        InputError: The folder holds no run, or one that cannot be run here.
    """
    facts, source = _facts(folder, shapes), str(folder / PROVENANCE)
    case, lane_set = _case_of(facts["case"])
    engine, tolerance = facts["engine"]["name"], facts.get("tolerance")
    options = RunOptions(precision=facts["precision"], device=facts["device"], tolerance=tolerance)
    require_options(engine, options)
    require_support(case, lane_set, engine)
    count = lane_set.lanes.lane_count
    if facts["lanes"] != count:
        allowed = f"must be {count:,}, the lanes of the case"
        raise InputError(source, "lanes", facts["lanes"], allowed)
    fields = {"status": np.zeros(count)} | _steps(folder / LANE_TABLE, count)
    given = facts["engine"].get("settings", {})
    settings = judged_settings(SETTINGS[engine], "engine.settings", given, source)
    return CaseRun(case, lane_set, Response(engine, fields, np.empty(0)), options, settings, 0.0)


def _case_of(told: Mapping[str, Any]) -> tuple[Case, LaneSet]:
    """The case of a run and its lanes, with the files that it names.

    Args:
        told: What `run.json` says of the case.

    Raises:
        InputError: It is no case, or its files are not there.
    """
    # Of a run of before, which did not say its folder, the file says it where it can be found.
    place = pathlib.Path(told.get("folder") or told["file"])
    folder = place if told.get("folder") else place.parent
    there = place.is_dir() or place.is_file()
    try:
        case = build_case(
            told["name"],
            told["file"],
            folder if there else None,
            told["resolved"],
            frozenset(told.get("overridden", ())),
        )
        return case, expand_lanes(case)
    except InputError as error:
        if there:
            raise
        allowed = f"{error.allowed}; the case is no longer in {place}, from where its files start"
        raise InputError(error.source, error.key, error.got, allowed) from None


def _facts(folder: pathlib.Path, shapes: Mapping[str, Shape]) -> dict[str, Any]:
    """What `run.json` says of a run.

    Raises:
        InputError: It is not there, cannot be read, or tells of something else than a run.
    """
    file = folder / PROVENANCE
    try:
        require_plain(file)
    except OSError:
        allowed = "must be what `warprock run -o DIR` writes"
        raise InputError(str(file), "", Said("nothing readable"), allowed) from None
    facts = read_facts(file, shapes)
    require_shape(facts, RUN, str(file))
    return facts


def _steps(table: pathlib.Path, count: int) -> dict[str, Any]:
    """The time steps that the numbers of the lanes are from, where their errors were estimated.

    Args:
        table: The lane table.
        count: Lanes that it has.
    """
    import pyarrow.parquet as pq

    allowed = "must be the lane table that `warprock run -o DIR` writes"
    try:
        require_plain(table)
        if "time_step_s" not in pq.read_schema(table).names:
            return {}
        column = pq.read_table(table, columns=["time_step_s"])["time_step_s"]
        steps = np.asarray(column.to_numpy(), dtype=np.float64)
    except (OSError, ValueError, TypeError) as error:
        raise InputError(str(table), "", Said("nothing readable"), allowed) from error
    if steps.shape != (count,):
        allowed = f"must have {count:,} rows, the lanes of the case"
        raise InputError(str(table), "", Said(f"{len(steps):,} rows"), allowed)
    if not np.all(steps > 0.0) or not np.all(np.isfinite(steps)):
        row = int(np.argmin((steps > 0.0) & np.isfinite(steps)))
        allowed = f"must be above 0 and finite (row {row})"
        raise InputError(str(table), "time_step_s", float(steps[row]), allowed)
    return {"time_step": steps}
