"""Runs of the impulse step over stacks of blocks: LANES stacks a thread, side by side.

Loops over the lanes are innermost and work on local matrices, one row a body or a point, so that
the compiler turns them into vector code; with one lane a thread the same text is the plain form
for any device. A func takes the entries of the matrices, and what it finds it leaves in those that
it takes as `wp.ref`: a matrix taken by reference would be copied at every read.

A run begins with SETTLING solves at the start, from velocities of zero, so that the impulses
become those of the rest or of the release. Half a step back from the acceleration that they leave
lie the velocities that the first step starts from: velocities belong to half steps.

An interface rocks while one of its ends carries no impulse; that needs no tolerance.
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
impulse = kernel_module("impulse_stack", precision=PRECISION)
wp.set_module_options(impulse.STACK_OPTIONS)
larger, smaller, size, book = scalar.larger, scalar.smaller, scalar.size, account.book
BlockResult, Result, Found = found_of.BlockResult, found_of.Result, found_of.Found
Motion, base_velocity = motion.Motion, motion.velocity
sample_index, sample_segment = motion.sample_index, motion.sample_segment
Knobs, set_out, approach, press = impulse.Knobs, impulse.set_out, impulse.approach, impulse.press
give_back, travel, work, stand = impulse.give_back, impulse.travel, impulse.work, impulse.stand
GROUND_FACE = impulse.GROUND_FACE
sine, cosine = scalar.sine, scalar.cosine

HALF_PI = real(1.5707963267948966)
HALF = real(0.5)
NEVER = real(1.0e30)
SETTLING = 200
"""Solves before the run. A stack that stands flat starts from its statics, and needs none."""
ROCKING = 1
OVERTURNED = 2
BROKEN = 3
SLID_OFF = 4


@wp.struct
class Block:
    """One block of a stack, and where it starts; names as at the head of `impulse_stack`.

    `left` and `right` are first guesses of the normal impulses below it, at -x and at +x [N s].
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


@wp.func
def begin(
    stack: Stack, face: wp.ref[real], c: wp.ref[real], uplift_time: wp.ref[real],
    mode: wp.ref[int],
):  # fmt: skip
    """Lays the ground, which has a face and is level, and sets a lane going."""
    face = GROUND_FACE
    c = real(1.0)
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
    """Part of the new velocities that a step keeps: while impulses settle they are put back."""
    return wp.where(count > 0, real(1.0), wp.where(count == 0, -HALF, real(0.0)))


@wp.func
def ride(
    v: real, count: int, mode: int, live: wp.ref[int],
    dv: wp.ref[real], hint: wp.ref[real], base: wp.ref[real],
    shift_x: wp.ref[real], shift_z: wp.ref[real], steps: wp.ref[int],
):  # fmt: skip
    """Begins a step after which the base moves at v [m/s], of a lane that lives on or not.

    That is kept in `live`, for the loop that writes the modes would be slow if it read them to
    tell what moves. While impulses settle, v is that of the first step; the hint tells which way
    the base is about to move.
    """
    hint = v - base
    dv = wp.where(count > 0, v - base, real(0.0))
    base = wp.where(count > 0, v, base)
    shift_x = real(0.0)
    shift_z = real(0.0)
    live = wp.where(count > 0 and mode == ROCKING, 1, 0)
    steps = steps + live


@wp.func
def advance(
    live: bool, kept: real, knobs: Knobs, dv: real, m: real, j: real,
    gap1: real, nx1: real, nz1: real, gap2: real, nx2: real, nz2: real,
    ux: real, uz: real, uo: real, shift_x: wp.ref[real], shift_z: wp.ref[real],
    x: wp.ref[real], z: wp.ref[real], theta: wp.ref[real], s: wp.ref[real], c: wp.ref[real],
    vx: wp.ref[real], vz: wp.ref[real], omega: wp.ref[real], loss: wp.ref[real],
    given: wp.ref[real],
):  # fmt: skip
    """Moves a block by a step; it takes over its new velocity, or a part of it (`kept`).

    The numbers 1 and 2 are the ends of the interface below it. What its contacts take from the
    energy, less what it is lifted by, is added to the loss, the base's work to what is given [J].
    """
    give_back(gap1, nx1, nz1, gap2, nx2, nz2, knobs, shift_x, shift_z)
    fall = knobs.time_step * knobs.gravity
    done = work(dv, fall, m / j, vx, vz, omega, ux, uz, uo)
    loss = loss - wp.where(live, (done + knobs.gravity * shift_z) / m, real(0.0))
    given = given - wp.where(live, HALF * dv * (vx + ux) / m, real(0.0))
    travel(live, knobs.time_step, shift_x, shift_z, ux, uz, uo, x, z, theta, s, c)
    vx = kept * ux
    vz = kept * uz
    omega = kept * uo


