"""Position-level contact step of a stack of rocking blocks (XPBD).

Bodies are numbered from the ground: body 0 is the ground, an endless flat face that nothing moves,
body k the k-th block. A body has its centre of mass at (x, z), in the frame of the base, the half
width `half_width` and the half height `half_height` [m], the clockwise rotation theta [rad] with
its sine s and cosine c, the inverse mass m [1/kg] and moment of inertia j [1/(kg m^2)], and the
velocity (vx, vz) [m/s], omega [rad/s]. Interface k, below block k, touches at the two ends of the
overlap of the upper block's bottom face and the lower one's top face: a corner of one body on the
face of the other. Of the two bodies of an interface the lower one's names begin with l.

One sub-step of length h:

    1. predict: velocity v* = v + h (0, -g) - (dv_base, 0) and pose q* = q + h v*;
    2. the ends whose gap at q is at most g h^2, a step's fall, are contacts. Their gaps and their
       places along the faces are taken at q and at q*, exactly; their gradients J at q;
    3. both passes are `iterations` Gauss-Seidel sweeps over the contacts, each of which corrects
       the two bodies of its interface by M^-1 J^T times its multipliers n, t [kg m] (impulses are
       n / h, t / h). They share the rows and differ in what these ask for:
           velocity pass:  growth of the gap from q = 0,  slip from q = 0
           pose pass:      gap + (alpha / h^2) n = 0,     distance from the anchor = 0
       or more than that with n = 0; and |t| <= mu n. alpha is the compliance of one contact
       [m/N]. The velocity pass starts from its last multipliers, the pose pass from the new ones;
    4. v(n + 1) = v* + correction of the velocity pass / h, q(n + 1) = q* + that of the pose pass.

The velocity pass is restitution zero: without it v would be (q(n + 1) - q(n)) / h. That it comes
first makes it a start for the poses; neither pass depends on the other's result. The anchor is the
place where an end came to stick; it goes when the pose pass slips there or the end opens.

How it comes to rigid contact, at first order:

- Growth and slip are differences of exact poses, so that v is the chord of the motion, and J is
  taken where the force acts: between impacts both passes agree, and the scheme is SHAKE, of second
  order. (With J at q* it would be of first order everywhere; with J v for the growth of a gap a
  turn about a corner would be braked at every step.)
- At an impact a corner goes through the face, for it is no contact until the sub-step after. That
  one pushes it out by M^-1 J^T, which moves the pose to where a block would be that had met the
  face in time. Divided by h that push would be a velocity that does not vanish with h, a bounce;
  the velocity pass leaves the plastic impulse alone, which is Housner's.
- What stays is of the order of h: the old corner carries until the end of the sub-step of the
  impact, wherever in it the impact was; half a sub-step too long or too short, nothing in the mean.
  (Stopped at the face, a corner would take over too early, by a sub-step in the mean.)
- Compliance presses poses in and leaves velocities alone: impacts are plastic at any. At rest an
  end is pressed in by alpha times its force; it gets there as an overdamped spring, in a time of
  about alpha m / h, so that a contact is the more rigid the smaller h is, and both limits, h -> 0
  and alpha -> 0, may be taken in any order.
- Sweeps that end early leave gaps and slips. Those come back in the next step, because gaps are
  absolute and an end that sticks keeps its anchor: what the sweeps reduce stays reduced. (With
  slip counted from the start of each sub-step alone, tall stacks creep and their errors grow.)

Macklin, Mueller and Chentanez (2016) for compliance, Macklin et al. (2019) for sub-steps, Mueller
et al. (2020) for rigid bodies and the velocity pass; Ryckaert, Ciccotti and Berendsen (1977) for
SHAKE.
"""

import warp as wp

from warprock.kernels.cone import alone
from warprock.kernels.xpbd.stack_ground import TURNS_ON_GROUND, solve_on_ground

if BLOCKS == 1:
    from warprock.kernels.xpbd.stack_ground import add_impulses, find_end
else:
    from warprock.kernels.shape.interface_flat import add_impulses, find_end

LOOSE = real(1.0e30)
"""Anchor of an end that has slipped or opened: none."""
TURNS = TURNS_ON_GROUND if BLOCKS == 1 else 1
"""Sweeps over an interface before the next one is visited: a single block has no other."""


@wp.struct
class Knobs:
    """What a step needs to know of the settings; `rate` is the inverse of the time step [1/s].

    `softness` is the compliance over the square of the time step [1/kg].
    """

    time_step: real
    rate: real
    gravity: real
    softness: real


