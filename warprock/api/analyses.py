"""The analyses of a case as functions, named as the commands."""

from __future__ import annotations

import functools
import os
import pathlib
from collections.abc import Mapping, Sequence
from typing import Any, Unpack

import pandas as pd

from warprock.analysis.boundaries import TOLERANCE as BOUNDARY_TOLERANCE
from warprock.analysis.boundaries import refine, require_tolerance
from warprock.analysis.capacities import INTENSITIES, capacities, require_columns
from warprock.analysis.fragility import INTENSITY, MOST_DOUBT, fragility_curves
from warprock.analysis.incremental import Ladder, plan_analysis, run_analysis
from warprock.analysis.lane_tables import measure_named, read_lanes
from warprock.analysis.limits import DEFAULT_LIMITS, read_limits
from warprock.analysis.overturning import run_grid
from warprock.analysis.sensitivity import PEAK, run_sensitivity
from warprock.analysis.spectrum import run_spectrum
from warprock.api.case import AnyCase
from warprock.api.found import Found
from warprock.api.names import python_names
from warprock.api.work import How, HowHeld, listing_how, working
from warprock.arguments import at_the_door, several
from warprock.errors import InputError
from warprock.figures.fragility import draw_curves, groups_of, plot_curves
from warprock.figures.incremental import draw_analysis, plot_analysis
from warprock.figures.overturning import draw_map, plot_map
from warprock.figures.sensitivity import draw_sensitivity, plot_sensitivity
from warprock.figures.spectrum import draw_spectrum, plot_spectrum
from warprock.report.chosen import played_of_analysis
from warprock.report.replays import played_beside
from warprock.report.scenes import scenes_of
from warprock.running.work import Work
from warprock.tables.fragility import fragility_report
from warprock.tables.incremental import analysis_report
from warprock.tables.overturning import map_report
from warprock.tables.sensitivity import sensitivity_report
from warprock.tables.spectrum import spectrum_report

Table = pd.DataFrame | Found | str | os.PathLike[str]
"""A lane table, what a run or a sweep found, or the path of a Parquet file or of its folder."""


