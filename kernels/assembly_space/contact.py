"""Contacts of an assembly in space, and Coulomb's law there.

A contact is a point P of a first block A on a second one B, with the normal n from B into A and two
tangents t and s = n x t. With r_A and r_B the levers of P from the two centres of mass,

    w = v_A + o_A x r_A - v_B - o_B x r_B,      u_n = n . w,  u_t = t . w,  u_s = s . w

The law of a step of length h, with the gap g at its start and impulses N and (T, S), is that of the
plane (assembly/joint.py) with a circle in place of an interval:

    0 <= N  perpendicular to  u_n + b >= 0,        b = max(g, 0) / h
    |(T, S)| <= friction N,  and (T, S) = -friction N (u_t, u_s) / |(u_t, u_s)| where it slides

A sweep takes the contacts one after the other. It sets N as in the plane, and then (T, S) to what
stops the contact, -W^-1 (u_t, u_s) with W the 2 x 2 matrix of what tangential impulses do. Where
that is outside the circle, it takes the nearest to (T, S) - (u_t, u_s) / k within the circle, k the
larger eigenvalue of W. Only the latter has its rest where friction acts against the slip.

In a sweep the motion of a block is its weighted velocity: times the root of mass or inertia,

    y = (v sqrt(m), D^-1/2 R^T o),      R the attitude, D the inverse moments of inertia

so that an impulse along n adds to y the same numbers that u_n reads from it, n sqrt(1 / m) and
D^1/2 R^T (r x n).
"""

import warp as wp

from warprock.kernels.algebra.vectors import Matrix, Vector


@wp.struct
class Heft:
    """What turns velocities of a block into its weighted ones; zero of what is fixed.

    Attributes:
        root: Root of the inverse mass [kg^-1/2].
        turns: D^1/2 R^T [kg^-1/2 m^-1].
    """

    root: real
    turns: Matrix


@wp.struct
class Move:
    """Velocity of the centre of mass [m/s] and angular velocity [rad/s]."""

    v: Vector
    o: Vector


@wp.struct
class Weighted:
    """Weighted velocities of a block [J^1/2]: of its centre, and of its turn about its own axes."""

    x: real
    y: real
    z: real
    ox: real
    oy: real
    oz: real


@wp.struct
class Contact:
    """A contact in a step; symbols as at the head of the file.

    Attributes:
        a, b: The blocks A and B.
        n, t, s: Normal and tangents.
        ra, rb: Levers [m].
        closing: Velocity b [m/s].
        friction: Coulomb friction coefficient; NEVER of a bond, which holds whatever it bears.
    """

    a: int
    b: int
    n: Vector
    t: Vector
    s: Vector
    ra: Vector
    rb: Vector
    closing: real
    friction: real


@wp.struct
class Row:
    """A contact as a sweep takes it, by plain numbers: a loop over those becomes vector code.

    Attributes:
        nx to sz: n, t and s.
        la, lb: Roots of the inverse masses of A and, negative, of B [kg^-1/2].
        nax to saz: What impulses along n, t and s do to the weighted velocities of A by its turn
            [kg^-1/2].
        nbx to sbz: Likewise, of B.
        kn, wn: What N does to u_n [1/kg], and its reciprocal.
        kt, wk: The larger eigenvalue k [1/kg], and its reciprocal.
        knt, kns: What N does to u_t and to u_s [1/kg].
        wtt, wts, wss: W^-1 [kg].
        closing, friction: As in `Contact`.
    """

    nx: real
    ny: real
    nz: real
    tx: real
    ty: real
    tz: real
    sx: real
    sy: real
    sz: real
    la: real
    lb: real
    nax: real
    nay: real
    naz: real
    tax: real
    tay: real
    taz: real
    sax: real
    say: real
    saz: real
    nbx: real
    nby: real
    nbz: real
    tbx: real
    tby: real
    tbz: real
    sbx: real
    sby: real
    sbz: real
    kn: real
    wn: real
    kt: real
    wk: real
    knt: real
    kns: real
    wtt: real
    wts: real
    wss: real
    closing: real
    friction: real


@wp.struct
class Impulse:
    """Impulses of a contact [N s], and what they changed by since the last sweep, p (pace.py)."""

    n: real
    t: real
    s: real
    pn: real
    pt: real
    ps: real


@wp.struct
class Rest:
    """What a sweep leaves, see `Solve`.

    Attributes:
        square: |d|^2 [J].
        worst: Square of the largest change of a velocity [m^2/s^2]: a root a contact would take as
            long as half of the rest.
    """

    square: real
    worst: real


@wp.func
def inner(a: Vector, b: Vector) -> real:
    """The scalar product of two vectors."""
    return fused(a[2], b[2], fused(a[1], b[1], a[0] * b[0]))


