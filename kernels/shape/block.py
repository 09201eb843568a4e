"""A single block in the plane, shared by the time-stepping schemes.

Its state, the gap of a corner that has parted, and the mode of its lane. `block` is the struct
`Block` of a scheme and `knobs` its `Knobs`, which have the fields that are used here.
"""

from typing import Any

import warp as wp

from warprock.kernels.contact.parting import slack, slides
from warprock.kernels.lane.modes import BROKEN, OVERTURNED


@wp.struct
class State:
    """A body in the plane, in the frame of its base.

    Attributes:
        x: Centre of mass along the base, from its place at rest [m].
        z: Height of its centre of mass above the base [m].
        theta: Clockwise rotation [rad].
        vx, vz: Velocity of its centre of mass [m/s].
        omega: Angular velocity [rad/s].
    """

    x: real
    z: real
    theta: real
    vx: real
    vz: real
    omega: real


@wp.struct
class Base:
    """Velocity of a lane's base along x and upwards [m/s]."""

    vx: real
    vz: real


@wp.struct
class Gaps:
    """Gaps of two corners [m].

    Attributes:
        lowest: Gap of the lower corner at the start of the step.
        left, right: Gaps of the -x and of the +x corner after the step, along their velocities.
    """

    lowest: real
    left: real
    right: real


@wp.func
def slide_of(block: Any, x: real, theta: real) -> real:
    """Slide along the base of the corner that the block stands on [m]."""
    side = wp.where(theta < real(0.0), real(-1.0), real(1.0))
    turned = in_range(theta)
    along = fused(side * block.half_width, cosine(turned) - real(1.0), x)
    return fused_less(block.half_height, sine(turned), along)


@wp.func
def height_of(block: Any, theta: real) -> real:
    """Height of the centre of mass of a block that stands on its lower corner [m]."""
    return block.half_width * size(sine(theta)) + block.half_height * cosine(theta)


@wp.func
def limit_of(block: Any, knobs: Any, omega: real) -> real:
    """Gap beyond which a corner has parted from the base [m]."""
    reach = block.half_width + block.half_height
    return slack(knobs.time_step, knobs.gravity, reach, omega * omega, reach)


@wp.func
def glides(block: Any, knobs: Any, vx: real, omega: real) -> bool:
    """Whether a flat block slides."""
    way = knobs.time_step * fused_less(block.half_height, omega, vx)
    return slides(way, knobs.time_step, knobs.gravity)


@wp.func
def mode_of(mode: int, theta: real, omega: real, slide: real) -> int:
    """Mode of a lane after a step: OVERTURNED, BROKEN, or `mode`.

    Args:
        mode: Its mode by its scheme.
        theta: Rotation [rad].
        omega: Angular velocity [rad/s].
        slide: Slide along the base [m].
    """
    zero = real(0.0)
    over = size(theta) >= HALF_PI
    sound = theta - theta == zero and omega - omega == zero and slide - slide == zero
    return wp.where(sound, wp.where(over, OVERTURNED, mode), BROKEN)
