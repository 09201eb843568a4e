"""Stacks in the plane with bodies among their blocks, as the kernels of stacks take them.

Every block stands on the corners of a chain (see kernels/shape/stack_body.py), boxes on two. What
it has rolled from corner to corner counts from its centre of mass at rest, so that with no slide
corner i touches the top of the block below at `along` + `aside`, from above the centre there.
"""

from __future__ import annotations

import dataclasses
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from warprock.engines.bodies import Corners, rotate_lever
from warprock.model.lanes import Lanes
from warprock.model.profiles import Profiles
from warprock.model.stacking import contact_ends

Array = npt.NDArray[np.float64]

ENDLESS = 1e9
"""Half width of the ground [m]."""


@dataclasses.dataclass(frozen=True)
class Interface:
    """What one block of each lane stands on, and with which corners.

    Attributes:
        corners: Its corners.
        aside: How far its centre is to +x of the one below when both are upright [m], shape [lane].
        low: Where the top below begins at -x [m], from above the centre there, shape [lane].
        high: Where it ends at +x [m].
        level: How high it is above the centre there [m].
    """

    corners: Corners
    aside: Array
    low: Array
    high: Array
    level: Array

    @classmethod
    def of(cls, lanes: Lanes, block: int) -> Self:
        """That below one block, from 0; the ground is level with an endless top."""
        profiles = profiles_of(lanes)
        body = profiles.of(block)
        if block == 0:
            zero = np.zeros(lanes.lane_count)
            return cls(Corners.of(body), zero, zero - ENDLESS, zero + ENDLESS, zero)
        low, high, level = profiles.top[:, block - 1].T
        middles = 0.5 * (low + high) - body.base_ends.mean(axis=1)
        return cls(Corners.of(body), lanes.offset[:, block] + middles, low, high, level)

    def find_contact(self, turn: Array) -> tuple[Array, Array, Array]:
        """Finds where a block touches that has turned by an angle [rad] and not slid.

        Args:
            turn: Against what it stands on, shape [lane, sample].

        Returns:
            The place along the top below, and x and z of the point from its own centre at the
            rotation zero [m], as `turn`.
        """
        own, aside = self.corners, self.aside[:, None]
        at = own.lowest(turn)
        place = np.clip(_take_corners(own.along, at) + aside, self.low[:, None], self.high[:, None])
        return place, *self._point(place - aside)

    def _point(self, along: Array) -> tuple[Array, Array]:
        """The point of the chain that a place of the chain rolled out [m] belongs to."""
        own = self.corners
        edge = (along[..., None] >= own.along[:, None]).sum(axis=-1) - 1
        edge = np.clip(edge, 0, np.maximum(own.last - 1, 0)[:, None])
        after = edge + 1
        x, z, start = (_take_corners(part, edge) for part in (own.x, own.z, own.along))
        part = (along - start) / (_take_corners(own.along, after) - start)
        next_x, next_z = (_take_corners(each, after) for each in (own.x, own.z))
        return x + part * (next_x - x), z + part * (next_z - z)

    def slide(self, turn: Array, x: Array, z: Array) -> Array:
        """Slide of a block along the top below [m].

        Args:
            turn: Against what it stands on [rad], shape [lane, sample].
            x: Its centre from the one below, along the top below [m].
            z: The same across that top [m].
        """
        own, s, c = self.corners, np.sin(turn), np.cos(turn)
        low, high = self.low[:, None], self.high[:, None]
        reach = own.x[:, None] * c[..., None] + own.z[:, None] * s[..., None] + x[..., None]
        within = np.arange(own.x.shape[1]) <= own.last[:, None]
        # The lowest corner, or of those beyond an end of the top the first one there.
        first = (within[:, None] & (reach < low[..., None])).sum(axis=-1) - 1
        last = np.minimum((within[:, None] & (reach <= high[..., None])).sum(axis=-1),
                          own.last[:, None])  # fmt: skip
        at = np.minimum(np.maximum(own.lowest(turn), first), last)
        here = np.take_along_axis(reach, at[..., None], axis=-1)[..., 0]
        end = np.clip(here, low, high)
        # Beyond an end its edge lies on that; how far along the edge the end is seen.
        edge = np.clip(np.where(here > high, at - 1, at), 0, np.maximum(own.last - 1, 0)[:, None])
        across, up = end - x, self.level[:, None] - z
        foot_x, foot_z = across * c - up * s, up * c + across * s
        angle = _take_corners(own.angle, edge)
        seen = (foot_x - _take_corners(own.x, edge)) * np.cos(angle)
        seen += (foot_z - _take_corners(own.z, edge)) * np.sin(angle)
        place = np.where(end == here, here - _take_corners(own.along, at),
                         end - seen - _take_corners(own.along, edge))  # fmt: skip
        return np.asarray(place - self.aside[:, None])


