"""Judges the energy account of a lane: which lanes of a time-stepping engine are `UNSTABLE`.

In the frame of its base a block gains energy from the motion of the base alone; contacts can only
take energy away. A step that is too long gives some back. Where it gave back more than the block
held at the start and got from the base, the lane has exploded: the step made its motion, not the
physics. The engine gives it the status `UNSTABLE`. The amounts are those of `energy`.
"""

from __future__ import annotations

import dataclasses
import math
from typing import Any, cast

import numpy as np
import numpy.typing as npt

from warprock.engines.bodies import Corners
from warprock.engines.energy import (
    energy_at_start,
    energy_held,
    energy_to_tilt,
    least_barrier,
    most_energy,
    nearest_edge,
    overturning_rise,
)
from warprock.model import rocking
from warprock.model.lanes import Lanes, SpatialLanes, as_stacks
from warprock.model.motion import GroundMotions, SpatialMotions
from warprock.model.stacking import sum_above, uplift_ratio
from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

EXPLOSION_BOUND = 1.0
"""Energy gained over energy held and supplied above which a lane has exploded, if `BARRIER_SHARE`
is exceeded, too."""
COMPLETE_BOUND = 0.1
"""The same bound for an account that knows the energy of springs. What they hold for a while does
not hide in the gain then, so that no lane overturns unnoticed on much less energy than it needs."""
BARRIER_SHARE = 0.1
"""Energy gained over the energy that overturns the blocks above which a lane has exploded (a
rotation of a twentieth of the slenderness angle). A block that holds next to no energy may gain a
multiple of it without moving."""
SINKING_SHARE = 1e-2
"""Penetration over the rise that overturns a block up to which contacts count as rigid."""


def energy_gained(lanes: Lanes, energy_lost: Array, peak_rotation: Array) -> Array:
    """Energy that single rigid blocks on a still base gained [J], shape [lane].

    The larger of two numbers: the gain in the engine's own account, and the energy of the largest
    rotation less that of the start. Negative where both say that the block lost energy.
    """
    reached = energy_held(lanes, peak_rotation) - energy_held(lanes, lanes.rotation_start)
    return np.fmax(-np.asarray(energy_lost, dtype=np.float64), reached)


def find_exploded(lanes: Lanes, held: Array, gained: Array, bound: float = EXPLOSION_BOUND) -> Mask:
    """Finds lanes that gained more energy than small errors explain, shape [lane].

    Args:
        lanes: Single blocks or stacks.
        held: Energy at the start above the flat state, and what the base supplied [J], [lane].
        gained: Energy gained from nowhere [J], shape [lane].
        bound: Energy gained over energy held and supplied up to which an error counts as small.
    """
    barrier = (
        (GRAVITY * lanes.mass * overturning_rise(lanes)).reshape(lanes.lane_count, -1).sum(axis=1)
    )
    return np.asarray((gained > bound * held) & (gained > BARRIER_SHARE * barrier))


def find_toppled_from_nothing(lanes: Lanes, held: Array, peak_rotation: Array) -> Mask:
    """Where a stack turned further than its energy can take it, shape [lane].

    Let u_k be the sine of the rotation of block k less that of what it stands on. While each u_k
    keeps its sign, the potential is concave in them. So the least energy that leaves the well
    around the flat state lies where a single u_k is not zero: the blocks from k up turn as one
    about an end of interface k, by the sine b_k. In the well the sum of |u_k| / b_k is less than
    one, and no rotation has a larger sine than the largest b_k. A stack that starts in the well
    with less than 1 - `BARRIER_SHARE` of that energy cannot leave it.

    This holds where friction holds every interface until it tips. No other lane is marked.

    Args:
        lanes: Stacks.
        held: Energy at the start above the flat state [J], shape [lane].
        peak_rotation: Largest rotations [rad], shape [lane, block].
    """
    barrier, sine = least_barrier(lanes)
    turn = np.diff(np.sin(lanes.rotation_start), axis=1, prepend=0.0)
    there = np.where(turn < 0.0, sine[0], sine[1])
    share = np.divide(np.abs(turn), there, out=np.full(turn.shape, np.inf), where=there > 0.0)
    inside = share.sum(axis=1) < 1.0
    holds = (lanes.friction >= (sine / np.sqrt(1.0 - sine**2)).max(axis=0)).all(axis=1)
    farthest = np.sin(np.minimum(np.abs(peak_rotation), 0.5 * np.pi)).max(axis=1)
    left_it = farthest > sine.max(axis=(0, 2))
    poor = held < (1.0 - BARRIER_SHARE) * barrier
    return np.asarray(inside & holds & left_it & poor)


