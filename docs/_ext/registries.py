"""Tables of the manual that are read from the program: columns, outcomes, statuses, exit codes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from warprock.case.input_columns import INPUTS
from warprock.model.response import FIELDS, HISTORIES
from warprock.model.words import OUTCOMES, STATUSES


def _columns_of_results() -> list[tuple[str, ...]]:
    rows = [("column", "unit", "of", "meaning")]
    for name, field in FIELDS.items():
        if name not in HISTORIES:
            unit = "" if field.unit == "-" else f"_{field.unit}"
            of = "block" if field.per_block else "lane"
            space = "; in space only" if field.spatial else ""
            rows.append((f"`{name}{unit}`", field.unit, of, f"{field.text}{space}"))
    return rows


def _columns_of_inputs() -> list[tuple[str, ...]]:
    rows = [("column", "unit", "meaning")]
    rows += [(f"`{name}`", column.unit or "-", column.text) for name, column in INPUTS.items()]
    return rows


def _outcomes() -> list[tuple[str, ...]]:
    rows = [("outcome", "what has become of the lane")]
    return [*rows, *((f"`{each.name.lower()}`", text) for each, text in OUTCOMES.items())]


def _statuses() -> list[tuple[str, ...]]:
    rows = [("status", "what the numbers of the lane are")]
    return [*rows, *((f"`{each.name.lower()}`", text) for each, text in STATUSES.items())]


REGISTRIES: dict[str, Callable[[], list[tuple[str, ...]]]] = {
    "columns-of-results": _columns_of_results,
    "columns-of-inputs": _columns_of_inputs,
    "outcomes": _outcomes,
    "statuses": _statuses,
}
"""Name of a table -> what makes its rows, the head first."""


class Registry(SphinxDirective):
    """A table of the program, by its name."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        """Nodes of the table."""
        head, *rows = REGISTRIES[self.arguments[0]]()
        lines = [head, ["---"] * len(head), *rows]
        text = "\n".join("| " + " | ".join(row) + " |" for row in lines)
        return self.parse_text_to_nodes(text)


def setup(app: Sphinx) -> dict[str, Any]:
    """Adds the directive to Sphinx."""
    app.add_directive("registry", Registry)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
