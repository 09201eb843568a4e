"""Runs of the impulse step over blocks in space, LANES lanes a thread.

The values of LANES lanes lie side by side in vectors and matrices, one row a corner, so that the
compiler turns them into vector code; with one lane a thread the same text is the plain form for
any device. A func takes the entries, and what it finds it leaves in those that it takes as
`wp.ref`.

A block rocks while a corner does not touch the base, see `feel`; it lands once one touches again.
"""

# A func leaves what it finds in the names that it takes by reference.
# ruff: noqa: F841

from typing import Any

import warp as wp

from warprock.kernels.instance import kernel_module

real: Any
PRECISION: str
MOTION: str
LANES: int
FRICTION: str

impulse = kernel_module("spatial_impulse", precision=PRECISION, friction=FRICTION)
wp.set_module_options(impulse.OPTIONS)
scalar = kernel_module("scalar", precision=PRECISION)
shape = kernel_module("spatial", precision=PRECISION)
motion = kernel_module("motion", precision=PRECISION, motion=MOTION)
found_of = kernel_module("spatial_found", precision=PRECISION)
larger, smaller, size, sign_of = scalar.larger, scalar.smaller, scalar.size, scalar.sign_of
Block, slide_of, turns_of, turn_freely = (
    shape.Block, shape.slide_of, shape.turns_of, shape.turn_freely,
)  # fmt: skip
BlockResult, Result, Found = found_of.BlockResult, found_of.Result, found_of.Found
Motion, base_velocity = motion.Motion, motion.velocity
sample_index, sample_segment = motion.sample_index, motion.sample_segment
Knobs, set_out, exchange, approach = (
    impulse.Knobs, impulse.set_out, impulse.exchange, impulse.approach,
)  # fmt: skip
press, advance = impulse.press, impulse.advance

HALF = real(0.5)
NEVER = real(1.0e30)
ROCKING = 1
OVERTURNED = 2
BROKEN = 3

Lane = wp.types.vector(length=LANES, dtype=real)
LaneInt = wp.types.vector(length=LANES, dtype=int)
Three = wp.types.matrix(shape=(3, LANES), dtype=real)
Corner = wp.types.matrix(shape=(4, LANES), dtype=real)


