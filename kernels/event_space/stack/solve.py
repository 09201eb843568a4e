"""Coulomb's law at all contacts of a stack in space, by Newton's method.

The impulse of a contact with velocity u is f = P(l - c (u + lift n)). P projects on the impulses
that its law allows, l is a multiplier, and c is a stiffness times the effective mass of the
contact. lift is its gap; to it in the law CONE comes mu |u_t| for the cone and mu (|u_x| + |u_y|)
for the box, mu the friction coefficient and u_t the slip. If l = f and lift is that of u, all laws
hold (augmented Lagrangian, with the change of variable of De Saxce and Feng 1998).

P is made of *pieces*. On all but one of them it is linear: a contact without impulse, one that
sticks, one without friction. With every contact on such a piece, M (v - v_free) = sum G^T f is a
linear system. Its matrix M + c sum G^T P' G has six rows a block and couples neighbours only; it is
factored as L D L^T.

Most solves continue the one of the step before: its impulses tell the pieces. `continue_pieces`
solves that system with the stiffness FIRM until l no longer changes, each time with a change
smaller by about that factor. Contacts that turn out to be on other linear pieces go there. If one
comes to the curved piece, this ends without a solution.

With a cone, `solve_with_slips` comes next. It bounds the friction of a contact by the disc that its
own push allows (Alart and Curnier 1991), so that stiffnesses along a face and across it may differ:
contacts share the friction of a face as they share its load. The Newton steps of this system, which
is not symmetric, converge fast where contacts slip, but not from everywhere.

Else, for given l and lift the velocities minimise a convex function. Newton's method finds its
least value; a step that does not descend is halved, and one within linear pieces is exact. Then l
is set to f and lift to that of u. This repeats until only round-off changes. Redundant contacts of
a face do no harm.

Lifts change slowly in these rounds: often by the same factor, or not less at all until a contact
comes to another piece. Where two changes are aligned, a `leap` goes on along them, to the limit of
their geometric series or to the first contact that comes to another piece. It goes the way of the
rounds, and so comes to the same solution.

After each of the first rounds, and once a leap has ended, `descend_to_slips` goes on with discs of
friction, l being the impulse. A stiffness of a few effective masses tells the pieces, and a step is
halved until it comes nearer to the law. The first rounds begin soft, so that l and not u tells the
pieces. Where a contact slides fast at the start they are left out. There may be another solution
nearby, which stops the slide or turns the block at once; rounds alone go on sliding.
"""

import warp as wp

from warprock.kernels.algebra.vectors import Matrix, Vector, X, Y, Z
from warprock.kernels.event_space.lane import LIGHTER, LIGHTEST
from warprock.kernels.event_space.stack.contact import (
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
    solve_by_sweeps,
    sticking_bits,
)
from warprock.kernels.shape_space.frame import relative_velocity
from warprock.kernels.shape_space.stack import Bodies, PointInts, PointNumbers, Points, rows_of

STIFF = by_precision(1.0e4, 1.0e2)
"""Stiffness c of a contact over its effective mass, in Newton's method of the last rounds."""
SOFT = real(100.0)
"""The same in the first round before slips."""
STIFFER = real(10.0)
"""Factor from a round before slips to the next one, up to STIFF."""
FIRM = by_precision(1.0e7, 1.0e5)
"""Stiffness on given pieces. A change of l leaves about 1/FIRM of it: two come to round-off."""
PLIANT = by_precision(1.0e5, 1.0e3)
"""Stiffness on given pieces where contacts slip."""
EVEN = real(3.0)
"""Stiffness that tells which contacts slip and where to, in the first rounds."""
SURE = real(100.0)
"""The same after a leap. Near a solution a larger one tells more of them right."""
FAST = real(10.0)
"""Speed from which a contact slides fast, over what loads change in the speed of a block. Errors of
random stacks are the same with 1 and with 100."""
SLIP_TURNS = 12
"""Largest number of Newton steps with slips after a round."""
SLIP_HALVINGS = 4
"""Largest number of trials of such a step, each half as long as the one before."""
DESCENDS = real(0.2)
"""Least part by which a whole step comes nearer to the law."""
TRIED = 30
"""Largest number of Newton steps with slips where none is halved."""
LOST = 6
"""Largest number of such steps before the velocities settle; later they seldom do."""
FAIR = by_precision(1.0e-4, 1.0e-2)
"""Relative change of the velocities in a step from which they have settled."""
CLOSE = by_precision(1.0e-9, 1.0e-4)
"""Relative change after which only round-off is left: the next one is about its square."""
HEAVY = real(10.0)
"""Weight, as a velocity over the largest one of a contact, from which weights fall where nothing
else solves an impact."""
LEAST_GRIP = real(0.01)
"""Least stiffness of a contact along its face, over that across it."""
TURNS = 12
"""Largest number of changes of l or of linear pieces."""
ROUNDS = 200
"""Largest number of rounds of Newton's method, each with one change of l."""
ALIGNED = real(0.99)
"""Squared cosine of the changes of lifts in two rounds from which a leap goes on along them."""
FARTHEST = real(1000.0)
"""Largest leap, over the change of a round."""
TRIES = 30
"""Largest number of Newton steps in a round."""
HALVINGS = 8
"""Largest number of times that a step which does not descend is halved."""
FIRST = 4
"""Gauss-Seidel sweeps for the first guess of the impulses."""
ROUGH = by_precision(1.0e-6, 1.0e-3)
"""Relative change of the velocities in a Newton step that ends a round before slips."""
ALIKE = by_precision(1.0e-13, 1.0e-5)
"""Relative change that ends any other round."""

ENOUGH = by_precision(1.0e-14, 1.0e-6)
"""Velocity by which contacts may break their laws, as a part of the velocities."""
SOUND = by_precision(1.0e-6, 1.0e-4)
"""The same where all rounds do not reach `ENOUGH`."""

