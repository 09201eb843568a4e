"""Mechanics of two stacked rigid blocks, from one Jacobian.

Sources of the model: Psycharis (1990), Spanos, Roussis and Politis (2001), Kounadis (2015). Planar
motion; no sliding and no flight at either contact, so each contact is a pivot or is closed.

The frame moves with the base: x along the base, z up. A rotation theta is clockwise, so that
theta > 0 leans towards +x. A *pattern* is a pair (ground, interface) of signs: the corner on
which the lower block pivots and the corner on which the upper one does, 0 for a contact that is
closed (lower block flat; upper block glued to the lower one). Four patterns follow: both rock,
the stack rocks as one, only the upper block rocks, rest.

Nothing here is typed from closed formulas. In a pattern the centres are sums of levers turned by
the two rotations, so that the six velocities v = (x1', z1', theta1', x2', z2', theta2') are
J(pattern) q' with q' = (theta1', theta2'). With M = diag(m1, m1, I1, m2, m2, I2), forces F of
gravity and of the base's acceleration, and G the free columns of a pattern (closed contacts take
a column away or join two):

- accelerations: G' J' M (J G a + J' q') = G' J' F, with the reaction R = M v' - F;
- impacts and velocity steps: v+ = J G a closest to v- in the norm of M (angular momentum of the
  whole about the new ground pivot and of the upper block about the new interface pivot), with
  the reaction R = M (v+ - v-).

A closed contact whose normal reaction N acts at e holds while N (c - s e) >= 0 for both corners
s: the work of R in opening about that corner. N e stands there, not e, for N may be zero.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]
Pair = tuple[float, float]

GROUND, INTERFACE = 0, 1
"""The two contacts, as indices."""
SIDES = (1, -1)
ROUND_OFF = 1e-12
"""Part of the largest moment of a reaction that counts as zero."""
SAME_MOTION = 1e-9
"""Relative difference of velocities below which two candidates are one motion."""


@dataclasses.dataclass(frozen=True)
class TwoBlocks:
    """Two homogeneous rectangular blocks, the lower one first in every pair.

    Masses and moments of inertia are those of the full rectangles: the mass that a chamfer takes
    away is ignored. A chamfer only moves the corners inwards on which a block pivots.

    Attributes:
        width: Full widths [m].
        height: Full heights [m].
        depth: Full depths across the plane of rocking [m].
        density: [kg/m^3].
        chamfer: What the chamfers take off the half widths of a block's faces [m].
    """

    width: Pair
    height: Pair
    depth: Pair = (1.0, 1.0)
    density: Pair = (1.0, 1.0)
    chamfer: Pair = (0.0, 0.0)

    def __post_init__(self) -> None:
        for name in ("width", "height", "depth", "density"):
            if not all(math.isfinite(v) and v > 0.0 for v in getattr(self, name)):
                raise ValueError(f"{name}: got {getattr(self, name)}, must be > 0")
        for chamfer, width in zip(self.chamfer, self.width, strict=True):
            if not 0.0 <= chamfer < 0.5 * width:
                raise ValueError(
                    f"chamfer: got {chamfer} m, must be >= 0 m and below half of {width} m"
                )

    @property
    def mass(self) -> Pair:
        """Masses [kg]."""
        lower, upper = (
            math.prod(sizes)
            for sizes in zip(self.width, self.height, self.depth, self.density, strict=True)
        )
        return lower, upper

    @property
    def ground_half_width(self) -> float:
        """Distance of the ground pivots from the lower block's middle [m]."""
        return 0.5 * self.width[0] - self.chamfer[0]

    @property
    def interface_half_width(self) -> float:
        """Distance of the interface pivots from the blocks' middle [m]."""
        return min(w / 2.0 - c for w, c in zip(self.width, self.chamfer, strict=True))


class Pattern(NamedTuple):
    """The corners on which the blocks pivot: -1 or +1, 0 where a contact is closed."""

    ground: int
    interface: int


REST = Pattern(0, 0)


