"""Blocks on compliant ground, as kernels/housner/bed_run.py takes them."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from warprock.model.hold import Bed
from warprock.model.lanes import Lanes
from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]


def bed_of(lanes: Lanes) -> Bed:
    """The ground below lanes that have one."""
    assert lanes.hold is not None
    assert lanes.hold.bed is not None
    return lanes.hold.bed


def bed_rate(lanes: Lanes) -> Array:
    """A bound of the rates of the blocks on their ground [rad/s], shape [lane]."""
    return bed_of(lanes).fastest_rate(lanes.width, lanes.height, lanes.depth, lanes.mass)


def bed_inputs(lanes: Lanes) -> dict[str, Array]:
    """Fields of the struct of the kernel that blocks on compliant ground alone have, [lane]."""
    bed = bed_of(lanes)
    return {
        "half_width": 0.5 * lanes.width,
        "half_height": 0.5 * lanes.height,
        "mass": lanes.mass,
        "inertia": lanes.mass * (lanes.width**2 + lanes.height**2) / 12.0,
        "stiffness": bed.stiffness * lanes.depth,
        "damping": bed.damping * lanes.depth,
        "gravity": np.full_like(lanes.width, GRAVITY),
        "sunk": bed.sunk(lanes.width, lanes.depth, lanes.mass),
        "fall_angle": lanes.slenderness_angle + np.arctan(np.minimum(lanes.friction, 1.0)),
    }
