"""Contact solve of a stack on compliant contacts, exact.

Each interface has two ends and one friction, as in direct/block.py: p = (n_1, n_2, f), n_1 at
the end away from the side to which it leans, n_2 and f at the other, f positive towards that side.
They act on the upper block and turn back on the lower one. With J the rows of the relative
velocities of an interface, upper and lower, W the inverse masses, they become

    w = q + D p + E_below^T p_below + E p_above,   D = J W J^T + CFM,   E = J_upper W J_lower'^T,

q being what there is without contact and the wishes of the ends (`wish` in direct/block.py). The
laws are those of direct/block.py, interface by interface. Given a state of all interfaces (which
ends carry, whether each sticks or to which side it slides) they are linear equations, block
tridiagonal, and solved by elimination from below; the states of the last step are tried first.
Where the solution breaks a law, a sweep over the interfaces from there (block Gauss-Seidel, each by
`solve_block`) proposes other states; if some sweeps do not find it, principal pivoting turns the
rows that break their law, all of them while they become fewer, else the first alone (Judice and
Pires 1994; finite with a box, whose matrix is positive definite). The first solution that keeps all
laws to round-off is taken, so the result is exact however it was found. A stack for which none is
found ends as UNSOLVED.
"""

import warp as wp

from warprock.kernels.direct.block import residual
from warprock.kernels.direct.block import solve as solve_block
from warprock.kernels.direct.stack_pivot import Equations, States, lemke
from warprock.kernels.shape.interface_flat import GROUND_FACE, find_end
from warprock.kernels.shape.stack import Matrix, Rows, Three, Triples, Values, matrix_of, three_of

TRIES = 50
"""Tries of states before Lemke's path is taken."""
SWEPT_TRIES = 6
"""First tries, from sweeps."""
PATIENCE = 10
"""Tries that turn all rows that break their law without there being fewer of them."""
ROUND_OFF = by_precision(1.0e-10, 1.0e-4)
"""Residual that counts as none, over the velocities that add up to it."""
BARELY = real(1.0 - 1.0e-9)
"""Part of its bound from which on a friction counts as sliding."""


@wp.struct
class Shapes:
    """What the blocks of one lane are; CFM in 1/kg."""

    half_width: Values
    half_height: Values
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


@wp.func
def interface_rows(shapes: Shapes, pose: Pose, k: int, lean: real):
    """Relative velocities at interface k from those of its blocks.

    Returns:
        Matrix of the upper block (rows: ends 1 and 2, slip; columns: x, z, rotation), of the
        lower one, and the gaps at both ends [m].
    """
    lhalf_width = GROUND_FACE
    lhalf_height = real(0.0)
    ls = real(0.0)
    lc = real(1.0)
    dx = pose.x[k]
    dz = pose.z[k]
    if k > 0:
        lhalf_width = shapes.half_width[k - 1]
        lhalf_height = shapes.half_height[k - 1]
        ls = pose.sine[k - 1]
        lc = pose.cosine[k - 1]
        dx = dx - pose.x[k - 1]
        dz = dz - pose.z[k - 1]
    half_width, half_height = shapes.half_width[k], shapes.half_height[k]
    s, c = pose.sine[k], pose.cosine[k]
    nx1, nz1, au1, _bu1, al1, _bl1, gap1, _place1 = find_end(
        -lean, half_width, half_height, s, c, lhalf_width, lhalf_height, ls, lc, dx, dz
    )
    nx2, nz2, au2, bu2, al2, bl2, gap2, _place2 = find_end(
        lean, half_width, half_height, s, c, lhalf_width, lhalf_height, ls, lc, dx, dz
    )
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
def kept(system: Equations, p: Triples) -> bool:
    """Whether impulses keep the laws of all interfaces to round-off."""
    worst = real(0.0)
    scale = real(0.0)
    for k in range(BLOCKS):
        d = matrix_of(system.own, k)
        q = coupled(system, p, k)
        force = three_of(p, k)
        miss = residual(
            system.friction[k], system.bound[k],
            d[0, 0], d[0, 1], d[1, 1], d[0, 2], d[1, 2], d[2, 2], q[0], q[1], q[2],
            force[0], force[1], force[2],
        )  # fmt: skip
        worst = wp.where(miss > worst or miss != miss, miss, worst)
        for i in range(3):
            scale += size(system.free[3 * k + i]) + d[i, i] * size(force[i])
    return worst <= ROUND_OFF * scale


