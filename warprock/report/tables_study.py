"""The sensitivity study, the run times and the families of programs on the terminal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rich.console import Console

from warprock.report.paper import PAPER_NAMES
from warprock.report.tables import MISSING, number, plain_table

Row = Mapping[str, Any]

FAMILIES = (("bullet", "impulse"), ("vortex", "direct"), ("dem", "dem"))
"""Column of the paper, and our engine of the same family."""
_STUDY_COLUMNS = (
    ("error_5s_ratio", "5 s", ".1e"),
    ("error_run_ratio", "20 s", ".1e"),
    ("rest_time_error_s", "rest", "+.2f"),
)
"""Column of a row of the study, its heading and its format."""
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
    out.print(table)
    out.print("  Default settings, of dem those of Table 5; nothing is fitted.", highlight=False)
    out.print()


def print_study(out: Console, rows: Sequence[Row]) -> None:
    """Errors and cost of every setting, a row each; nothing where there are none.

    Args:
        out: Where to.
        rows: Rows of `fig4`; those with a `knob` are the study's.
    """
    found = [row for row in rows if row.get("knob") is not None]
    if not found:
        return
    columns = [
        (reading, column, f"{text}\n{reading.removeprefix('height-').replace('-', ' ')}", form)
        for reading in dict.fromkeys(row["reading"] for row in found)
        for column, text, form in _STUDY_COLUMNS
        if any(row["reading"] == reading and number(row[column], "") != MISSING for row in found)
    ]
    table = plain_table(
        "Sensitivity study on B0: largest |rotation - Housner's| / slenderness angle",
        [
            *("engine", "knob", "value", "step\n[s]"),
            *(heading for _, _, heading, _ in columns),
            "CPU [s]",
        ],
        ("engine", "knob"),
    )
    groups: dict[tuple[str, str, float], dict[str, Row]] = {}
    for row in found:
        key = (row["source"], row["knob"], row["value"])
        groups.setdefault(key, {})[row["reading"]] = row
    last: tuple[str, str] | None = None
    for (engine, knob, value), cells in groups.items():
        if last is not None and last != (engine, knob):
            table.add_section()
        first = last != (engine, knob)
        last = (engine, knob)
        one = next(iter(cells.values()))
        table.add_row(
            engine if first else "",
            one["knob_title"] if first else "",
            f"{value:g}",
            number(one["time_step_s"], ".1e"),
            *(number(cells[reading][column], form) for reading, column, _, form in columns),
            number(one["cpu_s"], ".2g"),
        )
    out.print(table)
    out.print(
        "  Errors in the first 5 s and in 20 s, B0 5.0 m and 5.5 m high. One knob at a time; the\n"
        "  others stay at 240 frames/s, 200 sub-steps, a margin of 1e-6 m and 10 sweeps;\n"
        "  *: at 20 sub-steps. CPU: for 20 s of one block on one core.\n"
        "  rest: time of coming to rest, less Housner's [s], where both rest within 20 s.\n"
        "  direct solves its contacts exactly and without a margin: it has no such knobs.",
        markup=False,
        highlight=False,
    )
    out.print()


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
    out.print(table)
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
