"""Velocity-level contact step of a rocking block.

The block lives in the frame of the base: mass 1, centre of mass (x, z), clockwise rotation
theta, inertia I. Corner i sits at (X_i, Z_i) from the centre of mass, its gap is z + Z_i, its
velocity (vx + omega Z_i, vz - omega X_i). One step of length dt, semi-implicit Euler with the
velocities at half steps (so the release at t = 0 begins with half a step of gravity):

    1. v* = v + dt (0, -g) - (dv_base, 0), dv_base the change of the base velocity between the
       half steps, so that a velocity step of the base is carried exactly;
    2. corners nearer than the collision margin are contacts. Each asks for a normal velocity of
       at least -gap / dt (it may close an open gap) or zero, and for no tangential velocity
       within Coulomb's bound |f| <= mu n;
    3. projected Gauss-Seidel on the four impulses l = (n1, f1, n2, f2), started from those of
       the last step: l_i = clamp(-(u_i + sum over j != i of K_ij l_j) / K_ii), where
       K = J M^-1 J^T and u is what v* misses of the wish of each row. One contact alone is
       solved exactly, see cone.py;
    4. v = v* + M^-1 J^T l, q = q + dt v; the block is lifted by erp times its penetration, but
       for the 2 g dt^2 that one step of falling can make, else a resting block would never be
       still. (A penetration given back through the velocity would add energy that does not
       vanish with dt: at an impact it is of the order of dt times the velocity.)

A lane's state: x along the base from where the block would rest [m], z above the base [m], theta
[rad]; vx, vz [m/s] and omega [rad/s] relative to the base; the impulses n1, f1 of the -x corner
and n2, f2 of the +x corner in the last step, per unit mass [m/s]; loss, the energy lost so far
per unit mass [J/kg], less what lifting by erp has given it.

Jean and Moreau (1992) for the scheme, Catto (2005) for the solver.
"""

import warp as wp

from warprock.kernels.cone import alone
from warprock.kernels.instance import MAX_UNROLL

ENDS_EARLY = ITERATIONS > MAX_UNROLL
"""Whether sweeps end once one has changed nothing, for all others would change nothing either.
Fewer sweeps are written out, without a way out that would keep a loop over lanes scalar."""


@wp.struct
class Block:
    """What a step needs to know of one lane's block."""

    half_width: real
    half_height: real
    inverse_inertia: real
    friction: real


@wp.struct
class Knobs:
    """What a step needs to know of the settings; `rate` is the inverse of the time step [1/s]."""

    time_step: real
    rate: real
    gravity: real
    collision_margin: real
    erp: real


@wp.func
def wish(gap: real, knobs: Knobs) -> real:
    """Least normal velocity of a corner after the step: an open gap may close."""
    return -larger(gap, real(0.0)) * knobs.rate


@wp.struct
class Rows:
    """The four rows of the contact problem, each over its diagonal.

    a1 to a3 is the row of n1 off the diagonal, of f1, n2 and f2 in this order; b1 to b3 is that of
    f1, c1 to c3 that of n2, g1 to g3 that of f2. u1, s1, u2, s2 is what the rows of n1, f1, n2 and
    f2 ask for [m/s]. mu is the friction coefficient.
    """

    mu: real
    a1: real
    a2: real
    a3: real
    b1: real
    b2: real
    b3: real
    c1: real
    c2: real
    c3: real
    g1: real
    g2: real
    g3: real
    u1: real
    s1: real
    u2: real
    s2: real


@wp.func
def sweep(r: Rows, f1: real, n2: real, f2: real):
    """The impulses n1, f1, n2, f2 [m/s] after one sweep over the four rows."""
    # The value found last comes last in each row, so that the other terms need not wait for it.
    n1 = larger(less_three(r.u1, r.a1, f1, r.a2, n2, r.a3, f2), real(0.0))
    bound = r.mu * n1
    f1 = larger(smaller(less_three(r.s1, r.b2, n2, r.b3, f2, r.b1, n1), bound), -bound)
    n2 = larger(less_three(r.u2, r.c3, f2, r.c1, n1, r.c2, f1), real(0.0))
    bound = r.mu * n2
    f2 = larger(smaller(less_three(r.s2, r.g1, n1, r.g2, f1, r.g3, n2), bound), -bound)
    return n1, f1, n2, f2


