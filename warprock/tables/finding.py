"""A finding on the terminal: its tables, and what came out in sentences."""

from __future__ import annotations

import textwrap

from rich.console import Console

from warprock.findings.finding import Finding
from warprock.findings.sheets import Sheet
from warprock.tables.terminal import plain_table, print_table, say, stdout

LEAST = 8
"""Letters of a heading that are not broken."""


def print_finding(finding: Finding, console: Console | None = None) -> None:
    """Prints a finding but for its first sentence, which `print_end` says.

    Args:
        finding: The finding.
        console: Where to; the terminal if not given.
    """
    out = console or stdout()
    if finding.show is None:
        _print_sheets(finding, out)
    else:
        finding.show()
    for sentence in finding.sentences[1:]:
        say(out, sentence)


def _print_sheets(finding: Finding, out: Console) -> None:
    case, engine = finding.facts.get("case"), finding.facts.get("engine")
    name = engine["name"] if isinstance(engine, dict) else engine
    about = ", ".join(filter(None, (case["name"] if case else "", name)))
    out.print(": ".join(filter(None, (finding.kind, about))), style="bold", highlight=False)
    for sheet in finding.sheets:
        if not sheet.folded:
            print_sheet(sheet, out)


def print_sheet(sheet: Sheet, out: Console) -> None:
    """Prints a table and its note.

    Args:
        sheet: The table.
        out: Where to.
    """
    texts = sheet.texts
    heads = []
    for number, heading in enumerate(sheet.headings):
        name = heading.label
        widest = max([LEAST, *(len(row[number]) for row in sheet.rows)])
        longest = max([widest, *map(len, name.split())])
        lines = textwrap.wrap(name, longest, break_long_words=False)
        heads.append("\n".join(lines))
    left = [head for head, words in zip(heads, texts, strict=True) if words]
    table = plain_table(sheet.title, heads, left)
    for row in sheet.rows:
        table.add_row(*row)
    print_table(out, table)
    if sheet.note:
        say(out, f"  {sheet.note}")
