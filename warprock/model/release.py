"""How single blocks are let go: with velocities, and in space thrown in any attitude.

A block that is thrown may fall on any of its faces; its run does not end with its fall.
"""

from __future__ import annotations

import dataclasses
from typing import Self

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


@dataclasses.dataclass(frozen=True)
class Release:
    """Velocities of lanes at the start, and attitudes of those that are thrown.

    Attributes:
        velocity: Of the centre of mass, in the axes of the base [m/s], shape [lane, 3].
        angular_velocity: In the axes of the base [rad/s], shape [lane, 3]; about y, the second, a
            block turns towards +x.
        attitude: Quaternion (x, y, z, w) of a thrown block, shape [lane, 4]; None of blocks that
            start on their bottom.
        height: Height of the centre of a thrown block [m], shape [lane]; None likewise.
        gyration: Moments of inertia over the mass about the axes of a thrown block [m^2], shape
            [lane, 3]; None where it is the same all through.
    """

    velocity: Array
    angular_velocity: Array
    attitude: Array | None = None
    height: Array | None = None
    gyration: Array | None = None

    @property
    def thrown(self) -> bool:
        """Whether the blocks are thrown, so that they may fall on any of their faces."""
        return self.attitude is not None

    def scaled(self, factor: float) -> Self:
        """The same with velocities and heights times a factor."""
        return dataclasses.replace(
            self,
            velocity=self.velocity * factor,
            angular_velocity=self.angular_velocity * factor,
            height=None if self.height is None else self.height * factor,
        )

    def take(self, lanes: slice | npt.NDArray[np.intp]) -> Self:
        """Some of the lanes, by slice or by number."""
        parts = {f.name: getattr(self, f.name) for f in dataclasses.fields(self)}
        return dataclasses.replace(
            self, **{name: each[lanes] for name, each in parts.items() if each is not None}
        )


def rolling(corners: Array, angular_velocity: Array) -> Array:
    """Velocity of the centre of a block that turns about what touches and goes down [m/s].

    That is the corner, or the mean of the corners, that would move down fastest: one that rises
    leaves the ground.

    Args:
        corners: Corners that touch, from the centre of mass in the axes of the base [m], shape
            [lane, corner, 3]; NaN where one does not touch.
        angular_velocity: In the axes of the base [rad/s], shape [lane, 3].

    Returns:
        Shape [lane, 3]; zero where nothing touches.
    """
    speed = np.cross(angular_velocity[:, None], corners)
    down = np.nan_to_num(speed[..., 2], nan=np.inf)
    size = np.linalg.norm(speed, axis=-1)
    least = down.min(axis=1, keepdims=True)
    pivot = down <= least + ALIKE * np.nan_to_num(size).max(axis=1, keepdims=True)
    pivot &= np.isfinite(least)
    count = np.maximum(pivot.sum(axis=1, keepdims=True), 1)
    middle = np.where(pivot[..., None], np.nan_to_num(corners), 0.0).sum(axis=1) / count
    return np.asarray(-np.cross(angular_velocity, middle))


ALIKE = 1e-9
"""Part of the speed of the corners by which two of them go down alike."""
