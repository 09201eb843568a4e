"""What a picture shows of what holds a block: its wall, its ties, its load, the rest of its frame.

Each part is drawn between points that are fixed to what moves: the base, the block, or a point of
which the path is known. So a picture needs the motion of the block and of the base besides, and no
law of a tie or a frame. A frame's columns stand at a distance, and ties end at one, that the model
does not know: those are the picture's.
"""

from __future__ import annotations

import dataclasses
import enum
import math
from collections.abc import Iterator, Sequence

import numpy as np
import numpy.typing as npt

from warprock.model.hold import Frame, Hold, TopLoad
from warprock.model.lanes import Lanes
from warprock.model.tie_states import TieState, tie_elongations, tie_history

Array = npt.NDArray[np.float64]

MOST_COLUMNS = 6
"""Columns of a frame that are shown at most."""
THICK = 0.15
"""Thickness of a transverse wall as it is shown, over the height of the block, at least."""
AWAY = 0.3
"""Length of a tie without a wall over the height of the block; with twice its width more."""
ARROW = (0.08, 0.25)
"""Shortest and longest arrow of a load over the height of the block."""
BEAM = (0.06, 0.25)
"""Least and most height of the beam of a frame over that of its columns."""

MARGIN = 0.08
"""Part of the length of what stands on a base by which the base goes on beyond it."""


class Look(enum.StrEnum):
    """What a part is, and so how it looks."""

    WALL = "wall"
    ANCHOR = "anchor"
    COLUMN = "column"
    BEAM = "beam"
    TIE = "tie"
    LOAD = "load"


@dataclasses.dataclass(frozen=True)
class Mover:
    """What points of parts are fixed to.

    Attributes:
        on: "base", "block", or "path".
        shift: How far along x from it [m].
        path: Places beside the base along x and z of a mover with a path [m], shape [sample, 2].
    """

    on: str
    shift: float = 0.0
    path: Array | None = None


@dataclasses.dataclass(frozen=True)
class Part:
    """A part of a picture in the plane of rocking.

    Attributes:
        look: What it is. Walls, columns and beams are quadrilaterals, anchors and ties lines, loads
            arrows from their first point to their second.
        movers: Mover of each point.
        points: Places along x and z [m], shape [point, 2]: on a base from its middle, on a block
            from its middle as it turns, on a path from its point.
        states: What a tie does at every sample; None of others.
    """

    look: Look
    movers: tuple[Mover, ...]
    points: Array
    states: npt.NDArray[np.int8] | None = None

    def places(self, base: Array, block: Array) -> Array:
        """Its points over time [m], shape [sample, point, 2].

        Args:
            base: Displacement of the base along x and z, shape [sample, 2].
            block: Place of the middle of the block along x and z, and its rotation, shape
                [sample, 3].
        """
        found = np.empty((len(base), len(self.points), 2))
        for k, (mover, point) in enumerate(zip(self.movers, self.points, strict=True)):
            x, z = point
            if mover.on == "block":
                c, s = np.cos(block[:, 2]), np.sin(block[:, 2])
                found[:, k] = block[:, :2] + np.stack([c * x + s * z, c * z - s * x], axis=-1)
            else:
                found[:, k] = base + point
            if mover.path is not None:
                found[:, k] += mover.path
            found[:, k, 0] += mover.shift
        return found


BASE, BLOCK = Mover("base"), Mover("block")

ON_BASE = (Look.WALL, Look.ANCHOR, Look.COLUMN)
"""Parts that stand on the base."""


def standing(parts: Sequence[Part]) -> tuple[float, float]:
    """Where on the base that which stands on it begins and ends along x, with a margin [m]."""
    found = [
        mover.shift + point[0]
        for part in parts
        if part.look in ON_BASE
        for mover, point in zip(part.movers, part.points, strict=True)
    ]
    if not found:
        return 0.0, 0.0
    low, high = float(min(found)), float(max(found))
    return low - MARGIN * (high - low), high + MARGIN * (high - low)


def scene_parts(lanes: Lanes, times: Array, pose: Array, first_break: float) -> tuple[Part, ...]:
    """What holds the block of one lane, as a picture shows it.

    Args:
        lanes: That lane alone.
        times: Of the samples [s].
        pose: Place of the middle of its block along x and z beside its base [m], and its rotation
            [rad], shape [3, sample].
        first_break: When the first of its ties broke [s]; NaN if none did.
    """
    if lanes.hold is None:
        return ()
    size = float(lanes.width[0]), float(lanes.height[0])
    parts = [*_wall(lanes.hold, size), *_ties(lanes.hold, size, times, pose, first_break)]
    if lanes.hold.load is not None:
        parts += _load(lanes.hold.load, size, pose)
    if lanes.hold.frame is not None:
        parts += _frame(lanes.hold.frame, size, pose)
    return tuple(parts)


def _wall(hold: Hold, size: tuple[float, float]) -> Iterator[Part]:
    if hold.wall is None:
        return
    near = 0.5 * size[0] * float(hold.wall[0])
    far = near + float(hold.wall[0]) * _thickness(size)
    yield _standing_part(Look.WALL, [(near, 0.0), (far, 0.0), (far, size[1]), (near, size[1])])


