"""State of a stack in space, its momenta and energy, and its contacts before, in and after a step.

The scheme is in event_space/stack/step.py.
"""

import warp as wp

from warprock.kernels.algebra.vectors import Vector
from warprock.kernels.event.block.step import first_root
from warprock.kernels.event_space.block.moves import rotate_attitude, rotate_freely
from warprock.kernels.event_space.lane import Knots, Limits
from warprock.kernels.event_space.stack.contact import (
    AWAIT,
    CONE,
    HOLD,
    HOLD_X,
    HOLD_Y,
    KEEP,
    PUSH,
    Attitudes,
    Ints,
    Own,
    Pose,
    Touches,
    add_contact,
    block_of,
    directions,
    find_corners,
    height_of,
    sticking_bits,
    sticking_law,
    way_of,
)
from warprock.kernels.shape.faces import SLOTS
from warprock.kernels.shape_space.frame import frame, relative_velocity, rotate_diagonal
from warprock.kernels.shape_space.stack import CONTACTS, Bodies, PointNumbers, Points, rows_of

NEARLY = by_precision(1.0e-7, 1.0e-4)
"""Tolerance of the time of an event, as a part of the longest step."""
GRAIN = by_precision(1.0e-14, 1.0e-6)
"""Round-off of a gap, as a part of the half height of the first block."""
HOP = real(4.0)
"""A hop that lasts one step rises by its first velocity times the step over this number."""
LEFT_OUT = real(0.0625)
"""Velocity up to which a contact does not hop, nor slides back, over what gravity gives in the
longest step: a free corner would be back within an eighth of that step. Errors of this are of the
step's second order, as those of bounces that are left out."""

Kept = wp.types.matrix(shape=(16 * BLOCKS, 3), dtype=real)


@wp.struct
class State:
    """State of one lane.

    Centres of mass, attitudes, velocities, angular velocities; turns in the last step [rad]; forces
    of the contacts in the last step, by slot [N]; slots that exist, and those that touch, by
    interface; whether a block flies; whether the stack stands still on all of its contacts; time
    [s]; knots of the motion passed; base velocity [m/s]; cap, the longest next step [s]; mode;
    lost energy [J]; deepest penetration [m]; impacts; trials since a step was taken; whether the
    last one was taken; whether it moved the stack as one.
    """

    x: Bodies
    q: Attitudes
    v: Bodies
    w: Bodies
    turn: Bodies
    force: Kept
    there: Ints
    touch: Ints
    flies: Ints
    still: bool
    closed: bool
    time: real
    knots: Knots
    base: Vector
    cap: real
    mode: int
    lost: real
    deepest: real
    impacts: int
    tries: int
    taken: bool
    whole: bool


@wp.struct
class Look:
    """Contacts at the end of a trial: bits of slots by interface, and length to an event [s]."""

    there: Ints
    touch: Ints
    lands: Ints
    landed: bool
    closed: bool
    deepest: real
    cut: real


@wp.func
def momenta(own: Own, s: State) -> Bodies:
    """Angular momenta for unit mass [m^2/s]."""
    found, one = Bodies(), real(1.0)
    bodies = int(BLOCKS + 1)
    for k in range(1, bodies):
        b = block_of(own, k)
        inertia = rotate_diagonal(
            frame(s.q[k]), one / b.inverse_x, one / b.inverse_y, one / b.inverse_z
        )
        found[k] = inertia * s.w[k]
    return found


@wp.func
def energy(
    own: Own, gravity: real, x: Bodies, q: Attitudes, v: Bodies,
    w: Bodies,
) -> real:  # fmt: skip
    """Energy in the frame of the base [J]."""
    total, one = real(0.0), real(1.0)
    bodies = int(BLOCKS + 1)
    for k in range(1, bodies):
        b = block_of(own, k)
        inertia = rotate_diagonal(
            frame(q[k]), one / b.inverse_x, one / b.inverse_y, one / b.inverse_z
        )
        kinetic = HALF * (wp.dot(v[k], v[k]) + wp.dot(w[k], inertia * w[k]))
        total += b.mass * (kinetic + gravity * (x[k, 2] - b.z))
    return total


