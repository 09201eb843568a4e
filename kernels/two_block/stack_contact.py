"""The pattern of two stacked blocks after impulses and under forces: one rule for both.

After an impulse the velocities are those of the new pattern that are closest to the old ones in the
norm of kinetic energy, q+ = (J'^T M J')^-1 J'^T M J q-. The angular momentum of the whole about the
new ground pivot is conserved, and that of the upper block about the new interface pivot (Psycharis
1990; Spanos, Roussis and Politis 2001; Kounadis 2015). Energy never grows.

A new pattern is admissible if the corners that it lifts open and its touching contacts push; the
resultant of a contact that stays closed must lie inside its width. Open contacts keep their pivots.
If several patterns are admissible, the one that dissipates least is taken; if none is, the one that
dissipates least of those whose lifted corners open. Under forces the same conditions hold, with
accelerations in the place of velocities.
"""

import warp as wp

from warprock.kernels.two_block.stack_mechanics import (
    Pair,
    Places,
    Stack,
    accelerations,
    centre_motion,
    cross_terms,
    equations,
    ground_pulls,
    interface_pulls,
    inverse,
    kinetic_energy,
    least_margin,
    reactions,
    solve,
    spins,
)

NONE, OPENED, ADMISSIBLE = 0, 1, 2
"""Ranks of a candidate."""
PATTERNS = 9


@wp.struct
class Choice:
    """The chosen pattern: its rates or accelerations, its rank, and whether a pivot pulls."""

    ground: real
    interface: real
    motion: Pair
    energy: real
    rank: int
    pulls: bool


@wp.func
def corner(place: int) -> real:
    """The pivots in the order in which they are tried: 0, +1, -1."""
    return wp.where(place == 0, real(0.0), wp.where(place == 1, real(1.0), real(-1.0)))


@wp.func
def project(stack: Stack, s1: real, s2: real, rotation: Pair, momentum: Places, spin: Pair) -> Pair:
    """Rates in a pattern after the momenta of the centres [N s] and the spins [N m s]."""
    foot = s1 * stack.lane.ground
    edge = s2 * stack.lane.interface
    across = edge - foot
    h1 = stack.lower.half_height
    rise = h1 + h1
    sin1 = sine(rotation[0])
    cos1 = cosine(rotation[0])
    sin2 = sine(rotation[1])
    cos2 = cosine(rotation[1])
    r1 = momentum[0] * (h1 * cos1 + foot * sin1) + momentum[1] * (foot * cos1 - h1 * sin1)
    r1 = r1 + momentum[2] * (rise * cos1 - across * sin1)
    r1 = r1 - momentum[3] * (rise * sin1 + across * cos1) + spin[0]
    h2 = stack.upper.half_height
    r2 = momentum[2] * (h2 * cos2 + edge * sin2) + momentum[3] * (edge * cos2 - h2 * sin2)
    eq = equations(stack, s1, s2)
    m12 = cross_terms(eq, rotation)[0]
    return solve(inverse(s1, s2, eq.m11, m12, eq.m22), r1, r2 + spin[1])


@wp.func
def momenta(stack: Stack, s1: real, s2: real, rotation: Pair, rate: Pair, dv: real) -> Places:
    """Momenta of the centres relative to the base, after a step dv of the base velocity."""
    v = centre_motion(stack, s1, s2, rotation, rate, Pair(real(0.0), real(0.0)))
    m1 = stack.lower.mass
    m2 = stack.upper.mass
    return Places(m1 * (v[0] - dv), m1 * v[1], m2 * (v[2] - dv), m2 * v[3])


@wp.func
def opens(s1: real, s2: real, shut1: bool, shut2: bool, motion: Pair) -> bool:
    """Whether the touching corners that a pattern lifts open."""
    zero = real(0.0)
    stuck1 = shut1 and s1 != zero and not s1 * motion[0] > zero
    stuck2 = shut2 and s2 != zero and not s2 * (motion[1] - motion[0]) > zero
    return not stuck1 and not stuck2


