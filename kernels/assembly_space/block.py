"""Blocks of an assembly in space: their motion in a step, and what is seen of them.

The axes of a block are the principal axes of its inertia. With the velocities v and o before a step
of length h, e what gravity and the base add, and the impulses of the contacts (Moreau-Jean),

    v' = v + e + M^-1 J,    o' = o + I^-1 K,    x' = x + h v'

Then the block turns freely for h with the angular momentum I o' (`turn_freely`, symplectic, which
keeps it to the last bit), and o becomes what that is at its new attitude: the gyroscopic term. What
the contacts take of the energy is exactly

    e . M (v + v') / 2 - (v'. M v' - v . M v) / 2 - (o'. I o' - o . I o) / 2
"""

import warp as wp

from warprock.kernels.algebra.vectors import Matrix, Quaternion, Vector
from warprock.kernels.assembly.block import Seen
from warprock.kernels.assembly_space.contact import Heft, Move, Weighted, add_part, inner, times
from warprock.kernels.lane.account import Account
from warprock.kernels.lane.modes import BROKEN
from warprock.kernels.shape_space.block import turn_freely
from warprock.kernels.shape_space.frame import frame, rotate_diagonal
from warprock.kernels.shape_space.lanes import Triple


@wp.struct
class Block:
    """A block as a launch gives it.

    Attributes:
        light: Inverse mass [1/kg]; 0 of one that is fixed.
        inverse_x, inverse_y, inverse_z: Inverse moments of inertia about its axes [1/(kg m^2)].
        x, y, z: Centre of mass at the start [m].
        qx, qy, qz, qw: Attitude at the start.
        reach: Distance of the farthest corner from the centre of mass [m].
        fall: How far its centre sinks until it has fallen [m].
        calm: Speed up to which a corner counts as still [m/s].
    """

    light: real
    inverse_x: real
    inverse_y: real
    inverse_z: real
    x: real
    y: real
    z: real
    qx: real
    qy: real
    qz: real
    qw: real
    reach: real
    fall: real
    calm: real


@wp.struct
class Place:
    """Where a block is.

    Attributes:
        at: Centre of mass [m].
        q: Attitude.
        r: Its rotation matrix.
    """

    at: Vector
    q: Quaternion
    r: Matrix


@wp.struct
class Peak:
    """Largest turn [rad] and largest displacement of the centre [m] of a block so far."""

    turn: real
    moved: real


@wp.func
def start_place(block: Block) -> Place:
    """Where a block starts."""
    q = Quaternion(block.qx, block.qy, block.qz, block.qw)
    return Place(Vector(block.x, block.y, block.z), q, frame(q))


@wp.func
def heft_of(block: Block, r: Matrix) -> Heft:
    """What turns velocities of a block into its weighted ones, at an attitude."""
    x, y, z = wp.sqrt(block.inverse_x), wp.sqrt(block.inverse_y), wp.sqrt(block.inverse_z)
    return Heft(
        wp.sqrt(block.light),
        Matrix(
            x * r[0, 0], x * r[1, 0], x * r[2, 0], y * r[0, 1], y * r[1, 1], y * r[2, 1],
            z * r[0, 2], z * r[1, 2], z * r[2, 2],
        ),
    )  # fmt: skip


@wp.func
def inertia(block: Block, r: Matrix) -> Matrix:
    """Moment of inertia of a block that can move, in the axes of the base [kg m^2]."""
    one = real(1.0)
    return rotate_diagonal(
        r, one / block.inverse_x, one / block.inverse_y, one / block.inverse_z
    )  # fmt: skip


@wp.func
def turn_block(block: Block, q: Quaternion, spin: Vector, step: real) -> Quaternion:
    """Attitude of a block after it has turned freely, by its angular momentum [kg m^2/s]."""
    x, y, z, w = turn_freely(
        q[0], q[1], q[2], q[3], Triple(spin[0], spin[1], spin[2]),
        Triple(block.inverse_x, block.inverse_y, block.inverse_z), step,
    )  # fmt: skip
    return Quaternion(x, y, z, w)


