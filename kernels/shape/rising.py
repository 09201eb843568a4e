"""What a base that moves upwards (VERTICAL) changes in a step, and in the account of its lane."""

import warp as wp

if VERTICAL:

    @wp.func
    def fall_in(dt: real, gravity: real, dz: real) -> real:
        """What a step adds to a velocity downwards [m/s]: by gravity, and a base that gains dz."""
        return dt * gravity + dz

    @wp.func
    def sunk_in(dt: real, gravity: real, dz: real) -> real:
        """Penetration that one step of falling can make, twice [m]."""
        return real(2.0) * dt * dt * gravity + real(2.0) * dt * larger(dz, real(0.0))

    @wp.func
    def worked(dv: real, dz: real, ux: real, uz: real) -> real:
        """Work of a mass on its base, over the mass, in a step of which the base gains dv and dz.

        `ux` and `uz` are the sums of the velocities of the mass before and after it [m/s].
        """
        return HALF * dv * ux + HALF * dz * uz

    @wp.func
    def pulled(dv: real, dz: real, fall: real) -> real:
        """Gain along x that would tip a mass as much on a base that keeps its height [m/s].

        `fall` is what gravity makes of a velocity in the step; NEVER where nothing is left of it.
        """
        left = fall + dz
        return wp.where(left > real(0.0), dv * fall / left, NEVER)

else:

    @wp.func
    def fall_in(dt: real, gravity: real, dz: real) -> real:
        """The same by gravity alone."""
        return dt * gravity

    @wp.func
    def sunk_in(dt: real, gravity: real, dz: real) -> real:
        """The same of a base that keeps its height."""
        return real(2.0) * dt * dt * gravity

    @wp.func
    def worked(dv: real, dz: real, ux: real, uz: real) -> real:
        """The same of a base that keeps its height."""
        return HALF * dv * ux

    @wp.func
    def pulled(dv: real, dz: real, fall: real) -> real:
        """Itself."""
        return dv
