"""Soft-spring (distinct element) step of a stack of rocking blocks.

Bodies are numbered from the ground. Body 0 is the ground, an infinite flat face at rest; body k is
the k-th block. Positions are in the frame of the base. Body k has its centre of mass at (x, z), the
half height h, the half width f of its faces, and the clockwise rotation theta with sine s and
cosine c. Its faces point along e = (c, -s); their normal is n = (s, c). Heights are stored as
differences from those of the stack of rigid blocks, so that no digits of an overlap are lost.

Interface k lies between body k (upper) and body k - 1 (lower). Springs spread over the overlap of
the upper block's bottom face with the lower one's top face. They belong to the face whose corner
closes as the interface rocks on, the *slave*, and press on the plane of the other face, with its n
and e. D = theta_upper - theta_lower is the relative rotation, g the gap in the middle (a = 0) and
(P, Q) the lever of the middle from the slave's centre along e and n. A point at a along the slave's
face has

    gap                g - a sin D
    normal velocity    v_n = w_n - D' P
    sliding velocity   v_t = w_t + D' Q

All three are linear in a, so their coefficients are computed once for the interface. Stresses at a
point, per unit of area (Eq. 3 and 4 of the paper, with a dashpot beta k in parallel):

    normal   N = k_n (o + slip tan(psi)) - beta k_n v_n,    o = -gap, N >= -f_t while intact
    shear    T = -k_s (u + beta v_t),  u' = v_t,            |T| <= c + N tan(phi)

A point opens if its spring is in tension beyond f_t, and then carries nothing. A dashpot never
pulls by more than f_t either. A point slips if T reaches its bound; u is then the stretch at that
bound. The first slip or opening of a point removes its f_t and c for good. Opening
resets u to zero and keeps the dilation.

A step is one of central differences, with velocities at half steps. Stresses follow from positions
at n and velocities at n - 1/2, so dashpots lag by half a step. Then
v(n + 1/2) = v(n - 1/2) + dt F / m - dv_base and q(n + 1) = q(n) + dt v(n + 1/2).

Points are visited in pairs at the same distance from the middle of the overlap. The sums and
differences of a pair are exact mirror images in a mirrored scene.

Cundall and Strack (1979) for the scheme, Cundall (1988) for blocks.
"""

import warp as wp

from warprock.kernels.shape.interface import Box, Mass, Pose, Velocity
from warprock.kernels.shape.rising import base_work

STEEPEST = real(0.1)
"""Smallest cosine of the angle between two faces for which their overlap still grows."""
FAILED = real(1.0e-30)
"""Slip that marks a point that has opened [m]; an intact point has exactly zero."""


@wp.struct
class Block:
    """One block of a stack and its state at the start.

    z is relative to its height on rigid blocks, `stretch` that of the shear springs below it; vx,
    vz and omega are its velocities.
    """

    half_width: real
    half_height: real
    inverse_mass: real
    inverse_inertia: real
    friction: real
    depth: real
    offset: real
    x: real
    z: real
    theta: real
    stretch: real
    vx: real
    vz: real
    omega: real


@wp.struct
class Interface:
    """The interface below a block: friction coefficient, depth, position without slide [m]."""

    friction: real
    depth: real
    start: real


@wp.struct
class Knobs:
    """Settings of a step."""

    gravity: real
    normal_stiffness: real
    shear_stiffness: real
    shear_flexibility: real
    stiffness_damping: real
    mass_damping: real
    cohesion: real
    tensile_strength: real
    dilatancy: real


@wp.struct
class Pace:
    """The clock of a lane.

    Attributes:
        dt: Time step [s].
        span: Time over which the forces of this step act [s]: half a step in the first one.
        live: 1 if the lane takes this step, else 0.
        steps: Steps including this one.
    """

    dt: real
    span: real
    live: int
    steps: int


@wp.struct
class Base:
    """Velocities of the base along x and upwards, and their changes in the step [m/s]."""

    vx: real
    dx: real
    vz: real
    dz: real


@wp.struct
class Energy:
    """Energies of a lane [J].

    Attributes:
        loss: Work of the springs and of mass damping against the blocks so far.
        spent: That work before this step.
        stored: Energy in the springs.
        at_start: Energy in the springs in the first step.
    """

    loss: real
    spent: real
    stored: real
    at_start: real


@wp.struct
class Spring:
    """The springs of a point.

    Attributes:
        u: Stretch of the shear spring [m].
        slip: Slip so far [m], zero only of a point that never slipped or opened.
    """

    u: real
    slip: real


