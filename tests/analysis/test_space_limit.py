"""Limit analysis in space against closed forms, the plane, and symmetry."""

from __future__ import annotations

import numpy as np
import pytest

from tests.shared.assemblies import tilted_wall
from tests.shared.marks import first
from warprock.analysis.load_limit import CONE_SIDES, collapse_load, weaker_collapse
from warprock.model import patterns
from warprock.model.assembly import Piece, assemble
from warprock.model.solids import SpatialAssembly, assemble_solids

ACROSS = 0.5 * np.pi
WITHIN = np.cos(np.pi / CONE_SIDES)
"""Friction of a pyramid in the cone over that of the one around it."""


def built(pieces: list[Piece], friction: float) -> SpatialAssembly:
    return assemble_solids(pieces, density=2000.0, friction=friction)


def turned(pieces: list[Piece], angle: float) -> list[Piece]:
    c, s = np.cos(angle), np.sin(angle)
    matrix = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    return [each._replace(corners=each.corners @ matrix.T) for each in pieces]


@pytest.mark.parametrize("depth", first(1, [0.1, 0.3]))
def test_a_wall_out_of_its_plane_turns_over_its_edge(depth: float):
    """At thickness / height, whatever its bond; in the plane it bears far more."""
    wall = built(patterns.extruded(patterns.wall(0.4, 0.2, 3, 4, whole_first=True), depth), 0.7)
    for direction in (ACROSS, -ACROSS):
        found = collapse_load(wall, direction)
        assert found.load_factor == pytest.approx(depth / 0.8, rel=1e-6)
        assert found.inner_load_factor == pytest.approx(found.load_factor, rel=1e-6)
        assert not found.upper_bound
        # It turns about the edge of the lowest course, on which it falls.
        assert found.velocity[1:, 4:] == pytest.approx(0.0, abs=1e-6)


def test_a_wall_turned_about_the_vertical_has_the_same_load_in_the_direction_turned():
    pieces = patterns.extruded(patterns.wall(0.4, 0.2, 2, 3, whole_first=True), 0.15)
    for angle in (0.3, -2.1):
        found = collapse_load(built(turned(pieces, angle), 0.7), ACROSS + angle)
        assert found.load_factor == pytest.approx(0.15 / 0.6, rel=1e-6)


def test_blocks_of_the_plane_have_its_load_in_space():
    """The pyramid in the cone has edges along x, so its load is that of the plane, exactly."""
    pieces = patterns.wall(0.4, 0.2, 3, 4, whole_first=True)
    flat = collapse_load(assemble(pieces, depth=0.2, density=2000.0, friction=0.5))
    found = collapse_load(built(patterns.extruded(pieces, 0.2), 0.5))
    assert flat.upper_bound
    assert found.inner_load_factor == pytest.approx(flat.load_factor, rel=1e-5)
    assert found.inner_load_factor <= found.load_factor <= found.inner_load_factor / WITHIN
    arch = patterns.arch(10.0, 1.5, np.radians(157.5), 7)
    oppenheim = collapse_load(built(patterns.extruded(arch, 1.0), 100.0))
    assert oppenheim.load_factor == pytest.approx(0.3736, abs=5e-5)
    assert oppenheim.opens.sum() == 4


@pytest.mark.thorough
def test_a_wall_on_a_tilting_table_has_the_load_of_an_outside_program_between_its_bounds():
    """16.73 degrees, as in the plane; turned about the vertical, too."""
    wall = patterns.extruded(tilted_wall(), 0.1)
    for angle in (0.0, 0.7):
        found = collapse_load(built(turned(wall, angle), np.tan(np.radians(26.0))), angle)
        # The angle is told to a hundredth of a degree, which is 2e-4 of load, for rounded outlines.
        told = np.tan(np.radians(16.73))
        assert found.inner_load_factor - 3e-4 < told < found.load_factor + 3e-4
        assert found.load_factor <= found.inner_load_factor / WITHIN


@pytest.mark.thorough
def test_the_load_with_coulombs_law_is_that_of_the_plane():
    pieces = patterns.wall(0.4, 0.175, 2, 6, whole_first=False)
    flat = collapse_load(assemble(pieces, depth=0.2, density=2000.0, friction=0.65))
    found = collapse_load(built(patterns.extruded(pieces, 0.2), 0.65))
    assert flat.coulomb_load < 0.999 * flat.load_factor
    # There may be several such loads: those of walls 1 and 3 lie within 0.2 % of others'.
    assert found.coulomb_load == pytest.approx(flat.coulomb_load, rel=2e-3)


@pytest.mark.parametrize("direction", [0.0, 0.4, ACROSS])
def test_what_slides_slides_at_its_friction_in_any_direction(direction: float):
    drums = built(patterns.extruded(patterns.column(1.0, 0.5, 2), 1.0), 0.3)
    found = collapse_load(drums, direction)
    assert found.slides.any()
    # 0.3 lies between the loads of the two pyramids.
    assert WITHIN * 0.3 - 1e-7 <= found.inner_load_factor <= 0.3 + 1e-7
    assert 0.3 - 1e-7 <= found.load_factor <= 0.3 / WITHIN + 1e-7


def test_the_weakest_direction_of_a_column_is_across_its_sides():
    """Of a square column to any of four sides, not to a corner; of a flat one to its faces."""
    square = patterns.extruded(patterns.column(1.0, 0.5, 8), 1.0)
    flat = patterns.extruded(patterns.column(0.4, 1.0, 1), 0.3)
    for pieces, side, least in ((square, ACROSS, 0.25), (flat, np.pi, 0.3)):
        for angle in (0.0, 0.3, 2.0):
            found = weaker_collapse(built(turned(pieces, angle), 5.0))
            assert found.load_factor == pytest.approx(least, rel=1e-6)
            off = (found.direction - angle - ACROSS + 0.5 * side) % side - 0.5 * side
            assert off == pytest.approx(0.0, abs=1e-3)
    corner = collapse_load(built(square, 5.0), 0.25 * np.pi)
    assert corner.load_factor == pytest.approx(0.25 * np.sqrt(2.0), rel=1e-6)


def test_mirrored_walls_with_returns_have_mirrored_loads():
    pieces = patterns.corner(0.4, 0.2, 2, 3, 0.2, return_blocks=2, returns=1)
    mirrored = [each._replace(corners=each.corners * [1.0, -1.0, 1.0]) for each in pieces]
    loads = [collapse_load(built(pieces, 0.7), -ACROSS).load_factor]
    loads.append(collapse_load(built(mirrored, 0.7), ACROSS).load_factor)
    assert loads[1] == pytest.approx(loads[0], rel=1e-6)
    # The return holds the wall: without it the wall bears its thickness over its height.
    assert loads[0] > 0.2 / 0.6
