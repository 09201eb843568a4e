"""Geometry of a stack of planar rigid blocks.

Block k stands on block k - 1, the lowest on the ground, an endless flat face. Rotations theta are
absolute and clockwise; a lever (x, z) of a block points to (x cos + z sin, z cos - x sin).
Interface k lies below block k. Where its upper block is to the lower one is told by (along,
above): the middle of the upper block's bottom face as seen from the middle of the lower block's
top face, in the lower block's frame. An interface has two ends, side = +1 and -1. What touches
there is the corner that lies further in: of the upper block on the lower one's face (*kind* ON),
or of the lower block under the upper one's face (UNDER).

Touch is a sum of ENDS: 1 where the end to +x touches, 2 where the end to -x does; 3 is a closed
interface. The place of a contact is one number, its *anchor*: the corner's coordinate on the face
it touches, or `along` of a closed interface. It changes by sliding alone.
"""

import warp as wp

OPEN = 0
PLUS = 1
MINUS = 2
CLOSED = 3

ENDLESS = real(1.0e30)
"""Half width of the ground [m]."""
ALIKE = real(1.0 + 1.0e-9)
"""Ratio by which a corner may lie outside a face and still count as on it."""

Values = wp.types.vector(length=BLOCKS, dtype=real)
"""One number a block, or an interface."""
Counts = wp.types.vector(length=BLOCKS, dtype=int)
"""One whole number a block, or an interface."""
Triples = wp.types.vector(length=3 * BLOCKS, dtype=real)
"""Three numbers a block: velocity (x, z, rotation); an interface: along it, at + and - end."""
Rows = wp.types.matrix(shape=(3 * BLOCKS, 3), dtype=real)
"""A matrix of 3 x 3 an interface."""
Three = wp.types.vector(length=3, dtype=real)
Matrix = wp.types.matrix(shape=(3, 3), dtype=real)


@wp.struct
class Blocks:
    """What the blocks of one lane are."""

    half_height: Values
    half_width: Values
    inverse_mass: Values
    inverse_inertia: Values
    friction: Values


@wp.struct
class Pose:
    """Where the blocks of one lane are, and which ends touch."""

    theta: Values
    sine: Values
    cosine: Values
    along: Values
    above: Values
    touch: Counts


@wp.func
def three_of(values: Triples, k: int) -> Three:
    """Three numbers of one block or interface."""
    return Three(values[3 * k], values[3 * k + 1], values[3 * k + 2])


@wp.func
def matrix_of(rows: Rows, k: int) -> Matrix:
    """The 3 x 3 matrix of one interface."""
    return Matrix(
        rows[3 * k, 0], rows[3 * k, 1], rows[3 * k, 2],
        rows[3 * k + 1, 0], rows[3 * k + 1, 1], rows[3 * k + 1, 2],
        rows[3 * k + 2, 0], rows[3 * k + 2, 1], rows[3 * k + 2, 2],
    )  # fmt: skip


@wp.func
def side_of(touch: int) -> real:
    """Side of the end that touches, the one to +x where both do."""
    return wp.where(touch == MINUS, real(-1.0), real(1.0))


@wp.func
def between(pose: Pose, k: int):
    """Sine and cosine of the lower block, and of the rotation of the upper against the lower."""
    s = real(0.0)
    c = real(1.0)
    if k > 0:
        s = pose.sine[k - 1]
        c = pose.cosine[k - 1]
    return s, c, pose.sine[k] * c - pose.cosine[k] * s, pose.cosine[k] * c + pose.sine[k] * s


@wp.func
def lower_face(blocks: Blocks, k: int):
    """Half width of the face that block k stands on, and half height of the body below [m]."""
    half_width = ENDLESS
    half_height = real(0.0)
    if k > 0:
        half_width = blocks.half_width[k - 1]
        half_height = blocks.half_height[k - 1]
    return half_width, half_height


@wp.func
def anchored(blocks: Blocks, pose: Pose, k: int, touch: int):
    """Anchor of interface k [m], some of its ends touching, and how it changes with slip.

    By +1 (kind ON, or closed) or -1 (kind UNDER) times the slip of the upper block.
    """
    one = real(1.0)
    _s, _c, sd, cd = between(pose, k)
    low, _height = lower_face(blocks, k)
    side = side_of(touch)
    corner = pose.along[k] + side * blocks.half_width[k] * cd
    on = side * corner <= ALIKE * low
    under = (side * low - pose.along[k]) * cd + pose.above[k] * sd
    place = wp.where(on, corner, under)
    return wp.where(touch == CLOSED, pose.along[k], place), wp.where(
        on or touch == CLOSED, one, -one
    )


