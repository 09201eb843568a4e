"""Runs of the soft-spring step over blocks in space: LANES stacks a thread, side by side.

A single block is a stack of one. Every lane has its own time step, and with it its own number of
steps; a pack goes on until the last of its lanes has reached the next sample.

Loops over the lanes are innermost, so that the compiler turns them into vector code; with one lane
a thread the same text is the plain form for any device.

An interface has parted once its faces gape from the middle to three quarters of the way to the
corner that is pressed most, see `PIVOT` of dem/stack_lanes.py; in the plane that is an end. It
slides while it is closed in the middle and slips faster than springs swing that stick.
"""

import warp as wp

from warprock.kernels.algebra.vectors import X, Y, Z
from warprock.kernels.dem.stack import Energy, Knobs
from warprock.kernels.dem.stack_lanes import passes_left, time_past
from warprock.kernels.dem_space.stack import (
    Jolt,
    Load,
    Pace,
    Pair,
    Spring,
    Sums,
    add_pair,
    add_sums,
    integrate,
    load_blocks,
    solve_point,
)
from warprock.kernels.dem_space.stack_lanes import (
    Base,
    Lane,
    begin_step,
    move_base,
    observe_block,
    observe_interface,
    pose_before,
    result_of,
    start_block,
)
from warprock.kernels.dem_space.stack_meet import Link, find_contacts
from warprock.kernels.launch.instance import ONE_VECTOR
from warprock.kernels.launch.rows import kernel, rows
from warprock.kernels.motion.kinds import Motion, base_velocity
from warprock.kernels.shape.interface import GROUND
from warprock.kernels.shape.stack_found import Seen, start_seen
from warprock.kernels.shape_space.block import Block
from warprock.kernels.shape_space.block_found import Found, Peaks, block_result
from warprock.kernels.shape_space.lanes import State

wp.set_module_options(ONE_VECTOR)

PAIRS = max(ITERATIONS, 1)
"""Pairs of points of an interface; one in the middle counts as a pair of two halves."""
ALONG_X, ALONG_Y, SHARE, KIND = 0, 1, 2, 3
"""Rows of the points: a and b of `Pair`, its share of the area, and its kind."""
ON_AXES, DIAGONAL, OTHER_DIAGONAL = 0, 1, 2
"""Kinds of pairs, by where they lie."""
KINDS = 3
"""Number of kinds: what is summed over each, see `Sums`, is summed apart."""

Numbers = wp.types.matrix(shape=(BLOCKS + 1, LANES), dtype=real)
"""One number a body, the ground first."""


