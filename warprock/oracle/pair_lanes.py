"""The two-block oracle for a batch of lanes, lane by lane, answered as an engine answers."""

from __future__ import annotations

from typing import cast

import numpy as np
import numpy.typing as npt

from warprock.model.lanes import Lanes
from warprock.model.motion import GroundMotions, SpatialMotions, UprightMotions
from warprock.model.response import INTEGER_FIELDS, LANE_FIELDS, Outcome, Response, SampleTimes
from warprock.oracle.pair import TwoBlockResponse, rock_two_blocks
from warprock.oracle.pair_mechanics import REST, Pair, TwoBlocks
from warprock.oracle.pair_swings import StackOutcome

ORACLE = "oracle"


def why_not(lanes: Lanes) -> str | None:
    """Why the two-block oracle cannot run lanes; None if it can."""
    if lanes.block_count != 2:
        return f"the oracle of stacks has two blocks, the case has {lanes.block_count}"
    if lanes.offset.any():
        return "the oracle of stacks needs the upper block above the centre of the lower one"
    return None


def two_block_response(lanes: Lanes, motions: GroundMotions, times: SampleTimes) -> Response:
    """Runs every lane with `rock_two_blocks`.

    Args:
        lanes: Stacks of two centred blocks; see `why_not`.
        motions: Ground motions of the same lanes.
        times: Duration and sampling.

    Returns:
        Every lane field; slides and penetrations are zero by the model, `step_count` counts
        evaluations of the equations of motion.
    """
    assert not isinstance(motions, SpatialMotions | UprightMotions)
    answers = [
        rock_two_blocks(
            _two_blocks(lanes, lane),
            motions.segments(lane),
            times,
            rotation_start=cast("Pair", tuple(lanes.rotation_start[lane])),
        )
        for lane in range(lanes.lane_count)
    ]
    still = np.zeros((len(answers), 2))
    rows: dict[str, npt.ArrayLike] = {
        "peak_rotation": [a.peak_rotation for a in answers],
        "peak_time": [a.peak_time for a in answers],
        "outcome": [_outcome(a) for a in answers],
        "status": [a.status for a in answers],
        "impact_count": [len(a.impact_times) for a in answers],
        "uplift_time": [_uplift_time(a) for a in answers],
        "rest_time": [a.rest_time for a in answers],
        "residual_slide": still,
        "peak_slide": still,
        "peak_penetration": [0.0] * len(answers),
        "energy_lost": [a.energy_lost for a in answers],
        "step_count": [a.evaluation_count for a in answers],
    }
    fields: dict[str, npt.NDArray[np.generic]] = {
        name: np.array(rows[name], np.int64 if name in INTEGER_FIELDS else np.float64)
        for name in LANE_FIELDS
    }
    if times.interval is None:
        return Response(ORACLE, fields, np.empty(0))
    fields["rotation"] = np.array([a.rotation for a in answers])
    return Response(ORACLE, fields, times.times)


def _two_blocks(lanes: Lanes, lane: int) -> TwoBlocks:
    names = ("width", "height", "depth", "density", "chamfer")
    return TwoBlocks(**{name: cast("Pair", tuple(getattr(lanes, name)[lane])) for name in names})


def _outcome(answer: TwoBlockResponse) -> Outcome:
    fallen = answer.outcome in (StackOutcome.UPPER_OVERTURNED, StackOutcome.LOWER_OVERTURNED)
    if fallen:
        return Outcome.OVERTURNED
    return Outcome.AT_REST if answer.outcome is StackOutcome.AT_REST else Outcome.ROCKING


def _uplift_time(answer: TwoBlockResponse) -> float:
    """First time at which a block has left its face [s]; NaN if never."""
    moving = [
        time
        for time, pattern in zip(answer.pattern_times, answer.patterns, strict=True)
        if tuple(pattern) != REST
    ]
    return float(moving[0]) if moving else float("nan")
