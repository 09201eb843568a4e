"""Counts of lanes by what their refinement came to: within the tolerance, off it, sensitive."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from warprock.case.lanes import LaneSet
from warprock.model.response import USABLE, USABLE_NAMES, Response, Status

MET, MISSED, SENSITIVE, REFINED = "met", "missed", "sensitive", "refined"
FIRST_STEPS, TOTAL_STEPS = "first_step_count", "total_step_count"
KEY, KEY_BEFORE = "refinement", "accuracy"
"""Key of the counts in files, and the one that older files have."""


def rename_counts(facts: Mapping[str, Any]) -> dict[str, Any]:
    """What a file says, with the counts under the key of today."""
    return {KEY if name == KEY_BEFORE else name: value for name, value in facts.items()}


def error_ratio(response: Response, lane_set: LaneSet) -> npt.NDArray[np.float64]:
    """Estimated error of the rotation / slenderness angle, of a stack the largest, shape [lane]."""
    ratio = response["rotation_error"] / lane_set.lanes.slenderness_angle
    return np.asarray(ratio.reshape(response.lane_count, -1).max(axis=1))


def missed_tolerance(
    response: Response, lane_set: LaneSet, tolerance: float | None
) -> npt.NDArray[np.bool_]:
    """Lanes whose numbers are usable but not within the tolerance, sensitive or not, shape [lane].

    None where no error was estimated.
    """
    if tolerance is None or "rotation_error" not in response.fields:
        return np.zeros(response.lane_count, dtype=np.bool_)
    within = error_ratio(response, lane_set) <= tolerance
    sensitive = response["status"] == Status.SENSITIVE
    return np.asarray(np.isin(response["status"], USABLE) & (sensitive | ~within))


def refinement_counts(
    response: Response, lane_set: LaneSet, settings: Any, tolerance: float | None
) -> dict[str, int]:
    """Counts of lanes by what their estimates say, and of steps; counts of chunks may be added up.

    Args:
        response: The answer of `run_lane_set`.
        lane_set: Its lanes.
        settings: Settings of the engine, with the step asked for.
        tolerance: Largest error of a rotation over the slenderness angle; None without estimates.

    Returns:
        Lanes that `met` it, `missed` it though their runs approach one another, or are `sensitive`,
        lanes `refined`, whose numbers are from a finer step than that asked for; steps of one run
        of all lanes, `first_step_count`, and of all runs, `total_step_count`. Empty where no error
        was estimated: none was wanted, or the engine has none that comes from its step.
    """
    if tolerance is None or "rotation_error" not in response.fields:
        return {}
    factors = 1.0 if lane_set.step_factors is None else lane_set.step_factors
    missed = missed_tolerance(response, lane_set, tolerance)
    sensitive = response["status"] == Status.SENSITIVE
    return {
        MET: int(np.sum(np.isin(response["status"], USABLE) & ~missed)),
        MISSED: int(np.sum(missed & ~sensitive)),
        SENSITIVE: int(np.sum(sensitive)),
        REFINED: int(np.sum(response["time_step"] < 0.75 * factors * settings.time_step)),
        FIRST_STEPS: int(response[FIRST_STEPS].sum()),
        TOTAL_STEPS: int(response[TOTAL_STEPS].sum()),
    }


def count_bad(status: Mapping[str, int], refinement: Mapping[str, int]) -> int:
    """Lanes whose numbers may not be used, or that missed the tolerance.

    Args:
        status: Lanes by word of their status.
        refinement: What `refinement_counts` found.
    """
    return unusable_lanes(status) + refinement.get(MISSED, 0) + refinement.get(SENSITIVE, 0)


def unusable_lanes(status: Mapping[str, int]) -> int:
    """Lanes whose numbers may not be used, from the counts of their statuses."""
    usable = set(USABLE_NAMES)
    return sum(count for word, count in status.items() if word not in usable)
