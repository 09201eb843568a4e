"""Limit analysis: the sideways load at which an assembly collapses, by linear programme.

By the static theorem a load is carried if joints can transmit forces that balance it, compressive
and within Coulomb's cone. Of a joint between two blocks these are the forces at its ends, in space
at the corners of its polygon. The largest factor on a sideways self-weight beside the self-weight
itself,

    maximise  f   with   B r + f live + dead = 0,   n >= 0,   |t| <= friction n  at every end,

is a linear programme in the plane; its dual variables are the velocities of the blocks in the
mechanism that forms (Livesley 1978, Limit analysis of structures formed from rigid blocks,
*International Journal for Numerical Methods in Engineering* 12). In space the cone is round. A
regular pyramid around it gives a load that is not below the one of the cone, a pyramid in it one
that is not above (Livesley 1992, A computational model for the limit analysis of three-dimensional
masonry structures, *Meccanica* 27). Where joints slide in it the programme lets them open as they
slide, which Coulomb's law does not: the factor is an upper bound then (Drucker 1954, Coulomb
friction, plasticity, and limit loads, *Journal of Applied Mechanics* 21).

There a sequence of programmes finds a load with Coulomb's law: each end has the strength friction n
of its normal force n in the programme before, as a cohesion that hardly depends on its own n, so
that it slides without opening (Gilbert, Casapulla and Ahmed 2006, Limit analysis of masonry block
structures with non-associative frictional joints using linear programming, *Computers and
Structures* 84). Forces, load and mechanism obey Coulomb's law once the sequence settles; there may
be more than one such load.

In space the loads of all directions that an assembly carries are a convex set: those of a few
directions span a polygon in it, and each mechanism is a line that it lies behind. The weakest load
found is the one across such a line; none lies below the polygon, so none is weaker by `WEAKEST`.
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
from warprock.errors import NOTHING, InputError, Said
from warprock.model.assembly import SPACE, Assembly
from warprock.running.case_run import CaseRun
from warprock.running.options import Progress

Array = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]

MOST_JUDGED = (500, 250)
"""Blocks of an assembly in the plane and in space. In the plane the programme takes some 15 s for
400 of a wall, and twice as many take six times as long; in space 1 s for 60 and 15 s for 250."""

MOST_KINDS = 10_000
"""Assemblies that differ in a case: of 30 blocks each takes 0.1 s."""

WEAKER = 1.0 - 1e-6
"""A load factor over another one below which it is the weaker one; both are solved to 1e-7."""

CONE_SIDES = 16
"""Sides of the pyramids that stand for a cone of friction in space: the one in it has 0.981 of the
friction of the one around it. A multiple of four, so that mirrored scenes have the same load."""

WEAKEST, MOST_DIRECTIONS = 1e-2, 24
"""How far the weakest load in space may lie below the least of the directions that are judged, over
it; and the most of these."""

STEEPEST = 1.0 - 1e-5
"""Load across the line of a mechanism, over that in the direction judged, from which on the two
directions count as one."""

MOST_COULOMB, LARGEST_COULOMB = (20, 4), (60, 40)
"""Assemblies that differ whose load with Coulomb's law is looked for, and blocks of one, in the
plane and in space: it takes some 20 times as long as the bound, of a wall of 46 blocks 1.4 s, in
space of one of 33 blocks 5 s."""

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
        direction: To which the load acts [rad], from +x; in space about the vertical towards +y.
        load_factor: Sideways load over self-weight at which it collapses [-]; NaN where no forces
            balance the self-weight alone, infinite where nothing collapses. In space by pyramids
            around the cones of friction.
        velocity: Of the blocks in the mechanism, along x and y and counterclockwise, in space along
            x, y and z and about them; the largest velocity of a centre of mass is 1 m/s. Zero where
            there is no mechanism. Shape [block, 3], in space [block, 6].
    """

    assembly: Assembly
    direction: float
    load_factor: float
    velocity: Array

    @functools.cached_property
    def inner_load_factor(self) -> float:
        """The load factor by pyramids in the cones of friction [-]; in the plane no other."""
        if not self.assembly.spatial or not np.isfinite(self.load_factor):
            return self.load_factor
        programme = _Programme(self.assembly, self.direction)
        solved = programme.solve(programme.friction, np.zeros(programme.ends))
        # Both are solved to 1e-7, and friction that plays no part leaves them alike.
        return min(float(solved.x[-1]), self.load_factor) if solved.status == 0 else np.nan

    @functools.cached_property
    def coulomb_load(self) -> float:
        """Load factor with Coulomb's law [-]: that of a sequence of programmes where joints slide.

        NaN where the sequence does not settle, and of more blocks than `LARGEST_COULOMB`. In space
        by pyramids in the cones of friction.
        """
        if self.upper_bound and self.assembly.count > LARGEST_COULOMB[self.assembly.spatial]:
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
        """Velocity along the joints at their ends [m/s], shape [joint, end]."""
        along = np.einsum("jti,jei->jet", self.assembly.joints.tangents, self._relative)
        return np.asarray(np.linalg.norm(along, axis=2))

    @property
    def opens(self) -> Flags:
        """Joints that open at an end, or part, without sliding; shape [joint]."""
        return np.asarray((self.parting.max(axis=1, initial=0.0) > self._least) & ~self.slides)

    @property
    def slides(self) -> Flags:
        """Joints that slide under a force, which part no more than friction; shape [joint]."""
        friction = self.assembly.joints.friction / _within(self.assembly)
        pressed = self.parting <= friction[:, None] * self.slip + self._least
        return np.asarray(((self.slip > self._least) & pressed).any(axis=1))

    @property
    def upper_bound(self) -> bool:
        """Whether the load factor is an upper bound alone: a joint slides with friction."""
        return bool((self.slides & (self.assembly.joints.friction > 0.0)).any())

    @functools.cached_property
    def steepest(self) -> tuple[float, float]:
        """The direction in which this mechanism works most [rad], and the load that it bears there.

        The assembly bears no more than that load in that direction.
        """
        along, across = self.assembly.mass @ self.velocity[:, :2]
        direction = float(np.arctan2(across, along) % (2.0 * np.pi))
        return direction, self.load_factor * float(np.cos(direction - self.direction))

    @functools.cached_property
    def _relative(self) -> Array:
        """Velocity of the first block of a joint against the second, shape [joint, end, axis]."""
        joints, (first, second) = self.assembly.joints, self.assembly.joints.blocks.T
        return self.moved(first, joints.ends) - self.moved(second, joints.ends)

    def moved(self, blocks: npt.NDArray[np.intp], points: Array) -> Array:
        """Velocities of points of some blocks in the mechanism [m/s].

        Args:
            blocks: Numbers of the blocks, shape [n].
            points: Points of each [m], shape [n, point, axis].
        """
        axes = points.shape[-1]
        arm = points - self.assembly.centre[blocks][:, None]
        v = self.velocity[blocks][:, None]
        if axes == SPACE:
            return np.asarray(v[..., :axes] + np.cross(v[..., axes:], arm))
        return np.asarray(v[..., :2] + v[..., 2:] * np.stack([-arm[..., 1], arm[..., 0]], axis=-1))

    @property
    def _least(self) -> float:
        return STIRRED * float(np.abs(self._relative).max(initial=0.0))


