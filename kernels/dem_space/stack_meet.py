"""Places of the springs between two blocks in space, and relative motion of their faces.

The bottom face of the upper block lies on the top face of the lower body. Vectors are in the axes
of the lower body unless others are named. The springs are spread over the part of the upper face
above the lower one. That part has a middle, and A and B lead from there to its ends along the width
and the depth. It is a rectangle if the faces have no relative yaw. Else its grid has the largest
extents along both axes, and points beyond an edge of the lower face press on that edge.

All springs of an interface press along one normal, that of the contact where the upper face is
lowest: the lower face's, the upper one's where a corner of the lower face touches it, and that of
both edges where two cross, see `lowest_slopes` in shape/faces.py. Overlaps are told along it, and
so are velocities. The other two directions of a contact are the lower block's axes, turned with
the third one into the normal by the least turn. A shear spring keeps its stretch along them when
the normal changes: it has the same length and the same energy then.
"""

import warp as wp

from warprock.kernels.shape.faces import lowest_slopes
from warprock.kernels.shape_space.block import Block, slide_of
from warprock.kernels.shape_space.lanes import (
    State,
    Triple,
    Turn,
    into_base,
    into_body,
    matrix_of,
    product,
    turn_of,
    vector_product,
)
from warprock.kernels.shape_space.stack import face_pair

SMALLEST = real(1.0e-3)
"""Least cosine of the relative yaw for which the extent of a face still grows."""
NO_AREA = real(1.0e-12)
"""Area below which two faces do not overlap [m^2]."""


@wp.struct
class Link:
    """Places of the springs of an interface, in the axes of the lower body, and their velocities.

    Velocities and overlaps are along the directions of the contact, see above.

    Attributes:
        overlap: Penetration in the middle [m].
        over_a, over_b: Difference of that at the ends of A and B [m].
        area: Area of the springs [m^2]; 0 if the faces do not overlap.
        mu: Friction coefficient.
        wide, deep: Half width of the lower face [m] and half its depth.
        x, y: Place of the middle on the lower face, from the middle of that [m].
        over: One over the area that A and B span in the plan of the lower face [1/m^2].
        p1, p2, p3: Lever of the middle from the upper centre of mass [m].
        d1, d2, d3: Lever of the middle from the lower centre of mass [m].
        a1, a2, a3: A [m].
        b1, b2, b3: B [m].
        v1, v2, v3: Velocity of the upper face relative to the lower one in the middle [m/s].
        j1, j2, j3: Difference of that at the end of A [m/s].
        k1, k2, k3: Difference of that at the end of B [m/s].
        n1, n2, n3: The normal.
    """

    overlap: real
    over_a: real
    over_b: real
    area: real
    mu: real
    wide: real
    deep: real
    x: real
    y: real
    over: real
    p1: real
    p2: real
    p3: real
    d1: real
    d2: real
    d3: real
    a1: real
    a2: real
    a3: real
    b1: real
    b2: real
    b3: real
    v1: real
    v2: real
    v3: real
    j1: real
    j2: real
    j3: real
    k1: real
    k2: real
    k3: real
    n1: real
    n2: real
    n3: real


@wp.func
def parts_along(m: Turn, x: real, y: real, z: real):
    """Parts of a vector along the axes of a body."""
    v = into_body(m, Triple(x, y, z))
    return v.x, v.y, v.z


@wp.func
def out_of(m: Turn, x: real, y: real, z: real):
    """The vector with given parts along the axes of a body."""
    v = into_base(m, Triple(x, y, z))
    return v.x, v.y, v.z


@wp.func
def angular_velocity(block: Block, m: Turn, lx: real, ly: real, lz: real):
    """Angular velocity of a block [rad/s] from its angular momentum for unit mass [m^2/s]."""
    x, y, z = parts_along(m, lx, ly, lz)
    return out_of(m, x * block.inverse_x, y * block.inverse_y, z * block.inverse_z)


@wp.func
def stretch(half: real, reach_a: real, reach_b: real, place: real, lean_a: real, lean_b: real):
    """Middle and half length of the overlap with the face below, along one axis of the face [m].

    Args:
        half: Half length of the face along that axis [m].
        reach_a, reach_b: Half width of the lower face [m] and half its depth.
        place: Middle of the lower face along that axis, from the middle of the face [m].
        lean_a, lean_b: Part of the axis that lies along the lower face's width and along its depth.
    """
    width = reach_a / larger(size(lean_a), SMALLEST)
    depth = reach_b / larger(size(lean_b), SMALLEST)
    reach = smaller(width, depth)
    low = larger(-half, place - reach)
    top = smaller(half, place + reach)
    return real(0.5) * (low + top), real(0.5) * (top - low)


