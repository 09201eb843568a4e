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
        for row in section.keys:
            unit = "" if row.unit == "-" else f" [{row.unit}]"
            text = f"{row.text}{unit}; {facts(row)}"
            lines = textwrap.wrap(text, max(40, out.width - width - 1))
            for name, line in zip([f"  {row.key}", *([""] * len(lines))], lines, strict=False):
                out.print(f"{name:<{width}}{line}", highlight=False, soft_wrap=True)
        out.print()
