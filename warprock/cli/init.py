"""The command `init`: a new case."""

from __future__ import annotations

import pathlib
import shlex

import click

from warprock.cli import completion
from warprock.cli.options import reading_options, set_option


@click.command()
@click.argument("kind", required=False, shell_complete=completion.kinds)
@click.argument("path", required=False, type=click.Path(path_type=pathlib.Path))
@click.option(
    "--body",
    shell_complete=completion.bodies,
    help='bookcase, cabinet, column, drum, gas-cylinder or statue; or sizes: "0.6 m x 2 m x 0.4 m" '
    '(width x height x depth), "0.9 m x 6 m" (diameter x height of a cylinder).',
)
@click.option(
    "--record",
    shell_complete=completion.records,
    help="A shipped record, or a file of your own, which is written beside the case with its unit.",
)
@reading_options
@click.option(
    "--sweep",
    "sweeps",
    multiple=True,
    metavar="KEY=VALUES",
    shell_complete=completion.overrides,
    help='In the place of the sweeps of KIND, such as motion.target_pga="0.1 g to 1 g, 10"; repeat '
    "to cross.",
)
@set_option
def init(
    kind: str | None,
    path: pathlib.Path | None,
    body: str | None,
    record: str | None,
    sweeps: tuple[str, ...],
    overrides: tuple[str, ...],
    **table: str | None,
) -> None:
    """Write a commented case file of a KIND to start from, case.toml or PATH.

    For a body of any shape, from its mesh: warprock body.

    KIND is free, pulse, record, facade, parapet, strap, isolator, strip, stack, spatial, arch,
    wall, dry-stone, column, frame, corner, vault, sweep, sample, ensemble, map, spectrum or study.

    For example: warprock init record mine/case.toml --body cabinet --record quake.csv --unit g
    --sweep motion.target_pga="0.1 g to 1 g, 10"
    """
    from warprock.case.template import start_case
    from warprock.case.text import template_kinds
    from warprock.errors import NOTHING, InputError
    from warprock.recordings.column_file import Reading
    from warprock.running.catalogue import write_case
    from warprock.tables.terminal import print_end

    if kind is None:
        raise InputError("KIND", "", NOTHING, f"must be one of {', '.join(template_kinds())}")
    start = start_case(
        kind,
        body=body,
        record=record,
        reading=Reading(**table),
        sweeps=sweeps,
        overrides=overrides,
    )
    files = write_case(start, path or pathlib.Path("case.toml"))
    for file in files:
        click.echo(file)
    lanes = "one lane" if start.lanes == 1 else f"{start.lanes:,} lanes"
    command = {"map": "map", "spectrum": "spectrum", **LIMITS}.get(kind, "run")
    print_end(
        f"The case has {lanes}; change what does not fit your block.",
        f"warprock {command} {shlex.quote(str(files[0]))} -o results",
    )


LIMITS = dict.fromkeys(("arch", "corner", "vault"), "limit")
"""Kinds of cases whose collapse load one looks for first."""

COMMANDS = (init,)
