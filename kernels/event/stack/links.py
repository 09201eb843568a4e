"""A stack that sticks at all its contacts: a chain of blocks; event/stack/rocking.py.

Every interface is closed or pivots on a corner. Block k turns about a pivot below it, at B_k from
its centre, and carries the pivot of the next one at C_k from its own. With v^ = (z, -x) for a lever
v = (x, z) that turns with its block, the derivative by the rotation theta_k, the centres are

    r_k = A_k - B_k,   A_k = C_0 + ... + C_(k-1),

and the forces on the interfaces, with M_k the mass of block k and those on it,

    F_k = sum over i >= k of m_i (r_i'' + G) = M_k (A_k'' + G) + S_k,
    S_k = sum over i >= k of P_i'',   P_k = M_(k+1) C_k - m_k B_k,

G = (a, g) the acceleration of the base and gravity. The moment on interface k about its pivot is
that on interface k + 1, and

    I_k theta_k'' - m_k B_k^ . (r_k'' + G) + C_k^ . F_(k+1)
        = J_k theta_k'' + P_k^ . (A_k'' + G) + C_k^ . S_(k+1),
    J_k = I_k + m_k B_k^2 + M_(k+1) C_k^2,

since v^ . v'' = v^2 theta''. It is zero at a corner; at a closed interface it keeps both rotations
alike. In an impact the same holds of changes of velocities and of impulses, without G.
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
        touch: Ends that touch.
        bx, bz, cx, cz: Levers B and C of every block in the frame of the ground [m].
        px, pz: P [kg m].
        turns: J [kg m^2].
        place: Places of the anchors of the contacts, see shape/stack.py [m].
        under: 1 where the lower block's corner touches the upper one's face, whose normal counts.
        factors: Of the matrix of theta'', see `factorize`.
        known: Whether it is that of the pose and the touching ends of a state.
    """

    touch: Counts
    bx: Values
    bz: Values
    cx: Values
    cz: Values
    px: Values
    pz: Values
    turns: Values
    place: Values
    under: Counts
    factors: Square
    known: bool


@wp.func
def set_levers(blocks: wp.ref[Blocks], pose: wp.ref[Pose], touch: Counts, chain: wp.ref[Chain]):
    """Sets the levers of a stack that sticks where its ends touch."""
    chain.touch = touch
    carried = real(0.0)
    top_x = real(0.0)
    top_z = real(0.0)
    for step in range(BLOCKS):
        k = wp.static(BLOCKS - 1 - step)
        anchor = find_anchor(blocks, pose, k, touch[k])
        low, height = lower_face(blocks, k)
        side = side_of(touch[k])
        bx = side * blocks.half_width[k]
        bz = -blocks.half_height[k]
        onto = anchor.place
        if anchor.rate < real(0.0):
            bx = anchor.place
            onto = side * low
        if touch[k] == CLOSED:
            bx = real(0.0)
        if CHAINS:
            upper, lower = face_middles(blocks, k)
            across = bx + upper
            bx = across * blocks.foot_cosine[k] - bz * blocks.foot_sine[k]
            bz = bz * blocks.foot_cosine[k] + across * blocks.foot_sine[k]
            onto = onto + lower
        cx = top_x - bx
        cz = top_z - bz
        mass = blocks.mass[k]
        s = pose.sine[k]
        c = pose.cosine[k]
        chain.place[k] = anchor.place
        chain.under[k] = wp.where(anchor.rate < real(0.0), 1, 0)
        chain.turns[k] = fused(
            carried, dot(cx, cz, cx, cz), fused(mass, dot(bx, bz, bx, bz), blocks.inertia[k])
        )
        chain.bx[k] = dot(bx, bz, c, s)
        chain.bz[k] = wedge(bz, bx, s, c)
        chain.cx[k] = dot(cx, cz, c, s)
        chain.cz[k] = wedge(cz, cx, s, c)
        chain.px[k] = fused_less(mass, chain.bx[k], carried * chain.cx[k])
        chain.pz[k] = fused_less(mass, chain.bz[k], carried * chain.cz[k])
        carried = carried + mass
        top_x = onto
        top_z = height


