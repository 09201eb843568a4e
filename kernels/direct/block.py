"""Compliant contact step of a rocking block with an exact solve.

The block lives in the frame of the base: mass 1, centre of mass (x, z), clockwise rotation theta,
inverse inertia w. Corner i sits at (X_i, Z_i) from the centre of mass, its gap is z + Z_i, its
velocity across the base vz - omega X_i. Under each corner stand a spring k and a dashpot c that
push only. Backward Euler over a step h, with a velocity after the step v+ and a normal impulse n:

    n = -h (k gap+ + c v+),  gap+ = gap + h v+   while the corner touches, or, solved for v+,
    v+ + ERP gap / h + CFM n = 0,   CFM = 1 / (h (h k + c)),   ERP = h k / (h k + c)    (Eq. 13).

A corner touches if its gap is at most 2 g h^2, the fall that one step can make. An open gap of this
kind closes as a whole, v+ + gap / h + CFM n = 0; the spring and the dashpot act on the penetration.
A step solves

    1. u = v + h (0, -g) - (dv_base, 0), dv_base the change of the base velocity between the half
       steps at which velocities are kept, so that a velocity step of the base is carried exactly;
    2. w_i = v+_i + ERP gap_i / h + CFM n_i >= 0,  n_i >= 0,  w_i n_i = 0 for both corners, and
       Coulomb's law for the slip s = vx + omega Z of the lower corner: the friction f of the face
       has |f| <= bound, s = 0 inside the bound, f against s on it. The bound is friction (n_1 +
       n_2), the exact cone of a planar contact, or friction times that sum of the last step (box);
    3. v+ = u + M^-1 J^T (n_1, n_2, f), q+ = q + h v+.

There is one friction for the face and not one for each corner. The shares of two corners on one
face of a rigid block are not unique, and their levers differ by only 2 b sin(theta) while both
touch.

The solve is exact. It takes each contact state in turn (no corner; either one or both, sticking or
sliding to either side), solves its linear equations, and keeps the one whose residual in step 2 is
round-off. With a box the matrix is positive definite and the solution unique. With a cone there is
always a solution (Anitescu and Potra 1997); if there are several (Painleve), the first is taken.

Two things keep the error of impacts small. First, a corner lands inside a step, and contact begins
at its end. On average over many impacts, gravity then turns the block for the right time before
and after. (If the corner were kept from landing, it would brake a step too early, and the block
would lose an angular velocity of the order of h in every impact.) Second, the penetration of that
step, up to h times the velocity V of the corner, comes back slowly. With ERP = 1 it would come back
as a velocity V, an impact that adds energy however short the step. With a relaxation time c / k of
many steps it comes back as a velocity V h k / c, which vanishes with h.

Impulses and energies are per unit mass.
"""

import warp as wp

from warprock.kernels.shape.block import Gaps, State

ROUND_OFF = by_precision(1.0e-12, 1.0e-4)
"""Residual that counts as round-off, over the velocities at the start of the solve."""


@wp.struct
class Block:
    """The block of one lane; stiffness [1/s^2] for unit mass."""

    half_width: real
    half_height: real
    inverse_inertia: real
    friction: real
    stiffness: real
    cfm: real
    erp: real


@wp.struct
class Knobs:
    """Settings of a step.

    `rate` is the inverse of the time step [1/s], `margin` the gap up to which a corner touches
    [m], `box` 1 for the box, 0 for the cone.
    """

    time_step: real
    rate: real
    gravity: real
    margin: real
    box: real


@wp.struct
class Carried:
    """Normal impulses of the -x corner and of the +x corner [m/s]."""

    n1: real
    n2: real


@wp.struct
class Impulses:
    """Impulses that may solve a `Problem` [m/s].

    Attributes:
        n1, n2: Normal impulses of corners 1 and 2.
        f: Friction impulse of the face.
        miss: Residual of the laws of step 2, beyond round-off.
    """

    n1: real
    n2: real
    f: real
    miss: real


