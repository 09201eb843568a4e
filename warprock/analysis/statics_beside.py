"""Static answers beside the outcomes of the same lanes under their motions.

Two ratios say how strong a motion is for the statics of a block. The first is its largest
acceleration over the multiplier, beyond which the block turns. The second is its largest velocity
over the velocity step that just overturns the block. Outcomes come from `housner`: it has the same
rigid block on the same edges.
"""

from __future__ import annotations

import dataclasses

import numpy as np
import numpy.typing as npt

from warprock.analysis.statics import Statics
from warprock.errors import InputError, Said
from warprock.model.base_path import base_places
from warprock.model.motion import GroundMotions, MotionKind
from warprock.model.response import Outcome
from warprock.running.case_run import run_case
from warprock.running.companions import usable
from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]

ENGINE = "housner"
LOOKS = 20_001
"""Times at which the largest acceleration and velocity of a base are looked for."""


@dataclasses.dataclass(frozen=True)
class Beside:
    """Outcomes of lanes, shape [lane] each.

    Attributes:
        acceleration: Largest acceleration of the base [m/s^2].
        velocity: Largest velocity of the base [m/s].
        rotation: Largest rotation [rad].
        outcome: Codes of `Outcome`.
        usable: Whether the numbers may be used.
    """

    acceleration: Array
    velocity: Array
    rotation: Array
    outcome: npt.NDArray[np.int64]
    usable: npt.NDArray[np.bool_]

    def acceleration_ratio(self, found: Statics) -> Array:
        """Largest acceleration over the multiplier of each row, shape [row]."""
        with np.errstate(divide="ignore"):
            return np.asarray(self.acceleration[found.lane] / (GRAVITY * found.found.multiplier))

    def velocity_ratio(self, found: Statics) -> Array:
        """Largest velocity over the step that overturns each row, shape [row]."""
        return np.asarray(self.velocity[found.lane] / found.found.velocity_step)

    def rotation_ratio(self, found: Statics) -> Array:
        """Largest rotation over the capacity of each row, shape [row]."""
        return np.asarray(self.rotation[found.lane] / found.found.lean_capacity)


def run_beside(found: Statics) -> Beside:
    """Runs the lanes of which the statics are known.

    Args:
        found: Their statics.

    Raises:
        InputError: Their base stands still, or `housner` cannot run them.
    """
    case, motions = found.case, found.lane_set.motions
    if motions.kind is MotionKind.STILL:
        raise InputError(case.file, "motion", Said("no table"), "must be given: lanes run under it")
    response = run_case(case, ENGINE, histories=False).response
    acceleration, velocity = _peaks(motions, case.sample_times.duration)
    return Beside(
        acceleration=acceleration,
        velocity=velocity,
        rotation=np.asarray(response["peak_rotation"]),
        outcome=np.asarray(response["outcome"]),
        usable=usable(response),
    )


def _peaks(motions: GroundMotions, duration: float) -> tuple[Array, Array]:
    """Largest acceleration [m/s^2] and velocity [m/s] of bases along x, shape [lane] each."""
    times = np.linspace(0.0, duration, LOOKS)
    step = times[1]
    found = np.empty((2, motions.lane_count))
    for lane in range(motions.lane_count):
        acceleration = motions.components[0].acceleration(times, lane)
        velocity = np.diff(base_places(motions, lane, times)[:, 0]) / step
        found[:, lane] = np.abs(acceleration).max(), np.abs(velocity).max()
    return found[0], found[1]


def fell(beside: Beside) -> npt.NDArray[np.bool_]:
    """Whether each lane overturned, shape [lane]."""
    return np.asarray(beside.outcome == Outcome.OVERTURNED)
