"""Rigid bodies in free flight: Euler's equations by SciPy, and what histories tell of turns."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.integrate import solve_ivp

from warprock.model.pose import product
from warprock.model.response import Response
from warprock.model.turning import inverse, rotate

Array = npt.NDArray[np.float64]


def attitudes(response: Response) -> Array:
    """Quaternions of its histories, shape [lane, sample, 4]."""
    return np.stack([response[f"attitude_{part}"] for part in "xyzw"], axis=-1)


def apart(one: Array, other: Array) -> Array:
    """Angles between attitudes [rad], shape [...]."""
    along = np.abs(np.sum(one * other, axis=-1))
    return np.asarray(2.0 * np.arccos(np.minimum(along, 1.0)))


def euler(attitude: Array, spin: Array, times: Array, inertia: Array) -> Array:
    """Attitudes of a free body by Euler's equations, from SciPy.

    Args:
        attitude: At the start.
        spin: Angular velocity then, in the axes of the base [rad/s].
        times: [s], shape [sample].
        inertia: Its tensor in the axes of the body, shape [3, 3].
    """

    def rate(_time: float, state: Array) -> Array:
        q, w = state[:4], state[4:]
        dq = 0.5 * product(q, np.append(w, 0.0))
        return np.concatenate([dq, -np.linalg.solve(inertia, np.cross(w, inertia @ w))])

    first = np.concatenate([attitude, rotate(inverse(attitude), spin)])
    found = solve_ivp(rate, (0.0, times[-1]), first, t_eval=times, rtol=1e-11, atol=1e-12).y.T
    return np.asarray(found[:, :4])
