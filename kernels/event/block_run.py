"""Runs of the event step over lanes, LANES lanes a thread: a pack on the CPU, one on any device.

Every lane has its own time and ends its steps at its events. The rotation at a sample inside a step
is read off the polynomial that the step follows, so that histories do not change the run.

With one lane a thread the same text is the plain form.
"""

import warp as wp

from warprock.kernels.algebra.vectors import ALONG, ONLY, UPWARDS
from warprock.kernels.event.block.contact import Block, lower_corner
from warprock.kernels.event.block.rocking import Curve, value_after
from warprock.kernels.event.block.roll import roll
from warprock.kernels.event.block.state import (
    Seen,
    State,
    is_at_rest,
    observe,
    observe_peaks,
    start_seen,
)
from warprock.kernels.event.block.step import Knobs, look_ahead, step
from warprock.kernels.event.found import Result, block_result, result_of
from warprock.kernels.lane.modes import FLAT, FLYING, OVERTURNED, PIVOTING, STALLED
from warprock.kernels.launch.instance import TWO_VECTORS
from warprock.kernels.launch.rows import kernel, rows
from warprock.kernels.motion.kinds import Motion, ground_at
from warprock.kernels.shape.stack_found import BlockResult

wp.set_module_options(TWO_VECTORS)


@wp.struct
class Clock:
    """When a lane's last step began, and how it waits for a step with events.

    Attributes:
        begun: Time [s].
        due: 0 where the lane waits for none, 1 where it has been declined a step without events,
            URGENT where it surely needs one with events.
    """

    begun: real
    due: int


@wp.struct
class Place:
    """Where a step began: slide and gap of the lower corner [m], velocity of the centre [m/s]."""

    slide: real
    gap: real
    vx: real
    vz: real


@wp.struct
class Found:
    """Results."""

    results: wp.array(dtype=Result)
    blocks: wp.array2d(dtype=BlockResult)
    rotations: wp.array3d(dtype=real)
    places: wp.array4d(dtype=real)


PATIENCE = 5
"""Half rounds without events that lanes may lose, over the lanes that still run, until all that
wait take a step with events: what such a step costs."""

URGENT = 4
"""Weight of a round that a lane loses which surely needs a step with events. A lane that slides or
flies needs nothing else, and its steps are shorter: without that weight the others wait for it."""


@wp.func
def rotation_at(until: real, begun: real, s: State, path: Curve) -> real:
    """Rotation inside the last step [rad], on the polynomial that it followed."""
    return wp.where(until < s.time, value_after(path, until - begun), s.theta)


@wp.func
def place_at(
    block: Block, until: real, begun: real, at: real, s: State, path: Curve, start: Place
):  # fmt: skip
    """Centre of mass inside the last step [m], from the slide and the gap of the lower corner.

    Args:
        block: The block.
        until: The time [s]; if the step ends earlier, its end counts.
        begun: Start of the step [s].
        at: Rotation at that time [rad].
        s: State at the end of the step.
        path: Rotation in the step.
        start: Where the step began.

    Returns:
        x and z.
    """
    inside = until < s.time
    d = s.time - begun
    tau = wp.where(inside, until - begun, d)
    part = wp.where(inside and d > real(0.0), tau / d, real(1.0))
    side0 = sign_of(wp.where(path.c0 != real(0.0), path.c0, path.c1))
    lower = lower_corner(block, side0 * path.c0)
    glide = start.vx + path.c1 * lower.z
    rise = start.vz - side0 * path.c1 * lower.x
    bend = part * part
    slid = start.slide + tau * glide + bend * (s.slide - start.slide - d * glide)
    high = start.gap + tau * rise + bend * (s.gap - start.gap - d * rise)
    side = sign_of(at)
    lower = lower_corner(block, side * at)
    return slid + side * (block.half_width - lower.x), high - lower.z


@wp.func
def start_lane(block: Block, theta: real, omega: real):
    """State and response of a block at its start, from its rotation [rad] and its rate [rad/s]."""
    zero = real(0.0)
    flat = theta == zero and omega == zero
    side = sign_of(wp.where(theta != zero, theta, omega))
    lower = lower_corner(block, side * theta)
    # Zero is added so that no number is -0.
    vx, vz = -omega * lower.z + zero, side * omega * lower.x + zero
    mode = wp.where(flat, FLAT, PIVOTING)
    state = State(theta, zero, zero, vx, vz, omega, zero, mode, zero, 0, zero, NEVER)
    return state, start_seen(theta, flat)


@wp.func
def waits(s: State) -> int:
    """URGENT where a lane's next step has events: it slides on a corner, flies or is tried anew."""
    drags = s.mode == PIVOTING and s.slip != real(0.0)
    return wp.where(drags or s.mode == FLYING or s.cap < NEVER, URGENT, 0)


