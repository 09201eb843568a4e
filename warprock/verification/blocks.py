"""Engines side by side on stacks and in space: each block against that of a reference.

No engine is right about a stack by itself: the analytical model cannot slide, the contact engines
have their own rule for several corners that land at once. In space there is no analytical model. So
the engine named first is what the others are held against, and a difference is a difference.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pandas as pd

from warprock.case.lanes import LaneSet
from warprock.model.response import Outcome, Response, Status, names_of
from warprock.verification.housner import EARLY_TIME

Array = npt.NDArray[np.float64]


def compare_blocks(lane_set: LaneSet, response: Response, reference: Response) -> pd.DataFrame:
    """One row a lane and block: how far an engine's answer is from the reference's.

    Args:
        lane_set: The lanes, stacks or blocks in space, that both responses answer.
        response: Response of the engine, with or without histories.
        reference: Response of the engine that it is held against.

    Returns:
        The lanes' inputs, then `lane_number`, `engine`, `reference`, `block` (the lowest is 1),
        `status`, `outcome`, `peak_rotation_ratio`, `reference_peak_rotation_ratio`,
        `difference_5s_ratio` and `difference_run_ratio` (largest |rotation difference| / the
        block's slenderness angle over the first 5 s and over the run; NaN without histories), and
        `peak_slide_mm`. In space also `difference_across_5s_ratio` (that of the rotation across),
        `difference_yaw_5s_rad`, `peak_tilt_ratio` (over the slenderness angle) and `peak_yaw_rad`.
    """
    lanes = lane_set.lanes
    count = lanes.block_count
    slenderness = lanes.slenderness_angle.reshape(-1, count)
    early, whole = _history_differences(response, reference, slenderness)
    table = lane_set.inputs.loc[np.repeat(lane_set.inputs.index, count)].reset_index(drop=True)
    found = table.assign(
        lane_number=np.repeat(np.arange(lanes.lane_count), count),
        engine=response.engine,
        reference=reference.engine,
        block=np.tile(np.arange(1, count + 1), lanes.lane_count),
        status=np.repeat(names_of(Status, response["status"]), count),
        outcome=np.repeat(names_of(Outcome, response["outcome"]), count),
        peak_rotation_ratio=response["peak_rotation"].ravel() / slenderness.ravel(),
        reference_peak_rotation_ratio=reference["peak_rotation"].ravel() / slenderness.ravel(),
        difference_5s_ratio=early.ravel(),
        difference_run_ratio=whole.ravel(),
        peak_slide_mm=1e3 * response["peak_slide"].ravel(),
    )
    if not lanes.spatial:
        return found
    across, _ = _history_differences(response, reference, slenderness, "rotation_across")
    yaw, _ = _history_differences(response, reference, np.ones_like(slenderness), "yaw")
    return found.assign(
        difference_across_5s_ratio=across.ravel(),
        difference_yaw_5s_rad=yaw.ravel(),
        peak_tilt_ratio=response["peak_tilt"].ravel() / slenderness.ravel(),
        peak_yaw_rad=response["peak_yaw"].ravel(),
    )


def _history_differences(
    response: Response, reference: Response, scale: Array, name: str = "rotation"
) -> tuple[Array, Array]:
    """Largest |difference| of a history / scale early and over the run, shape [lane, block].

    A lane is compared until one of its blocks has fallen in either response: there it ends.
    """
    if not ("rotation" in response.fields and "rotation" in reference.fields):
        nothing = np.full_like(scale, np.nan)
        return nothing, nothing

    def history(answer: Response, field: str) -> Array:
        return np.asarray(answer[field].reshape(*scale.shape, -1))

    turned = [np.abs(history(answer, "rotation")) for answer in (response, reference)]
    fallen = np.maximum(*turned).max(axis=1) >= 0.5 * np.pi - 1e-6
    standing = (np.cumsum(fallen, axis=1) == 0)[:, None, :]
    gap = np.abs(history(response, name) - history(reference, name))
    difference = np.where(standing, gap, 0.0) / scale[:, :, None]
    early = response.times <= EARLY_TIME + 1e-9
    return difference[:, :, early].max(axis=2), difference.max(axis=2)