if BLOCKS == 1:

    @wp.func
    def attitude_on(lower: State, qx: real, qy: real, qz: real, qw: real):
        """The upper attitude as seen from the lower body: the ground is level."""
        return qx, qy, qz, qw

    @wp.func
    def into_lower(lower: State, x: real, y: real, z: real):
        """A vector of the base's axes in those of the lower body: the same on the ground."""
        return x, y, z

    @wp.func
    def out_of_lower(lower: State, x: real, y: real, z: real):
        """A vector of the lower body's axes in those of the base: the same on the ground."""
        return x, y, z

    @wp.func
    def lower_rotation(below: Block, lower: State):
        """Angular velocity of the lower body in its axes [rad/s]: the ground has none."""
        return real(0.0), real(0.0), real(0.0)

    @wp.func
    def overlap_of(block: Block, below: Block, c1: real, c2: real, m: Turn):
        """Middle and half length of what two faces share: the whole of the block's [m]."""
        return real(0.0), block.half_width, real(0.0), block.half_depth

    @wp.func
    def find_normal(block: Block, below: Block, m: Turn, c: Triple) -> Triple:
        """The normal of an interface: that of the ground."""
        return Triple(real(0.0), real(0.0), real(1.0))

    @wp.func
    def into_contact(n: Triple, x: real, y: real, z: real):
        """Parts of a vector along the directions of a contact: the axes of the ground."""
        return x, y, z

    @wp.func
    def out_of_contact(link: Link, x: real, y: real, z: real):
        """The vector with given parts along the directions of a contact."""
        return x, y, z

else:

    @wp.func
    def attitude_on(lower: State, qx: real, qy: real, qz: real, qw: real):
        """The upper attitude as seen from the lower body."""
        gx, gy, gz, gw = lower.qx, lower.qy, lower.qz, lower.qw
        return (
            fused_less(gx, qw, gw * qx) - fused_less(gz, qy, gy * qz),
            fused_less(gy, qw, gw * qy) - fused_less(gx, qz, gz * qx),
            fused_less(gz, qw, gw * qz) - fused_less(gy, qx, gx * qy),
            dot(gw, gx, qw, qx) + dot(gy, gz, qy, qz),
        )  # fmt: skip

    @wp.func
    def into_lower(lower: State, x: real, y: real, z: real):
        """A vector of the base's axes in those of the lower body."""
        return parts_along(turn_of(lower), x, y, z)

    @wp.func
    def out_of_lower(lower: State, x: real, y: real, z: real):
        """A vector of the lower body's axes in those of the base."""
        return out_of(turn_of(lower), x, y, z)

    @wp.func
    def lower_rotation(below: Block, lower: State):
        """Angular velocity of the lower body in its axes [rad/s]."""
        h1, h2, h3 = into_lower(lower, lower.lx, lower.ly, lower.lz)
        return h1 * below.inverse_x, h2 * below.inverse_y, h3 * below.inverse_z

    @wp.func
    def overlap_of(block: Block, below: Block, c1: real, c2: real, m: Turn):
        """Middle and half length of what faces share, along the upper one's width and depth [m].

        (c1, c2) is its centre of mass, m its axes as seen from the lower one.
        """
        cx, cy, high = block.centre_x, block.centre_y, block.half_height
        x = c1 + below.centre_x - product(m.r11, m.r12, m.r13, cx, cy, high)
        y = c2 + below.centre_y - product(m.r21, m.r22, m.r23, cx, cy, high)
        over = real(1.0) / larger(m.r33, SMALLEST)
        along = fused_less(m.r22, x, m.r12 * y) * over
        across = fused_less(m.r11, y, m.r21 * x) * over
        middle_a, half_a = stretch(
            block.half_width, below.half_width, below.half_depth, along, m.r11, m.r21
        )
        middle_b, half_b = stretch(
            block.half_depth, below.half_width, below.half_depth, across, m.r12, m.r22
        )
        return middle_a, half_a, middle_b, half_b

    @wp.func
    def find_normal(block: Block, below: Block, m: Turn, c: Triple) -> Triple:
        """The normal of an interface, see above.

        c is the centre of mass of the upper block from the lower one's, m its axes.
        """
        one = real(1.0)
        slopes = lowest_slopes(face_pair(block, below, m, c, one, one))
        over = one / wp.sqrt(product(slopes.x, slopes.y, one, slopes.x, slopes.y, one))
        return Triple(slopes.x * over, slopes.y * over, over)

    @wp.func
    def into_contact(n: Triple, x: real, y: real, z: real):
        """Parts of a vector along the directions of a contact with the normal n."""
        flat = dot(n.x, n.y, x, y)
        turned = fused(flat, real(1.0) / (real(1.0) + n.z), z)
        return fused_less(n.x, turned, x), fused_less(n.y, turned, y), fused(n.z, z, flat)

    @wp.func
    def out_of_contact(link: Link, x: real, y: real, z: real):
        """The vector with given parts along the directions of a contact."""
        flat = dot(link.n1, link.n2, x, y)
        turned = fused_less(flat, real(1.0) / (real(1.0) + link.n3), z)
        return (
            fused(link.n1, turned, x), fused(link.n2, turned, y), fused(link.n3, z, -flat),
        )  # fmt: skip


