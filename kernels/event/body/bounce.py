"""Impacts of a body that bounce: Newton's law or Poisson's for the corners that strike the base.

By Newton's law a corner that comes down at a speed v leaves the base with at least e v, e the
restitution:

    u >= e v,   n >= 0,   n (u - e v) = 0,   |f| <= friction n against the sliding after the impact,

of both ends of an edge at once where it lands flat (Moreau 1988). A corner that did not move before
has v = 0: the impact of the other end may lift it. Let s be the motion with the normal velocities
-e v at the corners and none along the base. Then the velocity after the impact plus s obeys the law
without rebound for the velocity before it plus s, so that `law_velocity` finds both.

By Poisson's law an impact has two phases (Glocker and Pfeiffer 1995). The compression is the impact
without rebound; let m be its normal impulse at a corner. In the expansion that corner gets at least
e m, and friction is found anew:

    u >= 0,   n >= e m,   (n - e m) u = 0,   |f| <= friction n against the sliding after it.

All corners that the compression presses expand, those too that did not move before. Both laws are
one where nothing rubs, and where every corner slides on in one direction: the expansion is then e
times the compression. They differ where friction stops the sliding. A corner that comes down at v,
slides at s, and sticks in both phases leaves at

    e v  (Newton),    e (v + K_nt s / K_tt)  (Poisson),

K the matrix of event/block/contact.py.

No such impact makes energy. Let C be the compression and E the expansion, with impulses P and
velocities u; e <= 1 is the same at all corners. Then the gain of both phases is at most

    (1 + e) f_C u_tC - friction (n - e m) |u_tE| - e |P_C - P_E|^2 / 2
        - (1 - e) (|P_C|^2 + |P_E|^2) / 2,

summed over the corners, |P|^2 / 2 being the energy that the impulses P give to a body at rest. No
term is positive.

- A corner slower than `slow` does not bounce: its flight, 2 e v / g, would last less than a part of
  the longest step. So bounces that follow one another ever faster come to an end. The height of
  those that are left out is of second order in the step.
  By Poisson's law none expands if all are slower.
- An impact by Newton's law that would make energy is a mixture of those with and without rebound,
  see contact/bounce.py. One by Poisson's law makes none.
- Where friction jams a corner such that nothing obeys the law of the expansion, there is none.

References:
    Moreau (1988), Unilateral contact and dry friction in finite freedom dynamics.
    Glocker and Pfeiffer (1995), Multiple impacts with friction in rigid multibody systems.
"""

import warp as wp

from warprock.kernels.contact.bounce import kept_part
from warprock.kernels.event.block.contact import Contact, Lever, Velocity
from warprock.kernels.event.body.contact import Blow, Body, law_velocity
from warprock.kernels.lane.modes import FLAT, FLYING, PIVOTING

SHORT = by_precision(1.0e-7, 1.0e-4)
"""A corner that rises at less than this part of e slow stays on the base. By Poisson's law a corner
that did not come down may leave at any speed, however small."""


@wp.func
def energy_of(body: Body, v: Velocity) -> real:
    """Kinetic energy for mass 1 [J/kg]."""
    return HALF * (v.x * v.x + v.z * v.z + body.inertia * v.omega * v.omega)


@wp.func
def velocity_between(law: Velocity, more: Velocity, part: real) -> Velocity:
    """A velocity and a part of the way from there."""
    return Velocity(
        law.x + part * more.x, law.z + part * more.z, law.omega + part * more.omega
    )  # fmt: skip


@wp.struct
class Expansion:
    """The second phase of an impact.

    Attributes:
        after: Velocity after it.
        first, second: Whether the first corner is pressed on and stays on the base, the second one.
        sticks: Whether the point of contact sticks.
        fits: Whether it obeys the law.
    """

    after: Velocity
    first: bool
    second: bool
    sticks: bool
    fits: bool


@wp.func
def velocity_after(body: Body, at: Lever, free: Velocity, n: real, f: real) -> Velocity:
    """Velocity after impulses [m/s] at a corner."""
    turn = body.inverse_inertia * (f * at.z - n * at.x)
    return Velocity(free.x + f, free.z + n, free.omega + turn)


