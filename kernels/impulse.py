"""Velocity-level contact step of a rocking block, for one precision and motion kind.

The block lives in the frame of the base: mass 1, centre of mass (x, z), clockwise rotation
theta, inertia I. Corner i sits at (X_i, Z_i) from the centre of mass, its gap is z + Z_i, its
velocity (vx + omega Z_i, vz - omega X_i). One step of length dt, semi-implicit Euler:

    1. v* = v + dt (0, -g) - (dv_base, 0): the base velocity at both ends of the step, so that a
       velocity step of the base is carried exactly;
    2. corners nearer than the collision margin are contacts. Each asks for a normal velocity of
       at least -gap / dt (it may close the gap) or -erp gap / dt (it gives back a part of a
       penetration), and for no tangential velocity within Coulomb's bound |f| <= mu n;
    3. projected Gauss-Seidel on the four impulses l = (n1, f1, n2, f2), started from those of
       the last step: l_i = clamp(-(u_i + sum over j != i of K_ij l_j) / K_ii), where
       K = J M^-1 J^T and u is what v* misses of the wish of each row;
    4. v = v* + M^-1 J^T l, q = q + dt v.

Jean and Moreau (1992) for the scheme, Catto (2005) for the solver. A block rocks while one of
its corners carries no impulse; that needs no tolerance.
"""

from typing import Any

import warp as wp

from warprock.kernels.instance import LANE_WIDTH, kernel_module, module_options

real: Any
PRECISION: str
MOTION: str
ITERATIONS: int

wp.set_module_options(module_options())
scalar = kernel_module("scalar", precision=PRECISION)
motion = kernel_module("motion", precision=PRECISION, motion=MOTION)
larger, smaller, size = scalar.larger, scalar.smaller, scalar.size
sine, cosine = scalar.sine, scalar.cosine
Motion, base_velocity = motion.Motion, motion.velocity
sample_index, sample_segment = motion.sample_index, motion.sample_segment

HALF_PI = real(1.5707963267948966)
NEVER = real(1.0e30)
ROCKING = 1
OVERTURNED = 2
BROKEN = 3


@wp.struct
class Block:
    """What a step needs to know of one lane's block."""

    half_width: real
    half_height: real
    inverse_inertia: real
    friction: real


@wp.struct
class Knobs:
    """What a step needs to know of the settings."""

    time_step: real
    gravity: real
    collision_margin: real
    erp: real


@wp.func
def wish(gap: real, knobs: Knobs) -> real:
    """Least normal velocity of a corner after the step."""
    return -gap / knobs.time_step * wp.where(gap > real(0.0), real(1.0), knobs.erp)


