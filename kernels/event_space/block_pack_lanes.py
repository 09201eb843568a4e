"""What is kept of the lanes of a pack, side by side.

One matrix of real and one of whole numbers, a row for each number of a lane. A func that is not
inlined must not take them: the compiler could no longer tell that nothing else points at them, and
would make no vector code.
"""

import warp as wp

from warprock.kernels.event_space.block_pack import Hinge
from warprock.kernels.event_space.block_run import Seen
from warprock.kernels.event_space.block_trial import State
from warprock.kernels.shape_space.block import Block
from warprock.kernels.shape_space.block_found import BlockResult
from warprock.kernels.vectors import Quaternion, Vector

X, Q, V, W, TURN, Q0, W0, BASE = 0, 3, 7, 10, 13, 16, 20, 23
LEVER, MOBILITY, MIXED, WAY, OPEN = 26, 29, 32, 35, 38
TIME, TIME0, CAP, LOST, DEEPEST, UNTIL, UPLIFT, REST = 41, 42, 43, 44, 45, 46, 47, 48
PEAK, PEAK_TIME, ACROSS, TILT, YAW, SLIDE_X, SLIDE_Y, SLIDE = 49, 50, 51, 52, 53, 54, 55, 56
LONGEST, REST_GAP, WIDTH, DEPTH, HEIGHT, CENTRE_X, CENTRE_Y = 57, 58, 59, 60, 61, 62, 63
INVERSE, FRICTION, FLAT_X, FLAT_Y, FLAT_C, FLAT_S, QZ, QW = 64, 67, 68, 69, 70, 71, 72, 73
OVER, INERTIA, X0, V0 = 74, 75, 78, 81
ROWS = 84
"""Rows of real numbers, the first of several where they are a vector: of the state and, ending in
0, of the one before the last step; of the hinge; of what is seen; of limits and block. UNTIL is the
time of the next sample."""

STANCE, SLIP, MODE, KNOTS, IMPACTS, STEPS, STANCE0 = 0, 1, 2, 3, 6, 7, 8
LANE, SAMPLE, STEP_LIMIT, DUE, BUSY = 9, 10, 11, 12, 13
MARKS = 14
"""Rows of whole numbers: of the state; the number of the lane and of its next sample. DUE marks a
lane that needs to be looked at by itself, BUSY one that needs a step by itself."""

Numbers = wp.types.matrix(shape=(ROWS, LANES), dtype=real)
Marks = wp.types.matrix(shape=(MARKS, LANES), dtype=int)


@wp.func(inline=True)
def at(entry: wp.ref[real]) -> real:
    """An entry of a matrix, which is copied as a whole if it is read without this."""
    return entry


@wp.func(inline=True)
def mark(entry: wp.ref[int]) -> int:
    """As `at`, of whole numbers."""
    return entry


@wp.func(inline=True)
def three(m: wp.ref[Numbers], row: int, i: int) -> Vector:
    """Vector, as rows of a lane."""
    return Vector(at(m[row, i]), at(m[row + 1, i]), at(m[row + 2, i]))


@wp.func(inline=True)
def four(m: wp.ref[Numbers], row: int, i: int) -> Quaternion:
    """Attitude, as rows of a lane."""
    return Quaternion(at(m[row, i]), at(m[row + 1, i]), at(m[row + 2, i]), at(m[row + 3, i]))


@wp.func(inline=True)
def put(m: wp.ref[Numbers], row: int, i: int, ok: bool, value: real):
    """Puts a number of a lane where `ok` says so."""
    m[row, i] = wp.where(ok, value, at(m[row, i]))


@wp.func(inline=True)
def put_three(m: wp.ref[Numbers], row: int, i: int, ok: bool, v: Vector):
    """Puts three rows of a lane where `ok` says so."""
    put(m, row, i, ok, v[0])
    put(m, row + 1, i, ok, v[1])
    put(m, row + 2, i, ok, v[2])


@wp.func(inline=True)
def put_four(m: wp.ref[Numbers], row: int, i: int, ok: bool, v: Quaternion):
    """Puts four rows of a lane where `ok` says so."""
    put(m, row, i, ok, v[0])
    put(m, row + 1, i, ok, v[1])
    put(m, row + 2, i, ok, v[2])
    put(m, row + 3, i, ok, v[3])


