"""Where a step ends in which a stack sticks at all its contacts; event/stack/rocking.py.

It ends where a pivoting block falls flat, and where the margin of a contact is used up: a closed
interface is about to open, or a contact to slide.
"""

import warp as wp

from warprock.kernels.event.block.begin import first_root
from warprock.kernels.event.stack.curves import Curve, Curves, load_of, rate_of, value_of
from warprock.kernels.event.stack.links import Chain
from warprock.kernels.event.stack.rocking import Rocking
from warprock.kernels.event.stack.state import GRAIN, NEARLY, SOON, Limits
from warprock.kernels.shape.stack import (
    CLOSED,
    Anchor,
    Blocks,
    Counts,
    Pose,
    Values,
    flat_rotation,
    lower_face,
    place_block,
    side_of,
    turn_block,
)

if CHAINS:
    from warprock.kernels.event.stack.edges import WITHIN, end_of_edge, room_of

LACKS = 0
ROLLS = 1
SPENT = 2
"""How a step comes out: a contact lacks force from its start; it ends after its whole length or
where a block falls flat; it ends where the margin of a contact is used up."""

SLIGHT = by_precision(1.0e-9, 1.0e-4)
"""Part of the stack's weight by which a contact may lack force and still hold."""
NEWTON_STEPS = 7
SECANT_STEPS = 8
CLOSE = real(1.0e-4)
"""Part of the stack's weight to which the margin is zero at the end of a step that uses it up."""


@wp.struct
class Loads:
    """Loads of the interfaces and rotations of the blocks at a time in a step.

    Attributes:
        fx, fz, moment: See `Rocking`.
        sine, cosine: Of the rotations.
    """

    fx: Values
    fz: Values
    moment: Values
    sine: Values
    cosine: Values


@wp.func
def opening_curve(blocks: wp.ref[Blocks], p: Curves, k: int, side: real) -> Curve:
    """Opening of a pivoting interface [rad], as a polynomial of the time since the start."""
    e = p[k]
    if CHAINS:
        e[0] = e[0] - blocks.foot[k]
    if k > 0:
        e = e - p[k - 1]
    return side * e


@wp.func
def face_load(blocks: wp.ref[Blocks], under: Counts, loads: wp.ref[Loads], k: int):
    """What an interface bears along the normal of the face that counts, and along it [N].

    Arguments as of `spare_of`.
    """
    s = real(0.0)
    c = real(1.0)
    face = k - 1 + under[k]
    if face >= 0:
        s = loads.sine[face]
        c = loads.cosine[face]
    if CHAINS:
        edge_s = loads.sine[k] * blocks.foot_cosine[k] - loads.cosine[k] * blocks.foot_sine[k]
        edge_c = loads.cosine[k] * blocks.foot_cosine[k] + loads.sine[k] * blocks.foot_sine[k]
        s = wp.where(under[k] == 1, edge_s, s)
        c = wp.where(under[k] == 1, edge_c, c)
    return dot(loads.fx[k], loads.fz[k], s, c), fused_less(loads.fz[k], s, loads.fx[k] * c)


@wp.func
def reach_of(blocks: wp.ref[Blocks], pose: wp.ref[Pose], k: int):
    """How far the overlap of the faces of a closed interface reaches to -x and to +x [m]."""
    low, _height = lower_face(blocks, k)
    behind = smaller(blocks.half_width[k], low + pose.along[k])
    return behind, smaller(blocks.half_width[k], low - pose.along[k])


@wp.func
def spare_of(
    blocks: wp.ref[Blocks], pose: wp.ref[Pose], chain: wp.ref[Chain], loads: wp.ref[Loads]
) -> real:  # fmt: skip
    """Margin of the weakest contact before it opens or slides [N].

    Both ends of the overlap of the faces of a closed interface must bear a load.

    Args:
        blocks: The blocks.
        pose: Their pose, for what does not change while contacts stick.
        chain: The chain that they make.
        loads: Loads and rotations.
    """
    least = NEVER
    for k in range(BLOCKS):
        normal, along = face_load(blocks, chain.under, loads, k)
        least = smaller(least, fused(blocks.friction[k], normal, -size(along)))
        least = smaller(least, normal)
        if chain.touch[k] == CLOSED:
            moment = loads.moment[k]
            behind, ahead = reach_of(blocks, pose, k)
            ends = smaller(fused(behind, normal, -moment), fused(ahead, normal, moment))
            least = smaller(least, ends / (ahead + behind))
    return least


@wp.func
def spare_at(
    blocks: wp.ref[Blocks], pose: wp.ref[Pose], chain: wp.ref[Chain], r: wp.ref[Rocking], tau: real,
    new: wp.ref[Pose],
) -> real:  # fmt: skip
    """`spare_of` at a time in a step; sets the pose then."""
    loads = Loads()
    new.touch = chain.touch
    for k in range(BLOCKS):
        loads.fx[k] = load_of(r.fx[wp.static(k)], tau)
        loads.fz[k] = load_of(r.fz[k], tau)
        loads.moment[k] = load_of(r.moment[k], tau)
        theta = value_of(r.theta[k], tau)
        if chain.touch[k] == CLOSED:
            theta = flat_rotation(blocks, new, k)
        turn_block(blocks, new, k, theta)
        anchor = Anchor(chain.place[k], real(1 - 2 * chain.under[k]))
        place_block(blocks, new, k, chain.touch[k], anchor)
    loads.sine = new.sine
    loads.cosine = new.cosine
    return spare_of(blocks, pose, chain, loads)


