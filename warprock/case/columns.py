"""A table as columns of NumPy; a DataFrame is made of it when one is asked for.

Whoever only counts and prints waits for no pandas.
"""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import numpy.typing as npt

from warprock.case.axes import Texts

if TYPE_CHECKING:
    import pandas as pd


Table: TypeAlias = "pd.DataFrame | Columns"
"""A table, read from a file or just made."""


class Meanings(dict[str, dict[str, str]]):
    """Unit and meaning of each column, by its name.

    pandas copies `DataFrame.attrs` to the bottom for every table and column that it makes of one:
    of the hundreds of columns of a run that took longer than what was asked for.
    """

    def __deepcopy__(self, memo: object) -> Meanings:
        return Meanings(self)


@dataclasses.dataclass(frozen=True)
class Columns:
    """Columns of one length by name.

    It gives names, rows and columns as a DataFrame does: `for name in table`, `name in table`,
    `len(table)`, `table[name]`, `table.head(n)`.

    Attributes:
        columns: An array of numbers, a list of texts, or `Texts` by the name of the column, each of
            shape [row].
        attrs: What is said of the table, as `DataFrame.attrs` has it.
    """

    columns: Mapping[str, Any]
    attrs: dict[str, Any] = dataclasses.field(default_factory=dict)

    @classmethod
    def of(cls, rows: Sequence[Mapping[str, Any]]) -> Columns:
        """A table of rows, each a value by the name of the column."""
        names = dict.fromkeys(name for row in rows for name in row)
        return cls({name: [row.get(name) for row in rows] for name in names})

    def __iter__(self) -> Iterator[str]:
        return iter(self.columns)

    def __contains__(self, name: object) -> bool:
        return name in self.columns

    def __len__(self) -> int:
        first = next(iter(self.columns.values()), ())
        return len(first.codes if isinstance(first, Texts) else first)

    def __getitem__(self, name: str) -> npt.NDArray[Any]:
        """A column as an array, texts as objects, shape [row]."""
        column = self.columns[name]
        if isinstance(column, Texts):
            return np.array(column.values, dtype=object)[column.codes]
        return np.asarray(column, dtype=object if isinstance(column, list) else None)

    def take(self, chosen: npt.NDArray[np.intp]) -> Columns:
        """Some rows, in any order and as often as they are named."""
        return Columns(
            {
                name: Texts(column.values, column.codes[chosen])
                if isinstance(column, Texts)
                else self[name][chosen]
                for name, column in self.columns.items()
            },
            self.attrs,
        )

    def head(self, count: int) -> Columns:
        """The first rows."""
        return self.take(np.arange(min(count, len(self))))

    def among(self, name: str, values: Sequence[object]) -> npt.NDArray[np.bool_]:
        """Whether a column has one of some values, shape [row]."""
        column = self.columns[name]
        if not isinstance(column, Texts):
            return np.array([value in values for value in self[name].tolist()], dtype=bool)
        known = np.array([text in values for text in column.values], dtype=bool)
        return np.asarray(known[column.codes])

    def distinct(self, name: str) -> list[Any]:
        """Values of a column, each once, in order of their first appearance."""
        column = self.columns[name]
        values = column.codes if isinstance(column, Texts) else column
        _, first = np.unique(values, return_index=True)
        found = values[np.sort(first)].tolist()
        return [column.values[code] for code in found] if isinstance(column, Texts) else found

    @property
    def records(self) -> list[dict[str, Any]]:
        """Its rows, each a value by the name of the column."""
        rows = zip(*(self[name].tolist() for name in self), strict=True)
        return [dict(zip(self, row, strict=True)) for row in rows]

    @functools.cached_property
    def frame(self) -> pd.DataFrame:
        """The table as a DataFrame, `Texts` as categories."""
        import pandas as pd

        table = pd.DataFrame(
            {
                name: pd.Categorical.from_codes(column.codes, pd.Index(column.values))
                if isinstance(column, Texts)
                else column
                for name, column in self.columns.items()
            }
        )
        table.attrs.update(self.attrs)
        return table
