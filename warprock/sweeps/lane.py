"""One lane of a sweep as a run of its own, to be looked at."""

from __future__ import annotations

import time

from warprock.case.lanes import expand_lanes
from warprock.model.response import SampleTimes
from warprock.running.case_run import CaseRun, require_options, run_lane_set
from warprock.sweeps.plan import Plan


def run_of_lane(plan: Plan, lane: int) -> CaseRun:
    """A lane of a sweep, run again: its numbers are those that its chunk has.

    Args:
        plan: The plan of the sweep.
        lane: Number of the lane, from 0; it is the first and only lane of the run.

    Raises:
        InputError: An option of the plan is not to be had here, such as its device.
    """
    case, options = plan.case, plan.options(None, None)
    require_options(plan.engine, options)
    lane_set = expand_lanes(case, range(lane, lane + 1))
    settings = case.engine_settings(plan.engine)
    times = SampleTimes(lane_set.times.duration)
    started = time.perf_counter()
    response = run_lane_set(plan.engine, lane_set, times, options, settings=settings)
    took = time.perf_counter() - started
    return CaseRun(case, lane_set, response, options, settings, took)
