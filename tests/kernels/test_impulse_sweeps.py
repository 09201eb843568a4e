"""The contacts of `impulse`: two by sweeps that end once one changes nothing, one alone exactly."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import warp as wp

from warprock.kernels.launch.instance import MAX_UNROLL, kernel_module, module_options
from warprock.running.devices import start_warp

SWEEPS = 100
"""More than are written out, so that they may end early."""

start_warp()
impulse: Any = kernel_module("impulse/block", precision="float64", iterations=SWEEPS)
Numbers: Any = wp.array2d(dtype=wp.float64)
Array = npt.NDArray[np.float64]


# The options of the engines: headers are compiled once for each set of flags.
wp.set_module_options(module_options())


@wp.kernel
def solve_all(problems: Numbers, found: Numbers):
    """The engine's solve, problem by problem."""
    i = wp.tid()
    row = problems[i]
    one = impulse.Corner(row[2], row[3], row[6], row[8], row[9])
    two = impulse.Corner(row[4], row[5], row[7], row[10], row[11])
    guess = impulse.Impulses(row[12], row[13], row[14], row[15])
    p = impulse.solve(row[0], row[1], one, two, guess)
    found[i, 0] = p.n1
    found[i, 1] = p.f1
    found[i, 2] = p.n2
    found[i, 3] = p.f2


def random_problems(count: int) -> Array:
    """Contacts of blocks of any shape and lean, one corner or both, started from anywhere."""
    rng = np.random.default_rng(3)
    b, h = rng.uniform(0.05, 3.0, (2, count))
    theta = rng.uniform(0.0, 1.5, count)
    w, s, c = 3.0 / (b * b + h * h), np.sin(theta), np.cos(theta)
    return np.column_stack(
        [
            rng.uniform(0.0, 1.5, count),
            w,
            *(-b * c - h * s, b * s - h * c, b * c - h * s, -b * s - h * c),
            *rng.choice([0.0, 1.0], (2, count)),
            *rng.normal(size=(4, count)),
            *rng.uniform(0.0, 0.3, (4, count)),
        ]
    )


def contacts(problem: Array) -> tuple[Array, Array, Array]:
    """Matrix of the contacts, which rows are active and their velocities; rows n1, f1, n2, f2."""
    w, x1, z1, x2, z2, on1, on2 = problem[1:8]
    rows = np.array([[0, 1, -x1], [1, 0, z1], [0, 1, -x2], [1, 0, z2]], dtype=float)
    matrix = rows @ np.diag([1.0, 1.0, w]) @ rows.T
    return matrix, np.array([on1, on1, on2, on2]), problem[8:12]


def swept(problem: Array, sweeps: int) -> Array:
    """Projected Gauss-Seidel by the matrix of the contacts."""
    matrix, active, velocities = contacts(problem)
    impulses = problem[12:] * active
    for _ in range(sweeps):
        for i in range(4):
            rest = matrix[i] @ impulses - matrix[i, i] * impulses[i]
            wanted = -active[i] * (velocities[i] + rest) / matrix[i, i]
            bound = problem[0] * impulses[i - 1]
            impulses[i] = max(wanted, 0.0) if i % 2 == 0 else np.clip(wanted, -bound, bound)
    return impulses


def lawful(problem: Array) -> list[tuple[float, float]]:
    """All impulses n and f that obey Coulomb at the only contact: it sticks, slides, leaves."""
    matrix, active, velocities = contacts(problem)
    own = np.flatnonzero(active)
    matrix, velocities, mu = matrix[np.ix_(own, own)], velocities[own], problem[0]
    n, f = np.linalg.solve(matrix, -velocities)
    found = [(n, f)] if abs(f) <= mu * n else []
    for side in (-1.0, 1.0):
        n = -velocities[0] / (matrix[0] @ (1.0, side * mu))
        slip = velocities[1] + n * (matrix[1] @ (1.0, side * mu))
        found += [(n, side * mu * n)] if n > 0.0 and side * slip <= 0.0 else []
    return found + ([(0.0, 0.0)] if velocities[0] >= 0.0 else [])


def solved(problems: Array) -> Array:
    """What the engine's solve finds, shape [problem, 4]."""
    found = wp.zeros((len(problems), 4), dtype=wp.float64, device="cpu")
    given = wp.array(problems, dtype=wp.float64, device="cpu")
    wp.launch(solve_all, len(problems), inputs=[given, found], device="cpu")
    return np.asarray(found.numpy())


def test_sweeps_that_end_early_are_all_of_them():
    """To round-off, of which each of the sweeps may leave its own."""
    assert SWEEPS > MAX_UNROLL
    problems = random_problems(150)
    problems = problems[problems[:, 6] == problems[:, 7]]
    expected = np.array([swept(problem, SWEEPS) for problem in problems])
    np.testing.assert_allclose(solved(problems), expected, rtol=1e-10, atol=SWEEPS * 2e-15)


def test_a_contact_that_is_alone_obeys_the_law_to_round_off():
    """Sweeps need not settle there; of several answers it takes the first, which is to stick."""
    problems = random_problems(3000)
    problems = problems[problems[:, 6] != problems[:, 7]]
    # Friction to 4.5: beyond Painleve's limit, too, where some have several answers or none.
    problems[:, 0] *= 3.0
    answers = [lawful(problem) for problem in problems]
    counts = np.array([len(each) for each in answers])
    assert np.sum(counts == 1) > 1000
    assert np.sum(counts > 1) > 10
    active = np.repeat(problems[:, 6:8], 2, axis=1)
    found = solved(problems)
    assert np.all(found[active == 0.0] == 0.0)
    alone = found[active == 1.0].reshape(-1, 2)
    solvable = counts > 0
    expected = np.array([each[0] for each in answers if each])
    np.testing.assert_allclose(alone[solvable], expected, rtol=1e-9, atol=1e-12)
    # Where nothing obeys the law the answer is finite, and within the cone.
    assert np.all(np.abs(alone[:, 1]) <= problems[:, 0] * alone[:, 0] + 1e-15)
