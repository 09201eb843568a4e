"""Runs of the Housner step over lanes, LANES lanes a thread: a pack on the CPU, one on any device.

With one lane a thread the same text is the plain form.

Under a record most steps of the packed form are those of housner/block_roll.py. Lanes need the
others at times of their own, so its first thread runs all lanes of a launch: those that wait for
such a step take it together once there are LANES of them, and where a lane has come to its end
another takes its place. What a lane does depends on itself alone. The plain form shares with it
that a block at rest passes many samples at once.
"""

import warp as wp

from warprock.kernels.housner.block import Block, step
from warprock.kernels.housner.block_found import BlockResult, Found, Result
from warprock.kernels.instance import CAPTURES, module_options
from warprock.kernels.modes import OVERTURNED, RESTING, ROCKING, STALLED
from warprock.kernels.motion import Motion, sample_index

ROLLS = MOTION == "record" and LANES > 1
HOPS = MOTION == "record"

if HOPS:
    from warprock.kernels.housner.block_roll import rest_on

if ROLLS:
    from warprock.kernels.housner.block_places import (
        CAP,
        COME,
        DUE,
        FREE,
        IMPACTS,
        LANE,
        LOSS,
        MODE,
        NEEDED,
        OMEGA,
        PEAK,
        PEAK_TIME,
        PLACES,
        REST_TIME,
        ROLL,
        SAMPLE,
        SEGMENT,
        SIDE,
        THETA,
        TIME,
        UNTIL,
        UPLIFT_TIME,
        WAIT,
        Marks,
        Numbers,
        Pack,
        PackMarks,
        at,
        block_at,
        block_result_of,
        bring_back,
        ends,
        keep,
        mark,
        motion_at,
        result_of,
        roll_on,
        start_lane,
        take_along,
    )
    from warprock.kernels.housner.block_roll import roll

    wp.set_module_options(module_options(more_flags=CAPTURES))


Lane = wp.types.vector(length=LANES, dtype=real)
LaneInt = wp.types.vector(length=LANES, dtype=int)


