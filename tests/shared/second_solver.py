"""A second solver of assemblies, from the law alone: an augmented Lagrangian in NumPy.

It shares the polygons and the joints of `warprock.model.assembly` with the engine, and no formula:
corners lie on edges here by projection, and all contacts of a step are solved at once.

The law of a step of length h (Moreau 1988), with M the mass matrix, w the velocities before it and
what gravity and the base add, G the rows of u_n and u_t at the contacts, g their gaps:

    M (v - w) = G_n' N + G_t' T
    0 <= N  perpendicular to  G_n v + max(g, 0) / h >= 0
    T in [-mu N, mu N],  G_t v = 0 within it, against T on its bounds

With the bounds of T held, v is the least of a convex function. Its augmented Lagrangian (Alart and
Curnier 1991, A mixed formulation for frictional contact problems prone to Newton like solution
methods, *Computer Methods in Applied Mechanics and Engineering* 92) is smooth but for kinks, and
Newton's method with a line search finds its least. Then N, T and the bounds of T are those of this
v, until the law holds to `EXACT`.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from warprock.model.assembly import Assembly
from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]

EXACT = 1e-8
"""Velocity by which contacts may break the law [m/s], unless no more is to be had: impulses of
joints that hold one another may grow for ever, and change nothing else."""
STIFF = 1e3
"""Penalty of the augmented Lagrangian, over the mass that a contact feels."""
OUTER, NEWTON = 30, 60
"""Most multipliers of a step, and most steps of Newton's method for each."""
GROUND = 1e3
"""Length by which fixed edges go on, over the size of the assembly."""


@dataclasses.dataclass
class Rows:
    """The contacts of a step: G, shape [contact, dof] each, gaps [m], inf where none is."""

    normal: Array
    tangent: Array
    gap: Array


@dataclasses.dataclass
class SecondSolver:
    """An assembly that moves.

    Attributes:
        kind: The assembly.
        step: Length of a step [s].
        base: Velocity of the base to +x at a time [m/s].

    `left` is the most by which impulses of a step broke the law [m/s].
    """

    kind: Assembly
    step: float
    base: Callable[[float], float]

    def __post_init__(self) -> None:
        kind, count = self.kind, self.kind.count
        self.free = np.repeat(~kind.fixed, 3)
        self.masses = np.stack([kind.mass, kind.mass, kind.mass * kind.gyration], axis=1).ravel()
        self.place = np.column_stack([kind.centre, np.zeros(count)])
        self.speed = np.zeros(3 * count)
        self.friction = np.repeat(kind.joints.friction, 2)
        self.normal_impulse, self.shear_impulse = np.zeros((2, 2 * kind.joints.count))
        self.edges = [self._edges(side) for side in (0, 1)]
        self.moved_base, self.left, self.steps = 0.0, 0.0, 0

    def _edges(self, side: int) -> Array:
        """The edge of a block of every joint, from its centre, shape [joint, end, 2]."""
        kind, found = self.kind, []
        size = float(np.ptp(kind.corners.reshape(-1, 2), axis=0).max())
        for pair, ends in zip(kind.joints.blocks, kind.joints.ends, strict=True):
            along = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
            corners = kind.corners[pair[side]] - ends[0]
            off = np.abs(along[0] * corners[:, 1] - along[1] * corners[:, 0])
            on = corners[off < 1e-6 * size] @ along
            more = GROUND * size if kind.fixed[pair[side]] else 0.0
            reach = np.array([on.min() - more, on.max() + more])
            found.append(ends[0] + reach[:, None] * along - kind.centre[pair[side]])
        return np.array(found)

    def contacts(self) -> Rows:
        """Where blocks touch now: at either end of a joint the corner that is further inside."""
        pairs = self.kind.joints.blocks
        moved = []
        for side in (0, 1):
            at = self.place[pairs[:, side]]
            c, s = np.cos(at[:, 2]), np.sin(at[:, 2])
            turn = np.array([[c, -s], [s, c]])
            moved.append(np.einsum("abj,jeb->jea", turn, self.edges[side]) + at[:, None, :2])
        count = len(pairs)
        dofs = 3 * self.kind.count
        normal, tangent = np.zeros((2, 2 * count, dofs))
        gap = np.full(2 * count, np.inf)
        for joint, end in np.ndindex(count, 2):
            own, other = moved[0][joint], moved[1][joint]
            line = other[1] - other[0]
            line = line / np.linalg.norm(line)
            ahead = (own[end] - other[end]) @ line * (1 - 2 * end)
            # The corner of the first block lies on the second one's edge, or the other way round.
            corner, edge = (own[end], other) if ahead >= 0.0 else (other[end], own)
            along = edge[1] - edge[0]
            length = float(np.linalg.norm(along))
            along = along / length
            where = (corner - edge[0]) @ along
            if (where >= length) if end == 0 else (where <= 0.0):
                continue
            n = np.array([-along[1], along[0]])
            side = 1.0 if ahead >= 0.0 else -1.0
            row = 2 * joint + end
            gap[row] = side * (corner - edge[0]) @ n
            for block, sign in zip(pairs[joint], (1.0, -1.0), strict=True):
                arm = corner - self.place[block, :2]
                for rows, d in ((normal, n), (tangent, np.array([-n[1], n[0]]))):
                    moment = arm[0] * d[1] - arm[1] * d[0]
                    rows[row, 3 * block : 3 * block + 3] = sign * np.array([*d, moment])
        return Rows(normal, tangent, gap)

    def advance(self) -> None:
        """One step."""
        moves = self.base((self.steps + 0.5) * self.step)
        push = np.tile([self.moved_base - moves, -self.step * GRAVITY, 0.0], self.kind.count)
        self.moved_base = moves
        rows = self.contacts()
        free = self.free
        there = np.isfinite(rows.gap)
        gn, gt = rows.normal[there][:, free], rows.tangent[there][:, free]
        toward = np.maximum(rows.gap[there], 0.0) / self.step
        mass = self.masses[free]
        start = self.speed[free] + push[free]
        own = _Step(gn, gt, toward, self.friction[there], mass, start)
        v, n, t, left = own.solve(self.normal_impulse[there], self.shear_impulse[there])
        self.normal_impulse[:] = self.shear_impulse[:] = 0.0
        self.normal_impulse[there], self.shear_impulse[there] = n, t
        self.speed = np.zeros_like(self.speed)
        self.speed[free] = v
        self.place = self.place + self.step * self.speed.reshape(-1, 3)
        self.left = max(self.left, left)
        self.steps += 1


