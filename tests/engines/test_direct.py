"""`direct`: its solve against brute force, its contacts against closed forms, its order."""

from __future__ import annotations

import dataclasses
import itertools
from typing import Any

import numpy as np
import pytest
import warp as wp

from tests.shared.blocks import Array, at_rest, free_lanes, make_lanes, sines
from warprock.kernels.launch.instance import kernel_module, module_options
from warprock.model.motion import Control
from warprock.model.response import SampleTimes, Status
from warprock.running.batch import run_batch
from warprock.settings.engines import DirectSettings
from warprock.units import GRAVITY

direct: Any = kernel_module("direct/block", precision="float64")


Numbers: Any = wp.array2d(dtype=wp.float64)


# The options of the engines: headers are compiled once for each set of flags.
wp.set_module_options(module_options())


@wp.kernel
def solve_all(problems: Numbers, found: Numbers):
    """The engine's solve, problem by problem."""
    i = wp.tid()
    row = problems[i]
    p = direct.solve_contacts(direct.Problem(
        row[0], row[1], row[2], row[3], row[4], row[5], row[6], row[7], row[8], row[9], row[10]
    ))  # fmt: skip
    found[i, 0] = p.miss
    found[i, 1] = p.n1
    found[i, 2] = p.n2
    found[i, 3] = p.f


@wp.kernel
def fall(block: direct.Block, knobs: direct.Knobs, speed: wp.float64, path: Numbers):
    """Height above the undeformed base [m] and velocity [m/s] of a flat block, step by step."""
    state = direct.State()
    state.z = block.half_height
    state.vz = speed
    carried = direct.Carried()
    loss = wp.float64(0.0)
    for k in range(path.shape[0]):
        after, bears, _gaps, _miss = direct.step(
            block, knobs, wp.float64(0.0), state, carried, loss
        )
        state = after
        carried = bears
        path[k, 0] = state.z - block.half_height
        path[k, 1] = state.vz


def fallen(
    step: float, stiffness: float, damping: float, gravity: float, speed: float, count: int
) -> Array:
    """Path of a block of mass 1, shape [step, 2], from the base at a speed."""
    block, knobs = direct.Block(), direct.Knobs()
    block.half_width, block.half_height, block.friction = 0.25, 0.5, 1.0
    block.inverse_inertia = 3.0 / (0.25**2 + 0.5**2)
    drag = step * stiffness + damping
    block.stiffness, block.cfm, block.erp = stiffness, 1.0 / (step * drag), step * stiffness / drag
    knobs.time_step, knobs.rate, knobs.gravity = step, 1.0 / step, gravity
    knobs.margin, knobs.box = 2.0 * gravity * step**2, 0.0
    path = wp.zeros((count, 2), dtype=wp.float64, device="cpu")
    wp.launch(fall, 1, inputs=[block, knobs, speed, path], device="cpu")
    return np.asarray(path.numpy())


def random_problems(count: int, largest_friction: float) -> Array:
    """Contact problems of blocks of any shape and lean, a third of them with a box."""
    rng = np.random.default_rng(5)
    b, h = rng.uniform(0.05, 3.0, (2, count))
    theta = np.where(rng.random(count) < 0.3, 1e-9, 1.5) * rng.random(count)
    w, s, c = 3.0 / (b * b + h * h), np.sin(theta), np.cos(theta)
    x1, x2, z2 = -b * c - h * s, b * c - h * s, -b * s - h * c
    cfm = 10.0 ** rng.uniform(-15.0, 1.0, count)
    friction = rng.uniform(0.0, largest_friction, count)
    box = rng.random(count) < 0.33
    return np.column_stack(
        [
            np.where(box, 0.0, friction),
            np.where(box, friction * rng.random(count), 0.0),
            *(1.0 + w * x1 * x1 + cfm, 1.0 + w * x1 * x2, 1.0 + w * x2 * x2 + cfm),
            *(-w * x1 * z2, -w * x2 * z2, 1.0 + w * z2 * z2),
            rng.normal(size=(count, 3)),
        ]
    )


def solved(problems: Array) -> Array:
    """What the engine finds: what it missed, n1, n2, f; shape [problem, 4]."""
    found = wp.zeros((len(problems), 4), dtype=wp.float64, device="cpu")
    rows = wp.array(problems, dtype=wp.float64, device="cpu")
    wp.launch(solve_all, len(problems), inputs=[rows, found], device="cpu")
    return np.asarray(found.numpy())