class Choice(NamedTuple):
    """A pattern chosen among candidates.

    Attributes:
        pattern: The pattern.
        motion: Rates [rad/s] or accelerations [rad/s^2] of the rotations in it, shape [block].
        admissible_count: Admissible candidates that differ in motion; one is expected.
        pulls: Whether a pivot would have to pull its block down.
    """

    pattern: Pattern
    motion: Array
    admissible_count: int
    pulls: bool


def opening(pattern: Pattern, motion: npt.ArrayLike) -> Pair:
    """How far (how fast) each contact is open (opens), from rotations (rates), >= 0 if true."""
    first, second = np.asarray(motion)
    return pattern.ground * float(first), pattern.interface * float(second - first)


def _place(x: float, z: float, rotation: float) -> Pair:
    """A lever turned clockwise."""
    c, s = math.cos(rotation), math.sin(rotation)
    return x * c + z * s, z * c - x * s


def _slope(x: float, z: float, rotation: float) -> Pair:
    """Derivative of a turned lever by its rotation."""
    c, s = math.cos(rotation), math.sin(rotation)
    return z * c - x * s, -x * c - z * s


def _size(reaction: Array) -> float:
    return float(np.abs(reaction).sum())


def _different(choices: list[Choice]) -> int:
    """How many of some choices differ in motion; 0 of none."""
    motions = np.array([choice.motion for choice in choices]).reshape(-1, 2)
    size = SAME_MOTION * float(np.abs(motions).max(initial=0.0))
    return sum(
        all(float(np.abs(motion - other).max()) > size for other in motions[:index])
        for index, motion in enumerate(motions)
    )


