"""Stacks with bodies in the plane that tests of engines share."""

from __future__ import annotations

import dataclasses

import numpy as np

from tests.shared.blocks import Array, make_stacks, sines
from tests.shared.planar_bodies import GYRATION, STEPPED, Points
from warprock.model.hull import lower_hull
from warprock.model.lanes import Lanes
from warprock.model.motion import Control, HarmonicMotions
from warprock.model.profiles import Profiles
from warprock.model.stacking import box_profiles

EIGHT = np.array([0.0, 0.0, 1.0, 0.0, 2.0, -1.0, 3.0, -2.0])
"""Accelerations of eight lanes [m/s^2]."""


def shaken(amplitude: Array, cycles: float = 1.0) -> HarmonicMotions:
    """A cycle of 1 Hz at accelerations [m/s^2]; zero is a base that stands still."""
    return sines(Control.ACCELERATION, amplitude, np.ones(len(amplitude)), cycles)


def random_pairs(count: int, friction: float) -> Lanes:
    """Pairs of boxes beside one another's middles; every other one starts turned."""
    rng = np.random.default_rng(1)
    turned = rng.uniform(-0.06, 0.1, (count, 2)) * (np.arange(count) % 2)[:, None]
    return make_stacks(
        rng.uniform(0.15, 0.3, (count, 2)),
        rng.uniform(0.4, 0.8, (count, 2)),
        density=rng.uniform(800.0, 2000.0, (count, 2)),
        offset=np.stack([np.zeros(count), rng.uniform(-0.08, 0.08, count)], axis=1),
        rotation=turned,
        friction=friction,
    )


def as_bodies(lanes: Lanes) -> Lanes:
    """Stacks of boxes, each of which is written as a body."""
    return dataclasses.replace(lanes, profiles=box_profiles(lanes))


def with_body(
    lanes: Lanes, block: int, points: Points = STEPPED, *, gyration: float = GYRATION
) -> Lanes:
    """Stacks of boxes, one block of which, from 0, is a body of its mass and box on other points.

    Its top lies where that of its box is, so that it may carry what its box carries.
    """
    found = as_bodies(lanes).profiles if lanes.profiles is None else lanes.profiles
    assert found is not None
    hull = lower_hull(np.asarray(points))
    most = max(len(hull), found.points.shape[2])
    rows = np.minimum(np.arange(most), found.points.shape[2] - 1)
    new, count, gyrations = found.points[:, :, rows], found.count.copy(), found.gyration.copy()
    new[:, block] = hull[np.minimum(np.arange(most), len(hull) - 1)]
    count[:, block], gyrations[:, block] = len(hull), gyration
    is_body = tuple(each or k == block for k, each in enumerate(found.is_body))
    top, mass = found.top.copy(), found.mass
    top[:, block, 2] = lanes.height[:, block] + hull[:, 1].min()
    return dataclasses.replace(lanes, profiles=Profiles(mass, gyrations, new, count, top, is_body))


def random_chains(seed: int, count: int, blocks: int) -> Lanes:
    """Stacks of blocks on 2 to 12 points each, of any roughness; every other one starts turned."""
    rng = np.random.default_rng(seed)
    shape = (count, blocks)
    width, height = rng.uniform(0.15, 0.6, shape), rng.uniform(0.3, 1.0, shape)
    offset = rng.uniform(-0.05, 0.05, shape)
    offset[:, 0] = 0.0
    lanes = make_stacks(
        width,
        height,
        density=rng.uniform(500.0, 3000.0, shape),
        offset=offset,
        friction=rng.uniform(0.1, 1.5, shape),
        rotation=rng.uniform(-0.05, 0.05, shape) * (np.arange(count) % 2)[:, None],
    )
    most = 12
    points, number = np.zeros((*shape, most, 2)), np.zeros(shape, np.int32)
    top = np.zeros((*shape, 3))
    for at in np.ndindex(shape):
        left, right = rng.uniform(-0.5, -0.15), rng.uniform(0.15, 0.5)
        more = rng.integers(0, most - 1)
        rough = 10.0 ** rng.uniform(-6.0, -1.0)
        x = np.concatenate([(left, right), rng.uniform(-0.7, 0.7, more)]) * width[at]
        z = np.concatenate([(0.0, 0.0), rng.uniform(0.0, rough, more)])
        centre = (left + (right - left) * rng.uniform(0.1, 0.9)) * width[at]
        high = rng.uniform(0.35, 0.6) * height[at]
        hull = lower_hull(np.stack([x - centre, z - high], axis=1))
        points[at], number[at] = hull[np.minimum(np.arange(most), len(hull) - 1)], len(hull)
        middle, half = rng.uniform(-0.1, 0.1) * width[at], rng.uniform(0.25, 0.5) * width[at]
        top[at] = (middle - half - centre, middle + half - centre, height[at] - high)
    gyration = (width**2 + height**2) / 12.0 * rng.uniform(0.7, 1.3, shape)
    profiles = Profiles(lanes.mass, gyration, points, number, top, (True,) * blocks)
    return dataclasses.replace(lanes, profiles=profiles)


def mirrored_stacks(lanes: Lanes) -> Lanes:
    """The same stacks seen from behind."""
    assert lanes.profiles is not None
    points = np.array(lanes.profiles.points)
    for block, count in np.ndindex(points.shape[:2]):
        own = points[block, count, : lanes.profiles.count[block, count]]
        own[:] = own[::-1] * np.array([-1.0, 1.0])
        points[block, count, len(own) :] = own[-1]
    left, right, height = np.moveaxis(lanes.profiles.top, -1, 0)
    top = np.stack([-right, -left, height], axis=-1)
    return dataclasses.replace(
        lanes,
        profiles=dataclasses.replace(lanes.profiles, points=points, top=top),
        offset=-lanes.offset,
        rotation_start=-lanes.rotation_start,
    )


def stack_of_one(lanes: Lanes) -> Lanes:
    """Single bodies in the plane as stacks of one."""
    body = lanes.body
    assert body is not None
    high = lanes.height - body.centre_height
    top = np.stack([body.points[:, 0, 0], body.points[:, -1, 0], high], axis=-1)
    parts = {
        name: each[:, None] for name, each in lanes.arrays.items() if name != "angular_restitution"
    }
    profiles = Profiles(
        mass=body.mass[:, None],
        gyration=body.gyration[:, None],
        points=body.points[:, None],
        count=body.count[:, None],
        top=top[:, None],
        is_body=(True,),
    )
    return dataclasses.replace(lanes, body=None, profiles=profiles, **parts)
