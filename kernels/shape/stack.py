"""Geometry of a stack of planar rigid blocks.

Block k stands on block k - 1, the lowest on the ground, an endless flat face. Rotations theta are
absolute and clockwise; a lever (x, z) of a block points to (x cos + z sin, z cos - x sin).
Interface k lies below block k. The place of block k is (along, above): the middle of its bottom
face as seen from the middle of the top face below it, in the frame of the lower block. An interface
has two ends, side = +1 and -1. The corner that lies further in touches there: that of the upper
block on the lower one's face (*kind* ON), or that of the lower block under the upper one's face
(UNDER).

`touch` is a sum of ends: 1 (PLUS) if the end to +x touches, 2 (MINUS) if the end to -x does; 3 is a
closed interface. The place of a contact is one number, its *anchor*: the coordinate of the corner
on the face it touches, or `along` of a closed interface. It changes only by sliding.

If CHAINS is true, the blocks are bodies on contact points. The upper face of an interface is then
one edge of a chain of corners: the edge on which the body lies, or on which it would fall. The
lower face is the top of the body below. Both faces may be off the centre of mass, and the edge may
be rotated relative to the body: the fields `foot...` describe that edge. event/stack/edges.py
changes it.
"""

import warp as wp

from warprock.kernels.algebra.vectors import Matrix
from warprock.kernels.algebra.vectors import Vector as Three

OPEN = 0
PLUS = 1
MINUS = 2
CLOSED = 3

ENDLESS = real(1.0e30)
"""Half width of the ground [m]."""
ALIKE = real(1.0 + 1.0e-9)
"""Distance by which a corner may lie outside a face and still count as on it, over the face."""

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
    """The blocks of one lane.

    Attributes:
        half_height, half_width: Half sizes of boxes; for bodies the depth of the edge below the
            centre of mass, and its half length [m].
        mass, inertia: [kg], [kg m^2].
        inverse_mass, inverse_inertia: [1/kg], [1/(kg m^2)].
        friction: Coefficient of friction at the interface below the block.
        foot: Rotation relative to the body below at which the edge lies flat [rad].
        foot_sine, foot_cosine: Of that rotation.
        foot_middle: How far the middle of the edge lies to +x of the centre along the edge [m].
        rolled: Place of that middle after the block has rolled on from its first place [m].
        ahead, behind: Turn from the edge to the next one to +x and to -x [rad]; NEVER at the last.
        edge: Row of the corners at which the edge begins, see shape/stack_body.py.
        top_half, top_middle, top_height: Half width of the top; distance of its middle from the
            centre to +x, and upwards [m].
    """

    half_height: Values
    half_width: Values
    mass: Values
    inertia: Values
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
        edge: Counts
        top_half: Values
        top_middle: Values
        top_height: Values