@wp.struct
class Load:
    """Force on a block [N], and its clockwise moment [N m]."""

    x: real
    z: real
    moment: real


@wp.struct
class Stretch:
    """The stretch that two faces share; names as at the head of this file.

    Attributes:
        ps, pc: Sine and cosine of the rotation of the plane.
        rs, rc: Those of the rotation of the upper block against the lower one.
        side: -1 where the upper block is the slave, else 1.
        de, dn: Upper centre from the lower one along e and n [m].
        half: Half length of the stretch along the slave's face [m].
        pe, pn: Lever of its middle from the slave's centre along e and n [m].
    """

    ps: real
    pc: real
    rs: real
    rc: real
    side: real
    de: real
    dn: real
    half: real
    pe: real
    pn: real


@wp.struct
class Meeting:
    """How two faces meet in the middle of the stretch, and what its end at +x has beyond that.

    Attributes:
        overlap, tilt: Overlap o [m].
        vn, parting: v_n [m/s].
        vt, sliding: v_t [m/s].
    """

    overlap: real
    tilt: real
    vn: real
    parting: real
    vt: real
    sliding: real


@wp.struct
class Stress:
    """What the springs of a point do.

    Attributes:
        n, t: Stresses N and T [N/m^2].
        e: Twice the energy in them [J/m^2].
        held: 1 if the point is pressed and does not slip, else 0.
    """

    n: real
    t: real
    e: real
    held: int


@wp.struct
class Sums:
    """What the springs of an interface do.

    Attributes:
        n, t: Means of N and T [N/m^2].
        nq, tq: Their first moments over the half length.
        e: Mean of twice the energy [J/m^2].
        held: Points that are pressed and do not slip.
    """

    n: real
    nq: real
    t: real
    tq: real
    e: real
    held: int


@wp.func
def one_minus_cosine(s: real, c: real) -> real:
    """1 - c of an angle with the sine s and the cosine c, without cancellation."""
    one = real(1.0)
    zero = real(0.0)
    return wp.where(c > zero, s * s / (one + larger(c, zero)), one - c)


@wp.func
def lean_of(turn: real, rate: real, dv: real) -> real:
    """Side to which an interface leans, -1 or 1, from how its blocks turn against each other."""
    zero = real(0.0)
    return sign_of(wp.where(turn != zero, turn, wp.where(rate != zero, rate, -dv)))


@wp.func
def shared_stretch(slave: real, plane: real, place: real, cos_turn: real):
    """Ends of the stretch that two faces of the half widths slave and plane [m] share.

    Args:
        slave: Half width of the slave's face [m], plane that of the other one.
        place: Place of the slave's middle along the plane, from the plane's middle [m].
        cos_turn: Cosine of the angle between the two.

    Returns:
        Places along the slave's face [m].
    """
    wide = real(1.0) / larger(cos_turn, STEEPEST)
    return larger(-slave, (-plane - place) * wide), smaller(slave, (plane - place) * wide)


@wp.func
def meeting_of(overlap: real, f: Stretch, wx: real, wz: real, omega: real, below: real) -> Meeting:
    """How the upper face moves against the lower one over the stretch that they share.

    Args:
        overlap: In the middle of the stretch [m].
        f: The stretch.
        wx, wz: Velocity of the upper centre from the lower one's [m/s].
        omega, below: Rates of the rotations of the upper and of the lower block [rad/s].
    """
    rate = omega - below
    turn = wp.where(f.side < real(0.0), below, omega)
    return Meeting(
        overlap, f.half * f.rs,
        fused_less(rate, f.pe, fused(turn, f.de, dot(wx, wz, f.ps, f.pc))),
        -f.half * f.rc * rate,
        fused(rate, f.pn, fused_less(turn, f.dn, fused_less(wz, f.ps, wx * f.pc))),
        f.half * f.side * f.rs * rate,
    )  # fmt: skip


@wp.func
def depth_of(
    dx: real, ez: real, both: real, tilted: real, across: real, tall: real, turn: real,
    cos_turn: real,
) -> real:  # fmt: skip
    """Depth of the middle of the slave's face below the plane [m]; names as in `find_contacts`."""
    sunk = fused_less(
        tall, one_minus_cosine(turn, cos_turn), both * one_minus_cosine(tilted, across)
    )
    return fused_less(ez, across, fused_less(dx, tilted, sunk))


