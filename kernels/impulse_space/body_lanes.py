"""What is kept of LANES bodies on points side by side, and the step of one of them.

One matrix of real numbers of lanes, one of points and one of whole numbers; a row for each number
of a lane. The funcs hand the entries to those of impulse_space/body.py, body_hold.py and
block.py. They are written out where they are called: the compiler could not tell otherwise that
nothing else points at the matrices, and would make no vector code.
"""

import warp as wp

from warprock.kernels.impulse_space.block import Knobs, integrate, solve_contact, warm_start
from warprock.kernels.impulse_space.block_seen import observe_contacts
from warprock.kernels.impulse_space.body import (
    find_contact,
    find_point,
    glides,
    observe_body,
    predict,
    start_body,
    start_point,
    tell_stance,
)
from warprock.kernels.impulse_space.body_hold import (
    add_held,
    add_pressure,
    find_motion,
    find_turn,
    judge,
    keep,
    share,
    take,
)
from warprock.kernels.impulse_space.bounce import calm
from warprock.kernels.modes import RUNNING
from warprock.kernels.shape_space.block import Block
from warprock.kernels.shape_space.body import MOST_POINTS, Frame, Point, throw_of
from warprock.kernels.shape_space.thrown import tumble_on

X, Y, Z, QX, QY, QZ, QW, VX, VY, VZ, LX, LY, LZ, UX = 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13
UY, UZ, OX, OY, OZ, R11, R12, R13, R21, R22, R23 = 14, 15, 16, 17, 18, 19, 20, 21, 22, 23, 24
R31, R32, R33, JXX, JXY, JXZ, JYY, JYZ, JZZ, IX, IY = 25, 26, 27, 28, 29, 30, 31, 32, 33, 34, 35
IZ, MU, LOWEST, DEEPEST, LANDED, LIFTED, SINCE, LOSS, MOVED = 36, 37, 38, 39, 40, 41, 42, 43, 44
SLIDE_X, SLIDE_Y, PEAK, PEAK_TIME, PEAK_ACROSS, PEAK_TILT, PEAK_YAW = 45, 46, 47, 48, 49, 50, 51
PEAK_SLIDE, UPLIFT_TIME, TOUCHING, WAY_X, WAY_Y, COUNT, MX, MY = 52, 53, 54, 55, 56, 57, 58, 59
MZ, XX, XY, YY, ZX, ZY, T, TX, TY, WX, WY, WZ = 60, 61, 62, 63, 64, 65, 66, 67, 68, 69, 70, 71
SX, SY, SZ, EX, EY, EZ, GZ, PUSH, BX, BY, CX, CY = 72, 73, 74, 75, 76, 77, 78, 79, 80, 81, 82, 83
TURN, GOOD, BASE, DV, FARTHEST = 84, 85, 86, 89, 92
NUMBERS = 93
"""Rows of real numbers of a lane; BASE and DV are vectors."""

ROWS = MOST_POINTS + 1
"""Rows of points: an even number would put the same point of all numbers in the same places of the
processor's cache, ten times slower."""
PX, PY, PZ, STOOD_X, STOOD_Y, FOOT = 0 * ROWS, 1 * ROWS, 2 * ROWS, 3 * ROWS, 4 * ROWS, 5 * ROWS
RX, RY, RZ, AIM, ON, HELD = 6 * ROWS, 7 * ROWS, 8 * ROWS, 9 * ROWS, 10 * ROWS, 11 * ROWS
APART, FX, FY, N, KX, KY = 12 * ROWS, 13 * ROWS, 14 * ROWS, 15 * ROWS, 16 * ROWS, 17 * ROWS
PN, P1, P2, P3, H11, H12 = 18 * ROWS, 19 * ROWS, 20 * ROWS, 21 * ROWS, 22 * ROWS, 23 * ROWS
H13, H22, H23, H33, GX, GY = 24 * ROWS, 25 * ROWS, 26 * ROWS, 27 * ROWS, 28 * ROWS, 29 * ROWS
GN = 30 * ROWS
POINT_NUMBERS = 31 * ROWS
"""First rows of numbers of points."""

