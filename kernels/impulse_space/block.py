"""Velocity-level contact step of a block in space.

The block lives in the frame of the base, with mass 1: centre of mass (x, y, z), attitude q (see
shape_space/block.py), velocity v and angular momentum l, both in the axes of the base. Corner k is
at the lever r_k from the centre of mass; its gap is z + r_z, its velocity v + omega x r, omega = J
l, with J the inverse inertia in the axes of the base. One step of length dt is that of the planar
block (see impulse/block.py), with three rows a corner:

    1. v* = v - dt (0, 0, g) - dv, dv the change of the base velocity between the half steps;
    2. corners with a gap below the collision margin are contacts. The normal velocity of each must
       be at least -gap / dt if it is open, so that it may close, else zero. The tangential velocity
       must be zero while |f| <= mu n (Coulomb);
    3. if impulses p = (f_x, f_y, n) that push, with friction within the bound, can stop all
       contacts together, they are taken (see impulse_space/block_hold.py). They are a fixed point
       of step 4, which is then left out. Else, if the block moves in a plane of its symmetry, that
       planar problem is solved exactly (see impulse_space/block_plane.py). Else
    4. projected Gauss-Seidel on the impulses, started from those of the last step, corner by
       corner. With K the 3 x 3 matrix of velocity per impulse at the corner, p - K^-1 u stops it.
       If that pushes and its friction is within the bound, the corner sticks. Else
       n = max(n - u_z / K_zz, 0), and the friction follows from the slip u_t: for the cone
       f - u_t / (largest eigenvalue of K_t), shortened to the bound; for the box f_x and f_y each
       limited to the bound. The fixed points for the cone are those of Coulomb's law,
       f = - mu n u_t / |u_t| for a slip in any direction;
    5. v = v* + sum of p, l = l + sum of r x p (J^-1 times the change of omega). Position and
       attitude follow; the attitude rotates freely with the angular momentum l. The block is lifted
       by erp times its penetration beyond 2 g dt^2, the fall that one step can make.

A step first visits the corner away from the side to which the block leans, along its width and
along its depth, so that the corners of a mirrored scene are visited in mirrored order. In that
order they are numbered: sides (-,-), (+,-), (-,+), (+,+), with + towards the lean.

Step 3 prevents a spurious rotation about the vertical if there are few sweeps. At two corners close
to each other sweeps find the difference of the frictions slowly, b^2 / I_z against h^2 / I_y a
sweep (b half the distance of the corners, h the height of the centre). Since the corners are always
visited in the same order, the remaining error always has the same sign.

Jean and Moreau (1992) for the scheme, Catto (2005) for the solver.
"""

import warp as wp

from warprock.kernels.contact.parting import CREEP, slack
from warprock.kernels.shape_space.block import Block, turn_freely
from warprock.kernels.shape_space.contact import drag, holds, slip_gains, stop_gains
from warprock.kernels.shape_space.lanes import (
    State,
    Symmetric,
    Triple,
    elementwise_product,
    inertia_of,
    into_base,
    into_body,
    minus,
    plus,
    product,
    scalar_product,
    times,
    turn_of,
    vector_product,
)

FAR = real(1.0e30)


@wp.struct
class Knobs:
    """Settings of a step; `rate` is the inverse of the time step [1/s].

    `moves` is the sum of 1 where a base of any lane moves along x, 2 along y and 4 along z. Only
    impulse_space/bounce.py reads `restitution`.
    """

    time_step: real
    rate: real
    gravity: real
    collision_margin: real
    erp: real
    sweeps: int
    moves: int
    restitution: real


@wp.struct
class Box:
    """A block of mass 1.

    Attributes:
        half_width, half_depth, half_height: Half sizes [m].
        centre_x, centre_y: The centre of mass from the middle, along width and depth [m].
        friction: Coulomb friction coefficient under it.
        inverse_x, inverse_y, inverse_z: Inverse moments of inertia about its axes [1/m^2].
    """

    half_width: real
    half_depth: real
    half_height: real
    centre_x: real
    centre_y: real
    friction: real
    inverse_x: real
    inverse_y: real
    inverse_z: real


@wp.struct
class Velocity:
    """Velocity of the centre of mass [m/s] and angular velocity [rad/s], in a step."""

    x: real
    y: real
    z: real
    turn_x: real
    turn_y: real
    turn_z: real


