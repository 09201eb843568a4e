"""Runs of the impulse step over stacks of blocks: LANES stacks a thread, side by side.

Every loop over the lanes works on local matrices, one row a body, so that the compiler turns it
into vector code; with one lane a thread the same text is the plain form for any device.

A run begins with SETTLING solves at the start, from velocities of zero: the impulses become those
of the release or of the rest, and half a step back from the acceleration that they leave lie the
velocities that the first step starts from (the velocities belong to half steps).
"""

from typing import Any

import warp as wp

from warprock.kernels.instance import kernel_module, module_options

real: Any
PRECISION: str
MOTION: str
ITERATIONS: int
BLOCKS: int
LANES: int

wp.set_module_options(module_options())
scalar = kernel_module("scalar", precision=PRECISION)
motion = kernel_module("motion", precision=PRECISION, motion=MOTION)
impulse = kernel_module("impulse_stack", precision=PRECISION)
larger, smaller, size = scalar.larger, scalar.smaller, scalar.size
sine, cosine = scalar.sine, scalar.cosine
Motion, base_velocity = motion.Motion, motion.velocity
sample_index, sample_segment = motion.sample_index, motion.sample_segment
Knobs, set_out, meet, resume = impulse.Knobs, impulse.set_out, impulse.meet, impulse.resume
press, stand = impulse.press, impulse.stand
GROUND_FACE = impulse.GROUND_FACE

HALF_PI = real(1.5707963267948966)
HALF = real(0.5)
NEVER = real(1.0e30)
SETTLING = 200
ROCKING = 1
OVERTURNED = 2
BROKEN = 3
SLID_OFF = 4


@wp.struct
class Block:
    """One block of a stack, and where it starts."""

    face: real
    high: real
    inverse_mass: real
    inverse_inertia: real
    gyration: real
    friction: real
    offset: real
    x: real
    z: real
    theta: real


@wp.struct
class Stack:
    """One lane's stack: the time at which it is first uplifted, 0 or NEVER."""

    uplift_time: real


@wp.struct
class BlockResult:
    """What one block's run leaves behind."""

    slide: real
    peak: real
    peak_time: real
    peak_slide: real


@wp.struct
class Result:
    """What one lane's run leaves behind."""

    uplift_time: real
    moved: real
    loss: real
    impacts: int
    mode: int
    steps: int


@wp.struct
class Found:
    """Where the kernel leaves what it finds."""

    results: wp.array(dtype=Result)
    blocks: wp.array2d(dtype=BlockResult)
    rotations: wp.array3d(dtype=real)


Lane = wp.types.vector(length=LANES, dtype=real)
LaneInt = wp.types.vector(length=LANES, dtype=int)
Body = wp.types.matrix(shape=(BLOCKS + 1, LANES), dtype=real)
Point = wp.types.matrix(shape=(2 * BLOCKS, LANES), dtype=real)


@wp.func
def give_back(
    gap1: real, nx1: real, nz1: real, gap2: real, nx2: real, nz2: real, knobs: Knobs,
    shift_x: wp.ref[real], shift_z: wp.ref[real],
):  # fmt: skip
    """Adds what an interface gives back of its penetration to the shift of all above it [m].

    But for the 2 g dt^2 that one step of falling can make, as for a single block.
    """
    deep = gap1 < gap2
    slack = real(2.0) * knobs.time_step * knobs.time_step * knobs.gravity
    push = knobs.erp * smaller(wp.where(deep, gap1, gap2) + slack, real(0.0))
    shift_x = shift_x - push * wp.where(deep, nx1, nx2)
    shift_z = shift_z - push * wp.where(deep, nz1, nz2)


@wp.func
def travel(
    live: bool, dt: real, shift_x: real, shift_z: real, ux: real, uz: real, uo: real,
    x: wp.ref[real], z: wp.ref[real], theta: wp.ref[real], s: wp.ref[real], c: wp.ref[real],
):  # fmt: skip
    """Moves a block that still lives by a step."""
    turned = wp.where(live, theta + dt * uo, theta)
    x = wp.where(live, x + dt * ux + shift_x, x)
    z = wp.where(live, z + dt * uz + shift_z, z)
    theta = turned
    s = sine(turned)
    c = cosine(turned)


@wp.func
def lose(
    live: bool, m: real, gyration: real, dv: real, fall: real, ux: real, uz: real, uo: real,
    kept: real, vx: wp.ref[real], vz: wp.ref[real], omega: wp.ref[real], loss: wp.ref[real],
):  # fmt: skip
    """Takes over a block's new velocity; the work of its contacts on the mean one is a loss.

    Args:
        live: Whether the block still moves.
        m: Inverse mass [1/kg].
        gyration: Square of the radius of gyration [m^2].
        dv: Change of the base velocity [m/s].
        fall: What gravity adds to a falling speed in a step [m/s].
        ux: New velocity of the centre [m/s]; uz likewise, uo the angular one [rad/s].
        uz: See ux.
        uo: See ux.
        kept: Part of the velocity that is taken over.
        vx: Velocity before, and after; vz, omega likewise.
        vz: See vx.
        omega: See vx.
        loss: Energy that the lane has lost [J].
    """
    work = (ux - vx + dv) * (vx + ux) + (uz - vz + fall) * (vz + uz)
    work = work + gyration * (uo - omega) * (omega + uo)
    loss = loss - wp.where(live, HALF * work / m, real(0.0))
    vx = kept * ux
    vz = kept * uz
    omega = kept * uo


