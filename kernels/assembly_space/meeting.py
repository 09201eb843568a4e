"""Where the blocks of an assembly in space touch, found anew once they have moved.

Blocks are convex polyhedra. Two of them touch along a face of one of them or along two edges that
cross: of all faces and of all pairs of edges those count from which the other block is farthest
(separating axes; Gottschalk, Lin and Manocha 1996, OBBTree, *SIGGRAPH*). On a face lies what of the
other block's most opposite face is above it (Sutherland and Hodgman 1974, Reentrant polygon
clipping, *Communications of the ACM* 17): each corner of that polygon is a contact, with the normal
of the face. Edges that cross have one contact, with the normal across both.

Blocks that a joint connects touch along its faces: on the face of the one from which the other is
farther, for as long as these face each other, lie over each other, and neither is deep in the
other. Elsewhere, and once that ends, all faces and edges count. There a face counts but for a rim
of `SLIP`: a block that stands beside another makes no step that a third could strike from the side.

The ground is the last body of a lane, a face without an end.

Only pairs that may touch soon are looked at, as in the plane (assembly/meeting.py).
"""

import warp as wp

from warprock.kernels.algebra.vectors import Matrix, Vector
from warprock.kernels.assembly.meeting import BELOW, NONE
from warprock.kernels.assembly_space.block import Place
from warprock.kernels.assembly_space.contact import (
    Contact,
    Couple,
    Heft,
    Impulse,
    Move,
    Row,
    Weighted,
    cross,
    inner,
    relative,
    tangent_of,
    times,
)

FACES = real(0.9)
"""Cosine of the angle between the two faces of a joint up to which it is one."""
DEEP = real(2.0e-2)
"""How deep a corner may be below the face of a joint, over the half diagonal of the smallest block.
What is deeper has come from the side."""
FLUSH = real(1.0e-4)
"""How far beyond an edge of the one face of a joint the other one is cut, likewise. Edges that were
flush when the wall was built cross anywhere after it has crept by less than a micrometre."""
MERGED = real(1.0e-3)
"""Distance of corners that count as one, likewise."""
SAME = real(5.0e-2)
"""Distance from a contact of the last step up to which a contact goes on as that one, likewise."""
PLAIN = real(1.0e-3)
"""By how much two edges must be farther apart than a face and a block to count, likewise: where
faces are nearly parallel, edges tell the same with more round-off."""
KEPT = real(0.1)
"""How far corners may have moved since contacts were found, over g dt^2, for these to stay as they
are but for their gaps: a corner that goes no faster than that in a step counts as still (`CREEP` in
kernels/contact/parting.py)."""
ACROSS = real(1.0e-2)
"""Sine of the angle between two edges below which they do not cross."""


@wp.struct
class Solid:
    """The shape of a block: where its parts begin among those of its lane, and how many there are.

    Attributes:
        corner, corners: Its corners; none of the ground, and of what is fixed below the ground.
        face, faces: Its faces.
        line, lines: Directions of its edges.
        edge, edges: Its edges.
        span, spans: Widths of its largest joint.
        reach: Distance of the farthest corner from its centre [m].
        moves: 1 where it is not fixed, else 0.
    """

    corner: int
    corners: int
    face: int
    faces: int
    line: int
    lines: int
    edge: int
    edges: int
    span: int
    spans: int
    reach: real
    moves: int


@wp.struct
class Face:
    """A face of a block, in its axes.

    Attributes:
        normal: Outward unit normal.
        level: Distance of its plane from the centre of mass [m].
        ring: Where its corners begin in the list of corners of faces, counterclockwise from
            outside.
        corners: How many there are; 0 of the ground, which goes on everywhere.
    """

    normal: Vector
    level: real
    ring: int
    corners: int


@wp.struct
class Edge:
    """An edge: its two corners, and its direction among those of its block."""

    start: int
    stop: int
    line: int


@wp.struct
class Span:
    """A width of a joint.

    Attributes:
        across: Unit vector across an edge of the joint, in its plane, in the axes of the block.
        width: How wide the joint is that way [m].
    """

    across: Vector
    width: real


