"""A box that rolls about one of its corners, or tumbles freely: SciPy, from mechanics alone.

Angular momentum about the fixed corner changes by the moment of the weight and of what a moving
base takes: dL/dt = a x m (g - a_base), a from the corner to the centre of mass; the angular
velocity is I^-1 L with the inertia of the box about that corner, the attitude a rotation matrix
R' = [w] R. In flight L about the centre of mass is constant. No formula is shared with the kernels.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np
import numpy.typing as npt
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]


@dataclasses.dataclass(frozen=True)
class Motion:
    """What a box does: attitudes [time, 3, 3] and angular velocities [time, 3] of unit mass."""

    size: tuple[float, float, float]
    attitudes: Array
    spins: Array

    @property
    def rotations(self) -> Array:
        """Rotations in the plane of rocking and across it [rad], shape [2, time]."""
        x, y, z = self.attitudes[:, :, 2].T
        return np.array([np.arctan2(x, z), np.arctan2(y, z)])

    def gaps(self, corner: tuple[int, int]) -> Array:
        """Least height of the other lower corners above one of them [m], shape [time]."""
        signs = [(sx, sy) for sx in (-1, 1) for sy in (-1, 1) if (sx, sy) != corner]
        ways = 0.5 * (np.array(signs) - np.array(corner)) * self.size[:2]
        return np.asarray((self.attitudes[:, 2, :2] @ ways.T).min(axis=1))

    def energy(self, corner: tuple[int, int]) -> Array:
        """Energy about a corner that stands still [J/kg], shape [time]."""
        about, arm = _about(self.size, corner)
        own = np.einsum("tji,tj->ti", self.attitudes, self.spins)
        turning = 0.5 * np.einsum("ti,ij,tj->t", own, about, own)
        return np.asarray(turning + GRAVITY * (self.attitudes @ arm)[:, 2])


def _inertia(size: tuple[float, float, float]) -> Array:
    width, depth, height = size
    return np.diag([depth**2 + height**2, width**2 + height**2, width**2 + depth**2]) / 12.0


def _about(size: tuple[float, float, float], corner: tuple[int, int]) -> tuple[Array, Array]:
    arm = 0.5 * np.array([-corner[0] * size[0], -corner[1] * size[1], size[2]])
    return _inertia(size) + arm @ arm * np.eye(3) - np.outer(arm, arm), arm


def _solved(
    inertia: Array, start: Array, momentum: Array, times: Array, moment: Callable[..., Array]
) -> tuple[Array, Array]:
    """Attitudes and angular velocities from an attitude and an angular momentum on."""

    def change(time: float, state: Array) -> Array:
        attitude = state[:9].reshape(3, 3)
        spin = attitude @ np.linalg.solve(inertia, attitude.T @ state[9:])
        turning = np.cross(spin, attitude, axisb=0, axisc=0)
        return np.concatenate([turning.ravel(), moment(time, attitude)])

    first = np.concatenate([start.ravel(), momentum])
    span = (float(times[0]), float(times[-1]))
    found = solve_ivp(change, span, first, "DOP853", times, rtol=1e-12, atol=1e-14).y
    attitudes = found[:9].T.reshape(-1, 3, 3)
    own = np.einsum("tji,jt->ti", attitudes, found[9:])
    return attitudes, np.einsum("tij,tj->ti", attitudes, np.linalg.solve(inertia, own.T).T)


def rolled(
    size: tuple[float, float, float],
    corner: tuple[int, int],
    lean: tuple[float, float],
    times: Array,
    base: Callable[[float], Array] = lambda _time: np.zeros(3),
    yaw: float = 0.0,
) -> Motion:
    """A box that starts at rest, leaning about one of its lower corners.

    Args:
        size: Full width, depth and height [m].
        corner: Signs of the corner along the width and the depth.
        lean: Rotation towards its own +x and +y, about an axis in its bottom face [rad].
        times: Times at which it is told [s], from 0 on.
        base: Acceleration of the base [m/s^2] at a time.
        yaw: Turn about the vertical before [rad].
    """
    about, arm = _about(size, corner)
    turn = Rotation.from_euler("z", yaw) * Rotation.from_rotvec([-lean[1], lean[0], 0.0])

    def moment(time: float, attitude: Array) -> Array:
        pull = np.array([0.0, 0.0, -GRAVITY]) - base(time)
        return np.asarray(np.cross(attitude @ arm, pull))

    return Motion(size, *_solved(about, turn.as_matrix(), np.zeros(3), times, moment))


def tumbled(start: Motion, times: Array) -> Motion:
    """A box that flies from the last state of another motion on, at the first of the times."""
    inertia, attitude, spin = _inertia(start.size), start.attitudes[-1], start.spins[-1]
    momentum = attitude @ inertia @ attitude.T @ spin
    nothing = np.zeros(3)
    return Motion(
        start.size, *_solved(inertia, attitude, momentum, times, lambda _time, _attitude: nothing)
    )
