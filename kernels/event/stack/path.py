"""A path from one state of a stack's contacts to a state that obeys the contact law.

The law of event/stack/contact.py with Coulomb friction is a linear complementarity problem in the
relative velocities without contact, q. They are moved, q + t r, so that a first guess obeys the law
at t = 1; then t goes down to 0. On the way impulses and velocities change linearly with t until the
margin of one condition is used up: an end opens or is pressed, a contact starts to slide or stops.
That contact changes its state, and the path goes on, with t up or down, whichever gives the new
condition a margin. This is the method of Lemke (1965, Management Science 11, 681), each pivot of
which here is one solution of the chain. From open contacts with r > 0 at the ends that touch it
reaches t = 0 whatever the friction, since the matrix of the chain is positive definite (Stewart and
Trinkle 1996, Int. J. Numer. Methods Eng. 39, 2673). With given directions of sliding it may not.
"""

import warp as wp

from warprock.kernels.event.stack.chain import (
    Contacts,
    Couplings,
    Factors,
    eliminate,
    impulses_above,
    impulses_below,
    is_positive,
    respond,
    velocity_after,
)
from warprock.kernels.shape.stack import MINUS, PLUS, Counts, Three, Triples, three_of

SLIDES_AHEAD = 3
SLIDES_BACK = 4
STOPS = 5
ENDS_OF_LAW = STOPS + 1
"""Codes of the conditions of the contact law besides those of both ends (PLUS, MINUS)."""
PIVOTS = 16 + 16 * BLOCKS
"""Changes of state on a path: some four times the most that were seen."""
ARRIVED = by_precision(1.0e-14, 1.0e-6)
"""Value of t that counts as 0."""
FARTHEST = real(1.0e30)


@wp.struct
class Problem:
    """What the contact law is asked for.

    Attributes:
        couplings: What impulses do to relative velocities.
        free: Relative velocities without contact, q [m/s].
        touch: Ends that touch.
        glide: Directions of sliding that are given; 0 where friction finds its own.
    """

    couplings: Couplings
    free: Triples
    touch: Counts
    glide: Counts


@wp.struct
class Contact:
    """One interface in an assumed state: see `Problem` and `Contacts`."""

    touch: int
    glide: int
    hold: int
    slip: int
    friction: real


@wp.struct
class Line:
    """Impulses [N s] and relative velocities [m/s], impulse + t impulse_rate and so on."""

    impulse: Triples
    impulse_rate: Triples
    velocity: Triples
    velocity_rate: Triples


@wp.func
def contact_of(problem: wp.ref[Problem], contacts: wp.ref[Contacts], k: int) -> Contact:
    """Interface k in an assumed state."""
    return Contact(
        problem.touch[k],
        problem.glide[k],
        contacts.hold[k],
        contacts.slip[k],
        problem.couplings.friction[k],
    )


@wp.func
def margin(code: int, p: Three, u: Three, contact: Contact) -> real:
    """Margin of a condition of the contact law, linear in impulses p and velocities u.

    An impulse [N s] if the condition is one of `bears`, else a velocity [m/s].
    """
    found = real(contact.slip) * u[0]
    if code == PLUS:
        found = wp.where((contact.hold & PLUS) != 0, p[1], u[1])
    elif code == MINUS:
        found = wp.where((contact.hold & MINUS) != 0, p[2], u[2])
    elif code == SLIDES_AHEAD:
        found = contact.friction * (p[1] + p[2]) + p[0]
    elif code == SLIDES_BACK:
        found = contact.friction * (p[1] + p[2]) - p[0]
    return found


@wp.func
def bears(code: int, contact: Contact) -> bool:
    """Whether a condition limits an impulse: of a held end, or of an interface that sticks."""
    found = contact.hold != 0 and contact.slip == 0 and code < STOPS
    if code <= MINUS:
        found = (contact.hold & code) != 0
    return found


