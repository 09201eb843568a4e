"""Runs of the impulse step over blocks in space, LANES lanes a thread.

The values of LANES lanes lie side by side in vectors and matrices, one row a corner, so that the
compiler turns them into vector code; with one lane a thread the same text is the plain form for
any device. A func takes the entries and writes its results to those that it takes as `wp.ref`. The
sweeps skip a corner that is no contact in any lane of the thread: they would not change a bit.

impulse_space/block_seen.py says when a block rocks, lands and lifts.
"""

import warp as wp

from warprock.kernels.impulse_space.block import (
    Knobs,
    find_contact,
    integrate,
    predict,
    solve_contact,
    swap_if,
    warm_start,
)
from warprock.kernels.impulse_space.block_hold import hold
from warprock.kernels.impulse_space.block_plane import find_plane, level, solve_in_plane
from warprock.kernels.impulse_space.block_seen import (
    glides,
    lifted_since,
    observe_block,
    observe_contacts,
)
from warprock.kernels.instance import ONE_VECTOR
from warprock.kernels.modes import RUNNING
from warprock.kernels.motion import Motion, base_velocity, sample_index, sample_segment
from warprock.kernels.shape_space.block import Block, turn_freely, turns_of
from warprock.kernels.shape_space.block_found import BlockResult, Found, Result

wp.set_module_options(ONE_VECTOR)

R = wp.types.vector(length=LANES, dtype=real)
"""A number a lane."""
LaneInt = wp.types.vector(length=LANES, dtype=int)
Three = wp.types.matrix(shape=(3, LANES), dtype=real)
Corner = wp.types.matrix(shape=(4, LANES), dtype=real)
Attitude = wp.types.vector(length=4, dtype=real)
Counts = wp.types.vector(length=4, dtype=int)


@wp.func
def start_block(
    block: Block, knobs: Knobs,
    half_width: wp.ref[real], half_depth: wp.ref[real], half_height: wp.ref[real],
    cx: wp.ref[real], cy: wp.ref[real], mu: wp.ref[real],
    ix: wp.ref[real], iy: wp.ref[real], iz: wp.ref[real],
    x: wp.ref[real], y: wp.ref[real], z: wp.ref[real],
    qx: wp.ref[real], qy: wp.ref[real], qz: wp.ref[real], qw: wp.ref[real],
    vz: wp.ref[real], lean_x: wp.ref[real], lean_y: wp.ref[real],
    uplift_time: wp.ref[real], mode: wp.ref[int],
    peak: wp.ref[real], peak_across: wp.ref[real], peak_tilt: wp.ref[real],
    n1: wp.ref[real], n2: wp.ref[real], n3: wp.ref[real], n4: wp.ref[real],
):  # fmt: skip
    """Puts a block where it starts, its weight on the corners that touch.

    Velocities belong to half steps: half a step before the start the block rises as fast as it will
    fall half a step after.
    """
    half_width = block.half_width
    half_depth = block.half_depth
    half_height = block.half_height
    cx = block.centre_x
    cy = block.centre_y
    mu = block.friction
    ix = block.inverse_x
    iy = block.inverse_y
    iz = block.inverse_z
    x = block.x
    y = block.y
    z = block.z
    qx = block.qx
    qy = block.qy
    qz = block.qz
    qw = block.qw
    fall = HALF * knobs.time_step * knobs.gravity
    vz = fall
    n1 = fall / block.standing
    n2 = fall / block.standing
    n3 = fall / block.standing
    n4 = fall / block.standing
    lean_x = sign_of(block.centre_x)
    lean_y = sign_of(block.centre_y)
    flat = block.standing == real(4.0)
    uplift_time = wp.where(flat, NEVER, real(0.0))
    mode = RUNNING
    r13 = real(2.0) * (block.qx * block.qz + block.qy * block.qw)
    r23 = real(2.0) * (block.qy * block.qz - block.qx * block.qw)
    r33 = real(1.0) - real(2.0) * (block.qx * block.qx + block.qy * block.qy)
    tan_x, tan_y, tilt, _yaw = turns_of(block, r13, r23, r33, block.qz, block.qw)
    peak = tan_x
    peak_across = tan_y
    peak_tilt = tilt


@wp.func
def reorder(
    swap_x: real, swap_y: real, a: wp.ref[real], b: wp.ref[real], c: wp.ref[real], d: wp.ref[real]
):
    """Swaps what the corners keep from step to step where the block leans to another side."""
    swap_if(swap_x, a, b)
    swap_if(swap_x, c, d)
    swap_if(swap_y, a, c)
    swap_if(swap_y, b, d)


