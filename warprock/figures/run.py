"""All figures of a run: histories, peaks over the swept inputs, or distributions."""

from __future__ import annotations

import numpy as np

from warprock.figures.drawing import Drawing
from warprock.figures.ensemble import draw_cells
from warprock.figures.histories import choose_lanes, draw_histories
from warprock.figures.limit import draw_collapse
from warprock.figures.peaks import draw_peaks
from warprock.figures.restraints import draw_restraints
from warprock.figures.sample import draw_sample_peaks, sampled
from warprock.figures.space import draw_space
from warprock.model.response import take_lanes
from warprock.running.case_run import CaseRun, run_lanes


def draw_run(run: CaseRun) -> list[Drawing]:
    """Draws a run: its peaks, and histories where the case says how to sample them.

    Args:
        run: The run; of a case with an ensemble, its distributions are drawn instead.

    Returns:
        The drawings.
    """
    if run.case.ensemble is not None:
        return [draw_cells(run)]
    drawings = []
    if run.case.sample_times.interval is not None:
        shown = choose_lanes(run.case)
        response = run_lanes(run, [int(lane) for lane in shown.lanes.ravel()])
        drawings.append(draw_histories(run, shown, response))
        if run.lane_set.lanes.spatial and run.lane_set.lanes.assembly is None:
            firsts = np.arange(len(shown.lanes)) * shown.lanes.shape[1]
            first = take_lanes(response, firsts)
            drawings.append(draw_space(run, shown.lanes[:, 0], list(shown.panels), first))
        drawings += draw_restraints(run)
    if run.lane_set.lanes.assembly is not None:
        drawings += draw_collapse(run)
    draw = draw_sample_peaks if sampled(run.case) else draw_peaks
    if not run.lane_set.lanes.stacked:
        return [*drawings, draw(run)]
    return [*drawings, *(draw(run, block) for block in range(run.lane_set.lanes.block_count))]
