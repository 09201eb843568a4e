"""Runs of the position-level step over stacks of blocks: LANES stacks a thread, side by side.

A single block is a stack of one. Loops over the lanes are innermost and work on local matrices,
one row a body or a point, so that the compiler turns them into vector code; with one lane a thread
the same text is the plain form for any device. A func takes the entries of the matrices, and what
it finds it leaves in those that it takes as `wp.ref`.

A run begins with SETTLING solves at the start, from velocities of zero, so that the multipliers
become those of the rest or of the release. Half a step back from the acceleration that they leave
lie the velocities that the first step starts from: velocities belong to half steps.

An interface rocks while one of its ends carries nothing; that needs no tolerance.
"""

# A func leaves what it finds in the names that it takes by reference.
# ruff: noqa: F841

from typing import Any

import warp as wp

from warprock.kernels.instance import kernel_module

real: Any
PRECISION: str
MOTION: str
ITERATIONS: int
BLOCKS: int
LANES: int

scalar = kernel_module("scalar", precision=PRECISION)
found_of = kernel_module("stack_found", precision=PRECISION)
motion = kernel_module("motion", precision=PRECISION, motion=MOTION)
account = kernel_module("account", precision=PRECISION)
xpbd = kernel_module("xpbd", precision=PRECISION, iterations=ITERATIONS, blocks=BLOCKS)
impulse = kernel_module("impulse_stack", precision=PRECISION)
wp.set_module_options(impulse.STACK_OPTIONS)
larger, smaller, size, book = scalar.larger, scalar.smaller, scalar.size, account.book
sine, cosine = scalar.sine, scalar.cosine
BlockResult, Result, Found = found_of.BlockResult, found_of.Result, found_of.Found
Motion, base_velocity = motion.Motion, motion.velocity
sample_index, sample_segment = motion.sample_index, motion.sample_segment
Knobs, predict, approach, sweep = xpbd.Knobs, xpbd.predict, xpbd.approach, xpbd.sweep
travel, held, TURNS, LOOSE = xpbd.travel, xpbd.held, xpbd.TURNS, xpbd.LOOSE
stand, GROUND_FACE = impulse.stand, impulse.GROUND_FACE

HALF_PI = real(1.5707963267948966)
HALF = real(0.5)
NEVER = real(1.0e30)
SETTLING = 40 * BLOCKS
"""Solves before the run. A stack that stands flat starts from its statics, and needs none."""
ROCKING = 1
OVERTURNED = 2
BROKEN = 3
SLID_OFF = 4


@wp.struct
class Block:
    """One block of a stack, and where it starts; names as at the head of `xpbd`.

    `left` and `right` are first guesses of the normal multipliers below it, at -x and at +x [kg m].
    """

    face: real
    high: real
    inverse_mass: real
    inverse_inertia: real
    friction: real
    offset: real
    x: real
    z: real
    theta: real
    left: real
    right: real


@wp.struct
class Stack:
    """One lane's stack.

    That is: the time at which it is first uplifted [s], 0 or NEVER, and the side to which its
    interfaces count as leaning before they turn, 1 or -1, mirrored with the stack.
    """

    uplift_time: real
    lean: real


Lane = wp.types.vector(length=LANES, dtype=real)
LaneInt = wp.types.vector(length=LANES, dtype=int)
Body = wp.types.matrix(shape=(BLOCKS + 1, LANES), dtype=real)
Point = wp.types.matrix(shape=(2 * BLOCKS, LANES), dtype=real)
Move = wp.types.matrix(shape=(2 * BLOCKS + 2, LANES), dtype=real)
Pass = wp.types.matrix(shape=(4 * BLOCKS, LANES), dtype=real)


@wp.func
def begin(
    stack: Stack, face: wp.ref[real], c: wp.ref[real], pc: wp.ref[real],
    uplift_time: wp.ref[real], mode: wp.ref[int],
):  # fmt: skip
    """Lays the ground, which has a face and is level, and sets a lane going."""
    face = GROUND_FACE
    c = real(1.0)
    pc = real(1.0)
    uplift_time = stack.uplift_time
    mode = ROCKING


@wp.func
def set_up(
    block: Block, side: real, face: wp.ref[real], high: wp.ref[real],
    m: wp.ref[real], j: wp.ref[real], mu: wp.ref[real], offset: wp.ref[real],
    x: wp.ref[real], z: wp.ref[real], theta: wp.ref[real], s: wp.ref[real], c: wp.ref[real],
    peak: wp.ref[real], lean: wp.ref[real], n1: wp.ref[real], n2: wp.ref[real],
):  # fmt: skip
    """Puts a block where it starts."""
    face = block.face
    high = block.high
    m = block.inverse_mass
    j = block.inverse_inertia
    mu = block.friction
    offset = block.offset
    x = block.x
    z = block.z
    theta = block.theta
    s = sine(block.theta)
    c = cosine(block.theta)
    peak = size(block.theta)
    lean = side
    n1 = wp.where(side > real(0.0), block.left, block.right)
    n2 = wp.where(side > real(0.0), block.right, block.left)