@kernel
def run_lanes(
    blocks: wp.array(dtype=Block), motions: wp.array(dtype=Motion), pool: wp.array2d(dtype=real),
    starts: wp.array(dtype=real), rates: wp.array(dtype=real), sample_times: wp.array(dtype=real),
    knobs: Knobs, found: Found,
):  # fmt: skip
    """Runs LANES lanes a thread, which take their steps side by side."""
    pack, _one = wp.tid()
    first = pack * LANES
    block_of = wp.array(ptr=blocks.ptr, shape=(blocks.shape[0],), dtype=Block)
    motion_of = wp.array(ptr=motions.ptr, shape=(motions.shape[0],), dtype=Motion)
    # By names of their own: read off the struct they would keep the loop over lanes scalar.
    results = found.results
    leaves = found.blocks
    rotations = found.rotations
    places = found.places
    state = rows(State)
    path = rows(Curve)
    clock = rows(Clock)
    place = rows(Place)
    seen = rows(Seen)
    for i in range(LANES):
        start, sees = start_lane(block_of[first + i], starts[first + i], rates[first + i])
        state[i] = start
        seen[i] = sees
    end = sample_times[sample_times.shape[0] - 1]
    for sample in range(sample_times.shape[0]):
        until = sample_times[sample]
        busy, lost_rounds = int(1), int(0)
        while busy > 0:
            if places.shape[0] > 0:
                for i in range(LANES):
                    live = state[i].mode < OVERTURNED and state[i].time < until
                    here = Place(state[i].slide, state[i].gap, state[i].vx, state[i].vz)
                    place[i] = wp.where(live, here, place[i])
            busy, waiting, resting, lost = int(0), int(0), int(0), int(0)
            for i in range(LANES):
                goes = wp.where(state[i].mode < OVERTURNED and state[i].time < until, 1, 0)
                stops = wp.where(clock[i].due > 0, goes, 0)
                busy = busy + goes
                waiting = waiting + stops
                resting = resting + wp.where(is_at_rest(state[i]), stops, 0)
                lost = lost + goes * clock[i].due
            patient = waiting < busy and 2 * (lost_rounds + lost) < PATIENCE * busy
            lost_rounds = wp.where(patient, lost_rounds + lost, 0)
            if patient:
                for i in range(LANES):
                    m = motion_of[first + i]
                    ground = ground_at(m, state[i].segment, pool)
                    going = state[i].mode < OVERTURNED and state[i].time < until
                    going = going and clock[i].due == 0
                    limit = block_of[first + i].step_limit
                    new, shown, way = roll(
                        block_of[first + i], knobs, m, ground, end, going, state[i]
                    )
                    path[i] = wp.where(shown.taken, way, path[i])
                    clock[i].begun = wp.where(shown.taken, state[i].time, clock[i].begun)
                    sees = seen[i]
                    observe_peaks(new, shown.apex, shown.apex_time, sees)
                    sees.loss = sees.loss + shown.lost
                    sees.steps = sees.steps + wp.where(shown.taken, 1, 0)
                    seen[i] = sees
                    clock[i].due = wp.where(going and not shown.taken, 1, clock[i].due)
                    new.mode = wp.where(shown.taken and sees.steps >= limit, STALLED, new.mode)
                    state[i] = new
            if resting > 0 and not patient:
                for i in range(LANES):
                    m = motion_of[first + i]
                    ground = ground_at(m, state[i].segment, pool)
                    most = look_ahead(block_of[first + i], m, ground, end, state[i])
                    looks = is_at_rest(state[i]) and clock[i].due > 0
                    state[i].cap = wp.where(looks, smaller(most, state[i].cap), state[i].cap)
            if waiting > 0 and not patient:
                for i in range(LANES):
                    m = motion_of[first + i]
                    ground = ground_at(m, state[i].segment, pool)
                    going = state[i].mode < OVERTURNED and state[i].time < until
                    going = going and clock[i].due > 0
                    limit = block_of[first + i].step_limit
                    new, shown, way = step(
                        block_of[first + i], knobs, m, ground, end, going, state[i]
                    )
                    path[i] = wp.where(shown.taken, way, path[i])
                    clock[i].begun = wp.where(shown.taken, state[i].time, clock[i].begun)
                    sees = seen[i]
                    still = new.theta == real(0.0)
                    new.mode = observe(going, limit, still, state[i], new, shown, sees)
                    seen[i] = sees
                    state[i] = new
                    clock[i].due = wp.where(going, waits(new), clock[i].due)
        if rotations.shape[0] > 0:
            for i in range(LANES):
                rotations[sample, ONLY, first + i] = rotation_at(
                    until, clock[i].begun, state[i], path[i]
                )
        if places.shape[0] > 0:
            for i in range(LANES):
                angle = rotation_at(until, clock[i].begun, state[i], path[i])
                spot, level = place_at(
                    block_of[first + i], until, clock[i].begun, angle, state[i], path[i], place[i]
                )
                places[sample, ONLY, ALONG, first + i] = spot
                places[sample, ONLY, UPWARDS, first + i] = level
    for i in range(LANES):
        results[first + i] = result_of(seen[i], real(0.0), state[i].mode)
        leaves[0, first + i] = block_result(state[i].slide, seen[i])
