"""Vectors turned by quaternions, and the principal axes of a moment of inertia."""

from __future__ import annotations

import itertools

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

ROUND_OFF = 1e-12
"""Products of inertia over the sum of the moments up to which they are round-off."""


def rotate(attitude: Array, vector: Array) -> Array:
    """Vectors given in body axes, shape [..., 3], seen from the base."""
    # Vector products written out: np.cross takes twice as long for few vectors.
    ahead, behind, real = attitude[..., [1, 2, 0]], attitude[..., [2, 0, 1]], attitude[..., 3:]
    twice = 2.0 * (ahead * vector[..., [2, 0, 1]] - behind * vector[..., [1, 2, 0]])
    across = ahead * twice[..., [2, 0, 1]] - behind * twice[..., [1, 2, 0]]
    return np.asarray(vector + real * twice + across)


def inverse(attitude: Array) -> Array:
    """Unit quaternions that turn back, shape [..., 4]."""
    return np.asarray(attitude * (-1.0, -1.0, -1.0, 1.0))


def principal_axes(tensor: Array) -> tuple[Array, Array]:
    """Principal moments of inertia, and the attitude of their axes.

    Each axis is that which is nearest to x, y or z. Of a body whose axes are principal but for
    round-off nothing turns; where two of its moments are equal, round-off alone would turn them.

    Args:
        tensor: Symmetric, shape [3, 3].

    Returns:
        Moments, shape [3], and a quaternion (x, y, z, w), shape [4], which turns the principal
        axes' components of a vector into those along the axes of the tensor.
    """
    own = np.diag(tensor)
    if np.abs(tensor - np.diag(own)).max() <= ROUND_OFF * own.sum():
        return own.copy(), np.array([0.0, 0.0, 0.0, 1.0])
    moments, vectors = np.linalg.eigh(tensor)
    order = max(
        itertools.permutations(range(3)),
        key=lambda p: sum(abs(vectors[i, j]) for i, j in enumerate(p)),
    )
    moments, vectors = moments[list(order)], vectors[:, list(order)]
    vectors = vectors * np.where(np.diag(vectors) < 0.0, -1.0, 1.0)
    if np.linalg.det(vectors) < 0.0:
        vectors[:, np.argmin(np.abs(np.diag(vectors)))] *= -1.0
    return moments, _quaternion(vectors)


def _quaternion(turn: Array) -> Array:
    """Quaternion (x, y, z, w) of a matrix that turns, w >= 0.

    It is the eigenvector of the largest eigenvalue of a symmetric matrix (Bar-Itzhack 2000).
    """
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = turn
    symmetric = np.array(
        [
            [xx - yy - zz, xy + yx, xz + zx, zy - yz],
            [xy + yx, yy - xx - zz, yz + zy, xz - zx],
            [xz + zx, yz + zy, zz - xx - yy, yx - xy],
            [zy - yz, xz - zx, yx - xy, xx + yy + zz],
        ]
    )
    found = np.linalg.eigh(symmetric)[1][:, -1]
    return np.asarray(found if found[3] >= 0.0 else -found)
