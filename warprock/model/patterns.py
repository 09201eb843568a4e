"""Patterns of assemblies as blocks: arches, walls in bond and of dry stone, columns, frames.

In space: any of these with a depth, walls that meet at corners, and barrel vaults.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from warprock.model.assembly import Array, Piece

ABUTMENT = 0.5
"""Depth of what is fixed below an assembly, over the size of a block."""

STONE_LENGTHS, COURSE_HEIGHTS = 0.6, 0.5
"""Largest difference of a stone's length and of a course's height from the mean, over the mean, at
a variation of 1."""

LEAN, SLOPE = math.radians(12.0), 0.2
"""Largest angle of a head joint from upright, and difference in level between the ends of a bed
over the mean height of a course, at a variation of 1."""

BOND = 0.25
"""Least distance between the head joints of two courses at the bed between them, over the mean
length of a stone, that is tried for."""

TRIES = 20
"""Lengths that are tried for a stone until it bonds; the last one is taken as it is."""

SLIVER = 1e-6
"""Least part of a block that is left beside an opening, over its length."""


class Opening(NamedTuple):
    """A rectangle that is left out of a wall, from its lower left corner [m]."""

    left: float
    bottom: float
    width: float
    height: float


def rectangle(left: float, bottom: float, right: float, top: float) -> Array:
    """Corners counterclockwise from the lower left one [m], shape [4, 2]."""
    return np.array([[left, bottom], [right, bottom], [right, top], [left, top]])


def arch(mean_radius: float, thickness: float, embrace: float, voussoirs: int) -> list[Piece]:
    """A circular arch with radial joints, its centre at the origin.

    Args:
        mean_radius: Of the middle line [m].
        thickness: Across it [m], less than twice the radius.
        embrace: Angle between the springings [rad], at most pi.
        voussoirs: How many, numbered from the left springing.
    """
    angles = 0.5 * math.pi + embrace * np.linspace(0.5, -0.5, voussoirs + 1)
    rays = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    inner, outer = (mean_radius - 0.5 * thickness) * rays, (mean_radius + 0.5 * thickness) * rays
    pieces = [
        Piece(str(k + 1), np.array([inner[k], inner[k + 1], outer[k + 1], outer[k]]))
        for k in range(voussoirs)
    ]
    for name, k, side in (("left abutment", 0, 1.0), ("right abutment", -1, -1.0)):
        away = ABUTMENT * thickness * side * np.array([-rays[k, 1], rays[k, 0]])
        face = [inner[k], outer[k]]
        corners = np.array([*face, *(each + away for each in reversed(face))])
        pieces.append(Piece(name, corners, fixed=True))
    return pieces


def wall(
    block_length: float,
    block_height: float,
    blocks: int,
    courses: int,
    *,
    whole_first: bool,
    openings: Sequence[Opening] = (),
) -> list[Piece]:
    """A wall in running bond on fixed ground, its lower left corner at the origin.

    Every other course begins and ends with half a block; openings cut blocks.

    Args:
        block_length: [m].
        block_height: [m].
        blocks: Length of the wall in blocks.
        courses: How many.
        whole_first: Whether the lowest course begins with a whole block.
        openings: Rectangles left out, whose bottoms and tops are those of courses.
    """
    length = blocks * block_length
    ground = rectangle(0.0, -ABUTMENT * block_height, length, 0.0)
    pieces = [Piece("ground", ground, fixed=True)]
    for course in range(courses):
        low, high = course * block_height, (course + 1) * block_height
        middle = 0.5 * (low + high)
        cuts = [each for each in openings if each.bottom < middle < each.bottom + each.height]
        whole = whole_first == (course % 2 == 0)
        places = np.arange(blocks + 1.0) if whole else np.r_[0.0, np.arange(blocks) + 0.5, blocks]
        left_over = _left_over(places * block_length, cuts, SLIVER * block_length)
        pieces += [
            Piece(f"{course + 1}.{number}", rectangle(left, low, right, high))
            for number, (left, right) in enumerate(left_over, 1)
        ]
    return pieces


def dry_stone(
    wall_length: float,
    wall_height: float,
    stone_length: float,
    stone_height: float,
    variation: float,
    seed: int,
) -> list[Piece]:
    """A random wall of dry stone in courses on fixed ground, its lower left corner at the origin.

    Heights of courses and lengths of stones are drawn evenly about their means; beds slope, and
    head joints lean. A stone whose end would lie close above or below a head joint is drawn again.

    Args:
        wall_length: [m].
        wall_height: [m].
        stone_length: Mean length of a stone [m].
        stone_height: Mean height of a course [m].
        variation: How much stones differ, from 0 (all alike) to 1.
        seed: What the random numbers begin with; the same wall for the same seed.
    """
    draw = np.random.default_rng(seed)
    beds = _beds(draw, wall_length, wall_height, stone_height, variation)
    ground = rectangle(0.0, -ABUTMENT * stone_height, wall_length, 0.0)
    pieces, below = [Piece("ground", ground, fixed=True)], np.empty(0)
    for course, (bed, top) in enumerate(itertools.pairwise(beds)):
        joints = _head_joints(draw, wall_length, stone_length, variation, below, course % 2 == 1)
        middle = 0.5 * (bed.mean() + top.mean())
        lean = np.zeros(len(joints) + 2)
        lean[1:-1] = np.tan(variation * LEAN * draw.uniform(-1.0, 1.0, len(joints)))
        places = np.r_[0.0, joints, wall_length]
        ends = [_meet(level, places, lean, middle, wall_length) for level in (bed, top)]
        pieces += [
            Piece(
                f"{course + 1}.{number + 1}",
                np.array([*ends[0][number : number + 2], *ends[1][number : number + 2][::-1]]),
            )
            for number in range(len(places) - 1)
        ]
        below = ends[1][1:-1, 0]
    return pieces


def _beds(
    draw: np.random.Generator, length: float, height: float, course: float, variation: float
) -> Array:
    """Levels of the two ends of every bed from the ground to the top [m], shape [bed, 2]."""
    count = max(round(height / course), 1)
    heights = 1.0 + variation * COURSE_HEIGHTS * draw.uniform(-1.0, 1.0, count)
    levels = np.r_[0.0, np.cumsum(heights)] * height / heights.sum()
    slope = 0.5 * SLOPE * variation * height / count * draw.uniform(-1.0, 1.0, count + 1)
    # The ground and the top are level.
    slope[[0, -1]] = 0.0
    return np.stack([levels - slope, levels + slope], axis=1)


def _head_joints(
    draw: np.random.Generator,
    length: float,
    stone: float,
    variation: float,
    below: Array,
    half_first: bool,
) -> Array:
    """Where the head joints of a course are, at half of its height [m]."""
    found: list[float] = []
    at = 0.0
    while True:
        mean = 0.5 * stone if half_first and not found else stone
        for _ in range(TRIES):
            end = at + mean * (1.0 + variation * STONE_LENGTHS * draw.uniform(-1.0, 1.0))
            if not len(below) or np.abs(below - end).min() > BOND * stone:
                break
        # What is left is a stone at least half as long as others.
        if end > length - (0.5 - SLIVER) * stone:
            return np.array(found)
        found.append(end)
        at = end


def _meet(bed: Array, places: Array, lean: Array, middle: float, length: float) -> Array:
    """Where leaning head joints meet a bed [m], shape [joint, 2]; their places are at `middle`."""
    slope = (bed[1] - bed[0]) / length
    # x = place + lean (y - middle), y = bed + slope x.
    x = (places + lean * (bed[0] - middle)) / (1.0 - lean * slope)
    return np.stack([x, bed[0] + slope * x], axis=1)


def _left_over(
    places: Array, cuts: Sequence[Opening], least: float
) -> Iterator[tuple[float, float]]:
    """What openings leave of the blocks of a course between some places, from left to right."""
    for block in zip(places[:-1].tolist(), places[1:].tolist(), strict=True):
        parts = [block]
        for cut in cuts:
            ends = [((a, min(b, cut.left)), (max(a, cut.left + cut.width), b)) for a, b in parts]
            parts = [(a, b) for pair in ends for a, b in pair if b - a > least]
        yield from parts


def column(drum_width: float, drum_height: float, drums: int) -> list[Piece]:
    """Equal drums on fixed ground, numbered from below; the middle of the ground at the origin."""
    half = 0.5 * drum_width
    ground = rectangle(-half, -ABUTMENT * drum_height, half, 0.0)
    return [
        Piece("ground", ground, fixed=True),
        *(
            Piece(str(k + 1), rectangle(-half, k * drum_height, half, (k + 1) * drum_height))
            for k in range(drums)
        ),
    ]


def frame(
    column_width: float, column_height: float, columns: int, span: float, beam_height: float
) -> list[Piece]:
    """Equal columns on fixed ground under one beam, the lower left corner at the origin.

    Args:
        column_width: [m].
        column_height: [m].
        columns: How many.
        span: Clear distance between neighbours [m].
        beam_height: Of the beam, which ends with the outer columns [m].
    """
    lefts = np.arange(columns) * (column_width + span)
    length, top = float(lefts[-1] + column_width), column_height + beam_height
    ground = rectangle(0.0, -ABUTMENT * column_width, length, 0.0)
    return [
        Piece("ground", ground, fixed=True),
        *(
            Piece(f"column {k + 1}", rectangle(left, 0.0, left + column_width, column_height))
            for k, left in enumerate(lefts.tolist())
        ),
        Piece("beam", rectangle(0.0, column_height, length, top)),
    ]


def extruded(pieces: Sequence[Piece], depth: float) -> list[Piece]:
    """Blocks of a pattern in the plane as prisms: their x along x, their y upwards.

    Args:
        pieces: Blocks in the plane.
        depth: Along y, half of it to either side of the plane [m].
    """
    return [
        each._replace(corners=_prism(each.corners, -0.5 * depth, 0.5 * depth)) for each in pieces
    ]


def _prism(section: Array, front: float, back: float) -> Array:
    """Corners of a prism between two levels of y [m], shape [2 corner, 3]."""
    ends = [np.insert(section, 1, level, axis=1) for level in (front, back)]
    return np.concatenate(ends)


def _box(low: Sequence[float], high: Sequence[float]) -> Array:
    """Corners of a box between its lowest and its highest coordinates [m], shape [8, 3]."""
    return np.array(list(itertools.product(*zip(low, high, strict=True))))


def corner(
    block_length: float,
    block_height: float,
    blocks: int,
    courses: int,
    depth: float,
    *,
    return_blocks: int,
    returns: int,
    openings: Sequence[Opening] = (),
) -> list[Piece]:
    """A wall along x with returns: walls along y that are bonded with its ends, on fixed ground.

    In the first course, the third and so on the wall along x runs through and the returns butt
    against it; in the others the returns run through. The outer corner of wall and first return is
    the origin; the front of the wall faces -y.

    Args:
        block_length: [m].
        block_height: [m].
        blocks: Length of the wall along x in blocks.
        courses: How many.
        depth: Thickness of the walls [m], less than the length of a block.
        return_blocks: Length of a return in blocks, the thickness of the wall included.
        returns: 1 at the end at the origin, or 2 at both ends.
        openings: Rectangles left out of the wall along x, as in `wall`.
    """
    length, across = blocks * block_length, return_blocks * block_length
    ground = _box([0.0, 0.0, -ABUTMENT * block_height], [length, depth, 0.0])
    pieces = [Piece("ground", ground, fixed=True)]
    lefts = {"left": 0.0, "right": length - depth} if returns == 2 else {"left": 0.0}
    for side, left in lefts.items():
        low, high = [left, depth, -ABUTMENT * block_height], [left + depth, across, 0.0]
        pieces.append(Piece(f"{side} ground", _box(low, high), fixed=True))
    for course in range(courses):
        bed, top = course * block_height, (course + 1) * block_height
        through = course % 2 == 0
        begin, end = (0.0 if through else depth), length
        if returns == 2 and not through:
            end -= depth
        cuts = [
            each for each in openings if each.bottom < 0.5 * (bed + top) < each.bottom + each.height
        ]
        places = _left_over(_bricks(begin, end, block_length), cuts, SLIVER * block_length)
        pieces += [
            Piece(f"{course + 1}.{number}", _box([a, 0.0, bed], [b, depth, top]))
            for number, (a, b) in enumerate(places, 1)
        ]
        ends = _bricks(depth if through else 0.0, across, block_length)
        for side, left in lefts.items():
            pieces += [
                Piece(f"{side} {course + 1}.{number}", _box([left, a, bed], [left + depth, b, top]))
                for number, (a, b) in enumerate(itertools.pairwise(ends.tolist()), 1)
            ]
    return pieces


def _bricks(begin: float, end: float, length: float) -> Array:
    """Where whole blocks from the beginning of a course end, and the rest of one at its end [m]."""
    whole = int((end - begin) / length + SLIVER)
    places = begin + length * np.arange(whole + 1.0)
    return np.append(places, end) if end - places[-1] > SLIVER * length else places


def vault(
    mean_radius: float,
    thickness: float,
    embrace: float,
    voussoirs: int,
    blocks: int,
    depth: float,
    *,
    whole_first: bool,
) -> list[Piece]:
    """A barrel vault: an arch whose courses, from springing to springing, run along y in bond.

    Every other course begins and ends with half a block. Block 3.2 is the second one of the third
    course from the left springing.

    Args:
        mean_radius: As in `arch` [m].
        thickness: As in `arch` [m].
        embrace: As in `arch` [rad].
        voussoirs: Courses from springing to springing.
        blocks: Length of the vault in blocks.
        depth: Length of the vault along y [m].
        whole_first: Whether the course at the left springing begins with a whole block.
    """
    pieces = []
    for place, each in enumerate(arch(mean_radius, thickness, embrace, voussoirs)):
        whole = whole_first == (place % 2 == 0)
        parts = np.arange(blocks + 1.0) if whole else np.r_[0.0, np.arange(blocks) + 0.5, blocks]
        ends = [0.0, depth] if each.fixed else (parts * depth / blocks).tolist()
        for number, (front, back) in enumerate(itertools.pairwise(ends), 1):
            name = each.name if each.fixed else f"{each.name}.{number}"
            own = _prism(each.corners, front - 0.5 * depth, back - 0.5 * depth)
            pieces.append(Piece(name, own, each.fixed))
    return pieces
