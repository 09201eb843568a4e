"""Runs of the direct step over lanes, LANES lanes a thread: a pack on the CPU, one on any device.

A block rocks while one of its corners has parted from the base, see parting.py. A flat one
starts at rest on its springs, a leaning one with its corner at the base.

With one lane a thread the same text is the plain form.
"""

import warp as wp

from warprock.kernels.account import book
from warprock.kernels.direct.block import Block, Knobs, step
from warprock.kernels.modes import BROKEN, RUNNING, UNSOLVED
from warprock.kernels.motion import Motion, base_velocity, sample_index, sample_segment
from warprock.kernels.parting import watch
from warprock.kernels.shape.block import glides, height_of, limit_of, observe, slide_of
from warprock.kernels.shape.stack_found import BlockResult, Found, Result, at_sample


@wp.func
def start(block: Block, knobs: Knobs, theta: real):
    """Where and how fast a block starts: x, z, vz, and the impulses of the step before.

    Velocities are those of half a step before the start: at rest, or about to begin to fall.
    """
    zero = real(0.0)
    flat = theta == zero
    fall = knobs.time_step * knobs.gravity
    sunk = wp.where(flat, HALF * knobs.gravity / block.stiffness, zero)
    return (
        -slide_of(block, zero, theta),
        height_of(block, theta) - sunk,
        wp.where(flat, zero, HALF * fall),
        wp.where(flat, HALF * fall, wp.where(theta < zero, fall, zero)),
        wp.where(flat, HALF * fall, wp.where(theta > zero, fall, zero)),
    )


@wp.func
def before_start(k: int) -> real:
    """Weight of the starting velocity in the contact work: 1/2 in step 1, then 0.

    The work of a step's contacts takes the mean of the velocities before and after. Before step 1
    there is only the fall that it starts from, see `start`.
    """
    return wp.where(k == 1, HALF, real(0.0))


Lane = wp.types.vector(length=LANES, dtype=real)
LaneInt = wp.types.vector(length=LANES, dtype=int)


@wp.kernel
def run_lanes(
    blocks: wp.array(dtype=Block),
    motions: wp.array(dtype=Motion),
    pool: wp.array2d(dtype=real),
    starts: wp.array(dtype=real),
    sample_times: wp.array(dtype=real),
    knobs: Knobs,
    found: Found,
):
    """Runs LANES lanes a thread, all at the same time."""
    first = wp.tid() * LANES
    # By names of their own: read off the struct they would keep the loop over lanes scalar.
    results = found.results
    leaves = found.blocks
    rotations = found.rotations
    places = found.places
    x, z, theta, vx, vz, omega = Lane(), Lane(), Lane(), Lane(), Lane(), Lane()
    n1, n2, loss, base = Lane(), Lane(), Lane(), Lane()
    given, jolt, supplied, taken, returned = Lane(), Lane(), Lane(), Lane(), Lane()
    peak, peak_time, peak_slide, deepest = Lane(), Lane(), Lane(), Lane()
    uplift_time, moved, since = Lane(), Lane(), Lane()
    impacts, mode, steps, apart1, apart2 = LaneInt(), LaneInt(), LaneInt(), LaneInt(), LaneInt()
    for i in range(LANES):
        block = blocks[first + i]
        th = starts[first + i]
        theta[i] = th
        qx, qz, uz, p1, p2 = start(block, knobs, th)
        x[i] = qx
        z[i] = qz
        vz[i] = uz
        n1[i] = p1
        n2[i] = p2
        peak[i] = size(th)
        uplift_time[i] = wp.where(th == real(0.0), NEVER, real(0.0))
        mode[i] = RUNNING
    k = int(0)
    time = real(0.0)
    for sample in range(sample_times.shape[0]):
        until = sample_times[sample]
        while time < until:
            k += 1
            time = real(k) * knobs.time_step
            half = time - HALF * knobs.time_step
            early = before_start(k)
            for i in range(LANES):
                m = motions[first + i]
                # Field by field: four float32 loaded at once would keep the loop scalar.
                block = Block()
                block.half_width = blocks[first + i].half_width
                block.half_height = blocks[first + i].half_height
                block.inverse_inertia = blocks[first + i].inverse_inertia
                block.friction = blocks[first + i].friction
                block.cfm = blocks[first + i].cfm
                block.erp = blocks[first + i].erp
                place = sample_index(m, sample_segment(m, half))
                moving = base_velocity(m, half, pool[2, place], pool[0, place], pool[1, place])
                qx, qz, qt, ux, uz, uo, p1, p2, lo, mi, gap, gap1, gap2 = step(
                    block, knobs, moving - base[i], x[i], z[i], theta[i], vx[i], vz[i], omega[i],
                    n1[i], n2[i], loss[i],
                )  # fmt: skip
                mo, pk, pt, ps = observe(
                    mode[i], time, qt, uo, slide_of(block, qx, qt), peak[i], peak_time[i],
                    peak_slide[i],
                )  # fmt: skip
                mo = wp.where(mi > real(0.0) and mo != BROKEN, UNSOLVED, mo)
                live = mode[i] == RUNNING
                watch(
                    live, time, limit_of(block, knobs, uo), p1, gap1, p2, gap2,
                    glides(block, knobs, ux, uo), since[i], apart1[i], apart2[i], uplift_time[i],
                    moved[i], impacts[i],
                )  # fmt: skip
                x[i] = wp.where(live, qx, x[i])
                z[i] = wp.where(live, qz, z[i])
                theta[i] = wp.where(live, qt, theta[i])
                loss[i] = wp.where(live, lo + early * vz[i] * (p1 + p2), loss[i])
                dv = moving - base[i]
                given[i] = given[i] - wp.where(live, HALF * dv * (vx[i] + ux), real(0.0))
                vx[i] = wp.where(live, ux, vx[i])
                vz[i] = wp.where(live, uz, vz[i])
                omega[i] = wp.where(live, uo, omega[i])
                n1[i] = wp.where(live, p1, n1[i])
                n2[i] = wp.where(live, p2, n2[i])
                base[i] = moving
                book(dv, given[i], loss[i], jolt[i], supplied[i], taken[i], returned[i])
                peak[i] = wp.where(live, pk, peak[i])
                peak_time[i] = wp.where(live, pt, peak_time[i])
                peak_slide[i] = wp.where(live, ps, peak_slide[i])
                deepest[i] = wp.where(live, larger(-gap, deepest[i]), deepest[i])
                steps[i] = steps[i] + wp.where(live, 1, 0)
                mode[i] = wp.where(live, mo, mode[i])
        past = time - until
        if rotations.shape[0] > 0:
            for i in range(LANES):
                rotations[sample, 0, first + i] = at_sample(mode[i], past, theta[i], omega[i])
        if places.shape[0] > 0:
            for i in range(LANES):
                places[sample, 0, 0, first + i] = at_sample(mode[i], past, x[i], vx[i])
                places[sample, 0, 1, first + i] = at_sample(mode[i], past, z[i], vz[i])
    for i in range(LANES):
        results[first + i] = Result(
            uplift_time[i], moved[i], loss[i], jolt[i], supplied[i], returned[i], deepest[i],
            impacts[i], mode[i], steps[i],
        )  # fmt: skip
        slide = slide_of(blocks[first + i], x[i], theta[i])
        leaves[0, first + i] = BlockResult(slide, peak[i], peak_time[i], peak_slide[i])
