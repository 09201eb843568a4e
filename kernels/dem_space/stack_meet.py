"""Where the springs between two blocks in space are and how their faces move.

The upper block's bottom face lies on the top face of the lower body, in whose axes all is told
that no other axes are named for. The springs are spread over the part of the upper face that lies
above the lower one: its middle, and A and B from there to its ends along the width and the depth.
Where the faces are not turned against each other that part is a rectangle; else its grid is that
of the largest stretches along the two axes, and of its points those that lie beyond an edge of the
lower face press on that edge.
"""

import warp as wp

from warprock.kernels.shape_space.block import (
    Block,
    in_axes,
    matrix_of,
    product,
    slide_of,
    vector_product,
)

SMALLEST = real(1.0e-3)
"""Cosine below which a face seen askew grows no longer."""
NO_AREA = real(1.0e-12)
"""Area below which two faces share nothing [m^2]."""


@wp.struct
class Moving:
    """Where a body is and how it moves.

    Attributes:
        x, y, z: Centre of mass [m]; z from its height in the stack of rigid blocks.
        qx, qy, qz, qw: Attitude.
        vx, vy, vz: Velocity [m/s].
        lx, ly, lz: Angular momentum for unit mass [m^2/s].
    """

    x: real
    y: real
    z: real
    qx: real
    qy: real
    qz: real
    qw: real
    vx: real
    vy: real
    vz: real
    lx: real
    ly: real
    lz: real


@wp.struct
class Link:
    """Where the springs of an interface are, in the lower body's axes.

    Attributes:
        o: Overlap in the middle [m].
        area: Of the springs [m^2], 0 where the faces share nothing.
        mu: Friction coefficient.
        wide, deep: Half width of the lower face [m] and half its depth.
        cx, cy: From the middle of the lower face to the lower centre of mass [m].
        p1, p2, p3: Lever of the middle from the upper centre of mass [m].
        d1, d2, d3: Lever of the middle from the lower centre of mass [m].
        a1, a2, a3: A [m].
        b1, b2, b3: B [m].
        v1, v2, v3: Velocity of the upper face against the lower one in the middle [m/s].
        j1, j2, j3: What is to be added to it at the end of A [m/s].
        k1, k2, k3: What is to be added to it at the end of B [m/s].
        slide_x, slide_y: Slide of the upper body along x and y [m].
    """

    o: real
    area: real
    mu: real
    wide: real
    deep: real
    cx: real
    cy: real
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
    slide_x: real
    slide_y: real


@wp.func
def stretch(half: real, reach_a: real, reach_b: real, place: real, lean_a: real, lean_b: real):
    """Middle and half length of what a face shares with the one below, along one of its axes [m].

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
    def attitude_on(lower: Moving, qx: real, qy: real, qz: real, qw: real):
        """The upper attitude as seen from the lower body: the ground is level."""
        return qx, qy, qz, qw

    @wp.func
    def seen_from(gx: real, gy: real, gz: real, gw: real, x: real, y: real, z: real):
        """A vector of the base's axes in those of the lower body: the same on the ground."""
        return x, y, z

    @wp.func
    def back_from(gx: real, gy: real, gz: real, gw: real, x: real, y: real, z: real):
        """A vector of the lower body's axes in those of the base: the same on the ground."""
        return x, y, z

    @wp.func
    def turning(below: Block, lower: Moving):
        """Angular velocity of the lower body in its axes [rad/s]: the ground has none."""
        return real(0.0), real(0.0), real(0.0)

    @wp.func
    def shared(
        block: Block, below: Block, c1: real, c2: real, m11: real, m12: real, m13: real, m21: real,
        m22: real, m23: real, m33: real,
    ):  # fmt: skip
        """Middle and half length of what two faces share: the whole of the block's [m]."""
        return real(0.0), block.half_width, real(0.0), block.half_depth