@wp.func
def predict(
    dv: real, hint: real, knobs: Knobs, ltheta: real, lomega: real, theta: real, omega: real,
    vx: wp.ref[real], vz: wp.ref[real], ps: wp.ref[real], pc: wp.ref[real],
    qx: wp.ref[real], qz: wp.ref[real], qo: wp.ref[real], lean: wp.ref[real],
    n1: wp.ref[real], t1: wp.ref[real], anchor1: wp.ref[real],
    n2: wp.ref[real], t2: wp.ref[real], anchor2: wp.ref[real],
):  # fmt: skip
    """Predicts the velocity and the rotation of a block; its interface in the order of its lean.

    Args:
        dv: Change of the base velocity in the step [m/s].
        hint: What it does or is about to do, for the lean of what does not move yet [m/s].
        knobs: Settings.
        ltheta, lomega: Rotation of what the block stands on [rad] and its angular velocity [rad/s].
        theta, omega: Rotation of the block [rad] and its angular velocity [rad/s].
        vx, vz: Its velocity, then the predicted one [m/s].
        ps, pc: Sine of the predicted rotation and its cosine.
        qx, qz, qo: Correction of the predicted pose, none so far.
        lean: Side to which the interface leaned before, then the one of this step: -1 or 1.
        n1, t1, anchor1, n2, t2, anchor2: Normal and tangential multiplier and anchor of the end
            visited first, away from the lean, and of the other. They change places with the lean.
    """
    zero = real(0.0)
    turn = theta - ltheta
    rate = omega - lomega
    still = wp.where(hint != zero, -hint, lean)
    now = sign_of(wp.where(turn != zero, turn, wp.where(rate != zero, rate, still)))
    same = now == lean
    lean = now
    n = real(n1)
    t = real(t1)
    anchor = real(anchor1)
    n1 = wp.where(same, n, n2)
    t1 = wp.where(same, t, t2)
    n2 = wp.where(same, n2, n)
    t2 = wp.where(same, t2, t)
    anchor1 = wp.where(same, anchor, anchor2)
    anchor2 = wp.where(same, anchor2, anchor)
    vx = vx - dv
    vz = fused_less(knobs.time_step, knobs.gravity, vz)
    turned = fused(knobs.time_step, omega, theta)
    ps = sine(in_range(turned))
    pc = cosine(in_range(turned))
    qx = zero
    qz = zero
    qo = zero


@wp.func
def without_tiny(value: real) -> real:
    """A number, or zero if it is below `TINY`: subnormal numbers are slow."""
    return wp.where(size(value) < TINY, real(0.0), value)


@wp.func
def find_contact(
    side: real, half_width: real, half_height: real, s: real, c: real, ps: real, pc: real, m: real,
    j: real, lhalf_width: real, lhalf_height: real, ls: real, lc: real, lps: real, lpc: real,
    lm: real, lj: real, x: real, z: real, vx: real, vz: real, below_x: real, below_z: real,
    below_vx: real, below_vz: real, knobs: Knobs, nx: wp.ref[real], nz: wp.ref[real],
    au: wp.ref[real], bu: wp.ref[real], al: wp.ref[real], bl: wp.ref[real], grown: wp.ref[real],
    slip: wp.ref[real], dn: wp.ref[real], gap: wp.ref[real], creep: wp.ref[real],
    soft: wp.ref[real], dt: wp.ref[real], anchor: wp.ref[real], n: wp.ref[real], t: wp.ref[real],
    qx: wp.ref[real], qz: wp.ref[real], qo: wp.ref[real], lx: wp.ref[real], lz: wp.ref[real],
    lo: wp.ref[real],
):  # fmt: skip
    """Finds a point at the start of the step and as predicted, and starts it from before.

    ps and pc are the sine and the cosine as predicted, vx and vz the predicted velocity, below_x
    and so on those of the lower body. Found are the normal and the levers at the start. For the
    velocity pass: by how much the gap would grow and the place change (`slip`) [m], and dn, the
    normal multiplier for a metre of gap [kg], nothing of an open end. For the pose pass: the gap,
    how far the place would be from its anchor (`creep`), and `soft` like dn. For both: dt, the
    tangential multiplier for a metre. The lower body's correction is (lx, lz, lo).
    """
    dx, dz = x - below_x, z - below_z
    px = fused(knobs.time_step, vx - below_vx, dx)
    pz = fused(knobs.time_step, vz - below_vz, dz)
    fx, fz, eu, du, el, dl, before, place = find_end(
        side, half_width, half_height, s, c, lhalf_width, lhalf_height, ls, lc, dx, dz
    )
    _x, _z, _eu, _du, _el, _dl, after, spot = find_end(
        side, half_width, half_height, ps, pc, lhalf_width, lhalf_height, lps, lpc, px, pz
    )
    closed = before <= knobs.gravity * knobs.time_step * knobs.time_step
    on = wp.where(closed, real(1.0), real(0.0))
    anchor = wp.where(closed and size(anchor) < LOOSE, anchor, place)
    nx = fx
    nz = fz
    au = eu
    bu = du
    al = el
    bl = dl
    grown = after - before
    slip = spot - place
    gap = after
    creep = spot - anchor
    normal = fused(lj * el, el, fused(j * eu, eu, m + lm))
    dn = on / normal
    soft = on / (normal + knobs.softness)
    dt = on / fused(lj * dl, dl, fused(j * du, du, m + lm))
    n = on * n
    t = on * without_tiny(t)
    add_impulses(m, j, lm, lj, fx, fz, eu, du, el, dl, n, t, qx, qz, qo, lx, lz, lo)


