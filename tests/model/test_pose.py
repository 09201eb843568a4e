"""Attitudes and starts of blocks in space, and the free rotation that the engines share."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest
import warp as wp

from tests.shared.blocks import make_stacks
from tests.shared.spatial_blocks import in_space, spatial_lanes, spatial_stack
from warprock.engines.blocks import start_on_corners
from warprock.kernels.launch.instance import kernel_module, module_options
from warprock.model.pose import Array, bottom_corners, product, quaternion, rotations, start_poses
from warprock.model.turning import rotate

real = wp.float64
turn_freely = kernel_module("shape_space/block", precision="float64").turn_freely
lanes = kernel_module("shape_space/lanes", precision="float64")
Triple = lanes.Triple
wp.set_module_options(module_options())

EPS = 1e-14
"""Round-off of a few operations on numbers of the order of one."""


@wp.kernel
def fly(
    attitude: wp.array2d(dtype=real),
    momentum: wp.array2d(dtype=real),
    inverse: wp.array2d(dtype=real),
    step: wp.array(dtype=real),
    steps: wp.array(dtype=int),
) -> None:
    """Free rotation, one body a thread."""
    i = wp.tid()
    a = attitude[i, 0]
    b = attitude[i, 1]
    c = attitude[i, 2]
    d = attitude[i, 3]
    spin = Triple(momentum[i, 0], momentum[i, 1], momentum[i, 2])
    ease = Triple(inverse[i, 0], inverse[i, 1], inverse[i, 2])
    for _ in range(steps[i]):
        a, b, c, d = turn_freely(a, b, c, d, spin, ease, step[i])
    attitude[i, 0] = a
    attitude[i, 1] = b
    attitude[i, 2] = c
    attitude[i, 3] = d


def flown(start: Array, momentum: Array, inverse: Array, step: Array, steps: Any) -> Array:
    """Attitudes after `steps` steps of free rotation, shape [body, 4]."""
    attitude = wp.array(start, dtype=real, device="cpu")
    inputs = [
        attitude,
        *(wp.array(each, dtype=real, device="cpu") for each in (momentum, inverse, step)),
        wp.array(np.asarray(steps, dtype=np.int32), dtype=int, device="cpu"),
    ]
    wp.launch(fly, dim=len(start), inputs=inputs, device="cpu")
    return np.asarray(attitude.numpy())


def energy(attitude: Array, momentum: Array, inverse: Array) -> Array:
    """Kinetic energy of a rotation, for unit mass."""
    body = rotate(attitude * np.array([-1.0, -1.0, -1.0, 1.0]), momentum)
    return np.asarray(0.5 * np.sum(body * body * inverse, axis=-1))


def some_bodies(count: int) -> tuple[Array, Array, Array]:
    """Attitudes, angular momenta and inverse moments of inertia of boxes."""
    random = np.random.default_rng(7)
    attitude = random.normal(size=(count, 4))
    attitude /= np.linalg.norm(attitude, axis=1, keepdims=True)
    sides = random.uniform(0.3, 1.2, size=(count, 3))
    inverse = 12.0 / (np.sum(sides**2, axis=1, keepdims=True) - sides**2)
    return attitude, random.normal(size=(count, 3)) * 0.3, inverse


def test_quaternions_turn_as_rotation_matrices_do() -> None:
    yaw, pitch = 0.7, -0.4
    c, s, k, t = np.cos(yaw), np.sin(yaw), np.cos(pitch), np.sin(pitch)
    matrix = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) @ [[k, 0, t], [0, 1, 0], [-t, 0, k]]
    both = product(quaternion(np.array([0.0, 0.0, yaw])), quaternion(np.array([0.0, pitch, 0.0])))
    np.testing.assert_allclose(rotate(both, np.eye(3)), matrix.T, atol=EPS)


def test_rotations_of_a_lean_and_a_yaw() -> None:
    lean = np.array([0.3, -0.2, 0.0])
    across, along = -quaternion(np.array([0.2, 0.0, 0.0])), quaternion(np.array([0.0, 0.3, 0.0]))
    np.testing.assert_allclose(rotations(along), (0.3, 0.0, 0.0), atol=EPS)
    np.testing.assert_allclose(rotations(across), (0.0, -0.2, 0.0), atol=EPS)
    yaw = quaternion(np.array([0.0, 0.0, 3.0]))
    np.testing.assert_allclose(rotations(yaw), (0.0, 0.0, 3.0), atol=EPS)
    turn = product(yaw, quaternion(lean))
    # The lean's axis lies in the block's own bottom face: it leaves the yaw as it is.
    assert rotations(turn)[2] == pytest.approx(3.0, abs=EPS)


def test_a_block_starts_with_its_lowest_corner_where_it_stands_flat() -> None:
    lanes = spatial_lanes(
        [0.5, 0.4, 0.3],
        1.0,
        depth=0.6,
        rotation_start=np.array([0.2, -0.1, 0.0]),
        rotation_across_start=np.array([0.1, 0.15, 0.0]),
        yaw_start=np.array([0.4, -2.0, 1.0]),
        gap_start=np.array([0.0, 0.02, 0.0]),
        centre_offset_x=np.array([0.02, -0.03, 0.05]),
        centre_offset_y=np.array([0.0, 0.05, -0.04]),
    )
    position, attitude = start_poses(lanes)
    corners = position[:, None] + rotate(attitude[:, None], bottom_corners(lanes))
    np.testing.assert_allclose(corners[..., 2].min(axis=1), lanes.gap_start, atol=EPS)
    flat = 0.5 * np.stack([lanes.face_width, lanes.face_depth], axis=-1)[:, None] * [
        (-1, -1), (1, -1), (1, 1), (-1, 1),
    ]  # fmt: skip
    c, s = np.cos(lanes.yaw_start)[:, None], np.sin(lanes.yaw_start)[:, None]
    stood = np.stack([c * flat[..., 0] - s * flat[..., 1], s * flat[..., 0] + c * flat[..., 1]], -1)
    low = corners[..., 2].argmin(axis=1)
    rows = np.arange(3)
    np.testing.assert_allclose(corners[rows, low, :2], stood[rows, low], atol=EPS)
    np.testing.assert_allclose(rotations(attitude)[2], lanes.yaw_start, atol=EPS)


def test_a_planar_lean_is_the_rotation_in_the_plane() -> None:
    lanes = spatial_lanes(0.5, 1.0, rotation_start=np.array([0.3]))
    along, across, yaw = rotations(start_poses(lanes)[1])
    np.testing.assert_allclose([along, across, yaw], [[0.3], [0.0], [0.0]], atol=EPS)


def test_blocks_of_a_stack_stand_on_one_another() -> None:
    lanes = spatial_stack(
        [0.5, 0.4],
        [1.0, 0.6],
        offset=np.array([[0.0, 0.03]]),
        offset_across=np.array([[0.0, -0.02]]),
    )
    position, _attitude = start_poses(lanes)
    np.testing.assert_allclose(position[0], [(0, 0, 0.5), (0.03, -0.02, 1.3)], atol=EPS)


def test_free_rotation_about_one_axis_is_exact() -> None:
    # Half a turn in one step about each of the body's axes: angle = l / I x dt.
    inverse = np.array([[3.0, 5.0, 7.0]] * 3)
    rate = 2.0
    start = np.tile([0.0, 0.0, 0.0, 1.0], (3, 1))
    momentum = rate * np.eye(3) / inverse
    found = flown(start, momentum, inverse, np.full(3, 0.5 * np.pi / rate), np.full(3, 1))
    expected = quaternion(0.5 * np.pi * np.eye(3))
    np.testing.assert_allclose(found, expected, atol=EPS)


def test_free_rotation_is_second_order_and_reversible() -> None:
    attitude, momentum, inverse = some_bodies(8)
    steps = np.array([100, 200, 400, 3200])
    ends = [flown(attitude, momentum, inverse, np.full(8, 1.0 / n), np.full(8, n)) for n in steps]
    gaps = [np.abs(end - ends[-1]).max(axis=1) for end in ends[:-1]]
    # A quarter of the error for half of the step; the finest run has 1/64 of the last one's.
    for coarse, fine in itertools.pairwise(gaps):
        np.testing.assert_allclose(coarse / fine, 4.0, rtol=0.15)
    there = ends[0]
    again = flown(there, momentum, inverse, np.full(8, -0.01), np.full(8, 100))
    np.testing.assert_allclose(again, attitude, atol=100 * EPS)


def test_free_rotation_keeps_its_energy_for_ever() -> None:
    # The angular momentum is the state: nothing changes it. The energy of a symplectic step errs
    # by a bounded amount of second order: over ten tumbles as over those after a thousand seconds.
    attitude, momentum, inverse = some_bodies(8)
    start = energy(attitude, momentum, inverse)
    worst = {}
    for step in (0.02, 0.01):
        found = []
        for first in (0.0, 1000.0):
            end = flown(attitude, momentum, inverse, np.full(8, step), np.full(8, first / step))
            errors = []
            for _ in range(100):
                end = flown(end, momentum, inverse, np.full(8, step), np.full(8, 0.2 / step))
                errors.append(np.abs(energy(end, momentum, inverse) / start - 1.0))
            np.testing.assert_allclose(np.linalg.norm(end, axis=1), 1.0, atol=EPS)
            found.append(np.max(errors, axis=0))
        # An error that grew with time would be fifty times as large.
        assert np.all(found[1] <= 3.0 * found[0])
        worst[step] = np.max(found)
    assert worst[0.01] <= 0.3 * worst[0.02]
    rate = np.max(np.abs(momentum * inverse))
    assert worst[0.01] <= (rate * 0.01) ** 2


@pytest.mark.parametrize("blocks", [2, 4])
def test_stacks_that_lean_start_in_space_where_they_start_in_the_plane(blocks: int) -> None:
    """Some lean as one, some on a flat block; upper blocks jut out, and are deeper or less deep."""
    rng = np.random.default_rng(1)
    shape, aside = (200, blocks), np.arange(blocks) > 0
    rotation = rng.uniform(-0.3, 0.3, shape)
    rotation[:50], rotation[50:100, 0] = rotation[:50, :1], 0.0
    flat = make_stacks(
        rng.uniform(0.3, 0.6, shape), rng.uniform(0.2, 0.6, shape), rotation=rotation,
        offset=aside * rng.uniform(-0.1, 0.1, shape),
    )  # fmt: skip
    place, _attitude = start_poses(in_space(flat, depth=rng.uniform(0.3, 0.6, shape)))
    x, z, _left, _right = start_on_corners(flat)
    np.testing.assert_allclose(place[..., 0], x, rtol=0.0, atol=EPS)
    np.testing.assert_allclose(place[..., 1], 0.0, rtol=0.0, atol=EPS)
    np.testing.assert_allclose(place[..., 2], z, rtol=0.0, atol=EPS)


def test_a_stack_whose_blocks_lean_alike_is_one_that_was_turned() -> None:
    rng = np.random.default_rng(2)
    one, each, above = np.ones(3), (100, 3), np.array([0.0, 1.0, 1.0])
    whole = {
        "depth": rng.uniform(0.3, 0.6, each),
        "yaw_start": rng.uniform(-3.0, 3.0, (100, 1)) * one,
        "offset_across": above * rng.uniform(-0.05, 0.05, each),
        "centre_offset_x": rng.uniform(-0.05, 0.05, each),
        "centre_offset_y": rng.uniform(-0.05, 0.05, each),
    }
    leans = {
        name: rng.uniform(-0.2, 0.2, (100, 1)) * one
        for name in ("rotation_start", "rotation_across_start")
    }
    blocks = make_stacks(
        rng.uniform(0.3, 0.6, each), rng.uniform(0.2, 0.6, each),
        offset=above * rng.uniform(-0.05, 0.05, each),
    )  # fmt: skip
    turned, upright = in_space(blocks, **whole, **leans), in_space(blocks, **whole)
    (place, attitude), (flat, level) = start_poses(turned), start_poses(upright)
    back = product(attitude[:, :1], level[:, :1] * (-1.0, -1.0, -1.0, 1.0))
    expected = place[:, :1] + rotate(back, flat - flat[:, :1])
    np.testing.assert_allclose(place, expected, rtol=0.0, atol=EPS)
    low = rotate(attitude[..., None, :], bottom_corners(turned)) + place[..., None, :]
    np.testing.assert_allclose(low[:, 0, :, 2].min(axis=1), 0.0, rtol=0.0, atol=EPS)


def test_a_turned_block_leans_on_the_lowest_corner_of_what_two_faces_share() -> None:
    """Against points of the upper face: none that lies over the lower one is below it."""
    rng = np.random.default_rng(3)
    shape, upper = (200, 2), np.array([0.0, 1.0])
    stacks = in_space(
        make_stacks(
            rng.uniform(0.3, 0.6, shape), 0.3, offset=upper * rng.uniform(-0.2, 0.2, shape)
        ),
        depth=rng.uniform(0.3, 0.6, shape),
        offset_across=upper * rng.uniform(-0.2, 0.2, shape),
        yaw_start=rng.uniform(-3.0, 3.0, shape),
        rotation_start=upper * rng.uniform(-1e-3, 1e-3, shape),
        rotation_across_start=upper * rng.uniform(-1e-3, 1e-3, shape),
    )
    place, attitude = start_poses(stacks)
    a, b = np.meshgrid(np.linspace(-0.5, 0.5, 201), np.linspace(-0.5, 0.5, 201))
    for lane in range(200):
        face = np.stack([a * stacks.width[lane, 1], b * stacks.depth[lane, 1], 0.0 * a - 0.15], -1)
        seen = place[lane, 1] + rotate(attitude[lane, 1], face) - (0.0, 0.0, 0.3)
        own = rotate(attitude[lane, 0] * (-1.0, -1.0, -1.0, 1.0), seen)
        over = 2.0 * np.abs(own[..., 0]) <= stacks.width[lane, 0]
        over &= 2.0 * np.abs(own[..., 1]) <= stacks.depth[lane, 0]
        lowest = seen[over, 2].min()
        # Where the points lie, and how far a turn of 1e-3 rad moves the face sideways.
        assert -2e-6 <= lowest <= 1e-3 * 0.01
