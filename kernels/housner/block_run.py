"""Runs of the Housner step over lanes, LANES lanes a thread: a pack on the CPU, one on any device.

With one lane a thread the same text is the plain form.

Under a record most steps of the packed form are those of housner/block_roll.py. Lanes need the
others at times of their own, so its first thread runs all lanes of a launch: those that wait for
such a step take it together once there are LANES of them, and where a lane has come to its end
another takes its place. What a lane does depends on itself alone. The plain form shares with it
that a block at rest passes many samples at once.
"""

import warp as wp

from warprock.kernels.algebra.vectors import ONLY
from warprock.kernels.housner.block import Block, State, stall, start_lane, step
from warprock.kernels.housner.block_found import BlockResult, Found, Result, Seen
from warprock.kernels.lane.modes import OVERTURNED, RESTING
from warprock.kernels.launch.instance import (
    CAPTURES,
    FOUR_VECTORS,
    HALVES_VECTORS,
    TWO_VECTORS,
    module_options,
)
from warprock.kernels.launch.rows import kernel, rows
from warprock.kernels.motion.kinds import Motion, ground_at

RECORD = MOTION == "record"

FOUR = HALVES_VECTORS and MOTION not in ("still", "record") and PRECISION == "float64"
wp.set_module_options(FOUR_VECTORS if FOUR else TWO_VECTORS)

if RECORD:
    from warprock.kernels.housner.block_roll import rest_on, roll


@wp.func
def result_of(s: State, seen: Seen) -> Result:
    """What the run of a lane leaves behind."""
    return Result(
        seen.uplift_time, seen.rest_time, seen.loss, s.needed, seen.impacts, s.mode, seen.steps
    )