@wp.func
def swept(system: Equations, p: Triples) -> Triples:
    """The impulses after a sweep over the interfaces, from the ground up."""
    found = p
    for k in range(BLOCKS):
        d = matrix_of(system.own, k)
        q = coupled(system, found, k)
        _miss, n1, n2, f = solve_block(
            system.friction[k], system.bound[k],
            d[0, 0], d[0, 1], d[1, 1], d[0, 2], d[1, 2], d[2, 2], q[0], q[1], q[2],
        )  # fmt: skip
        found = with_three(found, k, Three(n1, n2, f))
    return found


@wp.func
def states_of(system: Equations, p: Triples) -> States:
    """The states that impulses are in."""
    found = States()
    for k in range(BLOCKS):
        f = p[3 * k + 2]
        limit = system.bound[k] + system.friction[k] * (p[3 * k] + p[3 * k + 1])
        found[3 * k] = wp.where(p[3 * k] > real(0.0), 1, 0)
        found[3 * k + 1] = wp.where(p[3 * k + 1] > real(0.0), 1, 0)
        side = wp.where(f < real(0.0), -1, 1)
        found[3 * k + 2] = wp.where(size(f) >= BARELY * limit, side, 0)
    return found


@wp.func
def pivoted(system: Equations, states: States, p: Triples, first_only: bool):
    """States with those rows turned that break their law, all or the first one alone.

    Args:
        system: The problem.
        states: States of the rows.
        p: Their solution.
        first_only: Whether to turn but one.

    Returns:
        States; rows that break their law.
    """
    zero = real(0.0)
    found = states
    count = int(0)
    for k in range(BLOCKS):
        d = matrix_of(system.own, k)
        force = three_of(p, k)
        w = coupled(system, p, k) + d * force
        limit = system.bound[k] + system.friction[k] * (force[0] + force[1])
        for i in range(3):
            row = 3 * k + i
            turned = 1 - states[row]
            breaks = wp.where(states[row] == 1, force[i] < zero, w[i] < zero)
            if i == 2:
                drag = states[row]
                turned = wp.where(drag != 0, 0, wp.where(force[i] < zero, -1, 1))
                breaks = wp.where(drag == 0, size(force[i]) > limit, real(drag) * w[i] > zero)
            if breaks and (count == 0 or not first_only):
                found[row] = turned
            if breaks:
                count += 1
    return found, count


@wp.func
def of_states(system: Equations, states: States) -> Triples:
    """Solution of the linear equations of given states."""
    zero = real(0.0)
    one = real(1.0)
    reach = Rows()
    part = Triples()
    for k in range(BLOCKS):
        mu = system.friction[k]
        bound = system.bound[k]
        on1 = real(states[3 * k])
        on2 = real(states[3 * k + 1])
        drag = real(states[3 * k + 2])
        sticks = one - size(drag)
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
def solve(system: Equations, guess: Triples):
    """Impulses of all interfaces, exactly.

    Args:
        system: The problem.
        guess: Impulses in whose states the solution is sought first.

    Returns:
        Impulses; whether they are a solution; tries that it took.
    """
    states = states_of(system, guess)
    found = guess
    solved = bool(False)
    tries = int(0)
    fewest = int(3 * BLOCKS + 1)
    patience = int(0)
    while not solved and tries < TRIES:
        found = of_states(system, states)
        solved = kept(system, found)
        tries += 1
        if not solved and tries == TRIES:
            found = of_states(system, lemke(system))
            solved = kept(system, found)
        elif not solved and tries <= SWEPT_TRIES:
            states = states_of(system, swept(system, found))
        elif not solved:
            turned, count = pivoted(system, states, found, patience < 0)
            patience = wp.where(count < fewest, PATIENCE, patience - 1)
            fewest = wp.where(count < fewest, count, fewest)
            states = turned
    return found, solved, tries
