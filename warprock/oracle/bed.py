"""The oracle's block on compliant ground, by forces at points of its base.

The block is a body in the plane that obeys Newton's and Euler's equations. The ground presses at
the nodes of a Gauss rule on that part of the base that is below its surface, by depth and speed of
each node. Along the base the ground holds the lower corner without acceleration. SciPy's
`solve_ivp` (DOP853) is stopped where a corner dips in or lifts off, and where the block comes
upright or falls.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from warprock.model.response import SampleTimes, Status
from warprock.oracle.block_base import BaseSegment
from warprock.oracle.block_mechanics import Vector, cross, turned
from warprock.oracle.lane_run import LaneRun, ends_at, friction_for, looks_in
from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]

NODES, WEIGHTS = np.polynomial.legendre.leggauss(3)
"""Nodes in the pressed part of the base: moments of its pressure are of degree 2 along it."""
PHASE = 0.2
"""Longest step of DOP853 times the fastest rate: its dense output, on which events lie, is of a
lower order."""
JUST_BEFORE = 1e-12
"""A solve shorter than this part of the run got nowhere; an event at a lean lies so far before it
[rad]."""
LET_OFF = 0.05
"""Length of the solve that frees a block which got nowhere, over the longest step. It does not stop
where the block is upright."""


class BedRun(LaneRun):
    """One lane's run: the state and what has happened so far."""

    def __init__(
        self,
        sizes: tuple[float, float, float],
        density: float,
        bed: tuple[float, float],
        times: SampleTimes,
        rtol: float,
        friction: float,
    ) -> None:
        """Lays the block on the ground.

        Args:
            sizes: Full width, height and depth [m].
            density: [kg/m^3].
            bed: Stiffness [N/m^3] and damping [N s/m^3] a unit of area.
            times: Duration and sampling.
            rtol: Relative tolerance of DOP853.
            friction: Of the contact; beyond its angle and the slenderness angle contacts are not
                judged.
        """
        super().__init__(times, rtol)
        width, height, self.thickness = sizes
        self.mass = density * width * height * self.thickness
        self.inertia = self.mass * (width * width + height * height) / 12.0
        self.corners: tuple[Vector, Vector] = (
            (-0.5 * width, -0.5 * height),
            (0.5 * width, -0.5 * height),
        )
        self.width, self.height = width, height
        self.stiffness, self.damping = bed
        area = width * self.thickness
        lightness = 1.0 / self.mass + 0.25 * width**2 / self.inertia
        swing = math.sqrt(self.stiffness * area * lightness)
        self.longest = PHASE / max(swing, self.damping * area * lightness)
        self.sunk = self.mass * GRAVITY / (self.stiffness * area)
        # Place of the centre, turn to -x, their rates, and the energy that dampers took.
        self.state: Array = np.array([0.0, 0.5 * height - self.sunk, 0.0, 0.0, 0.0, 0.0, 0.0])
        self.pressed = [True, True]
        self.side = 1
        self.fall_tilt = math.atan2(width, height) + math.atan(min(friction, 1.0))

    @property
    def flat(self) -> bool:
        """Whether the whole face is pressed."""
        return all(self.pressed)

    @property
    def energy_lost(self) -> float:
        """Energy that the dampers took [J]."""
        return float(self.state[6])

    def start(self, rotation: float) -> None:
        """Releases the block in balance upon the ground from a rotation [rad] at rest."""
        self.side = 1 if rotation >= 0.0 else -1
        lean = abs(rotation)
        raised = self.width * math.sin(lean)
        # The pressure is a trapezium on the whole base, or a triangle at one end.
        depth = self.sunk + 0.5 * raised
        if depth < raised:
            depth = math.sqrt(2.0 * raised * self.sunk)
            self.pressed[0 if self.side > 0 else 1] = False
            self.uplift_time, self.rest_time = 0.0, math.nan
        lever = turned(self.corners[0 if self.side < 0 else 1], -rotation)
        foot = self.corners[0 if self.side < 0 else 1][0]
        self.state[:3] = foot - lever[0], -depth - lever[1], -rotation
        self.peak = lean
        self._fill(0.0, lambda times: np.full(len(times), rotation))

    def _levers(self, turn: float) -> tuple[Vector, Vector]:
        """Both corners of the base from the centre."""
        return turned(self.corners[0], turn), turned(self.corners[1], turn)

    def _depth(self, corner: int, state: Array) -> float:
        return -float(state[1]) - self._levers(float(state[2]))[corner][1]

    def _push(self, state: Array) -> tuple[float, float, float]:
        """Force of the ground upwards [N], its moment about the centre [N m], power lost [W]."""
        levers, omega, fall = self._levers(float(state[2])), float(state[5]), float(state[4])
        depths = [self._depth(corner, state) for corner in (0, 1)]
        if not any(self.pressed):
            return 0.0, 0.0, 0.0
        low, high = 0.0, 1.0
        if not all(self.pressed):
            edge = depths[0] / (depths[0] - depths[1])
            low, high = (0.0, edge) if self.pressed[0] else (edge, 1.0)
        force = moment = lost = 0.0
        for node, weight in zip(NODES, WEIGHTS, strict=True):
            part = low + 0.5 * (high - low) * (1.0 + node)
            area = 0.5 * (high - low) * weight * self.width * self.thickness
            x, z = (a + part * (b - a) for a, b in zip(*levers, strict=True))
            depth, speed = -float(state[1]) - z, -(fall + omega * x)
            pressure = self.stiffness * depth + self.damping * speed
            force += pressure * area
            moment += x * pressure * area
            lost += self.damping * speed * speed * area
        return force, moment, lost

    def _sideways(self, state: Array, moment: float, along: float) -> float:
        """Force along the base that leaves the lower corner no acceleration there [N]."""
        x, z = self._levers(float(state[2]))[0 if self.side < 0 else 1]
        lightness = 1.0 / self.mass + z * z / self.inertia
        omega = float(state[5])
        return (along + z * moment / self.inertia + omega * omega * x) / lightness

    def _derivative(self, time: float, state: Array) -> Array:
        along = self.acceleration(time)[0]
        force, moment, lost = self._push(state)
        grip = self._sideways(state, moment, along)
        lever = self._levers(float(state[2]))[0 if self.side < 0 else 1]
        spin = (moment + cross(lever, (grip, 0.0))) / self.inertia
        return np.array(
            [
                *state[3:6],
                grip / self.mass - along,
                force / self.mass - GRAVITY,
                spin,
                lost,
            ]
        )

    def follow(self, segment: BaseSegment, _scan: float) -> None:
        """Follows one segment of the motion."""
        stop = min(segment.stop, self.duration)
        self.acceleration = segment.acceleration
        if segment.velocity_step[0]:
            self._step(segment.velocity_step[0])
        stuck = False
        while self.time < stop and not self.overturned and self.status == Status.OK:
            # A block that starts upright first moves off: else it would stop there at once.
            before = self.time
            self._solve(min(stop, before + LET_OFF * self.longest) if stuck else stop, not stuck)
            stuck = self.time - before <= JUST_BEFORE * stop and not stuck

    def _step(self, velocity_step: float) -> None:
        """A velocity step of the base: the impulse along it leaves the corner its velocity."""
        x, z = self._levers(float(self.state[2]))[0 if self.side < 0 else 1]
        impulse = velocity_step / (1.0 / self.mass + z * z / self.inertia)
        self.state[3] += impulse / self.mass - velocity_step
        self.state[5] += cross((x, z), (impulse, 0.0)) / self.inertia

    def _events(self, upright: bool) -> list[Any]:
        """What stops a solve, and what is noted on its way."""
        events = [self._corner(0), self._corner(1)]
        if upright:
            events.append(ends_at(lambda _t, y: -self.side * y[2], "upright"))
        events.append(ends_at(lambda _t, y: 0.5 * math.pi + self.side * y[2], "fall"))
        # A little before, so that the contact is judged at the end.
        judged = self.fall_tilt - JUST_BEFORE
        if -self.side * float(self.state[2]) < judged - JUST_BEFORE:
            events.append(ends_at(lambda _t, y: judged + self.side * y[2], "judged"))
        turn = ends_at(lambda _t, y: -self.side * y[5], "turn")
        turn.terminal = False
        return [*events, turn]

    def _corner(self, corner: int) -> Any:
        """The event of a corner that lifts off, or dips in."""
        down = 1.0 if self.pressed[corner] else -1.0
        return ends_at(lambda _t, y: down * self._depth(corner, y), "corner", corner)

    def _solve(self, stop: float, upright: bool) -> None:
        events = self._events(upright)
        found = self._solved(self.state, stop, self.longest, events)
        for time in found.t_events[-1]:
            self._note(float(time), found.sol(time))
        self._judge(found)
        self._fill(found.t[-1], lambda times: -found.sol(times)[2])
        self.time, self.state = float(found.t[-1]), np.array(found.y[:, -1])
        self._note(self.time, self.state)
        pairs = zip(events[:-1], found.t_events, strict=False)
        happened = next((event for event, times in pairs if len(times)), None)
        if happened is not None:
            self._happen(happened)

    def _happen(self, event: Any) -> None:
        """What a stop changes."""
        if event.kind == "upright":
            self.state[2] = 0.0
            self.side = -self.side
        elif event.kind == "fall":
            self.overturned = True
            self.state[2] = -self.side * 0.5 * math.pi
            turn = -float(self.state[2])
            self._fill(math.inf, lambda times: np.full(len(times), turn))
        elif event.kind == "corner":
            whole, touching = self.flat, any(self.pressed)
            self.pressed[event.what] = not self.pressed[event.what]
            if whole:
                self._note_uplift(self.time)
            if self.flat:
                self.rest_time = self.time
            if self.flat or not touching:
                self._note_impact()

    def _judge(self, found: Any) -> None:
        """Notes the friction that the contact needs on a way."""

        def needed(time: float) -> float:
            state = found.sol(time)
            lean, rate = -self.side * state[2], -self.side * state[5]
            if self._falls(lean, rate):
                return 0.0
            force, moment, _ = self._push(state)
            return friction_for((self._sideways(state, moment, self.acceleration(time)[0]), force))

        self._look_at(needed, looks_in(found).tolist())

    def _note(self, time: float, state: Array) -> None:
        """Notes a rotation."""
        self._note_peak(time, abs(float(state[2])))

    def finish(self) -> None:
        """Counts where the run ends as a candidate for the peak."""
        self._note(self.time, self.state)
