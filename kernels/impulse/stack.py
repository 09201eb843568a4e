"""Velocity-level contact step of a stack of rocking blocks.

Bodies are numbered from the ground: body 0 is the ground, an endless flat face that nothing moves,
body k the k-th block. A body has half sizes (`Box`), a place and a rotation (`Pose`), a mass and a
`Velocity`, see shape/interface.py. A lever (X, Z) of a body points to (X c + Z s, Z c - X s);
(c, -s) is the direction of its faces, (s, c) their normal.

Interface k, below block k, touches at the two ends of the overlap of the upper block's bottom face
and the lower one's top face. An end is the corner that lies further in along the lower face. It is
a corner of the upper block on the lower one's face, or a corner of the lower block on the upper
one's face; the normal n = (nx, nz) and the direction e = (nz, -nx) are those of the touched face.
With r_u, r_l the levers from the two centres, and a = r.e and b = r.n of each [m], the relative
velocities at an end are

    normal:  (v_u - v_l).n - a_u omega_u + a_l omega_l
    slip:    (v_u - v_l).e + b_u omega_u - b_l omega_l

and the impulses n (normal) and t (tangential) [N s]. One step of length dt is that of a single
block (see impulse/block.py), body by body:

- the velocity without contact;
- contacts: ends with a gap within the collision margin. The normal velocity of each must be at
  least -gap / dt if it is open, else zero; its slip must be zero within Coulomb's bound;
- projected Gauss-Seidel from the impulses of the last step; a single contact of an interface is
  solved by cone.py;
- semi-implicit Euler, and erp.

The sweeps update the velocities, from the ground up. In an interface they first visit the end away
from the side to which it leans, so that a mirrored scene is visited in mirrored order. A stack that
is its own mirror image takes the mean of both orders, until its base moves along x. erp moves all
blocks above an interface along the normal there, by erp times its penetration beyond 2 g dt^2, the
fall that one step can make.

Jean and Moreau (1992) for the scheme, Catto (2005) for the solver.
"""

import warp as wp

from warprock.kernels.contact.cone import solve_single_contact
from warprock.kernels.impulse.block import Knobs
from warprock.kernels.lane.account import Account
from warprock.kernels.shape.interface import Impulse, Mass, Point, Pose, Velocity
from warprock.kernels.shape.rising import base_work, fall_depth, fall_in
from warprock.kernels.shape.stack_run import Base

SEEN = by_precision(1.0e-13, 1.0e-6)
"""Smallest lean [rad] and rate [rad/s] that have a side. Smaller ones are round-off: of a stack
that stands or moves as one block, or of a plane motion in space."""


@wp.struct
class Contact:
    """Effective masses and coupling of a point.

    Attributes:
        gap: [m].
        pn: Normal impulse per normal velocity [kg]; zero if the gap exceeds the margin.
        pt: Tangential impulse per slip velocity [kg], likewise.
        nt: Slip velocity per normal impulse [1/kg].
    """

    gap: real
    pn: real
    pt: real
    nt: real


@wp.struct
class Penetration:
    """Gap of a point [m], negative where it penetrates, and its normal (x, z)."""

    gap: real
    nx: real
    nz: real


@wp.struct
class Shift:
    """Shift by erp of all blocks above the interfaces handled so far [m]."""

    x: real
    z: real


@wp.func
def drop_round_off(turn: real) -> real:
    """A lean [rad] or a rate [rad/s]; zero if it is round-off."""
    return wp.where(size(turn) > SEEN, turn, real(0.0))


@wp.func
def side_of(turn: real, rate: real, hint: real, before: real) -> real:
    """Side to which an interface leans, -1 or 1.

    The first of these numbers that is not zero decides.

    Args:
        turn: Rotation of the block relative to the one below [rad].
        rate: Rate of that [rad/s].
        hint: Present or next gain of the base velocity [m/s].
        before: Side to which the interface leaned before.
    """
    zero, lean, moves = real(0.0), drop_round_off(turn), drop_round_off(rate)
    still = wp.where(hint != zero, -hint, before)
    return sign_of(wp.where(lean != zero, lean, wp.where(moves != zero, moves, still)))


@wp.func
def predict(v: Velocity, base: Base, knobs: Knobs) -> Velocity:
    """Velocity of a block after a step without contact."""
    return Velocity(
        v.x - base.gain, v.z - fall_in(knobs.time_step, knobs.gravity, base.rise), v.omega
    )


@wp.func
def find_contact(point: Point, gap: real, margin: real, up: Mass, low: Mass) -> Contact:
    """Effective masses and coupling of a point.

    Args:
        point: The point.
        gap: Its gap [m].
        margin: Collision margin [m].
        up, low: Masses of the upper and of the lower body.
    """
    on = wp.where(gap <= margin, real(1.0), real(0.0))
    return Contact(
        gap,
        on / fused(low.j * point.al, point.al, fused(up.j * point.au, point.au, up.m + low.m)),
        on / fused(low.j * point.bl, point.bl, fused(up.j * point.bu, point.bu, up.m + low.m)),
        -dot(up.j * point.au, low.j * point.al, point.bu, point.bl),
    )


