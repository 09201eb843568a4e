"""Rocking spectra: the function, which the command of its name calls."""

from __future__ import annotations

import functools
from typing import Unpack

from warprock.analysis.spectrum import run_spectrum
from warprock.api.case import AnyCase
from warprock.api.found import Found
from warprock.api.work import HowHeld, working
from warprock.arguments import at_the_door, listing
from warprock.figures.spectrum import draw_spectrum, plot_spectrum
from warprock.findings.spectrum import find_spectrum
from warprock.report.scenes import scenes_of


@listing(working)
@at_the_door
def spectrum(
    case: AnyCase,
    engine: str | None = None,
    **how: Unpack[HowHeld],
) -> Found:
    """Rocking spectra: peak rotation / slenderness angle over 2 pi / p, a curve a slenderness.

    `case` has a [spectrum] table with the periods 2 pi / p and the slenderness angles; axes of its
    sweep, each with a label, make panels.

    Args:
        case: The case, as in `run`, with a `Spectrum`.
        engine: Name of the engine, as in `run`.
        **how: overrides, tolerance, precision, device, workers and progress, as in `run`.

    Returns:
        A `Found` whose table has one row a block.

    Raises:
        InputError: Something cannot be used, said before anything runs.

    References:
        N. Makris and D. Konstantinidis (2003), The rocking spectrum and the limitations of
        practical design methodologies, *Earthquake Engineering and Structural Dynamics* 32.

    Example:
        >>> import warprock as wr
        >>> curve = {"spectrum.period": ["2 s", "4 s"], "spectrum.slenderness": ["10 deg"]}
        >>> curve |= {"run.duration": "20 s"}
        >>> found = wr.spectrum("rocking-spectrum", "housner", overrides=curve, progress=False)
        >>> found.table["period_s"].tolist()
        [2.0, 4.0]
    """
    with working(case, engine, **how) as work:
        found = run_spectrum(work.case, work.engine, work.options)
        return Found(
            f"{work.case.name}: rocking spectrum with {work.engine}",
            found,
            functools.partial(find_spectrum, found),
            functools.partial(draw_spectrum, found),
            (len(found.groups), functools.partial(plot_spectrum, found=found)),
            functools.partial(scenes_of, found.run),
        )
