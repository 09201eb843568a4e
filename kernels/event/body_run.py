"""Runs of the event step over bodies on contact points, LANES lanes a thread.

As event/block_run.py; in each step a lane looks up the corner that it turns about, or would tip
about, and the two beside it.

With one lane a thread the same text is the plain form.
"""

import warp as wp

from warprock.kernels.algebra.vectors import ALONG, ONLY, UPWARDS
from warprock.kernels.event.block.state import Seen, State, observe, start_seen
from warprock.kernels.event.block.step import Knobs
from warprock.kernels.event.body.contact import Body
from warprock.kernels.event.body.step import begin_step, look_ahead, step
from warprock.kernels.event.body.view import View, edge_of, tips_about_second
from warprock.kernels.event.body.weight import rise, weight_in
from warprock.kernels.event.found import Result, block_result, result_of
from warprock.kernels.lane.modes import FLAT, OVERTURNED, PIVOTING
from warprock.kernels.launch.instance import TWO_VECTORS
from warprock.kernels.launch.rows import kernel, rows
from warprock.kernels.motion.kinds import ground_at
from warprock.kernels.shape.above import Above, Motions, above_at
from warprock.kernels.shape.body import Corner, is_past, rotated_x, rotated_z
from warprock.kernels.shape.body_found import TO_LEFT, TO_RIGHT
from warprock.kernels.shape.stack_found import BlockResult

wp.set_module_options(TWO_VECTORS)

ASKED = wp.constant(1)
DONE = wp.constant(2)
"""States of looking ahead, which a lane at rest does before a step in which its base may let it go:
the step asked for it, it is done."""


@wp.struct
class Start:
    """The state that a lane's last step began with, for samples that lie inside it; its corner."""

    time: real
    theta: real
    slide: real
    gap: real
    vx: real
    vz: real
    omega: real
    corner: int


@wp.struct
class Chain:
    """Numbers of the corner of a lane's state (event/body/step.py) and of its last corner."""

    corner: int
    last: int


@wp.struct
class Climb:
    """Vertical motion of a lane's base: velocity upwards [m/s], knots passed."""

    rising: real
    risen: int


@wp.struct
class Sides:
    """More of the observed response of a body, and whether it has to look ahead.

    Attributes:
        left, right: Largest rotations to -x and to +x [rad].
        needed: Friction that its prescribed impacts need.
        look: 0, ASKED or DONE.
    """

    left: real
    right: real
    needed: real
    look: int


@wp.struct
class Found:
    """Results; `sides` holds the largest rotations to -x and to +x [rad], shape [2, lane]."""

    results: wp.array(dtype=Result)
    blocks: wp.array2d(dtype=BlockResult)
    rotations: wp.array3d(dtype=real)
    places: wp.array4d(dtype=real)
    sides: wp.array2d(dtype=real)


@wp.func
def starts_past(body: Body, angle: real) -> int:
    """1 where a body starts beyond a rotation, or at it and turns to +x; else 0."""
    turns_on = body.start == angle and body.spin > real(0.0)
    return wp.where(body.start > angle or turns_on, 1, 0)


@wp.func
def start_lane(lowest: Corner, body: Body):
    """State and response of a body at its start; if it turns, it turns about its lowest corner."""
    zero, theta, omega = real(0.0), body.start, body.spin
    flat = theta == lowest.angle and omega == zero
    s, c = sine(theta), cosine(theta)
    vx = -omega * (rotated_z(lowest.x, lowest.z, s, c) - body.radius)
    vz = omega * rotated_x(lowest.x, lowest.z, s, c)
    mode = wp.where(flat, FLAT, PIVOTING)
    state = State(theta, zero, zero, vx, vz, omega, zero, mode, zero, 0, zero, NEVER)
    return state, start_seen(theta, flat)


@wp.func
def turn_between(number: int, left: real, own: real):
    """Rotations between which a body turns about a corner [rad].

    Args:
        number: Of the corner.
        left, own: Angles of the edges to -x and to +x of it [rad].
    """
    low = wp.where(number > 0, larger(left, -HALF_PI), -HALF_PI)
    return low, smaller(own, HALF_PI)


