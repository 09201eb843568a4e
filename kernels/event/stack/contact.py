"""Coulomb's law at all contacts of a stack in the plane: exact, or reported as unsolved.

The contact law at an interface, with impulses and velocities as in event/stack/chain.py: n >= 0; an
end that touches does not sink; an end without n opens; a contact sticks with |f| <= mu (n + n), or
slides with f = -slip mu (n + n). A *state* says which ends are held (`hold`, a sum of ends) and in
which direction an interface slides (`slip`: -1, 1, or 0 if it sticks). With the states of all
interfaces given the system is linear and solved at once. If the first guess breaks the law, a path
leads from it to a state that obeys the law (event/stack/path.py); if that path fails, another one
starts at open contacts. If directions of sliding are given and no state obeys the law with them,
friction finds its own.
"""

import warp as wp

from warprock.kernels.event.stack.chain import (
    Contacts,
    Factors,
    apply_impulses,
    couple,
    eliminate,
    find_impulses,
    is_positive,
    relative_velocities,
    respond,
)
from warprock.kernels.event.stack.path import (
    ENDS_OF_LAW,
    STOPS,
    Contact,
    Line,
    Problem,
    applies,
    bears,
    contact_of,
    follow_path,
    margin,
    path_from_guess,
    path_from_open,
)
from warprock.kernels.shape.stack import (
    PLUS,
    Blocks,
    Counts,
    Jacobian,
    Three,
    Triples,
    three_of,
)

ATTEMPTS = 4
"""Paths: from the guess and from open contacts; twice from those without given sliding."""
IMPOSSIBLE = real(1.0e30)


@wp.struct
class RoundOff:
    """What counts as round-off: a velocity [m/s] and an impulse [N s]."""

    velocity: real
    impulse: real


@wp.struct
class Solution:
    """What `solve` finds.

    Attributes:
        velocity: Velocities of the blocks.
        impulse: Impulses at the interfaces [N s].
        contacts: State of the interfaces.
        solved: Whether it obeys the contact law.
        guessed: Whether it is the first guess.
        spare: Margin of the weakest contact in the state of the first guess [N s], see `spare_of`.
    """

    velocity: Triples
    impulse: Triples
    contacts: Contacts
    solved: bool
    guessed: bool
    spare: real


@wp.func
def violation(p: Three, u: Three, contact: Contact, dust: RoundOff) -> real:
    """By how much an interface breaks the contact law, over what counts as round-off.

    Args:
        p: Its impulses.
        u: Its relative velocities with them.
        contact: Its state.
        dust: What counts as round-off.
    """
    worst = real(0.0)
    for code in range(PLUS, ENDS_OF_LAW):
        if applies(code, contact):
            grain = wp.where(bears(code, contact), dust.impulse, dust.velocity)
            worst = larger(worst, -margin(code, p, u, contact) / grain)
    return worst


@wp.func
def worst_violation(
    problem: wp.ref[Problem], contacts: wp.ref[Contacts], line: wp.ref[Line], dust: RoundOff
) -> real:
    """The largest `violation` of all interfaces."""
    worst = real(0.0)
    for k in range(BLOCKS):
        contact = contact_of(problem, contacts, wp.static(k))
        if contact.touch != 0:
            p, u = three_of(line.impulse, k), three_of(line.velocity, k)
            worst = larger(worst, violation(p, u, contact, dust))
    return worst


@wp.func
def spare_of(
    problem: wp.ref[Problem], contacts: wp.ref[Contacts], impulse: wp.ref[Triples]
) -> real:  # fmt: skip
    """Margin of the weakest contact before a held end opens or one that sticks slides [N s]."""
    least = IMPOSSIBLE
    for k in range(BLOCKS):
        contact = contact_of(problem, contacts, k)
        p = three_of(impulse, k)
        for code in range(PLUS, STOPS):
            if bears(code, contact):
                least = smaller(least, margin(code, p, Three(), contact))
    return least


@wp.func(inline=False)
def solve(
    blocks: wp.ref[Blocks], g: wp.ref[Jacobian], touch: Counts, glide: Counts,
    free: wp.ref[Triples], dust: RoundOff, shift: Triples, found: wp.ref[Solution],
):  # fmt: skip
    """Finds velocities that obey the contact law.

    Args:
        blocks: The blocks.
        g: The Jacobian.
        touch: Ends that touch.
        glide: Directions of sliding that are given; 0 where friction finds its own.
        free: Velocities without contact.
        dust: What counts as round-off.
        shift: What the law adds to relative velocities [m/s]: of impacts that bounce.
        found: What is found; with the state that is tried first before.
    """
    problem = Problem()
    couple(blocks, g, problem.couplings)
    relative_velocities(g, free, problem.free)
    if BOUNCES:
        problem.free = problem.free + shift
    problem.touch = touch
    problem.glide = glide
    f, line, r = Factors(), Line(), Triples()
    eliminate(problem.couplings, found.contacts, 0, f)
    find_impulses(problem.couplings, f, found.contacts, problem.free, line.impulse)
    respond(problem.couplings, problem.free, line.impulse, line.velocity)
    found.spare = spare_of(problem, found.contacts, line.impulse)
    worst = IMPOSSIBLE
    if is_positive(f):
        worst = worst_violation(problem, found.contacts, line, dust)
    tries = int(0)
    while worst > real(1.0) and tries < ATTEMPTS:
        if tries == 0:
            path_from_guess(problem, found.contacts, line, r)
        else:
            path_from_open(problem, tries, r)
            found.contacts = Contacts()
            eliminate(problem.couplings, found.contacts, 0, f)
        if tries > 1:
            problem.glide = Counts()
        if follow_path(problem, found.contacts, f, r, line):
            worst = worst_violation(problem, found.contacts, line, dust)
        tries += 1
    found.velocity = free
    apply_impulses(blocks, g, found.velocity, line.impulse)
    found.impulse = line.impulse
    found.solved = not (worst > real(1.0))
    found.guessed = tries == 0
