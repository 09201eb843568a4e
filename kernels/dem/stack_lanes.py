"""What becomes of lanes of soft-spring blocks: how they step, and what is seen of them.

Blocks in space take `passes_left`, `time_past` and `observe_faces` from here.
"""

import warp as wp

from warprock.kernels.dem.stack import Base, Energy, Knobs, Pace
from warprock.kernels.modes import BROKEN, OVERTURNED, RUNNING, SLID_OFF
from warprock.kernels.parting import slides
from warprock.kernels.shape.interface import Velocity
from warprock.kernels.shape.stack_found import Seen

PIVOT = real(0.75)
"""Place up to which faces that have parted gape, from the middle, over the way to the end. Of five
sub-contacts only the last one then carries, which is when a rigid block lifts; of many, the
resultant has moved by 0.92 of the way. In space the end is the corner that is pressed most."""
APART = real(-1.0)
"""What an interface that has parted keeps for the time since which it gapes."""


@wp.func
def passes_left(until: real, steps: int, dt: real, mode: int) -> int:
    """Steps that a lane has to take to reach a time; may be one too many."""
    left = (until - real(steps) * dt) / dt
    running = mode == RUNNING and left > real(0.0)
    return wp.where(running, int(wp.ceil(wp.where(running, left, real(0.0)))) + 1, 0)


@wp.func
def time_past(until: real, steps: int, dt: real, mode: int) -> real:
    """Time by which a lane that still runs has passed a sample [s]."""
    return wp.where(mode == RUNNING, larger(real(steps) * dt - until, real(0.0)), real(0.0))


@wp.func
def observe_faces(
    live: bool, time: real, overlap: real, tilt: real, shared: real, slips: bool,
    since: wp.ref[real], seen: wp.ref[Seen],
):  # fmt: skip
    """Whether an interface rocks or slides, whether it has landed, and whether it is still there.

    Args:
        live: Whether the lane still runs.
        time: Time [s].
        overlap: Depth to which the faces overlap in the middle of what they share [m].
        tilt: By how much it is deeper at the end, or corner, where it is deepest [m].
        shared: How much they share.
        slips: Whether the faces slip.
        since: Time since which the middle gapes [s]: APART once it has parted, NEVER if closed.
        seen: What is seen of the lane: impacts are interfaces that have landed.
    """
    zero = real(0.0)
    gapes = overlap <= zero
    was = since < zero
    apart = gapes and (was or overlap + PIVOT * tilt <= zero)
    opened = wp.where(gapes, smaller(since, time), NEVER)
    lifts = live and apart and not was
    seen.uplift_time = wp.where(lifts, smaller(seen.uplift_time, opened), seen.uplift_time)
    seen.moved = wp.where(live and (apart or (slips and not gapes)), time, seen.moved)
    seen.impacts = seen.impacts + wp.where(live and was and not gapes, 1, 0)
    since = wp.where(live, wp.where(apart, APART, opened), since)
    deeper = larger(overlap + tilt, seen.deepest)
    seen.deepest = wp.where(live and shared > zero, deeper, seen.deepest)
    seen.mode = wp.where(live and shared <= zero, SLID_OFF, seen.mode)


@wp.struct
class Seat:
    """How a block sits on what is below it.

    Attributes:
        since: Time since which its interface gapes, see `observe_faces` [s].
        place: Where it is along that, as its interface was last seen [m].
        slide: How far it has slid [m].
    """

    since: real
    place: real
    slide: real


@wp.func
def lost_so_far(energy: Energy) -> real:
    """What springs and dampers have taken from the blocks before this step [J]."""
    return energy.spent - (energy.stored - energy.at_start)


@wp.func
def begin_step(until: real, mode: int, pace: wp.ref[Pace], energy: wp.ref[Energy]) -> real:
    """Begins a step of a lane, if it runs and has not reached a time [s].

    Returns:
        What is lost so far [J], see `lost_so_far`.
    """
    runs = mode == RUNNING and real(pace.steps) * pace.dt < until
    pace.span = wp.where(pace.steps == 0, HALF * pace.dt, pace.dt)
    energy.at_start = wp.where(pace.steps == 1, energy.stored, energy.at_start)
    lost = lost_so_far(energy)
    energy.stored = wp.where(runs, real(0.0), energy.stored)
    energy.spent = wp.where(runs, energy.loss, energy.spent)
    pace.live = wp.where(runs, 1, 0)
    pace.steps = pace.steps + pace.live
    return lost


@wp.func
def move_base(v: real, rise: real, live: int, base: Base) -> Base:
    """Takes the base of a lane to the velocities v along x and `rise` upwards [m/s]."""
    return Base(
        wp.where(live == 1, v, base.vx), v - base.vx,
        wp.where(live == 1, rise, base.vz), rise - base.vz,
    )  # fmt: skip


@wp.func
def glides(pace: Pace, knobs: Knobs, held: int, speed: real) -> bool:
    """Whether an interface slides that slips at a speed [m/s]; `held` springs do not slip."""
    return held == 0 and slides(pace.dt * speed, pace.dt, knobs.gravity)


@wp.func
def observe_interface(
    pace: Pace, overlap: real, tilt: real, shared: real, slips: bool, since: wp.ref[real],
    seen: wp.ref[Seen],
):  # fmt: skip
    """What a step shows of an interface as it begins, see `observe_faces`."""
    time = real(pace.steps - 1) * pace.dt
    observe_faces(pace.live == 1, time, overlap, tilt, shared, slips, since, seen)


@wp.func
def mode_after(live: bool, theta: real, u: Velocity, slid: real, mode: int) -> int:
    """How a lane goes on after a step of one of its blocks.

    Args:
        live: Whether it still runs.
        theta: Rotation of the block [rad].
        u: Velocity of the block.
        slid: Slide of the block [m].
        mode: How it goes on as far as is known.
    """
    zero, speed = real(0.0), u.x + u.z + u.omega
    sound = theta - theta == zero and speed - speed == zero and slid - slid == zero
    over = wp.where(size(theta) >= HALF_PI and mode != BROKEN, OVERTURNED, mode)
    return wp.where(live, wp.where(sound, over, BROKEN), mode)
