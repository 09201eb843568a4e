"""Random strips of wall between two floors, under pulses of which some fell them."""

from __future__ import annotations

import dataclasses

import numpy as np
import numpy.typing as npt

from tests.shared.blocks import make_lanes, sines
from warprock.model.hold import Hold
from warprock.model.lanes import Lanes
from warprock.model.motion import Control, HarmonicMotions
from warprock.model.strip import Strip
from warprock.units import GRAVITY


def strips(
    lanes: Lanes,
    hinge: npt.ArrayLike,
    weight: npt.ArrayLike = 0.0,
    aside: npt.ArrayLike = np.nan,
) -> Lanes:
    """Lanes cut in two, at leans as parts of their balance.

    Args:
        lanes: Blocks.
        hinge: Heights of the hinges over those of the blocks.
        weight: Weights on top [N].
        aside: Distances of the points below the floors from the middle [m]; NaN at the edge.
    """
    shape = (lanes.lane_count,)
    lower = np.broadcast_to(hinge, shape) * lanes.height
    beside = np.broadcast_to(aside, shape)
    half = 0.5 * lanes.width
    arm = np.stack([half - beside, half + beside], axis=1)
    arm = np.where(np.isnan(arm), lanes.width[:, None], arm)
    weight = np.broadcast_to(np.asarray(weight, dtype=np.float64), shape)
    strip = Strip(lanes.width, lower, lanes.height - lower, lanes.mass, weight, arm)
    part = lanes.rotation_start / lanes.slenderness_angle
    return dataclasses.replace(
        lanes,
        hold=Hold(strip=strip),
        angular_restitution=strip.angular_restitution,
        rotation_start=part * strip.critical.min(axis=1),
    )


def strip_batch(count: int, seed: int) -> tuple[Lanes, HarmonicMotions]:
    """Lanes, a third of them let go, with weights at edges and beside the middle."""
    rng = np.random.default_rng(seed)
    height = rng.uniform(1.0, 5.0, count)
    width = height * rng.uniform(0.04, 0.12, count)
    ratio = np.where(rng.random(count) < 0.3, rng.uniform(-0.9, 0.9, count), 0.0)
    blocks = make_lanes(width, height, ratio, 5.0)
    loaded = rng.random(count) < 0.6
    weight = np.where(loaded, rng.uniform(0.0, 2.0, count) * GRAVITY * blocks.mass, 0.0)
    aside = np.where(rng.random(count) < 0.5, rng.uniform(-0.5, 0.5, count) * width, np.nan)
    lanes = strips(blocks, rng.uniform(0.3, 0.9, count), weight, aside)
    if seed % 3 == 0:
        eta = rng.uniform(0.3, 0.95, count)
        lanes = dataclasses.replace(lanes, angular_restitution=eta, restitution_given=True)
    assert lanes.hold is not None
    assert lanes.hold.strip is not None
    pull = rng.uniform(0.5, 4.0, count) * GRAVITY * lanes.hold.strip.uplift_ratios.min(axis=1)
    frequency = lanes.frequency_parameter / (2.0 * np.pi) * rng.uniform(1.0, 4.0, count)
    control = Control.ACCELERATION if seed % 2 else Control.VELOCITY
    amplitude = pull if seed % 2 else pull / (2.0 * np.pi * frequency)
    return lanes, sines(control, amplitude, frequency, cycles=1.5)
