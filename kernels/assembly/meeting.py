"""Contacts between blocks that no joint declares: found anew where outlines come near.

Outlines are convex polygons, counterclockwise. Of two of them the edge counts from whose line the
other is farthest (separating axes; Gottschalk, Lin and Manocha 1996, OBBTree, *SIGGRAPH*). What the
facing edge of the other has beside it is cut at its two ends: two contacts at most, each a corner
of one block on an edge of the other, with the normal of that edge.

Blocks that share a joint meet there already: of them only what is no corner of the joint on an edge
of the joint is a contact here, until one has turned by a right angle against the other.

Two blocks side by side make no step that a third could strike from the side: an edge that has less
than `SLIP` of its length beside the other's is no contact. So a corner that has sunk in by what
steps leave slides over the seam.

The ground goes on to both sides, level, as the last body of a lane: what is lower is a contact.

Only pairs that may touch soon are looked at. They are listed anew once blocks may have come nearer
than the list allows: while nothing moves far, nothing is looked for.
"""

import warp as wp

from warprock.kernels.assembly.block import Seen
from warprock.kernels.assembly.joint import Contact, contact_at
from warprock.kernels.contact.parting import ARCS, FALLS
from warprock.kernels.lane.modes import STALLED
from warprock.kernels.shape.interface import Mass, Pose

SCOPE = real(0.15)
"""Clearance up to which pairs are listed, over the half diagonal of the smallest block."""
NEAR = real(0.02)
"""Gap up to which corners are contacts, likewise, unless a step moves blocks farther."""
STEPS_AHEAD = real(3.0)
"""Steps of the fastest corner that this gap covers at least."""
SLIP = real(4.0e-3)
"""Least length of an edge beside the other's, over the same half diagonal: a multiple of what
blocks sink in, a small part of what lies on an edge."""
BELOW = real(-1.0e30)
"""Its negative begins a search for the least number: Warp would write into a plain constant."""
NONE = -1
"""No joint, and no edge."""
BLOCK_COUNT, JOINT_COUNT = 0, 1
"""Where the counts of a lane's blocks and joints stand in `graph`, and in space in `sizes`."""
JOINED = 2
"""Where the two blocks of its first joint stand in `graph`."""


@wp.struct
class Around:
    """What a lane has besides its blocks and joints.

    Attributes:
        scale: Half diagonal of its smallest block [m].
        friction: Coulomb friction coefficient of contacts that no joint declares.
    """

    scale: real
    friction: real


@wp.struct
class Corner:
    """A corner of a block, and the edge that begins there, in the axes of the block.

    Attributes:
        x, z: From its centre of mass [m].
        nx, nz: Outward unit normal of the edge.
        length: Of the edge [m].
    """

    x: real
    z: real
    nx: real
    nz: real
    length: real


@wp.struct
class EdgeStarts:
    """The corners at which the edges of a joint begin, of its two blocks."""

    a: int
    b: int


@wp.struct
class Body:
    """A block as contacts are looked for; the last one of a lane is the ground.

    Attributes:
        first: Its first corner among those of its lane.
        count: How many it has; 0 of the ground, and of what is fixed below the ground.
        stands: The corner at which its edge on the ground begins; `NONE` without one.
        reach: Distance of the farthest corner from its centre [m].
        mass: Its inverse masses.
        pose: Where it is; of the ground z is its level.
    """

    first: int
    count: int
    stands: int
    reach: real
    mass: Mass
    pose: Pose


@wp.struct
class Pair:
    """Two blocks that may touch.

    Attributes:
        a, b: The blocks, a < b.
        edge_a, edge_b: The corners at which the edges of their joint begin; `NONE` without one.
    """

    a: int
    b: int
    edge_a: int
    edge_b: int


@wp.struct
class Free:
    """A contact of a pair from step to step.

    Attributes:
        a, b: The blocks.
        there: 1 where it is a contact in this step, else 0.
        parted: 1 where it has parted and not landed since, else 0.
        at: The contact.
        n, t: Its impulses [N s].
        pn, pt, dn, dt: As `Way` of solve.py.
    """

    a: int
    b: int
    there: int
    parted: int
    at: Contact
    n: real
    t: real
    pn: real
    pt: real
    dn: real
    dt: real


