"""Writes the page of a folder: one chapter for each kind of results that lies in it."""

from __future__ import annotations

import datetime
import pathlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

from warprock import __version__
from warprock.errors import InputError
from warprock.findings import asked
from warprock.findings.kinds import KNOWN_BY_FILE, kind_of_file, kinds
from warprock.report.content import Chapter, Page
from warprock.report.earlier import earlier_scenes
from warprock.report.folder import Drawn, ResultFolder
from warprock.report.page import REPORT, write_page
from warprock.running.lane_table import LANE_TABLE
from warprock.running.results import CELL_TABLE, PROVENANCE
from warprock.running.run_file import RUN, require_shape
from warprock.sweeps.plan import PLAN

Scenes = Mapping[str, Any]

Make = Callable[[ResultFolder, Scenes | None], Chapter]


def _makers(folder: ResultFolder) -> Iterator[Make]:
    """What makes the chapters of the results that lie in a folder, one after another."""
    facts = folder.facts
    if not facts and not folder.has(PLAN) and not any(map(folder.has, KNOWN_BY_FILE)):
        return
    from warprock.report.finding_chapters import run_chapter, sweep_chapter, teller

    kind = next((kind for key, kind in kinds().items() if key in facts), None)
    if kind is not None:
        yield teller(kind)
    elif facts and folder.has(LANE_TABLE):
        require_shape(facts, RUN, str(folder.path / PROVENANCE))
        yield run_chapter
    elif folder.has(PLAN):
        yield sweep_chapter
    for name in filter(folder.has, KNOWN_BY_FILE):
        yield teller(kind_of_file(name))


FITS = "fragility.csv"
"""Fragility functions, which may lie beside the run that they are of."""
_FILES = {
    "reproduce.json": "what was reproduced of the paper: rows, conflicts",
    LANE_TABLE: "every lane with every column: inputs, results, status, estimated errors",
    PROVENANCE: "the case as it was run, versions, machine, records, counts",
    "boundaries.parquet": "where the mode changes",
    "grid.parquet": "every lane of the grid",
    PLAN: "what was planned, with all that the numbers depend on",
    "fragility-p58.csv": "the fits as a component table after FEMA P-58, as pelicun reads it",
    "fragility.xml": "the fits as a fragility model of OpenQuake's NRML",
    "risk.csv": "yearly rates, a row a function",
    "risk-chances.csv": "chances within spans of years",
    "risk-contributions.csv": "which intensities make the rates",
    "risk-hazard.csv": "the hazard as it was used",
    "risk-allowed.csv": "rates of exceedance that an age allows",
    "predictors.csv": "intensity measures, the one that predicts best first",
    "predictors-pairs.csv": "each intensity measure beside each other one",
    "predictors.xml": "the best two as slices, a fragility model of OpenQuake's NRML",
    "predictors-p58.csv": "the same as a component table after FEMA P-58",
    "brief.html": "the page for a decision: two printed sheets",
    "brief.pdf": "the same, printed",
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
    first: Callable[[ResultFolder], Sequence[Chapter]] | None = None,
) -> pathlib.Path:
    """Writes the page of a folder of results.

    Args:
        folder: The folder.
        command: The command that made the results; empty where it is not known.
        scenes: Lanes to play, of `scenes.scenes_of`; None where no run is at hand.
        drawings: Figures that are at hand as they were drawn; others are taken as they lie there.
        first: What makes chapters of rooms above this one, which come first.

    Returns:
        The page, one file that needs nothing beside it.

    Raises:
        InputError: The folder holds no results, or some that cannot be read.
    """
    if not folder.is_dir():
        raise InputError("DIR", "", str(folder), "must be a folder of results")
    found = ResultFolder(folder, drawings)
    asked.require_known_keys(found.facts, str(folder / PROVENANCE))
    of = next((name for name in (PROVENANCE, PLAN, FITS) if found.has(name)), None)
    digest = "" if of is None else found.digest(of)
    scenes = earlier_scenes(folder, digest) if scenes is None else {**scenes, "digest": digest}
    chapters = [] if first is None else list(first(found))
    chapters += [make(found, scenes) for make in _makers(found)]
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
