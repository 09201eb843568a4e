"""Velocity-level contact step of a stack in the plane with bodies among its blocks.

As impulse/stack.py, but that an interface has up to three points (see shape/stack_body.py). They
are visited from the one away from the side to which the interface leans, so that a mirrored scene
is visited in mirrored order; what is kept of them from the last step moves along with the window.
"""

import warp as wp

from warprock.kernels.impulse.stack_flat import Knobs, clear, integrate, side_of, work
from warprock.kernels.modes import RUNNING
from warprock.kernels.parting import slack, slides
from warprock.kernels.shape.body_seen import moved_along, watch
from warprock.kernels.shape.interface_flat import add_impulses
from warprock.kernels.shape.rising import fall_in, sunk_in, worked
from warprock.kernels.shape.stack_body import (
    Block,
    Foot,
    find_foot,
    overlap_of,
    way_of_window,
)
from warprock.kernels.shape.stack_run_flat import mode_after


@wp.func
def predict(
    dv: real, rise: real, hint: real, knobs: Knobs, turn: real, vx: real, vz: real, omega: real,
    below: real, before: Foot, middle: Foot, after: Foot, s: real, c: real, ls: real, lc: real,
    low: real, high: real, dx: real, dz: real,
    ux: wp.ref[real], uz: wp.ref[real], uo: wp.ref[real], lean: wp.ref[real],
    window: wp.ref[int], by: wp.ref[int], n1: wp.ref[real], t1: wp.ref[real],
    n2: wp.ref[real], t2: wp.ref[real], n3: wp.ref[real], t3: wp.ref[real],
    shift_x: wp.ref[real], shift_z: wp.ref[real],
):  # fmt: skip
    """Velocity of a block without contact; its interface in the order of its lean.

    Arguments up to `below` as those of `predict` in impulse/stack.py, then those of
    `way_of_window` in shape/stack_body.py. Impulses of the points change places where the lean has
    changed, and move along with the window; `by` is how far it has moved. No shift is known yet.
    """
    zero, now = real(0.0), side_of(turn, omega - below, hint, lean)
    same = now == lean
    lean = now
    ux = vx - dv
    uz = vz - fall_in(knobs.time_step, knobs.gravity, rise)
    uo = omega
    way = way_of_window(before, middle, after, turn, now, s, c, ls, lc, low, high, dx, dz)
    window = window + way
    by = way
    ahead = wp.where(now > zero, way, -way)
    a, b, d = moved_along(ahead, wp.where(same, n1, n3), n2, wp.where(same, n3, n1))
    e, f, g = moved_along(ahead, wp.where(same, t1, t3), t2, wp.where(same, t3, t1))
    shift_x = zero
    shift_z = zero
    n1 = a
    n2 = b
    n3 = d
    t1 = e
    t2 = f
    t3 = g


@wp.func
def find_contact(
    before: Foot, middle: Foot, after: Foot, turn: int, lean: real,
    s: real, c: real, m: real, j: real, ls: real, lc: real, low: real, high: real, top: real,
    lm: real, lj: real, dx: real, dz: real, margin: real,
    nx: wp.ref[real], nz: wp.ref[real], au: wp.ref[real], bu: wp.ref[real],
    al: wp.ref[real], bl: wp.ref[real], gap: wp.ref[real],
    pn: wp.ref[real], pt: wp.ref[real], nt: wp.ref[real],
    n: wp.ref[real], t: wp.ref[real],
    ux: wp.ref[real], uz: wp.ref[real], uo: wp.ref[real],
    lx: wp.ref[real], lz: wp.ref[real], lo: wp.ref[real],
):  # fmt: skip
    """Finds a point and starts it from its last impulses, as `find_contact` in impulse/stack.py.

    Its number `turn` in the order of the lean is -1, 0 or 1. A point that is not there is no
    contact; its gap is wide.
    """
    role = wp.where(lean > real(0.0), turn, -turn)
    there, mx, mz, ru, hu, rl, hl, found, _slid = find_foot(
        before, middle, after, role, s, c, ls, lc, low, high, top, dx, dz
    )
    nx = mx
    nz = mz
    au = ru
    bu = hu
    al = rl
    bl = hl
    gap = wp.where(there, found, NEVER)
    on = wp.where(there and found <= margin, real(1.0), real(0.0))
    pn = on / fused(lj * rl, rl, fused(j * ru, ru, m + lm))
    pt = on / fused(lj * hl, hl, fused(j * hu, hu, m + lm))
    nt = -dot(j * ru, lj * rl, hu, hl)
    n = on * n
    t = on * t
    add_impulses(m, j, lm, lj, mx, mz, ru, hu, rl, hl, n, t, ux, uz, uo, lx, lz, lo)


