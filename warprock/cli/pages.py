"""How a command leaves a folder of results: listed, and with a page; and the command `report`."""

from __future__ import annotations

import pathlib
import shlex
from collections.abc import Mapping
from typing import Any

import click

from warprock.cli.exits import ASKED
from warprock.cli.options import json_option, list_written


def leave(
    folder: pathlib.Path,
    files: list[pathlib.Path],
    *,
    beside: bool = False,
    scenes: Mapping[str, Any] | None = None,
    drawings: Mapping[str, Any] | None = None,
) -> list[pathlib.Path]:
    """Lists what a command wrote and writes the page of the folder.

    Args:
        folder: Where it wrote to.
        files: What it wrote.
        beside: Whether that was made from the results in the folder, which stay.
        scenes: Lanes to play on the page.
        drawings: Figures as they were drawn, by the names of their files.

    Returns:
        The files, the page behind them.
    """
    from warprock.report.writing import write_report

    list_written(folder, files, beside=beside)
    page = write_report(folder, command=asked_command(), scenes=scenes, drawings=drawings)
    list_written(folder, [page], beside=True)
    return [*files, page]


def asked_command() -> str:
    """The command that runs, as it was typed; empty where it was called from a program."""
    context = click.get_current_context(silent=True)
    asked = None if context is None else context.meta.get(ASKED)
    return "" if asked is None else shlex.join(["warprock", *asked])


@click.command()
@click.argument("folder", metavar="DIR", type=click.Path(path_type=pathlib.Path))
@json_option
def report(folder: pathlib.Path, as_json: bool) -> None:
    """Write the page report.html of a folder of results that has none, or an old one.

    Every command that takes -o writes one: what was asked, what came out, figures, tables, lanes
    to play, statuses, versions and how to cite, in one file that needs nothing beside it.
    """
    from warprock.report.writing import write_report
    from warprock.run.files import require_writable
    from warprock.tables.terminal import print_json, print_written

    require_writable(folder, "DIR")
    page = write_report(folder)
    list_written(folder, [page], beside=True)
    print_json({"files": [page]}) if as_json else print_written([page])


COMMANDS = (report,)
