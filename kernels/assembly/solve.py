"""The impulses of all contacts of an assembly in a step, by nonsmooth conjugate gradients.

A sweep takes the contacts one after the other, each with the velocities that the last one left
(projected Gauss-Seidel):

    N = max(0, N - (u_n + b) / k_n)
    T = the nearest to T - u_t / k_t within -friction N and friction N

Its change of the impulses, d, is the negative gradient of a conjugate-gradient method
(Silcowitz, Niebe and Erleben 2010, A nonsmooth nonlinear conjugate gradient method for interactive
contact force problems, *The Visual Computer* 26):

    beta = |d|^2 / |d before|^2, at most 1, 0 from `GROWN` on, with the kinetic energy as |.|^2
    p = beta p + d,   impulses + beta p

An arch of 27 blocks takes 10 such sweeps a step, and some 200 plain ones. Where the joints between
free blocks form a tree, a lane leaps after a sweep instead, see tree.py. What a lane has left is
the largest velocity that a contact changed by in its last sweep; a lane is settled once that is
below its bound. A lane that is settled, or at its limit of sweeps, takes no further step along p:
so its impulses and its velocities agree, and it waits without any change.
"""

import warp as wp

from warprock.kernels.assembly.joint import Contact, Impulse, opening_speed, push
from warprock.kernels.shape.interface import Mass, Velocity

GROWN = real(1.1)
"""Growth of |d|^2 from which on the direction is dropped. Where blocks hold one another by forces
that may be large or small alike, sweeps change these evenly for hundreds of sweeps. There |d|^2
grows by parts in a million, and a direction is what ends it."""

ALONG, STRAIGHT = 16, 4
"""Sweeps with a direction p, and plain ones after them: where contacts begin or end to slide in
every sweep, directions alone may lead in circles."""

LEAPS, TIGHT = 20, real(1.0e-2)
"""Most leaps of a step, and the part of its bound to which a lane is solved while it leaps. A leap
that leaves more than half is the last one of its step: there sweeps get on faster."""

LONG, SHARE = 200, real(1.0e-2)
"""Sweeps after which a change by this share of the fastest corner's speed will do. Where blocks
that slide and fall wedge one another in, sweeps go on in circles, or impulses grow without end. The
length of the step is a larger error there: what touches late by a step has moved by all of it."""

STEEP, EASY, TURN = real(1.0), real(20.0), 1000
"""After `LONG` sweeps a lane that moves takes a part of each change of T where friction is above
STEEP: 1 / 2 after EASY more sweeps, 1 / 3 after twice as many, and so on (under-relaxation). Where
a contact slides, T follows N, and through a chain of blocks N follows T. Whole changes then
overshoot by more than they mend. Blocks that wedge one another in need whole changes, which come
in turn, TURN sweeps each. What a lane has left is the whole change in either case."""


@wp.struct
class Way:
    """The direction p of a contact's impulses, and their change d in the last sweep [N s]."""

    pn: real
    pt: real
    dn: real
    dt: real


@wp.struct
class Trail:
    """What the impulses along p do to the velocity of a block, and its velocity a sweep ago."""

    px: real
    pz: real
    po: real
    x: real
    z: real
    omega: real


@wp.struct
class Solve:
    """How far the solve of a lane has come.

    Attributes:
        on: 1 while it is not settled, else 0.
        beta: Part of the direction that is kept.
        worst: Largest change of the velocity of a contact in this sweep [m/s].
        square: |d|^2 of this sweep [J].
        before: That of the last one; 0 of a first sweep.
        left: `worst` of the last sweep [m/s].
        loose: What may be left after `LONG` sweeps [m/s].
        eased: The part of each change of T that is taken, see `EASY`.
        sweeps: Sweeps of this step.
    """

    on: real
    beta: real
    worst: real
    square: real
    before: real
    left: real
    loose: real
    eased: real
    sweeps: int


@wp.struct
class Leap:
    """The leaps of a lane, see tree.py.

    Attributes:
        count: Leaps of this step.
        next: 1 where one comes next, else 0.
        share: The part of it that keeps the law of all contacts.
    """

    count: int
    next: int
    share: real


@wp.func
def start_solve(on: real, bound: real, speed: real) -> Solve:
    """A solve before its first sweep.

    Args:
        on: Whether its lane runs (1) or has ended (0).
        bound: Velocity below which it is settled [m/s].
        speed: Largest speed of a corner in the lane [m/s].
    """
    zero = real(0.0)
    return Solve(on, zero, zero, zero, zero, zero, larger(bound, SHARE * speed), real(1.0), 0)


@wp.func
def drift_after(step: real, solve: Solve, drift: real) -> real:
    """How far solves that missed their bound have moved blocks, with one that has ended [m]."""
    return wp.where(solve.left > solve.loose, fused(step, solve.left, drift), drift)


if BONDS:

    @wp.func
    def least_normal(impulse: Impulse) -> real:
        """The least N of a contact [N s]: a bond holds."""
        return -impulse.hold

    @wp.func
    def most_drag(friction: real, n: real, impulse: Impulse) -> real:
        """The most |T| of a contact [N s]."""
        return larger(friction * n, real(0.0)) + impulse.hold

