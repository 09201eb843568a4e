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

Where CHAINS is true the blocks are bodies on contact points. An upper block's face is then the
edge of its chain of corners that it stands on, or would fall on; a lower block's is its top. Both
may lie beside its centre, and the edge may be turned against the body: `foot` is what belongs to
that edge. What goes from edge to edge is in event/stack_body.py.
"""

import warp as wp

from warprock.kernels.vectors import Matrix
from warprock.kernels.vectors import Vector as Three

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


@wp.struct
class Blocks:
    """What the blocks of one lane are; of bodies half sizes are those of the edge, and its depth.

    Of bodies, too, `foot`: rotation against what is below at which the edge lies flat [rad], with
    its sine and cosine; the middle of the edge, to +x of the centre along the edge [m]. `rolled`:
    where that middle comes to lie if the block rolls on from where it stood at first [m]. `ahead`
    and `behind`: how far it turns from the edge to the next one to +x and to -x [rad], NEVER where
    there is none. `top`: half the width of the top, its middle to +x of the centre and its height
    above it [m].
    """

    half_height: Values
    half_width: Values
    inverse_mass: Values
    inverse_inertia: Values
    friction: Values
    if CHAINS:
        foot: Values
        foot_sine: Values
        foot_cosine: Values
        foot_middle: Values
        rolled: Values
        ahead: Values
        behind: Values
        top_half: Values
        top_middle: Values
        top_height: Values


@wp.struct
class Pose:
    """Where the blocks of one lane are, and which ends touch.

    `foot`: see `Blocks`; its sine and cosine are those of the rotation of the edge.
    """

    theta: Values
    sine: Values
    cosine: Values
    along: Values
    above: Values
    touch: Counts
    if CHAINS:
        foot: Values
        foot_sine: Values
        foot_cosine: Values


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
    """Sine and cosine of the lower face, and of the rotation of the upper one against it."""
    s = real(0.0)
    c = real(1.0)
    if k > 0:
        s = pose.sine[k - 1]
        c = pose.cosine[k - 1]
    if CHAINS:
        sd = pose.foot_sine[k] * c - pose.foot_cosine[k] * s
        cd = pose.foot_cosine[k] * c + pose.foot_sine[k] * s
    else:
        sd = pose.sine[k] * c - pose.cosine[k] * s
        cd = pose.cosine[k] * c + pose.sine[k] * s
    return s, c, sd, cd


@wp.func
def with_foot(blocks: Blocks, pose: Pose, k: int) -> Pose:
    """A pose with the edge that block k stands on turned as the block is."""
    new = pose
    if CHAINS:
        s = pose.sine[k]
        c = pose.cosine[k]
        new.foot[k] = blocks.foot[k]
        new.foot_sine[k] = s * blocks.foot_cosine[k] - c * blocks.foot_sine[k]
        new.foot_cosine[k] = c * blocks.foot_cosine[k] + s * blocks.foot_sine[k]
    return new


@wp.func
def flat_rotation(blocks: Blocks, pose: Pose, k: int) -> real:
    """Rotation at which block k lies flat on what is below it [rad]."""
    theta = real(0.0)
    if k > 0:
        theta = pose.theta[k - 1]
    if CHAINS:
        theta = theta + blocks.foot[k]
    return theta


@wp.func
def turn_of(pose: Pose, k: int) -> real:
    """Rotation of the upper face of interface k against the lower one [rad]."""
    below = real(0.0)
    if k > 0:
        below = pose.theta[k - 1]
    turn = pose.theta[k] - below
    if CHAINS:
        turn = turn - pose.foot[k]
    return turn


@wp.func
def leaning(turn: real) -> int:
    """Ends of an interface that are nearest to the face below, both where it lies level.

    Args:
        turn: Rotation of the upper face against the lower one [rad].
    """
    zero = real(0.0)
    return wp.where(turn > zero, PLUS, wp.where(turn < zero, MINUS, CLOSED))


@wp.func
def ends_below(pose: Pose, k: int) -> int:
    """Ends of interface k that touch; of an open one those nearest to the face below.

    The place of an open interface is told by them: a fixed end would not do in a mirror.
    """
    return wp.where(pose.touch[k] == OPEN, leaning(turn_of(pose, k)), pose.touch[k])


@wp.func
def lower_face(blocks: Blocks, k: int):
    """Half width of the face that block k stands on, and half height of the body below [m]."""
    half_width = ENDLESS
    half_height = real(0.0)
    if k > 0:
        if CHAINS:
            half_width = blocks.top_half[k - 1]
            half_height = blocks.top_height[k - 1]
        else:
            half_width = blocks.half_width[k - 1]
            half_height = blocks.half_height[k - 1]
    return half_width, half_height


@wp.func
def face_middles(blocks: Blocks, k: int):
    """How far the middles of the faces of interface k lie to +x of the centres along them [m].

    Of the upper block, then of the lower one.
    """
    upper = real(0.0)
    lower = real(0.0)
    if CHAINS:
        upper = blocks.foot_middle[k]
        if k > 0:
            lower = blocks.top_middle[k - 1]
    return upper, lower


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
def from_centres(
    upper: real, lower: real, on: bool, sd: real, cd: real, xu: real, zu: real, xl: real, zl: real
):
    """Levers of `end_levers` from centres that lie beside the middles of their faces.

    Args:
        upper, lower: See `face_middles`.
        on: Whether the upper corner lies on the lower face.
        sd, cd: Sine and cosine of the rotation of the upper face against the lower one.
        xu, zu, xl, zl: Levers from above the middle of the upper face, from below that of the
            lower one [m].
    """
    return (
        xu + wp.where(on, upper * cd, upper),
        zu - wp.where(on, upper * sd, real(0.0)),
        xl + wp.where(on, lower, lower * cd),
        zl + wp.where(on, real(0.0), lower * sd),
    )


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
    if CHAINS:
        umid, lmid = face_middles(blocks, k)
        xu1, zu1, xl1, zl1 = from_centres(umid, lmid, on1, sd, cd, xu1, zu1, xl1, zl1)
        xu2, zu2, xl2, zl2 = from_centres(umid, lmid, on2, sd, cd, xu2, zu2, xl2, zl2)
    minus = pose.touch[k] == MINUS
    su = pose.sine[k]
    cu = pose.cosine[k]
    if CHAINS:
        su = pose.foot_sine[k]
        cu = pose.foot_cosine[k]
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


@wp.func(inline=False)
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