@wp.struct
class Near:
    """What a lane has of pairs and their contacts.

    Attributes:
        pairs: How many are listed; `NONE` before the first list.
        half: Where the list begins: one is written while the last one is read.
        touching: How many contacts there are in this step.
        full: 1 where the list has no room for all pairs, else 0.
        travelled: How far a corner may have come since the list was made [m].
        scope: Clearance up to which pairs are listed [m].
        range: Gap up to which corners are contacts [m].
        limit: Gap beyond which a contact has parted [m], about as `slack` in parting.py.
        deepest: Deepest penetration of a contact in this step [m].
        landed: Contacts that carry again after they had parted.
        carries: 1 where a contact carried in the last step, else 0.
        looks: 1 where pairs are looked at in this step, else 0.
    """

    pairs: int
    half: int
    touching: int
    full: int
    travelled: real
    scope: real
    range: real
    limit: real
    deepest: real
    landed: int
    carries: int
    looks: int


@wp.struct
class Facing:
    """The edge from whose line another block is farthest, and by how much [m]."""

    edge: int
    gap: real


@wp.struct
class Beside:
    """What two edges have side by side, from its lower end on the edge that counts to the higher.

    Attributes:
        nx, nz: Outward normal of the edge that counts.
        x0, z0, x1, z1: Corners at the two ends, from the centre of the block of that edge [m].
        gap0, gap1: Their gaps [m]; NEVER where there is no contact.
    """

    nx: real
    nz: real
    x0: real
    z0: real
    x1: real
    z1: real
    gap0: real
    gap1: real


@wp.struct
class Laid:
    """Where all blocks of a launch are, and what is kept of their free contacts.

    Attributes:
        graph: A row a pack: BLOCK_COUNT, JOINT_COUNT, then the two blocks of each joint.
        spare: 1 of a lane that only fills up its pack, else 0, shape [lane].
        around: Shape [lane].
        corners: Of all blocks of a lane, block by block, shape [lane, corner].
        sides: Of its joints, shape [lane, joint].
        bodies: Its blocks and the ground, shape [lane, block].
        pairs: Two lists of pairs, one behind the other, shape [lane, 2 pairs].
        free: Two contacts of each, shape [lane, 4 pairs].
        touching: Places there of the contacts of the step, shape [lane, 2 pairs].
    """

    graph: wp.array2d(dtype=int)
    spare: wp.array(dtype=int)
    around: wp.array(dtype=Around)
    corners: wp.array2d(dtype=Corner)
    sides: wp.array2d(dtype=EdgeStarts)
    bodies: wp.array2d(dtype=Body)
    pairs: wp.array2d(dtype=Pair)
    free: wp.array2d(dtype=Free)
    touching: wp.array2d(dtype=int)


@wp.func
def blocks_of(laid: Laid, pack: int, joint: int):
    """The two blocks of a joint."""
    at = JOINED + 2 * joint
    return int(laid.graph[pack, at]), int(laid.graph[pack, at + 1])


@wp.func
def comes_before(laid: Laid, pack: int, joint: int, a: int, b: int) -> bool:
    """Whether a joint comes before one of the blocks a and b in the order of their blocks."""
    low, high = blocks_of(laid, pack, joint)
    return low < a or (low == a and high < b)


@wp.func
def joins(laid: Laid, pack: int, joint: int, a: int, b: int) -> bool:
    """Whether a joint is between the blocks a and b."""
    low, high = blocks_of(laid, pack, joint)
    return low == a and high == b


@wp.func
def next_corner(corner: int, count: int) -> int:
    """The next corner."""
    return wp.where(corner + 1 < count, corner + 1, 0)


@wp.func
def seen_from(x: real, z: real, own: Pose, other: Pose):
    """A point of one block in the axes of another one, from its centre [m]."""
    wx = wedge(x, z, own.s, own.c) + own.x - other.x
    wz = dot(x, z, own.s, own.c) + own.z - other.z
    return dot(wx, wz, other.c, other.s), wedge(wz, wx, other.s, other.c)