@wp.func
def rotation_at(until: real, s: State, start: Start) -> real:
    """Rotation inside the last step [rad], from its start and its end."""
    tau = until - start.time
    d = s.time - start.time
    part = wp.where(d > real(0.0), tau / d, real(1.0))
    bend = part * part * (s.theta - start.theta - start.omega * d)
    return wp.where(until < s.time, start.theta + start.omega * tau + bend, s.theta)


@wp.func
def place_at(corner: Corner, radius: real, until: real, s: State, start: Start):
    """Centre of mass inside the last step [m], from the slide and the gap of its corner.

    Args:
        corner: The corner.
        radius: Of its arc [m].
        until: The time [s]; if the step ends earlier, its end counts.
        s, start: State at the end of the step and at its start.

    Returns:
        x and z.
    """
    inside = until < s.time
    d = s.time - start.time
    tau = wp.where(inside, until - start.time, d)
    part = wp.where(inside and d > real(0.0), tau / d, real(1.0))
    at = rotation_at(until, s, start)
    s0, c0 = sine(start.theta), cosine(start.theta)
    glide = start.vx + start.omega * (rotated_z(corner.x, corner.z, s0, c0) - radius)
    climb = start.vz - start.omega * rotated_x(corner.x, corner.z, s0, c0)
    bend = part * part
    slid = start.slide + tau * glide + bend * (s.slide - start.slide - d * glide)
    high = start.gap + tau * climb + bend * (s.gap - start.gap - d * climb)
    s1, c1 = sine(at), cosine(at)
    rolled = corner.along + radius * at
    return (
        slid + rolled - rotated_x(corner.x, corner.z, s1, c1),
        high + radius - rotated_z(corner.x, corner.z, s1, c1),
    )


