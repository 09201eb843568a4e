"""The contact law of one block in space: which contacts carry, stick or slide.

See event_space/block/contact.py for the states and the order in which they are tried.
"""

import warp as wp

from warprock.kernels.algebra.vectors import Matrix, Vector
from warprock.kernels.event_space.block.contact import (
    EDGE,
    FLAT,
    FLYING,
    Body,
    Corners,
    Held,
    Shares,
    Two,
    corner_matrix,
    corner_velocity,
    direction_of,
    first_directions,
    mask_of,
    sinks,
    stance_of,
    stick,
    try_sticking,
    try_sticking_end,
)
from warprock.kernels.event_space.block.moves import Course, stop_event
from warprock.kernels.event_space.block.slide import (
    solve_sliding,
    solve_sliding_corner,
    solve_swing,
    try_slipping,
    try_swing,
)
from warprock.kernels.event_space.lane import Limits

SWERVE = real(0.95)
"""Cosine of the largest angle by which the path of a sliding corner may turn in a long step."""
SHORTEST = real(0.01)
"""Part of the longest step from which on a step counts as long."""
SWEEPS = 5000
"""Sweeps of the Gauss-Seidel iteration before it gives up."""
SETTLED = by_precision(1.0e-13, 1.0e-6)
"""Change of the velocities in a sweep, as a part of the largest, that ends the iteration."""

CornerMatrices = wp.types.matrix(shape=(12, 3), dtype=real)
"""`corner_matrix` of every corner, one below the other."""


@wp.func
def corner_law(m: Matrix, u: Vector, mu: real, d0: Two) -> Vector:
    """Impulse of one corner that obeys the contact law, given its velocity without it."""
    p = Vector()
    if u[2] < real(0.0):
        p = -(wp.inverse(m) * u)
        push = wp.sqrt(p[0] * p[0] + p[1] * p[1])
        if p[2] < real(0.0) or push > mu * p[2]:
            start = wp.where(d0[0] * d0[0] + d0[1] * d0[1] > real(0.0), d0, -direction_of(p))
            n, d, sound = solve_sliding_corner(m, u, mu, start)
            if not sound:
                n, d, sound = solve_sliding_corner(m, u, mu, -direction_of(p))
            # A corner that can neither stick nor slide jams.
            p = wp.where(sound, n * Vector(-mu * d[0], -mu * d[1], real(1.0)), p)
    return p


@wp.func(inline=False)
def solve_by_sweeps(body: Body, mask: int, v: Vector, w: Vector, dust: real) -> Held:
    """The motion that obeys the contact law at some corners, found by Gauss-Seidel sweeps."""
    zero = real(0.0)
    h = Held()
    h.v = v
    h.w = w
    impulses = Corners()
    dirs = Corners()
    answers = CornerMatrices()
    for k in range(4):
        if (mask & (1 << k)) != 0:
            answer = corner_matrix(body, k)
            for row in range(3):
                answers[3 * k + row] = answer[row]
    speed = wp.length(v) + wp.length(w) * wp.length(body.corners[0])
    change = speed
    tries = int(0)
    while change > SETTLED * speed and tries < SWEEPS:
        change = real(0.0)
        for k in range(4):
            if (mask & (1 << k)) != 0:
                m = wp.matrix_from_rows(answers[3 * k], answers[3 * k + 1], answers[3 * k + 2])
                u = corner_velocity(body, h.v, h.w, k) - m * impulses[k]
                p = corner_law(m, u, body.friction, Two(dirs[k, 0], dirs[k, 1]))
                more = p - impulses[k]
                impulses[k] = p
                h.v = h.v + more
                h.w = h.w + body.inverse * wp.cross(body.corners[k], more)
                change = larger(change, wp.length(m * more))
                d = direction_of(corner_velocity(body, h.v, h.w, k))
                dirs[k] = Vector(d[0], d[1], zero)
        tries += 1
    held = int(0)
    for k in range(4):
        u = corner_velocity(body, h.v, h.w, k)
        push = wp.sqrt(impulses[k, 0] * impulses[k, 0] + impulses[k, 1] * impulses[k, 1])
        if (mask & (1 << k)) != 0 and u[2] <= dust and impulses[k, 2] > zero:
            held = held | (1 << k)
            if push >= body.friction * impulses[k, 2] * (real(1.0) - real(1.0e4) * SETTLED):
                h.slip = h.slip | (1 << k)
        h.work -= u[0] * impulses[k, 0] + u[1] * impulses[k, 1]
    h.stance = stance_of(held)
    h.fits = tries < SWEEPS
    return h