@wp.struct
class Lean:
    """Sides that a block leans to along its width and along its depth, -1 or 1."""

    x: real
    y: real


@wp.struct
class Contact:
    """A corner, or a point.

    Attributes:
        x, y, h: Lever from the centre of mass [m].
        aim: Least normal velocity after the step, if it is a contact [m/s].
        on: 1 if it is one, else 0.
    """

    x: real
    y: real
    h: real
    aim: real
    on: real


REAR, AHEAD_X, AHEAD_Y, LOWEST = 0, 1, 2, 3
"""Numbers of the corners of a face, by how they lie towards the lean: away from it along both axes,
ahead along x, ahead along y, ahead along both."""


@wp.struct
class Corners:
    """The corners of a face, in the order in which a step visits them: REAR to LOWEST."""

    a: Contact
    b: Contact
    c: Contact
    d: Contact


@wp.struct
class Impulse:
    """Friction and normal impulse of a contact, for unit mass [m/s]."""

    fx: real
    fy: real
    n: real


@wp.struct
class Gains:
    """Effect of impulses at a contact; all but kx and ky are zero if it is no contact.

    Attributes:
        kx, ky: Slip velocity per normal impulse.
        pn: Inverse of K_zz.
        p1, p2, p3: See `slip_gains`.
        h11, h12, h13, h22, h23, h33: See `stop_gains`.
    """

    kx: real
    ky: real
    pn: real
    p1: real
    p2: real
    p3: real
    h11: real
    h12: real
    h13: real
    h22: real
    h23: real
    h33: real


@wp.struct
class Gaps:
    """Observed gaps of the contacts of a block in a step.

    Attributes:
        lowest: Lowest gap [m].
        lifted: Corners that have parted.
        landed: Corners that land.
    """

    lowest: real
    lifted: real
    landed: real


@wp.func
def box_of(block: Block) -> Box:
    """The sizes, friction and inertia of a block."""
    return Box(
        block.half_width, block.half_depth, block.half_height, block.centre_x, block.centre_y,
        block.friction, block.inverse_x, block.inverse_y, block.inverse_z,
    )  # fmt: skip


@wp.func
def spin_of(s: State) -> Triple:
    """Angular momentum of a block for unit mass, in the axes of the base [m^2/s]."""
    return Triple(s.lx, s.ly, s.lz)


@wp.func
def rate_of(u: Velocity) -> Triple:
    """Angular velocity of a block, in the axes of the base [rad/s]."""
    return Triple(u.turn_x, u.turn_y, u.turn_z)


@wp.func
def inverse_of(box: Box) -> Triple:
    """Inverse moments of inertia of a block about its axes, for unit mass [1/m^2]."""
    return Triple(box.inverse_x, box.inverse_y, box.inverse_z)


@wp.func
def slips(square: real, knobs: Knobs) -> bool:
    """Whether a contact slides, from the square of its slip velocity [m^2/s^2]."""
    creep = CREEP * knobs.time_step * knobs.gravity
    return square > creep * creep


@wp.func
def side_of(lean: real, rate: real, dv: real, before: real) -> real:
    """Side to which a block leans, -1 or 1: by its axis, else its motion, the base's, or before."""
    zero = real(0.0)
    moved = wp.where(rate != zero, rate, wp.where(dv != zero, -dv, before))
    return sign_of(wp.where(lean != zero, lean, moved))


@wp.func
def predict(dv: Triple, knobs: Knobs, inverse: Triple, s: State):
    """Velocity of a block without contact, and its inverse inertia J in the axes of the base.

    dv is the change of the base velocity [m/s], inverse are the inverse moments of inertia about
    the block's axes [1/m^2].
    """
    j = inertia_of(turn_of(s), inverse)
    o = times(j, spin_of(s))
    fall = knobs.time_step * knobs.gravity
    return Velocity(s.vx - dv.x, s.vy - dv.y, s.vz - dv.z - fall, o.x, o.y, o.z), j


@wp.func
def find_lean(dv: Triple, s: State, free: Velocity, before: Lean) -> Lean:
    """Sides to which a block leans; dv is the change of the base velocity [m/s]."""
    r, zero = turn_of(s), real(0.0)
    x = side_of(-r.r31, free.turn_y, dv.x, before.x)
    # A yaw changes its sign if x is reversed, and if y is.
    twist = s.qz * s.qw * x
    y = side_of(-r.r32, -free.turn_x, dv.y, wp.where(twist != zero, twist, before.y))
    return Lean(x, y)


