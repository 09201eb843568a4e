"""Limit analysis against answers in closed form and of others."""

from __future__ import annotations

import numpy as np
import pytest

from tests.shared.assemblies import tilted_wall
from warprock.analysis.load_limit import Collapse, collapse_load
from warprock.model import patterns
from warprock.model.assembly import Assembly, Piece, assemble

NO_SLIDING = 100.0
"""A friction coefficient at which nothing slides."""


def built(pieces: list[Piece], friction: float) -> Assembly:
    return assemble(pieces, depth=1.0, density=2000.0, friction=friction)


def arch(voussoirs: int, thickness: float, friction: float, embrace: float = np.pi) -> Collapse:
    return collapse_load(built(patterns.arch(1.0, thickness, embrace, voussoirs), friction))


@pytest.mark.parametrize(
    ("voussoirs", "least"),
    # Of ever more voussoirs the limit is that of Milankovitch (1907), 0.1075.
    [(7, 0.0957), (15, 0.1061), (27, 0.1067), (201, 0.10746)],
)
def test_the_least_thickness_of_a_semicircular_arch(voussoirs: int, least: float):
    """Half a unit of the last digit either way."""
    half = 0.5 * 10.0 ** -len(f"{least}".partition(".")[2])
    assert not arch(voussoirs, least - half, NO_SLIDING).stands
    found = arch(voussoirs, least + half, NO_SLIDING)
    assert found.stands
    assert not found.upper_bound


@pytest.mark.parametrize(
    ("friction", "least"), [(0.31, 0.196), (0.33, 0.173), (0.35, 0.151), (0.38, 0.121)]
)
def test_an_arch_that_slides_has_to_be_thicker(friction: float, least: float):
    assert not arch(27, least - 6e-4, friction).stands
    found = arch(27, least + 6e-4, friction)
    assert found.stands
    assert found.upper_bound


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("pieces", "bound", "coulomb"),
    [
        (patterns.wall(0.4, 0.175, 5, 6, whole_first=False), 0.64286, 0.63982),
        (
            patterns.wall(
                0.4,
                0.175,
                4,
                11,
                whole_first=True,
                openings=[patterns.Opening(0.6, 0.525, 0.4, 0.875)],
            ),
            0.40369,
            0.35582,
        ),
    ],
    ids=["wall 1", "wall 3"],
)
def test_a_wall_whose_joints_slide_has_a_load_with_coulombs_law(
    pieces: list[Piece], bound: float, coulomb: float
):
    """Walls of Ferris and Tin-Loi (2001), who solve for it as a complementarity problem.

    There may be several such loads; those found here lie within 0.2 % of theirs.
    """
    found = collapse_load(built(pieces, 0.65))
    assert found.load_factor == pytest.approx(bound, abs=6e-6)
    assert found.upper_bound
    assert found.coulomb_load == pytest.approx(coulomb, rel=2e-3)
    still = collapse_load(built(patterns.column(1.0, 0.5, 6), 0.7))
    assert still.coulomb_load == still.load_factor


def test_no_thickness_makes_up_for_too_little_friction():
    assert not arch(27, 0.5, 0.30).stands
    assert not arch(27, 1.0, 0.30).stands


@pytest.mark.parametrize(("voussoirs", "factor"), [(7, 0.3736), (27, 0.3538)])
def test_the_arch_of_oppenheim(voussoirs: int, factor: float):
    """Oppenheim (1992) has 0.37 for his seven voussoirs: four hinges."""
    found = arch(voussoirs, 0.15, NO_SLIDING, np.radians(157.5))
    assert found.load_factor == pytest.approx(factor, abs=5e-5)
    assert found.opens.sum() == 4
    assert not found.upper_bound


@pytest.mark.parametrize(("friction", "factor", "slides"), [(0.7, 1.0 / 6.0, 0), (0.15, 0.15, 1)])
def test_a_column_of_drums_tips_as_one_block_or_slides(friction: float, factor: float, slides: int):
    found = collapse_load(built(patterns.column(1.0, 0.5, 12), friction))
    assert found.load_factor == pytest.approx(factor, rel=1e-9)
    assert found.slides.any() == slides
    if not slides:
        # About the corner of the lowest drum to +x; the centre of the highest moves at 1 m/s.
        turning = 1.0 / np.hypot(0.5, 5.75)
        assert found.velocity[1:, 2] == pytest.approx(-turning)


