"""What measures do to a yearly rate."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd

from warprock.analysis.incremental import Ladder
from warprock.analysis.measures import Measures
from warprock.findings.digits import number_of, quantity_of, value_of
from warprock.findings.finding import Facts, Finding, Kind, Tables
from warprock.findings.intensities import measure
from warprock.findings.numbers import counted, three
from warprock.findings.risk import once_in
from warprock.findings.sheets import Heading, Sheet
from warprock.running.provenance import case_facts, surroundings
from warprock.running.run_file import CASE

TABLE = "measures"
_NUMBER = (float, None)


def find_measures(found: Measures, ladder: Ladder) -> Finding:
    """What measures do to a yearly rate."""
    facts: dict[str, Any] = {
        "case": case_facts(found.case),
        "engine": found.engine,
        "measures": rate_facts(found, ladder),
        **surroundings(found.case),
    }
    return tell_measures(facts, {TABLE: effect_rows(found)})


def rate_facts(found: Measures, ladder: Ladder) -> dict[str, Any]:
    """The rate of a block as it is, and what it takes to meet a target, as numbers."""
    base, target = found.base, found.target
    facts: dict[str, Any] = {
        "rate_per_year": base.rate,
        "rate_p05_per_year": known(base.band[0]),
        "rate_p95_per_year": known(base.band[1]),
        "intensity": base.hazard.measure,
        "hazard": base.hazard.source,
        "lowest_factor": ladder.lowest,
        "highest_factor": ladder.highest,
        "median": base.function.fit.median,
    }
    if target is not None:
        facts |= {
            "target_per_year": target.rate,
            "width_m": target.own,
            "width_low_m": known(target.width.low),
            "width_high_m": known(target.width.high),
            "tie_low_share": known(target.tie.low),
            "tie_high_share": known(target.tie.high),
            "tie_why": target.tie.why,
        }
    return facts


def effect_rows(found: Measures) -> pd.DataFrame:
    """One row a measure, the one that lowers the rate most first."""
    rows = [
        {
            "measure": each.measure.name,
            "changes": "; ".join(f"{key}={value}" for key, value in each.measure.changes.items()),
            "factor": each.factor,
            "factor_p05": each.band[0],
            "factor_p95": each.band[1],
            "rate_per_year": np.nan if each.risk is None else each.risk.rate,
            "rate_p05_per_year": np.nan if each.risk is None else each.risk.band[0],
            "rate_p95_per_year": np.nan if each.risk is None else each.risk.band[1],
            "median": np.nan if each.risk is None else each.risk.function.fit.median,
            "dispersion": np.nan if each.risk is None else each.risk.function.fit.dispersion,
            "why": each.why,
        }
        for each in found.effects
    ]
    return pd.DataFrame(rows)


def known(value: float) -> float | None:
    """A number as a fact: None where there is none."""
    return float(value) if np.isfinite(value) else None


def tell_measures(facts: Facts, tables: Tables) -> Finding:
    """What measures do to a yearly rate, of their facts and table."""
    rows, base = tables[TABLE], facts["measures"]
    measured = measure(base["intensity"])
    return Finding(
        kind="Measures",
        facts=facts,
        tables=tables,
        sentences=[
            best_measure(rows, base),
            _as_it_is(base),
            *_rest(rows),
            *target_sentences(base),
        ],
        sheets=[effect_sheet(rows)],
        rows={"rows": TABLE},
        said={**base, "engine": facts["engine"]},
        asked=[
            ("Hazard", base["hazard"]),
            ("Intensity measure", measured.name),
            ("Factors", f"{factor_range(base)} on each motion"),
        ],
        pictures=["measures*.png"],
    )


RATE_SHAPE = {
    **dict.fromkeys(("rate_per_year", "median", "lowest_factor", "highest_factor"), float),
    **dict.fromkeys(("rate_p05_per_year", "rate_p95_per_year"), _NUMBER),
    **dict.fromkeys(("intensity", "hazard"), str),
    **dict.fromkeys(("target_per_year?", "width_m?"), float),
    **dict.fromkeys(("width_low_m?", "width_high_m?"), _NUMBER),
    **dict.fromkeys(("tie_low_share?", "tie_high_share?"), _NUMBER),
    "tie_why?": str,
}
"""What `rate_facts` hold."""
MEASURES = Kind(
    (TABLE,),
    tell_measures,
    "measures",
    {"case": CASE, "engine": str, "measures": RATE_SHAPE},
)


def _band(low: float, high: float) -> str:
    return f" (5 to 95 %: {three(low)} to {three(high)})" if np.isfinite(low) else ""


def best_measure(rows: pd.DataFrame, base: Facts) -> str:
    """The measure that lowers the rate most."""
    never = rows[rows["why"].astype(str).str.startswith("no lane falls")]
    if len(never):
        name = never["measure"].iloc[0]
        return f"Most is done by: {name}, with which {never['why'].iloc[0]}."
    known = rows[rows["factor"] < 1.0]
    if known.empty:
        return "None of the measures that were tried lowers the rate."
    row = known.sort_values("factor").iloc[0]
    return (
        f"Most is done by: {row['measure']}, which brings the rate to {three(row['factor'])} of "
        f"what it is{_band(row['factor_p05'], row['factor_p95'])}, from "
        f"{once_in(1.0 / base['rate_per_year'])} to {once_in(1.0 / row['rate_per_year'])}."
    )


def _as_it_is(base: Facts) -> str:
    low, high = base["rate_p05_per_year"], base["rate_p95_per_year"]
    band = "" if low is None or high is None else _band(low, high)
    return f"As it is, the block falls {three(base['rate_per_year'])} times a year{band}."


def _rest(rows: pd.DataFrame) -> list[str]:
    """Measures that do harm, and those that could not be judged."""
    found = []
    worse = rows[rows["factor"] > 1.0]
    if len(worse):
        names = ", ".join(f"{row['measure']} ({three(row['factor'])} times)"
                          for _, row in worse.iterrows())  # fmt: skip
        found.append(f"Higher than it is becomes the rate by: {names}.")
    out = rows[rows["factor"].isna() & ~rows["why"].astype(str).str.startswith("no lane falls")]
    if len(out):
        found.append(f"{counted(len(out), 'measure')} could not be judged; the table says why.")
    return found


def factor_range(base: Facts) -> str:
    """The factors on a motion between which it was looked."""
    ends = (f"{end}_factor" for end in ("lowest", "highest"))
    return " to ".join(value_of(base, name) for name in ends)


def target_sentences(base: Facts) -> list[str]:
    """The width and the straps that meet a rate."""
    if "target_per_year" not in base:
        return []
    own, low, high = (base[name] for name in ("width_m", "width_low_m", "width_high_m"))
    rate = once_in(1.0 / base["target_per_year"])
    if low is None:
        return [f"As wide as it is, and without straps, it falls no more often than {rate}."]
    found = (
        f"No width up to {three(low)} m brings its falls to {rate}."
        if high is None
        else f"A width between {quantity_of('width_m', low)} and {quantity_of('width_m', high)}, "
        f"{number_of('width_ratio', high / own)} times its own, "
        f"brings its falls to {rate}."
    )
    return [found, _straps(base)]


def _straps(base: Facts) -> str:
    """The straps that meet a rate."""
    if "tie_why" not in base:
        return "What straps would do was not looked for."
    if base["tie_why"]:
        return f"Which straps do so is not known: {base['tie_why']}."
    low, high = base["tie_low_share"], base["tie_high_share"]
    if high is None:
        return f"No straps that yield at up to {three(low)} of its weight do so."
    top = number_of("tie_high_share", high)
    ends = f"at {top}" if low == 0.0 else f"between {number_of('tie_low_share', low)} and {top}"
    return f"Two straps near its top that yield {ends} of its weight do so, too."


def effect_sheet(rows: pd.DataFrame) -> Sheet:
    """Every measure, the one that lowers the rate most first."""
    cells = [
        [
            str(row["measure"]),
            three(row["factor"]),
            f"{three(row['factor_p05'])} to {three(row['factor_p95'])}"
            if np.isfinite(row["factor_p05"])
            else "-",
            three(row["rate_per_year"]),
            number_of("return_period_years", 1.0 / row["rate_per_year"])
            if row["rate_per_year"] > 0
            else "-",
            "" if pd.isna(row["why"]) else str(row["why"]),
        ]
        for _, row in rows.iterrows()
    ]
    heads = [
        Heading("measure"),
        Heading("factor on the rate"),
        Heading("5 to 95 % over records"),
        Heading("rate", "1/year"),
        Heading("return period", "years"),
        Heading("note"),
    ]
    return Sheet("Measures", heads, cells, "A factor below 1 lowers the rate.")
