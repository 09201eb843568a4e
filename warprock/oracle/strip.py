"""A strip of wall for the oracle: Newton's law of its two bodies, with the forces at their edges.

Unknown are the angular accelerations of both bodies, the forces of the base and at the hinge, and
that of the floor along the base: seven numbers, of seven linear equations. Three a body are the
balances of forces and of moments about its centre; the last one keeps the point below the floor
from moving sideways. Velocity steps and impacts are the same equations for impulses and what the
velocities gain.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.optimize import brentq

from warprock.model.response import SampleTimes
from warprock.model.strip import LAID, Strip
from warprock.oracle.block_mechanics import PivotingBlock, Vector, turned
from warprock.oracle.block_swings import BlockRun
from warprock.oracle.lane_run import friction_for, root_between
from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]

ROUNDS = 50
"""Newton's steps for the turn of the upper body, most of which are not needed."""
AT_FALL = 1e-12
"""Distance from there [rad] from which on it has come to it."""
JUST_BEFORE = 1e-12
"""Time [s] before a strip falls at which its contacts are looked at for the last time."""


class Levers(NamedTuple):
    """Where the edges of both bodies are, seen from their centres, and how the bodies turn.

    Attributes:
        base: The edge on the base from the lower centre [m].
        below: The hinge from the lower centre [m].
        above: The hinge from the upper centre [m].
        top: The point below the floor from the upper centre [m].
        rates: Angular velocities for a tilt rate of 1, counter-clockwise.
    """

    base: Vector
    below: Vector
    above: Vector
    top: Vector
    rates: Vector


