"""How one block in space slides with friction as a box.

Each corner is assumed to stick or to slide to one side, along x and along y. Where it slides, the
friction is at its bound, against the slip. The impulses of a corner, or of both corners of an edge,
then solve a linear system. Opposite impulses of both ends along an edge do not change the motion.
A relative stiffness `SOFT` makes them unique; `AGAIN` corrections remove its effect on the motion.

A flat block, whose corners carry given parts of its weight, takes the motion (v_x, v_y, w_z) that
minimises a convex function. See event_space/block/box_friction.py.
"""

import warp as wp

from warprock.kernels.algebra.vectors import Vector, X, Y, Z
from warprock.kernels.event_space.block.contact import (
    EDGE,
    FLAT,
    Body,
    Corners,
    Held,
    Shares,
    corner_velocity,
    face_shares,
    lies_inside,
    mask_of,
    sinks,
    velocity_by_impulse,
)

ROUNDS = 200
"""Largest number of rounds between the pressure under a face and its friction."""
STRAIGHT = 10
"""Rounds that take the whole change of the pressure. Later ones take half of it."""
AGAIN = 4
"""Corrections that remove the effect of `SOFT` on the motion."""
SOFT = by_precision(1.0e-9, 1.0e-3)
"""Stiffness that makes opposite impulses at the ends of an edge unique, over that of the block."""
PULLED = by_precision(1.0e-6, 0.1)
"""Pull over the impulses that is no error of `SOFT`."""
ALIKE = by_precision(1.0e-14, 1.0e-6)
"""Round-off of a velocity, as a part of the largest."""
FULL = by_precision(1.0 - 1.0e-9, 1.0 - 1.0e-4)
"""Part of its bound above which friction counts as used up."""
OVER = by_precision(1.0 + 1.0e-12, 1.0 + 1.0e-5)
"""Part of its bound up to which friction counts as within it."""

Six = wp.types.vector(length=6, dtype=real)
"""Impulses, or velocities, of both ends of an edge: along x, y and z of the first, then of the
second."""
SECOND = 3
"""Place of the second end in `Six`."""
Gains = wp.types.matrix(shape=(6, 6), dtype=real)
"""Velocities of both ends of an edge, a row a number of `Six`, by unit impulses there, a column."""


@wp.func
def side_of(u: real) -> real:
    """Sign of a velocity: -1, 0 or 1."""
    one, zero = real(1.0), real(0.0)
    return wp.where(u > zero, one, wp.where(u < zero, -one, zero))


@wp.func
def slips_of(k: int, fx: real, fy: real, most_x: real, most_y: real, u: Vector, dust: real) -> int:
    """Bits of `slip` of corner k: set where its friction is at the bound and it moves."""
    x = size(fx) >= FULL * most_x and size(u[0]) > dust
    y = size(fy) >= FULL * most_y and size(u[1]) > dust
    return wp.where(x, 1 << k, 0) | wp.where(y, 16 << k, 0)


@wp.func
def gains_of(body: Body, i: int, j: int) -> Gains:
    """Velocities of corners i and j by unit impulses at both; i = j means one corner."""
    a = Gains()
    for column in range(6):
        one = Vector()
        one[column % 3] = real(1.0)
        source = wp.where(column < 3, i, j)
        first = velocity_by_impulse(body, source, one, i)
        second = velocity_by_impulse(body, source, one, j)
        for row in range(3):
            single_corner = i == j and column >= 3
            a[row, column] = wp.where(single_corner, real(0.0), first[row])
            a[3 + row, column] = wp.where(i == j and column < 3, real(0.0), second[row])
    return a


@wp.func
def factorize(system: Gains) -> Gains:
    """LU factors of a matrix, in one matrix."""
    a = system
    for k in range(6):
        for i in range(k + 1, 6):
            a[i, k] = a[i, k] / a[k, k]
            for j in range(k + 1, 6):
                a[i, j] = a[i, j] - a[i, k] * a[k, j]
    return a


@wp.func
def solve_factored(lu: Gains, right: Six) -> Six:
    """The solution of a linear system from its LU factors."""
    x = right
    for i in range(6):
        for j in range(i):
            x[i] = x[i] - lu[i, j] * x[j]
    for back in range(6):
        i = 5 - back
        for j in range(i + 1, 6):
            x[i] = x[i] - lu[i, j] * x[j]
        x[i] = x[i] / lu[i, i]
    return x


