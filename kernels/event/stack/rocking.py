"""Taylor polynomials of a stack that sticks at all its contacts; event/stack/step.py.

While every interface is closed or pivots on a corner that sticks, the stack is a chain with the
equations of event/stack/links.py. A lever (x, z) of the start comes to (x c + z s, z c - x s), with
s and c of the rotation since then. So the moment on block k is J_k theta_k'' + c u - s w, with

    u = P_k^ . (A_k'' + G) + C_k^ . S_(k+1),   w = P_k . (A_k'' + G) + C_k . S_(k+1)

and the levers of the start. At each order in time the equations are linear in that coefficient of
theta'', all with the matrix of the start (Leibniz's rule). Rotations are found to degree 6, forces
and moments to degree 4.
"""

import warp as wp

from warprock.kernels.event.stack.curves import ORDERS, Curves
from warprock.kernels.event.stack.links import Chain, accelerate
from warprock.kernels.event.stack.moves import opening, settles
from warprock.kernels.event.stack.state import Limits
from warprock.kernels.shape.stack import CLOSED, Blocks, Counts, Pose, Triples, Values, side_of

BRIEF = by_precision(1.0 / 16.0, 0.0)
BRIEF_ORDERS = ORDERS - 2
"""A step that ends this soon, as a part of the longest one d, is followed in polynomials of two
degrees less, up to twice the time that the first accelerations tell. They leave out some
(p d / 8)^5 / 5! of a motion at a frequency p, less than the (p d)^7 / 7! that all degrees leave out
of a step d long if p d is above 0.04, and else less than 3e-14. In float32 no step is: a corner
that lies flat but for round-off would seem to land soon in one step after the other."""

Terms = wp.types.vector(length=ORDERS, dtype=real)
"""Coefficients of an acceleration of the base."""


@wp.struct
class Rocking:
    """Polynomials of a stack whose contacts stick.

    Attributes:
        waits: Whether interfaces fall flat at once. Then nothing else is found but
        rests: which of them do: CLOSED there.
        reach: Time up to which the polynomials serve [s].
        theta: Rotations [rad].
        fx, fz: Forces on the interfaces [N].
        moment: Moments on the interfaces about their pivots [N m].
    """

    waits: bool
    rests: Counts
    reach: real
    theta: Curves
    fx: Curves
    fz: Curves
    moment: Curves


@wp.func
def look_at_start(
    pose: wp.ref[Pose], touch: Counts, velocity: Triples, bend: Values, rest: Values
):  # fmt: skip
    """What the accelerations at its start tell of a step.

    Args:
        pose: The pose, with the ends that touched before.
        touch: Ends that touch and stick.
        velocity: Velocities.
        bend: Angular accelerations [rad/s^2].
        rest: Swings below which a block rests [rad].

    Returns:
        Interfaces that fall flat again at once, see `settles`: CLOSED there; whether any does; when
        the first of the others falls flat [s].
    """
    soonest = NEVER
    rests = Counts()
    waits = bool(False)
    for k in range(BLOCKS):
        if touch[k] != CLOSED and pose.touch[k] == touch[k]:
            more = bend[k]
            if k > 0:
                more = more - bend[k - 1]
            more = side_of(touch[k]) * more
            start = opening(pose, velocity, k, touch[k])
            if more < real(0.0):
                if settles(start, HALF * more, rest[k]):
                    rests[k] = CLOSED
                    waits = True
                else:
                    angle = larger(start.angle, real(0.0))
                    speed = wp.sqrt(fused_less(TWO * more, angle, start.rate * start.rate))
                    soonest = smaller(soonest, -(start.rate + speed) / more)
    return rests, waits, soonest


@wp.func
def add_turned(vx: real, vz: real, s: real, c: real, x: real, z: real):
    """A vector (x, z) and the lever v turned by a rotation with sine s and cosine c."""
    return fused(vz, s, fused(vx, c, x)), fused_less(vx, s, fused(vz, c, z))


@wp.func
def accelerate_pivots(chain: wp.ref[Chain], s2: Values, c2: Values, ax: real, az: real):
    """A'' + G of all blocks (x, z), see event/stack/links.py [m/s^2].

    Args:
        chain: The chain.
        s2, c2: Second derivatives of the sines and cosines of the rotations since the start.
        ax, az: Acceleration of the base, upwards with gravity [m/s^2].
    """
    lx = Values()
    lz = Values()
    x = real(ax)
    z = real(az)
    for k in range(BLOCKS):
        lx[k] = x
        lz[k] = z
        x, z = add_turned(chain.cx[k], chain.cz[k], s2[k], c2[k], x, z)
    return lx, lz


