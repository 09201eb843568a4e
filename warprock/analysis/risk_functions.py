"""Fragility functions to take risks of: of lane tables, of incremental analyses, of components."""

from __future__ import annotations

import dataclasses
import io
import pathlib
from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd

from warprock.analysis.capacities import fit_capacities
from warprock.analysis.exports import COMPONENT_UNITS, intensity_of
from warprock.analysis.fragility import fragility_curves
from warprock.analysis.groups import (
    Weights,
    group_text,
    lane_groups,
    record_numbers,
    record_weights,
)
from warprock.analysis.hazard import Hazard
from warprock.analysis.hazard_files import MOST_BYTES
from warprock.analysis.incremental import Analysis, Verdict
from warprock.analysis.limits import Limit
from warprock.analysis.lognormal import Fit, bands_of, bracket_lanes
from warprock.analysis.lognormal import Verdict as FitVerdict
from warprock.analysis.risk import Function
from warprock.errors import NOTHING, InputError, list_allowed
from warprock.reading import read_bytes, reason
from warprock.units import UNITS

CAPACITIES = "capacities.parquet"
"""Table of the capacities that an incremental analysis found."""
PERIOD = "sa_period_s"
"""Column of the period of a spectral acceleration."""

_COMPONENT_COLUMNS = ("ID", "Demand-Type", "Demand-Unit")
_CAPACITY_COLUMNS = ("standing_factor", "overturning_factor", "verdict")


def is_capacity_table(table: pd.DataFrame) -> bool:
    """Whether a table is that of an incremental analysis, a capacity a lane."""
    return all(name in table for name in _CAPACITY_COLUMNS)


def capacity_table(found: Analysis) -> pd.DataFrame:
    """The capacities that an incremental analysis found, with the inputs of its lanes."""
    inputs = found.lane_set.inputs.reset_index(drop=True)
    return pd.concat([inputs, found.capacities], axis=1)


def read_components(path: pathlib.Path) -> pd.DataFrame:
    """A component table of medians and dispersions.

    Raises:
        InputError: It cannot be read, or is none.
    """
    allowed = "must be a component table, with columns ID, Demand-Type and Demand-Unit"
    try:
        table = pd.read_csv(io.BytesIO(read_bytes(path, MOST_BYTES)))
    except OSError as error:
        raise InputError("TABLE", "", str(path), f"{allowed} ({reason(error)})") from None
    except ValueError as error:
        raise InputError("TABLE", "", str(path), f"{allowed} ({error})") from None
    for name in _COMPONENT_COLUMNS:
        if name not in table:
            raise InputError(str(path), name, NOTHING, allowed)
    return table


def functions_of(
    table: pd.DataFrame,
    hazard: Hazard,
    *,
    source: str,
    limits: Sequence[Limit],
    by: Sequence[str],
    most_doubt: float,
    weights: Weights | None = None,
) -> list[Function]:
    """The fragility functions of a table over the measure of a hazard.

    Args:
        table: A lane table, or the capacities of an incremental analysis.
        hazard: The hazard.
        source: What errors name as the source of the table.
        limits: Limit states; an incremental analysis knows overturning alone.
        by: Columns that make groups of lanes.
        most_doubt: Share of a group's lanes that may be left out or in doubt.
        weights: Weights by record, or the column that has them; None where all weigh the same.

    Raises:
        InputError: The table lacks a column, or cannot be used.
    """
    measure = hazard.measure
    if measure not in table:
        known = [str(name) for name in table.select_dtypes("number").columns]
        allowed = f"must be over a column of {source}: {list_allowed(measure, known)}"
        raise InputError(hazard.source, "", measure, allowed)
    _require_period(table, hazard, source)
    if is_capacity_table(table):
        return functions_of_capacities(table, measure, source, limits, by, weights)
    curves = fragility_curves(
        table,
        source=source,
        intensity=measure,
        limits=limits,
        by=by,
        most_doubt=most_doubt,
        weights=weights,
    )
    return [
        Function(curve.group, curve.limit.name, curve.fit, curve.band, curve.errors, curve.extremes)
        for curve in curves
    ]


def _require_period(table: pd.DataFrame, hazard: Hazard, source: str) -> None:
    """Refuses a spectral acceleration at another period than that of the hazard."""
    if np.isnan(hazard.period):
        return
    periods = table[PERIOD].unique().tolist() if PERIOD in table else []
    if periods != [hazard.period]:
        got = ", ".join(f"{period:g}" for period in periods) or "none"
        allowed = f"must be that of {hazard.source} in every lane, {hazard.period:g} s"
        raise InputError(source, PERIOD, got, allowed)