@wp.func
def kept_of(count: int) -> real:
    """Part of the new velocities that a step keeps: while multipliers settle they are put back."""
    return wp.where(count > 0, real(1.0), wp.where(count == 0, -HALF, real(0.0)))


@wp.func
def shown(mode: int, past: real, theta: real, omega: real) -> real:
    """Rotation at a sample that a lane has passed by a time [s]; where it ended, its last one.

    Nothing stops the velocities of a lane that has ended, they need not be finite.
    """
    back = larger(past, real(0.0)) * omega
    return theta - wp.where(mode == ROCKING, back, real(0.0))


@wp.func
def ride(
    v: real, count: int, mode: int, live: wp.ref[int],
    dv: wp.ref[real], hint: wp.ref[real], base: wp.ref[real], steps: wp.ref[int],
):  # fmt: skip
    """Begins a step after which the base moves at v [m/s], of a lane that lives on or not.

    That is kept in `live`, for the loop that writes the modes would be slow if it read them to
    tell what moves. While multipliers settle, v is that of the first step; the hint tells which
    way the base is about to move.
    """
    hint = v - base
    dv = wp.where(count > 0, v - base, real(0.0))
    base = wp.where(count > 0, v, base)
    live = wp.where(count > 0 and mode == ROCKING, 1, 0)
    steps = steps + live


@wp.func
def start_poses(
    qx: real, qz: real, qo: real, n1: real, t1: real, n2: real, t2: real,
    rx: wp.ref[real], rz: wp.ref[real], ro: wp.ref[real],
    pose_n1: wp.ref[real], pose_t1: wp.ref[real], pose_n2: wp.ref[real], pose_t2: wp.ref[real],
):  # fmt: skip
    """Starts the pose pass of a block from what the velocity pass has found."""
    rx = qx
    rz = qz
    ro = qo
    pose_n1 = n1
    pose_t1 = t1
    pose_n2 = n2
    pose_t2 = t2


@wp.func
def observe(
    live: bool, time: real, theta: real, below: real,
    face: real, high: real, s: real, c: real, lface: real, lhigh: real, ls: real, lc: real,
    dx: real, dz: real, offset: real,
    peak: wp.ref[real], peak_time: wp.ref[real], slide: wp.ref[real], peak_slide: wp.ref[real],
    mode: wp.ref[int],
):  # fmt: skip
    """Peaks and slide of a block after a step, and whether its lane lives on.

    `below` is the rotation of what it stands on [rad]: a block has overturned, too, once it has
    turned by a right angle against that.
    """
    zero = real(0.0)
    turn = theta - below
    slid, overlap = stand(face, high, s, c, offset, lface, lhigh, ls, lc, dx, dz, turn)
    higher = live and size(theta) > peak
    peak_time = wp.where(higher, time, peak_time)
    peak = wp.where(higher, smaller(size(theta), HALF_PI), peak)
    slide = slid
    peak_slide = wp.where(live, larger(size(slid), peak_slide), peak_slide)
    total = theta + overlap
    stands = wp.where(overlap <= zero, SLID_OFF, ROCKING)
    over = larger(size(theta), size(turn)) >= HALF_PI
    found = wp.where(over, OVERTURNED, stands)
    mode = wp.where(live and mode == ROCKING, wp.where(total - total == zero, found, BROKEN), mode)