@kernel
def run_lanes(
    blocks: wp.array2d(dtype=Block), motions: wp.array2d(dtype=Motion),
    pool: wp.array2d(dtype=real), sample_times: wp.array(dtype=real), lanes: wp.array(dtype=Lane),
    points: wp.array2d(dtype=real), knobs: Knobs, found: Found,
):  # fmt: skip
    """Runs LANES lanes a thread, each at its own time; rows of points: a, b, share, kind."""
    # Of bodies, the ground first.
    block = rows(Block, BLOCKS + 1)
    state = rows(State, BLOCKS + 1)
    load = rows(Load, BLOCKS + 1)
    peaks = rows(Peaks, BLOCKS + 1)
    since = Numbers()
    # Of pairs: springs of the points at -(a, b) and at (a, b).
    one = rows(Spring, BLOCKS * PAIRS)
    two = rows(Spring, BLOCKS * PAIRS)
    sums = rows(Sums, KINDS)
    base = rows(Base, 3)
    contact = rows(Link)
    pace = rows(Pace)
    energy = rows(Energy)
    seen = rows(Seen)
    pack, _one = wp.tid()
    bodies, pairs, first, moves = int(BLOCKS + 1), int(PAIRS), pack * LANES, int(0)  # loops stay
    for i in range(LANES):
        # The ground is level.
        state[GROUND, i].qw = real(1.0)
        pace[i].dt = lanes[first + i].time_step
        pace[i].creep = lanes[first + i].creep
        seen[i] = start_seen(lanes[first + i].uplift_time)
        moves = moves | lanes[first + i].moves
        for k in range(bodies):
            block[k, i] = blocks[k, first + i]
        for k in range(1, bodies):
            s0, p0 = start_block(block[k, i])
            state[k, i] = s0
            peaks[k, i] = p0
            since[k, i] = NEVER
    for sample in range(sample_times.shape[0]):
        passes, until = int(0), sample_times[sample]
        for i in range(LANES):
            left = passes_left(until, pace[i].steps, pace[i].dt, seen[i].mode)
            passes = wp.max(passes, left)
        for _ in range(passes):
            for i in range(LANES):
                way, spent = pace[i], energy[i]
                begin_step(until, seen[i].mode, way, spent)
                pace[i] = way
                energy[i] = spent
            for d in range(3):
                if (moves >> d) % 2 == 1:
                    for i in range(LANES):
                        mid = (real(pace[i].steps) - HALF) * pace[i].dt
                        m = motions[d, first + i]
                        v = base_velocity(m, mid, pool)
                        base[d, i] = move_base(v, pace[i].live, base[d, i])
            for k in range(1, bodies):
                h = k - 1
                for i in range(LANES):
                    link, slide_x, slide_y = find_contacts(
                        block[k, i], block[h, i], state[k, i], state[h, i]
                    )
                    contact[i] = link
                    peaks[k, i].slide_x = slide_x
                    peaks[k, i].slide_y = slide_y
                    sees = seen[i]
                    observe_interface(pace[i], link, since[k, i], sees)
                    seen[i] = sees
                for p in range(pairs):
                    kind, q = int(points[KIND, p]), pairs * h + p
                    pair = Pair(points[ALONG_X, p], points[ALONG_Y, p], points[SHARE, p])
                    for i in range(LANES):
                        near = one[q, i]
                        borne = solve_point(knobs, contact[i], pace[i], -pair.a, -pair.b, near)
                        one[q, i] = near
                        far = two[q, i]
                        there = solve_point(knobs, contact[i], pace[i], pair.a, pair.b, far)
                        two[q, i] = far
                        total = sums[kind, i]
                        add_pair(contact[i], pair, borne, there, total)
                        sums[kind, i] = total
                for i in range(LANES):
                    stress_sums = add_sums(
                        sums[ON_AXES, i], sums[DIAGONAL, i], sums[OTHER_DIAGONAL, i]
                    )
                    above, below = load[k, i], load[h, i]
                    held = load_blocks(state[h, i], contact[i], stress_sums, above, below)
                    load[k, i] = above
                    load[h, i] = below
                    energy[i].stored = energy[i].stored + wp.where(
                        pace[i].live == 1, held, real(0.0)
                    )
                    for kind in range(KINDS):
                        sums[kind, i] = Sums()
            for k in range(1, bodies):
                for i in range(LANES):
                    jolt = Jolt(base[X, i].dv, base[Y, i].dv, base[Z, i].dv)
                    s = state[k, i]
                    integrate(pace[i], block[k, i], knobs, jolt, load[k, i], s, energy[i].loss)
                    state[k, i] = s
                    load[k, i] = Load()
                    tops = peaks[k, i]
                    seen[i].mode = observe_block(pace[i], block[k, i], s, tops, seen[i].mode)
                    peaks[k, i] = tops
        if found.attitudes.shape[0] > 0:
            for k in range(1, bodies):
                for i in range(LANES):
                    past = time_past(until, pace[i].steps, pace[i].dt, seen[i].mode)
                    was = pose_before(block[k, i], past, state[k, i])
                    for c in range(4):
                        found.attitudes[sample, k, c, first + i] = was[c]
                    for c in range(4, wp.where(found.places.shape[0] > 0, 7, 4)):
                        found.places[sample, k, c - 4, first + i] = was[c]
    for i in range(LANES):
        found.results[first + i] = result_of(seen[i], energy[i], pace[i].steps)
        for k in range(1, bodies):
            found.blocks[k, first + i] = block_result(state[k, i].qz, state[k, i].qw, peaks[k, i])
