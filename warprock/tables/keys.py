"""The keys of a case file on the terminal: two lines each."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

from warprock.case.reference import Section, facts
from warprock.tables.terminal import stdout


def print_keys(found: Sequence[Section]) -> None:
    """Prints tables of a case file: of each key what it may hold, and what it means."""
    out = stdout()
    for section in found:
        out.print(f"{section.title}  {section.text}", style="bold", highlight=False)
        width = max(len(row.key) for row in section.keys) + 4
        lines = []
        for row in section.keys:
            unit = "" if row.unit == "-" else f" [{row.unit}]"
            text = f"{row.text}{unit}; {facts(row)}"
            broken = textwrap.wrap(text, max(40, out.width - width - 1))
            names = (f"  {row.key}", *("" for _ in broken))
            lines += [f"{name:<{width}}{line}\n" for name, line in zip(names, broken, strict=False)]
        # A call a table: Rich takes longer for the call than for the lines.
        out.print("".join(lines), highlight=False, soft_wrap=True)
