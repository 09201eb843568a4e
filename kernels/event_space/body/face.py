"""How the face of a body in space presses on its base, sticks there and slides.

Three or more touching points that span a plane are a face: the body can only turn about the
vertical. The distribution of the normal impulses on the points is not unique. It is taken as that
of a bed of equal springs,

    n = a + b.(r - m), none below zero,

found in rounds from the sum and the moments of n. If the rounds do not end, because the centre of
pressure is close to the rim of few points, three corners of the hull carry the impulse.

A face sticks if friction in proportion to n can hold it, as one motion along the base and a turn
about the centre of pressure. If it slides, its motion (v_x, v_y, w_z) is the least of

    |v - v_free|^2 / 2 + I_zz (w_z - w_free)^2 / 2 + mu sum n_k |u_k|,

u_k the velocity of point k. Newton's method finds it. If a step would reverse the velocity of a
point, friction is viscous in that step, mu n_k / |u_k|, which never goes too far (Weiszfeld 1937).
"""

import warp as wp

from warprock.kernels.algebra.vectors import Matrix, Vector
from warprock.kernels.event_space.block.contact import BOX
from warprock.kernels.event_space.body.contact import (
    Carried,
    PointNumbers,
    Pose,
    Shape,
    Touches,
    bit_of,
)
from warprock.kernels.shape_space.body import APART, spans

ROUNDS = 20
"""Largest number of rounds that find the pressing points: of random bases and loads one in a
hundred needs more than five."""
TURNS = 200
"""Most steps of Newton's method."""
LEAST = real(0.125)
"""Least part of its change that the pressure takes in a round if the whole leaves the face."""
SETTLED = by_precision(1.0e-13, 1.0e-6)
"""Change of velocities and impulses in a step, over those without contact, that is round-off."""
GOOD = by_precision(1.0e-9, 1.0e-4)
"""Change above which a search that has not converged has failed."""
INSIDE = by_precision(1.0 - 1.0e-9, 1.0 - 1.0e-4)
"""Largest friction of a point that counts as sticking, over its bound."""


@wp.func
def sticks(p: Vector, most: real) -> bool:
    """Whether the friction of a point lies within a bound, of the cone or of the box."""
    if not BOX:
        return wp.sqrt(p[0] * p[0] + p[1] * p[1]) < most
    return size(p[0]) < most and size(p[1]) < most


@wp.func
def next_on_hull(t: Touches, least: real, i: int) -> int:
    """The point after point i on the convex hull of the touching points, in plan; i if none.

    Points whose squared distance is below `least` are one [m^2].
    """
    j, total = int(i), t.total
    for k in range(total):
        ax, ay = t.lever[j][0] - t.lever[i][0], t.lever[j][1] - t.lever[i][1]
        bx, by = t.lever[k][0] - t.lever[i][0], t.lever[k][1] - t.lever[i][1]
        side = ax * by - ay * bx
        apart = bx * bx + by * by
        farther = side == real(0.0) and apart > ax * ax + ay * ay
        if apart > least:
            j = wp.where(j == i or side < real(0.0) or farther, k, j)
    return j


@wp.func
def first_on_hull(t: Touches) -> int:
    """A corner of the convex hull of the touching points: the one with the least x."""
    first, total = int(0), t.total
    for k in range(total):
        first = wp.where(t.lever[k][0] < t.lever[first][0], k, first)
    return first


@wp.func
def press_on_three(s: Shape, t: Touches, normal_sum: real, along_x: real, along_y: real):
    """Normal impulses on three corners of the hull; whether any three can carry the load."""
    zero, one = real(0.0), real(1.0)
    n, carried, total, least = PointNumbers(), bool(False), t.total, APART * s.reach * s.reach
    a = first_on_hull(t)
    x, y = along_x / normal_sum - t.lever[a][0], along_y / normal_sum - t.lever[a][1]
    i, turns = next_on_hull(t, least, a), int(0)
    while not carried and turns < total:
        j = next_on_hull(t, least, i)
        ix, iy = t.lever[i][0] - t.lever[a][0], t.lever[i][1] - t.lever[a][1]
        jx, jy = t.lever[j][0] - t.lever[a][0], t.lever[j][1] - t.lever[a][1]
        over = one / larger(ix * jy - iy * jx, TINY)
        of_i, of_j = over * (x * jy - y * jx), over * (ix * y - iy * x)
        if of_i >= zero and of_j >= zero and of_i + of_j <= one:
            carried = bool(True)
            n[a] = normal_sum * (one - of_i - of_j)
            n[i] = normal_sum * of_i
            n[j] = normal_sum * of_j
        i = int(j)
        turns = wp.where(j == a, total, turns + 1)
    return n, carried


