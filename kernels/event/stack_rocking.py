"""Blocks of a stack that stick at all their contacts, as polynomials in time; event/stack.py.

While every interface is closed or pivots on a corner that sticks, the stack is a chain: block k
turns about a point of its own below it, at B_k from its centre, and carries the next one at C_k
from that point, both in its frame. With R_k v such a lever after the rotation theta_k and v^ =
(z, -x) its change with it, the centres and what the contacts bear are

    r_k = R_0 C_0 + ... + R_(k-1) C_(k-1) - R_k B_k,   F_k = sum over i >= k of m_i (r_i'' + G),

G = (a, g) the acceleration of the base and gravity. The moment that interface k bears about that
point is the one that interface k + 1 bears, and

    I_k theta_k'' - m_k (R_k B_k)^ . (r_k'' + G) + (R_k C_k)^ . F_(k+1);

it is zero at a corner, and at a closed interface what keeps both rotations alike. Of each order in
time these equations are linear in that coefficient of theta'', all with the matrix of the start
(Leibniz's rule). Rotations are found to degree 6, forces and moments to degree 4.
"""

import warp as wp

from warprock.kernels.shape.stack import (
    CLOSED,
    Blocks,
    Counts,
    Pose,
    Triples,
    Values,
    anchored,
    lower_face,
    side_of,
)

DEGREE = 6
ORDERS = DEGREE - 1
"""Coefficients of an acceleration."""

Curves = wp.types.matrix(shape=(BLOCKS, DEGREE + 1), dtype=real)
"""A polynomial in time a block or an interface, its constant term first."""
Terms = wp.types.vector(length=ORDERS, dtype=real)
"""Coefficients of an acceleration of the base."""
Square = wp.types.matrix(shape=(BLOCKS, BLOCKS), dtype=real)


@wp.struct
class Chain:
    """Levers of a stack whose contacts stick: B and C of every block, mass and inertia [m, kg, kg m^2].

    `under`: 1 where the lower block's corner touches the upper one's face, whose normal counts.
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
    """Rotations [rad], and what interfaces bear: force [N] along x and z, moment [N m].

    Sines and cosines of the rotations, and with (X, Z) = (R_0 C)^ and (R_0 B)^ as at the start the
    moments of a block without its inertia, c u - s w [N m].
    """

    chain: Chain
    theta: Curves
    s: Curves
    c: Curves
    u: Curves
    w: Curves
    fx: Curves
    fz: Curves
    moment: Curves


@wp.func
def chain_of(blocks: Blocks, pose: Pose, touch: Counts) -> Chain:
    """The levers of a stack some of whose ends touch, and stick."""
    chain = Chain()
    for k in range(BLOCKS):
        anchor, rate = anchored(blocks, pose, k, touch[k])
        low, height = lower_face(blocks, k)
        side = side_of(touch[k])
        below = side * blocks.half_width[k]
        onto = anchor
        if rate < real(0.0):
            below = anchor
            onto = side * low
            chain.under[k] = 1
        if touch[k] == CLOSED:
            below = real(0.0)
        chain.mass[k] = real(1.0) / blocks.inverse_mass[k]
        chain.inertia[k] = real(1.0) / blocks.inverse_inertia[k]
        chain.bx[k] = below
        chain.bz[k] = -blocks.half_height[k]
        if k > 0:
            chain.cx[k - 1] = onto - chain.bx[k - 1]
            chain.cz[k - 1] = height + blocks.half_height[k - 1]
    return chain


@wp.func
def factors(chain: Chain, pose: Pose, touch: Counts) -> Square:
    """Gauss's factors of the matrix of theta''; blocks that lie flat turn with what is below."""
    m = Square()
    carried = real(0.0)
    for step in range(BLOCKS):
        k = BLOCKS - 1 - step
        bx = chain.bx[k]
        bz = chain.bz[k]
        cx = chain.cx[k]
        cz = chain.cz[k]
        mass = chain.mass[k]
        inertia = chain.inertia[k] + mass * (bx * bx + bz * bz)
        m[k, k] = inertia + carried * (cx * cx + cz * cz)
        px = carried * cx - mass * bx
        pz = carried * cz - mass * bz
        for j in range(k):
            sd = pose.sine[k] * pose.cosine[j] - pose.cosine[k] * pose.sine[j]
            cd = pose.cosine[k] * pose.cosine[j] + pose.sine[k] * pose.sine[j]
            qx = chain.cx[j]
            qz = chain.cz[j]
            mixed = (px * qx + pz * qz) * cd + (pz * qx - px * qz) * sd
            m[j, k] = mixed
            m[k, j] = mixed
        carried = carried + mass
    for step in range(BLOCKS):
        k = BLOCKS - 1 - step
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
        for i in range(k + 1, BLOCKS):
            part = m[i, k] * m[k, k]
            for j in range(k + 1, BLOCKS):
                m[i, j] = m[i, j] - part * m[k, j]
            m[i, k] = part
    return m