IMPACTS, MODE, STEPS = 0, 1, 2
MARKS = 3
"""Rows of whole numbers."""

Numbers = wp.types.matrix(shape=(NUMBERS, LANES), dtype=real)
Points = wp.types.matrix(shape=(POINT_NUMBERS, LANES), dtype=real)
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
def start_lane(
    block: Block, frame: Frame, knobs: Knobs, m: wp.ref[Numbers], k: wp.ref[Marks], i: int,
):  # fmt: skip
    """Puts a body where it starts."""
    start_body(
        block, frame, knobs, m[MU, i], m[IX, i], m[IY, i], m[IZ, i], m[X, i], m[Y, i], m[Z, i],
        m[QX, i], m[QY, i], m[QZ, i], m[QW, i], m[VX, i], m[VY, i], m[VZ, i], m[LX, i], m[LY, i],
        m[LZ, i], m[UPLIFT_TIME, i], k[MODE, i], m[PEAK, i], m[PEAK_ACROSS, i], m[PEAK_TILT, i],
    )  # fmt: skip


@wp.func(inline=True)
def start_point_of_lane(
    point: Point, frame: Frame, knobs: Knobs, p: wp.ref[Points], c: int, i: int,
):  # fmt: skip
    """Copies a point, see `start_point`."""
    start_point(
        point, knobs, frame, p[PX + c, i], p[PY + c, i], p[PZ + c, i], p[STOOD_X + c, i],
        p[STOOD_Y + c, i], p[FOOT + c, i], p[N + c, i], p[APART + c, i],
    )  # fmt: skip


@wp.func(inline=True)
def predict_lane(knobs: Knobs, m: wp.ref[Numbers], i: int):
    """Velocities of a body without contact."""
    predict(
        at(m[DV + 0, i]), at(m[DV + 1, i]), at(m[DV + 2, i]), knobs, at(m[QX, i]), at(m[QY, i]),
        at(m[QZ, i]), at(m[QW, i]), at(m[LX, i]), at(m[LY, i]), at(m[LZ, i]), at(m[IX, i]),
        at(m[IY, i]), at(m[IZ, i]), at(m[VX, i]), at(m[VY, i]), at(m[VZ, i]), m[R11, i], m[R12, i],
        m[R13, i], m[R21, i], m[R22, i], m[R23, i], m[R31, i], m[R32, i], m[R33, i], m[JXX, i],
        m[JXY, i], m[JXZ, i], m[JYY, i], m[JYZ, i], m[JZZ, i], m[UX, i], m[UY, i], m[UZ, i],
        m[OX, i], m[OY, i], m[OZ, i], m[LOWEST, i], m[LIFTED, i], m[LANDED, i],
    )  # fmt: skip


@wp.func(inline=True)
def find_point_of_lane(m: wp.ref[Numbers], p: wp.ref[Points], c: int, i: int):
    """Lever of a point."""
    find_point(
        at(p[FOOT + c, i]) >= real(0.0), at(p[PX + c, i]), at(p[PY + c, i]), at(p[PZ + c, i]),
        at(m[Z, i]), at(m[R11, i]), at(m[R12, i]), at(m[R13, i]), at(m[R21, i]), at(m[R22, i]),
        at(m[R23, i]), at(m[R31, i]), at(m[R32, i]), at(m[R33, i]), p[RX + c, i], p[RY + c, i],
        p[RZ + c, i], m[LOWEST, i],
    )  # fmt: skip


@wp.func(inline=True)
def find_contact_of_lane(
    block: Block, frame: Frame, knobs: Knobs, m: wp.ref[Numbers], p: wp.ref[Points], c: int, i:
    int,
):  # fmt: skip
    """Whether a point is a contact."""
    find_contact(
        knobs, at(p[FOOT + c, i]), frame.reach, block.half_width, at(m[LOWEST, i]), at(m[X, i]),
        at(m[Y, i]), at(m[Z, i]), at(p[RX + c, i]), at(p[RY + c, i]), at(p[RZ + c, i]),
        at(p[STOOD_X + c, i]), at(p[STOOD_Y + c, i]), at(m[UZ, i]), at(m[OX, i]), at(m[OY, i]),
        at(m[OZ, i]), p[AIM + c, i], p[ON + c, i], p[HELD + c, i], p[FX + c, i], p[FY + c, i],
        p[N + c, i], p[APART + c, i], m[LIFTED, i], m[LANDED, i], m[COUNT, i], m[MX, i], m[MY, i],
        m[XX, i], m[XY, i], m[YY, i], m[TOUCHING, i], m[WAY_X, i], m[WAY_Y, i],
    )  # fmt: skip


