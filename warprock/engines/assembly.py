"""The engine of assemblies: many blocks with dry joints, velocity-level contact, batched."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from types import ModuleType
from typing import Any, ClassVar, final

import numpy as np
import numpy.typing as npt

from warprock.engines.assembly_packs import (
    block_columns,
    falls_by,
    graph_of,
    joint_columns,
    joints_moved,
    pack_up,
    room_for,
    sorts_of,
)
from warprock.engines.base import AbstractEngine
from warprock.engines.decoding import lane_fields, respond, rest_start_times, time_or_nan
from warprock.engines.launching import NEVER, Form, Found, Kernel, launch
from warprock.kernels import assembly
from warprock.kernels.instance import kernel_module
from warprock.model.assembly import Assemblies
from warprock.model.assembly import Assembly as Laid
from warprock.model.lanes import Lanes
from warprock.model.motion import GroundMotions
from warprock.model.response import JointState, Response, SampleTimes, Status, take_lanes
from warprock.model.scene import SceneKind
from warprock.settings.engines import AssemblySettings
from warprock.units import GRAVITY

WIDEST = ((100, 32), (400, 16), (1200, 8))
"""Lanes of a pack by the joints that it has room for, so that what the sweeps read stays in the
cache of a core; of larger ones `NARROWEST`."""
NARROWEST = 4

SEVERAL, ALIKE = 8, 6
"""Lanes, and lanes of one sort on average, from which on they run in packs. A pack of one lane
takes eight times as long as the lane alone; of few lanes another kernel would take longer to
compile."""

GAINED_SHARE = 0.1
"""Energy gained, over that which lets the lightest block fall, above which a lane is unstable, if
the lane gained more than its base supplied, too."""


@final
@dataclasses.dataclass(frozen=True)
class Assembly(AbstractEngine):
    """Many blocks with dry joints: Coulomb friction, plastic impacts, conjugate gradients.

    Steps of one length at the level of velocities (Moreau and Jean), first order in the step.
    Contacts are the two ends of what the edges of a joint share, in every step anew; so blocks may
    slide along one another and turn by any angle, but nothing else of them meets. What is fixed
    goes on beyond its joints. A step is solved once a sweep changes nothing any more; a lane of
    which a step needs more sweeps than the settings allow ends there (ITERATION_LIMIT).

    A lane ends, too, once it has collapsed (outcome OVERTURNED): the centre of a block is lower
    than at the start by half of the longest joint of the block, or a block has turned by a right
    angle. It is at rest while no joint gapes and no corner moves. A lane that gained more energy
    than its base supplied, or whose blocks went through one another, has the status UNSTABLE; one
    of which a corner came below an edge from its side has OUTSIDE_MODEL: other contacts than those
    of the joints would have met it there.
    """

    name: ClassVar[str] = "assembly"
    settings_type = AssemblySettings
    order: ClassVar[int | None] = 1
    assemblies: ClassVar[bool] = True

    @classmethod
    def declines(cls, scene: SceneKind) -> str | None:
        """It runs no single blocks and no stacks, which others run faster."""
        if scene.assembly:
            return None
        return f"{cls.name} runs assemblies of many blocks, and the case has no [assembly]"

    def kernel_of(self, scene: SceneKind | Lanes) -> Kernel:
        """The kernel that runs a scene: the more joints, the fewer lanes a thread."""
        if isinstance(scene, Lanes):
            contacts = 2 * _of(scene).most_joints
        else:
            contacts = scene.contact_point_count
        joints = room_for(contacts // 2)
        widest = next((width for most, width in WIDEST if joints <= most), NARROWEST)
        packed = self.target.kernel_form is Form.PACKED and not _are_unlike(scene)
        lanes = widest if packed else 1
        return Kernel(assembly, "assembly_run", lanes=lanes, points=2 * joints + 1)

    def module_of(self, lanes: Lanes, motions: GroundMotions) -> ModuleType:
        """The instance of that kernel's file for lanes and motions."""
        kernel = self.kernel_of(lanes)
        module: ModuleType = kernel_module(
            kernel.file,
            precision=self.target.precision,
            motion=motions.kind.value,
            blocks=room_for(_of(lanes).most_parts),
            lanes=kernel.lanes,
            points=kernel.points,
        )
        return module

    def alike_order(self, lanes: Lanes, motions: GroundMotions) -> npt.NDArray[np.intp] | None:
        """By how hard their bases pull: lanes that move alike need as many sweeps."""
        pull = motions.components[0].strongest_pull()
        return np.asarray(np.lexsort((pull, sorts_of(_of(lanes)))))

    def inputs(
        self, module: Any, lanes: Lanes, motions: GroundMotions, times: SampleTimes
    ) -> dict[str, Any]:
        """What the kernel takes, of lanes in packs; see `AbstractEngine.inputs`."""
        knobs, own = module.Knobs(), _of(lanes)
        knobs.time_step = self.settings.time_step
        knobs.gravity = GRAVITY
        knobs.settled = self.settings.settled * GRAVITY * self.settings.time_step
        knobs.sweeps = self.settings.iterations
        joints = module.POINTS // 2
        return {
            "blocks": block_columns(own, module.BLOCKS),
            "joints": joint_columns(own, joints),
            "graph": graph_of(own, module.LANES, joints),
            "knobs": knobs,
        }

    def run(self, lanes: Lanes, motions: GroundMotions, times: SampleTimes) -> Response:
        """Runs a batch of lanes on the calling thread; see `AbstractEngine.run`."""
        order, where = pack_up(_of(lanes), self.kernel_of(lanes).lanes)
        packed, moves = lanes.take(order), motions.take(order)
        module = self.module_of(packed, moves)
        inputs = self.inputs(module, packed, moves, times)
        found = launch(module, self.target, moves, times, **inputs)
        fields = dict(self.fields(packed, moves, times, found)) | _histories(packed, found)
        return take_lanes(respond(self.name, packed, fields, times), where)

    def fields(
        self, lanes: Lanes, motions: GroundMotions, times: SampleTimes, found: Found
    ) -> Mapping[str, npt.NDArray[Any]]:
        """Lane fields of a response; see `AbstractEngine.fields`."""
        rows, own = found.lanes, _of(lanes)
        assert found.contacts is not None
        joints = joints_moved(own, found.contacts)
        state = JointState.OPENED * joints.opened + JointState.SLID * joints.slid
        rest_time = rest_start_times(rows, times.times[-1] - 0.5 * self.settings.time_step)
        bad = [
            (_unstable(own, rows), Status.UNSTABLE),
            (rows["astray"] > 0, Status.OUTSIDE_MODEL),
        ]
        blocks = np.arange(found.blocks.shape[1]) < _count(own)[:, None]
        moved, last = (np.where(blocks, found.blocks[name], 0.0) for name in ("moved", "last"))
        return lane_fields(rows, rest_time, bad) | {
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
            "collapse_load": _loads(motions, rows),
            "joint_state": state[:, : own.most_joints],
            "solver_residual": rows["residual"],
        }


