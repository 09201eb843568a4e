"""Runs of the soft-spring step over blocks in space: LANES stacks a thread, side by side.

A single block is a stack of one. Every lane has its own time step, and with it its own number of
steps; a pack goes on until the last of its lanes has reached the next sample.

Loops over the lanes are innermost and work on local matrices, one row a number of a body or of a
point, so that the compiler turns them into vector code; with one lane a thread the same text is the
plain form for any device.

An interface has parted once its faces gape from the middle to three quarters of the way to the
corner that is pressed most, see `PIVOT` of dem/stack_lanes.py; in the plane that is an end. It
slides while it is closed in the middle and slips faster than springs swing that stick.
"""

import warp as wp

from warprock.kernels.dem.stack import Knobs
from warprock.kernels.dem.stack_lanes import passes_left, time_past
from warprock.kernels.dem_space.stack import integrate, load_blocks, solve_pair
from warprock.kernels.dem_space.stack_meet import Link, Moving, find_contacts
from warprock.kernels.dem_space.stack_rows import (
    Lane,
    begin_step,
    gather,
    keep_link,
    move_base,
    observe_block,
    observe_interface,
    pose_before,
    start_block,
    start_lane,
)
from warprock.kernels.instance import ONE_VECTOR
from warprock.kernels.motion import Motion, base_velocity, sample_index, sample_segment
from warprock.kernels.shape_space.block import Block
from warprock.kernels.shape_space.block_found import BlockResult, Found, Result

wp.set_module_options(ONE_VECTOR)

PAIRS = max(ITERATIONS, 1)
"""Pairs of points of an interface; one in the middle counts as a pair of two halves."""
KINDS = 3
"""Kinds of pairs: what is summed over each, see `solve_pair`, is summed apart."""

R = wp.types.vector(length=LANES, dtype=real)
"""A number a lane."""
Count = wp.types.vector(length=LANES, dtype=int)
Three = wp.types.matrix(shape=(3, LANES), dtype=real)
B = wp.types.matrix(shape=(BLOCKS + 1, LANES), dtype=real)
"""A number a body."""
Point = wp.types.matrix(shape=(BLOCKS * PAIRS, LANES), dtype=real)
"""A number of one point of each pair, and a sum over the pairs of a kind. Each number has a matrix
of its own: of two rows of one matrix, each found at run time, the compiler would have to check
before every loop that they are not the same."""
Sum = wp.types.matrix(shape=(KINDS, LANES), dtype=real)


