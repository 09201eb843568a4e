"""From one state of a stack's contacts to the one that obeys the contact law, along a path.

The law of event/stack_contact.py with Coulomb friction is a linear complementarity problem in the
relative velocities without contact. They are moved, q + t r, so that at t = 1 a first guess obeys
the law; then t goes down to 0. On the way impulses and velocities change linearly with t until one
condition has nothing left: an end opens or is pressed, a contact starts to slide or stops. That
contact changes its state, and the path goes on, t up or down, whichever leaves the new condition
room. This is the method of Lemke (1965, Management Science 11, 681), each pivot of which here is
one solution of the chain. From open contacts with r > 0 at the ends that touch it reaches t = 0
whatever the friction, since the matrix of the chain is positive definite (Stewart and Trinkle 1996,
Int. J. Numer. Methods Eng. 39, 2673). Where the direction of sliding is given it may not.
"""

import warp as wp

from warprock.kernels.event.stack_chain import (
    Couplings,
    Factors,
    eliminated,
    impulses_of,
    responses,
    sound,
)
from warprock.kernels.shape.stack import MINUS, PLUS, Counts, Three, Triples, three_of

SLIDES_AHEAD = 3
SLIDES_BACK = 4
STOPS = 5
ENDS_OF_LAW = STOPS + 1
"""Conditions of the contact law besides those of both ends (PLUS, MINUS)."""
PIVOTS = 16 + 16 * BLOCKS
"""Changes of state on a path: some four times the most that were seen."""
ARRIVED = by_precision(1.0e-14, 1.0e-6)
FARTHEST = real(1.0e30)


@wp.func
def left(code: int, p: Three, u: Three, hold: int, slip: int, mu: real) -> real:
    """What a condition of the contact law has left, linear in impulses and velocities."""
    found = real(slip) * u[0]
    if code == PLUS:
        found = wp.where((hold & PLUS) != 0, p[1], u[1])
    elif code == MINUS:
        found = wp.where((hold & MINUS) != 0, p[2], u[2])
    elif code == SLIDES_AHEAD:
        found = mu * (p[1] + p[2]) + p[0]
    elif code == SLIDES_BACK:
        found = mu * (p[1] + p[2]) - p[0]
    return found


@wp.func
def counts(code: int, touch: int, glide: int, hold: int, slip: int) -> bool:
    """Whether a condition is one of the state that a contact is in."""
    found = hold != 0 and slip != 0 and glide == 0
    if code <= MINUS:
        found = (touch & code) != 0
    elif code < STOPS:
        found = hold != 0 and slip == 0
    return found


@wp.func
def changed(code: int, glide: int, hold: int, slip: int, along: real):
    """The state after a condition had nothing left, and the condition that it has instead."""
    held = hold
    slips = slip
    other = code
    if code <= MINUS:
        if hold == 0:
            slips = wp.where(along > real(0.0), 1, -1)
            slips = wp.where(glide != 0, glide, slips)
        held = hold ^ code
    elif code < STOPS:
        slips = wp.where(code == SLIDES_AHEAD, 1, -1)
        other = STOPS
    else:
        slips = 0
        other = wp.where(slip > 0, SLIDES_AHEAD, SLIDES_BACK)
    return held, slips, other


@wp.func
def obeying(p: Three, u: Three, touch: int, glide: int, hold: int, slip: int, mu: real, more: real):
    """Impulses and velocities near given ones that obey the law in a state; more: at least 1."""
    f = p
    v = u
    for end in range(2):
        code = wp.where(end == 0, PLUS, MINUS)
        if (hold & code) != 0:
            f[1 + end] = larger(f[1 + end], -more * f[1 + end])
        elif (touch & code) != 0:
            v[1 + end] = larger(v[1 + end], -more * v[1 + end])
    most = mu * (f[1] + f[2])
    if hold != 0:
        if slip != 0:
            f[0] = -real(slip) * most
            if glide == 0:
                v[0] = real(slip) * larger(real(slip) * v[0], -more * real(slip) * v[0])
        elif size(f[0]) > most:
            f[0] = wp.where(f[0] > real(0.0), HALF * most, -HALF * most)
    return f, v


@wp.func(inline=False)
def near_guess(
    c: Couplings, touch: Counts, glide: Counts, hold: Counts, slip: Counts, q: Triples, p: Triples
) -> Triples:
    """The way r along which a guess obeys the law at t = 1.

    Args:
        c: The chain.
        touch: Ends that touch.
        glide: Directions of sliding that are given.
        hold: Ends held in the guess.
        slip: Directions of sliding in the guess.
        q: Relative velocities without contact.
        p: Impulses under the guess.
    """
    f = Triples()
    u = responses(c, q, p)
    for k in range(BLOCKS):
        # Not all alike, so that no two conditions have nothing left at once.
        more = real(1.0) + real(0.1) * real(wp.static(k))
        fk, uk = obeying(
            three_of(p, k), three_of(u, k), touch[k], glide[k], hold[k], slip[k], c.friction[k],
            more,
        )  # fmt: skip
        for i in range(3):
            f[3 * k + i] = fk[i]
            u[3 * k + i] = uk[i]
    return u - responses(c, q, f)