DUST = by_precision(1.0e-13, 1.0e-5)
"""Round-off of the convex function."""

NONE = 0
"""The piece of a contact without impulse."""
ALL = 1
"""The piece of a contact whose impulse has every part: it sticks."""
NORMAL = 2
"""The piece of a contact without friction."""
NO_Y = 3
"""The piece of a contact without friction along y."""
NO_X = 4
"""The piece of a contact without friction along x."""
CURVED = 5
"""The piece on which P is not linear: friction at its bound."""

GIVEN = 0
"""A look at contacts on given pieces."""
ANEW = 1
"""A look at contacts on the pieces of their arguments."""
RENEW = 2
"""As `ANEW`; then l is set to f and lifts to those of the velocities."""

SixRows = wp.types.matrix(shape=(6 * BLOCKS, 6), dtype=real)
Sixes = wp.types.matrix(shape=(BLOCKS, 6), dtype=real)
TURN = 3
"""Place of the angular velocity in a row of `Sixes`, behind the velocity."""


@wp.struct
class System:
    """What a solve is about.

    Attributes:
        t: The contacts.
        pose: Where the bodies are.
        mass: Effective mass of each contact across its face [kg].
        firm: Stiffness c of a contact over that mass.
        even: Stiffness that tells which contacts slip, over that mass.
        v, w: Velocity [m/s] and angular velocity [rad/s] of each body without contact.
    """

    t: Touches
    pose: Pose
    mass: PointNumbers
    firm: real
    even: real
    v: Bodies
    w: Bodies


@wp.struct
class Guess:
    """Multipliers l [N s], lifts [m/s], pieces; velocities [m/s], angular velocities [rad/s]."""

    asks: Points
    lift: PointNumbers
    pieces: PointInts
    v: Bodies
    w: Bodies


@wp.struct
class Slope:
    """What a look at all contacts finds.

    Attributes:
        force, spin: The gradient M (v - v_free) - sum G^T f.
        energy: The convex function [J].
        change: How much l and lifts changed, as an energy [J].
        same: Whether no contact went to another piece.
        straight: Whether none is on the curved piece.
    """

    force: Bodies
    spin: Bodies
    energy: real
    change: real
    same: bool
    straight: bool


@wp.struct
class Factor:
    """L D L^T of the matrix, six rows a block.

    Attributes:
        own: Within a block: L below its diagonal, on it the inverse of D.
        below: L between a block and the one below.
    """

    own: SixRows
    below: SixRows


@wp.struct
class Linear:
    """A Newton step: the gradient, and the matrix, six rows a block.

    Attributes:
        force, spin: The gradient M (v - v_free) - sum G^T f.
        own: Within a block.
        below, above: Rows of a block and columns of the one below, and the other way round.
    """

    force: Bodies
    spin: Bodies
    own: SixRows
    below: SixRows
    above: SixRows


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
def piece_of(law: int, mu: real, z: Vector) -> int:
    """The piece of the projection P on which an argument z lies."""
    if law == HOLD:
        return int(ALL)
    if law == KEEP:
        return int(NORMAL)
    if law == PUSH:
        return wp.where(z[2] > real(0.0), NORMAL, NONE)
    if law == HOLD_X:
        return int(NO_Y)
    if law == HOLD_Y:
        return int(NO_X)
    piece = int(NONE)
    if law == CONE:
        pull = wp.sqrt(z[0] * z[0] + z[1] * z[1])
        most = pull
        if BOX:
            pull = larger(wp.abs(z[0]), wp.abs(z[1]))
            most = wp.abs(z[0]) + wp.abs(z[1])
        piece = wp.where(z[2] + mu * most > real(0.0), CURVED, NONE)
        piece = wp.where(pull <= mu * z[2], ALL, piece)
    return piece


@wp.func
def project_on_piece(piece: int, law: int, mu: real, z: Vector) -> Vector:
    """P(z), taken on one of its pieces."""
    f = z
    if piece == CURVED:
        f, _slope = project_on_law(law, mu, z)
    elif piece != ALL:
        zero = real(0.0)
        f = Vector(
            wp.where(piece == NO_Y, z[0], zero), wp.where(piece == NO_X, z[1], zero),
            wp.where(piece == NONE, zero, z[2]),
        )  # fmt: skip
    return f


@wp.func
def lift_of(law: int, mu: real, gap: real, u: Vector) -> real:
    """The term `lift` of a contact, see the head of this file [m/s]."""
    if law != CONE:
        return gap
    if BOX:
        return gap + mu * (wp.abs(u[0]) + wp.abs(u[1]))
    return gap + mu * wp.sqrt(u[0] * u[0] + u[1] * u[1])