@wp.func
def move_base(v: real, base: wp.ref[real], dv: wp.ref[real]):
    """Change of the base velocity to v [m/s]."""
    dv = v - base
    base = v


@wp.func
def predict_block(
    dvx: real, dvy: real, dvz: real, knobs: Knobs, qx: real, qy: real, qz: real, qw: real,
    lx: real, ly: real, lz: real, ix: real, iy: real, iz: real, vx: real, vy: real, vz: real,
    ux: wp.ref[real], uy: wp.ref[real], uz: wp.ref[real],
    ox: wp.ref[real], oy: wp.ref[real], oz: wp.ref[real],
    jxx: wp.ref[real], jxy: wp.ref[real], jxz: wp.ref[real],
    jyy: wp.ref[real], jyz: wp.ref[real], jzz: wp.ref[real],
    lean_x: wp.ref[real], lean_y: wp.ref[real],
    lowest: wp.ref[real], lifted: wp.ref[real], landed: wp.ref[real],
    fx0: wp.ref[real], fx1: wp.ref[real], fx2: wp.ref[real], fx3: wp.ref[real],
    fy0: wp.ref[real], fy1: wp.ref[real], fy2: wp.ref[real], fy3: wp.ref[real],
    n0: wp.ref[real], n1: wp.ref[real], n2: wp.ref[real], n3: wp.ref[real],
    apart0: wp.ref[real], apart1: wp.ref[real], apart2: wp.ref[real], apart3: wp.ref[real],
    before: real, since: wp.ref[real],
):  # fmt: skip
    """Predicts the velocities of a block, with its corners in the order of the lean.

    `before` is when the last step ended [s], `since` the time since which it has not stood flat, or
    NEVER.
    """
    since = lifted_since(n0, n1, n2, n3, since, before)
    swap_x, swap_y = real(0.0), real(0.0)
    predict(
        dvx, dvy, dvz, knobs, qx, qy, qz, qw, lx, ly, lz, ix, iy, iz, vx, vy, vz, ux, uy, uz,
        ox, oy, oz, jxx, jxy, jxz, jyy, jyz, jzz, lean_x, lean_y, swap_x, swap_y,
        lowest,
    )  # fmt: skip
    lifted = real(0.0)
    landed = real(0.0)
    reorder(swap_x, swap_y, fx0, fx1, fx2, fx3)
    reorder(swap_x, swap_y, fy0, fy1, fy2, fy3)
    reorder(swap_x, swap_y, n0, n1, n2, n3)
    reorder(swap_x, swap_y, apart0, apart1, apart2, apart3)


@wp.func
def integrate_block(
    mode: wp.ref[int], knobs: Knobs, time: real, block: Block, ix: real, iy: real, iz: real,
    dvx: real, dvy: real, dvz: real, ux: real, uy: real, uz: real, ox: real, oy: real, oz: real,
    landed: real, lowest: real, lifted: real,
    x: wp.ref[real], y: wp.ref[real], z: wp.ref[real],
    qx: wp.ref[real], qy: wp.ref[real], qz: wp.ref[real], qw: wp.ref[real],
    vx: wp.ref[real], vy: wp.ref[real], vz: wp.ref[real],
    lx: wp.ref[real], ly: wp.ref[real], lz: wp.ref[real], loss: wp.ref[real],
    since: real, uplift_time: wp.ref[real], moved: wp.ref[real],
    deepest: wp.ref[real], impacts: wp.ref[int], steps: wp.ref[int],
    slide_x: wp.ref[real], slide_y: wp.ref[real],
    peak: wp.ref[real], peak_time: wp.ref[real],
    peak_across: wp.ref[real], peak_tilt: wp.ref[real], peak_yaw: wp.ref[real],
    peak_slide: wp.ref[real],
):  # fmt: skip
    """Moves a block by a step, and looks at it; see `integrate` and `observe_block`."""
    live = mode == RUNNING
    integrate(
        live, knobs, ix, iy, iz, dvx, dvy, dvz, ux, uy, uz, ox, oy, oz, lowest,
        x, y, z, qx, qy, qz, qw, vx, vy, vz, lx, ly, lz, loss,
    )  # fmt: skip
    observe_contacts(
        live, time, landed, lowest, lifted, glides(block, knobs, ux, uy, ox, oy, oz), since,
        uplift_time, moved, deepest, impacts, steps,
    )  # fmt: skip
    observe_block(
        live, time, block, x, y, z, qx, qy, qz, qw, vx + vy + vz + lx + ly + lz, slide_x, slide_y,
        peak, peak_time, peak_across, peak_tilt, peak_yaw, peak_slide, mode,
    )  # fmt: skip


