"""All that a case needs of a rigid body, and all that its user wants to know, from a mesh."""

from __future__ import annotations

import dataclasses
import math
import pathlib
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from warprock.bodies.footing import Footing, hull_of
from warprock.bodies.mesh import Solid, read_solid
from warprock.bodies.raised import flat_points, lift_base, raise_points, touching_points
from warprock.bodies.rests import (
    DOWN,
    STEADY,
    Fall,
    Rest,
    hull_points,
    least_lean,
    rest_at,
    rests_of,
    rolls,
)
from warprock.bodies.rests import turns_over as hull_turns_over
from warprock.errors import NOTHING, InputError, Said
from warprock.quantity import NumberKey
from warprock.units import GRAVITY

Array = npt.NDArray[np.float64]

UPWARDS: dict[str, tuple[float, float, float]] = {
    "z": (0.0, 0.0, 1.0),
    "y": (0.0, 1.0, 0.0),
    "x": (1.0, 0.0, 0.0),
    "-z": (0.0, 0.0, -1.0),
    "-y": (0.0, -1.0, 0.0),
    "-x": (-1.0, 0.0, 0.0),
}
"""Name of an axis of a file -> its direction."""
MODELS = ("planar", "spatial")
BASES = ("flat", "hull")
SAME_RISE = 1e-5
"""Rises that differ by so much of the least one are equal."""
SETTLED = math.radians(5.0)
"""Turn up to which a body settles from the pose of its file [rad]: scans are out of level."""
TOLERANCES = {"hull": 1e-5, "flat": 1e-3}
"""Height over the ground up to which a point is pressed to it [m], where none is named, by base:
round-off where points keep their heights, else what a good scan can tell."""
FLAT_TOLERANCES = (3e-4, 1e-3, 3e-3, 1e-2)
"""Tolerances at which the slenderness angle of a base pressed flat is listed [m]."""
POINTS = {"planar": 24, "spatial": 12}
"""Contact points of a case, at most, by its model: in a plane few of them touch, in space each
costs. A round base of 24 loses 0.9 % of its radius, one of 12 loses 3.4 %."""
LEAST_POINTS, MOST_POINTS = 3, 48


@dataclasses.dataclass(frozen=True)
class Asked:
    """What is asked of a mesh.

    Attributes:
        mass: Mass [kg]; None where the density is given.
        density: Density [kg/m^3]; None where the mass is given.
        unit: Unit of lengths in the file; None takes metres if its size looks like that.
        up: Axis of the file that points upwards, of `UPWARDS`.
        pose: The number of a rest, from 1; 0 is the pose of the file as it is, and None the rest
            next to it, into which the body settles.
        tolerance: Points at most so high above the lowest one are pressed to the ground [m]; None
            takes that of `TOLERANCES`.
        base: "hull" keeps points above the ground, too, that touch it as the body leans; "flat"
            leaves them out.
        points: Contact points that the case may have; None takes those of `POINTS`.
        model: "planar" or "spatial".
        direction: Direction of shaking, from the x axis towards y [rad]; None takes the weakest.
    """

    mass: float | None = None
    density: float | None = None
    unit: str | None = None
    up: str = "z"
    pose: int | None = None
    tolerance: float | None = None
    base: str = "hull"
    points: int | None = None
    model: str = "planar"
    direction: float | None = None