@wp.func(inline=False)
def look_at(s: wp.ref[System], g: wp.ref[Guess], mode: int) -> Slope:
    """The gradient and the convex function at a guess; the guess gets what the mode says."""
    # A field of a struct is read as a whole wherever it is indexed: once is enough.
    body = s.t.body
    way = s.t.way
    law = s.t.law
    gap = s.t.gap
    ru = s.t.ru
    rl = s.t.rl
    axes = s.pose.axes
    friction = s.pose.friction
    mass = s.mass
    firm = s.firm
    asks = g.asks
    lifts = g.lift
    pieces = g.pieces
    v = g.v
    w = g.w
    force, spin, energy, change = Bodies(), Bodies(), real(0.0), real(0.0)
    same, straight = bool(True), bool(True)
    bodies = int(BLOCKS + 1)
    for i in range(s.t.total):
        k, c, piece, lift = body[i], firm * mass[i], pieces[i], lifts[i]
        mu, e = friction[k], directions(axes, k, way[i])
        u = e * relative_velocity(v[k], w[k], ru[i], v[k - 1], w[k - 1], rl[i])
        if mode == RENEW:
            now = lift_of(law[i], mu, gap[i], u)
            z = asks[i] - c * Vector(u[0], u[1], u[2] + lift)
            piece = piece_of(law[i], mu, z)
            f = project_on_piece(piece, law[i], mu, z)
            more = now - lift
            change += (wp.length_sq(f - asks[i]) / (c * c) + more * more) / s.pose.light[k]
            lift = now
            asks[i] = f
            lifts[i] = lift
        z = asks[i] - c * Vector(u[0], u[1], u[2] + lift)
        if mode == ANEW:
            piece = piece_of(law[i], mu, z)
        same = same and piece == pieces[i]
        straight = straight and piece != CURVED
        pieces[i] = piece
        f = project_on_piece(piece, law[i], mu, z)
        energy += HALF * wp.length_sq(f) / c
        push = wp.transpose(e) * f
        force[k] = force[k] - push
        spin[k] = spin[k] - wp.cross(ru[i], push)
        force[k - 1] = force[k - 1] + push
        spin[k - 1] = spin[k - 1] + wp.cross(rl[i], push)
    for k in range(1, bodies):
        dv, dw, light = v[k] - s.v[k], w[k] - s.w[k], s.pose.light[k]
        turn = rows_of(s.pose.inertia, k) * dw
        force[k] = force[k] + dv / light
        spin[k] = spin[k] + turn
        energy += HALF * (wp.dot(dv, dv) / light + wp.dot(turn, dw))
    g.asks = asks
    g.lift = lifts
    g.pieces = pieces
    return Slope(force, spin, energy, change, same, straight)


@wp.func
def stiffness_of(s: wp.ref[System], g: wp.ref[Guess], i: int) -> Matrix:
    """Stiffness of a contact in the axes of the base, c E^T P' E with its directions E [kg]."""
    k = s.t.body[i]
    e = directions(s.pose.axes, k, s.t.way[i])
    m = Matrix()
    piece = g.pieces[i]
    if piece == ALL:
        m = wp.identity(n=3, dtype=real)
    elif piece == NORMAL:
        m = wp.outer(e[2], e[2])
    elif piece == CURVED:
        u = e * relative_velocity(g.v[k], g.w[k], s.t.ru[i], g.v[k - 1], g.w[k - 1], s.t.rl[i])
        z = g.asks[i] - s.firm * s.mass[i] * Vector(u[0], u[1], u[2] + g.lift[i])
        _f, slope = project_on_law(s.t.law[i], s.pose.friction[k], z)
        m = wp.transpose(e) * (slope * e)
    elif piece != NONE:
        m = wp.outer(e[2], e[2])
        m += wp.where(piece == NO_Y, wp.outer(e[0], e[0]), wp.outer(e[1], e[1]))
    return s.firm * s.mass[i] * m


@wp.func(inline=False)
def factor(s: wp.ref[System], g: wp.ref[Guess]) -> Factor:
    """L D L^T of the matrix M + c sum G^T P' G at a guess with its pieces."""
    a, b = SixRows(), SixRows()
    body = s.t.body
    ru = s.t.ru
    rl = s.t.rl
    light = s.pose.light
    inertia = s.pose.inertia
    bodies = int(BLOCKS + 1)
    for k in range(1, bodies):
        for i in range(3):
            a[6 * k - 6 + i, i] = real(1.0) / light[k]
            for j in range(3):
                a[6 * k - 3 + i, 3 + j] = inertia[3 * k + i, j]
    for q in range(s.t.total):
        if g.pieces[q] != NONE:
            k = body[q]
            m, up = stiffness_of(s, g, q), wp.skew(ru[q])
            row, turn = 6 * k - 6, up * m
            turns = turn * up
            for i in range(3):
                for j in range(3):
                    a[row + i, j] = a[row + i, j] + m[i, j]
                    a[row + 3 + i, j] = a[row + 3 + i, j] + turn[i, j]
                    a[row + 3 + i, 3 + j] = a[row + 3 + i, 3 + j] - turns[i, j]
            if k > 1:
                low = wp.skew(rl[q])
                back = low * m
                backs, both, across = back * low, turn * low, m * low
                for i in range(3):
                    for j in range(3):
                        a[row - 6 + i, j] = a[row - 6 + i, j] + m[i, j]
                        a[row - 3 + i, j] = a[row - 3 + i, j] + back[i, j]
                        a[row - 3 + i, 3 + j] = a[row - 3 + i, 3 + j] - backs[i, j]
                        b[row + i, j] = b[row + i, j] - m[i, j]
                        b[row + i, 3 + j] = b[row + i, 3 + j] + across[i, j]
                        b[row + 3 + i, j] = b[row + 3 + i, j] - turn[i, j]
                        b[row + 3 + i, 3 + j] = b[row + 3 + i, 3 + j] + both[i, j]
    for k in range(BLOCKS):
        row, low_row = 6 * k, 6 * k - 6
        if k > 0:
            for i in range(6):
                for j in range(6):
                    rest = b[row + i, j]
                    for n in range(j):
                        rest -= b[row + i, n] * a[low_row + j, n]
                    b[row + i, j] = rest
            for i in range(6):
                for j in range(6):
                    part = b[row + i, j] * a[low_row + j, j]
                    for n in range(i, 6):
                        a[row + n, i] = a[row + n, i] - part * b[row + n, j]
                    b[row + i, j] = part
        for j in range(6):
            pivot = real(1.0) / a[row + j, j]
            a[row + j, j] = pivot
            for i in range(j + 1, 6):
                part = a[row + i, j] * pivot
                for n in range(i, 6):
                    a[row + n, i] = a[row + n, i] - part * a[row + n, j]
            for i in range(j + 1, 6):
                a[row + i, j] = a[row + i, j] * pivot
    return Factor(a, b)


