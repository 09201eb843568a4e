"""Lognormal functions that were fitted to lanes: in a sentence, and as cells of a table."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd

from warprock.findings.digits import number_of, value_of
from warprock.findings.intensities import Measure, measure
from warprock.findings.numbers import three

FITTED = "fitted"
LIMIT = "limit_state"
MOST_FITS = 4
"""Fits that are told in sentences."""


WHY_NONE = {
    "separated": "the data are separated",
    "none reached": "no lane reached it",
    "all reached": "every lane reached it",
    "falling": "fewer lanes reach it at a greater intensity",
}
"""Why there is no function, in words."""


def fit_sentences(rows: pd.DataFrame, groups: Sequence[str], intensity: str) -> list[str]:
    """The first fits, a sentence each, and how many more there are.

    Args:
        rows: What `analysis.fragility.curve_rows` or `analysis.capacities.capacity_rows` returned.
        groups: Columns that tell groups apart.
        intensity: Column of the intensity measure.
    """
    measured = measure(intensity)
    found = [_fit_text(row, groups, measured) for _, row in rows.head(MOST_FITS).iterrows()]
    if len(rows) > MOST_FITS:
        found.append(f"{len(rows) - MOST_FITS:,} more functions are in the table.")
    return found


def worst_limit(rows: pd.DataFrame) -> pd.DataFrame:
    """The rows of overturning, or of the last limit state where that is none of them."""
    if LIMIT not in rows:
        return rows
    limits = rows[LIMIT].astype(str)
    return rows[limits == ("overturning" if "overturning" in set(limits) else limits.iloc[-1])]


def fits_headline(rows: pd.DataFrame, groups: Sequence[str], intensity: str) -> str:
    """Where half of the lanes reach the worst limit state, over all groups.

    Args:
        rows: As for `fit_sentences`.
        groups: Columns that tell groups apart.
        intensity: Column of the intensity measure.
    """
    measured, mine = measure(intensity), worst_limit(rows)
    if len(mine) == 1:
        row = mine.iloc[0]
        at = f"{_reached(row)} at a {measured.name} of {measured.text(row['median'])}"
        fitted_alone = row["verdict"] == FITTED
        return f"Half of the lanes reach {at}." if fitted_alone else _fit_text(row, [], measured)
    what, fitted = _reached(mine.iloc[0]), mine[mine["verdict"] == FITTED].sort_values("median")
    if fitted.empty:
        reasons = sorted({WHY_NONE.get(verdict, "fewer reach it at a greater intensity")
                          for verdict in mine["verdict"]})  # fmt: skip
        none = f"In none of {len(mine):,} groups a function of {what} could be fitted"
        return f"{none}: {' or '.join(reasons)}."
    ends = [f"{measured.text(row['median'])} ({_group(row, groups)})"
            for row in (fitted.iloc[0], fitted.iloc[-1])]  # fmt: skip
    return (
        f"Half of the lanes reach {what} at a {measured.name} of {' to '.join(dict.fromkeys(ends))}"
        f", in the {len(fitted):,} of {len(mine):,} groups with a function."
    )


def _group(row: pd.Series[Any], groups: Sequence[str]) -> str:
    return ", ".join(f"{name.replace('_', ' ')} {row[name]}" for name in groups)


def _reached(row: pd.Series[Any]) -> str:
    limit = str(row.get(LIMIT, "overturning"))
    return limit if limit in ("uplift", "overturning") else f"a limit of {limit}"


def _fit_text(row: pd.Series[Any], groups: Sequence[str], measured: Measure) -> str:
    """One fit in a sentence, or what is known where there is none."""
    group, what = _group(row, groups), _reached(row)
    lead, name = f"{group}: " if group else "", f"a {measured.name} of"
    low, high = measured.text(row["none_up_to"]), measured.text(row["all_from"])
    if row["verdict"] == FITTED:
        band = ""
        if np.isfinite(row["median_p05"]):
            ends = (measured.text(row[f"median_{end}"]) for end in ("p05", "p95"))
            band = f" (5 to 95 %: {' to '.join(ends)})"
        text = f"half of the lanes reach {what} at {name} {measured.text(row['median'])}{band}"
        text += f", with a dispersion of {three(row['dispersion'])}"
    elif row["verdict"] == "separated" and row["none_up_to"] == row["all_from"]:
        text = f"at {name} {low} some lanes reach {what} and some do not: a function needs lanes"
        text += " at more intensities"
    else:
        known = {
            "separated": f"every lane reaches {what} from {name} {high} up and none up to {low}",
            "none reached": f"no lane reaches {what} up to {name} {low}",
            "all reached": f"every lane reaches {what} from {name} {high} on",
        }
        none = f"no function of {what} could be fitted: fewer reach it at a greater intensity"
        text = known.get(row["verdict"], none)
    text = lead + text
    return f"{text[0].upper()}{text[1:]}."


def fit_cells(row: pd.Series[Any]) -> list[str]:
    """Median and dispersion of a row, or why there are none."""
    low_text, high_text = (value_of(row, name) for name in ("none_up_to", "all_from"))
    if row["verdict"] == "separated" and row["none_up_to"] == row["all_from"]:
        return [f"about {low_text}", "none: too few intensities"]
    known = {
        "separated": [f"between {low_text} and {high_text}", "none: data are separated"],
        "none reached": [f"above {low_text}", "none: nothing reached it"],
        "all reached": [f"below {high_text}", "none: everything reached it"],
    }
    if row["verdict"] != FITTED:
        return known.get(row["verdict"], ["none", "none: fewer reach it at a greater intensity"])
    return [f"{value_of(row, name)}{_band(row, name)}" for name in ("median", "dispersion")]


def _band(row: pd.Series[Any], name: str) -> str:
    low, high = row[f"{name}_p05"], row[f"{name}_p95"]
    return f" [{number_of(name, low)}, {number_of(name, high)}]" if np.isfinite(low) else ""