@wp.func
def cross(a: Vector, b: Vector) -> Vector:
    """The vector product of two vectors."""
    return Vector(
        fused_less(a[2], b[1], a[1] * b[2]),
        fused_less(a[0], b[2], a[2] * b[0]),
        fused_less(a[1], b[0], a[0] * b[1]),
    )


@wp.func
def add_part(part: real, a: Vector, b: Vector) -> Vector:
    """Gives part a + b."""
    return Vector(fused(part, a[0], b[0]), fused(part, a[1], b[1]), fused(part, a[2], b[2]))


@wp.func
def times(m: Matrix, a: Vector) -> Vector:
    """A matrix times a vector."""
    return Vector(
        fused(m[0, 2], a[2], fused(m[0, 1], a[1], m[0, 0] * a[0])),
        fused(m[1, 2], a[2], fused(m[1, 1], a[1], m[1, 0] * a[0])),
        fused(m[2, 2], a[2], fused(m[2, 1], a[1], m[2, 0] * a[0])),
    )


@wp.func
def tangent_of(n: Vector) -> Vector:
    """A unit vector across a normal: along x where it is steep, else level."""
    zero = real(0.0)
    steep = n[2] * n[2] > HALF
    t = wp.where(steep, Vector(n[2], zero, -n[0]), Vector(-n[1], n[0], zero))
    return (real(1.0) / wp.sqrt(inner(t, t))) * t


@wp.func
def weighted_of(m: Heft, v: Move) -> Weighted:
    """The weighted velocities of a block; zero of what is fixed."""
    over = wp.where(m.root > real(0.0), real(1.0) / larger(m.root, TINY), real(0.0))
    # Rows of `turns` have the lengths of the roots in D.
    e = times(m.turns, v.o)
    return Weighted(
        over * v.v[0], over * v.v[1], over * v.v[2],
        e[0] / larger(square_of_row(m.turns, 0), TINY),
        e[1] / larger(square_of_row(m.turns, 1), TINY),
        e[2] / larger(square_of_row(m.turns, 2), TINY),
    )  # fmt: skip


@wp.func
def square_of_row(m: Matrix, i: int) -> real:
    """Square of the length of a row of a matrix."""
    return fused(m[i, 2], m[i, 2], fused(m[i, 1], m[i, 1], m[i, 0] * m[i, 0]))


@wp.func
def move_of(m: Heft, y: Weighted) -> Move:
    """The velocities of a block by its weighted ones."""
    o = wp.transpose(m.turns) * Vector(y.ox, y.oy, y.oz)
    return Move(Vector(m.root * y.x, m.root * y.y, m.root * y.z), o)


@wp.func
def relative(at: Contact, va: Move, vb: Move) -> Vector:
    """Velocity w of a contact [m/s]."""
    return (va.v - vb.v) + (cross(va.o, at.ra) - cross(vb.o, at.rb))


@wp.func
def row_of(at: Contact, ma: Heft, mb: Heft) -> Row:
    """A contact as a sweep takes it."""
    n, t, s = at.n, at.t, at.s
    an, at_, as_ = (
        times(ma.turns, cross(at.ra, n)),
        times(ma.turns, cross(at.ra, t)),
        times(ma.turns, cross(at.ra, s)),
    )
    bn, bt, bs = (
        -times(mb.turns, cross(at.rb, n)),
        -times(mb.turns, cross(at.rb, t)),
        -times(mb.turns, cross(at.rb, s)),
    )
    light = fused(ma.root, ma.root, mb.root * mb.root)
    one = real(1.0)
    kn = light + (inner(an, an) + inner(bn, bn))
    tt = light + (inner(at_, at_) + inner(bt, bt))
    ss = light + (inner(as_, as_) + inner(bs, bs))
    ts = inner(at_, as_) + inner(bt, bs)
    apart = HALF * (tt - ss)
    kt = HALF * (tt + ss) + wp.sqrt(fused(apart, apart, ts * ts))
    over = one / fused_less(ts, ts, tt * ss)
    return Row(
        n[0], n[1], n[2], t[0], t[1], t[2], s[0], s[1], s[2], ma.root, -mb.root,
        an[0], an[1], an[2], at_[0], at_[1], at_[2], as_[0], as_[1], as_[2],
        bn[0], bn[1], bn[2], bt[0], bt[1], bt[2], bs[0], bs[1], bs[2],
        kn, one / kn, kt, one / kt, inner(an, at_) + inner(bn, bt),
        inner(an, as_) + inner(bn, bs), over * ss, -over * ts, over * tt, at.closing, at.friction,
    )  # fmt: skip


@wp.func
def sum_of(a: real, x: real, b: real, y: real, c: real, z: real) -> real:
    """The sum of three products."""
    return fused(c, z, fused(b, y, a * x))


