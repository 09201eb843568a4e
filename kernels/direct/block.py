"""Compliant contact step of a rocking block with an exact solve.

The block lives in the frame of the base: mass 1, centre of mass (x, z), clockwise rotation theta,
inverse inertia w. Corner i sits at (X_i, Z_i) from the centre of mass, its gap is z + Z_i, its
velocity across the base vz - omega X_i. Under each corner stand a spring k and a dashpot c that
push only. Backward Euler over a step h, with a velocity after the step v+ and a normal impulse n:

    n = -h (k gap+ + c v+),  gap+ = gap + h v+   while the corner touches, or, solved for v+,
    v+ + ERP gap / h + CFM n = 0,   CFM = 1 / (h (h k + c)),   ERP = h k / (h k + c)    (Eq. 13).

A corner touches where its gap is not wider than 2 g h^2, what one step of falling can make. Of
such a gap that is still open all is to close, v+ + gap / h + CFM n = 0: the spring and the
dashpot work on the penetration. A step solves

    1. u = v + h (0, -g) - (dv_base, 0), dv_base the change of the base velocity between the half
       steps at which velocities are kept, so that a velocity step of the base is carried exactly;
    2. w_i = v+_i + ERP gap_i / h + CFM n_i >= 0,  n_i >= 0,  w_i n_i = 0 for both corners, and
       Coulomb's law for the slip s = vx + omega Z of the lower corner: the friction f of the face
       has |f| <= bound, s = 0 inside the bound, f against s on it. The bound is friction (n_1 +
       n_2), the exact cone of a planar contact, or friction times that sum of the last step (box);
    3. v+ = u + M^-1 J^T (n_1, n_2, f), q+ = q + h v+.

One friction for the face and not one for each corner: of two corners on one face of a rigid block
the shares could not be told apart, and their levers differ by 2 b sin(theta) while both touch.

The solve is exact: it takes each way to touch in turn (no corner; either one or both, sticking or
sliding to either side), solves its linear equations, and keeps the one whose residual in step 2 is
round-off. With a box the matrix is positive definite and there is no other solution. With a cone
there is always one (Anitescu and Potra 1997); where there are more (Painleve), the first is taken.

What keeps the error of impacts small: a corner lands in the middle of a step and is noticed at
its end, so that on average over many impacts the weight turns the block the right time before and
after (a corner that was kept from landing would start to brake a step early, and the block would
lose an angular velocity of the order of h with every impact). It is then through by up to h times
its velocity V. With ERP = 1 that would come back as a velocity V, an impact with energy to spare
however short the step; with a relaxation time c / k of many steps it comes back slowly, as a
velocity V h k / c that vanishes with h.

A lane's state: x along the base from where the block would rest [m], z above the base [m], theta
[rad]; vx, vz [m/s] and omega [rad/s] relative to the base; the normal impulses n1 of the -x and n2
of the +x corner in the last step, per unit mass [m/s]; loss, what the contacts have taken from the
energy so far per unit mass [J/kg].
"""

import warp as wp

ROUND_OFF = by_precision(1.0e-12, 1.0e-4)
"""Residual that counts as none, over the velocities that the solve starts from."""


@wp.struct
class Block:
    """What a step needs to know of one lane's block; stiffness [1/s^2] for unit mass."""

    half_width: real
    half_height: real
    inverse_inertia: real
    friction: real
    stiffness: real
    cfm: real
    erp: real


@wp.struct
class Knobs:
    """What a step needs to know of the settings.

    `rate` is the inverse of the time step [1/s], `margin` the gap up to which a corner touches
    [m], `box` 1 for the box, 0 for the cone.
    """

    time_step: real
    rate: real
    gravity: real
    margin: real
    box: real


@wp.func
def wish(gap: real, erp: real, rate: real) -> real:
    """ERP gap / h of a corner [m/s]."""
    return rate * gap * wp.where(gap > real(0.0), real(1.0), erp)


@wp.func
def residual(
    mu: real, bound: real, k11: real, k12: real, k22: real, k13: real, k23: real, k33: real,
    q1: real, q2: real, q3: real, n1: real, n2: real, f: real,
) -> real:  # fmt: skip
    """By how much impulses miss the laws of step 2 [m/s]; arguments as in `solve`."""
    w1 = fused(k13, f, fused(k12, n2, fused(k11, n1, q1)))
    w2 = fused(k23, f, fused(k22, n2, fused(k12, n1, q2)))
    slip = fused(k33, f, fused(k23, n2, fused(k13, n1, q3)))
    limit = k33 * fused(mu, n1 + n2, bound)
    push = k33 * f
    drag = push - larger(smaller(push - slip, limit), -limit)
    return larger(larger(size(smaller(k11 * n1, w1)), size(smaller(k22 * n2, w2))), size(drag))


