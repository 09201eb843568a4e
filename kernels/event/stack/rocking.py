"""Taylor polynomials of a stack that sticks at all its contacts; event/stack/step.py.

While every interface is closed or pivots on a corner that sticks, the stack is a chain: block k
turns about a pivot below it, at B_k from its centre, and carries the pivot of the next one at C_k
from its own, both in its frame. With R_k v such a lever after the rotation theta_k and v^ =
(z, -x) its derivative by theta_k, the centres and the forces on the interfaces are

    r_k = R_0 C_0 + ... + R_(k-1) C_(k-1) - R_k B_k,   F_k = sum over i >= k of m_i (r_i'' + G),

G = (a, g) the acceleration of the base and gravity. The moment on interface k about its pivot is
that on interface k + 1, and

    I_k theta_k'' - m_k (R_k B_k)^ . (r_k'' + G) + (R_k C_k)^ . F_(k+1);

it is zero at a corner; at a closed interface it keeps both rotations alike. At each order in time
these equations are linear in that coefficient of theta'', all with the matrix of the start
(Leibniz's rule). Rotations are found to degree 6, forces and moments to degree 4.
"""

import warp as wp

from warprock.kernels.event.stack.curves import ORDERS, Curves
from warprock.kernels.event.stack.moves import opening, settles
from warprock.kernels.event.stack.state import Limits
from warprock.kernels.shape.stack import (
    CLOSED,
    Blocks,
    Counts,
    Pose,
    Triples,
    Values,
    face_middles,
    find_anchor,
    lower_face,
    side_of,
)

BRIEF = by_precision(1.0 / 16.0, 0.0)
BRIEF_ORDERS = ORDERS - 2
"""A step that ends this soon, as a part of the longest one d, is followed in polynomials of two
degrees less, up to twice the time that the first accelerations tell. They leave out some
(p d / 8)^5 / 5! of a motion at a frequency p, less than the (p d)^7 / 7! that all degrees leave out
of a step d long if p d is above 0.04, and else less than 3e-14. In float32 no step is: a corner
that lies flat but for round-off would seem to land soon in one step after the other."""

Terms = wp.types.vector(length=ORDERS, dtype=real)
"""Coefficients of an acceleration of the base."""
Square = wp.types.matrix(shape=(BLOCKS, BLOCKS), dtype=real)


@wp.struct
class Chain:
    """A stack whose contacts stick.

    Attributes:
        bx, bz, cx, cz: Levers B and C of every block [m].
        mass, inertia: [kg], [kg m^2].
        under: 1 where the lower block's corner touches the upper one's face, whose normal counts.
    """

    bx: Values
    bz: Values
    cx: Values
    cz: Values
    mass: Values
    inertia: Values
    under: Counts


@wp.struct
class Rocking:
    """Polynomials of a stack whose contacts stick.

    Attributes:
        waits: Whether interfaces fall flat at once. Then nothing else is found but
        rests: which of them do: CLOSED there.
        reach: Time up to which the polynomials serve [s].
        chain: Its levers.
        theta: Rotations [rad].
        fx, fz: Forces on the interfaces [N].
        moment: Moments on the interfaces about their pivots [N m].
    """

    waits: bool
    rests: Counts
    reach: real
    chain: Chain
    theta: Curves
    fx: Curves
    fz: Curves
    moment: Curves