@wp.func(inline=True)
def tell_stance_of_lane(before: real, m: wp.ref[Numbers], k: wp.ref[Marks], i: int):
    """What the points tell of the pose."""
    tell_stance(
        mark(k[MODE, i]) == RUNNING, before, m[COUNT, i], m[MX, i], m[MY, i], m[XX, i], m[XY, i],
        m[YY, i], m[LIFTED, i], m[SINCE, i], m[TOUCHING, i], m[WAY_X, i], m[WAY_Y, i],
        m[SLIDE_X, i], m[SLIDE_Y, i], m[PEAK_SLIDE, i],
    )  # fmt: skip


@wp.func(inline=True)
def add_held_of_lane(m: wp.ref[Numbers], p: wp.ref[Points], c: int, i: int):
    """Adds a held point to the sums."""
    add_held(
        at(p[HELD + c, i]), at(p[RX + c, i]), at(p[RY + c, i]), at(p[RZ + c, i]), at(p[AIM + c, i]),
        m[COUNT, i], m[MX, i], m[MY, i], m[MZ, i], m[XX, i], m[XY, i], m[YY, i], m[ZX, i], m[ZY, i],
        m[T, i], m[TX, i], m[TY, i],
    )  # fmt: skip


@wp.func(inline=True)
def find_motion_of_lane(frame: Frame, m: wp.ref[Numbers], i: int):
    """Motion of a body whose held points are stopped."""
    find_motion(
        frame.reach, at(m[UX, i]), at(m[UY, i]), at(m[UZ, i]), at(m[OX, i]), at(m[OY, i]),
        at(m[OZ, i]), at(m[LX, i]), at(m[LY, i]), at(m[LZ, i]), at(m[R11, i]), at(m[R12, i]),
        at(m[R13, i]), at(m[R21, i]), at(m[R22, i]), at(m[R23, i]), at(m[R31, i]), at(m[R32, i]),
        at(m[R33, i]), at(m[IX, i]), at(m[IY, i]), at(m[IZ, i]), m[COUNT, i], m[MX, i], m[MY, i],
        m[MZ, i], m[XX, i], m[XY, i], m[YY, i], m[ZX, i], m[ZY, i], m[T, i], m[TX, i], m[TY, i],
        m[WX, i], m[WY, i], m[WZ, i], m[SX, i], m[SY, i], m[SZ, i], m[EX, i], m[EY, i], m[EZ, i],
        m[GZ, i], m[PUSH, i], m[BX, i], m[BY, i],
    )  # fmt: skip
    m[GOOD, i] = real(1.0)


@wp.func(inline=True)
def judge_lane(knobs: Knobs, m: wp.ref[Numbers], p: wp.ref[Points], c: int, i: int):
    """Lets a point go, or holds it."""
    judge(
        knobs, at(p[ON + c, i]), at(p[AIM + c, i]), at(p[RX + c, i]), at(p[RY + c, i]),
        at(m[MX, i]), at(m[MY, i]), at(m[WZ, i]), at(m[SX, i]), at(m[SY, i]), at(m[PUSH, i]),
        at(m[BX, i]), at(m[BY, i]), p[HELD + c, i], m[GOOD, i],
    )  # fmt: skip


@wp.func(inline=True)
def clear_middle(m: wp.ref[Numbers], i: int):
    """Makes the sums that became the middle of the held points zero."""
    m[MX, i] = real(0.0)
    m[MY, i] = real(0.0)
    m[MZ, i] = real(0.0)


