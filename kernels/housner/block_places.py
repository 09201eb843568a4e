"""What is kept of the lanes that run side by side under a record.

One matrix of real and one of whole numbers, a row for each number of a lane, a column for each
place.
"""

import warp as wp

from warprock.kernels.housner.block import Block
from warprock.kernels.housner.block_found import BlockResult, Result
from warprock.kernels.modes import OVERTURNED, RESTING, ROCKING, STALLED
from warprock.kernels.motion import Motion

PLACES = 4 * LANES
"""Lanes side by side: enough for LANES of them to wait for one another, and rows fit the cache."""

THETA, OMEGA, SIDE, TIME, PEAK, PEAK_TIME = 0, 1, 2, 3, 4, 5
UPLIFT_TIME, REST_TIME, LOSS, CAP, NEEDED, UNTIL = 6, 7, 8, 9, 10, 11
STATE = 12
ANGLE, FREQUENCY, COUPLING, UPLIFT, FALL, LENGTH = 12, 13, 14, 15, 16, 17
START, SCALE, INTERVAL = 18, 19, 20
ROWS = 21
"""Rows of real numbers: of the state, see housner/block.py, with the time of the next sample; of
the block and of its motion."""

SEGMENT, MODE, IMPACTS, LANE = 0, 1, 2, 3
MARKED = 4
STEPS, STEP_LIMIT, OFFSET, COUNT, SAMPLE, DUE = 4, 5, 6, 7, 8, 9
MARKS = 10
"""Rows of whole numbers: of the state, with the number of the lane; of the block and of its motion;
the number of the next sample, and what the place is due to."""

ROLL, WAIT, COME, FREE = 0, 1, 2, 3
"""What a place is due to: a step without events; one that may hold some; a look, since its lane has
come to a sample or to its end; another lane."""

Numbers = wp.types.matrix(shape=(ROWS, PLACES), dtype=real)
Marks = wp.types.matrix(shape=(MARKS, PLACES), dtype=int)
Pack = wp.types.matrix(shape=(STATE, LANES), dtype=real)
PackMarks = wp.types.matrix(shape=(MARKED, LANES), dtype=int)
"""The same of the lanes that take a step with events together."""


@wp.func(inline=True)
def at(entry: wp.ref[real]) -> real:
    """An entry of a matrix, which is copied as a whole if it is read without this."""
    return entry


@wp.func(inline=True)
def mark(entry: wp.ref[int]) -> int:
    """As `at`, of whole numbers."""
    return entry


@wp.func(inline=True)
def start_lane(
    block: Block, motion: Motion, lane: int, theta: real, omega: real, m: wp.ref[Numbers],
    k: wp.ref[Marks], i: int,
):  # fmt: skip
    """Puts a lane in a free place, let go at a rotation [rad] with a rate [rad/s]."""
    rests = theta == real(0.0) and omega == real(0.0)
    m[THETA, i] = theta
    m[OMEGA, i] = omega
    m[SIDE, i] = sign_of(wp.where(theta == real(0.0), omega, theta))
    m[TIME, i] = real(0.0)
    m[PEAK, i] = size(theta)
    m[PEAK_TIME, i] = real(0.0)
    m[UPLIFT_TIME, i] = wp.where(rests, NEVER, real(0.0))
    m[REST_TIME, i] = wp.where(rests, real(0.0), NEVER)
    m[LOSS, i] = real(0.0)
    m[CAP, i] = NEVER
    m[NEEDED, i] = real(0.0)
    m[ANGLE, i] = block.slenderness_angle
    m[FREQUENCY, i] = block.frequency_squared
    m[COUPLING, i] = block.coupling
    m[UPLIFT, i] = block.uplift_acceleration
    m[FALL, i] = block.fall_angle
    m[LENGTH, i] = block.step_length
    m[START, i] = motion.start
    m[SCALE, i] = motion.scale
    m[INTERVAL, i] = motion.interval
    k[SEGMENT, i] = 0
    k[MODE, i] = wp.where(rests, RESTING, ROCKING)
    k[IMPACTS, i] = 0
    k[LANE, i] = lane
    k[STEPS, i] = 0
    k[STEP_LIMIT, i] = block.step_limit
    k[OFFSET, i] = motion.offset
    k[COUNT, i] = motion.count
    k[SAMPLE, i] = 0
    k[DUE, i] = COME


@wp.func(inline=True)
def block_at(m: wp.ref[Numbers], i: int) -> Block:
    """What a step without events needs to know of a block."""
    block = Block()
    block.slenderness_angle = at(m[ANGLE, i])
    block.frequency_squared = at(m[FREQUENCY, i])
    block.coupling = at(m[COUPLING, i])
    block.uplift_acceleration = at(m[UPLIFT, i])
    block.fall_angle = at(m[FALL, i])
    block.step_length = at(m[LENGTH, i])
    return block


