"""Attitude, free rotation and corners of blocks in space.

An attitude is a unit quaternion (x, y, z, w); its rotation matrix, row by row r11 to r33, turns
body axes (width, depth, height) into those of the base (x in the plane of rocking, y across it,
z upwards). Its third column is the block's axis: rotation = atan2(r13, r33), rotation across =
atan2(r23, r33), except for blocks that fall, see `turns_of`.

The state holds the angular momentum in the axes of the base, so free rotation conserves it to the
last bit and only changes the attitude. A step turns the block about its own axes one after the
other: x and y for half a step, z for a step, y and x for half a step. Each turn is the exact
rotation by one term m_i^2 / (2 I_i) of the energy. The scheme is of second order, symmetric and
symplectic, so the error of the energy stays bounded. Rotation about one axis alone is exact.

Dullweber, Leimkuhler and McLachlan (1997), Eq. 13 f.
"""

import warp as wp

from warprock.kernels.shape_space.lanes import Triple, Turn, into_body, matrix_of, product

TOUCH = real(1.0e-4)
"""Height above the lowest corner, over the half width, up to which corners count as touching for
the slide: a face that leans by less touches with all of its corners."""
FALLS = real(0.5)
"""Height of the top of a block's axis, over its length, below which the block counts as falling: it
leans by more than 60 degrees."""


@wp.struct
class Block:
    """One block of a lane, and where it starts; SI units, lengths are half lengths.

    Attributes:
        half_width, half_depth: Half sizes of the faces that touch [m].
        half_height: Half of the height [m].
        centre_x: The centre of mass from the middle, along the width [m].
        centre_y: The same along the depth [m].
        mass: [kg].
        inverse_x, inverse_y, inverse_z: Inverse moments of inertia about the body's axes, for unit
            mass [1/m^2].
        friction: Coulomb friction coefficient under the block.
        x, y, z: Centre of mass at the start [m].
        qx, qy, qz, qw: Attitude at the start.
        flat_x, flat_y: Middle of the bottom face at the start if the block were flat, from the
            centre of mass of the body below, in that body's axes [m].
        flat_c, flat_s: Cosine and sine of the yaw relative to the body below at the start.
        standing: Corners that touch at the start.
    """

    half_width: real
    half_depth: real
    half_height: real
    centre_x: real
    centre_y: real
    mass: real
    inverse_x: real
    inverse_y: real
    inverse_z: real
    friction: real
    x: real
    y: real
    z: real
    qx: real
    qy: real
    qz: real
    qw: real
    flat_x: real
    flat_y: real
    flat_c: real
    flat_s: real
    standing: real


@wp.func
def turn_pair(s: real, c: real, a: real, b: real):
    """Two numbers (a, b) turned by an angle with the sine s and the cosine c."""
    return fused(s, b, c * a), fused_less(s, a, c * b)


@wp.func
def turn_pair_twice(s: real, c: real, a: real, b: real):
    """Two numbers (a, b) turned by twice that angle."""
    twice = s + s
    return turn_pair(twice * c, fused_less(twice, s, real(1.0)), a, b)


@wp.func
def turn_freely(
    qx: real, qy: real, qz: real, qw: real, spin: Triple, inverse: Triple, dt: real
):  # fmt: skip
    """Attitude after free rotation for a time dt [s], of either sign: x, y, z, w.

    Args:
        qx, qy, qz, qw: Attitude.
        spin: Angular momentum in the axes of the base, for unit mass [m^2/s].
        inverse: Inverse moments of inertia about the body's axes, for unit mass [1/m^2].
        dt: Time [s]; no single turn may exceed 3 rad.
    """
    m, ix, iy, iz = into_body(matrix_of(qx, qy, qz, qw), spin), inverse.x, inverse.y, inverse.z
    mx, my, mz = m.x, m.y, m.z
    quarter = HALF * HALF * dt
    # About x, for half of the time. The quaternion takes half angles, the momentum in body axes
    # twice these.
    s, c = sine(quarter * ix * mx), cosine(quarter * ix * mx)
    ax, aw = turn_pair(s, c, qx, qw)
    ay, az = turn_pair(s, c, qy, qz)
    ny, nz = turn_pair_twice(s, c, my, mz)
    # About y.
    s, c = sine(quarter * iy * ny), cosine(quarter * iy * ny)
    bz, bx = turn_pair(s, c, az, ax)
    by, bw = turn_pair(s, c, ay, aw)
    kz, kx = turn_pair_twice(s, c, nz, mx)
    # About z, for the whole time.
    s, c = sine(TWO * quarter * iz * kz), cosine(TWO * quarter * iz * kz)
    cx, cy = turn_pair(s, c, bx, by)
    cz, cw = turn_pair(s, c, bz, bw)
    jx, jy = turn_pair_twice(s, c, kx, ny)
    # About y again, and x.
    s, c = sine(quarter * iy * jy), cosine(quarter * iy * jy)
    dz, dx = turn_pair(s, c, cz, cx)
    dy, dw = turn_pair(s, c, cy, cw)
    _hz, hx = turn_pair_twice(s, c, kz, jx)
    s, c = sine(quarter * ix * hx), cosine(quarter * ix * hx)
    ex, ew = turn_pair(s, c, dx, dw)
    ey, ez = turn_pair(s, c, dy, dz)
    # One Newton step towards length 1, which removes the round-off.
    back = fused_less(HALF, fused(ew, ew, product(ex, ey, ez, ex, ey, ez)), real(1.5))
    return back * ex, back * ey, back * ez, back * ew