@wp.func(inline=False)
def descent(factored: wp.ref[Factor], slope: wp.ref[Slope]):
    """The change of velocities and angular velocities in a whole Newton step."""
    a = factored.own
    b = factored.below
    force = slope.force
    spin = slope.spin
    x, dv, dw = Sixes(), Bodies(), Bodies()
    for k in range(BLOCKS):
        for i in range(3):
            x[k, i] = -force[k + 1, i]
            x[k, 3 + i] = -spin[k + 1, i]
        for i in range(6):
            rest = x[k, i]
            if k > 0:
                for j in range(6):
                    rest -= b[6 * k + i, j] * x[k - 1, j]
            for j in range(i):
                rest -= a[6 * k + i, j] * x[k, j]
            x[k, i] = rest
    for back in range(BLOCKS):
        k = BLOCKS - 1 - back
        for turn in range(6):
            i = 5 - turn
            rest = x[k, i] * a[6 * k + i, i]
            if back > 0:
                for j in range(6):
                    rest -= b[6 * k + 6 + j, i] * x[k + 1, j]
            for j in range(i + 1, 6):
                rest -= a[6 * k + j, i] * x[k, j]
            x[k, i] = rest
        dv[k + 1] = Vector(x[k, X], x[k, Y], x[k, Z])
        dw[k + 1] = Vector(x[k, TURN + X], x[k, TURN + Y], x[k, TURN + Z])
    return dv, dw


@wp.func
def piece_on_disc(law: int, mu: real, z: Vector) -> int:
    """The piece of a contact, its friction within the disc that its own push allows."""
    if law != CONE:
        return piece_of(law, mu, z)
    pull = wp.sqrt(z[0] * z[0] + z[1] * z[1])
    return wp.where(z[2] <= real(0.0), NONE, wp.where(pull <= mu * z[2], ALL, CURVED))


@wp.func
def project_on_disc(piece: int, law: int, mu: real, z: Vector) -> Vector:
    """The impulse of a contact on a piece, its friction within that disc."""
    if piece == CURVED:
        part = mu * z[2] / wp.sqrt(z[0] * z[0] + z[1] * z[1])
        return Vector(part * z[0], part * z[1], z[2])
    return project_on_piece(piece, law, mu, z)


@wp.func
def turning_of(mu: real, c: real, even: real, z: Vector) -> real:
    """Stiffness of the friction of a contact that slips against a turn of its slip [kg].

    `c` is the largest one, `even` that of the argument z [kg].
    """
    most = mu * z[2]
    spare = wp.sqrt(z[0] * z[0] + z[1] * z[1]) - most
    return wp.where(even * most < c * spare, even * most / spare, c)


@wp.func
def push_on_disc(
    piece: int, mu: real, c: real, even: real, z: Vector, ask: Vector, u: Vector
) -> Vector:
    """The impulse of a contact on a piece at a velocity u, linear in u; see `slope_on_disc`."""
    if piece != CURVED:
        return project_on_piece(piece, CONE, mu, ask - c * u)
    pull = wp.sqrt(z[0] * z[0] + z[1] * z[1])
    x, y, push = z[0] / pull, z[1] / pull, ask[2] - c * u[2]
    aside = turning_of(mu, c, even, z) * (x * u[1] - y * u[0])
    return Vector(mu * push * x + aside * y, mu * push * y - aside * x, push)


@wp.func
def slope_on_disc(piece: int, mu: real, turns: real, c: Vector, z: Vector) -> Matrix:
    """How an impulse on a piece shrinks with the velocity of its contact [kg].

    `c` is the stiffness along each direction, `turns` that of friction at its bound, which is along
    the argument z, against a turn of the slip [kg].
    """
    zero = real(0.0)
    if piece == CURVED:
        pull = wp.sqrt(z[0] * z[0] + z[1] * z[1])
        x, y = z[0] / pull, z[1] / pull
        return Matrix(
            turns * y * y, -turns * x * y, mu * x * c[2],
            -turns * x * y, turns * x * x, mu * y * c[2],
            zero, zero, c[2],
        )  # fmt: skip
    x = wp.where(piece == NORMAL or piece == NO_X, zero, c[0])  # noqa: SIM109
    y = wp.where(piece == NORMAL or piece == NO_Y, zero, c[1])  # noqa: SIM109
    return wp.diag(Vector(x, y, c[2]))


