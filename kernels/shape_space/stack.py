"""Stacks of blocks in space: types of rows, and the contacts of two blocks.

Bodies are numbered from the ground: body 0 is the ground, an endless face that nothing moves, body
k the k-th block. The contacts of interface k, below block k, are the corners of the overlap of the
bottom face of block k and the top face below (see shape/faces.py).
"""

import warp as wp

from warprock.kernels.algebra.vectors import Matrix, Vector
from warprock.kernels.shape.faces import SLOTS, UPPER, Faces, corner, mirror_slot
from warprock.kernels.shape_space.block import Block
from warprock.kernels.shape_space.frame import turn_of_matrix
from warprock.kernels.shape_space.lanes import Triple, Turn

CONTACTS = 8
"""Largest number of contacts of an interface: the slots of shape/faces.py."""
WHOLE = 15
"""Bits of their slots, all set."""

Bodies = wp.types.matrix(shape=(BLOCKS + 1, 3), dtype=real)
"""One vector a body, the ground first."""
Numbers = wp.types.vector(length=BLOCKS + 1, dtype=real)
"""One number a body."""
Axes = wp.types.matrix(shape=(3 * (BLOCKS + 1), 3), dtype=real)
"""One matrix of 3 x 3 a body."""
Points = wp.types.matrix(shape=(CONTACTS * BLOCKS, 3), dtype=real)
"""One vector a contact."""
PointGains = wp.types.matrix(shape=(CONTACTS * BLOCKS, 12), dtype=real)
"""The `Gains` of each contact; see shape_space/contact.py."""
PointNumbers = wp.types.vector(length=CONTACTS * BLOCKS, dtype=real)
"""One number a contact."""
PointInts = wp.types.vector(length=CONTACTS * BLOCKS, dtype=int)
"""One whole number a contact."""
Corners = wp.types.matrix(shape=(SLOTS, 3), dtype=real)
"""One vector a slot."""
CornerNumbers = wp.types.vector(length=SLOTS, dtype=real)
"""One number a slot."""


@wp.func
def rows_of(rows: Axes, k: int) -> Matrix:
    """The matrix of a body, of three rows."""
    return Matrix(
        rows[3 * k, 0], rows[3 * k, 1], rows[3 * k, 2],
        rows[3 * k + 1, 0], rows[3 * k + 1, 1], rows[3 * k + 1, 2],
        rows[3 * k + 2, 0], rows[3 * k + 2, 1], rows[3 * k + 2, 2],
    )  # fmt: skip


@wp.func
def slot_in_turn(slot: int, lean: Vector) -> int:
    """Slot to visit in the turn of `slot`, for a block that leans to given sides."""
    zero = real(0.0)
    return mirror_slot(slot, wp.where(lean[0] < zero, 1, 0), wp.where(lean[1] < zero, 1, 0))


@wp.func
def face_pair(block: Block, below: Block, m: Turn, c: Triple, lean_x: real, lean_y: real) -> Faces:
    """The bottom face of a block and the top face below, in a mirror image.

    Args:
        block: The upper block.
        below: The lower one.
        m: Attitude of the upper block in the axes of the lower one.
        c: Its centre of mass from that of the lower one, in those axes [m].
        lean_x, lean_y: Sides along x and y; where -1, the image is mirrored.
    """
    both = lean_x * lean_y
    x = c.x + below.centre_x - m.r11 * block.centre_x - m.r12 * block.centre_y
    y = c.y + below.centre_y - m.r21 * block.centre_x - m.r22 * block.centre_y
    z = c.z - below.half_height - m.r31 * block.centre_x - m.r32 * block.centre_y
    h = block.half_height
    return Faces(
        lean_x * (x - h * m.r13), lean_y * (y - h * m.r23), z - h * m.r33,
        m.r11, both * m.r21, lean_x * m.r31, both * m.r12, m.r22, lean_y * m.r32,
        block.half_width, block.half_depth, below.half_width, below.half_depth,
    )  # fmt: skip


@wp.func
def shared_corners(block: Block, below: Block, m: Matrix, c: Vector, lean: Vector):
    """Corners of the overlap of two faces, by slot (see shape/faces.py), found in a mirror image.

    Args:
        block: The upper block.
        below: The lower one.
        m: Attitude of the upper block in the axes of the lower one.
        c: Its centre of mass from that of the lower one, in those axes [m].
        lean: Sides along x and y; where -1, the image is mirrored.

    Returns:
        The points from the lower centre of mass, in the lower axes and not mirrored [m]; the gaps
        [m]; and a mask of the slots that exist.
    """
    sx, sy = lean[0], lean[1]
    faces = face_pair(block, below, turn_of_matrix(m), Triple(c[0], c[1], c[2]), sx, sy)
    places, gaps, there, s = Corners(), CornerNumbers(), int(0), int(0)
    # If all corners of the upper face lie over the lower one, the overlap is the upper face.
    while s < wp.where(there == WHOLE, UPPER, int(SLOTS)):
        x, y, gap, exists = corner(s, faces)
        t = slot_in_turn(s, lean)
        places[t] = Vector(
            sx * x - below.centre_x, sy * y - below.centre_y, gap + below.half_height
        )
        gaps[t] = gap
        there = there | wp.where(exists, 1 << t, 0)
        s += 1
    return places, gaps, there
