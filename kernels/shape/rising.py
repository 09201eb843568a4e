"""Effect of a base that moves upwards (VERTICAL) on a step and on the energy account of a lane."""

import warp as wp

if VERTICAL:

    @wp.func
    def fall_in(dt: real, gravity: real, dz: real) -> real:
        """Velocity downwards that a step adds [m/s], by gravity and by a base that gains dz."""
        return dt * gravity + dz

    @wp.func
    def fall_depth(dt: real, gravity: real, dz: real) -> real:
        """Twice the penetration that the fall in one step can make [m]."""
        return real(2.0) * dt * dt * gravity + real(2.0) * dt * larger(dz, real(0.0))

    @wp.func
    def base_work(dv: real, dz: real, ux: real, uz: real) -> real:
        """Work of a body on its base per unit mass, in a step in which the base gains dv and dz.

        `ux` and `uz` are the sums of the velocities of the body before and after it [m/s].
        """
        return HALF * dv * ux + HALF * dz * uz

    @wp.func
    def equivalent_gain(dv: real, dz: real, fall: real) -> real:
        """Gain dv of the base that would tip a body as much if the base kept its height [m/s].

        `fall` is the velocity that gravity gives in the step [m/s]. Returns NEVER if the rise of
        the base cancels it.
        """
        left = fall + dz
        return wp.where(left > real(0.0), dv * fall / left, NEVER)

else:

    @wp.func
    def fall_in(dt: real, gravity: real, dz: real) -> real:
        """Velocity downwards that a step adds by gravity [m/s]."""
        return dt * gravity

    @wp.func
    def fall_depth(dt: real, gravity: real, dz: real) -> real:
        """Twice the penetration that the fall in one step can make [m]."""
        return real(2.0) * dt * dt * gravity

    @wp.func
    def base_work(dv: real, dz: real, ux: real, uz: real) -> real:
        """Work of a body on its base per unit mass, in a step in which the base gains dv."""
        return HALF * dv * ux

    @wp.func
    def equivalent_gain(dv: real, dz: real, fall: real) -> real:
        """The gain dv itself: the base keeps its height."""
        return dv