def _are_unlike(scene: SceneKind | Lanes) -> bool:
    """Whether most of several lanes would have a pack of their own."""
    if not isinstance(scene, Lanes) or scene.lane_count < SEVERAL:
        return False
    return len(np.unique(sorts_of(_of(scene)))) * ALIKE > scene.lane_count


def _of(lanes: Lanes) -> Assemblies:
    assert lanes.assembly is not None
    return lanes.assembly


def _loads(motions: GroundMotions, rows: npt.NDArray[Any]) -> npt.NDArray[np.float64]:
    """Acceleration of the base / g when the blocks last were still before a collapse, [lane]."""
    found = np.full(len(rows), np.nan)
    for lane in np.flatnonzero(rows["collapse_time"] < NEVER):
        at = np.asarray([rows["still"][lane]], dtype=np.float64)
        found[lane] = abs(float(motions.components[0].acceleration(at, int(lane))[0])) / GRAVITY
    return found


def _count(own: Assemblies) -> npt.NDArray[np.intp]:
    return np.array([kind.count for kind in own.kinds])[own.lane]


def _unstable(own: Assemblies, rows: npt.NDArray[Any]) -> npt.NDArray[np.bool_]:
    """Where contacts gave energy, or let blocks through one another, shape [lane]."""
    lightest = np.array([_least_fall(kind) for kind in own.kinds])[own.lane]
    shortest = np.array([kind.joints.lengths.min() for kind in own.kinds])[own.lane]
    gained = np.maximum(-rows["loss"], rows["returned"])
    made = (gained > rows["supplied"]) & (gained > GAINED_SHARE * lightest)
    return np.asarray(made | (rows["deepest"] > 0.5 * shortest))


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
    taken, there = np.maximum(places, 0)[..., None], (places >= 0)[..., None]

    def of(values: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        return np.where(there, np.take_along_axis(values, taken, axis=1), 0.0)

    turn = np.clip(-of(found.history), -0.5 * np.pi, 0.5 * np.pi)
    fields = {"rotation": np.abs(turn).max(axis=1, keepdims=True)}
    if found.places is not None:
        x, z = (of(found.places[..., axis]) for axis in (0, 1))
        fields |= {"x": x, "z": z, "turn": turn}
    return fields
