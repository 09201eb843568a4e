"""Velocity-level contact step of a rocking block.

The block lives in the frame of the base: mass 1, centre of mass (x, z), clockwise rotation
theta, inertia I. Corner i sits at (X_i, Z_i) from the centre of mass, its gap is z + Z_i, its
velocity (vx + omega Z_i, vz - omega X_i). One step of length dt, semi-implicit Euler with the
velocities at half steps (so the release at t = 0 begins with half a step of gravity):

    1. v* = v + dt (0, -g) - (dv_base, 0), dv_base the change of the base velocity between the
       half steps, so that a velocity step of the base is carried exactly;
    2. corners with a gap below the collision margin are contacts. The normal velocity of each must
       be at least -gap / dt if it is open, so that it may close, else zero. The tangential velocity
       must be zero while |f| <= mu n (Coulomb);
    3. projected Gauss-Seidel on the four impulses p = (n1, f1, n2, f2), started from those of
       the last step: p_i = clamp(-(u_i + sum over j != i of K_ij p_j) / K_ii), where
       K = J M^-1 J^T and u_i is the velocity of row i by v*, less its least one. A single contact
       is solved exactly, see cone.py;
    4. v = v* + M^-1 J^T p, q = q + dt v. The block is lifted by erp times its penetration beyond
       2 g dt^2, the fall that one step can make; otherwise a resting block would never be still.
       (Correcting the penetration through the velocity would add energy that does not vanish with
       dt: the penetration of an impact is of the order of dt times the velocity.)

Impulses and energies are per unit mass. The loss is the energy lost so far [J/kg], less what
lifting by erp has given to the block.

Jean and Moreau (1992) for the scheme, Catto (2005) for the solver.
"""

import warp as wp

from warprock.kernels.contact.cone import solve_single_contact
from warprock.kernels.launch.instance import MAX_UNROLL
from warprock.kernels.shape.block import Gaps, State

ENDS_EARLY = ITERATIONS > MAX_UNROLL
"""Whether the sweeps end after one that changes nothing, since no later one would. Fewer sweeps are
unrolled without this exit, which would prevent vector code of the loop over lanes."""


@wp.struct
class Block:
    """The block of one lane."""

    half_width: real
    half_height: real
    inverse_inertia: real
    friction: real


@wp.struct
class Knobs:
    """Settings of a step; `rate` is the inverse of the time step [1/s]."""

    time_step: real
    rate: real
    gravity: real
    collision_margin: real
    erp: real


@wp.struct
class Impulses:
    """Normal and tangential impulses of the -x corner (1) and of the +x corner (2) [m/s]."""

    n1: real
    f1: real
    n2: real
    f2: real


@wp.struct
class Corner:
    """A corner at the start of a step.

    Attributes:
        x, z: From the centre of mass [m].
        on: 1 if it is a contact, else 0.
        u: Normal velocity without contact, less `least_normal_velocity` [m/s].
        s: Tangential velocity without contact [m/s].
    """

    x: real
    z: real
    on: real
    u: real
    s: real


@wp.func
def least_normal_velocity(gap: real, knobs: Knobs) -> real:
    """Least normal velocity of a corner after the step, by which an open gap may close [m/s]."""
    return -larger(gap, real(0.0)) * knobs.rate


