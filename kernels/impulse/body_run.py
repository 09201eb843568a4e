"""Runs of the impulse step over bodies on contact points, LANES lanes a thread.

In each step a lane looks up its lowest corner and its two neighbours. If the lowest corner changes,
impulses and parted flags of the last step move on to the new numbers.

A body rocks while fewer than two of its corners are closed, see shape/body_seen.py.

With one lane a thread the same text is the plain form.
"""

import warp as wp

from warprock.kernels.algebra.vectors import ALONG, ONLY, UPWARDS
from warprock.kernels.contact.parting import slack, slides
from warprock.kernels.impulse.block import Knobs
from warprock.kernels.impulse.body import Body, Feet, Impulses, step
from warprock.kernels.lane.account import Account, keep_account
from warprock.kernels.lane.modes import RUNNING
from warprock.kernels.launch.rows import kernel, rows
from warprock.kernels.motion.kinds import base_velocity
from warprock.kernels.shape.above import Motions
from warprock.kernels.shape.block import Base, State, mode_of
from warprock.kernels.shape.body import Corner, is_past, rotate_corner, rotated_x
from warprock.kernels.shape.body_found import TO_LEFT, TO_RIGHT, Found, Sides, observe_sides
from warprock.kernels.shape.body_seen import CornerParting, observe_corners, shift_corners
from warprock.kernels.shape.rising import base_work, equivalent_gain
from warprock.kernels.shape.stack_found import (
    Peaks,
    Seen,
    at_sample,
    block_result,
    observe_lane,
    observe_peaks,
    result_of,
    start_peaks,
    start_seen,
)

LaneInt = wp.types.vector(length=LANES, dtype=int)


@wp.struct
class Place:
    """Numbers of the lowest and of the last corner of a body, and its slide [m]."""

    low: int
    last: int
    slide: real


@wp.func
def move_along(by: int, p: Impulses) -> Impulses:
    """The impulses by the new numbers of the three corners, see `shift_corners`."""
    n1, n2, n3 = shift_corners(by, p.n1, p.n2, p.n3)
    f1, f2, f3 = shift_corners(by, p.f1, p.f2, p.f3)
    return Impulses(n1, f1, n2, f2, n3, f3)


@wp.func
def start(corner: Corner, ahead: Corner, body: Body, fall: real):
    """State of a body at its start, and first guesses of the impulses of its corners.

    `corner` is the lowest corner, `ahead` the next one, `fall` the velocity that gravity gives in
    half a step [m/s]. On an edge the first corner counts as the lowest. Both share the weight by
    statics.
    """
    zero, one = real(0.0), real(1.0)
    foot, low = rotate_corner(corner.x, corner.z, sine(body.start), cosine(body.start))
    flat = body.start == corner.angle
    length = wp.where(flat, ahead.along - corner.along, one)
    share = larger(smaller(-foot / length, one), zero)
    share = wp.where(flat, share, zero)
    state = State(
        corner.along - foot, -low, body.start, body.vx, body.vz + fall, body.omega
    )  # fmt: skip
    return state, Impulses(zero, zero, (one - share) * fall, zero, share * fall, zero)


@wp.func
def uplift_at_start(corner: Corner, body: Body) -> real:
    """Uplift time of a body at its start: 0, or NEVER if it stands still on an edge."""
    flat = body.start == corner.angle and body.omega == real(0.0)
    return wp.where(flat, NEVER, real(0.0))