def functions_of_capacities(
    table: pd.DataFrame,
    measure: str,
    source: str,
    limits: Sequence[Limit],
    by: Sequence[str],
    weights: Weights | None = None,
) -> list[Function]:
    """Functions of the capacities of an incremental analysis.

    Args:
        table: The capacities, a row a lane.
        measure: Column of the intensity measure.
        source: What errors name as the source of the table.
        limits: Limit states; none but overturning is known.
        by: Columns that make groups of lanes.
        weights: Weights by record, or the column that has them; None where all weigh the same.

    Raises:
        InputError: Another limit state, or a column that is missing or cannot be used.
    """
    others = [limit.name for limit in limits if limit.name != "overturning"]
    if others:
        allowed = f"must be overturning: {source} is an incremental analysis"
        raise InputError("--limit", "", others[0], allowed)
    for name in by:
        if name not in table:
            known = list_allowed(name, map(str, table.columns))
            raise InputError("--by", "", name, f"must be a column of {source}: {known}")
    if measure not in table:
        known = list_allowed(measure, map(str, table.select_dtypes("number").columns))
        raise InputError("--im", "", measure, f"must be a column of {source}: {known}")
    unit = table[measure].to_numpy(dtype=np.float64)
    if not np.all(np.isfinite(unit) & (unit > 0.0)):
        lane = int(np.argmin(np.isfinite(unit) & (unit > 0.0)))
        allowed = f"must be above 0 and finite in every lane (row {lane})"
        raise InputError(source, measure, float(unit[lane]), allowed)
    low, high = (
        table[f"{end}_factor"].to_numpy(dtype=np.float64) * unit
        for end in ("standing", "overturning")
    )
    numbered = (table["verdict"] != Verdict.UNKNOWN.value).to_numpy()
    found = []
    for group, lanes in lane_groups(table, by):
        mine = lanes[numbered[lanes]]
        if not len(mine):
            text = group_text(group) or "all lanes"
            raise InputError(source, "verdict", text, "must have a lane whose numbers can be used")
        rows = table.iloc[mine]
        brackets = bracket_lanes(low[mine], high[mine], record_numbers(rows))
        brackets = dataclasses.replace(brackets, weight=record_weights(rows, weights, source))
        fit = fit_capacities(brackets)
        found.append(Function(group, "overturning", fit, *bands_of(brackets, fit)))
    return found


def is_component_table(table: pd.DataFrame) -> bool:
    """Whether a table has functions that are known already."""
    return all(name in table for name in _COMPONENT_COLUMNS)


def functions_of_components(
    table: pd.DataFrame, hazard: Hazard, source: str, limits: Sequence[str]
) -> list[Function]:
    """The lognormal functions of a component table; others of it are left out.

    Args:
        table: The table.
        hazard: The hazard, whose measure must be that of all rows.
        source: What errors name as the source of the table.
        limits: Limit states by name, or by number where they have none: LS1; empty takes all.

    Raises:
        InputError: Another measure, a unit that is not known, or no such limit state.
    """
    found = []
    for number, row in enumerate(table.to_dict("records"), start=1):
        asked = intensity_of(str(row["Demand-Type"]))
        if asked != hazard.measure:
            allowed = f"must be the measure of the hazard, {hazard.measure} (row {number})"
            raise InputError(source, "Demand-Type", row["Demand-Type"], allowed)
        unit = COMPONENT_UNITS.get(str(row["Demand-Unit"]))
        size = next((float(units[unit]) for units in UNITS.values() if unit in units), None)
        if size is None:
            allowed = f"must be one of {', '.join(COMPONENT_UNITS)} (row {number})"
            raise InputError(source, "Demand-Unit", row["Demand-Unit"], allowed)
        states = [key.removesuffix("-Family") for key in map(str, row) if key.endswith("-Family")]
        for state in states:
            name = row.get(f"{state}-Name", state)
            if row[f"{state}-Family"] == "lognormal" and (not limits or name in limits):
                fit = _component_fit(row, state, size, source, number)
                found.append(Function({"component": row["ID"]}, str(name), fit))
    if not found:
        allowed = f"must be a limit state of {source} that has a lognormal function"
        raise InputError("--limit", "", ", ".join(limits), allowed)
    return found


def _component_fit(row: dict[Any, Any], state: str, size: float, source: str, number: int) -> Fit:
    """The function of a limit state of a component."""
    numbers = []
    for name in ("Theta_0", "Theta_1"):
        value = row.get(f"{state}-{name}")
        if not (isinstance(value, (int, float)) and np.isfinite(value) and value > 0.0):
            allowed = f"must be a number above 0 (row {number})"
            raise InputError(source, f"{state}-{name}", value, allowed)
        numbers.append(float(value))
    return Fit(FitVerdict.FITTED, numbers[0] * size, numbers[1])
