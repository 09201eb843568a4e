"""What yearly rates came to."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd

from warprock.analysis.hazard import Hazard
from warprock.analysis.risk import (
    Risk,
    allowed_hazard,
    allowed_rate,
    chance_within,
    contribution_edges,
)
from warprock.findings.digits import number_of, quantity_of, value_of
from warprock.findings.finding import Facts, Finding, Kind, Tables
from warprock.findings.fits import FITTED, LIMIT, MOST_FITS, WHY_NONE, worst_limit
from warprock.findings.intensities import measure
from warprock.findings.numbers import three
from warprock.findings.sheets import Heading, Sheet, sheet_of

RISK = "risk.csv"
CHANCES = "risk-chances.csv"
PARTS = "risk-contributions.csv"
HAZARD = "risk-hazard.csv"
ALLOWED = "risk-allowed.csv"
"""Rates of exceedance that an object which still stands allows."""


def find_risk(
    risks: Sequence[Risk], years: Sequence[float], age: float | None, unlikely: float
) -> Finding:
    """What yearly rates came to.

    Args:
        risks: The rates, one or more.
        years: Spans within which chances are told [years].
        age: How long the objects have stood [years]; None where that is not asked.
        unlikely: Chance of having stood below which a hazard is ruled out.
    """
    tables = {
        RISK: pd.DataFrame([_row(risk, age, unlikely) for risk in risks]),
        CHANCES: _chance_rows(risks, years),
        PARTS: _part_rows(risks),
        HAZARD: _hazard_rows(risks),
    }
    if age is not None:
        tables[ALLOWED] = _allowed_rows(risks, age, unlikely)
    return tell_risk({}, tables)


def _named(risk: Risk) -> dict[str, object]:
    return {**risk.function.name, LIMIT: risk.function.limit}


def _row(risk: Risk, age: float | None, unlikely: float) -> dict[str, object]:
    """One function: its rate, what it is made of, and what its age says."""
    fit, rate = risk.function.fit, risk.rate
    known = rate > 0.0
    row = {
        **_named(risk),
        "intensity": risk.hazard.measure,
        "hazard": risk.hazard.source,
        "verdict": fit.verdict.value,
        "median": fit.median,
        "dispersion": fit.dispersion,
        "rate_per_year": rate,
        "rate_p05_per_year": risk.band[0],
        "rate_p95_per_year": risk.band[1],
        "rate_fit_p05_per_year": risk.fit_band[0],
        "rate_fit_p95_per_year": risk.fit_band[1],
        "rate_if_reached_per_year": risk.extremes[0],
        "rate_if_not_per_year": risk.extremes[1],
        "return_period_years": 1.0 / rate,
        "share_below": risk.below,
        "share_beyond": risk.beyond,
        **{
            f"intensity_p{percent:02d}": risk.intensity_at(0.01 * percent) if known else np.nan
            for percent in (5, 50, 95)
        },
    }
    if age is not None:
        row |= {
            "age_years": age,
            "survival": np.exp(-rate * age),
            "survival_p05": np.exp(-risk.band[1] * age),
            "survival_p95": np.exp(-risk.band[0] * age),
            "unlikely": unlikely,
            "allowed_rate_per_year": allowed_rate(age, unlikely),
            "allowed_factor": allowed_rate(age, unlikely) / rate,
        }
    return row


def _chance_rows(risks: Sequence[Risk], years: Sequence[float]) -> pd.DataFrame:
    """A row a function and span."""
    return pd.DataFrame(
        [
            {
                **_named(risk),
                "within_years": span,
                "chance": chance_within(risk.rate, span),
                "chance_p05": chance_within(risk.band[0], span),
                "chance_p95": chance_within(risk.band[1], span),
            }
            for risk in risks
            for span in years
        ]
    )


def _part_rows(risks: Sequence[Risk]) -> pd.DataFrame:
    """Which intensities make the rates, a row a function and range of intensities."""
    rows: list[dict[str, object]] = []
    fitted = [risk for risk in risks if risk.function.fit.verdict.value == FITTED]
    if not fitted:
        names = (*_named(risks[0]), "intensity_from", "intensity_to", "rate_per_year", "share")
        return pd.DataFrame(columns=list(names))
    edges = contribution_edges(fitted)
    for risk in fitted:
        for low, high, rate in zip(edges[:-1], edges[1:], risk.between(edges), strict=True):
            rows.append(
                {
                    **_named(risk),
                    "intensity_from": low,
                    "intensity_to": high,
                    "rate_per_year": rate,
                    "share": rate / risk.rate,
                }
            )
    return pd.DataFrame(rows)


def _hazard_rows(risks: Sequence[Risk]) -> pd.DataFrame:
    """The hazard as it was used."""
    at = hazard_intensities(risks)
    return pd.DataFrame({"intensity": at, "rate_per_year": risks[0].hazard.rate(at)})


def hazard_intensities(risks: Sequence[Risk]) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Intensities at which a hazard is told: its rows, of a power law those that contribute."""
    hazard: Hazard = risks[0].hazard
    if len(hazard.edges):
        return hazard.edges
    known = [risk for risk in risks if risk.rate > 0.0]
    return contribution_edges(known) if known else np.ones(1)


