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

While a sweep takes the contacts of two blocks, it knows them by their relative motion alone: in the
axes n, t, s, which all of them share, by w at the centre of A and by o_A - o_B. With d the lever of
a contact from there and p its impulses, a sweep adds

    w += L p + C (d x p),   o += C^T p + O (d x p)

and gives the blocks their new y once it has taken all. So it reads a third of the numbers.
"""

import warp as wp

from warprock.kernels.algebra.vectors import Matrix, Vector

STEEP = real(1.0)
"""Friction above which steps are solved with more care, see pace.py."""


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
class Couple:
    """Two blocks that meet, as a sweep takes them: plain numbers, of which loops make vector code.

    Attributes:
        nx to sz: n, t and s.
        la, lb: Roots of the inverse masses of A and, negative, of B [kg^-1/2].
        friction: As in `Contact`.
        anx to asz: What a moment about n, t and s does to the weighted velocities of A
            [kg^-1/2 m^-1].
        bnx to bsz: Likewise, of B.
        lnx to lsz: What impulses along n, t and s at the centre of A do to those of B [kg^-1/2].
        vnn to vss: L, what such impulses do to the relative velocity [1/kg].
        cnn to css: C, what moments do to it [1/(kg m)].
        onn to oss: O, what moments do to the relative angular velocity [1/(kg m^2)].
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
    friction: real
    anx: real
    any: real
    anz: real
    atx: real
    aty: real
    atz: real
    asx: real
    asy: real
    asz: real
    bnx: real
    bny: real
    bnz: real
    btx: real
    bty: real
    btz: real
    bsx: real
    bsy: real
    bsz: real
    lnx: real
    lny: real
    lnz: real
    ltx: real
    lty: real
    ltz: real
    lsx: real
    lsy: real
    lsz: real
    vnn: real
    vnt: real
    vns: real
    vtt: real
    vts: real
    vss: real
    cnn: real
    cnt: real
    cns: real
    ctn: real
    ctt: real
    cts: real
    csn: real
    cst: real
    css: real
    onn: real
    ont: real
    ons: real
    ott: real
    ots: real
    oss: real


@wp.struct
class Row:
    """A contact as a sweep takes it, likewise.

    Attributes:
        dn, dt, ds: Its lever from the centre of A along n, t and s [m].
        kn, wn: What N does to u_n [1/kg], and its reciprocal.
        kt, wk: The larger eigenvalue k [1/kg], and its reciprocal.
        knt, kns: What N does to u_t and to u_s [1/kg].
        wtt, wts, wss: W^-1 [kg].
        closing: As in `Contact`.
    """

    dn: real
    dt: real
    ds: real
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


@wp.struct
class Apart:
    """Motion of A against B along n, t and s: of the centre of A [m/s], and turn [rad/s]."""

    n: real
    t: real
    s: real
    on: real
    ot: real
    os: real


@wp.struct
class Given:
    """What A got from B: impulse [N s] and moment about the centre of A [N m s], along n, t, s."""

    n: real
    t: real
    s: real
    mn: real
    mt: real
    ms: real


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
        worst: Square of the largest change of a velocity by p [m^2/s^2]: a root a contact would
            take as long as half of the rest.
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
def sum_of(a: real, x: real, b: real, y: real, c: real, z: real) -> real:
    """The sum of three products."""
    return fused(c, z, fused(b, y, a * x))


@wp.func
def couple_of(at: Contact, ma: Heft, mb: Heft) -> Couple:
    """Two blocks that meet as a sweep takes them, by one of their contacts."""
    n, t, s = at.n, at.t, at.s
    # From the centre of B to that of A.
    lever = at.rb - at.ra
    an, at_, as_ = times(ma.turns, n), times(ma.turns, t), times(ma.turns, s)
    bn, bt, bs = -times(mb.turns, n), -times(mb.turns, t), -times(mb.turns, s)
    ln, lt, ls = (
        -times(mb.turns, cross(lever, n)),
        -times(mb.turns, cross(lever, t)),
        -times(mb.turns, cross(lever, s)),
    )
    light = fused(ma.root, ma.root, mb.root * mb.root)
    return Couple(
        n[0], n[1], n[2], t[0], t[1], t[2], s[0], s[1], s[2], ma.root, -mb.root, at.friction,
        an[0], an[1], an[2], at_[0], at_[1], at_[2], as_[0], as_[1], as_[2],
        bn[0], bn[1], bn[2], bt[0], bt[1], bt[2], bs[0], bs[1], bs[2],
        ln[0], ln[1], ln[2], lt[0], lt[1], lt[2], ls[0], ls[1], ls[2],
        light + inner(ln, ln), inner(ln, lt), inner(ln, ls),
        light + inner(lt, lt), inner(lt, ls), light + inner(ls, ls),
        inner(ln, bn), inner(ln, bt), inner(ln, bs), inner(lt, bn), inner(lt, bt), inner(lt, bs),
        inner(ls, bn), inner(ls, bt), inner(ls, bs),
        inner(an, an) + inner(bn, bn), inner(an, at_) + inner(bn, bt),
        inner(an, as_) + inner(bn, bs), inner(at_, at_) + inner(bt, bt),
        inner(at_, as_) + inner(bt, bs), inner(as_, as_) + inner(bs, bs),
    )  # fmt: skip


