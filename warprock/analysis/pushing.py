"""Collapse loads by simulation: assemblies under a slow push, whose load is found by halving.

A push is a sideways load that rises evenly and stays. An assembly has collapsed under it if a block
has fallen or slid off, or if blocks still move at the end and one has come further than `FAR`.
Rigid blocks do not move below the load at which they collapse; above it by a part e of g they leave
as e cosh(p t) / 2 or faster, so that a hold of `HOLD` / p shows an e of 1e-3, where p is the
frequency parameter of a block as large as the assembly (Housner 1963).
"""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from warprock.analysis.load_limit import LoadLimits
from warprock.model.loads import LoadMotions, push_motions
from warprock.model.motion import GroundMotions, SpatialMotions, no_motion
from warprock.model.response import FALLEN, USABLE, Outcome, SampleTimes
from warprock.running.batch import run_batch
from warprock.running.case_run import require_options, require_support
from warprock.running.options import RunOptions
from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]
Places = npt.NDArray[np.intp]

RISE, HOLD = 4.0, 8.0
"""Time in which the load rises, and for which it stays, times the frequency parameter."""

FAR = 0.01
"""Displacement of a block that still moves, over the median length of the joints, from which its
assembly collapses: some thirty times what standing ones creep."""

ABOVE = 1.2
"""The largest load that is tried, over the upper bound of limit analysis."""

ACCURACY = 1e-3
"""Width of the last bracket over its load."""

SIDE_BY_SIDE = 16
"""Loads that are tried at once: a pack of lanes takes hardly longer than one of them."""


class Tried(NamedTuple):
    """Loads that were tried, shape [try] each.

    Attributes:
        kind: The place of the assembly among those of the case.
        factor: The load factor [-].
        moved: The largest displacement of a block [m].
        fell: Whether the assembly collapsed.
    """

    kind: Places
    factor: Array
    moved: Array
    fell: Flags


@dataclasses.dataclass(frozen=True, eq=False)
class Pushes:
    """What slow pushes came to.

    Attributes:
        engine: Name of the engine.
        low, high: Load factors between which each assembly collapses [-]; NaN of those that were
            not pushed or not found, infinite above where the largest load tried is borne. Shape
            [kind].
        unsound: Whether a lane below the collapse had no usable number, shape [kind].
        rise, hold: Time in which the load rises, and for which it stays [s].
        tried: All loads that were tried.
    """

    engine: str
    low: Array
    high: Array
    unsound: Flags
    rise: float
    hold: float
    tried: Tried

    @functools.cached_property
    def factor(self) -> Array:
        """The load factor at which each assembly collapses [-], the middle of its bracket."""
        return np.where(np.isfinite(self.high), 0.5 * (self.low + self.high), np.nan)


def run_pushes(found: LoadLimits, engine: str, options: RunOptions) -> Pushes:
    """Pushes every assembly of a case that stands, to the side to which limit analysis is weaker.

    Args:
        found: What limit analysis says of the case.
        engine: Name of the engine.
        options: How lanes are run, each once whatever the tolerance.

    Raises:
        InputError: An option that cannot be used, or the engine does not run the case.
    """
    once = dataclasses.replace(options, tolerance=None)
    require_options(engine, once)
    require_support(found.case, found.lane_set, engine)
    settings = found.case.engine_settings(engine)
    loads = np.array([each.load_factor for each in found.collapses])
    toward = np.array([each.direction for each in found.collapses])
    far = np.array([FAR * np.median(each.assembly.joints.lengths) for each in found.collapses])
    first = np.unique(found.lane, return_index=True)[1]
    own = found.lane_set.lanes.take(first)
    pushed = np.flatnonzero(np.isfinite(loads) & (loads > 0.0))
    slowest = float(own.frequency_parameter[pushed].min(initial=np.inf))
    rise, hold = RISE / slowest, HOLD / slowest

    def run(kinds: Places, factors: Array, done: int) -> tuple[Array, Flags, Flags]:
        """Displacements, whether assemblies collapsed, and whether these are usable, [try]."""
        nothing, one = np.zeros(len(kinds)), np.ones(len(kinds))
        response = run_batch(
            engine,
            own.take(kinds),
            _pushes(
                push_motions(GRAVITY * factors, rise * one, nothing, (rise + hold) * one),
                toward[kinds],
                spatial=found.spatial,
            ),
            SampleTimes(rise + hold),
            settings=settings,
            **once.counting_from(done).of_batch,
        )
        outcome, moved = response["outcome"], np.asarray(response["peak_displacement"])
        leaves = (outcome == Outcome.ROCKING) & (moved > far[kinds])
        fell = np.isin(outcome, FALLEN) | leaves
        return moved, fell, np.isin(response["status"], USABLE)

    return _search(engine, pushed, loads, run, (rise, hold))


Run = Callable[[Places, Array, int], tuple[Array, Flags, Flags]]


def _search(
    engine: str, pushed: Places, loads: Array, run: Run, spans: tuple[float, float]
) -> Pushes:
    """Brackets of the kinds that are pushed, several loads of each at once."""
    brackets = np.full((len(loads), 2), np.nan)
    brackets[pushed, 0], brackets[pushed, 1] = 0.0, ABOVE * loads[pushed]
    unsound, tried, done = np.zeros(len(loads), dtype=bool), [], 0
    each = max(1, SIDE_BY_SIDE // max(len(pushed), 1))
    # The first loads reach up to the largest, which need not bring an assembly down.
    wide, parts = pushed, np.arange(1, each + 1) / each
    while len(wide):
        kinds = np.repeat(wide, each)
        low, high = brackets[kinds].T
        factors = low + np.tile(parts, len(wide)) * (high - low)
        moved, fell, usable = run(kinds, factors, done)
        tried.append((kinds, factors, moved, fell & usable))
        done += len(kinds)
        rows = zip(wide, *(part.reshape(-1, each) for part in (factors, fell, usable)), strict=True)
        for kind, *row in rows:
            brackets[kind], unsound[kind] = _narrowed(brackets[kind], *row)
        if parts[-1] == 1.0:
            brackets[wide[brackets[wide, 0] == ABOVE * loads[wide]], 1] = np.inf
            parts = np.arange(1, each + 1) / (each + 1)
        low, high = brackets[wide].T
        wide = wide[np.isfinite(high) & (high - low > ACCURACY * high)]
    nothing = (np.zeros(0, dtype=np.intp), np.zeros(0), np.zeros(0), np.zeros(0, dtype=bool))
    joined = Tried(*(np.concatenate(part) for part in zip(nothing, *tried, strict=True)))
    return Pushes(engine, brackets[:, 0], brackets[:, 1], unsound, *spans, joined)


def _narrowed(bracket: Array, factors: Array, fell: Flags, usable: Flags) -> tuple[Array, bool]:
    """The part of a bracket in which the first of several loads brings an assembly down.

    Returns:
        The bracket, NaN where the first such lane has no usable number; and whether it has none.
    """
    ends = np.concatenate([bracket[:1], factors, bracket[1:]])
    ends_it = fell | ~usable
    first = int(np.argmax(ends_it)) if ends_it.any() else len(factors)
    if first < len(factors) and not usable[first]:
        return np.full(2, np.nan), True
    return ends[first : first + 2], False


def _pushes(along: LoadMotions, direction: Array, *, spatial: bool) -> GroundMotions:
    """Pushes to +x as pushes in other directions [rad], shape [lane]."""
    x = along.scaled(np.cos(direction))
    if not spatial:
        return x
    return SpatialMotions(x, along.scaled(np.sin(direction)), no_motion(along))