@wp.func(inline=True)
def add_pressure_of_lane(m: wp.ref[Numbers], p: wp.ref[Points], c: int, i: int):
    """Adds a point to the moments of the normal impulses."""
    add_pressure(
        at(p[HELD + c, i]), at(p[RX + c, i]), at(p[RY + c, i]), at(m[MX, i]), at(m[MY, i]),
        at(m[PUSH, i]), at(m[BX, i]), at(m[BY, i]), m[CX, i], m[CY, i], m[TURN, i],
    )  # fmt: skip


@wp.func(inline=True)
def find_turn_of_lane(m: wp.ref[Numbers], i: int):
    """The turn of the friction about the centre of pressure."""
    find_turn(
        at(m[EX, i]), at(m[EY, i]), at(m[EZ, i]), at(m[GZ, i]), at(m[MX, i]), at(m[MY, i]),
        m[CX, i], m[CY, i], m[TURN, i],
    )  # fmt: skip


@wp.func(inline=True)
def share_lane(knobs: Knobs, m: wp.ref[Numbers], p: wp.ref[Points], c: int, i: int):
    """Impulse of a point, and whether it obeys the law."""
    share(
        knobs, at(m[MU, i]), at(p[ON + c, i]), at(p[HELD + c, i]), at(p[AIM + c, i]),
        at(p[RX + c, i]), at(p[RY + c, i]), at(m[MX, i]), at(m[MY, i]), at(m[PUSH, i]),
        at(m[BX, i]), at(m[BY, i]), at(m[EX, i]), at(m[EY, i]), at(m[EZ, i]), at(m[CX, i]),
        at(m[CY, i]), at(m[TURN, i]), at(m[WZ, i]), at(m[SX, i]), at(m[SY, i]), p[GX + c, i],
        p[GY + c, i], p[GN + c, i], m[GOOD, i],
    )  # fmt: skip


@wp.func(inline=True)
def keep_lane(m: wp.ref[Numbers], i: int):
    """Writes the velocities of a body that is held."""
    keep(
        at(m[GOOD, i]) > real(0.0), at(m[WX, i]), at(m[WY, i]), at(m[WZ, i]), at(m[SX, i]),
        at(m[SY, i]), at(m[SZ, i]), m[UX, i], m[UY, i], m[UZ, i], m[OX, i], m[OY, i], m[OZ, i],
        m[MX, i], m[MY, i], m[MZ, i], m[CX, i], m[CY, i], m[TURN, i],
    )  # fmt: skip


@wp.func(inline=True)
def take_lane(m: wp.ref[Numbers], p: wp.ref[Points], c: int, i: int):
    """Writes the impulse of a point where its body is held."""
    take(
        at(m[GOOD, i]) > real(0.0), at(p[GX + c, i]), at(p[GY + c, i]), at(p[GN + c, i]),
        p[FX + c, i], p[FY + c, i], p[N + c, i], p[ON + c, i],
    )  # fmt: skip


@wp.func(inline=True)
def warm_start_lane(m: wp.ref[Numbers], p: wp.ref[Points], c: int, i: int):
    """Starts a contact from its last impulses."""
    warm_start(
        at(p[ON + c, i]), at(p[RX + c, i]), at(p[RY + c, i]), at(p[RZ + c, i]), at(p[FX + c, i]),
        at(p[FY + c, i]), at(p[N + c, i]), at(m[JXX, i]), at(m[JXY, i]), at(m[JXZ, i]),
        at(m[JYY, i]), at(m[JYZ, i]), at(m[JZZ, i]), p[KX + c, i], p[KY + c, i], p[PN + c, i],
        p[P1 + c, i], p[P2 + c, i], p[P3 + c, i], p[H11 + c, i], p[H12 + c, i], p[H13 + c, i],
        p[H22 + c, i], p[H23 + c, i], p[H33 + c, i], m[UX, i], m[UY, i], m[UZ, i], m[OX, i],
        m[OY, i], m[OZ, i],
    )  # fmt: skip


