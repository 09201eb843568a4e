"""Joints of an assembly: where two blocks touch, and Coulomb's law there.

A joint is an edge of a first block A that lies on an edge of a second one B. Both edges run along
the tangent t, and the normal n = (-t_z, t_x) points from B into A. At either end of what the edges
share is one contact: the corner of one block on the edge of the other. With P the corner, r_A and
r_B its arms from the two centres of mass, and v(P) the velocities of the blocks there,

    u_n = n . (v_A(P) - v_B(P)) = n . (v_A - v_B) + a_A omega_A + a_B omega_B
    u_t = t'. (v_A(P) - v_B(P)) = t'. (v_A - v_B) + b_A omega_A + b_B omega_B,   t' = (-n_z, n_x)

The law of a step of length h, with the gap g at its start and impulses N and T (Signorini and
Coulomb; impacts are plastic; Moreau 1988, Unilateral contact and dry friction in finite freedom
dynamics, in *Nonsmooth Mechanics and Applications*):

    0 <= N  perpendicular to  u_n + b >= 0,        b = max(g, 0) / h
    |T| <= friction N,  and T = -friction N sign(u_t) where u_t is not zero

So a gap may close within the step and no more. Nothing lifts out corners that have sunk in, by
what steps leave of their velocities, some micrometres a second at most: blocks that wedge one
another in cannot be lifted out, and impulses that tried would grow from step to step without bound.
Angles are positive counterclockwise here.
"""

import warp as wp

from warprock.kernels.shape.interface import Mass, Pose, Velocity

DEEP = real(0.1) if SPRINGS else real(2.0e-3)
"""Depth below an edge, over its length, down to which a corner touches it anywhere. Steps leave
less, springs more. A deeper corner touches only if it is farther from both ends than deep.
Otherwise it came from the side, and meeting.py has what it meets there."""


@wp.struct
class Edges:
    """A joint as a launch gives it, each edge in the axes of its block, from its centre of mass.

    Attributes:
        a_x, a_z: Where the edge of the first block begins [m].
        a_along_x, a_along_z: From there to its end [m].
        b_x, b_z, b_along_x, b_along_z: The same of the second block.
        friction: Coulomb friction coefficient.
        area: On springs, area that either end stands for [m^2].
        first, second: Stretch of the shear springs at the two ends at the start [m].
        cohesion, tension: Of a bonded joint, its strength in shear without load and in tension
            [N]; zero of a dry one.
    """

    a_x: real
    a_z: real
    a_along_x: real
    a_along_z: real
    b_x: real
    b_z: real
    b_along_x: real
    b_along_z: real
    friction: real
    if SPRINGS:
        area: real
        first: real
        second: real
    if BONDS:
        cohesion: real
        tension: real


@wp.struct
class Contact:
    """A contact in a step; symbols as at the head of the file.

    Attributes:
        nx, nz: Normal n.
        aa, ab: Arms of N, a_A and a_B [m].
        ba, bb: Arms of T, b_A and b_B [m].
        kn, kt: What an impulse along n, along t' does to u_n, to u_t [1/kg].
        wn, wt: Their reciprocals [kg]; zero of a corner that lands, in the solve without it.
        b: Velocity b [m/s].
        friction: Coulomb friction coefficient.
    """

    nx: real
    nz: real
    aa: real
    ab: real
    ba: real
    bb: real
    kn: real
    kt: real
    wn: real
    wt: real
    b: real
    friction: real


@wp.struct
class Impulse:
    """Impulses N and T of a contact [N s].

    Attributes:
        n, t: N and T.
        hold: What a bond may hold in either direction [N s]: no end while it lasts, see bond.py.
    """

    n: real
    t: real
    if BONDS:
        hold: real


@wp.func
def contact_at(
    nx: real, nz: real, x: real, z: real, dx: real, dz: real, ma: Mass, mb: Mass
) -> Contact:  # fmt: skip
    """A contact without its velocity b and its friction, of a normal.

    Args:
        nx, nz: The normal.
        x, z: The corner, from the centre of the first block [m].
        dx, dz: From the centre of the second block to that of the first [m].
        ma, mb: Masses of the blocks.
    """
    one, zero = real(1.0), real(0.0)
    px, pz = x + dx, z + dz
    aa, ba = wedge(x, z, nx, nz), dot(x, z, nx, nz)
    ab, bb = -wedge(px, pz, nx, nz), -dot(px, pz, nx, nz)
    kn = fused(mb.j, ab * ab, fused(ma.j, aa * aa, ma.m + mb.m))
    kt = fused(mb.j, bb * bb, fused(ma.j, ba * ba, ma.m + mb.m))
    return Contact(nx, nz, aa, ab, ba, bb, kn, kt, one / kn, one / kt, zero, zero)


