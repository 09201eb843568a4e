"""The command `body` as a function."""

from __future__ import annotations

import functools
import os
import pathlib
import tomllib

from warprock.api.case import Case
from warprock.api.found import Found
from warprock.api.names import python_names
from warprock.arguments import at_the_door
from warprock.bodies.body import Asked, Body, Texts, find_body, read_asked
from warprock.bodies.case_text import CASE_FILE, case_of
from warprock.case.template import Start
from warprock.figures.body import draw_body
from warprock.running.catalogue import write_case
from warprock.tables.bodies import body_report


@at_the_door
def body(
    mesh: str | os.PathLike[str],
    *,
    density: str | None = None,
    mass: str | None = None,
    unit: str | None = None,
    up: str = "z",
    pose: int | None = None,
    tolerance: str | None = None,
    base: str = "hull",
    points: int | None = None,
    model: str = "planar",
    direction: str | None = None,
    record: str | None = None,
) -> BodyFound:
    """A rigid body from its mesh: mass, inertia, what it stands on, and a case of it.

    Args:
        mesh: A closed surface around one body, .ply, .obj or .stl; needs the extra `mesh`.
        density: Such as "2700 kg/m^3"; give this or the mass.
        mass: Such as "350 kg".
        unit: Unit of lengths in the file; None takes metres if its size looks like that.
        up: Axis of the file that points upwards: "x", "y", "z", "-x", "-y" or "-z".
        pose: Number of a pose in which it rests; 0 is as in the file, None settles from there.
        tolerance: What lies at most so high is pressed to the ground; None is 1 mm of "flat".
        base: "hull" keeps points above the ground that touch it as the body leans; or "flat".
        points: Contact points that the case may have; None is 24 in the plane, 12 in space.
        model: "planar", in the plane of the direction, or "spatial".
        direction: Direction of shaking, from x towards y, such as "-25 deg"; None is the weakest.
        record: A shipped record, or a file that says its unit; None shakes the case by a pulse.

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
        report = functools.partial(body_report, found)
        draw = functools.partial(draw_body, found)
        super().__init__(f"{found.name}: a body", found, report, draw)
        self._start = start

    @property
    def case(self) -> Case:
        """Its case, on a pulse, as `run` takes it."""
        return Case.from_dict(tomllib.loads(self._start.text), name=self.found.name)

    def _write(self, folder: pathlib.Path) -> list[pathlib.Path]:
        return [*write_case(self._start, folder / CASE_FILE, "folder"), *super()._write(folder)]
