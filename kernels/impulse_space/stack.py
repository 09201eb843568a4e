"""Velocity-level contact step of a stack of blocks in space.

Bodies are numbered from the ground: body 0 is the ground, an endless face that nothing moves, body
k the k-th block. The step is that of the single block (see impulse_space/block.py), body by body;
the contacts of interface k, below block k, are the corners of what the bottom face of block k and
the top face of what it stands on share (see shape/faces.py), found once a step. Their normal is
that of the lower face, their impulses and slips are along its width, its depth and its normal. A
contact at the levers r_u and r_l from the centres of the two blocks sees the velocity

    v_u + omega_u x r_u - v_l - omega_l x r_l.

The sweeps go from the ground up; in an interface they visit the corners in an order that is that
of the mirror image in a mirrored scene. What an interface gives back of its penetration moves all
that stands on it along its normal, but for the 2 g dt^2 that one step of falling can make.
Angular momenta and moments of inertia are those for unit mass, impulses are in N s.
"""

import warp as wp

from warprock.kernels.impulse_space.block import Knobs, drag, holds, slip_gains, stop_gains
from warprock.kernels.shape.faces import SLOTS, Vector, corner, mirrored
from warprock.kernels.shape_space.block import (
    Block,
    in_axes,
    inverse_inertia,
    matrix_of,
    product,
    vector_product,
)

FAR = real(1.0e30)

Matrix = wp.types.matrix(shape=(3, 3), dtype=real)
Attitude = wp.types.vector(length=4, dtype=real)
Gains = wp.types.vector(length=12, dtype=real)

SETTLED = real(1.0e-14)
"""Change of the impulses in a sweep, over their size, that is round-off."""
CONTACTS = 8
"""Contacts of an interface: as many as two rectangles share corners."""
UPPER = 4
"""Slots of the upper face's own corners, the first ones."""
WHOLE = 15
"""Bits of their slots, all set."""

# Rows of bodies, the ground first; three rows a body; rows of contacts; rows of slots.
Bodies = wp.types.matrix(shape=(BLOCKS + 1, 3), dtype=real)
Numbers = wp.types.vector(length=BLOCKS + 1, dtype=real)
Axes = wp.types.matrix(shape=(3 * (BLOCKS + 1), 3), dtype=real)
Points = wp.types.matrix(shape=(CONTACTS * BLOCKS, 3), dtype=real)
PointGains = wp.types.matrix(shape=(CONTACTS * BLOCKS, 12), dtype=real)
PointNumbers = wp.types.vector(length=CONTACTS * BLOCKS, dtype=real)
PointInts = wp.types.vector(length=CONTACTS * BLOCKS, dtype=int)
Corners = wp.types.matrix(shape=(SLOTS, 3), dtype=real)
Chosen = wp.types.vector(length=CONTACTS, dtype=int)
CornerNumbers = wp.types.vector(length=SLOTS, dtype=real)


@wp.func
def frame(q: Attitude) -> Matrix:
    """Rotation matrix of an attitude."""
    r11, r12, r13, r21, r22, r23, r31, r32, r33 = matrix_of(q[0], q[1], q[2], q[3])
    return Matrix(r11, r12, r13, r21, r22, r23, r31, r32, r33)


@wp.func
def weighted(r: Matrix, x: real, y: real, z: real) -> Matrix:
    """R diag(x, y, z) R^T: a moment of inertia, or its inverse, in the axes of the base."""
    xx, xy, xz, yy, yz, zz = inverse_inertia(
        r[0, 0], r[0, 1], r[0, 2], r[1, 0], r[1, 1], r[1, 2], r[2, 0], r[2, 1], r[2, 2], x, y, z
    )
    return Matrix(xx, xy, xz, xy, yy, yz, xz, yz, zz)


@wp.func
def axis_of(r: Matrix, i: int) -> Vector:
    """One of the axes of a body: a column of its rotation matrix."""
    return Vector(r[0, i], r[1, i], r[2, i])