@wp.func
def attitudes_after(own: Own, s: State, spin: Bodies, w: Bodies, d: real) -> Attitudes:
    """Attitudes after a time d at the angular velocities w, or of free rotation in flight."""
    q = s.q
    bodies = int(BLOCKS + 1)
    for k in range(1, bodies):
        if s.flies[k] != 0:
            q[k] = rotate_freely(block_of(own, k), s.q[k], spin[k], d)
        else:
            q[k] = rotate_attitude(s.q[k], d * w[k])
    return q


@wp.func
def continue_contacts(own: Own, s: State, pose0: Pose, pose: Pose, rest: real) -> Touches:
    """The contacts of `pose` that touched in the state s."""
    t = Touches()
    bodies = int(BLOCKS + 1)
    slots = int(SLOTS)
    for k in range(1, bodies):
        places, _gaps, there, crossed = find_corners(own, pose, k)
        number = int(0)
        for i in range(slots):
            bit = 1 << i
            if (there & bit) != 0 and number < CONTACTS:
                touches = (s.touch[k] & bit) != 0
                if (s.there[k] & bit) == 0:
                    lever = wp.transpose(rows_of(pose.axes, k - 1)) * places[i]
                    lever = lever + pose.x[k - 1] - pose.x[k]
                    point = rows_of(pose.axes, k) * lever
                    touches = height_of(own, pose0, k, point) <= rest
                if touches:
                    t = add_contact(t, pose, k, way_of(i, crossed), CONE, real(0.0), places[i])
                    number += 1
    return t


@wp.func(inline=False)
def look_at_step(
    own: Own, limits: Limits, s: State, reached: State, pose0: Pose, pose: Pose, held: Ints, d: real
) -> Look:
    """Events of the corners in a step, from their gaps at both of its ends."""
    v, w = reached.v, reached.w
    zero, near, grain = (
        real(0.0),
        NEARLY * limits.longest_step,
        GRAIN * block_of(own, 1).half_height,
    )
    rest, n = limits.rest_gap, Look()
    slow = LEFT_OUT * limits.gravity * limits.longest_step
    n.closed = True
    n.cut = TWO * NEVER
    bodies = int(BLOCKS + 1)
    slots = int(SLOTS)
    for k in range(1, bodies):
        places, gaps, there, crossed = find_corners(own, pose, k)
        places0, gaps0, there0, crossed0 = find_corners(own, pose0, k)
        down, down0 = rows_of(pose.axes, k - 1), rows_of(pose0.axes, k - 1)
        n.there[k] = there
        n.closed = n.closed and there != 0
        touch, lands = int(0), int(0)
        for i in range(slots):
            bit = 1 << i
            if (there & bit) != 0:
                rl = wp.transpose(down) * places[i]
                ru = rl + pose.x[k - 1] - pose.x[k]
                point = rows_of(pose.axes, k) * ru
                before = gaps0[i]
                was = (s.touch[k] & bit) != 0
                # Where a contact slides it passes over both faces: its speed at the start is that
                # of the points which met there, along the normal that it had.
                rl0 = wp.transpose(down0) * places0[i]
                ru0 = rl0 + pose0.x[k - 1] - pose0.x[k]
                if (there0 & bit) == 0:
                    before = height_of(own, pose0, k, point)
                    was = before <= rest
                    ru0 = wp.transpose(rows_of(pose0.axes, k)) * point
                    rl0 = ru0 + pose0.x[k] - pose0.x[k - 1]
                rate = wp.dot(
                    directions(pose.axes, k, way_of(i, crossed))[2],
                    relative_velocity(v[k], w[k], ru, v[k - 1], w[k - 1], rl),
                )
                rate0 = wp.dot(
                    directions(pose0.axes, k, way_of(i, crossed0))[2],
                    relative_velocity(s.v[k], s.w[k], ru0, s.v[k - 1], s.w[k - 1], rl0),
                )
                holds = (held[k] & bit) != 0
                # A corner touches within the same distance above the face and below it.
                reach = larger(near * size(rate) + grain, rest)
                if d > near and not was and gaps[i] < -reach:
                    start = larger(before, zero)
                    cut = first_root(start, rate0, gaps[i], d)
                    if s.tries > 0:
                        # Seen from the end, which is near the landing by now.
                        cut = d - first_root(-gaps[i], rate, -start, d)
                    n.cut = smaller(n.cut, cut)
                # A hop inside the step.
                if d > near and holds and rate0 > slow and rate0 * d > HOP * rest:
                    n.cut = smaller(n.cut, HALF * HALF * d)
                on = holds or gaps[i] <= rest
                touch = touch | wp.where(on, bit, 0)
                lands = lands | wp.where(on and not was and rate < zero, bit, 0)
                n.closed = n.closed and on
                n.deepest = larger(n.deepest, -gaps[i])
        n.touch[k] = touch
        n.lands[k] = lands
        n.landed = n.landed or lands != 0
    return n


