"""Engines side by side on assemblies: what each makes of a lane, beside what a reference makes.

Where blocks slide, or an assembly is about to collapse, answers part; the first engine is what the
others are held against, and a difference is a difference.
"""

from __future__ import annotations

import numpy as np
import pandas as pd

from warprock.case.lanes import LaneSet
from warprock.model.response import Outcome, Response, Status, names_of


def compare_assemblies(lane_set: LaneSet, response: Response, reference: Response) -> pd.DataFrame:
    """One row a lane: how far an engine's answer is from the reference's.

    Args:
        lane_set: The lanes, assemblies, that both responses answer.
        response: Response of the engine, with or without histories.
        reference: Response of the engine that it is held against.

    Returns:
        The lanes' inputs, then `lane_number`, `engine`, `reference`, `status`, `outcome`,
        `fell_at_s` (when a block had fallen), `moved_mm` and `reference_moved_mm` (largest
        displacement of a block), and `difference_deg` (largest difference over the run of the
        largest rotation of any block so far; NaN without histories).
    """
    lanes = lane_set.lanes
    off = np.full(lanes.lane_count, np.nan)
    if "rotation" in response.fields and "rotation" in reference.fields:
        so_far = [
            np.maximum.accumulate(each["rotation"].reshape(lanes.lane_count, -1), axis=1)
            for each in (response, reference)
        ]
        off = np.degrees(np.abs(so_far[0] - so_far[1]).max(axis=1))
    return lane_set.inputs.reset_index(drop=True).assign(
        lane_number=np.arange(lanes.lane_count),
        engine=response.engine,
        reference=reference.engine,
        status=names_of(Status, response["status"]),
        outcome=names_of(Outcome, response["outcome"]),
        fell_at_s=response["collapse_time"],
        moved_mm=1e3 * response["peak_displacement"],
        reference_moved_mm=1e3 * reference["peak_displacement"],
        difference_deg=off,
    )