@wp.func
def factorize(chain: wp.ref[Chain]):
    """Sets the factors of the matrix of theta''; a block that lies flat turns with the one below.

    That of theta_j'' in the moment on k > j is P_k . C_j. The lower half has the factors below the
    diagonal of L, the diagonal the inverse of D, in L D L^T.
    """
    m = Square()
    px, pz, cx, cz = Values(), Values(), Values(), Values()
    # What turns as one block has the sums of its levers.
    above_px = real(0.0)
    above_pz = real(0.0)
    above_cx = real(0.0)
    above_cz = real(0.0)
    above_turns = real(0.0)
    for step in range(BLOCKS):
        k = wp.static(BLOCKS - 1 - step)
        beside = dot(above_px, above_pz, chain.cx[k], chain.cz[k])
        above_px = chain.px[k] + above_px
        above_pz = chain.pz[k] + above_pz
        above_cx = chain.cx[k] + above_cx
        above_cz = chain.cz[k] + above_cz
        above_turns = fused(TWO, beside, chain.turns[k] + above_turns)
        if chain.touch[k] == CLOSED:
            m[k, k] = real(1.0)
        else:
            m[k, k] = above_turns
            px[k] = above_px
            pz[k] = above_pz
            cx[k] = above_cx
            cz[k] = above_cz
            above_px = real(0.0)
            above_pz = real(0.0)
            above_cx = real(0.0)
            above_cz = real(0.0)
            above_turns = real(0.0)
    for k in range(BLOCKS):
        for j in range(wp.static(k)):
            m[k, j] = dot(px[k], pz[k], cx[j], cz[j])
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
    factorize(chain)
    chain.known = True


@wp.func
def accelerate(chain: wp.ref[Chain], moments: Values) -> Values:
    """Angular accelerations, or coefficients of them, from moments of all blocks [N m]."""
    b = moments
    for step in range(BLOCKS):
        k = wp.static(BLOCKS - 1 - step)
        if chain.touch[k] == CLOSED:
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
        if chain.touch[wp.static(k)] == CLOSED:
            b[k] = b[k - 1]
    return b


@wp.func
def velocities_of(chain: wp.ref[Chain], spins: Values) -> Triples:
    """Velocities of all blocks from the angular ones [rad/s]."""
    v = Triples()
    x = real(0.0)
    z = real(0.0)
    for k in range(BLOCKS):
        spin = spins[k]
        v[3 * k] = fused_less(spin, chain.bz[k], x)
        v[3 * k + 1] = fused(spin, chain.bx[k], z)
        v[3 * k + 2] = spin
        x = fused(spin, chain.cz[k], x)
        z = fused_less(spin, chain.cx[k], z)
    return v


@wp.func
def velocities_after(
    chain: wp.ref[Chain], old: wp.ref[Pose], new: wp.ref[Pose], spins: Values
) -> Triples:  # fmt: skip
    """Velocities of all blocks in a new pose from the angular ones there [rad/s].

    `old` is the pose of the chain.
    """
    v = Triples()
    x = real(0.0)
    z = real(0.0)
    for k in range(BLOCKS):
        s = spins[k] * wedge(new.sine[k], new.cosine[k], old.sine[k], old.cosine[k])
        c = spins[k] * dot(new.cosine[k], new.sine[k], old.cosine[k], old.sine[k])
        v[3 * k] = x - wedge(chain.bz[k], chain.bx[k], s, c)
        v[3 * k + 1] = z + dot(chain.bx[k], chain.bz[k], c, s)
        v[3 * k + 2] = spins[k]
        x = x + wedge(chain.cz[k], chain.cx[k], s, c)
        z = z - dot(chain.cx[k], chain.cz[k], c, s)
    return v


@wp.func
def sum_moments(blocks: wp.ref[Blocks], chain: wp.ref[Chain], velocity: Triples):
    """Sums of momenta above the interfaces (x, z) [N s], and moments of all blocks [N m s].

    The moments are those that the velocities of a chain have in its equations: its matrix times the
    angular velocities.
    """
    fx = Values()
    fz = Values()
    moments = Values()
    x = real(0.0)
    z = real(0.0)
    for step in range(BLOCKS):
        k = wp.static(BLOCKS - 1 - step)
        gx = blocks.mass[k] * velocity[3 * k]
        gz = blocks.mass[k] * velocity[wp.static(3 * k + 1)]
        own = blocks.inertia[k] * velocity[wp.static(3 * k + 2)]
        own = fused(chain.bx[k], gz, fused_less(chain.bz[k], gx, own))
        # The momenta from above are known last.
        moments[k] = fused(chain.cz[k], x, fused_less(chain.cx[k], z, own))
        x = x + gx
        z = z + gz
        fx[k] = x
        fz[k] = z
    return fx, fz, moments


@wp.func
def hold_together(blocks: wp.ref[Blocks], chain: wp.ref[Chain], velocity: Triples) -> Triples:
    """Velocities of a chain after impulses at its contacts, from any without them."""
    _x, _z, moments = sum_moments(blocks, chain, velocity)
    return velocities_of(chain, accelerate(chain, moments))
