"""Fragility functions: on the terminal, as JSON and as CSV files."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
from rich.console import Console

from warprock.analysis.fragility import RULE, Curve, component_rows, curve_rows, warnings
from warprock.model.undecided import UNDECIDED
from warprock.model.words import lane_count_text
from warprock.tables.report import Report
from warprock.tables.terminal import heading_text, number, plain_table, print_table, stdout

CURVES = "fragility.csv"
COMPONENTS = "fragility-p58.csv"


def fragility_report(
    lanes: pd.DataFrame, curves: Sequence[Curve], source: str, intensity: str
) -> Report:
    """What fragility functions have to show.

    Their files are the fits, and the same as a component table after FEMA P-58.

    Args:
        lanes: The lane table that they were fitted to.
        curves: The curves.
        source: Name of the table.
        intensity: Column of the intensity measure.
    """
    rows, said = curve_rows(curves), warnings(lanes, curves)

    def show() -> None:
        print_curves(rows, intensity, said)
        print_undecided(lanes)

    return Report(
        json={
            "table": source,
            "intensity": intensity,
            "undecided": undecided_lanes(lanes),
            "rule": RULE,
            "warnings": said,
            "curves": rows.to_dict("records"),
        },
        tables={CURVES: rows, COMPONENTS: component_rows(curves, intensity)},
        facts=None,
        show=show,
        came_out=fit_sentence(rows, intensity, str(rows["limit_state"].iloc[-1])),
        beside=True,
    )


def print_curves(
    rows: pd.DataFrame,
    intensity: str,
    said: Sequence[str] = (),
    console: Console | None = None,
) -> None:
    """Prints the fits.

    Args:
        rows: What `curve_rows` returned.
        intensity: Column of the intensity measure.
        said: What `warnings` returned.
        console: Where to; the terminal if not given.
    """
    out = console or stdout()
    groups = [str(name) for name in rows.columns[: list(rows.columns).index("limit_state")]]
    found = rows.drop_duplicates(groups) if groups else rows.head(1)
    if len(found) > GROUPS_SHOWN:
        _print_groups(out, rows, intensity, len(found))
    else:
        _print_fits(out, rows, intensity, groups)
    left_out = found[found["left_out"] > 0]
    for _, row in left_out.head(GROUPS_SHOWN).iterrows():
        where = "".join(f" of {name} {row[name]}" for name in groups)
        out.print(
            f"  left out: {lane_count_text(row['left_out'])}{where} whose numbers cannot be used "
            f"({row['left_out_as']})"
        )
    if len(left_out) > GROUPS_SHOWN:
        out.print(f"  left out in {len(left_out) - GROUPS_SHOWN:,} more groups, too")
    if rows["in_doubt"].any():
        out.print(
            "  in doubt: counted by their finest run; bands reach around those in which all of "
            "them reached the limit state, or none",
            soft_wrap=True,
        )
    for text in said:
        out.print(f"  note: {text}", soft_wrap=True)


def _print_fits(out: Console, rows: pd.DataFrame, intensity: str, groups: Sequence[str]) -> None:
    """Every fit, a group and limit state a row."""
    counts = ["lanes", "in_doubt", "records", "reached"]
    named = ["limit state", "lanes", "in\ndoubt", "records", "reached", "median", "dispersion"]
    headings = [*groups, *named]
    table = plain_table(f"Fragility over {intensity}", headings, headings[len(groups) + 1 :])
    for _, row in rows.iterrows():
        table.add_row(
            *(str(row[name]) for name in groups),
            row["limit_state"],
            *(f"{row[name]:,}" for name in counts),
            *fit_cells(row),
        )
    print_table(out, table)
    out.print("  in brackets: 5th and 95th percentile over records")


GROUPS_SHOWN = 8
"""Groups that are printed one by one; of more, what they come to."""


def _print_groups(out: Console, rows: pd.DataFrame, intensity: str, groups: int) -> None:
    """What the fits of many groups come to, a limit state a row."""
    headings = ["limit state", "groups\nfitted", "least\nmedian", "middle", "greatest"]
    headings += ["data\nparted", "none\nreached", "all\nreached", "lanes\nin doubt"]
    title = f"Fragility over {intensity}: {groups:,} groups"
    table = plain_table(title, headings, headings[:1])
    for limit, mine in rows.groupby("limit_state", sort=False):
        medians = mine[mine["verdict"] == "fitted"]["median"]
        verdicts = ("separated", "none reached", "all reached")
        table.add_row(
            str(limit),
            f"{len(medians):,}",
            *(number(value, ".4g") for value in medians.quantile([0.0, 0.5, 1.0])),
            *(f"{(mine['verdict'] == verdict).sum():,}" for verdict in verdicts),
            f"{mine['in_doubt'].sum():,}",
        )
    print_table(out, table)
    out.print(f"  all {len(rows):,} fits, group by group: --json, or -o DIR", highlight=False)


def undecided_lanes(table: pd.DataFrame) -> int:
    """Lanes of a lane table that had neither fallen nor come to stand when their run ended.

    0 for a table that does not say so, such as one of an earlier version.
    """
    return int(table[UNDECIDED].sum()) if UNDECIDED in table else 0


def print_undecided(table: pd.DataFrame, console: Console | None = None) -> None:
    """Says how many lanes of a table are undecided, if any are.

    Args:
        table: The lane table.
        console: Where to; the terminal if not given.
    """
    count = undecided_lanes(table)
    if count:
        out = console or stdout()
        out.print(
            f"  undecided: {count:,} of {lane_count_text(len(table))} had not fallen when their "
            "run ended, but still moved or were still shaken; they count as standing, with the "
            "peaks so far",
            highlight=False,
        )


def fit_sentence(rows: pd.DataFrame, intensity: str, reached: str) -> str:
    """The last fit among some rows in one sentence, or why there is none.

    Args:
        rows: What `curve_rows` or `analysis.capacities.capacity_rows` returned.
        intensity: Column of the intensity measure.
        reached: What the lanes reach: the limit state.
    """
    row = rows.iloc[-1]
    name = heading_text(intensity)
    mine = rows[rows["limit_state"] == row["limit_state"]] if "limit_state" in rows else rows
    if len(mine) > 1:
        medians = mine[mine["verdict"] == "fitted"]["median"]
        if medians.empty:
            return f"In none of {len(mine):,} groups a function of {reached} was fitted."
        span = f"{medians.min():.3g} to {medians.max():.3g} {name}"
        return (
            f"Half of the lanes reach {reached} at {span}, in the {len(medians):,} of "
            f"{len(mine):,} groups with a function."
        )
    if row["verdict"] != "fitted":
        median, why = fit_cells(row)
        return (
            f"No function of {reached} was fitted ({why.removeprefix('none: ')}; {median} {name})."
        )
    return (
        f"Half of the lanes reach {reached} at {row['median']:.3g} {name}, with a dispersion of "
        f"{row['dispersion']:.3g}."
    )


def fit_cells(row: pd.Series[Any]) -> tuple[str, str]:
    """Median and dispersion of a row, or why there are none."""
    if row["verdict"] == "fitted":
        cells = [
            f"{row[name]:.4g}{_band(row[f'{name}_p05'], row[f'{name}_p95'])}"
            for name in ("median", "dispersion")
        ]
        return cells[0], cells[1]
    if row["verdict"] == "separated":
        return f"between {row['none_up_to']:.4g} and {row['all_from']:.4g}", "none: data are parted"
    if row["verdict"] == "none reached":
        return f"above {row['none_up_to']:.4g}", "none: nothing reached it"
    if row["verdict"] == "all reached":
        return f"below {row['all_from']:.4g}", "none: everything reached it"
    return "none", "none: fewer reach it at a greater intensity"


def _band(low: float, high: float) -> str:
    return f" [{low:.4g}, {high:.4g}]" if np.isfinite(low) else ""
