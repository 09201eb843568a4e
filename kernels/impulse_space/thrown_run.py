"""Runs of the impulse step over blocks in space that start in motion or bounce, one lane a thread.

The step is that of impulse_space/block.py. Besides,

    - a corner that comes down fast bounces, see impulse_space/bounce.py;
    - of a block that tumbles the face that looks down becomes the bottom between two steps
      (shape_space/thrown.py). Its corners begin without impulses then. Its slide is the way of its
      centre along the base.
"""

import warp as wp

from warprock.kernels.impulse_space.block import (
    Knobs,
    find_contact,
    integrate,
    predict,
    solve_contact,
    warm_start,
)
from warprock.kernels.impulse_space.block_hold import hold
from warprock.kernels.impulse_space.block_plane import find_plane, level, solve_in_plane
from warprock.kernels.impulse_space.block_run import attitude_to_store, reorder
from warprock.kernels.impulse_space.block_seen import (
    glides,
    lifted_since,
    observe_block,
    observe_contacts,
)
from warprock.kernels.impulse_space.bounce import bounce, calm
from warprock.kernels.instance import BRANCHES
from warprock.kernels.modes import OVERTURNED, RUNNING
from warprock.kernels.motion import Motion, base_velocity, sample_index, sample_segment
from warprock.kernels.shape_space.block import Block, matrix_of, turns_of
from warprock.kernels.shape_space.block_found import BlockResult, Found, Result
from warprock.kernels.shape_space.thrown import Throw, after, leans, new_axes, renamed
from warprock.kernels.vectors import Matrix
from warprock.kernels.vectors import Vector as Three

wp.set_module_options(BRANCHES)

LANES = 1
"""Lanes of a thread."""
Four = wp.types.vector(length=4, dtype=real)
"""A quaternion, or a number a corner."""


@wp.struct
class Body:
    """State of one lane.

    Place x, attitude q, velocity v; spin, the angular momentum of unit mass; base, the velocity of
    the base; the side that it leans to; impulses of the corners and whether they have parted; what
    has been seen.
    """

    x: Three
    q: Four
    v: Three
    spin: Three
    base: Three
    lean_x: real
    lean_y: real
    fx: Four
    fy: Four
    n: Four
    apart: Four
    since: real
    uplift_time: real
    moved: real
    loss: real
    deepest: real
    impacts: int
    mode: int
    steps: int
    leaf: BlockResult


@wp.func
def start_body(block: Block, knobs: Knobs, throw: Throw) -> Body:
    """A block where it starts, its velocity that of half a step before."""
    b = Body()
    fall = HALF * knobs.time_step * knobs.gravity
    b.x = Three(block.x, block.y, block.z)
    b.q = Four(block.qx, block.qy, block.qz, block.qw)
    b.v = Three(throw.vx, throw.vy, throw.vz + fall)
    r11, r12, r13, r21, r22, r23, r31, r32, r33 = matrix_of(b.q[0], b.q[1], b.q[2], b.q[3])
    turn = Matrix(r11, r12, r13, r21, r22, r23, r31, r32, r33)
    one = real(1.0)
    inertia = wp.diag(Three(one / block.inverse_x, one / block.inverse_y, one / block.inverse_z))
    b.spin = turn * (inertia * (wp.transpose(turn) * Three(throw.wx, throw.wy, throw.wz)))
    b.lean_x = sign_of(block.centre_x)
    b.lean_y = sign_of(block.centre_y)
    b.uplift_time = wp.where(block.standing == real(4.0), NEVER, real(0.0))
    b.mode = RUNNING
    tan_x, tan_y, tilt, _yaw = turns_of(block, r13, r23, r33, b.q[2], b.q[3])
    b.leaf.peak = tan_x
    b.leaf.peak_across = tan_y
    b.leaf.peak_tilt = tilt
    return b


