"""A body on contact points in the plane, shared by the schemes.

Its contact points are the corners of a chain, convex towards the ground, from the one farthest to
-x to the one farthest to +x. Corner k lies at (x, z) from the centre of mass at the rotation zero.
On flat ground the lowest corner at a rotation theta (clockwise) is the one with

    angle(k - 1) <= theta <= angle(k),

where angle(k) is the rotation at which the edge between corners k and k + 1 lies flat. It grows
with k. The first corner has no lower bound and the last one no upper bound.

A body that rolls from corner to corner moves along the ground without sliding. Corner k then stands
at the place `along`, which grows by the length of an edge from corner to corner. The slide is the
distance of the lowest corner from its place.
"""

import warp as wp


@wp.struct
class Corner:
    """A corner of the body of a lane, [m] and [rad]; `angle` of the last one is NEVER."""

    x: real
    z: real
    angle: real
    along: real


@wp.func
def is_past(theta: real, angle: real) -> int:
    """1 if a body has turned beyond the edge with this angle, else 0."""
    return wp.where(theta > angle, 1, 0)


@wp.func
def rotated_x(x: real, z: real, s: real, c: real) -> real:
    """X of a corner of a body turned by an angle with the sine s and the cosine c [m]."""
    return x * c + z * s


@wp.func
def rotated_z(x: real, z: real, s: real, c: real) -> real:
    """Z of a corner of a body turned by such an angle [m]."""
    return z * c - x * s


@wp.func
def rotate_corner(x: real, z: real, s: real, c: real):
    """X and z of a corner of a body turned by such an angle [m]."""
    return rotated_x(x, z, s, c), rotated_z(x, z, s, c)
