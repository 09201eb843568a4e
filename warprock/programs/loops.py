"""Plain loops over Housner's equation, such as anyone may write: what a simulator has to beat.

Both are made for one scene, a block that rocks on a still base and neither slides nor flies, and
share nothing with our kernels. One hands a swing after the other to SciPy's `solve_ivp` with an
event at the impact; the other takes Runge-Kutta steps of fourth order and cuts them at impacts,
block by block, and is compiled by Numba where that is installed.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.integrate import solve_ivp

from warprock.programs.scene import missing

Array = npt.NDArray[np.float64]

ROOT_STEPS = 60
ROOT_TOLERANCE = 1e-12
"""Most steps of Newton's method to the time of an impact, and the change of that time at which it
ends. Where a swing is far shorter than the time step, each halves the way that is left."""

REST_RATE = 1e-9
"""Rate after an impact below which a block rests [rad/s]."""

PlainLoop = Callable[[Array, float, float, float, float, float, Array], None]


def _stepper(compiled: Callable[[Any], Any]) -> Any:
    """A step of fourth order of the block, compiled."""

    @compiled
    def moved(
        tilt: float, rate: float, alpha: float, square: float, step: float
    ) -> tuple[float, float]:
        """Tilt and rate after a step; the tilt is that to the side to which the block leans."""
        half = 0.5 * step
        bend_1 = -square * math.sin(alpha - tilt)
        rate_2 = rate + half * bend_1
        bend_2 = -square * math.sin(alpha - tilt - half * rate)
        rate_3 = rate + half * bend_2
        bend_3 = -square * math.sin(alpha - tilt - half * rate_2)
        rate_4 = rate + step * bend_3
        bend_4 = -square * math.sin(alpha - tilt - step * rate_3)
        tilt += step / 6.0 * (rate + 2.0 * rate_2 + 2.0 * rate_3 + rate_4)
        return tilt, rate + step / 6.0 * (bend_1 + 2.0 * bend_2 + 2.0 * bend_3 + bend_4)

    return moved


def plain_loop(compiled: Callable[[Any], Any]) -> PlainLoop:
    """The loop of Runge-Kutta steps.

    Args:
        compiled: What compiles a function, such as `numba.njit`; it may return it as it is.

    Returns:
        A function of the starts [rad], shape [lane], each let go from rest; the slenderness angle
        [rad], the squared frequency [1/s^2], the angular restitution, the time step [s], the time
        between two samples [s], and the rotations that it fills in [rad], shape [lane, sample].
    """
    moved = _stepper(compiled)

    @compiled
    def rock(
        starts: Array,
        alpha: float,
        square: float,
        restitution: float,
        step: float,
        interval: float,
        seen: Array,
    ) -> None:
        for lane in range(len(starts)):
            time, tilt, rate, side = 0.0, abs(starts[lane]), 0.0, 1.0
            if starts[lane] < 0.0:
                side = -1.0
            seen[lane, :] = 0.0
            seen[lane, 0] = starts[lane]
            sample, last = 1, seen.shape[1] - 1
            while sample <= last:
                taken = step
                after, rate_after = moved(tilt, rate, alpha, square, taken)
                struck = after <= 0.0
                if struck:
                    for _ in range(ROOT_STEPS):
                        change = after / rate_after
                        taken -= change
                        after, rate_after = moved(tilt, rate, alpha, square, taken)
                        if abs(change) < ROOT_TOLERANCE:
                            break
                while sample <= last and sample * interval <= time + taken:
                    # A cubic between the ends of the step.
                    s = (sample * interval - time) / taken
                    here = (1.0 + 2.0 * s) * tilt + s * taken * rate
                    there = (3.0 - 2.0 * s) * after - (1.0 - s) * taken * rate_after
                    seen[lane, sample] = side * ((1.0 - s) ** 2 * here + s * s * there)
                    sample += 1
                time += taken
                tilt, rate = after, rate_after
                if struck:
                    side, tilt, rate = -side, 0.0, -restitution * rate
                    if rate < REST_RATE:
                        break

    loop: PlainLoop = rock
    return loop


def numba_loop() -> PlainLoop:
    """The loop of Runge-Kutta steps, compiled by Numba.

    Raises:
        ImportError: Numba is not installed; one line that says how to install it.
    """
    try:
        import numba
    except ImportError as error:
        raise missing("numba", "pip install numba", error) from None
    return plain_loop(numba.njit)


def scipy_loop(
    start: float,
    alpha: float,
    square: float,
    restitution: float,
    method: str,
    tolerance: float,
    times: Array,
) -> Array:
    """One block, a swing after the other in `solve_ivp`.

    Args:
        start: Rotation from which it is let go at rest [rad].
        alpha: Slenderness angle [rad].
        square: Squared frequency [1/s^2].
        restitution: Angular restitution.
        method: Name of a method of `solve_ivp`.
        tolerance: Its relative tolerance, and its absolute one over the slenderness angle.
        times: Times of the samples from 0 [s].

    Returns:
        Rotations at those times [rad].
    """

    def slope(_: float, state: Array) -> tuple[float, float]:
        return state[1], -square * math.sin(alpha - state[0])

    def impact(_: float, state: Array) -> float:
        return float(state[0])

    impact.terminal, impact.direction = True, -1.0  # type: ignore[attr-defined]
    seen, time = np.zeros(len(times)), 0.0
    state, side = np.array([abs(start), 0.0]), math.copysign(1.0, start)
    options: Any = {"method": method, "rtol": tolerance, "atol": tolerance * alpha}
    options["events"] = impact
    while time < times[-1]:
        asked = times[times >= time]
        found: Any = solve_ivp(slope, (time, times[-1]), state, t_eval=asked, **options)
        first = len(times) - len(asked)
        if len(found.t):
            seen[first : first + len(found.t)] = side * found.y[0]
        if found.status != 1:
            break
        time, rate = found.t_events[0][0], -restitution * found.y_events[0][0][1]
        if rate < REST_RATE:
            break
        state, side = np.array([0.0, rate]), -side
    return seen