@wp.func
def better(
    mu: real, bound: real, k11: real, k12: real, k22: real, k13: real, k23: real, k33: real,
    q1: real, q2: real, q3: real, a: real, b1: real, b2: real, slack: real,
    miss: real, n1: real, n2: real, f: real,
):  # fmt: skip
    """The best of the impulses so far and of three ways to touch: corner 1, corner 2, both.

    Args:
        mu: As in `solve`, up to q3.
        a: The friction is a + b1 n1 + b2 n2; b1, b2 likewise.
        slack: Residual that counts as none [m/s].
        miss: What the residual of the impulses so far has beyond the slack [m/s].
        n1: The impulses so far; n2, f likewise.
    """
    zero = real(0.0)
    one = real(1.0)
    a11 = fused(k13, b1, k11)
    a12 = fused(k13, b2, k12)
    a21 = fused(k23, b1, k12)
    a22 = fused(k23, b2, k22)
    p1 = fused(k13, a, q1)
    p2 = fused(k23, a, q2)
    scale = one / fused_less(a12, a21, a11 * a22)
    n1_only = -p1 / a11
    n2_only = -p2 / a22
    n1_both = scale * fused_less(a22, p1, a12 * p2)
    n2_both = scale * fused_less(a11, p2, a21 * p1)
    f1 = fused(b1, n1_only, a)
    f2 = fused(b2, n2_only, a)
    f_both = fused(b2, n2_both, fused(b1, n1_both, a))
    miss1 = larger(
        residual(mu, bound, k11, k12, k22, k13, k23, k33, q1, q2, q3, n1_only, zero, f1) - slack,
        zero,
    )
    miss2 = larger(
        residual(mu, bound, k11, k12, k22, k13, k23, k33, q1, q2, q3, zero, n2_only, f2) - slack,
        zero,
    )
    miss_both = larger(
        residual(mu, bound, k11, k12, k22, k13, k23, k33, q1, q2, q3, n1_both, n2_both, f_both)
        - slack,
        zero,
    )
    n1 = wp.where(miss1 < miss, n1_only, n1)
    n2 = wp.where(miss1 < miss, zero, n2)
    f = wp.where(miss1 < miss, f1, f)
    miss = smaller(miss1, miss)
    n1 = wp.where(miss2 < miss, zero, n1)
    n2 = wp.where(miss2 < miss, n2_only, n2)
    f = wp.where(miss2 < miss, f2, f)
    miss = smaller(miss2, miss)
    n1 = wp.where(miss_both < miss, n1_both, n1)
    n2 = wp.where(miss_both < miss, n2_both, n2)
    f = wp.where(miss_both < miss, f_both, f)
    return smaller(miss_both, miss), n1, n2, f


@wp.func
def solve(
    mu: real, bound: real, k11: real, k12: real, k22: real, k13: real, k23: real, k33: real,
    q1: real, q2: real, q3: real,
):  # fmt: skip
    """Impulses of both corners and of the face, exactly.

    Args:
        mu: Friction coefficient of the cone, 0 with a box.
        bound: Largest friction of the box [m/s], 0 with a cone.
        k11: Rows of J M^-1 J^T, the CFM in the diagonal of the corners; 3 is the friction.
        q1: Velocity of corner 1 above its wish, without contact [m/s]; q2 likewise.
        q3: Slip without contact [m/s].

    Returns:
        What the residual has beyond round-off [m/s]; n1, n2 and the friction [m/s].
    """
    zero = real(0.0)
    one = real(1.0)
    hold = one / k33
    slack = ROUND_OFF * (size(q1) + size(q2) + size(q3))
    n1 = zero
    n2 = zero
    f = larger(smaller(-hold * q3, bound), -bound)
    miss = larger(
        residual(mu, bound, k11, k12, k22, k13, k23, k33, q1, q2, q3, n1, n2, f) - slack, zero
    )
    miss, n1, n2, f = better(
        mu, bound, k11, k12, k22, k13, k23, k33, q1, q2, q3,
        -hold * q3, -hold * k13, -hold * k23, slack, miss, n1, n2, f,
    )  # fmt: skip
    miss, n1, n2, f = better(
        mu, bound, k11, k12, k22, k13, k23, k33, q1, q2, q3,
        bound, mu, mu, slack, miss, n1, n2, f,
    )  # fmt: skip
    miss, n1, n2, f = better(
        mu, bound, k11, k12, k22, k13, k23, k33, q1, q2, q3,
        -bound, -mu, -mu, slack, miss, n1, n2, f,
    )  # fmt: skip
    return miss, n1, n2, f