@wp.func(inline=True)
def put_mark(k: wp.ref[Marks], row: int, i: int, ok: bool, value: int):
    """Puts a whole number of a lane where `ok` says so."""
    k[row, i] = wp.where(ok, value, mark(k[row, i]))


@wp.func(inline=True)
def state_of(m: wp.ref[Numbers], k: wp.ref[Marks], i: int) -> State:
    """The state of a lane."""
    s = State()
    s.x = three(m, X, i)
    s.q = four(m, Q, i)
    s.v = three(m, V, i)
    s.w = three(m, W, i)
    s.turn = three(m, TURN, i)
    s.stance = mark(k[STANCE, i])
    s.slip = mark(k[SLIP, i])
    s.time = at(m[TIME, i])
    s.knots[0] = mark(k[KNOTS, i])
    s.knots[1] = mark(k[KNOTS + 1, i])
    s.knots[2] = mark(k[KNOTS + 2, i])
    s.base = three(m, BASE, i)
    s.cap = at(m[CAP, i])
    s.mode = mark(k[MODE, i])
    s.lost = at(m[LOST, i])
    s.deepest = at(m[DEEPEST, i])
    s.impacts = mark(k[IMPACTS, i])
    s.taken = True
    return s


@wp.func(inline=True)
def keep(s: State, m: wp.ref[Numbers], k: wp.ref[Marks], i: int):
    """Keeps the state of a lane."""
    put_three(m, X, i, True, s.x)
    put_four(m, Q, i, True, s.q)
    put_three(m, V, i, True, s.v)
    put_three(m, W, i, True, s.w)
    put_three(m, TURN, i, True, s.turn)
    k[STANCE, i] = s.stance
    k[SLIP, i] = s.slip
    m[TIME, i] = s.time
    k[KNOTS, i] = s.knots[0]
    k[KNOTS + 1, i] = s.knots[1]
    k[KNOTS + 2, i] = s.knots[2]
    put_three(m, BASE, i, True, s.base)
    m[CAP, i] = s.cap
    k[MODE, i] = s.mode
    m[LOST, i] = s.lost
    m[DEEPEST, i] = s.deepest
    k[IMPACTS, i] = s.impacts


@wp.func(inline=True)
def before_of(m: wp.ref[Numbers], k: wp.ref[Marks], i: int) -> State:
    """What is kept of the state before the last step that was taken."""
    s = State()
    s.x = three(m, X0, i)
    s.q = four(m, Q0, i)
    s.v = three(m, V0, i)
    s.w = three(m, W0, i)
    s.time = at(m[TIME0, i])
    s.stance = mark(k[STANCE0, i])
    return s


@wp.func(inline=True)
def keep_before(s: State, ok: bool, m: wp.ref[Numbers], k: wp.ref[Marks], i: int):
    """Keeps that, where `ok` says so."""
    put_three(m, X0, i, ok, s.x)
    put_four(m, Q0, i, ok, s.q)
    put_three(m, V0, i, ok, s.v)
    put_three(m, W0, i, ok, s.w)
    put(m, TIME0, i, ok, s.time)
    put_mark(k, STANCE0, i, ok, s.stance)


@wp.func(inline=True)
def hinge_at(m: wp.ref[Numbers], i: int) -> Hinge:
    """The hinge of a lane."""
    h = Hinge()
    h.lever = three(m, LEVER, i)
    h.mobility = three(m, MOBILITY, i)
    h.mixed = three(m, MIXED, i)
    h.way = three(m, WAY, i)
    h.over = at(m[OVER, i])
    h.open = three(m, OPEN, i)
    return h


@wp.func(inline=True)
def keep_hinge(h: Hinge, m: wp.ref[Numbers], i: int):
    """Keeps the hinge of a lane."""
    put_three(m, LEVER, i, True, h.lever)
    put_three(m, MOBILITY, i, True, h.mobility)
    put_three(m, MIXED, i, True, h.mixed)
    put_three(m, WAY, i, True, h.way)
    m[OVER, i] = h.over
    put_three(m, OPEN, i, True, h.open)