@wp.func
def warm_start(gap: real, margin: real, last: Impulse) -> Impulse:
    """First guess of the impulses of a point: the last ones if it is a contact, else zero."""
    on = wp.where(gap <= margin, real(1.0), real(0.0))
    return Impulse(on * last.n, on * last.t)


@wp.func
def solve_contact(
    mu: real, rate: real, point: Point, contact: Contact, other: real, last: Impulse,
    u: Velocity, v: Velocity,
) -> Impulse:  # fmt: skip
    """Gauss-Seidel on the two impulses of a point.

    Args:
        mu: Friction coefficient.
        rate: Inverse of the time step [1/s].
        point, contact: The point.
        other: Sum of pn of the other points of the interface; if zero, this is the only contact,
            and it is solved exactly.
        last: Its impulses so far.
        u, v: Velocities of the upper and of the lower body.
    """
    zero = real(0.0)
    wx = u.x - v.x
    wz = u.z - v.z
    turn = wedge(point.al, point.au, u.omega, v.omega)
    opens = dot(point.nx, point.nz, wx, wz) + turn
    normal = fused(larger(contact.gap, zero), rate, opens)
    push = larger(fused_less(contact.pn, normal, last.n), zero)
    dn = push - last.n
    bound = mu * push
    slip = wedge(point.nz, point.nx, wz, wx) + wedge(point.bu, point.bl, v.omega, u.omega)
    drag = fused_less(contact.pt, fused(contact.nt, dn, slip), last.t)
    drag = larger(smaller(drag, bound), -bound)
    r, q = contact.pn * contact.nt, contact.pt * contact.nt
    free_n = fused_less(contact.pn, normal, fused(r, last.t, last.n))
    free_t = fused_less(contact.pt, slip, fused(q, last.n, last.t))
    both_n, both_t = solve_single_contact(mu, r, q, free_n, free_t)
    lone = other <= zero and contact.pn > zero
    return Impulse(wp.where(lone, both_n, push), wp.where(lone, both_t, drag))


@wp.func
def deeper_of(one: Penetration, two: Penetration) -> Penetration:
    """The deeper of two points."""
    first = one.gap < two.gap
    return Penetration(
        wp.where(first, one.gap, two.gap),
        wp.where(first, one.nx, two.nx),
        wp.where(first, one.nz, two.nz),
    )


@wp.func
def lift_out(knobs: Knobs, rise: real, deepest: Penetration, shift: Shift) -> Shift:
    """Adds the correction of the penetration of an interface to the shift of all blocks above."""
    slack = fall_depth(knobs.time_step, knobs.gravity, rise)
    push = knobs.erp * smaller(deepest.gap + slack, real(0.0))
    return Shift(fused_less(push, deepest.nx, shift.x), fused_less(push, deepest.nz, shift.z))


@wp.func
def integrate(live: bool, dt: real, shift: Shift, u: Velocity, at: Pose) -> Pose:
    """The pose of a block after a step, if its lane still runs."""
    theta = wp.where(live, fused(dt, u.omega, at.theta), at.theta)
    turned = in_range(theta)
    return Pose(
        wp.where(live, fused(dt, u.x, at.x) + shift.x, at.x),
        wp.where(live, fused(dt, u.z, at.z) + shift.z, at.z),
        theta, sine(turned), cosine(turned),
    )  # fmt: skip


@wp.func
def contact_work(dv: real, fall: real, gyration: real, v: Velocity, u: Velocity) -> real:
    """Work of a block's contacts on its mean velocity in a step, for unit mass [J/kg].

    Args:
        dv: Change of the base velocity [m/s].
        fall: Velocity downwards that gravity and a rising base give relative to the base [m/s].
        gyration: Square of the radius of gyration [m^2].
        v, u: Velocity before the step and after it.
    """
    linear = dot(u.x - v.x + dv, u.z - v.z + fall, v.x + u.x, v.z + u.z)
    return HALF * fused(gyration * (u.omega - v.omega), v.omega + u.omega, linear)


@wp.func
def add_energy(
    live: bool, knobs: Knobs, base: Base, mass: Mass, shift: Shift, v: Velocity, u: Velocity,
    account: wp.ref[Account],
):  # fmt: skip
    """Adds a step of a block, with velocities v before and u after, to the energy account [J].

    The loss grows by the energy that its contacts take, less the potential energy by which erp
    lifts it. The work of the base is added, too.
    """
    fall = fall_in(knobs.time_step, knobs.gravity, base.rise)
    done = contact_work(base.gain, fall, mass.m / mass.j, v, u)
    lost = fused(knobs.gravity, shift.z, done) / mass.m
    given = base_work(base.gain, base.rise, v.x + u.x, v.z + u.z) / mass.m
    account.loss = account.loss - wp.where(live, lost, real(0.0))
    account.work = account.work - wp.where(live, given, real(0.0))
