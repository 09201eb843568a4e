"""The part of a body on contact points that a step needs: one corner and its neighbours."""

import warp as wp

from warprock.kernels.event.block.state import End, Span, State
from warprock.kernels.event.block.step import GRAIN, NEARLY
from warprock.kernels.event.body.contact import Body, Edge, tips_right
from warprock.kernels.event.body.weight import Weight
from warprock.kernels.lane.modes import FLAT, FLYING
from warprock.kernels.shape.body import rotated_x, rotated_z


@wp.struct
class View:
    """Corner k and its neighbours, from the centre of mass at the rotation zero.

    Attributes:
        corner: k.
        x, z: Its place [m].
        low, high: Rotations at which the edges on both sides lie flat [rad].
        left_x, left_z: The corner to -x [m], k itself if it is the first.
        right_x, right_z: The corner to +x [m], k itself if it is the last.
        flat_right: Whether a body that lies flat lies on the edge to +x of k.
    """

    corner: int
    x: real
    z: real
    low: real
    high: real
    left_x: real
    left_z: real
    right_x: real
    right_z: real
    flat_right: bool


@wp.func
def edge_of(body: Body, x1: real, z1: real, x2: real, z2: real, s: real, c: real) -> Edge:
    """The edge between two corners, the first at -x, of a body turned by (s, c)."""
    return Edge(
        rotated_x(x1, z1, s, c), rotated_x(x2, z2, s, c), body.radius - rotated_z(x1, z1, s, c)
    )


@wp.func
def edge_below(body: Body, view: View, s: real, c: real) -> Edge:
    """The edge on which a flat body lies, turned by (s, c)."""
    right = view.flat_right
    return edge_of(
        body,
        wp.where(right, view.x, view.left_x),
        wp.where(right, view.z, view.left_z),
        wp.where(right, view.right_x, view.x),
        wp.where(right, view.right_z, view.z),
        s,
        c,
    )


@wp.func
def tips_about_second(
    body: Body, gravity: real, weight: Weight, edge: Edge, s: State, span: Span
) -> bool:
    """Whether a body on an edge would tip about the end at +x in a step, see `tips_right`."""
    uz = -HALF * span.d * gravity
    if VERTICAL:
        uz = uz - HALF * weight.gained
    return tips_right(body.friction, s.slip, edge, s.vx - HALF * span.dv, uz)


@wp.func
def find_contacts(body: Body, view: View, end: End):
    """Which corners have come down to the base at the end of a step.

    Args:
        body: The body.
        view: The corner and its neighbours.
        end: The end of the step; its `deep` is that of the corner alone.

    Returns:
        Whether the corner to +x has landed or become the lowest one; the same of that to -x;
        whether a flying corner lands; largest penetration of a corner [m].
    """
    near = NEARLY * body.longest_step
    s, c = sine(end.theta), cosine(end.theta)
    spot = rotated_z(view.x, view.z, s, c)
    zero, lies, flies = real(0.0), end.mode == FLAT, end.mode == FLYING
    right, left = end.omega > zero, end.omega < zero
    high, low = end.theta >= view.high - near * end.omega, end.theta <= view.low - near * end.omega
    up = not lies and right and high
    down = not lies and left and low
    rise = end.vz - end.omega * rotated_x(view.x, view.z, s, c)
    grain = GRAIN * (body.radius - spot)
    sinks, meets = rise < zero, end.gap <= grain - near * rise
    lands = flies and sinks and meets
    below = smaller(
        rotated_z(view.left_x, view.left_z, s, c), rotated_z(view.right_x, view.right_z, s, c)
    )
    return up, down, lands, larger(end.deep, spot - below + end.deep)
