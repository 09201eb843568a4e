"""Stacks that tests of several engines share, and what is known of them."""

from __future__ import annotations

import numpy as np

from tests.shared.blocks import Array, make_stacks, sines
from warprock.model.lanes import Lanes
from warprock.model.motion import Control, GroundMotions, HarmonicMotions
from warprock.model.response import SampleTimes
from warprock.oracle.pair import rock_two_blocks
from warprock.oracle.pair_mechanics import TwoBlocks
from warprock.units import GRAVITY


def random_pairs(count: int) -> Lanes:
    """Pairs of blocks, the upper one narrower or wider, released from rotations to either side."""
    rng = np.random.default_rng(1)
    return make_stacks(
        rng.uniform(0.15, 0.3, (count, 2)),
        rng.uniform(0.4, 0.8, (count, 2)),
        density=rng.uniform(800.0, 2000.0, (count, 2)),
        rotation=np.stack([rng.uniform(-0.06, 0.06, count), rng.uniform(-0.1, 0.1, count)], axis=1),
    )


def shaken_threes(count: int = 75) -> tuple[Lanes, HarmonicMotions]:
    """Stacks of three that rest, rock, slide, slide off and fall."""
    rng = np.random.default_rng(2)
    rotation = np.where(rng.random((count, 1)) < 0.3, rng.uniform(-0.05, 0.05, (count, 3)), 0.0)
    lanes = make_stacks(
        rng.uniform(0.2, 0.4, (count, 3)),
        rng.uniform(0.2, 0.5, (count, 3)),
        friction=rng.uniform(0.1, 1.0, (count, 3)),
        chamfer=rng.uniform(0.0, 0.01, (count, 3)),
        offset=rng.uniform(-0.02, 0.02, (count, 3)),
        rotation=rotation,
    )
    size = rng.uniform(0.05, 1.5, count) * GRAVITY
    return lanes, sines(Control.ACCELERATION, size, rng.uniform(1.0, 4.0, count), 1.5)


def follow_by_oracle(lanes: Lanes, motions: GroundMotions, times: SampleTimes) -> Array:
    """Rotations of two-block stacks by the oracle, shape [lane, block, sample]."""
    found = []
    for lane in range(lanes.lane_count):
        low, high = lanes.width[lane].tolist(), lanes.height[lane].tolist()
        blocks = TwoBlocks(tuple(low), tuple(high), (0.5, 0.5), tuple(lanes.density[lane].tolist()))
        start = tuple(lanes.rotation_start[lane].tolist())
        answer = rock_two_blocks(
            blocks, motions.segments(lane), times, rotation_start=start, rtol=1e-9
        )
        assert answer.odd_choice_count == 0
        assert np.isnan(answer.pull_time)
        assert len(answer.impact_times) >= 2
        found.append(answer.rotation)
    return np.array(found)


def potential_energy(lanes: Lanes) -> Array:
    """Energy of the start over that of the rest [J], shape [lane]."""
    _, z = place_centres(lanes, lanes.rotation_start, np.zeros_like(lanes.width))
    flat = np.cumsum(lanes.height, axis=1) - 0.5 * lanes.height
    return np.asarray((lanes.mass * GRAVITY * (z - flat)).sum(axis=1))


def place_centres(lanes: Lanes, rotation: Array, slide: Array) -> tuple[Array, Array]:
    """Centres of blocks that stand on their lower corners [m], shape [lane, block].

    The corner is the upper block's or the lower one's, whichever lies further in; placed one by
    one, in another way than the engines do it.
    """
    x, z = np.zeros_like(rotation), np.zeros_like(rotation)
    for lane in range(len(rotation)):
        foot, turn, face = 0.0 + 0.0j, 0.0, np.inf
        for block in range(rotation.shape[1]):
            # A clockwise turn of the lever x + i z.
            now = rotation[lane, block]
            spin, under = np.exp(-1j * now), np.exp(-1j * turn)
            half = 0.5 * lanes.face_width[lane, block]
            shift = lanes.offset[lane, block] + slide[lane, block]
            side = 1.0 if now >= turn else -1.0
            touch = side * min(half + side * shift, face)
            corner = foot + touch * under
            low = corner - (touch - shift) * spin
            centre = low + 0.5j * lanes.height[lane, block] * spin
            x[lane, block], z[lane, block] = centre.real, centre.imag
            foot, turn, face = low + 1j * lanes.height[lane, block] * spin, now, half
    return x, z
