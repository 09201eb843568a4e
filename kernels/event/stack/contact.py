"""Coulomb's law at all contacts of a stack in the plane: exact, or reported as unsolved.

The contact law at an interface, with impulses and velocities as in event/stack/chain.py: n >= 0; an
end that touches does not sink; an end without n opens; a contact sticks with |f| <= mu (n + n), or
slides with f = -slip mu (n + n). A *state* says which ends are held (`hold`, a sum of ends) and in
which direction an interface slides (`slip`: -1, 1, or 0 if it sticks). With the states of all
interfaces given the system is linear and solved at once. If the first guess breaks the law, all
interfaces that break it change their states at once, up to `CORRECTIONS` times: a held end that
pulls opens, an open one that sinks is held, one that needs too much friction slides, and one that
would slide against its friction sticks. If no such state obeys the law, a path leads from the last
one to a state that does (event/stack/path.py); if that path fails, another one starts at open
contacts. If directions of sliding are given and no state obeys the law with them,
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
    velocity_after,
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
    switch,
)
from warprock.kernels.shape.stack import (
    MINUS,
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
CORRECTIONS = 4
"""Corrections of a guess, of all interfaces at once, before a path: of tall stacks of six they
leave one path in a hundred, of flat ones one in eight."""
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
        ramps: Whether it has to lie on a path from the first guess, as at a velocity step of the
            base: of the states that obey the law there, that is the limit of a steep ramp.
        velocity: Velocities of the blocks.
        impulse: Impulses at the interfaces [N s].
        contacts: State of the interfaces.
        solved: Whether it obeys the contact law.
        guessed: Whether it is the first guess.
        spare: Margin of the weakest contact in the state of the first guess [N s], see `spare_of`.
    """

    ramps: bool
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
def try_state(
    problem: wp.ref[Problem], contacts: wp.ref[Contacts], first: int, dust: RoundOff,
    f: wp.ref[Factors], line: wp.ref[Line],
) -> real:  # fmt: skip
    """Sets the impulses of an assumed state, and the velocities with them.

    Args:
        problem: What the law is asked for.
        contacts: The state.
        first: The lowest interface whose state has changed.
        dust: What counts as round-off.
        f: Factors of the state before; those of the new one after.
        line: The impulses and velocities.

    Returns:
        By how much it breaks the law, see `violation`; IMPOSSIBLE if friction jams a contact.
    """
    eliminate(problem.couplings, contacts, first, f)
    find_impulses(problem.couplings, f, problem.free, line.impulse)
    for k in range(BLOCKS):
        u = Three()
        # Where all ends that touch are held and stick, nothing moves.
        if contacts.hold[k] != problem.touch[k] or contacts.slip[k] != 0:
            u = velocity_after(problem.couplings, problem.free, line.impulse, wp.static(k))
        for i in range(3):
            line.velocity[3 * k + i] = u[i]
    worst = IMPOSSIBLE
    if is_positive(f):
        worst = worst_violation(problem, contacts, line, dust)
    return worst


@wp.func(inline=False)
def correct(
    problem: wp.ref[Problem], line: wp.ref[Line], dust: RoundOff, contacts: wp.ref[Contacts]
) -> int:  # fmt: skip
    """Changes the state of every interface that breaks the law, its ends before its sliding.

    The lowest interface that has changed.
    """
    first = int(BLOCKS)
    for step in range(BLOCKS):
        k = wp.static(BLOCKS - 1 - step)
        contact = contact_of(problem, contacts, k)
        p, u = three_of(line.impulse, k), three_of(line.velocity, k)
        hold, slip = int(contact.hold), int(contact.slip)
        for code in range(PLUS, ENDS_OF_LAW):
            grain = wp.where(bears(code, contact), dust.impulse, dust.velocity)
            breaks = applies(code, contact) and -margin(code, p, u, contact) > grain
            if breaks and (code <= MINUS or hold == contact.hold):
                was = Contact(contact.touch, contact.glide, hold, slip, contact.friction)
                hold, slip, _other = switch(code, was, u[0])
                first = k
        contacts.hold[k] = hold
        contacts.slip[k] = slip
    return first


@wp.func(inline=False)
def keep_together(
    problem: wp.ref[Problem], line: wp.ref[Line], dust: RoundOff, contacts: wp.ref[Contacts]
):
    """Holds interfaces that corrections have opened though nothing moves them apart.

    Blocks that fly as one touch without impulses: open or held, they obey the law.
    """
    for k in range(BLOCKS):
        u = three_of(line.velocity, k)
        moves = larger(wp.abs(u[0]), larger(wp.abs(u[1]), wp.abs(u[2]))) > dust.velocity
        if contacts.hold[k] == 0 and not moves:
            contacts.hold[k] = problem.touch[k]


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
        found: What is found; with the state that is tried first, and `ramps`, before.
    """
    problem = Problem()
    couple(blocks, g, problem.couplings)
    relative_velocities(g, free, problem.free)
    if BOUNCES:
        problem.free = problem.free + shift
    problem.touch = touch
    problem.glide = glide
    f, line, r = Factors(), Line(), Triples()
    worst = try_state(problem, found.contacts, 0, dust, f, line)
    found.spare = spare_of(problem, found.contacts, line.impulse)
    found.guessed = not (worst > real(1.0))
    left = wp.where(found.ramps, 0, CORRECTIONS)
    while worst > real(1.0) and left > 0:
        left -= 1
        first = correct(problem, line, dust, found.contacts)
        worst = try_state(problem, found.contacts, first, dust, f, line)
    if not (found.guessed or worst > real(1.0)):
        keep_together(problem, line, dust, found.contacts)
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
