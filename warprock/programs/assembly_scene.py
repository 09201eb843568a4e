"""Assemblies as programs of others are given them, and what their poses show.

Every block is the hull of its corners, a box where it is one along its own axes; in the plane a
prism, its polygon over the depth of the assembly. Those that are fixed move with the base. Blocks
that share a joint touch, no others: as in our engines. Everything is read off poses at frames, by
the rules of `assembly`: a block has fallen once its centre is lower by half of its longest joint,
or it has turned by a right angle.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from warprock.errors import DeclinedError
from warprock.model.assembly import Assembly
from warprock.model.lanes import Lanes
from warprock.model.response import (
    ASSEMBLY_FIELDS,
    INTEGER_FIELDS,
    LANE_FIELDS,
    Outcome,
    Response,
    SampleTimes,
    Status,
)
from warprock.model.solids import SpatialAssembly
from warprock.model.turning import inverse, principal_axes, rotate
from warprock.programs.scene import PeerRun, PeerScene, frames_per_sample
from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]

MOVES = 1e-3
"""Rotation from which a block counts as having left its joints, over a radian, and displacement
over the size of the assembly: contacts of these programs give by less."""

SQUARE = 1e-9
"""Distance of a corner from that of a box, over its largest half size, up to which it is one."""

BOX_CORNERS = 8

UPRIGHT = np.array([0.0, 0.0, 0.0, 1.0])
"""The quaternion that turns nothing."""


class Solid(NamedTuple):
    """A block as a program is given it, in the axes of its inertia.

    Attributes:
        mass: [kg].
        inertia: About its centre of mass, along its axes [kg m^2].
        place: Centre of mass at the start [m], shape [3].
        attitude: Quaternion (x, y, z, w) of its axes at the start; none in the plane.
        hull: Its corners from the centre, along its axes [m], shape [corner, 3].
        box: Whether it is a box along them.
        fixed: Whether it moves with the base.
    """

    mass: float
    inertia: tuple[float, float, float]
    place: Array
    attitude: Array
    hull: Array
    box: bool
    fixed: bool

    @property
    def half(self) -> tuple[float, float, float]:
        """Half sizes of a box along x, y and z [m]."""
        x, y, z = 0.5 * np.ptp(self.hull, axis=0)
        return float(x), float(y), float(z)


def solids(kind: Assembly) -> list[Solid]:
    """The blocks of an assembly, in their order."""
    one = _solid if isinstance(kind, SpatialAssembly) else _prism
    return [one(kind, block) for block in range(kind.count)]  # type: ignore[arg-type]


def _prism(kind: Assembly, block: int) -> Solid:
    corners = kind.corners[block] - kind.centre[block]
    corners = corners[np.hypot(*(corners - np.roll(corners, -1, axis=0)).T) > 0.0]
    mass, about_y = float(kind.mass[block]), float(kind.mass[block] * kind.gyration[block])
    # Those of a sheet, which turns about y alone.
    other = 0.5 * about_y + mass * kind.depth**2 / 12.0
    ends = [np.insert(corners, 1, side * kind.depth, axis=1) for side in (-0.5, 0.5)]
    hull = np.concatenate(ends)
    place = np.insert(kind.centre[block], 1, 0.0)
    return Solid(
        mass, (other, about_y, other), place, UPRIGHT, hull, _is_box(hull), bool(kind.fixed[block])
    )


def _solid(kind: SpatialAssembly, block: int) -> Solid:
    inertia, attitude = principal_axes(kind.inertia[block])
    corners = kind.corners[block, : kind.corner_count[block]] - kind.centre[block]
    hull = rotate(inverse(attitude), corners)
    x, y, z = map(float, inertia)
    return Solid(
        float(kind.mass[block]), (x, y, z), kind.centre[block], attitude, hull, _is_box(hull),
        bool(kind.fixed[block]),
    )  # fmt: skip


def _is_box(hull: Array) -> bool:
    """Whether corners are those of a box along the axes."""
    half = 0.5 * np.ptp(hull, axis=0)
    near = np.abs(np.abs(hull - hull.mean(axis=0)) - half) <= SQUARE * half.max()
    return len(hull) == BOX_CORNERS and bool(near.all())


def touching(kind: Assembly) -> dict[tuple[int, int], float]:
    """Pairs of blocks that share a joint, and their friction, that of their last joint."""
    pairs = (tuple(sorted(map(int, pair))) for pair in kind.joints.blocks)
    frictions = map(float, kind.joints.friction)
    return {(a, b): friction for (a, b), friction in zip(pairs, frictions, strict=True)}


def one_friction(kind: Assembly) -> float:
    """The friction of all joints.

    Raises:
        DeclinedError: They have several.
    """
    friction = kind.joints.friction
    if np.ptp(friction) > 0.0:
        raise DeclinedError("it needs one friction coefficient for all joints of an assembly")
    return float(friction[0])


def assembly_response(
    name: str,
    lanes: Lanes,
    scenes: Sequence[PeerScene],
    runs: Sequence[PeerRun],
    times: SampleTimes,
) -> Response:
    """The response of a program to assemblies.

    Args:
        name: Its name.
        lanes: The lanes.
        scenes: Their scenes.
        runs: What it answered for each: poses of the blocks that can move.
        times: Sampling of the histories.
    """
    rows = [_lane(*pair, times) for pair in zip(scenes, runs, strict=True)]
    fields: dict[str, npt.NDArray[np.generic]] = {}
    for field in (*LANE_FIELDS, *ASSEMBLY_FIELDS):
        whole = field in INTEGER_FIELDS
        values = [row.get(field, 0 if whole else np.nan) for row in rows]
        fields[field] = np.array(values, np.int64 if whole else np.float64)
    if times.interval is None:
        return Response(name, fields, np.empty(0))
    fields["rotation"] = np.stack([np.asarray(row["history"]) for row in rows])
    return Response(name, fields, times.times)


def _lane(scene: PeerScene, run: PeerRun, times: SampleTimes) -> dict[str, object]:
    """Every field of one lane."""
    kind = scene.assembly
    assert kind is not None
    free, stamps = ~kind.fixed, scene.times
    base = scene.base.displacement(stamps) if scene.base else np.zeros((len(stamps), 3))
    axes = [0, 1, 2] if isinstance(kind, SpatialAssembly) else [0, 2]
    place = (run.position - base[:, None])[..., axes] - kind.centre[free]
    if isinstance(kind, SpatialAssembly):
        sine = np.linalg.norm(run.attitude[..., :3], axis=-1)
        turn = 2.0 * np.arctan2(sine, np.abs(run.attitude[..., 3]))
    else:
        turn = np.unwrap(2.0 * np.arctan2(run.attitude[..., 1], run.attitude[..., 3]), axis=0)
    turn = np.abs(turn)
    falls = 0.5 * kind.longest_joints
    fell = ((place[..., -1] < -falls[free]) | (turn >= 0.5 * np.pi)).any(axis=1)
    fallen = np.flatnonzero(fell)
    last = int(fallen[0]) if len(fallen) else len(stamps) - 1
    far = np.linalg.norm(place, axis=-1)[: last + 1].max(axis=1)
    most = np.minimum(turn[: last + 1].max(axis=1), 0.5 * np.pi)
    moves = np.flatnonzero((most > MOVES) | (far > MOVES * float(kind.size.max())))
    finite = bool(np.isfinite(run.position).all() and np.isfinite(run.attitude).all())
    load = np.nan
    if len(fallen) and scene.base is not None and len(moves):
        at = max(1, min(int(moves[0]), len(stamps) - 2))
        path = base[at - 1 : at + 2, :2]
        gained = np.linalg.norm(path[2] - 2.0 * path[1] + path[0])
        load = float(gained) / scene.frame**2 / GRAVITY
    every, history = frames_per_sample(times), np.full(len(stamps), most[-1])
    history[: last + 1] = most
    return {
        "peak_rotation": float(most.max()),
        "peak_time": float(stamps[int(most.argmax())]),
        "uplift_time": float(stamps[moves[0]]) if len(moves) else np.nan,
        "rest_time": np.nan,
        "outcome": Outcome.OVERTURNED if len(fallen) else Outcome.ROCKING,
        "status": Status.OK if finite else Status.NONFINITE,
        "peak_displacement": float(far.max()),
        "residual_displacement": float(far[-1]),
        "collapse_time": float(stamps[last]) if len(fallen) else np.nan,
        "collapse_load": float(load),
        "step_count": run.step_count,
        "history": history[::every],
    }
