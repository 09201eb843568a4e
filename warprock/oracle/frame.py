"""A frame of rocking columns for the oracle, from vectors: its momenta are projected on its motion.

Columns turn alike; the beam on them moves without turning, as the top of the diagonal of a column
does. Forces and momenta count by their product with how their points move when the columns turn by
a unit: so weights, inertia and an impact of all feet at once, whose impulses do no work on the
motion after it, follow without a closed form.
"""

from __future__ import annotations

from warprock.oracle.block_mechanics import PivotingBlock, Vector, cross, turned
from warprock.units import GRAVITY


class RockingFrame(PivotingBlock):
    """Columns capped by a beam, seen as one column with a point mass for its part of the beam."""

    def __init__(
        self,
        sizes: tuple[float, float, float],
        density: float,
        restitution: float | None,
        *,
        columns: int,
        mass_ratio: float,
    ) -> None:
        """Adds the beam to a column.

        Args:
            sizes: Full width, height and depth of a column [m].
            density: [kg/m^3].
            restitution: Prescribed ratio of the angular velocities after and before an impact.
            columns: How many there are.
            mass_ratio: Mass of the beam over that of all columns.
        """
        super().__init__(*sizes, density, restitution)
        self.columns, self.beam = columns, mass_ratio * self.mass
        # A column's top corner over its pivot, at twice the lever of its centre.
        self.tops = {side: (2.0 * x, 2.0 * y) for side, (x, y) in self.levers.items()}
        top = self.tops[1]
        self.corner_inertia += self.beam * (top[0] ** 2 + top[1] ** 2)

    def _moment(self, side: int, tilt: float, pull: Vector) -> float:
        """Moment of forces on all masses, each its mass times a vector [m/s^2], outwards [N m]."""
        masses = ((self.mass, self.levers[side]), (self.beam, self.tops[side]))
        moments = [mass * cross(turned(arm, -side * tilt), pull) for mass, arm in masses]
        return -side * sum(moments)

    def tilt_acceleration(
        self, side: int, tilt: float, base_acceleration: Vector, rate: float = 0.0
    ) -> float:
        """Second time derivative of the tilt [rad/s^2]."""
        along, upwards = base_acceleration
        pull = (-along, -(GRAVITY + upwards))
        return self._moment(side, tilt, pull) / self.corner_inertia

    def rate_step(self, side: int, tilt: float, velocity_step: Vector) -> float:
        """Step of the tilt rate [rad/s] that a velocity step of the base causes."""
        thrown = (-velocity_step[0], -velocity_step[1])
        return self._moment(side, tilt, thrown) / self.corner_inertia

    def rate_after_impact(self, side: int, rate: float) -> float:
        """Tilt rate [rad/s] after all free corners met the base, on those corners."""
        if self._restitution is not None:
            return -rate * self._restitution
        spin = -side * rate
        momentum = self.central_inertia * spin
        for mass, arms in ((self.mass, self.levers), (self.beam, self.tops)):
            before, after = arms[side], arms[-side]
            momentum += mass * spin * (before[0] * after[0] + before[1] * after[1])
        return side * momentum / self.corner_inertia

    def kinetic_energy(self, rate: float) -> float:
        """Kinetic energy of all columns and the beam [J]."""
        return self.columns * super().kinetic_energy(rate)

    def contact_force(
        self, side: int, tilt: float, rate: float, base_acceleration: Vector
    ) -> Vector:
        """Nothing: how the feet share what the base gives is not known."""
        return 0.0, 1.0

    def step_impulse(self, side: int, tilt: float, velocity_step: Vector) -> Vector:
        """Nothing, likewise."""
        return 0.0, 1.0

    def impact_impulse(self, side: int, before: float, after: float) -> Vector:
        """Nothing, likewise."""
        return 0.0, 1.0