@wp.func(inline=False)
def look_at_slips(s: wp.ref[System], g: wp.ref[Guess], begins: bool, settled: bool, given: bool):
    """The system of a Newton step, and whether all contacts stayed on their pieces.

    At the beginning the impulses tell the pieces. A contact that stays on its piece gets l = f, its
    friction only once the velocities have `settled`; then all contacts do. On pieces that are
    `given` l is the impulse.
    """
    body = s.t.body
    way = s.t.way
    laws = s.t.law
    gap = s.t.gap
    ru = s.t.ru
    rl = s.t.rl
    axes = s.pose.axes
    friction = s.pose.friction
    light = s.pose.light
    inertia = s.pose.inertia
    mass = s.mass
    asks = g.asks
    pieces = g.pieces
    v = g.v
    w = g.w
    force, spin = Bodies(), Bodies()
    own, below, above = SixRows(), SixRows(), SixRows()
    same, zero, load = bool(True), real(0.0), real(0.0)
    bodies = int(BLOCKS + 1)
    for k in range(1, bodies):
        dv, dw = v[k] - s.v[k], w[k] - s.w[k]
        force[k] = dv / light[k]
        spin[k] = rows_of(inertia, k) * dw
        for i in range(3):
            own[6 * k - 6 + i, i] = real(1.0) / light[k]
            for j in range(3):
                own[6 * k - 3 + i, 3 + j] = inertia[3 * k + i, j]
    for q in range(s.t.total):
        load += larger(asks[q, 2], zero) / real(s.t.total)
    for q in range(s.t.total):
        k, law, ask = body[q], laws[q], asks[q]
        mu, e = friction[k], directions(axes, k, way[q])
        u = e * relative_velocity(v[k], w[k], ru[q], v[k - 1], w[k - 1], rl[q])
        c = (PLIANT * mass[q]) * Vector(real(1.0), real(1.0), real(1.0))
        if law == CONE and load > zero and not given:
            # Contacts of a face share its friction as they share its load.
            grip = smaller(larger(ask[2] / load, LEAST_GRIP), real(1.0))
            c = Vector(grip * c[0], grip * c[1], c[2])
        at = Vector(u[0], u[1], u[2] + gap[q])
        off = wp.cw_mul(c, at)
        was = pieces[q]
        piece = piece_on_disc(law, mu, ask - off)
        guessed = begins and law == CONE and ask[2] > zero
        if given:
            piece = was
        elif guessed:
            piece = wp.where(sticking_bits(0, mu, ask) == 0, CURVED, ALL)
            if piece == ALL:
                ask = Vector(zero, zero, ask[2])
        elif piece == CURVED and was == CURVED:
            # Where a slip turns round the contact sticks first.
            turned = (ask[0] - off[0]) * ask[0] + (ask[1] - off[1]) * ask[1] < zero
            piece = wp.where(turned, ALL, CURVED)
        same = same and piece == was
        if settled or (piece == was and not begins and not given):
            stays = project_on_disc(piece, law, mu, ask - off)
            if law == CONE and piece == ALL and not settled:
                stays = Vector(ask[0], ask[1], stays[2])
            ask = stays
        asks[q] = ask
        pieces[q] = piece
        if piece != NONE:
            z = ask - off
            aside, f = real(0.0), Vector()
            if given:
                even = s.even * mass[q]
                z = ask - even * at
                aside = turning_of(mu, c[2], even, z)
                f = push_on_disc(piece, mu, c[2], even, z, ask, at)
            else:
                pull = wp.sqrt(z[0] * z[0] + z[1] * z[1])
                aside = c[0] * mu * larger(wp.where(guessed, ask[2], z[2]), zero) / pull
                f = project_on_disc(piece, law, mu, z)
            m = slope_on_disc(piece, mu, aside, c, z)
            push = wp.transpose(e) * f
            force[k] = force[k] - push
            spin[k] = spin[k] - wp.cross(ru[q], push)
            force[k - 1] = force[k - 1] + push
            spin[k - 1] = spin[k - 1] + wp.cross(rl[q], push)
            m = wp.transpose(e) * (m * e)
            up, low = wp.skew(ru[q]), wp.skew(rl[q])
            row = 6 * k - 6
            turn, right = up * m, m * up
            turns = turn * up
            for i in range(3):
                for j in range(3):
                    own[row + i, j] = own[row + i, j] + m[i, j]
                    own[row + i, 3 + j] = own[row + i, 3 + j] - right[i, j]
                    own[row + 3 + i, j] = own[row + 3 + i, j] + turn[i, j]
                    own[row + 3 + i, 3 + j] = own[row + 3 + i, 3 + j] - turns[i, j]
            if k > 1:
                back, across = low * m, m * low
                backs, both, cross = back * low, turn * low, back * up
                for i in range(3):
                    for j in range(3):
                        own[row - 6 + i, j] = own[row - 6 + i, j] + m[i, j]
                        own[row - 6 + i, 3 + j] = own[row - 6 + i, 3 + j] - across[i, j]
                        own[row - 3 + i, j] = own[row - 3 + i, j] + back[i, j]
                        own[row - 3 + i, 3 + j] = own[row - 3 + i, 3 + j] - backs[i, j]
                        below[row + i, j] = below[row + i, j] - m[i, j]
                        below[row + i, 3 + j] = below[row + i, 3 + j] + across[i, j]
                        below[row + 3 + i, j] = below[row + 3 + i, j] - turn[i, j]
                        below[row + 3 + i, 3 + j] = below[row + 3 + i, 3 + j] + both[i, j]
                        above[row + i, j] = above[row + i, j] - m[i, j]
                        above[row + i, 3 + j] = above[row + i, 3 + j] + right[i, j]
                        above[row + 3 + i, j] = above[row + 3 + i, j] - back[i, j]
                        above[row + 3 + i, 3 + j] = above[row + 3 + i, 3 + j] + cross[i, j]
    g.asks = asks
    g.pieces = pieces
    return Linear(force, spin, own, below, above), same


@wp.func(inline=False)
def eliminate(s: wp.ref[Linear]):
    """The change of velocities and angular velocities in a whole Newton step, by elimination."""
    a = s.own
    b = s.below
    c = s.above
    x, dv, dw = Sixes(), Bodies(), Bodies()
    for k in range(BLOCKS):
        row, low = 6 * k, 6 * k - 6
        for i in range(3):
            x[k, i] = -s.force[k + 1, i]
            x[k, 3 + i] = -s.spin[k + 1, i]
        if k > 0:
            # Rows of this block without the unknowns of the one below.
            for i in range(6):
                for j in range(6):
                    part = b[row + i, j]
                    for n in range(j):
                        part -= b[row + i, n] * a[low + n, j]
                    part = part * a[low + j, j]
                    b[row + i, j] = part
                for j in range(6):
                    part = a[row + i, j]
                    for n in range(6):
                        part -= b[row + i, n] * c[row + n, j]
                    a[row + i, j] = part
                rest = x[k, i]
                for n in range(6):
                    rest -= b[row + i, n] * x[k - 1, n]
                x[k, i] = rest
        for j in range(6):
            pivot = real(1.0) / a[row + j, j]
            a[row + j, j] = pivot
            for i in range(j + 1, 6):
                part = a[row + i, j] * pivot
                for n in range(j + 1, 6):
                    a[row + i, n] = a[row + i, n] - part * a[row + j, n]
                x[k, i] = x[k, i] - part * x[k, j]
                if k + 1 < BLOCKS:
                    for n in range(6):
                        c[row + 6 + i, n] = c[row + 6 + i, n] - part * c[row + 6 + j, n]
    for turned in range(BLOCKS):
        k = BLOCKS - 1 - turned
        row = 6 * k
        for turn in range(6):
            i = 5 - turn
            rest = x[k, i]
            if turned > 0:
                for j in range(6):
                    rest -= c[row + 6 + i, j] * x[k + 1, j]
            for j in range(i + 1, 6):
                rest -= a[row + i, j] * x[k, j]
            x[k, i] = rest * a[row + i, i]
        dv[k + 1] = Vector(x[k, X], x[k, Y], x[k, Z])
        dw[k + 1] = Vector(x[k, TURN + X], x[k, TURN + Y], x[k, TURN + Z])
    return dv, dw