@wp.func
def balance(
    even: real, place: real, n1: wp.ref[real], t1: wp.ref[real], n2: wp.ref[real],
    t2: wp.ref[real], n3: wp.ref[real], t3: wp.ref[real], ux: wp.ref[real], uo: wp.ref[real],
):  # fmt: skip
    """As `balance` in shape/stack_run.py, of three points from -x to +x.

    The image of the second one, which lies at `place` along the face [m], is the one on the other
    side of the centre.
    """
    zero, side = real(0.0), clear(place)
    whole, first, last = even > zero, side >= zero, side <= zero
    n = HALF * (wp.where(first, n1, n2) + wp.where(last, n3, n2))
    t = HALF * (wp.where(first, t1, t2) - wp.where(last, t3, t2))
    n1 = wp.where(whole and first, n, n1)
    t1 = wp.where(whole and first, t, t1)
    n2 = wp.where(whole and side != zero, n, n2)
    t2 = wp.where(whole, wp.where(first and last, zero, wp.where(first, -t, t)), t2)
    n3 = wp.where(whole and last, n, n3)
    t3 = wp.where(whole and last, -t, t3)
    ux = wp.where(whole, zero, ux)
    uo = wp.where(whole, zero, uo)


@wp.func
def lift_out(
    gap1: real, nx1: real, nz1: real, gap2: real, nx2: real, nz2: real,
    gap3: real, nx3: real, nz3: real, knobs: Knobs, rise: real,
    shift_x: wp.ref[real], shift_z: wp.ref[real],
):  # fmt: skip
    """Adds what an interface gives back of its penetration to the shift of all above it [m]."""
    first = gap1 < gap2
    gap = wp.where(first, gap1, gap2)
    nx = wp.where(first, nx1, nx2)
    nz = wp.where(first, nz1, nz2)
    deep = gap < gap3
    spare = sunk_in(knobs.time_step, knobs.gravity, rise)
    push = knobs.erp * smaller(wp.where(deep, gap, gap3) + spare, real(0.0))
    shift_x = fused_less(push, wp.where(deep, nx, nx3), shift_x)
    shift_z = fused_less(push, wp.where(deep, nz, nz3), shift_z)


@wp.func
def integrate_block(
    live: bool, kept: real, knobs: Knobs, dv: real, rise: real, m: real, j: real,
    gap1: real, nx1: real, nz1: real, gap2: real, nx2: real, nz2: real,
    gap3: real, nx3: real, nz3: real, ux: real, uz: real, uo: real,
    shift_x: wp.ref[real], shift_z: wp.ref[real], x: wp.ref[real], z: wp.ref[real],
    theta: wp.ref[real], s: wp.ref[real], c: wp.ref[real], vx: wp.ref[real], vz: wp.ref[real],
    omega: wp.ref[real], loss: wp.ref[real], given: wp.ref[real],
):  # fmt: skip
    """Moves a block by a step, as `integrate_block` in impulse/stack_run.py."""
    lift_out(
        gap1, nx1, nz1, gap2, nx2, nz2, gap3, nx3, nz3, knobs, rise, shift_x, shift_z
    )  # fmt: skip
    fall = fall_in(knobs.time_step, knobs.gravity, rise)
    done = work(dv, fall, m / j, vx, vz, omega, ux, uz, uo)
    loss = loss - wp.where(live, fused(knobs.gravity, shift_z, done) / m, real(0.0))
    given = given - wp.where(live, worked(dv, rise, vx + ux, vz + uz) / m, real(0.0))
    integrate(live, knobs.time_step, shift_x, shift_z, ux, uz, uo, x, z, theta, s, c)
    vx = kept * ux
    vz = kept * uz
    omega = kept * uo