@wp.func
def find_contact(edges: Edges, end: real, rate: real, a: Pose, b: Pose, ma: Mass, mb: Mass):
    """The contact at an end of a joint, where the blocks are at the start of a step.

    Args:
        edges: The joint.
        end: 0 for the end at which the tangent begins, 1 for the other.
        rate: 1 / time step [1/s].
        a, b: Where the blocks are.
        ma, mb: Their masses.

    Returns:
        The contact, and its gap [m]; NEVER where the corner has left the other edge, came below it
        from the side, or the blocks have turned by a right angle against each other.
    """
    zero, one = real(0.0), real(1.0)
    px, pz = fused(end, edges.a_along_x, edges.a_x), fused(end, edges.a_along_z, edges.a_z)
    qx, qz = fused(end, edges.b_along_x, edges.b_x), fused(end, edges.b_along_z, edges.b_z)
    # The two corners at this end from their centres of mass, and the edges, as the blocks are now.
    pax, paz = wedge(px, pz, a.s, a.c), dot(px, pz, a.s, a.c)
    qbx, qbz = wedge(qx, qz, b.s, b.c), dot(qx, qz, b.s, b.c)
    tax = wedge(edges.a_along_x, edges.a_along_z, a.s, a.c)
    taz = dot(edges.a_along_x, edges.a_along_z, a.s, a.c)
    tbx = wedge(edges.b_along_x, edges.b_along_z, b.s, b.c)
    tbz = dot(edges.b_along_x, edges.b_along_z, b.s, b.c)
    dx, dz = a.x - b.x, a.z - b.z
    sx, sz = dx + pax - qbx, dz + paz - qbz
    # The inner one of the two corners lies on the edge of the other block.
    inwards = one - real(2.0) * end
    on_b, on_a = inwards * dot(sx, sz, tbx, tbz), -inwards * dot(sx, sz, tax, taz)
    of_a = on_b >= zero
    square = wp.where(of_a, dot(tbx, tbz, tbx, tbz), dot(tax, taz, tax, taz))
    inside = wp.where(of_a, on_b, on_a)
    over = one / wp.sqrt(square)
    nx, nz = -over * wp.where(of_a, tbz, taz), over * wp.where(of_a, tbx, tax)
    rax, raz = wp.where(of_a, pax, qbx - dx), wp.where(of_a, paz, qbz - dz)
    at = contact_at(nx, nz, rax, raz, dx, dz, ma, mb)
    gap = dot(sx, sz, nx, nz)
    # Where the corner is deep below the edge, it has come from the side, not through the edge.
    inset = smaller(inside, square - inside)
    deep = gap < zero and gap * gap > DEEP * DEEP * square
    faces = dot(tax, taz, tbx, tbz) > zero
    on_edge = inside < square and inside > -DEEP * square and faces
    there = on_edge and not (deep and fused(gap * gap, square, -inset * size(inset)) > zero)
    gap = wp.where(there, gap, NEVER)
    at.b = rate * larger(gap, zero)
    at.friction = edges.friction
    return at, gap


@wp.func
def push(
    at: Contact, n: real, t: real, ma: Mass, mb: Mass, va: wp.ref[Velocity], vb: wp.ref[Velocity]
):
    """Adds impulses N and T of a contact to the velocities of its two blocks."""
    fx, fz = wedge(at.nx, at.nz, t, n), dot(at.nx, at.nz, t, n)
    va.x = fused(ma.m, fx, va.x)
    va.z = fused(ma.m, fz, va.z)
    va.omega = fused(ma.j, dot(at.aa, at.ba, n, t), va.omega)
    vb.x = fused_less(mb.m, fx, vb.x)
    vb.z = fused_less(mb.m, fz, vb.z)
    vb.omega = fused(mb.j, dot(at.ab, at.bb, n, t), vb.omega)


@wp.func
def opening_speed(at: Contact, va: Velocity, vb: Velocity) -> real:
    """Velocity u_n with which a contact opens [m/s]."""
    return dot(at.aa, at.ab, va.omega, vb.omega) + dot(at.nx, at.nz, va.x - vb.x, va.z - vb.z)


@wp.func
def sliding_speed(at: Contact, va: Velocity, vb: Velocity) -> real:
    """Velocity u_t with which a contact slides [m/s]."""
    return dot(at.ba, at.bb, va.omega, vb.omega) + wedge(at.nx, at.nz, va.x - vb.x, va.z - vb.z)
