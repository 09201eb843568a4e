"""What runs of the stepped engines over stacks share, for one precision: starts and what is seen.

These are the stacks whose interfaces touch at the two ends of an overlap, see `impulse_stack`. A
run begins with solves at the start, from velocities of zero, so that what contacts carry becomes
that of the rest or of the release. Half a step back from the acceleration that they leave lie the
velocities that the first step starts from: velocities belong to half steps. An interface
rocks while one of its ends has parted, see `parting`.

A func takes the entries of the matrices of a run, and what it finds it leaves in those that it
takes as `wp.ref`.
"""

import warp as wp

from warprock.kernels.impulse.stack import GROUND_FACE, meet, stand
from warprock.kernels.modes import BROKEN, OVERTURNED, RUNNING, SLID_OFF
from warprock.kernels.parting import slack, slides, watch


@wp.struct
class Block:
    """One block of a stack, and where it starts; names as at the head of `impulse_stack`.

    `left` and `right` are first guesses of what is carried below it, at -x and at +x: normal
    impulses [N s], or the engine's normal multipliers [kg m].
    """

    face: real
    high: real
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
    interfaces count as leaning before they turn, 1 or -1, mirrored with the stack.
    """

    uplift_time: real
    lean: real


@wp.func
def begin(
    stack: Stack, face: wp.ref[real], c: wp.ref[real], uplift_time: wp.ref[real],
    mode: wp.ref[int],
):  # fmt: skip
    """Lays the ground, which has a face and is level, and sets a lane going."""
    face = GROUND_FACE
    c = real(1.0)
    uplift_time = stack.uplift_time
    mode = RUNNING


@wp.func
def set_up(
    block: Block, side: real, face: wp.ref[real], high: wp.ref[real],
    m: wp.ref[real], j: wp.ref[real], mu: wp.ref[real], offset: wp.ref[real],
    x: wp.ref[real], z: wp.ref[real], theta: wp.ref[real], s: wp.ref[real], c: wp.ref[real],
    peak: wp.ref[real], lean: wp.ref[real], n1: wp.ref[real], n2: wp.ref[real],
):  # fmt: skip
    """Puts a block where it starts."""
    face = block.face
    high = block.high
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
    lean = side
    n1 = wp.where(side > real(0.0), block.left, block.right)
    n2 = wp.where(side > real(0.0), block.right, block.left)


@wp.func
def kept_of(count: int) -> real:
    """Part of the new velocities that a step keeps: while contacts settle they are put back."""
    return wp.where(count > 0, real(1.0), wp.where(count == 0, -HALF, real(0.0)))


@wp.func
def ride(
    v: real, count: int, mode: int, live: wp.ref[int],
    dv: wp.ref[real], hint: wp.ref[real], base: wp.ref[real], steps: wp.ref[int],
):  # fmt: skip
    """Begins a step after which the base moves at v [m/s], of a lane that lives on or not.

    That is kept in `live`, for the loop that writes the modes would be slow if it read them to
    tell what moves. While contacts settle, v is that of the first step; the hint tells which way
    the base is about to move.
    """
    hint = v - base
    dv = wp.where(count > 0, v - base, real(0.0))
    base = wp.where(count > 0, v, base)
    live = wp.where(count > 0 and mode == RUNNING, 1, 0)
    steps = steps + live


@wp.func
def gape(
    side: real, face: real, high: real, s: real, c: real,
    lface: real, lhigh: real, ls: real, lc: real, dx: real, dz: real,
) -> real:  # fmt: skip
    """How wide an end of an interface gapes [m]; arguments as in `impulse_stack.meet`."""
    nx, nz, au, bu = real(0.0), real(0.0), real(0.0), real(0.0)
    al, bl, gap = real(0.0), real(0.0), real(0.0)
    meet(side, face, high, s, c, lface, lhigh, ls, lc, dx, dz, nx, nz, au, bu, al, bl, gap)
    return gap


@wp.func
def became(theta: real, turn: real, overlap: real, total: real) -> int:
    """How a lane goes on with one of its blocks; `total` is finite only if its numbers are.

    A block has overturned, too, once it has turned by a right angle against what it stands on.
    """
    zero = real(0.0)
    stands = wp.where(overlap <= zero, SLID_OFF, RUNNING)
    over = larger(size(theta), size(turn)) >= HALF_PI
    return wp.where(total - total == zero, wp.where(over, OVERTURNED, stands), BROKEN)


@wp.func
def witness(
    live: bool, time: real, dt: real, gravity: real, lean: real, n1: real, n2: real, theta: real,
    below: real, ux: real, uz: real, uo: real, lo: real, face: real, high: real, s: real, c: real,
    offset: real, lface: real, lhigh: real, ls: real, lc: real, dx: real, dz: real, z: real,
    since: wp.ref[real], left: wp.ref[int], right: wp.ref[int], uplift_time: wp.ref[real],
    moved: wp.ref[real], deepest: wp.ref[real], impacts: wp.ref[int], peak: wp.ref[real],
    peak_time: wp.ref[real], slide: wp.ref[real], peak_slide: wp.ref[real], crept: wp.ref[real],
    mode: wp.ref[int],
):  # fmt: skip
    """What a step shows of a block and of the interface below it, and whether its lane lives on.

    Args:
        live: Whether the lane still runs.
        time: End of the step [s], before 0 while contacts settle.
        dt: Time step [s].
        gravity: Acceleration of gravity [m/s^2].
        lean: Side to which the interface leaned in the step, 1 or -1.
        n1, n2: What the end away from there carried, n2 the other.
        theta, below: Rotation of the block [rad], below that of what it stands on; all after the
            step.
        ux, uz, uo: Velocity of the block, uz likewise, uo its angular one; they must be finite.
            They come one by one, for their sum as one argument costs pairs of `impulse` a sixth of
            their speed.
        lo: Angular velocity of what it stands on [rad/s].
        face: See `impulse_stack.stand`, as all up to dz.
        z: Height of the block's centre [m].
        since: See `parting.watch`, as all up to impacts; left is the end at -x, right that at +x.
        deepest: Deepest penetration so far [m].
        peak, peak_time: Largest |theta| so far [rad], peak_time its time [s].
        slide, peak_slide: Slide along what the block stands on [m], peak_slide the largest so far.
        crept: Way by which it slipped in the step [m]. What slides goes on in the next; sweeps that
            end early can let a block that sticks shuttle.
        mode: How the lane goes on.
    """
    turn = theta - below
    slid, overlap = stand(face, high, s, c, offset, lface, lhigh, ls, lc, dx, dz, turn)
    gap1 = gape(real(-1.0), face, high, s, c, lface, lhigh, ls, lc, dx, dz)
    gap2 = gape(real(1.0), face, high, s, c, lface, lhigh, ls, lc, dx, dz)
    limit = slack(dt, gravity, face + high, uo * uo + lo * lo, high + size(z))
    forward = lean > real(0.0)
    way = slid - slide
    glides = slides(way, dt, gravity) and slides(crept, dt, gravity) and way * crept > real(0.0)
    crept = way
    watch(
        live, larger(time, real(0.0)), limit, wp.where(forward, n1, n2), gap1,
        wp.where(forward, n2, n1), gap2, glides, since, left, right, uplift_time, moved, impacts,
    )  # fmt: skip
    # The pose past a right angle in which a block has overturned is not an answer.
    stands = live and size(theta) < HALF_PI
    deepest = wp.where(stands, larger(-smaller(gap1, gap2), deepest), deepest)
    higher = live and size(theta) > peak
    peak_time = wp.where(higher, time, peak_time)
    peak = wp.where(higher, smaller(size(theta), HALF_PI), peak)
    slide = slid
    peak_slide = wp.where(live, larger(size(slid), peak_slide), peak_slide)
    found = became(theta, turn, overlap, theta + ux + uz + uo + overlap)
    mode = wp.where(live and mode == RUNNING, found, mode)


@wp.func
def shown(mode: int, past: real, theta: real, omega: real) -> real:
    """Rotation at a sample that a lane has passed by a time [s]; where it ended, its last one.

    Nothing stops the velocities of a lane that has ended, they need not be finite.
    """
    back = larger(past, real(0.0)) * omega
    return theta - wp.where(mode == RUNNING, back, real(0.0))
