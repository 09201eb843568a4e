"""Strips of wall between two floors, as kernels/housner/strip_run.py takes them."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from warprock.model.lanes import Lanes
from warprock.model.rocking import half_diagonal
from warprock.model.strip import Strip
from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]


def strip_of(lanes: Lanes) -> Strip:
    """The strips of lanes that have them."""
    assert lanes.hold is not None
    assert lanes.hold.strip is not None
    return lanes.hold.strip


def strip_rate(lanes: Lanes) -> Array:
    """Fastest rate of the strips [rad/s], shape [lane]: as a whole, and of either body alone."""
    strip = strip_of(lanes)
    shorter = np.minimum(strip.lower, strip.upper)
    alone = np.sqrt(0.75 * GRAVITY / half_diagonal(strip.width, shorter))
    return np.maximum(strip.frequency_parameter, alone)


def strip_inputs(lanes: Lanes) -> dict[str, Array]:
    """Fields of the struct of the kernel that strips alone have, shape [lane] each."""
    strip = strip_of(lanes)
    lower_mass, upper_mass = strip.masses
    lower_inertia, upper_inertia = strip.own_inertias
    lower_inertia = lower_inertia + 0.25 * lower_mass * (strip.width**2 + strip.lower**2)
    fields = {
        "width": strip.width,
        "lower": strip.lower,
        "upper": strip.upper,
        "lower_mass": lower_mass,
        "upper_mass": upper_mass,
        "lower_inertia": lower_inertia,
        "upper_inertia": upper_inertia,
        "weight": strip.weight,
        "gravity": np.full_like(strip.width, GRAVITY),
        "impact_friction": strip.impact_friction(lanes.angular_restitution),
    }
    falls = strip.falling(np.minimum(lanes.friction, 1.0))
    for name, each in (("arm", strip.arm), ("laid", strip.laid), ("fall", falls)):
        fields |= {f"{name}_left": each[:, 0], f"{name}_right": each[:, 1]}
    return fields
