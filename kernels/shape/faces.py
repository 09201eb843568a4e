"""Overlap of the faces of two blocks in space, and its corners.

Both faces are rectangles. The lower one, a top face, spans |x| <= a, |y| <= b around the origin of
its own axes, with z its normal. The upper one, a bottom face, has in these axes the middle o and
the directions d and e of its width and depth, with half lengths au and bu. The overlap is a polygon
in the plan of the lower face, with at most eight corners. Each corner has one of sixteen *slots*,
which identifies a contact from step to step:

    0 to 3    a corner of the upper face over the lower one: bit 1 its side along d, bit 2 along e;
    4 to 11   an end of what the lower face leaves of an edge of the upper one, where it cuts it:
              4 + 2 edge + end; edges 0 and 1 run along d, at -e and +e, 2 and 3 along e, at -d, +d;
    12 to 15  a corner of the lower face under the upper one, bits as before, along x and y.

The gap is the height of the upper face above the lower one at a corner. The lower face counts as
larger by a part SAME, so that faces with coinciding edges share the corners of the upper face.
"""

import warp as wp

SLOTS = 16
SAME = real(1.0e-6)
"""Part of a face by which another one may stick out and still count as inside."""
UPPER = 4
"""Number of the slots of the upper face's own corners, the first ones."""
ALONG_DEPTH = 8
"""First of the slots on the upper face's edges along its depth."""
LOWER = 12
"""First of the slots of the corners of the lower face."""
STEEPEST = real(1.0e-3)
"""Least cosine of a face or an edge to the lower face for which slopes still grow."""
PARALLEL = by_precision(1.0e-4, 1.0e-3)
"""Angle [rad] up to which faces count as parallel, and all of their contacts have one normal: a
face that slides cannot keep contacts of several. A force is off by this part at most."""


@wp.func
def side(bit: int) -> real:
    """-1 if a bit is not set, else 1."""
    return wp.where(bit == 0, real(-1.0), real(1.0))


@wp.func
def mirror_slot(slot: int, x: int, y: int) -> int:
    """Slot of the same corner in the mirror image of a pair of faces.

    Args:
        slot: Slot.
        x: 1 if the image is mirrored along x, else 0.
        y: The same along y.
    """
    if slot < 4:
        return slot ^ x ^ (2 * y)
    if slot >= 12:
        return 12 + ((slot - 12) ^ x ^ (2 * y))
    edge = (slot - 4) // 2
    end = (slot - 4) % 2
    if edge < 2:
        return 4 + 2 * (edge ^ y) + (end ^ x)
    return 4 + 2 * (2 + ((edge - 2) ^ x)) + (end ^ y)


@wp.func
def clip_line(place: real, run: real, bound: real):
    """Ends in t of the part of a line place + t run, -1 <= t <= 1, that lies within a bound."""
    along = wp.where(size(run) < TINY, TINY, run)
    first = (-bound - place) / along
    last = (bound - place) / along
    return larger(smaller(first, last), real(-1.0)), smaller(larger(first, last), real(1.0))


@wp.struct
class Faces:
    """Two faces, in the axes of the lower one.

    Attributes:
        ox, oy, oz: Middle of the upper face from that of the lower one [m].
        dx, dy, dz: Direction of the upper face's width.
        ex, ey, ez: Direction of its depth.
        au, bu: Half width and half depth of the upper face [m].
        a, b: Half width and half depth of the lower face [m].
    """

    ox: real
    oy: real
    oz: real
    dx: real
    dy: real
    dz: real
    ex: real
    ey: real
    ez: real
    au: real
    bu: real
    a: real
    b: real


@wp.func
def upper_corner(slot: int, f: Faces):
    """A corner of the upper face; see `corner`."""
    one, d, e = real(1.0), side(slot & 1) * f.au, side(slot & 2) * f.bu
    x, y, gap = f.ox + d * f.dx + e * f.ex, f.oy + d * f.dy + e * f.ey, f.oz + d * f.dz + e * f.ez
    there = size(x) <= f.a * (one + SAME) and size(y) <= f.b * (one + SAME)
    return x, y, gap, there


@wp.func
def edge_corner(slot: int, f: Faces):
    """An end of what the lower face leaves of an edge of the upper one; see `corner`."""
    one, edge = real(1.0), (slot - 4) // 2
    far, wide, deep = side(edge & 1), f.a * (one + SAME), f.b * (one + SAME)
    run_x = wp.where(edge < 2, f.au * f.dx, f.bu * f.ex)
    run_y = wp.where(edge < 2, f.au * f.dy, f.bu * f.ey)
    run_z = wp.where(edge < 2, f.au * f.dz, f.bu * f.ez)
    x = f.ox + far * wp.where(edge < 2, f.bu * f.ex, f.au * f.dx)
    y = f.oy + far * wp.where(edge < 2, f.bu * f.ey, f.au * f.dy)
    z = f.oz + far * wp.where(edge < 2, f.bu * f.ez, f.au * f.dz)
    x0, x1 = clip_line(x, run_x, wide)
    y0, y1 = clip_line(y, run_y, deep)
    first, last = larger(x0, y0), smaller(x1, y1)
    at = wp.where((slot - 4) % 2 == 0, first, last)
    return x + at * run_x, y + at * run_y, z + at * run_z, first < last and size(at) < one


