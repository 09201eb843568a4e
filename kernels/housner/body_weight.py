"""What weighs on a body, seen from its base: gravity, and what a base that moves upwards adds.

In the frame of the base every mass is pulled down by g + a_z(t). Where VERTICAL is not set the base
keeps its height: then a_z is zero, and nothing here leaves a trace in the machine code.
"""

import warp as wp

from warprock.kernels.motion.kinds import Acceleration, expand
from warprock.kernels.shape.above import Above


@wp.struct
class Sines:
    """Taylor coefficients of S found so far: sk is the one k before the last, or zero."""

    s0: real
    s1: real
    s2: real
    s3: real
    s4: real
    s5: real
    s6: real
    s7: real
    s8: real


@wp.func
def push(s: real, found: Sines) -> Sines:
    """Adds the next coefficient."""
    f = found
    return Sines(s, f.s0, f.s1, f.s2, f.s3, f.s4, f.s5, f.s6, f.s7)


if VERTICAL:

    @wp.func
    def expand_above(above: Above, time: real) -> Acceleration:
        """Vertical acceleration of the base about a time."""
        return expand(above.motion, above.segment, time, above.value, above.slope)

    @wp.func
    def lift_at(z: Acceleration, tau: real) -> real:
        """Vertical acceleration of the base a time tau later [m/s^2]."""
        high = z.a4 + tau * (z.a5 + tau * (z.a6 + tau * (z.a7 + tau * z.a8)))
        return z.a0 + tau * (z.a1 + tau * (z.a2 + tau * (z.a3 + tau * high)))

    @wp.func
    def weigh(p2: real, q: real, z: Acceleration, s: Sines) -> real:
        """Coefficient of q (g + a_z) S [1/s^2], of the order of the last one of S; p2 is q g."""
        low = z.a0 * s.s0 + z.a1 * s.s1 + z.a2 * s.s2 + z.a3 * s.s3 + z.a4 * s.s4
        return p2 * s.s0 + q * (low + z.a5 * s.s5 + z.a6 * s.s6 + z.a7 * s.s7 + z.a8 * s.s8)

else:

    @wp.func
    def expand_above(above: Above, time: real) -> Acceleration:
        """Zero: the base keeps its height."""
        return Acceleration()

    @wp.func
    def lift_at(z: Acceleration, tau: real) -> real:
        """Zero: the base keeps its height [m/s^2]."""
        return real(0.0)

    @wp.func
    def weigh(p2: real, q: real, z: Acceleration, s: Sines) -> real:
        """Coefficient of q g S [1/s^2], of the order of the last one of S; p2 is q g."""
        return p2 * s.s0
