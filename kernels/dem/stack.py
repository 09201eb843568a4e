"""Soft-spring (distinct element) step of a stack of rocking blocks.

Bodies are numbered from the ground: body 0 is the ground, an infinite flat face that nothing
moves, body k the k-th block. Body k has the centre of mass (x, z), half height h, half width of
its faces f, clockwise rotation theta, in the frame of the base; e = (c, -s) is the direction of
its faces, n = (s, c) their normal, s and c the sine and cosine of theta. Heights are kept as what
they differ from those of the stack built with rigid blocks, which keeps overlaps exact.

Interface k, between body k (upper) and body k - 1 (lower), is the overlap of the upper block's
bottom face and the lower one's top face. Springs spread over it belong to the face whose corner
closes when the interface rocks on (the *slave*) and press on the plane of the other one, with its
n and e. A point at a along the slave's face has, with D = theta_upper - theta_lower, g the gap at
a = 0 and (P, Q) its lever from the slave's centre along e and n,

    gap      g - a sin D
    parting  v_n = w_n - D' P
    sliding  v_t = w_t + D' Q

all linear in a, so that they are found once an interface and not once a spring. Stresses at a
point, per unit of area (Eq. 3 and 4 of the paper, with a dashpot beta k in parallel):

    normal   N = k_n (o + slip tan(psi)) - beta k_n v_n,    o = -gap, N >= -f_t while intact
    shear    T = -k_s (u + beta v_t),  u' = v_t,            |T| <= c + N tan(phi)

A point whose spring is in tension beyond f_t is open and carries nothing; a dashpot never pulls
beyond that either. Where T reaches its bound the point slips and u keeps what the spring carries.
The first slip or opening takes f_t and c away for good; opening forgets u, but no dilation.

One step of central differences, the velocities at half steps: stresses from the places at n and
the velocities at n - 1/2, which the dashpots see one half step late; then
v(n + 1/2) = v(n - 1/2) + dt F / m - dv_base, q(n + 1) = q(n) + dt v(n + 1/2).

Points are visited in pairs at the same distance from the middle of the overlap, whose sums and
differences are exact mirror images in a mirrored scene.

Cundall and Strack (1979) for the scheme, Cundall (1988) for blocks.
"""

import warp as wp

from warprock.kernels.shape.rising import worked

STEEPEST = real(0.1)
"""Smallest cosine of the angle between two faces for which their overlap still grows."""
FAILED = real(1.0e-30)
"""Slip of a point that has opened [m]: tiny, but not the exact zero of an intact one."""


@wp.struct
class Knobs:
    """What a step needs to know of the settings."""

    gravity: real
    normal_stiffness: real
    shear_stiffness: real
    shear_flexibility: real
    stiffness_damping: real
    mass_damping: real
    cohesion: real
    tensile_strength: real
    dilatancy: real


@wp.func
def rise(s: real, c: real) -> real:
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
def relative_motion(
    ps: real, pc: real, rs: real, rc: real, side: real, de: real, dn: real, hs: real, middle: real,
    half: real, wx: real, wz: real, omega: real, lomega: real,
    pe: wp.ref[real], pn: wp.ref[real], vn: wp.ref[real], vt: wp.ref[real],
    tilt: wp.ref[real], parting: wp.ref[real], sliding: wp.ref[real],
):  # fmt: skip
    """Finds how the upper face moves against the lower one over the stretch that they share.

    Args:
        ps: See `find_contacts`, as all that is not told here.
        hs: Half height of the slave [m].
        middle: Place of the middle of the stretch along the slave's face [m].
        pe: Lever of that middle from the slave's centre along e [m], pn along n; found.
        vn: v_n there [m/s], vt likewise; found.
        tilt: What is to be added to the overlap at the end at +x [m], parting to v_n and sliding
            to v_t [m/s]; found.
    """
    rate = omega - lomega
    turn = wp.where(side < real(0.0), lomega, omega)
    a = fused_less(hs, rs, middle * rc)
    b = side * dot(middle, hs, rs, rc)
    pe = a
    pn = b
    vn = fused_less(rate, a, fused(turn, de, dot(wx, wz, ps, pc)))
    vt = fused(rate, b, fused_less(turn, dn, fused_less(wz, ps, wx * pc)))
    tilt = half * rs
    parting = -half * rc * rate
    sliding = half * side * rs * rate