@wp.func
def facing_edge(
    laid: Laid, lane: int, one: Body, other: Body
) -> Facing:  # fmt: skip
    """The edge of a block from whose line another one is farthest."""
    found = Facing(0, -NEVER)
    for edge in range(one.count):
        side = laid.corners[lane, one.first + edge]
        nearest = -BELOW
        for k in range(other.count):
            corner = laid.corners[lane, other.first + k]
            x, z = seen_from(corner.x, corner.z, other.pose, one.pose)
            nearest = smaller(dot(x - side.x, z - side.z, side.nx, side.nz), nearest)
        if nearest > found.gap:
            found = Facing(edge, nearest)
    return found


@wp.func
def clearance(
    laid: Laid, lane: int, one: Body, other: Body, edge: int
) -> real:  # fmt: skip
    """How far the corners of a block are from another one, but for those of one edge [m]."""
    found = -BELOW
    for k in range(one.count):
        if k != edge and k != next_corner(edge, one.count):
            corner = laid.corners[lane, one.first + k]
            x, z = seen_from(corner.x, corner.z, one.pose, other.pose)
            away = -NEVER
            for at in range(other.count):
                side = laid.corners[lane, other.first + at]
                away = larger(dot(x - side.x, z - side.z, side.nx, side.nz), away)
            found = smaller(away, found)
    return found


@wp.func
def above_ground(
    laid: Laid, lane: int, one: Body, level: real, edge: int
) -> real:  # fmt: skip
    """Height of the lowest corner of a block above the ground, but for those of one edge [m]."""
    found = -BELOW
    for k in range(one.count):
        if edge < 0 or (k != edge and k != next_corner(edge, one.count)):
            corner = laid.corners[lane, one.first + k]
            high = dot(corner.x, corner.z, one.pose.s, one.pose.c) + one.pose.z - level
            found = smaller(high, found)
    return found


@wp.func
def faces(a: Pose, b: Pose) -> bool:
    """Whether the edges of a joint of two blocks still face each other."""
    return dot(a.s, a.c, b.s, b.c) > real(0.0)


@wp.func
def shared_length(
    laid: Laid, lane: int, a: Body, b: Body, pair: Pair
) -> real:  # fmt: skip
    """What the edges of a joint have side by side [m]."""
    start = laid.corners[lane, a.first + pair.edge_a]
    stop = laid.corners[lane, a.first + next_corner(pair.edge_a, a.count)]
    side = laid.corners[lane, b.first + pair.edge_b]
    x0, z0 = seen_from(start.x, start.z, a.pose, b.pose)
    x1, z1 = seen_from(stop.x, stop.z, a.pose, b.pose)
    # The edge runs along (-n_z, n_x).
    s0 = wedge(z0 - side.z, x0 - side.x, side.nz, side.nx)
    s1 = wedge(z1 - side.z, x1 - side.x, side.nz, side.nx)
    return smaller(larger(s0, s1), side.length) - larger(smaller(s0, s1), real(0.0))


@wp.func
def room_between(
    laid: Laid, lane: int, a: Body, b: Body, pair: Pair
) -> real:  # fmt: skip
    """How far two blocks may move until they may touch where no joint has them [m]."""
    if b.count == 0:
        edge = wp.where(a.pose.c > real(0.0), a.stands, NONE)
        return above_ground(laid, lane, a, b.pose.z, edge)
    if pair.edge_a == NONE:
        one, other = facing_edge(laid, lane, a, b), facing_edge(laid, lane, b, a)
        return larger(one.gap, other.gap)
    if not faces(a.pose, b.pose):
        return real(-1.0)
    near_a = clearance(laid, lane, a, b, pair.edge_a)
    near_b = clearance(laid, lane, b, a, pair.edge_b)
    return smaller(smaller(near_a, near_b), shared_length(laid, lane, a, b, pair))


@wp.func
def opposite_edge(
    laid: Laid, lane: int, one: Body, other: Body, edge: int
) -> int:  # fmt: skip
    """The edge of another block that faces an edge of a block most."""
    side = laid.corners[lane, one.first + edge]
    c = dot(one.pose.s, one.pose.c, other.pose.s, other.pose.c)
    s = wedge(other.pose.s, other.pose.c, one.pose.s, one.pose.c)
    found, least = int(0), -BELOW
    for k in range(other.count):
        at = laid.corners[lane, other.first + k]
        along = dot(wedge(at.nx, at.nz, s, c), dot(at.nx, at.nz, s, c), side.nx, side.nz)
        if along < least:
            found = k
            least = along
    return found


