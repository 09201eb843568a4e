"""Coulomb's law at all contacts of a stack in space, by Newton's method.

A contact answers its velocity u with the impulse f = P(l - c (u + lift n)), where P takes an
impulse to the nearest that its law allows, c is STIFF times the contact's own effective mass, and
lift its gap, or, with mu the friction coefficient and u_t the slip, mu |u_t| in the cone and
mu (|u_x| + |u_y|) in the box.
Where l = f, and lift is that of u, all laws hold (the augmented Lagrangian, with the change of
variable of De Saxce and Feng 1998).

With l and lift given, the velocities make a convex function least, M (v - v_free) = sum G^T f:
Newton's method with the banded matrix M + c sum G^T P' G of six rows a block, steps halved while
they do not descend; then l becomes f, lift that of u, and again until nothing changes but
round-off. Contacts that a face has in excess do no harm.

Where this does not settle, the sweeps of event_space/stack_contact.py do the rest.
"""

import warp as wp

from warprock.kernels.event_space.stack_contact import (
    BOX,
    CONE,
    HOLD,
    HOLD_X,
    HOLD_Y,
    KEEP,
    PUSH,
    SWEEPS,
    Pose,
    Touches,
    directions,
    effective,
    slip_at,
    solve_by_sweeps,
)
from warprock.kernels.shape_space.frame import relative_velocity
from warprock.kernels.shape_space.stack import Bodies, PointNumbers, Points, rows_of
from warprock.kernels.vectors import Matrix, Vector

ROWS = 6 * BLOCKS
BAND = 12
"""Rows of two neighbours: beyond them the matrix is empty."""
STIFF = by_precision(1.0e4, 1.0e2)
ROUNDS = 200
"""Most changes of l."""
LEAP = 8
"""Rounds after which lifts, which come nearer by a part at a time, are taken further at once..."""
AHEAD = real(8.0)
"""...by this multiple of what they changed by."""
TRIES = 30
"""Most of Newton's steps for one l."""
HALVINGS = 8
FIRST = 4
"""Sweeps that choose what each contact does at first."""
ALIKE = by_precision(1.0e-13, 1.0e-5)
"""Change of the velocities in one of Newton's steps, over their size, that ends a round."""

ENOUGH = by_precision(1.0e-14, 1.0e-6)
"""Velocity by which contacts may break their laws, as a part of all velocities..."""
SOUND = by_precision(1.0e-6, 1.0e-4)
"""...and where that many rounds do not come to it."""

DUST = by_precision(1.0e-13, 1.0e-5)
"""Round-off of the convex function."""

Long = wp.types.vector(length=ROWS, dtype=real)
Wide = wp.types.matrix(shape=(ROWS, ROWS), dtype=real)
Slopes = wp.types.matrix(shape=(3, 12), dtype=real)


@wp.func
def boxed(mu: real, z: Vector):
    """Projection of an impulse on the box of friction, and its derivative."""
    zero, one = real(0.0), real(1.0)
    x, y = wp.abs(z[0]), wp.abs(z[1])
    # Beyond their bounds: none, the larger part, both.
    fits_x, fits_y, push = bool(True), bool(True), z[2]
    if larger(x, y) > mu * push:
        push = (z[2] + mu * larger(x, y)) / (one + mu * mu)
        fits_x, fits_y = x < y, y <= x
        if smaller(x, y) > mu * push:
            push = (z[2] + mu * (x + y)) / (one + mu * mu + mu * mu)
            fits_x = False
            fits_y = False
    f, slope = Vector(), Matrix()
    if push > zero:
        g = Vector(
            wp.where(fits_x, zero, wp.sign(z[0]) * mu),
            wp.where(fits_y, zero, wp.sign(z[1]) * mu), one,
        )  # fmt: skip
        slope = wp.outer(g, g) / wp.dot(g, g)
        f = push * g
        if fits_x:
            f[0] = z[0]
            slope[0, 0] = one
        if fits_y:
            f[1] = z[1]
            slope[1, 1] = one
    return f, slope