@kernel
def run_lanes(
    blocks: wp.array(dtype=Body), corners: wp.array2d(dtype=Corner),
    motions: Motions, pool: wp.array2d(dtype=real),
    sample_times: wp.array(dtype=real), knobs: Knobs, found: Found,
):  # fmt: skip
    """Runs LANES lanes a thread, which take their steps side by side."""
    first = wp.tid() * LANES
    # By names of their own: read off the struct they would keep the loop over lanes scalar.
    results = found.results
    leaves = found.blocks
    rotations = found.rotations
    side_of = found.sides
    places = found.places
    state = rows(State)
    start = rows(Start)
    chain = rows(Chain)
    climb = rows(Climb)
    seen = rows(Seen)
    sides = rows(Sides)
    for i in range(LANES):
        for k in range(corners.shape[0] - 1):
            angle = corners[k, first + i].angle
            chain[i].corner = chain[i].corner + starts_past(blocks[first + i], angle)
            chain[i].last = chain[i].last + is_past(HALF_PI, angle)
        start[i].corner = chain[i].corner
        begins, sees = start_lane(corners[chain[i].corner, first + i], blocks[first + i])
        state[i] = begins
        seen[i] = sees
    end = sample_times[sample_times.shape[0] - 1]
    for sample in range(sample_times.shape[0]):
        until = sample_times[sample]
        busy, looking = int(1), int(0)
        while busy > 0:
            if looking > 0:
                for i in range(LANES):
                    above = Above()
                    if VERTICAL:
                        m = motions[ALONG, first + i]
                        up = motions[UPWARDS, first + i]
                        above = above_at(up, climb[i].risen, pool)
                    else:
                        m = motions[first + i]
                    ground = ground_at(m, state[i].segment, pool)
                    here = chain[i].corner
                    ahead = wp.min(here + 1, chain[i].last)
                    edge = edge_of(
                        blocks[first + i], corners[here, first + i].x, corners[here, first + i].z,
                        corners[ahead, first + i].x, corners[ahead, first + i].z,
                        sine(state[i].theta), cosine(state[i].theta),
                    )  # fmt: skip
                    most = look_ahead(
                        blocks[first + i], knobs.gravity, edge, m, ground, end, state[i], above
                    )
                    asked = sides[i].look == ASKED
                    state[i].cap = wp.where(asked, smaller(most, state[i].cap), state[i].cap)
                    sides[i].look = wp.where(asked, DONE, sides[i].look)
            for i in range(LANES):
                above = Above()
                if VERTICAL:
                    m = motions[ALONG, first + i]
                    up = motions[UPWARDS, first + i]
                    above = above_at(up, climb[i].risen, pool)
                else:
                    m = motions[first + i]
                ground = ground_at(m, state[i].segment, pool)
                going = state[i].mode < OVERTURNED and state[i].time < until
                span, more = begin_step(blocks[first + i], m, ground, end, going, state[i], above)
                weight = weight_in(knobs.gravity, above, span.time, span.d, climb[i].rising)
                # Field by field: four float32 loaded at once would keep the loop scalar.
                here = chain[i].corner
                ahead = wp.min(here + 1, chain[i].last)
                edge = edge_of(
                    blocks[first + i], corners[here, first + i].x, corners[here, first + i].z,
                    corners[ahead, first + i].x, corners[ahead, first + i].z,
                    sine(state[i].theta), cosine(state[i].theta),
                )  # fmt: skip
                tips = tips_about_second(
                    blocks[first + i], knobs.gravity, weight, edge, state[i], span
                )
                lies = state[i].mode == FLAT
                second = lies and tips
                k = wp.where(second, ahead, here)
                left, right = wp.max(k - 1, 0), wp.min(k + 1, chain[i].last)
                lowest, highest = turn_between(
                    k, corners[left, first + i].angle, corners[k, first + i].angle
                )
                view = View(
                    k, corners[k, first + i].x, corners[k, first + i].z, lowest, highest,
                    corners[left, first + i].x, corners[left, first + i].z,
                    corners[right, first + i].x, corners[right, first + i].z, not second,
                )  # fmt: skip
                new, shown, footing = step(
                    blocks[first + i], knobs, weight, view, going, span,
                    wp.where(sides[i].look == DONE, real(-1.0), more), state[i],
                )  # fmt: skip
                begun = Start(
                    state[i].time, state[i].theta, state[i].slide, state[i].gap, state[i].vx,
                    state[i].vz, state[i].omega, k,
                )  # fmt: skip
                start[i] = wp.where(shown.taken, begun, start[i])
                rise(shown.taken, weight, climb[i].rising, climb[i].risen)
                sees = seen[i]
                still = new.theta == state[i].theta and new.gap <= real(0.0)
                limit = blocks[first + i].step_limit
                new.mode = observe(going, limit, still, state[i], new, shown, sees)
                seen[i] = sees
                sides[i].left = larger(larger(-new.theta, -shown.apex), sides[i].left)
                sides[i].right = larger(larger(new.theta, shown.apex), sides[i].right)
                sides[i].needed = larger(footing.needed, sides[i].needed)
                looked = wp.where(shown.taken, 0, sides[i].look)
                sides[i].look = wp.where(footing.asks, ASKED, looked)
                chain[i].corner = wp.where(shown.taken, footing.corner, chain[i].corner)
                state[i] = new
            busy, looking = int(0), int(0)
            for i in range(LANES):
                goes = state[i].mode < OVERTURNED and state[i].time < until
                busy = busy + wp.where(goes, 1, 0)
                looking = looking + wp.where(sides[i].look == ASKED, 1, 0)
        if rotations.shape[0] > 0:
            for i in range(LANES):
                rotations[sample, ONLY, first + i] = rotation_at(until, state[i], start[i])
        if places.shape[0] > 0:
            for i in range(LANES):
                spot, level = place_at(
                    corners[start[i].corner, first + i], blocks[first + i].radius, until, state[i],
                    start[i],
                )  # fmt: skip
                places[sample, ONLY, ALONG, first + i] = spot
                places[sample, ONLY, UPWARDS, first + i] = level
    for i in range(LANES):
        results[first + i] = result_of(seen[i], sides[i].needed, state[i].mode)
        side_of[TO_LEFT, first + i] = sides[i].left
        side_of[TO_RIGHT, first + i] = sides[i].right
        leaves[0, first + i] = block_result(state[i].slide, seen[i])