class StripWall(PivotingBlock):
    """A strip of wall, whose tilt is that of its lower body."""

    def __init__(
        self,
        sizes: tuple[float, float, float],
        density: float,
        restitution: float | None,
        strip: Strip,
        lane: int,
    ) -> None:
        """Cuts a block in two.

        Args:
            sizes: Full width, height and depth of the strip [m].
            density: [kg/m^3].
            restitution: Prescribed ratio of the angular velocities after and before an impact.
            strip: The strips of all lanes.
            lane: The lane.
        """
        super().__init__(*sizes, density, restitution)
        width, height = sizes[:2]
        self.half, self.heights = 0.5 * width, (float(strip.lower[lane]), float(strip.upper[lane]))
        self.masses = tuple(self.mass * each / height for each in self.heights)
        self.inertias = tuple(
            mass * (width**2 + each**2) / 12.0
            for mass, each in zip(self.masses, self.heights, strict=True)
        )
        self.weight = float(strip.weight[lane])
        arms = strip.arm[lane].tolist()
        self.bearing = {side: side * (arms[side > 0] - self.half) for side in (1, -1)}
        self.laid = {side: self._laid(side) for side in (1, -1)}
        self.critical_tilt = min(self.falling_tilt(side, 0.0) for side in (1, -1))

    def _hinge(self, side: int, tilt: float) -> Vector:
        """Where the hinge is, from the middle of the base [m]."""
        x, y = turned((-2.0 * side * self.half, self.heights[0]), -side * tilt)
        return x + side * self.half, y

    def _shift(self, side: int, tilt: float, turn: float) -> float:
        """How far the point below the floor would have moved outwards, were it free [m]."""
        lever = (self.bearing[side] + side * self.half, self.heights[1])
        x = self._hinge(side, tilt)[0] + turned(lever, side * turn)[0]
        return float(side * (x - self.bearing[side]))

    def _laid(self, side: int) -> float:
        """Tilt at which one of the bodies lies [rad]."""
        if self._shift(side, LAID, LAID) < 0.0:
            return LAID
        found: float = brentq(lambda tilt: self._shift(side, tilt, LAID), 0.0, LAID, xtol=1e-15)
        return found

    def falling_tilt(self, side: int, friction: float) -> float:
        """Tilt at which a base acceleration of friction x g would just hold the strip [rad]."""
        base = (side * friction * GRAVITY, 0.0)
        if self.tilt_acceleration(side, self.laid[side], base) < 0.0:
            return self.laid[side]
        found: float = brentq(
            lambda tilt: self.tilt_acceleration(side, tilt, base), 0.0, self.laid[side], xtol=1e-15
        )
        return found

    def _levers(self, side: int, tilt: float) -> Levers:
        """The edges at a tilt; the turn of the upper body keeps the top in place."""
        (lower, upper), b = self.heights, side * self.half
        turn = 0.0
        span = (self.bearing[side] + b, upper)
        for _ in range(ROUNDS):
            change = self._shift(side, tilt, turn) / turned(span, side * turn)[1]
            turn += change
            if abs(change) <= 1e-16 * abs(turn):
                break
        first, second = -side * tilt, side * turn
        ratio = self._hinge(side, tilt)[1] / turned(span, second)[1]
        return Levers(
            turned((b, -0.5 * lower), first),
            turned((-b, 0.5 * lower), first),
            turned((-b, -0.5 * upper), second),
            turned((self.bearing[side], 0.5 * upper), second),
            (-side, side * ratio),
        )

    def _solve(
        self, at: Levers, gained: tuple[Vector, Vector], spins: Vector, apart: float,
        weight: float = 0.0, given: float | None = None,
    ) -> Array:  # fmt: skip
        """Angular gains of both bodies and the forces: of the base, at the hinge, of the floor.

        Args:
            at: Levers.
            gained: What the masses gain besides what turning gives them, over their mass.
            spins: What is added to the angular momenta, over their inertia.
            apart: What the point below the floor gains along the base besides turning.
            weight: On top [N].
            given: Angular gain of the lower body, instead of its balance of moments.
        """
        (m1, m2), (j1, j2) = self.masses, self.inertias
        c1 = (-at.base[0], -at.base[1])
        hinge = (at.below[0] - at.base[0], at.below[1] - at.base[1])
        c2 = (-at.above[0], -at.above[1])
        top = (at.top[0] - at.above[0], at.top[1] - at.above[1])
        rows = np.zeros((7, 7))
        rows[0, [0, 2, 4]] = -m1 * c1[1], -1.0, 1.0
        rows[1, [0, 3, 5]] = m1 * c1[0], -1.0, 1.0
        rows[2, :6] = j1, 0.0, at.base[1], -at.base[0], -at.below[1], at.below[0]
        rows[3, [0, 1, 4, 6]] = -m2 * hinge[1], -m2 * c2[1], -1.0, -1.0
        rows[4, [0, 1, 5]] = m2 * hinge[0], m2 * c2[0], -1.0
        rows[5, [1, 4, 5, 6]] = j2, at.above[1], -at.above[0], at.top[1]
        rows[6, :2] = -hinge[1], -top[1]
        (x1, y1), (x2, y2) = gained
        right = np.array(
            [m1 * x1, m1 * y1, j1 * spins[0], m2 * x2, m2 * y2 - weight, j2 * spins[1], apart]
        )
        right[5] -= at.top[0] * weight
        if given is not None:
            rows[2], right[2] = np.eye(7)[0], given
        return np.asarray(np.linalg.solve(rows, right))

    def _forces(self, side: int, tilt: float, rate: float, base: Vector) -> Array:
        """Angular accelerations and forces under a base acceleration."""
        at = self._levers(side, tilt)
        spin1, spin2 = (rate * each for each in at.rates)
        along, upwards = base[0], base[1] + GRAVITY
        hinge = (at.below[0] - at.base[0], at.below[1] - at.base[1])
        top = at.top[0] - at.above[0]
        lower = tuple(-(spin1**2) * each for each in at.base)
        upper = tuple(
            spin1**2 * each - spin2**2 * other for each, other in zip(hinge, at.above, strict=True)
        )
        return self._solve(
            at,
            ((lower[0] - along, lower[1] - upwards), (upper[0] - along, upper[1] - upwards)),
            (0.0, 0.0),
            spin1**2 * hinge[0] + spin2**2 * top,
            self.weight,
        )

    def tilt_acceleration(
        self, side: int, tilt: float, base_acceleration: Vector, rate: float = 0.0
    ) -> float:
        """Second time derivative of the tilt [rad/s^2]."""
        return -side * float(self._forces(side, tilt, rate, base_acceleration)[0])

    def _step(self, side: int, tilt: float, velocity_step: Vector) -> Array:
        """Angular gains and impulses at a velocity step of the base."""
        thrown = (-velocity_step[0], -velocity_step[1])
        return self._solve(self._levers(side, tilt), (thrown, thrown), (0.0, 0.0), 0.0)

    def rate_step(self, side: int, tilt: float, velocity_step: Vector) -> float:
        """Step of the tilt rate [rad/s] that a velocity step of the base causes."""
        return -side * float(self._step(side, tilt, velocity_step)[0])

    def _impact(self, side: int, rate: float, given: float | None) -> Array:
        """Angular velocities after an impact, of the mechanism of the other side, and impulses."""
        old, new = self._levers(side, 0.0), self._levers(-side, 0.0)
        spin1, spin2 = (rate * each for each in old.rates)
        hinge = (old.below[0] - old.base[0], old.below[1] - old.base[1])
        lower = (spin1 * old.base[1], -spin1 * old.base[0])
        upper = (
            -spin1 * hinge[1] + spin2 * old.above[1],
            spin1 * hinge[0] - spin2 * old.above[0],
        )
        return self._solve(new, (lower, upper), (spin1, spin2), 0.0, given=given)

    def rate_after_impact(self, side: int, rate: float) -> float:
        """Tilt rate bowed to the other side, after the strip has come back upright."""
        if self._restitution is not None:
            return -rate * self._restitution
        return side * float(self._impact(side, rate, None)[0])

    def contact_force(
        self, side: int, tilt: float, rate: float, base_acceleration: Vector
    ) -> Vector:
        """Force at base or hinge [N], of the two that which needs more friction."""
        return _worse(self._forces(side, tilt, rate, base_acceleration))

    def step_impulse(self, side: int, tilt: float, velocity_step: Vector) -> Vector:
        """Impulse at base or hinge at a velocity step [N s]: that which needs more friction."""
        return _worse(self._step(side, tilt, velocity_step))

    def impact_impulse(self, side: int, before: float, after: float) -> Vector:
        """Impulse at base or hinge in an impact [N s]: that which needs more friction."""
        return _worse(self._impact(side, before, side * after))

    def kinetic_energy(self, rate: float) -> float:
        """Kinetic energy of the upright strip [J]."""
        at = self._levers(1, 0.0)
        spin1, spin2 = (rate * each for each in at.rates)
        hinge = (at.below[0] - at.base[0], at.below[1] - at.base[1])
        upper = math.hypot(
            -spin1 * hinge[1] + spin2 * at.above[1], spin1 * hinge[0] - spin2 * at.above[0]
        )
        speeds = (spin1 * math.hypot(*at.base), upper)
        twice = [
            mass * speed**2 + inertia * spin**2
            for mass, speed, inertia, spin in zip(
                self.masses, speeds, self.inertias, (spin1, spin2), strict=True
            )
        ]
        return 0.5 * sum(twice)


