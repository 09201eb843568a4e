"""The independent reference: one rocking block integrated by SciPy's DOP853, event by event.

It shares no formula with the kernels or with `warprock.rocking`: the mechanics come from vectors
(`warprock.reference.mechanics`), the integrator and the root finder from SciPy.

Physics (Housner 1963): the block never slides and never bounces; it pivots on a base corner
until the free corner meets the base, an impact without restitution normal to the base.

- Integration: `scipy.integrate.DOP853` (order 8, the stepper inside `solve_ivp`), restarted at
  every knot of the motion and at every event. Records are restarted at every sample, so that each
  interval between samples is as a rule one step over a smooth right-hand side.
- Impact, turning point and overturning are bracketed on a step's dense output; the step is then
  repeated from its start to the root and the root corrected by Newton's method. So an event's
  state has the accuracy of the integrator, not of the interpolation.
- Peaks are turning points, never samples.
- Rest rule: after an impact the block rests if the base acceleration would lift neither corner
  and the next swing, were the acceleration to stay, remained below `REST_ROTATION_RATIO` of the
  slenderness angle on either side. It lifts again at the root of the overturning moment, or at a
  velocity step.
- A velocity step of the base is an impulse at its knot; the corner in contact is kept.
- Overturning is |rotation| = pi/2; the rotation stays there.
"""

from __future__ import annotations

import concurrent.futures
import dataclasses
import math
import multiprocessing
from collections.abc import Callable

import numpy as np
import numpy.typing as npt
from scipy.integrate import DOP853
from scipy.optimize import brentq, minimize_scalar

from warprock.lanes import Lanes
from warprock.motion import GroundMotions, HarmonicMotions, RickerMotions, Segment
from warprock.reference.mechanics import PivotingBlock
from warprock.response import FIELDS, INTEGER_FIELDS, LANE_FIELDS, Outcome, Response
from warprock.response import SampleTimes, Status

Array = npt.NDArray[np.float64]

RELATIVE_TOLERANCE = 1e-12
"""Relative tolerance of DOP853; SciPy raises anything below 100 x round-off = 2.2e-14."""
ABSOLUTE_TOLERANCE = 1e-14
"""Absolute tolerance of tilt [rad] and tilt rate [rad/s]."""
REST_ROTATION_RATIO = 1e-9
"""Threshold of the rest rule, a part of the slenderness angle."""
IMPACT_LIMIT = 100_000
"""Impacts after which a run stops with `Status.EVENT_LIMIT`."""
ROOT_TOLERANCE = 4.0 * float(np.finfo(np.float64).eps)
"""Relative tolerance of a root, the smallest that `brentq` takes."""
SCANS_PER_PERIOD = 64
"""Looks at the overturning moment in a period of the motion while the block rests."""


@dataclasses.dataclass(frozen=True)
class OracleResponse:
    """The oracle's answer for one lane.

    Attributes:
        rotation: Rotation [rad] at `times`, shape [sample].
        times: Sample times [s], shape [sample].
        peak_rotation: Largest |rotation| [rad].
        peak_time: Its time [s].
        impact_times: Times of the impacts [s], shape [impact].
        uplift_time: Time at which the block first leaves its flat state [s]; NaN if never, and
            the start of the run for a block that is released from a rotation.
        rest_time: Time from which the block stays at rest [s]; NaN if it does not.
        outcome: Where the block is at the end.
        status: Whether the numbers may be used.
        energy_lost: Energy lost in impacts [J].
        evaluation_count: Evaluations of the equation of motion.
    """

    rotation: Array
    times: Array
    peak_rotation: float
    peak_time: float
    impact_times: Array
    uplift_time: float
    rest_time: float
    outcome: Outcome
    status: Status
    energy_lost: float
    evaluation_count: int


def _root(function: Callable[[float], float], low: float, high: float) -> float:
    """A root between two times; the nearer end if round-off hides the change of sign."""
    at_low, at_high = function(low), function(high)
    if at_low * at_high > 0.0:
        return low if abs(at_low) < abs(at_high) else high
    found: float = brentq(function, low, high, xtol=1e-300, rtol=ROOT_TOLERANCE)
    return found


