"""Lanes of soft-spring blocks: their clock, their energy account, and their observed response.

Blocks in space use `passes_left`, `time_past` and `observe_faces` of this file.
"""

import warp as wp

from warprock.kernels.contact.parting import slides
from warprock.kernels.dem.stack import Base, Energy, Knobs, Pace
from warprock.kernels.lane.modes import BROKEN, OVERTURNED, RUNNING, SLID_OFF
from warprock.kernels.shape.interface import Velocity
from warprock.kernels.shape.stack_found import Seen

PIVOT = real(0.75)
"""Place up to which faces that have parted gape, from the middle, over the way to the end. Of five
sub-contacts only the last one then carries, which is when a rigid block lifts; of many, the
resultant has moved by 0.92 of the way. In space the end is the corner that is pressed most."""
APART = real(-1.0)
"""Value of `since` for an interface that has parted, see `observe_faces`."""


@wp.func
def passes_left(until: real, steps: int, dt: real, mode: int) -> int:
    """Number of steps that a lane needs to reach a time; may be one too many."""
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
    """Updates a lane by an interface: whether it rocks or slides, has landed, and still exists.

    Args:
        live: Whether the lane still runs.
        time: Time [s].
        overlap: Penetration in the middle of the shared part of the faces [m].
        tilt: Penetration at the deepest end, or corner, less that in the middle [m].
        shared: Size of the shared part of the faces.
        slips: Whether the faces slip.
        since: Time since which the middle is open [s]: APART once it has parted, NEVER if closed.
        seen: Observed response of the lane; an interface that lands is an impact.
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
    """Contact and slide of a block on the face below.

    Attributes:
        since: Time since which its interface is open, see `observe_faces` [s].
        place: Its last observed place along the face below [m].
        slide: Its slide [m].
    """

    since: real
    place: real
    slide: real


@wp.func
def dissipated_energy(energy: Energy) -> real:
    """Energy that springs and dampers have taken from the blocks before this step [J]."""
    return energy.spent - (energy.stored - energy.at_start)


@wp.func
def begin_step(until: real, mode: int, pace: wp.ref[Pace], energy: wp.ref[Energy]) -> real:
    """Begins a step of a lane, if it runs and has not reached a time [s].

    Returns:
        Energy lost so far [J], see `dissipated_energy`.
    """
    runs = mode == RUNNING and real(pace.steps) * pace.dt < until
    pace.span = wp.where(pace.steps == 0, HALF * pace.dt, pace.dt)
    energy.at_start = wp.where(pace.steps == 1, energy.stored, energy.at_start)
    lost = dissipated_energy(energy)
    energy.stored = wp.where(runs, real(0.0), energy.stored)
    energy.spent = wp.where(runs, energy.loss, energy.spent)
    pace.live = wp.where(runs, 1, 0)
    pace.steps = pace.steps + pace.live
    return lost


@wp.func
def move_base(v: real, rise: real, live: int, base: Base) -> Base:
    """The base of a lane with the new velocities v along x and `rise` upwards [m/s]."""
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
    """Observes an interface at the start of a step, see `observe_faces`."""
    time = real(pace.steps - 1) * pace.dt
    observe_faces(pace.live == 1, time, overlap, tilt, shared, slips, since, seen)


@wp.func
def mode_after(live: bool, theta: real, u: Velocity, slid: real, mode: int) -> int:
    """Mode of a lane after a step of one of its blocks.

    Args:
        live: Whether it still runs.
        theta: Rotation of the block [rad].
        u: Velocity of the block.
        slid: Slide of the block [m].
        mode: Its mode before.
    """
    zero, speed = real(0.0), u.x + u.z + u.omega
    sound = theta - theta == zero and speed - speed == zero and slid - slid == zero
    over = wp.where(size(theta) >= HALF_PI and mode != BROKEN, OVERTURNED, mode)
    return wp.where(live, wp.where(sound, over, BROKEN), mode)