def collapse_load(assembly: Assembly, direction: float = 0.0) -> Collapse:
    """The load factor of an assembly under a sideways self-weight, and its mechanism.

    On a table that tilts it collapses at the angle whose tangent is the load factor: the ratio of
    the forces along and across the table is all that counts.

    Args:
        assembly: The assembly.
        direction: To which the load acts [rad], from +x; in the plane 0 or pi.
    """
    programme = _Programme(assembly, direction)
    solved = programme.solve(programme.friction / _within(assembly), np.zeros(programme.ends))
    velocity = np.zeros((assembly.count, programme.motions))
    if solved.status == 0:
        factor = float(solved.x[-1])
        velocity[programme.free] = programme.velocity(solved)
    else:
        # Self-weight alone is balanced at a factor of 0; without a bound nothing collapses.
        factor = np.inf if solved.status == 3 else np.nan
    return Collapse(assembly, direction, factor, velocity)


def _within(assembly: Assembly) -> float:
    """How far a pyramid in a cone of friction lies within it, over its radius; 1 in the plane."""
    return float(np.cos(np.pi / CONE_SIDES)) if assembly.spatial else 1.0


class _Programme:
    """The linear programme of an assembly and one direction.

    Its variables are the normal forces at all ends; the shares of their tangential forces along the
    edges of a pyramid, one edge after another; and the load factor.
    """

    def __init__(self, assembly: Assembly, direction: float) -> None:
        """Sets up the balance of its blocks."""
        joints = assembly.joints
        self._joint, place = np.nonzero(np.arange(joints.ends.shape[1]) < joints.end_count[:, None])
        self.ends, self.friction = len(self._joint), joints.friction[self._joint]
        self.free = np.flatnonzero(~assembly.fixed)
        self.axes = assembly.centre.shape[1]
        self.motions = 3 * (self.axes - 1)
        self._length = float(np.sqrt(assembly.area[self.free].mean()))
        self.weight = assembly.mass[self.free] / assembly.mass[self.free].mean()
        live, self._dead = np.zeros((2, len(self.free), self.motions))
        self._toward = np.array([np.cos(direction), np.sin(direction)])[: self.axes - 1]
        live[:, : self.axes - 1] = self.weight[:, None] * self._toward
        self._dead[:, self.axes - 1] = -self.weight
        points = joints.ends[self._joint, place]
        tangents = joints.tangents[self._joint]
        edges = np.einsum("ka,eai->kei", _edges(self.axes - 1), tangents)
        self._edges = len(edges)
        forces = np.concatenate([joints.normal[self._joint][None], edges])
        balance = self._balance(assembly, points, forces)
        self._matrix = scipy.sparse.hstack([balance, scipy.sparse.csr_array(live.reshape(-1, 1))])

    def solve(self, slope: Array, cohesion: Array) -> Any:
        """The greatest load factor with |t| <= cohesion + slope n at every end, shape [end] each.

        Forces are over the mean weight of a block.
        """
        one = scipy.sparse.eye_array(self.ends)
        none = scipy.sparse.csr_array((self.ends, 1))
        cone = [scipy.sparse.diags_array(-slope), *[one] * self._edges, none]
        programme: Any = scipy.optimize.linprog
        return programme(
            np.r_[np.zeros((1 + self._edges) * self.ends), -1.0],
            A_ub=scipy.sparse.hstack(cone),
            b_ub=cohesion,
            A_eq=self._matrix,
            b_eq=-self._dead.ravel(),
            bounds=(0.0, None),
            # In space the interior-point method takes a quarter of the simplex's time.
            method="highs-ipm" if self.axes == SPACE else "highs",
        )

    def normal(self, solved: Any) -> Array:
        """Normal forces at the ends over the mean weight of a block, shape [end]."""
        return np.asarray(solved.x[: self.ends])

    def velocity(self, solved: Any) -> Array:
        """Velocities of the free blocks in the mechanism; see `Collapse`."""
        found = solved.eqlin.marginals.reshape(-1, self.motions).copy()
        found[:, self.axes :] /= self._length
        largest = np.linalg.norm(found[:, : self.axes], axis=1).max()
        work = (found[:, : self.axes - 1] @ self._toward * self.weight).sum()
        return np.asarray(found * (np.sign(work) / (largest or 1.0)))

    def _balance(self, assembly: Assembly, points: Array, forces: Array) -> Any:
        """Forces and moments on the free blocks by unit forces at the ends of joints.

        Args:
            assembly: The assembly.
            points: Where they act [m], shape [end, axis].
            forces: Their directions, shape [sort, end, axis].

        Returns:
            A matrix, rows by block along the axes and about its centre, moments over `_length`;
            columns by sort of force and end.
        """
        place = np.full(assembly.count, -1)
        place[self.free] = np.arange(len(self.free))
        rows, columns, values = [], [], []
        for side, sign in ((0, 1.0), (1, -1.0)):
            block = assembly.joints.blocks[self._joint, side]
            moment = _moment(points - assembly.centre[block], forces) / self._length
            value = sign * np.concatenate([forces, moment], axis=-1)
            row = self.motions * place[block][:, None] + np.arange(self.motions)
            column = np.arange(forces.shape[0] * self.ends).reshape(-1, self.ends, 1)
            row, column, value = np.broadcast_arrays(row, column, value)
            kept = np.broadcast_to((place[block] >= 0)[:, None], row.shape) & (value != 0.0)
            rows.append(row[kept])
            columns.append(column[kept])
            values.append(value[kept])
        where = np.concatenate(rows), np.concatenate(columns)
        shape = (self.motions * len(self.free), forces.shape[0] * self.ends)
        return scipy.sparse.csr_array((np.concatenate(values), where), shape=shape)


