"""Faces of a stack in space that moves as one: which loads `carries` lets them take."""

from __future__ import annotations

import numpy as np
import pytest
import warp as wp
from scipy.optimize import linprog

from warprock.kernels.launch.instance import kernel_module, module_options

wp.set_module_options(module_options())
real = wp.float64
whole = kernel_module("event_space/stack/whole", precision="float64", blocks=2)
Whole, carries, spread_of = whole.Whole, whole.carries, whole.spread_of
UPPER_FACE = 2
FRICTION, MOST = 0.6, 8
SIDES = 64
"""Sides of the polygon around the cone of friction."""


@wp.kernel
def load_faces(
    corners: wp.array3d(dtype=real), count: wp.array(dtype=int), load: wp.array2d(dtype=real),
    found: wp.array(dtype=int),
):  # fmt: skip
    """Whether each face takes its load: three parts of the impulse, three of its moment."""
    lane = wp.tid()
    on = Whole()
    number = count[lane]
    on.count[UPPER_FACE] = number
    for i in range(3):
        on.axes[3 * UPPER_FACE + i, i] = real(1.0)
    for i in range(number):
        for part in range(3):
            on.corners[MOST * (UPPER_FACE - 1) + i, part] = corners[lane, i, part]
    middle, spread, _number = spread_of(on, UPPER_FACE, (1 << number) - 1)
    on.middle[UPPER_FACE] = middle
    on.spread[UPPER_FACE] = spread
    push = whole.Vector(load[lane, 0], load[lane, 1], load[lane, 2])
    twist = whole.Vector(load[lane, 3], load[lane, 4], load[lane, 5])
    found[lane] = wp.where(carries(on, UPPER_FACE, real(FRICTION), push, twist), 1, 0)


def faces(lanes: int, draw: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Corners of convex faces in one plane [m], some next to one another, and their numbers."""
    count = draw.integers(3, MOST + 1, lanes)
    angle = 2.0 * np.pi * (np.arange(MOST) + draw.uniform(0.0, 0.9, (lanes, MOST)))
    angle /= count[:, None]
    flat = np.stack([0.2 * np.cos(angle), 0.1 * np.sin(angle)], axis=-1)
    shift = draw.uniform(-0.1, 0.1, (lanes, 1, 2))
    low = np.broadcast_to(draw.uniform(-0.5, -0.1, (lanes, 1, 1)), (lanes, MOST, 1))
    return np.concatenate([flat + shift, low], axis=-1), count


def taken(corners: np.ndarray, count: np.ndarray, load: np.ndarray) -> np.ndarray:
    found = wp.zeros(len(count), dtype=int)
    inputs = [wp.array(corners, dtype=real), wp.array(count.astype(np.int32), dtype=int)]
    inputs.append(wp.array(load, dtype=real))
    wp.launch(load_faces, dim=len(count), inputs=[*inputs, found], device="cpu")
    return found.numpy() == 1


def load_of(corners: np.ndarray, impulses: np.ndarray) -> np.ndarray:
    """Sum and moment of the impulses of corners."""
    return np.concatenate([impulses.sum(axis=1), np.cross(corners, impulses).sum(axis=1)], axis=-1)


def can_carry(corners: np.ndarray, load: np.ndarray) -> bool:
    """Whether impulses within a polygon around the cone of friction have a sum and a moment."""
    number = len(corners)
    sums = np.concatenate([np.tile(np.eye(3), number), _moments(corners)])
    angle = 2.0 * np.pi * np.arange(SIDES) / SIDES
    ways = np.stack([np.cos(angle), np.sin(angle), np.full(SIDES, -FRICTION)], axis=-1)
    bounds = [(None, None), (None, None), (0.0, None)] * number
    found = linprog(
        np.zeros(3 * number), A_ub=np.kron(np.eye(number), ways),
        b_ub=np.full(SIDES * number, 1e-9), A_eq=sums, b_eq=load, bounds=bounds,
    )  # fmt: skip
    return bool(found.status == 0)


def _moments(corners: np.ndarray) -> np.ndarray:
    """The matrix that makes the moment of impulses at corners."""
    return np.concatenate([np.cross(each, np.eye(3)).T for each in corners], axis=1)


def test_a_load_is_taken_only_if_corners_can_carry_it() -> None:
    """Of loads that are made of impulses within the cone, and of loads with another moment."""
    draw, lanes = np.random.default_rng(5), 400
    corners, count = faces(lanes, draw)
    there = np.arange(MOST) < count[:, None]
    pushes = draw.uniform(0.0, 1.0, (lanes, MOST)) ** 3 * there
    pull = draw.uniform(0.0, 1.2 * FRICTION, (lanes, MOST)) * pushes
    angle = draw.normal(0.0, 1.0, (lanes, 1)) + draw.normal(0.0, 0.5, (lanes, MOST))
    impulses = np.stack([pull * np.cos(angle), pull * np.sin(angle), pushes], axis=-1)
    load = load_of(corners, impulses)
    load[:, 3:] += draw.normal(0.0, 0.05, (lanes, 3))
    found = taken(corners, count, load)
    can = np.array([can_carry(c[:n], f) for c, n, f in zip(corners, count, load, strict=True)])
    assert not np.any(found & ~can)
    # One way to share a load takes most of what all of them can: 150 of 204.
    assert can.sum() >= 100
    assert found.sum() >= 0.7 * can.sum()


@pytest.mark.parametrize(("inside", "takes"), [(0.98, True), (1.02, False)])
def test_without_friction_the_centre_of_pressure_decides(inside: float, takes: bool) -> None:
    """It lies on a side of the face, moved towards the middle or away from it."""
    draw, lanes = np.random.default_rng(6), 4000
    corners, count = faces(lanes, draw)
    side = draw.integers(0, count)
    each = np.arange(lanes)
    first, last = corners[each, side], corners[each, (side + 1) % count]
    middle = np.stack([c[:n].mean(axis=0) for c, n in zip(corners, count, strict=True)])
    at = first + draw.uniform(0.0, 1.0, (lanes, 1)) * (last - first)
    centre = middle + inside * (at - middle)
    load = load_of(centre[:, None], np.tile([0.0, 0.0, 1.0], (lanes, 1, 1)))
    found = taken(corners, count, load)
    assert np.all(found == takes)