def start_on_feet(lanes: Lanes) -> tuple[Array, Array, Array, Array]:
    """Where the blocks of stacks with bodies start; see `blocks.start_on_corners`."""
    x, z, left, right = np.zeros((4, *lanes.width.shape))
    below_x, below_z, below = np.zeros((3, lanes.lane_count))
    for block, body in enumerate(profiles_of(lanes).each):
        here, turn = Interface.of(lanes, block), lanes.rotation_start[:, block]
        place, foot_x, foot_z = (part[:, 0] for part in here.find_contact((turn - below)[:, None]))
        ends = np.clip(body.base_ends + here.aside[:, None], here.low[:, None], here.high[:, None])
        left[:, block], right[:, block] = (
            below_x + rotate_lever(end, here.level, below)[0] for end in ends.T
        )
        on, own = rotate_lever(place, here.level, below), rotate_lever(foot_x, foot_z, turn)
        below_x, below_z, below = below_x + on[0] - own[0], below_z + on[1] - own[1], turn
        x[:, block], z[:, block] = below_x, below_z
    return x, z, left, right


def profile_slides(lanes: Lanes, rotation: Array, x: Array, z: Array) -> Array:
    """Slides of blocks along what they stand on [m], shape [lane, block, sample] as all others.

    Args:
        lanes: Stacks with bodies.
        rotation: Rotations [rad].
        x: Of the centres of mass [m].
        z: The same upwards [m].
    """
    slides = np.zeros_like(rotation)
    below_x, below_z, below = np.zeros((3, *rotation[:, 0].shape))
    for block in range(lanes.block_count):
        from_x, from_z = x[:, block] - below_x, z[:, block] - below_z
        along, above = rotate_lever(from_x, from_z, -below)
        turn = rotation[:, block] - below
        slides[:, block] = Interface.of(lanes, block).slide(turn, along, above)
        below_x, below_z, below = x[:, block], z[:, block], rotation[:, block]
    return slides


def profile_columns(lanes: Lanes, side: Array) -> dict[str, npt.NDArray[Any]]:
    """Fields of the struct `Block` of kernels/shape/stack_body.py, shape [lane, block] each.

    All but where a block starts.

    Args:
        lanes: Stacks with bodies.
        side: To which blocks count as leaning before they turn, -1 or 1, shape [lane].
    """
    profiles = profiles_of(lanes)
    feet = [Interface.of(lanes, block) for block in range(lanes.block_count)]
    reach = [(np.abs(foot.corners.x) + np.abs(foot.corners.z)).max(axis=1) for foot in feet]
    return {
        "inverse_mass": 1.0 / profiles.mass,
        "inverse_inertia": 1.0 / (profiles.mass * profiles.gyration),
        "friction": lanes.friction,
        "aside": np.stack([foot.aside for foot in feet], axis=1),
        "reach": np.stack(reach, axis=1),
        "centre_height": profiles.centre_height,
        "top_low": profiles.top[..., 0],
        "top_high": profiles.top[..., 1],
        "top": profiles.top[..., 2],
        "theta": lanes.rotation_start,
        "area": 0.5 * np.diff(np.stack(contact_ends(lanes)), axis=0)[0] * shared_depth(lanes),
        "rest": rest_heights(lanes),
        "window": _windows(lanes, feet, side),
    }


def edge_columns(lanes: Lanes) -> dict[str, npt.NDArray[Any]]:
    """Fields of the struct `Block` of kernels/event/stack_run.py, shape [lane, block] each.

    All but the rotations from which they rest. The edge is the one on which a block lies, or on
    which it would fall if it turned back; of a block that leans beyond the first corner of its
    chain, the first one.
    """
    columns = profile_columns(lanes, np.ones(lanes.lane_count))
    rows, found = _rows(lanes), []
    turns = np.diff(lanes.rotation_start, axis=1, prepend=0.0)
    for block in range(lanes.block_count):
        foot = Interface.of(lanes, block)
        corner = columns["window"][:, block] - block * rows - 1
        angle = _take_corners(foot.corners.angle, corner[:, None])[:, 0]
        place = _take_corners(foot.corners.along, corner[:, None])[:, 0] + foot.aside
        # The edge to +x of the corner: where it lies flat, or on an end of the top there. Where
        # the corner is beyond the other end of the top, it is the edge before it that lies there.
        flat = (turns[:, block] >= angle) & (place <= foot.high)
        ahead = flat | (place < foot.low) | (corner == 0)
        ahead &= corner < foot.corners.last
        found.append(columns["window"][:, block] - np.where(ahead, 0, 1))
    return {**columns, "edge": np.stack(found, axis=1)}


