"""Corners of what two faces share: against clipping one polygon by another in NumPy."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest
import warp as wp

from warprock.kernels.launch.instance import BRANCHES, kernel_module, module_options
from warprock.model.pose import quaternion
from warprock.model.turning import rotate

Array = npt.NDArray[np.float64]

real = wp.float64
faces = kernel_module("shape/faces", precision="float64")
corner, mirror_slot, Faces, SLOTS = faces.corner, faces.mirror_slot, faces.Faces, faces.SLOTS
lowest_slopes = faces.lowest_slopes
wp.set_module_options(module_options() | BRANCHES)

SIGNS = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])


@wp.kernel
def find(
    pairs: wp.array2d(dtype=real), points: wp.array3d(dtype=real), there: wp.array2d(dtype=int)
) -> None:
    """All sixteen slots of a pair of faces, one pair a thread."""
    i = wp.tid()
    both = Faces(
        pairs[i, 0], pairs[i, 1], pairs[i, 2], pairs[i, 3], pairs[i, 4], pairs[i, 5], pairs[i, 6],
        pairs[i, 7], pairs[i, 8], pairs[i, 9], pairs[i, 10], pairs[i, 11], pairs[i, 12],
    )  # fmt: skip
    slots = int(SLOTS)
    for s in range(slots):
        x, y, gap, exists = corner(s, both)
        points[i, s, 0] = x
        points[i, s, 1] = y
        points[i, s, 2] = gap
        there[i, s] = wp.where(exists, 1, 0)


@wp.kernel
def press(pairs: wp.array2d(dtype=real), normals: wp.array2d(dtype=real)) -> None:
    """The normal (x, y, 1) where the upper face is lowest, one pair a thread."""
    i = wp.tid()
    both = Faces(
        pairs[i, 0], pairs[i, 1], pairs[i, 2], pairs[i, 3], pairs[i, 4], pairs[i, 5], pairs[i, 6],
        pairs[i, 7], pairs[i, 8], pairs[i, 9], pairs[i, 10], pairs[i, 11], pairs[i, 12],
    )  # fmt: skip
    found = lowest_slopes(both)
    normals[i, 0] = found.x
    normals[i, 1] = found.y
    normals[i, 2] = real(1.0)


@wp.kernel
def image(x: int, y: int, found: wp.array(dtype=int)) -> None:
    """Slots in a mirror image."""
    found[wp.tid()] = mirror_slot(wp.tid(), x, y)


def shared(pairs: Array) -> tuple[Array, npt.NDArray[np.bool_]]:
    """Points, shape [pair, slot, 3], and which of them there are, shape [pair, slot]."""
    points = wp.zeros((len(pairs), SLOTS, 3), dtype=real, device="cpu")
    there = wp.zeros((len(pairs), SLOTS), dtype=int, device="cpu")
    inputs = [wp.array(pairs, dtype=real, device="cpu"), points, there]
    wp.launch(find, dim=len(pairs), inputs=inputs, device="cpu")
    return points.numpy(), there.numpy() == 1


def pair(middle: Array, turn: Array, upper: Array, lower: Array) -> Array:
    """One row of `find`: the middle and the turn of the upper face, full sizes of both."""
    axes = rotate(quaternion(np.asarray(turn)), np.eye(3))
    return np.concatenate(
        [middle, axes[0], axes[1], 0.5 * np.asarray(upper), 0.5 * np.asarray(lower)]
    )


def clipped(row: Array) -> Array:
    """The polygon that two faces share in the plan of the lower one, shape [corner, 2]."""
    o, d, e = row[:2], row[3:5], row[6:8]
    polygon = [o + s[0] * row[9] * d + s[1] * row[10] * e for s in SIGNS]
    bounds = row[11:13]
    for axis in (0, 1):
        for sign in (-1.0, 1.0):
            kept: list[Array] = []
            for a, b in zip(polygon, polygon[1:] + polygon[:1], strict=True):
                over_a, over_b = sign * a[axis] - bounds[axis], sign * b[axis] - bounds[axis]
                if over_a <= 0.0:
                    kept.append(a)
                if over_a * over_b < 0.0:
                    kept.append(a + over_a / (over_a - over_b) * (b - a))
            polygon = kept
            if not polygon:
                return np.zeros((0, 2))
    return np.array(polygon)


def random_pairs(count: int) -> Array:
    random = np.random.default_rng(3)
    return np.array(
        [
            pair(
                np.append(random.uniform(-0.6, 0.6, 2), random.uniform(0.0, 0.01)),
                np.append(random.uniform(-0.3, 0.3, 2), random.uniform(-np.pi, np.pi)),
                random.uniform(0.2, 1.0, 2),
                random.uniform(0.2, 1.0, 2),
            )
            for _ in range(count)
        ]
    )


@pytest.mark.thorough
def test_the_corners_are_those_of_the_clipped_polygon() -> None:
    pairs = random_pairs(300)
    points, there = shared(pairs)
    counts = set()
    for row, found, exists in zip(pairs, points, there, strict=True):
        expected = clipped(row)
        counts.add(len(expected))
        assert exists.sum() == len(expected)
        if len(expected) == 0:
            continue
        gaps = np.linalg.norm(found[exists, None, :2] - expected[None], axis=-1)
        # A lower face that counts as larger by a part of 1e-6 moves a corner by that much, more
        # where edges cross at a sharp angle.
        assert np.max(gaps.min(axis=0)) <= 1e-4
        assert np.max(gaps.min(axis=1)) <= 1e-4
    assert {0, 3, 4, 5, 6} <= counts


@pytest.mark.thorough
def test_the_gap_is_that_of_the_upper_face() -> None:
    pairs = random_pairs(50)
    points, there = shared(pairs)
    for row, found, exists in zip(pairs, points, there, strict=True):
        normal = np.cross(row[3:6], row[6:9])
        away = (found[exists] - row[:3]) @ normal
        np.testing.assert_allclose(away, 0.0, atol=1e-13)


@pytest.mark.thorough
@pytest.mark.parametrize("turn", [0.0, 1e-8, 0.3, 0.25 * np.pi])
def test_equal_faces_share_four_corners_or_eight(turn: float) -> None:
    row = pair(np.zeros(3), np.array([0.0, 0.0, turn]), np.ones(2), np.ones(2))
    points, there = shared(row[None])
    # Edges over one another share the upper face's corners; a real turn cuts all of them.
    assert there.sum() == (4 if turn < 1e-6 else 8)
    reach = np.linalg.norm(points[there][:, :2], axis=1)
    # A regular octagon at 45 degrees: all corners at 0.5 / cos(22.5 deg).
    if turn > 0.7:
        np.testing.assert_allclose(reach, 0.5 / np.cos(0.125 * np.pi), rtol=1e-5)


@pytest.mark.thorough
def test_faces_that_share_an_edge_line_keep_to_few_corners() -> None:
    # As deep as one another, moved along the width: two corners of each face, none twice.
    row = pair(np.array([0.1, 0.0, 0.0]), np.zeros(3), np.ones(2), np.ones(2))
    points, there = shared(row[None])
    assert there.sum() == 4
    np.testing.assert_allclose(np.sort(points[there][:, 0]), [-0.4, -0.4, 0.5, 0.5], atol=1e-6)


@pytest.mark.thorough
@pytest.mark.parametrize("sides", [(1, 0), (0, 1), (1, 1)])
def test_a_mirrored_pair_has_mirrored_slots(sides: tuple[int, int]) -> None:
    pairs = random_pairs(100)
    sx, sy = (1.0 - 2.0 * side for side in sides)
    flip = np.array([sx, sy, 1.0, 1.0, sx * sy, sx, sx * sy, 1.0, sy, 1.0, 1.0, 1.0, 1.0])
    points, there = shared(pairs)
    images, exist = shared(pairs * flip)
    slots = wp.zeros(SLOTS, dtype=int, device="cpu")
    wp.launch(image, dim=SLOTS, inputs=[*sides, slots], device="cpu")
    order = slots.numpy()
    assert sorted(order) == list(range(SLOTS))
    np.testing.assert_array_equal(exist[:, order], there)
    gaps = np.abs(images[:, order] * [sx, sy, 1.0] - points)[there]
    # The two ways to the same crossing differ by round-off, over the angle at which edges cross.
    assert np.max(gaps) <= 1e-9


def touched(row: Array, slot: int, point: Array) -> Array | None:
    """The normal (x, y, 1) of a contact at a slot; None where edges cross at less than 45 degrees.

    Args:
        row: A pair of faces.
        slot: The slot.
        point: Where it is.
    """
    d, e = row[3:6], row[6:9]
    normal = np.array([0.0, 0.0, 1.0])
    if slot >= 12:
        normal = np.cross(d, e)
    elif slot >= 4:
        # The end of the lower face's width or of its depth, whose edge runs along the other one.
        width = abs(abs(point[0]) - row[11]) < abs(abs(point[1]) - row[12])
        edge, below = (d if slot < 8 else e), np.array([0.0, 1.0, 0.0] if width else [1.0, 0, 0])
        normal = np.cross(edge, below)
        across, far = (0, 1) if width else (1, 0)
        if abs(edge[across]) < abs(edge[far]):
            return None
    return np.asarray(normal / normal[2])


@pytest.mark.thorough
def test_the_lowest_corner_has_the_normal_of_what_touches_there() -> None:
    pairs = random_pairs(1000)
    points, there = shared(pairs)
    normals = wp.zeros((len(pairs), 3), dtype=real, device="cpu")
    wp.launch(press, len(pairs), [wp.array(pairs, dtype=real, device="cpu"), normals], device="cpu")
    kinds = []
    for row, found, exists, normal in zip(pairs, points, there, normals.numpy(), strict=True):
        if not exists.any():
            continue
        slot = int(np.argmin(np.where(exists, found[:, 2], np.inf)))
        expected = touched(row, slot, found[slot])
        kinds.append((slot >= 4) + (slot >= 12) if expected is not None else 3)
        if expected is not None:
            np.testing.assert_allclose(normal, expected, rtol=0.0, atol=1e-12)
        else:
            # That of another one: across edges 45 degrees apart it leans by sqrt(2) of the upper
            # face at most, more as edges of tilted faces do.
            upper = np.cross(row[3:6], row[6:9])
            assert np.linalg.norm(normal[:2]) <= 1.5 * np.linalg.norm(upper[:2] / upper[2])
    assert np.bincount(kinds, minlength=4).min() >= 50
