"""Runs of the impulse step over bodies in space that stand on points, LANES lanes a thread.

As impulse/space_run.py, with as many rows of points as the body with the most of them has.
"""

import warp as wp

from warprock.kernels.impulse.space import Knobs, integrate, solve_contact, warm_start
from warprock.kernels.impulse.space_body import (
    find_contact,
    find_point,
    glides,
    observe_body,
    predict,
    start_body,
    tell_stance,
)
from warprock.kernels.impulse.space_body_hold import (
    ROUNDS,
    add_held,
    add_pressure,
    find_motion,
    find_turn,
    judge,
    share,
)
from warprock.kernels.impulse.space_run import Attitude, attitude_to_store, move_base
from warprock.kernels.impulse.space_seen import observe_contacts
from warprock.kernels.instance import ONE_VECTOR
from warprock.kernels.modes import RUNNING
from warprock.kernels.motion import Motion, base_velocity, sample_index, sample_segment
from warprock.kernels.shape.space import Block
from warprock.kernels.shape.space_body import MOST_POINTS, Frame, Point, block_attitude
from warprock.kernels.shape.space_found import BlockResult, Found, Result

wp.set_module_options(ONE_VECTOR)

R = wp.types.vector(length=LANES, dtype=real)
"""A number a lane."""
LaneInt = wp.types.vector(length=LANES, dtype=int)
Three = wp.types.matrix(shape=(3, LANES), dtype=real)
ROWS = MOST_POINTS + 1
"""One more than there are: an even number would put the same point of all matrices in the same
places of the processor's cache, ten times slower."""
P = wp.types.matrix(shape=(ROWS, LANES), dtype=real)
"""A number a point."""
Counts = wp.types.vector(length=ROWS, dtype=int)


@wp.func
def start_point(
    point: Point, knobs: Knobs, frame: Frame, x: wp.ref[real], y: wp.ref[real], z: wp.ref[real],
    stood_x: wp.ref[real], stood_y: wp.ref[real], foot: wp.ref[real],
    n: wp.ref[real], apart: wp.ref[real],
):  # fmt: skip
    """Copies a point; the feet share the weight, the others count as parted."""
    x = point.x
    y = point.y
    z = point.z
    stood_x = point.stood_x
    stood_y = point.stood_y
    foot = point.foot
    touches = point.foot > real(0.0)
    n = wp.where(touches, HALF * knobs.time_step * knobs.gravity / frame.feet, real(0.0))
    apart = wp.where(touches, real(0.0), real(1.0))


@wp.func
def keep(
    good: bool, a: real, b: real, c: real, d: real, e: real, f: real,
    ux: wp.ref[real], uy: wp.ref[real], uz: wp.ref[real],
    ox: wp.ref[real], oy: wp.ref[real], oz: wp.ref[real],
    mx: wp.ref[real], my: wp.ref[real], mz: wp.ref[real],
    cx: wp.ref[real], cy: wp.ref[real], turn: wp.ref[real],
):  # fmt: skip
    """Writes the velocities of a body that is held; sums become zero for the next step."""
    ux = wp.where(good, a, ux)
    uy = wp.where(good, b, uy)
    uz = wp.where(good, c, uz)
    ox = wp.where(good, d, ox)
    oy = wp.where(good, e, oy)
    oz = wp.where(good, f, oz)
    mx = real(0.0)
    my = real(0.0)
    mz = real(0.0)
    cx = real(0.0)
    cy = real(0.0)
    turn = real(0.0)


@wp.func
def take(
    good: bool, a: real, b: real, c: real,
    fx: wp.ref[real], fy: wp.ref[real], n: wp.ref[real], on: wp.ref[real],
):  # fmt: skip
    """Writes the impulse of a point where its body is held: the sweeps then leave it alone."""
    fx = wp.where(good, a, fx)
    fy = wp.where(good, b, fy)
    n = wp.where(good, c, n)
    on = wp.where(good, real(0.0), on)


