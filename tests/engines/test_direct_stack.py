"""`direct` on stacks: its solve against brute force, statics, sliding, very different weights."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest
import warp as wp

from tests.shared.blocks import Array, at_rest, make_stacks, sines, velocity_steps
from tests.shared.pairs import potential_energy
from warprock.kernels.launch.instance import LOOPS_STAY, kernel_module, module_options
from warprock.model.lanes import Lanes
from warprock.model.motion import Control, GroundMotions
from warprock.model.response import Outcome, Response, SampleTimes, Status
from warprock.running.batch import run_batch
from warprock.settings.engines import DirectSettings
from warprock.units import GRAVITY

pytestmark = pytest.mark.thorough

contact: Any = kernel_module("direct/stack", precision="float64", blocks=2)
Rows, Triples = contact.Rows, contact.Triples
Numbers: Any = wp.array2d(dtype=wp.float64)


# The options of the engines: headers are compiled once for each set of flags.
wp.set_module_options(module_options() | LOOPS_STAY)


@wp.kernel
def solve_all(problems: wp.array(dtype=contact.Equations), found: Numbers, by_lemke: bool):
    """The engine's solve of two interfaces, problem by problem."""
    i = wp.tid()
    system = problems[i]
    p, solved, _tries = contact.solve(system, Triples())
    if by_lemke:
        p = contact.solve_states(system, contact.lemke(system))
        solved = contact.keeps_laws(system, p)
    found[i, 0] = wp.where(solved, wp.float64(1.0), wp.float64(0.0))
    for j in range(6):
        found[i, 1 + j] = p[j]


def random_problems(count: int, box: bool) -> tuple[Any, Array, Array, Array, Array]:
    """Problems of two interfaces between bodies whose rows are random.

    Returns:
        Their structs; matrices [problem, 6, 6]; velocities without contact [problem, 6]; friction
        and bounds [problem, 2].
    """
    rng = np.random.default_rng(11)
    upper, lower = rng.normal(size=(2, count, 2, 3, 3))
    lower[:, 0] = 0.0
    jacobian = np.zeros((count, 6, 6))
    jacobian[:, :3, :3], jacobian[:, 3:, 3:] = upper[:, 0], upper[:, 1]
    jacobian[:, 3:, :3] = lower[:, 1]
    cfm = 10.0 ** rng.uniform(-12.0, -1.0, count)
    matrix = jacobian @ jacobian.transpose(0, 2, 1)
    matrix += cfm[:, None, None] * np.diag([1.0, 1.0, 0.0, 1.0, 1.0, 0.0])
    free = rng.normal(size=(count, 6))
    friction = rng.uniform(0.0, 1.0, (count, 2))
    bound = friction * rng.random((count, 2)) if box else np.zeros((count, 2))
    friction = np.zeros((count, 2)) if box else friction
    rows = np.zeros(count, dtype=contact.Equations.numpy_dtype())
    rows["own"][:, :3], rows["own"][:, 3:] = matrix[:, :3, :3], matrix[:, 3:, 3:]
    rows["above"][:, :3] = matrix[:, :3, 3:]
    rows["free"], rows["friction"], rows["bound"] = free, friction, bound
    return rows, matrix, free, friction, bound


def solved(rows: Any, by_lemke: bool) -> Array:
    """Impulses that the engine finds, shape [problem, 6]; every problem must be solved."""
    found = wp.zeros((len(rows), 7), dtype=wp.float64, device="cpu")
    problems = wp.array(rows, dtype=contact.Equations, device="cpu")
    wp.launch(solve_all, len(rows), inputs=[problems, found, by_lemke], device="cpu")
    values = np.asarray(found.numpy())
    assert np.all(values[:, 0] == 1.0)
    return values[:, 1:]


