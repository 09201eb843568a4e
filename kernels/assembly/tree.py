"""A leap to the solution of all contacts that hold, where joints between free blocks form a tree.

Such are columns, arches and frames. Sweeps pass forces on from joint to joint. A column of n drums
bends like a beam, and conjugate gradients take some n^2 sweeps. A leap solves for all contacts at
once that bear (N > 0), and for T of those that stick (|T| < friction N). With G their rows of u_n
and u_t, M the masses of the blocks, and W the masses that the contacts feel, the velocities change
by dv, and the impulses by dF:

    (M + G' r W G) dv = -G' r W (u + b),      dF = -r W (u + b + G dv),      M dv = G' dF

It is a step of the method of multipliers with the weight r (Hestenes 1969, Multiplier and gradient
methods, *Journal of Optimization Theory and Applications* 4). It leaves of u + b one part in r
times the least eigenvalue of W G M^-1 G'. The matrix has a block of 3 x 3 for every block and for
every pair that touches. In a tree, elimination from the leaves to the roots fills nothing in.

The way to the solution ends early, at the part `share` of it, where the first contact would open or
the first joint would slide. The next sweep lets go of that one. Contacts that slide keep T at their
bound.
"""

import warp as wp

from warprock.kernels.assembly.joint import (
    Contact,
    Impulse,
    opening_speed,
    sliding_speed,
)
from warprock.kernels.assembly.solve import Leap, Way, least_normal, most_drag
from warprock.kernels.shape.interface import Mass, Velocity

WEIGHT = by_precision(1.0e7, 1.0e3)
"""r: the larger, the less a leap leaves, and the more round-off: r times that of a velocity."""


INSIDE = by_precision(1.0 - 1.0e-9, 1.0 - 1.0e-5)
"""Part of the bound of T up to which a contact sticks: round-off of one that slides."""


@wp.struct
class Node:
    """The equation of a block, K dv + C dv of its parent = y, and then its solution.

    Attributes:
        xx, xz, zz, xo, zo, oo: K [kg, kg m, kg m^2].
        cxx, cxz, cxo, czx, czz, czo, cox, coz, coo: C, by rows; once it is eliminated, K^-1 C.
        x, z, o: y [kg m/s, kg m^2/s]; once it is eliminated, K^-1 y, and then dv [m/s, rad/s].
    """

    xx: real
    xz: real
    zz: real
    xo: real
    zo: real
    oo: real
    cxx: real
    cxz: real
    cxo: real
    czx: real
    czz: real
    czo: real
    cox: real
    coz: real
    coo: real
    x: real
    z: real
    o: real


@wp.struct
class Line:
    """A row of G: the direction at the one block, against it at the other, and the two arms [m]."""

    x: real
    z: real
    own: real
    other: real


@wp.func
def start_node(mass: Mass) -> Node:
    """The equation of a block without contacts."""
    one, zero = real(1.0), real(0.0)
    m = one / wp.where(mass.m > zero, mass.m, one)
    j = one / wp.where(mass.j > zero, mass.j, one)
    return Node(
        m, zero, m, zero, zero, j, zero, zero, zero, zero, zero, zero, zero, zero, zero,
        zero, zero, zero,
    )  # fmt: skip


@wp.func
def add_line(
    line: Line, weight: real, link: real, gain: real, own: wp.ref[Node], parent: wp.ref[Node]
):  # fmt: skip
    """Adds a row of G to the equations of two blocks.

    Args:
        line: The row, of the child first.
        weight: r W where the contact holds, else 0 [kg].
        link: The same; 0 where the parent is fixed.
        gain: - r W (u + b) [kg m/s].
        own, parent: The equations of the child and of its parent.
    """
    x, z, o, p = line.x, line.z, line.own, line.other
    wx, wz, wo = weight * x, weight * z, weight * o
    own.xx = fused(wx, x, own.xx)
    own.xz = fused(wx, z, own.xz)
    own.zz = fused(wz, z, own.zz)
    own.xo = fused(wx, o, own.xo)
    own.zo = fused(wz, o, own.zo)
    own.oo = fused(wo, o, own.oo)
    own.x = fused(gain, x, own.x)
    own.z = fused(gain, z, own.z)
    own.o = fused(gain, o, own.o)
    lx, lz, lo, lp = link * x, link * z, link * o, link * p
    own.cxx = fused_less(lx, x, own.cxx)
    own.cxz = fused_less(lx, z, own.cxz)
    own.cxo = fused(lx, p, own.cxo)
    own.czx = fused_less(lz, x, own.czx)
    own.czz = fused_less(lz, z, own.czz)
    own.czo = fused(lz, p, own.czo)
    own.cox = fused_less(lo, x, own.cox)
    own.coz = fused_less(lo, z, own.coz)
    own.coo = fused(lo, p, own.coo)
    parent.xx = fused(lx, x, parent.xx)
    parent.xz = fused(lx, z, parent.xz)
    parent.zz = fused(lz, z, parent.zz)
    parent.xo = fused_less(lx, p, parent.xo)
    parent.zo = fused_less(lz, p, parent.zo)
    parent.oo = fused(lp, p, parent.oo)
    parent.x = fused_less(gain, x, parent.x)
    parent.z = fused_less(gain, z, parent.z)
    parent.o = fused(gain, p, parent.o)