@wp.func(inline=True)
def solve_lane(m: wp.ref[Numbers], p: wp.ref[Points], c: int, i: int):
    """Gauss-Seidel on the impulses of a contact."""
    solve_contact(
        at(m[MU, i]), at(p[AIM + c, i]), at(p[RX + c, i]), at(p[RY + c, i]), at(p[RZ + c, i]),
        at(m[JXX, i]), at(m[JXY, i]), at(m[JXZ, i]), at(m[JYY, i]), at(m[JYZ, i]), at(m[JZZ, i]),
        at(p[KX + c, i]), at(p[KY + c, i]), at(p[PN + c, i]), at(p[P1 + c, i]), at(p[P2 + c, i]),
        at(p[P3 + c, i]), at(p[H11 + c, i]), at(p[H12 + c, i]), at(p[H13 + c, i]),
        at(p[H22 + c, i]), at(p[H23 + c, i]), at(p[H33 + c, i]), p[FX + c, i], p[FY + c, i],
        p[N + c, i], m[UX, i], m[UY, i], m[UZ, i], m[OX, i], m[OY, i], m[OZ, i],
    )  # fmt: skip


@wp.func(inline=True)
def integrate_lane(
    block: Block, frame: Frame, knobs: Knobs, time: real, m: wp.ref[Numbers], k: wp.ref[Marks],
    i: int,
):  # fmt: skip
    """Moves a body by a step, and looks at it."""
    live = mark(k[MODE, i]) == RUNNING
    calm(
        knobs, at(m[DV + 0, i]), at(m[DV + 1, i]), at(m[DV + 2, i]), at(m[QX, i]), at(m[QY, i]),
        at(m[QZ, i]), at(m[QW, i]), at(m[IX, i]), at(m[IY, i]), at(m[IZ, i]), at(m[VX, i]),
        at(m[VY, i]), at(m[VZ, i]), at(m[LX, i]), at(m[LY, i]), at(m[LZ, i]), m[UX, i], m[UY, i],
        m[UZ, i], m[OX, i], m[OY, i], m[OZ, i],
    )  # fmt: skip
    integrate(
        live, knobs, at(m[IX, i]), at(m[IY, i]), at(m[IZ, i]), at(m[DV + 0, i]), at(m[DV + 1, i]),
        at(m[DV + 2, i]), at(m[UX, i]), at(m[UY, i]), at(m[UZ, i]), at(m[OX, i]), at(m[OY, i]),
        at(m[OZ, i]), at(m[LOWEST, i]), m[X, i], m[Y, i], m[Z, i], m[QX, i], m[QY, i], m[QZ, i],
        m[QW, i], m[VX, i], m[VY, i], m[VZ, i], m[LX, i], m[LY, i], m[LZ, i], m[LOSS, i],
    )  # fmt: skip
    slides = glides(
        frame, knobs, at(m[Z, i]), at(m[UX, i]), at(m[UY, i]), at(m[OX, i]), at(m[OY, i]),
        at(m[OZ, i]),
    )  # fmt: skip
    observe_contacts(
        live, time, at(m[LANDED, i]), at(m[LOWEST, i]), at(m[LIFTED, i]), slides, at(m[SINCE, i]),
        m[UPLIFT_TIME, i], m[MOVED, i], m[DEEPEST, i], k[IMPACTS, i], k[STEPS, i],
    )  # fmt: skip
    observe_body(
        live, time, block, frame, at(m[X, i]) + at(m[Y, i]) + at(m[Z, i]) + at(m[VX, i]) +
        at(m[VY, i]) + at(m[VZ, i]) + at(m[LX, i]) + at(m[LY, i]) + at(m[LZ, i]), at(m[QX, i]),
        at(m[QY, i]), at(m[QZ, i]), at(m[QW, i]), m[PEAK, i], m[PEAK_TIME, i], m[PEAK_ACROSS, i],
        m[PEAK_TILT, i], m[PEAK_YAW, i], k[MODE, i],
    )  # fmt: skip
    tumble_on(
        throw_of(frame), block, at(m[X, i]), at(m[Y, i]), k[MODE, i], m[SLIDE_X, i],
        m[SLIDE_Y, i], m[PEAK_SLIDE, i], m[FARTHEST, i],
    )  # fmt: skip