@wp.func
def of_joint(corner: int, count: int, edge: int, own: int, others: int) -> bool:
    """Whether a corner on an edge is one of a joint.

    Args:
        corner: The corner.
        count: How many its block has.
        edge: The edge of the other block.
        own: The edge of the joint on the block of the corner; `NONE` without a joint.
        others: That on the block of the edge.
    """
    return others >= 0 and edge == others and (corner == own or corner == next_corner(own, count))


@wp.func
def overlap_of(
    laid: Laid, lane: int, one: Body, other: Body, edge: int, joint: EdgeStarts,
    slip: real, range_: real,
) -> Beside:  # fmt: skip
    """What an edge of a block and the one that faces it have side by side.

    Args:
        laid: Where the blocks are.
        lane: The lane.
        one, other: The block of the edge that counts, and the other one.
        edge: The edge.
        joint: The edges of their joint, `NONE` without one: first that of `one`.
        slip: Least length [m].
        range_: Gap up to which there is a contact [m].
    """
    side = laid.corners[lane, one.first + edge]
    facing = opposite_edge(laid, lane, one, other, edge)
    behind = next_corner(facing, other.count)
    start, stop = laid.corners[lane, other.first + facing], laid.corners[lane, other.first + behind]
    x0, z0 = seen_from(start.x, start.z, other.pose, one.pose)
    x1, z1 = seen_from(stop.x, stop.z, other.pose, one.pose)
    x0 = x0 - side.x
    z0 = z0 - side.z
    x1 = x1 - side.x
    z1 = z1 - side.z
    # Counterclockwise both: the other edge runs against this one, from its higher end downwards.
    high, low = wedge(z0, x0, side.nz, side.nx), wedge(z1, x1, side.nz, side.nx)
    gap_high, gap_low = dot(x0, z0, side.nx, side.nz), dot(x1, z1, side.nx, side.nz)
    begin, end = larger(low, real(0.0)), smaller(high, side.length)
    long = end - begin > slip
    slope = wp.where(long, (gap_high - gap_low) / wp.where(long, high - low, real(1.0)), real(0.0))
    gap0, gap1 = fused(slope, begin - low, gap_low), fused(slope, end - low, gap_low)
    last = next_corner(edge, one.count)
    joint0 = of_joint(edge, one.count, facing, joint.a, joint.b)
    if low >= real(0.0):
        joint0 = of_joint(behind, other.count, edge, joint.b, joint.a)
    joint1 = of_joint(last, one.count, facing, joint.a, joint.b)
    if high <= side.length:
        joint1 = of_joint(facing, other.count, edge, joint.b, joint.a)
    px, pz = side.x - side.nz * begin + side.nx * gap0, side.z + side.nx * begin + side.nz * gap0
    qx, qz = side.x - side.nz * end + side.nx * gap1, side.z + side.nx * end + side.nz * gap1
    s, c = one.pose.s, one.pose.c
    return Beside(
        wedge(side.nx, side.nz, s, c), dot(side.nx, side.nz, s, c),
        wedge(px, pz, s, c), dot(px, pz, s, c), wedge(qx, qz, s, c), dot(qx, qz, s, c),
        wp.where(long and gap0 <= range_ and not joint0, gap0, NEVER),
        wp.where(long and gap1 <= range_ and not joint1, gap1, NEVER),
    )  # fmt: skip


@wp.func
def on_ground(
    laid: Laid, lane: int, one: Body, level: real, range_: real
) -> Beside:  # fmt: skip
    """The lowest edge of a block on the ground, from -x to +x."""
    s, c = one.pose.s, one.pose.c
    facing, least = int(0), -BELOW
    for k in range(one.count):
        at = laid.corners[lane, one.first + k]
        up = dot(at.nx, at.nz, s, c)
        if up < least:
            facing = k
            least = up
    behind = next_corner(facing, one.count)
    start, stop = laid.corners[lane, one.first + facing], laid.corners[lane, one.first + behind]
    x0, z0 = wedge(start.x, start.z, s, c), dot(start.x, start.z, s, c)
    x1, z1 = wedge(stop.x, stop.z, s, c), dot(stop.x, stop.z, s, c)
    gap0, gap1 = one.pose.z + z0 - level, one.pose.z + z1 - level
    edge = wp.where(c > real(0.0), one.stands, NONE)
    joint0 = edge >= 0 and (facing == edge or facing == next_corner(edge, one.count))
    joint1 = edge >= 0 and (behind == edge or behind == next_corner(edge, one.count))
    return Beside(
        real(0.0), real(1.0), x0, z0, x1, z1,
        wp.where(gap0 <= range_ and not joint0, gap0, NEVER),
        wp.where(gap1 <= range_ and not joint1, gap1, NEVER),
    )  # fmt: skip


