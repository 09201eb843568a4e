"""State of a stack at a time, and a trial step before it is taken; event/stack/step.py."""

import warp as wp

from warprock.kernels.event.body.weight import Weight
from warprock.kernels.event.stack.curves import Curves
from warprock.kernels.event.stack.links import Chain
from warprock.kernels.motion.kinds import Motion
from warprock.kernels.shape.above import Above
from warprock.kernels.shape.stack import CLOSED, Blocks, Counts, Pose, Triples, Values, three_of

NEARLY = by_precision(1.0e-6, 1.0e-4)
"""Part of the longest step by which the time of an event may be missed."""
DUST = by_precision(1.0e-12, 1.0e-5)
"""Round-off of a velocity, as a part of the largest."""
STILL = by_precision(1.0e-9, 1.0e-4)
"""Velocity at a contact that sticks, as a part of the largest."""
REACH = real(0.125)
"""Largest rotation in one step [rad]: keeps the polynomials in their range."""
SLOWEST = real(1.0e-30)
"""Keeps a quotient by zero finite."""
GRAIN = by_precision(1.0e-15, 1.0e-6)
"""Round-off of a rotation [rad], and of a gap as a part of the half height."""
STEADY = 0
SEEKING = 1
FOUND = 2
"""Stages of a search, see `Search`."""
SOON = real(1.0e-3)
"""Part of the longest step by which the moment may be missed at which a contact lets go."""


@wp.struct
class Rebound:
    """Restitution of ends that close, and the speed up to which none bounces [m/s]."""

    kept: real
    slow: real


@wp.struct
class Limits:
    """What a step needs to know of a lane besides its blocks.

    Attributes:
        gravity: [m/s^2].
        mass: Of all blocks [kg].
        longest_step: [s].
        rest_rotation: Swing below which a block rests [rad].
        rebound: How ends bounce.
    """

    gravity: real
    mass: real
    longest_step: real
    rest_rotation: Values
    if BOUNCES:
        rebound: Rebound


@wp.struct
class Shaking:
    """Ground motion of a lane, and the samples of its record where the state stands.

    Attributes:
        motion: Motion along x.
        value, slope: What `series` takes of a record.
        above: Motion upwards.
    """

    motion: Motion
    value: real
    slope: real
    if VERTICAL:
        above: Above


@wp.struct
class Search:
    """Search for the moment at which a contact lets go: opens, or starts to slide.

    Attributes:
        stage: STEADY; SEEKING where the next step is a probe of next to no length; FOUND where the
            next step ends at that moment.
        lack: Margin of the weakest contact in the middle of the first trial [N], negative.
        span: Length of that trial [s].
    """

    stage: int
    lack: real
    span: real


@wp.struct
class State:
    """State of one lane, and what its last step was.

    Attributes:
        pose: Rotations and places.
        velocity: Relative to the base [m/s, rad/s].
        rate: Relative velocities at the interfaces [m/s].
        slip: Directions in which the interfaces slide.
        swing: Angular velocities at the end of the last step, before its impact [rad/s].
        time: [s].
        base: Velocity of the base [m/s].
        cap: Longest next step [s].
        lost: Energy lost so far [J].
        segment: Knots of the ground motion passed.
        mode: RUNNING, or why the lane has ended.
        impacts: Number of impacts.
        calm: Whether the last step changed nothing.
        taken: Whether the last trial was taken.
        deepest: How deep an end was in a face at the end of a step, before it was put back [m].
        search: Search for the moment at which a contact lets go.
        stuck: Whether all contacts stuck in the last step.
        curve: Rotations in the last step, as polynomials of the time since its start.
        chain: The chain that it is while its contacts stick.
        rising: Velocity of the base upwards [m/s].
        risen: Knots of its vertical motion passed.
    """

    pose: Pose
    velocity: Triples
    rate: Triples
    slip: Counts
    swing: Values
    time: real
    base: real
    cap: real
    lost: real
    segment: int
    mode: int
    impacts: int
    calm: bool
    taken: bool
    deepest: real
    search: Search
    stuck: bool
    curve: Curves
    chain: Chain
    if VERTICAL:
        rising: real
        risen: int