@wp.func
def witness(
    live: bool, time: real, n1: real, was1: real, gap1: real, n2: real, was2: real, gap2: real,
    uplift_time: wp.ref[real], moved: wp.ref[real], deepest: wp.ref[real], impacts: wp.ref[int],
):  # fmt: skip
    """Whether an interface rocks, and which of its ends have landed: what carried nothing does.

    The gaps are those at the start of the step.
    """
    zero = real(0.0)
    lifted = live and (n1 <= zero or n2 <= zero)
    landed1 = wp.where(live and was1 <= zero and n1 > zero, 1, 0)
    landed2 = wp.where(live and was2 <= zero and n2 > zero, 1, 0)
    uplift_time = wp.where(lifted and uplift_time >= NEVER, time, uplift_time)
    moved = wp.where(lifted, time, moved)
    impacts = impacts + landed1 + landed2
    deepest = wp.where(live, larger(-smaller(gap1, gap2), deepest), deepest)


@wp.func
def observe(
    live: bool, time: real, theta: real, below: real, ux: real, uz: real, uo: real,
    face: real, high: real, s: real, c: real, offset: real,
    lface: real, lhigh: real, ls: real, lc: real, dx: real, dz: real,
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
    total = theta + ux + uz + uo + overlap
    stands = wp.where(overlap <= zero, SLID_OFF, ROCKING)
    over = larger(size(theta), size(turn)) >= HALF_PI
    found = wp.where(over, OVERTURNED, stands)
    mode = wp.where(live and mode == ROCKING, wp.where(total - total == zero, found, BROKEN), mode)


@wp.func
def shown(mode: int, past: real, theta: real, omega: real) -> real:
    """Rotation at a sample that a lane has passed by a time [s]; where it ended, its last one.

    Nothing stops the velocities of a lane that has ended, they need not be finite.
    """
    back = larger(past, real(0.0)) * omega
    return theta - wp.where(mode == ROCKING, back, real(0.0))


@wp.kernel
def stacks(
    blocks: wp.array2d(dtype=Block), lanes: wp.array(dtype=Stack), motions: wp.array(dtype=Motion),
    pool: wp.array2d(dtype=real), sample_times: wp.array(dtype=real), knobs: Knobs, found: Found,
):  # fmt: skip
    """Runs LANES lanes a thread, all at the same time."""
    first, zero, dt = wp.tid() * LANES, real(0.0), knobs.time_step
    # Rows of bodies, the ground first: what they are, where, how fast, and what is kept of them.
    face, high, m, j, mu, offset = Body(), Body(), Body(), Body(), Body(), Body()
    x, z, theta, s, c, lean = Body(), Body(), Body(), Body(), Body(), Body()
    vx, vz, omega, ux, uz, uo = Body(), Body(), Body(), Body(), Body(), Body()
    peak, peak_time, slide, peak_slide = Body(), Body(), Body(), Body()
    # Rows of points: the first and the second end of interface 1, of interface 2, ...
    nx, nz, au, bu, al, bl = Point(), Point(), Point(), Point(), Point(), Point()
    gap, pn, pt, nt, n, t, was = Point(), Point(), Point(), Point(), Point(), Point(), Point()
    base, dv, hint, loss, jolt = Lane(), Lane(), Lane(), Lane(), Lane()
    given, supplied, taken, returned = Lane(), Lane(), Lane(), Lane()
    shift_x, shift_z, uplift_time, moved, deepest = Lane(), Lane(), Lane(), Lane(), Lane()
    impacts, mode, lives, steps = LaneInt(), LaneInt(), LaneInt(), LaneInt()
    # Counts that Warp does not know, so that it writes out none of the loops over them.
    bodies, points, sweeps = int(BLOCKS + 1), int(2 * BLOCKS), int(ITERATIONS)
    for i in range(LANES):
        begin(lanes[first + i], face[0, i], c[0, i], uplift_time[i], mode[i])
        for k in range(1, bodies):
            set_up(
                blocks[k - 1, first + i], lanes[first + i].lean, face[k, i], high[k, i], m[k, i],
                j[k, i], mu[k, i], offset[k, i], x[k, i], z[k, i], theta[k, i], s[k, i], c[k, i],
                peak[k, i], lean[k, i], n[2 * k - 2, i], n[2 * k - 1, i],
            )  # fmt: skip
    count = int(-SETTLING)
    time = real(count) * dt
    for sample in range(sample_times.shape[0]):
        until = sample_times[sample]
        while time < until:
            count += 1
            time = real(count) * dt
            half, kept = larger(time - HALF * dt, HALF * dt), kept_of(count)
            for i in range(LANES):
                lane = motions[first + i]
                place = sample_index(lane, sample_segment(lane, half))
                v = base_velocity(lane, half, pool[2, place], pool[0, place], pool[1, place])
                ride(
                    v, count, mode[i], lives[i], dv[i], hint[i], base[i],
                    shift_x[i], shift_z[i], steps[i],
                )  # fmt: skip
                book(dv[i], given[i], loss[i], jolt[i], supplied[i], taken[i], returned[i])
            for k in range(1, bodies):
                for i in range(LANES):
                    set_out(
                        dv[i], hint[i], knobs, theta[k, i] - theta[k - 1, i],
                        vx[k, i], vz[k, i], omega[k, i], omega[k - 1, i],
                        ux[k, i], uz[k, i], uo[k, i], lean[k, i],
                        n[2 * k - 2, i], t[2 * k - 2, i], n[2 * k - 1, i], t[2 * k - 1, i],
                    )  # fmt: skip
            for p in range(points):
                low, k, turn = p // 2, p // 2 + 1, real(2 * (p % 2) - 1)
                for i in range(LANES):
                    approach(
                        turn * lean[k, i], face[k, i], high[k, i], s[k, i], c[k, i], m[k, i],
                        j[k, i], face[low, i], high[low, i], s[low, i], c[low, i], m[low, i],
                        j[low, i], x[k, i] - x[low, i], z[k, i] - z[low, i], knobs.collision_margin,
                        nx[p, i], nz[p, i], au[p, i], bu[p, i], al[p, i], bl[p, i], gap[p, i],
                        pn[p, i], pt[p, i], nt[p, i], was[p, i], n[p, i], t[p, i],
                        ux[k, i], uz[k, i], uo[k, i], ux[low, i], uz[low, i], uo[low, i],
                    )  # fmt: skip
            for step in range(sweeps * points):
                p, low, k = step % points, step % points // 2, step % points // 2 + 1
                for i in range(LANES):
                    press(
                        mu[k, i], gap[p, i], knobs.rate, m[k, i], j[k, i], m[low, i], j[low, i],
                        nx[p, i], nz[p, i], au[p, i], bu[p, i], al[p, i], bl[p, i],
                        pn[p, i], pt[p, i], nt[p, i], n[p, i], t[p, i],
                        ux[k, i], uz[k, i], uo[k, i], ux[low, i], uz[low, i], uo[low, i],
                    )  # fmt: skip
            for k in range(1, bodies):
                low, p, q = k - 1, 2 * k - 2, 2 * k - 1
                for i in range(LANES):
                    live = lives[i] > 0
                    advance(
                        live, kept, knobs, dv[i], m[k, i], j[k, i],
                        gap[p, i], nx[p, i], nz[p, i], gap[q, i], nx[q, i], nz[q, i],
                        ux[k, i], uz[k, i], uo[k, i], shift_x[i], shift_z[i], x[k, i], z[k, i],
                        theta[k, i], s[k, i], c[k, i], vx[k, i], vz[k, i], omega[k, i], loss[i],
                        given[i],
                    )  # fmt: skip
                    witness(
                        live, time, n[p, i], was[p, i], gap[p, i], n[q, i], was[q, i], gap[q, i],
                        uplift_time[i], moved[i], deepest[i], impacts[i],
                    )  # fmt: skip
                    observe(
                        live, time, theta[k, i], theta[low, i], ux[k, i], uz[k, i], uo[k, i],
                        face[k, i], high[k, i], s[k, i], c[k, i], offset[k, i], face[low, i],
                        high[low, i], s[low, i], c[low, i], x[k, i] - x[low, i],
                        z[k, i] - z[low, i], peak[k, i], peak_time[k, i], slide[k, i],
                        peak_slide[k, i], mode[i],
                    )  # fmt: skip
        if found.rotations.shape[0] > 0:
            for k in range(1, bodies):
                for i in range(LANES):
                    turn = shown(mode[i], time - until, theta[k, i], omega[k, i])
                    found.rotations[sample, k - 1, first + i] = turn
    for i in range(LANES):
        book(dv[i], given[i], loss[i], jolt[i], supplied[i], taken[i], returned[i])
        found.results[first + i] = Result(
            uplift_time[i], moved[i], loss[i], jolt[i], supplied[i], returned[i], deepest[i],
            impacts[i], mode[i], steps[i],
        )  # fmt: skip
        for k in range(1, bodies):
            found.blocks[k - 1, first + i] = BlockResult(
                slide[k, i], peak[k, i], peak_time[k, i], peak_slide[k, i]
            )
