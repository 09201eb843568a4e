"""Briefs: the function, which the command of its name calls."""

from __future__ import annotations

import dataclasses
import functools
import pathlib
from collections.abc import Mapping, Sequence
from typing import Any, Unpack

import numpy as np

from warprock import __version__
from warprock.analysis.brief import Brief, run_brief
from warprock.analysis.incremental import Ladder
from warprock.analysis.measures import Question, own_measure
from warprock.analysis.risk import chance_within
from warprock.api.asked import HazardAsked, HazardLadder, LadderAsked, hazard_of, ladder_of, taken
from warprock.api.case import AnyCase
from warprock.api.found import Found
from warprock.api.names import python_names
from warprock.api.values import Length, Share
from warprock.api.work import HowHeld, working
from warprock.arguments import at_the_door, listing, require_within, several
from warprock.errors import InputError
from warprock.figures.brief import draw_object
from warprock.figures.drawing import Drawing
from warprock.figures.measures import bare_measures, draw_measures, plot_measures
from warprock.figures.risk import bare_risk, draw_risk
from warprock.findings.brief import (
    LEFT_OUT,
    YEARS,
    chances,
    find_brief,
    object_text,
    slide_sentence,
    sure_sentences,
    takes_sentence,
    times,
)
from warprock.findings.finding import Finding
from warprock.findings.measures import TABLE, best_measure, target_sentences
from warprock.findings.risk import percent_text
from warprock.report.brief import (
    BRIEF_PAGE,
    BRIEF_PDF,
    BriefPage,
    find_browser,
    print_page,
    render_brief,
)
from warprock.units import Dimension, parse_quantity


@listing(hazard_of, ladder_of, working)
@at_the_door
def brief(
    case: AnyCase,
    engine: str | None = None,
    *,
    measure: str | Sequence[str] = (),
    target: float | None = None,
    clearance: Length | None = None,
    accuracy: float = 0.02,
    max_outside: Share = 0.1,
    **asked: Unpack[HazardLadder],
) -> Found:
    """One page for a decision about one object: how likely it falls, what it takes, what helps.

    `case` is one block under several records, a lane each. The page has the object with a picture,
    the chance that it falls within a year and within 50 years in words and digits, what it takes
    and how often that comes, whether it slides into something first, measures by their factor on
    the rate, how sure all this is, and what was left out. `save` writes it as brief.html, two
    printed sheets, and as brief.pdf where a browser is there that prints.

    Args:
        case: The case, as in `run`.
        engine: Name of the engine, as in `run`.
        measure: Measure, as in `measures`; or several [default: those that the block can have].
        target: Yearly rate at which the least width and the least straps are looked for.
        clearance: Distance to the nearest thing that it must not slide into, such as "50 mm".
        accuracy: Width of a bracket over its least factor at which it is narrow enough [-].
        max_outside: Share of a rate that may come from motions beyond an end of the hazard [-].
        **asked: hazard, k0, k, at and im, the hazard as in `risk`; from_, to and count, the factors
            as in `ida`; overrides, tolerance, precision, device, workers and progress, as in `run`.

    Returns:
        A `Found` whose facts have the answers, `facts["brief"]`, and whose table has one row a
        measure; `found` is the brief.

    Raises:
        InputError: As of `measures`, or a clearance that is not above 0.

    References:
        M. D. Mastrandrea and others (2010), *Guidance note for lead authors of the IPCC fifth
        assessment report on consistent treatment of uncertainties*, table 1: words for chances.

    Example:
        >>> import warprock as wr
        >>> one = {"motion.scale": 1.0, "block.width": "0.5 m", "run.duration": "30 s"}
        >>> asked = {"k0": 1e-3, "k": 2.0, "count": 9, "accuracy": 0.1, "progress": False}
        >>> wider = {"measure": "block.width=0.6 m", "overrides": one, **asked}
        >>> found = wr.brief("fragility-five-blocks", "housner", **wider)
        >>> 0.0 < found.facts["brief"]["rate_per_year"] < 1.0
        True
    """
    with python_names():
        require_within("--max-outside", max_outside, 0.0, 1.0)
        question = Question(
            hazard_of(**taken(asked, HazardAsked)),
            ladder_of(accuracy, **taken(asked, LadderAsked)),
            [own_measure(text) for text in several(measure)],
            target,
            max_outside,
            read_clearance(clearance),
        )
    factors, how = question.ladder.factors.tolist(), taken(asked, HowHeld)
    with working(case, engine, runs=0, factors=factors, **how) as work:
        found = run_brief(work.case, work.engine, work.options, question)
        return BriefFound(
            f"{work.case.name}: brief with {work.engine}",
            found,
            functools.partial(_find, found, question.ladder),
            functools.partial(_draw, found),
            (1, functools.partial(plot_measures, found=found.measures)),
        )


