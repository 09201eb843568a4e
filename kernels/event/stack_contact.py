"""Contact of stacked planar blocks: exact, or reported as unsolved.

At each interface three impulses p = (f along the face, n at the + end, n at the - end) act on the
upper block, and -p on the lower one. Touching ends of closed faces move alike along them and share
f. With G the rows of `interface_rows` in shape/stack.py and W the inverse masses, relative
velocities become u + D p + couplings to the interfaces above and below: a block tridiagonal system.

The contact law at an interface: n >= 0; an end that touches does not sink; an end without n opens;
a contact sticks with |f| <= mu (n + n), or slides with f = -slip mu (n + n). A *state* says which
ends are held (`hold`, a sum of ends) and `slip` (-1, 1, or 0 where it sticks); given all states
the system is linear and solved at once (`bound_velocity`). If the states then break the law,
others are sought interface by interface (block Gauss-Seidel, each solved by trying its ten
states), and tried in the linear system again, until all fit. Where this goes in circles, one
interface after another takes the state that breaks the law least, from states at random where no
single change helps. What does not settle says so.
"""

import warp as wp

from warprock.kernels.shape.stack import (
    CLOSED,
    MINUS,
    PLUS,
    Blocks,
    Counts,
    Matrix,
    Rows,
    Three,
    Triples,
    matrix_of,
    three_of,
)

NEWTON_TRIES = 5
"""First tries of a round: a sweep from the last linear solution."""
SWEPT_TRIES = 9
"""Tries of a round until which it goes on sweeping; then interfaces are improved one by one, in
every other round from the start."""
ROUND = 12
"""Tries of a round; the first starts from the guess, the others from states at random."""
TRIES = 280
IMPOSSIBLE = real(1.0e30)


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
def violation(
    p: Three, u: Three, touch: int, hold: int, slip: int, mu: real, glides: bool,
    grain: real, mass: real,
) -> real:  # fmt: skip
    """How far a state breaks the contact law, 1 at what counts as round-off.

    Args:
        p: Impulses (along, at the + end, at the - end).
        u: Relative velocities with them.
        touch: Ends that touch.
        hold: Ends that are held.
        slip: Direction of sliding.
        mu: Friction coefficient.
        glides: Whether the direction of sliding is given and not to be tested.
        grain: Velocity that is round-off [m/s].
        mass: Mass that makes it an impulse [kg].
    """
    dust = grain * mass
    worst = real(0.0)
    if (hold & PLUS) != 0:
        worst = larger(worst, -p[1] / dust)
    elif (touch & PLUS) != 0:
        worst = larger(worst, -u[1] / grain)
    if (hold & MINUS) != 0:
        worst = larger(worst, -p[2] / dust)
    elif (touch & MINUS) != 0:
        worst = larger(worst, -u[2] / grain)
    if hold != 0:
        if slip == 0:
            worst = larger(worst, (size(p[0]) - mu * (p[1] + p[2])) / dust)
        elif not glides:
            worst = larger(worst, -real(slip) * u[0] / grain)
    return worst


@wp.func
def state_of(number: int):
    """Held ends and direction of sliding of one of the ten states of an interface."""
    hold = wp.where(number < 3, CLOSED, wp.where(number < 6, PLUS, wp.where(number < 9, MINUS, 0)))
    kind = number % 3
    return hold, wp.where(kind == 1, 1, wp.where(kind == 2, -1, 0))


@wp.func(inline=False)
def local_law(d: Matrix, u: Three, touch: int, glide: int, mu: real, grain: real, mass: real):
    """Impulses of one interface that obey the contact law, the others given.

    A contact that slides already (`glide`) first looks for a state that slides on.

    Returns:
        Impulses, held ends, direction of sliding.
    """
    best = IMPOSSIBLE
    found = Three()
    found_hold = int(0)
    found_slip = int(0)
    for number in range(20):
        given = number < 10
        hold, slip = state_of(number % 10)
        fits = glide != 0 and (hold == 0 or slip == glide)
        if best > real(1.0) and (hold & touch) == hold and (not given or fits):
            rows = held_rows(hold, slip)
            system = with_state(d, hold, slip, mu)
            p = wp.inverse(system) * wp.cw_mul(rows, -u)
            broken = violation(p, u + d * p, touch, hold, slip, mu, given, grain, mass)
            if wp.determinant(system) > real(0.0) and broken < best:
                best = broken
                found = p
                found_hold = hold
                found_slip = slip
    return found, found_hold, found_slip


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


