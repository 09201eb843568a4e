"""A map of overturning: on the terminal, as JSON and as files."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
from rich.console import Console

from warprock.analysis.overturning import Mode, OverturningMap
from warprock.model.words import lane_count_text
from warprock.running.lane_table import lane_table
from warprock.running.provenance import provenance
from warprock.tables.report import Report
from warprock.tables.terminal import plain_table, print_table, say, stdout
from warprock.units import GRAVITY

COLUMNS_SHOWN = 12
"""Frequencies of a group whose boundaries are printed."""

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


def grid_table(found: OverturningMap) -> pd.DataFrame:
    """The lane table of the grid, with `frequency_ratio` and `mode`."""
    table = lane_table(found.run.lane_set, found.run.response)
    rate = 2.0 * np.pi * table["frequency_hz"] / table["frequency_parameter_rad_s"]
    words = pd.Index([mode.text for mode in Mode])
    mode = pd.Categorical.from_codes(found.lane_mode, words)
    named = table.assign(frequency_ratio=rate, mode=mode)
    named.attrs["columns"] = table.attrs["columns"] | {
        "frequency_ratio": {"unit": "-", "text": BOUNDARY_COLUMNS["frequency_ratio"][1]},
        "mode": {"unit": "-", "text": "What the pulse does to the block"},
    }
    return named


def map_facts(found: OverturningMap) -> dict[str, Any]:
    """What ran and what came of it, ready for JSON."""
    counts = np.bincount(found.mode.ravel(), minlength=len(Mode))
    return provenance(found.run) | {
        "groups": list(found.groups),
        "grid_lanes": found.run.lane_set.lanes.lane_count,
        "lanes_run": found.lanes_run,
        "stages": found.stages,
        "tolerance": found.tolerance,
        "modes": {mode.text: int(count) for mode, count in zip(Mode, counts, strict=True)},
        "boundaries": len(found.boundaries),
        "decided_after_s": found.decided_after,
        "wall_time_s": found.wall_time,
    }


def map_report(found: OverturningMap) -> Report:
    """What a map has to show; its files are the lanes of the grid, the boundaries, and what ran."""
    boundaries = found.boundaries.copy()
    boundaries.attrs["columns"] = {
        name: {"unit": unit, "text": text} for name, (unit, text) in BOUNDARY_COLUMNS.items()
    }
    facts = map_facts(found)
    return Report(
        json={**facts, "rows": boundaries.to_dict("records")},
        tables={"grid": grid_table(found), "boundaries": boundaries},
        facts=facts,
        show=lambda: print_map(found),
        came_out=_sentence(found),
    )


def _sentence(found: OverturningMap) -> str:
    """The weakest pulse that overturns the block."""
    fatal = (Mode.WITHOUT_IMPACT.text, Mode.WITH_IMPACT.text)
    fell = found.boundaries[found.boundaries["above"].isin(fatal)]
    if fell.empty:
        return "No pulse of the map overturns the block."
    weakest = fell.sort_values("acceleration_ratio").iloc[0]
    return (
        f"The weakest pulse that overturns the block has {weakest['acceleration_ratio']:.3g} times "
        f"the acceleration that lifts it, {weakest['peak_acceleration_m_s2'] / GRAVITY:.3g} g at "
        f"{weakest['frequency_hz']:.3g} Hz."
    )


def print_map(found: OverturningMap, console: Console | None = None) -> None:
    """Prints where the modes change, at an even selection of the frequencies.

    Args:
        found: The map.
        console: Where to; the terminal if not given.
    """
    out = console or stdout()
    facts = map_facts(found)
    headings = ["omega_p / p", "a_p / (g tan alpha): what becomes of the block from there on"]
    for number, group in enumerate(found.groups):
        title = f"{found.run.case.name}, {found.run.response.engine}" + (
            f": {group}" if group else ""
        )
        table = plain_table(title, headings, headings[1:])
        ratios = found.frequency_ratio[number]
        last = len(ratios) - 1
        for column in np.unique(np.linspace(0, last, min(COLUMNS_SHOWN, last + 1)).astype(int)):
            table.add_row(f"{ratios[column]:.4g}", column_text(found, number, int(column)))
        print_table(out, table)
        if last + 1 > COLUMNS_SHOWN:
            say(
                out,
                f"  {COLUMNS_SHOWN} of {last + 1} frequencies; all are in boundaries.csv of -o DIR",
            )
    counts = ", ".join(f"{count:,} {mode}" for mode, count in facts["modes"].items() if count)
    out.print(f"grid of {lane_count_text(facts['grid_lanes'])}: {counts}", highlight=False)
    out.print(
        f"{facts['boundaries']:,} boundaries, each within a part {found.tolerance:g} of its "
        f"strength, by {facts['lanes_run'] - facts['grid_lanes']:,} more lanes in {found.stages} "
        f"batches; {found.wall_time:.1f} s",
        highlight=False,
    )
    unknown = facts["modes"][Mode.UNDECIDED.text]
    if facts["decided_after_s"] is not None:
        say(
            out,
            f"undecided: {lane_count_text(unknown)} in which the block had not fallen by the end "
            f"of the run, {facts['duration_s']:g} s, but still moved or was still shaken; "
            f'with -s run.duration="{facts["decided_after_s"]:g} s" none is undecided',
        )


def column_text(found: OverturningMap, group: int, column: int) -> str:
    """The modes of a column from its weakest lane up, and where they change."""
    rows = found.boundaries
    ratio = found.frequency_ratio[group, column]
    mine = rows[(rows["group"] == found.groups[group]) & (rows["frequency_ratio"] == ratio)]
    first = found.mode[group, column]
    known = first[first != Mode.NO_NUMBER]
    start = Mode(int(known[0])) if len(known) else Mode.NO_NUMBER
    changes = [
        f"{at:.4f} {above}"
        for at, above in zip(mine["acceleration_ratio"], mine["above"], strict=True)
    ]
    return ", ".join([start.text, *changes])
