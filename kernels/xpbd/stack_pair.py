"""Functions of xpbd/stack.py at the interface of two blocks.

stack_ground.py has the same functions for a block on the ground.
"""

import warp as wp

from warprock.kernels.shape.interface import Impulse, Mass, Point, Velocity, add_impulses

TURNS = 1
"""Sweeps over an interface before the next one is visited."""


@wp.struct
class Contact:
    """The conditions of an end in a pass, without multipliers.

    Attributes:
        gap: Growth of the gap; in the pose pass the gap [m].
        slip: Change of the place; in the pose pass its distance from the anchor [m].
        dn: Normal multiplier per metre of gap [kg]; zero for an open end.
    """

    gap: real
    slip: real
    dn: real


@wp.struct
class Grip:
    """How an end sticks.

    Attributes:
        dt: Tangential multiplier per metre of slip [kg]; zero for an open end.
        anchor: Place at which the end came to stick [m], or LOOSE.
    """

    dt: real
    anchor: real


@wp.struct
class End:
    """An end of an interface in a pass: its point, its conditions, its multipliers so far.

    `dt` is that of its `Grip`.
    """

    point: Point
    contact: Contact
    dt: real
    last: Impulse


@wp.struct
class Coupling:
    """Gaps (n) and slips (t) of both ends per unit multiplier [1/kg].

    `n1t2` is the gap of the first end per t of the second, which equals the slip of the second end
    per n of the first.
    """

    n1n1: real
    t1t1: real
    n2n2: real
    t2t2: real
    n1t1: real
    n2t2: real
    n1n2: real
    t1t2: real
    n1t2: real
    t1n2: real


@wp.func
def couple(up: Mass, low: Mass, one: Point, two: Point) -> Coupling:
    """The coupling of the multipliers of both ends of an interface.

    Args:
        up, low: Masses of the upper and of the lower body.
        one, two: The ends.
    """
    both = up.m + low.m
    along = both * dot(one.nx, one.nz, two.nx, two.nz)
    across = both * wedge(one.nx, one.nz, two.nx, two.nz)
    pu, pv, lu, lv = up.j * one.au, up.j * one.bu, low.j * one.al, low.j * one.bl
    qu, qv, ku, kv = up.j * two.au, up.j * two.bu, low.j * two.al, low.j * two.bl
    return Coupling(
        fused(lu, one.al, fused(pu, one.au, both)), fused(lv, one.bl, fused(pv, one.bu, both)),
        fused(ku, two.al, fused(qu, two.au, both)), fused(kv, two.bl, fused(qv, two.bu, both)),
        -dot(pu, lu, one.bu, one.bl), -dot(qu, ku, two.bu, two.bl),
        fused(lu, two.al, fused(pu, two.au, along)), fused(lv, two.bl, fused(pv, two.bu, along)),
        fused_less(lu, two.bl, fused_less(pu, two.bu, across)),
        -fused(lv, two.al, fused(pv, two.au, across)),
    )  # fmt: skip


@wp.func
def gap_and_slip(end: End, u: Velocity, v: Velocity):
    """Gap and slip of an end after the corrections u of the upper and v of the lower body [m]."""
    wx, wz, point = u.x - v.x, u.z - v.z, end.point
    gap = fused(point.nz, wz, fused(point.nx, wx, end.contact.gap))
    slip = fused_less(point.nx, wz, fused(point.nz, wx, end.contact.slip))
    grown = fused_less(point.au, u.omega, gap)
    slipped = fused(point.bu, u.omega, slip)
    return fused(point.al, v.omega, grown), fused_less(point.bl, v.omega, slipped)


@wp.func
def add_changes(
    up: Mass, low: Mass, first: End, second: End, one: Impulse, two: Impulse,
    u: wp.ref[Velocity], v: wp.ref[Velocity],
):  # fmt: skip
    """Updates the corrections of both bodies by the change of the multipliers of both ends.

    Args:
        up, low: Masses of the upper and of the lower body.
        first, second: The ends, with their multipliers before.
        one, two: Their multipliers now.
        u, v: Corrections of the upper and of the lower body.
    """
    gained = Impulse(one.n - first.last.n, one.t - first.last.t)
    add_impulses(up, low, first.point, gained, u, v)
    gained = Impulse(two.n - second.last.n, two.t - second.last.t)
    add_impulses(up, low, second.point, gained, u, v)
