"""Tables 9 to 12 of the paper and the collapse of the stack, on the terminal."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from rich.console import Console

from warprock.paper.printed import GEOMETRIES, PAPER_NAMES, REFERENCE_DEGREES
from warprock.tables.terminal import number, plain_table, print_table

Row = Mapping[str, Any]
Input = tuple[float, float]
"""Frequency [Hz] and amplitude [mm]."""

TITLES = {
    "table9": "Table 9: top block, one cycle of sine",
    "table10": "Table 10: bottom block, one cycle of sine",
    "table11": "Table 11: top block, 10 s of sine",
    "table12": "Table 12: bottom block, 10 s of sine",
}
ANALYTICAL = ("two-block", "acceleration", "equal-depths")
OURS = (
    ("event\nprinted", ("event", "displacement", "printed")),
    ("event\nlow-top", ("event", "displacement", "low-top")),
    ("impulse\nlow-top", ("impulse", "displacement", "low-top")),
    ("dem\nlow-top", ("dem", "displacement", "low-top")),
)
"""Heading, then source, reading and geometry of a column, with chamfers."""
ENSEMBLE = "event-ensemble"
CONTACT = ("bullet", "vortex", "dem")
NOTES = (
    "two-block: acceleration drive, equal depths, no sliding. The others: displacement drive, "
    "friction 1. All with 5 mm chamfers. dem: springs of Table 5.",
    "printed: top block 0.60 m high, depths 0.40 m (bottom) and 0.55 m (top).",
    "low-top: top block 0.55 m high, depths equal.",
)


class _Found:
    """Rows of one target by input, source, reading and geometry."""

    def __init__(self, rows: Iterable[Row]) -> None:
        self.rows = [row for row in rows if row["edges"] != "sharp"]
        self.inputs = list(dict.fromkeys(_key(row) for row in self.rows))

    def row(self, key: Input, source: str, reading: str, geometry: str | None) -> Row | None:
        """The row, if there is one."""
        return next(
            (
                row
                for row in self.rows
                if (_key(row), row["source"], row["reading"], row["geometry"])
                == (key, source, reading, geometry)
            ),
            None,
        )

    def peak(self, key: Input, source: str, reading: str, geometry: str | None) -> str:
        """A peak as the tables show it."""
        row = self.row(key, source, reading, geometry)
        return number(row and row["peak_rotation_ratio"], ".3f")

    def distribution(self, key: Input, geometry: str) -> str:
        """Median and range of an ensemble."""
        row = self.row(key, ENSEMBLE, "displacement", geometry)
        if row is None:
            return number(None, "")
        text = "{} ({} to {})".format(
            *(_ratio(row[n]) for n in ("peak_rotation_ratio", "low_5", "high_95"))
        )
        share = row["collapsed_share"]
        return f"{text}, {100 * share:.1f} % fall" if share else text

    def find_printed(self, key: Input, column: str) -> Row:
        """The row of a printed number."""
        row = self.row(key, f"paper-{column}", "as printed", None)
        assert row is not None
        return row


def _key(row: Row) -> Input:
    return row["frequency_hz"], row["amplitude_mm"]


def _ratio(value: Any) -> str:
    return "fell" if value is None else format(value, ".3f")


def _places(rows: Iterable[Row], geometry: str) -> str:
    return "  ".join(f"{number(row.get(f'percentile_{geometry}'), '.0f'):>3}" for row in rows)


def print_section6(out: Console, target: str, rows: Sequence[Row]) -> None:
    """Prints the rows of a target on stacks; those of a figure are in its CSV file only."""
    if target in ("table9", "table10"):
        _print_pulse(out, target, _Found(rows))
    elif target in ("table11", "table12"):
        _print_sine(out, target, _Found(rows))
    elif target == "collapse":
        _print_collapse(out, rows)


def _print_pulse(out: Console, target: str, found: _Found) -> None:
    table = plain_table(
        f"{TITLES[target]}: largest rotation / {REFERENCE_DEGREES} deg",
        [
            *("f\n[Hz]", "A\n[mm]", "paper\nanalytical", "two-block"),
            *(f"paper\n{PAPER_NAMES[name]}" for name in CONTACT),
            *(heading for heading, _ in OURS),
        ],
    )
    for key in found.inputs:
        table.add_row(
            *(f"{value:g}" for value in key),
            number(found.find_printed(key, "analytical")["peak_rotation_ratio"], ".3f"),
            found.peak(key, *ANALYTICAL),
            *(number(found.find_printed(key, n)["peak_rotation_ratio"], ".3f") for n in CONTACT),
            *(found.peak(key, *which) for _, which in OURS),
        )
    print_table(out, table)
    numbers = {key: [found.find_printed(key, name) for name in CONTACT] for key in found.inputs}
    _print_ensembles(out, found, "percentile of\nBullet, Vortex, DEM", numbers)


def _print_sine(out: Console, target: str, found: _Found) -> None:
    table = plain_table(
        f"{TITLES[target]}: largest rotation / {REFERENCE_DEGREES} deg. The test is inferred from "
        "the paper's\nerrors, which have no sign, by its analytical and by its Bullet column",
        [
            *("f\n[Hz]", "A\n[mm]"),
            *(f"{title}\nerror [%]" for title in PAPER_NAMES.values()),
            "two-block",
            *(heading for heading, _ in OURS),
            *("test, by\nanalytical", "test, by\nBullet"),
        ],
    )
    tests = {
        key: [r for r in found.rows if r["source"] == "inferred-experiment" and _key(r) == key]
        for key in found.inputs
    }
    for key in found.inputs:
        table.add_row(
            *(f"{value:g}" for value in key),
            *(_error(found.find_printed(key, name)) for name in PAPER_NAMES),
            found.peak(key, *ANALYTICAL),
            *(found.peak(key, *which) for _, which in OURS),
            *(_test(row) for row in tests[key]),
        )
    print_table(out, table)
    _print_ensembles(out, found, "percentile of\nboth tests", tests)


def _print_ensembles(
    out: Console, found: _Found, heading: str, numbers: Mapping[Input, Sequence[Row]]
) -> None:
    """The ensembles, and where in them the numbers of each input fall."""
    table = plain_table(
        "Ensembles of event: median (5 % to 95 %) of small differences in sizes, chamfers, "
        "placing, friction",
        ["f\n[Hz]", "A\n[mm]"]
        + [text for geometry in GEOMETRIES for text in (f"geometry\n{geometry}", heading)],
    )
    for key in found.inputs:
        table.add_row(
            *(f"{value:g}" for value in key),
            *(
                text
                for geometry in GEOMETRIES
                for text in (found.distribution(key, geometry), _places(numbers[key], geometry))
            ),
        )
    print_table(out, table)
    members = max(row.get("members") or 0 for row in found.rows)
    out.print(f"  {members_text(members)}", highlight=False)
    for note in NOTES:
        out.print(f"  {note}", highlight=False)
    out.print()


def members_text(members: int) -> str:
    """How many members an ensemble has, and how well its quantiles are known."""
    middle, end = (100.0 * math.sqrt(p * (1.0 - p) / members) for p in (0.5, 0.05))
    return (
        f"{members} members each: the median is that of all such stacks within {middle:.1f} points "
        f"of percentile (standard error), the ends at 5 and 95 % within {end:.1f}."
    )


def _error(row: Row) -> str:
    if row.get("why") == "printed as collapsed":
        return "fell"
    return number(row["abs_error_pct"], ".0f")


def _test(row: Row) -> str:
    fell = str(row.get("why", "")).startswith("90 deg")
    return "fell" if fell else number(row["peak_rotation_ratio"], ".3f")


def _print_collapse(out: Console, rows: Sequence[Row]) -> None:
    """Shares of collapses, a row a friction and input, a column a chamfer."""
    rows = [row for row in rows if row["block"] == "top"]
    chamfers = list(dict.fromkeys(row["chamfer_mm"] for row in rows))
    cells = {
        (*_key(row), row["amplitude"], row["friction"], row["chamfer_mm"]): row for row in rows
    }
    table = plain_table(
        "Share of members in which the stack collapses within 10 s of sine, geometry printed",
        [
            *("f\n[Hz]", "A\n[mm]", "amplitude", "friction"),
            *(f"chamfer\n{chamfer:g} mm" for chamfer in chamfers),
        ],
        ("amplitude",),
    )
    last = None
    for place in dict.fromkeys(cell[:4] for cell in sorted(cells, key=lambda c: (c[0], c[1]))):
        if last is not None and place[:2] != last:
            table.add_section()
        last = place[:2]
        table.add_row(
            *(f"{value:g}" for value in place[:2]),
            place[2],
            f"{place[3]:g}",
            *(_share(cells[(*place, chamfer)]) for chamfer in chamfers),
        )
    print_table(out, table)
    members = max(row["members"] for row in rows)
    out.print(f"  {members} members a cell; in brackets the 95 % interval.", highlight=False)
    out.print()


def _share(row: Row) -> str:
    if row["collapsed_share"] is None:
        return number(None, "")
    low, high = (f"{100 * row[name]:.0f}" for name in ("collapsed_low", "collapsed_high"))
    return f"{100 * row['collapsed_share']:.0f} % ({low} to {high})"
