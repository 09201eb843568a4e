"""Runs of the soft-spring step over stacks of blocks: LANES stacks a thread, side by side.

A single block is a stack of one. Every lane has its own time step, and with it its own number of
steps; a pack goes on until the last of its lanes has reached the next sample.

Loops over the lanes are innermost and work on local matrices, one row a body or a point, so that
the compiler turns them into vector code; with one lane a thread the same text is the plain form
for any device. A func takes the entries of the matrices and changes those it takes as `wp.ref`.

An interface has parted once its faces gape from the middle to three quarters of the way to an end
(`PIVOT` of dem/stack_lanes.py): the springs of an eighth of the face carry all, and the block turns
about that end, where before it leaned on its springs. It has landed, an impact, once it is closed
in the middle again. It slides while all springs that carry slip, faster than the bound of `slides`
in parting.py.
"""

import warp as wp

from warprock.kernels.account import book
from warprock.kernels.dem.stack import Knobs, find_contacts, integrate, load_blocks, solve_pair
from warprock.kernels.dem.stack_lanes import observe_faces, passes_left, time_past
from warprock.kernels.instance import ONE_VECTOR
from warprock.kernels.modes import BROKEN, OVERTURNED, RUNNING
from warprock.kernels.motion import base_velocity, sample_index, sample_segment
from warprock.kernels.parting import slides
from warprock.kernels.shape.above import Motions
from warprock.kernels.shape.interface import GROUND_FACE
from warprock.kernels.shape.rising import pulled
from warprock.kernels.shape.stack_found import BlockResult, Found, Result

wp.set_module_options(ONE_VECTOR)

POINTS = max(ITERATIONS, 2)
"""Sub-contacts of an interface."""
PAIRS = (POINTS + 1) // 2
"""Pairs of them; one in the middle counts as a pair of two halves."""
ODD = POINTS % 2
SPACING = real(1.0 / (POINTS - 1))
"""Distance of two points over the length of the interface."""


@wp.struct
class Block:
    """One block of a stack, and where it starts; z from where it would be on rigid blocks.

    `stretch` is that of the shear springs below it; vx, vz and omega are its velocities then.
    """

    half_width: real
    half_height: real
    inverse_mass: real
    inverse_inertia: real
    friction: real
    depth: real
    offset: real
    x: real
    z: real
    theta: real
    stretch: real
    vx: real
    vz: real
    omega: real


@wp.struct
class Stack:
    """One lane's stack: its time step [s], when it is first uplifted [s], 0 or NEVER."""

    time_step: real
    uplift_time: real


Lane = wp.types.vector(length=LANES, dtype=real)
LaneInt = wp.types.vector(length=LANES, dtype=int)
Body = wp.types.matrix(shape=(BLOCKS + 1, LANES), dtype=real)
Point = wp.types.matrix(shape=(BLOCKS * 2 * PAIRS, LANES), dtype=real)


@wp.func
def start_lane(
    stack: Stack, half_width: wp.ref[real], c: wp.ref[real], dt: wp.ref[real],
    uplift_time: wp.ref[real], mode: wp.ref[int],
):  # fmt: skip
    """Starts a lane: its ground, which is level and has a face, and its mode."""
    half_width = GROUND_FACE
    c = real(1.0)
    dt = stack.time_step
    uplift_time = stack.uplift_time
    mode = RUNNING


@wp.func
def start_block(
    block: Block, half_width: wp.ref[real], half_height: wp.ref[real], m: wp.ref[real],
    j: wp.ref[real], mu: wp.ref[real], depth: wp.ref[real], offset: wp.ref[real], x: wp.ref[real],
    z: wp.ref[real], theta: wp.ref[real], vx: wp.ref[real], vz: wp.ref[real],
    omega: wp.ref[real], s: wp.ref[real], c: wp.ref[real], since: wp.ref[real],
    peak: wp.ref[real],
):  # fmt: skip
    """Puts a block where it starts; its interface counts as closed."""
    half_width = block.half_width
    half_height = block.half_height
    m = block.inverse_mass
    j = block.inverse_inertia
    mu = block.friction
    depth = block.depth
    offset = block.offset
    x = block.x
    z = block.z
    theta = block.theta
    vx = block.vx
    vz = block.vz
    omega = block.omega
    s = sine(block.theta)
    c = cosine(block.theta)
    since = NEVER
    peak = size(block.theta)


