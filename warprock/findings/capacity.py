"""What blocks bear that are led outwards, by statics."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd

from warprock.analysis.statics import EITHER, Statics
from warprock.analysis.statics_beside import Beside
from warprock.findings.asked import naming_columns
from warprock.findings.finding import Facts, Finding, Kind, Tables
from warprock.findings.lanes import lane_name
from warprock.findings.numbers import counted, three
from warprock.findings.plain import plain
from warprock.findings.sheets import declared, sheet_of
from warprock.model.response import Outcome
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
BESIDE_COLUMNS = {
    "base_multiplier_ratio": ("-", "Largest base acceleration of the motion over multiplier g"),
    "base_velocity_ratio": ("-", "Largest base velocity of the motion over the step of velocity"),
    "rotation_capacity_ratio": ("-", "Largest rotation under the motion over the capacity"),
    "outcome": ("", "What became of the lane under its motion"),
    "usable": ("", "Whether the numbers under the motion may be used"),
}
"""Columns besides, where the lanes ran, too."""


def find_capacity(found: Statics, beside: Beside | None = None) -> Finding:
    """What the statics of a case came to.

    Args:
        found: The statics.
        beside: What became of the lanes under their motions; None where they did not run.
    """
    table, bears = capacity_table(found, beside), found.found
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


def capacity_table(found: Statics, beside: Beside | None = None) -> pd.DataFrame:
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
    if beside is None:
        return declared(table, COLUMNS)
    names = np.array([outcome.name.lower() for outcome in Outcome])
    table = table.assign(
        base_multiplier_ratio=beside.acceleration_ratio(found),
        base_velocity_ratio=beside.velocity_ratio(found),
        rotation_capacity_ratio=beside.rotation_ratio(found),
        outcome=names[beside.outcome[found.lane]],
        usable=beside.usable[found.lane],
    )
    return declared(table, COLUMNS | BESIDE_COLUMNS)


def tell_capacity(facts: Facts, tables: Tables) -> Finding:
    """What the statics of a case came to, of its facts and its table."""
    table = tables[CAPACITY]
    return Finding(
        kind="Capacity",
        facts=facts,
        tables=tables,
        sentences=[*beside_sentences(table), *_sentences(facts, table)],
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


def weakest_sides(table: pd.DataFrame) -> pd.DataFrame:
    """A row a lane: the side to which statics lets it go first, without unusable numbers."""
    usable = table[table["usable"]]
    return usable.loc[usable.groupby("lane")["multiplier"].idxmin()]


def beside_sentences(table: pd.DataFrame) -> list[str]:
    """How far statics and dynamics are apart; nothing where the lanes did not run."""
    if "base_multiplier_ratio" not in table or not table["usable"].any():
        return []
    lanes = weakest_sides(table)
    fell, beyond = lanes["outcome"] == "overturned", lanes["base_multiplier_ratio"] > 1.0
    said = [
        f"In {int(beyond.sum())} of {counted(len(lanes), 'lane')} the base accelerates beyond the "
        f"static multiplier, and {int((beyond & fell).sum())} of these overturn."
    ]
    if fell.any() and not fell.all():
        for name, what in (
            ("base_multiplier_ratio", "acceleration is {} times the multiplier"),
            ("base_velocity_ratio", "velocity is {} times the step that overturns"),
        ):
            low, high = lanes.loc[fell, name].min(), lanes.loc[~fell, name].max()
            said.append(
                f"None overturns before the base's {what.format(three(float(low)))}; one still "
                f"stands at {three(float(high))} times."
            )
    return said


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