@wp.func
def find_contacts(
    dv: real, box: Box, at: Pose, u: Velocity, low_box: Box, below: Pose, v: Velocity
):  # fmt: skip
    """Finds where the springs of an interface are, and how its faces meet.

    Args:
        dv: Change of the base velocity in the step [m/s].
        box, at, u: The upper block, where it is and how it moves.
        low_box, below, v: The lower one. Heights are those over the stack of rigid blocks.

    Returns:
        The stretch that the faces share, how they meet, and the place of the upper block along the
        lower one [m].
    """
    dx, ez = at.x - below.x, at.z - below.z
    turn = fused_less(at.c, below.s, at.s * below.c)
    cos_turn = dot(at.c, at.s, below.c, below.s)
    both = box.half_height + low_box.half_height
    dz = both + ez
    lean = lean_of(turn, u.omega - v.omega, dv)
    corner = fused_less(box.half_height, turn, fused_less(dz, below.s, dx * below.c))
    corner = fused(lean * box.half_width, cos_turn, corner)
    upper = lean * corner <= low_box.half_width
    side = wp.where(upper, real(-1.0), real(1.0))
    ps = wp.where(upper, below.s, at.s)
    pc = wp.where(upper, below.c, at.c)
    tall = wp.where(upper, box.half_height, low_box.half_height)
    slave = wp.where(upper, box.half_width, low_box.half_width)
    plane = wp.where(upper, low_box.half_width, box.half_width)
    along = fused_less(dz, ps, dx * pc)
    place = fused_less(tall, turn, -side * along)
    low, top = shared_stretch(slave, plane, place, cos_turn)
    middle = HALF * (low + top)
    overlap = fused(middle, turn, depth_of(dx, ez, both, ps, pc, tall, turn, cos_turn))
    slid = -side * (place - lean * slave * one_minus_cosine(turn, cos_turn))
    stretch = Stretch(
        ps, pc, turn, cos_turn, side, along, dot(dx, dz, ps, pc), HALF * (top - low),
        fused_less(tall, turn, middle * cos_turn), side * dot(middle, tall, turn, cos_turn),
    )  # fmt: skip
    meeting = meeting_of(overlap, stretch, u.x - v.x, u.z - v.z, u.omega, v.omega)
    return stretch, meeting, slid


@wp.func
def solve_spring(
    knobs: Knobs, pace: Pace, mu: real, overlap: real, vn: real, vt: real, spring: wp.ref[Spring]
):  # fmt: skip
    """Stresses at one point, see the head of this file; its springs move on.

    Args:
        knobs: The settings.
        pace: The clock of the lane.
        mu: tan(phi).
        overlap: Depth to which the faces overlap [m].
        vn: Velocity at which they part [m/s], vt at which they slide.
        spring: The springs.

    Returns:
        N and T [N/m^2], twice the energy in the springs [J/m^2].
    """
    zero, live = real(0.0), pace.live == 1
    old = real(spring.u)
    slips = real(spring.slip)
    intact = slips == zero
    pull = wp.where(intact, knobs.tensile_strength, zero)
    pressed = fused(knobs.dilatancy, slips, overlap)
    elastic = knobs.normal_stiffness * pressed
    closed = elastic > -pull
    damped = fused_less(knobs.stiffness_damping * knobs.normal_stiffness, vn, elastic)
    normal = wp.where(closed, larger(damped, -pull), zero)
    held = fused(mu, normal, wp.where(intact, knobs.cohesion, zero))
    bound = wp.where(closed, larger(held, zero), zero)
    stretch = fused(pace.dt, vt, old)
    wanted = -knobs.shear_stiffness * fused(knobs.stiffness_damping, vt, stretch)
    shear = larger(smaller(wanted, bound), -bound)
    kept = wp.where(shear == wanted, stretch, -knobs.shear_flexibility * shear)
    energy = fused(knobs.shear_stiffness * kept, kept, wp.where(closed, elastic * pressed, zero))
    spring.u = wp.where(live, kept, old)
    moved = wp.where(closed, slips + larger(stretch - kept, kept - stretch), larger(slips, FAILED))
    spring.slip = wp.where(live, moved, slips)
    return normal, shear, energy


