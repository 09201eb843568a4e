"""Springs of stacks in the plane with bodies among their blocks, for the soft-spring engine.

Every interface stands on springs at the two ends of what its faces share at rest, each with half of
its area: boxes as on two sub-contacts. As it turns, the springs are under the corners that touch.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from warprock.engines.bodies import rotate_lever
from warprock.engines.dem_springs import add_point, largest_frequency, round_frequency
from warprock.engines.stack_bodies import (
    Interface,
    profile_columns,
    profiles_of,
    rest_heights,
    shared_depth,
)
from warprock.model.lanes import Lanes
from warprock.model.stacking import contact_ends, sum_above
from warprock.settings.engines import DemSettings
from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]

SWEEPS = 60
"""Trials of how far blocks at rest lean on their springs, as in `dem_bodies`."""


def sprung_stacks(lanes: Lanes, settings: DemSettings) -> dict[str, npt.NDArray[Any]]:
    """Fields of the struct `Block` of kernels/shape/stack_body.py, shape [lane, block] each."""
    side = np.ones(lanes.lane_count)
    columns = profile_columns(lanes, side)
    x, z, rotation = _start(lanes, settings, columns["area"])
    nothing = np.zeros_like(x)
    return columns | {"x": x, "z": z, "theta": rotation, "left": nothing, "right": nothing}


def _start(lanes: Lanes, settings: DemSettings, area: Array) -> tuple[Array, Array, Array]:
    """Where the blocks start, pressed into one another by what they bear: x, z and rotations.

    An interface at which nothing is turned bears its load by statics; of one that starts turned
    the point that touches bears all.
    """
    turns = np.diff(lanes.rotation_start, axis=1, prepend=0.0)
    above = sum_above(lanes.mass)
    load = GRAVITY * above / (settings.normal_stiffness * area)
    low, high = contact_ends(lanes)
    x, z, rotation = np.zeros((3, *lanes.width.shape))
    share = np.full(x.shape, 0.5)
    for _ in range(SWEEPS):
        below_x, below_z, below = np.zeros((3, lanes.lane_count))
        for block in range(lanes.block_count):
            here, given = Interface.of(lanes, block), turns[:, block]
            flat = given == 0.0
            wide = high[:, block] - low[:, block]
            lean = load[:, block] * (2.0 * share[:, block] - 1.0) / wide
            turn = np.where(flat, lean, given)
            # At rest both points are seen at the middle of what is shared, else that which bears.
            touched, foot_x, foot_z = (part[:, 0] for part in here.find_contact(given[:, None]))
            middle = 0.5 * (low[:, block] + high[:, block])
            place = np.where(flat, middle + here.aside, touched)
            foot_x = np.where(flat, middle, foot_x)
            sunk = load[:, block] * np.where(flat, 0.5, 1.0)
            on = rotate_lever(place, here.level - sunk, below)
            own = rotate_lever(foot_x, foot_z, below + turn)
            below_x, below_z = below_x + on[0] - own[0], below_z + on[1] - own[1]
            below = below + turn
            x[:, block], z[:, block], rotation[:, block] = below_x, below_z, below
        for block in range(lanes.block_count):
            mass = lanes.mass[:, block:]
            centre = (mass * x[:, block:]).sum(axis=1) / mass.sum(axis=1)
            foot = Interface.of(lanes, block).corners.z.min(axis=1)
            left = [
                x[:, block] + rotate_lever(end[:, block], foot, rotation[:, block])[0]
                for end in (low, high)
            ]
            share[:, block] = np.clip((centre - left[0]) / (left[1] - left[0]), 0.0, 1.0)
    return x, z, rotation


def standing_ratio(lanes: Lanes, settings: DemSettings) -> Array:
    """`dem_springs.standing_ratio` of stacks with bodies, shape [lane, block]."""
    low, high = contact_ends(lanes)
    wide = high - low
    stiffness = settings.normal_stiffness * wide * shared_depth(lanes)
    mass, centre = lanes.mass, rest_heights(lanes)
    above, levers = (sum_above(mass * each) for each in (np.ones_like(mass), centre))
    ground = np.cumsum(lanes.height, axis=1) - lanes.height
    driven = GRAVITY * above * (levers / above - ground)
    return np.asarray(0.25 * stiffness * wide**2 / driven)


def stiffest_frequency(lanes: Lanes, settings: DemSettings) -> Array:
    """Largest angular frequency of small motions [rad/s], shape [lane].

    Of stacks of which every block lies on the edge that it stands on at rest, or on the edge whose
    ends are farthest away, both ends closed and sticking.
    """
    return round_frequency(np.maximum(*(_frequency(lanes, settings, far=f) for f in (False, True))))


def _frequency(lanes: Lanes, settings: DemSettings, *, far: bool) -> Array:
    """The largest one with blocks on one of two edges, shape [lane]."""
    profiles, (count, blocks) = profiles_of(lanes), lanes.width.shape
    low, high = contact_ends(lanes)
    area = 0.5 * (high - low) * shared_depth(lanes)
    stiffness = np.zeros((count, 3 * blocks, 3 * blocks))
    for block in range(blocks):
        here = Interface.of(lanes, block)
        x, z = np.stack([low[:, block], high[:, block]], axis=1), here.corners.z.min(axis=1)
        height = np.stack([z, z], axis=1)
        if far:
            x, height = _farthest_edge(here)
        for place, up in zip(x.T, height.T, strict=True):
            below = np.clip(place + here.aside, here.low, here.high), here.level
            add_point(stiffness, block, (place, up), below, settings, area[:, block])
    return largest_frequency(stiffness, profiles.mass, profiles.mass * profiles.gyration)


def _farthest_edge(here: Interface) -> tuple[Array, Array]:
    """Ends of the edge of which they are farthest from the centre: x and z [m], [lane, 2]."""
    x, z = here.corners.x, here.corners.z
    square = x**2 + z**2
    edge = np.argmax(square[:, :-1] + square[:, 1:], axis=1)[:, None] + np.arange(2)
    return np.take_along_axis(x, edge, axis=1), np.take_along_axis(z, edge, axis=1)
