"""Tables of what was reproduced of the paper: peaks beside the printed ones, errors, conflicts."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

from rich.console import Console

from warprock.findings.digits import cell_of, short_heading
from warprock.paper.printed import PAPER_NAMES, READING_NAMES
from warprock.paper.runs import ENGINES
from warprock.tables.compare import COMPARED_COLUMNS, HOLDS, Reasons
from warprock.tables.terminal import (
    Row,
    number,
    plain_table,
    print_end,
    print_table,
    print_written,
    stdout,
)

Input = tuple[float, float]
"""Frequency [Hz] and amplitude [mm]."""
_Column = Callable[[Input, str], str]


def print_reproduction(
    found: Mapping[str, Any], console: Console | None = None, *, verbose: bool = False
) -> None:
    """Prints what `reproduce.reproduce` returned: tables, errors, conflicts, files.

    Args:
        found: Its return value.
        console: Where to; the terminal if not given.
        verbose: Whether to print what each part took, too.
    """
    out = console or stdout()
    shown: set[str] = set()
    for target, mine in by_target(found["rows"]).items():
        print_target(out, target, mine, shown)
    if found["conflicts"]:
        out.print("Conflicts in the paper", style="bold")
    for conflict in found["conflicts"]:
        out.print(f"\n{conflict['item']}. {conflict['title']}.", style="bold", highlight=False)
        out.print(conflict["text"], highlight=False)
    out.print()
    print_written(found["files"], out)
    if verbose:
        for part, seconds in found["seconds"].items():
            out.print(f"{part}: {seconds:.1f} s", highlight=False)
    conflicts = len(found["conflicts"])
    print_end(
        f"{found['target']} is recomputed beside the paper, {conflicts} "
        f"{'conflict' if conflicts == 1 else 'conflicts'} in it named.",
        "warprock reproduce all" if found["target"] != "all" else "warprock init record",
        out,
    )


def by_target(rows: Sequence[Row]) -> dict[str, list[Row]]:
    """The rows of every target, in their order."""
    found: dict[str, list[Row]] = {}
    for row in rows:
        found.setdefault(row["target"], []).append(row)
    return found


def print_target(out: Console, target: str, rows: Sequence[Row], shown: set[str]) -> None:
    """Prints the tables of one target.

    Args:
        out: Where to.
        target: Its name.
        rows: Its rows.
        shown: Kinds of errors that were printed before, and need not be again; added to.
    """
    from warprock.paper.print_dem import print_dem_study
    from warprock.paper.print_families import print_families, print_times
    from warprock.paper.print_section6 import print_section6
    from warprock.paper.print_space import print_space
    from warprock.tables.study import print_studies

    if target == "table6":
        _print_peaks(out, rows)
        print_families(out, rows)
    elif target == "table7":
        _print_sine_peaks(out, rows)
    elif target == "times":
        print_times(out, rows)
    elif target == "dem":
        print_dem_study(out, rows)
    elif target == "table7-spatial":
        print_space(out, rows)
    kind = _CASE_OF_TARGET.get(target)
    if kind is None:
        print_section6(out, target, rows)
    elif kind not in shown:
        shown.add(kind)
        _print_errors(out, rows, kind)
        print_studies(out, rows)


# Targets on single blocks, whose engines have errors against Housner.
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


def _value(rows: Sequence[Row], key: Input, source: str, reading: str, column: str) -> Any:
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


OURS = (*ENGINES, "oracle")


INPUT_HEADINGS = ("reading", "f\n[Hz]", "A\n[mm]")


def _print_inputs(
    out: Console, title: str, rows: Sequence[Row], columns: Mapping[str, _Column]
) -> None:
    """A table with a row for every reading and input; `columns` turn the two into a text."""
    table = plain_table(title, [*INPUT_HEADINGS, *columns], ("reading",))
    inputs = list(dict.fromkeys((row["frequency_hz"], row["amplitude_mm"]) for row in rows))
    readings = list(dict.fromkeys(row["reading"] for row in rows if row["source"] == "housner"))
    for reading in readings:
        for index, key in enumerate(inputs):
            table.add_row(
                reading if index == 0 else "",
                f"{key[0]:g}",
                f"{key[1]:g}",
                *(column(key, reading) for column in columns.values()),
                end_section=key == inputs[-1],
            )
    print_table(out, table)


def _peak_columns(rows: Sequence[Row], sources: Iterable[str]) -> dict[str, _Column]:
    def column(source: str) -> _Column:
        return lambda key, reading: number(
            _value(rows, key, source, reading, "peak_rotation_ratio"), ".4f"
        )

    return {source: column(source) for source in sources}


def _paper_columns(rows: Sequence[Row], measure: str, form: str) -> dict[str, _Column]:
    def column(name: str) -> _Column:
        return lambda key, _reading: number(
            _value(rows, key, f"paper-{name}", "as printed", measure), form
        )

    headings = {
        name: title.replace("analytical", "analy-\ntical") for name, title in PAPER_NAMES.items()
    }
    return {f"paper\n{heading}": column(name) for name, heading in headings.items()}


def _print_peaks(out: Console, rows: Sequence[Row]) -> None:
    """Table 6: for each reading our columns, and the paper's beside them."""
    title = "Table 6: peak rotation / slenderness angle under one cycle of sine"
    ours = _peak_columns(rows, ("housner", "event", "impulse", "oracle"))
    _print_inputs(out, title, rows, ours | _paper_columns(rows, "peak_rotation_ratio", ".3f"))
    _print_readings(out)
    _print_trust(out, rows)


