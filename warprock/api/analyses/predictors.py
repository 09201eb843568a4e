"""Predictors: the function, which the command of its name calls."""

from __future__ import annotations

import functools
from collections.abc import Sequence

from warprock.analysis.lane_tables import measure_named
from warprock.analysis.limits import read_limits
from warprock.analysis.predictors import RATIO, compare_measures
from warprock.api.analyses.fragility import Table, lanes_of
from warprock.api.found import Found
from warprock.api.names import python_names
from warprock.api.values import Column, Share
from warprock.api.weights import AnyWeights, weights_of
from warprock.arguments import at_the_door, require_within, several
from warprock.figures.predictors import draw_predictors, plot_losses
from warprock.findings.predictors import find_predictors


@at_the_door
def predictors(
    table: Table,
    *,
    im: Column | Sequence[Column] = (),
    limit: str | float = "overturning",
    max_doubt: Share = 0.2,
    weights: AnyWeights | None = None,
) -> Found:
    """Which intensity measures of motions predict best whether a limit state is reached.

    Each measure alone has its lognormal function, each two together a probability in both. How well
    they predict is told of records that a fit has not seen: each record is predicted by the fit to
    all others. Each measure is tested beside each other one, by the likelihood ratio and over
    records: one is sufficient where the other adds nothing.

    Args:
        table: A lane table, what `run` or `sweep` found, or the path of one or of its folder.
        im: Column of an intensity measure; or PGA, PGV; or several [default: those that the table
            has of PGA, PGV, both over what lifts the block, and the spectral acceleration].
        limit: Limit state: uplift, overturning or a peak rotation / slenderness angle.
        max_doubt: Share of the lanes that may be left out or in doubt [-]; more is refused.
        weights: Weights of records: a CSV file with the columns record and weight, or the column of
            the lane table that has them.

    Returns:
        A `Found` whose table has one row a measure, the one that predicts best first, and
        `tables["predictors-pairs.csv"]` one for each beside each other; `found` has the functions.
        `save` writes the function of the best two as slices, one at each of five values of the
        second, for OpenQuake (predictors.xml) and pelicun (predictors-p58.csv).

    Raises:
        InputError: A column that the table does not have, too many lanes in doubt, fewer than three
            records, or a limit state that all lanes reach or none.

    References:
        N. Luco and C. A. Cornell (2007), Structure-specific scalar intensity measures for
        near-source and ordinary earthquake ground motions, *Earthquake Spectra* 23(2).

    Example:
        >>> import warprock as wr
        >>> run = wr.run("fragility-five-blocks", "housner", progress=False)
        >>> found = wr.predictors(run, im=["PGA", "PGV"], max_doubt=1.0)
        >>> found.table["measure"].tolist()
        ['peak_velocity_m_s', 'peak_acceleration_m_s2']
    """
    with python_names():
        lanes, source = lanes_of(table)
        text = limit if isinstance(limit, str) else f"{limit:g}"
        require_within("--max-doubt", max_doubt, 0.0, 1.0)
        (chosen,) = read_limits([text], ())
        columns = [*lanes.columns.astype(str), RATIO]
        found = compare_measures(
            lanes,
            source=source,
            measures=[measure_named(name, columns) for name in several(im)],
            limit=chosen,
            most_doubt=max_doubt,
            weights=weights_of(weights),
        )
        return Found(
            f"predictors of {chosen.name}",
            found,
            functools.partial(find_predictors, found, source),
            functools.partial(draw_predictors, found),
            (1, functools.partial(plot_losses, found=found)),
        )
