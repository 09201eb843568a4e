"""What a lane of a stack is at a time, and a step of it before it is taken; event/stack.py."""

import warp as wp

from warprock.kernels.event.body_weight import Weight
from warprock.kernels.event.stack_rocking import Curves
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
"""Round-off of a rotation [rad]."""
STEADY = 0
SEEKING = 1
FOUND = 2
"""Whether the moment is sought at which a contact opens or starts to slide, see `sought`."""
SOON = real(1.0e-3)
"""Part of the longest step by which that moment may be missed."""


@wp.struct
class Limits:
    """What a step needs to know of one lane besides its blocks; above, where its base stands."""

    gravity: real
    mass: real
    longest_step: real
    rest_rotation: Values
    if VERTICAL:
        above: Above


@wp.struct
class State:
    """State of one lane.

    velocity [m/s, rad/s] relative to the base; slip, the directions in which the interfaces slide;
    rate, relative velocities at the interfaces [m/s]; swing, angular velocities at the end of the
    last step before its impact [rad/s]; base velocity [m/s]; cap, the longest next step [s]; lost
    energy [J]; segment, knots passed; calm, whether the last step changed nothing; taken, whether
    the last trial was a step; deepest, how deep an end was in a face at the end of a step, before
    it was put back [m]; seek, lack and span, see `sought`; plain, whether the last step rolled and
    had no event; curve, the rotations in the last step as
    polynomials of the time since its start; rising, velocity of the base upwards
    [m/s]; risen, knots of its vertical motion passed.
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
    seek: int
    lack: real
    span: real
    plain: bool
    curve: Curves
    if VERTICAL:
        rising: real
        risen: int


@wp.struct
class Trial:
    """A step that has not been taken yet.

    Pose and velocity at its end before impacts; slip, the directions of sliding in it; length d
    [s]; time at its end [s]; change of the base's velocity in it and its velocity step [m/s]; lost
    energy [J]; cut, the length of the step to the first event inside it, else NEVER; falls, the
    ends that land; rests, the interfaces that close at its start instead; segment after it;
    turns, whether a contact opens or starts to slide in it; spare, what the contacts would have
    left if none did [N]; deep, how deep an end is in a face at its end [m]; rolls, whether all its
    contacts stick and it follows their polynomials (event/stack_rocking.py); spends, whether it
    ends where a contact has nothing left to spare; plain, whether it rolls and has no event; curve,
    see `State`; weight, what weighs; way, by how many edges bodies roll on at its end, see
    event/stack_body.py.
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
    turns: bool
    spare: real
    segment: int
    deep: real
    rolls: bool
    spends: bool
    plain: bool
    curve: Curves
    if CHAINS:
        way: Counts
    if VERTICAL:
        weight: Weight


@wp.func
def fastest(velocity: Triples):
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
def kinetic_energy(blocks: Blocks, velocity: Triples) -> real:
    """Kinetic energy in the frame of the base [J]."""
    energy = real(0.0)
    for k in range(BLOCKS):
        v = three_of(velocity, k)
        energy += HALF * (v[0] * v[0] + v[1] * v[1]) / blocks.inverse_mass[k]
        energy += HALF * v[2] * v[2] / blocks.inverse_inertia[k]
    return energy


@wp.func
def lost_between(blocks: Blocks, kick: real, free: Triples, velocity: Triples) -> real:
    """Energy that contacts take in an impact [J].

    The base's work on the blocks is at the mean of the velocities before and after, see account.py.

    Args:
        blocks: The blocks.
        kick: Velocity step of the base [m/s].
        free, velocity: Velocities after it without contact and with it.
    """
    lost = kinetic_energy(blocks, free) - kinetic_energy(blocks, velocity)
    for k in range(BLOCKS):
        lost -= HALF * kick * (velocity[3 * k] - free[3 * k]) / blocks.inverse_mass[k]
    return lost


@wp.func
def still_curve(s: State) -> Curves:
    """Rotations and angular velocities of a state, as polynomials that end there."""
    curve = Curves()
    for k in range(BLOCKS):
        curve[k, 0] = s.pose.theta[k]
        curve[k, 1] = s.velocity[3 * k + 2]
    return curve
