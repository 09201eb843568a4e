"""Stacks in the plane of which some blocks are bodies: what each block is, boxes among them.

A block stands on the lowest of its contact points, and carries the next one on its top, a flat
face. Its *base* is what it stands on at rest.
"""

from __future__ import annotations

import dataclasses
from typing import Self

import numpy as np
import numpy.typing as npt

from warprock.model.bodies import Bodies

Array = npt.NDArray[np.float64]


@dataclasses.dataclass(frozen=True)
class Profiles:
    """Blocks of stacks in the plane, lowest first, SI units, seen from their centres of mass.

    Attributes:
        mass: [kg], shape [lane, block].
        gyration: Moment of inertia about the centre of mass over the mass [m^2], [lane, block].
        points: Contact points, x and z, the lower hull from -x to +x [m], shape
            [lane, block, point, 2].
        count: Points of each block, shape [lane, block]; rows beyond repeat the last one.
        top: Where the top begins at -x, where it ends at +x, and how high it is [m], shape
            [lane, block, 3]; of a body that carries nothing it is for pictures alone.
        is_body: Of each block whether it is no box.
    """

    mass: Array
    gyration: Array
    points: Array
    count: npt.NDArray[np.int32]
    top: Array
    is_body: tuple[bool, ...]

    def of(self, block: int) -> Bodies:
        """One block of each lane, from 0, as bodies of their own."""
        lanes = len(self.mass)
        return Bodies(
            mass=self.mass[:, block],
            gyration=self.gyration[:, block],
            points=self.points[:, block],
            count=self.count[:, block],
            corner_radius=np.zeros(lanes),
            axes=np.broadcast_to((0.0, 0.0, 0.0, 1.0), (lanes, 4)),
        )

    @property
    def each(self) -> tuple[Bodies, ...]:
        """All blocks as bodies of their own, lowest first."""
        return tuple(self.of(block) for block in range(len(self.is_body)))

    def take(self, lanes: slice | npt.NDArray[np.intp]) -> Self:
        """Some of the lanes, by slice or by number."""
        parts = {
            field.name: getattr(self, field.name)[lanes]
            for field in dataclasses.fields(self)
            if field.name != "is_body"
        }
        return dataclasses.replace(self, **parts)

    @property
    def base_ends(self) -> Array:
        """Ends of the base at -x and +x, from below the centre of mass [m], [lane, block, 2]."""
        return np.stack([body.base_ends for body in self.each], axis=1)

    @property
    def centre_height(self) -> Array:
        """Height of the centre of mass above the base [m], shape [lane, block]."""
        return np.stack([body.centre_height for body in self.each], axis=1)

    @property
    def slenderness_angles(self) -> Array:
        """Angles of balance on flat ground, to -x and to +x [rad], shape [lane, block, 2]."""
        return np.stack([body.slenderness_angles for body in self.each], axis=1)

    @property
    def odd(self) -> Array:
        """What the mirror turns round [m], shape [lane, number]: 0 of what is its own image."""
        points = np.arange(self.points.shape[2])
        image = np.maximum(self.count[..., None] - 1 - points, 0)[..., None]
        seen = np.take_along_axis(self.points, image, axis=2) * np.array([-1.0, 1.0])
        left, right, _height = np.moveaxis(self.top, -1, 0)
        parts = [(self.points - seen).reshape(len(self.mass), -1), left + right]
        return np.concatenate(parts, axis=1)

    def outlines(self) -> Array:
        """Corners of all blocks as pictures show them: their base and their top [m].

        Shape [lane, block, corner, 2], going round from -x along the base.
        """
        left, right, height = np.moveaxis(self.top, -1, 0)
        face = np.stack([[right, height], [left, height]])
        return np.concatenate([self.points, np.moveaxis(face, (0, 1), (2, 3))], axis=2)
