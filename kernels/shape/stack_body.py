"""A stack in the plane whose blocks stand on chains of corners, each on the top of the one below.

A block stands on the corners of a chain that is convex towards what is below (see shape/body.py)
and carries the next one on its top, a flat face. A box stands on two corners.

Only the part of the chain above the top matters. Its points are the corners above the top. If an
edge passes over an end of the top, the point of the edge above that end is one, too. The chain is
convex, so only points near its lowest one can touch. A step handles three corners, the *window*,
with the roles -1, 0 and 1. Role 0 is the lowest corner, or the first corner beyond an end of the
top if the lowest one lies beyond that end; the others are its neighbours. A corner beyond an end is
replaced by the point above that end, on the edge to that corner.
"""

import warp as wp

from warprock.kernels.shape.body import rotated_x, rotated_z
from warprock.kernels.shape.interface import GROUND_FACE, Impulse, Point, Pose


@wp.struct
class Block:
    """One block, and where it starts.

    `aside` is the distance of its centre to +x of the one below if both are upright [m], zero for
    the lowest block; `reach` an upper bound of the distance of its corners from its centre [m];
    `window` the row of the corner that has the role 0 at first; `left` and `right` as in
    shape/stack_run.py; `area` half of the area on which it stands at rest [m^2]; `rest` its height
    at rest [m].
    """

    inverse_mass: real
    inverse_inertia: real
    friction: real
    aside: real
    reach: real
    centre_height: real
    top_low: real
    top_high: real
    top: real
    x: real
    z: real
    theta: real
    left: real
    right: real
    area: real
    rest: real
    window: int


@wp.struct
class Foot:
    """A corner as in shape/body.py, and the edge from it to the next one.

    That edge has the direction (cosine, sine) and lies `depth` below the centre of mass. All blocks
    have the same number of rows. The first corner of a block is repeated once, the last one at
    least once, so that every corner has neighbours; a repeated one has the same `along`.
    """

    x: real
    z: real
    angle: real
    along: real
    sine: real
    cosine: real
    depth: real


@wp.struct
class Top:
    """The top of a body: its ends and its height, from the centre of mass [m]."""

    low: real
    high: real
    height: real


@wp.struct
class Window:
    """The corners of a step: the one with the role 0, and its neighbours."""

    before: Foot
    middle: Foot
    after: Foot


@wp.struct
class Middle:
    """The corner with the role 0: its row, and the number of rows it moved in this step."""

    row: int
    way: int


@wp.func
def ground_top() -> Top:
    """The top of the ground, without ends."""
    return Top(-GROUND_FACE, GROUND_FACE, real(0.0))


@wp.func
def top_of(block: Block) -> Top:
    """The top of a block."""
    return Top(block.top_low, block.top_high, block.top)


@wp.func
def start_impulses(block: Block, lean: real, below: real):
    """First guesses of the impulses at the point away from a side, and at the next one.

    `below` is the rotation of the body below [rad]. A block that is rotated relative to it stands
    on the second point alone.
    """
    zero, ahead, flat = real(0.0), lean > real(0.0), block.theta == below
    one = wp.where(flat, wp.where(ahead, block.left, block.right), zero)
    two = wp.where(flat, wp.where(ahead, block.right, block.left), block.left + block.right)
    return Impulse(one, zero), Impulse(two, zero)


@wp.func
def along_top(foot: Foot, at: Pose, below: Pose) -> real:
    """Place of a corner of a block along the top below [m]."""
    dx, dz = at.x - below.x, at.z - below.z
    across = dx + rotated_x(foot.x, foot.z, at.s, at.c)
    return across * below.c - (dz + rotated_z(foot.x, foot.z, at.s, at.c)) * below.s