@wp.func
def look(
    block: Block, own: Block, knobs: Knobs, throw: Throw, named: Four, before: Body, time: real
) -> Body:  # fmt: skip
    """What a step shows of a block, `own` as it stands and `block` as it began."""
    b = before
    live = b.mode == RUNNING
    qx, qy, qz, qw = after(
        b.q[0], b.q[1], b.q[2], b.q[3], -named[0], -named[1], -named[2], named[3]
    )
    slide_x, slide_y = real(b.leaf.slide_x), real(b.leaf.slide_y)
    slide, yaw = real(b.leaf.peak_slide), real(b.leaf.peak_yaw)
    peak, peak_time = real(b.leaf.peak), real(b.leaf.peak_time)
    across, tilt, mode = real(b.leaf.peak_across), real(b.leaf.peak_tilt), int(b.mode)
    speed = b.v[0] + b.v[1] + b.v[2] + b.spin[0] + b.spin[1] + b.spin[2]
    observe_block(
        live, time, block, b.x[0], b.x[1], b.x[2], qx, qy, qz, qw, speed, slide_x, slide_y, peak,
        peak_time, across, tilt, yaw, slide, mode,
    )  # fmt: skip
    tumbles = throw.tumbles == 1
    x, y = b.x[0] - block.x, b.x[1] - block.y
    b.mode = wp.where(tumbles and mode == OVERTURNED, RUNNING, mode)
    b.leaf = BlockResult(
        qz, qw, wp.where(tumbles, x, slide_x), wp.where(tumbles, y, slide_y), peak, peak_time,
        across, tilt, yaw, wp.where(tumbles, larger(b.leaf.peak_slide, x * x + y * y), slide),
    )  # fmt: skip
    return b


@wp.func
def swept(
    own: Block, knobs: Knobs, aim: Four, on: Four, rx: Four, ry: Four, rz: Four, jxx: real,
    jxy: real, jxz: real, jyy: real, jyz: real, jzz: real, fx: wp.ref[Four], fy: wp.ref[Four],
    n: wp.ref[Four], ux: wp.ref[real], uy: wp.ref[real], uz: wp.ref[real], ox: wp.ref[real],
    oy: wp.ref[real], oz: wp.ref[real],
):  # fmt: skip
    """Sweeps over the corners that are not held together, from their last impulses."""
    zero, corners = real(0.0), int(4)
    kx, ky, pn, p1, p2, p3 = Four(), Four(), Four(), Four(), Four(), Four()
    h11, h12, h13, h22, h23, h33 = Four(), Four(), Four(), Four(), Four(), Four()
    for c in range(corners):
        if on[c] > zero:
            warm_start(
                on[c], rx[c], ry[c], rz[c], fx[c], fy[c], n[c], jxx, jxy, jxz, jyy, jyz, jzz,
                kx[c], ky[c], pn[c], p1[c], p2[c], p3[c], h11[c], h12[c], h13[c], h22[c], h23[c],
                h33[c], ux, uy, uz, ox, oy, oz,
            )  # fmt: skip
    for sweep in range(knobs.sweeps * corners):
        c = sweep % corners
        if on[c] > zero:
            solve_contact(
                own.friction, aim[c], rx[c], ry[c], rz[c], jxx, jxy, jxz, jyy, jyz, jzz, kx[c],
                ky[c], pn[c], p1[c], p2[c], p3[c], h11[c], h12[c], h13[c], h22[c], h23[c], h33[c],
                fx[c], fy[c], n[c], ux, uy, uz, ox, oy, oz,
            )  # fmt: skip


@wp.func
def reordered(
    swap_x: real, swap_y: real, fx: wp.ref[Four], fy: wp.ref[Four], n: wp.ref[Four],
    apart: wp.ref[Four],
):  # fmt: skip
    """What is known of the corners, in the order of another lean."""
    reorder(swap_x, swap_y, fx[0], fx[1], fx[2], fx[3])
    reorder(swap_x, swap_y, fy[0], fy[1], fy[2], fy[3])
    reorder(swap_x, swap_y, n[0], n[1], n[2], n[3])
    reorder(swap_x, swap_y, apart[0], apart[1], apart[2], apart[3])


@wp.func
def pressed(
    before: Body, lean_x: real, lean_y: real, fx: Four, fy: Four, n: Four, apart: Four
) -> Body:
    """A lane's state with the side that it leans to, its impulses and what has parted."""
    b = before
    b.lean_x = lean_x
    b.lean_y = lean_y
    b.fx = fx
    b.fy = fy
    b.n = n
    b.apart = apart
    return b


@wp.func
def told(
    before: Body, loss: real, uplift_time: real, moved: real, deepest: real, impacts: int,
    steps: int,
) -> Body:  # fmt: skip
    """A lane's state with what its last step has shown."""
    b = before
    b.loss = loss
    b.uplift_time = uplift_time
    b.moved = moved
    b.deepest = deepest
    b.impacts = impacts
    b.steps = steps
    return b


