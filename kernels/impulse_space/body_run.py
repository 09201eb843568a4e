"""Runs of the impulse step over bodies in space that stand on points, LANES lanes a thread.

As impulse_space/block_run.py, with as many rows of points as the body with the most of them has.
"""

import warp as wp

from warprock.kernels.impulse_space.block import Knobs
from warprock.kernels.impulse_space.block_run import Attitude, attitude_to_store, move_base
from warprock.kernels.impulse_space.body_hold import ROUNDS
from warprock.kernels.impulse_space.body_lanes import (
    BASE,
    DEEPEST,
    DV,
    GOOD,
    IMPACTS,
    IX,
    IY,
    IZ,
    LOSS,
    LX,
    LY,
    LZ,
    MODE,
    MOVED,
    ON,
    PEAK,
    PEAK_ACROSS,
    PEAK_SLIDE,
    PEAK_TILT,
    PEAK_TIME,
    PEAK_YAW,
    QW,
    QX,
    QY,
    QZ,
    ROWS,
    SLIDE_X,
    SLIDE_Y,
    STEPS,
    UPLIFT_TIME,
    VX,
    VY,
    VZ,
    Marks,
    Numbers,
    Points,
    X,
    Y,
    Z,
    add_held_of_lane,
    add_pressure_of_lane,
    at,
    clear_middle,
    find_contact_of_lane,
    find_motion_of_lane,
    find_point_of_lane,
    find_turn_of_lane,
    integrate_lane,
    judge_lane,
    keep_lane,
    mark,
    predict_lane,
    share_lane,
    solve_lane,
    start_lane,
    start_point_of_lane,
    take_lane,
    tell_stance_of_lane,
    warm_start_lane,
)
from warprock.kernels.instance import ONE_VECTOR
from warprock.kernels.modes import RUNNING
from warprock.kernels.motion import Motion, base_velocity, sample_index, sample_segment
from warprock.kernels.shape_space.block import Block
from warprock.kernels.shape_space.block_found import BlockResult, Found, Result
from warprock.kernels.shape_space.body import Frame, Point, block_attitude

wp.set_module_options(ONE_VECTOR)

Counts = wp.types.vector(length=ROWS, dtype=int)


@wp.kernel
def run_lanes(
    blocks: wp.array2d(dtype=Block), frames: wp.array(dtype=Frame),
    points: wp.array2d(dtype=Point), motions: wp.array2d(dtype=Motion),
    pool: wp.array2d(dtype=real), sample_times: wp.array(dtype=real), knobs: Knobs, found: Found,
):  # fmt: skip
    """Runs LANES lanes a thread, all at the same time."""
    pack, _one = wp.tid()
    first, dt, zero, time = pack * LANES, knobs.time_step, real(0.0), real(0.0)
    m, p, k, busy = Numbers(), Points(), Marks(), Counts()
    rows, count = points.shape[0], int(0)
    for i in range(LANES):
        start_lane(blocks[0, first + i], frames[first + i], knobs, m, k, i)
    for c in range(rows):
        for i in range(LANES):
            start_point_of_lane(points[c, first + i], frames[first + i], knobs, p, c, i)
    for sample in range(sample_times.shape[0]):
        while time < sample_times[sample]:
            count += 1
            time, half = real(count) * dt, (real(count) - HALF) * dt
            for i in range(LANES):
                for d in range(3):
                    way = motions[d, first + i]
                    place = sample_index(way, sample_segment(way, half))
                    v = base_velocity(way, half, pool[2, place], pool[0, place], pool[1, place])
                    move_base(v, m[BASE + d, i], m[DV + d, i])
                predict_lane(knobs, m, i)
            for c in range(rows):
                for i in range(LANES):
                    find_point_of_lane(m, p, c, i)
            for c in range(rows):
                for i in range(LANES):
                    find_contact_of_lane(blocks[0, first + i], frames[first + i], knobs, m, p, c, i)
            for i in range(LANES):
                tell_stance_of_lane(time - dt, m, k, i)
            changes, turns = int(1), int(0)
            while changes > 0 and turns < ROUNDS:
                for i in range(LANES):
                    clear_middle(m, i)
                for c in range(rows):
                    for i in range(LANES):
                        add_held_of_lane(m, p, c, i)
                for i in range(LANES):
                    find_motion_of_lane(frames[first + i], m, i)
                for c in range(rows):
                    for i in range(LANES):
                        judge_lane(knobs, m, p, c, i)
                changes = int(0)
                for i in range(LANES):
                    changes += wp.where(at(m[GOOD, i]) > zero, 0, 1)
                turns += 1
            for c in range(rows):
                for i in range(LANES):
                    add_pressure_of_lane(m, p, c, i)
            for i in range(LANES):
                find_turn_of_lane(m, i)
            for c in range(rows):
                for i in range(LANES):
                    share_lane(knobs, m, p, c, i)
            for i in range(LANES):
                keep_lane(m, i)
            for c in range(rows):
                busy[c] = 0
                for i in range(LANES):
                    take_lane(m, p, c, i)
                    busy[c] += wp.where(at(p[ON + c, i]) > zero, 1, 0)
                if busy[c] > 0:
                    for i in range(LANES):
                        warm_start_lane(m, p, c, i)
            for step in range(knobs.sweeps * rows):
                c = step % rows
                if (step // rows) % 2 == 1:
                    c = rows - 1 - c
                if busy[c] > 0:
                    for i in range(LANES):
                        solve_lane(m, p, c, i)
            for i in range(LANES):
                integrate_lane(blocks[0, first + i], frames[first + i], knobs, time, m, k, i)
        past = time - sample_times[sample]
        for i in range(wp.where(found.attitudes.shape[0] > 0, LANES, 0)):
            q = attitude_to_store(mark(k[MODE, i]) == RUNNING, -past, m[QX, i], m[QY, i], m[QZ, i],
                m[QW, i], m[LX, i], m[LY, i], m[LZ, i], m[IX, i], m[IY, i], m[IZ, i])  # fmt: skip
            qx, qy, qz, qw = block_attitude(frames[first + i], q[0], q[1], q[2], q[3])
            e = Attitude(qx, qy, qz, qw)
            for d in range(4):
                found.attitudes[sample, 0, d, first + i] = e[d]
        for i in range(wp.where(found.places.shape[0] > 0, LANES, 0)):
            back = wp.where(mark(k[MODE, i]) == RUNNING, past, zero)
            found.places[sample, 0, 0, first + i] = m[X, i] - back * m[VX, i]
            found.places[sample, 0, 1, first + i] = m[Y, i] - back * m[VY, i]
            found.places[sample, 0, 2, first + i] = m[Z, i] - back * m[VZ, i]
    for i in range(LANES):
        found.results[first + i] = Result(m[UPLIFT_TIME, i], m[MOVED, i], m[LOSS, i], m[DEEPEST, i],
            k[IMPACTS, i], k[MODE, i], k[STEPS, i])  # fmt: skip
        _x, _y, tz, tw = block_attitude(frames[first + i], m[QX, i], m[QY, i], m[QZ, i], m[QW, i])
        found.blocks[0, first + i] = BlockResult(tz, tw, m[SLIDE_X, i], m[SLIDE_Y, i], m[PEAK, i],
            m[PEAK_TIME, i], m[PEAK_ACROSS, i], m[PEAK_TILT, i], m[PEAK_YAW, i],
            m[PEAK_SLIDE, i])  # fmt: skip
