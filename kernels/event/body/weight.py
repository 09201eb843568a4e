"""Weight of a body of mass 1 in the frame of its base: gravity, and what a rising base adds.

It is g + a_z(t), where a_z is the upward acceleration of the base. An upward velocity step of the
base throws the body down. If VERTICAL is false, the base keeps its height and the weight is g.
"""

import warp as wp

from warprock.kernels.event.block.begin import base_change
from warprock.kernels.motion.kinds import (
    Acceleration,
    acceleration_at,
    expand,
    knot_step,
    knot_time,
)
from warprock.kernels.shape.above import Above


@wp.struct
class Weight:
    """Weight of a body of mass 1 in a step.

    Attributes:
        start, end: Weight at both ends of the step [m/s^2].
        gained: Change of the velocity of the base upwards, without the velocity step at the end
            [m/s].
        kick: Velocity step of the base upwards at the end [m/s].
        passed: Whether the step ends at a knot of the vertical motion.
    """

    start: real
    end: real
    gained: real
    kick: real
    passed: bool


if VERTICAL:

    @wp.func
    def weight_in(gravity: real, above: Above, time: real, d: real, rising: real) -> Weight:
        """Weight in a step of length d that ends at a time; `rising` is the velocity upwards."""
        w = Weight()
        w.passed = time >= knot_time(above.motion, above.segment)
        w.kick = wp.where(w.passed, knot_step(above.motion, above.segment), real(0.0))
        a = expand(above.motion, above.segment, time, above.value, above.slope)
        w.gained = base_change(above.motion, time, d, a.a0, a.a1, rising, w.kick)
        w.end = gravity + a.a0
        w.start = gravity + wp.where(d > real(0.0), TWO * w.gained / d - a.a0, a.a0)
        return w

else:

    @wp.func
    def weight_in(gravity: real, above: Above, time: real, d: real, rising: real) -> Weight:
        """Gravity alone."""
        return Weight(gravity, gravity, real(0.0), real(0.0), False)


@wp.func
def fall_in(weight: Weight, gravity: real, d: real) -> real:
    """Velocity downwards that the weight adds in a step of length d [m/s]."""
    fall = d * gravity
    if VERTICAL:
        fall = fall + weight.gained
    return fall


@wp.func
def nearest_lack(
    along: Acceleration, up: Acceleration, gravity: real, back: real, ahead: real, d: real
):  # fmt: skip
    """What a body at rest lacks until the base lets it go, on the side on which that is less.

    Args:
        along, up: Acceleration of the base.
        gravity: [m/s^2].
        back, ahead: Accelerations of the base to -x and to +x / weight that let it go.
        d: How far to look ahead [s].

    Returns:
        The lack, see event/lift.py; the acceleration that lets it go where the base keeps its
        height [m/s^2].
    """
    last = acceleration_at(along, d)
    weight, weight1 = real(gravity), real(gravity)
    if VERTICAL:
        weight = gravity + up.a0
        weight1 = gravity + acceleration_at(up, d)
    forward = smaller(weight * ahead - along.a0, weight1 * ahead - last) < smaller(
        weight * back + along.a0, weight1 * back + last
    )
    way, part = wp.where(forward, real(-1.0), real(1.0)), wp.where(forward, ahead, back)
    lack = Acceleration(
        fused(way, along.a0, part * weight), way * along.a1, way * along.a2, way * along.a3,
        way * along.a4, way * along.a5, way * along.a6, way * along.a7, way * along.a8,
    )  # fmt: skip
    if VERTICAL:
        lack = Acceleration(
            lack.a0, fused(part, up.a1, lack.a1), fused(part, up.a2, lack.a2),
            fused(part, up.a3, lack.a3), fused(part, up.a4, lack.a4), fused(part, up.a5, lack.a5),
            fused(part, up.a6, lack.a6), fused(part, up.a7, lack.a7), fused(part, up.a8, lack.a8),
        )  # fmt: skip
    return lack, part * gravity


@wp.func
def kicks(weight: Weight, kick: real) -> bool:
    """Whether the base steps its velocity at the end of a step, along x by `kick` or upwards."""
    found = kick != real(0.0)
    if VERTICAL:
        found = found or weight.kick != real(0.0)
    return found


@wp.func
def rise(taken: bool, weight: Weight, rising: wp.ref[real], risen: wp.ref[int]):
    """Updates the velocity of the base upwards [m/s] and the knots that it has passed."""
    if VERTICAL:
        rising = rising + wp.where(taken, weight.gained + weight.kick, real(0.0))
        risen = risen + wp.where(taken and weight.passed, 1, 0)