@wp.func
def begin_step(
    v: real, live: bool, steps: wp.ref[int], dt: real, fall: real, dz: real, dv: wp.ref[real],
    base: wp.ref[real],
    span: wp.ref[real], stored: wp.ref[real], at_start: wp.ref[real], loss: real,
    spent: wp.ref[real], given: real, jolt: wp.ref[real], supplied: wp.ref[real],
    taken: wp.ref[real], returned: wp.ref[real],
):  # fmt: skip
    """Begins a step of a lane whose base moves at v [m/s] after it, and upwards by dz faster.

    `fall` is what gravity makes of a velocity in a step [m/s].
    """
    dv = v - base
    base = wp.where(live, v, base)
    span = wp.where(steps == 0, HALF * dt, dt)
    at_start = wp.where(steps == 1, stored, at_start)
    book(pulled(dv, dz, fall), given, spent - (stored - at_start), jolt, supplied, taken, returned)
    stored = wp.where(live, real(0.0), stored)
    spent = wp.where(live, loss, spent)
    steps = steps + wp.where(live, 1, 0)


@wp.func
def observe_interface(
    live: bool, time: real, gravity: real, dt: real, overlap: real, tilt: real, shared: real,
    slip: real, held: wp.ref[int], since: wp.ref[real], uplift_time: wp.ref[real],
    moved: wp.ref[real], deepest: wp.ref[real], impacts: wp.ref[int], mode: wp.ref[int],
):  # fmt: skip
    """What a step shows of an interface, see `observe_faces`.

    It slides as told at the head of this file.


    Args:
        live: Whether the lane still runs.
        time: Time [s].
        gravity: Acceleration of gravity [m/s^2].
        dt: Time step [s].
        overlap: See `observe_faces`, as all that is not told here.
        tilt: By how much it is deeper or less deep at the ends of what they share [m].
        slip: Speed at which they slip [m/s].
        held: Springs that carry and do not slip; set to none for the next interface.
    """
    slips = held == 0 and slides(dt * slip, dt, gravity)
    observe_faces(
        live, time, overlap, size(tilt), shared, slips, since, uplift_time, moved, deepest, impacts,
        mode,
    )  # fmt: skip
    held = 0


@wp.func
def observe_block(
    live: bool, time: real, theta: real, speed: real, slid: real, peak: wp.ref[real],
    peak_time: wp.ref[real], slide: wp.ref[real], peak_slide: wp.ref[real], mode: wp.ref[int],
):  # fmt: skip
    """Peaks of a block after a step, and whether its lane lives on.

    `speed` is the sum of its velocities: it is finite only if they are.
    """
    zero = real(0.0)
    higher = live and size(theta) > peak
    peak_time = wp.where(higher, time, peak_time)
    peak = wp.where(higher, smaller(size(theta), HALF_PI), peak)
    slide = wp.where(live, slid, slide)
    peak_slide = wp.where(live, larger(size(slid), peak_slide), peak_slide)
    sound = theta - theta == zero and speed - speed == zero and slid - slid == zero
    over = wp.where(size(theta) >= HALF_PI and mode != BROKEN, OVERTURNED, mode)
    mode = wp.where(live, wp.where(sound, over, BROKEN), mode)


