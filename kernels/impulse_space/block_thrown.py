"""Blocks in space that start in motion, in impulse_space/block_run.py.

If a block tumbles, the face that looks down becomes its bottom between two steps
(shape_space/thrown.py). Its corners then start without impulses. Its slide is the displacement of
its centre along the base.
"""

import warp as wp

from warprock.kernels.algebra.vectors import Quaternion, Vector
from warprock.kernels.impulse_space.block import Knobs
from warprock.kernels.shape_space.block import Block, turns_of
from warprock.kernels.shape_space.block_found import Peaks, start_peaks
from warprock.kernels.shape_space.frame import frame
from warprock.kernels.shape_space.lanes import State, turn_of
from warprock.kernels.shape_space.thrown import Throw, compose


@wp.func
def start_throw(block: Block, knobs: Knobs, throw: Throw) -> State:
    """State of a block at its start, with the velocity of half a step before."""
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
    """Observed response of a block before its first step; the matrix is computed as in steps."""
    r = turn_of(s)
    along, across, tilt, _yaw = turns_of(block, r.r13, r.r23, r.r33, s.qz, s.qw)
    return start_peaks(along, across, tilt)


@wp.func
def set_attitude(s: State, x: real, y: real, z: real, w: real) -> State:
    """The state with another attitude."""
    n = s
    n.qx = x
    n.qy = y
    n.qz = z
    n.qw = w
    return n


@wp.func
def in_first_axes(s: State, named: Quaternion) -> State:
    """The state in the body axes of the start; `named` is the turn from these to the present."""
    x, y, z, w = compose(
        s.qx, s.qy, s.qz, s.qw, -named[0], -named[1], -named[2], named[3]
    )  # fmt: skip
    return set_attitude(s, x, y, z, w)


@wp.func
def observe_tumbling(block: Block, s: State, before: Peaks, now: Peaks) -> Peaks:
    """The observed response of a block that tumbles: its slide is that of its centre."""
    x, y = s.x - block.x, s.y - block.y
    return Peaks(
        x, y, now.rotation, now.time, now.across, now.tilt, now.yaw,
        larger(before.slide, x * x + y * y),
    )  # fmt: skip
