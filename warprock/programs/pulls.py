"""Ties and loads of a block as forces at its points, for programs that know neither.

Everything follows from where the block is in space, at each step anew: a tie's point turns with the
block, how far it moves along the base is the tie's elongation, and a tie keeps what it has yielded
and whether it broke. The force is that of the start of the step, so that its error is of the order
of the step, as that of these programs' contacts is.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Sequence

from warprock.model.hold import Hold

Vector = tuple[float, float, float]


@dataclasses.dataclass
class PulledTie:
    """A horizontal tie as the run goes on.

    Attributes:
        side: Side of the block that it pulls to, -1 or 1.
        point: Its point on the block, from the middle of the block along x and z [m].
        stiffness: [N/m].
        yield_force: [N].
        longest: Elongation at which it breaks [m].
        pushes: Whether it gives compression, too.
        free: Elongation at which it has no force [m].
        broken: Whether it broke.
    """

    side: float
    point: tuple[float, float]
    stiffness: float
    yield_force: float
    longest: float
    pushes: bool
    free: float
    broken: bool = False

    def force(self, elongation: float) -> float:
        """Tension at an elongation [m], in [N]; it yields and breaks on the way there."""
        self.broken = self.broken or elongation >= self.longest
        if self.broken:
            return 0.0
        force = self.stiffness * (elongation - self.free)
        if abs(force) > self.yield_force and (force > 0.0 or self.pushes):
            force = math.copysign(self.yield_force, force)
            self.free = elongation - force / self.stiffness
        return force if self.pushes else max(force, 0.0)


@dataclasses.dataclass(frozen=True)
class PulledLoad:
    """Forces on the middle of the top of a block, or beside it.

    Attributes:
        place: Distance of the weight to +x of the middle of the top [m].
        half_height: Of the block [m].
        weight: Downwards [N].
        thrust: Towards +x [N].
        stays: Whether the weight keeps its place while the block turns.
    """

    place: float
    half_height: float
    weight: float
    thrust: float
    stays: bool


class Pulls:
    """What pulls at the block of one lane, from step to step."""

    def __init__(self, hold: Hold, size: Sequence[float]) -> None:
        """Ties as they are while the block rests.

        Args:
            hold: What holds the block of this one lane, shape [1, ...].
            size: Width, depth and height of the block [m].
        """
        half_width, half_height = 0.5 * size[0], 0.5 * size[2]
        self._half_width = half_width
        self._ties = list(_ties(hold, half_width, half_height))
        self._load = _load(hold, half_height)

    def wrench(self, place: Sequence[float], base: float) -> tuple[float, ...]:
        """Forces on the block and their moments about its middle.

        Args:
            place: Of the middle of the block [m], and its quaternion (w, x, y, z).
            base: Displacement of the base along x [m].

        Returns:
            Force along x, y and z [N], moment about them [N m].
        """
        across, upwards = _axes(place)
        total = [0.0] * 6
        for tie in self._ties:
            lever = _combined(across, tie.point[0], upwards, tie.point[1])
            elongation = -tie.side * (float(place[0]) + lever[0] - base - tie.point[0])
            _add(total, lever, (tie.side * tie.force(elongation), 0.0, 0.0))
        load = self._load
        if load is not None:
            top = _combined(across, 0.0, upwards, load.half_height)
            _add(total, top, (load.thrust, 0.0, 0.0))
            at = _combined(across, load.place, upwards, load.half_height)
            if load.stays:
                at = (base + load.place - float(place[0]), 0.0, 0.0)
            _add(total, at, (0.0, 0.0, -load.weight))
        return tuple(total)


def _axes(place: Sequence[float]) -> tuple[Vector, Vector]:
    """Axes of a block that lie along x and z while it stands, in space."""
    w, x, y, z = (float(part) for part in place[3:7])
    across = (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y))
    upwards = (2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y))
    return across, upwards


def _combined(first: Vector, a: float, second: Vector, b: float) -> Vector:
    x, y, z = (a * one + b * other for one, other in zip(first, second, strict=True))
    return x, y, z


def _add(total: list[float], lever: Vector, force: Vector) -> None:
    """Adds a force at a lever to a sum of forces and moments."""
    (x, y, z), (fx, fy, fz) = lever, force
    parts = (fx, fy, fz, y * fz - z * fy, z * fx - x * fz, x * fy - y * fx)
    for k, part in enumerate(parts):
        total[k] += part


def _ties(hold: Hold, half_width: float, half_height: float) -> Iterator[PulledTie]:
    ties = hold.ties
    for tie in range(0 if ties is None else ties.count):
        assert ties is not None
        side = float(ties.side[0, tie])
        yield PulledTie(
            side=side,
            point=(side * half_width, float(ties.height[0, tie]) - half_height),
            stiffness=float(ties.stiffness[0, tie]),
            yield_force=float(ties.yield_force[0, tie]),
            longest=float(ties.slack[0, tie] + ties.ultimate_elongation[0, tie]),
            pushes=bool(ties.pushes[0, tie]),
            free=float(ties.free_length[0, tie]),
        )


def _load(hold: Hold, half_height: float) -> PulledLoad | None:
    load = hold.load
    if load is None:
        return None
    return PulledLoad(
        place=float(load.eccentricity[0]),
        half_height=half_height,
        weight=float(load.weight[0]),
        thrust=float(load.thrust[0]),
        stays=bool(load.stays[0]),
    )
