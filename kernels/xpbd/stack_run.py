"""Runs of the position-level step over stacks of blocks: LANES stacks a thread, side by side.

A single block is a stack of one. Loops over the lanes are innermost and work on local matrices,
one row a body or a point, so that the compiler turns them into vector code; with one lane a thread
the same text is the plain form for any device. A func takes the entries of the matrices, and what
it finds it leaves in those that it takes as `wp.ref`.

A run begins with SETTLING solves at the start; for what it shares with other stacks see
shape/stack_run.py.
"""

import warp as wp

from warprock.kernels.account import book
from warprock.kernels.instance import ONE_VECTOR
from warprock.kernels.motion import Motion, base_velocity, sample_index, sample_segment
from warprock.kernels.shape.stack_found import BlockResult, Found, Result, at_sample
from warprock.kernels.shape.stack_run_flat import (
    Block,
    Stack,
    balance,
    begin_step,
    observe,
    part_kept,
    start_block,
    start_lane,
)
from warprock.kernels.xpbd.stack import (
    LOOSE,
    TURNS,
    Knobs,
    anchor_after,
    find_contact,
    integrate,
    predict,
    solve,
)

wp.set_module_options(ONE_VECTOR)

LEVEL = real(1.0)
"""Cosine of the ground's rotation, as predicted, too."""
SETTLING = 40 * BLOCKS
"""Solves before the run. A stack that stands flat starts from its statics, and needs none."""
BEFORE = real(SETTLING)

Lane = wp.types.vector(length=LANES, dtype=real)
LaneInt = wp.types.vector(length=LANES, dtype=int)
Body = wp.types.matrix(shape=(BLOCKS + 1, LANES), dtype=real)
BodyInt = wp.types.matrix(shape=(BLOCKS + 1, LANES), dtype=int)
Point = wp.types.matrix(shape=(2 * BLOCKS, LANES), dtype=real)
Move = wp.types.matrix(shape=(2 * BLOCKS + 2, LANES), dtype=real)
Pass = wp.types.matrix(shape=(4 * BLOCKS, LANES), dtype=real)


@wp.func
def start_pose_pass(
    qx: wp.ref[real], qz: real, qo: wp.ref[real], n1: wp.ref[real], t1: wp.ref[real],
    n2: wp.ref[real], t2: wp.ref[real], rx: wp.ref[real], rz: wp.ref[real], ro: wp.ref[real],
    pose_n1: wp.ref[real], pose_t1: wp.ref[real], pose_n2: wp.ref[real], pose_t2: wp.ref[real],
    even: real,
):  # fmt: skip
    """Starts the pose pass of a block from what the velocity pass has found, see `balance`."""
    balance(even, n1, t1, n2, t2, qx, qo)
    rx = qx
    rz = qz
    ro = qo
    pose_n1 = n1
    pose_t1 = t1
    pose_n2 = n2
    pose_t2 = t2


@wp.func
def integrate_block(
    live: bool, time: real, kept: real, dv: real, knobs: Knobs, m: real, j: real, mu: real,
    qx: real, qz: real, qo: real, rx: real, rz: real, ro: real, lean: real, n1: real, pose_n1: real,
    pose_t1: real, n2: real, pose_n2: real, pose_t2: real, x: wp.ref[real], z: wp.ref[real],
    theta: wp.ref[real], s: wp.ref[real], c: wp.ref[real], vx: wp.ref[real], vz: wp.ref[real],
    omega: wp.ref[real], anchor1: wp.ref[real], anchor2: wp.ref[real], loss: wp.ref[real],
    given: wp.ref[real], since: wp.ref[real], left: wp.ref[int], right: wp.ref[int],
    uplift_time: wp.ref[real], moved: wp.ref[real], deepest: wp.ref[real], impacts: wp.ref[int],
    below: real, lomega: real, half_width: real, half_height: real, lhalf_width: real,
    lhalf_height: real, ls: real, lc: real, lx: real, lz: real, offset: real, peak: wp.ref[real],
    peak_time: wp.ref[real], slide: wp.ref[real], peak_slide: wp.ref[real], crept: wp.ref[real],
    mode: wp.ref[int], even: real,
):  # fmt: skip
    """Ends a step of a block, see `integrate`; it keeps a part of its velocity (`kept`).

    For what is seen of it and of its interface see `observe` in shape/stack_run.py; (lx, lz) is the
    centre of the body below.
    """
    a, b, e, f = real(pose_n1), real(pose_t1), real(pose_n2), real(pose_t2)
    way, turned = real(rx), real(ro)
    balance(even, a, b, e, f, way, turned)
    integrate(
        live, dv, knobs, m, j, qx, qz, qo, way, rz, turned, x, z, theta, s, c, vx, vz, omega, loss,
        given,
    )  # fmt: skip
    vx = kept * vx
    vz = kept * vz
    omega = kept * omega
    anchor1 = anchor_after(mu, a, b, anchor1)
    anchor2 = anchor_after(mu, e, f, anchor2)
    observe(
        live, time, knobs.time_step, knobs.gravity, lean, n1, n2, theta, below, vx, vz, omega,
        lomega, half_width, half_height, s, c, offset, lhalf_width, lhalf_height, ls, lc, x - lx,
        z - lz, z, since, left, right, uplift_time, moved, deepest, impacts, peak, peak_time, slide,
        peak_slide, crept, mode,
    )  # fmt: skip


