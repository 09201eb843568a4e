"""Limit analysis: the sideways load at which an assembly collapses, by linear programme.

By the static theorem a load is carried if joints can transmit forces that balance it, compressive
and within Coulomb's cone. Of a joint between two blocks these are the forces at its two ends. The
largest factor on a sideways self-weight beside the self-weight itself,

    maximise  f   with   B r + f live + dead = 0,   n >= 0,   |t| <= friction n  at every end,

is a linear programme; its dual variables are the velocities of the blocks in the mechanism that
forms (Livesley 1978, Limit analysis of structures formed from rigid blocks, *International Journal
for Numerical Methods in Engineering* 12). Where joints slide in it the programme lets them open as
they slide, which Coulomb's law does not: the factor is an upper bound then (Drucker 1954, Coulomb
friction, plasticity, and limit loads, *Journal of Applied Mechanics* 21).

There a sequence of programmes finds a load with Coulomb's law: each end has the strength friction n
of its normal force n in the programme before, as a cohesion that hardly depends on its own n, so
that it slides without opening (Gilbert, Casapulla and Ahmed 2006, Limit analysis of masonry block
structures with non-associative frictional joints using linear programming, *Computers and
Structures* 84). Forces, load and mechanism obey Coulomb's law once the sequence settles; there may
be more than one such load.
"""

from __future__ import annotations

import dataclasses
import functools
import time
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy

from warprock.case.case import Case
from warprock.case.lanes import LaneSet, expand_lanes
from warprock.errors import InputError
from warprock.model.assembly import Assembly
from warprock.quantity import NOTHING, Said
from warprock.running.case_run import CaseRun
from warprock.running.options import Progress

Array = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]

MOST_JUDGED = 500
"""Blocks of an assembly: the programme takes some 15 s for 400 of a wall, and twice as many take
six times as long."""

MOST_KINDS = 10_000
"""Assemblies that differ in a case: of 30 blocks each takes 0.1 s."""

WEAKER = 1.0 - 1e-6
"""Load factor to the left over that to the right below which the left is the weaker side; both are
solved to 1e-7."""

MOST_COULOMB, LARGEST_COULOMB = 20, 60
"""Assemblies that differ whose load with Coulomb's law is looked for, and blocks of one: it takes
some 20 times as long as the bound, of a wall of 46 blocks 1.4 s."""

PROGRAMMES = 80
"""Programmes of the sequence, at most: walls of 30 to 50 blocks take 7 to 50."""

SOFTENING, LEAST_COHESION = 1e-3, 1e-4
"""What an end loses of its strength as its normal force grows, over its friction; and the cohesion
of an end without normal force, over friction times the mean weight of a block. Of two walls of
Ferris and Tin-Loi, a tenth of either changes the load by less than 0.04 %."""

SAME_LOAD = 2e-6
"""Relative change of the load from one programme to the next at which the sequence has settled."""

STIRRED = 1e-6
"""Velocity of a joint above which it moves in a mechanism, over the largest: the programme is
solved to 1e-7."""


