"""A box that rolls about one of its corners, which stays where it is: SciPy, from mechanics alone.

Angular momentum about the corner changes by the moment of the weight and of what a moving base
takes: dL/dt = a x m (g - a_base), a from the corner to the centre of mass; the angular velocity is
I^-1 L with the inertia of the box about that corner, the attitude a rotation matrix R' = [w] R.
No formula is shared with the kernels.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]


def rolled(
    size: tuple[float, float, float],
    corner: tuple[int, int],
    lean: tuple[float, float],
    times: Array,
    base: Callable[[float], Array] = lambda _time: np.zeros(3),
    yaw: float = 0.0,
) -> tuple[Array, Array, float]:
    """Axis of a box that starts at rest, leaning about one of its lower corners.

    Args:
        size: Full width, depth and height [m].
        corner: Signs of the corner along the width and the depth.
        lean: Rotation towards its own +x and +y, about an axis in its bottom face [rad].
        times: Times at which its axis is told [s], from 0 on.
        base: Acceleration of the base [m/s^2] at a time.
        yaw: Turn about the vertical before [rad].

    Returns:
        Axis, shape [time, 3]; heights of the four lower corners above the pivot [m], shape
        [time, 4]; the largest part of the energy that got lost, on a base that stands still.
    """
    width, depth, height = size
    inertia = np.diag([depth**2 + height**2, width**2 + height**2, width**2 + depth**2]) / 12.0
    arm = 0.5 * np.array([-corner[0] * width, -corner[1] * depth, height])
    about = inertia + arm @ arm * np.eye(3) - np.outer(arm, arm)
    turn = Rotation.from_euler("z", yaw) * Rotation.from_rotvec([-lean[1], lean[0], 0.0])

    def change(time: float, state: Array) -> Array:
        attitude, momentum = state[:9].reshape(3, 3), state[9:]
        spin = attitude @ np.linalg.solve(about, attitude.T @ momentum)
        pull = np.array([0.0, 0.0, -GRAVITY]) - base(time)
        turning = np.cross(spin, attitude, axisb=0, axisc=0)
        return np.concatenate([turning.ravel(), np.cross(attitude @ arm, pull)])

    start = np.concatenate([turn.as_matrix().ravel(), np.zeros(3)])
    span = (0.0, float(times[-1]))
    found = solve_ivp(change, span, start, "DOP853", times, rtol=1e-12, atol=1e-14)
    attitudes = found.y[:9].T.reshape(-1, 3, 3)
    momenta = found.y[9:].T
    spins = np.linalg.solve(about, np.einsum("tji,tj->ti", attitudes, momenta)[..., None])[..., 0]
    energy = 0.5 * np.einsum("ti,ij,tj->t", spins, about, spins)
    energy += GRAVITY * (attitudes @ arm)[:, 2]
    signs = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])
    beside = 0.5 * np.array([width, depth]) * (signs - np.array(corner))
    gaps = (attitudes[:, :, :2] @ beside.T)[:, 2]
    return attitudes[:, :, 2], gaps, float(np.max(np.abs(energy / energy[0] - 1.0)))
