"""How a command leaves a folder of results: listed, and with a page; and the command `report`."""

from __future__ import annotations

import pathlib
import shlex
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import click

from warprock.cli.exits import ASKED
from warprock.cli.options import json_option, list_written

if TYPE_CHECKING:
    from warprock.figures.drawing import Drawing
    from warprock.report.content import Chapter
    from warprock.report.folder import ResultFolder


def leave(
    folder: pathlib.Path,
    files: list[pathlib.Path],
    *,
    drawings: Sequence[Drawing] = (),
    scenes: Mapping[str, Any] | None = None,
    beside: bool = False,
    stays: bool = False,
) -> list[pathlib.Path]:
    """Writes the figures of a command, lists what it wrote, and writes the page of the folder.

    Args:
        folder: Where it wrote to.
        files: What it wrote.
        drawings: Its figures.
        scenes: Lanes to play on the page.
        beside: Whether all that was made from the results in the folder, which stay.
        stays: Whether it is not listed, so that it stays whatever comes after it.

    Returns:
        The files, the figures and the page behind them.
    """
    from warprock.figures.drawing import write_drawings
    from warprock.report.page import REPORT

    files = [*files, *write_drawings(drawings, folder)]
    if stays:
        return [*files, add_page(folder, drawings=drawings, scenes=scenes)]
    old = folder / REPORT
    # The page that is there is about to be replaced, not left over.
    list_written(folder, [*files, old] if old.is_file() else files, beside=beside)
    page = add_page(folder, drawings=drawings, scenes=scenes)
    list_written(folder, [page], beside=True)
    return [*files, page]


def add_page(
    folder: pathlib.Path,
    *,
    drawings: Sequence[Drawing] = (),
    scenes: Mapping[str, Any] | None = None,
) -> pathlib.Path:
    """Writes the page of a folder whose files are not listed: they stay whatever comes after them.

    Args:
        folder: The folder.
        drawings: Figures of the command that runs.
        scenes: Lanes to play on the page.
    """
    from warprock.report.writing import write_report

    command = asked_command()
    return write_report(
        folder, command=command, drawings=drawings, scenes=scenes, first=_paper_chapters
    )


def _paper_chapters(folder: ResultFolder) -> list[Chapter]:
    """What was reproduced of the seed paper in a folder, if anything was."""
    from warprock.paper.page import FOUND, paper_chapter

    return [paper_chapter(folder)] if folder.has(FOUND) else []


def asked_command() -> str:
    """The command that runs, as it was typed; empty where it was called from a program."""
    context = click.get_current_context(silent=True)
    asked = None if context is None else context.meta.get(ASKED)
    return "" if asked is None else shlex.join(["warprock", *asked])


def on_case(
    command: str, case_name: str, overrides: Sequence[str], *more: str | pathlib.Path
) -> str:
    """A command on a case with its overrides, as it is typed.

    Args:
        command: Its name.
        case_name: The case, as it was typed.
        overrides: Of `-s`.
        more: Arguments behind them.
    """
    settings = [part for text in overrides for part in ("-s", text)]
    return shlex.join(["warprock", command, case_name, *settings, *map(str, more)])


@click.command()
@click.argument("folder", metavar="DIR", type=click.Path(path_type=pathlib.Path))
@json_option
def report(folder: pathlib.Path, as_json: bool) -> None:
    """Write the page report.html of a folder of results that has none, or an old one.

    Every command that takes -o writes one: what was asked, what came out, figures, tables, lanes
    to play, statuses, versions and how to cite, in one file that needs nothing beside it.
    """
    from warprock.report.writing import REPORT, write_report
    from warprock.running.files import require_writable_file
    from warprock.tables.terminal import print_end, print_json, print_written

    require_writable_file(folder / REPORT, "DIR")
    page = write_report(folder, first=_paper_chapters)
    list_written(folder, [page], beside=True)
    if as_json:
        print_json({"files": [page]})
    else:
        print_written([page])
        print_end("The page needs nothing beside it.", f"open {shlex.quote(str(page))}")


COMMANDS = (report,)
