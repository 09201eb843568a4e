"""What lowers the yearly chance that a block falls: measures, each as a factor on its rate.

The block, and the block with each measure, go through the same incremental dynamic analysis: the
same records, the same factors, the same engine. The lognormal capacities of each give its rate
under the hazard, and the rate with a measure over that without is its factor. Both rates lack the
same record in each sample of the band, so that what records have in common cancels in the factor.

The measures that are tried without being asked for are those that a block can have:

- a base that is 10, 25 or 50 % wider, of a body by its `block.base_scale`;
- ballast at its foot, a quarter of its mass, which lowers its centre;
- two ties at nine tenths of its height, each of which yields at a tenth of its weight: a strap to
  the wall behind it;
- an isolator of 0.5 Hz and 15 % damping under it;
- a floor at whose impacts it keeps nine tenths of the angular velocity that it keeps on its own;
- half of its friction, and half more, in engines whose blocks slide.

What an engine cannot do is said so, and no other takes its place: factors between engines would
hold the difference of their models.
"""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from warprock.analysis.bands import ratio_interval
from warprock.analysis.hazard import Hazard
from warprock.analysis.incremental import Ladder, plan_analysis, run_analysis
from warprock.analysis.lognormal import Verdict
from warprock.analysis.risk import Risk, assess, rates_of
from warprock.analysis.risk_functions import capacity_table, functions_of_capacities
from warprock.case.case import Case
from warprock.case.lanes import expand_lanes
from warprock.case.load import changed
from warprock.errors import NOTHING, InputError, Said
from warprock.running.engine_choice import slides
from warprock.running.options import RunOptions
from warprock.units import GRAVITY

WIDER = (1.1, 1.25, 1.5)
BALLAST = 0.25
"""Mass of the ballast over that of the block."""
TIE_HEIGHT, TIE_FORCE = 0.9, 0.1
"""Height of a strap over that of the block, and force at which it yields over its weight."""
TIE_GIVE, TIE_REACH = 0.005, 0.05
"""Elongation at which a strap yields, and that at which it breaks [m]."""
FLOOR = 0.9
"""Angular restitution on another floor over that on its own."""
ISOLATOR_HZ, ISOLATOR_DAMPING = 0.5, 0.15
WIDEST = (4.0, 3.0, 2.0, 1.5)
"""Greatest widths that a target is looked for at, over that of the block: the first that the engine
can do."""
CLOSE = 1.01
"""Ratio of the ends of a bracket at which what meets a target is known well enough."""
STEPS = 8
"""Steps in which what meets a target is looked for before a bracket is halved."""
TIES = (0.01, 1.0)
"""Least and greatest force at which straps yield among which a target is looked for, over the
weight."""


@dataclasses.dataclass(frozen=True)
class Measure:
    """Something that can be done to a block.

    Attributes:
        name: What it is, in short.
        changes: Values by dotted key that the case gets.
    """

    name: str
    changes: Mapping[str, Any]


@dataclasses.dataclass(frozen=True)
class Question:
    """What is asked of a block under a hazard.

    Attributes:
        hazard: The hazard.
        ladder: Factors on the motions.
        measures: The measures; empty takes the usual ones.
        target: Rate that the least width and the least straps are looked for at; None looks for
            none.
        most_outside: Share of a rate that may come from beyond an end of the hazard.
        clearance: Slide whose rate is asked for [m]; NaN asks for none.
    """

    hazard: Hazard
    ladder: Ladder
    measures: Sequence[Measure]
    target: float | None
    most_outside: float
    clearance: float = np.nan


@dataclasses.dataclass(frozen=True)
class Effect:
    """What a measure does to a yearly rate.

    Attributes:
        measure: The measure.
        risk: The rate with it; None where it could not be run.
        factor: Rate with it over rate without; NaN where one of them is not known.
        band: 5th and 95th percentile of the factor over records; NaN without.
        why: Why there is no rate; empty where there is one.
    """

    measure: Measure
    risk: Risk | None
    factor: float = np.nan
    band: tuple[float, float] = (np.nan, np.nan)
    why: str = ""


@dataclasses.dataclass(frozen=True)
class Least:
    """The least of something at which a yearly rate is met.

    Attributes:
        low: What is not enough; NaN where nothing is needed.
        high: What is enough; infinite where nothing that was tried is.
        why: Why it is not known; empty where it is.
    """

    low: float = np.nan
    high: float = np.nan
    why: str = ""


@dataclasses.dataclass(frozen=True)
class Target:
    """What it takes to meet a yearly rate.

    Attributes:
        rate: The rate that is asked for.
        own: Width of the block [m].
        width: The least width [m].
        tie: The least force at which two straps yield, over the weight of the block.
    """

    rate: float
    own: float
    width: Least
    tie: Least


@dataclasses.dataclass(frozen=True)
class Measures:
    """What lowers a yearly rate.

    Attributes:
        case: The case.
        engine: The engine.
        base: The rate of the block as it is.
        effects: What each measure does, the one that lowers it most first.
        target: What it takes to meet a rate; None where none is asked for.
    """

    case: Case
    engine: str
    base: Risk
    effects: Sequence[Effect]
    target: Target | None


