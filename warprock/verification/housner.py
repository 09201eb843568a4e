"""An engine's response held against Housner's, lane by lane, and where Housner holds at all.

Housner's block (Housner 1963) is planar, does not slide and loses energy in impacts alone. Where
it needs more friction than there is, as `housner` itself finds, or an engine's block slides, a
difference from Housner is no error of the engine; such a lane is compared all the same, with the
reason beside it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from warprock.case.lanes import LaneSet
from warprock.engines import reference_engine
from warprock.model.ratios import peak_ratio
from warprock.model.response import Outcome, Response, Status, names_of

if TYPE_CHECKING:
    import pandas as pd

Array = npt.NDArray[np.float64]

SLIDE_BOUND = 1e-3
"""Largest slide / width at which a lane still counts as one that does not slide."""
EARLY_TIME = 5.0
"""Time [s] that the early error covers: the stretch that the paper's figures enlarge."""
RESTITUTION_BOUND = 1e-9
"""Difference from Housner's angular restitution above which a case prescribes its own."""
PULLS = "the base would have to pull the block"
"""Why Housner does not hold where no friction is enough."""
NEEDS = "the block needs more friction than it has"
"""Why Housner does not hold where the block would slide; the two numbers come behind it."""
SMALL_ROTATION_RATIO = 1e-9
"""Peak rotation / slenderness angle below which a relative peak error has no meaning."""


def where_housner_holds(
    lane_set: LaneSet, response: Response, reference_response: Response
) -> list[str]:
    """Why Housner does not hold, one text a lane; an empty text where it does.

    Args:
        lane_set: The lanes.
        response: Response of the engine under test.
        reference_response: Housner's (`housner` or the oracle), which says what friction its block
            needs along the way, at impacts and at velocity steps.
    """
    lanes = lane_set.lanes
    friction, needed = lanes.friction, _friction_needed(reference_response)
    leaves = reference_response["status"] == Status.OUTSIDE_MODEL
    closed_form = 1.0 - 1.5 * np.sin(lanes.slenderness_angle) ** 2
    if lanes.hold is not None and lanes.hold.frame is not None:
        closed_form = lanes.hold.frame.angular_restitution(lanes.slenderness_angle)
    prescribed = np.abs(lanes.angular_restitution - closed_form) > RESTITUTION_BOUND
    if lanes.body is not None:
        # Of a body both sides have their own; an engine that runs one follows what is prescribed.
        prescribed = np.zeros_like(prescribed)
    slide = response["peak_slide"]
    reasons: list[str] = []
    for lane in range(lanes.lane_count):
        why: list[str] = []
        status = Status(int(response["status"][lane]))
        if status not in (Status.OK, Status.OUTSIDE_MODEL):
            why.append(f"status {status.name.lower()}")
        if leaves[lane] and np.isinf(needed[lane]):
            why.append(PULLS)
        elif leaves[lane]:
            why.append(f"{NEEDS}: {needed[lane]:.3g} for {friction[lane]:.3g}")
        if slide[lane] > SLIDE_BOUND * lanes.width[lane]:
            why.append(f"slides {1e3 * slide[lane]:.2g} mm")
        if prescribed[lane] and response.engine != reference_engine():
            why.append("the case prescribes an angular restitution of its own")
        reasons.append("; ".join(why))
    return reasons


def _friction_needed(reference: Response) -> Array:
    """What friction Housner's block needs, shape [lane]; NaN of frames, which do not say it."""
    unknown = np.full(len(reference["status"]), np.nan)
    return np.asarray(reference.fields.get("friction_needed", unknown))


def _history_errors(response: Response, reference: Response, scale: Array) -> tuple[Array, Array]:
    """Largest |rotation difference| / scale up to `EARLY_TIME` and over the run, shape [lane].

    A lane is compared until either block lies flat: what a history holds afterwards is a
    convention, not a motion.
    """
    times = response.times
    if len(times) != len(reference.times) or not np.allclose(times, reference.times):
        raise ValueError(
            f"histories: {response.engine} and {reference.engine} are sampled at different times"
        )
    ours, theirs = response["rotation"], reference["rotation"]
    fallen = np.maximum(np.abs(ours), np.abs(theirs)) >= 0.5 * np.pi - 1e-6
    standing = np.cumsum(fallen, axis=1) == 0
    difference = np.where(standing, np.abs(ours - theirs), 0.0) / scale[:, None]
    early = times <= EARLY_TIME + 1e-9
    return np.asarray(difference[:, early].max(axis=1)), np.asarray(difference.max(axis=1))


def housner_columns(
    lane_set: LaneSet, response: Response, reference_response: Response
) -> dict[str, Any]:
    """The engine's errors against Housner, and where Housner does not hold, one value a lane.

    Args:
        lane_set: The lanes that both responses answer.
        response: Response of the engine under test, with or without histories.
        reference_response: Housner's response (`housner` or the oracle) of the same lanes.

    Returns:
        Columns by name: `engine`, `holds`, `why`, `friction_needed` (of Housner's block; inf where
        its base would have to pull), `outcome`, `reference_outcome`, `peak_rotation_ratio`,
        `reference_peak_rotation_ratio`, `error_5s_ratio` and
        `error_run_ratio` (max |rotation difference| / slenderness angle over the first 5 s and
        over the run; NaN without histories), `peak_error` (relative; NaN where the reference
        does not rock), `peak_slide_mm` and `rest_time_error_s` (engine's minus Housner's; NaN
        where either never rests).
    """
    slenderness = lane_set.lanes.slenderness_angle
    reasons = where_housner_holds(lane_set, response, reference_response)
    lane_count = len(reasons)
    early = run = np.full(lane_count, np.nan)
    if "rotation" in response.fields and "rotation" in reference_response.fields:
        early, run = _history_errors(response, reference_response, slenderness)
    peak = peak_ratio(response, lane_set.lanes)
    reference_peak = peak_ratio(reference_response, lane_set.lanes)
    rocks = reference_peak > SMALL_ROTATION_RATIO
    peak_error = np.full(lane_count, np.nan)
    peak_error[rocks] = peak[rocks] / reference_peak[rocks] - 1.0
    return {
        "engine": [response.engine] * lane_count,
        "holds": [not why for why in reasons],
        "why": reasons,
        "friction_needed": _friction_needed(reference_response),
        "outcome": names_of(Outcome, response["outcome"]),
        "reference_outcome": names_of(Outcome, reference_response["outcome"]),
        "peak_rotation_ratio": peak,
        "reference_peak_rotation_ratio": reference_peak,
        "error_5s_ratio": early,
        "error_run_ratio": run,
        "peak_error": peak_error,
        "peak_slide_mm": 1e3 * response["peak_slide"],
        "rest_time_error_s": response["rest_time"] - reference_response["rest_time"],
    }


def compare_with_housner(
    lane_set: LaneSet, response: Response, reference_response: Response
) -> pd.DataFrame:
    """The lanes' inputs, and `housner_columns` beside them, one row a lane."""
    table = lane_set.inputs.reset_index(drop=True).copy()
    return table.assign(**housner_columns(lane_set, response, reference_response))