@kernel
def run_lanes(
    blocks: wp.array(dtype=Body), corners: wp.array2d(dtype=Corner),
    motions: Motions, pool: wp.array2d(dtype=real),
    sample_times: wp.array(dtype=real), knobs: Knobs, found: Found,
):  # fmt: skip
    """Runs LANES lanes a thread, all at the same time."""
    first = wp.tid() * LANES
    # By names of their own: read off the struct they would keep the loop over lanes scalar.
    results = found.results
    leaves = found.blocks
    rotations = found.rotations
    to_sides = found.sides
    places = found.places
    state = rows(State)
    impulses = rows(Impulses)
    place = rows(Place)
    base = rows(Base)
    account = rows(Account)
    parting = rows(CornerParting)
    peaks = rows(Peaks)
    sides = rows(Sides)
    seen = rows(Seen)
    edges = corners.shape[0] - 1
    for i in range(LANES):
        own = blocks[first + i]
        for e in range(edges):
            place[i].low = place[i].low + is_past(own.start, corners[e, first + i].angle)
            place[i].last = place[i].last + wp.where(corners[e, first + i].angle < NEVER, 1, 0)
        lowest = corners[place[i].low, first + i]
        second = corners[wp.min(place[i].low + 1, place[i].last), first + i]
        after, pushed = start(lowest, second, own, HALF * knobs.time_step * knobs.gravity)
        state[i] = after
        impulses[i] = pushed
        peaks[i] = start_peaks(own.start)
        seen[i] = start_seen(uplift_at_start(lowest, own))
    k = int(0)
    time = real(0.0)
    for sample in range(sample_times.shape[0]):
        until = sample_times[sample]
        while time < until:
            k += 1
            time = real(k) * knobs.time_step
            half = time - HALF * knobs.time_step
            now = LaneInt()
            for e in range(edges):
                for i in range(LANES):
                    now[i] = now[i] + is_past(state[i].theta, corners[e, first + i].angle)
            for i in range(LANES):
                dz = real(0.0)
                if VERTICAL:
                    m = motions[ALONG, first + i]
                    up = motions[UPWARDS, first + i]
                    rise = base_velocity(up, half, pool)
                    dz = rise - base[i].vz
                    base[i].vz = rise
                else:
                    m = motions[first + i]
                moving = base_velocity(m, half, pool)
                dv = moving - base[i].vx
                mid = now[i]
                by = mid - place[i].low
                has_left, has_right = wp.where(mid > 0, 1, 0), wp.where(mid < place[i].last, 1, 0)
                s, c = sine(in_range(state[i].theta)), cosine(in_range(state[i].theta))
                # Field by field: four float32 loaded at once would keep the loop scalar.
                body = Body()
                body.inverse_inertia = blocks[first + i].inverse_inertia
                body.friction = blocks[first + i].friction
                reach = blocks[first + i].reach
                before, ahead = mid - has_left, mid + has_right
                lx, lz = rotate_corner(
                    corners[before, first + i].x, corners[before, first + i].z, s, c
                )
                mx, mz = rotate_corner(corners[mid, first + i].x, corners[mid, first + i].z, s, c)
                rx, rz = rotate_corner(
                    corners[ahead, first + i].x, corners[ahead, first + i].z, s, c
                )
                feet = Feet(mx, mz, lx, lz, rx, rz, has_left, has_right)
                loss = account[i].loss
                after, pushed, sees, low = step(
                    body, knobs, dv, dz, feet, state[i],
                    move_along(by, impulses[i]), loss,
                )  # fmt: skip
                # The slide is that of the corner that was lowest at the start of the step.
                theta = in_range(after.theta)
                foot = rotated_x(
                    corners[mid, first + i].x, corners[mid, first + i].z, sine(theta), cosine(theta)
                )
                slid = after.x + foot - corners[mid, first + i].along
                limit = slack(
                    knobs.time_step, knobs.gravity, reach, after.omega * after.omega, reach
                )
                way = knobs.time_step * (after.vx + after.omega * mz)
                ends, lane = parting[i], seen[i]
                live = lane.mode == RUNNING
                glides = slides(way, knobs.time_step, knobs.gravity)
                observe_corners(live, by, time, limit, glides, sees, ends, lane)
                observe_lane(live, mode_of(RUNNING, after.theta, after.omega, slid), -low, lane)
                parting[i] = ends
                seen[i] = lane
                peaks[i] = observe_peaks(live, time, after.theta, slid, peaks[i])
                sides[i] = observe_sides(live, after.theta, sides[i])
                work = base_work(dv, dz, state[i].vx + after.vx, state[i].vz + after.vz)
                account[i].work = account[i].work - wp.where(live, work, real(0.0))
                account[i].loss = wp.where(live, loss, account[i].loss)
                pull = equivalent_gain(dv, dz, knobs.time_step * knobs.gravity)
                account[i] = keep_account(pull, account[i])
                base[i].vx = moving
                state[i] = wp.where(live, after, state[i])
                impulses[i] = wp.where(live, pushed, impulses[i])
                place[i].low = mid
                place[i].slide = wp.where(live, slid, place[i].slide)
        past = time - until
        if rotations.shape[0] > 0:
            for i in range(LANES):
                mode = seen[i].mode
                rotations[sample, ONLY, first + i] = at_sample(
                    mode, past, state[i].theta, state[i].omega
                )
        if places.shape[0] > 0:
            for i in range(LANES):
                mode = seen[i].mode
                places[sample, ONLY, ALONG, first + i] = at_sample(
                    mode, past, state[i].x, state[i].vx
                )
                places[sample, ONLY, UPWARDS, first + i] = at_sample(
                    mode, past, state[i].z, state[i].vz
                )
    for i in range(LANES):
        results[first + i] = result_of(seen[i], account[i])
        to_sides[TO_LEFT, first + i] = sides[i].left
        to_sides[TO_RIGHT, first + i] = sides[i].right
        leaves[0, first + i] = block_result(place[i].slide, peaks[i])
