"""What the soft-spring kernel of blocks in space keeps of its lanes, and what it sees happen.

A func takes numbers of one lane out of the kernel's rows, or leaves them there by reference.
"""

import warp as wp

from warprock.kernels.dem.stack_lanes import observe_faces
from warprock.kernels.dem_space.stack_meet import Link
from warprock.kernels.modes import BROKEN, OVERTURNED, RUNNING
from warprock.kernels.shape_space.block import Block, matrix_of, turn_freely, turns_of

Pose = wp.types.vector(length=7, dtype=real)
"""Attitude, and centre of mass [m]."""


@wp.struct
class Lane:
    """One lane: its time step [s], when it is first uplifted [s], 0 or NEVER, and where it moves.

    `moves` is the sum of 1 where its base moves along x, 2 along y and 4 along z; `creep` is the
    speed up to which faces may slip back and forth on their springs and not slide [m/s].
    """

    time_step: real
    creep: real
    uplift_time: real
    moves: int


@wp.func
def start_block(
    block: Block, x: wp.ref[real], y: wp.ref[real], z: wp.ref[real], qx: wp.ref[real],
    qy: wp.ref[real], qz: wp.ref[real], qw: wp.ref[real], since: wp.ref[real], peak: wp.ref[real],
    across: wp.ref[real], tilt: wp.ref[real],
):  # fmt: skip
    """Puts a block where it starts; its interface counts as closed."""
    x = block.x
    y = block.y
    z = block.z
    qx = block.qx
    qy = block.qy
    qz = block.qz
    qw = block.qw
    since = NEVER
    _a, _b, r13, _c, _d, r23, _e, _f, r33 = matrix_of(block.qx, block.qy, block.qz, block.qw)
    now, side, lean, _g = turns_of(block, r13, r23, r33, block.qz, block.qw)
    peak = now
    across = side
    tilt = lean


@wp.func
def start_lane(
    lane: Lane, qw: wp.ref[real], dt: wp.ref[real], creep: wp.ref[real],
    uplift_time: wp.ref[real], mode: wp.ref[int],
):  # fmt: skip
    """Starts a lane: its ground, which is level, and its mode."""
    qw = real(1.0)
    dt = lane.time_step
    creep = lane.creep
    uplift_time = lane.uplift_time
    mode = RUNNING


@wp.func
def total_of(axis: wp.ref[real], first: wp.ref[real], second: wp.ref[real]) -> real:
    """Sum over the pairs on the axes and on both diagonals; these are zero afterwards."""
    total = (real(axis) + real(first)) + real(second)
    axis = real(0.0)
    first = real(0.0)
    second = real(0.0)
    return total


@wp.func
def gather(
    n0: wp.ref[real], n1: wp.ref[real], n2: wp.ref[real],
    na0: wp.ref[real], na1: wp.ref[real], na2: wp.ref[real],
    nb0: wp.ref[real], nb1: wp.ref[real], nb2: wp.ref[real],
    s0: wp.ref[real], s1: wp.ref[real], s2: wp.ref[real],
    sa0: wp.ref[real], sa1: wp.ref[real], sa2: wp.ref[real],
    sb0: wp.ref[real], sb1: wp.ref[real], sb2: wp.ref[real],
    t0: wp.ref[real], t1: wp.ref[real], t2: wp.ref[real],
    ta0: wp.ref[real], ta1: wp.ref[real], ta2: wp.ref[real],
    tb0: wp.ref[real], tb1: wp.ref[real], tb2: wp.ref[real],
    e0: wp.ref[real], e1: wp.ref[real], e2: wp.ref[real],
):  # fmt: skip
    """Sums over all pairs of an interface, see `solve_pair`, of those of each kind."""
    return (
        total_of(n0, n1, n2), total_of(na0, na1, na2), total_of(nb0, nb1, nb2),
        total_of(s0, s1, s2), total_of(sa0, sa1, sa2), total_of(sb0, sb1, sb2),
        total_of(t0, t1, t2), total_of(ta0, ta1, ta2), total_of(tb0, tb1, tb2),
        total_of(e0, e1, e2),
    )  # fmt: skip