def _thickness(size: tuple[float, float]) -> float:
    return max(size[0], THICK * size[1])


def _standing_part(look: Look, points: list[tuple[float, float]]) -> Part:
    """A part that stands on the base."""
    return Part(look, (BASE,) * len(points), np.array(points))


def _ties(
    hold: Hold, size: tuple[float, float], times: Array, pose: Array, first_break: float
) -> Iterator[Part]:
    """Ties, and what they end at: the far side of the wall, or posts as high as they."""
    ties = hold.ties
    if ties is None:
        return
    elongation = tie_elongations(ties, *size, pose)
    states = tie_history(ties, elongation, times, first_break).states
    highest: dict[float, float] = {}
    for tie in range(ties.count):
        side, height = float(ties.side[0, tie]), float(ties.height[0, tie])
        walled = hold.wall is not None and float(hold.wall[0]) == side
        length = _thickness(size) if walled else AWAY * size[1] + 2.0 * size[0]
        end = side * (0.5 * size[0] + length)
        points = [(0.5 * side * size[0], height - 0.5 * size[1]), (end, height)]
        yield Part(Look.TIE, (BLOCK, BASE), np.array(points), states[tie])
        if walled:
            half = 0.04 * size[1]
            yield _standing_part(Look.ANCHOR, [(end, height - half), (end, height + half)])
        else:
            highest[end] = max(height, highest.get(end, 0.0))
    for end, height in highest.items():
        yield _standing_part(Look.ANCHOR, [(end, 0.0), (end, height + 0.04 * size[1])])


def _load(load: TopLoad, size: tuple[float, float], pose: Array) -> Iterator[Part]:
    """Arrows of the weight and of the thrust, as long as these are beside each other."""
    x, z, rotation = pose
    weight, thrust = float(load.weight[0]), float(load.thrust[0])
    largest = max(weight, abs(thrust))

    def length(force: float) -> float:
        return size[1] * max(ARROW[0], ARROW[1] * abs(force) / largest)

    half = 0.5 * size[1]
    middle = np.stack([x + half * np.sin(rotation), z + half * np.cos(rotation)], axis=-1)
    if weight > 0.0:
        place = float(load.eccentricity[0])
        if load.stays[0]:
            # Where the top is at the place that the weight keeps, and no further than its ends.
            half_width = 0.5 * size[0]
            along = (place - middle[:, 0]) / np.cos(rotation)
            along = np.clip(along, -half_width, half_width)
        else:
            along = np.full(len(x), place)
        arm = np.stack([along * np.cos(rotation), -along * np.sin(rotation)], axis=-1)
        yield _arrow(middle + arm, (0.0, length(weight)))
    if thrust != 0.0:
        sign = math.copysign(1.0, thrust)
        corner = -0.5 * sign * size[0]
        arm = np.stack([corner * np.cos(rotation), -corner * np.sin(rotation)], axis=-1)
        yield _arrow(middle + arm, (-sign * length(thrust), 0.0))


def _arrow(path: Array, tail: tuple[float, float]) -> Part:
    """An arrow to a point that moves; its tail goes with it."""
    mover = Mover("path", path=path)
    return Part(Look.LOAD, (mover, mover), np.array([tail, (0.0, 0.0)]))


def _frame(frame: Frame, size: tuple[float, float], pose: Array) -> Iterator[Part]:
    """The columns beside the block, and the beam on their higher corners, which does not turn.

    The beam is as high as its mass makes it of the columns' material, within `BEAM`.
    """
    width, height = size
    count = min(int(frame.columns[0]), MOST_COLUMNS)
    apart = max(2.5 * width, 0.6 * height)
    first = -apart * ((count - 1) // 2)
    shifts = [first + apart * k for k in range(count)]
    half = 0.5 * np.array([(-width, -height), (width, -height), (width, height), (-width, height)])
    for shift in shifts:
        if shift != 0.0:
            yield Part(Look.COLUMN, (Mover("block", shift),) * 4, half)
    x, z, rotation = pose
    corner = np.where(rotation > 0.0, -0.5 * width, 0.5 * width)
    top = 0.5 * height
    moved = x + corner * (np.cos(rotation) - 1.0) + top * np.sin(rotation)
    raised = z + top * np.cos(rotation) - corner * np.sin(rotation)
    mover = Mover("path", path=np.stack([moved, raised], axis=-1))
    low, high = shifts[0] - width, shifts[-1] + width
    thick = float(frame.mass_ratio[0]) * count * width * height / (high - low)
    thick = min(max(thick, BEAM[0] * height), BEAM[1] * height)
    points = [(low, 0.0), (high, 0.0), (high, thick), (low, thick)]
    yield Part(Look.BEAM, (mover,) * 4, np.array(points))


TIE_WORDS = {
    TieState.SLACK: "slack",
    TieState.TAUT: "taut",
    TieState.YIELDING: "yields",
    TieState.BROKEN: "broken",
}
"""What a tie does, as a picture says it."""
