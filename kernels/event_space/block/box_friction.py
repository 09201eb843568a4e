"""The contact law of one block in space with friction as a box along x and y.

At a corner |p_x| and |p_y| are at most friction n. If it slides along x, |p_x| is friction n, and
p_x is against the slip; likewise along y. Bit k of `slip` says that corner k slides along x, bit
4 + k that it slides along y. States are tried in this order:

    1. all touching corners stick (event_space/block/contact.py); if some slide already, an edge or
       a corner keeps its state along x and along y;
    2. the face or an edge sticks, except for corners that slide already;
    3. a flat block slides, with the normal impulses spread as if it stuck;
    4. no contact pushes;
    5. an edge, else a corner, takes each combination of sticking and sliding to either side, along
       x and y of each end (event_space/block/box_friction_slide.py). Both ends of an edge alike
       come first, then a corner that sticks.

If exactly one end of an edge would sink without contact, that corner is tried before 2, see
event_space/block/contact.py.

Steps end where the slip of a corner along x or y ends, which keeps the order at 2. Other changes
at the ends of a sliding edge are not located. So the errors of blocks that rock and slide scatter:
their mean over eight blocks falls with the step to the power 1.4 to 2.
"""

import warp as wp

from warprock.kernels.algebra.vectors import Vector
from warprock.kernels.event.block.begin import first_root
from warprock.kernels.event_space.block.box_friction_slide import (
    apply_impulses,
    ends_of,
    gains_of,
    side_of,
    solve_corners,
    solve_flat_friction,
    try_flat_sliding,
    try_sides,
)
from warprock.kernels.event_space.block.contact import (
    ALL,
    EDGE,
    FLAT,
    FLYING,
    Body,
    Corners,
    Held,
    corner_velocity,
    mask_of,
    sinks,
    stick,
    try_sticking,
    try_sticking_end,
)
from warprock.kernels.event_space.block.moves import Course
from warprock.kernels.event_space.lane import Limits

WAYS = 9
"""States of one end: sticks or slides to either side along x (3), times the same along y (3)."""
LOOSELY = by_precision(1.0e6, 10.0)
"""Multiple of round-off by which the last candidate may break the law."""


@wp.func
def directions(body: Body, v: Vector, w: Vector) -> Corners:
    """Sides, -1 or 1, to which the corners move along x and y; 0 where they do not."""
    dirs = Corners()
    for k in range(4):
        u = corner_velocity(body, v, w, k)
        dirs[k] = Vector(side_of(u[0]), side_of(u[1]), real(0.0))
    return dirs


@wp.func
def kept_sides(slip: int, dirs: Corners) -> Corners:
    """Sides to which corners already slide along x and y; 0 where they stick."""
    sides = Corners()
    for k in range(4):
        sides[k, 0] = wp.where((slip & (1 << k)) != 0, dirs[k, 0], real(0.0))
        sides[k, 1] = wp.where((slip & (16 << k)) != 0, dirs[k, 1], real(0.0))
    return sides


@wp.func(inline=False)
def solve_as_before(
    body: Body, stance: int, slip: int, start: Corners, v: Vector, w: Vector, dust: real
) -> Held:
    """The motion if all contacts keep their state; `fits` says whether it obeys the law.

    It never fits for a flat block that slides.
    """
    mask = mask_of(stance)
    h = Held()
    if stance != FLYING and slip == 0:
        h = try_sticking(body, stance, mask, v, w, dust)
    elif stance < FLAT:
        i, j = ends_of(stance)
        h = try_sides(body, stance, mask, gains_of(body, i, j), kept_sides(slip, start), v, w, dust)
    return h