@pytest.mark.parametrize("by_lemke", [False, True])
@pytest.mark.parametrize("box", [False, True])
def test_solve_meets_the_contact_laws(box: bool, by_lemke: bool) -> None:
    rows, matrix, free, friction, bound = random_problems(20_000, box)
    p = solved(rows, by_lemke)
    w = np.einsum("lij,lj->li", matrix, p) + free
    # Round-off of what adds up to a velocity.
    grain = 1e-10 * (1.0 + np.abs(matrix).max(axis=(1, 2)) * np.abs(p).max(axis=1))
    for k in (0, 3):
        for i in (k, k + 1):
            assert np.all(np.abs(np.minimum(p[:, i], w[:, i])) <= grain)
        limit = bound[:, k // 3] + friction[:, k // 3] * (p[:, k] + p[:, k + 1])
        force, slip = p[:, k + 2], w[:, k + 2]
        assert np.all(np.abs(force) <= limit + grain)
        # Inside the bound no slip, on it none with the force.
        assert np.all(np.minimum(np.abs(slip), np.abs(limit - np.abs(force))) <= grain)
        assert np.all(np.minimum(np.abs(force), np.sign(force) * slip) <= grain)
        assert 1000 < np.count_nonzero((p[:, k] > 0.0) & (p[:, k + 1] > 0.0)) < 19_000
        assert 1000 < np.count_nonzero(np.abs(slip) > 1e-6) < 19_999


def test_solution_of_a_box_is_the_one_that_brute_force_finds() -> None:
    rows, matrix, free, _, bound = random_problems(60, box=True)
    p = solved(rows, by_lemke=False)
    for lane in range(60):
        kept = []
        for state in itertools.product((0, 1), (0, 1), (-1, 0, 1), (0, 1), (0, 1), (-1, 0, 1)):
            a, right = matrix[lane].copy(), -free[lane]
            for i, each in enumerate(state):
                if each == 0 if i % 3 < 2 else each != 0:
                    a[i], right[i] = np.eye(6)[i], each * bound[lane, i // 3]
            x = np.linalg.solve(a, right)
            w = matrix[lane] @ x + free[lane]
            ends = [0, 1, 3, 4]
            fits = min(x[ends].min(), w[ends].min()) >= -1e-9
            fits &= np.all(np.abs(x[[2, 5]]) <= bound[lane] + 1e-9)
            fits &= np.all(np.array(state)[[2, 5]] * w[[2, 5]] <= 1e-9)
            if fits:
                kept.append(x)
        # The matrix is positive definite: there is one solution.
        assert kept
        for x in kept:
            np.testing.assert_allclose(x, p[lane], rtol=1e-7, atol=1e-7)


def run(lanes: Lanes, motions: GroundMotions, times: SampleTimes, **settings: Any) -> Response:
    """A run in which no lane fails."""
    response = run_batch("direct", lanes, motions, times, settings=DirectSettings(**settings))
    assert np.all(response["status"] == Status.OK)
    return response


def test_eccentric_stack_tilts_on_its_springs_by_statics() -> None:
    stiffness = 1e9
    offset = np.array([[0.0, 0.05, 0.0, 0.0, 0.02, 0.0], [0.0, 0.05, -0.05, 0.02, 0.0, -0.01]])
    width = np.tile([0.8, 0.7, 0.6, 0.5, 0.4, 0.3], (2, 1))
    lanes = make_stacks(width, 0.2, offset=offset, chamfer=0.01)
    response = run(
        lanes,
        at_rest(2),
        SampleTimes(2.0, 0.5),
        substeps=4,
        contact_stiffness=stiffness,
        contact_damping=5e-3 * stiffness,
    )
    # Two springs at the ends of each face carry what stands on it, eccentric by e: the face turns
    # by weight e / (2 stiffness (half width)^2), and each block by all faces below it.
    place = np.cumsum(lanes.offset, axis=1)
    total = np.cumsum(lanes.mass[:, ::-1], axis=1)[:, ::-1]
    centre = np.cumsum((lanes.mass * place)[:, ::-1], axis=1)[:, ::-1] / total
    half = 0.5 * lanes.face_width
    below = np.concatenate([np.full((2, 1), np.inf), half[:, :-1]], axis=1)
    right = np.minimum(half, below - lanes.offset)
    left = np.minimum(half, below + lanes.offset)
    middle = place + 0.5 * (right - left)
    tilt = GRAVITY * total * (centre - middle) / (2.0 * stiffness * (0.5 * (right + left)) ** 2)
    np.testing.assert_allclose(
        response["rotation"][:, :, -1], np.cumsum(tilt, axis=1), rtol=1e-3, atol=1e-12
    )
    assert np.all(response["outcome"] == Outcome.AT_REST)
    assert np.all(response["impact_count"] == 0)


def test_stack_slides_by_the_closed_form() -> None:
    # The lower block slides under the upper one's weight, which sticks to it.
    speed, friction = np.array([0.3, -0.2]), 0.1
    lanes = make_stacks(np.full((2, 2), 1.0), 0.5, friction=[friction, 1.0])
    motions = velocity_steps(speed, np.zeros(2), np.full(2, 10.0))
    response = run(lanes, motions, SampleTimes(1.0))
    expected = -np.sign(speed) * speed**2 / (2.0 * friction * GRAVITY)
    # First order: the last step may be off by v dt.
    slide = response["residual_slide"]
    assert np.all(np.abs(slide[:, 0] - expected) <= np.abs(speed) / 5040.0)
    assert np.all(np.abs(slide[:, 1]) <= 1e-9)
    np.testing.assert_allclose(
        response["energy_lost"], 0.5 * lanes.mass.sum(axis=1) * speed**2, rtol=2e-3
    )


@pytest.mark.parametrize("box", [0, 1])
def test_shaken_stacks_are_solved_in_every_step(box: bool) -> None:
    # Six blocks of any shape, weight and friction, shaken until some slide off or fall.
    rng = np.random.default_rng(0)
    shape = (24, 6)
    lanes = make_stacks(
        rng.uniform(0.2, 0.6, shape),
        rng.uniform(0.2, 0.8, shape),
        friction=rng.choice([0.1, 0.3, 0.7, 2.0, 10.0], shape),
        density=rng.choice([200.0, 2000.0], shape),
    )
    size, frequency = rng.uniform(0.1, 1.5, 24) * GRAVITY, rng.uniform(1.0, 6.0, 24)
    motions = sines(Control.ACCELERATION, size, frequency, 3.0)
    response = run(lanes, motions, SampleTimes(1.5), substeps=4, friction_box=int(box))
    outcomes = set(response["outcome"].tolist())
    assert {Outcome.ROCKING, Outcome.OVERTURNED, Outcome.SLID_OFF} <= outcomes


@pytest.mark.parametrize("ratio", [1e-4, 1e4])
def test_blocks_of_very_different_weight_stay_solved(ratio: float) -> None:
    turn = np.stack([np.linspace(-0.1, 0.1, 8), np.linspace(0.1, -0.05, 8)], axis=1)
    lanes = make_stacks(
        np.tile([0.4, 0.3], (8, 1)), 0.6, density=[1000.0, 1000.0 * ratio], rotation=turn
    )
    response = run(lanes, at_rest(8), SampleTimes(3.0))
    lost = response["energy_lost"] / potential_energy(lanes)
    # All of it where the stack has come to rest, part of it where it has not.
    assert np.all((lost > 0.9) & (lost < 1.0 + 1e-4))
