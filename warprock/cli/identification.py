"""The command `identify`: a block from its free rocking."""

from __future__ import annotations

import pathlib

import click

from warprock.cli.analysis import finish
from warprock.cli.options import json_option, output_option
from warprock.cli.signatures import own_options, read_function


@click.command(help=read_function("identification", "identify").text)
@click.argument("history", type=click.Path(path_type=pathlib.Path))
@own_options("identification", "identify")
@output_option
@json_option
def identify(
    history: pathlib.Path,
    fit: tuple[str, ...],
    column: str | None,
    unit: str | None,
    folder: pathlib.Path | None,
    as_json: bool,
    width: str | None,
    height: str | None,
    slenderness: str | None,
    frequency_parameter: str | None,
) -> None:
    """The command of `warprock.identify`."""
    from warprock.api.identification import identify_of

    texts = {
        "width": width,
        "height": height,
        "slenderness": slenderness,
        "frequency-parameter": frequency_parameter,
    }
    found = identify_of(history, texts, fit, column, unit)
    finish(found, folder, as_json=as_json, then=_then(found.facts["identified"]))


def _then(found: dict[str, float]) -> str:
    """The command to try next: a block with this restitution."""
    return f"warprock run CASE -s contact.angular_restitution={found['angular_restitution']:.4g}"


COMMANDS = (identify,)