else:

    @wp.func
    def attitude_on(lower: Moving, qx: real, qy: real, qz: real, qw: real):
        """The upper attitude as seen from the lower body."""
        gx, gy, gz, gw = lower.qx, lower.qy, lower.qz, lower.qw
        return (
            fused_less(gx, qw, gw * qx) - fused_less(gz, qy, gy * qz),
            fused_less(gy, qw, gw * qy) - fused_less(gx, qz, gz * qx),
            fused_less(gz, qw, gw * qz) - fused_less(gy, qx, gx * qy),
            dot(gw, gx, qw, qx) + dot(gy, gz, qy, qz),
        )  # fmt: skip

    @wp.func
    def seen_from(gx: real, gy: real, gz: real, gw: real, x: real, y: real, z: real):
        """A vector of the base's axes in those of the lower body, of the attitude gx to gw."""
        r11, r12, r13, r21, r22, r23, r31, r32, r33 = matrix_of(gx, gy, gz, gw)
        return in_axes(r11, r21, r31, r12, r22, r32, r13, r23, r33, x, y, z)

    @wp.func
    def back_from(gx: real, gy: real, gz: real, gw: real, x: real, y: real, z: real):
        """A vector of the lower body's axes in those of the base; gx to gw is its attitude."""
        r11, r12, r13, r21, r22, r23, r31, r32, r33 = matrix_of(gx, gy, gz, gw)
        return in_axes(r11, r12, r13, r21, r22, r23, r31, r32, r33, x, y, z)

    @wp.func
    def turning(below: Block, lower: Moving):
        """Angular velocity of the lower body in its axes [rad/s]."""
        h1, h2, h3 = seen_from(lower.qx, lower.qy, lower.qz, lower.qw, lower.lx, lower.ly, lower.lz)
        return h1 * below.inverse_x, h2 * below.inverse_y, h3 * below.inverse_z

    @wp.func
    def shared(
        block: Block, below: Block, c1: real, c2: real, m11: real, m12: real, m13: real, m21: real,
        m22: real, m23: real, m33: real,
    ):  # fmt: skip
        """Middle and half length of what faces share, along the upper one's width and depth [m].

        (c1, c2) and m11 to m33 are its centre of mass and attitude as seen from the lower one.
        """
        cx, cy, high = block.centre_x, block.centre_y, block.half_height
        x = c1 + below.centre_x - product(m11, m12, m13, cx, cy, high)
        y = c2 + below.centre_y - product(m21, m22, m23, cx, cy, high)
        over = real(1.0) / larger(m33, SMALLEST)
        along = fused_less(m22, x, m12 * y) * over
        across = fused_less(m11, y, m21 * x) * over
        middle_a, half_a = stretch(
            block.half_width, below.half_width, below.half_depth, along, m11, m21
        )
        middle_b, half_b = stretch(
            block.half_depth, below.half_width, below.half_depth, across, m12, m22
        )
        return middle_a, half_a, middle_b, half_b


@wp.func
def relative_motion(
    block: Block, m11: real, m12: real, m13: real, m21: real, m22: real, m23: real,
    m31: real, m32: real, m33: real, w1: real, w2: real, w3: real, l1: real, l2: real, l3: real,
    u1: real, u2: real, u3: real, p1: real, p2: real, p3: real, d1: real, d2: real, d3: real,
):  # fmt: skip
    """How the upper face moves against the lower one, all in the lower body's axes.

    Args:
        block: See `find_contacts`, as p1 to p3 and d1 to d3.
        m11: The upper block's attitude, row by row, to m33.
        w1: Velocity of the upper centre from the lower one's [m/s], to w3.
        l1: Angular momentum of the upper block for unit mass [m^2/s], to l3.
        u1: Angular velocity of the lower body [rad/s], to u3.

    Returns:
        Velocity in the middle of the springs [m/s]; difference of the angular velocities [rad/s].
    """
    n1, n2, n3 = in_axes(m11, m21, m31, m12, m22, m32, m13, m23, m33, l1, l2, l3)
    n1, n2, n3 = n1 * block.inverse_x, n2 * block.inverse_y, n3 * block.inverse_z
    o1, o2, o3 = in_axes(m11, m12, m13, m21, m22, m23, m31, m32, m33, n1, n2, n3)
    s1, s2, s3 = vector_product(o1, o2, o3, p1, p2, p3)
    t1, t2, t3 = vector_product(u1, u2, u3, d1, d2, d3)
    return w1 + s1 - t1, w2 + s2 - t2, w3 + s3 - t3, o1 - u1, o2 - u2, o3 - u3


