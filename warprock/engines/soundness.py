"""Energy from nowhere: which lanes of a time-stepping engine gained more than can be.

On a base that stands still a block can only lose energy. A step that is long for its size gives
some back; where that is more than the block held, its motion is the step's and not its own.
"""

from __future__ import annotations

import dataclasses

import numpy as np
import numpy.typing as npt

from warprock import rocking
from warprock.engines.stack_launching import start_on_corners
from warprock.lanes import Lanes
from warprock.motion import GroundMotions, HarmonicMotions, StillBase
from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

EXPLOSION_BOUND = 1.0
"""Energy gained over energy held at the start above which a lane's numbers are absurd..."""
BARRIER_SHARE = 0.1
"""...if what was gained is also this part of the energy that overturns the blocks (a twentieth of
the slenderness angle): a block that holds next to nothing may gain much of that, and move by
nothing."""
SINKING_SHARE = 1e-2
"""Part of the rise that overturns a block by which contacts may sink and count as rigid."""


def energy_held(lanes: Lanes, rotation: Array) -> Array:
    """Least energy above the flat state of single blocks that turned to a rotation [J], [lane].

    Beyond the slenderness angle it is what it takes to get there.
    """
    turned = np.minimum(np.abs(rotation), lanes.slenderness_angle)
    return rocking.energy(lanes.width, lanes.height, lanes.depth, lanes.density, turned, 0.0)


def energy_gained(lanes: Lanes, energy_lost: Array, peak_rotation: Array) -> Array:
    """Energy that single rigid blocks on a still base gained [J], shape [lane].

    By the engine's own account, or because they turned further than they were let go; negative
    where both say that they lost some.
    """
    reached = energy_held(lanes, peak_rotation) - energy_held(lanes, lanes.rotation_start)
    return np.fmax(-np.asarray(energy_lost, dtype=np.float64), reached)


def exploded(lanes: Lanes, held: Array, gained: Array) -> Mask:
    """Where more energy was gained than can be put down to small errors, shape [lane].

    Args:
        lanes: Single blocks or stacks.
        held: Energy at the start above the flat state [J], shape [lane].
        gained: Energy gained since [J], shape [lane].
    """
    rise = 0.5 * (np.hypot(lanes.width, lanes.height) - lanes.height)
    barrier = (GRAVITY * lanes.mass * rise).reshape(lanes.lane_count, -1).sum(axis=1)
    return np.asarray((gained > EXPLOSION_BOUND * held) & (gained > BARRIER_SHARE * barrier))


def stack_energy_held(lanes: Lanes) -> Array:
    """Energy at the start above the state in which all blocks of a stack are flat [J], [lane].

    Negative where the stack starts so far turned that it falls.
    """
    start, flat = (start_on_corners(each)[1] for each in (lanes, _flat(lanes)))
    return np.asarray(GRAVITY * (lanes.mass * (start - flat)).sum(axis=1))