@wp.func(inline=False)
def find_stop(
    t: Touches, pose: Pose, p: Points, s: State, vm: Bodies, wm: Bodies, slow: real
) -> real:
    """Part of a step after which the first contact has slid to a stop; above 1 if none has inside.

    Friction does not turn a slide back. Where it would, the contact stops on the way.

    Args:
        t, pose, p: The contacts in the mean of the step, and their impulses [N s].
        s: The state at its start.
        vm, wm: Its mean motion [m/s], [rad/s].
        slow: Slip up to which none counts [m/s].
    """
    found, zero = TWO * NEVER, real(0.0)
    for i in range(t.total):
        k = t.body[i]
        low, slot = k - 1, t.slot[i]
        law = sticking_law(slot, sticking_bits(slot, pose.friction[k], p[i]), CONE)
        if p[i][2] > zero and law != HOLD:
            e = directions(pose.axes, k, t.way[i])
            first = e * relative_velocity(s.v[k], s.w[k], t.ru[i], s.v[low], s.w[low], t.rl[i])
            mean = e * relative_velocity(vm[k], wm[k], t.ru[i], vm[low], wm[low], t.rl[i])
            # Along the directions in which it slides.
            x = wp.where(law == HOLD_X, zero, first[0])
            y = wp.where(law == HOLD_Y, zero, first[1])
            square = x * x + y * y
            back = square - TWO * (x * mean[0] + y * mean[1])
            if square > slow * slow and back > slow * wp.sqrt(square):
                found = smaller(found, square / (square + back))
    return found


@wp.func(inline=False)
def contacts_at_end(own: Own, pose: Pose, look: Look, held: Ints) -> Touches:
    """The contacts at the end of a step, with their laws for closing gaps."""
    t = Touches()
    bodies = int(BLOCKS + 1)
    slots = int(SLOTS)
    for k in range(1, bodies):
        places, gaps, _there, crossed = find_corners(own, pose, k)
        number = int(0)
        for i in range(slots):
            bit = 1 << i
            if (look.touch[k] & bit) != 0 and number < CONTACTS:
                law = wp.where((held[k] & bit) != 0, KEEP, PUSH)
                t = add_contact(t, pose, k, way_of(i, crossed), law, gaps[i], places[i])
                number += 1
    return t


@wp.func
def laws_of_velocity(closing: Touches, look: Look, stuck: Ints) -> Touches:
    """The same contacts with their laws for velocities."""
    t = closing
    for q in range(t.total):
        k, slot = t.body[q], t.slot[q]
        law = sticking_law(slot, stuck[k], t.law[q])
        t.law[q] = wp.where((look.lands[k] & (1 << slot)) != 0, AWAIT, law)
    t.gap = PointNumbers()
    return t
