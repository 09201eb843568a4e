"""Fragility functions: the function, which the command of its name calls."""

from __future__ import annotations

import functools
import os
import pathlib
from collections.abc import Mapping, Sequence
from typing import Any

import pandas as pd

from warprock.analysis.fragility import fragility_curves
from warprock.analysis.lane_tables import measure_named, read_lanes
from warprock.analysis.limits import DEFAULT_LIMITS, read_limits
from warprock.api.found import Found
from warprock.api.names import python_names
from warprock.api.values import Column, Length, Share
from warprock.api.weights import AnyWeights, weights_of
from warprock.arguments import at_the_door, require_within, several
from warprock.figures.fragility import draw_curves, groups_of, plot_curves
from warprock.findings.fragility import find_fragility
from warprock.report.replays import played_beside

Table = pd.DataFrame | Found | str | os.PathLike[str]
"""A lane table, what a run or a sweep found, or the path of a Parquet file or of its folder."""


@at_the_door
def fragility(
    table: Table,
    *,
    im: Column = "peak_acceleration_m_s2",
    limit: str | float | Sequence[str | float] = (),
    limit_slide: Length | Sequence[Length] = (),
    by: Column | Sequence[Column] = (),
    max_doubt: Share = 0.2,
    weights: AnyWeights | None = None,
) -> Found:
    """Fragility functions: how likely a limit state is, over an intensity of the motion.

    For each group of lanes and limit state the lognormal function of greatest likelihood, with a
    band over records, or why there is none.

    Args:
        table: A lane table, what `run` or `sweep` found, or the path of one or of its folder.
        im: Column of the intensity measure; or PGA, PGV.
        limit: Limit state: uplift, overturning or a peak rotation / slenderness angle; or several
            [default: uplift, 0.15, 0.35, overturning].
        limit_slide: Limit state: a peak slide, such as "10 mm"; or several.
        by: Column of groups; or several.
        max_doubt: Share of a group's lanes that may be left out or in doubt [-]; more is refused.
        weights: Weights of records: a CSV file with the columns record and weight, or the column of
            the lane table that has them.

    Returns:
        A `Found` whose table has one row a group and limit state; `found` are the curves.

    Raises:
        InputError: A column that the table does not have, a limit that is none, or too many lanes
            in doubt.

    References:
        J. W. Baker (2015), Efficient analytical fragility function fitting using dynamic structural
        analysis, *Earthquake Spectra* 31(1), Eqs. 10 and 11.

    Example:
        >>> import warprock as wr
        >>> fewer = {"sample.lanes": 64}
        >>> run = wr.run("sobol-single-block", "housner", overrides=fewer, progress=False)
        >>> found = wr.fragility(run, limit="overturning", max_doubt=1)
        >>> found.table["reached"].tolist() == [int((run.table["outcome"] == "overturned").sum())]
        True
    """
    with python_names():
        lanes, source = lanes_of(table)
        limits = [each if isinstance(each, str) else f"{each:g}" for each in several(limit)]
        slides = several(limit_slide)
        require_within("--max-doubt", max_doubt, 0.0, 1.0)
        chosen = read_limits(limits or (() if slides else DEFAULT_LIMITS), slides)
        im = measure_named(im, lanes.columns.astype(str))
        curves = fragility_curves(
            lanes,
            source=source,
            intensity=im,
            limits=chosen,
            by=several(by),
            most_doubt=max_doubt,
            weights=weights_of(weights),
        )
        return Found(
            f"fragility over {im}",
            curves,
            functools.partial(find_fragility, lanes, curves, source, im),
            functools.partial(draw_curves, curves, im),
            (len(groups_of(curves)), functools.partial(plot_curves, curves=curves, intensity=im)),
            functools.partial(_played_of_table, table, lanes, im),
        )


def _played_of_table(table: Table, lanes: pd.DataFrame, intensity: str) -> Mapping[str, Any] | None:
    """Lanes to play of the run that a table is of; None where it is not known."""
    if isinstance(table, Found):
        return table.scenes()
    if isinstance(table, pd.DataFrame):
        return None
    return played_beside(lanes, pathlib.Path(table), intensity)


def lanes_of(table: Table) -> tuple[pd.DataFrame, str]:
    """A lane table, and what errors name as its source."""
    if isinstance(table, Found):
        return table.table, table.title
    if isinstance(table, pd.DataFrame):
        return table, "table"
    return read_lanes(pathlib.Path(table)), os.fspath(table)
