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
    """Levers of a stack whose contacts stick: B and C of every block, and its mass [m, kg].

    `under`: 1 where the lower block's corner touches the upper one's face, whose normal counts.
    """

    bx: Values
    bz: Values
    cx: Values
    cz: Values
    mass: Values
    under: Counts


@wp.struct
class Rocking:
    """Rotations [rad], and what interfaces bear: force [N] along x and z, moment [N m]."""

    chain: Chain
    theta: Curves
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
        chain.bx[k] = below
        chain.bz[k] = -blocks.half_height[k]
        if k > 0:
            chain.cx[k - 1] = onto - chain.bx[k - 1]
            chain.cz[k - 1] = height + blocks.half_height[k - 1]
    return chain


@wp.func
def factors(blocks: Blocks, chain: Chain, pose: Pose, touch: Counts) -> Square:
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
        inertia = real(1.0) / blocks.inverse_inertia[k] + mass * (bx * bx + bz * bz)
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
    m = factors(blocks, chain, pose, touch)
    r = Rocking()
    r.chain = chain
    s = Curves()
    c = Curves()
    u = Curves()
    w = Curves()
    for k in range(BLOCKS):
        r.theta[k, 0] = pose.theta[k]
        r.theta[k, 1] = velocity[3 * k + 2]
        s[k, 0] = pose.sine[k]
        c[k, 0] = pose.cosine[k]
        s[k, 1] = velocity[3 * k + 2] * pose.cosine[k]
        c[k, 1] = -velocity[3 * k + 2] * pose.sine[k]
    for n in range(ORDERS):
        # Second derivatives of sines and cosines, at first without the new coefficients.
        s2 = Values()
        c2 = Values()
        bend = Values()
        for k in range(BLOCKS):
            for i in range(1, n + 2):
                part = real(i) * r.theta[k, i]
                s2[k] = s2[k] + part * c[k, n + 2 - i]
                c2[k] = c2[k] - part * s[k, n + 2 - i]
            s2[k] = real(n + 1) * s2[k]
            c2[k] = real(n + 1) * c2[k]
        for turn in range(2):
            x = ax[n]
            z = az[n]
            for k in range(BLOCKS):
                sk = s2[k] + bend[k] * pose.cosine[k]
                ck = c2[k] - bend[k] * pose.sine[k]
                r.fx[k, n] = chain.mass[k] * (x - chain.bx[k] * ck - chain.bz[k] * sk)
                r.fz[k, n] = chain.mass[k] * (z - chain.bz[k] * ck + chain.bx[k] * sk)
                x = x + chain.cx[k] * ck + chain.cz[k] * sk
                z = z + chain.cz[k] * ck - chain.cx[k] * sk
            x = real(0.0)
            z = real(0.0)
            load = Values()
            for step in range(BLOCKS):
                k = BLOCKS - 1 - step
                gx = r.fx[k, n]
                gz = r.fz[k, n]
                u[k, n] = chain.cz[k] * x - chain.cx[k] * z - chain.bz[k] * gx + chain.bx[k] * gz
                w[k, n] = chain.cx[k] * x + chain.cz[k] * z - chain.bx[k] * gx - chain.bz[k] * gz
                x = x + gx
                z = z + gz
                r.fx[k, n] = x
                r.fz[k, n] = z
                for i in range(n + 1):
                    load[k] = load[k] + c[k, i] * u[k, n - i] - s[k, i] * w[k, n - i]
            if turn == 0:
                bend = bent(m, touch, -load)
            else:
                above = real(0.0)
                for step in range(BLOCKS):
                    k = BLOCKS - 1 - step
                    above = above + load[k] + bend[k] / blocks.inverse_inertia[k]
                    r.moment[k, n] = above
        over = real(1.0) / real((n + 1) * (n + 2))
        for k in range(BLOCKS):
            r.theta[k, n + 2] = bend[k] * over
            s[k, n + 2] = (s2[k] + bend[k] * pose.cosine[k]) * over
            c[k, n + 2] = (c2[k] - bend[k] * pose.sine[k]) * over
    return r