@wp.func
def rows_of(rows: Axes, k: int) -> Matrix:
    """The matrix of a body, of three rows."""
    return Matrix(
        rows[3 * k, 0], rows[3 * k, 1], rows[3 * k, 2],
        rows[3 * k + 1, 0], rows[3 * k + 1, 1], rows[3 * k + 1, 2],
        rows[3 * k + 2, 0], rows[3 * k + 2, 1], rows[3 * k + 2, 2],
    )  # fmt: skip


@wp.func
def gains_of(both: real, e: Matrix, ju: Matrix, jl: Matrix, ru: Vector, rl: Vector) -> Gains:
    """What impulses at a contact do: pn, p1 to 3, h11 to 33, kx, ky; see impulse_space/block.py.

    Args:
        both: Sum of the inverse masses of its bodies [1/kg].
        e: Its directions, one a row.
        ju, jl: Inverse inertia of the upper body [1/(kg m^2)] and of the lower one.
        ru, rl: Levers from the upper and the lower centre of mass [m].
    """
    one = real(1.0)
    u1, u2, u3 = wp.cross(ru, e[0]), wp.cross(ru, e[1]), wp.cross(ru, e[2])
    l1, l2, l3 = wp.cross(rl, e[0]), wp.cross(rl, e[1]), wp.cross(rl, e[2])
    k11 = both + wp.dot(u1, ju * u1) + wp.dot(l1, jl * l1)
    k12 = wp.dot(u1, ju * u2) + wp.dot(l1, jl * l2)
    k13 = wp.dot(u1, ju * u3) + wp.dot(l1, jl * l3)
    k22 = both + wp.dot(u2, ju * u2) + wp.dot(l2, jl * l2)
    k23 = wp.dot(u2, ju * u3) + wp.dot(l2, jl * l3)
    k33 = both + wp.dot(u3, ju * u3) + wp.dot(l3, jl * l3)
    p1, p2, p3 = slip_gains(one, k11, k12, k22)
    h11, h12, h13, h22, h23, h33 = stop_gains(one, k11, k12, k13, k22, k23, k33)
    return Gains(one / k33, p1, p2, p3, h11, h12, h13, h22, h23, h33, k13, k23)


@wp.func
def velocity_at(v: Vector, o: Vector, r: Vector) -> Vector:
    """Velocity of a point of a block at the lever r from its centre of mass [m/s]."""
    return Vector(
        fused_less(o[2], r[1], fused(o[1], r[2], v[0])),
        fused_less(o[0], r[2], fused(o[2], r[0], v[1])),
        fused_less(o[1], r[0], fused(o[0], r[1], v[2])),
    )


@wp.func
def relative_velocity(
    vu: Vector, ou: Vector, ru: Vector, vl: Vector, ol: Vector, rl: Vector
) -> Vector:
    """Velocity of a contact on the upper block as seen from the lower one [m/s]."""
    return velocity_at(vu, ou, ru) - velocity_at(vl, ol, rl)


@wp.func
def parts_along(e: Matrix, v: Vector):
    """The parts of a vector along three directions, one a row."""
    return in_axes(
        e[0, 0], e[0, 1], e[0, 2], e[1, 0], e[1, 1], e[1, 2], e[2, 0], e[2, 1], e[2, 2],
        v[0], v[1], v[2],
    )  # fmt: skip


@wp.func
def pushed(v: Vector, light: real, p: Vector) -> Vector:
    """The velocity v of a block of the inverse mass `light` after the impulse p [m/s]."""
    return Vector(fused(light, p[0], v[0]), fused(light, p[1], v[1]), fused(light, p[2], v[2]))


@wp.func
def spun(o: Vector, j: Matrix, r: Vector, p: Vector) -> Vector:
    """The angular velocity o of a block, its inverse inertia j, after an impulse p at r [rad/s]."""
    x, y, z = vector_product(r[0], r[1], r[2], p[0], p[1], p[2])
    return Vector(
        fused(j[0, 2], z, fused(j[0, 1], y, fused(j[0, 0], x, o[0]))),
        fused(j[1, 2], z, fused(j[1, 1], y, fused(j[1, 0], x, o[1]))),
        fused(j[2, 2], z, fused(j[2, 1], y, fused(j[2, 0], x, o[2]))),
    )


