"""Lemke's pivoting for the contacts of a stack.

The laws of direct/stack.py are one linear complementarity problem y = M x + q, y >= 0, x >= 0,
y x = 0, with five pairs an interface (Stewart and Trinkle 1996):

- for each of both ends, its normal impulse and its velocity plus the allowed closing;
- for each side, the friction to that side, f = f+ - f-, and the slip against it plus lambda;
- lambda, the size of the slip, and the margin of the friction to its bound.

M is copositive, so the path that starts from a large z on every row ends at a solution (Anitescu
and Potra 1997). Bounds of zero would make ties, at which the path can end or cycle. So bounds are
widened a little here, each by a different amount, and only the states at the end are used. The
table is dense and the path starts without a guess: this is the last resort.
"""

import warp as wp

from warprock.kernels.shape.stack import Matrix, Rows, Triples, Values, matrix_of

COUNT = 5 * BLOCKS
"""Pairs."""
CONSTANT = COUNT + 1
"""Column of the constants in the table of a path."""
PIVOTS = 20 * COUNT
"""Pivots before the path is given up."""
FAR = real(1.0e30)
TILT = by_precision(1.0e-8, 1.0e-5)
"""Widening of the bounds, over the friction that would stop the velocities without contact."""
APART = real(1.25)
"""Ratio of the widening of an interface to that of the one below it."""

States = wp.types.vector(length=3 * BLOCKS, dtype=int)
"""State of every row: an end carries (1) or not (0); a face sticks (0) or slides (-1 or 1, the side
of its friction)."""
Names = wp.types.vector(length=COUNT + 1, dtype=int)
"""Variables by number: i is y_i, COUNT + i is x_i, 2 COUNT is z."""
Table = wp.types.matrix(shape=(COUNT, COUNT + 2), dtype=real)
"""Basic variables in terms of the others, one a column, z and the constant in the last two."""


@wp.struct
class Equations:
    """The problem of one step: D and E by rows, q, and the friction and bound of each face."""

    own: Rows
    above: Rows
    free: Triples
    bound: Values
    friction: Values


@wp.func
def set_block(table: Table, k: int, other: int, m: Matrix) -> Table:
    """The table with the block of the impulses of one interface at another set."""
    found = table
    for i in range(4):
        low = wp.where(i == 3, 2, i)
        sign = wp.where(i == 3, real(-1.0), real(1.0))
        for j in range(3):
            found[5 * k + i, 5 * other + j] = sign * m[low, j]
        found[5 * k + i, 5 * other + 3] = -sign * m[low, 2]
    return found


@wp.func
def table_of(system: Equations) -> Table:
    """The table at the start: y in terms of x and z."""
    one = real(1.0)
    table = Table()
    skew = real(0.0)
    for i in range(3 * BLOCKS):
        skew += TILT * size(system.free[i])
    for k in range(BLOCKS):
        d = matrix_of(system.own, k)
        table = set_block(table, k, k, d)
        if k > 0:
            table = set_block(table, k, k - 1, wp.transpose(matrix_of(system.above, k - 1)))
        if k < BLOCKS - 1:
            table = set_block(table, k, k + 1, matrix_of(system.above, k))
        last = 5 * k + 4
        for i in range(2):
            table[5 * k + 2 + i, last] = one
            table[last, 5 * k + i] = system.friction[k]
            table[last, 5 * k + 2 + i] = -one
        for i in range(3):
            table[5 * k + i, CONSTANT] = system.free[3 * k + i]
        table[5 * k + 3, CONSTANT] = -system.free[3 * k + 2]
        table[last, CONSTANT] = system.bound[k] + skew / d[2, 2]
        skew = APART * skew
        for i in range(4):
            table[5 * k + i, COUNT] = one
        table[last, COUNT] = one / d[2, 2]
    return table


@wp.func
def exchange(table: Table, row: int, column: int) -> Table:
    """The table after a pivot: the basic variable of a row and the one of a column swap."""
    found = table
    scale = real(1.0) / table[row, column]
    for j in range(COUNT + 2):
        found[row, j] = -scale * table[row, j]
    found[row, column] = scale
    for i in range(COUNT):
        if i != row:
            part = table[i, column]
            for j in range(COUNT + 2):
                found[i, j] = table[i, j] + part * found[row, j]
            found[i, column] = part * scale
    return found


@wp.func
def leaving_row(table: Table, basic: Names, column: int) -> int:
    """Ratio test: the leaving row for an entering column; z wins ties; -1 if there is none."""
    row = int(-1)
    least = FAR
    for i in range(COUNT):
        slope = table[i, column]
        if slope < real(0.0):
            reach = table[i, CONSTANT] / -slope
            if reach < least or (reach == least and basic[i] == 2 * COUNT):
                least = reach
                row = i
    return row


@wp.func
def first_row(table: Table) -> int:
    """Row that needs the largest z to start from; -1 if no row needs one."""
    row = int(-1)
    most = real(0.0)
    for i in range(COUNT):
        ask = -table[i, CONSTANT] / table[i, COUNT]
        if ask > most:
            most = ask
            row = i
    return row


@wp.func
def states_of(basic: Names) -> States:
    """States of the rows, from the variables that are not zero."""
    used = States()
    slips = States()
    states = States()
    for i in range(COUNT):
        pair = basic[i] - COUNT
        if pair >= 0 and pair < COUNT:
            k = pair // 5
            part = pair % 5
            if part < 2:
                states[3 * k + part] = 1
            if part == 2:
                used[3 * k + 1] = 1
            if part == 3:
                used[3 * k] = 1
            if part == 4:
                slips[k] = 1
    for k in range(BLOCKS):
        # Friction to both sides is below its bound; friction to none has a bound of zero.
        side = wp.where(used[3 * k] == 1, -1, 1)
        sticks = used[3 * k] == 1 and used[3 * k + 1] == 1
        states[3 * k + 2] = wp.where(sticks, 0, slips[k] * side)
    return states


@wp.func
def lemke(system: Equations) -> States:
    """States of a solution; if the path does not end, those in which no contact carries."""
    table = table_of(system)
    basic = Names()
    other = Names()
    for i in range(COUNT):
        basic[i] = i
        other[i] = COUNT + i
    other[COUNT] = 2 * COUNT
    row = first_row(table)
    column = int(COUNT)
    pivots = int(0)
    while row >= 0 and pivots < PIVOTS:
        pivots += 1
        table = exchange(table, row, column)
        left = basic[row]
        basic[row] = other[column]
        other[column] = left
        row = -1
        if left != 2 * COUNT:
            entering = (left + COUNT) % (2 * COUNT)
            for j in range(COUNT + 1):
                if other[j] == entering:
                    column = j
            row = leaving_row(table, basic, column)
    return states_of(basic)
