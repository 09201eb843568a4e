"""The motion of a held block between two events, as Taylor series in time.

With x, z the centre of mass and theta the clockwise rotation, a point (px, pz) of the block lies at

    X = px c + pz s,   Z = pz c - px s,   s = sin(theta),  c = cos(theta),

from the centre, and in it a force (fx, fz) turns the block by Z fx - X fz. Ties between two
changes give forces that are linear in x, s and c; a weight W on top turns the block by W X where it
moves with it, by W (place - x) where it keeps its place. The points that press add forces l along
E, which keep their rates: D'' = 0. So every Taylor coefficient of x, z, theta and of the forces
follows from lower ones, by the same matrix (held_contact.py) in all orders.
"""

import warp as wp

from warprock.kernels.contact.ties import ELASTIC, Tie, TieState, force_of
from warprock.kernels.event.held.contact import Vector, grip_of, mobility
from warprock.kernels.event.held.state import ALL, BASE, Block, Point, State, turn_point
from warprock.kernels.motion.series import DEGREE, Series, slope_of


@wp.struct
class Held:
    """The ties of a lane, [tie, lane], seen from a side: reflected if `face` is -1."""

    ties: wp.array2d(dtype=Tie)
    states: wp.array2d(dtype=TieState)
    lane: int
    face: real


@wp.struct
class Pull:
    """Forces of ties and of the load between two changes: along the base c0 - k0 x - k1 c - k2 s.

    Those times px and times pz, summed likewise: c1 - k1 x - k11 c - k12 s and
    c2 - k2 x - k12 c - k22 s. The weight of the load is `down` [N].
    """

    c0: real
    c1: real
    c2: real
    k0: real
    k1: real
    k2: real
    k11: real
    k12: real
    k22: real
    down: real


@wp.struct
class Path:
    """A step: centre of mass, rotation, its sine and cosine, forces of up to three constraints."""

    x: Series
    z: Series
    theta: Series
    sine: Series
    cosine: Series
    first: Series
    second: Series
    third: Series


@wp.func
def tie_of(held: Held, i: int) -> Tie:
    """A tie as it is seen."""
    tie = held.ties[i, held.lane]
    tie.side = held.face * tie.side
    return tie


@wp.func
def tie_point(block: Block, tie: Tie) -> Point:
    """The point of a tie on the block that does not lean."""
    return Point(tie.side * block.half_width, tie.height - block.half_height)


@wp.func
def stretch_of(block: Block, tie: Tie, s: State) -> real:
    """Elongation of a tie from the state in which the block rests [m]."""
    p = tie_point(block, tie)
    half = sine(HALF * s.theta)
    moved = s.x + real(2.0) * half * (p.z * cosine(HALF * s.theta) - p.x * half)
    return -tie.side * moved


@wp.func
def stretch_series(block: Block, tie: Tie, path: Path) -> Series:
    """Elongation of a tie in a step [m]."""
    p = tie_point(block, tie)
    found = -tie.side * (path.x + p.x * path.cosine + p.z * path.sine)
    found[0] = found[0] + tie.side * p.x
    return found


@wp.func
def pull_of(block: Block, held: Held) -> Pull:
    """The forces of all ties and of the load."""
    p = Pull()
    p.c0 = block.load_thrust
    p.c1 = block.load_thrust * block.load_place
    p.c2 = block.load_thrust * block.half_height
    p.down = block.load_weight
    for i in range(held.ties.shape[0]):
        tie = tie_of(held, i)
        state = held.states[i, held.lane]
        at = tie_point(block, tie)
        pulls = tie.side * force_of(tie, state, state.free)
        if state.does == ELASTIC:
            k = tie.stiffness
            pulls = k * at.x - tie.side * k * state.free
            p.k0 = p.k0 + k
            p.k1 = p.k1 + k * at.x
            p.k2 = p.k2 + k * at.z
            p.k11 = p.k11 + k * at.x * at.x
            p.k12 = p.k12 + k * at.x * at.z
            p.k22 = p.k22 + k * at.z * at.z
        p.c0 = p.c0 + pulls
        p.c1 = p.c1 + pulls * at.x
        p.c2 = p.c2 + pulls * at.z
    return p


@wp.func
def free_rates(block: Block, p: Pull, s: State, a: real) -> Vector:
    """Accelerations without contact: of weight, load and ties, on a base with an acceleration a."""
    sin, cos = sine(s.theta), cosine(s.theta)
    along = p.c0 - p.k0 * s.x - p.k1 * cos - p.k2 * sin
    across = p.c1 - p.k1 * s.x - p.k11 * cos - p.k12 * sin
    above = p.c2 - p.k2 * s.x - p.k12 * cos - p.k22 * sin
    lever = turn_point(Point(block.load_place, block.half_height), sin, cos)
    beside = lever.x
    if block.load_stays > 0:
        beside = block.load_place - s.x
    moment = above * cos - across * sin + p.down * beside
    return Vector(
        along / block.mass - a, -block.gravity - p.down / block.mass, moment / block.inertia
    )