@wp.struct
class Problem:
    """The contact problem of step 2.

    Attributes:
        mu: Friction coefficient of the cone, 0 with a box.
        bound: Largest friction of the box [m/s], 0 with a cone.
        k11, k12, k22, k13, k23, k33: J M^-1 J^T, the CFM in the diagonal of the corners; 3 is the
            friction.
        q1, q2: Velocities of corners 1 and 2 without contact, plus `allowed_closing` [m/s].
        q3: Slip without contact [m/s].
    """

    mu: real
    bound: real
    k11: real
    k12: real
    k22: real
    k13: real
    k23: real
    k33: real
    q1: real
    q2: real
    q3: real


@wp.struct
class Friction:
    """Friction a + b1 n1 + b2 n2 of a face that sticks, or slides to one side; a in [m/s]."""

    a: real
    b1: real
    b2: real


@wp.func
def allowed_closing(gap: real, erp: real, rate: real) -> real:
    """Velocity at which a corner may close, ERP gap / h; of an open gap, gap / h [m/s]."""
    return rate * gap * wp.where(gap > real(0.0), real(1.0), erp)


@wp.func
def residual_of(c: Problem, n1: real, n2: real, f: real) -> real:
    """Residual of the laws of step 2 for given impulses [m/s]."""
    w1 = fused(c.k13, f, fused(c.k12, n2, fused(c.k11, n1, c.q1)))
    w2 = fused(c.k23, f, fused(c.k22, n2, fused(c.k12, n1, c.q2)))
    slip = fused(c.k33, f, fused(c.k23, n2, fused(c.k13, n1, c.q3)))
    limit = c.k33 * fused(c.mu, n1 + n2, c.bound)
    push = c.k33 * f
    drag = push - larger(smaller(push - slip, limit), -limit)
    return larger(larger(size(smaller(c.k11 * n1, w1)), size(smaller(c.k22 * n2, w2))), size(drag))


@wp.func
def impulses_of(c: Problem, round_off: real, n1: real, n2: real, f: real) -> Impulses:
    """Impulses with their residual beyond round-off [m/s]."""
    return Impulses(n1, n2, f, larger(residual_of(c, n1, n2, f) - round_off, real(0.0)))


@wp.func
def better_of(one: Impulses, two: Impulses) -> Impulses:
    """The impulses with the smaller residual; the second ones if both are equal."""
    first = one.miss < two.miss
    return Impulses(
        wp.where(first, one.n1, two.n1), wp.where(first, one.n2, two.n2),
        wp.where(first, one.f, two.f), smaller(one.miss, two.miss),
    )  # fmt: skip


@wp.func
def try_friction(c: Problem, law: Friction, round_off: real, best: Impulses) -> Impulses:
    """The best of the impulses so far and of three contact states: corner 1, corner 2, both."""
    zero = real(0.0)
    a11 = fused(c.k13, law.b1, c.k11)
    a12 = fused(c.k13, law.b2, c.k12)
    a21 = fused(c.k23, law.b1, c.k12)
    a22 = fused(c.k23, law.b2, c.k22)
    p1 = fused(c.k13, law.a, c.q1)
    p2 = fused(c.k23, law.a, c.q2)
    scale = real(1.0) / fused_less(a12, a21, a11 * a22)
    n1 = -p1 / a11
    one = impulses_of(c, round_off, n1, zero, fused(law.b1, n1, law.a))
    n2 = -p2 / a22
    two = impulses_of(c, round_off, zero, n2, fused(law.b2, n2, law.a))
    m1 = scale * fused_less(a22, p1, a12 * p2)
    m2 = scale * fused_less(a11, p2, a21 * p1)
    both = impulses_of(c, round_off, m1, m2, fused(law.b2, m2, fused(law.b1, m1, law.a)))
    return better_of(both, better_of(two, better_of(one, best)))


@wp.func
def solve_contacts(c: Problem) -> Impulses:
    """Impulses of both corners and of the face, exactly."""
    hold = real(1.0) / c.k33
    round_off = ROUND_OFF * (size(c.q1) + size(c.q2) + size(c.q3))
    zero = real(0.0)
    best = impulses_of(
        c, round_off, zero, zero, larger(smaller(-hold * c.q3, c.bound), -c.bound)
    )  # fmt: skip
    sticks = Friction(-hold * c.q3, -hold * c.k13, -hold * c.k23)
    best = try_friction(c, sticks, round_off, best)
    best = try_friction(c, Friction(c.bound, c.mu, c.mu), round_off, best)
    return try_friction(c, Friction(-c.bound, -c.mu, -c.mu), round_off, best)


