"""The sensitivity study, the run times and the families of programs on the terminal."""

from __future__ import annotations

import pathlib
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from rich.console import Console
from rich.table import Table

from warprock.case import Case, load_case
from warprock.case_study import Study
from warprock.comparison import EARLY_TIME
from warprock.report.paper import PAPER_NAMES
from warprock.report.tables import MISSING, number, plain_table, print_table, reasons, stdout

Row = Mapping[str, Any]

FAMILIES = (("bullet", "impulse"), ("vortex", "direct"), ("dem", "dem"))
"""Column of the paper, and our engine of the same family."""
LANES_APART = 2
"""Lanes of a study up to which each has columns of its own."""
PULSE_BOUND = 2.0
"""CPU time [s] that each engine may take for the pulse on the single block."""


def print_families(out: Console, rows: Sequence[Row]) -> None:
    """Table 6 by family: each program of the paper beside our engine of its kind.

    Args:
        out: Where to.
        rows: Those of Table 6; nothing is printed where they lack an engine.
    """
    peaks = {
        (row["source"], row["frequency_hz"], row["amplitude_mm"]): row["peak_rotation_ratio"]
        for row in rows
        if row["reading"] in ("displacement", "as printed")
    }
    sources = {source for source, _, _ in peaks}
    if not sources.issuperset(engine for _, engine in FAMILIES):
        return
    table = plain_table(
        "Table 6 by family, displacement drive: the paper's program,\n"
        "our engine of its kind, and how far they are apart",
        ["f\n[Hz]", "A\n[mm]"]
        + [
            text
            for name, engine in FAMILIES
            for text in (f"paper\n{PAPER_NAMES[name]}", engine, "[%]")
        ],
    )
    inputs = [key[1:] for key in peaks if key[0] == FAMILIES[0][1]]
    for key in inputs:
        cells = []
        for name, engine in FAMILIES:
            theirs, ours = peaks[f"paper-{name}", *key], peaks[engine, *key]
            off = 100.0 * (ours / theirs - 1.0)
            cells += [number(theirs, ".3f"), number(ours, ".4f"), number(off, "+.1f")]
        table.add_row(*(f"{value:g}" for value in key), *cells)
    print_table(out, table)
    out.print("  Default settings, of dem those of Table 5; nothing is fitted.", highlight=False)
    out.print()


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
            out.print(f"  {line}", markup=False, highlight=False)
        out.print()
    duration = case.sample_times.duration
    lines = [
        f"{' and '.join(_spans(case))}: largest |rotation - Housner's| / slenderness in that time.",
        f"CPU: for {duration:g} s of one lane on one core, one lane a thread.",
    ]
    if any(number(row["rest_time_error_s"], "") != MISSING for row in found):
        lines.append("rest: time of coming to rest less Housner's [s], where both rest in time.")
    if len(lanes) > LANES_APART:
        lines.append("peak: largest rotation / slenderness.")
        lines.append(f"The largest of {len(lanes)} lanes each, those where Housner holds.")
    elif len(lanes) > 1:
        lines.append("; ".join(f"lane {lane}: {name}" for lane, name in lanes.items()))
    for lane, name in lanes.items():
        peaks = {number(row["peak_rotation_ratio"], ".4f") for row in found if row["lane"] == lane}
        if len(peaks) == 1 and len(lanes) <= LANES_APART:
            lines.append(f"Peak rotation / slenderness angle of {name}: {peaks.pop()} in all runs.")
    for line in lines + _where_housner_fails(found):
        out.print(f"  {line}", markup=False, highlight=False)
    out.print()


def print_studies(out: Console, rows: Sequence[Row]) -> None:
    """The studies of shipped cases that are among the rows of a reproduction.

    Args:
        out: Where to.
        rows: Rows; those of a study have the name of its `case`.
    """
    for name in dict.fromkeys(row["case"] for row in rows if row.get("setting") is not None):
        print_study(out, [row for row in rows if row.get("case") == name], load_case(name))


def print_study_run(
    rows: Sequence[Row],
    case: Case,
    wall_time: float,
    files: Sequence[pathlib.Path],
    console: Console | None = None,
) -> None:
    """Prints a study that was run.

    Args:
        rows: Rows of its table.
        case: The case.
        wall_time: Time that it took [s].
        files: Files that were written.
        console: Where to; the terminal if not given.
    """
    out = console or stdout()
    out.print(f"{case.name}: {case.title}", style="bold", highlight=False)
    out.print()
    print_study(out, rows, case)
    out.print(f"wall time: {wall_time:.3g} s", highlight=False)
    for file in files:
        out.print(f"wrote {file}", markup=False, highlight=False, soft_wrap=True)


def setting_name(setting: str, unit: str) -> str:
    """A setting as the case file writes it, with its unit."""
    return setting if unit in ("-", "1/s") else f"{setting} [{unit}]"