@wp.func
def attitude_to_store(
    live: bool, past: real, qx: real, qy: real, qz: real, qw: real, lx: real, ly: real, lz: real,
    ix: real, iy: real, iz: real,
) -> Attitude:  # fmt: skip
    """Attitude at a sample that a block has passed by the time -past [s], if it lives on."""
    e, f, g, h = turn_freely(
        qx, qy, qz, qw, lx, ly, lz, ix, iy, iz, wp.where(live, past, real(0.0))
    )
    return Attitude(e, f, g, h)


@wp.kernel
def run_lanes(
    blocks: wp.array2d(dtype=Block), motions: wp.array2d(dtype=Motion),
    pool: wp.array2d(dtype=real), sample_times: wp.array(dtype=real), knobs: Knobs, found: Found,
):  # fmt: skip
    """Runs LANES lanes a thread, all at the same time."""
    pack, _one = wp.tid()
    first, dt, zero, time = pack * LANES, knobs.time_step, real(0.0), real(0.0)
    x, y, z, qx, qy, qz, qw, vx, vy, vz, lx = R(), R(), R(), R(), R(), R(), R(), R(), R(), R(), R()
    ly, lz, ux, uy, uz, ox, oy, oz, half_w = R(), R(), R(), R(), R(), R(), R(), R(), R()
    half_d, half_h, cx, cy, mu, ix, iy, iz, loss = R(), R(), R(), R(), R(), R(), R(), R(), R()
    lowest, deepest, jxx, jxy, jxz, jyy, jyz, jzz = R(), R(), R(), R(), R(), R(), R(), R()
    lean_x, lean_y, landed, lifted, slide_x, slide_y, peak = R(), R(), R(), R(), R(), R(), R()
    peak_time, peak_across, peak_tilt, peak_yaw, peak_slide = R(), R(), R(), R(), R()
    uplift_time, moved, since, plane = R(), R(), R(), R()
    fx, fy, n, on, apart, aim = Corner(), Corner(), Corner(), Corner(), Corner(), Corner()
    rx, ry, rz, kx, ky, pn = Corner(), Corner(), Corner(), Corner(), Corner(), Corner()
    p1, p2, p3, h11, h12, h13 = Corner(), Corner(), Corner(), Corner(), Corner(), Corner()
    h22, h23, h33, busy = Corner(), Corner(), Corner(), Counts()
    impacts, mode, steps, base, dv = LaneInt(), LaneInt(), LaneInt(), Three(), Three()
    corners, count = int(4), int(0)  # no constant: else Warp would unroll the loops over it
    for i in range(LANES):
        start_block(
            blocks[0, first + i], knobs, half_w[i], half_d[i], half_h[i], cx[i], cy[i], mu[i],
            ix[i], iy[i], iz[i], x[i], y[i], z[i], qx[i], qy[i], qz[i], qw[i], vz[i], lean_x[i],
            lean_y[i], uplift_time[i], mode[i], peak[i], peak_across[i], peak_tilt[i], n[0, i],
            n[1, i], n[2, i], n[3, i],
        )  # fmt: skip
    for sample in range(sample_times.shape[0]):
        while time < sample_times[sample]:
            count += 1
            time, half = real(count) * dt, (real(count) - HALF) * dt
            for i in range(LANES):
                for d in range(3):
                    way = motions[d, first + i]
                    place = sample_index(way, sample_segment(way, half))
                    v = base_velocity(way, half, pool[2, place], pool[0, place], pool[1, place])
                    move_base(v, base[d, i], dv[d, i])
                predict_block(
                    dv[0, i], dv[1, i], dv[2, i], knobs, qx[i], qy[i], qz[i], qw[i], lx[i], ly[i],
                    lz[i], ix[i], iy[i], iz[i], vx[i], vy[i], vz[i], ux[i], uy[i], uz[i], ox[i],
                    oy[i], oz[i], jxx[i], jxy[i], jxz[i], jyy[i], jyz[i], jzz[i], lean_x[i],
                    lean_y[i], lowest[i], lifted[i], landed[i], fx[0, i], fx[1, i], fx[2, i], fx[3,
                    i], fy[0, i], fy[1, i], fy[2, i], fy[3, i], n[0, i], n[1, i], n[2, i], n[3, i],
                    apart[0, i], apart[1, i], apart[2, i], apart[3, i], time - dt, since[i],
                )  # fmt: skip
            for c in range(corners):
                for i in range(LANES):
                    find_contact(
                        c, lean_x[i], lean_y[i], half_w[i], half_d[i], half_h[i], cx[i], cy[i],
                        z[i], knobs, qx[i], qy[i], qz[i], qw[i], ox[i], oy[i], oz[i], rx[c, i],
                        ry[c, i], rz[c, i], aim[c, i], on[c, i], fx[c, i], fy[c, i], n[c, i],
                        apart[c, i], lowest[i], lifted[i], landed[i],
                    )  # fmt: skip
            for i in range(LANES):
                plane[i] = find_plane(
                    knobs, half_h[i], cx[i], cy[i], qx[i], qy[i], qz[i], qw[i], ux[i], uy[i],
                    ox[i], oy[i], oz[i],
                )  # fmt: skip
                level(
                    plane[i], aim[0, i], aim[1, i], aim[2, i], aim[3, i], on[0, i], on[1, i],
                    on[2, i], on[3, i],
                )  # fmt: skip
                hold(
                    knobs, lean_x[i], lean_y[i], half_w[i], half_d[i], half_h[i], cx[i], cy[i],
                    mu[i], qx[i], qy[i], qz[i], qw[i], ix[i], iy[i], iz[i], lx[i], ly[i], lz[i],
                    aim[0, i], aim[1, i], aim[2, i], aim[3, i], on[0, i], on[1, i], on[2, i],
                    on[3, i], fx[0, i], fx[1, i], fx[2, i], fx[3, i], fy[0, i], fy[1, i], fy[2, i],
                    fy[3, i], n[0, i], n[1, i], n[2, i], n[3, i], ux[i], uy[i], uz[i], ox[i], oy[i],
                    oz[i],
                )  # fmt: skip
            planar = int(0)
            for i in range(LANES):
                left = on[0, i] + on[1, i] + on[2, i] + on[3, i]
                planar += wp.where(plane[i] * left > zero, 1, 0)
            if planar > 0:
                for i in range(LANES):
                    solve_in_plane(
                        plane[i], knobs, lean_x[i], lean_y[i], mu[i], qx[i], qy[i], qz[i], qw[i],
                        ix[i], iy[i], rx[0, i], rx[1, i], rx[2, i], rx[3, i], ry[0, i], ry[1, i],
                        ry[2, i], ry[3, i], rz[0, i], rz[1, i], rz[2, i], rz[3, i], aim[0, i],
                        aim[1, i], aim[2, i], aim[3, i], on[0, i], on[1, i], on[2, i], on[3, i],
                        fx[0, i], fx[1, i], fx[2, i], fx[3, i], fy[0, i], fy[1, i], fy[2, i],
                        fy[3, i], n[0, i], n[1, i], n[2, i], n[3, i], ux[i], uy[i], uz[i], ox[i],
                        oy[i], oz[i],
                    )  # fmt: skip
            for c in range(corners):
                busy[c] = 0
                for i in range(LANES):
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
            for step in range(knobs.sweeps * corners):
                c = step % corners
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
                integrate_block(
                    mode[i], knobs, time, blocks[0, first + i], ix[i], iy[i], iz[i], dv[0, i], dv[1,
                    i], dv[2, i], ux[i], uy[i], uz[i], ox[i], oy[i], oz[i], landed[i], lowest[i],
                    lifted[i], x[i], y[i], z[i], qx[i],
                    qy[i], qz[i], qw[i], vx[i], vy[i], vz[i], lx[i], ly[i], lz[i], loss[i],
                    since[i], uplift_time[i], moved[i], deepest[i], impacts[i], steps[i],
                    slide_x[i], slide_y[i], peak[i], peak_time[i], peak_across[i], peak_tilt[i],
                    peak_yaw[i], peak_slide[i])  # fmt: skip
        for i in range(wp.where(found.attitudes.shape[0] > 0, LANES, 0)):
            q = attitude_to_store(mode[i] == RUNNING, sample_times[sample] - time, qx[i], qy[i],
                qz[i], qw[i], lx[i], ly[i], lz[i], ix[i], iy[i], iz[i])  # fmt: skip
            for d in range(4):
                found.attitudes[sample, 0, d, first + i] = q[d]
        for i in range(wp.where(found.places.shape[0] > 0, LANES, 0)):
            past = wp.where(mode[i] == RUNNING, time - sample_times[sample], zero)
            found.places[sample, 0, 0, first + i] = x[i] - past * vx[i]
            found.places[sample, 0, 1, first + i] = y[i] - past * vy[i]
            found.places[sample, 0, 2, first + i] = z[i] - past * vz[i]
    for i in range(LANES):
        found.results[first + i] = Result(uplift_time[i], moved[i], loss[i], deepest[i], impacts[i],
            mode[i], steps[i])  # fmt: skip
        found.blocks[0, first + i] = BlockResult(qz[i], qw[i], slide_x[i], slide_y[i], peak[i],
            peak_time[i], peak_across[i], peak_tilt[i], peak_yaw[i], peak_slide[i])  # fmt: skip