def fall_energy(lanes: Lanes, held: Array, peak_rotation: Array) -> Array:
    """Energy that weight released where blocks fell that had the energy for it [J], [lane].

    A block lies lower than in its flat state once it has turned by more than twice its slenderness
    angle. What stands on it then sinks by at most twice as much as its centre; on a body, by the
    ratio of the heights of its top and its centre.

    Args:
        lanes: Single blocks or stacks.
        held: Energy at the start above the flat state, and what the base supplied [J], [lane].
        peak_rotation: Largest rotations [rad], shape [lane], or [lane, block] for stacks.
    """
    if lanes.body is not None:
        # The side with the least rise needs the least energy to fall, and releases the most.
        able = held >= (1.0 - BARRIER_SHARE) * GRAVITY * lanes.mass * overturning_rise(lanes)
        turned = np.minimum(np.abs(peak_rotation), 0.5 * np.pi)
        sunk = -Corners.of(lanes.body).least_rise(turned)
        return np.asarray(np.where(able, GRAVITY * lanes.mass * np.maximum(sunk, 0.0), 0.0))
    stacks = as_stacks(lanes)
    able = held >= (1.0 - BARRIER_SHARE) * least_barrier(stacks)[0]
    turned, angle = np.abs(peak_rotation).reshape(stacks.width.shape), stacks.slenderness_angle
    above = sum_above(stacks.mass) - stacks.mass
    more: Array | float = 2.0
    if stacks.profiles is None:
        radius = rocking.half_diagonal(stacks.width, stacks.height)
        sunk = radius * np.maximum(np.cos(angle) - np.cos(turned - angle), 0.0)
    else:
        turned = np.minimum(turned, 0.5 * np.pi)
        rises = [
            Corners.of(body).least_rise(turned[:, block])
            for block, body in enumerate(stacks.profiles.each)
        ]
        sunk = np.maximum(-np.stack(rises, axis=1), 0.0)
        more = stacks.height / stacks.profiles.centre_height
    freed = (GRAVITY * (stacks.mass + more * above) * sunk).sum(axis=1)
    return np.asarray(np.where(able, freed, 0))


def find_moved_by_nothing(lanes: Lanes, pull: Array, lean: Array) -> Mask:
    """Where blocks turned that stood flat on a base too weak to lift any of them, shape [lane].

    The resultant of weight and inertia stays inside every face, whatever slides: friction that
    could tip a block would have held it. `BARRIER_SHARE` says how far a block has to turn. Of
    stacks in space nothing is said.

    Args:
        lanes: Single blocks or stacks.
        pull: Largest acceleration of the base [m/s^2], shape [lane]; a velocity step counts as one.
        lean: Largest rotations [rad], in space leans of the axes, shape [lane], or [lane, block]
            for stacks.
    """
    if lanes.spatial:
        blocks = cast(SpatialLanes, lanes)
        if lanes.block_count > 1:
            return np.zeros(lanes.lane_count, dtype=bool)
        leans = [blocks.rotation_start, blocks.rotation_across_start, blocks.gap_start]
        body = lanes.body
        height = 0.5 * lanes.height if body is None else body.centre_height
        ratio = nearest_edge(lanes) / height
        angle = np.arctan(ratio)
    else:
        leans = [lanes.rotation_start]
        angle = lanes.slenderness_angle
        body = lanes.body
        ratio = body.uplift_ratios.min(axis=1) if body else uplift_ratio(as_stacks(lanes))
    count = lanes.lane_count
    flat = ~np.any([each.reshape(count, -1).any(axis=1) for each in leans], axis=0)
    flat &= lanes.release is None
    weak = pull < (1.0 - BARRIER_SHARE) * GRAVITY * ratio.reshape(count, -1).min(axis=1)
    turned = (np.abs(lean).reshape(angle.shape) / angle).reshape(count, -1).max(axis=1)
    return np.asarray(flat & weak & (turned > 1.0 - math.sqrt(1.0 - BARRIER_SHARE)))


