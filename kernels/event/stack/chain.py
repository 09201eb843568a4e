"""How impulses at the interfaces of a stack change velocities: a block tridiagonal system.

Three impulses p = (f along the face, n at the + end, n at the - end) act at each interface on the
upper block, and -p on the lower one. Both ends of a closed interface move alike along it and share
f. With G the Jacobian of shape/stack.py and W the inverse masses, the relative velocities become
q + D p, D = G W G^T. Impulses at one interface act on the next ones alone, so D is block
tridiagonal. G^T p = 0 has no other solution than p = 0 (as seen from the top down), so D is
positive definite.

`wp.static` of a loop's index writes the loop out, so that its numbers stay out of memory.
"""

import warp as wp

from warprock.kernels.shape.stack import (
    MINUS,
    PLUS,
    Blocks,
    Counts,
    Jacobian,
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
    """What impulses do to relative velocities: the matrix D, and friction.

    Attributes:
        own: Diagonal blocks of D, one an interface [1/kg].
        below: Blocks beside them, from the impulses of the next lower interface [1/kg].
        friction: Coefficients of friction.
    """

    own: Rows
    below: Rows
    friction: Values


@wp.struct
class Contacts:
    """An assumed state of all interfaces.

    Attributes:
        hold: Ends whose gap stays closed, a sum of ends.
        slip: Direction of sliding, -1 or 1; 0 if the interface sticks, or holds no end.
    """

    hold: Counts
    slip: Counts


@wp.struct
class Factors:
    """Factors of the system of all interfaces, eliminated from below; see `eliminate`.

    Attributes:
        inverse: Minus the inverse of the diagonal block that is left at an interface; zero in the
            columns of rows that hold no velocity.
        reach: What the impulses of the next higher interface do to those of this one.
        positive: 1 if the determinant of the system up to each interface is positive, as without
            contact.
    """

    inverse: Rows
    reach: Rows
    positive: Counts


@wp.func
def state_rows(d: Matrix, hold: int, slip: int, mu: real) -> Matrix:
    """The equations of an interface: of its rows of D those of held velocities.

    The others say that an impulse is zero, or that friction opposes sliding.
    """
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
def invert(m: Matrix):
    """The inverse of a matrix, zero if there is none, and its determinant."""
    i = wedge(m[1, 1], m[1, 2], m[2, 1], m[2, 2])
    j = wedge(m[1, 2], m[1, 0], m[2, 2], m[2, 0])
    k = wedge(m[1, 0], m[1, 1], m[2, 0], m[2, 1])
    determinant = fused(m[0, 2], k, fused(m[0, 1], j, m[0, 0] * i))
    over = wp.where(determinant != real(0.0), real(1.0) / determinant, real(0.0))
    inverse = Matrix(
        i, wedge(m[0, 2], m[0, 1], m[2, 2], m[2, 1]), wedge(m[0, 1], m[0, 2], m[1, 1], m[1, 2]),
        j, wedge(m[0, 0], m[0, 2], m[2, 0], m[2, 2]), wedge(m[0, 2], m[0, 0], m[1, 2], m[1, 0]),
        k, wedge(m[0, 1], m[0, 0], m[2, 1], m[2, 0]), wedge(m[0, 0], m[0, 1], m[1, 0], m[1, 1]),
    )  # fmt: skip
    return over * inverse, determinant


@wp.func
def keep_columns(keep: Three, m: Matrix) -> Matrix:
    """The columns of a matrix, each times a number; a product with a diagonal one costs thrice."""
    return Matrix(
        keep[0] * m[0, 0], keep[1] * m[0, 1], keep[2] * m[0, 2],
        keep[0] * m[1, 0], keep[1] * m[1, 1], keep[2] * m[1, 2],
        keep[0] * m[2, 0], keep[1] * m[2, 1], keep[2] * m[2, 2],
    )  # fmt: skip


@wp.func
def add_product(a: Matrix, b: Matrix, m: Matrix) -> Matrix:
    """The matrix m + a b."""
    found = Matrix()
    for i in range(3):
        for j in range(3):
            first = fused(a[i, 1], b[1, j], fused(a[i, 0], b[0, j], m[i, j]))
            found[i, j] = fused(a[i, 2], b[2, j], first)
    return found


@wp.func
def add_times(m: Matrix, x: Three, v: Three) -> Three:
    """The vector v + m x."""
    found = Three()
    for i in range(3):
        found[i] = fused(m[i, 2], x[2], fused(m[i, 1], x[1], fused(m[i, 0], x[0], v[i])))
    return found


@wp.func
def relative_velocity(g: wp.ref[Jacobian], velocity: wp.ref[Triples], k: int) -> Three:
    """Relative velocities at interface k [m/s]."""
    u = add_times(matrix_of(g.upper, k), three_of(velocity, k), Three())
    if k > 0:
        u = add_times(matrix_of(g.lower, k), three_of(velocity, k - 1), u)
    return u


@wp.func(inline=False)
def relative_velocities(g: wp.ref[Jacobian], velocity: wp.ref[Triples], q: wp.ref[Triples]):
    """Sets the relative velocities q at all interfaces [m/s]."""
    for k in range(BLOCKS):
        u = relative_velocity(g, velocity, wp.static(k))
        for i in range(3):
            q[3 * k + i] = u[i]


@wp.func(inline=False)
def couple(blocks: wp.ref[Blocks], g: wp.ref[Jacobian], c: wp.ref[Couplings]):
    """Sets what impulses at the interfaces do to their relative velocities.

    An impulse of 1 along a row is one along (x, z), a unit vector, and one that turns the block.
    The lower block takes the opposite one, which turns it otherwise.
    """
    c.friction = blocks.friction
    mass = real(0.0)
    turn = real(0.0)
    for k in range(BLOCKS):
        up = matrix_of(g.upper, wp.static(k))
        down = Matrix()
        before = Matrix()
        if k > 0:
            down = matrix_of(g.lower, k)
            before = matrix_of(g.upper, k - 1)
        both = blocks.inverse_mass[k] + mass
        for i in range(3):
            for j in range(wp.static(i + 1)):
                along = both
                if j < i:
                    along = both * dot(up[i, 0], up[i, 1], up[j, 0], up[j, 1])
                turned = turn * down[i, 2]
                own = fused(turned, down[j, 2], along)
                own = fused(blocks.inverse_inertia[k] * up[i, 2], up[j, 2], own)
                c.own[3 * k + i, j] = own
                c.own[3 * k + j, i] = own
            for j in range(3):
                along = mass * dot(up[i, 0], up[i, 1], before[j, 0], before[j, 1])
                c.below[3 * k + i, j] = fused(turn * down[i, 2], before[j, 2], -along)
        mass = blocks.inverse_mass[k]
        turn = blocks.inverse_inertia[k]


@wp.func
def velocity_after(
    c: wp.ref[Couplings], q: wp.ref[Triples], p: wp.ref[Triples], k: int
) -> Three:  # fmt: skip
    """Relative velocity at interface k [m/s]: that of q + D p."""
    u = add_times(matrix_of(c.own, k), three_of(p, k), three_of(q, k))
    if k > 0:
        u = add_times(matrix_of(c.below, k), three_of(p, k - 1), u)
    if k < BLOCKS - 1:
        u = add_times(wp.transpose(matrix_of(c.below, k + 1)), three_of(p, k + 1), u)
    return u


@wp.func(inline=False)
def respond(
    c: wp.ref[Couplings], q: wp.ref[Triples], p: wp.ref[Triples], u: wp.ref[Triples]
):  # fmt: skip
    """Sets the relative velocities u = q + D p [m/s] after impulses p [N s]."""
    for k in range(BLOCKS):
        after = velocity_after(c, q, p, wp.static(k))
        for i in range(3):
            u[3 * k + i] = after[i]


@wp.func(inline=False)
def eliminate(
    c: wp.ref[Couplings], contacts: wp.ref[Contacts], first: int, f: wp.ref[Factors]
):  # fmt: skip
    """Factors of the system of an assumed state, from below: p_k = inverse_k ... + reach_k p_(k+1).

    Args:
        c: The couplings.
        contacts: The state.
        first: The lowest interface whose state has changed.
        f: Factors of the state before; those of the new one after.
    """
    for k in range(BLOCKS):
        if k >= first:
            hold = contacts.hold[wp.static(k)]
            slip = contacts.slip[k]
            own = matrix_of(c.own, k)
            positive = int(1)
            if k > 0:
                own = add_product(matrix_of(c.below, k), matrix_of(f.reach, k - 1), own)
                positive = f.positive[k - 1]
            inverse, determinant = invert(state_rows(own, hold, slip, c.friction[k]))
            f.positive[k] = wp.where(determinant > real(0.0), positive, 1 - positive)
            inverse = keep_columns(-held_rows(hold, slip), inverse)
            reach = Matrix()
            if k < BLOCKS - 1:
                above = wp.transpose(matrix_of(c.below, k + 1))
                reach = add_product(inverse, above, Matrix())
            for i in range(3):
                for j in range(3):
                    f.inverse[3 * k + i, j] = inverse[i, j]
                    f.reach[3 * k + i, j] = reach[i, j]


@wp.func
def is_positive(f: wp.ref[Factors]) -> bool:
    """Whether the determinant is positive; if not, friction jams a contact (Painleve)."""
    return f.positive[BLOCKS - 1] == 1


@wp.func
def impulses_below(
    c: wp.ref[Couplings], f: wp.ref[Factors], q: wp.ref[Triples], p: wp.ref[Triples], k: int
):  # fmt: skip
    """Sets the impulses of interface k as if those of the next higher one were zero."""
    u = three_of(q, k)
    if k > 0:
        u = add_times(matrix_of(c.below, k), three_of(p, k - 1), u)
    own = add_times(matrix_of(f.inverse, k), u, Three())
    for i in range(3):
        p[3 * k + i] = own[i]


@wp.func
def impulses_above(f: wp.ref[Factors], p: wp.ref[Triples], k: int):
    """Adds to the impulses of interface k what those of the next higher one do to them."""
    own = add_times(matrix_of(f.reach, k), three_of(p, k + 1), three_of(p, k))
    for i in range(3):
        p[3 * k + i] = own[i]


@wp.func(inline=False)
def find_impulses(
    c: wp.ref[Couplings], f: wp.ref[Factors], q: wp.ref[Triples], p: wp.ref[Triples]
):  # fmt: skip
    """Sets the impulses p of an assumed state [N s] from relative velocities without contact."""
    for k in range(BLOCKS):
        impulses_below(c, f, q, p, wp.static(k))
    for step in range(1, BLOCKS):
        impulses_above(f, p, wp.static(BLOCKS - 1 - step))


@wp.func(inline=False)
def apply_impulses(
    blocks: wp.ref[Blocks], g: wp.ref[Jacobian], v: wp.ref[Triples], p: wp.ref[Triples]
):  # fmt: skip
    """Changes the velocities v of all blocks by impulses."""
    for k in range(BLOCKS):
        up = wp.transpose(matrix_of(g.upper, wp.static(k)))
        kick = add_times(up, three_of(p, k), Three())
        if k < BLOCKS - 1:
            down = wp.transpose(matrix_of(g.lower, k + 1))
            kick = add_times(down, three_of(p, k + 1), kick)
        w = blocks.inverse_mass[k]
        v[3 * k] = v[3 * k] + w * kick[0]
        v[3 * k + 1] = v[3 * k + 1] + w * kick[1]
        v[3 * k + 2] = v[3 * k + 2] + blocks.inverse_inertia[k] * kick[2]


@wp.func(inline=False)
def constrain(
    blocks: wp.ref[Blocks], g: wp.ref[Jacobian], contacts: wp.ref[Contacts], v: wp.ref[Triples]
):  # fmt: skip
    """Changes the velocities v of all blocks without contact to those in an assumed state."""
    c, f, q, p = Couplings(), Factors(), Triples(), Triples()
    couple(blocks, g, c)
    relative_velocities(g, v, q)
    eliminate(c, contacts, 0, f)
    find_impulses(c, f, q, p)
    apply_impulses(blocks, g, v, p)
