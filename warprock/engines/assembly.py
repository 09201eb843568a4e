"""The engine of assemblies: many blocks with dry joints, velocity-level contact, batched."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from types import ModuleType
from typing import Any, ClassVar, cast

import numpy as np
import numpy.typing as npt

from warprock.engines import assembly_solids
from warprock.engines.assembly_packs import (
    LARGE,
    WIDEST,
    around_rows,
    block_columns,
    body_rows,
    corner_rows,
    falls_by,
    graph_of,
    joint_columns,
    joints_moved,
    least_reach,
    pack_up,
    room_for,
    room_for_pairs,
    side_rows,
    sorts_of,
    tree_of,
)
from warprock.engines.base import KernelEngine
from warprock.engines.decoding import (
    collapse_loads,
    lane_fields,
    respond,
    rest_start_times,
    time_or_nan,
)
from warprock.engines.launching import NEVER, Form, Found, Kernel, launch
from warprock.errors import InputError
from warprock.kernels import assembly, assembly_space
from warprock.kernels.lane.modes import OVERTURNED, SLID_OFF
from warprock.kernels.launch.instance import LANE_WIDTH, kernel_module
from warprock.model.assembly import Assemblies
from warprock.model.assembly import Assembly as Laid
from warprock.model.lanes import Lanes
from warprock.model.motion import GroundMotions
from warprock.model.pose import product
from warprock.model.response import (
    JointState,
    Response,
    SampleTimes,
    Status,
    join_responses,
    take_lanes,
)
from warprock.model.scene import SceneKind
from warprock.settings.engines import AssemblySettings
from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]

MORE_SWEEPS = 8
"""Times the most sweeps of a step that a large lane may take: forces go through more blocks."""

CREEP = 0.1
"""Speed up to which a corner counts as still, over gravity times step, as in
kernels/contact/parting.py."""

SEVERAL, ALIKE = 8, 6
"""Lanes, and lanes of one sort on average, from which on they run in packs. A pack of one lane
takes eight times as long as the lane alone; of few lanes another kernel would take longer to
compile."""

GAINED_SHARE = 0.1
"""Energy gained, over that which lets the lightest block fall, above which a lane is unstable, if
the lane gained more than its base supplied, too."""


SUNK_SHARE = 0.1
"""Depth of a corner in another block, over the half diagonal of the smallest block, above which a
lane is unstable: heaps have some thousandths."""


@dataclasses.dataclass(frozen=True)
class Assembly(KernelEngine):
    """Many blocks with dry joints: Coulomb friction, plastic impacts, accelerated sweeps.

    Steps of one length at the level of velocities (Moreau and Jean), first order in the step.
    Contacts are the two ends of what the edges of a joint share, in every step anew; and where
    blocks come near one another that no joint connects, or that have left it, corners and edges of
    their outlines, found anew, too. So blocks may slide along one another, turn by any angle, fall
    and lie on one another as a heap. The ground is level and goes on to both sides: at the level of
    the lowest blocks if these stand on something fixed there, else at that of the lowest corner.
    A step is solved once a sweep changes nothing any more; a lane of which a step needs more sweeps
    than the settings allow ends there (ITERATION_LIMIT), and one with more pairs of blocks side by
    side than there is room for, too (EVENT_LIMIT).

    A lane has collapsed (outcome OVERTURNED) once the centre of a block is lower than at the start
    by half of the longest joint of the block, or a block has turned by a right angle. It has slid
    off (SLID_OFF), which is a collapse, too, once a block has slid along another or the ground by
    more than its longest joint; in space, so far that its largest joint lies nowhere over where it
    was. It goes on for `after_collapse`. It is at rest while no
    corner moves and no joint gapes, but for blocks that lie or lean on others. A lane that gained
    more energy than its base supplied, or whose blocks went through one another, has the status
    UNSTABLE.
    """

    name: ClassVar[str] = "assembly"
    settings_type: ClassVar[type[Any]] = AssemblySettings
    order: ClassVar[int | None] = 1
    assemblies: ClassVar[bool] = True
    spatial: ClassVar[bool] = True
    solids: ClassVar[bool] = True
    on_springs: ClassVar[bool] = False
    """Whether contacts are springs."""

    @classmethod
    def declines(cls, scene: SceneKind) -> str | None:
        """Why it does not run a scene: others run single blocks and stacks faster."""
        if scene.bonded and not scene.spatial and scene.contact_point_count > 2 * LARGE:
            return (
                f"{cls.name} runs bonded joints (assembly.joint_tensile_strength) in assemblies of "
                f"up to {LARGE} joints, and the case has {scene.contact_point_count // 2}"
            )
        if scene.assembly:
            return None
        return f"{cls.name} runs assemblies of many blocks, and the case has no [assembly]"

    def kernel_of(self, scene: SceneKind | Lanes) -> Kernel:
        """The kernel that runs a scene: the more joints, the fewer lanes a thread.

        Of lanes of which only some are large it is that of the others.
        """
        if isinstance(scene, Lanes):
            large, joints = bool(_large(scene).all()), _of(scene).most_joints
            bonded = _of(scene).bonded
            trees = any(len(tree_of(kind).order) for kind in _of(scene).kinds)
        else:
            joints = scene.contact_point_count // 2
            large, bonded, trees = joints > LARGE, scene.bonded, False
        packed = self.target.kernel_form is Form.PACKED
        if scene.spatial:
            return Kernel(assembly_space, "assembly_run", bonds=bonded)
        if large and not self.on_springs:
            return Kernel(assembly, "team_run", lanes=LANE_WIDTH if packed else 1)
        room = room_for(min(joints, LARGE))
        widest = next(width for most, width in WIDEST if room <= room_for(most))
        lanes = widest if packed and not _are_unlike(scene) else 1
        return Kernel(
            assembly,
            "assembly_run",
            lanes=lanes,
            points=2 * room + 1,
            springs=self.on_springs,
            bonds=bonded and not self.on_springs,
            trees=trees and not self.on_springs,
        )

    def module_of(self, lanes: Lanes, motions: GroundMotions) -> ModuleType:
        """The instance of that kernel's file for lanes and motions."""
        kernel = self.kernel_of(lanes)
        if lanes.spatial:
            own = {"precision": self.target.precision, "motion": motions.kind.value, "lanes": 1}
            return cast(ModuleType, kernel_module(kernel.file, **own, bonds=kernel.bonds))
        module: ModuleType = kernel_module(
            kernel.file,
            precision=self.target.precision,
            motion=motions.kind.value,
            # Every block has a joint.
            blocks=room_for(min(_of(lanes).most_parts, LARGE + 1) + 1),
            lanes=kernel.lanes,
            points=kernel.points,
            springs=kernel.springs,
            bonds=kernel.bonds,
            trees=kernel.trees,
        )
        return module

    def warm_up(self, lanes: Lanes, motions: GroundMotions) -> None:
        """Compiles or loads the kernels of small lanes and of large ones."""
        if lanes.spatial:
            super().warm_up(lanes, motions)
            return
        large = _large(lanes)
        for some in (np.flatnonzero(~large), np.flatnonzero(large)):
            if len(some):
                super().warm_up(lanes.take(some), motions.take(some))

    def shares(self, lanes: Lanes) -> bool:
        """Whether half of the lanes or more are large ones."""
        if lanes.spatial:
            return False
        return 2 * int(_large(lanes).sum()) >= lanes.lane_count

    def alike_order(self, lanes: Lanes, motions: GroundMotions) -> npt.NDArray[np.intp] | None:
        """By how hard their bases pull: lanes that move alike need as many sweeps."""
        if lanes.spatial:
            return None
        pull = motions.components[0].largest_acceleration()
        return np.asarray(np.lexsort((pull, sorts_of(_of(lanes)))))

    def inputs(
        self, module: Any, lanes: Lanes, motions: GroundMotions, times: SampleTimes
    ) -> dict[str, Any]:
        """What the kernel takes, of lanes in packs; see `KernelEngine.inputs`."""
        if lanes.spatial:
            return self._spatial_inputs(module, lanes, self.longest_step(lanes, motions))
        own, joints, steps = _of(lanes), module.POINTS // 2, self.longest_step(lanes, motions)
        knobs = self._pace(module, steps[:: module.LANES])
        blocks, touching = self.columns(lanes, module.BLOCKS, joints)
        calm = np.repeat(self.calm(lanes, steps)[:, None], module.BLOCKS, axis=1)
        return {
            "blocks": blocks | {"calm": calm},
            "joints": touching,
            "laid": self._laid(module, own, joints, module.BLOCKS),
            "knobs": knobs,
        }

    def _spatial_inputs(self, module: Any, lanes: Lanes, steps: Array) -> dict[str, Any]:
        """What the kernel in space takes."""
        import warp as wp

        own, device, count = _of(lanes), self.target.device, lanes.lane_count
        laid, kept = module.Laid(), module.Kept()
        types = {name: field.type.dtype for name, field in module.Laid.vars.items()}
        rows = assembly_solids.rows_of(own, types)
        for name, values in rows.items():
            setattr(laid, name, wp.array(values, dtype=types[name], device=device))
        rooms = self._rooms(own)
        for name, room in rooms.items():
            setattr(laid, name, wp.zeros((count, room), dtype=types[name], device=device))
        for name in ("couple", "row"):
            setattr(laid, name, wp.zeros(count, dtype=types[name], device=device))
        for name, field in module.Kept.vars.items():
            values = wp.zeros((count, own.most_parts), dtype=field.type.dtype, device=device)
            setattr(kept, name, values)
        columns = assembly_solids.block_columns(own)
        calm = np.repeat(self.calm(lanes, steps)[:, None], own.most_parts, axis=1)
        return {
            "blocks": columns | {"calm": calm},
            "joints": {"friction": np.zeros((count, own.most_joints))},
            "laid": laid,
            "kept": kept,
            "knobs": self._pace(module, steps),
        }

    def _rooms(self, own: Assemblies) -> dict[str, int]:
        """How many of each of the arrays in which a lane in space keeps what it finds it has."""
        contacts = 2 * assembly_solids.room_for_contacts(own)
        rows, packs = assembly_solids.room_for_rows(own), assembly_solids.room_for_packs(own)
        packing = kernel_module("assembly_space/packing", precision=self.target.precision)
        return {
            "hefts": own.most_parts + 1,
            "moves": own.most_parts + 1,
            "spots": assembly_solids.most_corners(own),
            "joined": own.most_joints,
            "pairs": 2 * assembly_solids.room_for_pairs(own),
            "contacts": contacts,
            "impulses": contacts,
            "marks": contacts,
            "packs": packs,
            "sides": packing.WIDTH * packs,
            "couples": packing.WIDTH * packing.COUPLE * packs,
            "rows": packing.NUMBERS * rows,
            "order": packing.WIDTH * rows,
            "colours": own.most_parts + 1,
            "open": packing.COLOURS + 1,
            "weighted": own.most_parts + 2,
            "scratch": 4 * assembly_solids.MOST_CORNERS,
        }

    def lane_bytes(self, lanes: Lanes, motions: GroundMotions) -> int:
        """Memory that a lane in space takes while it runs [bytes]; see `AbstractEngine`."""
        if not lanes.spatial:
            return 0
        import warp as wp

        fields = self.module_of(lanes, motions).Laid.vars
        rooms = self._rooms(_of(lanes)).items()
        size_of = wp.types.type_size_in_bytes
        return sum(room * size_of(fields[name].type.dtype) for name, room in rooms)

    def _pace(self, module: Any, steps: Array) -> Any:
        """The kernel's settings with the time step of each pack."""
        import warp as wp

        knobs = self.knobs(module)
        knobs.time_steps = wp.array(steps, dtype=module.real, device=self.target.device)
        return knobs

    def _laid(self, module: Any, own: Assemblies, joints: int, blocks: int) -> Any:
        """The struct of where blocks are and may touch, of whole packs; see kernels/assembly."""
        import warp as wp

        device, lanes, pairs = self.target.device, len(own.lane), room_for_pairs(own)
        meeting = {name: field.type.dtype for name, field in module.Laid.vars.items()}
        rows = {
            "graph": graph_of(own, module.LANES, joints, blocks),
            "around": around_rows(own, meeting["around"]),
            "corners": corner_rows(own, meeting["corners"]),
            "sides": side_rows(own, meeting["sides"], joints),
            "bodies": body_rows(own, meeting["bodies"]),
        }
        laid = module.Laid()
        laid.spare = wp.zeros(lanes, dtype=int, device=device)
        for name, values in rows.items():
            setattr(laid, name, wp.array(values, dtype=meeting[name], device=device))
        for name, contacts in (("pairs", 1), ("free", 2), ("touching", 1)):
            shape = (lanes, 2 * contacts * pairs)
            setattr(laid, name, wp.empty(shape, dtype=meeting[name], device=device))
        return laid

    def knobs(self, module: Any) -> Any:
        """Settings as the kernel takes them, but for time steps."""
        knobs = module.Knobs()
        knobs.gravity = GRAVITY
        knobs.settled = self.settings.settled * GRAVITY * self.settings.time_step
        knobs.after_collapse = self.after_collapse
        knobs.sweeps = self.settings.iterations
        return knobs

    def columns(
        self, lanes: Lanes, blocks: int, joints: int
    ) -> tuple[dict[str, Array], dict[str, Array]]:
        """Fields of the structs of blocks and joints, [lane, block] and [lane, joint] each."""
        return block_columns(_of(lanes), blocks), joint_columns(_of(lanes), joints)

    @property
    def after_collapse(self) -> float:
        """How long a lane goes on after its collapse [s]."""
        return float(self.settings.after_collapse)

    def calm(self, lanes: Lanes, steps: Array) -> Array:
        """Speed up to which a corner counts as still [m/s], shape [lane]."""
        return CREEP * GRAVITY * steps

    def run(self, lanes: Lanes, motions: GroundMotions, times: SampleTimes) -> Response:
        """Runs a batch of lanes on the calling thread, large ones with others of its team.

        See `AbstractEngine.run`.
        """
        if lanes.spatial:
            module = self.module_of(lanes, motions)
            inputs = self.inputs(module, lanes, motions, times)
            found = launch(module, self.target, motions, times, **inputs)
            fields = dict(self.fields(lanes, motions, times, found))
            return respond(self.name, lanes, fields | _histories(lanes, found), times)
        large = _large(lanes)
        if self.on_springs and large.any():
            lane = int(np.argmax(large))
            allowed = f"must be at most {LARGE:,} joints on springs"
            raise InputError(self.name, f"lane {lane}", _of(lanes).of(lane).joints.count, allowed)
        small = np.flatnonzero(~large)
        groups = [small] if len(small) else []
        groups += [np.array([lane]) for lane in np.flatnonzero(large)]
        parts = [
            (self._run_large if large[own[0]] else self._run_packed)(
                lanes.take(own), motions.take(own), times
            )
            for own in groups
        ]
        together = parts[0] if len(parts) == 1 else join_responses(parts)
        return take_lanes(together, np.argsort(np.concatenate(groups)))

    def _run_packed(self, lanes: Lanes, motions: GroundMotions, times: SampleTimes) -> Response:
        steps = self.longest_step(lanes, motions)
        order, where = pack_up(_of(lanes), steps, self.kernel_of(lanes).lanes)
        packed, moves = lanes.take(order), motions.take(order)
        module = self.module_of(packed, moves)
        inputs = self.inputs(module, packed, moves, times)
        spare = np.ones(len(order), dtype=np.int32)
        spare[where] = 0
        inputs["laid"].spare.assign(spare)
        found = launch(module, self.target, moves, times, **inputs)
        fields = dict(self.fields(packed, moves, times, found)) | _histories(packed, found)
        return take_lanes(respond(self.name, packed, fields, times), where)

    def _run_large(self, lane: Lanes, motions: GroundMotions, times: SampleTimes) -> Response:
        from warprock.engines.assembly_team import Given, run_team

        own, module = _of(lane), self.module_of(lane, motions)
        kind, steps = own.of(0), self.longest_step(lane, motions)
        own = Assemblies((kind,), np.zeros(1, dtype=np.intp))
        knobs = self._pace(module, steps)
        knobs.sweeps *= MORE_SWEEPS
        blocks = block_columns(own, kind.count)
        blocks["calm"] = np.repeat(self.calm(lane, steps)[:, None], kind.count, axis=1)
        given = Given(
            columns=(blocks, joint_columns(own, kind.joints.count)),
            laid=self._laid(module, own, kind.joints.count, kind.count),
            knobs=knobs,
        )
        found = run_team(module, self.target, kind, given, motions, times)
        fields = dict(self.fields(lane, motions, times, found)) | _histories(lane, found)
        return respond(self.name, lane, fields, times)

    def fields(
        self, lanes: Lanes, motions: GroundMotions, times: SampleTimes, found: Found
    ) -> Mapping[str, npt.NDArray[Any]]:
        """Lane fields of a response; see `KernelEngine.fields`."""
        rows, own = found.lanes, _of(lanes)
        assert found.contacts is not None
        joints = joints_moved(own, found.contacts)
        state = np.zeros((len(rows), max(joints.opened.shape[1], own.most_joints)), dtype=np.int64)
        state[:, : joints.opened.shape[1]] = (
            JointState.OPENED * joints.opened + JointState.SLID * joints.slid
        )
        end = times.times[-1] - 0.5 * self.longest_step(lanes, motions)
        # What has fallen rests, too, if its lane went on to the end.
        goes_on = rows["collapse_time"] + self.after_collapse >= times.times[-1]
        fallen = np.isin(rows["mode"], (OVERTURNED, SLID_OFF)) & goes_on & (rows["moved"] < end)
        rest_time = np.where(fallen, rows["moved"], rest_start_times(rows, end))
        bad = [
            (_gained(own, rows), Status.UNSTABLE),
            (rows["astray"] > 0, Status.OUTSIDE_MODEL),
            (_sunk(own, rows), Status.UNSTABLE),
        ]
        blocks = np.arange(found.blocks.shape[1]) < _count(own)[:, None]
        moved, last = (np.where(blocks, found.blocks[name], 0.0) for name in ("moved", "last"))
        bonds = {}
        if found.bonds is not None and found.breaks is not None:
            whole = found.bonds[:, ::2] > 0
            whole = np.pad(whole, ((0, 0), (0, state.shape[1] - whole.shape[1])))
            state = state + JointState.BROKEN * (~whole & _bonded(own, state.shape[1]))
            bonds = {
                "broken_joints": found.breaks["count"],
                "joint_break_time": time_or_nan(found.breaks["first"]),
            }
        return (
            lane_fields(rows, rest_time, bad)
            | bonds
            | {
                "peak_rotation": rows["peak"][:, None],
                "peak_time": rows["peak_time"][:, None],
                "residual_slide": np.abs(joints.last).max(axis=1, initial=0.0)[:, None],
                "peak_slide": joints.slide.max(axis=1, initial=0.0)[:, None],
                "peak_displacement": moved.max(axis=1),
                "residual_displacement": last.max(axis=1),
                "peak_opening": joints.opening.max(axis=(1, 2), initial=0.0),
                "opened_joints": joints.opened.sum(axis=1),
                "slid_joints": joints.slid.sum(axis=1),
                "collapse_time": time_or_nan(rows["collapse_time"]),
                "collapse_load": collapse_loads(
                    motions, rows["still"], rows["collapse_time"] < NEVER
                ),
                "joint_state": state[:, : own.most_joints],
                "solver_residual": rows["residual"],
            }
        )