@wp.func
def bears(impulse: Impulse) -> bool:
    """Whether a contact bears."""
    return impulse.n > least_normal(impulse)


@wp.func
def sticks(at: Contact, impulse: Impulse) -> bool:
    """Whether a contact bears and does not slide."""
    bound = INSIDE * most_drag(at.friction, impulse.n, impulse)
    return bears(impulse) and size(impulse.t) < bound


@wp.func
def held_normal(at: Contact, impulse: Impulse) -> real:
    """Weight r W of a contact along its normal [kg]; 0 where it does not bear."""
    return wp.where(bears(impulse), WEIGHT * at.wn, real(0.0))


@wp.func
def held_shear(at: Contact, impulse: Impulse) -> real:
    """Weight r W of a contact along its tangent [kg]; 0 where it does not stick."""
    return wp.where(sticks(at, impulse), WEIGHT * at.wt, real(0.0))


@wp.func
def add_contact(
    at: Contact, impulse: Impulse, place: int, va: Velocity, vb: Velocity, own: wp.ref[Node],
    parent: wp.ref[Node],
):  # fmt: skip
    """Adds a contact to the equations of its blocks.

    Args:
        at: The contact.
        impulse: Its impulses.
        place: Of the child: 0 if it is the first block, 1 if the second; 2 more where the other one
            is fixed.
        va, vb: Velocities of the blocks.
        own, parent: The equations of the child and of the other block.
    """
    n, t = held_normal(at, impulse), held_shear(at, impulse)
    first = place % 2 == 0
    along = wp.where(first, real(1.0), real(-1.0))
    links = wp.where(place < 2, real(1.0), real(0.0))
    nx, nz = along * at.nx, along * at.nz
    normal = Line(nx, nz, wp.where(first, at.aa, at.ab), wp.where(first, at.ab, at.aa))
    add_line(normal, n, links * n, -n * (opening_speed(at, va, vb) + at.b), own, parent)
    shear = Line(-nz, nx, wp.where(first, at.ba, at.bb), wp.where(first, at.bb, at.ba))
    add_line(shear, t, links * t, -t * sliding_speed(at, va, vb), own, parent)


@wp.struct
class Factor:
    """L and the reciprocals of D, of K = L D L'."""

    zx: real
    ox: real
    oz: real
    x: real
    z: real
    o: real


@wp.func
def factor_of(node: Node) -> Factor:
    """Of the matrix K of an equation."""
    x = real(1.0) / node.xx
    zx, ox = node.xz * x, node.xo * x
    z = real(1.0) / fused_less(zx, node.xz, node.zz)
    left = fused_less(zx, node.xo, node.zo)
    oz = left * z
    o = real(1.0) / fused_less(oz, left, fused_less(ox, node.xo, node.oo))
    return Factor(zx, ox, oz, x, z, o)


@wp.func
def solve_column(by: Factor, x: real, z: real, o: real):
    """K^-1 of a column."""
    z1 = fused_less(by.zx, x, z)
    o1 = by.o * fused_less(by.oz, z1, fused_less(by.ox, x, o))
    z2 = fused_less(by.oz, o1, by.z * z1)
    x2 = fused_less(by.ox, o1, fused_less(by.zx, z2, by.x * x))
    return x2, z2, o1


@wp.func
def product_of(ax: real, az: real, ao: real, bx: real, bz: real, bo: real) -> real:
    """Scalar product of two columns."""
    return fused(ao, bo, dot(ax, az, bx, bz))


@wp.func
def eliminate(own: wp.ref[Node], parent: wp.ref[Node]):
    """Takes a block out of the equation of its parent."""
    by = factor_of(own)
    x, z, o = solve_column(by, own.x, own.z, own.o)
    ax, az, ao = solve_column(by, own.cxx, own.czx, own.cox)
    bx, bz, bo = solve_column(by, own.cxz, own.czz, own.coz)
    cx, cz, co = solve_column(by, own.cxo, own.czo, own.coo)
    parent.x = parent.x - product_of(own.cxx, own.czx, own.cox, x, z, o)
    parent.z = parent.z - product_of(own.cxz, own.czz, own.coz, x, z, o)
    parent.o = parent.o - product_of(own.cxo, own.czo, own.coo, x, z, o)
    parent.xx = parent.xx - product_of(own.cxx, own.czx, own.cox, ax, az, ao)
    parent.xz = parent.xz - product_of(own.cxx, own.czx, own.cox, bx, bz, bo)
    parent.zz = parent.zz - product_of(own.cxz, own.czz, own.coz, bx, bz, bo)
    parent.xo = parent.xo - product_of(own.cxx, own.czx, own.cox, cx, cz, co)
    parent.zo = parent.zo - product_of(own.cxz, own.czz, own.coz, cx, cz, co)
    parent.oo = parent.oo - product_of(own.cxo, own.czo, own.coo, cx, cz, co)
    own.x = x
    own.z = z
    own.o = o
    own.cxx = ax
    own.czx = az
    own.cox = ao
    own.cxz = bx
    own.czz = bz
    own.coz = bo
    own.cxo = cx
    own.czo = cz
    own.coo = co