@wp.func
def spare_first(
    blocks: wp.ref[Blocks], pose: wp.ref[Pose], chain: wp.ref[Chain], r: wp.ref[Rocking]
) -> real:  # fmt: skip
    """`spare_of` at the start of a step."""
    loads = Loads()
    for k in range(BLOCKS):
        loads.fx[k] = r.fx[k, 0]
        loads.fz[k] = r.fz[k, 0]
        loads.moment[k] = r.moment[k, 0]
    loads.sine = pose.sine
    loads.cosine = pose.cosine
    return spare_of(blocks, pose, chain, loads)


@wp.func
def landing_time(p: Curve, room: real, guess: real, d: real) -> real:
    """Time in (0, d] at which an opening crosses `room` [rad]; it is beyond `room` at d.

    Newton's method inside a shrinking bracket.
    """
    tau, low, high = real(guess), real(0.0), real(d)
    left = int(NEWTON_STEPS)
    while left > 0:
        e = value_of(p, tau)
        # An interface comes down to zero, and a body turns up to its next edge.
        before = wp.where(room > real(0.0), room - e, e) > real(0.0)
        low = wp.where(before, tau, low)
        high = wp.where(before, high, tau)
        left = wp.where(size(e - room) <= GRAIN, 0, left - 1)
        tau = tau - (e - room) / rate_of(p, tau)
        tau = wp.where(tau >= low and tau <= high, tau, HALF * (low + high))
    return tau


@wp.func
def find_impact(
    blocks: wp.ref[Blocks], limits: wp.ref[Limits], pose: wp.ref[Pose], touch: Counts,
    theta: Curves, d: real,
):  # fmt: skip
    """The first impact in a step; arguments as of `find_end`, and the rotations.

    Returns:
        Length of the step to there, d if there is none; whether there is one; whether a contact
        that was to open has not.
    """
    zero = real(0.0)
    d1 = real(d)
    fails = bool(False)
    lands = bool(False)
    near = NEARLY * limits.longest_step
    for k in range(BLOCKS):
        if touch[k] != CLOSED:
            side = side_of(touch[k])
            curve = opening_curve(blocks, theta, k, side)
            e0 = larger(curve[0], zero)
            r0 = curve[1]
            # Where another block has fallen flat before, this one only counts up to there.
            end = real(d1)
            e1 = value_of(curve, end)
            r1 = rate_of(curve, end)
            reach = near * size(r1) + GRAIN
            if r0 < zero and r1 > zero and e1 >= -reach:
                # It may have been below in between: look where it turns.
                end = end * r0 / (r0 - r1)
                e1 = value_of(curve, end)
                r1 = rate_of(curve, end)
            lands = lands or e1 <= reach
            if pose.touch[k] == CLOSED:
                fails = fails or e1 <= zero
            elif e1 < -reach:
                guess = first_root(e0, r0, e1, end)
                d1 = landing_time(curve, zero, guess, end)
            if CHAINS:
                # The edge that a body comes to as it turns on.
                room = room_of(blocks, k, side)
                low, _height = lower_face(blocks, k)
                within = size(end_of_edge(blocks, pose, k, side)) < WITHIN * low
                if within and e0 < room and e1 > room + reach:
                    guess = first_root(room - e0, -r0, room - e1, end)
                    d1 = smaller(d1, landing_time(curve, room, guess, end))
    return d1, lands, fails


@wp.func(inline=False)
def find_end(
    blocks: wp.ref[Blocks], limits: wp.ref[Limits], pose: wp.ref[Pose], chain: wp.ref[Chain],
    r: wp.ref[Rocking], d: real, new: wp.ref[Pose],
):  # fmt: skip
    """The end of a step in which all contacts stick.

    Args:
        blocks: The blocks.
        limits: The lane's limits.
        pose: Their pose, with the ends that touched before.
        chain: The chain that the ends make that touch and stick in the step.
        r: Polynomials of the step.
        d: Longest length of the step [s].
        new: The pose at its end.

    Returns:
        Length of the step; LACKS, ROLLS or SPENT; whether a block falls flat.
    """
    weight = limits.mass * limits.gravity
    d1, lands, fails = find_impact(blocks, limits, pose, chain.touch, r.theta, d)
    found = int(ROLLS)
    if fails:
        found = LACKS
    else:
        slack = SLIGHT * weight
        low = real(0.0)
        at_low = spare_first(blocks, pose, chain, r) + slack
        high = real(d1)
        at_high = spare_at(blocks, pose, chain, r, high, new) + slack
        if not at_low >= real(0.0):
            found = LACKS
        elif at_high < real(0.0):
            found = SPENT
            left = int(SECANT_STEPS)
            while left > 0:
                middle = low + (high - low) * at_low / (at_low - at_high)
                at = spare_at(blocks, pose, chain, r, middle, new) + slack
                d1 = middle
                left = wp.where(size(at) <= CLOSE * weight, 0, left - 1)
                if at < real(0.0):
                    high = middle
                    at_high = at
                    at_low = HALF * at_low
                else:
                    low = middle
                    at_low = at
                    at_high = HALF * at_high
            # A contact that lets go that soon lacks force from the start.
            if d1 <= SOON * limits.longest_step:
                found = LACKS
    return d1, found, lands