@wp.func
def finish(
    live: bool, time: real, kept: real, dv: real, knobs: Knobs, m: real, j: real, mu: real,
    qx: real, qz: real, qo: real, rx: real, rz: real, ro: real,
    n1: real, was1: real, gap1: real, pose_n1: real, pose_t1: real,
    n2: real, was2: real, gap2: real, pose_n2: real, pose_t2: real,
    x: wp.ref[real], z: wp.ref[real], theta: wp.ref[real], s: wp.ref[real], c: wp.ref[real],
    vx: wp.ref[real], vz: wp.ref[real], omega: wp.ref[real],
    anchor1: wp.ref[real], anchor2: wp.ref[real], loss: wp.ref[real], given: wp.ref[real],
    mode: wp.ref[int], uplift_time: wp.ref[real], moved: wp.ref[real], deepest: wp.ref[real],
    impacts: wp.ref[int], below: real, face: real, high: real, lface: real, lhigh: real, ls: real,
    lc: real, lx: real, lz: real, offset: real, peak: wp.ref[real], peak_time: wp.ref[real],
    slide: wp.ref[real], peak_slide: wp.ref[real],
):  # fmt: skip
    """Ends a step of a block, see `travel`; whether that is finite, and its interface rocks.

    It keeps a part of its velocity (`kept`). Ends have landed whose multiplier was nothing in the
    last step; their gaps are those at the start of the step. From `below` on, see `observe`;
    (lx, lz) is the centre of the body below.
    """
    zero = real(0.0)
    travel(
        live, dv, knobs, m, j, qx, qz, qo, rx, rz, ro, x, z, theta, s, c, vx, vz, omega, loss,
        given,
    )  # fmt: skip
    speed = vx + vz + omega
    mode = wp.where(live and mode == ROCKING and speed - speed != zero, BROKEN, mode)
    vx = kept * vx
    vz = kept * vz
    omega = kept * omega
    anchor1 = held(mu, pose_n1, pose_t1, anchor1)
    anchor2 = held(mu, pose_n2, pose_t2, anchor2)
    lifted = live and (n1 <= zero or n2 <= zero)
    landed1 = wp.where(live and was1 <= zero and n1 > zero, 1, 0)
    landed2 = wp.where(live and was2 <= zero and n2 > zero, 1, 0)
    uplift_time = wp.where(lifted and uplift_time >= NEVER, time, uplift_time)
    moved = wp.where(lifted, time, moved)
    impacts = impacts + landed1 + landed2
    deepest = wp.where(live, larger(-smaller(gap1, gap2), deepest), deepest)
    observe(
        live, time, theta, below, face, high, s, c, lface, lhigh, ls, lc, x - lx, z - lz, offset,
        peak, peak_time, slide, peak_slide, mode,
    )  # fmt: skip


