"""Coulomb's law at all contacts of a stack in space, by Newton's method.

The impulse of a contact with velocity u is f = P(l - c (u + lift n)). P projects on the impulses
that its law allows, l is a multiplier, and c is STIFF times the effective mass of the contact. lift
is its gap; in the law CONE it is mu |u_t| for the cone and mu (|u_x| + |u_y|) for the box, mu the
friction coefficient and u_t the slip. If l = f and lift is that of u, all laws hold (augmented
Lagrangian, with the change of variable of De Saxce and Feng 1998).

For given l and lift the velocities minimise a convex function: M (v - v_free) = sum G^T f. Newton's
method solves this with the banded matrix M + c sum G^T P' G, six rows a block; a step that does not
descend is halved. Then l is set to f and lift to that of u. This repeats until only round-off
changes. Redundant contacts of a face do no harm.

If this does not converge, the sweeps of event_space/stack_contact.py finish the solve.
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
    effective_mass,
    slip_at,
    solve_by_sweeps,
)
from warprock.kernels.shape_space.frame import relative_velocity
from warprock.kernels.shape_space.stack import Bodies, PointNumbers, Points, rows_of
from warprock.kernels.vectors import Matrix, Vector

ROWS = 6 * BLOCKS
BAND = 12
"""Rows of two neighbouring blocks: the band width of the matrix."""
STIFF = by_precision(1.0e4, 1.0e2)
ROUNDS = 200
"""Largest number of rounds, each with one change of l."""
LEAP = 8
"""Lifts converge slowly, by a factor a round. Every so many rounds they are extrapolated..."""
AHEAD = real(8.0)
"""...by this multiple of their last change."""
TRIES = 30
"""Largest number of Newton steps in a round."""
HALVINGS = 8
FIRST = 4
"""Gauss-Seidel sweeps for the first guess of the impulses."""
ALIKE = by_precision(1.0e-13, 1.0e-5)
"""Relative change of the velocities in a Newton step that ends a round."""

ENOUGH = by_precision(1.0e-14, 1.0e-6)
"""Velocity by which contacts may break their laws, as a part of the velocities..."""
SOUND = by_precision(1.0e-6, 1.0e-4)
"""...and if so many rounds do not reach that."""

DUST = by_precision(1.0e-13, 1.0e-5)
"""Round-off of the convex function."""

Long = wp.types.vector(length=ROWS, dtype=real)
Wide = wp.types.matrix(shape=(ROWS, ROWS), dtype=real)
Slopes = wp.types.matrix(shape=(3, 12), dtype=real)


@wp.func
def project_on_box(mu: real, z: Vector):
    """Projection of an impulse on the box of friction, and its derivative."""
    zero, one = real(0.0), real(1.0)
    x, y = wp.abs(z[0]), wp.abs(z[1])
    # Components beyond their bounds: none, the larger one, both.
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
def project_on_law(law: int, mu: real, z: Vector):
    """Projection of an impulse on the set that a law allows, and its derivative."""
    zero, one = real(0.0), real(1.0)
    f, slope = Vector(), Matrix()
    if law == HOLD:
        return z, wp.identity(n=3, dtype=real)
    if law == KEEP or (law == PUSH and z[2] > zero):
        f[2] = z[2]
        slope[2, 2] = one
    if BOX:
        if law == CONE:
            f, slope = project_on_box(mu, z)
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
def requested_impulse(
    t: Touches, pose: Pose, stiff: PointNumbers, asks: Points, v: Bodies, w: Bodies, i: int
):
    """Argument l - c (u + lift n) of the projection of contact i, and the contact's directions."""
    k = t.body[i]
    e = directions(pose.axes, k, t.slot[i])
    u = e * relative_velocity(v[k], w[k], t.ru[i], v[k - 1], w[k - 1], t.rl[i])
    u = u + Vector(real(0.0), real(0.0), t.gap[i])
    return asks[i] - stiff[i] * u, e


@wp.func
def lift_of(t: Touches, pose: Pose, v: Bodies, w: Bodies, i: int) -> real:
    """The term `lift` of contact i, see the head of this file [m/s]."""
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
    """The gradient M (v - v_free) - sum G^T f, and the convex function itself [J]."""
    force, spin, energy = Bodies(), Bodies(), real(0.0)
    bodies = int(BLOCKS + 1)
    for i in range(t.total):
        k = t.body[i]
        z, e = requested_impulse(t, pose, stiff, asks, v, w, i)
        f, _slope = project_on_law(t.law[i], pose.friction[k], z)
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
        z, e = requested_impulse(t, pose, stiff, asks, v, w, i)
        _f, slope = project_on_law(t.law[i], pose.friction[k], z)
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
def solve_banded(system: Wide, right: Long) -> Long:
    """The solution of the banded linear system, by elimination."""
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
def newton_step(
    t: Touches, pose: Pose, stiff: PointNumbers, asks: Points,
    v0: Bodies, w0: Bodies, v: Bodies, w: Bodies,
):  # fmt: skip
    """Velocities after a Newton step; their change and size, as energies [J]."""
    force, spin, energy = residual(t, pose, stiff, asks, v0, w0, v, w)
    right = Long()
    bodies = int(BLOCKS + 1)
    for k in range(1, bodies):
        for i in range(3):
            right[6 * k - 6 + i] = -force[k, i]
            right[6 * k - 3 + i] = -spin[k, i]
    found = solve_banded(matrix(t, pose, stiff, asks, v, w), right)
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
    """Impulses of all contacts, and the velocities with them, as `solve_by_sweeps`.

    With fewer rounds than ROUNDS the result is accepted as it is.
    """
    asks, u, o, good = solve_by_sweeps(FIRST, t, pose, first, v, w)
    if t.total == 0 or good:
        return asks, u, o, True
    c = t
    stiff, energy, done = PointNumbers(), real(0.0), bool(False)
    for i in range(t.total):
        stiff[i] = STIFF * effective_mass(t, pose, i)
        c.gap[i] = lift_of(t, pose, u, o, i)
    for turn in range(rounds):
        fits = bool(False)
        for _try in range(TRIES):
            u1, o1, more, whole = newton_step(c, pose, stiff, asks, v, w, u, o)
            u = u1
            o = o1
            energy = whole
            if more <= ALIKE * ALIKE * energy:
                fits = True
                break
        change = real(0.0)
        for i in range(t.total):
            z, _e = requested_impulse(c, pose, stiff, asks, u, o, i)
            f, _slope = project_on_law(c.law[i], pose.friction[t.body[i]], z)
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
