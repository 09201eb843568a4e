"""Soft-spring step of a stack in the plane with bodies among its blocks.

As dem/stack.py, with a spring under each of the up to three points of an interface (see
shape/stack_body.py) in the place of springs along a face. A point has half of the area that the
block and what it stands on share at rest. What a spring knows moves along with the window; one
that comes into view has opened before.
"""

import warp as wp

from warprock.kernels.dem.stack import FAILED, Knobs, spring
from warprock.kernels.shape.body_seen import moved_along
from warprock.kernels.shape.interface import Pose
from warprock.kernels.shape.stack_body import Foot, Top, Window, find_foot, way_of_window


@wp.func
def move_window(
    dv: real, turn: real, rate: real, before: Foot, middle: Foot, after: Foot,
    s: real, c: real, ls: real, lc: real, low: real, high: real, dx: real, dz: real,
    window: wp.ref[int], u1: wp.ref[real], slip1: wp.ref[real], u2: wp.ref[real],
    slip2: wp.ref[real], u3: wp.ref[real], slip3: wp.ref[real],
    deep: wp.ref[real], second: wp.ref[real],
):  # fmt: skip
    """Moves the window of an interface, and the springs of its three points from -x to +x with it.

    Args:
        dv: Change of the base velocity in the step [m/s].
        turn: Rotation of the block against what it stands on [rad], rate that of it [rad/s].
        before: See `way_of_window`, as all up to dz.
        window: Row of the corner with the role 0.
        u1: Stretch of a shear spring [m], slip1 its slip; see `spring` in dem/stack.py.
        deep, second: The deepest overlap of a point and the second one; none is known yet.
    """
    zero = real(0.0)
    lean = sign_of(wp.where(turn != zero, turn, wp.where(rate != zero, rate, -dv)))
    at, below, top = Pose(dx, dz, turn, s, c), Pose(zero, zero, zero, ls, lc), Top(low, high, zero)
    way = way_of_window(Window(before, middle, after), lean, at, below, top)
    window = window + way
    a, b, d = moved_along(way, u1, u2, u3)
    e, f, g = moved_along(way, slip1, slip2, slip3)
    u1 = a
    u2 = b
    u3 = d
    slip1 = wp.where(way < 0, FAILED, e)
    slip2 = f
    slip3 = wp.where(way > 0, FAILED, g)
    deep = -NEVER
    second = -NEVER


@wp.func
def press(
    knobs: Knobs, live: bool, mu: real, dt: real, area: real, before: Foot, middle: Foot,
    after: Foot, role: int, s: real, c: real, ls: real, lc: real, low: real, high: real, top: real,
    dx: real, dz: real, wx: real, wz: real, omega: real, lomega: real,
    u: wp.ref[real], slip: wp.ref[real], fx: wp.ref[real], fz: wp.ref[real],
    moment: wp.ref[real], lfx: wp.ref[real], lfz: wp.ref[real], lmoment: wp.ref[real],
    stored: wp.ref[real], held: wp.ref[int], deep: wp.ref[real], second: wp.ref[real],
    slid: wp.ref[real], sliding: wp.ref[real],
):  # fmt: skip
    """Adds what the spring of a point does to its two blocks.

    Args:
        knobs: See `spring` in dem/stack.py, as live, mu, dt, u and slip.
        area: That the point stands for [m^2].
        before: See `find_foot`, as all up to dz.
        wx: Velocity of the block from what it stands on [m/s], wz likewise.
        omega, lomega: Rates of their rotations [rad/s].
        fx: Force on the block so far [N], fz likewise, moment clockwise [N m]; lfx and so on, on
            what it stands on.
        stored: Energy in the springs so far [J].
        held: Points so far that are pressed and do not slip.
        deep, second: The deepest overlap of a point so far, and the second one [m].
        slid: Slide up to a constant [m], and sliding its rate [m/s], of the point with the role 0.
    """
    zero = real(0.0)
    at, below, face = Pose(dx, dz, zero, s, c), Pose(zero, zero, zero, ls, lc), Top(low, high, top)
    there, point, gap, place = find_foot(Window(before, middle, after), role, at, below, face)
    overlap = wp.where(there, -gap, -NEVER)
    vn = wx * point.nx + wz * point.nz - point.au * omega + point.al * lomega
    vt = wx * point.nz - wz * point.nx + point.bu * omega - point.bl * lomega
    kept = real(slip)
    normal, shear, energy = spring(knobs, live, mu, dt, overlap, vn, vt, u, slip)
    n = wp.where(there, area * normal, zero)
    t = wp.where(there, area * shear, zero)
    px = point.nx * n + point.nz * t
    pz = point.nz * n - point.nx * t
    fx = fx + px
    fz = fz + pz
    moment = moment + point.bu * t - point.au * n
    lfx = lfx - px
    lfz = lfz - pz
    lmoment = lmoment - point.bl * t + point.al * n
    stored = stored + wp.where(live and there, HALF * area * energy, zero)
    held = held + wp.where(n > zero and slip == kept, 1, 0)
    first = overlap > deep
    second = wp.where(first, deep, larger(overlap, second))
    deep = wp.where(first, overlap, deep)
    slid = wp.where(role == 0, place, slid)
    sliding = wp.where(role == 0, vt, sliding)