def _print_trust(out: Console, rows: Sequence[Row]) -> None:
    """Which column of ours to trust, reading by reading, and how far the others are from it."""
    found = [row for row in rows if row["source"] == "event"]
    for reading in dict.fromkeys(row["reading"] for row in found):
        mine = [row for row in found if row["reading"] == reading]
        exact = all(row["holds"] for row in mine)
        trusted, other = ("housner", "event") if exact else ("event", "housner")
        off = max(
            abs(
                _value(rows, key, other, reading, RATIO)
                / _value(rows, key, trusted, reading, RATIO)
                - 1
            )
            for key in ((row["frequency_hz"], row["amplitude_mm"]) for row in mine)
        )
        why = "no block slides" if exact else "blocks slide, which housner leaves out"
        text = f"  trust {trusted} for {reading}: {why}; {other} is within {100.0 * off:.2g} %"
        out.print(text, highlight=False)
    out.print()


RATIO = "peak_rotation_ratio"


def _print_sine_peaks(out: Console, rows: Sequence[Row]) -> None:
    """Table 7: our maxima, the test they imply, and errors against it beside the printed ones."""

    def test(key: Input) -> list[float]:
        return [
            _value(rows, key, "inferred-experiment", reading, "peak_rotation_ratio")
            for reading in ("double-size", "displacement")
        ]

    def error(source: str) -> _Column:
        def cell(key: Input, reading: str) -> str:
            ours = _value(rows, key, source, reading, "peak_rotation_ratio")
            return number(100.0 * (2.0 * ours / sum(test(key)) - 1.0), "+.0f")

        return cell

    _print_inputs(
        out,
        "Table 7: peak rotation / slenderness angle, 60 s of sine (oracle: 5 s).\n"
        "The test is inferred from the paper's errors by two routes, not measured.",
        rows,
        _peak_columns(rows, OURS)
        | {
            "test, by\nanalytical": lambda key, _: number(test(key)[0], ".3f"),
            "test, by\nBullet": lambda key, _: number(test(key)[1], ".3f"),
        },
    )
    _print_readings(out)
    _print_inputs(
        out,
        "Table 7: error [%] of the peak against the inferred test (mean of both\n"
        "routes), and the paper's errors as printed, without sign (-: collapsed)",
        rows,
        {source: error(source) for source in ENGINES}
        | _paper_columns(rows, "abs_error_pct", ".0f"),
    )
    out.print()


def _print_readings(out: Console) -> None:
    for reading, text in READING_NAMES.items():
        out.print(f"  {reading}: {text}", highlight=False)
    out.print()


def _lane_text(row: Row) -> str:
    if row.get("block"):
        return f"{row['block']}, from {row['rotation_ratio_start']:g}"
    if row["frequency_hz"] is None:
        return str(row["reading"])
    return f"{row['frequency_hz']:g} Hz, {row['amplitude_mm']:g} mm, {row['reading']}"


def _print_errors(out: Console, rows: Sequence[Row], kind: str) -> None:
    """The contact engine's errors against Housner, and where Housner does not hold."""
    table = plain_table(
        f"impulse against Housner, lane by lane: {kind}",
        ["lane", *map(short_heading, COMPARED_COLUMNS), HOLDS],
        ("lane", HOLDS),
    )
    letters = Reasons()
    for row in rows:
        if row["source"] == "impulse" and row.get("setting") is None:
            numbers = (cell_of(name, row[name]) for name in COMPARED_COLUMNS)
            table.add_row(_lane_text(row), *numbers, letters.cell(row))
    print_table(out, table)
    letters.print(out)