@wp.func
def gap_and_slip(
    gap: real, slip: real, nx: real, nz: real, au: real, bu: real, al: real, bl: real,
    wx: real, wz: real, qo: real, lo: real,
):  # fmt: skip
    """Gap and slip of a point after corrections; (wx, wz) is the upper body's to the lower's."""
    grown = fused_less(au, qo, fused(nz, wz, fused(nx, wx, gap)))
    slipped = fused(bu, qo, fused_less(nx, wz, fused(nz, wx, slip)))
    return fused(al, lo, grown), fused_less(bl, lo, slipped)


@wp.func
def coupling(
    m: real, j: real, lm: real, lj: real,
    nx1: real, nz1: real, au1: real, bu1: real, al1: real, bl1: real,
    nx2: real, nz2: real, au2: real, bu2: real, al2: real, bl2: real,
):  # fmt: skip
    """What multipliers do to the gaps and slips of both ends [1/kg].

    Returns:
        On the diagonal n1, t1, n2, t2; then n1 t1, n2 t2, n1 n2, t1 t2, n1 t2, t1 n2.
    """
    both = m + lm
    along = both * dot(nx1, nz1, nx2, nz2)
    across = both * wedge(nx1, nz1, nx2, nz2)
    pu, pv, lu, lv = j * au1, j * bu1, lj * al1, lj * bl1
    qu, qv, ku, kv = j * au2, j * bu2, lj * al2, lj * bl2
    return (
        fused(lu, al1, fused(pu, au1, both)), fused(lv, bl1, fused(pv, bu1, both)),
        fused(ku, al2, fused(qu, au2, both)), fused(kv, bl2, fused(qv, bu2, both)),
        -dot(pu, lu, bu1, bl1), -dot(qu, ku, bu2, bl2),
        fused(lu, al2, fused(pu, au2, along)), fused(lv, bl2, fused(pv, bu2, along)),
        fused_less(lu, bl2, fused_less(pu, bu2, across)),
        -fused(lv, al2, fused(pv, au2, across)),
    )  # fmt: skip