def _allowed_rows(risks: Sequence[Risk], age: float, unlikely: float) -> pd.DataFrame:
    """Rates of exceedance that the age of each object allows, a row a function and intensity."""
    at = hazard_intensities(risks)
    tables = [
        pd.DataFrame(
            {
                **{name: [value] * len(at) for name, value in _named(risk).items()},
                "intensity": at,
                "rate_per_year": risk.hazard.rate(at),
                "allowed_rate_per_year": allowed_hazard(risk.function.fit, at, age, unlikely),
            }
        )
        for risk in risks
        if risk.function.fit.dispersion > 0.0
    ]
    return pd.concat(tables) if tables else pd.DataFrame(columns=["intensity"])


def tell_risk(_facts: Facts, tables: Tables) -> Finding:
    """What yearly rates came to, of their tables; facts beside them are those of a run."""
    rows, chances = tables[RISK], tables[CHANCES]
    names = list(map(str, rows.columns[: list(rows.columns).index(LIMIT)]))
    intensity, hazard = str(rows["intensity"].iloc[0]), str(rows["hazard"].iloc[0])
    measured = measure(intensity)
    return Finding(
        kind="Yearly rates",
        title=f"Risk over {measured.name}",
        facts={},
        tables=tables,
        sentences=[
            _headline(rows, chances, names),
            *_sentences(rows, names, intensity),
            *_stood(rows, names),
        ],
        sheets=[
            _rate_sheet(rows, chances, names),
            sheet_of("Which intensities make the rate", tables[PARTS], file=PARTS, folded=True),
            sheet_of("All numbers of the rates", rows.dropna(axis="columns", how="all"),
                     note="p05, p95: 5th and 95th percentile over records; fit: of the fit alone.",
                     file=RISK, folded=True),
        ],
        asked=[
            ("Hazard", hazard),
            ("Intensity measure", intensity),
            ("Rate", "integral of the fragility function over the hazard, in closed form; "
                     "events as a Poisson process"),
        ],
        pictures=["risk*.png"],
        rows={"risks": RISK, "chances": CHANCES},
        beside=True,
    )  # fmt: skip


RISKS = Kind((RISK, CHANCES, PARTS), tell_risk, file=RISK)


def _name(row: pd.Series[Any], names: Sequence[str]) -> str:
    return ", ".join(str(row[name]) if name == "object" else f"{name.replace('_', ' ')} {row[name]}"
                     for name in names)  # fmt: skip


def _comes(limit: str) -> str:
    """What comes, of a limit state."""
    known = {"uplift": "Uplift", "overturning": "Overturning"}
    return known.get(limit, f"A limit of {limit}")


def once_in(period: float) -> str:
    """How often something comes, of its return period in years."""
    return f"once in {number_of('return_period_years', period)} years"


def percent_text(chance: float) -> str:
    """A chance in percent, two digits; a dash where there is none."""
    return quantity_of("chance", chance)


def _headline(rows: pd.DataFrame, chances: pd.DataFrame, names: Sequence[str]) -> str:
    """How often the worst limit state comes."""
    mine = worst_limit(rows)
    known = mine[mine["rate_per_year"] > 0.0].sort_values("rate_per_year")
    what = _comes(str(mine[LIMIT].iloc[0]))
    if known.empty:
        reasons = {WHY_NONE.get(verdict, "there is no function") for verdict in mine["verdict"]}
        return f"{what} has no yearly rate: {' or '.join(sorted(reasons))}."
    often = known.iloc[-1]
    if len(known) > 1:
        ends = [f"{once_in(row['return_period_years'])} ({_name(row, names)})"
                for row in (often, known.iloc[0])]  # fmt: skip
        return f"{what} comes from {ends[0]} to {ends[1]}."
    row = chances.loc[chances[chances[LIMIT] == often[LIMIT]].index]
    for name in names:
        row = row[row[name] == often[name]]
    longest = row.sort_values("within_years").iloc[-1]
    band = ""
    if np.isfinite(often["rate_p05_per_year"]):
        most, least = (1.0 / often[f"rate_{end}_per_year"] for end in ("p05", "p95"))
        years = " to ".join(number_of("return_period_years", each) for each in (least, most))
        band = f" (5 to 95 %: {years})"
    return (
        f"{what} comes {once_in(often['return_period_years'])}{band}: a chance of "
        f"{percent_text(longest['chance'])} within {value_of(longest, 'within_years')} years."
    )