def _spans(case: Case) -> list[str]:
    """Times that the errors cover: the early one, where the run is longer, and the run."""
    duration = case.sample_times.duration
    early = [f"{EARLY_TIME:g} s"] if duration > EARLY_TIME else []
    return [*early, f"{duration:g} s"]


def _study_columns(
    rows: Sequence[Row], case: Case
) -> list[tuple[str, Callable[[Mapping[int, Row]], str]]]:
    """Headings of the columns of numbers, and what they say of the rows of one run."""
    errors = ("error_5s_ratio", "error_run_ratio")[-len(_spans(case)) :]
    measures = [(error, span, ".1e") for error, span in zip(errors, _spans(case), strict=True)]
    measures += [("peak_rotation_ratio", "peak", ".4f"), ("rest_time_error_s", "rest", "+.2f")]
    lanes = list(dict.fromkeys(row["lane"] for row in rows))
    apart = len(lanes) <= LANES_APART
    columns = []
    for of in [[lane] for lane in lanes] if apart else [lanes]:
        where = f"\nlane {of[0]}" if apart and len(lanes) > 1 else ""
        for column, heading, form in measures:
            texts = {number(row[column], form) for row in rows if row["lane"] in of}
            same = column == "peak_rotation_ratio" and apart and len(texts) == 1
            if texts != {MISSING} and not same:
                columns.append((heading + where, _largest(column, form, of)))
    return columns


def _largest(column: str, form: str, lanes: Sequence[int]) -> Callable[[Mapping[int, Row]], str]:
    """Text of the largest value of a column among some lanes of a run.

    Of several lanes those count where Housner holds; one alone is shown whatever it is.
    """

    def cell(run: Mapping[int, Row]) -> str:
        held = [lane for lane in lanes if run[lane]["holds"] or len(lanes) == 1]
        values = [run[lane][column] for lane in held]
        known = [value for value in values if number(value, "") != MISSING]
        return number(max(known, key=abs) if known else None, form)

    return cell


def _study_table(rows: Sequence[Row], case: Case) -> Table:
    """The table of one engine."""
    columns = _study_columns(rows, case)
    table = plain_table(
        f"{rows[0]['engine']}: one setting at a time, against Housner",
        ["setting", "value", "step\n[s]", *(heading for heading, _ in columns), "CPU\n[s]"],
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
            f"{value:g}{'*' if one['baseline'] else ' '}",
            number(one["time_step_s"], ".1e"),
            *(cell(run) for _, cell in columns),
            number(one["cpu_s"], ".2g"),
        )
        last = setting
    return table


def _baseline(study: Study, engine: str) -> list[str]:
    """Where an engine's settings stay, and what it has not."""
    plan = study.plan(engine)
    own = ", ".join(f"{row['setting']} {row['baseline']:g}" for row in plan["vary"])
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


def print_times(out: Console, rows: Sequence[Row]) -> None:
    """The paper's run times and ours, a table a scene.

    Args:
        out: Where to.
        rows: Rows of the target `times`.
    """
    scenes = list(dict.fromkeys((row["system"], row["excitation"]) for row in rows))
    table = plain_table(
        "Run times: the paper's wall time, and CPU time of ours on one core",
        [
            *("scene", "ours\nlasts [s]", "program", "paper\n[s]", "one lane\n[s]"),
            *("of 64 lanes,\neach [s]", "steps"),
        ],
        ("scene", "program"),
    )
    for scene in scenes:
        mine = [row for row in rows if (row["system"], row["excitation"]) == scene]
        lasts = next(row["duration_s"] for row in mine if row["duration_s"] is not None)
        for index, row in enumerate(mine):
            name = row["source"].removeprefix("paper-")
            text = f"{scene[0]}, {row['frequency_hz']:g} Hz, {row['amplitude_mm']:g} mm, {scene[1]}"
            table.add_row(
                text if index == 0 else "",
                f"{lasts:g}" if index == 0 else "",
                PAPER_NAMES.get(name, name) if "paper" in row["source"] else name,
                number(row.get("wall_s"), "g"),
                number(row.get("cpu_s"), ".2g"),
                number(row.get("cpu_s_per_lane"), ".2g"),
                number(row.get("step_count"), ".0f"),
                end_section=row is mine[-1],
            )
    print_table(out, table)
    out.print(
        "  Ours at default settings, kernels built; a lane alone leaves most of a pack of lanes "
        "idle.",
        highlight=False,
    )
    lanes = [row for row in rows if (row["system"], row["excitation"]) == ("single", "pulse")]
    slowest = max((row for row in lanes if row.get("cpu_s")), key=lambda row: row["cpu_s"])
    out.print(
        f"  Slowest on the single block's pulse: {slowest['source']}, {slowest['cpu_s']:.2g} s; "
        f"asked of each engine: under {PULSE_BOUND:g} s.",
        highlight=False,
    )
    out.print()
