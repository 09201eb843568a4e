"""How far a stack that sticks at all its contacts gets in a step; event/stack_rocking.py.

A step ends where a pivoting block falls flat, and where a contact has nothing left to spare: a
closed one is about to open, or one that sticks to slide.
"""

import warp as wp

from warprock.kernels.event.block import first_root
from warprock.kernels.event.stack_rocking import DEGREE, ORDERS, Chain, Curve, Curves, Rocking
from warprock.kernels.shape.stack import (
    CLOSED,
    Blocks,
    Counts,
    Pose,
    Triples,
    Values,
    lower_face,
    side_of,
)

if CHAINS:
    from warprock.kernels.event.stack_body import WITHIN, end_of_edge, room_of

LACKS = 0
ROLLS = 1
SPENT = 2
"""What becomes of a step: a contact lacks force from its start; it ends at `d` or where a block
falls flat; it ends where a contact has nothing left to spare."""

SLIGHT = by_precision(1.0e-9, 1.0e-4)
"""Part of the stack's weight by which a contact may lack force and still be taken to hold."""
NEWTON_STEPS = 7
SECANT_STEPS = 8
CLOSE = real(1.0e-4)
"""Part of the stack's weight to which the moment is found at which nothing is left to spare."""


@wp.func
def value_of(p: Curve, tau: real) -> real:
    """Value of a polynomial."""
    found = p[DEGREE]
    for i in range(DEGREE):
        found = fused(found, tau, p[wp.static(DEGREE - 1 - i)])
    return found


@wp.func
def rate_of(p: Curve, tau: real) -> real:
    """Derivative of a polynomial."""
    found = real(0.0)
    for i in range(DEGREE):
        found = fused(found, tau, real(DEGREE - i) * p[wp.static(DEGREE - i)])
    return found


@wp.func
def load_of(p: Curve, tau: real) -> real:
    """Value of a polynomial that ends with what is known of an acceleration."""
    found = p[ORDERS - 1]
    for i in range(wp.static(ORDERS - 1)):
        found = fused(found, tau, p[wp.static(ORDERS - 2 - i)])
    return found


@wp.func
def turning_time(p: Curve, first: real, last: real, d: real) -> real:
    """Time at which a rotation turns back in a step of length d, from its rates at both ends."""
    at = d * first / (first - last)
    rate = rate_of(p, at)
    # The secant again, in the part in which the sign of the rate changes.
    if rate * first > real(0.0):
        at = at + (d - at) * rate / (rate - last)
    else:
        at = at * first / (first - rate)
    return at


@wp.func
def opening_curve(blocks: Blocks, p: Curves, k: int, side: real) -> Curve:
    """How far a pivoting interface is open [rad], as a polynomial of the time since the start."""
    e = p[k]
    if CHAINS:
        e[0] = e[0] - blocks.foot[k]
    if k > 0:
        e = e - p[k - 1]
    return side * e


@wp.func
def spare_of(
    blocks: Blocks, pose: Pose, touch: Counts, under: Counts, fx: Values, fz: Values,
    moment: Values, sines: Values, cosines: Values,
) -> real:  # fmt: skip
    """What the weakest contact has to spare before it opens or slides [N].

    Of a closed interface both ends of the overlap of its faces must bear a load.

    Args:
        blocks: The blocks.
        pose: Where they are, for what does not change while contacts stick.
        touch: Ends that touch and stick.
        under: See `Chain`.
        fx, fz, moment: See `Rocking`.
        sines, cosines: Of the rotations.
    """
    least = NEVER
    for k in range(BLOCKS):
        s = real(0.0)
        c = real(1.0)
        face = k - 1 + under[k]
        if face >= 0:
            s = sines[face]
            c = cosines[face]
        if CHAINS:
            edge_s = sines[k] * blocks.foot_cosine[k] - cosines[k] * blocks.foot_sine[k]
            edge_c = cosines[k] * blocks.foot_cosine[k] + sines[k] * blocks.foot_sine[k]
            s = wp.where(under[k] == 1, edge_s, s)
            c = wp.where(under[k] == 1, edge_c, c)
        normal = dot(fx[k], fz[k], s, c)
        along = fused_less(fz[k], s, fx[k] * c)
        least = smaller(least, fused(blocks.friction[k], normal, -size(along)))
        least = smaller(least, normal)
        if touch[k] == CLOSED:
            low, _height = lower_face(blocks, k)
            ahead = smaller(blocks.half_width[k], low - pose.along[k])
            behind = smaller(blocks.half_width[k], low + pose.along[k])
            ends = smaller(fused(behind, normal, -moment[k]), fused(ahead, normal, moment[k]))
            least = smaller(least, ends / (ahead + behind))
    return least


@wp.func
def spare_at(blocks: Blocks, pose: Pose, touch: Counts, r: Rocking, tau: real) -> real:
    """`spare_of` at a time in a step."""
    fx, fz, moment, sines, cosines = Values(), Values(), Values(), Values(), Values()
    for k in range(BLOCKS):
        fx[k] = load_of(r.fx[wp.static(k)], tau)
        fz[k] = load_of(r.fz[k], tau)
        moment[k] = load_of(r.moment[k], tau)
        theta = value_of(r.theta[k], tau)
        sines[k] = sine(theta)
        cosines[k] = cosine(theta)
    return spare_of(blocks, pose, touch, r.chain.under, fx, fz, moment, sines, cosines)


