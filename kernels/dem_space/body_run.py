"""Runs of the soft-spring step over bodies in space that stand on points, LANES lanes a thread.

As dem_space/stack_run.py: every lane has its own time step, and a pack goes on until the last of
its lanes has reached the next sample.
"""

import warp as wp

from warprock.kernels.dem.stack import Knobs
from warprock.kernels.dem.stack_lanes import passes_left, time_past
from warprock.kernels.dem_space.body import (
    Lane,
    add_point,
    find_lever,
    frame_of,
    keep_point,
    observe_body,
    observe_points,
    pose_before,
    solve_point,
    start_body,
    turn_body,
)
from warprock.kernels.dem_space.stack import integrate
from warprock.kernels.dem_space.stack_rows import begin_step, move_base
from warprock.kernels.instance import ONE_VECTOR
from warprock.kernels.motion import Motion, base_velocity, sample_index, sample_segment
from warprock.kernels.shape_space.block import Block
from warprock.kernels.shape_space.block_found import BlockResult, Found, Result
from warprock.kernels.shape_space.body import MOST_POINTS, Point, block_attitude, throw_of
from warprock.kernels.shape_space.thrown import push, tumble_on

wp.set_module_options(ONE_VECTOR)

R = wp.types.vector(length=LANES, dtype=real)
"""A number a lane."""
Count = wp.types.vector(length=LANES, dtype=int)
Three = wp.types.matrix(shape=(3, LANES), dtype=real)
P = wp.types.matrix(shape=(MOST_POINTS + 1, LANES), dtype=real)
"""A number a point; an odd number of rows, as in impulse_space/body_run.py."""