@wp.func
def push(
    own: Couple, at: Row, n: real, t: real, s: real,
    apart: wp.ref[Apart], given: wp.ref[Given],
):  # fmt: skip
    """Adds impulses at a contact to the relative motion of its blocks, and to what A got."""
    mn, mt, ms = (
        fused_less(at.ds, t, at.dt * s),
        fused_less(at.dn, s, at.ds * n),
        fused_less(at.dt, n, at.dn * t),
    )
    given.n = given.n + n
    given.t = given.t + t
    given.s = given.s + s
    given.mn = given.mn + mn
    given.mt = given.mt + mt
    given.ms = given.ms + ms
    apart.n = apart.n + (
        sum_of(own.vnn, n, own.vnt, t, own.vns, s) + sum_of(own.cnn, mn, own.cnt, mt, own.cns, ms)
    )
    apart.t = apart.t + (
        sum_of(own.vnt, n, own.vtt, t, own.vts, s) + sum_of(own.ctn, mn, own.ctt, mt, own.cts, ms)
    )
    apart.s = apart.s + (
        sum_of(own.vns, n, own.vts, t, own.vss, s) + sum_of(own.csn, mn, own.cst, mt, own.css, ms)
    )
    apart.on = apart.on + (
        sum_of(own.cnn, n, own.ctn, t, own.csn, s) + sum_of(own.onn, mn, own.ont, mt, own.ons, ms)
    )
    apart.ot = apart.ot + (
        sum_of(own.cnt, n, own.ctt, t, own.cst, s) + sum_of(own.ont, mn, own.ott, mt, own.ots, ms)
    )
    apart.os = apart.os + (
        sum_of(own.cns, n, own.cts, t, own.css, s) + sum_of(own.ons, mn, own.ots, mt, own.oss, ms)
    )


@wp.func
def slip_at(at: Row, apart: Apart) -> Vector:
    """Velocity of a contact along n, t and s [m/s]."""
    return Vector(
        apart.n + fused_less(apart.os, at.dt, apart.ot * at.ds),
        apart.t + fused_less(apart.on, at.ds, apart.os * at.dn),
        apart.s + fused_less(apart.ot, at.dn, apart.on * at.dt),
    )


@wp.func
def answer(own: Couple, at: Row, n: real, t: real, s: real) -> Vector:
    """What impulses at a contact do to its velocity, along n, t and s [m/s]."""
    apart, given = Apart(), Given()
    push(own, at, n, t, s, apart, given)
    return slip_at(at, apart)


@wp.func
def row_of(at: Contact, own: Couple) -> Row:
    """A contact as a sweep takes it."""
    one, zero = real(1.0), real(0.0)
    row = Row()
    row.dn = inner(at.n, at.ra)
    row.dt = inner(at.t, at.ra)
    row.ds = inner(at.s, at.ra)
    row.closing = at.closing
    by_n, by_t, by_s = (
        answer(own, row, one, zero, zero),
        answer(own, row, zero, one, zero),
        answer(own, row, zero, zero, one),
    )
    tt, ts, ss = by_t[1], by_t[2], by_s[2]
    apart = HALF * (tt - ss)
    over = one / fused_less(ts, ts, tt * ss)
    row.kn = by_n[0]
    row.wn = one / row.kn
    row.kt = HALF * (tt + ss) + wp.sqrt(fused(apart, apart, ts * ts))
    row.wk = one / row.kt
    row.knt = by_n[1]
    row.kns = by_n[2]
    row.wtt = over * ss
    row.wts = -over * ts
    row.wss = over * tt
    return row


@wp.func
def apart_of(own: Couple, va: Weighted, vb: Weighted) -> Apart:
    """Motion of A against B by their weighted velocities."""
    x, y, z = (
        fused(own.la, va.x, own.lb * vb.x),
        fused(own.la, va.y, own.lb * vb.y),
        fused(own.la, va.z, own.lb * vb.z),
    )
    return Apart(
        sum_of(own.nx, x, own.ny, y, own.nz, z)
        + sum_of(own.lnx, vb.ox, own.lny, vb.oy, own.lnz, vb.oz),
        sum_of(own.tx, x, own.ty, y, own.tz, z)
        + sum_of(own.ltx, vb.ox, own.lty, vb.oy, own.ltz, vb.oz),
        sum_of(own.sx, x, own.sy, y, own.sz, z)
        + sum_of(own.lsx, vb.ox, own.lsy, vb.oy, own.lsz, vb.oz),
        sum_of(own.anx, va.ox, own.any, va.oy, own.anz, va.oz)
        + sum_of(own.bnx, vb.ox, own.bny, vb.oy, own.bnz, vb.oz),
        sum_of(own.atx, va.ox, own.aty, va.oy, own.atz, va.oz)
        + sum_of(own.btx, vb.ox, own.bty, vb.oy, own.btz, vb.oz),
        sum_of(own.asx, va.ox, own.asy, va.oy, own.asz, va.oz)
        + sum_of(own.bsx, vb.ox, own.bsy, vb.oy, own.bsz, vb.oz),
    )