@wp.func
def spare_first(blocks: Blocks, pose: Pose, touch: Counts, r: Rocking) -> real:
    """`spare_of` at the start of a step."""
    fx, fz, moment = Values(), Values(), Values()
    for k in range(BLOCKS):
        fx[k] = r.fx[k, 0]
        fz[k] = r.fz[k, 0]
        moment[k] = r.moment[k, 0]
    return spare_of(blocks, pose, touch, r.chain.under, fx, fz, moment, pose.sine, pose.cosine)


@wp.func
def landing(p: Curve, room: real, guess: real, d: real, grain: real) -> real:
    """Time in (0, d] at which an interface is open by `room`, which it is not yet or no more at d.

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
        left = wp.where(size(e - room) <= grain, 0, left - 1)
        tau = tau - (e - room) / rate_of(p, tau)
        tau = wp.where(tau >= low and tau <= high, tau, HALF * (low + high))
    return tau


@wp.func
def to_landing(
    blocks: Blocks, theta: Curves, pose: Pose, touch: Counts, d: real, near: real, grain: real,
    rest: Values,
):  # fmt: skip
    """Length of a step to the first impact in it; d where there is none.

    Returns:
        That; whether there is one; whether a block rests at once (see `pivot_event` in
        event/stack_moves.py); whether a contact that was to open has not.
    """
    zero = real(0.0)
    d1 = real(d)
    waits = bool(False)
    fails = bool(False)
    lands = bool(False)
    for k in range(BLOCKS):
        if touch[k] != CLOSED:
            side = side_of(touch[k])
            curve = opening_curve(blocks, theta, k, side)
            e0 = larger(curve[0], zero)
            r0 = curve[1]
            e1 = value_of(curve, d)
            r1 = rate_of(curve, d)
            reach = near * size(r1) + grain
            end = real(d)
            if r0 < zero and r1 > zero and e1 >= -reach:
                # It may have been below in between: look where it turns.
                end = d * r0 / (r0 - r1)
                e1 = value_of(curve, end)
                r1 = rate_of(curve, end)
            lands = lands or e1 <= reach
            if pose.touch[k] == CLOSED:
                fails = fails or e1 <= zero
            elif e1 < -reach:
                quiet = (
                    end >= d
                    and e0 <= grain
                    and (r0 <= zero or r0 * r0 <= real(-4.0) * curve[2] * rest[k])
                )
                waits = waits or quiet
                guess = first_root(e0, r0, e1, end)
                d1 = smaller(d1, landing(curve, zero, guess, end, grain))
            if CHAINS:
                # The edge that a body comes to as it turns on.
                room = room_of(blocks, k, side)
                low, _height = lower_face(blocks, k)
                within = size(end_of_edge(blocks, pose, k, side)) < WITHIN * low
                if within and e0 < room and e1 > room + reach:
                    guess = first_root(room - e0, -r0, room - e1, end)
                    d1 = smaller(d1, landing(curve, room, guess, end, grain))
    # Whether a block rests is told by the end of the whole step.
    return wp.where(waits, d, d1), lands, waits, fails


@wp.func(inline=False)
def rolled(
    blocks: Blocks, pose: Pose, touch: Counts, r: Rocking, d: real, near: real, grain: real,
    rest: Values, weight: real, soon: real,
):  # fmt: skip
    """How far a stack gets in a step of length d.

    Args:
        blocks: The blocks.
        pose: Where they are, with the ends that touched before.
        touch: Ends that touch and stick in the step.
        r: What they do.
        d: Longest length of the step [s].
        near: Time by which an impact may be missed [s].
        grain: Round-off of a rotation [rad].
        rest: Swings that are left out [rad].
        weight: That of the stack [N].
        soon: A contact that lacks force within that time lacks it from the start [s].

    Returns:
        Length of the step; LACKS, ROLLS or SPENT; whether a block falls flat or rests.
    """
    d1, lands, waits, fails = to_landing(blocks, r.theta, pose, touch, d, near, grain, rest)
    found = int(ROLLS)
    if fails:
        found = LACKS
    elif not waits:
        slack = SLIGHT * weight
        low = real(0.0)
        at_low = spare_first(blocks, pose, touch, r) + slack
        high = real(d1)
        at_high = spare_at(blocks, pose, touch, r, high) + slack
        if not at_low >= real(0.0):
            found = LACKS
        elif at_high < real(0.0):
            found = SPENT
            left = int(SECANT_STEPS)
            while left > 0:
                middle = low + (high - low) * at_low / (at_low - at_high)
                at = spare_at(blocks, pose, touch, r, middle) + slack
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
            if d1 <= soon:
                found = LACKS
    return d1, found, lands


@wp.func
def rolled_velocity(chain: Chain, pose: Pose, p: Curves, tau: real) -> Triples:
    """Velocities of all blocks at a time in a step, `pose` being that of then."""
    v = Triples()
    x = real(0.0)
    z = real(0.0)
    for k in range(BLOCKS):
        spin = rate_of(p[k], tau)
        s = pose.sine[k]
        c = pose.cosine[k]
        v[3 * k] = x - spin * (chain.bz[k] * c - chain.bx[k] * s)
        v[3 * k + 1] = z + spin * (chain.bx[k] * c + chain.bz[k] * s)
        v[3 * k + 2] = spin
        x = x + spin * (chain.cz[k] * c - chain.cx[k] * s)
        z = z - spin * (chain.cx[k] * c + chain.cz[k] * s)
    return v