@wp.func
def chain_of(blocks: wp.ref[Blocks], pose: wp.ref[Pose], touch: Counts) -> Chain:
    """The levers of a stack that sticks where its ends touch."""
    chain = Chain()
    for k in range(BLOCKS):
        anchor = find_anchor(blocks, pose, wp.static(k), touch[k])
        low, height = lower_face(blocks, k)
        side = side_of(touch[k])
        below = side * blocks.half_width[k]
        onto = anchor.place
        if anchor.rate < real(0.0):
            below = anchor.place
            onto = side * low
            chain.under[k] = 1
        if touch[k] == CLOSED:
            below = real(0.0)
        chain.mass[k] = real(1.0) / blocks.inverse_mass[k]
        chain.inertia[k] = real(1.0) / blocks.inverse_inertia[k]
        chain.bx[k] = below
        chain.bz[k] = -blocks.half_height[k]
        if CHAINS:
            upper, lower = face_middles(blocks, k)
            depth = -blocks.half_height[k]
            s = blocks.foot_sine[k]
            c = blocks.foot_cosine[k]
            chain.bx[k] = (below + upper) * c - depth * s
            chain.bz[k] = depth * c + (below + upper) * s
            onto = onto + lower
        if k > 0:
            chain.cx[k - 1] = onto - chain.bx[k - 1]
            chain.cz[k - 1] = height - chain.bz[k - 1]
    return chain


@wp.func
def factorize(chain: wp.ref[Chain], pose: wp.ref[Pose], touch: Counts) -> Square:
    """Factors of the matrix of theta''; a block that lies flat turns with the one below.

    The lower half has those below the diagonal of L, the diagonal the inverse of D, in L D L^T.
    """
    m = Square()
    carried = real(0.0)
    for step in range(BLOCKS):
        k = wp.static(BLOCKS - 1 - step)
        bx = chain.bx[k]
        bz = chain.bz[k]
        cx = chain.cx[k]
        cz = chain.cz[k]
        mass = chain.mass[k]
        inertia = chain.inertia[k] + mass * (bx * bx + bz * bz)
        m[k, k] = inertia + carried * (cx * cx + cz * cz)
        px = carried * cx - mass * bx
        pz = carried * cz - mass * bz
        for j in range(wp.static(k)):
            sd = wedge(pose.cosine[j], pose.sine[j], pose.cosine[k], pose.sine[k])
            cd = dot(pose.cosine[k], pose.sine[k], pose.cosine[j], pose.sine[j])
            qx = chain.cx[j]
            qz = chain.cz[j]
            mixed = fused(dot(px, pz, qx, qz), cd, wedge(qx, qz, px, pz) * sd)
            m[j, k] = mixed
            m[k, j] = mixed
        carried = carried + mass
    for step in range(BLOCKS):
        k = wp.static(BLOCKS - 1 - step)
        if touch[k] == CLOSED:
            if k > 0:
                for j in range(BLOCKS):
                    m[k - 1, j] = m[k - 1, j] + m[k, j]
                for j in range(BLOCKS):
                    m[j, k - 1] = m[j, k - 1] + m[j, k]
            for j in range(BLOCKS):
                m[k, j] = real(0.0)
                m[j, k] = real(0.0)
            m[k, k] = real(1.0)
    for k in range(BLOCKS):
        m[k, k] = real(1.0) / m[k, k]
        for i in range(wp.static(k + 1), BLOCKS):
            m[k, i] = m[i, k]
            m[i, k] = m[i, k] * m[k, k]
            for j in range(wp.static(k + 1), wp.static(i + 1)):
                m[i, j] = fused_less(m[i, k], m[k, j], m[i, j])
    return m


@wp.func
def accelerate(m: wp.ref[Square], touch: Counts, moments: Values) -> Values:
    """Angular accelerations, or coefficients of them, from moments of all blocks [N m]."""
    b = moments
    for step in range(BLOCKS):
        k = wp.static(BLOCKS - 1 - step)
        if touch[k] == CLOSED:
            if k > 0:
                b[k - 1] = b[k - 1] + b[k]
            b[k] = real(0.0)
    for k in range(BLOCKS):
        for j in range(wp.static(k)):
            b[k] = fused_less(m[k, j], b[j], b[k])
    for k in range(BLOCKS):
        b[k] = b[k] * m[k, k]
    for step in range(BLOCKS):
        k = wp.static(BLOCKS - 1 - step)
        # What is known last comes last, so that the processor waits for one product a block.
        for after in range(wp.static(step)):
            j = wp.static(BLOCKS - 1 - after)
            b[k] = fused_less(m[j, k], b[j], b[k])
    for k in range(1, BLOCKS):
        if touch[wp.static(k)] == CLOSED:
            b[k] = b[k - 1]
    return b


