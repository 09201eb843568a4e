"""Lanes of the soft-spring kernel of blocks in space: start, clock and observed response.

Observed rotations are tangents, see shape_space/block_found.py. `since`, the time since which an
interface is open, is that of `observe_faces`.
"""

import warp as wp

from warprock.kernels.dem.stack import Energy
from warprock.kernels.dem.stack_lanes import observe_faces
from warprock.kernels.dem_space.stack import Pace
from warprock.kernels.dem_space.stack_meet import Link
from warprock.kernels.lane.modes import BROKEN, OVERTURNED, RUNNING
from warprock.kernels.shape.stack_found import Seen
from warprock.kernels.shape_space.block import Block, turn_freely, turns_of
from warprock.kernels.shape_space.block_found import Peaks, Result, observe_turns, start_peaks
from warprock.kernels.shape_space.lanes import State, Triple, matrix_of, turn_of

Pose = wp.types.vector(length=7, dtype=real)
"""Attitude, and centre of mass [m]."""


@wp.struct
class Lane:
    """One lane: its time step [s], when it is first uplifted [s], 0 or NEVER, and where it moves.

    `moves` is the sum of 1 where its base moves along x, 2 along y and 4 along z; `creep` is the
    speed up to which faces may slip back and forth on their springs and not slide [m/s].
    """

    time_step: real
    creep: real
    uplift_time: real
    moves: int


@wp.struct
class Base:
    """How the base moves along one direction: its velocity, and the change in the step [m/s]."""

    v: real
    dv: real


@wp.func
def start_block(block: Block):
    """State and peaks of a block at its start."""
    zero = real(0.0)
    r = matrix_of(block.qx, block.qy, block.qz, block.qw)
    along, across, tilt, _yaw = turns_of(block, r.r13, r.r23, r.r33, block.qz, block.qw)
    state = State(
        block.x, block.y, block.z, block.qx, block.qy, block.qz, block.qw, zero, zero, zero,
        zero, zero, zero,
    )  # fmt: skip
    return state, start_peaks(along, across, tilt)


@wp.func
def observe_block(pace: Pace, block: Block, s: State, peaks: wp.ref[Peaks], mode: int) -> int:
    """Updates the peaks of a block after a step, see `turns_of`; returns the mode of its lane."""
    live, zero, r = pace.live == 1, real(0.0), turn_of(s)
    time = real(pace.steps) * pace.dt
    along, across, tilt, yaw = turns_of(block, r.r13, r.r23, r.r33, s.qz, s.qw)
    way = peaks.slide_x * peaks.slide_x + peaks.slide_y * peaks.slide_y
    peaks = observe_turns(live, time, along, across, tilt, size(yaw), peaks)
    peaks.slide = wp.where(live, larger(way, peaks.slide), peaks.slide)
    # A sum of numbers is finite if all of them are.
    total = s.x + s.y + s.z + s.qx + s.qy + s.qz + s.qw + peaks.slide_x + peaks.slide_y
    over = wp.where(r.r33 <= zero and mode != BROKEN, OVERTURNED, mode)
    return wp.where(live, wp.where(total - total == zero, over, BROKEN), mode)


@wp.func
def observe_interface(pace: Pace, link: Link, since: wp.ref[real], seen: wp.ref[Seen]):
    """Observes an interface of a lane at the start of a step, see `observe_faces`.

    It slides if its fastest point slips by more than `creep`, see `Lane`.
    """
    x = size(link.v1) + size(link.j1) + size(link.k1)
    y = size(link.v2) + size(link.j2) + size(link.k2)
    time = real(pace.steps - 1) * pace.dt
    observe_faces(
        pace.live == 1, time, link.overlap, size(link.over_a) + size(link.over_b), link.area,
        x * x + y * y > pace.creep * pace.creep, since, seen,
    )  # fmt: skip


@wp.func
def move_base(v: real, live: int, base: Base) -> Base:
    """The base of a lane with a new velocity v along one direction [m/s]."""
    return Base(wp.where(live == 1, v, base.v), v - base.v)


@wp.func
def begin_step(until: real, mode: int, pace: wp.ref[Pace], energy: wp.ref[Energy]):
    """Begins a step; forces act over half of the first one. Keeps the energies of the last one."""
    runs = mode == RUNNING and real(pace.steps) * pace.dt < until
    pace.span = wp.where(pace.steps == 0, HALF * pace.dt, pace.dt)
    energy.at_start = wp.where(pace.steps == 1, energy.stored, energy.at_start)
    energy.stored = wp.where(runs, real(0.0), energy.stored)
    energy.spent = wp.where(runs, energy.loss, energy.spent)
    pace.live = wp.where(runs, 1, 0)
    pace.steps = pace.steps + pace.live


@wp.func
def pose_before(block: Block, past: real, s: State) -> Pose:
    """Attitude and centre of mass of a block some time ago [s]."""
    spin, inverse = (
        Triple(s.lx, s.ly, s.lz),
        Triple(block.inverse_x, block.inverse_y, block.inverse_z),
    )
    ex, ey, ez, ew = turn_freely(s.qx, s.qy, s.qz, s.qw, spin, inverse, -past)
    return Pose(ex, ey, ez, ew, s.x - past * s.vx, s.y - past * s.vy, s.z - past * s.vz)


@wp.func
def result_of(seen: Seen, energy: Energy, steps: int) -> Result:
    """Results of a lane."""
    lost = energy.spent - (energy.stored - energy.at_start)
    return Result(seen.uplift_time, seen.moved, lost, seen.deepest, seen.impacts, seen.mode, steps)
