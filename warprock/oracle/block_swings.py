"""The event loop of the oracle: one block from knot to knot of the motion, swing by swing.

Rules and accuracy are told in `warprock.oracle.block`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.integrate import DOP853
from scipy.optimize import minimize_scalar

from warprock.model.response import SampleTimes, Status
from warprock.oracle.block_base import BaseSegment
from warprock.oracle.block_mechanics import PivotingBlock
from warprock.oracle.lane_run import ABSOLUTE_TOLERANCE, LaneRun, friction_for, root_between

Array = npt.NDArray[np.float64]

REST_ROTATION_RATIO = 1e-9
"""Threshold of the rest rule, a part of the slenderness angle."""
FIRST_STEP = 0.1
"""Longest first step of a swing [s]; DOP853 chooses the others itself."""
SHORTEST_STEP = 1e-9
"""A first step this short [s] that does not lift the block shows that it has not lifted."""


class BlockRun(LaneRun):
    """One lane's run: the state and what has happened so far.

    Attributes:
        looks: Looks at the contact force in a step of DOP853; the largest one is then refined.
    """

    looks = 6

    def __init__(
        self, block: PivotingBlock, times: SampleTimes, rtol: float, friction: float
    ) -> None:
        """Puts the block flat on the base.

        Args:
            block: The block's mechanics.
            times: Duration and sampling.
            rtol: Relative tolerance of DOP853.
            friction: Of the contact, which only says from where on a fall is not judged.
        """
        super().__init__(times, rtol)
        self.fall_tilt = block.critical_tilt + math.atan(min(friction, 1.0))
        self.block, self.flat = block, True
        self.side, self.tilt, self.rate = 1, 0.0, 0.0
        self.energy_lost, self.step_hint = 0.0, math.inf

    @property
    def laid(self) -> float:
        """Tilt at which a block lies on its side [rad]."""
        return 0.5 * math.pi

    def start(self, rotation: float) -> None:
        """Releases the block from a rotation [rad] at rest."""
        if rotation != 0.0:
            self._leave(0.0, 1 if rotation > 0.0 else -1, 0.0)
            self.tilt = abs(rotation)
            self._note_peak(0.0, self.tilt)
        self._fill(0.0, lambda times: np.full(len(times), rotation))

    def follow(self, segment: BaseSegment, scan: float) -> None:
        """Follows one segment of the motion; `scan` is the time between looks at rest [s]."""
        stop = min(segment.stop, self.duration)
        self.acceleration = segment.acceleration
        if any(segment.velocity_step):
            step, sides = segment.velocity_step, (1, -1) if self.flat else (self.side,)
            side = max(sides, key=lambda each: self.block.rate_step(each, self.tilt, step))
            change = self.block.rate_step(side, self.tilt, step)
            if self.flat and not self._settles(self.time, change):
                self._leave(self.time, side, 0.0)
            if not self.flat and not self._falls(self.tilt, self.rate):
                impulse = self.block.step_impulse(self.side, self.tilt, segment.velocity_step)
                self._need(friction_for(impulse))
            self.rate += 0.0 if self.flat else change
        while self.time < stop and not self.overturned and self.status == Status.OK:
            if self.flat:
                self._wait(stop, scan)
            else:
                self._swing(stop)

    def _lifting(self, time: float) -> float:
        """The larger tilt acceleration of the flat block about its two corners [rad/s^2]."""
        base = self.acceleration(time)
        return max(self.block.tilt_acceleration(side, 0.0, base) for side in (1, -1))

    def _settles(self, time: float, rate: float) -> bool:
        """The rest rule: whether a swing from flat at a tilt rate [rad/s] is too small to count."""
        bend = self._lifting(time)
        limit = REST_ROTATION_RATIO * self.block.critical_tilt
        return rate <= 0.0 or (bend < 0.0 and rate * rate < -2.0 * bend * limit)

    def _leave(self, time: float, side: int, rate: float) -> None:
        self.flat, self.side, self.tilt, self.rate = False, side, 0.0, rate
        self._note_uplift(time)

    def _judge(self, dense: Callable[[Any], Array], begin: float, end: float) -> None:
        """Notes the friction that the contact needs in a part of a step."""

        def needed(time: float, tilt: float, rate: float) -> float:
            if self._falls(tilt, rate):
                return 0.0
            base = self.acceleration(time)
            return friction_for(self.block.contact_force(self.side, tilt, rate, base))

        grid = np.linspace(begin, end, self.looks + 1).tolist()
        found = [
            needed(time, *state) for time, state in zip(grid, dense(grid).T.tolist(), strict=True)
        ]
        top = int(np.argmax(found))
        if found[top] > 0.98 * self.friction_needed and math.isfinite(found[top]):
            low, high = grid[max(top - 1, 0)], grid[min(top + 1, self.looks)]
            best = minimize_scalar(
                lambda time: -needed(time, *dense(time).tolist()),
                bounds=(low, high),
                method="bounded",
            )
            self._need(-float(best.fun))
        self._need(found[top])

    def _wait(self, stop: float, scan: float) -> None:
        """Keeps the block flat until an overturning moment lifts it, or until `stop`."""
        count = max(1, math.ceil((stop - self.time) / scan))
        grid = np.linspace(self.time, stop, count + 1).tolist()
        lift = self._lift_time(grid)
        self.time = stop if math.isnan(lift) else lift
        self._fill(self.time, np.zeros_like)
        if not math.isnan(lift):
            base = self.acceleration(lift)
            side = max((1, -1), key=lambda s: self.block.tilt_acceleration(s, 0.0, base))
            self._leave(lift, side, 0.0)

    def _lift_time(self, grid: list[float]) -> float:
        """First time at which an overturning moment lifts the flat block [s]; NaN if none.

        Looks at every time of the grid, and between its neighbours around every local maximum.
        """
        values = [-math.inf, self._lifting(grid[0])]
        if values[1] > 0.0:
            return grid[0]
        for index in range(len(grid)):
            last = index == len(grid) - 1
            values.append(-math.inf if last else self._lifting(grid[index + 1]))
            low, high = grid[max(index - 1, 0)], grid[min(index + 1, len(grid) - 1)]
            top = grid[index] if last else high
            peaked = max(values[0], values[2]) <= values[1] > min(values[0], values[2])
            if values[2] <= 0.0 and len(grid) > 2 and peaked:
                top = float(
                    minimize_scalar(
                        lambda time: -self._lifting(time), bounds=(low, high), method="bounded"
                    ).x
                )
            if self._lifting(top) > 0.0:
                return root_between(self._lifting, low, top)
            values = values[1:]
        return math.nan

    def _derivative(self, time: float, state: npt.NDArray[Any]) -> npt.NDArray[Any]:
        base = self.acceleration(time)
        rate = float(state[1])
        bend = self.block.tilt_acceleration(self.side, float(state[0]), base, rate)
        return np.array((rate, bend))

    def _solver(self, time: float, state: Array, stop: float, first: float) -> DOP853:
        return DOP853(
            self._derivative,
            time,
            state,
            stop,
            rtol=self.rtol,
            atol=ABSOLUTE_TOLERANCE,
            first_step=min(first, stop - time),
        )

    def _state_at(self, time: float, state: Array, stop: float) -> Array:
        """The state at `stop`, integrated again from a step's start."""
        if not stop > time:
            return state
        solver = self._solver(time, state, stop, stop - time)
        while solver.status == "running":
            solver.step()
        self.evaluations += solver.nfev
        found: Array = solver.y
        return found

    def _swing(self, stop: float) -> None:
        """Integrates one swing until its impact, overturning or `stop`."""
        if self.tilt <= 0.0 and self.rate < 0.0:
            self._impact(self.time, self.rate)
            return
        first = self._first_step(stop)
        if first == 0.0:
            # Round-off took the block for lifted.
            self.flat, self.rest_time = True, self.time
            self.time = min(self.time + SHORTEST_STEP, stop)
            return
        solver = self._solver(self.time, np.array([self.tilt, self.rate]), stop, first)
        while solver.status == "running":
            begin, before = solver.t, solver.y
            failure = solver.step()
            if failure is not None or not np.all(np.isfinite(solver.y)):
                self.status = Status.NONFINITE
                break
            if self._event(solver, begin, before):
                break
            self.step_hint = solver.h_abs
            self.time, (self.tilt, self.rate) = solver.t, solver.y.tolist()
        self.evaluations += solver.nfev

    def _first_step(self, stop: float) -> float:
        """The step that the last swing ended with, or the whole of a short swing."""
        base = self.acceleration(self.time)
        bend = self.block.tilt_acceleration(self.side, self.tilt, base, self.rate)
        flight = 2.02 * self.rate / -bend if bend < 0.0 < self.rate else math.inf
        step = min(self.step_hint, flight, stop - self.time, FIRST_STEP)
        while self.tilt == 0.0 and self.rate == 0.0:
            # A block that has just lifted: a first step that ends before it comes back.
            if step < SHORTEST_STEP:
                return 0.0
            tilt, rate = self._state_at(self.time, np.zeros(2), self.time + step).tolist()
            if tilt > 0.0 and rate > 0.0:
                break
            step *= 0.25
        return step

    def _event(self, solver: DOP853, begin: float, before: Array) -> bool:
        """Handles what happened in a step; True if the swing is over."""
        end, after = solver.t, solver.y
        turned = before[1] * after[1] < 0.0 or (before[1] == 0.0 and after[1] < 0.0)
        dense = solver.dense_output()
        turn = begin
        extreme = before[0]
        if turned and before[1] != 0.0:
            turn = root_between(lambda time: float(dense(time)[1]), begin, end)
            extreme = self._state_at(begin, before, turn)[0]
        over = turned and before[1] > 0.0 and extreme >= self.laid
        low = turned and before[1] < 0.0 and extreme <= 0.0
        if over or after[0] >= self.laid:
            top = turn if over else end
            fall = root_between(lambda time: float(dense(time)[0]) - self.laid, begin, top)
            self._judge(dense, begin, fall)
            self._fill_swing(fall, dense)
            self._overturn(fall)
            return True
        if turned and before[1] >= 0.0:
            self._note_peak(turn, float(extreme))
        if low or after[0] <= 0.0:
            first, last = (begin, turn) if low else (turn, end)
            time, rate = self._touch(dense, (begin, before), first, last)
            self._judge(dense, begin, time)
            self._fill_swing(time, dense)
            self._impact(time, rate)
            return True
        self._judge(dense, begin, end)
        self._fill_swing(end, dense)
        return False

    def _fill_swing(self, stop: float, dense: Callable[[Array], Array]) -> None:
        self._fill(stop, lambda times: self.side * dense(times)[0])

    def _touch(
        self, dense: Callable[[float], Array], step: tuple[float, Array], low: float, high: float
    ) -> tuple[float, float]:
        """Time [s] at which the free corner meets the base, and the tilt rate [rad/s] then."""
        height, speed = self.block.corner_height, self.block.corner_speed
        time = root_between(lambda t: height(self.side, float(dense(t)[0])), low, high)
        begin, before = step
        for _ in range(2):
            tilt, rate = self._state_at(begin, before, time).tolist()
            falling = speed(self.side, tilt, rate)
            if falling >= 0.0:
                break
            time = min(max(time - height(self.side, tilt) / falling, low), high)
        return time, rate

    def _overturn(self, time: float) -> None:
        self.time, self.tilt, self.rate, self.overturned = time, self.laid, 0.0, True
        self._note_peak(time, self.tilt)
        self._fill(math.inf, lambda times: np.full(len(times), self.side * self.tilt))

    def _impact(self, time: float, rate: float) -> None:
        """The free corner meets the base: pivot on it, or rest."""
        self.time, self.tilt = time, 0.0
        self._note_impact()
        after = self.block.rate_after_impact(self.side, min(rate, 0.0))
        if rate < 0.0:
            self._need(friction_for(self.block.impact_impulse(self.side, rate, after)))
        if self._settles(time, after):
            self.flat, self.rest_time = True, time + self._tail(time, rate, after)
            after = 0.0
        self.energy_lost += self.block.kinetic_energy(rate) - self.block.kinetic_energy(after)
        self.side, self.rate = -self.side, after

    def _tail(self, time: float, before: float, after: float) -> float:
        """Time that the impacts left out by the rest rule would take [s].

        The swings alternate between the corners and shorten by the same ratio at each impact: a
        geometric series of pairs.
        """
        if after <= 0.0:
            return 0.0
        base, ratio = self.acceleration(time), after / -before
        first, second = (
            -2.0 / self.block.tilt_acceleration(side, 0.0, base) for side in (-self.side, self.side)
        )
        return after * (first + ratio * second) / (1.0 - ratio * ratio)

    def finish(self) -> None:
        """Counts where the run ends as a candidate for the peak."""
        if not self.flat and not self.overturned:
            self._note_peak(self.time, self.tilt)
