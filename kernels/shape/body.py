"""A body on contact points in the plane, as the schemes share it.

Its contact points are the corners of a chain, convex towards the ground, from the one farthest to
-x to the one farthest to +x; from the centre of mass, at the rotation zero, corner k is at (x, z).
Ground is flat, so that at a rotation theta (clockwise) no other corner can be lowest than the one
with

    angle(k - 1) <= theta <= angle(k),

angle(k) the rotation at which the edge between corners k and k + 1 lies flat; it grows with k. The
first corner has none before it and the last one none after it.

A body that rolls over from corner to corner moves on without sliding. `along` is where corner k
comes to stand on the ground then: it grows by the lengths of the edges. The slide is how far the
lowest corner has come from there.
"""

import warp as wp


@wp.struct
class Corner:
    """A corner of a lane's body, [m] and [rad]; beyond the last one `angle` is NEVER."""

    x: real
    z: real
    angle: real
    along: real


@wp.func
def is_past(theta: real, angle: real) -> int:
    """One where a body has turned beyond the edge with this angle: the corners before it count."""
    return wp.where(theta > angle, 1, 0)


@wp.func
def turned_x(x: real, z: real, s: real, c: real) -> real:
    """X of a corner of a body turned by an angle with the sine s and the cosine c [m]."""
    return x * c + z * s


@wp.func
def turned_z(x: real, z: real, s: real, c: real) -> real:
    """Z of the same [m]."""
    return z * c - x * s


@wp.func
def turn_corner(x: real, z: real, s: real, c: real):
    """X and z of the same [m]."""
    return turned_x(x, z, s, c), turned_z(x, z, s, c)