@wp.func
def expand_path(block: Block, p: Pull, a: Series, s: State) -> Path:
    """The motion from a state on, with the contacts that it has."""
    x, z, theta, sines, cosines = Series(), Series(), Series(), Series(), Series()
    forces_0, forces_1, forces_2 = Series(), Series(), Series()
    x[0] = s.x
    x[1] = s.vx
    z[0] = s.z
    z[1] = s.vz
    theta[0] = s.theta
    theta[1] = s.omega
    sines[0] = sine(s.theta)
    cosines[0] = cosine(s.theta)
    sines[1] = s.omega * cosines[0]
    cosines[1] = -s.omega * sines[0]
    level = (s.closed & BASE) == BASE
    if s.closed != ALL:
        holds = int(0)
        if s.slip == real(0.0) and (s.closed & BASE) > 0:
            holds = int(1)
        g = grip_of(block, s.closed, holds, s.slip)
        inverse = wp.inverse(mobility(block, g, sines[0], cosines[0]))
        top = Point(block.load_place, block.half_height)
        weight = block.gravity + p.down / block.mass
        for n in range(DEGREE - 1):
            turned_s, turned_c = real(0.0), real(0.0)
            for j in range(n + 1):
                rate = real(j + 1) * theta[j + 1]
                turned_s = turned_s + rate * cosines[n + 1 - j]
                turned_c = turned_c - rate * sines[n + 1 - j]
            turned_s = turned_s / real(n + 2)
            turned_c = turned_c / real(n + 2)
            moment = real(0.0)
            for j in range(n + 1):
                i = n - j
                above = -p.k2 * x[j] - p.k12 * cosines[j] - p.k22 * sines[j]
                across = -p.k1 * x[j] - p.k11 * cosines[j] - p.k12 * sines[j]
                if j == 0:
                    above = above + p.c2
                    across = across + p.c1
                moment = moment + above * cosines[i] - across * sines[i]
            beside = top.x * cosines[n] + top.z * sines[n]
            if block.load_stays > 0:
                beside = -x[n]
            along = -p.k0 * x[n] - p.k1 * cosines[n] - p.k2 * sines[n]
            down = real(0.0)
            if n == 0:
                along = along + p.c0
                down = weight
                if block.load_stays > 0:
                    beside = beside + top.x
            moment = moment + p.down * beside
            # What the forces of lower orders turn the block by.
            for j in range(n):
                i = n - j
                cos, sin = cosines[i], sines[i]
                force = Vector(forces_0[j], forces_1[j], forces_2[j])
                for k in range(g.count):
                    lever = turn_point(Point(g.px[k], g.pz[k]), sin, cos)
                    moment = moment + (lever.z * g.ex[k] - lever.x * g.ez[k]) * force[k]
            bx, bz, bo = along / block.mass - a[n], -down, moment / block.inertia
            order = real((n + 1) * (n + 2))
            lacks = Vector()
            for k in range(g.count):
                arm = turn_point(Point(g.px[k], g.pz[k]), sines[0], cosines[0])
                rest = turn_point(Point(g.px[k], g.pz[k]), turned_s, turned_c)
                spin = g.dx[k] * arm.z - g.dz[k] * arm.x
                moves = g.dx[k] * (bx + order * rest.x) + g.dz[k] * (bz + order * rest.z)
                lacks[k] = -(moves + spin * bo)
            now = inverse * lacks
            forces_0[n] = now[0]
            forces_1[n] = now[1]
            forces_2[n] = now[2]
            for k in range(g.count):
                lever = turn_point(Point(g.px[k], g.pz[k]), sines[0], cosines[0])
                bx = bx + g.ex[k] * now[k] / block.mass
                bz = bz + g.ez[k] * now[k] / block.mass
                bo = bo + (lever.z * g.ex[k] - lever.x * g.ez[k]) * now[k] / block.inertia
            if s.still > 0:
                bx = real(0.0)
            if level or s.still > 0:
                bz = real(0.0)
                bo = real(0.0)
            x[n + 2] = bx / order
            z[n + 2] = bz / order
            theta[n + 2] = bo / order
            sines[n + 2] = theta[n + 2] * cosines[0] + turned_s
            cosines[n + 2] = -theta[n + 2] * sines[0] + turned_c
    return Path(x, z, theta, sines, cosines, forces_0, forces_1, forces_2)


@wp.func
def force_series(path: Path, n: int) -> Series:
    """The force of a constraint in a step [N]."""
    found = path.first
    if n == 1:
        found = path.second
    if n == 2:
        found = path.third
    return found


@wp.func
def place_series(path: Path, p: Point) -> Series:
    """Where a point of the block is along the base in a step [m]."""
    return path.x + p.x * path.cosine + p.z * path.sine


@wp.func
def level_series(path: Path, p: Point) -> Series:
    """How high it is [m]."""
    return path.z + p.z * path.cosine - p.x * path.sine


@wp.func
def slip_series(path: Path, p: Point) -> Series:
    """Velocity of a point of a block along the base in a step [m/s]."""
    return slope_of(place_series(path, p))