@wp.func
def own_response(upper: Rows, lower: Rows, blocks: Blocks, k: int) -> Matrix:
    """What the impulses of interface k do to its own relative velocities."""
    up = matrix_of(upper, k)
    d = weighted(up, blocks, k) * wp.transpose(up)
    if k > 0:
        down = matrix_of(lower, k)
        d = d + weighted(down, blocks, k - 1) * wp.transpose(down)
    return d


@wp.func
def pushed(
    upper: Rows, lower: Rows, blocks: Blocks, velocity: Triples, p: Three, k: int
) -> Triples:
    """Velocities of all blocks after impulses at interface k."""
    v = velocity
    kick = wp.transpose(weighted(matrix_of(upper, k), blocks, k)) * p
    for i in range(3):
        v[3 * k + i] = v[3 * k + i] + kick[i]
    if k > 0:
        back = wp.transpose(weighted(matrix_of(lower, k), blocks, k - 1)) * p
        for i in range(3):
            v[3 * k - 3 + i] = v[3 * k - 3 + i] + back[i]
    return v


@wp.func(inline=False)
def bound_velocity(
    blocks: Blocks, upper: Rows, lower: Rows, hold: Counts, slip: Counts, free: Triples
):
    """Velocities and impulses under given states, by elimination from below.

    Returns:
        Velocities, impulses; whether the states can carry them at all (Painleve's paradox).
    """
    above = Rows()
    part = Triples()
    last = Three()
    reach = Matrix()
    sound = bool(True)
    for k in range(BLOCKS):
        rows = held_rows(hold[k], slip[k])
        up = matrix_of(upper, k)
        system = with_state(
            own_response(upper, lower, blocks, k), hold[k], slip[k], blocks.friction[k]
        )
        right = wp.cw_mul(rows, -relative_velocity(upper, lower, free, k))
        keep = wp.diag(rows)
        if k > 0:
            down = weighted(matrix_of(lower, k), blocks, k - 1)
            couple = keep * (down * wp.transpose(matrix_of(upper, k - 1)))
            right = right - couple * last
            system = system - couple * reach
        sound = sound and wp.determinant(system) > real(0.0)
        inverse = wp.inverse(system)
        last = inverse * right
        if k < BLOCKS - 1:
            reach = inverse * (
                keep * (weighted(up, blocks, k) * wp.transpose(matrix_of(lower, k + 1)))
            )
        for i in range(3):
            part[3 * k + i] = last[i]
            for j in range(3):
                above[3 * k + i, j] = reach[i, j]
    velocity = free
    p = Three()
    for step in range(BLOCKS):
        k = BLOCKS - 1 - step
        p = three_of(part, k) - matrix_of(above, k) * p
        for i in range(3):
            part[3 * k + i] = p[i]
        velocity = pushed(upper, lower, blocks, velocity, p, k)
    return velocity, part, sound


@wp.func(inline=False)
def tested(
    blocks: Blocks, upper: Rows, lower: Rows, touch: Counts, glide: Counts, hold: Counts,
    slip: Counts, free: Triples, grain: real, mass: real,
):  # fmt: skip
    """Velocities and impulses under given states, and the largest `violation` of all interfaces."""
    velocity, impulse, sound = bound_velocity(blocks, upper, lower, hold, slip, free)
    worst = real(0.0)
    for k in range(BLOCKS):
        if touch[k] != 0:
            broken = violation(
                three_of(impulse, k), relative_velocity(upper, lower, velocity, k), touch[k],
                hold[k], slip[k], blocks.friction[k], glide[k] != 0 and slip[k] == glide[k],
                grain, mass,
            )  # fmt: skip
            worst = larger(worst, broken)
    return velocity, impulse, wp.where(sound, worst, IMPOSSIBLE)