@wp.func
def allowed(law: int, mu: real, z: Vector):
    """Projection of an impulse on those that a law allows, and its derivative."""
    zero, one = real(0.0), real(1.0)
    f, slope = Vector(), Matrix()
    if law == HOLD:
        return z, wp.identity(n=3, dtype=real)
    if law == KEEP or (law == PUSH and z[2] > zero):
        f[2] = z[2]
        slope[2, 2] = one
    if BOX:
        if law == CONE:
            f, slope = boxed(mu, z)
        if law == HOLD_X:
            return Vector(z[0], zero, z[2]), wp.diag(Vector(one, zero, one))
        if law == HOLD_Y:
            return Vector(zero, z[1], z[2]), wp.diag(Vector(zero, one, one))
    elif law == CONE:
        pull = wp.sqrt(z[0] * z[0] + z[1] * z[1])
        if pull <= mu * z[2]:
            return z, wp.identity(n=3, dtype=real)
        f = Vector()
        slope = Matrix()
        over = one / (one + mu * mu)
        push = over * (z[2] + mu * pull)
        if push > zero:
            x, y = z[0] / pull, z[1] / pull
            f = Vector(mu * push * x, mu * push * y, push)
            g, s = mu * mu * over, mu * push / pull
            slope = Matrix(
                g * x * x + s * y * y, (g - s) * x * y, mu * over * x,
                (g - s) * x * y, g * y * y + s * x * x, mu * over * y,
                mu * over * x, mu * over * y, over,
            )  # fmt: skip
    return f, slope


@wp.func
def asked(t: Touches, pose: Pose, stiff: PointNumbers, asks: Points, v: Bodies, w: Bodies, i: int):
    """What contact i asks for: l - c (u + gap), along its directions; these are returned, too."""
    k = t.body[i]
    e = directions(pose.axes, k, t.slot[i])
    u = e * relative_velocity(v[k], w[k], t.ru[i], v[k - 1], w[k - 1], t.rl[i])
    u = u + Vector(real(0.0), real(0.0), t.gap[i])
    return asks[i] - stiff[i] * u, e


@wp.func
def lift_of(t: Touches, pose: Pose, v: Bodies, w: Bodies, i: int) -> real:
    """What a contact's normal velocity is taken to be more by [m/s]."""
    if t.law[i] != CONE:
        return t.gap[i]
    u = slip_at(t, pose, i, v, w)
    if BOX:
        return pose.friction[t.body[i]] * (wp.abs(u[0]) + wp.abs(u[1]))
    return pose.friction[t.body[i]] * wp.sqrt(u[0] * u[0] + u[1] * u[1])


@wp.func
def residual(
    t: Touches, pose: Pose, stiff: PointNumbers, asks: Points,
    v0: Bodies, w0: Bodies, v: Bodies, w: Bodies,
):  # fmt: skip
    """M (v - v_free) - sum G^T f of all blocks; the convex function whose slope it is [J]."""
    force, spin, energy = Bodies(), Bodies(), real(0.0)
    bodies = int(BLOCKS + 1)
    for i in range(t.total):
        k = t.body[i]
        z, e = asked(t, pose, stiff, asks, v, w, i)
        f, _slope = allowed(t.law[i], pose.friction[k], z)
        energy += HALF * wp.length_sq(f) / stiff[i]
        push = wp.transpose(e) * f
        force[k] = force[k] - push
        spin[k] = spin[k] - wp.cross(t.ru[i], push)
        force[k - 1] = force[k - 1] + push
        spin[k - 1] = spin[k - 1] + wp.cross(t.rl[i], push)
    for k in range(1, bodies):
        dv, dw = v[k] - v0[k], w[k] - w0[k]
        heavy = wp.inverse(rows_of(pose.ease, k)) * dw
        force[k] = force[k] + dv / pose.light[k]
        spin[k] = spin[k] + heavy
        energy += HALF * (wp.dot(dv, dv) / pose.light[k] + wp.dot(heavy, dw))
    return force, spin, energy


@wp.func
def matrix(
    t: Touches, pose: Pose, stiff: PointNumbers, asks: Points,
    v: Bodies, w: Bodies,
) -> Wide:  # fmt: skip
    """M + c sum G^T P' G."""
    a = Wide()
    bodies = int(BLOCKS + 1)
    for k in range(1, bodies):
        heavy = wp.inverse(rows_of(pose.ease, k))
        for i in range(3):
            a[6 * k - 6 + i, 6 * k - 6 + i] = real(1.0) / pose.light[k]
            for j in range(3):
                a[6 * k - 3 + i, 6 * k - 3 + j] = heavy[i, j]
    for i in range(t.total):
        k = t.body[i]
        z, e = asked(t, pose, stiff, asks, v, w, i)
        _f, slope = allowed(t.law[i], pose.friction[k], z)
        g = Slopes()
        for d in range(3):
            turn, back = wp.cross(t.ru[i], e[d]), wp.cross(t.rl[i], e[d])
            for j in range(3):
                g[d, j] = -e[d, j]
                g[d, 3 + j] = -back[j]
                g[d, 6 + j] = e[d, j]
                g[d, 9 + j] = turn[j]
        h = stiff[i] * (slope * g)
        first = 6 * k - 12
        least = wp.where(k == 1, 6, 0)
        for m in range(least, 12):
            column = Vector(g[0, m], g[1, m], g[2, m])
            for n in range(least, 12):
                more = column[0] * h[0, n] + column[1] * h[1, n] + column[2] * h[2, n]
                a[first + m, first + n] = a[first + m, first + n] + more
    return a


