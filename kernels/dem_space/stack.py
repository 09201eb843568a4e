"""Soft-spring (distinct element) step of blocks in space.

Bodies are numbered from the ground. Body 0 is the ground, an infinite flat face at rest; body k is
the k-th block. Heights are stored as differences from those of the stack of rigid blocks, so that
no digits of an overlap are lost.

Interface k lies between body k (upper) and body k - 1 (lower). Its levers are in the axes of the
lower body, velocities and forces along the directions of its contact, of which the third is its
normal n, see stack_meet.py. The springs are spread over the part of the upper block's bottom face
above the lower one's top face, as a grid along the width (A) and the depth (B). A point at (a, b),
each from -1 to 1, has

    lever    P = p + a A + b B       from the upper centre of mass, d + a A + b B from the lower one
    overlap  o + a o_a + b o_b,      o_a = -n_3 A_3, o_b = -n_3 B_3
    velocity V = v + a v_a + b v_b,  v_a = (w_upper - w_lower) x A, v_b likewise

All three are linear in a and b, so their coefficients are computed once for the interface. Stresses
at a point, per unit of area (Eq. 3 and 4 of the paper, with a dashpot beta k in parallel):

    normal   N = k_n (o + slip tan(psi)) - beta k_n V_3,      N >= -f_t while intact
    shear    T = -k_s (u + beta V_t),  u' = V_t = (V_1, V_2),  |T| <= c + N tan(phi)
             or, friction as a box: |T_1| and |T_2| each

A point opens if its spring is in tension beyond f_t, and then carries nothing. A dashpot never
pulls by more than f_t either. A point slips if |T| reaches its bound; u is then the stretch at that
bound. On the cone T keeps its direction, on the box T_1 and T_2 are bound separately.
The first slip or opening of a point removes its f_t and c for good. Opening resets u to zero and
keeps the dilation.

A step is one of central differences, with velocities and angular momenta L at half steps. Stresses
follow from positions at n and velocities at n - 1/2, so dashpots lag by half a step. Then
v(n + 1/2) = v(n - 1/2) + dt F / m - dv_base and L(n + 1/2) = L(n - 1/2) + dt M. Positions and
attitudes then move freely at these, see `turn_freely` in shape_space/block.py.

Points are visited in pairs +-(a, b). Pairs on one diagonal, on the other one and on the axes have
separate sums (`kind`), so that a scene mirrored in x or in y has mirrored forces to round-off.

Cundall and Strack (1979) for the scheme, Cundall (1988) for blocks in space.
"""

import warp as wp

from warprock.kernels.dem.stack import FAILED, Knobs
from warprock.kernels.dem_space.stack_meet import (
    Link,
    clip_to_face,
    out_of_contact,
    out_of_lower,
    parts_along,
)
from warprock.kernels.shape_space.block import Block, turn_freely
from warprock.kernels.shape_space.lanes import State, Triple, product, turn_of, vector_product

CONE = FRICTION == "cone"
"""Whether shear is bound as a cone, else as a box along the two directions."""
NEAR_ZERO = real(1.0e-30)
"""Square of a stress below which it has no direction."""


@wp.struct
class Pace:
    """How a lane steps.

    Attributes:
        dt: Time step [s].
        creep: Speed up to which faces may slip back and forth on their springs and not slide [m/s].
        span: Time over which the forces of this step act [s]: half a step in the first one.
        live: 1 while the lane runs, else 0.
        steps: Steps taken.
    """

    dt: real
    creep: real
    span: real
    live: int
    steps: int


@wp.struct
class Jolt:
    """Change of the velocity of the base in a step [m/s]."""

    x: real
    y: real
    z: real


@wp.struct
class Load:
    """What acts on a body, in the axes of the base.

    Attributes:
        fx, fy, fz: Force [N].
        mx, my, mz: Its moment about the centre of mass [N m].
    """

    fx: real
    fy: real
    fz: real
    mx: real
    my: real
    mz: real


@wp.struct
class Shear:
    """Shear stresses of a point within their bound [N/m^2].

    Attributes:
        x, y: Along the two directions.
        sticks_x, sticks_y: Whether they stick.
        over: One over what was wanted [m^2/N].
    """

    x: real
    y: real
    sticks_x: bool
    sticks_y: bool
    over: real


