"""Vectors, quaternions and matrices of three and four numbers, the same types everywhere."""

import warp as wp

Vector = wp.types.vector(length=3, dtype=real)
"""A vector in space; in the plane x, z and rotation of one thing."""
Quaternion = wp.types.vector(length=4, dtype=real)
"""An attitude (x, y, z, w); see shape_space/block.py."""
Matrix = wp.types.matrix(shape=(3, 3), dtype=real)
"""A rotation, or a moment of inertia, in space; in the plane one of `Vector`."""

X, Y, Z, W = 0, 1, 2, 3
"""Places of the components in a vector and in a quaternion, and of directions in rows."""
ALONG, UPWARDS = 0, 1
"""Directions in the plane, x and z: rows of the motions of a base and of places."""
ONLY = 0
"""The place of the only one of a kind: the block of a lane, the lane of a team."""
