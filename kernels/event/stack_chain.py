"""How impulses at the interfaces of a stack change velocities: a block tridiagonal system.

At each interface three impulses p = (f along the face, n at the + end, n at the - end) act on the
upper block, and -p on the lower one. Touching ends of closed faces move alike along them and share
f. With G the rows of `interface_rows` in shape/stack.py and W the inverse masses, relative
velocities become q + D p, D = G W G^T. An interface is coupled to the next ones alone. From the top
down, nothing but p = 0 has G^T p = 0: D is positive definite.

Loops in which `wp.static` stands are written out, which keeps their numbers out of memory.
"""

import warp as wp

from warprock.kernels.shape.stack import (
    MINUS,
    PLUS,
    Blocks,
    Counts,
    Matrix,
    Rows,
    Three,
    Triples,
    Values,
    matrix_of,
    three_of,
)


@wp.struct
class Couplings:
    """The matrix D: `own` of every interface, `below` from the impulses of the one below it."""

    own: Rows
    below: Rows
    friction: Values


@wp.struct
class Factors:
    """What elimination from below leaves of a system of all interfaces, see `eliminated`.

    `positive`: whether the determinant of the system is up to each interface, as without contact.
    """

    inverse: Rows
    reach: Rows
    positive: Counts


@wp.func
def with_state(d: Matrix, hold: int, slip: int, mu: real) -> Matrix:
    """Rows of an interface's equations: velocities that are held, else what the state says."""
    zero = real(0.0)
    one = real(1.0)
    drag = real(slip) * mu
    sticks = hold != 0 and slip == 0
    plus = (hold & PLUS) != 0
    minus = (hold & MINUS) != 0
    return Matrix(
        wp.where(sticks, d[0, 0], one),
        wp.where(sticks, d[0, 1], drag),
        wp.where(sticks, d[0, 2], drag),
        wp.where(plus, d[1, 0], zero),
        wp.where(plus, d[1, 1], one),
        wp.where(plus, d[1, 2], zero),
        wp.where(minus, d[2, 0], zero),
        wp.where(minus, d[2, 1], zero),
        wp.where(minus, d[2, 2], one),
    )


@wp.func
def held_rows(hold: int, slip: int) -> Three:
    """1 for every row of an interface that holds a velocity, else 0."""
    one = real(1.0)
    zero = real(0.0)
    return Three(
        wp.where(hold != 0 and slip == 0, one, zero),
        wp.where((hold & PLUS) != 0, one, zero),
        wp.where((hold & MINUS) != 0, one, zero),
    )


@wp.func
def weighted(m: Matrix, blocks: Blocks, k: int) -> Matrix:
    """Rows of an interface with the inverse masses of block k."""
    w = blocks.inverse_mass[k]
    return m * wp.diag(Three(w, w, blocks.inverse_inertia[k]))


@wp.func
def relative_velocity(upper: Rows, lower: Rows, velocity: Triples, k: int) -> Three:
    """Relative velocities at interface k."""
    u = matrix_of(upper, k) * three_of(velocity, k)
    if k > 0:
        u = u + matrix_of(lower, k) * three_of(velocity, k - 1)
    return u


@wp.func(inline=False)
def relative_velocities(upper: Rows, lower: Rows, velocity: Triples) -> Triples:
    """Relative velocities at all interfaces."""
    q = Triples()
    for k in range(BLOCKS):
        u = matrix_of(upper, wp.static(k)) * three_of(velocity, k)
        if k > 0:
            u = u + matrix_of(lower, k) * three_of(velocity, k - 1)
        for i in range(3):
            q[3 * k + i] = u[i]
    return q


@wp.func(inline=False)
def couplings_of(blocks: Blocks, upper: Rows, lower: Rows) -> Couplings:
    """What impulses at the interfaces do to their relative velocities."""
    c = Couplings()
    c.friction = blocks.friction
    for k in range(BLOCKS):
        up = matrix_of(upper, wp.static(k))
        d = weighted(up, blocks, k) * wp.transpose(up)
        couple = Matrix()
        if k > 0:
            down = matrix_of(lower, k)
            heavy = weighted(down, blocks, k - 1)
            d = d + heavy * wp.transpose(down)
            couple = heavy * wp.transpose(matrix_of(upper, k - 1))
        for i in range(3):
            for j in range(3):
                c.own[3 * k + i, j] = d[i, j]
                c.below[3 * k + i, j] = couple[i, j]
    return c