@wp.struct
class Spring:
    """State of the spring of a point.

    Attributes:
        ux, uy: Stretch along the two directions [m].
        slip: Slip so far [m], zero only of a point that never slipped or opened.
    """

    ux: real
    uy: real
    slip: real


@wp.struct
class Touch:
    """How faces meet at a point.

    Attributes:
        overlap: Depth to which they overlap [m].
        vn: Velocity at which they part [m/s].
        vx, vy: Velocity at which they slide [m/s].
    """

    overlap: real
    vn: real
    vx: real
    vy: real


@wp.struct
class Stress:
    """What a point bears.

    Attributes:
        n, x, y: N, T_1 and T_2 [N/m^2].
        energy: Twice the energy in its springs [J/m^2].
    """

    n: real
    x: real
    y: real
    energy: real


@wp.struct
class Sums:
    """Sums over points, each times its share of the area.

    Attributes:
        n, na, nb: N [N/m^2], and its first moments over the half lengths.
        t1, ta1, tb1: T_1, likewise.
        t2, ta2, tb2: T_2, likewise.
        energy: Twice the energy [J/m^2].
    """

    n: real
    na: real
    nb: real
    t1: real
    ta1: real
    tb1: real
    t2: real
    ta2: real
    tb2: real
    energy: real


@wp.struct
class Pair:
    """Two points of an interface, -(a, b) and (a, b).

    Attributes:
        a, b: Place along the width over the half length and along the depth.
        share: Part of the area that each of the two stands for.
    """

    a: real
    b: real
    share: real


@wp.func
def bind(want_x: real, want_y: real, bound: real) -> Shear:
    """Wanted shear stresses within their bound."""
    one = real(1.0)
    square = dot(want_x, want_y, want_x, want_y)
    over = one / wp.sqrt(larger(square, NEAR_ZERO))
    sticks_x = square <= bound * bound
    sticks_y = sticks_x
    part = wp.where(sticks_x, one, bound * over)
    shear_x, shear_y = part * want_x, part * want_y
    if not CONE:
        sticks_x = size(want_x) <= bound
        sticks_y = size(want_y) <= bound
        shear_x = larger(smaller(want_x, bound), -bound)
        shear_y = larger(smaller(want_y, bound), -bound)
    return Shear(shear_x, shear_y, sticks_x, sticks_y, over)


@wp.func
def load_spring(
    knobs: Knobs, live: bool, mu: real, dt: real, touch: Touch, spring: wp.ref[Spring]
) -> Stress:
    """Stresses at one point, see the head of this file; its spring follows.

    Args:
        knobs: The settings.
        live: Whether the lane still runs.
        mu: tan(phi).
        dt: Time step [s].
        touch: How the faces meet there.
        spring: Its spring.
    """
    zero = real(0.0)
    old_x = real(spring.ux)
    old_y = real(spring.uy)
    slips = real(spring.slip)
    vx, vy = touch.vx, touch.vy
    intact = slips == zero
    pull = wp.where(intact, knobs.tensile_strength, zero)
    pressed = fused(knobs.dilatancy, slips, touch.overlap)
    elastic = knobs.normal_stiffness * pressed
    closed = elastic > -pull
    damped = fused_less(knobs.stiffness_damping * knobs.normal_stiffness, touch.vn, elastic)
    normal = wp.where(closed, larger(damped, -pull), zero)
    held = fused(mu, normal, wp.where(intact, knobs.cohesion, zero))
    bound = wp.where(closed, larger(held, zero), zero)
    new_x, new_y = fused(dt, vx, old_x), fused(dt, vy, old_y)
    want_x = -knobs.shear_stiffness * fused(knobs.stiffness_damping, vx, new_x)
    want_y = -knobs.shear_stiffness * fused(knobs.stiffness_damping, vy, new_y)
    shear = bind(want_x, want_y, bound)
    kept_x = wp.where(shear.sticks_x, new_x, -knobs.shear_flexibility * shear.x)
    kept_y = wp.where(shear.sticks_y, new_y, -knobs.shear_flexibility * shear.y)
    held_energy = knobs.shear_stiffness * dot(kept_x, kept_y, kept_x, kept_y)
    energy = wp.where(closed, fused(elastic, pressed, held_energy), held_energy)
    lost_x, lost_y = new_x - kept_x, new_y - kept_y
    slid = shear.over * dot(lost_x, lost_y, want_x, want_y)
    if not CONE:
        slid = wp.sqrt(dot(lost_x, lost_y, lost_x, lost_y))
    spring.ux = wp.where(live, kept_x, old_x)
    spring.uy = wp.where(live, kept_y, old_y)
    moved = wp.where(closed, slips + size(slid), larger(slips, FAILED))
    spring.slip = wp.where(live, moved, slips)
    return Stress(normal, shear.x, shear.y, energy)


