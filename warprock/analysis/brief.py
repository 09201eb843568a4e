"""What a decision about one object wants to know: its yearly rate, what lowers it, and its slide.

The rate and the measures are those of `warprock.analysis.measures`. Beside them the block runs at
each factor of the ladder once more for its slide: how far it has slid at the strongest motions that
it stands before its first fall, and, where a clearance is asked for, how often in a year it slides
that far. A slide need not grow with the motion, so that its capacity is the first factor at which
it reaches the clearance, as it is for falls.
"""

from __future__ import annotations

import dataclasses

import numpy as np
import pandas as pd

from warprock.analysis.groups import RECORD
from warprock.analysis.incremental import Verdict
from warprock.analysis.measures import Measures, Question, run_measures
from warprock.analysis.risk import Risk, assess
from warprock.analysis.risk_functions import functions_of_capacities
from warprock.analysis.verdict import lanes_run
from warprock.case.case import Case
from warprock.case.lanes import LaneSet, expand_lanes
from warprock.model.response import FALLEN_NAMES, USABLE_NAMES
from warprock.running.engine_choice import slides
from warprock.running.options import RunOptions


@dataclasses.dataclass(frozen=True)
class Slide:
    """How far a block slides.

    Attributes:
        standing: Largest slide of any lane at motions below those of its first fall [m].
        clearance: Slide that is asked for [m]; NaN where none is.
        before: Lanes that slide that far before they first fall.
        risk: How often in a year it slides that far; None where that is not asked.
    """

    standing: float
    clearance: float = np.nan
    before: int = 0
    risk: Risk | None = None


@dataclasses.dataclass(frozen=True)
class Brief:
    """What a decision about one object wants to know.

    Attributes:
        measures: Its rate as it is, and what lowers it.
        lane_set: The object under its motions.
        slide: How far it slides; None where its engine leaves sliding out.
    """

    measures: Measures
    lane_set: LaneSet
    slide: Slide | None

    @property
    def base(self) -> Risk:
        """The rate at which the object falls as it is."""
        return self.measures.base

    @property
    def records(self) -> int:
        """Records that it runs under."""
        inputs = self.lane_set.inputs
        return int(inputs[RECORD].nunique()) if RECORD in inputs else len(inputs)


def run_brief(case: Case, engine: str, options: RunOptions, question: Question) -> Brief:
    """Runs a block as it is and with measures, and for its slide.

    Args:
        case: The case: one block under several records, a lane each.
        engine: Name of the engine.
        options: How lanes are run.
        question: What is asked of it.

    Raises:
        InputError: As of `run_measures`.
    """
    hazard, ladder, clearance = question.hazard, question.ladder, question.clearance
    found = run_measures(case, engine, options, question)
    lane_set = expand_lanes(case)
    if not slides(engine):
        return Brief(found, lane_set, None)
    count = lane_set.lanes.lane_count
    lanes = np.repeat(np.arange(count, dtype=np.intp), ladder.count)
    factors = np.tile(ladder.factors, count)
    settings = case.engine_settings(engine)
    runs = lanes_run(lane_set.take(lanes), factors, engine, options.without_progress(), settings)
    first = _first(runs, lanes, count, runs["outcome"].isin(FALLEN_NAMES))
    stood = runs["status"].isin(USABLE_NAMES) & (runs["motion_factor"] < first[lanes])
    standing = float(runs["peak_slide_m"][stood].max()) if stood.any() else 0.0
    if np.isnan(clearance):
        return Brief(found, lane_set, Slide(standing))
    hit = _first(runs, lanes, count, runs["peak_slide_m"] >= clearance)
    usable = runs["status"].isin(USABLE_NAMES).to_numpy() & (factors < hit[lanes])
    low = np.zeros(count)
    np.maximum.at(low, lanes[usable], factors[usable])
    unknown = (low == 0.0) & np.isinf(hit)
    table = pd.concat(
        [
            lane_set.inputs.reset_index(drop=True),
            pd.DataFrame(
                {
                    "standing_factor": low,
                    "overturning_factor": hit,
                    "verdict": np.where(
                        unknown, Verdict.UNKNOWN.value, Verdict.BRACKETED.value
                    ).astype(object),
                }
            ),
        ],
        axis=1,
    )
    (function,) = functions_of_capacities(table, hazard.measure, case.name, (), ())
    risk = assess(dataclasses.replace(function, limit="sliding"), hazard, question.most_outside)
    before = int((hit < first).sum())
    return Brief(found, lane_set, Slide(standing, clearance, before, risk))


def _first(runs: pd.DataFrame, lanes: np.ndarray, count: int, reached: pd.Series) -> np.ndarray:
    """The least factor at which each lane reached something; infinite where it did not."""
    mine = (reached & runs["status"].isin(USABLE_NAMES)).to_numpy()
    found = np.full(count, np.inf)
    np.minimum.at(found, lanes[mine], runs["motion_factor"].to_numpy()[mine])
    return found