@wp.func
def find_pressure(s: Shape, t: Touches, normal_sum: real, along_x: real, along_y: real):
    """Normal impulses of the touching points [m/s]; whether they can carry the load.

    Args:
        s: The body.
        t: The points.
        whole: Sum of the impulses.
        along_x, along_y: Sums of them times x and y [m^2/s].
    """
    zero, one, total = real(0.0), real(1.0), t.total
    n, settled, turns = PointNumbers(), bool(False), int(0)
    for k in range(total):
        n[k] = one
    while not settled and turns < ROUNDS:
        count, mx, my, xx, xy, yy = real(0.0), real(0.0), real(0.0), real(0.0), real(0.0), real(0.0)
        for k in range(total):
            if n[k] > zero:
                count += one
                mx += t.lever[k][0]
                my += t.lever[k][1]
        part = one / larger(count, one)
        mx = mx * part
        my = my * part
        for k in range(total):
            if n[k] > zero:
                x, y = t.lever[k][0] - mx, t.lever[k][1] - my
                xx += x * x
                xy += x * y
                yy += y * y
        over = one / larger(xx * yy - xy * xy, TINY)
        gx, gy = along_x - normal_sum * mx, along_y - normal_sum * my
        bx, by = over * (yy * gx - xy * gy), over * (xx * gy - xy * gx)
        settled = bool(True)
        for k in range(total):
            now = part * normal_sum + bx * (t.lever[k][0] - mx) + by * (t.lever[k][1] - my)
            settled = settled and (now > zero) == (n[k] > zero)
            n[k] = larger(now, zero)
        turns += 1
        if not spans(count, xx, xy, yy):
            settled = bool(False)
            turns = ROUNDS
    if not settled and normal_sum > zero:
        n3, carried = press_on_three(s, t, normal_sum, along_x, along_y)
        n = n3
        settled = carried
    return n, settled


@wp.func(inline=False)
def move_pressure(
    s: Shape, t: Touches, n: PointNumbers, normal_sum: real, more_x: real, more_y: real
):
    """As `find_pressure`, for normal impulses n whose moments change by given amounts."""
    mx, my, total = real(more_x), real(more_y), t.total
    for k in range(total):
        mx += n[k] * t.lever[k][0]
        my += n[k] * t.lever[k][1]
    now, carried = find_pressure(s, t, normal_sum, mx, my)
    return now, carried


@wp.func(inline=False)
def stick_flat(s: Shape, pose: Pose, t: Touches, v: Vector, w: Vector) -> Carried:
    """The motion if the face sticks, zero; whether it can.

    No point is held if the centre of pressure would leave the face.
    """
    zero, one, total = real(0.0), real(1.0), t.total
    c = Carried()
    if v[2] < zero:
        momentum, low = pose.inertia * w, real(0.0)
        for k in range(total):
            low += t.lever[k][2] / real(total)
        n, carried = find_pressure(s, t, -v[2], momentum[1] - low * v[0], -momentum[0] - low * v[1])
        fits = bool(carried)
        cx, cy, square = real(0.0), real(0.0), real(0.0)
        part = -one / v[2]
        for k in range(total):
            cx += part * n[k] * t.lever[k][0]
            cy += part * n[k] * t.lever[k][1]
        for k in range(total):
            x, y = t.lever[k][0] - cx, t.lever[k][1] - cy
            square += n[k] * (x * x + y * y)
        turn = (cx * v[1] - cy * v[0] - momentum[2]) / larger(square, TINY)
        for k in range(total):
            if n[k] > zero:
                x, y = t.lever[k][0] - cx, t.lever[k][1] - cy
                p = n[k] * Vector(-part * v[0] - turn * y, -part * v[1] + turn * x, one)
                fits = fits and sticks(p, INSIDE * s.friction * n[k])
                c.held = c.held | bit_of(t.which[k])
        c.fits = fits
        c.held = wp.where(carried, c.held, wp.uint64(0))
        c.stuck = c.held
    return c


@wp.func
def viscous_factor(x: real, y: real):
    """Reciprocal of a speed along the base, by which viscous friction multiplies the velocity.

    For the box along x and y separately.
    """
    a, b = real(1.0) / larger(size(x), TINY), real(1.0) / larger(size(y), TINY)
    if not BOX:
        a = real(1.0) / larger(wp.sqrt(x * x + y * y), TINY)
        b = a
    return a, b