@wp.func(inline=False)
def solve_as_before(
    body: Body, stance: int, slip: int, start: Corners, v: Vector, w: Vector, dust: real
) -> Held:
    """The motion if all contacts keep their state; `fits` if it obeys the law."""
    mask = mask_of(stance)
    h = Held()
    if stance != FLYING and slip == 0:
        h = try_sticking(body, stance, mask, v, w, dust)
    if slip != 0 and slip == mask:
        h = try_slipping(body, stance, mask, True, start, v, w, dust)
    if slip != 0 and slip != mask and stance < FLAT:
        edge = stance - EDGE
        turn = wp.where(slip == 1 << edge, 1, 0)
        k = (edge + turn) % 4
        other = (edge + 1 - turn) % 4
        way = body.corners[other] - body.corners[k]
        if way[0] * start[other, 1] < way[1] * start[other, 0]:
            turn = turn + 2
        h = try_swing(body, edge + 4 * turn, mask, slip, start, v, w, dust)
    return h


@wp.func(inline=False)
def try_slipping_stance(
    body: Body, stance: int, mask: int, slip: int, start: Corners, v: Vector, w: Vector, dust: real
) -> Held:
    """The motion if a stance slides; corners that already do keep their directions in `start`."""
    part = mask_of(stance)
    dirs = first_directions(body, stance, v, w)
    for k in range(4):
        if (slip & (1 << k)) != 0:
            dirs[k] = start[k]
    return try_slipping(body, stance, mask, (slip & part) == part, dirs, v, w, dust)


@wp.func(inline=False)
def solve_any_stance(
    body: Body, stance: int, slip: int, start: Corners, v: Vector, w: Vector, dust: real,
    turns: bool,
) -> Held:  # fmt: skip
    """The motion that obeys the contact law, see `solve`, out of all stances.

    The face or an edge as a whole comes before one of its corners. If an edge has to let go of one
    end alone (`turns`), sliding on a whole edge comes last. The states that `solve_as_before` has
    tried are left out.
    """
    mask = mask_of(stance)
    best = Held()
    for number in range(FLAT - EDGE + 1):
        c = FLAT - number
        part = mask_of(c)
        if not best.fits and c != stance and (part & mask) == part and (part & slip) == 0:
            best = try_sticking(body, c, mask, v, w, dust)
    for number in range(FLAT - EDGE + 1):
        c = FLAT - number
        part = mask_of(c)
        again = c == stance and slip == mask
        if not best.fits and not turns and not again and (part & mask) == part:
            best = try_slipping_stance(body, c, mask, slip, start, v, w, dust)
    for way in range(16):
        part = mask_of(EDGE + way % 4)
        if not best.fits and (part & mask) == part:
            best = try_swing(body, way, mask, slip & part, start, v, w, dust)
    for number in range(EDGE):
        c = EDGE - 1 - number
        if not best.fits and (mask_of(c) & mask & ~slip) != 0:
            best = try_sticking(body, c, mask, v, w, dust)
    most = wp.where(turns, FLAT, EDGE)
    for number in range(most):
        c = most - 1 - number
        part = mask_of(c)
        if not best.fits and (part & mask) == part:
            best = try_slipping_stance(body, c, mask, slip, start, v, w, dust)
    if not best.fits:
        best = Held()
        best.v = v
        best.w = w
        best.stance = FLYING
        best.fits = not sinks(body, v, w, mask, real(0.0))
    if not best.fits:
        best = solve_by_sweeps(body, mask, v, w, dust)
    return best