@wp.func(inline=True)
def seen_of(m: wp.ref[Numbers], i: int) -> Seen:
    """What has been seen of a lane."""
    seen = Seen()
    seen.leaf.slide_x = at(m[SLIDE_X, i])
    seen.leaf.slide_y = at(m[SLIDE_Y, i])
    seen.leaf.peak = at(m[PEAK, i])
    seen.leaf.peak_time = at(m[PEAK_TIME, i])
    seen.leaf.peak_across = at(m[ACROSS, i])
    seen.leaf.peak_tilt = at(m[TILT, i])
    seen.leaf.peak_yaw = at(m[YAW, i])
    seen.leaf.peak_slide = at(m[SLIDE, i])
    seen.uplift_time = at(m[UPLIFT, i])
    seen.rest_time = at(m[REST, i])
    return seen


@wp.func(inline=True)
def keep_leaf(leaf: BlockResult, ok: bool, m: wp.ref[Numbers], i: int):
    """Keeps what has been seen of the block of a lane, where `ok` says so."""
    put(m, SLIDE_X, i, ok, leaf.slide_x)
    put(m, SLIDE_Y, i, ok, leaf.slide_y)
    put(m, PEAK, i, ok, leaf.peak)
    put(m, PEAK_TIME, i, ok, leaf.peak_time)
    put(m, ACROSS, i, ok, leaf.peak_across)
    put(m, TILT, i, ok, leaf.peak_tilt)
    put(m, YAW, i, ok, leaf.peak_yaw)
    put(m, SLIDE, i, ok, leaf.peak_slide)


@wp.func(inline=True)
def keep_seen(seen: Seen, m: wp.ref[Numbers], i: int):
    """Keeps what has been seen of a lane."""
    keep_leaf(seen.leaf, True, m, i)
    m[UPLIFT, i] = seen.uplift_time
    m[REST, i] = seen.rest_time


@wp.func(inline=True)
def block_at(m: wp.ref[Numbers], i: int) -> Block:
    """The block of a lane, but for its mass and where it starts."""
    b = Block()
    b.half_width = at(m[WIDTH, i])
    b.half_depth = at(m[DEPTH, i])
    b.half_height = at(m[HEIGHT, i])
    b.centre_x = at(m[CENTRE_X, i])
    b.centre_y = at(m[CENTRE_Y, i])
    b.inverse_x = at(m[INVERSE, i])
    b.inverse_y = at(m[INVERSE + 1, i])
    b.inverse_z = at(m[INVERSE + 2, i])
    b.friction = at(m[FRICTION, i])
    b.flat_x = at(m[FLAT_X, i])
    b.flat_y = at(m[FLAT_Y, i])
    b.flat_c = at(m[FLAT_C, i])
    b.flat_s = at(m[FLAT_S, i])
    b.qz = at(m[QZ, i])
    b.qw = at(m[QW, i])
    return b


@wp.func(inline=True)
def keep_block(b: Block, m: wp.ref[Numbers], i: int):
    """Keeps that of a lane's block."""
    m[WIDTH, i] = b.half_width
    m[DEPTH, i] = b.half_depth
    m[HEIGHT, i] = b.half_height
    m[CENTRE_X, i] = b.centre_x
    m[CENTRE_Y, i] = b.centre_y
    m[INVERSE, i] = b.inverse_x
    m[INVERSE + 1, i] = b.inverse_y
    m[INVERSE + 2, i] = b.inverse_z
    m[INERTIA, i] = real(1.0) / b.inverse_x
    m[INERTIA + 1, i] = real(1.0) / b.inverse_y
    m[INERTIA + 2, i] = real(1.0) / b.inverse_z
    m[FRICTION, i] = b.friction
    m[FLAT_X, i] = b.flat_x
    m[FLAT_Y, i] = b.flat_y
    m[FLAT_C, i] = b.flat_c
    m[FLAT_S, i] = b.flat_s
    m[QZ, i] = b.qz
    m[QW, i] = b.qw
