"""Blocks with joints: polygons, which of them touch where, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

from warprock.model import patterns
from warprock.model.assembly import Assembly, Piece, assemble


def built(pieces: list[Piece], **more: float) -> Assembly:
    return assemble(pieces, **{"depth": 1.0, "density": 2000.0, "friction": 0.6, **more})


def touching(found: Assembly) -> set[tuple[str, str]]:
    return {(found.names[a], found.names[b]) for a, b in found.joints.blocks}


def test_a_block_is_a_polygon_wherever_it_lies():
    far = np.array([1e4, -2e4])
    for shift in (np.zeros(2), far):
        corners = np.array([[0.0, 0.0], [3.0, 0.0], [0.0, 4.0]]) + shift
        ground = patterns.rectangle(0.0, -1.0, 3.0, 0.0) + shift
        found = built([Piece("ground", ground, fixed=True), Piece("1", corners[::-1])])
        assert found.area[1] == pytest.approx(6.0)
        assert found.centre[1] - shift == pytest.approx([1.0, 4.0 / 3.0])
        # Of a triangle the squares of its sides over 36.
        assert found.gyration[1] == pytest.approx((9.0 + 16.0 + 25.0) / 36.0)
        assert found.mass[1] == pytest.approx(12_000.0)


def test_a_wall_in_bond_has_bed_and_head_joints():
    found = built(patterns.wall(0.4, 0.2, 2, 2, whole_first=True), head_friction=0.3)
    assert found.names == ("ground", "1.1", "1.2", "2.1", "2.2", "2.3")
    beds = {("ground", "1.1"), ("ground", "1.2"), ("1.1", "2.1"), ("1.1", "2.2"), ("1.2", "2.2")}
    heads = {("1.1", "1.2"), ("2.1", "2.2"), ("2.2", "2.3")}
    assert touching(found) == beds | heads | {("1.2", "2.3")}
    joints = found.joints
    length = np.linalg.norm(joints.ends[:, 1] - joints.ends[:, 0], axis=1)
    upright = np.abs(joints.normal[:, 0]) > 0.5
    assert sorted(length[upright]) == pytest.approx([0.2] * 3)
    assert sorted(length[~upright]) == pytest.approx([0.2] * 4 + [0.4] * 2)
    assert set(joints.friction[upright]) == {0.3}
    assert set(joints.friction[~upright]) == {0.6}
    away = found.centre[joints.blocks[:, 0]] - found.centre[joints.blocks[:, 1]]
    assert ((away * joints.normal).sum(axis=1) > 0.0).all()


def test_an_opening_cuts_blocks():
    opening = patterns.Opening(0.3, 0.2, 0.4, 0.2)
    pieces = patterns.wall(0.4, 0.2, 3, 3, whole_first=True, openings=[opening])
    found = built(pieces)
    names = [name for name in found.names if name.startswith("2.")]
    assert names == ["2.1", "2.2", "2.3", "2.4"]
    widths = [np.ptp(found.corners[found.names.index(name)], axis=0)[0] for name in names]
    assert widths == pytest.approx([0.2, 0.1, 0.3, 0.2])
    whole = built(patterns.wall(0.4, 0.2, 3, 3, whole_first=True))
    assert whole.area.sum() - found.area.sum() == pytest.approx(0.4 * 0.2)


@pytest.mark.parametrize("voussoirs", [1, 8, 33])
def test_an_arch_has_radial_joints_as_long_as_it_is_thick(voussoirs: int):
    found = built(patterns.arch(5.0, 0.8, np.radians(140.0), voussoirs))
    joints = found.joints
    assert joints.count == voussoirs + 1
    middle = joints.ends.mean(axis=1)
    assert np.linalg.norm(joints.ends[:, 1] - joints.ends[:, 0], axis=1) == pytest.approx(0.8)
    assert np.linalg.norm(middle, axis=1) == pytest.approx(5.0)
    assert (joints.normal * middle).sum(axis=1) == pytest.approx(0.0, abs=1e-12)


def test_what_measures_rotations_is_that_of_a_column_as_a_whole_and_of_the_thickness_of_an_arch():
    for count in (1, 4):
        drums = built(patterns.column(0.5, 2.0, count))
        # To a corner of the top, not to its middle.
        high = np.hypot(2.0 * count, 0.25)
        assert drums.slenderness_angle == pytest.approx(np.arctan(0.5 / high))
    flat = built(patterns.arch(10.0, 1.5, np.pi, 40))
    crown = np.hypot(10.0, 10.75)
    assert flat.slenderness_angle == pytest.approx(np.arctan(1.5 / crown), rel=1e-2)
    low, high = (built(patterns.wall(0.4, 0.2, n, 4, whole_first=True)) for n in (5, 50))
    # A long wall is as slender as a short one.
    assert high.slenderness_angle == pytest.approx(low.slenderness_angle, rel=0.05)


def test_columns_and_frames_stand_on_the_ground():
    drums = built(patterns.column(1.0, 0.5, 3))
    assert touching(drums) == {("ground", "1"), ("1", "2"), ("2", "3")}
    portal = built(patterns.frame(1.0, 6.0, 2, 3.0, 0.5))
    feet, tops = {("ground", "column 1"), ("ground", "column 2")}, {("column 1", "beam")}
    assert touching(portal) == feet | tops | {("column 2", "beam")}
    assert portal.size == pytest.approx([5.0, 6.5])


def test_what_overlaps_floats_or_is_not_convex_is_refused():
    ground = Piece("ground", patterns.rectangle(0.0, -1.0, 3.0, 0.0), fixed=True)
    first = Piece("a", patterns.rectangle(0.0, 0.0, 1.0, 1.0))
    with pytest.raises(ValueError, match="blocks apart: a and b overlap by 10 mm"):
        built([ground, first, Piece("b", patterns.rectangle(0.99, 0.0, 2.0, 1.0))])
    with pytest.raises(ValueError, match="something fixed: block b touches nothing"):
        built([ground, first, Piece("b", patterns.rectangle(0.0, 1.01, 1.0, 2.0))])
    beside = [Piece("post", patterns.rectangle(-1.0, 0.0, 0.0, 3.0), fixed=True), ground]
    hung = Piece("c", patterns.rectangle(1.0, -2.0, 2.0, -1.0))
    with pytest.raises(ValueError, match="block c hangs below all that touches it"):
        built([*beside, first, hung])
    dart = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.9, 0.1]])
    with pytest.raises(ValueError, match="be convex: block b is not"):
        built([ground, first, Piece("b", dart + np.array([1.5, 0.0]))])