@wp.func
def press_corner(body: Body, at: Lever, given: real, free: Velocity):
    """Keeps one corner on the base in an expansion.

    Args:
        body: The body.
        at: The corner.
        given: Normal impulse of the expansion at all corners [m/s], which `free` contains.
        free: Velocity without what this function finds.

    Returns:
        Velocity; whether the corner sticks; whether it is pressed.
    """
    zero, one, mu, w, x, z = real(0.0), real(1.0), body.friction, body.inverse_inertia, at.x, at.z
    u, s = free.z - free.omega * x, free.x + free.omega * z
    kn, kt, k = one + w * x * x, one + w * z * z, -w * x * z
    over = one / (one + w * (x * x + z * z))
    n, f = over * (k * s - kt * u), over * (k * u - kn * s)
    sticks = n >= zero and size(f) <= mu * (given + n)
    # As in `corner_impulse`: a corner that jams slides the other way.
    sign = sign_of(f)
    sign = wp.where(kn + sign * mu * k <= zero, -sign, sign)
    slipping = -(u + sign * mu * k * given) / (kn + sign * mu * k)
    n = wp.where(sticks, n, slipping)
    f = wp.where(sticks, f, sign * mu * (given + slipping))
    return velocity_after(body, at, free, n, f), sticks, n >= zero


@wp.func
def expand(body: Body, beside: bool, at: Lever, other: real, rest: Velocity, n: real, more: real):
    """The expansion after a compression that left the velocity `rest`.

    `n` is its normal impulse at the first corner [m/s], `more` that at the second one; the other
    arguments are as of `struck_velocity`.
    """
    zero, one, w, z = real(0.0), real(1.0), body.inverse_inertia, at.z
    given = n + more
    free = Velocity(rest.x, rest.z + given, rest.omega - w * (n * at.x + more * other))
    # No corner needs more than it is given.
    stop = -(free.x + free.omega * z) / (one + w * z * z)
    bound = body.friction * given
    up = velocity_after(body, Lever(zero, z), free, zero, larger(smaller(stop, bound), -bound))
    u1, u2 = up.z - up.omega * at.x, up.z - up.omega * other
    leaves = u1 >= zero and (not beside or u2 >= zero)
    # One corner would sink, and is pressed on.
    on1, sticks1, presses1 = press_corner(body, at, given, free)
    on2, sticks2, presses2 = press_corner(body, Lever(other, z), given, free)
    fits1 = presses1 and (not beside or on1.z - on1.omega * other >= zero)
    fits2 = beside and presses2 and on2.z - on2.omega * at.x >= zero
    second = not leaves and fits2 and (not fits1 or u2 < u1)
    first = not leaves and fits1 and not second
    after = Velocity(
        wp.where(first, on1.x, wp.where(second, on2.x, up.x)),
        wp.where(first, on1.z, wp.where(second, on2.z, up.z)),
        wp.where(first, on1.omega, wp.where(second, on2.omega, up.omega)),
    )
    sticks = wp.where(first, sticks1, wp.where(second, sticks2, size(stop) <= bound))
    return Expansion(after, first, second, sticks, leaves or first or second)


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
        body, beside, at, other, velocity_between(before, shift, one)
    )
    bounced = velocity_between(found, shift, -one)
    energy, more = energy_of(body, before), velocity_between(bounced, law, -one)
    slope = law.x * more.x + law.z * more.z + body.inertia * law.omega * more.omega
    part = kept_part(energy_of(body, more), slope, energy - energy_of(body, law))
    whole = part >= one
    after = velocity_between(law, more, part)
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
    still = free_sticks and (whole or sticks)
    # Poisson's law: what the compression pressed on expands.
    press, drag = law.z - before.z, law.x - before.x
    turned = drag * z - body.inertia * (law.omega - before.omega) - press * x
    shared = larger(smaller(turned / (other - x), press), zero)
    given, on_second = body.expansion * press, wp.where(both, shared, wp.where(second, press, zero))
    of_second = body.expansion * on_second
    grown = expand(body, beside, at, other, law, given - of_second, of_second)
    fast = u1 < -body.slow or (beside and u2 < -body.slow)
    grows = body.expansion > zero and fast and grown.fits
    after = Velocity(
        wp.where(grows, grown.after.x, after.x), wp.where(grows, grown.after.z, after.z),
        wp.where(grows, grown.after.omega, after.omega),
    )  # fmt: skip
    rise1, rise2 = after.z - after.omega * x, after.z - after.omega * other
    hop = SHORT * body.expansion * body.slow
    first_stays = wp.where(grows, grown.first or rise1 <= hop, first_stays)
    second_stays = wp.where(grows, grown.second or (beside and rise2 <= hop), second_stays)
    still = wp.where(grows, grown.sticks, still)
    stays = first_stays or second_stays
    lies = first_stays and second_stays
    lower = after.omega * (other - x) > zero
    is_second = wp.where(stays, not first_stays, beside and lower)
    along = after.x + after.omega * z
    slip = wp.where(still or not stays, zero, sign_of(along))
    contact = Contact(wp.where(lies, FLAT, wp.where(stays, PIVOTING, FLYING)), slip)
    return after, contact, Blow(is_second, energy - energy_of(body, after), zero)
