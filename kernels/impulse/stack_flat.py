"""Velocity-level contact step of a stack of rocking blocks.

Bodies are numbered from the ground: body 0 is the ground, an endless flat face that nothing moves,
body k the k-th block. A body has its centre of mass at (x, z), in the frame of the base, the half
width `half_width` and the half height `half_height` [m], the clockwise rotation theta [rad] with
its sine s and cosine c, the inverse mass m [1/kg] and moment of inertia j [1/(kg m^2)], and the
velocity (vx, vz) [m/s], omega [rad/s]. A lever (X, Z) of a body points to (X c + Z s, Z c - X s);
(c, -s) is the direction of its faces, (s, c) their normal. Of the two bodies of an interface the
lower one's names begin with l.

Interface k, below block k, touches at the two ends of the overlap of the upper block's bottom face
and the lower one's top face. An end is whichever corner lies further in along the lower face: a
corner of the upper block against the lower one's face, with the normal and the direction of that
face, or a corner of the lower one against the upper one's face, with those. A point with the
normal n = (nx, nz), the direction e = (nz, -nx) and the levers r_u, r_l from the two centres has,
with a = r.e and b = r.n of each [m], the relative velocities

    normal:  (v_u - v_l).n - a_u omega_u + a_l omega_l
    slip:    (v_u - v_l).e + b_u omega_u - b_l omega_l

and the impulses n (normal) and t (tangential) [N s]. One step of length dt is the single block's
(see impulse/block.py), body by body: the velocity without contact; contacts where the gap is within
the collision margin, each of which wants a normal velocity of at least -gap / dt or zero and no
slip within Coulomb's bound; projected Gauss-Seidel from the impulses of the last step, an end that
is alone at its interface by cone.py; semi-implicit Euler; erp. Here the sweeps work on the
velocities, from the ground up. In an interface they visit first the end away from the side it leans
to, so that a mirrored scene is visited in mirrored order; of a stack that is its own mirror image,
until its base moves along, the mean of both orders is taken. What an interface gives back of its
penetration moves all that stands on it along the normal there, but for the 2 g dt^2 that one step
of falling can make.

Jean and Moreau (1992) for the scheme, Catto (2005) for the solver.
"""

import warp as wp

from warprock.kernels.cone import alone
from warprock.kernels.shape.interface_flat import add_impulses, find_end
from warprock.kernels.shape.rising import fall_in, sunk_in

SEEN = by_precision(1.0e-13, 1.0e-6)
"""Smallest lean [rad] and rate [rad/s] that tell a side: what is below is what round-off leaves of
none where a stack stands, or moves as one, or in space in a plane."""


@wp.struct
class Knobs:
    """What a step needs to know of the settings; `rate` is the inverse of the time step [1/s]."""

    time_step: real
    rate: real
    gravity: real
    collision_margin: real
    erp: real


@wp.func
def clear(turn: real) -> real:
    """A lean [rad] or a rate [rad/s], zero where it is no more than round-off."""
    return wp.where(size(turn) > SEEN, turn, real(0.0))


@wp.func
def side_of(turn: real, rate: real, hint: real, before: real) -> real:
    """Side to which an interface leans, -1 or 1: by its turn, else its rate, the base's, or before.

    Arguments as those of `predict`.
    """
    zero, lean, moves = real(0.0), clear(turn), clear(rate)
    still = wp.where(hint != zero, -hint, before)
    return sign_of(wp.where(lean != zero, lean, wp.where(moves != zero, moves, still)))


@wp.func
def predict(
    dv: real, rise: real, hint: real, knobs: Knobs, turn: real, vx: real, vz: real, omega: real,
    below: real, ux: wp.ref[real], uz: wp.ref[real], uo: wp.ref[real], lean: wp.ref[real],
    n1: wp.ref[real], t1: wp.ref[real], n2: wp.ref[real], t2: wp.ref[real],
):  # fmt: skip
    """Velocity (ux, uz, uo) of a block without contact; its interface in the order of its lean.

    Args:
        dv: Change of the base velocity in the step [m/s]; rise: of that upwards.
        hint: What it does or is about to do, for the lean of what does not move yet [m/s].
        knobs: Settings.
        turn: Rotation of the block against what it stands on [rad].
        vx, vz, omega: Velocity of the block.
        below: Angular velocity of what it stands on [rad/s].
        ux, uz, uo: Velocity found.
        lean: Side to which the interface leaned before, then the one of this step: -1 or 1.
        n1, t1, n2, t2: Normal and tangential impulse of the end visited first, and of the other.
            They change places where the lean has changed.
    """
    now = side_of(turn, omega - below, hint, lean)
    same = now == lean
    n = real(n1)
    t = real(t1)
    n1 = wp.where(same, n, n2)
    t1 = wp.where(same, t, t2)
    n2 = wp.where(same, n2, n)
    t2 = wp.where(same, t2, t)
    lean = now
    ux = vx - dv
    uz = vz - fall_in(knobs.time_step, knobs.gravity, rise)
    uo = omega


