"""Yearly rates: the function, which the command of its name calls."""

from __future__ import annotations

import dataclasses
import functools
import os
import pathlib
from collections.abc import Mapping, Sequence
from typing import Unpack

import numpy as np
import pandas as pd

from warprock.analysis.hazard_files import parse_age
from warprock.analysis.lane_tables import read_lanes
from warprock.analysis.limits import read_limits
from warprock.analysis.risk import Risk, assess
from warprock.analysis.risk_functions import (
    CAPACITIES,
    functions_of,
    functions_of_components,
    is_component_table,
    read_components,
)
from warprock.api.analyses.fragility import Table
from warprock.api.asked import HazardAsked, hazard_of
from warprock.api.found import Found
from warprock.api.names import python_names
from warprock.api.values import Age, Column, Length, Share
from warprock.api.weights import AnyWeights, weights_of
from warprock.arguments import at_the_door, listing, require_within, several
from warprock.errors import NOTHING, InputError
from warprock.figures.risk import draw_risk, plot_risk
from warprock.findings.risk import find_risk


@listing(hazard_of)
@at_the_door
def risk(
    table: Table | Sequence[Table] | Mapping[str, Table],
    *,
    limit: str | float | Sequence[str | float] = (),
    limit_slide: Length | Sequence[Length] = (),
    by: Column | Sequence[Column] = (),
    max_doubt: Share = 0.2,
    weights: AnyWeights | None = None,
    years: float | Sequence[float] = (),
    survived: Age | None = None,
    unlikely: Share = 0.05,
    max_outside: Share = 0.1,
    **asked: Unpack[HazardAsked],
) -> Found:
    """How often in a year blocks reach a limit state, under a hazard curve of yours.

    Fragility functions are fitted to the lanes over the measure of the hazard; the rate is their
    integral over it, in closed form, with the band over records. The hazard is a file, `hazard`, or
    a power law: an intensity x is exceeded `k0` (x / `at`)^-`k` times a year.

    Args:
        table: What `run`, `sweep` or `ida` found, a lane table, or the path of one or of a folder;
            a component table with medians and dispersions (fragility-p58.csv), as pelicun has it;
            or several, by name or in a row, which are objects side by side.
        limit: Limit state: uplift, overturning or a peak rotation / slenderness angle; or several
            [default: overturning].
        limit_slide: Limit state: a peak slide, such as "10 mm"; or several.
        by: Column of groups; or several.
        max_doubt: Share of a group's lanes that may be left out or in doubt [-]; more is refused.
        weights: Weights of records: a CSV file with the columns record and weight, or the column of
            the lane table that has them.
        years: Within how many years the chance is told; or several [default: 1, 50].
        survived: Age of an object that still stands, such as "10 ka": what it allows the hazard to
            be.
        unlikely: Chance of standing that long below which a hazard is ruled out [-].
        max_outside: Share of a rate that may come from motions beyond an end of the hazard [-].
        **asked: hazard, a curve; or k0, k and at, a power law; and im, their intensity measure.

    Returns:
        A `Found` whose table has one row a function; `found` are the rates.

    Raises:
        InputError: A hazard that cannot be read, is over another measure, or ends too early; or as
            of `fragility`.

    References:
        C. A. Cornell and H. Krawinkler (2000), Progress and challenges in seismic performance
        assessment, *PEER Center News* 3(2).

    Example:
        >>> import warprock as wr
        >>> run = wr.run("fragility-five-blocks", "housner", progress=False)
        >>> found = wr.risk(run, k0=1e-4, k=2.0, im="PGA", max_doubt=1.0)
        >>> found.table["verdict"].tolist()
        ['fitted']
    """
    with python_names():
        under = hazard_of(**asked)
        limits = [each if isinstance(each, str) else f"{each:g}" for each in several(limit)]
        slides, spans = several(limit_slide), several(years)
        tables, weighed = _named(table), weights_of(weights)
        require_within("--max-doubt", max_doubt, 0.0, 1.0)
        require_within("--max-outside", max_outside, 0.0, 1.0)
        require_within("--unlikely", unlikely, 1e-12, 1.0 - 1e-12)
        for span in spans:
            if not (np.isfinite(span) and span > 0.0):
                raise InputError("--years", "", span, "must be a number of years above 0")
        age = None if survived is None else parse_age("--survived", survived)
        chosen = read_limits(limits or (() if slides else ("overturning",)), slides)
        risks: list[Risk] = []
        for name, one in tables.items():
            rows, source = read_table(one)
            if is_component_table(rows):
                states = [each.text for each in chosen] if limits or slides else []
                functions = functions_of_components(rows, under, source, states)
            else:
                functions = functions_of(
                    rows,
                    under,
                    source=source,
                    limits=chosen,
                    by=several(by),
                    most_doubt=max_doubt,
                    weights=weighed,
                )
            for each in functions:
                named = {"object": name, **each.name} if len(tables) > 1 else each.name
                risks.append(assess(dataclasses.replace(each, name=named), under, max_outside))
        return Found(
            f"risk over {under.measure}",
            risks,
            functools.partial(find_risk, risks, spans or (1.0, 50.0), age, unlikely),
            functools.partial(draw_risk, risks, age, unlikely),
            (len(risks), functools.partial(plot_risk, risks=risks)),
        )


def _named(table: Table | Sequence[Table] | Mapping[str, Table]) -> dict[str, Table]:
    """Tables by name."""
    if isinstance(table, Mapping):
        found = {str(name): each for name, each in table.items()}
    elif isinstance(table, pd.DataFrame | Found | str | os.PathLike):
        found = {"table": table}
    else:
        found = _named_in_turn(table)
    if not found:
        raise InputError("table", "", NOTHING, "must be at least one table")
    return found


def _named_in_turn(tables: Sequence[Table]) -> dict[str, Table]:
    """Tables by the names of their folders, or by number where these are not told apart."""
    names = [
        each.title if isinstance(each, Found) else
        "table" if isinstance(each, pd.DataFrame) else
        pathlib.Path(each).resolve().name
        for each in tables
    ]  # fmt: skip
    if len(set(names)) < len(names):
        names = [f"{number} {name}" for number, name in enumerate(names, start=1)]
    return dict(zip(names, tables, strict=True))


def read_table(table: Table) -> tuple[pd.DataFrame, str]:
    """A lane table or the capacities of an incremental analysis, and what errors name it."""
    if isinstance(table, Found):
        return table.table, table.title
    if isinstance(table, pd.DataFrame):
        return table, "table"
    path = pathlib.Path(table)
    if path.suffix == ".csv":
        return read_components(path), os.fspath(table)
    capacities = path / CAPACITIES
    return read_lanes(capacities if capacities.is_file() else path), os.fspath(table)