class _Run:
    """One lane's run: the state and what has happened so far."""

    def __init__(self, block: PivotingBlock, times: SampleTimes, rtol: float) -> None:
        self.block, self.rtol, self.duration = block, rtol, times.duration
        self.times = times.times
        self.rotation = np.full(len(self.times), np.nan)
        self.filled = 0
        self.time, self.side, self.tilt, self.rate = 0.0, 1, 0.0, 0.0
        self.flat, self.overturned, self.status = True, False, Status.OK
        self.peak, self.peak_time = 0.0, 0.0
        self.impacts: list[float] = []
        self.uplift_time, self.rest_time = math.nan, 0.0
        self.energy_lost, self.evaluations = 0.0, 0
        self.step_hint = math.inf
        self.acceleration: Callable[[float], float] = lambda _time: 0.0

    def start(self, rotation: float) -> None:
        """Releases the block from a rotation [rad] at rest."""
        if rotation != 0.0:
            self._leave(0.0, 1 if rotation > 0.0 else -1, 0.0)
            self.tilt = abs(rotation)
            self._note_peak(0.0, self.tilt)

    def follow(self, segment: Segment, scan: float) -> None:
        """Follows one segment of the motion; `scan` is the time between looks at rest [s]."""
        stop = min(segment.stop, self.duration)
        self.acceleration = segment.acceleration
        if segment.velocity_step != 0.0:
            if self.flat:
                self._leave(self.time, -1 if segment.velocity_step > 0.0 else 1, 0.0)
            self.rate += self.block.rate_step(self.side, self.tilt, segment.velocity_step)
        while self.time < stop and not self.overturned and self.status == Status.OK:
            if self.flat:
                self._wait(stop, scan)
            else:
                self._swing(stop)

    def _lifting(self, time: float) -> float:
        """The larger tilt acceleration of the flat block about its two corners [rad/s^2]."""
        base = self.acceleration(time)
        return max(self.block.tilt_acceleration(side, 0.0, base) for side in (1, -1))

    def _leave(self, time: float, side: int, rate: float) -> None:
        self.flat, self.side, self.tilt, self.rate = False, side, 0.0, rate
        self.rest_time = math.nan
        if math.isnan(self.uplift_time):
            self.uplift_time = time

    def _note_peak(self, time: float, tilt: float) -> None:
        if tilt > self.peak:
            self.peak, self.peak_time = tilt, time

    def _fill(self, stop: float, values: Callable[[Array], Array]) -> None:
        """Fills the histories up to a time from a function of times."""
        end = int(np.searchsorted(self.times, stop, side="right"))
        if end > self.filled:
            part = slice(self.filled, end)
            self.rotation[part] = values(self.times[part])
            self.filled = end

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
            if values[2] <= 0.0 and len(grid) > 2 and values[0] <= values[1] >= values[2]:
                top = float(
                    minimize_scalar(
                        lambda time: -self._lifting(time), bounds=(low, high), method="bounded"
                    ).x
                )
            if self._lifting(top) > 0.0:
                return _root(self._lifting, low, top)
            values = values[1:]
        return math.nan

    def _derivative(self, time: float, state: Array) -> tuple[float, float]:
        base = self.acceleration(time)
        rate = float(state[1])
        return rate, self.block.tilt_acceleration(self.side, float(state[0]), base)

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
        solver = self._solver(
            self.time, np.array([self.tilt, self.rate]), stop, self._first_step(stop)
        )
        while solver.status == "running":
            begin, before = solver.t, solver.y
            solver.step()
            if solver.status == "failed" or not np.all(np.isfinite(solver.y)):
                self.status = Status.NONFINITE
                break
            if self._event(solver, begin, before):
                break
            self.step_hint = solver.h_abs
            self.time, (self.tilt, self.rate) = solver.t, solver.y.tolist()
        self.evaluations += solver.nfev

    def _first_step(self, stop: float) -> float:
        """The step that the last swing ended with, or the whole of a short swing."""
        bend = self.block.tilt_acceleration(self.side, self.tilt, self.acceleration(self.time))
        flight = 2.02 * self.rate / -bend if bend < 0.0 < self.rate else math.inf
        guess = min(self.step_hint, flight, stop - self.time)
        return guess if guess < math.inf and guess > 0.0 else 1e-3

    def _event(self, solver: DOP853, begin: float, before: Array) -> bool:
        """Handles what happened in a step; True if the swing is over."""
        end, after = solver.t, solver.y
        turned = before[1] * after[1] < 0.0 or (before[1] == 0.0 and after[1] < 0.0)
        wanted = self.filled < len(self.times) and self.times[self.filled] <= end
        if not (turned or wanted or after[0] <= 0.0 or after[0] >= 0.5 * math.pi):
            return False
        dense = solver.dense_output()
        turn = begin
        extreme = before[0]
        if turned and before[1] != 0.0:
            turn = _root(lambda time: float(dense(time)[1]), begin, end)
            extreme = self._state_at(begin, before, turn)[0]
        over = turned and before[1] > 0.0 and extreme >= 0.5 * math.pi
        low = turned and before[1] < 0.0 and extreme <= 0.0
        if over or after[0] >= 0.5 * math.pi:
            top = turn if over else end
            fall = _root(lambda time: float(dense(time)[0]) - 0.5 * math.pi, begin, top)
            self._fill_swing(fall, dense)
            self._overturn(fall)
            return True
        if turned and before[1] >= 0.0:
            self._note_peak(turn, float(extreme))
        if low or after[0] <= 0.0:
            first, last = (begin, turn) if low else (turn, end)
            time, rate = self._touch(dense, (begin, before), first, last)
            self._fill_swing(time, dense)
            self._impact(time, rate)
            return True
        self._fill_swing(end, dense)
        return False

    def _fill_swing(self, stop: float, dense: Callable[[Array], Array]) -> None:
        self._fill(stop, lambda times: self.side * dense(times)[0])

    def _touch(
        self, dense: Callable[[float], Array], step: tuple[float, Array], low: float, high: float
    ) -> tuple[float, float]:
        """Time [s] at which the free corner meets the base, and the tilt rate [rad/s] then."""
        height, speed = self.block.corner_height, self.block.corner_speed
        time = _root(lambda t: height(self.side, float(dense(t)[0])), low, high)
        begin, before = step
        for _ in range(2):
            tilt, rate = self._state_at(begin, before, time).tolist()
            falling = speed(self.side, tilt, rate)
            if falling >= 0.0:
                break
            time = min(max(time - height(self.side, tilt) / falling, low), high)
        return time, rate

    def _overturn(self, time: float) -> None:
        self.time, self.tilt, self.rate, self.overturned = time, 0.5 * math.pi, 0.0, True
        self._note_peak(time, self.tilt)
        self._fill(math.inf, lambda times: np.full(len(times), self.side * self.tilt))

    def _impact(self, time: float, rate: float) -> None:
        """The free corner meets the base: pivot on it, or rest."""
        self.time, self.tilt = time, 0.0
        self.impacts.append(time)
        after = self.block.rate_after_impact(self.side, min(rate, 0.0))
        lifting = self._lifting(time)
        swing = after * after / (-2.0 * lifting) if lifting < 0.0 else math.inf
        if after <= 0.0 or swing < REST_ROTATION_RATIO * self.block.critical_tilt:
            after, self.flat, self.rest_time = 0.0, True, time
        self.energy_lost += self.block.kinetic_energy(rate) - self.block.kinetic_energy(after)
        self.side, self.rate = -self.side, after
        if len(self.impacts) >= IMPACT_LIMIT:
            self.status = Status.EVENT_LIMIT

    def result(self) -> OracleResponse:
        """What the run came to."""
        if not self.flat and not self.overturned:
            self._note_peak(self.time, self.tilt)
        rocking = Outcome.AT_REST if self.flat else Outcome.ROCKING
        return OracleResponse(
            rotation=self.rotation,
            times=self.times,
            peak_rotation=self.peak,
            peak_time=self.peak_time,
            impact_times=np.array(self.impacts),
            uplift_time=self.uplift_time,
            rest_time=self.rest_time,
            outcome=Outcome.OVERTURNED if self.overturned else rocking,
            status=self.status,
            energy_lost=self.energy_lost,
            evaluation_count=self.evaluations,
        )


