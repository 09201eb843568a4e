"""Does a block stand under a motion, and by how much: the questions that people come with.

One block and one motion are run as they are; with the motion a factor weaker and stronger, up to
where the block first falls; with small differences of size, friction and strength of the motion;
and, where it is a box, at greater widths under a motion 1.5 times as strong. Rocking is not
monotonic: a block may stand at a stronger motion than the one that overturned it, and a wider one
may fall where it stood. So factors count up to the first fall, and a width is enough from which on
no wider one that was tried falls.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from warprock.analysis.incremental import Analysis, Ladder, plan_analysis, run_analysis
from warprock.case.case import Case
from warprock.case.lanes import LaneSet, expand_lanes
from warprock.case.load import build_case, changed
from warprock.errors import NOTHING, InputError, Said
from warprock.model.response import FALLEN_NAMES, USABLE_NAMES, SampleTimes
from warprock.model.words import lane_count_text
from warprock.running.case_run import CaseRun, run_case, run_lane_set
from warprock.running.cells import wilson_interval
from warprock.running.engine_choice import slides
from warprock.running.lane_table import lane_table
from warprock.running.options import RunOptions, count_from

Array = npt.NDArray[np.float64]

MARGIN = 1.5
"""Factor on the motion that a width is asked for, unless another is."""
NEIGHBOURS = 256
FACTORS = 41
"""Factors on the motion at which the block runs, from 0.1 to 10."""
SEED = 1
WIDEST = 3.0
"""Greatest width that is tried, over that of the block."""
_WIDTHS = 25
_BETWEEN = 8
"""Widths of the first stage, and between two of them in each stage that follows."""


@dataclasses.dataclass(frozen=True)
class Spread:
    """How far neighbours differ: each quantity is even over 1 - share to 1 + share of its own.

    Attributes:
        size: Share of width and height [-].
        friction: Share of the friction coefficient [-].
        motion: Share of the strength of the motion [-].
    """

    size: float = 0.02
    friction: float = 0.1
    motion: float = 0.1

    def judge(self) -> None:
        """Refuses shares out of bounds.

        Raises:
            InputError: One of them is.
        """
        for name, share in dataclasses.asdict(self).items():
            if not 0.0 <= share <= 0.5:
                raise InputError(f"--spread-{name}", "", share, "must be a share from 0 to 0.5")


@dataclasses.dataclass(frozen=True)
class Widths:
    """How wide a box must be to stand under a motion.

    Attributes:
        own: Its width [m].
        low: A width at which it falls [m]; NaN where it stands at its own.
        high: The width from which on it stands at all that were tried [m]; infinite without.
        table: One row a width that was tried: `width_m`, `outcome`, `status`.
    """

    own: float
    low: float
    high: float
    table: pd.DataFrame


@dataclasses.dataclass(frozen=True)
class Verdict:
    """What became of a block, and how far it was from something else.

    Attributes:
        run: The block under the motion as it is.
        ladder: The block under weaker and stronger motions.
        neighbours: Lane table of its neighbours; their factor on the motion is `motion_factor`.
        spread: How far they differ.
        margin: Factor on the motion that the width is asked for.
        widths: How wide it must be; None where it is no box.
    """

    run: CaseRun
    ladder: Analysis
    neighbours: pd.DataFrame
    spread: Spread
    margin: float
    widths: Widths | None

    @property
    def lane(self) -> Mapping[str, Any]:
        """The block under the motion as it is: a row of the lane table."""
        table = lane_table(self.run.lane_set, self.run.response)
        return {str(name): value for name, value in table.iloc[0].items()}

    @property
    def slides(self) -> bool:
        """Whether its engine lets it slide."""
        return slides(self.run.response.engine)

    @property
    def capacity(self) -> Mapping[str, Any]:
        """What is known of the factor at which it first falls."""
        return {str(name): value for name, value in self.ladder.capacities.iloc[0].items()}

    @property
    def fallen(self) -> tuple[int, int, tuple[float, float]]:
        """Neighbours that fell, those with usable numbers, and the 95 % interval of the share."""
        usable = self.neighbours["status"].isin(USABLE_NAMES)
        fell = int((usable & self.neighbours["outcome"].isin(FALLEN_NAMES)).sum())
        low, high = wilson_interval(np.array([fell]), np.array([usable.sum()]))
        return fell, int(usable.sum()), (float(low[0]), float(high[0]))


def run_verdict(
    case: Case,
    engine: str,
    options: RunOptions,
    *,
    spread: Spread,
    neighbours: int = NEIGHBOURS,
    margin: float = MARGIN,
) -> Verdict:
    """Runs all that a verdict asks for.

    Args:
        case: One block under one motion.
        engine: Name of the engine.
        options: How lanes are run.
        spread: How far neighbours differ.
        neighbours: How many there are.
        margin: Factor on the motion that the width is asked for.

    Raises:
        InputError: The case has no motion, or several lanes, or something is out of bounds.
    """
    _require_one(case)
    spread.judge()
    for option, number, good, allowed in (
        ("--neighbours", neighbours, 16 <= neighbours <= 65536, "must be from 16 to 65,536"),
        ("--margin", margin, 0.1 <= margin <= 10.0, "must be from 0.1 to 10"),
    ):
        if not good:
            raise InputError(option, "", number, allowed)
    chosen = Ladder(count=FACTORS)
    plan = plan_analysis(case, engine, chosen, options)
    run = run_case(case, engine, options, histories=False)
    stages = run_analysis(
        case,
        plan,
        chosen,
        workers=options.workers,
        progress=count_from(options.progress, 1),
    )
    around = options.counting_from(1 + len(stages.curves))
    beside = _neighbours(case, engine, around, spread, neighbours)
    wide = around.counting_from(len(beside))
    return Verdict(run, stages, beside, spread, margin, _wide_enough(case, engine, wide, margin))


def _require_one(case: Case) -> None:
    """Refuses a case that is not one block under one motion."""
    if case.tables.motion is None:
        raise InputError(case.file, "motion", NOTHING, "must be given: a verdict is under a motion")
    if case.lane_count != 1 or case.ensemble is not None:
        got = Said(lane_count_text(case.lane_count))
        allowed = (
            "must be one block under one motion: fix what varies, such as -s motion.scale=1 "
            'or -s block.width="0.5 m"'
        )
        raise InputError(case.file, "sweep", got, allowed)
    if expand_lanes(case).lanes.stacked:
        allowed = (
            "must be a single block: of a stack warprock ida tells the factor at which it falls"
        )
        raise InputError(case.file, "block", Said("a stack"), allowed)


def lanes_run(
    lane_set: LaneSet, factors: Array, engine: str, options: RunOptions, settings: Any
) -> pd.DataFrame:
    """The lane table of some lanes, each with its motion a factor stronger.

    Args:
        lane_set: The lanes.
        factors: On their motions, shape [lane].
        engine: Name of the engine.
        options: How they are run.
        settings: Settings of the engine.
    """
    stronger = dataclasses.replace(lane_set, motions=lane_set.motions.scaled(factors))
    times = SampleTimes(stronger.longest.duration)
    response = run_lane_set(engine, stronger, times, options, settings=settings)
    return lane_table(stronger, response).assign(motion_factor=factors)


def is_box(case: Case) -> bool:
    """Whether a case is of one box, whose width may be changed."""
    block = case.raw.get("block", {})
    return "width" in block and "height" in block


def _neighbours(
    case: Case, engine: str, options: RunOptions, spread: Spread, count: int
) -> pd.DataFrame:
    """The lane table of the neighbours of a block."""
    inputs = expand_lanes(case).inputs
    drawn = {}
    sizes = {f"block.{name}": f"{name}_m" for name in ("width", "height")} if is_box(case) else {}
    for key, column in sizes.items():
        drawn[key] = _even(float(inputs[column].iloc[0]), spread.size, " m")
    if slides(engine) and "friction" in inputs:
        drawn["contact.friction"] = _even(float(inputs["friction"].iloc[0]), spread.friction, "")
    drawn = {key: each for key, each in drawn.items() if each is not None}
    rng = np.random.default_rng(SEED)
    factors = 1.0 + spread.motion * rng.uniform(-1.0, 1.0, count)
    if drawn:
        raw = {name: each for name, each in case.raw.items() if name != "check"}
        raw["sample"] = {"lanes": count, "seed": SEED, "sampling": "sobol", "over": drawn}
        lane_set = expand_lanes(build_case(case.name, case.file, case.folder, raw))
    else:
        lane_set = expand_lanes(case).take(np.zeros(count, dtype=np.intp))
    return lanes_run(lane_set, factors, engine, options, case.engine_settings(engine))


def _even(value: float, share: float, unit: str) -> dict[str, str | float] | None:
    """An even distribution about a value; None where it does not spread."""
    if share == 0.0:
        return None
    ends = (value * (1.0 - share), value * (1.0 + share))
    low, high = (f"{end:.12g}{unit}" if unit else end for end in ends)
    return {"distribution": "uniform", "from": low, "to": high}


def _wide_enough(case: Case, engine: str, options: RunOptions, margin: float) -> Widths | None:
    """The least width from which on a box stands under a motion that is stronger."""
    if not is_box(case):
        return None
    own = float(expand_lanes(case).inputs["width_m"].iloc[0])
    tried = pd.DataFrame()
    widths = own * np.geomspace(1.0, WIDEST, _WIDTHS)
    while True:
        found = _run_widths(case, engine, options.counting_from(len(tried)), widths, margin)
        tried = pd.concat([tried, found], ignore_index=True).sort_values("width_m")
        stood = tried["status"].isin(USABLE_NAMES) & ~tried["outcome"].isin(FALLEN_NAMES)
        at, fell = tried["width_m"].to_numpy(), np.flatnonzero(~stood.to_numpy())
        if not len(fell):
            return Widths(own, np.nan, own, tried)
        last = int(fell[-1])
        if last == len(at) - 1:
            return Widths(own, float(at[last]), np.inf, tried)
        low, high = float(at[last]), float(at[last + 1])
        if high <= low * 1.01:
            return Widths(own, low, high, tried)
        widths = np.geomspace(low, high, _BETWEEN + 2)[1:-1]


def _run_widths(
    case: Case, engine: str, options: RunOptions, widths: Array, factor: float
) -> pd.DataFrame:
    """What becomes of a box at some widths under a motion that is stronger."""
    texts = [f"{width:.12g} m" for width in widths]
    lane_set = expand_lanes(changed(case, {"block.width": texts}))
    factors = np.full(len(widths), factor)
    found = lanes_run(lane_set, factors, engine, options, case.engine_settings(engine))
    return found[["width_m", "outcome", "status", "peak_rotation_ratio"]].astype(
        {"outcome": str, "status": str}
    )
