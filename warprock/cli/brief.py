"""The command `brief`: one page for a decision about one object."""

from __future__ import annotations

import pathlib
from typing import Any, cast

import click

from warprock.cli.analysis import call, finish
from warprock.cli.completion import overrides
from warprock.cli.options import case_options, estimate_options, hazard_options, ladder_options
from warprock.cli.signatures import own_options


@click.command()
@case_options
@estimate_options
@hazard_options
@own_options("brief", "brief", measure=overrides)
@ladder_options
def brief(case_name: str, folder: pathlib.Path | None, as_json: bool, **asked: Any) -> None:
    """One page for a decision about one object: how likely it falls, what it takes, what helps.

    CASE is one block under several records, a lane each. -o writes the page as brief.html, two
    printed sheets, and as brief.pdf where a browser is there that prints. The hazard is that of
    warprock risk, the measures those of warprock measures.
    """
    from warprock.api import brief as api

    found, _engine = call(api.brief, case_name, **asked)
    finish(found, folder, as_json=as_json)
    unprinted = cast("api.BriefFound", found).unprinted
    if folder is not None and unprinted:
        click.echo(f"note: {unprinted}", err=True)


COMMANDS = (brief,)