@wp.func
def corners(block: Block, s: real, c: real):
    """Levers from the centre of mass to the -x and the +x corner: x, z, x, z [m]."""
    b, deep, aside = block.half_width, block.half_height * c, block.half_height * s
    return (
        fused_less(b, c, -aside), fused(b, s, -deep), fused(b, c, -aside), fused_less(b, s, -deep),
    )  # fmt: skip


@wp.func
def step(
    block: Block, knobs: Knobs, dv: real, state: State, before: Carried, loss: wp.ref[real]
):  # fmt: skip
    """One step of one lane, in which the base velocity changes by dv [m/s].

    `before` has the impulses of the last step. The step adds the energy that its contacts take to
    the loss [J/kg]. Returns the state, the impulses of the corners, the gaps, and the residual of
    the solve [m/s].
    """
    zero, one = real(0.0), real(1.0)
    w, dt = block.inverse_inertia, knobs.time_step
    # Reflected so that the block leans to +x: a mirrored scene has the same numbers.
    lean = wp.where(
        state.theta != zero, state.theta, wp.where(state.omega != zero, state.omega, -dv)
    )
    m = sign_of(lean)
    s = sine(m * state.theta)
    c = cosine(state.theta)
    x1, z1, x2, z2 = corners(block, s, c)
    gap1 = state.z + z1
    gap2 = state.z + z2
    ux = m * (state.vx - dv)
    uz = fused_less(dt, knobs.gravity, state.vz)
    uo = m * state.omega
    mu = block.friction
    lowest = smaller(gap1, gap2)
    touches = lowest <= knobs.margin
    bound = wp.where(touches, larger(knobs.box * mu * (before.n1 + before.n2), zero), zero)
    on1 = wp.where(gap1 <= knobs.margin, one, zero)
    on2 = wp.where(gap2 <= knobs.margin, one, zero)
    p = solve_contacts(Problem(
        (one - knobs.box) * mu, bound,
        fused(w * x1, x1, one + block.cfm), on1 * on2 * fused(w * x1, x2, one),
        fused(w * x2, x2, one + block.cfm),
        -on1 * w * x1 * z2, -on2 * w * x2 * z2, fused(w * z2, z2, one),
        on1 * fused_less(uo, x1, uz + allowed_closing(gap1, block.erp, knobs.rate)),
        on2 * fused_less(uo, x2, uz + allowed_closing(gap2, block.erp, knobs.rate)),
        fused(uo, z2, ux),
    ))  # fmt: skip
    vx1 = ux + p.f
    vz1 = uz + p.n1 + p.n2
    vo1 = fused(w, fused(p.f, z2, fused_less(p.n1, x1, -p.n2 * x2)), uo)
    # Loss: minus the work of the contact impulses on the mean velocities of their points.
    mx, mz, mo = HALF * (m * state.vx + vx1), HALF * (state.vz + vz1), HALF * (uo + vo1)
    pressed = fused(p.n1, fused_less(mo, x1, mz), p.n2 * fused_less(mo, x2, mz))
    work = fused(p.f, fused(mo, z2, mx), pressed)
    # If the height is too coarse to change by the velocity, as at rest in float32, the block gains
    # no potential energy. Without round-off this term is zero.
    risen = fused(dt, vz1, state.z)
    loss = loss - fused(knobs.gravity, fused_less(dt, vz1, risen - state.z), work)
    ahead1 = fused(dt, fused_less(vo1, x1, vz1), gap1)
    ahead2 = fused(dt, fused_less(vo1, x2, vz1), gap2)
    gaps = Gaps(lowest, wp.where(m < zero, ahead2, ahead1), wp.where(m < zero, ahead1, ahead2))
    carried = Carried(wp.where(m < zero, p.n2, p.n1), wp.where(m < zero, p.n1, p.n2))
    vx1 = m * vx1
    vo1 = m * vo1
    after = State(fused(dt, vx1, state.x), risen, fused(dt, vo1, state.theta), vx1, vz1, vo1)
    return after, carried, gaps, p.miss