@wp.func
def face_step(s: Shape, t: Touches, n: PointNumbers, spin: real, free: Vector, z: Vector):
    """Newton's step for the motion (v_x, v_y, w_z) of a face that slides, pressed by n.

    Also the viscous step, and the moments of the friction: sums of z p_x and of z p_y. `spin` is
    the moment of inertia about the vertical for unit mass [m^2].
    """
    zero, one, total = real(0.0), real(1.0), t.total
    bend, drag = wp.diag(Vector(one, one, spin)), wp.diag(Vector(one, one, spin))
    rest = Vector(z[0] - free[0], z[1] - free[1], spin * (z[2] - free[2]))
    lift_x, lift_y = real(0.0), real(0.0)
    for k in range(total):
        r, most = t.lever[k] + Vector(), s.friction * n[k]
        ux, uy = z[0] - z[2] * r[1], z[1] + z[2] * r[0]
        a, b = viscous_factor(ux, uy)
        px, py = most * a * ux, most * b * uy
        rest += Vector(px, py, r[0] * py - r[1] * px)
        lift_x -= r[2] * px
        lift_y -= r[2] * py
        gx, gy = Vector(one, zero, -r[1]), Vector(zero, one, r[0])
        drag += most * (a * wp.outer(gx, gx) + b * wp.outer(gy, gy))
        if not BOX:
            across = (a * ux) * gy - (a * uy) * gx
            bend += most * a * wp.outer(across, across)
    return -(wp.inverse(bend) * rest), -(wp.inverse(drag) * rest), lift_x, lift_y


@wp.func
def turns_back(t: Touches, n: PointNumbers, z: Vector, more: Vector) -> bool:
    """Whether a change of the motion of a face reverses the velocity of a pressing point."""
    zero, found, total = real(0.0), bool(False), t.total
    for k in range(total):
        r = t.lever[k] + Vector()
        x, y = z[0] - z[2] * r[1], z[1] + z[2] * r[0]
        x1, y1 = x + more[0] - more[2] * r[1], y + more[1] + more[2] * r[0]
        back = x * x1 + y * y1 < zero
        if BOX:
            back = x * x1 < zero or y * y1 < zero
        found = found or (back and n[k] > zero)
    return found


@wp.func(inline=False)
def slide_flat(s: Shape, pose: Pose, t: Touches, v: Vector, w: Vector) -> Carried:
    """The motion if the face slides, by the head of this file; whether it can."""
    zero, one, total = real(0.0), real(1.0), t.total
    c = Carried()
    momentum, i, normal_sum = pose.inertia * w, pose.inertia + Matrix(), -v[2]
    free = Vector(v[0], v[1], momentum[2] / i[2, 2])
    z, n, on = free + Vector(), PointNumbers(), normal_sum > zero
    for k in range(total):
        n[k] = normal_sum / real(total)
    most = wp.length(v) + s.reach * wp.length(w)
    change, last, part, tries = real(most), NEVER + zero, real(1.0), int(0)
    while on and change > SETTLED * most and tries < TURNS:
        more, gently, lift_x, lift_y = face_step(s, t, n, i[2, 2], free, z)
        if turns_back(t, n, z, more):
            more = gently
        # The first guess: a face that does not spin keeps its direction.
        more = wp.where(tries == 0, zero, one) * more
        z = z + more
        mx, my = lift_x + momentum[1] - i[1, 2] * z[2], lift_y - momentum[0] + i[0, 2] * z[2]
        for k in range(total):
            mx -= n[k] * t.lever[k][0]
            my -= n[k] * t.lever[k][1]
        change = wp.length(Vector(mx, my, zero)) / s.reach
        # Under-relaxation, since pressure and friction depend strongly on each other.
        part = larger(wp.where(change > last, HALF * part, smaller(TWO * part, one)), LEAST)
        last = real(change)
        now, carried = move_pressure(s, t, n, normal_sum, part * mx, part * my)
        if not carried:
            little = LEAST * part
            now, carried = move_pressure(s, t, n, normal_sum, little * mx, little * my)
        on = carried
        n = now
        change += wp.length(Vector(more[0], more[1], s.reach * more[2]))
        change = wp.where(tries == 0, most, change)
        tries += 1
    c.v = Vector(z[0], z[1], zero)
    c.w = Vector(zero, zero, z[2])
    c.fits = on and change <= GOOD * most
    for k in range(total):
        if n[k] > zero:
            u = c.v + wp.cross(c.w, t.lever[k])
            bit = bit_of(t.which[k])
            c.held = c.held | bit
            c.stuck = c.stuck | wp.where(wp.length(u) <= GOOD * most, bit, wp.uint64(0))
    return c
