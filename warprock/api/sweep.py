"""The commands `sweep plan`, `run` and `merge` as one function."""

from __future__ import annotations

import dataclasses
import functools
import os
import pathlib
from typing import Unpack

from warprock.analysis.lane_tables import read_lanes
from warprock.api.case import AnyCase
from warprock.api.found import Found, untitled
from warprock.api.work import HowHeld, working
from warprock.arguments import at_the_door, listing
from warprock.errors import InputError
from warprock.findings.sweep import find_sweep
from warprock.sweeps.chunks import merge
from warprock.sweeps.plan import Plan, make_plan, write_plan
from warprock.sweeps.run import Shard, chunks_to_run, run_here
from warprock.tables.sweeps import print_state


@listing(working)
@at_the_door
def sweep(
    case: AnyCase,
    folder: str | os.PathLike[str],
    engine: str | None = None,
    *,
    chunk: int = 50_000,
    **how: Unpack[HowHeld],
) -> Found:
    """Runs many lanes in chunks that are kept, and merges them.

    Called again it goes on with the chunks that are missing. `warprock sweep run FOLDER` does the
    same chunks, in the jobs of an array or on a cluster.

    Args:
        case: The case, as in `run`.
        folder: Folder of the sweep: its plan, its chunks and the merged table.
        engine: As in `run`.
        chunk: Lanes in a chunk.
        **how: overrides, tolerance, precision, device, workers and progress, as in `run`.

    Returns:
        A `Found` whose table is the lane table of all chunks.

    Raises:
        InputError: Something cannot be used, or the folder holds another plan.

    Example:
        >>> import tempfile
        >>> import warprock as wr
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     found = wr.sweep("free-b0", folder, "housner", chunk=1, progress=False)
        >>> found.facts["chunks_done"], len(found.table)
        (2, 2)
    """
    place = pathlib.Path(folder)
    with working(case, engine, **how) as work:
        quiet = dataclasses.replace(work.options, progress=None)
        plan = make_plan(work.case, work.engine, quiet, chunk_lanes=chunk)
        write_plan(plan, place)
        report = work.options.progress or (lambda _: None)
        run_here(plan, place, work.options.workers)(chunks_to_run(plan, place, Shard()), report)
        merge(plan, place)
    return SweepFound(f"{work.case.name}: sweep with {work.engine}", plan, place)


class SweepFound(Found):
    """A sweep that is done, in a folder of its own; `save` writes its table to another one."""

    _saves_page = False

    def __init__(self, title: str, plan: Plan, folder: pathlib.Path) -> None:
        # Read now, so that it stays when the folder goes.
        found = find_sweep(plan, folder, read_lanes(folder))
        show = functools.partial(print_state, found.json, folder)
        find = functools.partial(dataclasses.replace, found, show=show)
        super().__init__(title, plan, find, functools.partial(untitled, list))
        self.folder = folder

    @at_the_door
    def report(self, folder: str | os.PathLike[str] | None = None) -> pathlib.Path:
        """The page of the sweep, in its folder.

        Args:
            folder: That folder, or None.

        Returns:
            The file.

        Raises:
            InputError: It is another folder.
        """
        if folder is not None and pathlib.Path(folder) != self.folder:
            allowed = f"must be left out, or {self.folder}, where the sweep lies"
            raise InputError("folder", "", os.fspath(folder), allowed)
        return self._write_page(self.folder)