def shared_depth(lanes: Lanes) -> Array:
    """Depth of what blocks share with what they stand on [m], shape [lane, block].

    That of the shallower one; a body in the plane is as deep as the boxes beside it.
    """
    bodies = np.array(profiles_of(lanes).is_body)
    depth = np.where(bodies, np.inf, lanes.depth)
    depth[:, 1:] = np.minimum(depth[:, 1:], np.where(bodies, np.inf, lanes.depth)[:, :-1])
    return np.where(np.isfinite(depth), depth, lanes.depth)


def rest_heights(lanes: Lanes) -> Array:
    """Heights of the centres of mass of upright blocks above the ground [m], [lane, block]."""
    below = np.cumsum(lanes.height, axis=1) - lanes.height
    return np.asarray(below + profiles_of(lanes).centre_height)


def _windows(lanes: Lanes, feet: list[Interface], side: Array) -> npt.NDArray[np.intp]:
    """Row of the corner that is lowest at the start, or the first one beyond the top below.

    Where an edge lies flat, that to the side [lane], -1 or 1. Shape [lane, block].
    """
    rows = _rows(lanes)
    turns = np.diff(lanes.rotation_start, axis=1, prepend=0.0)
    found = []
    for block, (foot, turn) in enumerate(zip(feet, turns.T, strict=True)):
        own, last = foot.corners, foot.corners.last
        past = turn[:, None] > own.angle
        past |= (turn[:, None] == own.angle) & (side[:, None] > 0.0)
        place, within = own.along + foot.aside[:, None], np.arange(own.x.shape[1]) <= last[:, None]
        before = (within & (place < foot.low[:, None])).sum(axis=1) - 1
        upto = (within & (place <= foot.high[:, None])).sum(axis=1)
        lowest = np.maximum(past.sum(axis=1), before)
        found.append(block * rows + 1 + np.minimum(np.minimum(lowest, upto), last))
    return np.stack(found, axis=1)


def foot_columns(lanes: Lanes, foot: Any) -> dict[str, Array] | npt.NDArray[Any]:
    """What a kernel of stacks takes as `feet`: the corners of bodies, none of stacks of boxes.

    Args:
        lanes: The stacks.
        foot: The struct `Foot` of kernels/shape/stack_body.py.

    Returns:
        Its fields, shape [lane, block x row] each, or no row of it.
    """
    if lanes.profiles is None:
        return np.empty((0, 0), foot.numpy_dtype())
    rows = _rows(lanes)
    found: list[dict[str, Array]] = []
    for body in profiles_of(lanes).each:
        own = Corners.of(body)
        dx, dz = (np.diff(part, axis=1, append=part[:, -1:]) for part in (own.x, own.z))
        length = np.hypot(dx, dz)
        there = length > 0.0
        length = np.where(there, length, 1.0)
        s, c = np.where(there, dz / length, 0.0), np.where(there, dx / length, 1.0)
        found.append({**own.columns, "sine": s, "cosine": c, "depth": own.x * s - own.z * c})
    return {
        name: np.concatenate([_pad_rows(each[name], rows) for each in found], axis=1)
        for name in found[0]
    }


def _rows(lanes: Lanes) -> int:
    """Rows of the corners of a block: the first and the last one are there twice."""
    return 2 + max(int(Corners.of(body).x.shape[1]) for body in profiles_of(lanes).each)


def _pad_rows(values: Array, rows: int) -> Array:
    return np.pad(values, ((0, 0), (1, rows - 1 - values.shape[1])), mode="edge")


def profiles_of(lanes: Lanes) -> Profiles:
    """What the blocks of stacks with bodies are."""
    assert lanes.profiles is not None
    return lanes.profiles


def _take_corners(values: Array, at: npt.NDArray[np.intp]) -> Array:
    """Values of shape [lane, corner] by number, shape [lane, sample]."""
    return np.take_along_axis(values, at, axis=1)