@wp.struct
class Link:
    """A joint of a lane, in the order of the blocks.

    Attributes:
        a, b: Its blocks.
        face_a, face_b: Its faces on them.
        number: Which of the joints of the model it is.
        least: Slide up to which neither block has left what bears it [m], see `has_left`.
        friction: Coulomb friction coefficient.
        cohesion, tension: Strength in shear without load and in tension [Pa], see bond.py.
        area: [m^2].
        middle: Of its area, from the centre of its first block in the axes of that one [m].
        bending: Inverse of the second moments of its area about that, in these axes [1/m^4].
        twisting: Inverse of their sum [1/m^4].
    """

    a: int
    b: int
    face_a: int
    face_b: int
    number: int
    least: real
    friction: real
    if BONDS:
        cohesion: real
        tension: real
        area: real
        middle: Vector
        bending: Matrix
        twisting: real


@wp.struct
class Joined:
    """A joint from step to step.

    Attributes:
        first, count: Its contacts in the list of the last step.
        place: Its place in the packs of a sweep.
        opening: Widest gap so far [m].
        most: Largest |slide| so far [m].
        slide: Its slide, while it bears [m].
        holds: 1 while it is bonded, else 0.
    """

    first: int
    count: int
    place: int
    opening: real
    most: real
    slide: Vector
    if BONDS:
        holds: int


@wp.struct
class Pair:
    """Two blocks without a joint that may touch, and their contacts as in `Joined`."""

    a: int
    b: int
    first: int
    count: int
    place: int


@wp.struct
class Mark:
    """A contact from step to step.

    Attributes:
        spot: Where it is, in the axes of its first block [m].
        gap: [m].
        since: When it last carried [s]; NEVER before it does.
        parted: 1 where it has parted and not landed since, else 0.
    """

    spot: Vector
    gap: real
    since: real
    parted: int


@wp.struct
class Pack:
    """Meetings that a sweep takes side by side.

    Attributes:
        first, depth: The first of its rows, and how many it has: the most contacts of a meeting.
        count: Its meetings.
    """

    first: int
    depth: int
    count: int


@wp.struct
class Sides:
    """The two blocks of a meeting in a pack."""

    a: int
    b: int


@wp.struct
class Laid:
    """The blocks of a launch, and what is kept of their contacts.

    Attributes:
        sizes: A row a lane: BLOCK_COUNT, JOINT_COUNT.
        scale: Half diagonal of the smallest block [m], shape [lane].
        friction: Coulomb friction coefficient of contacts that no joint declares, shape [lane].
        solids: The blocks and the ground, shape [lane, block].
        corners: In the axes of the blocks, from their centres [m], shape [lane, corner].
        spots: The same where the blocks are, likewise.
        faces, rings, lines, edges, spans: Of all blocks, block by block.
        links: Shape [lane, joint].
        joined: Shape [lane, joint].
        places: Where the blocks and the ground are, shape [lane, block].
        hefts: Their inverse masses there, likewise.
        moves: Their velocities, likewise.
        pairs: Two lists of pairs, one behind the other, shape [lane, 2 pairs].
        contacts, impulses, marks: Two lists of contacts, likewise, shape [lane, 2 contacts].
        packs: What a sweep takes side by side, see packing.py, shape [lane, pack].
        sides: The blocks of their places, shape [lane, WIDTH pack].
        couples, rows, order: Their numbers, those of their contacts and places of these in the
            list, see there.
        couple, row: A meeting and a contact that are being written there, shape [lane].
        colours, open: Of each block those of its meetings, and of each colour its last pack.
        weighted: Velocities of each block, and none after them, shape [lane, block + 2].
        scratch: Corners of polygons that are being cut, twice the most that
            two faces have in common, shape [lane, corner].
    """

    sizes: wp.array2d(dtype=int)
    scale: wp.array(dtype=real)
    friction: wp.array(dtype=real)
    solids: wp.array2d(dtype=Solid)
    corners: wp.array2d(dtype=Vector)
    spots: wp.array2d(dtype=Vector)
    faces: wp.array2d(dtype=Face)
    rings: wp.array2d(dtype=int)
    lines: wp.array2d(dtype=Vector)
    edges: wp.array2d(dtype=Edge)
    spans: wp.array2d(dtype=Span)
    links: wp.array2d(dtype=Link)
    joined: wp.array2d(dtype=Joined)
    places: wp.array2d(dtype=Place)
    hefts: wp.array2d(dtype=Heft)
    moves: wp.array2d(dtype=Move)
    pairs: wp.array2d(dtype=Pair)
    contacts: wp.array2d(dtype=Contact)
    impulses: wp.array2d(dtype=Impulse)
    marks: wp.array2d(dtype=Mark)
    packs: wp.array2d(dtype=Pack)
    sides: wp.array2d(dtype=Sides)
    couples: wp.array2d(dtype=real)
    rows: wp.array2d(dtype=real)
    couple: wp.array(dtype=Couple)
    row: wp.array(dtype=Row)
    order: wp.array2d(dtype=int)
    colours: wp.array2d(dtype=wp.int64)
    open: wp.array2d(dtype=int)
    weighted: wp.array2d(dtype=Weighted)
    scratch: wp.array2d(dtype=Vector)