@wp.func
def depth_of(
    dx: real, ez: real, both: real, tilted: real, across: real, tall: real, turn: real,
    cos_turn: real,
) -> real:  # fmt: skip
    """Depth of the middle of the slave's face below the plane [m]; names as in `find_contacts`."""
    sunk = fused_less(tall, rise(turn, cos_turn), both * rise(tilted, across))
    return fused_less(ez, across, fused_less(dx, tilted, sunk))


@wp.func
def find_contacts(
    dv: real, half_width: real, half_height: real, s: real, c: real, omega: real,
    lhalf_width: real, lhalf_height: real, ls: real, lc: real, lomega: real,
    dx: real, ez: real, wx: real, wz: real,
    ps: wp.ref[real], pc: wp.ref[real], rs: wp.ref[real], rc: wp.ref[real],
    side: wp.ref[real], de: wp.ref[real], dn: wp.ref[real], half: wp.ref[real],
    slid: wp.ref[real], pe: wp.ref[real], pn: wp.ref[real], overlap: wp.ref[real], vn: wp.ref[real],
    vt: wp.ref[real], tilt: wp.ref[real], parting: wp.ref[real], sliding: wp.ref[real],
):  # fmt: skip
    """Finds where the springs of an interface are, and how the faces move: ps and all after it.

    Args:
        dv: Change of the base velocity in the step [m/s].
        half_width, half_height: Half sizes of the upper block [m].
        s, c, omega: Sine, cosine and rate of its rotation; of the lower one lhalf_width and so on.
        dx, ez: Upper centre to +x of the lower one, and above it less both half heights [m].
        wx: Velocity of the upper centre from the lower one's [m/s], wz likewise.
        ps, pc, rs, rc: Sine and cosine of the rotation of the plane, and of the upper block against
            the lower one.
        side: -1 where the upper block is the slave, else 1.
        de: Upper centre from the lower one along e [m], dn along n.
        half: Half length of the stretch that the faces share, along the slave's face [m].
        slid: Place of the upper block along the lower one [m].
        pe: See `relative_motion`, as all that is not told here.
        overlap: Overlap o in the middle of that stretch [m].
    """
    turn = fused_less(c, ls, s * lc)
    cos_turn = dot(c, s, lc, ls)
    both = half_height + lhalf_height
    dz = both + ez
    lean = lean_of(turn, omega - lomega, dv)
    corner = fused_less(half_height, turn, fused_less(dz, ls, dx * lc))
    corner = fused(lean * half_width, cos_turn, corner)
    upper = lean * corner <= lhalf_width
    sign = wp.where(upper, real(-1.0), real(1.0))
    tilted = wp.where(upper, ls, s)
    across = wp.where(upper, lc, c)
    tall = wp.where(upper, half_height, lhalf_height)
    slave = wp.where(upper, half_width, lhalf_width)
    plane = wp.where(upper, lhalf_width, half_width)
    along = fused_less(dz, tilted, dx * across)
    place = fused_less(tall, turn, -sign * along)
    low, top = shared_stretch(slave, plane, place, cos_turn)
    middle = real(0.5) * (low + top)
    length = real(0.5) * (top - low)
    normal = dot(dx, dz, tilted, across)
    ps = tilted
    pc = across
    rs = turn
    rc = cos_turn
    side = sign
    de = along
    dn = normal
    half = length
    overlap = fused(middle, turn, depth_of(dx, ez, both, tilted, across, tall, turn, cos_turn))
    slid = -sign * (place - lean * slave * rise(turn, cos_turn))
    relative_motion(
        tilted, across, turn, cos_turn, sign, along, normal, tall, middle, length,
        wx, wz, omega, lomega, pe, pn, vn, vt, tilt, parting, sliding,
    )  # fmt: skip