@wp.func
def solve(
    mu: real, w: real, x1: real, z1: real, x2: real, z2: real, on1: real, on2: real,
    u1: real, s1: real, u2: real, s2: real, n1: real, f1: real, n2: real, f2: real,
):  # fmt: skip
    """Impulses of the two corners by projected Gauss-Seidel.

    Args:
        mu: Friction coefficient.
        w: Inverse inertia for unit mass [1/m^2].
        x1: Corner 1 from the centre of mass [m]; z1, x2, z2 likewise.
        on1: One where corner 1 is a contact, else zero; on2 likewise.
        u1: Normal velocity of corner 1 above its wish [m/s], without contact; u2 likewise.
        s1: Tangential velocity of corner 1 [m/s], without contact; s2 likewise.
        n1: First guess of the normal impulse of corner 1 [m/s]; f1, n2, f2 likewise.
    """
    one = real(1.0)
    zero = real(0.0)
    # Rows of K over their diagonal; rows of an inactive corner vanish.
    d1 = on1 / (one + w * x1 * x1)
    e1 = on1 / (one + w * z1 * z1)
    d2 = on2 / (one + w * x2 * x2)
    e2 = on2 / (one + w * z2 * z2)
    n1n2 = one + w * x1 * x2
    f1f2 = one + w * z1 * z2
    n1f1 = -w * x1 * z1
    n1f2 = -w * x1 * z2
    n2f1 = -w * x2 * z1
    n2f2 = -w * x2 * z2
    a1 = d1 * n1f1
    a2 = d1 * n1n2
    a3 = d1 * n1f2
    b1 = e1 * n1f1
    b2 = e1 * n2f1
    b3 = e1 * f1f2
    c1 = d2 * n1n2
    c2 = d2 * n2f1
    c3 = d2 * n2f2
    g1 = e2 * n1f2
    g2 = e2 * f1f2
    g3 = e2 * n2f2
    u1 = -d1 * u1
    s1 = -e1 * s1
    u2 = -d2 * u2
    s2 = -e2 * s2
    n1 = n1 * on1
    f1 = f1 * on1
    n2 = n2 * on2
    f2 = f2 * on2
    for _ in range(ITERATIONS):
        n1 = larger(u1 - a1 * f1 - a2 * n2 - a3 * f2, zero)
        bound = mu * n1
        f1 = larger(smaller(s1 - b1 * n1 - b2 * n2 - b3 * f2, bound), -bound)
        n2 = larger(u2 - c1 * n1 - c2 * f1 - c3 * f2, zero)
        bound = mu * n2
        f2 = larger(smaller(s2 - g1 * n1 - g2 * f1 - g3 * n2, bound), -bound)
    return n1, f1, n2, f2


@wp.func
def step(
    block: Block, knobs: Knobs, dv: real,
    x: real, z: real, theta: real, vx: real, vz: real, omega: real,
    n1: real, f1: real, n2: real, f2: real, loss: real,
):  # fmt: skip
    """One step of one lane.

    Args:
        block: The lane's block.
        knobs: The settings.
        dv: Change of the base velocity in the step [m/s].
        x: Centre of mass along the base, from where it would rest [m].
        z: Centre of mass above the base [m].
        theta: Rotation [rad], clockwise, so towards +x.
        vx: Velocity along the base, relative to it [m/s]; vz, omega [rad/s] likewise.
        n1: Normal impulse of the -x corner in the last step, per unit mass [m/s].
        f1: Tangential impulse likewise; n2, f2 those of the +x corner.
        loss: Energy lost so far per unit mass [J/kg].

    Returns:
        The state after the step, in the order of the arguments from `x` on.
    """
    half = real(0.5)
    w = block.inverse_inertia
    dt = knobs.time_step
    s = sine(theta)
    c = cosine(theta)
    x1 = -block.half_width * c - block.half_height * s
    z1 = block.half_width * s - block.half_height * c
    x2 = block.half_width * c - block.half_height * s
    z2 = -block.half_width * s - block.half_height * c
    gap1 = z + z1
    gap2 = z + z2
    on1 = wp.where(gap1 <= knobs.collision_margin, real(1.0), real(0.0))
    on2 = wp.where(gap2 <= knobs.collision_margin, real(1.0), real(0.0))
    ux = vx - dv
    uz = vz - dt * knobs.gravity
    n1, f1, n2, f2 = solve(
        block.friction, w, x1, z1, x2, z2, on1, on2,
        uz - omega * x1 - wish(gap1, knobs), ux + omega * z1,
        uz - omega * x2 - wish(gap2, knobs), ux + omega * z2,
        n1, f1, n2, f2,
    )  # fmt: skip
    vx1 = ux + f1 + f2
    vz1 = uz + n1 + n2
    omega1 = omega + w * (f1 * z1 + f2 * z2 - n1 * x1 - n2 * x2)
    # Work of the contact impulses on the mean velocity of their corners, a loss.
    mx = half * (vx + vx1)
    mz = half * (vz + vz1)
    mo = half * (omega + omega1)
    work = n1 * (mz - mo * x1) + f1 * (mx + mo * z1) + n2 * (mz - mo * x2) + f2 * (mx + mo * z2)
    return (
        x + dt * vx1, z + dt * vz1, theta + dt * omega1, vx1, vz1, omega1,
        n1, f1, n2, f2, loss - work,
    )  # fmt: skip