def _edges(axes: int) -> Array:
    """Edges of the pyramid of friction by their parts along the tangents, shape [edge, tangent]."""
    if axes == 1:
        return np.array([[1.0], [-1.0]])
    angle = 2.0 * np.pi * np.arange(CONE_SIDES) / CONE_SIDES
    return np.stack([np.cos(angle), np.sin(angle)], axis=1)


def _moment(arm: Array, force: Array) -> Array:
    """Moments of forces about points, one in the plane and three in space on the last axis."""
    if arm.shape[-1] == SPACE:
        return np.cross(arm, force)
    return np.asarray(arm[..., :1] * force[..., 1:] - arm[..., 1:] * force[..., :1])


def _coulomb_load(assembly: Assembly, direction: float, most: float) -> float:
    """The load factor with Coulomb's law, at most that of limit analysis; NaN if none is found."""
    programme = _Programme(assembly, direction)
    friction = programme.friction
    solved = programme.solve(friction, np.zeros_like(friction))
    if solved.status != 0:
        return np.nan
    normal, load = programme.normal(solved), np.inf
    for _ in range(PROGRAMMES):
        cohesion = friction * ((1.0 + SOFTENING) * normal + LEAST_COHESION)
        solved = programme.solve(-SOFTENING * friction, cohesion)
        if solved.status != 0:
            return np.nan
        before, load = load, float(solved.x[-1])
        if abs(load - before) <= SAME_LOAD * load:
            return min(load, most)
        normal = 0.5 * (normal + programme.normal(solved))
    return np.nan