@wp.func
def spring(
    knobs: Knobs, live: bool, mu: real, dt: real, overlap: real, vn: real, vt: real,
    u: wp.ref[real], slip: wp.ref[real],
):  # fmt: skip
    """Stresses at one point, see the head of this file; updates u and slip.

    Args:
        knobs: The settings.
        live: Whether the lane still runs.
        mu: tan(phi).
        dt: Time step [s].
        overlap: Depth to which the faces overlap [m].
        vn: Velocity at which they part [m/s], vt at which they slide.
        u: Stretch of the shear spring [m].
        slip: Slip so far [m], zero only of a point that never slipped or opened.

    Returns:
        N and T [N/m^2], twice the energy in the springs [J/m^2].
    """
    zero = real(0.0)
    old = real(u)
    slips = real(slip)
    intact = slips == zero
    pull = wp.where(intact, knobs.tensile_strength, zero)
    pressed = fused(knobs.dilatancy, slips, overlap)
    elastic = knobs.normal_stiffness * pressed
    closed = elastic > -pull
    damped = fused_less(knobs.stiffness_damping * knobs.normal_stiffness, vn, elastic)
    normal = wp.where(closed, larger(damped, -pull), zero)
    held = fused(mu, normal, wp.where(intact, knobs.cohesion, zero))
    bound = wp.where(closed, larger(held, zero), zero)
    stretch = fused(dt, vt, old)
    wanted = -knobs.shear_stiffness * fused(knobs.stiffness_damping, vt, stretch)
    shear = larger(smaller(wanted, bound), -bound)
    kept = wp.where(size(wanted) <= bound, stretch, -knobs.shear_flexibility * shear)
    energy = fused(knobs.shear_stiffness * kept, kept, wp.where(closed, elastic * pressed, zero))
    u = wp.where(live, kept, old)
    moved = wp.where(closed, slips + size(stretch - kept), larger(slips, FAILED))
    slip = wp.where(live, moved, slips)
    return normal, shear, energy


@wp.func
def solve_pair(
    knobs: Knobs, live: bool, mu: real, dt: real, share: real, away: real,
    overlap: real, tilt: real, vn: real, parting: real, vt: real, sliding: real,
    u1: wp.ref[real], slip1: wp.ref[real], u2: wp.ref[real], slip2: wp.ref[real],
    n: wp.ref[real], nq: wp.ref[real], t: wp.ref[real], tq: wp.ref[real], e: wp.ref[real],
    held: wp.ref[int],
):  # fmt: skip
    """Adds a pair of points, -away and +away half lengths from the middle, to an interface.

    Args:
        knobs: See `spring`, as all up to dt.
        share: Part of the area that each of the two stands for.
        away: Their distance from the middle over the half length.
        overlap: At the middle [m]; tilt what is to be added at the end, see `find_contacts`; vn and
            parting, vt and sliding likewise.
        u1: State of the first point, see `spring`, slip1 likewise; u2, slip2 of the second.
        n: Mean of N so far [N/m^2], nq its first moment over the half length, t and tq of T,
            e the mean of twice the energy [J/m^2], held the points that are pressed and do not
            slip; all are added to.
    """
    before1 = real(slip1)
    before2 = real(slip2)
    n1, t1, e1 = spring(
        knobs, live, mu, dt, fused_less(away, tilt, overlap), fused_less(away, parting, vn),
        fused_less(away, sliding, vt), u1, slip1,
    )  # fmt: skip
    n2, t2, e2 = spring(
        knobs, live, mu, dt, fused(away, tilt, overlap), fused(away, parting, vn),
        fused(away, sliding, vt), u2, slip2,
    )  # fmt: skip
    n = fused(share, n1 + n2, n)
    t = fused(share, t1 + t2, t)
    nq = fused(share * away, n2 - n1, nq)
    tq = fused(share * away, t2 - t1, tq)
    e = fused(share, e1 + e2, e)
    held = held + wp.where(n1 > real(0.0) and slip1 == before1, 1, 0)
    held = held + wp.where(n2 > real(0.0) and slip2 == before2, 1, 0)