@wp.kernel
def run_lanes(
    blocks: wp.array2d(dtype=Block), lanes: wp.array(dtype=Stack), motions: wp.array(dtype=Motion),
    pool: wp.array2d(dtype=real), sample_times: wp.array(dtype=real), knobs: Knobs, found: Found,
):  # fmt: skip
    """Runs LANES lanes a thread, all at the same time."""
    # Rows of bodies, the ground first: what they are, where, how fast, and what is kept of them.
    half_w, half_h, m, j, mu, offset, far = Body(), Body(), Body(), Body(), Body(), Body(), Body()
    x, z, theta, s, c, ps, pc = Body(), Body(), Body(), Body(), Body(), Body(), Body(LEVEL)
    vx, vz, omega, lean, peak, when, slide = Body(), Body(), Body(), Body(), Body(), Body(), Body()
    # Rows of points, two an interface; then of bodies and points in the one and the other pass.
    nx, nz, au, bu, al, bl, ds = Point(), Point(), Point(), Point(), Point(), Point(), Point()
    anchor, qx, qz, qo, left, right = Point(LOOSE), Move(), Move(), Move(), BodyInt(), BodyInt()
    need, slip, dn, n, t, since, crept = Pass(), Pass(), Pass(), Pass(), Pass(), Body(), Body()
    base, dv, hint, loss, lift, last, deep = Lane(), Lane(), Lane(), Lane(), Lane(), Lane(), Lane()
    given, jolt, most, taken, back, even = Lane(), Lane(), Lane(), Lane(), Lane(), Lane()
    hit, mode, lives, steps = LaneInt(), LaneInt(), LaneInt(), LaneInt()
    pack, _one = wp.tid()
    bodies, points, first = int(BLOCKS + 1), int(2 * BLOCKS), pack * LANES  # loops stay
    count, sweeps, dt = int(-SETTLING), int(ITERATIONS // TURNS), knobs.time_step
    time = -BEFORE * dt
    for i in range(LANES):
        start_lane(lanes[first + i], half_w[0, i], c[0, i], lift[i], mode[i], even[i])
        for k in range(1, bodies):
            start_block(
                blocks[k - 1, first + i], lanes[first + i].lean, half_w[k, i], half_h[k, i],
                m[k, i], j[k, i], mu[k, i], offset[k, i], x[k, i], z[k, i], theta[k, i], s[k, i],
                c[k, i], peak[k, i], lean[k, i], n[2 * k - 2, i], n[2 * k - 1, i],
            )  # fmt: skip
    for sample in range(sample_times.shape[0]):
        while time < sample_times[sample]:
            count += 1
            time = real(count) * dt
            half, kept = larger(time - HALF * dt, HALF * dt), part_kept(count)
            for i in range(LANES):
                lane = motions[first + i]
                line = sample_index(lane, sample_segment(lane, half))
                v = base_velocity(lane, half, pool[2, line], pool[0, line], pool[1, line])
                begin_step(v, count, mode[i], lives[i], dv[i], hint[i], base[i], steps[i], even[i])
                book(dv[i], given[i], loss[i], jolt[i], most[i], taken[i], back[i])
            for k in range(1, bodies):
                p, q = 2 * k - 2, 2 * k - 1
                for i in range(LANES):
                    predict(dv[i], hint[i], knobs, theta[k - 1, i], omega[k - 1, i], theta[k, i],
                        omega[k, i], vx[k, i], vz[k, i], ps[k, i], pc[k, i], qx[k, i], qz[k, i],
                        qo[k, i], lean[k, i], n[p, i], t[p, i], anchor[p, i], n[q, i], t[q, i],
                        anchor[q, i])  # fmt: skip
            for p in range(points):
                low, k, r, turn = p // 2, p // 2 + 1, points + p, real(2 * (p % 2) - 1)
                for i in range(LANES):
                    find_contact(
                        turn * lean[k, i], half_w[k, i], half_h[k, i], s[k, i], c[k, i], ps[k, i],
                        pc[k, i], m[k, i], j[k, i], half_w[low, i], half_h[low, i], s[low, i],
                        c[low, i], ps[low, i], pc[low, i], m[low, i], j[low, i], x[k, i], z[k, i],
                        vx[k, i], vz[k, i], x[low, i], z[low, i], vx[low, i], vz[low, i], knobs,
                        nx[p, i], nz[p, i], au[p, i], bu[p, i], al[p, i], bl[p, i], need[p, i],
                        slip[p, i], dn[p, i], need[r, i], slip[r, i], dn[r, i], ds[p, i],
                        anchor[p, i], n[p, i], t[p, i], qx[k, i], qz[k, i], qo[k, i], qx[low, i],
                        qz[low, i], qo[low, i])  # fmt: skip
            for part in range(2):  # Velocities, then poses, which start from what those took.
                for k in range(1, bodies * part):
                    p, q, u = 2 * k - 2, 2 * k - 1, bodies + k
                    r, w = points + p, points + q
                    for i in range(LANES):
                        start_pose_pass(
                            qx[k, i], qz[k, i], qo[k, i], n[p, i], t[p, i], n[q, i], t[q, i],
                            qx[u, i], qz[u, i], qo[u, i], n[r, i], t[r, i], n[w, i], t[w, i],
                            even[i])  # fmt: skip
                for step in range(sweeps * BLOCKS):
                    k, p, q = step % BLOCKS + 1, step % BLOCKS * 2, step % BLOCKS * 2 + 1
                    u, r, w = k + part * bodies, p + part * points, q + part * points
                    for i in range(LANES):
                        solve(
                            mu[k, i], m[k, i], j[k, i], m[k - 1, i], j[k - 1, i], nx[p, i],
                            nz[p, i], au[p, i], bu[p, i], al[p, i], bl[p, i], need[r, i],
                            slip[r, i], dn[r, i], ds[p, i], nx[q, i], nz[q, i], au[q, i], bu[q, i],
                            al[q, i], bl[q, i], need[w, i], slip[w, i], dn[w, i], ds[q, i], n[r, i],
                            t[r, i], n[w, i], t[w, i], qx[u, i], qz[u, i], qo[u, i], qx[u - 1, i],
                            qz[u - 1, i], qo[u - 1, i])  # fmt: skip
            for k in range(1, bodies):
                low, p, q, u = k - 1, 2 * k - 2, 2 * k - 1, bodies + k
                r, w = points + p, points + q
                for i in range(LANES):
                    integrate_block(
                        lives[i] > 0, time, kept, dv[i], knobs, m[k, i], j[k, i], mu[k, i],
                        qx[k, i], qz[k, i], qo[k, i], qx[u, i], qz[u, i], qo[u, i], lean[k, i],
                        n[p, i], n[r, i], t[r, i], n[q, i], n[w, i], t[w, i], x[k, i], z[k, i],
                        theta[k, i], s[k, i], c[k, i], vx[k, i], vz[k, i], omega[k, i],
                        anchor[p, i], anchor[q, i], loss[i], given[i], since[k, i], left[k, i],
                        right[k, i], lift[i], last[i], deep[i], hit[i], theta[low, i],
                        omega[low, i], half_w[k, i], half_h[k, i], half_w[low, i], half_h[low, i],
                        s[low, i], c[low, i], x[low, i], z[low, i], offset[k, i], peak[k, i],
                        when[k, i], slide[k, i], far[k, i], crept[k, i], mode[i],
                        even[i])  # fmt: skip
        past = time - sample_times[sample]
        if found.rotations.shape[0] > 0:
            for k in range(1, bodies):
                for i in range(LANES):
                    turn = at_sample(mode[i], past, theta[k, i], omega[k, i])
                    found.rotations[sample, k - 1, first + i] = turn
                    if found.places.shape[0] > 0:
                        o, f = k - 1, first + i
                        found.places[sample, o, 0, f] = at_sample(mode[i], past, x[k, i], vx[k, i])
                        found.places[sample, o, 1, f] = at_sample(mode[i], past, z[k, i], vz[k, i])
    for i in range(LANES):
        book(dv[i], given[i], loss[i], jolt[i], most[i], taken[i], back[i])
        found.results[first + i] = Result(lift[i], last[i], loss[i], jolt[i], most[i], back[i],
            deep[i], hit[i], mode[i], steps[i])  # fmt: skip
        for k in range(1, bodies):
            block = BlockResult(slide[k, i], peak[k, i], when[k, i], far[k, i])
            found.blocks[k - 1, first + i] = block