def brute_force(problem: Array) -> list[Array]:
    """Every (n1, n2, f) that keeps the contact laws, by trying all twelve states."""
    mu, bound, k11, k12, k22, k13, k23, k33 = problem[:8]
    matrix = np.array([[k11, k12, k13], [k12, k22, k23], [k13, k23, k33]])
    free, kept = problem[8:], []
    for on1, on2, drag in itertools.product((False, True), (False, True), (-1, 0, 1)):
        # Rows: w or n of the corners, slip or the friction's law.
        rows, right = matrix.copy(), -free
        for corner, on in enumerate((on1, on2)):
            if not on:
                rows[corner], right[corner] = np.eye(3)[corner], 0.0
        if drag:
            rows[2], right[2] = [-drag * mu, -drag * mu, 1.0], drag * bound
        n = np.linalg.solve(rows, right)
        velocity = matrix @ n + free
        limit = bound + mu * (n[0] + n[1])
        slack = 1e-11 * (1.0 + np.abs(n).max() * matrix.max())
        fits = min(n[0], n[1], velocity[0], velocity[1]) >= -slack
        fits &= abs(n[2]) <= limit + slack
        fits &= drag * velocity[2] <= slack
        if fits:
            kept.append(n)
    return kept


def test_solve_is_exact_against_brute_force() -> None:
    problems = random_problems(1500, 1.0)
    found = solved(problems)
    assert np.all(found[:, 0] == 0.0)
    states = set()
    for problem, (_, n1, n2, f) in zip(problems, found, strict=True):
        kept = brute_force(problem)
        gaps = [np.abs(np.array([n1, n2, f]) - each).max() for each in kept]
        # Round-off of a solve of three rows whose numbers lie between 1e-2 and 1e2.
        assert min(gaps) <= 1e-9 * (1.0 + abs(n1) + abs(n2) + abs(f))
        limit = problem[1] + problem[0] * (n1 + n2)
        states.add((n1 > 0.0, n2 > 0.0, bool(abs(f) < 0.999 * limit)))
    # Nothing, one, both, each but the first sticking and sliding, were all among them.
    assert len(states) >= 7


def test_solve_meets_the_contact_laws_at_any_friction() -> None:
    problems = random_problems(200_000, 10.0)
    mu, bound, k11, k12, k22, k13, k23, k33, q1, q2, q3 = problems.T
    miss, n1, n2, f = solved(problems).T
    assert np.all(miss == 0.0)
    w1 = q1 + k11 * n1 + k12 * n2 + k13 * f
    w2 = q2 + k12 * n1 + k22 * n2 + k23 * f
    slip = q3 + k13 * n1 + k23 * n2 + k33 * f
    limit = bound + mu * (n1 + n2)
    # The velocities that the problems start from are about 1.
    tolerance = 1e-10
    for w, n in ((w1, n1), (w2, n2)):
        assert np.abs(np.minimum(w, n)).max() <= tolerance
    assert np.max(np.abs(f) - limit) <= tolerance
    inside = np.abs(f) < limit - 1e-9
    assert np.abs(slip[inside]).max() <= tolerance
    assert np.max((f * slip)[~inside]) <= tolerance
    assert np.count_nonzero(inside) > 10_000 < np.count_nonzero(~inside & (limit > 0.0))


def test_block_sinks_by_its_weight_over_the_stiffness() -> None:
    stiffness, damping = 4e5, 400.0
    path = fallen(1e-3, stiffness, damping, GRAVITY, 0.0, 400)
    # Two springs under a block of mass 1; the motion has decayed by exp(-160).
    np.testing.assert_allclose(path[-1, 0], -GRAVITY / (2.0 * stiffness), rtol=1e-9)
    assert abs(path[-1, 1]) <= 1e-12


def test_drop_follows_backward_euler_on_a_spring_and_a_dashpot() -> None:
    step, stiffness, damping, speed = 2e-4, 4e5, 40.0, -0.3
    path = fallen(step, stiffness, damping, GRAVITY, speed, 60)
    z, v = 0.0, speed
    for k in range(60):
        # Two springs and dashpots push, or nothing does.
        free = v - step * GRAVITY
        held = (free - 2.0 * step * stiffness * z) / (
            1.0 + 2.0 * step * (step * stiffness + damping)
        )
        touches = (
            z <= 2.0 * GRAVITY * step**2 and stiffness * (z + step * held) + damping * held < 0
        )
        v = held if touches else free
        z += step * v
        np.testing.assert_allclose(path[k], [z, v], rtol=0.0, atol=1e-13)
    assert path[-1, 1] > 0.1


