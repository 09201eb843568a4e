"""The command `measures`: what lowers the yearly chance that a block falls."""

from __future__ import annotations

import pathlib
from typing import Any

import click

from warprock.cli.analysis import call, finish
from warprock.cli.completion import overrides
from warprock.cli.options import case_options, estimate_options, hazard_options, ladder_options
from warprock.cli.signatures import own_options


@click.command()
@case_options
@estimate_options
@hazard_options
@own_options("measures", "measures", measure=overrides)
@ladder_options
def measures(case_name: str, folder: pathlib.Path | None, as_json: bool, **asked: Any) -> None:
    """What lowers the yearly chance that a block falls most: each measure as a factor on its rate.

    CASE is one block under several records, a lane each. It goes through an incremental dynamic
    analysis as it is and with each measure: a wider base, ballast at its foot, straps, an isolator,
    another floor, less or more friction, or measures of yours. The hazard is that of warprock risk.
    """
    from warprock.api import measures as api

    found, _engine = call(api.measures, case_name, **asked)
    finish(found, folder, as_json=as_json)


COMMANDS = (measures,)
