"""The command `reproduce`: tables and figures of the seed paper."""

from __future__ import annotations

import pathlib
import time
from typing import TYPE_CHECKING

import click

from warprock.cli import completion
from warprock.cli.options import json_option, output_to, workers_option
from warprock.cli.pages import add_page
from warprock.errors import written_as

if TYPE_CHECKING:
    from warprock.figures.drawing import Drawing


@click.command()
@click.argument("target", shell_complete=completion.targets)
@output_to(
    "Folder for the results; made if it does not exist.", default="results", show_default=True
)
@workers_option
@click.option(
    "--full",
    is_flag=True,
    help="All members that the ensembles of the cases have; 2 to 16 times fewer otherwise.",
)
@click.option("--verbose", is_flag=True, help="Also print what each part took.")
@json_option
def reproduce(
    target: str,
    folder: pathlib.Path,
    workers: int | None,
    full: bool,
    verbose: bool,
    as_json: bool,
) -> None:
    """Recompute the seed paper's TARGET: table6, table7, fig4, ... or all.

    An unknown TARGET lists them all. Its numbers are printed beside ours for every reading of the
    paper, with the conflicts in the paper.
    """
    from warprock.paper import reproduce as paper
    from warprock.paper.page import keep
    from warprock.paper.print_tables import print_reproduction
    from warprock.running.case_run import require_choice
    from warprock.tables.terminal import lane_progress, print_json

    target = written_as(target, paper.TARGETS)
    require_choice("reproduce", target, tuple(paper.TARGETS))
    drawings: list[Drawing] = []
    with lane_progress(f"reproduce {target}", None) as progress:
        found = paper.reproduce(
            target, folder, workers=workers, progress=progress, full=full, drawings=drawings
        )
    kept = keep(found, folder)
    begin = time.perf_counter()
    found["files"] += [str(kept), str(add_page(folder, drawings=drawings))]
    found["seconds"]["page"] = time.perf_counter() - begin
    print_json(found) if as_json else print_reproduction(found, verbose=verbose)


COMMANDS = (reproduce,)