@wp.struct
class Met:
    """How two bodies meet.

    Attributes:
        how: `NONE` where they do not; 0 on a face of the first one, 1 on one of the second, 2 along
            an edge of each.
        own, other: That face and the one opposite to it, or the edges of the first and the second.
        gap: Distance along the normal [m].
        normal: From the second body into the first.
    """

    how: int
    own: int
    other: int
    gap: real
    normal: Vector


@wp.struct
class Step:
    """The step that contacts are found for.

    Attributes:
        half: Where its list of contacts begins.
        old: Where that of the last step begins.
        live: 1 in the run, 0 in a solve before it.
        time: Its start [s].
        dt: Its length [s].
        gravity: [m/s^2].
        total: Contacts found so far.
        packs, rows: What a sweep takes, see packing.py.
        full: 1 where there is no room for all, else 0.
    """

    half: int
    old: int
    live: int
    time: real
    dt: real
    gravity: real
    total: int
    packs: int
    rows: int
    full: int


@wp.struct
class Spot:
    """A contact that has been found.

    Attributes:
        a, b: Its bodies.
        normal: From the second into the first.
        at: Where it is [m].
        gap: [m].
        friction: Coulomb friction coefficient.
    """

    a: int
    b: int
    normal: Vector
    at: Vector
    gap: real
    friction: real


@wp.struct
class Known:
    """What a contact carried in the last step, as a vector [N s], and what it was; -1 of none."""

    place: int
    n: real
    drag: Vector


@wp.func
def normal_of(laid: Laid, lane: int, k: int, face: int) -> Vector:
    """Outward normal of a face of a body, where it is."""
    return times(laid.places[lane, k].r, laid.faces[lane, laid.solids[lane, k].face + face].normal)


@wp.func
def level_of(laid: Laid, lane: int, k: int, face: int, normal: Vector) -> real:
    """Distance of the plane of a face of a body from the origin, along its normal [m]."""
    level = laid.faces[lane, laid.solids[lane, k].face + face].level
    return inner(normal, laid.places[lane, k].at) + level


@wp.func
def lowest(laid: Laid, lane: int, k: int, normal: Vector) -> real:
    """The lowest corner of a body along a normal [m]."""
    one = laid.solids[lane, k]
    found = -BELOW
    for i in range(one.corners):
        found = smaller(inner(normal, laid.spots[lane, one.corner + i]), found)
    return found


@wp.func
def ring_corner(laid: Laid, lane: int, k: int, face: int, place: int) -> Vector:
    """A corner of a face of a body, where it is [m]."""
    one = laid.solids[lane, k]
    ring = laid.faces[lane, one.face + face].ring
    return laid.spots[lane, one.corner + laid.rings[lane, ring + place]]


