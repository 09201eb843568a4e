"""The commands `sweep plan`, `run`, `status` and `merge`, and `bench sweep`."""

from __future__ import annotations

import dataclasses
import pathlib
import sys
from collections.abc import Callable
from typing import Any, TypeVar

import click

from warprock.cli.exits import EXIT_BAD_LANES, EXIT_RESUMABLE
from warprock.cli.options import (
    asked_options,
    case_argument,
    device_options,
    engine_for,
    engine_option,
    estimate_options,
    json_option,
    max_bad_option,
    output_file_to,
    output_to,
    say_engine,
    set_option,
    workers_option,
)
from warprock.cli.pages import add_page
from warprock.cli.sections import Several
from warprock.cli.signatures import own_options

Command = TypeVar("Command", bound=Callable[..., Any])


@click.group(cls=Several)
def sweep() -> None:
    """Many lanes in chunks that are resumed, spread over machines and merged.

    A plan is written first; `run` then does the chunks that are missing, as often as it is called,
    on one machine, in the jobs of an array (--shard) or on a Dask cluster (--scheduler).
    """


def _folder_argument(command: Command) -> Command:
    return click.argument("folder", metavar="DIR", type=click.Path(path_type=pathlib.Path))(command)


@sweep.command()
@case_argument
@engine_option
@set_option
@output_to("Folder of the sweep; made if it does not exist.", required=True)
@own_options("sweep", "sweep")
@device_options
@estimate_options
@json_option
def plan(
    case_name: str,
    engine: str | None,
    overrides: tuple[str, ...],
    folder: pathlib.Path,
    chunk: int,
    as_json: bool,
    **how: Any,
) -> None:
    """Write the plan of a sweep over the lanes of a CASE, after a look at every one of them."""
    from warprock.case.load import load_case
    from warprock.sweeps.plan import make_plan, plan_facts, write_plan
    from warprock.tables import sweeps, terminal

    case = load_case(case_name, overrides)
    options = asked_options(**how)
    choice = engine_for(case, engine)
    with terminal.lane_progress("look at every lane", case.lane_count) as progress:
        made = make_plan(
            case,
            choice.engine,
            dataclasses.replace(options, progress=progress),
            chunk_lanes=chunk,
        )
    written = write_plan(made, folder)
    say_engine(choice)
    page = add_page(folder)
    found = plan_facts(made) | {"folder": str(folder), "written": written, "files": [page]}
    if as_json:
        terminal.print_json(found)
    else:
        sweeps.print_plan(found)
        terminal.print_written([page])


@sweep.command()
@_folder_argument
@workers_option
@click.option("--shard", default="1/1", help="Part i/n of the chunks: every n-th, i from 1 to n.")
@click.option("--scheduler", help="Address of a Dask scheduler, or local; needs the extra [dask].")
@max_bad_option
@json_option
@click.pass_context
def run(
    ctx: click.Context,
    folder: pathlib.Path,
    workers: int | None,
    shard: str,
    scheduler: str | None,
    max_bad: float | None,
    as_json: bool,
) -> None:
    """Run the chunks of a sweep that are not there yet.

    Ctrl-C, SIGTERM and SIGUSR1 drop the chunk in hand; what is done stays, and running again goes
    on. Exits with 75 after the signals, with 130 after Ctrl-C.
    """
    from warprock.running.files import require_writable
    from warprock.sweeps.plan import read_plan
    from warprock.sweeps.run import (
        Stopped,
        chunks_to_run,
        read_shard,
        run_here,
        shard_counts,
        stopping,
    )
    from warprock.tables import sweeps, terminal

    part = read_shard(shard)
    found = read_plan(folder)
    require_writable(folder, "DIR")
    run_chunks = run_here(found, folder, workers)
    if scheduler is not None:
        from warprock.sweeps.dask import run_on_dask

        run_chunks = run_on_dask(found, folder, scheduler, workers)
    numbers = chunks_to_run(found, folder, part)
    lanes = sum(len(found.lanes_of(number)) for number in numbers)
    kept = len(part.chunks(found)) - len(numbers)
    try:
        with stopping(), sweeps.sweep_progress(lanes, len(numbers), kept) as progress:
            run_chunks(numbers, progress)
    except Stopped as stopped:
        _say_left(stopped.args[0], folder)
        ctx.exit(EXIT_RESUMABLE)
    except KeyboardInterrupt:
        _say_left("Ctrl-C", folder)
        raise
    counts = shard_counts(found, folder, part) | {"folder": str(folder)}
    settings = found.case.engine_settings(found.engine)
    if as_json:
        terminal.print_json(counts)
    else:
        sweeps.print_counts(counts, found.engine, settings)
    if max_bad is not None and counts["bad"] > max_bad * counts["lanes_done"]:
        ctx.exit(EXIT_BAD_LANES)