@wp.func(inline=False)
def solve_with_slips(s: wp.ref[System], g: wp.ref[Guess]) -> bool:
    """Whether a guess becomes the solution by Newton's method with discs of friction."""
    reach, near, settled = wp.length_sq(s.t.ru[0]), bool(False), bool(False)
    bodies = int(BLOCKS + 1)
    for turn in range(TRIED):
        system, same = look_at_slips(s, g, turn == 0, settled, False)
        if near and same:
            return True
        dv, dw = eliminate(system)
        g.v = g.v + dv
        g.w = g.w + dw
        change = real(0.0)
        for k in range(1, bodies):
            change += (wp.length_sq(dv[k]) + reach * wp.length_sq(dw[k])) / s.pose.light[k]
        norm_sq = size_of(s, g)
        near = change <= CLOSE * CLOSE * norm_sq
        settled = change <= FAIR * FAIR * norm_sq
        if not (change < NEVER) or (turn >= LOST and not settled):
            return False
    return False


@wp.func(inline=False)
def break_of_law(s: wp.ref[System], g: wp.ref[Guess]) -> real:
    """How far a guess is from the law, as an energy [J]; it gets its pieces."""
    total, pieces = real(0.0), PointInts()
    body = s.t.body
    way = s.t.way
    law = s.t.law
    gap = s.t.gap
    ru = s.t.ru
    rl = s.t.rl
    axes = s.pose.axes
    friction = s.pose.friction
    mass = s.mass
    asks = g.asks
    v = g.v
    w = g.w
    for i in range(s.t.total):
        k, even = body[i], s.even * mass[i]
        mu, e = friction[k], directions(axes, k, way[i])
        u = e * relative_velocity(v[k], w[k], ru[i], v[k - 1], w[k - 1], rl[i])
        z = asks[i] - even * Vector(u[0], u[1], u[2] + gap[i])
        piece = piece_on_disc(law[i], mu, z)
        total += wp.length_sq(asks[i] - project_on_disc(piece, law[i], mu, z)) / even
        pieces[i] = piece
    g.pieces = pieces
    return total


@wp.func(inline=False)
def follow_slips(s: wp.ref[System], g: wp.ref[Guess], dv: Bodies, dw: Bodies) -> Points:
    """The impulses at the end of a whole Newton step."""
    body = s.t.body
    way = s.t.way
    ru = s.t.ru
    rl = s.t.rl
    mass = s.mass
    asks = g.asks
    pieces = g.pieces
    v = g.v
    w = g.w
    for i in range(s.t.total):
        k, even, c = body[i], s.even * mass[i], PLIANT * mass[i]
        low, lift = k - 1, Vector(real(0.0), real(0.0), s.t.gap[i])
        e = directions(s.pose.axes, k, way[i])
        u = e * relative_velocity(v[k], w[k], ru[i], v[low], w[low], rl[i]) + lift
        du = e * relative_velocity(dv[k], dw[k], ru[i], dv[low], dw[low], rl[i])
        z = asks[i] - even * u
        asks[i] = push_on_disc(pieces[i], s.pose.friction[k], c, even, z, asks[i], u + du)
    return asks


@wp.func(inline=False)
def descend_to_slips(s: wp.ref[System], g: wp.ref[Guess]) -> bool:
    """Whether a guess becomes the solution by Newton steps that come nearer to the law."""
    far = break_of_law(s, g)
    for _turn in range(SLIP_TURNS):
        system, _same = look_at_slips(s, g, False, False, True)
        dv, dw = eliminate(system)
        asks = g.asks
        v = g.v
        w = g.w
        more = follow_slips(s, g, dv, dw) - asks
        before, part, fits = real(far), real(1.0), bool(False)
        for _again in range(SLIP_HALVINGS):
            g.asks = asks + part * more
            g.v = v + part * dv
            g.w = w + part * dw
            far = break_of_law(s, g)
            fits = far <= (real(1.0) - DESCENDS * part) * before
            if fits:
                break
            part = HALF * part
        # Only a whole step makes velocities those of the impulses.
        enough = part == real(1.0) and far <= ENOUGH * ENOUGH * size_of(s, g)
        if not fits or enough:
            return enough
    return False


@wp.func
def size_of(s: wp.ref[System], g: wp.ref[Guess]) -> real:
    """Twice the energies of all velocities, with those without contact, or about that [J]."""
    norm_sq, reach = real(0.0), wp.length_sq(s.t.ru[0])
    bodies = int(BLOCKS + 1)
    for k in range(1, bodies):
        speeds = wp.length_sq(g.v[k]) + wp.length_sq(s.v[k])
        turns = wp.length_sq(g.w[k]) + wp.length_sq(s.w[k])
        norm_sq += (speeds + reach * turns) / s.pose.light[k]
    return norm_sq