@wp.func
def slide_of(block: Block, dx: real, dy: real, r: Turn):
    """Slide of a block along the face below, in the axes of the body below, x and y [m].

    It is the mean displacement of the touching corners from their places at the start.

    Args:
        block: The block.
        dx, dy: Centre of mass from that of the body below (from the origin of the ground), in that
            body's axes [m].
        r: Attitude of the block in those axes.
    """
    zero, one = real(0.0), real(1.0)
    # Heights of the corners relative to the middle: -+ along the width, -+ along the depth.
    rise, climb = r.r31 * block.half_width, r.r32 * block.half_depth
    lowest = -wp.where(rise < zero, -rise, rise) - wp.where(climb < zero, -climb, climb)
    reach = lowest + TOUCH * block.half_width
    on1 = wp.where(-rise - climb <= reach, one, zero)
    on2 = wp.where(rise - climb <= reach, one, zero)
    on3 = wp.where(rise + climb <= reach, one, zero)
    on4 = wp.where(climb - rise <= reach, one, zero)
    part = one / (on1 + on2 + on3 + on4)
    along = part * (on2 + on3 - on1 - on4) * block.half_width
    across = part * (on3 + on4 - on1 - on2) * block.half_depth
    ax, ay = along - block.centre_x, across - block.centre_y
    stood_x = fused_less(block.flat_s, across, fused(block.flat_c, along, block.flat_x))
    stood_y = fused(block.flat_c, across, fused(block.flat_s, along, block.flat_y))
    return (
        fused_less(r.r13, block.half_height, fused(r.r12, ay, fused(r.r11, ax, dx))) - stood_x,
        fused_less(r.r23, block.half_height, fused(r.r22, ay, fused(r.r21, ax, dy))) - stood_y,
    )


@wp.func
def turns_of(block: Block, r13: real, r23: real, r33: real, qz: real, qw: real):
    """Rotations of a block as tangents, which need no trigonometric function.

    The two rotations are those of `rotations` in warprock/model/pose.py, of the axis
    (r13, r23, r33).

    Returns:
        Tangents of the rotation in the plane and across it (0 to infinity), square of the tangent
        of the tilt, tangent of half the yaw since the start; NEVER beyond a right angle.
    """
    zero = real(0.0)
    size_x = wp.where(r13 < zero, -r13, r13)
    size_y = wp.where(r23 < zero, -r23, r23)
    up = larger(r33, zero)
    square = up * up
    part = larger(fused_less(square, real(1.0) / (FALLS * FALLS), real(1.0)), zero)
    falls = part > zero
    part_x, part_y = part * r13, part * r23
    run_x = wp.where(falls, wp.sqrt(fused(part_y, part_y, square)), up)
    run_y = wp.where(falls, wp.sqrt(fused(part_x, part_x, square)), up)
    tan_x = size_x / larger(run_x, real(1.0e-30))
    tan_y = size_y / larger(run_y, real(1.0e-30))
    tan_tilt = dot(size_x, size_y, size_x, size_y) / larger(square, real(1.0e-30))
    # Twist about the vertical relative to the start, as complex numbers.
    along = dot(qw, qz, block.qw, block.qz)
    across = fused_less(qw, block.qz, qz * block.qw)
    along = wp.where(along < zero, -along, along)
    across = wp.where(across < zero, -across, across)
    return (
        smaller(tan_x, NEVER), smaller(tan_y, NEVER), smaller(tan_tilt, NEVER),
        across / larger(along, real(1.0e-30)),
    )  # fmt: skip