@wp.func
def way_of_window(window: Window, lean: real, at: Pose, below: Pose, top: Top) -> int:
    """Number of corners to +x by which the window of an interface moves: -1, 0 or 1.

    A step passes at most one edge or one corner, except for corners so close together that it does
    not matter which of them counts.

    Args:
        window: The window.
        lean: Side to which the interface counts as leaning if an edge lies flat.
        at: Pose of the block.
        below, top: Pose of the body below, and its top.
    """
    zero, turn = real(0.0), at.theta - below.theta
    before, middle, after = window.before, window.middle, window.after
    place = along_top(middle, at, below)
    has_before, has_after = before.along < middle.along, after.along > middle.along
    far = has_before and along_top(before, at, below) > top.high
    short = has_after and along_top(after, at, below) < top.low
    on = turn > middle.angle or (turn == middle.angle and lean > zero)
    back = turn < before.angle or (turn == before.angle and lean < zero)
    returns = wp.where(back and has_before and place >= top.low, -1, 0)
    turned = wp.where(on and has_after and place <= top.high, 1, returns)
    return wp.where(far, -1, wp.where(short, 1, turned))


@wp.func
def overlap_of(first: Foot, middle: Foot, last: Foot, at: Pose, below: Pose, top: Top) -> real:
    """Width of the part of a chain over the top below [m].

    The chain reaches from its first to its last corner, or to one between them after a large
    rotation.
    """
    a = along_top(first, at, below)
    b = along_top(middle, at, below)
    d = along_top(last, at, below)
    return smaller(larger(larger(a, b), d), top.high) - larger(smaller(smaller(a, b), d), top.low)


@wp.func
def find_foot(window: Window, role: int, at: Pose, below: Pose, top: Top):
    """The point with a role in the window of an interface.

    Args:
        window: The window.
        role: -1, 0 or 1.
        at: Pose of the block.
        below, top: Pose of the body below, and its top.

    Returns:
        Whether there is such a point; the point; the gap there [m]; the place of the block along
        the touched face [m], which changes only by sliding.
    """
    before, middle, after = window.before, window.middle, window.after
    s, c, ls, lc, dx, dz = at.s, at.c, below.s, below.c, at.x - below.x, at.z - below.z
    x = wp.where(role < 0, before.x, wp.where(role > 0, after.x, middle.x))
    z = wp.where(role < 0, before.z, wp.where(role > 0, after.z, middle.z))
    along = wp.where(role < 0, before.along, wp.where(role > 0, after.along, middle.along))
    px, pz = rotated_x(x, z, s, c), rotated_z(x, z, s, c)
    ax, az = dx + px, dz + pz
    place = ax * lc - az * ls
    first = along_top(middle, at, below)
    over = wp.where(place > top.high, 1, wp.where(place < top.low, -1, 0))
    passed = wp.where(first > top.high, 1, wp.where(first < top.low, -1, 0))
    has_before, has_after = before.along < middle.along, after.along > middle.along
    back = role < 0 or (role == 0 and over > 0)
    has_edge = wp.where(back, has_before, has_after)
    has_corner = wp.where(role < 0, has_before, role == 0 or has_after)
    inside = over == 0
    # An end lies under one edge only; the role is 0 if the corner with that role lies beyond it.
    over_end = has_edge and (role == 0 or (over == role and passed != role))
    there = wp.where(inside, has_corner, over_end)
    line_s = wp.where(back, before.sine, middle.sine)
    line_c = wp.where(back, before.cosine, middle.cosine)
    es, ec = s * line_c - c * line_s, c * line_c + s * line_s
    end = wp.where(over > 0, top.high, top.low)
    qx, qz = end * lc + top.height * ls, top.height * lc - end * ls
    bx, bz = qx - dx, qz - dz
    nx, nz = wp.where(inside, ls, es), wp.where(inside, lc, ec)
    rx, rz = wp.where(inside, px, bx), wp.where(inside, pz, bz)
    lx, lz = wp.where(inside, ax, qx), wp.where(inside, az, qz)
    au, bu = rx * nz - rz * nx, rx * nx + rz * nz
    al, bl = lx * nz - lz * nx, lx * nx + lz * nz
    depth = wp.where(back, before.depth, middle.depth)
    gap = wp.where(inside, ax * ls + az * lc - top.height, -bx * es - bz * ec - depth)
    # Distance of the end along its edge, from the corner at which the edge begins.
    begin = (
        wp.where(back, before.x, middle.x) * line_c + wp.where(back, before.z, middle.z) * line_s
    )
    seen = au - begin + wp.where(back, before.along, middle.along)
    return there, Point(nx, nz, au, bu, al, bl), gap, wp.where(inside, al - along, end - seen)
