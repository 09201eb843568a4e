"""Tables on the terminal for ensembles: a row a cell and block, distributions instead of lanes."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from typing import Any

from rich.console import Console

from warprock.case.case import Case
from warprock.findings.digits import cell_of, number_of, quantity_of
from warprock.findings.numbers import MISSING
from warprock.model.undecided import cut_text
from warprock.model.words import lane_count_text
from warprock.running.case_run import CaseRun
from warprock.running.cells import QUANTILES, cell_table
from warprock.running.lane_table import PEAK_RATIO
from warprock.settings.engines import has_time_step
from warprock.tables.swept import SweptAxis, swept_axes
from warprock.tables.terminal import plain_table, print_table, stdout
from warprock.units import Dimension

OVERTURNED = "overturned"
"""How a quantile among overturned lanes is printed."""


def cell_names(case: Case) -> list[str]:
    """What sets every cell of a case apart, in words; the case's name where there is only one."""
    axes = swept_axes(case)
    names = [[value_name(axis, at) for at in range(axis.length)] for axis in axes]
    return [", ".join(parts) for parts in itertools.product(*names)] if axes else [case.name]


def value_name(axis: SweptAxis, position: int) -> str:
    """What sets one value of an axis apart, its numbers bare where their units tell them apart."""
    measured = [column.dimension for column in axis.numbers.values()]
    told = len(set(measured)) == len(measured) and Dimension.DIMENSIONLESS not in measured
    return axis.name(position, bare=told)


def block_suffixes(block_count: int, *, stacked: bool) -> dict[str, str]:
    """Number of every block, empty for a single one, and the suffix of its columns."""
    return {str(k): f"_{k}" for k in range(1, block_count + 1)} if stacked else {"": ""}


def print_cells(run: CaseRun, console: Console | None = None) -> None:
    """Prints a run of an ensemble: the distribution of each cell.

    Args:
        run: The run.
        console: Where to; the terminal if not given.
    """
    out = console or stdout()
    case, lanes = run.case, run.lane_set.lanes
    assert case.ensemble is not None
    table = plain_table(
        f"{case.name}: {run.response.engine}, {len(cell_names(case))} cells of "
        f"{case.members} members, peak rotation / slenderness angle",
        ["cell", "block", *(_heading(share) for share in QUANTILES.values()), "overturned*"],
        ("cell", "block"),
    )
    rows = cell_table(run.lane_set, run.response).to_dict("records")
    blocks = block_suffixes(lanes.block_count, stacked=lanes.stacked)
    for name, row in zip(cell_names(case), rows, strict=True):
        for index, (block, suffix) in enumerate(blocks.items()):
            quantiles = (row[f"{PEAK_RATIO}_{q}{suffix}"] for q in QUANTILES)
            share = _share_text(row) if index == 0 else ""
            table.add_row(name if index == 0 else "", block, *map(_ratio_text, quantiles), share)
    print_table(out, table)
    out.print("  * share of the members, 95 % interval; a quantile among these is overturned")
    unusable = sum(round(row["members"] * (1.0 - row["usable"])) for row in rows)
    if unusable:
        out.print(f"left out: {unusable} of {lane_count_text(run.response.lane_count)}, not usable")
    if case.ensemble.time_step and not has_time_step(run.settings):
        out.print(
            f"time step: {run.response.engine} has none, so ensemble.time_step changes nothing"
        )
    cut = cut_text(run.lane_set.motions, run.lane_set.ends)
    if cut:
        out.print(cut, highlight=False)
    out.print(f"wall time: {quantity_of('wall_time_s', run.wall_time)}")


def print_cell_comparison(
    case: Case, found: Mapping[str, Any], console: Console | None = None
) -> None:
    """Prints a comparison of ensembles: a row a cell, block and engine.

    Args:
        case: The case.
        found: What `verification.checks.compare` returned.
        console: Where to; the terminal if not given.
    """
    out = console or stdout()
    first = found["engines"][0]
    headings = ["cell", "block", "engine", "median", f"median\n{first}"]
    headings += ["overturned", f"overturned\n{first}", "statistic*", "p value", "meaning"]
    title = f"{found['case']}: distributions of the peak rotation ratio against {first}"
    table = plain_table(title, headings, ("cell", "block", "engine", "meaning"))
    names, last = cell_names(case), None
    for row in found["rows"]:
        for block, suffix in block_suffixes(found["blocks"], stacked=found["stacked"]).items():
            table.add_row(
                "" if last == row["cell"] else names[row["cell"]],
                block,
                row["engine_b"],
                *(_ratio_text(row[f"median_{side}{suffix}"]) for side in "ba"),
                *(cell_of("overturned", row[f"overturned_{side}"]) for side in "ba"),
                *(number_of(name, row[f"{name}{suffix}"]) for name in ("statistic", "p_value")),
                row[f"meaning{suffix}"],
            )
            last = row["cell"]
    print_table(out, table)
    out.print(
        "  * largest difference of the two cumulative distributions (Kolmogorov-Smirnov), lanes "
        "that overturned above all others"
    )
    shares = {
        (row["cell"], row[f"engine_{side}"]): row[f"usable_{side}"]
        for row, side in itertools.product(found["rows"], "ab")
    }
    for engine in dict.fromkeys(found["engines"]):
        own = [share for (_, name), share in shares.items() if name == engine]
        unusable = round(sum(found["members"] * (1.0 - share) for share in own))
        if unusable:
            out.print(f"left out: {lane_count_text(unusable)} of {engine}, not usable")


def _heading(share: float) -> str:
    return "median" if share == 0.5 else f"{share:.0%}"


def _share_text(row: Mapping[Any, Any]) -> str:
    if math.isnan(row["overturned"]):
        return MISSING
    share, low, high = (
        cell_of("overturned", row[f"overturned{end}"]) for end in ("", "_low", "_high")
    )
    return f"{share} ({low} to {high})"


def _ratio_text(value: float | str | None) -> str:
    if isinstance(value, str):
        return value
    if value is not None and math.isinf(value):
        return OVERTURNED
    return number_of(PEAK_RATIO, value)