class StackMechanics:
    """Everything instantaneous about two stacked blocks; rotations and rates have shape [block]."""

    def __init__(self, blocks: TwoBlocks) -> None:
        """Derives masses and levers."""
        self.half_width = (blocks.ground_half_width, blocks.interface_half_width)
        self.half_height = (0.5 * blocks.height[0], 0.5 * blocks.height[1])
        self.mass = blocks.mass
        inertia = [
            m * (w * w + h * h) / 12.0
            for m, w, h in zip(self.mass, blocks.width, blocks.height, strict=True)
        ]
        first, second = self.mass
        self.masses = np.array([first, first, inertia[0], second, second, inertia[1]])
        self.slenderness_angle = tuple(map(math.atan2, blocks.width, blocks.height))
        self.base_force = -self.masses * np.array([1.0, 0.0, 0.0, 1.0, 0.0, 0.0])
        self.weight = -GRAVITY * self.masses * np.array([0.0, 1.0, 0.0, 0.0, 1.0, 0.0])
        self._reach = float(np.hypot(max(blocks.width), sum(blocks.height)))
        # The corner of the narrower face stands on the other block's face.
        upper, lower = (0.5 * blocks.width[k] - blocks.chamfer[k] for k in (1, 0))
        self._face = 0 if upper <= lower else 1

    def _levers(self, pattern: Pattern) -> tuple[Pair, Pair, Pair]:
        """Levers to the lower centre, to the interface pivot, and from it to the upper centre."""
        (b, c), (low, high) = self.half_width, self.half_height
        foot, edge = pattern.ground * b, pattern.interface * c
        return (-foot, low), (edge - foot, 2.0 * low), (-edge, high)

    def jacobian(self, pattern: Pattern, rotation: Array) -> Array:
        """J, shape [6, block]: the velocities of the two blocks from the rates of rotation."""
        first, second = rotation.tolist()
        centre, corner, upper = self._levers(pattern)
        (x1, z1), (x2, z2) = _slope(*centre, first), _slope(*corner, first)
        x3, z3 = _slope(*upper, second)
        return np.array(((x1, 0.0), (z1, 0.0), (1.0, 0.0), (x2, x3), (z2, z3), (0.0, 1.0)))

    def drift(self, pattern: Pattern, rotation: Array, rate: Array) -> Array:
        """Accelerations of the two blocks at even rates of rotation, shape [6]."""
        (first, second), (w1, w2) = rotation.tolist(), (rate * rate).tolist()
        centre, corner, upper = self._levers(pattern)
        (x1, z1), (x2, z2) = _place(*centre, first), _place(*corner, first)
        x3, z3 = _place(*upper, second)
        return np.array((-x1 * w1, -z1 * w1, 0.0, -x2 * w1 - x3 * w2, -z2 * w1 - z3 * w2, 0.0))

    def _closest(self, pattern: Pattern, jacobian: Array, momentum: Array) -> Array:
        """The motion of a pattern whose momentum is closest to one given, shape [block]."""
        if pattern == REST:
            return np.zeros(2)
        (a, c), (_, b) = (jacobian.T @ (self.masses[:, None] * jacobian)).tolist()
        first, second = (jacobian.T @ momentum).tolist()
        if pattern.interface == 0:
            both = (first + second) / (a + 2.0 * c + b)
            return np.array((both, both))
        if pattern.ground == 0:
            return np.array((0.0, second / b))
        area = a * b - c * c
        return np.array(((b * first - c * second) / area, (a * second - c * first) / area))

    def accelerations(
        self, pattern: Pattern, rotation: Array, rate: Array, base_acceleration: float
    ) -> tuple[Array, Array]:
        """Accelerations of the rotations [rad/s^2], shape [block], and the reaction R, shape [6].

        Args:
            pattern: Pattern, whose closed contacts the rates respect.
            rotation: [rad].
            rate: [rad/s].
            base_acceleration: [m/s^2].
        """
        jacobian = self.jacobian(pattern, rotation)
        force = self.weight + base_acceleration * self.base_force
        apparent = force - self.masses * self.drift(pattern, rotation, rate)
        bend = self._closest(pattern, jacobian, apparent)
        return bend, self.masses * (jacobian @ bend) - apparent

    def margins(self, pattern: Pattern, rotation: Array, reaction: Array) -> Array:
        """What keeps the closed contacts closed: N (c - s e), shape [contact, side].

        In N m for a force, N m s for an impulse; infinite for a contact that pivots.
        """
        found = np.full((2, 2), np.inf)
        for side, s in enumerate(SIDES):
            if pattern.interface == 0:
                turn = self.jacobian(Pattern(pattern.ground, s), rotation)[:, 1]
                found[INTERFACE, side] = s * float(turn @ reaction)
            if pattern.ground == 0:
                both = self.jacobian(Pattern(s, pattern.interface), rotation)
                turn = both[:, 0] if pattern.interface else both.sum(axis=1)
                found[GROUND, side] = s * float(turn @ reaction)
        return found

    def pulls(self, rotation: Array, reaction: Array) -> tuple[bool, bool]:
        """Whether ground and interface pull, normal to the ground and to the face there."""
        face = float(rotation[self._face])
        across = float(reaction[3] * math.sin(face) + reaction[4] * math.cos(face))
        ground = float(reaction[1] + reaction[4])
        return (
            ground < -ROUND_OFF * _size(reaction),
            across < -ROUND_OFF * _size(reaction[3:]),
        )

    def _holds(
        self,
        pattern: Pattern,
        closed: tuple[bool, bool],
        rotation: Array,
        found: tuple[Array, Array],
    ) -> bool:
        """Whether a candidate is admissible at its closed contacts."""
        motion, reaction = found
        opens = opening(pattern, motion)
        if any(closed[k] and pattern[k] != 0 and not opens[k] > 0.0 for k in (0, 1)):
            return False
        # What carries both blocks has the round-off of both, the interface that of the upper one.
        zero = ROUND_OFF * self._reach * np.array((_size(reaction), _size(reaction[3:])))
        return bool(np.all(self.margins(pattern, rotation, reaction) >= -zero[:, None]))

    def after_impulse(
        self,
        pattern: Pattern,
        rotation: Array,
        rate: Array,
        closed: tuple[bool, bool],
        velocity_step: float = 0.0,
    ) -> Choice:
        """Pattern and rates after an impact or a velocity step of the base.

        A candidate is admissible when the touching corners that it lifts do open, and touching
        contacts push, inside their width where they stay closed. A contact that is open keeps its
        pivot even if the impulse there pulls (`pulls` tells): the model has no flight. One
        candidate is expected. If there are several, or none, the one that dissipates least is
        taken, of the admissible ones or of those in which what is lifted opens; the count tells.

        Args:
            pattern: Pattern before.
            rotation: [rad].
            rate: Rates before [rad/s].
            closed: Whether ground and interface touch on their whole width at this moment.
            velocity_step: Of the base [m/s]; 0 for an impact.
        """
        before = self.masses * (self.jacobian(pattern, rotation) @ rate)
        before = before + velocity_step * self.base_force
        admissible: list[tuple[float, Choice]] = []
        opened: list[tuple[float, Choice]] = []
        for candidate in candidates(pattern, closed):
            jacobian = self.jacobian(candidate, rotation)
            motion = self._closest(candidate, jacobian, before)
            velocity = jacobian @ motion
            reaction = self.masses * velocity - before
            pulls = self.pulls(rotation, reaction)
            entry = Choice(candidate, motion, 1, any(pulls))
            energy = 0.5 * float(velocity @ (self.masses * velocity))
            opens = opening(candidate, motion)
            if all(opens[k] > 0.0 for k in (0, 1) if closed[k] and candidate[k]):
                opened.append((energy, entry))
            pushed = not any(pull and shut for pull, shut in zip(pulls, closed, strict=True))
            if pushed and self._holds(candidate, closed, rotation, (motion, reaction)):
                admissible.append((energy, entry))
        return self._least_lost(admissible or opened, len(admissible))

    def projected(self, pattern: Pattern, closing: Pattern, rotation: Array, rate: Array) -> Array:
        """Rates after contacts are closed that open too slowly to count, shape [block]."""
        momentum = self.masses * (self.jacobian(pattern, rotation) @ rate)
        return self._closest(closing, self.jacobian(closing, rotation), momentum)

    def _least_lost(self, entries: list[tuple[float, Choice]], count: int) -> Choice:
        """The entry of the largest energy; entries of one motion count as one."""
        _, best = max(entries, key=lambda entry: entry[0])
        return best._replace(admissible_count=min(count, _different([e for _, e in entries])))

    def after_force(
        self, pattern: Pattern, rotation: Array, rate: Array, base_acceleration: float
    ) -> Choice:
        """The pattern that the forces want, of those that leave the pivots where they are.

        Closed contacts stay closed, or open with an acceleration > 0. One candidate is expected;
        if there is none, the pattern stays. `pulls` also tells of a pivot that was there before.

        Args:
            pattern: Present pattern.
            rotation: [rad].
            rate: [rad/s].
            base_acceleration: [m/s^2].
        """
        closed = (pattern.ground == 0, pattern.interface == 0)
        chosen: list[Choice] = []
        present: Choice | None = None
        for candidate in candidates(pattern, closed):
            found = self.accelerations(candidate, rotation, rate, base_acceleration)
            pulls = any(self.pulls(rotation, found[1]))
            entry = Choice(candidate, found[0], 1, pulls)
            present = entry if candidate == pattern else present
            if self._holds(candidate, closed, rotation, found):
                chosen.append(entry)
        assert present is not None
        best = next((entry for entry in chosen if entry.pattern == pattern), None)
        best = best or next(iter(chosen), present)
        return best._replace(admissible_count=_different(chosen))

    def kinetic_energy(self, pattern: Pattern, rotation: Array, rate: Array) -> float:
        """Kinetic energy seen from the base [J]."""
        velocity = self.jacobian(pattern, rotation) @ rate
        return 0.5 * float(velocity @ (self.masses * velocity))

    def potential_energy(self, pattern: Pattern, rotation: Array) -> float:
        """Potential energy above the base [J]."""
        first, second = rotation.tolist()
        centre, corner, upper = self._levers(pattern)
        low = _place(*centre, first)[1]
        high = _place(*corner, first)[1] + _place(*upper, second)[1]
        return GRAVITY * (self.mass[0] * low + self.mass[1] * high)


def candidates(pattern: Pattern, closed: tuple[bool, bool]) -> list[Pattern]:
    """Patterns that may follow: any at a closed contact, the present pivot at an open one."""
    options = [(0, 1, -1) if shut else (s,) for s, shut in zip(pattern, closed, strict=True)]
    return list(itertools.starmap(Pattern, itertools.product(*options)))
