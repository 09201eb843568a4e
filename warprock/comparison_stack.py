"""Engines side by side on stacks: each block's history and peak against those of a reference.

No engine is right about a stack by itself: the analytical model cannot slide, the contact engines
have their own rule for several corners that land at once. So the engine named first is what the
others are held against, and a difference is a difference.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pandas as pd

from warprock.comparison import EARLY_TIME
from warprock.expansion import LaneSet
from warprock.response import Outcome, Response, Status

Array = npt.NDArray[np.float64]


def compare_blocks(lane_set: LaneSet, response: Response, reference: Response) -> pd.DataFrame:
    """One row a lane and block: how far an engine's answer is from the reference's.

    Args:
        lane_set: The lanes, stacks, that both responses answer.
        response: Response of the engine, with or without histories.
        reference: Response of the engine that it is held against.

    Returns:
        The lanes' inputs, then `lane_number`, `engine`, `reference`, `block` (the lowest is 1),
        `status`, `outcome`, `peak_rotation_ratio`, `reference_peak_rotation_ratio`,
        `difference_5s_ratio` and `difference_run_ratio` (largest |rotation difference| / the
        block's slenderness angle over the first 5 s and over the run; NaN without histories), and
        `peak_slide_mm`.
    """
    lanes = lane_set.lanes
    slenderness = lanes.slenderness_angle
    early, whole = _history_differences(response, reference, slenderness)
    count = lanes.block_count
    table = lane_set.inputs.loc[np.repeat(lane_set.inputs.index, count)].reset_index(drop=True)
    return table.assign(
        lane_number=np.repeat(np.arange(lanes.lane_count), count),
        engine=response.engine,
        reference=reference.engine,
        block=np.tile(np.arange(1, count + 1), lanes.lane_count),
        status=np.repeat([Status(int(c)).name.lower() for c in response["status"]], count),
        outcome=np.repeat([Outcome(int(c)).name.lower() for c in response["outcome"]], count),
        peak_rotation_ratio=(response["peak_rotation"] / slenderness).ravel(),
        reference_peak_rotation_ratio=(reference["peak_rotation"] / slenderness).ravel(),
        difference_5s_ratio=early.ravel(),
        difference_run_ratio=whole.ravel(),
        peak_slide_mm=1e3 * response["peak_slide"].ravel(),
    )


def _history_differences(
    response: Response, reference: Response, slenderness: Array
) -> tuple[Array, Array]:
    """Largest |rotation difference| / slenderness angle early and over the run, [lane, block].

    A lane is compared until one of its blocks has fallen in either response: there it ends.
    """
    if not ("rotation" in response.fields and "rotation" in reference.fields):
        nothing = np.full_like(slenderness, np.nan)
        return nothing, nothing
    ours, theirs = response["rotation"], reference["rotation"]
    fallen = np.maximum(np.abs(ours), np.abs(theirs)).max(axis=1) >= 0.5 * np.pi - 1e-6
    standing = (np.cumsum(fallen, axis=1) == 0)[:, None, :]
    difference = np.where(standing, np.abs(ours - theirs), 0.0) / slenderness[:, :, None]
    early = response.times <= EARLY_TIME + 1e-9
    return difference[:, :, early].max(axis=2), difference.max(axis=2)