@wp.func
def ring_count(laid: Laid, lane: int, k: int, face: int) -> int:
    """How many corners a face of a body has."""
    return laid.faces[lane, laid.solids[lane, k].face + face].corners


@wp.func
def lowest_of_face(laid: Laid, lane: int, k: int, face: int, normal: Vector) -> real:
    """The lowest corner of a face of a body along a normal [m]; of the ground none."""
    found = -BELOW
    for i in range(ring_count(laid, lane, k, face)):
        found = smaller(inner(normal, ring_corner(laid, lane, k, face, i)), found)
    return found


@wp.func
def opposite_face(laid: Laid, lane: int, k: int, normal: Vector) -> int:
    """The face of a body that faces a normal most."""
    one = laid.solids[lane, k]
    own = wp.transpose(laid.places[lane, k].r) * normal
    found, least = int(0), -BELOW
    for face in range(one.faces):
        along = inner(own, laid.faces[lane, one.face + face].normal)
        if along < least:
            found = face
            least = along
    return found


@wp.func
def farthest_face(laid: Laid, lane: int, k: int, other: int, so_far: Met, how: int) -> Met:
    """The face of a body from which another one is farthest, if farther than found so far."""
    found = so_far
    for face in range(laid.solids[lane, k].faces):
        n = normal_of(laid, lane, k, face)
        gap = lowest(laid, lane, other, n) - level_of(laid, lane, k, face, n)
        if gap > found.gap:
            found = Met(how, face, 0, gap, wp.where(how == 0, -n, n))
    return found


@wp.func
def edge_along(laid: Laid, lane: int, k: int, line: int, down: Vector) -> int:
    """The edge of a direction of a body that is lowest along a normal."""
    one = laid.solids[lane, k]
    found, least = int(0), -BELOW
    for i in range(one.edges):
        edge = laid.edges[lane, one.edge + i]
        if edge.line == line:
            level = inner(down, laid.spots[lane, one.corner + edge.start])
            if level < least:
                found = i
                least = level
    return found


@wp.func
def crossing(laid: Laid, lane: int, a: int, b: int, so_far: Met) -> Met:
    """The two directions of edges along which two blocks are farther apart than found so far."""
    one, two = laid.solids[lane, a], laid.solids[lane, b]
    found = so_far
    away = laid.places[lane, a].at - laid.places[lane, b].at
    least = fused(PLAIN, laid.scale[lane], so_far.gap)
    for i in range(one.lines):
        e = times(laid.places[lane, a].r, laid.lines[lane, one.line + i])
        for j in range(two.lines):
            n = cross(e, times(laid.places[lane, b].r, laid.lines[lane, two.line + j]))
            square = inner(n, n)
            if square > ACROSS * ACROSS:
                n = (sign_of(inner(n, away)) / wp.sqrt(square)) * n
                gap = lowest(laid, lane, a, n) + lowest(laid, lane, b, -n)
                if gap > least:
                    least = gap
                    found = Met(2, i, j, gap, n)
    return found


@wp.func
def meet(laid: Laid, lane: int, a: int, b: int, range_: real) -> Met:
    """How two blocks meet anywhere; nothing where they are farther apart than a range [m]."""
    found = Met(NONE, 0, 0, -NEVER, Vector())
    found = farthest_face(laid, lane, b, a, found, 1)
    if laid.solids[lane, b].lines > 0 and found.gap <= range_:
        # Of two faces that tell the same, that of the second block counts.
        ahead = Met(
            1, found.own, 0, fused(MERGED * MERGED, laid.scale[lane], found.gap), found.normal
        )
        first = farthest_face(laid, lane, a, b, ahead, 0)
        if first.how == 0:
            found = first
        if found.gap <= range_:
            found = crossing(laid, lane, a, b, found)
    if found.gap > range_:
        found.how = NONE
    elif found.how == 2:
        line_a = int(found.own)
        line_b = int(found.other)
        found.own = edge_along(laid, lane, a, line_a, found.normal)
        found.other = edge_along(laid, lane, b, line_b, -found.normal)
    elif found.how == 0:
        found.other = opposite_face(laid, lane, b, -found.normal)
    else:
        found.other = opposite_face(laid, lane, a, found.normal)
    return found


