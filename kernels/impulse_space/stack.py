"""Velocity-level contact step of a stack of blocks in space.

Bodies are numbered from the ground: body 0 is the ground, an endless face that nothing moves, body
k the k-th block. The step is that of a single block (see impulse_space/block.py), body by body. The
contacts of interface k, below block k, are the corners of the overlap of the bottom face of block k
and the top face below (see shape/faces.py), found once a step. Their normal is that of the lower
face; impulses and slips are along its width, its depth and its normal. The velocity of a contact at
the levers r_u and r_l from the centres of the two blocks is

    v_u + omega_u x r_u - v_l - omega_l x r_l.

The sweeps go from the ground up. In a mirrored scene they visit the corners of an interface in
mirrored order: slots are those of the mirror image in which the block leans to the positive side
along x and along y. erp moves all blocks above an interface along its normal, by erp times its
penetration beyond 2 g dt^2, the fall that one step can make. Angular momenta and moments of inertia
are those for unit mass, impulses are in N s.
"""

import warp as wp

from warprock.kernels.impulse.stack import drop_round_off
from warprock.kernels.impulse_space.block import (
    FAR,
    Gains,
    Impulse,
    Knobs,
    Lean,
    Velocity,
    rate_of,
    side_of,
    spin_of,
)
from warprock.kernels.lane.modes import BROKEN, OVERTURNED, RUNNING, SLID_OFF
from warprock.kernels.shape.faces import Faces, edge_corner, lower_corner, upper_corner
from warprock.kernels.shape.interface import GROUND_FACE
from warprock.kernels.shape_space.block import Block, slide_of, turn_freely, turns_of
from warprock.kernels.shape_space.block_found import Peaks, observe_slide, observe_turns
from warprock.kernels.shape_space.contact import drag, holds, slip_gains, stop_gains
from warprock.kernels.shape_space.lanes import (
    State,
    Symmetric,
    Triple,
    Turn,
    cross_product,
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

CORNERS = real(4.0)
"""Corners of the upper face; if all of them lie over the lower one, other slots do not exist."""

SETTLED = real(1.0e-14)
"""Relative change of the impulses in a sweep that is round-off."""


@wp.struct
class Spot:
    """A slot of an interface in a step.

    Attributes:
        x, y: Its place in the mirrored plan of the lower face [m].
        gap: Gap there [m].
        on: 1 if it is a contact, else 0.
    """

    x: real
    y: real
    gap: real
    on: real


@wp.struct
class Contact:
    """A contact of two bodies in a step.

    Attributes:
        ux, uy, uz: Lever from the upper centre of mass [m].
        lx, ly, lz: Lever from the lower one [m].
        gap: Its gap, zero if it sinks [m].
        on: 1 if it is one, else 0.
    """

    ux: real
    uy: real
    uz: real
    lx: real
    ly: real
    lz: real
    gap: real
    on: real


@wp.struct
class Opening:
    """Observed gaps of a lane in a step.

    Attributes:
        lifted: Slots that do not touch.
        landed: Slots that touch and did not before.
        deep: Deepest penetration of an interface [m].
    """

    lifted: real
    landed: real
    deep: real


@wp.struct
class Change:
    """Squares of the change of the impulses in a sweep, and of the impulses [N^2 s^2]."""

    change: real
    size: real


@wp.func
def turn_between(r: Turn, low: Turn) -> Turn:
    """Attitude of a block in the axes of another one."""
    a, b, c = (
        into_body(low, Triple(r.r11, r.r21, r.r31)),
        into_body(low, Triple(r.r12, r.r22, r.r32)),
        into_body(low, Triple(r.r13, r.r23, r.r33)),
    )
    return Turn(a.x, b.x, c.x, a.y, b.y, c.y, a.z, b.z, c.z)


@wp.func
def place_between(s: State, low: State, r: Turn) -> Triple:
    """Centre of mass from that of the body below, in the axes r of that body [m]."""
    return into_body(r, Triple(s.x - low.x, s.y - low.y, s.z - low.z))


@wp.func
def find_lean(
    m: Turn, low: Turn, u: Velocity, below: Velocity, hint: Triple, before: Lean
) -> Lean:  # fmt: skip
    """Sides along x and y to which a block leans on the body below, each -1 or 1.

    Args:
        m: Its attitude in the axes of the body below.
        low: Those axes.
        u, below: Velocities of both.
        hint: Present or next change of the base velocity [m/s].
        before: Sides that count if all of these are zero.
    """
    zero = real(0.0)
    rate = into_body(low, minus(rate_of(u), rate_of(below)))
    x = side_of(drop_round_off(-m.r31), drop_round_off(rate.y), hint.x, before.x)
    twist = drop_round_off(m.r21 * x)
    side = wp.where(twist != zero, twist, before.y)
    y = side_of(drop_round_off(-m.r32), drop_round_off(-rate.x), hint.y, side)
    return Lean(x, y)


@wp.func
def support_of(below: Block, k: int) -> Block:
    """The body below block k: the ground below the first one, else the given block."""
    first, zero = k == 1, real(0.0)
    below.half_width = wp.where(first, GROUND_FACE, below.half_width)
    below.half_depth = wp.where(first, GROUND_FACE, below.half_depth)
    below.half_height = wp.where(first, zero, below.half_height)
    below.centre_x = wp.where(first, zero, below.centre_x)
    below.centre_y = wp.where(first, zero, below.centre_y)
    return below


@wp.func
def spot_at(x: real, y: real, gap: real, there: bool, knobs: Knobs) -> Spot:
    """The slot of a corner: on if its gap is within the margin, FAR away if it does not exist."""
    on = wp.where(there and gap <= knobs.collision_margin, real(1.0), real(0.0))
    return Spot(x, y, wp.where(there, gap, FAR), on)


@wp.func
def find_upper_spot(slot: int, faces: Faces, knobs: Knobs, number: wp.ref[real]) -> Spot:
    """A corner of the upper face; adds it to the number of slots of its interface."""
    x, y, gap, there = upper_corner(slot, faces)
    number = number + wp.where(there, real(1.0), real(0.0))
    return spot_at(x, y, gap, there, knobs)


@wp.func
def find_edge_spot(
    slot: int, part: real, faces: Faces, knobs: Knobs, number: wp.ref[real]
) -> Spot:  # fmt: skip
    """A corner on an edge of the upper face, likewise; none if `part` is zero."""
    x, y, gap, exists = edge_corner(slot, faces)
    cut = exists and part > real(0.0)
    number = number + wp.where(cut, real(1.0), real(0.0))
    return spot_at(x, y, gap, cut, knobs)


@wp.func
def find_lower_spot(
    slot: int, part: real, faces: Faces, knobs: Knobs, number: wp.ref[real]
) -> Spot:  # fmt: skip
    """A corner of the lower face, likewise."""
    x, y, gap, exists = lower_corner(slot, faces)
    under = exists and part > real(0.0)
    number = number + wp.where(under, real(1.0), real(0.0))
    return spot_at(x, y, gap, under, knobs)


@wp.func
def observe_spot(spot: Spot, knobs: Knobs, apart: wp.ref[real], opens: wp.ref[Opening]):
    """Observes a slot.

    Args:
        spot: The slot.
        knobs: Settings.
        apart: 1 if it did not touch in the last step, else 0; updated.
        opens: Observed gaps of the interface; updated.
    """
    one, zero, gap = real(1.0), real(0.0), spot.gap
    there = gap < FAR
    was = apart > zero
    slack = fall_of(knobs)
    wide = there and gap > knobs.collision_margin + slack
    opens.deep = wp.where(there, larger(opens.deep, -gap), opens.deep)
    opens.lifted = opens.lifted + wp.where(wide, one, zero)
    opens.landed = opens.landed + wp.where(there and was and not wide, one, zero)
    apart = wp.where(wide, one, zero)


@wp.func
def fall_of(knobs: Knobs) -> real:
    """The fall that one step can make [m]."""
    return real(2.0) * knobs.time_step * knobs.time_step * knobs.gravity


@wp.func
def rise_of(knobs: Knobs, opens: Opening, low: Turn, shift: wp.ref[Triple], total: wp.ref[Opening]):
    """Adds an interface to what a lane observes in a step, and its correction to the shift.

    Args:
        knobs: Settings.
        opens: Observed gaps of the interface.
        low: Axes of its lower body.
        shift: Correction of all blocks above [m]; updated.
        total: Observed gaps of the lane; updated.
    """
    rise = knobs.erp * larger(opens.deep - fall_of(knobs), real(0.0))
    shift.x = shift.x + rise * low.r13
    shift.y = shift.y + rise * low.r23
    shift.z = shift.z + rise * low.r33
    total.lifted = total.lifted + opens.lifted
    total.landed = total.landed + opens.landed
    total.deep = larger(total.deep, opens.deep)


@wp.func
def find_contact(
    on: bool, spot: Spot, lean: Lean, below: Block, low: Turn, s: State, under: State
) -> Contact:  # fmt: skip
    """A contact at a slot.

    Args:
        on: Whether it is one.
        spot: The slot.
        lean: Sides to which the block leans.
        below: The body below.
        low: Its axes.
        s: The block.
        under: The state of the body below.
    """
    zero = real(0.0)
    x, y = lean.x * spot.x - below.centre_x, lean.y * spot.y - below.centre_y
    r = into_base(low, Triple(x, y, spot.gap + below.half_height))
    return Contact(
        wp.where(on, r.x + under.x - s.x, zero), wp.where(on, r.y + under.y - s.y, zero),
        wp.where(on, r.z + under.z - s.z, zero), wp.where(on, r.x, zero), wp.where(on, r.y, zero),
        wp.where(on, r.z, zero), wp.where(on, larger(spot.gap, zero), zero),
        wp.where(on, real(1.0), zero),
    )  # fmt: skip


@wp.func
def gains_of(both: real, r: Turn, ju: Symmetric, jl: Symmetric, at: Contact) -> Gains:
    """Effect of impulses at a contact.

    Args:
        both: Sum of the inverse masses of its bodies [1/kg].
        r: Axes of the lower body, the directions of the contact.
        ju, jl: Inverse inertia of the upper body [1/(kg m^2)] and of the lower one.
        at: The contact.
    """
    one = real(1.0)
    ru, rl = Triple(at.ux, at.uy, at.uz), Triple(at.lx, at.ly, at.lz)
    e1, e2, e3 = (
        Triple(r.r11, r.r21, r.r31), Triple(r.r12, r.r22, r.r32), Triple(r.r13, r.r23, r.r33)
    )  # fmt: skip
    u1, u2, u3 = cross_product(ru, e1), cross_product(ru, e2), cross_product(ru, e3)
    l1, l2, l3 = cross_product(rl, e1), cross_product(rl, e2), cross_product(rl, e3)
    ju1, ju2, ju3 = times(ju, u1), times(ju, u2), times(ju, u3)
    jl1, jl2, jl3 = times(jl, l1), times(jl, l2), times(jl, l3)
    k11 = both + scalar_product(u1, ju1) + scalar_product(l1, jl1)
    k12 = scalar_product(u1, ju2) + scalar_product(l1, jl2)
    k13 = scalar_product(u1, ju3) + scalar_product(l1, jl3)
    k22 = both + scalar_product(u2, ju2) + scalar_product(l2, jl2)
    k23 = scalar_product(u2, ju3) + scalar_product(l2, jl3)
    k33 = both + scalar_product(u3, ju3) + scalar_product(l3, jl3)
    p1, p2, p3 = slip_gains(one, k11, k12, k22)
    h = stop_gains(one, Symmetric(k11, k12, k13, k22, k23, k33))
    return Gains(k13, k23, one / k33, p1, p2, p3, h.xx, h.xy, h.xz, h.yy, h.yz, h.zz)


@wp.func
def velocity_at(u: Velocity, x: real, y: real, z: real) -> Triple:
    """Velocity of a point of a body at a lever from its centre of mass [m/s]."""
    return Triple(
        fused_less(u.turn_z, y, fused(u.turn_y, z, u.x)),
        fused_less(u.turn_x, z, fused(u.turn_z, x, u.y)),
        fused_less(u.turn_y, x, fused(u.turn_x, y, u.z)),
    )


@wp.func
def slip_between(at: Contact, u: Velocity, low: Velocity) -> Triple:
    """Velocity of a contact on the upper body as seen from the lower one [m/s]."""
    return minus(velocity_at(u, at.ux, at.uy, at.uz), velocity_at(low, at.lx, at.ly, at.lz))


@wp.func
def solve_contact(
    mu: real, rate: real, at: Contact, g: Gains, r: Turn, p: Impulse, slip: Triple
) -> Impulse:  # fmt: skip
    """New impulses of a contact along its directions, by a Gauss-Seidel update [N s].

    Args:
        mu: Friction coefficient.
        rate: Inverse of the time step [1/s].
        at: The contact.
        g: Effect of its impulses.
        r: Axes of the lower body.
        p: Its impulses so far [N s].
        slip: Its velocity, see `slip_between` [m/s].
    """
    zero = real(0.0)
    v = into_body(r, slip)
    z = fused(at.gap, rate, v.z)
    stop_x = p.fx - product(g.h11, g.h12, g.h13, v.x, v.y, z)
    stop_y = p.fy - product(g.h12, g.h22, g.h23, v.x, v.y, z)
    stop_z = p.n - product(g.h13, g.h23, g.h33, v.x, v.y, z)
    sticks = holds(stop_x, stop_y, stop_z, mu)
    pushed = larger(fused_less(g.pn, z, p.n), zero)
    # Slip velocity after the normal impulse.
    more = pushed - p.n
    fx, fy = drag(
        mu * pushed, p.fx, p.fy, fused(more, g.kx, v.x), fused(more, g.ky, v.y), g.p1, g.p2, g.p3
    )
    return Impulse(
        wp.where(sticks, stop_x, fx), wp.where(sticks, stop_y, fy), wp.where(sticks, stop_z, pushed)
    )


@wp.func
def add_change(change: Triple, p: Impulse, sums: wp.ref[Change]):
    """Adds a contact's change of its impulse in a sweep, and its impulse."""
    sums.change = sums.change + scalar_product(change, change)
    q = Triple(p.fx, p.fy, p.n)
    sums.size = sums.size + scalar_product(q, q)


@wp.func
def push(light: real, j: Symmetric, x: real, y: real, z: real, p: Triple, u: wp.ref[Velocity]):
    """Applies an impulse p [N s] at the lever (x, y, z) to the velocity u of a body.

    light is its inverse mass [1/kg], j its inverse inertia [1/(kg m^2)].
    """
    u.x = fused(light, p.x, u.x)
    u.y = fused(light, p.y, u.y)
    u.z = fused(light, p.z, u.z)
    a, b, c = vector_product(x, y, z, p.x, p.y, p.z)
    u.turn_x = fused(j.xz, c, fused(j.xy, b, fused(j.xx, a, u.turn_x)))
    u.turn_y = fused(j.yz, c, fused(j.yy, b, fused(j.xy, a, u.turn_y)))
    u.turn_z = fused(j.zz, c, fused(j.yz, b, fused(j.xz, a, u.turn_z)))


@wp.func
def integrate(
    settles: bool, dt: real, gravity: real, inverse: Triple, dv: Triple, s: State, u: Velocity,
    lift: Triple,
):  # fmt: skip
    """The state of a block after a step; before the first one, half a step back.

    Args:
        settles: Whether the step only finds impulses.
        dt: Time step [s].
        gravity: [m/s^2].
        inverse: Inverse moments of inertia of the block about its axes, for unit mass [1/m^2].
        dv: Change of the base velocity [m/s].
        s: The block before the step.
        u: Its velocity after it.
        lift: Correction of penetrations by erp [m].

    Returns:
        The block after the step, and the energy that its contacts took, for unit mass [J/kg].
    """
    one, r, half = real(1.0), turn_of(s), -HALF
    o = rate_of(u)
    before = times(inertia_of(r, inverse), spin_of(s))
    heavy = inertia_of(r, Triple(one / inverse.x, one / inverse.y, one / inverse.z))
    gain = times(heavy, minus(o, before))
    px, py, pz = u.x - s.vx + dv.x, u.y - s.vy + dv.y, u.z - s.vz + dv.z + dt * gravity
    linear = scalar_product(Triple(px, py, pz), Triple(s.vx + u.x, s.vy + u.y, s.vz + u.z))
    angular = scalar_product(gain, plus(before, o))
    work = HALF * (linear + angular) + gravity * lift.z
    spin = plus(spin_of(s), gain)
    qx, qy, qz, qw = turn_freely(s.qx, s.qy, s.qz, s.qw, spin, inverse, dt)
    after = State(
        wp.where(settles, s.x, s.x + dt * u.x + lift.x),
        wp.where(settles, s.y, s.y + dt * u.y + lift.y),
        wp.where(settles, s.z, s.z + dt * u.z + lift.z),
        wp.where(settles, s.qx, qx), wp.where(settles, s.qy, qy),
        wp.where(settles, s.qz, qz), wp.where(settles, s.qw, qw),
        wp.where(settles, half * u.x, u.x), wp.where(settles, half * u.y, u.y),
        wp.where(settles, half * u.z, u.z), wp.where(settles, half * gain.x, spin.x),
        wp.where(settles, half * gain.y, spin.y), wp.where(settles, half * gain.z, spin.z),
    )  # fmt: skip
    return after, wp.where(settles, real(0.0), -work)


@wp.func
def observe_block(
    live: bool, time: real, block: Block, s: State, m: Turn, c: Triple, peaks: Peaks
) -> Peaks:
    """Observed response of a block after a step, if its lane still runs.

    m is its attitude in the axes of the body below, c its centre of mass from that of that body, in
    those axes [m].
    """
    r = turn_of(s)
    along, across, tilt, yaw = turns_of(block, r.r13, r.r23, r.r33, s.qz, s.qw)
    x, y = slide_of(block, c.x, c.y, m)
    turned = observe_turns(live, time, along, across, tilt, yaw, peaks)
    return observe_slide(live, x, y, x * x + y * y, turned)


@wp.func
def mode_after(mode: int, shares: real, s: State, up: real, above: real) -> int:
    """The mode of a lane after one of its blocks has moved.

    Args:
        mode: Its mode before.
        shares: Not zero if the block overlaps the face below.
        s: The block.
        up, above: Parts of its axis along the vertical and along the axis of the body below.
    """
    sums = s.x + s.vx + s.vy + s.vz + (s.lx + s.ly + s.lz) + up
    found = wp.where(shares > real(0.0), RUNNING, SLID_OFF)
    found = wp.where(smaller(up, above) <= real(0.0), OVERTURNED, found)
    found = wp.where(sums - sums == real(0.0), found, BROKEN)
    return wp.where(mode == RUNNING, found, mode)
