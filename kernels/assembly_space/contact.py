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
"""

import warp as wp

from warprock.kernels.algebra.vectors import Matrix, Vector
from warprock.kernels.assembly.solve import Solve


@wp.struct
class Heft:
    """Inverse mass [1/kg] and inverse inertia in the axes of the base; zero of what is fixed."""

    light: real
    turns: Matrix


@wp.struct
class Move:
    """Velocity of the centre of mass [m/s] and angular velocity [rad/s]."""

    v: Vector
    o: Vector


@wp.struct
class Contact:
    """A contact in a step; symbols as at the head of the file.

    Attributes:
        a, b: The blocks A and B.
        n, t, s: Normal and tangents.
        ra, rb: Levers [m].
        kn, kt: What N does to u_n, and the larger eigenvalue k [1/kg].
        knt, kns: What N does to u_t and to u_s [1/kg].
        wtt, wts, wss: W^-1 [kg].
        closing: Velocity b [m/s].
        friction: Coulomb friction coefficient.
    """

    a: int
    b: int
    n: Vector
    t: Vector
    s: Vector
    ra: Vector
    rb: Vector
    kn: real
    kt: real
    knt: real
    kns: real
    wtt: real
    wts: real
    wss: real
    closing: real
    friction: real


@wp.struct
class Impulse:
    """Impulses of a contact [N s], their direction p and last change d (assembly/solve.py)."""

    n: real
    t: real
    s: real
    pn: real
    pt: real
    ps: real
    dn: real
    dt: real
    ds: real


@wp.func
def inner(a: Vector, b: Vector) -> real:
    """The scalar product of two vectors."""
    return fused(a[2], b[2], fused(a[1], b[1], a[0] * b[0]))


@wp.func
def outer(a: Vector, b: Vector) -> Vector:
    """The vector product of two vectors."""
    return Vector(
        fused_less(a[2], b[1], a[1] * b[2]),
        fused_less(a[0], b[2], a[2] * b[0]),
        fused_less(a[1], b[0], a[0] * b[1]),
    )


@wp.func
def moved(part: real, a: Vector, b: Vector) -> Vector:
    """The sum of a part of a and of b."""
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
def yields(j: Matrix, r: Vector, along: Vector) -> Vector:
    """What a unit impulse along a direction at the lever r does there by turning a block."""
    return outer(times(j, outer(r, along)), r)


@wp.func
def set_masses(at: wp.ref[Contact], ma: Heft, mb: Heft):
    """What impulses do to the velocities of a contact whose levers and directions are known."""
    n, t, s = Vector(at.n), Vector(at.t), Vector(at.s)
    light = ma.light + mb.light
    by_n = moved(light, n, yields(ma.turns, at.ra, n) + yields(mb.turns, at.rb, n))
    by_t = moved(light, t, yields(ma.turns, at.ra, t) + yields(mb.turns, at.rb, t))
    by_s = moved(light, s, yields(ma.turns, at.ra, s) + yields(mb.turns, at.rb, s))
    tt, ts, ss = inner(t, by_t), inner(t, by_s), inner(s, by_s)
    over = real(1.0) / fused_less(ts, ts, tt * ss)
    apart = HALF * (tt - ss)
    at.kn = inner(n, by_n)
    at.knt = inner(t, by_n)
    at.kns = inner(s, by_n)
    at.kt = HALF * (tt + ss) + wp.sqrt(fused(apart, apart, ts * ts))
    at.wtt = over * ss
    at.wts = -over * ts
    at.wss = over * tt


@wp.func
def relative(at: Contact, va: Move, vb: Move) -> Vector:
    """Velocity w of a contact [m/s]."""
    return (va.v - vb.v) + (outer(va.o, at.ra) - outer(vb.o, at.rb))


@wp.func
def push(at: Contact, p: Vector, ma: Heft, mb: Heft, va: wp.ref[Move], vb: wp.ref[Move]):
    """Adds an impulse p on the first block, and -p on the second one, to their velocities."""
    va.v = moved(ma.light, p, va.v)
    va.o = va.o + times(ma.turns, outer(at.ra, p))
    vb.v = moved(-mb.light, p, vb.v)
    vb.o = vb.o - times(mb.turns, outer(at.rb, p))


@wp.func
def sweep_contact(
    solve: wp.ref[Solve], at: Contact, ma: Heft, mb: Heft, held: wp.ref[Impulse],
    va: wp.ref[Move], vb: wp.ref[Move],
):  # fmt: skip
    """Takes one contact in a sweep; the velocities have taken the step along p already.

    Args:
        solve: The solve of its lane.
        at: The contact.
        ma, mb: Masses of its blocks.
        held: Its impulses.
        va, vb: Velocities of its blocks.
    """
    on, beta = real(solve.on), real(solve.beta)
    n0 = fused(beta, held.pn, held.n)
    t0, s0 = fused(beta, held.pt, held.t), fused(beta, held.ps, held.s)
    held.pn = fused(beta, held.pn, held.dn)
    held.pt = fused(beta, held.pt, held.dt)
    held.ps = fused(beta, held.ps, held.ds)
    w = relative(at, va, vb)
    n = larger(n0 - (inner(at.n, w) + at.closing) / at.kn, real(0.0))
    dn = on * (n - n0)
    n = n0 + dn
    ut, us = fused(at.knt, dn, inner(at.t, w)), fused(at.kns, dn, inner(at.s, w))
    bound = at.friction * n
    t = t0 - fused(at.wts, us, at.wtt * ut)
    s = s0 - fused(at.wss, us, at.wts * ut)
    if fused(s, s, t * t) > bound * bound:
        over = real(1.0) / at.kt
        t = fused_less(over, ut, t0)
        s = fused_less(over, us, s0)
        length = wp.sqrt(fused(s, s, t * t))
        kept = wp.where(length > bound, bound / length, real(1.0))
        t = kept * t
        s = kept * s
    dt, ds = on * (t - t0), on * (s - s0)
    held.n = n
    held.t = t0 + dt
    held.s = s0 + ds
    held.dn = dn
    held.dt = dt
    held.ds = ds
    square = fused(ds, ds, dt * dt)
    solve.square = fused(at.kt, square, fused(at.kn * dn, dn, solve.square))
    solve.worst = larger(larger(at.kn * size(dn), at.kt * wp.sqrt(square)), solve.worst)
    push(at, dn * at.n + dt * at.t + ds * at.s, ma, mb, va, vb)