@wp.func
def witness(
    live: bool, time: real, n1: real, old1: real, n2: real, old2: real,
    uplift_time: wp.ref[real], moved: wp.ref[real], impacts: wp.ref[int],
):  # fmt: skip
    """Whether an interface rocks (one end carries nothing), and which ends have landed."""
    zero = real(0.0)
    lifted = live and (n1 <= zero or n2 <= zero)
    landed1 = wp.where(live and old1 <= zero and n1 > zero, 1, 0)
    landed2 = wp.where(live and old2 <= zero and n2 > zero, 1, 0)
    uplift_time = wp.where(lifted and uplift_time >= NEVER, time, uplift_time)
    moved = wp.where(lifted, time, moved)
    impacts = impacts + landed1 + landed2


@wp.func
def note(
    live: bool, time: real, theta: real, speed: real, slid: real, overlap: real,
    peak: wp.ref[real], peak_time: wp.ref[real], slide: wp.ref[real], peak_slide: wp.ref[real],
    after: wp.ref[int],
):  # fmt: skip
    """Peaks of a block, and what its lane has become: `after` is what the blocks below found."""
    zero = real(0.0)
    higher = live and size(theta) > peak
    peak_time = wp.where(higher, time, peak_time)
    peak = wp.where(higher, smaller(size(theta), HALF_PI), peak)
    slide = slid
    peak_slide = wp.where(live, larger(size(slid), peak_slide), peak_slide)
    sound = theta - theta == zero and speed - speed == zero and overlap - overlap == zero
    off = wp.where(overlap <= zero, SLID_OFF, after)
    over = wp.where(size(theta) >= HALF_PI, OVERTURNED, off)
    after = wp.where(after == BROKEN or not sound, BROKEN, over)


