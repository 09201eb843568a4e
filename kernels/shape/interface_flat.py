"""The interface of a block in the plane and what it stands on: a block, or the ground.

An interface touches at the two ends of the overlap of the upper block's bottom face and the lower
one's top face: a corner of one body on the face of the other. For names see the head of
impulse/stack.py; of the two bodies the lower one's names begin with l.
"""

import warp as wp

GROUND_FACE = real(1.0e9)
"""Half width, and half depth, of the ground's face [m]: no block reaches its ends."""


@wp.func
def find_end(
    side: real, half_width: real, half_height: real, s: real, c: real,
    lhalf_width: real, lhalf_height: real, ls: real, lc: real, dx: real, dz: real,
):  # fmt: skip
    """The point at one end of the overlap: side is 1 for the end at +x, -1 for the other.

    (dx, dz) leads from the lower centre to the upper one [m].

    Returns:
        Normal (x, z) of the face that is touched; levers of the point from the upper centre
        along that face and along the normal, the same two from the lower centre [m]; the gap [m];
        the place of the upper block along what it touches [m], which changes by sliding alone.
    """
    px = wedge(side * half_width, half_height, s, c)
    pz = -dot(half_height, side * half_width, c, s)
    qx = dot(lhalf_height, side * lhalf_width, ls, lc)
    qz = wedge(lhalf_height, side * lhalf_width, ls, lc)
    ax = dx + px
    az = dz + pz
    bx = qx - dx
    bz = qz - dz
    # A corner of the upper block on the lower face, else one of the lower block on the upper face.
    inside = side * wedge(ax, az, ls, lc) <= lhalf_width
    nx = wp.where(inside, ls, s)
    nz = wp.where(inside, lc, c)
    rx = wp.where(inside, px, bx)
    rz = wp.where(inside, pz, bz)
    lx = wp.where(inside, ax, qx)
    lz = wp.where(inside, az, qz)
    au = wedge(rx, rz, nx, nz)
    bu = dot(rx, rz, nx, nz)
    al = wedge(lx, lz, nx, nz)
    bl = dot(lx, lz, nx, nz)
    return (
        nx, nz, au, bu, al, bl,
        wp.where(inside, bl - lhalf_height, -bu - half_height),
        wp.where(inside, al - side * half_width, side * lhalf_width - au),
    )  # fmt: skip


@wp.func
def gap_of_end(
    side: real, half_width: real, half_height: real, s: real, c: real,
    lhalf_width: real, lhalf_height: real, ls: real, lc: real, dx: real, dz: real,
) -> real:  # fmt: skip
    """How wide an end of an interface gapes [m]; arguments as in `find_end`."""
    _nx, _nz, _au, _bu, _al, _bl, gap, _place = find_end(
        side, half_width, half_height, s, c, lhalf_width, lhalf_height, ls, lc, dx, dz
    )
    return gap


@wp.func
def add_impulses(
    m: real, j: real, lm: real, lj: real, nx: real, nz: real,
    au: real, bu: real, al: real, bl: real, n: real, t: real,
    ux: wp.ref[real], uz: wp.ref[real], uo: wp.ref[real],
    lx: wp.ref[real], lz: wp.ref[real], lo: wp.ref[real],
):  # fmt: skip
    """Adds the impulses n, t of a point to the velocities of its bodies."""
    px = dot(nx, nz, n, t)
    pz = wedge(nz, nx, t, n)
    ux = fused(m, px, ux)
    uz = fused(m, pz, uz)
    uo = fused(j, wedge(bu, au, n, t), uo)
    lx = fused_less(lm, px, lx)
    lz = fused_less(lm, pz, lz)
    lo = fused_less(lj, wedge(bl, al, n, t), lo)


@wp.func
def place_on(
    half_width: real, half_height: real, s: real, c: real, offset: real,
    lhalf_width: real, lhalf_height: real, ls: real, lc: real, dx: real, dz: real, turn: real,
):  # fmt: skip
    """Slide of a block along what it stands on, and the width of the overlap of the faces [m].

    `offset` is the slide that was there at the start, `turn` the rotation of the block against
    what it stands on; (dx, dz) as in `find_end`.
    """
    lean = sign_of(turn)
    # The bottom corners of the block along the lower face: middle + run and middle - run.
    run = lean * half_width * dot(c, s, lc, ls)
    middle = wedge(fused_less(half_height, s, dx), fused_less(half_height, c, dz), ls, lc)
    bx = fused(lean * lhalf_width, lc, fused(lhalf_height, ls, -dx))
    bz = fused_less(lean * lhalf_width, ls, fused(lhalf_height, lc, -dz))
    inside = lean * (middle + run) <= lhalf_width
    place = wp.where(
        inside, middle + run - lean * half_width, lean * lhalf_width - wedge(bx, bz, s, c)
    )
    overlap = smaller(lean * (middle + run), lhalf_width) + smaller(
        lean * (run - middle), lhalf_width
    )
    return place - offset, overlap
