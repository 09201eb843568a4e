"""Contact of a held block with base and wall: which points press, and with what.

A block of mass m and inertia I may touch its base at two corners, with Coulomb's friction, and a
wall at two points, without friction. A point that presses keeps its distance; a point that sticks
keeps its place. So some rates D v have given values t. Forces l along directions E bring that about
(E differs from D where a corner slides):

    D (v0 + M^-1 E l) = t,

with v0 the rates without contact. Velocities in an impact and accelerations after it obey the same
law, with impulses or forces l. A normal force is not negative. A force along the base is within
friction. A point that does not press does not come nearer. At most three rates are independent, so
the kernel tries all sets of points and takes the first that obeys the law: sets that stick before
sets that slide, sets with both corners before the others (the law is that of Glocker 2001, ch. 5).

Where a block lies flat with its face on a wall, its forces are not unique. The kernel asks only
whether any forces hold it: a push J of the wall anywhere up its face, a friction |F| <= friction N,
and N anywhere along the base. With H = J + F and M the moment about the corner that base and wall
share, both known, forces hold it where

    H + friction N >= 0,    M + 2 b N >= 0,    2 h (H + friction N) >= M,

all counted away from the wall. Where the first fails, the block slides off. Where the second fails,
it lifts about its other corner. Where the third fails, its foot is thrust out.
"""

import warp as wp

from warprock.kernels.algebra.vectors import Matrix, Vector
from warprock.kernels.event.held.state import (
    ALL,
    BASE,
    FACE,
    LOW,
    RIGHT,
    Block,
    Point,
    has_point,
    point_of,
    turn_point,
)

EPS = by_precision(1.0e-10, 1.0e-4)
"""Relative round-off of a force or a rate that decides."""
SINGULAR = by_precision(1.0e-9, 1.0e-4)
"""Determinant over the product of the diagonal below which rates are not independent."""

Four = wp.types.vector(length=4, dtype=real)
"""A number of each contact point."""


@wp.struct
class Grip:
    """A set of contact points that press, as constraints: points in order, what sticks last.

    Attributes:
        px, pz: Their points, on the block that does not lean [m].
        dx, dz: Directions of their rates.
        ex, ez: Directions of their forces.
        count: How many there are.
        points: The set.
        holds: 1 if the base corner sticks.
        slip: Direction in which it slides.
    """

    px: Vector
    pz: Vector
    dx: Vector
    dz: Vector
    ex: Vector
    ez: Vector
    count: int
    points: int
    holds: int
    slip: real


@wp.struct
class Ask:
    """What contacts have to bring about.

    Attributes:
        free: Rates without them: velocities or accelerations.
        curve: omega^2 of accelerations, 0 of velocities.
        back: Velocities with which points are to part after an impact [m/s].
        near: Points that touch.
        slip: Direction of sliding, of accelerations.
        moves: 1 of velocities, 0 of accelerations.
        s, c: Sine and cosine of the rotation.
    """

    free: Vector
    curve: real
    back: Four
    near: int
    slip: real
    moves: int
    s: real
    c: real


@wp.struct
class Choice:
    """What contacts do.

    Attributes:
        points: Points that press.
        holds: 1 if the base corner sticks, else 0.
        slip: Direction in which it slides.
        rate: Rates with them.
        found: 1 if there is a set that obeys the law, else 0.
    """

    points: int
    holds: int
    slip: real
    rate: Vector
    found: int


@wp.func
def grip_of(block: Block, points: int, holds: int, slip: real) -> Grip:
    """A set of points that press as constraints."""
    px, pz, dx, dz, ex, ez = Vector(), Vector(), Vector(), Vector(), Vector(), Vector()
    n = int(0)
    for k in range(4):
        if has_point(points, k):
            p = point_of(block, k)
            px[n] = p.x
            pz[n] = p.z
            if k < 2:
                dz[n] = real(1.0)
                ez[n] = real(1.0)
                ex[n] = -slip * block.friction
            else:
                dx[n] = -block.wall
                ex[n] = -block.wall
            n = n + 1
    if holds > 0:
        k = int(0)
        if (points & RIGHT) > 0:
            k = int(1)
        p = point_of(block, k)
        px[n] = p.x
        pz[n] = p.z
        dx[n] = real(1.0)
        ex[n] = real(1.0)
        n = n + 1
    return Grip(px, pz, dx, dz, ex, ez, n, points, holds, slip)


