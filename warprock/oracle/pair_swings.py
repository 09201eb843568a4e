"""The event loop of the two-block oracle: from knot to knot of the motion, event by event.

Rules and accuracy are told in `warprock.oracle.pair`.
"""

from __future__ import annotations

import enum
import functools
import itertools
import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.integrate import DOP853

from warprock.model.motion import Segment
from warprock.model.response import SampleTimes, Status
from warprock.oracle.lane_run import root_between
from warprock.oracle.pair_mechanics import (
    INTERFACE,
    REST,
    Pair,
    Pattern,
    StackMechanics,
    opening,
)

Array = npt.NDArray[np.float64]

ABSOLUTE_TOLERANCE = 1e-13
"""Absolute tolerance of rotations [rad] and rates [rad/s]."""
LOOKS = 8
"""Looks at the closed contacts in a step."""
SHORTEST_STEP = 1e-9
"""How far a smooth transition is overstepped [s]."""
TOUCHING = 1e-14
"""Gap [rad] below which a second contact that closes takes part in an impact."""
REST_ROTATION_RATIO = 1e-9
"""Threshold of the rest rule, a part of the slenderness angle."""
EVENT_LIMIT = 20_000
"""Impacts and transitions after which a run stops with `Status.EVENT_LIMIT`."""


class StackOutcome(enum.IntEnum):
    """Where the two blocks are at the end; a stack that overturns as one is its lower block."""

    AT_REST = 0
    ROCKING = 1
    UPPER_OVERTURNED = 2
    LOWER_OVERTURNED = 3


def _component(states: Callable[[float], Array], index: int, time: float) -> float:
    """One component of a state at a time."""
    return float(states(time)[index])


class _Event(NamedTuple):
    """What ends a step: contact is the one that closes; None for a transition or an overturning."""

    time: float
    contact: int | None


class _Step(NamedTuple):
    """A step of the integrator; states are (rotations, rates), shape [4]."""

    begin: float
    before: Array
    end: float
    after: Array
    dense: Callable[[float], Array]


