"""A stack that sticks at all its contacts: a chain of blocks; event/stack/rocking.py.

Every interface is closed or pivots on a corner. Block k turns about a pivot below it, at B_k from
its centre, and carries the pivot of the next one at C_k from its own, both in its frame. With R_k v
such a lever after the rotation theta_k and v^ = (z, -x) its derivative by theta_k, the centres and
the forces on the interfaces are

    r_k = R_0 C_0 + ... + R_(k-1) C_(k-1) - R_k B_k,   F_k = sum over i >= k of m_i (r_i'' + G),

G = (a, g) the acceleration of the base and gravity. The moment on interface k about its pivot is
that on interface k + 1, and

    I_k theta_k'' - m_k (R_k B_k)^ . (r_k'' + G) + (R_k C_k)^ . F_(k+1);

it is zero at a corner; at a closed interface it keeps both rotations alike. In an impact the same
holds of changes of velocities and of impulses, without G.
"""

import warp as wp

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

Square = wp.types.matrix(shape=(BLOCKS, BLOCKS), dtype=real)


@wp.struct
class Chain:
    """A stack whose contacts stick, in a pose.

    Attributes:
        bx, bz, cx, cz: Levers B and C of every block [m].
        place: Places of the anchors of the contacts, see shape/stack.py [m].
        under: 1 where the lower block's corner touches the upper one's face, whose normal counts.
        factors: Of the matrix of theta'', see `factorize`.
        known: Whether it is that of the pose and the touching ends of a state.
    """

    bx: Values
    bz: Values
    cx: Values
    cz: Values
    place: Values
    under: Counts
    factors: Square
    known: bool


@wp.func
def set_levers(blocks: wp.ref[Blocks], pose: wp.ref[Pose], touch: Counts, chain: wp.ref[Chain]):
    """Sets the levers of a stack that sticks where its ends touch."""
    for k in range(BLOCKS):
        anchor = find_anchor(blocks, pose, wp.static(k), touch[k])
        low, height = lower_face(blocks, k)
        side = side_of(touch[k])
        below = side * blocks.half_width[k]
        onto = anchor.place
        if anchor.rate < real(0.0):
            below = anchor.place
            onto = side * low
        if touch[k] == CLOSED:
            below = real(0.0)
        chain.place[k] = anchor.place
        chain.under[k] = wp.where(anchor.rate < real(0.0), 1, 0)
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


