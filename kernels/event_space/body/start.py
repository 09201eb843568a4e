"""Bodies in space that start in motion, in the event step, and those that tumble.

A point that moves into the base at the start makes an impact. The lane of a body that
tumbles keeps running on whatever side it lies; its slide is the displacement of its centre.
"""

import warp as wp

from warprock.kernels.algebra.vectors import Vector
from warprock.kernels.event_space.body.contact import Shape, pose_of, touches_of
from warprock.kernels.event_space.body.law import solve
from warprock.kernels.event_space.body.step import State, energy
from warprock.kernels.event_space.lane import Limits
from warprock.kernels.lane.modes import OVERTURNED, RUNNING, UNSOLVED
from warprock.kernels.shape_space.block import Block
from warprock.kernels.shape_space.block_found import BlockResult
from warprock.kernels.shape_space.body import Frame

if BOUNCES:
    from warprock.kernels.event_space.body.bounce import bounce


@wp.func
def start_thrown(body: Shape, limits: Limits, frame: Frame, at_rest: State) -> State:
    """The state at the start with its velocities; if a point moves into the base, after impact."""
    s = at_rest
    v, w = Vector(frame.vx, frame.vy, frame.vz), Vector(frame.wx, frame.wy, frame.wz)
    if wp.length_sq(v) + wp.length_sq(w) > real(0.0):
        pose = pose_of(body, s.x, s.q)
        s.v = v
        s.w = w
        if not s.flies:
            dust = limits.gravity * limits.longest_step
            if BOUNCES:
                leaps = bounce(body, pose, s.touch, dust, v, w)
                c = leaps.carried
                s.touch = leaps.touch
                s.flies = s.touch == wp.uint64(0)
            else:
                c = solve(body, pose, touches_of(body, pose.turn, s.touch), dust, v, w)
            s.lost = energy(limits, pose, v, w) - energy(limits, pose, c.v, c.w)
            s.v = c.v
            s.w = c.w
            s.mode = wp.where(c.fits, s.mode, UNSOLVED)
        s.swing = s.w
    return s


@wp.func
def keep_running(frame: Frame, s: State) -> State:
    """The state, with a running mode if the body tumbles: it may lie on any side."""
    n = s
    if frame.tumbles == 1 and n.mode == OVERTURNED:
        n.mode = RUNNING
    return n


@wp.func
def observe_tumbling(frame: Frame, block: Block, before: BlockResult, now: BlockResult, s: State):
    """The observed response of a body; if it tumbles, its slide is that of its centre."""
    leaf = now
    if frame.tumbles == 1:
        leaf.slide_x = s.x[0] - block.x
        leaf.slide_y = s.x[1] - block.y
        way = leaf.slide_x * leaf.slide_x + leaf.slide_y * leaf.slide_y
        leaf.peak_slide = larger(way, before.peak_slide)
    return leaf
