"""The lanes of a run as a page names, judges and lists them."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from warprock.case.columns import Columns, Table
from warprock.case.input_columns import columns_of
from warprock.findings import asked
from warprock.findings.digits import DIGITS, MEASURED
from warprock.findings.numbers import three
from warprock.findings.sheets import ROWS, Heading, Sheet, heading
from warprock.model.response import FALLEN_NAMES, USABLE_NAMES
from warprock.running.lane_table import JOINT_COLUMNS, PEAK_RATIO
from warprock.units import ending, split_unit

TIES = ("peak_tie_force_N", "broken_ties", "tie_break_time_s", "tie_energy_lost_J")
"""Results of a lane with ties."""
JOINTS = (
    *("collapse_time_s", "peak_displacement_m", "residual_displacement_m", "peak_opening_m"),
    *("opened_joints", "slid_joints", "broken_joints"),
)
"""Results of a lane that is an assembly."""
SAID = ("collapse_load", "tilt_rate_deg_s", *JOINT_COLUMNS)
"""Columns of assemblies that sentences need."""
RESULTS = ("outcome", "status", *JOINTS, "impact_count", "rest_time_s", "friction_needed", *TIES)
"""Results of a lane that a page shows."""


def needed(facts: Mapping[str, Any]) -> str:
    """A pattern of the columns of the lane table that a page needs."""
    swept = [name for key in asked.swept_keys(facts["case"]) for name in columns_of(key)]
    names = "|".join(map(re.escape, ("lane", "member", *RESULTS, *SAID, *swept)))
    names += r"|(diameter|height)(_[1-9])?_m"
    return rf"^({names})$|^{PEAK_RATIO}|^peak_(rotation|time|slide)(_[1-9])?_|^rotation_error"


FAR = 2.0
"""Rotation over the slenderness angle beyond which a block is taken to fall."""


def numbers(table: Table, name: str) -> npt.NDArray[np.float64]:
    """A column of numbers, shape [row]."""
    return np.asarray(table[name], dtype=float)


def among(table: Table, name: str, words: Sequence[str]) -> npt.NDArray[np.bool_]:
    """Whether a column has one of some words, shape [row]."""
    if isinstance(table, Columns):
        return table.among(name, words)
    return np.asarray(table[name].isin(words))


def peak_ratio(table: Table) -> npt.NDArray[np.float64]:
    """Peak rotation / slenderness angle, of a stack the largest of its blocks, shape [lane]."""
    columns = [name for name in map(str, table) if name.startswith(PEAK_RATIO)]
    columns = [name for name in columns if not name.endswith("error")]
    ratios: npt.NDArray[np.float64] = np.max([numbers(table, name) for name in columns], axis=0)
    return ratios


def standing(table: Table) -> npt.NDArray[np.bool_]:
    """Lanes with usable numbers whose blocks stayed up, shape [lane].

    A block that was beyond `FAR` when its run ended was falling.
    """
    up = ~among(table, "outcome", FALLEN_NAMES)
    return up & among(table, "status", USABLE_NAMES) & (peak_ratio(table) <= FAR)


def falling(table: Table) -> int:
    """Lanes that still moved when their run ended, and were beyond `FAR`."""
    return int((among(table, "outcome", ["rocking"]) & (peak_ratio(table) > FAR)).sum())


def lane_name(facts: Mapping[str, Any], table: Table, row: int, thing: str = "lane") -> str:
    """A lane by number and by what sets it apart: `lane 8 (slip, frequency 3 Hz)`.

    Args:
        facts: What `run.json` holds.
        table: The lane table, or that of the cells of an ensemble.
        row: Number of its row.
        thing: What a row is, and the column of its number: lane or cell.
    """
    parts, given = [], asked.units_given(facts["case"])
    for name in asked.naming_columns(facts, table):
        value = np.asarray(table[name])[row]
        head = heading(name)
        if isinstance(value, str):
            parts.append(value)
        else:
            unit, size = given.get(name, (head.unit, 1.0))
            parts.append(f"{head.text} {three(size * float(value))} {unit}".strip())
    number = f"{thing} {int(np.asarray(table[thing])[row]):,}"
    return f"{number} ({', '.join(parts)})" if parts else number


def lane_sheet(
    facts: Mapping[str, Any],
    table: Table,
    *,
    besides: tuple[str, ...] = (),
    file: str,
    folded: bool = False,
) -> Sheet:
    """The lanes: what varies, what became of them, how far off they may be.

    Args:
        facts: What `run.json` holds.
        table: The lane table.
        besides: Columns that an analysis adds to it.
        file: Where all of it is.
        folded: Whether the reader has to open it.
    """
    shown, heads, cells = table.head(ROWS), [], []
    for head, name, factor in _columns(facts, table, besides):
        heads.append(head)
        values = np.asarray(shown[name])
        cells.append(
            [_cell(value) for value in (values if factor == 1.0 else factor * values).tolist()]
        )
    note = ""
    if len(shown) < len(table):
        note = f"The first {ROWS:,} of {len(table):,} lanes; all, with every column, are in {file}."
    lanes = [int(lane) for lane in shown["lane"]]
    return Sheet("Lanes", heads, list(zip(*cells, strict=True)), note, lanes, folded)


def _columns(
    facts: Mapping[str, Any], table: Table, besides: tuple[str, ...]
) -> Iterator[tuple[Heading, str, float]]:
    """Columns that a page shows of a lane table: heading, name, and factor on its numbers."""
    meanings = table.attrs.get("columns", {})
    peaks = [name for name in map(str, table) if name.startswith(PEAK_RATIO)]
    blocks = [name.removeprefix(PEAK_RATIO) for name in peaks]

    def of_block(block: str) -> Iterator[tuple[Heading | None, str, float]]:
        of = f" {block[1:]}" if block else ""
        yield Heading(f"peak rotation{of} / slenderness angle"), f"{PEAK_RATIO}{block}", 1.0
        yield _scaled(f"peak rotation{of}", "peak_rotation_rad", block)
        yield None, f"peak_time{block}_s", 1.0
        yield _scaled(f"peak slide{of}", "peak_slide_m", block)

    wanted: list[tuple[Heading | None, str, float]] = [(Heading("lane"), "lane", 1.0)]
    given = asked.units_given(facts["case"])
    for name in asked.naming_columns(facts, table):
        unit, size = given.get(name, ("", 1.0))
        wanted.append((Heading(heading(name).text, unit) if unit else None, name, size))
    wanted += [(None, name, 1.0) for name in besides]
    wanted += [column for block in blocks for column in of_block(block)]
    wanted += map(_as_said, RESULTS)
    for block in blocks:
        of = f" {block[1:]}" if block else ""
        wanted.append(_scaled(f"error of rotation{of}", "rotation_error_rad", block))
    for own, name, factor in wanted:
        if name in table:
            told = meanings.get(name, {})
            found = own or heading(name, "", told.get("unit", ""))
            yield Heading(found.text, found.unit, told.get("text", "")), name, factor


def _as_said(column: str) -> tuple[Heading | None, str, float]:
    """A column of a lane in the unit in which sentences say it: heading, column, and factor."""
    shown = DIGITS.get(column, MEASURED)
    if not shown.unit:
        return None, column, 1.0
    return Heading(heading(column).text, shown.unit), column, shown.size


def _scaled(name: str, column: str, block: str) -> tuple[Heading, str, float]:
    """A column of a block in the unit in which it is said: heading, column, and factor."""
    stem, unit = split_unit(column)
    shown = DIGITS[column]
    return Heading(name, shown.unit), f"{stem}{block}{ending(unit)}", shown.size


def _cell(value: Any) -> str:
    return value.replace("_", " ") if isinstance(value, str) else three(value)
