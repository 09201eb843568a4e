"""The command `body` as a function."""

from __future__ import annotations

import functools
import os
import pathlib
import tomllib

from warprock.api.case import Case
from warprock.api.found import Found
from warprock.api.names import python_names
from warprock.api.values import Angle, Density, Length, Mass
from warprock.arguments import at_the_door
from warprock.bodies.body import Asked, Body, Texts, find_body, read_asked
from warprock.bodies.case_text import case_of
from warprock.case.template import Start
from warprock.case.text import CASE_FILE
from warprock.figures.body import draw_body
from warprock.findings.body import find_body as find_told
from warprock.running.catalogue import write_case


@at_the_door
def body(
    mesh: str | os.PathLike[str],
    *,
    density: Density | None = None,
    mass: Mass | None = None,
    unit: str | None = None,
    up: str = "z",
    pose: int | None = None,
    tolerance: Length | None = None,
    base: str = "hull",
    points: int | None = None,
    model: str = "planar",
    direction: Angle | None = None,
    record: str | None = None,
) -> BodyFound:
    """A rigid body from its mesh: mass, inertia, what it stands on, and a case of it.

    Args:
        mesh: A closed surface around one body, .ply, .obj or .stl; needs the extra `mesh`.
        density: Such as "2700 kg/m^3"; or give `mass`.
        mass: Such as "350 kg".
        unit: Unit of lengths in the file: m without, or mm, cm, in, ft, km.
        up: Axis of the file that points upwards: x, y, z, -x, -y or -z.
        pose: Number of a pose in which it rests, as listed; 0 is that of the file as it is.
            Without, the rest next to that, into which it settles.
        tolerance: What lies at most so high above its lowest point is pressed to the ground.
            Without, 1 mm of a flat base, about what a good scan can tell; 0.01 mm, round-off, with
            `base` hull.
        base: hull: what touches the ground, and what touches it as the body leans, of a base that
            is not flat; flat: the first alone.
        points: Contact points that the case may have, from 3 to 48; without, 24 in the plane and
            12 in space, where each costs.
        model: planar: rocking in the plane of `direction`; spatial: free in space.
        direction: Direction of shaking, from x towards y, such as "-25 deg"; the weakest without.
        record: A shipped record, or a file that says its unit, in the place of a pulse.

    Returns:
        A `Found` whose table has slenderness angles by direction, and whose `case` is ready to run.

    Raises:
        InputError: An argument or the mesh cannot be used: holes, several bodies, no rest, mm.

    Example:
        >>> import tempfile
        >>> import trimesh
        >>> import warprock as wr
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     _ = trimesh.creation.box((0.5, 0.8, 2.0)).export(f"{folder}/slab.ply")
        ...     found = wr.body(f"{folder}/slab.ply", density="2700 kg/m^3")
        >>> round(found.found.mass), found.table["slenderness_angle_deg"].min().round(2)
        (2160, np.float64(14.04))
    """
    with python_names():
        asked = Asked(unit=unit, up=up, pose=pose, base=base, points=points, model=model)
        texts = Texts(density, mass, tolerance, direction)
        found = find_body(pathlib.Path(mesh), read_asked(asked, texts))
        return BodyFound(found, case_of(found, record))


class BodyFound(Found):
    """A body from a mesh, with its case; `save` writes the case, too."""

    def __init__(self, found: Body, start: Start) -> None:
        draw = functools.partial(draw_body, found)
        find = functools.partial(find_told, found)
        super().__init__(f"{found.name}: a body", found, find, draw)
        self._start = start

    @property
    def case(self) -> Case:
        """Its case, on a pulse, as `run` takes it."""
        return Case.from_dict(tomllib.loads(self._start.text), name=self.found.name)

    def save(self, folder: str | os.PathLike[str]) -> list[pathlib.Path]:
        """Writes all of it, as in `Found.save`, and the case."""
        with python_names():
            case = write_case(self._start, pathlib.Path(folder) / CASE_FILE, "--output")
        return [*case, *super().save(folder)]