@wp.func
def solve_contact(
    mu: real, gap: real, rate: real, gains: Gains, e: Matrix, ru: Vector, rl: Vector, p: Vector,
    vu: Vector, ou: Vector, vl: Vector, ol: Vector,
) -> Vector:  # fmt: skip
    """Gauss-Seidel on the impulses p of a contact, along its directions: what they become [N s].

    Arguments as in `gains_of`; v and o with u or l are the velocities and angular velocities of the
    upper and the lower body.
    """
    zero, g = real(0.0), gains
    x, y, parting = parts_along(e, relative_velocity(vu, ou, ru, vl, ol, rl))
    z = fused(larger(gap, zero), rate, parting)
    stop_x = p[0] - product(g[4], g[5], g[6], x, y, z)
    stop_y = p[1] - product(g[5], g[7], g[8], x, y, z)
    stop_z = p[2] - product(g[6], g[8], g[9], x, y, z)
    if holds(stop_x, stop_y, stop_z, mu):
        return Vector(stop_x, stop_y, stop_z)
    push = larger(fused_less(g[0], z, p[2]), zero)
    # The slip that the normal impulse leaves.
    more = push - p[2]
    slip_x, slip_y = fused(more, g[10], x), fused(more, g[11], y)
    fx, fy = drag(mu * push, p[0], p[1], slip_x, slip_y, g[1], g[2], g[3])
    return Vector(fx, fy, push)


@wp.func
def solve(
    sweeps: int, total: int, rate: real, mu: Numbers, light: Numbers, axes: Axes, ease: Axes,
    body: PointInts, gap: PointNumbers, ru: Points, rl: Points, first: Points, v: Bodies, w: Bodies,
):  # fmt: skip
    """Projected Gauss-Seidel on all contacts: their impulses, and the velocities of the bodies.

    Args:
        sweeps: How many at most; they end once one has changed next to nothing.
        total: Number of contacts.
        rate: Inverse of the time step [1/s].
        mu: Friction coefficient under each body.
        light: Inverse mass of each body [1/kg].
        axes: Axes of each body, three rows; a lower body's are the directions of a contact.
        ease: Inverse inertia of each body [1/(kg m^2)], three rows.
        body: Upper body of each contact.
        gap: Gap of each contact [m].
        ru, rl: Levers of each contact from the upper and the lower centre of mass [m].
        first: Impulses to start from [N s].
        v, w: Velocity [m/s] and angular velocity [rad/s] of each body without contact.
    """
    u, o, p, gains = Bodies(), Bodies(), Points(), PointGains()
    bodies = int(BLOCKS + 1)
    for k in range(bodies):
        u[k] = v[k]
        o[k] = w[k]
    for step in range(-1, sweeps):
        change, whole = real(0.0), real(0.0)
        for i in range(total):
            k = body[i]
            low = k - 1
            e, ju, jl = rows_of(axes, low), rows_of(ease, k), rows_of(ease, low)
            new = first[i]
            if step < 0:
                gains[i] = gains_of(light[k] + light[low], e, ju, jl, ru[i], rl[i])
            else:
                new = solve_contact(
                    mu[k], gap[i], rate, gains[i], e, ru[i], rl[i], p[i], u[k], o[k], u[low], o[low]
                )
            more = wp.transpose(e) * (new - p[i])
            change += wp.dot(more, more)
            whole += wp.dot(new, new)
            p[i] = new
            u[k] = pushed(u[k], light[k], more)
            o[k] = spun(o[k], ju, ru[i], more)
            # The ground does not move.
            if low > 0:
                u[low] = pushed(u[low], light[low], -more)
                o[low] = spun(o[low], jl, rl[i], -more)
        if step >= 0 and change <= SETTLED * SETTLED * whole:
            break
    return p, u, o