def _block(lanes: Lanes, lane: int) -> PivotingBlock:
    """The block of a lane; its angular restitution is prescribed only if it is not the rigid one."""
    shape = [float(a[lane]) for a in (lanes.width, lanes.height, lanes.depth, lanes.density)]
    given = float(lanes.angular_restitution[lane])
    rigid = PivotingBlock(*shape, restitution=None)
    if abs(rigid.rate_after_impact(1, -1.0) - given) <= 1e-12:
        return rigid
    return PivotingBlock(*shape, restitution=given)


def _scan_interval(motions: GroundMotions, lane: int) -> float:
    """Time between looks at the overturning moment of a resting block [s].

    Within a segment of a record the acceleration is linear, so its ends are enough.
    """
    if isinstance(motions, HarmonicMotions):
        return float(1.0 / (SCANS_PER_PERIOD * motions.frequency[lane]))
    if isinstance(motions, RickerMotions):
        return float(math.pi / (SCANS_PER_PERIOD * motions.rate[lane]))
    return math.inf


def rock(
    lanes: Lanes,
    motions: GroundMotions,
    lane: int,
    times: SampleTimes,
    *,
    rtol: float = RELATIVE_TOLERANCE,
) -> OracleResponse:
    """Runs one lane.

    Args:
        lanes: Blocks and starts, shape [lane].
        motions: Ground motions of the same lanes.
        lane: Index of the lane.
        times: Duration and sampling.
        rtol: Relative tolerance of the integrator.
    """
    run = _Run(_block(lanes, lane), times, rtol)
    run.start(float(lanes.rotation_start[lane]))
    run._fill(0.0, lambda at: np.full(len(at), float(lanes.rotation_start[lane])))
    scan = _scan_interval(motions, lane)
    for segment in motions.segments(lane):
        if segment.start < times.duration and not run.overturned:
            run.follow(segment, scan)
    return run.result()


