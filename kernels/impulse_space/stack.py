"""Velocity-level contact step of a stack of blocks in space.

Bodies are numbered from the ground: body 0 is the ground, an endless face that nothing moves, body
k the k-th block. The step is that of a single block (see impulse_space/block.py), body by body. The
contacts of interface k, below block k, are the corners of the overlap of the bottom face of block k
and the top face below (see shape/faces.py), found once a step. Their normal is that of the lower
face; impulses and slips are along its width, its depth and its normal. The velocity of a contact at
the levers r_u and r_l from the centres of the two blocks is

    v_u + omega_u x r_u - v_l - omega_l x r_l.

The sweeps go from the ground up. In a mirrored scene they visit the corners of an interface in
mirrored order. erp moves all blocks above an interface along its normal, by erp times its
penetration beyond 2 g dt^2, the fall that one step can make. Angular momenta and moments of inertia
are those for unit mass, impulses are in N s.
"""

import warp as wp

from warprock.kernels.algebra.vectors import Vector
from warprock.kernels.impulse_space.block import Knobs
from warprock.kernels.shape.faces import SLOTS
from warprock.kernels.shape_space.contact import gains_of, solve_contact
from warprock.kernels.shape_space.frame import (
    parts_along,
    push_spin,
    push_velocity,
    relative_velocity,
)
from warprock.kernels.shape_space.stack import (
    CONTACTS,
    UPPER,
    WHOLE,
    Axes,
    Bodies,
    CornerNumbers,
    Numbers,
    PointGains,
    PointInts,
    PointNumbers,
    Points,
    rows_of,
    slot_in_turn,
)

FAR = real(1.0e30)

SETTLED = real(1.0e-14)
"""Relative change of the impulses in a sweep that is round-off."""

Chosen = wp.types.vector(length=CONTACTS, dtype=int)
"""Slots of contacts."""


@wp.struct
class Pose:
    """Pose of all bodies in a step.

    Attributes:
        axes: Axes of each body, three rows; a lower body's are the directions of a contact.
        ease: Inverse inertia of each body [1/(kg m^2)], three rows.
        friction: Friction coefficient under each body.
        light: Inverse mass of each body [1/kg].
    """

    axes: Axes
    ease: Axes
    friction: Numbers
    light: Numbers


@wp.struct
class Touches:
    """The contacts of a stack in a step.

    Attributes:
        total: How many there are.
        body: Upper body of each.
        gap: Gap of each [m].
        ru, rl: Levers of each from the upper and the lower centre of mass [m].
    """

    total: int
    body: PointInts
    gap: PointNumbers
    ru: Points
    rl: Points


@wp.func
def solve(
    sweeps: int, rate: real, pose: wp.ref[Pose], t: wp.ref[Touches], first: Points, v: Bodies,
    w: Bodies,
):  # fmt: skip
    """Projected Gauss-Seidel on all contacts: their impulses, and the velocities of the bodies.

    Args:
        sweeps: Largest number; they end once a sweep changes only round-off.
        rate: Inverse of the time step [1/s].
        pose: The bodies.
        t: The contacts.
        first: Impulses to start from [N s].
        v, w: Velocity [m/s] and angular velocity [rad/s] of each body without contact.
    """
    u, o, p, gains = Bodies(), Bodies(), Points(), PointGains()
    # Local copies: sweeps that read the levers from their struct take a third to a half longer.
    # Copies of axes and inverse inertias gain nothing.
    ru = t.ru
    rl = t.rl
    friction = pose.friction
    light = pose.light
    body = t.body
    gap = t.gap
    total = t.total
    bodies = int(BLOCKS + 1)
    for k in range(bodies):
        u[k] = v[k]
        o[k] = w[k]
    for step in range(-1, sweeps):
        change, norm_sq = real(0.0), real(0.0)
        for i in range(total):
            k = body[i]
            low = k - 1
            e, ju, jl = rows_of(pose.axes, low), rows_of(pose.ease, k), rows_of(pose.ease, low)
            new = first[i]
            if step < 0:
                gains[i] = gains_of(light[k] + light[low], e, ju, jl, ru[i], rl[i])
            else:
                at = relative_velocity(u[k], o[k], ru[i], u[low], o[low], rl[i])
                new = solve_contact(friction[k], gap[i], rate, gains[i], e, p[i], at)
            more = wp.transpose(e) * (new - p[i])
            change += wp.dot(more, more)
            norm_sq += wp.dot(new, new)
            p[i] = new
            u[k] = push_velocity(u[k], light[k], more)
            o[k] = push_spin(o[k], ju, ru[i], more)
            # The ground does not move.
            if low > 0:
                u[low] = push_velocity(u[low], light[low], -more)
                o[low] = push_spin(o[low], jl, rl[i], -more)
        if step >= 0 and change <= SETTLED * SETTLED * norm_sq:
            break
    return p, u, o


@wp.func
def fastest_slip(pose: wp.ref[Pose], t: wp.ref[Touches], u: Bodies, o: Bodies) -> real:
    """Square of the speed at which the fastest contact slides [m^2/s^2]; see `solve`."""
    most = real(0.0)
    for i in range(t.total):
        k = t.body[i]
        v = relative_velocity(u[k], o[k], t.ru[i], u[k - 1], o[k - 1], t.rl[i])
        x, y, _z = parts_along(rows_of(pose.axes, k - 1), v)
        most = larger(most, dot(x, y, x, y))
    return most


@wp.struct
class Opening:
    """Observed gaps of an interface in a step.

    Attributes:
        wide: Bits of the slots that do not touch now.
        lands: 1 if a slot touches that did not before.
        deep: Deepest penetration [m].
        push: Correction of that by erp [m].
    """

    wide: int
    lands: int
    deep: real
    push: real


@wp.func
def find_contacts(gaps: CornerNumbers, there: int, lean: Vector, was: int, knobs: Knobs):
    """The contacts among the corners of the overlap of two faces.

    Args:
        gaps: Gaps by slot [m].
        there: Bits of the slots that exist.
        lean: Sides to which the upper block leans, for the order of the contacts.
        was: Bits of the slots that did not touch in the last step.
        knobs: Settings.

    Returns:
        Slots of the contacts and their number; and the observed gaps of the interface.
    """
    zero = real(0.0)
    slack = real(2.0) * knobs.time_step * knobs.time_step * knobs.gravity
    chosen, number, wide, lands, deep = Chosen(), int(0), int(0), int(0), real(-FAR)
    slots = wp.where(there == WHOLE, UPPER, int(SLOTS))
    for s in range(slots):
        t = slot_in_turn(s, lean)
        bit = 1 << t
        if (there & bit) != 0:
            deep = larger(deep, -gaps[t])
            if gaps[t] > knobs.collision_margin + slack:
                wide = wide | bit
            elif (was & bit) != 0:
                lands = 1
            if gaps[t] <= knobs.collision_margin and number < CONTACTS:
                chosen[number] = t
                number += 1
    push = knobs.erp * larger(deep - slack, zero)
    return chosen, number, Opening(wide, lands, deep, push)
