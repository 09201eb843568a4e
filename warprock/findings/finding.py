"""A finding: what an analysis came to, told once, for the terminal, a page, figures and Python."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

from warprock.case.columns import Columns, Table
from warprock.findings.sheets import Sheet

if TYPE_CHECKING:
    import pandas as pd

Facts = Mapping[str, Any]
Tables: TypeAlias = "Mapping[str, pd.DataFrame]"


@dataclasses.dataclass(frozen=True)
class Finding:
    """What an analysis came to.

    It is made of facts and tables alone, as they are written: a page of a folder of results tells
    the same as the command that wrote them.

    Attributes:
        kind: What it is, in a word or two: `Overturning map`.
        facts: What `run.json` holds; empty writes none.
        tables: Tables to write, by name; see `running.results.write_results`.
        sentences: What came out. The first, the most important one, ends the print-out and stands
            above the figure.
        sheets: Tables to read; the terminal leaves out those that are folded on a page.
        rows: Key of what `--json` prints -> the table whose rows it has.
        said: What `--json` prints besides; None prints the facts.
        asked: What was asked besides what all analyses ask: names and texts.
        pictures: Patterns of the names of its figures.
        texts: Texts to write, by the name of their file.
        title: What it is about, where that is no case.
        stays: Whether its files stay whatever a later command writes to the folder.
        beside: Whether it was made from the results in a folder, which stay when it is written.
        then: The command to try next, once the results are in a folder.
        show: Prints its tables on the terminal; None prints those of its sheets that are open.
    """

    kind: str
    facts: Facts
    tables: Mapping[str, Table]
    sentences: Sequence[str]
    sheets: Sequence[Sheet] = ()
    rows: Mapping[str, str] = dataclasses.field(default_factory=dict)
    said: Facts | None = None
    asked: Sequence[tuple[str, str]] = ()
    pictures: Sequence[str] = ()
    texts: Mapping[str, str] = dataclasses.field(default_factory=dict)
    title: str = ""
    stays: bool = False
    beside: bool = False
    then: str = ""
    show: Callable[[], None] | None = None

    @property
    def json(self) -> dict[str, Any]:
        """What `--json` prints, but for the files that were written."""
        rows = {key: _records(self.tables[name]) for key, name in self.rows.items()}
        return {**(self.facts if self.said is None else self.said), **rows}

    @property
    def frames(self) -> Mapping[str, pd.DataFrame]:
        """Its tables as DataFrames, by the name of their file."""
        return {
            name: table.frame if isinstance(table, Columns) else table
            for name, table in self.tables.items()
        }

    @property
    def headline(self) -> str:
        """The first sentence as a title: without its full stop."""
        return self.sentences[0].removesuffix(".")


def _records(table: Table) -> list[dict[str, Any]]:
    """The rows of a table, each a value by the name of the column."""
    if isinstance(table, Columns):
        return table.records
    return [{str(name): value for name, value in row.items()} for row in table.to_dict("records")]


class Kind(NamedTuple):
    """A kind of findings, as a page of a folder finds it.

    Attributes:
        tables: Names of the tables that it is told from, without the ending .parquet.
        tell: Makes the finding of facts and tables.
        key: What only findings of this kind say in `run.json`, by which they are known; empty where
            they are known by a file.
        shape: What they say there besides what all say, a shape of `running.run_file`.
        file: The file by which they are known, which may lie beside other results.
    """

    tables: Sequence[str]
    tell: Callable[[Facts, Tables], Finding]
    key: str = ""
    shape: Facts = MappingProxyType({})
    file: str = ""
