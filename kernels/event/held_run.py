"""Runs of held blocks that may slide over lanes, a lane a thread.

Rotation and place at a sample inside a step are read off the polynomials that the step follows, so
that histories do not change the run.
"""

import warp as wp

from warprock.kernels.algebra.vectors import ALONG, ONLY, UPWARDS
from warprock.kernels.contact.ties import BROKEN_TIE, YIELDING, YIELDING_BACK, Tie, TieState
from warprock.kernels.event.held.events import change_tie
from warprock.kernels.event.held.path import Held, stretch_of, tie_of
from warprock.kernels.event.held.state import Block, slide_of
from warprock.kernels.event.held.step import start_lane, step
from warprock.kernels.lane.modes import OVERTURNED, STALLED
from warprock.kernels.launch.instance import BRANCHES
from warprock.kernels.launch.rows import kernel
from warprock.kernels.motion.kinds import Motion, ground_at
from warprock.kernels.motion.series import value_of
from warprock.kernels.shape.stack_found import BlockResult

LANES = 1

wp.set_module_options(BRANCHES)


@wp.struct
class Result:
    """What one lane's run leaves behind; `tie_loss` in J, `broken` a number of ties."""

    uplift_time: real
    rest_time: real
    loss: real
    tie_loss: real
    force: real
    stretch: real
    break_time: real
    broken: int
    impacts: int
    mode: int
    steps: int


@wp.struct
class Found:
    """Where the answers go; `ties` is what the lanes work on."""

    results: wp.array(dtype=Result)
    blocks: wp.array2d(dtype=BlockResult)
    rotations: wp.array3d(dtype=real)
    places: wp.array4d(dtype=real)
    ties: wp.array2d(dtype=TieState)


@kernel
def run_lanes(
    blocks: wp.array(dtype=Block), ties: wp.array2d(dtype=Tie), motions: wp.array(dtype=Motion),
    pool: wp.array2d(dtype=real), starts: wp.array(dtype=real), rates: wp.array(dtype=real),
    sample_times: wp.array(dtype=real), found: Found,
):  # fmt: skip
    """Runs a lane a thread."""
    lane, _one = wp.tid()
    block = blocks[lane]
    m = motions[lane]
    held = Held(ties, found.ties, lane, real(1.0))
    s, seen = start_lane(block, starts[lane], rates[lane], held)
    count = sample_times.shape[0]
    end = sample_times[count - 1]
    sample = int(0)
    while s.mode < OVERTURNED and s.time < end:
        begun = real(s.time)
        ground = ground_at(m, s.segment, pool)
        path, side = step(block, held, m, ground, end, s, seen)
        while sample < count and sample_times[sample] < s.time:
            if sample_times[sample] >= begun:
                since = sample_times[sample] - begun
                if found.rotations.shape[0] > 0:
                    found.rotations[sample, ONLY, lane] = side * value_of(path.theta, since)
                if found.places.shape[0] > 0:
                    found.places[sample, ONLY, ALONG, lane] = side * value_of(path.x, since)
                    found.places[sample, ONLY, UPWARDS, lane] = value_of(path.z, since)
            sample = sample + 1
        if s.mode < OVERTURNED and seen.steps >= block.step_limit:
            s.mode = STALLED
    while sample < count:
        if found.rotations.shape[0] > 0:
            found.rotations[sample, ONLY, lane] = s.theta
        if found.places.shape[0] > 0:
            found.places[sample, ONLY, ALONG, lane] = s.x
            found.places[sample, ONLY, UPWARDS, lane] = s.z
        sample = sample + 1
    lost, broken = real(0.0), int(0)
    first = NEVER
    for i in range(ties.shape[0]):
        # A yielding that has not ended is weighed as if it ended now.
        if found.ties[i, lane].does == YIELDING:
            change_tie(held, i, -1, stretch_of(block, tie_of(held, i), s), s.time)
        if found.ties[i, lane].does == YIELDING_BACK:
            change_tie(held, i, 1, stretch_of(block, tie_of(held, i), s), s.time)
        lost = lost + found.ties[i, lane].lost
        first = smaller(found.ties[i, lane].broken, first)
        if found.ties[i, lane].does == BROKEN_TIE:
            broken = broken + 1
    found.results[lane] = Result(
        seen.uplift_time, seen.rest_time, seen.loss, lost, seen.force, seen.stretch, first, broken,
        seen.impacts, s.mode, seen.steps,
    )  # fmt: skip
    found.blocks[0, lane] = BlockResult(
        slide_of(block, s), seen.peak, seen.peak_time, seen.peak_slide
    )