@functools.lru_cache(maxsize=16)
def weaker_collapse(assembly: Assembly) -> Collapse:
    """That of the direction in which an assembly is weakest, of several alike the first one.

    In the plane of the two sides. In space first down from mechanism to mechanism, in the direction
    in which each works most; then, where the polygon leaves room for less than `WEAKEST` allows.
    """
    if not assembly.spatial:
        return _weaker([collapse_load(assembly, direction) for direction in (0.0, np.pi)])
    found = [collapse_load(assembly, 0.5 * np.pi * quarter) for quarter in range(4)]
    while len(found) < MOST_DIRECTIONS:
        loads = np.array([each.load_factor for each in found])
        if not (np.isfinite(loads) & (loads > 0.0)).all():
            break
        weakest = _weaker(found)
        direction, load = weakest.steepest
        if load >= STEEPEST * weakest.load_factor:
            nearest, direction = _nearest(np.array([each.direction for each in found]), loads)
            if nearest >= (1.0 - WEAKEST) * loads.min():
                break
        found.append(collapse_load(assembly, direction))
    return _weaker(found)


def _weaker(found: list[Collapse]) -> Collapse:
    """The first one of those whose load factor is the least."""
    loads = np.array([each.load_factor for each in found])
    if np.isnan(loads).any():
        return found[int(np.argmax(np.isnan(loads)))]
    return found[int(np.argmax(WEAKER * loads <= loads.min()))]


