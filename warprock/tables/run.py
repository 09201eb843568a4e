"""What `run` prints: every lane of a small run, counts and ranges of a large one."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from rich.console import Console
from rich.table import Table

from warprock.case.axes import lane_indices
from warprock.case.columns import Columns
from warprock.case.input_columns import columns_of
from warprock.case.round_base import round_base_note
from warprock.findings.digits import number_of, quantity_of, short_heading
from warprock.findings.numbers import three
from warprock.findings.sheets import heading
from warprock.model.drift import drift_text
from warprock.model.response import Status
from warprock.model.runnable import HIGHEST_STACK
from warprock.model.undecided import cut_text
from warprock.running.case_run import CaseRun
from warprock.running.lane_table import PEAK_RATIO, run_columns
from warprock.running.provenance import count_words
from warprock.settings.engines import has_time_step
from warprock.tables.swept import drawn_inputs, swept_axes
from warprock.tables.terminal import (
    cell_text,
    plain_table,
    print_table,
    say,
    stdout,
)
from warprock.units import ending, split_unit

LANES_SHOWN = 24
"""Lanes up to which `run` prints every one; a larger run prints counts and ranges."""

OUTSIDE = (
    "outside_model: there the block needs more friction than it has, and would slide, or its base "
    "would have to pull it (inf); with -e event it may slide and leave its base"
)
"""What is said of lanes outside Housner's model."""

OUTSIDE_PRESCRIBED = (
    "outside_model: there the angular restitution that the case prescribes needs more friction "
    "than there is, or the base would have to pull the block (inf); its impacts are as near to it "
    "as friction lets them"
)
"""What is said where an engine with a time step cannot follow prescribed impacts."""


class Result(NamedTuple):
    """A result of a lane as `run` shows it: with the digits and the heading of its column.

    Attributes:
        column: Column of the lane table, of a block without its number.
        per_block: Whether each block of a stack has its own.
        text: A value of the column as it is shown, where its digits are not those of the column.
        words: Whether its values are words.
    """

    column: str
    per_block: bool = False
    text: Callable[[Any], str] | None = None
    words: bool = False

    @property
    def heading(self) -> str:
        """What it is called, with its unit, in short lines."""
        return RATIO_HEADING if self.column == PEAK_RATIO else short_heading(self.column)

    def cells(self, values: npt.NDArray[Any]) -> list[str]:
        """Values of the column as they are shown."""
        return [
            number_of(self.column, value) if self.text is None else self.text(value)
            for value in values.tolist()
        ]


RATIO_HEADING = "peak /\nslend.\nangle"


def _slide(value: float) -> str:
    """A slide in mm; what is below a nanometre is round-off."""
    return "0" if abs(value) < 1e-9 else number_of("peak_slide_m", value)


def _word(value: Any) -> str:
    return str(value).replace("_", " ")


RESULTS = (
    Result("peak_rotation_rad", per_block=True),
    Result(PEAK_RATIO, per_block=True, text=three),
    Result("outcome", text=_word, words=True),
    Result("status", text=_word, words=True),
    Result("collapse_time_s"),
    Result("peak_displacement_m"),
    Result("opened_joints"),
    Result("slid_joints"),
    Result("broken_joints"),
    Result("peak_slide_m", per_block=True, text=_slide),
    Result("peak_tie_force_N"),
    Result("broken_ties"),
    Result("peak_rotation_across_rad", per_block=True),
    Result("peak_yaw_rad", per_block=True),
    Result("friction_needed", text=three),
    Result("rest_time_s"),
    Result("peak_time_s", per_block=True),
    Result("impact_count"),
    Result("rotation_error_rad", per_block=True),
)
"""What is shown of a lane, the most wanted first: the last gives way where there is no room."""


class Column(NamedTuple):
    """A column of what is printed: its heading, and the text of each lane."""

    heading: str
    cells: list[str]
    left: bool = False


def print_run(run: CaseRun, console: Console | None = None) -> None:
    """Prints a run: every lane of a small one, counts and ranges of a large one.

    Args:
        run: The run.
        console: Where to; the terminal if not given.
    """
    out = console or stdout()
    response = run.response
    table = run_columns(run.lane_set, response)
    count = response.lane_count
    title = f"{run.case.name}: {response.engine}, {count:,} {'lane' if count == 1 else 'lanes'}"
    if count == 1:
        _print_one(out, title, table)
    elif count <= LANES_SHOWN:
        _print_lanes(out, title, run, table)
    else:
        _print_ranges(out, title, table)
        say(out, "every lane is in the files of -o DIR")
    _print_notes(out, run, table)