@wp.kernel
def run_lanes(
    blocks: wp.array2d(dtype=Block), frames: wp.array(dtype=Frame),
    points: wp.array2d(dtype=Point), motions: wp.array2d(dtype=Motion),
    pool: wp.array2d(dtype=real), sample_times: wp.array(dtype=real), knobs: Knobs, found: Found,
):  # fmt: skip
    """Runs LANES lanes a thread, all at the same time."""
    first, dt, zero, time = wp.tid() * LANES, knobs.time_step, real(0.0), real(0.0)
    x, y, z, qx, qy, qz, qw, vx, vy, vz = R(), R(), R(), R(), R(), R(), R(), R(), R(), R()
    lx, ly, lz, ux, uy, uz, ox, oy, oz = R(), R(), R(), R(), R(), R(), R(), R(), R()
    r11, r12, r13, r21, r22, r23, r31, r32, r33 = R(), R(), R(), R(), R(), R(), R(), R(), R()
    jxx, jxy, jxz, jyy, jyz, jzz, ix, iy, iz, mu = R(), R(), R(), R(), R(), R(), R(), R(), R(), R()
    lowest, deepest, landed, lifted, since, loss, moved = R(), R(), R(), R(), R(), R(), R()
    slide_x, slide_y, peak, peak_time, peak_across, peak_tilt = R(), R(), R(), R(), R(), R()
    peak_yaw, peak_slide, uplift_time, touching, way_x, way_y = R(), R(), R(), R(), R(), R()
    count, mx, my, mz, xx, xy, yy, zx, zy, t = R(), R(), R(), R(), R(), R(), R(), R(), R(), R()
    tx, ty, wx, wy, wz, sx = R(), R(), R(), R(), R(), R()
    sy, sz, ex, ey, ez = R(), R(), R(), R(), R()
    gz, push, bx, by, cx, cy, turn, good = R(), R(), R(), R(), R(), R(), R(), R()
    px, py, pz, stood_x, stood_y, foot = P(), P(), P(), P(), P(), P()
    rx, ry, rz, aim, on, held, apart, fx, fy, n = P(), P(), P(), P(), P(), P(), P(), P(), P(), P()
    kx, ky, pn, p1, p2, p3, h11, h12, h13 = P(), P(), P(), P(), P(), P(), P(), P(), P()
    h22, h23, h33, gx, gy, gn, busy = P(), P(), P(), P(), P(), P(), Counts()
    impacts, mode, steps, base, dv = LaneInt(), LaneInt(), LaneInt(), Three(), Three()
    rows, step_count, one = points.shape[0], int(0), real(1.0)
    for i in range(LANES):
        start_body(
            blocks[0, first + i], frames[first + i], knobs, mu[i], ix[i], iy[i], iz[i], x[i], y[i],
            z[i], qx[i], qy[i], qz[i], qw[i], vz[i], uplift_time[i], mode[i], peak[i],
            peak_across[i], peak_tilt[i],
        )  # fmt: skip
    for c in range(rows):
        for i in range(LANES):
            start_point(
                points[c, first + i], knobs, frames[first + i], px[c, i], py[c, i], pz[c, i],
                stood_x[c, i], stood_y[c, i], foot[c, i], n[c, i], apart[c, i],
            )  # fmt: skip
    for sample in range(sample_times.shape[0]):
        while time < sample_times[sample]:
            step_count += 1
            time, half = real(step_count) * dt, (real(step_count) - HALF) * dt
            for i in range(LANES):
                for d in range(3):
                    way = motions[d, first + i]
                    place = sample_index(way, sample_segment(way, half))
                    v = base_velocity(way, half, pool[2, place], pool[0, place], pool[1, place])
                    move_base(v, base[d, i], dv[d, i])
                predict(
                    dv[0, i], dv[1, i], dv[2, i], knobs, qx[i], qy[i], qz[i], qw[i], lx[i], ly[i],
                    lz[i], ix[i], iy[i], iz[i], vx[i], vy[i], vz[i], r11[i], r12[i], r13[i], r21[i],
                    r22[i], r23[i], r31[i], r32[i], r33[i], jxx[i], jxy[i], jxz[i], jyy[i], jyz[i],
                    jzz[i], ux[i], uy[i], uz[i], ox[i], oy[i], oz[i], lowest[i], lifted[i],
                    landed[i],
                )  # fmt: skip
            for c in range(rows):
                for i in range(LANES):
                    find_point(
                        foot[c, i] >= zero, px[c, i], py[c, i], pz[c, i], z[i], r11[i], r12[i],
                        r13[i], r21[i], r22[i], r23[i], r31[i], r32[i], r33[i], rx[c, i], ry[c, i],
                        rz[c, i], lowest[i],
                    )  # fmt: skip
            for c in range(rows):
                for i in range(LANES):
                    find_contact(
                        knobs, foot[c, i], frames[first + i].reach, blocks[0, first + i].half_width,
                        lowest[i], x[i], y[i], z[i], rx[c, i], ry[c, i], rz[c, i], stood_x[c, i],
                        stood_y[c, i], ox[i], oy[i], oz[i], aim[c, i], on[c, i], held[c, i],
                        fx[c, i], fy[c, i], n[c, i], apart[c, i], lifted[i], landed[i], count[i],
                        mx[i], my[i], xx[i], xy[i], yy[i], touching[i], way_x[i], way_y[i],
                    )  # fmt: skip
            for i in range(LANES):
                tell_stance(
                    mode[i] == RUNNING, time - dt, count[i], mx[i], my[i], xx[i], xy[i], yy[i],
                    lifted[i], since[i], touching[i], way_x[i], way_y[i], slide_x[i], slide_y[i],
                    peak_slide[i],
                )  # fmt: skip
            changes, turns = int(1), int(0)
            while changes > 0 and turns < ROUNDS:
                for c in range(rows):
                    for i in range(LANES):
                        add_held(
                            held[c, i], rx[c, i], ry[c, i], rz[c, i], aim[c, i], count[i], mx[i],
                            my[i], mz[i], xx[i], xy[i], yy[i], zx[i], zy[i], t[i], tx[i], ty[i],
                        )  # fmt: skip
                for i in range(LANES):
                    find_motion(
                        frames[first + i].reach, ux[i], uy[i], uz[i], ox[i], oy[i], oz[i], lx[i],
                        ly[i], lz[i], r11[i], r12[i], r13[i], r21[i], r22[i], r23[i], r31[i],
                        r32[i], r33[i], ix[i], iy[i], iz[i], count[i], mx[i], my[i], mz[i], xx[i],
                        xy[i], yy[i], zx[i], zy[i], t[i], tx[i], ty[i], wx[i], wy[i], wz[i], sx[i],
                        sy[i], sz[i], ex[i], ey[i], ez[i], gz[i], push[i], bx[i], by[i],
                    )  # fmt: skip
                    good[i] = one
                for c in range(rows):
                    for i in range(LANES):
                        judge(
                            knobs, on[c, i], aim[c, i], rx[c, i], ry[c, i], mx[i], my[i], wz[i],
                            sx[i], sy[i], push[i], bx[i], by[i], held[c, i], good[i],
                        )  # fmt: skip
                changes = int(0)
                for i in range(LANES):
                    changes += wp.where(good[i] > zero, 0, 1)
                turns += 1
                for i in range(wp.where(changes > 0 and turns < ROUNDS, LANES, 0)):
                    mx[i] = zero
                    my[i] = zero
                    mz[i] = zero
            for c in range(rows):
                for i in range(LANES):
                    add_pressure(
                        held[c, i], rx[c, i], ry[c, i], mx[i], my[i], push[i], bx[i], by[i], cx[i],
                        cy[i], turn[i],
                    )  # fmt: skip
            for i in range(LANES):
                find_turn(ex[i], ey[i], ez[i], gz[i], mx[i], my[i], cx[i], cy[i], turn[i])
            for c in range(rows):
                for i in range(LANES):
                    share(
                        knobs, mu[i], on[c, i], held[c, i], aim[c, i], rx[c, i], ry[c, i], mx[i],
                        my[i], push[i], bx[i], by[i], ex[i], ey[i], ez[i], cx[i], cy[i], turn[i],
                        wz[i], sx[i], sy[i], gx[c, i], gy[c, i], gn[c, i], good[i],
                    )  # fmt: skip
            for i in range(LANES):
                keep(
                    good[i] > zero, wx[i], wy[i], wz[i], sx[i], sy[i], sz[i], ux[i], uy[i], uz[i],
                    ox[i], oy[i], oz[i], mx[i], my[i], mz[i], cx[i], cy[i], turn[i],
                )  # fmt: skip
            for c in range(rows):
                busy[c] = 0
                for i in range(LANES):
                    take(
                        good[i] > zero, gx[c, i], gy[c, i], gn[c, i], fx[c, i], fy[c, i], n[c, i],
                        on[c, i],
                    )  # fmt: skip
                    busy[c] += wp.where(on[c, i] > zero, 1, 0)
                if busy[c] > 0:
                    for i in range(LANES):
                        warm_start(
                            on[c, i], rx[c, i], ry[c, i], rz[c, i], fx[c, i], fy[c, i], n[c, i],
                            jxx[i], jxy[i], jxz[i], jyy[i], jyz[i], jzz[i], kx[c, i], ky[c, i],
                            pn[c, i], p1[c, i], p2[c, i], p3[c, i], h11[c, i], h12[c, i], h13[c, i],
                            h22[c, i], h23[c, i], h33[c, i], ux[i], uy[i], uz[i], ox[i], oy[i],
                            oz[i],
                        )  # fmt: skip
            for step in range(knobs.sweeps * rows):
                c = step % rows
                if (step // rows) % 2 == 1:
                    c = rows - 1 - c
                if busy[c] > 0:
                    for i in range(LANES):
                        solve_contact(
                            mu[i], aim[c, i], rx[c, i], ry[c, i], rz[c, i], jxx[i], jxy[i], jxz[i],
                            jyy[i], jyz[i], jzz[i], kx[c, i], ky[c, i], pn[c, i], p1[c, i],
                            p2[c, i], p3[c, i], h11[c, i], h12[c, i], h13[c, i], h22[c, i],
                            h23[c, i], h33[c, i], fx[c, i], fy[c, i], n[c, i], ux[i], uy[i], uz[i],
                            ox[i], oy[i], oz[i],
                        )  # fmt: skip
            for i in range(LANES):
                live = mode[i] == RUNNING
                integrate(
                    live, knobs, ix[i], iy[i], iz[i], dv[0, i], dv[1, i], dv[2, i], ux[i], uy[i],
                    uz[i], ox[i], oy[i], oz[i], lowest[i], x[i], y[i], z[i], qx[i], qy[i], qz[i],
                    qw[i], vx[i], vy[i], vz[i], lx[i], ly[i], lz[i], loss[i],
                )  # fmt: skip
                slides = glides(frames[first + i], knobs, z[i], ux[i], uy[i], ox[i], oy[i], oz[i])
                observe_contacts(
                    live, time, landed[i], lowest[i], lifted[i], slides, since[i], uplift_time[i],
                    moved[i], deepest[i], impacts[i], steps[i],
                )  # fmt: skip
                observe_body(
                    live, time, blocks[0, first + i], frames[first + i], x[i] + y[i] + z[i] + vx[i]
                    + vy[i] + vz[i] + lx[i] + ly[i] + lz[i], qx[i], qy[i], qz[i], qw[i], peak[i],
                    peak_time[i], peak_across[i], peak_tilt[i], peak_yaw[i], mode[i],
                )  # fmt: skip
        for i in range(wp.where(found.attitudes.shape[0] > 0, LANES, 0)):
            q = attitude_to_store(mode[i] == RUNNING, sample_times[sample] - time, qx[i], qy[i],
                qz[i], qw[i], lx[i], ly[i], lz[i], ix[i], iy[i], iz[i])  # fmt: skip
            tx_, ty_, tz_, tw_ = block_attitude(frames[first + i], q[0], q[1], q[2], q[3])
            e = Attitude(tx_, ty_, tz_, tw_)
            for d in range(4):
                found.attitudes[sample, 0, d, first + i] = e[d]
        for i in range(wp.where(found.places.shape[0] > 0, LANES, 0)):
            past = wp.where(mode[i] == RUNNING, time - sample_times[sample], zero)
            found.places[sample, 0, 0, first + i] = x[i] - past * vx[i]
            found.places[sample, 0, 1, first + i] = y[i] - past * vy[i]
            found.places[sample, 0, 2, first + i] = z[i] - past * vz[i]
    for i in range(LANES):
        found.results[first + i] = Result(uplift_time[i], moved[i], loss[i], deepest[i], impacts[i],
            mode[i], steps[i])  # fmt: skip
        _a, _b, tz, tw = block_attitude(frames[first + i], qx[i], qy[i], qz[i], qw[i])
        found.blocks[0, first + i] = BlockResult(tz, tw, slide_x[i], slide_y[i], peak[i],
            peak_time[i], peak_across[i], peak_tilt[i], peak_yaw[i], peak_slide[i])  # fmt: skip
