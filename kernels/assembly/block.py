"""Blocks of an assembly: their motion in a step, and what is seen of them and of their lane.

With the velocity v of a block before a step of length h, e what gravity and the base add to it in
the frame of the base, and the impulses J of the contacts (Moreau-Jean):

    v' = v + e + M^-1 J,    x' = x + h v'

What the contacts take of the energy is exactly  e . M (v + v') / 2 - (v'. M v' - v . M v) / 2.
"""

import warp as wp

from warprock.kernels.assembly.joint import Impulse
from warprock.kernels.lane.account import Account
from warprock.kernels.lane.modes import BROKEN, OVERTURNED, RUNNING, SLID_OFF
from warprock.kernels.shape.interface import Mass, Pose, Velocity

TURN, OVER_TURN = real(6.283185307179586), real(0.15915494309189535)
"""A whole turn [rad], and its reciprocal."""


@wp.struct
class Block:
    """A block as a launch gives it.

    Attributes:
        inverse_mass: [1/kg]; 0 of one that is fixed.
        inverse_inertia: About the centre of mass [1/(kg m^2)].
        x, z, theta: Centre of mass [m] and rotation [rad] at the start.
        reach: Distance of the farthest corner from there [m].
        fall: How far its centre sinks until it has fallen [m].
        calm: Speed up to which a corner counts as still [m/s].
    """

    inverse_mass: real
    inverse_inertia: real
    x: real
    z: real
    theta: real
    reach: real
    fall: real
    calm: real


@wp.struct
class Pull:
    """What gravity and the base add to every velocity in a step, in the frame of the base [m/s]."""

    x: real
    z: real


@wp.struct
class Peak:
    """Largest rotation [rad] and largest displacement of the centre [m] of a block so far."""

    theta: real
    moved: real


@wp.struct
class Track:
    """A contact from step to step.

    Attributes:
        slide: How far it has slid [m].
        most: Largest |slide| [m].
        opening: Widest gap [m].
        since: When it last carried [s]; NEVER before it does.
        parted: 1 where it has parted and not landed since, else 0.
    """

    slide: real
    most: real
    opening: real
    since: real
    parted: int


@wp.struct
class Seen:
    """What is seen of a lane.

    Attributes:
        mode: How it goes on, see modes.py.
        steps: Steps so far.
        impacts: Impacts so far.
        sweeps: Sweeps of all steps.
        uplift_time: When a joint first opened [s]; NEVER before.
        moved: When something last moved [s].
        deepest: Deepest penetration so far [m].
        peak: Largest |rotation| so far [rad].
        peak_time: Its time [s].
        collapse_time: When a block had fallen or slid off [s]; NEVER before.
        off: 1 where it had slid off, else 0.
        still: When no corner moved faster than at `CREEP` g dt, last [s].
        residual: The most that a step has left: what its last sweep changed of a velocity [m/s].
        speed: Largest speed of a corner in the last step [m/s].
        astray: Steps in which blocks on springs met where no joint has them.
        leans: 1 where a contact that no joint declares carried in the last step, else 0.
    """

    mode: int
    steps: int
    impacts: int
    sweeps: int
    uplift_time: real
    moved: real
    deepest: real
    peak: real
    peak_time: real
    collapse_time: real
    off: int
    still: real
    residual: real
    speed: real
    astray: int
    leans: int


@wp.func
def start_seen() -> Seen:
    """What is seen of a lane before its first step."""
    zero = real(0.0)
    return Seen(RUNNING, 0, 0, 0, NEVER, zero, zero, zero, zero, NEVER, 0, zero, zero, zero, 0, 0)


@wp.func
def integrate(step: real, v: Velocity, at: Pose) -> Pose:
    """Where a block is after a step of a length [s]."""
    theta = fused(step, v.omega, at.theta)
    turn = fused_less(TURN, wp.floor(fused(theta, OVER_TURN, HALF)), theta)
    # Beyond a right angle by way of its supplement: sine and cosine are polynomials.
    over = size(turn) > HALF_PI
    inside = wp.where(over, sign_of(turn) * HALF * TURN - turn, turn)
    c = cosine(inside)
    x, z = fused(step, v.x, at.x), fused(step, v.z, at.z)
    return Pose(x, z, theta, sine(inside), wp.where(over, -c, c))


@wp.func
def add_energy(live: bool, pull: Pull, gain: real, mass: Mass, before: Velocity, v: Velocity,
    account: wp.ref[Account],
):  # fmt: skip
    """Adds what a block does in a step to the account of its lane.

    Args:
        live: Whether the lane still runs.
        pull: What gravity and the base added to its velocity [m/s].
        gain: What the velocity of the base gained [m/s].
        mass: The mass of the block.
        before, v: Its velocity before and after the step.
        account: The account.
    """
    zero, one = real(0.0), real(1.0)
    free = live and mass.m > zero
    m = wp.where(free, one / wp.where(free, mass.m, one), zero)
    j = wp.where(free, one / wp.where(free, mass.j, one), zero)
    sx, sz, so = before.x + v.x, before.z + v.z, before.omega + v.omega
    outer = dot(pull.x, pull.z, sx, sz)
    kept = dot(v.x - before.x, v.z - before.z, sx, sz)
    turned = j * (v.omega - before.omega) * so
    account.work = account.work - HALF * m * gain * sx
    account.loss = account.loss + HALF * (m * (outer - kept) - turned)