@wp.func
def touch_at(link: Link, a: real, b: real) -> Touch:
    """How the faces of an interface meet at the point (a, b)."""
    return Touch(
        fused(b, link.over_b, fused(a, link.over_a, link.overlap)),
        fused(b, link.k3, fused(a, link.j3, link.v3)),
        fused(b, link.k1, fused(a, link.j1, link.v1)),
        fused(b, link.k2, fused(a, link.j2, link.v2)),
    )


@wp.func
def solve_point(
    knobs: Knobs, link: Link, pace: Pace, a: real, b: real, spring: wp.ref[Spring]
) -> Stress:
    """Stresses at the point (a, b) of an interface; its spring follows."""
    f, g = clip_to_face(link, a, b)
    return load_spring(knobs, pace.live == 1, link.mu, pace.dt, touch_at(link, f, g), spring)


@wp.func
def add_pair(link: Link, pair: Pair, one: Stress, two: Stress, sums: wp.ref[Sums]):
    """Adds what the points at -(a, b) and (a, b) bear to the sums of an interface."""
    share = pair.share
    f, g = clip_to_face(link, -pair.a, -pair.b)
    h, q = clip_to_face(link, pair.a, pair.b)
    # f n1 + h n2 by sums and differences, which mirrored scenes mirror to the last bit.
    h, f = share * HALF * (h - f), share * HALF * (h + f)
    q, g = share * HALF * (q - g), share * HALF * (q + g)
    sums.n = fused(share, one.n + two.n, sums.n)
    sums.na = fused(h, two.n - one.n, fused(f, one.n + two.n, sums.na))
    sums.nb = fused(q, two.n - one.n, fused(g, one.n + two.n, sums.nb))
    sums.t1 = fused(share, one.x + two.x, sums.t1)
    sums.ta1 = fused(h, two.x - one.x, fused(f, one.x + two.x, sums.ta1))
    sums.tb1 = fused(q, two.x - one.x, fused(g, one.x + two.x, sums.tb1))
    sums.t2 = fused(share, one.y + two.y, sums.t2)
    sums.ta2 = fused(h, two.y - one.y, fused(f, one.y + two.y, sums.ta2))
    sums.tb2 = fused(q, two.y - one.y, fused(g, one.y + two.y, sums.tb2))
    sums.energy = fused(share, one.energy + two.energy, sums.energy)


@wp.func
def add_sums(axis: Sums, first: Sums, second: Sums) -> Sums:
    """Sums over all pairs: those on the axes, on one diagonal and on the other."""
    return Sums(
        (axis.n + first.n) + second.n,
        (axis.na + first.na) + second.na,
        (axis.nb + first.nb) + second.nb,
        (axis.t1 + first.t1) + second.t1,
        (axis.ta1 + first.ta1) + second.ta1,
        (axis.tb1 + first.tb1) + second.tb1,
        (axis.t2 + first.t2) + second.t2,
        (axis.ta2 + first.ta2) + second.ta2,
        (axis.tb2 + first.tb2) + second.tb2,
        (axis.energy + first.energy) + second.energy,
    )