if RECORD and LANES > 1:
    wp.set_module_options(module_options(interleave=2, more_flags=CAPTURES))

    Members = wp.types.vector(length=LANES, dtype=int)
    """Places of the lanes that take a step with events together."""

    PLACES = 4 * LANES
    """Lanes side by side: enough for LANES of them to wait for one another, and rows fit the
    cache."""

    ROLL, WAIT, COME, FREE = 0, 1, 2, 3
    """What a place is due to: a step without events; one that may hold some; a look, since its lane
    has come to a sample or to its end; another lane."""

    @wp.struct
    class Place:
        """One of the lanes side by side.

        Attributes:
            lane: Its number.
            sample: Number of its next sample.
            until: Time of that [s].
            due: What the place is due to.
        """

        lane: int
        sample: int
        until: real
        due: int

    @kernel
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
        place = rows(Place, lanes=PLACES)
        block = rows(Block, lanes=PLACES)
        motion = rows(Motion, lanes=PLACES)
        state = rows(State, lanes=PLACES)
        seen = rows(Seen, lanes=PLACES)
        # Lanes that take a step with events together, and their places.
        pack = rows(Place)
        pack_state = rows(State)
        pack_seen = rows(Seen)
        members = Members()
        samples = sample_times.shape[0]
        for i in range(PLACES):
            place[i].due = FREE
        busy = int(1)
        while busy > 0:
            rolling, waiting = int(0), int(0)
            for i in range(PLACES):
                if place[i].due == FREE and coming < stop:
                    s0, o0 = start_lane(starts[coming], rates[coming])
                    state[i] = s0
                    seen[i] = o0
                    block[i] = block_of[coming]
                    motion[i] = motion_of[coming]
                    place[i] = Place(coming, 0, real(0.0), COME)
                    coming += 1
                while place[i].due == COME:
                    lane = place[i].lane
                    sample = place[i].sample
                    state[i].mode = stall(state[i].mode, seen[i].steps, block[i].step_limit)
                    ended = state[i].mode >= OVERTURNED
                    while sample < samples and (ended or state[i].time >= sample_times[sample]):
                        if rotations.shape[0] > 0:
                            rotations[sample, ONLY, lane] = state[i].theta
                        sample += 1
                    place[i].sample = sample
                    place[i].due = ROLL
                    if sample < samples:
                        place[i].until = sample_times[sample]
                    else:
                        results[lane] = result_of(state[i], seen[i])
                        leaves[0, lane] = BlockResult(seen[i].peak, seen[i].peak_time)
                        place[i].due = FREE
                    if place[i].due == ROLL and state[i].mode == RESTING:
                        rests = bool(True)
                        while rests and state[i].time < place[i].until:
                            ground = ground_at(motion[i], state[i].segment, pool)
                            rests, time, segment, needed = rest_on(
                                block[i], motion[i], ground, place[i].until, state[i]
                            )
                            state[i].time = time
                            state[i].segment = segment
                            state[i].needed = needed
                        place[i].due = wp.where(state[i].time < place[i].until, WAIT, COME)
                if place[i].due == WAIT:
                    if waiting < LANES:
                        members[waiting] = i
                    waiting += 1
                rolling += wp.where(place[i].due == ROLL, 1, 0)
            busy = rolling + waiting + stop - coming
            # A quarter of all places, or of the lanes in them where no others come.
            enough = wp.clamp((rolling + waiting) // 4, 1, LANES)
            if waiting >= enough:
                # A pack that is not full has its last lane several times.
                count = wp.where(waiting < LANES, waiting, LANES)
                for i in range(LANES):
                    p = members[wp.where(i < count, i, count - 1)]
                    pack[i] = place[p]
                    pack_state[i] = state[p]
                    pack_seen[i] = seen[p]
                for i in range(LANES):
                    m = motion_of[pack[i].lane]
                    ground = ground_at(m, pack_state[i].segment, pool)
                    s1, o1 = step(
                        block_of[pack[i].lane], m, ground, pack[i].until, pack_state[i],
                        pack_seen[i],
                    )  # fmt: skip
                    pack_state[i] = s1
                    pack_seen[i] = o1
                for i in range(count):
                    p = members[i]
                    state[p] = pack_state[i]
                    seen[p] = pack_seen[i]
                    comes = state[p].mode >= OVERTURNED or state[p].time >= place[p].until
                    comes = comes or state[p].mode == RESTING
                    place[p].due = wp.where(comes, COME, ROLL)
            # Lanes roll until a pack of them waits, or has come to a sample or to its end.
            rolling = wp.where(waiting < LANES + enough, busy, 0)
            while rolling > 0:
                for i in range(PLACES):
                    ground = ground_at(motion[i], state[i].segment, pool)
                    due = place[i].due
                    peak = seen[i].peak
                    until = place[i].until
                    calm, after = roll(block[i], motion[i], ground, until, state[i], peak)
                    taken = calm and due == ROLL
                    state[i] = wp.where(taken, after, state[i])
                    count = seen[i].steps + 1
                    higher = taken and size(after.theta) > peak
                    seen[i].peak = wp.where(higher, size(after.theta), peak)
                    seen[i].peak_time = wp.where(higher, after.time, seen[i].peak_time)
                    seen[i].steps = wp.where(taken, count, seen[i].steps)
                    comes = after.time >= until or count >= block[i].step_limit
                    next_due = wp.where(calm, wp.where(comes, COME, ROLL), WAIT)
                    place[i].due = wp.where(due == ROLL, next_due, due)
                rolling, free = int(0), int(0)
                for i in range(PLACES):
                    rolling += wp.where(place[i].due == ROLL, 1, 0)
                    free += wp.where(place[i].due == FREE, 1, 0)
                rolling = wp.where(PLACES - rolling - free < enough, rolling, 0)

else:

    @kernel
    def run_lanes(
        blocks: wp.array(dtype=Block), motions: wp.array(dtype=Motion),
        pool: wp.array2d(dtype=real), starts: wp.array(dtype=real), rates: wp.array(dtype=real),
        sample_times: wp.array(dtype=real), found: Found,
    ):  # fmt: skip
        """Runs LANES lanes a thread, which take their steps side by side."""
        thread, _one = wp.tid()
        first = thread * LANES
        block_of = wp.array(ptr=blocks.ptr, shape=(blocks.shape[0],), dtype=Block)
        motion_of = wp.array(ptr=motions.ptr, shape=(motions.shape[0],), dtype=Motion)
        # By names of their own: read off the struct they would keep the loop over lanes scalar.
        results = found.results
        leaves = found.blocks
        rotations = found.rotations
        state = rows(State)
        seen = rows(Seen)
        for i in range(LANES):
            s0, o0 = start_lane(starts[first + i], rates[first + i])
            state[i] = s0
            seen[i] = o0
        for sample in range(sample_times.shape[0]):
            until = sample_times[sample]
            busy = int(1)
            while busy > 0:
                busy = int(0)
                for i in range(LANES):
                    m = motion_of[first + i]
                    going = state[i].mode < OVERTURNED and state[i].time < until
                    ground = ground_at(m, state[i].segment, pool)
                    after, shown = step(block_of[first + i], m, ground, until, state[i], seen[i])
                    if RECORD:
                        rests, far, passed, needed = rest_on(
                            block_of[first + i], m, ground, until, state[i]
                        )
                        rests = rests and going
                        going = going and not rests
                        state[i].time = wp.where(rests, far, state[i].time)
                        state[i].segment = wp.where(rests, passed, state[i].segment)
                        state[i].needed = wp.where(rests, needed, state[i].needed)
                    # A lane that waits for others takes no step, not even one of length zero.
                    state[i] = wp.where(going, after, state[i])
                    seen[i] = wp.where(going, shown, seen[i])
                for i in range(LANES):
                    runs = state[i].mode < OVERTURNED and state[i].time < until
                    busy = busy + wp.where(runs, 1, 0)
            if rotations.shape[0] > 0:
                for i in range(LANES):
                    rotations[sample, ONLY, first + i] = state[i].theta
        for i in range(LANES):
            results[first + i] = result_of(state[i], seen[i])
            leaves[0, first + i] = BlockResult(seen[i].peak, seen[i].peak_time)