def _are_unlike(scene: SceneKind | Lanes) -> bool:
    """Whether most of several lanes would have a pack of their own."""
    if not isinstance(scene, Lanes) or scene.lane_count < SEVERAL:
        return False
    return len(np.unique(sorts_of(_of(scene)))) * ALIKE > scene.lane_count


def _of(lanes: Lanes) -> Assemblies:
    assert lanes.assembly is not None
    return lanes.assembly


def _large(lanes: Lanes) -> npt.NDArray[np.bool_]:
    """Which lanes have more than `LARGE` joints, shape [lane]."""
    own = _of(lanes)
    return np.array([kind.joints.count > LARGE for kind in own.kinds])[own.lane]


def _bonded(own: Assemblies, room: int) -> npt.NDArray[np.bool_]:
    """Which joints were bonded at the start, shape [lane, joint]."""
    rows = np.zeros((len(own.kinds), room), dtype=bool)
    for row, kind in zip(rows, own.kinds, strict=True):
        row[: kind.joints.count] = kind.joints.tension > 0.0
    return np.asarray(rows[own.lane])


def _count(own: Assemblies) -> npt.NDArray[np.intp]:
    return np.array([kind.count for kind in own.kinds])[own.lane]


def _gained(own: Assemblies, rows: npt.NDArray[Any]) -> npt.NDArray[np.bool_]:
    """Where contacts gave energy, shape [lane]."""
    lightest = np.array([_least_fall(kind) for kind in own.kinds])[own.lane]
    gained = np.maximum(-rows["loss"], rows["returned"])
    return np.asarray((gained > rows["supplied"]) & (gained > GAINED_SHARE * lightest))