@dataclasses.dataclass(frozen=True, eq=False)
class Collapse:
    """What the programme says of one assembly and one direction.

    Attributes:
        assembly: The assembly.
        direction: 1.0 where the load acts to +x, -1.0 to -x.
        load_factor: Sideways load over self-weight at which it collapses [-]; NaN where no forces
            balance the self-weight alone, infinite where nothing collapses.
        velocity: Of the blocks in the mechanism, along x and y and counterclockwise; the largest
            velocity of a centre of mass is 1 m/s. Zero where there is no mechanism. Shape
            [block, 3].
    """

    assembly: Assembly
    direction: float
    load_factor: float
    velocity: Array

    @functools.cached_property
    def coulomb_load(self) -> float:
        """Load factor with Coulomb's law [-]: that of a sequence of programmes where joints slide.

        NaN where the sequence does not settle, and of more blocks than `LARGEST_COULOMB`.
        """
        if self.upper_bound and self.assembly.count > LARGEST_COULOMB:
            return np.nan
        if not self.upper_bound or not np.isfinite(self.load_factor):
            return self.load_factor
        return _coulomb_load(self.assembly, self.direction, self.load_factor)

    @property
    def stands(self) -> bool:
        """Whether it carries its own weight."""
        return not np.isnan(self.load_factor)

    @functools.cached_property
    def parting(self) -> Array:
        """Velocity at which the ends of the joints open [m/s], shape [joint, end]."""
        return np.asarray((self._relative * self.assembly.joints.normal[:, None]).sum(axis=2))

    @functools.cached_property
    def slip(self) -> Array:
        """Velocity along the joints [m/s], shape [joint]."""
        return np.asarray((self._relative[:, 0] * self.assembly.joints.tangent).sum(axis=1))

    @property
    def opens(self) -> Flags:
        """Joints that open at an end, or part, without sliding; shape [joint]."""
        return np.asarray((self.parting.max(axis=1, initial=0.0) > self._least) & ~self.slides)

    @property
    def slides(self) -> Flags:
        """Joints that slide under a force, which part no more than friction; shape [joint]."""
        slip = np.abs(self.slip)
        pressed = self.parting.min(axis=1, initial=np.inf) <= (
            self.assembly.joints.friction * slip + self._least
        )
        return np.asarray((slip > self._least) & pressed)

    @property
    def upper_bound(self) -> bool:
        """Whether the load factor is an upper bound alone: a joint slides with friction."""
        return bool((self.slides & (self.assembly.joints.friction > 0.0)).any())

    @functools.cached_property
    def _relative(self) -> Array:
        """Velocity of the first block of a joint against the second, shape [joint, end, 2]."""
        joints, centre = self.assembly.joints, self.assembly.centre
        moved = []
        for side in (0, 1):
            block = joints.blocks[:, side]
            arm = joints.ends - centre[block][:, None]
            turned = np.stack([-arm[..., 1], arm[..., 0]], axis=-1)
            v = self.velocity[block][:, None]
            moved.append(v[..., :2] + v[..., 2:] * turned)
        return np.asarray(moved[0] - moved[1])

    @property
    def _least(self) -> float:
        return STIRRED * float(np.abs(self._relative).max(initial=0.0))


def collapse_load(assembly: Assembly, direction: float = 1.0) -> Collapse:
    """The load factor of an assembly under a sideways self-weight, and its mechanism.

    On a table that tilts it collapses at the angle whose tangent is the load factor: the ratio of
    the forces along and across the table is all that counts.

    Args:
        assembly: The assembly.
        direction: 1.0 for a load to +x, -1.0 to -x.
    """
    programme = _Programme(assembly, direction)
    friction = np.repeat(assembly.joints.friction, 2)
    solved = programme.solve(friction, np.zeros_like(friction))
    free, weight, length = programme.free, programme.weight, programme.length
    velocity = np.zeros((assembly.count, 3))
    if solved.status == 0:
        factor = float(solved.x[-1])
        found = solved.eqlin.marginals.reshape(-1, 3) * [1.0, 1.0, 1.0 / length]
        largest = np.hypot(found[:, 0], found[:, 1]).max()
        sense = direction * np.sign((found[:, 0] * weight).sum()) / (largest or 1.0)
        velocity[free] = found * sense
    else:
        # Self-weight alone is balanced at a factor of 0; without a bound nothing collapses.
        factor = np.inf if solved.status == 3 else np.nan
    return Collapse(assembly, direction, factor, velocity)