@wp.func
def find_contacts(block: Block, below: Block, upper: State, lower: State):
    """Places of the springs of an interface, and relative motion of its faces.

    Args:
        block, below: The upper and the lower block; the ground is endless and has no height.
        upper, lower: Their states.

    Returns:
        The link; slide of the upper body along x and y [m].
    """
    dx, dy, dz = upper.x - lower.x, upper.y - lower.y, upper.z - lower.z
    sx, sy, sz, sw = attitude_on(lower, upper.qx, upper.qy, upper.qz, upper.qw)
    m = matrix_of(sx, sy, sz, sw)
    both, high = block.half_height + below.half_height, block.half_height
    c1, c2, c3 = into_lower(lower, dx, dy, both + dz)
    slide_x, slide_y = slide_of(block, c1, c2, m)
    x, half_a, y, half_b = overlap_of(block, below, c1, c2, m)
    x, y = x - block.centre_x, y - block.centre_y
    p1, p2, p3 = out_of(m, x, y, -high)
    # Without cancellation: 1 - r33 = 2 (sx^2 + sy^2), likewise for the lower body.
    leans = dot(lower.qx, lower.qy, lower.qx, lower.qy)
    sunk = fused_less(high, dot(sx, sy, sx, sy), both * leans)
    _x, _y, up = into_lower(lower, dx, dy, dz)
    n = find_normal(block, below, m, Triple(c1, c2, c3))
    overlap = n.z * (TWO * sunk - up - dot(m.r31, m.r32, x, y))
    d1, d2, d3 = c1 + p1, c2 + p2, c3 + p3
    a1, a2, a3 = half_a * m.r11, half_a * m.r21, half_a * m.r31
    b1, b2, b3 = half_b * m.r12, half_b * m.r22, half_b * m.r32
    # Velocities, and angular velocities of both bodies.
    w1, w2, w3 = into_lower(lower, upper.vx - lower.vx, upper.vy - lower.vy, upper.vz - lower.vz)
    l1, l2, l3 = into_lower(lower, upper.lx, upper.ly, upper.lz)
    o1, o2, o3 = angular_velocity(block, m, l1, l2, l3)
    u1, u2, u3 = lower_rotation(below, lower)
    s1, s2, s3 = vector_product(o1, o2, o3, p1, p2, p3)
    t1, t2, t3 = vector_product(u1, u2, u3, d1, d2, d3)
    o1, o2, o3 = o1 - u1, o2 - u2, o3 - u3
    v1, v2, v3 = into_contact(n, w1 + s1 - t1, w2 + s2 - t2, w3 + s3 - t3)
    j1, j2, j3 = vector_product(o1, o2, o3, a1, a2, a3)
    k1, k2, k3 = vector_product(o1, o2, o3, b1, b2, b3)
    j1, j2, j3 = into_contact(n, j1, j2, j3)
    k1, k2, k3 = into_contact(n, k1, k2, k3)
    zero = real(0.0)
    over = real(1.0) / larger(fused_less(a2, b1, a1 * b2), NO_AREA)
    area = real(4.0) * larger(half_a, zero) * larger(half_b, zero)
    link = Link(
        overlap, -n.z * a3, -n.z * b3, area, block.friction, below.half_width, below.half_depth,
        d1 + below.centre_x, d2 + below.centre_y, over, p1, p2, p3, d1, d2, d3, a1, a2, a3,
        b1, b2, b3, v1, v2, v3, j1, j2, j3, k1, k2, k3, n.x, n.y, n.z,
    )  # fmt: skip
    return link, slide_x, slide_y


if BLOCKS == 1:

    @wp.func
    def clip_to_face(link: Link, a: real, b: real):
        """Where a point of the upper face meets the lower one: the ground is endless."""
        return a, b

else:

    @wp.func
    def clip_to_face(link: Link, a: real, b: real):
        """Where a point (a, b) of the upper face meets the lower one: beyond its edges, on them."""
        x = fused(b, link.b1, fused(a, link.a1, link.x))
        y = fused(b, link.b2, fused(a, link.a2, link.y))
        dx = larger(smaller(x, link.wide), -link.wide) - x
        dy = larger(smaller(y, link.deep), -link.deep) - y
        return (
            fused(fused_less(link.b1, dy, link.b2 * dx), link.over, a),
            fused(fused_less(link.a2, dx, link.a1 * dy), link.over, b),
        )
