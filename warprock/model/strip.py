"""A vertical strip of wall between two floors: two rigid bodies with a hinge between them.

Bowed towards +x, the lower body stands on the +x edge of its base and has turned by the lean
theta; its -x edge carries the upper body at the hinge, which has turned the other way, by psi. The
floor above bears on one point of the top, which it holds sideways: the point moves up and down
alone. Bowed towards -x everything is mirrored. With t the width, h1 and h2 the heights of the
bodies, and a from the edge of the upper body at the hinge to the point below the floor, along its
width:

    h2 sin(psi) + a (1 - cos(psi)) = h1 sin(theta) + t (1 - cos(theta)),
    r = dpsi/dtheta = (h1 cos(theta) + t sin(theta)) / (h2 cos(psi) + a sin(psi)).

With J the velocities of the centres for theta' = 1, and N the weight on top, a force without
inertia, Lagrange's equation is

    M theta'' + (dM/dtheta) theta'^2 / 2 = -V' - a_base S',
    M = I1 + m2 (Jx^2 + Jy^2) + J2 r^2,         I1 about the edge, J2 about the centre,
    S' = m1 (h1 cos(theta) + t sin(theta)) / 2 + m2 Jx,
    V' = g m1 (t cos(theta) - h1 sin(theta)) / 2 + g m2 Jy + N dy_top/dtheta.

It lifts at a_base / g = V' / (g S') at rest, 2 t / (x h) without a load, x h the height of the
hinge (Sorrentino, Masiani and Griffith 2008). Coming back upright, it goes on bowed to the other
side. What base, hinge and floor give then does no work on that motion, so that its momentum is kept
as projected on it:

    eta = (I- + m2 (h1^2 - t^2 (2 + r)^2) / 4 + J2 r^2) / (I+ + m2 (h1^2 + t^2 (2 + r)^2) / 4
          + J2 r^2),   I+- = m1 (h1^2 +- t^2) / 4 + J1,   r = h1 / h2.
"""

from __future__ import annotations

import dataclasses
import functools
from typing import Self

import numpy as np
import numpy.typing as npt

from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]

LAID = 1.5
"""Turn of a body [rad] at which a strip has fallen: short of a right angle, at which the top may
pass over the hinge."""

_BISECTIONS = 60
"""Halvings of a bracket of a lean: to round-off."""

_AWAY = 1e-4
"""Difference of leans [rad] over which a derivative is taken."""


@dataclasses.dataclass(frozen=True)
class Mechanism:
    """A strip at a lean to one side, per unit of its rate; see the head of this file.

    Attributes:
        inertia: M [kg m^2].
        restoring: V' [N m].
        pulled: S' [kg m].
    """

    inertia: Array
    restoring: Array
    pulled: Array


