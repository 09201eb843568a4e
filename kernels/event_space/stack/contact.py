"""Contact points of a stack of blocks in space, and the contact law there.

Bodies, faces and slots are those of shape_space/stack.py. The directions of a contact are the axes
of the face that is touched: of the lower block, or of the upper one if a corner of the lower block
touches it. Where an edge of one face crosses one of the other, the normal is that of both edges; of
edges that are less than about 45 degrees apart, that of the lower face. With friction as a box the
other two are the lower block's axes, projected across the normal. Each contact obeys one *law*:

    CONE    it pushes and does not approach by more than its gap, which is negative where it
            bounces; its friction is within the cone, or box, and against the slip;
    HOLD    it does not move, however large the impulse;
    HOLD_X  it does not move along x and its gap closes, without friction along y; HOLD_Y likewise;
    KEEP    its gap closes, however large the impulse, without friction;
    PUSH    it pushes and does not approach by more than its gap, without friction;
    AWAIT   it has no impulse.

Gauss-Seidel sweeps over all contacts find the impulses. A face has redundant contacts: their
impulses are not unique, but the motion is.
"""

import warp as wp

from warprock.kernels.algebra.vectors import Matrix, Vector, X, Y
from warprock.kernels.shape.faces import (
    ALONG_DEPTH,
    LOWER,
    PARALLEL,
    SLOTS,
    UPPER,
    crosses,
)
from warprock.kernels.shape.interface import GROUND_FACE
from warprock.kernels.shape_space.block import Block
from warprock.kernels.shape_space.contact import (
    NORMAL,
    SLIP_1,
    SLIP_3,
    STOP_XX,
    STOP_XY,
    STOP_XZ,
    STOP_YY,
    STOP_YZ,
    STOP_ZZ,
    Gains,
    gains_of,
    solve_contact,
)
from warprock.kernels.shape_space.frame import axis_of, frame, relative_velocity, rotate_diagonal
from warprock.kernels.shape_space.stack import (
    Axes,
    Bodies,
    Numbers,
    PointGains,
    PointInts,
    PointNumbers,
    Points,
    rows_of,
    shared_corners,
)

CONE = 0
HOLD = 1
KEEP = 2
PUSH = 3
AWAIT = 4
HOLD_X = 5
HOLD_Y = 6
BOX = FRICTION == "box"
"""Whether friction is bound as a box along a contact's directions, else as a cone."""

SWEEPS = 20000
"""Largest number of sweeps of a solve; the second half of them is under-relaxed by 1/2."""
SETTLED = by_precision(1.0e-14, 1.0e-6)
"""Relative change of the impulses in a sweep that is round-off."""
LOOSE = by_precision(1.0e-9, 1.0e-4)
"""Relative change of the impulses above which a solve that used all sweeps has failed."""
INSIDE = by_precision(1.0 - 1.0e-9, 1.0 - 1.0e-4)
"""Largest friction of a contact that counts as sticking, over its bound."""

Attitudes = wp.types.matrix(shape=(BLOCKS + 1, 4), dtype=real)
Ints = wp.types.vector(length=BLOCKS + 1, dtype=int)


@wp.struct
class Rebound:
    """Restitution of contacts that close, and the speed up to which none bounces [m/s]."""

    kept: real
    slow: real


@wp.struct
class Own:
    """The blocks of one lane: those of all lanes, shape [block, lane], and which lane it is.

    With a restitution also how its contacts bounce.
    """

    blocks: wp.array2d(dtype=Block)
    lane: int
    if BOUNCES:
        rebound: Rebound


@wp.struct
class Pose:
    """Pose of all bodies, a matrix by rows.

    Centres of mass [m], axes, inertia [kg m^2] and its inverse, the friction coefficient under each
    body, and its inverse mass [1/kg].
    """

    x: Bodies
    axes: Axes
    inertia: Axes
    ease: Axes
    friction: Numbers
    light: Numbers


@wp.struct
class Touches:
    """The contacts of a stack in one pose.

    Number; upper body, slot, way (see `find_corners`) and law of each; gap [m]; levers from both
    centres of mass [m].
    """

    total: int
    body: PointInts
    slot: PointInts
    way: PointInts
    law: PointInts
    gap: PointNumbers
    ru: Points
    rl: Points


@wp.func
def block_of(own: Own, k: int) -> Block:
    """One of the blocks, the lowest being 1."""
    return own.blocks[k - 1, own.lane]


@wp.func
def pose_of(own: Own, x: Bodies, q: Attitudes) -> Pose:
    """The pose of centres of mass and attitudes."""
    pose = Pose()
    pose.x = x
    for i in range(3):
        pose.axes[i, i] = real(1.0)
    bodies = int(BLOCKS + 1)
    for k in range(1, bodies):
        block = block_of(own, k)
        r = frame(q[k])
        pose.friction[k] = block.friction
        pose.light[k] = real(1.0) / block.mass
        j = rotate_diagonal(r, block.inverse_x, block.inverse_y, block.inverse_z)
        one = real(1.0)
        inertia = rotate_diagonal(
            r, one / block.inverse_x, one / block.inverse_y, one / block.inverse_z
        )
        for i in range(3):
            pose.axes[3 * k + i] = axis_of(r, i)
            pose.inertia[3 * k + i] = axis_of(inertia, i) * block.mass
            pose.ease[3 * k + i] = axis_of(j, i) / block.mass
    return pose


