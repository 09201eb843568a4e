"""Starts and observed response of stacks, shared by the stepped engines.

The interfaces of these stacks touch at the two ends of an overlap, see shape/interface.py. A run
begins with solves at the start, from velocities of zero, until the contacts carry the loads at rest
or at the release. Velocities belong to half steps, so the first step starts with those of half a
step earlier, -dt/2 times the settled acceleration. An interface rocks while one of its ends has
parted, see parting.py.
"""

from typing import Any

import warp as wp

from warprock.kernels.contact.parting import Bearing, Parting, observe_ends, slack, slides
from warprock.kernels.lane.modes import BROKEN, OVERTURNED, RUNNING, SLID_OFF
from warprock.kernels.shape.interface import (
    GROUND_FACE,
    Box,
    Impulse,
    Mass,
    Pose,
    Velocity,
    gap_of_end,
    place_on,
)
from warprock.kernels.shape.stack_found import Peaks, Seen, observe_peaks


@wp.struct
class Block:
    """One block of a stack, and where it starts; units as in shape/interface.py.

    `offset` is its slide at the start. `left` and `right` are first guesses of the normal impulses
    [N s], or normal multipliers of the engine [kg m], below it at -x and at +x.
    """

    half_width: real
    half_height: real
    inverse_mass: real
    inverse_inertia: real
    friction: real
    offset: real
    x: real
    z: real
    theta: real
    left: real
    right: real


@wp.struct
class Stack:
    """The stack of a lane at its start.

    Its uplift time [s], 0 or NEVER, and the side to which its interfaces count as leaning before
    they rotate: 1 or -1, mirrored with the stack; 0 for a stack that is its own mirror image.
    """

    uplift_time: real
    lean: real


@wp.struct
class Base:
    """The base of a lane.

    Attributes:
        v: Its velocity along x [m/s].
        gain: Gain of that in this step [m/s].
        hint: Present or next gain, for the lean of blocks that do not move yet [m/s].
        rising, rise: Its velocity upwards, and the gain of that in this step [m/s].
    """

    v: real
    gain: real
    hint: real
    rising: real
    rise: real


@wp.struct
class Lane:
    """Whether a lane still runs in this step, 1 or 0, and whether it is `even`.

    `even` is 1 for a stack that is its own mirror image, until its base moves along x; else 0.
    """

    live: int
    even: real


@wp.struct
class Interface:
    """The interface below a block: friction coefficient, and the side to which it leans, -1 or 1.

    The first of its points is the one away from that side.
    """

    friction: real
    lean: real


@wp.struct
class Slide:
    """Slide of a block along the face below it.

    Attributes:
        start: Place of the block without slide [m], see `place_on` in shape/interface.py.
        now: Slide [m].
        way: Change of the slide in the last step [m].
    """

    start: real
    now: real
    way: real


@wp.func
def ground() -> Box:
    """The ground as a box: no block reaches the ends of its face."""
    return Box(GROUND_FACE, real(0.0))


@wp.func
def box_of(block: Any) -> Box:
    """The half sizes of a block."""
    return Box(block.half_width, block.half_height)


@wp.func
def mass_of(block: Any) -> Mass:
    """The inverse mass and inverse moment of inertia of a block."""
    return Mass(block.inverse_mass, block.inverse_inertia)


@wp.func
def start_pose(block: Any) -> Pose:
    """The pose of a block at its start."""
    return Pose(block.x, block.z, block.theta, sine(block.theta), cosine(block.theta))


@wp.func
def start_lane(stack: Stack) -> Lane:
    """A lane before its first step."""
    return Lane(0, wp.where(stack.lean == real(0.0), real(1.0), real(0.0)))


@wp.func
def start_impulses(block: Block, lean: real):
    """First guesses of the impulses at the end away from a side, and at the other."""
    zero, ahead = real(0.0), lean > real(0.0)
    one = Impulse(wp.where(ahead, block.left, block.right), zero)
    return one, Impulse(wp.where(ahead, block.right, block.left), zero)