@wp.struct
class Rows:
    """The four rows of the contact problem, each divided by its diagonal element.

    a1 to a3 are the off-diagonal elements of the row of n1, at f1, n2 and f2 in this order; b1 to
    b3 those of f1, c1 to c3 those of n2, g1 to g3 those of f2. u1, s1, u2, s2 are the right sides
    of the rows of n1, f1, n2 and f2 [m/s]. mu is the friction coefficient.
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
def sweep(r: Rows, p: Impulses) -> Impulses:
    """The impulses after one sweep over the four rows; the n1 before it does not matter."""
    # The value that is known last comes last in each row, so that other terms need not wait for it.
    n1 = larger(less_three(r.u1, r.a1, p.f1, r.a2, p.n2, r.a3, p.f2), real(0.0))
    bound = r.mu * n1
    f1 = larger(smaller(less_three(r.s1, r.b2, p.n2, r.b3, p.f2, r.b1, n1), bound), -bound)
    n2 = larger(less_three(r.u2, r.c3, p.f2, r.c1, n1, r.c2, f1), real(0.0))
    bound = r.mu * n2
    f2 = larger(smaller(less_three(r.s2, r.g1, n1, r.g2, f1, r.g3, n2), bound), -bound)
    return Impulses(n1, f1, n2, f2)


@wp.func
def sweeps(r: Rows, p: Impulses) -> Impulses:
    """The impulses after all sweeps."""
    if ENDS_EARLY:
        for _ in range(ITERATIONS):
            old = p
            p = sweep(r, old)
            if p.f1 == old.f1 and p.n2 == old.n2 and p.f2 == old.f2:
                break
    else:
        for _ in range(ITERATIONS):
            p = sweep(r, p)
    return p


@wp.func
def inverses(a: real, b: real, c: real, d: real):
    """Inverses of four numbers by one division: a division takes as long as ten products."""
    ab = a * b
    cd = c * d
    over = real(1.0) / (ab * cd)
    left = over * cd
    right = over * ab
    return left * b, left * a, right * d, right * c


@wp.func
def solve(mu: real, w: real, one: Corner, two: Corner, guess: Impulses) -> Impulses:
    """Impulses of the two corners by projected Gauss-Seidel; a single contact is solved exactly.

    Args:
        mu: Friction coefficient.
        w: Inverse inertia for unit mass [1/m^2].
        one, two: The corners.
        guess: First guess of the impulses.
    """
    unit = real(1.0)
    # Rows of K divided by their diagonal; the rows of an inactive corner are zero.
    wx1, wz1, wx2, wz2 = w * one.x, w * one.z, w * two.x, w * two.z
    d1, e1, d2, e2 = inverses(
        fused(wx1, one.x, unit), fused(wz1, one.z, unit),
        fused(wx2, two.x, unit), fused(wz2, two.z, unit),
    )  # fmt: skip
    d1 = one.on * d1
    e1 = one.on * e1
    d2 = two.on * d2
    e2 = two.on * e2
    n1n2 = fused(wx1, two.x, unit)
    f1f2 = fused(wz1, two.z, unit)
    n1f1 = -wx1 * one.z
    n1f2 = -wx1 * two.z
    n2f1 = -wx2 * one.z
    n2f2 = -wx2 * two.z
    r = Rows(
        mu,
        d1 * n1f1, d1 * n1n2, d1 * n1f2,
        e1 * n1f1, e1 * n2f1, e1 * f1f2,
        d2 * n1n2, d2 * n2f1, d2 * n2f2,
        e2 * n1f2, e2 * f1f2, e2 * n2f2,
        -d1 * one.u, -e1 * one.s, -d2 * two.u, -e2 * two.s,
    )  # fmt: skip
    first, second = one.on > two.on, two.on > one.on
    n, f = solve_single_contact(
        mu, wp.where(first, r.a1, r.c3), wp.where(first, r.b1, r.g3),
        wp.where(first, r.u1, r.u2), wp.where(first, r.s1, r.s2),
    )  # fmt: skip
    p = sweeps(
        r, Impulses(guess.n1 * one.on, guess.f1 * one.on, guess.n2 * two.on, guess.f2 * two.on)
    )
    return Impulses(
        wp.where(first, n, p.n1), wp.where(first, f, p.f1),
        wp.where(second, n, p.n2), wp.where(second, f, p.f2),
    )  # fmt: skip


@wp.func
def balance(even: bool, p: Impulses) -> Impulses:
    """Impulses of both corners; for a block that does not lean, the mean of both orders."""
    n, f = HALF * (p.n1 + p.n2), HALF * (p.f1 - p.f2)
    return Impulses(
        wp.where(even, n, p.n1), wp.where(even, f, p.f1),
        wp.where(even, n, p.n2), wp.where(even, -f, p.f2),
    )  # fmt: skip


@wp.func
def mirror(side: real, p: Impulses) -> Impulses:
    """Impulses, reflected if `side` is -1."""
    swap = side < real(0.0)
    return Impulses(
        wp.where(swap, p.n2, p.n1), side * wp.where(swap, p.f2, p.f1),
        wp.where(swap, p.n1, p.n2), side * wp.where(swap, p.f1, p.f2),
    )  # fmt: skip


@wp.func
def step(
    block: Block, knobs: Knobs, dv: real, state: State, before: Impulses, loss: wp.ref[real]
):  # fmt: skip
    """One step of one lane, in which the base velocity changes by dv [m/s].

    `before` has the impulses of the last step. The step adds its own loss, see the head of this
    file. Returns the state, the impulses and the gaps.
    """
    zero = real(0.0)
    w = block.inverse_inertia
    dt = knobs.time_step
    # Reflected so that the block leans to +x. So the solver visits the corners of a mirrored scene
    # in mirrored order, and its residual is mirrored, too.
    slip = state.vx - dv
    lean = wp.where(
        state.theta != zero, state.theta, wp.where(state.omega != zero, state.omega, slip)
    )
    m = sign_of(lean)
    s = sine(m * state.theta)
    c = cosine(state.theta)
    x1 = -dot(block.half_width, block.half_height, c, s)
    z1 = wedge(block.half_width, block.half_height, c, s)
    x2 = wedge(block.half_width, block.half_height, s, c)
    z2 = -dot(block.half_width, block.half_height, s, c)
    gap1 = state.z + z1
    gap2 = state.z + z2
    on1 = wp.where(gap1 <= knobs.collision_margin, real(1.0), zero)
    on2 = wp.where(gap2 <= knobs.collision_margin, real(1.0), zero)
    ux = m * slip
    uz = fused_less(dt, knobs.gravity, state.vz)
    uo = m * state.omega
    one = Corner(
        x1, z1, on1, fused_less(uo, x1, uz) - least_normal_velocity(gap1, knobs), fused(uo, z1, ux)
    )
    two = Corner(
        x2, z2, on2, fused_less(uo, x2, uz) - least_normal_velocity(gap2, knobs), fused(uo, z2, ux)
    )
    p = balance(lean == zero, solve(block.friction, w, one, two, mirror(m, before)))
    vx1 = ux + p.f1 + p.f2
    vz1 = uz + p.n1 + p.n2
    vo1 = fused(w, wedge(z1, x1, p.n1, p.f1) + wedge(z2, x2, p.n2, p.f2), uo)
    # Loss: minus the work of the contact impulses on the mean velocities of their corners.
    mx, mz, mo = HALF * (m * state.vx + vx1), HALF * (state.vz + vz1), HALF * (uo + vo1)
    work1 = dot(p.n1, p.f1, fused_less(mo, x1, mz), fused(mo, z1, mx))
    work2 = dot(p.n2, p.f2, fused_less(mo, x2, mz), fused(mo, z2, mx))
    lowest = smaller(gap1, gap2)
    lift = -knobs.erp * smaller(lowest + real(2.0) * dt * dt * knobs.gravity, zero)
    loss = fused_less(knobs.gravity, lift, loss - work1 - work2)
    ahead1 = fused(dt, fused_less(vo1, x1, vz1), gap1)
    ahead2 = fused(dt, fused_less(vo1, x2, vz1), gap2)
    gaps = Gaps(lowest, wp.where(m < zero, ahead2, ahead1), wp.where(m < zero, ahead1, ahead2))
    vx1 = m * vx1
    vo1 = m * vo1
    after = State(
        fused(dt, vx1, state.x), fused(dt, vz1, state.z) + lift, fused(dt, vo1, state.theta),
        vx1, vz1, vo1,
    )  # fmt: skip
    return after, mirror(m, p), gaps