def test_drop_restitution_converges_to_the_closed_form() -> None:
    # Schwager and Poeschel (2007): the force of a spring and a dashpot that cannot pull ends
    # before the overlap does.
    stiffness, ratio, speed = 4e5, 0.2, -0.3
    natural = np.sqrt(2.0 * stiffness)
    rate = ratio * natural
    omega = np.sqrt(natural**2 - rate**2)
    expected = np.exp(-rate / omega * (np.pi - np.arctan2(2.0 * rate * omega, omega**2 - rate**2)))
    errors = []
    for steps in (100, 200, 400, 800):
        step = np.pi / natural / steps
        path = fallen(step, stiffness, ratio * natural, 0.0, speed, 3 * steps)
        errors.append(abs(path[-1, 1] / -speed - expected))
    # First order: half of the step, half of the error.
    assert errors[0] <= 0.05
    ratios = np.array(errors[:-1]) / np.array(errors[1:])
    assert np.all((ratios > 1.6) & (ratios < 2.5))


def test_stiff_contacts_converge_to_rigid_ones() -> None:
    lanes, times = free_lanes(), SampleTimes(3.0, 0.01)
    rigid = run_batch("direct", lanes, at_rest(9), times)["rotation"]
    gaps = []
    for stiffness in (1e8, 1e9, 1e10, 1e11):
        settings = DirectSettings(contact_stiffness=stiffness, contact_damping=5e-3 * stiffness)
        soft = run_batch("direct", lanes, at_rest(9), times, settings=settings)["rotation"]
        gaps.append(np.max(np.abs(soft - rigid).max(axis=1) / lanes.slenderness_angle))
    # What a block sinks goes with 1 / stiffness: a thousandth of it over three decades, within
    # the factor by which the scatter of impacts in their steps moves each end.
    assert gaps[0] <= 2e-2
    assert np.all(np.diff(gaps) < 0.0)
    assert 1e-4 <= gaps[-1] / gaps[0] <= 1e-2


def test_flat_block_tilts_on_its_springs_by_the_closed_form() -> None:
    # A slow pulse of 0.1 g, far below uplift: m a h / 2 on two springs, each b from the middle.
    stiffness = 1e8
    lanes = make_lanes(np.full(1, 0.5), 1.0)
    motions = sines(Control.ACCELERATION, 0.1 * GRAVITY, 1.0, 0.5)
    settings = DirectSettings(contact_stiffness=stiffness, contact_damping=1e5)
    response = run_batch("direct", lanes, motions, SampleTimes(0.5), settings=settings)
    moment = lanes.mass * 0.1 * GRAVITY * 0.5 * lanes.height
    tilt = moment / (2.0 * stiffness * (0.5 * lanes.width) ** 2)
    # Its own weight tilts it on by m g h / 2 over the stiffness, 1e-4 of that; the step less.
    np.testing.assert_allclose(response["peak_rotation"], tilt, rtol=1e-3)
    assert response["impact_count"][0] == 0


@pytest.mark.parametrize("stiffness", [1e7, 1e9, 1e15])
@pytest.mark.parametrize("relaxation", [0.0, 1e-3])
@pytest.mark.parametrize("box", [0, 1])
def test_energy_never_grows(stiffness: float, relaxation: float, box: int) -> None:
    lanes = free_lanes()
    settings = DirectSettings(
        contact_stiffness=stiffness, contact_damping=relaxation * stiffness, friction_box=box
    )
    times = SampleTimes(3.0, 0.01)
    response = run_batch("direct", lanes, at_rest(9), times, settings=settings)
    assert np.all(response["status"] == Status.OK)
    assert np.all(response["energy_lost"] > 0.0)
    height = lanes.rotation_start[:, None]
    # No swing beyond the release, but for what a corner sinks, m g / k over its half width.
    sunk = lanes.mass * GRAVITY / stiffness / (0.5 * lanes.width)
    assert np.all(np.abs(response["rotation"]) <= (1.0 + 1e-3) * height + 2.0 * sunk[:, None])


def test_box_slips_at_impacts_and_the_cone_does_not() -> None:
    lanes, times = free_lanes(), SampleTimes(3.0, 0.01)
    wide = dataclasses.replace(lanes, friction=np.full(9, 1e4))
    cone, box, wide_box = (
        run_batch("direct", each, at_rest(9), times, settings=DirectSettings(friction_box=kind))
        for each, kind in ((lanes, 0), (lanes, 1), (wide, 1))
    )
    # An impact asks for far more friction than the weight of the step before it allows.
    assert np.all(cone["peak_slide"] <= 2e-5)
    assert np.max(box["peak_slide"]) >= 1e-4
    # A box that is never reached is no box.
    np.testing.assert_array_equal(wide_box["rotation"], cone["rotation"])
