"""The command `body`: a rigid body of any shape, from its mesh to a case."""

from __future__ import annotations

import functools
import pathlib
import shlex
from typing import TYPE_CHECKING, Any

import click

from warprock.cli import completion
from warprock.cli.exits import waited_for
from warprock.cli.options import json_option, output_to
from warprock.cli.pages import asked_command, leave

if TYPE_CHECKING:
    from warprock.bodies.body import Body
    from warprock.case.template import Start
    from warprock.tables.report import Report


@click.command()
@click.argument("mesh", type=click.Path(path_type=pathlib.Path))
@click.option("--density", metavar="DENSITY", help='Such as "2700 kg/m^3"; or give --mass.')
@click.option("--mass", metavar="MASS", help='Such as "350 kg".')
@click.option("--unit", help="Unit of lengths in the file: m without, or mm, cm, in, ft, km.")
@click.option(
    "--up",
    default="z",
    show_default=True,
    help="Axis of the file that points upwards: x, y, z, -x, -y or -z.",
)
@click.option(
    "--pose",
    type=int,
    help="Number of a pose in which it rests, as listed; 0 is that of the file as it is. Without, "
    "the rest next to that, into which it settles.",
)
@click.option(
    "--tolerance",
    metavar="LENGTH",
    help="What lies at most so high above its lowest point is pressed to the ground. Without, 1 mm "
    "of a flat base, about what a good scan can tell; 0.01 mm, round-off, with --base hull.",
)
@click.option(
    "--base",
    default="hull",
    show_default=True,
    help="hull: what touches the ground, and what touches it as the body leans, of a base that is "
    "not flat; flat: the first alone.",
)
@click.option(
    "--points",
    type=int,
    help="Contact points that the case may have, from 3 to 48; without, 24 in the plane and 12 in "
    "space, where each costs.",
)
@click.option(
    "--model",
    default="planar",
    show_default=True,
    help="planar: rocking in the plane of --direction; spatial: free in space.",
)
@click.option(
    "--direction",
    metavar="ANGLE",
    help='Direction of shaking, from x towards y, such as "-25 deg"; the weakest without.',
)
@click.option(
    "--record",
    shell_complete=completion.records,
    help="A shipped record, or a file that says its unit, in the place of a pulse.",
)
@output_to("Folder for the case, a figure and a page; made if it does not exist.", metavar="CASE")
@json_option
def body(
    mesh: pathlib.Path,
    record: str | None,
    folder: pathlib.Path | None,
    as_json: bool,
    density: str | None,
    mass: str | None,
    tolerance: str | None,
    direction: str | None,
    **asked: Any,
) -> None:
    """A body from a MESH (PLY, OBJ, STL): what it weighs, where it stands on, which way it falls.

    The mesh is closed and one body; the extra `mesh` brings what reads it. With -o its case is
    written, ready to run on the record, or on a pulse that you replace by a motion of your own.

    For example: warprock body statue.ply --density "2700 kg/m^3" -o statue
    """
    from warprock.bodies.body import Asked, Texts, find_body, read_asked
    from warprock.bodies.case_text import case_of
    from warprock.tables.bodies import body_report
    from warprock.tables.terminal import print_end, print_json, print_written

    texts = Texts(density, mass, tolerance, direction)
    wanted = read_asked(Asked(**asked), texts)
    found = waited_for(functools.partial(find_body, mesh, wanted), f"body: looking at {mesh}")
    start = case_of(found, record)
    report = body_report(found, "CASE" if folder is None else shlex.quote(str(folder)))
    files: list[pathlib.Path] = []
    if folder is not None:
        files = _write(found, start, report, folder)
    if as_json:
        print_json({**report.json, "files": files})
    else:
        report.show()
        print_written(files)
        then = report.then if folder is not None else f"{asked_command()} -o mine"
        print_end(report.came_out, then)


def _write(found: Body, start: Start, report: Report, folder: pathlib.Path) -> list[pathlib.Path]:
    """Writes the case of a body, what was found, and the page."""
    from warprock.bodies.case_text import CASE_FILE
    from warprock.figures.body import draw_body
    from warprock.running.catalogue import write_case
    from warprock.running.results import write_results

    files = write_case(start, folder / CASE_FILE, "--output")
    results = write_results(folder, report.tables, report.facts)
    return [*files, *leave(folder, results, drawings=draw_body(found))]


COMMANDS = (body,)