@dataclasses.dataclass(frozen=True, eq=False)
class Body:
    """A rigid body in a pose at rest; its axes: z upwards, origin on the ground below the centre.

    Attributes:
        file: Where it is from.
        asked: What was asked.
        volume: Volume [m^3].
        mass: Mass [kg].
        inertia: Inertia tensor about the centre of mass over the mass [m^2], shape [3, 3].
        hull: Corners of its convex hull from the centre of mass [m], shape [corner, 3].
        footing: All that it stands on.
        contacts: The contact points of the case from the centre of mass [m], shape [point, 3].
        base: What it stands on in the case: the lowest of these.
        weakest: The weakest direction [rad]: that in which its centre rises least until it turns
            over, of all that touches, so that it does not depend on how many points a case has. Of
            a flat base it is across the nearest edge.
        rests: Poses in which it stands, those that ask for the least turn first.
        pose: The pose; of `rests` where it was asked for by number.
        sha256: SHA-256 of the file.
    """

    file: pathlib.Path
    asked: Asked
    volume: float
    mass: float
    inertia: Array
    hull: Array
    footing: Footing
    contacts: Array
    base: Footing
    weakest: float
    rests: tuple[Rest, ...]
    pose: Rest
    sha256: str

    @property
    def name(self) -> str:
        """Name of the file without its ending."""
        return self.file.stem

    @property
    def tolerance(self) -> float:
        """Height over the ground up to which a point is pressed to it [m]."""
        return _tolerance(self.asked)

    @property
    def points(self) -> Array:
        """Contact points of the case [m], shape [point, 3]."""
        return np.asarray(self.contacts + np.array([0.0, 0.0, self.base.height]))

    @property
    def density(self) -> float:
        """Density [kg/m^3]."""
        return self.mass / self.volume

    @property
    def sizes(self) -> Array:
        """Sizes of the box around it along x, y and z [m], shape [3]."""
        return np.asarray(np.ptp(self.hull, axis=0))

    @property
    def direction(self) -> float:
        """Direction of shaking [rad]: that asked for, or the weakest."""
        return self.weakest if self.asked.direction is None else self.asked.direction

    @property
    def frequency_parameter(self) -> float:
        """Frequency parameter p in the plane of shaking, about its farthest point [rad/s]."""
        across = np.array([-math.sin(self.direction), math.cos(self.direction), 0.0])
        arm = self.base.height * math.tan(float(self.in_plane(self.direction)[0]))
        radius = math.hypot(arm, self.base.height)
        gyration = float(across @ self.inertia @ across)
        return math.sqrt(GRAVITY * radius / (gyration + radius**2))

    def in_plane(self, *directions: float) -> Array:
        """Slenderness angles of the base of the case in planes of shaking [rad]."""
        return self.base.in_plane(np.array(directions))

    def turns_over(self, *directions: float) -> list[Fall]:
        """Where it turns over in planes of shaking, rolling on the contact points of the case.

        Args:
            directions: From the x axis towards y [rad].
        """
        return hull_turns_over(self.contacts, np.array(directions))

    def by_tolerance(self) -> list[tuple[float, float]]:
        """Tolerances [m], and the least slenderness angle of a base pressed flat at each [rad]."""
        found = []
        for tolerance in FLAT_TOLERANCES:
            rest = rest_at(self.hull, DOWN, tolerance)
            found.append((tolerance, rest.footing.slenderness_angle))
        return found


_READ = {
    "density": NumberKey("the density of the body", "1e-3 kg/m^3 to 1e5 kg/m^3"),
    "mass": NumberKey("the mass of the body", "1e-6 kg to 1e9 kg"),
    "tolerance": NumberKey(
        "the height over the ground up to which a point touches it", "1e-6 m to 1 m"
    ),
    "direction": NumberKey("the direction of shaking", "-360 deg to 360 deg"),
}
"""Options that are quantities."""


class Texts(NamedTuple):
    """Quantities as they are written, with their units; None where one is left out."""

    density: str | None = None
    mass: str | None = None
    tolerance: str | None = None
    direction: str | None = None


def read_asked(asked: Asked, texts: Texts) -> Asked:
    """What is asked, with quantities from the texts of options.

    Raises:
        InputError: Something cannot be used.
    """
    read = {
        name: _READ[name].read_option(f"--{name}", text) for name, text in texts._asdict().items()
    }
    whole = dataclasses.replace(
        asked,
        density=read["density"],
        mass=read["mass"],
        direction=read["direction"],
        tolerance=read["tolerance"],
    )
    _judge(whole)
    return whole


def find_body(path: pathlib.Path, asked: Asked) -> Body:
    """A body from the file of its mesh.

    Args:
        path: A file that ends in .ply, .obj or .stl.
        asked: What is asked of it.

    Raises:
        InputError: The mesh cannot be used, or the body does not stand in the pose.
    """
    solid = _upright(read_solid(path, asked.unit), asked.up)
    tolerance = _tolerance(asked)
    rests = tuple(rests_of(solid, tolerance))
    points = hull_points(solid) - solid.centre
    pose = _pose(str(path), asked, points, rests)
    footing = pose.footing
    hull = points @ pose.rotation.T
    most = asked.points or POINTS[asked.model]
    raised = asked.base == "hull"
    touching = touching_points(hull, footing, tolerance) if raised else lift_base(footing)
    weakest = _weakest(touching, footing)
    shaken = weakest if asked.direction is None else asked.direction
    contacts = flat_points(footing, most, shaken)
    if raised:
        contacts = raise_points(hull, footing, most, tolerance, shaken)
    low = contacts[contacts[:, 2] <= -footing.height]
    base = Footing(hull_of(low[:, :2]), footing.height)
    if base.arm <= 0.0:
        allowed = f"must be more: the body falls off a base of {most} points"
        raise InputError("--points", "", most, allowed)
    mass = solid.volume * asked.density if asked.density is not None else asked.mass
    assert mass is not None
    turn = pose.rotation
    return Body(
        path,
        asked,
        solid.volume,
        mass,
        turn @ solid.inertia @ turn.T,
        hull,
        footing,
        contacts,
        base,
        weakest,
        rests,
        pose,
        solid.sha256,
    )


