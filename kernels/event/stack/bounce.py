"""Impacts of a stack in the plane that bounce: Newton's law for every end that closes.

An end of an interface that closes at a speed v opens again with at least e v, e the restitution;
all ends of the stack that touch take part at once, as in event/body/bounce.py:

    u >= e v,   n >= 0,   n (u - e v) = 0,   |f| <= mu (n + n) against the sliding after the impact.

An end that touched without moving has v = 0: it stays, or opens. With the relative velocities
less e v the law is that without rebound, so that `solve` finds both.

- An end slower than `slow` does not bounce, see event/body/bounce.py.
- An impact that would make energy is a mixture of those with and without rebound, see
  contact/bounce.py.

References:
    Moreau (1988), Unilateral contact and dry friction in finite freedom dynamics.
"""

import warp as wp

from warprock.kernels.contact.bounce import kept_part
from warprock.kernels.event.stack.chain import relative_velocity
from warprock.kernels.event.stack.contact import RoundOff, Solution, solve
from warprock.kernels.event.stack.state import Rebound, kinetic_energy
from warprock.kernels.shape.stack import MINUS, PLUS, Blocks, Counts, Jacobian, Triples


@wp.func
def rebounds(
    g: wp.ref[Jacobian], rebound: Rebound, touch: Counts, free: wp.ref[Triples]
) -> Triples:  # fmt: skip
    """Minus the speeds at which ends have to open, in the rows of their velocities [m/s]."""
    shift = Triples()
    for k in range(BLOCKS):
        u = relative_velocity(g, free, k)
        for end in range(2):
            code = wp.where(end == 0, PLUS, MINUS)
            if (touch[k] & code) != 0 and u[1 + end] < -rebound.slow:
                shift[3 * k + 1 + end] = rebound.kept * u[1 + end]
    return shift


@wp.func(inline=False)
def bounce(
    blocks: wp.ref[Blocks], g: wp.ref[Jacobian], rebound: Rebound, touch: Counts,
    free: wp.ref[Triples], dust: RoundOff, found: wp.ref[Solution],
):  # fmt: skip
    """Finds the impact that bounces; arguments as of `solve`."""
    plastic = Solution()
    plastic.contacts = found.contacts
    plastic.ramps = found.ramps
    solve(blocks, g, touch, Counts(), free, dust, Triples(), plastic)
    shift = rebounds(g, rebound, touch, free)
    total = real(0.0)
    for k in range(3 * BLOCKS):
        total += shift[k]
    if total == real(0.0):
        found.velocity = plastic.velocity
        found.contacts = plastic.contacts
        found.solved = plastic.solved
        return
    solve(blocks, g, touch, Counts(), free, dust, shift, found)
    more = Triples()
    for k in range(3 * BLOCKS):
        more[k] = found.velocity[k] - plastic.velocity[k]
    square, least = kinetic_energy(blocks, more), kinetic_energy(blocks, plastic.velocity)
    slope = kinetic_energy(blocks, found.velocity) - least - square
    part = kept_part(square, slope, kinetic_energy(blocks, free) - least)
    found.solved = found.solved and plastic.solved
    for k in range(BLOCKS):
        hold = found.contacts.hold[k]
        if part < real(1.0):
            hold = hold & plastic.contacts.hold[k]
        for end in range(2):
            code = wp.where(end == 0, PLUS, MINUS)
            if (hold & code) != 0 and shift[3 * k + 1 + end] != real(0.0):
                hold = hold - code
        found.contacts.hold[k] = hold
    if part < real(1.0):
        for k in range(3 * BLOCKS):
            found.velocity[k] = plastic.velocity[k] + part * more[k]
        for k in range(BLOCKS):
            u = relative_velocity(g, found.velocity, k)
            sticks = found.contacts.slip[k] == 0 and plastic.contacts.slip[k] == 0
            found.contacts.slip[k] = wp.where(sticks, 0, int(sign_of(u[0])))
