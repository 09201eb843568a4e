"""The commands `doctor` and `bench`: this machine, and what steps cost on it."""

from __future__ import annotations

import pathlib

import click

from warprock.cli.analysis import call, finish, show
from warprock.cli.exits import EXIT_FAILED
from warprock.cli.options import json_option, output_option, workers_option
from warprock.cli.sections import Several
from warprock.cli.signatures import help_of, own_options, read_function
from warprock.cli.sweep import bench_sweep


@click.command(help=read_function("doctor", "doctor").text)
@json_option
@click.pass_context
def doctor(ctx: click.Context, as_json: bool) -> None:
    """The command of `warprock.doctor`."""
    from warprock.api import doctor as api

    found, _engine = call(api.doctor)
    show(found, as_json=as_json)
    if found.facts["missing"]:
        ctx.exit(EXIT_FAILED)


@click.group(cls=Several, invoke_without_command=True, help=read_function("bench", "bench").text)
@own_options("bench", "bench")
@click.option("--device", help=help_of("bench", "bench", "device"))
@output_option
@workers_option
@json_option
@click.pass_context
def bench(
    ctx: click.Context,
    seconds: float,
    device: str | None,
    folder: pathlib.Path | None,
    workers: int | None,
    as_json: bool,
) -> None:
    """The command of `warprock.bench`."""
    if ctx.invoked_subcommand is not None:
        return
    from warprock.api import bench as api
    from warprock.api.names import called_by_command

    with called_by_command():
        found = api.bench(seconds=seconds, device=device, workers=workers)
    finish(found, folder, as_json=as_json, then=found.finding.then, always=True)


@click.command("assembly")
@click.option("--space", is_flag=True, help="Walls in space, along their plane and out of it.")
@json_option
def bench_assembly(space: bool, as_json: bool) -> None:
    """Arches, drums and walls in MuJoCo and Bullet beside ours: collapse loads, errors, cost.

    Collapse loads stand beside those of limit analysis; the error is that of the motion of a wall
    of 33 blocks, in space of 60, in a second of a sine. Takes some five minutes.
    """
    from warprock.measure.assembly_bench import run_assembly_bench
    from warprock.running.devices import start_warp
    from warprock.tables.machine import print_assembly_bench
    from warprock.tables.terminal import print_json

    start_warp()
    found = run_assembly_bench(report=lambda text: click.echo(text, err=True), space=space)
    print_json(found) if as_json else print_assembly_bench(found)


@click.command("blocks")
@click.option("--blocks", type=int, multiple=True, help="10 to 10,000 without; repeat.")
@click.option("--space", is_flag=True, help="Walls of bricks in space; 10 to 300 without --blocks.")
@workers_option
@json_option
def bench_blocks(blocks: tuple[int, ...], space: bool, workers: int | None, as_json: bool) -> None:
    """What a lane of an assembly costs by its number of blocks: walls that stand on a moving base.

    Takes some minutes; a wall of 10,000 blocks most of them.
    """
    from warprock.measure.blocks_bench import run_blocks_bench
    from warprock.running.devices import start_warp
    from warprock.tables.machine import print_blocks_bench
    from warprock.tables.terminal import print_json

    start_warp()
    rows = run_blocks_bench(
        blocks, space=space, workers=workers, report=lambda text: click.echo(text, err=True)
    )
    print_json({"rows": rows}) if as_json else print_blocks_bench(rows)


bench.add_command(bench_assembly)
bench.add_command(bench_blocks)
bench.add_command(bench_sweep)
COMMANDS = (doctor, bench)