@wp.func
def inertia_forces(chain: wp.ref[Chain], s2: Values, c2: Values, ax: real, az: real):
    """Mass times acceleration of all blocks in the frame of the ground, with gravity [N].

    Args:
        chain: Their levers.
        s2, c2: Second derivatives of the sines and cosines of their rotations.
        ax, az: Acceleration of the base, upwards with gravity [m/s^2].
    """
    gx = Values()
    gz = Values()
    x = real(ax)
    z = real(az)
    for k in range(BLOCKS):
        sk = s2[k]
        ck = c2[k]
        gx[k] = chain.mass[k] * fused_less(chain.bz[k], sk, fused_less(chain.bx[k], ck, x))
        gz[k] = chain.mass[k] * fused(chain.bx[k], sk, fused_less(chain.bz[k], ck, z))
        x = fused(chain.cz[k], sk, fused(chain.cx[k], ck, x))
        z = fused_less(chain.cx[wp.static(k)], sk, fused(chain.cz[k], ck, z))
    return gx, gz


@wp.func
def interface_forces(chain: wp.ref[Chain], gx: Values, gz: Values):
    """Forces on the interfaces (x, z) [N], and moments u and w of them in the frames of the blocks.

    With s and c of a block's rotation, c u - s w is the moment on it about its pivot without its
    inertia [N m].
    """
    fx = Values()
    fz = Values()
    u = Values()
    w = Values()
    x = real(0.0)
    z = real(0.0)
    for step in range(BLOCKS):
        k = wp.static(BLOCKS - 1 - step)
        # The forces from above are known last.
        own_u = fused_less(chain.bz[k], gx[k], chain.bx[k] * gz[k])
        own_w = fused(chain.bx[k], gx[k], chain.bz[k] * gz[k])
        u[k] = fused(chain.cz[k], x, fused_less(chain.cx[k], z, own_u))
        w[k] = fused(chain.cx[k], x, fused(chain.cz[k], z, -own_w))
        x = x + gx[k]
        z = z + gz[k]
        fx[k] = x
        fz[k] = z
    return fx, fz, u, w


@wp.func
def missing_moments(load: Values, pose: wp.ref[Pose], u: Values, w: Values) -> Values:
    """Moments that the angular accelerations must balance [N m], see `interface_forces`."""
    missing = Values()
    for k in range(BLOCKS):
        missing[k] = fused(pose.sine[k], w[k], fused_less(pose.cosine[k], u[k], -load[k]))
    return missing


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
    velocity: Triples, ax: Terms, az: Terms,
) -> Rocking:  # fmt: skip
    """Taylor polynomials of a stack that sticks where its ends touch.

    Args:
        blocks: The blocks.
        limits: The lane's limits.
        pose: The pose.
        touch: Ends that touch and stick.
        velocity: Velocities; the angular ones count.
        ax, az: Taylor coefficients of the acceleration of the base, upwards with gravity [m/s^2].
    """
    r = Rocking()
    chain = chain_of(blocks, pose, touch)
    r.chain = chain
    theta, s, c = first_terms(pose, velocity)
    us, ws = Curves(), Curves()
    m = factorize(chain, pose, touch)
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
        gx, gz = inertia_forces(chain, s2, c2, ax[n], az[n])
        _fx, _fz, u, w = interface_forces(chain, gx, gz)
        bend = accelerate(m, touch, missing_moments(load, pose, u, w))
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
        gx, gz = inertia_forces(chain, s2, c2, ax[n], az[n])
        fx, fz, u, w = interface_forces(chain, gx, gz)
        missing = missing_moments(load, pose, u, w)
        over = real(1.0) / real((n + 1) * (n + 2))
        above = real(0.0)
        for step in range(BLOCKS):
            k = wp.static(BLOCKS - 1 - step)
            above = above + fused(bend[k], chain.inertia[k], -missing[k])
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