@wp.func
def eliminated(system: Wide, right: Long) -> Long:
    """The solution of the banded system."""
    a = system
    x = right
    rows = int(ROWS)
    for j in range(rows):
        last = wp.min(j + BAND, rows)
        for i in range(j + 1, last):
            part = a[i, j] / a[j, j]
            if part != real(0.0):
                for n in range(j, last):
                    a[i, n] = a[i, n] - part * a[j, n]
                x[i] = x[i] - part * x[j]
    for back in range(rows):
        j = rows - 1 - back
        last = wp.min(j + BAND, rows)
        total = x[j]
        for n in range(j + 1, last):
            total = total - a[j, n] * x[n]
        x[j] = total / a[j, j]
    return x


@wp.func(inline=False)
def nearer(
    t: Touches, pose: Pose, stiff: PointNumbers, asks: Points,
    v0: Bodies, w0: Bodies, v: Bodies, w: Bodies,
):  # fmt: skip
    """Velocities after one of Newton's steps; their change and size, as energies [J]."""
    force, spin, energy = residual(t, pose, stiff, asks, v0, w0, v, w)
    right = Long()
    bodies = int(BLOCKS + 1)
    for k in range(1, bodies):
        for i in range(3):
            right[6 * k - 6 + i] = -force[k, i]
            right[6 * k - 3 + i] = -spin[k, i]
    found = eliminated(matrix(t, pose, stiff, asks, v, w), right)
    part = real(1.0)
    v1, w1, change, whole = Bodies(), Bodies(), real(0.0), real(0.0)
    for _again in range(HALVINGS):
        change, whole = real(0.0), real(0.0)
        for k in range(1, bodies):
            dv, dw = Vector(), Vector()
            for i in range(3):
                dv[i] = part * found[6 * k - 6 + i]
                dw[i] = part * found[6 * k - 3 + i]
            v1[k] = v[k] + dv
            w1[k] = w[k] + dw
            reach = wp.length_sq(t.ru[0])
            change += (wp.length_sq(dv) + reach * wp.length_sq(dw)) / pose.light[k]
            whole += (wp.length_sq(v1[k]) + reach * wp.length_sq(w1[k])) / pose.light[k]
            whole += (wp.length_sq(v0[k]) + reach * wp.length_sq(w0[k])) / pose.light[k]
        _f, _s, now = residual(t, pose, stiff, asks, v0, w0, v1, w1)
        if now <= energy + DUST * energy:
            break
        part = HALF * part
    return v1, w1, change, whole


@wp.func(inline=False)
def solve(rounds: int, t: Touches, pose: Pose, first: Points, v: Bodies, w: Bodies):
    """Impulses of all contacts, and the velocities that they leave: as `solve_by_sweeps` does.

    With fewer rounds than ROUNDS what these come to is taken as it is.
    """
    asks, u, o, good = solve_by_sweeps(FIRST, t, pose, first, v, w)
    if t.total == 0 or good:
        return asks, u, o, True
    c = t
    stiff, energy, done = PointNumbers(), real(0.0), bool(False)
    for i in range(t.total):
        stiff[i] = STIFF * effective(t, pose, i)
        c.gap[i] = lift_of(t, pose, u, o, i)
    for turn in range(rounds):
        fits = bool(False)
        for _try in range(TRIES):
            u1, o1, more, whole = nearer(c, pose, stiff, asks, v, w, u, o)
            u = u1
            o = o1
            energy = whole
            if more <= ALIKE * ALIKE * energy:
                fits = True
                break
        change = real(0.0)
        for i in range(t.total):
            z, _e = asked(c, pose, stiff, asks, u, o, i)
            f, _slope = allowed(c.law[i], pose.friction[t.body[i]], z)
            lift = lift_of(t, pose, u, o, i)
            more = lift - c.gap[i]
            if turn % LEAP == LEAP - 1 and rounds == ROUNDS:
                lift = wp.where(t.law[i] == CONE, larger(lift + AHEAD * more, real(0.0)), lift)
            broken = wp.length_sq(f - asks[i]) / (stiff[i] * stiff[i]) + more * more
            change += broken / pose.light[t.body[i]]
            asks[i] = f
            c.gap[i] = lift
        done = fits and change <= SOUND * SOUND * energy
        if fits and change <= ENOUGH * ENOUGH * energy:
            break
    if not done and rounds == ROUNDS:
        asks, u, o, done = solve_by_sweeps(SWEEPS, t, pose, first, v, w)
    return asks, u, o, done