def _say_left(why: str, folder: pathlib.Path) -> None:
    click.echo(
        f"{why}: the chunk in hand is dropped, what is done is kept; to go on: "
        f"warprock sweep run {folder}",
        err=True,
    )
    sys.stderr.flush()


@sweep.command()
@_folder_argument
@json_option
def status(folder: pathlib.Path, as_json: bool) -> None:
    """How far a sweep is: its chunks, and what became of the lanes so far."""
    from warprock.sweeps.chunks import sweep_state
    from warprock.sweeps.plan import read_plan
    from warprock.tables import sweeps, terminal

    found = sweep_state(read_plan(folder), folder)
    terminal.print_json(found) if as_json else sweeps.print_state(found, folder)


@sweep.command()
@_folder_argument
@output_file_to(
    "file",
    "File to write, Parquet, or CSV where it ends in .csv. Without, lanes.parquet in DIR, and "
    "lanes.csv of up to 10,000 lanes.",
)
@json_option
def merge(folder: pathlib.Path, file: pathlib.Path | None, as_json: bool) -> None:
    """Join the chunks of a sweep that is done in one table, all lanes in order."""
    from concurrent.futures import ThreadPoolExecutor

    from warprock.case.lanes import expand_lanes
    from warprock.model.words import lane_count_text
    from warprock.report.replays import played_of_sweep
    from warprock.running.files import require_writable, require_writable_file
    from warprock.running.results import LANE_CSV, MOST_CSV_LANES
    from warprock.sweeps.chunks import merge as merge_chunks
    from warprock.sweeps.plan import read_plan
    from warprock.tables.terminal import lane_progress, print_end, print_json

    found = read_plan(folder)
    require_writable(folder, "DIR") if file is None else require_writable_file(file)
    with lane_progress("merge", found.lane_count) as progress, ThreadPoolExecutor(1) as beside:
        # The page plays lanes: what makes them is loaded while Arrow joins the chunks.
        beside.submit(expand_lanes, found.case, range(1))
        written = merge_chunks(found, folder, file, progress)
        if file is None and found.lane_count <= MOST_CSV_LANES:
            merge_chunks(found, folder, folder / LANE_CSV)
    if file is None:
        page = add_page(folder, scenes=played_of_sweep(found, folder))
        click.echo(f"wrote {page}", err=True)
    facts = {"plan": found.id, "lanes": found.lane_count, "file": str(written)}
    if as_json:
        print_json(facts)
    else:
        click.echo(written)
        count = found.lane_count
        said = f"{lane_count_text(count)} {'is' if count == 1 else 'are'} in one table."
        print_end(said, f"warprock fragility {written}")


@click.command("sweep")
@click.option("--lanes", type=int, multiple=True, help="10,000 and 1,000,000 without; repeat.")
@click.option("-e", "--engine", "engines", multiple=True, help="housner and event without; repeat.")
@workers_option
@json_option
def bench_sweep(
    lanes: tuple[int, ...], engines: tuple[str, ...], workers: int | None, as_json: bool
) -> None:
    """Lanes a second and memory of whole sweeps, from the plan to the merged table.

    Every lane is 20 s of a shipped record at its own scale, width and height and, with housner, its
    own angular restitution.
    """
    from warprock.measure.sweep_bench import ENGINES, LANES, run_sweep_bench
    from warprock.running.case_run import require_choice
    from warprock.settings.engines import SETTINGS
    from warprock.tables import sweeps, terminal

    for engine in engines:
        require_choice("--engine", engine, tuple(SETTINGS))
    rows = run_sweep_bench(
        lanes or LANES,
        engines or ENGINES,
        workers=workers,
        report=lambda text: click.echo(text, err=True),
    )
    terminal.print_json({"rows": rows}) if as_json else sweeps.print_sweep_bench(rows)


COMMANDS = (sweep,)