@wp.func
def moved_to(before: Body, x: Three, q: Four, v: Three, spin: Three) -> Body:
    """A lane's state at its next place."""
    b = before
    b.x = x
    b.q = q
    b.v = v
    b.spin = spin
    return b


@wp.func
def advance(
    own: Block, knobs: Knobs, change: Three, time: real, before: Body
) -> Body:  # fmt: skip
    """One step of a block that stands on its bottom, without what is seen of its turns."""
    b = before
    # Each a variable of its own: a func that writes to one must not write to another.
    x, y, z = real(b.x[0]), real(b.x[1]), real(b.x[2])
    qx, qy, qz, qw = real(b.q[0]), real(b.q[1]), real(b.q[2]), real(b.q[3])
    vx, vy, vz = real(b.v[0]), real(b.v[1]), real(b.v[2])
    lx, ly, lz = real(b.spin[0]), real(b.spin[1]), real(b.spin[2])
    ux, uy, uz, ox, oy, oz = real(0.0), real(0.0), real(0.0), real(0.0), real(0.0), real(0.0)
    jxx, jxy, jxz, jyy, jyz, jzz = real(0.0), real(0.0), real(0.0), real(0.0), real(0.0), real(0.0)
    lean_x, lean_y, swap_x, swap_y = real(b.lean_x), real(b.lean_y), real(0.0), real(0.0)
    lowest, lifted, landed = real(0.0), real(0.0), real(0.0)
    fx, fy, n, apart = b.fx + Four(), b.fy + Four(), b.n + Four(), b.apart + Four()
    rx, ry, rz, aim, on = Four(), Four(), Four(), Four(), Four()
    ix, iy, iz = own.inverse_x, own.inverse_y, own.inverse_z
    b.since = lifted_since(n[0], n[1], n[2], n[3], b.since, time - knobs.time_step)
    predict(
        change[0], change[1], change[2], knobs, qx, qy, qz, qw, lx, ly, lz, ix, iy, iz, vx, vy, vz,
        ux, uy, uz, ox, oy, oz, jxx, jxy, jxz, jyy, jyz, jzz, lean_x, lean_y, swap_x, swap_y,
        lowest,
    )  # fmt: skip
    reordered(swap_x, swap_y, fx, fy, n, apart)
    corners = int(4)
    for c in range(corners):
        find_contact(
            c, lean_x, lean_y, own.half_width, own.half_depth, own.half_height, own.centre_x,
            own.centre_y, z, knobs, qx, qy, qz, qw, ox, oy, oz, rx[c], ry[c], rz[c], aim[c], on[c],
            fx[c], fy[c], n[c], apart[c], lowest, lifted, landed,
        )  # fmt: skip
        aim[c] = bounce(knobs, rx[c], ry[c], uz, ox, oy, on[c], aim[c])
    plane = find_plane(
        knobs, own.half_height, own.centre_x, own.centre_y, qx, qy, qz, qw, ux, uy, ox, oy, oz
    )
    level(plane, aim[0], aim[1], aim[2], aim[3], on[0], on[1], on[2], on[3])
    hold(
        knobs, lean_x, lean_y, own.half_width, own.half_depth, own.half_height, own.centre_x,
        own.centre_y, own.friction, qx, qy, qz, qw, ix, iy, iz, lx, ly, lz, aim[0], aim[1], aim[2],
        aim[3], on[0], on[1], on[2], on[3], fx[0], fx[1], fx[2], fx[3], fy[0], fy[1], fy[2], fy[3],
        n[0], n[1], n[2], n[3], ux, uy, uz, ox, oy, oz,
    )  # fmt: skip
    solve_in_plane(
        plane, knobs, lean_x, lean_y, own.friction, qx, qy, qz, qw, ix, iy, rx[0], rx[1], rx[2],
        rx[3], ry[0], ry[1], ry[2], ry[3], rz[0], rz[1], rz[2], rz[3], aim[0], aim[1], aim[2],
        aim[3], on[0], on[1], on[2], on[3], fx[0], fx[1], fx[2], fx[3], fy[0], fy[1], fy[2], fy[3],
        n[0], n[1], n[2], n[3], ux, uy, uz, ox, oy, oz,
    )  # fmt: skip
    swept(
        own, knobs, aim, on, rx, ry, rz, jxx, jxy, jxz, jyy, jyz, jzz, fx, fy, n, ux, uy, uz, ox,
        oy, oz,
    )  # fmt: skip
    calm(
        knobs, change[0], change[1], change[2], qx, qy, qz, qw, ix, iy, iz, vx, vy, vz, lx, ly, lz,
        ux, uy, uz, ox, oy, oz,
    )  # fmt: skip
    loss, uplift_time = real(b.loss), real(b.uplift_time)
    moved, deepest, impacts, steps = real(b.moved), real(b.deepest), int(b.impacts), int(b.steps)
    integrate(
        True, knobs, ix, iy, iz, change[0], change[1], change[2], ux, uy, uz, ox, oy, oz, lowest,
        x, y, z, qx, qy, qz, qw, vx, vy, vz, lx, ly, lz, loss,
    )  # fmt: skip
    observe_contacts(
        True, time, landed, lowest, lifted, glides(own, knobs, ux, uy, ox, oy, oz), b.since,
        uplift_time, moved, deepest, impacts, steps,
    )  # fmt: skip
    b = moved_to(b, Three(x, y, z), Four(qx, qy, qz, qw), Three(vx, vy, vz), Three(lx, ly, lz))
    b = pressed(b, lean_x, lean_y, fx, fy, n, apart)
    return told(b, loss, uplift_time, moved, deepest, impacts, steps)


