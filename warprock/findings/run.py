"""What a run came to."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from warprock.case.columns import Table
from warprock.findings import asked
from warprock.findings.digits import quantity_of
from warprock.findings.finding import Facts, Finding
from warprock.findings.lanes import (
    among,
    falling,
    lane_name,
    lane_sheet,
    numbers,
    peak_ratio,
    standing,
)
from warprock.findings.numbers import counted, three
from warprock.findings.refinement import bad_sentences, refinement_sentences
from warprock.findings.sheets import sheet_of
from warprock.model.ratios import NO_TURN
from warprock.model.response import USABLE_NAMES
from warprock.model.words import ASSEMBLY, BLOCK
from warprock.running.case_run import CaseRun
from warprock.running.lane_table import APART, LANE_TABLE, run_columns
from warprock.running.provenance import provenance
from warprock.running.results import CELL_TABLE


def find_run(run: CaseRun, show: Callable[[], None]) -> Finding:
    """What a run came to.

    Args:
        run: The run.
        show: Prints it on the terminal.
    """
    tables: dict[str, Table] = {LANE_TABLE: run_columns(run.lane_set, run.response)}
    if run.case.ensemble is not None:
        from warprock.running.cells import cell_table

        tables[CELL_TABLE] = cell_table(run.lane_set, run.response)
    facts = provenance(run) | limit_beside(run)
    finest = float(run.response["time_step"].min()) if "time_step" in run.response.fields else None
    return dataclasses.replace(tell_run(facts, tables, finest), show=show)


def tell_run(
    facts: Facts, tables: Mapping[str, Table], finest_step: float | None = None
) -> Finding:
    """What a run or an ensemble came to, of its facts and tables, and of its finest step [s]."""
    lanes, cells = tables[LANE_TABLE], tables.get(CELL_TABLE)
    kind, sentences, sheets = "Run", run_sentences(facts, lanes, finest_step), []
    if cells is not None:
        kind, sentences = "Ensemble", [*sentences, *cell_sentences(facts, cells)]
        sheets.append(sheet_of("Cells of the ensemble", cells, file=CELL_TABLE))
    sheets.append(lane_sheet(facts, lanes, file=LANE_TABLE, folded=bool(sheets)))
    return Finding(
        kind=kind,
        facts=facts,
        tables=tables,
        sentences=sentences,
        sheets=sheets,
        rows={"rows": LANE_TABLE if cells is None else CELL_TABLE},
        pictures=["histories.png", "space.png", "mechanism.png", "ensemble*.png", "peaks*.png"],
    )


def run_sentences(
    facts: Mapping[str, Any], table: Table, finest_step: float | None = None
) -> list[str]:
    """What became of the lanes with the largest rotation, and how accurate that is."""
    count, outcome = len(table), facts["outcome"]
    together = None if "shortest_duration_s" in facts else facts.get("duration_s")
    thing = ASSEMBLY if "collapse_time_s" in table else BLOCK
    ended = asked.outcome_words(outcome, together, falling(table), thing)
    first = f"{counted(count, 'lane')} ran: {ended}."
    if count == 1:
        first = f"One lane ran: it {_at(table, 'outcome', 0).replace('_', ' ')}."
        first = first.replace("it at rest", "its block came to rest")
        first = first.replace("it rocking", "its block still moved when the run ended")
        first = first.replace("it overturned", "its block overturned")
        first = first.replace("it slid off", "a block slid off")
        if "collapse_time_s" in table:
            first = f"One lane ran: {assembly_words(table)}."
    peaks = peak_sentences(facts, table)
    refined = refinement_sentences(facts, finest_step)
    ties = tie_sentences(facts, table)
    return [f"{first} {peaks[0]}", *peaks[1:], *ties, *refined, *bad_sentences(facts)]


def peak_sentences(facts: Mapping[str, Any], table: Table) -> list[str]:
    """The largest rotation of what stood, and the median; how far thrown blocks went."""
    if "attitude_w_start" in table:
        return way_sentences(facts, table)
    if "collapse_time_s" in table:
        return assembly_sentences(facts, table)
    up, ratio = np.flatnonzero(standing(table)), peak_ratio(table)
    if not len(up):
        return ["No lane with usable numbers stayed up."]
    top = int(up[np.argmax(ratio[up])])
    if ratio[top] <= NO_TURN:
        return ["No block that stayed up rotated."]
    where = ""
    if len(table) > 1:
        where = f", in {lane_name(facts, table, top)}"
    when = numbers(table, "peak_time_s")[top] if "peak_time_s" in table else np.nan
    at = f" at {three(float(when))} s" if when == when and len(table) == 1 else ""
    degrees = ""
    if "peak_rotation_rad" in table:
        degrees = f" ({three(float(np.rad2deg(numbers(table, 'peak_rotation_rad')[top])))} deg)"
    text = (
        f"The largest rotation of a block that stayed up is {three(float(ratio[top]))} of its "
        f"slenderness angle{degrees}{at}{where}"
    )
    if len(up) > 2:
        text += f"; the median lane that stayed up reaches {three(float(np.median(ratio[up])))}"
    return [f"{text}."]


def _at(table: Table, name: str, row: int) -> Any:
    """What a column has in a row."""
    return np.asarray(table[name])[row]


def assembly_words(table: Table) -> str:
    """What became of an assembly, the only one of a run."""
    if np.isfinite(_at(table, "collapse_time_s", 0)):
        return "the assembly collapsed"
    if _at(table, "outcome", 0) == "at_rest":
        return "the assembly stood and came to rest"
    return "the assembly still moved when the run ended"


NAMED = 6
"""Joints that a sentence names."""


def assembly_sentences(facts: Facts, table: Table) -> list[str]:
    """How far the blocks of assemblies that stood moved, and how the first of the others fell."""
    moved, up = numbers(table, "peak_displacement_m"), np.flatnonzero(standing(table))
    fell = numbers(table, "collapse_time_s")
    told, alone = [], len(table) == 1
    if len(up):
        top = int(up[np.argmax(moved[up])])
        where = "" if alone else f", in {lane_name(facts, table, top)}"
        what = "a block" if alone else "a block of an assembly that did not collapse"
        far, median = (
            quantity_of("peak_displacement_m", value)
            for value in (moved[top], np.median(moved[up]))
        )
        text = f"The largest displacement of {what} is {far}{where}"
        if len(up) > 2:
            text += f", in the median lane {median}"
        told.append(f"{text}; {joint_words(table, top)}.")
    if np.isfinite(fell).any():
        first = int(np.nanargmin(fell))
        what = (
            "A block"
            if alone
            else f"The first collapse is in {lane_name(facts, table, first)}: a block"
        )
        load = float(_at(table, "collapse_load", first))
        tilt = ""
        if "tilt_rate_deg_s" in table:
            tilt = f", a tilt of {three(float(np.degrees(np.arctan(load))))} deg"
        began = f"at a sideways load of {three(load)} of the weight{tilt}" if load else "at once"
        fallen = "slid off" if _at(table, "outcome", first) == "slid_off" else "fallen"
        told.append(
            f"{what} had {fallen} at {three(fell[first])} s. "
            f"The motion that ended so began {began}; "
            f"{joint_words(table, first)}."
            f"{limit_words(facts, first, tilted=bool(tilt))}"
        )
    elif not len(up):
        told.append("No lane with usable numbers stayed up.")
    return told


JOINT_VERBS = (("opened_between", "opened"), ("slid_between", "slid"), ("broken_between", "broke"))
"""Columns of joints, and what these did."""


def joint_words(table: Table, row: int) -> str:
    """Which joints of a lane opened, slid and broke."""
    parts = []
    for column, verb in JOINT_VERBS:
        if column not in table:
            continue
        names = [name for name in str(_at(table, column, row)).split(APART) if name]
        if names:
            more = len(names) - NAMED
            left = f" and {more} more" if more > 0 else ""
            parts.append(f"{verb} between {', '.join(names[:NAMED])}{left}")
    return f"joints {' and '.join(parts)}" if parts else "no joint opened or slid"


LIMIT_ANALYSIS = "limit_analysis"
"""What `run.json` says of the first assembly that collapsed, if one did."""


def limit_words(facts: Facts, row: int, *, tilted: bool) -> str:
    """What limit analysis says of a lane that collapsed, as a sentence; empty of other lanes."""
    limit = facts.get(LIMIT_ANALYSIS)
    if limit is None or limit["row"] != row:
        return ""
    load = limit["load_factor"]
    if load is None:
        return " By limit analysis it does not carry its own weight."
    said, low = _steady(load, tilted=tilted), limit["coulomb_load_factor"]
    if not limit["upper_bound"]:
        return f" By limit analysis a steady sideways load of {said} brings it down."
    if low is None or three(low) == three(load):
        return (
            f" By limit analysis a steady sideways load of at most {said} brings it down, an upper "
            "bound, since joints slide."
        )
    return (
        f" By limit analysis a steady sideways load between {_steady(low, tilted=tilted)}, with "
        f"Coulomb's friction, and {said}, an upper bound since joints slide, brings it down."
    )


def _steady(load: float, *, tilted: bool) -> str:
    """A load factor in words, with the tilt of a table."""
    tilt = f" (a tilt of {three(float(np.degrees(np.arctan(load))))} deg)" if tilted else ""
    return f"{three(load)} of the weight{tilt}"


def limit_beside(run: CaseRun) -> dict[str, Any]:
    """Limit analysis of the first lane that collapsed; else nothing."""
    if run.lane_set.lanes.assembly is None:
        return {}
    from warprock.analysis.load_limit import collapse_beside

    found = collapse_beside(run)
    if found is None:
        return {}
    row, collapse = found
    load = collapse.load_factor if collapse.stands else None
    coulomb = collapse.coulomb_load if collapse.stands else np.nan
    limit = {
        "row": row,
        "load_factor": load,
        "coulomb_load_factor": coulomb if np.isfinite(coulomb) else None,
        "upper_bound": collapse.upper_bound,
    }
    return {LIMIT_ANALYSIS: limit}


def tie_sentences(facts: Mapping[str, Any], table: Table) -> list[str]:
    """The largest force of a tie, and whether one broke."""
    if "peak_tie_force_N" not in table:
        return []
    usable = np.flatnonzero(among(table, "status", USABLE_NAMES))
    if not len(usable):
        return []
    forces, broken = numbers(table, "peak_tie_force_N"), numbers(table, "broken_ties")
    top = int(usable[np.argmax(forces[usable])])
    largest = f"{three(1e-3 * float(forces[top]))} kN"
    broke = int((broken[usable] > 0.0).sum())
    if len(table) == 1:
        when = f"a tie broke at {three(float(_at(table, 'tie_break_time_s', 0)))} s"
        return [f"The largest force of a tie is {largest}; {when if broke else 'none broke'}."]
    lanes = f"in {counted(broke, 'lane')} a tie broke" if broke else "none broke"
    where = lane_name(facts, table, top)
    return [f"The largest force of a tie is {largest}, in {where}; {lanes}."]


def way_sentences(facts: Mapping[str, Any], table: Table) -> list[str]:
    """How far thrown blocks went, and when they lay still: they may lie on any side."""
    way, rest = numbers(table, "peak_slide_m"), numbers(table, "rest_time_s")
    rested = not np.isnan(rest).all()
    if len(table) == 1:
        still = f" and lies still after {three(float(rest[0]))} s" if rested else ""
        return [f"It goes {three(float(way[0]))} m along the base{still}."]
    far = int(np.argmax(way))
    name = lane_name(facts, table, far)
    text = f"The farthest goes {three(float(way[far]))} m along the base, {name}"
    if rested:
        last = three(float(np.nanmax(rest)))
        text += f"; the last of those that came to rest lies still after {last} s"
    return [f"{text}."]


def cell_sentences(facts: Mapping[str, Any], table: Table) -> list[str]:
    """The cell of an ensemble that overturns most often.

    Args:
        facts: What `run.json` holds.
        table: What `running.cells.cell_table` gives.
    """
    if "overturned" not in table or not len(table):
        return []
    share = numbers(table, "overturned")
    if np.isnan(share).all():
        return []
    row = int(np.nanargmax(share))
    low, high = (float(_at(table, f"overturned_{side}", row)) for side in ("low", "high"))
    if share[row] == 0.0:
        text = f"No member of any of the {len(table):,} cells overturned"
        return [f"{text}; with 95 % confidence at most {three(100 * high)} % do in a cell."]
    name = lane_name(facts, table, row, "cell")
    return [
        f"Of the {len(table):,} cells, {name} overturns most often: "
        f"{three(100.0 * float(share[row]))} % of its members (95 % interval "
        f"{three(100 * low)} to {three(100 * high)} %)."
    ]
