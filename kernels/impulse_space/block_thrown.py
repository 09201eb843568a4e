"""What impulse_space/block_run.py does with blocks in space that start in motion.

Of a block that tumbles the face that looks down becomes the bottom between two steps
(shape_space/thrown.py). Its corners begin without impulses then. Its slide is the way of its centre
along the base.
"""

import warp as wp

from warprock.kernels.impulse_space.block import Knobs
from warprock.kernels.shape_space.block import Block, turns_of
from warprock.kernels.shape_space.block_found import Peaks, start_peaks
from warprock.kernels.shape_space.frame import frame
from warprock.kernels.shape_space.lanes import State, turn_of
from warprock.kernels.shape_space.thrown import Throw, compose
from warprock.kernels.vectors import Quaternion, Vector


@wp.func
def start_throw(block: Block, knobs: Knobs, throw: Throw) -> State:
    """A block where it starts, its velocity that of half a step before."""
    fall, one = HALF * knobs.time_step * knobs.gravity, real(1.0)
    turn = frame(Quaternion(block.qx, block.qy, block.qz, block.qw))
    inertia = wp.diag(Vector(one / block.inverse_x, one / block.inverse_y, one / block.inverse_z))
    spin = turn * (inertia * (wp.transpose(turn) * Vector(throw.wx, throw.wy, throw.wz)))
    return State(
        block.x, block.y, block.z, block.qx, block.qy, block.qz, block.qw,
        throw.vx, throw.vy, throw.vz + fall, spin[0], spin[1], spin[2],
    )  # fmt: skip


@wp.func
def start_throw_peaks(block: Block, s: State) -> Peaks:
    """What is seen of a block before its first step; its matrix as after every later one."""
    r = turn_of(s)
    along, across, tilt, _yaw = turns_of(block, r.r13, r.r23, r.r33, s.qz, s.qw)
    return start_peaks(along, across, tilt)


@wp.func
def with_attitude(s: State, x: real, y: real, z: real, w: real) -> State:
    """The block at another attitude."""
    n = s
    n.qx = x
    n.qy = y
    n.qz = z
    n.qw = w
    return n


@wp.func
def as_it_began(s: State, named: Quaternion) -> State:
    """The block in the axes that it began with; `named` leads from these to its own."""
    x, y, z, w = compose(
        s.qx, s.qy, s.qz, s.qw, -named[0], -named[1], -named[2], named[3]
    )  # fmt: skip
    return with_attitude(s, x, y, z, w)


@wp.func
def observe_tumbling(block: Block, s: State, before: Peaks, now: Peaks) -> Peaks:
    """What is seen of a block that tumbles: its slide is the way of its centre."""
    x, y = s.x - block.x, s.y - block.y
    return Peaks(
        x, y, now.rotation, now.time, now.across, now.tilt, now.yaw,
        larger(before.slide, x * x + y * y),
    )  # fmt: skip