@wp.func
def factorize(blocks: wp.ref[Blocks], pose: wp.ref[Pose], touch: Counts, chain: wp.ref[Chain]):
    """Sets the factors of the matrix of theta''; a block that lies flat turns with the one below.

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
        mass = blocks.mass[k]
        inertia = blocks.inertia[k] + mass * (bx * bx + bz * bz)
        m[k, k] = inertia + carried * (cx * cx + cz * cz)
        px = carried * cx - mass * bx
        pz = carried * cz - mass * bz
        for j in range(wp.static(k)):
            sd = wedge(pose.cosine[j], pose.sine[j], pose.cosine[k], pose.sine[k])
            cd = dot(pose.cosine[k], pose.sine[k], pose.cosine[j], pose.sine[j])
            qx = chain.cx[j]
            qz = chain.cz[j]
            mixed = fused(dot(px, pz, qx, qz), cd, wedge(qx, qz, px, pz) * sd)
            m[k, j] = mixed
        carried = carried + mass
    for step in range(BLOCKS):
        k = wp.static(BLOCKS - 1 - step)
        if touch[k] == CLOSED:
            if k > 0:
                beside = m[k, k - 1]
                m[k - 1, k - 1] = (m[k - 1, k - 1] + beside) + (beside + m[k, k])
                for j in range(wp.static(k - 1)):
                    m[k - 1, j] = m[k - 1, j] + m[k, j]
                for j in range(wp.static(k + 1), BLOCKS):
                    m[j, k - 1] = m[j, k - 1] + m[j, k]
            for j in range(wp.static(k)):
                m[k, j] = real(0.0)
            for j in range(wp.static(k + 1), BLOCKS):
                m[j, k] = real(0.0)
            m[k, k] = real(1.0)
    for k in range(BLOCKS):
        m[k, k] = real(1.0) / m[k, k]
        for i in range(wp.static(k + 1), BLOCKS):
            m[k, i] = m[i, k]
            m[i, k] = m[i, k] * m[k, k]
            for j in range(wp.static(k + 1), wp.static(i + 1)):
                m[i, j] = fused_less(m[i, k], m[k, j], m[i, j])
    chain.factors = m


@wp.func(inline=False)
def link(blocks: wp.ref[Blocks], pose: wp.ref[Pose], touch: Counts, chain: wp.ref[Chain]):
    """Sets the chain of a stack that sticks where its ends touch."""
    set_levers(blocks, pose, touch, chain)
    factorize(blocks, pose, touch, chain)
    chain.known = True


@wp.func
def accelerate(chain: wp.ref[Chain], touch: Counts, moments: Values) -> Values:
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
            b[k] = fused_less(chain.factors[k, j], b[j], b[k])
    for k in range(BLOCKS):
        b[k] = b[k] * chain.factors[k, k]
    for step in range(BLOCKS):
        k = wp.static(BLOCKS - 1 - step)
        # What is known last comes last, so that the processor waits for one product a block.
        for after in range(wp.static(step)):
            j = wp.static(BLOCKS - 1 - after)
            b[k] = fused_less(chain.factors[j, k], b[j], b[k])
    for k in range(1, BLOCKS):
        if touch[wp.static(k)] == CLOSED:
            b[k] = b[k - 1]
    return b


@wp.func
def inertia_forces(
    blocks: wp.ref[Blocks], chain: wp.ref[Chain], s2: Values, c2: Values, ax: real, az: real
):  # fmt: skip
    """Mass times acceleration of all blocks in the frame of the ground, with gravity [N].

    Args:
        blocks: The blocks.
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
        gx[k] = blocks.mass[k] * fused_less(chain.bz[k], sk, fused_less(chain.bx[k], ck, x))
        gz[k] = blocks.mass[k] * fused(chain.bx[k], sk, fused_less(chain.bz[k], ck, z))
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
def velocities_of(chain: wp.ref[Chain], pose: wp.ref[Pose], spins: Values) -> Triples:
    """Velocities of all blocks from the angular ones [rad/s]."""
    v = Triples()
    x = real(0.0)
    z = real(0.0)
    for k in range(BLOCKS):
        spin = spins[k]
        s = pose.sine[k]
        c = pose.cosine[k]
        v[3 * k] = x - spin * (chain.bz[k] * c - chain.bx[k] * s)
        v[3 * k + 1] = z + spin * (chain.bx[k] * c + chain.bz[k] * s)
        v[3 * k + 2] = spin
        x = x + spin * (chain.cz[k] * c - chain.cx[k] * s)
        z = z - spin * (chain.cx[k] * c + chain.cz[k] * s)
    return v


@wp.func
def sum_moments(
    blocks: wp.ref[Blocks], chain: wp.ref[Chain], pose: wp.ref[Pose], velocity: Triples
):
    """Sums of momenta above the interfaces (x, z) [N s], and moments of all blocks [N m s].

    The moments are those that the velocities of a chain have in its equations: its matrix times the
    angular velocities.
    """
    gx = Values()
    gz = Values()
    for k in range(BLOCKS):
        gx[k] = blocks.mass[k] * velocity[3 * k]
        gz[k] = blocks.mass[k] * velocity[wp.static(3 * k + 1)]
    fx, fz, u, w = interface_forces(chain, gx, gz)
    moments = Values()
    for k in range(BLOCKS):
        turns = blocks.inertia[k] * velocity[wp.static(3 * k + 2)]
        moments[k] = fused_less(pose.sine[k], w[k], fused(pose.cosine[k], u[k], turns))
    return fx, fz, moments


@wp.func
def hold_together(
    blocks: wp.ref[Blocks], chain: wp.ref[Chain], pose: wp.ref[Pose], touch: Counts,
    velocity: Triples,
) -> Triples:  # fmt: skip
    """Velocities of a chain after impulses at its contacts, from any without them."""
    _x, _z, moments = sum_moments(blocks, chain, pose, velocity)
    return velocities_of(chain, pose, accelerate(chain, touch, moments))