@wp.func
def bent(m: Square, touch: Counts, moments: Values) -> Values:
    """Angular accelerations, or coefficients of them, that take up moments of all blocks."""
    b = moments
    for step in range(BLOCKS):
        k = BLOCKS - 1 - step
        if touch[k] == CLOSED:
            if k > 0:
                b[k - 1] = b[k - 1] + b[k]
            b[k] = real(0.0)
    for k in range(BLOCKS):
        for j in range(k):
            b[k] = b[k] - m[k, j] * b[j]
    for step in range(BLOCKS):
        k = BLOCKS - 1 - step
        for j in range(k + 1, BLOCKS):
            b[k] = b[k] - m[k, j] * b[j]
        b[k] = b[k] * m[k, k]
    for k in range(1, BLOCKS):
        if touch[k] == CLOSED:
            b[k] = b[k - 1]
    return b


@wp.func(inline=False)
def rocking(
    blocks: Blocks, pose: Pose, touch: Counts, velocity: Triples, ax: Terms, az: Terms
) -> Rocking:
    """Taylor polynomials of a stack that sticks where its ends touch.

    Args:
        blocks: The blocks.
        pose: Where they are.
        touch: Ends that touch and stick.
        velocity: Velocities, of which the rotations count.
        ax, az: Taylor coefficients of the acceleration of the base, upwards with gravity [m/s^2].
    """
    chain = chain_of(blocks, pose, touch)
    m = factors(chain, pose, touch)
    r = Rocking()
    r.chain = chain
    zero = real(0.0)
    for k in range(BLOCKS):
        r.theta[k, 0] = pose.theta[k]
        r.theta[k, 1] = velocity[3 * k + 2]
        r.s[k, 0] = pose.sine[k]
        r.c[k, 0] = pose.cosine[k]
        r.s[k, 1] = velocity[3 * k + 2] * pose.cosine[k]
        r.c[k, 1] = -velocity[3 * k + 2] * pose.sine[k]
    for n in range(ORDERS):
        # Second derivatives of sines and cosines without the new coefficients of rotations, and
        # moments of lower orders.
        s2 = Values()
        c2 = Values()
        load = Values()
        for k in range(BLOCKS):
            sk = zero
            ck = zero
            lk = zero
            for i in range(wp.static(n + 1)):
                sk = sk + real(wp.static(i + 1)) * r.theta[k, i + 1] * r.c[k, n + 1 - i]
                ck = ck - real(wp.static(i + 1)) * r.theta[k, i + 1] * r.s[k, n + 1 - i]
            for i in range(wp.static(n)):
                lk = lk + r.c[k, wp.static(i + 1)] * r.u[k, n - 1 - i] - r.s[k, i + 1] * r.w[k, n - 1 - i]
            s2[k] = real(n + 1) * sk
            c2[k] = real(n + 1) * ck
            load[wp.static(k)] = lk
        x = real(ax[n])
        z = real(az[n])
        for k in range(BLOCKS):
            r.fx[k, n] = chain.mass[k] * (x - chain.bx[k] * c2[k] - chain.bz[k] * s2[k])
            r.fz[k, n] = chain.mass[k] * (z - chain.bz[k] * c2[k] + chain.bx[k] * s2[k])
            x = x + chain.cx[k] * c2[k] + chain.cz[k] * s2[k]
            z = z + chain.cz[k] * c2[k] - chain.cx[wp.static(k)] * s2[k]
        x = zero
        z = zero
        moments = Values()
        for step in range(BLOCKS):
            k = wp.static(BLOCKS - 1 - step)
            gx = r.fx[k, n]
            gz = r.fz[k, n]
            u = chain.cz[k] * x - chain.cx[k] * z - chain.bz[k] * gx + chain.bx[k] * gz
            w = chain.cx[k] * x + chain.cz[k] * z - chain.bx[k] * gx - chain.bz[k] * gz
            x = x + gx
            z = z + gz
            moments[k] = load[k] + pose.cosine[k] * u - pose.sine[k] * w
        bend = bent(m, touch, -moments)
        x = real(ax[n])
        z = real(az[n])
        over = real(1.0) / real((n + 1) * (n + 2))
        for k in range(BLOCKS):
            sk = s2[k] + bend[k] * pose.cosine[k]
            ck = c2[k] - bend[k] * pose.sine[k]
            r.fx[k, n] = chain.mass[k] * (x - chain.bx[k] * ck - chain.bz[k] * sk)
            r.fz[k, n] = chain.mass[k] * (z - chain.bz[k] * ck + chain.bx[k] * sk)
            x = x + chain.cx[k] * ck + chain.cz[k] * sk
            z = z + chain.cz[k] * ck - chain.cx[k] * sk
            r.theta[k, n + 2] = bend[k] * over
            r.s[k, n + 2] = sk * over
            r.c[k, wp.static(n + 2)] = ck * over
        x = zero
        z = zero
        above = zero
        for step in range(BLOCKS):
            k = wp.static(BLOCKS - 1 - step)
            gx = r.fx[k, n]
            gz = r.fz[k, n]
            u = chain.cz[k] * x - chain.cx[k] * z - chain.bz[k] * gx + chain.bx[k] * gz
            w = chain.cx[k] * x + chain.cz[k] * z - chain.bx[k] * gx - chain.bz[k] * gz
            x = x + gx
            z = z + gz
            r.fx[k, n] = x
            r.fz[k, n] = z
            r.u[k, n] = u
            r.w[k, n] = w
            above = above + load[k] + pose.cosine[k] * u - pose.sine[k] * w
            above = above + bend[k] * chain.inertia[k]
            r.moment[k, n] = above
    return r
