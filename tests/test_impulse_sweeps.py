"""The sweeps of `impulse` that end once one changes nothing, against sweeps in NumPy."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import warp as wp

from warprock.devices import start_warp
from warprock.kernels.instance import MAX_UNROLL, kernel_module

SWEEPS = 100
"""More than are written out, so that they may end early."""

start_warp()
impulse: Any = kernel_module("impulse", precision="float64", iterations=SWEEPS)
Numbers: Any = wp.array2d(dtype=wp.float64)
Array = npt.NDArray[np.float64]


@wp.kernel(enable_backward=False)
def solve_all(problems: Numbers, found: Numbers):
    """The engine's solve, problem by problem."""
    i = wp.tid()
    n1, f1, n2, f2 = impulse.solve(
        problems[i, 0], problems[i, 1], problems[i, 2], problems[i, 3], problems[i, 4],
        problems[i, 5], problems[i, 6], problems[i, 7], problems[i, 8], problems[i, 9],
        problems[i, 10], problems[i, 11], problems[i, 12], problems[i, 13], problems[i, 14],
        problems[i, 15],
    )  # fmt: skip
    found[i, 0] = n1
    found[i, 1] = f1
    found[i, 2] = n2
    found[i, 3] = f2


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


def swept(problem: Array, sweeps: int) -> Array:
    """Projected Gauss-Seidel by the matrix of the contacts, rows n1, f1, n2, f2."""
    mu, w, x1, z1, x2, z2, on1, on2, *velocities = problem[:12]
    rows = np.array([[0, 1, -x1], [1, 0, z1], [0, 1, -x2], [1, 0, z2]], dtype=float)
    matrix = rows @ np.diag([1.0, 1.0, w]) @ rows.T
    active = np.array([on1, on1, on2, on2])
    impulses = problem[12:] * active
    for _ in range(sweeps):
        for i in range(4):
            rest = matrix[i] @ impulses - matrix[i, i] * impulses[i]
            wanted = -active[i] * (velocities[i] + rest) / matrix[i, i]
            bound = mu * impulses[i - 1]
            impulses[i] = max(wanted, 0.0) if i % 2 == 0 else np.clip(wanted, -bound, bound)
    return impulses


def test_sweeps_that_end_early_are_all_of_them():
    """To round-off, of which each of the sweeps may leave its own."""
    assert SWEEPS > MAX_UNROLL
    problems = random_problems(150)
    found = wp.zeros((len(problems), 4), dtype=wp.float64, device="cpu")
    given = wp.array(problems, dtype=wp.float64, device="cpu")
    wp.launch(solve_all, len(problems), inputs=[given, found], device="cpu")
    expected = np.array([swept(problem, SWEEPS) for problem in problems])
    np.testing.assert_allclose(found.numpy(), expected, rtol=1e-10, atol=SWEEPS * 2e-15)
