"""State of a lane with a held block, and what is seen of it.

All is relative to the base: x along it from where the block stands at rest, z upwards. A set of
contact points is a sum of the four numbers below.
"""

import warp as wp

LEFT, RIGHT, LOW, HIGH = 1, 2, 4, 8
"""Contact points: the corners at the base, and the lower and upper one at the wall."""

FACE = 12
"""Both points at the wall."""
BASE = 3
"""Both corners at the base."""
ALL = 15
"""A block that lies flat, with its face on the wall."""


@wp.struct
class Block:
    """What a step needs to know of one lane's block.

    Attributes:
        half_width, half_height: Half sizes [m].
        mass, inertia: Mass [kg], and moment of inertia about the centre of mass [kg m^2].
        gravity: [m/s^2].
        friction: Coefficient of friction of the base; a wall has none.
        wall: Side at which a wall stands, -1 or 1; 0 without one.
        rebound: Speed with which a point leaves the wall over that with which it came.
        rest_rotation: Swing below which the block rests [rad].
        longest_step: [s].
        load_weight, load_thrust, load_place: On its top: downwards and towards +x [N], and where
            from its middle [m].
        load_stays: 1 if the weight keeps its place while the block moves, else 0.
        step_limit: Largest number of steps.
    """

    half_width: real
    half_height: real
    mass: real
    inertia: real
    gravity: real
    friction: real
    wall: real
    rebound: real
    rest_rotation: real
    longest_step: real
    load_weight: real
    load_thrust: real
    load_place: real
    load_stays: int
    step_limit: int


@wp.struct
class State:
    """State of one lane.

    Attributes:
        x, z: Centre of mass [m].
        theta: Clockwise rotation [rad].
        vx, vz: Velocity of the centre of mass [m/s].
        omega: Angular velocity [rad/s].
        slip: Direction in which the base corner slides, -1 or 1, or 0 where it sticks.
        near: Points that touch and do not part.
        closed: Those of them that press.
        still: 1 where nothing can move, else 0.
        parts: Points that touch, have no speed along their normal, and are let go.
        opens: Points of which the force has just come to zero.
        starts: 2 where a corner has just begun to slide, else 0.
        fresh: 1 where it is to be decided anew which points press, else 0.
        mode: FLAT, PIVOTING or FLYING, or why the lane has ended.
        time: [s].
        segment: Knots of the motion passed.
        tail: Time of the impacts that the rest rule has just left out [s].
    """

    x: real
    z: real
    theta: real
    vx: real
    vz: real
    omega: real
    slip: real
    near: int
    closed: int
    still: int
    parts: int
    opens: int
    starts: int
    fresh: int
    mode: int
    time: real
    segment: int
    tail: real


@wp.struct
class Seen:
    """What is seen of a lane so far.

    Attributes:
        peak, peak_time: Largest |rotation| [rad] and its time [s].
        peak_slide: Largest |slide| [m].
        uplift_time: Time of the first uplift [s]; NEVER before.
        rest_time: Time since when the block rests [s]; NEVER while it does not.
        loss: Energy lost to friction and in impacts [J].
        force: Largest force of a tie [N].
        stretch: Largest elongation of a tie [m].
        impacts, steps: Their numbers.
    """

    peak: real
    peak_time: real
    peak_slide: real
    uplift_time: real
    rest_time: real
    loss: real
    force: real
    stretch: real
    impacts: int
    steps: int


@wp.struct
class Point:
    """A point, or a lever from the centre of mass [m]."""

    x: real
    z: real


@wp.func
def point_of(block: Block, k: int) -> Point:
    """The contact point of a number, 0 to 3, on the block that does not lean."""
    side = real(block.wall)
    if k == 0:
        side = real(-1.0)
    if k == 1:
        side = real(1.0)
    high = -block.half_height
    if k == 3:
        high = block.half_height
    return Point(side * block.half_width, high)


@wp.func
def turn_point(p: Point, s: real, c: real) -> Point:
    """A point of a block that leans, from the sine and the cosine of its rotation."""
    return Point(p.x * c + p.z * s, p.z * c - p.x * s)


@wp.func
def has_point(points: int, k: int) -> bool:
    """Whether a set has the contact point of a number, 0 to 3."""
    return (points >> k) & 1 == 1


@wp.func
def mirror_points(points: int) -> int:
    """A set of points of the mirror image: the corners of the base change places."""
    return (points & FACE) + ((points & LEFT) << 1) + ((points & RIGHT) >> 1)


@wp.func
def mirror_block(block: Block, face: real) -> Block:
    """The block, reflected if `face` is -1."""
    return Block(
        block.half_width, block.half_height, block.mass, block.inertia, block.gravity,
        block.friction, face * block.wall, block.rebound, block.rest_rotation, block.longest_step,
        block.load_weight, face * block.load_thrust, face * block.load_place, block.load_stays,
        block.step_limit,
    )  # fmt: skip


@wp.func
def mirror_state(s: State, face: real) -> State:
    """The state, reflected if `face` is -1."""
    near, closed, parts, opens = int(s.near), int(s.closed), int(s.parts), int(s.opens)
    if face < real(0.0):
        near = mirror_points(near)
        closed = mirror_points(closed)
        parts = mirror_points(parts)
        opens = mirror_points(opens)
    return State(
        face * s.x, s.z, face * s.theta, face * s.vx, s.vz, face * s.omega, face * s.slip, near,
        closed, s.still, parts, opens, s.starts, s.fresh, s.mode, s.time, s.segment, s.tail,
    )  # fmt: skip


@wp.func
def normal_gap(block: Block, k: int, s: State) -> real:
    """Distance of a contact point from the base, or from the wall [m]."""
    p = turn_point(point_of(block, k), sine(s.theta), cosine(s.theta))
    gap = s.z + p.z
    if k > 1:
        gap = block.half_width - block.wall * (s.x + p.x)
    return gap


@wp.func
def normal_rate(block: Block, k: int, s: State) -> real:
    """Velocity of a contact point away from the base, or from the wall [m/s]."""
    p = turn_point(point_of(block, k), sine(s.theta), cosine(s.theta))
    rate = s.vz - s.omega * p.x
    if k > 1:
        rate = -block.wall * (s.vx + s.omega * p.z)
    return rate


@wp.func
def slide_of(block: Block, s: State) -> real:
    """Slide of the lower corner along the base [m]."""
    side = sign_of(s.theta)
    p = turn_point(
        Point(side * block.half_width, -block.half_height), sine(s.theta), cosine(s.theta)
    )
    return s.x + p.x - side * block.half_width
