"""What weighs on a body, seen from its base: gravity, and what a base that moves upwards adds.

In the frame of the base every mass is pulled down by g + a_z(t). Where VERTICAL is not set the base
keeps its height: then a_z is zero, and nothing here leaves a trace in the machine code.
"""

import warp as wp

from warprock.kernels.motion import Motion, series


@wp.struct
class Heave:
    """Taylor coefficients 0 to 8 of the vertical acceleration of the base [m/s^2]."""

    z0: real
    z1: real
    z2: real
    z3: real
    z4: real
    z5: real
    z6: real
    z7: real
    z8: real


if VERTICAL:

    @wp.func
    def heave_at(m: Motion, segment: int, time: real, value: real, slope: real) -> Heave:
        """The vertical motion of the base about a time; arguments as those of `series`."""
        z0, z1, z2, z3, z4, z5, z6, z7, z8 = series(m, segment, time, value, slope)
        return Heave(z0, z1, z2, z3, z4, z5, z6, z7, z8)

    @wp.func
    def heave_after(z: Heave, tau: real) -> real:
        """Vertical acceleration of the base a time tau later [m/s^2]."""
        high = z.z4 + tau * (z.z5 + tau * (z.z6 + tau * (z.z7 + tau * z.z8)))
        return z.z0 + tau * (z.z1 + tau * (z.z2 + tau * (z.z3 + tau * high)))

    # fmt: off
    @wp.func
    def heavy(
        p2: real, q: real, z: Heave, s0: real, s1: real, s2: real, s3: real, s4: real, s5: real,
        s6: real, s7: real, s8: real,
    ) -> real:
        """Coefficient of q (g + a_z) S, from those of S: its own first, then the lower ones."""
        low = z.z0 * s0 + z.z1 * s1 + z.z2 * s2 + z.z3 * s3 + z.z4 * s4
        return p2 * s0 + q * (low + z.z5 * s5 + z.z6 * s6 + z.z7 * s7 + z.z8 * s8)
    # fmt: on

else:

    @wp.func
    def heave_at(m: Motion, segment: int, time: real, value: real, slope: real) -> Heave:
        """No vertical motion."""
        return Heave()

    @wp.func
    def heave_after(z: Heave, tau: real) -> real:
        """None either."""
        return real(0.0)

    # fmt: off
    @wp.func
    def heavy(
        p2: real, q: real, z: Heave, s0: real, s1: real, s2: real, s3: real, s4: real, s5: real,
        s6: real, s7: real, s8: real,
    ) -> real:
        """Coefficient of q g S, from that of S."""
        return p2 * s0
    # fmt: on