@wp.struct
class Pose:
    """Rotations and places of the blocks of one lane.

    Attributes:
        theta: Rotations [rad].
        sine, cosine: Of them.
        along, above: Places [m]; see the head of this file.
        touch: Ends that touch.
        foot: See `Blocks`.
        foot_sine, foot_cosine: Of the rotations of the edges.
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


@wp.struct
class Anchor:
    """The place of a contact of an interface.

    Attributes:
        place: Coordinate of the corner on the face that it touches [m]; `along` if closed.
        rate: Change of the place per slip of the upper block: 1 (kind ON, or closed) or -1 (kind
            UNDER).
    """

    place: real
    rate: real


@wp.struct
class Faces:
    """The two faces of an interface, in the frame of the lower one; all lengths in m.

    Attributes:
        lower_width, lower_height: Half width of the lower face, and its height above the centre of
            its block.
        upper_width, upper_height: Half width of the upper face, and the height of the centre of its
            block above it.
        along, above: See the head of this file.
        sine, cosine: Of the rotation of the upper face relative to the lower one.
        lower_middle, upper_middle: See `face_middles`.
    """

    lower_width: real
    lower_height: real
    upper_width: real
    upper_height: real
    along: real
    above: real
    sine: real
    cosine: real
    if CHAINS:
        lower_middle: real
        upper_middle: real


@wp.struct
class End:
    """One end of an interface, in the frame of the touched face; all lengths in m.

    Attributes:
        upper_x, upper_z: Lever from the centre of the upper block.
        lower_x, lower_z: Lever from the centre of the lower block.
        gap: Distance between corner and face.
        on: Whether the corner of the upper block touches the lower face (kind ON).
    """

    upper_x: real
    upper_z: real
    lower_x: real
    lower_z: real
    gap: real
    on: bool


@wp.struct
class Jacobian:
    """Relative velocities at all interfaces from the velocities of the blocks.

    Attributes:
        upper: The matrix of the upper block of every interface, see `interface_rows`.
        lower: That of the lower block; zero on the ground.
    """

    upper: Rows
    lower: Rows


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
    """Side of the end that touches; +1 if both do."""
    return wp.where(touch == MINUS, real(-1.0), real(1.0))


@wp.func
def face_below(pose: wp.ref[Pose], k: int):
    """Sine and cosine of the rotation of the lower face of interface k."""
    s = real(0.0)
    c = real(1.0)
    if k > 0:
        s = pose.sine[k - 1]
        c = pose.cosine[k - 1]
    return s, c


@wp.func
def face_above(pose: wp.ref[Pose], k: int):
    """Sine and cosine of the rotation of the upper face of interface k."""
    s = pose.sine[k]
    c = pose.cosine[k]
    if CHAINS:
        s = pose.foot_sine[k]
        c = pose.foot_cosine[k]
    return s, c


@wp.func
def turn_across(pose: wp.ref[Pose], k: int):
    """Sine and cosine of `turn_of`."""
    sl, cl = face_below(pose, k)
    su, cu = face_above(pose, k)
    return su * cl - cu * sl, cu * cl + su * sl


@wp.func
def turn_foot(blocks: wp.ref[Blocks], pose: wp.ref[Pose], k: int):
    """Sets sine and cosine of the edge of block k after a change of its rotation."""
    if CHAINS:
        s = pose.sine[k]
        c = pose.cosine[k]
        pose.foot[k] = blocks.foot[k]
        pose.foot_sine[k] = s * blocks.foot_cosine[k] - c * blocks.foot_sine[k]
        pose.foot_cosine[k] = c * blocks.foot_cosine[k] + s * blocks.foot_sine[k]


@wp.func
def turn_block(blocks: wp.ref[Blocks], pose: wp.ref[Pose], k: int, theta: real):
    """Sets the rotation of block k [rad]."""
    pose.theta[k] = theta
    pose.sine[k] = sine(theta)
    pose.cosine[k] = cosine(theta)
    turn_foot(blocks, pose, k)


@wp.func
def flat_rotation(blocks: wp.ref[Blocks], pose: wp.ref[Pose], k: int) -> real:
    """Rotation at which block k lies flat on the body below [rad]."""
    theta = real(0.0)
    if k > 0:
        theta = pose.theta[k - 1]
    if CHAINS:
        theta = theta + blocks.foot[k]
    return theta


@wp.func
def turn_of(pose: wp.ref[Pose], k: int) -> real:
    """Rotation of the upper face of interface k relative to the lower one [rad]."""
    below = real(0.0)
    if k > 0:
        below = pose.theta[k - 1]
    turn = pose.theta[k] - below
    if CHAINS:
        turn = turn - pose.foot[k]
    return turn


@wp.func
def nearest_ends(turn: real) -> int:
    """Ends of an interface that are nearest to the face below; both if it is level.

    Args:
        turn: Rotation of the upper face relative to the lower one [rad].
    """
    zero = real(0.0)
    return wp.where(turn > zero, PLUS, wp.where(turn < zero, MINUS, CLOSED))


@wp.func
def ends_below(pose: wp.ref[Pose], k: int) -> int:
    """Ends of interface k that touch; if none does, those nearest to the face below.

    They give the place of an open interface: with a fixed end a mirrored scene would differ.
    """
    return wp.where(pose.touch[k] == OPEN, nearest_ends(turn_of(pose, k)), pose.touch[k])


@wp.func
def lower_face(blocks: wp.ref[Blocks], k: int):
    """Half width of the face below block k, and its height above the centre of its block [m]."""
    half_width = ENDLESS
    height = real(0.0)
    if k > 0:
        if CHAINS:
            half_width = blocks.top_half[k - 1]
            height = blocks.top_height[k - 1]
        else:
            half_width = blocks.half_width[k - 1]
            height = blocks.half_height[k - 1]
    return half_width, height


@wp.func
def face_middles(blocks: wp.ref[Blocks], k: int):
    """Distances from the centres to the middles of the faces of interface k, to +x along them [m].

    Those of the upper and of the lower face.
    """
    upper = real(0.0)
    lower = real(0.0)
    if CHAINS:
        upper = blocks.foot_middle[k]
        if k > 0:
            lower = blocks.top_middle[k - 1]
    return upper, lower


@wp.func
def find_anchor(blocks: wp.ref[Blocks], pose: wp.ref[Pose], k: int, touch: int) -> Anchor:
    """The anchor of interface k if these ends of it touch."""
    one = real(1.0)
    sd, cd = turn_across(pose, k)
    low, _height = lower_face(blocks, k)
    side = side_of(touch)
    corner = pose.along[k] + side * blocks.half_width[k] * cd
    on = side * corner <= ALIKE * low
    under = (side * low - pose.along[k]) * cd + pose.above[k] * sd
    place = wp.where(on, corner, under)
    return Anchor(
        wp.where(touch == CLOSED, pose.along[k], place),
        wp.where(on or touch == CLOSED, one, -one),
    )


@wp.func
def place_at(blocks: wp.ref[Blocks], k: int, touch: int, anchor: Anchor, sd: real, cd: real):
    """`along` and `above` of interface k, from its anchor and sine and cosine of `turn_of`."""
    low, _height = lower_face(blocks, k)
    side = side_of(touch)
    half_width = side * blocks.half_width[k]
    along = anchor.place - half_width * cd
    above = half_width * sd
    if anchor.rate < real(0.0):
        along = side * low - anchor.place * cd
        above = anchor.place * sd
    if touch == CLOSED:
        along = anchor.place
        above = real(0.0)
    return along, above


@wp.func
def place_block(blocks: wp.ref[Blocks], pose: wp.ref[Pose], k: int, touch: int, anchor: Anchor):
    """Moves block k, whose rotation is set, to the place given by an anchor of its contact."""
    sd, cd = turn_across(pose, k)
    along, above = place_at(blocks, k, touch, anchor, sd, cd)
    pose.along[k] = along
    pose.above[k] = above


@wp.func
def upright_place(blocks: wp.ref[Blocks], k: int, touch: int, anchor: Anchor) -> real:
    """`along` of interface k after a rotation of its upper block about its corner to flat [m]."""
    along, _above = place_at(blocks, k, touch, anchor, real(0.0), real(1.0))
    return along


@wp.func
def slide_place(blocks: wp.ref[Blocks], pose: wp.ref[Pose], k: int) -> real:
    """`upright_place` of interface k in a pose [m]; it changes only by sliding."""
    ends = ends_below(pose, k)
    return upright_place(blocks, k, ends, find_anchor(blocks, pose, k, ends))


@wp.func
def find_end(f: Faces, side: real) -> End:
    """The end of an interface on a side, +1 or -1."""
    half = side * f.upper_width
    corner = f.along + half * f.cosine
    end = End()
    end.on = side * corner <= ALIKE * f.lower_width
    end.upper_x = half * f.cosine - f.upper_height * f.sine
    end.upper_z = -f.upper_height * f.cosine - half * f.sine
    end.lower_x = corner
    end.lower_z = f.lower_height
    end.gap = f.above - half * f.sine
    if not end.on:
        reach = side * f.lower_width - f.along
        end.upper_x = reach * f.cosine + f.above * f.sine
        end.upper_z = -f.upper_height
        end.lower_x = side * f.lower_width * f.cosine - f.lower_height * f.sine
        end.lower_z = f.lower_height * f.cosine + side * f.lower_width * f.sine
        end.gap = f.above * f.cosine - reach * f.sine
    if CHAINS:
        # Levers from the centres of mass, which are off the middles of the faces.
        end.upper_x = end.upper_x + wp.where(end.on, f.upper_middle * f.cosine, f.upper_middle)
        end.upper_z = end.upper_z - wp.where(end.on, f.upper_middle * f.sine, real(0.0))
        end.lower_x = end.lower_x + wp.where(end.on, f.lower_middle, f.lower_middle * f.cosine)
        end.lower_z = end.lower_z + wp.where(end.on, real(0.0), f.lower_middle * f.sine)
    return end


@wp.func
def faces_of(blocks: wp.ref[Blocks], pose: wp.ref[Pose], k: int) -> Faces:
    """The faces of interface k."""
    f = Faces()
    low, height = lower_face(blocks, k)
    sd, cd = turn_across(pose, k)
    f.lower_width = low
    f.lower_height = height
    f.upper_width = blocks.half_width[k]
    f.upper_height = blocks.half_height[k]
    f.along = pose.along[k]
    f.above = pose.above[k]
    f.sine = sd
    f.cosine = cd
    if CHAINS:
        upper, lower = face_middles(blocks, k)
        f.upper_middle = upper
        f.lower_middle = lower
    return f


@wp.func
def interface_rows(blocks: wp.ref[Blocks], pose: wp.ref[Pose], k: int):
    """Relative velocities at interface k from those of its blocks.

    Returns:
        Matrix of the upper block (rows: along the face, away from it at the + and the - end;
        columns: x, z, rotation), of the lower one, and the gaps at both ends [m].
    """
    faces = faces_of(blocks, pose, k)
    plus = find_end(faces, real(1.0))
    minus = find_end(faces, real(-1.0))
    sl, cl = face_below(pose, k)
    su, cu = face_above(pose, k)
    at_minus = pose.touch[k] == MINUS
    zu = wp.where(at_minus, minus.upper_z, plus.upper_z)
    zl = wp.where(at_minus, minus.lower_z, plus.lower_z)
    on = wp.where(at_minus, minus.on, plus.on)
    s = wp.where(on, sl, su)
    c = wp.where(on, cl, cu)
    s1 = wp.where(plus.on, sl, su)
    c1 = wp.where(plus.on, cl, cu)
    s2 = wp.where(minus.on, sl, su)
    c2 = wp.where(minus.on, cl, cu)
    upper = Matrix(c, -s, zu, s1, c1, -plus.upper_x, s2, c2, -minus.upper_x)
    lower = Matrix(-c, s, -zl, -s1, -c1, plus.lower_x, -s2, -c2, minus.lower_x)
    return upper, lower, plus.gap, minus.gap


@wp.func(inline=False)
def fill_jacobian(blocks: wp.ref[Blocks], pose: wp.ref[Pose], g: wp.ref[Jacobian]):
    """Sets `interface_rows` of every interface."""
    for k in range(BLOCKS):
        up, down, _plus, _minus = interface_rows(blocks, pose, k)
        for i in range(3):
            for j in range(3):
                g.upper[3 * k + i, j] = up[i, j]
                if k > 0:
                    g.lower[3 * k + i, j] = down[i, j]