def toppled_from_nothing(lanes: Lanes, held: Array, peak_rotation: Array) -> Mask:
    """Where a stack turned further than its energy can take it, shape [lane].

    Write the potential with u_k, the sine of the rotation of block k less that of what it stands
    on: as long as each u_k keeps its sign it is concave, so that the least energy to leave the
    well around the flat state lies where one u_k alone is not zero: the blocks from k up turn as
    one about an end of interface k. In the well the sum of |u_k| / (u_k there) is less than one,
    and no rotation has a larger sine than the largest of those. A stack that starts in the well
    with less than 1 - `BARRIER_SHARE` of that energy cannot leave it. Friction has to hold every
    interface until it tips; elsewhere nothing is said.

    Args:
        lanes: Stacks.
        held: Energy at the start above the flat state [J], shape [lane].
        peak_rotation: Largest rotations [rad], shape [lane, block].
    """
    x, z, left, right = start_on_corners(_flat(lanes))
    mass = lanes.mass
    # What stands on each interface, and its centre above it: sums from the top down.
    above, levers, heights = (
        np.cumsum((mass * each)[:, ::-1], axis=1)[:, ::-1] for each in (np.ones_like(x), x, z)
    )
    centre, rise = levers / above, heights / above - (z - 0.5 * lanes.height)
    arms = np.maximum(np.stack([centre - left, right - centre]), 0.0)
    reach = np.hypot(arms, rise)
    barrier = (GRAVITY * above * (reach - rise)).min(axis=(0, 2))
    sine = arms / reach
    turn = np.diff(np.sin(lanes.rotation_start), axis=1, prepend=0.0)
    there = np.where(turn < 0.0, sine[0], sine[1])
    share = np.divide(np.abs(turn), there, out=np.full(turn.shape, np.inf), where=there > 0.0)
    inside = share.sum(axis=1) < 1.0
    holds = (lanes.friction >= (arms / rise).max(axis=0)).all(axis=1)
    farthest = np.sin(np.minimum(np.abs(peak_rotation), 0.5 * np.pi)).max(axis=1)
    left_it = farthest > sine.max(axis=(0, 2))
    poor = held < (1.0 - BARRIER_SHARE) * barrier
    return np.asarray(inside & holds & left_it & poor)


def contacts_hold(lanes: Lanes, stiffness: float) -> Mask:
    """Where all contacts sink by little beside what overturns the blocks, shape [lane].

    Args:
        lanes: Single blocks or stacks.
        stiffness: Of one contact [N/m].
    """
    load = (GRAVITY * lanes.mass).reshape(lanes.lane_count, -1).sum(axis=1)
    rise = 0.5 * (np.hypot(lanes.face_width, lanes.height) - lanes.height)
    least = rise.reshape(lanes.lane_count, -1).min(axis=1)
    return np.asarray(load / stiffness <= SINKING_SHARE * least)


def unstable(
    lanes: Lanes,
    motions: GroundMotions,
    energy_lost: Array,
    peak_rotation: Array,
    *,
    rigid: Mask | bool = True,
) -> Mask:
    """Where blocks on a still base gained energy that nothing gave, shape [lane].

    Where the base moves it gives energy, and nothing is said: there only numbers that are not
    finite are found, see `launching.respond`.

    Args:
        lanes: Single blocks or stacks.
        motions: Their ground motions.
        energy_lost: By the engine's own account [J], shape [lane].
        peak_rotation: Largest rotations [rad], shape [lane], or [lane, block] for stacks.
        rigid: Whether contacts are rigid, so that rotations tell an energy, one or shape [lane].
    """
    still = stands_still(motions)
    if not still.any():
        return still
    if lanes.stacked and lanes.block_count == 1:
        parts = {
            field.name: getattr(lanes, field.name).reshape(lanes.lane_count)
            for field in dataclasses.fields(lanes)
        }
        lanes, peak_rotation = dataclasses.replace(lanes, **parts), peak_rotation[:, 0]
    account = -np.asarray(energy_lost, dtype=np.float64)
    if lanes.stacked:
        held = stack_energy_held(lanes)
        found = exploded(lanes, held, account)
        found |= rigid & toppled_from_nothing(lanes, held, peak_rotation)
        return still & found
    held = energy_held(lanes, lanes.rotation_start)
    gained = np.where(rigid, energy_gained(lanes, energy_lost, peak_rotation), account)
    return still & exploded(lanes, held, gained)


def stands_still(motions: GroundMotions) -> Mask:
    """Where the base never moves, shape [lane]: sines of no amplitude and no steps are known."""
    if isinstance(motions, HarmonicMotions):
        steps = (motions.velocity_step_start == 0.0) & (motions.velocity_step_stop == 0.0)
        return np.asarray(steps & (motions.acceleration_amplitude == 0.0))
    return np.full(motions.lane_count, isinstance(motions, StillBase))


def _flat(lanes: Lanes) -> Lanes:
    """The same stacks with no block turned."""
    return dataclasses.replace(lanes, rotation_start=np.zeros_like(lanes.rotation_start))
