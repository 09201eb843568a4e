"""What blocks bear that are led outwards, by statics."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd

from warprock.analysis.statics import EITHER, Statics
from warprock.findings.asked import naming_columns
from warprock.findings.finding import Facts, Finding, Kind, Tables
from warprock.findings.lanes import lane_name
from warprock.findings.numbers import counted, three
from warprock.findings.plain import plain
from warprock.findings.sheets import declared, sheet_of
from warprock.running.provenance import case_facts, surroundings
from warprock.running.run_file import CASE

CAPACITY = "capacity"
"""Name of the table."""
DEGREE = np.pi / 180.0

COLUMNS = {
    "lane": ("", "Number of the lane"),
    "side": ("", "Side to which the block leans"),
    "multiplier": ("-", "Base acceleration / g from which on the block turns"),
    "multiplier_peak": ("-", "Largest base acceleration / g that it takes on the way"),
    "rotation_at_peak_rad": ("rad", "Rotation at which it takes that"),
    "rotation_capacity_rad": ("rad", "Rotation at which nothing resists any more"),
    "displacement_capacity_m": ("m", "Way of the centre of percussion along the base to there"),
    "work_J": ("J", "Work that it takes to lead the block there"),
    "velocity_step_m_s": ("m/s", "Step of the velocity of a base at rest that overturns the block"),
}


def find_capacity(found: Statics) -> Finding:
    """What the statics of a case came to."""
    table, bears = capacity_table(found), found.found
    facts = {
        "case": case_facts(found.case),
        **surroundings(found.case),
        "lanes": found.lane_set.lanes.lane_count,
        CAPACITY: {
            "rows": len(table),
            "multiplier_least": float(bears.multiplier.min()),
            "velocity_step_least_m_s": _least(bears.velocity_step),
        },
    }
    return tell_capacity(plain(facts), {CAPACITY: table})


def _least(values: np.ndarray[Any, np.dtype[np.float64]]) -> float | None:
    known = values[np.isfinite(values)]
    return float(known.min()) if len(known) else None


def capacity_table(found: Statics) -> pd.DataFrame:
    """A row a lane and side: what sets it apart, and what it bears."""
    bears, inputs = found.found, found.lane_set.inputs.iloc[found.lane].reset_index(drop=True)
    results = {
        "multiplier": bears.multiplier,
        "multiplier_peak": bears.multiplier_peak,
        "rotation_at_peak_rad": bears.lean_at_peak,
        "rotation_capacity_rad": bears.lean_capacity,
        "displacement_capacity_m": bears.displacement_capacity,
        "work_J": bears.work,
        "velocity_step_m_s": bears.velocity_step,
    }
    facts = {"case": case_facts(found.case)}
    named = naming_columns(facts, inputs)
    apart = {name: inputs[name] for name in named if name != "lane"}
    table = pd.DataFrame({"lane": found.lane, **apart, "side": found.side, **results})
    table.attrs["columns"] = dict(found.lane_set.inputs.attrs.get("columns", {}))
    return declared(table, COLUMNS)


def tell_capacity(facts: Facts, tables: Tables) -> Finding:
    """What the statics of a case came to, of its facts and its table."""
    table = tables[CAPACITY]
    return Finding(
        kind="Capacity",
        facts=facts,
        tables=tables,
        sentences=_sentences(facts, table),
        sheets=[sheet_of("What blocks bear that are led outwards", table, file=f"{CAPACITY}.csv")],
        rows={"rows": CAPACITY},
        pictures=["capacity*.png"],
    )


KIND = Kind(
    (CAPACITY,),
    tell_capacity,
    CAPACITY,
    {
        "case": CASE,
        "lanes": int,
        CAPACITY: {
            "rows": int,
            "multiplier_least": float,
            "velocity_step_least_m_s": (float, None),
        },
    },
)


def _sentences(facts: Facts, table: pd.DataFrame) -> list[str]:
    """Where rocking starts, what is borne at most, and what overturns, of the weakest row each."""
    rocks = int(table["multiplier"].argmin())
    least = float(table["multiplier"].iloc[rocks])
    where = _where(facts, table, rocks)
    of = f", the least of {counted(facts['lanes'], 'lane')}" if facts["lanes"] > 1 else ""
    started = f"A base acceleration of {three(least)} g starts rocking{where}{of}."
    if least <= 0.0:
        started = f"Nothing has to move: the block falls by itself{where}."
    said = [started]
    bears = int(table["multiplier_peak"].argmin())
    peak = table.iloc[bears]
    if peak["rotation_at_peak_rad"] > 0.0:
        said.append(
            f"On the way it takes at most {three(float(peak['multiplier_peak']))} g, at "
            f"{three(float(peak['rotation_at_peak_rad']) / DEGREE)} deg"
            f"{_where(facts, table, bears)}."
        )
    steps = table["velocity_step_m_s"]
    if not steps.notna().any():
        return [*said, "Nothing overturns: the moment holds up to a right angle."]
    falls = int(steps.argmin(skipna=True))
    row = table.iloc[falls]
    lean, way, work, step = (
        three(float(row[name]) / unit)
        for name, unit in (
            ("rotation_capacity_rad", DEGREE),
            ("displacement_capacity_m", 1.0),
            ("work_J", 1.0),
            ("velocity_step_m_s", 1.0),
        )
    )
    said.append(
        f"It falls once it leans {lean} deg{_where(facts, table, falls)}: {way} m along the base "
        f"at its centre of percussion, after {work} J of work. A step of the velocity of a base "
        f"at rest by {step} m/s is enough."
    )
    return said


def _where(facts: Facts, table: pd.DataFrame, row: int) -> str:
    """The row, where there are several: its lane and its side."""
    side = str(table["side"].iloc[row])
    lane = f" in {lane_name(facts, table, row)}" if facts["lanes"] > 1 else ""
    return f"{'' if side == EITHER else f' to the {side}'}{lane}"