@wp.func
def meet_joint(laid: Laid, lane: int, link: Link) -> Met:
    """How two blocks meet at their joint; nothing where its faces no longer face each other."""
    na, nb = (
        normal_of(laid, lane, link.a, link.face_a),
        normal_of(laid, lane, link.b, link.face_b),
    )
    gap_b = lowest_of_face(laid, lane, link.a, link.face_a, nb) - level_of(
        laid, lane, link.b, link.face_b, nb
    )
    found = Met(1, link.face_b, link.face_a, gap_b, nb)
    if laid.solids[lane, link.b].lines > 0:
        gap_a = lowest_of_face(laid, lane, link.b, link.face_b, na) - level_of(
            laid, lane, link.a, link.face_a, na
        )
        if gap_a > fused(MERGED * MERGED, laid.scale[lane], gap_b):
            found = Met(0, link.face_a, link.face_b, gap_a, -na)
    if inner(na, nb) > -FACES:
        found.how = NONE
    return found


@wp.func
def cut(laid: Laid, lane: int, k: int, face: int, other: int, facing: int, rim: real):
    """What of a face of one body lies above a face of another one.

    Args:
        laid: Where the bodies are.
        lane: The lane.
        k, face: The body and its face above which it lies.
        other, facing: The other body and its face, that is cut.
        rim: How far inside the edges of the former it is cut [m].

    Returns:
        Where the corners of the polygon begin in `scratch`, and how many there are.
    """
    count = ring_count(laid, lane, other, facing)
    start, room = int(0), laid.scratch.shape[1] // 2
    for i in range(count):
        laid.scratch[lane, i] = ring_corner(laid, lane, other, facing, i)
    sides = ring_count(laid, lane, k, face)
    n = normal_of(laid, lane, k, face)
    for j in range(sides):
        here = ring_corner(laid, lane, k, face, j)
        there = ring_corner(laid, lane, k, face, wp.where(j + 1 < sides, j + 1, 0))
        inwards = cross(n, there - here)
        inwards = (real(1.0) / wp.sqrt(inner(inwards, inwards))) * inwards
        edge = inner(inwards, here) + rim
        into = room - start
        kept = int(0)
        if count > 0:
            last = laid.scratch[lane, start + count - 1]
            before = inner(inwards, last) - edge
            for i in range(count):
                point = laid.scratch[lane, start + i]
                now = inner(inwards, point) - edge
                if (now >= real(0.0)) != (before >= real(0.0)) and kept < room:
                    part = before / (before - now)
                    laid.scratch[lane, into + kept] = last + part * (point - last)
                    kept += 1
                if now >= real(0.0) and kept < room:
                    laid.scratch[lane, into + kept] = point
                    kept += 1
                last = point
                before = now
        count = kept
        start = into
    return start, count


@wp.func
def take_known(laid: Laid, lane: int, step: Step, first: int, count: int, spot: Vector) -> Known:
    """The contact of the last step nearest to a place in the axes of the first body, if near.

    It is taken once.
    """
    found = Known(NONE, real(0.0), Vector())
    least = SAME * laid.scale[lane]
    least = least * least
    for i in range(count):
        place = step.old + first + i
        away = laid.marks[lane, place].spot - spot
        square = inner(away, away)
        if square < least:
            least = square
            found.place = place
    if found.place != NONE:
        held = laid.impulses[lane, found.place]
        at = laid.contacts[lane, found.place]
        found.n = held.n
        found.drag = held.t * at.t + held.s * at.s
        laid.marks[lane, found.place].spot = Vector(NEVER, NEVER, NEVER)
    return found