@wp.func
def load_blocks(
    lower: State, link: Link, sums: Sums, above: wp.ref[Load], below: wp.ref[Load]
) -> real:
    """Adds the forces of the springs of an interface to the loads on its two blocks.

    Returns:
        The energy in the springs [J].
    """
    a1, a2, a3 = out_of_contact(link, sums.ta1, sums.ta2, sums.na)
    b1, b2, b3 = out_of_contact(link, sums.tb1, sums.tb2, sums.nb)
    f1, f2, f3 = out_of_contact(link, sums.t1, sums.t2, sums.n)
    s1, s2, s3 = vector_product(link.a1, link.a2, link.a3, a1, a2, a3)
    r1, r2, r3 = vector_product(link.b1, link.b2, link.b3, b1, b2, b3)
    moment_x, moment_y, moment_z = s1 + r1, s2 + r2, s3 + r3
    upper_x, upper_y, upper_z = vector_product(link.p1, link.p2, link.p3, f1, f2, f3)
    lower_x, lower_y, lower_z = vector_product(link.d1, link.d2, link.d3, f1, f2, f3)
    force_x, force_y, force_z = out_of_lower(lower, f1, f2, f3)
    upper_x, upper_y, upper_z = out_of_lower(
        lower, upper_x + moment_x, upper_y + moment_y, upper_z + moment_z
    )
    lower_x, lower_y, lower_z = out_of_lower(
        lower, lower_x + moment_x, lower_y + moment_y, lower_z + moment_z
    )
    above.fx = fused(link.area, force_x, above.fx)
    above.fy = fused(link.area, force_y, above.fy)
    above.fz = fused(link.area, force_z, above.fz)
    above.mx = fused(link.area, upper_x, above.mx)
    above.my = fused(link.area, upper_y, above.my)
    above.mz = fused(link.area, upper_z, above.mz)
    below.fx = fused_less(link.area, force_x, below.fx)
    below.fy = fused_less(link.area, force_y, below.fy)
    below.fz = fused_less(link.area, force_z, below.fz)
    below.mx = fused_less(link.area, lower_x, below.mx)
    below.my = fused_less(link.area, lower_y, below.my)
    below.mz = fused_less(link.area, lower_z, below.mz)
    return real(0.5) * link.area * sums.energy


@wp.func
def accelerate(over: real, drag: real, fx: real, fy: real, fz: real, vx: real, vy: real, vz: real):
    """Acceleration by a force, or by a moment, with mass damping."""
    return fused(over, fx, -drag * vx), fused(over, fy, -drag * vy), fused(over, fz, -drag * vz)


@wp.func
def integrate(
    pace: Pace, block: Block, knobs: Knobs, jolt: Jolt, load: Load, s: wp.ref[State],
    loss: wp.ref[real],
):  # fmt: skip
    """Moves a block by a step, and adds what its load takes of its energy to `loss` [J]."""
    live, dt, span = pace.live == 1, pace.dt, pace.span
    mass, over, drag = block.mass, real(1.0) / block.mass, knobs.mass_damping
    ix, iy, iz = block.inverse_x, block.inverse_y, block.inverse_z
    px, py, pz = accelerate(over, drag, load.fx, load.fy, load.fz, s.vx, s.vy, s.vz)
    ax, ay, az = accelerate(over, drag, load.mx, load.my, load.mz, s.lx, s.ly, s.lz)
    ux, uy = fused(span, px, s.vx - jolt.x), fused(span, py, s.vy - jolt.y)
    uz = fused(span, pz - knobs.gravity, s.vz - jolt.z)
    kx, ky, kz = fused(span, ax, s.lx), fused(span, ay, s.ly), fused(span, az, s.lz)
    axes = turn_of(s)
    spin_x, spin_y, spin_z = parts_along(axes, s.lx + kx, s.ly + ky, s.lz + kz)
    moment_x, moment_y, moment_z = parts_along(axes, ax, ay, az)
    moved = product(px, py, pz, s.vx + ux, s.vy + uy, s.vz + uz)
    turned = product(spin_x * ix, spin_y * iy, spin_z * iz, moment_x, moment_y, moment_z)
    work = HALF * span * mass * (moved + turned)
    qx, qy, qz, qw = turn_freely(s.qx, s.qy, s.qz, s.qw, Triple(kx, ky, kz), Triple(ix, iy, iz), dt)
    loss = loss - wp.where(live, work, real(0.0))
    s.x = wp.where(live, fused(dt, ux, s.x), s.x)
    s.y = wp.where(live, fused(dt, uy, s.y), s.y)
    s.z = wp.where(live, fused(dt, uz, s.z), s.z)
    s.qx = wp.where(live, qx, s.qx)
    s.qy = wp.where(live, qy, s.qy)
    s.qz = wp.where(live, qz, s.qz)
    s.qw = wp.where(live, qw, s.qw)
    s.vx = wp.where(live, ux, s.vx)
    s.vy = wp.where(live, uy, s.vy)
    s.vz = wp.where(live, uz, s.vz)
    s.lx = wp.where(live, kx, s.lx)
    s.ly = wp.where(live, ky, s.ly)
    s.lz = wp.where(live, kz, s.lz)