class StackRun:
    """One stack under one motion: the state and what has happened so far."""

    def __init__(
        self, mechanics: StackMechanics, times: SampleTimes, rtol: float, longest_step: float
    ) -> None:
        self.mechanics, self.duration = mechanics, times.duration
        self.rtol, self.longest_step = rtol, longest_step
        self.times = times.times
        self.rotation = np.full((2, len(self.times)), np.nan)
        self.filled = 0
        self.time, self.state, self.pattern = 0.0, np.zeros(4), REST
        self.peak, self.peak_time = np.zeros(2), np.zeros(2)
        self.pattern_times: list[float] = []
        self.patterns: list[Pattern] = []
        self.impacts: list[float] = []
        self.energy_lost, self.odd_choices, self.evaluations, self.events = 0.0, 0, 0, 0
        self.pull_time = math.nan
        self.status = Status.OK
        self.outcome: StackOutcome | None = None
        self.base: Callable[[float], float] = lambda _time: 0.0

    def start(self, rotation: Pair) -> None:
        """Releases the blocks at rest."""
        first, second = rotation
        self.state = np.array((first, second, 0.0, 0.0))
        self.pattern = Pattern(int(np.sign(first)), int(np.sign(second - first)))
        self._note_peak(0.0, self.state)
        self._note_pattern()

    def follow(self, segment: Segment) -> None:
        """Follows one segment of the motion."""
        stop = min(segment.stop, self.duration)
        self.base = segment.acceleration
        if segment.velocity_step != 0.0:
            self._shock(self._closed(), segment.velocity_step)
        self._regrip()
        while self.time < stop and self.outcome is None and self.status == Status.OK:
            if self.pattern == REST:
                self._wait(stop)
            else:
                self._swing(stop)
        self._note_peak(self.time, self.state)

    # State.

    def _closed(self) -> tuple[bool, bool]:
        return self.pattern.ground == 0, self.pattern.interface == 0

    def _gaps(self, state: Array) -> tuple[Pair, Pair]:
        """Gaps of the two contacts [rad] and their rates [rad/s]; zero at a closed one."""
        return opening(self.pattern, state[:2]), opening(self.pattern, state[2:])

    def _note_pattern(self) -> None:
        if not self.patterns or self.patterns[-1] != self.pattern:
            self.pattern_times.append(self.time)
            self.patterns.append(self.pattern)

    def _note_peak(self, time: float, state: Array) -> None:
        for block in (0, 1):
            if abs(state[block]) > self.peak[block]:
                self.peak[block], self.peak_time[block] = abs(state[block]), time

    def _note_pull(self, pulls: bool) -> None:
        if pulls and math.isnan(self.pull_time):
            self.pull_time = self.time

    def _fill(self, stop: float, values: Callable[[float], Array]) -> None:
        """Fills the histories up to a time from a function of time."""
        while self.filled < len(self.times) and self.times[self.filled] <= stop:
            self.rotation[:, self.filled] = values(float(self.times[self.filled]))[:2]
            self.filled += 1

    def _pulls(self) -> tuple[bool, bool]:
        place, rate = self.state[:2], self.state[2:]
        _, reaction = self.mechanics.accelerations(self.pattern, place, rate, self.base(self.time))
        return self.mechanics.pulls(place, reaction)

    # Contacts that close and open.

    def _regrip(self) -> None:
        """Lets the forces of this moment open closed contacts."""
        choice = self.mechanics.after_force(
            self.pattern, self.state[:2], self.state[2:], self.base(self.time)
        )
        self.odd_choices += choice.admissible_count != 1
        self.pattern = choice.pattern
        self._note_pull(choice.pulls)
        self._note_pattern()

    def _shock(self, closed: tuple[bool, bool], velocity_step: float) -> float:
        """An impact or a velocity step at touching contacts; the energy that it costs [J]."""
        place, rate = self.state[:2], self.state[2:]
        energy = self.mechanics.kinetic_energy(self.pattern, place, rate)
        choice = self.mechanics.after_impulse(self.pattern, place, rate, closed, velocity_step)
        self.odd_choices += choice.admissible_count != 1
        self._note_pull(choice.pulls)
        self.pattern, self.state = choice.pattern, np.concatenate((place, choice.motion))
        self._settle(closed)
        energy -= self.mechanics.kinetic_energy(self.pattern, place, self.state[2:])
        return energy

    def _settle(self, closed: tuple[bool, bool]) -> None:
        """The rest rule: closes touching contacts that open too slowly to count."""
        place, rate = self.state[:2], self.state[2:]
        base = self.base(self.time)
        bend, _ = self.mechanics.accelerations(self.pattern, place, rate, base)
        (_, speeds), bends = self._gaps(self.state), opening(self.pattern, bend)
        small = []
        for k in (0, 1):
            limit = REST_ROTATION_RATIO * self.mechanics.slenderness_angle[k]
            opened = closed[k] and self.pattern[k] != 0
            if opened and bends[k] < 0.0 and speeds[k] ** 2 < -2.0 * bends[k] * limit:
                small.append(k)
        for part in (small, small[:1], small[1:]):
            shut = Pattern(*(0 if k in part else s for k, s in enumerate(self.pattern)))
            slow = self.mechanics.projected(self.pattern, shut, place, rate)
            kept = self.mechanics.after_force(shut, place, slow, base)
            if shut != self.pattern and kept.pattern == shut and kept.admissible_count == 1:
                self.pattern, self.state = shut, np.concatenate((place, slow))
                return

    def _impact(self, contact: int) -> None:
        """A contact closes: its gap is exactly zero, and what moves on is decided."""
        gaps, speeds = self._gaps(self.state)
        closed = tuple(
            s == 0 or k == contact or (gaps[k] <= TOUCHING and speeds[k] < 0.0)
            for k, s in enumerate(self.pattern)
        )
        if closed[0]:
            self.state[1] = 0.0 if self.pattern.interface == 0 else self.state[1]
            self.state[0] = 0.0
        if closed[INTERFACE]:
            self.state[1] = self.state[0]
        self._note_peak(self.time, self.state)
        self.impacts.append(self.time)
        self.energy_lost += self._shock((closed[0], closed[1]), 0.0)
        self._regrip()
        self._count_event()

    def _count_event(self) -> None:
        self.events += 1
        if self.events >= EVENT_LIMIT:
            self.status = Status.EVENT_LIMIT

    # From event to event.

    def _margin(self, time: float, state: Array) -> float:
        """The smallest margin of the closed contacts [N m]; negative if one has to open."""
        bend = self.mechanics.accelerations(self.pattern, state[:2], state[2:], self.base(time))
        return float(self.mechanics.margins(self.pattern, state[:2], bend[1]).min())

    def _failing(self, begin: float, end: float, states: Callable[[float], Array]) -> float:
        """First time at which a closed contact has to open [s]; NaN if none is seen."""
        if 0 not in self.pattern:
            return math.nan
        looks = np.linspace(begin, end, LOOKS + 1).tolist()
        for low, high in itertools.pairwise(looks):
            if self._margin(high, states(high)) < 0.0:
                return root_between(lambda time: self._margin(time, states(time)), low, high)
        return math.nan

    def _wait(self, stop: float) -> None:
        """Keeps both blocks at rest until a contact opens, or until `stop`."""
        end = min(stop, self.time + self.longest_step)
        lift = self._failing(self.time, end, lambda _time: self.state)
        self.time = end if math.isnan(lift) else min(lift + SHORTEST_STEP, end)
        self._fill(self.time, lambda _time: self.state)
        if not math.isnan(lift):
            self._count_event()
            self._regrip()

    def _derivative(self, time: float, state: npt.NDArray[Any]) -> npt.NDArray[Any]:
        bend, _ = self.mechanics.accelerations(self.pattern, state[:2], state[2:], self.base(time))
        return np.concatenate((state[2:], bend))

    def _solver(self, time: float, state: Array, stop: float, first: float) -> DOP853:
        return DOP853(
            self._derivative,
            time,
            state,
            stop,
            rtol=self.rtol,
            atol=ABSOLUTE_TOLERANCE,
            first_step=min(first, stop - time),
            max_step=self.longest_step,
        )

    def _state_at(self, time: float, state: Array, stop: float) -> Array:
        """The state at `stop`, integrated again from a step's start."""
        if not stop > time:
            return state.copy()
        solver = self._solver(time, state, stop, stop - time)
        while solver.status == "running":
            solver.step()
        self.evaluations += solver.nfev
        found: Array = solver.y.copy()
        return found

    def _swing(self, stop: float) -> None:
        """Integrates until the next event or `stop`."""
        gaps, speeds = self._gaps(self.state)
        for k in (0, 1):
            if gaps[k] <= 0.0 and speeds[k] < 0.0:
                self._impact(k)
                return
        solver = self._solver(self.time, self.state, stop, self._first_step(stop))
        while solver.status == "running":
            begin, before = solver.t, solver.y.copy()
            failure = solver.step()
            if failure is not None or not np.all(np.isfinite(solver.y)):
                self.status = Status.NONFINITE
                break
            step = _Step(begin, before, solver.t, solver.y.copy(), solver.dense_output())
            event = self._event(step)
            self._note_turns(step, step.end if event is None else event.time)
            self._fill(step.end if event is None else event.time, step.dense)
            if event is not None:
                self._take(step, event)
                break
            self.time, self.state = step.end, step.after
            self._note_pull(any(self._pulls()))
        self.evaluations += solver.nfev

    def _first_step(self, stop: float) -> float:
        """A step that ends before a gap that is about to open comes near to closing again."""
        first = min(self.longest_step, stop - self.time)
        gaps, speeds = self._gaps(self.state)
        bends = opening(self.pattern, self._derivative(self.time, self.state)[2:])
        fresh = [k for k in (0, 1) if self.pattern[k] != 0 and gaps[k] <= 0.0]
        for k in fresh:
            if bends[k] < 0.0 < speeds[k]:
                first = min(first, 2.02 * speeds[k] / -bends[k])
        lifted = [k for k in fresh if speeds[k] == 0.0]
        while lifted and first > SHORTEST_STEP:
            gaps, speeds = self._gaps(self._state_at(self.time, self.state, self.time + first))
            if all(gaps[k] > 0.0 and speeds[k] > 0.0 for k in lifted):
                break
            first *= 0.25
        return first

    def _event(self, step: _Step) -> _Event | None:
        """The first event of a step."""
        found = [
            _Event(time, contact)
            for contact in (0, 1)
            if not math.isnan(time := self._closing(step, contact))
        ]
        lift = self._failing(step.begin, step.end, step.dense)
        if not math.isnan(lift):
            found.append(_Event(min(lift + SHORTEST_STEP, step.end), None))
        for block in (0, 1):
            if abs(step.after[block]) >= 0.5 * math.pi:
                found.append(_Event(self._falling(step, block), None))
        return min(found, key=lambda event: event.time, default=None)

    def _falling(self, step: _Step, block: int) -> float:
        """Time at which a block has overturned [s]."""
        return root_between(
            lambda time: abs(float(step.dense(time)[block])) - 0.5 * math.pi, step.begin, step.end
        )

    def _closing(self, step: _Step, contact: int) -> float:
        """Time at which an open contact closes in a step [s]; NaN if it does not."""
        if self.pattern[contact] == 0:
            return math.nan
        speed = self._gaps(step.before)[1][contact]
        (gap_end, speed_end) = (pair[contact] for pair in self._gaps(step.after))

        def gap_at(time: float) -> float:
            return self._gaps(step.dense(time))[0][contact]

        low, high = step.begin, step.end
        if speed * speed_end < 0.0:
            turn = root_between(lambda time: self._gaps(step.dense(time))[1][contact], low, high)
            if speed > 0.0:
                low = turn
            elif gap_at(turn) <= 0.0:
                high, gap_end = turn, 0.0
        return math.nan if gap_end > 0.0 else root_between(gap_at, low, high)

    def _note_turns(self, step: _Step, stop: float) -> None:
        """Counts the turning points of a step up to a time as candidates for the peaks."""
        for rate in (2, 3):
            if step.before[rate] * step.after[rate] < 0.0:
                turn = root_between(
                    functools.partial(_component, step.dense, rate), step.begin, step.end
                )
                if turn <= stop:
                    self._note_peak(turn, step.dense(turn))

    def _take(self, step: _Step, event: _Event) -> None:
        """Brings the state to an event and lets it happen."""
        time = event.time
        self.state = self._state_at(step.begin, step.before, time)
        if event.contact is not None:
            for _ in range(2):
                gaps, speeds = self._gaps(self.state)
                if speeds[event.contact] >= 0.0 or abs(gaps[event.contact]) <= TOUCHING:
                    break
                time = max(step.begin, time - gaps[event.contact] / speeds[event.contact])
                self.state = self._state_at(step.begin, step.before, time)
        self.time = time
        if event.contact is not None:
            self._impact(event.contact)
            return
        fallen = np.abs(self.state[:2]) >= 0.5 * math.pi - 1e-9
        if fallen.any():
            self.outcome = StackOutcome(3 if fallen[0] else 2)
            self._note_peak(self.time, self.state)
            self._fill(math.inf, lambda _time: self.state)
            return
        self._count_event()
        self._regrip()
