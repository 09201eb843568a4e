"""Functions of xpbd/stack.py at the interface of a block and the ground.

The ground is level and nothing moves it. So both ends are corners of the block, their normal is
(0, 1), and the ground gets no correction. The functions have the names and arguments of those in
stack_pair.py and shape/interface.py, and the same results to round-off.
"""

import warp as wp

from warprock.kernels.launch.instance import MAX_UNROLL
from warprock.kernels.shape.interface import Box, Impulse, Mass, Point, Pose, Velocity
from warprock.kernels.xpbd.stack_pair import Coupling, End

TURNS = max(n for n in range(1, MAX_UNROLL + 1) if max(ITERATIONS, 1) % n == 0)
"""Sweeps in one call, unrolled: there is no other interface to visit."""


@wp.func
def find_end(side: real, box: Box, at: Pose, low_box: Box, below: Pose):
    """See `find_end` in shape/interface.py."""
    px = wedge(side * box.half_width, box.half_height, at.s, at.c)
    pz = -dot(box.half_height, side * box.half_width, at.c, at.s)
    ax = at.x - below.x + px
    az = at.z - below.z + pz
    point = Point(real(0.0), real(1.0), px, pz, ax, az)
    return point, az, ax - side * box.half_width


@wp.func
def add_impulses(
    up: Mass, low: Mass, point: Point, impulse: Impulse, u: wp.ref[Velocity], v: wp.ref[Velocity]
):
    """See `add_impulses` in shape/interface.py."""
    u.x = fused(up.m, impulse.t, u.x)
    u.z = fused(up.m, impulse.n, u.z)
    u.omega = fused(up.j, wedge(point.bu, point.au, impulse.n, impulse.t), u.omega)


@wp.func
def couple(up: Mass, low: Mass, one: Point, two: Point) -> Coupling:
    """See `couple` in stack_pair.py."""
    m = up.m
    pu, pv, qu, qv = up.j * one.au, up.j * one.bu, up.j * two.au, up.j * two.bu
    return Coupling(
        fused(pu, one.au, m), fused(pv, one.bu, m), fused(qu, two.au, m), fused(qv, two.bu, m),
        -pu * one.bu, -qu * two.bu, fused(pu, two.au, m), fused(pv, two.bu, m),
        -pu * two.bu, -pv * two.au,
    )  # fmt: skip


@wp.func
def gap_and_slip(end: End, u: Velocity, v: Velocity):
    """See `gap_and_slip` in stack_pair.py."""
    gap = fused_less(end.point.au, u.omega, end.contact.gap + u.z)
    return gap, fused(end.point.bu, u.omega, end.contact.slip + u.x)


@wp.func
def add_changes(
    up: Mass, low: Mass, first: End, second: End, one: Impulse, two: Impulse,
    u: wp.ref[Velocity], v: wp.ref[Velocity],
):  # fmt: skip
    """See `add_changes` in stack_pair.py."""
    n1, t1, n2, t2 = first.last.n, first.last.t, second.last.n, second.last.t
    turn1 = wedge(first.point.bu, first.point.au, one.n - n1, one.t - t1)
    turn2 = wedge(second.point.bu, second.point.au, two.n - n2, two.t - t2)
    u.x = fused(up.m, one.t - t1 + two.t - t2, u.x)
    u.z = fused(up.m, one.n - n1 + two.n - n2, u.z)
    u.omega = fused(up.j, turn1 + turn2, u.omega)