@wp.kernel
def run_lanes(
    blocks: wp.array2d(dtype=Block), motions: wp.array2d(dtype=Motion),
    pool: wp.array2d(dtype=real), sample_times: wp.array(dtype=real), lanes: wp.array(dtype=Lane),
    points: wp.array2d(dtype=real), knobs: Knobs, found: Found,
):  # fmt: skip
    """Runs LANES lanes a thread, each at its own time; rows of points: a, b, share, kind."""
    # Rows of bodies, the ground first: where, how fast, and what is kept of them.
    x, y, z, qx, qy, qz, qw, vx, vy, vz = B(), B(), B(), B(), B(), B(), B(), B(), B(), B()
    lx, ly, lz, fx, fy, fz, mx, my, mz, at = B(), B(), B(), B(), B(), B(), B(), B(), B(), B()
    since, gx, gy, slide, peak, across, tilt, yaw = B(), B(), B(), B(), B(), B(), B(), B()
    # Rows of pairs, of the point at -(a, b) and of the one at (a, b); sums; the link looked at.
    ux, uy, slip, ux2, uy2, slip2 = Point(), Point(), Point(), Point(), Point(), Point()
    sn, sna, snb, s1, sa1, sb1, s2, sa2 = Sum(), Sum(), Sum(), Sum(), Sum(), Sum(), Sum(), Sum()
    sb2, se, base, dv = Sum(), Sum(), Three(), Three()
    o, area, mu, wide, deep, cx, cy, p1, p2, p3 = R(), R(), R(), R(), R(), R(), R(), R(), R(), R()
    d1, d2, d3, a1, a2, a3, b1, b2, b3, v1 = R(), R(), R(), R(), R(), R(), R(), R(), R(), R()
    v2, v3, j1, j2, j3, k1, k2, k3, dt = R(), R(), R(), R(), R(), R(), R(), R(), R()
    span, loss, spent, stored, at_start, lifted, moved = R(), R(), R(), R(), R(), R(), R()
    deepest, creep, live, impacts, mode, steps = R(), R(), Count(), Count(), Count(), Count()
    pack, _one = wp.tid()
    bodies, pairs, first, moves = int(BLOCKS + 1), int(PAIRS), pack * LANES, int(0)  # loops stay
    for i in range(LANES):
        start_lane(lanes[first + i], qw[0, i], dt[i], creep[i], lifted[i], mode[i])
        moves = moves | lanes[first + i].moves
        for k in range(1, bodies):
            start_block(blocks[k, first + i], x[k, i], y[k, i], z[k, i], qx[k, i], qy[k, i],
                qz[k, i], qw[k, i], since[k, i], peak[k, i], across[k, i], tilt[k, i])  # fmt: skip
    for sample in range(sample_times.shape[0]):
        passes, until = int(0), sample_times[sample]
        for i in range(LANES):
            passes = wp.max(passes, passes_left(until, steps[i], dt[i], mode[i]))
        for _ in range(passes):
            for i in range(LANES):
                begin_step(live[i], steps[i], dt[i], until, mode[i], loss[i], span[i], stored[i],
                    at_start[i], spent[i])  # fmt: skip
            for d in range(3):
                if (moves >> d) % 2 == 1:
                    for i in range(LANES):
                        mid = (real(steps[i]) - HALF) * dt[i]
                        lane = motions[d, first + i]
                        place = sample_index(lane, sample_segment(lane, mid))
                        v = base_velocity(lane, mid, pool[2, place], pool[0, place], pool[1, place])
                        move_base(v, live[i] == 1, base[d, i], dv[d, i])
            for k in range(1, bodies):
                h = k - 1
                for i in range(LANES):
                    upper = Moving(x[k, i], y[k, i], z[k, i], qx[k, i], qy[k, i], qz[k, i],
                        qw[k, i], vx[k, i], vy[k, i], vz[k, i], lx[k, i], ly[k, i],
                        lz[k, i])  # fmt: skip
                    lower = Moving(x[h, i], y[h, i], z[h, i], qx[h, i], qy[h, i], qz[h, i],
                        qw[h, i], vx[h, i], vy[h, i], vz[h, i], lx[h, i], ly[h, i],
                        lz[h, i])  # fmt: skip
                    link = find_contacts(blocks[k, first + i], blocks[h, first + i], upper, lower)
                    keep_link(link, o[i], area[i], mu[i], wide[i], deep[i], cx[i], cy[i], p1[i],
                        p2[i], p3[i], d1[i], d2[i], d3[i], a1[i], a2[i], a3[i], b1[i], b2[i], b3[i],
                        v1[i], v2[i], v3[i], j1[i], j2[i], j3[i], k1[i], k2[i], k3[i], gx[k, i],
                        gy[k, i])  # fmt: skip
                    observe_interface(live[i] == 1, steps[i], dt[i], link, creep[i], since[k, i],
                        lifted[i], moved[i], deepest[i], impacts[i], mode[i])  # fmt: skip
                for p in range(pairs):
                    r, q = int(points[3, p]), pairs * h + p
                    for i in range(LANES):
                        spot = Link(o[i], area[i], mu[i], wide[i], deep[i], cx[i], cy[i], p1[i],
                            p2[i], p3[i], d1[i], d2[i], d3[i], a1[i], a2[i], a3[i], b1[i], b2[i],
                            b3[i], v1[i], v2[i], v3[i], j1[i], j2[i], j3[i], k1[i], k2[i], k3[i],
                            gx[k, i], gy[k, i])  # fmt: skip
                        solve_pair(knobs, spot, live[i] == 1, dt[i], points[0, p], points[1, p],
                            points[2, p], ux[q, i], uy[q, i], slip[q, i], ux2[q, i], uy2[q, i],
                            slip2[q, i], sn[r, i], sna[r, i], snb[r, i], s1[r, i], sa1[r, i],
                            sb1[r, i], s2[r, i], sa2[r, i], sb2[r, i], se[r, i])  # fmt: skip
                for i in range(LANES):
                    n, na, nb, t1, ta1, tb1, t2, ta2, tb2, e = gather(sn[0, i], sn[1, i], sn[2, i],
                        sna[0, i], sna[1, i], sna[2, i], snb[0, i], snb[1, i], snb[2, i], s1[0, i],
                        s1[1, i], s1[2, i], sa1[0, i], sa1[1, i], sa1[2, i], sb1[0, i], sb1[1, i],
                        sb1[2, i], s2[0, i], s2[1, i], s2[2, i], sa2[0, i], sa2[1, i], sa2[2, i],
                        sb2[0, i], sb2[1, i], sb2[2, i], se[0, i], se[1, i], se[2, i])  # fmt: skip
                    load_blocks(live[i] == 1, qx[h, i], qy[h, i], qz[h, i], qw[h, i], area[i],
                        p1[i], p2[i], p3[i], d1[i], d2[i], d3[i], a1[i], a2[i], a3[i], b1[i], b2[i],
                        b3[i], n, na, nb, t1, ta1, tb1, t2, ta2, tb2, e, fx[k, i], fy[k, i],
                        fz[k, i], mx[k, i], my[k, i], mz[k, i], fx[h, i], fy[h, i], fz[h, i],
                        mx[h, i], my[h, i], mz[h, i], stored[i])  # fmt: skip
            for k in range(1, bodies):
                for i in range(LANES):
                    integrate(live[i] == 1, blocks[k, first + i], knobs, dt[i], span[i], dv[0, i],
                        dv[1, i], dv[2, i], x[k, i], y[k, i], z[k, i], qx[k, i], qy[k, i], qz[k, i],
                        qw[k, i], vx[k, i], vy[k, i], vz[k, i], lx[k, i], ly[k, i], lz[k, i],
                        fx[k, i], fy[k, i], fz[k, i], mx[k, i], my[k, i], mz[k, i],
                        loss[i])  # fmt: skip
                    observe_block(live[i] == 1, real(steps[i]) * dt[i], blocks[k, first + i],
                        qx[k, i], qy[k, i], qz[k, i], qw[k, i], x[k, i] + y[k, i] + z[k, i],
                        gx[k, i], gy[k, i], peak[k, i], at[k, i], across[k, i], tilt[k, i],
                        yaw[k, i], slide[k, i], mode[i])  # fmt: skip
        if found.attitudes.shape[0] > 0:
            for k in range(1, bodies):
                for i in range(LANES):
                    was = pose_before(blocks[k, first + i],
                        time_past(until, steps[i], dt[i], mode[i]), qx[k, i], qy[k, i], qz[k, i],
                        qw[k, i], lx[k, i], ly[k, i], lz[k, i], x[k, i], y[k, i], z[k, i], vx[k, i],
                        vy[k, i], vz[k, i])  # fmt: skip
                    for c in range(4):
                        found.attitudes[sample, k, c, first + i] = was[c]
                    for c in range(4, wp.where(found.places.shape[0] > 0, 7, 4)):
                        found.places[sample, k, c - 4, first + i] = was[c]
    for i in range(LANES):
        lost = spent[i] - (stored[i] - at_start[i])
        found.results[first + i] = Result(lifted[i], moved[i], lost, deepest[i], impacts[i],
            mode[i], steps[i])  # fmt: skip
        for k in range(1, bodies):
            found.blocks[k, first + i] = BlockResult(qz[k, i], qw[k, i], gx[k, i], gy[k, i],
                peak[k, i], at[k, i], across[k, i], tilt[k, i], yaw[k, i], slide[k, i])  # fmt: skip
