"""The families of programs and the run times of the paper beside ours, on the terminal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rich.console import Console

from warprock.paper.printed import PAPER_NAMES
from warprock.tables.terminal import number, plain_table, print_table

Row = Mapping[str, Any]


FAMILIES = (("bullet", "impulse"), ("vortex", "direct"), ("dem", "dem"))
"""Column of the paper, and our engine of the same family."""


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
