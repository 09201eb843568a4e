"""Writes the page of a folder: one chapter for each kind of results that lies in it."""

from __future__ import annotations

import datetime
import pathlib
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from warprock import __version__
from warprock.errors import InputError
from warprock.report.content import Chapter, Page
from warprock.report.folder import Drawn, ResultFolder
from warprock.report.page import REPORT, write_page
from warprock.report.run_chapter import run_chapter
from warprock.run.lane_table import LANE_TABLE
from warprock.run.results import CELL_TABLE, PROVENANCE

Scenes = Mapping[str, Any]

_CHAPTERS: tuple[tuple[Callable[[ResultFolder], bool], Callable[..., Chapter]], ...] = (
    (lambda folder: folder.has(LANE_TABLE, PROVENANCE), run_chapter),
)
"""What is in a folder, and the chapter that it makes."""

_FILES = {
    LANE_TABLE: "every lane with every column: inputs, results, status, estimated errors",
    PROVENANCE: "the case as it was run, versions, machine, records, counts",
    CELL_TABLE: "the distribution of every cell of the ensemble",
}
_ENDINGS = {
    ".png": "figure",
    ".csv": "table",
    ".parquet": "table, with unit and meaning of every column",
    ".json": "facts",
    ".md": "text",
}


def write_report(
    folder: pathlib.Path,
    *,
    command: str = "",
    scenes: Scenes | None = None,
    drawings: Sequence[Drawn] = (),
) -> pathlib.Path:
    """Writes the page of a folder of results.

    Args:
        folder: The folder.
        command: The command that made the results; empty where it is not known.
        scenes: Lanes to play, of `scenes.scenes_of`; None where no run is at hand.
        drawings: Figures that are at hand as they were drawn; others are taken as they lie there.

    Returns:
        The page, one file that needs nothing beside it.

    Raises:
        InputError: The folder holds no results, or some that cannot be read.
    """
    if not folder.is_dir():
        raise InputError("DIR", "", str(folder), "must be a folder of results")
    found = ResultFolder(folder, drawings)
    if scenes is not None:
        scenes = {**scenes, "digest": found.digest(PROVENANCE)}
    chapters = [make(found, scenes) for there, make in _CHAPTERS if there(found)]
    if not chapters:
        allowed = "must hold results of a warprock command, such as lanes.parquet and run.json"
        raise InputError("DIR", "", str(folder), allowed)
    now = datetime.datetime.now().astimezone()
    page = Page(
        title=chapters[0].title,
        command=command,
        chapters=chapters,
        files=_files(folder),
        written=f"Written by warprock {__version__} on {now:%d %B %Y, %H:%M}",
        version=__version__,
    )
    return write_page(page, folder)


def _files(folder: pathlib.Path) -> Sequence[tuple[str, str]]:
    """Files of a folder that a page names, and what each is."""
    names = sorted(path.name for path in folder.iterdir() if path.is_file())
    return [
        (name, _FILES.get(name, _ENDINGS[pathlib.PurePath(name).suffix]))
        for name in names
        if pathlib.PurePath(name).suffix in _ENDINGS and not name.startswith(".")
    ]


__all__ = ["REPORT", "write_report"]