@wp.func
def turning_rate(g: Grip, i: int, s: real, c: real) -> real:
    """Rate of a constraint as the block turns by a radian a second [m]."""
    p = turn_point(Point(g.px[i], g.pz[i]), s, c)
    return g.dx[i] * p.z - g.dz[i] * p.x


@wp.func
def turning_moment(g: Grip, i: int, s: real, c: real) -> real:
    """Moment of the force of a constraint about the centre of mass, over the force [m]."""
    p = turn_point(Point(g.px[i], g.pz[i]), s, c)
    return p.z * g.ex[i] - p.x * g.ez[i]


@wp.func
def mobility(block: Block, g: Grip, s: real, c: real) -> Matrix:
    """The matrix D M^-1 E, with ones for constraints that there are not."""
    a = Matrix()
    for i in range(3):
        a[i, i] = real(1.0)
    for i in range(g.count):
        for j in range(g.count):
            along = (g.dx[i] * g.ex[j] + g.dz[i] * g.ez[j]) / block.mass
            spin = turning_rate(g, i, s, c) * turning_moment(g, j, s, c) / block.inertia
            a[i, j] = along + spin
    return a


@wp.func
def has_one_answer(a: Matrix) -> bool:
    """Whether forces have one answer: rates that are independent, and no corner that jams.

    A corner jams where the friction of its sliding presses it the more on the base the harder that
    pushes back (Painleve 1895). Where leaving obeys the law, too, it leaves.
    """
    diagonal = size(a[0, 0] * a[1, 1] * a[2, 2])
    return wp.determinant(a) > SINGULAR * diagonal


@wp.func
def forces_of(block: Block, g: Grip, a: Matrix, ask: Ask) -> Vector:
    """The forces or impulses that bring the rates about."""
    lacks = Vector()
    for i in range(g.count):
        p = turn_point(Point(g.px[i], g.pz[i]), ask.s, ask.c)
        spin = g.dx[i] * p.z - g.dz[i] * p.x
        lacks[i] = ask.curve * (g.dx[i] * p.x + g.dz[i] * p.z)
        lacks[i] = lacks[i] - g.dx[i] * ask.free[0] - g.dz[i] * ask.free[1] - spin * ask.free[2]
    n = int(0)
    for k in range(4):
        if has_point(g.points, k):
            lacks[n] = lacks[n] + ask.back[k]
            n = n + 1
    return wp.inverse(a) * lacks


@wp.func
def rates_with(block: Block, g: Grip, force: Vector, ask: Ask) -> Vector:
    """The rates with those forces."""
    x, z, o = real(ask.free[0]), real(ask.free[1]), real(ask.free[2])
    for i in range(g.count):
        x = x + g.ex[i] * force[i] / block.mass
        z = z + g.ez[i] * force[i] / block.mass
        o = o + turning_moment(g, i, ask.s, ask.c) * force[i] / block.inertia
    return Vector(x, z, o)


@wp.func
def presses(block: Block, g: Grip, force: Vector, ask: Ask) -> bool:
    """Whether no force pulls, and the one along the base is within friction."""
    free = ask.free
    reach = block.half_height + block.half_width
    scale = block.mass * (size(free[0]) + size(free[1]) + reach * size(free[2]))
    slack = EPS * scale + TINY
    fits = bool(True)
    n = int(0)
    carried = real(0.0)
    for k in range(4):
        if has_point(g.points, k):
            least = -slack
            if k == 2 and g.holds == 0 and g.slip == real(0.0) and ask.moves > 0:
                # Beside a wall friction may take the place of a pull at the foot.
                least = least - block.friction * carried
            if not (force[n] >= least):
                fits = False
            if k < 2:
                carried = carried + force[n]
            n = n + 1
    if g.holds > 0 and size(force[n]) > block.friction * carried + slack:
        fits = False
    return fits