@wp.func
def integrate(step: real, block: Block, v: wp.ref[Move], at: wp.ref[Place]):
    """Moves a block that is not fixed on by a step of a length [s]."""
    spin = times(inertia(block, at.r), v.o)
    at.at = add_part(step, v.v, at.at)
    at.q = turn_block(block, at.q, spin, step)
    at.r = frame(at.q)
    v.o = times(rotate_diagonal(at.r, block.inverse_x, block.inverse_y, block.inverse_z), spin)


@wp.func
def strayed_by(block: Block, stood: Place, at: Place) -> real:
    """How far the corners of a block have moved since it stood elsewhere, at most [m]."""
    away, turn = at.at - stood.at, at.q - stood.q
    # An angle is twice what quaternions differ by, where that is small.
    half = wp.sqrt(wp.dot(turn, turn))
    return fused(TWO * block.reach, half, wp.sqrt(inner(away, away)))


@wp.func
def add_energy(
    pull: Vector, gain: Vector, block: Block, at: Place, before: Move, v: Move,
    account: wp.ref[Account],
):  # fmt: skip
    """Adds what a block that is not fixed does in a step to the account of its lane.

    Args:
        pull: What gravity and the base added to its velocity [m/s].
        gain: What the velocity of the base gained [m/s].
        block: The block.
        at: Where it was in the step.
        before, v: Its velocities before and after the step.
        account: The account.
    """
    m = real(1.0) / block.light
    both = before.v + v.v
    kept = inner(v.v - before.v, both)
    spun = inner(times(inertia(block, at.r), v.o - before.o), before.o + v.o)
    account.work = account.work - HALF * m * inner(gain, both)
    account.loss = account.loss + HALF * (m * (inner(pull, both) - kept) - spun)


@wp.func
def turn_since(block: Block, q: Quaternion) -> real:
    """Angle by which a block has turned since the start [rad], at most half a turn."""
    # Imaginary part and real part of q q0*.
    a, b = Vector(q[0], q[1], q[2]), Vector(-block.qx, -block.qy, -block.qz)
    vector = block.qw * a + q[3] * b + wp.cross(a, b)
    return TWO * wp.atan2(wp.sqrt(inner(vector, vector)), size(q[3] * block.qw - inner(a, b)))


@wp.func
def observe_block(
    time: real, block: Block, at: Place, v: Move, peak: wp.ref[Peak], seen: wp.ref[Seen]
):
    """What a step shows of a block, and how its lane goes on.

    Args:
        time: End of the step [s].
        block: The block.
        at: Where it is.
        v: Its velocities.
        peak: Its peaks.
        seen: What is seen of the lane.
    """
    turn = turn_since(block, at.q)
    away = at.at - Vector(block.x, block.y, block.z)
    far = wp.sqrt(inner(away, away))
    peak.turn = larger(smaller(turn, HALF_PI), peak.turn)
    peak.moved = larger(far, peak.moved)
    if smaller(turn, HALF_PI) > seen.peak:
        seen.peak = smaller(turn, HALF_PI)
        seen.peak_time = time
    speed = fused(block.reach, wp.sqrt(inner(v.o, v.o)), wp.sqrt(inner(v.v, v.v)))
    seen.moved = wp.where(speed > block.calm, time, seen.moved)
    seen.speed = larger(speed, seen.speed)
    fell = away[2] < -block.fall or turn >= HALF_PI
    seen.collapse_time = wp.where(fell, smaller(time, seen.collapse_time), seen.collapse_time)
    total = turn + far + speed
    # Of NaN and infinity, total - total is not 0.
    seen.mode = wp.where(total - total != real(0.0), BROKEN, seen.mode)


@wp.func
def add_weighted(part: real, a: Weighted, b: Weighted) -> Weighted:
    """Gives part a + b."""
    return Weighted(
        fused(part, a.x, b.x), fused(part, a.y, b.y), fused(part, a.z, b.z),
        fused(part, a.ox, b.ox), fused(part, a.oy, b.oy), fused(part, a.oz, b.oz),
    )  # fmt: skip


@wp.func
def extrapolate(beta: real, before: Weighted, y: Weighted) -> Weighted:
    """Weighted velocities that go on along their last change, as impulses will in the next sweep.

    Args:
        beta: Part of the change by which they go on.
        before: What they were after the sweep before the last one.
        y: What they are.
    """
    return add_weighted(beta, add_weighted(real(-1.0), before, y), y)
