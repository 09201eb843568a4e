"""Impacts of one block on its base in `event`, in the plane: every one obeys the contact law."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
import warp as wp

from warprock.kernels.lane.modes import FLAT, FLYING, PIVOTING
from warprock.kernels.launch.instance import kernel_module, module_options

Array = npt.NDArray[np.float64]

real = wp.float64
boxes: Any = kernel_module("event/block/contact", precision="float64")
box_impact: Any = kernel_module("event/block/impact", precision="float64")
body_contact: Any = kernel_module("event/body/contact", precision="float64", vertical=True)
body_bounce: Any = kernel_module("event/body/bounce", precision="float64", vertical=True)
wp.set_module_options(module_options())
Block, Body, Lever, Velocity = boxes.Block, body_contact.Body, boxes.Lever, boxes.Velocity
strike_box, strike_body = box_impact.struck_velocity, body_contact.struck_velocity

bounce_body = body_bounce.bounce_velocity

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


@wp.kernel
def bounce_bodies(
    bodies: wp.array(dtype=Body),
    place: wp.array(dtype=wp.vec3d),
    beside: wp.array(dtype=bool),
    before: wp.array(dtype=wp.vec3d),
    after: wp.array(dtype=wp.vec3d),
    lost: wp.array(dtype=real),
    modes: wp.array(dtype=int),
):
    """As `strike_bodies`, where corners bounce; `beside` says which bodies are level."""
    i = wp.tid()
    v = before[i]
    p = place[i]
    found, contact, blow = bounce_body(
        bodies[i], beside[i], Lever(p[0], p[1]), p[2], Velocity(v[0], v[1], v[2])
    )
    after[i] = wp.vec3d(found.x, found.z, found.omega)
    lost[i] = blow.lost
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


def bounced(
    rows: npt.NDArray[Any], first: Array, z: Array, other: Array, beside: Any, before: Array
) -> tuple[Array, Array, npt.NDArray[np.int32]]:
    """Velocities after impacts that bounce, the energy they lose, and the contacts that stay."""
    place = np.stack([first, z, other], axis=1)
    out = [wp.zeros(len(z), dtype=kind) for kind in (wp.vec3d, real, int)]
    level = np.broadcast_to(np.asarray(beside), len(z))
    inputs = [wp.array(rows, dtype=Body), wp.array(place, dtype=wp.vec3d), wp.array(level),
              wp.array(before, dtype=wp.vec3d), *out]  # fmt: skip
    wp.launch(bounce_bodies, dim=len(z), inputs=inputs, device="cpu")
    after, lost, modes = (each.numpy() for each in out)
    return after, lost, modes


def bouncing(
    count: int, friction: Any, inertia: Any, restitution: Any, law: str = "rebound"
) -> npt.NDArray[Any]:
    """Bodies of Newton's law, whose restitution is `rebound`, or of Poisson's, `expansion`."""
    rows = np.zeros(count, dtype=Body.numpy_dtype())
    rows["friction"], rows[law], rows["slow"] = friction, restitution, 1e-9
    rows["inertia"], rows["inverse_inertia"] = inertia, 1.0 / np.asarray(inertia)
    return rows


def test_corners_that_bounce_obey_newtons_law_and_make_no_energy() -> None:
    """Of one corner and of both ends of an edge; one in seventy would make energy (Kane)."""
    random = np.random.default_rng(3)
    height, friction, before = scenes(random)
    beside, rebound = random.random(COUNT) < 0.7, random.uniform(0.0, 1.0, COUNT)
    before[:, 2] = np.abs(before[:, 2])
    level = before[:, 2] == 0.0
    before[level, 0] = np.abs(before[level, 0])
    inertia, one = (1.0 + height**2) / 3.0, np.ones(COUNT)
    rows = bouncing(COUNT, friction, inertia, rebound)
    after, lost, modes = bounced(rows, one, -height, -one, beside, before)
    ends = np.stack([one, -one], axis=1)
    came = np.maximum(-(before[:, 1:2] - before[:, 2:] * ends), 0.0)
    leaves = after[:, 1:2] - after[:, 2:] * ends
    along, press, _turn = (after - before).T
    moment = along * -height - inertia * (after[:, 2] - before[:, 2])
    share = np.where(beside, 0.5 * (moment + press), press)
    shares = np.stack([share, press - share], axis=1)
    dust = 1e-9 * np.abs(before).sum(axis=1) * (1.0 + height)
    held = 0.5 * (before[:, 0] ** 2 + before[:, 1] ** 2 + inertia * before[:, 2] ** 2)
    kept = 0.5 * (after[:, 0] ** 2 + after[:, 1] ** 2 + inertia * after[:, 2] ** 2)
    np.testing.assert_allclose(lost, held - kept, atol=1e-12 * held.max())
    assert np.all(lost >= -1e-12 * held)
    # No corner sinks, none pulls, friction stays within its bound.
    touches = np.stack([one, np.where(beside, one, 0.0)], axis=1) > 0.0
    assert np.all(leaves[touches] >= np.repeat(-dust, touches.sum(axis=1)))
    assert np.all(shares >= -dust[:, None])
    assert np.all(np.abs(along) <= friction * press + dust)
    # Where energy is lost, nothing had to be lowered: there Newton's law holds to round-off.
    free = lost > 1e-9 * held
    assert np.sum(~free & (rebound < 0.99)) > COUNT // 100
    aim = rebound[:, None] * came
    gap = np.where(touches, leaves - aim, 0.0)[free]
    assert np.all(gap >= -dust[free, None])
    assert np.all(np.minimum(np.abs(gap), shares[free]) <= dust[free, None])
    drags = free & (np.abs(after[:, 0] - after[:, 2] * height) > dust)
    pull = -friction * press * np.sign(after[:, 0] - after[:, 2] * height)
    assert drags.sum() > COUNT // 10
    np.testing.assert_allclose(along[drags], pull[drags], atol=dust.max())
    # A corner stays on the base where it did not come down: an edge whose other end rises.
    assert np.all(modes[~beside] == FLYING)
    assert min((modes == FLYING).sum(), (modes == PIVOTING).sum()) > COUNT // 100


def test_corners_that_bounce_obey_poissons_law_and_make_no_energy() -> None:
    """In two phases, the first of which is the impact without rebound."""
    random = np.random.default_rng(7)
    height, friction, before = scenes(random)
    beside, kept = random.random(COUNT) < 0.7, random.uniform(0.0, 1.0, COUNT)
    before[:, 2] = np.abs(before[:, 2])
    level = before[:, 2] == 0.0
    before[level, 0] = np.abs(before[level, 0])
    inertia, one = (1.0 + height**2) / 3.0, np.ones(COUNT)
    scene = (one, -height, -one, beside, before)
    first, _lost, _modes = bounced(bouncing(COUNT, friction, inertia, 0.0), *scene)
    after, lost, modes = bounced(bouncing(COUNT, friction, inertia, kept, "expansion"), *scene)
    dust = 1e-9 * np.abs(before).sum(axis=1) * (1.0 + height)

    def impulses(old: Array, new: Array) -> tuple[Array, Array]:
        """Along the base, and upwards at either corner."""
        along, press, _turn = (new - old).T
        moment = along * -height - inertia * (new[:, 2] - old[:, 2])
        share = np.where(beside, 0.5 * (moment + press), press)
        return along, np.stack([share, press - share], axis=1)

    _drag, pressed = impulses(before, first)
    along, shares = impulses(first, after)
    excess = shares - kept[:, None] * pressed
    rise = after[:, 1:2] - after[:, 2:] * np.stack([one, -one], axis=1)
    touches = np.stack([one, np.where(beside, one, 0.0)], axis=1) > 0.0
    assert np.all(rise[touches] >= np.repeat(-dust, touches.sum(axis=1)))
    # What no expansion obeys stays as the compression left it.
    found = np.abs(along) + np.abs(shares).sum(axis=1) > dust
    assert np.mean(found) > 0.99
    assert np.all(excess[found] >= -dust[found, None])
    gap = np.minimum(np.abs(excess), np.abs(rise))[found]
    assert np.all(gap[touches[found]] <= np.repeat(dust[found], touches[found].sum(axis=1)))
    press, slide = shares.sum(axis=1), after[:, 0] - after[:, 2] * height
    assert np.all(np.abs(along) <= friction * press + dust)
    drags = found & (np.abs(slide) > dust)
    assert drags.sum() > COUNT // 10
    np.testing.assert_allclose(
        along[drags], (-friction * press * np.sign(slide))[drags], atol=dust.max()
    )
    # No impact makes energy, of none had a part to be taken back.
    held = 0.5 * (before[:, 0] ** 2 + before[:, 1] ** 2 + inertia * before[:, 2] ** 2)
    assert np.all(lost >= -1e-12 * held)
    assert min((modes == FLYING).sum(), (modes == PIVOTING).sum()) > COUNT // 100


def test_a_free_rectangle_leaves_a_corners_impact_as_closed_forms_say() -> None:
    """Without friction by the mass that the corner feels, stuck by its matrix; flat by e alone."""
    half, height, speed, rebound = 0.03, 0.05, 1.3, 0.4
    inertia = (half**2 + height**2) / 3.0
    along = 0.2
    before = np.array([[along, -speed, 0.0]])
    for friction, slides, law in (
        *((0.0, True, "rebound"), (0.0, True, "expansion")),
        *((1e3, False, "rebound"), (1e3, False, "expansion")),
    ):
        rows = bouncing(1, friction, inertia, rebound, law)
        after, _lost, modes = bounced(rows, [half], np.array([-height]), [0.0], False, before)
        # Of (n, f): what the corner's velocity upwards and along the base answers.
        answer = np.array([[inertia + half**2, half * height],
                           [half * height, inertia + height**2]]) / inertia  # fmt: skip
        wanted = np.array([(1.0 + rebound) * speed, -along])
        if law == "expansion" and not slides:
            # What sticks in both phases gets e n in the second: e (v + K_nt s / K_tt) upwards.
            wanted[0] += rebound * answer[0, 1] / answer[1, 1] * along
        push = np.linalg.solve(answer, wanted) if not slides else [wanted[0] / answer[0, 0], 0.0]
        turn = (-half * push[0] - height * push[1]) / inertia
        np.testing.assert_allclose(after[0], [along + push[1], push[0] - speed, turn], rtol=1e-12)
        assert modes[0] == FLYING
    rows = bouncing(1, 0.0, inertia, rebound)
    after, _lost, _modes = bounced(rows, [half], np.array([-height]), [-half], True, before)
    np.testing.assert_allclose(after[0], [along, rebound * speed, 0.0], atol=1e-15)