@wp.func
def find_contact(
    side: real, half_width: real, half_height: real, s: real, c: real, m: real, j: real,
    lhalf_width: real, lhalf_height: real, ls: real, lc: real, lm: real, lj: real,
    dx: real, dz: real, margin: real,
    nx: wp.ref[real], nz: wp.ref[real], au: wp.ref[real], bu: wp.ref[real],
    al: wp.ref[real], bl: wp.ref[real], gap: wp.ref[real],
    pn: wp.ref[real], pt: wp.ref[real], nt: wp.ref[real],
    n: wp.ref[real], t: wp.ref[real],
    ux: wp.ref[real], uz: wp.ref[real], uo: wp.ref[real],
    lx: wp.ref[real], lz: wp.ref[real], lo: wp.ref[real],
):  # fmt: skip
    """Finds a point (see `find_end`), what impulses do to it, and starts it from its last impulses.

    Found are pn, normal impulse for a normal velocity [kg], and pt, tangential impulse for a slip
    [kg], both zero where the gap is wider than the margin [m]; and nt, slip for a normal impulse
    [1/kg].
    """
    mx, mz, ru, hu, rl, hl, found, _place = find_end(
        side, half_width, half_height, s, c, lhalf_width, lhalf_height, ls, lc, dx, dz
    )
    nx = mx
    nz = mz
    au = ru
    bu = hu
    al = rl
    bl = hl
    gap = found
    on = wp.where(gap <= margin, real(1.0), real(0.0))
    pn = on / fused(lj * al, al, fused(j * au, au, m + lm))
    pt = on / fused(lj * bl, bl, fused(j * bu, bu, m + lm))
    nt = -dot(j * au, lj * al, bu, bl)
    n = on * n
    t = on * t
    add_impulses(m, j, lm, lj, nx, nz, au, bu, al, bl, n, t, ux, uz, uo, lx, lz, lo)


@wp.func
def solve_contact(
    mu: real, gap: real, rate: real, m: real, j: real, lm: real, lj: real,
    nx: real, nz: real, au: real, bu: real, al: real, bl: real, pn: real, pt: real, nt: real,
    other: real, n: wp.ref[real], t: wp.ref[real],
    ux: wp.ref[real], uz: wp.ref[real], uo: wp.ref[real],
    lx: wp.ref[real], lz: wp.ref[real], lo: wp.ref[real],
):  # fmt: skip
    """Gauss-Seidel on the two impulses of a point; mu is the friction coefficient.

    `other` is pn of the other end of the interface: without it both impulses are found at once.
    """
    zero = real(0.0)
    wx = ux - lx
    wz = uz - lz
    turn = wedge(al, au, uo, lo)
    normal = fused(larger(gap, zero), rate, dot(nx, nz, wx, wz) + turn)
    push = larger(fused_less(pn, normal, n), zero)
    dn = push - n
    bound = mu * push
    slip = wedge(nz, nx, wz, wx) + wedge(bu, bl, lo, uo)
    drag = larger(smaller(fused_less(pt, fused(nt, dn, slip), t), bound), -bound)
    r, q = pn * nt, pt * nt
    free_n, free_t = fused_less(pn, normal, fused(r, t, n)), fused_less(pt, slip, fused(q, n, t))
    both_n, both_t = alone(mu, r, q, free_n, free_t)
    lone = other <= zero and pn > zero
    push = wp.where(lone, both_n, push)
    drag = wp.where(lone, both_t, drag)
    dn = push - n
    dt = drag - t
    n = push
    t = drag
    add_impulses(m, j, lm, lj, nx, nz, au, bu, al, bl, dn, dt, ux, uz, uo, lx, lz, lo)


@wp.func
def lift_out(
    gap1: real, nx1: real, nz1: real, gap2: real, nx2: real, nz2: real, knobs: Knobs, rise: real,
    shift_x: wp.ref[real], shift_z: wp.ref[real],
):  # fmt: skip
    """Adds what an interface gives back of its penetration to the shift of all above it [m]."""
    deep = gap1 < gap2
    slack = sunk_in(knobs.time_step, knobs.gravity, rise)
    push = knobs.erp * smaller(wp.where(deep, gap1, gap2) + slack, real(0.0))
    shift_x = fused_less(push, wp.where(deep, nx1, nx2), shift_x)
    shift_z = fused_less(push, wp.where(deep, nz1, nz2), shift_z)


@wp.func
def integrate(
    live: bool, dt: real, shift_x: real, shift_z: real, ux: real, uz: real, uo: real,
    x: wp.ref[real], z: wp.ref[real], theta: wp.ref[real], s: wp.ref[real], c: wp.ref[real],
):  # fmt: skip
    """Moves a block by a step, where its lane is alive."""
    x = wp.where(live, fused(dt, ux, x) + shift_x, x)
    z = wp.where(live, fused(dt, uz, z) + shift_z, z)
    theta = wp.where(live, fused(dt, uo, theta), theta)
    turned = in_range(theta)
    s = sine(turned)
    c = cosine(turned)


@wp.func
def work(
    dv: real, fall: real, gyration: real, vx: real, vz: real, omega: real, ux: real, uz: real,
    uo: real,
) -> real:  # fmt: skip
    """Work of a block's contacts on its mean velocity in a step, for unit mass [J/kg].

    Args:
        dv: Change of the base velocity [m/s].
        fall: What gravity, and a base that rises faster, take from vz [m/s].
        gyration: Square of the radius of gyration [m^2].
        vx, vz, omega: Velocity before the step.
        ux, uz, uo: Velocity after it.
    """
    linear = dot(ux - vx + dv, uz - vz + fall, vx + ux, vz + uz)
    return HALF * fused(gyration * (uo - omega), omega + uo, linear)