class _Programme:
    """The linear programme of an assembly and one direction."""

    def __init__(self, assembly: Assembly, direction: float) -> None:
        """Sets up the balance of its blocks."""
        self.free = np.flatnonzero(~assembly.fixed)
        balance, self.length = _balance(assembly, self.free)
        self.weight = assembly.mass[self.free] / assembly.mass[self.free].mean()
        live, self._dead = np.zeros((len(self.free), 3)), np.zeros((len(self.free), 3))
        live[:, 0], self._dead[:, 1] = direction * self.weight, -self.weight
        self._balance = scipy.sparse.hstack([balance, scipy.sparse.csr_array(live.reshape(-1, 1))])
        self._ends = 2 * assembly.joints.count

    def solve(self, slope: Array, cohesion: Array) -> Any:
        """The greatest load factor with |t| <= cohesion + slope n at every end, shape [end] each.

        Forces are over the mean weight of a block.
        """
        cone = _cone(slope)
        return scipy.optimize.linprog(
            np.r_[np.zeros(2 * self._ends), -1.0],
            A_ub=cone,
            b_ub=np.repeat(cohesion, 2),
            A_eq=self._balance,
            b_eq=-self._dead.ravel(),
            bounds=[*[(0.0, None), (None, None)] * self._ends, (0.0, None)],
            method="highs",
        )


def _coulomb_load(assembly: Assembly, direction: float, most: float) -> float:
    """The load factor with Coulomb's law, at most that of limit analysis; NaN if none is found."""
    programme, friction = _Programme(assembly, direction), np.repeat(assembly.joints.friction, 2)
    solved = programme.solve(friction, np.zeros_like(friction))
    normal, load = solved.x[:-1:2], np.inf
    for _ in range(PROGRAMMES):
        cohesion = friction * ((1.0 + SOFTENING) * normal + LEAST_COHESION)
        solved = programme.solve(-SOFTENING * friction, cohesion)
        if solved.status != 0:
            return np.nan
        before, load = load, float(solved.x[-1])
        if abs(load - before) <= SAME_LOAD * load:
            return min(load, most)
        normal = 0.5 * (normal + solved.x[:-1:2])
    return np.nan


@functools.lru_cache(maxsize=16)
def weaker_collapse(assembly: Assembly) -> Collapse:
    """That of the side to which an assembly is weaker, to the right where both are alike."""
    right, left = (collapse_load(assembly, direction) for direction in (1.0, -1.0))
    return left if left.load_factor < WEAKER * right.load_factor else right


def _cone(ends: Array) -> Any:
    """Of every end of joints t - friction n and -t - friction n; a last column is the load's."""
    count = len(ends)
    row = 2 * np.arange(count)[:, None, None] + np.array([[0], [1]])
    column = 2 * np.arange(count)[:, None, None] + np.array([[0, 1]])
    value = np.empty((count, 2, 2))
    value[:, :, 0], value[:, :, 1] = -ends[:, None], [1.0, -1.0]
    where = [each.ravel() for each in np.broadcast_arrays(row, column)]
    return scipy.sparse.csr_array(
        (value.ravel(), (where[0], where[1])), shape=(2 * count, 2 * count + 1)
    )


def _balance(assembly: Assembly, free: npt.NDArray[np.intp]) -> tuple[Any, float]:
    """Forces and moments on the free blocks by unit forces at the ends of joints.

    Returns:
        A matrix, rows by block along x, along y and about its centre, columns by joint, end, and
        normal or tangential; and the length over which moments are divided [m].
    """
    joints, count = assembly.joints, len(free)
    length = float(np.sqrt(assembly.area[free].mean()))
    place = np.full(assembly.count, -1)
    place[free] = np.arange(count)
    force = np.stack([joints.normal, joints.tangent], axis=1)
    rows, columns, values = [], [], []
    for side, sign in ((0, 1.0), (1, -1.0)):
        block = joints.blocks[:, side]
        arm = joints.ends - assembly.centre[block][:, None]
        moment = (
            arm[:, :, None, 0] * force[:, None, :, 1] - arm[:, :, None, 1] * force[:, None, :, 0]
        )
        both = np.broadcast_to(force[:, None], (joints.count, 2, 2, 2))
        value = sign * np.concatenate([both, moment[..., None] / length], axis=-1)
        row = 3 * place[block][:, None, None, None] + np.arange(3)
        column = np.arange(4 * joints.count).reshape(-1, 2, 2, 1)
        row, column, value = np.broadcast_arrays(row, column, value)
        kept = np.broadcast_to((place[block] >= 0)[:, None, None, None], row.shape)
        rows.append(row[kept])
        columns.append(column[kept])
        values.append(value[kept])
    where = np.concatenate(rows), np.concatenate(columns)
    shape = (3 * count, 4 * joints.count)
    return scipy.sparse.csr_array((np.concatenate(values), where), shape=shape), length