@wp.func
def sweeps(r: Rows, n1: real, f1: real, n2: real, f2: real):
    """All sweeps from the impulses n1, f1, n2, f2 [m/s]."""
    if ENDS_EARLY:
        for _ in range(ITERATIONS):
            old_f1 = f1
            old_n2 = n2
            old_f2 = f2
            n1, f1, n2, f2 = sweep(r, f1, n2, f2)
            if f1 == old_f1 and n2 == old_n2 and f2 == old_f2:
                break
    else:
        for _ in range(ITERATIONS):
            n1, f1, n2, f2 = sweep(r, f1, n2, f2)
    return n1, f1, n2, f2


@wp.func
def inverses(a: real, b: real, c: real, d: real):
    """Inverses of four numbers by one division, which takes as long as ten products."""
    ab = a * b
    cd = c * d
    over = real(1.0) / (ab * cd)
    left = over * cd
    right = over * ab
    return left * b, left * a, right * d, right * c


@wp.func
def solve(
    mu: real, w: real, x1: real, z1: real, x2: real, z2: real, on1: real, on2: real,
    u1: real, s1: real, u2: real, s2: real, n1: real, f1: real, n2: real, f2: real,
):  # fmt: skip
    """Impulses of the two corners by projected Gauss-Seidel; of one alone, exactly.

    Args:
        mu: Friction coefficient.
        w: Inverse inertia for unit mass [1/m^2].
        x1: Corner 1 from the centre of mass [m]; z1, x2, z2 likewise.
        on1: One where corner 1 is a contact, else zero; on2 likewise.
        u1: Normal velocity of corner 1 above its wish [m/s], without contact; u2 likewise.
        s1: Tangential velocity of corner 1 [m/s], without contact; s2 likewise.
        n1: First guess of the normal impulse of corner 1 [m/s]; f1, n2, f2 likewise.
    """
    one = real(1.0)
    # Rows of K over their diagonal; rows of an inactive corner vanish.
    wx1, wz1, wx2, wz2 = w * x1, w * z1, w * x2, w * z2
    d1, e1, d2, e2 = inverses(
        fused(wx1, x1, one), fused(wz1, z1, one), fused(wx2, x2, one), fused(wz2, z2, one)
    )
    d1 = on1 * d1
    e1 = on1 * e1
    d2 = on2 * d2
    e2 = on2 * e2
    n1n2 = fused(wx1, x2, one)
    f1f2 = fused(wz1, z2, one)
    n1f1 = -wx1 * z1
    n1f2 = -wx1 * z2
    n2f1 = -wx2 * z1
    n2f2 = -wx2 * z2
    r = Rows(
        mu,
        d1 * n1f1, d1 * n1n2, d1 * n1f2,
        e1 * n1f1, e1 * n2f1, e1 * f1f2,
        d2 * n1n2, d2 * n2f1, d2 * n2f2,
        e2 * n1f2, e2 * f1f2, e2 * n2f2,
        -d1 * u1, -e1 * s1, -d2 * u2, -e2 * s2,
    )  # fmt: skip
    first, second = on1 > on2, on2 > on1
    n, f = alone(
        mu, wp.where(first, r.a1, r.c3), wp.where(first, r.b1, r.g3),
        wp.where(first, r.u1, r.u2), wp.where(first, r.s1, r.s2),
    )  # fmt: skip
    n1 = n1 * on1
    f1 = f1 * on1
    n2 = n2 * on2
    f2 = f2 * on2
    n1, f1, n2, f2 = sweeps(r, n1, f1, n2, f2)
    return (
        wp.where(first, n, n1), wp.where(first, f, f1), wp.where(second, n, n2),
        wp.where(second, f, f2),
    )  # fmt: skip