@wp.func
def begin(
    block: Block, knobs: Knobs, width: wp.ref[real], depth: wp.ref[real], height: wp.ref[real],
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
    width = block.width
    depth = block.depth
    height = block.height
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
    mode = ROCKING
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
    """Lets what the corners keep from step to step change places where a side is another."""
    exchange(swap_x, a, b)
    exchange(swap_x, c, d)
    exchange(swap_y, a, c)
    exchange(swap_y, b, d)


@wp.func
def feel(
    gap: real, knobs: Knobs, apart: wp.ref[real], lowest: wp.ref[real], lifted: wp.ref[real],
    landed: wp.ref[real],
):  # fmt: skip
    """Counts a corner that does not touch, or does and did not in the last step; the lowest gap.

    It touches within the margin, and what two steps of falling are: sweeps that end leave hops of
    that order.
    """
    zero, one = real(0.0), real(1.0)
    slack = real(2.0) * knobs.time_step * knobs.time_step * knobs.gravity
    now = wp.where(gap > knobs.collision_margin + slack, one, zero)
    landed = landed + wp.where(now < apart, one, zero)
    lifted = lifted + now
    apart = now
    lowest = smaller(lowest, gap)


@wp.func
def witness(
    live: bool, time: real, landed: real, lowest: real, lifted: real,
    uplift_time: wp.ref[real], moved: wp.ref[real], deepest: wp.ref[real], impacts: wp.ref[int],
    steps: wp.ref[int],
):  # fmt: skip
    """Whether a block rocks, whether it lands, and how deep it is.

    Args:
        live: Whether the lane lives on.
        time: End of the step [s].
        landed: Corners that touch now and did not in the last step.
        lowest: Lowest gap [m].
        lifted: Corners that do not touch.
        uplift_time: First time at which a corner does not [s].
        moved: Last such time [s].
        deepest: Deepest penetration [m].
        impacts: Landings.
        steps: Steps of a lane that lived on.
    """
    zero = real(0.0)
    rocks = live and lifted > zero
    uplift_time = wp.where(rocks and uplift_time >= NEVER, time, uplift_time)
    moved = wp.where(rocks, time, moved)
    impacts = impacts + wp.where(live and landed > zero, 1, 0)
    steps = steps + wp.where(live, 1, 0)
    deepest = wp.where(live, larger(-lowest, deepest), deepest)


@wp.func
def observe(
    live: bool, time: real, block: Block, x: real, y: real, z: real, qx: real, qy: real, qz: real,
    qw: real, speed: real, landed: real, lowest: real, lifted: real,
    uplift_time: wp.ref[real], moved: wp.ref[real], deepest: wp.ref[real], impacts: wp.ref[int],
    steps: wp.ref[int], slide_x: wp.ref[real], slide_y: wp.ref[real],
    peak: wp.ref[real], peak_time: wp.ref[real],
    peak_across: wp.ref[real], peak_tilt: wp.ref[real], peak_yaw: wp.ref[real],
    peak_slide: wp.ref[real], mode: wp.ref[int],
):  # fmt: skip
    """Peaks and slide of a block after a step, and whether its lane lives on.

    `speed` is a sum of its velocities, which is finite only if they are.
    """
    witness(live, time, landed, lowest, lifted, uplift_time, moved, deepest, impacts, steps)
    r11, r12, r13, r21, r22, r23, r31, r32, r33 = shape.matrix_of(qx, qy, qz, qw)
    tan_x, tan_y, tilt, yaw = turns_of(block, r13, r23, r33, qz, qw)
    away_x, away_y = slide_of(block, x, y, r11, r12, r13, r21, r22, r23, r31, r32)
    higher = live and tan_x > peak
    peak_time = wp.where(higher, time, peak_time)
    peak = wp.where(higher, tan_x, peak)
    peak_across = wp.where(live, larger(tan_y, peak_across), peak_across)
    peak_tilt = wp.where(live, larger(tilt, peak_tilt), peak_tilt)
    peak_yaw = wp.where(live, larger(yaw, peak_yaw), peak_yaw)
    slide_x = wp.where(live, away_x, slide_x)
    slide_y = wp.where(live, away_y, slide_y)
    peak_slide = wp.where(live, larger(away_x * away_x + away_y * away_y, peak_slide), peak_slide)
    total = x + y + z + r33 + qw + speed
    found = wp.where(r33 <= real(0.0), OVERTURNED, ROCKING)
    mode = wp.where(live, wp.where(total - total == real(0.0), found, BROKEN), mode)


@wp.kernel
def spatial(
    blocks: wp.array2d(dtype=Block), motions: wp.array2d(dtype=Motion),
    pool: wp.array2d(dtype=real), sample_times: wp.array(dtype=real), knobs: Knobs, found: Found,
):  # fmt: skip
    """Runs LANES lanes a thread, all at the same time."""
    first, dt, time = wp.tid() * LANES, knobs.time_step, real(0.0)
    x, y, z, qx, qy, qz, qw = Lane(), Lane(), Lane(), Lane(), Lane(), Lane(), Lane()
    vx, vy, vz, lx, ly, lz = Lane(), Lane(), Lane(), Lane(), Lane(), Lane()
    ux, uy, uz, ox, oy, oz = Lane(), Lane(), Lane(), Lane(), Lane(), Lane()
    width, depth, height, cx, cy, mu = Lane(), Lane(), Lane(), Lane(), Lane(), Lane()
    ix, iy, iz, loss, lowest, deepest = Lane(), Lane(), Lane(), Lane(), Lane(), Lane()
    lean_x, lean_y, swap_x, swap_y, landed, lifted = Lane(), Lane(), Lane(), Lane(), Lane(), Lane()
    slide_x, slide_y, peak, peak_time, peak_across = Lane(), Lane(), Lane(), Lane(), Lane()
    peak_tilt, peak_yaw, peak_slide, uplift_time, moved = Lane(), Lane(), Lane(), Lane(), Lane()
    impacts, mode, steps, base, dv = LaneInt(), LaneInt(), LaneInt(), Three(), Three()
    fx, fy, n, apart = Corner(), Corner(), Corner(), Corner()
    rx, ry, rz, gap, pn, p1 = Corner(), Corner(), Corner(), Corner(), Corner(), Corner()
    xx, xy, xz, yx, yy, yz = Corner(), Corner(), Corner(), Corner(), Corner(), Corner()
    zx, zy, zz, h11, h12, h13 = Corner(), Corner(), Corner(), Corner(), Corner(), Corner()
    h22, h23, h33, p2, p3, apart = Corner(), Corner(), Corner(), Corner(), Corner(), Corner()
    fx, fy, n = Corner(), Corner(), Corner()
    # A count that Warp does not know, so that it writes out none of the loops over it.
    corners, count = int(4), int(0)
    for i in range(LANES):
        begin(
            blocks[0, first + i], knobs, width[i], depth[i], height[i], cx[i], cy[i], mu[i], ix[i],
            iy[i], iz[i], x[i], y[i], z[i], qx[i], qy[i], qz[i], qw[i], vz[i], lean_x[i], lean_y[i],
            uplift_time[i], mode[i], peak[i], peak_across[i], peak_tilt[i], n[0, i], n[1, i],
            n[2, i], n[3, i],
        )  # fmt: skip
    for sample in range(sample_times.shape[0]):
        until = sample_times[sample]
        while time < until:
            count += 1
            time, half = real(count) * dt, (real(count) - HALF) * dt
            for i in range(LANES):
                for d in range(3):
                    way = motions[d, first + i]
                    place = sample_index(way, sample_segment(way, half))
                    v = base_velocity(way, half, pool[2, place], pool[0, place], pool[1, place])
                    dv[d, i] = v - base[d, i]
                    base[d, i] = v
                set_out(
                    dv[0, i], dv[1, i], dv[2, i], knobs, qx[i], qy[i], qz[i], qw[i], lx[i], ly[i],
                    lz[i], ix[i], iy[i], iz[i], vx[i], vy[i], vz[i], ux[i], uy[i], uz[i], ox[i],
                    oy[i], oz[i], lean_x[i], lean_y[i], swap_x[i], swap_y[i], lowest[i], lifted[i],
                    landed[i],
                )  # fmt: skip
                reorder(swap_x[i], swap_y[i], fx[0, i], fx[1, i], fx[2, i], fx[3, i])
                reorder(swap_x[i], swap_y[i], fy[0, i], fy[1, i], fy[2, i], fy[3, i])
                reorder(swap_x[i], swap_y[i], n[0, i], n[1, i], n[2, i], n[3, i])
                reorder(swap_x[i], swap_y[i], apart[0, i], apart[1, i], apart[2, i], apart[3, i])
            for c in range(corners):
                side_x, side_y = real(2 * (c % 2) - 1), real(2 * (c // 2) - 1)
                for i in range(LANES):
                    approach(
                        side_x * lean_x[i], side_y * lean_y[i], width[i], depth[i], height[i],
                        cx[i], cy[i], z[i], knobs, qx[i], qy[i], qz[i], qw[i], ix[i], iy[i], iz[i],
                        rx[c, i], ry[c, i], rz[c, i], gap[c, i], xx[c, i], xy[c, i], xz[c, i],
                        yx[c, i], yy[c, i], yz[c, i], zx[c, i], zy[c, i], zz[c, i], pn[c, i],
                        p1[c, i], p2[c, i], p3[c, i], h11[c, i], h12[c, i], h13[c, i], h22[c, i],
                        h23[c, i], h33[c, i], fx[c, i], fy[c, i], n[c, i], ux[i], uy[i], uz[i],
                        ox[i], oy[i], oz[i],
                    )  # fmt: skip
                    feel(gap[c, i], knobs, apart[c, i], lowest[i], lifted[i], landed[i])
            for step in range(knobs.sweeps * corners):
                c = step % corners
                for i in range(LANES):
                    press(
                        mu[i], gap[c, i], knobs.rate, rx[c, i], ry[c, i], rz[c, i], xx[c, i],
                        xy[c, i], xz[c, i], yx[c, i], yy[c, i], yz[c, i], zx[c, i], zy[c, i],
                        zz[c, i], pn[c, i], p1[c, i], p2[c, i], p3[c, i], h11[c, i], h12[c, i],
                        h13[c, i], h22[c, i], h23[c, i], h33[c, i], fx[c, i], fy[c, i], n[c, i],
                        ux[i], uy[i], uz[i], ox[i], oy[i], oz[i],
                    )  # fmt: skip
            for i in range(LANES):
                live = mode[i] == ROCKING
                advance(
                    live, knobs, ix[i], iy[i], iz[i], dv[0, i], dv[1, i], dv[2, i], ux[i], uy[i],
                    uz[i], ox[i], oy[i], oz[i], lowest[i], x[i], y[i], z[i], qx[i], qy[i], qz[i],
                    qw[i], vx[i], vy[i], vz[i], lx[i], ly[i], lz[i], loss[i],
                )  # fmt: skip
                observe(
                    live, time, blocks[0, first + i], x[i], y[i], z[i], qx[i], qy[i], qz[i], qw[i],
                    vx[i] + vy[i] + vz[i] + lx[i] + ly[i] + lz[i], landed[i], lowest[i], lifted[i],
                    uplift_time[i], moved[i], deepest[i], impacts[i], steps[i], slide_x[i],
                    slide_y[i], peak[i], peak_time[i], peak_across[i], peak_tilt[i], peak_yaw[i],
                    peak_slide[i], mode[i],
                )  # fmt: skip
        if found.attitudes.shape[0] > 0:
            for i in range(LANES):
                e, f, g, h = turn_freely(
                    qx[i], qy[i], qz[i], qw[i], lx[i], ly[i], lz[i], ix[i], iy[i], iz[i],
                    wp.where(mode[i] == ROCKING, until - time, real(0.0)),
                )  # fmt: skip
                found.attitudes[sample, 0, 0, first + i] = e
                found.attitudes[sample, 0, 1, first + i] = f
                found.attitudes[sample, 0, 2, first + i] = g
                found.attitudes[sample, 0, 3, first + i] = h
    for i in range(LANES):
        found.results[first + i] = Result(
            uplift_time[i], moved[i], loss[i], deepest[i], impacts[i], mode[i], steps[i]
        )
        found.blocks[0, first + i] = BlockResult(
            qz[i], qw[i], slide_x[i], slide_y[i], peak[i], peak_time[i], peak_across[i],
            peak_tilt[i], peak_yaw[i], peak_slide[i],
        )  # fmt: skip