@wp.func
def observe_contact(
    knobs: Knobs, gap: real, reach: real, u: Velocity, n: real, apart: wp.ref[real],
    gaps: wp.ref[Gaps],
):  # fmt: skip
    """Counts a corner that has parted, or that has landed after it had; see parting.py.

    Args:
        knobs: Settings.
        gap: Its gap after the last step [m].
        reach: Upper bound of its distance from the centre of mass [m].
        u: Velocity of its block.
        n: Its normal impulse in the last step.
        apart: 1 if it has parted and not landed since, else 0.
        gaps: Observed gaps of its block; updated.
    """
    zero, one = real(0.0), real(1.0)
    square = product(u.turn_x, u.turn_y, u.turn_z, u.turn_x, u.turn_y, u.turn_z)
    was = apart > zero
    limit = slack(knobs.time_step, knobs.gravity, reach, square, reach)
    gaps.landed = gaps.landed + wp.where(was and n > zero, one, zero)
    now = wp.where(gap > limit or (was and n <= zero), one, zero)
    gaps.lifted = gaps.lifted + now
    gaps.lowest = smaller(gaps.lowest, gap)
    apart = now


@wp.func
def find_contact(corner: int, knobs: Knobs, box: Box, lean: Lean, s: State) -> Contact:
    """The lever of a corner, and whether it is a contact."""
    zero = real(0.0)
    x = real(2 * (corner % 2) - 1) * lean.x * box.half_width - box.centre_x
    y = real(2 * (corner // 2) - 1) * lean.y * box.half_depth - box.centre_y
    r = into_base(turn_of(s), Triple(x, y, -box.half_height))
    gap = s.z + r.z
    on = wp.where(gap <= knobs.collision_margin, real(1.0), zero)
    return Contact(r.x, r.y, r.z, -larger(gap, zero) * knobs.rate, on)


@wp.func
def impulse_where(on: bool, p: Impulse) -> Impulse:
    """The impulse of a contact; zero if the corner is none."""
    zero = real(0.0)
    return Impulse(wp.where(on, p.fx, zero), wp.where(on, p.fy, zero), wp.where(on, p.n, zero))


@wp.func
def warm_start(at: Contact, p: Impulse, j: Symmetric, u: wp.ref[Velocity]) -> Gains:
    """Effect of impulses at a corner; applies those of the last step to the velocity u."""
    one, x, y, h = real(1.0), at.x, at.y, at.h
    # J (r x e) for e along x, y, z: r x e is (0, h, -y), (-h, 0, x), (y, -x, 0).
    a1, b1, c1 = vector_product(j.xx, j.xy, j.xz, x, y, h)
    a2, b2, c2 = vector_product(j.xy, j.yy, j.yz, x, y, h)
    a3, b3, c3 = vector_product(j.xz, j.yz, j.zz, x, y, h)
    kxx = fused_less(y, a3, fused(h, a2, one))
    kyy = fused_less(h, b1, fused(x, b3, one))
    kzz = fused_less(x, c2, fused(y, c1, one))
    kxy, kxz, kyz = fused_less(y, b3, h * b2), fused_less(y, c3, h * c2), fused_less(h, c1, x * c3)
    p1, p2, p3 = slip_gains(at.on, kxx, kxy, kyy)
    stop = stop_gains(at.on, Symmetric(kxx, kxy, kxz, kyy, kyz, kzz))
    px, py, pz = at.on * p.fx, at.on * p.fy, at.on * p.n
    u.x = u.x + px
    u.y = u.y + py
    u.z = u.z + pz
    u.turn_x = fused(c1, pz, fused(b1, py, fused(a1, px, u.turn_x)))
    u.turn_y = fused(c2, pz, fused(b2, py, fused(a2, px, u.turn_y)))
    u.turn_z = fused(c3, pz, fused(b3, py, fused(a3, px, u.turn_z)))
    return Gains(
        kxz, kyz, at.on / kzz, p1, p2, p3, stop.xx, stop.xy, stop.xz, stop.yy, stop.yz, stop.zz
    )


@wp.func
def solve_contact(
    mu: real, at: Contact, k: Gains, j: Symmetric, p: wp.ref[Impulse], u: wp.ref[Velocity]
):
    """Gauss-Seidel on the three impulses of a corner; mu is the friction coefficient."""
    slip_x = fused_less(u.turn_z, at.y, fused(u.turn_y, at.h, u.x))
    slip_y = fused_less(u.turn_x, at.h, fused(u.turn_z, at.x, u.y))
    normal = fused_less(u.turn_y, at.x, fused(u.turn_x, at.y, u.z - at.aim))
    stop_x = fused_less(k.h13, normal, fused_less(k.h12, slip_y, fused_less(k.h11, slip_x, p.fx)))
    stop_y = fused_less(k.h23, normal, fused_less(k.h22, slip_y, fused_less(k.h12, slip_x, p.fy)))
    stop_z = fused_less(k.h33, normal, fused_less(k.h23, slip_y, fused_less(k.h13, slip_x, p.n)))
    push = larger(fused_less(k.pn, normal, p.n), real(0.0))
    dn = push - p.n
    # Slip velocity after the normal impulse.
    slip_x = fused(dn, k.kx, slip_x)
    slip_y = fused(dn, k.ky, slip_y)
    new_x, new_y = drag(mu * push, p.fx, p.fy, slip_x, slip_y, k.p1, k.p2, k.p3)
    sticks = holds(stop_x, stop_y, stop_z, mu)
    dx = wp.where(sticks, stop_x, new_x) - p.fx
    dy = wp.where(sticks, stop_y, new_y) - p.fy
    dz = wp.where(sticks, stop_z, push) - p.n
    p.fx = p.fx + dx
    p.fy = p.fy + dy
    p.n = p.n + dz
    u.x = u.x + dx
    u.y = u.y + dy
    u.z = u.z + dz
    x, y, z = vector_product(at.x, at.y, at.h, dx, dy, dz)
    u.turn_x = fused(j.xz, z, fused(j.xy, y, fused(j.xx, x, u.turn_x)))
    u.turn_y = fused(j.yz, z, fused(j.yy, y, fused(j.xy, x, u.turn_y)))
    u.turn_z = fused(j.zz, z, fused(j.yz, y, fused(j.xz, x, u.turn_z)))


@wp.func
def integrate(
    live: bool, knobs: Knobs, inverse: Triple, dv: Triple, u: Velocity, lowest: real, s: State,
    loss: wp.ref[real],
) -> State:  # fmt: skip
    """The state of a block after a step, if its lane still runs.

    The loss for unit mass [J/kg] grows by the energy that contacts take: minus the work of their
    impulses on the mean of the velocities before and after, less the energy that lifting gives.
    """
    dt, zero = knobs.time_step, real(0.0)
    r = turn_of(s)
    # Body axes: momentum before, and the change of the angular velocity by contacts.
    a = elementwise_product(inverse, into_body(r, spin_of(s)))
    b = minus(into_body(r, rate_of(u)), a)
    h = Triple(b.x / inverse.x, b.y / inverse.y, b.z / inverse.z)
    p = Triple(u.x - s.vx + dv.x, u.y - s.vy + dv.y, u.z - s.vz + dv.z + dt * knobs.gravity)
    linear = scalar_product(p, Triple(s.vx + u.x, s.vy + u.y, s.vz + u.z))
    angular = scalar_product(h, plus(plus(a, a), b))
    lift = -knobs.erp * smaller(lowest + real(2.0) * dt * dt * knobs.gravity, zero)
    loss = loss - wp.where(live, HALF * (linear + angular) + knobs.gravity * lift, zero)
    spin = plus(spin_of(s), into_base(r, h))
    qx, qy, qz, qw = turn_freely(s.qx, s.qy, s.qz, s.qw, spin, inverse, dt)
    return State(
        wp.where(live, fused(dt, u.x, s.x), s.x), wp.where(live, fused(dt, u.y, s.y), s.y),
        wp.where(live, fused(dt, u.z, s.z + lift), s.z), wp.where(live, qx, s.qx),
        wp.where(live, qy, s.qy), wp.where(live, qz, s.qz), wp.where(live, qw, s.qw),
        u.x, u.y, u.z, spin.x, spin.y, spin.z,
    )  # fmt: skip