def _nearest(direction: Array, load: Array) -> tuple[float, float]:
    """The point of the polygon that loads of several directions span that is nearest to no load.

    Returns:
        Its distance, at most the weakest load, and its direction [rad].
    """
    order = np.argsort(direction)
    here = (load * np.exp(1j * direction))[order]
    along = np.roll(here, -1) - here
    part = np.clip(-(here * np.conj(along)).real / np.abs(along) ** 2, 0.0, 1.0)
    point = here + part * along
    place = int(np.argmin(np.abs(point)))
    return float(np.abs(point[place])), float(np.angle(point[place]) % (2.0 * np.pi))


@dataclasses.dataclass(frozen=True, eq=False)
class LoadLimits:
    """At which sideways load every lane of a case collapses.

    Attributes:
        case: The case.
        lane_set: Its lanes.
        collapses: One of each of the assemblies that differ, in the direction in which it is
            weaker.
        wall_time: [s].
        asked: The direction of the load [rad]; None where it is the weakest one.
    """

    case: Case
    lane_set: LaneSet
    collapses: tuple[Collapse, ...]
    wall_time: float
    asked: float | None = None

    @property
    def spatial(self) -> bool:
        """Whether the assemblies lie in space."""
        return self.collapses[0].assembly.spatial

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
        return frozenset(order[: MOST_COULOMB[self.spatial]].tolist())


def run_limits(
    case: Case, progress: Progress | None = None, direction: float | None = None
) -> LoadLimits:
    """Limit analysis of every lane of a case, to both sides; in space in all directions.

    Args:
        case: A case with an [assembly].
        progress: Called with the number of lanes that are done.
        direction: The only direction in which the load acts [rad]; None takes the weakest one.

    Raises:
        InputError: The case has no assembly, more that differ than `MOST_KINDS`, or one of more
            than `MOST_JUDGED` blocks; or the direction lies out of its plane.
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
    if direction is not None and not assemblies.spatial and direction not in (0.0, np.pi):
        allowed = "must be 0 deg or 180 deg: the assembly lies in the plane"
        raise InputError("--direction", "", f"{np.rad2deg(direction):g} deg", allowed)
    blocks, most = max(kind.count for kind in assemblies.kinds), MOST_JUDGED[assemblies.spatial]
    if blocks > most:
        allowed = f"must be at most {most} for limit analysis; `run` takes more"
        raise InputError(case.file, "assembly", Said(f"{blocks:,} blocks"), allowed)
    lanes, found = np.bincount(assemblies.lane), []
    for place, kind in enumerate(assemblies.kinds):
        if direction is None:
            found.append(weaker_collapse(kind))
        else:
            found.append(collapse_load(kind, direction))
        if progress is not None:
            progress(int(lanes[: place + 1].sum()))
    return LoadLimits(case, lane_set, tuple(found), time.perf_counter() - begin, direction)


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
    inputs = run.lane_set.inputs
    if TILT in inputs:
        back = np.pi * (float(inputs[TILT].iloc[lane]) < 0.0)
        turn = np.deg2rad(float(inputs[DIRECTION].iloc[lane])) if DIRECTION in inputs else 0.0
        return lane, collapse_load(kind, (turn + back) % (2.0 * np.pi))
    return lane, weaker_collapse(kind)


TILT, DIRECTION = "tilt_rate_deg_s", "direction_deg"
"""Columns of the rate of a tilting table and of the direction to which it sinks in space."""