@wp.func
def keep_link(
    link: Link, o: wp.ref[real], area: wp.ref[real], mu: wp.ref[real],
    wide: wp.ref[real], deep: wp.ref[real], cx: wp.ref[real], cy: wp.ref[real],
    p1: wp.ref[real], p2: wp.ref[real], p3: wp.ref[real],
    d1: wp.ref[real], d2: wp.ref[real], d3: wp.ref[real],
    a1: wp.ref[real], a2: wp.ref[real], a3: wp.ref[real],
    b1: wp.ref[real], b2: wp.ref[real], b3: wp.ref[real],
    v1: wp.ref[real], v2: wp.ref[real], v3: wp.ref[real],
    j1: wp.ref[real], j2: wp.ref[real], j3: wp.ref[real],
    k1: wp.ref[real], k2: wp.ref[real], k3: wp.ref[real], sx: wp.ref[real], sy: wp.ref[real],
):  # fmt: skip
    """Keeps the link that is being looked at, and the slide of its block."""
    o = link.o
    area = link.area
    mu = link.mu
    wide = link.wide
    deep = link.deep
    cx = link.cx
    cy = link.cy
    p1 = link.p1
    p2 = link.p2
    p3 = link.p3
    d1 = link.d1
    d2 = link.d2
    d3 = link.d3
    a1 = link.a1
    a2 = link.a2
    a3 = link.a3
    b1 = link.b1
    b2 = link.b2
    b3 = link.b3
    v1 = link.v1
    v2 = link.v2
    v3 = link.v3
    j1 = link.j1
    j2 = link.j2
    j3 = link.j3
    k1 = link.k1
    k2 = link.k2
    k3 = link.k3
    sx = link.slide_x
    sy = link.slide_y


@wp.func
def observe_block(
    live: bool, time: real, block: Block, qx: real, qy: real, qz: real, qw: real, others: real,
    slide_x: real, slide_y: real,
    peak: wp.ref[real], peak_time: wp.ref[real], across: wp.ref[real], tilt: wp.ref[real],
    yaw: wp.ref[real], slide: wp.ref[real], mode: wp.ref[int],
):  # fmt: skip
    """Peaks of a block after a step, see `turns_of`, and whether its lane lives on.

    `others` is a sum of its other numbers: it is finite only if all of them are.
    """
    zero = real(0.0)
    _a, _b, r13, _c, _d, r23, _e, _f, r33 = matrix_of(qx, qy, qz, qw)
    now, side, lean, twist = turns_of(block, r13, r23, r33, qz, qw)
    peak_time = wp.where(live and now > peak, time, peak_time)
    peak = wp.where(live, larger(now, peak), peak)
    across = wp.where(live, larger(side, across), across)
    tilt = wp.where(live, larger(lean, tilt), tilt)
    yaw = wp.where(live, larger(size(twist), yaw), yaw)
    slide = wp.where(live, larger(slide_x * slide_x + slide_y * slide_y, slide), slide)
    total = others + qx + qy + qz + qw + slide_x + slide_y
    over = wp.where(r33 <= zero and mode != BROKEN, OVERTURNED, mode)
    mode = wp.where(live, wp.where(total - total == zero, over, BROKEN), mode)


@wp.func
def observe_interface(
    live: bool, steps: int, dt: real, link: Link, creep: real, since: wp.ref[real],
    uplift_time: wp.ref[real], moved: wp.ref[real], deepest: wp.ref[real], impacts: wp.ref[int],
    mode: wp.ref[int],
):  # fmt: skip
    """What a step of a lane shows of an interface as it begins, see `observe_faces`.

    What its faces share slides where its fastest point slips by more than `creep`, see `Lane`.
    """
    x = size(link.v1) + size(link.j1) + size(link.k1)
    y = size(link.v2) + size(link.j2) + size(link.k2)
    time = real(steps - 1) * dt
    observe_faces(
        live, time, link.o, size(link.a3) + size(link.b3), link.area,
        x * x + y * y > creep * creep, since, uplift_time, moved, deepest, impacts, mode,
    )  # fmt: skip


@wp.func
def move_base(
    v: real, live: bool, base: wp.ref[real], dv: wp.ref[real]
):  # fmt: skip
    """Takes the base of a lane along one direction to v [m/s]."""
    dv = v - base
    base = wp.where(live, v, base)


@wp.func
def begin_step(
    live: wp.ref[int], steps: wp.ref[int], dt: real, until: real, mode: int, loss: real,
    span: wp.ref[real], stored: wp.ref[real], at_start: wp.ref[real], spent: wp.ref[real],
):  # fmt: skip
    """Begins a step: forces act over half of the first one; energies of the last one are kept."""
    runs = mode == RUNNING and real(steps) * dt < until
    span = wp.where(steps == 0, HALF * dt, dt)
    at_start = wp.where(steps == 1, stored, at_start)
    stored = wp.where(runs, real(0.0), stored)
    spent = wp.where(runs, loss, spent)
    live = wp.where(runs, 1, 0)
    steps = steps + live


@wp.func
def pose_before(
    block: Block, past: real, qx: real, qy: real, qz: real, qw: real, lx: real, ly: real, lz: real,
    x: real, y: real, z: real, vx: real, vy: real, vz: real,
) -> Pose:  # fmt: skip
    """Attitude and centre of mass of a block some time ago [s]."""
    ex, ey, ez, ew = turn_freely(
        qx, qy, qz, qw, lx, ly, lz, block.inverse_x, block.inverse_y, block.inverse_z, -past
    )
    return Pose(ex, ey, ez, ew, x - past * vx, y - past * vy, z - past * vz)