def read_clearance(text: str | None) -> float:
    """A clearance [m]; NaN where none is asked for.

    Raises:
        InputError: It is no length above 0.
    """
    if text is None:
        return float("nan")
    try:
        found = parse_quantity(text, Dimension.LENGTH)
    except ValueError as error:
        raise InputError("--clearance", "", text, str(error)) from None
    if not found > 0.0:
        raise InputError("--clearance", "", text, "must be above 0")
    return found


class BriefFound(Found):
    """A brief: `save` leaves its page and, where a browser is there, its print, too.

    Attributes:
        unprinted: Why the last `save` left no PDF; empty where it left one.
    """

    unprinted = ""

    def write(self, folder: pathlib.Path) -> list[pathlib.Path]:
        """Writes all but the figures and the page of results."""
        files = super().write(folder)
        browser = find_browser()
        self.unprinted = (
            f"no browser that prints was found: open {folder / BRIEF_PAGE} and print it"
            if browser is None
            else print_page(folder / BRIEF_PAGE, browser)
        )
        return files if self.unprinted else [*files, folder / BRIEF_PDF]


def _draw(found: Brief, title: str) -> list[Drawing]:
    """Draws what lowers the rate of a brief, where the rate comes from, and the object."""
    drawings = draw_measures(found.measures, title) + draw_risk([found.base], None, 0.05, title)
    return [*drawings, draw_object(found.lane_set, found.measures.case.title)]


def _find(found: Brief, ladder: Ladder) -> Finding:
    """What it came to, with its page."""
    finding = find_brief(found, ladder)
    return dataclasses.replace(finding, texts={BRIEF_PAGE: render_brief(_page(found, finding))})


def _page(found: Brief, finding: Finding) -> BriefPage:
    base, rows = finding.facts["brief"], finding.frames[TABLE]
    picture = draw_object(found.lane_set, found.measures.case.title)
    figures, motions = bare_measures(found.measures), bare_risk(found.base)
    return BriefPage(
        title=base["object"],
        object=object_text(base),
        chances=chances(base),
        picture=picture.svg(),
        parts=[
            ("What it takes", [takes_sentence(base)]),
            ("Does it slide into something first?", [slide_sentence(base)]),
            ("How sure is this?", sure_sentences(base)),
        ],
        motions=motions.svg() if motions else "",
        # What an engine cannot do is in the table of measures.
        helps=[
            best_measure(rows, base),
            *(each for each in target_sentences(base) if "cannot do this" not in each),
        ],
        figure=figures.svg() if figures else "",
        rows=[_row(row, found.measures.engine) for row in rows.to_dict("records")],
        left_out=LEFT_OUT,
        made=f"Hazard: {base['hazard']}. Simulated with warprock {__version__}, engine "
        f"{found.measures.engine}, case {found.measures.case.name}, {base['records']} records.",
    )


def _row(row: Mapping[Any, Any], engine: str) -> dict[str, str]:
    """A measure as a row of the page."""
    known = np.isfinite(row["factor_p05"])
    rate, why = row["rate_per_year"], str(row["why"] or "")
    if why.startswith("no lane falls"):
        note = "never fell under what was tried"
    else:
        note = f"{engine} cannot simulate it" if "cannot do this" in why else why
    return {
        "name": str(row["measure"]),
        "factor": times(row["factor"]),
        "band": f"{times(row['factor_p05'])} to {times(row['factor_p95'])}" if known else "-",
        "chance": percent_text(chance_within(rate, YEARS[-1])) if rate > 0.0 else "-",
        "note": note,
    }