@wp.func
def applies(code: int, contact: Contact) -> bool:
    """Whether a condition is one of the state that a contact is in."""
    found = contact.hold != 0 and contact.slip != 0 and contact.glide == 0
    if code <= MINUS:
        found = (contact.touch & code) != 0
    elif code < STOPS:
        found = contact.hold != 0 and contact.slip == 0
    return found


@wp.func
def switch(code: int, contact: Contact, along: real):
    """The state after the margin of a condition is used up.

    Args:
        code: The condition.
        contact: The state before.
        along: Sliding velocity then [m/s].

    Returns:
        Held ends, direction of sliding, and the condition that takes the place of the other.
    """
    held = contact.hold
    slips = contact.slip
    other = code
    if code <= MINUS:
        if contact.hold == 0:
            slips = wp.where(along > real(0.0), 1, -1)
            slips = wp.where(contact.glide != 0, contact.glide, slips)
        held = contact.hold ^ code
    elif code < STOPS:
        slips = wp.where(code == SLIDES_AHEAD, 1, -1)
        other = STOPS
    else:
        slips = 0
        other = wp.where(contact.slip > 0, SLIDES_AHEAD, SLIDES_BACK)
    return held, slips, other


@wp.func
def make_obey(p: Three, u: Three, contact: Contact, more: real):
    """Impulses and velocities near given ones that obey the law in a state.

    What breaks a condition is turned over and multiplied by `more`, at least 1.
    """
    f = p
    v = u
    slip = real(contact.slip)
    for end in range(2):
        code = wp.where(end == 0, PLUS, MINUS)
        if (contact.hold & code) != 0:
            f[1 + end] = larger(f[1 + end], -more * f[1 + end])
        elif (contact.touch & code) != 0:
            v[1 + end] = larger(v[1 + end], -more * v[1 + end])
    most = contact.friction * (f[1] + f[2])
    if contact.hold != 0:
        if contact.slip != 0:
            f[0] = -slip * most
            if contact.glide == 0:
                v[0] = slip * larger(slip * v[0], -more * slip * v[0])
        elif size(f[0]) > most:
            f[0] = wp.where(f[0] > real(0.0), HALF * most, -HALF * most)
    return f, v


@wp.func(inline=False)
def path_from_guess(
    problem: wp.ref[Problem], guess: wp.ref[Contacts], line: wp.ref[Line], r: wp.ref[Triples]
):  # fmt: skip
    """Sets the direction r along which a guess obeys the law at t = 1 [m/s].

    `line` has its impulses and the relative velocities with them.
    """
    f, u, v = Triples(), Triples(), Triples()
    for k in range(BLOCKS):
        # Not all alike, so that no two margins are used up at once.
        more = real(1.0) + real(0.1) * real(wp.static(k))
        contact = contact_of(problem, guess, k)
        fk, uk = make_obey(three_of(line.impulse, k), three_of(line.velocity, k), contact, more)
        for i in range(3):
            f[3 * k + i] = fk[i]
            u[3 * k + i] = uk[i]
    respond(problem.couplings, problem.free, f, v)
    for i in range(3 * BLOCKS):
        r[i] = u[i] - v[i]


@wp.func
def path_from_open(problem: wp.ref[Problem], attempt: int, r: wp.ref[Triples]):
    """Sets a direction r along which open contacts obey the law at large t [m/s]."""
    q = problem.free
    fastest = real(0.0)
    for i in range(3 * BLOCKS):
        r[i] = real(0.0)
        fastest = larger(fastest, size(q[i]))
    dice = int(attempt)
    for k in range(BLOCKS):
        # The motion decides which end comes first, so that a mirrored stack takes a mirrored path.
        ahead = q[3 * k] + (q[3 * k + 1] - q[3 * k + 2]) > real(0.0)
        for end in range(2):
            # Not all alike, as above.
            dice = (dice * 75 + 74) % 65537
            at = wp.where(ahead, end, 1 - end)
            if (problem.touch[k] & wp.where(at == 0, PLUS, MINUS)) != 0:
                r[3 * k + 1 + at] = fastest * (real(0.5) + real(dice) / real(65537.0))