@wp.func
def from_open(touch: Counts, q: Triples, attempt: int) -> Triples:
    """A way r along which open contacts obey the law at large t."""
    r = Triples()
    fastest = real(0.0)
    for i in range(3 * BLOCKS):
        fastest = larger(fastest, size(q[i]))
    dice = int(attempt)
    for k in range(BLOCKS):
        # Which end comes first is told by the motion, so that a mirror image takes the image of it.
        ahead = q[3 * k] + (q[3 * k + 1] - q[3 * k + 2]) > real(0.0)
        for end in range(2):
            # Not all alike, as above.
            dice = (dice * 75 + 74) % 65537
            at = wp.where(ahead, end, 1 - end)
            if (touch[k] & wp.where(at == 0, PLUS, MINUS)) != 0:
                r[3 * k + 1 + at] = fastest * (real(0.5) + real(dice) / real(65537.0))
    return r


@wp.func(inline=False)
def next_change(
    c: Couplings, touch: Counts, glide: Counts, hold: Counts, slip: Counts, p: Triples, s: Triples,
    u: Triples, w: Triples, sense: real, at: int, code: int,
):  # fmt: skip
    """The first condition of all contacts that has nothing left, as t goes on.

    Args:
        c: The chain.
        touch: Ends that touch.
        glide: Directions of sliding that are given.
        hold: Ends held.
        slip: Directions of sliding.
        p, s: Impulses p + t s.
        u, w: Relative velocities u + t w.
        sense: 1 where t goes up, -1 where it goes down.
        at, code: The condition that the last change of state left with nothing.

    Returns:
        sense * t, FARTHEST if there is none; the interface; the condition; sliding velocity there.
    """
    first = FARTHEST
    next_at = int(0)
    next_code = int(0)
    along = real(0.0)
    for k in range(BLOCKS):
        if touch[k] != 0:
            pk = three_of(p, wp.static(k))
            sk = three_of(s, k)
            uk = three_of(u, k)
            wk = three_of(w, k)
            for which in range(PLUS, ENDS_OF_LAW):
                rate = left(which, sk, wk, hold[k], slip[k], c.friction[k])
                if (
                    rate * sense < real(0.0)
                    and counts(which, touch[k], glide[k], hold[k], slip[k])
                    and not (k == at and which == code)
                ):
                    t = -left(which, pk, uk, hold[k], slip[k], c.friction[k]) / rate
                    if sense * t < first:
                        first = sense * t
                        next_at = k
                        next_code = which
                        along = uk[0] + t * wk[0]
    return first, next_at, next_code, along


@wp.func(inline=False)
def followed(
    c: Couplings, touch: Counts, glide: Counts, hold: Counts, slip: Counts, q: Triples, r: Triples
):
    """The state at the end of the path.

    Args:
        c: The chain.
        touch: Ends that touch.
        glide: Directions of sliding that are given, 0 where friction finds its own.
        hold: Ends held where the path starts.
        slip: Directions of sliding there.
        q: Relative velocities without contact.
        r: How they are moved.

    Returns:
        Impulses, held ends, directions of sliding; whether t = 0 was reached.
    """
    held = hold
    slips = slip
    f = Factors()
    p = Triples()
    sense = real(-1.0)
    at = int(0)
    code = int(0)
    tries = int(PIVOTS)
    arrived = bool(False)
    while tries > 0:
        tries -= 1
        f = eliminated(c, held, slips, f, at)
        p = impulses_of(c, f, held, slips, q)
        s = impulses_of(c, f, held, slips, r)
        u = responses(c, q, p)
        w = responses(c, r, s)
        if code != 0:
            mu = c.friction[at]
            rate = left(code, three_of(s, at), three_of(w, at), held[at], slips[at], mu)
            sense = wp.where(rate > real(0.0), real(1.0), real(-1.0))
        first, next_at, next_code, along = next_change(
            c, touch, glide, held, slips, p, s, u, w, sense, at, code
        )
        if sense < real(0.0) and first >= -ARRIVED:
            arrived = sound(f)
            tries = 0
        elif next_code == 0:
            tries = 0
        else:
            at = next_at
            held_at, slips_at, code_at = changed(next_code, glide[at], held[at], slips[at], along)
            held[at] = held_at
            slips[at] = slips_at
            code = code_at
    return p, held, slips, arrived
