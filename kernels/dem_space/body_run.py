"""Runs of the soft-spring step over bodies in space that stand on points, LANES lanes a thread.

As dem_space/stack_run.py: every lane has its own time step, and a pack goes on until the last of
its lanes has reached the next sample.
"""

import warp as wp

from warprock.kernels.algebra.vectors import ONLY, X, Y, Z
from warprock.kernels.dem.stack import Energy, Knobs
from warprock.kernels.dem.stack_lanes import passes_left, time_past
from warprock.kernels.dem_space.body import (
    Footing,
    Footprint,
    Lane,
    Lever,
    Spin,
    add_force,
    add_point,
    find_lever,
    is_low,
    observe_body,
    observe_points,
    pose_before,
    solve_point,
    start_body,
    start_footprint,
    touch_of,
    turn_body,
)
from warprock.kernels.dem_space.stack import Jolt, Load, Pace, Spring, integrate
from warprock.kernels.dem_space.stack_lanes import (
    Base,
    begin_step,
    move_base,
    result_of,
)
from warprock.kernels.launch.instance import ONE_VECTOR
from warprock.kernels.launch.rows import kernel, rows
from warprock.kernels.motion.kinds import Motion, base_velocity
from warprock.kernels.shape.stack_found import Seen, start_seen
from warprock.kernels.shape_space.block import Block
from warprock.kernels.shape_space.block_found import Found, Peaks, block_result
from warprock.kernels.shape_space.body import MOST_POINTS, Frame, Point, block_attitude, throw_of
from warprock.kernels.shape_space.lanes import State, Turn
from warprock.kernels.shape_space.thrown import tumble_on

wp.set_module_options(ONE_VECTOR)


@wp.struct
class Low:
    """How a body lies.

    Attributes:
        lowest: Height of its lowest point from the centre of mass, in a step [m].
        way: Square of the largest way of its centre so far [m^2], see `tumble_on`.
        since: Time since which it gapes, see `observe_faces` [s].
    """

    lowest: real
    way: real
    since: real


@kernel
def run_lanes(
    blocks: wp.array2d(dtype=Block), lanes: wp.array(dtype=Lane),
    points: wp.array2d(dtype=Point), motions: wp.array2d(dtype=Motion),
    pool: wp.array2d(dtype=real), sample_times: wp.array(dtype=real), knobs: Knobs, found: Found,
):  # fmt: skip
    """Runs LANES lanes a thread, each at its own time."""
    block = rows(Block)
    frame = rows(Frame)
    state = rows(State)
    axes = rows(Turn)
    spin = rows(Spin)
    load = rows(Load)
    peaks = rows(Peaks)
    low = rows(Low)
    sums = rows(Footprint)
    base = rows(Base, 3)
    pace = rows(Pace)
    energy = rows(Energy)
    seen = rows(Seen)
    footing = rows(Footing)
    # Of points; an odd number of rows, as in impulse_space/body_run.py.
    point = rows(Point, MOST_POINTS + 1)
    spring = rows(Spring, MOST_POINTS + 1)
    lever = rows(Lever, MOST_POINTS + 1)
    pack, _one = wp.tid()
    count, first, moves = points.shape[0], pack * LANES, int(0)
    for i in range(LANES):
        block[i] = blocks[0, first + i]
        frame[i] = lanes[first + i].frame
        moves = moves | lanes[first + i].moves
        s0, p0 = start_body(block[i], frame[i])
        state[i] = s0
        peaks[i] = p0
        low[i].since = NEVER
        pace[i].dt = lanes[first + i].time_step
        pace[i].creep = lanes[first + i].creep
        footing[i] = Footing(
            lanes[first + i].height, lanes[first + i].area, block[i].friction, block[i].half_width
        )
        seen[i] = start_seen(lanes[first + i].uplift_time)
    for c in range(count):
        for i in range(LANES):
            point[c, i] = points[c, first + i]
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
            for i in range(LANES):
                turned, turns = turn_body(block[i], state[i])
                axes[i] = turned
                spin[i] = turns
                low[i].lowest = NEVER
                sums[i] = start_footprint()
            for c in range(count):
                for i in range(LANES):
                    r0 = find_lever(axes[i], point[c, i])
                    lever[c, i] = r0
                    lowest = low[i].lowest
                    there = point[c, i].foot >= real(0.0)
                    low[i].lowest = wp.where(there, smaller(lowest, r0.z), lowest)
            for c in range(count):
                for i in range(LANES):
                    touch = touch_of(footing[i].height, state[i], spin[i], lever[c, i])
                    bent, total, acts = spring[c, i], sums[i], load[i]
                    force = solve_point(
                        knobs, pace[i], footing[i].friction, footing[i].area,
                        point[c, i].foot >= real(0.0), touch, bent,
                    )  # fmt: skip
                    spring[c, i] = bent
                    add_force(force, lever[c, i], acts)
                    load[i] = acts
                    held = wp.where(pace[i].live == 1, HALF * force.energy, real(0.0))
                    energy[i].stored = energy[i].stored + held
                    wide = footing[i].half_width
                    near = is_low(point[c, i], lever[c, i], low[i].lowest, wide)
                    add_point(point[c, i], near, touch, force.n, state[i], lever[c, i], total)
                    sums[i] = total
            for i in range(LANES):
                tops, sees = peaks[i], seen[i]
                observe_points(pace[i], frame[i], sums[i], low[i].since, tops, sees)
                jolt = Jolt(base[X, i].dv, base[Y, i].dv, base[Z, i].dv)
                s = state[i]
                integrate(pace[i], block[i], knobs, jolt, load[i], s, energy[i].loss)
                state[i] = s
                load[i] = Load()
                sees.mode = observe_body(pace[i], block[i], frame[i], s, tops, sees.mode)
                seen[i] = sees
                peaks[i] = tumble_on(
                    throw_of(frame[i]), block[i], s, seen[i].mode, low[i].way, tops
                )
        if found.attitudes.shape[0] > 0:
            for i in range(LANES):
                past = time_past(until, pace[i].steps, pace[i].dt, seen[i].mode)
                was = pose_before(block[i], frame[i], past, state[i])
                for c in range(4):
                    found.attitudes[sample, ONLY, c, first + i] = was[c]
                for c in range(4, wp.where(found.places.shape[0] > 0, 7, 4)):
                    found.places[sample, ONLY, c - 4, first + i] = was[c]
    for i in range(LANES):
        found.results[first + i] = result_of(seen[i], energy[i], pace[i].steps)
        s = state[i]
        _a, _b, tz, tw = block_attitude(frame[i], s.qx, s.qy, s.qz, s.qw)
        found.blocks[0, first + i] = block_result(tz, tw, peaks[i])