@wp.func(inline=True)
def motion_at(m: wp.ref[Numbers], k: wp.ref[Marks], i: int) -> Motion:
    """What it needs to know of the motion."""
    motion = Motion()
    motion.start = at(m[START, i])
    motion.scale = at(m[SCALE, i])
    motion.interval = at(m[INTERVAL, i])
    motion.offset = mark(k[OFFSET, i])
    motion.count = mark(k[COUNT, i])
    return motion


@wp.func(inline=True)
def roll_on(
    ok: bool, theta: real, omega: real, time: real, segment: int, m: wp.ref[Numbers],
    k: wp.ref[Marks], i: int,
):  # fmt: skip
    """What a step without events does to a lane that is due to one, if it is taken."""
    due = mark(k[DUE, i])
    until = at(m[UNTIL, i])
    peak = at(m[PEAK, i])
    count = mark(k[STEPS, i]) + 1
    comes = time >= until or count >= mark(k[STEP_LIMIT, i])
    taken = ok and due == ROLL
    higher = taken and size(theta) > peak
    m[THETA, i] = wp.where(taken, theta, at(m[THETA, i]))
    m[OMEGA, i] = wp.where(taken, omega, at(m[OMEGA, i]))
    m[TIME, i] = wp.where(taken, time, at(m[TIME, i]))
    k[SEGMENT, i] = wp.where(taken, segment, mark(k[SEGMENT, i]))
    m[PEAK, i] = wp.where(higher, size(theta), peak)
    m[PEAK_TIME, i] = wp.where(higher, time, at(m[PEAK_TIME, i]))
    k[STEPS, i] = wp.where(taken, count, mark(k[STEPS, i]))
    next_due = wp.where(ok, wp.where(comes, COME, ROLL), WAIT)
    k[DUE, i] = wp.where(due == ROLL, next_due, due)


@wp.func(inline=True)
def take_along(
    m: wp.ref[Numbers], k: wp.ref[Marks], p: int, pack: wp.ref[Pack], marks: wp.ref[PackMarks],
    i: int,
):  # fmt: skip
    """Copies the state of a place to a lane of the pack."""
    for row in range(STATE):
        pack[row, i] = at(m[row, p])
    for row in range(MARKED):
        marks[row, i] = mark(k[row, p])


@wp.func(inline=True)
def keep(
    theta: real, omega: real, side: real, time: real, segment: int, mode: int, peak: real,
    peak_time: real, uplift_time: real, rest_time: real, loss: real, impacts: int, cap: real,
    needed: real, pack: wp.ref[Pack], marks: wp.ref[PackMarks], i: int,
):  # fmt: skip
    """Keeps the state of a lane of the pack."""
    pack[THETA, i] = theta
    pack[OMEGA, i] = omega
    pack[SIDE, i] = side
    pack[TIME, i] = time
    marks[SEGMENT, i] = segment
    marks[MODE, i] = mode
    pack[PEAK, i] = peak
    pack[PEAK_TIME, i] = peak_time
    pack[UPLIFT_TIME, i] = uplift_time
    pack[REST_TIME, i] = rest_time
    pack[LOSS, i] = loss
    marks[IMPACTS, i] = impacts
    pack[CAP, i] = cap
    pack[NEEDED, i] = needed


@wp.func(inline=True)
def bring_back(
    m: wp.ref[Numbers], k: wp.ref[Marks], p: int, pack: wp.ref[Pack], marks: wp.ref[PackMarks],
    i: int,
):  # fmt: skip
    """Copies it back after a step, and says what the place is due to."""
    for row in range(STATE):
        m[row, p] = at(pack[row, i])
    for row in range(MARKED):
        k[row, p] = mark(marks[row, i])
    count = mark(k[STEPS, p]) + 1
    finished = mark(k[MODE, p]) >= OVERTURNED or at(m[TIME, p]) >= at(m[UNTIL, p])
    k[STEPS, p] = count
    comes = finished or count >= mark(k[STEP_LIMIT, p]) or mark(k[MODE, p]) == RESTING
    k[DUE, p] = wp.where(comes, COME, ROLL)


@wp.func(inline=True)
def ends(k: wp.ref[Marks], i: int) -> bool:
    """Whether a lane runs no further, having used up its steps or not."""
    spent = mark(k[STEPS, i]) >= mark(k[STEP_LIMIT, i]) and mark(k[MODE, i]) < OVERTURNED
    k[MODE, i] = wp.where(spent, STALLED, mark(k[MODE, i]))
    return mark(k[MODE, i]) >= OVERTURNED


@wp.func(inline=True)
def result_of(m: wp.ref[Numbers], k: wp.ref[Marks], i: int) -> Result:
    """What the run of a lane leaves behind."""
    return Result(
        at(m[UPLIFT_TIME, i]), at(m[REST_TIME, i]), at(m[LOSS, i]), at(m[NEEDED, i]),
        mark(k[IMPACTS, i]), mark(k[MODE, i]), mark(k[STEPS, i]),
    )  # fmt: skip


@wp.func(inline=True)
def block_result_of(m: wp.ref[Numbers], i: int) -> BlockResult:
    """What that of its block does."""
    return BlockResult(at(m[PEAK, i]), at(m[PEAK_TIME, i]))
