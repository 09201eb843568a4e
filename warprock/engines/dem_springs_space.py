"""Springs of the soft-spring engine under blocks in space, in NumPy: how they lie, rest and swing.

Blocks are [lane, block], lowest first; interface k is the one below block k, told in the axes of
that block, from the middle of its bottom face. `spatial_columns` describes the blocks.
"""

from __future__ import annotations

import dataclasses
from typing import Self, cast

import numpy as np
import numpy.typing as npt

from warprock.engines.blocks import spatial_columns
from warprock.engines.dem_springs import round_frequency
from warprock.model.lanes import Lanes, SpatialLanes, as_stacks
from warprock.model.pose import product, quaternion
from warprock.model.stacking import sum_above
from warprock.model.turning import rotate
from warprock.settings.engines import DemSettings
from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]

EQUILIBRIUM_SWEEPS = 60
"""Iterations that find which points carry; a handful suffices unless the weight is near an edge."""
ENDLESS = 1e9
"""Half width of the ground's face [m]."""
SMALLEST = 1e-3
"""Cosine below which a face seen askew grows no longer, as in the kernel."""


def point_pairs(along: int, across: int) -> Array:
    """Pairs of points -(a, b) and (a, b) of a grid spread evenly over a face from edge to edge.

    Trapezoidal rule: points on an edge stand for half, at a corner for a quarter of the others'
    area. From the middle outwards, so that the pairs on one diagonal come in the order of those on
    the other.

    Args:
        along: Points along the width, >= 2.
        across: Points along the depth, >= 2.

    Returns:
        Rows a and b (-1 to 1), part of the area of each of the two, and kind (0 on an axis, 1 and 2
        on the diagonals), shape [4, pair]; a point in the middle is a pair of two halves.
    """
    rows = []
    for q in range((across + 1) // 2):
        for p in range((along + 1) // 2):
            a = (2 * p + 1 - along % 2) / (along - 1)
            b = (2 * q + 1 - across % 2) / (across - 1)
            ends = (0.5 if a == 1.0 else 1.0) * (0.5 if b == 1.0 else 1.0)
            share = ends / (along - 1) / (across - 1)
            if a == b == 0.0:
                rows.append((a, b, 0.5 * share, 0.0))
            elif a == 0.0 or b == 0.0:
                rows.append((a, b, share, 0.0))
            else:
                rows += [(a, b, share, 1.0), (a, -b, share, 2.0)]
    return np.array(rows).T


@dataclasses.dataclass(frozen=True)
class SpatialSprings:
    """The points of every interface of flat stacks in space.

    Attributes:
        columns: What the blocks are, see `spatial_columns`.
        place: From the middle of the face of the block above [m], shape [lane, block, point, 2].
        area: Area that a point stands for [m^2], shape [lane, block, point].
        kind: Of the pairs, shape [pair]; points are all -(a, b), then all (a, b).
    """

    columns: dict[str, Array]
    place: Array
    area: Array
    kind: Array

    @classmethod
    def of(cls, lanes: Lanes, settings: DemSettings) -> Self:
        """Points spread over each interface, as kernels/dem_space/stack_meet.py does."""
        columns = spatial_columns(lanes)
        a, b, share, kind = point_pairs(settings.subcontacts, settings.subcontacts_across)
        a, b, share = np.r_[-a, a], np.r_[-b, b], np.r_[share, share]
        width, depth = columns["half_width"], columns["half_depth"]
        wide, deep = _below(width, ENDLESS), _below(depth, ENDLESS)
        # Middle of the upper face from that of the lower one, in the lower one's axes.
        x = columns["flat_x"] + _below(columns["centre_x"], 0.0)
        y = columns["flat_y"] + _below(columns["centre_y"], 0.0)
        c, s = columns["flat_c"], columns["flat_s"]
        middle_a, half_a = _stretch(width, wide, deep, -c * x - s * y, c, s)
        middle_b, half_b = _stretch(depth, wide, deep, s * x - c * y, s, c)
        along = middle_a[..., None] + half_a[..., None] * a
        across = middle_b[..., None] + half_b[..., None] * b
        c, s, x, y, wide, deep = (v[..., None] for v in (c, s, x, y, wide, deep))
        px, py = x + c * along - s * across, y + s * along + c * across
        dx, dy = np.clip(px, -wide, wide) - px, np.clip(py, -deep, deep) - py
        area = 4.0 * np.fmax(half_a, 0.0) * np.fmax(half_b, 0.0)
        return cls(
            columns=columns,
            place=np.stack([along + c * dx + s * dy, across - s * dx + c * dy], axis=-1),
            area=np.where(np.isnan(half_a * half_b), np.nan, area)[..., None] * share,
            kind=kind,
        )

    def total(self, values: Array) -> Array:
        """Sums over the points (last axis); a mirrored stack has exactly the mirrored sum."""
        pairs = values[..., : len(self.kind)] + values[..., len(self.kind) :]
        parts = [pairs[..., self.kind == kind].sum(axis=-1) for kind in (1.0, 2.0, 0.0)]
        return np.asarray((parts[0] + parts[1]) + parts[2])


def _below(values: Array, ground: float) -> Array:
    """What the body below each block has."""
    return np.concatenate([np.full((len(values), 1), ground), values[:, :-1]], axis=1)


def _stretch(
    half: Array, wide: Array, deep: Array, place: Array, lean_x: Array, lean_y: Array
) -> tuple[Array, Array]:
    """Middle and half length of what a face shares with the one below along one of its axes [m]."""
    reach = np.minimum(
        wide / np.maximum(np.abs(lean_x), SMALLEST), deep / np.maximum(np.abs(lean_y), SMALLEST)
    )
    low, top = np.maximum(-half, place - reach), np.minimum(half, place + reach)
    return 0.5 * (low + top), 0.5 * (top - low)


def spatial_frequencies(lanes: Lanes, settings: DemSettings) -> Array:
    """Angular frequencies of small motions of flat stacks [rad/s], shape [lane, 6 block], rising.

    The roots of K - w^2 M over three displacements and three rotations of every block, every point
    of every interface closed and sticking; NaN where a size is not finite. A block that stands on
    fewer points is softer.
    """
    springs = SpatialSprings.of(lanes, settings)
    columns = springs.columns
    count, blocks, points = springs.area.shape
    size = 6 * blocks
    stiffness = np.zeros((count, size, size))
    axes = np.eye(3)
    c, s = columns["flat_c"], columns["flat_s"]
    for block in range(blocks):
        upper = _levers(springs, block)
        lower = _turn_by(upper + _middle(columns, block), c[:, block], s[:, block])
        if block > 0:
            flat = [columns[name][:, block] for name in ("flat_x", "flat_y")]
            high = columns["half_height"][:, block - 1]
            lower[..., :2] += np.stack(flat, axis=-1)[:, None]
            lower[..., 2] = high[:, None]
        for axis, k in zip(
            axes,
            (settings.shear_stiffness, settings.shear_stiffness, settings.normal_stiffness),
            strict=True,
        ):
            row = np.zeros((count, points, size))
            e = np.broadcast_to(axis, upper.shape)
            row[..., 6 * block : 6 * block + 6] = np.concatenate([e, np.cross(upper, e)], axis=-1)
            if block > 0:
                e = _turn_by(e, c[:, block], s[:, block])
                part = np.concatenate([e, np.cross(lower, e)], axis=-1)
                row[..., 6 * block - 6 : 6 * block] = -part
            weighed = row * (k * springs.area[:, block])[..., None]
            stiffness += np.matmul(row.transpose(0, 2, 1), weighed)
    one = np.ones_like(c)
    inertia = [1.0 / columns[f"inverse_{axis}"] for axis in "xyz"]
    masses = columns["mass"][..., None] * np.stack([one, one, one, *inertia], axis=-1)
    root = np.sqrt(masses).reshape(count, size)
    scaled = stiffness / (root[:, :, None] * root[:, None, :])
    sound = np.isfinite(scaled).all(axis=(1, 2))
    roots = np.linalg.eigvalsh(np.where(sound[:, None, None], scaled, 0.0))
    return np.where(sound[:, None], round_frequency(np.sqrt(np.maximum(roots, 0.0))), np.nan)


def _middle(columns: dict[str, Array], block: int) -> Array:
    """Middle of a block's bottom face to its centre of mass [m], shape [lane, 1, 3]."""
    names = ("centre_x", "centre_y", "half_height")
    return np.stack([columns[name][:, block] for name in names], axis=-1)[:, None]


def _levers(springs: SpatialSprings, block: int) -> Array:
    """Points below a block from its centre of mass, in its axes [m], shape [lane, point, 3]."""
    flat = np.concatenate([springs.place[:, block], np.zeros((*springs.area[:, 0].shape, 1))], -1)
    return np.asarray(flat - _middle(springs.columns, block))


def _turn_by(vector: Array, c: Array, s: Array) -> Array:
    """Rotates vectors [lane, point, 3] about the vertical, from +x to +y."""
    x, y, z = vector[..., 0], vector[..., 1], vector[..., 2]
    c, s = c[:, None], s[:, None]
    return np.stack([c * x - s * y, s * x + c * y, z + 0.0 * x], axis=-1)


def start_in_space(lanes: Lanes, settings: DemSettings) -> dict[str, Array]:
    """What the blocks are and where they start, pressed into one another by what they bear.

    Flat blocks are in static equilibrium, eccentric as they may be. Of blocks that are let go from
    a lean every interface bears the weight above it on the points that reach it, pressed along the
    normal of the lower face; what is in the air, or on something that is, bears none.

    Returns:
        `spatial_columns`, shape [lane, block] each, with settled poses; z from where it would be in
        the flat stack of rigid blocks.
    """
    stacks = cast(SpatialLanes, as_stacks(lanes))
    springs = SpatialSprings.of(lanes, settings)
    columns = dict(springs.columns)
    position = np.stack([columns[name] for name in ("x", "y", "z")], axis=-1)
    attitude = np.stack([columns[name] for name in ("qx", "qy", "qz", "qw")], axis=-1)
    position[..., 2] -= np.cumsum(stacks.height, axis=1) - 0.5 * stacks.height
    leans = (stacks.rotation_start != 0.0) | (stacks.rotation_across_start != 0.0)
    flat = ~leans.any(axis=1) & ~(stacks.gap_start > 0.0).any(axis=1)
    moved, turn = _pile(
        springs, stacks.yaw_start, *_equilibrium_in_space(springs, stacks, settings)
    )
    position += np.where(flat[:, None, None], moved, 0.0)
    attitude = np.where(flat[:, None, None], product(quaternion(turn), attitude), attitude)
    flies = np.logical_or.accumulate(stacks.gap_start > 0.0, axis=1)
    weight = GRAVITY * sum_above(np.where(flies, 0.0, stacks.mass))
    rise = rotate(attitude[:, :1], _levers(springs, 0))[..., 2] + 0.5 * stacks.height[:, :1]
    rise, axis = rise + position[:, :1, 2], np.broadcast_to((0.0, 0.0, 1.0), (len(rise), 3))
    for block in range(stacks.block_count):
        if block > 0:
            rise, axis = _rise(springs, attitude, block)
        stiffness = settings.normal_stiffness * springs.area[:, block]
        depth = _find_sinking(springs, rise, stiffness, weight[:, block] * axis[:, 2])
        sunk = np.where(~flat & ~flies[:, block], depth, 0.0)
        position[:, block:] -= (sunk[:, None] * axis)[:, None]
    columns |= {name: position[..., axis] for axis, name in enumerate(("x", "y", "z"))}
    return columns | {
        name: attitude[..., part] for part, name in enumerate(("qx", "qy", "qz", "qw"))
    }


def _rise(springs: SpatialSprings, attitude: Array, block: int) -> tuple[Array, Array]:
    """Heights of points above the face of the rigid block below [m], and the normal of that face.

    Shapes [lane, point] and [lane, 3], for attitudes of the shape [lane, block, 4].
    """
    columns = springs.columns
    low, up = attitude[:, block - 1], attitude[:, block]
    axis = rotate(low, np.broadcast_to((0.0, 0.0, 1.0), (len(low), 3)))
    apart = np.stack([columns[n][:, block] - columns[n][:, block - 1] for n in "xyz"], axis=-1)
    seen = rotate(up[:, None], _levers(springs, block)) + apart[:, None]
    height = (seen * axis[:, None]).sum(axis=-1) - columns["half_height"][:, block - 1, None]
    return height, axis


def _find_sinking(springs: SpatialSprings, rise: Array, stiffness: Array, weight: Array) -> Array:
    """How far points at heights [m], [lane, point], must sink for springs to bear a weight [m]."""
    closed = np.ones(rise.shape, dtype=bool)
    depth = np.zeros(len(rise))
    for _ in range(rise.shape[1] + 1):
        k = np.where(closed, stiffness, 0.0)
        total = springs.total(k)
        depth = (weight + springs.total(k * rise)) / np.where(total > 0.0, total, 1.0)
        now = depth[:, None] > rise
        if np.array_equal(now, closed):
            break
        closed = np.where(now.any(axis=1, keepdims=True), now, closed)
    return depth


def _equilibrium_in_space(
    springs: SpatialSprings, stacks: SpatialLanes, settings: DemSettings
) -> tuple[Array, Array]:
    """Overlap in the middle of every face [m] and slopes of it along both axes [-].

    Shapes [lane, block] and [lane, block, 2].
    """
    depth, slope = np.zeros(stacks.width.shape), np.zeros((*stacks.width.shape, 2))
    stiffness = settings.normal_stiffness * springs.area
    weight = GRAVITY * sum_above(stacks.mass)
    for _ in range(EQUILIBRIUM_SWEEPS):
        before = depth.copy(), slope.copy()
        lever = _lever_above(springs, stacks, depth, slope)
        for block in range(stacks.block_count):
            depth[:, block], slope[:, block] = _bearing(
                springs,
                springs.place[:, block],
                stiffness[:, block],
                weight[:, block],
                lever[:, block],
            )
        if all(
            np.allclose(old, new, rtol=1e-14, atol=1e-18, equal_nan=True)
            for old, new in zip(before, (depth, slope), strict=True)
        ):
            break
    return depth, slope


def _bearing(
    springs: SpatialSprings, place: Array, stiffness: Array, weight: Array, lever: Array
) -> tuple[Array, Array]:
    """Overlap and slopes of springs that bear a weight without tension.

    Args:
        springs: For its sums.
        place: Of the points [m], shape [lane, point, 2].
        stiffness: [N/m], shape [lane, point].
        weight: [N], shape [lane].
        lever: Of the weight [m], shape [lane, 2].
    """
    shape = np.concatenate([np.ones((*stiffness.shape, 1)), place], axis=-1)
    load = weight[:, None] * np.concatenate([np.ones((len(lever), 1)), lever], axis=-1)
    closed = np.ones(stiffness.shape, dtype=bool)
    found = np.zeros((len(weight), 3))
    for _ in range(EQUILIBRIUM_SWEEPS):
        k = np.where(closed, stiffness, 0.0)
        matrix = springs.total(
            (k[..., None, None] * shape[..., :, None] * shape[..., None, :]).transpose(0, 2, 3, 1)
        )
        span = matrix[:, 1, 1] * matrix[:, 2, 2] * matrix[:, 0, 0]
        solvable = np.linalg.det(np.where(np.isfinite(matrix), matrix, 0.0)) > 1e-9 * span
        safe = np.where(solvable[:, None, None], matrix, np.eye(3))
        answer = np.linalg.solve(safe, load[..., None])[..., 0]
        found = np.where(solvable[:, None], answer, found)
        now = (shape * found[:, None]).sum(axis=-1) > 0.0
        if np.array_equal(now, closed):
            break
        closed = np.where(now.any(axis=1, keepdims=True), now, closed)
    found[~np.isfinite(load).all(axis=1)] = np.nan
    return found[:, 0], found[:, 1:]


def _pile(springs: SpatialSprings, yaw: Array, depth: Array, slope: Array) -> tuple[Array, Array]:
    """How the centres of flat blocks move [m], and turns [rad], shape [lane, block, 3] each.

    Of first order in the overlaps, which are 1e-5 of the sizes: a block leans by the slopes of all
    interfaces below it.
    """
    columns = springs.columns
    moved, turn = np.zeros((2, *depth.shape, 3))
    foot, total = np.zeros((2, len(depth), 3))
    for block in range(depth.shape[1]):
        c, s = np.cos(yaw[:, block]), np.sin(yaw[:, block])
        a, b = slope[:, block, 0], slope[:, block, 1]
        total = total + np.stack([-s * a - c * b, c * a - s * b, 0.0 * a], axis=-1)
        turn[:, block] = total
        foot = foot.copy()
        foot[:, 2] -= depth[:, block]
        centre = _turn_by(_middle(columns, block), c, s)[:, 0]
        moved[:, block] = foot + np.cross(total, centre)
        if block + 1 < depth.shape[1]:
            flat = [columns[name][:, block + 1] for name in ("flat_x", "flat_y")]
            up = np.stack([*flat, columns["half_height"][:, block]], axis=-1)[:, None]
            foot = moved[:, block] + np.cross(total, _turn_by(up, c, s)[:, 0])
    return moved, turn


def _lever_above(
    springs: SpatialSprings, stacks: SpatialLanes, depth: Array, slope: Array
) -> Array:
    """Lever of all that stands on an interface from the middle of the upper face, in its axes [m].

    Shape [lane, block, 2].
    """
    columns = springs.columns
    moved, turn = _pile(springs, stacks.yaw_start, depth, slope)
    centre = np.stack([columns[name] for name in ("x", "y")], axis=-1) + moved[..., :2]
    mass = stacks.mass[..., None]
    above = sum_above(mass * centre)
    above = above / sum_above(mass)
    lever = np.empty_like(centre)
    for block in range(stacks.block_count):
        c, s = np.cos(stacks.yaw_start[:, block]), np.sin(stacks.yaw_start[:, block])
        arm = _turn_by(_middle(columns, block), c, s)[:, 0]
        foot = centre[:, block] - (arm + np.cross(turn[:, block], arm))[:, :2]
        x, y = (above[:, block] - foot).T
        lever[:, block] = np.stack([c * x + s * y, c * y - s * x], axis=-1)
    return lever