def _rock_all(
    lanes: Lanes, motions: GroundMotions, times: SampleTimes, rtol: float
) -> list[OracleResponse]:
    return [rock(lanes, motions, lane, times, rtol=rtol) for lane in range(lanes.lane_count)]


def oracle_response(
    lanes: Lanes,
    motions: GroundMotions,
    times: SampleTimes,
    workers: int = 1,
    *,
    rtol: float = RELATIVE_TOLERANCE,
) -> Response:
    """Runs every lane, over worker processes if asked for.

    Args:
        lanes: Blocks and starts, shape [lane].
        motions: Ground motions of the same lanes.
        times: Duration and sampling.
        workers: Worker processes; 1 stays in this one.
        rtol: Relative tolerance of the integrator.

    Returns:
        Every lane field; `step_count` counts evaluations of the equation of motion, slides are
        zero by the model.
    """
    if workers <= 1 or lanes.lane_count <= 1:
        answers = _rock_all(lanes, motions, times, rtol)
    else:
        size = max(1, lanes.lane_count // (4 * workers))
        parts = [slice(at, at + size) for at in range(0, lanes.lane_count, size)]
        context = multiprocessing.get_context("spawn")
        with concurrent.futures.ProcessPoolExecutor(workers, mp_context=context) as pool:
            tasks = [
                pool.submit(_rock_all, lanes.take(part), motions.take(part), times, rtol)
                for part in parts
            ]
            answers = [answer for task in tasks for answer in task.result()]
    rows = {
        "impact_count": [len(a.impact_times) for a in answers],
        "step_count": [a.evaluation_count for a in answers],
        "residual_slide": [0.0] * len(answers),
        "peak_slide": [0.0] * len(answers),
    }
    fields: dict[str, npt.NDArray[np.generic]] = {}
    for name in LANE_FIELDS:
        values = rows[name] if name in rows else [getattr(a, name) for a in answers]
        fields[name] = np.array(values, np.int64 if name in INTEGER_FIELDS else np.float64)
    if times.interval is None:
        return Response("oracle", fields, np.empty(0))
    fields[FIELDS["rotation"].name] = np.array([a.rotation for a in answers])
    return Response("oracle", fields, times.times)