@wp.func(inline=False)
def predict_rocking(
    blocks: wp.ref[Blocks], limits: wp.ref[Limits], pose: wp.ref[Pose], chain: wp.ref[Chain],
    velocity: wp.ref[Triples], ax: wp.ref[Terms], az: wp.ref[Terms], r: wp.ref[Rocking],
):  # fmt: skip
    """Finds the Taylor polynomials of a stack that sticks where its ends touch.

    Args:
        blocks: The blocks.
        limits: The lane's limits.
        pose: The pose, with the ends that touched before.
        chain: The chain that the ends make that touch and stick.
        velocity: Velocities; the angular ones count.
        ax, az: Taylor coefficients of the acceleration of the base, upwards with gravity [m/s^2].
        r: What is found.
    """
    s, c, us, ws, rate = Curves(), Curves(), Curves(), Curves(), Curves()
    carried = Values()
    mass = real(0.0)
    for step in range(BLOCKS):
        k = wp.static(BLOCKS - 1 - step)
        mass = mass + blocks.mass[k]
        carried[k] = mass
        spin = velocity[wp.static(3 * k + 2)]
        r.theta[k, 0] = pose.theta[k]
        r.theta[k, 1] = spin
        rate[k, 0] = spin
        s[k, 1] = spin
    soon = bool(False)
    r.waits = False
    for n in range(ORDERS):
        if n == BRIEF_ORDERS and soon:
            return
        # Second derivatives without the new coefficients of the rotations, and what moments of
        # lower orders leave. The sums have no terms of s = 0 and c = 1 at the start.
        s2, c2, load, missing = Values(), Values(), Values(), Values()
        for k in range(BLOCKS):
            sk = real(0.0)
            ck = real(0.0)
            lk = real(0.0)
            for i in range(wp.static(n)):
                sk = fused(rate[k, i], c[k, n + 1 - i], sk)
            for i in range(wp.static(n + 1)):
                ck = fused_less(rate[k, i], s[k, n + 1 - i], ck)
            for j in range(2, wp.static(n + 1)):
                lk = fused_less(c[k, j], us[k, n - j], lk)
            for j in range(1, wp.static(n + 1)):
                lk = fused(s[k, j], ws[k, n - j], lk)
            s2[k] = real(n + 1) * sk
            c2[k] = real(n + 1) * ck
            load[wp.static(k)] = lk
        lx, lz = accelerate_pivots(chain, s2, c2, ax[n], az[n])
        sx = real(0.0)
        sz = real(0.0)
        for step in range(BLOCKS):
            k = wp.static(BLOCKS - 1 - step)
            own = fused(chain.px[k], lz[k], fused_less(chain.pz[k], lx[k], load[k]))
            missing[k] = fused(chain.cx[k], sz, fused_less(chain.cz[k], sx, own))
            sx, sz = add_turned(chain.px[k], chain.pz[k], s2[k], c2[k], sx, sz)
        bend = accelerate(chain, missing)
        if n == 0:
            rests, waits, soonest = look_at_start(
                pose, chain.touch, velocity, bend, limits.rest_rotation
            )
            soon = soonest < BRIEF * limits.longest_step
            r.reach = wp.where(soon, TWO * soonest, NEVER)
            if waits:
                r.waits = True
                r.rests = rests
                return
        for k in range(BLOCKS):
            s2[k] = s2[k] + bend[k]
        lx, lz = accelerate_pivots(chain, s2, c2, ax[n], az[n])
        sx = real(0.0)
        sz = real(0.0)
        over = real(1.0) / real((n + 1) * (n + 2))
        above = real(0.0)
        for step in range(BLOCKS):
            k = wp.static(BLOCKS - 1 - step)
            # The forces from above are known last.
            u = wedge(lx[k], lz[k], chain.px[k], chain.pz[k])
            u = fused(chain.cz[k], sx, fused_less(chain.cx[k], sz, u))
            w = dot(lx[k], lz[k], chain.px[k], chain.pz[k])
            w = fused(chain.cx[k], sx, fused(chain.cz[k], sz, w))
            above = above + fused(bend[k], chain.turns[k], u - load[k])
            sx, sz = add_turned(chain.px[k], chain.pz[k], s2[k], c2[k], sx, sz)
            r.moment[k, n] = above
            r.fx[k, n] = fused(carried[k], lx[k], sx)
            r.fz[k, n] = fused(carried[k], lz[k], sz)
            us[k, n] = u
            ws[k, n] = w
            r.theta[k, n + 2] = over * bend[k]
            rate[k, n + 1] = real(n + 2) * r.theta[k, n + 2]
            s[k, n + 2] = over * s2[k]
            c[k, n + 2] = over * c2[k]
