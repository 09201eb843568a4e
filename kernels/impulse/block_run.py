"""Runs of the impulse step over lanes, LANES lanes a thread: a pack on the CPU, one on any device.

A block rocks while one of its corners has parted from the base, see parting.py.

With one lane a thread the same text is the plain form.
"""

import warp as wp

from warprock.kernels.algebra.vectors import ALONG, ONLY, UPWARDS
from warprock.kernels.contact.parting import Bearing, Parting, observe_ends
from warprock.kernels.impulse.block import Block, Impulses, Knobs, step
from warprock.kernels.lane.account import Account, keep_account
from warprock.kernels.lane.modes import RUNNING
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
def share_of(lean: real, knobs: Knobs) -> real:
    """First guess of a corner's impulse, a share of half a step of gravity; lean > 0 is to it."""
    share = wp.where(lean > real(0.0), HALF, wp.where(lean < real(0.0), real(0.0), real(0.25)))
    return share * knobs.time_step * knobs.gravity


@wp.func
def start(block: Block, knobs: Knobs, theta: real):
    """State of a block at its start, and first guesses of the impulses of its corners."""
    zero = real(0.0)
    x, z = -slide_of(block, zero, theta), height_of(block, theta)
    fall = HALF * knobs.time_step * knobs.gravity
    state = State(x, z, theta, zero, fall, zero)
    return state, Impulses(share_of(-theta, knobs), zero, share_of(theta, knobs), zero)


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
    impulses = rows(Impulses)
    base = rows(Base)
    account = rows(Account)
    parting = rows(Parting)
    peaks = rows(Peaks)
    seen = rows(Seen)
    for i in range(LANES):
        theta = starts[first + i]
        after, pushed = start(blocks[first + i], knobs, theta)
        state[i] = after
        impulses[i] = pushed
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
            for i in range(LANES):
                m = motions[first + i]
                # Field by field: four float32 loaded at once would keep the loop scalar.
                block = Block()
                block.half_width = blocks[first + i].half_width
                block.half_height = blocks[first + i].half_height
                block.inverse_inertia = blocks[first + i].inverse_inertia
                block.friction = blocks[first + i].friction
                moving = base_velocity(m, half, pool)
                dv = moving - base[i].vx
                loss = account[i].loss
                after, pushed, gaps = step(block, knobs, dv, state[i], impulses[i], loss)
                slide = slide_of(block, after.x, after.theta)
                ends, sees = parting[i], seen[i]
                live = sees.mode == RUNNING
                peaks[i] = observe_peaks(live, time, after.theta, slide, peaks[i])
                observe_ends(
                    live, time, limit_of(block, knobs, after.omega),
                    glides(block, knobs, after.vx, after.omega),
                    Bearing(pushed.n1, gaps.left), Bearing(pushed.n2, gaps.right), ends, sees,
                )  # fmt: skip
                mode = mode_of(RUNNING, after.theta, after.omega, slide)
                observe_lane(live, mode, -gaps.lowest, sees)
                parting[i] = ends
                seen[i] = sees
                work = HALF * dv * (state[i].vx + after.vx)
                account[i].work = account[i].work - wp.where(live, work, real(0.0))
                account[i].loss = wp.where(live, loss, account[i].loss)
                account[i] = keep_account(dv, account[i])
                base[i].vx = moving
                state[i] = wp.where(live, after, state[i])
                impulses[i] = wp.where(live, pushed, impulses[i])
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
