"""Soft-spring step of a body on contact points.

As dem/stack.py, with a spring under every corner (see shape/body.py) in the place of springs along
a face. In the frame of the base, z is the height of the centre of mass over that of the rigid body
at rest; a corner (x, z) from it at the rotation zero, raised by `rise` above the ground then, is at
(X, Z) from it at theta, and

    overlap  o = -(z + raised - x s - z_corner (1 - c)),
    parting  v_n = vz - omega X,
    sliding  v_t = vx + omega Z.

The stresses of the spring stand for an area of the base.
"""

import warp as wp

from warprock.kernels.dem.stack import Knobs, spring
from warprock.kernels.shape.body import turned_x, turned_z


@wp.struct
class Spring:
    """A corner of a lane's body, and its spring.

    Attributes:
        x, z: From the centre of mass at the rotation zero [m].
        raised: Height above the ground of a rigid body at rest [m]; endless of a row that is none.
        along: See shape/body.py [m].
        area: That it stands for [m^2].
    """

    x: real
    z: real
    raised: real
    along: real
    area: real


@wp.func
def find_overlap(
    number: int, corner_x: real, corner_z: real, raised: real, z: real, s: real, lift: real,
    u: real, slip: real, overlap: wp.ref[real], deep: wp.ref[real], second: wp.ref[real],
    deepest: wp.ref[int], busy: wp.ref[int],
):  # fmt: skip
    """Finds how deep a corner is in the base, and whether its spring has anything to do.

    A spring does nothing that has opened before and is open.

    Args:
        number: Of the corner.
        corner_x, corner_z, raised: Fields of `Spring`.
        z: Height of the centre of mass of the body; s and lift sine of its rotation and 1 - cosine.
        u, slip: State of the spring, see `spring` in dem/stack.py.
        overlap: Depth [m]; found.
        deep, second: The deepest overlap of a corner so far, and the second one [m].
        deepest: Number of the deepest corner so far.
        busy: Springs so far that have something to do.
    """
    zero = real(0.0)
    depth = corner_x * s + corner_z * lift - raised - z
    old = real(deep)
    first = depth > old
    second = wp.where(first, old, larger(depth, second))
    deep = wp.where(first, depth, old)
    deepest = wp.where(first, number, deepest)
    idle = depth <= zero and u == zero and slip > zero
    busy = busy + wp.where(idle, 0, 1)
    overlap = depth


@wp.func
def press(
    knobs: Knobs, live: bool, mu: real, dt: real, corner_x: real, corner_z: real, area: real,
    overlap: real, s: real, c: real, vx: real, vz: real, omega: real,
    u: wp.ref[real], slip: wp.ref[real], fx: wp.ref[real], fz: wp.ref[real], moment: wp.ref[real],
    stored: wp.ref[real], held: wp.ref[int],
):  # fmt: skip
    """Adds what the spring of a corner does to a body.

    Args:
        knobs: See `spring` in dem/stack.py, as live, mu, dt, overlap, u and slip.
        corner_x, corner_z, area: Fields of `Spring`.
        s, c: Sine and cosine of the rotation of the body; vx, vz and omega its velocities.
        fx, fz: Force on the body so far [N], moment clockwise [N m].
        stored: Energy in the springs so far [J].
        held: Corners so far that are pressed and do not slip.
    """
    zero = real(0.0)
    lever_x = turned_x(corner_x, corner_z, s, c)
    lever_z = turned_z(corner_x, corner_z, s, c)
    before = real(slip)
    normal, shear, energy = spring(
        knobs, live, mu, dt, overlap, vz - omega * lever_x, vx + omega * lever_z, u, slip
    )
    fx = fx + area * shear
    fz = fz + area * normal
    moment = moment + area * (shear * lever_z - normal * lever_x)
    stored = stored + wp.where(live, HALF * area * energy, zero)
    held = held + wp.where(normal > zero and slip == before, 1, 0)