@wp.struct
class Trial:
    """A step that has not been taken yet.

    Attributes:
        pose, velocity: At its end, before impacts.
        slip: Directions of sliding in it.
        d: Its length [s].
        time: Time at its end [s].
        dv: Change of the base's velocity in it [m/s].
        kick: Velocity step of the base at its end [m/s].
        lost: Energy that friction takes in it [J].
        cut: Length of the step to the first event inside it, else NEVER.
        falls: Ends that land.
        resting: Whether interfaces close at its start instead; `falls` says which.
        struck: Whether it ends with an impact.
        settled: Whether its contacts obey the contact law.
        switches: Whether a contact lets go in it.
        spare: Margin of the weakest contact if none lets go [N].
        segment: Knots passed after it.
        deep: How deep an end is in a face at its end [m].
        rocks: Whether all contacts stick and it follows polynomials (event/stack/rocking.py).
        spends: Whether it ends where the margin of a contact is used up.
        plain: Whether it rocks and has no event.
        curve: See `State`.
        way: By how many edges bodies roll on at its end (event/stack/edges.py).
        weight: Gravity and the vertical motion of the base.
    """

    pose: Pose
    velocity: Triples
    slip: Counts
    d: real
    time: real
    dv: real
    kick: real
    lost: real
    cut: real
    falls: Counts
    resting: bool
    struck: bool
    settled: bool
    switches: bool
    spare: real
    segment: int
    deep: real
    rocks: bool
    spends: bool
    plain: bool
    curve: Curves
    if CHAINS:
        way: Counts
    if VERTICAL:
        weight: Weight


@wp.func
def largest_speeds(velocity: Triples):
    """Largest velocity of a block's centre [m/s] and largest angular velocity [rad/s]."""
    speed = real(0.0)
    spin = real(0.0)
    for k in range(BLOCKS):
        speed = larger(speed, size(velocity[3 * k]))
        speed = larger(speed, size(velocity[3 * k + 1]))
        spin = larger(spin, size(velocity[3 * k + 2]))
    return speed, spin


@wp.func
def at_rest(touch: Counts, slip: Counts) -> bool:
    """Whether all interfaces are closed and stick."""
    rests = bool(True)
    for k in range(BLOCKS):
        rests = rests and touch[k] == CLOSED and slip[k] == 0
    return rests


@wp.func
def as_base_rises(velocity: Triples, gained: real) -> Triples:
    """Velocities of blocks as seen from a base that gains velocity upwards [m/s]."""
    v = velocity
    for k in range(BLOCKS):
        v[3 * k + 1] = v[3 * k + 1] - gained
    return v


@wp.func
def kinetic_energy(blocks: wp.ref[Blocks], velocity: Triples) -> real:
    """Kinetic energy in the frame of the base [J]."""
    energy = real(0.0)
    for k in range(BLOCKS):
        v = three_of(velocity, k)
        energy += HALF * (v[0] * v[0] + v[1] * v[1]) * blocks.mass[k]
        energy += HALF * v[2] * v[2] * blocks.inertia[k]
    return energy


@wp.func
def lost_in_impact(
    blocks: wp.ref[Blocks], t: wp.ref[Trial], free: Triples, velocity: Triples
) -> real:
    """Energy that contacts take in the impact at the end of a trial step [J].

    The base's work on the blocks is at the mean of the velocities before and after, see account.py.

    Args:
        blocks: The blocks.
        t: The step.
        free, velocity: Velocities after the base's velocity step, without contact and with it.
    """
    lost = real(0.0)
    rise = real(0.0)
    if VERTICAL:
        rise = t.weight.kick
    for k in range(BLOCKS):
        before, after = three_of(free, k), three_of(velocity, k)
        less, total = before - after, before + after
        along = less[0] * (total[0] + t.kick) + less[1] * (total[1] + rise)
        lost += HALF * along * blocks.mass[k]
        lost += HALF * less[2] * total[2] * blocks.inertia[k]
    return lost


@wp.func
def still_curve(s: wp.ref[State]) -> Curves:
    """Rotations and angular velocities of a state, as polynomials that end there."""
    curve = Curves()
    for k in range(BLOCKS):
        curve[k, 0] = s.pose.theta[k]
        curve[k, 1] = s.velocity[3 * k + 2]
    return curve
