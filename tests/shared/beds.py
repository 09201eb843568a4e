"""Random blocks on compliant ground, under pulses of which some overturn them."""

from __future__ import annotations

import dataclasses

import numpy as np

from tests.shared.held import held_batch
from warprock.model.hold import Bed, Hold
from warprock.model.lanes import Lanes
from warprock.model.motion import HarmonicMotions
from warprock.units import GRAVITY


def bed_batch(count: int, seed: int) -> tuple[Lanes, HarmonicMotions]:
    """Lanes, a third of them let go, that lie up to a fiftieth of their width deep at rest.

    A fifth has no dampers; of the others they are up to critical, for the whole face.
    """
    lanes, motions = held_batch(count, seed, wall=False, ties=0)
    rng = np.random.default_rng(seed + 77)
    area = lanes.width * lanes.depth
    sunk = lanes.width * 10.0 ** rng.uniform(-3.3, -1.7, count)
    stiffness = lanes.mass * GRAVITY / (sunk * area)
    critical = 2.0 * np.sqrt(stiffness * area * lanes.mass) / area
    part = np.where(rng.random(count) < 0.2, 0.0, rng.uniform(0.05, 1.0, count))
    hold = Hold(bed=Bed(stiffness, part * critical))
    return dataclasses.replace(lanes, hold=hold), motions.scaled(np.full(count, 0.5))