@dataclasses.dataclass
class _Step:
    """The problem of a step; symbols as at the head of the file."""

    gn: Array
    gt: Array
    toward: Array
    friction: Array
    mass: Array
    start: Array

    def solve(self, n: Array, t: Array) -> tuple[Array, Array, Array, float]:
        """Velocities and impulses that obey the law, from impulses of the last step."""
        # What a contact feels: one over what an impulse of its own does to its velocity.
        self.rn = STIFF / (self.gn**2 / self.mass).sum(axis=1)
        self.rt = STIFF / (self.gt**2 / self.mass).sum(axis=1)
        v = self.start + (self.gn.T @ n + self.gt.T @ t) / self.mass
        best, left = (v, n, t), np.inf
        for _ in range(OUTER):
            v, n, t = self._least(v, n, t)
            broken = self.broken_by(v, n, t)
            if broken < left:
                best, left = (v, n, t), broken
            if left < EXACT:
                break
        return *best, left

    def broken_by(self, v: Array, n: Array, t: Array) -> float:
        """By how much impulses break the law that their velocities ask for [m/s]."""
        rn, rt = self.rn / STIFF, self.rt / STIFF
        v = self.start + (self.gn.T @ n + self.gt.T @ t) / self.mass
        wanted = np.maximum(n - rn * (self.gn @ v + self.toward), 0.0)
        dragged = np.clip(t - rt * (self.gt @ v), -self.friction * n, self.friction * n)
        return float(max(np.abs((wanted - n) / rn).max(), np.abs((dragged - t) / rt).max()))

    def _least(self, v: Array, n0: Array, t0: Array) -> tuple[Array, Array, Array]:
        bound = self.friction * n0

        def impulses(v: Array) -> tuple[Array, Array]:
            n = np.maximum(n0 - self.rn * (self.gn @ v + self.toward), 0.0)
            return n, np.clip(t0 - self.rt * (self.gt @ v), -bound, bound)

        def slope(v: Array) -> Array:
            n, t = impulses(v)
            return self.mass * (v - self.start) - self.gn.T @ n - self.gt.T @ t

        for _ in range(NEWTON):
            lack = slope(v)
            if np.abs(lack / self.mass).max() < 0.1 * EXACT / STIFF:
                break
            n, t = impulses(v)
            acts, sticks = n > 0.0, np.abs(t) < bound
            held = (self.gn[acts].T * self.rn[acts]) @ self.gn[acts]
            held += (self.gt[sticks].T * self.rt[sticks]) @ self.gt[sticks]
            way = -np.linalg.solve(np.diag(self.mass) + held, lack)
            v = v + _along(lambda a, v=v, way=way: float(slope(v + a * way) @ way)) * way
        return v, *impulses(v)


def _along(slope: Callable[[float], float]) -> float:
    """Where a convex function is least between 0 and 1, by its slope there."""
    if slope(1.0) <= 0.0:
        return 1.0
    low, high = 0.0, 1.0
    at_low, at_high = slope(0.0), slope(1.0)
    for _ in range(8):
        at = low + min(max(-at_low / (at_high - at_low), 0.1), 0.9) * (high - low)
        found = slope(at)
        if abs(found) < 0.1 * abs(slope(0.0)):
            return at
        if found > 0.0:
            high, at_high = at, found
        else:
            low, at_low = at, found
    return low if low > 0.0 else high