@at_the_door
def fragility(
    table: Table,
    *,
    im: str = INTENSITY,
    limit: str | float | Sequence[str | float] = (),
    limit_slide: str | Sequence[str] = (),
    by: str | Sequence[str] = (),
    max_doubt: float = MOST_DOUBT,
) -> Found:
    """Fragility functions: how likely a limit state is, over an intensity of the motion.

    For each group of lanes and limit state the lognormal function of greatest likelihood, with a
    band over records, or why there is none.

    Args:
        table: A lane table, what `run` or `sweep` found, or the path of one or of its folder.
        im: Column of the intensity measure, above 0 in every lane; or PGA, PGV.
        limit: Limit state, or several: "uplift", "overturning" or a peak rotation / slenderness
            angle; uplift, 0.15, 0.35 and overturning where neither these nor slides are given.
        limit_slide: Limit states that are a peak slide, such as "10 mm".
        by: Column that makes groups of lanes, or several.
        max_doubt: Share of a group's lanes that may be left out or in doubt [-]; more is refused.

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
    _require_within("max_doubt", max_doubt, 0.0, 1.0)
    groups, slides = several(by), several(limit_slide)
    with python_names():
        lanes, source = _lanes_of(table)
        im = measure_named(im, lanes.columns.astype(str))
        texts = [each if isinstance(each, str) else f"{each:g}" for each in several(limit)]
        chosen = read_limits(texts or (() if slides else DEFAULT_LIMITS), slides)
        how: dict[str, Any] = {"limits": chosen, "by": groups, "most_doubt": max_doubt}
        curves = fragility_curves(lanes, source=source, intensity=im, **how)
    return Found(
        f"fragility over {im}",
        curves,
        functools.partial(fragility_report, lanes, curves, source, im),
        functools.partial(draw_curves, curves, im),
        (len(groups_of(curves)), functools.partial(plot_curves, curves=curves, intensity=im)),
        functools.partial(_played_of_table, table, lanes, im),
    )


def _played_of_table(table: Table, lanes: pd.DataFrame, intensity: str) -> Mapping[str, Any] | None:
    """Lanes to play of the run that a table is of; None where it is not known."""
    if isinstance(table, Found):
        return table._scenes()
    if isinstance(table, pd.DataFrame):
        return None
    return played_beside(lanes, pathlib.Path(table), intensity)


def _lanes_of(table: Table) -> tuple[pd.DataFrame, str]:
    """A lane table, and what errors name as its source."""
    if isinstance(table, Found):
        return table.table, table.title
    if isinstance(table, pd.DataFrame):
        return table, "table"
    return read_lanes(pathlib.Path(table)), os.fspath(table)


@listing_how
@at_the_door
def ida(
    case: AnyCase,
    engine: str | None = None,
    *,
    from_: float = 0.1,
    to: float = 10.0,
    count: int = 21,
    accuracy: float = 0.01,
    im: str = INTENSITY,
    by: str | Sequence[str] = (),
    folder: str | os.PathLike[str] | None = None,
    **how: Unpack[HowHeld],
) -> Found:
    """Incremental dynamic analysis: the factor on its motion at which each lane first falls.

    All lanes run at a ladder of factors; the bracket of each one's first fall is then halved.

    Args:
        case: The case, as in `run`.
        engine: Name of the engine, as in `run`.
        from_: Least factor on the motion [-].
        to: Greatest factor [-].
        count: Factors of the first stage.
        accuracy: Width of a bracket over its least factor at which it is narrow enough [-].
        im: Intensity measure: this column, or PGA, normalised_acceleration, scale, factor.
        by: Column that makes groups of lanes, or several.
        folder: Where finished stages are kept, so that the same call goes on behind the last one;
            None keeps none.
        **how: overrides, tolerance, precision, device, workers and progress, as in `run`.

    Returns:
        A `Found` whose tables have the capacities of the lanes and of their groups, and every run.

    Raises:
        InputError: Something cannot be used, said before anything runs.

    References:
        D. Vamvatsikos and C. A. Cornell (2002), Incremental dynamic analysis, *Earthquake
        Engineering and Structural Dynamics* 31(3).

    Example:
        >>> import warprock as wr
        >>> shorter = {"motion.scale": 1.0, "run.duration": "20 s"}
        >>> asked = {"from_": 0.2, "to": 2.0, "count": 5, "accuracy": 0.1, "progress": False}
        >>> found = wr.ida("record-ridgecrest", "housner", **asked, overrides=shorter)
        >>> found.table["overturning_factor"].round(3).tolist()
        [1.299]
    """
    ladder = Ladder(from_, to, count, accuracy)
    with python_names():
        ladder.judge()
    with working(case, engine, counted=False, factors=ladder.factors.tolist(), **how) as work:
        place = None if folder is None else pathlib.Path(folder)
        return _ida(work, ladder, measure_named(im, INTENSITIES), several(by), place)


def _ida(
    work: Work, ladder: Ladder, intensity: str, by: Sequence[str], folder: pathlib.Path | None
) -> Found:
    """Plans and runs an incremental dynamic analysis; stages are kept in the folder."""
    options = work.options
    plan = plan_analysis(work.case, work.engine, ladder, options)
    require_columns(work.case, intensity, by)
    found = run_analysis(
        work.case, plan, ladder, folder, workers=options.workers, progress=options.progress
    )
    groups = capacities(found, intensity=intensity, by=by)
    draw = functools.partial(plot_analysis, found=found, groups=groups, intensity=intensity)
    quiet = options.without_progress()
    return Found(
        f"{work.case.name}: incremental dynamic analysis with {work.engine}",
        found,
        functools.partial(analysis_report, found, work.case, groups, intensity),
        functools.partial(draw_analysis, found, groups, intensity),
        (len(groups), draw),
        functools.partial(played_of_analysis, work.case, work.engine, quiet, found),
    )


@listing_how
@at_the_door
def map(
    case: AnyCase,
    engine: str | None = None,
    *,
    tolerance: float = BOUNDARY_TOLERANCE,
    **how: Unpack[How],
) -> Found:
    """How pulses overturn a block: without an impact, with impacts, or not at all.

    Args:
        case: The case, as in `run`, which sweeps motion.frequency and motion.amplitude; further
            axes, each with a label, make panels.
        engine: Name of the engine, as in `run`.
        tolerance: Width of a boundary over its height at which it is narrow enough [-].
        **how: overrides, precision, device, workers and progress, as in `run`.

    Returns:
        A `Found` with the lanes of the grid and the boundaries between modes.

    Raises:
        InputError: Something cannot be used, said before anything runs.

    References:
        J. Zhang and N. Makris (2001), Rocking response of free-standing blocks under cycloidal
        pulses, *Journal of Engineering Mechanics* 127(5).

    Example:
        >>> import warprock as wr
        >>> grid = {"motion.frequency": ["1 Hz"], "motion.amplitude": ["0.01 g", "0.15 g"]}
        >>> grid |= {"motion.waveform": "sine", "motion.cycles": 1}
        >>> found = wr.map("overturning-map", "housner", overrides=grid, progress=False)
        >>> found.tables["boundaries"]["acceleration_ratio"].round(2).tolist()
        [1.23, 2.31, 2.35]
    """
    with working(case, engine, counted=False, **how) as work:
        require_tolerance(tolerance)
        grid = run_grid(work.case, work.engine, work.options)
        found = refine(grid, tolerance, progress=work.options.progress)
    return Found(
        f"{work.case.name}: overturning map with {work.engine}",
        found,
        functools.partial(map_report, found),
        functools.partial(draw_map, found),
        (len(found.groups), functools.partial(plot_map, found=found)),
        functools.partial(scenes_of, found.run),
    )


@listing_how
@at_the_door
def spectrum(
    case: AnyCase,
    engine: str | None = None,
    **how: Unpack[HowHeld],
) -> Found:
    """Rocking spectra: peak rotation / slenderness angle over 2 pi / p, a curve a slenderness.

    Args:
        case: The case, as in `run`, with a `Spectrum`; axes of its sweep, each with a label, make
            panels.
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
        functools.partial(spectrum_report, found),
        functools.partial(draw_spectrum, found),
        (len(found.groups), functools.partial(plot_spectrum, found=found)),
        functools.partial(scenes_of, found.run),
    )


