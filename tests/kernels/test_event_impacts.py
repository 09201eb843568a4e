"""Impacts of one block on its base in `event`, in the plane: every one obeys the contact law."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
import warp as wp

from warprock.kernels.instance import kernel_module, module_options
from warprock.kernels.modes import FLAT

Array = npt.NDArray[np.float64]

real = wp.float64
boxes: Any = kernel_module("event/block_contact", precision="float64")
box_impact: Any = kernel_module("event/block_impact", precision="float64")
body_contact: Any = kernel_module("event/body_contact", precision="float64", vertical=True)
wp.set_module_options(module_options())
Block, Body, Lever, Velocity = boxes.Block, body_contact.Body, boxes.Lever, boxes.Velocity
strike_box, strike_body = box_impact.struck_velocity, body_contact.struck_velocity

COUNT = 20_000


@wp.kernel
def strike_boxes(
    blocks: wp.array(dtype=Block),
    before: wp.array(dtype=wp.vec3d),
    after: wp.array(dtype=wp.vec3d),
    modes: wp.array(dtype=int),
):
    """Level boxes whose corner at +x is struck first."""
    i = wp.tid()
    v = before[i]
    block = blocks[i]
    corner = Lever(block.half_width, -block.half_height)
    found, contact, _lost = strike_box(block, True, corner, Velocity(v[0], v[1], v[2]))
    after[i] = wp.vec3d(found.x, found.z, found.omega)
    modes[i] = contact.mode


@wp.kernel
def strike_bodies(
    bodies: wp.array(dtype=Body),
    place: wp.array(dtype=wp.vec3d),
    before: wp.array(dtype=wp.vec3d),
    after: wp.array(dtype=wp.vec3d),
    modes: wp.array(dtype=int),
):
    """Level bodies; of a place x of the corner struck first, its z, and x of the other one."""
    i = wp.tid()
    v = before[i]
    p = place[i]
    found, contact, _blow = strike_body(
        bodies[i], True, False, Lever(p[0], p[1]), p[2], Velocity(v[0], v[1], v[2])
    )
    after[i] = wp.vec3d(found.x, found.z, found.omega)
    modes[i] = contact.mode


def scenes(random: np.random.Generator) -> tuple[Array, Array, Array]:
    """Sizes, friction and velocities: a third lands level, a third turns about a sliding corner.

    Returns:
        Half height over half width, friction, velocities before, shape [lane, 3].
    """
    height = 10.0 ** random.uniform(-0.7, 1.0, COUNT)
    friction = 10.0 ** random.uniform(-1.3, 0.6, COUNT)
    before = random.normal(size=(COUNT, 3))
    before[:, 0] *= 10.0 ** random.uniform(-1.0, 1.0, COUNT)
    before[:, 1] = -np.abs(before[:, 1])
    kind = np.arange(COUNT) % 3
    before[kind == 0, 2] = 0.0
    before[kind == 1, 1] = -np.abs(before[kind == 1, 2])
    return height, friction, before


def check_law(
    friction: Array, inertia: Array, first: Array, z: Array, other: Array, before: Array,
    after: Array,
) -> None:  # fmt: skip
    """Signorini's conditions with no rebound, and Coulomb's, at both corners."""
    along, press, _turn = (after - before).T
    moment = along * z - inertia * (after[:, 2] - before[:, 2])
    share = (moment - press * other) / (first - other)
    shares = np.stack([share, press - share], axis=1)
    rise = after[:, 1:2] - after[:, 2:] * np.stack([first, other], axis=1)
    slide = after[:, 0] + after[:, 2] * z
    # Round-off of the solve, of which the jam of a corner takes some digits.
    dust = 1e-9 * np.abs(before).sum(axis=1) * (1.0 + np.abs(z))
    assert np.all(shares >= -dust[:, None])
    assert np.all(rise >= -dust[:, None])
    assert np.all(np.minimum(np.abs(rise), np.abs(shares)) <= dust[:, None])
    assert np.all(np.abs(along) <= friction * press + dust)
    drags = np.abs(slide) > dust
    assert drags.sum() > COUNT // 10
    np.testing.assert_allclose(
        along[drags], (-friction * press * np.sign(slide))[drags], atol=dust.max()
    )


def test_boxes_obey_it() -> None:
    height, friction, before = scenes(np.random.default_rng(1))
    # The corner that closes faster is the first, of a level landing the one ahead.
    before[:, 2] = np.abs(before[:, 2])
    level = before[:, 2] == 0.0
    before[level, 0] = np.abs(before[level, 0])
    inertia = (1.0 + height**2) / 3.0
    rows = np.zeros(COUNT, dtype=Block.numpy_dtype())
    rows["half_width"], rows["half_height"], rows["friction"] = 1.0, height, friction
    rows["inertia"], rows["inverse_inertia"] = inertia, 1.0 / inertia
    after, modes = wp.zeros(COUNT, dtype=wp.vec3d), wp.zeros(COUNT, dtype=int)
    inputs = [wp.array(rows, dtype=Block), wp.array(before, dtype=wp.vec3d), after, modes]
    wp.launch(strike_boxes, dim=COUNT, inputs=inputs, device="cpu")
    one = np.ones(COUNT)
    check_law(friction, inertia, one, -height, -one, before, after.numpy())
    assert (modes.numpy() == FLAT).sum() > COUNT // 10


@pytest.mark.parametrize("beside", [False, True])
def test_bodies_obey_it(beside: bool) -> None:
    random = np.random.default_rng(2)
    height, friction, before = scenes(random)
    # Edges below the centre of mass and beside it, from either end.
    other = random.uniform(0.05, 0.9, COUNT) if beside else random.uniform(-1.0, -0.1, COUNT)
    first, other = np.where(random.random(COUNT) < 0.5, 1.0, -1.0) * np.stack(
        [np.ones(COUNT), other]
    )
    closes = np.where(before[:, 2] == 0.0, before[:, 0], before[:, 2]) * (first - other) >= 0.0
    first, other = np.where(closes, first, other), np.where(closes, other, first)
    # A corner beside the centre of mass rises where the body turns about the other one.
    before[:, 1] = np.minimum(before[:, 1], -np.abs(before[:, 2]) * np.abs(other))
    inertia = (1.0 + height**2) / 3.0 * random.uniform(0.5, 2.0, COUNT)
    rows = np.zeros(COUNT, dtype=Body.numpy_dtype())
    rows["friction"], rows["restitution"] = friction, -1.0
    rows["inertia"], rows["inverse_inertia"] = inertia, 1.0 / inertia
    after, modes = wp.zeros(COUNT, dtype=wp.vec3d), wp.zeros(COUNT, dtype=int)
    place = np.stack([first, -height, other], axis=1)
    arrays = [wp.array(each, dtype=wp.vec3d) for each in (place, before)]
    inputs = [wp.array(rows, dtype=Body), *arrays, after, modes]
    wp.launch(strike_bodies, dim=COUNT, inputs=inputs, device="cpu")
    check_law(friction, inertia, first, -height, other, before, after.numpy())
    assert (modes.numpy() == FLAT).sum() > COUNT // 100