@wp.func
def slide_of(block: Block, x: real, theta: real) -> real:
    """Slide along the base of the corner that the block stands on [m]."""
    side = wp.where(theta < real(0.0), real(-1.0), real(1.0))
    lean = side * block.half_width * (cosine(theta) - real(1.0))
    return x + lean - block.half_height * sine(theta)


@wp.func
def observe(
    half_pi: real, mode: int, time: real, theta: real, omega: real, slide: real,
    n1: real, n2: real, old1: real, old2: real,
    peak: real, peak_time: real, peak_slide: real, uplift_time: real, moved: real, impacts: int,
):  # fmt: skip
    """What a step adds to the response of one lane.

    Args:
        half_pi: Rotation at which the block has overturned.
        mode: ROCKING (not at its end), OVERTURNED or BROKEN.
        time: End of the step [s].
        theta: Rotation [rad], omega its rate [rad/s].
        omega: Angular velocity [rad/s].
        slide: Slide along the base [m].
        n1: Normal impulse of the -x corner in this step; old1 in the step before.
        n2: Normal impulse of the +x corner in this step; old2 in the step before.
        old1: See n1.
        old2: See n2.
        peak: Largest |theta| so far [rad], peak_time its time [s].
        peak_time: See peak.
        peak_slide: Largest |slide| so far [m].
        uplift_time: First time at which a corner carries nothing [s].
        moved: Last time at which a corner carries nothing [s].
        impacts: Times at which a corner that carried nothing is loaded again.

    Returns:
        mode, peak, peak_time, peak_slide, uplift_time, moved, impacts.
    """
    zero = real(0.0)
    higher = size(theta) > peak
    lifted = n1 <= zero or n2 <= zero
    landed1 = wp.where(old1 <= zero and n1 > zero, 1, 0)
    landed2 = wp.where(old2 <= zero and n2 > zero, 1, 0)
    over = size(theta) >= half_pi
    sound = theta - theta == zero and omega - omega == zero and slide - slide == zero
    return (
        wp.where(sound, wp.where(over, OVERTURNED, mode), BROKEN),
        wp.where(higher, smaller(size(theta), half_pi), peak),
        wp.where(higher, time, peak_time),
        larger(size(slide), peak_slide),
        wp.where(lifted and uplift_time >= NEVER, time, uplift_time),
        wp.where(lifted, time, moved),
        impacts + landed1 + landed2,
    )


@wp.struct
class Result:
    """What one lane's run leaves behind."""

    theta: real
    slide: real
    peak: real
    peak_time: real
    peak_slide: real
    uplift_time: real
    moved: real
    loss: real
    impacts: int
    mode: int
    steps: int


Lane = wp.types.vector(length=LANE_WIDTH, dtype=real)
LaneInt = wp.types.vector(length=LANE_WIDTH, dtype=int)


