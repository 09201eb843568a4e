"""A rigid block that pivots on one of its two base corners, from vectors alone.

Everything here follows from four statements: the moment of a force is the cross product of its
lever arm with it; the moment of inertia about a corner is the central one plus mass times the
squared distance (parallel axes); an impact of the free corner conserves the angular momentum
about that corner, because the impulse of the base passes through it; and a velocity step of the
base conserves, seen from the base, everything but the impulse that the step gives the mass.

The frame moves with the base: x along the base, y up, angles and moments counter-clockwise; what
the base does is a vector in it. A block that leans towards +x stands on its +x corner (side = +1)
and has turned clockwise.
"""

from __future__ import annotations

import math

from warprock.units import GRAVITY

Vector = tuple[float, float]


def cross(left: Vector, right: Vector) -> float:
    """The out-of-plane component of the cross product of two vectors of the plane."""
    return left[0] * right[1] - left[1] * right[0]


def turned(vector: Vector, angle: float) -> Vector:
    """A vector turned counter-clockwise by an angle [rad]."""
    c, s = math.cos(angle), math.sin(angle)
    return (c * vector[0] - s * vector[1], s * vector[0] + c * vector[1])


class PivotingBlock:
    """A homogeneous rectangular block standing on a base corner.

    The tilt is the angle by which the block has turned outwards about its corner, >= 0 [rad]; the
    tilt rate its time derivative [rad/s]. `side` is +1 on the +x corner, -1 on the other.
    """

    def __init__(
        self, width: float, height: float, depth: float, density: float, restitution: float | None
    ) -> None:
        """Derives masses and levers.

        Args:
            width: Full width [m].
            height: Full height [m].
            depth: Full depth [m].
            density: [kg/m^3].
            restitution: Prescribed ratio of the angular velocities after and before an impact;
                None lets the conservation of angular momentum decide.
        """
        self.mass = density * width * height * depth
        corners: dict[int, Vector] = {1: (0.5 * width, 0.0), -1: (-0.5 * width, 0.0)}
        centre: Vector = (0.0, 0.5 * height)
        self.levers: dict[int, Vector] = {
            side: (centre[0] - corner[0], centre[1] - corner[1]) for side, corner in corners.items()
        }
        self.free_corners: dict[int, Vector] = {
            side: (corners[-side][0] - corner[0], corners[-side][1] - corner[1])
            for side, corner in corners.items()
        }
        self.central_inertia = self.mass * (width * width + height * height) / 12.0
        arm_x, arm_y = self.levers[1]
        self.corner_inertia = self.central_inertia + self.mass * (arm_x * arm_x + arm_y * arm_y)
        self.critical_tilt = math.atan2(width, height)
        self._restitution = restitution

    def tilt_acceleration(
        self, side: int, tilt: float, base_acceleration: Vector, rate: float = 0.0
    ) -> float:
        """Second time derivative of the tilt [rad/s^2] under gravity and a base acceleration.

        Of what turns as one it does not depend on the tilt rate.
        """
        lever = turned(self.levers[side], -side * tilt)
        along, upwards = base_acceleration
        force = (-self.mass * along, -self.mass * (GRAVITY + upwards))
        return -side * cross(lever, force) / self.corner_inertia

    def corner_height(self, side: int, tilt: float) -> float:
        """Height of the free base corner above the base [m]."""
        return turned(self.free_corners[side], -side * tilt)[1]

    def corner_speed(self, side: int, tilt: float, rate: float) -> float:
        """Vertical velocity of the free base corner [m/s]."""
        return -side * rate * turned(self.free_corners[side], -side * tilt)[0]

    def rate_step(self, side: int, tilt: float, velocity_step: Vector) -> float:
        """Step of the tilt rate [rad/s] that a velocity step of the base [m/s] causes.

        Seen from the base the step throws the mass back with -mass x velocity_step through the
        centre of mass; the corner answers with an impulse that has no moment about itself.
        """
        lever = turned(self.levers[side], -side * tilt)
        thrown = (-self.mass * velocity_step[0], -self.mass * velocity_step[1])
        return -side * cross(lever, thrown) / self.corner_inertia

    def rate_after_impact(self, side: int, rate: float) -> float:
        """Tilt rate on the other corner [rad/s] after the free corner of `side` met the base.

        Args:
            side: Corner before the impact.
            rate: Tilt rate before the impact, < 0.

        Returns:
            The tilt rate after the impact; <= 0 means that the block stays on both corners.
        """
        if self._restitution is not None:
            return -rate * self._restitution
        spin = -side * rate
        old, new = self.levers[side], self.levers[-side]
        velocity = (-spin * old[1], spin * old[0])
        momentum = self.central_inertia * spin + self.mass * cross(new, velocity)
        return side * momentum / self.corner_inertia

    def contact_force(
        self, side: int, tilt: float, rate: float, base_acceleration: Vector
    ) -> Vector:
        """Force of the base on the pivoting block along and upwards [N], by Newton's law.

        Mass times the acceleration of its centre, the base's and that of turning, less its weight.
        """
        lever = turned(self.levers[side], -side * tilt)
        bend = -side * self.tilt_acceleration(side, tilt, base_acceleration)
        along = base_acceleration[0] - bend * lever[1] - rate**2 * lever[0]
        upwards = GRAVITY + base_acceleration[1] + bend * lever[0] - rate**2 * lever[1]
        return self.mass * along, self.mass * upwards

    def step_impulse(self, side: int, tilt: float, velocity_step: Vector) -> Vector:
        """Impulse of the base on the block along and upwards [N s] at a velocity step [m/s]."""
        lever = turned(self.levers[side], -side * tilt)
        spin = -side * self.rate_step(side, tilt, velocity_step)
        along, upwards = velocity_step
        return self.mass * (along - spin * lever[1]), self.mass * (upwards + spin * lever[0])

    def impact_impulse(self, side: int, before: float, after: float) -> Vector:
        """Impulse of the base along and upwards [N s] at an impact of the free corner.

        Args:
            side: Corner before the impact.
            before: Tilt rate before it, < 0 [rad/s].
            after: Tilt rate about the other corner after it [rad/s].
        """
        old, new = self.levers[side], self.levers[-side]
        spin, spin_after = -side * before, side * after
        along = -spin_after * new[1] + spin * old[1]
        return self.mass * along, self.mass * (spin_after * new[0] - spin * old[0])

    def kinetic_energy(self, rate: float) -> float:
        """Kinetic energy of the rotation about a corner [J]."""
        return 0.5 * self.corner_inertia * rate * rate
