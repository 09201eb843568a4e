"""Runs of the direct step over lanes, LANES lanes a thread: a pack on the CPU, one on any device.

A block rocks while one of its corners has parted from the base, see parting.py. A flat block
starts at rest on its springs, a leaning one with its corner at the base.

With one lane a thread the same text is the plain form.
"""

import warp as wp

from warprock.kernels.algebra.vectors import ALONG, ONLY, UPWARDS
from warprock.kernels.contact.parting import Bearing, Parting, observe_ends
from warprock.kernels.direct.block import Block, Carried, Knobs, step
from warprock.kernels.lane.account import Account, keep_account
from warprock.kernels.lane.modes import BROKEN, RUNNING, UNSOLVED
from warprock.kernels.launch.rows import kernel, rows
from warprock.kernels.motion.kinds import Motion, base_velocity
from warprock.kernels.shape.block import (
    Base,
    State,
    glides,
    height_of,
    limit_of,
    mode_of,
    slide_of,
)
from warprock.kernels.shape.stack_found import (
    Found,
    Peaks,
    Seen,
    at_sample,
    block_result,
    observe_lane,
    observe_peaks,
    result_of,
    start_peaks,
    start_seen,
)


@wp.func
def start(block: Block, knobs: Knobs, theta: real):
    """State of a block at its start, and the impulses of its corners in the step before.

    Velocities are those of half a step before the start: zero, or those of the coming fall.
    """
    zero = real(0.0)
    flat = theta == zero
    fall = knobs.time_step * knobs.gravity
    sunk = wp.where(flat, HALF * knobs.gravity / block.stiffness, zero)
    x, z = -slide_of(block, zero, theta), height_of(block, theta) - sunk
    state = State(x, z, theta, zero, wp.where(flat, zero, HALF * fall), zero)
    return state, Carried(
        wp.where(flat, HALF * fall, wp.where(theta < zero, fall, zero)),
        wp.where(flat, HALF * fall, wp.where(theta > zero, fall, zero)),
    )


@wp.func
def before_start(k: int) -> real:
    """Weight of the starting velocity in the contact work: 1/2 in step 1, then 0.

    The contact work of a step uses the mean of the velocities before and after it. The velocity
    before step 1 is only the fall of half a step, see `start`.
    """
    return wp.where(k == 1, HALF, real(0.0))


@kernel
def run_lanes(
    blocks: wp.array(dtype=Block), motions: wp.array(dtype=Motion), pool: wp.array2d(dtype=real),
    starts: wp.array(dtype=real), sample_times: wp.array(dtype=real), knobs: Knobs, found: Found,
):  # fmt: skip
    """Runs LANES lanes a thread, all at the same time."""
    first = wp.tid() * LANES
    # By names of their own: read off the struct they would keep the loop over lanes scalar.
    results = found.results
    leaves = found.blocks
    rotations = found.rotations
    places = found.places
    state = rows(State)
    carried = rows(Carried)
    base = rows(Base)
    account = rows(Account)
    parting = rows(Parting)
    peaks = rows(Peaks)
    seen = rows(Seen)
    for i in range(LANES):
        theta = starts[first + i]
        after, bears = start(blocks[first + i], knobs, theta)
        state[i] = after
        carried[i] = bears
        peaks[i] = start_peaks(theta)
        seen[i] = start_seen(wp.where(theta == real(0.0), NEVER, real(0.0)))
    k = int(0)
    time = real(0.0)
    for sample in range(sample_times.shape[0]):
        until = sample_times[sample]
        while time < until:
            k += 1
            time = real(k) * knobs.time_step
            half = time - HALF * knobs.time_step
            early = before_start(k)
            for i in range(LANES):
                m = motions[first + i]
                # Field by field: four float32 loaded at once would keep the loop scalar.
                block = Block()
                block.half_width = blocks[first + i].half_width
                block.half_height = blocks[first + i].half_height
                block.inverse_inertia = blocks[first + i].inverse_inertia
                block.friction = blocks[first + i].friction
                block.cfm = blocks[first + i].cfm
                block.erp = blocks[first + i].erp
                moving = base_velocity(m, half, pool)
                dv = moving - base[i].vx
                loss = account[i].loss
                after, bears, gaps, miss = step(block, knobs, dv, state[i], carried[i], loss)
                loss = loss + early * state[i].vz * (bears.n1 + bears.n2)
                slide = slide_of(block, after.x, after.theta)
                ends, sees = parting[i], seen[i]
                live = sees.mode == RUNNING
                peaks[i] = observe_peaks(live, time, after.theta, slide, peaks[i])
                observe_ends(
                    live, time, limit_of(block, knobs, after.omega),
                    glides(block, knobs, after.vx, after.omega),
                    Bearing(bears.n1, gaps.left), Bearing(bears.n2, gaps.right), ends, sees,
                )  # fmt: skip
                mode = mode_of(RUNNING, after.theta, after.omega, slide)
                mode = wp.where(miss > real(0.0) and mode != BROKEN, UNSOLVED, mode)
                observe_lane(live, mode, -gaps.lowest, sees)
                parting[i] = ends
                seen[i] = sees
                work = HALF * dv * (state[i].vx + after.vx)
                account[i].work = account[i].work - wp.where(live, work, real(0.0))
                account[i].loss = wp.where(live, loss, account[i].loss)
                account[i] = keep_account(dv, account[i])
                base[i].vx = moving
                state[i] = wp.where(live, after, state[i])
                carried[i] = wp.where(live, bears, carried[i])
        past = time - until
        if rotations.shape[0] > 0:
            for i in range(LANES):
                mode = seen[i].mode
                rotations[sample, ONLY, first + i] = at_sample(
                    mode, past, state[i].theta, state[i].omega
                )
        if places.shape[0] > 0:
            for i in range(LANES):
                mode = seen[i].mode
                places[sample, ONLY, ALONG, first + i] = at_sample(
                    mode, past, state[i].x, state[i].vx
                )
                places[sample, ONLY, UPWARDS, first + i] = at_sample(
                    mode, past, state[i].z, state[i].vz
                )
    for i in range(LANES):
        results[first + i] = result_of(seen[i], account[i])
        slide = slide_of(blocks[first + i], state[i].x, state[i].theta)
        leaves[0, first + i] = block_result(slide, peaks[i])
