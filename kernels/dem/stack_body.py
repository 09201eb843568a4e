"""Soft-spring step of a stack in the plane with bodies among its blocks.

As dem/stack.py, with a spring under each of the up to three points of an interface (see
shape/stack_body.py) instead of springs along a face. A point represents half of the contact area of
the interface at rest. The state of a spring moves along with the window; a point that comes into
view counts as opened before.
"""

import warp as wp

from warprock.kernels.dem.stack import FAILED, Knobs, Load, Pace, Spring, solve_spring
from warprock.kernels.shape.body_seen import shift_corners
from warprock.kernels.shape.interface import Point, Pose, Velocity
from warprock.kernels.shape.stack_body import Top, Window, find_foot


@wp.struct
class Interface:
    """The interface below a block.

    Attributes:
        friction: tan(phi).
        area: Area that each of its points represents [m^2].
        start: Place of the block along the face below without slide [m].
        window: Row of the corner with the role 0.
    """

    friction: real
    area: real
    start: real
    window: int


@wp.struct
class Contact:
    """A point of an interface.

    Attributes:
        there: 1 if the point exists, else 0.
        overlap: Its penetration [m].
        vn, vt: Velocity at which it parts, and at which it slides [m/s].
    """

    there: int
    overlap: real
    vn: real
    vt: real


@wp.struct
class Force:
    """Force and energy of the springs of a point.

    Attributes:
        n, t: Normal and tangential force [N].
        stored: Energy in the springs [J].
        held: 1 if the point is pressed and does not slip, else 0.
    """

    n: real
    t: real
    stored: real
    held: int


@wp.struct
class Contacts:
    """Observed points of an interface.

    Attributes:
        first, second: The deepest overlap of a point so far, and the second one [m].
        speed: Slip velocity of the point with the role 0 [m/s].
        held: Points so far that are pressed and do not slip.
    """

    first: real
    second: real
    speed: real
    held: int


@wp.func
def move_springs(
    way: int, one: wp.ref[Spring], two: wp.ref[Spring], three: wp.ref[Spring]
):  # fmt: skip
    """Moves the springs of three points from -x to +x along with their window."""
    a, b, d = shift_corners(way, one.u, two.u, three.u)
    e, f, g = shift_corners(way, one.slip, two.slip, three.slip)
    one.u = a
    two.u = b
    three.u = d
    one.slip = wp.where(way < 0, FAILED, e)
    two.slip = f
    three.slip = wp.where(way > 0, FAILED, g)


@wp.func
def find_contact(
    window: Window, role: int, at: Pose, below: Pose, top: Top, u: Velocity, v: Velocity
):  # fmt: skip
    """A point of an interface, see `find_foot`, and how it moves.

    Args:
        window: See `find_foot`, like all arguments up to `top`.
        u, v: Velocities of the block and of the body below.

    Returns:
        The contact; the point; the place of the block along the touched face [m].
    """
    there, point, gap, place = find_foot(window, role, at, below, top)
    wx, wz = u.x - v.x, u.z - v.z
    contact = Contact(
        wp.where(there, 1, 0), wp.where(there, -gap, -NEVER),
        wx * point.nx + wz * point.nz - point.au * u.omega + point.al * v.omega,
        wx * point.nz - wz * point.nx + point.bu * u.omega - point.bl * v.omega,
    )  # fmt: skip
    return contact, point, place


@wp.func
def press(
    knobs: Knobs, pace: Pace, interface: Interface, contact: Contact, spring: wp.ref[Spring]
) -> Force:  # fmt: skip
    """Force of the springs of a point, see `solve_spring` in dem/stack.py; updates the springs."""
    zero, there, area = real(0.0), contact.there == 1, interface.area
    before = real(spring.slip)
    normal, shear, energy = solve_spring(
        knobs, pace, interface.friction, contact.overlap, contact.vn, contact.vt, spring
    )
    n = wp.where(there, area * normal, zero)
    stored = wp.where(pace.live == 1 and there, HALF * area * energy, zero)
    held = wp.where(n > zero and spring.slip == before, 1, 0)
    return Force(n, wp.where(there, area * shear, zero), stored, held)


@wp.func
def load_blocks(point: Point, force: Force, up: wp.ref[Load], low: wp.ref[Load]):
    """Adds the force of a point to the loads of the block and of the body below."""
    n, t = force.n, force.t
    px = point.nx * n + point.nz * t
    pz = point.nz * n - point.nx * t
    up.x = up.x + px
    up.z = up.z + pz
    up.moment = up.moment + point.bu * t - point.au * n
    low.x = low.x - px
    low.z = low.z - pz
    low.moment = low.moment - point.bl * t + point.al * n


@wp.func
def observe_contact(role: int, contact: Contact, held: int, all: Contacts) -> Contacts:
    """The observed points of an interface, updated by the point with a role."""
    first, depth = contact.overlap > all.first, contact.overlap
    return Contacts(
        wp.where(first, depth, all.first),
        wp.where(first, all.first, larger(depth, all.second)),
        wp.where(role == 0, contact.vt, all.speed),
        all.held + held,
    )
