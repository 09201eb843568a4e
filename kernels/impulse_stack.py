"""Velocity-level contact step of a stack of rocking blocks, for one precision.

Bodies are numbered from the ground: body 0 is the ground, an infinite flat face that nothing
moves, body k the k-th block. Body k has the centre of mass (x, z), half height h, half width of
its faces f, clockwise rotation theta, in the frame of the base. A lever (X, Z) of the body points
to (X c + Z s, Z c - X s), with s, c the sine and cosine of theta; e = (c, -s) is the direction of
its faces, n = (s, c) their normal.

Interface k, between body k (upper) and body k - 1 (lower), touches at the two ends of the overlap
of the upper block's bottom face and the lower one's top face. Each end is whichever corner lies
further in along the lower face: a corner of the upper block against the lower's face, with the
normal and the direction of that face, or a corner of the lower one against the upper's face, with
those. A point at the lever r_u from the upper and r_l from the lower centre has, with a = r.e and
b = r.n of each, the relative velocities

    normal:  (v_u - v_l).n - a_u omega_u + a_l omega_l
    sliding: (v_u - v_l).e + b_u omega_u - b_l omega_l

One step of length dt is that of a single block (`impulse`), body by body: the velocity without
contact, contacts nearer than the collision margin, projected Gauss-Seidel from the last step's
impulses, semi-implicit Euler, erp. Here the sweeps work on the velocities, interfaces from the
ground up, and in each interface first the end that opens when it rocks on towards its lean, so
that a mirrored scene is visited in mirrored order. A penetration given back at an interface moves
all that stands on it, along the normal there.

Jean and Moreau (1992) for the scheme, Catto (2005) for the solver.
"""

from typing import Any

import warp as wp

from warprock.kernels.instance import kernel_module, module_options

real: Any
PRECISION: str

wp.set_module_options(module_options())
scalar = kernel_module("scalar", precision=PRECISION)
larger, smaller = scalar.larger, scalar.smaller
sign_of = scalar.sign_of

GROUND_FACE = real(1.0e9)
"""Half width of the ground's face [m]: no block reaches its ends."""


@wp.struct
class Knobs:
    """What a step needs to know of the settings."""

    time_step: real
    rate: real
    gravity: real
    collision_margin: real
    erp: real


@wp.func
def set_out(
    dv: real, knobs: Knobs, turn: real, vx: real, vz: real, omega: real, below: real,
    ux: wp.ref[real], uz: wp.ref[real], uo: wp.ref[real], lean: wp.ref[real],
    n1: wp.ref[real], t1: wp.ref[real], n2: wp.ref[real], t2: wp.ref[real],
):  # fmt: skip
    """Velocity of a block without contact, and its interface seen from the side it leans to.

    Args:
        dv: Change of the base velocity [m/s].
        knobs: Settings.
        turn: Rotation of the block against what it stands on [rad].
        vx: Velocity of its centre [m/s]; vz likewise.
        vz: See vx.
        omega: Its angular velocity [rad/s]; below that of what it stands on.
        below: See omega.
        ux: Where the velocity goes; uz, uo likewise.
        uz: See ux.
        uo: See ux.
        lean: Side to which the interface leaned, and leans: -1 or 1.
        n1: Normal impulse of the end opposite to the lean; n2 of the other, swapped with it where
            the lean has changed; t1, t2 likewise.
        t1: See n1.
        n2: See n1.
        t2: See n1.
    """
    zero = real(0.0)
    rate = omega - below
    now = sign_of(wp.where(turn != zero, turn, wp.where(rate != zero, rate, -dv)))
    same = now == lean
    n = n1
    t = t1
    n1 = wp.where(same, n, n2)
    t1 = wp.where(same, t, t2)
    n2 = wp.where(same, n2, n)
    t2 = wp.where(same, t2, t)
    lean = now
    ux = vx - dv
    uz = vz - knobs.time_step * knobs.gravity
    uo = omega