def _shown(table: Columns) -> Iterator[tuple[Result, str, str]]:
    """The results that a table has, with their columns and headings, block by block."""
    for result in RESULTS:
        if result.column in table:
            yield result, result.column, result.heading
        elif result.per_block:
            for block in range(1, HIGHEST_STACK + 1):
                stem, unit = split_unit(result.column)
                column = f"{stem}_{block}{ending(unit)}"
                if column in table:
                    yield result, column, f"block {block}\n{result.heading}"


def _print_one(out: Console, title: str, table: Columns) -> None:
    """A run of one lane: a line for each result."""
    out.print(title, style="bold", highlight=False)
    for result, column, head in _shown(table):
        name = " ".join(head.replace("slend.", "slenderness").split())
        text = result.cells(table[column])[0]
        say(out, f"  {name:<30} {text}")


def _print_lanes(out: Console, title: str, run: CaseRun, table: Columns) -> None:
    """A small run: a row a lane, with as many results as there is room for."""
    inputs = [Column("lane", [str(lane) for lane in table["lane"].tolist()]), *_inputs(run, table)]
    results = []
    for result, column, head in _shown(table):
        if column == "status" and table.among(column, ["ok"]).all():
            continue
        results.append(Column(head, result.cells(table[column]), result.words))
    shown = list(results)
    while len(shown) > 1 and _width(made := _table(title, [*inputs, *shown])) > out.width:
        shown.pop()
    made = _table(title, [*inputs, *shown])
    print_table(out, made)
    left = ", ".join(" ".join(column.heading.split()) for column in results[len(shown) :])
    if left:
        text = f"no room for: {left}; a wider terminal, or the files of -o DIR, have them"
        say(out, text)


def _inputs(run: CaseRun, table: Columns) -> list[Column]:
    """What tells the lanes apart."""
    shape, lanes = run.case.shape, range(run.response.lane_count)
    positions = lane_indices(shape, lanes)
    found = []
    for axis in swept_axes(run.case):
        at = positions[axis.number]
        words = axis.texts
        for label, texts in axis.columns().items():
            left = bool(words) and "[" not in label
            found.append(Column(label, [texts[place] for place in at], left))
    for drawn in drawn_inputs(run.case):
        for name in columns_of(drawn.key) & set(table):
            label = heading(name).label.replace(" [", "\n[")
            found.append(Column(label, [_drawn(value) for value in table[name].tolist()]))
    return found


def _drawn(value: Any) -> str:
    return three(value) if isinstance(value, float) else cell_text(value)


def _table(title: str, columns: Sequence[Column]) -> Table:
    made = plain_table(
        title,
        [column.heading for column in columns],
        [column.heading for column in columns if column.left],
    )
    for cells in zip(*(column.cells for column in columns), strict=True):
        made.add_row(*cells)
    return made


def _width(table: Table) -> int:
    """Characters that a table needs where nothing in it wraps."""
    widths = 0
    for column in table.columns:
        cells = (str(column.header), *map(str, column.cells))
        widths += 1 + max(len(line) for cell in cells for line in cell.split("\n"))
    return widths


def _print_ranges(out: Console, title: str, table: Columns) -> None:
    """A large run: least, median and largest of every result, and the lane of the largest."""
    headings = ["", "least", "median", "largest", "in lane"]
    made = plain_table(title, headings, headings[:1])
    for result, column, head in _shown(table):
        if result.words or column.startswith(("friction_needed", "rotation_error")):
            continue
        values = table[column].astype(float)
        if np.isnan(values).all():
            continue
        name = " ".join(head.replace("slend.", "slenderness").split())
        part = np.array([np.nanmin(values), np.nanmedian(values), np.nanmax(values)])
        most = int(np.nanargmax(values))
        made.add_row(name, *result.cells(part), str(table["lane"][most]))
    print_table(out, made)


def _print_notes(out: Console, run: CaseRun, table: Columns) -> None:
    """Counts of outcomes and statuses, and what limits the numbers."""
    response = run.response
    for name in ("outcome", "status"):
        counts = count_words(response, name)
        words = ", ".join(f"{count:,} {word}" for word, count in counts.items() if count)
        say(out, f"{name}: {words}")
    replaced = round_base_note(table)
    if replaced:
        say(out, replaced)
    motions = run.lane_set.motions
    for note in (cut_text(motions, run.lane_set.ends), drift_text(motions)):
        if note:
            say(out, note)
    if run.lane_set.scene.friction_note and has_time_step(run.settings):
        say(out, f"friction: {run.lane_set.scene.friction_note}")
    if "friction_needed" in response.fields and response.count(Status.OUTSIDE_MODEL):
        say(out, OUTSIDE_PRESCRIBED if has_time_step(run.settings) else OUTSIDE)
    say(out, f"wall time: {quantity_of('wall_time_s', run.wall_time)}")