@wp.func
def observe(
    before: Foot, middle: Foot, after: Foot, first: Foot, last: Foot, by: int, block: Block,
    live: bool, time: real, dt: real, gravity: real, lean: real,
    n1: real, n2: real, n3: real, theta: real, below: real,
    ux: real, uz: real, uo: real, lo: real, s: real, c: real, ls: real, lc: real,
    low: real, high: real, top: real, dx: real, dz: real, z: real,
    since: wp.ref[real], left: wp.ref[int], under: wp.ref[int], right: wp.ref[int],
    uplift_time: wp.ref[real], moved: wp.ref[real], deepest: wp.ref[real], impacts: wp.ref[int],
    peak: wp.ref[real], peak_time: wp.ref[real], slide: wp.ref[real], peak_slide: wp.ref[real],
    crept: wp.ref[real], mode: wp.ref[int],
):  # fmt: skip
    """What a step shows of a block and of the interface below it, and whether its lane lives on.

    As `observe` in shape/stack_run.py, the points of the window in the place of two ends. Other
    arguments as those of `find_foot` in shape/stack_body.py and of `watch` in shape/body_seen.py.
    """
    turn = theta - below
    has_l, _x1, _z1, _a1, _b1, _c1, _d1, gap_l, _slid1 = find_foot(
        before, middle, after, -1, s, c, ls, lc, low, high, top, dx, dz
    )
    has_m, _x2, _z2, _a2, _b2, _c2, _d2, gap_m, slid = find_foot(
        before, middle, after, 0, s, c, ls, lc, low, high, top, dx, dz
    )
    has_r, _x3, _z3, _a3, _b3, _c3, _d3, gap_r, _slid3 = find_foot(
        before, middle, after, 1, s, c, ls, lc, low, high, top, dx, dz
    )
    gap_m = wp.where(has_m, gap_m, NEVER)
    overlap = overlap_of(first, middle, last, s, c, ls, lc, low, high, dx, dz)
    slid = slid - block.aside
    limit = slack(dt, gravity, block.reach, uo * uo + lo * lo, block.centre_height + size(z))
    forward = lean > real(0.0)
    way = slid - slide
    glides = slides(way, dt, gravity) and slides(crept, dt, gravity) and way * crept > real(0.0)
    crept = way
    watch(
        live, by, larger(time, real(0.0)), limit, has_l, has_r, wp.where(forward, n1, n3), gap_l,
        n2, gap_m, wp.where(forward, n3, n1), gap_r, glides, since, left, under, right,
        uplift_time, moved, impacts,
    )  # fmt: skip
    gap = smaller(wp.where(has_l, gap_l, NEVER), wp.where(has_r, gap_r, NEVER))
    gap = smaller(gap, gap_m)
    stands = live and larger(size(theta), size(turn)) < HALF_PI
    deepest = wp.where(stands, larger(-gap, deepest), deepest)
    higher = live and size(theta) > peak
    peak_time = wp.where(higher, time, peak_time)
    peak = wp.where(higher, smaller(size(theta), HALF_PI), peak)
    slide = slid
    peak_slide = wp.where(live, larger(size(slid), peak_slide), peak_slide)
    found = mode_after(theta, turn, overlap, theta + ux + uz + uo + overlap)
    mode = wp.where(live and mode == RUNNING, found, mode)


@wp.func
def finish_step(
    before: Foot, middle: Foot, after: Foot, first: Foot, last: Foot, by: int, block: Block,
    live: bool, kept: real, knobs: Knobs, time: real, dv: real, rise: real, lean: real,
    m: real, j: real,
    gap1: real, nx1: real, nz1: real, n1: real, gap2: real, nx2: real, nz2: real, n2: real,
    gap3: real, nx3: real, nz3: real, n3: real, ux: real, uz: real, uo: real,
    lx: real, lz: real, ltheta: real, lo: real, ls: real, lc: real,
    low: real, high: real, top: real,
    shift_x: wp.ref[real], shift_z: wp.ref[real], x: wp.ref[real], z: wp.ref[real],
    theta: wp.ref[real], s: wp.ref[real], c: wp.ref[real], vx: wp.ref[real], vz: wp.ref[real],
    omega: wp.ref[real], loss: wp.ref[real], given: wp.ref[real],
    since: wp.ref[real], left: wp.ref[int], under: wp.ref[int], right: wp.ref[int],
    uplift_time: wp.ref[real], moved: wp.ref[real], deepest: wp.ref[real], impacts: wp.ref[int],
    peak: wp.ref[real], peak_time: wp.ref[real], slide: wp.ref[real], peak_slide: wp.ref[real],
    crept: wp.ref[real], mode: wp.ref[int],
):  # fmt: skip
    """Moves a block by a step, see `integrate_block`, and looks at it, see `observe`.

    Of what it stands on, which has moved already, the place, rotation and its rate are lx to lo.
    """
    integrate_block(
        live, kept, knobs, dv, rise, m, j, gap1, nx1, nz1, gap2, nx2, nz2, gap3, nx3, nz3, ux, uz,
        uo, shift_x, shift_z, x, z, theta, s, c, vx, vz, omega, loss, given,
    )  # fmt: skip
    observe(
        before, middle, after, first, last, by, block, live, time, knobs.time_step, knobs.gravity,
        lean, n1, n2, n3, theta, ltheta, ux, uz, uo, lo, s, c, ls, lc, low, high, top, x - lx,
        z - lz, z, since, left, under, right, uplift_time, moved, deepest, impacts, peak,
        peak_time, slide, peak_slide, crept, mode,
    )  # fmt: skip