@wp.kernel
def run_lanes(
    blocks: wp.array2d(dtype=Block), lanes: wp.array(dtype=Lane),
    points: wp.array2d(dtype=Point), motions: wp.array2d(dtype=Motion),
    pool: wp.array2d(dtype=real), sample_times: wp.array(dtype=real), knobs: Knobs, found: Found,
):  # fmt: skip
    """Runs LANES lanes a thread, each at its own time."""
    x, y, z, qx, qy, qz, qw, vx, vy, vz = R(), R(), R(), R(), R(), R(), R(), R(), R(), R()
    lx, ly, lz, fx, fy, fz, mx, my, mz, at = R(), R(), R(), R(), R(), R(), R(), R(), R(), R()
    r11, r12, r13, r21, r22, r23, r31, r32, r33 = R(), R(), R(), R(), R(), R(), R(), R(), R()
    ox, oy, oz, lowest, since, gx, gy, slide = R(), R(), R(), R(), R(), R(), R(), R()
    peak, across, tilt, yaw, dt, span, loss, spent = R(), R(), R(), R(), R(), R(), R(), R()
    stored, at_start, lifted, moved, deepest, count = R(), R(), R(), R(), R(), R()
    sx, sy, xx, xy, yy, middle, deep, fastest = R(), R(), R(), R(), R(), R(), R(), R()
    touching, way_x, way_y, far, live, impacts = R(), R(), R(), R(), Count(), Count()
    mode, steps, base, dv, ux, uy = Count(), Count(), Three(), Three(), P(), P()
    slip, px, py, pz, stood_x, stood_y, foot = P(), P(), P(), P(), P(), P(), P()
    rx, ry, rz = P(), P(), P()
    pack, _one = wp.tid()
    rows, first = points.shape[0], pack * LANES
    for i in range(LANES):
        start_body(
            blocks[0, first + i], lanes[first + i], x[i], y[i], z[i], qx[i], qy[i],
             qz[i], qw[i], since[i], peak[i], across[i], tilt[i], dt[i], lifted[i], mode[i],
        )  # fmt: skip
        block = blocks[0, first + i]
        push(throw_of(frame_of(lanes[first + i])), qx[i], qy[i], qz[i], qw[i], block.inverse_x,
            block.inverse_y, block.inverse_z, vx[i], vy[i], vz[i], lx[i], ly[i], lz[i])  # fmt: skip
    for c in range(rows):
        for i in range(LANES):
            keep_point(points[c, first + i], px[c, i], py[c, i], pz[c, i], stood_x[c, i],
                stood_y[c, i], foot[c, i])  # fmt: skip
    for sample in range(sample_times.shape[0]):
        passes, until = int(0), sample_times[sample]
        for i in range(LANES):
            passes = wp.max(passes, passes_left(until, steps[i], dt[i], mode[i]))
        for _ in range(passes):
            for i in range(LANES):
                begin_step(live[i], steps[i], dt[i], until, mode[i], loss[i], span[i], stored[i],
                    at_start[i], spent[i])  # fmt: skip
                for d in range(3):
                    mid = (real(steps[i]) - HALF) * dt[i]
                    way = motions[d, first + i]
                    place = sample_index(way, sample_segment(way, mid))
                    v = base_velocity(way, mid, pool[2, place], pool[0, place], pool[1, place])
                    move_base(v, live[i] == 1, base[d, i], dv[d, i])
                block = blocks[0, first + i]
                turn_body(
                    qx[i], qy[i], qz[i], qw[i], lx[i], ly[i], lz[i], block.inverse_x,
                    block.inverse_y, block.inverse_z, r11[i], r12[i], r13[i], r21[i], r22[i],
                    r23[i], r31[i], r32[i], r33[i], ox[i], oy[i], oz[i], lowest[i],
                )  # fmt: skip
            for c in range(rows):
                for i in range(LANES):
                    find_lever(
                        foot[c, i] >= real(0.0), px[c, i], py[c, i], pz[c, i], r11[i], r12[i],
                        r13[i], r21[i], r22[i], r23[i], r31[i], r32[i], r33[i], rx[c, i], ry[c, i],
                        rz[c, i], lowest[i],
                    )  # fmt: skip
            for c in range(rows):
                for i in range(LANES):
                    block = blocks[0, first + i]
                    lane = lanes[first + i]
                    overlap = -(z[i] + (lane.height + rz[c, i]))
                    n, square = solve_point(
                        knobs, live[i] == 1, block.friction, dt[i], lane.area,
                        foot[c, i] >= real(0.0), overlap, rx[c, i], ry[c, i], rz[c, i], vx[i],
                        vy[i], vz[i], ox[i], oy[i], oz[i], ux[c, i], uy[c, i], slip[c, i], fx[i],
                        fy[i], fz[i], mx[i], my[i], mz[i], stored[i],
                    )  # fmt: skip
                    add_point(
                        foot[c, i], block.half_width, lowest[i], overlap, n, square, x[i], y[i],
                        rx[c, i], ry[c, i], rz[c, i], stood_x[c, i], stood_y[c, i], count[i], sx[i],
                        sy[i], xx[i], xy[i], yy[i], middle[i], deep[i], fastest[i], touching[i],
                        way_x[i], way_y[i],
                    )  # fmt: skip
            for i in range(LANES):
                observe_points(
                    live[i] == 1, real(steps[i] - 1) * dt[i], frame_of(lanes[first + i]),
                    lanes[first + i].creep, count[i], sx[i], sy[i], xx[i], xy[i], yy[i], middle[i],
                    deep[i], fastest[i], touching[i], way_x[i], way_y[i], since[i], lifted[i],
                    moved[i], deepest[i], impacts[i], mode[i], gx[i], gy[i], slide[i],
                )  # fmt: skip
                integrate(live[i] == 1, blocks[0, first + i], knobs, dt[i], span[i], dv[0, i],
                    dv[1, i], dv[2, i], x[i], y[i], z[i], qx[i], qy[i], qz[i], qw[i], vx[i], vy[i],
                    vz[i], lx[i], ly[i], lz[i], fx[i], fy[i], fz[i], mx[i], my[i], mz[i],
                    loss[i])  # fmt: skip
                observe_body(
                    live[i] == 1, real(steps[i]) * dt[i], blocks[0, first + i],
                    frame_of(lanes[first + i]), x[i] + y[i] + z[i] + gx[i] + gy[i], qx[i], qy[i],
                    qz[i], qw[i], peak[i], at[i], across[i], tilt[i], yaw[i], mode[i],
                )  # fmt: skip
                tumble_on(throw_of(frame_of(lanes[first + i])), blocks[0, first + i], x[i], y[i],
                    mode[i], gx[i], gy[i], slide[i], far[i])  # fmt: skip
        if found.attitudes.shape[0] > 0:
            for i in range(LANES):
                was = pose_before(blocks[0, first + i], frame_of(lanes[first + i]),
                    time_past(until, steps[i], dt[i], mode[i]), qx[i], qy[i], qz[i], qw[i], lx[i],
                    ly[i], lz[i], x[i], y[i], z[i], vx[i], vy[i], vz[i])  # fmt: skip
                for c in range(4):
                    found.attitudes[sample, 0, c, first + i] = was[c]
                for c in range(4, wp.where(found.places.shape[0] > 0, 7, 4)):
                    found.places[sample, 0, c - 4, first + i] = was[c]
    for i in range(LANES):
        lost = spent[i] - (stored[i] - at_start[i])
        found.results[first + i] = Result(lifted[i], moved[i], lost, deepest[i], impacts[i],
            mode[i], steps[i])  # fmt: skip
        _a, _b, tz, tw = block_attitude(frame_of(lanes[first + i]), qx[i], qy[i], qz[i], qw[i])
        found.blocks[0, first + i] = BlockResult(tz, tw, gx[i], gy[i], peak[i], at[i], across[i],
            tilt[i], yaw[i], slide[i])  # fmt: skip