@wp.kernel
def run_lanes(
    blocks: wp.array2d(dtype=Block), lanes: wp.array(dtype=Stack), motions: Motions,
    pool: wp.array2d(dtype=real), sample_times: wp.array(dtype=real), knobs: Knobs, found: Found,
):  # fmt: skip
    """Runs LANES lanes a thread, each at its own time."""
    # Rows of bodies, the ground first: what they are, where, how fast, and what is kept of them.
    half_w, half_h, m, j, mu, depth, offset = Body(), Body(), Body(), Body(), Body(), Body(), Body()
    x, z, theta, s, c, vx, vz = Body(), Body(), Body(), Body(), Body(), Body(), Body()
    omega, fx, fz, moment, since, slid = Body(), Body(), Body(), Body(), Body(), Body()
    peak, peak_time, slide, peak_slide = Body(), Body(), Body(), Body()
    # Rows of points, pair by pair from the middle outwards: the one at -x, the one at +x.
    u, slip = Point(), Point()
    # The interface that is being looked at, names as in dem/stack.py.
    ps, pc, rs, rc, side, de, dn = Lane(), Lane(), Lane(), Lane(), Lane(), Lane(), Lane()
    half, pe, pn, overlap, vn, vt, tilt = Lane(), Lane(), Lane(), Lane(), Lane(), Lane(), Lane()
    parting, sliding, n, nq, t, tq, e = Lane(), Lane(), Lane(), Lane(), Lane(), Lane(), Lane()
    dt, span, base, dv, loss, spent, stored = Lane(), Lane(), Lane(), Lane(), Lane(), Lane(), Lane()
    at_start, given, supplied, taken, returned = Lane(), Lane(), Lane(), Lane(), Lane()
    uplift_time, moved, deepest, jolt, dz, rising = Lane(), Lane(), Lane(), Lane(), Lane(), Lane()
    live, impacts, mode, steps, held = LaneInt(), LaneInt(), LaneInt(), LaneInt(), LaneInt()
    # Variables, not constants: else Warp would unroll the loops over them.
    pack, _one = wp.tid()
    bodies, pairs, first = int(BLOCKS + 1), int(PAIRS), pack * LANES
    for i in range(LANES):
        start_lane(lanes[first + i], half_w[0, i], c[0, i], dt[i], uplift_time[i], mode[i])
        for k in range(1, bodies):
            start_block(blocks[k - 1, first + i], half_w[k, i], half_h[k, i], m[k, i], j[k, i],
                mu[k, i], depth[k, i], offset[k, i], x[k, i], z[k, i], theta[k, i], vx[k, i],
                vz[k, i], omega[k, i], s[k, i], c[k, i], since[k, i], peak[k, i])  # fmt: skip
            for p in range(2 * pairs):
                u[2 * pairs * (k - 1) + p, i] = blocks[k - 1, first + i].stretch
    for sample in range(sample_times.shape[0]):
        until = sample_times[sample]
        passes = int(0)
        for i in range(LANES):
            passes = wp.max(passes, passes_left(until, steps[i], dt[i], mode[i]))
        for _ in range(passes):
            for i in range(LANES):
                live[i] = wp.where(mode[i] == RUNNING and real(steps[i]) * dt[i] < until, 1, 0)
                mid = (real(steps[i]) + HALF) * dt[i]
                if VERTICAL:
                    lane = motions[0, first + i]
                    up = motions[1, first + i]
                    high = sample_index(up, sample_segment(up, mid))
                    w = base_velocity(up, mid, pool[2, high], pool[0, high], pool[1, high])
                    dz[i] = w - rising[i]
                    rising[i] = wp.where(live[i] == 1, w, rising[i])
                else:
                    lane = motions[first + i]
                place = sample_index(lane, sample_segment(lane, mid))
                v = base_velocity(lane, mid, pool[2, place], pool[0, place], pool[1, place])
                begin_step(v, live[i] == 1, steps[i], dt[i], knobs.gravity * dt[i], dz[i], dv[i],
                    base[i], span[i], stored[i], at_start[i], loss[i], spent[i], given[i],
                    jolt[i], supplied[i], taken[i], returned[i])  # fmt: skip
            for k in range(1, bodies):
                low, row = k - 1, (k - 1) * 2 * pairs
                for i in range(LANES):
                    find_contacts(dv[i], half_w[k, i], half_h[k, i], s[k, i], c[k, i], omega[k, i],
                        half_w[low, i], half_h[low, i], s[low, i], c[low, i], omega[low, i],
                        x[k, i] - x[low, i], z[k, i] - z[low, i], vx[k, i] - vx[low, i],
                        vz[k, i] - vz[low, i], ps[i], pc[i], rs[i], rc[i], side[i], de[i], dn[i],
                        half[i], slid[k, i], pe[i], pn[i], overlap[i], vn[i], vt[i], tilt[i],
                        parting[i], sliding[i])  # fmt: skip
                for p in range(pairs):
                    away = SPACING * real(2 * p + 1 - ODD)
                    share = SPACING * wp.where(p == pairs - 1 or p < ODD, HALF, real(1.0))
                    for i in range(LANES):
                        solve_pair(knobs, live[i] == 1, mu[k, i], dt[i], share, away, overlap[i],
                            tilt[i], vn[i], parting[i], vt[i], sliding[i], u[row + 2 * p, i],
                            slip[row + 2 * p, i], u[row + 2 * p + 1, i], slip[row + 2 * p + 1, i],
                            n[i], nq[i], t[i], tq[i], e[i], held[i])  # fmt: skip
                for i in range(LANES):
                    load_blocks(depth[k, i], ps[i], pc[i], rs[i], rc[i], side[i], de[i], dn[i],
                        half[i], pe[i], pn[i], n[i], nq[i], t[i], tq[i], e[i], fx[k, i], fz[k, i],
                        moment[k, i], fx[low, i], fz[low, i], moment[low, i], live[i] == 1,
                        stored[i])  # fmt: skip
                    observe_interface(live[i] == 1, real(steps[i] - 1) * dt[i], knobs.gravity,
                        dt[i], overlap[i], tilt[i], half[i], vt[i], held[i], since[k, i],
                        uplift_time[i], moved[i], deepest[i], impacts[i], mode[i])  # fmt: skip
            for k in range(1, bodies):
                for i in range(LANES):
                    integrate(live[i] == 1, dv[i], dz[i], dt[i], span[i], knobs, m[k, i], j[k, i],
                        fx[k, i], fz[k, i], moment[k, i], x[k, i], z[k, i], theta[k, i], s[k, i],
                        c[k, i], vx[k, i], vz[k, i], omega[k, i], loss[i], given[i])  # fmt: skip
                    observe_block(live[i] == 1, real(steps[i]) * dt[i], theta[k, i],
                        vx[k, i] + vz[k, i] + omega[k, i], slid[k, i] - offset[k, i], peak[k, i],
                        peak_time[k, i], slide[k, i], peak_slide[k, i], mode[i])  # fmt: skip
        if found.rotations.shape[0] > 0:
            for k in range(1, bodies):
                for i in range(LANES):
                    past = time_past(until, steps[i], dt[i], mode[i])
                    found.rotations[sample, k - 1, first + i] = theta[k, i] - past * omega[k, i]
        if found.places.shape[0] > 0:
            for i in range(LANES):
                past = time_past(until, steps[i], dt[i], mode[i])
                for k in range(1, bodies):
                    found.places[sample, k - 1, 0, first + i] = x[k, i] - past * vx[k, i]
                    found.places[sample, k - 1, 1, first + i] = z[k, i] - past * vz[k, i]
    for i in range(LANES):
        lost = spent[i] - (stored[i] - at_start[i])
        pull = pulled(dv[i], dz[i], knobs.gravity * dt[i])
        book(pull, given[i], lost, jolt[i], supplied[i], taken[i], returned[i])
        found.results[first + i] = Result(
            uplift_time[i], moved[i], lost, jolt[i], supplied[i], returned[i], deepest[i],
            impacts[i], mode[i], steps[i],
        )  # fmt: skip
        for k in range(1, bodies):
            found.blocks[k - 1, first + i] = BlockResult(
                slide[k, i], peak[k, i], peak_time[k, i], peak_slide[k, i]
            )
