"""What an overturning map came to."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd

from warprock.analysis.overturning import AMPLITUDE, FREQUENCY, Mode, OverturningMap
from warprock.findings.asked import group_labels
from warprock.findings.digits import number_of, quantity_of, value_of
from warprock.findings.finding import Facts, Finding, Kind, Tables
from warprock.findings.lanes import lane_sheet
from warprock.findings.numbers import counted, even_selection, listed, three
from warprock.findings.sheets import Heading, Sheet, declared, sheet_of
from warprock.running.lane_table import lane_table
from warprock.running.provenance import provenance
from warprock.running.run_file import COUNTS, OF_CASE
from warprock.units import GRAVITY

COLUMNS_SHOWN = 12
"""Frequencies of a group whose modes stand in the table to read."""

BOUNDARY_COLUMNS: dict[str, tuple[str, str]] = {
    "group": ("-", "Labels of the case"),
    "frequency_hz": ("Hz", "Frequency of the pulse"),
    "frequency_ratio": ("-", "Angular frequency of the pulse / frequency parameter of the block"),
    "acceleration_ratio": ("-", "Peak acceleration / (g tan(slenderness angle))"),
    "acceleration_ratio_low": ("-", "The same, where the mode is still that below"),
    "acceleration_ratio_high": ("-", "The same, where the mode is that above"),
    "peak_acceleration_m_s2": ("m/s^2", "Peak acceleration"),
    "below": ("-", "Mode below"),
    "above": ("-", "Mode above"),
}
GRID_COLUMNS: dict[str, tuple[str, str]] = {
    "frequency_ratio": BOUNDARY_COLUMNS["frequency_ratio"],
    "mode": ("-", "What the pulse does to the block"),
}
FATAL = {
    Mode.WITHOUT_IMPACT.text: "without an impact",
    Mode.WITH_IMPACT.text: "after an impact",
}
"""Modes of blocks that overturn, and how a sentence says them."""


def map_facts(found: OverturningMap) -> dict[str, Any]:
    """What ran and what came of it, ready for JSON."""
    counts = np.bincount(found.mode.ravel(), minlength=len(Mode))
    return provenance(found.run) | {
        "groups": list(found.groups),
        "grid_lanes": found.run.lane_set.lanes.lane_count,
        "lanes_run": found.lanes_run,
        "stages": found.stages,
        "boundary_accuracy": found.accuracy,
        "modes": {mode.text: int(count) for mode, count in zip(Mode, counts, strict=True)},
        "boundaries": len(found.boundaries),
        "decided_after_s": found.decided_after,
        "wall_time_s": found.wall_time,
    }


def map_tables(found: OverturningMap) -> dict[str, pd.DataFrame]:
    """The lane table of the grid, with `frequency_ratio` and `mode`, and the boundaries."""
    table = lane_table(found.run.lane_set, found.run.response)
    rate = 2.0 * np.pi * table["frequency_hz"] / table["frequency_parameter_rad_s"]
    words = pd.Index([mode.text for mode in Mode])
    mode = pd.Categorical.from_codes(found.lane_mode, words)
    grid = declared(table.assign(frequency_ratio=rate, mode=mode), GRID_COLUMNS)
    return {"grid": grid, "boundaries": declared(found.boundaries.copy(), BOUNDARY_COLUMNS)}


def find_map(found: OverturningMap) -> Finding:
    """What a map came to."""
    return tell_map(map_facts(found), map_tables(found))


def tell_map(facts: Facts, tables: Tables) -> Finding:
    """What a map came to, of its facts and tables."""
    boundaries = tables["boundaries"]
    grid = tables["grid"].assign(group=group_labels(facts, tables["grid"], FREQUENCY, AMPLITUDE))
    return Finding(
        kind="Overturning map",
        facts=facts,
        tables=tables,
        sentences=_sentences(facts, grid, boundaries),
        sheets=[
            *(_mode_sheet(group, rows, boundaries) for group, rows in _groups(grid)),
            sheet_of("Boundaries", boundaries, file="boundaries.csv", folded=True),
            lane_sheet(
                facts,
                tables["grid"],
                besides=("frequency_ratio", "mode"),
                file="grid.csv",
                folded=True,
            ),
        ],
        rows={"rows": "boundaries"},
        asked=[("Boundaries", f"to {value_of(facts, 'boundary_accuracy')} of their strength")],
        pictures=["map*.png"],
    )


def _groups(grid: pd.DataFrame) -> list[tuple[str, pd.DataFrame]]:
    return [(str(name), rows) for name, rows in grid.groupby("group", sort=False)]


def _sentences(facts: Facts, grid: pd.DataFrame, boundaries: pd.DataFrame) -> list[str]:
    """The weakest pulse that overturns, the modes of the grid, and how it was refined."""
    weakest = _weakest(grid, boundaries)
    assembly = "collapse_time_s" in grid
    noun, fells, fell_it = (
        ("assembly", "brings the assembly down", "bring it down")
        if assembly
        else ("block", "overturns the block", "overturn it")
    )
    if weakest.empty:
        found = [f"No pulse of the map {fells}."]
    else:
        first = weakest.iloc[int(weakest["acceleration_ratio"].argmin())]
        where = f" ({first['group']})" if first["group"] else ""
        found = [f"The weakest pulse that {fells}{where} has {_pulse(first)}."]
    if len(weakest) > 1:
        texts = [f"{row['group']}: {_pulse(row)}" for _, row in weakest.iterrows()]
        found.append(f"The weakest of each group: {'; '.join(texts)}.")
    said = {
        Mode.SAFE.text: f"leave the {noun} standing",
        **{mode: f"{fell_it} {how}" for mode, how in FATAL.items()},
        Mode.NO_NUMBER.text: "have no usable number",
        Mode.UNDECIDED.text: "are undecided",
    }
    modes = facts["modes"]
    counts = [f"{modes[mode]:,} {words}" for mode, words in said.items() if modes.get(mode)]
    found.append(f"Of the {facts['grid_lanes']:,} pulses of the grid {listed(counts)}.")
    more = facts["lanes_run"] - facts["grid_lanes"]
    found.append(
        f"{counted(facts['boundaries'], 'boundary', 'boundaries')} between the modes were found, "
        f"each to {value_of(facts, 'boundary_accuracy')} of its strength, by "
        f"{counted(more, 'more lane')} in "
        f"{counted(facts['stages'], 'batch', 'batches')}."
    )
    if facts["decided_after_s"] is not None:
        count = modes[Mode.UNDECIDED.text]
        undecided = counted(count, "lane") if count else "lanes between those of the grid"
        decided = quantity_of("decided_after_s", facts["decided_after_s"])
        found.append(
            f"Undecided: {undecided} in which the {noun} had not fallen by the end of the run, "
            f"{quantity_of('duration_s', facts['duration_s'])}, but still moved or was still "
            f'shaken; with -s run.duration="{decided}" none is undecided.'
        )
    return found


def _weakest(grid: pd.DataFrame, boundaries: pd.DataFrame) -> pd.DataFrame:
    """The weakest pulse that overturns, of each group: at a boundary, or a lane of the grid."""
    lanes = grid.rename(columns={"normalised_acceleration": "acceleration_ratio", "mode": "above"})
    columns = ["group", "frequency_hz", "acceleration_ratio", "peak_acceleration_m_s2", "above"]
    parts = [rows.loc[rows["above"].isin(FATAL), columns] for rows in (boundaries, lanes)]
    falls = pd.concat([part.astype({"above": object}) for part in parts if len(part)] or parts)
    falls = falls.reset_index(drop=True)
    return falls.loc[falls.groupby("group", sort=False)["acceleration_ratio"].idxmin()]


def _pulse(row: pd.Series[Any]) -> str:
    return (
        f"{three(float(row['acceleration_ratio']))} g tan(slenderness angle), "
        f"{three(float(row['peak_acceleration_m_s2']) / GRAVITY)} g at "
        f"{three(float(row['frequency_hz']))} Hz, {FATAL[row['above']]}"
    )


def _mode_sheet(group: str, grid: pd.DataFrame, boundaries: pd.DataFrame) -> Sheet:
    """The modes from the weakest lane up, and where they change, at some of the frequencies."""
    columns = [rows.sort_values("normalised_acceleration") for _, rows in
               grid.groupby("frequency_ratio")]  # fmt: skip
    mine = boundaries[boundaries["group"] == group]
    rows = []
    for lanes in even_selection(columns, COLUMNS_SHOWN):
        ratio = float(lanes["frequency_ratio"].iloc[0])
        known = lanes["mode"][lanes["mode"] != Mode.NO_NUMBER.text]
        changes = mine[np.isclose(mine["frequency_ratio"], ratio, rtol=1e-12, atol=0.0)]
        pairs = zip(changes["acceleration_ratio"], changes["above"], strict=True)
        texts = [str(known.iloc[0]) if len(known) else Mode.NO_NUMBER.text]
        texts += [f"{number_of('acceleration_ratio', at)} {to}" for at, to in pairs]
        rows.append([number_of("frequency_ratio", ratio), ", ".join(texts)])
    note = f"{COLUMNS_SHOWN} of {len(columns)} frequencies; all are in boundaries.csv."
    return Sheet(
        f"Modes by strength{f': {group}' if group else ''}",
        [
            Heading("omega_p/p", "", BOUNDARY_COLUMNS["frequency_ratio"][1]),
            Heading("a_p / (g tan alpha) and the mode from there on", "", ""),
        ],
        rows,
        note if len(columns) > COLUMNS_SHOWN else "",
    )


MAP = Kind(
    ("boundaries", "grid"),
    tell_map,
    "modes",
    {
        **OF_CASE,
        "modes": COUNTS,
        "grid_lanes": int,
        "lanes_run": int,
        "boundaries": int,
        "stages": int,
        "boundary_accuracy": float,
        "decided_after_s": (float, None),
        "duration_s": float,
    },
)