@wp.func
def add_contact(laid: Laid, lane: int, spot: Spot, mark: Mark, was: Known, step: wp.ref[Step]):
    """Adds a contact to the list of a step, with the impulses of the last one as a guess."""
    room = laid.contacts.shape[1] // 2
    if step.total >= room:
        step.full = 1
        return
    place = step.half + step.total
    at = Contact()
    at.a = spot.a
    at.b = spot.b
    at.n = spot.normal
    at.t = tangent_of(spot.normal)
    at.s = cross(at.n, at.t)
    at.ra = spot.at - laid.places[lane, spot.a].at
    at.rb = spot.at - laid.places[lane, spot.b].at
    at.friction = spot.friction
    at.closing = larger(spot.gap, real(0.0)) / step.dt
    held = Impulse()
    held.n = was.n
    held.t = inner(at.t, was.drag)
    held.s = inner(at.s, was.drag)
    laid.contacts[lane, place] = at
    laid.impulses[lane, place] = held
    laid.marks[lane, place] = mark
    step.total += 1


@wp.func
def crossing_spot(laid: Laid, lane: int, spot: Spot, met: Met) -> Spot:
    """Where two edges that cross are nearest to each other: on that of the first block."""
    found = spot
    one, two = laid.solids[lane, spot.a], laid.solids[lane, spot.b]
    own, other = laid.edges[lane, one.edge + met.own], laid.edges[lane, two.edge + met.other]
    p, q = (
        laid.spots[lane, one.corner + own.start],
        laid.spots[lane, two.corner + other.start],
    )
    e = laid.spots[lane, one.corner + own.stop] - p
    # The plane of the other edge and the normal cuts this edge there.
    across = cross(laid.spots[lane, two.corner + other.stop] - q, met.normal)
    part = inner(across, q - p) / inner(across, e)
    found.at = p + smaller(larger(part, real(0.0)), real(1.0)) * e
    return found


@wp.func
def own_spot(laid: Laid, lane: int, k: int, at: Vector) -> Vector:
    """A place in the axes of a body [m]."""
    return wp.transpose(laid.places[lane, k].r) * (at - laid.places[lane, k].at)


@wp.func
def is_new(laid: Laid, lane: int, start: int, i: int, count: int) -> bool:
    """Whether a corner of a polygon is none that came before."""
    least = MERGED * laid.scale[lane]
    away = laid.scratch[lane, start + i] - laid.scratch[lane, start + wp.max(i - 1, 0)]
    round_ = laid.scratch[lane, start + i] - laid.scratch[lane, start]
    differs = inner(away, away) > least * least or i == 0
    closes = i > 0 and i == count - 1 and inner(round_, round_) <= least * least
    return differs and not closes


@wp.func
def slip_of_joint(laid: Laid, lane: int, old: int, joined: Joined) -> Vector:
    """Velocity with which a joint slid in the last step, as its contacts bore [m/s]."""
    total, found = real(0.0), Vector()
    for i in range(joined.count):
        at = laid.contacts[lane, old + joined.first + i]
        n = laid.impulses[lane, old + joined.first + i].n
        w = relative(at, laid.moves[lane, at.a], laid.moves[lane, at.b])
        found = found + n * (w - inner(at.n, w) * at.n)
        total = total + n
    return wp.where(total > real(0.0), (real(1.0) / larger(total, TINY)) * found, Vector())


@wp.func
def has_left(laid: Laid, lane: int, k: int, slide: Vector) -> bool:
    """Whether a block has slid so far that its largest joint is nowhere over where it was.

    A convex polygon has no point in common with itself moved along its plane once it has moved
    across one of its edges by its width there (separating axes).

    Args:
        laid: Where the bodies are.
        lane: The lane.
        k: The body; what is fixed leaves nothing.
        slide: How far it has slid along another body [m].
    """
    one = laid.solids[lane, k]
    own = wp.transpose(laid.places[lane, k].r) * slide
    found = bool(False)
    for i in range(one.spans):
        span = laid.spans[lane, one.span + i]
        found = found or size(inner(own, span.across)) > span.width
    return found
