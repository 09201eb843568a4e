"""The interface of a block in the plane and the body below it: a block, or the ground.

An interface touches at the two ends of the overlap of the upper block's bottom face and the lower
one's top face. Each end is a corner of one body on the face of the other. See the head of
impulse/stack.py. The frame is that of the base, and rotations are positive clockwise; joints of
assemblies take `Pose`, `Mass` and `Velocity` with rotations that are positive counterclockwise.
"""

import warp as wp

GROUND_FACE = real(1.0e9)
"""Half width, and half depth, of the ground's face [m]: no block reaches its ends."""

GROUND = 0
"""Number of the ground where bodies are numbered from it upwards: the lowest block is 1."""


@wp.struct
class Box:
    """Half width and half height of a rectangular block [m]."""

    half_width: real
    half_height: real


@wp.struct
class Pose:
    """Centre of mass [m] and rotation [rad] of a body, with its sine and cosine."""

    x: real
    z: real
    theta: real
    s: real
    c: real


@wp.struct
class Mass:
    """Inverse mass m [1/kg] and inverse moment of inertia j [1/(kg m^2)]; zero of what is fixed."""

    m: real
    j: real


@wp.struct
class Velocity:
    """Velocity of a centre of mass [m/s] and angular velocity [rad/s]."""

    x: real
    z: real
    omega: real


@wp.struct
class Point:
    """A point at which two bodies touch.

    Attributes:
        nx, nz: Normal of the touched face.
        au, bu: Lever from the upper centre along that face and along the normal [m].
        al, bl: The same from the lower centre [m].
    """

    nx: real
    nz: real
    au: real
    bu: real
    al: real
    bl: real


@wp.struct
class Impulse:
    """Normal impulse n and tangential impulse t at a point [N s]."""

    n: real
    t: real


@wp.func
def find_end(side: real, box: Box, at: Pose, low_box: Box, below: Pose):
    """The point at one end of the overlap: side is 1 for the end at +x, -1 for the other.

    Args:
        side: Which end.
        box, at: The upper block and its pose.
        low_box, below: The lower one and its pose.

    Returns:
        The point; the gap there [m]; the place of the upper block along the touched face [m], which
        changes only by sliding.
    """
    dx = at.x - below.x
    dz = at.z - below.z
    px = wedge(side * box.half_width, box.half_height, at.s, at.c)
    pz = -dot(box.half_height, side * box.half_width, at.c, at.s)
    qx = dot(low_box.half_height, side * low_box.half_width, below.s, below.c)
    qz = wedge(low_box.half_height, side * low_box.half_width, below.s, below.c)
    ax = dx + px
    az = dz + pz
    bx = qx - dx
    bz = qz - dz
    # Either a corner of the upper block on the lower face, or one of the lower on the upper face.
    inside = side * wedge(ax, az, below.s, below.c) <= low_box.half_width
    nx = wp.where(inside, below.s, at.s)
    nz = wp.where(inside, below.c, at.c)
    rx = wp.where(inside, px, bx)
    rz = wp.where(inside, pz, bz)
    lx = wp.where(inside, ax, qx)
    lz = wp.where(inside, az, qz)
    au = wedge(rx, rz, nx, nz)
    bu = dot(rx, rz, nx, nz)
    al = wedge(lx, lz, nx, nz)
    bl = dot(lx, lz, nx, nz)
    gap = wp.where(inside, bl - low_box.half_height, -bu - box.half_height)
    place = wp.where(inside, al - side * box.half_width, side * low_box.half_width - au)
    return Point(nx, nz, au, bu, al, bl), gap, place


@wp.func
def gap_of_end(side: real, box: Box, at: Pose, low_box: Box, below: Pose) -> real:
    """Gap of an end of an interface [m]; arguments as in `find_end`."""
    _point, gap, _place = find_end(side, box, at, low_box, below)
    return gap


@wp.func
def add_impulses(
    up: Mass, low: Mass, point: Point, impulse: Impulse, u: wp.ref[Velocity], v: wp.ref[Velocity]
):
    """Adds the impulses of a point to the velocities u of the upper and v of the lower body."""
    px = dot(point.nx, point.nz, impulse.n, impulse.t)
    pz = wedge(point.nz, point.nx, impulse.t, impulse.n)
    u.x = fused(up.m, px, u.x)
    u.z = fused(up.m, pz, u.z)
    u.omega = fused(up.j, wedge(point.bu, point.au, impulse.n, impulse.t), u.omega)
    v.x = fused_less(low.m, px, v.x)
    v.z = fused_less(low.m, pz, v.z)
    v.omega = fused_less(low.j, wedge(point.bl, point.al, impulse.n, impulse.t), v.omega)


@wp.func
def place_on(box: Box, at: Pose, low_box: Box, below: Pose):
    """Place of a block along the face below it, and the width of the overlap of the faces [m].

    The place changes only by sliding; arguments as in `find_end`.
    """
    dx = at.x - below.x
    dz = at.z - below.z
    lean = sign_of(at.theta - below.theta)
    # The bottom corners of the block along the lower face: middle + run and middle - run.
    run = lean * box.half_width * dot(at.c, at.s, below.c, below.s)
    down_x = fused_less(box.half_height, at.s, dx)
    down_z = fused_less(box.half_height, at.c, dz)
    middle = wedge(down_x, down_z, below.s, below.c)
    edge = lean * low_box.half_width
    bx = fused(edge, below.c, fused(low_box.half_height, below.s, -dx))
    bz = fused_less(edge, below.s, fused(low_box.half_height, below.c, -dz))
    inside = lean * (middle + run) <= low_box.half_width
    place = wp.where(inside, middle + run - lean * box.half_width, edge - wedge(bx, bz, at.s, at.c))
    overlap = smaller(lean * (middle + run), low_box.half_width) + smaller(
        lean * (run - middle), low_box.half_width
    )
    return place, overlap
