"""Assemblies that are columns of equal drums, which engines of stacks can run, too."""

from __future__ import annotations

import dataclasses

import numpy as np

from warprock.model.assembly import Assemblies, Assembly, Places
from warprock.model.lanes import Lanes


def drums_of(kind: Assembly) -> Places:
    """Places of the blocks of a column, the lowest first, shape [drum]."""
    free = np.flatnonzero(~kind.fixed)
    return np.asarray(free[np.argsort(kind.centre[free, 1], kind="stable")], dtype=np.intp)


def joints_below(kind: Assembly) -> Places:
    """Places of the joints on which the drums of a column stand, the lowest first."""
    level = kind.joints.ends[..., 1].mean(axis=1)
    return np.asarray(np.argsort(level, kind="stable"), dtype=np.intp)


def no_column(assemblies: Assemblies) -> str:
    """Why assemblies are not all columns of as many equal drums; empty where they are."""
    whys = (_no_column(kind) for kind in assemblies.kinds)
    why = next(filter(None, whys), "")
    counts = {int((~kind.fixed).sum()) for kind in assemblies.kinds}
    if not why and len(counts) > 1:
        words = " and ".join(map(str, sorted(counts)))
        return f"its lanes have {words} of them (assembly.drums)"
    return why


def _no_column(kind: Assembly) -> str:
    """Why an assembly is no column of equal drums with dry joints; empty where it is one."""
    joints = kind.joints
    if kind.spatial:
        return "it lies in space"
    if joints.tension.any():
        return "its joints are bonded (assembly.joint_tensile_strength)"
    if joints.cohesion.any():
        return "its joints are bonded (assembly.joint_cohesion)"
    order = drums_of(kind)
    low, high = kind.corners.min(axis=1), kind.corners.max(axis=1)
    size = high - low
    boxes = np.abs(kind.area - size.prod(axis=1)) <= kind.flush * size.sum(axis=1)
    first = order[0]
    below = np.concatenate([[-1], order[:-1]])
    pairs = {frozenset(pair) for pair in joints.blocks.tolist()}
    for block, under in zip(order.tolist(), below.tolist(), strict=True):
        name = kind.names[block]
        if not boxes[block]:
            return f"block {name} is no upright rectangle"
        if np.abs(size[block] - size[first]).max() > 2.0 * kind.flush:
            of, other = (_size(size[each]) for each in (block, first))
            return f"block {name} is {of}, and block {kind.names[first]} is {other}"
        foot = low[first, 1] if under < 0 else high[under, 1]
        beside = 0.0 if under < 0 else abs(low[block, 0] - low[under, 0])
        touches = under < 0 or frozenset((block, under)) in pairs
        if not touches or max(beside, abs(low[block, 1] - foot)) > 2.0 * kind.flush:
            return f"block {name} does not stand upon the middle of one other block alone"
    grounded = kind.fixed[joints.blocks].any(axis=1)
    if joints.count > len(order) or grounded.sum() != 1:
        return "more than one joint connects it with what is fixed"
    foot = joints.ends[grounded][0]
    short = abs(np.ptp(foot[:, 0]) - size[first, 0]) > 4.0 * kind.flush
    if short or np.ptp(foot[:, 1]) > 2.0 * kind.flush:
        return f"block {kind.names[first]} stands with a part of its width alone on what is fixed"
    return ""


def _size(size: np.ndarray) -> str:
    return f"{size[0]:.6g} m wide and {size[1]:.6g} m high"


def as_stacks_of_drums(lanes: Lanes) -> Lanes:
    """Lanes of columns as the stacks that they are, drums of the same number in all of them."""
    own = lanes.assembly
    assert own is not None
    rows = [
        np.stack(
            [
                *np.ptp(kind.corners[drums_of(kind)], axis=1).T,
                kind.joints.friction[joints_below(kind)],
                np.full(len(drums_of(kind)), kind.depth),
                np.full(len(drums_of(kind)), kind.density),
            ]
        )
        for kind in own.kinds
    ]
    width, height, friction, depth, density = np.stack(rows, axis=1)[:, own.lane]
    nothing = np.zeros_like(width)
    return dataclasses.replace(
        lanes,
        width=width,
        height=height,
        depth=depth,
        density=density,
        friction=friction,
        chamfer=nothing,
        offset=nothing,
        rotation_start=nothing,
        assembly=None,
    )