def _worse(found: Array) -> Vector:
    """Of the forces of the base and at the hinge that which needs more friction."""
    forces = [(float(found[2]), float(found[3])), (float(found[4]), float(found[5]))]
    return max(forces, key=friction_for)


class StripRun(BlockRun):
    """One lane's run of a strip, whose fall depends on its side."""

    block: StripWall
    looks = 12

    def __init__(self, block: StripWall, times: SampleTimes, rtol: float, friction: float) -> None:
        """Puts the strip upright; see `BlockRun`."""
        self._fall_tilts = {side: block.falling_tilt(side, min(friction, 1.0)) for side in (1, -1)}
        super().__init__(block, times, rtol, friction)

    @property
    def laid(self) -> float:
        """Tilt at which a body of the strip lies [rad]."""
        return self.block.laid[self.side]

    def _falls(self, tilt: float, rate: float) -> bool:
        return tilt >= self._fall_tilts[self.side] and rate >= 0.0

    def _judge(self, dense: Callable[[Any], Array], begin: float, end: float) -> None:
        """Up to where the strip falls, at which what it needs may be largest."""
        past = self._fall_tilts[self.side]
        if dense(begin)[0] < past and dense(end)[0] > past - AT_FALL:
            end = root_between(lambda time: dense(time)[0] - past, begin, end) - JUST_BEFORE
        super()._judge(dense, begin, end)
