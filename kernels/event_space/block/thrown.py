"""Blocks in space that start in motion and may tumble, in event_space/block_run.py.

A corner that moves into the base at the start makes an inelastic impact. If a block tumbles, the
face that looks down becomes its bottom between two steps (shape_space/thrown.py), so that the step
itself handles one bottom face only. The slide is the displacement of its centre along the base.
"""

import warp as wp

from warprock.kernels.algebra.vectors import Quaternion, Vector
from warprock.kernels.event_space.block.contact import FLAT, FLYING, Corners, mask_of, stance_of
from warprock.kernels.event_space.block.moves import body_at
from warprock.kernels.event_space.block.seen import Seen, peaks_at
from warprock.kernels.event_space.block.step import DUST, solve
from warprock.kernels.event_space.block.trial import State, kinetic_energy
from warprock.kernels.event_space.lane import Limits
from warprock.kernels.lane.modes import UNSOLVED
from warprock.kernels.shape_space.block import Block
from warprock.kernels.shape_space.thrown import Throw, compose, old_corner


@wp.func
def start_thrown(block: Block, limits: Limits, throw: Throw, at_rest: State) -> State:
    """The state at the start with its velocities; if a corner moves into the base, after impact."""
    s = at_rest
    s.v = Vector(throw.vx, throw.vy, throw.vz)
    s.w = Vector(throw.wx, throw.wy, throw.wz)
    if s.stance != FLYING:
        body = body_at(block, s.q)
        speed = wp.length(s.v) + wp.length(s.w) * block.half_height
        grain = DUST * (speed + limits.gravity * limits.longest_step)
        h = solve(body, s.stance, 0, Corners(), s.v, s.w, grain)
        s.lost = kinetic_energy(body, s.v, s.w) - kinetic_energy(body, h.v, h.w)
        s.v = h.v
        s.w = h.w
        s.stance = h.stance
        s.slip = h.slip
        s.mode = wp.where(h.fits, s.mode, UNSOLVED)
    return s


@wp.func
def corners_after(mask: int, gx: real, gy: real, gw: real) -> int:
    """Mask of corners of the old bottom, a sum of 2^k, in the numbers of the new bottom."""
    found = int(0)
    for k in range(4):
        old = old_corner(k, gx, gy, gw)
        if old >= 0 and (mask & (1 << old)) != 0:
            found = found | (1 << k)
    return found


@wp.func
def rename_axes(s: State, gx: real, gy: real, gw: real) -> State:
    """The state in renamed axes."""
    n = s
    x, y, z, w = compose(s.q[0], s.q[1], s.q[2], s.q[3], gx, gy, real(0.0), gw)
    n.q = Quaternion(x, y, z, w)
    n.stance = stance_of(corners_after(mask_of(s.stance), gx, gy, gw))
    along = corners_after(s.slip & 15, gx, gy, gw)
    n.slip = along | (corners_after(s.slip >> 4, gx, gy, gw) << 4)
    return n


@wp.func
def own_axes(q: Quaternion, named: Quaternion) -> Quaternion:
    """Attitude of the body axes of the start."""
    x, y, z, w = compose(q[0], q[1], q[2], q[3], -named[0], -named[1], -named[2], named[3])
    return Quaternion(x, y, z, w)


@wp.func
def observe_tumbling(block: Block, before: Seen, s0: State, s: State, named: Quaternion) -> Seen:
    """The observed response of a block that tumbles, after a step."""
    seen = before
    seen.leaf = peaks_at(block, before.leaf, own_axes(s.q, named), s.time)
    x, y = s.x[0] - block.x, s.x[1] - block.y
    seen.leaf.slide_x = x
    seen.leaf.slide_y = y
    seen.leaf.peak_slide = larger(x * x + y * y, seen.leaf.peak_slide)
    rested = s0.stance == FLAT and s0.slip == 0
    if s.stance != FLAT or s.slip != 0:
        seen.rest_time = NEVER
    elif not rested:
        seen.rest_time = s.time
    return seen