@wp.func(inline=False)
def solve_by_sweep(
    blocks: Blocks, upper: Rows, lower: Rows, touch: Counts, glide: Counts, hold: Counts,
    slip: Counts, velocity: Triples, impulse: Triples, grain: real, mass: real,
):  # fmt: skip
    """One Gauss-Seidel sweep: velocities, impulses and the states found on the way."""
    v = velocity
    p = impulse
    held = hold
    slips = slip
    for k in range(BLOCKS):
        if touch[k] != 0:
            d = own_response(upper, lower, blocks, k)
            old = three_of(p, k)
            u = relative_velocity(upper, lower, v, k) - d * old
            new, held_k, slip_k = local_law(
                d, u, touch[k], glide[k], blocks.friction[k], grain, mass
            )
            v = pushed(upper, lower, blocks, v, new - old, k)
            for i in range(3):
                p[3 * k + i] = new[i]
            held[k] = held_k
            slips[k] = slip_k
    return v, p, held, slips


@wp.func(inline=False)
def improved(
    blocks: Blocks, upper: Rows, lower: Rows, touch: Counts, glide: Counts, hold: Counts,
    slip: Counts, free: Triples, worst: real, grain: real, mass: real,
):  # fmt: skip
    """States that break the law less: each interface in turn takes the best of its ten states."""
    held = hold
    slips = slip
    least = worst
    for k in range(BLOCKS):
        held_k = held[k]
        slip_k = slips[k]
        for number in range(10):
            other, sliding = state_of(number)
            if (other & touch[k]) == other:
                held[k] = other
                slips[k] = sliding
                _v, _p, broken = tested(
                    blocks, upper, lower, touch, glide, held, slips, free, grain, mass
                )
                if broken < least:
                    least = broken
                    held_k = other
                    slip_k = sliding
        held[k] = held_k
        slips[k] = slip_k
    return held, slips


@wp.func
def spare(blocks: Blocks, hold: Counts, slip: Counts, impulse: Triples) -> real:
    """Margin of the weakest held end before it opens, or of a sticking contact before it slides."""
    least = IMPOSSIBLE
    for k in range(BLOCKS):
        p = three_of(impulse, k)
        if (hold[k] & PLUS) != 0:
            least = smaller(least, p[1])
        if (hold[k] & MINUS) != 0:
            least = smaller(least, p[2])
        if hold[k] != 0 and slip[k] == 0:
            least = smaller(least, blocks.friction[k] * (p[1] + p[2]) - size(p[0]))
    return least


@wp.func(inline=False)
def solve(
    blocks: Blocks, upper: Rows, lower: Rows, touch: Counts, glide: Counts, hold: Counts,
    slip: Counts, free: Triples, grain: real, mass: real,
):  # fmt: skip
    """Velocities that obey the contact law.

    Args:
        blocks: The blocks.
        upper: Rows of the upper blocks.
        lower: Rows of the lower blocks.
        touch: Ends that touch.
        glide: Directions of sliding that are given, 0 where friction finds its own.
        hold: Ends held, as a first guess.
        slip: Directions of sliding, as a first guess.
        free: Velocities without contact.
        grain: See `violation`.
        mass: See `violation`.

    Returns:
        Velocities, impulses, held ends, directions of sliding; whether all obey the law; whether
        the first guess did, and its `spare`.
    """
    v = Triples()
    p = Triples()
    swept_v = Triples()
    swept_p = Triples()
    held = hold
    slips = slip
    left = real(0.0)
    worst = IMPOSSIBLE
    tries = int(0)
    dice = int(1)
    while worst > real(1.0) and tries < TRIES:
        phase = tries % ROUND
        if tries > 0 and phase == 0:
            for k in range(BLOCKS):
                dice = dice * 75 % 65537
                held[k] = dice % 4 & touch[k]
                dice = dice * 75 % 65537
                slips[k] = wp.where(held[k] != 0, dice % 3 - 1, 0)
        v, p, worst = tested(blocks, upper, lower, touch, glide, held, slips, free, grain, mass)
        if tries == 0:
            left = spare(blocks, hold, slip, p)
        if worst > real(1.0):
            if phase < SWEPT_TRIES and tries // ROUND % 2 == 0:
                if phase < NEWTON_TRIES:
                    swept_v = v
                    swept_p = p
                swept_v, swept_p, held, slips = solve_by_sweep(
                    blocks, upper, lower, touch, glide, held, slips, swept_v, swept_p, grain, mass
                )
            else:
                held, slips = improved(
                    blocks, upper, lower, touch, glide, held, slips, free, worst, grain, mass
                )
        tries += 1
    return v, p, held, slips, not (worst > real(1.0)), tries == 1, left