def own_measure(text: str) -> Measure:
    """A measure as somebody writes it: `KEY=VALUE`, or several with semicolons between them.

    Raises:
        InputError: One of them has no equals sign.
    """
    changes = {}
    for part in text.split(";"):
        key, equals, value = part.partition("=")
        if not equals or not key.strip():
            allowed = 'must be KEY=VALUE, such as block.width="0.8 m", or several, separated by ;'
            raise InputError("--measure", "", text, allowed)
        changes[key.strip()] = _value(value.strip().strip('"'))
    return Measure(text, changes)


def _value(text: str) -> str | float:
    try:
        return float(text)
    except ValueError:
        return text


def usual_measures(case: Case, engine: str) -> list[Measure]:
    """The measures that are tried where none are asked for; see the head of this file."""
    lane_set = expand_lanes(case, range(1))
    block, row = case.raw.get("block", {}), lane_set.inputs.iloc[0]
    found = []
    box = {"width", "height"} <= set(block)
    if box:
        width, height = float(row["width_m"]), float(row["height_m"])
        found += [
            Measure(
                f"base {100.0 * (by - 1.0):.0f} % wider", {"block.width": f"{by * width:.12g} m"}
            )
            for by in WIDER
        ]
        found.append(Measure(f"ballast of {BALLAST:g} of its mass at its foot", _ballast(row)))
    elif "base" in block:
        own = float(block.get("base_scale", 1.0))
        found += [
            Measure(f"base {100.0 * (by - 1.0):.0f} % wider", {"block.base_scale": by * own})
            for by in WIDER
        ]
    if box and "tie" not in case.raw:
        straps = _straps(_mass(row), height, TIE_FORCE)
        found.append(Measure(f"straps that yield at {TIE_FORCE:g} of its weight", straps))
    if "support" not in case.raw:
        isolator = {"frequency": f"{ISOLATOR_HZ:g} Hz", "damping": ISOLATOR_DAMPING}
        found.append(Measure(f"isolator of {ISOLATOR_HZ:g} Hz", {"support": isolator}))
    restitution = float(row.get("angular_restitution", np.nan))
    if box and np.isfinite(restitution):
        floor = {"contact.angular_restitution": float(f"{FLOOR * restitution:.12g}")}
        found.append(Measure(f"floor with {FLOOR:g} of its restitution", floor))
    if slides(engine) and "friction" in row:
        friction = float(row["friction"])
        found += [
            Measure(f"friction {by:g} times", {"contact.friction": by * friction})
            for by in (0.5, 1.5)
        ]
    return found


def _ballast(row: Any) -> dict[str, Any]:
    """A box with ballast at the middle of its foot, as a body; the ballast is taken as a point."""
    width, height = float(row["width_m"]), float(row["height_m"])
    own = _mass(row)
    mass, centre = own * (1.0 + BALLAST), 0.5 * height / (1.0 + BALLAST)
    inertia = own * (width**2 + height**2) / 12.0
    inertia += own * (0.5 * height - centre) ** 2 + BALLAST * own * centre**2
    half = 0.5 * width
    body = {
        "mass": f"{mass:.12g} kg",
        "base": [[f"{-half:.12g} m", "0 m"], [f"{half:.12g} m", "0 m"]],
        "centre": ["0 m", f"{centre:.12g} m"],
        "inertia": f"{inertia:.12g} kg m^2",
    }
    return {"block": body}


def _mass(row: Any) -> float:
    """Mass of a box [kg]."""
    return float(row["density_kg_m3"] * row["width_m"] * row["height_m"] * row["depth_m"])


def _straps(mass: float, height: float, share: float) -> dict[str, Any]:
    """Two ties near the top, one to each side, that yield at a share of the weight."""
    force = share * mass * GRAVITY
    tie = {
        "height": f"{TIE_HEIGHT * height:.12g} m",
        "stiffness": f"{force / TIE_GIVE:.12g} N/m",
        "yield_force": f"{force:.12g} N",
        "ultimate_elongation": f"{TIE_REACH:g} m",
    }
    return {"tie": [{**tie, "side": side} for side in ("left", "right")]}


def run_measures(case: Case, engine: str, options: RunOptions, question: Question) -> Measures:
    """Runs a block with each measure, and finds what each does to its rate.

    Args:
        case: The case: one block under several records, a lane each.
        engine: Name of the engine.
        options: How lanes are run.
        question: What is asked of it.

    Raises:
        InputError: The block has no rate as it is, or something cannot be used.
    """
    target, measures = question.target, question.measures
    if target is not None and not (np.isfinite(target) and target > 0.0):
        raise InputError("--target", "", target, "must be a rate above 0 a year")
    if case.tables.motion is None:
        raise InputError(case.file, "motion", NOTHING, "must be given: it is made stronger")
    tried = list(measures) or usual_measures(case, engine)
    for measure in measures:
        try:
            changed(case, measure.changes)
        except InputError as error:
            raise InputError("--measure", error.key, error.got, error.allowed) from None
    runner = _Runner(engine, options, question)
    base = runner.rate(case)
    if not base.rate > 0.0:
        allowed = (
            "must have a rate to lower: no lognormal function fits the factors at which its lanes "
            f"fall ({base.function.fit.verdict.value})"
        )
        raise InputError(case.file, "motion", Said("the block as it is"), allowed)
    effects = [runner.effect(case, measure, base) for measure in tried]
    effects.sort(key=lambda each: each.factor if np.isfinite(each.factor) else np.inf)
    goal = None if target is None else runner.meet(case, base, target)
    return Measures(case, engine, base, effects, goal)


