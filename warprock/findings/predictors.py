"""Which intensity measures predict best, in words."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd

from warprock.analysis.exports import component_rows, nrml_text
from warprock.analysis.fragility import curve_rows
from warprock.analysis.predictors import SUFFICIENT, Predictors, slices
from warprock.analysis.risk_functions import PERIOD
from warprock.findings.digits import number_of
from warprock.findings.finding import Facts, Finding, Kind, Tables
from warprock.findings.intensities import measure
from warprock.findings.numbers import counted, three
from warprock.findings.sheets import Heading, Sheet

SINGLES = "predictors.csv"
PAIRS = "predictors-pairs.csv"
COMPONENTS = "predictors-p58.csv"
NRML = "predictors.xml"


def find_predictors(found: Predictors, source: str) -> Finding:
    """Which intensity measures predict best.

    Args:
        found: What was compared.
        source: Name of the table.
    """
    tables = {SINGLES: _single_rows(found, source), PAIRS: _pair_rows(found)}
    first, cut = slices(found)
    texts = {}
    if cut:
        table = found.table
        periods = table[PERIOD].unique().tolist() if PERIOD in table else list[float]()
        period = float(periods[0]) if len(periods) == 1 else np.nan
        tables[COMPONENTS] = component_rows(cut, first, period)
        model = nrml_text(cut, first, period)
        texts = {NRML: model} if model else {}
    return tell_predictors({}, tables, texts)


def _single_rows(found: Predictors, source: str) -> pd.DataFrame:
    """A row a measure, the one that predicts best first."""
    fits = curve_rows(found.curves).to_dict("records") if found.curves else []
    rows = []
    best = found.singles[0]
    for each, fit in zip(found.singles, fits, strict=True):
        gain, error = found.gain(best, each)
        lanes = fit["lanes"]
        rows.append(
            {
                "measure": each.measures[0],
                "limit_state": found.limit.name,
                "source": source,
                "lanes": lanes,
                "records": found.records,
                **{name: fit[name] for name in ("verdict", "median", "dispersion")},
                "log_likelihood": each.log_likelihood,
                "loss": each.loss,
                "loss_over_best": gain,
                "loss_over_best_error": error,
            }
        )
    for name, twin in found.same.items():
        rows.append({"measure": name, "limit_state": found.limit.name, "source": source,
                     "same_as": twin or "nothing: it does not differ"})  # fmt: skip
    return pd.DataFrame(rows)


def _pair_rows(found: Predictors) -> pd.DataFrame:
    """A row for each measure beside each other."""
    rows = []
    alone = {each.measures[0]: each for each in found.singles}
    for test in found.tests:
        first, second = test.pair.measures
        gain, error = found.gain(test.pair, alone[first])
        a, b, c = test.pair.coefficients
        rows.append(
            {
                "measure": first,
                "second": second,
                **dict(zip(("a", "b", "c"), (a, b, c), strict=True)),
                "log_likelihood": test.pair.log_likelihood,
                "likelihood_ratio": test.statistic,
                "chance_of_ratio": test.chance,
                "t_over_records": test.t,
                "chance_over_records": test.chance_over_records,
                "sufficient": bool(test.sufficient),
                "loss": test.pair.loss,
                "loss_gain": gain,
                "loss_gain_error": error,
            }
        )
    names = ("measure", "second", "loss", "loss_gain", "likelihood_ratio", "chance_over_records")
    return pd.DataFrame(rows) if rows else pd.DataFrame(columns=[*names, "sufficient"])


def tell_predictors(_facts: Facts, tables: Tables, texts: dict[str, str] | None = None) -> Finding:
    """Which intensity measures predict best, of their tables."""
    singles, pairs = tables[SINGLES], tables[PAIRS]
    limit = str(singles["limit_state"].iloc[0])
    return Finding(
        kind="Predictors",
        title=f"What predicts {limit}",
        facts={},
        tables=tables,
        sentences=[
            _headline(singles, limit),
            *_second(singles),
            *_together(pairs),
            *_sufficient(singles, pairs),
            *_same(singles),
        ],
        sheets=[_single_sheet(singles), *([_pair_sheet(pairs)] if len(pairs) else [])],
        asked=[
            ("Limit state", limit),
            ("Loss", "minus the logarithm of the probability of what became of a lane, of records "
                     "that the fit has not seen; 0.693 knows nothing"),
        ],
        pictures=["predictors*.png"],
        texts=texts or {},
        rows={"measures": SINGLES, "pairs": PAIRS},
        beside=True,
    )  # fmt: skip


PREDICTORS = Kind((SINGLES, PAIRS), tell_predictors, file=SINGLES)


def _name(column: str) -> str:
    return measure(column).name


def _known(singles: pd.DataFrame) -> pd.DataFrame:
    return singles[singles["loss"].notna()]


def _headline(singles: pd.DataFrame, limit: str) -> str:
    """The measure that predicts best."""
    known = _known(singles)
    row = known.iloc[0]
    if row["verdict"] == "separated":
        return f"The {_name(row['measure'])} parts the lanes that reach {limit} from the others."
    return (
        f"Of {counted(len(known), 'measure')} the {_name(row['measure'])} predicts {limit} best, "
        f"with a loss of {three(row['loss'])} on records unseen."
    )


def _second(singles: pd.DataFrame) -> list[str]:
    """How far the next is behind."""
    known = _known(singles)
    if len(known) < 2:
        return []
    row = known.iloc[1]
    gap, error = row["loss_over_best"], row["loss_over_best_error"]
    clear = "" if gap > 2.0 * error else ", which other records could turn round"
    return [
        f"The {_name(row['measure'])} comes next, {three(gap)} +- {three(error)} behind{clear}."
    ]


def _together(pairs: pd.DataFrame) -> list[str]:
    """What the best two do together."""
    known = pairs[pairs["loss"].notna()]
    if known.empty:
        return []
    row = known.sort_values("loss", kind="stable").iloc[0]
    gain, error = row["loss_gain"], row["loss_gain_error"]
    better = f"{three(gain)} +- {three(error)} lower than of the first alone"
    if gain <= 0.0:
        better = "no lower than of the first alone"
    return [
        f"The best two are the {_name(row['measure'])} and the {_name(row['second'])}: loss "
        f"{three(row['loss'])}, {better}; likelihood ratio {three(row['likelihood_ratio'])}, "
        f"chance by a draw of records {three(row['chance_over_records'])}."
    ]


def _sufficient(singles: pd.DataFrame, pairs: pd.DataFrame) -> list[str]:
    """Whether the best measure is sufficient beside the others."""
    known = _known(singles)
    if pairs.empty or known["verdict"].iloc[0] == "separated":
        return []
    best = known["measure"].iloc[0]
    mine = pairs[(pairs["measure"] == best) & pairs["chance_over_records"].notna()]
    if mine.empty:
        return []
    missing = [_name(name) for name in mine[~mine["sufficient"].astype(bool)]["second"]]
    if not missing:
        level = number_of("level", SUFFICIENT)
        return [f"The {_name(best)} is sufficient beside all others (chance above {level})."]
    return [f"The {_name(best)} is not sufficient: {', '.join(missing)} adds to it."]


def _same(singles: pd.DataFrame) -> list[str]:
    """Measures that say the same as another."""
    if "same_as" not in singles:
        return []
    mine = singles[singles["same_as"].notna()]
    return [f"Left out: {_name(row['measure'])}, which tells these lanes apart as "
            f"{row['same_as']} does." for _, row in mine.iterrows()]  # fmt: skip


def _single_sheet(singles: pd.DataFrame) -> Sheet:
    rows = [
        [
            _name(row["measure"]),
            three(row["loss"]),
            _gap(row["loss_over_best"], row["loss_over_best_error"]),
            three(row["log_likelihood"]),
            three(row["dispersion"]),
        ]
        for _, row in _fitted(singles).iterrows()
    ]
    heads = ["measure", "loss, records unseen", "behind the best", "log-likelihood", "dispersion"]
    note = "Behind the best: with its standard error over records."
    return Sheet("Measures alone", [*map(Heading, heads)], rows, note)


def _fitted(singles: pd.DataFrame) -> pd.DataFrame:
    return singles[singles["log_likelihood"].notna()]


def _gap(value: float, error: float) -> str:
    return "-" if not np.isfinite(value) else f"{three(value)} +- {three(error)}"


def _pair_sheet(pairs: pd.DataFrame) -> Sheet:
    rows: list[list[Any]] = [
        [
            _name(row["measure"]),
            _name(row["second"]),
            three(row["loss"]),
            _gap(row["loss_gain"], row["loss_gain_error"]),
            three(row["likelihood_ratio"]),
            three(row["chance_over_records"]),
            "yes" if row["sufficient"] else "no",
        ]
        for _, row in pairs.iterrows()
    ]
    heads = ["measure", "with", "loss, records unseen", "gain", "likelihood ratio"]
    heads += ["chance over records", "sufficient alone"]
    return Sheet("Measures two by two", [*map(Heading, heads)], rows)
