"""Options that several commands share."""

from __future__ import annotations

import pathlib
from collections.abc import Callable
from typing import Any, TypeVar

import click

Command = TypeVar("Command", bound=Callable[..., Any])


def json_option(command: Command) -> Command:
    """`--json`, as `as_json`."""
    return click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")(command)


def set_option(command: Command) -> Command:
    """`-s KEY=VALUE`, as `overrides`."""
    return click.option(
        "-s",
        "--set",
        "overrides",
        multiple=True,
        metavar="KEY=VALUE",
        help='Change a key of the case, such as -s block.height="5.5 m".',
    )(command)


def workers_option(command: Command) -> Command:
    """`--workers`."""
    return click.option("--workers", type=int, help="Worker threads; the cores at hand without.")(
        command
    )


def run_options(command: Command) -> Command:
    """`--precision`, `--device` and `--workers`."""
    options = (
        click.option("--precision", default="float64", show_default=True, help="Or float32."),
        click.option("--device", default="cpu", show_default=True, help="Warp device."),
        workers_option,
    )
    for option in reversed(options):
        command = option(command)
    return command


def output_option(command: Command) -> Command:
    """`-o`, as `folder`."""
    return click.option(
        "-o",
        "--output",
        "folder",
        type=click.Path(path_type=pathlib.Path),
        help="Folder for the results; made if it does not exist.",
    )(command)


def engine_option(command: Command) -> Command:
    """`-e`, None where none is named."""
    return click.option(
        "-e", "--engine", help="Engine; without, housner for one block, event for a stack."
    )(command)