def contacts_hold(lanes: Lanes, stiffness: float) -> Mask:
    """Lanes whose contacts sink by much less than overturns the blocks, shape [lane].

    Args:
        lanes: Single blocks or stacks.
        stiffness: Of one contact [N/m].
    """
    load = (GRAVITY * lanes.mass).reshape(lanes.lane_count, -1).sum(axis=1)
    rise = 0.5 * (np.hypot(lanes.face_width, lanes.height) - lanes.height)
    least = rise.reshape(lanes.lane_count, -1).min(axis=1)
    return np.asarray(load / stiffness <= SINKING_SHARE * least)


@dataclasses.dataclass(frozen=True)
class Account:
    """What is known of the energy of lanes, in the frames of their bases.

    Attributes:
        pull: Largest acceleration of the base over a step [m/s^2], shape [lane]; of a base that
            falls, over the part of the weight that is left.
        supplied: Most work that the base had done on the blocks by any time [J], shape [lane].
        lost: What the contacts have taken in the end [J], shape [lane].
        returned: Most that the contacts gave back of what they had taken [J], shape [lane].
        deepest: Deepest penetration [m], shape [lane].
    """

    pull: Array
    supplied: Array
    lost: Array
    returned: Array
    deepest: Array


def account_of(
    rows: npt.NDArray[Any], time_step: Array | float, mass: Array | float = 1.0
) -> Account:
    """The account that a kernel leaves in its results.

    Args:
        rows: Rows of its `Result`, shape [lane].
        time_step: Time step [s], one or shape [lane].
        mass: Mass of the blocks [kg], shape [lane], where the rows are for unit mass.
    """
    jolt, supplied, lost, returned, deepest = (
        np.asarray(rows[name], dtype=np.float64)
        for name in ("jolt", "supplied", "loss", "returned", "deepest")
    )
    return Account(jolt / time_step, mass * supplied, mass * lost, mass * returned, deepest)


def account_in_space(
    lanes: Lanes,
    motions: GroundMotions,
    duration: float,
    rows: npt.NDArray[Any],
    mass: Array | float = 1.0,
) -> Account:
    """The account of blocks in space: what their kernels leave, and bounds known before a run.

    Args:
        lanes: Single blocks or stacks.
        motions: Their ground motions.
        duration: Of the run [s].
        rows: Rows of the `Result` of a kernel, shape [lane].
        mass: Mass of the blocks [kg], shape [lane], where the rows are for unit mass.
    """
    lost, deepest = (np.asarray(rows[name], dtype=np.float64) for name in ("loss", "deepest"))
    held = energy_at_start(lanes)
    supplied = most_energy(lanes, held, motions, duration) - held
    pull = pull_in_space(cast(SpatialMotions, motions))
    return Account(pull, supplied, mass * lost, np.zeros_like(lost), deepest)


def pull_in_space(motions: SpatialMotions) -> Array:
    """Horizontal acceleration that tips a block as much as one that is also lifted, shape [lane].

    Infinite where the base velocity steps, or the base may fall as fast as its blocks [m/s^2].
    """
    x, y, z = (part.largest_acceleration() for part in motions.components)
    left = 1.0 - z / GRAVITY
    return np.where(left > 0.0, np.hypot(x, y) / np.where(left > 0.0, left, 1.0), np.inf)