@wp.func
def load_blocks(
    depth: real, ps: real, pc: real, rs: real, rc: real, side: real, de: real, dn: real,
    half: real, pe: real, pn: real, n: wp.ref[real], nq: wp.ref[real], t: wp.ref[real],
    tq: wp.ref[real], e: wp.ref[real],
    fx: wp.ref[real], fz: wp.ref[real], moment: wp.ref[real],
    lfx: wp.ref[real], lfz: wp.ref[real], lmoment: wp.ref[real],
    live: bool, stored: wp.ref[real],
):  # fmt: skip
    """Adds the forces of the springs of an interface to those on its two blocks: fx and after.

    Args:
        depth: Depth of the interface [m].
        ps: See `find_contacts`, as all up to half.
        pe: See `find_contacts`, pn likewise.
        n: See `solve_pair`, as all up to e; set to zero for the next interface.
        fx: Force on the upper block [N], fz and its clockwise moment [N m]; lfx and so on, of the
            lower one.
        live: Whether the lane still runs.
        stored: Energy in the springs [J].
    """
    zero = real(0.0)
    area = real(2.0) * larger(half, zero) * depth
    normal = area * n
    shear = area * t
    spread = fused_less(rc, nq, side * rs * tq)
    about = fused(area * half, spread, fused_less(pe, normal, pn * shear))
    across = fused_less(de, normal, dn * shear)
    px = dot(normal, shear, ps, pc)
    pz = fused_less(shear, ps, normal * pc)
    fx = fx + px
    fz = fz + pz
    moment = moment + about - wp.where(side < zero, zero, across)
    lfx = lfx - px
    lfz = lfz - pz
    lmoment = lmoment - about - wp.where(side < zero, across, zero)
    stored = stored + wp.where(live, real(0.5) * area * e, zero)
    n = zero
    nq = zero
    t = zero
    tq = zero
    e = zero


@wp.func
def integrate(
    live: bool, dv: real, dz: real, dt: real, span: real, knobs: Knobs, m: real, j: real,
    fx: wp.ref[real], fz: wp.ref[real], moment: wp.ref[real],
    x: wp.ref[real], z: wp.ref[real], theta: wp.ref[real], s: wp.ref[real], c: wp.ref[real],
    vx: wp.ref[real], vz: wp.ref[real], omega: wp.ref[real], loss: wp.ref[real],
    given: wp.ref[real],
):  # fmt: skip
    """Moves a block by a step.

    Args:
        live: Whether the lane still runs.
        dv: Change of the base velocity in the step [m/s]; dz that upwards.
        dt: Time step [s].
        span: Time over which the forces act: half of it in the first step, from rest [s].
        knobs: The settings.
        m: Inverse mass [1/kg], j inverse moment of inertia [1/(kg m^2)].
        fx: Force [N], fz likewise, moment clockwise [N m]; set to zero for the next step.
        x: Centre of the block, z likewise; theta its rotation, s and c sine and cosine of it, vx,
            vz and omega its velocities. All move on.
        loss: Work of the springs and of mass damping against the blocks so far [J], given that of
            the base on them.
    """
    half = real(0.5)
    old_x = real(vx)
    old_z = real(vz)
    old_o = real(omega)
    drag = knobs.mass_damping
    px = fused_less(drag, old_x, m * fx)
    pz = fused_less(drag, old_z, m * fz)
    po = fused_less(drag, old_o, j * moment)
    new_x = fused(span, px, old_x) - dv
    new_z = fused(span, pz - knobs.gravity, old_z)
    if VERTICAL:
        new_z = new_z - dz
    new_o = fused(span, po, old_o)
    mass = real(1.0) / m
    work = fused(mass, dot(px, pz, old_x + new_x, old_z + new_z), po * (old_o + new_o) / j)
    loss = loss - wp.where(live, half * span * work, real(0.0))
    given = given - wp.where(live, mass * worked(dv, dz, old_x + new_x, old_z + new_z), real(0.0))
    vx = wp.where(live, new_x, old_x)
    vz = wp.where(live, new_z, old_z)
    omega = wp.where(live, new_o, old_o)
    x = wp.where(live, fused(dt, new_x, x), x)
    z = wp.where(live, fused(dt, new_z, z), z)
    angle = wp.where(live, fused(dt, new_o, theta), theta)
    theta = angle
    turned = in_range(angle)
    s = sine(turned)
    c = cosine(turned)
    fx = real(0.0)
    fz = real(0.0)
    moment = real(0.0)