@dataclasses.dataclass(frozen=True, eq=False)
class LoadLimits:
    """At which sideways load every lane of a case collapses.

    Attributes:
        case: The case.
        lane_set: Its lanes.
        collapses: One of each of the assemblies that differ, in the direction in which it is
            weaker.
        wall_time: [s].
    """

    case: Case
    lane_set: LaneSet
    collapses: tuple[Collapse, ...]
    wall_time: float

    @property
    def lane(self) -> npt.NDArray[np.intp]:
        """The place of every lane's among the collapses, shape [lane]."""
        assemblies = self.lane_set.lanes.assembly
        assert assemblies is not None
        return assemblies.lane

    @functools.cached_property
    def with_coulomb(self) -> frozenset[int]:
        """Collapses whose load with Coulomb's law is looked for: the weakest ones first."""
        loads = np.array([each.load_factor for each in self.collapses])
        order = np.argsort(np.where(np.isfinite(loads), loads, np.inf), kind="stable")
        return frozenset(order[:MOST_COULOMB].tolist())


def run_limits(case: Case, progress: Progress | None = None) -> LoadLimits:
    """Limit analysis of every lane of a case, to both sides.

    Args:
        case: A case with an [assembly].
        progress: Called with the number of lanes that are done.

    Raises:
        InputError: The case has no assembly, more that differ than `MOST_KINDS`, or one of more
            than `MOST_JUDGED` blocks.
    """
    if case.tables.assembly is None:
        allowed = "must be given: limit analysis is of many blocks with joints"
        raise InputError(case.file, "assembly", NOTHING, allowed)
    begin = time.perf_counter()
    lane_set = expand_lanes(case)
    assemblies = lane_set.lanes.assembly
    assert assemblies is not None
    if assemblies.bonded:
        key, allowed = "assembly.joint_tensile_strength", "must be left out: joints are dry here"
        raise InputError(case.source_of(key), key, Said("a value"), allowed)
    if len(assemblies.kinds) > MOST_KINDS:
        got = Said(f"{len(assemblies.kinds):,} assemblies that differ")
        raise InputError(case.file, "sweep", got, f"must be at most {MOST_KINDS:,}")
    blocks = max(kind.count for kind in assemblies.kinds)
    if blocks > MOST_JUDGED:
        allowed = f"must be at most {MOST_JUDGED} for limit analysis; `run` takes more"
        raise InputError(case.file, "assembly", Said(f"{blocks:,} blocks"), allowed)
    lanes, found = np.bincount(assemblies.lane), []
    for place, kind in enumerate(assemblies.kinds):
        found.append(weaker_collapse(kind))
        if progress is not None:
            progress(int(lanes[: place + 1].sum()))
    return LoadLimits(case, lane_set, tuple(found), time.perf_counter() - begin)


MOST_BLOCKS = 100
"""Blocks up to which limit analysis, which takes a second for so many of a wall, is done beside a
run."""


def collapse_beside(run: CaseRun) -> tuple[int, Collapse] | None:
    """Limit analysis of the first lane of a run that collapsed; None of too many or bonded blocks.

    To the side to which its table tilts; of other motions to the weaker one.

    Returns:
        The place of the lane in the run, and what limit analysis says.
    """
    own, fell = run.lane_set.lanes.assembly, run.response.fields.get("collapse_time")
    if own is None or own.bonded or fell is None or np.isnan(fell).all():
        return None
    lane = int(np.nanargmin(fell))
    kind = own.of(lane)
    if kind.count > MOST_BLOCKS:
        return None
    if TILT in run.lane_set.inputs:
        rate = float(run.lane_set.inputs[TILT].iloc[lane])
        return lane, collapse_load(kind, float(np.sign(rate)))
    return lane, weaker_collapse(kind)


TILT = "tilt_rate_deg_s"
"""Column of the rate of a tilting table."""