else:

    @wp.func
    def least_normal(impulse: Impulse) -> real:
        """The least N of a contact [N s]."""
        return real(0.0)

    @wp.func
    def most_drag(friction: real, n: real, impulse: Impulse) -> real:
        """The most |T| of a contact [N s]."""
        return friction * n


@wp.func
def sweep_contact(
    solve: wp.ref[Solve], at: Contact, ma: Mass, mb: Mass, impulse: wp.ref[Impulse],
    way: wp.ref[Way], va: wp.ref[Velocity], vb: wp.ref[Velocity],
):  # fmt: skip
    """Takes one contact in a sweep; the velocities have taken the step along p already.

    Args:
        solve: The solve of its lane.
        at: The contact.
        ma, mb: Masses of its blocks.
        impulse: Its impulses.
        way: Their direction and last change.
        va, vb: Velocities of its blocks.
    """
    on, beta = real(solve.on), real(solve.beta)
    n0, t0 = fused(beta, way.pn, impulse.n), fused(beta, way.pt, impulse.t)
    way.pn = fused(beta, way.pn, way.dn)
    way.pt = fused(beta, way.pt, way.dt)
    wanted = larger(fused_less(at.wn, opening_speed(at, va, vb) + at.b, n0), least_normal(impulse))
    dn = on * (wanted - n0)
    n = n0 + dn
    # What dn does to u_t goes through the rotations alone, for n and t' are at right angles.
    oa, ob = fused(ma.j, at.aa * dn, va.omega), fused(mb.j, at.ab * dn, vb.omega)
    w = dot(at.ba, at.bb, oa, ob) + wedge(at.nx, at.nz, va.x - vb.x, va.z - vb.z)
    bound = most_drag(at.friction, n, impulse)
    dragged = smaller(larger(fused_less(at.wt, w, t0), -bound), bound)
    whole = on * (dragged - t0)
    dt = wp.where(at.friction > STEEP, solve.eased * whole, whole)
    impulse.n = n
    impulse.t = t0 + dt
    way.dn = dn
    way.dt = dt
    un, ut = dn * at.kn, dt * at.kt
    solve.square = fused(dt, ut, fused(dn, un, solve.square))
    solve.worst = larger(larger(size(un), size(whole * at.kt)), solve.worst)
    push(at, dn, dt, ma, mb, va, vb)


@wp.func
def decide(bound: real, most: int, leaps: bool, solve: wp.ref[Solve], leap: wp.ref[Leap]):
    """Whether a lane sweeps on, and how, after a sweep.

    Args:
        bound: Velocity below which it is settled [m/s].
        most: Most sweeps of a step.
        leaps: Whether its joints form a tree, see tree.py.
        solve: Its solve.
        leap: Its leaps.
    """
    zero, on = real(0.0), real(solve.on)
    square, before, worst = real(solve.square), real(solve.before), real(solve.worst)
    live = on > zero
    count = wp.where(solve.sweeps == 0, 0, leap.count)
    fails = leap.next > 0 and worst > HALF * solve.left
    count = wp.where(fails, LEAPS, count)
    may_leap = leaps and count < LEAPS
    left = wp.where(may_leap, TIGHT * bound, wp.where(solve.sweeps < LONG, bound, solve.loose))
    goes = live and worst > left and solve.sweeps + 1 < most
    jumps = goes and may_leap
    leap.next = wp.where(jumps, 1, 0)
    leap.count = count + leap.next
    leap.share = real(1.0)
    plain = solve.sweeps % (ALONG + STRAIGHT) >= ALONG
    shrinks = before > zero and square < GROWN * before and not plain
    solve.sweeps = solve.sweeps + wp.where(live, 1, 0)
    turn = (solve.sweeps - LONG) % (2 * TURN)
    eases = solve.loose > bound and solve.sweeps > LONG and turn < TURN
    solve.eased = EASY / (EASY + real(wp.where(eases, turn, 0)))
    kept = smaller(square / wp.where(shrinks, before, real(1.0)), real(1.0))
    solve.beta = wp.where(goes and shrinks and not jumps, kept, zero)
    solve.before = wp.where(live, wp.where(jumps, zero, square), before)
    solve.left = wp.where(live, worst, solve.left)
    solve.on = wp.where(goes, real(1.0), zero)
    solve.worst = zero
    solve.square = zero


@wp.func
def extrapolate(beta: real, v: wp.ref[Velocity], trail: wp.ref[Trail]):
    """Moves the velocity of a block along p by beta, as its impulses will in the next sweep."""
    dx, dz, do = v.x - trail.x, v.z - trail.z, v.omega - trail.omega
    v.x = fused(beta, trail.px, v.x)
    v.z = fused(beta, trail.pz, v.z)
    v.omega = fused(beta, trail.po, v.omega)
    trail.px = fused(beta, trail.px, dx)
    trail.pz = fused(beta, trail.pz, dz)
    trail.po = fused(beta, trail.po, do)
    trail.x = v.x
    trail.z = v.z
    trail.omega = v.omega