def unstable(
    lanes: Lanes,
    account: Account,
    lean: Array,
    *,
    rigid: Mask | bool = True,
    complete: bool = False,
) -> Mask:
    """Where blocks gained energy that nothing gave, shape [lane], on a base that moves or not.

    In the frame of the base the energy of the blocks is what they held at the start, plus the work
    of the base, less what the contacts have taken. It is never below zero. So contacts take, and
    can give back, at most what was held and the most that the base had supplied. Rigid contacts
    hold nothing, and no rotation takes more energy than there was.

    A lane is marked where

    - contacts gave back more than `EXPLOSION_BOUND` times what there was, or a rotation shows such
      a gain: the step made it. An account that is complete, with what springs hold in it, may be
      wrong by `COMPLETE_BOUND`. Where soft contacts let blocks sink below their flat state, or
      where a block falls, gains count from there;
    - blocks turned on a base too weak to lift them (`find_moved_by_nothing`): a block that has
      begun to rock takes energy from such a base, so the first condition would miss it;
    - a corner went through its ground (`find_fallen_through`).

    Args:
        lanes: Single blocks or stacks.
        account: The engine's account.
        lean: Largest rotations [rad], in space leans of the axes, shape [lane], or [lane, block]
            for stacks.
        rigid: Whether contacts are rigid, so that a rotation shows an energy, one or shape [lane].
        complete: Whether the account knows what springs hold, so that contacts give nothing back.
    """
    if lanes.block_count == 1:
        # A stack of one is judged as a single block.
        parts: dict[str, Any] = {
            name: each.reshape(lanes.lane_count) for name, each in lanes.arrays.items()
        }
        body = lanes.body if lanes.profiles is None else lanes.profiles.of(0)
        lanes = dataclasses.replace(lanes, body=body, profiles=None, **parts)
        lean = lean.reshape(lanes.lane_count)
    held = energy_at_start(lanes) + account.supplied
    sinks = (GRAVITY * lanes.mass).reshape(lanes.lane_count, -1).sum(axis=1) * account.deepest
    sunk = np.where(rigid | complete, 0.0, sinks)
    judge = _gained_in_space if lanes.spatial else _gained_in_plane
    found = judge(lanes, account, held, sunk, lean, rigid, complete)
    found |= rigid & find_moved_by_nothing(lanes, account.pull, lean)
    return np.asarray(found | (rigid & find_fallen_through(lanes, account.deepest)))


def _gained_in_plane(
    lanes: Lanes,
    account: Account,
    held: Array,
    sunk: Array,
    lean: Array,
    rigid: Mask | bool,
    complete: bool,
) -> Mask:
    """Where blocks in the plane gained more than they held and were supplied, shape [lane]."""
    bound = COMPLETE_BOUND if complete else EXPLOSION_BOUND
    fell = np.zeros_like(sunk) if complete else fall_energy(lanes, held, lean)
    found = find_exploded(lanes, held + sunk, -account.lost, bound)
    found |= find_exploded(lanes, held + sunk + fell, account.returned, bound)
    if lanes.stacked:
        return np.asarray(found | (rigid & find_toppled_from_nothing(lanes, held, lean)))
    # Of a body it is not known to which side it turned so far: the side that takes less.
    needed = energy_held(lanes, lean)
    if lanes.body is not None:
        needed = np.minimum(needed, energy_held(lanes, -lean))
    reached = np.where(rigid, needed - held, 0.0)
    return np.asarray(found | find_exploded(lanes, held, reached))


def _gained_in_space(
    lanes: Lanes,
    account: Account,
    held: Array,
    sunk: Array,
    lean: Array,
    rigid: Mask | bool,
    complete: bool,
) -> Mask:
    """Where blocks in space gained so: no account says there what contacts gave back."""
    found = find_exploded(lanes, held, -account.lost)
    if lanes.stacked or lanes.thrown:
        return found
    # Springs let a centre sink below where a rigid corner would hold it.
    bound = EXPLOSION_BOUND if rigid else COMPLETE_BOUND
    return found | find_exploded(lanes, held, energy_to_tilt(lanes, lean) - sunk - held, bound)


def find_fallen_through(lanes: Lanes, deepest: Array) -> Mask:
    """Where a corner went deeper into rigid ground than half of its block's least side, [lane].

    A block of which the centre may be below the face it stands on is not held up by it.
    """
    least = np.minimum(lanes.width, lanes.height)
    least = np.minimum(least, lanes.depth) if lanes.spatial else least
    return np.asarray(deepest > 0.5 * least.reshape(lanes.lane_count, -1).min(axis=1))
