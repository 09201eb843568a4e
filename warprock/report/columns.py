"""Tables as a page reads them: which columns each file has, declared here and held to."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from warprock.errors import InputError, Said
from warprock.model.response import USABLE_NAMES, Outcome, Status
from warprock.running.lane_table import LANE_TABLE, PEAK_RATIO
from warprock.running.results import CELL_TABLE
from warprock.units import ENDINGS

if TYPE_CHECKING:
    import pandas as pd

TEXT, NUMBER, FLAG = "text", "numbers", "true or false"
LANE = "*"
"""Stands for the columns that every table of lanes has."""

_WORDS = {"outcome": Outcome, "status": Status}
_MEASURED = (*ENDINGS.values(), "_ratio")
"""Ends of names of columns that hold numbers."""

_FITS = {
    **dict.fromkeys(("lanes", "median", "median_p05", "median_p95"), NUMBER),
    **dict.fromkeys(("dispersion", "all_from", "none_up_to"), NUMBER),
    "verdict": TEXT,
}
_RATES = dict.fromkeys(
    ("rate_per_year", "rate_p05_per_year", "rate_p95_per_year", "return_period_years", "median"),
    NUMBER,
)
_RATES |= dict.fromkeys(("rate_fit_p05_per_year", "rate_fit_p95_per_year"), NUMBER)
_RATES |= dict.fromkeys(
    ("share_below", "share_beyond", "intensity_p05", "intensity_p50", "intensity_p95"), NUMBER
)
_TOLD = dict.fromkeys(("limit_state", "intensity", "hazard", "verdict"), TEXT)
COLUMNS: Mapping[str, Mapping[str, str]] = {
    LANE_TABLE: {LANE: LANE},
    "grid.parquet": {LANE: LANE, "frequency_ratio": NUMBER, "mode": TEXT},
    "spectrum.parquet": {LANE: LANE, PEAK_RATIO: NUMBER, "period_s": NUMBER},
    "boundaries.parquet": {
        "group": TEXT,
        "above": TEXT,
        **dict.fromkeys(("acceleration_ratio", "frequency_ratio", "frequency_hz"), NUMBER),
    },
    "sensitivity.parquet": {
        **dict.fromkeys(("group", "input"), TEXT),
        **dict.fromkeys(("total", "first_order"), NUMBER),
    },
    "study.parquet": {
        **dict.fromkeys(("engine", "setting", "unit"), TEXT),
        **dict.fromkeys(("error_run_ratio", "value", "cpu_s"), NUMBER),
        "baseline": FLAG,
    },
    "comparison.parquet": {"engine": TEXT},
    "capacities.parquet": {
        **dict.fromkeys(("lane", "resurrections", "runs"), NUMBER),
        "verdict": TEXT,
    },
    "trade.parquet": {
        **dict.fromkeys(("scene", "engine"), TEXT),
        **dict.fromkeys(("ok_share", "error_max", "cpu_s_per_simulated_s"), NUMBER),
    },
    "capacity.parquet": {
        "side": TEXT,
        **dict.fromkeys(("lane", "multiplier", "multiplier_peak", "velocity_step_m_s"), NUMBER),
    },
    "swings.parquet": dict.fromkeys(("swing", "peak_rotation_rad", "duration_s"), NUMBER),
    "fragility-p58.csv": {"Demand-Type": TEXT},
    "fragility.csv": _FITS,
    "fragility.parquet": _FITS,
    "risk.csv": {**_RATES, **_TOLD},
    "risk-chances.csv": {"limit_state": TEXT, "within_years": NUMBER, "chance": NUMBER},
}
_BESIDES: Mapping[str, Mapping[str, str]] = {
    "fragility.csv": {"limit_state": TEXT, "in_doubt": NUMBER},
    CELL_TABLE: dict.fromkeys(("overturned", "overturned_low", "overturned_high"), NUMBER),
}
"""Columns that one of several has besides; those of cells, where one is there, all are."""
_MAY_BE_EMPTY = ("boundaries.parquet", "fragility-p58.csv")


def require_columns(table: pd.DataFrame, name: str, source: str) -> None:
    """Refuses a table that lacks columns of its kind, or holds something else in them.

    Args:
        table: The table.
        name: Name of its file.
        source: Its path, as errors say.

    Raises:
        InputError: It is not as a command writes it.
    """
    columns = dict(COLUMNS.get(name, {}))
    if name != CELL_TABLE or "overturned" in table:
        columns |= _BESIDES.get(name, {})
    if columns and table.empty and name not in _MAY_BE_EMPTY:
        raise InputError(source, "", Said("0 rows"), "must have at least one")
    if columns.pop(LANE, None):
        _require_lanes(table, source)
    for column, kind in columns.items():
        _require_column(table, column, kind, source)


def _require_lanes(table: pd.DataFrame, source: str) -> None:
    """Refuses what is no table of lanes."""
    thrown = ("peak_slide_m", "rest_time_s") if "attitude_w_start" in table else ()
    measured = [name for name in map(str, table) if name.endswith(_MEASURED)]
    ratios = [name for name in map(str, table) if name.startswith(PEAK_RATIO)]
    besides = [name for name in ("impact_count", "friction_needed") if name in table]
    for name in ("lane", *thrown, *(ratios or [PEAK_RATIO]), *measured, *besides):
        _require_column(table, name, NUMBER, source)
    for name, words in _WORDS.items():
        _require_column(table, name, TEXT, source)
        known = [code.name.lower() for code in words]
        _require(table, name, table[name].isin(known), f"must be one of {', '.join(known)}", source)
    lane = table["lane"].to_numpy(dtype=float)
    whole = np.isfinite(lane) & (np.abs(lane) < 1e15)
    _require(table, "lane", whole, "must be the number of a lane", source)
    usable = table["status"].isin(USABLE_NAMES).to_numpy()
    for name in ratios:
        good = ~usable | (table[name].to_numpy(dtype=float) >= 0.0)
        allowed = "must be a number from 0 up where the status says that it may be used"
        _require(table, name, good, allowed, source)


def _require_column(table: pd.DataFrame, name: str, kind: str, source: str) -> None:
    if name not in table:
        raise InputError(source, name, Said("nothing"), "must be a column: warprock writes it")
    values = table[name]
    if values.ndim > 1:
        raise InputError(source, name, Said("the column again"), "must be there once")
    import pandas as pd

    if kind == TEXT:
        good = np.array([isinstance(each, str) or each != each for each in values], dtype=bool)
    elif kind == FLAG:
        good = np.full(len(values), pd.api.types.is_bool_dtype(values.dtype))
    else:
        good = np.full(len(values), pd.api.types.is_numeric_dtype(values.dtype))
    _require(table, name, good, f"must hold {kind}", source)


def _require(table: pd.DataFrame, name: str, good: object, allowed: str, source: str) -> None:
    """Refuses the first row of a column that is not good."""
    held = np.asarray(good, dtype=bool)
    if not held.all():
        row = int(np.argmin(held))
        raise InputError(source, name, table[name].iloc[row], f"{allowed} (row {row})")