@wp.func
def part_kept(count: int) -> real:
    """Factor by which a step keeps the new velocities: 1; while contacts settle, 0.

    After the last of the settling solves it is -1/2: velocities of half a step earlier.
    """
    return wp.where(count > 0, real(1.0), wp.where(count == 0, -HALF, real(0.0)))


@wp.func
def part_of(kept: real, u: Velocity) -> Velocity:
    """A velocity times the factor of `part_kept`."""
    return Velocity(kept * u.x, kept * u.z, kept * u.omega)


@wp.func
def move_base(v: real, count: int, base: Base) -> Base:
    """The base in a step after which its velocity along x is v [m/s].

    While contacts settle, v is that of the first step, and only `hint` depends on it.
    """
    hint, moves = v - base.v, count > 0
    gain = wp.where(moves, hint, real(0.0))
    return Base(wp.where(moves, v, base.v), gain, hint, base.rising, base.rise)


@wp.func
def begin_step(count: int, mode: int, hint: real, lane: Lane) -> Lane:
    """Whether a lane still runs in a step, and whether it is still even.

    The former is kept beside the mode, since a loop that reads and writes the modes is slow.
    """
    live = wp.where(count > 0 and mode == RUNNING, 1, 0)
    return Lane(live, wp.where(hint == real(0.0), lane.even, real(0.0)))


@wp.func
def swap_unless(same: bool, one: wp.ref[Impulse], two: wp.ref[Impulse]):
    """Swaps the impulses of two points, unless the order of the points is the same."""
    n = real(one.n)
    t = real(one.t)
    one.n = wp.where(same, n, two.n)
    one.t = wp.where(same, t, two.t)
    two.n = wp.where(same, two.n, n)
    two.t = wp.where(same, two.t, t)


@wp.func
def balance(
    even: real, one: wp.ref[Impulse], two: wp.ref[Impulse], along: wp.ref[real],
    turning: wp.ref[real],
):  # fmt: skip
    """Impulses of two points that are mirror images, and the velocity of their block.

    A stack that is its own mirror image (`even`) takes the mean of the sweeps in both orders, so
    that it can only move upwards.
    """
    zero, n, t = real(0.0), HALF * (one.n + two.n), HALF * (one.t - two.t)
    one.n = wp.where(even > zero, n, one.n)
    one.t = wp.where(even > zero, t, one.t)
    two.n = wp.where(even > zero, n, two.n)
    two.t = wp.where(even > zero, -t, two.t)
    along = wp.where(even > zero, zero, along)
    turning = wp.where(even > zero, zero, turning)


@wp.func
def mode_after(theta: real, turn: real, overlap: real, total: real) -> int:
    """Mode of a lane after a step, by one of its blocks; `total` is finite if its numbers are.

    A block has also overturned once it is at a right angle to the body below.
    """
    zero = real(0.0)
    stands = wp.where(overlap <= zero, SLID_OFF, RUNNING)
    over = larger(size(theta), size(turn)) >= HALF_PI
    return wp.where(total - total == zero, wp.where(over, OVERTURNED, stands), BROKEN)


@wp.struct
class Step:
    """A step of a lane.

    Attributes:
        live: 1 if the lane still runs, else 0.
        time: End of the step [s]; negative while contacts settle.
        dt: Its length [s].
        gravity: Acceleration of gravity [m/s^2].
    """

    live: int
    time: real
    dt: real
    gravity: real


@wp.struct
class View:
    """An interface after a step.

    Attributes:
        theta: Rotation of the block above it [rad].
        turn: Rotation of the block relative to the body below [rad].
        place: Place of the block along that [m], see `place_on` in shape/interface.py.
        overlap: Width of the overlap of the faces [m].
        limit: Gap beyond which a point has parted [m], see `slack` in parting.py.
        total: Finite if the numbers of the block are.
    """

    theta: real
    turn: real
    place: real
    overlap: real
    limit: real
    total: real


