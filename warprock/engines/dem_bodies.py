"""Springs under bodies on contact points in the plane, for the soft-spring engine.

Every corner stands on a spring as the corners of a box with two sub-contacts do: it has half of the
area of the base that the body stands on at rest, as deep as `Lanes.depth` says.
"""

from __future__ import annotations

import dataclasses

import numpy as np
import numpy.typing as npt

from warprock.engines.blocks import speed_columns
from warprock.engines.bodies import Corners
from warprock.engines.dem_springs import round_frequency
from warprock.engines.launching import NEVER
from warprock.model.bodies import Bodies
from warprock.model.lanes import Lanes
from warprock.settings.engines import DemSettings
from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]

SWEEPS = 60
"""Iterations for the lean of a body at rest on its springs; each reduces the error to the
settlement / width of it."""


def corner_rows(points: int) -> int:
    """Rows of corners that a kernel is made for: a multiple of four, for few kernels.

    Args:
        points: Most contact points of a body.
    """
    return -(-points // 4) * 4


@dataclasses.dataclass(frozen=True)
class CornerSprings:
    """Bodies and the springs under their corners.

    Attributes:
        body: The bodies.
        corners: Their corners.
        area: That a corner stands for [m^2], shape [lane].
        load: Weight over what a spring gives per metre, the settlement of one that bears all [m],
            shape [lane].
    """

    body: Bodies
    corners: Corners
    area: Array
    load: Array

    @classmethod
    def of(cls, lanes: Lanes, settings: DemSettings) -> CornerSprings:
        """The springs of lanes of bodies."""
        assert lanes.body is not None
        corners = Corners.of(lanes.body)
        area = 0.5 * np.ptp(lanes.body.base_ends, axis=1) * lanes.depth
        load = GRAVITY * lanes.mass / (settings.normal_stiffness * area)
        return cls(lanes.body, corners, area, load)

    @property
    def columns(self) -> dict[str, Array]:
        """Fields of the struct `Corner` of kernels/dem/body.py, shape [lane, row]."""
        corners = self.corners
        rows = corner_rows(self.body.most_points)
        beyond = ((0, 0), (0, rows - corners.x.shape[1]))
        real = np.arange(corners.x.shape[1]) <= corners.last[:, None]
        columns = {
            "x": corners.x,
            "z": corners.z,
            "raised": np.where(real, corners.z - corners.z.min(axis=1, keepdims=True), NEVER),
            "along": corners.along,
            "area": np.repeat(self.area[:, None], corners.x.shape[1], axis=1),
        }
        return {
            name: np.pad(each, beyond, constant_values=NEVER if name == "raised" else 0.0)
            for name, each in columns.items()
        }

    def start(self, rotation: Array) -> dict[str, Array]:
        """Where bodies start: centre of mass x and z, and rotation, shape [lane, 1] each.

        One that is let go turned is pressed in at its lowest corner by its weight; one on the edge
        on which it stands at rest is in static equilibrium.

        Args:
            rotation: At the start [rad], shape [lane].
        """
        corners, lane = self.corners, np.arange(len(rotation))
        first = corners.lowest(np.zeros((len(rotation), 1)))[:, 0]
        left, right = corners.x[lane, first], corners.x[lane, first + 1]
        low = corners.z[lane, first]
        theta, rests = rotation.copy(), rotation == 0.0
        for _ in range(SWEEPS):
            s, c = np.sin(theta), np.cos(theta)
            lever = left * c + low * s
            share = np.clip(-lever / ((right - left) * c), 0.0, 1.0)
            lean = np.arcsin(np.clip(self.load * (2.0 * share - 1.0) / (right - left), -1.0, 1.0))
            theta = np.where(rests, lean, theta)
        at = np.where(rests, first, corners.lowest(rotation[:, None])[:, 0])
        x, z, along = (part[lane, at] for part in (corners.x, corners.z, corners.along))
        s, c = np.sin(theta), np.cos(theta)
        pressed = self.load * np.where(rests, 1.0 - share, 1.0)
        height = -corners.z.min(axis=1)
        return {
            "x": along - (x * c + z * s),
            "z": -(z * c - x * s) - pressed - height,
            "theta": theta,
        }

    def stiffest_frequency(self, settings: DemSettings) -> Array:
        """Largest angular frequency of small motions [rad/s], shape [lane].

        Of a body that lies on any of its edges, both ends closed and sticking: no more than two
        corners of a convex chain do.
        """
        x, z = self.corners.x, self.corners.z
        zero, one = np.zeros_like(x), np.ones_like(x)
        arm = 1.0 / np.sqrt(self.body.gyration)[:, None]
        normal = np.stack([zero, one, -x * arm], axis=-1)
        shear = np.stack([one, zero, z * arm], axis=-1)
        corner = settings.normal_stiffness * normal[..., :, None] * normal[..., None, :]
        corner = corner + settings.shear_stiffness * shear[..., :, None] * shear[..., None, :]
        edges = (corner[:, :-1] + corner[:, 1:]) * (self.area / self.body.mass)[:, None, None, None]
        largest = np.linalg.eigvalsh(edges)[..., -1].max(axis=1)
        return round_frequency(np.sqrt(largest))

    def standing_ratio(self) -> Array:
        """Rocking stiffness of the springs / that needed to stand, shape [lane, 1].

        See `dem_springs.standing_ratio`: k_n I over the weight times the height of its centre.
        """
        second = 0.5 * np.ptp(self.body.base_ends, axis=1) ** 2
        return np.asarray(second / (self.load * self.body.centre_height))[:, None]


def cornered_columns(
    springs: CornerSprings, lanes: Lanes, time_step: Array
) -> dict[str, npt.NDArray[np.float64]]:
    """Fields of the struct `Body` of kernels/dem/body_run.py, shape [lane, 1] each."""
    columns = {
        "inverse_mass": 1.0 / lanes.mass,
        "inverse_inertia": 1.0 / (lanes.mass * springs.body.gyration),
        "friction": lanes.friction,
        "height": springs.body.centre_height,
        "time_step": time_step,
        **springs.start(lanes.rotation_start),
        **speed_columns(lanes),
    }
    flat = (lanes.rotation_start == 0.0) & (columns["omega"] == 0.0)
    columns["uplift_time"] = np.where(flat, NEVER, 0.0)
    return {name: each[:, None] for name, each in columns.items()}