@wp.func
def fastest_slip(
    total: int, axes: Axes, body: PointInts, ru: Points, rl: Points, u: Bodies, o: Bodies
) -> real:
    """Square of the speed at which the fastest contact slides [m^2/s^2]; see `solve`."""
    most = real(0.0)
    for i in range(total):
        k = body[i]
        v = relative_velocity(u[k], o[k], ru[i], u[k - 1], o[k - 1], rl[i])
        x, y, _z = parts_along(rows_of(axes, k - 1), v)
        most = larger(most, dot(x, y, x, y))
    return most


@wp.func
def visited(slot: int, lean: Vector) -> int:
    """Slot that is visited in the turn of another, where a block leans to the sides given."""
    zero = real(0.0)
    return mirrored(slot, wp.where(lean[0] < zero, 1, 0), wp.where(lean[1] < zero, 1, 0))


@wp.func
def shared_corners(block: Block, below: Block, m: Matrix, c: Vector, lean: Vector):
    """Corners of what two faces share, by slot (see shape/faces.py), found in a mirror image.

    Args:
        block: The upper block.
        below: The lower one.
        m: Attitude of the upper block as seen from the lower one.
        c: Its centre of mass from that of the lower one, in the axes of that [m].
        lean: Sides, -1 or 1, along x and y: where -1, the image is mirrored.

    Returns:
        The points from the lower centre of mass, in the lower axes and not mirrored [m]; the gaps
        [m]; and in the bits of a number which of them there are.
    """
    sx, sy = lean[0], lean[1]
    x = c[0] + below.centre_x - m[0, 0] * block.centre_x - m[0, 1] * block.centre_y
    y = c[1] + below.centre_y - m[1, 0] * block.centre_x - m[1, 1] * block.centre_y
    z = c[2] - below.half_height - m[2, 0] * block.centre_x - m[2, 1] * block.centre_y
    h = block.half_height
    middle = Vector(sx * (x - h * m[0, 2]), sy * (y - h * m[1, 2]), z - h * m[2, 2])
    d = Vector(m[0, 0], sx * sy * m[1, 0], sx * m[2, 0])
    e = Vector(sx * sy * m[0, 1], m[1, 1], sy * m[2, 1])
    places, gaps, there, s = Corners(), CornerNumbers(), int(0), int(0)
    # A face whose corners all lie over the other shares them alone.
    while s < wp.where(there == WHOLE, UPPER, int(SLOTS)):
        point, exists = corner(
            s, middle, d, e, block.half_width, block.half_depth, below.half_width, below.half_depth
        )
        t = visited(s, lean)
        places[t] = Vector(
            sx * point[0] - below.centre_x,
            sy * point[1] - below.centre_y,
            point[2] + below.half_height,
        )
        gaps[t] = point[2]
        there = there | wp.where(exists, 1 << t, 0)
        s += 1
    return places, gaps, there


@wp.func
def find_contacts(gaps: CornerNumbers, there: int, lean: Vector, was: int, knobs: Knobs):
    """The contacts among the corners of what two faces share.

    Args:
        gaps: Gaps by slot [m].
        there: Bits of the slots that there are.
        lean: Sides to which the upper block leans, for the order of the contacts.
        was: Bits of the slots that did not touch in the last step.
        knobs: Settings.

    Returns:
        Slots of the contacts and their number; bits of the slots that do not touch now; 1 where one
        touches that did not; the deepest penetration [m]; and what the interface gives back [m].
    """
    zero = real(0.0)
    slack = real(2.0) * knobs.time_step * knobs.time_step * knobs.gravity
    chosen, number, wide, lands, deep = Chosen(), int(0), int(0), int(0), real(-FAR)
    slots = wp.where(there == WHOLE, UPPER, int(SLOTS))
    for s in range(slots):
        t = visited(s, lean)
        bit = 1 << t
        if (there & bit) != 0:
            deep = larger(deep, -gaps[t])
            if gaps[t] > knobs.collision_margin + slack:
                wide = wide | bit
            elif (was & bit) != 0:
                lands = 1
            if gaps[t] <= knobs.collision_margin and number < CONTACTS:
                chosen[number] = t
                number += 1
    return chosen, number, wide, lands, deep, knobs.erp * larger(deep - slack, zero)