@wp.kernel
def run_lanes(
    blocks: wp.array2d(dtype=Block), throws: wp.array(dtype=Throw),
    motions: wp.array2d(dtype=Motion), pool: wp.array2d(dtype=real),
    sample_times: wp.array(dtype=real), knobs: Knobs, found: Found,
):  # fmt: skip
    """Runs one lane a thread."""
    lane, dt, zero, time = wp.tid(), knobs.time_step, real(0.0), real(0.0)
    block = blocks[0, lane]
    own = blocks[0, lane]
    throw = throws[lane]
    named = Four(zero, zero, zero, real(1.0))
    b = start_body(block, knobs, throw)
    count = int(0)
    for sample in range(sample_times.shape[0]):
        until = sample_times[sample]
        while time < until and b.mode == RUNNING:
            count += 1
            time = real(count) * dt
            half = (real(count) - HALF) * dt
            if throw.tumbles == 1 and leans(b.q[0], b.q[1]):
                gx, gy, gw = new_axes(b.q[0], b.q[1], b.q[2], b.q[3])
                own = renamed(own, gx, gy)
                x, y, z, w = after(b.q[0], b.q[1], b.q[2], b.q[3], gx, gy, zero, gw)
                b.q = Four(x, y, z, w)
                x, y, z, w = after(named[0], named[1], named[2], named[3], gx, gy, zero, gw)
                named = Four(x, y, z, w)
                b.fx = Four()
                b.fy = Four()
                b.n = Four()
                b.apart = Four()
            now = Three()
            for d in range(3):
                way = motions[d, lane]
                place = sample_index(way, sample_segment(way, half))
                now[d] = base_velocity(way, half, pool[2, place], pool[0, place], pool[1, place])
            change = now - b.base
            b.base = now
            b = advance(own, knobs, change, time, b)
            b = look(block, own, knobs, throw, named, b, time)
        past = wp.where(b.mode == RUNNING, time - until, zero)
        if found.attitudes.shape[0] > 0:
            x, y, z, w = after(
                b.q[0], b.q[1], b.q[2], b.q[3], -named[0], -named[1], -named[2], named[3]
            )
            q = attitude_to_store(
                b.mode == RUNNING, -past, x, y, z, w, b.spin[0], b.spin[1], b.spin[2],
                block.inverse_x, block.inverse_y, block.inverse_z,
            )  # fmt: skip
            for d in range(4):
                found.attitudes[sample, 0, d, lane] = q[d]
        if found.places.shape[0] > 0:
            for d in range(3):
                found.places[sample, 0, d, lane] = b.x[d] - past * b.v[d]
    found.results[lane] = Result(
        b.uplift_time, b.moved, b.loss, b.deepest, b.impacts, b.mode, b.steps
    )
    found.blocks[0, lane] = b.leaf
