"""The table [block] of a body that is no box: mass, base, centre of mass and moments of inertia."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any, ClassVar, Self

import numpy as np
import numpy.typing as npt
import pydantic

from warprock.case.block_keys import FACE_FRICTION, HEIGHT, OFFSET, ROTATION_START
from warprock.case.validation import KeyedError, Table
from warprock.case.value_kinds import OtherKey
from warprock.errors import Said
from warprock.model.hull import LEVEL, lower_hulls
from warprock.quantity import Column, NumberKey
from warprock.units import Dimension, allowed_text, parse_any

Array = npt.NDArray[np.float64]

MOST_POINTS = 64
"""Points that a base may have."""

_LENGTH = NumberKey("a coordinate", "-1 km to 1 km or -1000 to 1000")
_POINT = "[x, z], or [x, y, z] in space: lengths with a unit, or numbers of metres"
_TENSOR = (
    "must be about the centre of mass: one moment of inertia in the plane, such as "
    '"18 kg m^2", and in space six numbers [xx, yy, zz, xy, xz, yz], entries of the tensor'
)


def _coordinate(got: object) -> float:
    return _LENGTH.read(got).value


def _list(got: object, allowed: str) -> Sequence[Any]:
    if not isinstance(got, list | tuple):
        raise ValueError(allowed)
    return got


def _point(got: object) -> tuple[float, ...]:
    allowed = f"must be {_POINT}"
    parts = _list(got, allowed)
    if len(parts) not in (2, 3):
        raise ValueError(allowed)
    return tuple(_coordinate(part) for part in parts)


def _base(got: object) -> tuple[tuple[float, ...], ...]:
    allowed = f"must be a list of 2 to {MOST_POINTS} contact points, each {_POINT}"
    points = _list(got, allowed)
    if not 2 <= len(points) <= MOST_POINTS:
        raise KeyedError((), Said(f"{len(points)} points"), allowed)
    found = []
    for number, point in enumerate(points):
        try:
            found.append(_point(point))
        except ValueError as error:
            raise KeyedError(number, point, str(error)) from None
        if len(found[-1]) != len(found[0]):
            said = f"must have {len(found[0])} coordinates, as the first point"
            raise KeyedError(number, point, said)
    return tuple(found)


def _top(got: object) -> tuple[tuple[float, ...], ...]:
    """Ends of a face in the plane [m], that to -x first."""
    allowed = "must be a list of 2 points, the ends of the face, each [x, z]: lengths with a unit, "
    allowed += "or numbers of metres"
    ends = tuple(_point(end) for end in _list(got, allowed))
    if len(ends) != 2 or any(len(end) != 2 for end in ends):
        raise ValueError(allowed)
    return tuple(sorted(ends))


def _inertia(got: object) -> tuple[float, ...]:
    allowed = (Dimension.INERTIA, Dimension.DIMENSIONLESS)
    parts = got if isinstance(got, list | tuple) else [got]
    if len(parts) not in (1, 6):
        raise ValueError(_TENSOR)
    found = []
    for number, part in enumerate(parts):
        try:
            found.append(parse_any(part, allowed[: 1 + (len(parts) == 6)]).value)
        except ValueError:
            text = f"must be {allowed_text(allowed[: 1 + (len(parts) == 6)])}"
            path = (number,) if len(parts) == 6 else ()
            raise KeyedError(path, part, text) from None
    return tuple(found)


class _Body(Table):
    """What every body has that is no box: `mass` and `base` where a box has width and density."""

    mass: Annotated[
        float,
        NumberKey("the mass of the body", "1e-6 kg to 1e9 kg", swept=True, column=Column("mass")),
    ]
    base: Annotated[
        Any,
        OtherKey(
            "the contact points, in axes of the body with z upwards and any origin; it stands on "
            "the lowest of them",
            f"list of 2 to {MOST_POINTS} points {_POINT}",
            _base,
            "must be given: a list of contact points, each " + _POINT,
        ),
    ]
    centre: Annotated[
        Any,
        OtherKey(
            "the centre of mass, in the axes of the base",
            f"point {_POINT}",
            _point,
            f"must be given: the centre of mass, {_POINT}",
        ),
    ]
    inertia: Annotated[
        Any,
        OtherKey(
            "the moment of inertia about the centre of mass; in space the tensor, along the axes "
            "of the base (xy is minus the integral of x y dm)",
            "moment of inertia, or list of six [xx, yy, zz, xy, xz, yz]",
            _inertia,
            _TENSOR,
        ),
    ]
    base_scale: Annotated[
        float,
        NumberKey(
            "the factor on the distances of the contact points from below the centre of mass",
            "0.1 to 10",
            swept=True,
            column=Column("base_scale"),
        ),
    ] = 1.0
    height: Annotated[float | None, HEIGHT] = None

    @property
    def spatial(self) -> bool:
        """Whether it is described in space."""
        return len(self.base[0]) == 3

    @property
    def points(self) -> Array:
        """Contact points from the centre of mass [m], shape [point, 2], or [point, 3] in space."""
        return np.asarray(np.array(self.base) - np.array(self.centre))

    @property
    def tensor(self) -> Array:
        """Tensor of inertia of a body in space [kg m^2], shape [3, 3]."""
        xx, yy, zz, xy, xz, yz = self.inertia
        return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])

    @pydantic.model_validator(mode="after")
    def _fits_together(self) -> Self:
        if len(self.centre) != len(self.base[0]):
            allowed = f"must have {len(self.base[0])} coordinates, as the points of the base"
            raise KeyedError("centre", list(self.centre), allowed)
        if len(self.inertia) != (6 if self.spatial else 1):
            raise KeyedError("inertia", Said(_numbers(len(self.inertia))), _TENSOR)
        if self.spatial:
            self._judge_tensor()
        elif self.inertia[0] <= 0.0:
            raise KeyedError("inertia", f"{self.inertia[0]:g} kg m^2", "must be more than 0")
        self._judge_rest()
        return self

    def _judge_tensor(self) -> None:
        """Refuses a tensor that no body has."""
        least, middle, most = np.linalg.eigvalsh(self.tensor)
        if least <= 0.0 or most > (1.0 + LEVEL) * (least + middle):
            allowed = (
                "must be the tensor of a body: principal moments above 0, none above the sum of "
                f"the other two (they are {least:.6g}, {middle:.6g} and {most:.6g} kg m^2)"
            )
            raise KeyedError("inertia", list(self.inertia), allowed)

    def _judge_rest(self) -> None:
        """Refuses a body that does not stand on its lowest points."""
        points = self.points
        height = -points[:, -1].min()
        if height <= 0.0:
            raise KeyedError("centre", list(self.centre), "must be above the lowest contact point")
        low = points[:, -1] + height <= LEVEL * np.ptp(points, axis=0).max()
        if not _inside(points[low][:, :-1]):
            few = "a body stands on those with the least z"
            allowed = f"must be above the area between the lowest contact points: {few}"
            raise KeyedError("centre", list(self.centre), allowed)


class Body(_Body):
    """The body of a case with one body in a lane."""

    place: ClassVar[str] = "block"

    corner_radius: Annotated[
        float | None,
        NumberKey(
            "the radius that the corners of the base are rounded with, between the edges that "
            "meet in them and, at its ends, the vertical",
            "0 m to 1 km",
            swept=True,
            column=Column("corner_radius", "mm"),
        ),
    ] = None


class StackedBody(_Body):
    """One block of a stack in the plane that is no box; what stands on it stands on its top."""

    place: ClassVar[str] = "block.N"

    top: Annotated[
        Any,
        OtherKey(
            "the ends of the flat top of a body that carries a block, in the axes of the base",
            "list of 2 points [x, z]",
            _top,
        ),
    ] = None
    offset: Annotated[float, OFFSET] = 0.0
    friction: Annotated[float | None, FACE_FRICTION] = None
    rotation: Annotated[float, ROTATION_START] = 0.0

    @pydantic.model_validator(mode="after")
    def _fits_in_a_stack(self) -> Self:
        if self.top is not None:
            self._judge_top()
        return self

    def _judge_top(self) -> None:
        """Refuses a top that is not level, or not above the base, or of a body in space."""
        if self.spatial:
            allowed = "must not be given with points [x, y, z]: it is seen in the plane alone"
            raise KeyedError("top", list(self.top), allowed)
        (left, low), (right, high) = self.top
        if left == right or abs(high - low) > LEVEL * abs(right - left):
            raise KeyedError("top", list(self.top), "must be two ends of a level face: the same z")
        if high <= max(z for _x, z in self.base):
            raise KeyedError("top", list(self.top), "must be above all points of the base")
        if self.height is not None:
            raise KeyedError("height", f"{self.height:g} m", "must not be given beside top")


def _numbers(count: int) -> str:
    return "1 number" if count == 1 else f"{count} numbers"


def _inside(points: Array) -> bool:
    """Whether the origin lies inside the hull of some points, not on its edge; [point, 1 or 2]."""
    if points.shape[1] == 1:
        return bool(points.min() < 0.0 < points.max())
    angles = np.sort(np.arctan2(points[:, 1], points[:, 0]))
    gaps = np.diff(angles, append=angles[0] + 2.0 * np.pi)
    return bool(gaps.max() < np.pi * (1.0 - LEVEL))


def profiles(points: Array, directions: Array) -> tuple[Array, npt.NDArray[np.int32]]:
    """The contact points of a body in space as seen in vertical planes, those that can touch.

    Args:
        points: From the centre of mass [m], shape [point, 3].
        directions: Angles from the x axis to the planes [rad], shape [lane].

    Returns:
        As `lower_hulls`.
    """
    c, s = np.cos(directions)[:, None], np.sin(directions)[:, None]
    along = points[:, 0] * c + points[:, 1] * s
    return lower_hulls(np.stack([along, np.broadcast_to(points[:, 2], along.shape)], axis=-1))
