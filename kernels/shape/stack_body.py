"""A stack in the plane whose blocks stand on chains of corners, each on the top of the one below.

A block stands on the corners of a chain that is convex towards what is below (see shape/body.py)
and carries the next one on its top, a flat face from `low` to `high` along it, `top` above its
centre of mass. A box stands on two corners.

Only the part of the chain above the top matters. Its points are the corners above the top; where an
edge passes over an end of the top, the point of the edge above that end is one, too. The chain is
convex, so that only what is near its lowest point can touch. A step looks at three corners, the
*window*, with the roles -1, 0 and 1: the lowest one (if it lies beyond an end of the top, the first
corner beyond that end) and its two neighbours. A corner beyond an end is replaced by the point
above that end, on the edge that leads to it.
"""

import warp as wp

from warprock.kernels.shape.body import turned_x, turned_z


@wp.struct
class Block:
    """One block, and where it starts.

    `aside` is how far its centre is to +x of the one below when both are upright [m], of the
    lowest block zero; `reach` at least the distance of its corners from its centre [m]; `window`
    the row of the corner that first has the role 0; `left` and `right` as in shape/stack_run.py;
    `area` half of that over which it stands at rest [m^2], `rest` its height then [m].
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

    That edge has the direction (cosine, sine) and lies `depth` below the centre of mass. Blocks
    have the same number of rows; the first corner of a block is there twice, the last one twice or
    more, so that beside every corner there is one, with the same `along` where there is none.
    """

    x: real
    z: real
    angle: real
    along: real
    sine: real
    cosine: real
    depth: real


@wp.func
def start_block(
    block: Block, side: real, below: real, m: wp.ref[real], j: wp.ref[real], mu: wp.ref[real],
    low: wp.ref[real], high: wp.ref[real], top: wp.ref[real], x: wp.ref[real], z: wp.ref[real],
    theta: wp.ref[real], s: wp.ref[real], c: wp.ref[real], peak: wp.ref[real],
    lean: wp.ref[real], window: wp.ref[int], n1: wp.ref[real], n2: wp.ref[real],
):  # fmt: skip
    """Puts a block where it starts.

    Args:
        block: The block.
        side: Side to which it counts as leaning.
        below: Rotation of what it stands on [rad]. Turned against that, it stands on one point.
        m: What is found, as all up to window.
        n1, n2: What the first and the second point carry, from the one away from the side.
    """
    ahead, flat = sign_of(side) > real(0.0), block.theta == below
    n1 = wp.where(flat, wp.where(ahead, block.left, block.right), real(0.0))
    n2 = wp.where(flat, wp.where(ahead, block.right, block.left), block.left + block.right)
    m = block.inverse_mass
    j = block.inverse_inertia
    mu = block.friction
    low = block.top_low
    high = block.top_high
    top = block.top
    x = block.x
    z = block.z
    theta = block.theta
    s = sine(block.theta)
    c = cosine(block.theta)
    peak = size(block.theta)
    lean = sign_of(side)
    window = block.window


@wp.func
def along_top(foot: Foot, s: real, c: real, ls: real, lc: real, dx: real, dz: real) -> real:
    """Where a corner is along the top of what its block stands on [m].

    Args:
        foot: The corner.
        s, c: Sine and cosine of the block's rotation.
        ls, lc: Those of what it stands on.
        dx, dz: Way from the centre there to the block's [m].
    """
    across = dx + turned_x(foot.x, foot.z, s, c)
    return across * lc - (dz + turned_z(foot.x, foot.z, s, c)) * ls


@wp.func
def way_of_window(
    before: Foot, middle: Foot, after: Foot, turn: real, lean: real, s: real, c: real,
    ls: real, lc: real, low: real, high: real, dx: real, dz: real,
) -> int:  # fmt: skip
    """By how many corners to +x the window of an interface moves: -1, 0 or 1.

    In a step no more than one edge or one corner is passed, but for such as lie so close together
    that it does not matter which of them counts.

    Args:
        before: Corner to -x of that with the role 0.
        middle: That one.
        after: Corner to +x of it.
        turn: Rotation of the block against what it stands on [rad].
        lean: Side to which it counts as leaning where an edge lies flat.
        s, c: Sine and cosine of the block's rotation.
        ls, lc: Those of what it stands on.
        low, high: Ends of the top there [m].
        dx, dz: Way from the centre there to the block's [m].
    """
    zero = real(0.0)
    place = along_top(middle, s, c, ls, lc, dx, dz)
    has_before, has_after = before.along < middle.along, after.along > middle.along
    far = has_before and along_top(before, s, c, ls, lc, dx, dz) > high
    short = has_after and along_top(after, s, c, ls, lc, dx, dz) < low
    on = turn > middle.angle or (turn == middle.angle and lean > zero)
    back = turn < before.angle or (turn == before.angle and lean < zero)
    turned = wp.where(
        on and has_after and place <= high, 1, wp.where(back and has_before and place >= low, -1, 0)
    )
    return wp.where(far, -1, wp.where(short, 1, turned))


