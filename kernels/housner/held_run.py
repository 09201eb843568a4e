"""Runs of blocks that something holds over lanes, a lane a thread."""

import warp as wp

from warprock.kernels.algebra.vectors import ONLY
from warprock.kernels.contact.ties import BROKEN_TIE, Load, Tie, TieState
from warprock.kernels.housner.block import stall
from warprock.kernels.housner.block_found import BlockResult
from warprock.kernels.housner.held import Block, TiesSeen, observe_ties, step
from warprock.kernels.housner.held_ties import Restraints, start_ties, unfinished_loss
from warprock.kernels.housner.lean import start_lane
from warprock.kernels.lane.modes import OVERTURNED
from warprock.kernels.launch.instance import BRANCHES
from warprock.kernels.launch.rows import kernel
from warprock.kernels.motion.kinds import Motion, ground_at

LANES = 1

wp.set_module_options(BRANCHES)


@wp.struct
class Result:
    """What one lane's run leaves behind; `tie_loss` in J, `broken` a number of ties."""

    uplift_time: real
    rest_time: real
    loss: real
    tie_loss: real
    needed: real
    force: real
    stretch: real
    break_time: real
    broken: int
    impacts: int
    mode: int
    steps: int


@wp.struct
class Found:
    """Arrays of results; `ties` holds the states of the ties, which the lanes update."""

    results: wp.array(dtype=Result)
    blocks: wp.array2d(dtype=BlockResult)
    rotations: wp.array3d(dtype=real)
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
    load = Load(
        block.load_weight, block.load_thrust, block.load_place, block.load_height, block.load_stays
    )
    held = Restraints(ties, found.ties, lane, block.half_width, block.inertia, load)
    s, seen = start_lane(starts[lane], rates[lane], block.wall)
    pulled = TiesSeen()
    start_ties(held, s.side, s.theta)
    observe_ties(held, s, pulled)
    for sample in range(sample_times.shape[0]):
        until = sample_times[sample]
        while s.mode < OVERTURNED and s.time < until:
            ground = ground_at(m, s.segment, pool)
            step(block, m, ground, until, held, s, seen, pulled)
            s.mode = stall(s.mode, seen.steps, block.step_limit)
        if found.rotations.shape[0] > 0:
            found.rotations[sample, ONLY, lane] = s.theta
    lost, broken = real(0.0), int(0)
    first = NEVER
    for i in range(ties.shape[0]):
        lost = lost + unfinished_loss(held, i, s.side, s.theta)
        first = smaller(found.ties[i, lane].broken, first)
        if found.ties[i, lane].does == BROKEN_TIE:
            broken = broken + 1
    found.results[lane] = Result(
        seen.uplift_time, seen.rest_time, seen.loss, lost, seen.needed, pulled.force,
        pulled.stretch, first, broken, seen.impacts, s.mode, seen.steps,
    )  # fmt: skip
    found.blocks[0, lane] = BlockResult(seen.peak, seen.peak_time)
