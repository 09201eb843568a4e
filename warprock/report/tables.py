"""Tables on the terminal: what was reproduced, checked and compared."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from rich import box
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from warprock.report.paper import PAPER_NAMES, READING_NAMES

if TYPE_CHECKING:
    from warprock.checks import CheckRow

Row = Mapping[str, Any]

MISSING = "-"
COMPARED_COLUMNS = (
    ("error_5s_ratio", "max |diff| / slenderness\nfirst 5 s", ".1e"),
    ("error_run_ratio", "\nwhole run", ".1e"),
    ("peak_error", "peak\nerror", "+.2%"),
    ("rest_time_error_s", "rest time\nerror [s]", "+.3f"),
)
"""Column of a comparison with Housner, its heading and its format."""


def stdout() -> Console:
    """The terminal; where there is none, wide enough for every table here."""
    console = Console()
    return console if console.is_terminal else Console(width=130)


def number(value: object, form: str) -> str:
    """A value in a format, or a dash where there is none."""
    return MISSING if value is None or value != value else format(value, form)


def print_reproduction(found: Mapping[str, Any], console: Console | None = None) -> None:
    """Prints what `reproduce.reproduce` returned: tables, errors, conflicts, files.

    Args:
        found: Its return value.
        console: Where to; the terminal if not given.
    """
    out = console or stdout()
    rows: Sequence[Row] = found["rows"]
    shown: set[str] = set()
    for target in dict.fromkeys(row["target"] for row in rows):
        mine = [row for row in rows if row["target"] == target]
        if target == "table6":
            _print_peaks(out, mine)
        elif target == "table7":
            _print_sine_peaks(out, mine)
        kind = _CASE_OF_TARGET[target]
        if kind not in shown:
            shown.add(kind)
            _print_errors(out, mine, f"Engines against Housner, lane by lane ({kind})")
    out.print("[bold]Conflicts in the paper[/bold]")
    for conflict in found["conflicts"]:
        out.print(f"\n[bold]{conflict['item']}. {conflict['title']}.[/bold]", highlight=False)
        out.print(conflict["text"], markup=False, highlight=False)
    out.print()
    for file in found["files"]:
        out.print(f"wrote {file}", markup=False, highlight=False, soft_wrap=True)


_CASE_OF_TARGET = {
    "table6": "sine pulse",
    "table7": "continuous sine",
    "fig4": "free rocking of B0",
    "fig5": "free rocking of B1 to B3",
    "fig7": "sine pulse",
    "fig8": "sine pulse",
    "fig10": "continuous sine",
    "fig11": "continuous sine",
}


def _table(title: str, headings: Iterable[str], left: Iterable[str] = ()) -> Table:
    table = Table(
        title=title, title_justify="left", title_style="bold", box=box.SIMPLE_HEAD, pad_edge=False
    )
    for heading in headings:
        table.add_column(
            escape(heading),
            justify="left" if heading in left else "right",
            overflow="fold",
            no_wrap=heading not in left,
        )
    return table


def _value(
    rows: Sequence[Row], key: tuple[Any, Any], source: str, reading: str, column: str
) -> Any:
    return next(
        (
            row.get(column)
            for row in rows
            if (row["frequency_hz"], row["amplitude_mm"]) == key
            and row["source"] == source
            and row["reading"] == reading
        ),
        None,
    )


def _inputs(rows: Sequence[Row]) -> list[tuple[Any, Any]]:
    return list(dict.fromkeys((row["frequency_hz"], row["amplitude_mm"]) for row in rows))


def _readings(rows: Sequence[Row]) -> list[str]:
    return list(dict.fromkeys(row["reading"] for row in rows if row["source"] == "housner"))


def _print_peaks(out: Console, rows: Sequence[Row]) -> None:
    """Table 6: for each reading our columns, and the paper's beside them."""
    ours = ("housner", "impulse", "oracle")
    table = _table(
        "Table 6: peak rotation / slenderness angle under one cycle of sine",
        [
            "reading",
            "f [Hz]",
            "A [mm]",
            *ours,
            *(f"paper\n{PAPER_NAMES[name]}" for name in PAPER_NAMES),
        ],
        ("reading",),
    )
    for reading in _readings(rows):
        for index, key in enumerate(_inputs(rows)):
            mine = [_value(rows, key, name, reading, "peak_rotation_ratio") for name in ours]
            theirs = [
                _value(rows, key, f"paper-{name}", "as printed", "peak_rotation_ratio")
                for name in PAPER_NAMES
            ]
            table.add_row(
                reading if index == 0 else "",
                f"{key[0]:g}",
                f"{key[1]:g}",
                *(number(value, ".4f") for value in mine),
                *(number(value, ".3f") for value in theirs),
                end_section=index == len(_inputs(rows)) - 1,
            )
    out.print(table)
    _print_readings(out)


def _print_readings(out: Console) -> None:
    for reading, text in READING_NAMES.items():
        out.print(f"  {reading}: {text}", markup=False, highlight=False)
    out.print()