@wp.func
def moves_apart(block: Block, g: Grip, rate: Vector, ask: Ask) -> bool:
    """Whether no other point comes nearer, and the base corner slides the way it does."""
    reach = block.half_height + block.half_width
    free = ask.free
    scale = size(free[0]) + size(free[1]) + reach * (size(free[2]) + ask.curve)
    slack = EPS * scale + TINY
    fits = bool(True)
    for k in range(4):
        p = turn_point(point_of(block, k), ask.s, ask.c)
        if has_point(ask.near, k) and not has_point(g.points, k):
            moves = rate[1] - rate[2] * p.x - ask.curve * p.z
            if k > 1:
                moves = -block.wall * (rate[0] + rate[2] * p.z - ask.curve * p.x)
            if not (moves - ask.back[k] >= -slack):
                fits = False
    starts = g.slip != real(0.0) and ask.slip == real(0.0)
    if starts and (g.points & BASE) > 0:
        k = int(0)
        if (g.points & RIGHT) > 0:
            k = int(1)
        p = turn_point(point_of(block, k), ask.s, ask.c)
        along = rate[0] + rate[2] * p.z - ask.curve * p.x
        if not (g.slip * along >= -slack):
            fits = False
    return fits


@wp.func
def wall_reserve(block: Block, along: real, upwards: real, moment: real) -> Vector:
    """What is left until a block that lies flat with its face on a wall is let go.

    Args:
        block: The block.
        along, upwards: Force or impulse that base and wall have to give.
        moment: Its moment about the centre of mass.

    Returns:
        Until it slides off, until it lifts, until its foot is thrust out.
    """
    away = -block.wall
    p = point_of(block, 2)
    about = away * (moment - (p.z * along - p.x * upwards))
    push = away * along + block.friction * upwards
    b, h = block.half_width, block.half_height
    return Vector(push, about + TWO * b * upwards, TWO * h * push - about)


@wp.func
def wall_holds(block: Block, ask: Ask) -> bool:
    """Whether base and wall bring a block to rest, or keep it there, that lies on both."""
    free = ask.free
    left = wall_reserve(
        block, -block.mass * free[0], -block.mass * free[1], -block.inertia * free[2]
    )
    reach = block.half_height + block.half_width
    scale = size(free[0]) + size(free[1]) + reach * size(free[2])
    slack = EPS * block.mass * scale
    bounces = ask.back[2] > real(0.0) or ask.back[3] > real(0.0)
    rests = ask.near == ALL and ask.slip == real(0.0) and ask.curve == real(0.0)
    held = left[0] >= -slack and left[1] >= -reach * slack and left[2] >= -reach * slack
    return rests and held and not bounces


@wp.func
def choose(block: Block, ask: Ask) -> Choice:
    """The points that press: the first set that obeys the law."""
    zero = real(0.0)
    found = Choice(0, 0, zero, ask.free, 0)
    if wall_holds(block, ask):
        found = Choice(ALL, 1, zero, Vector(), 1)
    first = real(block.wall)
    if first == zero:
        first = real(1.0)
    for way in range(3):
        slip = zero
        if way > 0:
            slip = first
        if way > 1:
            slip = -first
        goes = ask.slip == zero or ask.slip == slip
        for trial in range(16):
            # Base corners from both to none, each with the points at the wall from none to both.
            base = 3 - trial // 4
            wall = (trial % 4) * LOW
            points = base + wall
            holds = int(0)
            # A face on the wall holds the foot in its stead.
            faced = base > 0 and wall == FACE
            if way == 0 and base > 0 and not faced:
                holds = int(1)
            fits = found.found == 0 and goes and (points & ask.near) == points
            # Without a corner at the base there is no friction: tried once.
            if base == 0 and way > 0 and ask.slip == zero:
                fits = False
            if base == BASE and wall > 0:
                fits = False
            if faced and (way > 0 or ask.moves == 0):
                fits = False
            if fits:
                g = grip_of(block, points, holds, slip)
                a = mobility(block, g, ask.s, ask.c)
                if has_one_answer(a):
                    force = forces_of(block, g, a, ask)
                    rate = rates_with(block, g, force, ask)
                    if presses(block, g, force, ask) and moves_apart(block, g, rate, ask):
                        found = Choice(points, holds, slip, rate, 1)
    return found