@wp.func
def meet(
    side: real, face: real, high: real, s: real, c: real,
    lface: real, lhigh: real, ls: real, lc: real, dx: real, dz: real,
    nx: wp.ref[real], nz: wp.ref[real], au: wp.ref[real], bu: wp.ref[real],
    al: wp.ref[real], bl: wp.ref[real], gap: wp.ref[real],
):  # fmt: skip
    """One end of the overlap of two faces.

    Args:
        side: 1 for the end at +x, -1 for the other.
        face: Half width of the upper block's faces [m]; lface of the lower one's.
        high: Half height of the upper block [m]; lhigh of the lower one.
        s: Sine of the upper block's rotation; ls of the lower one's.
        c: Cosine of the upper block's rotation; lc of the lower one's.
        lface: See face.
        lhigh: See high.
        ls: See s.
        lc: See c.
        dx: Upper centre from the lower one [m]; dz likewise.
        dz: See dx.
        nx: Where the normal goes; nz likewise.
        nz: See nx.
        au: Where a of the upper lever goes [m]; bu, al, bl likewise.
        bu: See au.
        al: See au.
        bl: See au.
        gap: Where the gap goes [m].
    """
    px = side * face * c - high * s
    pz = -high * c - side * face * s
    qx = side * lface * lc + lhigh * ls
    qz = lhigh * lc - side * lface * ls
    ax = dx + px
    az = dz + pz
    bx = qx - dx
    bz = qz - dz
    inside = side * (ax * lc - az * ls) <= lface
    mx = wp.where(inside, ls, s)
    mz = wp.where(inside, lc, c)
    ux = wp.where(inside, px, bx)
    uz = wp.where(inside, pz, bz)
    lx = wp.where(inside, ax, qx)
    lz = wp.where(inside, az, qz)
    nx = mx
    nz = mz
    au = ux * mz - uz * mx
    bu = ux * mx + uz * mz
    al = lx * mz - lz * mx
    bl = lx * mx + lz * mz
    gap = wp.where(inside, ax * ls + az * lc - lhigh, -bx * s - bz * c - high)


@wp.func
def kick(
    m: real, j: real, nx: real, nz: real, a: real, b: real, p: real, f: real,
    ux: wp.ref[real], uz: wp.ref[real], uo: wp.ref[real],
):  # fmt: skip
    """Adds a normal impulse p and a tangential one f at a lever (a, b) to a body's velocity."""
    ux = ux + m * (nx * p + nz * f)
    uz = uz + m * (nz * p - nx * f)
    uo = uo + j * (b * f - a * p)


@wp.func
def resume(
    gap: real, margin: real, m: real, j: real, lm: real, lj: real,
    nx: real, nz: real, au: real, bu: real, al: real, bl: real,
    pn: wp.ref[real], pt: wp.ref[real], nt: wp.ref[real], was: wp.ref[real],
    n: wp.ref[real], t: wp.ref[real],
    ux: wp.ref[real], uz: wp.ref[real], uo: wp.ref[real],
    lx: wp.ref[real], lz: wp.ref[real], lo: wp.ref[real],
):  # fmt: skip
    """Starts a point from its impulses of the last step.

    Args:
        gap: [m].
        margin: Gap above which the point is no contact [m].
        m: Inverse mass of the upper block [1/kg]; lm of the lower one.
        j: Inverse moment of inertia of the upper block [1/(kg m^2)]; lj of the lower one.
        lm: See m.
        lj: See j.
        nx: Normal; nz likewise.
        nz: See nx.
        au: Lever a of the upper block [m]; bu, al, bl likewise.
        bu: See au.
        al: See au.
        bl: See au.
        pn: Where the normal impulse for a normal velocity goes [kg], 0 for what is no contact.
        pt: Where the tangential impulse for a tangential velocity goes [kg], likewise.
        nt: Where the tangential velocity for a normal impulse goes [1/kg].
        was: Where the normal impulse of the last step goes [N s].
        n: Normal impulse [N s]; t the tangential one.
        t: See n.
        ux: Velocity of the upper block [m/s]; uz likewise, uo its angular velocity [rad/s].
        uz: See ux.
        uo: See ux.
        lx: Velocity of the lower block [m/s]; lz likewise, lo its angular velocity [rad/s].
        lz: See lx.
        lo: See lx.
    """
    on = wp.where(gap <= margin, real(1.0), real(0.0))
    pn = on / (m + lm + j * au * au + lj * al * al)
    pt = on / (m + lm + j * bu * bu + lj * bl * bl)
    nt = -(j * au * bu + lj * al * bl)
    was = n
    p = on * n
    f = on * t
    n = p
    t = f
    kick(m, j, nx, nz, au, bu, p, f, ux, uz, uo)
    kick(lm, lj, nx, nz, al, bl, -p, -f, lx, lz, lo)


