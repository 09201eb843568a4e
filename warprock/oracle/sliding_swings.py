"""A block that walls, ties and loads hold and that may slide: the oracle's own contact.

Everything follows from forces at points. A block has three velocities, of its centre and of turning
counter-clockwise; a point of it at a lever r moves at v + w (-r_z, r_x). Points that press are
constraints on accelerations, solved with their forces as one linear system at every evaluation;
SciPy's `solve_ivp` (DOP853) is stopped where a force, a gap, a reserve of friction or a speed of
sliding comes to zero, and where the force of a tie has a corner or a tie turns back.

Which points press is looked for anew wherever something has happened: the set of points is taken
that obeys the contact law at a state a millionth of a second ahead, where nothing is at its bound.
Whether a block that lies still can be held is a linear programme: the largest amount by which all
forces may keep away from their bounds.

Impacts are solved as forces are, with impulses: the base is plastic, a wall throws back (Newton's
restitution), friction is Coulomb's in impulses, too. A block that lies on base and wall stays if a
linear programme finds impulses that stop it. The rest rule is that of
`warprock.oracle.block_swings`.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.optimize import brentq, linprog

from warprock.model.lanes import Lanes
from warprock.model.motion import GroundMotions, SpatialMotions, UprightMotions
from warprock.model.response import SampleTimes, Status
from warprock.oracle.block_base import BaseSegment, base_segments
from warprock.oracle.block_mechanics import PivotingBlock, Vector, turned
from warprock.oracle.block_swings import REST_ROTATION_RATIO
from warprock.oracle.held_swings import AT_CORNER, LONGEST, HeldTie, hold_of_lane
from warprock.oracle.lane_run import LaneRun, ends_at, looks_in
from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]

AHEAD = 1e-6
"""How far ahead contacts are looked for [s]."""
HOP = 2e-3
"""Longest first step after something has happened [s]."""
SCANS_PER_PERIOD = 64
"""Looks at what lies still in a period of the motion."""
NOISE = 1e-12
"""Penetration from which on a point has come back that has just parted [m]."""
SLACK = 1e-9
"""Part of a force, of an acceleration or of a velocity that counts as none."""
TOUCHING = 1e-9
"""Gap [m] up to which a point touches where something has happened."""
BASE, WALL = ("left", "right"), ("low", "high")
"""Points that may touch the base, and the wall."""


class Grip(NamedTuple):
    """Points that press, and how the base holds: 0 it sticks, else the way in which it slides."""

    points: tuple[str, ...]
    slip: int

    @property
    def sticks(self) -> bool:
        """Whether a point of it is held along the base."""
        return self.slip == 0 and any(name in BASE for name in self.points)


class Answer(NamedTuple):
    """Accelerations or velocities with contacts; normal forces, and the force along the base."""

    rates: Array
    normal: dict[str, float]
    along: float


class SlidingRun(LaneRun):
    """One lane's run: state, contacts, and what has happened so far."""

    def __init__(self, lanes: Lanes, lane: int, times: SampleTimes, rtol: float) -> None:
        """Puts the block flat on the base.

        Args:
            lanes: Held blocks.
            lane: The lane.
            times: Duration and sampling.
            rtol: Relative tolerance of DOP853.
        """
        super().__init__(times, rtol)
        width, height, depth, density, friction = (
            float(getattr(lanes, name)[lane])
            for name in ("width", "height", "depth", "density", "friction")
        )
        block = PivotingBlock(width, height, depth, density, None)
        self.half_width, self.half_height = 0.5 * width, 0.5 * height
        self.masses = np.array([block.mass, block.mass, block.central_inertia])
        self.friction = friction
        assert lanes.hold is not None
        held = hold_of_lane(lanes.hold, lane, block)
        self.ties, self.load, self.wall, self.rebound = held
        self.rest_rotation = REST_ROTATION_RATIO * block.critical_tilt
        side = float(self.wall)
        self.points: dict[str, Vector] = {
            "left": (-self.half_width, -self.half_height),
            "right": (self.half_width, -self.half_height),
        }
        if self.wall:
            self.points["low"] = (side * self.half_width, -self.half_height)
            self.points["high"] = (side * self.half_width, self.half_height)
        self.x = np.full(len(self.times), np.nan)
        self.hops = True
        # x, z, angle, their rates, and what friction has taken.
        self.state = np.array([0.0, self.half_height, 0.0, 0.0, 0.0, 0.0, 0.0])
        self.grip = Grip(tuple(self.points), 0)
        self.still = True
        self.peak_slide, self.lost, self.tail = 0.0, 0.0, 0.0
        self.peak_tie_force, self.peak_tie_elongation = 0.0, 0.0

    # Where points are, and what acts.

    def _lever(self, point: Vector, state: Array) -> Vector:
        return turned(point, float(state[2]))

    def _gap(self, name: str, state: Array) -> float:
        x, z = self._lever(self.points[name], state)
        if name in BASE:
            return float(state[1] + z)
        return float(self.half_width - self.wall * (state[0] + x))

    def _row(self, name: str, state: Array, along: bool = False) -> tuple[Array, float]:
        """The rate of a point along its normal or along the base, as a row; what turning adds."""
        x, z = self._lever(self.points[name], state)
        spin = float(state[5]) ** 2
        if along:
            return np.array([1.0, 0.0, -z]), -spin * x
        if name in BASE:
            return np.array([0.0, 1.0, x]), -spin * z
        return np.array([-self.wall, 0.0, self.wall * z]), self.wall * spin * x

    def _stretch(self, tie: HeldTie, state: Array) -> float:
        point = (tie.point[0], tie.point[1] - self.half_height)
        return float(-tie.side * (state[0] + self._lever(point, state)[0] - point[0]))

    def _stretch_rate(self, tie: HeldTie, state: Array) -> float:
        z = self._lever((tie.point[0], tie.point[1] - self.half_height), state)[1]
        return float(-tie.side * (state[3] - state[5] * z))

    def _pull(self, time: float, state: Array) -> Array:
        """Forces and moment of weight, inertia, load and ties, without contacts."""
        along, upwards = self.acceleration(time)
        total: Array = np.array([-along, -GRAVITY - upwards, 0.0]) * self.masses
        top = self._lever((self.load.point[0], self.half_height), state)
        total += _at(top, (self.load.thrust, 0.0))
        under = (self.load.point[0] - state[0], 0.0) if self.load.stays else top
        total += _at(under, (0.0, -self.load.weight))
        for tie in self.ties:
            lever = self._lever((tie.point[0], tie.point[1] - self.half_height), state)
            total += _at(lever, (tie.side * tie.force(self._stretch(tie, state)), 0.0))
        return total

    # The contact law.

    def _solve(self, grip: Grip, free: Array, state: Array, target: dict[str, float]) -> Answer:
        """Rates and forces of points that press: rates are `free` without them."""
        rows, forces, wanted = [], [], []
        on_base = [name for name in grip.points if name in BASE]
        for name in grip.points:
            row, more = self._row(name, state)
            force = row.copy()
            if name in BASE and grip.slip:
                force = force - grip.slip * self.friction * self._row(name, state, along=True)[0]
            rows.append(row)
            forces.append(force)
            wanted.append(target.get(name, -more))
        if grip.sticks:
            row, more = self._row(on_base[-1], state, along=True)
            rows.append(row)
            forces.append(row)
            wanted.append(target.get("along", -more))
        if not rows:
            return Answer(free, {}, 0.0)
        jacobian, push = np.array(rows), np.array(forces).T / self.masses[:, None]
        found = np.linalg.solve(jacobian @ push, np.array(wanted) - jacobian @ free)
        normal = dict(zip(grip.points, found[: len(grip.points)].tolist(), strict=True))
        carried = sum(normal[name] for name in on_base)
        along = float(found[-1]) if grip.sticks else -grip.slip * self.friction * carried
        return Answer(free + push @ found, normal, along)

    def _grips(self, near: set[str], slips: tuple[int, ...]) -> Iterator[Grip]:
        """Sets of points that press, those that stick first; of which rates are independent."""
        for slip in slips:
            for count in range(len(near), -1, -1):
                for points in itertools.combinations([n for n in self.points if n in near], count):
                    on_base = sum(name in BASE for name in points)
                    if on_base == 0 and slip:
                        continue
                    rows = count + (1 if on_base and slip == 0 else 0)
                    if rows <= 3 and not (on_base == 2 and count > 2):
                        yield Grip(points, slip)

    def _obeys(
        self, grip: Grip, found: Answer, state: Array, near: set[str], target: dict[str, float],
        *, starts: bool,
    ) -> bool:  # fmt: skip
        """Whether forces push, stay within friction, and leave no point to come nearer."""
        force = SLACK * sum(abs(each) for each in found.normal.values())
        carried = sum(found.normal[name] for name in grip.points if name in BASE)
        if any(each < -force for each in found.normal.values()):
            return False
        if grip.sticks and abs(found.along) > self.friction * carried + force:
            return False
        rate = SLACK * float(np.abs(found.rates * (1.0, 1.0, self.half_height)).sum())
        for name in near - set(grip.points):
            row, more = self._row(name, state)
            if row @ found.rates < target.get(name, -more) - rate - 1e-300:
                return False
        if grip.slip and starts:
            corner = [name for name in grip.points if name in BASE][-1]
            row, more = self._row(corner, state, along=True)
            return bool(grip.slip * (row @ found.rates - target.get("along", -more)) >= -rate)
        return True

    def _choose(
        self, free: Array, state: Array, near: set[str], slip: int, target: dict[str, float]
    ) -> tuple[Grip, Answer] | None:
        """The first set that obeys the law; None if there is none."""
        slips = (slip,) if slip else (0, self.wall or 1, -(self.wall or 1))
        for grip in self._grips(near, slips):
            try:
                found = self._solve(grip, free, state, target)
            except np.linalg.LinAlgError:
                continue
            if self._obeys(grip, found, state, near, target, starts=not slip):
                return grip, found
        return None

    def _reserve(self, needed: Array) -> float:
        """How far forces that give what is needed may keep from their bounds; negative if none do.

        Args:
            needed: Force along x and z and moment about the centre that contacts must give.
        """
        flat = np.zeros(7)
        names = list(self.points)
        levers = np.array([self._row(name, flat)[0] for name in names])
        along = self._row("left", flat, along=True)[0]
        # Normal forces, the force along the base, and the reserve.
        equal = np.column_stack([levers.T, along, np.zeros(3)])
        rows = []
        for k in range(len(names)):
            row = np.zeros(len(names) + 2)
            row[[k, -1]] = -1.0, 1.0
            rows.append(row)
        for sign in (1.0, -1.0):
            row = np.zeros(len(names) + 2)
            row[: len(names)] = [-self.friction if name in BASE else 0.0 for name in names]
            row[-2:] = sign, 1.0
            rows.append(row)
        scale = float(self.masses[0]) * GRAVITY
        found: Any = linprog(
            np.eye(len(names) + 2)[-1] * -1.0,
            A_ub=np.array(rows),
            b_ub=np.zeros(len(rows)),
            A_eq=equal,
            b_eq=needed / scale,
            bounds=[(None, None)] * (len(names) + 2),
        )
        return -float(found.fun) if found.success else -math.inf

    # What happens.

    def start(self, rotation: float) -> None:
        """Releases the block from a rotation [rad] at rest."""
        if rotation != 0.0:
            foot = self.points["right" if rotation > 0.0 else "left"]
            lever = turned(foot, -rotation)
            self.state[:3] = foot[0] - lever[0], -lever[1], -rotation
            self.grip = Grip(("right" if rotation > 0.0 else "left",), 0)
            self.uplift_time, self.rest_time, self.still = 0.0, math.nan, False
        for tie in self.ties:
            stretch = self._stretch(tie, self.state)
            tie.settle(stretch)
            tie.lost = 0.0
            if stretch > tie.longest:
                tie.broken = 0.0
        self._note(self.state)
        self._fill(0.0, lambda times: np.tile(self.state[:, None], len(times)))

    def follow(self, segment: BaseSegment, scan: float) -> None:
        """Follows one segment of the motion; `scan` is the time between looks at rest [s]."""
        stop = min(segment.stop, self.duration)
        self.acceleration = segment.acceleration
        if any(segment.velocity_step):
            self._strike(segment.velocity_step[0])
        if not self.still or any(segment.velocity_step):
            self._decide(set(self.grip.points) | self._resting(), self.grip.slip)
        while self.time < stop and not self.overturned and self.status == Status.OK:
            if self.still:
                self._wait(stop, scan)
            else:
                self._move(stop)

    def _resting(self) -> set[str]:
        """Points that touch and have no speed along their normal."""
        speed = SLACK * (1.0 + float(np.abs(self.state[3:6]).sum()))
        found = set()
        for name in self.points:
            row = self._row(name, self.state)[0]
            if self._gap(name, self.state) <= TOUCHING and abs(row @ self.state[3:6]) <= speed:
                found.add(name)
        return found

    def _decide(self, near: set[str], slip: int) -> None:
        """Looks for the points that press a little ahead."""
        was, rested = self.grip, self.still
        slip = slip if near & set(BASE) else 0
        grip = Grip(tuple(n for n in was.points if n in near), slip)
        try:
            rates = self._accelerations(self.time, self.state, grip)
        except np.linalg.LinAlgError:
            rates = np.zeros(3)
        ahead = self.state.copy()
        # No point is moved along its normal, which an explicit step would do in its second order.
        ahead[3:6] += AHEAD * rates
        ahead[:3] += AHEAD * (self.state[3:6] + 0.5 * AHEAD * rates)
        time = self.time + AHEAD
        flat = near >= set(BASE)
        if flat and slip == 0 and not self.state[3:6].any():
            pull = self._pull(time, self.state)
            if near >= set(self.points) and self._reserve(-pull) >= 0.0:
                self._lie(rested, Grip(tuple(self.points), 0))
                return
        free = self._pull(time, ahead) / self.masses
        found = self._choose(free, ahead, near, slip, {})
        if found is None:
            self.status = Status.ITERATION_LIMIT
            return
        self.grip = found[0]
        full = len(self.grip.points) + self.grip.sticks >= 3 and not self.grip.slip
        if full and not np.abs(self.state[3:6]).max() > SLACK:
            self._lie(rested, self.grip)
            return
        self.still, self.rest_time, self.tail = False, math.nan, 0.0
        on_base = set(self.grip.points) & set(BASE)
        if math.isnan(self.uplift_time) and len(on_base) < 2:
            self.uplift_time = self.time

    def _lie(self, rested: bool, grip: Grip) -> None:
        """Nothing moves from now on; the points that hold it."""
        self.state[3:6] = 0.0
        self.still = True
        if not rested:
            self.rest_time = self.time + self.tail
        self.tail = 0.0
        self.grip = grip

    def _touches(self, name: str) -> bool:
        return self._gap(name, self.state) <= TOUCHING

    def _held(self, time: float) -> float:
        """What keeps a block that lies still from moving; negative where it moves."""
        pull = self._pull(time, self.state)
        if set(self.grip.points) == set(self.points):
            return self._reserve(-pull)
        grip = Grip(self.grip.points, 0)
        found = self._solve(grip, pull / self.masses, self.state, {})
        carried = sum(found.normal[name] for name in grip.points if name in BASE)
        least = min(found.normal.values())
        return min(least, self.friction * carried - abs(found.along)) / float(self.masses[0])

    def _wait(self, stop: float, scan: float) -> None:
        """Keeps the block still until forces move it, or until `stop`."""
        count = max(2, math.ceil((stop - self.time) / scan))
        grid = np.linspace(self.time, stop, count + 1).tolist()
        held = [self._held(time) for time in grid]
        goes = next((k for k, each in enumerate(held) if each < 0.0), None)
        end = stop
        if goes is not None:
            end = grid[0]
            if goes > 0:
                end = brentq(self._held, grid[goes - 1], grid[goes], xtol=1e-300, rtol=1e-15)
        self._fill(end, lambda times: np.tile(self.state[:, None], len(times)))
        self.time = end
        if goes is not None:
            near = set(self.grip.points)
            self.still, self.hops = False, True
            self._decide(near, 0)

    def _accelerations(self, time: float, state: Array, grip: Grip) -> Array:
        free = self._pull(time, state) / self.masses
        return self._solve(grip, free, state, {}).rates

    def _derivative(self, time: float, state: npt.NDArray[Any]) -> npt.NDArray[Any]:
        free = self._pull(time, state) / self.masses
        found = self._solve(self.grip, free, state, {})
        power = 0.0
        if self.grip.slip:
            corner = [name for name in self.grip.points if name in BASE][-1]
            power = -found.along * float(self._row(corner, state, along=True)[0] @ state[3:6])
        return np.array([*state[3:6], *found.rates, power])

    def _answer(self, time: float, state: Array) -> Answer:
        return self._solve(self.grip, self._pull(time, state) / self.masses, state, {})

    def _events(self) -> list[Any]:
        """What may end a way: each a function that falls to zero."""
        found = []
        resting = self._resting()
        on_base = [name for name in self.grip.points if name in BASE]
        for name in self.points:
            if name in self.grip.points:
                found.append(
                    ends_at(lambda t, y, n=name: self._answer(t, y).normal[n], "open", name)
                )
            else:
                # A foot turns away from its wall with the square of the lean, and what touches
                # without speed parts with that of the time: round-off at first.
                least = NOISE if name == "low" or name in resting else 0.0
                found.append(
                    ends_at(lambda _t, y, n=name, e=least: self._gap(n, y) + e, "touch", name)
                )
        if self.grip.sticks:
            for sign in (1, -1):

                def margin(time: float, state: Array, sign: int = sign) -> float:
                    answer = self._answer(time, state)
                    carried = sum(answer.normal[name] for name in on_base)
                    return self.friction * carried - sign * answer.along

                found.append(ends_at(margin, "slide", -sign))
        elif on_base:
            corner, slip = on_base[-1], self.grip.slip
            found.append(
                ends_at(
                    lambda _t, y: slip * float(self._row(corner, y, along=True)[0] @ y[3:6]),
                    "stop",
                    corner,
                )
            )
        for side in (1, -1):
            found.append(ends_at(lambda _t, y, s=side: 0.5 * math.pi + s * y[2], "fall", side))
        soon = self.state.copy()
        soon[3:6] += AHEAD * self._accelerations(self.time + AHEAD, self.state, self.grip)
        for tie in self.ties:
            way = 1.0 if self._stretch_rate(tie, soon) > 0.0 else -1.0
            found.append(
                ends_at(lambda _t, y, e=tie, w=way: w * self._stretch_rate(e, y), "turn", tie)
            )
            now = self._stretch(tie, self.state)
            for bend in tie.corners():
                if way * (bend - now) > AT_CORNER:
                    snaps = tie if way > 0.0 and bend == tie.longest else None
                    found.append(
                        ends_at(
                            lambda _t, y, e=tie, w=way, c=bend: w * (c - self._stretch(e, y)),
                            "corner",
                            snaps,
                        )
                    )
        return found

    def _hop(self) -> float:
        """A first step that ends before a point that has just parted comes back [s]."""
        rates = self._accelerations(self.time, self.state, self.grip)
        step = HOP
        for name in set(self.points) - set(self.grip.points):
            row, more = self._row(name, self.state)
            leaves, bend = float(row @ self.state[3:6]), float(row @ rates + more)
            if self._touches(name) and leaves > 0.0 > bend:
                step = min(step, -0.5 * leaves / bend)
        return step

    def _move(self, stop: float) -> None:
        """Follows the block until something happens, or for a first short step."""
        if self.hops:
            stop, self.hops = min(stop, self.time + self._hop()), False
        events = self._events()
        found = self._solved(self.state, stop, LONGEST, events)
        happened = [e for e, times in zip(events, found.t_events, strict=True) if len(times)]
        self._fill(found.t[-1], lambda times: found.sol(times))
        self.time, self.state = float(found.t[-1]), found.y[:, -1].copy()
        for state in found.sol(looks_in(found)).T:
            self._note(state)
        self._note(self.state)
        if happened:
            self.hops = True
            self._happen(happened[0])

    def _happen(self, event: Any) -> None:
        near, slip = set(self.grip.points), self.grip.slip
        # Several ties may turn back at once.
        for tie in self.ties:
            tie.settle(self._stretch(tie, self.state))
        if event.kind == "fall":
            self.overturned = True
            self.peak = 0.5 * math.pi
            self.state[2] = -0.5 * math.pi * event.what
            self._fill(math.inf, lambda times: np.tile(self.state[:, None], len(times)))
            return
        if event.kind == "touch":
            self._strike(0.0)
            near, slip = self._resting(), self.grip.slip
        elif event.kind == "open":
            near.discard(event.what)
        elif event.kind == "slide":
            slip = event.what
        elif event.kind == "stop":
            row = self._row(event.what, self.state, along=True)[0]
            self.state[3] -= row @ self.state[3:6]
            slip = 0
        elif event.kind == "corner" and event.what is not None:
            event.what.snap(self.time)
        self._decide(near, slip)

    def _strike(self, step: float) -> None:
        """An impact of points that touch, or a velocity step of the base [m/s]."""
        self.state[3] -= step
        self.hops = True
        touching = {name for name in self.points if self._touches(name)}
        if touching >= set(BASE):
            self.state[1], self.state[2] = self.half_height, 0.0
            if touching >= set(self.points) and self.wall:
                self.state[0] = 0.0
        before = self.state[3:6].copy()
        speed = SLACK * (1e-3 + float(np.abs(before).sum()))
        target, thrown, hit = {"along": 0.0}, False, False
        for name in touching:
            rate = float(self._row(name, self.state)[0] @ before)
            target[name] = 0.0
            if rate < -speed:
                hit = hit or name not in self.grip.points
                if name in WALL and self.rebound > 0.0:
                    target[name], thrown = -self.rebound * rate, True
        self._take(touching, target, speed, before)
        if thrown and self._stays(touching):
            for name in touching:
                target[name] = 0.0
            self._take(touching, target, speed, before)
        if hit and touching >= set(BASE) and not touching & set(WALL) and self.state[5]:
            self._settle(abs(float(before[2])))
        for tie in self.ties:
            tie.settle(self._stretch(tie, self.state))
        if hit:
            self._note_impact()
        self.lost += 0.5 * float(self.masses @ (before**2 - self.state[3:6] ** 2))
        self.lost += 0.5 * float(self.masses[0]) * step * float(before[0] - self.state[3])

    def _take(
        self, touching: set[str], target: dict[str, float], speed: float, before: Array
    ) -> None:
        """Takes the velocities after an impact."""
        stops = not any(target.values())
        self.grip = Grip((), 0)
        if stops and touching >= set(self.points) and self.wall:
            stops = self._reserve(-before * self.masses) >= -1e-12
        else:
            stops = False
        if stops:
            self.state[3:6] = 0.0
        else:
            found = self._choose_impact(touching, target, before)
            if found is None:
                self.status = Status.ITERATION_LIMIT
                return
            self.state[3:6] = found
        self.state[3:6][np.abs(self.state[3:6]) < 1e-3 * speed] = 0.0
        on_base = [name for name in self._resting() if name in BASE]
        slip = 0
        if on_base:
            along = float(self._row(on_base[0], self.state, along=True)[0] @ self.state[3:6])
            slip = int(np.sign(along)) if abs(along) > speed else 0
        self.grip = Grip(tuple(n for n in self.points if n in self._resting()), slip)

    def _choose_impact(
        self, touching: set[str], target: dict[str, float], before: Array
    ) -> Array | None:
        """Velocities after an impact; where wall and foot share a push, any share will do."""
        found = self._choose(before, self.state, touching, 0, target)
        if found is not None:
            return found[1].rates
        for foot in set(BASE) & touching:
            # As held by its wall along the base, whose push friction may take over in part.
            grip = Grip((foot, *WALL), self.wall or 1)
            saved, self.friction = self.friction, 0.0
            answer = self._solve(grip, before, self.state, target)
            self.friction = saved
            pushes = answer.normal["low"] >= -self.friction * answer.normal[foot]
            if pushes and answer.normal["high"] >= 0.0 and answer.normal[foot] >= 0.0:
                return answer.rates
        return None

    def _stays(self, touching: set[str]) -> bool:
        """Whether points that the wall has thrown back come back from next to nothing."""
        near = self._resting() & set(BASE)
        found = self._choose(
            self._pull(self.time, self.state) / self.masses, self.state, near, self.grip.slip, {}
        )
        if found is None:
            return False
        speed, pulled = 0.0, 0.0
        for name in touching & set(WALL):
            row, more = self._row(name, self.state)
            leaves = float(row @ self.state[3:6])
            if leaves > speed:
                speed, pulled = leaves, -float(row @ found[1].rates + more)
        swing = 2.0 * self.half_height * self.rest_rotation
        if pulled > 0.0 and speed * speed <= 2.0 * pulled * swing:
            self.tail = 2.0 * speed / pulled / max(1.0 - self.rebound, 1e-6)
            return True
        return False

    def _settle(self, before: float) -> None:
        """The rest rule of a block that has come down flat."""
        after = abs(float(self.state[5]))
        calm = self.state.copy()
        calm[5] = 0.0
        free = self._pull(self.time, calm) / self.masses
        down = {}
        for name, sign in (("right", 1.0), ("left", -1.0)):
            found = self._choose(free, calm, {name}, self.grip.slip, {})
            down[name] = sign * float(found[1].rates[2]) if found is not None else -1.0
        weaker = min(down.values())
        if weaker > 0.0 and after * after <= 2.0 * weaker * self.rest_rotation:
            kept = after / max(before, after)
            first, second = ("right", "left") if self.state[5] < 0.0 else ("left", "right")
            lost = max(1.0 - kept * kept, 1e-6)
            self.tail = 2.0 * after * (1.0 / down[first] + kept / down[second]) / lost
            self.state[4:6] = 0.0
            if self.grip.slip == 0:
                self.state[3] = 0.0
            self.grip = Grip(BASE, int(np.sign(self.state[3])))

    # What is seen.

    def _slide(self, state: Array) -> float:
        foot = self.points["right" if state[2] <= 0.0 else "left"]
        return float(state[0] + self._lever(foot, state)[0] - foot[0])

    def _note(self, state: Array) -> None:
        self.peak = max(self.peak, abs(float(state[2])))
        self.peak_slide = max(self.peak_slide, abs(self._slide(state)))
        for tie in self.ties:
            stretch = self._stretch(tie, state)
            self.peak_tie_elongation = max(self.peak_tie_elongation, stretch)
            self.peak_tie_force = max(self.peak_tie_force, abs(tie.force(stretch)))

    def _take_samples(self, part: slice, values: Array) -> None:
        self.rotation[part] = -values[2]
        self.x[part] = values[0]

    @property
    def tie_energy_lost(self) -> float:
        """Energy that the ties have taken [J]."""
        total = 0.0
        for tie in self.ties:
            free, lost = tie.free, tie.lost
            tie.settle(self._stretch(tie, self.state))
            total += tie.lost
            tie.free, tie.lost = free, lost
        return total

    @property
    def energy_lost(self) -> float:
        """Energy lost in impacts, to friction and by the ties [J]."""
        return self.lost + float(self.state[6]) + self.tie_energy_lost

    @property
    def slide(self) -> float:
        """Slide of the lower corner at the end [m]."""
        return self._slide(self.state)


RTOL = 1e-13
"""Relative tolerance of DOP853."""


def slide(lanes: Lanes, motions: GroundMotions, lane: int, times: SampleTimes) -> SlidingRun:
    """Runs one lane of blocks that walls, ties and loads hold, with sliding.

    Args:
        lanes: Held blocks, shape [lane].
        motions: Motions of the same lanes, along x.
        lane: Index of the lane.
        times: Duration and sampling.
    """
    assert not isinstance(motions, SpatialMotions | UprightMotions)
    run = SlidingRun(lanes, lane, times, RTOL)
    run.start(float(lanes.rotation_start[lane]))
    scan = float(motions.shortest_period[lane]) / SCANS_PER_PERIOD
    for segment in base_segments(motions, lane):
        if segment.start < times.duration and not run.overturned:
            run.follow(segment, scan)
    return run


def _at(lever: Vector, force: Vector) -> Array:
    """A force at a lever from the centre: along x and z, and its moment."""
    return np.array([force[0], force[1], lever[0] * force[1] - lever[1] * force[0]])