@wp.kernel
def packed(
    blocks: wp.array(dtype=Block),
    motions: wp.array(dtype=Motion),
    pool: wp.array2d(dtype=real),
    starts: wp.array(dtype=real),
    sample_times: wp.array(dtype=real),
    knobs: Knobs,
    results: wp.array(dtype=Result),
    rotations: wp.array2d(dtype=real),
):
    """Runs packs of LANE_WIDTH lanes, all at the same time."""
    first = wp.tid() * LANE_WIDTH
    x = Lane()
    z = Lane()
    theta = Lane()
    vx = Lane()
    vz = Lane()
    omega = Lane()
    n1 = Lane()
    f1 = Lane()
    n2 = Lane()
    f2 = Lane()
    loss = Lane()
    base = Lane()
    peak = Lane()
    peak_time = Lane()
    peak_slide = Lane()
    uplift_time = Lane()
    moved = Lane()
    impacts = LaneInt()
    mode = LaneInt()
    steps = LaneInt()
    for l in range(LANE_WIDTH):
        block = blocks[first + l]
        th = starts[first + l]
        theta[l] = th
        x[l] = -slide_of(block, real(0.0), th)
        z[l] = block.half_width * size(sine(th)) + block.half_height * cosine(th)
        n1[l] = wp.where(th > real(0.0), real(0.0), knobs.time_step * knobs.gravity)
        n2[l] = wp.where(th < real(0.0), real(0.0), knobs.time_step * knobs.gravity)
        peak[l] = size(th)
        uplift_time[l] = wp.where(th == real(0.0), NEVER, real(0.0))
        mode[l] = ROCKING
    k = int(0)
    time = real(0.0)
    for sample in range(sample_times.shape[0]):
        until = sample_times[sample]
        while time < until:
            k += 1
            time = real(k) * knobs.time_step
            for l in range(LANE_WIDTH):
                m = motions[first + l]
                block = blocks[first + l]
                place = sample_index(m, sample_segment(m, time))
                moving = base_velocity(m, time, pool[2, place], pool[0, place], pool[1, place])
                qx, qz, qt, ux, uz, uo, p1, t1, p2, t2, lo = step(
                    block, knobs, moving - base[l], x[l], z[l], theta[l], vx[l], vz[l], omega[l],
                    n1[l], f1[l], n2[l], f2[l], loss[l],
                )  # fmt: skip
                mo, pk, pt, ps, ut, mv, im = observe(
                    HALF_PI, mode[l], time, qt, uo, slide_of(block, qx, qt), p1, p2, n1[l], n2[l],
                    peak[l], peak_time[l], peak_slide[l], uplift_time[l], moved[l], impacts[l],
                )  # fmt: skip
                live = mode[l] == ROCKING
                x[l] = wp.where(live, qx, x[l])
                z[l] = wp.where(live, qz, z[l])
                theta[l] = wp.where(live, qt, theta[l])
                vx[l] = wp.where(live, ux, vx[l])
                vz[l] = wp.where(live, uz, vz[l])
                omega[l] = wp.where(live, uo, omega[l])
                n1[l] = wp.where(live, p1, n1[l])
                f1[l] = wp.where(live, t1, f1[l])
                n2[l] = wp.where(live, p2, n2[l])
                f2[l] = wp.where(live, t2, f2[l])
                loss[l] = wp.where(live, lo, loss[l])
                base[l] = moving
                peak[l] = wp.where(live, pk, peak[l])
                peak_time[l] = wp.where(live, pt, peak_time[l])
                peak_slide[l] = wp.where(live, ps, peak_slide[l])
                uplift_time[l] = wp.where(live, ut, uplift_time[l])
                moved[l] = wp.where(live, mv, moved[l])
                impacts[l] = wp.where(live, im, impacts[l])
                steps[l] = steps[l] + wp.where(live, 1, 0)
                mode[l] = wp.where(live, mo, mode[l])
        if rotations.shape[0] > 0:
            back = time - until
            for l in range(LANE_WIDTH):
                at = theta[l] - wp.where(mode[l] == ROCKING, back * omega[l], real(0.0))
                rotations[sample, first + l] = at
    for l in range(LANE_WIDTH):
        result = Result()
        result.theta = theta[l]
        result.slide = slide_of(blocks[first + l], x[l], theta[l])
        result.peak = peak[l]
        result.peak_time = peak_time[l]
        result.peak_slide = peak_slide[l]
        result.uplift_time = uplift_time[l]
        result.moved = moved[l]
        result.loss = loss[l]
        result.impacts = impacts[l]
        result.mode = mode[l]
        result.steps = steps[l]
        results[first + l] = result
