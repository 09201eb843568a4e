"""Runs of a body on a convex base over lanes, LANES lanes a thread; see housner/block_run.py."""

import warp as wp

from warprock.kernels.housner.block import end_of_step
from warprock.kernels.housner.block_found import BlockResult, Result
from warprock.kernels.housner.body import Body, Edge, Foot, advance, event_step, motion_step
from warprock.kernels.modes import OVERTURNED, RESTING, ROCKING, STALLED
from warprock.kernels.motion import Motion, knot_step, knot_time, sample_index
from warprock.kernels.shape.above import Above, Motions


@wp.struct
class Found:
    """Where the answers go; `sides`: largest rotations to -x and to +x [rad], shape [2, lane]."""

    results: wp.array(dtype=Result)
    blocks: wp.array2d(dtype=BlockResult)
    rotations: wp.array3d(dtype=real)
    sides: wp.array2d(dtype=real)


Lane = wp.types.vector(length=LANES, dtype=real)
LaneInt = wp.types.vector(length=LANES, dtype=int)


@wp.struct
class Start:
    """Rotation and its rate at the start, the number of the foot there, and that of the last."""

    theta: real
    omega: real
    place: int
    last: int


@wp.func
def settle(
    body: Body, foot: Foot, edge: Edge, upper: bool, pull: real, impact: bool, uplift: bool,
    acceleration: real, lifting: real, m: Motion, above: Above,
    theta: real, omega: real, place: int, time: real, segment: int, mode: int,
    peak: real, peak_time: real, uplift_time: real, rest_time: real, loss: real, impacts: int,
    needed: real,
):  # fmt: skip
    """What the event at the end of a step does, or else the knot of the motion that it ends at."""
    omega1, place1, mode1, uplift_time1, rest_time1, loss1, needed1 = event_step(
        body, edge, impact, uplift, upper, pull, acceleration, lifting, time,
        omega, place, mode, uplift_time, rest_time, loss, needed,
    )  # fmt: skip
    # After an event the foot is another: the knot is passed in a step of its own, of length zero.
    happened = impact or uplift
    passed = time >= knot_time(m, segment) and mode < OVERTURNED and not happened
    steps, dv, dz, high = bool(passed), knot_step(m, segment), real(0.0), int(above.segment)
    if VERTICAL:
        rises = time >= knot_time(above.motion, high) and mode < OVERTURNED and not happened
        dv = wp.where(passed, dv, real(0.0))
        dz = wp.where(rises, knot_step(above.motion, high), real(0.0))
        steps = passed or rises
        high = high + wp.where(rises, 1, 0)
    omega1, place1, mode1, uplift_time1, rest_time1, needed1 = motion_step(
        body, foot, edge, steps, dv, dz, time,
        theta, omega1, place1, mode1, uplift_time1, rest_time1, needed1,
    )  # fmt: skip
    mode1, theta1, peak1, peak_time1 = end_of_step(mode1, theta, omega1, time, peak, peak_time)
    return (
        theta1, omega1, place1, segment + wp.where(passed, 1, 0), high, mode1, peak1, peak_time1,
        uplift_time1, rest_time1, loss1, impacts + wp.where(impact, 1, 0), needed1,
    )  # fmt: skip


