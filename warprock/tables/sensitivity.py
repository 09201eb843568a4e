"""Sobol' indices: on the terminal, as JSON and as files."""

from __future__ import annotations

from typing import Any

from rich.console import Console

from warprock.analysis.sensitivity import Sensitivity
from warprock.model.words import lane_count_text
from warprock.running.provenance import provenance
from warprock.tables.accuracy import run_accuracy_lines
from warprock.tables.report import Report
from warprock.tables.terminal import number, plain_table, print_table, stdout

_MEANINGS = {
    "group": "Labels of the case",
    "input": "Key of the case that is drawn",
    "first_order": "Share of the variance that goes when the input alone is known",
    "total": "Share of the variance that stays when all other inputs are known",
}


def sensitivity_facts(found: Sensitivity) -> dict[str, Any]:
    """What ran and what came of it, ready for JSON."""
    return provenance(found.run) | {"of": found.of, "groups": found.groups.to_dict("records")}


def sensitivity_report(found: Sensitivity) -> Report:
    """What indices have to show; their files are the indices, and what ran."""
    table, facts = found.rows.copy(), sensitivity_facts(found)
    table.attrs["columns"] = {
        name: {"unit": "-", "text": _text(str(name))} for name in table.columns
    }
    return Report(
        json={**facts, "rows": table.to_dict("records")},
        tables={"sensitivity": table},
        facts=facts,
        show=lambda: print_sensitivity(found),
        came_out=_sentence(found),
    )


def _sentence(found: Sensitivity) -> str:
    """The input that matters most."""
    known = found.rows[found.rows["total"].notna()]
    if known.empty:
        return f"Nothing explains {found.of}: it does not vary."
    most = known.sort_values("total", ascending=False).iloc[0]
    return (
        f"{most['input']} matters most to {found.of}: alone it explains "
        f"{100.0 * most['first_order']:.3g} % of the variance, with its interactions "
        f"{100.0 * most['total']:.3g} %."
    )


def _text(column: str) -> str:
    if column in _MEANINGS:
        return _MEANINGS[column]
    name, percentile = column.rsplit("_p", 1)
    return f"{_MEANINGS[name]}; percentile {int(percentile)} over resampled rows of the design"


def print_sensitivity(found: Sensitivity, console: Console | None = None) -> None:
    """Prints the indices, the most important input first.

    Args:
        found: The indices.
        console: Where to; the terminal if not given.
    """
    out = console or stdout()
    for _, group in found.groups.iterrows():
        name = f", {group['group']}" if group["group"] else ""
        title = f"{found.run.case.name}, {found.run.response.engine}{name}"
        title += f": Sobol' indices of {found.of}"
        table = plain_table(title, ["input", "first order", "total"], ["input"])
        mine = found.rows[found.rows["group"] == group["group"]]
        for _, row in mine.sort_values("total", ascending=False, kind="stable").iterrows():
            cells = [
                f"{number(row[index], '.3f')} "
                f"[{number(row[f'{index}_p05'], '.3f')}, {number(row[f'{index}_p95'], '.3f')}]"
                for index in ("first_order", "total")
            ]
            table.add_row(row["input"], *cells)
        print_table(out, table)
        fell = f", {group['overturned']:,} overturned" if group["overturned"] else ""
        if group["censored"]:
            fell += f" ({group['censored']:,} that fell or went beyond balance count as 1)"
        out.print(
            f"  {lane_count_text(group['lanes'])}{fell}; mean {group['mean']:.4g}, standard "
            f"deviation "
            f"{group['standard_deviation']:.4g}",
            highlight=False,
        )
    out.print("  in brackets: 5th and 95th percentile over resampled rows of the design")
    for line in run_accuracy_lines(found.run):
        out.print(line, highlight=False, soft_wrap=True)
