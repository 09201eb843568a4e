"""Runs of strips of wall over lanes, a lane a thread."""

import warp as wp

from warprock.kernels.algebra.vectors import ONLY
from warprock.kernels.housner.block import stall
from warprock.kernels.housner.block_found import BlockResult, Found, Result
from warprock.kernels.housner.lean import start_lane
from warprock.kernels.housner.strip import Strip, step
from warprock.kernels.lane.modes import OVERTURNED
from warprock.kernels.launch.instance import BRANCHES
from warprock.kernels.launch.rows import kernel
from warprock.kernels.motion.kinds import Motion, ground_at

LANES = 1

wp.set_module_options(BRANCHES)


@kernel
def run_lanes(
    blocks: wp.array(dtype=Strip), motions: wp.array(dtype=Motion), pool: wp.array2d(dtype=real),
    starts: wp.array(dtype=real), rates: wp.array(dtype=real), sample_times: wp.array(dtype=real),
    found: Found,
):  # fmt: skip
    """Runs a lane a thread."""
    lane, _one = wp.tid()
    strip = blocks[lane]
    m = motions[lane]
    s, seen = start_lane(starts[lane], rates[lane], real(0.0))
    for sample in range(sample_times.shape[0]):
        until = sample_times[sample]
        while s.mode < OVERTURNED and s.time < until:
            ground = ground_at(m, s.segment, pool)
            step(strip, m, ground, until, s, seen)
            s.mode = stall(s.mode, seen.steps, strip.step_limit)
        if found.rotations.shape[0] > 0:
            found.rotations[sample, ONLY, lane] = s.theta
    found.results[lane] = Result(
        seen.uplift_time, seen.rest_time, seen.loss, seen.needed, seen.impacts, s.mode, seen.steps
    )
    found.blocks[0, lane] = BlockResult(seen.peak, seen.peak_time)