@wp.kernel
def run_lanes(
    blocks: wp.array(dtype=Body),
    feet: wp.array2d(dtype=Foot),
    edges: wp.array2d(dtype=Edge),
    motions: Motions,
    pool: wp.array2d(dtype=real),
    starts: wp.array(dtype=Start),
    sample_times: wp.array(dtype=real),
    found: Found,
):
    """Runs LANES lanes a thread, which take their steps side by side.

    `feet` and `edges` are [number, lane]; lanes with fewer repeat the last.
    """
    first = wp.tid() * LANES
    results = found.results
    leaves = found.blocks
    rotations = found.rotations
    sides = found.sides
    theta, omega = Lane(), Lane()
    place, last = LaneInt(), LaneInt()
    time = Lane()
    segment, risen, mode = LaneInt(), LaneInt(), LaneInt()
    peak = Lane()
    peak_time = Lane()
    left = Lane()
    right = Lane()
    uplift_time = Lane()
    rest_time = Lane()
    loss = Lane()
    impacts = LaneInt()
    cap = Lane()
    needed = Lane()
    steps = LaneInt()
    for i in range(LANES):
        theta[i] = starts[first + i].theta
        place[i] = starts[first + i].place
        last[i] = starts[first + i].last
        omega[i] = starts[first + i].omega
        flat = theta[i] == real(0.0) and omega[i] == real(0.0)
        mode[i] = wp.where(flat, RESTING, ROCKING)
        peak[i] = size(theta[i])
        cap[i] = NEVER
        uplift_time[i] = wp.where(flat, NEVER, real(0.0))
        rest_time[i] = wp.where(flat, real(0.0), NEVER)
    for sample in range(sample_times.shape[0]):
        until = sample_times[sample]
        busy = int(1)
        while busy > 0:
            busy = int(0)
            for i in range(LANES):
                above = Above()
                if VERTICAL:
                    m = motions[0, first + i]
                    up = motions[1, first + i]
                    high = sample_index(up, risen[i])
                    above = Above(up, risen[i], pool[0, high], pool[1, high])
                else:
                    m = motions[first + i]
                body = blocks[first + i]
                foot = feet[place[i], first + i]
                at = sample_index(m, segment[i])
                going = mode[i] < OVERTURNED and time[i] < until
                steps[i] = steps[i] + wp.where(going, 1, 0)
                # The last foot has no edge behind it.
                behind = edges[wp.min(place[i], last[i] - 1), first + i]
                th, om, ti, ac, az, upper, pu, hit, lift, ca, ne = advance(
                    body, foot, behind, last[i], m, pool[0, at], pool[1, at], above, until,
                    theta[i], omega[i], place[i], time[i], segment[i], mode[i], cap[i], needed[i],
                )  # fmt: skip
                number = place[i] - wp.where(upper, 0, 1)
                edge = edges[wp.min(wp.max(number, 0), last[i] - 1), first + i]
                th, om, pl, se, hi, mo, pk, pt, ut, rt, lo, im, ne = settle(
                    body, foot, edge, upper, pu, hit, lift, ac, az, m, above,
                    th, om, place[i], ti, segment[i], mode[i], peak[i], peak_time[i],
                    uplift_time[i], rest_time[i], loss[i], impacts[i], ne,
                )  # fmt: skip
                # A lane that waits for others takes no step, not even one of length zero.
                theta[i] = wp.where(going, th, theta[i])
                left[i] = larger(-theta[i], left[i])
                right[i] = larger(theta[i], right[i])
                omega[i] = wp.where(going, om, omega[i])
                place[i] = wp.where(going, pl, place[i])
                time[i] = wp.where(going, ti, time[i])
                segment[i] = wp.where(going, se, segment[i])
                risen[i] = wp.where(going, hi, risen[i])
                mo = wp.where(
                    steps[i] >= blocks[first + i].step_limit and mo < OVERTURNED, STALLED, mo
                )
                mode[i] = wp.where(going, mo, mode[i])
                peak[i] = wp.where(going, pk, peak[i])
                peak_time[i] = wp.where(going, pt, peak_time[i])
                uplift_time[i] = wp.where(going, ut, uplift_time[i])
                rest_time[i] = wp.where(going, rt, rest_time[i])
                loss[i] = wp.where(going, lo, loss[i])
                impacts[i] = wp.where(going, im, impacts[i])
                cap[i] = wp.where(going, ca, cap[i])
                needed[i] = wp.where(going, ne, needed[i])
            for i in range(LANES):
                busy = busy + wp.where(mode[i] < OVERTURNED and time[i] < until, 1, 0)
        if rotations.shape[0] > 0:
            for i in range(LANES):
                rotations[sample, 0, first + i] = theta[i]
    for i in range(LANES):
        results[first + i] = Result(
            uplift_time[i], rest_time[i], loss[i], needed[i], impacts[i], mode[i], steps[i]
        )
        sides[0, first + i] = left[i]
        sides[1, first + i] = right[i]
        leaves[0, first + i] = BlockResult(peak[i], peak_time[i])