@wp.func(inline=False)
def solve_any_corner(body: Body, mask: int, v: Vector, w: Vector, dust: real) -> Held:
    """The motion if an edge or a corner carries, in any state; `fits` says if it obeys the law.

    Both ends of an edge alike come first, then a corner that sticks, then all other states.
    """
    best = Held()
    for turn in range(2):
        for number in range(FLAT):
            c = FLAT - 1 - number
            part = mask_of(c)
            i, j = ends_of(c)
            if not best.fits and (part & mask) == part:
                gains = gains_of(body, i, j)
                for way in range(wp.where(c >= EDGE, WAYS * WAYS, WAYS)):
                    alike = way % (WAYS + 1) == 0
                    if not best.fits and alike == (turn == 0):
                        sides = Corners()
                        sides[j] = side_of_way(way // WAYS)
                        sides[i] = side_of_way(way % WAYS)
                        best = try_sides(body, c, mask, gains, sides, v, w, dust)
    return best


@wp.func
def side_of_way(number: int) -> Vector:
    """One of the nine states of an end as sides along x and y; number 0 sticks along both."""
    x, y = number % 3, number // 3
    return Vector(real(x - 3 * (x // 2)), real(y - 3 * (y // 2)), real(0.0))


@wp.func(inline=False)
def solve(
    body: Body, stance: int, slip: int, start: Corners, v: Vector, w: Vector, dust: real
) -> Held:
    """The motion that obeys the contact law; see `solve` in event_space/block/law.py."""
    mask = mask_of(stance)
    slides = (slip | (slip >> 4)) & ALL
    first = solve_as_before(body, stance, slip, start, v, w, dust)
    best = first
    if not best.fits and stance >= EDGE and stance < FLAT and slip == 0:
        best = try_sticking_end(body, stance, v, w, dust)
    for number in range(FLAT - EDGE + 1):
        c = FLAT - number
        part = mask_of(c)
        if not best.fits and c != stance and (part & mask) == part and (part & slides) == 0:
            best = try_sticking(body, c, mask, v, w, dust)
    if not best.fits and stance == FLAT:
        best = try_flat_sliding(body, v, w, dust)
    if not best.fits:
        best = Held()
        best.v = v
        best.w = w
        best.stance = FLYING
        best.fits = not sinks(body, v, w, mask, real(0.0))
    if not best.fits:
        best = solve_any_corner(body, mask, v, w, dust)
    if not best.fits:
        best = solve_any_corner(body, mask, v, w, LOOSELY * dust)
    best.turns = first.turns
    best.spare = first.spare
    return best


@wp.func(inline=False)
def project(body: Body, stance: int, slip: int, v: Vector, w: Vector):
    """Velocities projected on the contacts, along their force."""
    v_after = v
    w_after = w
    dirs = directions(body, v, w)
    if stance != FLYING and slip == 0:
        v_after, w_after = stick(body, stance, v, w)
    elif stance == FLAT:
        most = Corners()
        enough = TWO * (wp.length(v) + size(w[2]) * wp.length(body.corners[0]))
        for k in range(4):
            x = wp.where((slip & (1 << k)) != 0, real(0.0), enough)
            y = wp.where((slip & (16 << k)) != 0, real(0.0), enough)
            most[k] = Vector(x, y, real(0.0))
        z, _f = solve_flat_friction(body, most, Vector(v[0], v[1], w[2]))
        v_after = Vector(z[0], z[1], real(0.0))
        w_after = Vector(real(0.0), real(0.0), z[2])
    elif stance < FLAT:
        i, j = ends_of(stance)
        v_after, w_after = apply_impulses(
            body, i, j,
            solve_corners(body, i, j, gains_of(body, i, j), kept_sides(slip, dirs), True, v, w),
            v, w,
        )  # fmt: skip
    return v_after, w_after


@wp.func
def sliding_bits(mask: int) -> int:
    """`slip` if all corners of a mask slide."""
    return mask | (mask << 4)


@wp.func
def moving_bits(k: int, u: Vector, slow: real) -> int:
    """Bits of `slip` of corner k at a velocity, see event_space/block/law.py."""
    return wp.where(size(u[0]) > slow, 1 << k, 0) | wp.where(size(u[1]) > slow, 16 << k, 0)


@wp.func
def holds_both_ends(stance: int, slip: int) -> bool:
    """Whether both ends of an edge stick."""
    return slip == 0


@wp.func
def slip_after(
    k: int, mu: real, limits: Limits, course: Course, before: int, during: int, stance: int
):
    """Slip of a touching corner after a step; see event_space/block/law.py.

    If it slips along x or y at the start but not in the mean of the step, the slip ends inside at
    an unknown time. Then half of the step is tried.
    """
    cut = NEVER
    slip = during
    u0, u1, d, near = course.first, course.last, course.d, course.near
    for axis in range(2):
        bit = (1 << k) << (4 * axis)
        reach = near * size(u1[axis] - u0[axis]) / larger(d, TINY)
        e0 = size(u0[axis])
        e1 = u1[axis] * side_of(u0[axis])
        if (before & bit) != 0 and (during & bit) == 0:
            if e0 > reach and d > TWO * near:
                cut = smaller(cut, HALF * d)
        elif (before & bit) != 0:
            if e0 > reach and e1 < -reach and d > near:
                cut = smaller(cut, first_root(e0, (e1 - e0) / d, e1, d))
            elif e1 <= reach and size(e1) <= real(10.0) * reach:
                slip = slip - bit
    return cut, slip
