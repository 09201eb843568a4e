"""Velocity-level contact step of a stack of blocks in space.

Bodies are numbered from the ground: body 0 is the ground, an endless face that nothing moves, body
k the k-th block. The step is that of a single block (see impulse_space/block.py), body by body. The
contacts of interface k, below block k, are the corners of the overlap of the bottom face of block k
and the top face below (see shape/faces.py), found once a step. All of an interface is in the axes
of its lower body, whose third one is the normal: impulses, slips, and places from the foot, the
point of the lower face under the upper centre of mass. With the levers c_u and c_l of the foot from
both centres, the upper body moves there, as seen from the lower one, at

    V = v_u + omega_u x c_u - v_l - omega_l x c_l,     W = omega_u - omega_l,

and a contact at r at V + W x r. Its impulse p changes V by L p + C (r x p) and W by C^T p + J (r x
p), where the sum over both bodies, of inverse mass 1/m, inverse inertia J_b and lever c, is

    L = sum 1/m - [c] J_b [c],     C = - sum [c] J_b,     J = sum J_b,     [c] x = c x x.

So a sweep knows two bodies by V and W alone while it visits an interface; then both get the sum of
its impulses.

A contact has that third axis for its normal, but where a corner of the lower face touches the upper
one, whose normal it has, and where edges of faces that are not parallel cross: there the normal is
that of both edges. Such contacts have directions of their own; the sweeps turn slips into them and
impulses back. Rows of contacts of which no lane has any leave that out.

A sweep pushes, then drags: it never stops a contact by itself. One after the other, such stops come
to a slide where a velocity step of the base presses corners so that they stick.

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
    Contact,
    Impulse,
    Knobs,
    Lean,
    Velocity,
    rate_of,
    side_of,
    spin_of,
)
from warprock.kernels.lane.modes import BROKEN, OVERTURNED, RUNNING, SLID_OFF
from warprock.kernels.shape.faces import (
    ALONG_DEPTH,
    LOWER,
    PARALLEL,
    Faces,
    crosses,
    edge_corner,
    lower_corner,
    upper_corner,
)
from warprock.kernels.shape.interface import GROUND_FACE
from warprock.kernels.shape_space.block import Block, slide_of, turn_freely, turns_of
from warprock.kernels.shape_space.block_found import Peaks, observe_slide, observe_turns
from warprock.kernels.shape_space.contact import drag, slip_gains
from warprock.kernels.shape_space.lanes import (
    State,
    Symmetric,
    Triple,
    Turn,
    inertia_of,
    into_base,
    into_body,
    minus,
    multiple,
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
"""Change of the impulses in a sweep that is round-off, over the weight of the stack in a step. With
a larger one round-off would decide how many sweeps a lane takes: a stack that stands straight then
yaws to either side."""


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
class Foot:
    """Levers of the foot of an interface, in the axes of its lower body.

    Attributes:
        height: Of the upper centre of mass above it [m].
        x, y, z: From the lower centre of mass [m].
    """

    height: real
    x: real
    y: real
    z: real


@wp.struct
class Mobility:
    """The matrices L, C and J of an interface, see above [1/kg, 1/(kg m), 1/(kg m^2)]."""

    l11: real
    l12: real
    l13: real
    l22: real
    l23: real
    l33: real
    c11: real
    c12: real
    c13: real
    c21: real
    c22: real
    c23: real
    c31: real
    c32: real
    c33: real
    j11: real
    j12: real
    j13: real
    j22: real
    j23: real
    j33: real


@wp.struct
class Effect:
    """Change of the relative motion of two bodies per impulse along x, y or z of a contact.

    Attributes:
        x1, x2, x3: Of V along x [1/kg]; likewise y and z.
        turn_x1, turn_x2, turn_x3: Of W about x [1/(kg m)]; likewise y and z.
    """

    x1: real
    x2: real
    x3: real
    y1: real
    y2: real
    y3: real
    z1: real
    z2: real
    z3: real
    turn_x1: real
    turn_x2: real
    turn_x3: real
    turn_y1: real
    turn_y2: real
    turn_y3: real
    turn_z1: real
    turn_z2: real
    turn_z3: real


@wp.struct
class Gains:
    """Effect of impulses at a contact; all but kx and ky are zero if it is no contact.

    Attributes:
        kx, ky: Slip velocity per normal impulse.
        pn: Inverse of the normal velocity per normal impulse.
        p1, p2, p3: See `slip_gains`.
    """

    kx: real
    ky: real
    pn: real
    p1: real
    p2: real
    p3: real


@wp.struct
class Wrench:
    """Sum of impulses [N s] and of their moments about the foot [N m s]."""

    x: real
    y: real
    z: real
    turn_x: real
    turn_y: real
    turn_z: real


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
def ground_under(lowest: Block) -> Block:
    """The ground as the body below the lowest block."""
    zero = real(0.0)
    ground = lowest
    ground.half_width = GROUND_FACE
    ground.half_depth = GROUND_FACE
    ground.half_height = zero
    ground.centre_x = zero
    ground.centre_y = zero
    return ground


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
def inverse_of(block: Block) -> Triple:
    """Inverse moments of inertia of a block about its axes, for unit mass [1/m^2]."""
    return Triple(block.inverse_x, block.inverse_y, block.inverse_z)


@wp.func
def find_foot(away: Triple, height: real) -> Foot:
    """The foot of an interface, see `place_between`; `height` is half that of the body below."""
    return Foot(away.z - height, away.x, away.y, height)


@wp.func
def find_contact(spot: Spot, lean: Lean, below: Block, foot: Foot, knobs: Knobs) -> Contact:
    """The contact at a slot, from the foot.

    Args:
        spot: The slot.
        lean: Sides to which the block leans.
        below: The body below.
        foot: Its levers.
        knobs: Settings.
    """
    zero, on = real(0.0), spot.on > real(0.0)
    x = lean.x * spot.x - below.centre_x - foot.x
    y = lean.y * spot.y - below.centre_y - foot.y
    aim = -larger(spot.gap, zero) * knobs.rate
    return Contact(
        wp.where(on, x, zero), wp.where(on, y, zero), wp.where(on, spot.gap, zero),
        wp.where(on, aim, zero), spot.on,
    )  # fmt: skip


@wp.func
def mobility_of(
    light: real, under: real, m: Turn, inverse: Triple, lower: Triple, foot: Foot
) -> Mobility:  # fmt: skip
    """What impulses at the foot do to the relative motion of two bodies.

    Args:
        light, under: Inverse masses of the upper and the lower body [1/kg].
        m: Attitude of the upper one in the axes of the lower one.
        inverse, lower: Inverse moments of inertia of both about their axes, for unit mass [1/m^2].
        foot: Levers.
    """
    j, jl = inertia_of(m, multiple(light, inverse)), multiple(under, lower)
    h, x, y, z, both = foot.height, foot.x, foot.y, foot.z, light + under
    hx, hy = h * j.xy, h * h * j.xy
    ax, bx, cx = jl.x * z, jl.y * x, jl.z * x
    ay, bz, cy = jl.x * y, jl.y * z, jl.z * y
    return Mobility(
        both + fused(h * h, j.yy, fused(bz, z, cy * y)), -fused(cx, y, hy), -bx * z,
        both + fused(h * h, j.xx, fused(ax, z, cx * x)), -ay * z, both + fused(ay, y, bx * x),
        -hx, fused_less(h, j.yy, bz), fused_less(h, j.yz, -cy),
        fused(h, j.xx, -ax), hx, fused(h, j.xz, cx),
        ay, -bx, real(0.0),
        j.xx + jl.x, j.xy, j.xz, j.yy + jl.y, j.yz, j.zz + jl.z,
    )  # fmt: skip


@wp.func
def effect_of(m: Mobility, at: Contact) -> Effect:
    """What impulses at a contact do; nothing if there is none."""
    x, y, h, on = at.x, at.y, at.h, at.on
    # r x e for e along x, y, z is (0, h, -y), (-h, 0, x), (y, -x, 0).
    return Effect(
        on * fused_less(m.c13, y, fused(m.c12, h, m.l11)),
        on * fused(m.c13, x, fused_less(m.c11, h, m.l12)),
        on * fused_less(m.c12, x, fused(m.c11, y, m.l13)),
        on * fused_less(m.c23, y, fused(m.c22, h, m.l12)),
        on * fused(m.c23, x, fused_less(m.c21, h, m.l22)),
        on * fused_less(m.c22, x, fused(m.c21, y, m.l23)),
        on * fused_less(m.c33, y, fused(m.c32, h, m.l13)),
        on * fused(m.c33, x, fused_less(m.c31, h, m.l23)),
        on * fused_less(m.c32, x, fused(m.c31, y, m.l33)),
        on * fused_less(m.j13, y, fused(m.j12, h, m.c11)),
        on * fused(m.j13, x, fused_less(m.j11, h, m.c21)),
        on * fused_less(m.j12, x, fused(m.j11, y, m.c31)),
        on * fused_less(m.j23, y, fused(m.j22, h, m.c12)),
        on * fused(m.j23, x, fused_less(m.j12, h, m.c22)),
        on * fused_less(m.j22, x, fused(m.j12, y, m.c32)),
        on * fused_less(m.j33, y, fused(m.j23, h, m.c13)),
        on * fused(m.j33, x, fused_less(m.j13, h, m.c23)),
        on * fused_less(m.j23, x, fused(m.j13, y, m.c33)),
    )  # fmt: skip


@wp.func
def yield_of(mobility: Mobility, at: Contact) -> Symmetric:
    """Velocity of a contact per impulse on it [1/kg]; the unit matrix if there is none."""
    off, effect = real(1.0) - at.on, effect_of(mobility, at)
    return Symmetric(
        off + fused_less(effect.turn_z1, at.y, fused(effect.turn_y1, at.h, effect.x1)),
        fused_less(effect.turn_z2, at.y, fused(effect.turn_y2, at.h, effect.x2)),
        fused_less(effect.turn_z3, at.y, fused(effect.turn_y3, at.h, effect.x3)),
        off + fused_less(effect.turn_x2, at.h, fused(effect.turn_z2, at.x, effect.y2)),
        fused_less(effect.turn_x3, at.h, fused(effect.turn_z3, at.x, effect.y3)),
        off + fused_less(effect.turn_y3, at.x, fused(effect.turn_x3, at.y, effect.z3)),
    )  # fmt: skip


@wp.func
def gains_of(k: Symmetric, on: real) -> Gains:
    """Effect of impulses at a contact on its velocity, from `yield_of`."""
    p1, p2, p3 = slip_gains(on, k.xx, k.xy, k.yy)
    return Gains(k.xz, k.yz, on / k.zz, p1, p2, p3)


@wp.func
def normal_of(slot: int, spot: Spot, m: Turn, faces: Faces) -> Triple:
    """Normal of the contact at a slot.

    Args:
        slot: The slot.
        spot: Its place.
        m: Attitude of the upper body in the axes of the lower one.
        faces: The two faces.
    """
    zero, one = real(0.0), real(1.0)
    tilted = size(m.r31) + size(m.r32) > PARALLEL
    lower = slot >= LOWER and tilted
    # Direction of an edge of the upper face.
    width = slot < ALONG_DEPTH
    ex, ey = wp.where(width, m.r11, m.r12), wp.where(width, m.r21, m.r22)
    wide = tilted and crosses(slot, spot.x, ey, faces.a)
    deep = tilted and not wide and crosses(slot, spot.y, ex, faces.b)
    down = -wp.where(width, m.r31, m.r32) * wp.sign(wp.where(wide, ex, ey))
    x = wp.where(lower, m.r13, wp.where(wide, down, zero))
    y = wp.where(lower, m.r23, wp.where(deep, down, zero))
    z = wp.where(lower, m.r33, wp.where(wide, size(ex), wp.where(deep, size(ey), one)))
    over = one / wp.sqrt(product(x, y, z, x, y, z))
    there = spot.on > zero
    return Triple(
        wp.where(there, over * x, zero), wp.where(there, over * y, zero),
        wp.where(there, over * z, one),
    )  # fmt: skip


@wp.func
def directions_of(n: Triple) -> Turn:
    """Directions of a contact with a normal, one a column: the first is as near x as can be."""
    one, zero = real(1.0), real(0.0)
    part = wp.sqrt(fused_less(n.x, n.x, one))
    x, y, z = part, -n.x * n.y / part, -n.x * n.z / part
    return Turn(x, zero, n.x, y, n.z / part, n.y, z, -n.y / part, n.z)


@wp.func
def turn_yield(k: Symmetric, axes: Turn) -> Symmetric:
    """`yield_of` along the directions of a contact."""
    a = into_body(axes, times(k, Triple(axes.r11, axes.r21, axes.r31)))
    b = into_body(axes, times(k, Triple(axes.r12, axes.r22, axes.r32)))
    c = into_body(axes, times(k, Triple(axes.r13, axes.r23, axes.r33)))
    return Symmetric(a.x, b.x, c.x, b.y, c.y, c.z)


@wp.func
def motion_between(foot: Foot, low: Turn, u: Velocity, below: Velocity) -> Velocity:
    """V and W, see above: a body as seen from the one below, in the axes `low`."""
    v = into_body(low, Triple(u.x - below.x, u.y - below.y, u.z - below.z))
    o = into_body(low, rate_of(u))
    b = into_body(low, rate_of(below))
    wx, wy, wz = vector_product(b.x, b.y, b.z, foot.x, foot.y, foot.z)
    return Velocity(
        fused_less(foot.height, o.y, v.x) - wx, fused(foot.height, o.x, v.y) - wy, v.z - wz,
        o.x - b.x, o.y - b.y, o.z - b.z,
    )  # fmt: skip


@wp.func
def slip_of(at: Contact, v: Velocity) -> Triple:
    """Velocity of a contact from that at the foot [m/s]."""
    return Triple(
        fused_less(v.turn_z, at.y, fused(v.turn_y, at.h, v.x)),
        fused_less(v.turn_x, at.h, fused(v.turn_z, at.x, v.y)),
        fused_less(v.turn_y, at.x, fused(v.turn_x, at.y, v.z)),
    )


@wp.func
def solve_contact(mu: real, at: Contact, g: Gains, p: Impulse, v: Triple) -> Impulse:
    """New impulses of a contact along its directions, by a Gauss-Seidel update [N s].

    Args:
        mu: Friction coefficient.
        at: The contact.
        g: Effect of its impulses.
        p: Its impulses so far [N s].
        v: Its velocity, see `slip_of` [m/s].
    """
    pushed = larger(fused_less(g.pn, v.z - at.aim, p.n), real(0.0))
    # Slip velocity after the normal impulse.
    more = pushed - p.n
    fx, fy = drag(
        mu * pushed, p.fx, p.fy, fused(more, g.kx, v.x), fused(more, g.ky, v.y), g.p1, g.p2, g.p3
    )
    return Impulse(fx, fy, pushed)


@wp.func
def moment_of(at: Contact, p: Triple) -> Triple:
    """Moment of an impulse at a contact about the foot [N m s]."""
    x, y, z = vector_product(at.x, at.y, at.h, p.x, p.y, p.z)
    return Triple(x, y, z)


@wp.func
def add_impulse(p: Triple, moment: Triple, sum: wp.ref[Wrench]):
    """Adds an impulse [N s] and its moment to those of an interface."""
    sum.x = sum.x + p.x
    sum.y = sum.y + p.y
    sum.z = sum.z + p.z
    sum.turn_x = sum.turn_x + moment.x
    sum.turn_y = sum.turn_y + moment.y
    sum.turn_z = sum.turn_z + moment.z


@wp.func
def with_product(u: real, a: real, b: real, c: real, p: Triple) -> real:
    """The sum of u and the scalar product of (a, b, c) and p."""
    return fused(c, p.z, fused(b, p.y, fused(a, p.x, u)))


@wp.func
def add_motion(m: Mobility, p: Triple, g: Triple, v: wp.ref[Velocity]):
    """Adds what an impulse p [N s] with the moment g about the foot [N m s] does to V and W."""
    v.x = with_product(with_product(v.x, m.l11, m.l12, m.l13, p), m.c11, m.c12, m.c13, g)
    v.y = with_product(with_product(v.y, m.l12, m.l22, m.l23, p), m.c21, m.c22, m.c23, g)
    v.z = with_product(with_product(v.z, m.l13, m.l23, m.l33, p), m.c31, m.c32, m.c33, g)
    v.turn_x = with_product(with_product(v.turn_x, m.c11, m.c21, m.c31, p), m.j11, m.j12, m.j13, g)
    v.turn_y = with_product(with_product(v.turn_y, m.c12, m.c22, m.c32, p), m.j12, m.j22, m.j23, g)
    v.turn_z = with_product(with_product(v.turn_z, m.c13, m.c23, m.c33, p), m.j13, m.j23, m.j33, g)


@wp.func
def square_of(p: Wrench, foot: Foot) -> real:
    """The square of the impulses of an interface, moments over the height [N^2 s^2]."""
    part = real(1.0) / foot.height
    mx, my, mz = part * p.turn_x, part * p.turn_y, part * p.turn_z
    return product(p.x, p.y, p.z, p.x, p.y, p.z) + product(mx, my, mz, mx, my, mz)


@wp.func
def push_upper(
    light: real, j: Symmetric, foot: Foot, low: Turn, p: Wrench, u: wp.ref[Velocity]
):  # fmt: skip
    """Gives the impulses of an interface to its upper body; see `push`."""
    moment = Triple(
        fused(foot.height, p.y, p.turn_x), fused_less(foot.height, p.x, p.turn_y), p.turn_z
    )
    push(light, j, into_base(low, Triple(p.x, p.y, p.z)), into_base(low, moment), u)


@wp.func
def push_lower(
    light: real, j: Symmetric, foot: Foot, low: Turn, p: Wrench, u: wp.ref[Velocity]
):  # fmt: skip
    """Gives the impulses of an interface to its lower body; see `push`."""
    mx, my, mz = vector_product(foot.x, foot.y, foot.z, p.x, p.y, p.z)
    moment = Triple(-p.turn_x - mx, -p.turn_y - my, -p.turn_z - mz)
    push(light, j, into_base(low, Triple(-p.x, -p.y, -p.z)), into_base(low, moment), u)


@wp.func
def push(light: real, j: Symmetric, p: Triple, moment: Triple, u: wp.ref[Velocity]):
    """Changes the velocity of a body by an impulse.

    Args:
        light: Inverse mass [1/kg].
        j: Inverse inertia, in the axes of the base [1/(kg m^2)].
        p: The impulse [N s].
        moment: Its moment about the centre of mass [N m s].
        u: The velocity; updated.
    """
    u.x = fused(light, p.x, u.x)
    u.y = fused(light, p.y, u.y)
    u.z = fused(light, p.z, u.z)
    u.turn_x = fused(j.xz, moment.z, fused(j.xy, moment.y, fused(j.xx, moment.x, u.turn_x)))
    u.turn_y = fused(j.yz, moment.z, fused(j.yy, moment.y, fused(j.xy, moment.x, u.turn_y)))
    u.turn_z = fused(j.zz, moment.z, fused(j.yz, moment.y, fused(j.xz, moment.x, u.turn_z)))


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