@wp.func
def give(own: Couple, given: Given, va: wp.ref[Weighted], vb: wp.ref[Weighted]):
    """Adds what A got from B to the velocities of both."""
    n, t, s, mn, mt, ms = given.n, given.t, given.s, given.mn, given.mt, given.ms
    px, py, pz = (
        sum_of(n, own.nx, t, own.tx, s, own.sx),
        sum_of(n, own.ny, t, own.ty, s, own.sy),
        sum_of(n, own.nz, t, own.tz, s, own.sz),
    )
    va.x = fused(own.la, px, va.x)
    va.y = fused(own.la, py, va.y)
    va.z = fused(own.la, pz, va.z)
    vb.x = fused(own.lb, px, vb.x)
    vb.y = fused(own.lb, py, vb.y)
    vb.z = fused(own.lb, pz, vb.z)
    va.ox = va.ox + sum_of(mn, own.anx, mt, own.atx, ms, own.asx)
    va.oy = va.oy + sum_of(mn, own.any, mt, own.aty, ms, own.asy)
    va.oz = va.oz + sum_of(mn, own.anz, mt, own.atz, ms, own.asz)
    vb.ox = vb.ox + (
        sum_of(mn, own.bnx, mt, own.btx, ms, own.bsx) + sum_of(n, own.lnx, t, own.ltx, s, own.lsx)
    )
    vb.oy = vb.oy + (
        sum_of(mn, own.bny, mt, own.bty, ms, own.bsy) + sum_of(n, own.lny, t, own.lty, s, own.lsy)
    )
    vb.oz = vb.oz + (
        sum_of(mn, own.bnz, mt, own.btz, ms, own.bsz) + sum_of(n, own.lnz, t, own.ltz, s, own.lsz)
    )


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
    rest: wp.ref[Rest], beta: real, eased: real, own: Couple, at: Row, held: wp.ref[Impulse],
    apart: wp.ref[Apart], given: wp.ref[Given],
):  # fmt: skip
    """Takes one contact in a sweep; the velocities have gone on along p already.

    Args:
        rest: What the sweep leaves.
        beta: Part of the last change by which impulses go on.
        eased: The part of a change of (T, S) that is taken where friction is above `STEEP`.
        own: The blocks of the contact.
        at: The contact; one of zeros changes nothing.
        held: Its impulses.
        apart: Relative motion of the blocks.
        given: What A got from B in this sweep.
    """
    n0 = fused(beta, held.pn, held.n)
    t0, s0 = fused(beta, held.pt, held.t), fused(beta, held.ps, held.s)
    u = slip_at(at, apart)
    n = larger(fused_less(at.wn, u[0] + at.closing, n0), least_normal(own.friction))
    dn = n - n0
    ut = fused(at.knt, dn, u[1])
    us = fused(at.kns, dn, u[2])
    bound = most_drag(own.friction, n)
    t1 = t0 - fused(at.wts, us, at.wtt * ut)
    s1 = s0 - fused(at.wss, us, at.wts * ut)
    t2, s2 = fused_less(at.wk, ut, t0), fused_less(at.wk, us, s0)
    length = wp.sqrt(fused(s2, s2, t2 * t2))
    kept = smaller(bound / larger(length, TINY), real(1.0))
    sticks = fused(s1, s1, t1 * t1) <= bound * bound
    all_t, all_s = wp.where(sticks, t1, kept * t2) - t0, wp.where(sticks, s1, kept * s2) - s0
    part = wp.where(own.friction > STEEP, eased, real(1.0))
    dt, ds = part * all_t, part * all_s
    held.n = n
    held.t = t0 + dt
    held.s = s0 + ds
    pt, ps = fused(beta, held.pt, all_t), fused(beta, held.ps, all_s)
    held.pn = fused(beta, held.pn, dn)
    held.pt = fused(beta, held.pt, dt)
    held.ps = fused(beta, held.ps, ds)
    square = fused(ds, ds, dt * dt)
    rest.square = rest.square + fused(at.kn * dn, dn, at.kt * square)
    un, drag = at.kn * held.pn, fused(ps, ps, pt * pt)
    rest.worst = larger(larger(un * un, at.kt * at.kt * drag), rest.worst)
    push(own, at, dn, dt, ds, apart, given)
