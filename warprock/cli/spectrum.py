"""The command `spectrum`: peak rotations of blocks of many sizes under one motion."""

from __future__ import annotations

import functools
import pathlib
from typing import Any

import click

from warprock.cli.analysis import case_work, finish, run_of, running
from warprock.cli.options import case_options, estimate_options


@click.command()
@case_options
@estimate_options
def spectrum(folder: pathlib.Path | None, as_json: bool, **asked: Any) -> None:
    """Rocking spectra: peak rotation / slenderness angle over 2 pi / p, a curve a slenderness.

    CASE has a [spectrum] table with the periods 2 pi / p and the slenderness angles; axes of its
    sweep, each with a label, make panels.
    """
    from warprock.analysis.spectrum import run_spectrum
    from warprock.figures.spectrum import draw_spectrum
    from warprock.tables.spectrum import spectrum_report

    work = case_work(**asked)
    with running(work, work.case.lane_count) as options:
        found = run_spectrum(work.case, work.engine, options)
    then = run_of(work.engine, folder, **asked)
    draw = functools.partial(draw_spectrum, found=found)
    finish(spectrum_report(found), draw, folder, as_json=as_json, then=then, run=found.run)


COMMANDS = (spectrum,)