@wp.func
def push(at: Row, n: real, t: real, s: real, va: wp.ref[Weighted], vb: wp.ref[Weighted]):
    """Adds impulses on the first block, and against them on the second one, to their velocities."""
    px = sum_of(n, at.nx, t, at.tx, s, at.sx)
    py = sum_of(n, at.ny, t, at.ty, s, at.sy)
    pz = sum_of(n, at.nz, t, at.tz, s, at.sz)
    va.x = fused(at.la, px, va.x)
    va.y = fused(at.la, py, va.y)
    va.z = fused(at.la, pz, va.z)
    vb.x = fused(at.lb, px, vb.x)
    vb.y = fused(at.lb, py, vb.y)
    vb.z = fused(at.lb, pz, vb.z)
    va.ox = va.ox + sum_of(n, at.nax, t, at.tax, s, at.sax)
    va.oy = va.oy + sum_of(n, at.nay, t, at.tay, s, at.say)
    va.oz = va.oz + sum_of(n, at.naz, t, at.taz, s, at.saz)
    vb.ox = vb.ox + sum_of(n, at.nbx, t, at.tbx, s, at.sbx)
    vb.oy = vb.oy + sum_of(n, at.nby, t, at.tby, s, at.sby)
    vb.oz = vb.oz + sum_of(n, at.nbz, t, at.tbz, s, at.sbz)


if BONDS:

    @wp.func
    def least_normal(friction: real) -> real:
        """The least N of a contact [N s]: a bond holds."""
        return wp.where(friction >= NEVER, -NEVER, real(0.0))

    @wp.func
    def most_drag(friction: real, n: real) -> real:
        """The most |(T, S)| of a contact [N s]."""
        return wp.where(friction >= NEVER, NEVER, friction * n)

else:

    @wp.func
    def least_normal(friction: real) -> real:
        """The least N of a contact [N s]."""
        return real(0.0)

    @wp.func
    def most_drag(friction: real, n: real) -> real:
        """The most |(T, S)| of a contact [N s]."""
        return friction * n


@wp.func
def sweep_contact(
    rest: wp.ref[Rest], beta: real, at: Row, held: wp.ref[Impulse],
    va: wp.ref[Weighted], vb: wp.ref[Weighted],
):  # fmt: skip
    """Takes one contact in a sweep; the velocities have gone on along p already.

    Args:
        rest: What the sweep leaves.
        beta: Part of the last change by which impulses go on.
        at: The contact; one of zeros changes nothing.
        held: Its impulses.
        va, vb: Weighted velocities of its blocks.
    """
    n0 = fused(beta, held.pn, held.n)
    t0, s0 = fused(beta, held.pt, held.t), fused(beta, held.ps, held.s)
    x, y, z = (
        fused(at.la, va.x, at.lb * vb.x),
        fused(at.la, va.y, at.lb * vb.y),
        fused(at.la, va.z, at.lb * vb.z),
    )
    un = sum_of(at.nx, x, at.ny, y, at.nz, z) + (
        sum_of(at.nax, va.ox, at.nay, va.oy, at.naz, va.oz)
        + sum_of(at.nbx, vb.ox, at.nby, vb.oy, at.nbz, vb.oz)
    )
    ut = sum_of(at.tx, x, at.ty, y, at.tz, z) + (
        sum_of(at.tax, va.ox, at.tay, va.oy, at.taz, va.oz)
        + sum_of(at.tbx, vb.ox, at.tby, vb.oy, at.tbz, vb.oz)
    )
    us = sum_of(at.sx, x, at.sy, y, at.sz, z) + (
        sum_of(at.sax, va.ox, at.say, va.oy, at.saz, va.oz)
        + sum_of(at.sbx, vb.ox, at.sby, vb.oy, at.sbz, vb.oz)
    )
    n = larger(fused_less(at.wn, un + at.closing, n0), least_normal(at.friction))
    dn = n - n0
    ut = fused(at.knt, dn, ut)
    us = fused(at.kns, dn, us)
    bound = most_drag(at.friction, n)
    t1 = t0 - fused(at.wts, us, at.wtt * ut)
    s1 = s0 - fused(at.wss, us, at.wts * ut)
    t2, s2 = fused_less(at.wk, ut, t0), fused_less(at.wk, us, s0)
    length = wp.sqrt(fused(s2, s2, t2 * t2))
    kept = smaller(bound / larger(length, TINY), real(1.0))
    sticks = fused(s1, s1, t1 * t1) <= bound * bound
    dt, ds = wp.where(sticks, t1, kept * t2) - t0, wp.where(sticks, s1, kept * s2) - s0
    held.n = n
    held.t = t0 + dt
    held.s = s0 + ds
    held.pn = fused(beta, held.pn, dn)
    held.pt = fused(beta, held.pt, dt)
    held.ps = fused(beta, held.ps, ds)
    square = fused(ds, ds, dt * dt)
    un, ut = at.kn * dn, at.kt * square
    rest.square = rest.square + fused(un, dn, ut)
    rest.worst = larger(larger(un * un, at.kt * ut), rest.worst)
    push(at, dn, dt, ds, va, vb)
