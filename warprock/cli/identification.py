"""The command `identify`: a block from its free rocking."""

from __future__ import annotations

import math
import pathlib
import shlex
from typing import Any

import click

from warprock.cli.analysis import call, finish
from warprock.cli.options import json_option, output_option
from warprock.cli.signatures import own_options, read_function


@click.command(help=read_function("identification", "identify").text)
@click.argument("history", type=click.Path(path_type=pathlib.Path))
@own_options("identification", "identify")
@output_option
@json_option
def identify(
    history: pathlib.Path, folder: pathlib.Path | None, as_json: bool, **asked: Any
) -> None:
    """The command of `warprock.identify`."""
    from warprock.api import identification as api

    found, _engine = call(api.identify, history, **asked)
    finish(found, folder, as_json=as_json, then=_then(found.facts["identified"]))


HEIGHT = 1.0
"""Height of a block of which only the slenderness is known [m]."""


def _then(found: dict[str, Any]) -> str:
    """The command to try next: the block that was found, as a box that is let go.

    A box has the same motion as the block if its slenderness angle and its frequency parameter are
    the same.
    """
    from warprock.units import GRAVITY

    angle, rate = found["slenderness_angle_rad"], found["frequency_parameter_rad_s"]
    diagonal = HEIGHT / math.cos(angle) if rate is None else 1.5 * GRAVITY / rate**2
    width, height = diagonal * math.sin(angle), diagonal * math.cos(angle)
    # Noise may take it beyond what a case allows.
    kept = f"{min(max(found['angular_restitution'], 0.0), 1.0):.4g}"
    settings = [f"block.width={width:.4g} m", f"block.height={height:.4g} m"]
    if found["one_sided"]:
        settings += ["transverse_wall.side=left", f"transverse_wall.rebound={kept}"]
    else:
        settings += [f"contact.angular_restitution={kept}"]
    words = [word for setting in settings for word in ("-s", setting)]
    return shlex.join(["warprock", "run", "free-b0", "-e", "housner", *words])


COMMANDS = (identify,)
