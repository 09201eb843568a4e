"""The event loop of the oracle for a block that walls and ties hold.

Everything follows from forces at points, as in `warprock.oracle.block_mechanics`: the point at
which a tie pulls is turned with the block, its displacement along the base is the tie's elongation,
and the moment is the cross product of its lever with the force. The force is k (e - e0) cut off at
the yield force, and at zero where a tie only pulls. As long as the block turns one way each tie is
stretched or let go all along, so that this holds whatever it did before; where the block turns back
e0 is moved to what the tie has yielded. SciPy's `solve_ivp` (DOP853) is stopped where a block turns
back, lands or falls, and where the force of a tie has a corner.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.optimize import brentq, minimize_scalar

from warprock.model.hold import Hold
from warprock.model.response import SampleTimes, Status
from warprock.oracle.block_base import BaseSegment
from warprock.oracle.block_mechanics import PivotingBlock, Vector, cross, turned
from warprock.oracle.block_swings import REST_ROTATION_RATIO
from warprock.oracle.lane_run import LaneRun, ends_at, friction_for, looks_in
from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]

LONGEST = 0.02
"""Longest step of DOP853 [s]: its dense output, on which events lie, is of a lower order."""
SHORTEST = 1e-9
"""A hop as short as this [s] is none."""
LEAST_HOP = 1e-14
"""Step [s] that is taken though the block does not seem to move."""
AT_CORNER = 1e-12
"""Distance of a tie from a corner of its force [m] from which on it has come to it."""


@dataclasses.dataclass
class HeldTie:
    """A tie as the run goes on.

    Attributes:
        side: Side that it pulls to.
        point: Its point on the block at rest, from the middle of the base [m].
        stiffness: [N/m].
        yield_force: [N].
        longest: Elongation at which it breaks [m].
        pushes: Whether it gives compression.
        free: Elongation without force [m].
        lost: Energy that it has taken [J].
        broken: When it broke [s]; infinite before.
    """

    side: float
    point: Vector
    stiffness: float
    yield_force: float
    longest: float
    pushes: bool
    free: float
    lost: float = 0.0
    broken: float = math.inf

    def force(self, stretch: float) -> float:
        """Force at an elongation [N], tension positive."""
        if self.broken < math.inf:
            return 0.0
        least = -self.yield_force if self.pushes else 0.0
        return min(max(self.stiffness * (stretch - self.free), least), self.yield_force)

    def corners(self) -> list[float]:
        """Elongations at which the force has a corner [m]."""
        if self.broken < math.inf:
            return []
        reach = self.yield_force / self.stiffness
        low = self.free - reach if self.pushes else self.free
        return [each for each in (low, self.free + reach, self.longest) if math.isfinite(each)]

    def settle(self, stretch: float) -> None:
        """Takes what it has yielded as its new length."""
        if self.broken < math.inf or self.yield_force == math.inf:
            return
        reach = self.yield_force / self.stiffness
        free = max(self.free, stretch - reach)
        free = min(free, stretch + reach) if self.pushes else free
        self.lost += self.yield_force * abs(free - self.free)
        self.free = free

    def snap(self, time: float) -> None:
        """Breaks it."""
        self.settle(self.longest)
        self.lost += 0.5 * self.force(self.longest) ** 2 / self.stiffness
        self.broken = time


class HeldLoad(NamedTuple):
    """Forces on the top of a block: a weight [N], which may stay, and a thrust towards +x [N]."""

    point: Vector
    weight: float
    thrust: float
    stays: bool


class HeldRun(LaneRun):
    """One lane's run: the state and what has happened so far."""

    def __init__(
        self,
        block: PivotingBlock,
        hold: Hold,
        lane: int,
        times: SampleTimes,
        rtol: float,
        friction: float,
    ) -> None:
        """Puts the block flat on the base.

        Args:
            block: The block's mechanics.
            hold: What holds the blocks.
            lane: The lane.
            times: Duration and sampling.
            rtol: Relative tolerance of DOP853.
            friction: Of the contact, which only says from where on a fall is not judged.
        """
        super().__init__(times, rtol)
        self.block, self.flat = block, True
        self.ties, self.load, self.wall, self.rebound = hold_of_lane(hold, lane, block)
        self.theta, self.omega, self.lost = 0.0, 0.0, 0.0
        self.side = -self.wall or 1
        self.peak_tie_force, self.peak_tie_elongation = 0.0, 0.0
        self.fall_tilt = block.critical_tilt + math.atan(min(friction, 1.0))

    @property
    def sides(self) -> tuple[int, ...]:
        """Sides to which the block may turn."""
        return (-self.wall,) if self.wall else (1, -1)

    @property
    def energy_lost(self) -> float:
        """Energy lost in impacts and to the ties [J]."""
        return self.lost + self.tie_energy_lost

    @property
    def tie_energy_lost(self) -> float:
        """Energy that the ties took by yielding and breaking [J]."""
        yielding = 0.0
        for tie in self.ties:
            fresh = dataclasses.replace(tie)
            fresh.settle(self._stretch(tie, self.side, self.theta))
            yielding += fresh.lost
        return yielding

    def start(self, rotation: float) -> None:
        """Releases the block from a rotation [rad] at rest."""
        if rotation != 0.0:
            self.side = 1 if rotation > 0.0 else -1
            self.flat, self.theta = False, rotation
            self.uplift_time, self.rest_time = 0.0, math.nan
        for tie in self.ties:
            stretch = self._stretch(tie, self.side, rotation)
            tie.settle(stretch)
            tie.lost = 0.0
            if stretch > tie.longest:
                tie.broken = 0.0
        self._note()
        self._fill(0.0, lambda times: np.full(len(times), rotation))

    def _stretch(self, tie: HeldTie, side: int, theta: float) -> float:
        """Elongation of a tie [m] with the block turned towards +x on a corner."""
        lever = (tie.point[0] - side * self._half_width, tie.point[1])
        return -tie.side * (turned(lever, -theta)[0] - lever[0])

    @property
    def _half_width(self) -> float:
        return -self.block.levers[1][0]

    def _moment(self, side: int, theta: float) -> tuple[float, float]:
        """Moment of load and ties about a corner, towards +x [N m], and their force along x [N]."""
        lever = (self.load.point[0] - side * self._half_width, self.load.point[1])
        moved, total = turned(lever, -theta), self.load.thrust
        moment = -cross(lever if self.load.stays else moved, (0.0, -self.load.weight))
        moment -= cross(moved, (total, 0.0))
        for tie in self.ties:
            lever = (tie.point[0] - side * self._half_width, tie.point[1])
            force = (tie.side * tie.force(self._stretch(tie, side, theta)), 0.0)
            moment -= cross(turned(lever, -theta), force)
            total += force[0]
        return moment, total

    def _bend(self, side: int, theta: float, time: float) -> float:
        """Angular acceleration towards +x [rad/s^2]."""
        free = side * self.block.tilt_acceleration(side, side * theta, self.acceleration(time))
        return free + self._moment(side, theta)[0] / self.block.corner_inertia

    def follow(self, segment: BaseSegment, scan: float) -> None:
        """Follows one segment of the motion; `scan` is the time between looks at rest [s]."""
        stop = min(segment.stop, self.duration)
        self.acceleration = segment.acceleration
        if any(segment.velocity_step):
            self._step(segment.velocity_step)
        while self.time < stop and not self.overturned and self.status == Status.OK:
            if self.flat:
                self._wait(stop, scan)
            else:
                self._swing(stop)

    def _step(self, velocity_step: Vector) -> None:
        """A velocity step of the base."""
        kick = -math.copysign(1.0, velocity_step[0])
        side = int(kick) if self.theta == 0.0 and not self.wall else self.side
        change = side * self.block.rate_step(side, side * self.theta, velocity_step)
        if self.flat:
            if side not in self.sides or side * change <= 0.0 or self._settles(side, change, True):
                return
            self._leave(self.time, side)
        if self.theta == 0.0 and not self.wall:
            self.side = 1 if self.omega + change > 0.0 else -1
        self.omega += change
        if not self._falls(self.side * self.theta, self.side * self.omega):
            impulse = self.block.step_impulse(self.side, self.side * self.theta, velocity_step)
            self._need(friction_for(impulse))

    def _lifting(self, time: float) -> float:
        """The larger outward angular acceleration of the flat block about its corners."""
        return max(side * self._bend(side, 0.0, time) for side in self.sides)

    def _settles(self, _side: int, rate: float, still: bool = False) -> bool:
        """The rest rule: whether a swing from flat is too small to count."""
        before = self.acceleration
        if still:
            self.acceleration = lambda _time: (0.0, 0.0)
        bend = self._lifting(self.time)
        self.acceleration = before
        limit = REST_ROTATION_RATIO * self.block.critical_tilt
        return bend < 0.0 and rate * rate <= -2.0 * bend * limit

    def _leave(self, time: float, side: int) -> None:
        self.flat, self.side, self.theta, self.omega = False, side, 0.0, 0.0
        self._note_uplift(time)

    def _note(self) -> None:
        """Notes the rotation and the ties where the block is."""
        self._note_peak(self.time, abs(self.theta))
        for tie in self.ties:
            stretch = self._stretch(tie, self.side, self.theta)
            self.peak_tie_elongation = max(self.peak_tie_elongation, stretch)
            self.peak_tie_force = max(self.peak_tie_force, abs(tie.force(stretch)))

    def _wait(self, stop: float, scan: float) -> None:
        """Keeps the block flat until a moment lifts it, or until `stop`."""
        count = max(2, math.ceil((stop - self.time) / scan))
        grid = np.linspace(self.time, stop, count + 1).tolist()
        lift = self._lift_time(grid)
        pull, weight = self._moment(1, 0.0)[1], self.block.mass * GRAVITY + self.load.weight

        def needed(time: float) -> float:
            along = self.block.mass * self.acceleration(time)[0] - pull
            return 0.0 if self.wall * along < 0.0 else abs(along) / weight

        looks = grid if math.isnan(lift) else [*(time for time in grid if time < lift), lift]
        self._look_at(needed, looks)
        self.time = stop if math.isnan(lift) else lift
        self._fill(self.time, np.zeros_like)
        if not math.isnan(lift):
            self._leave(lift, max(self.sides, key=lambda s: s * self._bend(s, 0.0, lift)))

    def _lift_time(self, grid: list[float]) -> float:
        """First time at which a moment lifts the flat block [s]; NaN if none."""
        values = [self._lifting(time) for time in grid]
        for at, value in enumerate(values):
            if value > 0.0:
                return grid[0] if at == 0 else _crossing(self._lifting, grid[at - 1], grid[at])
            inside = 0 < at < len(grid) - 1
            if inside and value >= max(values[at - 1], values[at + 1]):
                bounds = (grid[at - 1], grid[at + 1])
                found = minimize_scalar(
                    lambda time: -self._lifting(time), bounds=bounds, method="bounded"
                )
                if self._lifting(float(found.x)) > 0.0:
                    return _crossing(self._lifting, grid[at - 1], float(found.x))
        return math.nan

    def _derivative(self, time: float, state: npt.NDArray[Any]) -> tuple[float, float]:
        return float(state[1]), self._bend(self.side, float(state[0]), time)

    def _follow(self, stop: float, events: list[Any] | None = None) -> Any:
        return self._solved((self.theta, self.omega), stop, LONGEST, events)

    def _swing(self, stop: float) -> None:
        """Follows the block one way: until it turns back, lands, falls, or a tie changes."""
        outwards = self._outwards(stop)
        if outwards is None:
            self.flat, self.rest_time = True, self.time
            self.time = min(self.time + SHORTEST, stop)
            return
        if self.side * self.theta <= 0.0 and not outwards:
            self._impact()
            return
        towards = self.side if outwards else -self.side
        if self.theta == 0.0 or self.omega == 0.0:
            self._hop(stop, towards)
            if self.time >= stop:
                return
        events = [ends_at(lambda _t, y: towards * y[1], "turn")]
        if outwards:
            events.append(ends_at(lambda _t, y: 0.5 * math.pi - self.side * y[0], "fall"))
            # A little before, so that the contact is judged at the end.
            judged = self.fall_tilt - AT_CORNER
            if self.side * self.theta < judged - AT_CORNER:
                events.append(ends_at(lambda _t, y: judged - self.side * y[0], "judged"))
        else:
            events.append(ends_at(lambda _t, y: self.side * y[0], "land"))
        for tie in self.ties:
            stretches = tie.side * towards < 0.0
            now = self._stretch(tie, self.side, self.theta)
            for corner in tie.corners():
                ahead = corner - now if stretches else now - corner
                if ahead > AT_CORNER:
                    events.append(self._corner(tie, corner, stretches))
        found = self._follow(stop, events)
        happened = next(
            (e for e, times in zip(events, found.t_events, strict=True) if len(times)), None
        )
        if happened is not None:
            happened = _first_of_last_step(found, events, happened)
        self._judge(found)
        self._fill(found.t[-1], lambda times: found.sol(times)[0])
        self.time, (self.theta, self.omega) = float(found.t[-1]), found.y[:, -1].tolist()
        self._note()
        if happened is not None:
            self._happen(happened)

    def _corner(self, tie: HeldTie, corner: float, stretches: bool) -> Any:
        """The event of a tie that comes to a corner of its force."""
        sign = 1.0 if stretches else -1.0
        snaps = tie if stretches and corner == tie.longest else None
        return ends_at(
            lambda _t, y: sign * (corner - self._stretch(tie, self.side, float(y[0]))),
            "corner",
            snaps,
        )

    def _happen(self, event: Any) -> None:
        if event.kind == "turn":
            self.omega = 0.0
            for tie in self.ties:
                tie.settle(self._stretch(tie, self.side, self.theta))
        elif event.kind == "land":
            self._impact()
        elif event.kind == "fall":
            self.theta, self.overturned = math.copysign(0.5 * math.pi, self.side), True
            self._note()
            self._fill(math.inf, lambda times: np.full(len(times), self.theta))
        elif event.what is not None:
            event.what.snap(self.time)

    def _outwards(self, stop: float) -> bool | None:
        """Whether the block turns outwards; None where round-off took it for lifted."""
        if self.omega != 0.0:
            return self.side * self.omega > 0.0
        if self.theta != 0.0:
            return self.side * self._bend(self.side, self.theta, self.time) > 0.0
        step = min(stop - self.time, LONGEST)
        while step > SHORTEST:
            theta, omega = self._follow(self.time + step).y[:, -1]
            if self.side * theta > 0.0 and self.side * omega > 0.0:
                return True
            step *= 0.25
        return None

    def _hop(self, stop: float, towards: int) -> None:
        """A first short step from the base or from rest, which ends before anything happens."""
        bend = self.side * self._bend(self.side, 0.0, self.time)
        flight = 0.5 * abs(self.omega) / -bend if bend < 0.0 else math.inf
        step = min(stop - self.time, LONGEST, flight or LONGEST)
        while True:
            found = self._follow(self.time + step)
            theta, omega = found.y[:, -1].tolist()
            onwards = towards * (theta - self.theta) > 0.0 and towards * omega > 0.0
            up = self.side * theta > 0.0 and self._same_forces(theta)
            if (onwards and up) or step < LEAST_HOP:
                break
            step *= 0.25
        self._judge(found)
        self._fill(self.time + step, lambda times: found.sol(times)[0])
        self.time, self.theta, self.omega = self.time + step, theta, omega

    def _same_forces(self, theta: float) -> bool:
        """Whether no tie comes to a corner of its force on the way to a rotation."""
        for tie in self.ties:
            now, then = (self._stretch(tie, self.side, each) for each in (self.theta, theta))
            low, high = min(now, then) + AT_CORNER, max(now, then) - AT_CORNER
            if any(low < corner < high for corner in tie.corners()):
                return False
        return True

    def _judge(self, found: Any) -> None:
        """Notes the friction that the contact needs on a way."""

        def needed(time: float) -> float:
            theta, omega = (float(each) for each in found.sol(time))
            if self._falls(self.side * theta, self.side * omega):
                return 0.0
            along, upwards = self.acceleration(time)
            lever = turned(self.block.levers[self.side], -theta)
            bend = -self._bend(self.side, theta, time)
            along += -bend * lever[1] - omega**2 * lever[0]
            upwards += GRAVITY + bend * lever[0] - omega**2 * lever[1]
            pull, mass = self._moment(self.side, theta)[1], self.block.mass
            return friction_for((mass * along - pull, mass * upwards + self.load.weight))

        self._look_at(needed, looks_in(found).tolist())

    def _impact(self) -> None:
        """The block comes back: it goes on about its other corner, or rebounds, or rests."""
        before = abs(self.omega)
        self._note_impact()
        self.theta = 0.0
        for tie in self.ties:
            tie.settle(self._stretch(tie, self.side, 0.0))
        if self.wall:
            kept, after = self.rebound, self.rebound * before
        else:
            after = max(self.block.rate_after_impact(self.side, -before), 0.0)
            if before > 0.0:
                self._need(friction_for(self.block.impact_impulse(self.side, -before, after)))
            kept = after / before if before > 0.0 else 0.0
            self.side = -self.side
        if self._settles(self.side, after):
            self.flat, self.rest_time = True, self.time + self._tail(after, kept)
            after = 0.0
        self.lost += self.block.kinetic_energy(before) - self.block.kinetic_energy(after)
        self.omega = self.side * after

    def _tail(self, rate: float, kept: float) -> float:
        """Time that the impacts left out by the rest rule would take [s]."""
        first = -2.0 * rate / (self.side * self._bend(self.side, 0.0, self.time))
        if self.wall or rate <= 0.0:
            return first / max(1.0 - kept, 1e-6)
        second = 2.0 * kept * rate / (self.side * self._bend(-self.side, 0.0, self.time))
        return (first + second) / (1.0 - kept * kept)

    def finish(self) -> None:
        """Counts where the run ends as a candidate for the peak."""
        self._note()