@dataclasses.dataclass(frozen=True)
class Strip:
    """Strips of wall, shape [lane] each.

    Attributes:
        width: t [m].
        lower: Height of the hinge, h1 [m].
        upper: Height of the upper body, h2 [m].
        mass: Of both bodies [kg].
        weight: On top [N].
        arm: The distances a, bowed to -x and to +x [m], shape [lane, 2].
    """

    width: Array
    lower: Array
    upper: Array
    mass: Array
    weight: Array
    arm: Array

    def take(self, lanes: slice | npt.NDArray[np.intp]) -> Self:
        """Some of the lanes, by slice or by number."""
        names = [field.name for field in dataclasses.fields(self)]
        return dataclasses.replace(self, **{name: getattr(self, name)[lanes] for name in names})

    @property
    def masses(self) -> tuple[Array, Array]:
        """Masses of the lower and of the upper body [kg]."""
        part = self.lower / (self.lower + self.upper)
        return np.asarray(self.mass * part), np.asarray(self.mass * (1.0 - part))

    @property
    def own_inertias(self) -> tuple[Array, Array]:
        """Moments of inertia of the bodies about their centres [kg m^2]."""
        first, second = (
            mass / 12.0 * (self.width**2 + height**2)
            for mass, height in zip(self.masses, (self.lower, self.upper), strict=True)
        )
        return np.asarray(first), np.asarray(second)

    def at(self, lean: Array) -> Mechanism:
        """The strips at leans to either side [rad], shape [lane, 2]."""
        t, h1, h2, n = (each[:, None] for each in (self.width, self.lower, self.upper, self.weight))
        m1, m2 = (each[:, None] for each in self.masses)
        j1, j2 = (each[:, None] for each in self.own_inertias)
        s, c = np.sin(lean), np.cos(lean)
        turn = _turn(h2, self.arm, h1 * s + t * (1.0 - c))
        s2, c2 = np.sin(turn), np.cos(turn)
        across, rise = h1 * c + t * s, t * c - h1 * s
        ratio = across / (h2 * c2 + self.arm * s2)
        x = across - 0.5 * (t * s2 + h2 * c2) * ratio
        y = rise + 0.5 * (t * c2 - h2 * s2) * ratio
        top = rise + (self.arm * c2 - h2 * s2) * ratio
        inertia = j1 + 0.25 * m1 * (t**2 + h1**2) + m2 * (x**2 + y**2) + j2 * ratio**2
        restoring = GRAVITY * (0.5 * m1 * rise + m2 * y) + n * top
        return Mechanism(inertia, restoring, 0.5 * m1 * across + m2 * x)

    @functools.cached_property
    def laid(self) -> Array:
        """Leans at which one of the bodies has turned by `LAID` [rad], shape [lane, 2]."""
        reach = self.upper[:, None] * np.sin(LAID) + self.arm * (1.0 - np.cos(LAID))
        found = _turn(self.lower[:, None], self.width[:, None], reach)
        return np.fmin(found, LAID)

    @functools.cached_property
    def critical(self) -> Array:
        """Leans at which the strips stand in unstable balance [rad], shape [lane, 2]."""
        return self.falling(np.zeros_like(self.width))

    def places(self, rotation: Array) -> Array:
        """Where the bodies are and how they have turned, seen from the middle of the base.

        Args:
            rotation: Of the lower body [rad], positive towards +x, shape [lane, sample].

        Returns:
            x and z of their centres [m] and their rotations [rad], lower body first, shape
            [lane, body, sample, 3].
        """
        side, lean = np.where(rotation < 0.0, -1.0, 1.0), np.abs(rotation)
        t, h1, h2 = (each[:, None] for each in (self.width, self.lower, self.upper))
        arm = np.where(rotation < 0.0, self.arm[:, :1], self.arm[:, 1:])
        s, c = np.sin(lean), np.cos(lean)
        turn = _turn(h2, arm, h1 * s + t * (1.0 - c))
        s2, c2 = np.sin(turn), np.cos(turn)
        hinge_x, hinge_z = t * (0.5 - c) + h1 * s, t * s + h1 * c
        lower = side * 0.5 * (t * (1.0 - c) + h1 * s), 0.5 * hinge_z, rotation
        upper = (
            side * (hinge_x + 0.5 * (t * c2 - h2 * s2)),
            hinge_z + 0.5 * (t * s2 + h2 * c2),
            -side * turn,
        )
        return np.stack([np.stack(each, axis=-1) for each in (lower, upper)], axis=1)

    def falling(self, friction: Array) -> Array:
        """Leans at which a base acceleration of friction x g would just hold them, [lane, 2]."""
        low, high = np.zeros_like(self.arm), self.laid
        for _ in range(_BISECTIONS):
            lean = 0.5 * (low + high)
            found = self.at(lean)
            stands = found.restoring + friction[:, None] * GRAVITY * found.pulled > 0.0
            low, high = np.where(stands, lean, low), np.where(stands, high, lean)
        return np.asarray(0.5 * (low + high))

    @functools.cached_property
    def upright(self) -> Mechanism:
        """The strips as they stand."""
        return self.at(np.zeros_like(self.arm))

    @property
    def uplift_ratios(self) -> Array:
        """Base acceleration / g that bows the strips to -x and to +x [-], shape [lane, 2]."""
        return np.asarray(self.upright.restoring / self.upright.pulled / GRAVITY)

    @functools.cached_property
    def frequency_parameter(self) -> Array:
        """Rate at which a lean grows away from the weaker balance [rad/s]."""
        step = _AWAY * self.critical
        change = self.at(self.critical + step).restoring - self.at(self.critical - step).restoring
        rates = np.sqrt(-0.5 * change / step / self.at(self.critical).inertia)
        return np.asarray(rates.max(axis=1))

    @property
    def angular_restitution(self) -> Array:
        """Ratio of the rates after and before the strips come back upright [-]."""
        (m1, m2), (j1, j2) = self.masses, self.own_inertias
        h, t, r = self.lower, self.width, self.lower / self.upper
        along = 0.25 * (m1 + m2) * h**2 + j1 + j2 * r**2
        across = 0.25 * t**2 * (m1 + m2 * (2.0 + r) ** 2)
        return np.asarray((along - across) / (along + across))

    def impact_friction(self, restitution: Array) -> Array:
        """Friction that base and hinge need where the strips come back upright [-].

        What the bodies gain is what base, hinge and floor give. Of a prescribed restitution, the
        moment that is left over acts at the base.
        """
        (m1, m2), (_, j2) = self.masses, self.own_inertias
        h, t, r = self.lower, self.width, self.lower / self.upper
        along = 0.5 * h * (restitution - 1.0)
        rise = 0.5 * t * (restitution + 1.0)
        hinge = m2 * (2.0 + r) * rise
        turn = j2 * r * (restitution - 1.0)
        floor = -(turn + 0.5 * t * hinge - 0.5 * self.upper * m2 * along) / self.upper
        of_hinge = m2 * along - floor
        of_base = m1 * along + of_hinge
        asked = np.abs(of_base) / (m1 * rise + hinge), np.abs(of_hinge) / hinge
        return np.asarray(np.maximum(*asked))


def _turn(height: Array, arm: Array, reach: Array) -> Array:
    """The angle x [rad] with height sin(x) + arm (1 - cos(x)) = reach; NaN where there is none."""
    square = height**2 + reach * (2.0 * arm - reach)
    with np.errstate(invalid="ignore"):
        return np.asarray(2.0 * np.arctan2(reach, height + np.sqrt(square)))