@wp.func(inline=False)
def continue_pieces(s: wp.ref[System], g: wp.ref[Guess]) -> bool:
    """Whether a guess becomes the solution, contacts on the pieces that its impulses tell."""
    ru = s.t.ru
    rl = s.t.rl
    v = g.v
    w = g.w
    zero = real(0.0)
    for i in range(s.t.total):
        k, law = s.t.body[i], s.t.law[i]
        z = g.asks[i]
        if law != CONE or z[2] <= zero:
            # No impulse tells: by the velocity.
            mu, e = s.pose.friction[k], directions(s.pose.axes, k, s.t.way[i])
            u = e * relative_velocity(v[k], w[k], ru[i], v[k - 1], w[k - 1], rl[i])
            lift = lift_of(law, mu, s.t.gap[i], u)
            z = z - s.firm * s.mass[i] * Vector(u[0], u[1], u[2] + lift)
            g.lift[i] = lift
        piece = piece_of(law, s.pose.friction[k], z)
        if piece == CURVED:
            return False
        g.pieces[i] = piece
        g.lift[i] = wp.where(law == CONE and piece == ALL, s.t.gap[i], g.lift[i])
    slope = look_at(s, g, GIVEN)
    factored = factor(s, g)
    before = zero
    for _turn in range(TURNS):
        dv, dw = descent(factored, slope)
        g.v = g.v + dv
        g.w = g.w + dw
        slope = look_at(s, g, RENEW)
        if not slope.straight:
            return False
        bound = ENOUGH * ENOUGH * size_of(s, g)
        # Changes shrink by the same factor each time: the next one would be round-off.
        if slope.same:
            if slope.change <= bound or slope.change * slope.change <= bound * before:
                return True
            before = slope.change
        else:
            factored = factor(s, g)
            before = zero
    return False


@wp.func(inline=False)
def leap(s: wp.ref[System], g: wp.ref[Guess], now: wp.ref[Guess], last: wp.ref[Guess], ratio: real):
    """Goes on along the change of a round to where a contact comes to another piece, or about so.

    Changes whose ratio is below 1 are a geometric series (Aitken): at most to its limit.

    Args:
        s: The system.
        g: The guess after the round; updated.
        now, last: Guesses that the round and the one before were solved with, and their velocities.
        ratio: Of the last change of the lifts to the one before.
    """
    one, same = real(1.0), bool(True)
    most = wp.where(ratio < one, smaller(ratio / (one - ratio), FARTHEST), FARTHEST)
    asks = now.asks - last.asks
    lift = now.lift - last.lift
    v = now.v - last.v
    w = now.w - last.w
    far, longer = smaller(one, most), smaller(one, most)
    while same and longer > real(0.0):
        ahead = Guess(
            now.asks + far * asks, now.lift + far * lift, now.pieces, now.v + far * v,
            now.w + far * w,
        )  # fmt: skip
        slope = look_at(s, ahead, ANEW)
        same = slope.same
        longer = wp.where(same, smaller(most - far, far), real(0.0))
        far = far + longer
    # The round itself went by `ratio`.
    far = larger(far - ratio, real(0.0))
    g.asks = g.asks + far * asks
    g.v = g.v + far * v
    g.w = g.w + far * w
    for i in range(s.t.total):
        g.lift[i] = larger(g.lift[i] + far * lift[i], s.t.gap[i])


@wp.func(inline=False)
def solve_by_newton(rounds: int, alike: real, s: wp.ref[System], g: wp.ref[Guess]) -> bool:
    """Whether as many rounds at most make a guess the solution; `alike` ends a round."""
    done, norm_sq, ready = bool(False), real(0.0), bool(False)
    factored, on, before, reach = Factor(), PointInts(), PointNumbers(), wp.length_sq(s.t.ru[0])
    bodies = int(BLOCKS + 1)
    last = Guess(g.asks, g.lift, g.pieces, g.v, g.w)
    leapt = bool(False)
    for _turn in range(rounds):
        fits = bool(False)
        slope = look_at(s, g, ANEW)
        for _try in range(TRIES):
            same = ready
            for i in range(s.t.total):
                same = same and g.pieces[i] == on[i]
            if not (slope.straight and same):
                factored = factor(s, g)
                ready = True
                on = g.pieces
            dv, dw = descent(factored, slope)
            v0 = g.v
            w0 = g.w
            energy = slope.energy
            straight = slope.straight
            part, exact = real(1.0), bool(False)
            for again in range(HALVINGS):
                g.v = v0 + part * dv
                g.w = w0 + part * dw
                slope = look_at(s, g, ANEW)
                exact = straight and again == 0
                for i in range(s.t.total):
                    exact = exact and g.pieces[i] == on[i]
                if exact or slope.energy <= energy + DUST * energy:
                    break
                part = HALF * part
            change = real(0.0)
            for k in range(1, bodies):
                turns = reach * wp.length_sq(part * dw[k])
                change += (wp.length_sq(part * dv[k]) + turns) / s.pose.light[k]
            norm_sq = size_of(s, g)
            if exact or change <= alike * alike * norm_sq:
                fits = True
                break
        now = Guess(g.asks, g.lift, g.pieces, g.v, g.w)
        slope = look_at(s, g, RENEW)
        more = g.lift - now.lift
        along, was = wp.dot(more, before), wp.dot(before, before)
        leaps = along > real(0.0) and along * along >= ALIGNED * wp.dot(more, more) * was
        if leaps and rounds == ROUNDS:
            leap(s, g, now, last, along / was)
            more = PointNumbers()
        elif leapt and not BOX:
            near = Guess(g.asks, g.lift, g.pieces, g.v, g.w)
            if descend_to_slips(s, near):
                g = near
                return True
        leapt = leaps and rounds == ROUNDS
        last = now
        before = more
        done = fits and slope.change <= SOUND * SOUND * norm_sq
        if fits and slope.change <= ENOUGH * ENOUGH * norm_sq:
            break
    return done