def _sentences(rows: pd.DataFrame, names: Sequence[str], intensity: str) -> list[str]:
    """Each rate, which motions make it, and what comes from beyond the hazard."""
    measured, found = measure(intensity), []
    for _, row in rows.head(MOST_FITS).iterrows():
        name = f"{_name(row, names)}: " if names else ""
        if not row["rate_per_year"] > 0.0:
            why = WHY_NONE.get(row["verdict"], "there is no function")
            found.append(f"{name}{_comes(row[LIMIT])} has no yearly rate: {why}.")
            continue
        ends = [measured.text(row[f"intensity_p{percent:02d}"]) for percent in (5, 95)]
        text = f"{name}{_comes(row[LIMIT])} comes {three(row['rate_per_year'])} times a year"
        if row["verdict"] == FITTED:
            text += f"; nine tenths of that under a {measured.name} of {ends[0]} to {ends[1]}"
        else:
            text += f"; lanes are separated at a {measured.name} of {measured.text(row['median'])}"
        found.append(f"{text}.")
    if len(rows) > MOST_FITS:
        found.append(f"All {len(rows):,} rates are in the table.")
    for side, where in (("below", "weaker"), ("beyond", "stronger")):
        most = rows[f"share_{side}"].max()
        if most >= 5e-4:
            found.append(
                f"Up to {percent_text(most)} of a rate comes from motions {where} than the hazard "
                "tells of, where it is continued at the slope of its end."
            )
    return found


def _stood(rows: pd.DataFrame, names: Sequence[str]) -> list[str]:
    """What it says of the hazard that objects have stood for their age."""
    if "age_years" not in rows:
        return []
    found = []
    for _, row in worst_limit(rows).head(MOST_FITS).iterrows():
        if not row["rate_per_year"] > 0.0:
            continue
        name = f"{_name(row, names)}: " if names else ""
        factor = row["allowed_factor"]
        text = (
            f"{name}Under this hazard it stands for {three(row['age_years'])} years with a chance "
            f"of {percent_text(row['survival'])}"
        )
        text += (
            f": that it does rules the hazard out at {percent_text(row['unlikely'])}, whose rates "
            f"must be {three(1.0 / factor)} times lower at least"
            if factor < 1.0
            else f": that says nothing against the hazard, whose rates could be {three(factor)} "
            f"times higher before that chance is {percent_text(row['unlikely'])}"
        )
        found.append(f"{text}.")
    return found


def _rate_sheet(rows: pd.DataFrame, chances: pd.DataFrame, names: Sequence[str]) -> Sheet:
    """Every rate: with its band, its return period and its chances."""
    spans = list(dict.fromkeys(chances["within_years"]))
    each = chances["chance"].to_numpy().reshape(len(rows), len(spans))
    cells = [
        [
            *(str(row[name]) for name in (*names, LIMIT)),
            value_of(row, "rate_per_year"),
            _range(row["rate_p05_per_year"], row["rate_p95_per_year"]),
            _range(row["rate_fit_p05_per_year"], row["rate_fit_p95_per_year"]),
            three(row["return_period_years"]),
            *(percent_text(chance) for chance in mine),
            percent_text(row["share_below"] + row["share_beyond"]),
        ]
        for (_, row), mine in zip(rows.iterrows(), each, strict=True)
    ]
    heads = [Heading(name.replace("_", " ")) for name in (*names, LIMIT)]
    heads += [Heading("rate", "1/year"), Heading("5 to 95 % over records", "1/year")]
    heads += [Heading("of the fit alone", "1/year")]
    heads += [Heading("return period", "years")]
    heads += [Heading(f"chance within {number_of('within_years', span)} years") for span in spans]
    heads += [Heading("beyond the hazard")]
    return Sheet("Yearly rates", heads, cells, "Beyond the hazard: share of the rate from motions "
                 "weaker or stronger than it tells of.")  # fmt: skip


def _range(low: float, high: float) -> str:
    ends = (number_of("rate_per_year", each) for each in (low, high))
    return " to ".join(ends) if np.isfinite(low) else "-"