@wp.func
def substitute(parent: Node, own: wp.ref[Node]):
    """The solution of a block from that of its parent."""
    own.x = own.x - product_of(own.cxx, own.cxz, own.cxo, parent.x, parent.z, parent.o)
    own.z = own.z - product_of(own.czx, own.czz, own.czo, parent.x, parent.z, parent.o)
    own.o = own.o - product_of(own.cox, own.coz, own.coo, parent.x, parent.z, parent.o)


@wp.func
def change_of(node: Node, mass: Mass) -> Velocity:
    """Change dv of the velocity of a block: nothing where it is fixed."""
    free = mass.m > real(0.0)
    zero = real(0.0)
    return Velocity(
        wp.where(free, node.x, zero), wp.where(free, node.z, zero), wp.where(free, node.o, zero)
    )


@wp.func
def share_within(room: real, rate: real, share: real) -> real:
    """The part of a way that leaves room for a change by a rate, at most `share`."""
    return wp.where(rate * share > room, room / rate, share)


@wp.func
def aim(
    at: Contact, impulse: Impulse, va: Velocity, vb: Velocity, da: Velocity, db: Velocity,
    way: wp.ref[Way],
):  # fmt: skip
    """The change of the impulses of a contact.

    Args:
        at: The contact.
        impulse: Its impulses.
        va, vb: Velocities of its blocks.
        da, db: Their changes dv.
        way: Takes the change.
    """
    n, t = held_normal(at, impulse), held_shear(at, impulse)
    way.dn = -n * ((opening_speed(at, va, vb) + at.b) + opening_speed(at, da, db))
    way.dt = -t * (sliding_speed(at, va, vb) + sliding_speed(at, da, db))
    way.pn = real(0.0)
    way.pt = real(0.0)


@wp.func
def limit_share(
    at: Contact, impulse: Impulse, way: Way, end: Contact, other: Impulse, along: Way,
    leap: wp.ref[Leap],
):  # fmt: skip
    """Shortens the way of a lane to what keeps the law of a joint.

    Args:
        at, impulse, way: One end of it, its impulses and their change.
        end, other, along: The same of the other end.
        leap: The leap of the lane, with `share`.
    """
    part = share_within(impulse.n - least_normal(impulse), -way.dn, leap.share)
    part = share_within(other.n - least_normal(other), -along.dn, part)
    stuck = sticks(at, impulse) or sticks(end, other)
    bound = most_drag(at.friction, impulse.n, impulse) + most_drag(end.friction, other.n, other)
    grows = fused(at.friction, way.dn, end.friction * along.dn)
    t, dt = impulse.t + other.t, way.dt + along.dt
    kept = share_within(bound + t, -dt - grows, share_within(bound - t, dt - grows, part))
    leap.share = wp.where(stuck, kept, part)


@wp.func
def clamp(t: real, most: real) -> real:
    """The nearest to t within -most and most."""
    return smaller(larger(t, -most), most)


@wp.func
def leap_to(
    at: Contact, impulse: Impulse, way: Way, end: Contact, other: Impulse, along: Way, share: real
):  # fmt: skip
    """The change of the impulses of a joint by a leap.

    T of its two ends acts along one line: what the one cannot bear goes over to the other.

    Args:
        at, impulse, way: One end of it, its impulses and their change.
        end, other, along: The same of the other end.
        share: The part of the change.

    Returns:
        Changes of N and T of the one end, and of the other one [N s].
    """
    n = larger(fused(share, way.dn, impulse.n), least_normal(impulse))
    m = larger(fused(share, along.dn, other.n), least_normal(other))
    near = most_drag(at.friction, n, impulse)
    far = most_drag(end.friction, m, other)
    stuck = sticks(at, impulse) or sticks(end, other)
    t, u = fused(share, way.dt, impulse.t), fused(share, along.dt, other.t)
    t = wp.where(stuck, t, wp.where(impulse.t < real(0.0), -near, near))
    u = wp.where(stuck, u, wp.where(other.t < real(0.0), -far, far))
    both = t + u
    u = clamp(both - clamp(t, near), far)
    t = clamp(both - u, near)
    return n - impulse.n, t - impulse.t, m - other.n, u - other.t