@wp.func
def solve_anywhere(
    mu: real, m: real, j: real, lm: real, lj: real,
    nx1: real, nz1: real, au1: real, bu1: real, al1: real, bl1: real,
    gap1: real, slip1: real, dn1: real, dt1: real,
    nx2: real, nz2: real, au2: real, bu2: real, al2: real, bl2: real,
    gap2: real, slip2: real, dn2: real, dt2: real,
    n1: wp.ref[real], t1: wp.ref[real], n2: wp.ref[real], t2: wp.ref[real],
    qx: wp.ref[real], qz: wp.ref[real], qo: wp.ref[real],
    lx: wp.ref[real], lz: wp.ref[real], lo: wp.ref[real],
):  # fmt: skip
    """A sweep over the four multipliers of an interface; those of an end alone are found exactly.

    mu is the friction coefficient.
    """
    n1n1, t1t1, n2n2, t2t2, n1t1, n2t2, n1n2, t1t2, n1t2, t1n2 = coupling(
        m, j, lm, lj, nx1, nz1, au1, bu1, al1, bl1, nx2, nz2, au2, bu2, al2, bl2
    )
    # Gaps and slips as they would be without these four, over what one of them does.
    u1, s1 = gap_and_slip(gap1, slip1, nx1, nz1, au1, bu1, al1, bl1, qx - lx, qz - lz, qo, lo)
    u2, s2 = gap_and_slip(gap2, slip2, nx2, nz2, au2, bu2, al2, bl2, qx - lx, qz - lz, qo, lo)
    a = real(n1)
    b = real(t1)
    e = real(n2)
    f = real(t2)
    u1 = -dn1 * less_three(fused_less(n1n1, a, u1), n1t1, b, n1n2, e, n1t2, f)
    s1 = -dt1 * less_three(fused_less(n1t1, a, s1), t1t1, b, t1n2, e, t1t2, f)
    u2 = -dn2 * less_three(fused_less(n1n2, a, u2), t1n2, b, n2n2, e, n2t2, f)
    s2 = -dt2 * less_three(fused_less(n1t2, a, s2), t1t2, b, n2t2, e, t2t2, f)
    a1 = dn1 * n1t1
    a2 = dn1 * n1n2
    a3 = dn1 * n1t2
    b1 = dt1 * n1t1
    b2 = dt1 * t1n2
    b3 = dt1 * t1t2
    c1 = dn2 * n1n2
    c2 = dn2 * t1n2
    c3 = dn2 * n2t2
    d1 = dt2 * n1t2
    d2 = dt2 * t1t2
    d3 = dt2 * n2t2
    first, second = dn2 <= real(0.0), dn1 <= real(0.0)
    n, t = alone(
        mu, wp.where(first, a1, c3), wp.where(first, b1, d3), wp.where(first, u1, u2),
        wp.where(first, s1, s2),
    )  # fmt: skip
    # The value found last comes last in each row, so that the other terms need not wait for it.
    a = larger(less_three(u1, a1, b, a2, e, a3, f), real(0.0))
    b = larger(smaller(less_three(s1, b2, e, b3, f, b1, a), mu * a), -mu * a)
    e = larger(less_three(u2, c3, f, c1, a, c2, b), real(0.0))
    f = larger(smaller(less_three(s2, d1, a, d2, b, d3, e), mu * e), -mu * e)
    a, b = wp.where(first, n, a), wp.where(first, t, b)
    e, f = wp.where(second, n, e), wp.where(second, t, f)
    add_impulses(m, j, lm, lj, nx1, nz1, au1, bu1, al1, bl1, a - n1, b - t1, qx, qz, qo, lx, lz, lo)
    add_impulses(m, j, lm, lj, nx2, nz2, au2, bu2, al2, bl2, e - n2, f - t2, qx, qz, qo, lx, lz, lo)
    n1 = a
    t1 = b
    n2 = e
    t2 = f


solve = solve_on_ground if BLOCKS == 1 else solve_anywhere


@wp.func
def integrate(
    live: bool, dv: real, knobs: Knobs, m: real, j: real,
    qx: real, qz: real, qo: real, rx: real, rz: real, ro: real,
    x: wp.ref[real], z: wp.ref[real], theta: wp.ref[real], s: wp.ref[real], c: wp.ref[real],
    vx: wp.ref[real], vz: wp.ref[real], omega: wp.ref[real], loss: wp.ref[real],
    given: wp.ref[real],
):  # fmt: skip
    """Moves a block, where its lane is alive, and gives it its velocity.

    The corrections of its predicted velocity, times the time step, are (qx, qz, qo), those of its
    predicted pose (rx, rz, ro). What its contacts take from its energy is added to the loss [J]:
    their work on the mean velocity of the step, less what poses are lifted by beyond velocities;
    the base's work is added to what is given [J].
    """
    dt = knobs.time_step
    x = wp.where(live, x + fused(dt, vx, rx), x)
    z = wp.where(live, z + fused(dt, vz, rz), z)
    theta = wp.where(live, theta + fused(dt, omega, ro), theta)
    turned = in_range(theta)
    s = sine(turned)
    c = cosine(turned)
    # Change of the velocity by contacts; it times the sum of the velocities before and after.
    px = knobs.rate * qx
    pz = knobs.rate * qz
    po = knobs.rate * qo
    along = vx + dv + vx + px
    linear = HALF * dot(px, pz, along, fused(dt, knobs.gravity, vz + vz + pz))
    angular = HALF * po * (omega + omega + po)
    done = fused(knobs.gravity, rz - qz, linear) / m + angular / j
    loss = loss - wp.where(live, done, real(0.0))
    given = given - wp.where(live, HALF * dv * along / m, real(0.0))
    vx = without_tiny(vx + px)
    vz = without_tiny(vz + pz)
    omega = without_tiny(omega + po)


@wp.func
def anchor_after(mu: real, n: real, t: real, anchor: real) -> real:
    """Anchor of an end after a step with the multipliers n, t of its pose: none if it slips."""
    return wp.where(size(t) < mu * n, anchor, LOOSE)
