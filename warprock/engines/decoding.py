"""What the results of kernels that step through time mean, the same of all such engines."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from warprock.engines.launching import time_or_nan
from warprock.kernels.modes import BROKEN, OVERTURNED, SLID_OFF
from warprock.model.response import Outcome, Status

Mask = npt.NDArray[np.bool_]


def lane_fields(
    rows: npt.NDArray[Any],
    still_since: npt.NDArray[np.float64] | float,
    marks: Sequence[tuple[Mask, Status]],
) -> dict[str, npt.NDArray[Any]]:
    """Lane fields from the results of a kernel, all but those that blocks of their own have.

    Args:
        rows: Rows of its `Result`, shape [lane].
        still_since: A lane that has not moved since then [s] is at rest at the end.
        marks: Statuses besides `NONFINITE` and where they hold, shape [lane]; the first one counts.
    """
    mode = rows["mode"]
    moved = np.asarray(rows["moved"], dtype=np.float64)
    resting = (mode < OVERTURNED) & (moved < still_since)
    where = [mode == BROKEN, *(mask for mask, _ in marks)]
    statuses = [Status.NONFINITE, *(status for _, status in marks)]
    return {
        "outcome": np.select(
            [mode == OVERTURNED, mode == SLID_OFF, resting],
            [Outcome.OVERTURNED, Outcome.SLID_OFF, Outcome.AT_REST],
            Outcome.ROCKING,
        ),
        "status": np.select(where, statuses, Status.OK),
        "impact_count": rows["impacts"],
        "uplift_time": time_or_nan(rows["uplift_time"]),
        "rest_time": np.where(resting, moved, np.nan),
        "peak_penetration": rows["deepest"],
        "energy_lost": rows["loss"],
        "step_count": rows["steps"],
    }


def planar_fields(per_block: npt.NDArray[Any]) -> dict[str, npt.NDArray[Any]]:
    """Fields of blocks in the plane, shape [lane, block] each; [lane] of single blocks."""
    return {
        "peak_rotation": per_block["peak"],
        "peak_time": per_block["peak_time"],
        "residual_slide": per_block["slide"],
        "peak_slide": per_block["peak_slide"],
    }