@wp.func
def below_of(own: Own, k: int) -> Block:
    """The block below block k; the ground below the first one."""
    base = Block()
    base.half_width = GROUND_FACE
    base.half_depth = GROUND_FACE
    if k > 1:
        return block_of(own, k - 1)
    return base


@wp.func
def way_of(slot: int, crossed: int) -> int:
    """The way of a contact, see `find_corners`."""
    x, y = crossed & (1 << (slot + SLOTS)), crossed & (1 << slot)
    return slot + wp.where(x != 0, 2 * SLOTS, wp.where(y != 0, SLOTS, 0))


@wp.func
def height_of(own: Own, pose: Pose, k: int, point: Vector) -> real:
    """Height above the face below of a point of block k, given in its own axes [m]."""
    at = pose.x[k] - pose.x[k - 1] + wp.transpose(rows_of(pose.axes, k)) * point
    return wp.dot(pose.axes[3 * k - 1], at) - below_of(own, k).half_height


@wp.func
def directions(axes: Axes, body: int, way: int) -> Matrix:
    """Directions of a contact, one a row."""
    e = rows_of(axes, wp.where(way >= LOWER and way < SLOTS, body, body - 1))
    if way >= SLOTS:
        # An edge of the upper face, and one of the lower face across it.
        upper = axes[3 * body + wp.where(way % SLOTS < ALONG_DEPTH, 0, 1)]
        lower = 3 * body - 3 + wp.where(way < 2 * SLOTS, 0, 1)
        upper = wp.sign(wp.dot(upper, axes[lower])) * upper
        if way < 2 * SLOTS:
            e[0] = upper
            e[2] = wp.normalize(wp.cross(upper, axes[3 * body - 2]))
        else:
            e[0] = axes[3 * body - 3]
            e[2] = wp.normalize(wp.cross(e[0], upper))
        e[1] = wp.cross(e[2], e[0])
    if BOX:  # noqa: SIM102, decided before launch
        if way >= LOWER:
            normal = Vector(e[2, 0], e[2, 1], e[2, 2])
            x = axes[3 * body - 3]
            x = wp.normalize(x - wp.dot(x, normal) * normal)
            e[0] = x
            e[1] = wp.cross(normal, x)
    return e


@wp.func(inline=False)
def find_corners(own: Own, pose: Pose, k: int):
    """Corners of the overlap of the faces of interface k, by slot: see `shared_corners`.

    The fourth value is a mask of the slots at which edges cross that run in other directions, of
    faces that are not parallel: of the slots themselves where the lower edge runs along y, SLOTS
    bits higher where it runs along x. The *way* of a contact is its slot, at such crossings SLOTS
    or twice that more. Gaps are distances along the normal of the contact. Faces that look away
    from each other have no corners.
    """
    one = real(1.0)
    down = rows_of(pose.axes, k - 1)
    m = down * wp.transpose(rows_of(pose.axes, k))
    c = down * (pose.x[k] - pose.x[k - 1])
    lean = Vector(one, one, one)
    below = below_of(own, k)
    places, gaps, there = shared_corners(block_of(own, k), below, m, c, lean)
    tilted = size(m[2, 0]) + size(m[2, 1]) > PARALLEL
    crossed = int(0)
    there = wp.where(m[2, 2] > real(0.0), there, 0)
    if tilted:
        slots = int(SLOTS)
        for i in range(UPPER, slots):
            x, y = places[i, X] + below.centre_x, places[i, Y] + below.centre_y
            edge = axis_of(m, wp.where(i < ALONG_DEPTH, 0, 1))
            if crosses(i, x, edge[1], below.half_width):
                crossed = crossed | (1 << i)
            elif crosses(i, y, edge[0], below.half_depth):
                crossed = crossed | (1 << (i + SLOTS))
            if (there & (1 << i)) != 0:
                normal = directions(pose.axes, k, way_of(i, crossed))[2]
                gaps[i] = gaps[i] * wp.dot(normal, down[2])
    return places, gaps, there, crossed


@wp.func
def add_contact(before: Touches, pose: Pose, k: int, way: int, law: int, gap: real, place: Vector):
    """The contacts with one added, its place from the lower block's centre in that block's axes."""
    t = before
    i = t.total
    slot = way % SLOTS
    lever = wp.transpose(rows_of(pose.axes, k - 1)) * place
    t.body[i] = k
    t.slot[i] = slot
    t.way[i] = way
    t.law[i] = law
    t.gap[i] = gap
    t.rl[i] = lever
    t.ru[i] = lever + pose.x[k - 1] - pose.x[k]
    t.total = i + 1
    return t


