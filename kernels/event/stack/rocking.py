"""Taylor polynomials of a stack that sticks at all its contacts; event/stack/step.py.

While every interface is closed or pivots on a corner that sticks, the stack is a chain with the
equations of event/stack/links.py. At each order in time these are linear in that coefficient of
theta'', all with the matrix of the start (Leibniz's rule). Rotations are found to degree 6, forces
and moments to degree 4.
"""

import warp as wp

from warprock.kernels.event.stack.curves import ORDERS, Curves
from warprock.kernels.event.stack.links import (
    Chain,
    accelerate,
    inertia_forces,
    interface_forces,
    missing_moments,
)
from warprock.kernels.event.stack.moves import opening, settles
from warprock.kernels.event.stack.state import Limits
from warprock.kernels.shape.stack import CLOSED, Blocks, Counts, Pose, Triples, Values, side_of

BRIEF = by_precision(1.0 / 16.0, 0.0)
BRIEF_ORDERS = ORDERS - 2
"""A step that ends this soon, as a part of the longest one d, is followed in polynomials of two
degrees less, up to twice the time that the first accelerations tell. They leave out some
(p d / 8)^5 / 5! of a motion at a frequency p, less than the (p d)^7 / 7! that all degrees leave out
of a step d long if p d is above 0.04, and else less than 3e-14. In float32 no step is: a corner
that lies flat but for round-off would seem to land soon in one step after the other."""

Terms = wp.types.vector(length=ORDERS, dtype=real)
"""Coefficients of an acceleration of the base."""


@wp.struct
class Rocking:
    """Polynomials of a stack whose contacts stick.

    Attributes:
        waits: Whether interfaces fall flat at once. Then nothing else is found but
        rests: which of them do: CLOSED there.
        reach: Time up to which the polynomials serve [s].
        theta: Rotations [rad].
        fx, fz: Forces on the interfaces [N].
        moment: Moments on the interfaces about their pivots [N m].
    """

    waits: bool
    rests: Counts
    reach: real
    theta: Curves
    fx: Curves
    fz: Curves
    moment: Curves


@wp.func
def first_terms(pose: wp.ref[Pose], velocity: Triples):
    """Polynomials of rotations, their sines and cosines to the terms that the state gives."""
    theta, s, c = Curves(), Curves(), Curves()
    for k in range(BLOCKS):
        spin = velocity[wp.static(3 * k + 2)]
        theta[k, 0] = pose.theta[k]
        theta[k, 1] = spin
        s[k, 0] = pose.sine[k]
        c[k, 0] = pose.cosine[k]
        s[k, 1] = spin * pose.cosine[k]
        c[k, 1] = -spin * pose.sine[k]
    return theta, s, c


@wp.func
def look_at_start(
    pose: wp.ref[Pose], touch: Counts, velocity: Triples, bend: Values, rest: Values
):  # fmt: skip
    """What the accelerations at its start tell of a step.

    Args:
        pose: The pose, with the ends that touched before.
        touch: Ends that touch and stick.
        velocity: Velocities.
        bend: Angular accelerations [rad/s^2].
        rest: Swings below which a block rests [rad].

    Returns:
        Interfaces that fall flat again at once, see `settles`: CLOSED there; whether any does; when
        the first of the others falls flat [s].
    """
    soonest = NEVER
    rests = Counts()
    waits = bool(False)
    for k in range(BLOCKS):
        if touch[k] != CLOSED and pose.touch[k] == touch[k]:
            more = bend[k]
            if k > 0:
                more = more - bend[k - 1]
            more = side_of(touch[k]) * more
            start = opening(pose, velocity, k, touch[k])
            if more < real(0.0):
                if settles(start, HALF * more, rest[k]):
                    rests[k] = CLOSED
                    waits = True
                else:
                    angle = larger(start.angle, real(0.0))
                    speed = wp.sqrt(fused_less(TWO * more, angle, start.rate * start.rate))
                    soonest = smaller(soonest, -(start.rate + speed) / more)
    return rests, waits, soonest


@wp.func(inline=False)
def predict_rocking(
    blocks: wp.ref[Blocks], limits: wp.ref[Limits], pose: wp.ref[Pose], touch: Counts,
    chain: wp.ref[Chain], velocity: Triples, ax: Terms, az: Terms,
) -> Rocking:  # fmt: skip
    """Taylor polynomials of a stack that sticks where its ends touch.

    Args:
        blocks: The blocks.
        limits: The lane's limits.
        pose: The pose.
        touch: Ends that touch and stick.
        chain: The chain that they make.
        velocity: Velocities; the angular ones count.
        ax, az: Taylor coefficients of the acceleration of the base, upwards with gravity [m/s^2].
    """
    r = Rocking()
    theta, s, c = first_terms(pose, velocity)
    us, ws = Curves(), Curves()
    soon = bool(False)
    for n in range(ORDERS):
        if n == BRIEF_ORDERS and soon:
            r.theta = theta
            return r
        # Second derivatives without the new coefficients of the rotations; moments of lower orders.
        s2 = Values()
        c2 = Values()
        load = Values()
        for k in range(BLOCKS):
            sk = real(0.0)
            ck = real(0.0)
            lk = real(0.0)
            for i in range(wp.static(n + 1)):
                part = real(wp.static(i + 1)) * theta[k, i + 1]
                sk = fused(part, c[k, n + 1 - i], sk)
                ck = fused_less(part, s[k, n + 1 - i], ck)
            for i in range(wp.static(n)):
                j = wp.static(i + 1)
                lk = fused(c[k, j], us[k, n - j], fused_less(s[k, j], ws[k, n - j], lk))
            s2[k] = real(n + 1) * sk
            c2[k] = real(n + 1) * ck
            load[wp.static(k)] = lk
        gx, gz = inertia_forces(blocks, chain, s2, c2, ax[n], az[n])
        _fx, _fz, u, w = interface_forces(chain, gx, gz)
        bend = accelerate(chain, touch, missing_moments(load, pose, u, w))
        if n == 0:
            rests, waits, soonest = look_at_start(pose, touch, velocity, bend, limits.rest_rotation)
            soon = soonest < BRIEF * limits.longest_step
            r.reach = wp.where(soon, TWO * soonest, NEVER)
            if waits:
                r.waits = True
                r.rests = rests
                return r
        for k in range(BLOCKS):
            s2[k] = fused(bend[k], pose.cosine[k], s2[k])
            c2[k] = fused_less(bend[k], pose.sine[k], c2[k])
        gx, gz = inertia_forces(blocks, chain, s2, c2, ax[n], az[n])
        fx, fz, u, w = interface_forces(chain, gx, gz)
        missing = missing_moments(load, pose, u, w)
        over = real(1.0) / real((n + 1) * (n + 2))
        above = real(0.0)
        for step in range(BLOCKS):
            k = wp.static(BLOCKS - 1 - step)
            above = above + fused(bend[k], blocks.inertia[k], -missing[k])
            r.moment[k, n] = above
            r.fx[k, n] = fx[k]
            r.fz[k, n] = fz[k]
            us[k, n] = u[k]
            ws[k, n] = w[k]
            theta[k, n + 2] = over * bend[k]
            s[k, n + 2] = over * s2[k]
            c[k, n + 2] = over * c2[k]
    r.theta = theta
    return r
