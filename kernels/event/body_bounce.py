"""Impacts of a body that bounce: Newton's law for every corner that strikes the base.

A corner that comes down at a speed v leaves the base with at least e v, e the restitution:

    u >= e v,   n >= 0,   n (u - e v) = 0,   |f| <= friction n against the sliding after the impact,

of both ends of an edge at once where it lands flat (Moreau 1988). A corner that did not move before
has v = 0: the impact of the other end may lift it. Let s be the motion with the normal velocities
-e v at the corners and none along the base. Then the velocity after the impact plus s obeys the law
without rebound for the velocity before it plus s, so that `law_velocity` finds both.

- A corner slower than `slow` does not bounce: its flight, 2 e v / g, would last less than a part of
  the longest step. So bounces that follow one another ever faster come to an end. The height of
  those that are left out is of second order in the step.
- An impact that would make energy is a mixture of those with and without rebound, see bounce.py.

References:
    Moreau (1988), Unilateral contact and dry friction in finite freedom dynamics.
"""

import warp as wp

from warprock.kernels.contact.bounce import kept_part
from warprock.kernels.event.block_contact import Contact, Lever, Velocity
from warprock.kernels.event.body_contact import Blow, Body, law_velocity
from warprock.kernels.lane.modes import FLAT, FLYING, PIVOTING


@wp.func
def energy_of(body: Body, v: Velocity) -> real:
    """Kinetic energy for mass 1 [J/kg]."""
    return HALF * (v.x * v.x + v.z * v.z + body.inertia * v.omega * v.omega)


@wp.func
def between(law: Velocity, more: Velocity, part: real) -> Velocity:
    """A velocity and a part of the way from there."""
    return Velocity(
        law.x + part * more.x, law.z + part * more.z, law.omega + part * more.omega
    )  # fmt: skip


@wp.func
def bounce_velocity(body: Body, beside: bool, at: Lever, other: real, before: Velocity):
    """Velocity after an impact that bounces; arguments as of `struck_velocity`.

    Returns:
        Velocity; contact; more about the impact: `second` says whether the second corner is the one
        that stays on the base, or the lower one if none does.
    """
    zero, one, e = real(0.0), real(1.0), body.rebound
    x, z = at.x, at.z
    u1, u2 = before.z - before.omega * x, before.z - before.omega * other
    s1 = wp.where(u1 < -body.slow, e * u1, zero)
    s2 = wp.where(beside and u2 < -body.slow, e * u2, zero)
    turn = wp.where(beside, (s2 - s1) / (x - other), zero)
    shift = Velocity(-turn * z, s1 + turn * x, turn)
    law, mode, sticks, second = law_velocity(body, beside, at, other, before)
    found, free_mode, free_sticks, free_second = law_velocity(
        body, beside, at, other, between(before, shift, one)
    )
    bounced = between(found, shift, -one)
    energy, more = energy_of(body, before), between(bounced, law, -one)
    slope = law.x * more.x + law.z * more.z + body.inertia * law.omega * more.omega
    part = kept_part(energy_of(body, more), slope, energy - energy_of(body, law))
    whole = part >= one
    after = between(law, more, part)
    after = Velocity(
        wp.where(whole, bounced.x, after.x), wp.where(whole, bounced.z, after.z),
        wp.where(whole, bounced.omega, after.omega),
    )  # fmt: skip
    # What neither law lets go stays on the base.
    both, flat = mode == FLAT, free_mode == FLAT
    one_law = whole or both or (mode == PIVOTING and not second)
    two_law = whole or both or (mode == PIVOTING and second)
    first_stays = one_law and s1 == zero and (flat or (free_mode == PIVOTING and not free_second))
    second_stays = two_law and s2 == zero and (flat or (free_mode == PIVOTING and free_second))
    stays = first_stays or second_stays
    lies = first_stays and second_stays
    lower = after.omega * (other - x) > zero
    is_second = wp.where(stays, not first_stays, beside and lower)
    along = after.x + after.omega * z
    still = free_sticks and (whole or sticks)
    slip = wp.where(still or not stays, zero, sign_of(along))
    contact = Contact(wp.where(lies, FLAT, wp.where(stays, PIVOTING, FLYING)), slip)
    return after, contact, Blow(is_second, energy - energy_of(body, after), zero)