@wp.func
def solve_by_law(
    t: Touches, i: int, pose: Pose, gains: Gains, e: Matrix, p: Vector, v: Bodies, w: Bodies
) -> Vector:
    """Impulses of one contact by its law, those of the others fixed; see `solve_contact`."""
    zero, g, k = real(0.0), gains, t.body[i]
    mu, vu, ou, vl, ol = pose.friction[k], v[k], w[k], v[k - 1], w[k - 1]
    u = relative_velocity(vu, ou, t.ru[i], vl, ol, t.rl[i])
    if t.law[i] == CONE:
        return solve_contact(mu, zero, g, e, p, u + t.gap[i] * e[2])
    at = e * u
    if t.law[i] == HOLD:
        return Vector(
            p[0] - g[STOP_XX] * at[0] - g[STOP_XY] * at[1] - g[STOP_XZ] * at[2],
            p[1] - g[STOP_XY] * at[0] - g[STOP_YY] * at[1] - g[STOP_YZ] * at[2],
            p[2] - g[STOP_XZ] * at[0] - g[STOP_YZ] * at[1] - g[STOP_ZZ] * at[2],
        )
    if t.law[i] == AWAIT:
        return p
    push = p[2] - g[NORMAL] * (at[2] + t.gap[i])
    if BOX:
        if t.law[i] == HOLD_X:
            return Vector(p[0] - g[SLIP_1] * at[0], zero, push)
        if t.law[i] == HOLD_Y:
            return Vector(zero, p[1] - g[SLIP_3] * at[1], push)
    return Vector(zero, zero, wp.where(t.law[i] == KEEP, push, larger(push, zero)))


@wp.func(inline=False)
def solve_by_sweeps(sweeps: int, t: Touches, pose: Pose, first: Points, v: Bodies, w: Bodies):
    """Impulses of all contacts, and the velocities with them.

    Args:
        sweeps: Largest number of sweeps.
        t: The contacts.
        pose: Where the bodies are.
        first: Impulses to start from [N s].
        v, w: Velocity [m/s] and angular velocity [rad/s] of each body without contact.

    Returns:
        Impulses along the directions of each contact, velocities, angular velocities, and whether
        the sweeps converged.
    """
    u, o, p, gains = Bodies(), Bodies(), Points(), PointGains()
    bodies = int(BLOCKS + 1)
    for k in range(bodies):
        u[k] = v[k]
        o[k] = w[k]
    good = bool(False)
    for step in range(-1, sweeps):
        change, norm_sq = real(0.0), real(0.0)
        part = wp.where(2 * step > sweeps, real(0.5), real(1.0))
        for i in range(t.total):
            k = t.body[i]
            low = k - 1
            e = directions(pose.axes, k, t.way[i])
            ju, jl = rows_of(pose.ease, k), rows_of(pose.ease, low)
            new = first[i]
            if step < 0:
                gains[i] = gains_of(pose.light[k] + pose.light[low], e, ju, jl, t.ru[i], t.rl[i])
            else:
                new = solve_by_law(t, i, pose, gains[i], e, p[i], u, o)
                new = p[i] + part * (new - p[i])
            more = wp.transpose(e) * (new - p[i])
            change += wp.dot(more, more)
            norm_sq += wp.dot(new, new)
            p[i] = new
            u[k] = u[k] + pose.light[k] * more
            o[k] = o[k] + ju * wp.cross(t.ru[i], more)
            u[low] = u[low] - pose.light[low] * more
            o[low] = o[low] - jl * wp.cross(t.rl[i], more)
        good = (
            step >= 0
            and change <= wp.where(sweeps == SWEEPS, LOOSE * LOOSE, SETTLED * SETTLED) * norm_sq
        )
        if step >= 0 and change <= SETTLED * SETTLED * norm_sq:
            break
    return p, u, o, good


@wp.func
def sticking_bits(slot: int, mu: real, p: Vector) -> int:
    """Bits of a contact with law CONE if it sticks: its slot; of the box along y, its slot + 16."""
    most = INSIDE * mu * p[2]
    bits = wp.where(wp.sqrt(p[0] * p[0] + p[1] * p[1]) < most, 1 << slot, 0)
    if BOX:
        x = wp.where(wp.abs(p[0]) < most, 1 << slot, 0)
        bits = x | wp.where(wp.abs(p[1]) < most, 1 << (SLOTS + slot), 0)
    return wp.where(p[2] > real(0.0), bits, 0)


@wp.func
def sticking_law(slot: int, bits: int, law: int) -> int:
    """Law of a contact that sticks by `sticking_bits`: HOLD, HOLD_X or HOLD_Y; else `law`."""
    x = (bits & (1 << slot)) != 0
    found = wp.where(x, HOLD, law)
    if BOX:
        y = (bits & (1 << (SLOTS + slot))) != 0
        found = wp.where(x and y, HOLD, wp.where(x, HOLD_X, wp.where(y, HOLD_Y, law)))
    return found
