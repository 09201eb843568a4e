"""What a comparison of engines came to."""

from __future__ import annotations

import dataclasses
import shlex
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from warprock.case.case import Case
from warprock.findings.digits import number_of
from warprock.findings.finding import Facts, Finding, Kind, Tables
from warprock.findings.numbers import counted, listed, three
from warprock.findings.plain import plain
from warprock.findings.sheets import Heading, Sheet, sheet_of
from warprock.running.provenance import case_facts, surroundings
from warprock.running.run_file import CASE, ROWS
from warprock.settings.engines import EXACT, SETTINGS
from warprock.verification.settings import plain_name

TABLE = "comparison"
_WANTED = (
    *("lane", "block", "cell", "engine", "engine_a", "engine_b", "outcome", "status"),
    *("peak_rotation_ratio", "error_5s_ratio", "error_run_ratio", "peak_error"),
    *("difference_5s_ratio", "difference_run_ratio", "rest_time_error_s", "peak_slide_mm"),
    *("difference_across_5s_ratio", "difference_yaw_5s_rad", "holds", "why"),
    *("position_error_mm", "rotation_error_deg", "same_face"),
    *("fell_at_s", "moved_mm", "difference_deg"),
)
"""Columns of lanes that a page shows, of those that a comparison has."""


def find_compare(case: Case, found: Mapping[str, Any], show: Callable[[], None]) -> Finding:
    """What a comparison came to.

    Args:
        case: The case.
        found: What `verification.checks.compare` returned.
        show: Prints its tables on the terminal.
    """
    tables = {TABLE: pd.DataFrame(found["rows"])}
    if found["costs"]:
        tables["costs"] = _costs(found["costs"])
    facts = plain({**found, "asked": case_facts(case), **surroundings(case)})
    engine = _nearest(facts)[1] if _against_housner(facts) else found["engines"][0]
    where = case.name if case.folder is None else case.file
    # Programs of others and the oracle are no engines: `run` chooses one then.
    by = ["-e", plain_name(engine)] if engine and plain_name(engine) in SETTINGS else []
    then = shlex.join(["warprock", "run", where, *by, "-o", "results"])
    return dataclasses.replace(tell_compare(facts, tables), said=found, then=then, show=show)


def tell_compare(facts: Facts, tables: Tables) -> Finding:
    """What a comparison came to, of its facts and table."""
    table, names = tables[TABLE], facts["engines"]
    shown = table[[name for name in _WANTED if name in table]] if "cell" not in table else table
    engines = list(_engines(table))
    said = [sentence for sentence, _ in engines] or list(_assemblies(table))
    if facts.get("assembly"):
        said += judged_by_falls(facts["rows"])
    sheets = [_summary([row for _, row in engines])] if engines else []
    sheets.append(
        sheet_of(
            "Lane by lane",
            shown.rename(columns={"lane": "of lane"}),
            file=f"{TABLE}.csv",
            folded=bool(engines),
        )
    )
    if facts.get("costs"):
        sheets.append(sheet_of("What the programs took", _costs(facts["costs"])))
    headline = f"{counted(len(names), 'engine')} were held against {names[0]}."
    if "observed" in facts:
        headline = f"{counted(len(names), 'engine')} were held against poses that were observed."
    elif _against_housner(facts):
        headline = _nearest(facts)[0]
    same = f"{counted(len(names), 'engine')} on the same lanes: {listed(names)}."
    return Finding(
        kind="Comparison",
        facts=facts,
        tables=tables,
        sentences=[headline, same, *said],
        sheets=sheets,
        asked=[("Engines", ", ".join(names))],
        pictures=["*.png"],
    )


def _costs(rows: list[dict[str, Any]]) -> pd.DataFrame:
    """What programs took, their settings as text."""
    told = {
        number: ", ".join(f"{name} = {value}" for name, value in row["settings"].items())
        for number, row in enumerate(rows)
    }
    return pd.DataFrame(rows).assign(settings=pd.Series(told))


COMPARISON = Kind(
    (TABLE,),
    tell_compare,
    "asked",
    {
        "asked": CASE,
        "engines": [str],
        "costs?": [{"settings": {...: (str, float, bool, None)}, **ROWS[0]}],
        **dict.fromkeys(("stacked", "spatial", "assembly?"), bool),
        "rows": ROWS,
    },
)


