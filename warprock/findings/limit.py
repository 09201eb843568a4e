"""What limit analysis came to."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd

from warprock.analysis.load_limit import CONE_SIDES, Collapse, LoadLimits
from warprock.analysis.pushing import ACCURACY, Pushes
from warprock.case.assembly import BETWEEN
from warprock.case.input_columns import input_meaning
from warprock.findings.asked import naming_columns
from warprock.findings.digits import quantity_of, value_of
from warprock.findings.finding import Facts, Finding, Kind, Tables
from warprock.findings.lanes import lane_name
from warprock.findings.numbers import counted, listed, three
from warprock.findings.sheets import declared, heading, sheet_of
from warprock.running.lane_table import APART
from warprock.running.provenance import case_facts, surroundings
from warprock.running.run_file import CASE

LOAD_FACTOR, COULOMB, TILT = "load_factor", "coulomb_load_factor", "tilt_deg"
INNER, TOWARDS, TOWARDS_DEG = "inner_load_factor", "towards", "towards_deg"
COLUMNS: dict[str, tuple[str, str]] = {
    LOAD_FACTOR: (
        "-",
        "Sideways load / self-weight at which it collapses; nothing where it does not stand",
    ),
    COULOMB: (
        "-",
        "The same with Coulomb's law where joints slide; nothing where it was not looked for",
    ),
    TILT: ("deg", "Angle of a tilting table at which it collapses"),
    TOWARDS: ("-", "Side to which it is weaker: right is +x"),
    "upper_bound": ("-", "Whether joints slide, so that the load factor is an upper bound"),
    "opening": ("-", "Number of joints that open without sliding"),
    "sliding": ("-", "Number of joints that slide"),
    "opens": ("-", "Blocks between which joints open"),
    "slides": ("-", "Blocks between which joints slide"),
}
IN_SPACE = {
    TOWARDS_DEG: ("deg", "Direction of the load, from +x about the vertical towards +y"),
    INNER: ("-", "Load factor by pyramids in the cones of friction; the other is by those around"),
}
"""Columns in space: the direction instead of the side, and a load that is no more than the exact
one."""
PUSHED = "pushed_load_factor"
PUSHED_COLUMN = {
    PUSHED: (
        "-",
        "The same under a slow push, by simulation; nothing where it was not found",
    ),
}
"""The column besides, where assemblies were pushed."""
NAMES = ("opens", "slides")
"""Columns that the table to read goes without: names of many joints are in the file."""
MOST_NAMED = 8
"""Joints that a sentence names."""
BOUND = (
    "Where joints slide the load is an upper bound: limit analysis lets a joint open as it slides, "
    "which Coulomb's friction does not. The load with Coulomb's law is beside it; the assembly may "
    "fall anywhere from there to the bound."
)


CONE = (
    "In space friction is a pyramid of {sides} sides: around its cone for the upper load, in it "
    "for the lower one; the load of the cone lies between the two."
)


def limit_facts(found: LoadLimits, pushes: Pushes | None = None) -> dict[str, Any]:
    """What was asked and what came of it, ready for JSON."""
    lanes = found.lane
    stands = np.array([each.stands for each in found.collapses])[lanes]
    bounds = np.array([each.upper_bound for each in found.collapses])[lanes]
    return {
        "case": case_facts(found.case),
        **surroundings(found.case),
        "lanes": len(lanes),
        "standing": int(stands.sum()),
        "upper_bounds": int(bounds.sum()),
        "wall_time_s": found.wall_time,
        **_space_facts(found),
        **_push_facts(found, pushes),
    }


def _space_facts(found: LoadLimits) -> dict[str, Any]:
    """How loads were found in space; nothing in the plane."""
    if not found.spatial:
        return {}
    asked = None if found.asked is None else float(np.rad2deg(found.asked))
    return {"space": {"cone_sides": CONE_SIDES, "asked_deg": asked}}


def _push_facts(found: LoadLimits, pushes: Pushes | None) -> dict[str, Any]:
    """How assemblies were pushed; nothing where they were not."""
    if pushes is None:
        return {}
    borne = np.isinf(pushes.high)
    return {
        "push": {
            "engine": pushes.engine,
            "rise_s": pushes.rise,
            "hold_s": pushes.hold,
            "accuracy": ACCURACY,
            "runs": len(pushes.tried.factor),
            "unsound": int(pushes.unsound[found.lane].sum()),
            "borne": int(borne[found.lane].sum()),
        }
    }


def limit_table(found: LoadLimits, pushes: Pushes | None = None) -> pd.DataFrame:
    """The inputs of the lanes, and at which load each collapses and how."""
    inputs, lanes = found.lane_set.inputs, found.lane
    columns: dict[str, Any] = {"lane": np.arange(len(lanes))}
    columns |= {str(name): inputs[name].array for name in inputs.columns}
    table = declared(pd.DataFrame(columns), {name: input_meaning(name) for name in columns})
    looked = found.with_coulomb
    kinds = enumerate(found.collapses)
    rows = pd.DataFrame([_row(each, coulomb=place in looked) for place, each in kinds]).iloc[lanes]
    declarations = _columns(spatial=found.spatial)
    columns = {name: rows[name].to_numpy() for name in declarations}
    table = declared(table.assign(**columns), declarations)
    if pushes is None:
        return table
    return declared(table.assign(**{PUSHED: pushes.factor[lanes]}), PUSHED_COLUMN)


def _columns(*, spatial: bool) -> dict[str, tuple[str, str]]:
    """Columns of what came out, in their order."""
    if not spatial:
        return COLUMNS
    found = {LOAD_FACTOR: COLUMNS[LOAD_FACTOR], INNER: IN_SPACE[INNER]}
    rest = {name: each for name, each in COLUMNS.items() if name not in (LOAD_FACTOR, TOWARDS)}
    return found | {TOWARDS_DEG: IN_SPACE[TOWARDS_DEG]} | rest


def _row(collapse: Collapse, *, coulomb: bool) -> dict[str, Any]:
    named = {
        name: APART.join(_joints(collapse, getattr(collapse, name))) for name in ("opens", "slides")
    }
    factor = collapse.load_factor
    return {
        LOAD_FACTOR: factor,
        COULOMB: collapse.coulomb_load if coulomb else np.nan,
        TILT: np.rad2deg(np.arctan(factor)),
        TOWARDS: ("right" if collapse.direction == 0.0 else "left") * bool(np.isfinite(factor)),
        TOWARDS_DEG: np.rad2deg(collapse.direction),
        INNER: collapse.inner_load_factor,
        "upper_bound": collapse.upper_bound,
        "opening": int(collapse.opens.sum()),
        "sliding": int(collapse.slides.sum()),
        **named,
    }


def _joints(collapse: Collapse, chosen: np.ndarray[Any, np.dtype[np.bool_]]) -> list[str]:
    """Joints by the names of their blocks, each pair once."""
    names, joints = collapse.assembly.names, collapse.assembly.joints
    pairs = [BETWEEN.join(names[block] for block in pair) for pair in joints.blocks[chosen]]
    return list(dict.fromkeys(pairs))


def find_limit(found: LoadLimits, pushes: Pushes | None = None) -> Finding:
    """What limit analysis came to, and slow pushes beside it."""
    return tell_limit(limit_facts(found, pushes), {"limits": limit_table(found, pushes)})


def tell_limit(facts: Facts, tables: Tables) -> Finding:
    """What limit analysis came to, of its facts and table."""
    table = tables["limits"]
    own = [name for name in _columns(spatial="space" in facts) if name not in NAMES]
    shown = ["lane", *naming_columns(facts, table), *own]
    if PUSHED in table:
        shown.insert(shown.index(TILT), PUSHED)
    sheet = table[shown].copy()
    sheet.attrs = table.attrs
    return Finding(
        kind="Limit analysis",
        facts=facts,
        tables=tables,
        sentences=_sentences(facts, table),
        sheets=[sheet_of("Lanes", sheet, file="limits.parquet")],
        rows={"rows": "limits"},
        pictures=["mechanism*.png", "push.png"],
    )


LIMIT = Kind(
    ("limits",),
    tell_limit,
    "upper_bounds",
    {
        "case": CASE,
        "lanes": int,
        "standing": int,
        "upper_bounds": int,
        "space?": {"cone_sides": int, "asked_deg": (float, None)},
        "push?": {
            "engine": str,
            "rise_s": float,
            "hold_s": float,
            "accuracy": float,
            "runs": int,
            "unsound": int,
            "borne": int,
        },
    },
)


def _sentences(facts: Facts, table: pd.DataFrame) -> list[str]:
    """At which load, of how many lanes, and by which mechanism."""
    up = table[table[LOAD_FACTOR].notna()]
    if len(table) == 1:
        found = [_of_one(facts, table.iloc[0])]
    else:
        found = [_of_many(facts, table, up)]
        found += _where_it_stands(facts, table)
    found += _pushed(facts, table)
    if len(up):
        weakest = up.iloc[int(up[LOAD_FACTOR].argmin())]
        found += _mechanism(facts, table, weakest)
    if facts["upper_bounds"]:
        found.append(BOUND)
        found += [CONE.format(sides=facts["space"]["cone_sides"])] if "space" in facts else []
    return found


def _of_one(facts: Facts, row: pd.Series[Any]) -> str:
    factor = float(row[LOAD_FACTOR])
    if np.isnan(factor):
        return "The assembly does not carry its own weight."
    if np.isinf(factor):
        return "No sideways load brings the assembly to collapse."
    load, tilt = three(factor), three(float(row[TILT]))
    under, by = f"of {load}", tilt
    if row["upper_bound"]:
        under, by, lower = f"of at most {load}", f"at most {tilt}", float(row[COULOMB])
        if lower < (1.0 - SAME) * factor:
            least = three(float(np.rad2deg(np.arctan(lower))))
            under, by = f"between {three(lower)} and {load}", f"{least} to {tilt}"
    return (
        f"The assembly {_whither(facts, row)} under a sideways load {under} of its "
        f"weight, or on a table that tilts by {by} degrees."
    )


def _whither(facts: Facts, row: pd.Series[Any]) -> str:
    """To which side or in which direction it collapses."""
    if "space" not in facts:
        return f"collapses to the {row[TOWARDS]}"
    towards = f"{value_of(row, TOWARDS_DEG)} degrees (0 is +x, 90 is +y)"
    if facts["space"]["asked_deg"] is not None:
        return f"collapses towards {towards}"
    return f"is weakest towards {towards}: it collapses"


SAME = 1e-3
"""Relative difference from which two load factors are told apart."""


def _of_many(facts: Facts, table: pd.DataFrame, up: pd.DataFrame) -> str:
    standing = f"{facts['standing']:,} of {counted(len(table), 'assembly', 'assemblies')}"
    if not len(up):
        return f"{standing} carry their own weight."
    least, most = float(up[LOAD_FACTOR].min()), float(up[LOAD_FACTOR].max())
    bounds = facts["upper_bounds"]
    are = f"; {bounds:,} of these loads are upper bounds" if bounds else ""
    return (
        f"{standing} carry their own weight, and collapse under a sideways load of "
        f"{_range(least, most)} of it{are}."
    )


def _range(least: float, most: float) -> str:
    """Two loads in words, one where they read alike."""
    return f"{three(least)} to {three(most)}" if three(least) != three(most) else three(least)


def _where_it_stands(facts: Facts, table: pd.DataFrame) -> list[str]:
    """From which value of the one input that varies on it stands, or no more."""
    names = naming_columns(facts, table)
    if len(names) != 1 or not pd.api.types.is_numeric_dtype(table[names[0]]):
        return []
    ordered = table.sort_values(names[0])
    stands = ordered[LOAD_FACTOR].notna().to_numpy()
    change = np.flatnonzero(np.diff(stands.astype(int)))
    if len(change) != 1:
        return []
    head = heading(names[0])
    below, above = (
        f"{three(float(value))} {head.unit}".strip()
        for value in ordered[names[0]].iloc[[change[0], change[0] + 1]]
    )
    stood, fell = (below, above) if stands[0] else (above, below)
    return [f"With a {head.text} of {stood} it stands, with {fell} it does not."]


def _pushed(facts: Facts, table: pd.DataFrame) -> list[str]:
    """At which load slow pushes bring assemblies down, beside limit analysis."""
    if "push" not in facts:
        return []
    push, told = facts["push"], []
    known = table[table[PUSHED].notna()]
    rise, hold = three(push["rise_s"]), three(push["hold_s"])
    how = f"by a load that rises within {rise} s and stays for {hold} s (engine {push['engine']})"
    if len(known):
        least, most = float(known[PUSHED].min()), float(known[PUSHED].max())
        what = "it collapses" if len(table) == 1 else f"{len(known):,} of them collapse"
        at = _range(least, most)
        told.append(f"Pushed slowly, {how}, {what} at {at} of the weight, {_beside(known)}.")
    for count, what in (
        (push["unsound"], "a lane below the collapse has no usable number"),
        (push["borne"], "the largest load that was tried did not bring it down"),
    ):
        if count:
            where = "" if len(table) == 1 else f" for {counted(count, 'assembly', 'assemblies')}"
            told.append(f"Pushes found no load{where}: {what}.")
    return told


def _beside(known: pd.DataFrame) -> str:
    """How far the loads of pushes are from those of limit analysis."""
    pushed, most = known[PUSHED].to_numpy(), known[LOAD_FACTOR].to_numpy()
    least = np.fmin(known[COULOMB].to_numpy(dtype=float), most)
    away = np.maximum(np.maximum(least - pushed, pushed - most), 0.0) / pushed
    if not known["upper_bound"].any():
        return f"within {_percent(away.max())} of the load of limit analysis"
    if not (away > ACCURACY).any():
        return "in the interval of limit analysis"
    return f"up to {_percent(away.max())} outside the interval of limit analysis"


def _percent(part: float) -> str:
    """A share rounded upwards, not finer than pushes are found."""
    return quantity_of("limit_gap", np.ceil(1e3 * max(part, ACCURACY)) / 1e3)


def _mechanism(facts: Facts, table: pd.DataFrame, row: pd.Series[Any]) -> list[str]:
    """Which joints open and slide in a lane."""
    opens, slides = (
        [each for each in str(row[name]).split(APART) if each] for name in ("opens", "slides")
    )
    parts = []
    for joints, does in ((opens, "open"), (slides, "slide")):
        if joints:
            named = listed(joints[:MOST_NAMED])
            more = len(joints) - MOST_NAMED
            rest = f", and {more:,} more" if more > 0 else ""
            parts.append(f"joints {does} between {named}{rest}")
    if not parts:
        return []
    where = "" if len(table) == 1 else f", of {lane_name(facts, table, int(row['lane']))},"
    none = "" if slides else "; none slides"
    return [f"In the weakest mechanism{where} {' and '.join(parts)}{none}."]