@wp.func
def meet(laid: Laid, lane: int, a: Body, b: Body, pair: Pair, near: Near) -> Beside:
    """Where two blocks meet: normal from the second into the first, ends along its tangent.

    The places of the corners are from the centre of the first block.
    """
    if b.count == 0:
        return on_ground(laid, lane, a, b.pose.z, near.range)
    slip = SLIP * laid.around[lane].scale
    joint = EdgeStarts(NONE, NONE)
    if pair.edge_a != NONE and faces(a.pose, b.pose):
        joint = EdgeStarts(pair.edge_a, pair.edge_b)
    one, other = facing_edge(laid, lane, a, b), facing_edge(laid, lane, b, a)
    nothing = Beside()
    nothing.gap0 = NEVER
    nothing.gap1 = NEVER
    if larger(one.gap, other.gap) > near.range:
        return nothing
    if one.gap > other.gap:
        met = overlap_of(laid, lane, a, b, one.edge, joint, slip, near.range)
        met.nx = -met.nx
        met.nz = -met.nz
        return met
    turned = EdgeStarts(joint.b, joint.a)
    met = overlap_of(laid, lane, b, a, other.edge, turned, slip, near.range)
    # Its tangent runs against the edge of the second block: the ends change places.
    dx, dz = b.pose.x - a.pose.x, b.pose.z - a.pose.z
    return Beside(
        met.nx, met.nz, met.x1 + dx, met.z1 + dz, met.x0 + dx, met.z0 + dz, met.gap1, met.gap0
    )


@wp.func
def look_out(scale: real, dt: real, gravity: real, speed: real, near: Near) -> Near:
    """How far a lane has to look where a step begins.

    Args:
        scale: Half diagonal of its smallest block [m].
        dt: Time step [s].
        gravity: Acceleration of gravity [m/s^2].
        speed: Largest speed of a corner in the last step [m/s].
        near: Its list.
    """
    found = near
    step = dt * speed
    found.travelled = near.travelled + step
    found.range = larger(NEAR * scale, STEPS_AHEAD * step)
    found.limit = fused(ARCS * step, step / scale, FALLS * gravity * dt * dt)
    scope = larger(SCOPE * scale, TWO * found.range)
    found.scope = wp.where(is_old(found), scope, found.scope)
    return found


@wp.func
def is_old(near: Near) -> bool:
    """Whether blocks that are not listed may be within range."""
    return near.pairs == NONE or fused(TWO, near.travelled, near.range) > near.scope


@wp.func
def observe_free(live: bool, goes: bool, near: Near, seen: wp.ref[Seen]):
    """What the contacts of a step that no joint declares show, where the next one begins.

    Args:
        live: Whether its lane still runs.
        goes: Whether the lane begins a step.
        near: Its list.
        seen: What is seen of the lane.
    """
    seen.leans = wp.where(goes, near.carries, seen.leans)
    seen.impacts = seen.impacts + wp.where(live, near.landed, 0)
    seen.deepest = wp.where(live, larger(near.deepest, seen.deepest), seen.deepest)
    seen.mode = wp.where(live and near.full > 0, STALLED, seen.mode)