@wp.func
def carried(blocks: Blocks, k: int, touch: int, anchor: real, rate: real, sd: real, cd: real):
    """Along and above of interface k from its anchor and the rotation across it."""
    low, _height = lower_face(blocks, k)
    side = side_of(touch)
    half_width = side * blocks.half_width[k]
    along = anchor - half_width * cd
    above = half_width * sd
    if rate < real(0.0):
        along = side * low - anchor * cd
        above = anchor * sd
    if touch == CLOSED:
        along = anchor
        above = real(0.0)
    return along, above


@wp.func
def upright_place(blocks: Blocks, k: int, touch: int, anchor: real, rate: real) -> real:
    """`along` of interface k if its upper block were turned flat about its corner [m]."""
    along, _above = carried(blocks, k, touch, anchor, rate, real(0.0), real(1.0))
    return along


@wp.func
def end_levers(
    side: real, lhalf_width: real, lhalf_height: real, half_width: real, half_height: real,
    along: real, above: real, sd: real, cd: real,
):  # fmt: skip
    """One end of an interface, in the frame of the face that is touched there.

    Args:
        side: +1 or -1.
        lhalf_width, lhalf_height: Half sizes of the lower block [m].
        half_width, half_height: Half sizes of the upper block [m].
        along, above: See the head of this file.
        sd: Sine of the rotation of the upper block against the lower.
        cd: Its cosine.

    Returns:
        Lever (two values) from the upper block's centre, from the lower one's; the gap [m];
        whether the upper corner lies on the lower face.
    """
    corner = along + side * half_width * cd
    on = side * corner <= ALIKE * lhalf_width
    xu = side * half_width * cd - half_height * sd
    zu = -half_height * cd - side * half_width * sd
    xl = corner
    zl = lhalf_height
    gap = above - side * half_width * sd
    if not on:
        reach = side * lhalf_width - along
        xu = reach * cd + above * sd
        zu = -half_height
        xl = side * lhalf_width * cd - lhalf_height * sd
        zl = lhalf_height * cd + side * lhalf_width * sd
        gap = above * cd - reach * sd
    return xu, zu, xl, zl, gap, on


@wp.func
def interface_rows(blocks: Blocks, pose: Pose, k: int):
    """Relative velocities at interface k from those of its blocks.

    Returns:
        Matrix of the upper block (rows: along the face, away from it at the + and the - end;
        columns: x, z, rotation), of the lower one, and the gaps at both ends [m].
    """
    sl, cl, sd, cd = between(pose, k)
    lhalf_width, lhalf_height = lower_face(blocks, k)
    half_width = blocks.half_width[k]
    half_height = blocks.half_height[k]
    along = pose.along[k]
    above = pose.above[k]
    xu1, zu1, xl1, zl1, gap1, on1 = end_levers(
        real(1.0), lhalf_width, lhalf_height, half_width, half_height, along, above, sd, cd
    )
    xu2, zu2, xl2, zl2, gap2, on2 = end_levers(
        real(-1.0), lhalf_width, lhalf_height, half_width, half_height, along, above, sd, cd
    )
    minus = pose.touch[k] == MINUS
    su = pose.sine[k]
    cu = pose.cosine[k]
    zu = wp.where(minus, zu2, zu1)
    zl = wp.where(minus, zl2, zl1)
    on = wp.where(minus, on2, on1)
    s = wp.where(on, sl, su)
    c = wp.where(on, cl, cu)
    s1 = wp.where(on1, sl, su)
    c1 = wp.where(on1, cl, cu)
    s2 = wp.where(on2, sl, su)
    c2 = wp.where(on2, cl, cu)
    upper = Matrix(c, -s, zu, s1, c1, -xu1, s2, c2, -xu2)
    lower = Matrix(-c, s, -zl, -s1, -c1, xl1, -s2, -c2, xl2)
    return upper, lower, gap1, gap2


@wp.func
def all_rows(blocks: Blocks, pose: Pose):
    """`interface_rows` of every interface: both matrices, and the gaps at both ends."""
    upper = Rows()
    lower = Rows()
    plus = Values()
    minus = Values()
    for k in range(BLOCKS):
        up, down, gap1, gap2 = interface_rows(blocks, pose, k)
        plus[k] = gap1
        minus[k] = gap2
        for i in range(3):
            for j in range(3):
                upper[3 * k + i, j] = up[i, j]
                if k > 0:
                    lower[3 * k + i, j] = down[i, j]
    return upper, lower, plus, minus