@wp.func
def press(
    mu: real, gap: real, rate: real, m: real, j: real, lm: real, lj: real,
    nx: real, nz: real, au: real, bu: real, al: real, bl: real, pn: real, pt: real, nt: real,
    n: wp.ref[real], t: wp.ref[real],
    ux: wp.ref[real], uz: wp.ref[real], uo: wp.ref[real],
    lx: wp.ref[real], lz: wp.ref[real], lo: wp.ref[real],
):  # fmt: skip
    """Gauss-Seidel on the two impulses of a point: an open gap may close, a closed one not.

    Args:
        mu: Friction coefficient.
        gap: See `resume`, as all that is not told here.
        rate: Inverse of the time step [1/s].
        m: See `resume`.
        j: See `resume`.
        lm: See `resume`.
        lj: See `resume`.
        nx: See `resume`.
        nz: See `resume`.
        au: See `resume`.
        bu: See `resume`.
        al: See `resume`.
        bl: See `resume`.
        pn: What `resume` left there; pt, nt likewise.
        pt: See pn.
        nt: See pn.
        n: See `resume`.
        t: See `resume`.
        ux: See `resume`.
        uz: See `resume`.
        uo: See `resume`.
        lx: See `resume`.
        lz: See `resume`.
        lo: See `resume`.
    """
    zero = real(0.0)
    wx = ux - lx
    wz = uz - lz
    normal = nx * wx + nz * wz - au * uo + al * lo + larger(gap, zero) * rate
    p = larger(n - pn * normal, zero)
    dp = p - n
    bound = mu * p
    slip = nz * wx - nx * wz + bu * uo - bl * lo + nt * dp
    f = larger(smaller(t - pt * slip, bound), -bound)
    df = f - t
    n = p
    t = f
    kick(m, j, nx, nz, au, bu, dp, df, ux, uz, uo)
    kick(lm, lj, nx, nz, al, bl, -dp, -df, lx, lz, lo)


@wp.func
def stand(
    face: real, high: real, s: real, c: real, offset: real,
    lface: real, lhigh: real, ls: real, lc: real, dx: real, dz: real, turn: real,
):  # fmt: skip
    """Slide of a block along what it stands on, and the width of the overlap of the faces [m].

    Args:
        face: See `meet`, as all that is not told here.
        high: See `meet`.
        s: See `meet`.
        c: See `meet`.
        offset: Slide that was there at the start [m].
        lface: See `meet`.
        lhigh: See `meet`.
        ls: See `meet`.
        lc: See `meet`.
        dx: See `meet`.
        dz: See `meet`.
        turn: Rotation of the block against what it stands on [rad].
    """
    lean = sign_of(turn)
    # Bottom corners of the block along the lower face, from the middles of both.
    run = lean * face * (c * lc + s * ls)
    middle = (dx - high * s) * lc - (dz - high * c) * ls
    bx = lean * lface * lc + lhigh * ls - dx
    bz = lhigh * lc - lean * lface * ls - dz
    inside = lean * (middle + run) <= lface
    place = wp.where(inside, middle + run - lean * face, lean * lface - (bx * c - bz * s))
    overlap = smaller(lean * (middle + run), lface) + smaller(lean * (run - middle), lface)
    return place - offset, overlap
