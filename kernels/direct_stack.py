"""Contact solve of a stack on compliant contacts, exact, for one precision and block count.

Each interface has two ends and one friction, as the base has in `direct`: p = (n_1, n_2, f), n_1 at
the end away from the side to which it leans, n_2 and f at the other, f positive towards that side.
They act on the upper block and turn back on the lower one. With J the rows of the relative
velocities of an interface, upper and lower, W the inverse masses, they become

    w = q + D p + E_below^T p_below + E p_above,   D = J W J^T + CFM,   E = J_upper W J_lower'^T,

q being what there is without contact and the wishes of the ends (`direct.wish`). The laws are
those of `direct`, interface by interface. Given a state of all interfaces (which ends carry,
whether each sticks or to which side it slides) they are linear equations, block tridiagonal, and
solved by elimination from below; the states of the last step are tried first. Where the solution
breaks a law, a sweep over the interfaces (block Gauss-Seidel, each by `direct.solve`) proposes
other states, from that solution in the first tries, from the last sweep later on. The first
solution whose residual in every law is round-off is taken: what is found is exact, whatever the
search. A stack for which none is found says so.
"""

from typing import Any

import warp as wp

from warprock.kernels.instance import kernel_module

real: Any
PRECISION: str
BLOCKS: int

stack = kernel_module("stack", precision=PRECISION, blocks=BLOCKS)
wp.set_module_options(stack.STACK_OPTIONS)
scalar = kernel_module("scalar", precision=PRECISION)
direct = kernel_module("direct", precision=PRECISION)
impulse_stack = kernel_module("impulse_stack", precision=PRECISION)
larger, size, smaller = scalar.larger, scalar.size, scalar.smaller
Values, Triples, Rows = stack.Values, stack.Triples, stack.Rows
Three, Matrix = stack.Three, stack.Matrix
three_of, matrix_of = stack.three_of, stack.matrix_of
meet = impulse_stack.meet

TRIES = 400
"""Tries of states before a stack is given up."""
CLOSE_TRIES = 6
"""Tries that sweep on from the last solution, not from the last sweep."""
ROUND_OFF = real(1.0e-10 if PRECISION == "float64" else 2.0e-3)
"""Residual that counts as none, over the velocities that the solve starts from."""
BARELY = real(1.0 - 1.0e-9)
"""Part of its bound from which on a friction counts as sliding."""


@wp.struct
class Shapes:
    """What the blocks of one lane are; CFM in 1/kg."""

    face: Values
    high: Values
    inverse_mass: Values
    inverse_inertia: Values
    friction: Values


@wp.struct
class Pose:
    """Where the blocks of one lane are."""

    x: Values
    z: Values
    sine: Values
    cosine: Values


@wp.struct
class Equations:
    """The problem of one step: D and E by rows, q, and the bounds of the box."""

    own: Rows
    above: Rows
    free: Triples
    bound: Values
    friction: Values
    slack: real


@wp.func
def interface_rows(shapes: Shapes, pose: Pose, k: int, lean: real):
    """Relative velocities at interface k from those of its blocks.

    Returns:
        Matrix of the upper block (rows: ends 1 and 2, slip; columns: x, z, rotation), of the
        lower one, and the gaps at both ends [m].
    """
    lface = real(impulse_stack.GROUND_FACE)
    lhigh = real(0.0)
    ls = real(0.0)
    lc = real(1.0)
    dx = pose.x[k]
    dz = pose.z[k]
    if k > 0:
        lface = shapes.face[k - 1]
        lhigh = shapes.high[k - 1]
        ls = pose.sine[k - 1]
        lc = pose.cosine[k - 1]
        dx = dx - pose.x[k - 1]
        dz = dz - pose.z[k - 1]
    nx1, nz1, au1, bu1 = real(0.0), real(0.0), real(0.0), real(0.0)
    al1, bl1, gap1 = real(0.0), real(0.0), real(0.0)
    nx2, nz2, au2, bu2 = real(0.0), real(0.0), real(0.0), real(0.0)
    al2, bl2, gap2 = real(0.0), real(0.0), real(0.0)
    face, high, s, c = shapes.face[k], shapes.high[k], pose.sine[k], pose.cosine[k]
    meet(-lean, face, high, s, c, lface, lhigh, ls, lc, dx, dz, nx1, nz1, au1, bu1, al1, bl1, gap1)
    meet(lean, face, high, s, c, lface, lhigh, ls, lc, dx, dz, nx2, nz2, au2, bu2, al2, bl2, gap2)
    upper = Matrix(nx1, nz1, -au1, nx2, nz2, -au2, lean * nz2, -lean * nx2, lean * bu2)
    lower = Matrix(-nx1, -nz1, al1, -nx2, -nz2, al2, -lean * nz2, lean * nx2, -lean * bl2)
    return upper, lower, gap1, gap2