@wp.func(inline=False)
def find_line(
    problem: wp.ref[Problem], f: wp.ref[Factors], r: wp.ref[Triples], line: wp.ref[Line]
):  # fmt: skip
    """Sets the line of a state with the factors f, along r.

    Value and rate follow one another interface by interface, so that the processor works on both.
    """
    for k in range(BLOCKS):
        impulses_below(problem.couplings, f, problem.free, line.impulse, wp.static(k))
        impulses_below(problem.couplings, f, r, line.impulse_rate, k)
    for step in range(1, BLOCKS):
        k = wp.static(BLOCKS - 1 - step)
        impulses_above(f, line.impulse, k)
        impulses_above(f, line.impulse_rate, k)
    for k in range(BLOCKS):
        u = velocity_after(problem.couplings, problem.free, line.impulse, wp.static(k))
        w = velocity_after(problem.couplings, r, line.impulse_rate, k)
        for i in range(3):
            line.velocity[3 * k + i] = u[i]
            line.velocity_rate[3 * k + i] = w[i]


@wp.func(inline=False)
def next_switch(
    problem: wp.ref[Problem], contacts: wp.ref[Contacts], line: wp.ref[Line], sense: real, at: int,
    code: int,
):  # fmt: skip
    """The first condition of all contacts whose margin is used up as t goes on.

    Args:
        problem: What the law is asked for.
        contacts: The state.
        line: Impulses and velocities in it.
        sense: 1 if t goes up, -1 if it goes down.
        at, code: Interface and condition of the last change of state, whose margin is zero.

    Returns:
        sense * t, FARTHEST if there is none; the interface; the condition; sliding velocity there.
    """
    first = FARTHEST
    next_at = int(0)
    next_code = int(0)
    along = real(0.0)
    for k in range(BLOCKS):
        contact = contact_of(problem, contacts, wp.static(k))
        if contact.touch != 0:
            p = three_of(line.impulse, k)
            s = three_of(line.impulse_rate, k)
            u = three_of(line.velocity, k)
            w = three_of(line.velocity_rate, k)
            for which in range(PLUS, ENDS_OF_LAW):
                rate = margin(which, s, w, contact)
                if (
                    rate * sense < real(0.0)
                    and applies(which, contact)
                    and not (k == at and which == code)
                ):
                    t = -margin(which, p, u, contact) / rate
                    if sense * t < first:
                        first = sense * t
                        next_at = k
                        next_code = which
                        along = u[0] + t * w[0]
    return first, next_at, next_code, along


@wp.func(inline=False)
def follow_path(
    problem: wp.ref[Problem], contacts: wp.ref[Contacts], f: wp.ref[Factors], r: wp.ref[Triples],
    line: wp.ref[Line],
) -> bool:  # fmt: skip
    """Follows a path; whether it has reached t = 0.

    Args:
        problem: What the law is asked for.
        contacts: State in which the path starts; that at its end after.
        f: Factors of that state, likewise.
        r: How the relative velocities without contact are moved [m/s].
        line: The line of the last state after.
    """
    sense = real(-1.0)
    at = int(0)
    code = int(0)
    tries = int(PIVOTS)
    arrived = bool(False)
    while tries > 0:
        tries -= 1
        if code != 0:
            eliminate(problem.couplings, contacts, at, f)
        find_line(problem, f, r, line)
        if code != 0:
            contact = contact_of(problem, contacts, at)
            rate = margin(
                code, three_of(line.impulse_rate, at), three_of(line.velocity_rate, at), contact
            )
            sense = wp.where(rate > real(0.0), real(1.0), real(-1.0))
        first, next_at, next_code, along = next_switch(problem, contacts, line, sense, at, code)
        if sense < real(0.0) and first >= -ARRIVED:
            arrived = is_positive(f)
            tries = 0
        elif next_code == 0:
            tries = 0
        else:
            at = next_at
            hold, slip, other = switch(next_code, contact_of(problem, contacts, at), along)
            contacts.hold[at] = hold
            contacts.slip[at] = slip
            code = other
    return arrived
