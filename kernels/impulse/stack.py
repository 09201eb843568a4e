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

from warprock.kernels.account import Account
from warprock.kernels.cone import alone
from warprock.kernels.shape.interface import Impulse, Mass, Point, Pose, Velocity
from warprock.kernels.shape.rising import fall_in, sunk_in, worked
from warprock.kernels.shape.stack_run import Base

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


@wp.struct
class Contact:
    """What impulses do at a point.

    Attributes:
        gap: How wide it gapes [m].
        pn: Normal impulse for a normal velocity [kg], zero where the gap is wider than the margin.
        pt: Tangential impulse for a slip [kg], likewise.
        nt: Slip for a normal impulse [1/kg].
    """

    gap: real
    pn: real
    pt: real
    nt: real


@wp.struct
class Penetration:
    """How wide a point gapes [m], below zero where it is pressed in, and its normal (x, z)."""

    gap: real
    nx: real
    nz: real


@wp.struct
class Shift:
    """By how much a step lifts out all that stands above the interfaces seen so far [m]."""

    x: real
    z: real


@wp.func
def clear(turn: real) -> real:
    """A lean [rad] or a rate [rad/s], zero where it is no more than round-off."""
    return wp.where(size(turn) > SEEN, turn, real(0.0))


@wp.func
def side_of(turn: real, rate: real, hint: real, before: real) -> real:
    """Side to which an interface leans, -1 or 1: by its turn, else its rate, the base's, or before.

    Args:
        turn: Rotation of the block against what it stands on [rad].
        rate: Rate of that [rad/s].
        hint: What the base gains or is about to gain [m/s].
        before: Side to which the interface leaned before.
    """
    zero, lean, moves = real(0.0), clear(turn), clear(rate)
    still = wp.where(hint != zero, -hint, before)
    return sign_of(wp.where(lean != zero, lean, wp.where(moves != zero, moves, still)))


@wp.func
def predict(v: Velocity, base: Base, knobs: Knobs) -> Velocity:
    """Velocity of a block after a step without contact."""
    return Velocity(
        v.x - base.gain, v.z - fall_in(knobs.time_step, knobs.gravity, base.rise), v.omega
    )


@wp.func
def swap_unless(same: bool, one: wp.ref[Impulse], two: wp.ref[Impulse]):
    """Lets the impulses of two points change places, unless the order of the points is the same."""
    n = real(one.n)
    t = real(one.t)
    one.n = wp.where(same, n, two.n)
    one.t = wp.where(same, t, two.t)
    two.n = wp.where(same, two.n, n)
    two.t = wp.where(same, two.t, t)


@wp.func
def find_contact(point: Point, gap: real, margin: real, up: Mass, low: Mass) -> Contact:
    """What impulses do at a point: nothing where its gap is wider than the margin [m].

    Args:
        point: The point.
        gap: How wide it gapes [m].
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
    """What the sweeps start from at a point: the last impulses where it is a contact, else none."""
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
        other: pn of the other points of the interface: without them both impulses are found at
            once.
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
    both_n, both_t = alone(mu, r, q, free_n, free_t)
    lone = other <= zero and contact.pn > zero
    return Impulse(wp.where(lone, both_n, push), wp.where(lone, both_t, drag))


@wp.func
def deeper(one: Penetration, two: Penetration) -> Penetration:
    """The deeper of two points."""
    first = one.gap < two.gap
    return Penetration(
        wp.where(first, one.gap, two.gap),
        wp.where(first, one.nx, two.nx),
        wp.where(first, one.nz, two.nz),
    )


@wp.func
def lift_out(knobs: Knobs, rise: real, deepest: Penetration, shift: Shift) -> Shift:
    """Adds what an interface gives back of its penetration to the shift of all above it."""
    slack = sunk_in(knobs.time_step, knobs.gravity, rise)
    push = knobs.erp * smaller(deepest.gap + slack, real(0.0))
    return Shift(fused_less(push, deepest.nx, shift.x), fused_less(push, deepest.nz, shift.z))


@wp.func
def integrate(live: bool, dt: real, shift: Shift, u: Velocity, at: Pose) -> Pose:
    """Moves a block by a step, where its lane is alive."""
    theta = wp.where(live, fused(dt, u.omega, at.theta), at.theta)
    turned = in_range(theta)
    return Pose(
        wp.where(live, fused(dt, u.x, at.x) + shift.x, at.x),
        wp.where(live, fused(dt, u.z, at.z) + shift.z, at.z),
        theta, sine(turned), cosine(turned),
    )  # fmt: skip


@wp.func
def work(dv: real, fall: real, gyration: real, v: Velocity, u: Velocity) -> real:
    """Work of a block's contacts on its mean velocity in a step, for unit mass [J/kg].

    Args:
        dv: Change of the base velocity [m/s].
        fall: What gravity, and a base that rises faster, take from v.z [m/s].
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
    """Books a step of a block with the velocity v before it and u after it.

    What its contacts take from the energy, less what it is lifted by, is added to the loss, the
    base's work to what is given [J].
    """
    fall = fall_in(knobs.time_step, knobs.gravity, base.rise)
    done = work(base.gain, fall, mass.m / mass.j, v, u)
    lost = fused(knobs.gravity, shift.z, done) / mass.m
    given = worked(base.gain, base.rise, v.x + u.x, v.z + u.z) / mass.m
    account.loss = account.loss - wp.where(live, lost, real(0.0))
    account.work = account.work - wp.where(live, given, real(0.0))