@wp.func
def view_interface(
    step: Step, box: Box, at: Pose, low_box: Box, below: Pose, u: Velocity, low_omega: real
) -> View:
    """The interface below a block after a step.

    Args:
        step: The step.
        box, at: The block and its pose.
        low_box, below: The body below and its pose.
        u: Velocity of the block.
        low_omega: Angular velocity of the body below [rad/s].
    """
    place, overlap = place_on(box, at, low_box, below)
    reach, square = box.half_width + box.half_height, u.omega * u.omega + low_omega * low_omega
    limit = slack(step.dt, step.gravity, reach, square, box.half_height + size(at.z))
    total = at.theta + u.x + u.z + u.omega + overlap
    return View(at.theta, at.theta - below.theta, place, overlap, limit, total)


@wp.func
def bearings(lean: real, n1: real, n2: real, box: Box, at: Pose, low_box: Box, below: Pose):
    """The ends of an interface at -x and at +x after a step.

    Args:
        lean: Side to which the interface leaned in the step.
        n1, n2: Normal impulses of the end away from that side, and of the other.
        box: See `find_end` in shape/interface.py, like all arguments after it.
    """
    minus, forward = real(-1.0), lean > real(0.0)
    left = gap_of_end(minus, box, at, low_box, below)
    right = gap_of_end(-minus, box, at, low_box, below)
    return (
        Bearing(wp.where(forward, n1, n2), left), Bearing(wp.where(forward, n2, n1), right),
    )  # fmt: skip


@wp.func
def observe_slide(step: Step, place: real, slide: wp.ref[Slide]) -> bool:
    """Slide of a block after a step, and whether the block slides.

    It slides if it slips the same way in two steps: sweeps that end early can move a sticking block
    to and fro.
    """
    now = place - slide.start
    way = now - slide.now
    slips = slides(way, step.dt, step.gravity) and slides(slide.way, step.dt, step.gravity)
    slips = slips and way * slide.way > real(0.0)
    slide.now = now
    slide.way = way
    return slips


@wp.func
def observe_block(
    step: Step, view: View, depth: real, slide: real, peaks: wp.ref[Peaks], seen: wp.ref[Seen]
):
    """Updates the peaks of a block and the response of its lane after a step.

    Args:
        step: The step.
        view: The interface below the block.
        depth: Penetration there [m].
        slide: Slide of the block [m].
        peaks: Its peaks so far.
        seen: Observed response of the lane.
    """
    live = step.live > 0
    peaks = observe_peaks(live, step.time, view.theta, slide, peaks)
    seen.deepest = wp.where(live, larger(depth, seen.deepest), seen.deepest)
    found = mode_after(view.theta, view.turn, view.overlap, view.total)
    seen.mode = wp.where(live and seen.mode == RUNNING, found, seen.mode)


@wp.func
def observe(
    step: Step, view: View, left: Bearing, right: Bearing, parting: wp.ref[Parting],
    slide: wp.ref[Slide], peaks: wp.ref[Peaks], seen: wp.ref[Seen],
):  # fmt: skip
    """Updates the response of a lane by a block and the interface below it after a step.

    Args:
        step: The step.
        view: The interface.
        left, right: Its end at -x and its end at +x.
        parting: What is kept of both ends.
        slide: Slide of the block.
        peaks: Its peaks so far.
        seen: Observed response of the lane.
    """
    zero = real(0.0)
    slips = observe_slide(step, view.place, slide)
    time = larger(step.time, zero)
    observe_ends(step.live > 0, time, view.limit, slips, left, right, parting, seen)
    # The rotation of an overturned block exceeds a right angle: that pose does not count.
    deepest = -smaller(left.gap, right.gap)
    depth = wp.where(size(view.theta) < HALF_PI, deepest, zero)
    observe_block(step, view, depth, slide.now, peaks, seen)