@wp.func
def list_pairs(laid: Laid, lane: int, pack: int, near: Near) -> Near:
    """Lists the pairs of a lane that may touch soon, in the order of their blocks.

    What is kept of their contacts moves with them. Joints come in the order of their blocks, too.
    """
    count = laid.graph[pack, BLOCK_COUNT]
    joints = laid.graph[pack, JOINT_COUNT]
    room = laid.pairs.shape[1] // 2
    half = wp.where(near.half == 0, room, 0)
    joint, found, old = int(0), int(0), int(0)
    for a in range(count):
        one = laid.bodies[lane, a]
        for b in range(a + 1, count + 1):
            edges = EdgeStarts(NONE, NONE)
            while joint < joints and comes_before(laid, pack, joint, a, b):
                joint += 1
            if joint < joints and joins(laid, pack, joint, a, b):
                edges = laid.sides[lane, joint]
            other = laid.bodies[lane, b]
            dx, dz = one.pose.x - other.pose.x, one.pose.z - other.pose.z
            away = one.reach + other.reach + near.scope
            close = other.count > 0 and dot(dx, dz, dx, dz) < away * away
            close = close or (b == count and dz < one.reach + near.scope)
            moves = one.mass.m > real(0.0) or other.mass.m > real(0.0)
            if one.count > 0 and close and moves:
                pair = Pair(a, b, edges.a, edges.b)
                if room_between(laid, lane, one, other, pair) < near.scope:
                    while old < near.pairs and (
                        laid.pairs[lane, near.half + old].a < a
                        or (
                            laid.pairs[lane, near.half + old].a == a
                            and laid.pairs[lane, near.half + old].b < b
                        )
                    ):
                        old += 1
                    known = int(NONE)
                    if (
                        old < near.pairs
                        and laid.pairs[lane, near.half + old].a == a
                        and laid.pairs[lane, near.half + old].b == b
                    ):
                        known = 2 * (near.half + old)
                    if found < room:
                        laid.pairs[lane, half + found] = pair
                        for end in range(2):
                            kept = Free()
                            kept.a = a
                            kept.b = b
                            kept.parted = wp.where(near.pairs == NONE, 0, 1)
                            if known >= 0:
                                kept = laid.free[lane, known + end]
                            laid.free[lane, 2 * (half + found) + end] = kept
                    found += 1
    listed = near
    listed.pairs = wp.min(found, room)
    listed.half = half
    listed.full = wp.where(found > room, 1, near.full)
    listed.travelled = real(0.0)
    return listed


ALIKE = real(0.9)
"""Cosine of the turn of a normal from which on the impulses of the last step are no guess."""


@wp.func
def find_free(laid: Laid, lane: int, rate: real, near: Near) -> Near:
    """Finds the contacts of the pairs of a lane, where its blocks are at the start of a step.

    Args:
        laid: Where its blocks are.
        lane: The lane.
        rate: 1 / time step [1/s].
        near: Its list.
    """
    zero = real(0.0)
    found = near
    found.touching = 0
    found.deepest = zero
    found.landed = 0
    found.carries = 0
    for p in range(near.pairs):
        place = near.half + p
        pair = laid.pairs[lane, place]
        a = laid.bodies[lane, pair.a]
        b = laid.bodies[lane, pair.b]
        met = meet(laid, lane, a, b, pair, near)
        for end in range(2):
            was = laid.free[lane, 2 * place + end]
            gap = wp.where(end == 0, met.gap0, met.gap1)
            x, z = wp.where(end == 0, met.x0, met.x1), wp.where(end == 0, met.z0, met.z1)
            now = Free()
            now.a = pair.a
            now.b = pair.b
            now.parted = 1
            carried = was.there > 0 and was.n > zero
            if carried:
                found.carries = 1
                found.landed += was.parted
            if gap < NEVER:
                now.there = 1
                now.parted = wp.where(gap > near.limit or (was.parted > 0 and not carried), 1, 0)
                closing = rate * larger(gap, zero)
                dx, dz = a.pose.x - b.pose.x, a.pose.z - b.pose.z
                now.at = contact_at(met.nx, met.nz, x, z, dx, dz, a.mass, b.mass)
                now.at.b = closing
                now.at.friction = laid.around[lane].friction
                if was.there > 0 and dot(was.at.nx, was.at.nz, met.nx, met.nz) > ALIKE:
                    now.n = was.n
                    now.t = was.t
                found.deepest = larger(-gap, found.deepest)
                laid.touching[lane, found.touching] = 2 * place + end
                found.touching += 1
            laid.free[lane, 2 * place + end] = now
    return found
