"""A study on the terminal: errors and cost of every setting."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.table import Table

from warprock.case.case import Case
from warprock.case.load import load_case
from warprock.case.study import Study
from warprock.findings.digits import number_of, quantity_of, short_heading, value_of
from warprock.findings.numbers import MISSING
from warprock.tables.compare import reasons
from warprock.tables.terminal import plain_table, stdout
from warprock.verification.housner import EARLY_TIME

if TYPE_CHECKING:
    from warprock.verification.study import StudyRun

Row = Mapping[str, Any]


LANES_APART = 2
"""Lanes of a study up to which each has columns of its own."""


def print_study(out: Console, rows: Sequence[Row], case: Case) -> None:
    """Errors and cost of every setting, a table an engine; nothing where there are no rows.

    Args:
        out: Where to.
        rows: Rows that have a `setting` are those of `study.StudyRun.table`; others are left out.
        case: The case of the study.
    """
    found = [row for row in rows if row.get("setting") is not None]
    if not found or case.study is None:
        return
    for engine in dict.fromkeys(row["engine"] for row in found):
        mine = [row for row in found if row["engine"] == engine]
        lanes = {row["lane"]: row["lane_name"] for row in mine}
        out.print(_study_table(mine, case))
        for line in _baseline(case.study, engine):
            out.print(f"  {line}", highlight=False)
        out.print()
    time = quantity_of("duration_s", case.sample_times.duration)
    lines = [
        f"{' and '.join(_spans(case))}: largest |rotation - Housner's| / slenderness angle in that "
        "time.",
        f"CPU: for {time} of one lane on one core, one lane a thread.",
    ]
    if any(value_of(row, "rest_time_error_s") != MISSING for row in found):
        lines.append("rest: time of coming to rest less Housner's [s], where both rest in time.")
    if len(lanes) > LANES_APART:
        lines.append("peak: largest rotation / slenderness angle.")
        lines.append(f"The largest of {len(lanes)} lanes each, those where Housner holds.")
    elif len(lanes) > 1:
        lines.append("; ".join(f"lane {lane}: {name}" for lane, name in lanes.items()))
    for lane, name in lanes.items():
        peaks = {value_of(row, "peak_rotation_ratio") for row in found if row["lane"] == lane}
        if len(peaks) == 1 and len(lanes) <= LANES_APART:
            lines.append(f"Peak rotation / slenderness angle of {name}: {peaks.pop()} in all runs.")
    for line in lines + _where_housner_fails(found):
        out.print(f"  {line}", highlight=False)
    out.print()


def print_studies(out: Console, rows: Sequence[Row]) -> None:
    """The studies of shipped cases that are among the rows of a reproduction.

    Args:
        out: Where to.
        rows: Rows; those of a study have the name of its `case`.
    """
    for name in dict.fromkeys(row["case"] for row in rows if row.get("setting") is not None):
        print_study(out, [row for row in rows if row.get("case") == name], load_case(name))


def print_study_run(found: StudyRun, console: Console | None = None) -> None:
    """Prints the tables of a study that was run.

    Args:
        found: The study.
        console: Where to; the terminal if not given.
    """
    out = console or stdout()
    out.print(f"{found.case.name}: {found.case.title}", style="bold", highlight=False)
    out.print()
    print_study(out, found.rows, found.case)
    out.print(f"wall time: {quantity_of('wall_time_s', found.wall_time)}", highlight=False)


def setting_name(setting: str, unit: str) -> str:
    """A setting as the case file writes it, with its unit."""
    return setting if unit in ("-", "1/s") else f"{setting} [{unit}]"


def _spans(case: Case) -> list[str]:
    """Times that the errors cover: the early one, where the run is longer, and the run."""
    duration = case.sample_times.duration
    early = [quantity_of("duration_s", EARLY_TIME)] if duration > EARLY_TIME else []
    return [*early, quantity_of("duration_s", duration)]


def _study_columns(
    rows: Sequence[Row], case: Case
) -> list[tuple[str, Callable[[Mapping[int, Row]], str]]]:
    """Headings of the columns of numbers, and what they say of the rows of one run."""
    errors = ("error_5s_ratio", "error_run_ratio")[-len(_spans(case)) :]
    measures = [*zip(errors, _spans(case), strict=True)]
    measures += [("peak_rotation_ratio", "peak"), ("rest_time_error_s", "rest")]
    lanes = list(dict.fromkeys(row["lane"] for row in rows))
    apart = len(lanes) <= LANES_APART
    columns = []
    for of in [[lane] for lane in lanes] if apart else [lanes]:
        where = f"\nlane {of[0]}" if apart and len(lanes) > 1 else ""
        for column, heading in measures:
            texts = {value_of(row, column) for row in rows if row["lane"] in of}
            same = column == "peak_rotation_ratio" and apart and len(texts) == 1
            if texts != {MISSING} and not same:
                columns.append((heading + where, _largest(column, of)))
    return columns


def _largest(column: str, lanes: Sequence[int]) -> Callable[[Mapping[int, Row]], str]:
    """Text of the largest value of a column among some lanes of a run.

    Of several lanes those count where Housner holds; one alone is shown whatever it is.
    """

    def cell(run: Mapping[int, Row]) -> str:
        held = [lane for lane in lanes if run[lane]["holds"] or len(lanes) == 1]
        values = [run[lane][column] for lane in held]
        known = [value for value in values if number_of(column, value) != MISSING]
        return number_of(column, max(known, key=abs) if known else None)

    return cell


def _study_table(rows: Sequence[Row], case: Case) -> Table:
    """The table of one engine."""
    columns = _study_columns(rows, case)
    table = plain_table(
        f"{rows[0]['engine']}: one setting at a time, against Housner",
        [
            "setting",
            "value",
            short_heading("time_step_s"),
            *(head for head, _ in columns),
            short_heading("cpu_s"),
        ],
        ("setting",),
    )
    runs: dict[tuple[str, float], dict[int, Row]] = {}
    for row in rows:
        runs.setdefault((row["setting"], row["value"]), {})[row["lane"]] = row
    last = None
    for (setting, value), run in runs.items():
        one = next(iter(run.values()))
        if last is not None and last != setting:
            table.add_section()
        table.add_row(
            setting_name(setting, one["unit"]) if last != setting else "",
            f"{number_of('value', value)}{'*' if one['baseline'] else ' '}",
            value_of(one, "time_step_s"),
            *(cell(run) for _, cell in columns),
            value_of(one, "cpu_s"),
        )
        last = setting
    return table


def _baseline(study: Study, engine: str) -> list[str]:
    """Where an engine's settings stay, and what it has not."""
    plan = study.plan(engine)
    own = ", ".join(
        f"{row['setting']} {number_of('value', row['baseline'])}" for row in plan["vary"]
    )
    lines = [f"*: the case's own, where a setting stays while another varies: {own}"]
    if plan["lacks"]:
        lines.append(f"{engine} has no {' and no '.join(plan['lacks'])}.")
    return lines


def _where_housner_fails(rows: Sequence[Row]) -> list[str]:
    """Lanes in whose errors Housner has a part, and why, a line an engine."""
    lines = []
    lane_count = len({row["lane"] for row in rows})
    for engine in dict.fromkeys(row["engine"] for row in rows):
        failing = [row for row in rows if row["engine"] == engine and not row["holds"]]
        lanes = {row["lane"] for row in failing}
        clauses = dict.fromkeys(clause for row in failing for clause in reasons(row["why"]))
        if lanes:
            where = f"{len(lanes)} of {lane_count} lanes"
            lines.append(f"{engine}: Housner does not hold in {where}: {'; '.join(clauses)}")
    return lines