@wp.func
def find_contacts(block: Block, below: Block, upper: Moving, lower: Moving) -> Link:
    """Finds where the springs of an interface are, and how the faces move.

    Args:
        block, below: The upper and the lower block; the ground is endless and has no height.
        upper, lower: Where they are.
    """
    dx, dy, dz = upper.x - lower.x, upper.y - lower.y, upper.z - lower.z
    gx, gy, gz, gw = lower.qx, lower.qy, lower.qz, lower.qw
    sx, sy, sz, sw = attitude_on(lower, upper.qx, upper.qy, upper.qz, upper.qw)
    m11, m12, m13, m21, m22, m23, m31, m32, m33 = matrix_of(sx, sy, sz, sw)
    both, high = block.half_height + below.half_height, block.half_height
    c1, c2, c3 = seen_from(gx, gy, gz, gw, dx, dy, both + dz)
    slide_x, slide_y = slide_of(block, c1, c2, m11, m12, m13, m21, m22, m23, m31, m32)
    x, half_a, y, half_b = shared(block, below, c1, c2, m11, m12, m13, m21, m22, m23, m33)
    x, y = x - block.centre_x, y - block.centre_y
    p1, p2, p3 = in_axes(m11, m12, m13, m21, m22, m23, m31, m32, m33, x, y, -high)
    # Nothing cancels: 1 - m33 = 2 (sx^2 + sy^2), and that of the lower body likewise.
    sunk = fused_less(high, dot(sx, sy, sx, sy), both * dot(gx, gy, gx, gy))
    _x, _y, up = seen_from(gx, gy, gz, gw, dx, dy, dz)
    o = TWO * sunk - up - dot(m31, m32, x, y)
    d1, d2, d3 = c1 + p1, c2 + p2, c3 + p3
    a1, a2, a3 = half_a * m11, half_a * m21, half_a * m31
    b1, b2, b3 = half_b * m12, half_b * m22, half_b * m32
    w1, w2, w3 = seen_from(
        gx, gy, gz, gw, upper.vx - lower.vx, upper.vy - lower.vy, upper.vz - lower.vz
    )
    l1, l2, l3 = seen_from(gx, gy, gz, gw, upper.lx, upper.ly, upper.lz)
    u1, u2, u3 = turning(below, lower)
    v1, v2, v3, t1, t2, t3 = relative_motion(
        block, m11, m12, m13, m21, m22, m23, m31, m32, m33,
        w1, w2, w3, l1, l2, l3, u1, u2, u3, p1, p2, p3, d1, d2, d3,
    )  # fmt: skip
    j1, j2, j3 = vector_product(t1, t2, t3, a1, a2, a3)
    k1, k2, k3 = vector_product(t1, t2, t3, b1, b2, b3)
    zero = real(0.0)
    area = real(4.0) * larger(half_a, zero) * larger(half_b, zero)
    return Link(
        o, area, block.friction, below.half_width, below.half_depth, below.centre_x, below.centre_y,
        p1, p2, p3, d1, d2, d3, a1, a2, a3, b1, b2, b3,
        v1, v2, v3, j1, j2, j3, k1, k2, k3, slide_x, slide_y,
    )  # fmt: skip


if BLOCKS == 1:

    @wp.func
    def held_in(link: Link, a: real, b: real):
        """Where a point of the upper face meets the lower one: the ground is endless."""
        return a, b

else:

    @wp.func
    def held_in(link: Link, a: real, b: real):
        """Where a point (a, b) of the upper face meets the lower one: beyond its edges, on them."""
        x = fused(b, link.b1, fused(a, link.a1, link.d1 + link.cx))
        y = fused(b, link.b2, fused(a, link.a2, link.d2 + link.cy))
        dx = larger(smaller(x, link.wide), -link.wide) - x
        dy = larger(smaller(y, link.deep), -link.deep) - y
        over = real(1.0) / larger(fused_less(link.a2, link.b1, link.a1 * link.b2), NO_AREA)
        return (
            fused(fused_less(link.b1, dy, link.b2 * dx), over, a),
            fused(fused_less(link.a2, dx, link.a1 * dy), over, b),
        )
