"""Rocking spectra: on the terminal, as JSON and as files."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
from rich.console import Console

from warprock.analysis.spectrum import Spectrum
from warprock.model.response import USABLE, Outcome
from warprock.model.undecided import UNDECIDED
from warprock.model.words import lane_count_text
from warprock.running.lane_table import lane_table
from warprock.running.provenance import provenance
from warprock.tables.accuracy import run_accuracy_lines
from warprock.tables.report import Report
from warprock.tables.terminal import number, plain_table, print_table, say, stdout

PERIODS_SHOWN = 16
"""Periods that are printed, an even selection."""
FELL, NOTHING = "fell", "-"


def spectrum_table(found: Spectrum) -> pd.DataFrame:
    """The lane table, with `period_s`, 2 pi / p."""
    table = lane_table(found.run.lane_set, found.run.response)
    named = table.assign(period_s=found.period)
    meaning = {"unit": "s", "text": "2 pi / frequency parameter"}
    named.attrs["columns"] = table.attrs["columns"] | {"period_s": meaning}
    return named


def spectrum_facts(found: Spectrum) -> dict[str, Any]:
    """What ran and what came of it, ready for JSON."""
    return provenance(found.run) | {"groups": list(found.groups), "curves": list(found.curves)}


def spectrum_report(found: Spectrum) -> Report:
    """What spectra have to show; their files are every lane, and what ran."""
    table, facts = spectrum_table(found), spectrum_facts(found)
    return Report(
        json={**facts, "rows": table.to_dict("records")},
        tables={"spectrum": table},
        facts=facts,
        show=lambda: print_spectrum(found),
        came_out=_sentence(found),
    )


def _sentence(found: Spectrum) -> str:
    """The largest block that fell, and how many did."""
    fell = found.run.response["outcome"] == Outcome.OVERTURNED
    if not fell.any():
        return f"None of the {len(fell):,} blocks falls."
    most = float(np.max(found.period[fell]))
    return (
        f"{int(fell.sum()):,} of {len(fell):,} blocks fall; the largest of them has 2 pi / p = "
        f"{most:.3g} s."
    )


def print_spectrum(found: Spectrum, console: Console | None = None) -> None:
    """Prints the curves beside one another, at an even selection of the periods.

    Args:
        found: The spectra.
        console: Where to; the terminal if not given.
    """
    out = console or stdout()
    periods, usable = found.period, np.isin(found.run.response["status"], USABLE)
    fell = found.run.response["outcome"] == Outcome.OVERTURNED
    ratio = found.ratio
    for group, lanes in zip(found.groups, found.lanes, strict=True):
        title = "Peak rotation / slenderness angle" + (f", {group}" if group else "")
        table = plain_table(
            f"{found.run.case.name}, {found.run.response.engine}: {title}", ["2 pi / p [s]"]
        )
        for curve in found.curves:
            table.add_column(curve, justify="right")
        last = lanes.shape[1] - 1
        for place in np.unique(np.linspace(0, last, min(PERIODS_SHOWN, last + 1)).astype(int)):
            cells = []
            for lane in lanes[:, place]:
                cell = FELL if fell[lane] else number(ratio[lane], ".4f")
                cells.append(cell if usable[lane] else NOTHING)
            table.add_row(f"{periods[lanes[0, place]]:.3g}", *cells)
        print_table(out, table)
        if last + 1 > PERIODS_SHOWN:
            say(out, f"  {PERIODS_SHOWN} of {last + 1} periods; all are in spectrum.csv of -o DIR")
    facts = spectrum_facts(found)
    counts = ", ".join(f"{count:,} {word}" for word, count in facts["outcome"].items() if count)
    lanes = lane_count_text(len(periods))
    out.print(f"{lanes}: {counts}; {found.run.wall_time:.1f} s", highlight=False)
    if facts[UNDECIDED]:
        out.print(
            f"undecided: {facts[UNDECIDED]:,} lanes in which the block had not fallen by the end "
            f"of the run, {facts['duration_s']:g} s, but still moved or was still shaken",
            highlight=False,
        )
    for line in run_accuracy_lines(found.run):
        out.print(line, highlight=False, soft_wrap=True)
