"""The study of the distinct-element springs on the terminal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rich.console import Console

from warprock.tables.terminal import number, plain_table, print_table

Row = Mapping[str, Any]


def print_dem_study(out: Console, rows: Sequence[Row]) -> None:
    """Peaks of every variant of the springs, and how far the worst is from paper and Housner.

    Args:
        out: Where to.
        rows: Those of `reproduce dem`.
    """
    inputs = list(dict.fromkeys((row["frequency_hz"], row["amplitude_mm"]) for row in rows))
    table = plain_table(
        "dem on Table 6, displacement drive: largest rotation / slenderness angle",
        [
            *("springs", "value", "steps\na second"),
            *(f"{f:g} Hz\n{a:g} mm" for f, a in inputs),
            *("worst off\nthe DEM\n[%]", "worst off\nHousner\n[%]", "restitu-\ntion"),
        ],
        ("springs",),
    )
    variants = dict.fromkeys((row["knob"], row["value"]) for row in rows)
    last = None
    for knob, value in variants:
        mine = [row for row in rows if (row["knob"], row["value"]) == (knob, value)]
        if last is not None and last != knob:
            table.add_section()
        table.add_row(
            "" if knob == last else knob,
            number(value, "g"),
            number(mine[0]["steps_per_s"], ".0f"),
            *(number(row["peak_rotation_ratio"], ".4f") for row in mine),
            *(
                number(100.0 * max((row[off] for row in mine), key=abs), "+.1f")
                for off in ("paper_off", "housner_off")
            ),
            number(mine[0]["restitution"], ".3f"),
        )
        last = knob
    print_table(out, table)
    out.print(
        "  Table 5: five sub-contacts, 1e9 N/m^3, beta 2.25e-4 s, friction 1; the others differ\n"
        "  in what is named. The last two have friction 5: the velocity step does not slide them.",
        highlight=False,
    )
    out.print(
        "  restitution: angular velocity kept at the first impact, let go from half of the\n"
        f"  slenderness angle; Housner's is {rows[0]['housner_restitution']:.3f}.",
        highlight=False,
    )
    out.print()
