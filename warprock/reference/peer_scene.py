"""What the peers (physics engines of others) are given to run, and what they answer."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


@dataclasses.dataclass(frozen=True)
class FreeRocking:
    """One block on a fixed flat base, let go on one of its corners; full dimensions, SI units.

    Attributes:
        width: Full width in the plane of rocking [m].
        height: Full height [m].
        depth: Full depth across the plane of rocking [m].
        density: [kg/m^3].
        friction: Coulomb friction coefficient between the block and the base.
        rotation_start: Rotation at the start [rad], positive towards +x; released from rest.
        duration: Length of the run [s].
    """

    width: float
    height: float
    depth: float
    density: float
    friction: float
    rotation_start: float
    duration: float

    @property
    def centre_start(self) -> tuple[float, float]:
        """Place of the centre at the start [m]: to +x of where it is upright, and above the base.

        The corner to the side of the rotation stays where it is when the block stands upright.
        """
        angle = abs(self.rotation_start)
        half_width, half_height = 0.5 * self.width, 0.5 * self.height
        inwards = half_width * math.cos(angle) - half_height * math.sin(angle)
        aside = math.copysign(half_width - inwards, self.rotation_start)
        return aside, half_width * math.sin(angle) + half_height * math.cos(angle)

    @property
    def quaternion_start(self) -> tuple[float, float, float, float]:
        """Attitude at the start as a quaternion (w, x, y, z): a turn about +y."""
        half = 0.5 * self.rotation_start
        return math.cos(half), 0.0, math.sin(half), 0.0


@dataclasses.dataclass(frozen=True)
class PeerRun:
    """What a peer answered.

    Attributes:
        times: Times of the samples [s], shape [sample], the start among them.
        rotation: Rotation about +y at those times [rad], shape [sample].
        cpu_s: CPU time of the stepping loop alone [s].
    """

    times: Array
    rotation: Array
    cpu_s: float


def missing(package: str, extra: str, error: ImportError) -> ImportError:
    """What to raise where a peer's package cannot be imported: one line that names the extra."""
    return ImportError(f'{package}: {error}; pip install "warprock[{extra}]" installs it')