if ROLLS:

    @wp.kernel
    def run_lanes(
        blocks: wp.array(dtype=Block), motions: wp.array(dtype=Motion),
        pool: wp.array2d(dtype=real), starts: wp.array(dtype=real), rates: wp.array(dtype=real),
        sample_times: wp.array(dtype=real), found: Found,
    ):  # fmt: skip
        """Runs all lanes of a launch in its first thread, PLACES of them side by side."""
        thread, _one = wp.tid()
        if thread > 0:
            return
        coming, stop = int(0), blocks.shape[0]
        block_of = wp.array(ptr=blocks.ptr, shape=(blocks.shape[0],), dtype=Block)
        motion_of = wp.array(ptr=motions.ptr, shape=(motions.shape[0],), dtype=Motion)
        # By names of their own: read off the struct they would keep the loops over lanes scalar.
        results = found.results
        leaves = found.blocks
        rotations = found.rotations
        m, k, w, n = Numbers(), Marks(), Pack(), PackMarks()
        place = LaneInt()
        samples = sample_times.shape[0]
        for i in range(PLACES):
            k[DUE, i] = FREE
        busy = int(1)
        while busy > 0:
            rolling, waiting = int(0), int(0)
            for i in range(PLACES):
                if mark(k[DUE, i]) == FREE and coming < stop:
                    start_lane(
                        block_of[coming], motion_of[coming], coming, starts[coming], rates[coming],
                        m, k, i,
                    )  # fmt: skip
                    coming += 1
                while mark(k[DUE, i]) == COME:
                    lane, sample, ended = mark(k[LANE, i]), mark(k[SAMPLE, i]), ends(k, i)
                    while sample < samples and (ended or at(m[TIME, i]) >= sample_times[sample]):
                        if rotations.shape[0] > 0:
                            rotations[sample, 0, lane] = at(m[THETA, i])
                        sample += 1
                    k[SAMPLE, i] = sample
                    k[DUE, i] = ROLL
                    if sample < samples:
                        m[UNTIL, i] = sample_times[sample]
                    else:
                        results[lane] = result_of(m, k, i)
                        leaves[0, lane] = block_result_of(m, i)
                        k[DUE, i] = FREE
                    if mark(k[DUE, i]) == ROLL and mark(k[MODE, i]) == RESTING:
                        rests = bool(True)
                        while rests and at(m[TIME, i]) < at(m[UNTIL, i]):
                            index = sample_index(motion_at(m, k, i), mark(k[SEGMENT, i]))
                            rests, ti, se = rest_on(
                                block_at(m, i), motion_at(m, k, i), pool[0, index],
                                pool[1, index], pool[3, index], at(m[UNTIL, i]), at(m[TIME, i]),
                                mark(k[SEGMENT, i]), RESTING, at(m[CAP, i]),
                            )  # fmt: skip
                            m[TIME, i] = ti
                            k[SEGMENT, i] = se
                        k[DUE, i] = wp.where(at(m[TIME, i]) < at(m[UNTIL, i]), WAIT, COME)
                if mark(k[DUE, i]) == WAIT:
                    if waiting < LANES:
                        place[waiting] = i
                    waiting += 1
                rolling += wp.where(mark(k[DUE, i]) == ROLL, 1, 0)
            busy = rolling + waiting + stop - coming
            # A quarter of all places, or of the lanes in them where no others come.
            enough = wp.clamp((rolling + waiting) // 4, 1, LANES)
            if waiting >= enough:
                # A pack that is not full has its last lane several times.
                count = wp.where(waiting < LANES, waiting, LANES)
                for i in range(LANES):
                    take_along(m, k, place[wp.where(i < count, i, count - 1)], w, n, i)
                for i in range(LANES):
                    motion = motion_of[mark(n[LANE, i])]
                    index = sample_index(motion, mark(n[SEGMENT, i]))
                    th, om, si, ti, se, mo, pk, pt, ut, rt, lo, im, ca, ne = step(
                        block_of[mark(n[LANE, i])], motion, pool[0, index], pool[1, index],
                        at(w[UNTIL, i]), at(w[THETA, i]), at(w[OMEGA, i]), at(w[SIDE, i]),
                        at(w[TIME, i]), mark(n[SEGMENT, i]), mark(n[MODE, i]), at(w[PEAK, i]),
                        at(w[PEAK_TIME, i]), at(w[UPLIFT_TIME, i]), at(w[REST_TIME, i]),
                        at(w[LOSS, i]), mark(n[IMPACTS, i]), at(w[CAP, i]), at(w[NEEDED, i]),
                    )  # fmt: skip
                    keep(th, om, si, ti, se, mo, pk, pt, ut, rt, lo, im, ca, ne, w, n, i)
                for i in range(count):
                    bring_back(m, k, place[i], w, n, i)
            # Lanes roll until a pack of them waits, or has come to a sample or to its end.
            rolling = wp.where(waiting < LANES + enough, busy, 0)
            while rolling > 0:
                for i in range(PLACES):
                    motion = motion_at(m, k, i)
                    index = sample_index(motion, mark(k[SEGMENT, i]))
                    ok, th, om, ti, se = roll(
                        block_at(m, i), motion, pool[0, index], pool[1, index],
                        at(m[UNTIL, i]), at(m[THETA, i]), at(m[OMEGA, i]), at(m[SIDE, i]),
                        at(m[TIME, i]), mark(k[SEGMENT, i]), mark(k[MODE, i]), at(m[PEAK, i]),
                        at(m[CAP, i]), at(m[NEEDED, i]),
                    )  # fmt: skip
                    roll_on(ok, th, om, ti, se, m, k, i)
                rolling, free = int(0), int(0)
                for i in range(PLACES):
                    rolling += wp.where(mark(k[DUE, i]) == ROLL, 1, 0)
                    free += wp.where(mark(k[DUE, i]) == FREE, 1, 0)
                rolling = wp.where(PLACES - rolling - free < enough, rolling, 0)

else:

    @wp.kernel
    def run_lanes(
        blocks: wp.array(dtype=Block),
        motions: wp.array(dtype=Motion),
        pool: wp.array2d(dtype=real),
        starts: wp.array(dtype=real),
        rates: wp.array(dtype=real),
        sample_times: wp.array(dtype=real),
        found: Found,
    ):
        """Runs LANES lanes a thread, which take their steps side by side."""
        pack, _one = wp.tid()
        first = pack * LANES
        block_of = wp.array(ptr=blocks.ptr, shape=(blocks.shape[0],), dtype=Block)
        motion_of = wp.array(ptr=motions.ptr, shape=(motions.shape[0],), dtype=Motion)
        # By names of their own: read off the struct they would keep the loop over lanes scalar.
        results = found.results
        leaves = found.blocks
        rotations = found.rotations
        theta = Lane()
        omega = Lane()
        side = Lane()
        time = Lane()
        segment = LaneInt()
        mode = LaneInt()
        peak = Lane()
        peak_time = Lane()
        uplift_time = Lane()
        rest_time = Lane()
        loss = Lane()
        impacts = LaneInt()
        cap = Lane()
        needed = Lane()
        steps = LaneInt()
        for i in range(LANES):
            theta[i] = starts[first + i]
            omega[i] = rates[first + i]
            side[i] = sign_of(wp.where(theta[i] == real(0.0), omega[i], theta[i]))
            rests = theta[i] == real(0.0) and omega[i] == real(0.0)
            mode[i] = wp.where(rests, RESTING, ROCKING)
            peak[i] = size(theta[i])
            cap[i] = NEVER
            uplift_time[i] = wp.where(rests, NEVER, real(0.0))
            rest_time[i] = wp.where(rests, real(0.0), NEVER)
        for sample in range(sample_times.shape[0]):
            until = sample_times[sample]
            busy = int(1)
            while busy > 0:
                busy = int(0)
                for i in range(LANES):
                    m = motion_of[first + i]
                    place = sample_index(m, segment[i])
                    going = mode[i] < OVERTURNED and time[i] < until
                    th, om, si, ti, se, mo, pk, pt, ut, rt, lo, im, ca, ne = step(
                        block_of[first + i], m, pool[0, place], pool[1, place], until,
                        theta[i], omega[i], side[i], time[i], segment[i], mode[i],
                        peak[i], peak_time[i], uplift_time[i], rest_time[i], loss[i], impacts[i],
                        cap[i], needed[i],
                    )  # fmt: skip
                    if HOPS:
                        rests, far, passed = rest_on(
                            block_of[first + i], m, pool[0, place], pool[1, place], pool[3, place],
                            until, time[i], segment[i], mode[i], cap[i],
                        )  # fmt: skip
                        rests = rests and going
                        going = going and not rests
                        time[i] = wp.where(rests, far, time[i])
                        segment[i] = wp.where(rests, passed, segment[i])
                    # A lane that waits for others takes no step, not even one of length zero.
                    steps[i] = steps[i] + wp.where(going, 1, 0)
                    theta[i] = wp.where(going, th, theta[i])
                    omega[i] = wp.where(going, om, omega[i])
                    side[i] = wp.where(going, si, side[i])
                    time[i] = wp.where(going, ti, time[i])
                    segment[i] = wp.where(going, se, segment[i])
                    mo = wp.where(
                        steps[i] >= block_of[first + i].step_limit and mo < OVERTURNED, STALLED, mo
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
            leaves[0, first + i] = BlockResult(peak[i], peak_time[i])