@wp.func
def after_impulse(
    stack: Stack, s1: real, s2: real, shut1: bool, shut2: bool,
    rotation: Pair, rate: Pair, dv: real,
) -> Choice:  # fmt: skip
    """Pattern and rates after an impact, or after a step dv [m/s] of the base velocity.

    Args:
        stack: The stack.
        s1: Ground pivot before.
        s2: Interface pivot before.
        shut1: Whether the ground contact touches on its whole width.
        shut2: Whether the interface does.
        rotation: [rad].
        rate: Before [rad/s].
        dv: [m/s]; 0 for an impact.
    """
    before = momenta(stack, s1, s2, rotation, rate, dv)
    spin = spins(stack, rate)
    best = Choice()
    best.ground = s1
    best.interface = s2
    best.motion = rate
    place = int(0)
    while place < PATTERNS:
        i1 = place % 3
        i2 = place // 3
        place += 1
        if (shut1 or i1 == 0) and (shut2 or i2 == 0):
            ground = wp.where(shut1, corner(i1), s1)
            interface = wp.where(shut2, corner(i2), s2)
            w = project(stack, ground, interface, rotation, before, spin)
            force = momenta(stack, ground, interface, rotation, w, real(0.0)) - before
            turn = spins(stack, w - rate)
            pulls1 = ground_pulls(force)
            pulls2 = interface_pulls(stack, rotation, force)
            margin = least_margin(stack, ground, interface, rotation, force, turn)
            energy = kinetic_energy(stack, ground, interface, rotation, w)
            sound = margin >= real(0.0) and not (pulls1 and shut1) and not (pulls2 and shut2)
            rank = wp.where(sound, ADMISSIBLE, OPENED)
            rank = wp.where(opens(ground, interface, shut1, shut2, w), rank, NONE)
            if rank > best.rank or (rank == best.rank and rank > NONE and energy > best.energy):
                best.ground = ground
                best.interface = interface
                best.motion = w
                best.energy = energy
                best.rank = rank
                best.pulls = pulls1 or pulls2
    return best


@wp.func
def after_force(stack: Stack, s1: real, s2: real, rotation: Pair, rate: Pair, a: real) -> Choice:
    """The pattern that the forces choose, among those that keep the present pivots.

    Closed contacts stay closed, or open with an acceleration > 0. The present pattern is tried
    first, and kept if none is admissible.
    """
    shut1 = s1 == real(0.0)
    shut2 = s2 == real(0.0)
    best = Choice()
    place = int(0)
    while place < PATTERNS and best.rank < ADMISSIBLE:
        i1 = place % 3
        i2 = place // 3
        if (shut1 or i1 == 0) and (shut2 or i2 == 0):
            ground = wp.where(shut1, corner(i1), s1)
            interface = wp.where(shut2, corner(i2), s2)
            bend = accelerations(stack, ground, interface, rotation, rate, a)
            force = reactions(stack, ground, interface, rotation, rate, bend, a)
            turn = spins(stack, bend)
            margin = least_margin(stack, ground, interface, rotation, force, turn)
            holds = margin >= real(0.0) and opens(ground, interface, shut1, shut2, bend)
            if holds or place == 0:
                best.ground = ground
                best.interface = interface
                best.motion = bend
                best.rank = wp.where(holds, ADMISSIBLE, NONE)
                best.pulls = ground_pulls(force) or interface_pulls(stack, rotation, force)
        place += 1
    return best


@wp.func
def closes_again(lever: real, speed: real, bend: real, rest_rotation: real) -> bool:
    """Whether a contact that opens with a rate would close again before it opens by a rotation."""
    falls = lever != real(0.0) and bend < real(0.0)
    return falls and speed * speed < real(-2.0) * bend * rest_rotation


@wp.func
def close_slow_contacts(
    stack: Stack, found: Choice, shut1: bool, shut2: bool, rotation: Pair, a: real
) -> Choice:
    """The rest rule: closes touching contacts that open too slowly to count.

    It closes both if both may be closed, else the ground, else the interface. The contacts must
    then stay closed under the acceleration at that time.
    """
    zero = real(0.0)
    s1 = found.ground
    s2 = found.interface
    w = found.motion
    bend = accelerations(stack, s1, s2, rotation, w, a)
    small1 = shut1 and closes_again(s1, w[0], s1 * bend[0], stack.lower.rest_rotation)
    gap = s2 * (bend[1] - bend[0])
    small2 = shut2 and closes_again(s2, w[1] - w[0], gap, stack.upper.rest_rotation)
    momentum = momenta(stack, s1, s2, rotation, w, zero)
    spin = spins(stack, w)
    part = int(0)
    while part < 3:
        ground = wp.where(small1 and part != 2, zero, s1)
        interface = wp.where(small2 and part != 1, zero, s2)
        part += 1
        if ground != s1 or interface != s2:
            rate = project(stack, ground, interface, rotation, momentum, spin)
            kept = after_force(stack, ground, interface, rotation, rate, a)
            if kept.rank == ADMISSIBLE and kept.ground == ground and kept.interface == interface:
                found.ground = ground
                found.interface = interface
                found.motion = rate
                part = 3
    return found
