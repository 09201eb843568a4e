"""Vectors, quaternions and matrices of three and four numbers, the same types everywhere."""

import warp as wp

Vector = wp.types.vector(length=3, dtype=real)
"""A vector in space; in the plane x, z and rotation of one thing."""
Quaternion = wp.types.vector(length=4, dtype=real)
"""An attitude (x, y, z, w); see shape_space/block.py."""
Matrix = wp.types.matrix(shape=(3, 3), dtype=real)

X, Y, Z = 0, 1, 2
"""Places of the components along the axes in a vector, and of directions in rows."""
