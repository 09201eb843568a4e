"""Soft-spring step of a body on contact points.

As dem/stack.py, with a spring under every corner (see shape/body.py) instead of springs along a
face. In the frame of the base, z is the height of the centre of mass above that of the rigid body
at rest. A corner lies at (x, z) from it at the rotation zero, `raised` above the ground, and at
(X, Z) at the rotation theta. Then

    overlap  o = -(z + raised - x s - z_corner (1 - c)),
    parting  v_n = vz - omega X,
    sliding  v_t = vx + omega Z.

Each spring represents an area of the base.
"""

import warp as wp

from warprock.kernels.dem.stack import Knobs, Load, Pace, Spring, solve_spring
from warprock.kernels.shape.body import rotated_x, rotated_z
from warprock.kernels.shape.interface import Pose, Velocity


@wp.struct
class Corner:
    """A corner of a lane's body, with a spring.

    Attributes:
        x, z: From the centre of mass at the rotation zero [m].
        raised: Height above the ground of a rigid body at rest [m]; endless of a row that is none.
        along: See shape/body.py [m].
        area: Area that its spring represents [m^2].
    """

    x: real
    z: real
    raised: real
    along: real
    area: real


@wp.struct
class Deepest:
    """The corners of a body that are deepest in the base.

    Attributes:
        first, second: The deepest overlap of a corner so far, and the second one [m].
        corner: Number of the deepest corner so far.
    """

    first: real
    second: real
    corner: int


@wp.func
def depth_of(x: real, z: real, raised: real, height: real, s: real, lift: real) -> real:
    """Penetration of a corner [m].

    Args:
        x, z, raised: Fields of `Corner`.
        height: Of the centre of mass of the body over that at rest [m].
        s: Sine of the rotation of the body, lift 1 - cosine of it.
    """
    return x * s + z * lift - raised - height


@wp.func
def find_deepest(number: int, depth: real, deep: Deepest) -> Deepest:
    """The deepest corners, updated by a corner with a number and a depth [m]."""
    first = depth > deep.first
    return Deepest(
        wp.where(first, depth, deep.first),
        wp.where(first, deep.first, larger(depth, deep.second)),
        wp.where(first, number, deep.corner),
    )


@wp.func
def has_work(depth: real, spring: Spring) -> int:
    """Whether a spring may carry, 1 or 0; it does not if it has opened before and is open."""
    zero = real(0.0)
    return wp.where(depth <= zero and spring.u == zero and spring.slip > zero, 0, 1)


@wp.struct
class Pressed:
    """Energy and number of pressed springs of a body.

    Attributes:
        stored: Energy in them [J].
        held: Corners that are pressed and do not slip.
    """

    stored: real
    held: int


@wp.func
def press(
    knobs: Knobs, pace: Pace, mu: real, corner: Corner, depth: real, at: Pose, u: Velocity,
    spring: wp.ref[Spring],
):  # fmt: skip
    """Adds the load of the spring of a corner to its body, with its energy and whether it sticks.

    Args:
        knobs: See `solve_spring` in dem/stack.py, as pace, mu and spring.
        corner: The corner.
        depth: Penetration of the corner [m].
        at, u: Pose and velocity of the body.
        spring: The spring; updated.
    """
    lever_x = rotated_x(corner.x, corner.z, at.s, at.c)
    lever_z = rotated_z(corner.x, corner.z, at.s, at.c)
    before = real(spring.slip)
    normal, shear, energy = solve_spring(
        knobs, pace, mu, depth, u.z - u.omega * lever_x, u.x + u.omega * lever_z, spring
    )
    load = Load(
        corner.area * shear, corner.area * normal,
        corner.area * (shear * lever_z - normal * lever_x),
    )  # fmt: skip
    zero = real(0.0)
    stored = wp.where(pace.live == 1, HALF * corner.area * energy, zero)
    held = wp.where(normal > zero and spring.slip == before, 1, 0)
    return load, Pressed(stored, held)
