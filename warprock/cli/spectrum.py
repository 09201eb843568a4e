"""The command `spectrum`: peak rotations of blocks of many sizes under one motion."""

from __future__ import annotations

import pathlib
from typing import Any

import click

from warprock.cli.analysis import case_work, finish, run_of
from warprock.cli.options import case_options, estimate_options


@click.command()
@case_options
@estimate_options
def spectrum(folder: pathlib.Path | None, as_json: bool, **asked: Any) -> None:
    """Rocking spectra: peak rotation / slenderness angle over 2 pi / p, a curve a slenderness.

    CASE has a [spectrum] table with the periods 2 pi / p and the slenderness angles; axes of its
    sweep, each with a label, make panels.
    """
    from warprock.api.analyses.spectrum import spectrum_of

    with case_work(**asked, runs=1) as work:
        found = spectrum_of(work)
    finish(found, folder, as_json=as_json, then=run_of(work.engine, folder, **asked))


COMMANDS = (spectrum,)