@wp.func(inline=False)
def solve(
    body: Body, stance: int, slip: int, start: Corners, v: Vector, w: Vector, dust: real
) -> Held:
    """The motion that obeys the contact law.

    Args:
        body: The block.
        stance: Where it touches.
        slip: Corners that slide already; 0 if the directions of sliding are free.
        start: Directions in which they slide.
        v: Velocity without contact [m/s].
        w: Angular velocity without contact [rad/s].
        dust: Velocity that is round-off [m/s].

    Returns:
        The motion; its `spare` and `turns` are those of the state before.
    """
    first = solve_as_before(body, stance, slip, start, v, w, dust)
    best = first
    if not best.fits and stance >= EDGE and stance < FLAT and slip == 0:
        best = try_sticking_end(body, stance, v, w, dust)
    if not best.fits:
        best = solve_any_stance(body, stance, slip, start, v, w, dust, first.turns)
    best.turns = first.turns
    best.spare = first.spare
    return best


@wp.func
def directions(body: Body, v: Vector, w: Vector) -> Corners:
    """Directions in which the corners move along the base."""
    dirs = Corners()
    for k in range(4):
        d = direction_of(corner_velocity(body, v, w, k))
        dirs[k] = Vector(d[0], d[1], real(0.0))
    return dirs


@wp.func(inline=False)
def project(body: Body, stance: int, slip: int, v: Vector, w: Vector):
    """Velocities projected on the contacts, along their force."""
    v_after = v
    w_after = w
    mask = mask_of(stance)
    if stance != FLYING and slip == 0:
        v_after, w_after = stick(body, stance, v, w)
    elif stance < FLAT and slip == mask:
        v_after, w_after, _n, _sound = solve_sliding(
            body, stance, body.friction, directions(body, v, w), Shares(), v, w
        )
    elif stance < FLAT:
        k = stance % 4
        first = slip == 1 << k
        other = (k + 1) % 4
        pinned = wp.where(first, other, k)
        slides = wp.where(first, k, other)
        u = corner_velocity(body, v, w, slides) - corner_velocity(body, v, w, pinned)
        way = body.corners[slides] - body.corners[pinned]
        side = wp.where(way[0] * u[1] < way[1] * u[0], real(-1.0), real(1.0))
        swing = solve_swing(body, pinned, slides, side, v, w)
        v_after = swing.v
        w_after = swing.w
    elif stance == FLAT:
        v_after = Vector(v[0], v[1], real(0.0))
        w_after = Vector(real(0.0), real(0.0), w[2])
    return v_after, w_after


@wp.func
def sliding_bits(mask: int) -> int:
    """`slip` if all corners of a mask slide."""
    return mask


@wp.func
def moving_bits(k: int, u: Vector, slow: real) -> int:
    """Bit of `slip` of corner k at velocity u; 0 if it moves along the base by at most `slow`."""
    return wp.where(u[0] * u[0] + u[1] * u[1] > slow * slow, 1 << k, 0)


@wp.func
def holds_both_ends(stance: int, slip: int) -> bool:
    """Whether at least one end of an edge sticks."""
    return slip != mask_of(stance)


@wp.func
def swerves(mu: real, limits: Limits, course: Course) -> bool:
    """Whether the path of a sliding corner turns so sharply in a step that a shorter one pays."""
    u0, u1, shortest = course.first, course.last, SHORTEST * limits.longest_step
    swift = larger(wp.length(u0), wp.length(u1)) > mu * limits.gravity * shortest
    return course.d > shortest and swift and wp.dot(direction_of(u0), direction_of(u1)) < SWERVE


@wp.func
def slip_after(
    k: int, mu: real, limits: Limits, course: Course, before: int, during: int, stance: int
):
    """Slip of a touching corner after a step.

    Args:
        k: The corner.
        mu: Friction coefficient.
        limits: Those of the lane.
        course: How the corner moves along the base in the step.
        before, during: `slip` at the start of the step, and in it.
        stance: Stance in the step.

    Returns:
        Length of the step to the stop of the corner if that lies inside, else NEVER; slip after.
    """
    cut = NEVER
    slip = during
    bit = 1 << k
    if (during & before & bit) != 0:
        there, stops = stop_event(course)
        cut = there
        slip = during - wp.where(stops, bit, 0)
        # The corner about which a flat block turns always swerves.
        if stance < FLAT and not stops and swerves(mu, limits, course):
            cut = smaller(cut, HALF * course.d)
    return cut, slip
