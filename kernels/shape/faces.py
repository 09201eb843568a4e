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

from warprock.kernels.algebra.vectors import Vector

SLOTS = 16
SAME = real(1.0e-6)
"""Part of a face by which another one may stick out and still count as inside."""


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


@wp.func
def corner(slot: int, o: Vector, d: Vector, e: Vector, au: real, bu: real, a: real, b: real):
    """One corner of the overlap of two faces.

    Args:
        slot: Its slot.
        o: Middle of the upper face from that of the lower one, in its axes [m].
        d, e: Directions of the upper face's width and depth, in those axes.
        au, bu: Half width and half depth of the upper face [m].
        a, b: Half width and half depth of the lower face [m].

    Returns:
        The point on the upper face, whose z is the gap [m], and whether there is such a corner.
    """
    one, none = real(1.0), Vector(real(0.0), real(0.0), real(0.0))
    wide, deep = a * (one + SAME), b * (one + SAME)
    if slot < 4:
        point = o + side(slot & 1) * au * d + side(slot & 2) * bu * e
        return point, size(point[0]) <= wide and size(point[1]) <= deep
    if slot < 12:
        edge = (slot - 4) // 2
        middle = o + side(edge & 1) * wp.where(edge < 2, bu * e, au * d)
        run = wp.where(edge < 2, au * d, bu * e)
        x0, x1 = clip_line(middle[0], run[0], wide)
        y0, y1 = clip_line(middle[1], run[1], deep)
        first, last = larger(x0, y0), smaller(x1, y1)
        at = wp.where((slot - 4) % 2 == 0, first, last)
        return middle + at * run, first < last and size(at) < one
    x = side((slot - 12) & 1) * a
    y = side((slot - 12) & 2) * b
    turned = d[0] * e[1] - d[1] * e[0]
    if turned <= real(0.0):
        return none, False
    u = ((x - o[0]) * e[1] - (y - o[1]) * e[0]) / turned
    v = ((y - o[1]) * d[0] - (x - o[0]) * d[1]) / turned
    inside = size(u) < au * (one - SAME) and size(v) < bu * (one - SAME)
    return o + u * d + v * e, inside
