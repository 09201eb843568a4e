"""Random blocks that walls and ties hold, under pulses of which some overturn them."""

from __future__ import annotations

import dataclasses

import numpy as np
import numpy.typing as npt

from tests.shared.blocks import make_lanes, sines
from warprock.model.hold import Hold, Ties, TopLoad
from warprock.model.lanes import Lanes
from warprock.model.motion import Control, HarmonicMotions
from warprock.units import GRAVITY


def held_batch(
    count: int, seed: int, *, wall: bool, ties: int, load: bool = False
) -> tuple[Lanes, HarmonicMotions]:
    """Lanes, a third of them let go from a rotation, with or without a wall and ties."""
    rng = np.random.default_rng(seed)
    height = rng.uniform(1.0, 5.0, count)
    width = height * rng.uniform(0.1, 0.35, count)
    side = rng.choice([-1.0, 1.0], count)
    ratio = np.where(rng.random(count) < 0.3, rng.uniform(0.1, 0.9, count), 0.0)
    lanes = make_lanes(width, height, -side * ratio, 5.0)
    hold = Hold()
    if wall:
        plastic = rng.random(count) < 0.3
        hold = Hold(side, np.where(plastic, 0.0, rng.uniform(0.0, 0.7, count)))
    if ties:
        hold = dataclasses.replace(hold, ties=random_ties(rng, lanes, ties))
    if load:
        hold = dataclasses.replace(hold, load=random_load(rng, lanes))
    pull = rng.uniform(0.5, 4.0, count) * GRAVITY * width / height
    frequency = lanes.frequency_parameter / (2.0 * np.pi) * rng.uniform(1.0, 4.0, count)
    control = Control.ACCELERATION if seed % 2 else Control.VELOCITY
    amplitude = pull if seed % 2 else pull / (2.0 * np.pi * frequency)
    motions = sines(control, amplitude, frequency, cycles=1.5)
    return dataclasses.replace(lanes, hold=hold), motions


def random_load(rng: np.random.Generator, lanes: Lanes) -> TopLoad:
    """Loads up to the weight of the block, of which some move with it, and thrusts."""
    count, weight = lanes.lane_count, GRAVITY * lanes.mass
    return TopLoad(
        weight=rng.uniform(0.0, 1.0, count) * weight,
        eccentricity=rng.uniform(-0.4, 0.4, count) * lanes.width,
        thrust=rng.uniform(-0.05, 0.05, count) * weight * lanes.width / lanes.height,
        stays=rng.random(count) < 0.5,
    )


def random_ties(rng: np.random.Generator, lanes: Lanes, count: int) -> Ties:
    """Ties from soft to stiff: slack, prestressed, yielding, breaking, pushing ones."""
    shape = (lanes.lane_count, count)
    width, height = lanes.width[:, None], lanes.height[:, None]
    weight = GRAVITY * lanes.mass[:, None]
    tipping = 0.5 * weight * width / height
    stiffness = 0.5 * weight / height * 10.0 ** rng.uniform(-1.0, 2.0, shape)
    loose = rng.random(shape) < 0.5
    slack = np.where(loose, rng.uniform(0.0, 0.05, shape) * width, 0.0)
    prestress = np.where(loose, 0.0, rng.uniform(0.0, 0.5, shape) * tipping)
    yields, breaks = rng.random(shape) < 0.6, rng.random(shape) < 0.4
    return Ties(
        side=rng.choice([-1.0, 1.0], shape),
        height=rng.uniform(0.3, 1.0, shape) * height,
        stiffness=stiffness,
        slack=slack,
        prestress=prestress,
        yield_force=np.where(yields, prestress + rng.uniform(0.05, 1.0, shape) * tipping, np.inf),
        ultimate_elongation=np.where(breaks, rng.uniform(0.02, 0.6, shape) * width, np.inf),
        pushes=~loose & (rng.random(shape) < 0.6),
    )


def one_tie(lanes: Lanes, *, pushes: bool = False, **given: npt.ArrayLike) -> Ties:
    """One tie a lane, elastic, at -x of the top and without slack unless it is given otherwise."""
    fields = {
        "side": -1.0,
        "height": lanes.height,
        "stiffness": 1e5,
        "slack": 0.0,
        "prestress": 0.0,
        "yield_force": np.inf,
        "ultimate_elongation": np.inf,
    } | given
    shape = (lanes.lane_count, 1)
    columns = {
        name: np.broadcast_to(np.reshape(value, (-1, 1)), shape).astype(np.float64)
        for name, value in fields.items()
    }
    return Ties(**columns, pushes=np.full(shape, pushes))


def mirrored(lanes: Lanes, motions: HarmonicMotions) -> tuple[Lanes, HarmonicMotions]:
    """The mirror image of held lanes and of their motions."""
    hold = lanes.hold
    assert hold is not None
    wall = None if hold.wall is None else -hold.wall
    ties = None if hold.ties is None else dataclasses.replace(hold.ties, side=-hold.ties.side)
    load = hold.load
    if load is not None:
        load = dataclasses.replace(load, eccentricity=-load.eccentricity, thrust=-load.thrust)
    hold = dataclasses.replace(hold, wall=wall, ties=ties, load=load)
    names = (
        "acceleration_amplitude",
        "velocity_offset",
        "velocity_step_start",
        "velocity_step_stop",
        "velocity_final",
    )
    turned = dataclasses.replace(motions, **{name: -getattr(motions, name) for name in names})
    return dataclasses.replace(lanes, rotation_start=-lanes.rotation_start, hold=hold), turned