@wp.func
def solve_corners(
    body: Body, i: int, j: int, gains: Gains, sides: Corners, pulls: bool, v: Vector, w: Vector
) -> Six:  # fmt: skip
    """Impulses of two corners that stay on the base and stick or slide as given.

    Args:
        body: The block.
        i, j: Two corners; the same number twice for one corner.
        gains: `gains_of` these corners.
        sides: Of all corners along x and y: -1 or 1 if it slides to that side, 0 if it sticks.
        pulls: Whether the base may pull at a corner. Else impulses that do are left as they are
            found at first, which takes a third of the time.
        v: Velocity without these impulses [m/s].
        w: Angular velocity without them [rad/s].
    """
    zero, one = real(0.0), real(1.0)
    rows = gains
    soft = Gains()
    right = Six()
    for c in range(2):
        k = wp.where(c == 0, i, j)
        u = corner_velocity(body, v, w, k)
        for axis in range(3):
            r = 3 * c + axis
            right[r] = -u[axis]
            soft[r, r] = SOFT * rows[r, r]
            if axis < 2 and sides[k, axis] != zero:
                for column in range(6):
                    rows[r, column] = zero
                rows[r, r] = one
                rows[r, 3 * c + 2] = body.friction * sides[k, axis]
                right[r] = zero
                soft[r, r] = zero
    lu = factorize(rows + soft)
    p = solve_factored(lu, right)
    least = -PULLED * wp.length(p)
    if pulls or (p[Z] >= least and p[SECOND + Z] >= least):
        for _again in range(AGAIN):
            p = p + solve_factored(lu, right - rows * p)
    return p


@wp.func
def apply_impulses(body: Body, i: int, j: int, p: Six, v: Vector, w: Vector):
    """Velocities after impulses at corners i and j; if i = j, the first three numbers count."""
    first = Vector(p[X], p[Y], p[Z])
    second = Vector(p[SECOND + X], p[SECOND + Y], p[SECOND + Z])
    v_after = v + first
    w_after = w + body.inverse * wp.cross(body.corners[i], first)
    if i != j:
        v_after = v_after + second
        w_after = w_after + body.inverse * wp.cross(body.corners[j], second)
    return v_after, w_after


@wp.func
def ends_of(stance: int):
    """Both corners of an edge; of a stance on one corner, that corner twice."""
    i = stance % 4
    return i, wp.where(stance >= EDGE, (i + 1) % 4, i)


@wp.func(inline=False)
def try_sides(
    body: Body, stance: int, mask: int, gains: Gains, sides: Corners, v: Vector, w: Vector,
    dust: real,
) -> Held:  # fmt: skip
    """The motion if the ends of a stance stick or slide as given; `fits` if it obeys the law."""
    h = Held()
    h.stance = stance
    i, j = ends_of(stance)
    p = solve_corners(body, i, j, gains, sides, False, v, w)
    v_after, w_after = apply_impulses(body, i, j, p, v, w)
    h.v = v_after
    h.w = w_after
    h.fits = True
    for c in range(wp.where(i == j, 1, 2)):
        k = wp.where(c == 0, i, j)
        u = corner_velocity(body, v_after, w_after, k)
        most = body.friction * p[3 * c + 2]
        h.fits = h.fits and most >= real(0.0) and size(u[2]) <= dust
        for axis in range(2):
            side = sides[k, axis]
            within = size(p[3 * c + axis]) <= OVER * most and size(u[axis]) <= dust
            if side != real(0.0):
                within = side * u[axis] >= -dust
            h.fits = h.fits and within
            h.work -= u[axis] * p[3 * c + axis]
        h.slip = h.slip | slips_of(k, p[3 * c], p[3 * c + 1], most, most, u, dust)
    h.fits = h.fits and not sinks(body, v_after, w_after, mask & ~mask_of(stance), dust)
    return h


@wp.func
def flat_velocity(body: Body, z: Vector, k: int) -> Vector:
    """Velocity of corner k in a flat block's motion (v_x, v_y, w_z)."""
    return Vector(z[0] - z[2] * body.corners[k, 1], z[1] + z[2] * body.corners[k, 0], real(0.0))


@wp.func
def arm_of(body: Body, axis: int, k: int) -> real:
    """Velocity of corner k along x or y by a unit spin of a flat block [m]."""
    return wp.where(axis == 0, -body.corners[k, 1], body.corners[k, 0])


@wp.func
def solve_axis(body: Body, most: Corners, free: real, axis: int, spin: real, side: real):
    """Velocity of a flat block along x or y under friction along that axis, given its spin.

    The friction of a corner jumps where its velocity passes zero. The velocity is the one at which
    the sum of these jumps balances the velocity without friction.

    Args:
        body: The block.
        most: Largest friction of each corner along x and y [m/s].
        free: Velocity without friction [m/s].
        axis: 0 for x, 1 for y.
        spin: Angular velocity [rad/s].
        side: Sign that counts if the spin is zero.

    Returns:
        The velocity; the friction impulses; square of the arm of the corner that sticks, if any.
    """
    f = Shares()
    velocity = free
    bend = real(0.0)
    for k in range(4):
        arm = arm_of(body, axis, k)
        pull = -arm * spin - free
        for j in range(4):
            apart = (arm_of(body, axis, j) - arm) * wp.where(spin == real(0.0), side, spin)
            apart = wp.where(apart == real(0.0), real(k - j), apart)
            before = wp.where(apart > real(0.0), most[j, axis], -most[j, axis])
            pull += wp.where(j == k, real(0.0), before)
        f[k] = larger(smaller(pull, most[k, axis]), -most[k, axis])
        velocity += f[k]
        if f[k] == pull:
            bend = arm * arm
    return velocity, f, bend