@wp.func
def observe_block(
    live: bool, time: real, block: Block, at: Pose, v: Velocity,
    peak: wp.ref[Peak], seen: wp.ref[Seen],
):  # fmt: skip
    """What a step shows of a block, and how its lane goes on.

    Args:
        live: Whether the lane still runs.
        time: End of the step [s].
        block: The block.
        at: Where it is.
        v: Its velocity.
        peak: Its peaks.
        seen: What is seen of the lane.
    """
    zero = real(0.0)
    turn, dx, dz = size(at.theta), at.x - block.x, at.z - block.z
    far = wp.sqrt(dot(dx, dz, dx, dz))
    peak.theta = wp.where(live, larger(smaller(turn, HALF_PI), peak.theta), peak.theta)
    peak.moved = wp.where(live, larger(far, peak.moved), peak.moved)
    higher = live and smaller(turn, HALF_PI) > seen.peak
    seen.peak = wp.where(higher, smaller(turn, HALF_PI), seen.peak)
    seen.peak_time = wp.where(higher, time, seen.peak_time)
    speed = fused(block.reach, size(v.omega), size(v.x) + size(v.z))
    seen.moved = wp.where(live and speed > block.calm, time, seen.moved)
    seen.speed = larger(speed, seen.speed)
    total = at.theta + far + speed
    fell = dz < -block.fall or turn >= HALF_PI
    falls = smaller(time, seen.collapse_time)
    seen.collapse_time = wp.where(live and fell, falls, seen.collapse_time)
    # A number that is none makes `total - total` none.
    seen.mode = wp.where(live and total - total != zero, BROKEN, seen.mode)


@wp.func
def observe_slide(live: bool, step: real, rate: real, carried: real, track: wp.ref[Track]):
    """How far a contact that carries has slid after a step.

    Args:
        live: Whether its lane still runs.
        step: Length of the step [s].
        rate: Velocity with which the contact slides [m/s].
        carried: Its normal impulse [N s].
        track: The contact from step to step.
    """
    way = wp.where(live and carried > real(0.0), step * rate, real(0.0))
    track.slide = track.slide + way
    track.most = larger(size(track.slide), track.most)


@wp.func
def length_of(block: Block) -> real:
    """Length of the longest joint of a block [m]; NEVER of one that is fixed."""
    return wp.where(block.inverse_mass > real(0.0), real(2.0) * block.fall, NEVER)


@wp.func
def observe_off(off: bool, time: real, seen: wp.ref[Seen]):
    """Keeps that a block has slid off what bore it: by more than its longest joint.

    Args:
        off: Whether it has, in a lane that still runs and had not collapsed.
        time: End of the step [s].
        seen: What is seen of the lane.
    """
    seen.collapse_time = wp.where(off, smaller(time, seen.collapse_time), seen.collapse_time)
    seen.off = wp.where(off, 1, seen.off)


@wp.func
def last_mode(seen: Seen) -> int:
    """How a lane has ended: whether it had collapsed, and how, if nothing else ended it."""
    fell = wp.where(seen.off > 0, SLID_OFF, OVERTURNED)
    return wp.where(seen.mode == RUNNING and seen.collapse_time < NEVER, fell, seen.mode)


@wp.func
def observe_gap(
    live: bool, time: real, gap: real, limit: real, impulse: Impulse, track: wp.ref[Track],
    seen: wp.ref[Seen],
):  # fmt: skip
    """What the gap of a contact shows, where a step begins.

    Args:
        live: Whether its lane still runs.
        time: Start of the step [s].
        gap: Gap [m]; NEVER where the corner has left the other edge.
        limit: Gap beyond which it has parted [m], see `slack` in parting.py.
        impulse: What it carried in the last step.
        track: The contact from step to step.
        seen: What is seen of the lane.
    """
    carries, was = impulse.n > real(0.0), track.parted > 0
    # What leans on others or lies on the ground may rest while its joint gapes.
    leans = seen.leans > 0
    apart = gap > limit or (was and not carries)
    opening = wp.where(gap < NEVER, gap, real(0.0))
    seen.impacts = seen.impacts + wp.where(live and was and carries, 1, 0)
    track.since = wp.where(live and carries, time, track.since)
    lifted = smaller(smaller(track.since, time), seen.uplift_time)
    seen.uplift_time = wp.where(live and apart, lifted, seen.uplift_time)
    seen.moved = wp.where(live and apart and not leans, time, seen.moved)
    seen.deepest = wp.where(live, larger(-opening, seen.deepest), seen.deepest)
    stands = live and seen.collapse_time >= NEVER
    track.opening = wp.where(stands, larger(opening, track.opening), track.opening)
    track.parted = wp.where(live, wp.where(apart, 1, 0), track.parted)