@wp.func
def press(
    knobs: Knobs, pace: Pace, mu: real, away: real, m: Meeting, spring: wp.ref[Spring]
) -> Stress:
    """What the springs of a point do that is `away` half lengths from the middle, to +x.

    Args:
        knobs: See `solve_spring`, as pace and mu.
        away: Place of the point.
        m: How the faces meet.
        spring: Its springs; they move on.
    """
    before = real(spring.slip)
    n, t, stored = solve_spring(
        knobs, pace, mu, fused(away, m.tilt, m.overlap), fused(away, m.parting, m.vn),
        fused(away, m.sliding, m.vt), spring,
    )  # fmt: skip
    return Stress(n, t, stored, wp.where(n > real(0.0) and spring.slip == before, 1, 0))


@wp.func
def add_pair(share: real, away: real, one: Stress, two: Stress, sums: Sums) -> Sums:
    """Adds two points at the same distance from the middle, -x first, to an interface.

    Args:
        share: Share of the interface that each of them stands for.
        away: Their distance from the middle, in half lengths.
        one, two: What their springs do.
        sums: What the springs of the interface do so far.
    """
    return Sums(
        fused(share, one.n + two.n, sums.n), fused(share * away, two.n - one.n, sums.nq),
        fused(share, one.t + two.t, sums.t), fused(share * away, two.t - one.t, sums.tq),
        fused(share, one.e + two.e, sums.e), sums.held + one.held + two.held,
    )  # fmt: skip


@wp.func
def load_blocks(
    depth: real, f: Stretch, sums: Sums, up: wp.ref[Load], low: wp.ref[Load]
) -> real:  # fmt: skip
    """Adds the forces of the springs of an interface to those on its two blocks.

    Args:
        depth: Depth of the interface [m].
        f: The stretch that its faces share.
        sums: What its springs do.
        up, low: Loads of the upper and of the lower block.

    Returns:
        Energy in the springs [J].
    """
    zero = real(0.0)
    area = real(2.0) * larger(f.half, zero) * depth
    normal = area * sums.n
    shear = area * sums.t
    spread = fused_less(f.rc, sums.nq, f.side * f.rs * sums.tq)
    about = fused(area * f.half, spread, fused_less(f.pe, normal, f.pn * shear))
    across = fused_less(f.de, normal, f.dn * shear)
    px = dot(normal, shear, f.ps, f.pc)
    pz = fused_less(shear, f.ps, normal * f.pc)
    up.x = up.x + px
    up.z = up.z + pz
    up.moment = up.moment + about - wp.where(f.side < zero, zero, across)
    low.x = low.x - px
    low.z = low.z - pz
    low.moment = low.moment - about - wp.where(f.side < zero, across, zero)
    return HALF * area * sums.e


@wp.func
def integrate(
    knobs: Knobs, pace: Pace, base: Base, mass: Mass, load: Load, at: wp.ref[Pose],
    u: wp.ref[Velocity], loss: wp.ref[real],
) -> real:  # fmt: skip
    """Moves a block by a step.

    Args:
        knobs: The settings.
        pace: The clock of its lane.
        base: How the base moves.
        mass: Of the block.
        load: The forces on it.
        at, u: Where the block is and how it moves.
        loss: Work of the springs and of mass damping against the blocks so far [J].

    Returns:
        Work of the block on the base in the step [J].
    """
    live = pace.live == 1
    drag = knobs.mass_damping
    px = fused_less(drag, u.x, mass.m * load.x)
    pz = fused_less(drag, u.z, mass.m * load.z)
    po = fused_less(drag, u.omega, mass.j * load.moment)
    new_x = fused(pace.span, px, u.x) - base.dx
    new_z = fused(pace.span, pz - knobs.gravity, u.z)
    if VERTICAL:
        new_z = new_z - base.dz
    new_o = fused(pace.span, po, u.omega)
    sum_x, sum_z, sum_o = u.x + new_x, u.z + new_z, u.omega + new_o
    own = real(1.0) / mass.m
    work = fused(own, dot(px, pz, sum_x, sum_z), po * sum_o / mass.j)
    loss = loss - wp.where(live, HALF * pace.span * work, real(0.0))
    u.x = wp.where(live, new_x, u.x)
    u.z = wp.where(live, new_z, u.z)
    u.omega = wp.where(live, new_o, u.omega)
    at.x = wp.where(live, fused(pace.dt, new_x, at.x), at.x)
    at.z = wp.where(live, fused(pace.dt, new_z, at.z), at.z)
    angle = wp.where(live, fused(pace.dt, new_o, at.theta), at.theta)
    at.theta = angle
    turned = in_range(angle)
    at.s = sine(turned)
    at.c = cosine(turned)
    return wp.where(live, own * base_work(base.dx, base.dz, sum_x, sum_z), real(0.0))
