"""The command `body`: a rigid body of any shape, from its mesh to a case."""

from __future__ import annotations

import functools
import pathlib
import shlex
from typing import Any

import click

from warprock.cli import completion
from warprock.cli.analysis import finish
from warprock.cli.exits import waited_for
from warprock.cli.options import json_option, output_to
from warprock.cli.signatures import own_options


@click.command()
@click.argument("mesh", type=click.Path(path_type=pathlib.Path))
@own_options("body", "body", record=completion.records)
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
    from warprock.api.body import BodyFound
    from warprock.bodies.body import Asked, Texts, find_body, read_asked
    from warprock.bodies.case_text import case_of
    from warprock.case.text import CASE_FILE
    from warprock.running.catalogue import write_case

    texts = Texts(density, mass, tolerance, direction)
    wanted = read_asked(Asked(**asked), texts)
    found = waited_for(functools.partial(find_body, mesh, wanted), f"body: looking at {mesh}")
    start = case_of(found, record)
    files = [] if folder is None else write_case(start, folder / CASE_FILE, "--output")
    then = f"warprock run {shlex.quote(str(folder))} -o results"
    made = BodyFound(found, start)
    finish(made, folder, as_json=as_json, then=then, output="mine", first=files)


COMMANDS = (body,)