def hold_of_lane(
    hold: Hold, lane: int, block: PivotingBlock
) -> tuple[list[HeldTie], HeldLoad, int, float]:
    """What holds the block of a lane: ties, load, the side of its wall (0 without), rebound."""
    wall = 0 if hold.wall is None else int(hold.wall[lane])
    rebound = 0.0 if hold.rebound is None else float(hold.rebound[lane])
    return _ties(hold, lane, block), _load(hold, lane, block), wall, rebound


def _load(hold: Hold, lane: int, block: PivotingBlock) -> HeldLoad:
    """The load of a lane; nothing without one."""
    load, height = hold.load, 2.0 * block.levers[1][1]
    if load is None:
        return HeldLoad((0.0, height), 0.0, 0.0, stays=False)
    point = (float(load.eccentricity[lane]), height)
    weight, thrust = float(load.weight[lane]), float(load.thrust[lane])
    return HeldLoad(point, weight, thrust, bool(load.stays[lane]))


def _ties(hold: Hold, lane: int, block: PivotingBlock) -> list[HeldTie]:
    """The ties of a lane."""
    ties = hold.ties
    if ties is None:
        return []
    half_width = -block.levers[1][0]
    found = []
    for tie in range(ties.count):
        side, stiffness = float(ties.side[lane, tie]), float(ties.stiffness[lane, tie])
        slack = float(ties.slack[lane, tie])
        found.append(
            HeldTie(
                side=side,
                point=(side * half_width, float(ties.height[lane, tie])),
                stiffness=stiffness,
                yield_force=float(ties.yield_force[lane, tie]),
                longest=slack + float(ties.ultimate_elongation[lane, tie]),
                pushes=bool(ties.pushes[lane, tie]),
                free=slack - float(ties.prestress[lane, tie]) / stiffness,
            )
        )
    return found


def _first_of_last_step(found: Any, events: list[Any], happened: Any) -> Any:
    """The event that comes first in the last step of a solution, which it ends there.

    `solve_ivp` sees no event that a step passes and, after the block has turned back, passes again.
    At the turning point it still has its other sign.
    """
    before, end, way = found.t[-2], found.t[-1], found.sol
    for event in events:
        passed = event is not happened and event(end, found.y[:, -1]) < 0.0
        if passed and event(before, found.y[:, -2]) > 0.0:
            time = brentq(lambda at, e=event: e(at, way(at)), before, end, xtol=1e-300, rtol=1e-15)
            if time < found.t[-1]:
                happened, found.t[-1], found.y[:, -1] = event, time, way(time)
    return happened


def _crossing(function: Callable[[float], float], low: float, high: float) -> float:
    """The root of a function between a time at which it is negative and one at which it is not."""
    found: float = brentq(function, low, high, xtol=1e-300, rtol=1e-15)
    return found