@wp.func
def balanced(even: bool, n1: real, f1: real, n2: real, f2: real):
    """Impulses of both corners; of a block that leans to no side the mean of both orders."""
    n, f = HALF * (n1 + n2), HALF * (f1 - f2)
    return (
        wp.where(even, n, n1), wp.where(even, f, f1), wp.where(even, n, n2), wp.where(even, -f, f2)
    )  # fmt: skip


@wp.func
def step(
    block: Block, knobs: Knobs, dv: real,
    x: real, z: real, theta: real, vx: real, vz: real, omega: real,
    n1: real, f1: real, n2: real, f2: real, loss: real,
):  # fmt: skip
    """One step of one lane, in which the base velocity changes by dv [m/s].

    The arguments from `x` on are the lane's state, see the head of this file; the step returns
    it in the same order, the gap of the lower corner at its start [m], and the gaps after it of the
    -x and of the +x corner, along their velocities [m].
    """
    zero = real(0.0)
    w = block.inverse_inertia
    dt = knobs.time_step
    # Seen so that the block leans to +x: the solver then visits the corners of a mirrored scene
    # in mirrored order, and its remainder is mirrored too.
    slip = vx - dv
    lean = wp.where(theta != zero, theta, wp.where(omega != zero, omega, slip))
    m = sign_of(lean)
    s = sine(m * theta)
    c = cosine(theta)
    x1 = -dot(block.half_width, block.half_height, c, s)
    z1 = wedge(block.half_width, block.half_height, c, s)
    x2 = wedge(block.half_width, block.half_height, s, c)
    z2 = -dot(block.half_width, block.half_height, s, c)
    gap1 = z + z1
    gap2 = z + z2
    on1 = wp.where(gap1 <= knobs.collision_margin, real(1.0), zero)
    on2 = wp.where(gap2 <= knobs.collision_margin, real(1.0), zero)
    ux = m * slip
    uz = fused_less(dt, knobs.gravity, vz)
    uo = m * omega
    p1, t1, p2, t2 = solve(
        block.friction, w, x1, z1, x2, z2, on1, on2,
        fused_less(uo, x1, uz) - wish(gap1, knobs), fused(uo, z1, ux),
        fused_less(uo, x2, uz) - wish(gap2, knobs), fused(uo, z2, ux),
        wp.where(m < zero, n2, n1), m * wp.where(m < zero, f2, f1),
        wp.where(m < zero, n1, n2), m * wp.where(m < zero, f1, f2),
    )  # fmt: skip
    p1, t1, p2, t2 = balanced(lean == zero, p1, t1, p2, t2)
    vx1 = ux + t1 + t2
    vz1 = uz + p1 + p2
    vo1 = fused(w, wedge(z1, x1, p1, t1) + wedge(z2, x2, p2, t2), uo)
    # Work of the contact impulses on the mean velocity of their corners, a loss.
    mx, mz, mo = HALF * (m * vx + vx1), HALF * (vz + vz1), HALF * (uo + vo1)
    work1 = dot(p1, t1, fused_less(mo, x1, mz), fused(mo, z1, mx))
    work2 = dot(p2, t2, fused_less(mo, x2, mz), fused(mo, z2, mx))
    lowest = smaller(gap1, gap2)
    lift = -knobs.erp * smaller(lowest + real(2.0) * dt * dt * knobs.gravity, zero)
    ahead1 = fused(dt, fused_less(vo1, x1, vz1), gap1)
    ahead2 = fused(dt, fused_less(vo1, x2, vz1), gap2)
    vx1 = m * vx1
    vo1 = m * vo1
    return (
        fused(dt, vx1, x), fused(dt, vz1, z) + lift, fused(dt, vo1, theta), vx1, vz1, vo1,
        wp.where(m < zero, p2, p1), m * wp.where(m < zero, t2, t1),
        wp.where(m < zero, p1, p2), m * wp.where(m < zero, t1, t2),
        fused_less(knobs.gravity, lift, loss - work1 - work2), lowest,
        wp.where(m < zero, ahead2, ahead1), wp.where(m < zero, ahead1, ahead2),
    )  # fmt: skip
