"""Patterns of assemblies: arches, walls in running bond, columns of drums and frames, as blocks."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from warprock.model.assembly import Array, Piece

ABUTMENT = 0.5
"""Depth of what is fixed below an assembly, over the size of a block."""

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