def _weakest(touching: Array, footing: Footing) -> float:
    """The direction in which the centre rises least until the body turns over [rad].

    Args:
        touching: All that may touch, from the centre of mass [m], shape [point, 3].
        footing: What touches at rest.
    """
    around = np.concatenate([footing.edge_directions(), np.radians(np.arange(-179.0, 181.0))])
    rises = np.array([fall.rise for fall in hull_turns_over(touching, around)])
    weak = around[rises <= rises.min() * (1.0 + SAME_RISE)]
    return float(min(weak, key=lambda angle: (round(abs(angle), 6), -angle)))


def _tolerance(asked: Asked) -> float:
    """Height over the ground up to which a point is pressed to it [m]."""
    return TOLERANCES[asked.base] if asked.tolerance is None else asked.tolerance


def _judge(asked: Asked) -> None:
    """Refuses what cannot be asked, before a file is read."""
    given = [each for each in (asked.mass, asked.density) if each is not None]
    if len(given) != 1:
        got = Said("both") if given else NOTHING
        allowed = (
            'must be given, or --mass, one of the two: --density "2700 kg/m^3" (marble, granite), '
            '"2400 kg/m^3" (concrete)'
        )
        raise InputError("--density", "", got, allowed)
    if asked.up not in UPWARDS:
        raise InputError("--up", "", asked.up, f"must be one of {', '.join(UPWARDS)}")
    if asked.base not in BASES:
        raise InputError("--base", "", asked.base, f"must be one of {', '.join(BASES)}")
    if asked.model not in MODELS:
        raise InputError("--model", "", asked.model, f"must be one of {', '.join(MODELS)}")
    if asked.points is not None and not LEAST_POINTS <= asked.points <= MOST_POINTS:
        allowed = f"must be from {LEAST_POINTS} to {MOST_POINTS} contact points"
        raise InputError("--points", "", asked.points, allowed)


def _upright(solid: Solid, up: str) -> Solid:
    """A body in axes of which the third one is the axis `up` of its file."""
    if up == "z":
        return solid
    turn = rest_at(np.eye(3), -np.array(UPWARDS[up]), 0.0).rotation
    return dataclasses.replace(
        solid,
        corners=solid.corners @ turn.T,
        centre=turn @ solid.centre,
        inertia=turn @ solid.inertia @ turn.T,
    )


def _pose(source: str, asked: Asked, points: Array, rests: tuple[Rest, ...]) -> Rest:
    """The pose asked for.

    Raises:
        InputError: There is none of that number, or the body does not stand as it lies in its file.
    """
    if asked.pose:
        if not 1 <= asked.pose <= len(rests):
            known = f"from 1 to {len(rests)}" if rests else "0: it stands in no other pose"
            allowed = f"must be 0, the pose of the file, or {known}"
            raise InputError("--pose", "", asked.pose, allowed)
        return rests[asked.pose - 1]
    if asked.pose is None and rests and rests[0].turn < SETTLED:
        return rests[0]
    pose = rest_at(points, DOWN, _tolerance(asked))
    why = _falls(pose.footing, points)
    if not why:
        return pose
    if not rests:
        got = Said(f"a body without a stable rest: it {why}")
        raise InputError(source, "", got, "must stand in some pose without rolling away")
    turn = np.degrees(rests[0].turn)
    more = "" if len(rests) == 1 else f" (poses 1 to {len(rests)} do)"
    allowed = f"must stand: --pose 1, turned by {turn:.3g} deg, does{more}, or say --up"
    raise InputError(source, "", Said(f"a body that does not stand as scanned: it {why}"), allowed)


def _falls(footing: Footing, points: Array) -> str:
    """Why a body does not stand in a pose; empty where it does."""
    if len(footing.polygon) < 3:
        count = len(footing.polygon)
        return f"touches the ground at {'one point' if count == 1 else 'points of one line'} alone"
    if footing.slenderness_angle <= 0.0:
        return f"has its centre of mass {-1e3 * footing.arm:.3g} mm outside its contact points"
    least = least_lean(points, footing)
    if least < STEADY:
        return f"falls at a lean of {np.degrees(least):.2g} deg, less than {np.degrees(STEADY):.2g}"
    return "rolls" if rolls(points, footing) else ""