@wp.kernel
def stacks(
    blocks: wp.array2d(dtype=Block), lanes: wp.array(dtype=Stack), motions: wp.array(dtype=Motion),
    pool: wp.array2d(dtype=real), sample_times: wp.array(dtype=real), knobs: Knobs, found: Found,
):  # fmt: skip
    """Runs LANES lanes a thread, all at the same time."""
    # Rows of bodies, the ground first: what they are, where, how fast, and what is kept of them.
    face, high, m, j, mu, offset, far = Body(), Body(), Body(), Body(), Body(), Body(), Body()
    x, z, theta, s, c, ps, pc = Body(), Body(), Body(), Body(), Body(), Body(), Body()
    vx, vz, omega, lean, peak, when, slide = Body(), Body(), Body(), Body(), Body(), Body(), Body()
    # Rows of points, two an interface; then of bodies and points in the one and the other pass.
    nx, nz, au, bu, al, bl, ds = Point(), Point(), Point(), Point(), Point(), Point(), Point()
    was, anchor, qx, qz, qo = Point(), Point(LOOSE), Move(), Move(), Move()
    need, slip, dn, n, t = Pass(), Pass(), Pass(), Pass(), Pass()
    base, dv, hint, loss, lift, last, deep = Lane(), Lane(), Lane(), Lane(), Lane(), Lane(), Lane()
    given, jolt, most, taken, back = Lane(), Lane(), Lane(), Lane(), Lane()
    hit, mode, lives, steps = LaneInt(), LaneInt(), LaneInt(), LaneInt()
    # Counts that Warp does not know, so that it writes out none of the loops over them.
    bodies, points, sweeps = int(BLOCKS + 1), int(2 * BLOCKS), int(ITERATIONS // TURNS)
    first, dt = wp.tid() * LANES, knobs.time_step
    for i in range(LANES):
        begin(lanes[first + i], face[0, i], c[0, i], pc[0, i], lift[i], mode[i])
        for k in range(1, bodies):
            set_up(
                blocks[k - 1, first + i], lanes[first + i].lean, face[k, i], high[k, i], m[k, i],
                j[k, i], mu[k, i], offset[k, i], x[k, i], z[k, i], theta[k, i], s[k, i], c[k, i],
                peak[k, i], lean[k, i], n[2 * k - 2, i], n[2 * k - 1, i],
            )  # fmt: skip
    count, time = int(-SETTLING), -real(SETTLING) * dt
    for sample in range(sample_times.shape[0]):
        while time < sample_times[sample]:
            count += 1
            time = real(count) * dt
            half, kept = larger(time - HALF * dt, HALF * dt), kept_of(count)
            for i in range(LANES):
                lane = motions[first + i]
                line = sample_index(lane, sample_segment(lane, half))
                v = base_velocity(lane, half, pool[2, line], pool[0, line], pool[1, line])
                ride(v, count, mode[i], lives[i], dv[i], hint[i], base[i], steps[i])
                book(dv[i], given[i], loss[i], jolt[i], most[i], taken[i], back[i])
            for k in range(1, bodies):
                p, q = 2 * k - 2, 2 * k - 1
                for i in range(LANES):
                    predict(
                        dv[i], hint[i], knobs, theta[k - 1, i], omega[k - 1, i], theta[k, i],
                        omega[k, i], vx[k, i], vz[k, i], ps[k, i], pc[k, i], qx[k, i], qz[k, i],
                        qo[k, i], lean[k, i], n[p, i], t[p, i], anchor[p, i], n[q, i], t[q, i],
                        anchor[q, i],
                    )  # fmt: skip
            for p in range(points):
                low, k, r, turn = p // 2, p // 2 + 1, points + p, real(2 * (p % 2) - 1)
                for i in range(LANES):
                    approach(
                        turn * lean[k, i], face[k, i], high[k, i], s[k, i], c[k, i], ps[k, i],
                        pc[k, i], m[k, i], j[k, i], face[low, i], high[low, i], s[low, i],
                        c[low, i], ps[low, i], pc[low, i], m[low, i], j[low, i], x[k, i], z[k, i],
                        vx[k, i], vz[k, i], x[low, i], z[low, i], vx[low, i], vz[low, i], knobs,
                        nx[p, i], nz[p, i], au[p, i], bu[p, i], al[p, i], bl[p, i], need[p, i],
                        slip[p, i], dn[p, i], need[r, i], slip[r, i], dn[r, i], ds[p, i],
                        anchor[p, i], was[p, i], n[p, i], t[p, i], qx[k, i], qz[k, i], qo[k, i],
                        qx[low, i], qz[low, i], qo[low, i],
                    )  # fmt: skip
            for part in range(2):  # Velocities, then poses, which start from what those took.
                for k in range(1, bodies * part):
                    p, q, u = 2 * k - 2, 2 * k - 1, bodies + k
                    r, w = points + p, points + q
                    for i in range(LANES):
                        start_poses(
                            qx[k, i], qz[k, i], qo[k, i], n[p, i], t[p, i], n[q, i], t[q, i],
                            qx[u, i], qz[u, i], qo[u, i], n[r, i], t[r, i], n[w, i], t[w, i],
                        )  # fmt: skip
                for step in range(sweeps * BLOCKS):
                    k, p, q = step % BLOCKS + 1, step % BLOCKS * 2, step % BLOCKS * 2 + 1
                    u, r, w = k + part * bodies, p + part * points, q + part * points
                    for i in range(LANES):
                        sweep(
                            mu[k, i], m[k, i], j[k, i], m[k - 1, i], j[k - 1, i], nx[p, i],
                            nz[p, i], au[p, i], bu[p, i], al[p, i], bl[p, i], need[r, i],
                            slip[r, i], dn[r, i], ds[p, i], nx[q, i], nz[q, i], au[q, i], bu[q, i],
                            al[q, i], bl[q, i], need[w, i], slip[w, i], dn[w, i], ds[q, i], n[r, i],
                            t[r, i], n[w, i], t[w, i], qx[u, i], qz[u, i], qo[u, i], qx[u - 1, i],
                            qz[u - 1, i], qo[u - 1, i],
                        )  # fmt: skip
            for k in range(1, bodies):
                low, p, q, u = k - 1, 2 * k - 2, 2 * k - 1, bodies + k
                r, w = points + p, points + q
                for i in range(LANES):
                    finish(
                        lives[i] > 0, time, kept, dv[i], knobs, m[k, i], j[k, i], mu[k, i],
                        qx[k, i], qz[k, i], qo[k, i], qx[u, i], qz[u, i], qo[u, i], n[p, i],
                        was[p, i], need[r, i] - need[p, i], n[r, i], t[r, i], n[q, i], was[q, i],
                        need[w, i] - need[q, i], n[w, i], t[w, i], x[k, i], z[k, i], theta[k, i],
                        s[k, i], c[k, i], vx[k, i], vz[k, i], omega[k, i], anchor[p, i],
                        anchor[q, i], loss[i], given[i], mode[i], lift[i], last[i], deep[i],
                        hit[i], theta[low, i], face[k, i], high[k, i], face[low, i],
                        high[low, i], s[low, i], c[low, i], x[low, i], z[low, i], offset[k, i],
                        peak[k, i], when[k, i], slide[k, i], far[k, i],
                    )  # fmt: skip
        if found.rotations.shape[0] > 0:
            for k in range(1, bodies):
                for i in range(LANES):
                    turn = shown(mode[i], time - sample_times[sample], theta[k, i], omega[k, i])
                    found.rotations[sample, k - 1, first + i] = turn
    for i in range(LANES):
        book(dv[i], given[i], loss[i], jolt[i], most[i], taken[i], back[i])
        found.results[first + i] = Result(
            lift[i], last[i], loss[i], jolt[i], most[i], back[i], deep[i], hit[i], mode[i], steps[i]
        )
        for k in range(1, bodies):
            block = BlockResult(slide[k, i], peak[k, i], when[k, i], far[k, i])
            found.blocks[k - 1, first + i] = block
