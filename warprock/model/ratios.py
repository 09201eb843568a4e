"""Rotations over the slenderness angle of the side that a block turns to."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from warprock.model.lanes import Lanes
from warprock.model.response import BODY_FIELDS, Response

Array = npt.NDArray[np.float64]

NO_TURN = 1e-6
"""Rotation ratio up to which a block does not rotate, as users are told."""


def peak_ratio(response: Response, lanes: Lanes) -> Array:
    """Largest rotation / slenderness angle [-], shape [lane], or [lane, block] for stacks.

    Of a body in the plane the larger one of those to its two sides, which may differ; in space of
    its weaker side.
    """
    if lanes.body is None or not set(BODY_FIELDS) <= set(response.fields):
        return np.asarray(response["peak_rotation"] / lanes.slenderness_angle)
    sides = np.stack([response[name] for name in BODY_FIELDS], axis=1)
    return np.asarray((sides / lanes.slenderness_angles).max(axis=1))


def rotation_ratio(rotation: Array, lanes: Lanes) -> Array:
    """Rotations / slenderness angle of the side that they go to [-], same shape.

    Args:
        rotation: [rad], shape [lane, sample].
        lanes: Single blocks.
    """
    if lanes.body is None:
        return np.asarray(rotation / lanes.slenderness_angle[:, None])
    left, right = lanes.slenderness_angles.T[..., None]
    return np.asarray(rotation / np.where(rotation < 0.0, left, right))