class _Runner:
    """Runs variants of a case one after another."""

    def __init__(self, engine: str, options: RunOptions, question: Question) -> None:
        self.engine, self.options, self.done = engine, options, 0
        self.hazard, self.ladder = question.hazard, question.ladder
        self.most_outside = question.most_outside

    def rate(self, case: Case) -> Risk:
        """The rate at which the lanes of a case fall."""
        plan = plan_analysis(case, self.engine, self.ladder, self.options)
        counted = self.options.counting_from(self.done)
        found = run_analysis(
            case, plan, self.ladder, workers=counted.workers, progress=counted.progress
        )
        self.done += len(found.curves)
        table = capacity_table(found)
        (function,) = functions_of_capacities(table, self.hazard.measure, case.name, (), ())
        return assess(function, self.hazard, self.most_outside)

    def effect(self, case: Case, measure: Measure, base: Risk) -> Effect:
        """What a measure does to a rate."""
        try:
            risk = self.rate(changed(case, measure.changes))
        except InputError as error:
            return Effect(measure, None, why=error.allowed)
        if not risk.rate > 0.0:
            verdict = risk.function.fit.verdict
            top = self.ladder.highest
            why = f"no lane falls up to {top:g} times its motion"
            return Effect(
                measure, risk, why=why if verdict is Verdict.NONE_REACHED else verdict.value
            )
        band = (np.nan, np.nan)
        if risk.function.band is not None and base.function.band is not None:
            band = ratio_interval(
                risk.function.band,
                base.function.band,
                lambda median, spread: rates_of(self.hazard, median, spread),
            )
        return Effect(measure, risk, risk.rate / base.rate, band)

    def meet(self, case: Case, base: Risk, target: float) -> Target:
        """The least width and the least straps at which a box meets a rate.

        Each by halving a bracket over its logarithm.
        """
        block = case.raw.get("block", {})
        if not {"width", "height"} <= set(block):
            allowed = "must be left out: the block is no box, whose width could be changed"
            raise InputError("--target", "", target, allowed)
        row = expand_lanes(case, range(1)).inputs.iloc[0]
        own = float(row["width_m"])
        if base.rate <= target:
            return Target(target, own, Least(high=own), Least(high=0.0))

        def wider(width: float) -> bool:
            return self._meets(case, {"block.width": f"{width:.12g} m"}, target)

        def tied(share: float) -> bool:
            return self._meets(case, _straps(_mass(row), float(row["height_m"]), share), target)

        return Target(target, own, self._width(own, wider), self._tie(case, tied))

    def _width(self, own: float, meets: Callable[[float], bool]) -> Least:
        """The least width, from that of the block up to the greatest that the engine can do."""
        for by in WIDEST[:-1]:
            try:
                return _least(own, by * own, meets)
            except InputError:
                continue
        return _least(own, WIDEST[-1] * own, meets)

    def _tie(self, case: Case, meets: Callable[[float], bool]) -> Least:
        """The least straps."""
        if "tie" in case.raw:
            return Least(why="the block has ties already")
        try:
            return Least(0.0, TIES[0]) if meets(TIES[0]) else _least(*TIES, meets)
        except InputError as error:
            return Least(why=error.allowed)

    def _meets(self, case: Case, changes: Mapping[str, Any], target: float) -> bool:
        """Whether a box with some changes meets a rate; one that never falls does."""
        risk = self.rate(changed(case, changes))
        return risk.rate <= target or risk.function.fit.verdict is Verdict.NONE_REACHED


def _least(low: float, high: float, meets: Callable[[float], bool]) -> Least:
    """The least of something from which on all that is tried is enough.

    A rate does not fall evenly with a width or a strap: more may do less. So the most comes first,
    and steps go down to the last that is not enough; a bracket is halved between it and the next.

    Args:
        low: What is not enough.
        high: The most that is tried.
        meets: Whether it is enough.
    """
    steps = np.geomspace(low, high, STEPS + 1)[::-1].tolist()
    if not meets(steps[0]):
        return Least(high, np.inf)
    for more, less in itertools.pairwise(steps):
        if less == steps[-1] or not meets(less):
            low, high = less, more
            break
    while high > CLOSE * low:
        middle = float(np.sqrt(low * high))
        low, high = (low, middle) if meets(middle) else (middle, high)
    return Least(low, high)