@wp.func
def weighted(rows: Matrix, shapes: Shapes, k: int) -> Matrix:
    """Rows of an interface times the inverse masses of block k."""
    m = shapes.inverse_mass[k]
    return rows * wp.diag(Three(m, m, shapes.inverse_inertia[k]))


@wp.func
def with_rows(rows: Rows, k: int, m: Matrix) -> Rows:
    """Rows with the matrix of one interface put in."""
    found = rows
    for i in range(3):
        for j in range(3):
            found[3 * k + i, j] = m[i, j]
    return found


@wp.func
def with_three(values: Triples, k: int, t: Three) -> Triples:
    """Numbers with those of one interface put in."""
    found = values
    for i in range(3):
        found[3 * k + i] = t[i]
    return found


@wp.func
def coupled(system: Equations, p: Triples, k: int) -> Three:
    """Relative velocities at interface k above the wishes, without its own impulses."""
    q = three_of(system.free, k)
    if k > 0:
        q = q + wp.transpose(matrix_of(system.above, k - 1)) * three_of(p, k - 1)
    if k < BLOCKS - 1:
        q = q + matrix_of(system.above, k) * three_of(p, k + 1)
    return q


@wp.func
def broken(system: Equations, p: Triples) -> real:
    """Largest residual of the laws in all interfaces [m/s]; not a number where p is none."""
    worst = real(0.0)
    for k in range(BLOCKS):
        d = matrix_of(system.own, k)
        q = coupled(system, p, k)
        miss = direct.residual(
            system.friction[k], system.bound[k],
            d[0, 0], d[0, 1], d[1, 1], d[0, 2], d[1, 2], d[2, 2], q[0], q[1], q[2],
            p[3 * k], p[3 * k + 1], p[3 * k + 2],
        )  # fmt: skip
        worst = wp.where(miss > worst or miss != miss, miss, worst)
    return worst


@wp.func
def swept(system: Equations, p: Triples) -> Triples:
    """The impulses after a sweep over the interfaces, from the ground up."""
    found = p
    for k in range(BLOCKS):
        d = matrix_of(system.own, k)
        q = coupled(system, found, k)
        _miss, n1, n2, f = direct.solve(
            system.friction[k], system.bound[k],
            d[0, 0], d[0, 1], d[1, 1], d[0, 2], d[1, 2], d[2, 2], q[0], q[1], q[2],
        )  # fmt: skip
        found = with_three(found, k, Three(n1, n2, f))
    return found


@wp.func
def of_states(system: Equations, p: Triples) -> Triples:
    """Solution of the linear equations of the states that impulses are in."""
    zero = real(0.0)
    one = real(1.0)
    reach = Rows()
    part = Triples()
    for k in range(BLOCKS):
        mu = system.friction[k]
        bound = system.bound[k]
        on1 = wp.where(p[3 * k] > zero, one, zero)
        on2 = wp.where(p[3 * k + 1] > zero, one, zero)
        f = p[3 * k + 2]
        limit = bound + mu * (p[3 * k] + p[3 * k + 1])
        side = scalar.sign_of(f)
        slides = size(f) >= BARELY * limit
        sticks = wp.where(slides, zero, one)
        drag = wp.where(slides, side, zero)
        keep = wp.diag(Three(on1, on2, sticks))
        rest = Matrix(
            one - on1, zero, zero, zero, one - on2, zero, -drag * mu, -drag * mu, one - sticks
        )
        matrix = keep * matrix_of(system.own, k) + rest
        right = Three(zero, zero, drag * bound) - keep * three_of(system.free, k)
        if k > 0:
            down = keep * wp.transpose(matrix_of(system.above, k - 1))
            matrix = matrix - down * matrix_of(reach, k - 1)
            right = right - down * three_of(part, k - 1)
        inverse = wp.inverse(matrix)
        part = with_three(part, k, inverse * right)
        reach = with_rows(reach, k, inverse * (keep * matrix_of(system.above, k)))
    for step in range(1, BLOCKS):
        k = BLOCKS - 1 - step
        last = three_of(part, k) - matrix_of(reach, k) * three_of(part, k + 1)
        part = with_three(part, k, last)
    return part


@wp.func
def solve_stack(system: Equations, guess: Triples):
    """Impulses of all interfaces, exactly.

    Args:
        system: The problem.
        guess: Impulses in whose states the solution is sought first.

    Returns:
        Impulses; whether they are a solution; tries that it took.
    """
    p = guess
    found = guess
    solved = bool(False)
    tries = int(0)
    while not solved and tries < TRIES:
        if tries > 0:
            p = swept(system, p)
        found = of_states(system, p)
        miss = broken(system, found)
        solved = miss <= system.slack
        if tries < CLOSE_TRIES and miss == miss:
            p = found
        tries += 1
    return found, solved, tries
