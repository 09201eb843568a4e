"""Contact solve of a stack on compliant contacts, exact.

Each interface has two ends and one friction, as in direct/block.py: p = (n_1, n_2, f), n_1 at
the end away from the side to which it leans, n_2 and f at the other, f positive towards that side.
They act on the upper block and turn back on the lower one. With J the rows of the relative
velocities of an interface, upper and lower, W the inverse masses, they become

    w = q + D p + E_below^T p_below + E p_above,   D = J W J^T + CFM,   E = J_upper W J_lower'^T,

q the velocities without contact plus the allowed closing of the ends (`allowed_closing` in
direct/block.py). The laws are those of direct/block.py, interface by interface. A state says which
ends carry, and whether each interface sticks or to which side it slides. For a given state the laws
are linear equations, block tridiagonal, solved by elimination from below. States are tried in this
order, until a solution keeps all laws to round-off, so the result is exact however it is found:

    1. the states of the last step;
    2. states proposed by sweeps over the interfaces from there (block Gauss-Seidel, each interface
       by `solve_contacts`);
    3. principal pivoting, which changes the state of the rows that break their law: of all while
       their number falls, else of the first one (Judice and Pires 1994; finite with a box, whose
       matrix is positive definite);
    4. Lemke's path (direct/stack_pivot.py).

A stack without a solution ends as UNSOLVED.
"""

import warp as wp

from warprock.kernels.direct.block import Problem, residual_of, solve_contacts
from warprock.kernels.direct.stack_pivot import Equations, States, lemke
from warprock.kernels.shape.interface import Box, Pose, find_end
from warprock.kernels.shape.stack import Matrix, Rows, Three, Triples, Values, matrix_of, three_of
from warprock.kernels.shape.stack_run import ground

TRIES = 50
"""Number of states that are tried before Lemke's path."""
SWEPT_TRIES = 6
"""Number of these that sweeps propose, the first ones."""
PATIENCE = 10
"""Number of pivots in all rows that break their law without their number falling."""
ROUND_OFF = by_precision(1.0e-10, 1.0e-4)
"""Residual that counts as round-off, over the velocities of which it is a sum."""
BARELY = real(1.0 - 1.0e-9)
"""Friction above this part of its bound counts as sliding."""


@wp.struct
class Shapes:
    """Sizes, masses and contact properties of the blocks of one lane; CFM in 1/kg."""

    half_width: Values
    half_height: Values
    inverse_mass: Values
    inverse_inertia: Values
    friction: Values


@wp.struct
class Poses:
    """Poses of the blocks of one lane, see `Pose` in shape/interface.py."""

    x: Values
    z: Values
    theta: Values
    s: Values
    c: Values


@wp.func
def box_of(shapes: Shapes, k: int) -> Box:
    """The half sizes of block k; block -1 is the ground."""
    if k < 0:
        return ground()
    return Box(shapes.half_width[k], shapes.half_height[k])


@wp.func
def pose_of(poses: Poses, k: int) -> Pose:
    """Pose of block k; block -1 is the ground."""
    zero = real(0.0)
    if k < 0:
        return Pose(zero, zero, zero, zero, real(1.0))
    return Pose(poses.x[k], poses.z[k], poses.theta[k], poses.s[k], poses.c[k])


@wp.func
def interface_rows(shapes: Shapes, poses: Poses, k: int, lean: real):
    """Relative velocities at interface k from those of its blocks.

    Returns:
        Matrix of the upper block (rows: ends 1 and 2, slip; columns: x, z, rotation), of the
        lower one, and the gaps at both ends [m].
    """
    box, at = box_of(shapes, k), pose_of(poses, k)
    low_box, below = box_of(shapes, k - 1), pose_of(poses, k - 1)
    a, gap1, _place1 = find_end(-lean, box, at, low_box, below)
    b, gap2, _place2 = find_end(lean, box, at, low_box, below)
    upper = Matrix(
        a.nx, a.nz, -a.au, b.nx, b.nz, -b.au, lean * b.nz, -lean * b.nx, lean * b.bu
    )  # fmt: skip
    lower = Matrix(
        -a.nx, -a.nz, a.al, -b.nx, -b.nz, b.al, -lean * b.nz, lean * b.nx, -lean * b.bl
    )  # fmt: skip
    return upper, lower, gap1, gap2


@wp.func
def times_inverse_mass(rows: Matrix, shapes: Shapes, k: int) -> Matrix:
    """Rows of an interface times the inverse masses of block k."""
    m = shapes.inverse_mass[k]
    return rows * wp.diag(Three(m, m, shapes.inverse_inertia[k]))