@wp.func(inline=False)
def slides(s: wp.ref[System], g: wp.ref[Guess]) -> bool:
    """Whether a contact slides fast at the velocities of a guess; before an impact none does."""
    found, most = bool(False), real(0.0)
    bodies = int(BLOCKS + 1)
    for k in range(1, bodies):
        most = larger(most, wp.length_sq(s.v[k] - g.v[k]))
    for i in range(s.t.total):
        k = s.t.body[i]
        low = k - 1
        e = directions(s.pose.axes, k, s.t.way[i])
        u = e * relative_velocity(g.v[k], g.w[k], s.t.ru[i], g.v[low], g.w[low], s.t.rl[i])
        along = u[0] * u[0] + u[1] * u[1]
        fast = most > real(0.0) and along > FAST * FAST * most
        found = found or (fast and u[2] * u[2] < along)
    return found


@wp.func(inline=False)
def solve(
    rounds: int, t: Touches, pose: Pose, first: Points, v: Bodies, w: Bodies, near_v: Bodies,
    near_w: Bodies,
):  # fmt: skip
    """Impulses of all contacts, and the velocities with them, as `solve_by_sweeps`.

    `near_v` and `near_w` are velocities close to those asked for. With fewer rounds than ROUNDS the
    result is accepted as it is.
    """
    if t.total == 0:
        return first, v, w, True
    s = System(t, pose, PointNumbers(), FIRM, EVEN, v, w)
    g = Guess(first, t.gap, PointInts(), near_v, near_w)
    for i in range(t.total):
        k = t.body[i]
        n = directions(pose.axes, k, t.way[i])[2]
        up, low = wp.cross(t.ru[i], n), wp.cross(t.rl[i], n)
        turns = wp.dot(up, rows_of(pose.ease, k) * up)
        turns += wp.dot(low, rows_of(pose.ease, k - 1) * low)
        s.mass[i] = real(1.0) / (pose.light[k] + pose.light[k - 1] + turns)
    good = continue_pieces(s, g)
    if good:
        return g.asks, g.v, g.w, True
    asks, u, o, good = solve_by_sweeps(FIRST, t, pose, first, v, w)
    if good:
        return asks, u, o, True
    if not BOX:
        g = Guess(asks, t.gap, PointInts(), u, o)
        good = solve_with_slips(s, g)
        if good:
            return g.asks, g.v, g.w, True
    for i in range(t.total):
        k = t.body[i]
        e = directions(pose.axes, k, t.way[i])
        at = e * relative_velocity(u[k], o[k], t.ru[i], u[k - 1], o[k - 1], t.rl[i])
        g.lift[i] = lift_of(t.law[i], pose.friction[k], t.gap[i], at)
    g.asks = asks
    g.v = u
    g.w = o
    near = Guess(first, t.gap, PointInts(), near_v, near_w)
    if not BOX and rounds == ROUNDS and not slides(s, near):
        s.firm = SOFT
        while s.firm <= STIFF:
            good = solve_by_newton(1, ROUGH, s, g)
            near = g
            if descend_to_slips(s, near):
                return near.asks, near.v, near.w, True
            s.firm = STIFFER * s.firm
    s.firm = STIFF
    s.even = SURE
    good = solve_by_newton(rounds, ALIKE, s, g)
    return g.asks, g.v, g.w, good


@wp.func(inline=False)
def solve_as_ramp(t: Touches, pose: Pose, v: Bodies, w: Bodies, most: real, least: real):
    """Solves an impact with weights that fall between bounds [m/s]; see `solve_impact`."""
    bodies = int(BLOCKS + 1)
    p, v1, w1, fits = Points(), Bodies(), Bodies(), bool(False)
    for again in range(2):
        # If a ramp was not solved, in smaller parts.
        lighter = wp.where(again == 0, LIGHTER, HALF)
        if not fits:
            p = Points()
        weight = real(most)
        while weight > least and not fits:
            pressed = Bodies()
            for k in range(1, bodies):
                pressed[k] = v[k] - Vector(real(0.0), real(0.0), weight)
            p, v1, w1, good = solve(ROUNDS, t, pose, p, pressed, w, v1, w1)
            weight = lighter * weight
            fits = good and weight <= least
    return p, v1, w1, fits


@wp.func(inline=False)
def solve_impact(t: Touches, pose: Pose, v: Bodies, w: Bodies, kick: real):
    """Impulses of an impact of contacts that obey CONE [N s], velocities, and whether it is solved.

    A velocity step of the base moves no contact up or down. So "no impulse, all slides" obeys the
    law, also where friction presses a corner on what it slides on and stops it at once. Of these
    solutions the limit of a steep ramp is wanted. In a ramp the weight acts, too. It is all there
    is at first, and counts ever less beside the acceleration of the base. So the impact is solved
    with weights that fall from the velocity step to next to nothing, each time from the impulses of
    the one before.

    Any other impact is solved as it is. If that fails, weights fall, too: from more than the
    velocities of contacts, so that friction holds them all at first, to next to nothing.

    Args:
        t: The contacts.
        pose: Where the bodies are.
        v, w: Velocity [m/s] and angular velocity [rad/s] of each body before.
        kick: Velocity step of the base [m/s], or 0.
    """
    p, v1, w1, fits = solve_as_ramp(t, pose, v, w, kick, LIGHTEST * kick)
    if not fits:
        p, v1, w1, fits = solve(ROUNDS, t, pose, Points(), v, w, v, w)
    if not fits:
        fastest = real(0.0)
        for i in range(t.total):
            k = t.body[i]
            u = relative_velocity(v[k], w[k], t.ru[i], v[k - 1], w[k - 1], t.rl[i])
            fastest = larger(fastest, wp.length(u))
        p, v1, w1, fits = solve_as_ramp(t, pose, v, w, HEAVY * fastest, LIGHTEST * fastest)
    if not fits:
        p, v1, w1, fits = solve_by_sweeps(SWEEPS, t, pose, Points(), v, w)
    return p, v1, w1, fits
