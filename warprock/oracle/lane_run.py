"""What the oracle's runs share: roots; of single blocks also the clock, events and solves."""

from __future__ import annotations

import abc
import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, minimize_scalar

from warprock.model.response import SampleTimes, Status
from warprock.oracle.block_mechanics import Vector

Array = npt.NDArray[np.float64]

ABSOLUTE_TOLERANCE = 1e-14
"""Absolute tolerance of tilt [rad] and tilt rate [rad/s]."""
IMPACT_LIMIT = 100_000
"""Impacts after which a run stops with `Status.EVENT_LIMIT`."""
LOOKS = np.linspace(0.0, 1.0, 9)
"""Parts of a step at which the contact force is looked at."""


ROOT_TOLERANCE = 4.0 * float(np.finfo(np.float64).eps)
"""Relative tolerance of a root, the smallest that `brentq` takes."""


def root_between(function: Callable[[float], float], low: float, high: float) -> float:
    """A root between two times; the nearer end if round-off hides the change of sign."""
    at_low, at_high = function(low), function(high)
    if at_low * at_high > 0.0:
        return low if abs(at_low) < abs(at_high) else high
    found: float = brentq(function, low, high, xtol=1e-300, rtol=ROOT_TOLERANCE)
    return found


def friction_for(force: Vector) -> float:
    """Friction that a force or an impulse of the base needs; infinite where it pulls."""
    along, upwards = force
    return abs(along) / upwards if upwards > 0.0 else math.inf


def ends_at(function: Callable[..., float], kind: str, what: Any = None) -> Any:
    """An event of `solve_ivp` that ends it where a function falls to zero.

    Args:
        function: Of the time [s] and the state.
        kind: What happens there.
        what: To which point or tie.
    """

    def event(time: float, state: Array) -> float:
        return float(function(time, state))

    event.terminal, event.direction = True, -1.0  # type: ignore[attr-defined]
    event.kind, event.what = kind, what  # type: ignore[attr-defined]
    return event


def looks_in(found: Any) -> Array:
    """Times at which a solution is looked at: `LOOKS` in each of its steps [s]."""
    return np.unique(found.t[:-1, None] + LOOKS * np.diff(found.t)[:, None])


class LaneRun(abc.ABC):
    """One lane's run: the clock and what has happened so far.

    Attributes:
        fall_tilt: Tilt from which on the block falls whatever its contact does [rad].
    """

    fall_tilt = math.inf

    def __init__(self, times: SampleTimes, rtol: float) -> None:
        """Starts the clock.

        Args:
            times: Duration and sampling.
            rtol: Relative tolerance of DOP853.
        """
        self.times, self.duration, self.rtol = times.times, times.duration, rtol
        self.rotation = np.full(len(self.times), np.nan)
        self.filled, self.evaluations, self.time = 0, 0, 0.0
        self.overturned, self.status = False, Status.OK
        self.peak, self.peak_time, self.friction_needed = 0.0, 0.0, 0.0
        self.impacts: list[float] = []
        self.uplift_time, self.rest_time = math.nan, 0.0
        self.acceleration: Callable[[float], Vector] = lambda _time: (0.0, 0.0)

    def _fill(self, stop: float, rotation: Callable[[Array], Array]) -> None:
        """Fills the samples up to a time from a function of times."""
        end = int(np.searchsorted(self.times, stop, side="right"))
        if end > self.filled:
            self._take_samples(slice(self.filled, end), rotation(self.times[self.filled : end]))
            self.filled = end

    def _take_samples(self, part: slice, values: Array) -> None:
        self.rotation[part] = values

    def _note_peak(self, time: float, tilt: float) -> None:
        if tilt > self.peak:
            self.peak, self.peak_time = tilt, time

    def _note_uplift(self, time: float) -> None:
        self.rest_time = math.nan
        if math.isnan(self.uplift_time):
            self.uplift_time = time

    def _note_impact(self) -> None:
        self.impacts.append(self.time)
        if len(self.impacts) >= IMPACT_LIMIT:
            self.status = Status.EVENT_LIMIT

    def _need(self, friction: float) -> None:
        self.friction_needed = max(self.friction_needed, friction)

    def _falls(self, tilt: float, rate: float) -> bool:
        """Whether the block falls whatever its contact does: that is not judged."""
        return tilt >= self.fall_tilt and rate >= 0.0

    def _look_at(self, needed: Callable[[float], float], times: Sequence[float]) -> None:
        """Notes the largest friction that is needed at some times, and at the crest among them."""
        looks = [needed(time) for time in times]
        at = int(np.argmax(looks))
        self._need(looks[at])
        if 0 < at < len(times) - 1 and looks[at] < math.inf:
            most = 1e3 * looks[at]
            top = minimize_scalar(
                lambda time: -min(needed(time), most),
                bounds=(times[at - 1], times[at + 1]),
                method="bounded",
            )
            self._need(-float(top.fun))

    @abc.abstractmethod
    def _derivative(self, time: float, state: npt.NDArray[Any]) -> Any:
        """Rates of the state."""

    def _solved(self, state: Any, stop: float, longest: float, events: Any = None) -> Any:
        """SciPy's DOP853 from a state at the present time, with steps up to a longest one [s]."""
        found = solve_ivp(
            self._derivative,
            (self.time, stop),
            state,
            method="DOP853",
            rtol=self.rtol,
            atol=ABSOLUTE_TOLERANCE,
            max_step=longest,
            events=events,
            dense_output=True,
        )
        self.evaluations += found.nfev
        return found