@listing_how
@at_the_door
def sensitivity(
    case: AnyCase,
    engine: str | None = None,
    *,
    of: str = PEAK,
    resamples: int = 200,
    **how: Unpack[HowHeld],
) -> Found:
    """Sobol' indices: which inputs of a case with a sample explain the variance of a result.

    Args:
        case: The case, as in `run`, with a `Sample` of a power of 2 of lanes; with d inputs
            (d + 2) times as many run. Axes of its sweep, each with a label, make panels.
        engine: Name of the engine, as in `run`.
        of: Result of the lane table, or "overturned".
        resamples: Samples for the bands of the indices, from 10 to 10,000.
        **how: overrides, tolerance, precision, device, workers and progress, as in `run`.

    Returns:
        A `Found` whose table has one row a group and input.

    Raises:
        InputError: Something cannot be used, said before anything runs.

    References:
        A. Saltelli et al. (2010), Variance based sensitivity analysis of model output, *Computer
        Physics Communications* 181.

    Example:
        >>> import warprock as wr
        >>> fewer = {"overrides": {"sample.lanes": 16}, "progress": False}
        >>> found = wr.sensitivity("sobol-single-block", "housner", resamples=10, **fewer)
        >>> len(found.table)
        12
    """
    _require_within("resamples", resamples, 10, 10_000)
    with working(case, engine, counted=False, **how) as work:
        found = run_sensitivity(work.case, work.engine, work.options, of=of, resamples=resamples)
    return Found(
        f"{work.case.name}: Sobol' indices of {of} with {work.engine}",
        found,
        functools.partial(sensitivity_report, found),
        functools.partial(draw_sensitivity, found),
        (len(found.groups), functools.partial(plot_sensitivity, found=found)),
    )


def _require_within(argument: str, value: float, least: float, most: float) -> None:
    """Refuses a number that is out of bounds, or none.

    Raises:
        InputError: It is.
    """
    if not least <= value <= most:
        raise InputError(argument, "", value, f"must be from {least} to {most}")