@wp.func
def set_rows(rows: Rows, k: int, m: Matrix) -> Rows:
    """Rows with the matrix of one interface replaced."""
    found = rows
    for i in range(3):
        for j in range(3):
            found[3 * k + i, j] = m[i, j]
    return found


@wp.func
def set_three(values: Triples, k: int, t: Three) -> Triples:
    """Numbers with those of one interface replaced."""
    found = values
    for i in range(3):
        found[3 * k + i] = t[i]
    return found


@wp.func
def velocities_without(system: Equations, p: Triples, k: int) -> Three:
    """Relative velocities at interface k plus the allowed closing, without its own impulses."""
    q = three_of(system.free, k)
    if k > 0:
        q = q + wp.transpose(matrix_of(system.above, k - 1)) * three_of(p, k - 1)
    if k < BLOCKS - 1:
        q = q + matrix_of(system.above, k) * three_of(p, k + 1)
    return q


@wp.func
def problem_of(system: Equations, p: Triples, k: int) -> Problem:
    """The contact problem of interface k alone, given the impulses of the others."""
    d, q = matrix_of(system.own, k), velocities_without(system, p, k)
    return Problem(
        system.friction[k], system.bound[k],
        d[0, 0], d[0, 1], d[1, 1], d[0, 2], d[1, 2], d[2, 2], q[0], q[1], q[2],
    )  # fmt: skip


@wp.func
def keeps_laws(system: Equations, p: Triples) -> bool:
    """Whether impulses keep the laws of all interfaces to round-off."""
    worst = real(0.0)
    scale = real(0.0)
    for k in range(BLOCKS):
        d = matrix_of(system.own, k)
        force = three_of(p, k)
        miss = residual_of(problem_of(system, p, k), force[0], force[1], force[2])
        worst = wp.where(miss > worst or miss != miss, miss, worst)
        for i in range(3):
            scale += size(system.free[3 * k + i]) + d[i, i] * size(force[i])
    return worst <= ROUND_OFF * scale


@wp.func
def sweep(system: Equations, p: Triples) -> Triples:
    """The impulses after a sweep over the interfaces, from the ground up."""
    found = p
    for k in range(BLOCKS):
        own = solve_contacts(problem_of(system, found, k))
        found = set_three(found, k, Three(own.n1, own.n2, own.f))
    return found


@wp.func
def states_of(system: Equations, p: Triples) -> States:
    """States of the rows, from impulses."""
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
def pivot(system: Equations, states: States, p: Triples, first_only: bool):
    """States after a principal pivot in all rows that break their law, or in the first one.

    Args:
        system: The problem.
        states: States of the rows.
        p: Their solution.
        first_only: Whether to pivot in one row only.

    Returns:
        States; rows that break their law.
    """
    zero = real(0.0)
    found = states
    count = int(0)
    for k in range(BLOCKS):
        d = matrix_of(system.own, k)
        force = three_of(p, k)
        w = velocities_without(system, p, k) + d * force
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
def solve_states(system: Equations, states: States) -> Triples:
    """Solution of the linear equations for given states."""
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
        part = set_three(part, k, inverse * right)
        reach = set_rows(reach, k, inverse * (keep * matrix_of(system.above, k)))
    for step in range(1, BLOCKS):
        k = BLOCKS - 1 - step
        last = three_of(part, k) - matrix_of(reach, k) * three_of(part, k + 1)
        part = set_three(part, k, last)
    return part


@wp.func
def solve(system: Equations, guess: Triples):
    """Impulses of all interfaces, exactly.

    Args:
        system: The problem.
        guess: Impulses whose states are tried first.

    Returns:
        Impulses; whether they are a solution; number of states tried.
    """
    states = states_of(system, guess)
    found = guess
    solved = bool(False)
    tries = int(0)
    fewest = int(3 * BLOCKS + 1)
    patience = int(0)
    while not solved and tries < TRIES:
        found = solve_states(system, states)
        solved = keeps_laws(system, found)
        tries += 1
        if not solved and tries == TRIES:
            found = solve_states(system, lemke(system))
            solved = keeps_laws(system, found)
        elif not solved and tries <= SWEPT_TRIES:
            states = states_of(system, sweep(system, found))
        elif not solved:
            turned, count = pivot(system, states, found, patience < 0)
            patience = wp.where(count < fewest, PATIENCE, patience - 1)
            fewest = wp.where(count < fewest, count, fewest)
            states = turned
    return found, solved, tries