def _print_sine_peaks(out: Console, rows: Sequence[Row]) -> None:
    """Table 7: our maxima, the test they imply, and errors against it beside the printed ones."""
    ours = ("housner", "impulse", "oracle")
    table = _table(
        "Table 7: peak rotation / slenderness angle under 60 s of sine (oracle: its first 5 s), "
        "and errors against\nthe test. The test's maxima are inferred from the printed errors by "
        "two routes, not measured; the paper\nprints errors without their sign.",
        [
            "reading",
            "f [Hz]",
            "A [mm]",
            *ours,
            "test inferred\nanalytical / Bullet",
            "error [%]\nhousner",
            "\nimpulse",
            *(f"paper [%]\n{PAPER_NAMES[name]}" for name in PAPER_NAMES),
        ],
        ("reading",),
    )
    for reading in _readings(rows):
        for index, key in enumerate(_inputs(rows)):
            mine = [_value(rows, key, name, reading, "peak_rotation_ratio") for name in ours]
            routes = [
                _value(rows, key, "inferred-experiment", route, "peak_rotation_ratio")
                for route in ("slip", "displacement")
            ]
            test = 0.5 * (routes[0] + routes[1])
            printed = [
                _value(rows, key, f"paper-{name}", "as printed", "abs_error_pct")
                for name in PAPER_NAMES
            ]
            table.add_row(
                reading if index == 0 else "",
                f"{key[0]:g}",
                f"{key[1]:g}",
                *(number(value, ".4f") for value in mine),
                " / ".join(number(value, ".3f") for value in routes),
                *(number(100.0 * (value / test - 1.0), "+.0f") for value in mine[:2]),
                *("fell" if value is None else f"{value:.0f}" for value in printed),
                end_section=index == len(_inputs(rows)) - 1,
            )
    out.print(table)
    _print_readings(out)


def _lane_text(row: Row) -> str:
    if row.get("block"):
        return f"{row['block']}, from {row['rotation_ratio_start']:g}"
    if row["frequency_hz"] is None:
        return str(row["reading"])
    return f"{row['frequency_hz']:g} Hz, {row['amplitude_mm']:g} mm, {row['reading']}"


def _print_errors(out: Console, rows: Sequence[Row], title: str) -> None:
    """Every engine's errors against Housner, and why Housner does not hold where it does not."""
    headings = ["lane", "engine", *(heading for _, heading, _ in COMPARED_COLUMNS)]
    table = _table(title, [*headings, "Housner holds?"], ("lane", "engine", "Housner holds?"))
    for row in rows:
        if row.get("holds") is None or row["source"] == "housner":
            continue
        table.add_row(
            _lane_text(row),
            row["source"],
            *(number(row[name], form) for name, _, form in COMPARED_COLUMNS),
            "yes" if row["holds"] else f"no: {row['why']}",
        )
    out.print(table)
    out.print()


def print_checks(rows: Sequence[CheckRow], console: Console | None = None) -> None:
    """Prints the rows of `checks.run_checks`, and what failed with its reason.

    Args:
        rows: The rows.
        console: Where to; the terminal if not given.
    """
    out = console or stdout()
    left = ("case", "check", "engine", "lanes", "")
    table = _table("Checks", ["case", "check", "engine", "lanes", "value", "limit", ""], left)
    for row in rows:
        verdict = "[green]ok[/green]" if row.ok else "[bold red]FAILED[/bold red]"
        table.add_row(
            row.case,
            row.name,
            row.engine,
            row.lanes,
            number(row.value, ".2e"),
            number(row.limit, ".2e"),
            verdict,
        )
    out.print(table)
    for row in rows:
        if not row.ok or "left out" in row.note:
            out.print(f"\n{row.case}, {row.engine}, {row.lanes}: {row.note}", markup=False)
            out.print(f"because: {' '.join(row.because.split())}", markup=False)
    failed = sum(not row.ok for row in rows)
    out.print(f"\n{len(rows) - failed} passed, {failed} failed", highlight=False)


def print_comparison(found: Mapping[str, Any], console: Console | None = None) -> None:
    """Prints what `checks.compare` returned, lane by lane, engines under each other.

    Args:
        found: Its return value.
        console: Where to; the terminal if not given.
    """
    out = console or stdout()
    headings = ["lane", "engine", "peak\nratio", "outcome"]
    table = _table(
        f"{found['case']}: engines against Housner",
        [*headings, *(heading for _, heading, _ in COMPARED_COLUMNS), "Housner holds?"],
        ("lane", "engine", "outcome", "Housner holds?"),
    )
    rows: Sequence[Row] = found["rows"]
    for lane in dict.fromkeys(row["lane"] for row in rows):
        for index, row in enumerate(row for row in rows if row["lane"] == lane):
            table.add_row(
                lane if index == 0 else "",
                row["engine"],
                number(row["peak_rotation_ratio"], ".4f"),
                row["outcome"],
                *(number(row[name], form) for name, _, form in COMPARED_COLUMNS),
                "yes" if row["holds"] else f"no: {row['why']}",
            )
    out.print(table)