@wp.func(inline=False)
def responses(c: Couplings, q: Triples, p: Triples) -> Triples:
    """Relative velocities q + D p with impulses."""
    u = q
    for k in range(BLOCKS):
        own = matrix_of(c.own, wp.static(k)) * three_of(p, k)
        if k > 0:
            own = own + matrix_of(c.below, k) * three_of(p, k - 1)
        if k < BLOCKS - 1:
            own = own + wp.transpose(matrix_of(c.below, k + 1)) * three_of(p, k + 1)
        for i in range(3):
            u[3 * k + i] = u[3 * k + i] + own[i]
    return u


@wp.func(inline=False)
def eliminated(c: Couplings, hold: Counts, slip: Counts, before: Factors, first: int) -> Factors:
    """The system of given states, eliminated from below: p_k = inverse_k ... - reach_k p_(k+1).

    Args:
        c: The chain.
        hold: Ends held.
        slip: Directions of sliding.
        before: Factors of states that are the same below interface `first`.
        first: The lowest interface whose state has changed.
    """
    f = before
    for k in range(BLOCKS):
        if k >= first:
            keep = wp.diag(held_rows(hold[k], slip[k]))
            system = with_state(matrix_of(c.own, wp.static(k)), hold[k], slip[k], c.friction[k])
            positive = int(1)
            if k > 0:
                system = system - keep * matrix_of(c.below, k) * matrix_of(f.reach, k - 1)
                positive = f.positive[k - 1]
            turned = not wp.determinant(system) > real(0.0)
            f.positive[k] = wp.where(turned, 1 - positive, positive)
            inverse = wp.inverse(system)
            reach = Matrix()
            if k < BLOCKS - 1:
                reach = inverse * (keep * wp.transpose(matrix_of(c.below, k + 1)))
            for i in range(3):
                for j in range(3):
                    f.inverse[3 * k + i, j] = inverse[i, j]
                    f.reach[3 * k + i, j] = reach[i, j]
    return f


@wp.func
def sound(f: Factors) -> bool:
    """Whether the determinant is positive; if not, friction turns contacts about (Painleve)."""
    return f.positive[BLOCKS - 1] == 1


@wp.func(inline=False)
def impulses_of(c: Couplings, f: Factors, hold: Counts, slip: Counts, q: Triples) -> Triples:
    """Impulses under given states from relative velocities without contact."""
    part = Triples()
    last = Three()
    for k in range(BLOCKS):
        right = -three_of(q, wp.static(k))
        if k > 0:
            right = right - matrix_of(c.below, k) * last
        last = matrix_of(f.inverse, k) * wp.cw_mul(held_rows(hold[k], slip[k]), right)
        for i in range(3):
            part[3 * k + i] = last[i]
    for step in range(1, BLOCKS):
        k = wp.static(BLOCKS - 1 - step)
        last = three_of(part, k) - matrix_of(f.reach, k) * last
        for i in range(3):
            part[3 * k + i] = last[i]
    return part


@wp.func(inline=False)
def pushed(blocks: Blocks, upper: Rows, lower: Rows, velocity: Triples, p: Triples) -> Triples:
    """Velocities of all blocks after impulses."""
    v = velocity
    for k in range(BLOCKS):
        kick = wp.transpose(matrix_of(upper, wp.static(k))) * three_of(p, k)
        if k < BLOCKS - 1:
            kick = kick + wp.transpose(matrix_of(lower, k + 1)) * three_of(p, k + 1)
        w = blocks.inverse_mass[k]
        v[3 * k] = v[3 * k] + w * kick[0]
        v[3 * k + 1] = v[3 * k + 1] + w * kick[1]
        v[3 * k + 2] = v[3 * k + 2] + blocks.inverse_inertia[k] * kick[2]
    return v


@wp.func(inline=False)
def bound_velocity(
    blocks: Blocks, upper: Rows, lower: Rows, hold: Counts, slip: Counts, free: Triples
) -> Triples:
    """Velocities under given states."""
    c = couplings_of(blocks, upper, lower)
    q = relative_velocities(upper, lower, free)
    f = eliminated(c, hold, slip, Factors(), 0)
    p = impulses_of(c, f, hold, slip, q)
    return pushed(blocks, upper, lower, free, p)
