"""What runs of the stepped engines over stacks share: starts and what is seen.

These are the stacks whose interfaces touch at the two ends of an overlap, see shape/interface.py.
A run begins with solves at the start, from velocities of zero, until the contacts carry what they
carry at rest, or at the release. Velocities belong to half steps, so the first step starts from
velocities half a step back: -dt/2 times the settled acceleration. An interface rocks while one of
its ends has parted, see parting.py.

A func takes the entries of the matrices of a run, and what it finds it leaves in those that it
takes as `wp.ref`.
"""

import warp as wp

from warprock.kernels.modes import BROKEN, OVERTURNED, RUNNING, SLID_OFF
from warprock.kernels.parting import slack, slides, watch
from warprock.kernels.shape.interface_flat import GROUND_FACE, gap_of_end, place_on


@wp.struct
class Block:
    """One block of a stack, and where it starts; names as at the head of impulse/stack.py.

    `left` and `right` are first guesses of what is carried below it, at -x and at +x: normal
    impulses [N s], or the engine's normal multipliers [kg m].
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
    """One lane's stack.

    That is: the time at which it is first uplifted [s], 0 or NEVER, and the side to which its
    interfaces count as leaning before they turn, 1 or -1, mirrored with the stack; 0 of a stack
    that is its own mirror image.
    """

    uplift_time: real
    lean: real


@wp.func
def start_lane(
    stack: Stack, half_width: wp.ref[real], c: wp.ref[real], uplift_time: wp.ref[real],
    mode: wp.ref[int], even: wp.ref[real],
):  # fmt: skip
    """Starts a lane: its ground, which is level and has a face, its mode, and `even`.

    That is 1 of a stack that is its own mirror image, until its base moves along, else 0.
    """
    even = wp.where(stack.lean == real(0.0), real(1.0), real(0.0))
    half_width = GROUND_FACE
    c = real(1.0)
    uplift_time = stack.uplift_time
    mode = RUNNING


@wp.func
def start_block(
    block: Block, side: real, half_width: wp.ref[real], half_height: wp.ref[real],
    m: wp.ref[real], j: wp.ref[real], mu: wp.ref[real], offset: wp.ref[real],
    x: wp.ref[real], z: wp.ref[real], theta: wp.ref[real], s: wp.ref[real], c: wp.ref[real],
    peak: wp.ref[real], lean: wp.ref[real], n1: wp.ref[real], n2: wp.ref[real],
):  # fmt: skip
    """Puts a block where it starts."""
    half_width = block.half_width
    half_height = block.half_height
    m = block.inverse_mass
    j = block.inverse_inertia
    mu = block.friction
    offset = block.offset
    x = block.x
    z = block.z
    theta = block.theta
    s = sine(block.theta)
    c = cosine(block.theta)
    peak = size(block.theta)
    lean = sign_of(side)
    n1 = wp.where(lean > real(0.0), block.left, block.right)
    n2 = wp.where(lean > real(0.0), block.right, block.left)


@wp.func
def part_kept(count: int) -> real:
    """Part of the new velocities that a step keeps: all; while contacts settle, none.

    After the last of these solves -1/2: velocities half a step back.
    """
    return wp.where(count > 0, real(1.0), wp.where(count == 0, -HALF, real(0.0)))


@wp.func
def begin_step(
    v: real, count: int, mode: int, live: wp.ref[int],
    dv: wp.ref[real], hint: wp.ref[real], base: wp.ref[real], steps: wp.ref[int],
    even: wp.ref[real],
):  # fmt: skip
    """Begins a step after which the base moves at v [m/s], of a lane that lives on or not.

    Whether the lane lives on is kept in `live`: a loop that both read and wrote the modes would be
    slow. While contacts settle, v is that of the first step; the hint tells which way
    the base is about to move; then no stack is `even` any more.
    """
    hint = v - base
    even = wp.where(hint == real(0.0), even, real(0.0))
    dv = wp.where(count > 0, v - base, real(0.0))
    base = wp.where(count > 0, v, base)
    live = wp.where(count > 0 and mode == RUNNING, 1, 0)
    steps = steps + live


@wp.func
def balance(
    even: real, n1: wp.ref[real], t1: wp.ref[real], n2: wp.ref[real], t2: wp.ref[real],
    along: wp.ref[real], turning: wp.ref[real],
):  # fmt: skip
    """Impulses of two points that mirror each other, and what they leave of a block's motion.

    Of a stack that is its own mirror image (`even`) the mean of the sweeps in both orders: it moves
    upwards alone.
    """
    zero, n, t = real(0.0), HALF * (n1 + n2), HALF * (t1 - t2)
    n1 = wp.where(even > zero, n, n1)
    t1 = wp.where(even > zero, t, t1)
    n2 = wp.where(even > zero, n, n2)
    t2 = wp.where(even > zero, -t, t2)
    along = wp.where(even > zero, zero, along)
    turning = wp.where(even > zero, zero, turning)


@wp.func
def mode_after(theta: real, turn: real, overlap: real, total: real) -> int:
    """How a lane goes on with one of its blocks; `total` is finite only if its numbers are.

    A block has overturned, too, once it has turned by a right angle against what it stands on.
    """
    zero = real(0.0)
    stands = wp.where(overlap <= zero, SLID_OFF, RUNNING)
    over = larger(size(theta), size(turn)) >= HALF_PI
    return wp.where(total - total == zero, wp.where(over, OVERTURNED, stands), BROKEN)


@wp.func
def observe(
    live: bool, time: real, dt: real, gravity: real, lean: real, n1: real, n2: real, theta: real,
    below: real, ux: real, uz: real, uo: real, lo: real, half_width: real, half_height: real,
    s: real, c: real, offset: real, lhalf_width: real, lhalf_height: real, ls: real, lc: real,
    dx: real, dz: real, z: real, since: wp.ref[real], left: wp.ref[int], right: wp.ref[int],
    uplift_time: wp.ref[real], moved: wp.ref[real], deepest: wp.ref[real], impacts: wp.ref[int],
    peak: wp.ref[real], peak_time: wp.ref[real], slide: wp.ref[real], peak_slide: wp.ref[real],
    crept: wp.ref[real], mode: wp.ref[int],
):  # fmt: skip
    """What a step shows of a block and of the interface below it, and whether its lane lives on.

    Args:
        live: Whether the lane still runs.
        time: End of the step [s], before 0 while contacts settle.
        dt: Time step [s].
        gravity: Acceleration of gravity [m/s^2].
        lean: Side to which the interface leaned in the step, 1 or -1.
        n1, n2: What the end away from there carried, and the other end.
        theta, below: Rotations of the block and of what it stands on, after the step [rad].
        ux, uz, uo, lo: Velocity and angular velocity of the block, which must be finite; angular
            velocity of what it stands on. (The sum of the first three as one argument costs a
            sixth of the speed of `impulse`.)
        half_width: See `place_on` in shape/interface.py, as all up to dz. z: its height [m].
        since: See `watch` in parting.py, as all up to impacts; left: the end at -x, right: at +x.
        deepest: Deepest penetration so far [m].
        peak, peak_time: Largest |theta| so far [rad] and its time [s].
        slide, peak_slide: Slide along what the block stands on [m], and the largest so far.
        crept: Way by which it slipped in the step [m]. A block slides if it slips on the same way
            in the next step, too: sweeps that end early can move a block that sticks to and fro.
        mode: How the lane goes on.
    """
    turn = theta - below
    slid, overlap = place_on(
        half_width, half_height, s, c, offset, lhalf_width, lhalf_height, ls, lc, dx, dz, turn
    )
    gap1 = gap_of_end(
        real(-1.0), half_width, half_height, s, c, lhalf_width, lhalf_height, ls, lc, dx, dz
    )
    gap2 = gap_of_end(
        real(1.0), half_width, half_height, s, c, lhalf_width, lhalf_height, ls, lc, dx, dz
    )
    limit = slack(dt, gravity, half_width + half_height, uo * uo + lo * lo, half_height + size(z))
    forward = lean > real(0.0)
    way = slid - slide
    glides = slides(way, dt, gravity) and slides(crept, dt, gravity) and way * crept > real(0.0)
    crept = way
    watch(
        live, larger(time, real(0.0)), limit, wp.where(forward, n1, n2), gap1,
        wp.where(forward, n2, n1), gap2, glides, since, left, right, uplift_time, moved, impacts,
    )  # fmt: skip
    # A block that has overturned has turned past a right angle: that pose does not count.
    stands = live and size(theta) < HALF_PI
    deepest = wp.where(stands, larger(-smaller(gap1, gap2), deepest), deepest)
    higher = live and size(theta) > peak
    peak_time = wp.where(higher, time, peak_time)
    peak = wp.where(higher, smaller(size(theta), HALF_PI), peak)
    slide = slid
    peak_slide = wp.where(live, larger(size(slid), peak_slide), peak_slide)
    found = mode_after(theta, turn, overlap, theta + ux + uz + uo + overlap)
    mode = wp.where(live and mode == RUNNING, found, mode)