@wp.func
def overlap_of(
    first: Foot, middle: Foot, last: Foot, s: real, c: real, ls: real, lc: real,
    low: real, high: real, dx: real, dz: real,
) -> real:  # fmt: skip
    """Width of the part of a chain over the top below [m].

    The chain reaches from its first to its last corner, or to one between them where it is turned
    far.
    """
    a = along_top(first, s, c, ls, lc, dx, dz)
    b = along_top(middle, s, c, ls, lc, dx, dz)
    d = along_top(last, s, c, ls, lc, dx, dz)
    return smaller(larger(larger(a, b), d), high) - larger(smaller(smaller(a, b), d), low)


@wp.func
def find_foot(
    before: Foot, middle: Foot, after: Foot, role: int,
    s: real, c: real, ls: real, lc: real, low: real, high: real, top: real, dx: real, dz: real,
):  # fmt: skip
    """The point with a role in the window of an interface.

    Args:
        before: Corner to -x of that with the role 0.
        middle: That one.
        after: Corner to +x of it.
        role: -1, 0 or 1.
        s, c: Sine and cosine of the block's rotation.
        ls, lc: Those of what it stands on, of which all up to top are the top's.
        low, high: Ends of the top along it, from above the centre [m].
        top: Its height above the centre [m].
        dx, dz: Way from the centre there to the block's [m].

    Returns:
        Whether there is such a point; normal (x, z) of the face that is touched; levers of the
        point from the block's centre along that face and along the normal, the same two from the
        centre of what it stands on [m]; the gap [m]; the slide up to a constant [m].
    """
    x = wp.where(role < 0, before.x, wp.where(role > 0, after.x, middle.x))
    z = wp.where(role < 0, before.z, wp.where(role > 0, after.z, middle.z))
    along = wp.where(role < 0, before.along, wp.where(role > 0, after.along, middle.along))
    px, pz = turned_x(x, z, s, c), turned_z(x, z, s, c)
    ax, az = dx + px, dz + pz
    place = ax * lc - az * ls
    first = along_top(middle, s, c, ls, lc, dx, dz)
    over = wp.where(place > high, 1, wp.where(place < low, -1, 0))
    passed = wp.where(first > high, 1, wp.where(first < low, -1, 0))
    has_before, has_after = before.along < middle.along, after.along > middle.along
    back = role < 0 or (role == 0 and over > 0)
    has_edge = wp.where(back, has_before, has_after)
    has_corner = wp.where(role < 0, has_before, role == 0 or has_after)
    inside = over == 0
    # An end is under one edge alone: with the role 0 where its corner lies beyond it.
    over_end = has_edge and (role == 0 or (over == role and passed != role))
    there = wp.where(inside, has_corner, over_end)
    line_s = wp.where(back, before.sine, middle.sine)
    line_c = wp.where(back, before.cosine, middle.cosine)
    es, ec = s * line_c - c * line_s, c * line_c + s * line_s
    end = wp.where(over > 0, high, low)
    qx, qz = end * lc + top * ls, top * lc - end * ls
    bx, bz = qx - dx, qz - dz
    nx, nz = wp.where(inside, ls, es), wp.where(inside, lc, ec)
    rx, rz = wp.where(inside, px, bx), wp.where(inside, pz, bz)
    lx, lz = wp.where(inside, ax, qx), wp.where(inside, az, qz)
    au, bu = rx * nz - rz * nx, rx * nx + rz * nz
    al, bl = lx * nz - lz * nx, lx * nx + lz * nz
    depth = wp.where(back, before.depth, middle.depth)
    gap = wp.where(inside, ax * ls + az * lc - top, -bx * es - bz * ec - depth)
    # How far along its edge the end is seen from the corner at which that begins.
    begin = (
        wp.where(back, before.x, middle.x) * line_c + wp.where(back, before.z, middle.z) * line_s
    )
    seen = au - begin + wp.where(back, before.along, middle.along)
    return there, nx, nz, au, bu, al, bl, gap, wp.where(inside, al - along, end - seen)