def test_walls_of_ferris_and_tin_loi():
    """Walls 1 and 3 of Ferris and Tin-Loi (2001), associative."""
    first = built(patterns.wall(0.4, 0.175, 5, 6, whole_first=False), 0.65)
    third = built(
        patterns.wall(
            0.4, 0.175, 4, 11, whole_first=True, openings=[patterns.Opening(0.6, 0.525, 0.4, 0.875)]
        ),
        0.65,
    )
    assert (first.count, third.count) == (34, 47)
    for wall, factor in ((first, 0.64286), (third, 0.40369)):
        found = collapse_load(wall)
        assert found.load_factor == pytest.approx(factor, abs=6e-6)
        assert found.upper_bound
        # Walls and their mirror images.
        assert collapse_load(wall, np.pi).load_factor == pytest.approx(factor, abs=6e-6)


def test_a_wall_and_an_arch_on_a_tilting_table():
    """As Hua, Buzzetti, Pingaro, da Silva and Milani (2025) have them, to a hundredth of a degree.

    Program LACT3, samples `wall` and `arch_1`: bounds from both sides meet there. The arch is a
    semicircle of 27 voussoirs, of which the lowest two are fixed.
    """
    wall = collapse_load(built(tilted_wall(), np.tan(np.radians(26.0))), 0.0)
    arch = patterns.arch(0.34515, 0.0563, np.pi * 25.0 / 27.0, 25)
    hinged = collapse_load(built(arch, np.tan(np.radians(30.0))))
    for found, angle in ((wall, 16.73), (hinged, 17.10)):
        assert np.degrees(np.arctan(found.load_factor)) == pytest.approx(angle, abs=0.01)
    assert wall.upper_bound
    assert not hinged.upper_bound


def test_a_strip_wall_that_is_held_at_its_top():
    """Two bodies with a crack at half the height: 2 t / (x h), t / h = 1 / 14, x = 1 / 2."""
    t, h, low = 0.25, 3.5, 1e-3
    pieces = [
        Piece("ground", patterns.rectangle(0.0, -1.0, t, 0.0), fixed=True),
        Piece("lower", patterns.rectangle(0.0, 0.0, t, 0.5 * h)),
        Piece("upper", patterns.rectangle(0.0, 0.5 * h, t, h)),
        Piece("roof", patterns.rectangle(t, h - low, t + 1.0, h + low), fixed=True),
    ]
    found = assemble(pieces, depth=1.0, density=2000.0, friction=NO_SLIDING, head_friction=0.0)
    load = collapse_load(found)
    # The roof holds the last millimetre of the wall, not its top alone.
    assert load.load_factor == pytest.approx(2.0 * t / (0.5 * h), rel=2.0 * low)
    assert load.opens.tolist() == [True, True, False]
    assert load.slides.tolist() == [False, False, True]
    assert not load.upper_bound


@pytest.mark.parametrize("pieces", [patterns.arch(3.0, 0.5, 2.5, 9), patterns.column(1.0, 0.7, 4)])
def test_forces_scale_with_the_weight_and_not_with_the_size(pieces: list[Piece]):
    """A larger assembly and one elsewhere have the same load factor."""
    factor = collapse_load(built(pieces, 0.6)).load_factor
    for scale, shift in ((100.0, 0.0), (0.01, 0.0), (1.0, 50.0)):
        moved = [each._replace(corners=scale * each.corners + shift) for each in pieces]
        assert collapse_load(built(moved, 0.6)).load_factor == pytest.approx(factor, rel=1e-6)


def test_the_mechanism_keeps_joints_from_closing_and_balances_work():
    """The kinematic theorem: the load's power is that which the weight takes up."""
    found = arch(11, 0.15, NO_SLIDING)
    assert found.parting.min() > -1e-9
    assembly = found.assembly
    power = (assembly.mass * found.velocity[:, 0]).sum() * found.load_factor
    assert power == pytest.approx((assembly.mass * found.velocity[:, 1]).sum(), rel=1e-6)