@wp.kernel
def stacks(
    blocks: wp.array2d(dtype=Block),
    lanes: wp.array(dtype=Stack),
    motions: wp.array(dtype=Motion),
    pool: wp.array2d(dtype=real),
    sample_times: wp.array(dtype=real),
    knobs: Knobs,
    found: Found,
):
    """Runs LANES lanes a thread, all at the same time."""
    first, dt, zero = wp.tid() * LANES, knobs.time_step, real(0.0)
    # Rows of bodies, the ground first: what they are, where, how fast, and what is kept of them.
    face, high, m, j, r, mu, offset = Body(), Body(), Body(), Body(), Body(), Body(), Body()
    x, z, theta, s, c, lean = Body(), Body(), Body(), Body(), Body(), Body()
    vx, vz, omega, ux, uz, uo = Body(), Body(), Body(), Body(), Body(), Body()
    peak, peak_time, slide, peak_slide = Body(), Body(), Body(), Body()
    # Rows of points: the first and the second end of interface 1, of interface 2, ...
    nx, nz, au, bu, al, bl = Point(), Point(), Point(), Point(), Point(), Point()
    gap, pn, pt, nt, n, t, was = Point(), Point(), Point(), Point(), Point(), Point(), Point()
    base, dv, loss, shift_x, shift_z = Lane(), Lane(), Lane(), Lane(), Lane()
    uplift_time, moved, impacts = Lane(), Lane(), LaneInt()
    mode, after, steps = LaneInt(), LaneInt(), LaneInt()
    # Counts that Warp does not know, so that it writes out none of the loops over them.
    bodies, points, sweeps = int(BLOCKS + 1), int(2 * BLOCKS), int(ITERATIONS)
    for i in range(LANES):
        c[0, i] = real(1.0)
        face[0, i] = GROUND_FACE
        uplift_time[i] = lanes[first + i].uplift_time
        mode[i] = ROCKING
    for k in range(1, bodies):
        for i in range(LANES):
            one = blocks[k - 1, first + i]
            face[k, i] = one.face
            high[k, i] = one.high
            m[k, i] = one.inverse_mass
            j[k, i] = one.inverse_inertia
            r[k, i] = one.gyration
            mu[k, i] = one.friction
            offset[k, i] = one.offset
            x[k, i] = one.x
            z[k, i] = one.z
            theta[k, i] = one.theta
            s[k, i] = sine(one.theta)
            c[k, i] = cosine(one.theta)
            lean[k, i] = real(1.0)
            peak[k, i] = size(one.theta)
    count = int(-SETTLING)
    time = real(count) * dt
    for sample in range(sample_times.shape[0]):
        until = sample_times[sample]
        while time < until:
            count += 1
            time = real(count) * dt
            half = time - HALF * dt
            # While the impulses settle nothing moves, and the velocities are put back.
            kept = wp.where(count > 0, real(1.0), wp.where(count == 0, -HALF, zero))
            for i in range(LANES):
                ride = motions[first + i]
                place = sample_index(ride, sample_segment(ride, half))
                v = base_velocity(ride, half, pool[2, place], pool[0, place], pool[1, place])
                dv[i] = v - base[i]
                base[i] = v
                shift_x[i] = zero
                shift_z[i] = zero
                after[i] = ROCKING
            for k in range(1, bodies):
                for i in range(LANES):
                    set_out(
                        dv[i], knobs, theta[k, i] - theta[k - 1, i],
                        vx[k, i], vz[k, i], omega[k, i], omega[k - 1, i],
                        ux[k, i], uz[k, i], uo[k, i], lean[k, i],
                        n[2 * k - 2, i], t[2 * k - 2, i], n[2 * k - 1, i], t[2 * k - 1, i],
                    )  # fmt: skip
            for p in range(points):
                low = p // 2
                k = low + 1
                turn = real(2 * (p - 2 * low) - 1)
                for i in range(LANES):
                    meet(
                        turn * lean[k, i], face[k, i], high[k, i], s[k, i], c[k, i],
                        face[low, i], high[low, i], s[low, i], c[low, i],
                        x[k, i] - x[low, i], z[k, i] - z[low, i],
                        nx[p, i], nz[p, i], au[p, i], bu[p, i], al[p, i], bl[p, i], gap[p, i],
                    )  # fmt: skip
                    resume(
                        gap[p, i], knobs.collision_margin, m[k, i], j[k, i], m[low, i], j[low, i],
                        nx[p, i], nz[p, i], au[p, i], bu[p, i], al[p, i], bl[p, i],
                        pn[p, i], pt[p, i], nt[p, i], was[p, i], n[p, i], t[p, i],
                        ux[k, i], uz[k, i], uo[k, i], ux[low, i], uz[low, i], uo[low, i],
                    )  # fmt: skip
            for _ in range(sweeps):
                for p in range(points):
                    low = p // 2
                    k = low + 1
                    for i in range(LANES):
                        press(
                            mu[k, i], gap[p, i], knobs.rate,
                            m[k, i], j[k, i], m[low, i], j[low, i],
                            nx[p, i], nz[p, i], au[p, i], bu[p, i], al[p, i], bl[p, i],
                            pn[p, i], pt[p, i], nt[p, i], n[p, i], t[p, i],
                            ux[k, i], uz[k, i], uo[k, i], ux[low, i], uz[low, i], uo[low, i],
                        )  # fmt: skip
            for k in range(1, bodies):
                low = k - 1
                p = 2 * low
                for i in range(LANES):
                    live = count > 0 and mode[i] == ROCKING
                    give_back(
                        gap[p, i], nx[p, i], nz[p, i], gap[p + 1, i], nx[p + 1, i], nz[p + 1, i],
                        knobs, shift_x[i], shift_z[i],
                    )  # fmt: skip
                    travel(
                        live, dt, shift_x[i], shift_z[i], ux[k, i], uz[k, i], uo[k, i],
                        x[k, i], z[k, i], theta[k, i], s[k, i], c[k, i],
                    )  # fmt: skip
                    lose(
                        live, m[k, i], r[k, i], dv[i], dt * knobs.gravity,
                        ux[k, i], uz[k, i], uo[k, i], kept, vx[k, i], vz[k, i], omega[k, i], loss[i],
                    )  # fmt: skip
                    witness(
                        live, time, n[p, i], was[p, i], n[p + 1, i], was[p + 1, i],
                        uplift_time[i], moved[i], impacts[i],
                    )  # fmt: skip
                    slid, overlap = stand(
                        face[k, i], high[k, i], s[k, i], c[k, i], offset[k, i],
                        face[low, i], high[low, i], s[low, i], c[low, i],
                        x[k, i] - x[low, i], z[k, i] - z[low, i], theta[k, i] - theta[low, i],
                    )  # fmt: skip
                    note(
                        live, time, theta[k, i], ux[k, i] + uz[k, i] + uo[k, i], slid, overlap,
                        peak[k, i], peak_time[k, i], slide[k, i], peak_slide[k, i], after[i],
                    )  # fmt: skip
            for i in range(LANES):
                live = count > 0 and mode[i] == ROCKING
                steps[i] = steps[i] + wp.where(live, 1, 0)
                mode[i] = wp.where(live, after[i], mode[i])
        if found.rotations.shape[0] > 0:
            for k in range(1, bodies):
                for i in range(LANES):
                    past = wp.where(count > 0 and mode[i] == ROCKING, time - until, zero)
                    back = wp.where(past > zero, past * omega[k, i], zero)
                    found.rotations[sample, k - 1, first + i] = theta[k, i] - back
    for k in range(1, bodies):
        for i in range(LANES):
            found.blocks[k - 1, first + i] = BlockResult(
                slide[k, i], peak[k, i], peak_time[k, i], peak_slide[k, i]
            )
    for i in range(LANES):
        found.results[first + i] = Result(
            uplift_time[i], moved[i], loss[i], impacts[i], mode[i], steps[i]
        )