def _sunk(own: Assemblies, rows: npt.NDArray[Any]) -> npt.NDArray[np.bool_]:
    """Where contacts let blocks through one another, shape [lane]."""
    smallest = np.array([least_reach(kind) for kind in own.kinds])[own.lane]
    return np.asarray(rows["deepest"] > SUNK_SHARE * smallest)


def _least_fall(kind: Laid) -> float:
    """The least energy that is set free where one block falls [J]."""
    falls = GRAVITY * kind.mass * falls_by(kind)
    return float(falls[~kind.fixed].min())


def _histories(lanes: Lanes, found: Found) -> dict[str, npt.NDArray[Any]]:
    """Histories: the largest rotation of any block, and where all that can move are."""
    if found.history is None:
        return {}
    own = _of(lanes)
    moves = np.full((len(own.kinds), own.most_blocks), -1)
    for row, kind in zip(moves, own.kinds, strict=True):
        free = np.flatnonzero(~kind.fixed)
        row[: len(free)] = free
    places = moves[own.lane]
    taken, there = np.maximum(places, 0), places >= 0

    def of(values: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        every = (..., *(None for _ in values.shape[2:]))
        chosen = np.take_along_axis(values, taken[every], axis=1)
        return np.where(there[every], chosen, 0.0)

    if lanes.spatial:
        # How blocks have turned since the start.
        starts = of(assembly_solids.turns_back(own))
        attitude = product(of(found.history), starts[:, :, None])
        turn = 2.0 * np.arctan2(
            np.linalg.norm(attitude[..., :3], axis=-1), np.abs(attitude[..., 3])
        )
    else:
        turn = -of(found.history)
    most = np.clip(np.abs(turn), 0.0, 0.5 * np.pi)
    fields = {"rotation": most.max(axis=1, keepdims=True)}
    if found.places is not None:
        axes = "xyz" if lanes.spatial else "xz"
        fields |= {axis: of(found.places[..., k]) for k, axis in enumerate(axes)}
        if lanes.spatial:
            fields |= {f"attitude_{part}": attitude[..., k] for k, part in enumerate("xyzw")}
        else:
            fields["turn"] = turn
    return fields
