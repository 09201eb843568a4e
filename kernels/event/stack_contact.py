"""Contact of stacked planar blocks: exact, or reported as unsolved.

The contact law at an interface, impulses and velocities as in event/stack_chain.py: n >= 0; an end
that touches does not sink; an end without n opens; a contact sticks with |f| <= mu (n + n), or
slides with f = -slip mu (n + n). A *state* says which ends are held (`hold`, a sum of ends) and
`slip` (-1, 1, or 0 where it sticks); given all states the system is linear and solved at once. If
a guess breaks the law, a path leads from it to states that obey it (event/stack_path.py), or one
from open contacts; where directions of sliding are given and none obeys it, friction finds its own.
"""

import warp as wp

from warprock.kernels.event.stack_chain import (
    Couplings,
    Factors,
    couplings_of,
    eliminated,
    impulses_of,
    pushed,
    relative_velocities,
    responses,
    sound,
)
from warprock.kernels.event.stack_path import followed, from_open, near_guess
from warprock.kernels.shape.stack import MINUS, PLUS, Blocks, Counts, Rows, Three, Triples, three_of

ATTEMPTS = 4
"""Paths: from the guess and from open contacts; twice from those without given sliding."""
IMPOSSIBLE = real(1.0e30)


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
def broken(
    c: Couplings, touch: Counts, glide: Counts, hold: Counts, slip: Counts, q: Triples, p: Triples,
    grain: real, mass: real,
) -> real:  # fmt: skip
    """The largest `violation` of all interfaces."""
    worst = real(0.0)
    u = responses(c, q, p)
    for k in range(BLOCKS):
        if touch[k] != 0:
            found = violation(
                three_of(p, k), three_of(u, wp.static(k)), touch[k], hold[k], slip[k],
                c.friction[k], glide[k] != 0 and slip[k] == glide[k], grain, mass,
            )  # fmt: skip
            worst = larger(worst, found)
    return worst


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
    c = couplings_of(blocks, upper, lower)
    q = relative_velocities(upper, lower, free)
    f = eliminated(c, hold, slip, Factors(), 0)
    p = impulses_of(c, f, hold, slip, q)
    left = spare(blocks, hold, slip, p)
    worst = IMPOSSIBLE
    if sound(f):
        worst = broken(c, touch, glide, hold, slip, q, p, grain, mass)
    held = hold
    slips = slip
    given = glide
    tries = int(0)
    while worst > real(1.0) and tries < ATTEMPTS:
        r = Triples()
        if tries == 0:
            r = near_guess(c, touch, glide, hold, slip, q, p)
        else:
            r = from_open(touch, q, tries)
            held = Counts()
            slips = Counts()
        if tries > 1:
            given = Counts()
        p, held, slips, arrived = followed(c, touch, given, held, slips, q, r)
        if arrived:
            worst = broken(c, touch, given, held, slips, q, p, grain, mass)
        tries += 1
    v = pushed(blocks, upper, lower, free, p)
    return v, p, held, slips, not (worst > real(1.0)), tries == 0, left