@wp.func
def lower_corner(slot: int, f: Faces):
    """A corner of the lower face under the upper one; see `corner`."""
    one = real(1.0)
    x, y = side((slot - 12) & 1) * f.a, side((slot - 12) & 2) * f.b
    turned = f.dx * f.ey - f.dy * f.ex
    up = turned > real(0.0)
    over = wp.where(up, turned, one)
    u = ((x - f.ox) * f.ey - (y - f.oy) * f.ex) / over
    v = ((y - f.oy) * f.dx - (x - f.ox) * f.dy) / over
    inside = size(u) < f.au * (one - SAME) and size(v) < f.bu * (one - SAME)
    return (
        f.ox + u * f.dx + v * f.ex, f.oy + u * f.dy + v * f.ey, f.oz + u * f.dz + v * f.ez,
        up and inside,
    )  # fmt: skip


@wp.func
def corner(slot: int, f: Faces):
    """One corner of the overlap of two faces, by its slot.

    Returns:
        The point on the upper face, whose z is the gap [m], and whether there is such a corner.
    """
    if slot < 4:
        x, y, gap, there = upper_corner(slot, f)
        return x, y, gap, there
    if slot < 12:
        x, y, gap, there = edge_corner(slot, f)
        return x, y, gap, there
    x, y, gap, there = lower_corner(slot, f)
    return x, y, gap, there


@wp.func
def crosses(slot: int, place: real, along: real, half: real) -> bool:
    """Whether an edge of the upper face crosses one of the lower face at a slot.

    Edges that are less than 45 degrees apart count as one.

    Args:
        slot: The slot.
        place: Where it is across the lower edge, from the middle of that face [m].
        along: Cosine of the angle between the edges.
        half: Half length of the lower face across its edge [m].
    """
    ends = size(place) > half * (real(1.0) + HALF * SAME)
    return slot >= UPPER and slot < LOWER and ends and along * along < HALF


@wp.struct
class Slopes:
    """The normal (x, y, 1) of a contact of two faces, and how well it tells where that is.

    Attributes:
        x, y: Slopes.
        reach: See `lowest_slopes` [m].
    """

    x: real
    y: real
    reach: real


@wp.func
def slopes_of(gx: real, gy: real, x: real, y: real, f: Faces) -> Slopes:
    """Slopes (x, y) of a normal, of faces that part at the slopes (gx, gy), with their reach."""
    ux, uy = gx - x, gy - y
    lower = dot(f.a, f.b, size(x), size(y))
    upper = dot(f.au, f.bu, size(dot(ux, uy, f.dx, f.dy)), size(dot(ux, uy, f.ex, f.ey)))
    return Slopes(x, y, lower + upper + dot(ux, uy, f.ox, f.oy))


@wp.func
def nearer(one: Slopes, other: Slopes) -> Slopes:
    """That of two normals which reaches less far; the first if both do alike."""
    less = other.reach < one.reach
    return Slopes(
        wp.where(less, other.x, one.x), wp.where(less, other.y, one.y),
        wp.where(less, other.reach, one.reach),
    )  # fmt: skip


@wp.func
def slope_across(run: real, rise: real) -> real:
    """Slope of a normal across an edge that rises so much over a run."""
    return -rise / (sign_of(run) * larger(size(run), STEEPEST))


@wp.func
def lowest_slopes(f: Faces) -> Slopes:
    """The normal (x, y, 1) of the contact where the upper face is lowest over the lower one.

    A corner of the upper face touches along the lower normal (0, 0, 1), a corner of the lower face
    along the upper one, (g, 1), and edges that cross along the normal of both. The lowest corner of
    the overlap lies farthest along g. How far, is the least of the bounds

        h(q) + H(g - q),    h(q) = max q . r in the lower face,    H likewise in the upper one,

    and the q that gives the least is what the edges of the lower face hold of g: (q, 1) is the
    normal. It is 0, g, or that of edges which cross and run in other directions.
    """
    zero = real(0.0)
    over = real(1.0) / larger(fused_less(f.dy, f.ex, f.dx * f.ey), STEEPEST)
    gx = over * fused_less(f.dz, f.ey, f.dy * f.ez)
    gy = over * fused_less(f.dx, f.ez, f.dz * f.ex)
    # Of two edges of the upper face the one that runs rather across.
    aside = size(f.dx) < size(f.dy)
    run_x, rise_x = wp.where(aside, f.ex, f.dx), wp.where(aside, f.ez, f.dz)
    run_y, rise_y = wp.where(aside, f.dy, f.ey), wp.where(aside, f.dz, f.ez)
    found = nearer(slopes_of(gx, gy, zero, zero, f), slopes_of(gx, gy, gx, gy, f))
    found = nearer(found, slopes_of(gx, gy, slope_across(run_x, rise_x), zero, f))
    return nearer(found, slopes_of(gx, gy, zero, slope_across(run_y, rise_y), f))