@wp.func
def corners(block: Block, s: real, c: real):
    """Where the -x and the +x corner are from the centre of mass: x, z, x, z [m]."""
    b, deep, aside = block.half_width, block.half_height * c, block.half_height * s
    return (
        fused_less(b, c, -aside), fused(b, s, -deep), fused(b, c, -aside), fused_less(b, s, -deep),
    )  # fmt: skip


@wp.func
def work_of(
    p1: real, p2: real, f: real, x1: real, x2: real, z2: real, mx: real, mz: real, mo: real,
) -> real:  # fmt: skip
    """Work of the contact impulses on the mean velocities where they act [J/kg], a loss."""
    pressed = fused(p1, fused_less(mo, x1, mz), p2 * fused_less(mo, x2, mz))
    return fused(f, fused(mo, z2, mx), pressed)


@wp.func
def step(
    block: Block, knobs: Knobs, dv: real,
    x: real, z: real, theta: real, vx: real, vz: real, omega: real,
    n1: real, n2: real, loss: real,
):  # fmt: skip
    """One step of one lane, in which the base velocity changes by dv [m/s].

    The arguments from `x` on are the lane's state, see the head of this file; the step returns
    it in the same order, what `solve` missed, the gap of the lower corner at its start [m], and the
    gaps after it of the -x and of the +x corner, along their velocities [m].
    """
    zero, one = real(0.0), real(1.0)
    w, dt = block.inverse_inertia, knobs.time_step
    # Seen so that the block leans to +x: a mirrored scene is solved by the same numbers.
    lean = wp.where(theta != zero, theta, wp.where(omega != zero, omega, -dv))
    m = sign_of(lean)
    s = sine(m * theta)
    c = cosine(theta)
    x1, z1, x2, z2 = corners(block, s, c)
    gap1 = z + z1
    gap2 = z + z2
    ux = m * (vx - dv)
    uz = fused_less(dt, knobs.gravity, vz)
    uo = m * omega
    mu = block.friction
    lowest = smaller(gap1, gap2)
    touches = lowest <= knobs.margin
    bound = wp.where(touches, larger(knobs.box * mu * (n1 + n2), zero), zero)
    on1 = wp.where(gap1 <= knobs.margin, one, zero)
    on2 = wp.where(gap2 <= knobs.margin, one, zero)
    miss, p1, p2, f = solve(
        (one - knobs.box) * mu, bound,
        fused(w * x1, x1, one + block.cfm), on1 * on2 * fused(w * x1, x2, one),
        fused(w * x2, x2, one + block.cfm),
        -on1 * w * x1 * z2, -on2 * w * x2 * z2, fused(w * z2, z2, one),
        on1 * fused_less(uo, x1, uz + wish(gap1, block.erp, knobs.rate)),
        on2 * fused_less(uo, x2, uz + wish(gap2, block.erp, knobs.rate)),
        fused(uo, z2, ux),
    )  # fmt: skip
    vx1 = ux + f
    vz1 = uz + p1 + p2
    vo1 = fused(w, fused(f, z2, fused_less(p1, x1, -p2 * x2)), uo)
    work = work_of(
        p1, p2, f, x1, x2, z2,
        HALF * (m * vx + vx1), HALF * (vz + vz1), HALF * (uo + vo1),
    )  # fmt: skip
    # A height that is too coarse to take up what the velocity adds, as at rest in float32, has not
    # won its weight; without round-off this is nothing.
    risen = fused(dt, vz1, z)
    work = fused(knobs.gravity, fused_less(dt, vz1, risen - z), work)
    ahead1 = fused(dt, fused_less(vo1, x1, vz1), gap1)
    ahead2 = fused(dt, fused_less(vo1, x2, vz1), gap2)
    vx1 = m * vx1
    vo1 = m * vo1
    return (
        fused(dt, vx1, x), risen, fused(dt, vo1, theta), vx1, vz1, vo1,
        wp.where(m < zero, p2, p1), wp.where(m < zero, p1, p2), loss - work, miss,
        lowest, wp.where(m < zero, ahead2, ahead1), wp.where(m < zero, ahead1, ahead2),
    )  # fmt: skip