@wp.func(inline=False)
def evaluate_spin(body: Body, most: Corners, free: Vector, spin: real, side: real):
    """Velocities by `solve_axis` at a spin; the excess of the spin, and its slope."""
    lighter = real(1.0) / body.inertia[2, 2]
    x, fx, bend_x = solve_axis(body, most, free[0], 0, spin, side)
    y, fy, bend_y = solve_axis(body, most, free[1], 1, spin, side)
    f = Corners()
    over = spin - free[2]
    for k in range(4):
        f[k] = Vector(fx[k], fy[k], real(0.0))
        over -= lighter * (arm_of(body, 0, k) * fx[k] + arm_of(body, 1, k) * fy[k])
    return Vector(x, y, spin), f, over, real(1.0) + lighter * (bend_x + bend_y)


@wp.func(inline=False)
def solve_flat_friction(body: Body, most: Corners, free: Vector):
    """Motion of a flat block (v_x, v_y, w_z) after friction.

    The spin is the root of an increasing, piecewise linear function: Newton's method, bracketed.

    Args:
        body: The block.
        most: Largest friction of each corner along x and y [m/s].
        free: The motion without friction.

    Returns:
        The motion, and the friction of each corner.
    """
    zero, one = real(0.0), real(1.0)
    z, f, above, _first = evaluate_spin(body, most, free, zero, one)
    _z, f0, below, _second = evaluate_spin(body, most, free, zero, -one)
    reach = real(0.0)
    for k in range(4):
        far = size(body.corners[k, 0]) + size(body.corners[k, 1])
        reach += far * (most[k, 0] + most[k, 1]) / body.inertia[2, 2]
    if below <= zero and above >= zero:
        part = wp.where(above > below, above / larger(above - below, TINY), zero)
        f = f + part * (f0 - f)
    else:
        least = wp.where(above < zero, zero, smaller(free[2], zero) - reach)
        largest = wp.where(above < zero, larger(free[2], zero) + reach, zero)
        spin = free[2]
        over = one
        tries = int(0)
        while size(over) > ALIKE * (size(free[2]) + reach) and tries < ROUNDS:
            if spin <= least or spin >= largest:
                spin = HALF * (least + largest)
            z1, f1, over1, slope1 = evaluate_spin(body, most, free, spin, one)
            z = z1
            f = f1
            over = over1
            least = wp.where(over < zero, spin, least)
            largest = wp.where(over > zero, spin, largest)
            spin = spin - over / slope1
            tries += 1
    return z, f


@wp.func
def clip_shares(shares: Shares) -> Shares:
    """Shares of the corners, zero for those that would pull; their sum stays one."""
    found = shares
    total = real(0.0)
    for k in range(4):
        found[k] = larger(shares[k], real(0.0))
        total += found[k]
    return found / total


@wp.func(inline=False)
def try_flat_sliding(body: Body, v: Vector, w: Vector, dust: real) -> Held:
    """The motion of a flat block that slides or stops; `fits` if it obeys the contact law."""
    zero = real(0.0)
    h = Held()
    h.stance = FLAT
    push = -v[2]
    spin = body.inertia * w
    low = -body.corners[0, 2]
    free = Vector(v[0], v[1], w[2])
    n = Shares(real(0.25), real(0.25), real(0.25), real(0.25)) * larger(push, zero)
    z = free
    f = Corners()
    most = Corners()
    x = real(0.0)
    y = real(0.0)
    enough = real(10.0) * ALIKE * (wp.length(v) + size(w[2]) * wp.length(body.corners[0]))
    change = larger(push, zero)
    tries = int(0)
    while change > enough and tries < ROUNDS:
        total = Vector()
        for k in range(4):
            most[k] = body.friction * Vector(n[k], n[k], zero)
        z1, f1 = solve_flat_friction(body, most, free)
        z = z1
        f = f1
        for k in range(4):
            total = total + f1[k]
        x = (spin[1] - low * total[0]) / larger(push, TINY)
        y = (-spin[0] - low * total[1]) / larger(push, TINY)
        more = push * clip_shares(face_shares(body, x, y)) - n
        change = wp.length(more)
        n = n + more * wp.where(tries < STRAIGHT, real(1.0), real(0.5))
        tries += 1
    h.v = Vector(z[0], z[1], zero)
    h.w = Vector(zero, zero, z[2])
    for k in range(4):
        u = flat_velocity(body, z, k)
        h.slip = h.slip | slips_of(k, f[k, 0], f[k, 1], most[k, 0], most[k, 1], u, dust)
        h.work -= u[0] * f[k, 0] + u[1] * f[k, 1]
    h.fits = push >= zero and tries < ROUNDS and lies_inside(body, x, y)
    return h
