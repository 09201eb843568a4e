"""Steps of assemblies, held to a second solver and to the law itself; neither is our kernel's text.

Scenes that fit into one kernel are a batch, at 1e-3 s, under the same pulse of 1.2 g.
"""

from __future__ import annotations

import functools

import numpy as np
import numpy.typing as npt
import pytest
from scipy.optimize import linprog

from tests.shared.assemblies import as_records, assembly_lanes, built, oppenheim, wall_1
from tests.shared.marks import first
from tests.shared.second_solver import SecondSolver
from warprock.model import patterns
from warprock.model.motion import Control, Waveform, harmonic_motions
from warprock.model.response import Response, SampleTimes, Status
from warprock.running.batch import run_batch
from warprock.settings.engines import AssemblySettings
from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]

pytestmark = pytest.mark.usefixtures("two_rooms")

STEP, STEPS = 1e-3, 60
PART = 1e-5
SETTLED = PART * GRAVITY * STEP
"""Velocity to which a step is solved here [m/s], a hundredth of the default."""
LEFT = 10.0 * SETTLED
"""Velocity of a block that the joints around it leave together [m/s]."""
PEAK, FREQUENCY = 1.2 * GRAVITY, 4.0

SCENES = {
    "arch": oppenheim(7),
    "drums": built(patterns.column(1.0, 0.5, 5), 0.7),
    "wall": built(patterns.wall(0.4, 0.175, 2, 3, whole_first=False), 0.65),
    "smooth wall": built(patterns.wall(0.4, 0.175, 2, 3, whole_first=False), 0.3),
    "wall 1": wall_1(),
}


def base_velocity(time: float) -> float:
    omega = 2.0 * np.pi * FREQUENCY
    return float(PEAK / omega * (1.0 - np.cos(omega * time)))


def batch_of(scene: str) -> list[str]:
    """The scenes that run together with one: `wall 1` has more blocks, and a kernel of its own."""
    return [name for name in SCENES if (name == "wall 1") == (scene == "wall 1")]


@functools.cache
def engine_run(*scenes: str) -> Response:
    lanes, count = assembly_lanes([SCENES[scene] for scene in scenes]), len(scenes)
    motions = harmonic_motions(
        Waveform.SINE, [Control.ACCELERATION] * count, np.full(count, PEAK),
        np.full(count, FREQUENCY), np.zeros(count), np.full(count, 1.0 / FREQUENCY),
    )  # fmt: skip
    times = SampleTimes(STEPS * STEP, STEP, places=True)
    settings = AssemblySettings(time_step=STEP, settled=PART, iterations=20_000)
    return run_batch("assembly", lanes, as_records(motions), times, settings=settings)


def path(scene: str) -> Array:
    """Centres [m] and turns counterclockwise [rad] of all blocks, [step, block, 3]."""
    batch, kind = batch_of(scene), SCENES[scene]
    lane, found = batch.index(scene), engine_run(*batch)
    assert found["status"][lane] == Status.OK
    free = ~kind.fixed
    still = np.column_stack([kind.centre, np.zeros(kind.count)])
    places = np.repeat(still[None], STEPS + 1, axis=0)
    for axis, (name, sign) in enumerate((("x", 1.0), ("z", 1.0), ("turn", -1.0))):
        places[:, free, axis] = sign * found[name][lane, : free.sum()].T
    return places


@pytest.mark.thorough
@pytest.mark.parametrize("scene", first(2, [name for name in SCENES if name != "wall 1"]))
def test_a_second_solver_goes_the_same_way_step_by_step(scene: str):
    """Contacts are solved to SETTLED; of a chain of joints a block may have some times that.

    So places differ by `LEFT` times the length of the run, a 30,000th of how far blocks move.
    """
    solver, found = SecondSolver(SCENES[scene], STEP, base_velocity), path(scene)
    for step in range(STEPS):
        solver.advance()
        assert np.abs(solver.place - found[step + 1]).max() < STEPS * STEP * LEFT, step
    assert solver.left < 1e-3 * GRAVITY * STEP
    assert np.abs(found[-1] - found[0]).max() >= 1e-4


@pytest.mark.parametrize("scene", first(1, ["smooth wall", "wall 1"]))
def test_impulses_exist_by_which_a_wall_moves_as_the_engine_says(scene: str):
    """A wall has many answers where joints slide, so that another solver may find another one.

    Of the path of the engine a linear programme finds impulses that obey Coulomb's law and leave
    the least of the change of velocity that no contact explains.
    """
    kind, found = SCENES[scene], path(scene)
    solver = SecondSolver(kind, STEP, base_velocity)
    speeds = np.diff(found, axis=0, prepend=found[:1]) / STEP
    slid = 0
    for step in range(5, STEPS, 6):
        gain = base_velocity((step + 0.5) * STEP) - base_velocity((step - 0.5) * STEP)
        push = np.tile([-gain, -STEP * GRAVITY, 0.0], (kind.count, 1))
        solver.place = found[step]
        left, slides = _unexplained(
            solver, (speeds[step + 1] - speeds[step] - push), speeds[step + 1]
        )
        assert left < LEFT, step
        slid += slides
    assert slid > 0


def _unexplained(solver: SecondSolver, change: Array, speed: Array) -> tuple[float, int]:
    """Velocity that no impulses explain [m/s]; how many contacts that press slide."""
    rows, free = solver.contacts(), solver.free
    there = np.isfinite(rows.gap)
    opens = rows.normal[there] @ speed.ravel() + np.maximum(rows.gap[there], 0.0) / solver.step
    slips = rows.tangent[there] @ speed.ravel()
    friction = solver.friction[there]
    assert opens.min() > -LEFT
    count, tiny = int(there.sum()), LEFT
    moves = np.vstack([rows.normal[there], rows.tangent[there]])[:, free].T
    moves = moves / solver.masses[free][:, None]
    wanted = change.ravel()[free]
    last = np.ones((len(wanted), 1))
    eye, none = np.eye(count), np.zeros((count, 1))
    # Unknowns: N, T, and the largest part of the change that is left.
    upper = np.block([
        [moves, -last], [-moves, -last],
        [-np.diag(friction), eye, none], [-np.diag(friction), -eye, none],
    ])  # fmt: skip
    bound = np.concatenate([wanted, -wanted, np.zeros(2 * count)])
    glides = np.flatnonzero(np.abs(slips) > tiny)
    equal = np.zeros((len(glides), 2 * count + 1))
    equal[np.arange(len(glides)), count + glides] = 1.0
    equal[np.arange(len(glides)), glides] = friction[glides] * np.sign(slips[glides])
    presses = opens < tiny
    limits = [(0.0, None if at else 0.0) for at in presses] + [(None, None)] * count + [(0.0, None)]
    cost = np.zeros(2 * count + 1)
    cost[-1] = 1.0
    solved = linprog(
        cost, upper, bound, equal if len(glides) else None,
        np.zeros(len(glides)) if len(glides) else None, limits,
    )  # fmt: skip
    return float(solved.fun), int((presses & (np.abs(slips) > tiny)).sum())