def _against_housner(facts: Facts) -> bool:
    """Whether lanes of single blocks in the plane were held against Housner."""
    single = not any(facts.get(name) for name in ("stacked", "spatial", "assembly"))
    return single and "ensemble" not in facts["asked"]["resolved"] and "observed" not in facts


def _nearest(facts: Facts) -> tuple[str, str]:
    """What a comparison with Housner says in one sentence, and the engine that is nearest to him.

    It is empty where he holds in no lane.

    Args:
        facts: What `run.json` holds of it.
    """
    largest: dict[str, float] = {}
    for row in facts["rows"]:
        if row["holds"] and row["error_run_ratio"] is not None:
            before = largest.get(row["engine"], 0.0)
            largest[row["engine"]] = max(before, row["error_run_ratio"])
    if not largest:
        return "Housner holds in no lane.", ""
    # Housner's equation is no nearer to itself than it was before.
    others = [engine for engine in largest if plain_name(engine) not in EXACT] or list(largest)
    best = min(others, key=lambda engine: largest[engine])
    within = f"within {number_of('error_run_ratio', largest[best])} of the slenderness angle"
    if len(others) == 1:
        return f"{best} is {within} of Housner.", best
    return f"{best} is nearest to Housner: {within}.", best


def _engines(table: pd.DataFrame) -> Iterator[tuple[str, list[str]]]:
    """A sentence and a row of the summary of every engine, where lanes are compared one by one."""
    name = next((n for n in ("error_run_ratio", "difference_run_ratio") if n in table), None)
    if name is None:
        return
    for engine, rows in table.groupby("engine", sort=False):
        kept = rows[rows["holds"].astype(bool)] if "holds" in rows else rows
        reference = str(rows["reference"].iloc[0]) if "reference" in rows else "Housner"
        off = kept[name].to_numpy(dtype=float)
        off = off[np.isfinite(off)]
        # `housner` is the reference where that is Housner.
        if str(engine).lower() == reference.lower() or not len(off):
            continue
        counts = f"{counted(len(off), 'row')}, lanes and blocks" if "block" in rows else ""
        counts = counts or f"{counted(len(off), 'lane')} in which Housner holds"
        middle, most = (number_of(name, float(value)) for value in (np.median(off), off.max()))
        yield (
            f"{engine} is within {most} of the slenderness angle of {reference} over the whole "
            f"run, {middle} in the median of {counts}.",
            [str(engine), reference, f"{len(off):,}", middle, most],
        )


def _assemblies(table: pd.DataFrame) -> Iterator[str]:
    """A sentence about every engine, where lanes are assemblies."""
    if "difference_deg" not in table:
        return
    reference = str(table["reference"].iloc[0])
    wanted = table[table["engine"] == reference].set_index("lane_number")["outcome"]
    for engine, rows in table.groupby("engine", sort=False):
        if engine == reference:
            continue
        own = rows.set_index("lane_number")
        same = int((own["outcome"] == wanted.loc[own.index]).sum())
        off = own["difference_deg"].to_numpy(dtype=float)
        text = f"{engine} has the outcome of {reference} in {same} of {len(own)} lanes"
        if np.isfinite(off).any():
            text += f"; its largest rotations differ by {three(float(np.nanmax(off)))} deg at most"
        yield text + "."


def judged_by_falls(rows: Sequence[Mapping[str, Any]]) -> list[str]:
    """That in programs of others only falls count, where an assembly slid off.

    Args:
        rows: Of a comparison of assemblies.
    """
    programs = [
        name
        for name in dict.fromkeys(str(row["engine"]) for row in rows)
        if plain_name(name) not in SETTINGS
    ]
    if not programs or all(row["outcome"] != "slid_off" for row in rows):
        return []
    return [f"Only falls count in {listed(programs)}: what slides off goes on there."]


def _summary(rows: list[list[str]]) -> Sheet:
    text = "Largest |rotation - that of the reference| / slenderness angle over the run"
    heads = [Heading("engine"), Heading("held against"), Heading("rows"),
             Heading("median", "", text), Heading("largest", "", text)]  # fmt: skip
    return Sheet("What it comes to", heads, rows)
